//! From a vibration to its envelopes.

use crate::HapticError;
use serde::{Deserialize, Serialize};

use super::{AmplitudePoint, Envelopes, FrequencyPoint, FrequencyRange};
use piezotact::fourier::{RealTransform, fast_length};
use piezotact::quantity::{Quantity, QuantityError, Seconds};
use piezotact::series::Series;
use piezotact::spectrum::{Symmetry, Window};

/// How envelopes are taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvelopeConfig {
    /// From one breakpoint to the next, s.
    pub hop_s: f64,
    /// The length of the Hann window around a breakpoint, s.
    pub window_s: f64,
    /// What 0 and 1 of the frequency stand for; power outside it is left out of the frequency.
    pub range: FrequencyRange,
}

impl EnvelopeConfig {
    /// 25 breakpoints a second under Hann windows of 80 ms, frequencies from 20 to 1000 Hz: as fast as clips made by
    /// hand or by a phone's designer tools, and as slow as a window that resolves 25 Hz allows.
    ///
    /// # Errors
    /// None with these numbers; [`QuantityError::Band`] by type.
    pub fn texture() -> Result<Self, QuantityError> {
        Ok(Self {
            hop_s: 0.04,
            window_s: 0.08,
            range: FrequencyRange::texture()?,
        })
    }
}

/// The envelopes of `x`: at every breakpoint the amplitude of the sine that has the rms of the window around it, as a
/// share of `full_scale` (in the unit of `x`), and the place of the spectral centroid in the range. Amplitudes beyond
/// full scale are 1; where nothing vibrates, the frequency before it stays.
///
/// Formula: a = √2·√(Σw·x²/Σw)/full scale; f = Σf·|X|²/Σ|X|² over the range, X the transform of √w·x.
///
/// Source: rms envelope of a sine; spectral centroid, Peeters et al. (2011), 10.1121/1.3642604, on power.
///
/// # Errors
/// [`HapticError::FullScale`] when it is no number above zero; [`HapticError::NoLength`] when `x` is shorter than
/// a hop or the windows hold no samples; [`HapticError::Point`] when it is longer than an hour.
pub fn analyse<Q: Quantity>(
    x: &Series<Q>,
    full_scale: f64,
    config: &EnvelopeConfig,
) -> Result<Envelopes, HapticError> {
    if !(full_scale > 0.0 && full_scale.is_finite()) {
        return Err(HapticError::FullScale { found: full_scale });
    }
    let (samples, rate) = (x.samples(), x.rate());
    let duration_s = x.duration().0;
    let half = rate.samples_in(Seconds(0.5 * config.window_s));
    let hops = (duration_s / config.hop_s).floor();
    if half < 2 || !(1.0..1e6).contains(&hops) {
        return Err(HapticError::NoLength {
            found: format!(
                "{duration_s:.3} s at {rate}, for breakpoints every {} s",
                config.hop_s
            ),
        });
    }
    let window = Window::Hann.coefficients(2 * half, Symmetry::Periodic);
    let mut transform = RealTransform::new(fast_length(2 * half));
    let step_hz = rate.hz() / transform.length() as f64;
    let band = config.range.band();
    let (mut amplitude, mut frequency) = (Vec::new(), Vec::<FrequencyPoint>::new());
    let mut times_s: Vec<f64> = (0..=hops as usize)
        .map(|k| k as f64 * config.hop_s)
        .collect();
    if duration_s - hops * config.hop_s > 1e-9 {
        times_s.push(duration_s);
    }
    for time_s in times_s {
        let centre = rate.samples_in(Seconds(time_s));
        let from = centre.saturating_sub(half);
        let to = (centre + half).min(samples.len());
        let part = samples.get(from..to).unwrap_or(&[]);
        let weights = &window[from + half - centre..];
        let (mut power, mut weight) = (0.0, 0.0);
        let weighted: Vec<f64> = part
            .iter()
            .zip(weights)
            .map(|(v, w)| {
                power += w * v * v;
                weight += w;
                v * w.sqrt()
            })
            .collect();
        let rms = if weight > 0.0 {
            (power / weight).sqrt()
        } else {
            0.0
        };
        let (mut moment, mut all) = (0.0, 0.0);
        for (k, bin) in transform.forward(&weighted).iter().enumerate() {
            let hertz = k as f64 * step_hz;
            if band.contains(hertz) {
                moment += hertz * bin.norm_sqr();
                all += bin.norm_sqr();
            }
        }
        let before = frequency.last().map_or(0.5, |point| point.frequency);
        amplitude.push(AmplitudePoint {
            time_s,
            amplitude: (std::f64::consts::SQRT_2 * rms / full_scale).min(1.0),
            emphasis: None,
        });
        frequency.push(FrequencyPoint {
            time_s,
            frequency: if all > 0.0 {
                config.range.share(moment / all)
            } else {
                before
            },
        });
    }
    Envelopes::new(amplitude, frequency)
}
