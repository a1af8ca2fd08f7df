//! Distinguishability of pairs of samples: outcomes, and the criteria from which they follow.

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Outcome};
use crate::perception::Contribution;
use crate::statistics::Permuted;

/// More pairs than this are counted and not listed.
const LISTED: usize = 15;

/// The criteria for a pair of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PairCriterion {
    /// The distance against the just-noticeable difference and the range that was published of it.
    JustNoticeableDifference,
    /// The distance against how far halves of one of the two samples lie apart, of 95 % of divisions into halves.
    DistanceWithin,
    /// The p-value of the distance under the hypothesis that the strokes of both are from one sample, adjusted for all pairs of
    /// the study: up to α they differ, above it nothing is decided.
    Chance,
    /// The distance with what lies around the lines that are left out, less the power that these have at rest: a difference may lie there.
    LeftOut,
    /// The distance without the lines of which it is not known whether the textures make them.
    InDoubt,
    /// The distance where the spectra of all samples are divided by what their sensors show at rest: a sensor of another gain or unit differs
    /// there as it does in the strokes.
    AtRest,
    /// The difference over time and channels of the means of the strokes, against 1 JND and against how far halves of one of the two samples
    /// lie apart.
    OverTime,
    /// The p-value of that difference, as [`Self::Chance`].
    ChanceOverTime,
}

/// Whether two samples are distinguishable by their vibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Distinguishability {
    /// They differ by more than strokes of one sample do, and by more than the published range of the JND.
    ToldApart,
    /// They differ by less than the JND, at which 75 % of judgements are right.
    BelowJnd,
    /// The strokes are compatible with both.
    NotDecided,
}

impl Distinguishability {
    /// The outcome in plain words.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::ToldApart => "distinguishable",
            Self::BelowJnd => "below the just-noticeable difference (75 % correct)",
            Self::NotDecided => "not decided",
        }
    }

    pub(super) fn of(criteria: &[Criterion<PairCriterion>]) -> Self {
        let find = |what| criteria.iter().find(|c| c.what == what).map(|c| c.outcome);
        let by_spectra = Self::by_spectra(criteria);
        let (time, chance) = (
            find(PairCriterion::OverTime),
            find(PairCriterion::ChanceOverTime),
        );
        // What a machine adds to a stroke, or another gain, is felt over time too.
        let mut doubted = criteria.iter();
        let doubted = doubted.any(|c| {
            use PairCriterion::{AtRest, InDoubt, LeftOut};
            matches!(c.what, AtRest | InDoubt | LeftOut)
        });
        match (by_spectra, time) {
            (Self::ToldApart, _) | (_, None) => by_spectra,
            (_, Some(Outcome::NotMet)) if chance == Some(Outcome::Met) && !doubted => {
                Self::ToldApart
            }
            (Self::BelowJnd, Some(Outcome::Met)) => Self::BelowJnd,
            _ => Self::NotDecided,
        }
    }

    /// What the spectra of the strokes say.
    fn by_spectra(criteria: &[Criterion<PairCriterion>]) -> Self {
        let outcome = |what| {
            let found = criteria.iter().find(|c| c.what == what);
            found.map_or(Outcome::NotDecided, |c| c.outcome)
        };
        let jnd = outcome(PairCriterion::JustNoticeableDifference);
        let mut left_out = criteria.iter().filter(|c| c.what == PairCriterion::LeftOut);
        let may_hide = left_out.any(|c| c.outcome != Outcome::Met);
        let mut in_doubt = criteria.iter().filter(|c| c.what == PairCriterion::InDoubt);
        if in_doubt.any(|c| c.outcome != jnd) {
            return Self::NotDecided;
        }
        let mut at_rest = criteria.iter().filter(|c| c.what == PairCriterion::AtRest);
        if jnd == Outcome::NotMet && at_rest.any(|c| c.outcome != Outcome::NotMet) {
            return Self::NotDecided;
        }
        match (
            jnd,
            outcome(PairCriterion::DistanceWithin),
            outcome(PairCriterion::Chance),
        ) {
            (Outcome::Met, ..) if may_hide => Self::NotDecided,
            (Outcome::Met, ..) => Self::BelowJnd,
            (Outcome::NotMet, Outcome::NotMet, Outcome::Met) => Self::ToldApart,
            _ => Self::NotDecided,
        }
    }
}

/// Two samples compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Pair {
    /// The first, as an index of the names.
    pub a: usize,
    /// The second.
    pub b: usize,
    /// Their distance, JND.
    pub distance_jnd: f64,
    /// The 95 % confidence interval of the distance, JND; absent where a sample has one stroke or recording.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub interval_jnd: Option<[f64; 2]>,
    /// The parts of the distance: spectrum, level and balance, JND.
    pub parts_jnd: [f64; 3],
    /// The permutation test; absent where a sample has one stroke or recording.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub permuted: Option<Permuted>,
    /// Its probability adjusted for all pairs of the study.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub p_adjusted: Option<f64>,
    /// The features in which they differ most over time and channels.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub felt_in: Vec<Contribution>,
    /// Whether neither reaches the detection threshold.
    pub neither_felt: bool,
    /// The criteria.
    pub criteria: Vec<Criterion<PairCriterion>>,
    /// The outcome.
    pub outcome: Distinguishability,
}

/// The independent units of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SampleUnit {
    /// Strokes are taken for independent.
    Strokes,
    /// Recordings are; the strokes of one are averaged.
    Recordings,
}

impl SampleUnit {
    /// "strokes" or "recordings".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Strokes => "strokes",
            Self::Recordings => "recordings",
        }
    }
}

/// Samples and which of them are distinguishable.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Groups {
    /// What they share beside other settings, as a person says it; a study sets it, and it is empty where there is one setting.
    pub setting: String,
    /// The names.
    pub names: Vec<String>,
    /// How many strokes, or recordings, each has.
    pub units: Vec<usize>,
    /// How far two halves of each sample's strokes lie apart, JND, in the median over divisions; absent for one stroke.
    pub within_jnd: Vec<Option<f64>>,
    /// Every pair.
    pub pairs: Vec<Pair>,
    /// The largest sets of two and more in which every pair is below the just-noticeable difference, as indices of names. A sample may
    /// stand in several.
    pub below_jnd: Vec<Vec<usize>>,
}

impl Groups {
    /// The pair of the samples `i` and `j`, in any order.
    #[must_use]
    pub fn pair(&self, i: usize, j: usize) -> Option<&Pair> {
        let (a, b) = (i.min(j), i.max(j));
        self.pairs.iter().find(|pair| pair.a == a && pair.b == b)
    }

    /// The sets below the just-noticeable difference, by name.
    #[must_use]
    pub fn below_by_name(&self) -> Vec<Vec<String>> {
        self.below_jnd
            .iter()
            .map(|group| group.iter().map(|i| self.names[*i].clone()).collect())
            .collect()
    }

    /// The pairs with this outcome.
    pub fn with(&self, outcome: Distinguishability) -> impl Iterator<Item = &Pair> {
        self.pairs
            .iter()
            .filter(move |pair| pair.outcome == outcome)
    }
}

impl Pair {
    fn outcome_of(&self, what: PairCriterion) -> Option<Outcome> {
        let mut criteria = self.criteria.iter();
        criteria.find(|c| c.what == what).map(|c| c.outcome)
    }

    /// Why nothing is decided, in a few words.
    fn open_because(&self, groups: &Groups) -> String {
        let is = |what, outcome| {
            let mut all = self.criteria.iter();
            all.any(|c| c.what == what && c.outcome == outcome)
        };
        if self.interval_jnd.is_none() {
            return "a sample has only one stroke or recording".into();
        }
        let jnd = self.outcome_of(PairCriterion::JustNoticeableDifference);
        let in_doubt = self.outcome_of(PairCriterion::InDoubt);
        if jnd != Some(Outcome::NotDecided) && in_doubt.is_some() && in_doubt != jnd {
            return "the outcome is another one without the lines that may be of the machine or the mains".into();
        }
        let at_rest = self.outcome_of(PairCriterion::AtRest);
        if jnd == Some(Outcome::NotMet) && at_rest.is_some() && at_rest != jnd {
            return "the sensors differ as much while nothing is touched: check their units and gains".into();
        }
        let spectra = Distinguishability::by_spectra(&self.criteria);
        if spectra == Distinguishability::BelowJnd {
            return self.time_open_because().into();
        }
        if is(PairCriterion::OverTime, Outcome::NotMet)
            && is(PairCriterion::ChanceOverTime, Outcome::Met)
        {
            return "over time it is noticed, but what may not be of the texture (lines of the machine or the mains, sensors at rest) is felt over \
                    time too"
                .into();
        }
        if is(PairCriterion::JustNoticeableDifference, Outcome::Met) {
            return "a difference may lie around the lines that are left out".into();
        }
        if !is(PairCriterion::JustNoticeableDifference, Outcome::NotMet) {
            return "the interval overlaps the published range of the just-noticeable difference"
                .into();
        }
        match self.p_adjusted {
            Some(p) if !is(PairCriterion::Chance, Outcome::Met) => {
                if self.is_smallest_p(groups) {
                    format!("p = {p:.3} is the smallest that so few repetitions can give")
                } else {
                    format!("the difference may be due to chance, p = {p:.3}")
                }
            }
            _ => "the halves of one sample differ by as much".into(),
        }
    }

    /// ", over time 2.31 JND (1.65–3.23), in modulation around 24 Hz (Pacini)"; empty where it is not computed.
    fn over_time(&self) -> String {
        let mut criteria = self.criteria.iter();
        let time = criteria.find(|c| c.what == PairCriterion::OverTime);
        let Some((found, [low, high])) = time.and_then(|c| c.found.zip(c.interval)) else {
            return String::new();
        };
        let features = match self.felt_in_words() {
            none if none.is_empty() => none,
            features => format!(", in {features}"),
        };
        format!(", over time {found:.2} JND ({low:.2}–{high:.2}){features}")
    }

    /// The features in which they differ most over time and channels: "modulation around 24 Hz (Pacini) and pitch"; empty where they do not.
    #[must_use]
    pub fn felt_in_words(&self) -> String {
        let features: Vec<String> = self.felt_in.iter().map(ToString::to_string).collect();
        features.join(" and ")
    }

    /// Why the time course decides nothing of two samples whose spectra are alike.
    fn time_open_because(&self) -> &'static str {
        let mut criteria = self.criteria.iter();
        let time = criteria.find(|c| c.what == PairCriterion::OverTime);
        let low = time.and_then(|c| c.interval).map(|[low, _]| low);
        match (low, time.map(|c| c.outcome)) {
            (None, _) => "the time course is not known: record at 1 kHz or faster",
            (_, Some(Outcome::NotMet))
                if self.outcome_of(PairCriterion::ChanceOverTime) == Some(Outcome::Met) =>
            {
                "lines of a machine, the mains or the sensors may make the difference over time"
            }
            (_, Some(Outcome::NotMet)) => {
                "chance may make the difference over time: record each sample more often"
            }
            (Some(low), _) if low > 1.0 => {
                "over time they differ, but recordings of one sample may do so too: record each several times"
            }
            _ => "over time the difference is in the range of the just-noticeable difference",
        }
    }

    /// Whether no division of the units of both samples has a larger distance; of samples with as many units, two are the same.
    fn is_smallest_p(&self, groups: &Groups) -> bool {
        let same = if groups.units[self.a] == groups.units[self.b] {
            2.0
        } else {
            1.0
        };
        self.permuted.is_some_and(|test| {
            test.exhaustive && test.p_value * test.divisions as f64 <= same + 0.5
        })
    }

    fn sentence(&self, groups: &Groups) -> String {
        let both = format!("{} and {}", groups.names[self.a], groups.names[self.b]);
        let word = self.outcome.word();
        if self.neither_felt {
            // A distance above the threshold says nothing there.
            let why = match self.outcome {
                Distinguishability::NotDecided => format!("; {}", self.open_because(groups)),
                _ => String::new(),
            };
            return format!("{word}: {both}: neither reaches the detection threshold{why}");
        }
        let halves = groups.within_jnd[self.a]
            .into_iter()
            .chain(groups.within_jnd[self.b])
            .fold(0.0, f64::max);
        let interval = self.interval_jnd.map_or_else(String::new, |[low, high]| {
            format!(" (95 %: {low:.2}–{high:.2}; halves of one sample: {halves:.2})")
        });
        let why = match self.outcome {
            Distinguishability::NotDecided => format!("; {}", self.open_because(groups)),
            _ => String::new(),
        };
        format!(
            "{word}: {both}, {:.2} JND{interval}{}{why}",
            self.distance_jnd,
            self.over_time()
        )
    }
}

impl Groups {
    /// The results as text: every pair, or for many pairs the number of each outcome and the sets below the JND.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        if self.pairs.len() <= LISTED {
            return self.pairs.iter().map(|p| p.sentence(self)).collect();
        }
        let mut sentences = Vec::new();
        for outcome in [
            Distinguishability::ToldApart,
            Distinguishability::BelowJnd,
            Distinguishability::NotDecided,
        ] {
            sentences.push(format!(
                "{}: {} of {} pairs",
                outcome.word(),
                self.with(outcome).count(),
                self.pairs.len()
            ));
            if outcome == Distinguishability::BelowJnd {
                let sets = self.below_by_name();
                sentences.extend(sets.iter().map(|set| format!("  {}", set.join(", "))));
            }
        }
        sentences
    }
}

impl PairCriterion {
    /// The criterion as text.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::JustNoticeableDifference => {
                "distance below the just-noticeable difference (75 % correct)"
            }
            Self::DistanceWithin => "distance below that between the halves of one sample",
            Self::Chance => "permutation test of the difference (adjusted p)",
            Self::InDoubt => "distance without lines that may be of the machine or the mains",
            Self::AtRest => "distance with the noise of all sensors at rest made equal",
            Self::LeftOut => "distance with what lies around the lines that are left out",
            Self::OverTime => {
                "difference over time and channels below the just-noticeable difference"
            }
            Self::ChanceOverTime => "permutation test of the difference over time (adjusted p)",
        }
    }
}
