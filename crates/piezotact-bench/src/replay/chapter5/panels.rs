//! Bundles of people: how far they lie apart by load and angle, and their average.

use piezotact::compare::sign_test;
use piezotact::quantity::{Acceleration, Band, Hertz, Quantity};
use piezotact::series::{mean, rms};
use piezotact::transfer::{
    Bundle, BundleAverage, BundleError, LeaveOneOut, TransferFunction, average, bundle,
    leave_one_out,
};

use super::{ANGLES_DEG, Device, Inertance, LOADS_N, Measured, drawn, levels, same};
use crate::replay::ReplayError;
use crate::replay::claims::{Finding, Holds, least, most};
use crate::replay::figure::{Axis, Figure, Line, Mark, Shown, frequency};

/// The band of the thesis' figures, Hz.
const BAND_HZ: [f64; 2] = [20.0, 1000.0];
/// The conditions of the device, angle and load, in the order of [`Panels::device`].
fn conditions() -> impl Iterator<Item = (f64, f64)> {
    ANGLES_DEG
        .into_iter()
        .flat_map(|angle_deg| LOADS_N.map(|load_n| (angle_deg, load_n)))
}

/// The bundles of both benches.
pub(super) struct Panels {
    /// The fingers of all people at all loads.
    all: Bundle,
    /// At each load.
    shaker: Vec<Bundle>,
    /// At each angle and load.
    device: Vec<Bundle>,
    /// The averages over people: fingers at each load, and the device at 20° and 0.2 N by both means.
    finger_averages: Vec<Inertance>,
    device_averages: [Device; 2],
    /// What the average costs those whom it leaves out, at 20° and 0.2 N.
    left_out: LeaveOneOut,
    device_lines: Vec<Vec<(f64, f64)>>,
}

type Panel<I> = [Measured<TransferFunction<I, Acceleration>>];

fn at<I: Quantity>(
    panel: &Panel<I>,
    angle_deg: f64,
    load_n: f64,
) -> Vec<&TransferFunction<I, Acceleration>> {
    panel
        .iter()
        .filter(|m| m.is_at(angle_deg, load_n))
        .map(|m| &m.function)
        .collect()
}

impl Panels {
    pub(super) fn of(
        fingers: &[Measured<Inertance>],
        devices: &[Measured<Device>],
    ) -> Result<Self, ReplayError> {
        let band = Band::new(Hertz(BAND_HZ[0]), Hertz(BAND_HZ[1]))?;
        let everybody: Vec<&Inertance> = fingers.iter().map(|m| &m.function).collect();
        let at_load = |load_n: f64| at(fingers, ANGLES_DEG[0], load_n);
        let light = at(devices, ANGLES_DEG[0], LOADS_N[0]);
        Ok(Self {
            all: bundle(&everybody, band)?,
            shaker: LOADS_N
                .iter()
                .map(|load_n| bundle(&at_load(*load_n), band))
                .collect::<Result<_, BundleError>>()?,
            device: conditions()
                .map(|(angle_deg, load_n)| bundle(&at(devices, angle_deg, load_n), band))
                .collect::<Result<_, BundleError>>()?,
            finger_averages: LOADS_N
                .iter()
                .map(|load_n| average(&at_load(*load_n), BundleAverage::LogMagnitude))
                .collect::<Result<_, BundleError>>()?,
            device_averages: [
                average(&light, BundleAverage::LogMagnitude)?,
                average(&light, BundleAverage::Complex)?,
            ],
            left_out: leave_one_out(&light, BundleAverage::LogMagnitude, band)?,
            device_lines: light
                .iter()
                .map(|f| levels(f, BAND_HZ[0], BAND_HZ[1]))
                .collect(),
        })
    }

    pub(super) fn all_together(&self) -> Finding {
        let (deviation, hz) = (self.all.max_deviation_db, self.all.max_deviation_at_hz);
        Finding::of(
            1,
            Holds::all([(
                (6.0..=9.0).contains(&deviation),
                "the deviation lies outside 6–9 dB; the load drifts as the force cell warms, which widens the bundle",
            )]),
            format!(
                "{deviation:.1} dB at {hz:.0} Hz over {} transfer functions",
                self.all.count
            ),
        )
    }

    pub(super) fn narrower_with_load(&self) -> Finding {
        let falls = |bundles: &[Bundle]| {
            bundles
                .windows(2)
                .all(|pair| pair[0].max_deviation_db > pair[1].max_deviation_db)
        };
        let told = |bundles: &[Bundle]| {
            let each: Vec<String> = bundles
                .iter()
                .map(|b| format!("{:.1}", b.max_deviation_db))
                .collect();
            each.join(", ")
        };
        let (flat, steep) = self.device.split_at(LOADS_N.len());
        Finding::of(
            2,
            Holds::all([
                (falls(&self.shaker), "it does not fall on the shaker"),
                (falls(flat), "it does not fall on the device at 20°"),
                (falls(steep), "it does not fall on the device at 40°"),
            ]),
            format!(
                "at 0.2, 0.4, 0.6 N: shaker {}; device at 20° {}, at 40° {} dB",
                told(&self.shaker),
                told(flat),
                told(steep)
            ),
        )
    }

    pub(super) fn widest_condition(&self) -> Finding {
        let widest = conditions()
            .zip(&self.device)
            .max_by(|a, b| a.1.max_deviation_db.total_cmp(&b.1.max_deviation_db));
        let ((angle_deg, load_n), deviation) = widest
            .map_or(((f64::NAN, f64::NAN), f64::NAN), |(c, b)| {
                (c, b.max_deviation_db)
            });
        Finding::of(
            8,
            Holds::all([(
                same(angle_deg, ANGLES_DEG[0]) && same(load_n, LOADS_N[0]),
                "another condition spreads more",
            )]),
            format!(
                "{angle_deg}° and {load_n} N: {deviation:.1} dB over {} people",
                self.device[0].count
            ),
        )
    }

    pub(super) fn average_inside(&self) -> Finding {
        let bundle = &self.device[0];
        let inside = self.device_averages.each_ref().map(|averaged| {
            let lines = levels(averaged, BAND_HZ[0], BAND_HZ[1]);
            let within = lines
                .iter()
                .zip(bundle.lowest_db.iter().zip(&bundle.highest_db))
                .filter(|(line, (low, high))| (**low..=**high).contains(&line.1));
            within.count() as f64 / lines.len() as f64
        });
        let [low, high] = self.left_out.interval_db_rms.unwrap_or([f64::NAN; 2]);
        let worst = most(self.left_out.penalties.iter().map(|p| p.db_max));
        Finding::of(
            9,
            Holds::all([
                (
                    inside[0] >= 1.0,
                    "the mean of log magnitudes leaves the bundle",
                ),
                (inside[1] >= 1.0, "the complex mean leaves the bundle"),
            ]),
            format!(
                "at 20° and 0.2 N on the device: {:.0} % of the lines for the mean of log magnitudes, {:.0} % for the complex mean; the average of the others misses a person by {:.1} dB rms ({low:.1} to {high:.1}), at most {worst:.1} dB",
                inside[0] * 100.0,
                inside[1] * 100.0,
                self.left_out.mean_db_rms
            ),
        )
    }

    pub(super) fn figures(&self) -> Vec<Figure> {
        let names = || LOADS_N.iter().map(|load_n| format!("{load_n} N"));
        let deviations = |label: &str, bundles: &[Bundle]| {
            Line::over_names(label, bundles.iter().map(|b| b.max_deviation_db))
        };
        let by_load = |number, caption: &str, lines| Figure {
            number,
            caption: caption.into(),
            shown: Shown::Lines {
                x: Axis::names("load", names()),
                y: Axis::linear("maximum deviation, dB"),
                lines,
            },
        };
        let (flat, steep) = self.device.split_at(LOADS_N.len());
        let of_band = |f: &Inertance| levels(f, BAND_HZ[0], BAND_HZ[1]);
        let averages = names()
            .zip(&self.finger_averages)
            .map(|(name, f)| (name, of_band(f)));
        let mut lines: Vec<Line> = self
            .device_lines
            .iter()
            .map(|points| Line::new("", Mark::Thin, points.clone()))
            .collect();
        let averaged = levels(&self.device_averages[0], BAND_HZ[0], BAND_HZ[1]);
        lines.push(Line::new("average", Mark::Line, averaged));
        vec![
            by_load("68", "Maximum deviation of the fingers of five participants.", vec![deviations("shaker, 20°", &self.shaker)]),
            drawn("70b", "Average fingers at three loads: mean of log magnitudes and phases.", "(m/s²)/N", averages.collect()),
            Figure {
                number: "76",
                caption: "The device with the fingers of twenty participants at 20° and 0.2 N, and their average.".into(),
                shown: Shown::Lines {
                    x: frequency(),
                    y: Axis::linear("magnitude, dB re 1 (m/s²)/full scale"),
                    lines,
                },
            },
            by_load("77", "Maximum deviation of the device with the fingers of twenty participants.", vec![deviations("20°", flat), deviations("40°", steep)]),
        ]
    }
}

/// 20° against 40° on the device, person by person over all loads.
pub(super) fn angle(devices: &[Measured<Device>]) -> Finding {
    let mut people: Vec<u64> = devices.iter().map(|m| m.participant).collect();
    people.dedup();
    let (mut shapes, mut trends) = (Vec::new(), Vec::new());
    for person in people {
        let mut steps = Vec::new();
        for load_n in LOADS_N {
            let at = |angle_deg: f64| {
                let found = devices
                    .iter()
                    .find(|m| m.participant == person && m.is_at(angle_deg, load_n));
                found.map(|m| levels(&m.function, BAND_HZ[0], BAND_HZ[1]))
            };
            let (Some(flat), Some(steep)) = (at(ANGLES_DEG[0]), at(ANGLES_DEG[1])) else {
                continue;
            };
            let step: Vec<f64> = flat.iter().zip(&steep).map(|(a, b)| b.1 - a.1).collect();
            shapes.push(rms(&step));
            steps.push(mean(&step));
        }
        trends.push(mean(&steps));
    }
    let (widest, p) = (most(shapes), sign_test(&trends).unwrap_or(f64::NAN));
    let rising = trends.iter().filter(|step| **step > 0.0).count();
    Finding::of(
        4,
        Holds::all([
            (widest < 1.5, "somebody's differs by 1.5 dB rms or more"),
            (p > 0.05, "the angle has a trend"),
        ]),
        format!(
            "at most {widest:.2} dB rms; louder at 40° for {rising} of {} people, p = {p:.2}; mean step {:+.2} dB, at least {:+.2}",
            trends.len(),
            mean(&trends),
            least(trends.iter().copied())
        ),
    )
}
