//! Columns of numbers as the channels of a recording, whatever file holds them.

use std::ops::Range;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::{counted, digits};
use piezotact::quantity::{Measure, SampleRate, Seconds, Unit};
use piezotact::recording::{
    Channel, Clock, Condition, Provenance, Recording, RecordingWarning, StartTime,
};

use piezotact::roles::is_force_name;

use crate::date_time::DAY_S;
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::sidecar::measure_or_unit;
use crate::time_column::{
    TimeBase, base_beside, base_of, choose_base, is_time, most_repeated, named_unit, seconds_of,
    state_unit,
};

/// Units at the end of a name, as Python writes them; a longer ending stands before one that it ends in.
const ENDINGS: [(&str, &str); 12] = [
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
];

/// One column as a file holds it.
#[derive(Clone, Debug)]
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
            units.find_map(|(ending, unit)| Some((cell.strip_suffix(ending)?, *unit)))
        };
        // Only times are in s and ms: a name may end in an s for other reasons.
        let parts = in_brackets.or_else(|| named_unit(cell).or_else(at_its_end));
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
}

/// The columns of a file whose rows were taken together.
#[derive(Default)]
pub(crate) struct Table {
    pub(crate) columns: Vec<Column>,
    /// The number of the column of moments, in s since the first one.
    pub(crate) moments: Option<usize>,
    /// The moment of the first row.
    pub(crate) started_at: Option<StartTime>,
    /// The rate that the file states, and where.
    pub(crate) stated: Option<(String, SampleRate)>,
    pub(crate) warnings: Vec<Warning>,
}

impl Table {
    /// Adds a column of moments, in s since the first one; of several, the first is the time.
    pub(crate) fn add_moments(&mut self, column: Column, start: Option<StartTime>) {
        if self.moments.is_none() {
            self.moments = Some(self.columns.len());
            self.started_at = start.or(self.started_at.take());
            let unit = Some("s".to_owned());
            self.columns.push(Column { unit, ..column });
        }
    }

    /// The recording of the columns, on the grid of their time.
    pub(crate) fn recording(
        mut self,
        path: &Path,
        options: &ReadOptions,
    ) -> Result<Recording, ReadError> {
        let mut options = options.clone();
        // A time in numbers is finer than the moments beside it.
        let is_named = |at: &usize| Some(*at) != self.moments && is_time(&self.columns[*at].name);
        let named = (0..self.columns.len()).find(is_named);
        let others: Vec<Column> = (0..self.columns.len())
            .filter(|at| Some(*at) != named && (Some(*at) == self.moments || is_named(at)))
            .map(|at| self.columns[at].clone())
            .collect();
        let mut time = named.or(self.moments).map(|at| {
            self.warnings
                .extend(without_copied_rows(&mut self.columns, at));
            let time = self.columns[at].clone();
            let mut number = 0..;
            self.columns.retain(|_| {
                number
                    .next()
                    .is_none_or(|k| k != at && Some(k) != self.moments)
            });
            time
        });
        if let Some(time) = &mut time {
            state_unit(path, time, &mut options.units)?;
        }
        let mut of_time = Vec::new();
        let found = match (&time, &self.stated) {
            (Some(time), Some((line, rate))) => {
                Some(Ok(base_beside(path, time, (line, *rate), &mut of_time)))
            }
            (Some(time), None) => Some(base_of(path, time, &mut of_time)),
            (None, Some((line, rate))) => {
                let what = format!("the rate of {rate} is that of the line `{line}`");
                of_time.push(Warning::from(RecordingWarning::Guessed { what }));
                Some(Ok(TimeBase::even(*rate)))
            }
            (None, None) => None,
        };
        if let (Some(time), Some(Ok(base)), None) = (&time, &found, options.rate) {
            let last = time.values.len().saturating_sub(1);
            let lasts_s = base.time_of(last);
            let contradicted = others
                .iter()
                .filter_map(|other| contradicted(time, lasts_s, other));
            of_time.extend(contradicted);
        }
        let base = choose_base(path, &options, found, &mut of_time)?;
        self.warnings.append(&mut of_time);
        let unnamed = WithoutUnit::HeaderCan;
        let mut recording =
            recording_of(path, self.columns, &base, self.warnings, &options, unnamed)?;
        let started_at = self.started_at;
        recording.annotations.started_at = started_at.map(|at| at.later(Seconds(base.offset_s)));
        Ok(recording)
    }
}

/// The warning that another time column says that the rows last longer or shorter than `time` says, by more than 1 % and its own
/// steps.
fn contradicted(time: &Column, lasts_s: f64, other: &Column) -> Option<Warning> {
    let steps = || other.values.windows(2).map(|pair| pair[1] - pair[0]);
    let (first, last) = (other.values.first()?, other.values.last()?);
    if steps().any(|step| step.is_nan() || step < 0.0) || last <= first {
        return None;
    }
    let longest = steps().fold(0.0, f64::max);
    let differs = |unit_s: &f64| {
        ((last - first) * unit_s - lasts_s).abs() > 0.01 * lasts_s + 2.0 * longest * unit_s
    };
    // Without a unit, it has the one that agrees.
    let units = match &other.unit {
        Some(unit) => vec![seconds_of(unit)?],
        None => vec![1.0, 1e-3, 1e-6, 1e-9, DAY_S],
    };
    let stated_s = (last - first) * units.first()?;
    units.iter().all(differs).then(|| {
        Warning::from(RecordingWarning::Guessed {
            what: format!(
                "`{}` lasts {} s and `{}` {} s in the same rows: the first gives the rate",
                time.name,
                digits(lasts_s),
                other.name,
                digits(stated_s)
            ),
        })
    })
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

/// More channels than samples are a table with a channel in each row, from this many on.
const MOST_OF_FEW: usize = 64;

/// The recording of `columns` on the grid of `base`, in SI; `warnings` are those about it.
pub(crate) fn recording_of(
    path: &Path,
    columns: Vec<Column>,
    base: &TimeBase,
    warnings: Vec<Warning>,
    options: &ReadOptions,
    unnamed: WithoutUnit<'_>,
) -> Result<Recording, ReadError> {
    let rows = columns.first().map_or(0, |column| column.values.len());
    if columns.len() > MOST_OF_FEW && columns.len() > rows {
        return Err(ReadError::content(
            path,
            "samples in rows and channels in columns",
            format!("{rows} rows with {} columns", columns.len()),
            "transpose it, if each row is a channel; else record more samples than channels",
        ));
    }
    let columns = columns.into_iter().map(|column| (column, 0)).collect();
    let bases = [(base.clone(), Seconds(0.0))];
    recording_of_bases(path, columns, &bases, warnings, options, unnamed)
}

/// As [`recording_of`], where every column has the number of its grid in `bases`, with the time of its first row.
pub(crate) fn recording_of_bases(
    path: &Path,
    columns: Vec<(Column, usize)>,
    bases: &[(TimeBase, Seconds)],
    mut warnings: Vec<Warning>,
    options: &ReadOptions,
    unnamed: WithoutUnit<'_>,
) -> Result<Recording, ReadError> {
    let mut channels = Vec::with_capacity(columns.len());
    let (mut without_unit, mut by_name, mut scaled) = (Vec::new(), Vec::new(), false);
    let names: Vec<String> = columns
        .iter()
        .map(|(column, _)| column.name.clone())
        .collect();
    let first_s = bases
        .iter()
        .map(|(base, start)| start.0 + base.offset_s)
        .fold(f64::INFINITY, f64::min);
    let mut lost_s = Vec::new();
    let counts = match unnamed {
        WithoutUnit::HeaderCan => &[],
        WithoutUnit::OnlyScale { counts } => counts,
    };
    for (column, number) in columns {
        let (base, start_s) = &bases[number];
        let start_s = Seconds(start_s.0 + base.offset_s);
        let clock = Clock {
            rate_hz: base.rate,
            start_s,
        };
        let own = column
            .unit
            .as_deref()
            .map(str::trim)
            .filter(|unit| !unit.is_empty());
        let stated = options
            .units
            .get(&column.name)
            .map(|text| of_force(&column.name, text).unwrap_or_else(|| measure_or_unit(text)));
        let plain = (Unit::Other(String::new()), 1.0);
        let scale = options.scale.as_ref();
        let (unit, factor) = match (stated, own.map(|text| parsed(&column.name, text)), scale) {
            // What 1 of a potential stands for is the calibration of its sensor.
            (Some(stated), Some(own), _) if is_calibration(options, &column.name, &own.0) => stated,
            (Some(stated), Some(own), _) if stated != own => {
                return Err(unit_differs(path, &column.name, &own.0, &stated.0));
            }
            (Some(known), _, _) | (None, Some(known), _) => known,
            (None, None, Some(scale)) if can_be(&column.name, &scale.unit) => {
                scaled = true;
                (scale.unit.clone(), scale.value)
            }
            (None, None, _) if options.is_drive || counts.contains(&column.name) => {
                without_unit.push(column.name.clone());
                plain
            }
            (None, None, _) if quantity_of(&column.name) == Some(Unit::Newton) => {
                by_name.push(column.name.clone());
                (Unit::Newton, 1.0)
            }
            (None, None, _) => {
                without_unit.push(column.name.clone());
                plain
            }
        };
        let mut samples = column.values;
        base.cut(&mut samples);
        if let Some((code, spans)) = without_codes(&mut samples) {
            let at_s = |row: usize| start_s.0 - first_s + base.time_of(row);
            let lost = spans.iter().map(|span| [at_s(span.start), at_s(span.end)]);
            lost_s.extend(lost);
            let rows: usize = spans.iter().map(ExactSizeIterator::len).sum();
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "`{}` holds {code:e} in {} from {:.3} s on, a code for no data: straight lines are in its place",
                    column.name,
                    counted(rows, "row"),
                    spans.first().map_or(0.0, |span| at_s(span.start))
                ),
            }));
        }
        base.fill(&mut samples);
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
    if let WithoutUnit::OnlyScale { .. } = unnamed {
        let warning = |channel: String| match counts.contains(&channel) {
            true => RecordingWarning::Counts { channel },
            false => RecordingWarning::Uncalibrated { channel },
        };
        let unscaled = without_unit.drain(..).filter(|_| !options.is_drive);
        warnings.extend(unscaled.map(warning).map(Warning::from));
    }
    let mut guessed =
        |what: String| warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    if let [first, others @ ..] = without_unit.as_slice() {
        let others = if others.is_empty() {
            String::new()
        } else {
            format!(" and {} more", others.len())
        };
        guessed(format!(
            "channel `{first}`{others} has no unit and is read as numbers without unit (write `{first} (m/s2)` in the \
             header, or give the value of 1 with --scale)"
        ));
    }
    if let [first, others @ ..] = by_name.as_slice() {
        let (verb, name) = match others {
            [] => ("is", "its name is that of a force"),
            _ => ("are", "their names are those of forces"),
        };
        guessed(format!(
            "`{}` without a unit {verb} read in N, as {name} (another unit: --scale \"{first}=mN\")",
            by_name.join("`, `")
        ));
    }
    if let (Some(scale), false) = (&options.scale, scaled) {
        guessed(format!(
            "the scale {scale} was not used: every channel has a unit, or a name of another quantity"
        ));
    }
    if let Some(other) = options.units.keys().find(|name| !names.contains(name)) {
        guessed(format!(
            "the unit of `{other}` was not used: the channels are `{}`",
            names.join("`, `")
        ));
    }
    let provenance = Provenance {
        source: path.display().to_string(),
        ..Provenance::default()
    };
    let mut recording = Recording::with_clocks(channels, Condition::default(), provenance)
        .map_err(ReadError::of(path))?;
    recording.about.warnings = warnings;
    let losses = &mut recording.about.provenance.losses;
    losses.stretches_s.append(&mut lost_s);
    for (base, start) in bases {
        base.note(&mut recording, start.0 + base.offset_s - first_s);
    }
    Ok(recording)
}

/// How long after the start of the file its part begins that is read.
pub(crate) fn start_of_part(bases: &[(TimeBase, Seconds)]) -> Seconds {
    let first = |of: &dyn Fn(&(TimeBase, Seconds)) -> f64| {
        bases.iter().map(of).fold(f64::INFINITY, f64::min)
    };
    let later = first(&|(base, start)| start.0 + base.offset_s) - first(&|(_, start)| start.0);
    Seconds(if later.is_finite() { later } else { 0.0 })
}

/// Whether a value with a unit is stated of a channel whose `own` unit is that of a sensor's signal: `0.5 N` of one in V.
fn is_calibration(options: &ReadOptions, name: &str, own: &Unit) -> bool {
    let stated = options.units.get(name).map(|text| text.parse::<Measure>());
    let is_other = |measure: Measure| measure.unit != *own;
    let is_signal = matches!(own, Unit::Volt | Unit::FullScale | Unit::Other(_));
    is_signal && stated.is_some_and(|stated| stated.is_ok_and(is_other))
}

fn unit_differs(path: &Path, name: &str, own: &Unit, stated: &Unit) -> ReadError {
    ReadError::content(
        path,
        format!("the unit of `{name}` as the file states it, {own}"),
        stated.symbol(),
        match own {
            Unit::Volt => format!(
                "correct the one that is wrong, or state what 1 in the file stands for: --scale \"{name}=0.5 {stated}\""
            ),
            _ => "correct the one that is wrong".into(),
        },
    )
}

/// The unit of a channel, and the factor to SI.
fn parsed(name: &str, text: &str) -> (Unit, f64) {
    of_force(name, text).unwrap_or_else(|| Unit::parse(text))
}

/// What scales state of a channel that is called as a force: a gram there is the weight of one, and no acceleration.
fn of_force(name: &str, text: &str) -> Option<(Unit, f64)> {
    if quantity_of(name) != Some(Unit::Newton) {
        return None;
    }
    let newtons = match text.trim() {
        "g" | "gf" => 9.806_65e-3,
        "kg" | "kgf" => 9.806_65,
        "cN" => 1e-2,
        _ => return None,
    };
    Some((Unit::Newton, newtons))
}

/// The unit of what a channel's name says that it is; a torque has none of those that a scale has.
fn quantity_of(name: &str) -> Option<Unit> {
    let plain: String = name
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric())
        .collect();
    let is_torque = plain.contains("torque") || plain.contains("moment");
    match plain.as_str() {
        _ if is_force_name(name) => Some(Unit::Newton),
        "tx" | "ty" | "tz" | "mx" | "my" | "mz" => Some(Unit::Other("Nm".into())),
        _ if is_torque => Some(Unit::Other("Nm".into())),
        _ if plain.starts_with("acc") => Some(Unit::MetrePerSecondSquared),
        _ if plain.starts_with("gyro") => Some(Unit::RadianPerSecond),
        _ => None,
    }
}

/// Whether a channel of this name can be in `unit`: a sensor's potential or digital samples always.
fn can_be(name: &str, unit: &Unit) -> bool {
    matches!(unit, Unit::Volt | Unit::FullScale) || quantity_of(name).is_none_or(|own| own == *unit)
}

/// What devices write in place of a value that they do not have: ±1e6 and further powers of ten, 9.9e37, the largest number of
/// single precision.
pub(crate) fn is_code(value: f64) -> bool {
    let size = value.abs();
    let power = size.log10();
    size >= 1e6 && ((power - power.round()).abs() < 1e-9 || (9.8e37..1e39).contains(&size))
}

/// Puts straight lines in the place of a code for no data, which no other value of the channel comes near: the code, and its rows.
fn without_codes(samples: &mut [f64]) -> Option<(f64, Vec<Range<usize>>)> {
    let code = samples.iter().copied().find(|value| is_code(*value))?;
    let others = samples.iter().filter(|value| **value != code);
    let (count, largest) = others.fold((0, 0.0_f64), |(count, most), value| {
        (count + 1, most.max(value.abs()))
    });
    if 2 * count < samples.len() || 1e3 * largest > code.abs() {
        return None;
    }
    let mut spans = Vec::<Range<usize>>::new();
    for row in (0..samples.len()).filter(|row| samples[*row] == code) {
        match spans.last_mut().filter(|span| span.end == row) {
            Some(span) => span.end += 1,
            None => spans.push(row..row + 1),
        }
    }
    for span in &spans {
        let before = span.start.checked_sub(1).map(|row| samples[row]);
        let after = samples.get(span.end).copied();
        let (Some(from), Some(to)) = (before.or(after), after.or(before)) else {
            continue;
        };
        let steps = (span.len() + 1) as f64;
        for (k, sample) in samples[span.clone()].iter_mut().enumerate() {
            *sample = from + (to - from) * (k + 1) as f64 / steps;
        }
    }
    Some((code, spans))
}
