//! Tables of BIDS: columns between tabulators, `n/a` where there is nothing.

use std::io::BufRead;
use std::path::Path;

use piezotact::page::{Cell, Column, Table};

use super::NOTHING;
use super::error::BidsError;
use piezotact_dataset::ReadError;
use piezotact_dataset::open_input;

/// The longest line that is read, in bytes.
const LONGEST_LINE: u64 = 1 << 24;

/// `table` as BIDS has tables; numbers in the shortest form that gives the same number again.
///
/// # Errors
/// [`BidsError::Text`] for a text that it cannot hold; `place` names the table.
pub(super) fn tsv_text(table: &Table, place: &str) -> Result<String, BidsError> {
    let refused = |column: &str, found: &str| BidsError::Text {
        place: format!("{place}, column {column}"),
        found: found.to_owned(),
    };
    let mut text = String::new();
    for (i, column) in table.columns.iter().enumerate() {
        if i > 0 {
            text.push('\t');
        }
        if column.name.is_empty() || column.name.contains(['\t', '\n', '\r']) {
            return Err(refused("of the heading", &column.name));
        }
        text.push_str(&column.name);
    }
    text.push('\n');
    for row in &table.rows {
        for (i, (cell, column)) in row.iter().zip(&table.columns).enumerate() {
            if i > 0 {
                text.push('\t');
            }
            match cell {
                Cell::Number(value) | Cell::Rounded { value, .. } if value.is_finite() => {
                    text.push_str(&value.to_string());
                }
                Cell::Outcome(outcome) => text.push_str(outcome.word()),
                Cell::Text(found) if found.is_empty() => text.push_str(NOTHING),
                Cell::Text(found) => {
                    if found.contains(['\t', '\n', '\r']) || found == NOTHING {
                        return Err(refused(&column.name, found));
                    }
                    text.push_str(found);
                }
                Cell::Number(_) | Cell::Rounded { .. } | Cell::Missing(()) => {
                    text.push_str(NOTHING)
                }
            }
        }
        text.push('\n');
    }
    Ok(text)
}

/// The lines of a text file, one at a time; each with its number, from 1.
pub(super) struct Lines<R> {
    of: R,
    number: u64,
    line: Vec<u8>,
}

/// Why a line cannot be read.
pub(super) enum LineFault {
    /// It is too long.
    Long,
    /// It is no text in UTF-8.
    NoText,
    /// The file cannot be read.
    Io(std::io::Error),
}

impl LineFault {
    pub(super) fn sentence(&self) -> String {
        match self {
            Self::Long => format!(
                "expected lines of at most {LONGEST_LINE} bytes, found a longer one; it is no table of BIDS"
            ),
            Self::NoText => "expected text in UTF-8, found other bytes; save it in UTF-8".into(),
            Self::Io(error) => format!(
                "expected a file that can be read to its end, found one that cannot ({error}); copy it again"
            ),
        }
    }
}

impl<R: BufRead> Lines<R> {
    pub(super) fn of(of: R) -> Self {
        Self {
            of,
            number: 0,
            line: Vec::new(),
        }
    }

    /// The next line with its number; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<(u64, &str)>, (u64, LineFault)> {
        use std::io::Read as _;
        self.line.clear();
        let number = self.number + 1;
        let mut limited = (&mut self.of).take(LONGEST_LINE);
        let read = limited.read_until(b'\n', &mut self.line);
        let read = read.map_err(|error| (number, LineFault::Io(error)))?;
        if read == 0 {
            return Ok(None);
        }
        self.number = number;
        if self.line.last() == Some(&b'\n') {
            self.line.pop();
            if self.line.last() == Some(&b'\r') {
                self.line.pop();
            }
        } else if read as u64 == LONGEST_LINE {
            return Err((number, LineFault::Long));
        }
        let mut bytes = self.line.as_slice();
        if number == 1 {
            bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        }
        match std::str::from_utf8(bytes) {
            // Wide characters of another encoding.
            Ok(line) if line.contains('\0') => Err((number, LineFault::NoText)),
            Ok(line) => Ok(Some((number, line))),
            Err(_no_text) => Err((number, LineFault::NoText)),
        }
    }
}

/// The table at `path`, whose name from the root is `file`; cells are texts, and missing where they have nothing.
pub(super) fn read_table(path: &Path, file: &str) -> Result<Table, BidsError> {
    let opened = open_input(path)?;
    let mut lines = Lines::of(std::io::BufReader::new(opened));
    let mut table: Option<Table> = None;
    loop {
        let (number, line) = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err((number, fault)) => return Err(BidsError::file(file, number, fault.sentence())),
        };
        match &mut table {
            None => {
                let names = line.split('\t');
                table = Some(Table::new(names.map(|name| Column::new(name, name))));
            }
            Some(table) => {
                if line.is_empty() && table.columns.len() > 1 {
                    continue;
                }
                let cells = line.split('\t').map(|cell| match cell {
                    "" | NOTHING => Cell::Missing(()),
                    text => Cell::from(text),
                });
                let row: Vec<Cell> = cells.collect();
                if row.len() != table.columns.len() {
                    return Err(BidsError::file(
                        file,
                        number,
                        format!(
                            "expected {} cells as in the heading, found {}; complete the line",
                            table.columns.len(),
                            row.len()
                        ),
                    ));
                }
                table.rows.push(row);
            }
        }
    }
    table.ok_or_else(|| {
        BidsError::Read(ReadError::content(
            path,
            "a table with a heading",
            "an empty file",
            "it was cut short: copy it again",
        ))
    })
}

/// The text in `column` of row `row`; `None` where the column is not there or the cell has nothing.
pub(super) fn cell<'a>(table: &'a Table, row: usize, column: &str) -> Option<&'a str> {
    let at = table.columns.iter().position(|one| one.name == column)?;
    match table.rows.get(row)?.get(at)? {
        Cell::Text(text) => Some(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let mut table = Table::new(["onset", "name"].map(|name| Column::new(name, name)));
        table.rows = vec![
            vec![Cell::from(0.1 + 0.2), Cell::from("S2 INVERTED")],
            vec![Cell::from(f64::NAN), Cell::from("")],
            vec![Cell::Missing(()), Cell::from("é|ü")],
        ];
        let text = tsv_text(&table, "a table").unwrap();
        assert_eq!(
            text.lines().nth(1),
            Some("0.30000000000000004\tS2 INVERTED")
        );
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let read = read_table(file.path(), "a.tsv").unwrap();
        assert_eq!(cell(&read, 0, "onset"), Some("0.30000000000000004"));
        assert_eq!(
            (cell(&read, 1, "onset"), cell(&read, 1, "name")),
            (None, None)
        );
        assert_eq!(cell(&read, 2, "name"), Some("é|ü"));
        for odd in ["n/a", "a\tb", "a\nb"] {
            table.rows[0][1] = Cell::from(odd);
            let said = tsv_text(&table, "a table").unwrap_err().to_string();
            assert!(said.contains("a table, column name"), "{said}");
        }
        std::fs::write(file.path(), "a\tb\n1\t2\n3\n").unwrap();
        let said = read_table(file.path(), "a.tsv").unwrap_err().to_string();
        assert!(said.contains("a.tsv, line 3: expected 2 cells"), "{said}");
    }
}
