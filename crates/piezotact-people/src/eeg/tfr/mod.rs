//! Power over time and frequency by Morlet wavelets.
//!
//! A [`TfrPlan`] is made once for a rate, a length and frequencies, and processes any number of epochs. Nothing is kept of single trials
//! but what is asked for: their average, or their mean power in bands and windows.

mod run;
mod spread;
mod wavelet;
mod windows;

use crate::eeg::erd::Part;
use piezotact::fourier::{Complex, ComplexPlanner};
use piezotact::quantity::{Band, SampleRate};
use serde::{Deserialize, Serialize};

use super::epochs::Epochs;
use run::{good_length, response};

pub(super) use run::Sink;
pub(super) use spread::SpreadSink;
pub use windows::{TrialPowers, Window};
pub(super) use windows::{WindowSink, times_within};

/// More frequencies are a mistake.
const MOST_FREQUENCIES: f64 = 1000.0;

/// What is estimated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TfrConfig {
    /// The frequencies, Hz.
    pub frequencies_hz: Vec<f64>,
    /// The number of cycles at each frequency: a wavelet has a standard deviation of cycles/(2π·f).
    pub cycles: Vec<f64>,
    /// Every so many-th sample is given out; power is computed at the full rate.
    pub decimation: usize,
}

/// How many cycles wavelets have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cycles {
    /// As many at every frequency.
    Constant(f64),
    /// The frequency in Hz over this: wavelets of one length at every frequency.
    FrequencyOver(f64),
}

impl TfrConfig {
    /// Frequencies from the lower to the upper end of `range`, `step_hz` apart, with every sample given out.
    ///
    /// # Errors
    /// [`TfrError::Steps`] unless the step is above 0 and gives at most 1000 frequencies.
    pub fn over(range: Band, step_hz: f64, cycles: Cycles) -> Result<Self, TfrError> {
        let (low, high) = (range.low().0, range.high().0);
        let steps = (high - low) / step_hz;
        if !(step_hz > 0.0 && steps < MOST_FREQUENCIES) {
            return Err(TfrError::Steps { step_hz });
        }
        let frequencies_hz: Vec<f64> = (0..=(steps + 1e-9) as usize)
            .map(|i| low + step_hz * i as f64)
            .collect();
        let of = |hz: &f64| match cycles {
            Cycles::Constant(count) => count,
            Cycles::FrequencyOver(share) => hz / share,
        };
        Ok(Self {
            cycles: frequencies_hz.iter().map(of).collect(),
            frequencies_hz,
            decimation: 1,
        })
    }

    /// The length of the longest wavelet, s: ten standard deviations. No epoch is shorter.
    #[must_use]
    pub fn longest_s(&self) -> f64 {
        5.0 * self.reach_s()
    }

    /// How far the longest wavelet reaches, s: two standard deviations. The ends of epochs touch what is nearer to them.
    #[must_use]
    pub fn reach_s(&self) -> f64 {
        let all = self.frequencies_hz.iter().zip(&self.cycles);
        all.map(|(hz, cycles)| 2.0 * sd_s(*hz, *cycles))
            .fold(0.0, f64::max)
    }
}

/// A planned estimate for epochs of one rate and length.
#[derive(Clone)]
pub struct TfrPlan {
    config: TfrConfig,
    rate: SampleRate,
    samples: usize,
    smears_s: Vec<f64>,
    responses: Vec<Vec<f64>>,
    length: usize,
    forward: std::sync::Arc<dyn piezotact::fourier::Fft<f64>>,
    inverse: std::sync::Arc<dyn piezotact::fourier::Fft<f64>>,
}

impl std::fmt::Debug for TfrPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TfrPlan")
            .field("config", &self.config)
            .field("rate", &self.rate)
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl TfrPlan {
    /// A plan for epochs of `samples` at `rate`.
    ///
    /// Source: MNE-Python's `tfr_array_morlet` (with `zero_mean`); C. Tallon-Baudry et al. (1997), J. Neurosci. 17.
    ///
    /// # Errors
    /// [`TfrError`] without a frequency, for one outside 0 to half the rate, cycles that are not one positive number for each frequency, a
    /// wavelet longer than the epoch, or a decimation of 0 or above the number of samples.
    pub fn plan(config: &TfrConfig, rate: SampleRate, samples: usize) -> Result<Self, TfrError> {
        check(config, rate, samples)?;
        let mut waves = Vec::new();
        let mut smears_s = Vec::new();
        for (&frequency_hz, &cycles) in config.frequencies_hz.iter().zip(&config.cycles) {
            // Before a wavelet is made, as it may be longer than the memory.
            let sd_s = sd_s(frequency_hz, cycles);
            let length = wavelet::morlet_length(sd_s, rate.hz());
            if length > samples {
                return Err(TfrError::LongerThanEpoch {
                    frequency_hz,
                    wavelet_s: length as f64 / rate.hz(),
                    epoch_s: samples as f64 / rate.hz(),
                });
            }
            smears_s.push(sd_s);
            waves.push(wavelet::morlet(frequency_hz, sd_s, rate.hz()));
        }
        let longest = waves.iter().map(Vec::len).max();
        // What wraps around only meets zeros: half a wavelet behind the samples is enough.
        let needed = samples + longest.unwrap_or(0) / 2;
        let folded = good_length(needed.div_ceil(config.decimation));
        let length = folded * config.decimation;
        let mut planner = ComplexPlanner::new();
        let forward = planner.plan_fft_forward(length);
        let inverse = planner.plan_fft_inverse(folded);
        let mut scratch = vec![Complex::default(); forward.get_inplace_scratch_len()];
        let responses = waves
            .iter()
            .map(|wave| response(wave, length, &*forward, &mut scratch))
            .collect();
        Ok(Self {
            config: config.clone(),
            rate,
            samples,
            smears_s,
            responses,
            length,
            forward,
            inverse,
        })
    }

    /// What is estimated.
    #[must_use]
    pub fn config(&self) -> &TfrConfig {
        &self.config
    }

    /// The temporal smear at each frequency, s: the standard deviation of the amplitude envelope of the wavelet. Power at a time holds that of
    /// about two of them before and after.
    #[must_use]
    pub fn smears_s(&self) -> &[f64] {
        &self.smears_s
    }

    /// The number of times given out for each epoch.
    #[must_use]
    pub fn times(&self) -> usize {
        self.samples.div_ceil(self.config.decimation)
    }

    /// The mean power over epochs, channels × frequencies × times, V².
    ///
    /// # Errors
    /// [`TfrError::Epochs`] for epochs of another rate or length than planned.
    pub fn average(&self, epochs: &Epochs) -> Result<Power, TfrError> {
        let mut sink = AverageSink::new(self, epochs);
        self.run(epochs, &mut sink)?;
        Ok(sink.finish(self, epochs))
    }

    /// The mean power of each channel and epoch in each of `windows`, V²; nothing else is kept of single epochs.
    ///
    /// # Errors
    /// [`TfrError::Epochs`] for epochs of another rate or length than planned, [`TfrError::NoTime`] or [`TfrError::NoFrequency`] for a window without a time or frequency.
    pub fn trials(&self, epochs: &Epochs, windows: &[Window]) -> Result<TrialPowers, TfrError> {
        let mut sink = WindowSink::new(self, epochs, windows)?;
        self.run(epochs, &mut sink)?;
        Ok(sink.finish())
    }
}

/// The standard deviation of a Morlet wavelet, s.
fn sd_s(frequency_hz: f64, cycles: f64) -> f64 {
    cycles / (std::f64::consts::TAU * frequency_hz)
}

/// Checks all that needs no wavelet.
fn check(config: &TfrConfig, rate: SampleRate, samples: usize) -> Result<(), TfrError> {
    let TfrConfig {
        frequencies_hz,
        cycles,
        decimation,
        ..
    } = config;
    if frequencies_hz.is_empty() || cycles.len() != frequencies_hz.len() {
        return Err(TfrError::Cycles {
            frequencies: frequencies_hz.len(),
            found: cycles.len(),
        });
    }
    if *decimation == 0 || *decimation > samples {
        return Err(TfrError::Decimation {
            found: *decimation,
            samples,
        });
    }
    let nyquist_hz = rate.nyquist().0;
    for (&found_hz, &cycles) in frequencies_hz.iter().zip(cycles) {
        if !(found_hz > 0.0 && found_hz <= nyquist_hz) {
            return Err(TfrError::Frequency {
                found_hz,
                nyquist_hz,
            });
        }
        if !(cycles > 0.0 && cycles.is_finite()) {
            return Err(TfrError::NoCycles {
                frequency_hz: found_hz,
                found: cycles,
            });
        }
    }
    Ok(())
}

/// Mean power over epochs.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// The names of the channels.
    pub channels: Vec<String>,
    pub frequencies_hz: Vec<f64>,
    /// The times from the event, s.
    pub times_s: Vec<f64>,
    /// The temporal smear at each frequency, s.
    pub smears_s: Vec<f64>,
    /// How many epochs were averaged.
    pub epochs: usize,
    /// The first and the last time of the epochs, s.
    pub extent_s: [f64; 2],
    /// Channels × frequencies × times, V².
    pub values: Vec<f64>,
}

impl Power {
    /// Power over time of one channel and frequency, V².
    #[must_use]
    pub fn line(&self, channel: usize, frequency: usize) -> &[f64] {
        let times = self.times_s.len();
        let start = (channel * self.frequencies_hz.len() + frequency) * times;
        &self.values[start..start + times]
    }
}

/// Adds up power over epochs.
pub(super) struct AverageSink {
    frequencies: usize,
    times: usize,
    arch: pulp::Arch,
    sums: Vec<f64>,
}

impl AverageSink {
    pub(super) fn new(plan: &TfrPlan, epochs: &Epochs) -> Self {
        let frequencies = plan.config.frequencies_hz.len();
        let times = plan.times();
        Self {
            frequencies,
            times,
            arch: pulp::Arch::new(),
            sums: vec![0.0; epochs.channels().len() * frequencies * times],
        }
    }

    pub(super) fn finish(self, plan: &TfrPlan, epochs: &Epochs) -> Power {
        let mut values = self.sums;
        for value in &mut values {
            *value /= epochs.count() as f64;
        }
        Power {
            channels: epochs.channels().to_vec(),
            frequencies_hz: plan.config.frequencies_hz.clone(),
            times_s: (0..self.times)
                .map(|i| epochs.time_s(i * plan.config.decimation))
                .collect(),
            smears_s: plan.smears_s.clone(),
            epochs: epochs.count(),
            extent_s: [epochs.first_s(), epochs.last_s()],
            values,
        }
    }
}

impl Sink for AverageSink {
    fn take(&mut self, channel: usize, _: usize, frequency: usize, z: &[Complex<f64>]) {
        let start = (channel * self.frequencies + frequency) * self.times;
        let sums = &mut self.sums[start..start + self.times];
        self.arch.dispatch(|| {
            for (sum, value) in sums.iter_mut().zip(z) {
                *sum += value.re * value.re + value.im * value.im;
            }
        });
    }
}

/// Power over time and frequency, or a change of it, that cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TfrError {
    /// A step that gives no frequencies.
    #[error(
        "expected a step of frequencies above 0 Hz that gives at most 1000, found {step_hz} Hz; 1 Hz is usual"
    )]
    Steps { step_hz: f64 },
    /// No frequency, or not one number of cycles for each.
    #[error(
        "expected one number of cycles for each of at least one frequency, found {found} for {frequencies}; state as many of both"
    )]
    Cycles {
        /// How many frequencies there are.
        frequencies: usize,
        /// How many numbers of cycles.
        found: usize,
    },
    /// A number of cycles that is none.
    #[error(
        "expected a number of cycles above 0 at {frequency_hz} Hz, found {found}; 4 to 7 are usual"
    )]
    NoCycles { frequency_hz: f64, found: f64 },
    /// A frequency outside the band of the signal.
    #[error(
        "expected a frequency above 0 Hz up to half the rate ({nyquist_hz} Hz), found {found_hz} Hz; state another"
    )]
    Frequency {
        /// What was found, Hz.
        found_hz: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// A wavelet that is longer than the epoch.
    #[error(
        "the wavelet at {frequency_hz} Hz is {wavelet_s} s long, longer than the epoch of {epoch_s} s: take fewer cycles, a higher frequency or longer epochs"
    )]
    LongerThanEpoch {
        frequency_hz: f64,
        /// The length of the wavelet, s.
        wavelet_s: f64,
        /// The length of the epoch, s.
        epoch_s: f64,
    },
    /// A decimation of 0, or of more than there are samples.
    #[error(
        "expected every n-th sample with n from 1 to the {samples} samples of an epoch, found {found}; 1 keeps all"
    )]
    Decimation {
        found: usize,
        /// The samples of an epoch.
        samples: usize,
    },
    /// Epochs of another rate or length than planned.
    #[error(
        "internal error: planned for {samples} samples at {rate_hz} Hz, found {found} at {found_hz} Hz; please report it"
    )]
    Epochs {
        samples: usize,
        /// The rate planned, Hz.
        rate_hz: f64,
        found: usize,
        /// The rate found, Hz.
        found_hz: f64,
    },
    /// No time.
    #[error(
        "no time of the epoch ({first_s} s to {last_s} s) lies in the window from {from_s} s to {to_s} s: state another"
    )]
    NoTime {
        /// The window's first time, s.
        from_s: f64,
        /// Its last time, s.
        to_s: f64,
        /// The epoch's first time, s.
        first_s: f64,
        /// Its last time, s.
        last_s: f64,
    },
    /// No frequency.
    #[error(
        "no planned frequency lies between {low_hz} Hz and {high_hz} Hz: plan frequencies within the band"
    )]
    NoFrequency {
        /// The band's lower end, Hz.
        low_hz: f64,
        /// Its upper end, Hz.
        high_hz: f64,
    },
    /// Too few epochs.
    #[error("expected at least {needed} epochs, found {found}; record more, or reject fewer")]
    FewEpochs {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A part outside the epoch.
    #[error(
        "the {part} ({from_s} s to {to_s} s) is not within the epoch ({first_s} s to {last_s} s): state another, or cut longer epochs"
    )]
    Outside {
        part: Part,
        /// Its first time, s.
        from_s: f64,
        /// Its last time, s.
        to_s: f64,
        /// The epoch's first time, s.
        first_s: f64,
        /// The epoch's last time, s.
        last_s: f64,
    },
    /// A part that lies only where wavelets reach beyond the epoch.
    #[error(
        "the {part} ({from_s} s to {to_s} s) lies within {reach_s:.3} s of the ends of the epoch, the reach of the wavelet: cut longer epochs, or take fewer cycles"
    )]
    AtEdge {
        part: Part,
        /// Its first time, s.
        from_s: f64,
        /// Its last time, s.
        to_s: f64,
        /// Two standard deviations of the wavelet, s.
        reach_s: f64,
    },
    /// A baseline that overlaps the window.
    #[error("the baseline overlaps the window by {by_s:.3} s: move one of them")]
    Overlap {
        /// By how much, s.
        by_s: f64,
    },
    /// A baseline without power.
    #[error("the baseline of {channel} has no power: leave the channel out")]
    NoPower { channel: String },
    /// No band.
    #[error("no band of frequencies above 0 Hz is stated: state one")]
    NoBand,
}
