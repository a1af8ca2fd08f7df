//! The best linear approximation from multisines, with the noise and the distortion of the device separated.
//!
//! Noise differs from period to period. Distortion repeats with every period and is not the linear response to the drive: it
//! appears on lines that are not excited, on even lines from even powers and on odd lines from odd powers.

use crate::transfer::TransferWarning;
use num_complex::Complex;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::cross::EXCITED;
use super::periodic::{Blocks, Record, Transformed, smoothed};
use super::{CrossSpectra, Estimator, Known, TransferError, TransferFunction};
use crate::quantity::{Band, Hertz, Quantity};
use crate::series::Series;

/// Levels within one third-octave band: the rms of one line of one period in the unit of the response, as the root of the
/// mean power over the band's lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DistortionLevels {
    /// The band.
    pub band_hz: Band,
    /// The linear response, on excited lines.
    pub linear: f64,
    /// The noise: the part that differs from period to period.
    pub noise: f64,
    /// The odd distortion: the part that repeats on odd lines that are not excited; 0 if it does not exceed the noise, absent if
    /// no such line lies in the band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odd: Option<f64>,
    /// The even distortion: the part that repeats on even lines; 0 or absent likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub even: Option<f64>,
    /// The stochastic distortion: the difference between realisations on the excited lines beyond the noise.
    pub stochastic: f64,
}

impl DistortionLevels {
    /// What differs from period to period and what repeats on even and odd lines, each re the answer, dB; infinitely low where it
    /// does not stand out of the noise, absent where no such line lies in the band.
    ///
    /// Formula: 20·log₁₀(level / answer).
    ///
    /// Source: by definition of the decibel.
    #[must_use]
    pub fn re_answer_db(&self) -> [Option<f64>; 3] {
        [Some(self.noise), self.even, self.odd].map(|level| {
            level.map(|level| match level > 0.0 && self.linear > 0.0 {
                true => 20.0 * (level / self.linear).log10(),
                false => f64::NEG_INFINITY,
            })
        })
    }
}

/// How far a device is from linear, from multisines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Distortion {
    /// The number of realisations, each with its own random phases.
    pub realisations: usize,
    /// Periods of each.
    pub periods: usize,
    /// The step between lines, Hz.
    pub resolution_hz: f64,
    /// From the lowest to the highest band.
    pub levels: Vec<DistortionLevels>,
}

impl Distortion {
    /// The highest distortion: its level in dB re the linear response, and the band.
    #[must_use]
    pub fn worst(&self) -> Option<(f64, Band)> {
        self.levels
            .iter()
            .filter(|l| l.linear > 0.0)
            .map(|l| {
                let power = [l.odd, l.even].iter().flatten().map(|v| v * v).sum::<f64>();
                (
                    10.0 * (power / (l.linear * l.linear))
                        .max(f64::MIN_POSITIVE)
                        .log10(),
                    l.band_hz,
                )
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Distortion {
    /// Several measurements with the same lines, combined: the root of the mean powers; `None` for none.
    #[must_use]
    pub fn together(all: &[Self]) -> Option<Self> {
        let mut one = all.first()?.clone();
        for (i, level) in one.levels.iter_mut().enumerate() {
            let mean = |of: &dyn Fn(&DistortionLevels) -> Option<f64>| {
                let powers: Vec<f64> = all
                    .iter()
                    .filter_map(|d| of(d.levels.get(i)?))
                    .map(|v| v * v)
                    .collect();
                (!powers.is_empty()).then(|| crate::statistics::mean(&powers).sqrt())
            };
            *level = DistortionLevels {
                band_hz: level.band_hz,
                linear: mean(&|l| Some(l.linear)).unwrap_or(0.0),
                noise: mean(&|l| Some(l.noise)).unwrap_or(0.0),
                odd: mean(&|l| l.odd),
                even: mean(&|l| l.even),
                stochastic: mean(&|l| Some(l.stochastic)).unwrap_or(0.0),
            };
        }
        one.realisations = all.iter().map(|d| d.realisations).sum();
        Some(one)
    }
}

/// The result of a multisine measurement of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct BestLinear<I: Quantity, O: Quantity> {
    /// The best linear approximation; its coherence and confidence count noise and distortion together.
    pub function: TransferFunction<I, O>,
    /// Noise and distortion, separated.
    pub distortion: Distortion,
}

/// Lines of an estimate are at least so many fine lines apart: the grid has gaps of six.
pub const SEGMENTS_OF_A_PERIOD: usize = 4;

/// The significance level of distortion: its mean over realisations must exceed zero by Student's t of this probability.
const CHANCE: f64 = 1e-3;

/// Sums of powers over the lines of one band.
#[derive(Clone, Default)]
struct Sums {
    linear: f64,
    noise: f64,
    stochastic: f64,
    excited: usize,
    odd: Kept,
    even: Kept,
    noise_lines: usize,
}

/// The repeating part on the lines of one kind, realisation by realisation.
#[derive(Clone, Default)]
struct Kept {
    powers: Vec<f64>,
    lines: usize,
}

impl Kept {
    /// The mean power of a line where it stands out of the noise, 0 where it does not; `None` without lines.
    fn level(&self) -> Option<f64> {
        let count = self.powers.len();
        if self.lines == 0 {
            return None;
        }
        let of_a_line: Vec<f64> = self.powers.iter().map(|p| p / self.lines as f64).collect();
        let mean = crate::statistics::mean(&of_a_line);
        let squares: f64 = of_a_line.iter().map(|p| (p - mean).powi(2)).sum();
        let freedom = count.saturating_sub(1) as f64;
        let error = (squares / freedom / count as f64).sqrt();
        let t = StudentsT::new(0.0, 1.0, freedom)
            .ok()?
            .inverse_cdf(1.0 - CHANCE);
        Some(if mean > t * error { mean.sqrt() } else { 0.0 })
    }
}

/// The best linear approximation from `drive` to `response` in units of `O` per `I`, on lines rate/`segment` apart, from
/// multisines: every row of `blocks` holds the periods of one realisation.
///
/// Formula: Gₘ = Ȳₘ/X̄ₘ of the means over periods; noise: the variance over periods of Y − Gₘ·X; distortion on a line that
/// is not excited: the mean of Re(EₚE*ᵩ) of the residues E = Y − G·X of periods p, q half a row apart, where its mean over
/// realisations stands out of zero by Student's t; stochastic: the variance of Gₘ over realisations less that of
/// noise. The function is ΣX̄*Ȳ/ΣX̄*X̄ over realisations and the excited lines about each line.
///
/// Source: J. Schoukens, M. Vaes and R. Pintelon (2016), IEEE Control Systems 36(3); R. Pintelon and J. Schoukens (2012),
/// *System Identification*, 2nd ed., section 4.3.
///
/// # Errors
/// [`TransferError::Estimate`] when the recording does not hold the blocks, segments are longer than a period, or there
/// are not two periods and two realisations; [`TransferError::FewRowsLeft`] when too much was lost; those of [`TransferFunction::from_lines`].
pub fn best_linear<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    blocks: Blocks,
    segment: usize,
    known: Known<'_>,
) -> Result<BestLinear<I, O>, TransferError> {
    if blocks.in_a_row < 2 || blocks.rows < 2 {
        return Err(crate::spectrum::EstimateError::Config {
            what: "at least 2 realisations of 2 periods each",
            found: format!("{} of {}", blocks.rows, blocks.in_a_row),
        }
        .into());
    }
    if segment > blocks.length / SEGMENTS_OF_A_PERIOD {
        return Err(crate::spectrum::EstimateError::Config {
            what: "segments of at most a quarter of a period, between whose lines there is always one that is excited",
            found: segment.to_string(),
        }
        .into());
    }
    let transformed = Transformed::of(drive, response, blocks, known.lost_s)?;
    let blocks = Blocks {
        rows: transformed.drive.len(),
        ..blocks
    };
    let mean_of = |rows: &[Vec<Vec<Complex<f64>>>]| -> Vec<Vec<Complex<f64>>> {
        rows.iter().map(|r| mean(r)).collect()
    };
    let (x, y) = (mean_of(&transformed.drive), mean_of(&transformed.response));
    let power: Vec<f64> = (0..x[0].len())
        .map(|k| x.iter().map(|x| x[k].norm_sqr()).sum::<f64>())
        .collect();
    let strongest = power.iter().copied().fold(0.0, f64::max);
    let excited = |k: usize| power[k] > EXCITED * strongest;
    let records: Vec<Record<'_>> = x
        .iter()
        .map(Vec::as_slice)
        .zip(y.iter().map(Vec::as_slice))
        .collect();
    let spectra: CrossSpectra<I, O> = smoothed(
        &records,
        &excited,
        transformed.step_hz,
        drive.rate(),
        segment,
    )?;
    let signals = (drive, response);
    let (mut function, _) =
        TransferFunction::estimated(&spectra, Estimator::H1, signals, known.driven)?;
    function.about.provenance.steps.push(format!(
        "best linear approximation from {} realisations of {} periods of {:.3}, neighbouring lines averaged to steps of {:.3} Hz: {} averages",
        blocks.rows,
        blocks.in_a_row,
        drive.rate().duration_of(blocks.length),
        spectra.resolution_hz,
        spectra.averages
    ));
    let distortion = distortion(&transformed, [&x, &y], &excited, blocks);
    function.about.warnings.extend(transformed.left_out);
    function
        .about
        .warnings
        .extend(distortion_warning(&distortion));
    Ok(BestLinear {
        function,
        distortion,
    })
}

/// A warning is raised for distortion above this level re the linear response, dB.
const LOUD_DISTORTION_DB: f64 = -20.0;

fn distortion_warning(distortion: &Distortion) -> Option<crate::Warning> {
    let (level_db, band_hz) = distortion.worst()?;
    (level_db > LOUD_DISTORTION_DB).then_some(crate::Warning::from(TransferWarning::Nonlinear {
        level_db,
        band_hz,
    }))
}

fn mean(periods: &[Vec<Complex<f64>>]) -> Vec<Complex<f64>> {
    let n = periods.len() as f64;
    (0..periods[0].len())
        .map(|k| periods.iter().map(|p| p[k]).sum::<Complex<f64>>() / n)
        .collect()
}

fn distortion(
    transformed: &Transformed,
    [x, y]: [&[Vec<Complex<f64>>]; 2],
    excited: &dyn Fn(usize) -> bool,
    blocks: Blocks,
) -> Distortion {
    let (rows, periods) = (blocks.rows as f64, blocks.in_a_row as f64);
    let lines: Vec<usize> = (1..x[0].len() - 1).filter(|k| excited(*k)).collect();
    let (first, last) = (
        lines.first().copied().unwrap_or(0),
        lines.last().copied().unwrap_or(0),
    );
    let step_hz = transformed.step_hz;
    // From the transform's value to the rms of its line.
    let scale = 2.0 / (blocks.length as f64).powi(2);
    let mut gains = vec![Complex::default(); x[0].len()];
    for k in &lines {
        gains[*k] = (0..blocks.rows)
            .map(|m| y[m][*k] / x[m][*k])
            .sum::<Complex<f64>>()
            / rows;
    }
    interpolate(&mut gains, &lines);
    let bands = Band::new(Hertz(first as f64 * step_hz), Hertz(last as f64 * step_hz))
        .map(Band::third_octaves)
        .unwrap_or_default();
    let mut sums = vec![Sums::default(); bands.len()];
    for k in first..=last {
        let Some(at) = bands.iter().position(|b| b.contains(k as f64 * step_hz)) else {
            continue;
        };
        let sum = &mut sums[at];
        let is_excited = excited(k);
        let kept = if k % 2 == 0 {
            &mut sum.even
        } else {
            &mut sum.odd
        };
        if !is_excited {
            kept.lines += 1;
            kept.powers.resize(blocks.rows, 0.0);
        }
        let (mut noise, mut spread, mut answer) = (0.0, 0.0, 0.0);
        for m in 0..blocks.rows {
            let own = if is_excited {
                y[m][k] / x[m][k]
            } else {
                gains[k]
            };
            let left = |p: usize| transformed.response[m][p][k] - own * transformed.drive[m][p][k];
            let mean = y[m][k] - own * x[m][k];
            let differs: f64 = (0..blocks.in_a_row)
                .map(|p| (left(p) - mean).norm_sqr())
                .sum();
            noise += differs / (periods - 1.0) / rows;
            spread += (own - gains[k]).norm_sqr() * x[m][k].norm_sqr() / (rows - 1.0);
            answer += (gains[k] * x[m][k]).norm_sqr() / rows;
            if !is_excited {
                kept.powers[m] += repeating(blocks.in_a_row, &left) * scale;
            }
        }
        sum.noise += noise * scale;
        sum.noise_lines += 1;
        if is_excited {
            sum.linear += answer * scale;
            sum.stochastic += (spread - noise / periods) * scale;
            sum.excited += 1;
        }
    }
    let root = |power: f64, count: usize| (power / count.max(1) as f64).max(0.0).sqrt();
    let levels = bands
        .iter()
        .zip(&sums)
        .filter(|(_, s)| s.excited > 0)
        .map(|(band_hz, s)| DistortionLevels {
            band_hz: *band_hz,
            linear: root(s.linear, s.excited),
            noise: root(s.noise, s.noise_lines),
            odd: s.odd.level(),
            even: s.even.level(),
            stochastic: root(s.stochastic, s.excited),
        })
        .collect();
    Distortion {
        realisations: blocks.rows,
        periods: blocks.in_a_row,
        resolution_hz: step_hz,
        levels,
    }
}

/// The power common to the periods of a row, from products of periods as far apart as possible: slow movements of the hand
/// correlate neighbouring periods, noise is uncorrelated.
fn repeating(periods: usize, left: &dyn Fn(usize) -> Complex<f64>) -> f64 {
    let apart = periods.div_ceil(2);
    let products: Vec<f64> = (0..periods - apart)
        .map(|p| (left(p) * left(p + apart).conj()).re)
        .collect();
    crate::statistics::mean(&products)
}

/// Fills the lines between those of `known` linearly.
fn interpolate(gains: &mut [Complex<f64>], known: &[usize]) {
    for pair in known.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        let step = (gains[high] - gains[low]) / (high - low) as f64;
        for k in low + 1..high {
            gains[k] = gains[low] + step * (k - low) as f64;
        }
    }
}
