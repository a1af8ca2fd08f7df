//! Even time columns that are larger than memory: their rate by passes over them.

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::series::is_sample;

use super::{FAR, ROUNDED, seconds_per_unit};
use crate::columns::Column;
use crate::error::ReadError;

/// Steps that all lie this close to their mean, as a share of it, are even: half of what is a warning elsewhere.
const EVEN: f64 = 0.5 * super::EVEN;

/// Passes over a column of times: its steps and its mean, the slope of its line, and how far it lies from that.
#[derive(Debug, Default)]
pub(crate) struct EvenTimes {
    pass: usize,
    /// Rows of this pass so far.
    row: usize,
    count: usize,
    first: f64,
    last: f64,
    shortest: f64,
    longest: f64,
    are_whole: bool,
    are_samples: bool,
    /// Σ(t − t₀), and the mean that it gives.
    sum: f64,
    mean: f64,
    xx: f64,
    xy: f64,
    period: f64,
    residual: f64,
}

impl EvenTimes {
    /// Whether a pass is to follow, which is begun.
    pub(crate) fn begin_pass(&mut self) -> bool {
        match self.pass {
            0 => {
                (self.shortest, self.longest) = (f64::MAX, f64::MIN);
                (self.are_whole, self.are_samples) = (true, true);
            }
            1 => {
                self.count = self.row;
                self.mean = self.first + self.sum / self.count as f64;
            }
            _ => self.period = self.xy / self.xx,
        }
        self.row = 0;
        self.pass += 1;
        self.pass == 1 || self.pass <= 3 && self.has_even_steps()
    }

    fn has_even_steps(&self) -> bool {
        let mean = (self.last - self.first) / (self.count as f64 - 1.0);
        let (low, high) = (self.shortest / mean - 1.0, self.longest / mean - 1.0);
        self.are_samples && self.count > 2 && mean > 0.0 && low >= -EVEN && high <= EVEN
    }

    /// The next times of a pass.
    pub(crate) fn add(&mut self, times: &[f64]) {
        let at = 0.5 * (self.count as f64 - 1.0);
        for time in times {
            let x = self.row as f64 - at;
            match self.pass {
                1 => {
                    if self.row == 0 {
                        self.first = *time;
                    } else {
                        let step = time - self.last;
                        self.shortest = self.shortest.min(step);
                        self.longest = self.longest.max(step);
                    }
                    self.last = *time;
                    self.are_whole &= time.fract() == 0.0;
                    self.are_samples &= is_sample(*time);
                    self.sum += time - self.first;
                }
                2 => {
                    self.xx += x * x;
                    self.xy += x * (time - self.mean);
                }
                _ => {
                    let off = ((time - self.mean) / self.period - x).abs();
                    self.residual = self.residual.max(off);
                }
            }
            self.row += 1;
        }
    }

    /// The rate of the times, which is that of the whole column; `None` where they are not even or their rate is no whole number.
    pub(crate) fn rate(
        &self,
        path: &Path,
        column: &Column,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<SampleRate>, ReadError> {
        if self.pass <= 3 || self.residual > FAR {
            return Ok(None);
        }
        let like = Column {
            values: vec![if self.are_whole { 1.0 } else { 0.5 }],
            ..column.clone()
        };
        let to_seconds = seconds_per_unit(path, &like, self.period, warnings)?;
        let found_hz = 1.0 / (self.period * to_seconds);
        let off = (found_hz.round() / found_hz - 1.0).abs();
        let is_whole = off <= ROUNDED && off * self.count as f64 <= FAR;
        let rate = is_whole.then(|| SampleRate::new(found_hz.round()));
        rate.transpose().map_err(ReadError::of(path))
    }
}
