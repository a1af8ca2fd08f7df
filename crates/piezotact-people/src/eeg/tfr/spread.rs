//! Mean power over epochs with how much it scatters from epoch to epoch, at some of the times.

use piezotact::fourier::Complex;

use super::{Power, Sink, TfrPlan};
use crate::eeg::epochs::Epochs;

/// Adds up power and its square over epochs, at every so many-th time that the plan gives out.
pub(in crate::eeg) struct SpreadSink {
    frequencies: usize,
    times: usize,
    every: usize,
    /// Channel, epoch and frequency whose power is in `own`: that of all tapers.
    open: Option<[usize; 3]>,
    own: Vec<f64>,
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
            open: None,
            own: vec![0.0; times],
            sums: vec![0.0; all],
            squares: vec![0.0; all],
        }
    }

    /// The power of one epoch is complete.
    fn close(&mut self) {
        let Some([channel, _, frequency]) = self.open.take() else {
            return;
        };
        let start = (channel * self.frequencies + frequency) * self.times;
        let sums = &mut self.sums[start..start + self.times];
        let squares = &mut self.squares[start..start + self.times];
        for ((sum, square), own) in sums.iter_mut().zip(squares).zip(&mut self.own) {
            *sum += *own;
            *square += *own * *own;
            *own = 0.0;
        }
    }

    /// The mean power, and the squared standard error of each mean re its square, channels × frequencies × times.
    pub(in crate::eeg) fn finish(mut self, plan: &TfrPlan, epochs: &Epochs) -> (Power, Vec<f64>) {
        self.close();
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
    fn take(
        &mut self,
        channel: usize,
        epoch: usize,
        frequency: usize,
        z: &[Complex<f64>],
        scale: f64,
    ) {
        let now = [channel, epoch, frequency];
        if self.open != Some(now) {
            self.close();
            self.open = Some(now);
        }
        for (own, value) in self.own.iter_mut().zip(z.iter().step_by(self.every)) {
            *own += scale * value.norm_sqr();
        }
    }
}
