//! The gate that a characterisation passes while it runs: a measurement that leaves its load, or in which the finger no
//! longer follows the drive, ends at once and is asked for again.

use std::fmt;

use piezotact::quantity::{Acceleration, Drive, Newtons, SampleRate, Seconds};
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::mean;
use piezotact::transfer::{CrossPlan, CrossSpectra};

use crate::procedure::LOWEST_JUDGED;
use crate::traits::{BenchError, Chunk};

/// What a characterisation must keep to.
#[derive(Clone, Debug, PartialEq)]
pub struct GateConfig {
    /// The mean force of every window may depart from its target by this share.
    pub force_share: f64,
    /// The median coherence of the driven lines of every window.
    pub least_coherence: f64,
    /// How long a window is.
    pub window: Seconds,
}

impl GateConfig {
    /// ±10 % of the load and a coherence of 0.9, over windows of 10 s.
    #[must_use]
    pub fn usual() -> Self {
        Self {
            force_share: 0.1,
            least_coherence: 0.9,
            window: Seconds(10.0),
        }
    }
}

/// Why a measurement is asked for again.
#[derive(Clone, Debug, PartialEq)]
pub enum Breach {
    /// The force left its target.
    Force {
        /// From when to when, s.
        window_s: [f64; 2],
        /// The mean force, N.
        mean_n: f64,
        /// The target, N.
        target_n: f64,
        /// By which share it may depart.
        share: f64,
    },
    /// The acceleration does not follow the drive.
    Coherence {
        /// From when to when, s.
        window_s: [f64; 2],
        /// The median coherence of the driven lines.
        median: f64,
        /// What is asked for.
        least: f64,
    },
    /// A repeat answers with the opposite sign of the first.
    Polarity {
        /// How much the two share, −1 to 1.
        correlation: f64,
    },
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Force {
                window_s: [from, to],
                mean_n,
                target_n,
                share,
            } => write!(
                f,
                "the force averaged {mean_n:.3} N from {from:.0} to {to:.0} s, expected {target_n} N ± {:.0} %: hold the finger so that the display shows {target_n} N",
                share * 100.0
            ),
            Self::Coherence {
                window_s: [from, to],
                median,
                least,
            } => write!(
                f,
                "coherence was {median:.4} from {from:.0} to {to:.0} s, expected {least} or more: put the finger on the actuator, and check the sensor and its wax"
            ),
            Self::Polarity { correlation } => write!(
                f,
                "it answers with the opposite sign of the first repeat (correlation {correlation:.2}): check the polarity of the sensor and the actuator"
            ),
        }
    }
}

impl std::error::Error for Breach {}

/// The places in a chunk of the channels that a gate judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GateRoles {
    /// The drive.
    pub drive: usize,
    /// The acceleration.
    pub acceleration: usize,
    /// The normal force; without one, coherence alone is judged.
    pub force: Option<usize>,
}

/// Watches the chunks of one run.
#[derive(Debug)]
pub struct Gate {
    config: GateConfig,
    target: Option<Newtons>,
    rate: SampleRate,
    plan: CrossPlan,
    roles: GateRoles,
    window: [Vec<f64>; 3],
    /// Samples before the window.
    before: usize,
    /// How many samples belong to the run; what comes after is rest.
    run: usize,
    breach: Option<Breach>,
}

impl Gate {
    /// A gate for a run of `run` samples at `rate` at a load of `target`, whose coherence is estimated with segments of
    /// `segment` samples.
    ///
    /// # Errors
    /// [`BenchError::Impossible`] when a window does not hold five segments.
    pub fn new(
        config: &GateConfig,
        target: Option<Newtons>,
        rate: SampleRate,
        roles: GateRoles,
        run: usize,
        segment: usize,
    ) -> Result<Self, BenchError> {
        let welch = WelchConfig::hann(segment);
        let plan = CrossPlan::new(&welch, rate).ok();
        let holds = rate.samples_in(config.window) / segment.max(1);
        match plan {
            Some(plan) if holds >= 5 => Ok(Self {
                config: config.clone(),
                target,
                rate,
                plan,
                roles,
                window: Default::default(),
                before: 0,
                run,
                breach: None,
            }),
            _ => Err(BenchError::Impossible {
                expected: format!(
                    "segments of which five fit into the {} over which the gate judges",
                    config.window
                ),
                found: segment.to_string(),
                todo: "take shorter segments, 2048 is usual at 5 kHz, or turn the gate off".into(),
            }),
        }
    }

    /// Judges every window as it fills.
    ///
    /// # Errors
    /// The [`Breach`], once there is one.
    pub fn admit(&mut self, chunk: &Chunk) -> Result<(), Breach> {
        let GateRoles {
            drive,
            acceleration,
            force,
        } = self.roles;
        let channels = [Some(drive), Some(acceleration), force];
        for (window, place) in self.window.iter_mut().zip(channels) {
            let channel = place.and_then(|place| chunk.channels.get(place));
            window.extend(channel.into_iter().flatten());
        }
        let length = self.rate.samples_in(self.config.window);
        while self.window[0].len() >= length {
            self.judge(length);
        }
        self.breach.clone().map_or(Ok(()), Err)
    }

    /// Judges what is left at the end, when it is at least half a window.
    pub fn finish(&mut self) {
        let left = self
            .run
            .saturating_sub(self.before)
            .min(self.window[0].len());
        if 2 * left >= self.rate.samples_in(self.config.window) || self.before == 0 {
            self.judge(left);
        }
    }

    /// Why the run is asked for again; `None` for one that passed.
    #[must_use]
    pub fn breach(&self) -> Option<&Breach> {
        self.breach.as_ref()
    }

    fn judge(&mut self, length: usize) {
        let parts: [Vec<f64>; 3] = self
            .window
            .each_mut()
            .map(|channel| channel.drain(..length.min(channel.len())).collect());
        let [drive, acceleration, force] = parts;
        let window_s = [self.before, self.before + length].map(|at| at as f64 / self.rate.hz());
        self.before += length;
        if self.breach.is_some() || length == 0 {
            return;
        }
        let share = self.config.force_share;
        let mean_n = mean(&force);
        if let Some(Newtons(target_n)) = self.target
            && self.roles.force.is_some()
            && (mean_n / target_n - 1.0).abs() > share
        {
            self.breach = Some(Breach::Force {
                window_s,
                mean_n,
                target_n,
                share,
            });
            return;
        }
        let spectra: Result<CrossSpectra<Drive, Acceleration>, _> =
            self.plan.estimate(&drive, &acceleration);
        // Of a window too short for a segment nothing can be said.
        let Ok(spectra) = spectra else { return };
        let least = self.config.least_coherence;
        // A sweep that is still below what the device answers to gives nothing to judge.
        let Some(median) = spectra.driven_coherence(LOWEST_JUDGED) else {
            return;
        };
        if median < least {
            self.breach = Some(Breach::Coherence {
                window_s,
                median,
                least,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 1_000.0;
    const ROLES: GateRoles = GateRoles {
        drive: 0,
        acceleration: 1,
        force: Some(2),
    };

    /// Chunks of a second: drive, acceleration and force, the last two as `answer` and `force_n` make them of the drive and
    /// of the second.
    fn run(
        seconds: usize,
        answer: impl Fn(usize, f64) -> f64,
        force_n: impl Fn(usize) -> f64,
    ) -> Gate {
        let mut random = crate::random::Random::stream(1, 1, "gate");
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let target = Some(Newtons(0.2));
        let mut gate = Gate::new(
            &GateConfig::usual(),
            target,
            rate,
            ROLES,
            seconds * 1_000,
            128,
        )
        .unwrap();
        for second in 0..seconds {
            let drive: Vec<f64> = (0..1_000).map(|_| random.normal()).collect();
            let acceleration = drive
                .iter()
                .map(|x| answer(second, *x) + 0.01 * random.normal())
                .collect();
            let chunk = Chunk {
                channels: vec![drive, acceleration, vec![force_n(second); 1_000]],
            };
            if gate.admit(&chunk).is_err() {
                break;
            }
        }
        gate.finish();
        gate
    }

    #[test]
    fn a_steady_run_passes() {
        assert_eq!(run(25, |_, x| x, |_| 0.21).breach(), None);
    }

    #[test]
    fn a_force_that_leaves_its_target_ends_the_run_there() {
        let gate = run(60, |_, x| x, |second| if second < 20 { 0.2 } else { 0.25 });
        let Some(Breach::Force {
            window_s, mean_n, ..
        }) = gate.breach()
        else {
            panic!("{:?}", gate.breach())
        };
        assert!(*window_s == [20.0, 30.0] && (mean_n - 0.25).abs() < 1e-12);
        assert_eq!(gate.before, 30_000);
        let told = gate.breach().unwrap().to_string();
        assert!(
            told.contains("0.250 N from 20 to 30 s") && told.contains("0.2 N ± 10 %"),
            "{told}"
        );
    }

    #[test]
    fn a_finger_that_lifts_ends_the_run() {
        let gate = run(60, |second, x| if second < 10 { x } else { 0.0 }, |_| 0.2);
        assert!(
            matches!(
                gate.breach(),
                Some(Breach::Coherence {
                    window_s: [10.0, 20.0],
                    ..
                })
            ),
            "{:?}",
            gate.breach()
        );
    }

    /// Shorter than a window: judged at the end all the same; a short rest is not judged.
    #[test]
    fn what_is_left_at_the_end_is_judged_when_it_is_long_enough() {
        assert!(run(6, |_, x| x, |_| 0.3).breach().is_some());
        assert!(
            run(14, |_, x| x, |second| if second < 10 { 0.2 } else { 0.3 })
                .breach()
                .is_none()
        );
        assert!(
            run(16, |_, x| x, |second| if second < 10 { 0.2 } else { 0.3 })
                .breach()
                .is_some()
        );
    }

    /// Without a force, coherence is judged all the same, and no load is missed that nobody measured.
    #[test]
    fn without_a_force_the_finger_is_judged_by_coherence() {
        let roles = GateRoles {
            force: None,
            ..ROLES
        };
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut random = crate::random::Random::stream(1, 1, "gate");
        let mut judged = |answers: f64| {
            let usual = GateConfig::usual();
            let target = Some(Newtons(0.2));
            let mut gate = Gate::new(&usual, target, rate, roles, 20_000, 128).unwrap();
            for _ in 0..20 {
                let drive: Vec<f64> = (0..1_000).map(|_| random.normal()).collect();
                let noisy = |x: &f64| answers * x + 0.01 * random.normal();
                let acceleration = drive.iter().map(noisy).collect();
                let channels = vec![drive, acceleration];
                if gate.admit(&Chunk { channels }).is_err() {
                    break;
                }
            }
            gate.finish();
            gate.breach().cloned()
        };
        assert_eq!(judged(1.0), None);
        assert!(matches!(judged(0.0), Some(Breach::Coherence { .. })));
    }

    #[test]
    fn segments_longer_than_windows_are_refused() {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        assert!(Gate::new(&GateConfig::usual(), None, rate, ROLES, 1, 4_096).is_err());
    }
}
