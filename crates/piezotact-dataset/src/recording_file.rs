//! Reading of recordings: our Parquet files, and Parquet files of other programs.

mod blocks;

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
pub(crate) use blocks::ParquetBlocks;

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
    let later = later_recording(path);
    stored.recording.about.warnings.extend(later);
    Ok(stored)
}

/// The warning that the journal of a later recording lies beside this one.
fn later_recording(path: &Path) -> Option<Warning> {
    let journal = journal_path(path);
    journal.exists().then(|| {
        Warning::from(RecordingWarning::OtherOrigin {
            what: OtherOrigin::LaterRecording {
                file: journal.display().to_string(),
            },
        })
    })
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

/// What a Parquet file of ours says beside its samples.
struct Documents {
    start_text: Option<String>,
    start: StartDocument,
    end: Option<EndDocument>,
}

impl Documents {
    fn of(path: &Path, reader: &Reader) -> Result<Self, ReadError> {
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
        let end = end
            .map(|text| serde_json::from_str(&text))
            .transpose()
            .map_err(|error| unlike(&error))?;
        Ok(Self {
            start_text,
            start,
            end,
        })
    }

    fn require_channels(&self, path: &Path, found: usize) -> Result<(), ReadError> {
        if found == self.start.channels.len() {
            return Ok(());
        }
        Err(ReadError::content(
            path,
            format!(
                "{} channels, as its start document states",
                self.start.channels.len()
            ),
            format!("{found}"),
            "the file is damaged: copy it again",
        ))
    }

    /// Refuses samples that are not those that were stored with the documents; `fingerprint` of those that were read.
    fn require_own(
        &self,
        path: &Path,
        samples: usize,
        fingerprint: Option<u64>,
    ) -> Result<(), ReadError> {
        let Some(end) = &self.end else {
            return Ok(());
        };
        let stored = end.fingerprint.zip(fingerprint);
        let holds_all =
            end.samples == samples && stored.is_none_or(|(stored, found)| stored == found);
        if !holds_all || is_start_changed(self.start_text.as_deref(), end) {
            return Err(damaged(path, &"it does not hold what was recorded"));
        }
        Ok(())
    }

    /// `recording` of the length `read_s`, with what the end says; `rate` is the one that a person states.
    fn completed(&self, mut recording: Recording, read_s: f64, rate: Option<SampleRate>) -> Stored {
        let own = recording.rate();
        let warnings = &mut recording.about.warnings;
        if let Some(stated) = rate.filter(|rate| *rate != own) {
            warnings.push(Warning::from(RecordingWarning::StatedDiffers {
                what: Stated::RateKept {
                    stated_hz: stated.hz(),
                    found_hz: own.hz(),
                },
            }));
        }
        match &self.end {
            Some(end) => {
                warnings.extend(end.warnings.iter().cloned());
                let happened = end.events.iter().cloned();
                recording.annotations.events.extend(happened);
            }
            None => {
                recording.about.provenance.losses.is_interrupted = true;
                warnings.push(Warning::from(RecordingWarning::Interrupted { read_s }));
            }
        }
        Stored {
            recording,
            setup: self.start.setup.clone(),
            rendering: self.start.rendering.clone(),
            played: self.start.drive,
            samples: None,
        }
    }
}

fn read_with_documents(
    path: &Path,
    reader: &Reader,
    rate: Option<SampleRate>,
) -> Result<(Stored, StartDocument, Option<EndDocument>), ReadError> {
    let documents = Documents::of(path, reader)?;
    let samples = reader.numbers(path, documents.start.columns())?;
    documents.require_channels(path, samples.len())?;
    let fingerprints: Vec<Fingerprint> = samples
        .iter()
        .map(|channel| Fingerprint::of(channel))
        .collect();
    let recording = assemble(path, &documents.start, samples)?;
    let fingerprint = Some(Fingerprint::all(&fingerprints));
    documents.require_own(path, recording.len(), fingerprint)?;
    let read_s = recording.duration().0;
    let stored = documents.completed(recording, read_s, rate);
    Ok((stored, documents.start, documents.end))
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
    for (column, held) in columns.zip(reader.held(path, Columns::Whole)?) {
        let column = Column {
            values: held.values,
            ..column_of(column)
        };
        match held.moments {
            Some(start) => table.add_moments(column, start),
            None => table.columns.push(column),
        }
    }
    table.recording(path, options)
}

/// A column of this name and unit, which may stand in its name.
fn column_of((name, unit): (String, Option<String>)) -> Column {
    match unit {
        Some(_) => Column {
            name,
            unit,
            values: Vec::new(),
        },
        None => Column::from_header(&name),
    }
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
