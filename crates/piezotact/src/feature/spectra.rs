//! Spectra of strokes, with their mean and scatter.

use serde::Serialize;

/// A spectrum of every stroke, with mean and standard deviation over strokes line by line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StrokeSpectra {
    /// The unit of the values.
    pub unit: String,
    /// The step between lines, Hz; the first lies at 0 Hz.
    pub resolution_hz: f64,
    /// The lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// One spectrum for each stroke; none of a recording that is larger than memory.
    #[serde(skip)]
    pub each: Vec<Vec<f64>>,
    /// Their mean.
    pub mean: Vec<f64>,
    /// Their standard deviation, n − 1 in the denominator; 0 for one stroke.
    pub sd: Vec<f64>,
}

impl StrokeSpectra {
    /// The spectra `each` in `unit`, all of one length, with their mean and standard deviation.
    ///
    /// Source: sample mean and standard deviation over strokes, of powers or amplitudes, not of decibels.
    #[must_use]
    pub fn over(each: Vec<Vec<f64>>, resolution_hz: f64, unit: String) -> Self {
        let count = each.len();
        let lines = each.first().map_or(0, Vec::len);
        let mut mean = vec![0.0; lines];
        for spectrum in &each {
            for (sum, value) in mean.iter_mut().zip(spectrum) {
                *sum += value / count as f64;
            }
        }
        let mut sd = vec![0.0; lines];
        for spectrum in &each {
            for ((sum, value), mean) in sd.iter_mut().zip(spectrum).zip(&mean) {
                *sum += (value - mean) * (value - mean);
            }
        }
        for sum in &mut sd {
            *sum = (*sum / (count.max(2) - 1) as f64).sqrt();
        }
        Self {
            unit,
            resolution_hz,
            frequency_hz: crate::spectrum::frequency_axis(resolution_hz, lines),
            each,
            mean,
            sd,
        }
    }

    /// Takes the strokes of `other` with these, of so many strokes each.
    pub(super) fn join(&mut self, other: &Self, [own, its]: [usize; 2]) {
        let (n, m) = (own as f64, its as f64);
        let lines = self.mean.iter_mut().zip(&mut self.sd);
        for ((mean, sd), (other, its_sd)) in lines.zip(other.mean.iter().zip(&other.sd)) {
            let apart = other - *mean;
            let squares = *sd * *sd * (n - 1.0) + its_sd * its_sd * (m - 1.0);
            *sd = ((squares + apart * apart * n * m / (n + m)) / (n + m - 1.0)).sqrt();
            *mean += apart * m / (n + m);
        }
    }
}
