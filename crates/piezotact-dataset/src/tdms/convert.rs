//! The channels of a TDMS file as a recording.

use std::path::Path;

use piezotact::Warning;
use piezotact::number::{counted, digits};
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{Recording, RecordingWarning, StartTime};

use super::index::Kind;
use super::layout::Object;
use super::property::{Properties, Property, Stamp, Start};
use super::samples::{File, Values};
use super::scale::Chain;
use crate::columns::{Column, WithoutUnit, recording_of_bases, start_of_part};
use crate::error::ReadError;
use crate::lvm;
use crate::open::ReadOptions;
use crate::time_column::{TimeBase, base_of, choose_base, is_time, rate_of_step, seconds_of};

/// More names than this are not listed in a warning.
const MOST_NAMED: usize = 6;
/// Starts that differ by less than this share of a sample are one.
const LEAST_SHIFT: f64 = 0.01;
/// Properties with these words in their names are labels of the recording.
const LABELS: [&str; 6] = [
    "description",
    "sensor",
    "serial",
    "comment",
    "remark",
    "ni_channelname",
];

/// A channel with samples.
struct Signal {
    group: String,
    column: Column,
    /// Integers without a scale.
    is_count: bool,
    /// Samples that the file states and does not hold.
    missing: u64,
    /// The time between two samples, s, where it is stated.
    step_s: Option<f64>,
    /// The time of the first sample from `began` on, s.
    offset_s: f64,
    began: Option<StartTime>,
}

/// The times of a group: a channel of them, in s where no unit stands, and the absolute time from which they count.
struct Times {
    group: String,
    column: Column,
    began: Option<StartTime>,
}

/// Signals that share a clock.
struct Group {
    signals: Vec<Signal>,
    /// The number of their times.
    times: Option<usize>,
}

/// The channels of a file as a recording.
pub(super) fn recording_of(
    path: &Path,
    file: &File,
    values: Vec<Vec<Values>>,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let mut parts = Parts::default();
    let labels = labels(&file.objects);
    for (number, values) in values.into_iter().enumerate() {
        parts.add(&file.objects, number, values);
    }
    let is_cut = file.is_cut;
    let mut groups = parts.grouped();
    if groups.len() > 1 && options.rate.is_none() {
        // Single values beside signals have no rate.
        for group in groups.extract_if(.., |group| {
            group.times.is_none() && group.signals[0].step_s.is_none()
        }) {
            let names = group.signals.into_iter().map(|signal| signal.column.name);
            parts
                .left_out
                .extend(names.map(|name| format!("`{name}` (no rate, no times)")));
        }
    }
    if groups.is_empty() {
        return Err(ReadError::content(
            path,
            "a channel with a rate and samples",
            match parts.left_out.as_slice() {
                [] => "none".into(),
                left_out => first_of(left_out),
            },
            "export the signals with the time between two samples, or with their times, or give the rate with --rate",
        ));
    }
    if options.rate.is_some() && groups.len() > 1 {
        return Err(ReadError::content(
            path,
            "channels of one rate, because one rate is given",
            format!("channels on {} sampling clocks", groups.len()),
            "leave the rate out, or export channels of different rates to separate files",
        ));
    }
    let mut warnings = parts.warnings;
    if !parts.restarted.is_empty() {
        warnings.push(guessed(format!(
            "the file states further starts: {}; all samples were read as one continuous signal, although some may be missing between them",
            first_of(&parts.restarted)
        )));
    }
    let mut said = Vec::new();
    missing(&groups, &mut said);
    if is_cut {
        for group in &mut groups {
            whole_rows(group, &mut said, &mut parts.left_out);
        }
    }
    if is_cut || !said.is_empty() {
        let missing = match said.as_slice() {
            [] => "how many samples are missing is not known".to_owned(),
            said => format!("missing are {}", first_of(said)),
        };
        warnings.push(guessed(format!(
            "the file ends before the samples that it states: {missing}; the available samples were read"
        )));
    }
    if !parts.left_out.is_empty() {
        warnings.push(guessed(format!(
            "channels were left out: {}",
            first_of(&parts.left_out)
        )));
    }
    let mut of_rate = Vec::new();
    let starts = groups.iter().flat_map(|group| group.began(&parts.times));
    let earliest = starts.min_by(|a, b| a.seconds_since(b).0.total_cmp(&0.0));
    let without_start = groups
        .iter()
        .filter(|group| group.began(&parts.times).is_none());
    let names = without_start.map(|group| format!("`{}`", group.signals[0].column.name));
    let names: Vec<String> = names.collect();
    if earliest.is_some() && !names.is_empty() {
        warnings.push(guessed(format!(
            "no start is stated of {}, which is taken to begin with the first channel",
            first_of(&names)
        )));
    }
    let mut columns = Vec::new();
    let mut bases = Vec::new();
    let mut counts = Vec::new();
    for group in groups {
        let times = group.times.and_then(|at| parts.times.get(at));
        one_length(path, &group, times.filter(|_| !is_cut))?;
        let found = match (times, group.signals[0].step_s) {
            (Some(times), _) => Some(base_of(path, &times.column, &mut of_rate)),
            (None, Some(step_s)) => Some(rate_of_step(path, step_s).map(TimeBase::even)),
            (None, None) => None,
        };
        let start_s = match (group.began(&parts.times), &earliest) {
            (Some(began), Some(earliest)) => began.seconds_since(earliest).0,
            // Without an absolute time, only times on a common zero can be compared.
            (None, None) => group.offset_s(&parts.times),
            _ => 0.0,
        };
        let base = choose_base(path, options, found, &mut of_rate)?;
        warnings.extend(group.shifted());
        bases.push((base, Seconds(start_s)));
        for signal in group.signals {
            if signal.is_count {
                counts.push(signal.column.name.clone());
            }
            columns.push((signal.column, bases.len() - 1));
        }
    }
    of_rate.append(&mut warnings);
    of_rate.extend(apart(&columns, &bases));
    let unnamed = WithoutUnit::OnlyScale { counts: &counts };
    let mut recording = recording_of_bases(path, columns, &bases, of_rate, options, unnamed)?;
    let later = start_of_part(&bases);
    recording.annotations.started_at = earliest.map(|at| at.later(later));
    recording.annotations.labels = labels;
    recording.about.provenance.losses.is_interrupted = is_cut;
    if file.is_interrupted {
        let read_s = recording.duration().0;
        let warning = RecordingWarning::Interrupted { read_s };
        recording.about.warnings.insert(0, warning.into());
    }
    Ok(recording)
}

fn guessed(what: String) -> Warning {
    Warning::from(RecordingWarning::Guessed { what })
}

/// That channels begin after those end that began first: nothing was recorded together.
fn apart(columns: &[(Column, usize)], bases: &[(TimeBase, Seconds)]) -> Option<Warning> {
    let start_s = |at: usize| bases[at].1.0;
    let (first, at) = (columns.iter()).min_by(|a, b| start_s(a.1).total_cmp(&start_s(b.1)))?;
    let length_s = bases[*at].0.time_of(first.values.len());
    let later = columns
        .iter()
        .filter(|(_, other)| start_s(*other) - start_s(*at) > length_s);
    let names: Vec<String> = later
        .clone()
        .map(|(column, _)| format!("`{}`", column.name))
        .collect();
    let (_, next) = later.min_by(|a, b| start_s(a.1).total_cmp(&start_s(b.1)))?;
    Some(guessed(format!(
        "{} begin {} s after `{}`, which lasts {} s: they were not recorded together",
        first_of(&names),
        digits(start_s(*next) - start_s(*at)),
        first.name,
        digits(length_s)
    )))
}

/// The first of a list, and how many more there are.
fn first_of(all: &[String]) -> String {
    let first = all[..all.len().min(MOST_NAMED)].join(", ");
    match all.len().saturating_sub(MOST_NAMED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// What a file holds, sorted.
#[derive(Default)]
struct Parts {
    signals: Vec<Signal>,
    times: Vec<Times>,
    /// Channels that are left out, and why.
    left_out: Vec<String>,
    /// Channels that were started again, and where.
    restarted: Vec<String>,
    warnings: Vec<Warning>,
}

impl Parts {
    /// Takes the channel of this number.
    fn add(&mut self, objects: &[Object], number: usize, mut values: Vec<Values>) {
        let object = &objects[number];
        let Some(channel) = &object.channel else {
            return;
        };
        let name = name_of(objects, number, channel);
        let held = object
            .slots
            .iter()
            .map(|slot| slot.count)
            .max()
            .unwrap_or(0);
        let mut leave = |why: String| self.left_out.push(format!("`{name}` ({why})"));
        if held == 0 {
            return leave(match object.missing {
                0 => "no samples".into(),
                missing => format!("none of its {missing} samples are in the file"),
            });
        }
        let text = |key: &str| object.properties.get(key).and_then(Property::text);
        match object.slots[0].kind {
            Kind::Text => {
                let first = values[0].text.take().unwrap_or_default();
                return leave(format!(
                    "{}, the first `{}`",
                    counted(held as usize, "text"),
                    first.chars().take(40).collect::<String>().escape_debug()
                ));
            }
            Kind::Complex(_) => return leave("complex numbers".into()),
            Kind::Time => {
                let began = values[0].first.and_then(Stamp::start_time);
                return self.times.push(Times {
                    group: object.group.clone(),
                    column: Column {
                        name,
                        unit: Some("s".into()),
                        values: values.swap_remove(0).numbers,
                    },
                    began,
                });
            }
            _ => {}
        }
        if let Some(property) = &object.changed {
            return leave(format!("its `{property}` changes between its samples"));
        }
        let of_step = text("wf_xunit_string").map(|unit| (unit, Unit::parse(unit)));
        let second = match of_step {
            None => 1.0,
            Some((_, (Unit::Second, second))) => second,
            Some((unit, _)) => return leave(format!("over {unit}, not over time")),
        };
        let slots: Vec<Vec<f64>> = values.into_iter().map(|values| values.numbers).collect();
        let chain = match chain_of(objects, object) {
            Ok(chain) => chain,
            Err(what) => return leave(format!("{what}, which is not applied here")),
        };
        let is_scaled = chain.is_some();
        let (values, outside) = match chain {
            Some(chain) => chain.apply(slots),
            None if slots.len() > 1 => {
                return leave(format!(
                    "{} scalers and no scale that joins them",
                    slots.len()
                ));
            }
            None => (slots.into_iter().next().unwrap_or_default(), 0),
        };
        if outside > 0 {
            self.warnings
                .push(Warning::from(RecordingWarning::OutsideRange {
                    channel: name.clone(),
                    samples: outside,
                    of: values.len(),
                }));
        }
        let number = |key: &str| object.properties.get(key).and_then(Property::number);
        let is_line = matches!(object.slots[0].kind, Kind::Truth | Kind::Bit(..));
        let unit = text("unit_string").or_else(|| text("NI_UnitDescription"));
        let is_float = matches!(
            object.slots[0].kind,
            Kind::Number(crate::stored::Stored::F32 | crate::stored::Stored::F64)
        );
        let step_s = number("wf_increment").map(|step| step * second);
        let step_s = step_s.filter(|s| *s > 0.0 && s.is_finite());
        let start = object.starts.first().map(|(_, start)| *start);
        let mut start = start.unwrap_or_else(|| Start::of(&object.properties));
        start.offset_s *= second;
        if let Some((place, samples)) = step_s.and_then(|step_s| gap(object, step_s, second)) {
            self.restarted.push(format!(
                "`{name}` at sample {place}, {samples:.1} samples after the one before"
            ));
        }
        let began = start.stamp.and_then(Stamp::start_time);
        self.signals.push(Signal {
            group: object.group.clone(),
            column: Column {
                name,
                unit: match unit {
                    // A line is no quantity: nothing scales it.
                    None if is_line => Some("0/1".into()),
                    unit => unit.map(lvm::unit),
                },
                values,
            },
            is_count: !is_scaled && !is_float,
            missing: object.missing,
            step_s,
            offset_s: start.offset_s,
            began: began.map(|began| began.later(Seconds(start.offset_s))),
        });
    }

    /// The signals by their clocks. A channel of times gives those of its group the times that their properties do not.
    fn grouped(&mut self) -> Vec<Group> {
        let signals = std::mem::take(&mut self.signals);
        let needs_times = |group: &str| {
            let mut of_group = signals.iter().filter(|signal| signal.group == group);
            of_group.any(|signal| signal.step_s.is_none() && !holds_times(signal))
        };
        let of_numbers: Vec<bool> = signals
            .iter()
            .map(|signal| {
                signal.step_s.is_none() && holds_times(signal) && needs_times(&signal.group)
            })
            .collect();
        let mut groups = Vec::<Group>::new();
        let mut others = Vec::new();
        for (signal, is_time) in signals.into_iter().zip(of_numbers) {
            match is_time {
                true => self.times.push(Times {
                    group: signal.group,
                    column: signal.column,
                    began: None,
                }),
                false => others.push(signal),
            }
        }
        for signal in others {
            let times = match signal.step_s {
                Some(_) => None,
                None => self
                    .times
                    .iter()
                    .position(|times| times.group == signal.group),
            };
            match groups.iter_mut().find(|group| group.holds(&signal, times)) {
                Some(group) => group.signals.push(signal),
                None => groups.push(Group {
                    signals: vec![signal],
                    times,
                }),
            }
        }
        let used = |at: usize| groups.iter().any(|group| group.times == Some(at));
        let unused = self.times.iter().enumerate().filter(|(at, _)| !used(*at));
        let unused = unused.map(|(_, times)| format!("`{}` (times)", times.column.name));
        self.left_out.extend(unused);
        groups
    }
}

/// The first start of a channel that does not lie where the samples before it end: the sample, and how many samples after the one before.
/// The offsets of its starts count in units of `second`.
fn gap(object: &Object, step_s: f64, second: f64) -> Option<(u64, f64)> {
    let (_, first) = object.starts.first()?;
    let distances = object.starts.iter().filter_map(|(count, start)| {
        let samples = start.since(*first, second)? / step_s - *count as f64;
        (samples.abs() > 0.5).then_some((*count, samples + 1.0))
    });
    distances.into_iter().next()
}

/// Whether a channel holds the times of others.
fn holds_times(signal: &Signal) -> bool {
    let name = Column::from_header(&signal.column.name).name;
    let unit = signal.column.unit.as_deref();
    is_time(&name) && unit.is_none_or(|unit| seconds_of(unit).is_some())
}

/// The scales of a channel: its own, or those of its group or of the file.
pub(super) fn chain_of(objects: &[Object], object: &Object) -> Result<Option<Chain>, String> {
    let above = [object.group.as_str(), ""].map(|group| {
        let is_it = |other: &&Object| other.channel.is_none() && other.group == group;
        objects.iter().find(is_it)
    });
    let mut properties: Vec<&Properties> = vec![&object.properties];
    properties.extend(above.into_iter().flatten().map(|object| &object.properties));
    Chain::of(&properties, &object.slots)
}

/// The name of a channel, with that of its group where another group has a channel of this name.
pub(super) fn name_of(objects: &[Object], number: usize, channel: &str) -> String {
    let mut others = objects.iter().enumerate();
    match others.any(|(at, other)| at != number && other.channel.as_deref() == Some(channel)) {
        true => format!("{}: {channel}", objects[number].group),
        false => channel.to_owned(),
    }
}

/// What properties say of sensors and of the recording.
fn labels(objects: &[Object]) -> std::collections::BTreeMap<String, String> {
    let of = |(number, object): (usize, &Object)| {
        let place = match &object.channel {
            Some(channel) => format!("{}: ", name_of(objects, number, channel)),
            None if object.group.is_empty() => String::new(),
            None => format!("{}: ", object.group),
        };
        let wanted = |(key, value): (&String, &Property)| {
            let small = key.to_lowercase();
            let is_label = LABELS.iter().any(|word| small.contains(word));
            let text = value
                .text()
                .filter(|_| is_label && small != "ni_unitdescription")?;
            let is_name = Some(text) == object.channel.as_deref();
            (!is_name).then(|| (format!("{place}{key}"), text.to_owned()))
        };
        object
            .properties
            .iter()
            .filter_map(wanted)
            .collect::<Vec<_>>()
    };
    objects.iter().enumerate().flat_map(of).collect()
}

impl Group {
    /// Whether a signal has its clock.
    fn holds(&self, signal: &Signal, times: Option<usize>) -> bool {
        let first = &self.signals[0];
        let half_a_step = 0.5 * first.step_s.unwrap_or(0.0);
        let starts = (self.later_s(signal)).is_some_and(|later| later.abs() <= half_a_step);
        self.times == times && first.step_s == signal.step_s && (starts || first.step_s.is_none())
    }

    /// How much later than its first one a signal begins, s; absent where only one of them states a moment.
    fn later_s(&self, signal: &Signal) -> Option<f64> {
        let first = &self.signals[0];
        match (&first.began, &signal.began) {
            (Some(own), Some(other)) => Some(other.seconds_since(own).0),
            (None, None) => Some(signal.offset_s - first.offset_s),
            _ => None,
        }
    }

    /// The warning that signals begin up to half a sample from the first one, whose clock they share.
    fn shifted(&self) -> Option<Warning> {
        let first = &self.signals[0];
        let step_s = first.step_s?;
        let shifts = self.signals.iter().filter_map(|signal| {
            let shift = self.later_s(signal)? / step_s;
            let name = &signal.column.name;
            (shift.abs() > LEAST_SHIFT).then(|| format!("`{name}` by {} samples", digits(shift)))
        });
        let shifts: Vec<String> = shifts.collect();
        (!shifts.is_empty()).then(|| {
            guessed(format!(
                "channels that begin up to half a sample ({} ms) from `{}` are read as taken at once with it: {} later",
                digits(500.0 * step_s),
                first.column.name,
                first_of(&shifts)
            ))
        })
    }

    /// The time of its first sample.
    fn began(&self, times: &[Times]) -> Option<StartTime> {
        match self.times {
            Some(at) => times[at].began.clone(),
            None => self.signals[0].began.clone(),
        }
    }

    /// The time of its first sample, s, where no absolute one is known.
    fn offset_s(&self, times: &[Times]) -> f64 {
        match self.times {
            Some(at) => {
                let column = &times[at].column;
                let (_, second) = Unit::parse(column.unit.as_deref().unwrap_or("s"));
                column.values.first().map_or(0.0, |first| first * second)
            }
            None => self.signals[0].offset_s,
        }
    }
}

/// Says which channels of a file lack samples that it states.
fn missing(groups: &[Group], said: &mut Vec<String>) {
    for signal in groups.iter().flat_map(|group| &group.signals) {
        if signal.missing > 0 {
            let stated = signal
                .missing
                .saturating_add(signal.column.values.len() as u64);
            said.push(format!(
                "{} of {stated} samples of `{}`",
                signal.missing, signal.column.name
            ));
        }
    }
}

/// Leaves whole rows of a clock in a file that was cut short, at the length at which most samples stay.
fn whole_rows(group: &mut Group, said: &mut Vec<String>, left_out: &mut Vec<String>) {
    let length = |signal: &Signal| signal.column.values.len();
    let lengths: Vec<usize> = group.signals.iter().map(length).collect();
    let stay = |kept: &usize| {
        let longer = lengths.iter().filter(|other| *other >= kept);
        (longer.count() as u128 * *kept as u128, *kept)
    };
    let kept = lengths.iter().copied().max_by_key(stay).unwrap_or(0);
    for signal in group.signals.extract_if(.., |signal| length(signal) < kept) {
        left_out.push(format!(
            "`{}` ({} samples, where others have {kept})",
            signal.column.name,
            length(&signal)
        ));
    }
    for signal in &mut group.signals {
        let more = length(signal) - kept;
        signal.column.values.truncate(kept);
        if more > 0 {
            said.push(format!(
                "the last {more} samples of `{}` were left out, as other channels end before them",
                signal.column.name
            ));
        }
    }
}

/// That all channels of a clock have as many samples, and as many as there are times.
fn one_length(path: &Path, group: &Group, times: Option<&Times>) -> Result<(), ReadError> {
    let first = &group.signals[0].column;
    let others = group.signals.iter().map(|signal| &signal.column);
    let mut others = others.chain(times.map(|times| &times.column));
    match others.find(|other| other.values.len() != first.values.len()) {
        None => Ok(()),
        Some(other) => Err(ReadError::content(
            path,
            format!(
                "{} samples in every channel of one clock, as in `{}`",
                first.values.len(),
                first.name
            ),
            format!("{} of `{}`", other.values.len(), other.name),
            "export the channels that were recorded together to a separate file",
        )),
    }
}
