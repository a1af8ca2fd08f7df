//! Texts that people type and others read: in lists, tables and files that spreadsheet programs open.

use std::borrow::Cow;
use std::collections::BTreeSet;

/// The largest number of characters of a name or a short text.
const MOST_OF_SHORT: usize = 200;
/// The largest number of characters of a long text.
const MOST_OF_LONG: usize = 10_000;
/// With these a spreadsheet program takes a cell for a formula, the wide ones where they are typed in Japanese or Chinese.
const FORMULA: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];

/// The fewest characters of a password or passphrase.
const SHORTEST_SECRET: usize = 12;
/// The fewest different characters among them.
const FEWEST_DIFFERENT: usize = 5;

/// Checks a password or passphrase that a person chooses: at least 12 characters, of which at least 5 differ.
///
/// # Errors
/// [`TextError`].
///
/// Source: docs/decisions/store.md.
pub fn check_secret(text: &str) -> Result<(), TextError> {
    let found = text.chars().count();
    if found < SHORTEST_SECRET {
        return Err(TextError::Short { found });
    }
    let different: BTreeSet<char> = text.chars().collect();
    match different.len() {
        found if found < FEWEST_DIFFERENT => Err(TextError::Even { found }),
        _ => Ok(()),
    }
}

/// The part of `text` that is in the language with the tag `tag`, as in BCP 47. A part begins with a line that holds its tag in brackets,
/// `[fr]`. Where no part is in that language it is the first one; a text without such lines is given as a whole.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn part_in<'a>(text: &'a str, tag: Option<&str>) -> &'a str {
    let base = |tag: &str| {
        tag.split(['-', '_'])
            .next()
            .unwrap_or_default()
            .to_lowercase()
    };
    // Where each part begins and ends, with its tag; what is before the first has none.
    let mut parts: Vec<(Option<&str>, usize, usize)> = vec![(None, 0, text.len())];
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let begins = line.trim().strip_prefix('[');
        let is_tag =
            |tag: &&str| (2..=12).contains(&tag.len()) && !tag.contains(char::is_whitespace);
        if let Some(tag) = begins
            .and_then(|rest| rest.strip_suffix(']'))
            .filter(is_tag)
        {
            if let Some(last) = parts.last_mut() {
                last.2 = at;
            }
            parts.push((Some(tag), at + line.len(), text.len()));
        }
        at += line.len();
    }
    let of = |part: &(Option<&str>, usize, usize)| text[part.1..part.2].trim();
    let wanted = tag.map(base);
    let found = parts
        .iter()
        .find(|(one, ..)| wanted.is_some() && one.map(base) == wanted);
    let first = parts.iter().find(|part| !of(part).is_empty());
    found.or(first).map_or(text, of)
}

/// Why a text, a password or a passphrase is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    /// A character that is not shown, and changes how or where others are.
    #[error("character {} (U+{:04X}) is a control character or reverses the reading direction: remove it", .at + 1, u32::from(*.found)
    )]
    Hidden {
        found: char,
        /// How many characters stand before it.
        at: usize,
    },
    /// It is too long.
    #[error("the text has {found} characters, and {most} are the most: shorten it")]
    Long {
        /// How many there may be.
        most: usize,
        /// How many there are.
        found: usize,
    },
    /// A spreadsheet program would execute it.
    #[error("the text begins with `{found}`, which spreadsheets execute: begin with a word")]
    Formula { found: char },
    /// Too few characters.
    #[error(
        "{found} characters are too few, {SHORTEST_SECRET} are needed: four words that do not belong together are good"
    )]
    Short { found: usize },
    /// The same characters again and again.
    #[error(
        "only {found} different characters, {FEWEST_DIFFERENT} are needed: four words that do not belong together are good"
    )]
    Even {
        /// How many of its characters differ.
        found: usize,
    },
}

/// Checks one line of text, such as how a person is reached: at most 200 characters, none of which is a control character, a
/// separator of lines or a mark that reverses the reading direction (U+202A to U+202E, U+2066 to U+2069).
///
/// # Errors
/// [`TextError::Hidden`], [`TextError::Long`].
///
/// Source: docs/decisions/documents.md; Unicode Standard Annex 9, section 2, for the marks.
pub fn check_line(text: &str) -> Result<(), TextError> {
    check(text, MOST_OF_SHORT, hides)
}

/// Checks a name or a short text that can stand in a table: as [`check_line`], and no first character that makes a formula of a
/// cell (`=`, `+`, `-`, `@`, and their wide forms).
///
/// # Errors
/// [`TextError`].
///
/// Source: docs/decisions/documents.md.
pub fn check_short(text: &str) -> Result<(), TextError> {
    check_line(text)?;
    match text.chars().next().filter(|first| FORMULA.contains(first)) {
        None => Ok(()),
        Some(found) => Err(TextError::Formula { found }),
    }
}

/// Checks a long text, such as an instruction: as [`check_line`] with at most 10 000 characters, tabulators and lines.
///
/// # Errors
/// [`TextError::Hidden`], [`TextError::Long`].
///
/// Source: docs/decisions/documents.md.
pub fn check_long(text: &str) -> Result<(), TextError> {
    // A carriage return alone lets a line overwrite the one before it.
    let lines = text.replace("\r\n", "\n");
    check(&lines, MOST_OF_LONG, |sign| {
        hides(sign) && !matches!(sign, '\n' | '\t')
    })
}

/// `text` as it can be shown on one line: each character that [`check_line`] refuses is written as `\u{1b}`.
///
/// Source: docs/decisions/documents.md.
#[must_use]
pub fn shown(text: &str) -> Cow<'_, str> {
    if !text.contains(hides) {
        return Cow::Borrowed(text);
    }
    let escaped = text.chars().map(|sign| match hides(sign) {
        true => format!("\\u{{{:x}}}", u32::from(sign)),
        false => sign.to_string(),
    });
    Cow::Owned(escaped.collect())
}

/// `text` as a cell of an exported table: with `'` before it where a spreadsheet program would execute it, or where it begins with
/// `'` itself, so that one `'` is always taken away again.
///
/// Source: docs/decisions/documents.md.
#[must_use]
pub fn cell(text: &str) -> Cow<'_, str> {
    let begins = |sign: char| FORMULA.contains(&sign) || sign.is_control() || sign == '\'';
    match text.trim_start_matches(' ').starts_with(begins) {
        false => Cow::Borrowed(text),
        true => Cow::Owned(format!("'{text}")),
    }
}

/// Whether a character is not shown, and changes how or where others are.
fn hides(sign: char) -> bool {
    sign.is_control()
        || matches!(
            sign,
            '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

fn check(text: &str, most: usize, refused: impl Fn(char) -> bool) -> Result<(), TextError> {
    let mut characters = text.chars().enumerate();
    if let Some((at, found)) = characters.find(|(_, sign)| refused(*sign)) {
        return Err(TextError::Hidden { found, at });
    }
    match text.chars().count() {
        found if found > most => Err(TextError::Long { most, found }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_of_a_text_is_that_of_the_language_or_the_first() {
        let whole = "I take part.\nFor [fr] ask.\n";
        assert_eq!(part_in(whole, Some("fr")), whole.trim());
        let parts = "[en]\nI take part.\n\n[fr]\nJe participe.\nOui.\n[it]\n";
        for (tag, found) in [
            (Some("fr-CH"), "Je participe.\nOui."),
            (Some("EN"), "I take part."),
            (Some("ja"), "I take part."),
            (None, "I take part."),
        ] {
            assert_eq!(part_in(parts, tag), found, "{tag:?}");
        }
        assert_eq!(part_in("", Some("fr")), "");
    }

    #[test]
    fn a_secret_has_12_characters_of_which_5_differ() {
        assert_eq!(check_secret("four words of wood"), Ok(()));
        assert_eq!(check_secret("éàü éàü éàüx"), Ok(()));
        for (text, refused) in [
            ("a", TextError::Short { found: 1 }),
            ("éàü éàü éàü", TextError::Short { found: 11 }),
            ("            ", TextError::Even { found: 1 }),
            ("abcdabcdabcdabcd", TextError::Even { found: 4 }),
        ] {
            assert_eq!(check_secret(text), Err(refused));
        }
    }

    #[test]
    fn what_forges_a_line_is_refused_and_written_out_when_shown() {
        for (sign, written) in [
            ('\n', "\\u{a}"),
            ('\r', "\\u{d}"),
            ('\u{1b}', "\\u{1b}"),
            ('\u{7f}', "\\u{7f}"),
            ('\u{85}', "\\u{85}"),
            ('\u{2028}', "\\u{2028}"),
            ('\u{202e}', "\\u{202e}"),
            ('\u{2066}', "\\u{2066}"),
        ] {
            let text = format!("Ab{sign}c");
            let refused = Err(TextError::Hidden { found: sign, at: 2 });
            assert_eq!(check_line(&text), refused);
            assert_eq!(check_short(&text), refused);
            assert_eq!(check_long(&text).is_ok(), sign == '\n', "{sign:?}");
            assert_eq!(shown(&text), format!("Ab{written}c"));
        }
        for text in ["", "Zoë Ångström", "山田 花子", "مريم", "a\\b"] {
            assert_eq!(check_line(text), Ok(()));
            assert_eq!(shown(text), text);
        }
        let said = check_line("a\u{1b}[2K").unwrap_err().to_string();
        assert!(
            said.contains("character 2 (U+001B)") && said.contains("remove it"),
            "{said}"
        );
    }

    #[test]
    fn a_formula_is_no_name_and_a_telephone_number_is_a_line() {
        for text in ["=1+1", "+33 1", "-x", "@SUM(A1)", "＝1"] {
            assert!(matches!(check_short(text), Err(TextError::Formula { .. })));
            assert_eq!(check_line(text), Ok(()));
            assert_eq!(check_long(text), Ok(()));
        }
        assert_eq!(check_short("a=1"), Ok(()));
    }

    #[test]
    fn texts_are_counted_in_characters() {
        assert_eq!(check_short(&"é".repeat(200)), Ok(()));
        let (most, found) = (200, 201);
        assert_eq!(
            check_short(&"é".repeat(201)),
            Err(TextError::Long { most, found })
        );
        assert_eq!(check_long(&"a\r\nb".repeat(2500)), Ok(()));
        assert!(check_long(&"é".repeat(10_001)).is_err());
        assert!(check_long("a\rb").is_err());
    }

    #[test]
    fn a_cell_that_would_be_executed_is_a_text_and_the_others_stay() {
        for text in ["=1+1", "+1", "-1", "@x", "\t=1", " =1", "'quoted'", "＝1"] {
            assert_eq!(cell(text), format!("'{text}"));
        }
        for text in ["", "a=1", "wrong button", "1 - 2"] {
            assert_eq!(cell(text), text);
        }
    }
}
