//! `strokes` and `compare` on recordings of other laboratories, with their known values.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{Folder, shared};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The ridged board of 2 mm: what the four speeds agree on, from the files as they are.
#[test]
fn the_ridges_of_a_measured_board_come_out_of_four_speeds() {
    let Some(folder) = shared("data/vibration/fabricslide") else {
        return;
    };
    let files = |board: &str| -> Vec<String> {
        [5, 10, 20, 30]
            .map(|v| {
                folder
                    .join(format!("Board{board}_F135_V-{v}mmps_0.csv"))
                    .to_string_lossy()
                    .into_owned()
            })
            .to_vec()
    };
    let here = Folder::new();
    let compared = |files: &[String]| {
        let mut arguments = vec!["compare"];
        arguments.extend(files.iter().map(String::as_str));
        arguments.extend(["--by", "speed", "--json"]);
        here.run(&arguments).json()
    };
    let fine = compared(&files("2mm"));
    assert_eq!(fine["period"]["outcome"], "met", "{}", fine["period"]);
    let period = 1e3 * number(&fine["period"]["period_m"]);
    assert!((3.96..=3.98).contains(&period), "{period}");
    // The index reads the peaks off bins at a rate of 1/28 ms; the time stamps' own rate is 0.3 % lower.
    for (peak, hz) in fine["period"]["peaks"]
        .as_array()
        .unwrap()
        .iter()
        .zip([1.26, 2.51, 5.02, 7.58])
    {
        assert!(
            (number(&peak["frequency_hz"]) / hz - 1.0).abs() < 0.01,
            "{peak}"
        );
    }
    let shown = here.run(&["info", &files("2mm")[0]]);
    let shown = shown.out();
    assert!(
        shown.contains("condition: sample Board2mm") && shown.contains("speed 0.005 m/s"),
        "{shown}"
    );
    let coarse = &compared(&files("10mm"))["period"];
    assert_eq!(coarse["outcome"], "met", "{coarse}");
    let coarse = 1e3 * number(&coarse["period_m"]);
    assert!((coarse - 20.0).abs() < 0.2, "{coarse}");
    // The same pattern as a person writes it.
    let mut stated = vec!["compare"];
    let names = files("2mm");
    stated.extend(names.iter().map(String::as_str));
    stated.extend([
        "--by",
        "speed",
        "--json",
        "--meta",
        "{sample}_F{load}_V-{speed:mm/s}mmps_{repeat}",
    ]);
    let again = here.run(&stated).json();
    assert_eq!(again["period"]["period_m"], fine["period"]["period_m"]);
    assert!(
        again["warnings"]
            .to_string()
            .contains("{load} in the name pattern has no unit")
    );
}

/// Two fabrics at four speeds: levels and durations, and their order.
#[test]
fn levels_and_durations_of_measured_fabrics_are_the_known_ones() {
    let Some(folder) = shared("data/vibration/textsense") else {
        return;
    };
    let here = Folder::new();
    for (fabric, known, first_s, last_s) in [
        ("text3", [0.00072, 0.00067, 0.00096, 0.00132], 2.67, 0.89),
        ("text9", [0.00055, 0.00065, 0.00088, 0.00126], 3.04, 0.87),
    ] {
        let files = [1, 2, 3, 4].map(|v| {
            folder
                .join(format!("{fabric}_v{v}.wav"))
                .to_string_lossy()
                .into_owned()
        });
        let mut arguments = vec!["strokes"];
        arguments.extend(files.iter().map(String::as_str));
        arguments.extend(["--meta", "{sample}_{run}", "--by", "file", "--json"]);
        let json = here.run(&arguments).json();
        let strokes: Vec<&Value> = json["recordings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|r| &r["strokes"][0])
            .collect();
        for (stroke, known) in strokes.iter().zip(known) {
            assert!(
                (number(&stroke["rms"]) - known).abs() < 5.1e-6,
                "{fabric}: {stroke}"
            );
        }
        assert!((number(&strokes[0]["duration_s"]) - first_s).abs() < 0.005);
        assert!((number(&strokes[3]["duration_s"]) - last_s).abs() < 0.005);
        let rms: Vec<f64> = strokes.iter().map(|s| number(&s["rms"])).collect();
        assert!(rms[3] > rms[2] && rms[2] > rms[1].max(rms[0]), "{rms:?}");
        assert_eq!(json["recordings"][0]["unit"], "FS");
    }
}
