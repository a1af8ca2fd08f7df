//! Writes a data set: aside, file by file, and renamed when it is complete.

mod parts;
mod texts;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use piezotact::document::Content;
use piezotact::page::{Cell, Column, Table};
use piezotact::recording::{Channel, Clock, Recording};
use piezotact_people::association::{
    Behaviour, BehaviourMeanings, behaviour_meanings, is_recorded, person_meanings,
};
use piezotact_people::campaign::dictionary::ColumnMeaning;
use piezotact_people::campaign::protocol::Protocol;
use serde::Serialize;

use super::about::{DatasetAbout, NotCarried, Person, SessionFacts};
use super::error::BidsError;
use super::folder::NewFolder;
use super::json::{
    ColumnSidecar, Columns, DatasetLinks, Description, GeneratedBy, SignalSidecar, SourceDataset,
    channel_meaning,
};
use super::label::Labels;
use super::name::{Entities, STIM, TRIALS};
use super::physio::write_signals;
use super::privacy::{
    Calendar, age_of, carried, handedness_of, is_finger, is_language, sex_of, without_folders,
};
use super::table::tsv_text;
use super::{BIDS_VERSION, CHECKSUMS, DESCRIPTION, HED_VERSION, PROGRAM, PROTOCOL};
use parts::{
    DRIVE, column_names, described, events_carried, groups, is_of_a_bench, names_carried,
    require_no_notes, sidecars, suffix_number, texts_carried,
};

/// The folder of what is derived, from the root.
const DERIVATIVES: &str = "derivatives/piezotact";

/// One recording with what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Touched<'a> {
    /// The participant's pseudonym.
    pub participant: &'a str,
    /// The session, by its name in the protocol.
    pub session: &'a str,
    /// The task.
    pub task: &'a str,
    /// The sample or stimulus.
    pub sample: &'a str,
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

/// A value that was derived, with the recordings that it was made from.
#[derive(Clone, Debug)]
pub struct Derived<'a> {
    /// Whose it is, with session and task; absent for one of the whole study.
    pub of: Option<(&'a str, &'a str)>,
    /// The task.
    pub task: Option<&'a str>,
    /// The sample or stimulus.
    pub sample: Option<&'a str>,
    /// What it is, in one word: `average`.
    pub desc: &'a str,
    /// Its kind, in one word: `psd`.
    pub suffix: &'a str,
    /// The value as a table.
    pub table: &'a Table,
    /// What its columns mean.
    pub columns: BTreeMap<String, ColumnMeaning>,
    /// What it is, in a sentence.
    pub description: &'a str,
    /// How it was made: settings, doubts and verdicts, as its document has them.
    pub provenance: serde_json::Value,
    /// What it was made from.
    pub sources: Sources<'a>,
}

/// What a value was made from.
#[derive(Clone, Copy, Debug)]
pub enum Sources<'a> {
    /// Files, re the folder of its session.
    Session(&'a [String]),
    /// The drive of its stimulus.
    Drive,
    /// All answers.
    Answers,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Exported {
    /// How many participants.
    pub participants: usize,
    /// How many sessions.
    pub sessions: usize,
    /// How many recordings.
    pub recordings: usize,
    /// How many answers.
    pub answers: usize,
    /// How many files.
    pub files: usize,
    /// What the study holds and the data set does not carry.
    pub not_carried: Vec<NotCarried>,
}

impl Content for Exported {
    const SCHEMA: &'static str = "bids_export";
}

/// A data set that is being written.
#[derive(Debug)]
pub struct BidsWriter<'a> {
    about: DatasetAbout<'a>,
    protocol: &'a Protocol,
    meanings: Vec<BehaviourMeanings>,
    folder: NewFolder,
    people: BTreeMap<String, (Person, Calendar)>,
    sessions: Vec<(String, SessionFacts)>,
    /// The data files of each session, with their times.
    scans: BTreeMap<(String, String), Vec<Scan>>,
    runs: BTreeMap<Entities, u32>,
    /// How many values of a kind were derived.
    kinds_derived: BTreeMap<(Entities, String), u32>,
    /// The kinds of events by task, beside those of the protocol.
    kinds: BTreeMap<String, BTreeSet<String>>,
    /// The tasks that have answers, and those that have events.
    with_answers: BTreeSet<String>,
    with_events: BTreeSet<String>,
    labels: [Labels; 4],
    recordings: usize,
    answers: usize,
    dated: usize,
}

/// A data file, re the folder of its session, with its time.
type Scan = (String, Option<String>);

/// Which of the labels.
const PARTICIPANT: usize = 0;
const SESSION: usize = 1;
const TASK: usize = 2;
const SAMPLE: usize = 3;

impl<'a> BidsWriter<'a> {
    /// Begins a data set of the study of `protocol` that will stand at `place`.
    ///
    /// # Errors
    /// [`BidsError::Exists`] where something stands there, [`BidsError::Clash`] and [`BidsError::NoLabel`] for names of the protocol
    /// that make no names of files, and [`BidsError::Write`].
    pub fn create(
        place: &Path,
        about: DatasetAbout<'a>,
        protocol: &'a Protocol,
    ) -> Result<Self, BidsError> {
        let mut labels = ["participant", "session", "task", "sample"].map(Labels::of);
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
        // No sample may have the label of the events of a session.
        labels[SAMPLE].label(TRIALS)?;
        let folder = NewFolder::beside(place)?;
        Ok(Self {
            about,
            protocol,
            meanings: behaviour_meanings(protocol),
            folder,
            people: BTreeMap::new(),
            sessions: Vec::new(),
            scans: BTreeMap::new(),
            runs: BTreeMap::new(),
            kinds_derived: BTreeMap::new(),
            kinds: BTreeMap::new(),
            with_answers: BTreeSet::new(),
            with_events: BTreeSet::new(),
            labels,
            recordings: 0,
            answers: 0,
            dated: 0,
        })
    }

    /// Adds a participant.
    ///
    /// # Errors
    /// [`BidsError::Clash`], [`BidsError::NoLabel`].
    pub fn person(&mut self, person: Person) -> Result<(), BidsError> {
        self.labels[PARTICIPANT].label(&person.pseudonym)?;
        let calendar = Calendar::beginning(person.first_ms);
        self.people
            .insert(person.pseudonym.clone(), (person, calendar));
        Ok(())
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
        session: &str,
        task: &str,
    ) -> Result<Entities, BidsError> {
        Ok(Entities {
            sub: self.labels[PARTICIPANT].label(participant)?,
            ses: Some(self.labels[SESSION].label(session)?),
            task: Some(self.labels[TASK].label(task)?),
            ..Entities::default()
        })
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

    /// Adds a recording; gives the name of its first file re the folder of the session.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn recording(&mut self, touched: &Touched<'_>) -> Result<String, BidsError> {
        let mut of = self.entities(touched.participant, touched.session, touched.task)?;
        of.acq = Some(self.labels[SAMPLE].label(touched.sample)?);
        let run = self.runs.entry(of.clone()).or_default();
        *run += 1;
        of.run = Some(*run);
        let calendar = self
            .people
            .get(touched.participant)
            .map(|(_, calendar)| *calendar);
        let started = touched.recording.annotations.started_at.as_ref();
        let time = calendar.and_then(|calendar| match (started, touched.at_ms) {
            (Some(started), _) => Some(calendar.start(started)),
            (None, Some(at_ms)) => Some(calendar.text(at_ms)),
            (None, None) => None,
        });
        let source = self.source(&of, touched)?;
        let mut first = None;
        for (label, clock, numbers) in groups(touched) {
            of.recording = Some(label.to_owned() + &suffix_number(&clock.1));
            let channels = touched.recording.channels();
            let of_group: Vec<&Channel> = numbers.iter().map(|at| &channels[*at]).collect();
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
        time: Option<String>,
    ) -> String {
        let name = file
            .trim_start_matches(&of.folder())
            .trim_start_matches('/')
            .to_owned();
        let key = (touched.participant.to_owned(), touched.session.to_owned());
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
            doubts: about.doubts.clone(),
            labels,
            source_file: source.as_ref().map(|name| format!("bids::{name}")),
            others,
        }
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
        let of = self.entities(participant, session, &behaviour.task)?;
        let calendar = self.people.get(participant).map(|(_, calendar)| *calendar);
        let time = calendar
            .zip(began_ms)
            .map(|(calendar, at_ms)| calendar.text(at_ms));
        let mut names = Vec::new();
        if !behaviour.responses.rows.is_empty() {
            let file = of.file("beh", "tsv");
            self.folder
                .put_text(&file, &tsv_text(&behaviour.responses, &file)?)?;
            self.with_answers.insert(behaviour.task.clone());
            self.answers += behaviour.responses.rows.len();
            names.push(file);
        }
        let task = self.protocol.task(&behaviour.task);
        let file = match task.is_some_and(|task| is_recorded(&task.kind)) {
            true => of.of_session().file("events", "tsv"),
            false => of.file("events", "tsv"),
        };
        self.folder
            .put_text(&file, &tsv_text(&behaviour.events, &file)?)?;
        self.with_events.insert(behaviour.task.clone());
        names.push(file);
        let key = (participant.to_owned(), session.to_owned());
        let scans = self.scans.entry(key).or_default();
        for name in names {
            let name = name
                .trim_start_matches(&of.folder())
                .trim_start_matches('/');
            scans.push((name.to_owned(), time.clone()));
        }
        Ok(())
    }

    /// Adds a value that was derived.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Text`], and those of labels.
    pub fn derived(&mut self, derived: &Derived<'_>) -> Result<(), BidsError> {
        let mut of = Entities {
            desc: super::label_of(derived.desc),
            ..Entities::default()
        };
        if let Some(task) = derived.task {
            of.task = Some(self.labels[TASK].label(task)?);
        }
        if let Some(sample) = derived.sample {
            of.acq = Some(self.labels[SAMPLE].label(sample)?);
        }
        let stem = match derived.of {
            Some((participant, session)) => {
                of.sub = self.labels[PARTICIPANT].label(participant)?;
                of.ses = Some(self.labels[SESSION].label(session)?);
                let key = (of.clone(), derived.suffix.to_owned());
                let counted = self.kinds_derived.entry(key).or_default();
                *counted += 1;
                of.run = (*counted > 1).then_some(*counted);
                format!("{DERIVATIVES}/{}/beh/{of}_{}", of.folder(), derived.suffix)
            }
            None => {
                let text = of.to_string();
                let without = text.trim_start_matches("sub-").trim_start_matches('_');
                format!("{DERIVATIVES}/{without}_{}", derived.suffix)
            }
        };
        let file = format!("{stem}.tsv");
        self.folder
            .put_text(&file, &tsv_text(derived.table, &file)?)?;
        let mut sidecar = serde_json::Map::new();
        sidecar.insert("Description".into(), derived.description.into());
        let sources: Vec<String> = match derived.sources {
            Sources::Session(files) => (files.iter())
                .map(|file| format!("bids:study:{}/{file}", of.folder()))
                .collect(),
            Sources::Drive => self.drives_of(&of),
            Sources::Answers => (self.scans.values().flatten())
                .filter(|(name, _)| name.ends_with("_beh.tsv"))
                .map(|(name, _)| format!("bids:study:{}", beside(name)))
                .collect(),
        };
        sidecar.insert("Sources".into(), sources.into());
        sidecar.insert("Provenance".into(), texts_carried(&derived.provenance));
        let has = |name: &String| derived.table.columns.iter().any(|one| one.name == *name);
        for (name, meaning) in derived.columns.iter().filter(|(name, _)| has(name)) {
            sidecar.insert(
                name.clone(),
                serde_json::to_value(meaning).unwrap_or_default(),
            );
        }
        self.folder.put_json(&format!("{stem}.json"), &sidecar)
    }

    /// The drive of a stimulus, as a URI.
    fn drives_of(&self, of: &Entities) -> Vec<String> {
        let label = of.acq.as_deref().unwrap_or_default();
        let file = format!("stimuli/{}/{label}_drive.wav", of.folder());
        let is_there = self.folder.has(&file);
        is_there
            .then(|| format!("bids:study:{file}"))
            .into_iter()
            .collect()
    }

    /// How many recordings have no copy as they are, since they state a date or are of another program.
    #[must_use]
    pub fn dated(&self) -> usize {
        self.dated
    }

    /// Completes the data set and puts it in its place; `doubts` are what a person should know of the recordings before relying on them,
    /// in words.
    ///
    /// # Errors
    /// [`BidsError::Write`], [`BidsError::Exists`] where something came to stand there.
    pub fn finish(
        mut self,
        not_carried: Vec<NotCarried>,
        doubts: &[String],
    ) -> Result<(Exported, PathBuf), BidsError> {
        self.participants()?;
        self.session_tables()?;
        self.task_sidecars()?;
        self.folder
            .put_text(PROTOCOL, &without_comments(self.about.protocol))?;
        let exported = Exported {
            participants: self.people.len(),
            sessions: self.sessions.len(),
            recordings: self.recordings,
            answers: self.answers,
            files: 0,
            not_carried,
        };
        let readme = texts::readme(&self.about, self.protocol, (&exported, doubts));
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
        for (pseudonym, (person, _)) in &self.people {
            let label = self.labels[PARTICIPANT].label(pseudonym)?;
            let word = |word: Option<&'static str>| word.map_or(Cell::Missing(()), Cell::from);
            let is_person = person.judge.is_none();
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
        let mut columns = sidecars(&person_meanings());
        columns.insert(
            "participant_id".into(),
            described("Participant, by the label of the data set."),
        );
        self.folder.put_json("participants.json", &columns)
    }

    fn session_tables(&mut self) -> Result<(), BidsError> {
        for pseudonym in self.people.keys().cloned().collect::<Vec<_>>() {
            let sub = self.labels[PARTICIPANT].label(&pseudonym)?;
            let mut table =
                Table::new(texts::SESSION_COLUMNS.map(|(name, _)| Column::new(name, name)));
            let own = self.sessions.iter().filter(|(of, _)| *of == pseudonym);
            for (_, facts) in own.cloned().collect::<Vec<_>>() {
                let row = self.session_row(&pseudonym, &facts)?;
                table.rows.push(row);
                self.scans_table(&pseudonym, &facts)?;
            }
            let file = format!("sub-{sub}/sub-{sub}_sessions.tsv");
            self.folder.put_text(&file, &tsv_text(&table, &file)?)?;
            let columns: Columns = texts::SESSION_COLUMNS
                .iter()
                .map(|(name, meaning)| ((*name).to_owned(), texts::column(meaning)))
                .collect();
            self.folder
                .put_json(&format!("sub-{sub}/sub-{sub}_sessions.json"), &columns)?;
        }
        Ok(())
    }

    fn session_row(
        &mut self,
        pseudonym: &str,
        facts: &SessionFacts,
    ) -> Result<Vec<Cell>, BidsError> {
        let ses = self.labels[SESSION].label(&facts.session)?;
        let person = self.people.get(pseudonym);
        let calendar = person.map(|(_, calendar)| *calendar);
        let judge = person.and_then(|(person, _)| person.judge.clone());
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

    fn scans_table(&mut self, pseudonym: &str, facts: &SessionFacts) -> Result<(), BidsError> {
        let key = (pseudonym.to_owned(), facts.session.clone());
        let Some(scans) = self.scans.get(&key) else {
            return Ok(());
        };
        let mut table = Table::new(["filename", "acq_time"].map(|name| Column::new(name, name)));
        table.rows = scans
            .iter()
            .map(|(name, time)| {
                let time = time.as_deref().map_or(Cell::Missing(()), Cell::from);
                vec![Cell::from(name.as_str()), time]
            })
            .collect();
        let of = Entities {
            sub: self.labels[PARTICIPANT].label(pseudonym)?,
            ses: Some(self.labels[SESSION].label(&facts.session)?),
            ..Entities::default()
        };
        let file = format!("{}/{of}_scans.tsv", of.folder());
        self.folder.put_text(&file, &tsv_text(&table, &file)?)
    }

    /// The sidecars of the answers and events of each task, which stand at the root.
    fn task_sidecars(&mut self) -> Result<(), BidsError> {
        for (task, meanings) in self.protocol.tasks.iter().zip(self.meanings.clone()) {
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
}

/// The file `name` of the folder `beh`, from the root: its name says whose it is.
fn beside(name: &str) -> String {
    let file = name.rsplit('/').next().unwrap_or_default();
    let mut parts = file.split('_');
    let sub = parts.next().unwrap_or_default();
    let ses = parts.next().unwrap_or_default();
    format!("{sub}/{ses}/{name}")
}

/// Whether the first step of the provenance is a label that somebody typed.
fn has_label(touched: &Touched<'_>) -> bool {
    let first = touched.recording.about.provenance.steps.first();
    touched.named_by == NamedBy::Person
        && is_of_a_bench(touched)
        && first.is_some_and(|first| first != NO_LABEL)
}

/// A protocol without what somebody noted in it: its values alone. One that is none stays out.
fn without_comments(text: &str) -> String {
    let values: Result<toml::Table, _> = toml::from_str(text);
    let text = values.ok().and_then(|values| toml::to_string(&values).ok());
    text.unwrap_or_default()
}
