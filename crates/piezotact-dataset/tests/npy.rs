//! Arrays that NumPy saved (`golden/npy.py`), and those that are no recording.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::{Path, PathBuf};

use piezotact::quantity::{SampleRate, Unit};
use piezotact_dataset::{
    Contents, FileKind, ReadError, ReadOptions, read_recording, recording_formats,
};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden/npy")
        .join(name)
}

fn stated() -> ReadOptions {
    ReadOptions {
        rate: Some(SampleRate::new(1000.0).unwrap()),
        scale: Some("2 m/s2".parse().unwrap()),
        ..ReadOptions::default()
    }
}

#[track_caller]
fn read(name: &str, options: &ReadOptions) -> Contents {
    read_recording(&golden(name), options).unwrap()
}

fn of_bytes(bytes: &[u8]) -> Result<Contents, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    std::fs::write(&path, bytes).unwrap();
    read_recording(&path, &stated())
}

/// Channel c holds `scale` (c + 1) sin(0.37 k), to `within` of its peak.
#[track_caller]
fn assert_sines(contents: &Contents, scale: f64, within: f64) {
    for (c, channel) in contents.recording.channels().iter().enumerate() {
        assert_eq!(channel.samples.len(), 40);
        for (k, found) in channel.samples.iter().enumerate() {
            let peak = scale * (c + 1) as f64;
            let expected = peak * (0.37 * k as f64).sin();
            assert!(
                (found - expected).abs() <= within * peak,
                "{}, {k}: {found} {expected}",
                channel.name
            );
        }
    }
}

#[test]
fn arrays_of_every_order_are_read_with_a_stated_rate_and_scale() {
    // 64 bits differ by the sine of two libraries, 32 bits by half a step, integers by half a thousandth.
    for (name, channels, scale, within) in [
        ("one.npy", 1, 2.0, 1e-15),
        ("big_endian.npy", 1, 2.0, 6e-8),
        ("int16.npy", 1, 2000.0, 5e-4),
        ("three.npy", 3, 2.0, 1e-15),
        ("fortran.npy", 3, 2.0, 1e-15),
    ] {
        let contents = read(name, &stated());
        assert_eq!(contents.kind.to_string(), "NumPy");
        let r = &contents.recording;
        assert_eq!((r.channels().len(), r.rate().hz()), (channels, 1000.0));
        assert_eq!(r.channels()[0].unit, Unit::MetrePerSecondSquared);
        assert_eq!(r.about.warnings, [], "{name}");
        assert_sines(&contents, scale, within);
    }
    assert_eq!(
        read("three.npy", &stated()).recording.channels()[2].name,
        "channel 3"
    );
    assert!(recording_formats().contains("NPY, NPZ"));
    assert_eq!(
        FileKind::of_ending(Path::new("a.npz")).unwrap().to_string(),
        "NumPy"
    );
}

#[test]
fn an_archive_names_its_channels_and_its_rate() {
    let contents = read("named.npz", &ReadOptions::default());
    let r = &contents.recording;
    let names: Vec<&str> = r.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!((names, r.rate().hz()), (vec!["acc", "force"], 5000.0));
    assert_sines(&contents, 1.0, 1e-15);
    let warnings: Vec<String> = r.about.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(
        warnings.iter().any(|text| text.contains("`note`")),
        "{warnings:?}"
    );
    // What a person states goes before what the file says, and the difference is said.
    let rate = ReadOptions {
        scale: None,
        ..stated()
    };
    let other = read("named.npz", &rate).recording;
    assert_eq!(other.rate().hz(), 1000.0);
    assert!(other.about.warnings[0].to_string().contains("5000"));
    // Time stamps in s.
    let timed = read("timed.npz", &ReadOptions::default());
    assert_eq!(timed.recording.rate().hz(), 2000.0);
    assert_eq!(timed.recording.channels().len(), 1);
    assert_sines(&timed, 1.0, 1e-15);
}

#[test]
fn what_is_no_recording_is_named() {
    for (name, part) in [
        ("object.npy", "Python objects (a pickle)"),
        ("complex.npy", "complex numbers"),
        ("channels_in_rows.npy", "3 × 40, more channels than samples"),
    ] {
        let error = read_recording(&golden(name), &stated())
            .unwrap_err()
            .to_string();
        assert!(error.contains(part), "{error}");
    }
    let error = read_recording(&golden("one.npy"), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--rate"), "{error}");
    // Shapes that no file holds, and a description that is longer than its file.
    let header = |dict: &str| {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((dict.len() as u16).to_le_bytes());
        bytes.extend(dict.as_bytes());
        bytes
    };
    let of_shape =
        |shape: &str| format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    for (dict, part) in [
        (
            of_shape("(1099511627776, 1099511627776)"),
            "an impossible shape",
        ),
        (
            of_shape(&format!("{}3{}", "(".repeat(20_000), ")".repeat(20_000))),
            "the header `",
        ),
        (of_shape("(2, 2, 2)"), "cut short"),
        (of_shape("(3,)"), "0 of its 24 bytes"),
        ("{}".into(), "as NumPy saves it"),
    ] {
        let error = of_bytes(&header(&dict)).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let error = of_bytes(&header(&of_shape("(3,)"))[..30]).unwrap_err();
    assert!(
        error.to_string().contains("ends within its header"),
        "{error}"
    );
}

#[test]
fn cut_and_damaged_files_are_sentences() {
    for name in ["one.npy", "named.npz", "timed.npz"] {
        let whole = std::fs::read(golden(name)).unwrap();
        for length in (1..whole.len()).step_by(13) {
            let read = of_bytes(&whole[..length]);
            assert!(read.is_err(), "{name}: {length}");
        }
        for at in (0..whole.len()).step_by(17) {
            for flipped in [0xFF, 0x01] {
                let mut bytes = whole.clone();
                bytes[at] ^= flipped;
                let _either = of_bytes(&bytes);
            }
        }
    }
}

/// An `.npy` of `values`.
fn array(values: &[f64], shape: &str) -> Vec<u8> {
    let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((dict.len() as u16).to_le_bytes());
    bytes.extend(dict.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// An `.npz` of samples under their names, and of its rate.
fn archive(folder: &Path, fs_hz: f64, arrays: &[(&str, Vec<f64>)]) -> PathBuf {
    use std::io::Write as _;
    let path = folder.join("a.npz");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let plain = zip::write::SimpleFileOptions::default();
    for (name, values) in arrays {
        zip.start_file(format!("{name}.npy"), plain).unwrap();
        let shape = format!("({},)", values.len());
        zip.write_all(&array(values, &shape)).unwrap();
    }
    zip.start_file("fs.npy", plain).unwrap();
    zip.write_all(&array(&[fs_hz], "()")).unwrap();
    zip.finish().unwrap();
    path
}

fn ramp(step: f64) -> Vec<f64> {
    (0..40).map(|k| f64::from(k) * step).collect()
}

/// Where `fs` and a time vector say two rates, the times count, with a warning; what is rounded, or in ms without saying so, agrees.
#[test]
fn times_count_before_a_rate_that_contradicts_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = |fs_hz: f64, name: &str, step: f64| {
        archive(
            folder.path(),
            fs_hz,
            &[("acc", ramp(0.1)), (name, ramp(step))],
        )
    };
    let options = ReadOptions::default();
    for (fs_hz, name, step) in [
        (1000.0, "t", 2e-4),
        (2500.0, "t", 1e-3),
        (5000.0, "t (s)", 0.2),
    ] {
        let read = read_recording(&file(fs_hz, name, step), &options).unwrap();
        let found_hz = 1.0 / step;
        assert!((read.recording.rate().hz() - found_hz).abs() < 1e-6 * found_hz);
        let said = format!("{:?}", read.recording.about.warnings);
        assert!(
            said.contains(&format!("`fs` states {fs_hz} Hz, `t` gives")),
            "{said}"
        );
        // What a person states goes before both.
        read_recording(&file(fs_hz, name, step), &stated()).unwrap();
    }
    for (fs_hz, name, step) in [
        (5000.0, "t", 2.001e-4),
        (5000.0, "time", 0.2),
        (5000.0, "t_ms", 0.2),
    ] {
        let read = read_recording(&file(fs_hz, name, step), &options).unwrap();
        let names: Vec<_> = read
            .recording
            .channels()
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        assert_eq!((read.recording.rate().hz(), names), (fs_hz, vec!["acc"]));
    }
}

/// Units stand in names as in the header of a table, or in the sidecar; one scale does not hold of two quantities.
#[test]
fn arrays_have_units_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    for (acc, force) in [
        ("acc (m/s²)", "fz (mN)"),
        ("acc_m_s2", "fz [mN]"),
        ("acc [m/s2]", "fz_mN"),
    ] {
        let path = archive(
            folder.path(),
            5000.0,
            &[(acc, ramp(1.0)), (force, ramp(1.0))],
        );
        let r = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        let channels: Vec<_> = r
            .channels()
            .iter()
            .map(|c| (c.name.as_str(), c.unit.clone()))
            .collect();
        let expected = [("acc", Unit::MetrePerSecondSquared), ("fz", Unit::Newton)];
        assert_eq!(
            (channels, r.channels()[1].samples[39]),
            (expected.to_vec(), 0.039)
        );
        assert_eq!(r.about.warnings, []);
    }
    let path = archive(
        folder.path(),
        5000.0,
        &[("acc", ramp(1.0)), ("fz", ramp(1.0))],
    );
    let scaled = ReadOptions {
        rate: None,
        ..stated()
    };
    let error = read_recording(&path, &scaled).unwrap_err().to_string();
    assert!(
        error.contains("acc, fz") && error.contains(r#"{"units": {"acc""#),
        "{error}"
    );
    let sidecar = folder.path().join("a.npz.json");
    std::fs::write(
        &sidecar,
        r#"{"units": {"fz": "2 N"}, "condition": {"sample": "S4"}, "labels": {"session": "2"},
            "events": [{"onset_s": 0.001, "duration_s": 0, "kind": "answer"}]}"#,
    )
    .unwrap();
    let r = read_recording(&path, &scaled).unwrap().recording;
    assert_eq!(r.channels()[1].samples[39], 78.0);
    assert_eq!(r.channels()[0].unit, Unit::MetrePerSecondSquared);
    assert_eq!(r.about.condition.sample.as_deref(), Some("S4"));
    assert_eq!(
        (
            r.annotations.labels["session"].as_str(),
            r.annotations.events.len()
        ),
        ("2", 1)
    );
    assert_eq!(r.about.warnings, []);
    std::fs::write(&sidecar, r#"{"units": {"fy": "N"}}"#).unwrap();
    let error = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("(acc, fz), found `fy`"), "{error}");
}

#[test]
fn integers_without_a_scale_are_counts() {
    let only_rate = ReadOptions {
        scale: None,
        ..stated()
    };
    let r = read("int16.npy", &only_rate).recording;
    let text = r.about.warnings[0].to_string();
    assert!(
        text.contains("counts") && !text.contains("full scale"),
        "{text}"
    );
    assert!(
        read("one.npy", &only_rate).recording.about.warnings[0]
            .to_string()
            .contains("physical scale")
    );
}

/// A sidecar beside a format that takes none is not ignored without a word.
#[test]
fn a_sidecar_that_is_not_read_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.edf");
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/eeg/gaps.edf");
    std::fs::copy(kept, &path).unwrap();
    let read = || {
        read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording
            .about
            .warnings
    };
    let before = read().len();
    std::fs::write(folder.path().join("a.edf.json"), "{}").unwrap();
    let text = read()[before].to_string();
    assert!(
        text.contains("a.edf.json is not read") && text.contains("EDF or BDF"),
        "{text}"
    );
}

/// Units of rates and times stand in their names, and rates that contradict each other are refused.
#[test]
fn units_of_rates_and_times_of_archives() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.npz");
    let save = |numbers: &[(&str, f64)], text: Option<(&str, &str)>| {
        let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        let plain = zip::write::SimpleFileOptions::default();
        let mut add = |name: &str, bytes: &[u8]| {
            zip.start_file(format!("{name}.npy"), plain).unwrap();
            zip.write_all(bytes).unwrap();
        };
        add(
            "acc",
            &array(&ramp(1.0), &format!("({},)", ramp(1.0).len())),
        );
        for (name, value) in numbers {
            add(name, &array(&[*value], "()"));
        }
        if let Some((name, text)) = text {
            // As NumPy saves a text: U3, four bytes a letter.
            let mut bytes = array(&[], "()");
            let at = bytes.windows(3).position(|three| three == b"<f8").unwrap();
            bytes[at..at + 3].copy_from_slice(format!("<U{}", text.len()).as_bytes());
            bytes.extend(
                text.chars()
                    .flat_map(|letter| u32::from(letter).to_le_bytes()),
            );
            add(name, &bytes);
        }
        zip.finish().unwrap();
        read_recording(&path, &ReadOptions::default())
    };
    for (name, value, unit) in [
        ("fs", 2.0, Some(("fs_unit", "kHz"))),
        ("fs (kHz)", 2.0, None),
        ("dt_ms", 0.5, None),
    ] {
        let read = save(&[(name, value)], unit).unwrap().recording;
        assert_eq!(read.rate().hz(), 2000.0, "{name}");
    }
    let refused = save(&[("fs", 1000.0), ("dt", 5e-4)], None).unwrap_err();
    assert!(refused.to_string().contains("2000 Hz of `dt`"), "{refused}");
    let scaled = save(
        &[("fs", 1000.0), ("sensitivity", 0.1)],
        Some(("acc_unit", "g")),
    )
    .unwrap();
    assert_eq!(
        scaled.recording.channels()[0].unit,
        Unit::MetrePerSecondSquared
    );
    let said = format!("{:?}", scaled.recording.about.warnings);
    assert!(said.contains("`sensitivity` holds no samples"), "{said}");
}
