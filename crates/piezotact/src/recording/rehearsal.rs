//! Whether a drive was played through the transfer function that it was made with.

use std::fmt;

use super::Provenance;
use crate::checksum::Checksum;
use crate::doubt::{Advice, Doubt, DoubtKind, doubts};

doubts! {
    /// What a person should know of a rehearsal before relying on it.
    pub enum RehearsalDoubt {
        /// A drive was played through the very transfer function that it was rendered with or corrected on.
        PlayedThroughItsOwn("played_through_its_own") {
            /// Its checksum.
            transfer: Checksum,
        },
    }
}

impl DoubtKind for RehearsalDoubt {
    fn of(doubt: &Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        vec![Advice::PlayThroughOtherPlacement]
    }
}

impl fmt::Display for RehearsalDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PlayedThroughItsOwn { transfer } => write!(
                f,
                "the drive was played through the very transfer function that it was rendered with or corrected on (checksum {transfer}): the target comes back whatever device and finger do, and how close it came is no proof"
            ),
        }
    }
}

/// The doubt about a recording that comes from a bench which answered with the very transfer function that its drive was
/// made with: `drive` is the drive's provenance, `recording` the recording's. `None` where they differ, and where either
/// does not say.
///
/// Source: decisions 0027 and 0030 of this project: an inverse crime shows nothing of a device.
#[must_use]
pub fn played_through_its_own(drive: &Provenance, recording: &Provenance) -> Option<Doubt> {
    let transfer = recording.answered_with?;
    drive
        .made_with
        .contains(&transfer)
        .then(|| RehearsalDoubt::PlayedThroughItsOwn { transfer }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_knows_what_it_was_made_with() {
        let (own, other) = (Checksum::of([1.0, 0.1]), Checksum::of([1.0, 0.2]));
        let drive = Provenance {
            made_with: vec![own],
            ..Provenance::default()
        };
        let played = |answered_with| {
            let recording = Provenance {
                answered_with,
                ..Provenance::default()
            };
            played_through_its_own(&drive, &recording)
        };
        assert_eq!(played(Some(other)), None);
        assert_eq!(played(None), None);
        let doubt = played(Some(own)).unwrap();
        assert!(doubt.to_string().contains("the very transfer function"));
        let text = serde_json::to_string(&(&doubt, &drive)).unwrap();
        let back: (Doubt, Provenance) = serde_json::from_str(&text).unwrap();
        assert_eq!(back, (doubt, drive));
        // Of a file of before nothing is known.
        let before: Provenance = serde_json::from_str(r#"{"source": "twin"}"#).unwrap();
        assert_eq!((before.made_with, before.answered_with), (vec![], None));
    }
}
