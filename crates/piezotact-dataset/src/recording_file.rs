//! Reading of recordings: our Parquet files, and Parquet files of other programs.

use piezotact::checksum::Checksum;
use std::path::Path;

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::quantity::SampleRate;
use piezotact::recording::{Channel, OtherOrigin, Recording, RecordingWarning, Stated};

use crate::columns::{Column, Table};
use crate::error::ReadError;
use crate::journal::{
    END_KEY, EndDocument, Fingerprint, START_KEY, StartDocument, UNIT_KEY, fingerprint_of,
    journal_path,
};
use crate::open::ReadOptions;
use crate::parquet_file::{Columns, Reader, damaged};
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

/// Reads a Parquet file: ours, or the table of another program.
pub(crate) fn read_parquet(path: &Path, options: &ReadOptions) -> Result<Stored, ReadError> {
    let reader = opened(path)?;
    if reader.stored(START_KEY).is_none() {
        return Ok(table_in(path, &reader, options)?.into());
    }
    let (mut stored, _, _) = read_with_documents(path, &reader, options.rate)?;
    if journal_path(path).exists() {
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
        false => read_parquet(path, &ReadOptions::default())?,
    };
    Ok(stored.recording)
}

/// Reads a Parquet file of ours with its documents.
pub(crate) fn read_parquet_whole(
    path: &Path,
) -> Result<(Stored, StartDocument, Option<EndDocument>), ReadError> {
    read_with_documents(path, &opened(path)?, None)
}

fn opened(path: &Path) -> Result<Reader, ReadError> {
    let file = crate::input::open_input(path)?;
    Reader::new(file).map_err(|error| damaged(path, &error))
}

fn read_with_documents(
    path: &Path,
    reader: &Reader,
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
    let (start_text, end) = (reader.stored(START_KEY), reader.stored(END_KEY));
    let start: StartDocument = serde_json::from_str(start_text.as_deref().unwrap_or_default())
        .map_err(|error| unlike(&error))?;
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
    if let Some(stated) = rate.filter(|rate| *rate != recording.rate()) {
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
        None => {
            recording.about.provenance.losses.is_interrupted = true;
            recording
                .about
                .warnings
                .push(Warning::from(RecordingWarning::Interrupted {
                    read_s: recording.duration().0,
                }))
        }
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

/// Whether another program wrote the Parquet file at `path`.
pub(crate) fn of_another(path: &Path) -> Result<bool, ReadError> {
    Ok(opened(path)?.stored(START_KEY).is_none())
}

/// The table of another program. Units stand in the metadata of a column, or in its name.
fn table_in(path: &Path, reader: &Reader, options: &ReadOptions) -> Result<Recording, ReadError> {
    let mut table = Table::default();
    let columns = reader.columns_with(UNIT_KEY).into_iter();
    for ((name, unit), held) in columns.zip(reader.held(path, Columns::Whole)?) {
        let column = Column {
            values: held.values,
            ..match unit {
                Some(_) => Column {
                    name,
                    unit,
                    values: Vec::new(),
                },
                None => Column::from_header(&name),
            }
        };
        match held.moments {
            Some(start) => table.add_moments(column, start),
            None => table.columns.push(column),
        }
    }
    table.recording(path, options)
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
