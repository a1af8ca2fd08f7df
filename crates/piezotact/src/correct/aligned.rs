//! Measured responses, aligned in time with the intended response.

use std::ops::Range;

use crate::quantity::{Band, Quantity};
use crate::series::Series;
use crate::spectrum::{Spectrum, WelchConfig, WelchPlan};
use crate::verify::{VerifyError, align};

/// The measured responses to one drive, aligned in time with its aim.
pub(super) struct AlignedResponses<O: Quantity> {
    /// The samples of the aim that all of them cover.
    pub(super) shared: Range<usize>,
    /// The samples of each response in that range.
    pub(super) measured: Vec<Vec<f64>>,
    /// The PSD of the aim in that range.
    pub(super) wanted: Spectrum<O>,
    pub(super) got: Spectrum<O>,
}

impl<O: Quantity> AlignedResponses<O> {
    /// `responses` aligned in time with `aim`.
    ///
    /// # Errors
    /// [`VerifyError::Rate`] when one has another rate, [`VerifyError::Silent`] when one holds nothing in `band`,
    /// [`VerifyError::TooShort`] when they share less than a segment.
    pub(super) fn of(
        responses: &[&Series<O>],
        aim: &Series<O>,
        welch: &WelchConfig,
        band: Band,
    ) -> Result<Self, VerifyError> {
        let mut shared = 0..aim.samples().len();
        let mut measured = Vec::with_capacity(responses.len());
        for response in responses {
            if response.rate() != aim.rate() {
                return Err(VerifyError::Rate {
                    target_hz: aim.rate().hz(),
                    measured_hz: response.rate().hz(),
                });
            }
            let aligned = align(aim, response, band)?;
            shared = shared.start.max(aligned.from)..shared.end.min(aligned.to);
            measured.push(aligned.measured);
        }
        if measured.is_empty() || shared.len() < welch.segment {
            return Err(VerifyError::TooShort {
                expected: welch.segment,
                found: if measured.is_empty() { 0 } else { shared.len() },
            });
        }
        for measured in &mut measured {
            measured.truncate(shared.end);
            measured.drain(..shared.start);
        }
        let mut plan = WelchPlan::new(welch, aim.rate())?;
        let all: Vec<&[f64]> = measured.iter().map(Vec::as_slice).collect();
        Ok(Self {
            wanted: plan.estimate::<O>(&[&aim.samples()[shared.clone()]])?,
            got: plan.estimate::<O>(&all)?,
            shared,
            measured,
        })
    }
}
