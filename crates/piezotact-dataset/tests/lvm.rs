//! LabVIEW measurement files: measured ones, which lie beside the checkout, and variants made here.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use piezotact::recording::RecordingWarning;
use std::path::{Path, PathBuf};

use crate::support::Lcg;
use piezotact::Warning;
use piezotact::quantity::{Measure, SampleRate, Unit};
use piezotact::recording::Recording;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::cross_spectra;
use piezotact_dataset::lvm::parse_lvm;
use piezotact_dataset::{FileKind, ReadError, ReadOptions, read_recording};

fn measured(name: &str) -> Option<PathBuf> {
    shared_data::shared(&format!("data/frf/lvm/{name}"))
}

fn read(text: &[u8], options: &ReadOptions) -> Result<Recording, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.lvm");
    std::fs::write(&path, text).unwrap();
    read_recording(&path, options).map(|contents| contents.recording)
}

fn plain(text: &str) -> Result<Recording, ReadError> {
    read(text.as_bytes(), &ReadOptions::default())
}

fn warnings(recording: &Recording) -> String {
    let texts: Vec<String> = recording
        .about
        .warnings
        .iter()
        .map(Warning::to_string)
        .collect();
    texts.join("\n")
}

#[test]
fn twice_the_rows_that_the_header_promises() {
    let Some(path) = measured("long_single_header_multi_ch.lvm") else {
        return;
    };
    let contents = read_recording(&path, &ReadOptions::default()).unwrap();
    assert_eq!(contents.kind, FileKind::LVM);
    let recording = contents.recording;
    assert_eq!(recording.len(), 16_384);
    let text = warnings(&recording);
    assert!(
        text.contains("states 8192 samples and 16384 follow"),
        "{text}"
    );
    assert!(text.contains("0.000977"), "{text}");
    let names: Vec<&str> = recording
        .channels()
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names, ["F", "m_1", "m_2"]);
    assert!((recording.rate().hz() - 1.0 / 0.000977).abs() < 1e-9);
    let (_, force) = recording.raw(Some("F")).unwrap();
    assert!((force.samples()[0] - 0.052530 * 9.80665).abs() < 1e-12);
    let (_, response) = recording.raw(Some("m_1")).unwrap();

    // Hann segments of 1024 samples (1 Hz between lines), half overlapping: SciPy 1.17.1 finds 0.7595226 in
    // 10–400 Hz; the detrended segments and the order of summation leave less than 1e-9 between them.
    let spectra = cross_spectra(&force, &response, &WelchConfig::hann(1024)).unwrap();
    let band: Vec<f64> = (spectra.coherence().into_iter().enumerate())
        .filter(|(line, _)| (10.0..=400.0).contains(&(*line as f64 * spectra.resolution_hz)))
        .map(|(_, coherence)| coherence)
        .collect();
    assert_eq!(band.len(), 390);
    let mean = band.iter().sum::<f64>() / band.len() as f64;
    assert!((mean - 0.759_522_610_514_129_4).abs() < 1e-9, "{mean}");
}

#[test]
fn the_small_files_of_others() {
    for name in ["short.lvm", "short_new_line_end.lvm"] {
        let Some(path) = measured(name) else { return };
        let recording = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        assert_eq!(recording.len(), 10);
        assert!((recording.rate().hz() - 25_600.0).abs() < 1e-9);
        let [force, response] = recording.channels() else {
            unreachable!("two channels");
        };
        assert_eq!((&force.unit, force.samples[2]), (&Unit::Newton, 0.616905));
        assert_eq!(response.unit, Unit::MetrePerSecondSquared);
        assert_eq!(response.name, "Response (Trigger)");
        assert_eq!(recording.about.warnings, []);
    }
    let all = |name: &str, options: &ReadOptions| {
        measured(name).map(|path| read_recording(&path, options).map(|contents| contents.recording))
    };
    let none = ReadOptions::default();
    if let Some(read) = all("multi_time_column.lvm", &none) {
        let read = read.unwrap();
        assert!((read.rate().hz() - 51_200.0).abs() < 1e-6);
        assert_eq!(read.channels()[1].unit, Unit::MetrePerSecondSquared);
        assert!((read.channels()[1].samples[2] - 0.467541 * 9.80665).abs() < 1e-12);
        assert!(warnings(&read).contains("states 51200 samples and 3 follow"));
    }
    if let Some(read) = all("no_decimal_separator.lvm", &none) {
        let read = read.unwrap();
        assert_eq!((read.channels().len(), read.len()), (3, 4));
        assert!((read.rate().hz() - 4000.0).abs() < 1e-6);
        assert!((read.channels()[2].samples[1] + 0.005606 * 9.80665).abs() < 1e-12);
    }
    if let Some(read) = all("with_comments.lvm", &none) {
        let refused = read.unwrap_err().to_string();
        assert!(refused.contains("give --rate"), "{refused}");
        let stated = ReadOptions {
            rate: Some(SampleRate::new(1.0).unwrap()),
            ..ReadOptions::default()
        };
        let read = all("with_comments.lvm", &stated).unwrap().unwrap();
        assert_eq!((read.channels().len(), read.len()), (3, 9));
        assert!(
            warnings(&read).contains("9 row(s) carry a comment"),
            "{}",
            warnings(&read)
        );
        assert!(warnings(&read).contains("states 1 samples"));
    }
    if let Some(read) = all("with_empty_fields.lvm", &none) {
        let read = read.unwrap();
        let names: Vec<&str> = read.channels().iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["Dev0/Ai0", "Dev0/Ai2", "Dev0/Ai0 1"]);
        assert!((read.rate().hz() - 1000.0).abs() < 1e-6);
        assert!(
            warnings(&read).contains("Untitled, Untitled 1"),
            "{}",
            warnings(&read)
        );
        assert!(
            read.about
                .warnings
                .contains(&Warning::from(RecordingWarning::Uncalibrated {
                    channel: "Dev0/Ai0".into()
                }))
        );
    }
}

fn header(separator: &str, decimal: &str, columns: &str) -> String {
    let s = if separator == "Comma" { "," } else { "\t" };
    format!(
        "LabVIEW Measurement{s}\r\nSeparator{s}{separator}\r\nDecimal_Separator{s}{decimal}\r\nX_Columns{s}{columns}\r\n***End_of_Header***{s}\r\n{s}\r\n"
    )
}

fn segment(time: &str, x0: &str, rows: &str) -> String {
    format!(
        "Channels\t1\t\r\nSamples\t2\t\r\nDate\t2024/01/01\r\nTime\t{time}\r\nX_Dimension\tTime\r\nX0\t{x0}\r\nDelta_X\t0,5\r\n***End_of_Header***\t\r\nX_Value\tacc\tComment\r\n{rows}"
    )
}

#[test]
fn commas_between_columns() {
    let text = header("Comma", ".", "One")
        + "Channels,2\nSamples,3,3\nY_Unit_Label,mN,g\nX_Dimension,Time,Time\nDelta_X,0.1,0.1\n***End_of_Header***\nX_Value,a,b,Comment\n0.0,1.5,2,late, and long\n0.1,2.5,2\n0.2,3.5,2\n";
    let read = plain(&text).unwrap();
    assert!((read.rate().hz() - 10.0).abs() < 1e-9);
    assert!((read.channels()[0].samples[2] - 3.5e-3).abs() < 1e-15);
    assert!(
        warnings(&read).contains("`late  and long`") || warnings(&read).contains("`late and long`"),
        "{}",
        warnings(&read)
    );
}

#[test]
fn segments_join_where_nothing_is_missing() {
    let file = |second: &str, x0: &str| {
        header("Tab", ",", "No")
            + &segment("10:00:00,5", "0,0E+0", "\t1,5\r\n\t2,5\r\n\r\n")
            + &segment(second, x0, "\t3,5\r\n\t4,5\r\n")
    };
    for (time, x0) in [("10:00:01,5", "0,0"), ("10:00:00,5", "1,0")] {
        let read = plain(&file(time, x0)).unwrap();
        assert_eq!(read.channels()[0].samples, [1.5, 2.5, 3.5, 4.5]);
        assert!((read.rate().hz() - 2.0).abs() < 1e-12);
        // The time of the first sample by the computer's clock, in no zone that the file names.
        let start = read.annotations.started_at.map(|time| time.to_string());
        assert_eq!(start.as_deref(), Some("2024-01-01T10:00:00.5"));
    }
    // Samples that are missing between segments are lost ones, unless they are more than half of those that are there: a pause.
    let paused = plain(&file("10:00:02,5", "0,0")).unwrap();
    assert_eq!(paused.channels()[0].samples.len(), 6);
    assert_eq!(paused.channels()[0].samples[4..], [3.5, 4.5]);
    assert_eq!(paused.about.provenance.losses.stretches_s, [[1.0, 2.0]]);
    let paused = plain(&file("10:00:05,5", "0,0")).unwrap();
    assert_eq!(paused.channels()[0].samples, [1.5, 2.5]);
    assert!(warnings(&paused).contains("2 parts"));
    let second = ReadOptions {
        part: Some(2),
        ..ReadOptions::default()
    };
    let second = read(file("10:00:05,5", "0,0").as_bytes(), &second).unwrap();
    assert_eq!(second.channels()[0].samples, [3.5, 4.5]);
    let start = second.annotations.started_at.map(|time| time.to_string());
    assert_eq!(start.as_deref(), Some("2024-01-01T10:00:05.5"));
    // One scale for channels that name no unit.
    let scaled = ReadOptions {
        scale: Some("2 g".parse::<Measure>().unwrap()),
        rate: None,
        ..ReadOptions::default()
    };
    let read = read(file("10:00:01,5", "0,0").as_bytes(), &scaled).unwrap();
    assert!((read.channels()[0].samples[0] - 3.0 * 9.80665).abs() < 1e-12);
    assert_eq!(read.about.warnings, []);
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let of = |rows: &str| header("Tab", ",", "No") + &segment("1:0:0", "0", rows);
    for (text, part) in [
        (
            "LabVIEW Measurement\t\nSeparator\tTab\n".into(),
            "after the header of the file",
        ),
        (header("Tab", ",", "No"), "a segment with rows"),
        (header("Tab", ",", "No") + "Channels\t1\n", "a row of names"),
        (of(""), "rows of numbers"),
        (of("\t1,5\n\tabc\n"), "`abc` in row 17, column `acc`"),
        (of("\t1,5\n\t\n\t2,5\n"), "rows of numbers"),
        (of("\t1,5\n\t2,5\tx\t\t\n"), ""),
        (
            of("\t1,5\n").replace("Delta_X\t0,5", "Delta_X\t0"),
            "--rate",
        ),
        (
            of("\t1,5\n").replace("X_Dimension\tTime", "X_Dimension\tFrequency"),
            "Frequency",
        ),
        (
            of("\t1,5\n").replace("\tacc\tComment", "\tComment"),
            "names of channels",
        ),
    ] {
        match plain(&text) {
            Err(error) => {
                let error = error.to_string();
                assert!(!part.is_empty(), "{error}");
                assert!(
                    error.contains(part) || error.contains("header of a segment"),
                    "{part}: {error}"
                );
            }
            Ok(read) => assert!(part.is_empty(), "{part}: {read:?}"),
        }
    }
}

/// A small file of two segments.
pub(crate) fn small() -> String {
    header("Tab", ",", "No")
        + &segment("10:00:00,5", "0,0E+0", "\t1,5\tgood\r\n\t2,5\r\n\r\n")
        + &segment("10:00:01,5", "0,0", "\t3,5\r\n\t4,5\r\n")
}

/// Truncations and flipped bytes: an error that says what to do, or samples, never a panic.
#[test]
fn damage_is_an_error_and_no_panic() {
    let text = small();
    let look = |bytes: &[u8]| {
        if let Err(error) = parse_lvm(Path::new("a.lvm"), bytes, &ReadOptions::default()) {
            assert!(
                error.to_string().contains(';') || matches!(error, ReadError::Invalid { .. }),
                "{error}"
            );
        }
    };
    for length in 1..text.len() {
        look(&text.as_bytes()[..length]);
    }
    let mut random = Lcg(9);
    let mut damaged = text.clone().into_bytes();
    for round in 0..4000 {
        let at = random.below(damaged.len());
        damaged[at] = random.below(256) as u8;
        look(&damaged);
        if round % 3 == 0 {
            damaged = text.clone().into_bytes();
        }
    }
}

/// Two channels with a time column each, of 1 kHz and of 100 Hz from 0.2 s on, as `X_Columns Multi` writes them.
#[test]
fn channels_of_two_rates_keep_their_clocks() {
    let header = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nMulti_Headings\tYes\nX_Columns\tMulti\nTime_Pref\tAbsolute\n***End_of_Header***\t\n\t\n\
        Channels\t2\t\t\t\t\nSamples\t20\t\t3\t\t\nDate\t2024/03/01\t\t2024/03/01\t\t\nTime\t10:22:33.25\t\t10:22:33.25\t\t\n\
        Y_Unit_Label\tm/s2\t\tN\t\t\nX_Dimension\tTime\t\tTime\t\t\nX0\t0.0\t\t0.2\t\t\nDelta_X\t0.001\t\t0.01\t\t\n\
        ***End_of_Header***\t\t\t\t\t\nX_Value\tacc\tX_Value\tfz\tComment\n";
    let mut text = header.to_owned();
    for k in 0..20 {
        let slow = match k {
            0..=2 => format!("{:.2}\t{}", 0.2 + 0.01 * f64::from(k), k),
            _ => "\t".into(),
        };
        text.push_str(&format!(
            "{:.3}\t{}\t{slow}\t\n",
            0.001 * f64::from(k),
            k * 2
        ));
    }
    let recording = plain(&text).unwrap();
    let found: Vec<(f64, f64, usize)> = recording
        .channels_with_clocks()
        .map(|(c, clock)| {
            let hz = (clock.rate_hz.hz() * 1e6).round() / 1e6;
            (hz, clock.start_s.0, c.samples.len())
        })
        .collect();
    assert_eq!(found, [(1000.0, 0.0, 20), (100.0, 0.2, 3)]);
    assert!((recording.duration().0 - 0.23).abs() < 1e-9);
    let started = recording.annotations.started_at.as_ref().unwrap();
    assert_eq!(started.to_string(), "2024-03-01T10:22:33.25");
    let said = recording.require_one_clock(["acc", "fz"]).unwrap_err();
    assert!(
        said.to_string().contains("`fz` at 100 Hz from 0.2 s on"),
        "{said}"
    );
    // One rate cannot be stated for both.
    let rate = SampleRate::new(500.0).ok();
    let stated = read(
        text.as_bytes(),
        &ReadOptions {
            scale: None,
            rate,
            ..ReadOptions::default()
        },
    );
    let said = stated.unwrap_err().to_string();
    assert!(said.contains("2 sampling clocks"), "{said}");
}

/// The last number of a file that was cut: 12.3 of 12.345.
#[test]
fn a_last_number_that_was_cut_is_left_out() {
    let file = |last: &str| {
        let rows: String = (0..20)
            .map(|k| format!("{k}.000000\t{:.6}\n", f64::from(k) / 7.0))
            .collect();
        let header = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\nChannels\t1\nDelta_X\t0.1\t\n\
             ***End_of_Header***\t\nX_Value\tacc\tComment\n";
        plain(&format!("{header}{rows}{last}")).unwrap()
    };
    for last in ["20.000000\t12.3", "20.000000\t", "20.00"] {
        let read = file(last);
        assert_eq!(read.len(), 20, "{last}");
        assert!(
            warnings(&read).contains("row 30 has no end of line"),
            "{}",
            warnings(&read)
        );
    }
    for last in ["20.000000\t12.345678", "20.000000\t12.3\n"] {
        let read = file(last);
        assert_eq!(read.len(), 21);
        assert!(!warnings(&read).contains("no end of line"));
    }
}
