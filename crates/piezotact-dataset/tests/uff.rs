//! Universal files: those that analysers wrote, our own, and both damaged in thousands of ways. The measured ones
//! lie beside the checkout, in `../shared/data`.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use piezotact::recording::RecordingWarning;
use std::path::{Path, PathBuf};

use crate::support::Lcg;
use num_complex::Complex;
use piezotact::Warning;
use piezotact::quantity::{Degrees, Newtons, SampleRate, Unit};
use piezotact::recording::{About, Channel, Condition, Provenance, Recording};
use piezotact::transfer::Estimator;
use piezotact_dataset::uff::{
    UffAbscissa, UffData, UffEncoding, UffFunction, UffKind, parse_uff, write_uff,
    write_uff_recording,
};
use piezotact_dataset::{
    Contents, FileKind, ReadError, ReadOptions, TransferDocument, TransferFormat, holds_transfer,
    read_recording, read_transfer, write_transfer, write_transfer_as,
};

fn measured(name: &str) -> Option<PathBuf> {
    shared_data::shared(&format!("data/frf/uff/{name}"))
}

fn parse(bytes: &[u8]) -> Result<Vec<UffFunction>, ReadError> {
    parse_uff(Path::new("t.uff"), bytes)
}

fn recording(path: &Path) -> Contents {
    read_recording(path, &ReadOptions::default()).unwrap()
}

#[test]
fn text_and_binary_hold_the_same_signal() {
    let (Some(text), Some(binary)) = (
        measured("Sample_UFF58_ascii.uff"),
        measured("Sample_UFF58b_bin.uff"),
    ) else {
        return;
    };
    let (text, binary) = (recording(&text), recording(&binary));
    assert_eq!(text.kind, FileKind::UFF);
    let (a, b) = (
        &text.recording.channels()[0],
        &binary.recording.channels()[0],
    );
    assert_eq!((a.samples.len(), b.samples.len()), (79_292, 79_292));
    assert_eq!((a.name.as_str(), &a.unit), ("Mic 01", &Unit::Pascal));
    // Six digits of text: half of the last one is 5e-6 of a mantissa of 1.
    for (a, b) in a.samples.iter().zip(&b.samples) {
        assert!((a - b).abs() <= 5.1e-6 * b.abs(), "{a} {b}");
    }
    // The sum that pyuff 2.5.8 finds, in another order of summation.
    assert!((b.samples.iter().sum::<f64>() - 5.715_040_058_740_556).abs() < 1e-9);
    assert!((text.recording.rate().hz() * 1.52588e-5 - 1.0).abs() < 1e-12);
}

#[test]
fn an_uneven_psd_is_what_the_file_says() {
    let Some(path) = measured("sample_dataset58_psd.uff") else {
        return;
    };
    let functions = parse(&std::fs::read(&path).unwrap()).unwrap();
    let psd = &functions[0];
    assert_eq!(
        (psd.kind, psd.data.len(), psd.promised),
        (UffKind::Psd, 3201, 3201)
    );
    let UffAbscissa::List(places) = &psd.abscissa else {
        unreachable!("uneven");
    };
    assert_eq!((places[1], places[3200]), (1.0, 3200.0));
    assert_eq!(psd.ordinate_axis.unit, "g²/Hz");
    assert_eq!(psd.date(), "13-Apr-23 09:57:51");
    let UffData::Complex(values) = &psd.data else {
        unreachable!("complex");
    };
    let sum: Complex<f64> = values.iter().sum();
    assert!((sum.re - 0.313_069_255_390_254_43).abs() < 1e-12 && sum.im == 0.0);
    let refused = read_recording(&path, &ReadOptions::default()).unwrap_err();
    assert!(
        refused.to_string().contains("1 × power spectral density"),
        "{refused}"
    );
}

#[test]
fn headers_that_trap() {
    if let Some(path) = measured("non_ascii_header.uff") {
        let function = &parse(&std::fs::read(&path).unwrap()).unwrap()[0];
        assert_eq!(function.kind, UffKind::FrequencyResponse);
        assert_eq!(function.ordinate_axis.unit, "(1/N)*(m/s²)");
        let document = read_transfer(&path).unwrap();
        assert_eq!(document.real[1], -5.99924e-2);
        assert_eq!(document.imaginary[5], 2.93363);
        assert_eq!(
            (&document.drive_unit, &document.response_unit),
            (&Unit::Newton, &Unit::MetrePerSecondSquared)
        );
        assert_eq!(document.coherence, [1.0; 6]);
        let warning = &document.about.warnings[0];
        assert!(
            matches!(warning.kind(), Some(RecordingWarning::Guessed { what }) if what.contains("no coherence"))
        );
        assert!(holds_transfer(&path));
    }
    if let Some(path) = measured("binary8byte.uff") {
        let contents = recording(&path);
        let channel = &contents.recording.channels()[0];
        assert_eq!(
            (channel.samples.len(), channel.name.as_str()),
            (250, "sine 5 Hz")
        );
        assert!((contents.recording.rate().hz() - 100.0).abs() < 1e-9);
        for (k, sample) in channel.samples.iter().enumerate() {
            let sine = 9.80665 * (0.1 * std::f64::consts::PI * k as f64).sin();
            // Its 5 Hz are 5 Hz to a few 1e-6 only.
            assert!((sample - sine).abs() < 1e-4, "{k}: {sample} {sine}");
        }
        assert_eq!(contents.recording.about.warnings, []);
        assert!(!holds_transfer(&path));
    }
    if let Some(path) = measured("dataset_milestone_in_header.uff") {
        let bytes = std::fs::read(&path).unwrap();
        let function = &parse(&bytes).unwrap()[0];
        assert_eq!(function.reference.direction, 0);
        assert_eq!(function.reference.node, -1);
        assert_eq!((function.data.len(), function.promised), (42, 2_508_876));
        let warnings = recording(&path).recording.about.warnings;
        assert!(
            warnings[0].to_string().contains("2508876 samples"),
            "{warnings:?}"
        );
    }
    if let Some(path) = measured("TestLab 161 164 18 15 82.uff") {
        let refused = read_recording(&path, &ReadOptions::default()).unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("only datasets 15, 18, 82, 151, 164"),
            "{refused}"
        );
    }
}

/// The lines of `(re+imj)` in which a measured response is kept beside the universal files.
fn complex_lines(path: &Path) -> Vec<Complex<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| {
            let line = line.trim().trim_matches(['(', ')']).trim_end_matches('j');
            let sign = line
                .char_indices()
                .rev()
                .find(|(at, c)| matches!(c, '+' | '-') && *at > 0 && !line[..*at].ends_with('e'))
                .unwrap()
                .0;
            Complex::new(line[..sign].parse().unwrap(), line[sign..].parse().unwrap())
        })
        .collect()
}

fn document(response: &[Complex<f64>], rate_hz: f64) -> TransferDocument {
    let lines = response.len();
    let step_hz = rate_hz / (2 * (lines - 1)) as f64;
    TransferDocument {
        drive_unit: Unit::FullScale,
        response_unit: Unit::MetrePerSecondSquared,
        estimator: Estimator::H2,
        known_input: false,
        identities: None,
        effective_averages: Some(37.5),
        excited_hz: None,
        impact: None,
        confidence: None,
        attempts: Vec::new(),
        distortion: None,
        measured_for: None,
        averages: 40,
        rate_hz: Some(SampleRate::new(rate_hz).unwrap()),
        about: About::new(
            Condition {
                participant: Some("P 07; left".into()),
                load_n: Some(Newtons(0.2)),
                angle_deg: Some(Degrees(15.0)),
                ..Condition::default()
            },
            Provenance::default(),
        ),
        drive: None,
        frequency_hz: (0..lines).map(|k| k as f64 * step_hz).collect(),
        real: response.iter().map(|h| h.re).collect(),
        imaginary: response.iter().map(|h| h.im).collect(),
        coherence: (0..lines).map(|k| 1.0 / (1.0 + 0.001 * k as f64)).collect(),
    }
}

fn made() -> TransferDocument {
    let mut random = Lcg(3);
    let mut next = || (random.below(2_000_001) as f64 - 1e6) * 1e-9;
    let response: Vec<Complex<f64>> = (0..257).map(|_| Complex::new(next(), next())).collect();
    document(&response, 10_000.0 / 3.0)
}

fn assert_same(read: &TransferDocument, written: &TransferDocument, rtol: f64) {
    let close = |a: &[f64], b: &[f64]| {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= rtol * b.abs(), "{a} {b}");
        }
    };
    close(&read.real, &written.real);
    close(&read.imaginary, &written.imaginary);
    close(&read.coherence, &written.coherence);
    // The rate that stands beside the short step gives it back.
    assert_eq!(read.frequency_hz, written.frequency_hz);
    assert_eq!(read.rate_hz, written.rate_hz);
    assert_eq!(read.about.condition, written.about.condition);
    assert_eq!(read.estimator, written.estimator);
    assert_eq!(read.averages, written.averages);
    assert_eq!(read.drive_unit, written.drive_unit);
    assert_eq!(read.response_unit, written.response_unit);
    assert_eq!(read.about.warnings, written.about.warnings);
}

#[test]
fn measured_responses_come_back_from_both_forms() {
    let folder = tempfile::tempdir().unwrap();
    for k in 1..=3 {
        let Some(path) = measured(&format!("meas_point_{k}.txt")) else {
            return;
        };
        let written = document(&complex_lines(&path), 2000.0);
        for (format, rtol) in [
            // 13 digits of text; all bits of a double.
            (TransferFormat::UffText, 5.1e-13),
            (TransferFormat::UffBinary, 0.0),
        ] {
            let file = folder.path().join(format!("{k}.uff"));
            write_transfer_as(&file, &written, format).unwrap();
            assert_same(&read_transfer(&file).unwrap(), &written, rtol);
        }
    }
}

#[test]
fn what_is_written_is_read_and_becomes_a_transfer_function() {
    let folder = tempfile::tempdir().unwrap();
    let written = made();
    let file = folder.path().join("tf.unv");
    write_transfer(&file, &written).unwrap();
    assert!(std::fs::read(&file).unwrap().starts_with(b"    -1"));
    let read = read_transfer(&file).unwrap();
    assert_same(&read, &written, 5.1e-13);
    let function = read
        .function::<piezotact::quantity::Drive, piezotact::quantity::Acceleration>(&file)
        .unwrap();
    assert_eq!(function.response().len(), 257);

    let functions = parse(&std::fs::read(&file).unwrap()).unwrap();
    assert_eq!(functions.len(), 2);
    assert_eq!(functions[1].kind, UffKind::Coherence);
    assert_eq!(functions[0].ordinate_axis.unit, "m/s^2");
    assert_eq!(functions[0].denominator_axis.unit, "FS");
    assert_eq!(functions[0].response.to_string(), "RESPONSE:1");

    let mut long = made();
    long.about.condition.participant = Some("P".repeat(80));
    let refused = write_transfer(&file, &long).unwrap_err().to_string();
    assert!(refused.contains("80 characters"), "{refused}");
    let mut torn = made();
    torn.coherence.pop();
    assert!(write_transfer(&file, &torn).is_err());
    // A refused write leaves the file that was there.
    assert!(read_transfer(&file).is_ok());
}

/// What `golden/uff.py` computes too: 17 lines of simple fractions.
fn golden() -> TransferDocument {
    let mut golden = document(&[Complex::default(); 17], 1000.0);
    for k in 0..17 {
        golden.real[k] = 1.0 / (1 + k) as f64;
        golden.imaginary[k] = -(k as f64) / 16.0;
        golden.coherence[k] = 1.0 / (1.0 + k as f64 / 64.0);
    }
    golden
}

/// pyuff 2.5.8 has read these files (see `golden/uff.py`), and written the other two that are read here.
#[test]
fn files_are_those_that_pyuff_reads_and_its_own_are_read() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let folder = tempfile::tempdir().unwrap();
    for (name, encoding) in [
        ("transfer.uff", UffEncoding::Text),
        ("transfer_binary.uff", UffEncoding::Binary),
    ] {
        let file = folder.path().join(name);
        write_uff(&file, &golden(), encoding).unwrap();
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::copy(&file, kept.join(name)).unwrap();
        }
        assert_eq!(
            std::fs::read(&file).unwrap(),
            std::fs::read(kept.join(name)).unwrap(),
            "{name}: UPDATE_GOLDEN=1 writes it again; then run golden/uff.py"
        );
    }
    for (name, rtol) in [("pyuff.uff", 5.1e-12), ("pyuff_binary.uff", 0.0)] {
        let read = read_transfer(&kept.join(name)).unwrap();
        let golden = golden();
        for (a, b) in [
            (&read.real, &golden.real),
            (&read.imaginary, &golden.imaginary),
            (&read.coherence, &golden.coherence),
            (&read.frequency_hz, &golden.frequency_hz),
        ] {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() <= rtol * b.abs(), "{name}: {a} {b}");
            }
        }
        assert_eq!(read.response_unit, Unit::MetrePerSecondSquared);
        assert_eq!((read.drive_unit, read.real.len()), (Unit::Newton, 17));
        assert_eq!(read.about.warnings, []);
    }
}

/// One dataset of text: `kind` with `values` and an abscissa of its own.
fn dataset(kind: u8, header: &str, axes: &str, body: &str) -> String {
    format!(
        "    -1\n    58\nline 1\nNONE\nNONE\nNONE\nNONE\n{kind:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}\n{header}\n{axes}{body}\n    -1\n",
        0, 0, 0, "plate", 4, -3, "hammer", 2, 3
    )
}

fn axes(abscissa: (u8, &str), ordinate: &str, over: &str) -> String {
    let axis = |quantity: u8, unit: &str| {
        format!(
            "{quantity:10}{:5}{:5}{:5} {:20} {unit:20}\n",
            0, 0, 0, "NONE"
        )
    };
    axis(abscissa.0, abscissa.1) + &axis(0, ordinate) + &axis(0, over) + &axis(0, "NONE")
}

#[test]
fn a_response_above_0_hz_is_filled_below_and_an_uneven_one_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let read = |text: String| {
        std::fs::write(&path, text).unwrap();
        read_transfer(&path)
    };
    let hz = |unit| axes((18, unit), "g", "N");
    let header = |start: f64, step: f64| {
        format!(
            "{:10}{:10}{:10}{start:13.5E}{step:13.5E}{:13.5E}",
            6, 3, 1, 0.0
        )
    };
    let body = " 1.0E+00 0.0E+00 2.0D+00 -1.0D+00\n 3.0E+00 1.0E+00";
    let coherence = |points: &str| {
        dataset(
            6,
            &header(10.0, 5.0).replacen("6", "4", 1),
            &hz("Hz"),
            points,
        )
    };
    let text = dataset(4, &header(10.0, 5.0), &hz("Hz"), body) + &coherence("0.5 0.6 0.7");
    let document = read(text).unwrap();
    assert_eq!(document.frequency_hz, [0.0, 5.0, 10.0, 15.0, 20.0]);
    assert_eq!(document.coherence, [0.0, 0.0, 0.5, 0.6, 0.7]);
    assert_eq!(document.real[..2], [0.0, 0.0]);
    assert!((document.real[3] - 2.0 * 9.80665).abs() < 1e-12);
    assert!((document.imaginary[3] + 9.80665).abs() < 1e-12);
    assert_eq!(document.drive_unit, Unit::Newton);
    assert_eq!(
        document.about.warnings.len(),
        1,
        "{:?}",
        document.about.warnings
    );
    // Its fifth id line is not ours: nothing is read off the others.
    assert_eq!(document.averages, 0);

    let khz = read(dataset(4, &header(0.0, 0.5), &hz("kHz"), body)).unwrap();
    assert_eq!(khz.frequency_hz, [0.0, 500.0, 1000.0]);
    assert!(
        khz.about.warnings[0]
            .to_string()
            .contains("assumed to be 1")
    );

    for (text, part) in [
        (
            dataset(4, &header(12.0, 5.0), &hz("Hz"), body),
            "from 12 Hz in steps of 5 Hz",
        ),
        (
            dataset(4, &header(1e9, 5.0), &hz("Hz"), body),
            "export it from 0 Hz",
        ),
        (
            dataset(4, &header(0.0, 5.0), &hz("s"), body),
            "over frequency",
        ),
        (
            dataset(4, &header(0.0, 5.0), &hz("Hz"), " 1.0 2.0 3.0 4.0"),
            "3 frequency lines, as the header states",
        ),
        (dataset(4, &header(0.0, -5.0), &hz("Hz"), body), "increases"),
        (
            dataset(4, &header(0.0, 5.0), &hz("Hz"), body)
                + &dataset(4, &header(0.0, 5.0), &hz("Hz"), body),
            "several (plate:4:-Z over hammer:2:+Z",
        ),
        (coherence("0.5 0.6 0.7"), "1 × coherence"),
        (
            dataset(
                4,
                &header(0.0, 0.0).replacen("         1", "         0", 1),
                &hz("Hz"),
                " 0.0 1.0 0.0 1.0 1.0 0.0 5.0 1.0 0.0",
            ),
            "1 Hz in line 1",
        ),
    ] {
        let refused = read(text).unwrap_err().to_string();
        assert!(refused.contains(part), "{part}: {refused}");
        assert!(refused.contains(';'), "{refused}");
    }
}

#[test]
fn several_time_responses_are_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let header = format!(
        "{:10}{:10}{:10}{:13.5E}{:13.5E}{:13.5E}",
        2, 3, 1, 0.0, 1e-3, 0.0
    );
    let mut text = dataset(
        1,
        &header,
        &axes((17, "s"), "mN", "NONE"),
        " 1.0 2.0 3.0 0.0",
    );
    text += "    -1\n  2411\n  anything -1\n    -1\n";
    text += &dataset(
        1,
        &header,
        &axes((17, "s"), "NONE", "NONE"),
        "  1.00000-200  2.00000E+00 -3.00000E+00",
    );
    std::fs::write(&path, &text).unwrap();
    let contents = recording(&path);
    let channels = contents.recording.channels();
    assert_eq!(channels[0].unit, Unit::Newton);
    assert!((channels[0].samples[2] - 3e-3).abs() < 1e-15);
    assert_eq!(channels[0].samples.len(), 3);
    assert_eq!(channels[1].name, "plate 2");
    assert_eq!(channels[1].samples[0], 1e-200);
    assert_eq!(
        contents.recording.about.warnings,
        [Warning::from(RecordingWarning::Uncalibrated {
            channel: "plate 2".into()
        })]
    );
    // A time signal that calls itself a frequency response.
    let strange = dataset(4, &header, &axes((17, "s"), "g", "NONE"), " 1.0 2.0 3.0");
    std::fs::write(&path, strange).unwrap();
    let warnings = recording(&path).recording.about.warnings;
    assert!(
        warnings[0]
            .to_string()
            .contains("frequency response but has a time axis"),
        "{warnings:?}"
    );
    assert!(!holds_transfer(&path));
    let longer = header.replacen("         3", "         4", 1);
    text += &dataset(
        1,
        &longer,
        &axes((17, "s"), "N", "NONE"),
        " 1.0 2.0 3.0 4.0",
    );
    std::fs::write(&path, &text).unwrap();
    let refused = read_recording(&path, &ReadOptions::default()).unwrap_err();
    assert!(
        refused.to_string().contains("4 values of plate"),
        "{refused}"
    );
}

#[test]
fn either_order_of_bytes_and_every_width() {
    let values = [0.5_f64, -1.25, 3.0, 1e-3, 7.0, -0.125];
    let header = |data: u8, points: usize, even: u8| {
        format!(
            "{data:10}{points:10}{even:10}{:13.5E}{:13.5E}{:13.5E}",
            0.0, 1.0, 0.0
        )
    };
    for (data, even, per_point) in [
        (2, 1, 1),
        (4, 1, 1),
        (5, 1, 2),
        (6, 1, 2),
        (4, 0, 2),
        (6, 0, 3),
    ] {
        for order in [1, 2] {
            let text = dataset(
                4,
                &header(data, 6 / per_point, even),
                &axes((18, "Hz"), "g", "N"),
                "DATA",
            );
            let (before, after) = text.split_once("DATA\n").unwrap();
            let mut bytes = before
                .replacen(
                    "    58",
                    &format!("    58b     {order}     2          11          48"),
                    1,
                )
                .into_bytes();
            for value in values {
                let single = data == 2 || data == 5;
                let mut put = if single {
                    (value as f32).to_le_bytes().to_vec()
                } else {
                    value.to_le_bytes().to_vec()
                };
                if order == 2 {
                    put.reverse();
                }
                bytes.extend(put);
            }
            bytes.extend(after.as_bytes());
            let function = &parse(&bytes).unwrap()[0];
            assert_eq!(function.data.len(), 6 / per_point);
            match (&function.data, &function.abscissa) {
                (UffData::Real(found), UffAbscissa::Even { .. }) => {
                    assert!((found[3] - 1e-3).abs() < 1e-9);
                }
                (UffData::Real(found), UffAbscissa::List(places)) => {
                    assert_eq!((found[0], places[1]), (-1.25, 3.0));
                }
                (UffData::Complex(found), UffAbscissa::Even { .. }) => {
                    assert_eq!(found[0], Complex::new(0.5, -1.25));
                }
                (UffData::Complex(found), UffAbscissa::List(places)) => {
                    assert_eq!((found[1], places[0]), (Complex::new(7.0, -0.125), 0.5));
                }
            }
        }
    }
}

/// Every truncation and thousands of flipped bytes: an error that says what to do, or values, never a panic.
#[test]
fn damage_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.uff");
    let mut small = made();
    for column in [
        &mut small.frequency_hz,
        &mut small.real,
        &mut small.imaginary,
        &mut small.coherence,
    ] {
        column.truncate(9);
    }
    for encoding in [UffEncoding::Text, UffEncoding::Binary] {
        write_uff(&file, &small, encoding).unwrap();
        let bytes = std::fs::read(&file).unwrap();
        let look = |bytes: &[u8]| match parse(bytes) {
            Err(error) => assert!(error.to_string().contains(';'), "{error}"),
            Ok(functions) => assert!(!functions.is_empty()),
        };
        // Cut anywhere but in the blanks after the last mark, something is missing: split files are refused, or
        // hold the whole frequency response and no coherence.
        for length in 0..bytes.len() {
            look(&bytes[..length]);
        }
        let mut random = Lcg(5);
        let mut damaged = bytes.clone();
        for round in 0..6000 {
            let at = random.below(bytes.len());
            damaged[at] = random.below(256) as u8;
            look(&damaged);
            if round % 100 == 0 {
                std::fs::write(&file, &damaged).unwrap();
                let _either = read_transfer(&file);
                let _or = read_recording(&file, &ReadOptions::default());
            }
            if round % 3 == 0 {
                damaged.clone_from(&bytes);
            }
        }
    }
    let huge = "    -1\n    58b     1     2          11  99999999\n\n\n\n\n\n    1\n         2 999999999         1\n\n\n\n\nabc";
    let refused = parse(huge.as_bytes()).unwrap_err().to_string();
    assert!(
        refused.contains("an evenly spaced abscissa") || refused.contains("999999999 values"),
        "{refused}"
    );
}

#[test]
fn time_signals_are_written_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.uff");
    let channel = |name: &str, unit, phase: f64| Channel {
        name: name.into(),
        unit,
        samples: (0..1001)
            .map(|i| 3.7 * (f64::from(i) * 0.1 + phase).sin())
            .collect(),
    };
    let original = Recording::new(
        vec![
            channel("nail acceleration", Unit::MetrePerSecondSquared, 0.0),
            channel("drive", Unit::FullScale, 1.0),
        ],
        SampleRate::new(48_000.0).unwrap(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    let losses = write_uff_recording(&path, &original).unwrap();
    assert!(losses[0].to_string().contains("condition"), "{losses:?}");
    assert!(!holds_transfer(&path));
    let back = recording(&path).recording;
    assert_eq!(back.rate(), original.rate());
    for (a, b) in back.channels().iter().zip(original.channels()) {
        assert_eq!(
            (&a.name, &a.unit, a.samples.len()),
            (&b.name, &b.unit, 1001)
        );
        for (a, b) in a.samples.iter().zip(&b.samples) {
            // Thirteen digits.
            assert!((a - b).abs() <= 5.1e-13 * b.abs(), "{a} {b}");
        }
    }
    let long = channel(&"x".repeat(81), Unit::Newton, 0.0);
    let long = Recording::new(
        vec![long],
        original.rate(),
        Condition::default(),
        Provenance::default(),
    );
    let error = write_uff_recording(&path, &long.unwrap())
        .unwrap_err()
        .to_string();
    assert!(error.contains("a name of a channel"), "{error}");
}
