//! The recordings that are exported with a study: strokes that are given, and playings that the study has.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::invocation::Found;
use piezotact::number::counted;
use piezotact::page::Table;
use piezotact::quantity::Unit;
use piezotact::recording::{Event, Recording};
use piezotact::study::{
    self, AnalysedRecording, Breadth, Factor, Gesture, Question, Recorded, Stated, StudySettings,
    events_table,
};
use piezotact::warning::{Warning, merged};
use piezotact_dataset::{NamePattern, cuts_path, known_naming, read_cuts_of, reads};
use piezotact_study::bids::{BidsWriter, Exported, NamedBy, Touched, warnings_carried};

use super::derived;
use crate::advice::merged_text;
use crate::cli::Reading;
use crate::failure::{Failure, Outcome, usage};
use crate::reading::read;
use crate::report::name;

/// A recording of strokes, with what was found in it.
pub(super) struct Strokes {
    pub(super) participant: String,
    /// Absent where none is stated.
    pub(super) sample: Option<String>,
    pub(super) recording: Recording,
    /// What happened in it; absent where its strokes could not be cut.
    pub(super) events: Option<Table>,
    /// With its features and spectra, where it has strokes.
    pub(super) take: Option<AnalysedRecording>,
}

impl Strokes {
    /// Writes the recording, of the file at `path`, with what was derived from it; gives its name in the data set.
    pub(super) fn write(
        &self,
        writer: &mut BidsWriter<'_>,
        path: &Path,
        (session, task): (Option<&str>, &str),
    ) -> Outcome<String> {
        let touched = Touched {
            participant: &self.participant,
            session,
            task,
            sample: self.sample.as_deref(),
            recording: &self.recording,
            at_ms: None,
            events: self.events.as_ref(),
            file: path,
            named_by: NamedBy::Person,
        };
        let written = writer.recording(&touched)?;
        if let Some(take) = &self.take {
            for one in derived::of_strokes(take, &touched, &written) {
                writer.derived(&one.borrowed())?;
            }
        }
        Ok(written)
    }
}

/// The checksums of `paths`.
///
/// # Errors
/// Two files of the same bytes.
pub(super) fn distinct(paths: &[PathBuf]) -> Outcome<Vec<String>> {
    let mut known: BTreeMap<String, &PathBuf> = BTreeMap::new();
    for path in paths {
        let Found::File { sha256, .. } = reads::found(path) else {
            // What cannot be read is said when it is read.
            continue;
        };
        if let Some(other) = known.insert(sha256, path) {
            return Err(usage(anyhow!(
                "expected recordings that differ, found {} with the bytes of {}; give one of them",
                path.display(),
                other.display()
            )));
        }
    }
    Ok(known.into_keys().collect())
}

/// The recording at `path`, with its strokes; of the participant `otherwise` where it names nobody.
pub(super) fn strokes(
    path: &Path,
    meta: Option<&NamePattern>,
    otherwise: Option<&str>,
    reading: &Reading,
) -> Outcome<Strokes> {
    let mut recording = read(path, reading)?.recording;
    require_touch(path, &recording)?;
    // Reading has warned of them.
    let outside = recording.annotations.outside(recording.duration());
    let outside: Vec<Event> = outside.into_iter().cloned().collect();
    let events = &mut recording.annotations.events;
    events.retain(|event| !outside.contains(event));
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
    let named = own.participant.or(naming.condition.participant.clone());
    let mut stated = Stated::nothing();
    if named.is_none() {
        stated.condition.participant = otherwise.map(str::to_owned);
    }
    let participant = named.or(stated.condition.participant.clone());
    let participant = participant.ok_or_else(|| {
        none_named(
            path,
            "participant",
            "in a sidecar, or, without a study, with --participant",
        )
    })?;
    let sample = own.sample.or(naming.condition.sample.clone());
    let recorded = Recorded {
        file: path.display().to_string(),
        name: name(path),
        recording: recording.clone(),
        naming,
        cuts,
        cuts_are_looked_for_in: beside.display().to_string(),
    };
    // Strokes that cannot be cut are no reason to leave a recording out.
    let Ok(take) = study::cut(recorded, &stated) else {
        recording.about.condition.participant = Some(participant.clone());
        recording.about.condition.sample.clone_from(&sample);
        return Ok(Strokes {
            participant,
            sample,
            recording,
            events: None,
            take: None,
        });
    };
    // A motion may have come from another clock.
    let motion = take.segmentation.roles.motion.as_ref();
    let channels = take.recording.channels().iter();
    let clock = channels
        .map(|channel| channel.name.as_str())
        .min_by_key(|name| motion.is_some_and(|motion| motion.channel() == *name))
        .map(|name| recording.clock_of(name));
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

/// A recording that does not say whose, or of what, it is.
pub(super) fn none_named(path: &Path, what: &str, or: &str) -> Failure {
    Failure::Data(anyhow!(
        "{}: expected a recording that names its {what}, found none; state it in the file name with --meta, {or}",
        path.display()
    ))
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

/// What a person should know of the recordings that are exported: all of it for who exports, and what the data set may say.
#[derive(Default)]
pub(super) struct Said {
    own: Vec<Warning>,
    carried: Vec<Warning>,
}

impl Said {
    /// Adds warnings that the data set may repeat.
    pub(super) fn add(&mut self, warnings: &[Warning]) {
        self.own.extend_from_slice(warnings);
        self.carried.extend_from_slice(warnings);
    }

    /// Adds what is known of a recording of strokes.
    pub(super) fn add_of(&mut self, strokes: &Strokes) {
        let about = &strokes.recording.about;
        let bench = about.provenance.bench;
        let mut warnings = about.warnings.clone();
        warnings.extend(strokes.take.iter().flat_map(AnalysedRecording::warnings));
        self.own.extend_from_slice(&warnings);
        self.carried.extend(warnings_carried(bench, warnings));
    }

    /// The sentences of the data set.
    pub(super) fn in_words(&self) -> Vec<String> {
        merged(&self.carried).iter().map(merged_text).collect()
    }

    /// Puts all into what is said of the export.
    pub(super) fn put_into(self, exported: &mut Exported) {
        for warning in self.own {
            if !exported.warnings.contains(&warning) {
                exported.warnings.push(warning);
            }
        }
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
