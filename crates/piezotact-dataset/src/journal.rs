//! Our own recording format: Parquet, written through a journal so that a crash loses at most the last
//! second.
//!
//! While a recording runs, `NAME.part` grows beside its place: an Arrow IPC stream whose schema carries the
//! start document, with one batch for every chunk, on the disk before the next one is taken. When the
//! recording ends, the journal becomes `NAME`, a Parquet file with the start and the end document in its
//! metadata, written whole or not at all; then the journal goes. A journal without a Parquet file is a
//! recording that was interrupted, and is read as one.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Annotations, Condition, Provenance};
use serde::{Deserialize, Serialize};

use crate::atomic::{sync_folder, write_atomically};
use crate::error::WriteError;
use crate::sidecar::Rendering;

pub(crate) const START_KEY: &str = "piezotact.start";
pub(crate) const END_KEY: &str = "piezotact.end";
pub(crate) const UNIT_KEY: &str = "unit";

/// What is known before the first sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartDocument {
    /// The version of this format.
    #[serde(default)]
    pub format: u32,
    /// The rate in Hz.
    pub rate_hz: SampleRate,
    /// The channels' names and SI units, in their order.
    pub channels: Vec<(String, Unit)>,
    /// What is going on.
    #[serde(default)]
    pub condition: Condition,
    /// Where it comes from.
    #[serde(default)]
    pub provenance: Provenance,
    /// When it began, its labels, and the events that are planned.
    #[serde(flatten)]
    pub annotations: Annotations,
    /// The device that plays, when one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<DriveSetup>,
    /// How the drive that is played was made, when it was rendered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendering: Option<Rendering>,
}

impl StartDocument {
    /// The version that this program writes.
    pub const FORMAT: u32 = 1;
}

/// What is known after the last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndDocument {
    /// The number of samples of each channel.
    pub samples: usize,
    /// The samples' fingerprint: FNV-1a over the bits of each channel in turn, the channels' added up. Damage to
    /// the file shows in it.
    #[serde(default)]
    pub fingerprint: Option<u64>,
    /// The fingerprint of the start document as it is stored.
    #[serde(default)]
    pub start_fingerprint: Option<u64>,
    /// What came up while recording.
    #[serde(default)]
    pub doubts: Vec<Doubt>,
}

/// The fingerprint of a text: FNV-1a over its bytes.
pub(crate) fn fingerprint_of(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// A recording that is being written.
pub struct JournalWriter {
    path: PathBuf,
    journal: PathBuf,
    start: StartDocument,
    stream: StreamWriter<BufWriter<File>>,
    samples: usize,
    fingerprints: Vec<Fingerprint>,
}

/// The running fingerprint of one channel.
#[derive(Clone, Copy)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, samples: &[f64]) {
        for sample in samples {
            self.0 = (self.0 ^ sample.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// The fingerprint of a whole channel.
    pub(crate) fn of(samples: &[f64]) -> Self {
        let mut fingerprint = Self::new();
        fingerprint.add(samples);
        fingerprint
    }

    pub(crate) fn all(channels: &[Self]) -> u64 {
        channels.iter().fold(0, |sum, channel| {
            sum.wrapping_mul(31).wrapping_add(channel.0)
        })
    }
}

impl std::fmt::Debug for JournalWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JournalWriter")
            .field("path", &self.path)
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl JournalWriter {
    /// Begins the recording at `path`: the start document is on the disk when this returns.
    ///
    /// # Errors
    /// [`WriteError::Content`] when the journal of an interrupted recording stands there, which is never
    /// overwritten; [`WriteError::Io`] when the operating system refuses.
    pub fn create(path: &Path, start: StartDocument) -> Result<Self, WriteError> {
        let journal = journal_path(path);
        if path.is_dir() {
            return Err(WriteError::content(
                path,
                "the name of a file",
                "a folder",
                "give a file's name in it",
            ));
        }
        let file = File::options()
            .write(true)
            .create_new(true)
            .open(&journal)
            .map_err(|error| {
                if error.kind() == std::io::ErrorKind::AlreadyExists {
                    WriteError::content(
                        &journal,
                        "a free place for the recording",
                        "the journal of a recording that was interrupted or is still running",
                        "keep it (it can be read as it is) by moving it away, or remove it",
                    )
                } else {
                    WriteError::Io {
                        path: journal.clone(),
                        source: error,
                    }
                }
            })?;
        let schema = schema_of(&start).map_err(arrow_failed(&journal))?;
        let mut stream =
            StreamWriter::try_new(BufWriter::new(file), &schema).map_err(arrow_failed(&journal))?;
        to_disk(&mut stream, &journal)?;
        sync_folder(&journal);
        let fingerprints = vec![Fingerprint::new(); start.channels.len()];
        Ok(Self {
            path: path.into(),
            journal,
            start,
            stream,
            samples: 0,
            fingerprints,
        })
    }

    /// Appends one chunk, a list of samples for each channel; it is on the disk when this returns.
    ///
    /// # Errors
    /// [`WriteError::Content`] when the chunk has other channels than the start document says, or lists of
    /// different length; [`WriteError::Io`] when the operating system refuses.
    pub fn append(&mut self, chunk: &[Vec<f64>]) -> Result<(), WriteError> {
        let frames = chunk.first().map_or(0, Vec::len);
        if chunk.len() != self.start.channels.len()
            || chunk.iter().any(|channel| channel.len() != frames)
        {
            return Err(WriteError::content(
                &self.path,
                format!(
                    "{} channels of equal length in every chunk",
                    self.start.channels.len()
                ),
                format!("{}", chunk.len()),
                "this is a fault of the bench: report it",
            ));
        }
        let columns: Vec<ArrayRef> = chunk
            .iter()
            .map(|channel| Arc::new(Float64Array::from(channel.clone())) as ArrayRef)
            .collect();
        let batch = RecordBatch::try_new(
            schema_of(&self.start).map_err(arrow_failed(&self.journal))?,
            columns,
        )
        .map_err(arrow_failed(&self.journal))?;
        self.stream
            .write(&batch)
            .map_err(arrow_failed(&self.journal))?;
        to_disk(&mut self.stream, &self.journal)?;
        self.samples += frames;
        for (fingerprint, channel) in self.fingerprints.iter_mut().zip(chunk) {
            fingerprint.add(channel);
        }
        Ok(())
    }

    /// Ends the recording: the journal becomes the Parquet file with the end document in it. A recording that
    /// stood there before is kept beside it under a name of its own, which is returned; the same bytes are not
    /// kept twice.
    ///
    /// # Errors
    /// [`WriteError`] when the Parquet file cannot be written; the journal then stays and can be read.
    pub fn finish(
        mut self,
        provenance: Provenance,
        doubts: Vec<Doubt>,
    ) -> Result<Option<PathBuf>, WriteError> {
        // What was learned on the way, as the sensors' noise, joins what was known at the start.
        self.start.provenance = provenance;
        self.stream.finish().map_err(arrow_failed(&self.journal))?;
        to_disk(&mut self.stream, &self.journal)?;
        let fingerprint = Some(Fingerprint::all(&self.fingerprints));
        let end = EndDocument {
            samples: self.samples,
            fingerprint,
            start_fingerprint: None,
            doubts,
        };
        let batches = StreamReader::try_new(
            BufReader::new(File::open(&self.journal).map_err(WriteError::io(&self.journal))?),
            None,
        )
        .map_err(arrow_failed(&self.journal))?;
        let aside = side_path(&self.path);
        write_parquet(&aside, &self.start, &end, batches)?;
        let kept = keep_aside(&self.path, &aside)?;
        std::fs::rename(&aside, &self.path).map_err(WriteError::io(&self.path))?;
        // The recording is in its place on the disk before its journal goes.
        sync_folder(&self.path);
        std::fs::remove_file(&self.journal).map_err(WriteError::io(&self.journal))?;
        Ok(kept)
    }
}

/// Where a finished recording stands until the one before it is out of the way: `NAME.whole`.
fn side_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".whole");
    name.into()
}

/// Renames what stands at `path` to the first free `NAME.before-N`, unless it is the same as `new`.
fn keep_aside(path: &Path, new: &Path) -> Result<Option<PathBuf>, WriteError> {
    if !path.is_file() || same_bytes(path, new).unwrap_or(false) {
        return Ok(None);
    }
    let kept = (1..)
        .map(|number: u32| {
            let mut name = path.as_os_str().to_owned();
            name.push(format!(".before-{number}"));
            PathBuf::from(name)
        })
        .find(|candidate| !candidate.exists());
    if let Some(kept) = &kept {
        std::fs::rename(path, kept).map_err(WriteError::io(path))?;
    }
    Ok(kept)
}

fn same_bytes(a: &Path, b: &Path) -> std::io::Result<bool> {
    Ok(std::fs::metadata(a)?.len() == std::fs::metadata(b)?.len()
        && std::fs::read(a)? == std::fs::read(b)?)
}

fn to_disk(stream: &mut StreamWriter<BufWriter<File>>, journal: &Path) -> Result<(), WriteError> {
    stream.get_mut().flush().map_err(WriteError::io(journal))?;
    stream
        .get_ref()
        .get_ref()
        .sync_data()
        .map_err(WriteError::io(journal))
}

fn arrow_failed(path: &Path) -> impl FnOnce(ArrowError) -> WriteError + '_ {
    move |error| WriteError::Io {
        path: path.into(),
        source: std::io::Error::other(error),
    }
}

fn schema_of(start: &StartDocument) -> Result<SchemaRef, ArrowError> {
    let fields: Vec<Field> = start
        .channels
        .iter()
        .map(|(name, unit)| {
            Field::new(name, DataType::Float64, false).with_metadata(HashMap::from([(
                UNIT_KEY.to_owned(),
                unit.symbol().to_owned(),
            )]))
        })
        .collect();
    let text =
        serde_json::to_string(start).map_err(|error| ArrowError::JsonError(error.to_string()))?;
    Ok(Arc::new(Schema::new_with_metadata(
        fields,
        HashMap::from([(START_KEY.to_owned(), text)]),
    )))
}

fn write_parquet(
    path: &Path,
    start: &StartDocument,
    end: &EndDocument,
    batches: impl Iterator<Item = Result<RecordBatch, ArrowError>>,
) -> Result<(), WriteError> {
    let failed = |error: parquet::errors::ParquetError| WriteError::Io {
        path: path.into(),
        source: std::io::Error::other(error),
    };
    let json = |value: Result<String, serde_json::Error>| {
        value.map_err(|error| WriteError::Io {
            path: path.into(),
            source: error.into(),
        })
    };
    let start_text = json(serde_json::to_string(start))?;
    let end = EndDocument {
        start_fingerprint: Some(fingerprint_of(&start_text)),
        ..end.clone()
    };
    let end_text = json(serde_json::to_string(&end))?;
    write_atomically(path, |out| {
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_key_value_metadata(Some(vec![
                KeyValue::new(START_KEY.to_owned(), start_text),
                KeyValue::new(END_KEY.to_owned(), end_text),
            ]))
            .build();
        let schema = schema_of(start).map_err(arrow_failed(path))?;
        let mut writer =
            ArrowWriter::try_new(&mut *out, schema, Some(properties)).map_err(failed)?;
        for batch in batches {
            writer
                .write(&batch.map_err(arrow_failed(path))?)
                .map_err(failed)?;
        }
        writer.close().map(|_metadata| ()).map_err(failed)
    })
}

/// The journal of the recording at `path`: `NAME.part`.
#[must_use]
pub fn journal_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording_file::{read_journal, read_parquet};

    fn start() -> StartDocument {
        StartDocument {
            format: StartDocument::FORMAT,
            rate_hz: SampleRate::new(100.0).unwrap(),
            channels: vec![
                ("acc".into(), Unit::MetrePerSecondSquared),
                ("fz".into(), Unit::Newton),
            ],
            condition: Condition {
                participant: Some("P03".into()),
                ..Condition::default()
            },
            provenance: Provenance {
                source: "test".into(),
                ..Provenance::default()
            },
            annotations: serde_json::from_str(ANNOTATIONS).unwrap(),
            setup: None,
            rendering: None,
        }
    }

    const ANNOTATIONS: &str = r#"{"started_at": "2024-03-01T10:22:33Z", "labels": {"session": "2"},
        "events": [{"onset_s": 0.5, "duration_s": 0.25, "kind": "stimulus", "value": "S8"}]}"#;

    fn second(of: usize) -> Vec<Vec<f64>> {
        let acc: Vec<f64> = (0..100).map(|i| (of * 100 + i) as f64).collect();
        vec![acc.clone(), acc.iter().map(|v| -v).collect()]
    }

    #[test]
    fn a_recording_comes_back_as_it_went_in() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        for of in 0..3 {
            writer.append(&second(of)).unwrap();
        }
        let doubt = Doubt::LoadOffTarget {
            mean_n: 0.3,
            target_n: 0.2,
        };
        writer
            .finish(start().provenance, vec![doubt.clone()])
            .unwrap();
        assert!(!journal_path(&path).exists());
        let recording = read_parquet(&path, None).unwrap().recording;
        assert_eq!(recording.len(), 300);
        assert_eq!(recording.channels()[1].samples[299], -299.0);
        assert_eq!(recording.channels()[1].unit, Unit::Newton);
        assert_eq!(recording.condition.participant.as_deref(), Some("P03"));
        assert_eq!(recording.doubts, [doubt]);
        assert_eq!(recording.annotations, start().annotations);
    }

    /// "A session with a volunteer cannot be lost": not to the next one of the same name either.
    #[test]
    fn a_recording_of_the_same_name_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let record = |of| {
            let mut writer = JournalWriter::create(&path, start()).unwrap();
            writer.append(&second(of)).unwrap();
            writer.finish(start().provenance, vec![]).unwrap()
        };
        assert_eq!(record(0), None);
        assert_eq!(record(0), None, "the same again");
        let kept = record(1).unwrap();
        assert_eq!(
            read_parquet(&kept, None).unwrap().recording.channels()[0].samples[0],
            0.0
        );
        assert_eq!(
            read_parquet(&path, None).unwrap().recording.channels()[0].samples[0],
            100.0
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    /// Wherever a crash cuts the journal, every second that was on the disk before it is read.
    #[test]
    fn a_crash_loses_at_most_the_last_second() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        let mut on_disk = vec![(std::fs::metadata(journal_path(&path)).unwrap().len(), 0)];
        for of in 0..3 {
            writer.append(&second(of)).unwrap();
            on_disk.push((
                std::fs::metadata(journal_path(&path)).unwrap().len(),
                (of + 1) * 100,
            ));
        }
        drop(writer);
        let whole = std::fs::read(journal_path(&path)).unwrap();
        let cut = folder.path().join("cut.parquet.part");
        for length in (on_disk[0].0 as usize..=whole.len())
            .step_by(37)
            .chain([whole.len()])
        {
            std::fs::write(&cut, &whole[..length]).unwrap();
            let recording = read_journal(&cut).unwrap().recording;
            let safe = on_disk
                .iter()
                .filter(|(bytes, _)| *bytes as usize <= length)
                .map(|(_, n)| *n)
                .max();
            assert_eq!(recording.len(), safe.unwrap(), "cut at {length}");
            assert_eq!(recording.annotations, start().annotations);
            assert!(matches!(recording.doubts[..], [Doubt::Interrupted { .. }]));
        }
    }

    #[test]
    fn an_interrupted_recording_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        writer.append(&second(0)).unwrap();
        drop(writer);
        let refused = JournalWriter::create(&path, start())
            .unwrap_err()
            .to_string();
        assert!(refused.contains("interrupted"), "{refused}");
        assert_eq!(
            read_journal(&journal_path(&path)).unwrap().recording.len(),
            100
        );
    }

    #[test]
    fn a_damaged_file_is_a_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        writer.append(&second(0)).unwrap();
        writer.finish(start().provenance, vec![]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in (0..whole.len()).step_by(11) {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_parquet(&path, None).is_err(), "{length}");
        }
        for at in (0..whole.len()).step_by(5) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xFF;
            std::fs::write(&path, &bytes).unwrap();
            let _either = read_parquet(&path, None);
        }
    }
}
