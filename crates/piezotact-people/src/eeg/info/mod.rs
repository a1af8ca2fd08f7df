//! What a file of EEG holds, before anything is computed of it.

mod mains;
mod page;

use std::collections::BTreeMap;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::integrity::{Defects, inspect_samples, never_changes};
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{Channel, StartTime};
use serde::{Deserialize, Serialize};

use super::held::held;
use super::pulses::SharedClock;
use super::quality;
use super::reference::Montage;
use super::source::{Segment, SignalKind, events, marker_name, tasks, warnings_of};
use super::{EegWarning, LeftOutElectrodes};

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ChannelInfo {
    /// Its name.
    pub name: String,
    /// What it records, by its name and unit.
    pub kind: SignalKind,
    /// The SI unit of its samples.
    pub unit: Unit,
    /// Its rate.
    pub rate_hz: SampleRate,
    /// Whether its name has a built-in position on the scalp.
    pub positioned: bool,
    /// Whether a table beside the file calls it bad.
    pub bad: bool,
    /// Whether it never changes.
    pub flat: bool,
    /// The share of samples at a limit, 0–1.
    pub saturated_share: f64,
    /// The share of samples in which it holds one value for 0.2 s or more, 0–1; 0 of a channel that never changes.
    pub frozen_share: f64,
    /// The share of samples that are no finite numbers, 0–1.
    pub missing_share: f64,
    /// The standard deviation of its samples over all parts, in its unit.
    pub spread: f64,
    /// The frequency of the mains in its longest part, Hz; absent where none stands out, or the part is shorter than 8 s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mains_hz: Option<f64>,
    /// The share of the mains in its power, 0–1; 0 where none stands out.
    pub mains_share: f64,
}

/// One part without a gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PartInfo {
    /// When it begins, from the first sample of the file.
    pub start_s: Seconds,
    /// How long it lasts.
    pub duration_s: Seconds,
    /// How long nothing was recorded before it.
    pub gap_before_s: Seconds,
}

/// Markers of one name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MarkerCount {
    /// The name: kind and value.
    pub marker: String,
    /// How many.
    pub count: usize,
    /// The first, from the first sample of the file.
    pub first_s: Seconds,
    /// The last.
    pub last_s: Seconds,
}

/// What a file of EEG holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EegInfo {
    /// The file.
    pub file: String,
    /// Its kind: "EDF+".
    pub kind: String,
    /// When it was begun, if it says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub started_at: Option<StartTime>,
    /// The channels, in the order of the file.
    pub channels: Vec<ChannelInfo>,
    /// The parts without a gap.
    pub parts: Vec<PartInfo>,
    /// Markers by name.
    pub markers: Vec<MarkerCount>,
    /// The tasks that markers name.
    pub tasks: Vec<String>,
    /// How the clock of another file runs against this one, where pulses of both were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<SharedClock>,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for EegInfo {
    const SCHEMA: &'static str = "eeg_info";
}

/// What `segments` of the file called `file` hold: channels with their state, parts, markers; samples in SI, times in s.
///
/// Source: each column has its own ([`inspect_samples`] for flat, saturated and frozen signals and the mains).
///
/// # Errors
/// None; a file without a segment has no channel.
#[must_use]
pub fn info(file: &str, kind: &str, segments: &[Segment<'_>]) -> EegInfo {
    let first_of = segments.first();
    let first = first_of.map(|segment| segment.recording);
    let channels = segments
        .first()
        .map_or_else(Vec::new, |first| channels(first, segments));
    EegInfo {
        file: file.to_owned(),
        kind: kind.to_owned(),
        started_at: first.and_then(|r| r.annotations.started_at.clone()),
        channels,
        parts: parts(segments),
        markers: marker_counts(segments),
        tasks: tasks(segments),
        clock: None,
        warnings: [
            warnings_of(segments),
            in_other_units(first_of),
            apart(segments),
        ]
        .concat(),
    }
}

/// The warnings about channels that are called as electrodes and are in none of their units.
fn in_other_units(first: Option<&Segment<'_>>) -> Vec<Warning> {
    let found = first.map(Segment::electrodes_in_other_units);
    let warning = |(unit, names): (String, Vec<String>)| {
        let why = LeftOutElectrodes::NotInVolts { unit };
        let names = names.join(", ");
        Warning::from(EegWarning::ElectrodesLeftOut { names, why })
    };
    found.into_iter().flatten().map(warning).collect()
}

/// The warnings about electrodes that stand apart from the others, in the longest part; none where they have different rates.
fn apart(segments: &[Segment<'_>]) -> Vec<Warning> {
    let longest = segments.iter().max_by(|a, b| {
        a.recording
            .duration()
            .0
            .total_cmp(&b.recording.duration().0)
    });
    let Some(longest) = longest else {
        return Vec::new();
    };
    let is_electrode = |channel: &Channel| {
        longest.kind_of(&channel.name, &channel.unit) == SignalKind::Eeg
            && !longest.is_bad(&channel.name)
            && !never_changes(&channel.samples)
    };
    let all = longest.recording.channels_with_clocks();
    let own: Vec<_> = all.filter(|(channel, _)| is_electrode(channel)).collect();
    let Some((_, clock)) = own.first() else {
        return Vec::new();
    };
    if own.iter().any(|(_, other)| other.rate_hz != clock.rate_hz) {
        return Vec::new();
    }
    let names: Vec<String> = own.iter().map(|(one, _)| one.name.clone()).collect();
    let signals: Vec<&[f64]> = own.iter().map(|(one, _)| one.samples.as_slice()).collect();
    quality::warnings(&names, &signals, clock.rate_hz)
}

fn channels(first: &Segment<'_>, segments: &[Segment<'_>]) -> Vec<ChannelInfo> {
    let own = first.recording.channels();
    let names: Vec<String> = own.iter().map(|channel| channel.name.clone()).collect();
    let known = Montage::known(&names);
    let channels = first.recording.channels_with_clocks().zip(known);
    let of = channels
        .enumerate()
        .map(|(number, ((channel, clock), known))| {
            let parts: Vec<&[f64]> = segments
                .iter()
                .filter_map(|part| part.recording.channels().get(number))
                .map(|channel| channel.samples.as_slice())
                .collect();
            let kind = first.kind_of(&channel.name, &channel.unit);
            ChannelInfo {
                positioned: known.is_some(),
                bad: first.is_bad(&channel.name),
                ..channel_info(channel, kind, clock.rate_hz, &parts)
            }
        });
    of.collect()
}

fn channel_info(
    channel: &Channel,
    kind: SignalKind,
    rate: SampleRate,
    parts: &[&[f64]],
) -> ChannelInfo {
    let (name, unit) = (&channel.name, &channel.unit);
    let found: Vec<Defects> = parts
        .iter()
        .filter(|part| !part.is_empty())
        .map(|part| inspect_samples(part, rate, unit))
        .collect();
    let all = found.iter().map(|part| part.samples).sum::<usize>().max(1) as f64;
    let share = |of: &dyn Fn(&Defects) -> f64| {
        let weighted = found.iter().map(|part| of(part) * part.samples as f64);
        weighted.sum::<f64>() / all
    };
    let longest = found.iter().max_by_key(|part| part.samples);
    let hum = longest.and_then(|part| part.hum.as_ref());
    let hum = hum.map(|hum| (hum.mains_hz, hum.share));
    let longest = parts.iter().max_by_key(|part| part.len());
    let mains = hum.or_else(|| mains::line(longest?, rate));
    let values = || parts.iter().flat_map(|part| part.iter().copied());
    let mean = values().sum::<f64>() / all;
    let squares: f64 = values().map(|v| (v - mean) * (v - mean)).sum();
    ChannelInfo {
        name: name.to_owned(),
        kind,
        unit: unit.clone(),
        rate_hz: rate,
        positioned: false,
        bad: false,
        flat: kind != SignalKind::Trigger && found.iter().all(|part| part.dead),
        // Codes of triggers hold their values.
        saturated_share: match kind {
            SignalKind::Trigger => 0.0,
            _ => share(&|part| part.clipped_fraction),
        },
        frozen_share: match kind {
            SignalKind::Trigger => 0.0,
            _ if found.iter().all(|part| part.dead) => 0.0,
            _ => {
                let held = parts.iter().flat_map(|part| held(part, rate));
                held.map(|part| part.len()).sum::<usize>() as f64 / all
            }
        },
        missing_share: values().filter(|value| !value.is_finite()).count() as f64 / all,
        spread: (squares / all).sqrt(),
        mains_hz: mains.map(|(hz, _)| hz),
        mains_share: mains.map_or(0.0, |(_, share)| share),
    }
}

fn parts(segments: &[Segment<'_>]) -> Vec<PartInfo> {
    let mut ended_s = 0.0;
    segments
        .iter()
        .map(|segment| {
            let (start_s, duration_s) = (segment.start_s.0, segment.recording.duration().0);
            let gap_s = (start_s - ended_s).max(0.0);
            ended_s = start_s + duration_s;
            PartInfo {
                start_s: Seconds(start_s),
                duration_s: Seconds(duration_s),
                // Less is rounding.
                gap_before_s: Seconds(if gap_s < 1e-6 { 0.0 } else { gap_s }),
            }
        })
        .collect()
}

fn marker_counts(segments: &[Segment<'_>]) -> Vec<MarkerCount> {
    let mut found = BTreeMap::<String, MarkerCount>::new();
    for segment in segments {
        for event in events(std::slice::from_ref(segment)) {
            let at_s = Seconds(segment.start_s.0 + event.onset_s.0);
            let marker = marker_name(event);
            let count = found.entry(marker.clone()).or_insert(MarkerCount {
                marker,
                count: 0,
                first_s: at_s,
                last_s: at_s,
            });
            count.count += 1;
            count.first_s.0 = count.first_s.0.min(at_s.0);
            count.last_s.0 = count.last_s.0.max(at_s.0);
        }
    }
    found.into_values().collect()
}

impl EegInfo {
    /// The electrodes.
    pub fn electrodes(&self) -> impl Iterator<Item = &ChannelInfo> {
        self.channels.iter().filter(|c| c.kind == SignalKind::Eeg)
    }

    /// The same with how the clock of another file runs.
    #[must_use]
    pub fn with_clock(mut self, clock: SharedClock) -> Self {
        self.warnings.extend(clock.warnings.iter().cloned());
        self.clock = Some(clock);
        self
    }
}

#[cfg(test)]
mod tests {
    use piezotact::page::Shown as _;

    use super::*;
    use piezotact::recording::{Condition, Event, EventValue, Provenance, Recording};

    #[test]
    fn a_file_says_what_it_holds() {
        let rate = SampleRate::new(250.0).unwrap();
        let wave = |i: usize| {
            let t = i as f64 / 250.0;
            1e-5 * (63.0 * t).sin() + 3e-6 * ((i * 7919) % 101) as f64 / 101.0
        };
        let channel = |name: &str, samples: Vec<f64>| Channel {
            name: name.into(),
            unit: Unit::Volt,
            samples,
        };
        let mains =
            |i: usize| wave(i) + 5e-5 * (std::f64::consts::TAU * 50.0 * i as f64 / 250.0).sin();
        let recording = |count: usize| {
            let channels = vec![
                channel("C3", (0..count).map(wave).collect()),
                channel("Cz", vec![0.0; count]),
                channel("E1", (0..count).map(mains).collect()),
                channel("C4", (0..count).map(|i| wave(i).min(7e-6)).collect()),
            ];
            let mut made =
                Recording::new(channels, rate, Condition::default(), Provenance::default())
                    .unwrap();
            made.annotations.events = vec![Event {
                onset_s: Seconds(1.0),
                duration_s: Seconds(0.0),
                kind: "Stimulus".into(),
                value: Some(EventValue::Text("S  1".into())),
            }];
            made
        };
        let two = [recording(5000), recording(2500)];
        let segment = |i: usize| Segment {
            recording: &two[i],
            start_s: Seconds(25.0 * i as f64),
            event_samples: &[250],
            stated: &[],
        };
        let found = info("a.vhdr", "BrainVision", &[segment(0), segment(1)]);
        let flat: Vec<bool> = found.channels.iter().map(|c| c.flat).collect();
        assert_eq!(flat, [false, true, false, false]);
        let mains: Vec<Option<f64>> = found.channels.iter().map(|c| c.mains_hz).collect();
        assert_eq!(mains, [None, None, Some(50.0), None]);
        assert!(found.channels[2].mains_share > 0.9);
        assert!(
            found.channels[3].saturated_share > 0.1 && found.channels[0].saturated_share == 0.0
        );
        let positioned: Vec<bool> = found.channels.iter().map(|c| c.positioned).collect();
        assert_eq!(positioned, [true, true, false, true]);
        assert!(
            (found.parts[1].gap_before_s.0 - 5.0).abs() < 1e-9
                && found.parts[0].gap_before_s.0 == 0.0
        );
        let marker = &found.markers[0];
        assert_eq!(
            (marker.count, marker.first_s.0, marker.last_s.0),
            (2, 1.0, 26.0)
        );
        assert_eq!(marker.marker, "Stimulus/S 1");
        assert!(
            found.sentence().contains("4 electrodes"),
            "{}",
            found.sentence()
        );
        let page = found.page();
        assert!(page.sections.len() >= 4);
    }
}
