//! What the panels of both benches say of the claims.

use piezotact::figure::Line;
use piezotact::panel::{
    FallsWithLoad, LoadStep, Panel, PanelAnalysis, PanelConfig, PanelError, analyse,
};
use piezotact::quantity::{Band, Hertz};
use piezotact::transfer::{BundleAverage, Ensemble};

use super::{ANGLES_DEG, Device, Fingers, Inertance, LOADS_N, cell, drawn, levels};
use crate::ReplayError;
use crate::claims::{
    Finding, Holds, above, alone, at_least, at_most, below, in_report_only, least, most,
    no_exception,
};
use crate::figure::{Counterpart, frequency, line, linear, names, over_steps};

/// The band of the thesis' figures, Hz.
const BAND_HZ: [f64; 2] = [20.0, 1000.0];

/// Both panels, analysed.
pub(super) struct Panels {
    pub(super) fingers: PanelAnalysis,
    pub(super) devices: PanelAnalysis,
    /// Averages over people: fingers at each load, and the device at 20° and 0.2 N.
    finger_averages: Vec<Inertance>,
    device_average: Device,
    /// Everybody on the device at 20° and 0.2 N.
    light: Vec<Device>,
}

impl Panels {
    pub(super) fn of(
        fingers: &Fingers,
        devices: &Panel<piezotact::quantity::Drive, piezotact::quantity::Acceleration>,
        seed: u64,
    ) -> Result<Self, ReplayError> {
        let band = Band::new(Hertz(BAND_HZ[0]), Hertz(BAND_HZ[1]))?;
        let config = PanelConfig::usual(band, seed);
        let log = BundleAverage::LogMagnitude;
        let light = cell(LOADS_N[0], ANGLES_DEG[0]);
        let average_at = |load_n: f64| {
            let at = cell(load_n, ANGLES_DEG[0]);
            piezotact::panel::average_of_panel(fingers, at, log, band)
                .map(|average| average.function)
        };
        Ok(Self {
            fingers: analyse(fingers, &config)?,
            devices: analyse(devices, &config)?,
            finger_averages: LOADS_N
                .into_iter()
                .map(average_at)
                .collect::<Result<_, PanelError>>()?,
            device_average: piezotact::panel::average_of_panel(devices, light, log, band)?.function,
            light: devices
                .participants()
                .iter()
                .filter_map(|who| devices.person(who, light, log).transpose())
                .collect::<Result<_, _>>()?,
        })
    }

    pub(super) fn all_together(&self) -> Finding {
        let all = &self.fingers.all;
        let (deviation, hz) = (all.max_deviation_db, all.max_deviation_at_hz);
        Finding::of(
            1,
            Holds::all([
                at_least(deviation, 6.0, "dB", "the deviation is below 6 dB"),
                at_most(
                    deviation,
                    10.0,
                    "dB",
                    "the deviation is above 10 dB; the load drifts while the force cell warms up, which widens the bundle, and five participants are few for a maximum",
                ),
            ]),
            format!(
                "{deviation:.1} dB at {hz:.0} Hz over {} transfer functions",
                all.count
            ),
        )
    }

    pub(super) fn narrower_with_load(&self) -> Finding {
        let bundles = [
            (&self.fingers, 0, "on the shaker"),
            (&self.devices, 0, "on the device at 20°"),
            (&self.devices, 1, "on the device at 40°"),
        ];
        let steps = |panel: &PanelAnalysis, angle: usize| {
            let deviations = panel.falls.get(angle).map(|f| f.deviations_db.clone());
            let deviations = deviations.unwrap_or_default();
            let whole = match deviations[..] {
                [light, _, heavy] => heavy - light,
                _ => f64::NAN,
            };
            (
                whole,
                most(deviations.windows(2).map(|pair| pair[1] - pair[0])),
            )
        };
        let mut rules: Vec<_> = bundles
            .iter()
            .map(|(panel, angle, on)| {
                let unless_met = format!("{on}, 0.6 N does not deviate less than 0.2 N");
                alone(below(steps(panel, *angle).0, 0.0, "dB", &unless_met))
            })
            .collect();
        let largest = most(
            bundles
                .iter()
                .map(|(panel, angle, _)| steps(panel, *angle).1),
        );
        rules.push(in_report_only(below(
            largest,
            0.0,
            "dB",
            "from 0.2 to 0.4 or from 0.4 to 0.6 N, a bundle does not become narrower",
        )));
        let told = |f: &FallsWithLoad| {
            let each: Vec<String> = f
                .deviations_db
                .iter()
                .map(|db| format!("{db:.1}"))
                .collect();
            let share = f.share_overall.map_or(String::new(), |share| {
                format!(
                    " (smaller at 0.6 N than at 0.2 N in {:.0} % of random halves of the participants)",
                    share * 100.0
                )
            });
            format!("{}{share}", each.join(", "))
        };
        let told =
            |panel: &PanelAnalysis, angle: usize| panel.falls.get(angle).map_or("–".into(), told);
        Finding::of(
            2,
            Holds::all(rules),
            format!(
                "at 0.2, 0.4, 0.6 N: shaker {}; device at 20° {}, at 40° {} dB",
                told(&self.fingers, 0),
                told(&self.devices, 0),
                told(&self.devices, 1)
            ),
        )
    }

    pub(super) fn louder_with_load(&self) -> Finding {
        let shaker_db = least_step(&self.fingers, ANGLES_DEG[0]);
        let device_db = least(ANGLES_DEG.map(|angle| least_step(&self.devices, angle)));
        let rising = least(ANGLES_DEG.map(|angle| rising_share(&self.devices, angle)));
        Finding::of(
            3,
            Holds::all([
                above(
                    device_db,
                    0.0,
                    "dB",
                    "on the device, the mean gain of some participant does not rise from one load to the next",
                ),
                at_least(
                    rising,
                    0.95,
                    "",
                    "on the device, the gain of some participant rises from 0.2 to 0.6 N on fewer than 95 % of the lines",
                ),
                above(
                    shaker_db,
                    0.0,
                    "dB",
                    "on the shaker, the mean gain of some participant does not rise from one load to the next",
                ),
            ]),
            format!(
                "smallest values of all participants: mean step from one load to the next {device_db:+.2} dB on the device at \
                    20° and 40°, {shaker_db:+.2} dB on the shaker; from 0.2 to 0.6 N the gain rises on {:.1} % of the lines on \
                    the device, on {:.1} % on the shaker",
                rising * 100.0,
                rising_share(&self.fingers, ANGLES_DEG[0]) * 100.0
            ),
        )
    }

    pub(super) fn angle(&self) -> Finding {
        let Some(effect) = self
            .devices
            .angle_effects
            .iter()
            .find(|e| e.load_n.is_none())
        else {
            return Finding::of(
                4,
                Holds::all([no_exception(1, "one angle only")]),
                "–".into(),
            );
        };
        let p = effect.sign_test_p.unwrap_or(f64::NAN);
        Finding::of(
            4,
            Holds::all([
                below(
                    effect.largest_db_rms,
                    1.5,
                    "dB",
                    "for some participant, the difference is 1.5 dB rms or more",
                ),
                above(p, 0.05, "", "the angle has a trend"),
            ]),
            format!(
                "at most {:.2} dB rms; higher gain at 40° for {} of {} participants, p = {p:.2}; mean step {:+.2} dB, at \
                    least {:+.2}",
                effect.largest_db_rms,
                effect.louder,
                effect.people.len(),
                effect.mean_db,
                least(effect.people.iter().map(|p| p.mean_db))
            ),
        )
    }

    pub(super) fn widest_condition(&self) -> Finding {
        let Some(worst) = &self.devices.worst else {
            return Finding::of(
                8,
                Holds::all([no_exception(
                    1,
                    "no participant was measured in every condition",
                )]),
                "–".into(),
            );
        };
        let widest_at = |light: bool| {
            let at = worst.ranking.iter();
            let at = at.filter(|(at, _)| super::same(at.load_n.0, LOADS_N[0]) == light);
            most(at.map(|(_, db)| *db))
        };
        let next = worst
            .ranking
            .get(1)
            .map_or(String::new(), |(at, db)| format!("; next {at}: {db:.1} dB"));
        let sure = worst.share.map_or(String::new(), |share| {
            format!(
                "; the widest in {:.0} % of random halves of the participants, so the angle is {}",
                share * 100.0,
                if share >= 0.95 { "clear" } else { "open" }
            )
        });
        Finding::of(
            8,
            Holds::all([above(
                widest_at(true) - widest_at(false),
                0.0,
                "dB",
                "another load than 0.2 N has the largest deviation",
            )]),
            format!(
                "{}: {:.1} dB over {} participants{next}{sure}",
                worst.cell, worst.max_deviation_db, worst.people
            ),
        )
    }

    /// The average of the twenty at 20° and 0.2 N.
    pub(super) fn device_average(&self) -> &Device {
        &self.device_average
    }

    pub(super) fn average_inside(&self) -> Finding {
        let light = cell(LOADS_N[0], ANGLES_DEG[0]);
        let found = self.devices.averages.iter().find(|a| a.cell.is(light));
        let bundle = self.devices.spreads.iter().find(|s| s.cell.is(light));
        let (Some(average), Some(spread)) = (found, bundle) else {
            return Finding::of(
                9,
                Holds::all([no_exception(1, "nothing was measured")]),
                "–".into(),
            );
        };
        let inside = |db: &[f64], bundle: &Ensemble| {
            let lines = db
                .iter()
                .zip(bundle.lowest_db.iter().zip(&bundle.highest_db));
            let within = lines.filter(|(db, (low, high))| (**low..=**high).contains(*db));
            within.count() as f64 / db.len() as f64
        };
        let log = inside(&average.log_magnitude_db, &spread.bundle);
        let complex = inside(&average.complex_db, &spread.bundle);
        let costs = average.penalties_of(BundleAverage::LogMagnitude);
        let [low, high] = costs.new_person_db_rms.unwrap_or([f64::NAN; 2]);
        let worst = most(costs.people.iter().map(|p| p.db_max));
        Finding::of(
            9,
            Holds::all([
                at_least(
                    log,
                    1.0,
                    "",
                    "the mean of log magnitudes is outside the bundle",
                ),
                at_least(complex, 1.0, "", "the complex mean is outside the bundle"),
            ]),
            format!(
                "at 20° and 0.2 N on the device: {:.0} % of the lines for the mean of log magnitudes, {:.0} % for the complex \
                    mean; the average of the others has an error of {:.1} dB rms for a participant (95 % for one new participant: \
                    {low:.1} to {high:.1}), at most {worst:.1} dB",
                log * 100.0,
                complex * 100.0,
                costs.mean_db_rms
            ),
        )
    }

    pub(super) fn figures(&self) -> Vec<Counterpart> {
        let loads = || LOADS_N.iter().map(|load_n| format!("{load_n} N"));
        let deviations = |label: &str, panel: &PanelAnalysis, angle: usize| {
            let found = panel.falls.get(angle).map(|f| f.deviations_db.clone());
            over_steps(label, found.unwrap_or_default().into_iter())
        };
        let by_load = |number, caption: &str, lines| {
            Counterpart::chart(
                number,
                caption,
                (names("load", loads()), linear("maximum deviation, dB")),
                lines,
            )
        };
        let averages = loads()
            .zip(&self.finger_averages)
            .map(|(name, f)| (name, levels(f, BAND_HZ[0], BAND_HZ[1])));
        let mut lines: Vec<Line> = self
            .light
            .iter()
            .map(|f| line("", levels(f, BAND_HZ[0], BAND_HZ[1])).thin())
            .collect();
        let averaged = levels(&self.device_average, BAND_HZ[0], BAND_HZ[1]);
        lines.push(line("average", averaged));
        vec![
            by_load(
                "68",
                "Maximum deviation of the fingers of five participants.",
                vec![deviations("shaker, 20°", &self.fingers, 0)],
            ),
            drawn(
                "70b",
                "Average fingers at three loads: mean of log magnitudes and phases.",
                "(m/s²)/N",
                averages.collect(),
            ),
            Counterpart::chart(
                "76",
                "The device with the fingers of twenty participants at 20° and 0.2 N, and their average.",
                (frequency(), linear("magnitude, dB re 1 (m/s²)/full scale")),
                lines,
            ),
            by_load(
                "77",
                "Maximum deviation of the device with the fingers of twenty participants.",
                vec![
                    deviations("20°", &self.devices, 0),
                    deviations("40°", &self.devices, 1),
                ],
            ),
        ]
    }
}

/// The steps of `panel` between two loads at an angle.
fn step(panel: &PanelAnalysis, angle_deg: f64, from_n: f64, to_n: f64) -> Option<&LoadStep> {
    panel.load_steps.iter().find(|step| {
        super::same(step.from_n.0, from_n)
            && super::same(step.to_n.0, to_n)
            && super::same(step.angle_deg.0, angle_deg)
    })
}

/// The least mean step of everybody from one load to the next at an angle, dB.
fn least_step(panel: &PanelAnalysis, angle_deg: f64) -> f64 {
    least(LOADS_N.windows(2).map(|loads| {
        let step = step(panel, angle_deg, loads[0], loads[1]);
        step.map_or(f64::NAN, |step| {
            least(step.people.iter().map(|p| p.mean_db))
        })
    }))
}

/// The least share of lines of anybody that rise from the lightest to the heaviest load at an angle.
fn rising_share(panel: &PanelAnalysis, angle_deg: f64) -> f64 {
    step(panel, angle_deg, LOADS_N[0], LOADS_N[2]).map_or(f64::NAN, |step| step.least_rising_share)
}
