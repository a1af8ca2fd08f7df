//! How a person judges textures by touch: from the cues of what was delivered to the finger, with noise, to an answer.
//!
//! [`Cues`] are computed from an acceleration and never from a name. [`Touch`] holds one person's sense of touch, a [`Judge`] says
//! which of the cues count. [`Person`] joins the two and answers with standard normal numbers that the caller draws; the
//! probabilities of the same answers, integrated over this noise, are [`Person::choice_probabilities`] and
//! [`Person::order_probability`].

mod answer;
mod cues;
mod normal;
mod probability;
mod touch;
mod which;
mod words;

pub use answer::{JudgeError, Look, Moment, Person, Recall, Sameness};
pub use cues::{CUE_BANDS, Cues, OnSurface, Pattern};
pub use touch::Touch;
pub use which::{
    Answers, Bounds, ChoiceAnswer, FIT_NATS, FIT_SHARE, FitCriterion, JudgeFit, MIN_PEOPLE,
    NAMED_WEIGHT, OrderAnswer, Parameters, TouchedTexture, Verdict, VerdictCriterion, Which,
    which_judge,
};

use serde::{Deserialize, Serialize};

/// A model of how people judge, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Judge {
    /// By level and spectrum, and on real surfaces by their period and friction (Thurstone, case V).
    Thurstone,
    /// At random.
    Guesser,
    /// By level alone.
    LevelOnly,
    /// By spectrum alone.
    SpectrumOnly,
}

/// A name that no judge has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a judge (thurstone, guesser, level_only, spectrum_only), found `{found}`; correct the name"
)]
pub struct UnknownJudge {
    pub found: String,
}

impl Judge {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Thurstone,
        Self::Guesser,
        Self::LevelOnly,
        Self::SpectrumOnly,
    ];

    /// Its name, as in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Thurstone => "thurstone",
            Self::Guesser => "guesser",
            Self::LevelOnly => "level_only",
            Self::SpectrumOnly => "spectrum_only",
        }
    }

    /// The judge called `name`.
    ///
    /// # Errors
    /// [`UnknownJudge`] with the names there are.
    pub fn named(name: &str) -> Result<Self, UnknownJudge> {
        let found = Self::ALL.into_iter().find(|judge| judge.name() == name);
        found.ok_or_else(|| UnknownJudge {
            found: name.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files_and_others_are_refused() {
        for judge in Judge::ALL {
            assert_eq!(Judge::named(judge.name()), Ok(judge));
            let text = serde_json::to_string(&judge).unwrap();
            assert_eq!(text, format!("\"{}\"", judge.name()));
        }
        let refused = Judge::named("Thurston").unwrap_err().to_string();
        assert!(
            refused.contains("`Thurston`") && refused.contains("level_only"),
            "{refused}"
        );
    }
}
