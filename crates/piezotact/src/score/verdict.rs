//! The verdict on a score.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{BandScore, Difference, Extent, OverTime};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::discrimination::Model;
use crate::perception::Contribution;
use crate::quantity::{Band, Seconds};
use crate::statistics::LevelSpread;

/// A wider interval holds differences that nobody feels and such as everybody feels: twice the published range of the JND, from zero.
const WIDE_JND: f64 = 3.2;
/// The longest recording that is recommended, s.
const LONGEST_S: f64 = 3600.0;

/// How B, the test, differs from A, the reference, by more than can just be noticed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// Its overall level is higher.
    Louder,
    /// Its overall level is lower.
    Softer,
    /// The balance has moved to high frequencies.
    Higher,
    /// The balance has moved to low frequencies.
    Lower,
    /// It is stronger in these bands, the one that counts most first.
    StrongerIn(Vec<Band>),
    /// It is weaker in these bands, the one that counts most first.
    WeakerIn(Vec<Band>),
    /// It differs in these features over time, the one that counts most first.
    DiffersIn(Vec<Contribution>),
}

/// What a score is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ScoreCriterion {
    /// The score against the just-noticeable difference and the range that was published of it.
    JustNoticeableDifference,
    /// The score against how far the halves of one recording lie apart.
    DifferenceWithin,
    /// How far they are apart over time and channels, against one JND and how far the halves of one recording are.
    OverTime,
    /// The loudest 0.1 s over the detection threshold, where neither reaches it over its whole length.
    LoudestMoment,
}

impl fmt::Display for ScoreCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::JustNoticeableDifference => {
                "score below the just-noticeable difference (75 % correct)"
            }
            Self::DifferenceWithin => "score below the difference between the halves of one recording",
            Self::OverTime => {
                "difference over time and channels below the just-noticeable difference (79 % correct)"
            }
            Self::LoudestMoment => {
                "loudest 0.1 s relative to the detection threshold, if neither reaches it over its whole length"
            }
        })
    }
}

/// Whether `what` is among `criteria` and is not met.
pub(super) fn not_met(criteria: &[Criterion<ScoreCriterion>], what: ScoreCriterion) -> bool {
    let mut all = criteria.iter();
    all.any(|c| c.what == what && c.outcome == Outcome::NotMet)
}

/// The criteria of `score`: met where all that the data allow is below the limit.
pub(super) fn criteria(
    score: Difference,
    (extent, within_jnd): (Extent, Option<[f64; 2]>),
    (levels, sensation_db): (Option<[LevelSpread; 2]>, [f64; 2]),
    over_time: Option<&OverTime>,
    model: &Model,
) -> Vec<Criterion<ScoreCriterion>> {
    let interval = Some([score.low_jnd, score.high_jnd]);
    let against = |what, limit| Criterion::new(what, "JND", score.jnd, interval, limit);
    let mut criteria = vec![against(
        ScoreCriterion::JustNoticeableDifference,
        model.limit(),
    )];
    // If one waveform follows the other, changes over time are common to both.
    if let (Extent::WholeOfEach, Some([a, b])) = (extent, within_jnd) {
        criteria.push(against(
            ScoreCriterion::DifferenceWithin,
            Limit::at_most(a.max(b)),
        ));
    }
    if let Some(found) = over_time {
        let jnd = found.difference.jnd;
        criteria.push(Criterion::new(
            ScoreCriterion::OverTime,
            "JND",
            jnd.value,
            Some([jnd.low, jnd.high]),
            Limit::AtMost {
                met: 1.0,
                not_met: found.within_jnd.max(1.0),
            },
        ));
    }
    if let Some([a, b]) = levels
        && sensation_db.iter().all(|db| *db <= 0.0)
    {
        criteria.push(Criterion::new(
            ScoreCriterion::LoudestMoment,
            "dB",
            a.loudest_db.max(b.loudest_db),
            None,
            Limit::at_most(0.0),
        ));
    }
    criteria
}

/// Whether two vibrations are distinguishable by touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Verdict {
    /// All differences are below the just-noticeable difference (75 % correct), with 95 % confidence.
    BelowJnd,
    /// The score is above the published range of the just-noticeable difference, and above what halves of one recording
    /// differ by, with 95 % confidence.
    Distinguishable {
        /// How they differ.
        how: Vec<How>,
    },
    /// The recordings are compatible with both.
    NotDecided {
        /// How long both should be, s; absent when no length helps.
        #[serde(skip_serializing_if = "Option::is_none")]
        needed_s: Option<f64>,
    },
}

impl Verdict {
    /// The verdict on `score` by its `criteria`, from recordings of `length`. The differences in level and in balance come with
    /// whether the test has more.
    pub(super) fn of(
        score: Difference,
        criteria: &[Criterion<ScoreCriterion>],
        [level, balance]: [(Difference, bool); 2],
        (bands, over_time): (&[BandScore], Option<&OverTime>),
        length: Seconds,
    ) -> Self {
        let Some(jnd) = criteria
            .iter()
            .find(|c| c.what == ScoreCriterion::JustNoticeableDifference)
        else {
            return Self::NotDecided { needed_s: None };
        };
        use ScoreCriterion::{LoudestMoment, OverTime as Time};
        let in_time = |c: &&Criterion<ScoreCriterion>| matches!(c.what, Time | LoudestMoment);
        let outcome_of = |what| criteria.iter().find(|c| c.what == what).map(|c| c.outcome);
        let features = match (outcome_of(Time), over_time) {
            (Some(Outcome::NotMet), Some(found)) => found.difference.main_contributions(),
            _ => Vec::new(),
        };
        let mut of_levels = criteria.iter().filter(|c| !in_time(c));
        let by_levels = of_levels.all(|c| c.outcome == Outcome::NotMet);
        if !by_levels && features.is_empty() {
            // Long-time levels below the JND give no information about changes over time.
            let is_below = jnd.outcome == Outcome::Met
                && matches!(outcome_of(Time), None | Some(Outcome::Met))
                && outcome_of(LoudestMoment) != Some(Outcome::NotMet);
            return match (is_below, jnd.outcome) {
                (true, _) => Self::BelowJnd,
                (false, Outcome::Met) => Self::NotDecided { needed_s: None },
                (false, _) => Self::NotDecided {
                    needed_s: needed_s(score, jnd.limit, length),
                },
            };
        }
        let mut how = Vec::new();
        if !by_levels {
            how.push(How::DiffersIn(features));
            return Self::Distinguishable { how };
        }
        match level {
            (d, true) if d.low_jnd > 1.0 => how.push(How::Louder),
            (d, false) if d.low_jnd > 1.0 => how.push(How::Softer),
            _ => {}
        }
        match balance {
            (d, true) if d.low_jnd > 1.0 => how.push(How::Higher),
            (d, false) if d.low_jnd > 1.0 => how.push(How::Lower),
            _ => {}
        }
        let (stronger, weaker) = (apart(bands, 1.0), apart(bands, -1.0));
        if !stronger.is_empty() {
            how.push(How::StrongerIn(stronger));
        }
        if !weaker.is_empty() {
            how.push(How::WeakerIn(weaker));
        }
        Self::Distinguishable { how }
    }

    /// One word for it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::BelowJnd => "below the just-noticeable difference (75 % correct)",
            Self::Distinguishable { .. } => "distinguishable",
            Self::NotDecided { .. } => "not decided",
        }
    }
}

/// How long both recordings should be, s, for their limits to fall below or above the range of the JND; `None` where the
/// difference lies in that range or so close to it that an hour does not do.
fn needed_s(score: Difference, limit: Limit, length: Seconds) -> Option<f64> {
    let (met, not_met) = (limit.value(), limit.not_met_from());
    // Scatter and limits close in with the root of the length.
    let reach = score.high_jnd - score.jnd;
    let likely = (score.jnd - score.scatter_jnd).max(0.0);
    let room = if likely < met {
        met - likely
    } else {
        likely - not_met
    };
    if room <= 0.0 {
        return None;
    }
    let needed_s = length.0 * ((reach + score.scatter_jnd) / room).powi(2) * 1.1;
    (needed_s <= LONGEST_S).then_some(needed_s.max(length.0))
}

/// The bands that differ by more than a JND in the direction of `sign`, neighbours as one; the one that counts most first.
fn apart(bands: &[BandScore], sign: f64) -> Vec<Band> {
    let differs = |b: &BandScore| b.share > 0.0 && sign * b.felt_jnd - b.ci_half_width_jnd > 1.0;
    let mut runs: Vec<(f64, Band)> = bands
        .chunk_by(|x, y| differs(x) == differs(y))
        .filter(|run| run.first().is_some_and(differs))
        .filter_map(|run| {
            let counts: f64 = run.iter().map(|b| b.share * b.felt_jnd.abs()).sum();
            let (low, high) = (run.first()?.band_hz.low(), run.last()?.band_hz.high());
            Some((counts, Band::new(low, high).ok()?))
        })
        .collect();
    runs.sort_by(|x, y| y.0.total_cmp(&x.0));
    runs.into_iter().map(|(_, band)| band).collect()
}

impl fmt::Display for How {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, bands) = match self {
            Self::Louder => return f.write_str("louder"),
            Self::Softer => return f.write_str("softer"),
            Self::Higher => return f.write_str("higher in frequency"),
            Self::Lower => return f.write_str("lower in frequency"),
            Self::StrongerIn(bands) => ("stronger", bands),
            Self::WeakerIn(bands) => ("weaker", bands),
            Self::DiffersIn(features) => {
                let features: Vec<String> = features.iter().map(ToString::to_string).collect();
                return write!(f, "different in {}", features.join(" and "));
            }
        };
        write!(f, "{word} at ")?;
        for (i, band) in bands.iter().enumerate() {
            write!(f, "{}{band}", if i > 0 { " and " } else { "" })?;
        }
        Ok(())
    }
}

impl super::Score {
    /// Its [`super::Score::sentence`].
    pub(super) fn in_words(&self) -> String {
        let score = self.score;
        let model = self.config.model();
        let range = format!(
            "{:.2} JND (95 %: {:.2}–{:.2})",
            score.jnd, score.low_jnd, score.high_jnd
        );
        let word = self.verdict.word();
        match &self.verdict {
            Verdict::BelowJnd
                if self.reference_sensation_db <= 0.0 && self.test_sensation_db <= 0.0 =>
            {
                format!("{word}: neither reaches the detection threshold")
            }
            Verdict::BelowJnd => format!("{word}: score {range}{}", self.over_time_in_words()),
            Verdict::Distinguishable { how } => {
                let how: Vec<String> = how.iter().map(ToString::to_string).collect();
                let how = match how.as_slice() {
                    [] => "differs slightly in all bands".into(),
                    how => format!("is {}", how.join(", ")),
                };
                format!(
                    "{word}: score {range}{}; B {how}",
                    self.over_time_in_words()
                )
            }
            Verdict::NotDecided { needed_s } => {
                let halves = self.within_jnd.map_or(0.0, |[a, b]| a.max(b));
                let within = self.criteria.iter().any(|c| {
                    c.what == ScoreCriterion::DifferenceWithin && c.outcome != Outcome::NotMet
                });
                let why = match needed_s {
                    _ if not_met(&self.criteria, ScoreCriterion::LoudestMoment) => {
                        "over their whole length neither reaches the detection threshold, but the loudest 0.1 s do, which the \
                            score does not evaluate".into()
                    }
                    _ if score.high_jnd < 1.0 => {
                        "over time and channels the difference is in the range of the just-noticeable difference".into()
                    }
                    _ if within && score.low_jnd > model.noticed_jnd() => {
                        format!("the halves of one recording differ by {halves:.2} JND")
                    }
                    Some(needed_s) => format!("record about {} of each", duration(*needed_s)),
                    None if score.high_jnd - score.low_jnd > WIDE_JND => {
                        "the interval says nothing: the recordings are too short, or change too much over time; record longer, under \
                            conditions that stay the same".into()
                    }
                    None => format!(
                        "it is in the published range of the just-noticeable difference, {:.1}–{:.1} dB or 1–{:.2} JND, or so \
                            close to it that a longer recording cannot decide",
                        model.level_jnd.0,
                        model.level_jnd_high.0.max(model.level_jnd.0),
                        model.noticed_jnd()
                    ),
                };
                format!("{word}: score {range}{}; {why}", self.over_time_in_words())
            }
        }
    }

    fn over_time_in_words(&self) -> String {
        self.over_time.as_ref().map_or_else(String::new, |found| {
            let jnd = found.difference.jnd;
            format!(
                ", over time and channels {:.2} JND ({:.2}–{:.2})",
                jnd.value, jnd.low, jnd.high
            )
        })
    }
}

fn duration(length_s: f64) -> String {
    if length_s < 120.0 {
        format!("{:.0} s", length_s.ceil())
    } else {
        format!("{:.0} min", (length_s / 60.0).ceil())
    }
}
