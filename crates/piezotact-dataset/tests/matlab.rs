//! MATLAB files of every version, good and damaged, which lie beside the checkout; our own; and both torn apart.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use piezotact::warning::{Few, FewWarning};
use std::path::{Path, PathBuf};

use crate::support::Lcg;
use piezotact::Warning;
use piezotact::device::{DeviceDescription, DriveSetup};
use piezotact::quantity::{Degrees, Newtons, SampleRate, Unit, Volts};
use piezotact::recording::{About, Condition, Provenance, Touch};
use piezotact::transfer::Estimator;
use piezotact_dataset::matlab::{
    MatEntry, MatFile, MatNumbers, MatValue, NumberClass, parse_mat, write_mat,
};
use piezotact_dataset::{
    FileKind, ReadError, ReadOptions, TransferDocument, holds_transfer, read_recording,
    read_transfer, write_transfer,
};

fn files() -> Vec<PathBuf> {
    let Some(folder) = shared_data::shared("data/daq/mat") else {
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "mat"))
        .collect();
    files.sort();
    files
}

pub(super) fn parse(path: &Path) -> Result<MatFile, ReadError> {
    parse_mat(path, &std::fs::read(path).unwrap())
}

/// The files that SciPy 1.17.1 refuses too, and a part of what we say of them. (It also refuses a name with a letter
/// beyond ASCII, which is well-formed UTF-8 and is read here.)
const REFUSED: [(&str, &str); 6] = [
    ("bad_miuint32.mat", "dimensions"),
    ("corrupted_zlib_checksum.mat", "damaged bytes"),
    ("corrupted_zlib_data.mat", ""),
    ("debigged_m4.mat", ""),
    ("malformed1.mat", ""),
    ("testhdf5_7.4_GLNX86.mat", "-v7"),
];

#[test]
fn every_file_is_read_or_refused_with_a_reason() {
    for path in files() {
        let name = path.file_name().unwrap().to_str().unwrap();
        let refused = REFUSED.iter().find(|(file, _)| *file == name);
        match (parse(&path), refused) {
            (Ok(file), None) => assert!(!file.variables.is_empty(), "{name}"),
            (Err(error), Some((_, part))) => {
                let text = error.to_string();
                assert!(text.contains(part) && text.contains(';'), "{name}: {text}");
            }
            (Ok(file), Some(_)) => unreachable!("{name} should be refused: {file:?}"),
            (Err(error), None) => unreachable!("{name}: {error}"),
        }
    }
}

pub(super) fn numbers(value: &MatValue) -> &MatNumbers {
    match value {
        MatValue::Numbers(numbers) => numbers,
        other => unreachable!("{other:?}"),
    }
}

/// The value of one variable in every version of a file that there is.
fn each(stem: &str, variable: &str, mut check: impl FnMut(&str, &MatValue)) {
    let mut seen = 0;
    for path in files() {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if name
            .strip_prefix(stem)
            .is_some_and(|rest| rest.starts_with(['_', '.']))
        {
            let file = parse(&path).unwrap();
            check(&name, file.get(variable).unwrap());
            seen += 1;
        }
    }
    assert!(seen > 0 || files().is_empty(), "{stem}");
}

#[test]
fn every_class_in_every_version() {
    each("testdouble", "testdouble", |name, value| {
        let values = value.vector().unwrap();
        assert_eq!(numbers(value).dims, [1, 9], "{name}");
        for (k, value) in values.iter().enumerate() {
            // Written as 0:pi/4:2*pi.
            assert!((value - k as f64 * std::f64::consts::FRAC_PI_4).abs() < 1e-15);
        }
    });
    each("testcomplex", "testcomplex", |name, value| {
        let numbers = numbers(value);
        let imaginary = numbers.imaginary.as_ref().unwrap();
        for (k, (re, im)) in numbers.real.iter().zip(imaginary).enumerate() {
            let turn = k as f64 * std::f64::consts::FRAC_PI_4;
            assert!(
                (re - turn.cos()).abs() < 1e-15 && (im - turn.sin()).abs() < 1e-15,
                "{name}"
            );
        }
    });
    each("testmatrix", "testmatrix", |name, value| {
        assert_eq!(numbers(value).dims, [3, 5], "{name}");
        let mut expected = [0.0; 15];
        for (at, value) in [
            (0, 1.0),
            (1, 2.0),
            (2, 3.0),
            (3, 2.0),
            (6, 3.0),
            (9, 4.0),
            (12, 5.0),
        ] {
            expected[at] = value;
        }
        assert_eq!(numbers(value).real, expected, "{name}");
    });
    each("test3dmatrix", "test3dmatrix", |name, value| {
        assert_eq!(numbers(value).dims, [2, 3, 4], "{name}");
        let expected: Vec<f64> = (1..=24).map(f64::from).collect();
        assert_eq!(numbers(value).real, expected);
    });
    each("testminus", "testminus", |_, value| {
        assert_eq!(value.scalar(), Some(-1.0))
    });
    each("teststring", "teststring", |_, value| {
        assert_eq!(
            value.text(),
            Some("\"Do nine men interpret?\" \"Nine men,\" I nod.")
        );
    });
    each("teststringarray", "teststringarray", |_, value| {
        let rows = ["one  ", "two  ", "three"].map(String::from).to_vec();
        assert_eq!(*value, MatValue::Text(rows));
    });
    each("testunicode", "testunicode", |_, value| {
        let text = value.text().unwrap();
        assert!(text.starts_with("Japanese: \nすべての人間は"), "{text}");
        assert_eq!(text.chars().count(), 100);
    });
    each("testcell", "testcell", |_, value| match value {
        MatValue::Cell { dims, values } => {
            assert_eq!(*dims, [1, 4]);
            assert!(values[0].text().unwrap().starts_with("This cell contains"));
            assert_eq!(values[3].vector(), Some(&[1.0, 2.0, 3.0][..]));
        }
        other => unreachable!("{other:?}"),
    });
    each("teststructarr", "teststructarr", |_, value| match value {
        MatValue::Struct {
            dims,
            fields,
            values,
            class: None,
        } => {
            assert_eq!(
                (dims.as_slice(), fields.as_slice()),
                (&[1, 2][..], &["one".to_owned(), "two".into()][..])
            );
            assert_eq!(values[1].scalar(), Some(2.0));
            assert_eq!(values[2].text(), Some("number 1"));
        }
        other => unreachable!("{other:?}"),
    });
    each("testobject", "testobject", |_, value| {
        assert!(
            matches!(value, MatValue::Struct { class: Some(class), .. } if class == "inline"),
            "{value:?}"
        );
    });
    let entries = [1.0, 2.0, 3.0, 4.0, 5.0, 2.0, 3.0];
    let places = [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (1, 0), (2, 0)];
    for (stem, first) in [("testsparse", 0.0), ("testsparsecomplex", 1.0)] {
        each(stem, stem, |name, value| match value {
            MatValue::Sparse {
                rows: 3,
                columns: 5,
                entries: found,
            } => {
                let mut found = found.clone();
                found.sort_by_key(|entry| (entry.row, entry.column));
                let expected: Vec<MatEntry> = places
                    .iter()
                    .zip(entries)
                    .map(|(&(row, column), real)| MatEntry {
                        row,
                        column,
                        real,
                        // The first entry alone is complex.
                        imaginary: if (row, column) == (0, 0) { first } else { 0.0 },
                    })
                    .collect();
                assert_eq!(found, expected, "{name}");
            }
            other => unreachable!("{other:?}"),
        });
    }
    each("testbool", "testbools", |_, value| {
        assert_eq!(
            (numbers(value).class, numbers(value).real.as_slice()),
            (NumberClass::Logical, &[1.0, 0.0][..])
        );
    });
    each("big_endian", "floats", |_, value| {
        assert_eq!(
            (numbers(value).class, numbers(value).real.as_slice()),
            (NumberClass::Single, &[2.0, 3.0, 3.0, 4.0][..])
        );
    });
    each("testvec", "fit_params", |_, value| {
        assert!((value.vector().unwrap()[1] - 7.511_302_56e-3).abs() < 1e-10);
    });
    each("testfunc", "testfunc", |_, value| {
        assert!(matches!(value, MatValue::Unreadable(_)))
    });
}

#[test]
fn time_signals_of_others_become_recordings() {
    if let Some(path) = shared_data::shared("data/frf/vibrationtesting/frf_data1.mat") {
        let contents = read_recording(&path, &ReadOptions::default()).unwrap();
        assert_eq!(contents.kind, FileKind::MATLAB);
        let recording = contents.recording;
        let [x, f] = recording.channels() else {
            unreachable!("two channels");
        };
        assert_eq!(
            (x.name.as_str(), f.name.as_str(), x.samples.len()),
            ("x", "f", 1024)
        );
        // Sums of the big-endian doubles, as NumPy finds them.
        assert!((x.samples.iter().sum::<f64>() - 4.157_444_817_172_845).abs() < 1e-9);
        assert!((f.samples[0] - 0.322_720_87).abs() < 1e-8);
        assert!((recording.rate().hz() - 10.0).abs() < 1e-9);
        assert_eq!(
            recording.about.warnings.len(),
            2,
            "{:?}",
            recording.about.warnings
        );
        let scaled = ReadOptions {
            scale: Some("1 N".parse().unwrap()),
            rate: None,
            ..ReadOptions::default()
        };
        let scaled = read_recording(&path, &scaled).unwrap().recording;
        assert_eq!(
            (&scaled.channels()[0].unit, scaled.about.warnings.len()),
            (&Unit::Newton, 0)
        );
        assert!(!holds_transfer(&path));
    }
    if let Some(path) = shared_data::shared("data/frf/vibrationtesting/case1.mat") {
        let recording = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        let names: Vec<&str> = recording
            .channels()
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        assert_eq!(names, ["Time_chan_1", "Time_chan_2"]);
        assert_eq!(recording.len(), 4096);
        // The stated rate, not the one of times in single precision (1279.95 Hz).
        assert_eq!(recording.rate().hz(), 1280.0);
        assert!(!holds_transfer(&path));
    }
}

fn document() -> TransferDocument {
    let lines = 65;
    TransferDocument {
        drive_unit: Unit::FullScale,
        response_unit: Unit::MetrePerSecondSquared,
        estimator: Estimator::HvAt { noise_ratio: 0.25 },
        known_input: true,
        identities: None,
        effective_averages: Some(37.5),
        excited_hz: None,
        impact: None,
        confidence: None,
        attempts: Vec::new(),
        distortion: None,
        measured_for: None,
        averages: 12,
        rate_hz: Some(SampleRate::new(10_000.0).unwrap()),
        about: About {
            condition: Condition {
                participant: Some("Zoë 𝄞".into()),
                load_n: Some(Newtons(0.2)),
                angle_deg: Some(Degrees(15.0)),
                touch: Some(Touch::Resting),
                ..Condition::default()
            },
            provenance: Provenance {
                source: "bench".into(),
                ..Provenance::default()
            }
            .then("estimated"),
            warnings: vec![Warning::from(FewWarning::Few {
                found: 12,
                recommended: 20,
                what: Few::Averages,
            })],
        },
        drive: Some(
            DriveSetup::new(
                DeviceDescription::drv2667().at_usual_gain(),
                Volts(1.41),
                Some(1e-6),
            )
            .unwrap(),
        ),
        frequency_hz: (0..lines)
            .map(|k| f64::from(k) * 10_000.0 / 128.0)
            .collect(),
        real: (0..lines).map(|k| (f64::from(k) * 0.3).cos()).collect(),
        imaginary: (0..lines)
            .map(|k| (f64::from(k) * 0.7).sin() / 3.0)
            .collect(),
        coherence: (0..lines).map(|k| 1.0 / (1.0 + f64::from(k))).collect(),
    }
}

#[test]
fn what_is_written_is_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tf.mat");
    let written = document();
    write_transfer(&file, &written).unwrap();
    assert!(holds_transfer(&file));
    assert_eq!(read_transfer(&file).unwrap(), written);
    let variables = parse(&file).unwrap();
    assert_eq!(variables.get("load_n").unwrap().scalar(), Some(0.2));
    assert_eq!(variables.get("participant").unwrap().text(), Some("Zoë 𝄞"));
    let bare = TransferDocument {
        about: About {
            condition: Condition::default(),
            ..document().about
        },
        drive_unit: Unit::Other(String::new()),
        response_unit: Unit::Other("counts".into()),
        rate_hz: None,
        ..document()
    };
    write_transfer(&file, &bare).unwrap();
    assert_eq!(read_transfer(&file).unwrap(), bare);
    let mut odd = document();
    odd.real[3] = f64::NAN;
    assert!(
        write_mat(&file, &odd)
            .unwrap_err()
            .to_string()
            .contains("NaN")
    );
}

/// A file of an earlier form, whose warnings were called otherwise: refused, not read without them.
#[test]
fn own_description_of_an_earlier_form_is_refused() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/earlier.mat");
    let refused = read_transfer(&file).unwrap_err().to_string();
    assert!(
        refused.contains("earlier version")
            && refused.contains("estimate the transfer function again"),
        "{refused}"
    );
}

/// SciPy 1.17.1 has read this file (see `golden/matlab.py`), and written the other that is read here.
#[test]
fn files_are_those_that_scipy_reads_and_its_own_are_read() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("transfer.mat");
    write_mat(&file, &document()).unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::copy(&file, kept.join("transfer.mat")).unwrap();
    }
    // The sines of another machine may differ in the last place: what is read is compared, not bytes.
    let (ours, kept_one) = (
        read_transfer(&file).unwrap(),
        read_transfer(&kept.join("transfer.mat")).unwrap(),
    );
    assert_eq!(ours.about.condition, kept_one.about.condition);
    assert_eq!(
        ours.coherence, kept_one.coherence,
        "UPDATE_GOLDEN=1 writes it again; then run golden/matlab.py"
    );

    let file = parse(&kept.join("scipy.mat")).unwrap();
    assert_eq!(file.get("int64").unwrap().vector(), Some(&[-9.0, 9.0][..]));
    assert_eq!(file.get("text").unwrap().text(), Some("Zoë 𝄞"));
    assert_eq!(numbers(file.get("matrix").unwrap()).dims, [2, 3]);
    assert!(!numbers(file.get("beyond").unwrap()).exact);
    let read = read_transfer(&kept.join("scipy.mat")).unwrap();
    assert_eq!(read.real, [1.0, 0.5, 0.25]);
    assert_eq!(read.imaginary, [0.0, -1.0, -2.0]);
    assert_eq!(read.coherence, [0.5, 0.75, 1.0]);
    assert_eq!(read.frequency_hz, [0.0, 2.5, 5.0]);
}

/// An array of doubles as an element of version 5.
fn array(name: &str, dims: [u32; 2], class: u32, parts: &[&[f64]]) -> Vec<u8> {
    let mut body = Vec::new();
    let mut element = |kind: u32, data: &[u8]| {
        body.extend(kind.to_le_bytes());
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(data);
        let filled = body.len().next_multiple_of(8);
        body.resize(filled, 0);
    };
    let complex = if parts.len() > 1 { 0x800 } else { 0 };
    element(6, &[(class | complex).to_le_bytes(), [0; 4]].concat());
    element(5, &dims.map(u32::to_le_bytes).concat());
    element(1, name.as_bytes());
    for part in parts {
        let bytes: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
        element(9, &bytes);
    }
    let mut whole = 14_u32.to_le_bytes().to_vec();
    whole.extend((body.len() as u32).to_le_bytes());
    whole.extend(body);
    whole
}

fn file_of(arrays: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1]);
    bytes.extend(b"IM");
    bytes.extend(arrays.concat());
    bytes
}

#[test]
fn names_that_others_give() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mat");
    let put = |arrays: &[Vec<u8>]| std::fs::write(&file, file_of(arrays)).unwrap();
    let column = |name: &str, values: &[f64]| array(name, [values.len() as u32, 1], 6, &[values]);
    let frf = array("FRF", [3, 1], 6, &[&[1.0, 2.0, 3.0], &[0.0, 1.0, 2.0]]);
    put(&[frf.clone(), column("freq", &[0.0, 2.0, 4.0])]);
    let document = read_transfer(&file).unwrap();
    assert_eq!(
        (document.imaginary[2], document.frequency_hz[2]),
        (2.0, 4.0)
    );
    assert_eq!(document.coherence, [1.0; 3]);
    assert!(
        document.about.warnings[0]
            .to_string()
            .contains("assumed to be 1")
    );
    put(&[
        frf.clone(),
        column("freq", &[2.0, 4.0, 6.0]),
        column("coh", &[0.1, 0.2, 0.3]),
    ]);
    assert_eq!(
        read_transfer(&file).unwrap().coherence,
        [0.0, 0.1, 0.2, 0.3]
    );
    put(&[frf.clone(), column("freq", &[0.0, 2.0, 5.0])]);
    let refused = read_transfer(&file).unwrap_err().to_string();
    assert!(refused.contains("uniform axis"), "{refused}");
    put(&[frf]);
    let refused = read_transfer(&file).unwrap_err().to_string();
    assert!(refused.contains("FRF (3×1 complex)"), "{refused}");

    let none = ReadOptions::default();
    let acc = column("acc", &[1.0, 2.0, 3.0]);
    put(&[acc.clone(), column("Fs", &[500.0])]);
    assert_eq!(
        read_recording(&file, &none).unwrap().recording.rate().hz(),
        500.0
    );
    put(&[
        acc.clone(),
        column("time", &[0.0, 0.25, 0.5]),
        column("other", &[1.0; 7]),
    ]);
    let recording = read_recording(&file, &none).unwrap().recording;
    assert_eq!(
        (recording.rate().hz(), recording.channels().len()),
        (4.0, 1)
    );
    assert!(
        recording
            .about
            .warnings
            .iter()
            .any(|warning| warning.to_string().contains("other"))
    );
    put(&[
        array(
            "data",
            [4, 2],
            6,
            &[&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]],
        ),
        column("fs", &[10.0]),
    ]);
    let recording = read_recording(&file, &none).unwrap().recording;
    assert_eq!(recording.channels()[1].samples, [5.0, 6.0, 7.0, 8.0]);
    put(&[
        array(
            "data",
            [2, 4],
            6,
            &[&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]],
        ),
        column("fs", &[10.0]),
    ]);
    let recording = read_recording(&file, &none).unwrap().recording;
    assert_eq!(recording.channels()[1].samples, [2.0, 4.0, 6.0, 8.0]);
    for (arrays, part) in [
        (vec![acc.clone()], "--rate"),
        (
            vec![acc.clone(), column("b", &[1.0; 4]), column("fs", &[9.0])],
            "one length",
        ),
        (vec![column("fs", &[9.0])], "fs (1×1)"),
        (vec![], "no variables"),
        (vec![acc.clone(), column("fs", &[-9.0])], "-9"),
    ] {
        put(&arrays);
        let refused = read_recording(&file, &none).unwrap_err().to_string();
        assert!(refused.contains(part), "{part}: {refused}");
    }
}

#[test]
fn claims_are_not_believed() {
    let values: &[f64] = &[1.0, 2.0];
    let nested = (0..200).fold(array("", [1, 1], 6, &[&[1.0]]), |inside, _| {
        let mut cell = array("", [1, 1], 1, &[]);
        cell.extend(inside);
        let length = (cell.len() - 8) as u32;
        cell[4..8].copy_from_slice(&length.to_le_bytes());
        cell
    });
    for (bytes, part) in [
        (
            file_of(&[array("a", [i32::MAX as u32; 2], 6, &[values])]),
            "numbers",
        ),
        (
            file_of(&[array("a", [i32::MAX as u32; 2], 1, &[])]),
            "arrays within another",
        ),
        (
            file_of(&[array("a", [u32::MAX, 2], 6, &[values])]),
            "dimensions",
        ),
        (file_of(&[nested]), "64 arrays"),
    ] {
        let refused = parse_mat(Path::new("a.mat"), &bytes)
            .unwrap_err()
            .to_string();
        assert!(refused.contains(part), "{part}: {refused}");
    }
    // A structure of very many elements without a field takes no room.
    let mut many = array("a", [1 << 30, 1 << 20], 2, &[]);
    let names = [5_u32 | 4 << 16, 8, 1, 0].map(u32::to_le_bytes).concat();
    many.extend(names);
    let length = (many.len() - 8) as u32;
    many[4..8].copy_from_slice(&length.to_le_bytes());
    assert!(parse_mat(Path::new("a.mat"), &file_of(&[many])).is_ok());
}

/// Truncations and flipped bytes of every file: an error that says what to do, or values, never a panic.
#[test]
fn damage_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("tf.mat");
    write_transfer(&own, &document()).unwrap();
    let scratch = folder.path().join("a.mat");
    let mut random = Lcg(21);
    for path in files().into_iter().chain([own]) {
        let bytes = std::fs::read(&path).unwrap();
        if bytes.len() > 9000 {
            continue;
        }
        let look = |bytes: &[u8]| {
            if let Err(error) = parse_mat(&path, bytes) {
                assert!(error.to_string().contains(';'), "{error}");
            }
        };
        for length in (0..bytes.len()).step_by(1 + bytes.len() / 500) {
            look(&bytes[..length]);
        }
        let mut damaged = bytes.clone();
        for round in 0..600 {
            // Beyond the text of the header, where nothing is read.
            let first = if bytes.starts_with(b"MATLAB") { 124 } else { 0 };
            let at = first + random.below(bytes.len() - first);
            damaged[at] ^= 1 << random.below(8);
            look(&damaged);
            if round % 200 == 0 {
                std::fs::write(&scratch, &damaged).unwrap();
                let _either = read_transfer(&scratch);
                let _or = read_recording(&scratch, &ReadOptions::default());
            }
            if round % 3 == 0 {
                damaged.clone_from(&bytes);
            }
        }
    }
}
