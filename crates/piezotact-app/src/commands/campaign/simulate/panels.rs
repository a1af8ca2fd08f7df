//! The same campaign with several panels of virtual volunteers, on all cores.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::channel;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::anyhow;
use piezotact::number::counted;
use piezotact_people::association::{AnswerTable, AssociationConfig, associate};
use piezotact_people::judge::Verdict;

use super::super::study::Study;
use super::which::which_of;
use super::{Arguments, SIMULATING, asked, simulated, study};
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::Between;
use crate::output::{print, say};
use crate::progress::{Words, Work};

const PANELS: Words = Words {
    item: "panel",
    then: "counting",
    ..SIMULATING
};

/// What a panel answered.
struct Panel {
    seed: u64,
    /// The share of expected associations, %.
    expected_percent: f64,
    said: String,
    /// Which judge the answers show; `None` where they are not compared.
    judged: Option<Verdict>,
}

/// Does `count` campaigns, and says what each found and how they differ.
pub(super) fn run(args: &Arguments, count: u32) -> Outcome {
    let last = args.seed.checked_add(u64::from(count) - 1);
    last.ok_or_else(|| {
        usage(anyhow!(
            "--seed: expected one that {} can follow, found {}; state a smaller one",
            counted(count as usize - 1, "other"),
            args.seed
        ))
    })?;
    let work = Work::of_sizes(PANELS, vec![1.0; count as usize]);
    let between = Between::items("volunteer");
    let mut panels = Vec::new();
    on_all_cores(args, count, |panel| {
        say(&format!("seed {}: {}", panel.seed, panel.said));
        panels.push(panel);
        work.one_more();
    })?;
    drop((work, between));
    panels.sort_by_key(|panel| panel.seed);
    print(&summary(args, &panels))
}

/// Does `count` campaigns on all cores; `done` is given each as it is complete. After an error the others end with the panel that they are
/// at.
fn on_all_cores(args: &Arguments, count: u32, mut done: impl FnMut(Panel)) -> Outcome {
    let places: Mutex<VecDeque<u32>> = Mutex::new((0..count).collect());
    let (sender, results) = channel();
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers.min(count as usize) {
            let (places, sender) = (&places, sender.clone());
            scope.spawn(move || {
                while let Some(place) = locked(places).pop_front() {
                    if sender.send(panel(args, place)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut ended = Ok(());
        for found in &results {
            match found {
                Ok(panel) => done(panel),
                Err(error) if ended.is_ok() => {
                    locked(&places).clear();
                    ended = Err(error);
                }
                Err(_a_further_one) => {}
            }
        }
        ended
    })
}

fn locked(places: &Mutex<VecDeque<u32>>) -> MutexGuard<'_, VecDeque<u32>> {
    places.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The campaign of the panel at `place`, whose study is a folder of its own.
fn panel(args: &Arguments, place: u32) -> Outcome<Panel> {
    let seed = args.seed + u64::from(place);
    let own = Arguments {
        study: args.study.join(format!("seed-{seed}")),
        seed,
        panels: None,
        ..args.clone()
    };
    let (mut made, _alone) = study(&own)?;
    let campaign = made.campaign.clone();
    let participants = own
        .participants
        .unwrap_or(campaign.protocol.panel.participants);
    let simulation = asked(&own, &campaign, participants)?;
    simulated(&own, &simulation, participants, &mut made, &mut |_| {})?;
    let (expected_percent, mut said) = found(&made)?;
    let mut judged = None;
    match which_of(&made)? {
        Some(Ok(which)) => {
            said = format!("{said} {}", which.sentence());
            judged = Some(which.verdict);
        }
        Some(Err(why)) => said = format!("{said} Judges are not compared: {why}."),
        None => {}
    }
    Ok(Panel {
        seed,
        expected_percent,
        said,
        judged,
    })
}

/// The share of expected associations, and what the matrix of all says.
fn found(study: &Study) -> Outcome<(f64, String)> {
    let (declared, _) = study.answers()?;
    let mut answers = study.associations()?;
    if answers.is_empty() {
        answers = study.places()?;
    }
    if answers.is_empty() {
        return Ok((f64::NAN, "no answer names a sample".to_owned()));
    }
    let table = AnswerTable::new(declared, answers).map_err(|error| Failure::Data(error.into()))?;
    let found = associate(&table, &AssociationConfig::default());
    let found = found.map_err(|error| Failure::Data(error.into()))?;
    let share = found.expected.first();
    let percent = share.map(|share| 100.0 * share.expected as f64 / share.answers as f64);
    Ok((percent.unwrap_or(f64::NAN), found.sentence()))
}

/// How many panels, and how their shares of expected associations differ.
fn summary(args: &Arguments, panels: &[Panel]) -> String {
    let shares: Vec<f64> = panels.iter().map(|panel| panel.expected_percent).collect();
    let known: Vec<f64> = shares
        .into_iter()
        .filter(|share| share.is_finite())
        .collect();
    let spread = match known.as_slice() {
        [] => "no answer names a sample".to_owned(),
        known => {
            let (low, high) = known
                .iter()
                .fold((f64::MAX, f64::MIN), |(low, high), share| {
                    (low.min(*share), high.max(*share))
                });
            let mean = known.iter().sum::<f64>() / known.len() as f64;
            format!(
                "as expected {mean:.1} % on average, {low:.1} to {high:.1} % from panel to panel"
            )
        }
    };
    format!(
        "{}: {} of virtual volunteers who judge as {}; {spread}{}",
        args.study.display(),
        counted(panels.len(), "panel"),
        args.judge.name(),
        judged(panels)
    )
}

/// How many panels show which judge.
fn judged(panels: &[Panel]) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for verdict in panels.iter().filter_map(|panel| panel.judged) {
        let shown = match verdict {
            Verdict::Named { judge } => format!("show {}", judge.name()),
            Verdict::NoneFits => "show none of the judges".to_owned(),
            Verdict::NotDecided => "do not decide".to_owned(),
        };
        *counts.entry(shown).or_default() += 1;
    }
    if counts.is_empty() {
        return String::new();
    }
    let counts: Vec<String> = counts
        .iter()
        .map(|(shown, count)| format!("{count} {shown}"))
        .collect();
    format!("; which judge it was: {}", counts.join(", "))
}
