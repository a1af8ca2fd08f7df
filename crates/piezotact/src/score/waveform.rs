//! How alike two waveforms are once their delay is taken away.

use crate::recording::{RecordingWarning, ReversedSign};
use serde::{Deserialize, Serialize};

use crate::quantity::{Acceleration, Band};
use crate::series::Series;
use crate::statistics::rms;
use crate::verify::{VerifyError, VerifyWarning, align, nmse_db};
use crate::warning::Warning;

/// How alike two waveforms are, limited to a band and aligned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
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

/// What of two recordings is compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// All of each: they are two realisations, and no time of one belongs to a time of the other.
    WholeOfEach,
    /// What they share in time, aligned: one follows the other.
    SharedPart,
}

/// From this correlation on, of either sign, one waveform follows the other over nearly all of the shorter one.
const FOLLOWS: f64 = 0.5;
/// So much of the shorter one.
pub(super) const NEARLY_ALL: f64 = 0.8;
/// From this correlation on it follows over whatever they share: events that happen to coincide do not correlate so well.
const FOLLOWS_IN_PART: f64 = 0.8;

/// A delay this close to a whole number of samples is one: it is found to 1e-4.
const WHOLE: f64 = 1e-3;

/// Two waveforms compared.
pub(super) struct Compared {
    pub(super) waveform: Waveform,
    pub(super) warnings: Vec<Warning>,
    /// The part that both share, where one follows the other.
    pub(super) shared: Option<[Series<Acceleration>; 2]>,
}

/// The waveforms of `reference` and `test` compared within `band`.
pub(super) fn waveform(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    band: Band,
) -> Result<Compared, VerifyError> {
    let aligned = align(reference, test, band)?;
    let compared = aligned.from..aligned.to;
    let compared_s = reference.rate().duration_of(compared.len()).0;
    let wanted = &aligned.target_in_band[compared.clone()];
    let got = &aligned.measured_in_band[compared.clone()];
    let product: f64 = wanted.iter().zip(got).map(|(r, t)| r * t).sum();
    let norm = wanted.len() as f64 * rms(wanted) * rms(got);
    let correlation = if norm > 0.0 { product / norm } else { 0.0 };
    let error: Vec<f64> = wanted.iter().zip(got).map(|(r, t)| t - r).collect();
    let mut warnings = Vec::new();
    let shorter = reference.samples().len().min(test.samples().len());
    let nearly_all = compared.len() as f64 >= NEARLY_ALL * shorter as f64;
    let follows = correlation.abs() > if nearly_all { FOLLOWS } else { FOLLOWS_IN_PART };
    if follows && correlation < 0.0 {
        warnings.push(Warning::from(RecordingWarning::Sign {
            of: ReversedSign::Measurement { correlation },
        }));
    }
    let mut shared = None;
    if follows {
        // A hundredth is what aligning costs at the ends.
        if compared.len() * 100 < reference.samples().len() * 99 {
            warnings.push(Warning::from(VerifyWarning::Cut {
                compared_s,
                target_s: reference.duration().0,
            }));
        }
        // A delay of whole samples needs no interpolation: what is equal stays equal.
        let late = aligned.delay.0 * reference.rate().hz();
        let moved = |i: usize| {
            let place = i as f64 + late.round();
            test.samples()
                .get(place.max(0.0) as usize)
                .copied()
                .unwrap_or(0.0)
        };
        let on_time: Vec<f64> = if (late - late.round()).abs() < WHOLE {
            (0..reference.samples().len()).map(moved).collect()
        } else {
            aligned.measured
        };
        let part =
            |samples: &[f64]| Series::new(samples[compared.clone()].to_vec(), reference.rate());
        shared = part(reference.samples())
            .and_then(|a| Ok([a, part(&on_time)?]))
            .ok();
    }
    Ok(Compared {
        waveform: Waveform {
            correlation,
            nmse_db: nmse_db(rms(&error), rms(wanted)),
            delay_s: aligned.delay.0,
            compared_s,
        },
        warnings,
        shared,
    })
}
