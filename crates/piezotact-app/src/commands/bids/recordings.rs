//! The recordings that are exported with a study: strokes that are given, and playings that the study has.

use std::path::Path;

use anyhow::anyhow;
use piezotact::number::counted;
use piezotact::page::Table;
use piezotact::quantity::Unit;
use piezotact::recording::Recording;
use piezotact::study::{
    self, AnalysedRecording, Breadth, Factor, Gesture, Question, Recorded, Stated, StudySettings,
    events_table,
};
use piezotact::warning::Warning;
use piezotact_dataset::{NamePattern, cuts_path, known_naming, read_cuts_of, reads};

use crate::cli::Reading;
use crate::failure::{Failure, Outcome, usage};
use crate::reading::read;
use crate::report::name;

/// A recording of strokes, with what was found in it.
pub(super) struct Strokes {
    pub(super) participant: String,
    pub(super) sample: String,
    pub(super) recording: Recording,
    /// What happened in it; absent where its strokes could not be cut.
    pub(super) events: Option<Table>,
    /// With its features and spectra, where it has strokes.
    pub(super) take: Option<AnalysedRecording>,
}

/// The recording at `path`, with its strokes.
pub(super) fn strokes(
    path: &Path,
    meta: Option<&NamePattern>,
    reading: &Reading,
) -> Outcome<Strokes> {
    let recording = read(path, reading)?.recording;
    require_touch(path, &recording)?;
    let naming = match meta {
        Some(pattern) => pattern.read(path).map_err(usage)?,
        None => known_naming(path),
    };
    let beside = cuts_path(path);
    let cuts = match reads::is_there(&beside) {
        true => Some(read_cuts_of(&beside, path)?.0),
        false => None,
    };
    let own = recording.about.condition.clone();
    let [participant, sample] = [
        (own.participant, naming.condition.participant.clone(), "participant"),
        (own.sample, naming.condition.sample.clone(), "sample"),
    ]
    .map(|(own, named, what)| {
        own.or(named).ok_or_else(|| {
            Failure::Data(anyhow!(
                "{}: expected a recording that names its {what}, found none; state it in the file name with --meta, or in a sidecar",
                path.display()
            ))
        })
    });
    let (participant, sample) = (participant?, sample?);
    let recorded = Recorded {
        file: path.display().to_string(),
        name: name(path),
        recording: recording.clone(),
        naming,
        cuts,
        cuts_are_looked_for_in: beside.display().to_string(),
    };
    let mut recording = recording;
    // Strokes that cannot be cut are no reason to leave a recording out.
    let Ok(take) = study::cut(recorded, &Stated::nothing()) else {
        recording
            .about
            .condition
            .participant
            .get_or_insert_with(|| participant.clone());
        recording
            .about
            .condition
            .sample
            .get_or_insert_with(|| sample.clone());
        return Ok(Strokes {
            participant,
            sample,
            recording,
            events: None,
            take: None,
        });
    };
    let clock = take
        .recording
        .channels()
        .first()
        .map(|channel| recording.clock_of(&channel.name));
    let events = events_table(&take, clock.map_or(0.0, |clock| clock.start_s.0));
    recording.about.condition = take.recording.about.condition.clone();
    Ok(Strokes {
        participant,
        sample,
        recording,
        events: Some(events),
        take: analysed(take),
    })
}

/// Refuses signals of a brain or a muscle.
fn require_touch(path: &Path, recording: &Recording) -> Outcome {
    let mut units = recording.channels().iter().map(|channel| &channel.unit);
    match units.all(|unit| *unit == Unit::Volt) {
        true => Err(usage(anyhow!(
            "{}: expected a recording of touch (acceleration, force, position), found {} in V; leave it out",
            path.display(),
            counted(recording.channels().len(), "channel")
        ))),
        false => Ok(()),
    }
}

impl Strokes {
    /// What a person should know before relying on the recording.
    pub(super) fn warnings(&self) -> Vec<Warning> {
        let own = self.recording.about.warnings.iter().cloned();
        own.chain(self.take.iter().flat_map(AnalysedRecording::warnings))
            .collect()
    }
}

/// `take` with its features and spectra; none for one without strokes.
fn analysed(take: AnalysedRecording) -> Option<AnalysedRecording> {
    let settings = StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Groups(Some(Factor::File)),
        breadth: Breadth::Question,
    };
    let study = study::analyse(vec![take], &settings).ok()?;
    study.takes.into_iter().find(|take| take.analysis.is_some())
}
