//! The outcome of a closed loop as data: why it ended, which drive was kept, and why.

use std::fmt;

use piezotact::Warning;
use piezotact::correct::{MeasurementFault, MeasurementFaultWarning};
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::lineage::Mode;
use piezotact::statistics::{mean, t_quantile};
use serde::Serialize;

use super::ClosedLoopResult;

/// Why a measurement of a loop is not reliable.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "mishap", rename_all = "snake_case")]
pub enum LoopFailure {
    /// The bench failed.
    Bench {
        /// What it says.
        said: String,
    },
    /// Playback was cut short, samples were lost, or the run was interrupted.
    Playback {
        /// How.
        warning: Box<Warning>,
    },
    /// The force was not held.
    Force {
        /// From when on, s.
        from_s: f64,
        /// Its mean from there on, N.
        mean_n: f64,
        /// What it should be, N.
        asked_n: f64,
        /// How far it may be off, as a share.
        share: f64,
    },
    /// The sensor clips.
    SensorClips {
        /// The share of the response at a limit, 0–1.
        fraction: f64,
    },
    /// The response is no louder than its noise.
    Faint {
        /// The response, m/s² rms.
        rms_m_s2: f64,
        /// Its noise, m/s² rms.
        noise_m_s2: f64,
    },
    /// The response is inverted or ends too early.
    Response {
        /// How.
        warning: Box<Warning>,
    },
    /// No correction could be computed from this measurement.
    Correction {
        /// Why.
        said: String,
    },
}

impl LoopFailure {
    /// The failure as a warning.
    #[must_use]
    pub fn warning(&self) -> Warning {
        let fault = match self.clone() {
            Self::Playback { warning } | Self::Response { warning } => return *warning,
            Self::Bench { said } => MeasurementFault::Bench { said },
            Self::Correction { said } => MeasurementFault::Correction { said },
            Self::Force {
                from_s,
                mean_n,
                asked_n,
                share,
            } => MeasurementFault::Force {
                from_s,
                mean_n,
                asked_n,
                share,
            },
            Self::SensorClips { fraction } => MeasurementFault::SensorClips { fraction },
            Self::Faint {
                rms_m_s2,
                noise_m_s2,
            } => MeasurementFault::ResponseFaint {
                rms_m_s2,
                noise_m_s2,
            },
        };
        MeasurementFaultWarning::Failed { fault }.into()
    }
}

impl fmt::Display for LoopFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.warning().fmt(f)
    }
}

/// Why a loop ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "end", content = "why", rename_all = "snake_case")]
pub enum LoopEnd {
    /// The planned number of corrections was made.
    #[default]
    Done,
    /// There was no improvement in two iterations.
    NoBetter,
    /// It got clearly worse.
    Worse,
    /// A measurement was not reliable.
    Broken(LoopFailure),
}

impl fmt::Display for LoopEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("completed the requested number of corrections"),
            Self::NoBetter => f.write_str("stopped: no improvement in two iterations"),
            Self::Worse => f.write_str("stopped: the error became clearly larger"),
            Self::Broken(why) => write!(f, "a measurement was invalid: {why}"),
        }
    }
}

/// The errors of one measurement of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopErrors {
    /// The objective of the loop, dB: see [`super::Iteration::aim_db`].
    pub aim_db: f64,
    /// The rms error of the spectrum over what the inverse reaches, dB.
    pub spectrum_db: f64,
}

/// The quantities in which a corrected drive is compared with the open loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum GainCriterion {
    /// The objective of the loop.
    Aim,
    /// The spectrum error.
    Spectrum,
}

/// The comparison of the best corrected drive with the open loop, by measurements that were not used to choose either.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Gain {
    /// The number of the drive.
    pub number: usize,
    /// The error of the open loop minus that of the corrected drive, dB, positive if the corrected drive is closer; with the
    /// interval from the spread of the loop's own pairs of measurements.
    pub criteria: [Criterion<GainCriterion>; 2],
}

impl Gain {
    /// The gain of the drive `number`, measured as `closed` by measurements that did not choose it, over the open loop;
    /// `pairs` are the two measurements of every drive of the loop, those of the open loop first. `None` without either.
    ///
    /// Formula: mean(open) − mean(closed) ± t·s·√(1/2 + 1/n), n the measurements of `closed`; s² = Σd²/(2m) over the
    /// differences d of m pairs, t Student's with m degrees of freedom.
    pub(super) fn of(
        number: usize,
        pairs: &[[LoopErrors; 2]],
        closed: &[LoopErrors],
    ) -> Option<Self> {
        let open = pairs.first()?;
        if closed.is_empty() {
            return None;
        }
        let t = t_quantile(pairs.len())?;
        let gain = |what: GainCriterion, value: fn(&LoopErrors) -> f64| {
            let over = |all: &[LoopErrors]| mean(&all.iter().map(value).collect::<Vec<_>>());
            let squares: f64 = pairs
                .iter()
                .map(|[a, b]| (value(a) - value(b)).powi(2))
                .sum();
            let spread = (squares / (2 * pairs.len()) as f64).sqrt();
            let reach = t * spread * (0.5 + 1.0 / closed.len() as f64).sqrt();
            let found = over(open) - over(closed);
            Criterion::new(
                what,
                "dB",
                found,
                Some([found - reach, found + reach]),
                Limit::at_least(0.0),
            )
        };
        Some(Self {
            number,
            criteria: [
                gain(GainCriterion::Aim, |c| c.aim_db),
                gain(GainCriterion::Spectrum, |c| c.spectrum_db),
            ],
        })
    }

    /// Whether it came closer in `what`.
    #[must_use]
    pub fn outcome(&self, what: GainCriterion) -> Outcome {
        let mut of = self.criteria.iter().filter(|c| c.what == what);
        of.next().map_or(Outcome::NotDecided, |c| c.outcome)
    }

    /// Whether the corrected drive is kept: its objective is better beyond the spread of measurements, and,
    /// for a waveform, either by `alike_db` or without a worse spectrum.
    pub(super) fn keeps(&self, mode: Mode, alike_db: f64) -> bool {
        let [aim, spectrum] = &self.criteria;
        let clearly = aim.interval.is_some_and(|[low, _]| low >= alike_db);
        aim.outcome == Outcome::Met
            && (mode == Mode::Texture || clearly || spectrum.outcome != Outcome::NotMet)
    }
}

/// Which drive a loop kept, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SelectedDrive {
    /// The best corrected drive: it is closer than the open loop by more than the spread of measurements.
    Corrected,
    /// The open loop: nothing was corrected.
    NothingCorrected,
    /// The open loop: no correction came closer.
    NoneCloser,
    /// The open loop: the best correction came no closer beyond the spread of measurements when it was measured once more.
    WithinSpread,
    /// The open loop: the best correction was further off when it was measured once more.
    FurtherOff,
}

impl SelectedDrive {
    /// Whether it is the open loop's drive.
    #[must_use]
    pub fn keeps_open_loop(self) -> bool {
        self != Self::Corrected
    }
}

impl fmt::Display for SelectedDrive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Corrected => "the corrected drive is kept",
            Self::NothingCorrected => "the open-loop drive is kept: no correction was made",
            Self::NoneCloser => "the open-loop drive is kept: no correction reduced the error",
            Self::WithinSpread => {
                "the open-loop drive is kept: in the confirmation measurement, the best correction gave no improvement beyond \
                    the scatter of the measurements"
            }
            Self::FurtherOff => {
                "the open-loop drive is kept: in the confirmation measurement, the best correction had a larger error"
            }
        })
    }
}

impl ClosedLoopResult {
    /// Whether the drive that is kept has a worse spectrum than the open loop, beyond the spread of measurements.
    #[must_use]
    pub fn got_worse(&self) -> bool {
        let gain = self.gain.as_ref();
        !self.kept.keeps_open_loop()
            && gain.is_some_and(|gain| gain.outcome(GainCriterion::Spectrum) == Outcome::NotMet)
    }

    /// Whether the drive that is kept was measured once more, comes close to its target, and is not worse than the open loop.
    #[must_use]
    pub fn is_close(&self) -> bool {
        self.confirmed.is_some() && !self.got_worse() && self.best_verification().is_close()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look normal: sums of twelve uniform ones.
    struct Noise(u64);

    impl Noise {
        fn normal(&mut self) -> f64 {
            let uniform = |state: &mut u64| {
                *state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (*state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
        }
    }

    /// A loop of `truths` whose measurements scatter by 0.05 dB: the best by its second measurement, measured once more.
    fn kept(noise: &mut Noise, truths: &[f64]) -> bool {
        let mut measured = |truth: f64| {
            let db = truth + 0.05 * noise.normal();
            LoopErrors {
                aim_db: db,
                spectrum_db: db,
            }
        };
        let pairs: Vec<[LoopErrors; 2]> = truths
            .iter()
            .map(|t| [measured(*t), measured(*t)])
            .collect();
        let best = (0..truths.len())
            .min_by(|a, b| pairs[*a][1].aim_db.total_cmp(&pairs[*b][1].aim_db))
            .unwrap();
        let once_more = measured(truths[best]);
        let gain = Gain::of(best, &pairs, &[pairs[best][0], once_more]);
        best > 0 && gain.unwrap().keeps(Mode::Texture, 0.5)
    }

    /// Corrections that change nothing, or make it worse by 0.03 dB, are kept in 5 % of loops or fewer, though the best of
    /// seven looks better in most; those that gain 0.2 dB are kept.
    #[test]
    fn a_lucky_measurement_keeps_no_correction() {
        let mut noise = Noise(3);
        let mut share = |truths: &[f64]| {
            let loops = 2000;
            (0..loops).filter(|_| kept(&mut noise, truths)).count() as f64 / f64::from(loops)
        };
        let nothing = share(&[0.16; 7]);
        let worse = share(&[0.16, 0.19, 0.19, 0.19, 0.19]);
        let better = share(&[0.5, 0.3, 0.3, 0.3, 0.3]);
        assert!(nothing <= 0.05 && worse <= 0.02 && better >= 0.8);
    }

    /// A waveform a little closer does not pay for a worse spectrum (0.16 to 0.28 dB), and one much closer does.
    #[test]
    fn a_worse_spectrum_is_not_kept_for_little() {
        let at = |aim_db: f64, spectrum_db: f64| LoopErrors {
            aim_db,
            spectrum_db,
        };
        let pairs = [
            [at(-20.0, 0.16), at(-20.1, 0.17)],
            [at(-20.5, 0.28), at(-20.6, 0.28)],
        ];
        let gain = |nmse: f64, spectrum: f64| {
            let closed = [at(nmse, spectrum), at(nmse, spectrum)];
            Gain::of(1, &pairs, &closed).unwrap()
        };
        assert!(!gain(-20.5, 0.28).keeps(Mode::Replicate, 0.5));
        assert!(gain(-24.0, 0.28).keeps(Mode::Replicate, 0.5));
        assert_eq!(
            gain(-24.0, 0.28).outcome(GainCriterion::Spectrum),
            Outcome::NotMet
        );
        assert!(gain(-20.5, 0.16).keeps(Mode::Replicate, 0.5));
    }
}
