//! One module for each command.

mod characterise;
mod demo;
mod export;
mod info;
pub(crate) mod manipulate;
pub(crate) mod panel;
mod play;
mod render;
mod replay;
pub(crate) mod roughness;
mod score;
mod spectrum;
pub(crate) mod touch;
mod transfer;
pub(crate) mod twin;
mod verify;

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::device::DriveSetup;
use piezotact::integrity::doubts_of;
use piezotact::quantity::{Acceleration, Degrees, Newtons, QuantityError, SampleRate, Unit};
use piezotact::recording::{Recording, RecordingError};
use piezotact::series::Series;
use piezotact_bench::{Acquire, DeviceError, Placement, ProcedureError, RunPlan, Until};
use piezotact_dataset::sidecar::sidecar_path;
use piezotact_dataset::{
    Contents, ReadOptions, check_place, journal_path, read_recording, set_aside_path,
};

use crate::cli::{Cli, Command, Finger, Reading};
use crate::failure::{Failure, Outcome, usage};

pub(crate) fn run(cli: Cli) -> Outcome {
    match cli.command {
        Command::Demo(args) => demo::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Spectrum(args) => spectrum::run(&args),
        Command::Characterise(args) => characterise::run(&args),
        Command::Transfer(args) => transfer::run(&args),
        Command::Manipulate(args) => manipulate::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Play(args) => play::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Score(args) => score::run(&args),
        Command::Segment(args) => touch::segment::run(&args),
        Command::Analyse(args) => touch::analyse::run(&args),
        Command::Compare(args) => touch::compare::run(&args),
        Command::Roughness(args) => roughness::run(&args),
        Command::Panel(args) => panel::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Twin(args) => twin::run(&args),
        Command::Replay(args) => replay::run(&args),
    }
}

/// A rate given in Hz on the command line.
fn rate_option(rate_hz: Option<f64>) -> Result<Option<SampleRate>, Failure> {
    rate_hz
        .map(SampleRate::new)
        .transpose()
        .map_err(usage::<QuantityError>)
}

fn read(path: &Path, reading: &Reading) -> Outcome<Contents> {
    let options = ReadOptions {
        scale: reading.scale.clone(),
        rate: rate_option(reading.rate)?,
    };
    inspected(path, &options)
}

/// The recording in a file, with the doubts about what broke on its way to the file.
fn inspected(path: &Path, options: &ReadOptions) -> Outcome<Contents> {
    let mut contents = read_recording(path, options)?;
    let found = doubts_of(&contents.recording, drive_limit(contents.setup.as_ref()));
    contents.recording.about.doubts.extend(found);
    Ok(contents)
}

/// The largest drive that the device plays, of full scale: full scale where it is not known.
fn drive_limit(setup: Option<&DriveSetup>) -> f64 {
    setup.map_or(1.0, DriveSetup::drive_limit)
}

/// Refuses outputs that would replace an input, an input's sidecar, or each other, or that have no folder to
/// stand in: before anything is measured that could not be kept.
fn outputs(inputs: &[&Path], outputs: &[&Path]) -> Outcome {
    let read: Vec<PathBuf> = inputs
        .iter()
        .flat_map(|input| [place(input), place(&sidecar_path(input))])
        .collect();
    for (i, output) in outputs.iter().enumerate() {
        if read.contains(&place(output)) {
            return Err(usage(anyhow!(
                "{} is read and would be replaced: give the output another name",
                output.display()
            )));
        }
        if outputs[..i]
            .iter()
            .any(|other| place(other) == place(output))
        {
            return Err(usage(anyhow!(
                "{} is written twice: give each output its own name",
                output.display()
            )));
        }
        let folder = folder_of(output);
        if !folder.is_dir() {
            return Err(anyhow!(
                "{}: expected the folder {} to be there, found none; make it",
                output.display(),
                folder.display()
            )
            .into());
        }
        if std::fs::metadata(output).is_ok_and(|found| !found.is_dir() && !found.is_file()) {
            return Err(anyhow!(
                "{}: expected the name of a file, found a device; give a file's name",
                output.display()
            )
            .into());
        }
        if output.is_dir() {
            return Err(anyhow!(
                "{}: expected the name of a file, found a folder; give a file's name in it",
                output.display()
            )
            .into());
        }
        check_place(output)?;
    }
    Ok(())
}

/// The ending of an output's name, in small letters, which is one of `known`.
pub(crate) fn has_ending<'a>(path: &Path, known: &[&'a str]) -> Outcome<&'a str> {
    let found = path.extension().map(|end| end.to_ascii_lowercase());
    let ending = known
        .iter()
        .find(|known| found.as_deref() == Some((*known).as_ref()));
    ending.copied().ok_or_else(|| {
        usage(anyhow!(
            "{}: expected a name that ends in .{}, found another; say what to write by it",
            path.display(),
            known.join(" or .")
        ))
    })
}

/// The files that a recording called `record` takes up while it is made, and the longest name that one of an interrupted
/// command gets.
fn recording_files(record: &Path) -> [PathBuf; 3] {
    [
        record.to_owned(),
        journal_path(record),
        set_aside_path(record, 1),
    ]
}

fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Where a path leads to, whatever its spelling and whether the file is there yet or not.
fn place(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| {
        let folder =
            std::fs::canonicalize(folder_of(path)).unwrap_or_else(|_| folder_of(path).to_owned());
        folder.join(path.file_name().unwrap_or_default())
    })
}

/// The texture in a recording, in m/s²; when its scale is not known, what to do about it.
fn texture(
    path: &Path,
    recording: &Recording,
    channel: Option<&str>,
) -> Outcome<Series<Acceleration>> {
    recording.series::<Acceleration>(channel).map_err(|error| {
        let text = path.display();
        match &error {
            RecordingError::Unit { found: Unit::FullScale, .. } => Failure::Data(anyhow!(
                "{text}: expected a physical scale, found none (full scale = 1); give it with --scale \"200 m/s2\" or in {text}.json"
            )),
            _ => Failure::Data(anyhow::Error::new(error).context(text.to_string())),
        }
    })
}

/// What a bench refuses because of what it was asked is a matter of the command line.
pub(crate) fn bench_failure(error: impl Into<ProcedureError>) -> Failure {
    match error.into() {
        error @ (ProcedureError::Impossible { .. }
        | ProcedureError::Device(DeviceError::Impossible { .. })) => usage(error),
        other => other.into(),
    }
}

/// The load of a run that states none, N.
const USUAL_LOAD_N: f64 = 0.2;
/// The angle of a run that states none, degrees.
const USUAL_ANGLE_DEG: f64 = 20.0;

/// A run of what the options ask for; what they leave open is as the bench has it, or as is usual.
fn run_plan(label: &str, finger: &Finger, acquirer: &dyn Acquire) -> RunPlan {
    let here = acquirer.describe().condition;
    let (load, angle) = (finger.load.map(Newtons), finger.angle.map(Degrees));
    RunPlan {
        label: label.into(),
        load: Some(load.or(here.load_n).unwrap_or(Newtons(USUAL_LOAD_N))),
        angle: angle.or(here.angle_deg).unwrap_or(Degrees(USUAL_ANGLE_DEG)),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}
