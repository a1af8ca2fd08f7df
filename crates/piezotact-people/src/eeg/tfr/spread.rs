//! Mean power over epochs with how much it scatters from epoch to epoch, at some of the times.

use piezotact::fourier::Complex;

use super::{Power, Sink, TfrPlan};
use crate::eeg::epochs::Epochs;

/// Adds up power and its square over epochs, at every so many-th time that the plan gives out.
pub(in crate::eeg) struct SpreadSink {
    frequencies: usize,
    times: usize,
    every: usize,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl SpreadSink {
    pub(in crate::eeg) fn new(plan: &TfrPlan, epochs: &Epochs, every: usize) -> Self {
        let frequencies = plan.config.frequencies_hz.len();
        let times = plan.times().div_ceil(every);
        let all = epochs.channels().len() * frequencies * times;
        Self {
            frequencies,
            times,
            every,
            sums: vec![0.0; all],
            squares: vec![0.0; all],
        }
    }

    /// The mean power, and the squared standard error of each mean re its square, channels × frequencies × times.
    pub(in crate::eeg) fn finish(mut self, plan: &TfrPlan, epochs: &Epochs) -> (Power, Vec<f64>) {
        let n = epochs.count() as f64;
        for (sum, square) in self.sums.iter_mut().zip(&mut self.squares) {
            let mean = *sum / n;
            let variance = (*square / n - mean * mean).max(0.0) * n / (n - 1.0).max(1.0);
            *sum = mean;
            *square = if mean > 0.0 {
                variance / n / (mean * mean)
            } else {
                0.0
            };
        }
        let power = Power {
            channels: epochs.channels().to_vec(),
            frequencies_hz: plan.config.frequencies_hz.clone(),
            times_s: (0..self.times)
                .map(|i| epochs.time_s(i * self.every * plan.config.decimation))
                .collect(),
            smears_s: plan.smears_s.clone(),
            epochs: epochs.count(),
            extent_s: [epochs.first_s(), epochs.last_s()],
            values: self.sums,
        };
        (power, self.squares)
    }
}

impl Sink for SpreadSink {
    fn take(&mut self, channel: usize, _: usize, frequency: usize, z: &[Complex<f64>]) {
        let start = (channel * self.frequencies + frequency) * self.times;
        let sums = &mut self.sums[start..start + self.times];
        let squares = &mut self.squares[start..start + self.times];
        let values = z.iter().step_by(self.every);
        for ((sum, square), value) in sums.iter_mut().zip(squares).zip(values) {
            let power = value.norm_sqr();
            *sum += power;
            *square += power * power;
        }
    }
}
