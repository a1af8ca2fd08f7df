//! What haptic files must not do: fill the memory, change their level on the way, or be answered as something else.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::Path;

use piezotact::quantity::{Drive, SampleRate};
use piezotact::series::Series;
use piezotact_dataset::haptic::{parse_haptic, write_hjif};
use piezotact_dataset::{ReadOptions, holds_transfer, read_recording};
use piezotact_haptic::{
    Ahap, AhapParameterId, AhapPattern, Exported, HjifTexture, ahap_of, reference_device,
};

/// One breakpoint is a constant: without it the event beneath plays at full strength.
#[test]
fn a_single_breakpoint_keeps_its_strength_in_ahap() {
    let clip = |amplitude: &str, frequency: &str| {
        let text = format!(
            r#"{{"version": {{"major": 1}}, "signals": {{"continuous": {{"envelopes": {{"amplitude": {amplitude}{frequency}}}}}}}}}"#
        );
        ahap_of(&parse_haptic(Path::new("t.haptic"), text.as_bytes()).unwrap())
    };
    let held = |pattern: &Exported<Ahap>, id: AhapParameterId| {
        let entries = pattern.content.pattern.iter();
        let of_id = entries.filter_map(|entry| match entry {
            AhapPattern::Parameter(at_once) if at_once.parameter_id == id => {
                Some((at_once.time, at_once.parameter_value))
            }
            _ => None,
        });
        of_id.collect::<Vec<_>>()
    };
    let (intensity, sharpness) = (
        AhapParameterId::HapticIntensityControl,
        AhapParameterId::HapticSharpnessControl,
    );
    let one = clip(
        r#"[{"time": 2, "amplitude": 0.25}]"#,
        r#", "frequency": [{"time": 0, "frequency": 0.16}]"#,
    );
    assert_eq!(held(&one, intensity), [(0.0, 0.5)]);
    assert_eq!(held(&one, sharpness), [(0.0, 0.4)]);
    let late = clip(
        r#"[{"time": 1, "amplitude": 0.25}, {"time": 2, "amplitude": 1}]"#,
        "",
    );
    let said: Vec<String> = late.losses.iter().map(ToString::to_string).collect();
    assert!(
        said.iter().any(|loss| loss.contains("sharpness"))
            && said.iter().any(|loss| loss.contains("before the first")),
        "{said:?}"
    );
    let usual = clip(
        r#"[{"time": 0, "amplitude": 0.25}, {"time": 2, "amplitude": 1}]"#,
        "",
    );
    assert_eq!(held(&usual, intensity), []);
}

#[test]
fn json_that_is_called_a_clip_is_answered_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.haptic");
    let deep = "[".repeat(200_000);
    for text in ["{}", "[]", " null", &deep, r#"{"a": 1}"#] {
        std::fs::write(&path, text).unwrap();
        assert!(!holds_transfer(&path));
        let error = read_recording(&path, &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("a haptic clip"), "{error}");
    }
}

/// Between keyframes there are straight lines: at its own rate a file is read as it is, at another that is said.
#[test]
fn hjif_is_read_at_the_rate_it_was_made_at() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let tone = |i: usize| 0.5 * (std::f64::consts::TAU * 1000.0 * i as f64 / 5000.0 + 0.3).sin();
    let rate = SampleRate::new(5000.0).unwrap();
    let x = Series::<Drive>::new((0..10_000).map(tone).collect(), rate).unwrap();
    let texture = HjifTexture {
        description: "a tone".into(),
        date: "2025-01-15".into(),
        full_scale: "1 FS".parse().unwrap(),
        device: reference_device(None, None, None),
    };
    write_hjif(&path, &x, &texture).unwrap();
    let played = read_recording(&path, &ReadOptions::default())
        .unwrap()
        .recording;
    assert_eq!((played.rate(), played.len()), (rate, 10_000));
    let rms = |samples: &[f64]| piezotact::statistics::standard_deviation(samples);
    let level = rms(&played.channels()[0].samples) / rms(x.samples());
    assert!((level - 1.0).abs() < 1e-5, "{level}");
    let options = ReadOptions {
        scale: None,
        rate: SampleRate::new(8000.0).ok(),
        ..ReadOptions::default()
    };
    let other = read_recording(&path, &options).unwrap().recording;
    let said = other
        .about
        .warnings
        .iter()
        .any(|d| d.to_string().contains("--rate 5000"));
    assert!(said, "{:?}", other.about.warnings);
    assert!(
        !played
            .about
            .warnings
            .iter()
            .any(|d| d.to_string().contains("--rate 5000"))
    );
}

#[test]
fn what_would_fill_the_memory_or_is_not_played_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.hjif");
    let file = |channels: &str| {
        format!(
            r#"{{"version": "2025", "profile": "Main", "level": 1, "date": "2025-01-15", "description": "", "timescale": 1000,
            "avatars": [], "syncs": [], "perceptions": [{{"id": 0, "avatar_id": 0, "description": "",
            "perception_modality": "Vibrotactile", "effect_library": [], "channels": [{channels}]}}]}}"#
        )
    };
    // Many channels of an hour are refused before there is memory for one.
    let hour = |id: usize, effect: &str| {
        format!(
            r#"{{"id": {id}, "description": "", "gain": 1, "mixing_coefficient": 1, "body_part_mask": 0, "bands": [{{
            "band_type": "Curve", "curve_type": "Linear", "lower_frequency_limit": 0, "upper_frequency_limit": 50,
            "effects": [{{"effect_type": "{effect}", "id": 99, "position": 0, "keyframes": [
            {{"relative_position": 0, "amplitude_modulation": 0}},
            {{"relative_position": 3600000, "amplitude_modulation": 0.3}}]}}]}}]}}"#
        )
    };
    let channels: Vec<String> = (0..200).map(|id| hour(id, "Basis")).collect();
    let text = file(&channels.join(","));
    std::fs::write(&path, text).unwrap();
    let error = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    for part in ["at most 67108864 samples", "200 channels", "lower rate"] {
        assert!(error.contains(part), "{error}");
    }
    // What is not played says so, and not that nothing lasts.
    std::fs::write(&path, file(&hour(0, "Reference"))).unwrap();
    let error = read_recording(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("composite effects"), "{error}");
}

/// Apple, `CHHapticParameterCurve.ControlPoint`: times count from the start of their curve.
#[test]
fn control_points_count_from_their_own_curve_in_ahap() {
    let points: Vec<String> = (0..20)
        .map(|k| format!(r#"{{"time": {k}, "amplitude": 0.5}}"#))
        .collect();
    let text = format!(
        r#"{{"version": {{"major": 1}}, "signals": {{"continuous": {{"envelopes": {{"amplitude": [{}]}}}}}}}}"#,
        points.join(", ")
    );
    let clip = parse_haptic(Path::new("t.haptic"), text.as_bytes()).unwrap();
    let pattern = ahap_of(&clip).content.pattern;
    let curves: Vec<(f32, Vec<f32>)> = (pattern.iter())
        .filter_map(|entry| match entry {
            AhapPattern::ParameterCurve(curve) => {
                let points = &curve.parameter_curve_control_points;
                Some((curve.time, points.iter().map(|point| point.time).collect()))
            }
            _ => None,
        })
        .collect();
    let first = (0..16_u8).map(f32::from).collect();
    assert_eq!(
        curves,
        [(0.0, first), (15.0, vec![0.0, 1.0, 2.0, 3.0, 4.0])]
    );
}

#[test]
fn a_sound_that_fades_and_repeats_is_read_in_ahap() {
    let text = r#"{"Version": 1, "Pattern": [{"Event": {"EventType": "AudioCustom", "Time": 0, "EventWaveformPath": "a.wav",
        "EventWaveformUseVolumeEnvelope": true, "EventWaveformLoopEnabled": false, "EventParameters": []}}]}"#;
    let read = piezotact_haptic::parse_ahap(text.as_bytes()).unwrap();
    let AhapPattern::Event(event) = &read.pattern[0] else {
        unreachable!("{read:?}");
    };
    assert_eq!(event.event_waveform_use_volume_envelope, Some(true));
    assert_eq!(event.event_waveform_loop_enabled, Some(false));
}
