//! Chapter 5: transfer functions of the finger alone, on the shaker, and of the device with the finger.

mod panels;

use panels::Panels;
use piezotact::panel::{
    Artefact, Cell, Dip, Entry, Filing, PairDistances, Panel, artefact_of, repeatability,
};
use piezotact::quantity::{
    Acceleration, Band, Degrees, Drive, Force, Hertz, Newtons, Potential, Quantity, Seconds,
};
use piezotact::recording::Recording;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{BundleAverage, Estimator, TransferFunction, estimate};

use crate::averaged::with_average;
use crate::claims::{Finding, Holds, above, at_most, below, least, most, no_exception};
use crate::figure::{Counterpart, frequency, line, linear};
use crate::{Chapter, ReplayError, campaigns, said_once};
use piezotact_bench::ProcedureError;
use piezotact_bench::procedure::record;
use piezotact_bench::{Placement, RunPlan, Until};
use piezotact_twin::{Participant, ShakerBench, ShakerExcitation, ShakerMount};
use piezotact_volunteers::{Laboratory, characterised, resting};

const LOADS_N: [f64; 3] = [0.2, 0.4, 0.6];
const ANGLES_DEG: [f64; 2] = [20.0, 40.0];
/// On the shaker (*thesis* 5.1.1) and on the device (*thesis* 5.1.2).
const ON_SHAKER: u64 = 5;
const ON_DEVICE: u64 = 20;
/// Consecutive measurements of one placement in every condition (*thesis* 5.1.2).
const REPEATS: u32 = 3;
/// How long each measurement lasts: the control, one on the shaker, one on the device.
const CONTROL_S: f64 = 60.0;
const SHAKER_S: f64 = 60.0;
const DEVICE_S: f64 = 20.0;
/// Lines 2.4 Hz apart.
const SEGMENT: usize = 2_048;

type Inertance = TransferFunction<Force, Acceleration>;
type Device = TransferFunction<Drive, Acceleration>;
type Fingers = Panel<Force, Acceleration>;
type Devices = Panel<Drive, Acceleration>;

/// Whether two numbers of a protocol are one.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

fn cell(load_n: f64, angle_deg: f64) -> Cell {
    Cell {
        load_n: Newtons(load_n),
        angle_deg: Degrees(angle_deg),
    }
}

fn pseudonym(laboratory: &Laboratory, participant: u64) -> String {
    Participant::of(participant, laboratory.seed, &laboratory.parameters).pseudonym()
}

/// One measurement of a protocol: the finger is put down for the first repeat of a placement, and left there.
#[derive(Clone, Copy)]
struct Asked {
    participant: u64,
    cell: Cell,
    placement: u32,
    repeat: u32,
}

impl Asked {
    fn label(self) -> String {
        let (Cell { load_n, angle_deg }, placement) = (self.cell, self.placement);
        format!("panel {} {} placement {placement}", angle_deg.0, load_n.0)
    }

    fn run(self) -> RunPlan {
        let first = self.label();
        let run = resting(&first, self.cell.load_n.0, self.cell.angle_deg.0);
        if self.repeat == 1 {
            return run;
        }
        RunPlan {
            label: format!("{first} repeat {}", self.repeat),
            placement: Placement::SameAs(first),
            ..run
        }
    }

    /// Every repeat is driven by its own random signal.
    fn seed(self, laboratory: &Laboratory) -> u64 {
        laboratory.seed.wrapping_add(u64::from(self.repeat - 1))
    }

    fn filed<I: Quantity>(
        self,
        laboratory: &Laboratory,
        function: TransferFunction<I, Acceleration>,
    ) -> Entry<I, Acceleration> {
        let filing = Filing {
            participant: pseudonym(laboratory, self.participant),
            cell: self.cell,
            placement: self.placement,
            repeat: self.repeat,
        };
        Entry { filing, function }
    }
}

pub(super) fn chapter5(laboratory: &Laboratory) -> Result<Chapter, ReplayError> {
    let control = control(laboratory)?;
    let fingers = fingers(laboratory)?;
    let devices = devices(laboratory)?;
    let repeats = repeats(laboratory, &devices)?;
    let panels = Panels::of(&fingers, &devices, laboratory.seed)?;
    let averaged = with_average(laboratory, panels.device_average())?;
    let campaigns = campaigns::of_chapter_5(laboratory, panels.device_average())?;
    let mut figures = figures(laboratory, &control, &fingers, &devices, &repeats)?;
    figures.extend(panels.figures());
    figures.extend(averaged.figure);
    figures.extend(campaigns.figures);
    figures.sort_by_key(|figure| {
        let digits = figure
            .number
            .trim_end_matches(|c: char| c.is_ascii_alphabetic());
        digits.parse::<u32>().unwrap_or(u32::MAX)
    });
    let mut findings = vec![
        panels.all_together(),
        panels.narrower_with_load(),
        panels.louder_with_load(),
        panels.angle(),
        antiresonance(&control, &fingers),
        repeatable(&repeats)?,
        coherent(&devices, &repeats),
        panels.widest_condition(),
        panels.average_inside(),
        averaged.finding,
    ];
    findings.extend(campaigns.findings);
    let of_entries = fingers
        .entries()
        .iter()
        .flat_map(|e| &e.function.about.warnings);
    let of_devices = devices
        .entries()
        .iter()
        .flat_map(|e| &e.function.about.warnings);
    let of_repeats = repeats
        .entries()
        .iter()
        .flat_map(|e| &e.function.about.warnings);
    Ok(Chapter {
        number: 5,
        title: "Transfer functions of finger and device",
        measured: vec![
            format!(
                "On the shaker participants 1 to {ON_SHAKER} pressed with 0.2, 0.4 and 0.6 N at 20°, each {REPEATS} times \
                    for {SHAKER_S} s of random drive to 1 kHz without lifting the finger; the control measurement had the \
                    accelerometer on the plate."
            ),
            format!(
                "On the device participants 1 to {ON_DEVICE} did so at 20° and 40° for {DEVICE_S} s each time. The {REPEATS} \
                    are averaged. At 20° and 0.2 N everybody was measured three more times, with the finger withdrawn and \
                    repositioned before each."
            ),
            averaged.measured,
        ]
        .into_iter()
        .chain(campaigns.measured)
        .collect(),
        findings,
        warnings: said_once(
            (of_entries.map(|d| ("shaker", d)))
                .chain(of_devices.map(|d| ("device", d)))
                .chain(of_repeats.map(|d| ("repeats", d)))
                .chain((panels.fingers.warnings.iter()).map(|d| ("panel on the shaker", d)))
                .chain(
                    averaged
                        .warnings
                        .iter()
                        .map(|d| ("rendering with the average", d)),
                )
                .chain((panels.devices.warnings.iter()).map(|d| ("panel on the device", d))),
        ),
        figures,
        missing: Vec::new(),
    })
}

fn shaken(
    laboratory: &Laboratory,
    participant: u64,
    mount: ShakerMount,
    run: &RunPlan,
    excitation: ShakerExcitation,
) -> Result<Recording, ReplayError> {
    let person = Participant::of(participant, laboratory.seed, &laboratory.parameters);
    let bench = ShakerBench::new(&laboratory.parameters, person, mount, excitation);
    // The shaker drives itself, and is done when its excitation is.
    let run = RunPlan {
        until: Until::Stopped,
        ..run.clone()
    };
    Ok(record(bench.into_acquirer().as_mut(), &run)?)
}

fn h1<I: Quantity>(
    recording: &Recording,
    input: &str,
) -> Result<TransferFunction<I, Acceleration>, ReplayError> {
    let from = recording
        .series::<I>(Some(input))
        .map_err(ProcedureError::from)?;
    let to = recording
        .series::<Acceleration>(Some("acceleration"))
        .map_err(ProcedureError::from)?;
    let config = WelchConfig::hann(SEGMENT);
    let mut function =
        estimate(&from, &to, &config, Estimator::H1).map_err(ProcedureError::from)?;
    function.about.condition = recording.about.condition.clone();
    Ok(function)
}

fn control(
    laboratory: &Laboratory,
) -> Result<TransferFunction<Potential, Acceleration>, ReplayError> {
    let run = RunPlan {
        load: None,
        ..resting("control", 0.2, ANGLES_DEG[0])
    };
    let excitation = ShakerExcitation::thesis(Seconds(CONTROL_S), laboratory.seed);
    let recording = shaken(laboratory, 1, ShakerMount::Plate, &run, excitation)?;
    h1(&recording, "drive")
}

fn fingers(laboratory: &Laboratory) -> Result<Fingers, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=ON_SHAKER {
        for load_n in LOADS_N {
            for repeat in 1..=REPEATS {
                let asked = Asked {
                    participant,
                    cell: cell(load_n, ANGLES_DEG[0]),
                    placement: 1,
                    repeat,
                };
                let excitation =
                    ShakerExcitation::thesis(Seconds(SHAKER_S), asked.seed(laboratory));
                let mount = ShakerMount::Finger;
                let recording = shaken(laboratory, participant, mount, &asked.run(), excitation)?;
                all.push(asked.filed(laboratory, h1(&recording, "force")?));
            }
        }
    }
    Ok(Panel::new(all)?)
}

fn devices(laboratory: &Laboratory) -> Result<Devices, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=ON_DEVICE {
        let mut bench = laboratory.device(participant);
        for (angle_deg, load_n) in ANGLES_DEG.into_iter().flat_map(|a| LOADS_N.map(|l| (a, l))) {
            for repeat in 1..=REPEATS {
                let asked = Asked {
                    participant,
                    cell: cell(load_n, angle_deg),
                    placement: 1,
                    repeat,
                };
                let seed = asked.seed(laboratory);
                let function = characterised(&mut bench, asked.run(), DEVICE_S, seed)?;
                all.push(asked.filed(laboratory, function));
            }
        }
    }
    Ok(Panel::new(all)?)
}

/// Every finger at 20° and 0.2 N: the three measurements of the panel without repositioning, and three with repositioning.
fn repeats(laboratory: &Laboratory, devices: &Devices) -> Result<Devices, ReplayError> {
    let light = cell(LOADS_N[0], ANGLES_DEG[0]);
    let lying = devices.entries().iter().filter(|e| e.filing.cell.is(light));
    let mut all: Vec<Entry<Drive, Acceleration>> = lying.cloned().collect();
    for participant in 1..=ON_DEVICE {
        let mut bench = laboratory.device(participant);
        for placement in 2..=4 {
            let asked = Asked {
                participant,
                cell: light,
                placement,
                repeat: 1,
            };
            let seed = asked.seed(laboratory).wrapping_add(u64::from(placement));
            let function = characterised(&mut bench, asked.run(), DEVICE_S, seed)?;
            all.push(asked.filed(laboratory, function));
        }
    }
    Ok(Panel::new(all)?)
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

fn antiresonance(
    control: &TransferFunction<Potential, Acceleration>,
    fingers: &Fingers,
) -> Finding {
    let searched = Band::new(Hertz(100.0), Hertz(500.0)).ok();
    let artefact = searched.and_then(|band| artefact_of(control, band).ok());
    let control_hz = artefact.as_ref().map_or(f64::NAN, |a| a.at_hz);
    let dips = artefact.as_ref().map_or(Vec::new(), |a| dips(a, fingers));
    // Lower than what is close by.
    let places: Vec<f64> = dips
        .iter()
        .filter(|(before, _)| before.depth_db > 2.0)
        .map(|(before, _)| before.at_hz)
        .collect();
    let (lowest, highest) = (least(places.iter().copied()), most(places.iter().copied()));
    let left = most(dips.iter().map(|(_, after)| after.largest_db));
    let near = |hz: f64| (hz - 265.0).abs() <= 5.0;
    let count = fingers.participants().len() * fingers.cells().len();
    Finding::of(
        5,
        Holds::all([
            no_exception(
                1 - usize::from(near(control_hz)),
                "the antiresonance is not in the control",
            ),
            no_exception(
                1 - usize::from(places.len() == count && near(lowest) && near(highest)),
                "the antiresonance is not in the measurement of every finger",
            ),
            at_most(left, 2.0, "dB", "more than 2 dB remain after compensation"),
        ]),
        format!(
            "control {control_hz:.1} Hz, {:.1} dB deep; {} of {count} fingers, {lowest:.1}–{highest:.1} Hz; after division by \
                the narrow structure of the control, at most {left:.1} dB remain",
            artefact.as_ref().map_or(f64::NAN, |a| a.depth_db),
            places.len(),
        ),
    )
}

/// The artefact in everybody's finger, before and after it is taken out.
fn dips(artefact: &Artefact, fingers: &Fingers) -> Vec<(Dip, Dip)> {
    let mut found = Vec::new();
    for who in fingers.participants() {
        for at in fingers.cells() {
            let own = fingers.person(who, *at, BundleAverage::LogMagnitude);
            let removed = own
                .ok()
                .flatten()
                .and_then(|own| artefact.remove_from(&own).ok());
            found.extend(removed.map(|removed| (removed.before, removed.after)));
        }
    }
    found
}

fn repeatable(repeats: &Devices) -> Result<Finding, ReplayError> {
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let (found, _) = repeatability(repeats, band, &[])?;
    let largest = |pairs: Option<&PairDistances>| {
        pairs.map_or((f64::NAN, String::new()), |pairs| {
            (pairs.largest_db_rms, pairs.largest_in.clone())
        })
    };
    let ((lying, least_steady), (put_back, moved_most)) = (
        largest(found.lying.as_ref()),
        largest(found.put_back.as_ref()),
    );
    Ok(Finding::of(
        6,
        Holds::all([at_most(
            most([lying, put_back]),
            1.0,
            "dB",
            "two measurements of some participant differ by more",
        )]),
        format!(
            "over 20–1000 Hz and {} participants, any two of three measurements without moving the finger differ by at most \
                {lying:.2} dB rms ({least_steady}), and any two with the finger repositioned by at most {put_back:.2} dB \
                ({moved_most})",
            repeats.participants().len()
        ),
    ))
}

fn coherent(devices: &Devices, repeats: &Devices) -> Finding {
    let band = Band::new(Hertz(25.0), Hertz(950.0)).ok();
    let moved = |entry: &&Entry<Drive, Acceleration>| entry.filing.placement > 1;
    let all = || {
        let repositioned = repeats.entries().iter().filter(moved);
        devices
            .entries()
            .iter()
            .chain(repositioned)
            .map(|entry| &entry.function)
    };
    let lowest = least(all().map(|r| {
        let summary = band.and_then(|band| r.coherence_in(band));
        summary.map_or(f64::NAN, |summary| summary.lowest)
    }));
    let at_5_hz = most(all().map(|r| {
        let k = (5.0 / r.resolution_hz()).round() as usize;
        r.coherence().get(k).copied().unwrap_or(f64::NAN)
    }));
    Finding::of(
        7,
        Holds::all([
            above(lowest, 0.95, "", "it falls below 0.95 within 25–950 Hz"),
            below(at_5_hz, 0.9, "", "it is above 0.9 at 5 Hz"),
        ]),
        format!(
            "at least {lowest:.3} over 25–950 Hz, at most {at_5_hz:.2} at 5 Hz, over {} measurements on the device: all \
                participants, loads and angles",
            all().count()
        ),
    )
}

/// Magnitudes in one frame.
fn drawn(
    number: &'static str,
    caption: &str,
    unit: &str,
    lines: Vec<(String, Vec<(f64, f64)>)>,
) -> Counterpart {
    Counterpart::chart(
        number,
        caption,
        (frequency(), linear(format!("magnitude, dB re 1 {unit}"))),
        lines
            .into_iter()
            .map(|(label, points)| line(label, points))
            .collect(),
    )
}

/// A person's own average in one condition, as it is drawn.
fn shown<I: Quantity>(
    panel: &Panel<I, Acceleration>,
    who: &str,
    at: Cell,
    [low_hz, high_hz]: [f64; 2],
) -> Result<Vec<(f64, f64)>, ReplayError> {
    let own = panel.person(who, at, BundleAverage::LogMagnitude)?;
    Ok(own.map_or(Vec::new(), |own| levels(&own, low_hz, high_hz)))
}

/// One line with its name.
type Named = (String, Vec<(f64, f64)>);

fn figures(
    laboratory: &Laboratory,
    control: &TransferFunction<Potential, Acceleration>,
    fingers: &Fingers,
    devices: &Devices,
    repeats: &Devices,
) -> Result<Vec<Counterpart>, ReplayError> {
    const INERTANCE: &str = "(m/s²)/N";
    const DEVICE: &str = "(m/s²)/full scale";
    const ALL_HZ: [f64; 2] = [20.0, 1000.0];
    const NEAR_HZ: [f64; 2] = [200.0, 340.0];
    let flat = |load_n: f64| cell(load_n, ANGLES_DEG[0]);
    let first = pseudonym(laboratory, 1);
    let at = |load_n: f64| -> Result<Vec<Named>, ReplayError> {
        let people = fingers.participants().iter();
        people
            .map(|who| Ok((who.clone(), shown(fingers, who, flat(load_n), ALL_HZ)?)))
            .collect()
    };
    let everybody = |range: [f64; 2]| -> Result<Vec<Named>, ReplayError> {
        let mut lines = Vec::new();
        for who in fingers.participants() {
            for at in fingers.cells() {
                lines.push((String::new(), shown(fingers, who, *at, range)?));
            }
        }
        Ok(lines)
    };
    let over_loads = |angle_deg: f64| -> Result<Vec<Named>, ReplayError> {
        LOADS_N
            .into_iter()
            .map(|load_n| {
                let lines = shown(devices, &first, cell(load_n, angle_deg), ALL_HZ)?;
                Ok((format!("{load_n} N"), lines))
            })
            .collect()
    };
    let one = LOADS_N
        .into_iter()
        .map(|load_n| {
            Ok((
                format!("{load_n} N"),
                shown(fingers, &first, flat(load_n), ALL_HZ)?,
            ))
        })
        .collect::<Result<Vec<Named>, ReplayError>>()?;
    let mut figures = vec![
        drawn(
            "67a",
            "The finger alone, five participants at 0.2 N.",
            INERTANCE,
            at(0.2)?,
        ),
        drawn("67b", "The same at 0.4 N.", INERTANCE, at(0.4)?),
        drawn("67c", "The same at 0.6 N.", INERTANCE, at(0.6)?),
        drawn(
            "67d",
            "All participants at all loads.",
            INERTANCE,
            everybody(ALL_HZ)?,
        ),
        drawn(
            "70a",
            "The finger of participant 1 at three loads.",
            INERTANCE,
            one,
        ),
        drawn(
            "71a",
            "The control measurement: the accelerometer on the plate.",
            "(m/s²)/V",
            vec![(String::new(), levels(control, ALL_HZ[0], ALL_HZ[1]))],
        ),
        drawn(
            "71b",
            "All fingers around the antiresonance of the bench.",
            INERTANCE,
            everybody(NEAR_HZ)?,
        ),
        drawn(
            "74a",
            "The device with the finger of participant 1 at three loads, 20°.",
            DEVICE,
            over_loads(ANGLES_DEG[0])?,
        ),
        drawn(
            "74b",
            "The same at 40°.",
            DEVICE,
            over_loads(ANGLES_DEG[1])?,
        ),
    ];
    for (number, load_n) in [("75a", 0.2), ("75b", 0.4), ("75c", 0.6)] {
        let both = ANGLES_DEG
            .into_iter()
            .map(|angle_deg| {
                let lines = shown(devices, &first, cell(load_n, angle_deg), ALL_HZ)?;
                Ok((format!("{angle_deg}°"), lines))
            })
            .collect::<Result<Vec<Named>, ReplayError>>()?;
        let caption =
            format!("The device with the finger of participant 1 at two angles, {load_n} N.");
        figures.push(drawn(number, &caption, DEVICE, both));
    }
    let named = |entry: &Entry<Drive, Acceleration>| match entry.filing {
        Filing {
            placement: 1,
            repeat,
            ..
        } => format!("not moved, {repeat}"),
        Filing { placement, .. } => format!("repositioned, {}", placement - 1),
    };
    let all = || {
        repeats
            .entries()
            .iter()
            .filter(|e| e.filing.participant == first)
    };
    let repeated = all().map(|e| (named(e), levels(&e.function, ALL_HZ[0], ALL_HZ[1])));
    figures.push(drawn(
        "78a",
        "Six measurements of one finger: three without moving it, three with the finger repositioned.",
        DEVICE,
        repeated.collect(),
    ));
    figures.push(Counterpart::chart(
        "78b",
        "The coherence of these six measurements.",
        (frequency(), linear("coherence")),
        all()
            .map(|entry| {
                let f = &entry.function;
                let points = f
                    .frequencies_hz()
                    .into_iter()
                    .zip(f.coherence().iter().copied());
                let within = points.filter(|(hz, _)| *hz <= ALL_HZ[1]).collect();
                line(named(entry), within)
            })
            .collect(),
    ));
    Ok(figures)
}
