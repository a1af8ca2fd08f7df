//! Chapter 5: transfer functions of the finger alone, on the shaker, and of the device with the finger.

mod panels;

use panels::Panels;
use piezotact::quantity::{
    Acceleration, Band, Drive, Force, Hertz, Newtons, Potential, Quantity, Seconds,
};
use piezotact::recording::Recording;
use piezotact::series::{mean, rms};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction, estimate};

use crate::BenchError;
use crate::procedure::record;
use crate::replay::claims::{Finding, Holds, least, most};
use crate::replay::figure::{Axis, Figure, Line, Mark, Shown, frequency};
use crate::replay::rendering::{characterised, device, resting};
use crate::replay::{Chapter, Replay, ReplayError, said_once};
use crate::traits::RunPlan;
use crate::twin::{Participant, ShakerBench, ShakerExcitation, ShakerMount};

const LOADS_N: [f64; 3] = [0.2, 0.4, 0.6];
const ANGLES_DEG: [f64; 2] = [20.0, 40.0];
/// On the shaker (*thesis* 5.1.1) and on the device (*thesis* 5.1.2).
const ON_SHAKER: u64 = 5;
const ON_DEVICE: u64 = 20;
const SHAKER_S: f64 = 60.0;
const DEVICE_S: f64 = 30.0;
/// Lines 2.4 Hz apart.
const SEGMENT: usize = 2_048;
const RENDERING: &str = "Rendering that knows its limits";

type Inertance = TransferFunction<Force, Acceleration>;
type Device = TransferFunction<Drive, Acceleration>;

/// One transfer function of a panel.
struct Measured<H> {
    participant: u64,
    load_n: f64,
    angle_deg: f64,
    function: H,
}

/// Whether two numbers of a protocol are one.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

impl<H> Measured<H> {
    fn is_at(&self, angle_deg: f64, load_n: f64) -> bool {
        same(self.angle_deg, angle_deg) && same(self.load_n, load_n)
    }
}

pub(super) fn chapter5(replay: &Replay) -> Result<Chapter, ReplayError> {
    let control = control(replay)?;
    let fingers = fingers(replay)?;
    let devices = devices(replay)?;
    let repeats = repeats(replay)?;
    let panels = Panels::of(&fingers, &devices)?;
    let mut figures = figures(&control, &fingers, &devices, &repeats);
    figures.extend(panels.figures());
    figures.sort_by_key(|figure| {
        let digits = figure
            .number
            .trim_end_matches(|c: char| c.is_ascii_alphabetic());
        digits.parse::<u32>().unwrap_or(u32::MAX)
    });
    let findings = vec![
        panels.all_together(),
        panels.narrower_with_load(),
        louder_with_load(&fingers, &devices),
        panels::angle(&devices),
        antiresonance(&control, &fingers),
        repeatable(&repeats),
        coherent(&repeats),
        panels.widest_condition(),
        panels.average_inside(),
        Finding::not_yet(22, RENDERING),
        Finding::not_yet(26, "the issue of campaigns"),
    ];
    Ok(Chapter {
        number: 5,
        title: "Transfer functions of finger and device",
        measured: vec![
            format!("On the shaker participants 1 to {ON_SHAKER} pressed with 0.2, 0.4 and 0.6 N at 20° for {SHAKER_S} s of random drive to 1 kHz each; the control measurement had the accelerometer on the plate."),
            format!("On the device participants 1 to {ON_DEVICE} did so at 20° and 40° for {DEVICE_S} s each, and participant 1 six times at 20° and 0.2 N, taking the finger off in between."),
        ],
        findings,
        doubts: said_once(
            (fingers.iter().flat_map(|m| &m.function.doubts).map(|d| ("shaker", d)))
                .chain(devices.iter().flat_map(|m| &m.function.doubts).map(|d| ("device", d)))
                .chain(repeats.iter().flat_map(|r| &r.doubts).map(|d| ("repeats", d))),
        ),
        figures,
        missing: vec![
            "Figure 79 (the averaged transfer function), with Rendering that knows its limits; figure 80, with the issue of campaigns.".into(),
        ],
    })
}

fn shaken(
    replay: &Replay,
    participant: u64,
    mount: ShakerMount,
    load_n: Option<f64>,
) -> Result<Recording, ReplayError> {
    let person = Participant::of(participant, replay.seed, &replay.parameters);
    let excitation = ShakerExcitation::thesis(Seconds(SHAKER_S), replay.seed);
    let bench = ShakerBench::new(&replay.parameters, person, mount, excitation);
    let run = RunPlan {
        load: load_n.map(Newtons),
        ..resting(&format!("shaker at {} N", load_n.unwrap_or(0.0)), 0.2, 20.0)
    };
    Ok(record(bench.into_acquirer().as_mut(), &run)?)
}

fn h1<I: Quantity>(
    recording: &Recording,
    input: &str,
) -> Result<TransferFunction<I, Acceleration>, ReplayError> {
    let from = recording
        .series::<I>(Some(input))
        .map_err(BenchError::from)?;
    let to = recording
        .series::<Acceleration>(Some("acceleration"))
        .map_err(BenchError::from)?;
    let config = WelchConfig::hann(SEGMENT);
    Ok(estimate(&from, &to, &config, Estimator::H1).map_err(BenchError::from)?)
}

fn control(replay: &Replay) -> Result<TransferFunction<Potential, Acceleration>, ReplayError> {
    h1(&shaken(replay, 1, ShakerMount::Plate, None)?, "drive")
}

fn fingers(replay: &Replay) -> Result<Vec<Measured<Inertance>>, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=ON_SHAKER {
        for load_n in LOADS_N {
            let recording = shaken(replay, participant, ShakerMount::Finger, Some(load_n))?;
            let function = h1(&recording, "force")?;
            all.push(Measured {
                participant,
                load_n,
                angle_deg: ANGLES_DEG[0],
                function,
            });
        }
    }
    Ok(all)
}

fn devices(replay: &Replay) -> Result<Vec<Measured<Device>>, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=ON_DEVICE {
        let mut bench = device(replay, participant);
        for (angle_deg, load_n) in ANGLES_DEG.into_iter().flat_map(|a| LOADS_N.map(|l| (a, l))) {
            let run = resting(&format!("panel {angle_deg} {load_n}"), load_n, angle_deg);
            let function = characterised(&mut bench, run, DEVICE_S, replay.seed)?;
            all.push(Measured {
                participant,
                load_n,
                angle_deg,
                function,
            });
        }
    }
    Ok(all)
}

/// One finger six times, put back in between.
fn repeats(replay: &Replay) -> Result<Vec<Device>, ReplayError> {
    let mut bench = device(replay, 1);
    (1..=6)
        .map(|i| {
            let run = resting(&format!("repeat {i}"), 0.2, 20.0);
            characterised(&mut bench, run, SHAKER_S, replay.seed)
        })
        .collect()
}

/// Magnitudes in dB within a band, with their frequencies.
fn levels<I: Quantity>(
    function: &TransferFunction<I, Acceleration>,
    low_hz: f64,
    high_hz: f64,
) -> Vec<(f64, f64)> {
    function
        .frequencies_hz()
        .into_iter()
        .zip(function.response())
        .filter(|(f, _)| (low_hz..=high_hz).contains(f))
        .map(|(f, h)| (f, 20.0 * h.norm().max(f64::MIN_POSITIVE).log10()))
        .collect()
}

/// How much louder each person's response is at 0.6 than at 0.2 N: the mean, and the share of lines where it is.
fn steps<I: Quantity>(panel: &[Measured<TransferFunction<I, Acceleration>>]) -> Vec<(f64, f64)> {
    let of = |participant: u64, load_n: f64| {
        let found = panel
            .iter()
            .find(|m| m.participant == participant && m.is_at(ANGLES_DEG[0], load_n));
        found.map(|m| levels(&m.function, 20.0, 1000.0))
    };
    let mut people: Vec<u64> = panel.iter().map(|m| m.participant).collect();
    people.dedup();
    people
        .into_iter()
        .filter_map(|p| {
            let (light, firm) = (of(p, 0.2)?, of(p, 0.6)?);
            let steps: Vec<f64> = light.iter().zip(&firm).map(|(a, b)| b.1 - a.1).collect();
            let rising = steps.iter().filter(|step| **step > 0.0).count();
            Some((mean(&steps), rising as f64 / steps.len() as f64))
        })
        .collect()
}

fn louder_with_load(fingers: &[Measured<Inertance>], devices: &[Measured<Device>]) -> Finding {
    let worst = |steps: &[(f64, f64)]| {
        (
            least(steps.iter().map(|s| s.0)),
            least(steps.iter().map(|s| s.1)),
        )
    };
    let (shaker, device) = (worst(&steps(fingers)), worst(&steps(devices)));
    Finding::of(
        3,
        Holds::all([
            (
                shaker.0 > 0.0 && device.0 > 0.0,
                "somebody's mean gain falls",
            ),
            (
                device.1 >= 0.95,
                "on the device somebody's gain rises on fewer than 95 % of the lines",
            ),
            (
                shaker.1 >= 0.95,
                "on the shaker somebody's gain rises on fewer than 95 % of the lines: single estimates of a minute scatter there by as much as the step",
            ),
        ]),
        format!(
            "0.2 to 0.6 N, least of all people: shaker {:+.2} dB, {:.0} % of lines; device {:+.2} dB, {:.0} % of lines",
            shaker.0,
            shaker.1 * 100.0,
            device.0,
            device.1 * 100.0
        ),
    )
}

/// The frequency of the lowest level of a range that is lower than both its ends by 2 dB, and its depth below their mean.
fn dip(levels: &[(f64, f64)]) -> Option<(f64, f64)> {
    let lowest = levels.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (first, last) = (levels.first()?, levels.last()?);
    let depth = 0.5 * (first.1 + last.1) - lowest.1;
    (lowest.1 < first.1.min(last.1) - 2.0).then_some((lowest.0, depth))
}

fn antiresonance(
    control: &TransferFunction<Potential, Acceleration>,
    fingers: &[Measured<Inertance>],
) -> Finding {
    const AROUND: (f64, f64) = (225.0, 305.0);
    let in_control = dip(&levels(control, AROUND.0, AROUND.1));
    // Far above the suspension the bare plate's own response is flat.
    let flat = levels(control, 700.0, 900.0);
    let flat_db = mean(&flat.iter().map(|l| l.1).collect::<Vec<f64>>());
    let artefact: Vec<f64> = levels(control, AROUND.0, AROUND.1)
        .iter()
        .map(|l| l.1 - flat_db)
        .collect();
    let (mut places, mut left) = (Vec::new(), Vec::new());
    for m in fingers {
        let measured = levels(&m.function, AROUND.0, AROUND.1);
        places.extend(dip(&measured).map(|(hz, _)| hz));
        let removed: Vec<f64> = measured
            .iter()
            .zip(&artefact)
            .map(|(l, a)| l.1 - a)
            .collect();
        left.push(bulge(&removed));
    }
    let (lowest, highest) = (least(places.iter().copied()), most(places.iter().copied()));
    let left = most(left);
    let near = |hz: f64| (hz - 265.0).abs() <= 5.0;
    let control_hz = in_control.map_or(f64::NAN, |(hz, _)| hz);
    Finding::of(
        5,
        Holds::all([
            (near(control_hz), "it is not in the control"),
            (
                places.len() == fingers.len() && near(lowest) && near(highest),
                "it is not in every finger",
            ),
            (left <= 2.0, "more than 2 dB are left after compensation"),
        ]),
        format!(
            "control {control_hz:.1} Hz; {} of {} fingers, {lowest:.1}–{highest:.1} Hz; after division by the control at most {left:.1} dB are left",
            places.len(),
            fingers.len()
        ),
    )
}

/// The largest departure of levels from the straight line between their ends, dB.
fn bulge(levels_db: &[f64]) -> f64 {
    let (Some(first), Some(last)) = (levels_db.first(), levels_db.last()) else {
        return f64::NAN;
    };
    let steps = (levels_db.len() - 1).max(1) as f64;
    let line = |i: usize| first + (last - first) * i as f64 / steps;
    most(
        levels_db
            .iter()
            .enumerate()
            .map(|(i, l)| (l - line(i)).abs()),
    )
}

fn repeatable(repeats: &[Device]) -> Finding {
    let all: Vec<Vec<(f64, f64)>> = repeats.iter().map(|r| levels(r, 20.0, 1000.0)).collect();
    let mut apart = Vec::new();
    for (i, a) in all.iter().enumerate() {
        for b in &all[..i] {
            let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.1 - b.1).collect();
            apart.push(rms(&off));
        }
    }
    let apart = most(apart);
    Finding::of(
        6,
        Holds::all([(apart <= 1.0, "two are further apart")]),
        format!("six measurements, any two at most {apart:.2} dB rms apart over 20–1000 Hz"),
    )
}

fn coherent(repeats: &[Device]) -> Finding {
    let band = Band::new(Hertz(25.0), Hertz(950.0)).ok();
    let lowest = least(repeats.iter().map(|r| {
        let summary = band.and_then(|band| r.coherence_in(band));
        summary.map_or(f64::NAN, |summary| summary.lowest)
    }));
    let at_5_hz = most(repeats.iter().map(|r| {
        let k = (5.0 / r.resolution_hz()).round() as usize;
        r.coherence().get(k).copied().unwrap_or(f64::NAN)
    }));
    Finding::of(
        7,
        Holds::all([
            (lowest > 0.95, "it falls below 0.95 within 25–950 Hz"),
            (at_5_hz < 0.9, "it is above 0.9 at 5 Hz"),
        ]),
        format!("at least {lowest:.3} over 25–950 Hz, at most {at_5_hz:.2} at 5 Hz"),
    )
}

/// Magnitudes in one frame.
fn drawn(
    number: &'static str,
    caption: &str,
    unit: &str,
    lines: Vec<(String, Vec<(f64, f64)>)>,
) -> Figure {
    Figure {
        number,
        caption: caption.into(),
        shown: Shown::Lines {
            x: frequency(),
            y: Axis::linear(&format!("magnitude, dB re 1 {unit}")),
            lines: lines
                .into_iter()
                .map(|(label, points)| Line::new(label, Mark::Line, points))
                .collect(),
        },
    }
}

fn figures(
    control: &TransferFunction<Potential, Acceleration>,
    fingers: &[Measured<Inertance>],
    devices: &[Measured<Device>],
    repeats: &[Device],
) -> Vec<Figure> {
    const INERTANCE: &str = "(m/s²)/N";
    const DEVICE: &str = "(m/s²)/full scale";
    let shown = |m: &Measured<Inertance>| levels(&m.function, 20.0, 1000.0);
    let at = |load_n: f64| -> Vec<(String, Vec<(f64, f64)>)> {
        let chosen = fingers.iter().filter(|m| same(m.load_n, load_n));
        chosen
            .map(|m| (format!("P{:02}", m.participant), shown(m)))
            .collect()
    };
    let one = |participant: u64| -> Vec<(String, Vec<(f64, f64)>)> {
        let chosen = fingers.iter().filter(|m| m.participant == participant);
        chosen
            .map(|m| (format!("{} N", m.load_n), shown(m)))
            .collect()
    };
    let all = fingers.iter().map(|m| (String::new(), shown(m))).collect();
    let mut figures = vec![
        drawn(
            "67a",
            "The finger alone, five participants at 0.2 N.",
            INERTANCE,
            at(0.2),
        ),
        drawn("67b", "The same at 0.4 N.", INERTANCE, at(0.4)),
        drawn("67c", "The same at 0.6 N.", INERTANCE, at(0.6)),
        drawn("67d", "All participants at all loads.", INERTANCE, all),
        drawn(
            "70a",
            "The finger of participant 1 at three loads.",
            INERTANCE,
            one(1),
        ),
        drawn(
            "71a",
            "The control measurement: the accelerometer on the plate.",
            "(m/s²)/V",
            vec![(String::new(), levels(control, 20.0, 1000.0))],
        ),
    ];
    let near = |m: &Measured<Inertance>| (String::new(), levels(&m.function, 200.0, 340.0));
    figures.push(drawn(
        "71b",
        "All fingers around the antiresonance of the bench.",
        INERTANCE,
        fingers.iter().map(near).collect(),
    ));
    let of_device = |m: &Measured<Device>| levels(&m.function, 20.0, 1000.0);
    let first = devices
        .iter()
        .filter(|m| m.participant == 1 && same(m.angle_deg, ANGLES_DEG[0]));
    figures.push(drawn(
        "74a",
        "The device with the finger of participant 1 at three loads, 20°.",
        DEVICE,
        first
            .map(|m| (format!("{} N", m.load_n), of_device(m)))
            .collect(),
    ));
    let at = |angle_deg: f64, load_n: f64| {
        let found = devices
            .iter()
            .find(|m| m.participant == 1 && m.is_at(angle_deg, load_n));
        found.map(of_device).unwrap_or_default()
    };
    let steep = LOADS_N.map(|load_n| (format!("{load_n} N"), at(ANGLES_DEG[1], load_n)));
    figures.push(drawn("74b", "The same at 40°.", DEVICE, steep.into()));
    for (number, load_n) in [("75a", 0.2), ("75b", 0.4), ("75c", 0.6)] {
        let both = ANGLES_DEG.map(|angle_deg| (format!("{angle_deg}°"), at(angle_deg, load_n)));
        let caption =
            format!("The device with the finger of participant 1 at two angles, {load_n} N.");
        figures.push(drawn(number, &caption, DEVICE, both.into()));
    }
    let repeated = repeats
        .iter()
        .enumerate()
        .map(|(i, r)| (format!("repeat {}", i + 1), levels(r, 20.0, 1000.0)));
    figures.push(drawn(
        "78a",
        "Six measurements of one finger, taken off and put back.",
        DEVICE,
        repeated.collect(),
    ));
    figures.push(Figure {
        number: "78b",
        caption: "Their coherence.".into(),
        shown: Shown::Lines {
            x: frequency(),
            y: Axis::linear("coherence"),
            lines: repeats
                .iter()
                .enumerate()
                .map(|(i, r)| {
                    let points = r
                        .frequencies_hz()
                        .into_iter()
                        .zip(r.coherence().iter().copied());
                    let within = points.filter(|(f, _)| *f <= 1000.0).collect();
                    Line::new(format!("repeat {}", i + 1), Mark::Line, within)
                })
                .collect(),
        },
    });
    figures
}
