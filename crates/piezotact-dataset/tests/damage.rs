//! Recordings of every kind, cut and damaged, through the one door: values that were there or an error that says what to do, and no panic.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use piezotact::quantity::SampleRate;
use piezotact::recording::Recording;
use piezotact_dataset::{ReadError, ReadOptions, read_recording};

use crate::shared_data;
use crate::support::Lcg;

/// A file that is read whole, with what is stated of it.
struct Kind {
    name: String,
    bytes: Vec<u8>,
    options: ReadOptions,
}

impl Kind {
    fn of(name: &str, bytes: Vec<u8>) -> Self {
        Self {
            name: name.into(),
            bytes,
            options: ReadOptions::default(),
        }
    }

    fn golden(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
        let bytes = std::fs::read(path.join(name)).unwrap();
        Self::of(name.rsplit('/').next().unwrap(), bytes)
    }

    fn shared(name: &str) -> Option<Self> {
        let path = shared_data::shared(&format!("data/daq/{name}"))?;
        let bytes = std::fs::read(&path).unwrap();
        Some(Self::of(name.rsplit('/').next().unwrap(), bytes))
    }

    fn at(mut self, rate_hz: f64) -> Self {
        self.options.rate = Some(SampleRate::new(rate_hz).unwrap());
        self
    }
}

/// A file of each reader; those of catman and of NI's programs lie beside the checkout.
fn kinds() -> Vec<Kind> {
    let mut kinds = vec![
        Kind::golden("daqmx.tdms").at(1000.0),
        Kind::golden("scales.tdms").at(1000.0),
        Kind::golden("scipy7.mat").at(1000.0),
        Kind::golden("npy/one.npy").at(1000.0),
        Kind::golden("npy/timed.npz"),
        Kind::golden("tables/zstd.parquet"),
        Kind::golden("tables/moments.parquet"),
        Kind::of("a.flac", crate::flac::small()),
        Kind::of("dewesoft.txt", dewesoft().into_bytes()),
        Kind::of("a.csv", table().into_bytes()),
        Kind::of("a.wav", wav()),
        Kind::of("a.lvm", crate::lvm::small().into_bytes()),
        Kind::of("a.uff", crate::uff_clocks::small()),
    ];
    kinds.extend(Kind::shared("catman/4byteJob1_2022_04_12_13_31_47.bin"));
    kinds.extend(Kind::shared(
        "flac/subset_64_-_rice_partitions_with_escape_code_zero.flac",
    ));
    kinds
}

/// 60 rows of time, a vibration and a force.
fn rows(hz: f64, between: &str) -> String {
    let row = |i: usize| {
        let (time_s, vibration) = (i as f64 / hz, (i * 7 % 11) as f64 / 4.0);
        format!("{time_s:.4}{between}{vibration}{between}0.25\n")
    };
    (0..60).map(row).collect()
}

/// The export of DewesoftX as text: its header above the names of the channels.
fn dewesoft() -> String {
    let head = "File name: test.dxd\nStart time: 3/15/2024 10:22:33.250\nNumber of channels: 2\nSample rate: 1000 Hz\n\n\
        Time (s)\tacc (m/s2)\tfz (N)\n";
    head.to_owned() + &rows(1000.0, "\t")
}

fn table() -> String {
    "time (s),nail (m/s2),fz (N)\n".to_owned() + &rows(500.0, ",")
}

fn wav() -> Vec<u8> {
    let spec = hound::WavSpec {
        channels: 2,
        sample_rate: 5000,
        bits_per_sample: 24,
        sample_format: hound::SampleFormat::Int,
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
    for i in 0..200 {
        writer.write_sample(i * 1000 - 90_000).unwrap();
    }
    writer.finalize().unwrap();
    bytes.into_inner()
}

/// Reads damaged bytes under the name of a file.
struct Reader {
    folder: tempfile::TempDir,
}

impl Reader {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn path(&self, kind: &Kind) -> PathBuf {
        self.folder.path().join(&kind.name)
    }

    fn read(&self, kind: &Kind, bytes: &[u8]) -> Result<Recording, ReadError> {
        let path = self.path(kind);
        std::fs::write(&path, bytes).unwrap();
        read_recording(&path, &kind.options).map(|contents| contents.recording)
    }

    /// A recording, or an error that says what to do.
    fn look(&self, kind: &Kind, bytes: &[u8]) {
        if let Err(error) = self.read(kind, bytes) {
            let is_said =
                error.to_string().contains(';') || matches!(error, ReadError::Invalid { .. });
            assert!(is_said, "{}: {error}", kind.name);
        }
    }
}

/// `bytes` with one thing wrong with them.
fn damaged(random: &mut Lcg, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let at = random.below(bytes.len());
    let length = 1 + random.below(16);
    let end = (at + length).min(bytes.len());
    match random.below(8) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.below(256) as u8,
        // Lengths and counts that lie.
        2 => bytes[at..end].fill(0xFF),
        3 => bytes[at..end].fill(0),
        4 => bytes.truncate(at),
        5 => drop(bytes.drain(at..end)),
        6 => {
            let again = bytes[at..end].to_vec();
            bytes.splice(at..at, again);
        }
        _ => {
            let from = random.below(bytes.len());
            let other: Vec<u8> = bytes[from..].iter().copied().take(length).collect();
            bytes[at..(at + other.len()).min(end)]
                .iter_mut()
                .zip(other)
                .for_each(|(to, from)| *to = from);
        }
    }
    bytes
}

fn damage(rounds: usize) {
    let reader = Reader::new();
    let mut random = Lcg(50);
    for kind in kinds() {
        for round in 0..rounds {
            let mut bytes = damaged(&mut random, &kind.bytes);
            // Every third time with another thing wrong.
            if round % 3 == 0 && !bytes.is_empty() {
                bytes = damaged(&mut random, &bytes);
            }
            reader.look(&kind, &bytes);
        }
    }
}

#[test]
fn damaged_recordings_are_errors_and_no_panic() {
    damage(150);
}

#[test]
#[ignore = "30 000 rounds of each kind of file; ./x soak numbers"]
fn soak_damage_of_recordings() {
    damage(30_000);
}

/// What is read of a file that was cut at 200 places was there: the same samples, in the same order.
#[test]
fn recordings_that_were_cut_have_the_samples_that_are_left() {
    let reader = Reader::new();
    for kind in kinds() {
        // A file that holds more than recordings is for the damage alone.
        let Ok(whole) = reader.read(&kind, &kind.bytes) else {
            continue;
        };
        for place in 0..200 {
            let length = place * kind.bytes.len() / 200;
            let Ok(cut) = reader.read(&kind, &kind.bytes[..length]) else {
                continue;
            };
            for channel in cut.channels() {
                let found = whole.channels().iter().find(|one| one.name == channel.name);
                // Of scales that the rest of the file states, the values may differ.
                let Some(all) = found.filter(|all| all.unit == channel.unit) else {
                    continue;
                };
                assert!(
                    channel.samples.len() <= all.samples.len(),
                    "{} cut at {length}: {} samples of {}",
                    kind.name,
                    channel.samples.len(),
                    all.samples.len()
                );
                // Behind fewer than ten whole rows, a last one without an end of line is kept (docs/decisions/files.md).
                let is_short = channel.samples.len() <= 10;
                let kept = channel.samples.len() - usize::from(is_short);
                let pairs = channel.samples.iter().zip(&all.samples).take(kept);
                let other = pairs
                    .enumerate()
                    .find(|(_, (a, b))| a.to_bits() != b.to_bits());
                assert_eq!(
                    other, None,
                    "{} cut at {length}: `{}`",
                    kind.name, channel.name
                );
            }
        }
    }
}
