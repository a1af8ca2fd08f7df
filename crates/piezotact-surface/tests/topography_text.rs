//! Topographies as text, in the ways that programs write them.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::support::{NOTHING, STATED, assert_heights, assert_refused, attack, map, parse};
use piezotact::recording::{RecordingWarning, Steps};
use piezotact_surface::Topography;
use piezotact_surface::TopographyKind;

#[test]
fn columns_fill_a_grid_in_any_order() {
    let metres = [1e-6, 2e-6, 3e-6, 4e-6, f64::NAN, 6e-6];
    for text in [
        "0,0,1\n0.002,0,2\n0.004,0,3\n0,0.002,4\n0.002,0.002,nan\n0.004,0.002,6\n",
        "0.004;0.002;6\n0;0;1\n0.002;0;2\n0.004;0;3\n0;0.002;4\n",
        "0\t0\t1\r\n0\t0,002\t4\r\n0,002\t0\t2\r\n0,004\t0\t3\r\n0,004\t0,002\t6\r\n",
        "0 0 1\n\n0,002 0 2\n0,004 0 3\n0 0,002 4\n0,004 0,002 6\n",
    ] {
        let read = parse(text.as_bytes(), &STATED).unwrap();
        assert_eq!(read.kind, TopographyKind::PointText, "{text}");
        assert_heights(&read, &metres);
        assert_eq!(map(&read).columns(), 3);
        assert!((map(&read).step_x_m() - 2e-6).abs() < 1e-12);
        assert_refused(text.as_bytes(), "unit of the coordinates");
        attack(text.as_bytes());
    }
    // A header that names units needs nobody's statement, and wins over one.
    for header in [
        "x (µm),y (µm),z (nm)\n",
        "# X [um], Y [um], Z [nm]\n",
        "x,y,z\num,um,nm\n",
    ] {
        let text = format!("{header}0,0,1\n1,0,2\n0,1,3\n1,1,4\n");
        let read = parse(text.as_bytes(), &NOTHING).unwrap();
        assert_heights(&read, &[1e-9, 2e-9, 3e-9, 4e-9]);
        assert_eq!(read.warnings, []);
        assert_eq!(parse(text.as_bytes(), &STATED).unwrap().warnings.len(), 2);
    }
    let refused = |text: &str, part: &str| {
        let error = parse(text.as_bytes(), &STATED).unwrap_err().to_string();
        assert!(error.contains(part), "{text}: {error}");
    };
    refused("0,0,1\n1,0,2\n0,1,3\n1,1,4\n1,1,5\n", "a second one");
    refused("0,0,1\n1,0,2\n0,1,3\nnan,1,4\n", "coordinates");
    refused("0,0,1\n1,0,2\n0,1,3\n1,1,4\n1e9,1,4\n", "a second one");
    refused("0,0,1\n1,0,2\n2.4,1,3\n3,1,4\n", "even steps in x");
    refused("0,0,1\n1,0,2\n2,0,4\n", "even steps in y");
    refused("0,0,1\n1,0,2\n0,1\n", "line 3");
    refused("0,0,1\n1,0,2\n0,1,a\n", "`a`");
    let diagonal: String = (0..100).map(|i| format!("{i},{i},1\n")).collect();
    refused(&diagonal, "a complete grid");
    let read = parse(b"0 0 1\n1.05 0 2\n0 1 3\n1 1 4\n2 1 4\n2 0 4\n", &STATED).unwrap();
    assert!(
        matches!(read.warnings.as_slice(), [warning] if matches!(warning.kind(), Some(RecordingWarning::UnevenSteps { of: Steps::Place, .. }))),
        "{:?}",
        read.warnings
    );
}

#[test]
fn a_matrix_states_its_scale_or_a_person_does() {
    let rows = "1 2 3 4\n5 6 --- 8\n";
    let metres = [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, f64::NAN, 8e-6];
    let gwyddion = "# Channel: Topography\n# Width: 8.0 µm\n# Height: 4.0 µm\n# Value units: µm\n";
    for (text, options) in [
        (rows.to_owned(), STATED),
        (rows.replace(' ', ","), STATED),
        (
            format!("h=2 w=4\npixel size=2e-6 m\nheight conversion factor (-> m)=1e-6\n{rows}"),
            NOTHING,
        ),
        (format!("{gwyddion}{}", rows.replace(' ', "\t")), NOTHING),
        (
            format!(
                "# Kanal: Topography\n# Breite: 8.0 µm\n# Höhe: 4.0 µm\n# Value units: µm\n{rows}"
            ),
            NOTHING,
        ),
    ] {
        let read = parse(text.as_bytes(), &options).unwrap();
        assert_eq!(read.kind, TopographyKind::MatrixText);
        assert_heights(&read, &metres);
        assert!((map(&read).step_x_m() - 2e-6).abs() < 1e-12);
        attack(text.as_bytes());
    }
    // µ in Latin-1, two columns, and steps that differ.
    let latin: Vec<u8> = gwyddion
        .replace("4.0", "6.0")
        .chars()
        .map(|c| c as u8)
        .chain(*b"1 2\n3 4\n")
        .collect();
    let read = parse(&latin, &NOTHING).unwrap();
    assert!((map(&read).step_y_m() - 3e-6).abs() < 1e-12);
    assert_refused(rows.as_bytes(), "step between points");
    assert_refused(format!("h=3 w=4\n{rows}").as_bytes(), "3 rows");
    let flat = format!("pixel size=2e-6 m\nheight conversion factor (-> m)=0\n{rows}");
    assert_refused(flat.as_bytes(), "above zero");
    assert_refused(b"nothing\nof note\n", "rows of numbers");
    assert_refused(b"", "empty");
    assert_refused(b"\x7fELF\0\0\0", "unknown kind");
    let marker = format!("{rows}1 2 3 1e30\n");
    let error = parse(marker.as_bytes(), &STATED).unwrap_err().to_string();
    assert!(error.contains("not measured"), "{error}");
}

#[test]
fn profiles_come_in_one_column_and_in_two() {
    let heights: Vec<f64> = (0..9).map(|i| f64::from(i) * 1e-6).collect();
    let two: String = (0..9)
        .map(|i| format!("{}\t{i}\n", f64::from(i) * 0.002))
        .collect();
    let one: String = (0..9).map(|i| format!("{i}\n")).collect();
    let reversed: String = (0..9)
        .map(|i| format!("{} {}\n", 0.016 - f64::from(i) * 0.002, 8 - i))
        .collect();
    for (text, kind) in [
        (&two, TopographyKind::ProfileText),
        (&reversed, TopographyKind::ProfileText),
        (&one, TopographyKind::HeightText),
    ] {
        let read = parse(text.as_bytes(), &STATED).unwrap();
        assert_eq!(read.kind, kind);
        assert_heights(&read, &heights);
        let Topography::Profile(profile) = &read.topography else {
            unreachable!("a profile");
        };
        assert!((profile.step_m() - 2e-6).abs() < 1e-12);
        assert_refused(text.as_bytes(), "unit of the");
    }
    let error = |text: &str| parse(text.as_bytes(), &STATED).unwrap_err().to_string();
    assert!(error(&two.replace("0.008", "0.0091")).contains("a step from"));
    assert!(error(&two.replace("\t4", "\tnan")).contains("without gaps"));
    assert!(error("0 1\n").contains("two points"));
    let surfcom = "4.0\n8\n1.5\n2\n3\n4\n5\n6\n7\n8\n";
    let read = parse(surfcom.as_bytes(), &NOTHING).unwrap();
    assert_eq!(read.kind, TopographyKind::Surfcom);
    assert_heights(&read, &[1.5e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 7e-6, 8e-6]);
    let Topography::Profile(profile) = &read.topography else {
        unreachable!("a profile");
    };
    assert!((profile.step_m() - 0.5e-3).abs() < 1e-12);
    attack(surfcom.as_bytes());
    assert_refused(surfcom.replace("7\n", "").as_bytes(), "8 heights");
}
