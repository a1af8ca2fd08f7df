//! `piezotact bids export` without a study: recordings and transfer functions of a laboratory, as a data set without sessions.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::anyhow;
use piezotact::recording::BenchKind;
use piezotact_people::campaign::chain::Sha;
use piezotact_study::bids::{BidsWriter, Calendar, DatasetAbout, Exported, NotCarried, Person};

use super::export::{Arguments, WRITING, goes_on, wordlike};
use super::{derived, recordings};
use crate::deliver::deliver_and;
use crate::failure::{Outcome, usage};
use crate::interrupt::Between;
use crate::invocation::PROGRAM;
use crate::places::outputs;
use crate::progress::Work;

/// The name of a data set that nobody named.
const NO_NAME: &str = "Recordings of touch";

pub(super) fn run(args: &Arguments) -> Outcome {
    outputs(&[], &args.outputs.files())?;
    if !args.eeg.is_empty() {
        return Err(usage(anyhow!(
            "expected a study for --eeg, found recordings alone; give the folder of the study, or write EEG alone with mne-bids"
        )));
    }
    let sums = recordings::distinct(&args.recordings)?;
    let known_by = Sha::of(sums.join(" ").as_bytes()).to_string();
    let about = DatasetAbout {
        name: args.name.as_deref().unwrap_or(NO_NAME),
        authors: &args.author,
        license: args.license.as_deref(),
        program: PROGRAM,
        study: &known_by,
        followed: None,
        simulated: None,
        warnings: &[],
    };
    let mut laboratory = Laboratory {
        args,
        writer: BidsWriter::create(&args.out, about)?,
        people: BTreeMap::new(),
        benches: Vec::new(),
        dates: 0,
        uncut: 0,
        said: recordings::Said::default(),
    };
    laboratory.recordings()?;
    laboratory.transfer_functions()?;
    let (exported, place) = laboratory.finished()?;
    deliver_and(&args.outputs, &exported, &[&place])
}

/// The data set of a laboratory, while it is written.
struct Laboratory<'a> {
    args: &'a Arguments,
    writer: BidsWriter<'a>,
    people: BTreeMap<String, Person>,
    /// What each recording was made on.
    benches: Vec<Option<BenchKind>>,
    /// How many recordings state when they were begun.
    dates: usize,
    uncut: usize,
    said: recordings::Said,
}

impl Laboratory<'_> {
    fn recordings(&mut self) -> Outcome {
        let args = self.args;
        let writing = Work::of_files(WRITING, &args.recordings);
        let between = Between::items("recording");
        for path in &args.recordings {
            goes_on()?;
            let (meta, otherwise) = (args.meta.as_ref(), args.participant.as_deref());
            let strokes = recordings::strokes(path, meta, otherwise, &args.reading)?;
            self.note_person(&strokes);
            self.uncut += usize::from(strokes.take.is_none());
            self.said.add_of(&strokes);
            strokes.write(&mut self.writer, path, (None, &args.task))?;
            writing.one_more();
        }
        drop((writing, between));
        Ok(())
    }

    /// Notes who was recorded, and when first; somebody of whom every recording is simulated is virtual.
    fn note_person(&mut self, strokes: &recordings::Strokes) {
        let recording = &strokes.recording;
        let bench = recording.about.provenance.bench;
        let is_virtual = bench.is_some_and(|bench| !bench.is_real());
        self.benches.push(bench);
        let started = recording.annotations.started_at.as_ref();
        self.dates += usize::from(started.is_some());
        let began_ms = started.and_then(Calendar::ms_since_1970);
        let person = self
            .people
            .entry(strokes.participant.clone())
            .or_insert_with(|| Person {
                pseudonym: strokes.participant.clone(),
                is_virtual,
                first_ms: i64::MAX,
                ..Person::default()
            });
        person.is_virtual &= is_virtual;
        person.first_ms = person.first_ms.min(began_ms.unwrap_or(i64::MAX));
    }

    fn transfer_functions(&mut self) -> Outcome {
        let people = self.people.keys().map(|name| (name.clone(), None));
        let people = people.collect();
        for path in &self.args.transfer {
            let one = derived::of_transfer(path, self.args.participant.as_deref(), &people)?;
            self.writer.derived(&one.borrowed())?;
        }
        Ok(())
    }

    fn not_carried(&self) -> Vec<NotCarried> {
        let dated = self.writer.dated();
        let found = [
            (self.dates > 0).then_some(NotCarried::Dates),
            Some(NotCarried::TypedTexts),
            Some(NotCarried::Rendering),
            (dated > 0).then_some(NotCarried::DatedFiles { files: dated }),
            (self.uncut > 0).then_some(NotCarried::Uncut {
                recordings: self.uncut,
            }),
            wordlike(self.people.keys().map(String::as_str), self.writer.words()),
        ];
        found.into_iter().flatten().collect()
    }

    /// Writes the tables of people and of the data set.
    fn finished(mut self) -> Outcome<(Exported, PathBuf)> {
        let not_carried = self.not_carried();
        let simulated = BenchKind::simulated(self.benches).into_iter();
        let said: Vec<String> = simulated.chain(self.said.in_words()).collect();
        for mut person in self.people.into_values() {
            if person.first_ms == i64::MAX {
                person.first_ms = 0;
            }
            self.writer.person(person)?;
        }
        let (mut exported, place) = self.writer.finish(not_carried, &said)?;
        self.said.put_into(&mut exported);
        Ok((exported, place))
    }
}
