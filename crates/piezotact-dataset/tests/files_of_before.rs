//! Files of earlier versions stay readable: the README of each version in `tests/data` says how they were made.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::PathBuf;

use piezotact::Doubt;
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{BenchKind, Touch};
use piezotact::stroke::Cut;
use piezotact_dataset::{
    Contents, FileKind, PanelFolder, ReadOptions, holds_transfer, read_cuts, read_recording,
    read_transfer,
};

fn file(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/v0.1.0")).join(name)
}

fn recording(name: &str) -> Contents {
    read_recording(&file(name), &ReadOptions::default()).unwrap()
}

/// The largest absolute sample of a channel.
fn peak(contents: &Contents, channel: usize) -> f64 {
    piezotact::statistics::peak(&contents.recording.channels()[channel].samples)
}

#[track_caller]
fn within(found: f64, expected: f64) {
    // Files hold the values whole: what is left is the text of the expected value.
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs(),
        "{found} {expected}"
    );
}

#[track_caller]
fn assert_doubts(found: &[Doubt], parts: &[&str]) {
    let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), parts.len(), "{texts:?}");
    for (text, part) in texts.iter().zip(parts) {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// What rendering through `tf.json` left open.
const OF_THE_DRIVE: [&str; 4] = [
    "lowest 0.668 at 78 Hz",
    "1.8 ± 0.2 ms after the drive",
    "60–97.7 Hz",
    "12 % of the texture's power",
];

#[test]
fn a_recording_that_was_played_keeps_its_drive() {
    let read = recording("played.parquet");
    assert_eq!(read.kind, FileKind::PARQUET);
    let r = &read.recording;
    assert_eq!((r.rate().hz(), r.len()), (5000.0, 6500));
    let channels: Vec<_> = r
        .channels()
        .iter()
        .map(|c| (c.name.as_str(), c.unit.clone()))
        .collect();
    assert_eq!(
        channels,
        [
            ("drive", Unit::FullScale),
            ("acceleration", Unit::MetrePerSecondSquared),
            ("normal_force", Unit::Newton)
        ]
    );
    within(peak(&read, 1), 1.092_003_083_524_834_2);
    assert_eq!(r.about.condition.person().unwrap(), "P02 (twin of seed 7)");
    assert_eq!(r.about.condition.touch, Some(Touch::Resting));
    assert_eq!(r.about.provenance.bench, Some(BenchKind::Twin));
    assert_eq!(r.about.provenance.steps.len(), 3);
    assert_doubts(&r.about.doubts, &[]);
    assert_eq!(read.setup.unwrap().gain.to_string(), "B3");
    let rendering = read.rendering.unwrap();
    assert_eq!(rendering.target, "texture.wav");
    assert_eq!(
        rendering.about.condition.participant.as_deref(),
        Some("P01")
    );
    assert_eq!(rendering.config.inverse.regularisation, 9e-6);
    assert_eq!(rendering.about.provenance.made_with.len(), 1);
    assert_doubts(&rendering.about.doubts, &OF_THE_DRIVE);
}

#[test]
fn a_recording_keeps_its_doubts() {
    let read = recording("doubted.parquet");
    let r = &read.recording;
    assert_eq!((r.rate().hz(), r.len()), (1000.0, 1000));
    within(r.channels()[0].samples[999], (999.0_f64 * 0.37).sin());
    assert_eq!(r.about.condition.sample.as_deref(), Some("S8"));
    assert_eq!(r.about.condition.speed_m_s, Some(0.06));
    assert_doubts(
        &r.about.doubts,
        &[
            "mean normal force was 0.310 N",
            "25 % of the samples of acceleration",
        ],
    );
}

#[test]
fn an_interrupted_recording_is_read_by_its_name_and_by_its_journal_s() {
    for name in ["interrupted.parquet", "interrupted.parquet.part"] {
        let read = recording(name);
        assert_eq!(read.kind, FileKind::JOURNAL);
        let r = &read.recording;
        assert_eq!((r.rate().hz(), r.len()), (1000.0, 1000));
        within(r.channels()[0].samples[999], (999.0_f64 * 0.37).sin());
        assert_eq!(r.about.condition.person().unwrap(), "P03 (twin of seed 7)");
        assert_doubts(
            &r.about.doubts,
            &["1.000 s could be read", "has no checksums"],
        );
    }
}

#[test]
fn a_drive_keeps_how_it_was_made() {
    let read = recording("drive.wav");
    let r = &read.recording;
    assert_eq!((r.rate().hz(), r.len()), (5000.0, 4000));
    assert_eq!(r.channels()[0].unit, Unit::FullScale);
    within(peak(&read, 0), 0.094_071_067_869_663_24);
    assert_eq!(r.about.condition.load_n.unwrap().0, 0.2);
    assert!(r.about.provenance.lineage.is_some());
    assert_doubts(&r.about.doubts, &[]);
    let rendering = read.rendering.unwrap();
    assert_eq!(rendering.headroom.limited_by.to_string(), "the amplifier");
    assert_eq!(rendering.achievable_band_hz[0].low().0, 97.65625);
    assert_doubts(&rendering.about.doubts, &OF_THE_DRIVE);
}

#[test]
fn a_manipulated_texture_keeps_its_lineage() {
    let read = recording("manipulated.wav");
    let r = &read.recording;
    assert_eq!((r.rate().hz(), r.len()), (5000.0, 1500));
    assert_eq!(r.channels()[0].unit, Unit::MetrePerSecondSquared);
    within(peak(&read, 0), 1.504_069_531_353_933_6);
    let lineage = serde_json::to_value(r.about.provenance.lineage.as_ref().unwrap()).unwrap();
    assert_eq!(lineage["source"], "texture.wav");
    assert_eq!(lineage["steps"].as_array().unwrap().len(), 2);
    assert_doubts(&r.about.doubts, &[]);
}

#[test]
fn a_transfer_function_keeps_its_doubts() {
    let path = file("tf.json");
    assert!(holds_transfer(&path));
    let read = read_transfer(&path).unwrap();
    assert_eq!((read.real.len(), read.averages), (65, 194));
    assert_eq!(read.real[5], 3.390_463_230_563_537_6);
    assert_eq!(read.coherence[5], 0.918_910_215_098_680_5);
    assert_eq!(
        read.about.condition.person().unwrap(),
        "P01 (twin of seed 7)"
    );
    assert_doubts(
        &read.about.doubts,
        &["1.8 ± 0.2 ms after the drive", "lowest 0.543 at 39 Hz"],
    );
}

#[test]
fn a_panel_is_read_with_what_it_lists() {
    let contents = PanelFolder::open(&file("panel")).unwrap().read().unwrap();
    let [entry] = contents.panel.as_slice() else {
        unreachable!("one measurement")
    };
    assert_eq!(entry.filing.participant, "P01");
    assert_eq!(entry.function.response()[5].re, -10.524_351_313_083_312);
    assert_eq!(contents.drive_unit, Unit::FullScale);
    assert_eq!(entry.function.about.doubts.len(), 4);
    assert!(
        entry.function.about.doubts[2]
            .to_string()
            .contains("mean normal force was 0.175 N")
    );
    assert_doubts(&contents.doubts, &[]);
}

#[test]
fn cuts_are_read_with_their_notes() {
    let cuts = read_cuts(&file("strokes.cuts")).unwrap();
    assert_eq!(
        cuts.cuts,
        [
            Cut::Stroke {
                from_s: Seconds(1.59),
                to_s: Seconds(1.992)
            },
            Cut::LeaveOut {
                from_s: Seconds(3.1),
                to_s: Seconds(3.2),
                note: "the participant sneezed".into()
            }
        ]
    );
}

/// Files of a newer program are named, not misread.
#[test]
fn files_of_the_future_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let newer = |name: &str| {
        let text = std::fs::read_to_string(file(name)).unwrap();
        let text = text.replacen('{', "{\"format\": 99,", 1);
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let said = read_transfer(&newer("tf.json")).unwrap_err().to_string();
    assert!(
        said.contains("found format 99; read it with a newer version"),
        "{said}"
    );
    // What is no number is no version of ours either.
    let text = std::fs::read_to_string(file("tf.json")).unwrap();
    let other = folder.path().join("other.json");
    std::fs::write(
        &other,
        text.replacen('{', "{\"format\": \"transfer 9\",", 1),
    )
    .unwrap();
    let said = read_transfer(&other).unwrap_err().to_string();
    assert!(said.contains("transfer 9"), "{said}");
    newer("drive.wav.json");
    let wav = folder.path().join("drive.wav");
    std::fs::copy(file("drive.wav"), &wav).unwrap();
    let said = read_recording(&wav, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("found format 99; read it with a newer version"),
        "{said}"
    );
    let index = std::fs::read_to_string(file("panel").join("panel.json")).unwrap();
    let index = index.replace("piezotact panel 1", "piezotact panel 2");
    std::fs::write(folder.path().join("panel.json"), index).unwrap();
    let said = PanelFolder::open(folder.path()).unwrap_err().to_string();
    assert!(
        said.contains("piezotact panel 2") && said.contains("newer version"),
        "{said}"
    );
}
