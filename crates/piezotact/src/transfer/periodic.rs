//! Transfer functions from periodic drives: sweeps and multisines. Blocks are transformed without a window,
//! and neighbouring lines are averaged to the line spacing of an estimate by segments.

use crate::recording::{LostBy, RecordingWarning};
use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::{CrossSpectra, Estimator, Known, TransferError, TransferFunction, touches};
use crate::fourier::RealTransform;
use crate::quantity::{Quantity, SampleRate};
use crate::series::Series;
use crate::spectrum::EstimateError;
use crate::warning::Warning;

/// The positions of the blocks of a periodic drive in a recording, in samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Blocks {
    /// The distance from the onset of the drive to the first block.
    pub lead: usize,
    /// The length of a block.
    pub length: usize,
    /// How many follow each other.
    pub in_a_row: usize,
    /// From the first block of a row to the first of the next.
    pub stride: usize,
    /// How many rows.
    pub rows: usize,
}

/// The onset of a recorded drive: the first sample above a hundredth of its largest.
pub(super) fn onset(drive: &[f64]) -> usize {
    let least = 0.01 * crate::statistics::peak(drive);
    drive.iter().position(|x| x.abs() > least).unwrap_or(0)
}

/// The transforms of every block of drive and response: rows of blocks of length/2 + 1 lines.
pub(super) struct Transformed {
    pub(super) drive: Vec<Vec<Vec<Complex<f64>>>>,
    pub(super) response: Vec<Vec<Vec<Complex<f64>>>>,
    /// The step between lines, Hz.
    pub(super) step_hz: f64,
    /// The warning about rows that were left out because they contain lost samples.
    pub(super) left_out: Option<Warning>,
}

impl Transformed {
    /// Cuts and transforms.
    pub(super) fn of<I: Quantity, O: Quantity>(
        drive: &Series<I>,
        response: &Series<O>,
        blocks: Blocks,
        lost_s: &[[f64; 2]],
    ) -> Result<Self, TransferError> {
        if drive.rate() != response.rate() || drive.samples().len() != response.samples().len() {
            return Err(EstimateError::Mismatch {
                left: I::NAME,
                right: O::NAME,
                what: "the rate and the number of samples",
                left_value: format!("{}, {}", drive.rate(), drive.samples().len()),
                right_value: format!("{}, {}", response.rate(), response.samples().len()),
            }
            .into());
        }
        let Blocks {
            lead,
            length,
            in_a_row,
            stride,
            rows,
        } = blocks;
        let first = onset(drive.samples()).saturating_add(lead);
        let needed = first + stride * rows.saturating_sub(1) + length * in_a_row;
        if length < 4 || rows * in_a_row == 0 || needed > drive.samples().len() {
            return Err(EstimateError::TooShort {
                expected: needed.max(4),
                found: drive.samples().len(),
            }
            .into());
        }
        // A row extends from the end of the previous one, so that its settling time belongs to it.
        let kept: Vec<usize> = (0..rows)
            .filter(|row| {
                let from = first + row * stride;
                let settles = stride.saturating_sub(length * in_a_row).min(from);
                !touches(
                    &(from - settles..from + length * in_a_row),
                    lost_s,
                    drive.rate(),
                )
            })
            .collect();
        let (left_out, needed) = (rows - kept.len(), if in_a_row > 1 { 2 } else { 1 });
        if left_out > 0 && kept.len() < needed {
            return Err(TransferError::FewRowsLeft {
                needed,
                left: kept.len(),
                of: rows,
            });
        }
        let mut plan = RealTransform::new(length);
        let mut cut = |samples: &[f64]| -> Vec<Vec<Vec<Complex<f64>>>> {
            kept.iter()
                .map(|row| {
                    (0..in_a_row)
                        .map(|k| first + row * stride + k * length)
                        .map(|at| plan.forward(&samples[at..at + length]))
                        .collect()
                })
                .collect()
        };
        Ok(Self {
            drive: cut(drive.samples()),
            response: cut(response.samples()),
            step_hz: drive.rate().hz() / length as f64,
            left_out: (left_out > 0).then_some(Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::Segments { left_out, of: rows },
            })),
        })
    }
}

/// The transforms of drive and response of one block.
pub(super) type Record<'a> = (&'a [Complex<f64>], &'a [Complex<f64>]);

/// Cross-spectra on lines `rate`/`segment` apart from `records` of fine lines `step_hz` apart, each a drive and a
/// response: about every line the fine ones of both sides are averaged with the weights of a raised cosine that ends at
/// its neighbours. Fine lines without `counted` do not exist for it.
pub(super) fn smoothed<I: Quantity, O: Quantity>(
    records: &[Record<'_>],
    counted: &dyn Fn(usize) -> bool,
    step_hz: f64,
    rate: SampleRate,
    segment: usize,
) -> Result<CrossSpectra<I, O>, TransferError> {
    let resolution_hz = rate.hz() / segment as f64;
    if segment < 2 || resolution_hz < step_hz {
        return Err(EstimateError::Config {
            what: "segments from 2 samples to the length of a block",
            found: segment.to_string(),
        }
        .into());
    }
    let fine = records.iter().map(|(x, _)| x.len()).min().unwrap_or(0);
    let lines = segment / 2 + 1;
    let mut spectra = CrossSpectra::<I, O>::from_parts(
        vec![0.0; lines],
        vec![0.0; lines],
        vec![Complex::default(); lines],
        resolution_hz,
        0,
    )?;
    let reach = resolution_hz / step_hz;
    // Of the lines in use, the mean of how many independent values they average.
    let (mut independent, mut in_use) = (0.0, 0usize);
    for line in 0..lines {
        let centre = line as f64 * reach;
        let (from, to) = (
            (centre - reach).ceil().max(0.0) as usize,
            (centre + reach).floor() as usize,
        );
        let (mut all, mut weights, mut squares) = (0.0, 0.0, 0.0);
        for k in from..=to.min(fine.saturating_sub(1)) {
            let weight = 0.5 + 0.5 * (std::f64::consts::PI * (k as f64 - centre) / reach).cos();
            all += weight;
            if !counted(k) {
                continue;
            }
            weights += weight;
            squares += weight * weight;
            for (x, y) in records {
                spectra.drive_power[line] += weight * x[k].norm_sqr();
                spectra.response_power[line] += weight * y[k].norm_sqr();
                spectra.cross[line] += x[k].conj() * y[k] * weight;
            }
        }
        if weights > 0.0 {
            let scale = 1.0 / (all * records.len() as f64);
            spectra.drive_power[line] *= scale;
            spectra.response_power[line] *= scale;
            spectra.cross[line] *= scale;
            independent += weights * weights / squares;
            in_use += 1;
        }
    }
    spectra.effective_averages = records.len() as f64 * independent / in_use.max(1) as f64;
    spectra.averages = spectra.effective_averages.round() as usize;
    Ok(spectra)
}

/// The transfer function from `drive` to `response` over sweeps, on lines rate/`segment` apart, with what is `known` beside the
/// samples.
///
/// Formula: H1 = ΣX*Y/ΣX*X over the sweeps and over neighbouring lines; coherence likewise, so that it says whether the
/// sweeps agree.
///
/// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 11.5.4 (frequency averaging).
///
/// # Errors
/// [`TransferError::Estimate`] when the recording does not hold the blocks, or segments are longer than they;
/// [`TransferError::FewRowsLeft`] when too much was lost; those of
/// [`TransferFunction::from_lines`].
pub fn estimate_sweeps<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    blocks: Blocks,
    segment: usize,
    estimator: Estimator,
    known: Known<'_>,
) -> Result<TransferFunction<I, O>, TransferError> {
    let transformed = Transformed::of(drive, response, blocks, known.lost_s)?;
    let rows = transformed.drive.iter().zip(&transformed.response);
    let records: Vec<Record<'_>> = rows
        .flat_map(|(x, y)| x.iter().map(Vec::as_slice).zip(y.iter().map(Vec::as_slice)))
        .collect();
    let spectra: CrossSpectra<I, O> = smoothed(
        &records,
        &|_| true,
        transformed.step_hz,
        drive.rate(),
        segment,
    )?;
    let signals = (drive, response);
    let (mut function, _) =
        TransferFunction::estimated(&spectra, estimator, signals, known.driven)?;
    function.about.provenance.steps.push(format!(
        "transfer function {estimator:?} of {} sweeps of {:.3}, neighbouring lines averaged to steps of {:.3} Hz: {} averages",
        records.len(),
        drive.rate().duration_of(blocks.length),
        spectra.resolution_hz,
        spectra.averages
    ));
    function.about.warnings.extend(transformed.left_out);
    Ok(function)
}
