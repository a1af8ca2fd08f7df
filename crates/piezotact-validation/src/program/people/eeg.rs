//! What `piezotact eeg stats` says over people: contrasts of tasks, their sizes, means of tasks, clusters.

use anyhow::{Context as _, Result};
use piezotact::criterion::Outcome;
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::statistics::random::Random;
use piezotact_people::eeg::epochs::{Criterion, CutConfig, Epochs};
use piezotact_people::eeg::erd::{Mode, Order};
use piezotact_people::eeg::group::{GroupConfig, compare};
use piezotact_people::eeg::person::{EegErd, NamedBand, PersonConfig, Positions, Region, person};
use piezotact_people::eeg::prepare::{
    ChannelChoice, ConditionCount, EpochCounts, MarkerChoice, PrepareConfig, Prepared, Reference,
};
use piezotact_people::eeg::source::Subject;
use piezotact_people::eeg::tfr::TfrConfig;

use super::ability::{GUESSERS_SHARE, skewed};
use super::{Found, Printed, Question, Scenario, World};

const STUDIES: usize = 1_000;
const CHANNELS: [&str; 9] = ["C3", "C1", "Cz", "C2", "C4", "FC3", "FC4", "CP3", "CP4"];
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
/// Of the cluster test.
const FLIPS: usize = 512;

/// How people differ between tasks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Differ {
    Equal,
    UnequalSpread,
    UnequalEpochs,
    OneTask,
    Skewed,
    NoChange,
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
        step_s: 0.1,
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

/// The document of a person in a task with this change, and noise of its own at each electrode.
fn document(
    of: &EegErd,
    name: &str,
    task: usize,
    (change_db, epochs): (f64, usize),
    random: &mut Random,
) -> EegErd {
    let mut found = of.clone();
    found.file = format!("{name}_{}.vhdr", TASKS[task]);
    found.subject = Subject {
        participant: name.to_owned(),
        task: TASKS[task].to_owned(),
    };
    let off: Vec<f64> = CHANNELS.iter().map(|_| 0.5 * random.normal()).collect();
    for region in &mut found.regions {
        region.decibels = change_db;
        region.percent = 100.0 * (10f64.powf(change_db / 10.0) - 1.0);
        region.epochs = epochs;
    }
    for (one, off) in found.electrodes.iter_mut().zip(&off) {
        one.decibels = change_db + off;
        one.percent = 100.0 * (10f64.powf(one.decibels / 10.0) - 1.0);
        one.epochs = epochs;
    }
    let times_s = found.times_s.clone();
    for map in &mut found.maps {
        let mut noise = 0.0;
        for (at, decibels) in map.decibels.iter_mut().enumerate() {
            let time = times_s[at % times_s.len()];
            let electrode = at / times_s.len() / FREQUENCIES_HZ.len();
            noise = 0.7 * noise + random.normal();
            let inside = if time > 0.0 {
                change_db + off[electrode]
            } else {
                0.0
            };
            *decibels = inside + noise;
        }
    }
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
            for task in 0..if i < people { 2 } else { 1 } {
                let more_db = match (task, world) {
                    (1, World::Effect) => EFFECT_DB,
                    _ => 0.0,
                };
                let change_db = CHANGE_DB + shared_db + kind.of_task(task, &mut random) + more_db;
                let epochs = match (kind, task) {
                    (Differ::UnequalEpochs, 1) => EPOCHS,
                    (Differ::UnequalEpochs, _) => 4 * EPOCHS,
                    _ => EPOCHS,
                };
                let name = format!("P{i:02}");
                documents.push(document(&of, &name, task, (change_db, epochs), &mut random));
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
        let interval = measured.map(|one| one.difference.interval);
        let concluded = measured.map(|_| contrast.outcome() == Outcome::Met);
        let mean = found.changes.first().context("no change")?;
        let clusters = found.clusters.first();
        let differs = clusters
            .filter(|one| one.smallest_p <= 0.05)
            .map(|one| one.criteria.iter().any(|c| c.outcome == Outcome::Met));
        Ok(vec![
            Found {
                concluded,
                ..Found::estimated(interval, 0.0)
            },
            Found::estimated(measured.map(|one| one.d_z_interval), 0.0),
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
