//! Checksums of values, by which files name what they were made with.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A checksum of the lines of a transfer function: FNV-1a over their step and their real and imaginary parts as 32-bit
/// floating point, so that a file that keeps seven digits keeps it too. In files 16 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "String", into = "String")]
pub struct Checksum(u64);

impl Checksum {
    /// The checksum of `values`, in this order.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        // Both zeros are one.
        let bytes = |value: f64| (value as f32 + 0.0).to_bits().to_le_bytes();
        Self(fnv(values.into_iter().flat_map(bytes)))
    }

    /// The checksum of the `bytes` of a file: FNV-1a over them, 64 bits.
    #[must_use]
    pub fn of_bytes(bytes: &[u8]) -> Self {
        Self(fnv(bytes.iter().copied()))
    }
}

/// FNV-1a, 64 bits.
fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let begin = 0xcbf2_9ce4_8422_2325_u64;
    let next = |sum: u64, byte: u8| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.into_iter().fold(begin, next)
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
    pub found: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_32_bits_keep_has_one_checksum() {
        assert_eq!(Checksum::of([f64::from(0.1f32)]), Checksum::of([0.1]));
        assert_ne!(Checksum::of([0.1]), Checksum::of([0.100_001]));
    }
}
