//! Adds the perceptible difference to a verification, so that score and verification never contradict each other.

use super::{Score, ScoreConfig, ScoreWarning, Verdict, score_alone};
use crate::criterion::Criterion;
use crate::quantity::{Acceleration, Quantity, SampleRate};
use crate::series::Series;
use crate::verify::{Verification, VerifyCriterion};
use crate::warning::Warning;

/// `verification` with the perceptible difference between target and measurement as a further criterion, in JND, if the
/// score is decided: a rendering that can be distinguished from its target does not pass, and for one that does not pass the
/// result states when the difference is below one JND. Nothing is added for quantities other than accelerations, for recordings
/// too short to be scored, or if the score is not decided.
///
/// Source: [`super::score`] over the band of the verification, of the two as they are compared there.
#[must_use]
pub fn with_perceptible_difference(verification: Verification) -> Verification {
    match criterion(&verification) {
        Some(criterion) => verification.with(criterion),
        None => verification,
    }
}

/// The warnings that target or measurement of `verification`, as they were compared, lie below the detection threshold: what meets every
/// criterion there is not felt.
///
/// Source: [`super::score`], as [`with_perceptible_difference`].
#[must_use]
pub fn warnings_of_feeling(verification: &Verification) -> Vec<Warning> {
    let warnings = scored(verification).map(|(found, _)| found.warnings);
    let not_felt = |warning: &Warning| matches!(warning.kind(), Some(ScoreWarning::NotFelt { .. }));
    warnings
        .unwrap_or_default()
        .into_iter()
        .filter(not_felt)
        .collect()
}

/// The score of what `verification` compared, and how it was computed.
fn scored(verification: &Verification) -> Option<(Score, ScoreConfig)> {
    if verification.psd_unit != Acceleration::UNIT.of_psd() {
        return None;
    }
    let rate = SampleRate::new(verification.rate_hz).ok()?;
    let part = |samples: &[f64]| {
        let cut = samples.get(verification.compared.clone())?.to_vec();
        Series::<Acceleration>::new(cut, rate).ok()
    };
    let (target, measured) = (part(&verification.target)?, part(&verification.aligned)?);
    let config = ScoreConfig::over(verification.band_hz, verification.rate_hz);
    let found = score_alone(&target, &measured, &config).ok()?;
    Some((found, config))
}

fn criterion(verification: &Verification) -> Option<Criterion<VerifyCriterion>> {
    let (found, config) = scored(verification)?;
    if matches!(found.verdict, Verdict::NotDecided { .. }) {
        return None;
    }
    let interval = [found.score.low_jnd, found.score.high_jnd];
    let limit = config.model().limit();
    Some(Criterion::new(
        VerifyCriterion::FeltDifference,
        "JND",
        found.score.jnd,
        Some(interval),
        limit,
    ))
}
