//! Repeats of one measurement: the pooled estimate, and the difference between repeats.

use crate::transfer::TransferError;
use num_complex::Complex;

use super::TransferFunction;
use super::bundle::{level_db, same_lines};
use crate::quantity::{Band, Quantity};
use crate::statistics::rms;
use crate::warning::Warnings;

/// The pooled estimate of repeats with one drive, in units of `O` per `I`: the result as if they had been recorded in one
/// recording. Coherence falls where they disagree. Condition, device and provenance are those of the first.
///
/// Formula: H1 = Σw·H1ᵢ, γ² = |H1|²/Σ(w·|H1ᵢ|²/γᵢ²), with w the share of the averages, as the drive's power is the same;
/// the others follow from both: H2 = H1/γ², Hv = H1/γ, total least squares.
///
/// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 9.2.4, with Syy = |H|²·Sxx/γ².
///
/// # Errors
/// [`TransferError::Few`] for none, [`TransferError::OtherLines`] when their lines differ.
pub fn pooled<I: Quantity, O: Quantity>(
    repeats: &[&TransferFunction<I, O>],
) -> Result<TransferFunction<I, O>, TransferError> {
    same_lines(repeats, 1)?;
    let first = repeats[0];
    if repeats.len() == 1 {
        return Ok(first.clone());
    }
    let all: f64 = repeats.iter().map(|r| r.averages.max(1) as f64).sum();
    let lines = first.response.len();
    // Per unit of the drive's power: the cross-spectrum, and the response's power.
    let (mut cross, mut power) = (vec![Complex::default(); lines], vec![0.0; lines]);
    for repeat in repeats {
        let weight = repeat.averages.max(1) as f64 / all;
        for (line, (h, coherence)) in repeat.response.iter().zip(&repeat.coherence).enumerate() {
            if *coherence > 0.0 {
                let h1 = repeat.estimator.h1_of(*h, *coherence);
                cross[line] += h1 * weight;
                power[line] += weight * h1.norm_sqr() / coherence;
            }
        }
    }
    let coherence: Vec<f64> = cross
        .iter()
        .zip(&power)
        .map(|(h1, power)| {
            if *power > 0.0 {
                h1.norm_sqr() / power
            } else {
                0.0
            }
        })
        .collect();
    let response = cross
        .iter()
        .zip(&coherence)
        .map(|(h1, coherence)| first.estimator.of_h1(*h1, *coherence))
        .collect();
    let mut one = TransferFunction::from_lines(
        response,
        coherence,
        first.resolution_hz,
        first.rate,
        first.estimator,
        repeats
            .iter()
            .fold(0usize, |sum, r| sum.saturating_add(r.averages)),
    )?;
    let few = one.few_averages();
    one.about.warnings.extend(few);
    one.effective_averages = repeats.iter().map(|r| r.effective_averages).sum();
    one.excited = first.excited;
    one.known_input = repeats.iter().all(|r| r.known_input);
    one.about.condition.clone_from(&first.about.condition);
    one.drive.clone_from(&first.drive);
    one.about.provenance.clone_from(&first.about.provenance);
    let mut warnings: Warnings = std::mem::take(&mut one.about.warnings)
        .into_iter()
        .collect();
    // What follows from the estimate itself is evaluated again for the pooled one.
    for repeat in repeats {
        let own = repeat.warnings_of_estimate();
        let theirs = repeat.about.warnings.iter();
        warnings.extend(theirs.filter(|warning| !own.contains(warning)).cloned());
    }
    one.about.warnings = warnings.into();
    one.about.provenance = one
        .about
        .provenance
        .then(format!("{} repeats as one estimate", repeats.len()));
    Ok(one)
}

/// The largest difference between two of `repeats` within `band`: the rms over the lines of the difference of their
/// magnitudes, dB; `None` for fewer than two, different line spacings, or no line in the band.
///
/// Formula: max over pairs of √(mean (20·log10|Hᵢ/Hⱼ|)²).
///
/// Source: L. Felicetti's thesis (2024), section 5.1.2 and figure 78a, as a number.
#[must_use]
pub fn max_pair_difference_db<I: Quantity, O: Quantity>(
    repeats: &[&TransferFunction<I, O>],
    band: Band,
) -> Option<f64> {
    same_lines(repeats, 2).ok()?;
    let levels: Vec<Vec<f64>> = repeats
        .iter()
        .map(|r| {
            r.lines_in(band)
                .map(|(line, _)| level_db(r.response[line]))
                .collect()
        })
        .collect();
    let apart = levels.iter().enumerate().flat_map(|(i, a)| {
        levels[..i]
            .iter()
            .map(|b| rms(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>()))
    });
    apart.reduce(f64::max).filter(|_| !levels[0].is_empty())
}
