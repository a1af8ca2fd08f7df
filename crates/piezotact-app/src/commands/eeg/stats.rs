//! `piezotact eeg stats`: tasks compared over participants.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::{Args, ValueEnum};
use piezotact::document;
use piezotact::invocation::Found;
use piezotact_dataset::read_input_text;
use piezotact_people::eeg::erd::Mode;
use piezotact_people::eeg::group::{GroupConfig, GroupError, compare};
use piezotact_people::eeg::person::EegErd;

use super::of_file;
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, usage};
use crate::made::Made;
use crate::memory::reading_fits;
use crate::places::outputs;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Documents of `piezotact eeg erd`, one for each participant and task.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The unit of changes: percent of the baseline, or dB. Clusters are always of dB.
    #[arg(long, value_enum, default_value = "percent")]
    unit: UnitOption,
    /// The tasks from the most to the least desynchronised one, as it is claimed, separated by commas: whether this order holds.
    #[arg(long, value_name = "TASKS", value_delimiter = ',')]
    gradient: Vec<String>,
    /// A difference of no interest, in the unit, stated before the data are seen: tasks whose 95 % interval lies within it are alike.
    #[arg(long, value_name = "DIFFERENCE")]
    margin: Option<f64>,
    /// Only these bands of the documents, separated by commas: contrasts that were planned are adjusted among themselves. Default: all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    band: Vec<String>,
    /// Only these regions of the documents, separated by commas. Default: all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    region: Vec<String>,
    /// Electrodes up to this angle apart, seen from the centre of the head, are neighbours in clusters, degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 35.0)]
    neighbours: f64,
    /// Sign flips of the cluster test; all are tried where there are no more.
    #[arg(long, value_name = "COUNT", default_value_t = 10_000)]
    flips: usize,
    /// The seed of sign flips that are drawn.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    outputs: Outputs,
}

/// The unit of changes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum UnitOption {
    /// Percent of the baseline.
    Percent,
    /// dB.
    Db,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let read: Vec<&Path> = args.files.iter().map(PathBuf::as_path).collect();
    outputs(&read, &args.outputs.files())?;
    let documents = read.iter().map(|path| document(path));
    let documents = documents.collect::<Outcome<Vec<(EegErd, Vec<Sampled>)>>>()?;
    different_samples(&documents)?;
    let documents = documents.into_iter().map(|(document, _)| Ok(document));
    let only = |document: Outcome<EegErd>| document?.only(&args.band, &args.region).map_err(usage);
    let documents = documents.map(only).collect::<Outcome<Vec<EegErd>>>()?;
    let found = compare(&documents, &config(args)).map_err(|error| match error {
        GroupError::NoTask { .. } | GroupError::OneStep | GroupError::Margin => usage(error),
        error => Failure::Data(anyhow!(error)),
    })?;
    deliver(&args.outputs, &found)
}

/// A file of samples that a document was computed from, and its checksum.
type Sampled = (String, Found);

/// Refuses documents of two people that were computed from one file of samples, whatever its markers and channels.
fn different_samples(documents: &[(EegErd, Vec<Sampled>)]) -> Outcome {
    let mut known: Vec<(&str, &Sampled)> = Vec::new();
    for (document, files) in documents {
        let participant = document.subject.participant.as_str();
        for file in files {
            let other = known
                .iter()
                .find(|(of, (_, sum))| *of != participant && *sum == file.1);
            if let Some((of, (path, _))) = other {
                return Err(Failure::Data(anyhow!(
                    "expected a recording of each participant, found the same samples for {of} ({path}) and {participant} ({}); give each \
                     recording once",
                    file.0
                )));
            }
            known.push((participant, file));
        }
    }
    Ok(())
}

/// The document at `path`, with the files of samples that it states.
fn document(path: &Path) -> Outcome<(EegErd, Vec<Sampled>)> {
    reading_fits(path)?;
    let text = read_input_text(path)?;
    let made = Made::of(&text);
    if made.as_ref().is_some_and(|made| !made.untouched) {
        return Err(of_file(path)(anyhow!(
            "expected the results as `eeg erd` wrote them, found others under its checksum: the file was changed by hand or damaged; compute it again"
        )));
    }
    let inputs = made.into_iter().flat_map(|made| made.invocation.inputs);
    let samples = inputs.filter(|input| {
        let ending = Path::new(&input.path).extension().unwrap_or_default();
        let of_samples = ["eeg", "edf", "bdf", "set", "fdt", "xdf"];
        let is_known = of_samples
            .iter()
            .any(|one| ending.eq_ignore_ascii_case(one));
        is_known && !matches!(input.found, Found::Nothing | Found::Changed)
    });
    let samples = samples.map(|input| (input.path, input.found)).collect();
    Ok((document::read(&text).map_err(of_file(path))?, samples))
}

fn config(args: &Arguments) -> GroupConfig {
    GroupConfig {
        unit: match args.unit {
            UnitOption::Percent => Mode::Percent,
            UnitOption::Db => Mode::Decibels,
        },
        gradient: args.gradient.clone(),
        margin: args.margin,
        neighbours_deg: args.neighbours,
        flips: args.flips,
        seed: args.seed,
    }
}
