//! HBM catman binary files: measured ones, which lie beside the checkout, and the same damaged.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use crate::support::Lcg;
use piezotact::quantity::Unit;
use piezotact_dataset::{ReadOptions, read_recording};

/// Means as `APReader` gives them (INDEX.md); two inputs are open.
#[test]
fn channels_without_an_overload_are_read() {
    let none = ReadOptions::default();
    for (file, mean) in [
        ("4byteJob1_2022_04_12_13_31_47", 0.624_232_470_989_227_3),
        ("8byteJob1_2022_04_12_13_31_23", 0.623_052_591_085_434),
    ] {
        let Some(path) = shared_data::shared(&format!("data/daq/catman/{file}.bin")) else {
            return;
        };
        let read = read_recording(&path, &none).unwrap().recording;
        assert_eq!((read.channels().len(), read.len()), (6, 100));
        assert!((read.rate().hz() - 300.0).abs() < 1e-9);
        let first = &read.channels()[0];
        assert_eq!(
            (first.name.as_str(), first.unit.symbol()),
            ("poti5k", "Ohm")
        );
        let found = first.samples.iter().sum::<f64>() / 100.0;
        assert!((found - mean).abs() < 1e-6, "{found}");
        let place = read
            .channels()
            .iter()
            .find(|c| c.name == "Baumer encoder 2500")
            .unwrap();
        assert_eq!(place.unit, Unit::Metre);
        assert!((place.samples[0] - 0.222_768_005).abs() < 1e-9);
        let began = read.annotations.started_at.as_ref().unwrap().to_string();
        assert!(began.starts_with("2022-04-12T13:31:"), "{began}");
        let [warning] = read.about.warnings.as_slice() else {
            panic!("{:?}", read.about.warnings);
        };
        let said = warning.to_string();
        assert!(
            said.contains("`Poti5K TABLE 5-wire plus minus` (100 of 100 samples are -1000000"),
            "{said}"
        );
        assert!(said.contains("`Thermocouple Type K` (100 of 100"), "{said}");
        // Cut or damaged, it is an error or a recording.
        let bytes = std::fs::read(&path).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("a.bin");
        let mut random = Lcg(3);
        for round in 0..120 {
            let mut bytes = bytes.clone();
            let at = random.below(36_000);
            match round % 2 {
                0 => bytes.truncate(at),
                _ => bytes[at] = random.below(256) as u8,
            }
            std::fs::write(&place, &bytes).unwrap();
            let read = read_recording(&place, &none);
            assert!(round % 2 == 1 || read.is_err(), "{at}");
        }
    }
}
