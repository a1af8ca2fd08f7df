//! Heights in arrays without units: NumPy's and MATLAB's.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_surface::{Topography, TopographyKind, TopographyOptions};

use crate::support::{NOTHING, STATED, assert_heights, assert_refused, attack, map, parse};

/// Three rows of four heights in µm, one of them not measured.
const ROWS: [[f64; 4]; 3] = [
    [1.0, 2.0, 3.0, 4.0],
    [5.0, f64::NAN, 7.0, 8.0],
    [9.0, 10.0, 11.0, 12.5],
];

fn heights_m() -> Vec<f64> {
    ROWS.concat().iter().map(|z| z * 1e-6).collect()
}

/// An array of `kind`, as NumPy saves it; `data` in the order of the file.
fn npy(kind: &str, in_columns: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '{kind}', 'fortran_order': {in_columns}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn bytes(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(f64::to_le_bytes).collect()
}

fn by_columns() -> Vec<f64> {
    (0..4)
        .flat_map(|column| ROWS.map(|row| row[column]))
        .collect()
}

/// A double matrix of a MATLAB file of version 5: name, sides, numbers down the columns.
fn variable(name: &str, [rows, columns]: [u32; 2], real: Vec<f64>) -> Vec<u8> {
    let part = |kind: u32, data: &[u8]| {
        let mut part = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        part.extend(data);
        part.resize(part.len().next_multiple_of(8), 0);
        part
    };
    let sides = [rows.to_le_bytes(), columns.to_le_bytes()].concat();
    let parts = [
        part(6, &[6_u32.to_le_bytes(), [0; 4]].concat()),
        part(5, &sides),
        part(1, name.as_bytes()),
        part(9, &bytes(real)),
    ];
    part(14, &parts.concat())
}

fn mat(variables: Vec<Vec<u8>>) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend(b"\x00\x01IM");
    file.extend(variables.concat());
    file
}

#[test]
fn rows_and_columns_of_an_array_are_those_of_the_map() {
    let files = [
        (
            npy("<f8", "False", "(3, 4)", &bytes(ROWS.concat())),
            TopographyKind::Npy,
        ),
        (
            npy("<f8", "True", "(3, 4)", &bytes(by_columns())),
            TopographyKind::Npy,
        ),
        (
            mat(vec![variable("a", [3, 4], by_columns())]),
            TopographyKind::Mat,
        ),
    ];
    for (file, kind) in files {
        let read = parse(&file, &STATED).unwrap();
        assert_eq!(read.kind, kind);
        let map = map(&read);
        assert_eq!((map.columns(), map.rows()), (4, 3));
        assert_eq!((map.step_x_m(), map.step_y_m()), (2e-6, 2e-6));
        assert_heights(&read, &heights_m());
        attack(&file);
    }
    // Counts of a sensor, whose unit is what one of them is.
    let counts: Vec<u8> = (1_i16..=6).flat_map(i16::to_be_bytes).collect();
    let options = TopographyOptions {
        height_unit_m: Some(2.5e-9),
        ..STATED
    };
    let read = parse(&npy(">i2", "False", "(2, 3)", &counts), &options).unwrap();
    let expected: Vec<f64> = (1..=6).map(|z| f64::from(z) * 2.5e-9).collect();
    assert_heights(&read, &expected);
}

#[test]
fn one_line_is_a_profile() {
    let line = [1.0, 2.0, 4.0, 3.0, 1.0, 2.0, 5.0, 2.5];
    let files = [
        npy("<f8", "False", "(8,)", &bytes(line)),
        npy("<f8", "False", "(1, 8)", &bytes(line)),
        npy("<f8", "False", "(8, 1)", &bytes(line)),
        mat(vec![variable("z", [8, 1], line.to_vec())]),
        mat(vec![variable("z", [1, 8], line.to_vec())]),
    ];
    for file in files {
        let read = parse(&file, &STATED).unwrap();
        assert!(matches!(read.topography, Topography::Profile(_)));
        assert_heights(&read, &line.map(|z| z * 1e-6));
    }
}

#[test]
fn unit_and_step_are_never_guessed() {
    let files = [
        npy("<f8", "False", "(3, 4)", &bytes(ROWS.concat())),
        mat(vec![variable("z", [3, 4], by_columns())]),
    ];
    for file in files {
        assert_refused(&file, "--z-unit");
        let options = TopographyOptions {
            height_unit_m: Some(1e-6),
            ..NOTHING
        };
        let said = parse(&file, &options).unwrap_err().to_string();
        assert!(said.contains("--step"), "{said}");
        for step_m in [0.0, -1e-6, f64::NAN] {
            let options = TopographyOptions {
                step_m: Some(step_m),
                ..options
            };
            let said = parse(&file, &options).unwrap_err().to_string();
            assert!(said.contains("above zero"), "{said}");
        }
    }
}

#[test]
fn heights_among_other_matrices_are_known_by_name_or_refused() {
    let grid = || {
        ["X", "Y"]
            .map(|name| variable(name, [3, 4], by_columns()))
            .to_vec()
    };
    let mut named = grid();
    named.push(variable("Z", [3, 4], by_columns()));
    named.push(variable("dx", [1, 1], vec![0.5]));
    let read = parse(&mat(named), &STATED).unwrap();
    assert_heights(&read, &heights_m());
    let said = read.warnings[0].to_string();
    assert!(said.contains("`Z` is taken as the heights"), "{said}");
    assert!(said.contains("`X`, `Y`, `dx` were left out"), "{said}");
    assert_refused(&mat(grid()), "`X` (3 × 4), `Y` (3 × 4)");
    assert_refused(&mat(vec![variable("a", [1, 1], vec![1.0])]), "found none");
}

#[test]
fn arrays_that_are_no_map_are_refused() {
    let wrong = [
        (
            npy("<f8", "False", "(1, 3, 4)", &bytes(ROWS.concat())),
            "3 dimensions",
        ),
        (
            npy("<f8", "False", "(3, 4)", &bytes(ROWS.concat())[..90]),
            "90 of its 96 bytes",
        ),
        (
            npy("<c16", "False", "(3, 2)", &bytes(ROWS.concat())),
            "complex numbers",
        ),
        (npy("<f8", "False", "(0, 4)", &[]), "points"),
    ];
    for (file, part) in wrong {
        let said = parse(&file, &STATED).unwrap_err().to_string();
        assert!(said.contains(part), "no {part} in {said}");
    }
}
