//! Tables of numbers as text: commas, semicolons or tabs, a header, and units in the header or in a row of
//! their own.

mod layout;
mod rows;

use std::borrow::Cow;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::counted;
use piezotact::quantity::Seconds;
use piezotact::recording::{Recording, RecordingWarning, StartTime};
use piezotact::series::is_sample;

use crate::columns::{Column, Table};
use crate::commas::{Ambiguous, Evidence, Signs, signs_of};
use crate::date_time::{DAY_S, Stamp, Stamps, is_date};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::stated_rate::is_same_rate;
use crate::text::{FEW_ROWS, decimals_of, text_of};
use crate::time_column::is_time;
use layout::{Layout, layout, rates_in, start_in};
use rows::Rows;

/// More columns than this are no channels: samples stand in rows.
const MOST_COLUMNS: usize = 4096;

/// Reads a table; the rate comes from `options`, or else from its time column, and what 1 stands for in a
/// channel that names no unit may come from `options` too.
pub(crate) fn read_table(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let text = text_of(bytes);
    let Layout {
        text,
        delimiter,
        above,
        lines_above,
    } = layout(&text);
    let wrong =
        |expected: &str, found: String, todo: &str| ReadError::content(path, expected, found, todo);
    let mut warnings = Vec::from_iter(skipped(&above));
    let signs = signs_in(text, delimiter, &mut warnings).map_err(|found| {
        wrong(
            "numbers whose decimal sign is known",
            format!(
                "`{}` and `{}`, of which either sign can separate thousands",
                found.point, found.comma
            ),
            "export the table without separators of thousands, or with another number of decimals",
        )
    })?;
    let mut rows = Rows::of(text, delimiter);
    let number = |cell: &str| match signs {
        Some(signs) => signs.number(cell),
        None => cell.parse().ok(),
    };

    let mut cells: Vec<Cow<'_, str>> = Vec::new();
    let Some(Ok(_)) = rows.next(&mut cells) else {
        return Err(wrong(
            "a table with a header",
            "nothing".into(),
            "check the file",
        ));
    };
    let mut columns = columns_of(path, &cells, &number)?;
    let width = columns.len();
    let mut cells_of = Vec::new();
    let mut second = true;
    let mut last_row = lines_above + 1;
    let has_end = text.ends_with(['\n', '\r']);
    let mut decimals = Vec::<usize>::new();
    while let Some(at) = rows.next(&mut cells) {
        let at =
            at.map_err(|error| wrong("rows of numbers", error.to_string(), "repair the file"))?;
        let line = at + 1 + lines_above;
        if let Some(extra) = cells.iter().skip(width).find(|cell| !cell.is_empty()) {
            return Err(wrong(
                &format!("{width} columns in every row, as in the header"),
                format!("one more, `{extra}`, in row {line}"),
                "if the numbers have decimal commas, export with semicolons or tabs between columns",
            ));
        }
        cells.truncate(width);
        let is_moment = |cell: &str| Stamp::of(cell).is_some() || is_date(cell);
        let is_value = |cell: &Cow<'_, str>| number(cell).is_some() || is_moment(cell);
        if std::mem::take(&mut second) && !cells.iter().any(is_value) {
            for (column, unit) in columns.iter_mut().zip(&cells) {
                column.unit = Some(unit.trim_matches(['(', ')', '[', ']']).to_owned());
            }
            continue;
        }
        let count = columns.first().map_or(0, |column| column.values.len());
        if !has_end && count >= FEW_ROWS && rows.is_at_end() {
            // Where every number has as many decimals, this one is whole.
            let is_whole = cells.len() == width
                && cells
                    .last()
                    .and_then(|cell| decimals_of(cell))
                    .is_some_and(|own| decimals == [own]);
            if !is_whole {
                let what = format!(
                    "the file is truncated: row {line} has no end of line, its last number may be cut, and it was left out"
                );
                warnings.push(Warning::from(RecordingWarning::Guessed { what }));
                break;
            }
        }
        if cells.len() < width {
            return Err(wrong(
                &format!("{width} columns in every row"),
                format!("{} in row {line}", cells.len()),
                "the file was cut short or a cell is missing: repair that row",
            ));
        }
        if cells_of.is_empty() {
            cells_of.extend(cells.iter().map(|cell| Cells::of(cell)));
        }
        for ((column, cell), of) in columns.iter_mut().zip(&cells).zip(&mut cells_of) {
            let value = match of {
                Cells::Numbers => number(cell).filter(|value| is_sample(*value)),
                Cells::Moments(stamps) => stamps.seconds(cell),
                Cells::Dates(_) => is_date(cell).then_some(0.0),
            };
            let value = value.ok_or_else(|| no_number(path, column, cell, line))?;
            column.values.push(value);
        }
        if !has_end && decimals.len() < 2 {
            let own = cells.last().and_then(|cell| decimals_of(cell)).unwrap_or(0);
            if !decimals.contains(&own) {
                decimals.push(own);
            }
        }
        last_row = line;
    }
    if columns
        .first()
        .is_none_or(|column| column.values.is_empty())
    {
        return Err(wrong(
            "rows of numbers",
            format!("none below row {last_row}"),
            "check the export",
        ));
    }
    let mut rates = rates_in(&above, delimiter).into_iter();
    let stated = rates.next();
    if let Some((line, rate)) = &stated
        && let Some((other, _)) = rates.find(|(_, other)| !is_same_rate(rate.hz(), other.hz()))
    {
        let what = format!("`{other}` contradicts `{line}` above the header: the second was used");
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    let mut table = Table {
        stated,
        started_at: start_in(&above),
        warnings,
        ..Table::default()
    };
    let mut dates = cells_of.iter().filter_map(|of| match of {
        Cells::Dates(date) => Some(date.clone()),
        _ => None,
    });
    let date = dates.next();
    for (column, of) in columns.into_iter().zip(cells_of) {
        match of {
            Cells::Numbers => match excel_start(&column) {
                Some(start) => {
                    let first = column.values.first().copied().unwrap_or(0.0);
                    let seconds = column.values.iter().map(|day| (day - first) * DAY_S);
                    let values = seconds.collect();
                    table.add_moments(Column { values, ..column }, Some(start));
                }
                None => table.columns.push(column),
            },
            Cells::Moments(stamps) => table.add_moments(column, stamps.start(date.as_deref())),
            Cells::Dates(_) => {}
        }
    }
    table.recording(path, options)
}

/// What the cells of a column are, by its first row.
enum Cells {
    Numbers,
    Moments(Stamps),
    Dates(String),
}

impl Cells {
    fn of(first: &str) -> Self {
        match () {
            () if Stamp::of(first).is_some() => Self::Moments(Stamps::default()),
            () if is_date(first) => Self::Dates(first.to_owned()),
            () => Self::Numbers,
        }
    }
}

/// The moment of the first row of a column of days as Excel counts them, from the years 2000 to 2100: one called as dates are, or a
/// time whose steps are too short for seconds.
fn excel_start(column: &Column) -> Option<StartTime> {
    let (first, last) = (column.values.first()?, column.values.last()?);
    let days = 36_526.0..73_051.0;
    let is_days = days.contains(first) && days.contains(last) && column.unit.is_none();
    let called = ["date", "datum", "date time", "date/time", "datetime"];
    let is_date = called.contains(&column.name.to_lowercase().as_str());
    let step = (last - first) / (column.values.len().max(2) - 1) as f64;
    let is_time = is_time(&column.name) && step > 0.0 && step < 2e-6;
    let epoch = StartTime::try_from("1899-12-30T00:00:00".to_owned()).ok();
    let day = epoch.filter(|_| is_days && (is_date || is_time))?;
    Some(
        day.later(Seconds(first.floor() * DAY_S))
            .later(Seconds(first.fract() * DAY_S)),
    )
}

/// The warning that lines above the header were not read as a table.
fn skipped(above: &[&str]) -> Option<Warning> {
    let first = above.first()?;
    Some(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "{} above the header {} not read as part of the table (the first: `{}`)",
            counted(above.len(), "line"),
            if above.len() == 1 { "was" } else { "were" },
            first.trim().chars().take(60).collect::<String>()
        ),
    }))
}

/// The empty columns that a header names.
fn columns_of(
    path: &Path,
    header: &[Cow<'_, str>],
    number: &dyn Fn(&str) -> Option<f64>,
) -> Result<Vec<Column>, ReadError> {
    if header.iter().all(|cell| number(cell).is_some()) {
        return Err(ReadError::content(
            path,
            "a header with the names of the channels in the first row",
            format!("numbers ({})", header.first().map_or("", AsRef::as_ref)),
            "add a header such as `time (s),acc (m/s2)`",
        ));
    }
    if header.len() > MOST_COLUMNS {
        return Err(ReadError::content(
            path,
            format!("a table of at most {MOST_COLUMNS} columns, one for each channel"),
            format!("{}", header.len()),
            "if each row holds a channel, transpose the table; else export fewer channels",
        ));
    }
    // The header may be marked as a comment: `# time (s)`.
    let first = header.iter().take(1);
    let first = first.map(|cell| cell.trim_start_matches(['#', '%', ' ']));
    let cells = first.chain(header.iter().skip(1).map(AsRef::as_ref));
    let mut columns: Vec<Column> = cells.map(Column::from_header).collect();
    // A trailing delimiter makes an empty last column.
    while columns.last().is_some_and(|column| column.name.is_empty()) {
        columns.pop();
    }
    Ok(columns)
}

fn no_number(path: &Path, column: &Column, cell: &str, line: usize) -> ReadError {
    let found = if cell.is_empty() {
        "an empty cell"
    } else {
        cell
    };
    ReadError::content(
        path,
        "a number",
        format!("`{found}` in row {line}, column `{}`", column.name),
        "repair or cut that row",
    )
}

/// What commas and points in the numbers of a table stand for; none where points alone can stand in a number, as decimal signs.
/// Separators of thousands are a warning.
fn signs_in(
    text: &str,
    delimiter: u8,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Signs>, Ambiguous> {
    let possible = match delimiter {
        // Between commas, only a number in quotes has one.
        b',' => text.contains('"'),
        _ => text.contains([',', '.']),
    };
    if !possible {
        return Ok(None);
    }
    let mut evidence: Vec<Evidence> = Vec::new();
    let (mut rows, mut cells) = (Rows::of(text, delimiter), Vec::new());
    let mut below_header = false;
    while let Some(row) = rows.next(&mut cells) {
        if row.is_err() || !std::mem::replace(&mut below_header, true) {
            continue;
        }
        for (at, cell) in cells.iter().enumerate().take(MOST_COLUMNS) {
            if at == evidence.len() {
                evidence.push(Evidence::default());
            }
            evidence[at].add(cell);
        }
    }
    let (signs, said) = signs_of(&evidence, delimiter)?;
    warnings.extend(said.map(|what| Warning::from(RecordingWarning::Guessed { what })));
    Ok(Some(signs))
}

#[cfg(test)]
mod tests;
