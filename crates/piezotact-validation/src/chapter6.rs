//! Chapter 6: three surfaces touched freely by ten people, the forces on the device in two tasks, and the EEG in all three.

use piezotact::Warning;
use piezotact::compare::{Periods, Sliding, SpatialPeriod, Summary, spatial_period};
use piezotact::figure::Line;
use piezotact::quantity::{Acceleration, Force, Hertz};
use piezotact::recording::Recording;
use piezotact::series::Series;
use piezotact::statistics::{PairedDifference, mean, paired_difference};
use piezotact::verify::Verification;

use super::brain::brains;
use super::claims::{
    Finding, Holds, above, at_least, at_most, below, least as smallest, most as largest,
    no_exception,
};
use super::comb::{Comb, band_peak, comb_of};
use super::figure::{
    Counterpart, decibels, density, frequency, line, linear, names, over_names, share_scales,
    side_by_side,
};
use super::measured::summary;
use super::rendering::{compared, played, rendered, target};
use super::{Chapter, ReplayError, campaigns, said_once};
use piezotact_bench::ProcedureError;
use piezotact_bench::procedure::FORCE_CHANNEL;
use piezotact_twin::{ActTouch, ActiveProtocol, Pace, Participant, SlidingDirection, TriboAir};
use piezotact_volunteers::{Laboratory, Taken, characterised, resting, run, take};

/// Who takes part (*thesis* 6.2).
const PARTICIPANTS: u64 = 10;
/// The surfaces: rough, biomimetic, smooth.
const SURFACES: [&str; 3] = ["M8", "BIO", "M3"];
const STROKES: usize = 12;
/// Lines 2.4 Hz apart.
const SEGMENT: usize = 2_048;
/// The wavelength of M8, m (*thesis* Table 2).
const WAVELENGTH_M: f64 = 0.716e-3;
/// Speeds of passive touch, m/s.
const SPEEDS_M_S: [f64; 3] = [0.01, 0.02, 0.03];
/// How long everybody's device is excited at random for the transfer function, s.
const CHARACTERISE_S: f64 = 20.0;
const TASKS: [&str; 2] = ["control", "imagery"];
/// Where the thesis sees the first definite peak, Hz, and how far it must stand above its surroundings, dB.
const PEAK_HZ: [f64; 2] = [70.0, 110.0];
const PEAK_DB: f64 = 3.0;

/// One person on one surface.
struct Free {
    participant: u64,
    surface: &'static str,
    taken: Taken,
    summary: Summary,
    target: Series<Acceleration>,
}

pub(super) fn chapter6(laboratory: &Laboratory) -> Result<Chapter, ReplayError> {
    let free = touched(laboratory)?;
    let period = passive(laboratory)?;
    let Tasks {
        forces_n,
        softest_db,
        warnings,
        figure,
    } = tasks(laboratory, &free)?;
    let campaigns = campaigns::of_chapter_6(laboratory)?;
    let brains = brains(laboratory, SURFACES).map_err(|error| format!("EEG: {error}"))?;
    let mut findings = vec![
        harmonics(&free, period.as_ref()),
        different(&free),
        forces(&free, &forces_n),
    ];
    findings.extend(campaigns.findings);
    findings.push(peaks(&free));
    findings.extend(brains.findings);
    findings.sort_by_key(|finding| finding.claim);
    Ok(Chapter {
        number: 6,
        title: "Free touch of three surfaces, the device, and the EEG",
        measured: vec![
            format!("Participants 1 to {PARTICIPANTS} stroked M8 (rough), the biomimetic sample and M3 (smooth) {STROKES} times each at their own speed and force."),
            format!("The device was characterised with each finger ({CHARACTERISE_S} s of random drive, 20°, 0.2 N). One stroke over every surface was rendered with that transfer function and played in two tasks, at a level lower by at most {:.1} dB where it exceeded the limits of the device.", softest_db.abs()),
            "M8 was touched passively at 10, 20 and 30 mm/s by the reference participant.".into(),
        ]
        .into_iter()
        .chain(campaigns.measured)
        .chain(brains.measured)
        .collect(),
        findings,
        warnings: said_once(
            free.iter()
                .flat_map(|one| one.taken.warnings.iter().map(|d| (one.surface, d)))
                .chain(period.iter().flat_map(|p| p.warnings.iter().map(|d| ("M8, passive", d))))
                .chain(warnings.iter().map(|(surface, d)| (*surface, d)))
                .chain(brains.warnings.iter().map(|d| ("EEG", d))),
        ),
        figures: figures(&free)
            .into_iter()
            .chain(figure)
            .chain(campaigns.figures)
            .chain(brains.figures)
            .collect(),
        missing: vec![
            "Figure 88 (the surfaces): the command `twin surface M8` of piezotact writes their height maps.".into(),
            "Figure 94 draws the matrices of figure 95 as columns in space: the same numbers.".into(),
            "Figure 96 shows sources of the cortex, which the program does not compute; its counterpart shows electrodes.".into(),
        ],
    })
}

fn touched(laboratory: &Laboratory) -> Result<Vec<Free>, ReplayError> {
    let mut all = Vec::new();
    for participant in 1..=PARTICIPANTS {
        for surface in SURFACES {
            let person = Participant::of(participant, laboratory.seed, &laboratory.parameters);
            let protocol = ActiveProtocol {
                strokes: STROKES,
                movement: SlidingDirection::Proximal,
                pace: Pace::Free,
            };
            let sample = laboratory.parameters.sample(surface)?;
            let bench = ActTouch::new(&laboratory.parameters, person, sample, protocol)?;
            let (taken, recording) = take(
                bench.into_acquirer(),
                &run(laboratory, "chapter 6", None),
                SEGMENT,
            )?;
            all.push(Free {
                participant,
                surface,
                summary: summary(&taken, surface, Periods::default())?,
                target: target(&taken, &recording)?,
                taken,
            });
        }
    }
    Ok(all)
}

/// The spatial period of M8 from passive touch at three speeds.
fn passive(laboratory: &Laboratory) -> Result<Option<SpatialPeriod>, ReplayError> {
    let mut vibrations = Vec::new();
    for speed_m_s in SPEEDS_M_S {
        let person = Participant::of(0, laboratory.seed, &laboratory.parameters);
        let sample = laboratory.parameters.sample("M8")?;
        let bench = TriboAir::new(&laboratory.parameters, person, sample, 6, speed_m_s)?;
        let (taken, recording) = take(
            bench.into_acquirer(),
            &run(laboratory, "chapter 6", Some(0.2)),
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

/// What was measured on the device.
struct Tasks {
    /// The mean force, N: by task, by surface, of every person.
    forces_n: [[Vec<f64>; 3]; 2],
    /// The lowest level of a rendering re its target, dB.
    softest_db: f64,
    warnings: Vec<(&'static str, Warning)>,
    figure: Option<Counterpart>,
}

/// Everybody's own strokes, rendered with everybody's own transfer function and played in both tasks.
fn tasks(laboratory: &Laboratory, free: &[Free]) -> Result<Tasks, ReplayError> {
    let mut tasks = Tasks {
        forces_n: Default::default(),
        softest_db: 0.0,
        warnings: Vec::new(),
        figure: None,
    };
    for participant in 1..=PARTICIPANTS {
        let mut bench = laboratory.device(participant);
        let asked = resting("characterise", 0.2, 20.0);
        let function = characterised(&mut bench, asked, CHARACTERISE_S, laboratory.seed)?;
        for (place, surface) in SURFACES.into_iter().enumerate() {
            let Some(one) = of(free, surface).find(|one| one.participant == participant) else {
                continue;
            };
            let (drive, level) = rendered(&one.target, &function)?;
            tasks.softest_db = tasks.softest_db.min(level.0);
            let warnings = drive.about.warnings.iter().cloned();
            tasks
                .warnings
                .extend(warnings.map(|warning| (surface, warning)));
            let mut verified = Vec::new();
            for (task, forces_n) in TASKS.into_iter().zip(&mut tasks.forces_n) {
                let run = resting(&format!("{task} {surface}"), 0.2, 20.0);
                let recording = played(&mut bench, &drive.drive, &run)?;
                forces_n[place].push(held_n(&recording)?);
                if participant == 1 && tasks.figure.is_none() {
                    verified.push((task, compared(&one.target, &recording, level)?));
                }
            }
            if tasks.figure.is_none() {
                tasks.figure = Some(rendered_figure(surface, &verified));
            }
        }
    }
    Ok(tasks)
}

/// Figure 92: a stroke, and what the finger does in the two tasks.
fn rendered_figure(surface: &str, verified: &[(&str, Verification)]) -> Counterpart {
    let spectrum = |label: &str, of: &Verification, psd: &[f64]| {
        let step_hz = of.frequency_hz.get(1).copied().unwrap_or(1.0);
        line(label, decibels(psd, step_hz, 10.0, 600.0))
    };
    let touched = verified
        .first()
        .map(|(_, of)| spectrum("touched", of, &of.target_psd));
    let tasks = verified
        .iter()
        .map(|(task, of)| spectrum(task, of, &of.measured_psd));
    Counterpart::chart(
        "92",
        format!(
            "{surface} under the finger of participant 1: one stroke, and its rendering as measured in the two tasks."
        ),
        (frequency(), density()),
        touched.into_iter().chain(tasks).collect(),
    )
}

fn held_n(recording: &Recording) -> Result<f64, ReplayError> {
    let force = recording
        .series::<Force>(Some(FORCE_CHANNEL))
        .map_err(ProcedureError::from)?;
    Ok(mean(force.samples()))
}

fn of<'a>(free: &'a [Free], surface: &'a str) -> impl Iterator<Item = &'a Free> {
    free.iter().filter(move |one| one.surface == surface)
}

fn harmonics(free: &[Free], passive: Option<&SpatialPeriod>) -> Finding {
    let combs: Vec<(u64, Comb)> = of(free, "M8")
        .map(|one| (one.participant, comb_of(&one.taken.analysis.psd)))
        .collect();
    let speeds = || combs.iter().map(|(_, comb)| comb.spacing_hz * WAVELENGTH_M);
    let (slowest, fastest) = (smallest(speeds()), largest(speeds()));
    let counts = || combs.iter().map(|(_, comb)| comb.harmonics);
    let few: Vec<String> = combs
        .iter()
        .filter(|(_, comb)| comb.harmonics < 2)
        .map(|(who, _)| format!("P{who:02}"))
        .collect();
    let few = match &few[..] {
        [] => String::new(),
        few => format!(" (fewer than two: {})", few.join(", ")),
    };
    let period = passive
        .filter(|found| found.is_common())
        .map_or("no clear period".into(), |found| {
            format!("period {:.3} mm", found.period_m * 1e3)
        });
    Finding::of(
        29,
        Holds::all([
            at_least(
                counts().min().map_or(f64::NAN, |least| least as f64),
                2.0,
                "",
                "fewer than two harmonics stand out for some participant",
            ),
            at_least(
                slowest * 1e3,
                10.0,
                "mm/s",
                "for some participant, the comb indicates a speed below 10 mm/s",
            ),
            at_most(
                fastest * 1e3,
                50.0,
                "mm/s",
                "for some participant, the comb indicates a speed above 50 mm/s",
            ),
        ]),
        format!(
            "free: spacing of the comb times 0.716 mm {:.0}–{:.0} mm/s over {} participants, {} to {} harmonics within 50–400 Hz \
                in the spectrum of each{few}; passive, where the speed is known: {period}",
            slowest * 1e3,
            fastest * 1e3,
            combs.len(),
            counts().min().unwrap_or(0),
            counts().max().unwrap_or(0),
        ),
    )
}

fn peaks(free: &[Free]) -> Finding {
    // Without a local maximum there is no peak: 0 dB.
    let height = |one: &Free| band_peak(&one.summary.psd, PEAK_HZ).map_or(0.0, |p| p.prominence_db);
    let heights = |surface: &'static str| -> Vec<f64> { of(free, surface).map(height).collect() };
    let [rough, bio, smooth] = SURFACES.map(heights);
    let with = |heights: &[f64]| heights.iter().filter(|db| **db >= PEAK_DB).count();
    let least = |heights: &[f64]| smallest(heights.iter().copied());
    Finding::of(
        36,
        Holds::all([
            at_least(
                least(&rough),
                PEAK_DB,
                "dB",
                "on M8, some participant shows no peak between 70 and 110 Hz: those of its comb are v/0.716 mm apart, 45 to 60 Hz, and can \
                    lie on either side of the band; without a local maximum the prominence is 0 dB",
            ),
            at_least(
                least(&bio),
                PEAK_DB,
                "dB",
                "on BIO, some participant shows no peak between 70 and 110 Hz: the peak is at v/λ, and λ alone has a spread of 13 % in the population, \
                    so that at one common speed one person in eleven is outside the band; without a local maximum the prominence is 0 dB",
            ),
            below(
                largest(smooth.iter().copied()),
                PEAK_DB,
                "dB",
                "on M3, some participant shows a peak between 70 and 110 Hz: its broad spectrum bends there by 2 dB, and the noise of twelve \
                    strokes adds to it",
            ),
        ]),
        format!(
            "prominence of the highest peak between 70 and 110 Hz (0 dB where there is none): M8 {:.1} to {:.1} dB ({} of {} participants ≥ {PEAK_DB} \
                dB), BIO {:.1} to {:.1} dB ({}), M3 {:.1} to {:.1} dB ({})",
            least(&rough),
            largest(rough.iter().copied()),
            with(&rough),
            rough.len(),
            least(&bio),
            largest(bio.iter().copied()),
            with(&bio),
            least(&smooth),
            largest(smooth.iter().copied()),
            with(&smooth),
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

/// Everybody's mean over several conditions.
fn over_all<'a>(conditions: impl Iterator<Item = &'a Vec<f64>> + Clone) -> Vec<f64> {
    let people = conditions.clone().map(Vec::len).min().unwrap_or(0);
    let person = |i: usize| {
        mean(
            &conditions
                .clone()
                .map(|forces| forces[i])
                .collect::<Vec<f64>>(),
        )
    };
    (0..people).map(person).collect()
}

fn forces(free: &[Free], tasks: &[[Vec<f64>; 3]; 2]) -> Finding {
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
    let by_task: Vec<Vec<f64>> = tasks.iter().map(|task| over_all(task.iter())).collect();
    let by_surface = [0, 1, 2].map(|place| over_all(tasks.iter().map(move |task| &task[place])));
    let imagery = paired_difference(&by_task[0], &by_task[1]);
    let p_of = |d: Option<PairedDifference>| d.map_or(f64::NAN, |d| d.p_value);
    // Holm's smallest adjusted p of the tasks and of the three pairs of surfaces.
    let pairs = [(0, 1), (0, 2), (1, 2)];
    let surfaces = pairs.map(|(a, b)| p_of(paired_difference(&by_surface[a], &by_surface[b])));
    let (of_tasks, of_surfaces) = (p_of(imagery), smallest(surfaces));
    let p = (4.0 * smallest([of_tasks, of_surfaces])).min(1.0);
    let held = by_surface.each_ref().map(|forces| mean(forces));
    Finding::of(
        31,
        Holds::all([
            above(
                bio_n - rough_n.max(smooth_n),
                0.0,
                "N",
                "the biomimetic sample is not pressed hardest",
            ),
            at_most(
                (rough / smooth - 1.0).abs(),
                0.1,
                "",
                "M3 and M8 differ in friction",
            ),
            at_least(
                rough.min(smooth) / bio,
                1.5,
                "",
                "their friction is less than 1.5 times that of BIO",
            ),
            above(
                p,
                0.05,
                "",
                "on the device, the tasks or the surfaces differ in force",
            ),
        ]),
        format!(
            "force M8 {rough_n:.2}, BIO {bio_n:.2}, M3 {smooth_n:.2} N; friction {rough:.2}, {bio:.2}, {smooth:.2}; imagery − \
                control {:+.1} mN, p = {of_tasks:.2}; on the device M8 {:.3}, BIO {:.3}, M3 {:.3} N, least p of a pair \
                {of_surfaces:.2}; of all four tests p = {p:.2} (Holm; {} participants, rendered drives; neither task nor surface \
                has an influence on the force of the twin)",
            imagery.map_or(f64::NAN, |d| d.mean * 1e3),
            held[0],
            held[1],
            held[2],
            by_task[0].len()
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
        side_by_side((1..=PARTICIPANTS).map(one).collect())
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
    share_scales(&mut figures);
    figures
}
