//! Tables of numbers as text: commas, semicolons or tabs, a header, and units in the header or in a row of
//! their own.

use piezotact::statistics::median;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{
    Channel, Clock, Condition, Provenance, Recording, RecordingWarning, Stated, Steps,
};
use piezotact::series::is_sample;

use crate::commas::{Ambiguous, Evidence, Signs, signs_of};
use crate::error::ReadError;
use crate::open::ReadOptions;

/// Names under which a column holds the time.
const TIME_NAMES: [&str; 5] = ["time", "t", "timestamp", "zeit", "temps"];
/// Units at the end of a name, as Python writes them; a longer ending stands before one that it ends in.
const ENDINGS: [(&str, &str); 14] = [
    ("_mm_s2", "mm/s2"),
    ("_m_s2", "m/s2"),
    ("_ms2", "m/s2"),
    ("_mm_s", "mm/s"),
    ("_m_s", "m/s"),
    ("_mN", "mN"),
    ("_N", "N"),
    ("_n", "N"),
    ("_mV", "mV"),
    ("_V", "V"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_ms", "ms"),
    ("_s", "s"),
];
/// More columns than this are no channels: samples stand in rows.
const MOST_COLUMNS: usize = 4096;
/// Repeated time stamps up to this share of all rows are slips of the clock.
const MOST_REPEATED: f64 = 1e-3;
/// The tolerance for evenly spaced time steps, as a share of the median step.
const EVEN: f64 = 0.01;
/// A step that differs by more than this share from the usual one is a gap, not jitter: rows are missing.
const GAP: f64 = 0.25;

/// Reads a table; the rate comes from `options`, or else from its time column, and what 1 stands for in a
/// channel that names no unit may come from `options` too.
pub(crate) fn read_table(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let text = text_of(bytes);
    let delimiter = delimiter_of(&text);
    let wrong =
        |expected: &str, found: String, todo: &str| ReadError::content(path, expected, found, todo);
    let records = || {
        csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes())
            .into_records()
    };
    let mut warnings = Vec::new();
    let signs = signs_in(&text, delimiter, &mut warnings, records).map_err(|found| {
        wrong(
            "numbers whose decimal sign is known",
            format!(
                "`{}` and `{}`, of which either sign can separate thousands",
                found.point, found.comma
            ),
            "export the table without separators of thousands, or with another number of decimals",
        )
    })?;
    let mut rows = records()
        .enumerate()
        .filter(|(_, row)| !row.as_ref().is_ok_and(|row| row.iter().all(str::is_empty)));
    let number = |cell: &str| match signs {
        Some(signs) => signs.number(cell),
        None => cell.parse().ok(),
    };

    let header = match rows.next() {
        Some((_, Ok(row))) => row,
        _ => {
            return Err(wrong(
                "a table with a header",
                "nothing".into(),
                "check the file",
            ));
        }
    };
    let mut columns = columns_of(path, &header, &number)?;
    let width = columns.len();
    let mut second = true;
    let mut last_row = 1;
    for (at, row) in rows {
        let line = at + 1;
        let row =
            row.map_err(|error| wrong("rows of numbers", error.to_string(), "repair the file"))?;
        if let Some(extra) = row.iter().skip(width).find(|cell| !cell.is_empty()) {
            return Err(wrong(
                &format!("{width} columns in every row, as in the header"),
                format!("one more, `{extra}`, in row {line}"),
                "if the numbers have decimal commas, export with semicolons or tabs between columns",
            ));
        }
        let cells: Vec<&str> = row.iter().take(width).collect();
        if std::mem::take(&mut second) && cells.iter().all(|cell| number(cell).is_none()) {
            for (column, unit) in columns.iter_mut().zip(&cells) {
                column.unit = Some(unit.trim_matches(['(', ')', '[', ']']).to_owned());
            }
            continue;
        }
        if cells.len() < width {
            return Err(wrong(
                &format!("{width} columns in every row"),
                format!("{} in row {line}", cells.len()),
                "the file was cut short or a cell is missing: repair that row",
            ));
        }
        for (column, cell) in columns.iter_mut().zip(&cells) {
            let value = number(cell).filter(|value| is_sample(*value));
            let value = value.ok_or_else(|| no_number(path, column, cell, line))?;
            column.values.push(value);
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
    assemble(path, columns, warnings, options)
}

/// Lab programs write Latin-1 as often as UTF-8; only names and units can be hit by it.
fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

/// What stands between the cells: the most frequent of tab, semicolon and comma in the first line.
fn delimiter_of(text: &str) -> u8 {
    let first = text
        .lines()
        .find(|line| !line.trim().is_empty())
        .unwrap_or("");
    let delimiter = [b'\t', b';', b','].into_iter().max_by_key(|d| {
        let count = first.bytes().filter(|b| b == d).count();
        // On a tie the order above decides: max_by_key keeps the last, so tabs must count a little more.
        (
            count,
            [b',', b';', b'\t'].iter().position(|other| other == d),
        )
    });
    delimiter.unwrap_or(b',')
}

/// The empty columns that a header names.
fn columns_of(
    path: &Path,
    header: &csv::StringRecord,
    number: &dyn Fn(&str) -> Option<f64>,
) -> Result<Vec<Column>, ReadError> {
    if header.iter().all(|cell| number(cell).is_some()) {
        return Err(ReadError::content(
            path,
            "a header with the names of the channels in the first row",
            format!("numbers ({})", header.iter().next().unwrap_or("")),
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
    let mut columns: Vec<Column> = header.iter().map(Column::from_header).collect();
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
fn signs_in<R: Iterator<Item = csv::Result<csv::StringRecord>>>(
    text: &str,
    delimiter: u8,
    warnings: &mut Vec<Warning>,
    records: impl Fn() -> R,
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
    for row in records().skip(1).flatten() {
        for (at, cell) in row.iter().enumerate().take(MOST_COLUMNS) {
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

/// One column as a file holds it.
#[derive(Clone)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
    pub(crate) values: Vec<f64>,
}

/// The advice for channels whose unit the file does not name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum WithoutUnit<'a> {
    /// The header can name it.
    HeaderCan,
    /// Only --scale can.
    OnlyScale {
        /// The channels whose samples are integers, counts of a converter.
        counts: &'a [String],
    },
}

impl Column {
    /// `acc (m/s2)`, `acc [m/s2]`, `acc_m_s2` or plain `acc`.
    pub(crate) fn from_header(cell: &str) -> Self {
        let in_brackets = ['(', '['].into_iter().find_map(|open| {
            let (name, rest) = cell.split_once(open)?;
            Some((name.trim(), rest.trim_end_matches([')', ']']).trim()))
        });
        let at_its_end = || {
            let mut units = ENDINGS.iter();
            let (name, unit) =
                units.find_map(|(ending, unit)| Some((cell.strip_suffix(ending)?, *unit)))?;
            // Only times are in s and ms: a name may end in an s for other reasons.
            (!["s", "ms"].contains(&unit) || is_time(name)).then_some((name, unit))
        };
        let parts = in_brackets.or_else(at_its_end);
        let (name, unit) = match parts {
            Some((name, unit)) if !name.is_empty() => (name, Some(unit.to_owned())),
            _ => (cell, None),
        };
        Self {
            name: name.into(),
            unit,
            values: Vec::new(),
        }
    }

    fn is_time(&self) -> bool {
        is_time(&self.name)
    }
}

/// Whether a column of this name holds the time.
pub(crate) fn is_time(name: &str) -> bool {
    TIME_NAMES.contains(&name.to_ascii_lowercase().as_str())
}

fn assemble(
    path: &Path,
    mut columns: Vec<Column>,
    mut warnings: Vec<Warning>,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let time = columns.iter().position(Column::is_time);
    if let Some(time) = time {
        warnings.extend(without_copied_rows(&mut columns, time));
    }
    let time = time.map(|at| columns.remove(at));
    let mut of_time = Vec::new();
    let found = time.map(|time| rate_of(path, &time, &mut of_time));
    let rate = choose_rate(path, options.rate, found, &mut of_time)?;
    warnings.extend(of_time);
    recording_of(
        path,
        columns,
        rate,
        warnings,
        options,
        WithoutUnit::HeaderCan,
    )
}

/// Leaves out rows that repeat the row before them with its time stamp, where they are few, with a warning.
fn without_copied_rows(columns: &mut [Column], time: usize) -> Option<Warning> {
    let stamps = &columns[time].values;
    let is_copy = |row: usize| {
        let mut columns = columns.iter();
        columns.all(|column| column.values[row] == column.values[row - 1])
    };
    let copies: Vec<usize> = (1..stamps.len())
        .filter(|row| stamps[*row] == stamps[row - 1] && is_copy(*row))
        .collect();
    let stamp = *stamps.get(*copies.first()?)?;
    if copies.len() > most_repeated(stamps.len()) {
        return None;
    }
    for column in columns {
        let mut row = 0;
        column.values.retain(|_| {
            row += 1;
            copies.binary_search(&(row - 1)).is_err()
        });
    }
    Some(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "{} the row before with its time stamp {} left out (the first at {stamp})",
            match copies.len() {
                1 => "1 row that repeats".to_owned(),
                count => format!("{count} rows that repeat"),
            },
            if copies.len() == 1 { "was" } else { "were" }
        ),
    }))
}

/// How many time stamps of so many may be repeated.
fn most_repeated(stamps: usize) -> usize {
    ((stamps as f64 * MOST_REPEATED) as usize).max(1)
}

/// The rate that is stated, or else the one that was found; a warning where they differ.
pub(crate) fn choose_rate(
    path: &Path,
    stated: Option<SampleRate>,
    found: Option<Result<SampleRate, ReadError>>,
    warnings: &mut Vec<Warning>,
) -> Result<SampleRate, ReadError> {
    match (stated, found) {
        (Some(stated), Some(found)) => {
            // Warnings about time stamps that are not used are irrelevant.
            warnings.clear();
            match found {
                Ok(found) if (found.hz() / stated.hz() - 1.0).abs() > EVEN => {
                    warnings.push(Warning::from(RecordingWarning::StatedDiffers {
                        what: Stated::Rate {
                            stated_hz: stated.hz(),
                            found_hz: found.hz(),
                        },
                    }));
                }
                Ok(_) => {}
                Err(error) => warnings.push(Warning::from(RecordingWarning::Guessed {
                    what: format!(
                        "the time column was not used; the stated rate was used ({error})"
                    ),
                })),
            }
            Ok(stated)
        }
        (Some(stated), None) => Ok(stated),
        (None, Some(found)) => found,
        (None, None) => Err(ReadError::content(
            path,
            "a time column, or a rate",
            "neither",
            "give the rate with --rate, for example --rate 5000",
        )),
    }
}

/// The recording of `columns` at `rate`, in SI; `warnings` are those about the rate.
pub(crate) fn recording_of(
    path: &Path,
    columns: Vec<Column>,
    rate: SampleRate,
    warnings: Vec<Warning>,
    options: &ReadOptions,
    unnamed: WithoutUnit<'_>,
) -> Result<Recording, ReadError> {
    let clock = Clock::at(rate);
    let columns = columns.into_iter().map(|column| (column, clock)).collect();
    recording_of_clocks(path, columns, warnings, options, unnamed)
}

/// As [`recording_of`], where every column has a clock.
pub(crate) fn recording_of_clocks(
    path: &Path,
    columns: Vec<(Column, Clock)>,
    mut warnings: Vec<Warning>,
    options: &ReadOptions,
    unnamed: WithoutUnit<'_>,
) -> Result<Recording, ReadError> {
    let mut channels = Vec::with_capacity(columns.len());
    let (mut without_unit, mut scaled) = (Vec::new(), false);
    for (column, clock) in columns {
        let (mut unit, mut factor) = Unit::parse(column.unit.as_deref().unwrap_or(""));
        if matches!(&unit, Unit::Other(text) if text.is_empty()) {
            match &options.scale {
                Some(scale) => (unit, factor, scaled) = (scale.unit.clone(), scale.value, true),
                None => without_unit.push(column.name.clone()),
            }
        }
        let mut samples = column.values;
        for sample in &mut samples {
            *sample *= factor;
        }
        let name = column.name;
        channels.push((
            Channel {
                name,
                unit,
                samples,
            },
            clock,
        ));
    }
    if let WithoutUnit::OnlyScale { counts } = unnamed {
        let warning = |channel: String| match counts.contains(&channel) {
            true => RecordingWarning::Counts { channel },
            false => RecordingWarning::Uncalibrated { channel },
        };
        let unscaled = without_unit.drain(..).filter(|_| !options.is_drive);
        warnings.extend(unscaled.map(warning).map(Warning::from));
    }
    if let [first, others @ ..] = without_unit.as_slice() {
        let others = if others.is_empty() {
            String::new()
        } else {
            format!(" and {} more", others.len())
        };
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "channel `{first}`{others} has no unit and is read as numbers without unit (write `{first} (m/s2)` in the \
                 header, or give the value of 1 with --scale)"
            ),
        }));
    }
    if let (Some(scale), false) = (&options.scale, scaled) {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!("the scale {scale} was not used: every channel has a unit"),
        }));
    }
    let provenance = Provenance {
        source: path.display().to_string(),
        ..Provenance::default()
    };
    let mut recording = Recording::with_clocks(channels, Condition::default(), provenance)
        .map_err(ReadError::of(path))?;
    recording.about.warnings = warnings;
    Ok(recording)
}

/// How far a rate from rounded time stamps may lie from a whole number to be taken for it.
const ROUNDED: f64 = 2e-6;

/// The rate that a time column stands for: one over its mean step, when no step is a gap.
pub(crate) fn rate_of(
    path: &Path,
    time: &Column,
    warnings: &mut Vec<Warning>,
) -> Result<SampleRate, ReadError> {
    let steps: Vec<f64> = time
        .values
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    if steps.is_empty() {
        return Err(ReadError::content(
            path,
            "two rows or more",
            "one",
            "record longer, or give --rate",
        ));
    }
    let repeated = repeated_stamps(path, time, &steps)?;
    let mut forward: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    let Some(usual) = median(&mut forward) else {
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!("{} in every row", time.values[0]),
            "export the time with more digits, or give --rate to read the rows as evenly sampled",
        ));
    };
    let repeats = Repeats::of(&steps, &repeated, usual);
    warnings.extend(repeats.warning(time, repeated.first().copied()));
    if let Some(at) = steps
        .iter()
        .enumerate()
        .position(|(at, step)| !repeats.explain(at) && (step / usual - 1.0).abs() > GAP)
    {
        return Err(ReadError::content(
            path,
            format!("`{}` to increase in steps of about {usual}", time.name),
            format!("a step from {} to {}", time.values[at], time.values[at + 1]),
            "rows are missing or the clock changed: cut the recording there, or give --rate to read it as evenly sampled",
        ));
    }
    let mean = (time.values[time.values.len() - 1] - time.values[0])
        / (steps.len() - repeats.extra) as f64;
    let to_seconds = seconds_per_unit(path, time, mean, warnings)?;
    let worst = steps
        .iter()
        .enumerate()
        .filter(|(at, _)| !repeats.explain(*at))
        .map(|(_, step)| (step / usual - 1.0).abs())
        .fold(0.0, f64::max);
    if worst > EVEN {
        warnings.push(Warning::from(RecordingWarning::UnevenSteps {
            worst,
            of: Steps::Time,
        }));
    }
    // Time stamps are rounded to the digits of the table: a rate that close to a whole number is one.
    let found_hz = 1.0 / (mean * to_seconds);
    let whole = (found_hz - found_hz.round()).abs() <= ROUNDED * found_hz;
    let rate_hz = if whole { found_hz.round() } else { found_hz };
    SampleRate::new(rate_hz).map_err(ReadError::of(path))
}

/// Where `steps` repeat a time stamp; an error where the time does not increase.
fn repeated_stamps(path: &Path, time: &Column, steps: &[f64]) -> Result<Vec<usize>, ReadError> {
    if let Some(at) = steps.iter().position(|step| *step < 0.0) {
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!(
                "{} after {} in row {at} below the header",
                time.values[at + 1],
                time.values[at],
                at = at + 2
            ),
            "if rows are out of order, sort them by time; if the clock was set back, cut the recording there; or give --rate to \
             read the rows as evenly sampled",
        ));
    }
    let repeated: Vec<usize> = (0..steps.len()).filter(|at| steps[*at] == 0.0).collect();
    if repeated.len() > most_repeated(time.values.len()) {
        let at = repeated[0];
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!(
                "{} again in row {} below the header, and {} stamps that are repeated in all",
                time.values[at + 1],
                at + 2,
                repeated.len()
            ),
            "export the time with more digits, or give --rate to read the rows as evenly sampled",
        ));
    }
    Ok(repeated)
}

/// What 1 in a time column is in s: by its unit, or else guessed from its `mean` step.
fn seconds_per_unit(
    path: &Path,
    time: &Column,
    mean: f64,
    warnings: &mut Vec<Warning>,
) -> Result<f64, ReadError> {
    Ok(match time.unit.as_deref().map(Unit::parse) {
        Some((Unit::Second, factor)) => factor,
        Some((unit, _)) if unit != Unit::Other(String::new()) => {
            return Err(ReadError::content(
                path,
                format!("`{}` in s, ms or µs", time.name),
                unit.symbol().to_owned(),
                "correct its unit, or give --rate",
            ));
        }
        _ => {
            // Whole numbers that step by more than one are milliseconds; anything else is seconds.
            let whole = time.values.iter().all(|t| t.fract() == 0.0) && mean > 1.0;
            let (unit, factor) = if whole {
                ("milliseconds", 1e-3)
            } else {
                ("seconds", 1.0)
            };
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "`{}` has no unit and is read as {unit} (mean step {})",
                    time.name,
                    digits(mean)
                ),
            }));
            factor
        }
    })
}

/// Steps that time stamps repeated by a slip of the clock explain.
struct Repeats {
    /// The steps of 0, and the double ones beside them.
    steps: Vec<usize>,
    /// Rows more than the time has room for: repeated stamps without a double step beside them.
    extra: usize,
}

impl Repeats {
    fn of(steps: &[f64], repeated: &[usize], usual: f64) -> Self {
        let mut explained = Vec::new();
        let mut extra = 0;
        for &at in repeated {
            explained.push(at);
            let double = |at: &usize| {
                let step = steps.get(*at).copied().unwrap_or(0.0);
                (step / (2.0 * usual) - 1.0).abs() <= GAP && !explained.contains(at)
            };
            match [at + 1, at.wrapping_sub(1)].into_iter().find(double) {
                Some(double) => explained.push(double),
                None => extra += 1,
            }
        }
        explained.sort_unstable();
        Self {
            steps: explained,
            extra,
        }
    }

    fn explain(&self, step: usize) -> bool {
        self.steps.binary_search(&step).is_ok()
    }

    fn warning(&self, time: &Column, first: Option<usize>) -> Option<Warning> {
        let stamp = time.values.get(first?)?;
        let repeated = self.steps.iter();
        let count = repeated
            .filter(|at| time.values.get(**at) == time.values.get(**at + 1))
            .count();
        Some(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "{} repeated in `{}` (the first: {stamp}); the rows are read as evenly sampled",
                match count {
                    1 => "1 time stamp is".to_owned(),
                    count => format!("{count} time stamps are"),
                },
                time.name
            ),
        }))
    }
}

#[cfg(test)]
mod tests;
