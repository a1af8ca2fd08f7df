//! Inversion of transfer functions: the drive whose response is a target.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::{RenderError, share_of_least_error};
use crate::fourier::{RealTransform, minimum_phase};
use crate::quantity::{Band, Hertz, Quantity, SampleRate};
use crate::spectrum::{WelchConfig, WelchPlan};
use crate::statistics::rms;
use crate::transfer::TransferFunction;

/// The regularisation of an inverse: the share of the target, 0–1, that it aims for in every line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Inverse {
    /// The whole target: plain division, as in the thesis.
    Plain,
    /// |H|²/(|H|² + ε·max|H|²): less where the device hardly responds.
    Constant,
    /// γ² times that: less where the coherence is low (Wiener's filter, ε(f) = |H|²(1 − γ²)/γ²).
    Coherence,
    /// As [`Self::Constant`], and when the drive does not fit the device, less where the target needs most drive: lines are
    /// kept where a decibel costs the least drive.
    DriveLimited,
}

impl Inverse {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Plain,
        Self::Constant,
        Self::Coherence,
        Self::DriveLimited,
    ];

    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Constant => "constant",
            Self::Coherence => "coherence",
            Self::DriveLimited => "drive-limited",
        }
    }
}

/// Which phase the inverse has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PhaseForm {
    /// The negative phase of the device: waveforms are reproduced, delayed by the modelling delay, with a pre-echo before
    /// a sudden onset.
    Linear,
    /// The minimum phase of its magnitude: spectra are reproduced, waveforms are not. The edges of the band ring before the beginning.
    Minimum,
}

impl PhaseForm {
    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Minimum => "minimum",
        }
    }
}

/// How a transfer function is inverted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct InverseConfig {
    /// The band that is rendered.
    pub band: Band,
    /// The width of the raised-cosine edges outside the band, as a ratio of its ends.
    pub edge_ratio: f64,
    /// The regularisation ε, relative to the largest |H|² *in the band*. (Relative to all lines it would
    /// follow H1's noise above the excitation, and nothing of the target would be left.)
    pub regularisation: f64,
    /// The share of the target that is aimed for in every line.
    pub inverse: Inverse,
    /// Which phase it has.
    pub phase: PhaseForm,
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
            inverse: Inverse::Constant,
            phase: PhaseForm::Linear,
        }
    }
}

/// The drive power that a target needs, line by line, and the resulting attenuation.
#[derive(Clone, Debug, PartialEq)]
pub struct Limiting {
    /// The drive's power on every line of the transfer function, re its median over the band.
    cost: Vec<f64>,
    resolution_hz: f64,
    /// The strength of the attenuation; 0 attenuates nothing.
    strength: f64,
}

impl Limiting {
    /// The drive power that `target` at `rate` needs through `function`, without attenuation.
    ///
    /// Formula: D = S/|H|² with the target's PSD S, from a PSD on about the lines of the transfer function.
    ///
    /// Source: the drive's power of the inverse in [`invert`].
    ///
    /// # Errors
    /// [`RenderError::NoResponse`] when nothing in the band has a cost.
    pub fn of<I: Quantity, O: Quantity>(
        target: &[f64],
        rate: SampleRate,
        function: &TransferFunction<I, O>,
        band: Band,
    ) -> Result<Self, RenderError> {
        let none = || RenderError::NoResponse { band };
        let segment = (rate.hz() / function.resolution_hz()).round().max(16.0) as usize;
        let config = WelchConfig::hann(segment.min(target.len()).max(2));
        let psd = WelchPlan::new(&config, rate)
            .and_then(|mut plan| plan.estimate::<O>(&[target]))
            .map_err(|_too_short| none())?;
        let power_at = |hz: f64| {
            let place = (hz / psd.resolution_hz).min((psd.values.len() - 1) as f64);
            let line = (place as usize).min(psd.values.len() - 2);
            let part = place - line as f64;
            psd.values[line] * (1.0 - part) + psd.values[line + 1] * part
        };
        let mut cost: Vec<f64> = function
            .frequencies_hz()
            .into_iter()
            .zip(function.response())
            .map(|(hz, h)| {
                if h.norm_sqr() > 0.0 {
                    power_at(hz) / h.norm_sqr()
                } else {
                    0.0
                }
            })
            .collect();
        let mut inside: Vec<f64> = function
            .lines_in(band)
            .map(|(line, _)| cost[line])
            .filter(|c| *c > 0.0)
            .collect();
        let median = crate::statistics::median(&mut inside).ok_or_else(none)?;
        for value in &mut cost {
            *value /= median;
        }
        Ok(Self {
            cost,
            resolution_hz: function.resolution_hz(),
            strength: 0.0,
        })
    }

    /// The same with the attenuation strength `strength_ratio`, the λ of [`Self::share_at`].
    #[must_use]
    pub fn turned_down(&self, strength_ratio: f64) -> Self {
        Self {
            strength: strength_ratio,
            ..self.clone()
        }
    }

    /// The same with the cost of every line as its contribution to the drive's slope, re the median over `band`: a drive that
    /// is too steep is attenuated at high frequencies.
    pub(super) fn by_slope(mut self, band: Band) -> Self {
        let mut inside = Vec::new();
        for (line, cost) in self.cost.iter_mut().enumerate() {
            let hz = line as f64 * self.resolution_hz;
            *cost *= hz * hz;
            if band.contains(hz) && *cost > 0.0 {
                inside.push(*cost);
            }
        }
        let median = crate::statistics::median(&mut inside).unwrap_or(1.0);
        for cost in &mut self.cost {
            *cost /= median;
        }
        self
    }

    /// The share of the target that is left at a frequency, 0–1.
    ///
    /// Formula: [`share_of_least_error`] of λ·D: the least rms error in dB for the drive that is saved.
    #[must_use]
    pub fn share_at(&self, frequency_hz: f64) -> f64 {
        let line = ((frequency_hz / self.resolution_hz).round().max(0.0) as usize)
            .min(self.cost.len() - 1);
        share_of_least_error(self.strength * self.cost[line])
    }
}

/// The inversion of targets of one length, planned once.
#[derive(Clone, Debug)]
pub struct InversePlan {
    transform: RealTransform,
    lines: Vec<Line>,
    /// The power within the band of the last inverted target.
    in_band: f64,
}

/// One line with a non-zero weight.
#[derive(Clone, Copy, Debug)]
struct Line {
    index: usize,
    weight: f64,
    h: Complex<f64>,
    coherence: f64,
    frequency_hz: f64,
}

impl InversePlan {
    /// A plan for targets of `samples` samples.
    #[must_use]
    pub fn new(samples: usize) -> Self {
        Self {
            transform: RealTransform::new(samples),
            lines: Vec::new(),
            in_band: 0.0,
        }
    }

    /// The share of the power of `target` (the last inverted one) outside the band of its inversion, 0–1, if it is a tenth or
    /// more.
    pub(crate) fn outside(&self, target: &[f64]) -> Option<f64> {
        // By Parseval, over all samples and in the lines of positive frequencies.
        let power = 0.5 * (target.len() as f64 * rms(target)).powi(2);
        let share = 1.0 - self.in_band / power.max(f64::MIN_POSITIVE);
        (share >= 0.1).then_some(share)
    }

    /// The same of a target at `rate` that was not inverted.
    pub(crate) fn outside_of(
        &mut self,
        target: &[f64],
        rate: SampleRate,
        band: Band,
    ) -> Option<f64> {
        let n = self.transform.length();
        let spectrum = self.transform.forward(target);
        let inside = |line: &usize| band.contains(*line as f64 * rate.hz() / n as f64);
        let lines = (0..spectrum.len()).filter(inside);
        self.in_band = lines.map(|line| spectrum[line].norm_sqr()).sum();
        self.outside(target)
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
        self.invert_limited(target, rate, function, config, None)
    }

    /// As [`Self::invert`], turned down by `limiting` where there is one.
    ///
    /// # Errors
    /// Those of [`Self::invert`].
    pub fn invert_limited<I: Quantity, O: Quantity>(
        &mut self,
        target: &[f64],
        rate: SampleRate,
        function: &TransferFunction<I, O>,
        config: &InverseConfig,
        limiting: Option<&Limiting>,
    ) -> Result<Vec<f64>, RenderError> {
        let n = self.transform.length();
        if target.len() != n {
            return Err(RenderError::Length {
                expected: n,
                found: target.len(),
            });
        }
        let gains = self.gains(rate, function, config, limiting)?;
        let spectrum = self.transform.forward(target);
        let inside = |line: &&Line| config.band.contains(line.frequency_hz);
        let in_band = self.lines.iter().filter(inside);
        self.in_band = in_band.map(|line| spectrum[line.index].norm_sqr()).sum();
        let mut drive = vec![Complex::default(); spectrum.len()];
        for (line, gain) in self.lines.iter().zip(gains) {
            drive[line.index] = spectrum[line.index] * gain;
        }
        Ok(self.transform.inverse(drive))
    }

    /// The factor of every line with a non-zero weight.
    fn gains<I: Quantity, O: Quantity>(
        &mut self,
        rate: SampleRate,
        function: &TransferFunction<I, O>,
        config: &InverseConfig,
        limiting: Option<&Limiting>,
    ) -> Result<Vec<Complex<f64>>, RenderError> {
        let n = self.transform.length();
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
        self.lines.clear();
        // No line outside the edges of the band has a weight, and one inverse alone asks for the coherence.
        let place = |hz: f64| hz * n as f64 / rate.hz();
        let first = place(config.band.low().0 * (1.0 - config.edge_ratio)).floor();
        let last = place(config.band.high().0 * (1.0 + config.edge_ratio)).ceil();
        let weighted = first.max(0.0) as usize..=(last as usize).min(n / 2);
        let by_coherence = config.inverse == Inverse::Coherence;
        self.lines.extend(weighted.filter_map(|index| {
            let frequency_hz = index as f64 * rate.hz() / n as f64;
            let weight = config.band.weight(frequency_hz, config.edge_ratio);
            (weight > 0.0).then(|| Line {
                index,
                weight,
                h: function.at(frequency_hz),
                coherence: match by_coherence {
                    true => function.coherence_at(frequency_hz),
                    false => 1.0,
                },
                frequency_hz,
            })
        }));
        // The edges outside the band must not decide what is strong in it.
        let inside = |line: &&Line| config.band.contains(line.frequency_hz);
        let in_band = self.lines.iter().filter(inside);
        let largest = in_band.map(|line| line.h.norm_sqr()).fold(0.0, f64::max);
        if largest <= 0.0 {
            return Err(RenderError::NoResponse { band: config.band });
        }
        let share = |line: &Line| {
            let limited = limiting.map_or(1.0, |limiting| limiting.share_at(line.frequency_hz));
            limited * config.share(line.h.norm_sqr() / largest, line.coherence)
        };
        let turned = match config.phase {
            PhaseForm::Linear => Vec::new(),
            PhaseForm::Minimum => self.minimum_phases(n, largest, config.regularisation),
        };
        let gain = |(i, line): (usize, &Line)| {
            let power = line.h.norm_sqr();
            if power <= 0.0 {
                return Complex::default();
            }
            let asked = line.weight * share(line);
            match turned.get(i) {
                Some(phase) => Complex::from_polar(asked / power.sqrt(), -phase),
                None => line.h.conj() * (asked / power),
            }
        };
        Ok(self.lines.iter().enumerate().map(gain).collect())
    }

    /// The minimum phases of the lines that count, rad; beyond them the magnitude stays as it is at their ends.
    fn minimum_phases(&self, n: usize, largest: f64, regularisation: f64) -> Vec<f64> {
        let least = (largest * regularisation.max(1e-12)).sqrt();
        let (Some(first), Some(last)) = (self.lines.first(), self.lines.last()) else {
            return Vec::new();
        };
        let at = |index: usize| {
            let place = index.clamp(first.index, last.index) - first.index;
            self.lines[place].h.norm().max(least)
        };
        let magnitudes: Vec<f64> = (0..=n / 2).map(at).collect();
        let phases = minimum_phase(&magnitudes, n);
        self.lines.iter().map(|line| phases[line.index]).collect()
    }
}

impl InverseConfig {
    /// The share of the target, 0–1, that is asked of a line with a power of `power` re the band's largest |H|², and of
    /// this coherence.
    pub(super) fn share(&self, power: f64, coherence: f64) -> f64 {
        let constant = || power / (power + self.regularisation);
        match self.inverse {
            Inverse::Plain => 1.0,
            Inverse::Constant | Inverse::DriveLimited => constant(),
            Inverse::Coherence => constant() * coherence.clamp(0.0, 1.0),
        }
    }
}

/// The drive whose response is `target`, with the length of the target, by circular convolution: one end wraps into
/// the other. Samples of `O` at `rate` become samples of `I`.
///
/// Formula: `irfft(FIV · c/H · W)`, H interpolated linearly in its real and imaginary part, W the band with raised-cosine
/// edges, c the share of [`Inverse`]: with a constant ε it is `conj(H)/(|H|² + ε·max_band|H|²)`.
///
/// Source: the thesis' eq. 16–17; regularised as in Kirkeby and Nelson (1999), JAES 47(7/8); N. Wiener (1949) for coherence;
/// A. V. Oppenheim and R. W. Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 13.5 for the minimum phase.
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
