//! `verify` with what its report shows beside the measurement that is judged, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::support::{BENCH, Done, Folder, RENDER, noise, prepared, results, wav};
use serde_json::Value;

const RATE_HZ: f64 = 5000.0;

/// What is shown only where it was asked for: its caption, and the option that asks.
const AMPLITUDES: &str = "Amplitude spectra (FFT) of target and measurement within";
const BESIDE_SPECTRA: &str = "PSDs of the texture and of the drive computed from it";
const BESIDE_WAVEFORMS: &str = "The drive is shifted earlier by";
const STRAIGHT: &str = "PSDs of the target and of the target filtered by the transfer function";
const ALSO: &str = "PSDs of the target and of all measurements";
const BEFORE: &str = "PSDs before and after";

fn table(columns: &str, values: &[f64]) -> String {
    let rows = values.iter().enumerate();
    let rows = rows.map(|(i, v)| format!("{},{v:.9}\n", i as f64 / RATE_HZ));
    format!("time (s),{columns}\n{}", rows.collect::<String>())
}

fn split(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// What a sensor reads of `delivered`: without noise it would be a copy, which is no measurement.
fn sensed(delivered: &[f64]) -> Vec<f64> {
    let read = delivered.iter().enumerate();
    read.map(|(i, v)| v + 2e-3 * (0.37 * (i * i) as f64).sin())
        .collect()
}

fn verify(folder: &Folder, rest: &str) -> Done {
    folder.run(&split(&format!("verify {rest}")))
}

fn html(folder: &Folder, rest: &str) -> String {
    // A report is written whatever the verdict.
    let done = verify(folder, &format!("{rest} --report r.html"));
    assert!(matches!(done.code(), Some(0 | 3 | 4 | 5)), "{}", done.err());
    std::fs::read_to_string(folder.path("r.html")).unwrap()
}

fn expect_shown(html: &str, shown: &[&str], not: &[&str]) {
    for caption in shown {
        assert!(html.contains(caption), "the report lacks `{caption}`");
    }
    for caption in not {
        assert!(!html.contains(caption), "the report holds `{caption}`");
    }
}

/// A texture of 2 m/s² full scale, rendered with one transfer function and with another, and played to one finger.
fn two_measured() -> Folder {
    let folder = prepared();
    folder.write("texture.wav.json", r#"{"full_scale": "2 m/s2"}"#);
    let other = "characterise --bench twin:participant=5,seed=7 --seconds 10 --out other.json";
    folder.run(&split(other)).expect_success();
    for (transfer, name) in [("tf.json", "own"), ("other.json", "foreign")] {
        let render = format!("render texture.wav --transfer {transfer} --out {name}.wav");
        folder.run(&split(&render)).expect_success();
        let play = format!("play {name}.wav --bench {BENCH} --record {name}.parquet");
        folder.run(&split(&play)).expect_success();
    }
    folder
}

#[test]
fn a_report_shows_what_it_was_given_and_nothing_else() {
    let folder = two_measured();
    // A measurement alone says nothing of a drive.
    let felt = noise(20_000).map(|v| 2.0 * v).collect::<Vec<f64>>();
    folder.write("own.csv", table("nail (m/s2)", &sensed(&felt)));
    let plain = html(&folder, "--target texture.wav --measured own.csv");
    let given = [BESIDE_SPECTRA, BESIDE_WAVEFORMS, STRAIGHT, ALSO, BEFORE];
    expect_shown(&plain, &[AMPLITUDES], &given);
    for computed in [
        "flat-top window over segments of 8192 samples (1.64 s",
        "divided by the sum of the window",
        "amplitude, m/s²",
    ] {
        assert!(plain.contains(computed), "{computed}");
    }
    let base = "--target texture.wav --measured own.parquet";
    let with_drive = [AMPLITUDES, BESIDE_SPECTRA, BESIDE_WAVEFORMS];
    expect_shown(&html(&folder, base), &with_drive, &[STRAIGHT, ALSO, BEFORE]);
    let straight = html(&folder, &format!("{base} --transfer tf.json"));
    expect_shown(
        &straight,
        &[STRAIGHT, "computed, not measured"],
        &[ALSO, BEFORE],
    );
    let also = html(&folder, &format!("{base} --also foreign.parquet"));
    expect_shown(&also, &[ALSO, ">foreign.parquet<"], &[STRAIGHT, BEFORE]);
    // The warnings about it is said of it, in the report and in the console.
    let also_said = verify(&folder, &format!("{base} --also foreign.parquet"));
    assert!(also_said.err().contains("warning: foreign.parquet: "));
    assert!(
        also_said.out().contains("foreign.parquet: not passed"),
        "{}",
        also_said.out()
    );
    assert!(
        also.contains("P05"),
        "the report does not say whom it was rendered for"
    );
    let before = html(&folder, &format!("{base} --before texture.wav"));
    expect_shown(
        &before,
        &[BEFORE, "the target does not state what it was made from"],
        &[STRAIGHT, ALSO],
    );
    // The drive of a file is moved by the modelling delay that it was rendered with.
    folder.write("felt.csv", table("nail (m/s2)", &sensed(&felt)));
    let from_file = "--target texture.wav --measured felt.csv --drive own.wav";
    let shown = html(&folder, from_file);
    expect_shown(&shown, &with_drive, &[STRAIGHT]);
    assert!(shown.contains("shifted earlier by 250.0 ms: the modelling delay"));
}

/// Each further measurement has the numbers of a verification of its own, and the verdict is that of the first.
#[test]
fn further_measurements_are_verified_in_the_same_way() {
    let folder = two_measured();
    let base = "--target texture.wav --json --measured";
    let (alone, alone_code) = verify(&folder, &format!("{base} foreign.parquet")).json_and_code();
    assert_eq!(alone_code, Some(3), "{}", alone["verdict"]);
    // `json` expects success: the exit code is that of --measured.
    let both = verify(
        &folder,
        &format!("{base} own.parquet --also foreign.parquet"),
    )
    .json();
    let mut also = both["also"][0].clone();
    let fields = also.as_object_mut().unwrap();
    assert_eq!(fields.remove("file").unwrap(), "foreign.parquet");
    let mut bare = alone.clone();
    for name in ["schema", "version", "invocation"] {
        bare.as_object_mut().unwrap().remove(name);
    }
    assert_eq!(also, bare);
    let mut first = results(both.clone());
    first.as_object_mut().unwrap().remove("also");
    assert_eq!(
        first,
        results(verify(&folder, &format!("{base} own.parquet")).json())
    );
    let swapped = verify(
        &folder,
        &format!("{base} foreign.parquet --also own.parquet"),
    );
    assert_eq!(swapped.code(), Some(3));
    // Files of one name are told apart, and many are shown.
    std::fs::create_dir(folder.path("day2")).unwrap();
    std::fs::copy(folder.path("own.parquet"), folder.path("day2/own.parquet")).unwrap();
    let many = "own.parquet --also day2/own.parquet --also foreign.parquet --also own.parquet";
    let names = verify(&folder, &format!("{base} {many}")).json();
    let names: Vec<&Value> = names["also"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| &v["file"])
        .collect();
    assert_eq!(
        names,
        ["day2/own.parquet", "foreign.parquet", "own.parquet (2)"]
    );
    html(&folder, &format!("--target texture.wav --measured {many}"));
}

/// A device with a direct path and an echo five samples later: its transfer function is known, so are the error and the
/// correlation of a texture that is sent straight to it.
#[test]
fn the_texture_sent_straight_has_the_error_that_it_must_have() {
    let folder = Folder::new();
    let texture: Vec<f64> = noise(40_000).collect();
    folder.write("texture.csv", table("nail (m/s2)", &texture));
    folder.write("felt.csv", table("nail (m/s2)", &sensed(&texture)));
    let (direct, echo, later) = (0.8, 0.6, 5.0);
    let resolution_hz = RATE_HZ / 4096.0;
    let hz: Vec<f64> = (0..=2048).map(|k| f64::from(k) * resolution_hz).collect();
    let turn = |hz: f64| -TAU * hz * later / RATE_HZ;
    let list = |value: &dyn Fn(f64) -> f64| hz.iter().map(|hz| value(*hz)).collect::<Vec<f64>>();
    let function = serde_json::json!({
        "frequency_hz": hz,
        "real": list(&|hz| direct + echo * turn(hz).cos()),
        "imaginary": list(&|hz| echo * turn(hz).sin()),
        "coherence": list(&|_| 1.0),
        "rate_hz": RATE_HZ,
        "drive_unit": "FS",
        "response_unit": "m/s²",
    });
    folder.write("tf.json", function.to_string());
    let base = "--target texture.csv --measured felt.csv --transfer tf.json --band 30..500";
    let found =
        verify(&folder, &format!("{base} --json")).json()["uncompensated_predicted"].clone();
    let number = |key: &str| found[key].as_f64().unwrap();
    // |H|² = a² + b² + 2ab·cos φ at the lines of the comparison, from the definition of the error.
    let lines = (0..513).map(|k| f64::from(k) * RATE_HZ / 1024.0);
    let gains_db: Vec<f64> = lines
        .filter(|hz| (30.0..=500.0).contains(hz))
        .map(|hz| direct * direct + echo * echo + 2.0 * direct * echo * turn(hz).cos())
        .map(|power| 10.0 * power.log10())
        .collect();
    let mean_db = gains_db.iter().sum::<f64>() / gains_db.len() as f64;
    let squares = gains_db.iter().map(|db| (db - mean_db).powi(2));
    let error_db = (squares.sum::<f64>() / gains_db.len() as f64).sqrt();
    assert!(error_db > 1.0, "{error_db}");
    // 0.05 dB: segments see H through the window's 5 Hz, and noise between its own lines.
    assert!(
        (number("error_db_rms_level_matched") - error_db).abs() < 0.05,
        "{found} {error_db}"
    );
    assert!(
        (number("level_difference_db") - mean_db).abs() < 0.05,
        "{found} {mean_db}"
    );
    assert_eq!(found["band_hz"], serde_json::json!([30.0, 500.0]));
    // The same filter in time, sample by sample, as a measurement of its own.
    let at = |i: usize| if i < 5 { 0.0 } else { echo * texture[i - 5] };
    let filtered: Vec<f64> = (0..texture.len())
        .map(|i| direct * texture[i] + at(i))
        .collect();
    folder.write("filtered.csv", table("nail (m/s2)", &filtered));
    let rest = "--target texture.csv --measured filtered.csv --band 30..500 --json";
    let (in_time, _) = verify(&folder, rest).json_and_code();
    for key in ["error_db_rms_level_matched", "waveform_correlation"] {
        let apart = number(key) - in_time[key].as_f64().unwrap();
        assert!(apart.abs() < 5e-3, "{key}: {apart}");
    }
    let report = html(&folder, base);
    let said = format!("{:.2} dB", number("error_db_rms_level_matched"));
    assert!(report.contains(&said), "the report lacks {said}");
    // Where the transfer function says nothing, that is said, and the verification is done all the same.
    let short = serde_json::json!({
        "frequency_hz": [0.0, 10.0, 20.0], "real": [1.0, 1.0, 1.0], "imaginary": [0.0, 0.0, 0.0],
        "coherence": [1.0, 1.0, 1.0], "rate_hz": RATE_HZ, "drive_unit": "FS", "response_unit": "m/s²",
    });
    folder.write("tf.json", short.to_string());
    let said = verify(&folder, &format!("{base} --json")).json();
    let said = said["uncompensated_predicted"]["not_computed"].to_string();
    assert!(said.contains("30–500 Hz"), "{said}");
    html(&folder, base);
}

/// The exchange of levels of two textures: one shape at another height, with what was done.
#[test]
fn a_swap_of_level_shows_as_the_same_shape_at_another_height() {
    let folder = two_measured();
    let loud: Vec<f64> = noise(20_000)
        .zip(noise(20_001).skip(1))
        .map(|(a, b)| 3.0 * (a + b))
        .collect();
    folder.write("loud.csv", table("nail (m/s2)", &loud));
    let swap = "manipulate texture.wav --rms-of loud.csv --out swapped.wav --json";
    let done = folder.run(&split(swap)).json();
    // A measurement of one's own that is the target.
    let ratio = done["rms_after"].as_f64().unwrap() / done["rms_before"].as_f64().unwrap();
    let felt: Vec<f64> = noise(20_000).map(|v| 2.0 * ratio * v).collect();
    folder.write("felt.csv", table("nail (m/s2)", &sensed(&felt)));
    let base = "--target swapped.wav --measured felt.csv --before texture.wav --before loud.csv";
    let said = verify(&folder, &format!("{base} --json")).json();
    let number = |i: usize, key: &str| said["before"][i][key].as_f64().unwrap();
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-4;
    assert!(close(
        number(0, "rms_before"),
        done["rms_before"].as_f64().unwrap()
    ));
    assert!(close(
        number(0, "rms_after"),
        done["rms_after"].as_f64().unwrap()
    ));
    assert!((number(0, "level_db") - 20.0 * ratio.log10()).abs() < 1e-3);
    assert!(number(0, "shape_error_db_rms") < 1e-3, "{said}");
    // The other one has the level and another shape.
    assert!(number(1, "level_db").abs() < 1e-3 && number(1, "shape_error_db_rms") > 0.5);
    let report = html(&folder, base);
    for part in [
        "source of the target",
        "one of its properties was used",
        "rms of loud.csv",
        "texture.wav, ",
        " m/s² rms",
    ] {
        assert!(report.contains(part), "the report lacks {part}");
    }
    folder.write("unrelated.csv", table("nail (m/s2)", &loud));
    let report = html(&folder, &format!("{base} --before unrelated.csv"));
    assert!(report.contains("not named in the processing steps"));
}

/// A target that was made from one stroke of a recording is compared with that stroke.
#[test]
fn a_texture_before_may_be_one_stroke() {
    let folder = Folder::new();
    let record = "twin record --bench acttouch --sample S8 --participant 3 --speed 30mm/s --strokes 3 --out S8.parquet";
    folder.run(&split(record)).expect_success();
    let make = "manipulate S8.parquet --stroke 2 --gain -6dB --out made.wav";
    folder.run(&split(make)).expect_success();
    let base = "--target made.wav --measured made.wav --band 30..500 --before S8.parquet";
    // A copy is compared, and decides nothing.
    let done = verify(&folder, &format!("{base} --before-stroke 2 --json"));
    let (said, code) = done.json_and_code();
    assert_eq!(code, Some(5));
    let before = &said["before"][0];
    assert!(
        (before["level_db"].as_f64().unwrap() + 6.0).abs() < 1e-3,
        "{before}"
    );
    assert!(
        before["shape_error_db_rms"].as_f64().unwrap() < 1e-3,
        "{before}"
    );
    // Without it all of the recording is taken, and that is said.
    let (whole, _) = verify(&folder, &format!("{base} --json")).json_and_code();
    assert!(
        whole["warnings"]
            .to_string()
            .contains("including gesture and pauses")
    );
    verify(&folder, &format!("{base} --before-stroke 9"))
        .expect_failure(1, &["S8.parquet", "from 1 to 3", "--before-stroke 9"]);
}

#[test]
fn what_cannot_be_shown_beside_it_is_refused() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2"]].concat())
        .expect_success();
    let play = format!("play drive.wav --bench {BENCH} --record m.parquet");
    folder.run(&split(&play)).expect_success();
    folder.write("texture.wav.json", r#"{"full_scale": "2 m/s2"}"#);
    let whole: Vec<f64> = noise(20_000).map(|v| 2.0 * v).collect();
    folder.write("short.csv", table("nail (m/s2)", &whole[..600]));
    folder.write("half.csv", table("nail (m/s2)", &whole[..12_000]));
    folder.write("silent.csv", table("nail (m/s2)", &[0.0; 20_000]));
    folder.write("force.csv", table("press (N)", &whole));
    folder.write(
        "two.csv",
        table("nail (m/s2),palm (m/s2)", &whole)
            .replace('\n', ",0\n")
            .replacen(",0\n", "\n", 1),
    );
    folder.write("slow.wav", wav(noise(4_000), 1_000));
    folder.write("slow.wav.json", r#"{"full_scale": "2 m/s2"}"#);
    folder.write("fine.wav", wav(noise(40_000), 10_000));
    folder.write("fine.wav.json", r#"{"full_scale": "2 m/s2"}"#);
    let base = "--target texture.wav --measured m.parquet --report r.html";
    for (rest, code, parts) in [
        (
            "--also absent.parquet",
            1,
            &["absent.parquet", "no such file"][..],
        ),
        (
            "--also silent.csv",
            1,
            &["silent.csv", "the measurement has no signal"],
        ),
        (
            "--also short.csv",
            1,
            &[
                "short.csv",
                "expected 1024 samples",
                "target and measurement, found",
            ],
        ),
        ("--also force.csv", 1, &["force.csv", "m/s²"]),
        ("--also slow.wav", 2, &["20–1000 Hz", "500 Hz"]),
        ("--before absent.wav", 1, &["no such file: absent.wav"]),
        ("--before force.csv", 1, &["force.csv", "m/s²"]),
        (
            "--before two.csv",
            1,
            &["two.csv", "nail [m/s²], palm [m/s²]"],
        ),
        ("--before silent.csv", 1, &["silent.csv"]),
        (
            "--before short.csv",
            1,
            &["short.csv", "1024 samples, found 600"],
        ),
        (
            "--before slow.wav",
            2,
            &["slow.wav", "20–1000 Hz", "500 Hz"],
        ),
        (
            "--before texture.wav --before-stroke 0",
            2,
            &["--before-stroke"],
        ),
        ("--also r.html", 2, &["r.html", "would be replaced"]),
    ] {
        verify(&folder, &format!("{base} {rest}")).expect_failure(code, parts);
        assert!(!folder.path("r.html").exists(), "{rest} left a report");
    }
    // What is shorter is compared as far as it goes, and what has another rate at the lower one: both are said.
    let said = verify(
        &folder,
        &format!("{base} --also half.csv --also fine.wav --json"),
    )
    .json();
    let warnings = |i: usize| said["also"][i]["warnings"].to_string();
    assert!(warnings(0).contains("\"cut\""), "{}", warnings(0));
    assert!(warnings(1).contains("rate_converted"), "{}", warnings(1));
    verify(
        &folder,
        &format!("{base} --before two.csv --before-channel nail"),
    )
    .expect_success();
}

/// Half of the power of the target lies above what the measurement can hold, and at the lower scale nobody feels either.
#[test]
fn what_a_lower_rate_leaves_out_and_what_is_not_felt_is_said() {
    let folder = Folder::new();
    let tone = |hz: f64, rate_hz: u32| {
        let each = (0..4 * rate_hz).map(move |i| f64::from(i) / f64::from(rate_hz));
        each.map(move |t_s| 0.4 * (TAU * hz * t_s).sin())
    };
    let both = tone(100.0, 10_000).zip(tone(3000.0, 10_000));
    folder.write(
        "target.wav",
        wav(both.map(|(low, high)| low + high), 10_000),
    );
    let kept = tone(100.0, 5_000).zip(noise(20_000));
    folder.write(
        "measured.wav",
        wav(kept.map(|(v, noise)| v + 1e-3 * noise), 5_000),
    );
    let unfelt = "neither the target nor the measurement reaches the detection threshold";
    for (scale, is_felt) in [("10m/s2", true), ("0.001m/s2", false)] {
        let line = format!("--target target.wav --measured measured.wav --scale {scale}");
        let done = verify(&folder, &line);
        let said = done.out();
        assert!(
            said.contains("with 50 % of the power of the whole texture"),
            "{said}"
        );
        assert_eq!(said.contains(unfelt), !is_felt, "{said}");
        assert!(jnd_of_the_whole(&said) < 1.0, "nobody feels 3 kHz: {said}");
    }
}

/// The difference from the whole texture that the conclusion states, JND.
fn jnd_of_the_whole(said: &str) -> f64 {
    let from = "whole texture, from which the measurement differs by ";
    let (_, rest) = said.split_once(from).unwrap_or_else(|| panic!("{said}"));
    let (jnd, _) = rest.split_once(" JND").unwrap();
    jnd.parse().unwrap()
}

/// The strongest line of a texture lies below the band of its drive. "Passed, 0.14 JND" did not say that the texture is another one. A drive that was
/// rendered in a wider band is compared in it: the line is judged.
#[test]
fn a_line_below_the_band_of_the_drive_is_a_difference_from_the_whole_texture() {
    let folder = prepared();
    let tone = |i: usize| (TAU * 16.0 * i as f64 / RATE_HZ).sin();
    let whole = noise(20_000).enumerate();
    let whole: Vec<f64> = whole.map(|(i, v)| 0.3 * v + 1.5 * tone(i)).collect();
    folder.write("whole.csv", table("acc (m/s2)", &whole));
    for (name, band) in [("usual", ""), ("wide", "--band 12..1000 --level fit")] {
        let render = format!("render whole.csv --transfer tf.json {band} --out {name}.wav");
        folder.run(&split(&render)).expect_success();
        let play = format!("play {name}.wav --bench {BENCH} --record {name}.parquet");
        folder.run(&split(&play)).expect_success();
    }
    let base = "--target whole.csv --measured usual.parquet";
    let said = verify(&folder, base).out();
    assert!(said.contains("over 20–1000 Hz"), "{said}");
    assert!(jnd_of_the_whole(&said) > 1.0, "{said}");
    expect_shown(&html(&folder, base), &["whole texture"], &[]);
    let wide = "--target whole.csv --measured wide.parquet --json";
    let (wide, _) = verify(&folder, wide).json_and_code();
    assert_eq!(wide["band_hz"], serde_json::json!([12.0, 1000.0]));
}
