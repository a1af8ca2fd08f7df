//! Files for consumer haptic devices: `.haptic` clips, Apple's AHAP, and the interchange format of MPEG, HJIF.
//!
//! None of them holds a waveform in m/s², as a texture is here. Whatever a format cannot represent is returned as
//! [`RecordingDoubt::FormatLoses`], so that nobody takes such a file for a complete copy.

mod ahap;
mod clip;
mod hjif;
mod hjif_check;
mod hjif_write;
mod target;

use piezotact::recording::RecordingDoubt;
use std::path::Path;

use piezotact::Doubt;

use crate::error::ReadError;

pub use ahap::{
    Ahap, AhapControlPoint, AhapCurve, AhapDynamic, AhapEvent, AhapEventType, AhapMetadata,
    AhapParameter, AhapParameterId, AhapPattern, ahap_of, parse_ahap, write_ahap,
};
pub use clip::{HapticClip, HapticMetadata, HapticVersion, clip_of, parse_haptic, write_haptic};
pub use hjif::{
    Hjif, HjifAvatar, HjifBand, HjifBandType, HjifBaseSignal, HjifChannel, HjifCurveType,
    HjifEffect, HjifEffectType, HjifKeyframe, HjifPerception, HjifReferenceDevice, HjifSync,
    parse_hjif,
};
pub use hjif_write::{HjifTexture, date_of, piezo_device, write_hjif};

pub(crate) use target::{recording_of_clip, recording_of_hjif};

/// The result of an export, and the information that the format could not represent.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported<T> {
    /// The content of the file.
    pub content: T,
    /// The doubts about information that was lost.
    pub losses: Vec<Doubt>,
}

/// The haptic formats that are JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HapticKind {
    /// A `.haptic` clip.
    Clip,
    /// Apple's AHAP.
    Ahap,
    /// MPEG's HJIF.
    Hjif,
}

/// Which haptic format `bytes` are, by the names that only it has; `None` for anything else. The ending says nothing:
/// HJIF is found under `.hmpg`, which is the name of MPEG's binary format.
#[must_use]
pub fn haptic_kind(bytes: &[u8]) -> Option<HapticKind> {
    let text = without_mark(bytes);
    let start = text.iter().position(|byte| !byte.is_ascii_whitespace())?;
    if text[start] != b'{' || holds(text, b"\"frequency_hz\"") {
        return None;
    }
    [
        (b"\"perceptions\"".as_slice(), HapticKind::Hjif),
        (b"\"signals\"", HapticKind::Clip),
        (b"\"voices\"", HapticKind::Clip),
        (b"\"Pattern\"", HapticKind::Ahap),
    ]
    .into_iter()
    .find_map(|(name, kind)| holds(text, name).then_some(kind))
}

/// JSON, or what stands for it, that is called a haptic file and is none of the three.
pub(crate) fn is_called_haptic(path: &Path, bytes: &[u8]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let called = ending.is_some_and(|ending| {
        ["haptic", "hjif", "ahap"]
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
    });
    let text = without_mark(bytes).trim_ascii();
    called && (text.first().is_some_and(|byte| b"{[\"".contains(byte)) || text == b"null")
}

/// Whether the file at `path` is a haptic file, and which; `None` for what cannot be read.
#[must_use]
pub fn haptic_kind_of_file(path: &Path) -> Option<HapticKind> {
    use std::io::Read as _;
    let mut file = crate::reads::open(path).ok()?;
    let mut head = Vec::new();
    // A long recording is not read for this.
    (&mut file).take(64).read_to_end(&mut head).ok()?;
    let first = without_mark(&head)
        .iter()
        .find(|byte| !byte.is_ascii_whitespace())?;
    if *first != b'{' {
        return None;
    }
    file.read_to_end(&mut head).ok()?;
    haptic_kind(&head)
}

/// Reads a `.haptic` clip.
///
/// # Errors
/// [`ReadError::Io`] when the file cannot be read; those of [`parse_haptic`].
pub fn read_haptic(path: &Path) -> Result<HapticClip, ReadError> {
    let bytes = crate::reads::read(path).map_err(|error| ReadError::io(path, &error))?;
    parse_haptic(path, &bytes)
}

/// The loss of `what` by `format`.
fn loses(format: &str, what: impl Into<String>) -> Doubt {
    Doubt::from(RecordingDoubt::FormatLoses {
        format: format.into(),
        what: what.into(),
    })
}

/// The bytes without the mark that some editors put before UTF-8.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

fn holds(text: &[u8], name: &[u8]) -> bool {
    text.windows(name.len()).any(|window| window == name)
}

/// Reads JSON as `T`; what is missing or of another type is named with its place.
fn json<T: serde::de::DeserializeOwned>(
    path: &Path,
    bytes: &[u8],
    expected: &str,
    todo: &str,
) -> Result<T, ReadError> {
    serde_json::from_slice(without_mark(bytes))
        .map_err(|error| ReadError::content(path, expected, error.to_string(), todo))
}
