//! `piezotact roughness` on Surfcom profiles with their settings (`.tx3`), and on sets of surfaces. The files are made here, in the
//! form that such an instrument writes them.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::fmt::Write as _;

use crate::support::{Folder, noise};
use serde_json::Value;

const POINTS: usize = 2000;

/// A rough line, in µm: 2000 points.
fn rough() -> Vec<f64> {
    let mut z = 0.0;
    let next = |w: f64| {
        z = 0.9 * z + w;
        z
    };
    noise(POINTS).map(next).collect()
}

/// A rough line with waviness, in µm.
fn primary() -> Vec<f64> {
    let wave = |i: usize| (i as f64 / 1400.0 * std::f64::consts::TAU).sin();
    let points = rough().into_iter().enumerate();
    points.map(|(i, z)| z + 6.0 * wave(i)).collect()
}

/// The roughness profile that an instrument with a Gaussian filter makes of [`primary`].
fn roughness(cutoff_steps: usize) -> Vec<f64> {
    filtered(&primary(), cutoff_steps)
}

/// `z` after a Gaussian filter.
fn filtered(z: &[f64], cutoff_steps: usize) -> Vec<f64> {
    let weight =
        |d: f64| (-std::f64::consts::PI * (d / (0.4697 * cutoff_steps as f64)).powi(2)).exp();
    let at = |i: isize| {
        let i = if i < 0 { -i - 1 } else { i };
        let i = if i >= POINTS as isize {
            2 * POINTS as isize - 1 - i
        } else {
            i
        };
        z[i as usize]
    };
    let reach = cutoff_steps as isize;
    (0..POINTS as isize)
        .map(|i| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for d in (-reach..=reach).step_by(5) {
                let w = weight(d as f64);
                sum += w * at(i + d);
                weights += w;
            }
            at(i) - sum / weights
        })
        .collect()
}

fn profile(length_mm: f64, heights_um: &[f64]) -> String {
    let mut text = format!("{length_mm:.5}\r\n{}\r\n", heights_um.len());
    for z in heights_um {
        write!(text, "{z:.4}\r\n").unwrap();
    }
    text
}

/// Settings with Spanish labels in Latin-1, as the instrument writes them.
fn settings(cutoff: &str, evaluated: &str, ra: &str) -> Vec<u8> {
    let text = format!(
        "Fecha\t01.02.2025\r\nEstándar\tISO '97\r\nTipo medición\tAspereza\r\nLongitud medición\t10.0mm\r\nOnda de corte\t{cutoff}\r\n\
         Rango de medida\t+/-128.0um\r\nVelocidad medición\t0.3mm/s\r\nRelación corte Ls\t100\r\nLongitud onda corte Ls\t25.0um\r\n\
         Longitud evaluación\t{evaluated}\r\nPa\t*.*******um\t*.*******um\r\nRa\t{ra}\t*.*******um\r\nRk\t*.*******um\t*\r\n"
    );
    text.chars()
        .map(|sign| u8::try_from(u32::from(sign)).unwrap())
        .collect()
}

fn mean_height(heights: &[f64]) -> f64 {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    heights.iter().map(|z| (z - mean).abs()).sum::<f64>() / heights.len() as f64
}

fn codes(value: &Value) -> Vec<String> {
    let warnings = value["warnings"].as_array().unwrap().iter();
    let cause = |warning: &Value| {
        let cause = [&warning["fault"], &warning["what"]];
        let cause = cause.iter().find_map(|cause| cause.as_str());
        let code = warning["code"].as_str().unwrap();
        format!("{code}/{}", cause.unwrap_or_default())
    };
    warnings.map(cause).collect()
}

#[test]
fn a_filtered_profile_is_not_filtered_again() {
    let folder = Folder::new();
    let heights = roughness(500);
    let expected_um = mean_height(&heights);
    folder.write("plate_roughness.tx2", profile(10.0, &heights));
    let ra = format!("{expected_um:.7}um");
    folder.write("plate_settings.tx3", settings("2.5mm", "10.0mm", &ra));
    folder.write("other_settings.tx3", settings("0.8mm", "10.0mm", &ra));
    let run = |options: &[&str]| {
        let arguments = [&["roughness", "plate_roughness.tx2", "--json"], options].concat();
        folder.run(&arguments).json()
    };
    let value = run(&[]);
    // the four sections have means of their own, and the file four decimals
    assert!(
        (value["Ra"].as_f64().unwrap() / expected_um - 1.0).abs() < 0.01,
        "{value}"
    );
    assert_eq!(value["filter"], "instrument");
    assert_eq!(value["cutoff_by"], "instrument");
    assert_eq!(
        (&value["cutoff_mm"], &value["sections"]),
        (&2.5.into(), &4.into())
    );
    assert_eq!(codes(&value), ["few/sections"]);
    let stated = &value["instrument"];
    assert!((stated["parameters"]["Ra"].as_f64().unwrap() - expected_um).abs() < 1e-6);
    assert_eq!(
        stated["parameters"].as_object().unwrap().len(),
        1,
        "blank results are none"
    );
    assert_eq!(stated["lambda_s_um"].as_f64().unwrap().round(), 25.0);
    for name in ["Rk", "Rpk", "Rvk", "Mr1_percent", "Mr2_percent"] {
        assert!(value[name].as_f64().unwrap() > 0.0, "{name}");
    }
    let done = folder.run(&["roughness", "plate_roughness.tx2", "--report", "r.html"]);
    for part in [
        "not filtered again",
        "Instrument (",
        "plate_settings.tx3",
        "λc 2.5 mm",
    ] {
        assert!(done.out().contains(part), "{part}: {}", done.out());
    }
    let html = std::fs::read_to_string(folder.path("r.html")).unwrap();
    assert!(
        html.contains("<th class=\"n\" scope=\"col\">instrument</th>")
            && html.contains("not filtered again")
    );

    // who wants it filtered again gets it, with a warning
    for options in [&["--filter", "gauss"][..], &["--cutoff", "0.8mm"]] {
        let again = run(options);
        assert_eq!(again["filter"], "gauss");
        assert!(
            codes(&again).contains(&"filter_doubtful/twice".to_owned()),
            "{again}"
        );
    }
    // without the settings it cannot be known how it was filtered
    std::fs::remove_file(folder.path("plate_settings.tx3")).unwrap();
    let alone = run(&["--step", "5um", "--cutoff", "2.5mm"]);
    assert!(
        codes(&alone).contains(&"filter_doubtful/twice".to_owned()),
        "{alone}"
    );
    let done = folder.run(&["roughness", "plate_roughness.tx2", "--step", "5um"]);
    assert!(
        done.err().contains(".tx3") && done.err().contains("--filter none"),
        "{}",
        done.err()
    );
}

#[test]
fn the_length_evaluated_gives_the_step() {
    let folder = Folder::new();
    folder.write("a.tx1", profile(10.0, &primary()));
    let alone = folder.run(&["roughness", "a.tx1", "--json"]).json();
    assert!(
        codes(&alone).contains(&"instrument_differs/length".to_owned()),
        "{alone}"
    );
    folder.write("a.tx3", settings("0.8mm", "5.5mm", "*.*******um"));
    let value = folder.run(&["roughness", "a.tx1", "--json"]).json();
    let step_um = value["step_um"].as_f64().unwrap();
    assert!((step_um - 5500.0 / POINTS as f64).abs() < 1e-9, "{step_um}");
    assert!(
        codes(&value).contains(&"instrument_differs/length_set".to_owned()),
        "{value}"
    );
    assert!(
        !codes(&value).contains(&"instrument_differs/length".to_owned()),
        "{value}"
    );
    assert_eq!(value["filter"], "gauss");
    // a step that a person states goes before both
    let stated = folder
        .run(&["roughness", "a.tx1", "--json", "--step", "2um"])
        .json();
    assert!((stated["step_um"].as_f64().unwrap() - 2.0).abs() < 1e-9);
    // the usual step needs no settings
    folder.write("b.tx1", profile(10e-3 / 28_087.0 * 2e6, &primary()));
    let usual = folder.run(&["roughness", "b.tx1", "--json"]).json();
    assert!(
        !codes(&usual)
            .iter()
            .any(|code| code.starts_with("instrument_differs/length")),
        "{usual}"
    );
}

#[test]
fn another_value_than_the_instruments_is_a_warning() {
    let folder = Folder::new();
    folder.write("a.tx2", profile(10.0, &roughness(500)));
    folder.write("a.tx3", settings("2.5mm", "10.0mm", "9.0000000um"));
    let value = folder.run(&["roughness", "a.tx2", "--json"]).json();
    assert!(
        codes(&value).contains(&"instrument_differs/parameter".to_owned()),
        "{value}"
    );
}

#[test]
fn a_profile_that_looks_filtered_is_a_warning() {
    let folder = Folder::new();
    let table = |heights: &[f64]| {
        let rows = heights.iter().enumerate();
        let rows = rows.map(|(i, z)| format!("{:.3},{z:.5}\n", i as f64 * 5e-3));
        format!("x (mm),z (um)\n{}", rows.collect::<String>())
    };
    folder.write("filtered.csv", table(&filtered(&rough(), 200)));
    folder.write("rough.csv", table(&rough()));
    folder.write("primary.csv", table(&primary()));
    let of = |file: &str| {
        let value = folder
            .run(&["roughness", file, "--cutoff", "1mm", "--json"])
            .json();
        codes(&value).contains(&"filter_doubtful/looks_filtered".to_owned())
    };
    assert!(of("filtered.csv"));
    assert!(!of("rough.csv"));
    assert!(!of("primary.csv"));
}

/// A profile of 10 mm at steps of 2 µm: noise of this height, in µm.
fn rough_line(height_um: f64) -> String {
    let mut text = String::from("x (mm),z (um)\n");
    for (i, w) in noise(5000).enumerate() {
        writeln!(text, "{:.3},{:.6}", i as f64 * 2e-3, height_um * w).unwrap();
    }
    text
}

#[test]
fn several_files_are_a_set_in_the_order_of_ra() {
    let folder = Folder::new();
    for (name, height_um) in [("S3.csv", 0.5), ("S1.csv", 9.0), ("S2.csv", 2.0)] {
        folder.write(name, rough_line(height_um));
    }
    let files = [
        "roughness",
        "S3.csv",
        "S1.csv",
        "S2.csv",
        "--cutoff",
        "0.8mm",
    ];
    let outputs = ["--csv", "set.csv", "--report", "set.html"];
    let done = folder.run(&[&files[..], &outputs].concat());
    done.expect_success();
    let out = done.out();
    let places = ["S1.csv", "S2.csv", "S3.csv"].map(|name| out.find(name).unwrap());
    assert!(places.is_sorted(), "{out}");
    assert!(out.contains("Ra, µm") && out.contains("Rpk, µm"), "{out}");
    let table = std::fs::read_to_string(folder.path("set.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].starts_with("file,Ra_um,Rq_um,"), "{}", rows[0]);
    assert_eq!(rows.len(), 4);
    assert!(rows[1].starts_with("S1.csv,") && rows[3].starts_with("S3.csv,"));
    let html = std::fs::read_to_string(folder.path("set.html")).unwrap();
    for part in [
        "S1.csv, S2.csv, S3.csv",
        "height, µm",
        "<svg",
        "Parameters",
        "0.8 mm",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let value = folder.run(&[&files[..], &["--json"]].concat()).json();
    assert_eq!(value["schema"], "roughness_set");
    let surfaces = value["surfaces"].as_array().unwrap();
    let ra = |i: usize| surfaces[i]["Ra"].as_f64().unwrap();
    assert!(ra(0) > ra(1) && ra(1) > ra(2));
    assert_eq!(value["failed"], serde_json::json!([]));
}

#[test]
fn one_bad_file_of_several_does_not_stop_the_others() {
    let folder = Folder::new();
    folder.write("S1.csv", rough_line(1.0));
    folder.write("bad.csv", "x (mm),z (um)\n0,1\n0.1,oops\n");
    folder.write("S2.csv", rough_line(2.0));
    let done = folder.run(&[
        "roughness",
        "S1.csv",
        "bad.csv",
        "S2.csv",
        "--report",
        "r.html",
    ]);
    done.expect_failure(1, &["1 of 3 files gave no result", "bad.csv", "`oops`"]);
    assert!(
        done.out().contains("S1.csv") && done.out().contains("S2.csv"),
        "{}",
        done.out()
    );
    let html = std::fs::read_to_string(folder.path("r.html")).unwrap();
    assert!(html.contains("Files without a result") && html.contains("oops"));
    folder
        .run(&[
            "roughness",
            "bad.csv",
            "nowhere.csv",
            "--report",
            "none.html",
        ])
        .expect_failure(1, &["none of 2 files", "nowhere.csv"]);
    assert!(!folder.path("none.html").exists());
}
