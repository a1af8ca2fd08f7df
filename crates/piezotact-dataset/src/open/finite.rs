//! Samples that are none.

use std::path::Path;

use piezotact::quantity::SampleRate;
use piezotact::recording::Channel;
use piezotact::series::is_sample;

use super::Contents;
use crate::error::ReadError;

/// Refuses a recording with a sample that is NaN or infinite, or without samples.
pub(super) fn finite(path: &Path, contents: Contents) -> Result<Contents, ReadError> {
    if contents.recording.is_empty() {
        return Err(ReadError::content(
            path,
            "samples",
            "none",
            "it was stopped during its first second: record again",
        ));
    }
    let mut channels = contents.recording.channels_with_clocks();
    let bad = channels.find_map(|(channel, of)| not_a_sample(path, channel, of.rate_hz, 0));
    drop(channels);
    bad.map_or(Ok(contents), Err)
}

/// The error about the first sample of `channel` that is NaN or infinite, where one is; the first sample of all has this number.
pub(super) fn not_a_sample(
    path: &Path,
    channel: &Channel,
    rate: SampleRate,
    first: usize,
) -> Option<ReadError> {
    let at = channel.samples.iter().position(|v| !is_sample(*v))?;
    Some(ReadError::content(
        path,
        "samples within ±1e100",
        format!(
            "{} at sample {} ({:.3}) of `{}`",
            channel.samples[at],
            first + at,
            rate.duration_of(first + at),
            channel.name
        ),
        "cut that part or repair the export",
    ))
}
