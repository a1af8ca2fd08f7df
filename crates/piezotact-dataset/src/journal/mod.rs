//! Our own recording format: Parquet, written through a journal so that a crash loses at most the last
//! second.
//!
//! While a recording runs, `NAME.part` grows beside its place: the documents of the run as blocks with a checksum each, on
//! the disk before the next one is taken. When the recording ends, the journal becomes `NAME`, a Parquet file with the start and the
//! end document in its metadata, written whole or not at all; then the journal goes. A journal without a Parquet file is a
//! recording that was interrupted, and is read as one.

mod frames;
mod read;
mod sink;
mod writer;

use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::checksum::Checksum;
use piezotact::device::DriveSetup;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{About, Annotations, Clock, Event, Recording};
use piezotact::run::{Ended, RunStart};
use serde::{Deserialize, Serialize};

use crate::atomic::write_atomically;
use crate::error::WriteError;
use crate::parquet_file::{Columns, Writer};
use crate::sidecar::Rendering;

pub(crate) use read::{is_journal, read_run_journal};
pub use sink::{JournalSink, RunFolder};
pub use writer::{JournalWriter, keep_before, set_aside_path};

pub(crate) const START_KEY: &str = "piezotact.start";
pub(crate) const END_KEY: &str = "piezotact.end";
pub(crate) const UNIT_KEY: &str = "unit";

/// What is known before the first sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartDocument {
    /// The version of this format.
    pub format: u32,
    /// The rate in Hz.
    pub rate_hz: SampleRate,
    /// The channels' names and SI units, in their order.
    pub channels: Vec<(String, Unit)>,
    /// What is going on, and where it comes from; what gives a warning stands in the end document.
    #[serde(flatten, serialize_with = "About::without_empty_warnings")]
    pub about: About,
    /// When it began, its labels, and the events that are planned.
    #[serde(flatten)]
    pub annotations: Annotations,
    /// The clock of each channel; none where all run at [`Self::rate_hz`] from the first sample on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<Clock>,
    /// The device that plays, when one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<DriveSetup>,
    /// How the drive that is played was made, when it was rendered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendering: Option<Rendering>,
    /// What the run is for; absent where no run was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// The checksum of the drive that is played.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Checksum>,
}

impl StartDocument {
    /// The version that this program writes where all channels share a clock.
    pub const FORMAT: u32 = 1;
    /// The version that it writes where they do not: columns differ in length, and are filled up with nulls.
    pub const FORMAT_WITH_CLOCKS: u32 = 2;

    /// How the columns of its Parquet file are filled.
    pub(crate) fn columns(&self) -> Columns {
        if self.clocks.is_empty() {
            Columns::Whole
        } else {
            Columns::FilledUp
        }
    }

    /// What is kept of the start of a run.
    #[must_use]
    pub fn of(start: &RunStart, rendering: Option<Rendering>) -> Self {
        Self {
            format: match start.clocks.as_slice() {
                [] => Self::FORMAT,
                _ => Self::FORMAT_WITH_CLOCKS,
            },
            rate_hz: start.rate_hz,
            channels: start.channels.clone(),
            about: start.about.clone(),
            setup: start.setup.clone(),
            annotations: start.annotations.clone(),
            clocks: start.clocks.clone(),
            rendering,
            label: Some(start.label.clone()),
            drive: start.drive,
        }
    }
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
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
    /// What happened while it ran.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// How the run ended; absent where no run was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<Ended>,
}

/// The fingerprint of a text: FNV-1a over its bytes.
pub(crate) fn fingerprint_of(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// The running fingerprint of one channel.
#[derive(Clone, Copy)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) fn add(&mut self, samples: &[f64]) {
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

fn write_parquet(
    path: &Path,
    start: &StartDocument,
    end: &EndDocument,
    chunks: impl Iterator<Item = std::io::Result<Vec<Vec<f64>>>>,
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
        let names = start.channels.iter().map(|(name, _)| name.as_str());
        let columns = start.columns();
        let texts = [(START_KEY, start_text), (END_KEY, end_text)];
        let mut writer = Writer::new(&mut *out, names, columns, texts).map_err(failed)?;
        for chunk in chunks {
            let chunk = chunk.map_err(WriteError::io(path))?;
            writer.append(chunk).map_err(failed)?;
        }
        writer.finish().map_err(failed)
    })
}

/// Writes `recording` to `path` as a Parquet file, whole or not at all.
///
/// # Errors
/// [`WriteError::Io`] where the operating system refuses.
pub fn write_recording(path: &Path, recording: &Recording) -> Result<(), WriteError> {
    write_measurement(path, recording, None, None)
}

/// As [`write_recording`], with the device that played and how the drive was made, where they are known.
///
/// # Errors
/// Those of [`write_recording`].
pub fn write_measurement(
    path: &Path,
    recording: &Recording,
    setup: Option<&DriveSetup>,
    rendering: Option<&Rendering>,
) -> Result<(), WriteError> {
    let clocks = recording.stated_clocks();
    let channels = recording.channels();
    let start = StartDocument {
        format: match clocks.as_slice() {
            [] => StartDocument::FORMAT,
            _ => StartDocument::FORMAT_WITH_CLOCKS,
        },
        rate_hz: recording.rate(),
        channels: channels
            .iter()
            .map(|channel| (channel.name.clone(), channel.unit.clone()))
            .collect(),
        about: recording.about.clone(),
        annotations: recording.annotations.clone(),
        clocks,
        setup: setup.cloned(),
        rendering: rendering.cloned(),
        label: None,
        drive: None,
    };
    let fingerprints: Vec<Fingerprint> = channels
        .iter()
        .map(|channel| Fingerprint::of(&channel.samples))
        .collect();
    let end = EndDocument {
        samples: recording.len(),
        fingerprint: Some(Fingerprint::all(&fingerprints)),
        start_fingerprint: None,
        warnings: Vec::new(),
        events: Vec::new(),
        ended: None,
    };
    let samples = channels.iter().map(|channel| channel.samples.clone());
    let whole = std::iter::once(Ok(samples.collect()));
    write_parquet(path, &start, &end, whole)
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
    use super::read::read_run_journal as read_journal;
    use super::*;
    use crate::open::ReadOptions;
    use crate::recording_file::read_parquet;
    use piezotact::recording::Reached;
    use piezotact::recording::{Condition, Provenance, RecordingWarning};

    fn start() -> StartDocument {
        StartDocument {
            format: StartDocument::FORMAT,
            rate_hz: SampleRate::new(100.0).unwrap(),
            channels: vec![
                ("acc".into(), Unit::MetrePerSecondSquared),
                ("fz".into(), Unit::Newton),
            ],
            about: About::new(
                Condition {
                    participant: Some("P03".into()),
                    ..Condition::default()
                },
                Provenance {
                    source: "test".into(),
                    ..Provenance::default()
                },
            ),
            annotations: serde_json::from_str(ANNOTATIONS).unwrap(),
            clocks: Vec::new(),
            setup: None,
            rendering: None,
            label: None,
            drive: None,
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
        let warning = Warning::from(RecordingWarning::ConditionDiffers {
            what: Reached::Load {
                mean_n: 0.3,
                target_n: 0.2,
            },
        });
        let mut provenance = start().about.provenance;
        provenance.losses.samples = 25;
        provenance.losses.stretches_s = vec![[0.5, 0.75]];
        writer
            .finish(provenance.clone(), vec![warning.clone()])
            .unwrap();
        assert!(!journal_path(&path).exists());
        let recording = read_parquet(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        assert_eq!(recording.len(), 300);
        assert_eq!(recording.channels()[1].samples[299], -299.0);
        assert_eq!(recording.channels()[1].unit, Unit::Newton);
        assert_eq!(
            recording.about.condition.participant.as_deref(),
            Some("P03")
        );
        assert_eq!(recording.about.warnings, [warning]);
        assert_eq!(recording.about.provenance.losses, provenance.losses);
        assert_eq!(recording.annotations, start().annotations);
    }

    /// Two clocks: what each channel holds, and when, comes back from the Parquet file and from the journal of a run that was
    /// killed, and with them the events of the run.
    #[test]
    fn channels_of_two_clocks_come_back_with_their_events() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let clock = |hz: f64, start_s: f64| Clock {
            rate_hz: SampleRate::new(hz).unwrap(),
            start_s: piezotact::quantity::Seconds(start_s),
        };
        let clocks = vec![clock(100.0, 0.0), clock(10.0, 0.25)];
        let start = StartDocument {
            format: StartDocument::FORMAT_WITH_CLOCKS,
            clocks: clocks.clone(),
            ..start()
        };
        let mut writer = JournalWriter::create(&path, start.clone()).unwrap();
        let lost: Event = serde_json::from_str(
            r#"{"onset_s": 1.5, "duration_s": 0.5, "kind": "samples_lost", "value": 50.0}"#,
        )
        .unwrap();
        for of in 0..3 {
            for (clock, rate) in [(0, 100), (1, 10)] {
                let samples = (0..rate).map(|k| f64::from(of * rate + k)).collect();
                let chunk = piezotact::run::RunChunk {
                    first: (of * rate) as u64,
                    clock,
                    channels: vec![samples],
                    ..Default::default()
                };
                writer.append_chunk(&chunk).unwrap();
            }
            if of == 1 {
                writer.append_event(&lost).unwrap();
            }
        }
        let expected: Vec<Event> = [start.annotations.events.clone(), vec![lost]].concat();
        let check = |recording: &Recording| {
            assert_eq!(recording.stated_clocks(), clocks);
            let counts = recording.channels().iter().map(|c| c.samples.len());
            assert_eq!(counts.collect::<Vec<_>>(), [300, 30]);
            assert_eq!(recording.channels()[1].samples[29], 29.0);
            assert!((recording.duration().0 - 3.25).abs() < 1e-12);
            assert_eq!(recording.annotations.events, expected);
            assert_eq!(recording.annotations.labels, start.annotations.labels);
        };
        let killed = folder.path().join("killed.parquet.part");
        std::fs::copy(journal_path(&path), &killed).unwrap();
        check(&read_journal(&killed).unwrap().recording);
        let provenance = start.about.provenance.clone();
        writer.finish(provenance, vec![]).unwrap();
        check(
            &read_parquet(&path, &ReadOptions::default())
                .unwrap()
                .recording,
        );

        // A chunk with the channels of another clock is none of this recording.
        let mut writer = JournalWriter::create(&path, start.clone()).unwrap();
        assert!(writer.append(&second(0)).is_err());
    }

    /// "A session with a volunteer cannot be lost": not to the next one of the same name either.
    #[test]
    fn a_recording_of_the_same_name_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let record = |of| {
            let mut writer = JournalWriter::create(&path, start()).unwrap();
            writer.append(&second(of)).unwrap();
            writer.finish(start().about.provenance, vec![]).unwrap()
        };
        assert_eq!(record(0), None);
        assert_eq!(record(0), None, "the same again");
        let kept = record(1).unwrap();
        assert_eq!(
            read_parquet(&kept, &ReadOptions::default())
                .unwrap()
                .recording
                .channels()[0]
                .samples[0],
            0.0
        );
        assert_eq!(
            read_parquet(&path, &ReadOptions::default())
                .unwrap()
                .recording
                .channels()[0]
                .samples[0],
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
            assert!(
                matches!(&recording.about.warnings[..], [warning] if matches!(warning.kind(), Some(RecordingWarning::Interrupted { .. })))
            );
            assert!(recording.about.provenance.losses.is_interrupted);
        }
    }

    #[test]
    fn an_interrupted_recording_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut running = JournalWriter::create(&path, start()).unwrap();
        running.append(&second(0)).unwrap();
        let refused = JournalWriter::create(&path, start());
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("still running"), "{said}");
        drop(running);
        // It was interrupted: its journal is kept beside the next recording of that name.
        let mut next = JournalWriter::create(&path, start()).unwrap();
        let aside = next.set_aside()[0].clone();
        next.append(&second(1)).unwrap();
        next.finish(start().about.provenance, vec![]).unwrap();
        assert!(aside.ends_with("r.parquet.interrupted-1.part"));
        let samples = |recording: &Recording| recording.channels()[0].samples.clone();
        assert_eq!(samples(&read_journal(&aside).unwrap().recording)[0], 0.0);
        let finished = read_parquet(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        assert_eq!(samples(&finished)[0], 100.0);
    }

    /// Of one damaged byte the reader says what was lost, and everything else keeps its place in time.
    #[test]
    fn a_flipped_byte_is_named_with_what_was_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        let mut ends = vec![std::fs::metadata(journal_path(&path)).unwrap().len()];
        for of in 0..3 {
            writer.append(&second(of)).unwrap();
            ends.push(std::fs::metadata(journal_path(&path)).unwrap().len());
        }
        drop(writer);
        let whole = std::fs::read(journal_path(&path)).unwrap();
        let damaged = folder.path().join("d.parquet.part");
        for at in (0..whole.len()).step_by(97) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            std::fs::write(&damaged, &bytes).unwrap();
            let recording = read_journal(&damaged).unwrap().recording;
            let said: Vec<String> = recording
                .about
                .warnings
                .iter()
                .map(ToString::to_string)
                .collect();
            let said = said.join("\n");
            let block = (1..=3).find(|k| (at as u64) >= ends[k - 1] && (at as u64) < ends[*k]);
            let samples = &recording.channels()[0].samples;
            match block {
                None => assert_eq!(samples.len(), 300, "byte {at}: {said}"),
                Some(3) => assert_eq!(samples.len(), 200, "byte {at}: {said}"),
                Some(block) => {
                    let lost = format!("{}.00–{}.00 s", block - 1, block);
                    assert!(said.contains(&lost), "byte {at}: {said}");
                    assert_eq!((samples.len(), samples[299]), (300, 299.0), "byte {at}");
                }
            }
        }
    }

    /// Ended while it was finished, a recording leaves half copies, which the next one removes; what is the only copy stays.
    #[test]
    fn what_a_second_interrupt_leaves_is_cleaned_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let begun = || JournalWriter::create(&path, start()).unwrap();
        let mut first = begun();
        first.append(&second(0)).unwrap();
        assert_eq!((first.removed(), first.set_aside().len()), (0, 0));
        drop(first);
        let side = folder.path().join("r.parquet.whole");
        let half = folder
            .path()
            .join(".piezotact-unfinished-r.parquet.whole-a1.tmp");
        std::fs::write(&side, "half").unwrap();
        std::fs::write(&half, "half").unwrap();
        let mut next = begun();
        next.append(&second(1)).unwrap();
        assert_eq!(next.removed(), 2);
        assert!(next.set_aside()[0].ends_with("r.parquet.interrupted-1.part"));
        assert!(!side.exists() && !half.exists());
        next.finish(start().about.provenance, vec![]).unwrap();
        // The journal is gone: what was whole is the only copy.
        std::fs::rename(&path, &side).unwrap();
        let last = begun();
        assert!(last.set_aside()[0].ends_with("r.parquet.interrupted-1.parquet"));
        assert_eq!(last.removed(), 0);
        assert!(read_parquet(&last.set_aside()[0], &ReadOptions::default()).is_ok());
    }

    /// A newer format is named as that; where all of it reads as today's, its header alone is wrong.
    #[test]
    fn a_journal_of_another_format_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        for of in 0..2 {
            writer.append(&second(of)).unwrap();
        }
        drop(writer);
        let whole = std::fs::read(journal_path(&path)).unwrap();
        let changed = folder.path().join("c.parquet.part");
        let read = |bytes: &[u8]| {
            std::fs::write(&changed, bytes).unwrap();
            let options = ReadOptions::default();
            crate::read_recording(&changed, &options).map_err(|error| error.to_string())
        };
        let mut header = whole.clone();
        header[5] = 2;
        let recording = read(&header).unwrap().recording;
        assert_eq!(recording.len(), 200);
        let said = recording.about.warnings[0].to_string();
        assert!(
            said.contains("format 2, but this version reads up to 1"),
            "{said}"
        );
        // Other blocks, all of them or one.
        let newer: Vec<u8> = header[..8].iter().copied().chain(*b"otherwise").collect();
        let mut one = header.clone();
        one[whole.len() / 2] ^= 1;
        for bytes in [newer, one] {
            let said = read(&bytes).unwrap_err();
            assert!(
                said.contains("format 1 or before") && said.contains("found format 2"),
                "{said}"
            );
        }
        let mut damaged = whole.clone();
        damaged[1] = b'?';
        let said = read(&damaged).unwrap().recording.about.warnings[0].to_string();
        assert!(said.contains("damaged at 1 place: no samples"), "{said}");
    }

    #[test]
    fn a_damaged_file_is_a_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let mut writer = JournalWriter::create(&path, start()).unwrap();
        writer.append(&second(0)).unwrap();
        writer.finish(start().about.provenance, vec![]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in (0..whole.len()).step_by(11) {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(
                read_parquet(&path, &ReadOptions::default()).is_err(),
                "{length}"
            );
        }
        for at in (0..whole.len()).step_by(5) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xFF;
            std::fs::write(&path, &bytes).unwrap();
            let _either = read_parquet(&path, &ReadOptions::default());
        }
    }
}
