//! The channels and the times among the variables of a MATLAB file, with the names and units that texts beside them state.

use std::collections::HashMap;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::recording::RecordingWarning;
use piezotact::statistics::median;

use super::convert::shape;
use super::units::{Stated, texts_of};
use super::{MatNumbers, MatValue};
use crate::columns::Column;
use crate::error::ReadError;
use crate::stated_rate::{UNIT_WORDS, hz_of, may_be_scale, one_of, states_rate, without_word};
use crate::time_column;

/// Names of vectors of time, in small letters.
pub(super) const TIMES: [&str; 7] = [
    "t",
    "time",
    "time_s",
    "timestamp",
    "zeit",
    "temps",
    "time_domain",
];
/// Words that make the name of a channel that of its time: `Data1_time_acc` is the time of `Data1_acc`.
const TIME_WORDS: [&str; 4] = ["time", "timestamp", "zeit", "temps"];
/// Names of lists of channels.
pub(super) const NAMES: [&str; 6] = [
    "names",
    "name",
    "channels",
    "channel_names",
    "labels",
    "label",
];
/// Names that say nothing of a channel in a structure.
const PLAIN: [&str; 7] = ["data", "values", "value", "signal", "samples", "y", "x"];
/// Up to this relative difference, a rate found from times differs from the stated one by the rounding of the times.
pub(super) const ROUNDED_TIMES: f64 = 1e-3;
/// The steps of a first column that is the time differ by less than this share.
const EVEN_STEPS: f64 = 0.02;
/// More channels than this are no recording.
const MOST_SIGNALS: usize = 4096;
/// More columns than this make a matrix that is no recording.
const MOST_CHANNELS: usize = 512;

/// A variable and where it stands.
pub(super) struct Named<'m> {
    /// As MATLAB writes it: `run(2).acc`.
    pub(super) name: String,
    /// What it shares with its companions: `run(2)`; `{2}` of `acc{2}`.
    pub(super) scope: String,
    /// The last part in small letters: `acc`.
    pub(super) last: String,
    pub(super) value: &'m MatValue,
}

impl<'m> Named<'m> {
    pub(super) fn new(name: &str, value: &'m MatValue) -> Self {
        let number = name.ends_with(['}', ')']).then(|| name.rfind(['{', '(']));
        let (base, number) = name.split_at(number.flatten().unwrap_or(name.len()));
        let (scope, last) = base.rsplit_once('.').unwrap_or(("", base));
        Self {
            name: name.to_owned(),
            scope: format!("{scope}{number}"),
            last: last.to_ascii_lowercase(),
            value,
        }
    }

    pub(super) fn is(&self, names: &[&str]) -> bool {
        names.contains(&self.last.as_str())
    }

    fn vector(&self) -> Option<&'m [f64]> {
        self.value.vector().filter(|values| values.len() > 1)
    }
}

/// The variables of a file, and those of each place.
pub(super) struct Variables<'m> {
    pub(super) all: Vec<Named<'m>>,
    by_scope: HashMap<String, Vec<usize>>,
    /// What a structure `units` says of its neighbours, by its place and their names in small letters.
    in_structures: HashMap<(String, String), String>,
    /// Whether a person states the rate: what the file states of it does not count.
    is_rate_given: bool,
}

impl<'m> Variables<'m> {
    pub(super) fn new(all: Vec<Named<'m>>, stated: Option<SampleRate>) -> Self {
        let mut by_scope = HashMap::<String, Vec<usize>>::new();
        let mut in_structures = HashMap::new();
        for (at, variable) in all.iter().enumerate() {
            by_scope.entry(variable.scope.clone()).or_default().push(at);
            let (place, called) = variable
                .scope
                .rsplit_once('.')
                .unwrap_or(("", &variable.scope));
            let unit = variable.value.text().map(str::trim);
            if let (true, Some(unit)) = (UNIT_WORDS.contains(&&*called.to_ascii_lowercase()), unit)
            {
                let of = (place.to_owned(), variable.last.clone());
                in_structures.insert(of, unit.to_owned());
            }
        }
        Self {
            all,
            by_scope,
            in_structures,
            is_rate_given: stated.is_some(),
        }
    }

    pub(super) fn at(&self, scope: &str) -> impl Iterator<Item = usize> {
        self.by_scope.get(scope).into_iter().flatten().copied()
    }

    /// Those of one place.
    pub(super) fn here(&self, scope: &str) -> impl Iterator<Item = &Named<'m>> {
        self.at(scope).map(|at| &self.all[at])
    }

    /// The unit that a structure of units states of what is called `name` (in small letters) in a place: `units.ft` of `ft`.
    pub(super) fn unit_in_structure(&self, scope: &str, name: &str) -> Option<String> {
        outwards(scope)
            .find_map(|place| {
                let of = (place.to_owned(), name.to_owned());
                self.in_structures.get(&of).filter(|unit| !unit.is_empty())
            })
            .cloned()
    }

    /// The unit that a text beside a variable states of it alone: `fs_unit`, `t_unit`, `units.t`; `wf_xunit_string` of a step.
    fn unit_of(&self, variable: &Named<'m>) -> Option<String> {
        let is_step = ["wf_increment", "increment"].contains(&variable.last.as_str());
        let is_its = |text: &Named<'_>| {
            without_word(&text.last, &UNIT_WORDS).as_ref() == Some(&variable.last)
                || is_step && text.last == "wf_xunit_string"
        };
        let texts = self.texts(&variable.scope);
        let mut texts = texts.into_iter();
        (texts.find_map(|(text, unit)| is_its(text).then(|| unit.to_owned())))
            .or_else(|| self.unit_in_structure(&variable.scope, &variable.last))
    }

    /// The rates that one place states, in Hz.
    pub(super) fn rates(&self, path: &Path, scope: &str) -> Result<Vec<(String, f64)>, ReadError> {
        let all = self.here(scope).filter(|one| states_rate(&one.last));
        all.filter_map(|one| Some((one, one.value.scalar()?)))
            .map(|(one, value)| {
                let hz = hz_of(path, &one.last, value, self.unit_of(one).as_deref())?;
                Ok((one.name.clone(), hz))
            })
            .collect()
    }

    /// The texts of one place.
    fn texts(&self, scope: &str) -> Vec<(&Named<'m>, &'m str)> {
        self.here(scope)
            .filter_map(|text| Some((text, text.value.text()?.trim())))
            .filter(|(_, text)| !text.is_empty())
            .collect()
    }
}

/// A place and those around it, up to that of the variables themselves.
pub(super) fn outwards(scope: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(scope), |inner| {
        let end = match inner.ends_with('}') {
            true => inner.rfind('{'),
            false => inner.rfind('.'),
        };
        (!inner.is_empty()).then(|| &inner[..end.unwrap_or(0)])
    })
}

/// Of an element or a cell, its place without numbers: equal for the runs of one array.
pub(super) fn run_of(scope: &str) -> Option<String> {
    let mut open = 0;
    let keep = |letter: &char| {
        open += usize::from(matches!(letter, '{' | '('));
        let kept = open == 0;
        open -= usize::from(matches!(letter, '}' | ')') && open > 0);
        kept
    };
    let without: String = scope.chars().filter(keep).collect();
    (without != scope).then_some(without)
}

/// A channel that was found.
pub(super) struct Signal {
    /// The place of its variable in the list of variables.
    pub(super) at: usize,
    pub(super) column: Column,
    /// Its time, where it has one of its own.
    pub(super) own_time: Option<usize>,
}

/// What stands for time: its place, and the number of its column.
#[derive(Default)]
pub(super) struct Times {
    /// Place, number of the variable and number of the column.
    places: Vec<(String, usize, usize)>,
    pub(super) columns: Vec<Column>,
}

impl Times {
    /// The number of this time; equal ones are one.
    fn add(&mut self, name: &str, unit: Option<String>, values: &[f64]) -> usize {
        let is_it = |time: &Column| time.values == values && time.unit == unit;
        let known = self.columns.iter().position(is_it);
        known.unwrap_or_else(|| {
            self.columns.push(Column {
                name: name.to_owned(),
                unit,
                values: values.to_vec(),
            });
            self.columns.len() - 1
        })
    }

    /// The times of one place: the number of the variable, and that of the column.
    pub(super) fn here(&self, scope: &str) -> impl Iterator<Item = (usize, usize)> {
        let here = self.places.iter().filter(move |(of, ..)| of == scope);
        here.map(|(_, at, time)| (*at, *time))
    }

    /// The time of `length` that is nearest to `scope`. `Err` where there are others alone: how far out the nearest stands, and its
    /// length.
    pub(super) fn nearest(
        &self,
        scope: &str,
        length: usize,
    ) -> Result<Option<usize>, (usize, usize)> {
        let mut other = None;
        for (far, place) in outwards(scope).enumerate() {
            for (_, time) in self.here(place) {
                let found = self.columns[time].values.len();
                if found == length {
                    return Ok(Some(time));
                }
                other = other.or(Some((far, found)));
            }
        }
        other.map_or(Ok(None), Err)
    }
}

/// The channels and times of a file, and what was left out of them.
#[derive(Default)]
pub(super) struct Found {
    pub(super) signals: Vec<Signal>,
    pub(super) times: Times,
    /// Arrays of numbers that make no channels, each with its shape.
    pub(super) no_channels: Vec<String>,
    /// Numbers that may be the scale of a channel.
    pub(super) scales: Vec<String>,
    pub(super) warnings: Vec<Warning>,
}

impl Found {
    pub(super) fn guess(&mut self, what: String) {
        self.warnings
            .push(Warning::from(RecordingWarning::Guessed { what }));
    }

    pub(super) fn of(path: &Path, variables: &Variables<'_>) -> Result<Self, ReadError> {
        let mut found = Self::default();
        let mut own_times = vec![None; variables.all.len()];
        let mut is_time = vec![false; variables.all.len()];
        for (at, variable) in variables.all.iter().enumerate() {
            let Some(values) = variable.vector() else {
                continue;
            };
            let of = without_word(&variable.last, &TIME_WORDS);
            let fits = |other: &Named<'_>| {
                Some(&other.last) == of.as_ref()
                    && other.vector().is_some_and(|of| of.len() == values.len())
            };
            // `time_ms`: the unit may stand at its end.
            let header = Column::from_header(&variable.last);
            let unit = || variables.unit_of(variable);
            let is_called = |name: &str| TIMES.contains(&name) || time_column::is_time(name);
            if is_called(&variable.last) || is_called(&header.name) {
                let unit = unit().or(header.unit);
                let time = found.times.add(&variable.name, unit, values);
                found.times.places.push((variable.scope.clone(), at, time));
                is_time[at] = true;
            } else if of.is_some()
                && let Some(other) =
                    (variables.at(&variable.scope)).find(|at| fits(&variables.all[*at]))
            {
                own_times[other] = Some(found.times.add(&variable.name, unit(), values));
                is_time[at] = true;
            }
        }
        for (at, variable) in variables.all.iter().enumerate() {
            if let (MatValue::Numbers(numbers), false) = (variable.value, is_time[at]) {
                found.add(path, variables, at, numbers, own_times[at])?;
            }
        }
        found.name_and_scale(variables);
        Ok(found)
    }

    fn add(
        &mut self,
        path: &Path,
        variables: &Variables<'_>,
        at: usize,
        numbers: &MatNumbers,
        own_time: Option<usize>,
    ) -> Result<(), ReadError> {
        let variable = &variables.all[at];
        if let Some(value) = variable.value.scalar()
            && may_be_scale(&variable.last)
        {
            self.scales.push(format!("`{}` ({value})", variable.name));
        }
        if numbers.real.len() < 2 {
            return Ok(());
        }
        let mut columns = columns_of(&variable.name, numbers);
        if columns.is_empty() {
            let shape = shape(variable.value);
            self.no_channels
                .push(format!("{} ({shape})", variable.name));
            return Ok(());
        }
        if !numbers.exact {
            self.guess(format!(
                "`{}` holds integers beyond ±2⁵³, which were rounded",
                variable.name
            ));
        }
        let count = columns.len();
        let list = |words: &[&str]| list_of(variables, &variable.scope, words, count);
        let (names, units) = (list(&NAMES), list(&UNIT_WORDS));
        if count > 1 {
            for (column, name) in columns.iter_mut().zip(names.iter().flatten()) {
                column.name.clone_from(name);
            }
            for (column, unit) in columns.iter_mut().zip(units.iter().flatten()) {
                column.unit = Some(unit.clone());
            }
        }
        let length = columns[0].values.len();
        let no_time = own_time.is_none() && self.times.nearest(&variable.scope, length) == Ok(None);
        let mut own_time = own_time;
        if count > 1 && no_time {
            let rate = nearest_rate(path, variables, &variable.scope)?;
            let first = &columns[0];
            let called = TIMES.contains(&first.name.to_ascii_lowercase().as_str());
            if called || is_even_time(&first.values, rate.map(|stated| stated.rate.hz())) {
                if !called {
                    self.guess(format!(
                        "the first of the {count} columns of `{}` increases in even steps and is read as their time",
                        variable.name
                    ));
                }
                let first = columns.remove(0);
                own_time = Some(self.times.add(&first.name, first.unit, &first.values));
            }
        }
        if self.signals.len() + columns.len() > MOST_SIGNALS {
            return Err(ReadError::content(
                path,
                format!("at most {MOST_SIGNALS} channels"),
                "more",
                "save the channels that you need in a separate file",
            ));
        }
        self.signals
            .extend(columns.into_iter().map(|column| Signal {
                at,
                column,
                own_time,
            }));
        Ok(())
    }

    /// Names and units that texts beside the channels state.
    fn name_and_scale(&mut self, variables: &Variables<'_>) {
        // How many variables and how many channels of them each place has; those of one variable follow each other.
        let mut signals_here = HashMap::<&str, [usize; 2]>::new();
        let mut last = None;
        for signal in &self.signals {
            let scope = variables.all[signal.at].scope.as_str();
            let [arrays, channels] = signals_here.entry(scope).or_default();
            *arrays += usize::from(last.replace(signal.at) != Some(signal.at));
            *channels += 1;
        }
        // Tables of channels: a structure with a name and a unit, and no numbers.
        let mut table = HashMap::new();
        for name in variables.all.iter().filter(|name| name.is(&["name"])) {
            let here = variables.texts(&name.scope);
            let unit = here.iter().find(|(text, _)| text.is(&UNIT_WORDS));
            let no_numbers = !signals_here.contains_key(name.scope.as_str());
            if let (Some((_, unit)), Some(name), true) = (unit, name.value.text(), no_numbers) {
                table.insert(name.trim().to_ascii_lowercase(), (*unit).to_owned());
            }
        }
        let stated = Stated::of(self, variables);
        let (mut renamed, mut unused) = (Vec::new(), stated.said);
        for (number, signal) in self.signals.iter().enumerate() {
            let variable = &variables.all[signal.at];
            let here = variables.texts(&variable.scope);
            let [arrays, channels] = signals_here[variable.scope.as_str()];
            let alone = channels == 1;
            let own = here.iter().find(|(text, _)| {
                without_word(&text.last, &UNIT_WORDS).is_some_and(|of| of == variable.last)
            });
            let any = here.iter().find(|(text, _)| text.is(&UNIT_WORDS));
            let only = any.filter(|_| arrays == 1);
            let ends = variable.last.match_indices('_').map(|(at, _)| at + 1);
            let entry = std::iter::once(0)
                .chain(ends)
                .find_map(|from| table.get(&variable.last[from..]));
            let own = own.map(|(_, unit)| (*unit).to_owned());
            let unit = own
                .or_else(|| stated.units.get(&number).cloned())
                .or_else(|| only.map(|(_, unit)| (*unit).to_owned()))
                .or_else(|| entry.cloned());
            if let (Some((text, of)), None, None) = (any, &unit, &signal.column.unit) {
                let what = format!(
                    "`{}` states {of} for {arrays} variables and was not used",
                    text.name
                );
                if !unused.contains(&what) {
                    unused.push(what);
                }
            }
            let stated = here.iter().find(|(text, _)| alone && text.is(&NAMES));
            let name = match stated {
                Some((_, name)) if !variable.scope.is_empty() => Some((*name).to_owned()),
                _ if alone && variable.is(&PLAIN) && !variable.scope.starts_with('{') => {
                    Some(variable.scope.clone()).filter(|scope| !scope.is_empty())
                }
                _ => None,
            };
            renamed.push((number, name, unit));
        }
        for (number, name, unit) in renamed {
            let taken = |name: &String| self.signals.iter().any(|s| s.column.name == *name);
            let name = name.filter(|name| !taken(name));
            let column = &mut self.signals[number].column;
            column.unit = column.unit.take().or(unit);
            if let Some(name) = name {
                column.name = name;
            }
        }
        for what in unused {
            self.guess(what);
        }
    }
}

/// The texts of the nearest list that is called one of `names` and has `count` of them.
fn list_of(
    variables: &Variables<'_>,
    scope: &str,
    names: &[&str],
    count: usize,
) -> Option<Vec<String>> {
    outwards(scope).find_map(|place| {
        let mut here = variables.here(place).filter(|variable| variable.is(names));
        here.find_map(|variable| texts_of(variable.value).filter(|texts| texts.len() == count))
    })
}

/// Whether the values increase in even steps, of the stated rate where there is one.
fn is_even_time(values: &[f64], rate_hz: Option<f64>) -> bool {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let Some(usual) = median(&mut steps).filter(|usual| *usual > 0.0 && values.len() > 2) else {
        return false;
    };
    let even = steps
        .iter()
        .all(|step| (step / usual - 1.0).abs() <= EVEN_STEPS);
    even && rate_hz.is_none_or(|rate| (usual * rate - 1.0).abs() <= ROUNDED_TIMES)
}

/// A vector as one column, a matrix as one for each of its shorter dimension.
fn columns_of(name: &str, numbers: &MatNumbers) -> Vec<Column> {
    if numbers.imaginary.is_some() {
        return Vec::new();
    }
    let column = |name, values| Column {
        name,
        unit: None,
        values,
    };
    if numbers.is_vector() {
        return vec![column(name.to_owned(), numbers.real.clone())];
    }
    let &[rows, columns] = numbers.dims.as_slice() else {
        return Vec::new();
    };
    if rows.min(columns) > MOST_CHANNELS {
        return Vec::new();
    }
    if rows >= columns {
        let parts = numbers.real.chunks_exact(rows).enumerate();
        parts
            .map(|(k, values)| column(format!("{name} {}", k + 1), values.to_vec()))
            .collect()
    } else {
        (0..rows)
            .map(|k| {
                let values = numbers.real.iter().skip(k).step_by(rows).copied().collect();
                column(format!("{name} {}", k + 1), values)
            })
            .collect()
    }
}

/// A stated rate.
#[derive(Clone, PartialEq)]
pub(super) struct StatedRate {
    /// How far out it stands.
    pub(super) far: usize,
    /// The name of its variable.
    pub(super) name: String,
    pub(super) rate: SampleRate,
}

/// The rate that is stated nearest to a place.
pub(super) fn nearest_rate(
    path: &Path,
    variables: &Variables<'_>,
    scope: &str,
) -> Result<Option<StatedRate>, ReadError> {
    for (far, place) in outwards(scope).enumerate() {
        let mut rates = variables.rates(path, place)?;
        if variables.is_rate_given {
            rates.truncate(1);
        }
        if let Some((name, hz)) = one_of(path, rates)? {
            let rate = SampleRate::new(hz).map_err(ReadError::of(path))?;
            return Ok(Some(StatedRate { far, name, rate }));
        }
    }
    Ok(None)
}
