//! Channels of codes.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::integrity::warnings_of;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};

/// Codes rest for long: as a signal, such a channel would be dead.
#[test]
fn channels_of_codes_are_no_signals() {
    let warned = |name: &str| {
        let channel = Channel {
            name: name.into(),
            unit: Unit::Volt,
            samples: vec![0.0; 5_000],
        };
        let about = (Condition::default(), Provenance::default());
        let recording = Recording::new(
            vec![channel],
            SampleRate::new(5000.0).unwrap(),
            about.0,
            about.1,
        )
        .unwrap();
        !warnings_of(&recording, 1.0).is_empty()
    };
    assert!(warned("nail") && warned("stimulus"));
    for name in ["Status", "TRIG", "trigger in", "STI 014", "STIM"] {
        assert!(!warned(name), "{name}");
    }
}
