//! The design of a campaign as one value: what is asked of participants, what it can show, and its faults.

mod page;

use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::document::Content;
use piezotact::number::counted;
use piezotact::page::{Cell, Column, Table};
use serde::{Deserialize, Serialize};

use super::describe::describe;
use super::design::{
    BetterPlan, CampaignDescription, Change, DesignCriterion, DesignError, DesignReport, Fault,
    FoundFault, PairsWanted, PowerQuestion, PowerStudy, SampleCount, TaskTime, design_findings,
    power_study, task_times,
};
use super::protocol::{Protocol, SessionProtocol, SourceTime, When};

/// A task of a session, with its trials and its time for one participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SessionTask {
    /// The block of the session.
    pub block: String,
    /// The title of the task.
    pub title: String,
    /// The task, its mean number of trials, and seconds.
    #[serde(flatten)]
    pub time: TaskTime,
}

/// A session, with its time for one participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SessionTime {
    /// The session.
    pub session: String,
    /// When it takes place, relative to the one before it.
    pub when: When,
    /// Its tasks.
    pub tasks: Vec<SessionTask>,
    /// Seconds.
    pub time_s: f64,
    /// How long it takes by the source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_time: Option<SourceTime>,
}

impl SessionTime {
    /// Minutes in which textures play.
    fn played_min(&self) -> f64 {
        let tasks = self.tasks.iter();
        tasks.map(|task| task.time.played_s).sum::<f64>() / 60.0
    }

    /// How its time agrees with that of the source, in one sentence; `None` where the source does not say.
    fn source_sentence(&self) -> Option<String> {
        let source = self.source_time.as_ref()?;
        let of_source = f64::from(source.min);
        let planned = self.time_s / 60.0;
        let session = &self.session;
        if (planned - of_source).abs() <= AGREES_SHARE * of_source {
            return Some(format!(
                "The source has {of_source:.0} min for {session}: as here."
            ));
        }
        let why_not = match &source.why_not {
            Some(why_not) => why_not.as_str(),
            None => "The protocol does not say why.",
        };
        Some(format!(
            "The source has {of_source:.0} min for {session}, not {planned:.0}. {why_not}"
        ))
    }
}

/// The design of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CampaignDesign {
    /// The protocol's name.
    pub protocol: String,
    /// Its title.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// All real samples of the protocol, also those that stand in no set.
    pub samples: Vec<String>,
    /// All sessions of one participant.
    pub sessions: Vec<SessionTime>,
    /// The session whose design is judged.
    pub judged_session: String,
    /// Tasks of earlier sessions that are judged with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier_tasks: Vec<String>,
    /// What was judged.
    pub campaign: CampaignDescription,
    /// What it can show, and its faults.
    pub report: DesignReport,
    /// How often a stated difference is found, where one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerStudy>,
}

impl Content for CampaignDesign {
    const SCHEMA: &'static str = "campaign_design";
}

/// The design of the campaign of `protocol`: its sessions with seconds of one participant, and the check of the session that its
/// aims name. `seed` serves simulations and searches.
///
/// # Errors
/// [`DesignError`] for a design that cannot be checked: sequences that cannot be, numbers out of range.
///
/// Source: docs/decisions/campaigns.md.
pub fn campaign_design(protocol: &Protocol, seed: u64) -> Result<CampaignDesign, DesignError> {
    let campaign = describe(protocol);
    let report = design_findings(&campaign, seed)?;
    let sessions = protocol.sessions.iter();
    Ok(CampaignDesign {
        protocol: protocol.name.clone(),
        title: protocol.title.clone(),
        source: protocol.source.clone(),
        samples: protocol.samples.clone(),
        sessions: sessions
            .map(|session| session_time(protocol, session))
            .collect::<Result<_, _>>()?,
        judged_session: protocol.aims.session.clone(),
        earlier_tasks: protocol.aims.earlier_tasks.clone(),
        campaign,
        report,
        power: None,
    })
}

/// Up to this share of the source's time, a session takes as long as there.
const AGREES_SHARE: f64 = 0.1;

/// The time of a session, block by block: a task can stand in several blocks.
fn session_time(
    protocol: &Protocol,
    session: &SessionProtocol,
) -> Result<SessionTime, DesignError> {
    let mut tasks = Vec::new();
    for block in &session.blocks {
        let mut alone = protocol.clone();
        alone.aims.session.clone_from(&session.name);
        alone.aims.earlier_tasks.clear();
        alone.aims.comparisons.clear();
        alone.sessions = vec![SessionProtocol {
            blocks: vec![block.clone()],
            ..session.clone()
        }];
        for time in task_times(&describe(&alone))? {
            let title = protocol.task(&time.task).map(|task| task.title.clone());
            tasks.push(SessionTask {
                block: block.name.clone(),
                title: title.unwrap_or_default(),
                time,
            });
        }
    }
    Ok(SessionTime {
        session: session.name.clone(),
        when: session.when,
        time_s: tasks.iter().map(|task| task.time.time_s).sum(),
        source_time: session.source_time.clone(),
        tasks,
    })
}

/// What the columns of a table of chance say.
const CHANCE_COLUMNS: &str = "enumerated: mean ± standard deviation (SD). Where each sample is presented once, this is the SD of people who \
    answer each once; who repeats answers has the SD beside it. Above chance from: the smallest possible number that chance reaches with \
    a probability of 5 % at most, whether answers are repeated or not; together: of all participants. Whole order: its probability by \
    chance. Last follows: the share of sequences whose last answer follows from the others.";

fn minutes(time_s: f64) -> String {
    format!("{:.0}", time_s / 60.0)
}

/// How often, in words.
fn times(mean: f64) -> String {
    match number(mean).as_str() {
        "1" => "once".to_owned(),
        "2" => "twice".to_owned(),
        other => format!("{other} times"),
    }
}

/// With how many presentations a cell was simulated, where their mean is no whole number.
fn simulated(of: &SampleCount) -> String {
    let whole = of.precision.plan.presentations;
    match (of.presentations - whole as f64).abs() < 1e-9 {
        true => String::new(),
        false => format!(" on average (simulated: {})", times(whole as f64)),
    }
}

/// A mean number of trials or presentations: whole numbers without decimals.
fn number(mean: f64) -> String {
    match (mean - mean.round()).abs() < 1e-9 {
        true => format!("{mean:.0}"),
        false => format!("{mean:.1}"),
    }
}

impl CampaignDesign {
    /// The design with the power for a stated difference, and with the fault where it is found more rarely than is wanted.
    ///
    /// # Errors
    /// As [`power_study`].
    ///
    /// Source: [`power_study`].
    pub fn with_power(mut self, question: &PowerQuestion) -> Result<Self, DesignError> {
        let study = power_study(&self.campaign, question, self.report.seed)?;
        let (power_share, wanted_share) = (study.planned.power_share, study.wanted_share);
        let between = question.difference.names().clone();
        let what = DesignCriterion::DifferenceFound {
            between: between.clone(),
        };
        // Judged by the share itself: what is found too rarely is never called enough for the interval of a simulation.
        let limit = Limit::at_least(wanted_share);
        let criterion = Criterion::new(what, "", power_share, None, limit);
        self.report.criteria.push(criterion.clone());
        if criterion.outcome == Outcome::NotMet {
            let participants = study.planned.participants;
            let better = study.participants_needed.map(|needed| BetterPlan {
                change: Change::Participants {
                    participants: needed,
                },
                sets: [self.sets_each(); 2],
                participant_s: [self.report.participant_s; 2],
                participants: [participants, needed],
                sets_shared_by_two: None,
                participant_shared_by_two_s: None,
            });
            let fault = Fault::DifferenceMissed {
                between,
                participants,
                power_share,
                wanted_share,
            };
            self.report.faults.push(FoundFault {
                fault,
                criterion,
                better,
            });
        }
        self.power = Some(study);
        Ok(self)
    }

    /// Sets of one participant.
    fn sets_each(&self) -> usize {
        let campaign = &self.campaign;
        campaign
            .sets
            .len()
            .div_ceil(campaign.sets_shared_over.max(1))
    }

    /// The outcome of all rules together; not decided where none was judged.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        let has = |outcome| self.report.criteria.iter().any(|c| c.outcome == outcome);
        match () {
            () if has(Outcome::NotMet) => Outcome::NotMet,
            () if has(Outcome::NotDecided) || !has(Outcome::Met) => Outcome::NotDecided,
            () => Outcome::Met,
        }
    }

    /// The conclusion in one sentence: how many faults, how many rules are met or not decided.
    #[must_use]
    pub fn sentence(&self) -> String {
        let rules = self.report.criteria.len();
        if rules == 0 {
            return "No rule applies to this design: nothing was judged.".into();
        }
        let mut text = match self.report.faults.len() {
            0 => format!("No fault was found: {} judged", counted(rules, "rule")),
            faults => format!(
                "{} found: of {} judged, {faults} not met",
                counted(faults, "fault"),
                counted(rules, "rule")
            ),
        };
        let open = self.open();
        if !open.is_empty() {
            text += &format!("; {} not decided: {}", open.len(), open.join("; "));
        }
        text + "."
    }

    /// Each rule that is not decided, with what would decide it.
    fn open(&self) -> Vec<String> {
        let all = self.report.criteria.iter();
        let open = all.filter(|one| one.outcome == Outcome::NotDecided);
        open.map(|one| {
            let decides = match &one.what {
                _ if one.found.is_some() => {
                    "the interval of the simulation holds the limit, and one participant or trial more or fewer decides"
                }
                DesignCriterion::FixedPositions { .. } => "the orders of the tasks decide",
                DesignCriterion::ThresholdsDecided { .. } => {
                    "it is too long to be simulated: fewer levels, thresholds or trials decide"
                }
                _ => "nothing was measured",
            };
            format!("{} ({decides})", one.what)
        })
        .collect()
    }

    /// What is asked in one sentence: participants, samples, sets, tray.
    #[must_use]
    pub fn asked_sentence(&self) -> String {
        let campaign = &self.campaign;
        let mut sizes: Vec<usize> = campaign.sets.iter().map(Vec::len).collect();
        sizes.sort_unstable();
        let sets = match (sizes.first(), sizes.last()) {
            (Some(least), Some(most)) if least == most => {
                format!("{} of {most}", counted(sizes.len(), "set"))
            }
            (Some(least), Some(most)) => {
                format!("{} of {least} to {most}", counted(sizes.len(), "set"))
            }
            _ => "no sets".to_owned(),
        };
        let some = match campaign.samples.len() {
            in_sets if campaign.sets.is_empty() || in_sets == self.samples.len() => String::new(),
            in_sets => format!("{in_sets} of them in "),
        };
        let shared = match campaign.sets_shared_over {
            1 => String::new(),
            over => format!(", shared by {over} participants"),
        };
        format!(
            "{}; {}, {some}{sets}{shared}; a tray of {}.",
            counted(campaign.participants, "participant"),
            counted(self.samples.len(), "sample"),
            campaign.tray
        )
    }

    /// What is judged, in one sentence.
    #[must_use]
    pub fn judged_sentence(&self) -> String {
        let earlier = match self.earlier_tasks.is_empty() {
            true => String::new(),
            false => format!(", with {} before it", self.earlier_tasks.join(", ")),
        };
        format!(
            "Judged is the session {}{earlier}: {} min of each participant. The costs of better plans are counted in this time.",
            self.judged_session,
            minutes(self.report.participant_s)
        )
    }

    /// The sessions of one participant: items (orders, stimuli of a sequence, samples, pairs, ratings) and minutes of each task, then of each session.
    #[must_use]
    pub fn sessions_table(&self) -> Table {
        let names = [
            ("session", "session"),
            ("when", "when"),
            ("task", "task"),
            ("what is done", "title"),
            ("items", "items"),
            ("min", "time_min"),
            ("of it playing", "played_min"),
        ];
        let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
        for session in &self.sessions {
            let when = match session.when {
                When::AnyTime => "any time",
                When::AnotherDay => "another day",
            };
            for (i, task) in session.tasks.iter().enumerate() {
                let once = |text: &str| Cell::from(if i == 0 { text } else { "" });
                table.rows.push(vec![
                    once(&session.session),
                    once(when),
                    Cell::from(task.time.task.as_str()),
                    Cell::from(task.title.as_str()),
                    Cell::from(number(task.time.trials)),
                    Cell::Number(task.time.time_s / 60.0),
                    Cell::Number(task.time.played_s / 60.0),
                ]);
            }
        }
        table
    }

    /// The minutes of each session, what plays in them, and how they agree with the source; a sentence each.
    #[must_use]
    pub fn time_sentence(&self) -> String {
        let sessions = self.sessions.iter();
        let parts: Vec<String> = sessions
            .map(|session| {
                let playing = match session.played_min() {
                    min if min > 0.0 => format!(" ({min:.1} min of it textures play)"),
                    _ => String::new(),
                };
                let of_all = minutes(session.time_s);
                format!("{} {of_all} min{playing}", session.session)
            })
            .collect();
        let all: f64 = self.sessions.iter().map(|session| session.time_s).sum();
        let mut said = vec![format!(
            "One participant: {}; {} min in all. {} together: {:.1} h. Arrival, consent and pauses are not counted.",
            parts.join(", "),
            minutes(all),
            counted(self.campaign.participants, "participant"),
            self.campaign.participants as f64 * all / 3600.0
        )];
        said.extend(
            self.sessions
                .iter()
                .filter_map(SessionTime::source_sentence),
        );
        said.join(" ")
    }

    /// What chance reaches in each task whose answers are right or wrong; without columns that say nothing of any task.
    #[must_use]
    pub fn chance_table(&self) -> Table {
        let names = [
            ("task", "task"),
            ("answers", "answers"),
            ("chance level", "chance_share"),
            ("right by chance", "right_by_chance"),
            ("with repeats", "right_if_independent"),
            ("above chance from", "beyond_chance_from"),
            ("together", "beyond_chance_together_from"),
            ("whole order", "whole_order_share"),
            ("SD of τ", "tau_sd"),
            ("last follows", "forced_share"),
        ];
        let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
        let chance = self.report.chance.iter();
        table.rows = chance
            .map(|of| {
                let level = (of.answers > 0.0).then(|| of.mean / of.answers);
                let share = |value: Option<f64>| value.map_or(Cell::Missing(()), share_cell);
                let from = |from: Option<usize>| {
                    Cell::from(from.map_or("none".to_owned(), |from| from.to_string()))
                };
                vec![
                    Cell::from(of.task.as_str()),
                    Cell::from(number(of.answers)),
                    share(level),
                    Cell::from(format!("{:.1}\u{a0}±\u{a0}{:.2}", of.mean, of.sd)),
                    Cell::from(format!("±\u{a0}{:.2}", of.sd_independent)),
                    from(of.beyond_chance_from),
                    from(of.beyond_chance_together_from),
                    share(of.whole_order_share),
                    Cell::from(of.tau_sd),
                    share(of.forced_share),
                ]
            })
            .collect();
        let said: Vec<bool> = (0..table.columns.len())
            .map(|i| (table.rows.iter()).any(|row| row[i] != Cell::Missing(())))
            .collect();
        let mut kept = said.iter();
        table.columns.retain(|_| kept.next() == Some(&true));
        for row in &mut table.rows {
            let mut kept = said.iter();
            row.retain(|_| kept.next() == Some(&true));
        }
        table
    }

    /// What the columns of [`Self::chance_table`] say.
    #[must_use]
    pub fn chance_note(&self) -> String {
        let whose = match self.campaign.sets_shared_over {
            1 => "one participant",
            _ => "the participants who share the sets",
        };
        format!("Right answers of {whose} by chance, {CHANCE_COLUMNS}")
    }

    /// The precision of cells and the power of comparisons for the planned number of participants, a sentence each.
    #[must_use]
    pub fn precision_sentences(&self) -> Vec<String> {
        let participants = counted(self.campaign.participants, "participant");
        let cells = self.report.precision.iter().map(|of| {
            format!(
                "{}: a cell of {}, presented {} to each participant{}, has an expected 95 % interval of ±{:.0} percentage points with \
                 {participants} ({} simulated studies; assumed: {:.0} % of the answers of the median participant are in the cell, \
                 standard deviation of the logit over participants {}).",
                of.task,
                of.sample,
                times(of.presentations),
                simulated(of),
                100.0 * of.precision.half_width_share,
                of.precision.studies,
                100.0 * of.precision.plan.share,
                of.precision.plan.logit_sd
            )
        });
        let power = self.report.power.iter().map(|of| {
            format!(
                "{}: {participants} have a power of {:.2} for an effect of {:.2} standard deviations.",
                of.tasks.join(", "),
                of.power_share,
                of.effect_ratio
            )
        });
        let crossing = self.report.crossing.iter().map(|of| {
            format!(
                "Crossed orders: {}, {} in each and {} left over.",
                counted(of.cells, "cell"),
                counted(of.in_every_cell, "participant"),
                of.left_over
            )
        });
        let aims = self.campaign.aims;
        let ratings = self.report.ratings.iter().map(|of| {
            format!(
                "{}: a mean rating has an expected 95 % interval of ±{:.2} on its scale of {} (±{:.0} % of it) with {participants} \
                 (Student's t; assumed: the median participant rates at {:.0} % of the scale, standard deviation of the logit over \
                 participants {}).",
                of.task,
                of.half_width_share * of.range as f64,
                counted(of.range as usize, "step"),
                100.0 * of.half_width_share,
                100.0 * aims.cell_share,
                aims.logit_sd
            )
        });
        let thresholds = self.report.thresholds.iter().map(|of| {
            format!(
                "{}: {:.0} % of {} simulated runs decide a threshold (assumed: answers as a Weibull function in dB says, with thresholds \
                 from {} to {}).",
                of.task,
                100.0 * of.decided_share,
                of.runs,
                of.thresholds[0],
                of.thresholds[1]
            )
        });
        let cells = cells.chain(ratings).chain(thresholds);
        cells.chain(power).chain(crossing).collect()
    }

    /// How many pairs of samples are together in a set, in one sentence; `None` without sets.
    #[must_use]
    pub fn pairs_sentence(&self) -> Option<String> {
        let coverage = self.report.coverage.as_ref()?;
        let together = coverage.times.iter().filter(|of| of.sets > 0);
        let times: Vec<String> = together
            .map(|of| format!("{} in {}", of.pairs, counted(of.sets, "set")))
            .collect();
        let never = match (coverage.never.len(), self.campaign.pairs_wanted) {
            (0, _) => String::new(),
            (pairs, PairsWanted::All) => {
                format!(" The other {pairs} are never: untested, which is not 0 %.")
            }
            (pairs, PairsWanted::WithinSets) => {
                format!(" The other {pairs} are never, and are not meant to be compared.")
            }
        };
        let counts = coverage.presentations.iter();
        let sets = match (counts.clone().min(), counts.max()) {
            (Some(least), Some(most)) if least == most => counted(*most, "set"),
            (Some(least), Some(most)) => format!("{least} to {}", counted(*most, "set")),
            _ => counted(0, "set"),
        };
        Some(format!(
            "{} of {} pairs are together in a set ({}).{never} Each sample stands in {sets}.",
            coverage.together,
            coverage.pairs,
            times.join(", ")
        ))
    }

    /// Each sample with the number of its sets and the samples that it is never together with; `None` without sets.
    #[must_use]
    pub fn pairs_table(&self) -> Option<Table> {
        let coverage = self.report.coverage.as_ref()?;
        let names = [
            ("sample", "sample"),
            ("sets", "sets"),
            ("never together with", "never"),
        ];
        let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
        for (i, sample) in self.report.samples.iter().enumerate() {
            let others = coverage.never.iter().filter_map(|[a, b]| match i {
                i if i == *a => Some(*b),
                i if i == *b => Some(*a),
                _ => None,
            });
            let others: Vec<&str> = others.map(|j| self.report.samples[j].as_str()).collect();
            table.rows.push(vec![
                Cell::from(sample.as_str()),
                Cell::from(coverage.presentations[i].to_string()),
                Cell::from(others.join(", ")),
            ]);
        }
        Some(table)
    }
}

/// A share that can be small: of 14 samples one order of 87 billions.
fn share_cell(share: f64) -> Cell {
    Cell::from(match share {
        0.0 => "0\u{a0}%".to_owned(),
        1.0 => "100\u{a0}%".to_owned(),
        share if share >= 0.001 => format!("{:.1}\u{a0}%", 100.0 * share),
        share => format!("1\u{a0}in\u{a0}{:.1e}", 1.0 / share),
    })
}

#[cfg(test)]
mod tests;
