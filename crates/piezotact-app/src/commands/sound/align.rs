//! `piezotact sound align`: the recording of another system on the clock of a drive.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::align::{
    AlignConfig, AlignError, AlignedRecording, Compared, Named, align_recordings,
};
use piezotact::quantity::{Band, Seconds};
use piezotact_dataset::{Contents, write_measurement};

use crate::cli::Reading;
use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Failure, Outcome, usage};
use crate::keeping::Earlier;
use crate::places::{has_ending, outputs, place};
use crate::reading::{read, read_drive};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The drive that was played: its WAV file, or a recording with a channel `drive`.
    drive: PathBuf,
    /// What another system recorded meanwhile, in any format that is read.
    recording: PathBuf,
    /// The channel in which the drive is looked for; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    channel: Option<String>,
    /// The band in which both are compared, in Hz; default: 20..1000, as far as the rates allow.
    #[arg(long, value_name = "LOW..HIGH")]
    band: Option<Band>,
    /// The length of the blocks that are looked for, in s; four or more have to be recorded.
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    block: f64,
    /// The largest drift between the two clocks, in ppm.
    #[arg(long, value_name = "PPM", default_value_t = 300.0)]
    largest_drift: f64,
    #[command(flatten)]
    reading: Reading,
    /// Writes the recording with all its channels and events on the clock of the drive, and the drive in a channel of its own.
    #[arg(long, value_name = "OUT.parquet")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    check(args)?;
    let drive = read_drive(&args.drive)?;
    let recorded = read(&args.recording, &args.reading)?;
    let [drive_file, file] = [&args.drive, &args.recording].map(|path| path.display().to_string());
    let compared = Compared::of(
        Named {
            file: &drive_file,
            recording: &drive.recording,
        },
        Named {
            file: &file,
            recording: &recorded.recording,
        },
        args.channel.as_deref(),
    );
    let compared = compared.map_err(|error| refused(args, error))?;
    let mut found = align_recordings(&compared, &config(args, &compared)?)
        .map_err(|error| refused(args, error))?;
    if let Some(out) = &args.out {
        write(args, out, &found, &compared, [&drive, &recorded])?;
        found.out = Some(out.display().to_string());
    }
    let written: Vec<&Path> = args.out.iter().map(PathBuf::as_path).collect();
    deliver_and(&args.outputs, &found, &written)
}

/// Refuses files that cannot be given together.
fn check(args: &Arguments) -> Outcome {
    let out = args.out.iter().map(PathBuf::as_path);
    let written: Vec<&Path> = out.chain(args.outputs.files()).collect();
    outputs(&[&args.drive, &args.recording], &written)?;
    if let Some(out) = &args.out {
        has_ending(out, &["parquet"])?;
    }
    if place(&args.drive) == place(&args.recording) {
        return Err(usage(anyhow!(
            "expected the drive and what another system recorded, found {} twice; give the file of each",
            args.drive.display()
        )));
    }
    Ok(())
}

fn config(args: &Arguments, compared: &Compared<'_>) -> Outcome<AlignConfig> {
    let band = match args.band {
        Some(band) => band,
        None => compared.usual().map_err(|error| refused(args, error))?.band,
    };
    Ok(AlignConfig {
        band,
        block_s: Seconds(args.block),
        most_drift_ppm: args.largest_drift,
    })
}

/// What is refused because of the options is a matter of the command line; else the file is named.
fn refused(args: &Arguments, error: AlignError) -> Failure {
    let path = match &error {
        AlignError::Settings | AlignError::Band { .. } => return usage(error),
        AlignError::NoDrive { .. } | AlignError::NotFinite { what: "drive" } => &args.drive,
        _ => &args.recording,
    };
    let file = path.display().to_string();
    Failure::Data(anyhow::Error::new(error).context(file))
}

/// Writes the recording on the clock of the drive, with the device that played it.
fn write(
    args: &Arguments,
    out: &Path,
    found: &AlignedRecording,
    compared: &Compared<'_>,
    [drive, recorded]: [&Contents; 2],
) -> Outcome {
    let placed = found.on_drive(compared);
    let placed = placed.map_err(|error| refused(args, error))?;
    let setup = recorded.setup.as_ref().or(drive.setup.as_ref());
    let rendering = recorded.rendering.as_ref().or(drive.rendering.as_ref());
    let earlier = Earlier::at(out, "the earlier recording")?;
    write_measurement(out, &placed, setup, rendering)?;
    earlier.settle()
}
