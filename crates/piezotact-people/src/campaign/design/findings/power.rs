//! How many people, repeats and sets find a stated difference in a campaign as it is designed.

use piezotact::number::counted;
use piezotact::page::{Cell, Column, Table};
use serde::{Deserialize, Serialize};

use super::super::description::{CampaignDescription, TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::power::{
    CORRELATION, FoundShare, MOST_PARTICIPANTS, MOST_PRESENTATIONS, PowerPlan, found_share,
};
use super::super::precision::{CellPlan, cell_precision};
use super::met::Met;
use super::{Work, checked_sets, fewest};
use crate::difference::{Difference, LEVEL_SHARE, MIN_GROUP};
use crate::interval::clopper_pearson;

/// Simulated campaigns for each number of participants and repeats.
const CAMPAIGNS: usize = 1000;
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
    /// The standard deviation over participants, of the logits of the shares.
    pub logit_sd: f64,
    /// The mean number of presentations to each participant.
    pub presentations: [f64; 2],
    /// The share of participants who are presented with one of the two only, and do not count.
    pub one_only_share: f64,
    /// Of two samples: how many sets have both, and how many sets there are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sets: Option<[usize; 2]>,
    /// The power that is wanted.
    pub wanted_share: f64,
    /// As it is designed.
    pub planned: FoundShare,
    /// The smallest probability that the planned participants can give.
    pub smallest_p: f64,
    /// The share of campaigns that find a difference where there is none.
    pub without_difference_share: f64,
    /// The smallest number of participants that suffices; absent above 200.
    pub participants_needed: Option<usize>,
    /// The smallest number of times the presentations that suffices with the planned participants; absent where none of
    /// [`Self::most_times`] does.
    pub times_needed: Option<usize>,
    /// The largest number of times that was looked at.
    pub most_times: usize,
    /// Power and precision over participants, one row for each number of times the presentations.
    pub curves: Vec<Vec<PowerPoint>>,
}

/// The power of `campaign` for a stated difference, by simulated campaigns that end in the test of [`crate::difference`]. Participants
/// are presented with what the rules of the design draw for them.
///
/// # Errors
/// [`DesignError`] for names that the campaign does not have, two samples that no set has both of, shares that do not differ, and numbers
/// out of range.
///
/// Source: docs/decisions/campaigns.md.
pub fn power_study(
    campaign: &CampaignDescription,
    question: &PowerQuestion,
    seed: u64,
) -> Result<PowerStudy, DesignError> {
    let [a, b] = question.shares;
    if a == b {
        return Err(DesignError::OutOfRange {
            what: "the difference between the two stated shares",
            found: 0.0,
            expected: "two shares that differ",
        });
    }
    let sets = checked_sets(campaign)?;
    let work = Work::new(campaign, &sets, seed);
    let met = work.asked(question)?;
    let logit_sd = question.logit_sd.unwrap_or(campaign.aims.logit_sd);
    let simulation = Simulation {
        plan: PowerPlan {
            difference: question.difference.clone(),
            participants: campaign.participants,
            presentations: met.drawn(1),
            shares: question.shares,
            logit_sd,
        },
        met: &met,
        seed,
    };
    let planned = simulation.share(campaign.participants, 1)?;
    let wanted_share = campaign.aims.power_share;
    let too_few =
        |participants, times| Ok(simulation.share(participants, times)?.power_share < wanted_share);
    let participants_needed = match too_few(MOST_PARTICIPANTS, 1)? {
        true => None,
        false => Some(fewest(1, MOST_PARTICIPANTS, |n| too_few(n.max(2), 1))?),
    };
    let counts = simulation.plan.presentations.iter().flatten();
    let most = counts.copied().max().unwrap_or(1).max(1);
    let most_times = (MOST_PRESENTATIONS / most).clamp(1, MOST_TIMES);
    let times_needed = match too_few(campaign.participants, most_times)? {
        true => None,
        false => Some(fewest(0, most_times, |n| {
            too_few(campaign.participants, n)
        })?),
    };
    let times = TIMES.into_iter().filter(|times| *times <= most_times);
    let curves = times.map(|times| simulation.curve(times));
    let one_only = |[n, m]: &&[usize; 2]| (*n == 0) != (*m == 0);
    let drawn = &simulation.plan.presentations;
    Ok(PowerStudy {
        question: question.clone(),
        logit_sd,
        presentations: met.mean(),
        one_only_share: drawn.iter().filter(one_only).count() as f64 / drawn.len().max(1) as f64,
        sets: work.sets_with(question),
        wanted_share,
        smallest_p: question.difference.smallest_p([campaign.participants; 2]),
        without_difference_share: simulation.without_difference()?,
        participants_needed,
        times_needed,
        most_times,
        curves: curves.collect::<Result<_, _>>()?,
        planned,
    })
}

/// Simulated campaigns of a design.
struct Simulation<'a> {
    plan: PowerPlan,
    met: &'a Met<'a>,
    seed: u64,
}

impl Simulation<'_> {
    fn of(&self, participants: usize, times: usize) -> PowerPlan {
        PowerPlan {
            participants,
            presentations: self.met.drawn(times),
            ..self.plan.clone()
        }
    }

    fn share(&self, participants: usize, times: usize) -> Result<FoundShare, DesignError> {
        Ok(FoundShare {
            participants,
            times,
            power_share: found_share(&self.of(participants, times), CAMPAIGNS, self.seed)?,
            campaigns: CAMPAIGNS,
        })
    }

    /// How often a difference is found where there is none.
    fn without_difference(&self) -> Result<f64, DesignError> {
        let middle = (self.plan.shares[0] + self.plan.shares[1]) / 2.0;
        let none = PowerPlan {
            shares: [middle; 2],
            logit_sd: match self.plan.difference {
                // Who are right and wrong as often do not differ in it.
                Difference::Samples(_) => 0.0,
                _ => self.plan.logit_sd,
            },
            ..self.plan.clone()
        };
        found_share(&none, CAMPAIGNS, self.seed)
    }

    /// Power, and the interval of a cell of the first of the two, over participants.
    fn curve(&self, times: usize) -> Result<Vec<PowerPoint>, DesignError> {
        let presentations = (self.met.mean()[0] * times as f64).round() as usize;
        let point = |participants| {
            let cell = CellPlan {
                participants,
                presentations: presentations.max(1),
                share: self.plan.shares[0],
                logit_sd: self.plan.logit_sd,
            };
            Ok(PowerPoint {
                found: self.share(participants, times)?,
                half_width_share: cell_precision(&cell, STUDIES, self.seed)?.half_width_share,
            })
        };
        PARTICIPANTS.into_iter().map(point).collect()
    }
}

impl Work<'_> {
    /// How often participants meet both of what is asked for.
    fn asked(&self, question: &PowerQuestion) -> Result<Met<'_>, DesignError> {
        let tasks = self.campaign.tasks.iter();
        let judged: Vec<&TaskDescription> = tasks.filter(|task| names(task)).collect();
        let known = || judged.iter().map(|task| &task.name);
        let task = |name: &String| {
            let found = judged.iter().find(|task| task.name == *name);
            found.copied().ok_or_else(|| unknown("task", name, known()))
        };
        let chosen = match &question.task {
            Some(name) => vec![task(name)?],
            None => judged.clone(),
        };
        let difference = &question.difference;
        match difference {
            Difference::Tasks([a, b]) => {
                if judged.len() < 2 {
                    return Err(DesignError::TooFewToCompare {
                        known: known().cloned().collect(),
                    });
                }
                let [first, second] = [task(a)?, task(b)?];
                if a == b {
                    return Err(unknown("other task", b, known()));
                }
                self.met(difference, [&[first], &[second]])
            }
            Difference::People(_) | Difference::Again(_) => match chosen[..] {
                [_] => self.met(difference, [&chosen, &[]]),
                _ => Err(DesignError::WhichTask {
                    known: known().cloned().collect::<Vec<_>>().join(", "),
                }),
            },
            Difference::Samples(both) => {
                let samples = &self.campaign.samples;
                let other = (both[0] == both[1]).then_some(&both[1]);
                if let Some(name) = both.iter().find(|name| !samples.contains(name)).or(other) {
                    return Err(unknown("sample, each once,", name, samples.iter()));
                }
                if self.sets_with(question).is_none_or(|[sets, _]| sets == 0) {
                    return Err(DesignError::NeverTogether {
                        pair: both.clone().into(),
                    });
                }
                self.met(difference, [&chosen, &[]])
            }
        }
    }

    /// Of two samples: how many sets have both, and how many sets there are.
    fn sets_with(&self, question: &PowerQuestion) -> Option<[usize; 2]> {
        let Difference::Samples([a, b]) = &question.difference else {
            return None;
        };
        let sets = 0..self.blocks.len();
        let both = sets.filter(|set| self.has(*set, a) && self.has(*set, b));
        Some([both.count(), self.blocks.len()])
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
            Difference::Tasks(_) | Difference::Again(_) => (
                format!(
                    "expected answers {a} and {b}, the logits of one person correlated by {CORRELATION}"
                ),
                "",
            ),
            Difference::People(_) => (format!("expected answers {a} and {b}"), " in each group"),
        };
        let [n, m] = self.presentations.map(|n| format!("{n:.1}"));
        let sets = self.sets.map_or_else(String::new, |[both, all]| {
            format!(", in {both} of {}", counted(all, "set"))
        });
        let one_only = match self.one_only_share {
            share if share > 0.0 => format!(
                "; {} of participants meet one of the two only, and do not count",
                percent(share)
            ),
            _ => String::new(),
        };
        let asked = format!(
            "Asked: to find that {one} and {two} differ, by a permutation of participants at 5 %. Assumed for the median \
             participant: {shares}; standard deviation of the logit over participants {}. On average {n} and {m} presentations to each \
             participant{sets}{one_only}.",
            self.logit_sd
        );
        let planned = &self.planned;
        let found = (planned.power_share * planned.campaigns as f64).round() as usize;
        let [low, high] = clopper_pearson(found, planned.campaigns);
        let now = format!(
            "{}{people} {} it in {} of {} simulated campaigns (95 %: {:.0} to {:.0} %); {} is wanted. Without a difference one is found in {:.1} %.",
            counted(planned.participants, "participant"),
            if planned.participants == 1 && people.is_empty() {
                "finds"
            } else {
                "find"
            },
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
            Some(needed) => format!("Needed: about {needed} participants{people}"),
            None => format!("Not even {MOST_PARTICIPANTS} participants{people} suffice"),
        };
        format!("{more}; {}.", self.needed_repeats())
    }

    fn is_few_in_groups(&self) -> bool {
        let of_people = matches!(self.question.difference, Difference::People(_));
        of_people && self.planned.participants < MIN_GROUP
    }

    /// What more presentations do with the planned participants.
    fn needed_repeats(&self) -> String {
        let people = self.planned.participants;
        match self.times_needed {
            Some(1) => format!("{people} participants have presentations enough"),
            Some(times) => {
                let sets = self.sets.map_or_else(String::new, |[both, _]| {
                    format!(", in {} with both", counted(both * times, "set"))
                });
                format!(
                    "or {times} times as many presentations with {people} participants, by repeats{sets}"
                )
            }
            None if self.is_few_in_groups() => format!(
                "groups of {people} decide nothing, however often each answers: {MIN_GROUP} participants or more in each are needed"
            ),
            None if self.smallest_p > LEVEL_SHARE => format!(
                "with {people} participants no test of people reaches 5 %, however often each answers: the smallest p is {:.3}",
                self.smallest_p
            ),
            None => format!(
                "up to {} times as many presentations do not suffice with {people} participants{}",
                self.most_times,
                match self.logit_sd > 0.0 {
                    true => ", who differ from each other",
                    false => "",
                }
            ),
        }
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
