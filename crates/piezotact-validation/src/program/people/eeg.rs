//! What `piezotact eeg stats` says over people: contrasts of tasks, their sizes, means of tasks, clusters.

use anyhow::{Context as _, Result};
use piezotact::criterion::Outcome;
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::statistics::random::Random;
use piezotact_people::eeg::epochs::{Criterion, CutConfig, Epochs};
use piezotact_people::eeg::erd::{Mode, Order};
use piezotact_people::eeg::group::{GroupConfig, GroupCriterion, LEVEL, compare};
use piezotact_people::eeg::person::{
    Change, EegErd, NamedBand, PersonConfig, Positions, Region, Trace, person,
};
use piezotact_people::eeg::prepare::{
    ChannelChoice, ConditionCount, EpochCounts, MarkerChoice, PrepareConfig, Prepared, Reference,
};
use piezotact_people::eeg::source::Subject;
use piezotact_people::eeg::tfr::TfrConfig;

use super::ability::{GUESSERS_SHARE, skewed};
use super::{Found, Printed, Question, Scenario, World};

const STUDIES: usize = 1_000;
const CHANNELS: [&str; 5] = ["C3", "C1", "C5", "FC3", "CP3"];
const TASKS: [&str; 2] = ["a", "b"];
const FREQUENCIES_HZ: [f64; 3] = [8.0, 10.0, 12.0];
const RATE_HZ: f64 = 64.0;
const FIRST_S: f64 = -1.2;
const EPOCHS: usize = 12;
/// The mean change of both tasks, how people differ in it in common, and in each task, dB.
const CHANGE_DB: f64 = -2.5;
const PEOPLE_DB: f64 = 1.0;
const TASK_DB: f64 = 0.8;
/// The difference between the tasks, where there is one, dB.
const EFFECT_DB: f64 = 1.0;
/// The power of a baseline, dB re 1 µV², how people differ in it, and how a person does between tasks.
const BASELINE_DB: f64 = 10.0;
const BASELINE_PEOPLE_DB: f64 = 3.0;
const BASELINE_TASK_DB: f64 = 0.3;
/// How much more power one of two unequal baselines has, dB.
const BASELINES_DB: f64 = 2.0;
/// The power of noise that is added in one task, re that of its baseline.
const NOISE: f64 = 1.0;
/// Of the cluster test.
const FLIPS: usize = 256;

/// How people differ between tasks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Differ {
    Equal,
    UnequalSpread,
    UnequalEpochs,
    OneTask,
    Skewed,
    NoChange,
    /// The power in the window is the same; that in the baseline is not.
    Baselines,
    /// One task has more noise throughout.
    Noise,
}

impl Differ {
    fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::UnequalSpread => "unequal spread",
            Self::UnequalEpochs => "unequal number of epochs",
            Self::OneTask => "unequal n: 4 with one task alone",
            Self::Skewed => "skewed in one task",
            Self::NoChange => "15 % without any change in one task",
            Self::Baselines => "unequal baselines, equal windows",
            Self::Noise => "noise added in one task",
        }
    }

    /// The difference of the changes that the baselines make, dB.
    fn difference_db(self) -> f64 {
        match self {
            Self::Baselines => -BASELINES_DB,
            _ => 0.0,
        }
    }

    /// How far a person is off the mean in a task, dB; its mean over people is 0.
    fn of_task(self, task: usize, random: &mut Random) -> f64 {
        match (self, task) {
            (Self::UnequalSpread, 0) => 0.25 * TASK_DB * random.normal(),
            (Self::UnequalSpread, _) => 2.0 * TASK_DB * random.normal(),
            // Of a quarter of the epochs.
            (Self::UnequalEpochs, 1) => 2.0 * TASK_DB * random.normal(),
            (Self::Skewed, 1) => TASK_DB * skewed(random),
            (Self::NoChange, 1) => {
                let own = TASK_DB * random.normal();
                match random.uniform() < GUESSERS_SHARE {
                    true => -CHANGE_DB * (1.0 - GUESSERS_SHARE) + 0.2 * own,
                    false => CHANGE_DB * GUESSERS_SHARE + own,
                }
            }
            _ => TASK_DB * random.normal(),
        }
    }
}

/// The document of somebody, whose numbers are replaced.
fn somebody() -> Result<EegErd> {
    let rate = SampleRate::new(RATE_HZ)?;
    let samples = (2.4 * RATE_HZ) as usize;
    let mut random = Random::stream(49, 3, "somebody");
    let volts = (0..CHANNELS.len() * EPOCHS * samples).map(|_| 1e-5 * random.normal());
    let names = CHANNELS.map(str::to_owned).to_vec();
    let conditions = vec!["S1".to_owned(); EPOCHS];
    let prepared = Prepared {
        config: PrepareConfig {
            markers: vec![MarkerChoice {
                marker: "S 1".into(),
                condition: "S1".into(),
            }],
            task: None,
            extent: CutConfig {
                start_s: FIRST_S,
                end_s: 1.2,
            },
            channels: ChannelChoice::AllBut(Vec::new()),
            filters: Vec::new(),
            eog: Vec::new(),
            interpolated: Vec::new(),
            reference: Reference::AsRecorded,
            criteria: vec![Criterion::PeakToPeak { above_v: 1e-3 }],
            min_epochs: 2,
        },
        task: TASKS[0].into(),
        onsets_s: (0..EPOCHS).map(|i| 5.0 * i as f64).collect(),
        epochs: Epochs::new(names, conditions, rate, FIRST_S, volts.collect())?,
        counts: EpochCounts {
            conditions: vec![ConditionCount {
                condition: "S1".into(),
                markers: EPOCHS,
                kept: EPOCHS,
                ..ConditionCount::default()
            }],
            not_whole: Vec::new(),
            rejected: Vec::new(),
        },
        warnings: Vec::new(),
    };
    let config = PersonConfig {
        power: TfrConfig {
            frequencies_hz: FREQUENCIES_HZ.to_vec(),
            cycles: FREQUENCIES_HZ.map(|hz| hz / 2.0).to_vec(),
            decimation: 1,
        },
        step_s: 0.2,
        bands: vec![NamedBand {
            name: "alpha".into(),
            hz: Band::new(Hertz(8.0), Hertz(12.0))?,
        }],
        regions: Region::single(&CHANNELS[..1]),
        baseline_s: [-0.8, -0.3],
        window_s: [0.0, 0.6],
        order: Order::PowerFirst,
        min_epochs: 2,
    };
    let subject = Subject {
        participant: "P".into(),
        task: TASKS[0].into(),
    };
    Ok(person(
        "P.vhdr",
        &subject,
        &prepared,
        &Positions::OfNames,
        &config,
    )?)
}

/// What somebody shows in a task.
struct Shown {
    change_db: f64,
    baseline_db: f64,
    epochs: usize,
}

impl Shown {
    /// The same with the power `noise`, re the baseline, added to baseline and window.
    fn with_noise(self, noise: f64) -> Self {
        let more_db = |ratio: f64| 10.0 * ((ratio + noise) / ratio).log10();
        let window = 10f64.powf(self.change_db / 10.0);
        Self {
            change_db: self.change_db + more_db(window) - more_db(1.0),
            baseline_db: self.baseline_db + more_db(1.0),
            ..self
        }
    }
}

/// The document of a person in a task, with noise of its own at each electrode.
fn document(of: &EegErd, name: &str, task: usize, shown: &Shown, random: &mut Random) -> EegErd {
    let mut found = of.clone();
    found.file = format!("{name}_{}.vhdr", TASKS[task]);
    found.subject = Subject {
        participant: name.to_owned(),
        task: TASKS[task].to_owned(),
    };
    let power_v2 = |db: f64| 1e-12 * 10f64.powf(db / 10.0);
    let set = |one: &mut Change, change_db: f64| {
        one.decibels = change_db;
        one.percent = 100.0 * (10f64.powf(change_db / 10.0) - 1.0);
        one.baseline_power_v2 = power_v2(shown.baseline_db);
        one.window_power_v2 = power_v2(shown.baseline_db + change_db);
        one.epochs = shown.epochs;
    };
    let off: Vec<f64> = CHANNELS.iter().map(|_| 0.5 * random.normal()).collect();
    for region in &mut found.regions {
        set(region, shown.change_db);
    }
    for (one, off) in found.electrodes.iter_mut().zip(&off) {
        set(one, shown.change_db + off);
    }
    let times_s = found.times_s.clone();
    for map in &mut found.maps {
        let mut noise = 0.0;
        for (at, decibels) in map.decibels.iter_mut().enumerate() {
            let time = times_s[at % times_s.len()];
            let electrode = at / times_s.len() / FREQUENCIES_HZ.len();
            noise = 0.7 * noise + random.normal();
            let inside = if time > 0.0 {
                shown.change_db + off[electrode]
            } else {
                0.0
            };
            *decibels = inside + noise;
        }
        map.baselines_db.fill(shown.baseline_db);
    }
    // Epochs that are those of no other document.
    let mut levels = || {
        let levels = (0..120).map(|_| (20.0 * random.normal()).round() as i16);
        levels.collect()
    };
    found.trace = Trace {
        step_s: 0.4,
        epochs: vec![levels(), levels()],
    };
    found
}

pub(super) fn scenarios() -> Vec<Scenario> {
    use Differ as D;
    let all = [
        (D::Equal, 4),
        (D::Equal, 6),
        (D::Equal, 10),
        (D::Equal, 20),
        (D::UnequalSpread, 10),
        (D::UnequalEpochs, 10),
        (D::OneTask, 10),
        (D::Skewed, 10),
        (D::NoChange, 10),
        (D::NoChange, 20),
        (D::Baselines, 10),
        (D::Noise, 10),
    ];
    let Ok(of) = somebody() else {
        return Vec::new();
    };
    all.map(|(kind, people)| scenario(of.clone(), kind, people))
        .into()
}

fn scenario(of: EegErd, kind: Differ, people: usize) -> Scenario {
    let study = move |seed: u64, world: World| -> Result<Vec<Found>> {
        let mut random = Random::stream(seed, people as u64, kind.name());
        let mut documents = Vec::new();
        let of_one = if kind == Differ::OneTask { 4 } else { 0 };
        for i in 0..people + of_one {
            let shared_db = PEOPLE_DB * random.normal();
            let own_db = BASELINE_DB + BASELINE_PEOPLE_DB * random.normal();
            let tasks = if i < people { 2 } else { 1 };
            for task in 0..tasks {
                let more_db = match (task, world) {
                    (1, World::Effect) => EFFECT_DB,
                    _ => 0.0,
                };
                let difference_db = [0.0, kind.difference_db()][task];
                let of_task_db = kind.of_task(task, &mut random);
                let shown = Shown {
                    change_db: CHANGE_DB + shared_db + of_task_db + difference_db + more_db,
                    baseline_db: own_db - difference_db + BASELINE_TASK_DB * random.normal(),
                    epochs: match (kind, task) {
                        (Differ::UnequalEpochs, 0) => 4 * EPOCHS,
                        _ => EPOCHS,
                    },
                };
                let shown = match (kind, task) {
                    (Differ::Noise, 1) => shown.with_noise(NOISE),
                    _ => shown,
                };
                let name = format!("P{i:02}");
                documents.push(document(&of, &name, task, &shown, &mut random));
            }
        }
        let config = GroupConfig {
            unit: Mode::Decibels,
            gradient: Vec::new(),
            margin: None,
            neighbours_deg: 35.0,
            flips: FLIPS,
            seed,
        };
        let found = compare(&documents, &config)?;
        let contrast = found.contrasts.first().context("no contrast")?;
        let measured = contrast.contrast;
        // What noise adds to the difference is another in each person: its intervals have no one truth.
        let estimated = measured.filter(|_| kind != Differ::Noise);
        let interval = estimated.map(|one| one.difference.interval);
        // What the baselines may carry is withheld.
        let concluded = measured
            .filter(|_| !contrast.may_be_of_baselines())
            .map(|_| contrast.outcome() == Outcome::Met);
        let truth_db = kind.difference_db();
        let mean = found.changes.first().context("no change")?;
        let clusters = found.clusters.first();
        let differs = clusters.filter(|one| one.smallest_p <= LEVEL);
        let differs = differs.map(|one| {
            let mut criteria = one.criteria.iter();
            let own = criteria.find(|c| matches!(c.what, GroupCriterion::Cluster { .. }));
            own.is_some_and(|c| c.outcome == Outcome::Met)
        });
        Ok(vec![
            Found {
                concluded,
                ..Found::estimated(interval, truth_db)
            },
            Found::estimated(
                estimated.map(|one| one.d_z_interval),
                truth_db / TASK_DB / 2f64.sqrt(),
            ),
            Found::estimated(mean.interval, CHANGE_DB),
            Found::tested(differs),
        ])
    };
    Scenario {
        questions: vec![
            Question::of("contrast of tasks", Printed::Both),
            Question::of("d_z of the contrast", Printed::Interval),
            Question::of("mean change of a task", Printed::Interval),
            Question::of("clusters", Printed::Test),
        ],
        name: kind.name(),
        people: people.to_string(),
        studies: STUDIES,
        study: Box::new(study),
    }
}
