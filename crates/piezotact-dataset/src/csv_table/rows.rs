//! The rows of a table as text: straight from the text where no cell stands in quotes.

use std::borrow::Cow;
use std::iter::Peekable;

use csv::StringRecord;

/// A row of a table with quotes, and its place.
type Quoted<'t> = Box<dyn Iterator<Item = (usize, csv::Result<StringRecord>)> + 't>;

/// The rows of a table that are not blank.
pub(super) enum Rows<'t> {
    /// Without quotes: what is left of the text, the delimiter, and how many lines were read that are not empty.
    Plain(&'t str, char, usize),
    Quoted(Peekable<Quoted<'t>>),
}

impl<'t> Rows<'t> {
    /// Those of `text`, whose cells `delimiter` separates.
    pub(super) fn of(text: &'t str, delimiter: u8) -> Self {
        let mut returns = text.match_indices('\r');
        let is_plain = !text.contains('"')
            && returns.all(|(at, _)| text.as_bytes().get(at + 1) == Some(&b'\n'));
        if is_plain {
            return Self::Plain(text, char::from(delimiter), 0);
        }
        Self::quoted(text, delimiter)
    }

    /// Those of a text of which cells may stand in quotes, by crate csv.
    fn quoted(text: &'t str, delimiter: u8) -> Self {
        let reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let is_blank = |row: &StringRecord| row.iter().all(str::is_empty);
        let rows = reader.into_records().enumerate();
        let rows: Quoted<'t> =
            Box::new(rows.filter(move |(_, row)| !row.as_ref().is_ok_and(is_blank)));
        Self::Quoted(rows.peekable())
    }

    /// The cells of the next row, without the white space around them, and its place among the lines that are not empty; `None` behind
    /// the last one.
    pub(super) fn next(&mut self, cells: &mut Vec<Cow<'t, str>>) -> Option<csv::Result<usize>> {
        cells.clear();
        match self {
            Self::Plain(text, delimiter, read) => loop {
                let line = next_line(text)?;
                if line.is_empty() {
                    continue;
                }
                *read += 1;
                cells.extend(
                    line.split(*delimiter)
                        .map(|cell| Cow::Borrowed(cell.trim())),
                );
                if !cells.iter().all(|cell| cell.is_empty()) {
                    return Some(Ok(*read - 1));
                }
                cells.clear();
            },
            Self::Quoted(rows) => {
                let (at, row) = rows.next()?;
                let row = match row {
                    Ok(row) => row,
                    Err(error) => return Some(Err(error)),
                };
                cells.extend(row.iter().map(|cell| Cow::Owned(cell.to_owned())));
                Some(Ok(at))
            }
        }
    }

    /// Whether no row follows.
    pub(super) fn is_at_end(&mut self) -> bool {
        match self {
            Self::Plain(text, delimiter, _) => text
                .split('\n')
                .all(|line| line.split(*delimiter).all(|cell| cell.trim().is_empty())),
            Self::Quoted(rows) => rows.peek().is_none(),
        }
    }
}

/// The next line of `text`, without its end, of which what follows is left; `None` behind the last one.
fn next_line<'t>(text: &mut &'t str) -> Option<&'t str> {
    if text.is_empty() {
        return None;
    }
    let (line, rest) = text.split_once('\n').unwrap_or((text, ""));
    *text = rest;
    Some(line.strip_suffix('\r').unwrap_or(line))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    /// All rows with their places, and whether the end was seen before each of them and behind the last.
    fn all_of(mut rows: Rows<'_>) -> (Vec<(usize, Vec<String>)>, Vec<bool>) {
        let (mut found, mut ends) = (Vec::new(), vec![rows.is_at_end()]);
        let mut cells = Vec::new();
        while let Some(at) = rows.next(&mut cells) {
            let cells = cells.iter().map(|cell| cell.to_string()).collect();
            found.push((at.expect("no row of this text is malformed"), cells));
            ends.push(rows.is_at_end());
        }
        (found, ends)
    }

    #[test]
    fn both_ways_give_the_same_rows() {
        const PARTS: [&str; 12] = [
            "1.5", "−2", "a b", " ", "\t", ",", ";", "\n", "\r\n", "\n\n", "é", "",
        ];
        let mut random = Random::stream(5, 0, "rows");
        let mut below = |n: usize| (random.uniform() * n as f64) as usize;
        for _ in 0..4000 {
            let length = below(40);
            let text: String = (0..length).map(|_| PARTS[below(PARTS.len())]).collect();
            for delimiter in [b',', b';', b'\t'] {
                let plain = Rows::of(&text, delimiter);
                assert!(matches!(plain, Rows::Plain(..)), "{text:?}");
                assert_eq!(
                    all_of(plain),
                    all_of(Rows::quoted(&text, delimiter)),
                    "{text:?} at {delimiter}"
                );
            }
        }
    }

    #[test]
    fn quotes_and_lone_returns_are_read_by_the_crate() {
        for text in ["a,\"b\"\n", "1,2\r3,4\r", "\r"] {
            assert!(matches!(Rows::of(text, b','), Rows::Quoted(_)), "{text:?}");
        }
    }
}
