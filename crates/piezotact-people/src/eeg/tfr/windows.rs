//! Mean power of single epochs in bands and windows.

use crate::eeg::tfr::TfrError;
use std::ops::Range;

use piezotact::fourier::Complex;
use piezotact::quantity::Band;

use super::{Sink, TfrPlan};
use crate::eeg::epochs::Epochs;

/// A band of frequencies and a window of time, all ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub band: Band,
    /// The first and the last time from the event, s.
    pub extent_s: [f64; 2],
}

/// Mean power of each channel and epoch in windows.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialPowers {
    pub windows: Vec<Window>,
    /// How many epochs there are.
    pub epochs: usize,
    /// Channels × windows × epochs, V²: the mean over the times and frequencies of the window.
    pub values: Vec<f64>,
}

impl TrialPowers {
    /// The mean power of each epoch in a window of a channel, V².
    #[must_use]
    pub fn of(&self, channel: usize, window: usize) -> &[f64] {
        let start = (channel * self.windows.len() + window) * self.epochs;
        &self.values[start..start + self.epochs]
    }
}

/// The times and frequencies of a window.
#[derive(Clone, Debug)]
struct Part {
    times: Range<usize>,
    frequencies: Vec<bool>,
    factor: f64,
}

pub(in crate::eeg) struct WindowSink {
    windows: Vec<Window>,
    parts: Vec<Part>,
    epochs: usize,
    arch: pulp::Arch,
    sums: Vec<f64>,
}

impl WindowSink {
    pub(in crate::eeg) fn new(
        plan: &TfrPlan,
        epochs: &Epochs,
        windows: &[Window],
    ) -> Result<Self, TfrError> {
        let times: Vec<f64> = (0..plan.times())
            .map(|i| epochs.time_s(i * plan.config.decimation))
            .collect();
        let hz = &plan.config.frequencies_hz;
        let part = |window: &Window| {
            let range = times_within(&times, window.extent_s);
            let frequencies: Vec<bool> = hz.iter().map(|f| window.band.contains(*f)).collect();
            let count = frequencies.iter().filter(|is| **is).count();
            if range.is_empty() {
                return Err(TfrError::NoTime {
                    from_s: window.extent_s[0],
                    to_s: window.extent_s[1],
                    first_s: epochs.first_s(),
                    last_s: epochs.last_s(),
                });
            }
            if count == 0 {
                return Err(TfrError::NoFrequency {
                    low_hz: window.band.low().0,
                    high_hz: window.band.high().0,
                });
            }
            Ok(Part {
                factor: 1.0 / (range.len() * count) as f64,
                times: range,
                frequencies,
            })
        };
        Ok(Self {
            parts: windows.iter().map(part).collect::<Result<_, _>>()?,
            windows: windows.to_vec(),
            epochs: epochs.count(),
            arch: pulp::Arch::new(),
            sums: vec![0.0; epochs.channels().len() * windows.len() * epochs.count()],
        })
    }

    pub(in crate::eeg) fn finish(self) -> TrialPowers {
        TrialPowers {
            windows: self.windows,
            epochs: self.epochs,
            values: self.sums,
        }
    }
}

/// The indices of the times from `from` to `to`, both included up to rounding.
pub(in crate::eeg) fn times_within(times_s: &[f64], [from, to]: [f64; 2]) -> Range<usize> {
    let slack = 1e-9;
    let start = times_s.partition_point(|t| *t < from - slack);
    let end = times_s.partition_point(|t| *t <= to + slack);
    start..end.max(start)
}

impl Sink for WindowSink {
    fn take(&mut self, channel: usize, epoch: usize, frequency: usize, z: &[Complex<f64>]) {
        let windows = self.parts.len();
        for (window, part) in self.parts.iter().enumerate() {
            if !part.frequencies[frequency] {
                continue;
            }
            let values = &z[part.times.clone()];
            let sum = self.arch.dispatch(|| {
                // Eight sums beside each other, in an order of their own on every machine.
                let mut sums = [0.0; 8];
                let chunks = values.chunks_exact(8);
                let rest = chunks.remainder();
                for chunk in chunks {
                    for (sum, value) in sums.iter_mut().zip(chunk) {
                        *sum += value.re * value.re + value.im * value.im;
                    }
                }
                sums.iter().sum::<f64>() + rest.iter().map(|value| value.norm_sqr()).sum::<f64>()
            });
            self.sums[(channel * windows + window) * self.epochs + epoch] += part.factor * sum;
        }
    }
}
