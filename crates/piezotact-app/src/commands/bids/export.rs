//! `piezotact bids export`: a study as a data set.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::quantity::Hertz;
use piezotact::warning::{Warning, merged};
use piezotact_dataset::eeg::read_eeg_source;
use piezotact_dataset::{NamePattern, texture_file_name};
use piezotact_people::association::{StimulusFiles, behaviour, playing_events};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::{Protocol, TaskKind};
use piezotact_people::campaign::session::{Stage, State};
use piezotact_people::campaign::store::{Purpose, SessionEntry};
use piezotact_study::bids::{
    BidsWriter, Brain, BrainAbout, DatasetAbout, Exported, Followed, NamedBy, NotCarried, Person,
    SessionFacts, Touched,
};
use piezotact_study::store::Pseudonym;

use super::{derived, laboratory, recordings};
use crate::advice::merged_text;
use crate::cli::Reading;
use crate::commands::campaign::{simulated_as, study::Study};
use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::{Between, interrupted};
use crate::invocation::PROGRAM;
use crate::places::outputs;
use crate::progress::{Words, Work};
use crate::reading::read;

pub(super) const WRITING: Words = Words {
    doing: "writing",
    done: "written",
    item: "recording",
    then: "completing the data set",
};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of the study; without one, the recordings are a data set without sessions.
    #[arg(value_name = "STUDY", required_unless_present = "recordings")]
    study: Option<PathBuf>,
    /// The folder to write, which is not there yet.
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: PathBuf,
    /// Recordings of strokes, each of one participant and one sample.
    #[arg(long, value_name = "FILES", num_args = 1..)]
    pub(super) recordings: Vec<PathBuf>,
    /// Pattern that reads participant and sample from the file names, such as '{participant}_{sample}_{repeat}'.
    #[arg(long, value_name = "PATTERN")]
    pub(super) meta: Option<NamePattern>,
    /// Without STUDY: the participant of recordings and transfer functions that name none.
    #[arg(long, value_name = "NAME", conflicts_with = "study", value_parser = line)]
    pub(super) participant: Option<String>,
    /// Without STUDY: what was done, in one word.
    #[arg(long, value_name = "NAME", conflicts_with = "study", default_value = "touch", value_parser = line)]
    pub(super) task: String,
    /// EEG recordings, each of one participant and one task of the protocol.
    #[arg(long, value_name = "FILES", num_args = 1..)]
    pub(super) eeg: Vec<PathBuf>,
    /// Pattern that reads participant and task from the names of the EEG files.
    #[arg(
        long,
        value_name = "PATTERN",
        default_value = "{participant}_{task}",
        requires = "eeg"
    )]
    eeg_meta: NamePattern,
    /// The reference of the EEG electrodes, in words such as 'average of the mastoids'.
    #[arg(long, value_name = "WORDS", requires = "eeg", value_parser = line)]
    eeg_reference: Option<String>,
    /// The frequency of the mains where the EEG was recorded: 50Hz or 60Hz.
    #[arg(long, value_name = "FREQUENCY", requires = "eeg", value_parser = frequency)]
    line: Option<Hertz>,
    /// Transfer functions of the participants, as derived data.
    #[arg(long, value_name = "FILES", num_args = 1..)]
    pub(super) transfer: Vec<PathBuf>,
    /// The name of the data set; default: the title of the protocol, or `Recordings of touch`.
    #[arg(long, value_parser = line)]
    pub(super) name: Option<String>,
    /// An author, as to be cited; once for each.
    #[arg(long, value_name = "NAME", value_parser = line)]
    pub(super) author: Vec<String>,
    /// The licence under which others may use it, such as CC0 or CC-BY-4.0.
    #[arg(long, value_parser = line)]
    pub(super) license: Option<String>,
    #[command(flatten)]
    pub(super) reading: Reading,
    #[command(flatten)]
    pub(super) outputs: Outputs,
}

/// A frequency with its unit.
fn frequency(text: &str) -> Result<Hertz, String> {
    match text.trim_end_matches("Hz").trim().parse::<f64>() {
        Ok(hz) if (1.0..=1000.0).contains(&hz) => Ok(Hertz(hz)),
        _ => Err("expected a frequency from 1 Hz to 1000 Hz, such as 50Hz".to_owned()),
    }
}

/// A line of text.
pub(super) fn line(text: &str) -> Result<String, String> {
    if text.trim().is_empty() {
        return Err("expected some words, found none; leave the option out".to_owned());
    }
    piezotact_people::campaign::text::check_line(text).map_err(|error| error.to_string())?;
    Ok(text.to_owned())
}

/// A session that is exported.
struct Session<'a> {
    participant: Pseudonym,
    state: State<'a>,
    folder: PathBuf,
}

pub(super) fn run(args: &Arguments) -> Outcome {
    match &args.study {
        Some(folder) => of_study(args, folder),
        None => laboratory::run(args),
    }
}

fn of_study(args: &Arguments, folder: &Path) -> Outcome {
    let study = Study::open(folder)?;
    piezotact_study::bids::require_outside(folder, &args.out)?;
    outputs(&[], &args.outputs.files())?;
    let live = study.live()?;
    let counted_in: Vec<&(SessionEntry, Plan)> = (live.iter())
        .filter(|(entry, _)| entry.purpose == Purpose::Volunteer)
        .collect();
    let rehearsals = live.len() - counted_in.len();
    let withdrawn = study.sessions()?.len() - live.len();
    let sessions = sessions(&study, &counted_in)?;
    if sessions.is_empty() {
        return Err(Failure::Data(anyhow!(
            "{}: expected a study with a session that counts, found none; export it when somebody took part",
            folder.display()
        )));
    }
    let text = piezotact_dataset::read_input_text(&folder.join("protocol.toml"))?;
    let campaign = &study.campaign;
    let known_by = format!("{} {}", campaign.protocol_sha, campaign.seed);
    let known_by = Sha::of(known_by.as_bytes()).to_string();
    let simulated = simulated_as(&study)?;
    let warnings = study.warnings()?;
    let in_words = in_words(&warnings);
    let about = DatasetAbout {
        name: args.name.as_deref().unwrap_or(&campaign.protocol.title),
        authors: &args.author,
        license: args.license.as_deref(),
        program: PROGRAM,
        study: &known_by,
        followed: Some(Followed {
            protocol: &campaign.protocol,
            text: &text,
        }),
        simulated: simulated.as_deref(),
        warnings: &in_words,
    };
    let writer = BidsWriter::create(&args.out, about)?;
    let left_out = [rehearsals, withdrawn];
    let (mut exported, place) = written(args, (&study, &sessions), writer, left_out)?;
    exported.warnings.extend(warnings);
    deliver_and(&args.outputs, &exported, &[&place])
}

fn in_words(warnings: &[Warning]) -> Vec<String> {
    merged(warnings).iter().map(merged_text).collect()
}

/// Everything, in its place; with how many rehearsals and sessions of people who withdrew are left out.
fn written(
    args: &Arguments,
    (study, sessions): (&Study, &[Session<'_>]),
    writer: BidsWriter<'_>,
    [rehearsals, withdrawn]: [usize; 2],
) -> Outcome<(Exported, PathBuf)> {
    let mut export = Export {
        args,
        protocol: &study.campaign.protocol,
        sessions,
        writer,
        missing_runs: 0,
        uncut: 0,
        recorded: BTreeSet::new(),
        sources: BTreeMap::new(),
        said: recordings::Said::default(),
    };
    export.people()?;
    export.played()?;
    export.touched()?;
    export.brains()?;
    export.derived(study)?;
    let mut not_carried = export.not_carried();
    not_carried.extend((rehearsals > 0).then_some(NotCarried::Rehearsals {
        sessions: rehearsals,
    }));
    not_carried.extend((withdrawn > 0).then_some(NotCarried::Withdrawn {
        sessions: withdrawn,
    }));
    let in_words = export.said.in_words();
    let (mut exported, place) = export.writer.finish(not_carried, &in_words)?;
    export.said.put_into(&mut exported);
    Ok((exported, place))
}

fn sessions<'a>(study: &'a Study, live: &[&'a (SessionEntry, Plan)]) -> Outcome<Vec<Session<'a>>> {
    let sessions = live.iter().map(|(_, plan)| {
        let participant = Pseudonym::new(&plan.participant)?;
        Ok(Session {
            folder: study.store.participant_folder(&participant),
            state: study.state(plan)?,
            participant,
        })
    });
    sessions.collect()
}

/// A data set that is being written.
struct Export<'a> {
    args: &'a Arguments,
    protocol: &'a Protocol,
    sessions: &'a [Session<'a>],
    writer: BidsWriter<'a>,
    missing_runs: usize,
    uncut: usize,
    /// The participants and samples of whom a recording was given.
    recorded: BTreeSet<(String, String)>,
    /// The recordings of strokes by participant and sample, from the root.
    sources: BTreeMap<(String, String), Vec<String>>,
    said: recordings::Said,
}

/// The files of one session that its tables name.
#[derive(Default)]
struct Files {
    drives: BTreeMap<String, String>,
    recordings: BTreeMap<String, String>,
}

impl StimulusFiles for Files {
    fn drive(&self, stimulus: &str) -> Option<String> {
        self.drives.get(stimulus).cloned()
    }

    fn recording(&self, journal: &str) -> Option<String> {
        self.recordings.get(journal).cloned()
    }
}

impl Export<'_> {
    fn people(&mut self) -> Outcome {
        let mut people: BTreeMap<&str, Person> = BTreeMap::new();
        for session in self.sessions {
            let who = session.state.participant();
            let began_ms = session.state.began_ms().unwrap_or_default();
            let person = people
                .entry(session.participant.as_str())
                .or_insert_with(|| Person {
                    pseudonym: session.participant.as_str().to_owned(),
                    first_ms: began_ms,
                    ..Person::default()
                });
            person.first_ms = person.first_ms.min(began_ms);
            person.age_years = person.age_years.or(who.age_years);
            person.sex = person.sex.take().or(who.sex.clone());
            person.handedness = person.handedness.take().or(who.handedness.clone());
            person.is_virtual |= who.judge.is_some();
            person.judge = person
                .judge
                .take()
                .or(who.judge.map(|judge| judge.name().to_owned()));
        }
        for person in people.into_values() {
            self.writer.person(person)?;
        }
        for session in self.sessions {
            self.writer
                .session(session.participant.as_str(), facts(&session.state))?;
        }
        Ok(())
    }

    /// The drives, recordings and answers of the sessions.
    fn played(&mut self) -> Outcome {
        let sessions = self.sessions;
        let writing = Work::of_sizes(WRITING, vec![1.0; sessions.len()]);
        let between = Between::items("session");
        for session in sessions {
            goes_on()?;
            self.session(session)?;
            writing.one_more();
        }
        drop((writing, between));
        Ok(())
    }

    fn session(&mut self, session: &Session<'_>) -> Outcome {
        let state = &session.state;
        let (participant, name) = (session.participant.as_str(), state.plan().session.as_str());
        let folder = session.folder.join(name);
        let mut files = Files::default();
        for stimulus in piezotact_people::campaign::readiness::stimuli_of(state.plan()) {
            let drive = folder
                .join("drives")
                .join(format!("{}.wav", texture_file_name(stimulus)));
            if drive.is_file() {
                let written = self.writer.stimulus(participant, name, stimulus, &drive)?;
                files.drives.insert(stimulus.to_owned(), written);
            }
        }
        for (trial, of) in state.trials() {
            for (element, one) in &of.evidence {
                let Some(journal) = &one.journal else {
                    continue;
                };
                let place = folder.join(journal);
                if !place.is_file() {
                    self.missing_runs += 1;
                    continue;
                }
                let recording = read(&place, &self.args.reading)?.recording;
                let events = playing_events(trial, *element, one);
                let touched = Touched {
                    participant,
                    session: Some(name),
                    task: &trial.task,
                    sample: Some(&one.stimulus),
                    recording: &recording,
                    at_ms: None,
                    events: Some(&events),
                    file: &place,
                    named_by: NamedBy::Session,
                };
                let written = self.writer.recording(&touched)?;
                files.recordings.insert(journal.clone(), written);
            }
        }
        for of_task in behaviour(state, &files) {
            self.writer
                .behaviour(participant, name, &of_task, state.began_ms())?;
        }
        Ok(())
    }

    /// The recordings of strokes.
    fn touched(&mut self) -> Outcome {
        let writing = Work::of_files(WRITING, &self.args.recordings);
        let between = Between::items("recording");
        recordings::distinct(&self.args.recordings)?;
        for path in &self.args.recordings {
            goes_on()?;
            let meta = self.args.meta.as_ref();
            let strokes = recordings::strokes(path, meta, None, &self.args.reading)?;
            let sample = strokes.sample.clone();
            let sample =
                sample.ok_or_else(|| recordings::none_named(path, "sample", "or in a sidecar"))?;
            let (session, task) = self.place_of(path, (&strokes.participant, &sample))?;
            self.uncut += usize::from(strokes.take.is_none());
            self.said.add_of(&strokes);
            let at = (Some(session.as_str()), task.as_str());
            let written = strokes.write(&mut self.writer, path, at)?;
            let key = (strokes.participant.clone(), sample.clone());
            self.sources.entry(key.clone()).or_default().push(written);
            self.recorded.insert(key);
            writing.one_more();
        }
        drop((writing, between));
        Ok(())
    }

    /// The session and the task of the recording in `path`.
    fn place_of(
        &self,
        path: &Path,
        (participant, sample): (&str, &String),
    ) -> Outcome<(String, String)> {
        let refused = |text: String| usage(anyhow!("{}: {text}", path.display()));
        let known: BTreeSet<&str> = self
            .sessions
            .iter()
            .map(|one| one.participant.as_str())
            .collect();
        if !known.contains(participant) {
            return Err(refused(format!(
                "expected a recording of a participant of the study ({}), found one of {}; correct its name, or leave it out",
                known.into_iter().collect::<Vec<_>>().join(", "),
                participant
            )));
        }
        if !self.protocol.samples.contains(sample) {
            return Err(refused(format!(
                "expected a recording of a sample of the protocol ({}), found one of {}; correct its name, or leave it out",
                self.protocol.samples.join(", "),
                sample
            )));
        }
        let own = self
            .sessions
            .iter()
            .filter(|one| one.participant.as_str() == participant);
        for session in own {
            let mut touching = session.state.trials().filter(|(trial, _)| {
                let task = self.protocol.task(&trial.task);
                task.is_some_and(|task| matches!(task.kind, TaskKind::Touch { .. }))
                    && trial.presented.names().contains(sample)
            });
            if let Some((trial, _)) = touching.next() {
                return Ok((session.state.plan().session.clone(), trial.task.clone()));
            }
        }
        Err(refused(format!(
            "expected a session of {} in which {} is touched and recorded, found none in the study; lead it with piezotact campaign run, or leave the recording out",
            participant, sample
        )))
    }

    /// The EEG recordings.
    fn brains(&mut self) -> Outcome {
        let about = BrainAbout {
            reference: self.args.eeg_reference.clone(),
            line_hz: self.args.line.map(|hz| hz.0),
        };
        let writing = Work::of_files(WRITING, &self.args.eeg);
        let between = Between::items("recording");
        for path in &self.args.eeg {
            goes_on()?;
            let (participant, task) = self.whose(path)?;
            let session = self.session_of(path, &participant, &task)?;
            let source = read_eeg_source(path)?;
            for segment in source.segments.into_iter().map(|part| part.recording) {
                self.said.add(&segment.about.warnings);
                self.writer.eeg(Brain {
                    participant: &participant,
                    session: &session,
                    task: &task,
                    recording: segment,
                    channels: &source.channels,
                    about: &about,
                })?;
            }
            writing.one_more();
        }
        drop((writing, between));
        Ok(())
    }

    /// The participant and the task in the name of an EEG file.
    fn whose(&self, path: &Path) -> Outcome<(String, String)> {
        let naming = self.args.eeg_meta.read(path).map_err(usage)?;
        let task = naming.labels.get("task").cloned();
        match (naming.condition.participant, task) {
            (Some(participant), Some(task)) => Ok((participant, task)),
            _ => Err(usage(anyhow!(
                "{}: expected a pattern with {{participant}} and {{task}}, found one without; state both in --eeg-meta",
                path.display()
            ))),
        }
    }

    /// The session of a participant in which a task was.
    fn session_of(&self, path: &Path, participant: &str, task: &str) -> Outcome<String> {
        let names: Vec<&str> = (self.protocol.tasks.iter())
            .map(|task| task.name.as_str())
            .collect();
        let mut own = self
            .sessions
            .iter()
            .filter(|one| one.participant.as_str() == participant);
        let found = own.find(|one| one.state.trials().any(|(trial, _)| trial.task == task));
        found.map(|one| one.state.plan().session.clone()).ok_or_else(|| {
            usage(anyhow!(
                "{}: expected EEG of a participant of the study in a task of a session that was held (tasks: {}), found participant {participant}, task {task}; correct its name, or leave it out",
                path.display(),
                names.join(", ")
            ))
        })
    }

    /// What was computed of the study.
    fn derived(&mut self, study: &Study) -> Outcome {
        for session in self.sessions {
            let name = &session.state.plan().session;
            let of = (session.participant.as_str(), name.as_str());
            for one in derived::of_drives(of, &session.folder.join(name), session.state.plan())? {
                self.writer.derived(&one.borrowed())?;
            }
        }
        // The first session of each counts.
        let people = self.sessions.iter().rev().map(|one| {
            let session = one.state.plan().session.clone();
            (one.participant.as_str().to_owned(), Some(session))
        });
        let people = people.collect();
        for path in &self.args.transfer {
            let one = derived::of_transfer(path, None, &people)?;
            self.writer.derived(&one.borrowed())?;
        }
        for one in derived::of_answers(study)? {
            self.writer.derived(&one.borrowed())?;
        }
        Ok(())
    }

    /// What the study holds and the data set does not carry.
    fn not_carried(&self) -> Vec<NotCarried> {
        let mut unrecorded = 0;
        let (mut unpresented, mut void) = (0, 0);
        let mut old = BTreeSet::new();
        for session in self.sessions {
            let participant = session.participant.as_str();
            if session
                .state
                .participant()
                .age_years
                .is_some_and(|age| age >= 90)
            {
                old.insert(participant);
            }
            for (trial, of) in session.state.trials() {
                unpresented += usize::from(of.at_ms[0].is_none());
                void += of.attempts.saturating_sub(1);
                let task = self.protocol.task(&trial.task);
                if task.is_some_and(|task| matches!(task.kind, TaskKind::Touch { .. }))
                    && of.confirmed
                {
                    let missing = trial.presented.names().iter().any(|sample| {
                        !self
                            .recorded
                            .contains(&(participant.to_owned(), sample.clone()))
                    });
                    unrecorded += usize::from(missing);
                }
            }
        }
        let dated = self.writer.dated();
        let pseudonyms = self.sessions.iter().map(|one| one.participant.as_str());
        let wordlike = wordlike(pseudonyms, self.writer.words());
        let counts = [
            (void > 0).then_some(NotCarried::VoidAttempts { attempts: void }),
            (!old.is_empty()).then_some(NotCarried::Ages { people: old.len() }),
            (dated > 0).then_some(NotCarried::DatedFiles { files: dated }),
            (self.missing_runs > 0).then_some(NotCarried::MissingRuns {
                runs: self.missing_runs,
            }),
            (unrecorded > 0).then_some(NotCarried::Unrecorded { trials: unrecorded }),
            (self.uncut > 0).then_some(NotCarried::Uncut {
                recordings: self.uncut,
            }),
            (self.sessions.iter())
                .any(|one| one.state.participant().judge.is_some())
                .then_some(NotCarried::Cues),
            (!self.args.eeg.is_empty()).then_some(NotCarried::EegOriginals {
                recordings: self.args.eeg.len(),
            }),
            wordlike,
        ];
        let always = [
            NotCarried::Dates,
            NotCarried::TypedTexts,
            NotCarried::Identities,
            NotCarried::Steps,
            NotCarried::Rendering,
            NotCarried::Plans { unpresented },
        ];
        always
            .into_iter()
            .chain(counts.into_iter().flatten())
            .collect()
    }
}

/// The pseudonyms that are no code of up to three letters and four digits, which may be names, dates or numbers of telephones, and `words` of
/// other programs.
pub(super) fn wordlike<'p>(
    pseudonyms: impl Iterator<Item = &'p str>,
    words: &BTreeSet<String>,
) -> Option<NotCarried> {
    let is_code = |name: &str| {
        let number = name.trim_start_matches(|sign: char| sign.is_ascii_alphabetic());
        let letters = name.len() - number.len();
        letters <= 3
            && (1..=4).contains(&number.len())
            && number.chars().all(|sign| sign.is_ascii_digit())
    };
    let found: BTreeSet<String> = pseudonyms
        .filter(|name| !is_code(name))
        .map(|name| format!("{name} (participant)"))
        .collect();
    let words: Vec<String> = found.into_iter().chain(words.iter().cloned()).collect();
    (!words.is_empty()).then_some(NotCarried::Wordlike { words })
}

/// What is known of a session.
fn facts(state: &State<'_>) -> SessionFacts {
    let who = state.participant();
    let planned: usize = state.progress().values().map(|(_, planned)| planned).sum();
    SessionFacts {
        session: state.plan().session.clone(),
        began_ms: state.began_ms(),
        ended: match state.stage() {
            _ if state.is_complete() => "complete",
            Stage::Ended => "ended",
            Stage::Stopped => "stopped",
            _ => "open",
        },
        confirmed: state.confirmed(),
        planned,
        sex: who.sex.clone(),
        age_years: who.age_years,
        handedness: who.handedness.clone(),
        finger: who.finger.clone(),
        language: who.language.clone(),
    }
}

/// Ends the command where a signal came.
pub(super) fn goes_on() -> Outcome {
    match interrupted() {
        true => Err(Failure::Data(anyhow!(
            "the data set is not complete, and nothing of it was kept; the same command begins anew"
        ))),
        false => Ok(()),
    }
}
