//! Files as laboratories have them, read whole.

use std::path::Path;

use anyhow::{Context as _, Result};
use piezotact::recording::Channel;
use piezotact::statistics::{mean, rms};
use piezotact_dataset::eeg::read_eeg;
use piezotact_dataset::{ReadOptions, read_recording};

use super::Prepared;

/// The recording in the file `name`.
pub(super) fn recording(folder: &Path, name: &str) -> Result<Prepared> {
    let path = folder.join(name);
    let read = move || -> Result<Read> {
        let contents = read_recording(&path, &ReadOptions::default())?;
        Ok(figures(contents.recording.channels()))
    };
    prepared(read)
}

/// The EEG in the file `name`.
pub(super) fn eeg(folder: &Path, name: &str) -> Result<Prepared> {
    let path = folder.join(name);
    let read = move || -> Result<Read> {
        let file = read_eeg(&path)?;
        let first = file.segments.first().context("no segment")?;
        Ok(figures(first.recording.channels()))
    };
    prepared(read)
}

/// The bytes of the samples, and the mean and the root mean square of each channel.
struct Read {
    bytes: usize,
    figures: Vec<f64>,
}

fn figures(channels: &[Channel]) -> Read {
    let of = |channel: &Channel| [mean(&channel.samples), rms(&channel.samples)];
    Read {
        bytes: channels
            .iter()
            .map(|channel| 8 * channel.samples.len())
            .sum(),
        figures: channels.iter().flat_map(of).collect(),
    }
}

fn prepared(read: impl Fn() -> Result<Read> + 'static) -> Result<Prepared> {
    Ok(Prepared {
        input_bytes: read()?.bytes,
        work: Box::new(move || Ok(read()?.figures)),
    })
}
