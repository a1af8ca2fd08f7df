//! `piezotact sound`: sound devices, their calibration and latency, and recordings of other systems on the clock of a drive.

pub(super) mod align;
pub(super) mod burst;
#[cfg(feature = "audio")]
pub(super) mod calibrate;
#[cfg(feature = "audio")]
pub(super) mod devices;
#[cfg(feature = "audio")]
pub(super) mod latency;
#[cfg(feature = "audio")]
pub(crate) mod plant;

use clap::{Args, Subcommand};

use crate::failure::Outcome;

#[cfg(not(feature = "audio"))]
super::lacking::lacking! {
    calibrate(Arguments), "sound calibrate";
    devices(Arguments), "sound devices";
    latency(Arguments), "sound latency";
    plant(Arguments), "twin plant";
}

#[derive(Debug, Args)]
pub(crate) struct Sound {
    #[command(subcommand)]
    command: SoundCommand,
}

#[derive(Debug, Subcommand)]
enum SoundCommand {
    /// Lists sound systems and sound devices with their rates, channels and buffers.
    #[command(
        after_help = "Example:\n  piezotact sound devices\n  piezotact sound devices --host jack --json"
    )]
    Devices(devices::Arguments),
    /// Calibrates a sound device: volts at full scale, sensitivities of inputs, cables, the level of its loopback.
    #[command(
        after_help = "What was calibrated before is kept, where it is of the same device. A bench opens only if its loopback is within 0.1 dB of the\ncalibration. Each sensor is calibrated by --exciter, or by its stated sensitivity and --input-volts.\n\nExample:\n  piezotact sound calibrate setup.toml --tone 20\n  piezotact sound calibrate setup.toml --voltmeter 0.349 --wires\n  piezotact sound calibrate setup.toml --exciter 2"
    )]
    Calibrate(calibrate::Arguments),
    /// Measures the latency of a sound device from output to input over restarts of its streams.
    #[command(
        after_help = "Median, 95 % and 99 % are stored beside the set-up, and stand in every later recording.\n\nExample:\n  piezotact sound latency setup.toml\n  piezotact sound latency setup.toml --restarts 200 --json"
    )]
    Latency(latency::Arguments),
    /// Adds synchronisation bursts to a drive, by which what another system records is aligned whatever the drive is.
    #[command(
        after_help = "The burst before the drive sweeps the band upwards, the burst after it downwards. The sidecar states their times for\n`piezotact sound align`. Keep it beside the file.\n\nExample:\n  piezotact sound burst drive.wav --out with.wav\n  piezotact sound burst drive.wav --band 80..500 --duration 1 --peak 0.1 --out with.wav"
    )]
    Burst(burst::Arguments),
    /// Places what another system recorded on the clock of the drive that was played: offset, drift, and their uncertainty.
    #[command(
        after_help = "The two systems may have other rates and clocks, and the recording may begin and end at any time. A drive that repeats, such as\na tone, needs the bursts of `piezotact sound burst`. The delay of the device is in the offset. With --out, `piezotact transfer`\nestimates the transfer function from the file.\n\nExample:\n  piezotact sound align drive.wav dewesoft.csv --channel nail --report align.html\n  piezotact sound align drive.wav other.mat --out aligned.parquet\n  piezotact transfer aligned.parquet --drive drive --response nail --out tf.json"
    )]
    Align(align::Arguments),
}

pub(crate) fn run(args: &Sound) -> Outcome {
    match &args.command {
        SoundCommand::Devices(args) => devices::run(args),
        SoundCommand::Calibrate(args) => calibrate::run(args),
        SoundCommand::Latency(args) => latency::run(args),
        SoundCommand::Burst(args) => burst::run(args),
        SoundCommand::Align(args) => align::run(args),
    }
}

/// Writes what was measured at a place, and keeps what stood there under a free name.
#[cfg(feature = "audio")]
fn keep<T: piezotact::document::Content>(
    (out, earlier): (&std::path::Path, &'static str),
    found: &T,
) -> Outcome {
    let earlier = crate::keeping::Earlier::at(out, earlier)?;
    let text = crate::output::document_text(found, Some(out))?;
    crate::output::write_text(out, &text)?;
    earlier.settle()
}
