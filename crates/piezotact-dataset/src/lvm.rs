//! LabVIEW measurement files (`.lvm`): text with a header for the file and one for each segment.
//!
//! Source of the layout: National Instruments, *Specification for the LabVIEW Measurement File (.lvm)*.

use piezotact::recording::RecordingWarning;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::Seconds;
use piezotact::recording::{Recording, StartTime};

use crate::columns::{Column, WithoutUnit, recording_of_bases, start_of_part};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::text::{text_of, without_cut_row};
use crate::time_column::{LONGEST_PAUSE, TimeBase, base_of, choose_base, rate_of_step};

const MAGIC: &str = "LabVIEW Measurement";
const END: &str = "***End_of_Header***";

/// Whether `bytes` begin as a LabVIEW measurement file does.
#[must_use]
pub fn looks_like_lvm(bytes: &[u8]) -> bool {
    text_of(&bytes[..bytes.len().min(64)]).starts_with(MAGIC)
}

/// What a column of a segment is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    Channel,
    Comment,
}

/// One column of a segment.
#[derive(Clone)]
struct Field {
    role: Role,
    name: String,
    unit: String,
    start: Option<f64>,
    step: Option<(f64, String)>,
    promised: Option<u64>,
    clock: Option<String>,
    values: Vec<f64>,
    /// Empty cells seen, and the row of the first.
    empty: Option<usize>,
}

struct Segment {
    fields: Vec<Field>,
    rows: usize,
    /// Whether it is several segments of the file, one behind the other.
    joined: bool,
    /// Rows before which samples are missing, and how many: between segments.
    gaps: Vec<(usize, usize)>,
}

/// Reads a measurement file. All rows are read, whatever number of samples the header promises; where the two differ,
/// a warning says so. `path` is what a refusal names.
///
/// # Errors
/// [`ReadError::Content`] when a header, a row or a rate is missing, a cell is no number, channels differ in length or
/// rate, or segments do not follow each other; [`ReadError::Invalid`] when the rate is impossible.
pub fn parse_lvm(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Recording, ReadError> {
    let text = text_of(bytes);
    let below_header = text.rfind(END).map_or(0, |at| at + END.len());
    let (whole, cut) = without_cut_row(&text, below_header);
    let mut reader = Reader {
        path,
        lines: whole.lines().enumerate().peekable(),
        separator: '\t',
        decimal: None,
        comments: Vec::new(),
    };
    reader.file_header()?;
    let mut segments = Vec::new();
    while let Some(segment) = reader.segment()? {
        segments.push(segment);
    }
    let comments = std::mem::take(&mut reader.comments);
    let mut warnings = Vec::from_iter(cut);
    let joined = join(path, segments, &mut warnings)?;
    assemble(path, joined, &comments, warnings, options)
}

struct Reader<'a, I: Iterator<Item = (usize, &'a str)>> {
    path: &'a Path,
    lines: std::iter::Peekable<I>,
    separator: char,
    decimal: Option<char>,
    /// The rows with a comment, and what they say.
    comments: Vec<(usize, String)>,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Reader<'a, I> {
    fn wrong(&self, expected: &str, found: String, todo: &str) -> ReadError {
        ReadError::content(self.path, expected, found, todo)
    }

    fn file_header(&mut self) -> Result<(), ReadError> {
        for (at, line) in self.lines.by_ref() {
            if line.starts_with(END) {
                return Ok(());
            }
            // The separator of the file stands behind every key, in this line too.
            if let Some(value) = line.strip_prefix("Separator") {
                if value.to_ascii_lowercase().contains("comma") {
                    self.separator = ',';
                }
            } else if let Some(value) = line.strip_prefix("Decimal_Separator") {
                self.decimal = value.trim_end().chars().last();
            } else if at == 1 && !line.contains('\t') && line.contains(',') {
                self.separator = ',';
            }
        }
        Err(self.wrong(
            "***End_of_Header*** after the header of the file",
            "the end of the file".into(),
            "the file was cut short: copy or export it again",
        ))
    }

    /// A number with the file's decimal sign; without a stated one either is understood where columns are not
    /// separated by commas.
    fn number(&self, cell: &str) -> Option<f64> {
        match (self.decimal, self.separator) {
            (Some(','), _) => cell.replace(',', ".").parse().ok(),
            (None, '\t') => cell
                .parse()
                .ok()
                .or_else(|| cell.replace(',', ".").parse().ok()),
            _ => cell.parse().ok(),
        }
    }

    /// The next segment: its header, the names of its columns, its rows.
    fn segment(&mut self) -> Result<Option<Segment>, ReadError> {
        while self
            .lines
            .next_if(|(_, line)| line.trim().is_empty())
            .is_some()
        {}
        if self.lines.peek().is_none() {
            return Ok(None);
        }
        let mut header = Vec::new();
        let mut ended = false;
        for (_, line) in self.lines.by_ref() {
            if line.starts_with(END) {
                ended = true;
                break;
            }
            header.push(line);
        }
        let names = self.lines.next();
        let (true, Some((_, names))) = (ended, names) else {
            return Err(self.wrong(
                "the header of a segment, ***End_of_Header***, and a row of names",
                "the end of the file".into(),
                "the file was cut short: copy or export it again",
            ));
        };
        let mut fields = self.fields(&header, names)?;
        let mut rows = 0;
        while let Some((at, line)) = self.lines.next_if(|(_, line)| !line.trim().is_empty()) {
            self.row(at + 1, line, &mut fields)?;
            rows += 1;
        }
        Ok(Some(Segment {
            fields,
            rows,
            joined: false,
            gaps: Vec::new(),
        }))
    }

    fn fields(&self, header: &[&str], names: &str) -> Result<Vec<Field>, ReadError> {
        let entries = |key: &str| -> Vec<String> {
            let line = header.iter().find(|line| {
                line.strip_prefix(key)
                    .is_some_and(|rest| rest.is_empty() || rest.starts_with(self.separator))
            });
            line.map_or_else(Vec::new, |line| {
                let cells = line.split(self.separator);
                cells.map(|cell| cell.trim().to_owned()).collect()
            })
        };
        let dimension = entries("X_Dimension");
        if let Some(other) = dimension
            .iter()
            .skip(1)
            .find(|what| !what.is_empty() && *what != "Time")
        {
            return Err(self.wrong(
                "signals over time",
                format!("an X_Dimension of `{other}`"),
                "export the time signals",
            ));
        }
        let (units, starts) = (entries("Y_Unit_Label"), entries("X0"));
        let (steps, promises) = (entries("Delta_X"), entries("Samples"));
        let (dates, clocks) = (entries("Date"), entries("Time"));
        let cell = |row: &[String], at: usize| row.get(at).cloned().unwrap_or_default();
        let mut fields: Vec<Field> = names
            .split(self.separator)
            .enumerate()
            .map(|(at, name)| {
                let name = name.trim();
                let role = match name {
                    "X_Value" => Role::Time,
                    "Comment" => Role::Comment,
                    _ => Role::Channel,
                };
                // The entries of a header stand above the columns they hold for.
                let step = cell(&steps, at);
                let day = cell(&clocks, at);
                Field {
                    role,
                    name: name.to_owned(),
                    unit: unit(&cell(&units, at)),
                    start: self.number(&cell(&starts, at)),
                    step: self.number(&step).map(|value| (value, step)),
                    promised: cell(&promises, at).parse().ok(),
                    clock: (!day.is_empty()).then(|| format!("{} {day}", cell(&dates, at))),
                    values: Vec::new(),
                    empty: None,
                }
            })
            .collect();
        // A trailing separator makes an empty last column.
        while fields
            .last()
            .is_some_and(|field| field.role == Role::Channel && field.name.is_empty())
        {
            fields.pop();
        }
        if !fields.iter().any(|field| field.role == Role::Channel) {
            return Err(self.wrong(
                "the names of channels below the header",
                format!(
                    "`{}`",
                    names.chars().take(40).collect::<String>().escape_debug()
                ),
                "check the export",
            ));
        }
        Ok(fields)
    }

    fn row(&mut self, at: usize, line: &str, fields: &mut [Field]) -> Result<(), ReadError> {
        let mut cells = line.split(self.separator);
        for field in fields.iter_mut() {
            let cell = cells.next();
            match (field.role, cell.map(str::trim)) {
                (Role::Comment, Some(cell)) => {
                    // A comment may hold the separator.
                    let rest: Vec<&str> = cells.by_ref().collect();
                    let comment = [&[cell][..], &rest].concat().join(" ");
                    if !comment.trim().is_empty() {
                        self.comments.push((at, comment.trim().to_owned()));
                    }
                }
                (Role::Comment, None) => {}
                (_, Some("") | None) => {
                    field.empty.get_or_insert(at);
                }
                (_, Some(cell)) => match self.number(cell) {
                    Some(value) if field.empty.is_none() => field.values.push(value),
                    Some(_) => {
                        return Err(self.wrong(
                            "a number in every row of a channel",
                            format!(
                                "an empty cell in row {}, column `{}`",
                                field.empty.unwrap_or(at),
                                field.name
                            ),
                            "repair or cut that row",
                        ));
                    }
                    None => {
                        return Err(self.wrong(
                            "a number",
                            format!(
                                "`{}` in row {at}, column `{}`",
                                cell.escape_debug(),
                                field.name
                            ),
                            "repair or cut that row",
                        ));
                    }
                },
            }
        }
        match cells.find(|cell| !cell.trim().is_empty()) {
            None => Ok(()),
            Some(extra) => Err(self.wrong(
                &format!(
                    "{} columns in every row, as in the row of names",
                    fields.len()
                ),
                format!("one more, `{}`, in row {at}", extra.escape_debug()),
                "check the column separator and the decimal sign",
            )),
        }
    }
}

/// The symbol of a unit: LabVIEW writes the names of units as often as their symbols.
pub(crate) fn unit(label: &str) -> String {
    let symbol = match label.to_ascii_lowercase().as_str() {
        "newtons" | "newton" => "N",
        "volts" | "volt" => "V",
        "pascals" | "pascal" => "Pa",
        "meters" | "metres" | "meter" | "metre" => "m",
        "seconds" | "second" => "s",
        "m/s^2" | "m/sec^2" => "m/s2",
        "gs" | "g's" => "g",
        _ => label,
    };
    symbol.to_owned()
}

/// One segment of all, where each goes on where the one before ends.
fn join(
    path: &Path,
    segments: Vec<Segment>,
    warnings: &mut Vec<Warning>,
) -> Result<Segment, ReadError> {
    let mut segments = segments.into_iter().enumerate();
    let Some((_, mut whole)) = segments.next() else {
        return Err(ReadError::content(
            path,
            "a segment with rows of numbers",
            "none",
            "check the export",
        ));
    };
    promises(&whole, warnings);
    for (k, mut next) in segments {
        promises(&next, warnings);
        let differs = |found: String| {
            ReadError::content(
                path,
                "consecutive segments of the same channels without a gap",
                format!("{found} in segment {}", k + 1),
                "save every segment in a separate file",
            )
        };
        if next.fields.len() != whole.fields.len() {
            return Err(differs(format!("{} columns", next.fields.len())));
        }
        let gap = gap(&whole, &next);
        for (field, more) in whole.fields.iter_mut().zip(&mut next.fields) {
            if field.name != more.name || field.unit != more.unit {
                return Err(differs(format!("`{}` for `{}`", more.name, field.name)));
            }
            field.values.append(&mut more.values);
            field.empty = field.empty.or(more.empty);
        }
        match gap {
            Some(samples) if samples.abs() <= 0.5 => {}
            Some(samples) if samples > 0.0 && samples <= LONGEST_PAUSE => {
                whole.gaps.push((whole.rows, samples.round() as usize));
            }
            Some(samples) => return Err(differs(format!("a gap of {samples:.1} samples"))),
            None => return Err(differs("no start".into())),
        }
        whole.rows += next.rows;
        whole.joined = true;
    }
    Ok(whole)
}

/// How many samples are missing between two segments, by their time columns, or by their clocks and X0.
fn gap(whole: &Segment, next: &Segment) -> Option<f64> {
    let timed = |segment: &Segment| {
        let field = segment
            .fields
            .iter()
            .find(|field| field.role == Role::Time)?;
        Some((*field.values.first()?, *field.values.last()?))
    };
    let first = whole
        .fields
        .iter()
        .find(|field| field.role == Role::Channel)?;
    let other = next
        .fields
        .iter()
        .find(|field| field.role == Role::Channel)?;
    let step = first
        .step
        .as_ref()
        .map(|(step, _)| *step)
        .filter(|step| *step > 0.0)?;
    if let (Some((_, last)), Some((start, _))) = (timed(whole), timed(next)) {
        return Some((start - last) / step - 1.0);
    }
    let clock = |field: &Field| -> Option<(String, f64)> {
        let (day, time) = field.clock.as_ref()?.split_once(' ')?;
        let mut seconds = 0.0;
        for part in time.split(':') {
            seconds = 60.0 * seconds + part.replace(',', ".").parse::<f64>().ok()?;
        }
        Some((day.to_owned(), seconds))
    };
    let later = match (clock(first), clock(other)) {
        (Some((day, from)), Some((same, to))) if day == same => to - from,
        (None, None) => 0.0,
        _ => return None,
    };
    let missing: usize = whole.gaps.iter().map(|(_, count)| count).sum();
    let ends = first.start? + (whole.rows + missing) as f64 * step;
    Some((other.start? + later - ends) / step)
}

/// What is to be said where more or fewer rows follow than a header promises.
fn promises(segment: &Segment, warnings: &mut Vec<Warning>) {
    let promised = segment
        .fields
        .iter()
        .filter(|field| field.role == Role::Channel)
        .find_map(|field| field.promised.filter(|count| *count > 0));
    let rows = segment.rows as u64;
    match promised {
        Some(promised) if promised < rows => warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the header states {promised} samples and {rows} follow: all were read as one continuous signal, although \
                 there may be a gap after every {promised}"
            ),
        })),
        Some(promised) if promised > rows => warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the header states {promised} samples and {rows} follow: the file is truncated, the available samples were read"
            ),
        })),
        _ => {}
    }
}

fn assemble(
    path: &Path,
    segment: Segment,
    comments: &[(usize, String)],
    mut warnings: Vec<Warning>,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let started_at = start_of(&segment);
    let (several, gaps) = (segment.joined, segment.gaps);
    let rows = segment.rows;
    let (groups, empty) = grouped(segment.fields);
    let one_clock = match (several, options.rate) {
        (true, _) => Some("channels of one rate in all segments"),
        (false, Some(_)) => Some("channels of one rate, because one rate is given"),
        (false, None) => None,
    };
    check_lengths(path, &groups, rows, one_clock)?;
    if !empty.is_empty() {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "channels without a number were left out: {}",
                empty[..empty.len().min(6)].join(", ")
            ),
        }));
    }
    if let Some((row, text)) = comments.first() {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "{} row(s) carry a comment, the first in row {row} `{}`: they are not kept",
                comments.len(),
                text.chars().take(40).collect::<String>()
            ),
        }));
    }
    let mut of_rate = Vec::new();
    let (mut columns, mut bases) = (Vec::new(), Vec::new());
    let first_clock = groups[0].began.clone();
    for group in groups {
        let start_s = group.start_s(first_clock.as_ref());
        let found = match (&group.time, group.step) {
            (Some(time), _) if time.values.len() > 1 => Some(base_of(path, time, &mut of_rate)),
            (_, Some((step, written))) if step > 0.0 => {
                of_rate.extend(coarse(step, &written));
                let rate = rate_of_step(path, step);
                Some(rate.map(|rate| TimeBase::with_gaps(rate, gaps.clone(), rows)))
            }
            _ => None,
        };
        let base = choose_base(path, options, found, &mut of_rate)?;
        let number = bases.len();
        bases.push((base, Seconds(start_s)));
        columns.extend(group.columns.into_iter().map(|column| (column, number)));
    }
    of_rate.append(&mut warnings);
    let mut recording = recording_of_bases(
        path,
        columns,
        &bases,
        of_rate,
        options,
        WithoutUnit::OnlyScale { counts: &[] },
    )?;
    let begins_first = recording.clocks()[0].start_s.0 <= 0.0;
    let started_at = started_at.map(|at| at.later(start_of_part(&bases)));
    recording.annotations.started_at = started_at.filter(|_| begins_first);
    Ok(recording)
}

/// The fields by the clock that they share, and the names of those without a number.
fn grouped(fields: Vec<Field>) -> (Vec<Group>, Vec<String>) {
    let mut empty = Vec::new();
    let mut groups = Vec::<Group>::new();
    let mut time = None::<Column>;
    for field in fields {
        match field.role {
            Role::Comment => {}
            Role::Time if field.values.is_empty() => {}
            Role::Time => {
                time = Some(Column {
                    name: field.name,
                    unit: Some("s".into()),
                    values: field.values,
                });
            }
            Role::Channel if field.values.is_empty() => empty.push(field.name),
            Role::Channel => {
                let known = groups
                    .iter_mut()
                    .find(|group| group.holds(&field, time.as_ref()));
                let (column, head) = field.split();
                match known {
                    Some(group) => {
                        group.step = group.step.take().or(head.step);
                        group.columns.push(column);
                    }
                    None => groups.push(Group {
                        time: time.clone(),
                        columns: vec![column],
                        ..head
                    }),
                }
            }
        }
    }
    (groups, empty)
}

/// Channels of one clock have as many numbers as each other, and those of all segments one clock.
fn check_lengths(
    path: &Path,
    groups: &[Group],
    rows: usize,
    one_clock: Option<&str>,
) -> Result<(), ReadError> {
    let Some(first) = groups.first() else {
        return Err(ReadError::content(
            path,
            "rows of numbers below the names of the channels",
            "none",
            "check the export",
        ));
    };
    if let Some(one_clock) = one_clock.filter(|_| groups.len() > 1) {
        return Err(ReadError::content(
            path,
            one_clock,
            format!("channels on {} sampling clocks", groups.len()),
            "save channels of different rates in separate files",
        ));
    }
    let longest = groups.iter().flat_map(|group| &group.columns);
    let longest = longest.map(|column| column.values.len()).max();
    for group in groups {
        let expected = match groups.len() {
            1 => rows,
            _ => group.columns[0].values.len(),
        };
        let short = group
            .columns
            .iter()
            .find(|column| column.values.len() != expected);
        if let Some(short) = short.or((longest != Some(rows)).then_some(&first.columns[0])) {
            return Err(ReadError::content(
                path,
                format!("{expected} numbers in every channel on one sampling clock"),
                format!("{} of `{}`", short.values.len(), short.name),
                "the file was cut short or the channels differ in length: remove the incomplete rows, or save the channels in \
                 separate files",
            ));
        }
    }
    Ok(())
}

/// The channels that share a clock.
struct Group {
    time: Option<Column>,
    step: Option<(f64, String)>,
    /// When its segment began, by the clock of the computer.
    began: Option<StartTime>,
    /// Where its first sample lies from there, s.
    start: Option<f64>,
    columns: Vec<Column>,
}

impl Group {
    /// Whether a channel behind this column of times belongs to it.
    fn holds(&self, field: &Field, time: Option<&Column>) -> bool {
        let steps = match (&self.step, &field.step) {
            (Some((own, _)), Some((other, _))) => own == other,
            _ => true,
        };
        let times = match (&self.time, time) {
            (Some(own), Some(other)) => own.values == other.values,
            (own, other) => own.is_none() == other.is_none(),
        };
        let starts = match (self.start, field.start) {
            (Some(own), Some(other)) => own == other,
            _ => true,
        };
        let half_a_step = self.step.as_ref().map_or(0.0, |(step, _)| 0.5 * step.abs());
        let began = match (&self.began, &field.began()) {
            (Some(own), Some(other)) => own.seconds_since(other).0.abs() <= half_a_step,
            _ => true,
        };
        steps && times && starts && began
    }

    /// The time of its first sample, s, from the moment at which the first group's segment began.
    fn start_s(&self, first: Option<&StartTime>) -> f64 {
        let own = self
            .time
            .as_ref()
            .and_then(|time| time.values.first().copied());
        let later = match (&self.began, first) {
            (Some(own), Some(first)) => own.seconds_since(first).0,
            _ => 0.0,
        };
        own.or(self.start).unwrap_or(0.0) + later
    }
}

impl Field {
    /// The time at which the header says that its segment began.
    fn began(&self) -> Option<StartTime> {
        let (day, time) = self.clock.as_ref()?.split_once(' ')?;
        let at = format!("{}T{}", day.replace('/', "-"), time.replace(',', "."));
        StartTime::try_from(at).ok()
    }

    /// Its samples, and what its header says of their times.
    fn split(self) -> (Column, Group) {
        let head = Group {
            time: None,
            began: self.began(),
            step: self.step,
            start: self.start,
            columns: Vec::new(),
        };
        let column = Column {
            name: self.name,
            unit: Some(self.unit),
            values: self.values,
        };
        (column, head)
    }
}

/// When the first sample was taken, X0 after the time of the header, by the clock of the computer, whose zone the file does not say.
fn start_of(segment: &Segment) -> Option<StartTime> {
    let mut fields = segment.fields.iter();
    let first = fields.find(|field| field.role == Role::Channel)?;
    let start_s = first.start.filter(|start| (0.0..1e9).contains(start));
    Some(first.began()?.later(Seconds(start_s.unwrap_or(0.0))))
}

/// A step written with so few digits that the rate is not known to 10⁻⁴, unless it makes a whole number of Hz.
fn coarse(step: f64, written: &str) -> Option<Warning> {
    let (mantissa, exponent) = written.split_once(['E', 'e']).unwrap_or((written, "0"));
    let decimals = mantissa
        .split_once(['.', ','])
        .map_or(0, |(_, decimals)| decimals.len());
    let place = exponent.parse::<f64>().ok()? - decimals as f64;
    let share = 0.5 * 10_f64.powf(place) / step;
    let rate = 1.0 / step;
    let whole = (rate - rate.round()).abs() < 1e-6 * rate;
    (share > 1e-4 && !whole).then(|| Warning::from(RecordingWarning::Guessed {
        what: format!(
            "Delta_X is written as {written}: the rate of {rate:.2} Hz is only known to {:.2} % (give it with --rate)",
            100.0 * share
        ),
    }))
}
