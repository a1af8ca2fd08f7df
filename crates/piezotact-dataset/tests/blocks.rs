//! Recordings in blocks: the samples, the description and the errors are those of the whole file.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use crate::shared_data;
use crate::tdms::shared_files;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact_dataset::{
    ReadError, ReadOptions, RecordingInBlocks, read_recording, recording_in_blocks, write_recording,
};

/// The samples of `names` in blocks, put together again.
fn together(
    blocks: &RecordingInBlocks,
    names: &[&str],
    block: usize,
) -> Result<Vec<(String, Vec<f64>)>, ReadError> {
    let mut all = Vec::<(String, Vec<f64>)>::new();
    blocks.each(names, block, |first, part| {
        assert!((1..=block).contains(&part.len()));
        for (k, channel) in part.channels().iter().enumerate() {
            if first == 0 {
                all.push((channel.name.clone(), Vec::new()));
            }
            assert_eq!((&all[k].0, all[k].1.len()), (&channel.name, first));
            all[k].1.extend(&channel.samples);
        }
        Ok::<(), ReadError>(())
    })?;
    Ok(all)
}

/// Compares a file in blocks with the whole one; `false` where it is not read in blocks.
fn compare(path: &Path, options: &ReadOptions, lengths: &[usize]) -> bool {
    let Some(blocks) = recording_in_blocks(path, options, 0).unwrap_or(None) else {
        return false;
    };
    let file = path.display();
    let names = blocks.contents().recording.channels().iter();
    let names: Vec<&str> = names.map(|channel| channel.name.as_str()).collect();
    let whole = match read_recording(path, options) {
        Ok(whole) => whole,
        Err(error) => {
            let found = together(&blocks, &names, lengths[0]).unwrap_err();
            assert_eq!(found.to_string(), error.to_string());
            return true;
        }
    };
    let (found, expected) = (&blocks.contents().recording, &whole.recording);
    assert_eq!(found.about, expected.about, "{file}");
    assert_eq!(found.annotations, expected.annotations, "{file}");
    assert_eq!(found.clocks(), expected.clocks(), "{file}");
    assert_eq!(blocks.contents().kind, whole.kind, "{file}");
    assert_eq!(blocks.samples(), expected.len(), "{file}");
    let described = |recording: &Recording| {
        let of = |c: &Channel| (c.name.clone(), c.unit.clone());
        recording.channels().iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(described(found), described(expected), "{file}");
    let last = &names[names.len() - 1..];
    for block in lengths {
        for wanted in [&names[..], last] {
            let found = together(&blocks, wanted, *block).unwrap();
            assert_eq!(found.len(), wanted.len(), "{file}");
            for (name, samples) in found {
                let whole = expected.pick(Some(&name), &Unit::Newton).unwrap();
                let bits = |samples: &[f64]| samples.iter().map(|v| v.to_bits()).collect();
                let (found, whole): (Vec<u64>, Vec<u64>) = (bits(&samples), bits(&whole.samples));
                assert!(found == whole, "{file}, {name} in blocks of {block}");
            }
        }
    }
    true
}

fn kept(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    folder.join(name)
}

fn ours(folder: &Path, samples: usize) -> PathBuf {
    let channel = |name: &str, unit: Unit, k: usize| Channel {
        name: name.into(),
        unit,
        samples: (0..samples)
            .map(|i| ((i * i * k) as f64 * 0.01).sin())
            .collect(),
    };
    let channels = vec![
        channel("acceleration", Unit::MetrePerSecondSquared, 1),
        channel("fz", Unit::Newton, 3),
    ];
    let rate = SampleRate::new(5000.0).unwrap();
    let recording = Recording::new(channels, rate, Condition::default(), Provenance::default());
    let path = folder.join("ours.parquet");
    write_recording(&path, &recording.unwrap()).unwrap();
    path
}

#[test]
fn blocks_of_any_length_are_the_whole_file() {
    let none = ReadOptions::default();
    let rate = ReadOptions {
        rate: SampleRate::new(1000.0).ok(),
        ..ReadOptions::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let ours = ours(folder.path(), 70_001);
    assert!(compare(&ours, &none, &[1 << 20, 65_536, 4099]));
    assert!(compare(&ours, &rate, &[70_000]));
    for name in ["tables/zstd.parquet", "tables/moments.parquet"] {
        assert!(compare(&kept(name), &none, &[1, 7, 1000]), "{name}");
    }
    // Text may be no times, which only all of it shows; a scale that is a table, how many samples lie outside.
    for name in ["tables/text.parquet", "scales.tdms"] {
        assert!(!compare(&kept(name), &none, &[]), "{name}");
    }
    assert!(compare(&kept("daqmx.tdms"), &none, &[1, 3, 1000]));
}

#[test]
fn files_of_other_programs_in_blocks_are_the_whole_files() {
    let none = ReadOptions::default();
    let rate = ReadOptions {
        rate: SampleRate::new(5000.0).ok(),
        ..ReadOptions::default()
    };
    let mut files = shared_files();
    let cases = ["rowgroups_zstd.parquet", "time_col.parquet"];
    files.extend(
        cases
            .map(|name| format!("cases/{name}"))
            .iter()
            .filter_map(|n| shared_data::shared(n)),
    );
    let found: Vec<bool> = (files.iter())
        .flat_map(|path| [&none, &rate].map(|options| compare(path, options, &[997, 8192])))
        .collect();
    let in_blocks = found.iter().filter(|found| **found).count();
    assert!(
        files.is_empty() || in_blocks >= 20,
        "{in_blocks} of {}",
        found.len()
    );
}

/// A size that fits is read whole, and so is what only the whole file shows.
#[test]
fn what_fits_or_has_to_be_whole_is_not_read_in_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let path = ours(folder.path(), 1000);
    let none = ReadOptions::default();
    let of = |options: &ReadOptions, beyond| recording_in_blocks(&path, options, beyond).unwrap();
    assert!(of(&none, 15_999).is_some());
    assert!(of(&none, 16_000).is_none());
    let second = ReadOptions {
        part: Some(2),
        ..ReadOptions::default()
    };
    assert!(of(&second, 0).is_none());
    // A file of ours needs none beside it, and says that it is not read.
    std::fs::write(folder.path().join("ours.parquet.json"), "{}").unwrap();
    assert!(compare(&path, &none, &[100]));
    let table = folder.path().join("table.parquet");
    std::fs::copy(kept("tables/zstd.parquet"), &table).unwrap();
    assert!(recording_in_blocks(&table, &none, 0).unwrap().is_some());
    std::fs::write(folder.path().join("table.parquet.json"), "{}").unwrap();
    assert!(recording_in_blocks(&table, &none, 0).unwrap().is_none());
}

/// Damage that shows in the samples alone is an error of the pass over all channels, with the sentence of the whole file.
#[test]
fn damage_is_the_same_error_in_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let path = ours(folder.path(), 5000);
    let bytes = std::fs::read(&path).unwrap();
    let none = ReadOptions::default();
    let mut seen = 0;
    for at in (4..bytes.len() - 8).step_by(977) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x10;
        std::fs::write(&path, &changed).unwrap();
        let whole = read_recording(&path, &none).map(drop);
        let found = recording_in_blocks(&path, &none, 0).and_then(|blocks| match blocks {
            Some(blocks) => together(&blocks, &["acceleration", "fz"], 777).map(drop),
            None => read_recording(&path, &none).map(drop),
        });
        assert_eq!(whole.is_err(), found.is_err(), "byte {at}");
        seen += usize::from(whole.is_err());
    }
    assert!(seen > 10, "{seen}");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let whole = read_recording(&path, &none).unwrap_err().to_string();
    let found = recording_in_blocks(&path, &none, 0).unwrap_err();
    assert_eq!(found.to_string(), whole);
}
