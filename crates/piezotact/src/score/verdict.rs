//! The verdict on a score.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{BandScore, Difference, Extent, Perceived};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::discrimination::Model;
use crate::perception::{Contribution, Feature, PerceivedDifference};
use crate::quantity::{Band, Seconds};
use crate::statistics::LevelSpread;

/// A wider interval holds differences that nobody feels and such as everybody feels: twice the published range of the JND, from zero.
const WIDE_JND: f64 = 3.2;
/// Parts of one stroke, of less than a second each, are up to so many JND apart: it begins and ends softly (4.8 in measured strokes;
/// docs/decisions/perception.md).
const SHORT_EXCERPTS_JND: f64 = 5.0;
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
    /// It differs in these features, the one that counts most first.
    DiffersIn(Vec<Contribution>),
}

/// What a score is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ScoreCriterion {
    /// The difference against the just-noticeable difference; of spectra, with the range that was published of it.
    JustNoticeableDifference,
    /// The difference against how far parts of one recording lie apart: halves; of the perceived difference quarters too.
    DifferenceWithin,
    /// The loudest 0.1 s over the detection threshold, where neither reaches it over its whole length and the spectra decide.
    LoudestMoment,
}

impl fmt::Display for ScoreCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::JustNoticeableDifference => "difference below the just-noticeable difference",
            Self::DifferenceWithin => "difference below that between parts of one recording (perceived: twice)",
            Self::LoudestMoment => {
                "loudest 0.1 s relative to the detection threshold, if neither reaches it over its whole length"
            }
        })
    }
}

/// The outcome of the criterion on `what` in `criteria`.
fn outcome(criteria: &[Criterion<ScoreCriterion>], what: ScoreCriterion) -> Option<Outcome> {
    let mut all = criteria.iter();
    all.find(|c| c.what == what).map(|c| c.outcome)
}

/// The criteria on a difference: met where all that the data allow is below the limit.
fn criteria(
    (jnd, interval): (f64, [f64; 2]),
    limit: Limit,
    within_jnd: Option<f64>,
) -> Vec<Criterion<ScoreCriterion>> {
    use ScoreCriterion::{DifferenceWithin, JustNoticeableDifference};
    let against = |what, limit| Criterion::new(what, "JND", jnd, Some(interval), limit);
    let mut criteria = vec![against(JustNoticeableDifference, limit)];
    criteria.extend(within_jnd.map(|within| against(DifferenceWithin, Limit::at_most(within))));
    criteria
}

/// The criteria on the perceived difference.
pub(super) fn perceived_criteria(found: &Perceived) -> Vec<Criterion<ScoreCriterion>> {
    let jnd = found.difference.jnd;
    let limit = found.difference.criterion.limit;
    let within_jnd = found.within_jnd.map(|within| match found.is_short() {
        true => within.max(SHORT_EXCERPTS_JND),
        false => within,
    });
    let mut criteria = criteria((jnd.value, [jnd.low, jnd.high]), limit, within_jnd);
    criteria[0] = (found.difference).judged(ScoreCriterion::JustNoticeableDifference, limit);
    criteria
}

/// The criteria on the difference of the spectra.
pub(super) fn spectral_criteria(
    found: Difference,
    (extent, within_jnd): (Extent, Option<[f64; 2]>),
    (levels, sensation_db): (Option<[LevelSpread; 2]>, [f64; 2]),
    model: &Model,
) -> Vec<Criterion<ScoreCriterion>> {
    // If one waveform follows the other, changes over time are common to both.
    let within_jnd = match extent {
        Extent::WholeOfEach => within_jnd.map(|[a, b]| a.max(b)),
        Extent::SharedPart => None,
    };
    let interval = [found.low_jnd, found.high_jnd];
    let mut criteria = criteria((found.jnd, interval), model.limit(), within_jnd);
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
    /// The difference is below the just-noticeable difference, with its whole interval.
    BelowJnd,
    /// The difference is above the just-noticeable difference (of spectra: above its published range), and above what parts of one
    /// recording differ by, with its whole interval.
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
    /// The verdict on the perceived difference `found` by its `criteria`.
    pub(super) fn perceived(
        criteria: &[Criterion<ScoreCriterion>],
        found: &PerceivedDifference,
    ) -> Self {
        if outcome(criteria, ScoreCriterion::JustNoticeableDifference) == Some(Outcome::Met) {
            return Self::BelowJnd;
        }
        if criteria.iter().any(|c| c.outcome != Outcome::NotMet) {
            return Self::NotDecided { needed_s: None };
        }
        let features = found.main_contributions();
        let by_level = features.iter().any(|one| one.feature == Feature::Level);
        let mut how = Vec::new();
        match found.felt_level.0 {
            db if by_level && db > 0.0 => how.push(How::Louder),
            db if by_level && db < 0.0 => how.push(How::Softer),
            _ => {}
        }
        how.push(How::DiffersIn(features));
        Self::Distinguishable { how }
    }

    /// The verdict on the difference of spectra `found` by its `criteria`, from recordings of `length`. The differences in level and in
    /// balance come with whether the test has more.
    pub(super) fn spectral(
        found: Difference,
        criteria: &[Criterion<ScoreCriterion>],
        [level, balance]: [(Difference, bool); 2],
        bands: &[BandScore],
        length: Seconds,
    ) -> Self {
        use ScoreCriterion::{JustNoticeableDifference, LoudestMoment};
        let Some(jnd) = criteria.iter().find(|c| c.what == JustNoticeableDifference) else {
            return Self::NotDecided { needed_s: None };
        };
        // Long-time levels below the threshold give no information about single moments.
        match (jnd.outcome, outcome(criteria, LoudestMoment)) {
            (Outcome::Met, Some(Outcome::NotMet)) => return Self::NotDecided { needed_s: None },
            (Outcome::Met, _) => return Self::BelowJnd,
            _ => {}
        }
        let mut of_levels = criteria.iter().filter(|c| c.what != LoudestMoment);
        if of_levels.any(|c| c.outcome != Outcome::NotMet) {
            return Self::NotDecided {
                needed_s: needed_s(found, jnd.limit, length),
            };
        }
        let mut how = Vec::new();
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
            Self::BelowJnd => "below the just-noticeable difference",
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
        match &self.perceived {
            Some(found) => self.perceived_in_words(found),
            None => format!("by the spectra alone {}", self.spectra_in_words()),
        }
    }

    fn perceived_in_words(&self, found: &Perceived) -> String {
        let difference = &found.difference;
        let within_jnd = found.within_jnd.unwrap_or(0.0);
        match &self.verdict {
            Verdict::NotDecided { .. } if difference.jnd.low > 1.0 => {
                let why = match found.is_short() && within_jnd < SHORT_EXCERPTS_JND {
                    true => format!(
                        "parts of one stroke as short as these differ by up to {SHORT_EXCERPTS_JND} JND; record longer"
                    ),
                    false => format!(
                        "parts of one recording differ by {:.2} JND",
                        0.5 * within_jnd
                    ),
                };
                format!("{}: {}; {why}", self.verdict.word(), difference.range())
            }
            Verdict::Distinguishable { how } if how.contains(&How::Louder) => {
                format!("{}; B is {}", difference.sentence(), How::Louder)
            }
            Verdict::Distinguishable { how } if how.contains(&How::Softer) => {
                format!("{}; B is {}", difference.sentence(), How::Softer)
            }
            _ => difference.sentence(),
        }
    }

    fn spectra_in_words(&self) -> String {
        let found = self.spectral;
        let model = self.config.model();
        let range = format!(
            "{:.2} JND (95 %: {:.2}–{:.2})",
            found.jnd, found.low_jnd, found.high_jnd
        );
        let word = self.verdict.word();
        let is = |what| outcome(&self.criteria, what);
        match &self.verdict {
            Verdict::BelowJnd
                if self.reference_sensation_db <= 0.0 && self.test_sensation_db <= 0.0 =>
            {
                format!("{word}: neither reaches the detection threshold")
            }
            Verdict::BelowJnd => format!("{word}: {range}"),
            Verdict::Distinguishable { how } => {
                let how: Vec<String> = how.iter().map(ToString::to_string).collect();
                let how = match how.as_slice() {
                    [] => "differs slightly in all bands".into(),
                    how => format!("is {}", how.join(", ")),
                };
                format!("{word}: {range}; B {how}")
            }
            Verdict::NotDecided { needed_s } => {
                let halves = self.within_jnd.map_or(0.0, |[a, b]| a.max(b));
                let within = is(ScoreCriterion::DifferenceWithin)
                    .is_some_and(|outcome| outcome != Outcome::NotMet);
                let why = match needed_s {
                    _ if is(ScoreCriterion::LoudestMoment) == Some(Outcome::NotMet) => {
                        "over their whole length neither reaches the detection threshold, but the loudest 0.1 s do, which the \
                            spectra do not show".into()
                    }
                    _ if within && found.low_jnd > model.noticed_jnd() => {
                        format!("the halves of one recording differ by {halves:.2} JND")
                    }
                    Some(needed_s) => format!("record about {} of each", duration(*needed_s)),
                    None if found.high_jnd - found.low_jnd > WIDE_JND => {
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
                format!("{word}: {range}; {why}")
            }
        }
    }
}

fn duration(length_s: f64) -> String {
    if length_s < 120.0 {
        format!("{:.0} s", length_s.ceil())
    } else {
        format!("{:.0} min", (length_s / 60.0).ceil())
    }
}
