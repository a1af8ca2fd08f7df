//! Chapter 6, EEG: the desynchronisation of alpha while three surfaces are touched in three tasks, at electrodes.

use std::collections::BTreeMap;

use piezotact::Warning;
use piezotact::figure::{Line, Mark};
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::recording::{EventValue, Recording};
use piezotact::statistics::{holm, mean};
use piezotact_people::eeg::cluster::{
    ClusterConfig, ClusterError, ClusterTest, Grid, differences, test,
};
use piezotact_people::eeg::contrast::{Contrast, paired};
use piezotact_people::eeg::epochs::{Continuous, CutConfig, Epochs, Event, cut};
use piezotact_people::eeg::erd::{ErdConfig, Mode, desynchronisation, map};
use piezotact_people::eeg::reference::Montage;
use piezotact_people::eeg::tfr::{Power, TfrConfig, TfrPlan};
use piezotact_twin::Participant;
use piezotact_twin::eeg::{EegProtocol, REST, Task, record};

use super::ReplayError;
use super::claims::{Finding, Holds, below};
use super::figure::{Counterpart, line, linear, names, side_by_side};
use piezotact_volunteers::Laboratory;

/// Who takes part (*thesis* 6.2).
const PARTICIPANTS: u64 = 10;
/// The tasks from the strongest desynchronisation to the weakest (*thesis* 6.5).
const ORDER: [Task; 3] = [Task::Control, Task::Imagery, Task::Natural];
/// The pairs of tasks that the thesis compares: that of the stronger activation first (6.5).
const PAIRS: [[usize; 2]; 3] = [[0, 2], [0, 1], [1, 2]];
/// The electrodes over the sensorimotor cortex of the right hand.
const REGION: [&str; 12] = [
    "FC5", "FC3", "FC1", "C5", "C3", "C1", "CP5", "CP3", "CP1", "P5", "P3", "P1",
];
/// Whose desynchronisation is averaged.
const CENTRE: [&str; 2] = ["C3", "CP3"];
/// Touches of each surface in each task.
const TRIALS: usize = 60;
/// Enough for the band of alpha, and half the samples of usual amplifiers.
const RATE_HZ: f64 = 256.0;
/// The band (*thesis* 6.5).
const ALPHA_HZ: [f64; 2] = [8.0, 12.0];
/// The frequencies of the wavelets, and their cycles.
const FREQUENCIES_HZ: [f64; 5] = [8.0, 9.0, 10.0, 11.0, 12.0];
const CYCLES: f64 = 7.0;
/// From before a movement is planned (*thesis* 6.5).
const BASELINE_S: [f64; 2] = [-1.5, -0.5];
/// The first 800 ms (*thesis* 6.5).
const WINDOW_S: [f64; 2] = [0.0, 0.8];
const EPOCH_S: [f64; 2] = [-2.0, 1.4];
/// Every so many-th sample of power: 32 a second.
const DECIMATION: usize = 8;
const MIN_EPOCHS: usize = 10;
/// Electrodes are neighbours at up to this angle.
const NEIGHBOURS_DEG: f64 = 35.0;
/// All flips of ten people are 512.
const FLIPS: usize = 1_024;
/// The level of the three cluster tests together.
const LEVEL: f64 = 0.05;

/// What the EEG of all participants says.
pub(super) struct Brains {
    pub(super) findings: Vec<Finding>,
    pub(super) figures: Vec<Counterpart>,
    pub(super) measured: Vec<String>,
    pub(super) warnings: Vec<Warning>,
}

/// One task of one person.
struct Session {
    /// The desynchronisation at the centre, %, by surface.
    by_surface: BTreeMap<String, f64>,
    /// Over electrodes, frequencies and times of all trials, %.
    changes: Power,
    warnings: Vec<Warning>,
}

/// The sessions of all participants: one list for each task of [`ORDER`].
type Sessions = [Vec<Session>; 3];

pub(super) fn brains(laboratory: &Laboratory, surfaces: [&str; 3]) -> Result<Brains, ReplayError> {
    let sessions = recorded(laboratory, surfaces)?;
    let tests = tested(&sessions, laboratory.seed)?;
    Ok(Brains {
        findings: vec![gradient(&sessions, surfaces)?, clusters(&tests)],
        figures: vec![
            by_task(&sessions, surfaces),
            over_time(&sessions),
            over_electrodes(&tests),
        ],
        measured: vec![format!(
            "The EEG of participants 1 to {PARTICIPANTS} was recorded at {} electrodes in three tasks, each surface touched {TRIALS} times. Morlet wavelets of {CYCLES} \
             cycles at 8, 9 … 12 Hz; power was averaged over trials before the baseline ({} to {} s) was divided; window {} to {} s; no trial was rejected.",
            REGION.len(),
            BASELINE_S[0],
            BASELINE_S[1],
            WINDOW_S[0],
            WINDOW_S[1],
        )],
        warnings: sessions
            .into_iter()
            .flatten()
            .flat_map(|one| one.warnings)
            .collect(),
    })
}

/// All participants in all tasks.
fn recorded(laboratory: &Laboratory, surfaces: [&str; 3]) -> Result<Sessions, ReplayError> {
    let mut sessions: Sessions = Default::default();
    for participant in 1..=PARTICIPANTS {
        for (task, list) in ORDER.into_iter().zip(&mut sessions) {
            list.push(session(laboratory, participant, task, surfaces)?);
        }
    }
    Ok(sessions)
}

/// The cluster tests of [`PAIRS`].
fn tested(sessions: &Sessions, seed: u64) -> Result<[ClusterTest; 3], ReplayError> {
    let of = |[strong, weak]: [usize; 2]| contrasted(&sessions[strong], &sessions[weak], seed);
    let [first, second, third] = PAIRS;
    Ok([of(first)?, of(second)?, of(third)?])
}

fn session(
    laboratory: &Laboratory,
    participant: u64,
    task: Task,
    surfaces: [&str; 3],
) -> Result<Session, ReplayError> {
    let person = Participant::of(participant, laboratory.seed, &laboratory.parameters);
    let protocol = EegProtocol {
        surfaces: surfaces.map(str::to_owned).to_vec(),
        trials_per_surface: TRIALS,
        rate: SampleRate::new(RATE_HZ)?,
        channels: REGION.map(str::to_owned).to_vec(),
        ..EegProtocol::usual(&laboratory.parameters, task)?
    };
    let epochs = epochs(&record(
        &laboratory.parameters,
        &person,
        &protocol,
        "chapter 6",
    )?)?;
    let plan = TfrPlan::plan(
        &TfrConfig {
            frequencies_hz: FREQUENCIES_HZ.to_vec(),
            cycles: FREQUENCIES_HZ.map(|_| CYCLES).to_vec(),
            decimation: DECIMATION,
        },
        epochs.rate(),
        epochs.samples(),
    )?;
    let config = ErdConfig {
        band: Band::new(Hertz(ALPHA_HZ[0]), Hertz(ALPHA_HZ[1]))?,
        baseline_s: BASELINE_S,
        window_s: WINDOW_S,
        mode: Mode::Percent,
        min_epochs: MIN_EPOCHS,
    };
    let (mut by_surface, mut warnings) = (BTreeMap::new(), Vec::new());
    for surface in surfaces {
        let erd = desynchronisation(&plan, &epochs.of_condition(surface)?, &config)?;
        let centre = erd.channels.iter();
        let centre = centre.filter(|one| CENTRE.contains(&one.channel.as_str()));
        let changes: Vec<f64> = centre.map(|one| one.change).collect();
        by_surface.insert(surface.to_owned(), mean(&changes));
        warnings.extend(erd.warnings);
    }
    let changes = map(
        &plan.average(&epochs)?,
        BASELINE_S,
        Mode::Percent,
        MIN_EPOCHS,
    )?;
    Ok(Session {
        by_surface,
        changes: changes.power,
        warnings,
    })
}

/// The trials of a recording, each with its surface.
fn epochs(recording: &Recording) -> Result<Epochs, ReplayError> {
    let channels: Vec<String> = recording
        .channels()
        .iter()
        .map(|c| c.name.clone())
        .collect();
    let volts: Vec<f64> = recording
        .channels()
        .iter()
        .flat_map(|c| c.samples.iter().copied())
        .collect();
    let trials = recording
        .annotations
        .events
        .iter()
        .filter(|event| event.kind != REST);
    let events: Vec<Event> = trials
        .map(|event| Event {
            sample: recording.rate().samples_in(event.onset_s),
            condition: event
                .value
                .as_ref()
                .map(EventValue::to_string)
                .unwrap_or_default(),
        })
        .collect();
    let continuous = Continuous {
        channels: &channels,
        rate: recording.rate(),
        volts: &volts,
        gaps: &[],
    };
    let [start_s, end_s] = EPOCH_S;
    Ok(cut(&continuous, &events, &CutConfig { start_s, end_s })?.epochs)
}

/// One value of each person at the centre, %, the mean over surfaces.
fn overall(sessions: &[Session]) -> Vec<f64> {
    sessions
        .iter()
        .map(|one| mean(&one.by_surface.values().copied().collect::<Vec<_>>()))
        .collect()
}

fn on(sessions: &[Session], surface: &str) -> Vec<f64> {
    sessions
        .iter()
        .filter_map(|one| one.by_surface.get(surface).copied())
        .collect()
}

fn gradient(sessions: &Sessions, surfaces: [&str; 3]) -> Result<Finding, ReplayError> {
    let means = surfaces.map(|surface| sessions.each_ref().map(|task| mean(&on(task, surface))));
    let order = "on some surface the group means are not in the order control, imagery, natural";
    let steps = means
        .iter()
        .flat_map(|[control, imagery, natural]| [control - imagery, imagery - natural]);
    let rules = steps.map(|step| below(step, 0.0, "%", order));
    let said: Vec<String> = surfaces
        .iter()
        .zip(&means)
        .map(|(surface, [control, imagery, natural])| {
            format!("{surface} {control:.1}, {imagery:.1}, {natural:.1} %")
        })
        .collect();
    let all = sessions.each_ref().map(|task| overall(task));
    let effect = |[strong, weak]: [usize; 2]| -> Result<String, ClusterError> {
        let Contrast {
            difference,
            d_z,
            d_z_interval: [low, high],
        } = paired(&all[strong], &all[weak])?;
        Ok(format!(
            "{} − {} {:+.1} points, d_z = {d_z:.1} [{low:.1}, {high:.1}], p = {:.4}",
            ORDER[weak], ORDER[strong], difference.mean, difference.p_value
        ))
    };
    let effects = PAIRS
        .into_iter()
        .map(effect)
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Finding::of(
        33,
        Holds::all(rules),
        format!(
            "change of the power of 8–12 Hz at C3 and CP3 in the first 0.8 s, control, imagery, natural (negative: desynchronisation; group means of {PARTICIPANTS}): \
                {}; over all surfaces {}",
            said.join("; "),
            effects.join("; ")
        ),
    ))
}

/// The nodes of the window: electrodes × frequencies × times.
fn nodes(session: &Session) -> Vec<f64> {
    let changes = &session.changes;
    let times = window(changes);
    let lines = changes.values.chunks_exact(changes.times_s.len());
    lines
        .flat_map(|line| line[times.clone()].iter().copied())
        .collect()
}

fn window(changes: &Power) -> std::ops::Range<usize> {
    let [from, to] = WINDOW_S;
    let start = changes.times_s.partition_point(|t| *t < from - 1e-9);
    start..changes.times_s.partition_point(|t| *t <= to + 1e-9)
}

/// The cluster test of two tasks over the window: positive where the first has the stronger desynchronisation.
fn contrasted(strong: &[Session], weak: &[Session], seed: u64) -> Result<ClusterTest, ReplayError> {
    let of = |sessions: &[Session]| -> Vec<Vec<f64>> { sessions.iter().map(nodes).collect() };
    let people = differences(&of(strong), &of(weak))?;
    let montage = Montage::ten_ten(&REGION.map(str::to_owned))?;
    let times = strong.first().map_or(0, |one| window(&one.changes).len());
    let grid = Grid::new(
        REGION.len(),
        FREQUENCIES_HZ.len(),
        times,
        &montage.neighbours(NEIGHBOURS_DEG),
    )?;
    let config =
        ClusterConfig::two_sided(people.len(), FLIPS, seed).ok_or(ClusterError::FewPeople {
            found: people.len(),
        })?;
    Ok(test(&people, &grid, &config)?)
}

/// The p of the heaviest cluster in which the first task has the stronger desynchronisation; 1 without one.
fn p_of(test: &ClusterTest) -> f64 {
    let mut positive = test.clusters.iter().filter(|cluster| cluster.mass > 0.0);
    positive.next().map_or(1.0, |cluster| cluster.p_value)
}

fn clusters(tests: &[ClusterTest; 3]) -> Finding {
    let unless = [
        "control and natural touch do not differ in a cluster",
        "control and imagery do not differ in a cluster",
        "imagery and natural touch do not differ in a cluster",
    ];
    let adjusted = holm(&tests.each_ref().map(p_of));
    let rules = adjusted
        .iter()
        .zip(unless)
        .map(|(p, unless)| below(*p, LEVEL, "", unless));
    let said = PAIRS
        .iter()
        .zip(tests)
        .zip(&adjusted)
        .map(|(([strong, weak], test), p)| {
            let heaviest = test.clusters.iter().find(|cluster| cluster.mass > 0.0);
            let share = heaviest.map_or(0.0, |cluster| {
                cluster.nodes.len() as f64 / test.t.len() as f64
            });
            format!(
                "{} against {}: p = {p:.3}, {:.0} % of the nodes",
                ORDER[*strong],
                ORDER[*weak],
                share * 100.0
            )
        });
    Finding::of(
        37,
        Holds::all(rules),
        format!(
            "clusters over {} electrodes about C3 and CP3, 8–12 Hz and the first 0.8 s in which the first task has the stronger desynchronisation: {} (p adjusted for three tests, Holm; all \
                {} different sign flips of {} participants; no sources of the cortex)",
            REGION.len(),
            said.collect::<Vec<_>>().join("; "),
            tests[0].flips,
            tests[0].people,
        ),
    )
}

/// Figure 97: everybody and the group, task by task.
fn by_task(sessions: &Sessions, surfaces: [&str; 3]) -> Counterpart {
    let people = surfaces.iter().map(|surface| {
        let points = sessions.iter().enumerate().flat_map(|(x, task)| {
            on(task, surface)
                .into_iter()
                .map(move |change| (x as f64, change))
        });
        line(format!("{surface}, participants"), points.collect()).marked(Mark::Dots)
    });
    let groups = surfaces.iter().map(|surface| {
        let points = sessions
            .iter()
            .enumerate()
            .map(|(x, task)| (x as f64, mean(&on(task, surface))));
        line(format!("{surface}, mean"), points.collect()).marked(Mark::Joined)
    });
    let lines: Vec<Line> = side_by_side(people.collect())
        .into_iter()
        .chain(side_by_side(groups.collect()))
        .collect();
    Counterpart::chart(
        "97a",
        "Change of the power of 8–12 Hz at C3 and CP3 in the first 0.8 s of touch relative to rest: each participant, and the group means. Negative is a desynchronisation.",
        (
            names("task", ORDER.iter().map(Task::to_string)),
            linear("change of power, %"),
        ),
        lines,
    )
}

/// Figure 97: over time.
fn over_time(sessions: &Sessions) -> Counterpart {
    let lines = ORDER.iter().zip(sessions).map(|(task, sessions)| {
        let curves: Vec<Vec<f64>> = sessions.iter().map(|one| course(&one.changes)).collect();
        let times = sessions.first().map_or(&[][..], |one| &one.changes.times_s);
        let points = times.iter().enumerate().map(|(i, time)| {
            (
                *time,
                mean(&curves.iter().map(|curve| curve[i]).collect::<Vec<_>>()),
            )
        });
        let whole = points.filter(|(time, _)| (-1.6..=1.1).contains(time));
        line(task.to_string(), whole.collect())
    });
    Counterpart::chart(
        "97b",
        "The same over time, mean of all participants and surfaces; the touch begins at 0 s. A wavelet smears by 0.1 s.",
        (
            linear("time from the onset, s"),
            linear("change of power, %"),
        ),
        lines.collect(),
    )
}

/// The mean change over the centre and the band, %.
fn course(changes: &Power) -> Vec<f64> {
    let (lines, times) = (changes.frequencies_hz.len(), changes.times_s.len());
    let centre: Vec<usize> = (0..changes.channels.len())
        .filter(|i| CENTRE.contains(&changes.channels[*i].as_str()))
        .collect();
    let rows: Vec<&[f64]> = centre
        .iter()
        .flat_map(|channel| (0..lines).map(|frequency| changes.line(*channel, frequency)))
        .collect();
    (0..times)
        .map(|t| mean(&rows.iter().map(|row| row[t]).collect::<Vec<_>>()))
        .collect()
}

/// Instead of figure 96: t of each electrode, the mean over the window and the band.
fn over_electrodes(tests: &[ClusterTest; 3]) -> Counterpart {
    let lines = PAIRS.iter().zip(tests).map(|([strong, weak], test)| {
        let each = test
            .t
            .chunks_exact((test.t.len() / REGION.len()).max(1))
            .map(mean);
        let points = each.enumerate().map(|(x, t)| (x as f64, t)).collect();
        line(
            format!("{} against {}", ORDER[*strong], ORDER[*weak]),
            points,
        )
        .marked(Mark::Dots)
    });
    Counterpart::chart(
        "96",
        "At electrodes instead of sources: Student's t over participants, mean over 8–12 Hz and the first 0.8 s. Positive: the first task has the stronger desynchronisation.",
        (
            names("electrode", REGION.iter().map(|name| (*name).to_owned())),
            linear("mean t"),
        ),
        lines.collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where all tasks desynchronise alike, neither claim is found; and no task has a desynchronisation where none is made.
    #[test]
    #[ignore = "many repetitions: ./x soak runs it"]
    fn soak_nothing_is_found_where_tasks_are_alike() {
        let mut parameters = piezotact_twin::TwinParameters::built_in();
        let model = &mut parameters.eeg.desynchronisation;
        (model.control, model.imagery, model.natural) = (0.0, 0.0, 0.0);
        (model.person_spread, model.task_spread, model.surface_spread) = (0.0, 0.0, 0.0);
        let laboratory = Laboratory {
            parameters,
            seed: 1,
        };
        let sessions = recorded(&laboratory, ["M8", "BIO", "M3"]).unwrap();
        for task in &sessions {
            // Ten people with 180 trials each, of which each alone scatters by 12 points.
            let change = mean(&overall(task));
            assert!(change.abs() < 5.0, "{change}");
        }
        let found = gradient(&sessions, ["M8", "BIO", "M3"]).unwrap();
        assert!(!found.holds(), "{}", found.measured);
        let found = clusters(&tested(&sessions, 1).unwrap());
        assert!(!found.holds(), "{}", found.measured);
        assert!(
            found.criteria.iter().all(|c| c.found > Some(0.05)),
            "{}",
            found.measured
        );
    }
}
