//! Damaged EEG files: an error that says what was expected, what was found and what to do; never a panic, never more memory than the
//! file has bytes for.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use piezotact_dataset::eeg::{read_eeg, read_xdf};
use piezotact_dataset::{ReadOptions, read_recording};

use crate::eeg::kept;
use crate::support::Lcg;

/// A folder with copies of the files of tests/golden/eeg whose names begin with `stem`.
fn copied(stem: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let from = kept("");
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if name.starts_with(stem) {
            std::fs::copy(&path, folder.path().join(name)).unwrap();
        }
    }
    let place = folder.path().to_owned();
    (folder, place)
}

fn refused(path: &Path, part: &str) {
    let error = read_eeg(path).unwrap_err().to_string();
    assert!(error.contains(part), "{part}: {error}");
    assert!(
        error.contains("expected") && error.contains("found") && error.contains(';'),
        "{error}"
    );
}

fn edited(path: &Path, from: &str, to: &str) {
    let bytes = std::fs::read(path).unwrap();
    let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    assert!(text.contains(from), "{from}");
    let changed: Vec<u8> = text
        .replacen(from, to, 1)
        .chars()
        .map(|c| c as u8)
        .collect();
    std::fs::write(path, changed).unwrap();
}

#[test]
fn a_brainvision_recording_that_is_not_whole_is_refused() {
    for (from, to, part) in [
        (
            "NumberOfChannels=2",
            "NumberOfChannels=3",
            "3 channels in [Channel Infos]",
        ),
        (
            "NumberOfChannels=2",
            "NumberOfChannels=two",
            "NumberOfChannels to be a number",
        ),
        (
            "NumberOfChannels=2",
            "NumberOfChannels=2147483648",
            "NumberOfChannels to be a number",
        ),
        (
            "SamplingInterval=10000",
            "SamplingInterval=x",
            "SamplingInterval to be a number",
        ),
        (
            "SamplingInterval=10000",
            "SamplingInterval=0",
            "SamplingInterval to be a number",
        ),
        (
            "SamplingInterval=10000",
            "SamplingInterval=10000\r\nDataPoints=2147483648",
            "2147483648 samples of each channel",
        ),
        (
            "BinaryFormat=INT_16",
            "BinaryFormat=INT_12",
            "BinaryFormat to be INT_16",
        ),
        ("BinaryFormat=INT_16", "Other=INT_16", "`BinaryFormat`"),
        (
            "DataFormat=BINARY",
            "DataFormat=ASCII",
            "samples as text (DataFormat=ASCII), which are not read",
        ),
        (
            "DataFile=gap.eeg",
            "DataFile=other.eeg",
            "the file that DataFile names",
        ),
        (
            "DataFile=gap.eeg",
            "DataFile=../gap.eeg",
            "in the folder of the header",
        ),
        (
            "MarkerFile=gap.vmrk",
            "MarkerFile=other.vmrk",
            "the file that MarkerFile names",
        ),
        ("Ch2=Temp,,0.5", "Ch2=Temp,,half", "a resolution"),
        ("Ch2=Temp", "Ch1=Temp", "each once"),
        ("[Common Infos]", "[Common]", "`DataFile`"),
    ] {
        let (_folder, place) = copied("gap.");
        let header = place.join("gap.vhdr");
        // A missing MarkerFile key is no error; everything else is.
        edited(&header, from, to);
        match part {
            "`DataFile`" => assert!(
                read_eeg(&header)
                    .unwrap_err()
                    .to_string()
                    .contains("[Common Infos]")
            ),
            _ => refused(&header, part),
        }
    }
    // Vectorized channels begin elsewhere where samples are missing.
    let (_folder, place) = copied("gap.");
    edited(
        &place.join("gap.vmrk"),
        "Mk6=Stimulus,S  3,300",
        "Mk6=Stimulus,S  3,301",
    );
    refused(&place.join("gap.vhdr"), "the marker at data point 301");
    let (_folder, place) = copied("gap.");
    let data = std::fs::read(place.join("gap.eeg")).unwrap();
    for length in [0, 3, data.len() / 2, data.len() - 1] {
        std::fs::write(place.join("gap.eeg"), &data[..length]).unwrap();
        refused(&place.join("gap.vhdr"), "cut short");
    }
    std::fs::remove_file(place.join("gap.eeg")).unwrap();
    refused(&place.join("gap.vhdr"), "the file that DataFile names");
}

#[test]
fn an_edf_file_that_is_not_whole_is_refused() {
    let field = |at: usize, text: &str, part: &str| {
        let (_folder, place) = copied("plus.");
        let path = place.join("plus.edf");
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[at..at + 8].copy_from_slice(format!("{text:8}").as_bytes());
        std::fs::write(&path, bytes).unwrap();
        refused(&path, part);
    };
    // Three signals: two of samples, one of annotations.
    let of_signals = |columns: usize| 256 + 3 * columns;
    field(184, "99999999", "bytes stated");
    field(236, "x", "the number of records");
    field(236, "-2", "or -1");
    field(244, "x", "the duration of a record");
    field(244, "0", "above 0 s");
    field(of_signals(16 + 80 + 8), "x", "the physical minimum of `C1`");
    field(
        of_signals(16 + 80 + 40 + 80),
        "99999999",
        "at least one record",
    );
    field(of_signals(16 + 80 + 40 + 80), "-5", "at least one sample");
    let (_folder, place) = copied("plus.");
    let path = place.join("plus.edf");
    let bytes = std::fs::read(&path).unwrap();
    for (length, part) in [
        (100, "a complete header"),
        (300, "header of 1024 bytes"),
        (1024, "at least one record"),
    ] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        match length {
            100 => assert!(read_eeg(&path).is_err()),
            _ => refused(&path, part),
        }
    }
    // A recording that was not ended is read, with a warning.
    let mut unfinished = bytes.clone();
    unfinished[236..244].copy_from_slice(b"-1      ");
    std::fs::write(&path, &unfinished[..bytes.len() - 1]).unwrap();
    let read = read_eeg(&path).unwrap();
    let recording = &read.segments[0].recording;
    assert_eq!(recording.len(), 900);
    assert!(
        recording
            .about
            .warnings
            .iter()
            .any(|warning| warning.code == "interrupted")
    );
}

#[test]
fn a_data_set_of_eeglab_that_is_not_whole_is_refused() {
    let (_folder, place) = copied("struct.");
    let path = place.join("struct.set");
    let samples = std::fs::read(place.join("struct.fdt")).unwrap();
    std::fs::write(place.join("struct.fdt"), &samples[..samples.len() / 2]).unwrap();
    refused(&path, "2 channels of 300 samples");
    std::fs::remove_file(place.join("struct.fdt")).unwrap();
    refused(&path, "the file with its samples, `struct.fdt`");
    std::fs::write(&path, b"MATLAB 7.3 MAT-file, Platform: GLNXA64").unwrap();
    refused(&path, "-v7");
    let mut hdf = vec![0; 512];
    hdf.extend(b"\x89HDF\r\n\x1a\n");
    std::fs::write(&path, hdf).unwrap();
    let error = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("7.3 (HDF5)") && error.contains("-v7"),
        "{error}"
    );
}

/// Truncations and flipped bytes of every kind of file: an error or a recording, never a panic.
#[test]
fn damage_is_an_error_and_no_panic() {
    damaged_in(150);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_damage_of_eeg_files() {
    damaged_in(500);
}

fn damaged_in(rounds: usize) {
    let mut random = Lcg(7);
    for (stem, name, target) in [
        ("gap.", "gap.vhdr", "gap.vhdr"),
        ("gap.", "gap.vhdr", "gap.vmrk"),
        ("pybv_float.", "pybv_float.vhdr", "pybv_float.vhdr"),
        ("plus.edf", "plus.edf", "plus.edf"),
        ("gaps.edf", "gaps.edf", "gaps.edf"),
        ("two.edf", "two.edf", "two.edf"),
        ("plus.bdf", "plus.bdf", "plus.bdf"),
        ("struct.", "struct.set", "struct.set"),
        ("eeglabio.", "eeglabio.set", "eeglabio.set"),
        ("epochs.", "epochs.set", "epochs.set"),
        ("streams.", "streams.xdf", "streams.xdf"),
    ] {
        let (_folder, place) = copied(stem);
        let (path, target) = (place.join(name), place.join(target));
        let bytes = std::fs::read(&target).unwrap();
        let look = |bytes: &[u8]| {
            std::fs::write(&target, bytes).unwrap();
            let error = match name {
                "streams.xdf" => read_xdf(&path).err(),
                _ => read_eeg(&path).err(),
            };
            if let Some(error) = error {
                let text = error.to_string();
                let said = ["expected", "no such file", "is a folder", "no channel"];
                assert!(said.iter().any(|part| text.contains(part)), "{text}");
            }
        };
        for length in (0..bytes.len()).step_by(1 + bytes.len() / 120) {
            look(&bytes[..length]);
        }
        let mut damaged = bytes.clone();
        // Most of a file is samples: damage is mostly where the header is.
        let header = bytes.len().min(1400);
        for round in 0..rounds {
            let limit = if round % 4 == 0 { bytes.len() } else { header };
            let at = random.below(limit);
            damaged[at] = match round % 3 {
                0 => b'0' + random.below(10) as u8,
                _ => damaged[at] ^ (1 << random.below(8)),
            };
            look(&damaged);
            if round % 50 == 0 {
                let _either = read_recording(&path, &ReadOptions::default());
            }
            if round % 3 == 0 {
                damaged.clone_from(&bytes);
            }
        }
        std::fs::write(&target, &bytes).unwrap();
        assert!(name == "streams.xdf" || read_eeg(&path).is_ok(), "{name}");
    }
}

/// Codes beyond the range that a header states have a scale that may be wrong.
#[test]
fn codes_outside_their_range_are_reported() {
    let (_folder, place) = copied("plus.");
    let path = place.join("plus.edf");
    let outside = |path: &Path| -> Vec<String> {
        let found = read_eeg(path).unwrap();
        let warnings = found.segments[0].recording.about.warnings.clone();
        let codes = warnings.iter().map(|warning| warning.code.to_string());
        codes
            .filter(|code| code == "outside_stated_range")
            .collect()
    };
    assert!(outside(&path).is_empty());
    let mut bytes = std::fs::read(&path).unwrap();
    // The digital maximum of the first of three signals.
    let at = 256 + 3 * (16 + 80 + 8 + 8 + 8 + 8);
    bytes[at..at + 8].copy_from_slice(b"1       ");
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(outside(&path).len(), 1);
}
