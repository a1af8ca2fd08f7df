//! The spectrum over time on the command line.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{Folder, noise, wav};

/// However long the recording and however fine its lines, the figure over time says what it shows and stays small, and so does the document.
#[test]
fn a_figure_over_time_stays_small() {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(1_000_000), 5_000));
    for settings in [
        &[][..],
        &["--segment", "16384", "--max-frequency", "2500"],
        &["--segment", "64", "--overlap", "0"],
    ] {
        let command = "spectrum texture.wav --over-time --report time.html --figures time --json";
        let command: Vec<&str> = command.split(' ').collect();
        let document = folder
            .run(&[&command[..], &["--scale", "2 m/s2"], settings].concat())
            .json();
        let over_time = &document["over_time"];
        let count = |list: &serde_json::Value| list.as_array().map_or(0, Vec::len);
        let (times, frequencies) = (
            count(&over_time["times_s"]),
            count(&over_time["frequencies_hz"]),
        );
        assert!((100..=600).contains(&times), "{settings:?}: {times}");
        assert!(
            (13..=300).contains(&frequencies),
            "{settings:?}: {frequencies}"
        );
        let rows = over_time["psd"].as_array().unwrap();
        assert_eq!(rows.len(), frequencies, "{settings:?}");
        assert!(rows.iter().all(|row| count(row) == times), "{settings:?}");
        let figure = std::fs::read_to_string(folder.path("time/02-over-time.svg")).unwrap();
        assert!(figure.len() < 500_000, "{settings:?}: {}", figure.len());
        for part in [
            ">texture.wav, ",
            ">hann window, ",
            // Long lines are broken between words.
            "averaged",
            ">time, s<",
            ">frequency, Hz<",
            ">PSD, dB re 1 (m/s²)²/Hz<",
        ] {
            assert!(figure.contains(part), "{settings:?}: no {part}");
        }
    }
}
