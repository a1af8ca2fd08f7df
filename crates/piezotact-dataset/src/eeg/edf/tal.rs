//! Annotation lists of EDF+: `+onset`, 0x15, `duration`, 0x14, `text`, 0x14, …, 0x00.

/// Ends an onset, a duration or a text.
pub(super) const END: u8 = 0x14;
/// Stands before a duration.
pub(super) const DURATION: u8 = 0x15;

/// The time at which a record begins, from the start time of the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Onset {
    pub(super) record: usize,
    pub(super) onset_s: f64,
}

/// An annotation; its onset is counted from the start time of the header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Annotation {
    pub(super) onset_s: f64,
    pub(super) duration_s: f64,
    pub(super) text: String,
}

/// What one annotation channel holds in one record.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Found {
    /// The onset of the first list.
    pub(super) first_onset: Option<f64>,
    pub(super) annotations: Vec<Annotation>,
    /// What was found where an onset or a duration is expected, of each list that cannot be read.
    pub(super) unreadable: Vec<String>,
}

/// Reads the annotation lists in `bytes`.
pub(super) fn parse(bytes: &[u8]) -> Found {
    let mut found = Found::default();
    let lists = bytes.split(|byte| *byte == 0);
    // Some programs fill up with spaces.
    let lists = lists.filter(|list| list.iter().any(|byte| *byte != b' '));
    for (number, list) in lists.enumerate() {
        let mut fields = list.split(|byte| *byte == END);
        let time = fields.next().unwrap_or_default();
        let (onset, duration) = match time.iter().position(|byte| *byte == DURATION) {
            Some(at) => (&time[..at], Some(&time[at + 1..])),
            None => (time, None),
        };
        let signed = matches!(onset.first(), Some(b'+' | b'-'));
        let Some(onset_s) = number_in(onset).filter(|_| signed) else {
            let what = format!("`{}` as an onset", short(onset));
            found.unreadable.push(what);
            continue;
        };
        if number == 0 {
            found.first_onset = Some(onset_s);
        }
        let duration_s = match duration {
            None | Some([]) => Some(0.0),
            Some(text) => number_in(text).filter(|s| *s >= 0.0),
        };
        let Some(duration_s) = duration_s else {
            let text = duration.unwrap_or_default();
            found
                .unreadable
                .push(format!("`{}` as a duration", short(text)));
            continue;
        };
        let texts = fields.filter(|text| !text.is_empty());
        found.annotations.extend(texts.map(|text| Annotation {
            onset_s,
            duration_s,
            text: super::super::ini::text_of(text),
        }));
    }
    found
}

fn number_in(text: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(text).ok()?.trim();
    let plain = text
        .bytes()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E'));
    let value: f64 = text.parse().ok().filter(|_| plain)?;
    (value.abs() < 1e12).then_some(value)
}

fn short(bytes: &[u8]) -> String {
    let bytes = &bytes[..bytes.len().min(40)];
    String::from_utf8_lossy(bytes).escape_debug().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_hold_one_onset_and_several_texts() {
        let found = parse(b"+10.25\x14\x14\0+11\x150.5\x14a\x14\xC2\xB5\x14\0-1.5\x14b\x14\0\0\0");
        assert_eq!(found.first_onset, Some(10.25));
        let annotation = |onset_s, duration_s, text: &str| Annotation {
            onset_s,
            duration_s,
            text: text.into(),
        };
        let expected = [
            annotation(11.0, 0.5, "a"),
            annotation(11.0, 0.5, "µ"),
            annotation(-1.5, 0.0, "b"),
        ];
        assert_eq!(found.annotations, expected);
        assert_eq!(parse(b"\0\0"), Found::default());
        for (bytes, part) in [
            (&b"10\x14a\x14\0"[..], "`10` as an onset"),
            (b"+x\x14a\x14\0", "`+x` as an onset"),
            (b"+6,5\x14a\x14\0", "`+6,5` as an onset"),
            (b"+1\x15-2\x14a\x14\0", "`-2` as a duration"),
        ] {
            let found = parse(&[bytes, b"+7\x14b\x14\0"].concat());
            assert_eq!(found.unreadable, [part]);
            // The others are read; the onset of a record stands in its first list alone.
            assert_eq!(found.annotations, [annotation(7.0, 0.0, "b")]);
            assert_eq!(found.first_onset, part.ends_with("duration").then_some(1.0));
        }
    }
}
