//! Haptic files: which of the formats that are JSON a file is of, and, with the feature `haptic`, its reading and writing.

#[cfg(feature = "haptic")]
mod files;

use std::path::Path;

#[cfg(feature = "haptic")]
pub use files::{
    parse_ahap, parse_haptic, parse_hjif, read_haptic, write_ahap, write_haptic, write_hjif,
};
#[cfg(feature = "haptic")]
pub(crate) use files::{recording_of_clip, recording_of_hjif};

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
    let mut file = crate::input::open_input(path).ok()?;
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

/// The bytes without the mark that some editors put before UTF-8.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

fn holds(text: &[u8], name: &[u8]) -> bool {
    text.windows(name.len()).any(|window| window == name)
}
