//! From the parts of a recording to clean epochs: channels, filters, cut, regression, reference, rejection.

mod error;
mod interpolated;
mod off;
mod signals;
mod usable;

use std::collections::{BTreeMap, BTreeSet};

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::recording::{Event, EventValue};
use serde::{Deserialize, Serialize};

use super::epochs::{Continuous, Criterion, CutConfig, Epochs, NotCut, cut, reject};
use super::filter::{Fir, Pass};
use super::reference::{Montage, average, to_channels};
use super::regression::EogRegression;
use super::source::{Segment, is_marker, kind_and_value, markers, task_of, tasks, warnings_of};
use interpolated::interpolated;
use signals::Signals;
use usable::{beside_unusable, lost_to_electrodes, once, unknown_in_average, unusable};

pub use error::PrepareError;
pub use signals::ChannelChoice;

/// A marker and the condition whose epochs it begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MarkerChoice {
    /// The marker, by its whole name, its kind or its value.
    pub marker: String,
    /// The condition: a surface. Where it is the name of a kind of markers itself, each has the condition that its value names.
    pub condition: String,
}

impl MarkerChoice {
    /// The condition of an event that this marker stands for.
    fn condition_of(&self, event: &Event) -> String {
        let is_kind = self.condition == self.marker && !is_number(event);
        match kind_and_value(event) {
            (kind, Some(value)) if is_kind && kind == self.marker => value,
            _ => self.condition.clone(),
        }
    }
}

/// Whether the value of an event is a number: the code of a trigger names no condition.
fn is_number(event: &Event) -> bool {
    matches!(event.value, Some(EventValue::Number(_)))
}

/// What signals are referred to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// What they were recorded against.
    AsRecorded,
    /// The mean of all electrodes.
    Average,
    /// The mean of these channels.
    Channels(Vec<String>),
}

impl std::fmt::Display for Reference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AsRecorded => f.write_str("as recorded"),
            Self::Average => f.write_str("average of all electrodes"),
            Self::Channels(names) => write!(f, "{}", names.join(" and ")),
        }
    }
}

/// How epochs are made. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PrepareConfig {
    /// The markers, and what each begins.
    pub markers: Vec<MarkerChoice>,
    /// The task whose epochs are taken; absent where the recording has only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// The extent of epochs.
    pub extent: CutConfig,
    /// Which channels.
    pub channels: ChannelChoice,
    /// Filters of the continuous signals, in order; each part between two gaps by itself.
    pub filters: Vec<Pass>,
    /// EOG channels whose part in the others is taken away by regression; none where empty.
    pub eog: Vec<String>,
    /// Electrodes whose signals are interpolated from those of the others; none where empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interpolated: Vec<String>,
    /// The reference.
    pub reference: Reference,
    /// By what epochs are rejected; nothing where empty.
    pub criteria: Vec<Criterion>,
    /// With fewer epochs of a condition there is no result.
    pub min_epochs: usize,
}

/// Epochs of a condition, counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ConditionCount {
    /// The condition.
    pub condition: String,
    /// Its markers.
    pub markers: usize,
    /// Epochs that are kept.
    pub kept: usize,
    /// Epochs that a criterion rejected.
    pub rejected: usize,
    /// Markers without a whole epoch: it would cross a gap or an end of the recording.
    pub left_out: usize,
}

/// A marker without a whole epoch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct NotWhole {
    /// Its condition.
    pub condition: String,
    /// When it stands, from the first sample of the file, s.
    pub onset_s: f64,
    /// Why.
    pub reason: NotCut,
}

/// An epoch that was rejected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RejectedEpoch {
    /// Its condition.
    pub condition: String,
    /// When its marker stands, from the first sample of the file, s.
    pub onset_s: f64,
    /// The channel that is furthest beyond its limit.
    pub channel: String,
    /// How many channels are beyond one.
    pub channels: usize,
    /// By which criterion.
    pub criterion: Criterion,
    /// What the criterion measured, V.
    pub found_v: f64,
}

/// Which markers have an epoch, and which not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EpochCounts {
    /// How many of each condition, in the order in which they were asked for.
    pub conditions: Vec<ConditionCount>,
    /// Each marker without a whole epoch.
    pub not_whole: Vec<NotWhole>,
    /// Each rejected epoch.
    pub rejected: Vec<RejectedEpoch>,
}

/// Clean epochs with the way to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// How they were made.
    pub config: PrepareConfig,
    /// The task: the one asked for, or that of the recording; empty where nothing names one.
    pub task: String,
    /// The epochs that are kept.
    pub epochs: Epochs,
    /// When their markers stand, from the first sample of the file, s.
    pub onsets_s: Vec<f64>,
    /// Which markers have one.
    pub counts: EpochCounts,
    /// What to know before relying on them.
    pub warnings: Vec<Warning>,
}

/// An event of the whole recording, parts joined.
struct Marked {
    event: super::epochs::Event,
    onset_s: f64,
}

/// Epochs of `segments`, V: signals are filtered part by part, cut, freed of eye movements, interpolated where asked, referred, and rejected,
/// in this order. No epoch crosses a gap.
///
/// Source: the order of steps of MNE-Python's tutorials; each step has its own.
///
/// # Errors
/// [`PrepareError`] for channels that do not exist, are flat or at a limit, markers that do not exist, several tasks, fewer epochs of a condition
/// than asked for, and what the steps refuse.
pub fn prepare(segments: &[Segment<'_>], config: &PrepareConfig) -> Result<Prepared, PrepareError> {
    prepare_at(segments, config, None)
}

/// As [`prepare`], with interpolation at measured positions.
///
/// Source: as [`prepare`].
///
/// # Errors
/// Those of [`prepare`].
pub fn prepare_at(
    segments: &[Segment<'_>],
    config: &PrepareConfig,
    measured: Option<&Montage>,
) -> Result<Prepared, PrepareError> {
    something_passes(&config.filters)?;
    let mut signals = Signals::of(segments, config)?;
    let task = task_asked(segments, config.task.as_deref())?;
    let (marked, mut outside) = marked(segments, config, &task, &signals.starts)?;
    let mut warnings = warnings_of(segments);
    let marked = once(marked, &mut warnings);
    let unusable = unusable(segments, &signals);
    let all = marked.len();
    let (marked, within) = beside_unusable(marked, &unusable, signals.rate, &config.extent);
    if let (0, Some(first)) = (marked.len(), within.first()) {
        return Err(PrepareError::NoneUsable {
            markers: all,
            why: first.reason.to_string(),
        });
    }
    warnings.extend(lost_to_electrodes(&within, all));
    outside.extend(within);
    warnings.extend(signals.warnings.iter().cloned());
    warnings.extend(signals.apart());
    warnings.extend(filtered(&mut signals, &config.filters)?);
    let events: Vec<_> = marked.iter().map(|one| one.event.clone()).collect();
    let recording = Continuous {
        channels: &signals.names,
        rate: signals.rate,
        volts: &signals.volts,
        gaps: &signals.starts[1..],
    };
    let found = cut(&recording, &events, &config.extent)?;
    let not_cut = found.left_out.iter().map(|left| NotWhole {
        condition: left.condition.clone(),
        onset_s: marked[left.event].onset_s,
        reason: left.reason.clone(),
    });
    let mut not_whole: Vec<NotWhole> = not_cut.chain(outside.iter().cloned()).collect();
    not_whole.sort_by(|one, other| one.onset_s.total_cmp(&other.onset_s));
    let whole: Vec<f64> = (0..marked.len())
        .filter(|i| found.left_out.iter().all(|left| left.event != *i))
        .map(|i| marked[i].onset_s)
        .collect();
    let cleaned = without_eyes(&found.epochs, config, &signals.electrodes)?;
    let whole_cap = interpolated(cleaned, config, &signals.order, measured, &mut warnings)?;
    let epochs = referred(whole_cap, &config.reference)?;
    let (epochs, rejected) = rejected(epochs, config, &whole, &mut warnings)?;
    let is_kept = |onset_s: &&f64| rejected.iter().all(|one| one.onset_s != **onset_s);
    let onsets_s = whole.iter().filter(is_kept).copied().collect();
    let counts = EpochCounts {
        conditions: counted(config, (&events, &outside), &epochs, &rejected),
        not_whole,
        rejected,
    };
    enough(&counts, config.min_epochs)?;
    if config.reference == Reference::Average {
        warnings.extend(unknown_in_average(&epochs));
    }
    Ok(Prepared {
        config: config.clone(),
        task,
        epochs,
        onsets_s,
        counts,
        warnings,
    })
}

/// Refuses filters that leave nothing.
fn something_passes(filters: &[Pass]) -> Result<(), PrepareError> {
    let lows = filters.iter().filter_map(|pass| match pass {
        Pass::Above(hz) | Pass::Between(hz, _) => Some(*hz),
        _ => None,
    });
    let highs = filters.iter().filter_map(|pass| match pass {
        Pass::Below(hz) | Pass::Between(_, hz) => Some(*hz),
        _ => None,
    });
    match (lows.reduce(f64::max), highs.reduce(f64::min)) {
        (Some(high_pass_hz), Some(low_pass_hz)) if high_pass_hz >= low_pass_hz => {
            Err(PrepareError::NothingPasses {
                high_pass_hz,
                low_pass_hz,
            })
        }
        _ => Ok(()),
    }
}

/// The task whose epochs are taken; empty where the recording names none.
fn task_asked(segments: &[Segment<'_>], wanted: Option<&str>) -> Result<String, PrepareError> {
    let there = tasks(segments);
    let named = || there.join(", ");
    match (wanted, there.as_slice()) {
        (Some(wanted), []) => Ok(wanted.to_owned()),
        (Some(wanted), there) if there.iter().any(|task| task == wanted) => Ok(wanted.to_owned()),
        (Some(wanted), _) => Err(PrepareError::OtherTask {
            wanted: wanted.to_owned(),
            tasks: named(),
        }),
        (None, []) => Ok(String::new()),
        (None, [task]) => Ok(task.clone()),
        (None, _) => Err(PrepareError::SeveralTasks { tasks: named() }),
    }
}

/// The events that are asked for, in their order, on the samples of all parts joined; and those that lie outside their part, before it or in
/// the gap behind it.
fn marked(
    segments: &[Segment<'_>],
    config: &PrepareConfig,
    task: &str,
    starts: &[usize],
) -> Result<(Vec<Marked>, Vec<NotWhole>), PrepareError> {
    let there = || {
        let found = markers(segments);
        let found = found
            .iter()
            .map(|(name, count)| format!("{name} ({count})"));
        let found: Vec<String> = found.collect();
        match found.is_empty() {
            true => "no marker at all".to_owned(),
            false => found.join(", "),
        }
    };
    if config.markers.is_empty() {
        return Err(PrepareError::NoMarkerStated { found: there() });
    }
    let named = !tasks(segments).is_empty();
    if !named {
        one_task(segments, config, task)?;
    }
    let mut inside = !named;
    let mut seen = vec![[0; 2]; config.markers.len()];
    let (mut found, mut lost) = (Vec::new(), Vec::new());
    for (segment, start) in segments.iter().zip(starts) {
        let channels = segment.recording.channels().iter();
        let length = channels.map(|channel| channel.samples.len()).max();
        let length = length.unwrap_or_default() as i64;
        let mut events: Vec<_> = segment
            .recording
            .annotations
            .events
            .iter()
            .zip(segment.event_samples)
            .collect();
        events.sort_by_key(|(_, sample)| **sample);
        for (event, sample) in events {
            if named && let Some(begun) = task_of(event) {
                inside = begun == task;
            }
            let choice = config
                .markers
                .iter()
                .position(|choice| is_marker(event, &choice.marker));
            let Some(choice) = choice else { continue };
            seen[choice][usize::from(inside)] += 1;
            if !inside {
                continue;
            }
            let condition = config.markers[choice].condition_of(event);
            let onset_s = segment.start_s.0 + event.onset_s.0;
            let reason = match *sample {
                before if before < 0 => Some(NotCut::BeforeStart),
                behind if behind >= length => Some(NotCut::AfterEnd),
                _ => None,
            };
            match reason {
                None => found.push(Marked {
                    event: super::epochs::Event {
                        sample: *start + *sample as usize,
                        condition,
                    },
                    onset_s,
                }),
                Some(reason) => lost.push(NotWhole {
                    condition,
                    onset_s,
                    reason,
                }),
            }
        }
    }
    for (choice, [outside, inside]) in config.markers.iter().zip(seen) {
        let wanted = choice.marker.clone();
        match (outside, inside) {
            (_, 1..) => {}
            (0, _) => {
                return Err(PrepareError::NoMarker {
                    wanted,
                    found: there(),
                });
            }
            _ => {
                return Err(PrepareError::NoMarkerInTask {
                    wanted,
                    task: task.to_owned(),
                });
            }
        }
    }
    Ok((found, lost))
}

/// Kinds of markers that name the task themselves.
///
/// Source: docs/decisions/eeg.md.
const TASKS: [&str; 3] = ["natural", "control", "imagery"];

/// Refuses markers of several kinds under one value, and of another task than the one stated, in a file without markers of tasks.
fn one_task(
    segments: &[Segment<'_>],
    config: &PrepareConfig,
    task: &str,
) -> Result<(), PrepareError> {
    let mut known: Vec<String> = Vec::new();
    for choice in &config.markers {
        let all = segments
            .iter()
            .flat_map(|segment| &segment.recording.annotations.events);
        let own = all.filter(|event| is_marker(event, &choice.marker));
        let kinds: BTreeSet<&str> = own.map(|event| event.kind.trim()).collect();
        if kinds.len() > 1 {
            let names = kinds.iter().map(|kind| format!("{kind}/{}", choice.marker));
            return Err(PrepareError::SeveralKinds {
                wanted: choice.marker.clone(),
                found: names.collect::<Vec<_>>().join(", "),
            });
        }
        let of_tasks = kinds.iter().map(|kind| kind.to_lowercase());
        for kind in of_tasks.filter(|kind| TASKS.contains(&kind.as_str())) {
            if !known.contains(&kind) {
                known.push(kind);
            }
        }
    }
    let stated = task.to_lowercase();
    match known.as_slice() {
        [] => Ok(()),
        [one] if *one == stated || !TASKS.contains(&stated.as_str()) => Ok(()),
        [one] => Err(PrepareError::OtherTask {
            wanted: task.to_owned(),
            tasks: format!("markers of the task {one}"),
        }),
        _ => Err(PrepareError::SeveralTasks {
            tasks: known.join(", "),
        }),
    }
}

/// Filters each part by itself, and returns warnings.
fn filtered(signals: &mut Signals, filters: &[Pass]) -> Result<Vec<Warning>, PrepareError> {
    let mut warnings = Vec::new();
    for pass in filters {
        let filter = Fir::plan(pass, signals.rate)?;
        let shortest = signals.parts().map(|part| part.len()).min();
        warnings.extend(filter.warnings(shortest.unwrap_or_default()));
        let parts: Vec<_> = signals.parts().collect();
        let length = signals.length;
        for signal in signals.volts.chunks_exact_mut(length) {
            for part in &parts {
                let own = &mut signal[part.clone()];
                own.copy_from_slice(&filter.apply(own));
            }
        }
    }
    Ok(warnings)
}

/// `epochs` of the electrodes named, without eye movements where EOG channels are stated.
fn without_eyes(
    epochs: &Epochs,
    config: &PrepareConfig,
    electrodes: &[String],
) -> Result<Epochs, PrepareError> {
    let names: Vec<&str> = electrodes.iter().map(String::as_str).collect();
    if config.eog.is_empty() {
        return Ok(epochs.picked(&names)?);
    }
    let eog: Vec<&str> = config.eog.iter().map(String::as_str).collect();
    let regression = EogRegression::fit(epochs, &eog, &names)?;
    Ok(regression.apply(epochs)?.picked(&names)?)
}

/// Epochs against a reference.
fn referred(epochs: Epochs, reference: &Reference) -> Result<Epochs, PrepareError> {
    Ok(match reference {
        Reference::AsRecorded => epochs,
        Reference::Average => average(&epochs),
        Reference::Channels(references) => {
            let references: Vec<&str> = references.iter().map(String::as_str).collect();
            let found = to_channels(&epochs, &references)?;
            match references[..] {
                // It would be 0 at every sample.
                [reference] => {
                    let names = epochs.channels().iter().map(String::as_str);
                    let others: Vec<&str> = names.filter(|name| *name != reference).collect();
                    found.picked(&others)?
                }
                _ => found,
            }
        }
    })
}

/// The epochs that no criterion rejects, and the others; `onsets` are those of the markers of `epochs`.
fn rejected(
    epochs: Epochs,
    config: &PrepareConfig,
    onsets: &[f64],
    warnings: &mut Vec<Warning>,
) -> Result<(Epochs, Vec<RejectedEpoch>), PrepareError> {
    if config.criteria.is_empty() {
        return Ok((epochs, Vec::new()));
    }
    let looked: Vec<&str> = epochs.channels().iter().map(String::as_str).collect();
    let found = reject(&epochs, &looked, &config.criteria)?;
    warnings.extend(found.warnings);
    let rejected = found.rejected.into_iter().map(|one| RejectedEpoch {
        condition: one.condition,
        onset_s: onsets[one.epoch],
        channel: one.channel,
        channels: one.channels,
        criterion: one.criterion,
        found_v: one.found_v,
    });
    Ok((found.epochs, rejected.collect()))
}

/// How many epochs of each condition there are.
fn counted(
    config: &PrepareConfig,
    (events, outside): (&[super::epochs::Event], &[NotWhole]),
    epochs: &Epochs,
    rejected: &[RejectedEpoch],
) -> Vec<ConditionCount> {
    // In the order of the markers that were asked for; the values of one kind in their own.
    let of_parts = events.iter().map(|event| &event.condition);
    let mut own: Vec<&String> = of_parts
        .chain(outside.iter().map(|event| &event.condition))
        .collect();
    own.sort();
    let asked = config.markers.iter().map(|choice| &choice.condition);
    let asked = asked.filter(|condition| own.contains(condition));
    let mut conditions: Vec<&String> = Vec::new();
    for condition in asked.chain(own.clone()) {
        if !conditions.contains(&condition) {
            conditions.push(condition);
        }
    }
    let mut kept = BTreeMap::<&str, usize>::new();
    for condition in epochs.conditions() {
        *kept.entry(condition).or_default() += 1;
    }
    let of = |condition: &String| {
        let markers = events.iter().filter(|e| e.condition == *condition).count()
            + outside.iter().filter(|e| e.condition == *condition).count();
        let rejected = rejected
            .iter()
            .filter(|e| e.condition == *condition)
            .count();
        let kept = kept.get(condition.as_str()).copied().unwrap_or_default();
        ConditionCount {
            condition: condition.clone(),
            markers,
            kept,
            rejected,
            left_out: markers - rejected - kept,
        }
    };
    conditions.into_iter().map(of).collect()
}

fn enough(counts: &EpochCounts, needed: usize) -> Result<(), PrepareError> {
    let why = |condition: &String| {
        let mut lost = counts.not_whole.iter();
        let first = lost.find(|one| one.condition == *condition)?;
        Some(format!("; of the first left out, {}", first.reason))
    };
    match counts
        .conditions
        .iter()
        .find(|count| count.kept < needed.max(1))
    {
        None => Ok(()),
        Some(few) => Err(PrepareError::FewEpochs {
            condition: few.condition.clone(),
            found: few.kept,
            needed: needed.max(1),
            rejected: few.rejected,
            left_out: few.left_out,
            why: why(&few.condition).unwrap_or_default(),
        }),
    }
}

impl Prepared {
    /// The rate of the epochs.
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        self.epochs.rate()
    }
}

#[cfg(test)]
mod cap_tests;
#[cfg(test)]
mod tests;
