//! Files of a newer program are named, not misread.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact_dataset::{ReadOptions, read_recording, read_transfer};

#[test]
fn newer_formats_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // What is no number is no version of ours either.
    for (format, found) in [("99", "found format 99"), ("\"transfer 9\"", "transfer 9")] {
        let text = format!("{{\"format\": {format}, \"frequency_hz\": [0, 1]}}");
        std::fs::write(path("tf.json"), text).unwrap();
        let said = read_transfer(&path("tf.json")).unwrap_err().to_string();
        assert!(
            said.contains(found) && said.contains("read it with a newer version"),
            "{said}"
        );
    }
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 1000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut wav = hound::WavWriter::create(path("drive.wav"), spec).unwrap();
    for sample in [0.0_f32, 0.5, -0.5] {
        wav.write_sample(sample).unwrap();
    }
    wav.finalize().unwrap();
    std::fs::write(path("drive.wav.json"), "{\"format\": 99}").unwrap();
    let read = read_recording(&path("drive.wav"), &ReadOptions::default());
    let said = read.unwrap_err().to_string();
    assert!(
        said.contains("found format 99; read it with a newer version"),
        "{said}"
    );
}
