//! Conformance tests of steps out of order.

use super::{DURATION, Make, Playing, Subject, begin, expect, playback, take, until};
use crate::error::DeviceError;
use crate::plan::Until;

/// Refused as out of order.
fn refused<T>(outcome: Result<T, DeviceError>, what: &str) -> Result<(), String> {
    match outcome {
        Err(DeviceError::Order { .. }) => Ok(()),
        Err(other) => Err(format!(
            "expected {what} to be refused as out of order, found: {other}"
        )),
        Ok(_) => Err(format!(
            "expected {what} to be refused as out of order, found nothing said"
        )),
    }
}

pub(super) fn acquiring(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let run = until(subject, Until::Duration(DURATION));
    refused(
        bench.acquirer.next_chunk(),
        "a chunk before the input is ready",
    )?;
    refused(bench.acquirer.start(), "a start before the input is ready")?;
    bench
        .acquirer
        .ready(&run, &bench.stop)
        .map_err(|error| error.to_string())?;
    refused(bench.acquirer.next_chunk(), "a chunk before the start")?;
    begin(&mut bench, playback(subject), &run)?;
    let taken = take(&mut bench, Playing::of(subject.drive.as_ref()), |taken| {
        !taken.chunks.is_empty()
    })?;
    expect(!taken.chunks.is_empty(), "a chunk", "none")?;
    bench.player.stop();
    bench.acquirer.stop();
    refused(bench.acquirer.next_chunk(), "a chunk after the stop")?;
    refused(
        bench.acquirer.start(),
        "another start without being made ready",
    )
}

pub(super) fn playing(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let run = until(subject, Until::Duration(DURATION));
    refused(bench.player.progress(), "progress before the start")?;
    refused(bench.player.start(), "a start before the output is ready")?;
    begin(&mut bench, playback(subject), &run)?;
    refused(
        bench.player.start(),
        "another start without being made ready",
    )?;
    bench.player.stop();
    bench.acquirer.stop();
    refused(bench.player.start(), "a start after the stop")
}
