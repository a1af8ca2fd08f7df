//! Adds the perceptible difference to a verification, so that score and verification never contradict each other.

use super::{Score, ScoreConfig, Verdict, score_alone};
use crate::criterion::Criterion;
use crate::quantity::{Acceleration, Quantity, SampleRate};
use crate::series::Series;
use crate::verify::{Verification, VerifyCriterion};

/// `verification` with the perceptible difference between target and measurement as a further criterion, in JND, if the
/// score is decided: a rendering that can be distinguished from its target does not pass, and for one that does not pass the
/// result states when the difference is below one JND. The levels re the detection threshold are kept. Nothing is added for quantities other than accelerations, for recordings
/// too short to be scored, or if the score is not decided.
///
/// Source: [`super::score`] over the band of the verification, of the two as they are compared there.
#[must_use]
pub fn with_perceptible_difference(mut verification: Verification) -> Verification {
    let Some((found, config)) = scored(&verification) else {
        return verification;
    };
    verification.sensation_db = Some([found.reference_sensation_db, found.test_sensation_db]);
    match criterion(&found, &config) {
        Some(criterion) => verification.with(criterion),
        None => verification,
    }
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

fn criterion(found: &Score, config: &ScoreConfig) -> Option<Criterion<VerifyCriterion>> {
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
