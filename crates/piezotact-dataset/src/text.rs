//! The text of a file, whatever its encoding.

use std::borrow::Cow;

use piezotact::Warning;
use piezotact::recording::RecordingWarning;

/// The text of `bytes`: UTF-8 or UTF-16 with or without a mark, or else Latin-1, which lab programs write as often; only names and
/// units can be hit by it.
pub(crate) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(order) = utf16(bytes) {
        let units = bytes.chunks_exact(2).map(|pair| order([pair[0], pair[1]]));
        let text: String = char::decode_utf16(units)
            .map(|one| one.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        return Cow::Owned(text.trim_start_matches('\u{feff}').to_owned());
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text.trim_start_matches('\u{feff}')),
        Err(_) => Cow::Owned(bytes.iter().map(|b| char::from(*b)).collect()),
    }
}

/// Whether `bytes` are text: no byte of it is zero, unless two make a character.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    !bytes.contains(&0) || utf16(bytes).is_some()
}

/// The order of the bytes of a UTF-16 text.
fn utf16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes {
        [0xFF, 0xFE, rest @ ..] if !rest.starts_with(&[0, 0]) => return Some(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => return Some(u16::from_be_bytes),
        _ => {}
    }
    // Without a mark, every second byte of its first letters and digits is zero.
    let head = &bytes[..bytes.len().min(64)];
    let zeros = |at: usize| head.len() >= 8 && head.iter().skip(at).step_by(2).all(|b| *b == 0);
    let letters = |at: usize| {
        head.iter()
            .skip(at)
            .step_by(2)
            .all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace())
    };
    match () {
        () if zeros(1) && letters(0) => Some(u16::from_le_bytes),
        () if zeros(0) && letters(1) => Some(u16::from_be_bytes),
        () => None,
    }
}

/// In a table of fewer rows a last line without an end was typed, not cut.
pub(crate) const FEW_ROWS: usize = 10;

/// How many letters follow the decimal sign of a number.
pub(crate) fn decimals_of(cell: &str) -> Option<usize> {
    Some(cell.len() - cell.rfind(['.', ','])?)
}

/// The text without a last row that was cut within a number, and the warning about it; `from` is where rows begin, after the rest of a line
/// and a line of names. Where every number has as many decimals as the last one, that one is whole.
pub(crate) fn without_cut_row(text: &str, from: usize) -> (&str, Option<Warning>) {
    let Some(at) = text.rfind('\n').filter(|at| at + 1 < text.len()) else {
        return (text, None);
    };
    let rows = text.get(from..at).unwrap_or_default().lines().skip(2);
    let shape = |row: &str| {
        let cells = row.trim_end().split(['\t', ';']);
        let (mut count, mut last) = (0, "");
        for cell in cells {
            (count, last) = (count + 1, cell.trim());
        }
        Some((count, decimals_of(last)?))
    };
    let own = shape(&text[at + 1..]);
    let (mut count, mut is_whole) = (0, own.is_some());
    for row in rows.filter(|row| !row.trim().is_empty()) {
        count += 1;
        is_whole &= shape(row) == own;
    }
    if is_whole || count < FEW_ROWS {
        return (text, None);
    }
    let what = format!(
        "the file is truncated: its row {} has no end of line, its last number may be cut, and it was left out",
        text[..=at].lines().count() + 1
    );
    let warning = Warning::from(RecordingWarning::Guessed { what });
    (&text[..=at], Some(warning))
}
