//! `piezotact campaign verify`: whether what is stored is what was written.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::number::counted;
use piezotact::quantity::Acceleration;
use piezotact_bench::procedure::ACCELERATION_CHANNEL;
use piezotact_dataset::reads;
use piezotact_dataset::{ReadOptions, read_recording};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::{State, sha_of_samples};
use piezotact_people::campaign::store::Store as _;
use piezotact_study::store::{Kept, Pseudonym};

use super::study::{Begun, Study};
use crate::failure::{Failure, Outcome};
use crate::output::{print, say};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let sessions = study.store.verify()?;
    let checked = each_session(&study)?;
    print(&format!(
        "{}: {} verified: no event was changed, reordered or removed{} are found only by comparing the checksums above with a copy of them: keep one outside the study. Drives are not checked.",
        args.study.display(),
        counted(sessions, "session"),
        match study.store.kept() {
            Kept::InFolder =>
                ", by the changes that the study counted. Journals that were rewritten together with that number",
            Kept::OnServer =>
                " from the middle. Missing sessions, missing last events and rewritten journals",
        }
    ))?;
    let unexplained = study.store.unexplained_changes()?;
    if unexplained > 0 {
        say(&format!(
            "warning: {unexplained} of the changes that the study counted are not there: a withdrawal was given again, or last events were removed; compare the checksums above with a copy of them"
        ));
    }
    checked.say();
    match checked.wrong.len() {
        0 => Ok(()),
        wrong => Err(Failure::Data(anyhow!(
            "{wrong} of {} recordings are not those that were made while the stimuli played; restore them from a copy of the study",
            checked.alike + wrong
        ))),
    }
}

/// Prints what is found of every session; gives what was found of the recordings.
fn each_session(study: &Study) -> Outcome<Recordings> {
    let mut checked = Recordings::default();
    for Begun {
        entry,
        plan,
        unreadable,
    } in study.sessions()?
    {
        if let Some(why) = unreadable {
            return Err(why);
        }
        let events = study.store.events(&entry.key)?.len();
        let head = study.store.head(&entry.key)?;
        let head = head.map_or_else(|| "no event".to_owned(), |head| head.to_string());
        let what = match plan {
            Some(plan) => {
                // Its events follow from each other, and belong to its plan.
                let recordings = recordings(study, &study.state(&plan)?)?;
                let what = recordings.words();
                checked.add(recordings);
                what
            }
            None => "erased after a withdrawal, the chain is whole".to_owned(),
        };
        print(&format!(
            "{} {}: {events} events, {what}; ends with {head}",
            entry.key.participant, entry.key.session
        ))?;
    }
    Ok(checked)
}

/// The recordings of what was played, compared with what the events say of them.
#[derive(Default)]
struct Recordings {
    alike: usize,
    /// Those of sessions at other stations, which are not in this folder.
    elsewhere: usize,
    /// Those that no counted answer names.
    uncounted: Vec<PathBuf>,
    /// What is wrong, one sentence for each.
    wrong: Vec<String>,
}

impl Recordings {
    /// Says what is elsewhere, uncounted and wrong.
    fn say(&self) {
        if self.elsewhere > 0 {
            say(&format!(
                "{} recordings of what was played are not in this folder: they were made at other stations, or are missing; verify them there",
                self.elsewhere
            ));
        }
        if let Some(first) = self.uncounted.first() {
            say(&format!(
                "{} of attempts that were void, repeated or interrupted: no answer counts them, and they are not verified; the first is {}",
                counted(self.uncounted.len(), "recording"),
                first.display()
            ));
        }
        for one in &self.wrong {
            say(one);
        }
    }

    fn add(&mut self, other: Self) {
        self.alike += other.alike;
        self.elsewhere += other.elsewhere;
        self.uncounted.extend(other.uncounted);
        self.wrong.extend(other.wrong);
    }

    fn words(&self) -> String {
        match (self.alike, self.wrong.len()) {
            (0, 0) => "whole".to_owned(),
            (alike, 0) => format!("whole, with the {alike} recordings of what was played"),
            (alike, wrong) => {
                format!(
                    "whole, but {wrong} of {} recordings of what was played are not",
                    alike + wrong
                )
            }
        }
    }
}

/// The recordings of the playings that count in a session.
fn recordings(study: &Study, state: &State<'_>) -> Outcome<Recordings> {
    let plan = state.plan();
    let participant = Pseudonym::new(&plan.participant)?;
    let folder = study.store.session_folder(&participant, &plan.session)?;
    let mut found = Recordings {
        uncounted: runs_in(&folder),
        ..Recordings::default()
    };
    for (_, trial) in state.trials() {
        let played = trial.evidence.iter();
        let played = played.filter_map(|(_, one)| Some((one.journal.as_ref()?, one.recorded?)));
        let touched = trial.touched.iter().flat_map(|one| &one.recordings);
        let touched = touched.filter_map(|one| Some((&one.journal, one.recorded?)));
        for (journal, recorded) in played.chain(touched) {
            found.uncounted.retain(|run| *run != folder.join(journal));
            if study.store.kept() == Kept::OnServer && !reads::is_there(&folder.join(journal)) {
                found.elsewhere += 1;
                continue;
            }
            match is_recorded(&folder.join(journal), recorded) {
                Ok(true) => found.alike += 1,
                Ok(false) => found.wrong.push(format!(
                    "{}: expected the recording that was made in session {} of {participant}, found another",
                    folder.join(journal).display(),
                    plan.session
                )),
                Err(error) => found.wrong.push(error.to_string()),
            }
        }
    }
    Ok(found)
}

/// The recordings in the folder of a session, by name.
fn runs_in(folder: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(folder.join("runs")).into_iter().flatten();
    let files = files.filter_map(|file| Some(file.ok()?.path()));
    let mut runs: Vec<PathBuf> = files
        .filter(|file| {
            file.extension()
                .is_some_and(|of| of == "parquet" || of == "part")
        })
        .collect();
    runs.sort();
    runs
}

/// Whether the acceleration in `file` is the one whose checksum was noted while it was recorded.
fn is_recorded(file: &Path, noted: Sha) -> anyhow::Result<bool> {
    let recording = read_recording(file, &ReadOptions::default())?.recording;
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
    Ok(sha_of_samples(response.samples()) == noted)
}
