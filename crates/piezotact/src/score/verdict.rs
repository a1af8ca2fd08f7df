//! What a score means, as a person would act on it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{BandScore, Difference};
use crate::quantity::{Band, Seconds};

/// Recording longer than this is no advice, s.
const LONGEST_S: f64 = 3600.0;

/// Where two vibrations differ by more than can just be noticed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// In the overall level.
    Level,
    /// In the balance of low and high frequencies.
    Balance,
    /// In third octaves, the one that counts most first.
    Bands(Vec<Band>),
}

/// Whether a finger could tell two vibrations apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Verdict {
    /// All differences are below one JND, with 95 % confidence.
    Indistinguishable,
    /// The score is above one JND, with 95 % confidence.
    Distinguishable {
        /// Where they differ.
        places: Vec<Place>,
    },
    /// The recordings are too short for either.
    CannotTell {
        /// How long both should be, s; absent when no length helps.
        #[serde(skip_serializing_if = "Option::is_none")]
        needed_s: Option<f64>,
    },
}

impl Verdict {
    /// The verdict on `score`, the largest of the differences in spectrum, level and balance, from recordings of `length`.
    pub(super) fn of(
        score: Difference,
        [_, level, balance]: [Difference; 3],
        bands: &[BandScore],
        length: Seconds,
    ) -> Self {
        if score.high_jnd < 1.0 {
            return Self::Indistinguishable;
        }
        if score.low_jnd <= 1.0 {
            // Scatter and limits close in with the root of the length.
            let reach = score.high_jnd - score.jnd;
            let likely = (score.jnd - score.scatter_jnd).max(0.0);
            let closing = (reach + score.scatter_jnd) / (1.0 - likely);
            let needed_s = length.0 * closing.powi(2) * 1.1;
            return Self::CannotTell {
                needed_s: (needed_s <= LONGEST_S).then_some(needed_s.max(length.0)),
            };
        }
        let mut places = Vec::new();
        if level.low_jnd > 1.0 {
            places.push(Place::Level);
        }
        if balance.low_jnd > 1.0 {
            places.push(Place::Balance);
        }
        let mut apart: Vec<&BandScore> = bands
            .iter()
            .filter(|b| b.share > 0.0 && b.felt_jnd.abs() - b.reach_jnd > 1.0)
            .collect();
        let counts = |b: &BandScore| b.share * b.felt_jnd.abs();
        apart.sort_by(|x, y| counts(y).total_cmp(&counts(x)));
        if !apart.is_empty() {
            places.push(Place::Bands(apart.iter().map(|b| b.band_hz).collect()));
        }
        Self::Distinguishable { places }
    }

    /// One word for it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Indistinguishable => "indistinguishable",
            Self::Distinguishable { .. } => "distinguishable",
            Self::CannotTell { .. } => "cannot tell",
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level => f.write_str("in level"),
            Self::Balance => f.write_str("in the balance of low and high frequencies"),
            Self::Bands(bands) => {
                f.write_str("at ")?;
                for (i, band) in bands.iter().take(3).enumerate() {
                    write!(f, "{}{band}", if i > 0 { ", " } else { "" })?;
                }
                match bands.len().saturating_sub(3) {
                    0 => Ok(()),
                    more => write!(f, " and {more} more bands"),
                }
            }
        }
    }
}

impl super::Score {
    /// One sentence that says whether a finger could tell, by how much, and where.
    #[must_use]
    pub fn sentence(&self) -> String {
        let score = self.score;
        let range = format!(
            "{:.2} JND (95 %: {:.2}–{:.2})",
            score.jnd, score.low_jnd, score.high_jnd
        );
        match &self.verdict {
            Verdict::Indistinguishable
                if self.reference_sensation_db <= 0.0 && self.test_sensation_db <= 0.0 =>
            {
                "indistinguishable: neither reaches the detection threshold".into()
            }
            Verdict::Indistinguishable => {
                format!("indistinguishable: all differences are below 1 JND, score {range}")
            }
            Verdict::Distinguishable { places } => {
                let places: Vec<String> = places.iter().map(ToString::to_string).collect();
                let place = match places.as_slice() {
                    [] => "over the whole spectrum".into(),
                    [only] => only.clone(),
                    [first @ .., last] => format!("{} and {last}", first.join(", ")),
                };
                format!("distinguishable: score {range}, they differ {place}")
            }
            Verdict::CannotTell {
                needed_s: Some(needed_s),
            } => format!(
                "cannot tell: score {range}; record about {} of each",
                duration(*needed_s)
            ),
            Verdict::CannotTell { needed_s: None } => format!(
                "cannot tell: score {range}; it lies so close to 1 JND that no length of recording decides"
            ),
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
