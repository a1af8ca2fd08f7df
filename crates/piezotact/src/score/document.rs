//! A score as it is handed out.

use serde::Serialize;

use super::Score;
use crate::document::Content;

/// A score with its verdict as a sentence and the origin of its just noticeable differences.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreDocument<'a> {
    /// What was found.
    #[serde(flatten)]
    pub score: &'a Score,
    /// The verdict in one sentence.
    pub sentence: String,
    /// Where the just noticeable differences come from.
    pub jnd_source: &'static str,
}

impl Content for ScoreDocument<'_> {
    const SCHEMA: &'static str = "score";
}

impl<'a> ScoreDocument<'a> {
    /// `score` with its verdict.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn of(score: &'a Score) -> Self {
        Self {
            score,
            sentence: score.sentence(),
            jnd_source: score.config.model().jnd_source(),
        }
    }
}
