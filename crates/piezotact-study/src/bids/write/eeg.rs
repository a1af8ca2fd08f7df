//! EEG: `BrainVision` files with their sidecars, channels, events and template positions.

use std::collections::BTreeMap;

use piezotact::page::{Cell, Column, Table};
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{BenchKind, EventValue, Recording};
use piezotact_people::campaign::dictionary::columns_of;
use piezotact_people::eeg::reference::Montage;
use serde_json::json;

use super::super::error::BidsError;
use super::super::json::unit_text;
use super::super::name::Entities;
use super::super::privacy::carried;
use super::super::table::tsv_text;
use super::super::{NOTHING, PROGRAM};
use super::parts::{is_marker, is_no_date, kind_carried, sidecars, unit_carried};
use super::{Began, BidsWriter};
use piezotact_dataset::eeg::{ChannelRow, markers_of, write_brainvision};

/// The radius of the head on which template positions stand, in m.
///
/// Source: the sphere of MNE-Python.
const HEAD_M: f64 = 0.095;

/// One EEG recording, or one of its parts between two gaps, with what is known of it.
#[derive(Clone, Debug)]
pub struct Brain<'a> {
    pub participant: &'a str,
    /// The session, by its name in the protocol.
    pub session: &'a str,
    pub task: &'a str,
    /// The recording, channels in V.
    pub recording: Recording,
    /// What a table beside the file states of its channels; may be empty.
    pub channels: &'a [ChannelRow],
    /// What the laboratory states of it.
    pub about: &'a BrainAbout,
}

/// What a laboratory states of its EEG recordings, as no file format holds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BrainAbout {
    /// The reference of the electrodes, in words; absent where it is not known.
    pub reference: Option<String>,
    /// The frequency of the mains, in Hz; absent where it is not known.
    pub line_hz: Option<f64>,
}

/// The type of a channel in BIDS.
///
/// Source: BIDS 1.11, EEG, `*_channels.tsv`.
pub(in super::super) fn channel_type(name: &str, unit: &Unit) -> &'static str {
    let upper = name.to_uppercase();
    let begins = |words: &[&str]| words.iter().any(|word| upper.starts_with(word));
    match unit {
        _ if begins(&["VEOG"]) => "VEOG",
        _ if begins(&["HEOG"]) => "HEOG",
        _ if begins(&["EOG"]) => "EOG",
        _ if begins(&["ECG", "EKG"]) => "ECG",
        _ if begins(&["EMG"]) => "EMG",
        _ if begins(&["TRIG", "STATUS", "STIM", "STI "]) => "TRIG",
        Unit::Volt => "EEG",
        _ => "MISC",
    }
}

impl BidsWriter<'_> {
    /// Adds an EEG recording.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn eeg(&mut self, brain: Brain<'_>) -> Result<(), BidsError> {
        let mut of = self.entities(brain.participant, Some(brain.session), brain.task)?;
        let run = self.brain_runs.entry(of.clone()).or_default();
        *run += 1;
        of.run = Some(*run);
        let started = brain.recording.annotations.started_at.clone();
        let time = started.map(Began::Start);
        let mut recording = brain.recording.clone();
        // The header would state the true date.
        recording.annotations.started_at = None;
        recording.annotations.labels.clear();
        let bench = recording.about.provenance.bench;
        // A file begins with a segment, and each has its own.
        let events = &mut recording.annotations.events;
        let lasts_s = brain.recording.duration().0;
        events.retain(|event| {
            // One outside the samples, of which a warning of the reader tells, is none of this recording.
            let is_within = (0.0..=lasts_s).contains(&event.onset_s.0);
            is_within && event.kind != "New Segment"
        });
        for event in events {
            event.value = event
                .value
                .take()
                .and_then(|value| value_carried(value, bench));
            event.kind = kind_carried(&event.kind, bench);
        }
        recording.restate_units(unit_carried);
        if bench.is_none() {
            let channels = recording.channels().iter();
            self.note_words("channel", channels.map(|channel| channel.name.as_str()));
            let events = recording.annotations.events.iter();
            let texts = events.flat_map(|event| match &event.value {
                Some(EventValue::Text(text)) => vec![event.kind.as_str(), text.as_str()],
                _ => vec![event.kind.as_str()],
            });
            self.note_words("event", texts);
        }
        let header = of.file_in("eeg", "eeg", "vhdr");
        let path = self.folder.path(&header)?;
        // What the format does not hold stands beside it, or in the list of what is not carried.
        let _said = write_brainvision(&path, &recording, &markers_of(&recording))?;
        for ending in ["vhdr", "eeg", "vmrk"] {
            self.folder.adopt(&of.file_in("eeg", "eeg", ending))?;
        }
        self.eeg_sidecars(&brain, &of, &recording)?;
        self.eeg_positions(&of, &recording)?;
        let key = (brain.participant.to_owned(), Some(brain.session.to_owned()));
        let name = header
            .trim_start_matches(&of.folder())
            .trim_start_matches('/');
        let scans = self.scans.entry(key).or_default();
        scans.push((name.to_owned(), time));
        self.brains += 1;
        Ok(())
    }

    /// What stands beside the samples: the recording, its channels, its events.
    fn eeg_sidecars(
        &mut self,
        brain: &Brain<'_>,
        of: &Entities,
        recording: &Recording,
    ) -> Result<(), BidsError> {
        let rate_hz = recording.rate().hz();
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        let states = brain.channels.iter().any(|row| row.status.is_some());
        let status = states.then_some("status");
        let columns = ["name", "type", "units", "sampling_frequency"];
        let mut channels = table(&columns.into_iter().chain(status).collect::<Vec<_>>());
        for channel in recording.channels() {
            let kind = channel_type(&channel.name, &channel.unit);
            *counts.entry(kind).or_default() += 1;
            channels.rows.push(vec![
                Cell::from(channel.name.as_str()),
                Cell::from(kind),
                Cell::from(match &channel.unit {
                    // As in the file of samples.
                    Unit::Volt => "µV".to_owned(),
                    other => unit_text(other),
                }),
                Cell::from(rate_hz),
            ]);
            let row = brain.channels.iter().find(|row| row.name == channel.name);
            if let (true, Some(cells)) = (states, channels.rows.last_mut()) {
                // An empty text is written as n/a.
                let status = row.and_then(|row| row.status.clone()).unwrap_or_default();
                cells.push(Cell::Text(status.to_lowercase()));
            }
        }
        let file = of.file_in("eeg", "channels", "tsv");
        self.folder.put_text(&file, &tsv_text(&channels, &file)?)?;
        let count = |kinds: &[&str]| {
            kinds
                .iter()
                .filter_map(|kind| counts.get(kind))
                .sum::<usize>()
        };
        // Other fields than those of BIDS are an error of its older validator.
        let made_by = match &recording.about.provenance.bench {
            Some(BenchKind::Hardware) | None => NOTHING.to_owned(),
            Some(_) => format!("simulated by {PROGRAM}: nobody was recorded"),
        };
        let sidecar = json!({
            "TaskName": brain.task,
            "SamplingFrequency": rate_hz,
            "EEGReference": brain.about.reference.as_deref().unwrap_or(NOTHING),
            "PowerLineFrequency": brain.about.line_hz.map_or_else(|| json!(NOTHING), |hz| json!(hz)),
            "SoftwareFilters": NOTHING,
            "RecordingType": "continuous",
            "RecordingDuration": recording.len() as f64 / rate_hz,
            "EEGChannelCount": count(&["EEG"]),
            "EOGChannelCount": count(&["EOG", "VEOG", "HEOG"]),
            "ECGChannelCount": count(&["ECG"]),
            "EMGChannelCount": count(&["EMG"]),
            "MiscChannelCount": count(&["MISC"]),
            "TriggerChannelCount": count(&["TRIG"]),
            "Manufacturer": made_by,
        });
        self.folder
            .put_json(&of.file_in("eeg", "eeg", "json"), &sidecar)?;
        if recording.annotations.events.is_empty() {
            return Ok(());
        }
        self.eeg_events(of, recording)
    }

    fn eeg_events(&mut self, of: &Entities, recording: &Recording) -> Result<(), BidsError> {
        let mut events = table(&["onset", "duration", "trial_type", "value", "sample"]);
        for event in &recording.annotations.events {
            let value = match &event.value {
                None => Cell::Missing(()),
                Some(EventValue::Number(number)) => Cell::from(*number),
                Some(EventValue::Text(text)) => Cell::from(text.as_str()),
            };
            let Seconds(onset_s) = event.onset_s;
            events.rows.push(vec![
                Cell::from(onset_s),
                Cell::from(event.duration_s.0),
                Cell::from(event.kind.as_str()),
                value,
                Cell::from((onset_s * recording.rate().hz()).round_ties_even()),
            ]);
        }
        let file = of.file_in("eeg", "events", "tsv");
        self.folder.put_text(&file, &tsv_text(&events, &file)?)?;
        let columns = sidecars(&columns_of("eeg_events"));
        self.folder
            .put_json(&of.file_in("eeg", "events", "json"), &columns)
    }

    /// Template positions of the electrodes whose names have one, once for a session.
    fn eeg_positions(&mut self, of: &Entities, recording: &Recording) -> Result<(), BidsError> {
        let of = Entities {
            task: None,
            run: None,
            ..of.clone()
        };
        let file = of.file_in("eeg", "electrodes", "tsv");
        if self.folder.holds(&file) {
            return Ok(());
        }
        let mut electrodes = table(&["name", "x", "y", "z"]);
        let own = recording.channels().iter();
        let own = own.filter(|channel| channel_type(&channel.name, &channel.unit) == "EEG");
        let names: Vec<String> = own.map(|channel| channel.name.clone()).collect();
        for (name, position) in names.iter().zip(Montage::known(&names)) {
            let mut row = vec![Cell::from(name.as_str())];
            for axis in 0..3 {
                row.push(Cell::from(position.map(|position| position[axis] * HEAD_M)));
            }
            electrodes.rows.push(row);
        }
        let has_one = |row: &Vec<Cell>| matches!(row[1], Cell::Number(_));
        if !electrodes.rows.iter().any(has_one) {
            return Ok(());
        }
        self.folder
            .put_text(&file, &tsv_text(&electrodes, &file)?)?;
        let space = json!({
            "EEGCoordinateSystem": "Other",
            "EEGCoordinateSystemDescription": format!(
                "{PROGRAM}: template positions of the extended 10-20 system on a sphere, not measured; x to the right, y to the front, z up, from the centre of the head."
            ),
            "EEGCoordinateUnits": "m",
        });
        self.folder
            .put_json(&of.file_in("eeg", "coordsystem", "json"), &space)
    }
}

/// The value of an event as it may be carried: numbers and the codes of markers of any file, words of our own benches.
fn value_carried(value: EventValue, bench: Option<BenchKind>) -> Option<EventValue> {
    match value {
        EventValue::Text(text) => {
            let text = carried(&text)?;
            (bench.is_some() || is_marker(&text)).then_some(EventValue::Text(text))
        }
        EventValue::Number(number) => {
            (bench.is_some() || is_no_date(number)).then_some(EventValue::Number(number))
        }
    }
}

fn table(names: &[&str]) -> Table {
    Table::new(names.iter().map(|name| Column::new(name, name)))
}
