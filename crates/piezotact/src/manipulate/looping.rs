//! Textures of any length: the end is cross-faded into a similar stretch at the beginning, at constant power.

use crate::manipulate::{ManipulateWarning, NoticeableJoin};
use std::f64::consts::PI;
use std::ops::Range;

use super::error::require_range;
use super::{ManipulateError, Manipulated, about_mean, manipulated};
use crate::fourier::RealTransform;
use crate::lineage::{Join, Operation};
use crate::quantity::{Decibels, Quantity, SampleRate, Seconds};
use crate::series::Series;
use crate::spectrum::{Symmetry, Window};
use crate::statistics::correlation;
use crate::warning::Warning;

/// How a texture is joined with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinConfig {
    /// How long one end is faded into the other.
    pub crossfade: Seconds,
    /// How much of the end may be given up for a better join.
    pub search: Seconds,
}

impl JoinConfig {
    /// A crossfade of 0.1 s and a search over half a second, or an eighth and a quarter of a short texture.
    #[must_use]
    pub fn usual(texture: Seconds) -> Self {
        Self {
            crossfade: Seconds((texture.0 / 8.0).min(0.1)),
            search: Seconds((texture.0 / 4.0).min(0.5)),
        }
    }
}

/// The number of candidate joins that are evaluated in detail, the most correlated first.
const CANDIDATES: usize = 24;
/// The shortest crossfade, in samples.
const SHORTEST_CROSSFADE: usize = 8;
/// The length of a short-time spectrum, s: below the temporal resolution of touch.
const FRAME_S: f64 = 0.0256;
/// The limits of a join re the texture itself above which a warning is raised: steps between samples, and short-time spectra.
const WARNING_STEP_RATIO: f64 = 1.1;
const WARNING_SPECTRUM_DB: f64 = 1.0;
/// Ends with a correlation below this cancel during the crossfade.
const WARNING_END_CORRELATION: f64 = -0.3;
/// The averaging time of a perceived level, s, and the limit of its change at the join above the texture's own changes, dB.
const LEVEL_S: f64 = 0.1;
const WARNING_LEVEL_JUMP_DB: f64 = 1.0;
/// The longest texture that is generated, in s and in samples (2 GB).
const LONGEST_S: f64 = 3600.0;
const MOST_SAMPLES: f64 = 268_435_456.0;
/// The largest number of products in the search for a join; above it only some of the lags are tried (at usual rates, all).
const MOST_PRODUCTS: usize = 500_000_000;

/// `x` with the length `duration`, in the unit of `x`: cut, or joined with itself as often as needed. The ends are cross-faded at
/// constant power where they correlate most; the lineage states how the join compares with the rest.
///
/// Formula: y = (a·x₁ + b·x₂)/√(1 + 2ρ·a·b), a = cos θ, b = sin θ, θ = π/4·(1 − cos πu), ρ the correlation of the two.
///
/// Source: M. Fink, M. Holters and U. Zölzer (2016), DAFx-16: signal-matched power-complementary cross-fading.
///
/// # Errors
/// [`ManipulateError::Range`] for a duration of less than a sample or more than an hour, [`ManipulateError::TooShort`] for
/// a texture that does not hold four crossfades and the search, [`ManipulateError::Silent`].
pub fn looped<Q: Quantity>(
    x: &Series<Q>,
    duration: Seconds,
    config: &JoinConfig,
) -> Result<Manipulated<Q>, ManipulateError> {
    let rate = x.rate();
    let range = (1.0 / rate.hz(), longest_s(rate));
    require_range(
        "a length",
        duration.0,
        range,
        " s",
        "ask for one in between",
    )?;
    let wanted = rate.samples_in(duration);
    let (mean, samples) = about_mean(x)?;
    let duration_s = rate.duration_of(wanted).0;
    if wanted <= samples.len() {
        let operation = Operation::Looped {
            duration_s,
            join: None,
        };
        return manipulated(x, x.samples()[..wanted].to_vec(), operation, Vec::new());
    }
    let fade = rate.samples_in(config.crossfade);
    let search = rate.samples_in(config.search);
    let shortest = 4 * fade.max(SHORTEST_CROSSFADE) + search;
    if fade < SHORTEST_CROSSFADE || samples.len() < shortest {
        return Err(ManipulateError::TooShort {
            expected: rate.duration_of(shortest.max(8 * SHORTEST_CROSSFADE)),
            found: rate.duration_of(samples.len()),
        });
    }
    let latest = samples.len() - fade;
    let best = best_seam(
        &samples,
        fade,
        latest - search..latest + 1,
        (FRAME_S * rate.hz()) as usize,
    );
    let period = best.period;
    let mut out: Vec<f64> = Vec::with_capacity(wanted);
    out.extend(&samples[..period]);
    let mut joins = 0;
    while out.len() < wanted {
        out.extend(&best.seam);
        out.extend(&samples[fade..period]);
        joins += 1;
    }
    out.truncate(wanted);
    for sample in &mut out {
        *sample += mean;
    }
    let join = Join {
        joins,
        period_s: rate.duration_of(period).0,
        crossfade_s: rate.duration_of(fade).0,
        correlation: best.correlation,
        step_ratio: best.step_ratio,
        spectrum_db: best.spectrum_db,
    };
    let mut warnings = Vec::new();
    if join.step_ratio > WARNING_STEP_RATIO
        || join.spectrum_db > WARNING_SPECTRUM_DB
        || join.correlation < WARNING_END_CORRELATION
    {
        warnings.push(Warning::from(ManipulateWarning::JoinShows {
            by: NoticeableJoin::Waveform {
                correlation: join.correlation,
                step_ratio: join.step_ratio,
                spectrum_db: join.spectrum_db,
            },
        }));
    }
    let window = (LEVEL_S * rate.hz()) as usize;
    warnings.extend(level_jumps(&samples, period, fade, window));
    let operation = Operation::Looped {
        duration_s,
        join: Some(join),
    };
    manipulated(x, out, operation, warnings)
}

/// The longest texture that is made at `rate`, s.
pub(super) fn longest_s(rate: SampleRate) -> f64 {
    LONGEST_S.min(MOST_SAMPLES / rate.hz())
}

/// The warning about a level that jumps at the join by more than it changes anywhere else over the same time.
fn level_jumps(samples: &[f64], period: usize, fade: usize, window: usize) -> Option<Warning> {
    let window = window.min(period.saturating_sub(fade) / 4).max(1);
    let mut sums = Vec::with_capacity(samples.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for sample in samples {
        sum += sample * sample;
        sums.push(sum);
    }
    // Power 120 dB below that of the whole texture is imperceptible.
    let floor = 1e-12 * sum / samples.len() as f64;
    let level_db = |from: usize| {
        let power = (sums[from + window] - sums[from]) / window as f64;
        Decibels::from_power(power.max(floor)).0
    };
    let jump_db = level_db(fade) - level_db(period - window);
    // The extent of a join: the fade and half a window on either side.
    let apart = window + fade;
    let last = (samples.len() - window).checked_sub(apart)?;
    let own_db = (0..=last)
        .step_by((window / 8).max(1))
        .map(|from| (level_db(from + apart) - level_db(from)).abs())
        .fold(0.0, f64::max);
    (jump_db.abs() > own_db + WARNING_LEVEL_JUMP_DB).then_some(Warning::from(
        ManipulateWarning::JoinShows {
            by: NoticeableJoin::Level { jump_db, own_db },
        },
    ))
}

/// One way of joining.
struct Seam {
    /// The samples after which the texture begins again.
    period: usize,
    /// The cross-fade from the end into the beginning.
    seam: Vec<f64>,
    correlation: f64,
    step_ratio: f64,
    spectrum_db: f64,
}

/// The most correlated join that is not more noticeable than the texture itself; if there is none, the least noticeable.
fn best_seam(samples: &[f64], fade: usize, periods: Range<usize>, frame: usize) -> Seam {
    let head = &samples[..fade];
    let stride = (periods.len().saturating_mul(fade) / MOST_PRODUCTS).max(1);
    let mut alike: Vec<(f64, usize)> = periods
        .step_by(stride)
        .map(|period| (correlation(&samples[period..period + fade], head), period))
        .collect();
    alike.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Neighbouring lags of a chosen join are not candidates of their own.
    let mut chosen: Vec<(f64, usize)> = Vec::new();
    for candidate in alike {
        if chosen
            .iter()
            .all(|(_, period)| period.abs_diff(candidate.1) > 2)
        {
            chosen.push(candidate);
        }
        if chosen.len() == CANDIDATES {
            break;
        }
    }
    let texture = ShortTime::of(samples, frame.clamp(8, fade.max(8)));
    let mut least: Option<Seam> = None;
    for (correlation, period) in chosen {
        let seam = crossfaded(&samples[period..period + fade], head, correlation);
        let around = around(samples, &seam, period, texture.frame);
        let candidate = Seam {
            step_ratio: largest_step(&around) / texture.largest_step.max(f64::MIN_POSITIVE),
            spectrum_db: texture.excess_db(&around),
            period,
            seam,
            correlation,
        };
        if candidate.step_ratio <= 1.0 && candidate.spectrum_db <= 0.0 {
            return candidate;
        }
        if least
            .as_ref()
            .is_none_or(|least| shows(&candidate) < shows(least))
        {
            least = Some(candidate);
        }
    }
    // There is always a candidate: the search range holds at least one sample.
    least.unwrap_or_else(|| Seam {
        period: samples.len() - fade,
        seam: head.to_vec(),
        correlation: 0.0,
        step_ratio: f64::INFINITY,
        spectrum_db: f64::INFINITY,
    })
}

/// How noticeable a join is, dB.
fn shows(seam: &Seam) -> f64 {
    seam.spectrum_db
        .max(Decibels::from_amplitude_ratio(seam.step_ratio).0)
}

/// A seam with a frame of what comes before and after it.
fn around(samples: &[f64], seam: &[f64], period: usize, frame: usize) -> Vec<f64> {
    let after = seam.len()..(seam.len() + frame).min(period);
    [&samples[period - frame..period], seam, &samples[after]].concat()
}

/// `from` fading into `to`, with the power that both have.
fn crossfaded(from: &[f64], to: &[f64], correlation: f64) -> Vec<f64> {
    let n = from.len();
    from.iter()
        .zip(to)
        .enumerate()
        .map(|(i, (from, to))| {
            let angle = PI / 4.0 * (1.0 - (PI * (i as f64 + 0.5) / n as f64).cos());
            let (b, a) = angle.sin_cos();
            // Ends of opposite sign cannot keep constant power: below a correlation of −0.9 it decreases.
            let power = 1.0 + 2.0 * correlation.max(-0.9) * a * b;
            (a * from + b * to) / power.sqrt()
        })
        .collect()
}

fn largest_step(samples: &[f64]) -> f64 {
    samples
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f64::max)
}

/// The short-time spectra of a texture, with which a join is compared.
struct ShortTime {
    frame: usize,
    window: Vec<f64>,
    transform: RealTransform,
    /// The mean power of every line.
    mean_power: Vec<f64>,
    /// The power of the strongest frame, each line weighed by its mean.
    strongest: f64,
    largest_step: f64,
}

impl ShortTime {
    fn of(samples: &[f64], frame: usize) -> Self {
        let mut this = Self {
            frame,
            window: Window::Hann.coefficients(frame, Symmetry::Periodic),
            transform: RealTransform::new(frame),
            mean_power: vec![1.0; frame / 2 + 1],
            strongest: 0.0,
            largest_step: largest_step(samples),
        };
        let frames = this.powers(samples);
        let mut mean_power = vec![0.0; frame / 2 + 1];
        for power in &frames {
            for (sum, value) in mean_power.iter_mut().zip(power) {
                *sum += value / frames.len() as f64;
            }
        }
        // Lines with almost no power contain only rounding errors.
        let floor = 1e-12 * mean_power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        this.mean_power = mean_power.iter().map(|power| power.max(floor)).collect();
        this.strongest = this.strongest_of(&frames);
        this
    }

    fn powers(&self, samples: &[f64]) -> Vec<Vec<f64>> {
        let mut transform = self.transform.clone();
        samples
            .windows(self.frame)
            .step_by((self.frame / 8).max(1))
            .map(|part| {
                let windowed: Vec<f64> =
                    part.iter().zip(&self.window).map(|(x, w)| x * w).collect();
                let bins = transform.forward(&windowed);
                bins.iter().map(num_complex::Complex::norm_sqr).collect()
            })
            .collect()
    }

    fn strongest_of(&self, frames: &[Vec<f64>]) -> f64 {
        let weighed = |power: &Vec<f64>| {
            let lines = power.iter().zip(&self.mean_power);
            lines.map(|(power, mean)| power / mean).sum::<f64>()
        };
        frames.iter().map(weighed).fold(0.0, f64::max)
    }

    fn excess_db(&self, samples: &[f64]) -> f64 {
        let strongest = self.strongest_of(&self.powers(samples));
        Decibels::from_power(strongest / self.strongest.max(f64::MIN_POSITIVE)).0
    }
}
