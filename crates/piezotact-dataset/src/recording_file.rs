//! Reading of recordings: our Parquet files, and Parquet files of other programs.

use piezotact::checksum::Checksum;
use std::path::Path;

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{
    About, Annotations, Channel, OtherOrigin, Provenance, Recording, RecordingWarning, Stated,
};

use crate::error::ReadError;
use crate::journal::{
    END_KEY, EndDocument, Fingerprint, START_KEY, StartDocument, UNIT_KEY, fingerprint_of,
    journal_path,
};
use crate::parquet_file::{Reader, damaged};
use crate::sidecar::Rendering;
use crate::wav::SampleFormat;

/// A recording and what its start says of the drive.
pub(crate) struct Stored {
    pub(crate) recording: Recording,
    pub(crate) setup: Option<DriveSetup>,
    pub(crate) rendering: Option<Rendering>,
    /// The checksum of the drive that was played.
    pub(crate) played: Option<Checksum>,
    /// How a file of samples alone stores them.
    pub(crate) samples: Option<SampleFormat>,
}

impl From<Recording> for Stored {
    fn from(recording: Recording) -> Self {
        Self {
            recording,
            setup: None,
            rendering: None,
            played: None,
            samples: None,
        }
    }
}

/// Reads a Parquet file: ours, or any other with one numeric column a channel when the rate is given.
pub(crate) fn read_parquet(path: &Path, rate: Option<SampleRate>) -> Result<Stored, ReadError> {
    let (mut stored, start, _) = read_with_documents(path, rate)?;
    if start.format > 0 && journal_path(path).exists() {
        stored
            .recording
            .about
            .warnings
            .push(Warning::from(RecordingWarning::OtherOrigin {
                what: OtherOrigin::LaterRecording {
                    file: journal_path(path).display().to_string(),
                },
            }));
    }
    Ok(stored)
}

/// The recording in `path`, a journal (`.part`) or a Parquet file that this program wrote, as it was stored: nothing is inspected.
///
/// # Errors
/// [`ReadError`] naming the file.
pub fn recording_of_ours(path: &Path) -> Result<Recording, ReadError> {
    let is_journal = path.extension().is_some_and(|ending| ending == "part");
    let stored = match is_journal {
        true => crate::journal::read_run_journal(path)?,
        false => read_parquet(path, None)?,
    };
    Ok(stored.recording)
}

/// Reads a Parquet file of ours with its documents.
pub(crate) fn read_parquet_whole(
    path: &Path,
) -> Result<(Stored, StartDocument, Option<EndDocument>), ReadError> {
    read_with_documents(path, None)
}

fn read_with_documents(
    path: &Path,
    rate: Option<SampleRate>,
) -> Result<(Stored, StartDocument, Option<EndDocument>), ReadError> {
    let unlike = |error: &serde_json::Error| {
        ReadError::content(
            path,
            "a description of the recording as this version writes it",
            format!("another ({error})"),
            "record or make it again with this version; where this version made it, it is damaged: copy it again",
        )
    };
    let file = crate::input::open_input(path)?;
    let reader = Reader::new(file).map_err(|error| damaged(path, &error))?;
    let (start, end) = (reader.stored(START_KEY), reader.stored(END_KEY));
    let start_text = start.clone();
    let start = match start {
        Some(text) => serde_json::from_str(&text).map_err(|error| unlike(&error))?,
        None => foreign_start(path, &reader, rate)?,
    };
    let ours = start.format > 0;
    if start.format > StartDocument::FORMAT_WITH_CLOCKS {
        return Err(ReadError::content(
            path,
            format!(
                "a recording of format {} or before",
                StartDocument::FORMAT_WITH_CLOCKS
            ),
            format!("format {}", start.format),
            "read it with the newer program that wrote it",
        ));
    }
    let end: Option<EndDocument> = end
        .map(|text| serde_json::from_str(&text))
        .transpose()
        .map_err(|error| unlike(&error))?;
    let samples = reader.numbers(path, start.columns())?;
    if samples.len() != start.channels.len() {
        return Err(ReadError::content(
            path,
            format!(
                "{} channels, as its start document states",
                start.channels.len()
            ),
            format!("{}", samples.len()),
            "the file is damaged: copy it again",
        ));
    }
    let fingerprints: Vec<Fingerprint> = samples
        .iter()
        .map(|channel| Fingerprint::of(channel))
        .collect();
    let fingerprint = Fingerprint::all(&fingerprints);
    let mut recording = assemble(path, &start, samples)?;
    if let Some(stated) = rate.filter(|rate| ours && *rate != recording.rate()) {
        recording
            .about
            .warnings
            .push(Warning::from(RecordingWarning::StatedDiffers {
                what: Stated::RateKept {
                    stated_hz: stated.hz(),
                    found_hz: recording.rate().hz(),
                },
            }));
    }
    match &end {
        Some(end) => {
            let holds_all = end.samples == recording.len()
                && end.fingerprint.is_none_or(|stored| stored == fingerprint);
            if !holds_all || is_start_changed(start_text.as_deref(), end) {
                return Err(damaged(path, &"it does not hold what was recorded"));
            }
            recording
                .about
                .warnings
                .extend(end.warnings.iter().cloned());
            let happened = end.events.iter().cloned();
            recording.annotations.events.extend(happened);
        }
        None if ours => {
            recording.about.provenance.losses.is_interrupted = true;
            recording
                .about
                .warnings
                .push(Warning::from(RecordingWarning::Interrupted {
                    read_s: recording.duration().0,
                }))
        }
        None => {}
    }
    let stored = Stored {
        recording,
        setup: start.setup.clone(),
        rendering: start.rendering.clone(),
        played: start.drive,
        samples: None,
    };
    Ok((stored, start, end))
}

/// Whether a start document is not the one that was stored with the samples.
fn is_start_changed(start: Option<&str>, end: &EndDocument) -> bool {
    match (start, end.start_fingerprint) {
        (Some(text), Some(stored)) => fingerprint_of(text) != stored,
        _ => false,
    }
}

/// The metadata of a Parquet file of another program.
fn foreign_start(
    path: &Path,
    reader: &Reader,
    rate: Option<SampleRate>,
) -> Result<StartDocument, ReadError> {
    let rate_hz = rate.ok_or_else(|| {
        ReadError::content(
            path,
            "a recording of this program, or a rate",
            "a Parquet file of another program, which names no rate",
            "give the rate with --rate",
        )
    })?;
    let columns = reader.columns_with(UNIT_KEY).into_iter();
    let channels = columns.map(|(name, unit)| {
        let unit = Unit::parse(unit.as_deref().unwrap_or_default());
        (name, unit)
    });
    let (channels, factors): (Vec<_>, Vec<f64>) = channels
        .map(|(name, (unit, factor)): (String, (Unit, f64))| ((name, unit), factor))
        .unzip();
    if let Some((name, _)) = channels
        .iter()
        .zip(&factors)
        .find(|(_, factor)| **factor != 1.0)
        .map(|(channel, _)| channel)
    {
        return Err(ReadError::content(
            path,
            "SI units in the columns' metadata",
            format!("another in `{name}`"),
            "convert that column to m/s², N or V before writing the file",
        ));
    }
    Ok(StartDocument {
        format: 0,
        rate_hz,
        channels,
        about: About {
            provenance: Provenance {
                source: path.display().to_string(),
                ..Provenance::default()
            },
            ..About::default()
        },
        annotations: Annotations::default(),
        clocks: Vec::new(),
        setup: None,
        rendering: None,
        label: None,
        drive: None,
    })
}

pub(crate) fn assemble(
    path: &Path,
    start: &StartDocument,
    samples: Vec<Vec<f64>>,
) -> Result<Recording, ReadError> {
    let channels = start
        .channels
        .iter()
        .zip(samples)
        .map(|((name, unit), samples)| Channel {
            name: name.clone(),
            unit: unit.clone(),
            samples,
        })
        .collect();
    let about = start.about.clone();
    let mut recording = Recording::on_clocks(channels, start.rate_hz, &start.clocks, about)
        .map_err(ReadError::of(path))?;
    recording.annotations = start.annotations.clone();
    Ok(recording)
}
