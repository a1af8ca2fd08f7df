//! Reads a data set back: recordings, answers, participants, and what it says of itself.

mod whole;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use piezotact::page::Table;
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{
    About, Channel, Clock, Condition, Event, EventValue, Recording, StartTime,
};
use piezotact_people::association::ReadBehaviour;
use serde_json::Value;

use super::check::LONGEST_SESSION_S;
use super::error::BidsError;
use super::folder::require_outside;
use super::json::SignalSidecar;
use super::name::{Entities, Parsed, TRIALS};
use super::physio::{each_row, number_in};
use super::privacy::ms_of;
use super::table::{cell, read_table};
use super::tree::{Entry, Tree, text};
use super::{DESCRIPTION, PROTOCOL};
use piezotact_dataset::read_input_text;

use whole::require_whole;
pub(super) use whole::{require_one, two_studies};

/// A data set that was opened.
#[derive(Debug)]
pub struct BidsFolder {
    tree: Tree,
    /// The participants by their labels.
    people: BTreeMap<String, ReadPerson>,
    /// By the labels of participant and session.
    sessions: BTreeMap<(String, String), ReadSession>,
}

#[derive(Debug, Default)]
struct ReadPerson {
    pseudonym: String,
}

#[derive(Debug, Default)]
struct ReadSession {
    name: String,
    /// Its row in the table of sessions.
    row_number: usize,
    began_ms: Option<i64>,
    judge: Option<String>,
    /// The cells of its row, by the names of the columns.
    row: BTreeMap<String, String>,
    /// The times of its files.
    scans: BTreeMap<String, String>,
}

/// A recording of a data set: which files it stands in.
#[derive(Clone, Debug)]
pub struct BidsRecording {
    /// What its name says.
    pub entities: Entities,
    /// Its entities as they stand in the names of its files, with what tells it from another recording of the same name.
    pub name: String,
    files: Vec<Entry>,
    events: Option<Entry>,
}

/// More cells of one file of signals than these are not held in memory: 2 h of 4 channels at 5 kHz are 144 million.
const MOST_CELLS: usize = 400_000_000;

/// What belongs together: the folder, and the entities but `recording`.
type Together<'a> = (String, Vec<(&'a str, &'a str)>);

/// Kinds of events that come of an analysis and are no part of a recording.
const DERIVED_EVENTS: [&str; 3] = ["stroke", "rejected", "stimulus"];

impl BidsFolder {
    /// The data set in `root`.
    ///
    /// # Errors
    /// [`BidsError::NoDataset`] for a folder without one, with a half-written one or with several; [`BidsError::NoTouch`] for one
    /// without touch data; [`BidsError::File`] for tables that cannot be read, for files of two studies, for links that lead out of the
    /// folder, and for data that are missing or changed since the export.
    pub fn open(root: &Path) -> Result<Self, BidsError> {
        let tree = Tree::of(root)?;
        require_one(&tree)?;
        tree.json(DESCRIPTION)?;
        require_whole(&tree)?;
        let mut folder = Self {
            tree,
            people: BTreeMap::new(),
            sessions: BTreeMap::new(),
        };
        folder.require_one_study()?;
        folder.read_people()?;
        folder.require_touch()?;
        Ok(folder)
    }

    /// Refuses files that say that they are of two studies.
    fn require_one_study(&self) -> Result<(), BidsError> {
        match two_studies(&self.tree) {
            None => Ok(()),
            Some((file, why)) => Err(BidsError::file(&file, None, why)),
        }
    }

    fn read_people(&mut self) -> Result<(), BidsError> {
        if self.tree.has("participants.tsv") {
            let table = self.table("participants.tsv")?;
            if !table.columns.iter().any(|one| one.name == "participant_id") {
                let why = "expected the column participant_id, found none; name it, with tabulators between columns";
                return Err(BidsError::file("participants.tsv", 1, why));
            }
            for row in 0..table.rows.len() {
                let Some(id) = cell(&table, row, "participant_id") else {
                    continue;
                };
                let label = id.trim_start_matches("sub-").to_owned();
                let pseudonym = cell(&table, row, "pseudonym").unwrap_or(&label);
                let pseudonym = pseudonym.to_owned();
                self.people.insert(label, ReadPerson { pseudonym });
            }
        }
        for entry in self.tree.entries.clone() {
            let Some(name) = entry.parsed() else { continue };
            let Some(sub) = name.label("sub").map(str::to_owned) else {
                continue;
            };
            match (name.suffix.as_str(), name.ending.as_str()) {
                ("sessions", "tsv") => self.read_sessions(&entry.file, &sub)?,
                ("scans", "tsv") => {
                    let ses = name.label("ses").unwrap_or_default().to_owned();
                    let table = self.table(&entry.file)?;
                    let session = self.sessions.entry((sub, ses)).or_default();
                    for row in 0..table.rows.len() {
                        if let (Some(file), Some(time)) =
                            (cell(&table, row, "filename"), cell(&table, row, "acq_time"))
                        {
                            session.scans.insert(file.to_owned(), time.to_owned());
                        }
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn read_sessions(&mut self, file: &str, sub: &str) -> Result<(), BidsError> {
        let table = self.table(file)?;
        for row in 0..table.rows.len() {
            let Some(id) = cell(&table, row, "session_id") else {
                continue;
            };
            let label = id.trim_start_matches("ses-").to_owned();
            let session = self
                .sessions
                .entry((sub.to_owned(), label.clone()))
                .or_default();
            session.row_number = row;
            session.name = cell(&table, row, "session").unwrap_or(&label).to_owned();
            session.began_ms = cell(&table, row, "acq_time").and_then(ms_of);
            session.judge = cell(&table, row, "judge").map(str::to_owned);
            let names = table.columns.iter().map(|column| &column.name);
            session.row = names
                .filter_map(|name| Some((name.clone(), cell(&table, row, name)?.to_owned())))
                .collect();
        }
        Ok(())
    }

    fn table(&self, file: &str) -> Result<Table, BidsError> {
        read_table(&self.tree.path(file), file)
    }

    /// Refuses a data set without signals of touch and without answers.
    fn require_touch(&self) -> Result<(), BidsError> {
        let mut kinds: BTreeSet<&str> = BTreeSet::new();
        for entry in &self.tree.entries {
            if let Some(datatype) = entry.datatype() {
                kinds.insert(datatype);
            }
            let Some(name) = entry.parsed() else { continue };
            if name.suffix == "beh" && name.ending == "tsv" {
                let table = self.table(&entry.file)?;
                let has = |wanted: &str| table.columns.iter().any(|one| one.name == wanted);
                if has("response") && (has("presented") || has("rank")) {
                    return Ok(());
                }
            }
            if entry.is_signal() {
                let sidecar = self.tree.sidecar(entry)?;
                let of_touch = sidecar.values().any(|value| {
                    let unit = value.get("Units").and_then(Value::as_str);
                    let unit = unit.map(|unit| Unit::parse(unit).0);
                    matches!(unit, Some(Unit::MetrePerSecondSquared | Unit::Newton))
                });
                if of_touch {
                    return Ok(());
                }
            }
        }
        let found = match kinds.is_empty() {
            true => "no folder of data".to_owned(),
            false => format!(
                "data in {}",
                kinds.into_iter().collect::<Vec<_>>().join(", ")
            ),
        };
        Err(BidsError::NoTouch {
            folder: self.tree.root.clone(),
            found,
        })
    }

    /// Refuses a place inside the data set for what is made of it.
    ///
    /// # Errors
    /// [`BidsError::Inside`].
    pub fn require_outside(&self, place: &Path) -> Result<(), BidsError> {
        require_outside(&self.tree.root, place)
    }

    /// The protocol of the study, where the data set has it.
    ///
    /// # Errors
    /// [`BidsError::Read`].
    pub fn protocol(&self) -> Result<Option<String>, BidsError> {
        match self.tree.has(PROTOCOL) {
            true => Ok(Some(read_input_text(&self.tree.path(PROTOCOL))?)),
            false => Ok(None),
        }
    }

    /// The files of drives, from the root.
    #[must_use]
    pub fn stimuli(&self) -> Vec<PathBuf> {
        let others = self.tree.others.iter();
        let drives = others.filter(|file| file.starts_with("stimuli/"));
        drives.map(PathBuf::from).collect()
    }

    /// The files of EEG, from the root: samples, headers, channels, events, positions.
    #[must_use]
    pub fn eeg(&self) -> Vec<PathBuf> {
        let all = self.tree.entries.iter();
        let of_brain = all.filter(|entry| entry.datatype() == Some("eeg") && !entry.is_signal());
        of_brain.map(|entry| PathBuf::from(&entry.file)).collect()
    }

    /// The file at `file`, from the root.
    #[must_use]
    pub fn path(&self, file: &Path) -> PathBuf {
        self.tree.root.join(file)
    }

    /// The pseudonym of the participant, and the name of the session, of labels.
    fn names(&self, entities: &Entities) -> (String, String) {
        let person = self.people.get(&entities.sub);
        let ses = entities.ses.clone().unwrap_or_default();
        let session = self.sessions.get(&(entities.sub.clone(), ses.clone()));
        let session = session.map(|session| session.name.clone());
        (
            person.map_or_else(|| entities.sub.clone(), |person| person.pseudonym.clone()),
            session.filter(|name| !name.is_empty()).unwrap_or(ses),
        )
    }

    /// The sessions with the cells of their rows, the participant's pseudonym first: by participant, in the order of their rows.
    #[must_use]
    pub fn sessions(&self) -> Vec<(String, BTreeMap<String, String>)> {
        let mut all: Vec<_> = self.sessions.iter().collect();
        all.sort_by_key(|((sub, _), session)| (sub.clone(), session.row_number));
        let named = all.into_iter().map(|((sub, _), session)| {
            let person = self.people.get(sub);
            let pseudonym = person.map_or(sub, |person| &person.pseudonym);
            (pseudonym.clone(), session.row.clone())
        });
        named.filter(|(_, row)| !row.is_empty()).collect()
    }

    /// The recordings, in the order of their names.
    #[must_use]
    pub fn recordings(&self) -> Vec<BidsRecording> {
        let mut found: BTreeMap<Together<'_>, BidsRecording> = BTreeMap::new();
        for entry in self.tree.entries.iter().filter(|entry| entry.is_signal()) {
            let Some(name) = entry.parsed() else { continue };
            let key = (entry.folder().to_owned(), name.together());
            let of = found.entry(key).or_insert_with(|| BidsRecording {
                entities: entities_of(name),
                name: String::new(),
                files: Vec::new(),
                events: None,
            });
            of.files.push(entry.clone());
        }
        for entry in self.tree.entries.iter().filter(|entry| entry.is_table()) {
            let Some(name) = entry.parsed().filter(|name| name.suffix == "events") else {
                continue;
            };
            if let Some(of) = found.get_mut(&(entry.folder().to_owned(), name.together())) {
                of.events = Some(entry.clone());
            }
        }
        let mut known = BTreeSet::new();
        let named = found
            .into_iter()
            .map(|((folder, entities), of)| BidsRecording {
                name: name_of(&folder, &entities, &mut known),
                ..of
            });
        named.collect()
    }

    /// The recording `of`, bit by bit as it was written.
    ///
    /// # Errors
    /// [`BidsError::File`] for a sidecar or samples that cannot be read, [`BidsError::Recording`] for channels that make none.
    pub fn read_recording(&self, of: &BidsRecording) -> Result<Recording, BidsError> {
        let mut channels: Vec<(usize, Channel, Clock)> = Vec::new();
        let mut about = About::default();
        let mut first = "";
        let (mut labels, mut is_ours) = (BTreeMap::new(), false);
        let mut source = None;
        for (at, entry) in of.files.iter().enumerate() {
            let sidecar = self.signal_sidecar(entry)?;
            let known = sidecar.channels.clone();
            let (clock, read) = self.signals(entry, &sidecar)?;
            for (i, channel) in read.into_iter().enumerate() {
                let place = known.get(i).copied().unwrap_or(at * 1000 + i);
                channels.push((place, channel, clock));
            }
            if at == 0 {
                first = &entry.file;
                labels = sidecar.labels;
                source = sidecar.source_file;
                is_ours = sidecar.study.is_some();
                about = About {
                    condition: sidecar.condition,
                    provenance: sidecar.provenance,
                    warnings: sidecar.warnings,
                };
            }
        }
        channels.sort_by_key(|(place, ..)| *place);
        if !is_ours {
            self.complete(&mut about.condition, &of.entities);
        }
        let with_clocks = channels
            .into_iter()
            .map(|(_, channel, clock)| (channel, clock));
        let recording =
            Recording::with_clocks(with_clocks.collect(), about.condition, about.provenance);
        let mut recording = recording.map_err(|source| BidsError::Recording {
            file: first.to_owned(),
            source,
        })?;
        recording.about.warnings = about.warnings;
        if let Some(entry) = &of.events {
            recording.annotations.events = self.events(entry)?;
        }
        recording.annotations.labels = labels;
        recording.annotations.started_at = self.started(of);
        if let Some(source) = source {
            self.require_source(first, &recording, &source)?;
        }
        Ok(recording)
    }

    /// What names of files say, where the sidecar does not say it.
    fn complete(&self, condition: &mut Condition, entities: &Entities) {
        let (pseudonym, _) = self.names(entities);
        condition.participant.get_or_insert(pseudonym);
        if let Some(acq) = &entities.acq {
            condition.sample.get_or_insert_with(|| acq.clone());
        }
    }

    fn started(&self, of: &BidsRecording) -> Option<StartTime> {
        let ses = of.entities.ses.clone().unwrap_or_default();
        let session = self.sessions.get(&(of.entities.sub.clone(), ses))?;
        let name = |entry: &Entry| {
            let folder = of.entities.folder();
            let rest = entry.file.strip_prefix(&folder)?;
            session.scans.get(rest.trim_start_matches('/'))
        };
        let time = of.files.iter().find_map(name)?;
        StartTime::try_from(time.clone()).ok()
    }

    fn events(&self, entry: &Entry) -> Result<Vec<Event>, BidsError> {
        let table = self.table(&entry.file)?;
        let mut events = Vec::new();
        for row in 0..table.rows.len() {
            let kind = cell(&table, row, "trial_type").unwrap_or("event");
            if DERIVED_EVENTS.contains(&kind) {
                continue;
            }
            let number = |column: &str| match cell(&table, row, column) {
                None => Ok(None),
                Some(text) => number_in(text).map(Some).ok_or_else(|| {
                    let why = format!(
                        "expected a number in the column {column}, found `{text}`; correct the cell"
                    );
                    BidsError::file(&entry.file, row as u64 + 2, why)
                }),
            };
            let Some(onset_s) = number("onset")? else {
                continue;
            };
            let value = cell(&table, row, "value");
            events.push(Event {
                onset_s: Seconds(onset_s),
                duration_s: Seconds(number("duration")?.unwrap_or(0.0)),
                kind: kind.to_owned(),
                value: value.map(|text| match number_in(text) {
                    Some(number) => EventValue::Number(number),
                    None => EventValue::Text(text.to_owned()),
                }),
            });
        }
        Ok(events)
    }

    fn signal_sidecar(&self, entry: &Entry) -> Result<SignalSidecar, BidsError> {
        let object = self.tree.sidecar(entry)?;
        if object.is_empty() {
            return Err(BidsError::file(
                &entry.file,
                None,
                "expected a JSON file of the same name beside it, found none; restore it: without it nobody knows the rate and the columns",
            ));
        }
        serde_json::from_value(Value::Object(object)).map_err(|error| {
            BidsError::file(
                &entry.file,
                None,
                format!("expected SamplingFrequency, StartTime and Columns in its JSON file, found other fields ({error}); complete it"),
            )
        })
    }

    /// The clock and the channels of a file, in SI.
    fn signals(
        &self,
        entry: &Entry,
        sidecar: &SignalSidecar,
    ) -> Result<(Clock, Vec<Channel>), BidsError> {
        let rate_hz = SampleRate::new(sidecar.sampling_frequency).map_err(|error| {
            BidsError::file(
                &entry.file,
                None,
                format!("SamplingFrequency of its JSON file: {error}"),
            )
        })?;
        let within = -LONGEST_SESSION_S..=LONGEST_SESSION_S;
        if !within.contains(&sidecar.start_time) {
            let why = format!(
                "expected a StartTime in its JSON file within a week, found {}; correct it",
                sidecar.start_time
            );
            return Err(BidsError::file(&entry.file, None, why));
        }
        let clock = Clock {
            rate_hz,
            start_s: Seconds(sidecar.start_time),
        };
        let own: Vec<&str> = match sidecar.others.get("ChannelNames").and_then(Value::as_array) {
            Some(names) => names.iter().filter_map(Value::as_str).collect(),
            None => Vec::new(),
        };
        let (mut channels, factors): (Vec<Channel>, Vec<f64>) = sidecar
            .columns
            .iter()
            .enumerate()
            .map(|(i, name)| {
                let meaning = sidecar.others.get(name).and_then(Value::as_object);
                let unit = meaning.and_then(|meaning| text(meaning, "Units"));
                let (unit, factor) = unit_of(unit.unwrap_or_default());
                let channel = Channel {
                    name: own.get(i).map_or(name.as_str(), |own| own).to_owned(),
                    unit,
                    samples: Vec::new(),
                };
                (channel, factor)
            })
            .unzip();
        let mut cells = 0;
        let read = each_row(&self.tree.path(&entry.file), channels.len(), |row| {
            cells += row.len();
            if cells > MOST_CELLS {
                return ControlFlow::Break(());
            }
            for ((channel, value), factor) in channels.iter_mut().zip(row).zip(&factors) {
                // A factor of 1 changes no bit.
                channel.samples.push(value * factor);
            }
            ControlFlow::Continue(())
        })?;
        if cells > MOST_CELLS {
            let why = format!(
                "expected at most {MOST_CELLS} values in a file, found more; split the recording"
            );
            return Err(BidsError::file(&entry.file, None, why));
        }
        match read {
            Ok(_rows) => Ok((clock, channels)),
            Err(fault) => {
                let (line, why) = fault.sentence(sidecar.columns.len());
                Err(BidsError::file(&entry.file, line, why))
            }
        }
    }

    /// What happened in the sessions, task by task, in the order of participants and sessions.
    ///
    /// # Errors
    /// [`BidsError::File`] for tables that cannot be read.
    pub fn behaviour(&self) -> Result<Vec<ReadBehaviour>, BidsError> {
        let mut found: BTreeMap<Together<'_>, (Entities, ReadBehaviour)> = BTreeMap::new();
        let of_recordings: BTreeSet<(&str, Vec<(&str, &str)>)> = (self.tree.entries.iter())
            .filter(|entry| entry.is_signal())
            .filter_map(|entry| Some((entry.folder(), entry.parsed()?.together())))
            .collect();
        for entry in self.tree.entries.iter().filter(|entry| entry.is_table()) {
            let Some(name) = entry.parsed() else { continue };
            let is_events = match name.suffix.as_str() {
                "beh" => false,
                "events" if !of_recordings.contains(&(entry.folder(), name.together())) => true,
                _ => continue,
            };
            let entities = entities_of(name);
            let (participant, session) = self.names(&entities);
            let key = (
                entities.sub.clone(),
                entities.ses.clone().unwrap_or_default(),
            );
            let facts = self.sessions.get(&key);
            let task = self.task_name(entry, name);
            let (_, of) = found
                .entry((entry.folder().to_owned(), of_task(name)))
                .or_insert_with(|| {
                    let of = ReadBehaviour {
                        participant,
                        session,
                        judge: facts.and_then(|facts| facts.judge.clone()),
                        began_ms: facts.and_then(|facts| facts.began_ms),
                        ..ReadBehaviour::default()
                    };
                    (entities, of)
                });
            if of.task.is_empty() || !is_events {
                of.task = task;
            }
            let table = self.table(&entry.file)?;
            match is_events {
                true => of.events = table,
                false => of.responses = table,
            }
        }
        let mut found: Vec<(Entities, ReadBehaviour)> = found.into_values().collect();
        found.sort_by_key(|(entities, _)| {
            let key = (
                entities.sub.clone(),
                entities.ses.clone().unwrap_or_default(),
            );
            let row = self.sessions.get(&key).map(|session| session.row_number);
            (key.0, row)
        });
        Ok(found.into_iter().map(|(_, of)| of).collect())
    }

    /// The task of a table: the name in its sidecar, or in that of its answers, or its label.
    fn task_name(&self, entry: &Entry, name: &Parsed) -> String {
        let own = self.tree.sidecar(entry).unwrap_or_default();
        if let Some(task) = text(&own, "TaskName") {
            return task.to_owned();
        }
        let label = name.label("task").unwrap_or_default();
        for file in [
            format!("task-{label}_beh.json"),
            format!("task-{label}_physio.json"),
        ] {
            if let Ok(object) = self.tree.json(&file)
                && let Some(task) = text(&object, "TaskName")
            {
                return task.to_owned();
            }
        }
        // Tasks that are not answered are known by their recordings.
        let signal = self.tree.entries.iter().find(|other| {
            other.is_signal()
                && other
                    .parsed()
                    .is_some_and(|of| of.label("task") == Some(label))
        });
        let of_signal = signal.and_then(|signal| self.tree.sidecar(signal).ok());
        let task = of_signal.and_then(|object| text(&object, "TaskName").map(str::to_owned));
        task.unwrap_or_else(|| label.to_owned())
    }
}

/// What events and answers of one task of a session share.
fn of_task(name: &Parsed) -> Vec<(&str, &str)> {
    let mut all = name.together();
    all.retain(|of| *of != ("acq", TRIALS));
    all
}

/// A name for the recording of `entities` in `folder` that is not `known` yet, small and capital letters being one.
fn name_of(folder: &str, entities: &[(&str, &str)], known: &mut BTreeSet<String>) -> String {
    let parts: Vec<String> = entities
        .iter()
        .map(|(key, label)| format!("{key}-{label}"))
        .collect();
    let plain = parts.join("_");
    let of_kind = format!("{plain}_{}", folder.rsplit('/').next().unwrap_or_default());
    let numbered = (2..).map(|count| format!("{of_kind}_{count}"));
    let mut names = [plain, of_kind.clone()].into_iter().chain(numbered);
    let free = names.find(|name| known.insert(name.to_lowercase()));
    // There are more numbers than recordings.
    free.unwrap_or(of_kind)
}

/// A unit of a column, and the factor to SI; a share of full scale is a number without unit.
fn unit_of(text: &str) -> (Unit, f64) {
    match text {
        "arbitrary" => (Unit::Other(String::new()), 1.0),
        text => Unit::parse(text),
    }
}

fn entities_of(name: &Parsed) -> Entities {
    let label = |key: &str| name.label(key).map(str::to_owned);
    Entities {
        sub: label("sub").unwrap_or_default(),
        ses: label("ses"),
        task: label("task"),
        acq: label("acq"),
        run: name.label("run").and_then(|run| run.parse().ok()),
        recording: None,
        desc: None,
    }
}
