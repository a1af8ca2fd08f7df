//! Faults of a design, and better plans with their cost.

use piezotact::criterion::Criterion;
use piezotact::number::counted;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::construct::Method;

fn people(count: usize) -> String {
    counted(count, "participant")
}

/// What a criterion of a design judges.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Error)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum DesignCriterion {
    /// Pairs that are together in a set.
    #[error("pairs together in a set")]
    PairsTogether,
    /// The share of sequences whose last answer follows from the others.
    #[error("{task}: share of sequences whose last answer follows from the others")]
    ForcedAnswers {
        /// The task.
        task: String,
    },
    /// Kendall's τ of an order with no sample in its position, where one sample moved.
    #[error("{task}: Kendall's τ of an order that position scores as all wrong")]
    PositionsOfOrder {
        /// The task.
        task: String,
    },
    /// Tasks of a comparison that always have the same position.
    #[error("{}: tasks that always have the same position", .tasks.join(", "))]
    FixedPositions {
        /// The tasks compared.
        tasks: Vec<String>,
    },
    /// Participants left over when all cells are filled equally.
    #[error("participants left over when all cells are filled equally")]
    CellsFilled,
    /// The power of a comparison.
    #[error("{}: power", .tasks.join(", "))]
    Power {
        /// The tasks compared.
        tasks: Vec<String>,
    },
    /// The power for a stated difference.
    #[error("{} and {}: power for the stated difference", .between[0], .between[1])]
    DifferenceFound {
        /// What differs.
        between: [String; 2],
    },
    /// The half-width of the interval of a cell.
    #[error("{task}: half-width of the 95 % interval of a cell")]
    HalfWidth {
        /// The task.
        task: String,
    },
    /// The half-width of the interval of a mean rating, as a share of its scale.
    #[error("{task}: half-width of the 95 % interval of a mean rating, as a share of the scale")]
    RatingHalfWidth {
        /// The task.
        task: String,
    },
    /// The share of simulated adaptive runs that decide a threshold.
    #[error("{task}: share of runs that decide a threshold")]
    ThresholdsDecided {
        /// The task.
        task: String,
    },
}

/// A sample and the number of sets that hold it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SampleSetCount {
    /// The sample.
    pub sample: String,
    /// The number of sets.
    pub sets: usize,
}

/// A fault of a design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Error)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum Fault {
    /// Pairs are never together in a set, so their cells stay untested.
    #[error("{} of {pairs} pairs are never together in a set ({together} are): their cells stay untested.", .never.len())]
    PairsNeverTogether {
        /// The number of pairs together.
        together: usize,
        /// All pairs.
        pairs: usize,
        /// The pairs that are never together.
        never: Vec<[String; 2]>,
        /// The samples in the fewest sets.
        rarest: Vec<SampleSetCount>,
    },
    /// Every sequence is a permutation of its set, so answers depend on each other.
    #[error(
        "{task}: every sequence holds each sample of its set once, so the last answer follows from the others; right answers by chance have a standard deviation of {chance_sd:.2}, not {chance_sd_independent:.2}."
    )]
    AnswersByExclusion {
        /// The task.
        task: String,
        /// The sequences that are permutations; absent where they are drawn.
        permutations: Option<usize>,
        /// The standard deviation of right answers by chance, of one participant.
        chance_sd: f64,
        /// What it would be for independent answers.
        chance_sd_independent: f64,
    },
    /// A matrix of samples and positions overstates confusion.
    #[error(
        "{task}: one sample moved from first to last leaves {in_position} of {samples} in position, with Kendall's τ {tau:.3}: positions alone overstate confusion."
    )]
    PositionOverstatesConfusion {
        /// The task.
        task: String,
        /// The number of samples ordered.
        samples: usize,
        /// Samples in their position after one moved from first to last.
        in_position: usize,
        /// Kendall's τ of that order.
        tau: f64,
    },
    /// A task of a comparison always has the same position.
    #[error("{task} is always number {position} of {}: its differences from the others are confounded with order.", .tasks.join(", "))]
    ConfoundedWithOrder {
        /// The task.
        task: String,
        /// Its position among the tasks compared, from 1.
        position: usize,
        /// The tasks compared.
        tasks: Vec<String>,
    },
    /// Participants do not fill the cells of the crossed factors equally.
    #[error("{} cannot fill {cells} cells equally.", people(*.participants))]
    CannotBeBalanced {
        /// The number of cells.
        cells: usize,
        /// The number of participants.
        participants: usize,
    },
    /// The comparison has too little power.
    #[error("{}: {} {} a power of {power_share:.2} for an effect of {effect_ratio:.2} standard deviations, {wanted_share:.2} is wanted.", .tasks.join(", "), people(*.participants), if *.participants == 1 { "has" } else { "have" })]
    PowerTooLow {
        /// The tasks compared.
        tasks: Vec<String>,
        /// The number of participants.
        participants: usize,
        /// The smallest effect that must not be missed.
        effect_ratio: f64,
        /// The power for it.
        power_share: f64,
        /// The power wanted.
        wanted_share: f64,
    },
    /// The stated difference is found too rarely.
    #[error("{} and {}: {} find the stated difference in {:.0} % of campaigns, {:.0} % is wanted.", .between[0], .between[1], people(*.participants), 100.0 * .power_share, 100.0 * .wanted_share)]
    DifferenceMissed {
        /// What differs.
        between: [String; 2],
        /// The number of participants; of each group where groups are compared.
        participants: usize,
        /// How often it is found.
        power_share: f64,
        /// The power wanted.
        wanted_share: f64,
    },
    /// The interval of a mean rating is too wide.
    #[error("{task}: a mean rating of {} has an interval of ±{:.0} % of the scale, ±{:.0} % is wanted.", people(*.participants), 100.0 * .half_width_share, 100.0 * .wanted_share)]
    RatingTooWide {
        /// The task.
        task: String,
        /// The number of participants.
        participants: usize,
        /// The half-width, as a share of the scale.
        half_width_share: f64,
        /// The half-width wanted.
        wanted_share: f64,
    },
    /// Too few runs decide a threshold.
    #[error("{task}: {:.0} % of runs of at most {trials} trials decide a threshold, {:.0} % is wanted.", 100.0 * .decided_share, 100.0 * .wanted_share)]
    ThresholdsOpen {
        /// The task.
        task: String,
        /// The trials of a run at most.
        trials: u32,
        /// The share of runs that decide.
        decided_share: f64,
        /// The share wanted.
        wanted_share: f64,
    },
    /// The interval of a cell is too wide.
    #[error("{task}: a cell of {sample} has an expected interval of ±{:.0} percentage points ({} to each participant), ±{:.0} is wanted.", 100.0 * .half_width_share, counted(*.presentations, "presentation"), 100.0 * .wanted_share)]
    IntervalTooWide {
        /// The task.
        task: String,
        /// The sample with the fewest presentations.
        sample: String,
        /// Its presentations to one participant.
        presentations: usize,
        /// The expected half-width.
        half_width_share: f64,
        /// The half-width wanted.
        wanted_share: f64,
    },
}

/// What a better plan changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Error)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "change", rename_all = "snake_case")]
pub enum Change {
    /// Other sets.
    #[error("{} sets put {together} of {pairs} pairs together{}", .sets.len(), if .sets.len() > *.bound { format!(" (fewer than {bound} cannot)") } else { String::new() })]
    Sets {
        /// How they were built.
        method: Method,
        /// The sets.
        sets: Vec<Vec<String>>,
        /// Pairs together in them, counted.
        together: usize,
        /// All pairs.
        pairs: usize,
        /// The smallest number of sets there can be (Schönheim's bound).
        bound: usize,
        /// The sets of each of two participants, as indices.
        halves: Vec<Vec<usize>>,
    },
    /// Sequences drawn independently.
    #[error("sequences of {shortest} to {longest}, each stimulus drawn from the whole set")]
    IndependentSequences {
        /// The shortest length.
        shortest: usize,
        /// The longest length.
        longest: usize,
    },
    /// Pairwise dominance and Kendall's τ beside the positions.
    #[error("pairwise dominance and Kendall's τ beside the positions")]
    DominanceBesidePosition,
    /// The task takes each position equally often, with vibrations of an earlier session.
    #[error("vibrations from an earlier session, and {} orders of tasks", .orders.len())]
    EarlierMeasurement {
        /// The orders of the tasks compared.
        orders: Vec<Vec<String>>,
    },
    /// Another number of participants.
    #[error("{participants} participants")]
    Participants {
        /// The number.
        participants: usize,
    },
    /// More presentations to each participant.
    #[error("at least {presentations} presentations of each sample to each participant")]
    Presentations {
        /// Presentations of each sample to each participant.
        presentations: usize,
    },
}

/// A better plan and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Error)]
#[error("{change}. Cost: {}.", self.cost())]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BetterPlan {
    /// What changes.
    pub change: Change,
    /// Sets of one participant, now and then.
    pub sets: [usize; 2],
    /// Seconds of one participant, now and then.
    pub participant_s: [f64; 2],
    /// Participants, now and then.
    pub participants: [usize; 2],
    /// Sets of one participant where two share them.
    pub sets_shared_by_two: Option<usize>,
    /// Seconds of one participant where two share the sets.
    pub participant_shared_by_two_s: Option<f64>,
}

impl BetterPlan {
    /// What it costs, in words: participants, their time together, and sets and time of each, beside those of now.
    #[must_use]
    pub fn cost(&self) -> String {
        let minutes = |s: f64| format!("{:.0} min", s / 60.0);
        let mut parts = Vec::new();
        let [now, then] = self.participants;
        if now != then {
            let hours = |i: usize| self.participants[i] as f64 * self.participant_s[i] / 3600.0;
            let other = match then > now {
                true => format!("{} more", counted(then - now, "participant")),
                false => format!("{} fewer", counted(now - then, "participant")),
            };
            parts.push(format!(
                "{other}, {:.1} h of all together instead of {:.1} h",
                hours(1),
                hours(0)
            ));
        }
        let [now, then] = self.sets;
        if now != then {
            parts.push(format!("{then} sets for each participant instead of {now}"));
        }
        let [now, then] = self.participant_s.map(minutes);
        parts.push(match now == then {
            true => format!("{then} for each participant, as now"),
            false => format!("{then} for each participant instead of {now}"),
        });
        if let (Some(sets), Some(s)) = (self.sets_shared_by_two, self.participant_shared_by_two_s) {
            parts.push(format!(
                "shared by two participants, at most {sets} sets and {} each, and each pair is judged by half of the participants: \
                 invite twice as many for the same precision of a cell",
                minutes(s)
            ));
        }
        parts.join("; ")
    }
}

/// A fault with the criterion that found it, and what would be better.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FoundFault {
    /// The fault.
    pub fault: Fault,
    /// The criterion that is not met.
    pub criterion: Criterion<DesignCriterion>,
    /// What would be better; absent where none is known.
    pub better: Option<BetterPlan>,
}
