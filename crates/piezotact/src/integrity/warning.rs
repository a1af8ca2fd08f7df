//! Warnings about signal defects: fields and sentences.

use std::fmt;

use crate::number::digits_that_count;
use crate::warning::words::percent;
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// A defect of a signal on its way from the sensor to the file.
    pub enum SignalWarning {
        /// A channel that never changes.
        DeadChannel("dead_channel") of Channel(channel) {
            /// The channel.
            channel: String,
        },
        /// A channel holds one value while it should not.
        Frozen("frozen") of Channel(channel) {
            /// The channel.
            channel: String,
            /// How often.
            count: usize,
            /// Where the longest begins, s.
            at_s: f64,
            /// How long the longest lasts, s.
            longest_s: f64,
            /// The share of the recording, 0–1.
            share: f64,
        },
        /// A channel falls to its floor at once and comes back at once.
        DropOuts("drop_outs") of Channel(channel) {
            /// The channel.
            channel: String,
            /// How often.
            count: usize,
            /// Where the longest begins, s.
            at_s: f64,
            /// How long the longest lasts, s.
            longest_s: f64,
            /// The share of the recording, 0–1.
            share: f64,
        },
        /// Lines of the mains and their harmonics.
        MainsHum("mains_hum") of Channel(channel) {
            /// The channel.
            channel: String,
            /// The frequency of the mains as found, Hz.
            mains_hz: f64,
            /// The lines found, as multiples of it.
            harmonics: Vec<usize>,
            /// Their share of the power, 0–1.
            share: f64,
            /// How far the strongest stands above the lines around it, dB.
            above_db: f64,
        },
        /// Two channels are one signal.
        Copied("copied") of Channel(channel) {
            /// The channel that is a copy.
            channel: String,
            /// Of which.
            of: String,
            /// The copy over the original.
            factor: f64,
            /// How much later it is, s.
            delay_s: f64,
        },
        /// A drive beyond what can be played.
        DriveBeyondLimit("drive_beyond_limit") of Channel(channel) {
            /// The channel.
            channel: String,
            /// Its largest magnitude, of full scale.
            peak: f64,
            /// The limit, of full scale.
            limit: f64,
            /// The share of samples beyond it, 0–1.
            share: f64,
            /// By how much the level of the played drive is below this drive, dB.
            lost_db: f64,
        },
        /// A response that is dead while the drive goes on.
        ResponseDead("response_dead") of Channel(channel) {
            /// The channel.
            channel: String,
            /// How often.
            count: usize,
            /// How long the longest lasts, s.
            longest_s: f64,
            /// The share of the drive's power that was played meanwhile, 0–1.
            share: f64,
            /// How far the transfer function is too low, dB.
            low_db: f64,
        },
        /// Clipping of a drive or a response behind a transfer function.
        ClippedTransfer("clipped_transfer") of Channel(channel) {
            /// The channel.
            channel: String,
            /// The share of samples at the limit, 0–1.
            fraction: f64,
            /// How far the transfer function is off at most, dB; below zero where it is too low. Absent where it cannot be said.
            off_db: Option<f64>,
        },
    }
}

impl WarningKind for SignalWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, LeaveOut, LowerLevel, RecordAgain};
        match self {
            Self::DeadChannel { .. } => vec![Check(Subject::CableAndRange)],
            Self::Frozen { .. } => vec![RecordAgain, LeaveOut],
            Self::DropOuts { .. } => vec![Check(Subject::CableAndRange), RecordAgain],
            Self::MainsHum { .. } => vec![Check(Subject::ShieldAndEarth), RecordAgain],
            Self::Copied { .. } => vec![Check(Subject::Wiring)],
            Self::DriveBeyondLimit { .. } => {
                vec![Check(Subject::UnitAndScale), LowerLevel { to_db: None }]
            }
            Self::ResponseDead { .. } => vec![RecordAgain],
            Self::ClippedTransfer { .. } => vec![LowerLevel { to_db: None }, RecordAgain],
        }
    }
}

/// A time as text.
fn time(seconds: f64) -> String {
    if seconds.abs() < 1.0 {
        format!("{:.0} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

fn times(count: usize) -> String {
    if count == 1 {
        "once".into()
    } else {
        format!("{count} times")
    }
}

impl fmt::Display for SignalWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DeadChannel { channel } => {
                write!(f, "`{channel}` is constant and contains no signal")
            }
            Self::Frozen {
                channel,
                count,
                at_s,
                longest_s,
                share,
            } => write!(
                f,
                "`{channel}` stays at one value {}, longest for {} from {at_s:.2} s on, {} of the time: the sensor or its \
                    connection was frozen",
                times(*count),
                time(*longest_s),
                percent(*share)
            ),
            Self::DropOuts {
                channel,
                count,
                at_s,
                longest_s,
                share,
            } => write!(
                f,
                "`{channel}` drops out {}, longest for {} from {at_s:.2} s on, {} of the time: it falls abruptly to its floor \
                    and returns abruptly",
                times(*count),
                time(*longest_s),
                percent(*share)
            ),
            Self::MainsHum {
                channel,
                mains_hz,
                harmonics,
                share,
                above_db,
            } => {
                let lines: Vec<String> = harmonics
                    .iter()
                    .take(4)
                    .map(|n| format!("{:.0}", mains_hz * *n as f64))
                    .collect();
                let more = if harmonics.len() > 4 { ", …" } else { "" };
                write!(
                    f,
                    "`{channel}` contains spectral lines of constant phase at {}{more} Hz, {} of its power and up \
                        to {above_db:.0} dB above the neighbouring lines: this is typical of mains hum",
                    lines.join(", "),
                    percent(*share)
                )
            }
            Self::Copied {
                channel,
                of,
                factor,
                delay_s,
            } => {
                write!(
                    f,
                    "`{channel}` is `{of}` times {}",
                    digits_that_count(*factor, 4)
                )?;
                if *delay_s != 0.0 {
                    let side = if *delay_s > 0.0 { "later" } else { "earlier" };
                    write!(f, ", {:.2} ms {side}", delay_s.abs() * 1e3)?;
                }
                f.write_str(
                    ": the same signal was recorded twice, so a transfer function between the two has no meaning",
                )
            }
            Self::DriveBeyondLimit {
                channel,
                peak,
                limit,
                share,
                lost_db,
            } => {
                write!(
                    f,
                    "`{channel}` reaches {peak:.2} of full scale, but only {limit:.2} can be played: {} of its samples are \
                        beyond this limit",
                    percent(*share)
                )?;
                if *lost_db >= 0.05 {
                    write!(
                        f,
                        ", and the level that can be played is {lost_db:.1} dB lower"
                    )?;
                }
                Ok(())
            }
            Self::ResponseDead {
                channel,
                count,
                longest_s,
                share,
                low_db,
            } => write!(
                f,
                "`{channel}` has no signal {}, longest for {}, while {} of the drive is played: the transfer function is \
                    about {low_db:.1} dB too low",
                times(*count),
                time(*longest_s),
                percent(*share)
            ),
            Self::ClippedTransfer {
                channel,
                fraction,
                off_db,
            } => {
                write!(
                    f,
                    "{} of the samples of `{channel}` are at a limit",
                    percent(*fraction)
                )?;
                match off_db {
                    Some(off_db) if *off_db < 0.0 => write!(
                        f,
                        ": the transfer function is up to {:.1} dB too low",
                        -off_db
                    ),
                    Some(off_db) => write!(
                        f,
                        ": the transfer function is up to {off_db:.1} dB too high"
                    ),
                    None => Ok(()),
                }
            }
        }
    }
}
