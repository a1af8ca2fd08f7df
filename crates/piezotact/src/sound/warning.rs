//! Warnings about sound devices.

use std::fmt;

use crate::number::{counted, digits, digits_signed, rounded};
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about sound devices: their calibration, their timing, and what they cannot record.
    pub enum SoundWarning {
        /// The calibration is old, or of a day to come.
        CalibrationOld("sound_calibration_old") {
            /// What was calibrated then.
            what: String,
            /// When it was made.
            made_on: String,
            /// How many days ago.
            days: f64,
            /// After how many it is old.
            most_days: f64,
        },
        /// The device was not calibrated: levels are relative to full scale.
        NotCalibrated("sound_not_calibrated") {
            /// What was not.
            what: String,
        },
        /// No channel records what is played: timing and level are not checked.
        NoLoopback("sound_no_loopback"),
        /// A sound input does not pass 0 Hz: a steady force is not recorded.
        AcCoupled("sound_input_ac_coupled") {
            /// The channel.
            channel: String,
        },
        /// The input reached its full scale.
        InputClipped("sound_input_clipped") {
            /// The channel.
            channel: String,
            /// How many samples.
            samples: u64,
        },
        /// The drive exceeded full scale and was limited.
        DriveLimited("sound_drive_limited") {
            /// How many samples.
            samples: u64,
        },
        /// The engine left parts of the signal silent.
        SilentParts("sound_silent_parts") {
            /// How many parts.
            parts: usize,
            /// How many samples in all.
            samples: usize,
        },
        /// Callbacks of the sound system came late.
        Stalled("sound_stalled") {
            /// How often.
            times: usize,
            /// The longest pause, s.
            longest_s: f64,
        },
        /// Few restarts.
        FewRestarts("sound_few_restarts") {
            /// How many.
            restarts: usize,
            /// Fewer than this are few.
            few: usize,
        },
        /// Restarts without a latency, or with samples lost.
        RestartsFailed("sound_restarts_failed") {
            /// Without the signal in the loopback.
            silent: usize,
            /// With lost samples.
            dropped: usize,
            /// Of how many.
            restarts: usize,
        },
        /// The clocks of output and input differ.
        ClocksApart("sound_clocks_apart") {
            /// By how much the input runs faster, ppm.
            ppm: f64,
            /// Half the 95 % interval, ppm.
            uncertainty_ppm: f64,
        },
        /// The latency is not what it was when it was measured.
        LatencyChanged("sound_latency_changed") {
            /// When it was measured.
            measured_on: String,
            /// Its median then, s.
            stored_s: f64,
            /// What it is now, s.
            found_s: f64,
        },
        /// Two ways of finding a level lead to different values.
        WaysDisagree("sound_ways_disagree") {
            /// Of what.
            what: String,
            /// How the value was found that is used.
            found_by: String,
            /// The other way.
            other_by: String,
            /// The first re the second, dB.
            by_db: f64,
        },
        /// The pulse of an output arrived on no input alone.
        WireNotFound("sound_wire_not_found") {
            /// What was expected and found.
            what: String,
        },
        /// The delay of the loopback stepped, and no loss was reported.
        DelayStepped("sound_delay_stepped") {
            /// Where, by the clock of the recording, s.
            at_s: f64,
            /// By how much longer it was from there on, s.
            by_s: f64,
        },
    }
}

impl WarningKind for SoundWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::CalibrationOld { .. }
            | Self::NotCalibrated { .. }
            | Self::WaysDisagree { .. } => {
                vec![Advice::Check(Subject::UnitAndScale)]
            }
            Self::AcCoupled { .. } => vec![Advice::MeasureForce],
            Self::InputClipped { .. } => vec![Advice::RecordAgain],
            Self::DriveLimited { .. } => vec![Advice::LowerLevel { to_db: None }],
            Self::SilentParts { .. } | Self::Stalled { .. } => {
                vec![Advice::CloseOtherPrograms, Advice::PlayAgain]
            }
            Self::RestartsFailed { .. } => vec![Advice::CloseOtherPrograms],
            Self::ClocksApart { .. } => vec![Advice::AlignChannels],
            Self::LatencyChanged { .. } => vec![Advice::MeasureAgain],
            Self::DelayStepped { .. } => vec![Advice::CloseOtherPrograms, Advice::RecordAgain],
            Self::NoLoopback | Self::FewRestarts { .. } | Self::WireNotFound { .. } => Vec::new(),
        }
    }
}

impl fmt::Display for SoundWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CalibrationOld {
                what,
                made_on,
                days,
                most_days,
            } => match *days < 0.0 {
                true => write!(f, "the calibration of {what} is dated {made_on}, a day to come: check the clock of this computer"),
                false => write!(
                    f,
                    "{what} of the sound device was calibrated on {made_on}, {} days ago: a calibration is old after {} days",
                    rounded(*days),
                    rounded(*most_days)
                ),
            },
            Self::NotCalibrated { what } => write!(
                f,
                "{what} was not calibrated: its levels are relative to full scale"
            ),
            Self::WireNotFound { what } => f.write_str(what),
            Self::NoLoopback => f.write_str(
                "no input records what is played: delay, level, lost samples and silent parts of the playback are not checked",
            ),
            Self::AcCoupled { channel } => write!(
                f,
                "`{channel}` is recorded by a sound input, which does not pass 0 Hz: a steady force is not in it"
            ),
            Self::InputClipped { channel, samples } => write!(
                f,
                "the input of `{channel}` reached its full scale in {}",
                counted(*samples as usize, "sample")
            ),
            Self::DriveLimited { samples } => write!(
                f,
                "the drive exceeded full scale in {}, which were limited",
                counted(*samples as usize, "sample")
            ),
            Self::SilentParts { parts, samples } => write!(
                f,
                "the loopback holds {} of silence, {samples} samples in all, where the drive has none",
                counted(*parts, "part")
            ),
            Self::Stalled { times, longest_s } => write!(
                f,
                "the sound system paused {}, at the longest for {} ms",
                counted(*times, "time"),
                digits(1e3 * longest_s)
            ),
            Self::FewRestarts { restarts, few } => write!(
                f,
                "{}: percentiles of the latency need at least {few} restarts",
                counted(*restarts, "restart")
            ),
            Self::RestartsFailed {
                silent,
                dropped,
                restarts,
            } => write!(
                f,
                "of {}, {silent} had no signal in the loopback and {dropped} lost samples",
                counted(*restarts, "restart")
            ),
            Self::ClocksApart {
                ppm,
                uncertainty_ppm,
            } => write!(
                f,
                "the clock of the input runs {} ppm {} than that of the output (±{} ppm, 95 %): what was recorded shares one clock, and verifications are \
                 corrected for it; every other comparison with the drive that was played is off by more and more",
                digits(ppm.abs()),
                if *ppm >= 0.0 { "faster" } else { "slower" },
                digits(*uncertainty_ppm)
            ),
            Self::LatencyChanged {
                measured_on,
                stored_s,
                found_s,
            } => write!(
                f,
                "the latency is {} ms now and was {} ms when it was measured on {measured_on}: cables, buffers or driver changed; it is left out",
                digits(1e3 * found_s),
                digits(1e3 * stored_s)
            ),
            Self::WaysDisagree {
                what,
                found_by,
                other_by,
                by_db,
            } => write!(
                f,
                "{what}: {found_by} gives {} dB re {other_by}; one of them is wrong: check readings, units and set-up",
                digits_signed(*by_db)
            ),
            Self::DelayStepped { at_s, by_s } => write!(
                f,
                "at {at_s:.2} s the delay from output to input stepped by {} ms: samples were lost or repeated, and the sound system did not report it",
                digits_signed(1e3 * by_s)
            ),
        }
    }
}
