//! Where the header of a table stands, and what separates its cells.

use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::StartTime;

use crate::date_time::{Stamp, is_date};
use crate::time_column::seconds_of;

/// The header is looked for in this many lines.
const SEARCHED: usize = 200;
/// What a line above the header says of the rate begins so, in small letters.
const RATES: [&str; 8] = [
    "sample rate",
    "samplerate",
    "sampling rate",
    "sample frequency",
    "sampling frequency",
    "scan rate",
    "abtastrate",
    "acquisition rate",
];
/// What a line above the header says of the time from sample to sample.
const STEPS: [&str; 8] = [
    "sample interval",
    "sampling interval",
    "sample period",
    "sampling period",
    "sampling time",
    "time increment",
    "time step",
    "abtastintervall",
];
/// What a line above the header says of the start.
const STARTS: [&str; 5] = ["start", "date", "recorded", "datum", "created"];

/// A table from its header on.
pub(super) struct Layout<'t> {
    pub(super) text: &'t str,
    pub(super) delimiter: u8,
    /// The lines above the header.
    pub(super) above: Vec<&'t str>,
    /// How many lines of the file stand above the header.
    pub(super) lines_above: usize,
}

/// The layout of a table. Its header is the first line, unless rows of numbers begin further down: then it stands above these, with a
/// row of units between them or without. A first line `sep=;` states the separator, as Excel writes it.
pub(super) fn layout(text: &str) -> Layout<'_> {
    let (stated, table, mut lines_above) = match stated_delimiter(text) {
        Some((delimiter, rest)) => (Some(delimiter), rest, 1),
        None => (None, text, 0),
    };
    let lines: Vec<(usize, usize, &str)> = lines_of(table)
        .filter(|(_, _, line)| !line.trim().is_empty())
        .take(SEARCHED)
        .collect();
    let header = header_line(&lines, stated).filter(|at| *at > 0);
    let (above, rest) = match header.and_then(|at| lines.get(at)) {
        Some((number, from, _)) => {
            lines_above += number;
            (&lines[..header.unwrap_or(0)], &table[*from..])
        }
        None => (&lines[..0], table),
    };
    let first = rest.lines().find(|line| !line.trim().is_empty());
    Layout {
        text: rest,
        delimiter: stated.unwrap_or_else(|| delimiter_of(first.unwrap_or(""))),
        above: above.iter().map(|(_, _, line)| *line).collect(),
        lines_above,
    }
}

/// The lines of a text, each with its number from 0 and where it begins.
fn lines_of(text: &str) -> impl Iterator<Item = (usize, usize, &str)> {
    let mut from = 0;
    text.split_inclusive('\n')
        .enumerate()
        .map(move |(number, line)| {
            let at = from;
            from += line.len();
            (number, at, line.trim_end_matches(['\n', '\r']))
        })
}

/// The separator that the first line states, and the text below.
fn stated_delimiter(text: &str) -> Option<(u8, &str)> {
    let (first, rest) = text.split_once('\n')?;
    let first = first.trim_end_matches('\r').trim_matches('"');
    let sign = first
        .strip_prefix("sep=")
        .or_else(|| first.strip_prefix("SEP="))?;
    match sign.as_bytes() {
        [sign @ (b',' | b';' | b'\t')] => Some((*sign, rest)),
        _ => None,
    }
}

/// Which of the lines is the header, where titles stand above it; none where the first one is.
fn header_line(lines: &[(usize, usize, &str)], stated: Option<u8>) -> Option<usize> {
    let delimiter = |line: &str| stated.unwrap_or_else(|| of_numbers(line));
    let is_row = |line: &str| is_row(line, delimiter(line));
    let first = lines.iter().position(|(_, _, line)| is_row(line))?;
    let (_, _, numbers) = lines[first];
    let sign = delimiter(numbers);
    let width = |at: usize| cells(lines[at].2, sign).count();
    let columns = cells(numbers, sign).count();
    let goes_on = (lines.get(first + 1))
        .is_none_or(|(_, _, next)| is_row(next) && cells(next, delimiter(next)).count() == columns);
    if !goes_on
        || first < 2
        || (first == 2
            && columns > 1
            && width(0) >= columns
            && width(1) >= columns
            && rates_in(&[lines[0].2], sign).is_empty())
    {
        return None;
    }
    let units = are_units(lines[first - 1].2, sign);
    [first - if units { 2 } else { 1 }, first - 1]
        .into_iter()
        .find(|at| width(*at) == columns)
}

/// The cells of a line, without empty ones at its end. Separators in quotes separate nothing.
fn cells(line: &str, delimiter: u8) -> impl Iterator<Item = &str> {
    let sign = char::from(delimiter);
    let line = line.trim_end_matches([sign, ' ', '\t']);
    let mut is_open = quotes(line);
    let cells = line.split(move |letter| is_outside(letter, &mut is_open) && letter == sign);
    cells.map(|cell| cell.trim().trim_matches('"'))
}

/// Whether a letter, of those of a line in their order, is outside of quotes; a line whose quotes do not close has none.
fn is_outside(letter: char, is_open: &mut Option<bool>) -> bool {
    if let Some(open) = is_open {
        *open ^= letter == '"';
    }
    *is_open != Some(true)
}

/// The state before the first letter of a line.
fn quotes(line: &str) -> Option<bool> {
    let count = line.matches('"').count();
    (count > 0 && count.is_multiple_of(2)).then_some(false)
}

/// What separates the cells of a row of numbers: a comma only where nothing else does.
fn of_numbers(line: &str) -> u8 {
    let signs = [b'\t', b';'].into_iter();
    let mut found = signs.filter(|sign| line.trim_end().as_bytes().contains(sign));
    found.next().unwrap_or(b',')
}

fn is_row(line: &str, delimiter: u8) -> bool {
    let is_number = |cell: &str| {
        cell.bytes().any(|byte| byte.is_ascii_digit())
            && cell
                .chars()
                .all(|c| c.is_ascii_digit() || "+-−.,eE".contains(c))
    };
    let mut numbers = 0;
    let mut all = cells(line, delimiter);
    let fits = all.all(|cell| {
        numbers += usize::from(is_number(cell));
        cell.is_empty() || is_number(cell) || is_date(cell) || Stamp::of(cell).is_some()
    });
    fits && numbers > 0
}

/// Whether the cells of a line are units, in brackets or known.
fn are_units(line: &str, delimiter: u8) -> bool {
    let is_known = |cell: &str| !matches!(Unit::parse(cell).0, Unit::Other(_));
    let bare = |cell: &str| cell.trim_matches(['(', ')', '[', ']']).to_owned();
    let in_brackets = |cell: &str| cell.starts_with(['(', '[']) && cell.ends_with([')', ']']);
    let mut known = 0;
    let fits = cells(line, delimiter).all(|cell| {
        known += usize::from(is_known(&bare(cell)));
        cell.is_empty() || cell == "-" || in_brackets(cell) || is_known(&bare(cell))
    });
    fits && known > 0
}

/// What stands between the cells: the most frequent of tab, semicolon and comma in the header.
fn delimiter_of(header: &str) -> u8 {
    let delimiter = [b'\t', b';', b','].into_iter().max_by_key(|d| {
        let mut is_open = quotes(header);
        let letters = header
            .chars()
            .filter(|letter| is_outside(*letter, &mut is_open));
        let count = letters.filter(|letter| *letter == char::from(*d)).count();
        // On a tie the order above decides: max_by_key keeps the last, so tabs must count a little more.
        (
            count,
            [b',', b';', b'\t'].iter().position(|other| other == d),
        )
    });
    delimiter.unwrap_or(b',')
}

/// The rates that lines above the header of a table state, or their inverse, each with its line.
pub(super) fn rates_in(above: &[&str], delimiter: u8) -> Vec<(String, SampleRate)> {
    let rates = above.iter().filter_map(|line| {
        let small = line.to_lowercase();
        let behind = |keys: &[&str]| {
            let key = |key: &&str| Some(small.find(*key)? + key.len());
            small.get(keys.iter().find_map(key)?..)
        };
        let rate_hz = match behind(&RATES) {
            Some(rest) => {
                let (number, _) = number_in(rest, delimiter)?;
                let factor = match () {
                    () if small.contains("khz") => 1e3,
                    () if small.contains("/min") || small.contains("per min") => 1.0 / 60.0,
                    () => 1.0,
                };
                number * factor
            }
            None => {
                let rest = behind(&STEPS)?;
                let (number, after) = number_in(rest, delimiter)?;
                // `interval (ms),2`, `interval;0.5 ms`, `interval,0.5,ms`; in s without one, where that is short.
                let is_unit = |text: &&str| seconds_of(text).is_some();
                let signs = |c: char| c.is_whitespace() || "()[],;:\t\"=".contains(c);
                let before = &rest[..rest.len() - after.len()];
                let mut words = before.split(signs).chain(after.split(signs));
                let unit_s = words.find(is_unit).and_then(seconds_of);
                1.0 / (number * unit_s.or((number < 1.0).then_some(1.0))?)
            }
        };
        Some((line.trim().to_owned(), SampleRate::new(rate_hz).ok()?))
    });
    rates.collect()
}

/// The first number of a text, and what follows it.
fn number_in(text: &str, delimiter: u8) -> Option<(f64, &str)> {
    let text = &text[text.find(|c: char| c.is_ascii_digit())?..];
    let mut end = text
        .find(|c: char| !(c.is_ascii_digit() || c == '.' || c == ','))
        .unwrap_or(text.len());
    let number = rate_number(text[..end].trim_end_matches([',', '.']), delimiter)?;
    // 5.0e-04.
    let exponent = text[end..].strip_prefix('e').map_or("", |rest| {
        let digits = rest.trim_start_matches(['+', '-']);
        let digits = digits.len()
            - digits
                .trim_start_matches(|c: char| c.is_ascii_digit())
                .len();
        let sign = usize::from(rest.starts_with(['+', '-']));
        &rest[..if digits > 0 { sign + digits } else { 0 }]
    });
    let power: i32 = match exponent {
        "" => 0,
        exponent => {
            end += 1 + exponent.len();
            exponent.parse().ok()?
        }
    };
    Some((number * 10_f64.powi(power), &text[end..]))
}

/// A rate with points and commas: of both, the last is the decimal sign. A comma alone before three digits separates thousands in a table
/// whose cells are separated by commas; elsewhere it may be either.
fn rate_number(text: &str, delimiter: u8) -> Option<f64> {
    let (point, comma) = (text.rfind('.'), text.rfind(','));
    let plain = match (point, comma) {
        (_, None) => text.to_owned(),
        (Some(point), Some(comma)) if point > comma => text.replace(',', ""),
        (Some(_), Some(_)) => text.replace('.', "").replace(',', "."),
        (None, Some(comma)) => match (text.len() - comma, delimiter) {
            (4, b',') => text.replace(',', ""),
            (4, _) => return None,
            _ => text.replace(',', "."),
        },
    };
    plain.parse().ok()
}

/// The moment that a line above the header states as the start.
pub(super) fn start_in(above: &[&str]) -> Option<StartTime> {
    above.iter().find_map(|line| {
        let small = line.to_lowercase();
        STARTS.iter().find(|key| small.contains(*key))?;
        let signs = line
            .char_indices()
            .filter(|(_, c)| [':', ',', ';', '\t', '=', ' '].contains(c));
        let behind = signs.filter_map(|(at, sign)| line.get(at + sign.len_utf8()..));
        behind
            .map(|rest| rest.trim_matches([',', ';', '\t', ' ', '"']))
            .find_map(|rest| Stamp::of(rest)?.start())
    })
}
