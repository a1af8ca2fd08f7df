//! `piezotact roughness` as a black box: measured maps and profiles, texts with and without units, refusals.
//!
//! Measured files lie beside the checkout, in `../shared/data`; without them a test says that it was skipped,
//! and with `CI=true` it fails.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::support::{Folder, noise, self_contained, shared};
use serde_json::Value;

fn measured(file: &str) -> Option<PathBuf> {
    shared(&format!("data/topography/{file}"))
}

fn json_of(file: &std::path::Path, options: &[&str]) -> Value {
    let mut arguments = vec!["roughness", file.to_str().unwrap(), "--json"];
    arguments.extend(options);
    Folder::new().run(&arguments).json()
}

#[track_caller]
fn check(value: &Value, key: &str, expected: f64, tolerance: f64) {
    let found = value[key].as_f64().unwrap();
    assert!(
        (found / expected - 1.0).abs() <= tolerance,
        "{key}: expected {expected}, found {found}"
    );
}

#[test]
fn measured_maps_have_the_published_sq() {
    for (file, sq_um) in [
        ("surfacetopography/plu-1.plu", 2.834391),
        ("surfacetopography/bcrf-1.bcrf", 0.024560207),
        ("surfacetopography/al3d-1.al3d", 7.688266),
    ] {
        let Some(path) = measured(file) else { return };
        let value = json_of(&path, &["--filter", "none"]);
        // published to seven digits
        check(&value, "Sq", sq_um, 1e-5);
        assert_eq!(value["form"], "mean");
        assert_eq!(value["filter"], "none");
        let level = json_of(&path, &[]);
        assert_eq!(level["form"], "level");
        assert!(level["Sq"].as_f64() < value["Sq"].as_f64());
    }
}

#[test]
fn a_surfcom_profile_has_the_instruments_roughness() {
    let (Some(primary), Some(roughness)) = (
        measured("surfcom/specimen_1_primary.tx1"),
        measured("surfcom/specimen_1_roughness.tx2"),
    ) else {
        return;
    };
    let instrument = json_of(&roughness, &["--filter", "none"]);
    check(&instrument, "Ra", 3.065, 2e-4);
    check(&instrument, "Rq", 5.903, 2e-4);
    assert!(instrument["cutoff_mm"].is_null());
    let ours = json_of(&primary, &["--cutoff", "2.5mm", "--standard", "iso21920"]);
    // The instrument measured beyond the line and filters its ends otherwise.
    check(&ours, "Ra", 3.065, 0.04);
    check(&ours, "Rq", 5.903, 0.02);
    check(&ours, "cutoff_mm", 2.5, 1e-12);
    check(&ours, "lambda_s_um", 8.0, 1e-12);
    check(&ours, "evaluation_length_mm", 10.0, 1e-6);
    assert_eq!(ours["sections"], 4);
    assert_eq!(ours["cutoff_by"], "stated");
    assert_eq!(ours["ends"], "kept");
    let few = &ours["warnings"][0];
    assert_eq!(
        (&few["code"], &few["what"]),
        (&"few".into(), &"sections".into())
    );

    let folder = Folder::new();
    let file = primary.to_str().unwrap();
    let done = folder.run(&[
        "roughness",
        file,
        "--cutoff",
        "2.5 mm",
        "--s-filter",
        "25um",
    ]);
    done.expect_success();
    for part in [
        "Ra ",
        " µm",
        "ISO 4287",
        "λc 2.5 mm (stated)",
        "λs 25 µm",
        "4 sampling lengths",
    ] {
        assert!(done.out().contains(part), "{part}: {}", done.out());
    }
    assert!(
        done.err().starts_with("warning: only 4 sections"),
        "{}",
        done.err()
    );
    // Without an option, the cut-off is that of the file beside it, and Ra that of the instrument.
    let own = json_of(&primary, &[]);
    check(&own, "cutoff_mm", 2.5, 1e-12);
    check(&own, "Ra", 3.065, 0.01);
    // Alone it gets that of ISO 4288: the five sections of 0.8 mm lie beside the groove.
    folder.write("alone.tx1", std::fs::read(&primary).unwrap());
    let alone = folder.run(&["roughness", "alone.tx1", "--json"]).json();
    check(&alone, "cutoff_mm", 0.8, 1e-12);
    assert_eq!(alone["warnings"][0]["code"], "uneven_profile");
    let chosen = folder.run(&["roughness", "alone.tx1"]);
    assert!(
        chosen.out().contains("chosen by ISO 4288 from Ra"),
        "{}",
        chosen.out()
    );
}

#[test]
fn texts_need_their_units() {
    let (Some(map), Some(line)) = (
        measured("nanovea/test1.txt"),
        measured("surfacetopography/xy-4.txt"),
    ) else {
        return;
    };
    let folder = Folder::new();
    for file in [&map, &line] {
        folder
            .run(&["roughness", file.to_str().unwrap()])
            .expect_failure(1, &["unit of the coordinates", "--x-unit mm"]);
        folder
            .run(&["roughness", file.to_str().unwrap(), "--x-unit", "mm"])
            .expect_failure(1, &["unit of the heights", "--z-unit um"]);
    }
    let value = json_of(&map, &["--x-unit", "mm", "--z-unit", "um"]);
    assert_eq!(
        (&value["columns"], &value["rows"]),
        (&101.into(), &101.into())
    );
    check(&value, "step_x_um", 5.0, 1e-9);
    for key in [
        "Sa",
        "Sq",
        "Sz",
        "Sp",
        "Sv",
        "Sal",
        "Ssk",
        "Sku",
        "Sdq",
        "Sdr_percent",
        "Str",
    ] {
        assert!(value[key].is_number(), "{key}");
    }
    let um = json_of(
        &line,
        &["--x-unit", "mm", "--z-unit", "mm", "--cutoff", "0.08mm"],
    );
    let nm = json_of(
        &line,
        &["--x-unit", "mm", "--z-unit", "um", "--cutoff", "80um"],
    );
    check(&um, "Ra", nm["Ra"].as_f64().unwrap() * 1e3, 1e-9);
    assert_eq!(um["sections"], 5);
    for key in ["Ra", "Rq", "Rz", "Rt", "Rp", "Rv", "Rsk", "Rku", "Rdq"] {
        assert!(um[key].is_number(), "{key}");
    }
    assert!(um.get("RSm").is_some());
}

/// A profile of 20 mm at steps of 2 µm: a wave of 0.1 mm with a little noise, in µm, tilted.
fn line() -> String {
    let mut text = String::from("x (mm),z (um)\n");
    for (i, noise) in noise(10_000).enumerate() {
        let x_mm = i as f64 * 2e-3;
        let z_um = (x_mm / 0.1 * std::f64::consts::TAU).sin() + 0.01 * noise + x_mm;
        writeln!(text, "{x_mm:.4},{z_um:.6}").unwrap();
    }
    text
}

#[test]
fn a_profile_is_stated_tabulated_and_reported() {
    let folder = Folder::new();
    folder.write("line.csv", line());
    let done = folder.run(&[
        "roughness",
        "line.csv",
        "--csv",
        "out.csv",
        "--report",
        "out.html",
    ]);
    done.expect_success();
    assert!(
        done.out().ends_with("wrote out.csv\nreport: out.html\n"),
        "{}",
        done.out()
    );
    let value = folder.run(&["roughness", "line.csv", "--json"]).json();
    // a sine of 1 µm: 2/π, and its width
    check(&value, "Ra", 2.0 / std::f64::consts::PI, 0.02);
    check(&value, "RSm", 100.0, 0.01);
    check(&value, "cutoff_mm", 0.8, 1e-12);
    assert_eq!(
        value["lambda_s_um"],
        Value::Null,
        "2.5 µm are no five steps"
    );
    assert_eq!(value["cutoff_by"], "iso4288");
    assert_eq!(
        (&value["unit"], &value["kind"]),
        (&"um".into(), &"profile".into())
    );
    assert_eq!(
        (&value["standard"], &value["form"]),
        (&"iso4287".into(), &"level".into())
    );
    let periodic = folder
        .run(&["roughness", "line.csv", "--json", "--periodic"])
        .json();
    check(&periodic, "cutoff_mm", 0.25, 1e-12);
    assert_eq!(periodic["cutoff_by"], "iso4288_periodic");

    let table = std::fs::read_to_string(folder.path("out.csv")).unwrap();
    let mut rows = table.lines();
    assert_eq!(
        rows.next(),
        Some("position_mm,primary_um,mean_line_um,roughness_um")
    );
    let row: Vec<f64> = rows
        .nth(5000)
        .unwrap()
        .split(',')
        .map(|v| v.parse().unwrap())
        .collect();
    assert!((row[0] - 10.0).abs() < 1e-9);
    assert!(
        (row[1] - row[2] - row[3]).abs() < 2e-6,
        "primary = mean line + roughness: {row:?}"
    );
    assert_eq!(rows.count(), 10_000 - 5001);

    let html = std::fs::read_to_string(folder.path("out.html")).unwrap();
    for part in [
        "Ra 0.6",
        "mean line",
        "height, µm",
        "position, mm",
        "Warnings",
        "material ratio, %",
    ] {
        assert!(html.contains(part), "the report lacks {part}");
    }
    self_contained(&html);
}

#[test]
fn a_map_is_reported_with_its_image() {
    let folder = Folder::new();
    let mut text = String::from("x (mm),y (mm),z (um)\n");
    for (i, z_um) in noise(60 * 40).enumerate() {
        let (x_mm, y_mm) = ((i % 60) as f64 * 0.01, (i / 60) as f64 * 0.01);
        let z = if i == 777 {
            "NaN".into()
        } else {
            z_um.to_string()
        };
        writeln!(text, "{x_mm},{y_mm},{z}").unwrap();
    }
    folder.write("map.csv", text);
    let done = folder.run(&[
        "roughness",
        "map.csv",
        "--report",
        "map.html",
        "--cutoff",
        "0.25mm",
    ]);
    done.expect_success();
    assert!(done.out().contains("ISO 25178-2"), "{}", done.out());
    assert!(
        done.out().contains("L-filter Gaussian, 0.25 mm"),
        "{}",
        done.out()
    );
    let warnings: Vec<String> = done.err().lines().map(str::to_owned).collect();
    assert_eq!(
        warnings
            .iter()
            .filter(|d| d.contains("not measured"))
            .count(),
        1,
        "{warnings:?}"
    );
    let html = std::fs::read_to_string(folder.path("map.html")).unwrap();
    for part in [
        "data:image/png;base64,",
        "height, µm",
        "x, µm",
        "y, µm",
        "Grey: not measured",
    ] {
        assert!(html.contains(part), "the report lacks {part}");
    }
    self_contained(&html);
    for (options, parts) in [
        (
            &["--standard", "iso4287"][..],
            &["--standard", "height map"][..],
        ),
        (&["--periodic"], &["--periodic", "height map"]),
        (&["--s-filter", "iso"], &["--s-filter iso", "height map"]),
        (
            &["--filter", "none", "--cutoff", "0.2mm"],
            &["--filter none with --cutoff"],
        ),
        (&["--form", "poly9"], &["degree 1 to 4", "found degree 9"]),
        (&["--step", "1um"], &["--step", "leave it out"]),
    ] {
        let mut arguments = vec!["roughness", "map.csv"];
        arguments.extend(options);
        folder.run(&arguments).expect_failure(2, parts);
    }
    assert_eq!(folder.names(), ["map.csv", "map.html"]);
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = Folder::new();
    let whole = line();
    folder.write("line.csv", &whole);
    let rows: Vec<&str> = whole.lines().collect();
    folder.write("short.csv", rows[..31].join("\n"));
    folder.write(
        "missing.csv",
        [&rows[..100], &["0.198,NaN"], &rows[101..200]]
            .concat()
            .join("\n"),
    );
    folder.write(
        "uneven.csv",
        [&rows[..100], &rows[140..200]].concat().join("\n"),
    );
    folder.write(
        "bare.csv",
        "1.5\n2.25\n1.75\n2.5\n1.5\n2.5\n1.5\n2.5\n1.25\n",
    );
    folder.write("empty.csv", "");
    folder.write("volts.csv", whole.replace("z (um)", "z (V)"));
    let usage: [(&[&str], &[&str]); 15] = [
        (&["--cutoff", "0mm"], &["above zero", "`0mm`", "2.5mm"]),
        (&["--cutoff", "-2.5mm"], &["above zero", "`-2.5mm`"]),
        (&["--cutoff", "NaNmm"], &["above zero", "`NaNmm`"]),
        (&["--cutoff", "infmm"], &["above zero", "`infmm`"]),
        (&["--cutoff", "2.5"], &["with a unit", "`2.5`"]),
        (&["--cutoff", "2.5N"], &["m, mm, um, nm", "`2.5N`"]),
        (&["--cutoff", "0.8mm", "--periodic"], &["--periodic"]),
        (&["--form", "poly11"], &["poly2 to poly10"]),
        (
            &["--s-filter", "3mm", "--cutoff", "0.8mm"],
            &["below the cut-off", "found 3 mm"],
        ),
        (
            &["--filter", "none", "--s-filter", "8um"],
            &["--filter none with --s-filter"],
        ),
        (
            &["--filter", "none", "--periodic"],
            &["--filter none with --periodic"],
        ),
        (&["--x-unit", "V"], &["unit of length", "`V`"]),
        (&["--along", "x"], &["height map", "found a profile"]),
        (&["--along", "z"], &["along the rows"]),
        (&["--csv", "line.csv"], &["line.csv", "would be replaced"]),
    ];
    for (options, parts) in usage {
        let mut arguments = vec!["roughness", "line.csv"];
        arguments.extend(options);
        folder.run(&arguments).expect_failure(2, parts);
    }
    let data: [(&[&str], &[&str]); 8] = [
        (
            &["line.csv", "--cutoff", "25mm"],
            &["to 20 mm (the length measured)", "found 25 mm"],
        ),
        (
            &["line.csv", "--cutoff", "1um"],
            &["from 0.01 mm (5 steps)", "found 0.001 mm"],
        ),
        (&["short.csv"], &["the length measured", "measure a longer"]),
        (&["missing.csv"], &["without gaps", "point 99"]),
        (&["uneven.csv"], &["a step from", "resample"]),
        (&["bare.csv"], &["unit of the heights", "--z-unit"]),
        (
            &["bare.csv", "--z-unit", "um"],
            &["step between points", "--step"],
        ),
        (&["volts.csv"], &["units of length", "`V`"]),
    ];
    for (arguments, parts) in data {
        let arguments = [&["roughness"], arguments].concat();
        folder.run(&arguments).expect_failure(1, parts);
    }
    folder
        .run(&["roughness", "empty.csv"])
        .expect_failure(1, &["an empty file"]);
    folder
        .run(&["roughness", "absent.csv"])
        .expect_failure(1, &["no such file: absent.csv"]);
    let before = folder.names();
    folder
        .run(&[
            "roughness",
            "short.csv",
            "--report",
            "r.html",
            "--csv",
            "r.csv",
        ])
        .expect_failure(1, &[]);
    assert_eq!(
        folder.names(),
        before,
        "nothing is written where nothing was computed"
    );
    let stated = [
        "roughness",
        "bare.csv",
        "--z-unit",
        "um",
        "--step",
        "5um",
        "--filter",
        "none",
    ];
    folder.run(&stated).expect_success();
}

#[test]
fn a_units_statement_that_the_file_contradicts_is_said() {
    let folder = Folder::new();
    folder.write("line.csv", line());
    let value = folder
        .run(&["roughness", "line.csv", "--json", "--z-unit", "mm"])
        .json();
    let warning = value["warnings"][0]["text"].as_str().unwrap();
    assert!(warning.contains("was not used"), "{warning}");
    check(&value, "Ra", 2.0 / std::f64::consts::PI, 0.02);
}

/// Dots of 12 µm on a square of 80 µm, one of them not measured, with the lines along x.
#[test]
fn a_map_of_dots_gives_its_period_and_the_ra_of_its_lines() {
    let folder = Folder::new();
    let mut text = String::new();
    for row in 0..200 {
        for column in 0..240 {
            let off = |at: i32| f64::from((at * 2 + 40).rem_euclid(80) - 40);
            let height = 12.0 * f64::from(u8::from(off(row).hypot(off(column)) < 15.0));
            if (row, column) == (50, 60) {
                text.push_str("NaN ");
            } else {
                write!(text, "{height} ").unwrap();
            }
        }
        text.push('\n');
    }
    folder.write("dots.txt", text);
    let options = [
        "--step", "2um", "--z-unit", "um", "--along", "x", "--cutoff", "0.08mm",
    ];
    let mut words = vec!["roughness", "dots.txt"];
    words.extend(options);
    let done = folder.run(&words);
    done.expect_success();
    for part in [
        "Texture of dots: period 79.95 µm and 79.93 µm (0.0° from x)",
        "(20 whole dots, all alike)",
        "1 with points",
        "199 lines along x",
    ] {
        assert!(done.out().contains(part), "{part}: {}", done.out());
    }
    words.push("--json");
    let value = folder.run(&words).json();
    let texture = &value["texture"];
    check(texture, "period_um", 80.0, 0.005);
    check(texture, "height_um", 12.0, 0.05);
    // The base is lower after the L-filter of one period, and half the height with it.
    check(texture, "width_um", 30.0, 0.06);
    assert_eq!(texture["kind"], "dots");
    let lines = &value["lines"];
    assert_eq!(
        (lines["lines"].as_u64(), lines["incomplete"].as_u64()),
        (Some(199), Some(1))
    );
    assert_eq!(lines["cutoff_by"], "stated");
    assert!(lines["mean"]["Ra"].as_f64() > Some(0.5) && lines["law"].is_null());
    words.pop();
    words.extend(["--report", "r.html"]);
    folder.run(&words).expect_success();
    self_contained(&std::fs::read_to_string(folder.path("r.html")).unwrap());
}

#[test]
fn an_array_of_heights_takes_its_unit_and_step() {
    let folder = Folder::new();
    // Ridges of 0.4 mm, 20 µm high, in steps of 20 µm: an array of NumPy in mm.
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (60, 400), }";
    let header = format!("{header:<117}\n");
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    for _row in 0..60 {
        for column in 0..400 {
            let x = f64::from(column) * 0.02;
            let height = 0.01 * (std::f64::consts::TAU * x / 0.4).sin();
            bytes.extend(height.to_le_bytes());
        }
    }
    std::fs::write(folder.path("map.npy"), bytes).unwrap();
    let line = "roughness map.npy --step 20um --z-unit mm --json";
    let mut words: Vec<&str> = line.split(' ').collect();
    let done = folder.run(&words);
    done.expect_success();
    let value = done.json();
    check(&value["texture"], "period_um", 400.0, 0.01);
    words.extend(["--x-unit", "mm"]);
    folder.run(&words).expect_failure(2, &["--x-unit"]);
}
