//! Mean, level and peak of samples.

use piezotact_fourier::sum;

/// The root mean square of `samples` about zero, in their unit; 0 for none.
///
/// Source: √(Σx²/n).
#[must_use]
pub fn rms(samples: &[f64]) -> f64 {
    if samples.is_empty() {
        return 0.0;
    }
    (samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64).sqrt()
}

/// The mean of `samples`, in their unit; 0 for none.
///
/// Source: Σx/n.
#[must_use]
pub fn mean(samples: &[f64]) -> f64 {
    sum(samples) / samples.len().max(1) as f64
}

/// The standard deviation of `samples` about their mean, in their unit: the rms of what changes.
///
/// Source: √(Σ(x − mean)²/n).
#[must_use]
pub fn standard_deviation(samples: &[f64]) -> f64 {
    let mean = mean(samples);
    (samples.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / samples.len().max(1) as f64)
        .sqrt()
}

/// The correlation of two signals of one length about zero, −1 to 1; 0 when either is silent. Of what was freed of its mean it is
/// Pearson's.
///
/// Source: Σab/√(Σa²·Σb²).
#[must_use]
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        ab += a * b;
        aa += a * a;
        bb += b * b;
    }
    let both: f64 = aa * bb;
    if both > 0.0 { ab / both.sqrt() } else { 0.0 }
}

/// The largest absolute value of `samples`, in their unit; 0 for none.
///
/// Source: max|x|.
#[must_use]
pub fn peak(samples: &[f64]) -> f64 {
    // In lanes: a single running maximum waits for itself.
    let mut lanes = [0.0; 16];
    let chunks = samples.chunks_exact(16);
    let rest = chunks
        .remainder()
        .iter()
        .fold(0.0, |peak, v| v.abs().max(peak));
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            let v = v.abs();
            *lane = if v > *lane { v } else { *lane };
        }
    }
    lanes.iter().copied().fold(rest, f64::max)
}
