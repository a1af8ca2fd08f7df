//! The content of an EEG file before it is cut at its gaps.

use std::collections::BTreeMap;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::{
    BenchKind, Channel, Clock, Condition, Event, EventValue, Losses, NotUsed, Provenance,
    Recording, RecordingWarning, StartTime,
};

use super::{EegFile, EegKind, EegSegment, unique_names};
use crate::error::ReadError;

/// Where an event stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// At a sample of the fastest channel, counted over all that is stored. It may lie between two samples.
    Sample(f64),
    /// At a time from the first sample of the file, s.
    Time(f64),
}

/// An event of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Marked {
    pub(super) place: Place,
    pub(super) duration_s: f64,
    pub(super) kind: String,
    pub(super) value: Option<EventValue>,
}

/// A part without a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// The unit of storage (a sample, a record) that it begins with.
    pub(super) from: usize,
    /// The time of its first sample from the first sample of the file, s.
    pub(super) start_s: f64,
}

/// One channel with all its samples, gaps closed.
pub(super) struct Line {
    pub(super) channel: Channel,
    pub(super) rate: SampleRate,
    /// Samples in one unit of storage.
    pub(super) per_unit: usize,
    /// The unit as the file writes it.
    pub(super) stated_unit: String,
}

/// All that a file holds.
pub(super) struct Content {
    pub(super) kind: EegKind,
    pub(super) lines: Vec<Line>,
    /// Parts in the order of storage; the first begins with unit 0.
    pub(super) parts: Vec<Part>,
    pub(super) events: Vec<Marked>,
    pub(super) started_at: Option<StartTime>,
    pub(super) warnings: Vec<Warning>,
    /// What the file lacks of its run.
    pub(super) losses: Losses,
    /// The bench, where the file says that no person took part.
    pub(super) bench: Option<BenchKind>,
}

/// The index of the sample nearest to a time, halves to the even one.
fn nearest(sample: f64) -> i64 {
    // Beyond the range of i64 the conversion ends at its limits.
    sample.round_ties_even() as i64
}

impl Content {
    /// The file, cut at its gaps.
    pub(super) fn into_file(mut self, path: &Path) -> Result<EegFile, ReadError> {
        let mut names: Vec<String> = self.lines.iter().map(|l| l.channel.name.clone()).collect();
        let renamed = unique_names(&mut names);
        if !renamed.is_empty() {
            self.warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "several channels are called {}, and a number was added to their names",
                    renamed.join(", ")
                ),
            }));
        }
        for (line, name) in self.lines.iter_mut().zip(names) {
            line.channel.name = name;
        }
        let fastest = self
            .lines
            .iter()
            .max_by(|a, b| a.rate.hz().total_cmp(&b.rate.hz()));
        let Some((rate, per_unit)) = fastest.map(|line| (line.rate, line.per_unit)) else {
            return Err(ReadError::content(
                path,
                "a channel with samples",
                "none",
                "check the export",
            ));
        };
        let stated = self.lines.iter_mut();
        let stated = stated.map(|line| {
            let unit = std::mem::take(&mut line.stated_unit);
            (line.channel.name.clone(), unit)
        });
        let stated_units: BTreeMap<String, String> =
            stated.filter(|(_, unit)| !unit.is_empty()).collect();
        let starts: Vec<usize> = self.parts.iter().map(|part| part.from).collect();
        let mut segments = Vec::with_capacity(self.parts.len());
        let of_parts = self.events_of_parts(rate, per_unit);
        for (number, (part, own)) in self.parts.iter().zip(of_parts).enumerate() {
            let next = starts.get(number + 1).copied();
            let (events, event_samples) = own.into_iter().unzip();
            let mut channels = Vec::with_capacity(self.lines.len());
            for line in &mut self.lines {
                let all = &mut line.channel.samples;
                let samples = match (number, next) {
                    (0, None) => std::mem::take(all),
                    _ => {
                        let at = |unit: usize| (unit * line.per_unit).min(all.len());
                        let end = next.map_or(all.len(), at);
                        all.get(at(part.from)..end).unwrap_or_default().to_vec()
                    }
                };
                let channel = Channel {
                    name: line.channel.name.clone(),
                    unit: line.channel.unit.clone(),
                    samples,
                };
                channels.push((channel, Clock::at(line.rate)));
            }
            let provenance = Provenance {
                source: path.display().to_string(),
                bench: self.bench,
                ..Provenance::default()
            };
            let mut recording = Recording::with_clocks(channels, Condition::default(), provenance)
                .map_err(ReadError::of(path))?;
            recording.annotations.started_at = self
                .started_at
                .as_ref()
                .map(|at| at.later(Seconds(part.start_s)));
            recording.annotations.events = events;
            // What is of the whole file stands once.
            if number == 0 {
                recording.about.warnings.clone_from(&self.warnings);
                let losses = &mut recording.about.provenance.losses;
                losses.clone_from(&self.losses);
            }
            let length_s = recording.duration();
            let outside = recording.annotations.outside(length_s);
            if let Some(first) = outside.first() {
                let warning = Warning::from(RecordingWarning::NotUsed {
                    what: NotUsed::Events {
                        count: outside.len(),
                        onset_s: first.onset_s.0,
                        lasts_s: first.duration_s.0,
                        length_s: length_s.0,
                    },
                });
                recording.about.warnings.push(warning);
            }
            segments.push(EegSegment {
                recording,
                start_s: Seconds(part.start_s),
                event_samples,
            });
        }
        Ok(EegFile {
            kind: self.kind,
            segments,
            positions: Vec::new(),
            stated_units,
        })
    }

    /// The events of each part with the indices of their samples: those from its start to the start of the next. The first part has those
    /// before it too.
    fn events_of_parts(&self, rate: SampleRate, per_unit: usize) -> Vec<Vec<(Event, i64)>> {
        // Half a sample of the fastest channel, so that an onset that was rounded when it was written stays in its part.
        let slack_s = 0.5 / rate.hz();
        let first_sample = |part: &Part| (part.from * per_unit) as f64;
        let part_of = |place: Place| {
            let begun = |part: &Part| match place {
                Place::Sample(sample) => first_sample(part) <= sample,
                Place::Time(time_s) => part.start_s <= time_s + slack_s,
            };
            self.parts.iter().rposition(begun).unwrap_or(0)
        };
        let mut found = vec![Vec::new(); self.parts.len()];
        for event in &self.events {
            let number = part_of(event.place);
            let part = &self.parts[number];
            let (onset_s, sample) = match event.place {
                Place::Sample(sample) => {
                    let first = first_sample(part);
                    // Rounded before the part is counted from its start: which sample it is does not depend on gaps.
                    let own = nearest(sample) - nearest(first);
                    ((sample - first) / rate.hz(), own)
                }
                Place::Time(time_s) => {
                    let onset_s = time_s - part.start_s;
                    (onset_s, nearest(onset_s * rate.hz()))
                }
            };
            let event = Event {
                onset_s: Seconds(onset_s),
                duration_s: Seconds(event.duration_s),
                kind: event.kind.clone(),
                value: event.value.clone(),
            };
            found[number].push((event, sample));
        }
        found
    }
}
