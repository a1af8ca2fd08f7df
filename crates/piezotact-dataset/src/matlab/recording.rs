//! From the variables of a MATLAB file to the channels of a recording.
//!
//! Fields of one structure belong together, and so do cells of one number: `run.acc` with `run.fs`, `acc{2}` with `t{2}`. A channel
//! has the nearest time or rate, from its own structure outwards.

use std::path::Path;

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::Recording;

use super::convert::{flat, holds_response, listed};
use super::signals::{
    Found, Named, ROUNDED_TIMES, StatedRate, Variables, nearest_rate, outwards, run_of,
};
use super::{MatFile, MatValue};
use crate::columns::{Column, WithoutUnit, recording_of_bases};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::stated_rate::is_same_rate;
use crate::time_column::{TimeBase, base_beside, base_of, choose_base, state_unit};

/// More objects of classes than this are not named.
const MOST_OBJECTS: usize = 6;

/// Channels of one time, or of one place and rate.
struct Group {
    time: Option<usize>,
    scope: String,
    stated: Option<StatedRate>,
    columns: Vec<Column>,
}

impl Group {
    fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}

/// The numbers of a file as the channels of a recording.
pub(crate) fn recording_of(
    path: &Path,
    file: &MatFile,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let all = flat(file);
    let named = all.iter().map(|(name, value)| Named::new(name, value));
    let variables = Variables::new(named.collect(), options.rate);
    let mut found = Found::of(path, &variables)?;
    let mut options = options.clone();
    for time in &mut found.times.columns {
        state_unit(path, time, &mut options.units)?;
    }
    let options = &options;
    let (groups, left_out) = grouped(path, &variables, &mut found, options)?;
    let mut objects: Vec<(&str, &str)> = (variables.all.iter())
        .filter_map(|variable| match variable.value {
            MatValue::Object(class) => Some((
                variable.name.as_str(),
                class.as_deref().unwrap_or("of its own"),
            )),
            _ => None,
        })
        .collect();
    objects.truncate(MOST_OBJECTS);
    if groups.is_empty() {
        let todo = objects.first().map_or_else(
            || "save the channels as vectors with a rate `fs` or a time `t`, or export them as CSV with a header".into(),
            |(name, class)| how_to_save(name, class),
        );
        return Err(ReadError::content(
            path,
            "vectors of real numbers, all of one length, as channels",
            listed(&all),
            todo,
        ));
    }
    if (groups.iter())
        .any(|group| group.time.is_none() && group.stated.is_none() && options.rate.is_none())
    {
        return Err(ReadError::content(
            path,
            "a rate: a number named fs, rate or sampling_rate, or a vector named t or time",
            listed(&all),
            match objects.first() {
                Some((name, class)) => {
                    format!("give the rate with --rate, or {}", how_to_save(name, class))
                }
                None => "give the rate with --rate, for example --rate 5000".into(),
            },
        ));
    }
    for (name, class) in &objects {
        found.guess(format!(
            "`{name}`, an object of the class {class}, was left out: {}",
            how_to_save(name, class)
        ));
    }
    for (why, mut names) in left_out {
        let count = names.len();
        names.truncate(6);
        found.guess(format!(
            "{count} vectors {why} and were left out: {}",
            names.join(", ")
        ));
    }
    // A file with a frequency response is read as one, too: its spectra are not left out.
    if !found.no_channels.is_empty() && !holds_response(&all) {
        found.no_channels.truncate(6);
        let named = found.no_channels.join(", ");
        found.guess(format!(
            "arrays that are no channels were left out: {named}"
        ));
    }
    if !found.scales.is_empty() {
        found.scales.truncate(6);
        let named = found.scales.join(", ");
        found.guess(format!(
            "numbers that may be the scale of a channel were not applied: {named} (a scale: --scale \"200 m/s2\")"
        ));
    }
    let (placed, mut warnings) = on_clocks(path, &variables, groups, &mut found, options)?;
    warnings.append(&mut found.warnings);
    let bases: Vec<(TimeBase, Seconds)> = (placed.iter())
        .map(|placed| (placed.base.clone(), Seconds(placed.start_s)))
        .collect();
    let columns = (placed.into_iter().enumerate())
        .flat_map(|(number, placed)| {
            placed
                .group
                .columns
                .into_iter()
                .map(move |column| (column, number))
        })
        .collect();
    recording_of_bases(
        path,
        columns,
        &bases,
        warnings,
        options,
        WithoutUnit::OnlyScale { counts: &[] },
    )
}

/// How the content of an object is saved in MATLAB so that other programs can read it.
fn how_to_save(name: &str, class: &str) -> String {
    match class {
        "table" | "timetable" => format!(
            "save the columns of a table in MATLAB with s = table2struct({name}, 'ToScalar', true); save('file.mat', '-struct', 's') (a timetable \
             first becomes one with timetable2table; its times become seconds with seconds(t - t(1)))"
        ),
        "datetime" => format!("save it in MATLAB as seconds: t = seconds({name} - {name}(1))"),
        "duration" => format!("save it in MATLAB as seconds: t = seconds({name})"),
        "string" | "categorical" => format!("save it in MATLAB as texts: {name} = cellstr({name})"),
        "timeseries" => format!("save its numbers in MATLAB: t = {name}.Time; x = {name}.Data"),
        _ => "save its numbers in MATLAB as vectors".to_owned(),
    }
}

/// Why vectors were left out, and which.
type LeftOut = Vec<(String, Vec<String>)>;

/// The channels by their time or place.
fn grouped(
    path: &Path,
    variables: &Variables<'_>,
    found: &mut Found,
    options: &ReadOptions,
) -> Result<(Vec<Group>, LeftOut), ReadError> {
    let mut groups = Vec::<Group>::new();
    let mut left_out = LeftOut::new();
    let mut leave = |why: String, name: String| match left_out.iter_mut().find(|out| out.0 == why) {
        Some((_, names)) => names.push(name),
        None => left_out.push((why, vec![name])),
    };
    for signal in std::mem::take(&mut found.signals) {
        let scope = &variables.all[signal.at].scope;
        let stated = nearest_rate(path, variables, scope)?;
        let nearest = match signal.own_time {
            Some(time) => Ok(Some(time)),
            None => found.times.nearest(scope, signal.column.values.len()),
        };
        let time = match nearest {
            Ok(time) => time,
            // Its own rate is nearer than a time of other channels.
            Err((far, _)) if stated.as_ref().is_some_and(|stated| stated.far < far) => None,
            Err((_, length)) => {
                let why = format!("are not as long as the time ({length})");
                leave(why, signal.column.name);
                continue;
            }
        };
        let known = groups.iter_mut().find(|group| match time {
            Some(_) => group.time == time && group.stated == stated,
            None => group.time.is_none() && group.scope == *scope,
        });
        match known {
            Some(group) => group.columns.push(signal.column),
            None => groups.push(Group {
                time,
                scope: scope.clone(),
                stated,
                columns: vec![signal.column],
            }),
        }
    }
    // Where some have a time or a rate, what has none beside them is no channel.
    let timed = |group: &Group| group.time.is_some() || group.stated.is_some();
    if options.rate.is_none() && groups.iter().any(timed) {
        let (with, without) = groups.into_iter().partition(timed);
        groups = with;
        for column in without.into_iter().flat_map(|group: Group| group.columns) {
            leave("have no time and no rate".into(), column.name);
        }
    }
    one_length(path, &groups)?;
    Ok((groups, left_out))
}

/// Channels without a time have one length where they share a place or a rate; runs of one array may differ.
fn one_length(path: &Path, groups: &[Group]) -> Result<(), ReadError> {
    let stated_by = |group: &Group| group.stated.as_ref().map(|stated| stated.name.clone());
    let without_time = groups.iter().filter(|group| group.time.is_none());
    let mut first = None::<(&Group, &Column)>;
    for group in without_time {
        for column in &group.columns {
            let (of, other) = *first.get_or_insert((group, column));
            let apart = of.scope != group.scope
                && (run_of(&of.scope).is_some_and(|of| run_of(&group.scope) == Some(of))
                    || stated_by(of) != stated_by(group));
            if column.values.len() != other.values.len() && !apart {
                return Err(ReadError::content(
                    path,
                    "vectors of one length as channels, or a vector `t` or `time` whose length selects the channels",
                    format!(
                        "`{}` with {} and `{}` with {} numbers",
                        other.name,
                        other.values.len(),
                        column.name,
                        column.values.len()
                    ),
                    "save the channels that were recorded together in a separate file",
                ));
            }
        }
    }
    Ok(())
}

/// Channels on the grid of their time.
struct Placed {
    group: Group,
    base: TimeBase,
    start_s: f64,
}

/// The channels with their grids, and the warnings about the times.
fn on_clocks(
    path: &Path,
    variables: &Variables<'_>,
    groups: Vec<Group>,
    found: &mut Found,
    options: &ReadOptions,
) -> Result<(Vec<Placed>, Vec<Warning>), ReadError> {
    let found_bases: Vec<Option<TimeBase>> = (found.times.columns.iter())
        .map(|time| base_of(path, time, &mut Vec::new()).ok())
        .collect();
    let of_times: Vec<Option<SampleRate>> = (found_bases.iter())
        .map(|base| Some(base.as_ref()?.rate))
        .collect();
    let fewest_parts = found_bases.iter().flatten().map(TimeBase::parts).min();
    let rate_in_file = |group: &Group| match group.time {
        Some(time) => of_times[time],
        None => group.stated.as_ref().map(|stated| stated.rate),
    };
    one_rate(path, groups.iter().filter_map(rate_in_file), options)?;
    let some_usable = groups.iter().any(|group| rate_in_file(group).is_some());
    let without_time = groups.iter().find(|group| group.time.is_none());
    let without_time = without_time.and_then(|group| Some(group.columns.first()?.name.clone()));
    let several = found.times.columns.len() > 1 || (groups.len() > 1 && without_time.is_some());
    let mut warnings = Vec::<Warning>::new();
    let (mut placed, mut late) = (Vec::new(), Vec::new());
    for group in groups {
        let (mut of_rate, mut start_s) = (Vec::new(), 0.0);
        let base = match (group.time, &group.stated) {
            (Some(time), stated) => {
                let rate = of_times[time];
                let time = &found.times.columns[time];
                if let (true, Some(rate)) = (several, rate) {
                    start_s = start_of(time, rate);
                    if let (Some(other), true) = (&without_time, start_s != 0.0) {
                        late.push(format!(
                            "`{}` begins at {} s; `{other}` has a rate and no time, and is taken to begin at 0 s",
                            time.name,
                            digits(start_s)
                        ));
                    }
                }
                // A rate of a file with several is that of other channels.
                let own = stated.as_ref().filter(|stated| {
                    let agrees = |rate: &SampleRate| agree(rate.hz(), stated.rate.hz());
                    rate.as_ref().is_some_and(agrees) || !of_times.iter().flatten().any(agrees)
                });
                Some(match own {
                    Some(stated) => {
                        let stated = (stated.name.as_str(), stated.rate);
                        Ok(base_beside(path, time, stated, &mut of_rate))
                    }
                    None => base_of(path, time, &mut of_rate),
                })
            }
            (None, stated) => (stated.as_ref()).map(|stated| Ok(TimeBase::even(stated.rate))),
        };
        let base = match base {
            Some(Err(error)) if options.rate.is_none() && some_usable => {
                let names: Vec<&str> = (group.columns.iter())
                    .map(|column| column.name.as_str())
                    .collect();
                found.guess(format!("{} was left out: {error}", names.join(", ")));
                continue;
            }
            Some(Ok(base))
                if options.rate.is_none()
                    && Some(base.parts()) > fewest_parts
                    && fewest_parts.is_some() =>
            {
                for column in &group.columns {
                    found.guess(format!(
                        "{} was left out: its time has pauses where that of other channels has none",
                        column.name
                    ));
                }
                continue;
            }
            base => choose_base(path, options, base, &mut of_rate)?,
        };
        for warning in of_rate {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        placed.push(Placed {
            group,
            base,
            start_s,
        });
    }
    for of_time in late {
        found.guess(of_time);
    }
    one_after_the_other(&mut placed, found);
    if options.rate.is_none() {
        outer_rates(path, variables, &placed, found)?;
    }
    Ok((placed, warnings))
}

/// Warns of rates around the channels that none of them has.
fn outer_rates(
    path: &Path,
    variables: &Variables<'_>,
    placed: &[Placed],
    found: &mut Found,
) -> Result<(), ReadError> {
    let mut said = Vec::new();
    for Placed { group, base, .. } in placed {
        for place in outwards(&group.scope) {
            for (name, hz) in variables.rates(path, place)? {
                let is_used = |placed: &Placed| {
                    let own = placed.group.stated.as_ref();
                    is_same_rate(placed.base.rate.hz(), hz)
                        || own.is_some_and(|own| own.name == name)
                };
                if said.contains(&name) || placed.iter().any(is_used) {
                    continue;
                }
                found.guess(format!(
                    "`{name}` states {} Hz and was not used: `{}` has {} Hz",
                    digits(hz),
                    group.columns[0].name,
                    digits(base.rate.hz())
                ));
                said.push(name);
            }
        }
    }
    Ok(())
}

/// Refuses one rate for channels of several.
fn one_rate(
    path: &Path,
    rates: impl Iterator<Item = SampleRate>,
    options: &ReadOptions,
) -> Result<(), ReadError> {
    let mut rates = rates.map(SampleRate::hz);
    let first = rates.next();
    let other = rates.find(|hz| first.is_some_and(|first| !agree(first, *hz)));
    match (options.rate, first, other) {
        (Some(_), Some(first), Some(other)) => Err(ReadError::content(
            path,
            "channels of one rate, because one rate is given",
            format!("rates of {first} and {other} Hz"),
            "leave out --rate",
        )),
        _ => Ok(()),
    }
}

fn agree(a_hz: f64, b_hz: f64) -> bool {
    (a_hz / b_hz - 1.0).abs() <= ROUNDED_TIMES
}

/// When the first sample was taken, in s. The unit of the times follows from their rate: s or a power of ten of it.
fn start_of(time: &Column, rate: SampleRate) -> f64 {
    let (Some(first), Some(last)) = (time.values.first(), time.values.last()) else {
        return 0.0;
    };
    let unit_s = (time.values.len() - 1) as f64 / ((last - first) * rate.hz());
    first * 10_f64.powi(unit_s.log10().round() as i32)
}

/// Runs of one array (elements, cells) at the same time, but of different lengths, were recorded one after the other.
fn one_after_the_other(placed: &mut [Placed], found: &mut Found) {
    for first in 0..placed.len() {
        let Placed {
            group,
            base,
            start_s,
        } = &placed[first];
        let (of, rate, start_s) = (run_of(&group.scope), base.rate, *start_s);
        let is_run = |other: &Placed| {
            of.is_some()
                && run_of(&other.group.scope) == of
                && (other.base.rate, other.start_s) == (rate, start_s)
        };
        let runs: Vec<usize> = (first..placed.len())
            .filter(|at| is_run(&placed[*at]))
            .collect();
        let length = placed[first].group.len();
        if runs.iter().all(|at| placed[*at].group.len() == length) {
            continue;
        }
        let mut start_s = start_s;
        for at in &runs {
            placed[*at].start_s = start_s;
            start_s += rate.duration_of(placed[*at].group.len()).0;
        }
        let name = |at: &usize| placed[*at].group.columns[0].name.clone();
        let names: Vec<String> = runs.iter().take(3).map(name).collect();
        found.guess(format!(
            "{} runs of different lengths ({}, …) are placed one after the other: the times between them are not in the file",
            runs.len(),
            names.join(", ")
        ));
    }
}
