//! `piezotact score` as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{self, Folder, noise, wav};

/// Thirty seconds of noise from another place of the sequence for every `seed`.
fn realisation(seed: usize, rate_hz: u32, gain: f64) -> Vec<u8> {
    let length = 30 * rate_hz as usize;
    let samples: Vec<f64> = noise(length * (seed + 1)).skip(length * seed).collect();
    wav(samples.into_iter().map(|v| gain * v), rate_hz)
}

const SCALE: [&str; 2] = ["--scale", "20 m/s2"];

fn score(folder: &Folder, a: &str, b: &str, more: &[&str]) -> support::Done {
    folder.run(&[&["score", a, b][..], &SCALE, more].concat())
}

#[test]
fn two_realisations_are_not_distinguishable_and_the_verdict_comes_first() {
    let folder = Folder::new();
    folder.write("a.wav", realisation(0, 5_000, 0.5));
    folder.write("b.wav", realisation(1, 5_000, 0.5));
    let done = score(&folder, "a.wav", "b.wav", &["--report", "score.html"]);
    done.expect_success();
    let out = done.out();
    assert!(
        out.starts_with("below the just-noticeable difference: 0."),
        "{out}"
    );
    for part in [
        "% right of two intervals",
        "perceived difference (",
        "difference below the just-noticeable difference",
        "report: score.html",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    let html = std::fs::read_to_string(folder.path("score.html")).unwrap();
    for part in [
        "below the just-noticeable difference",
        "Sensitivity to the parameters of the model",
        "threshold_offset_db",
        "difference of the spectra: the largest of the next three",
        "detection threshold",
        "parts of one recording",
        "No nail-to-skin map was given",
        "not in m/s²",
        "Other measures, not part of the score",
        "NMSE",
        "ST-SIM",
        "SPQI",
        "<svg",
    ] {
        assert!(html.contains(part), "the report lacks {part}");
    }
    let json = score(&folder, "a.wav", "b.wav", &["--json"]).json();
    assert_eq!(json["verdict"]["is"], "below_jnd");
    assert_eq!(json["criteria"][0]["outcome"], "met");
    assert_eq!(json["criteria"][0]["limit"]["met"], 1.0);
    assert!(json["perceived"]["jnd"]["value"].as_f64().unwrap() < 0.2);
    assert!(json["spectral"]["jnd"].as_f64().unwrap() < 0.2);
    assert_eq!(json["bands"].as_array().unwrap().len(), 18);
    assert!(
        json["sentence"]
            .as_str()
            .unwrap()
            .starts_with("below the just-noticeable difference")
    );
    let says = |b: &str| {
        score(&folder, "a.wav", b, &[])
            .err()
            .contains("identical samples")
    };
    assert_eq!([says("a.wav"), says("b.wav")], [true, false]);
    for key in [
        "waveform",
        "literature",
        "spectrum_error",
        "level_error_db",
        "warnings",
    ] {
        assert!(!json[key].is_null(), "{key}");
    }
}

#[test]
fn a_louder_texture_is_distinguishable_by_as_many_jnd_as_it_is_louder() {
    let folder = Folder::new();
    folder.write("a.wav", realisation(0, 5_000, 0.5));
    folder.write(
        "b.wav",
        realisation(1, 5_000, 0.5 * 10f64.powf(4.74 / 20.0)),
    );
    let of = |more: &[&str]| score(&folder, "a.wav", "b.wav", &[&["--json"], more].concat()).json();
    let found = of(&[]);
    assert_eq!(
        found["verdict"]["is"], "distinguishable",
        "{}",
        found["sentence"]
    );
    assert_eq!(found["verdict"]["how"][0], "louder");
    assert!(
        (found["level"]["jnd"].as_f64().unwrap() - 3.0).abs() < 0.1,
        "{}",
        found["level"]
    );
    // With a JND twice as large, half as many of them; a distinguishable pair is a result, not a failure.
    let half = of(&["--jnd", "3.16"]);
    assert!((half["level"]["jnd"].as_f64().unwrap() - 1.5).abs() < 0.1);
    let band = of(&["--band", "100..300"]);
    assert_eq!(band["config"]["band"], serde_json::json!([100.0, 300.0]));
}

#[test]
fn what_cannot_be_scored_is_refused_and_what_is_questionable_is_said() {
    let folder = Folder::new();
    folder.write("a.wav", realisation(0, 5_000, 0.5));
    folder.write("silent.wav", wav((0..50_000).map(|_| 0.0), 5_000));
    folder.write("short.wav", wav(noise(2_000), 5_000));
    folder.write("shorter.wav", wav(noise(1_000), 5_000));
    folder.write("slow.wav", wav(noise(5_000), 500));
    let other = noise(155_000).skip(150_000).map(|v| 0.5 * v);
    folder.write("second.wav", wav(other, 5_000));
    let rows: String = (0..9_000)
        .map(|i| format!("{},{}\n", f64::from(i) * 2e-4, i % 7))
        .collect();
    folder.write("force.csv", format!("time (s),force (N)\n{rows}"));
    folder
        .run(&["score", "a.wav", "a.wav"])
        .expect_failure(1, &["physical scale", "--scale"]);
    score(&folder, "a.wav", "force.csv", &[]).expect_failure(1, &["force.csv", "m/s²", "force"]);
    score(&folder, "a.wav", "silent.wav", &[]).expect_failure(1, &["the test has no signal"]);
    // By the model from 0.3 s on, with what is not compared; by spectra from a segment on. One model never takes the place of the other.
    let spectral = ["--model", "spectral"];
    let done = score(&folder, "a.wav", "short.wav", &["--json"]).json();
    let limitation = &done["perceived"]["limitations"][0];
    assert_eq!(limitation["is"], "short_excerpt", "{done}");
    score(&folder, "a.wav", "short.wav", &spectral)
        .expect_failure(1, &["0.82 s", "0.400 s", "record longer"]);
    score(&folder, "a.wav", "shorter.wav", &[])
        .expect_failure(1, &["0.30 s", "0.200 s", "record longer"]);
    let narrow = ["--band", "20..200"];
    score(&folder, "slow.wav", "slow.wav", &narrow)
        .expect_failure(1, &["1000 Hz", "500 Hz", "--model spectral"]);
    let done = score(
        &folder,
        "slow.wav",
        "slow.wav",
        &[narrow, spectral].concat(),
    );
    done.expect_success();
    assert!(
        done.out().starts_with("by the spectra alone"),
        "{}",
        done.out()
    );
    for (option, value, part) in [
        ("--jnd", "0", "just-noticeable"),
        ("--frequency-jnd", "-1", "just-noticeable"),
        ("--band", "20..4000", "2500 Hz"),
        ("--full-scale", "2 N", "--full-scale"),
    ] {
        score(&folder, "a.wav", "a.wav", &[option, value]).expect_failure(2, &[part]);
    }
    score(&folder, "a.wav", "a.wav", &["--report", "a.wav"])
        .expect_failure(2, &["would be replaced"]);

    folder.write("fast.wav", realisation(1, 10_000, 0.7));
    let done = score(&folder, "a.wav", "fast.wav", &["--band", "20..900"]);
    done.expect_success();
    assert!(
        done.err()
            .contains("the test is sampled at 10000 Hz and was resampled to 5000 Hz"),
        "{}",
        done.err()
    );
    let done = score(&folder, "second.wav", "a.wav", &spectral);
    done.expect_success();
    let says = "by the spectra alone not decided";
    assert!(done.out().starts_with(says), "{}", done.out());
    assert!(done.err().contains("record longer"), "{}", done.err());
}

#[test]
fn a_recording_is_nothing_but_itself() {
    let folder = Folder::new();
    folder.write("a.wav", realisation(0, 5_000, 0.5));
    let json = score(&folder, "a.wav", "a.wav", &["--json"]).json();
    for jnd in [&json["spectral"]["jnd"], &json["perceived"]["jnd"]["value"]] {
        assert!(jnd.as_f64().unwrap() < 1e-6, "{jnd}");
    }
    assert!((json["literature"]["st_sim"]["value"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    assert!((json["literature"]["spqi"].as_f64().unwrap() - 1.0).abs() < 1e-6);
    assert_eq!(json["extent"], "shared_part");
}

/// Skin that moves less than the nail feels less; a table that is no map is refused with what to do.
#[test]
fn a_nail_to_skin_map_moves_the_threshold() {
    let folder = Folder::new();
    folder.write("a.wav", realisation(0, 5_000, 0.5));
    folder.write("b.wav", realisation(1, 5_000, 0.5));
    folder.write(
        "map.csv",
        "# laser\nfrequency (Hz),skin over nail (dB)\n10,-20\n1000,-20\n",
    );
    folder.write("ratio.csv", "frequency (Hz),ratio\n10,0.1\n1000,0.1\n");
    folder.write(
        "bad.csv",
        "frequency (Hz),skin over nail (dB)\n100,-3\n50,-3\n",
    );
    folder.write("other.csv", "x,y\n1,2\n");
    let of = |more: &[&str]| score(&folder, "a.wav", "b.wav", &[&["--json"], more].concat()).json();
    let level = |json: &serde_json::Value| json["reference_sensation_db"].as_f64().unwrap();
    let plain = level(&of(&[]));
    for map in ["map.csv", "ratio.csv"] {
        let json = of(&["--contact-map", map]);
        assert!((plain - level(&json) - 20.0).abs() < 1e-6, "{map}");
        assert!(
            !json["warnings"].to_string().contains("thresholds_of_skin"),
            "{}",
            json["warnings"]
        );
    }
    assert!(
        of(&[])["warnings"]
            .to_string()
            .contains("thresholds_of_skin")
    );
    for (map, parts) in [
        ("bad.csv", ["50 Hz", "row 2"]),
        ("other.csv", ["header `x,y`", "frequency"]),
    ] {
        score(&folder, "a.wav", "b.wav", &["--contact-map", map]).expect_failure(1, &parts);
    }
}
