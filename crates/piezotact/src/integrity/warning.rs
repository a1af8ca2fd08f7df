//! Warnings about signal defects: fields and sentences.

use crate::number::{digits, digits_that_count};
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// A defect of a signal on its way from the sensor to the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SignalWarning {
    /// A channel that cannot be trusted.
    #[error("`{channel}` {fault}; {}", fault.advice())]
    #[serde(rename = "channel_doubtful")]
    Channel {
        channel: String,
        #[serde(flatten)]
        fault: ChannelFault,
    },
}

/// What is wrong with a channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum ChannelFault {
    /// A channel that never changes.
    #[error("is constant and contains no signal")]
    Dead,
    /// A channel holds one value while it should not.
    #[error(
        "stays at one value {}, longest for {} from {at_s:.2} s on, {} of the time: the sensor or its connection was frozen",
        times(*count),
        time(*longest_s),
        percent(*share)
    )]
    Frozen {
        count: usize,
        at_s: f64,
        longest_s: f64,
        share: f64,
    },
    /// A channel falls to its floor at once and comes back at once.
    #[error(
        "drops out {}, longest for {} from {at_s:.2} s on, {} of the time: it falls abruptly to its floor and returns abruptly",
        times(*count),
        time(*longest_s),
        percent(*share)
    )]
    DropOuts {
        count: usize,
        at_s: f64,
        longest_s: f64,
        share: f64,
    },
    /// Lines of the mains and their harmonics.
    #[error(
        "contains spectral lines of constant phase at {} Hz, {} of its power and up to {above_db:.0} dB above the neighbouring lines: this is \
            typical of mains hum",
        lines_of(*mains_hz, harmonics),
        percent(*share)
    )]
    MainsHum {
        mains_hz: f64,
        harmonics: Vec<usize>,
        share: f64,
        above_db: f64,
    },
    /// Lines that are there while nothing is touched.
    #[error(
        "has lines at {} Hz while nothing is touched too, {} of the power of the strokes: they come from the mains or a machine, not from a texture",
        frequencies(lines_hz),
        percent(*share)
    )]
    LinesAtRest { lines_hz: Vec<f64>, share: f64 },
    /// Two channels are one signal.
    #[error(
        "is `{of}` times {}{}: the same signal was recorded twice, so a transfer function between the two has no meaning",
        digits_that_count(*factor, 4),
        delayed(*delay_s)
    )]
    Copied {
        of: String,
        factor: f64,
        delay_s: f64,
    },
    /// A drive beyond what can be played.
    #[error(
        "reaches {peak:.2} of full scale, but only {limit:.2} can be played: {} of its samples are beyond this limit{}",
        percent(*share),
        if *lost_db >= 0.05 { format!(", which lowers the played level by {lost_db:.1} dB") } else { String::new() }
    )]
    BeyondLimit {
        peak: f64,
        limit: f64,
        share: f64,
        lost_db: f64,
    },
    /// A response that is dead while the drive goes on.
    #[error(
        "has no signal {}, longest for {}, while {} of the drive is played: the transfer function is about {low_db:.1} dB too low",
        times(*count),
        time(*longest_s),
        percent(*share)
    )]
    DeadWhileDriven {
        count: usize,
        longest_s: f64,
        share: f64,
        low_db: f64,
    },
    /// Clipping of a drive or a response behind a transfer function.
    #[error(
        "has {} of its samples at a limit{}",
        percent(*fraction),
        off_db.map_or_else(String::new, |off_db| {
            let side = if off_db < 0.0 { "low" } else { "high" };
            format!(": the transfer function is up to {:.1} dB too {side}", off_db.abs())
        })
    )]
    Clipped { fraction: f64, off_db: Option<f64> },
}

impl ChannelFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Dead => "check its cable and its range",
            Self::Frozen { .. } => "record again, or leave these parts out",
            Self::DropOuts { .. } => "check its cable and its range, and record again",
            Self::LinesAtRest { .. } => {
                "check shield and earth, switch off what vibrates, and record again"
            }
            Self::MainsHum { .. } => "check shield and earth, and record again",
            Self::Copied { .. } => "check the wiring and the names of the channels",
            Self::BeyondLimit { .. } => "check its unit and scale, or lower the level",
            Self::DeadWhileDriven { .. } => "record again",
            Self::Clipped { .. } => "lower the level, and record again",
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

/// The first four harmonics of a frequency, in Hz.
fn lines_of(mains_hz: f64, harmonics: &[usize]) -> String {
    let first = harmonics.iter().take(4);
    let lines: Vec<String> = first
        .map(|n| format!("{:.0}", mains_hz * *n as f64))
        .collect();
    let more = if harmonics.len() > 4 { ", …" } else { "" };
    lines.join(", ") + more
}

/// The first four of `lines_hz`.
fn frequencies(lines_hz: &[f64]) -> String {
    let lines: Vec<String> = lines_hz.iter().take(4).map(|hz| digits(*hz)).collect();
    let more = if lines_hz.len() > 4 { ", …" } else { "" };
    lines.join(", ") + more
}

/// A delay, where there is one.
fn delayed(delay_s: f64) -> String {
    match delay_s {
        0.0 => String::new(),
        later if later > 0.0 => format!(", {:.2} ms later", later * 1e3),
        earlier => format!(", {:.2} ms earlier", -earlier * 1e3),
    }
}
