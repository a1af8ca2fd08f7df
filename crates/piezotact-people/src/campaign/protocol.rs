//! The protocol of a campaign: everything that is decided before the first participant, as data (TOML).

mod check;
mod library;
mod method;
mod reference;
mod stimulus;

use std::collections::BTreeMap;

use piezotact::document::Content;
use serde::{Deserialize, Serialize};

use super::design::{Comparison, Factor, PairsWanted, Scoring};
pub use check::{ProtocolError, read};
pub use library::{LIBRARY, from_library};
pub use method::{Adaptive, Catch, Level, Method, Question, Training};
pub use reference::reference;
pub(super) use stimulus::rms_in_words;
pub use stimulus::{BandStated, Stimulus};

/// The version of the form of protocols that this program reads.
pub const FORM: u32 = 1;

/// A protocol.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// The version of the form: 1.
    pub form: u32,
    /// Its name: `isotropic_triplets`.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// What the source leaves open, and what was decided here.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub decided_here: Vec<String>,
    /// All real samples.
    pub samples: Vec<String>,
    /// How many samples the tray holds, at least 1.
    pub tray_slots: usize,
    /// How real samples are turned when they are handed over or laid out, by the sample: `a row of dots along the stroke`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub orientation: BTreeMap<String, String>,
    /// Rendered stimuli other than the plain one of each sample, which has the sample's name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stimuli: Vec<Stimulus>,
    /// The sets of samples that are presented together.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<SampleSet>,
    /// How the samples are explored.
    pub exploration: Exploration,
    /// How stimuli are rendered; absent where none is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendering: Option<Rendering>,
    /// What happens with an interrupted session.
    pub resuming: Resuming,
    /// The people.
    pub panel: Panel,
    /// What the campaign must be able to show; its design is judged by it.
    pub aims: Aims,
    /// The tasks.
    pub tasks: Vec<Task>,
    /// The sessions of each participant, in their order.
    pub sessions: Vec<SessionProtocol>,
}

/// A set of samples.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SampleSet {
    /// Its name: `A`.
    pub name: String,
    /// Its samples.
    pub samples: Vec<String>,
}

/// How samples are explored.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Exploration {
    /// The finger: `dominant index`.
    pub finger: String,
    /// The suggested direction of strokes.
    pub direction: Direction,
}

/// The direction of strokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Towards the body is suggested, and not enforced.
    Proximal,
    /// As the participant likes.
    Free,
}

/// How stimuli are rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rendering {
    /// Which transfer function the drives are made with.
    pub transfer_function: TransferFunctionUse,
    /// Which stroke of a recording is rendered.
    pub stroke: StrokeChoice,
    /// How a stimulus is played.
    pub playing: Playing,
    /// The largest age at its session of a drive and of what it was measured and made from, in hours, above 0 to 87600.
    pub max_age_hours: f64,
}

/// Whose transfer function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "whose", rename_all = "snake_case", deny_unknown_fields)]
pub enum TransferFunctionUse {
    /// The participant's own.
    Own,
    /// The average of a panel, to which no participant belongs.
    Average {
        /// The panel.
        panel: String,
    },
}

/// Which stroke of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum StrokeChoice {
    /// The one closest to the median of its texture.
    Median,
}

/// How a stimulus is played.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "how", rename_all = "snake_case", deny_unknown_fields)]
pub enum Playing {
    /// Once from beginning to end.
    Once,
    /// Again and again, with a pause between, as a finger strokes again.
    Repeated {
        /// The pause between two strokes, in seconds, 0 to 3600.
        pause_s: f64,
        /// The longest time of one presentation, in seconds, up to 3600.
        duration_s: f64,
    },
}

/// A drive may be so much longer than its texture, s: what the inversion needs before and after it.
pub const AROUND_S: f64 = 1.0;

impl Playing {
    /// The longest drive that is presented, in seconds; none where it is played whole.
    #[must_use]
    pub fn longest_s(&self) -> Option<f64> {
        match self {
            Self::Once => None,
            Self::Repeated { duration_s, .. } => Some(duration_s + AROUND_S),
        }
    }
}

/// What happens with an interrupted session.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Resuming {
    /// Where it goes on.
    pub at: ResumeAt,
    /// After how many hours it does not go on at all, above 0 to 87600.
    pub refused_after_hours: f64,
}

/// Where an interrupted session goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ResumeAt {
    /// The interrupted trial is repeated from its beginning.
    TrialAnew,
}

/// The people of a campaign.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// How many participants are planned.
    pub participants: u32,
    /// Panels to which no participant may belong.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disjoint_from: Vec<String>,
}

/// What a campaign must be able to show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Aims {
    /// The session whose design is judged.
    pub session: String,
    /// Which pairs of samples the sets are meant to compare.
    pub pairs: PairsWanted,
    /// How declared orders are scored.
    pub scoring: Scoring,
    /// The wanted power of comparisons, as a share above 0 and below 1.
    pub power_share: f64,
    /// The largest half-width of the 95 % interval of a cell, as a share above 0 and below 0.5.
    pub half_width_share: f64,
    /// The expected share of answers in a cell of interest, of the median participant, above 0 and below 1.
    pub cell_share: f64,
    /// The expected standard deviation over participants, of the logit of that share, 0 to 10.
    pub logit_sd: f64,
    /// Tasks whose results are compared within participants.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub comparisons: Vec<Comparison>,
    /// Orders that are crossed over participants beside those of the blocks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also_counterbalanced: Vec<Factor>,
    /// Tasks of earlier sessions that are compared, in the order in which every participant has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier_tasks: Vec<String>,
}

/// A task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Task {
    /// Its name in data: `task2`.
    pub name: String,
    /// Its title.
    pub title: String,
    /// What the participant is asked, word for word.
    pub instruction: String,
    /// The same for participants with another language, by its tag (BCP 47), such as `fr`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub in_language: BTreeMap<String, TaskWords>,
    /// What the experimenter confirms before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checklist: Vec<String>,
    /// How long one trial takes, in seconds, for the plan of the time: touching and answering, beside one playing in full of each
    /// texture, which is added; where textures are played once as they were stroked, with that.
    pub seconds_per_trial: f64,
    /// Trials before the counted ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<Training>,
    /// Trials whose answer is known, among the counted ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub catch: Option<Catch>,
    /// Whether "I do not know" is an answer. It is noted, and counts in no matrix. An adaptive comparison has none: the participant guesses.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub may_not_know: bool,
    /// What it asks.
    #[serde(flatten)]
    pub kind: TaskKind,
}

/// What pages show of a task in another language. Answers are noted in the words of the task itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TaskWords {
    /// What the participant is asked, word for word.
    pub instruction: String,
    /// The title.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The items of the checklist, in the same order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checklist: Vec<String>,
    /// The descriptors, in the same order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub descriptors: Vec<String>,
    /// The first end of an order, or what the lowest rating stands for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// The other end, or what the highest rating stands for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
}

impl Task {
    /// Its words in the language with the tag `tag` (`fr-CH`), or in the language without a region (`fr`); none where it has only its own.
    #[must_use]
    pub fn words_in(&self, tag: &str) -> Option<&TaskWords> {
        let base = tag.split(['-', '_']).next().unwrap_or_default();
        let find = |wanted: &str| {
            let mut all = self.in_language.iter();
            all.find(|(known, _)| known.eq_ignore_ascii_case(wanted))
        };
        find(tag).or_else(|| find(base)).map(|(_, words)| words)
    }
}

/// What a task asks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TaskKind {
    /// Strokes on each real sample are recorded; nothing is answered.
    Touch {
        /// Strokes on each sample.
        strokes: u32,
    },
    /// The samples are learned by sight, then named blindfold one after the other in random order.
    Identify {
        /// How often each sample is presented.
        presentations: u32,
    },
    /// The samples are put in order by touch.
    Order {
        /// The first end: `roughest`.
        from: String,
        /// The other end: `smoothest`.
        to: String,
        /// The physical order from the first end to the other.
        key: OrderKey,
    },
    /// A sequence of rendered stimuli; to each a real sample of the set is associated.
    Associate {
        /// How the sequence comes about.
        sequence: Sequence,
        /// What the samples are called in answers.
        labels: Labels,
    },
    /// Two stimuli are compared.
    Compare {
        /// What is asked.
        question: Question,
        /// How the stimuli are chosen.
        method: Method,
        /// The pause from an answer to the next trial, which then begins by itself on the pages of a session, in seconds; absent where
        /// the experimenter begins each. An answer is final when it is pressed then.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        next_after_s: Option<f64>,
    },
    /// Descriptors are chosen for each sample.
    Categorise {
        /// The descriptors.
        descriptors: Vec<String>,
        /// How many may be chosen.
        at_most: u32,
    },
    /// Each sample is rated on a scale.
    Rate {
        /// The lowest value.
        from: i64,
        /// The highest value.
        to: i64,
        /// What the lowest value stands for: `not at all`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lowest: Option<String>,
        /// What the highest value stands for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        highest: Option<String>,
    },
}

/// The physical order of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum OrderKey {
    /// That of the protocol's list of samples.
    AsListed,
    /// That of the list from its end to its beginning.
    Reversed,
    /// There is none: no order is right or wrong.
    None,
}

/// How the sequence of an association comes about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "how", rename_all = "snake_case", deny_unknown_fields)]
pub enum Sequence {
    /// Each element is drawn from the samples of the set, independently of the others: repeats and omissions happen.
    Drawn {
        /// The lengths, each with the same probability.
        lengths: Vec<usize>,
    },
    /// Each sample once, in an order that is balanced over participants, within each order of the block's tasks. The participant can
    /// answer by exclusion.
    Balanced,
    /// Fixed sequences, the same for all participants, presented in this order.
    Fixed {
        /// The sequences with their sets.
        tests: Vec<FixedTest>,
    },
}

/// A fixed sequence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FixedTest {
    /// The set.
    pub set: String,
    /// The stimuli in their order.
    pub stimuli: Vec<String>,
}

/// What samples are called in the answers of an association.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "are", rename_all = "snake_case", deny_unknown_fields)]
pub enum Labels {
    /// The names of the samples.
    Names,
    /// A, B, C … in the participant's own order of another task of the same set; the samples stay there.
    OwnOrder {
        /// The ordering task.
        task: String,
    },
}

/// A session of each participant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SessionProtocol {
    /// Its name: `discrimination`.
    pub name: String,
    /// When, relative to the session before it.
    pub when: When,
    /// How long it takes by the source; absent where the source does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_time: Option<SourceTime>,
    /// Its blocks in their order.
    pub blocks: Vec<Block>,
}

/// How long a session takes by the source of a protocol.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SourceTime {
    /// Minutes.
    pub min: u32,
    /// Why the tasks take another time, as a sentence; absent where they take as long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
}

/// When a session takes place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum When {
    /// It is the first, or at any time after the one before it.
    AnyTime,
    /// On a later day than the one before it.
    AnotherDay,
}

/// A block of a session: tasks over the sets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its name.
    pub name: String,
    /// The tasks, one at once after the other.
    pub tasks: Vec<String>,
    /// The order of the tasks.
    pub task_order: OrderRule,
    /// What it goes over.
    pub over: Over,
    /// The order of the sets.
    pub set_order: OrderRule,
    /// How often it is repeated.
    pub repeats: u32,
}

/// What a block goes over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// All samples of the protocol at once.
    AllSamples,
    /// Each of these samples at once, as one set.
    Samples(Vec<String>),
    /// Every set, one after the other.
    EverySet,
    /// One of these shares of the sets; the shares are given to participants in turn.
    SharesOfSets(Vec<Vec<String>>),
}

impl Over {
    /// Whether it goes over sets of the protocol.
    #[must_use]
    pub fn is_of_sets(&self) -> bool {
        matches!(self, Self::EverySet | Self::SharesOfSets(_))
    }
}

/// Samples that are on the tray together.
#[derive(Clone, Copy, Debug)]
pub struct Group<'a> {
    /// The set's name; absent for samples that are no set of the protocol.
    pub set: Option<&'a str>,
    pub samples: &'a [String],
}

/// An order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum OrderRule {
    /// As listed in the protocol, the same for all.
    AsListed,
    /// Random for each participant.
    Shuffled,
    /// A row of a balanced Latin square, so that each stands equally often at each place over participants.
    Balanced,
}

impl Content for Protocol {
    const SCHEMA: &'static str = "protocol";
}

impl Protocol {
    /// The task called `name`.
    #[must_use]
    pub fn task(&self, name: &str) -> Option<&Task> {
        self.tasks.iter().find(|task| task.name == name)
    }

    /// The session called `name`.
    #[must_use]
    pub fn session(&self, name: &str) -> Option<&SessionProtocol> {
        self.sessions.iter().find(|session| session.name == name)
    }

    /// The groups that a block goes over, one after the other, of a participant of each share; one share where everybody has all.
    #[must_use]
    pub fn groups<'a>(&'a self, over: &'a Over) -> Vec<Vec<Group<'a>>> {
        let set = |name: &'a String| Group {
            set: Some(name),
            samples: self.set(name).map_or(&[], |set| &set.samples),
        };
        let at_once = |samples| vec![vec![Group { set: None, samples }]];
        match over {
            Over::AllSamples => at_once(&self.samples),
            Over::Samples(samples) => at_once(samples),
            Over::EverySet => vec![self.sets.iter().map(|one| set(&one.name)).collect()],
            Over::SharesOfSets(shares) => {
                let shares = shares.iter().map(|share| share.iter().map(set).collect());
                shares.collect()
            }
        }
    }

    /// The set called `name`.
    #[must_use]
    pub fn set(&self, name: &str) -> Option<&SampleSet> {
        self.sets.iter().find(|set| set.name == name)
    }
}
