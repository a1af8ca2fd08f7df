//! Chapter 6: three surfaces touched freely by ten people, and the forces on the device in two tasks.

use piezotact::Doubt;
use piezotact::compare::CompareDoubt;
use piezotact::compare::{Periods, Sliding, SpatialPeriod, Summary, spatial_period};
use piezotact::feature::Analysis;
use piezotact::figure::Line;
use piezotact::quantity::{Acceleration, Drive, Force, Hertz};
use piezotact::recording::Recording;
use piezotact::series::Series;
use piezotact::statistics::{PairedDifference, mean, paired_difference};

use super::claims::{
    Finding, Holds, above, at_most, least as smallest, most as largest, no_exception,
};
use super::figure::{Counterpart, decibels, density, frequency, line, linear, names, over_names};
use super::measured::{Taken, analysed, run, take};
use super::rendering::{device, played, resting, sent_straight, target};
use super::{Chapter, Replay, ReplayError, said_once};
use piezotact_bench::ProcedureError;
use piezotact_bench::procedure::FORCE_CHANNEL;
use piezotact_twin::{ActTouch, ActiveProtocol, Movement, Pace, Participant, TriboAir};

/// Who takes part (*thesis* 6.2).
const PARTICIPANTS: u64 = 10;
/// The surfaces: rough, biomimetic, smooth.
const SURFACES: [&str; 3] = ["M8", "BIO", "M3"];
const STROKES: usize = 12;
/// Lines 2.4 Hz apart for levels and speeds; 1.2 Hz for combs, whose teeth are 14–70 Hz apart and whose strokes are
/// long enough up to 50 mm/s.
const SEGMENT: usize = 2_048;
const FINE: usize = 4_096;
/// The wavelength of M8, m (*thesis* Table 2).
const WAVELENGTH_M: f64 = 0.716e-3;
/// Speeds of passive touch, m/s.
const SPEEDS_M_S: [f64; 3] = [0.01, 0.02, 0.03];
const CAMPAIGNS: &str = "discrimination experiments";
const BRAIN: &str = "EEG analysis";

/// One person on one surface.
struct Free {
    participant: u64,
    surface: &'static str,
    taken: Taken,
    summary: Summary,
    /// With finer lines.
    fine: Analysis,
    target: Series<Acceleration>,
}

pub(super) fn chapter6(replay: &Replay) -> Result<Chapter, ReplayError> {
    let free = touched(replay)?;
    let period = passive(replay)?;
    let tasks = tasks(replay, &free)?;
    let findings = vec![
        harmonics(&free, period.as_ref()),
        different(&free),
        forces(&free, &tasks),
        Finding::not_yet(32, CAMPAIGNS),
        Finding::not_yet(33, BRAIN),
    ];
    Ok(Chapter {
        number: 6,
        title: "Free touch of three surfaces, and the device",
        measured: vec![
            format!("Participants 1 to {PARTICIPANTS} stroked M8 (rough), the biomimetic sample and M3 (smooth) {STROKES} times each at their own speed and force."),
            "On the device each held the finger for the rendering of every surface in two tasks; M8 was touched passively at 10, 20 and 30 mm/s by the reference participant.".into(),
        ],
        findings,
        doubts: said_once(
            free.iter()
                .flat_map(|one| one.taken.doubts.iter().map(|d| (one.surface, d)))
                .chain(period.iter().flat_map(|p| p.doubts.iter().map(|d| ("M8, passive", d)))),
        ),
        figures: figures(&free),
        missing: vec![
            "Figure 88 (the surfaces): the command `twin surface M8` of piezotact writes their height maps.".into(),
            "Figure 92 (recorded and rendered): the same verification as figures 47 and 48.".into(),
            "Figures 94 and 95 (discrimination experiments) and figures 96 and 97 (EEG), which the program does not contain \
                yet.".into(),
        ],
    })
}

fn touched(replay: &Replay) -> Result<Vec<Free>, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=PARTICIPANTS {
        for surface in SURFACES {
            let person = Participant::of(participant, replay.seed, &replay.parameters);
            let protocol = ActiveProtocol {
                strokes: STROKES,
                movement: Movement::Proximal,
                pace: Pace::Free,
            };
            let sample = replay.parameters.sample(surface)?;
            let bench = ActTouch::new(&replay.parameters, person, sample, protocol)?;
            let (taken, recording) = take(
                bench.into_acquirer(),
                &run(replay, "chapter 6", None),
                SEGMENT,
            )?;
            all.push(Free {
                participant,
                surface,
                summary: taken.summary(surface, Periods::default())?,
                target: target(&taken, &recording)?,
                fine: analysed(&recording, &taken.segmentation, FINE)?,
                taken,
            });
        }
    }
    Ok(all)
}

/// The spatial period of M8 from passive touch at three speeds.
fn passive(replay: &Replay) -> Result<Option<SpatialPeriod>, ReplayError> {
    let mut vibrations = Vec::new();
    for speed_m_s in SPEEDS_M_S {
        let person = Participant::of(0, replay.seed, &replay.parameters);
        let sample = replay.parameters.sample("M8")?;
        let bench = TriboAir::new(&replay.parameters, person, sample, 6, speed_m_s)?;
        let (taken, recording) = take(
            bench.into_acquirer(),
            &run(replay, "chapter 6", Some(0.2)),
            SEGMENT,
        )?;
        let speed = taken.analysis.speed_m_s().unwrap_or(speed_m_s);
        let vibration = recording
            .series::<Acceleration>(None)
            .map_err(ProcedureError::from)?;
        vibrations.push((speed, taken, vibration));
    }
    let slidings: Vec<Sliding<'_>> = vibrations
        .iter()
        .map(|(speed_m_s, taken, vibration)| Sliding {
            group: String::new(),
            speed_m_s: *speed_m_s,
            rate: vibration.rate(),
            stretches: taken
                .segmentation
                .strokes
                .iter()
                .map(|stroke| stroke.steady.of(vibration.samples()))
                .collect(),
        })
        .collect();
    Ok(spatial_period(&slidings, Hertz(7.5)))
}

/// The mean force on the device in the two tasks, N, for every person: over the three surfaces.
fn tasks(replay: &Replay, free: &[Free]) -> Result<[Vec<f64>; 2], ReplayError> {
    let mut forces = [Vec::new(), Vec::new()];
    for participant in 1..=PARTICIPANTS {
        let mut bench = device(replay, participant);
        for (task, forces) in ["control", "imagery"].iter().zip(&mut forces) {
            let mut theirs = Vec::new();
            for one in free.iter().filter(|one| one.participant == participant) {
                let [_, drive] = sent_straight(&mut bench, &one.target)?;
                let run = resting(&format!("{task} {}", one.surface), 0.2, 20.0);
                theirs.push(held_n(&mut bench, &drive, &run)?);
            }
            forces.push(mean(&theirs));
        }
    }
    Ok(forces)
}

fn held_n(
    bench: &mut piezotact_bench::Bench,
    drive: &Series<Drive>,
    run: &piezotact_bench::RunPlan,
) -> Result<f64, ReplayError> {
    let recording: Recording = played(bench, drive, run)?;
    let force = recording
        .series::<Force>(Some(FORCE_CHANNEL))
        .map_err(ProcedureError::from)?;
    Ok(mean(force.samples()))
}

fn of<'a>(free: &'a [Free], surface: &'a str) -> impl Iterator<Item = &'a Free> {
    free.iter().filter(move |one| one.surface == surface)
}

/// What a single person's strokes over M8 say: the speed that their strongest line speaks for, m/s, and how many of
/// the harmonics 2–6 within 50–400 Hz stand above the valleys beside them by 1.5 dB: three standard errors of a hundred
/// and more independent lines in each.
///
/// Speeds differ from stroke to stroke, so spectra are averaged over multiples of each stroke's strongest line.
fn comb(one: &Free) -> (f64, usize) {
    let centres = |analysis: &Analysis| -> Vec<f64> {
        let psd = &analysis.psd;
        let strokes = analysis.strokes.iter().zip(&psd.each);
        strokes
            .map(|(stroke, psd_of)| centre_hz(psd_of, psd.resolution_hz, stroke.strongest_hz))
            .collect()
    };
    let psd = &one.fine.psd;
    let fundamentals = centres(&one.fine);
    // The mean level within a tenth of an order.
    let around = |order: f64| -> f64 {
        let levels = psd.each.iter().zip(&fundamentals).flat_map(|(psd_of, hz)| {
            let line = |order: f64| (order * hz / psd.resolution_hz).round() as usize;
            let power = |k: usize| psd_of.get(k).copied().unwrap_or(0.0);
            (line(order - 0.1)..=line(order + 0.1)).map(power)
        });
        mean(&levels.collect::<Vec<f64>>())
    };
    let usual_hz = mean(&fundamentals);
    let shown = (2..=6)
        .map(f64::from)
        .filter(|order| (50.0..=400.0).contains(&(order * usual_hz)))
        .filter(|order| {
            // Between its valleys a spectrum that merely falls lies at their geometric mean.
            let valleys = (around(order - 0.5) * around(order + 0.5)).sqrt();
            around(*order) > 1.41 * valleys
        })
        .count();
    let mut all = centres(&one.taken.analysis);
    all.sort_by(f64::total_cmp);
    let middle = all.get(all.len() / 2);
    (middle.map_or(f64::NAN, |hz| hz * WAVELENGTH_M), shown)
}

/// The centre of power within a tenth of the strongest line, Hz: a peak of many lines has its middle there.
fn centre_hz(psd: &[f64], step_hz: f64, strongest_hz: f64) -> f64 {
    let lines = (0.9 * strongest_hz / step_hz).round() as usize
        ..=(1.1 * strongest_hz / step_hz).round() as usize;
    let power = |k: usize| psd.get(k).copied().unwrap_or(0.0);
    let (sum, first) = lines.fold((0.0, 0.0), |(sum, first), k| {
        (sum + power(k), first + power(k) * k as f64 * step_hz)
    });
    if sum > 0.0 { first / sum } else { strongest_hz }
}

fn harmonics(free: &[Free], passive: Option<&SpatialPeriod>) -> Finding {
    let combs: Vec<(f64, usize)> = of(free, "M8").map(comb).collect();
    let slowest = smallest(combs.iter().map(|c| c.0));
    let fastest = largest(combs.iter().map(|c| c.0));
    let least = combs.iter().map(|c| c.1).min().unwrap_or(0);
    let most = combs.iter().map(|c| c.1).max().unwrap_or(0);
    let without: Vec<String> = of(free, "M8")
        .zip(&combs)
        .filter(|(_, comb)| comb.1 == 0)
        .map(|(one, _)| format!("P{:02}", one.participant))
        .collect();
    let no_harmonic = format!(
        "no harmonic is three standard errors above the background for {}, whose speed varies within strokes",
        if without.is_empty() {
            "some participant".into()
        } else {
            without.join(", ")
        }
    );
    let period = passive.map_or(f64::NAN, |found| found.period_m);
    let doubted = passive.is_none_or(|found| {
        let unsure =
            |doubt: &Doubt| matches!(doubt.kind(), Some(CompareDoubt::NoCommonPeriod { .. }));
        found.doubts.iter().any(unsure)
    });
    Finding::of(
        29,
        Holds::all([
            at_most(
                (period / WAVELENGTH_M - 1.0).abs(),
                0.03,
                "",
                "where the speed is known, the period is different",
            ),
            no_exception(
                usize::from(doubted),
                "where the speed is known, no period is clear",
            ),
            no_exception(
                1 - usize::from(slowest >= 0.01 && fastest <= 0.05),
                "for some participant, the comb indicates a speed outside 10–50 mm/s",
            ),
            no_exception(without.len(), no_harmonic.as_str()),
        ]),
        format!(
            "passive: period {:.3} mm; free: strongest line times 0.716 mm {:.0}–{:.0} mm/s over {} participants; {least} \
                to {most} of the harmonics 2–6 of this line in the spectrum of each participant",
            period * 1e3,
            slowest * 1e3,
            fastest * 1e3,
            combs.len()
        ),
    )
}

fn different(free: &[Free]) -> Finding {
    let values = |surface: &'static str, value: fn(&Summary) -> f64| -> Vec<f64> {
        of(free, surface).map(|one| value(&one.summary)).collect()
    };
    let level = |s: &Summary| s.rms.mean;
    let centroid = |s: &Summary| s.centroid_hz.mean;
    let everybody = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a > b);
    let (rough, bio, smooth) = (
        values("M8", level),
        values("BIO", level),
        values("M3", level),
    );
    let [rough_hz, bio_hz, smooth_hz] = SURFACES.map(|surface| values(surface, centroid));
    let louder = bio
        .iter()
        .zip(&rough)
        .filter(|(bio, rough)| bio > rough)
        .count();
    Finding::of(
        30,
        Holds::all([
            no_exception(
                1 - usize::from(everybody(&rough, &smooth) && everybody(&bio, &smooth)),
                "M3 does not have the lowest level for every participant",
            ),
            no_exception(
                1 - usize::from(everybody(&smooth_hz, &rough_hz) && everybody(&smooth_hz, &bio_hz)),
                "the centroid of M3 is not the highest for every participant",
            ),
            no_exception(
                1 - usize::from(louder > 0 && louder < rough.len()),
                "M8 and BIO have the same order for every participant",
            ),
        ]),
        format!(
            "mean rms M8 {:.2}, BIO {:.2}, M3 {:.2} m/s²; centroids {:.0}, {:.0}, {:.0} Hz; BIO has the higher level \
                for {louder} of {}",
            mean(&rough),
            mean(&bio),
            mean(&smooth),
            mean(&rough_hz),
            mean(&bio_hz),
            mean(&smooth_hz),
            rough.len()
        ),
    )
}

fn forces(free: &[Free], tasks: &[Vec<f64>; 2]) -> Finding {
    let over = |surface: &str, value: fn(&Summary) -> Option<f64>| {
        mean(
            &of(free, surface)
                .filter_map(|one| value(&one.summary))
                .collect::<Vec<f64>>(),
        )
    };
    let force = |s: &Summary| Some(s.normal_force_n?.mean);
    let friction = |s: &Summary| Some(s.friction_coefficient?.mean);
    let [rough_n, bio_n, smooth_n] = SURFACES.map(|surface| over(surface, force));
    let [rough, bio, smooth] = SURFACES.map(|surface| over(surface, friction));
    let paired = paired_difference(&tasks[0], &tasks[1]);
    let p = paired.map_or(f64::NAN, |d: PairedDifference| d.p_value);
    Finding::of(
        31,
        Holds::all([
            no_exception(
                1 - usize::from(bio_n > rough_n && bio_n > smooth_n),
                "the biomimetic sample is not pressed hardest",
            ),
            at_most(
                (rough / smooth - 1.0).abs(),
                0.1,
                "",
                "M3 and M8 differ in friction",
            ),
            no_exception(
                1 - usize::from(rough.min(smooth) >= 1.5 * bio),
                "their friction is less than 1.5 times that of BIO",
            ),
            above(p, 0.05, "", "the tasks differ in force"),
        ]),
        format!(
            "force M8 {rough_n:.2}, BIO {bio_n:.2}, M3 {smooth_n:.2} N; friction {rough:.2}, {bio:.2}, {smooth:.2}; imagery − \
                control {:+.1} mN, p = {p:.2} ({} participants; the task has no influence on the force of the twin)",
            paired.map_or(f64::NAN, |d| d.mean * 1e3),
            tasks[0].len()
        ),
    )
}

fn figures(free: &[Free]) -> Vec<Counterpart> {
    let spectrum = |label: String, summary: &Summary| {
        let points = decibels(&summary.psd.mean, summary.psd.resolution_hz, 10.0, 600.0);
        line(label, points)
    };
    let frame = |number: &'static str, caption: String, lines: Vec<Line>| {
        Counterpart::chart(number, caption, (frequency(), density()), lines)
    };
    let mut figures = Vec::new();
    for (number, participant) in [("89a", 1), ("89b", 2), ("89c", 3)] {
        let theirs = free.iter().filter(|one| one.participant == participant);
        let lines = theirs
            .map(|one| spectrum(one.surface.to_owned(), &one.summary))
            .collect();
        figures.push(frame(
            number,
            format!(
                "The three surfaces under the finger of participant {participant}, freely touched."
            ),
            lines,
        ));
    }
    for (number, surface) in [("90a", "M8"), ("90b", "BIO"), ("90c", "M3")] {
        let lines = of(free, surface)
            .map(|one| spectrum(format!("P{:02}", one.participant), &one.summary))
            .collect();
        figures.push(frame(
            number,
            format!("{surface} touched freely by all participants: mean PSDs."),
            lines,
        ));
    }
    let strokes = of(free, "M8").take(3).filter_map(|one| {
        let psd = &one.taken.analysis.psd;
        let points = decibels(psd.each.first()?, psd.resolution_hz, 10.0, 500.0);
        Some(line(format!("P{:02}", one.participant), points))
    });
    figures.push(frame(
        "91",
        "Single strokes over M8: the harmonics of its wavelength.".into(),
        strokes.collect(),
    ));
    let by_surface = |value: fn(&Summary) -> Option<f64>| -> Vec<Line> {
        let one = |participant: u64| {
            let theirs = free.iter().filter(|one| one.participant == participant);
            let values = theirs.filter_map(|one| value(&one.summary));
            over_names(&format!("P{participant:02}"), values)
        };
        (1..=PARTICIPANTS).map(one).collect()
    };
    for (number, caption, label, lines) in [
        (
            "93a",
            "Normal force of free touch.",
            "force, N",
            by_surface(|s| Some(s.normal_force_n?.mean)),
        ),
        (
            "93b",
            "Friction coefficient of free touch.",
            "friction coefficient",
            by_surface(|s| Some(s.friction_coefficient?.mean)),
        ),
    ] {
        figures.push(Counterpart::chart(
            number,
            caption,
            (
                names("surface", SURFACES.iter().map(|s| (*s).to_owned())),
                linear(label),
            ),
            lines,
        ));
    }
    figures
}
