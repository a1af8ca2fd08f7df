//! Texts as they are shown: what files hold reaches the terminal without control characters, and in messages shortened.

use std::borrow::Cow;
use std::fmt::Write as _;

/// A word of a message is shown up to this many characters; paths longer, as a line.
const LONGEST_WORD: usize = 200;
/// What is shown of a longer one.
const OF_A_WORD: usize = 60;
/// A number in a message has at most this many digits in a row.
const LONGEST_NUMBER: usize = 40;
/// What is shown of a longer one.
const OF_A_NUMBER: usize = 12;
/// A line of a message is shown up to this many characters.
const LONGEST_LINE: usize = 6000;
/// What is shown of a longer one.
const OF_A_LINE: usize = 600;

/// `text` with control characters, except line ends and tabs, as `\\u001b`: in JSON they mean the same, and a terminal does
/// nothing on them. Signs that turn the direction of writing count as such.
pub(crate) fn harmless(text: &str) -> Cow<'_, str> {
    let acts = |sign: char| {
        (sign.is_control() && !['\n', '\t'].contains(&sign))
            || ('\u{202a}'..='\u{202e}').contains(&sign)
            || ('\u{2066}'..='\u{2069}').contains(&sign)
    };
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for sign in text.chars() {
        if acts(sign) {
            let _never_fails = write!(shown, "\\u{:04x}", u32::from(sign));
        } else {
            shown.push(sign);
        }
    }
    Cow::Owned(shown)
}

/// A message without what nobody reads: words, numbers and lines beyond any length are cut, with the number of their characters.
pub(crate) fn shortened(message: &str) -> Cow<'_, str> {
    let whole = |line: &str| line.len() <= LONGEST_LINE && line.split_whitespace().all(is_short);
    if message.split('\n').all(whole) {
        return Cow::Borrowed(message);
    }
    let lines = message.split('\n').map(|line| {
        let words: String = line
            .split_inclusive(char::is_whitespace)
            .map(short_word)
            .collect();
        cut(&words, LONGEST_LINE, OF_A_LINE)
    });
    Cow::Owned(lines.collect::<Vec<_>>().join("\n"))
}

fn is_path(word: &str) -> bool {
    word.contains(['/', '\\'])
}

fn is_short(word: &str) -> bool {
    word.len() <= LONGEST_NUMBER
        || ((word.len() <= LONGEST_WORD || is_path(word)) && !has_long_number(word))
}

fn has_long_number(word: &str) -> bool {
    let mut digits = word.split(|sign: char| !sign.is_ascii_digit());
    !is_path(word) && digits.any(|run| run.len() > LONGEST_NUMBER)
}

fn short_word(word: &str) -> String {
    if is_path(word) {
        return word.to_owned();
    }
    let mut shown = String::new();
    let mut rest = word;
    while let Some(at) = rest.find(|sign: char| sign.is_ascii_digit()) {
        let digits = rest[at..]
            .find(|sign: char| !sign.is_ascii_digit())
            .unwrap_or(rest.len() - at);
        shown += &rest[..at];
        shown += &match digits > LONGEST_NUMBER {
            true => format!("{}… ({digits} digits)", &rest[at..at + OF_A_NUMBER]),
            false => rest[at..at + digits].to_owned(),
        };
        rest = &rest[at + digits..];
    }
    shown += rest;
    cut(&shown, LONGEST_WORD, OF_A_WORD)
}

/// The first `kept` characters of a text of more than `most`, with the number of the others.
fn cut(text: &str, most: usize, kept: usize) -> String {
    if text.len() <= most || text.chars().count() <= most {
        return text.to_owned();
    }
    let first: String = text.chars().take(kept).collect();
    let end = &text[text.trim_end().len()..];
    format!(
        "{first}… ({} characters more){end}",
        text.chars().count() - kept
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_does_nothing_on_what_a_file_holds() {
        assert_eq!(harmless("µ\tα\n−1"), "µ\tα\n−1");
        assert_eq!(
            harmless("a\u{1b}[31mred\r\u{7}\u{9b}\u{202e}"),
            "a\\u001b[31mred\\u000d\\u0007\\u009b\\u202e"
        );
        // JSON holds the same text
        let json = serde_json::to_string("x\u{9b}y").unwrap();
        assert_eq!(
            serde_json::from_str::<String>(&harmless(&json)).unwrap(),
            "x\u{9b}y"
        );
    }

    #[test]
    fn messages_have_a_length_that_people_read() {
        let usual = "a.csv: expected a number, found `12,5` in row 3; repair or cut that row";
        assert_eq!(shortened(usual), usual);
        let path = format!("/{}/a.csv: expected 12345678901234567890", "x".repeat(3000));
        assert_eq!(shortened(&path), path);
        let cell = format!("found `{}` in row 3", "x".repeat(50_000_000));
        let shown = shortened(&cell).into_owned();
        assert!(
            shown.len() < 200 && shown.ends_with("characters more) in row 3"),
            "{shown}"
        );
        let words = format!("found `{}` in row 3", "x ".repeat(50_000));
        assert!(shortened(&words).len() < 1000);
        let number = format!("found {}.5 Hz", 1e300);
        assert_eq!(shortened(&number), "found 100000000000… (301 digits).5 Hz");
    }
}
