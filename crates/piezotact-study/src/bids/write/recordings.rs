//! Recordings of touch: signals with their sidecars, events and originals.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use piezotact::page::{Cell, Table};
use piezotact::recording::{Channel, Clock, Recording};

use super::super::error::BidsError;
use super::super::json::{ColumnSidecar, SignalSidecar, channel_meaning};
use super::super::name::{Entities, STIM};
use super::super::physio::write_signals;
use super::super::privacy::{carried, warnings_carried, without_folders};
use super::super::table::tsv_text;
use super::parts::{
    DRIVE, column_names, events_carried, groups, is_of_a_bench, names_carried, suffix_number,
};
use super::{Began, BidsWriter, SAMPLE};

/// One recording with what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Touched<'a> {
    pub participant: &'a str,
    /// The session, by its name in the protocol; absent without a campaign.
    pub session: Option<&'a str>,
    pub task: &'a str,
    /// The sample or stimulus; absent where none is stated.
    pub sample: Option<&'a str>,
    /// The recording, with the condition that counts.
    pub recording: &'a Recording,
    /// When it began, in ms since 1970-01-01 00:00 UTC, where the recording does not state it.
    pub at_ms: Option<i64>,
    /// What happened in it, in the columns of [`piezotact::study::events_table`].
    pub events: Option<&'a Table>,
    /// The file that it was read from.
    pub file: &'a Path,
    /// Who named the run.
    pub named_by: NamedBy,
}

/// Who gave a run its label, which is the first step of its provenance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedBy {
    /// The session of the study.
    Session,
    /// Whoever recorded it: the label may say anything.
    Person,
}

/// The label of a run that nobody named.
const NO_LABEL: &str = "record";

impl BidsWriter<'_> {
    /// Adds a recording; gives the name of its first file re the folder of the session.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn recording(&mut self, touched: &Touched<'_>) -> Result<String, BidsError> {
        let mut of = self.entities(touched.participant, touched.session, touched.task)?;
        if let Some(sample) = touched.sample {
            of.acq = Some(self.labels[SAMPLE].label(sample)?);
        }
        let run = self.runs.entry(of.clone()).or_default();
        *run += 1;
        of.run = Some(*run);
        let started = touched.recording.annotations.started_at.clone();
        let time = match (started, touched.at_ms) {
            (Some(started), _) => Some(Began::Start(started)),
            (None, at_ms) => at_ms.map(Began::At),
        };
        let source = self.source(&of, touched)?;
        let mut first = None;
        for (label, clock, numbers) in groups(touched) {
            of.recording = Some(label.to_owned() + &suffix_number(&clock.1));
            let channels = touched.recording.channels();
            let of_group: Vec<&Channel> = numbers.iter().map(|at| &channels[*at]).collect();
            if !is_of_a_bench(touched) {
                let names = names_carried(&of_group);
                self.note_words("channel", names.iter().map(String::as_str));
            }
            let suffix = if label == DRIVE { STIM } else { "physio" };
            let data = of.file(suffix, "tsv.gz");
            self.folder.put(&data, |out| {
                write_signals(&of_group, out).map_err(BidsError::io(Path::new(&data)))
            })?;
            let sidecar = self.sidecar((touched, &source), &clock.0, (&numbers, &of_group), suffix);
            self.folder.put_json(&of.file(suffix, "json"), &sidecar)?;
            let name = self.scanned(touched, &of, &data, time.clone());
            first.get_or_insert(name);
        }
        of.recording = None;
        if let Some(events) = touched.events.filter(|events| !events.rows.is_empty()) {
            let events = &events_carried(events, touched);
            let at = events
                .columns
                .iter()
                .position(|one| one.name == "trial_type");
            let kinds = events.rows.iter().filter_map(|row| match &row[at?] {
                Cell::Text(kind) => Some(kind.clone()),
                _ => None,
            });
            let kinds: BTreeSet<String> = kinds.collect();
            if !is_of_a_bench(touched) {
                self.note_words("event", kinds.iter().map(String::as_str));
            }
            let known = self.kinds.entry(touched.task.to_owned()).or_default();
            known.extend(kinds);
            self.with_events.insert(touched.task.to_owned());
            let file = of.file("events", "tsv");
            self.folder.put_text(&file, &tsv_text(events, &file)?)?;
        }
        self.recordings += 1;
        Ok(first.unwrap_or_default())
    }

    /// Notes a data file of a session; gives its name re the folder of the session.
    fn scanned(
        &mut self,
        touched: &Touched<'_>,
        of: &Entities,
        file: &str,
        time: Option<Began>,
    ) -> String {
        let name = file
            .trim_start_matches(&of.folder())
            .trim_start_matches('/')
            .to_owned();
        let session = touched.session.map(str::to_owned);
        let key = (touched.participant.to_owned(), session);
        self.scans
            .entry(key)
            .or_default()
            .push((name.clone(), time));
        name
    }

    /// A copy of the file of a recording, bit by bit; its name from the root. None of a file that states a date,
    /// or of another program, whose header may.
    fn source(
        &mut self,
        of: &Entities,
        touched: &Touched<'_>,
    ) -> Result<Option<String>, BidsError> {
        let annotations = &touched.recording.annotations;
        let labelled = has_label(touched);
        let is_ours = touched
            .file
            .extension()
            .is_some_and(|end| end == "parquet" || end == "part");
        if annotations.started_at.is_some() || !is_of_a_bench(touched) || !is_ours || labelled {
            self.dated += 1;
            return Ok(None);
        }
        let ending = touched.file.extension().and_then(|ending| ending.to_str());
        let name = format!(
            "sourcedata/{}/{of}.{}",
            of.folder(),
            ending.unwrap_or("part").to_ascii_lowercase()
        );
        self.folder.copy(&name, touched.file)?;
        Ok(Some(name))
    }

    fn sidecar(
        &self,
        (touched, source): (&Touched<'_>, &Option<String>),
        clock: &Clock,
        (numbers, channels): (&[usize], &[&Channel]),
        suffix: &str,
    ) -> SignalSidecar {
        let about = &touched.recording.about;
        let mut provenance = about.provenance.clone();
        let mut labels = touched.recording.annotations.labels.clone();
        // Notes on files of other programs hold their names and dates.
        if !is_of_a_bench(touched) {
            provenance.source.clear();
            provenance.steps.clear();
            labels.clear();
        }
        if has_label(touched) {
            provenance.steps.remove(0);
        }
        provenance.source = without_folders(&provenance.source);
        provenance.steps = (provenance.steps.iter())
            .filter_map(|step| carried(step))
            .collect();
        labels.retain(|name, text| {
            let kept = carried(text);
            *text = kept.clone().unwrap_or_default();
            kept.is_some() && carried(name).is_some()
        });
        let own = names_carried(channels);
        let names = column_names(&own);
        let meanings = names
            .iter()
            .zip(&own)
            .zip(channels)
            .map(|((name, own), channel)| {
                let meaning = ColumnSidecar::from(channel_meaning(own, &channel.unit, suffix));
                (
                    name.clone(),
                    serde_json::to_value(meaning).unwrap_or_default(),
                )
            });
        let mut others: BTreeMap<String, serde_json::Value> = meanings.collect();
        others.insert("ChannelNames".into(), own.into());
        SignalSidecar {
            sampling_frequency: clock.rate_hz.hz(),
            start_time: clock.start_s.0,
            columns: names,
            physio_type: (suffix != STIM).then(|| "generic".to_owned()),
            task_name: Some(touched.task.to_owned()),
            study: Some(self.about.study.to_owned()),
            channels: numbers.to_vec(),
            condition: about.condition.clone(),
            provenance,
            warnings: warnings_carried(about.provenance.bench, about.warnings.clone()),
            labels,
            source_file: source.as_ref().map(|name| format!("bids::{name}")),
            others,
        }
    }
}

/// Whether the first step of the provenance is a label that somebody typed.
fn has_label(touched: &Touched<'_>) -> bool {
    let first = touched.recording.about.provenance.steps.first();
    touched.named_by == NamedBy::Person
        && is_of_a_bench(touched)
        && first.is_some_and(|first| first != NO_LABEL)
}
