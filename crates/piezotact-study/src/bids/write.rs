//! Writes a data set: aside, file by file, and renamed when it is complete.

mod derived;
mod eeg;
mod parts;
mod recordings;
mod texts;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::page::{Cell, Column, Table};
use piezotact::recording::StartTime;
use piezotact_people::association::{
    Behaviour, BehaviourMeanings, behaviour_meanings, is_recorded,
};
use piezotact_people::campaign::dictionary::columns_of;
use serde::Serialize;

use super::about::{DatasetAbout, Followed, NotCarried, Person, SessionFacts};
use super::error::BidsError;
use super::folder::NewFolder;
use super::json::{DatasetLinks, Description, GeneratedBy, SourceDataset};
use super::label::Labels;
use super::name::{Entities, TRIALS};
use super::privacy::{
    Calendar, age_of, handedness_of, has_unknown_word, is_finger, is_language, sex_of,
};
use super::table::tsv_text;
use super::{BIDS_VERSION, CHECKSUMS, DESCRIPTION, HED_VERSION, PROGRAM, PROTOCOL};
use parts::{require_no_notes, sidecars};

pub use derived::{Derived, Sources};
pub use eeg::{Brain, BrainAbout};
pub use recordings::{NamedBy, Touched};

/// The folder of what is derived, from the root.
const DERIVATIVES: &str = "derivatives/piezotact";

/// What was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Exported {
    /// How many participants.
    pub participants: usize,
    /// How many sessions.
    pub sessions: usize,
    /// How many recordings.
    pub recordings: usize,
    /// How many EEG recordings.
    pub eeg_recordings: usize,
    /// How many answers.
    pub answers: usize,
    /// How many files.
    pub files: usize,
    /// What the study holds and the data set does not carry.
    pub not_carried: Vec<NotCarried>,
    /// What to know of the study and its recordings before relying on it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Warning>,
}

impl Content for Exported {
    const SCHEMA: &'static str = "bids_export";
}

/// A data set that is being written.
#[derive(Debug)]
pub struct BidsWriter<'a> {
    about: DatasetAbout<'a>,
    meanings: Vec<BehaviourMeanings>,
    folder: NewFolder,
    people: BTreeMap<String, Person>,
    sessions: Vec<(String, SessionFacts)>,
    /// The data files of each session, with their times.
    scans: BTreeMap<(String, Option<String>), Vec<Scan>>,
    runs: BTreeMap<Entities, u32>,
    brain_runs: BTreeMap<Entities, u32>,
    /// How many values of a kind were derived that are of no one recording.
    kinds_derived: BTreeMap<(Entities, String), u32>,
    /// The kinds of events by task, beside those of the protocol.
    kinds: BTreeMap<String, BTreeSet<String>>,
    /// The tasks that have answers, and those that have events.
    with_answers: BTreeSet<String>,
    with_events: BTreeSet<String>,
    labels: [Labels; 4],
    recordings: usize,
    brains: usize,
    answers: usize,
    dated: usize,
    /// Words of other programs that are carried and that this program does not know.
    words: BTreeSet<String>,
}

/// A data file, re the folder of its session, or of its participant where there are no sessions, with its time.
type Scan = (String, Option<Began>);

/// When something was begun.
#[derive(Clone, Debug)]
enum Began {
    /// In ms since 1970-01-01 00:00 UTC.
    At(i64),
    /// As a recording states it.
    Start(StartTime),
}

/// Which of the labels.
const PARTICIPANT: usize = 0;
const SESSION: usize = 1;
const TASK: usize = 2;
const SAMPLE: usize = 3;

impl<'a> BidsWriter<'a> {
    /// Begins a data set that will stand at `place`.
    ///
    /// # Errors
    /// [`BidsError::Exists`] where something stands there, [`BidsError::Clash`] and [`BidsError::NoLabel`] for names of the protocol
    /// that make no names of files, and [`BidsError::Write`].
    pub fn create(place: &Path, about: DatasetAbout<'a>) -> Result<Self, BidsError> {
        let mut labels = ["participant", "session", "task", "sample"].map(Labels::of);
        if let Some(Followed { protocol, .. }) = about.followed {
            for session in &protocol.sessions {
                labels[SESSION].label(&session.name)?;
            }
            for task in &protocol.tasks {
                labels[TASK].label(&task.name)?;
            }
            let made = protocol.stimuli.iter().map(|stimulus| &stimulus.name);
            for name in protocol.samples.iter().chain(made) {
                labels[SAMPLE].label(name)?;
            }
        }
        // No sample may have the label of the events of a session.
        labels[SAMPLE].label(TRIALS)?;
        let folder = NewFolder::beside(place)?;
        let meanings = about.followed.map(|of| behaviour_meanings(of.protocol));
        Ok(Self {
            about,
            meanings: meanings.unwrap_or_default(),
            folder,
            people: BTreeMap::new(),
            sessions: Vec::new(),
            scans: BTreeMap::new(),
            runs: BTreeMap::new(),
            brain_runs: BTreeMap::new(),
            kinds_derived: BTreeMap::new(),
            kinds: BTreeMap::new(),
            with_answers: BTreeSet::new(),
            with_events: BTreeSet::new(),
            labels,
            recordings: 0,
            brains: 0,
            answers: 0,
            dated: 0,
            words: BTreeSet::new(),
        })
    }

    /// Adds a participant.
    ///
    /// # Errors
    /// [`BidsError::Clash`], [`BidsError::NoLabel`].
    pub fn person(&mut self, person: Person) -> Result<(), BidsError> {
        self.labels[PARTICIPANT].label(&person.pseudonym)?;
        self.people.insert(person.pseudonym.clone(), person);
        Ok(())
    }

    fn calendar(&self, pseudonym: &str) -> Option<Calendar> {
        let person = self.people.get(pseudonym)?;
        Some(Calendar::beginning(person.first_ms))
    }

    /// Adds a session of a participant who was added.
    ///
    /// # Errors
    /// [`BidsError::Clash`], [`BidsError::NoLabel`].
    pub fn session(&mut self, pseudonym: &str, session: SessionFacts) -> Result<(), BidsError> {
        self.labels[SESSION].label(&session.session)?;
        self.sessions.push((pseudonym.to_owned(), session));
        Ok(())
    }

    fn entities(
        &mut self,
        participant: &str,
        session: Option<&str>,
        task: &str,
    ) -> Result<Entities, BidsError> {
        Ok(Entities {
            sub: self.labels[PARTICIPANT].label(participant)?,
            ses: self.session_label(session)?,
            task: Some(self.labels[TASK].label(task)?),
            ..Entities::default()
        })
    }

    fn session_label(&mut self, session: Option<&str>) -> Result<Option<String>, BidsError> {
        session
            .map(|name| self.labels[SESSION].label(name))
            .transpose()
    }

    /// Copies the drive of `stimulus` that is in `file`; gives its name re the folder of stimuli.
    ///
    /// # Errors
    /// [`BidsError::Read`], [`BidsError::Write`], and those of labels.
    pub fn stimulus(
        &mut self,
        participant: &str,
        session: &str,
        stimulus: &str,
        file: &Path,
    ) -> Result<String, BidsError> {
        let of = Entities {
            sub: self.labels[PARTICIPANT].label(participant)?,
            ses: Some(self.labels[SESSION].label(session)?),
            ..Entities::default()
        };
        let label = self.labels[SAMPLE].label(stimulus)?;
        require_no_notes(file)?;
        let name = format!("{}/{label}_drive.wav", of.folder());
        self.folder.copy(&format!("stimuli/{name}"), file)?;
        Ok(name)
    }

    /// Adds what happened in one task of a session.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn behaviour(
        &mut self,
        participant: &str,
        session: &str,
        behaviour: &Behaviour,
        began_ms: Option<i64>,
    ) -> Result<(), BidsError> {
        let of = self.entities(participant, Some(session), &behaviour.task)?;
        let time = began_ms.map(Began::At);
        let mut names = Vec::new();
        if !behaviour.responses.rows.is_empty() {
            let file = of.file("beh", "tsv");
            self.folder
                .put_text(&file, &tsv_text(&behaviour.responses, &file)?)?;
            self.with_answers.insert(behaviour.task.clone());
            self.answers += behaviour.responses.rows.len();
            names.push(file);
        }
        let followed = self.about.followed;
        let task = followed.and_then(|of| of.protocol.task(&behaviour.task));
        let file = match task.is_some_and(|task| is_recorded(&task.kind)) {
            true => of.of_session().file("events", "tsv"),
            false => of.file("events", "tsv"),
        };
        self.folder
            .put_text(&file, &tsv_text(&behaviour.events, &file)?)?;
        self.with_events.insert(behaviour.task.clone());
        names.push(file);
        let key = (participant.to_owned(), Some(session.to_owned()));
        let scans = self.scans.entry(key).or_default();
        for name in names {
            let name = name
                .trim_start_matches(&of.folder())
                .trim_start_matches('/');
            scans.push((name.to_owned(), time.clone()));
        }
        Ok(())
    }

    /// How many recordings have no copy as they are, since they state a date or are of another program.
    #[must_use]
    pub fn dated(&self) -> usize {
        self.dated
    }

    /// The names of channels and events in files of other programs that are carried and may be those of people.
    #[must_use]
    pub fn words(&self) -> &BTreeSet<String> {
        &self.words
    }

    /// Notes those of `texts` that hold words this program does not know; `of` says what they name.
    fn note_words<'t>(&mut self, of: &str, texts: impl IntoIterator<Item = &'t str>) {
        let unknown = texts.into_iter().filter(|text| has_unknown_word(text));
        self.words
            .extend(unknown.map(|text| format!("{text} ({of})")));
    }

    /// Completes the data set and puts it in its place; `warnings` are what a person should know of the recordings before relying on them,
    /// in words.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Exists`] where something came to stand there.
    pub fn finish(
        mut self,
        not_carried: Vec<NotCarried>,
        warnings: &[String],
    ) -> Result<(Exported, PathBuf), BidsError> {
        self.participants()?;
        if let Some(Followed { text, .. }) = self.about.followed {
            self.session_tables()?;
            self.folder.put_text(PROTOCOL, &without_comments(text))?;
        } else {
            for pseudonym in self.people.keys().cloned().collect::<Vec<_>>() {
                self.scans_table(&pseudonym, None)?;
            }
        }
        self.task_sidecars()?;
        let exported = Exported {
            participants: self.people.len(),
            sessions: self.sessions.len(),
            recordings: self.recordings,
            eeg_recordings: self.brains,
            answers: self.answers,
            files: 0,
            not_carried,
            warnings: Vec::new(),
        };
        let readme = texts::readme(&self.about, (&exported, warnings));
        self.folder.put_text("README.md", &readme)?;
        let description = |kind, hed_version, derived: Option<[SourceDataset; 1]>| Description {
            name: self.about.name,
            bids_version: BIDS_VERSION,
            hed_version,
            dataset_type: kind,
            license: self.about.license,
            authors: self.about.authors,
            generated_by: [GeneratedBy {
                name: PROGRAM,
                version: self.about.program.trim_start_matches("piezotact "),
                description: texts::PROGRAM,
            }],
            dataset_links: derived.as_ref().map(|_| DatasetLinks { study: "../.." }),
            source_datasets: derived,
        };
        if self.folder.has(DERIVATIVES) {
            let source = Some([SourceDataset { url: "../../" }]);
            let derived = description("derivative", None, source);
            self.folder
                .put_json(&format!("{DERIVATIVES}/{DESCRIPTION}"), &derived)?;
            self.folder
                .put_text(&format!("{DERIVATIVES}/README.md"), texts::DERIVED)?;
            self.folder
                .put_text(&format!("{DERIVATIVES}/.bidsignore"), texts::NOT_OF_BIDS)?;
        }
        self.folder.put_checksums(CHECKSUMS)?;
        // Last: a folder without it is none.
        let own = description("raw", Some(HED_VERSION), None);
        self.folder.put_json(DESCRIPTION, &own)?;
        let files = self.folder.files();
        let place = self.folder.commit()?;
        Ok((Exported { files, ..exported }, place))
    }

    fn participants(&mut self) -> Result<(), BidsError> {
        let names = [
            "participant_id",
            "species",
            "age",
            "sex",
            "handedness",
            "kind",
            "pseudonym",
        ];
        let mut table = Table::new(names.map(|name| Column::new(name, name)));
        for (pseudonym, person) in &self.people {
            let label = self.labels[PARTICIPANT].label(pseudonym)?;
            let word = |word: Option<&'static str>| word.map_or(Cell::Missing(()), Cell::from);
            let is_person = !person.is_virtual;
            table.rows.push(vec![
                Cell::from(format!("sub-{label}")),
                word(is_person.then_some("homo sapiens")),
                Cell::from(person.age_years.map(|age| f64::from(age_of(age)))),
                word(person.sex.as_deref().and_then(sex_of)),
                word(person.handedness.as_deref().and_then(handedness_of)),
                Cell::from(if is_person { "volunteer" } else { "virtual" }),
                Cell::from(pseudonym.as_str()),
            ]);
        }
        let text = tsv_text(&table, "participants.tsv")?;
        self.folder.put_text("participants.tsv", &text)?;
        let columns = sidecars(&columns_of("participants"));
        self.folder.put_json("participants.json", &columns)
    }

    fn session_tables(&mut self) -> Result<(), BidsError> {
        for pseudonym in self.people.keys().cloned().collect::<Vec<_>>() {
            let sub = self.labels[PARTICIPANT].label(&pseudonym)?;
            let mut table = Table::new(texts::SESSION_COLUMNS.map(|name| Column::new(name, name)));
            let own = self.sessions.iter().filter(|(of, _)| *of == pseudonym);
            for (_, facts) in own.cloned().collect::<Vec<_>>() {
                let row = self.session_row(&pseudonym, &facts)?;
                table.rows.push(row);
                self.scans_table(&pseudonym, Some(&facts.session))?;
            }
            let file = format!("sub-{sub}/sub-{sub}_sessions.tsv");
            self.folder.put_text(&file, &tsv_text(&table, &file)?)?;
            let file = format!("sub-{sub}/sub-{sub}_sessions.json");
            self.folder
                .put_json(&file, &sidecars(&columns_of("sessions")))?;
        }
        Ok(())
    }

    fn session_row(
        &mut self,
        pseudonym: &str,
        facts: &SessionFacts,
    ) -> Result<Vec<Cell>, BidsError> {
        let ses = self.labels[SESSION].label(&facts.session)?;
        let calendar = self.calendar(pseudonym);
        let judge = self.people.get(pseudonym).and_then(|of| of.judge.clone());
        let text = |text: &Option<String>| text.as_deref().map_or(Cell::Missing(()), Cell::from);
        let time = calendar.zip(facts.began_ms);
        Ok(vec![
            Cell::from(format!("ses-{ses}")),
            time.map_or(Cell::Missing(()), |(calendar, at_ms)| {
                Cell::from(calendar.text(at_ms))
            }),
            Cell::from(facts.session.as_str()),
            Cell::from(facts.ended),
            Cell::from(facts.confirmed as f64),
            Cell::from(facts.planned as f64),
            text(&facts.sex.clone().filter(|sex| sex_of(sex).is_some())),
            Cell::from(facts.age_years.map(|age| f64::from(age_of(age)))),
            text(&facts.handedness),
            text(&facts.finger.clone().filter(|one| is_finger(one))),
            text(&facts.language.clone().filter(|one| is_language(one))),
            text(&judge),
        ])
    }

    fn scans_table(&mut self, pseudonym: &str, session: Option<&str>) -> Result<(), BidsError> {
        let key = (pseudonym.to_owned(), session.map(str::to_owned));
        let Some(scans) = self.scans.get(&key) else {
            return Ok(());
        };
        let calendar = self.calendar(pseudonym);
        let on_calendar = |time: &Began| match time {
            Began::At(at_ms) => calendar.map(|calendar| calendar.text(*at_ms)),
            Began::Start(started) => calendar.map(|calendar| calendar.start(started)),
        };
        let mut table = Table::new(["filename", "acq_time"].map(|name| Column::new(name, name)));
        table.rows = scans
            .iter()
            .map(|(name, time)| {
                let time = time.as_ref().and_then(on_calendar);
                let time = time.map_or(Cell::Missing(()), Cell::from);
                vec![Cell::from(name.as_str()), time]
            })
            .collect();
        let of = Entities {
            sub: self.labels[PARTICIPANT].label(pseudonym)?,
            ses: self.session_label(session)?,
            ..Entities::default()
        };
        let file = format!("{}/{of}_scans.tsv", of.folder());
        self.folder.put_text(&file, &tsv_text(&table, &file)?)
    }

    /// The sidecars of the answers and events of each task, which stand at the root.
    fn task_sidecars(&mut self) -> Result<(), BidsError> {
        let Some(Followed { protocol, .. }) = self.about.followed else {
            return self.recording_events_sidecars();
        };
        for (task, meanings) in protocol.tasks.iter().zip(self.meanings.clone()) {
            let label = self.labels[TASK].label(&task.name)?;
            if self.with_answers.contains(&task.name) {
                let sidecar = texts::TaskSidecar {
                    task_name: &task.name,
                    task_description: &task.title,
                    instructions: &task.instruction,
                    study: self.about.study,
                    columns: sidecars(&meanings.responses),
                };
                self.folder
                    .put_json(&format!("task-{label}_beh.json"), &sidecar)?;
            }
            if self.with_events.contains(&task.name) {
                let mut columns = sidecars(&meanings.events);
                let kinds = self.kinds.get(&task.name);
                if let Some(kinds) = kinds {
                    texts::with_recording_events(&mut columns, kinds);
                }
                texts::with_tags(&mut columns);
                self.folder
                    .put_json(&format!("task-{label}_events.json"), &columns)?;
            }
        }
        Ok(())
    }

    /// The sidecars of the events of recordings without a campaign, which stand at the root.
    fn recording_events_sidecars(&mut self) -> Result<(), BidsError> {
        for task in self.with_events.clone() {
            let label = self.labels[TASK].label(&task)?;
            let kinds = self.kinds.get(&task).cloned().unwrap_or_default();
            let columns = texts::of_recording_events(&kinds);
            self.folder
                .put_json(&format!("task-{label}_events.json"), &columns)?;
        }
        Ok(())
    }
}

/// A protocol without what somebody noted in it: its values alone. One that is none stays out.
fn without_comments(text: &str) -> String {
    let values: Result<toml::Table, _> = toml::from_str(text);
    let text = values.ok().and_then(|values| toml::to_string(&values).ok());
    text.unwrap_or_default()
}
