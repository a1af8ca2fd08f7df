//! The biorthogonal 9/7 wavelets in which haptic files store blocks of samples.

use crate::HapticError;

/// Half of the even analysis low-pass, from its middle outwards.
const ANALYSIS_LOW: [f64; 5] = [
    0.852_698_679_008_894,
    0.377_402_855_612_831,
    -0.110_624_404_418_437,
    -0.023_849_465_019_557,
    0.037_828_455_507_264,
];
/// Half of the even synthesis low-pass, from its middle outwards.
const SYNTHESIS_LOW: [f64; 4] = [
    0.788_485_616_405_583,
    0.418_092_273_221_617,
    -0.040_689_417_609_164,
    -0.064_538_882_628_697,
];

/// The most samples in a block.
const LARGEST_BLOCK: usize = 1 << 20;

/// The coefficients of a block of samples: [`wavelet_synthesis`] undone.
#[cfg(test)]
pub(crate) fn wavelet_analysis(samples: &[f64]) -> Result<Vec<f64>, HapticError> {
    let levels = levels(samples.len())?;
    let mut out = samples.to_vec();
    for level in 0..levels {
        let length = samples.len() >> level;
        let x = out[..length].to_vec();
        for k in 0..length / 2 {
            out[k] = even(&ANALYSIS_LOW, |d| x[mirrored(2 * k, d, length)]);
            // The high-pass is the synthesis low-pass with alternating signs.
            let high = |d: isize| alternating(d) * x[mirrored(2 * k + 1, d, length)];
            out[length / 2 + k] = -even(&SYNTHESIS_LOW, high);
        }
    }
    Ok(out)
}

/// The samples of a block from its coefficients, the coarsest first.
///
/// Formula: log2(n/4) levels of the 9/7 filter bank with filters of norm √2 and symmetric ends.
///
/// Source: Cohen, Daubechies and Feauveau (1992), 10.1002/cpa.3160450502, table 6.2; ISO/IEC 23090-31 reference software, `source/FilterBank/src/Wavelet.cpp`.
///
/// # Errors
/// [`HapticError::Content`] unless there are 8 to 2^20 coefficients, a power of two.
pub fn wavelet_synthesis(coefficients: &[f64]) -> Result<Vec<f64>, HapticError> {
    let levels = levels(coefficients.len())?;
    let mut out = coefficients.to_vec();
    for level in (0..levels).rev() {
        let length = coefficients.len() >> level;
        let (mut low, mut high) = (vec![0.0; length], vec![0.0; length]);
        for k in 0..length / 2 {
            low[2 * k] = out[k];
            high[2 * k + 1] = out[length / 2 + k];
        }
        for (i, value) in out[..length].iter_mut().enumerate() {
            let of_low = even(&SYNTHESIS_LOW, |d| low[mirrored(i, d, length)]);
            let of_high = even(&ANALYSIS_LOW, |d| {
                alternating(d) * high[mirrored(i, d, length)]
            });
            *value = of_low - of_high;
        }
    }
    Ok(out)
}

fn levels(length: usize) -> Result<u32, HapticError> {
    if (8..=LARGEST_BLOCK).contains(&length) && length.is_power_of_two() {
        Ok((length / 4).ilog2())
    } else {
        Err(HapticError::content(
            "wavelet blocks of 8 to 1048576 coefficients, a power of two",
            length.to_string(),
            crate::AGAIN,
        ))
    }
}

/// An even filter around a place: Σ h|d|·x(d).
fn even(half: &[f64], x: impl Fn(isize) -> f64) -> f64 {
    let sides = half.iter().enumerate().skip(1);
    half[0] * x(0)
        + sides
            .map(|(d, h)| h * (x(d as isize) + x(-(d as isize))))
            .sum::<f64>()
}

fn alternating(d: isize) -> f64 {
    if d % 2 == 0 { 1.0 } else { -1.0 }
}

/// The place `d` from `i`, mirrored at the first and last of `length` samples without repeating them.
fn mirrored(i: usize, d: isize, length: usize) -> usize {
    let (place, last) = (i as isize + d, length as isize - 1);
    let period = 2 * last;
    let within = place.rem_euclid(period);
    (if within > last {
        period - within
    } else {
        within
    }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_comes_back() {
        let samples: Vec<f64> = (0..256).map(|i| (f64::from(i * i) * 0.01).sin()).collect();
        let coefficients = wavelet_analysis(&samples).unwrap();
        let back = wavelet_synthesis(&coefficients).unwrap();
        for (a, b) in back.iter().zip(&samples) {
            // Fifteen digits of the filters.
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
        // The filters have norm √2: a constant grows by √2 a level and leaves no details.
        let constant = wavelet_analysis(&[1.0; 64]).unwrap();
        assert!((constant[0] - 4.0).abs() < 1e-9, "{}", constant[0]);
        assert!(constant[4..].iter().all(|v| v.abs() < 1e-9));
    }

    #[test]
    fn odd_blocks_are_refused() {
        for length in [0, 1, 4, 100, 1 << 21] {
            assert!(wavelet_synthesis(&vec![0.0; length]).is_err(), "{length}");
        }
    }
}
