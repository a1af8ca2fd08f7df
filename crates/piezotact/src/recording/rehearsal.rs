//! Whether a drive was played through the transfer function that it was made with.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Provenance;
use crate::doubt::Doubt;

/// A checksum of the lines of a transfer function: FNV-1a over their step and their real and imaginary parts as 32-bit
/// floating point, so that a file that keeps seven digits keeps it too. In files 16 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Checksum(u64);

impl Checksum {
    /// The checksum of `values`, in this order.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sum = 0xcbf2_9ce4_8422_2325_u64;
        for value in values {
            // Both zeros are one.
            for byte in (value as f32 + 0.0).to_bits().to_le_bytes() {
                sum = (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
        Self(sum)
    }
}

impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl From<Checksum> for String {
    fn from(checksum: Checksum) -> Self {
        checksum.to_string()
    }
}

impl TryFrom<String> for Checksum {
    type Error = NoChecksum;

    fn try_from(text: String) -> Result<Self, NoChecksum> {
        u64::from_str_radix(&text, 16)
            .map(Self)
            .map_err(|_no_number| NoChecksum { found: text })
    }
}

/// A text that is no checksum.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a checksum of 16 hexadecimal digits, found `{found}`")]
pub struct NoChecksum {
    /// The text.
    pub found: String,
}

/// What a person should know of a rehearsal before relying on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "doubt", rename_all = "snake_case")]
pub enum RehearsalDoubt {
    /// A drive was played through the very transfer function that it was rendered with or corrected on.
    PlayedThroughItsOwn {
        /// Its checksum.
        transfer: Checksum,
    },
}

impl fmt::Display for RehearsalDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PlayedThroughItsOwn { transfer } => write!(
                f,
                "the drive was played through the very transfer function that it was rendered with or corrected on (checksum {transfer}): the target comes back whatever device and finger do, and how close it came is no proof; play it through another placement, drawn from a panel's repeats (`panel=FOLDER` behind the measured bench's file), through another person's, or on the device"
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
        .then_some(Doubt::Rehearsal(RehearsalDoubt::PlayedThroughItsOwn {
            transfer,
        }))
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
        // What 32-bit files keep is the same, and what they do not is not.
        assert_eq!(Checksum::of([f64::from(0.1f32)]), Checksum::of([0.1]));
        assert_ne!(Checksum::of([0.1]), Checksum::of([0.100_001]));
    }
}
