//! Adds the perceptible difference to a verification, so that score and verification never contradict each other.

use super::perceived::perceived;
use super::verdict::perceived_criteria;
use super::{Perceived, ScoreConfig, Verdict};
use crate::criterion::Criterion;
use crate::lineage::Mode;
use crate::quantity::{Acceleration, Quantity, SampleRate};
use crate::series::Series;
use crate::verify::{Verification, VerifyCriterion};

/// `verification` with the perceived difference between target and measurement as a further criterion, in JND, if it is decided: a
/// rendering that can be distinguished from its target does not pass, and for one that does not pass the result states when the
/// difference is below one JND. The levels re the detection threshold are kept. Nothing is added for quantities other than accelerations,
/// for recordings of which it cannot be computed, or if it is not decided.
///
/// Source: [`super::score`] over the band of the verification, of the two as they are compared there.
#[must_use]
pub fn with_perceptible_difference(mut verification: Verification) -> Verification {
    let Some(found) = felt(&verification) else {
        return verification;
    };
    verification.sensation_db = Some(found.difference.sensation_level.map(|level| level.0));
    match criterion(&found) {
        Some(criterion) => verification.with(criterion),
        None => verification,
    }
}

/// The perceived difference of what `verification` compared.
fn felt(verification: &Verification) -> Option<Perceived> {
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
    let both = [target, measured];
    let common = match verification.mode {
        Mode::Replicate => Some((&both, 1.0 - verification.waveform_correlation.powi(2))),
        Mode::Texture => None,
    };
    let [target, measured] = &both;
    perceived([target, measured], common, &config).ok()
}

/// The criterion on the perceived difference; `None` where it is not decided.
fn criterion(found: &Perceived) -> Option<Criterion<VerifyCriterion>> {
    let jnd = found.difference.jnd;
    let decided = match Verdict::perceived(&perceived_criteria(found), &found.difference) {
        Verdict::BelowJnd | Verdict::Distinguishable { .. } => Some([jnd.low, jnd.high]),
        Verdict::NotDecided { .. } => None,
    };
    Some(Criterion::new(
        VerifyCriterion::FeltDifference,
        "JND",
        jnd.value,
        Some(decided?),
        found.difference.criterion.limit,
    ))
}
