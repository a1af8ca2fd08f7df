//! How many people, repeats and sets find a stated difference in a campaign as it is designed.

use piezotact::number::counted;
use piezotact::page::{Cell, Column, Table};
use serde::{Deserialize, Serialize};

use super::super::description::{CampaignDescription, TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::power::{
    FoundShare, MOST_PARTICIPANTS, MOST_PRESENTATIONS, PowerPlan, cell_of, found_share,
};
use super::presented::tests;
use super::{Work, checked_sets, fewest};
use crate::difference::Difference;
use crate::interval::clopper_pearson;

/// Simulated campaigns for a number that is stated, and for a point of a curve.
const CAMPAIGNS: usize = 1000;
const CAMPAIGNS_OF_A_POINT: usize = 400;
/// Simulated studies for the interval of a cell.
const STUDIES: usize = 200;
/// The most repeats that are looked for.
const MOST_TIMES: usize = 60;
/// The curves: participants along each, one for each number of times the presentations.
const PARTICIPANTS: [usize; 12] = [4, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60];
const TIMES: [usize; 3] = [1, 2, 4];

/// What is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PowerQuestion {
    /// The difference that is to be found.
    pub difference: Difference,
    /// The task whose answers count; of two samples or groups, where several can.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Shares of the median participant, as of [`PowerPlan`].
    pub shares: [f64; 2],
    /// The standard deviation over participants, of the logits of these shares; by default that of the campaign's aims.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub logit_sd: Option<f64>,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PowerPoint {
    /// How often the difference is found.
    #[serde(flatten)]
    pub found: FoundShare,
    /// The mean half-width of the 95 % interval of a cell of the first of the two, as a share.
    pub half_width_share: f64,
}

/// How often a stated difference is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PowerStudy {
    /// What was asked.
    pub question: PowerQuestion,
    /// What was simulated, as it is designed.
    pub plan: PowerPlan,
    /// The mean number of presentations to each participant, before rounding.
    pub presentations: [f64; 2],
    /// Of two samples: how many sets have both, and how many sets there are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sets: Option<[usize; 2]>,
    /// The power that is wanted.
    pub wanted_share: f64,
    /// As it is designed.
    pub planned: FoundShare,
    /// The share of campaigns that find a difference where there is none, and people do not differ from each other in it.
    pub without_difference_share: f64,
    /// The smallest number of participants that suffices; absent above 200.
    pub participants_needed: Option<usize>,
    /// The smallest number of times the presentations that suffices with the planned participants; absent above 60.
    pub times_needed: Option<usize>,
    /// Power and precision over participants, one row for each number of times the presentations.
    pub curves: Vec<Vec<PowerPoint>>,
}

/// The power of `campaign` for a stated difference, by simulated campaigns that end in the test of [`crate::difference`].
///
/// # Errors
/// [`DesignError`] for names that the campaign does not have, two samples that no set has both of, and numbers out of range.
///
/// Source: decision 0074 of this project.
pub fn power_study(
    campaign: &CampaignDescription,
    question: &PowerQuestion,
    seed: u64,
) -> Result<PowerStudy, DesignError> {
    let sets = checked_sets(campaign)?;
    let work = Work::new(campaign, sets.as_ref(), seed);
    let (presentations, sets) = work.presentations_of(question)?;
    let plan = PowerPlan {
        difference: question.difference.clone(),
        participants: campaign.participants,
        presentations: presentations.map(|n| (n.round() as usize).max(1)),
        shares: question.shares,
        logit_sd: question.logit_sd.unwrap_or(campaign.aims.logit_sd),
    };
    let of = |participants: usize, times: usize| PowerPlan {
        participants,
        presentations: presentations.map(|n| ((n * times as f64).round() as usize).max(1)),
        ..plan.clone()
    };
    let share = |participants, times, campaigns| {
        let power_share = found_share(&of(participants, times), campaigns, seed)?;
        Ok::<_, DesignError>(FoundShare {
            participants,
            times,
            power_share,
            campaigns,
        })
    };
    let planned = share(campaign.participants, 1, CAMPAIGNS)?;
    let wanted_share = campaign.aims.power_share;
    let too_few =
        |participants, times| Ok(share(participants, times, CAMPAIGNS)?.power_share < wanted_share);
    let participants_needed = match too_few(MOST_PARTICIPANTS, 1)? {
        true => None,
        false => Some(fewest(1, MOST_PARTICIPANTS, |n| too_few(n.max(2), 1))?),
    };
    let most = presentations[0].max(presentations[1]).max(1.0);
    let in_reach = ((MOST_PRESENTATIONS as f64 / most) as usize).clamp(1, MOST_TIMES);
    let times_needed = match too_few(campaign.participants, in_reach)? {
        true => None,
        false => Some(fewest(0, in_reach, |n| too_few(campaign.participants, n))?),
    };
    let middle = (question.shares[0] + question.shares[1]) / 2.0;
    let none = PowerPlan {
        shares: [middle; 2],
        logit_sd: match question.difference {
            // Who are right and wrong as often do not differ in it.
            Difference::Samples(_) => 0.0,
            _ => plan.logit_sd,
        },
        ..plan.clone()
    };
    let times = TIMES.into_iter().filter(|times| *times <= in_reach);
    let curve = |times| {
        let points = PARTICIPANTS.into_iter().map(|participants| {
            Ok(PowerPoint {
                found: share(participants, times, CAMPAIGNS_OF_A_POINT)?,
                half_width_share: cell_of(&of(participants, times), STUDIES, seed)?
                    .half_width_share,
            })
        });
        points.collect::<Result<Vec<_>, DesignError>>()
    };
    Ok(PowerStudy {
        question: question.clone(),
        presentations,
        sets,
        wanted_share,
        planned,
        without_difference_share: found_share(&none, CAMPAIGNS, seed)?,
        participants_needed,
        times_needed,
        curves: times.map(curve).collect::<Result<_, _>>()?,
        plan,
    })
}

impl Work<'_> {
    /// Presentations to each participant of both that are compared; of samples, in how many of how many sets both are.
    fn presentations_of(
        &self,
        question: &PowerQuestion,
    ) -> Result<([f64; 2], Option<[usize; 2]>), DesignError> {
        let tasks = &self.campaign.tasks;
        let judged: Vec<&TaskDescription> = tasks.iter().filter(|task| names(task)).collect();
        let task = |name: &String| {
            let found = judged.iter().find(|task| task.name == *name);
            found
                .copied()
                .ok_or_else(|| unknown("task", name, judged.iter().map(|t| &t.name)))
        };
        let chosen = match &question.task {
            Some(name) => vec![task(name)?],
            None => judged.clone(),
        };
        match &question.difference {
            Difference::Tasks([a, b]) => {
                if a == b {
                    return Err(unknown("other task", b, judged.iter().map(|t| &t.name)));
                }
                Ok(([self.trials(task(a)?)?, self.trials(task(b)?)?], None))
            }
            Difference::People(_) => match chosen[..] {
                [task] => Ok(([self.trials(task)?; 2], None)),
                _ => {
                    let none = String::new();
                    Err(unknown("task", &none, judged.iter().map(|t| &t.name)))
                }
            },
            Difference::Samples(both) => {
                let samples = &self.campaign.samples;
                if let Some(name) = both.iter().find(|name| !samples.contains(name)) {
                    return Err(unknown("sample", name, samples.iter()));
                }
                let [a, b] = both
                    .each_ref()
                    .map(|name| samples.iter().position(|s| s == name));
                let has_both = |set: &&Vec<usize>| {
                    let has = |one: Option<usize>| one.is_some_and(|one| set.contains(&one));
                    has(a) && has(b)
                };
                let sets = self.blocks.iter().filter(has_both).count();
                if sets == 0 || a == b {
                    return Err(DesignError::NeverTogether {
                        pair: both.clone().into(),
                    });
                }
                let mut counts = [0.0; 2];
                for task in chosen {
                    for (count, name) in counts.iter_mut().zip(both) {
                        *count += self.times_in_sets_with(task, name, both)?;
                    }
                }
                Ok((counts, Some([sets, self.blocks.len()])))
            }
        }
    }

    /// How often a participant meets `sample` in `task` where both of a pair are on offer.
    fn times_in_sets_with(
        &self,
        task: &TaskDescription,
        sample: &str,
        both: &[String; 2],
    ) -> Result<f64, DesignError> {
        let samples = &self.campaign.samples;
        let holds = |block: &[usize]| {
            both.iter()
                .all(|name| block.iter().any(|i| samples[*i] == *name))
        };
        let times = match &task.task {
            TaskKind::IdentifyFromMemory => {
                self.blocks.iter().filter(|block| holds(block)).count() as f64
            }
            TaskKind::Associate { sequence } => {
                let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
                let of = |test: &super::presented::Test| {
                    let block = &self.blocks[test.set];
                    if !holds(block) {
                        return 0.0;
                    }
                    if !test.stimuli.is_empty() {
                        let plain = test.stimuli.iter().filter(|name| **name == sample);
                        return plain.count() as f64;
                    }
                    let place = block.iter().position(|i| samples[*i] == sample);
                    place.map_or(0.0, |place| test.presentations[place])
                };
                tests.iter().map(of).sum()
            }
            _ => 0.0,
        };
        Ok(times * self.share() * task.repeats as f64)
    }
}

/// Whether answers of a task name a sample.
fn names(task: &TaskDescription) -> bool {
    matches!(
        task.task,
        TaskKind::Associate { .. } | TaskKind::IdentifyFromMemory
    )
}

fn unknown<'a>(
    what: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a String>,
) -> DesignError {
    DesignError::NotToCompare {
        what,
        name: name.to_owned(),
        known: known.cloned().collect::<Vec<_>>().join(", "),
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

impl PowerStudy {
    /// What was asked, what was assumed, what was found, and what would suffice: one sentence each.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let [a, b] = self.question.shares.map(percent);
        let [one, two] = self.question.difference.names();
        let (shares, people) = match self.question.difference {
            Difference::Samples(_) => (format!("right {a}, taken for the other {b}"), ""),
            Difference::Tasks(_) => (format!("as expected {a} and {b}"), ""),
            Difference::People(_) => (format!("as expected {a} and {b}"), " in each group"),
        };
        let [n, m] = self.presentations.map(|n| format!("{n:.1}"));
        let sets = self.sets.map_or_else(String::new, |[both, all]| {
            format!(", in {both} of {}", counted(all, "set"))
        });
        let asked = format!(
            "Asked: to find that {one} and {two} differ, by a permutation of participants at 5 %. Assumed: {shares}, of the median \
             participant; standard deviation over participants {} of the logit; {n} and {m} presentations to each participant{sets}.",
            self.plan.logit_sd
        );
        let planned = &self.planned;
        let found = (planned.power_share * planned.campaigns as f64).round() as usize;
        let [low, high] = clopper_pearson(found, planned.campaigns);
        let now = format!(
            "{}{people} find it in {} of {} simulated campaigns (95 %: {:.0} to {:.0} %); {} is wanted. Without a difference one is found in {:.1} %.",
            counted(planned.participants, "participant"),
            percent(planned.power_share),
            planned.campaigns,
            100.0 * low,
            100.0 * high,
            percent(self.wanted_share),
            100.0 * self.without_difference_share
        );
        vec![asked, now, self.needed(people)]
    }

    fn needed(&self, people: &str) -> String {
        let more = match self.participants_needed {
            Some(needed) => format!("Needed: {needed} participants{people}"),
            None => "Not even 200 participants suffice".to_owned(),
        };
        let repeats = match self.times_needed {
            Some(1) => format!(
                "; the presentations are enough with {} participants",
                self.planned.participants
            ),
            Some(times) => {
                let sets = self.sets.map_or_else(String::new, |[both, _]| {
                    format!(", in {} with both", counted(both * times, "set"))
                });
                format!(
                    "; or {times} times as many presentations with {} participants, by repeats{sets}",
                    self.planned.participants
                )
            }
            None => format!(
                "; more repeats do not suffice with {} participants, who differ from each other",
                self.planned.participants
            ),
        };
        format!("{more}{repeats}.")
    }

    /// Power and precision over participants.
    #[must_use]
    pub fn table(&self) -> Table {
        let times: Vec<usize> = self
            .curves
            .iter()
            .filter_map(|c| Some(c.first()?.found.times))
            .collect();
        let mut columns = vec![Column::new("participants", "participants")];
        for times in &times {
            let heading = match times {
                1 => "found, %".to_owned(),
                times => format!("{times} × presentations: found, %"),
            };
            columns.push(Column::new(
                &heading,
                &format!("found_percent_times_{times}"),
            ));
            let name = format!("cell_half_width_points_times_{times}");
            columns.push(Column::new("cell ±, points", &name));
        }
        let mut table = Table::new(columns);
        let rows = self.curves.first().map_or(0, Vec::len);
        for row in 0..rows {
            let points: Vec<&PowerPoint> = self.curves.iter().filter_map(|c| c.get(row)).collect();
            let participants = points.first().map_or(0, |point| point.found.participants);
            let mut cells = vec![Cell::from(participants.to_string())];
            for point in points {
                cells.push(Cell::from(format!(
                    "{:.0}",
                    100.0 * point.found.power_share
                )));
                cells.push(Cell::from(format!("{:.0}", 100.0 * point.half_width_share)));
            }
            table.rows.push(cells);
        }
        table
    }
}
