//! Warnings about a closed loop.

use std::fmt;

use crate::number::{digits, rounded};
use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use crate::warning::{Advice, Subject, Warning, WarningKind, causes, warnings};

warnings! {
    /// Warnings about a closed loop.
    pub enum LoopWarning {
        /// A closed loop got worse and was stopped.
        LoopStopped("loop_stopped") {
            /// The best iteration.
            best: usize,
            /// Why it was stopped.
            why: LoopStop,
        },
        /// A loop ended further from its target than the limit.
        TargetMissed("target_missed") {
            /// The rms error of the spectrum that is left, dB.
            error_db_rms: f64,
            /// The limit, dB.
            limit_db: f64,
        },
        /// Lines of the target that the sensor's noise hides.
        TargetInNoise("target_in_noise") {
            /// Their share of the band's lines, 0–1.
            share: f64,
            /// The bands in which they lie.
            bands: Vec<Band>,
        },
        /// The crests of a drive were limited, which changed its waveform.
        CrestsPressed("crests_pressed") {
            /// The correlation with the drive as it was asked for.
            correlation: f64,
        },
    }
}

causes! {
    /// Why a closed loop was stopped.
    pub enum LoopStop {
        /// It got clearly worse.
        GotWorse("got_worse"),
        /// A measurement was not reliable.
        NotBelieved("not_believed") {
            /// What was wrong with it.
            cause: Warning,
        },
        /// The confirmation measurement of the drive that was kept failed.
        NotConfirmed("not_confirmed") {
            /// What was wrong with the measurement.
            cause: Warning,
        },
        /// A cause in words.
        Said("said") {
            /// What was said.
            text: String,
        },
    }
}

warnings! {
    /// What can be wrong with one measurement of a closed loop.
    pub enum MeasurementFaultWarning {
        /// The bench failed.
        BenchFailed("bench_failed") {
            /// What it said.
            said: String,
        },
        /// The force was not held.
        ForceNotHeld("force_not_held") {
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
        SensorClips("sensor_clips") {
            /// The share of the response at a limit, 0–1.
            fraction: f64,
        },
        /// The response is no louder than its noise.
        Faint("response_faint") {
            /// The response, m/s² rms.
            rms_m_s2: f64,
            /// Its noise, m/s² rms.
            noise_m_s2: f64,
        },
        /// No correction could be computed from this measurement.
        NotCorrected("not_corrected") {
            /// What the correction said.
            said: String,
        },
    }
}

impl WarningKind for MeasurementFaultWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        Vec::new()
    }
}

impl fmt::Display for MeasurementFaultWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BenchFailed { said } | Self::NotCorrected { said } => f.write_str(said),
            Self::ForceNotHeld {
                from_s,
                mean_n,
                asked_n,
                share,
            } => write!(
                f,
                "from {from_s:.0} s on, the mean force was {mean_n:.3} N, expected {asked_n} N ± {:.0} %: hold the finger so \
                    that the display shows this force",
                share * 100.0,
                asked_n = rounded(*asked_n)
            ),
            Self::SensorClips { fraction } => write!(
                f,
                "{:.1} % of the samples of the response are at a limit: the sensor clips; use its larger range, or render at a \
                    lower level",
                fraction * 100.0
            ),
            Self::Faint {
                rms_m_s2,
                noise_m_s2,
            } => write!(
                f,
                "the response ({} m/s² rms) is less than twice its noise ({}): the finger lifted, the sensor came off, the \
                    amplifier is off, or the level of the texture is too low for a correction",
                digits(*rms_m_s2),
                digits(*noise_m_s2)
            ),
        }
    }
}

impl fmt::Display for LoopStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GotWorse => f.write_str("stopped: the error became clearly larger"),
            Self::NotBelieved { cause } => {
                write!(f, "a measurement was invalid: {cause}")
            }
            Self::NotConfirmed { cause } => write!(
                f,
                "the confirmation measurement of the drive that is kept failed: {cause}"
            ),
            Self::Said { text } => f.write_str(text),
        }
    }
}

impl WarningKind for LoopWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::LoopStopped { .. } => vec![Advice::CharacteriseAgain],
            Self::TargetMissed { .. } => {
                vec![Advice::Check(Subject::Lines), Advice::CharacteriseAgain]
            }
            Self::TargetInNoise { .. } => vec![Advice::RaiseLevel, Advice::QuieterSensor],
            Self::CrestsPressed { .. } => vec![Advice::LowerLevel { to_db: None }],
        }
    }
}

impl fmt::Display for LoopWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LoopStopped { best, why } => write!(
                f,
                "the closed loop ended early ({why}); the drive is that of iteration {best}: the device or the finger may have changed"
            ),
            Self::TargetMissed {
                error_db_rms,
                limit_db,
            } => write!(
                f,
                "the best drive of the loop has an error of {error_db_rms:.1} dB rms (limit {limit_db} dB): the device may not \
                    respond over the whole band",
                limit_db = rounded(*limit_db)
            ),
            Self::TargetInNoise { share, bands } => write!(
                f,
                "in {} of the band ({}) the target is below the noise of the sensor: most of the error there is noise, and \
                    little of it can be corrected",
                percent(*share),
                list(bands)
            ),
            Self::CrestsPressed { correlation } => write!(
                f,
                "the peaks of the drive were limited so that it fits (correlation {correlation:.2} with the requested drive): \
                    the spectrum is kept, but sudden bursts are weaker"
            ),
        }
    }
}
