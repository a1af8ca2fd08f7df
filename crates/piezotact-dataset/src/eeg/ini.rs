//! The text of `BrainVision` headers and marker files: sections of `key=value` lines, in UTF-8 or Latin-1.

/// The text of `bytes`: UTF-8, or Latin-1 where they are none.
pub(super) fn text_of(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// The `key=value` lines of the section `[name]`, in order; comments and other lines are left out.
pub(super) fn section<'t>(text: &'t str, name: &str) -> Vec<(&'t str, &'t str)> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(title) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            // Sections of free text follow, with brackets of their own.
            if title.eq_ignore_ascii_case("Comment") {
                break;
            }
            inside = title.eq_ignore_ascii_case(name);
        } else if inside
            && !line.starts_with(';')
            && let Some((key, value)) = line.split_once('=')
        {
            found.push((key.trim(), value.trim()));
        }
    }
    found
}

/// The value of `key` in a section, in whatever case; `None` where it is absent or empty.
pub(super) fn value<'t>(section: &[(&'t str, &'t str)], key: &str) -> Option<&'t str> {
    let found = section.iter().find(|(k, _)| k.eq_ignore_ascii_case(key));
    found.map(|(_, v)| *v).filter(|v| !v.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_and_encodings() {
        let text = text_of(b"Title\r\n[Common Infos]\r\n; no=1\r\nA=1\r\nb = 2,\xB5V\r\n[Other]\r\nA=3\r\n[Comment]\r\n[Other]\nA=4");
        assert_eq!(section(&text, "common infos"), [("A", "1"), ("b", "2,µV")]);
        assert_eq!(section(&text, "Other"), [("A", "3")]);
        assert_eq!(value(&section(&text, "Other"), "a"), Some("3"));
        assert_eq!(text_of("\u{feff}µ".as_bytes()), "µ");
    }
}
