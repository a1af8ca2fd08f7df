//! Transfer functions inverted: the drive whose response is a target.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::RenderError;
use crate::fourier;
use crate::quantity::{Band, Hertz, Quantity, SampleRate};
use crate::transfer::TransferFunction;

/// How a transfer function is inverted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InverseConfig {
    /// The band that is rendered.
    pub band: Band,
    /// The width of the raised-cosine edges outside the band, as a ratio of its ends.
    pub edge_ratio: f64,
    /// The regularisation ε, relative to the largest |H|² *in the band*. (Relative to all lines it would
    /// follow H1's noise above the excitation, and nothing of the target would be left.)
    pub regularisation: f64,
}

impl InverseConfig {
    /// Edges of 10 % and ε = 9e-6, that is −50 dB re the band's largest |H|: a device that answers 40 dB
    /// more weakly at one frequency than at another is still inverted there to 0.8 dB.
    #[must_use]
    pub fn over(band: Band) -> Self {
        Self {
            band,
            edge_ratio: 0.1,
            regularisation: 9e-6,
        }
    }
}

/// The inversion of targets of one length, planned once.
#[derive(Clone, Debug)]
pub struct InversePlan {
    transform: fourier::RealTransform,
    lines: Vec<(usize, f64, Complex<f64>)>,
}

impl InversePlan {
    /// A plan for targets of `samples` samples.
    #[must_use]
    pub fn new(samples: usize) -> Self {
        Self {
            transform: fourier::RealTransform::new(samples),
            lines: Vec::new(),
        }
    }

    /// The drive whose response is `target`; see [`invert`].
    ///
    /// # Errors
    /// Those of [`invert`]; [`RenderError::Length`] when the target has another length than the plan.
    pub fn invert<I: Quantity, O: Quantity>(
        &mut self,
        target: &[f64],
        rate: SampleRate,
        function: &TransferFunction<I, O>,
        config: &InverseConfig,
    ) -> Result<Vec<f64>, RenderError> {
        let n = self.transform.length();
        if target.len() != n {
            return Err(RenderError::Length {
                expected: n,
                found: target.len(),
            });
        }
        require_band(config.band, rate.nyquist(), "the target's rate")?;
        require_band(
            config.band,
            Hertz(function.highest_hz()),
            "the transfer function",
        )?;
        if !(config.regularisation.is_finite() && config.regularisation >= 0.0) {
            return Err(RenderError::Regularisation {
                found: config.regularisation,
            });
        }
        let spectrum = self.transform.forward(target);
        // The lines that count: index, weight, and the transfer function there.
        self.lines.clear();
        self.lines.extend((0..spectrum.len()).filter_map(|k| {
            let frequency_hz = k as f64 * rate.hz() / n as f64;
            let weight = config.band.weight(frequency_hz, config.edge_ratio);
            (weight > 0.0).then(|| (k, weight, function.at(frequency_hz)))
        }));
        let in_band = self.lines.iter().filter(|(_, weight, _)| *weight > 0.5);
        let largest = in_band.map(|(.., h)| h.norm_sqr()).fold(0.0, f64::max);
        if largest <= 0.0 {
            return Err(RenderError::NoResponse { band: config.band });
        }
        let floor = config.regularisation * largest;
        let mut drive = vec![Complex::default(); spectrum.len()];
        for (k, weight, h) in &self.lines {
            drive[*k] = spectrum[*k] * h.conj() * (weight / (h.norm_sqr() + floor));
        }
        Ok(self.transform.inverse(drive))
    }
}

/// The drive whose response is `target`, as long as the target and circular: what leaves one end comes in at
/// the other. Samples of `O` at `rate` become samples of `I`.
///
/// Formula: `irfft(FIV · conj(H)/(|H|² + ε·max_band|H|²) · W)`, H interpolated linearly in its real and
/// imaginary part, W the band with raised-cosine edges.
///
/// Source: the thesis' eq. 16–17, regularised as in Kirkeby and Nelson (1999), JAES 47(7/8).
///
/// # Errors
/// [`RenderError::BandAboveNyquist`], [`RenderError::Regularisation`], [`RenderError::NoResponse`].
pub fn invert<I: Quantity, O: Quantity>(
    target: &[f64],
    rate: SampleRate,
    function: &TransferFunction<I, O>,
    config: &InverseConfig,
) -> Result<Vec<f64>, RenderError> {
    InversePlan::new(target.len()).invert(target, rate, function, config)
}

fn require_band(band: Band, highest: Hertz, what: &'static str) -> Result<(), RenderError> {
    if band.high().0 > highest.0 * (1.0 + 1e-9) {
        return Err(RenderError::BandAboveNyquist {
            band,
            what,
            highest,
        });
    }
    Ok(())
}
