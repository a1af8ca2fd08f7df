//! The best linear approximation from multisines, with the noise and the distortion of the device told apart.
//!
//! What differs from period to period is noise. What repeats with every period and is not the answer to the drive is
//! distortion: it stands on lines that are not driven, on even ones by even powers, on odd ones by odd powers.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::periodic::{Blocks, Record, Transformed, smoothed};
use super::{CrossSpectra, Estimator, TransferError, TransferFunction};
use crate::quantity::{Band, Hertz, Quantity};
use crate::series::Series;

/// Levels within one third-octave band: the rms of one line of one period in the unit of the response, as the root of the
/// mean power over the band's lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DistortionLevels {
    /// The band.
    pub band_hz: Band,
    /// The answer, on lines that are driven.
    pub linear: f64,
    /// What differs from period to period.
    pub noise: f64,
    /// What repeats on odd lines that are not driven; 0 where it does not stand out of the noise, absent where no such
    /// line lies in the band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odd: Option<f64>,
    /// What repeats on even lines, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub even: Option<f64>,
    /// What differs from one realisation to another on the driven lines beyond noise: the distortion that looks like noise.
    pub stochastic: f64,
}

/// How far a device is from linear, from multisines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Realisations with phases of their own.
    pub realisations: usize,
    /// Periods of each.
    pub periods: usize,
    /// The step between lines, Hz.
    pub resolution_hz: f64,
    /// From the lowest to the highest band.
    pub levels: Vec<DistortionLevels>,
}

impl Distortion {
    /// Where distortion stands highest above the answer: its level in dB re the answer, and the band.
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
    /// What several measurements of one grid say together: the root of the mean powers; `None` for none.
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
                (!powers.is_empty()).then(|| crate::series::mean(&powers).sqrt())
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

/// What multisines say of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct BestLinear<I: Quantity, O: Quantity> {
    /// The best linear approximation; its coherence and confidence count noise and distortion together.
    pub function: TransferFunction<I, O>,
    /// Noise and distortion, told apart.
    pub distortion: Distortion,
}

/// A line is driven when it holds this share of the strongest: 40 dB below.
const DRIVEN: f64 = 1e-4;

/// What repeats counts as distortion when it exceeds the noise's share by so many of its standard deviations.
const STANDS_OUT: f64 = 4.0;

/// Sums of powers over the lines of one band.
#[derive(Clone, Copy, Default)]
struct Sums {
    linear: f64,
    noise: f64,
    stochastic: f64,
    driven: usize,
    odd: (f64, usize),
    even: (f64, usize),
    noise_lines: usize,
}

/// The best linear approximation of what lies between `drive` and `response`, on lines rate/`segment` apart, from
/// multisines: every row of `blocks` holds the periods of one realisation.
///
/// Formula: Gₘ = Ȳₘ/X̄ₘ of the means over periods; noise: the variance over periods of Y − Gₘ·X; distortion on a line that
/// is not driven: |Ȳ − G·X̄|² less the noise's share 1/P; stochastic: the variance of Gₘ over realisations less that of
/// noise. The function is ΣX̄*Ȳ/ΣX̄*X̄ over realisations and the driven lines about each line.
///
/// Source: J. Schoukens, M. Vaes and R. Pintelon (2016), IEEE Control Systems 36(3); R. Pintelon and J. Schoukens (2012),
/// *System Identification*, 2nd ed., section 4.3.
///
/// # Errors
/// [`TransferError::Estimate`] when the recording does not hold the blocks, segments are longer than a period, or there
/// are not two periods and two realisations; those of [`TransferFunction::from_lines`].
pub fn best_linear<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    blocks: Blocks,
    segment: usize,
) -> Result<BestLinear<I, O>, TransferError> {
    if blocks.in_a_row < 2 || blocks.rows < 2 {
        return Err(crate::spectrum::EstimateError::Config {
            what: "at least 2 realisations of 2 periods each",
            found: format!("{} of {}", blocks.rows, blocks.in_a_row),
        }
        .into());
    }
    let transformed = Transformed::of(drive, response, blocks)?;
    let mean_of = |rows: &[Vec<Vec<Complex<f64>>>]| -> Vec<Vec<Complex<f64>>> {
        rows.iter().map(|r| mean(r)).collect()
    };
    let (x, y) = (mean_of(&transformed.drive), mean_of(&transformed.response));
    let power: Vec<f64> = (0..x[0].len())
        .map(|k| x.iter().map(|x| x[k].norm_sqr()).sum::<f64>())
        .collect();
    let strongest = power.iter().copied().fold(0.0, f64::max);
    let driven = |k: usize| power[k] > DRIVEN * strongest;
    let records: Vec<Record<'_>> = x
        .iter()
        .map(Vec::as_slice)
        .zip(y.iter().map(Vec::as_slice))
        .collect();
    let spectra: CrossSpectra<I, O> = smoothed(
        &records,
        &driven,
        transformed.step_hz,
        drive.rate(),
        segment,
    )?;
    let mut function = TransferFunction::estimated(&spectra, Estimator::H1, drive, response)?;
    function.provenance.steps.push(format!(
        "best linear approximation from {} realisations of {} periods of {:.3}, neighbouring lines averaged to steps of {:.3} Hz: {} averages",
        blocks.rows,
        blocks.in_a_row,
        drive.rate().duration_of(blocks.length),
        spectra.resolution_hz,
        spectra.averages
    ));
    let distortion = distortion(&transformed, [&x, &y], &driven, blocks);
    function.doubts.extend(distortion_doubt(&distortion));
    Ok(BestLinear {
        function,
        distortion,
    })
}

/// Distortion louder than this re the answer is said, dB.
const LOUD_DISTORTION_DB: f64 = -20.0;

fn distortion_doubt(distortion: &Distortion) -> Option<crate::Doubt> {
    let (level_db, band_hz) = distortion.worst()?;
    (level_db > LOUD_DISTORTION_DB).then_some(crate::Doubt::Nonlinear { level_db, band_hz })
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
    driven: &dyn Fn(usize) -> bool,
    blocks: Blocks,
) -> Distortion {
    let (rows, periods) = (blocks.rows as f64, blocks.in_a_row as f64);
    let lines: Vec<usize> = (1..x[0].len() - 1).filter(|k| driven(*k)).collect();
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
        let mut noise = 0.0;
        let (mut repeats, mut spread, mut answer) = (0.0, 0.0, 0.0);
        for m in 0..blocks.rows {
            let own = if driven(k) {
                y[m][k] / x[m][k]
            } else {
                gains[k]
            };
            let left = |y: Complex<f64>, x: Complex<f64>| y - own * x;
            let kept = left(y[m][k], x[m][k]);
            let differs: f64 = (0..blocks.in_a_row)
                .map(|p| {
                    (left(transformed.response[m][p][k], transformed.drive[m][p][k]) - kept)
                        .norm_sqr()
                })
                .sum();
            noise += differs / (periods - 1.0) / rows;
            repeats += kept.norm_sqr() / rows;
            spread += (own - gains[k]).norm_sqr() * x[m][k].norm_sqr() / (rows - 1.0);
            answer += (gains[k] * x[m][k]).norm_sqr() / rows;
        }
        sum.noise += noise * scale;
        sum.noise_lines += 1;
        if driven(k) {
            sum.linear += answer * scale;
            sum.stochastic += (spread - noise / periods) * scale;
            sum.driven += 1;
        } else {
            let kind = if k % 2 == 0 {
                &mut sum.even
            } else {
                &mut sum.odd
            };
            kind.0 += (repeats - noise / periods) * scale;
            kind.1 += 1;
        }
    }
    let root = |power: f64, count: usize| (power / count.max(1) as f64).max(0.0).sqrt();
    // What noise alone leaves scatters by its own mean over the root of how often it was seen.
    let beyond = |power: f64, count: usize, noise: f64| {
        let scatter = noise / periods / (count as f64 * rows).sqrt();
        if power / count as f64 > STANDS_OUT * scatter {
            root(power, count)
        } else {
            0.0
        }
    };
    let levels = bands
        .iter()
        .zip(&sums)
        .filter(|(_, s)| s.driven > 0)
        .map(|(band_hz, s)| DistortionLevels {
            band_hz: *band_hz,
            linear: root(s.linear, s.driven),
            noise: root(s.noise, s.noise_lines),
            odd: (s.odd.1 > 0)
                .then(|| beyond(s.odd.0, s.odd.1, s.noise / s.noise_lines.max(1) as f64)),
            even: (s.even.1 > 0)
                .then(|| beyond(s.even.0, s.even.1, s.noise / s.noise_lines.max(1) as f64)),
            stochastic: root(s.stochastic, s.driven),
        })
        .collect();
    Distortion {
        realisations: blocks.rows,
        periods: blocks.in_a_row,
        resolution_hz: step_hz,
        levels,
    }
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
