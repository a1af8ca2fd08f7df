//! The text of a file, whatever its encoding.

/// The text of `bytes`: UTF-8 or UTF-16 with or without a mark, or else Latin-1, which lab programs write as often; only names and
/// units can be hit by it.
pub(crate) fn text_of(bytes: &[u8]) -> String {
    if let Some(order) = utf16(bytes) {
        let units = bytes.chunks_exact(2).map(|pair| order([pair[0], pair[1]]));
        let text: String = char::decode_utf16(units)
            .map(|one| one.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        return text.trim_start_matches('\u{feff}').to_owned();
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
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
