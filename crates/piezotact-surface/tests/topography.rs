//! Topographies that real instruments wrote, against what `SurfaceTopography` 1.27.1 and the instruments' own
//! programs say of them, and damaged in thousands of ways. The files lie beside the checkout, in
//! `../shared/data`; without them a test says that it was skipped, and with `CI=true` it fails.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test that reads reference files, and fails where they cannot be read"
)]

use crate::shared_data;
use piezotact_surface::{HeightsFault, SurfaceWarning};
use std::path::PathBuf;

use crate::support::Lcg;
use piezotact::Warning;
use piezotact::surface::HeightMap;
use piezotact_surface::Topography;
use piezotact_surface::topography::parse_topography;
use piezotact_surface::{TopographyKind, TopographyOptions, read_topography, write_sur};

/// The same formulae in other orders of summation, on heights that may be stored as 32-bit floats.
const RTOL: f64 = 1e-6;

const FILES: [(&str, TopographyKind); 11] = [
    ("surfacetopography/al3d-1.al3d", TopographyKind::Al3d),
    ("surfacetopography/bcrf-1.bcrf", TopographyKind::Bcrf),
    ("surfacetopography/matrix-4.txt", TopographyKind::MatrixText),
    ("surfacetopography/plu-1.plu", TopographyKind::Plu),
    ("surfacetopography/sdf-1.sdf", TopographyKind::SdfText),
    ("surfacetopography/sur-3.sur", TopographyKind::Sur),
    ("surfacetopography/x3p-2.x3p", TopographyKind::X3p),
    ("nanovea/test1.txt", TopographyKind::PointText),
    ("surfacetopography/xy-4.txt", TopographyKind::ProfileText),
    ("surfcom/specimen_1_primary.tx1", TopographyKind::Surfcom),
    ("surfcom/specimen_1_roughness.tx2", TopographyKind::Surfcom),
];

/// A measured topography.
fn shared(path: &str) -> Option<PathBuf> {
    shared_data::shared(&format!("data/topography/{path}"))
}

/// What a person who knows the file states: nothing where the file says it.
fn options(file: &str) -> TopographyOptions {
    let units = |coordinate_unit_m, height_unit_m| TopographyOptions {
        coordinate_unit_m: Some(coordinate_unit_m),
        height_unit_m: Some(height_unit_m),
        step_m: None,
    };
    match file {
        "nanovea/test1.txt" => units(1e-3, 1e-6),
        "surfacetopography/xy-4.txt" => units(1e-3, 1e-3),
        _ => TopographyOptions::default(),
    }
}

fn heights_of(topography: &Topography) -> (&[f64], usize, f64, f64) {
    match topography {
        Topography::Map(map) => (
            map.heights_m(),
            map.columns(),
            map.step_x_m(),
            map.step_y_m(),
        ),
        Topography::Profile(profile) => (
            profile.heights_m(),
            profile.heights_m().len(),
            profile.step_m(),
            profile.step_m(),
        ),
    }
}

/// Heights above their mean; points that were not measured are left out.
fn above_mean(heights_m: &[f64]) -> (Vec<f64>, f64) {
    let measured: Vec<f64> = heights_m.iter().copied().filter(|z| !z.is_nan()).collect();
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    (measured.iter().map(|z| z - mean).collect(), mean)
}

fn moment(off: &[f64], power: i32) -> f64 {
    off.iter().map(|z| z.powi(power)).sum::<f64>() / off.len() as f64
}

fn sq_m(topography: &Topography) -> f64 {
    moment(&above_mean(heights_of(topography).0).0, 2).sqrt()
}

fn assert_near(what: &str, got: f64, expected: f64, tolerance: f64) {
    assert!(
        (got - expected).abs() <= tolerance,
        "{what}: got {got}, expected {expected}"
    );
}

#[test]
fn every_file_is_what_another_program_reads() {
    let golden: serde_json::Value =
        serde_json::from_str(include_str!("golden/topography.json")).unwrap();
    let cases = golden.as_array().unwrap();
    assert_eq!(cases.len(), FILES.len());
    for (file, kind) in FILES {
        let Some(path) = shared(file) else { continue };
        let case = cases.iter().find(|case| case["file"] == file).unwrap();
        let figure = |key: &str| case[key].as_f64().unwrap();
        let read = read_topography(&path, &options(file)).unwrap();
        assert_eq!(read.kind, kind, "{file}");
        let (heights, columns, step_x_m, step_y_m) = heights_of(&read.topography);
        let rows = heights.len() / columns;
        assert_eq!(
            (rows as f64, columns as f64),
            (figure("rows"), figure("columns"))
        );
        let missing = heights.iter().filter(|z| z.is_nan()).count();
        assert_eq!(missing as f64, figure("missing"), "{file}");
        for (key, step) in [("step_x_m", step_x_m), ("step_y_m", step_y_m)] {
            assert_near(
                &format!("{file} {key}"),
                step,
                figure(key),
                RTOL * figure(key),
            );
        }
        let (off, mean) = above_mean(heights);
        let sq = figure("sq_m");
        let (low, high) = off.iter().fold((0.0, 0.0), |(low, high): (f64, f64), z| {
            (low.min(*z), high.max(*z))
        });
        for (key, got, tolerance) in [
            ("sq_m", moment(&off, 2).sqrt(), RTOL * sq),
            ("ssk", moment(&off, 3) / sq.powi(3), 1e-5),
            ("sku", moment(&off, 4) / sq.powi(4), 1e-5 * figure("sku")),
            ("lowest_m", low, RTOL * sq),
            ("highest_m", high, RTOL * sq),
        ] {
            assert_near(&format!("{file} {key}"), got, figure(key), tolerance);
        }
        for (key, at) in [
            ("first_m", 0),
            ("second_m", 1),
            ("end_of_first_row_m", columns - 1),
            ("last_m", heights.len() - 1),
        ] {
            match case[key].as_f64() {
                None => assert!(heights[at].is_nan(), "{file} {key}"),
                // A mean of 50 mm in 32-bit floats: the golden program's rounding.
                Some(z) => assert_near(&format!("{file} {key}"), heights[at] - mean, z, 1e-5 * sq),
            }
        }
        let expected: Vec<Warning> = match missing {
            0 => Vec::new(),
            _ => vec![Warning::from(SurfaceWarning::Heights {
                fault: HeightsFault::Missing {
                    share: missing as f64 / heights.len() as f64,
                },
            })],
        };
        assert_eq!(read.warnings, expected, "{file}");
    }
}

/// Published values: the root mean square of all points above their mean, no plane removed.
#[test]
fn raw_sq_is_as_published() {
    for (file, sq) in [
        ("surfacetopography/plu-1.plu", 2.834391e-6),
        ("surfacetopography/bcrf-1.bcrf", 24.560207e-9),
        ("surfacetopography/al3d-1.al3d", 7.688266e-6),
    ] {
        let Some(path) = shared(file) else { continue };
        let read = read_topography(&path, &TopographyOptions::default()).unwrap();
        assert_near(file, sq_m(&read.topography), sq, 1e-5 * sq);
    }
}

/// Archives of others, against `SurfaceTopography`, x3ptools and a reading of zip and XML by hand (`expected.json` beside them):
/// columns, rows, points that were not measured, Sq in m.
#[test]
fn archives_are_what_other_programs_read() {
    for (file, columns, rows, missing, sq) in [
        ("openfmc/ISO5436-sample1.x3p", 4, 4, 1, 0.610_509_154_5),
        ("openfmc/ISO5436-sample1_bin.x3p", 4, 4, 1, 0.610_509_154_5),
        ("openfmc/ISO5436-sample4.x3p", 4, 4, 1, 0.610_537_577_3),
        ("openfmc/ISO5436-sample4_bin.x3p", 4, 4, 1, 0.610_537_577_3),
        (
            "openfmc/KautschukInfiniteFocus.x3p",
            860,
            634,
            5296,
            3.398_871_811e-6,
        ),
        ("x3ptools/sample-land.x3p", 918, 256, 25_292, 34.334_27e-6),
    ] {
        let Some(path) = shared(file) else { continue };
        let read = read_topography(&path, &TopographyOptions::default()).unwrap();
        let (heights, found, _, _) = heights_of(&read.topography);
        let not_measured = heights.iter().filter(|z| z.is_nan()).count();
        assert_eq!(
            (found, heights.len() / found, not_measured),
            (columns, rows, missing),
            "{file}"
        );
        // Sq as published has seven digits.
        assert_near(file, sq_m(&read.topography), sq, 2e-7 * sq);
    }
}

/// The instrument's own roughness profile has the Ra and Rq that it prints.
#[test]
fn surfcom_profiles_have_the_instruments_roughness() {
    let Some(path) = shared("surfcom/specimen_1_roughness.tx2") else {
        return;
    };
    let read = read_topography(&path, &TopographyOptions::default()).unwrap();
    let Topography::Profile(profile) = &read.topography else {
        unreachable!("a profile");
    };
    assert_eq!(profile.heights_m().len(), 28_087);
    assert_near("length", profile.length_m(), 10e-3, 1e-12);
    // Its mean line is 17 nm off zero; with it Ra would be 3.0657 µm.
    let (off, _) = above_mean(profile.heights_m());
    let ra = off.iter().map(|z| z.abs()).sum::<f64>() / off.len() as f64;
    assert_near("Ra", ra, 3.065e-6, 0.0005e-6);
    assert_near("Rq", moment(&off, 2).sqrt(), 5.903e-6, 0.0005e-6);
}

#[test]
fn a_text_without_units_is_refused_in_one_sentence() {
    for (file, part) in [
        ("nanovea/test1.txt", "unit of the coordinates"),
        ("surfacetopography/xy-4.txt", "unit of the coordinates"),
    ] {
        let Some(path) = shared(file) else { continue };
        let error = read_topography(&path, &TopographyOptions::default()).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn a_written_sur_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    for (file, _) in FILES {
        let Some(path) = shared(file) else { continue };
        let Topography::Map(map) = read_topography(&path, &options(file)).unwrap().topography
        else {
            continue;
        };
        let copy = folder.path().join("copy.sur");
        write_sur(&copy, &map).unwrap();
        let read = read_topography(&copy, &TopographyOptions::default()).unwrap();
        let Topography::Map(back) = read.topography else {
            unreachable!("a map");
        };
        assert_eq!(
            (read.kind, back.rows(), back.columns()),
            (TopographyKind::Sur, map.rows(), map.columns())
        );
        assert_near(file, back.step_x_m(), map.step_x_m(), 1e-7 * map.step_x_m());
        assert_near(file, back.step_y_m(), map.step_y_m(), 1e-7 * map.step_y_m());
        let range = heights_range(&map);
        for (a, b) in map.heights_m().iter().zip(back.heights_m()) {
            assert_eq!(a.is_nan(), b.is_nan(), "{file}");
            // The offset is a 32-bit float, and the lowest height one ulp above it.
            let tolerance = range * 2f64.powi(-30) + a.abs() * 1e-15;
            assert!(a.is_nan() || (a - b).abs() <= tolerance, "{file}: {a} {b}");
        }
    }
}

fn heights_range(map: &HeightMap) -> f64 {
    let measured = || map.heights_m().iter().copied().filter(|z| !z.is_nan());
    measured().fold(f64::NEG_INFINITY, f64::max) - measured().fold(f64::INFINITY, f64::min)
}

/// How many bytes of a file its heights and what states their number need. Pictures and remarks may follow;
/// x-y-z and x-z columns may end after any row; of a last number in text, the first digit is a number too.
fn needed(kind: TopographyKind, bytes: &[u8]) -> usize {
    let before_last_word = |bytes: &[u8]| {
        let end = bytes.trim_ascii_end();
        end.iter().rposition(u8::is_ascii_whitespace).unwrap() + 1
    };
    match kind {
        TopographyKind::PointText | TopographyKind::ProfileText => 0,
        TopographyKind::Al3d => 1261 + 200 * 296 * 4,
        TopographyKind::Plu => 508 + 768 * 576 * 4,
        TopographyKind::MatrixText | TopographyKind::Surfcom => before_last_word(bytes),
        TopographyKind::SdfText => {
            let end = bytes.iter().position(|byte| *byte == b'*').unwrap();
            let second = bytes[end + 1..].iter().position(|byte| *byte == b'*');
            before_last_word(&bytes[..end + 1 + second.unwrap()])
        }
        _ => bytes.len(),
    }
}

#[test]
fn no_truncation_is_read_as_a_whole_file_or_panics() {
    for (file, kind) in FILES {
        let Some(path) = shared(file) else { continue };
        let bytes = std::fs::read(&path).unwrap();
        let needed = needed(kind, &bytes);
        let mut random = Lcg(7);
        let near_the_end = needed.saturating_sub(30)..needed + 2;
        for length in (0..700)
            .chain(near_the_end)
            .chain(std::iter::repeat_with(|| random.below(bytes.len())).take(40))
        {
            let Some(part) = bytes.get(..length) else {
                continue;
            };
            let read = parse_topography(&path, part, &options(file));
            assert!(
                length >= needed || read.is_err(),
                "{file} cut to {length} bytes"
            );
        }
    }
}

/// Where the header of a file is; of text, its first lines, and of X3P, the directory of the archive.
fn header(kind: TopographyKind, length: usize) -> std::ops::Range<usize> {
    match kind {
        TopographyKind::Sur => 0..512,
        TopographyKind::Plu => 0..508,
        TopographyKind::Al3d => 0..1261,
        TopographyKind::Bcrf => 0..800,
        TopographyKind::X3p => length - 2000..length,
        _ => 0..length.min(400),
    }
}

#[test]
fn no_flipped_byte_of_a_header_panics() {
    flipped(&[10, 190]);
}

#[test]
#[ignore = "2000 bytes of every file; ./x soak numbers"]
fn soak_no_flipped_byte_of_a_header_panics() {
    flipped(&[300, 1700]);
}

/// Flips so many bytes of the header of each file, as it is and cut short.
fn flipped(&[whole_times, short_times]: &[u32; 2]) {
    for (file, kind) in FILES {
        let Some(path) = shared(file) else { continue };
        let whole = std::fs::read(&path).unwrap();
        let mut random = Lcg(42);
        let header = header(kind, whole.len());
        // A file with few of its heights is quicker, and its header is read all the same.
        let short = whole[..whole.len().min(20_000)].to_vec();
        for (mut damaged, times) in [(whole, whole_times), (short, short_times)] {
            for _ in 0..times {
                let at = header.start + random.below(header.len());
                let Some(before) = damaged.get(at).copied() else {
                    continue;
                };
                damaged[at] ^= 1 + random.below(255) as u8;
                if let Err(error) = parse_topography(&path, &damaged, &options(file)) {
                    assert!(error.to_string().contains(';'), "{error}");
                }
                damaged[at] = before;
            }
        }
    }
}
