//! What `strokes` and `compare` share: recordings read, and options as what is stated of a study.

pub(crate) mod compare;
mod cuts;
mod large;
pub(crate) mod strokes;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::quantity::{Measure, Newtons, Unit};
use piezotact::recording::{Condition, Recording, RecordingWarning, SlidingDirection, Touch};
use piezotact::stroke::Judging;
use piezotact::study::{
    self, AnalysedRecording, Breadth, Factor, Gesture, Question, Recorded, Stated, StudyAnalysis,
    StudyError, StudySettings,
};
use piezotact_dataset::reads::is_there;
use piezotact_dataset::{
    cuts_path, known_naming, known_sample_sets, read_cuts_of, read_sample_set,
};

use crate::advice::{merged_text, text};
use crate::cli::{By, CONDITIONS, Computing, DirectionName, Takes, TouchName};
use crate::failure::{Failure, Failures, Outcome, usage};
use crate::memory::fits;
use crate::output::say;
use crate::places::{outputs, place};
use crate::progress::{Words, Work};
use crate::reading::read;
use crate::report::name;

impl From<DirectionName> for SlidingDirection {
    fn from(direction: DirectionName) -> Self {
        match direction {
            DirectionName::Proximal => Self::Proximal,
            DirectionName::Distal => Self::Distal,
            DirectionName::Transversal => Self::Transversal,
            DirectionName::Circular => Self::Circular,
        }
    }
}

const READING: Words = Words {
    doing: "reading",
    done: "read",
    item: "recording",
    then: "reading",
};
const ANALYSING: Words = Words {
    doing: "analysing",
    done: "analysed",
    item: "recording",
    then: "averaging and comparing",
};

/// Refuses outputs that would replace what is read, or each other.
fn check_outputs(takes: &Takes, written: &[&Path]) -> Outcome {
    let mut read: Vec<&Path> = takes.recordings.iter().map(PathBuf::as_path).collect();
    read.extend(takes.cuts.as_deref());
    outputs(&read, written)
}

/// Reads and cuts every recording; one that fails does not stop the others.
pub(crate) fn take_all(args: &Takes) -> Outcome<(Vec<AnalysedRecording>, Failures)> {
    if args.cuts.is_some() && args.recordings.len() > 1 {
        return Err(usage(anyhow!(
            "expected one recording with --cuts, found {}; for several, put RECORDING.cuts beside each of them",
            args.recordings.len()
        )));
    }
    let stated = stated(args)?;
    let mut places = BTreeSet::new();
    if let Some(twice) = (args.recordings.iter()).find(|path| !places.insert(place(path))) {
        return Err(usage(anyhow!(
            "{} is given twice: name every recording once",
            twice.display()
        )));
    }
    let reading = Work::of_files(READING, &args.recordings);
    let mut takes: Vec<AnalysedRecording> = Vec::with_capacity(args.recordings.len());
    let mut failures = Failures::of(args.recordings.len());
    for path in &args.recordings {
        let taken =
            recorded(path, args).and_then(|recorded| study::cut(recorded, &stated).map_err(failed));
        takes.extend(failures.unless_failed(path, taken)?);
        reading.one_more();
    }
    drop(reading);
    if takes.is_empty() {
        failures.outcome()?;
    }
    Ok((takes, failures))
}

/// A recording with its name's condition and a person's cuts.
fn recorded(path: &Path, args: &Takes) -> Outcome<Recorded> {
    let recording = read(path, &args.reading)?.recording;
    let what = format!("{}: its analysis", path.display());
    fits(&what, recording.len(), study::MEMORY_BYTES_A_SAMPLE)?;
    named(path, args, recording)
}

/// `recording` with its name's condition and a person's cuts.
fn named(path: &Path, args: &Takes, mut recording: Recording) -> Outcome<Recorded> {
    let naming = match &args.meta {
        Some(pattern) => pattern.read(path).map_err(usage)?,
        None => known_naming(path),
    };
    // A pattern that a person gives counts more than the sample that was noted while recording; what a texture was made of is known.
    let is_noted = recording.about.provenance.lineage.is_none();
    let condition = &mut recording.about.condition;
    if let (Some(_), Some(named), true) = (&args.meta, &naming.condition.sample, is_noted)
        && let Some(noted) = condition.sample.replace(named.clone())
        && noted != *named
    {
        let what =
            format!("the sample is {named} by --meta, and not {noted} as the recording states");
        let guessed = RecordingWarning::Guessed { what };
        recording.about.warnings.push(guessed.into());
    }
    let beside = cuts_path(path);
    let cuts = match &args.cuts {
        Some(file) => Some(read_cuts_of(file, path)?),
        None if is_there(&beside) => Some(read_cuts_of(&beside, path)?),
        None => None,
    };
    let cuts = cuts.map(|(cuts, warning)| {
        recording.about.warnings.extend(warning);
        cuts
    });
    // Files of one name in two folders are two recordings.
    let mut alike = args.recordings.iter().filter(|p| name(p) == name(path));
    let file = path.display().to_string();
    Ok(Recorded {
        name: match alike.nth(1) {
            Some(_) => file.clone(),
            None => name(path),
        },
        file,
        recording,
        naming,
        cuts,
        cuts_are_looked_for_in: beside.display().to_string(),
    })
}

/// What the options state of all recordings.
fn stated(args: &Takes) -> Outcome<Stated> {
    let touch = args.touch.map(|touch| match touch {
        TouchName::Active => Touch::Active,
        TouchName::Passive => Touch::Passive,
    });
    let stated = Stated {
        condition: Condition {
            load_n: args.load.map(Newtons),
            speed_m_s: args.speed,
            touch,
            direction: args.direction.map(Into::into),
            ..Condition::default()
        },
        vibration: args.vibration.clone(),
        normal_force: args.normal_force.clone(),
        tangential_force: args.tangential_force.clone(),
        motion: args.motion.clone(),
        judging: if args.every_contact {
            Judging::ContactOnly
        } else {
            Judging::Sliding
        },
    };
    stated.check().map_err(failed)?;
    Ok(stated)
}

/// How a study is analysed: as the options say, with all that a report shows where one is asked for.
fn settings(computing: &Computing, question: Question) -> Outcome<StudySettings> {
    Ok(StudySettings {
        gesture: match computing.high_pass {
            Some(stated) => Gesture::Stated(stated.0),
            None => Gesture::Usual,
        },
        segment: computing.segment,
        sets: (computing.set.iter())
            .map(|set| read_sample_set(set))
            .collect::<Result<_, _>>()?,
        twin_sets: known_sample_sets()?,
        ridge_m: ridge_m(computing.ridge.as_ref())?,
        question,
        breadth: match computing.outputs.report {
            Some(_) => Breadth::Report,
            None => Breadth::Question,
        },
    })
}

/// Analyses the recordings that could be cut, and says which failed.
fn analysed(
    mut takes: Vec<AnalysedRecording>,
    by: Option<&By>,
    failures: &Failures,
    settings: &StudySettings,
) -> Outcome<StudyAnalysis> {
    if let Some(By::Label(name)) = by {
        study::label_by(&mut takes, name).map_err(failed)?;
    }
    let sizes = takes.iter().map(|take| take.recording.len() as f64);
    let analysing = Work::of_sizes(ANALYSING, sizes.collect());
    let study = study::analyse_watched(takes, settings, &mut || analysing.one_more());
    let study = study.map_err(failed);
    drop(analysing);
    let mut study = study.inspect_err(|_also_failed| failures.say())?;
    study.failed = failures.files().to_vec();
    Ok(study)
}

/// An error of a study as one of usage or of data, with the options that help.
fn failed(error: StudyError) -> Failure {
    let sentence = error.to_string();
    match error {
        StudyError::TangentialForces { .. } => usage(anyhow!("{sentence} (--tangential-force)")),
        StudyError::Load { .. } => usage(anyhow!("{sentence} (--load)")),
        StudyError::Speed { .. } => usage(anyhow!("{sentence} (--speed)")),
        StudyError::OneRecording { .. } => usage(anyhow!(sentence)),
        StudyError::Coarse { .. } => usage(anyhow!("{sentence} (--segment)")),
        StudyError::NothingToCompare { .. } => usage(anyhow!("{sentence} with --meta")),
        StudyError::Unknown { by, ref recording } => {
            let field = match by {
                Factor::Sample | Factor::File => "{sample}",
                Factor::Speed => "{speed:mm/s}",
                Factor::Participant => "{participant}",
                Factor::Touch => "{touch}",
                Factor::Load => "{load:N}",
                Factor::Direction => "{direction}",
                Factor::Label => "{label}",
            };
            // Only these formats have a file beside them that states conditions.
            let ending = Path::new(recording).extension().unwrap_or_default();
            let beside = match ["wav", "npy", "npz"]
                .iter()
                .any(|takes_one| ending.eq_ignore_ascii_case(takes_one))
            {
                true => format!(", or in {recording}.json"),
                false => String::new(),
            };
            usage(anyhow!(
                "{sentence}: say it in the file names with --meta and {field}{beside}"
            ))
        }
        StudyError::Label { ref known, .. } => {
            let conditions = CONDITIONS.map(Factor::word).join(", ");
            let labels = match known.is_empty() {
                true => "they have none".to_owned(),
                false => format!("theirs are {}", known.join(", ")),
            };
            usage(anyhow!(
                "{sentence}: name one of {conditions}, or a label of all recordings, such as a field of --meta ({labels})"
            ))
        }
        StudyError::NoStrokes { found } => {
            // The reason of the only recording stands in the sentence.
            let said = found.because.as_ref();
            let said = said.filter(|_| found.recordings.len() == 1);
            for warning in found.warnings.iter().filter(|w| Some(&w.warning) != said) {
                say(&format!("warning: {}", merged_text(warning)));
            }
            Failure::Data(anyhow!(found.sentence_with(&text)))
        }
        other => other.into(),
    }
}

/// The wavelength of the finger's ridges, m.
fn ridge_m(ridge: Option<&Measure>) -> Outcome<Option<f64>> {
    match ridge {
        Some(ridge) if ridge.unit != Unit::Metre || !(1e-5..1e-2).contains(&ridge.value) => {
            Err(usage(anyhow!(
                "expected a length such as 0.5mm for --ridge, found {ridge}; give it in mm or um"
            )))
        }
        ridge => Ok(ridge.map(|ridge| ridge.value)),
    }
}
