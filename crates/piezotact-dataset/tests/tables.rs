//! Tables as laboratories have them, in text and in Parquet. The Parquet files are those of `golden/tables.py`.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::{Path, PathBuf};

use piezotact::quantity::Unit;
use piezotact::recording::Recording;
use piezotact_dataset::{ReadError, ReadOptions, read_recording};

use crate::shared_data::shared;

fn read_file(path: &Path, options: &ReadOptions) -> Result<Recording, ReadError> {
    read_recording(path, options).map(|contents| contents.recording)
}

fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Recording, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    std::fs::write(&path, bytes).unwrap();
    read_file(&path, options)
}

fn read(text: &str) -> Recording {
    read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden/tables")
        .join(name)
}

/// A force in g is a weight: no acceleration, and no vibration.
#[test]
fn a_force_in_grams_is_in_newtons() {
    for (unit, newtons) in [("g", 0.5), ("cN", 0.509_86), ("kg", 500.0)] {
        let mut text = format!("time (s),fz ({unit}),acc (g)\n");
        for row in 0..20 {
            text += &format!("{},50.986,1\n", f64::from(row) / 100.0);
        }
        let recording = read(&text);
        let channels = recording.channels();
        assert_eq!(channels[0].unit, Unit::Newton, "{unit}");
        assert!((channels[0].samples[3] - newtons).abs() < 1e-4 * newtons);
        assert_eq!(channels[1].unit, Unit::MetrePerSecondSquared);
    }
}

/// A clock that jumps by more samples than can be counted: an error with the step.
#[test]
fn a_clock_that_jumps_beyond_all_bounds_is_refused() {
    for last in ["9e18", "1e30", "1e99"] {
        let mut text = "time (s),acc (g)\n".to_owned();
        for row in 0..200 {
            text += &format!("{},1\n", f64::from(row) / 1000.0);
        }
        text += &format!("{last},1\n{last},1\n");
        let refused = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap_err();
        assert!(
            refused.to_string().contains("steps of about 0.001"),
            "{refused}"
        );
    }
}

/// Steps of 64 to 96 ms fit no grid: the recording lasts as long as its times do.
#[test]
fn times_that_fit_no_grid_have_their_mean_step() {
    let Some(path) = shared("data/vibration/finger_force/force_data_1.csv") else {
        return;
    };
    let recording = read_file(&path, &ReadOptions::default()).unwrap();
    let step_s = 1.0 / recording.rate().hz();
    assert!((step_s - 0.080_97).abs() < 5e-6, "{step_s}");
    assert!(said(&recording).contains("evenly sampled"));
}

/// Titles, headers and dates as laboratories have them: the rate and the start.
#[test]
fn titles_headers_and_dates_of_laboratories() {
    let rows = |row: &dyn Fn(u32) -> String| (0..40).map(row).collect::<String>();
    let ms = |k: u32| format!("{:.3}", f64::from(k) / 1000.0);
    let plain = rows(&|k| format!("{k}.0,1.0\n"));
    let comma = rows(&|k| format!("{k},0;1,0\n"));
    let timed = rows(&|k| format!("{},1.0\n", ms(k)));
    let excel = rows(&|k| format!("{:.11},{},1.0\n", 45_000.5 + f64::from(k) / 86.4e6, ms(k)));
    let dated = rows(&|k| format!("2024-03-01,10:22:33,{},1.0\n", ms(k)));
    for (text, hz, start) in [
        (
            format!("\"Sample rate [Hz]: 2.000,0\"\nacc (g);f (N)\n{comma}"),
            2000.0,
            None,
        ),
        (
            format!("Sample rate,\"2,000 Hz\"\nacc (g),f (N)\n{plain}"),
            2000.0,
            None,
        ),
        (
            format!("Sample rate: 60000 samples/min\nacc (g),f (N)\n{plain}"),
            1000.0,
            None,
        ),
        (
            format!("Start: 12/31/2023 10:22:33\nSample rate: 1 kHz\nacc (g),f (N)\n{plain}"),
            1000.0,
            Some("2023-12-31T10:22:33.0"),
        ),
        (format!("# time (s),acc (m·s⁻²)\n{timed}"), 1000.0, None),
        (
            format!("\"time; elapsed (s)\",\"acc; nail (g)\"\n{timed}")
                .replace("time; elapsed", "time"),
            1000.0,
            None,
        ),
        (format!("time (s),\"acc; x; y (g)\"\n{timed}"), 1000.0, None),
        (
            format!("Date,Elapsed (s),acc (g)\n{excel}"),
            1000.0,
            Some("2023-03-15T12:00:00"),
        ),
        (
            format!("Date,Time,Elapsed (s),acc (g)\n{dated}"),
            1000.0,
            Some("2024-03-01T10:22:33.0"),
        ),
    ] {
        let recording = read(&text);
        assert!((recording.rate().hz() - hz).abs() < 1e-6, "{text}");
        let found = recording
            .annotations
            .started_at
            .as_ref()
            .map(ToString::to_string);
        assert_eq!(
            found.as_deref().map(|at| &at[..19]),
            start.map(|at| &at[..19]),
            "{text}"
        );
        assert_eq!(
            recording.channels()[0].unit,
            Unit::MetrePerSecondSquared,
            "{text}"
        );
    }
    // Days of Excel alone are the time.
    let excel = rows(&|k| format!("{:.11},1.0\n", 45_000.5 + f64::from(k) / 86.4e6));
    let recording = read(&format!("Time,acc (g)\n{excel}"));
    assert!(
        (recording.rate().hz() - 1000.0).abs() < 1.0,
        "{}",
        recording.rate()
    );
    // A comma before three digits may be either sign where cells are not separated by commas.
    let text = format!("Sample rate: 2,000 Hz\nacc (g);f (N)\n{comma}");
    assert!(read_bytes(text.as_bytes(), &ReadOptions::default()).is_err());
}

/// A force cell whose file holds its potential: 1 V is 0.5 N.
#[test]
fn a_force_in_volts_is_calibrated() {
    let text = "time (s),Channel B (V),acc (g)\n0,2,1\n0.001,4,1\n0.002,6,1\n";
    let recording = read_bytes(text.as_bytes(), &stated(None, &[("Channel B", "0.5 N")])).unwrap();
    let channel = &recording.channels()[0];
    assert_eq!(
        (&channel.unit, channel.samples.as_slice()),
        (&Unit::Newton, &[1.0, 2.0, 3.0][..])
    );
    for (name, unit) in [("Channel B", "N"), ("acc", "0.5 N")] {
        let refused = read_bytes(text.as_bytes(), &stated(None, &[(name, unit)])).unwrap_err();
        assert!(
            refused.to_string().contains("as the file states it"),
            "{refused}"
        );
    }
}

/// The unit of a time column is stated as that of a channel is.
#[test]
fn the_unit_of_a_time_is_stated() {
    let rows: String = (0..40).map(|k| format!("{},1\n", 500 * k)).collect();
    let text = format!("t,acc (m/s2)\n{rows}");
    let recording = read_bytes(text.as_bytes(), &stated(None, &[("t", "us")])).unwrap();
    assert_eq!(
        (recording.rate().hz(), said(&recording).as_str()),
        (2000.0, "")
    );
    let text = text.replacen('t', "t (ms)", 1);
    let refused = read_bytes(text.as_bytes(), &stated(None, &[("t", "us")])).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("the unit of `t` as the file states it, ms"),
        "{refused}"
    );
}

fn said(recording: &Recording) -> String {
    let warnings = recording.about.warnings.iter();
    warnings.map(|one| format!("{one}\n")).collect()
}

/// Mean and standard deviation, as NumPy's `std()`.
fn spread(samples: &[f64]) -> (f64, f64) {
    let count = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let squares: f64 = samples.iter().map(|one| (one - mean).powi(2)).sum();
    (mean, (squares / count).sqrt())
}

fn stated(scale: Option<&str>, units: &[(&str, &str)]) -> ReadOptions {
    let units = units
        .iter()
        .map(|(name, unit)| ((*name).into(), (*unit).into()));
    ReadOptions {
        scale: scale.map(|scale| scale.parse().unwrap()),
        units: units.collect(),
        ..ReadOptions::default()
    }
}

#[test]
fn the_separator_that_excel_states_is_used() {
    let recording = read("sep=;\r\ntime (s);acc (m/s2)\r\n0,000;12,5\r\n0,001;-3,25\r\n");
    assert_eq!(recording.rate().hz(), 1000.0);
    assert_eq!(recording.channels()[0].samples, [12.5, -3.25]);
    let error = read_bytes(
        b"sep=;\ntime (s);acc (g)\n0;1\n0,1;x\n",
        &ReadOptions::default(),
    );
    assert!(error.unwrap_err().to_string().contains("`x` in row 4"));
}

#[test]
fn utf16_is_read_with_a_mark_and_without() {
    let text = "time (ms)\tKraft (N)\n0\t1,5\n1\t2,5\n";
    let units: Vec<u16> = text.encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    for bytes in [
        [&b"\xFF\xFE"[..], &little].concat(),
        [&b"\xFE\xFF"[..], &big].concat(),
        little,
        big,
    ] {
        let recording = read_bytes(&bytes, &ReadOptions::default()).unwrap();
        assert_eq!(recording.channels()[0].samples, [1.5, 2.5]);
        assert_eq!(recording.rate().hz(), 1000.0);
    }
}

#[test]
fn moments_are_times() {
    let rows = |row: &dyn Fn(u32) -> String| (0..80).map(row).collect::<String>();
    let ms = |k: u32| (f64::from(k) * 12.5).round() as u32;
    for (text, start) in [
        (
            format!(
                "time,x (g)\n{}",
                rows(&|k| format!("2024-03-01T10:22:33.{:03}Z,{k}\n", ms(k)))
            ),
            Some("2024-03-01T10:22:33.000Z"),
        ),
        (
            format!(
                "Datum;Uhrzeit;x (g)\n{}",
                rows(&|k| format!("01.03.2024;10:22:33,{:03};{k}\n", ms(k)))
            ),
            Some("2024-03-01T10:22:33.000"),
        ),
        (
            format!(
                "clock\tx (g)\n{}",
                rows(&|k| format!("10:22:33.{:03}\t{k}\n", ms(k)))
            ),
            None,
        ),
    ] {
        let recording = read(&text);
        assert_eq!(
            (recording.rate().hz(), recording.channels().len()),
            (80.0, 1),
            "{text}"
        );
        let started = recording.annotations.started_at.as_ref();
        assert_eq!(started.map(ToString::to_string).as_deref(), start);
        assert_eq!(said(&recording), "");
    }
    let odd = read_bytes(
        b"time,x\n2024-03-01 10:00:00,1\nlater,2\n",
        &ReadOptions::default(),
    );
    assert!(odd.unwrap_err().to_string().contains("`later` in row 3"));
}

#[test]
fn titles_above_the_header_are_said_and_their_rate_and_start_are_read() {
    let title = "Data file,finger.dxd\nStart time: 2024-03-01 10:22:33.5\nSample rate: 2 kHz\n\n";
    let recording = read(&format!("{title}acc,fz\nm/s2,N\n1,2\n3,4\n"));
    assert_eq!(recording.rate().hz(), 2000.0);
    assert_eq!(recording.channels()[1].unit, Unit::Newton);
    assert_eq!(recording.channels()[1].samples, [2.0, 4.0]);
    let started = recording.annotations.started_at.as_ref().unwrap();
    assert_eq!(started.to_string(), "2024-03-01T10:22:33.5");
    let warnings = said(&recording);
    assert!(
        warnings.contains("3 lines above the header") && warnings.contains("`Sample rate: 2 kHz`"),
        "{warnings}"
    );
    // The times of the table count before a rate that they do not have.
    let recording = read(&format!(
        "{title}time (s),acc (m/s2)\n0,1\n0.001,2\n0.002,3\n"
    ));
    assert_eq!(
        (recording.rate().hz(), recording.channels().len()),
        (1000.0, 1)
    );
    assert!(said(&recording).contains("gives 1000 Hz: the second was used"));
    // A single column.
    let recording = read("Kraft im Versuch 3\nSampling rate [Hz]: 500\nfz (N)\n1\n2\n");
    assert_eq!((recording.rate().hz(), recording.len()), (500.0, 2));
    let error = read_bytes(
        b"Title\n\ntime (s),acc (g)\n0,1\n0.1,1\n0.2,x\n",
        &ReadOptions::default(),
    );
    assert!(error.unwrap_err().to_string().contains("`x` in row 6"));
}

#[test]
fn units_come_by_channel_and_by_names_that_say_them() {
    let text = "t;acc;fz;Tz\n0,000;1;2;3\n0,001;1;2;3\n";
    let units = |options: &ReadOptions| {
        let recording = read_bytes(text.as_bytes(), options).unwrap();
        let channels = recording.channels().iter();
        let units: Vec<String> = channels
            .map(|c| format!("{} {}", c.samples[0], c.unit))
            .collect();
        (units.join(", "), said(&recording))
    };
    let (found, warnings) = units(&stated(None, &[]));
    assert_eq!(found, "1 no unit, 2 N, 3 no unit");
    assert!(
        warnings.contains("`fz` without a unit is read in N"),
        "{warnings}"
    );
    // A scale is that of channels that can have it.
    assert_eq!(
        units(&stated(Some("10 m/s2"), &[])).0,
        "10 m/s², 2 N, 3 no unit"
    );
    assert_eq!(
        units(&stated(Some("3 N"), &[])).0,
        "1 no unit, 6 N, 3 no unit"
    );
    let (found, _) = units(&stated(Some("1 g"), &[("fz", "2 mN"), ("Tz", "V")]));
    assert_eq!(found, "9.80665 m/s², 0.004 N, 3 V");
    let (_, warnings) = units(&stated(None, &[("fx", "N")]));
    assert!(
        warnings.contains("the unit of `fx` was not used"),
        "{warnings}"
    );
    let text = "time (s),fz (N)\n0,1\n1,2\n";
    let differs = read_bytes(text.as_bytes(), &stated(None, &[("fz", "mN")]));
    assert!(
        differs
            .unwrap_err()
            .to_string()
            .contains("the unit of `fz` as the file states it, N")
    );
}

/// A value that a device writes where it has none is none: its rows are lost ones.
#[test]
fn codes_of_overloads_are_no_data() {
    let value = |k: u32| {
        if (3..6).contains(&k) {
            -1e6
        } else {
            f64::from(k)
        }
    };
    let rows: String = (0..20)
        .map(|k| format!("{},{}\n", f64::from(k) / 10.0, value(k)))
        .collect();
    let recording = read(&format!("time (s),fz (mN)\n{rows}"));
    let samples = &recording.channels()[0].samples;
    assert!(
        samples
            .iter()
            .enumerate()
            .all(|(k, v)| (v - 1e-3 * k as f64).abs() < 1e-12),
        "{samples:?}"
    );
    assert_eq!(recording.about.provenance.losses.stretches_s, [[0.3, 0.6]]);
    assert!(said(&recording).contains("`fz` holds -1e6 in 3 rows from 0.300 s on"));
    // Values that come near it are values.
    let recording = read("time (s),x (Pa)\n0,1000000\n1,900000\n2,800000\n");
    assert_eq!(recording.channels()[0].samples[0], 1e6);
}

#[test]
fn parquet_of_other_programs_has_its_own_times() {
    let none = ReadOptions::default();
    let zstd = read_file(&kept("zstd.parquet"), &none).unwrap();
    assert_eq!(
        (zstd.rate().hz(), zstd.channels().len(), zstd.len()),
        (80.0, 1, 40)
    );
    let last = 9.80665 * f64::from(39).mul_add(0.37, 0.0).sin();
    assert!((zstd.channels()[0].samples[39] - last).abs() < 1e-12);
    assert_eq!(said(&zstd), "");
    let moments = read_file(&kept("moments.parquet"), &none).unwrap();
    assert_eq!((moments.rate().hz(), moments.channels().len()), (80.0, 1));
    assert_eq!(moments.channels()[0].samples[..3], [-1.0, -0.999, -0.998]);
    let started = moments.annotations.started_at.as_ref().unwrap();
    assert_eq!(started.to_string(), "2024-03-01T10:22:33.25Z");
    let text = read_file(&kept("text.parquet"), &none).unwrap();
    assert_eq!((text.rate().hz(), text.channels().len()), (80.0, 1));
    let error = read_file(&kept("brotli.parquet"), &none)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("Snappy, zstd, gzip, found BROTLI"),
        "{error}"
    );
    // A stated rate does not make the time a channel.
    let rate = ReadOptions {
        rate: piezotact::quantity::SampleRate::new(40.0).ok(),
        ..ReadOptions::default()
    };
    let slower = read_file(&kept("zstd.parquet"), &rate).unwrap();
    assert_eq!((slower.rate().hz(), slower.channels().len()), (40.0, 1));
    assert!(said(&slower).contains("the time stamps give 80 Hz"));
}

/// A table, a MATLAB file and a Parquet file take their units, condition and start from a sidecar.
#[test]
fn sidecars_complete_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    std::fs::write(&path, "t;a;b\n0,000;1;2\n0,001;1;2\n").unwrap();
    let sidecar = r#"{"channels": ["acc", "fz"], "units": {"fz": "2 mN", "acc": "g"}, "condition": {"load_n": 0.4},
        "labels": {"session": "2"}}"#;
    std::fs::write(folder.path().join("a.csv.json"), sidecar).unwrap();
    let recording = read_file(&path, &ReadOptions::default()).unwrap();
    let [acc, fz] = recording.channels() else {
        panic!("two channels")
    };
    assert_eq!((acc.name.as_str(), acc.samples[0]), ("acc", 9.80665));
    assert_eq!(
        (fz.name.as_str(), fz.samples[0], &fz.unit),
        ("fz", 4e-3, &Unit::Newton)
    );
    assert_eq!(
        recording.about.condition.load_n.map(|load| load.0),
        Some(0.4)
    );
    assert!(!said(&recording).contains("a.csv.json is not read"));
    std::fs::write(folder.path().join("a.csv.json"), r#"{"units": {"c": "N"}}"#).unwrap();
    let error = read_file(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("`units` of channels that the file has (a, b)"),
        "{error}"
    );
}

/// The files of the issue, with the numbers of NumPy.
#[test]
fn files_of_laboratories_have_their_values() {
    let Some(cases) = shared("cases") else {
        return;
    };
    let none = ReadOptions::default();
    let close = |found: (f64, f64), wanted: (f64, f64)| {
        assert!(
            (found.0 - wanted.0).abs() < 0.01 && (found.1 - wanted.1).abs() < 0.05,
            "{found:?}"
        );
    };
    let excel = read_file(&cases.join("sep_line_excel.csv"), &none).unwrap();
    close(spread(&excel.channels()[0].samples), (12.34, 1060.7));
    let iso = read_file(&cases.join("iso_T_Z.csv"), &none).unwrap();
    assert_eq!(iso.rate().hz(), 80.0);
    let with = ReadOptions {
        rate: piezotact::quantity::SampleRate::new(1000.0).ok(),
        ..ReadOptions::default()
    };
    let zstd = read_file(&cases.join("rowgroups_zstd.parquet"), &with).unwrap();
    close(spread(&zstd.channels()[0].samples), (2.50, 8.73));
    let timed = read_file(&cases.join("time_col.parquet"), &none).unwrap();
    assert_eq!((timed.rate().hz(), timed.channels().len()), (1000.0, 2));
}
