//! Text as numbers: header lines, then rows of equal width.

use super::source::{Source, unit_m};
use piezotact_dataset::ReadError;

/// More lines than this without numbers are no header.
const LONGEST_HEADER: usize = 300;
/// What programs write for a point that was not measured, in capitals.
const NOT_MEASURED: [&str; 9] = ["", "NAN", "BAD", "***", "---", "-", "N/A", "NA", "NULL"];

/// Rows of numbers, and the text above them.
pub(super) struct Table {
    pub(super) header: Vec<String>,
    pub(super) width: usize,
    /// Row by row; NaN where nothing was measured.
    pub(super) values: Vec<f64>,
    /// The second row as it stands in the file.
    pub(super) second: String,
    separator: Separator,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Separator {
    Space,
    Of(char),
}

impl Separator {
    /// What separates the numbers of a line. A comma between digits is a decimal sign where something else
    /// separates: a tab, a semicolon, or spaces in a line without points.
    fn of(line: &str) -> Self {
        let decimal = |word: &str| {
            word.matches(',').count() <= 1 && !word.starts_with(',') && !word.ends_with(',')
        };
        if line.contains('\t') {
            Self::Of('\t')
        } else if line.contains(';') {
            Self::Of(';')
        } else if line.contains(',') {
            let words = line.split_whitespace();
            if !line.contains('.') && words.clone().count() > 1 && words.clone().all(decimal) {
                Self::Space
            } else {
                Self::Of(',')
            }
        } else {
            Self::Space
        }
    }

    fn cells<'l>(self, line: &'l str) -> Box<dyn Iterator<Item = &'l str> + 'l> {
        match self {
            Self::Space => Box::new(line.split_whitespace()),
            Self::Of(sign) => {
                // A separator at the end of a row opens no further cell.
                let line = line.trim_matches(' ');
                let line = line.strip_suffix(sign).unwrap_or(line);
                Box::new(line.split(sign).map(str::trim))
            }
        }
    }

    /// A number, NaN for a point that was not measured, or `None` for a word.
    fn number(self, cell: &str) -> Option<f64> {
        let cell = cell.trim_matches('"');
        let parsed = if self != Self::Of(',') && cell.contains(',') {
            cell.replace(',', ".").parse()
        } else {
            cell.parse()
        };
        match parsed {
            Ok(number) => Some(number),
            Err(_) => NOT_MEASURED
                .iter()
                .any(|missing| cell.eq_ignore_ascii_case(missing))
                .then_some(f64::NAN),
        }
    }
}

/// UTF-8, UTF-16 with its mark, or Latin-1; `None` for what is no text.
pub(super) fn decode(bytes: &[u8]) -> Option<String> {
    let utf16 = |bytes: &[u8], read: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| match pair {
            [a, b] => read([*a, *b]),
            _ => 0,
        });
        char::decode_utf16(units)
            .collect::<Result<String, _>>()
            .ok()
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ if bytes.contains(&0) => None,
        _ => Some(match std::str::from_utf8(bytes) {
            Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
            Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
        }),
    }
}

impl Table {
    pub(super) fn read(source: Source<'_>) -> Result<Self, ReadError> {
        let Some(text) = decode(source.bytes) else {
            return Err(source.wrong(
                "a topography: SUR, X3P, PLU, AL3D, BCR, SDF, NPY, MAT or text",
                "a binary file of an unknown kind",
                "export it as SUR, X3P, SDF or text",
            ));
        };
        let mut header = Vec::new();
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty());
        let no_numbers = |found: &str| {
            source.wrong(
                "rows of numbers",
                format!("none {found}"),
                "check the export",
            )
        };
        let (first, separator) = loop {
            let Some((_, line)) = lines.next() else {
                return Err(no_numbers("in the file"));
            };
            let separator = Separator::of(line);
            let cells = || separator.cells(line).map(|cell| separator.number(cell));
            if cells().all(|cell| cell.is_some()) && cells().flatten().any(|z| !z.is_nan()) {
                break (line, separator);
            }
            header.push(line.to_owned());
            if header.len() > LONGEST_HEADER {
                return Err(no_numbers("in the first lines"));
            }
        };
        let mut table = Self {
            header,
            width: separator.cells(first).count(),
            values: separator
                .cells(first)
                .filter_map(|cell| separator.number(cell))
                .collect(),
            second: String::new(),
            separator,
        };
        for (at, line) in lines {
            if table.second.is_empty() {
                line.trim().clone_into(&mut table.second);
            }
            let before = table.values.len();
            for cell in separator.cells(line) {
                table.values.push(separator.number(cell).ok_or_else(|| {
                    let shown: String = cell.chars().take(40).collect();
                    source.wrong(
                        "a number",
                        format!("`{shown}` in line {}", at + 1),
                        "repair or cut that row",
                    )
                })?);
            }
            let found = table.values.len() - before;
            if found != table.width {
                return Err(source.wrong(
                    format!("{} numbers in every row", table.width),
                    format!("{found} in line {}", at + 1),
                    "the file was cut short or a number is missing: repair that row",
                ));
            }
        }
        Ok(table)
    }

    pub(super) fn column(&self, at: usize) -> Vec<f64> {
        self.values
            .iter()
            .skip(at)
            .step_by(self.width.max(1))
            .copied()
            .collect()
    }

    /// What 1 stands for in each column, in m, where the header names units: in brackets, after a slash, or as
    /// a row of their own.
    pub(super) fn column_units_m(&self, source: Source<'_>) -> Result<Option<Vec<f64>>, ReadError> {
        for line in self.header.iter().rev() {
            let line = line.trim_start_matches(['#', '%', ' ']);
            let bracketed: Vec<&str> = line
                .split(['(', '['])
                .skip(1)
                .filter_map(|part| part.split([')', ']']).next())
                .collect();
            let cells: Vec<&str> = match self.separator {
                Separator::Space => Separator::of(line).cells(line).collect(),
                separator => separator.cells(line).collect(),
            };
            if bracketed.len() == self.width {
                return bracketed
                    .iter()
                    .map(|name| {
                        unit_m(name).ok_or_else(|| {
                            source.wrong(
                                "units of length in the header",
                                format!("`{name}`"),
                                "export heights in a unit of length",
                            )
                        })
                    })
                    .collect::<Result<_, _>>()
                    .map(Some);
            }
            if cells.len() == self.width {
                let units: Option<Vec<f64>> = cells
                    .iter()
                    .map(|cell| unit_m(cell.rsplit('/').next().unwrap_or(cell)))
                    .collect();
                if units.is_some() {
                    return Ok(units);
                }
            }
        }
        Ok(None)
    }
}
