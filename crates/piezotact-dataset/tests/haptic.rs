//! Haptic files: clips of `NiceVibrations` with the conversions that it expects, an HJIF file of another program, what is
//! written here read back, and all of it damaged in thousands of ways. The files lie beside the checkout, in
//! `../shared/data`.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use piezotact::recording::RecordingWarning;
use std::path::{Path, PathBuf};

use crate::support::Lcg;
use piezotact::device::{DeviceDescription, DriveSetup};
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Measure, SampleRate, Unit, Volts};
use piezotact::series::Series;
use piezotact_dataset::haptic::{
    HapticKind, haptic_kind, parse_ahap, parse_haptic, parse_hjif, read_haptic, write_ahap,
    write_haptic, write_hjif,
};
use piezotact_dataset::{
    Contents, FileKind, ReadError, ReadOptions, holds_transfer, read_recording,
};
use piezotact_haptic::envelope::EnvelopeConfig;
use piezotact_haptic::{
    HapticClip, HapticMetadata, HjifTexture, ahap_of, clip_of, date_of, reference_device,
};
use serde_json::Value;

/// Single precision around 1: one step is 6e-8. Upstream's own tests use the same number.
const SINGLE: f64 = 1e-7;

fn clip_file(name: &str) -> Option<PathBuf> {
    shared_data::shared(&format!("data/haptic/haptic/{name}"))
}

fn hjif_file() -> Option<PathBuf> {
    shared_data::shared("data/haptic/hjif/0.hmpg")
}

fn parse(text: &str) -> Result<HapticClip, ReadError> {
    parse_haptic(Path::new("t.haptic"), text.as_bytes())
}

fn recording(path: &Path, options: &ReadOptions) -> Contents {
    read_recording(path, options).unwrap()
}

fn wobble(count: usize, rate_hz: f64) -> Series<Acceleration> {
    let samples = (0..count)
        .map(|i| {
            let t = i as f64 / rate_hz;
            (1.5 + (7.0 * t).sin()) * (std::f64::consts::TAU * 180.0 * t).sin()
        })
        .collect();
    Series::new(samples, SampleRate::new(rate_hz).unwrap()).unwrap()
}

fn metres(value: f64) -> Measure {
    Measure {
        value,
        unit: Unit::MetrePerSecondSquared,
    }
}

/// The farthest that two JSON values lie apart; what is no number must be equal, with the same fields in any order.
fn apart(ours: &Value, theirs: &Value, place: &str) -> f64 {
    match (ours, theirs) {
        (Value::Object(a), Value::Object(b)) => {
            let names = |map: &serde_json::Map<String, Value>| {
                map.keys()
                    .cloned()
                    .collect::<std::collections::BTreeSet<_>>()
            };
            assert_eq!(names(a), names(b), "{place}");
            a.iter()
                .map(|(name, value)| apart(value, &b[name], &format!("{place}.{name}")))
                .fold(0.0, f64::max)
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter()
                .zip(b)
                .enumerate()
                .map(|(i, (a, b))| apart(a, b, &format!("{place}[{i}]")))
                .fold(0.0, f64::max)
        }
        (Value::Number(a), Value::Number(b)) => (a.as_f64().unwrap() - b.as_f64().unwrap()).abs(),
        _ => {
            assert_eq!(ours, theirs, "{place}");
            0.0
        }
    }
}

/// Its makers let the control points of a later curve carry the time of the pattern. Apple's format says "relative to the parameter
/// curve's start time", as its own files have it: an iPhone would play such a curve late, by the time at which it begins.
fn as_apple_counts(pattern: &mut Value) {
    for entry in pattern["Pattern"].as_array_mut().unwrap() {
        if let Some(curve) = entry.get_mut("ParameterCurve") {
            let begins = curve["Time"].as_f64().unwrap();
            for point in curve["ParameterCurveControlPoints"].as_array_mut().unwrap() {
                point["Time"] = (point["Time"].as_f64().unwrap() - begins).into();
            }
        }
    }
}

#[test]
fn every_clip_converts_to_what_its_makers_expect() {
    let folder = tempfile::tempdir().unwrap();
    for (clip, expected) in [
        ("2_points.haptic", "2_points.ahap"),
        ("3_points.haptic", "3_points.ahap"),
        ("16_points.haptic", "16_points.ahap"),
        ("17_points.haptic", "17_points.ahap"),
        ("long_clip.haptic", "long_clip.ahap"),
        (
            "valid_v1_multiple_emphasis.haptic",
            "valid_v1_multiple_transients.ahap",
        ),
    ] {
        let (Some(clip), Some(expected)) = (clip_file(clip), clip_file(expected)) else {
            return;
        };
        let pattern = ahap_of(&read_haptic(&clip).unwrap());
        let written = folder.path().join("t.ahap");
        write_ahap(&written, &pattern.content).unwrap();
        let ours: Value = serde_json::from_slice(&std::fs::read(&written).unwrap()).unwrap();
        let mut theirs: Value = serde_json::from_slice(&std::fs::read(&expected).unwrap()).unwrap();
        as_apple_counts(&mut theirs);
        let far = apart(&ours, &theirs, "");
        assert!(far <= SINGLE, "{}: {far}", clip.display());
        assert!(!pattern.losses.is_empty());
    }
}

#[test]
fn ahap_files_are_read_and_wrong_fields_named() {
    for name in [
        "ahap_from_valid_v0.ahap",
        "ahap_from_valid_v0_from_dsp.ahap",
        "ahap_from_valid_v1.ahap",
        "ahap_from_valid_v1_required.ahap",
        "studio_export.ahap",
        "valid_fields.ahap",
        "valid_required.ahap",
    ] {
        let Some(path) = clip_file(name) else { return };
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(haptic_kind(&bytes), Some(HapticKind::Ahap));
        parse_ahap(&path, &bytes).unwrap();
        let refused = read_recording(&path, &ReadOptions::default()).unwrap_err();
        assert!(refused.to_string().contains("AHAP"), "{refused}");
    }
    let Some(path) = clip_file("invalid_fields.ahap") else {
        return;
    };
    let error = parse_ahap(&path, &std::fs::read(&path).unwrap())
        .unwrap_err()
        .to_string();
    for part in [
        "invalid_fields.ahap",
        "`ParameterCurves`",
        "`ParameterCurve`",
        "line 2",
    ] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn what_is_wrong_with_a_clip_is_named_with_its_place() {
    let v1 = |amplitude: &str, frequency: &str| {
        format!(
            r#"{{"version": {{"major": 1, "minor": 0, "patch": 0}}, "signals": {{"continuous": {{"envelopes":
            {{"amplitude": {amplitude}, "frequency": {frequency}}}}}}}}}"#
        )
    };
    let v0 = |voices: &str, duration: f64| {
        format!(r#"{{"metadata": {{"duration": {duration}}}, "voices": {voices}}}"#)
    };
    for (text, parts) in [
        (v1("[]", "null"), &["no breakpoint of amplitude"][..]),
        (
            v1(r#"[{"time": -0.5, "amplitude": 0}]"#, "null"),
            &["a time from 0", "-0.5", "breakpoint 0 of the amplitude"],
        ),
        (
            v1(
                r#"[{"time": 0, "amplitude": 0}, {"time": 1, "amplitude": 1.2}]"#,
                "null",
            ),
            &["from 0 to 1", "1.2", "breakpoint 1"],
        ),
        (
            v1(
                r#"[{"time": 1, "amplitude": 0}, {"time": 0.5, "amplitude": 0}]"#,
                "null",
            ),
            &["not before 1 s", "0.5"],
        ),
        (
            v1(
                r#"[{"time": 0, "amplitude": 0.8, "emphasis": {"amplitude": 0.2, "frequency": 0}}]"#,
                "null",
            ),
            &["at least the amplitude 0.8", "0.2"],
        ),
        (
            v1(
                r#"[{"time": 0, "amplitude": 0}]"#,
                r#"[{"time": 0, "frequency": -0.1}]"#,
            ),
            &["a frequency from 0 to 1", "frequency envelope"],
        ),
        (
            v1(r#"[{"time": 0}]"#, "null"),
            &["missing field `amplitude`", "line"],
        ),
        (
            v1(r#"[{"time": "0", "amplitude": 0}]"#, "null"),
            &["invalid type"],
        ),
        (
            r#"{"version": {"major": 1}, "signal": {}}"#.into(),
            &["missing field `signals`"],
        ),
        (
            r#"{"version": {"major": 2}, "signals": {}}"#.into(),
            &["version 0 or 1", "2.0.0"],
        ),
        (
            v0(r#"{"envelopes": [], "transients": []}"#, 1.0),
            &["amplitude", "none"],
        ),
        (
            v0(
                r#"{"envelopes": [[{"time": 2, "amplitude": 0}]], "transients": []}"#,
                1.0,
            ),
            &["within the stated duration", "2 s in 1 s"],
        ),
        (
            v0(
                r#"{"envelopes": [[{"time": 0, "amplitude": 0}]], "transients": [[{"time": 0, "amplitude": 1}]]}"#,
                1.0,
            ),
            &["a frequency for every transient", "[1]"],
        ),
    ] {
        let error = parse(&text).unwrap_err().to_string();
        let says_what_to_do = error.contains(';') || error.contains(": export it again");
        assert!(says_what_to_do, "{error}");
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

#[test]
fn a_clip_of_version_0_becomes_one_of_version_1() {
    let clip = parse(
        r#"{"version": {"major": 0, "minor": 2, "patch": 0}, "metadata": {"editor": "E", "duration": 2.0}, "voices":
        {"envelopes": [[{"time": 0, "amplitude": 0.1}, {"time": 1, "amplitude": 0.5}],
                       [{"time": 0, "amplitude": 0.3}]],
         "transients": [[{"time": 0.5, "amplitude": 1}, {"time": 1, "amplitude": 0.4}],
                        [{"time": 0.5, "amplitude": 0.2}, {"time": 1, "amplitude": 0.9}]]}}"#,
    )
    .unwrap();
    let points = clip.envelopes.amplitude();
    let read: Vec<(f64, f64)> = points.iter().map(|p| (p.time_s, p.amplitude)).collect();
    assert_eq!(read, [(0.0, 0.1), (1.0, 0.5), (2.0, 0.5)]);
    let emphasis = points[1].emphasis.unwrap();
    assert_eq!((emphasis.amplitude, emphasis.frequency), (0.5, 0.9));
    assert_eq!(clip.envelopes.frequency().len(), 1);
    assert_eq!(clip.metadata.editor, "E");
    let warnings: Vec<String> = clip.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings[0].contains("1 of 2 transients"), "{warnings:?}");
    assert!(warnings[1].contains("raised"), "{warnings:?}");
}

#[test]
fn clips_come_back_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.haptic");
    let x = wobble(16_000, 8000.0);
    let config = EnvelopeConfig::texture().unwrap();
    let metadata = HapticMetadata {
        editor: "piezotact".into(),
        description: "µ".into(),
        ..HapticMetadata::default()
    };
    let shares = x.samples().iter().map(|v| v / 2.5).collect();
    let shares = Series::<Drive>::new(shares, x.rate()).unwrap();
    let made = clip_of(&shares, &metres(2.5), &config, metadata, ".haptic").unwrap();
    let said: Vec<String> = made.losses.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 3);
    for (said, part) in said
        .iter()
        .zip(["the waveform", "Hz", "--scale \"2.5 m/s²\""])
    {
        assert!(said.contains(part), "{said}");
    }
    write_haptic(&path, &made.content).unwrap();
    assert_eq!(read_haptic(&path).unwrap(), made.content);
    for name in ["17_points.haptic", "valid_v1_multiple_emphasis.haptic"] {
        let Some(original) = clip_file(name) else {
            return;
        };
        let clip = read_haptic(&original).unwrap();
        write_haptic(&path, &clip).unwrap();
        assert_eq!(read_haptic(&path).unwrap(), clip);
    }
    // As a target: the level is back, in the unit that was stated.
    assert!(!holds_transfer(&path));
    write_haptic(&path, &made.content).unwrap();
    let options = ReadOptions {
        scale: Some(metres(2.5)),
        rate: None,
        ..ReadOptions::default()
    };
    let contents = recording(&path, &options);
    assert_eq!(contents.kind, FileKind::HAPTIC_CLIP);
    let back = contents.recording.series::<Acceleration>(None).unwrap();
    assert_eq!(back.rate().hz(), 8000.0);
    assert_eq!(back.samples().len(), 16_000);
    // Envelopes 40 ms apart of a level that swings in 0.9 s.
    assert!(
        (back.rms() / x.rms() - 1.0).abs() < 0.02,
        "{} {}",
        back.rms(),
        x.rms()
    );
    let plain = recording(&path, &ReadOptions::default()).recording;
    assert_eq!(plain.channels()[0].unit, Unit::FullScale);
    assert!(
        plain
            .about
            .warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(RecordingWarning::Uncalibrated { .. })))
    );
}

#[test]
fn hjif_of_another_program_is_read_and_its_departures_are_named() {
    let Some(path) = hjif_file() else { return };
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(haptic_kind(&bytes), Some(HapticKind::Hjif));
    assert!(!holds_transfer(&path));
    let file = parse_hjif(&path, &bytes).unwrap();
    let bands = &file.perceptions[0].channels[0].bands;
    assert_eq!(bands.len(), 2);
    assert_eq!(bands[1].effects[0].keyframes.as_ref().unwrap().len(), 1026);
    // It was written by a program that follows a draft.
    let departures = file.departures();
    assert_eq!(departures.len(), 6, "{departures:#?}");
    for part in [
        "the version is ``",
        "the date is ``",
        "`mixing_weight`, as drafts wrote it",
        "a band of type Curve has a `block_length`",
        "`block_length` of a band of wavelets is no whole number",
        "a band of type WaveletWave has a `curve_type`",
    ] {
        assert!(
            departures.iter().any(|d| d.contains(part)),
            "{departures:#?}"
        );
    }
    let contents = recording(&path, &ReadOptions::default());
    assert_eq!(contents.kind, FileKind::HJIF);
    let played = &contents.recording;
    // 1024 samples at the upper limit of the band, 1000 Hz.
    assert_eq!((played.rate().hz(), played.len()), (8000.0, 8193));
    let peak = played.channels()[0]
        .samples
        .iter()
        .fold(0.0f64, |p, v| p.max(v.abs()));
    assert!((0.1..1.5).contains(&peak), "{peak}");
    let warnings: Vec<String> = played
        .about
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect();
    assert!(
        warnings
            .iter()
            .any(|d| d.contains("departs from ISO/IEC 23090-31")),
        "{warnings:?}"
    );
    // What is written again holds the same.
    let again: Value = serde_json::to_value(&file).unwrap();
    let original: Value = serde_json::from_slice(&bytes).unwrap();
    assert!(apart(&again, &original, "") < 1e-7);
}

fn texture() -> HjifTexture {
    let set = DeviceDescription::drv2667().at_usual_gain();
    let setup = DriveSetup::new(set, Volts(1.4), Some(80e-9)).unwrap();
    HjifTexture {
        description: "S8 at 30 mm/s".into(),
        date: date_of(1_736_899_200),
        full_scale: metres(2.5),
        device: reference_device(
            Some(&setup),
            Some(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()),
            Some(180.0),
        ),
    }
}

#[test]
fn our_hjif_conforms_and_holds_the_waveform() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let x = wobble(80_000, 8000.0);
    let shares: Vec<f64> = x.samples().iter().map(|v| v / 2.5).collect();
    let shares = Series::<Drive>::new(shares, x.rate()).unwrap();
    let written = write_hjif(&path, &shares, &texture()).unwrap();
    assert_eq!(written.losses.len(), 3);
    let file = parse_hjif(&path, &std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(file, written.content);
    assert_eq!(file.departures(), Vec::<String>::new());
    let perception = &file.perceptions[0];
    assert_eq!(perception.perception_modality, "Vibrotactile Texture");
    let device = &perception.reference_devices[0];
    assert_eq!(device.kind.as_deref(), Some("Piezo"));
    assert_eq!(device.maximum_voltage, Some(75.0));
    assert_eq!(
        (device.minimum_frequency, device.maximum_frequency),
        (Some(20.0), Some(1000.0))
    );
    assert_eq!(device.resonance_frequency, Some(180.0));
    assert_eq!(file.date, "2025-01-15");
    assert_eq!(perception.channels[0].bands[0].effects.len(), 3);
    let options = ReadOptions {
        scale: Some(metres(2.5)),
        rate: None,
        ..ReadOptions::default()
    };
    let back = recording(&path, &options).recording;
    let back = back.series::<Acceleration>(None).unwrap();
    assert_eq!(back.samples().len(), 80_000);
    for (a, b) in back.samples().iter().zip(x.samples()) {
        // Single precision of a full scale of 2.5 m/s², and 1 ns beside the tick.
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

#[test]
fn hjif_refuses_what_it_cannot_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let series = |samples: &[f64], rate_hz| {
        Series::<Drive>::new(samples.to_vec(), SampleRate::new(rate_hz).unwrap()).unwrap()
    };
    for (series, part) in [
        (series(&[0.0, 1.5], 8000.0), "1.5 in sample 1"),
        (series(&[0.0], 8000.0), "two samples"),
        (series(&[0.0, 0.1], 96_000.0), "at most 48000"),
        (series(&[0.0, 0.1], 1234.5), "whole Hz"),
    ] {
        let error = write_hjif(&path, &series, &texture())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(part) && error.contains("expected"),
            "{error}"
        );
        assert!(!path.exists());
    }
}

#[test]
fn each_rule_of_the_structure_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let x = Series::<Drive>::new(vec![0.0, 0.5, 0.0], SampleRate::new(8000.0).unwrap()).unwrap();
    write_hjif(&path, &x, &texture()).unwrap();
    let sound: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    for (pointer, value, part) in [
        ("/version", "2022".into(), "version"),
        ("/version", "2025-0".into(), "version"),
        ("/profile", "Baseline".into(), "profile"),
        ("/level", 3.into(), "level"),
        ("/date", "yesterday".into(), "date"),
        ("/timescale", 96_000.into(), "timescale"),
        (
            "/perceptions/0/perception_modality",
            "Tickle".into(),
            "modality",
        ),
        ("/perceptions/0/avatar_id", 4.into(), "avatar 4"),
        (
            "/perceptions/0/reference_devices/0/type",
            "Piezoelectric".into(),
            "actuator",
        ),
        (
            "/perceptions/0/reference_devices/0/resonance_frequency",
            5.0.into(),
            "rise",
        ),
        (
            "/perceptions/0/channels/0/reference_device_id",
            7.into(),
            "device",
        ),
        (
            "/perceptions/0/channels/0/bands/0/lower_frequency_limit",
            5000.into(),
            "ends below",
        ),
        (
            "/perceptions/0/channels/0/bands/0/effects/0/effect_type",
            "Reference".into(),
            "library",
        ),
        (
            "/perceptions/0/channels/0/bands/0/effects/0/phase",
            Value::Null,
            "lacks",
        ),
    ] {
        let mut broken = sound.clone();
        *broken.pointer_mut(pointer).unwrap() = value;
        let file = parse_hjif(&path, broken.to_string().as_bytes()).unwrap();
        let departures = file.departures();
        assert!(
            departures.len() == 1 && departures[0].contains(part),
            "{pointer}: {departures:?}"
        );
    }
    // What cannot be read at all.
    for (pointer, value, part) in [
        ("/perceptions", Value::Null, "null"),
        (
            "/perceptions/0/channels/0/bands/0/band_type",
            "Wave".into(),
            "unknown variant `Wave`",
        ),
        (
            "/perceptions/0/channels/0/gain",
            "loud".into(),
            "invalid type",
        ),
        (
            "/perceptions/0/channels/0/bands/0/effects/0/position",
            0.5.into(),
            "invalid",
        ),
    ] {
        let mut broken = sound.clone();
        *broken.pointer_mut(pointer).unwrap() = value;
        let error = parse_hjif(&path, broken.to_string().as_bytes())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(part) && error.contains("expected"),
            "{error}"
        );
    }
}

#[test]
fn every_kind_of_band_is_played() {
    let file = |bands: &str| {
        format!(
            r#"{{"version": "2025", "profile": "Main", "level": 1, "date": "2025-01-15", "description": "", "timescale": 1000,
            "avatars": [], "syncs": [], "perceptions": [{{"id": 0, "avatar_id": 0, "description": "",
            "perception_modality": "Vibrotactile", "effect_library": [{{"effect_type": "Basis", "id": 3, "position": 0,
            "phase": 0, "base_signal": "Square", "keyframes": [{{"relative_position": 0, "amplitude_modulation": 0.5,
            "frequency_modulation": 100}}]}}], "channels": [{{"id": 0, "description": "", "gain": 2,
            "mixing_coefficient": 1, "body_part_mask": 0, "bands": [{bands}]}}]}}]}}"#
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let wave = r#"{"band_type": "VectorialWave", "lower_frequency_limit": 0, "upper_frequency_limit": 500, "effects":
        [{"effect_type": "Basis", "position": 100, "phase": 0, "base_signal": "Sine", "keyframes":
        [{"relative_position": 0, "amplitude_modulation": 0.25, "frequency_modulation": 100},
         {"relative_position": 900, "amplitude_modulation": 0.25, "frequency_modulation": 100}]}]}"#;
    let tap = r#"{"band_type": "Transient", "lower_frequency_limit": 0, "upper_frequency_limit": 500, "effects":
        [{"effect_type": "Reference", "id": 3, "position": 10}]}"#;
    let curve = r#"{"band_type": "Curve", "curve_type": "Akima", "lower_frequency_limit": 0, "upper_frequency_limit": 50,
        "effects": [{"effect_type": "Basis", "position": 0, "phase": 0, "base_signal": "Sine", "keyframes":
        [{"relative_position": 0, "amplitude_modulation": 0}, {"relative_position": 50, "amplitude_modulation": 0.3},
         {"relative_position": 100, "amplitude_modulation": 0}]}]}"#;
    for (band, length, peak) in [(wave, 8001, 0.5), (tap, 257, 1.0), (curve, 801, 0.6)] {
        let text = file(band);
        let parsed = parse_hjif(&path, text.as_bytes()).unwrap();
        assert_eq!(parsed.departures(), Vec::<String>::new());
        std::fs::write(&path, text).unwrap();
        let played = recording(&path, &ReadOptions::default()).recording;
        let samples = &played.channels()[0].samples;
        let found = samples.iter().fold(0.0f64, |p, v| p.max(v.abs()));
        assert_eq!(samples.len(), length);
        assert!((found - peak).abs() < 1e-3 * peak, "{found} {peak}");
        assert!(samples[..80].iter().all(|v| v.abs() < 0.3));
    }
    std::fs::write(&path, file("")).unwrap();
    let error = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("a duration above 0 s"), "{error}");
}

#[test]
fn days_are_those_of_the_calendar() {
    for (unix_s, day) in [
        (0, "1970-01-01"),
        (951_782_400, "2000-02-29"),
        (1_735_689_599, "2024-12-31"),
        (4_102_444_800, "2100-01-01"),
        (4_107_542_400, "2100-03-01"),
    ] {
        assert_eq!(date_of(unix_s), day);
    }
    assert!(date_of(u64::MAX).starts_with("9999"));
}

/// Truncated everywhere and with thousands of bytes flipped: a recording or a sentence, never a panic.
#[test]
fn damage_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let x = Series::<Drive>::new(vec![0.1; 40], SampleRate::new(8000.0).unwrap()).unwrap();
    write_hjif(&path, &x, &texture()).unwrap();
    let mut originals = vec![std::fs::read(&path).unwrap()];
    for name in [
        "valid_v1_multiple_emphasis.haptic",
        "2_points.haptic",
        "2_points.ahap",
    ] {
        originals.extend(clip_file(name).map(|path| std::fs::read(path).unwrap()));
    }
    let mut random = Lcg(7);
    let damaged_path = folder.path().join("d");
    let attack = |bytes: &[u8], to_disk: bool| {
        let _either = parse_haptic(&path, bytes);
        let _either = parse_ahap(&path, bytes);
        if let Ok(file) = parse_hjif(&path, bytes) {
            let _some = file.departures();
        }
        if to_disk {
            std::fs::write(&damaged_path, bytes).unwrap();
            if let Err(error) = read_recording(&damaged_path, &ReadOptions::default()) {
                assert!(
                    [";", "expected", "is needed", ": export it again"]
                        .iter()
                        .any(|part| error.to_string().contains(part)),
                    "{error}"
                );
            }
        }
    };
    for original in originals {
        for length in 0..original.len() {
            attack(&original[..length], length % 16 == 0);
        }
        let mut damaged = original.clone();
        for i in 0..1500 {
            let at = random.below(damaged.len());
            let before = damaged[at];
            // Half of the time a digit for a digit, so that numbers go wrong and not only the syntax.
            damaged[at] = if i % 2 == 0 && before.is_ascii_digit() {
                b'0' + random.below(10) as u8
            } else {
                before ^ (1 + random.below(255) as u8)
            };
            attack(&damaged, i % 4 == 0);
            damaged[at] = before;
        }
    }
}
