//! How alike two waveforms are once their delay is taken away.

use serde::{Deserialize, Serialize};

use crate::doubt::Doubt;
use crate::quantity::{Acceleration, Band};
use crate::series::{Series, rms};
use crate::verify::{VerifyError, align};

/// How alike two waveforms are, limited to a band and aligned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Waveform {
    /// Pearson's correlation.
    pub correlation: f64,
    /// The power of the difference over that of the reference, dB; 0 dB is no better than silence.
    pub nmse_db: f64,
    /// How much later the test is, s.
    pub delay_s: f64,
    /// How much of them is compared, s.
    pub compared_s: f64,
}

/// The waveforms of `reference` and `test` compared within `band`; with the doubts about that.
pub(super) fn waveform(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    band: Band,
) -> Result<(Waveform, Vec<Doubt>), VerifyError> {
    let aligned = align(reference, test, band)?;
    let compared = aligned.from..aligned.to;
    let compared_s = reference.rate().duration_of(compared.len()).0;
    let wanted = &aligned.target_in_band[compared.clone()];
    let got = &aligned.measured_in_band[compared];
    let product: f64 = wanted.iter().zip(got).map(|(r, t)| r * t).sum();
    let norm = wanted.len() as f64 * rms(wanted) * rms(got);
    let correlation = if norm > 0.0 { product / norm } else { 0.0 };
    let error: Vec<f64> = wanted.iter().zip(got).map(|(r, t)| t - r).collect();
    let share = rms(&error) / rms(wanted).max(f64::MIN_POSITIVE);
    let mut doubts = Vec::new();
    if correlation < -0.5 {
        doubts.push(Doubt::Inverted { correlation });
    }
    Ok((
        Waveform {
            correlation,
            // What is equal to the last bit is as good as numbers are.
            nmse_db: 20.0 * share.max(1e-16).log10(),
            delay_s: aligned.delay.0,
            compared_s,
        },
        doubts,
    ))
}
