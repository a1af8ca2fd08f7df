//! Detects a drive that was played through the same transfer function with which it was made (an inverse crime).

use super::Provenance;
use crate::checksum::Checksum;
use crate::warning::Warning;
use serde::{Deserialize, Serialize};

/// Warnings about rehearsals: drives played through a measured transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RehearsalWarning {
    /// A drive was played through the same transfer function with which it was rendered or corrected.
    #[error(
        "the drive was played through the same transfer function that it was rendered with or corrected on (checksum {transfer}): the target is \
            reproduced whatever the device and the finger do, so a small error is no evidence; play it through another placement (drawn from the \
            repeats of a panel), through the transfer function of another participant, or on the device"
    )]
    PlayedThroughItsOwn { transfer: Checksum },
}

/// The transfer function with which a drive was made and through which it was played, where it is one: `drive` is the drive's
/// provenance, `recording` the recording's. `None` if they differ, or if either is unknown.
///
/// Source: docs/decisions/twin.md: an inverse crime shows nothing of a device.
#[must_use]
pub fn rehearsed_on(drive: &Provenance, recording: &Provenance) -> Option<Checksum> {
    let transfer = recording.answered_with?;
    drive.made_with.contains(&transfer).then_some(transfer)
}

/// The warning about a recording from a bench made of the same transfer function with which its drive was made; `None` where
/// [`rehearsed_on`] is.
///
/// Source: as [`rehearsed_on`].
#[must_use]
pub fn played_through_its_own(drive: &Provenance, recording: &Provenance) -> Option<Warning> {
    let transfer = rehearsed_on(drive, recording)?;
    Some(RehearsalWarning::PlayedThroughItsOwn { transfer }.into())
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
        let warning = played(Some(own)).unwrap();
        assert!(warning.to_string().contains("the same transfer function"));
        let text = serde_json::to_string(&(&warning, &drive)).unwrap();
        let back: (Warning, Provenance) = serde_json::from_str(&text).unwrap();
        assert_eq!(back, (warning, drive));
    }
}
