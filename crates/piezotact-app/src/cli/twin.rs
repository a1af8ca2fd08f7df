//! The commands that run on the digital twin alone.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use piezotact::quantity::{Measure, Unit};

use crate::live::Live;

#[derive(Debug, Args)]
pub(crate) struct Twin {
    #[command(subcommand)]
    pub(crate) command: TwinCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum TwinCommand {
    /// Simulates the recording of a finger in active touch, in passive touch, or on the shaker, or the EEG of its person.
    #[command(
        after_help = "Example:\n  piezotact twin record --bench acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 15 --out S4.parquet\n  piezotact twin record --bench triboair --sample S1 --speed 20mm/s --out S1.wav\n  piezotact twin record --bench acttouch --sample M8 --free --out M8.parquet\n  piezotact twin record --bench shaker --load 0.4 --out finger.parquet\n  piezotact twin record --bench eeg --task imagery --participant 3 --out P03_imagery.vhdr"
    )]
    Record(Record),
    /// Writes the height map of a sample, for `piezotact roughness`.
    #[command(
        after_help = "Example:\n  piezotact twin surface S4 --out map.sur\n  piezotact twin surface M8 --size 4mm --step 4um --out M8.sur"
    )]
    Surface(crate::commands::twin::surface::Arguments),
    /// Stands in for a sound device with a finger on it, as a JACK client that answers what `audio:SETUP.toml` plays.
    #[command(
        after_help = "Start a server first, such as jackd -d dummy -r 48000 -p 1024. The channels of the set-up are connected as soon as a program opens\nthem. With [force] file = \"force.txt\" in the set-up, its force cell writes there.\n\nExample:\n  piezotact twin plant setup.toml --participant 3 --load 0.2\n  piezotact characterise --bench audio:setup.toml --out tf.json"
    )]
    Plant(crate::commands::sound::plant::Arguments),
    /// Prints the parameters of the twin with their ranges and sources, as a file that a laboratory can change.
    #[command(after_help = "Example:\n  piezotact twin parameters > twin.toml")]
    Parameters(Parameters),
}

/// Who and which numbers.
#[derive(Debug, Args)]
pub(crate) struct Who {
    /// The number of the participant, from 1; 0 is the reference participant, with all parameters at their means.
    #[arg(long, default_value_t = 1)]
    pub(crate) participant: u64,
    /// Seed of the random participants, surfaces, movements and noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// A laboratory's own parameter file, with the changed parameters only (see `piezotact twin parameters`).
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) twin: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum BenchName {
    /// Active touch: a person strokes the sample.
    Acttouch,
    /// Passive touch: the sample moves under a finger at rest.
    Triboair,
    /// A shaker under the finger, to measure its transfer function.
    Shaker,
    /// 64 electrodes and two of the EOG, while three surfaces are touched (--task).
    Eeg,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum TaskName {
    /// The person strokes each surface.
    Natural,
    /// The device plays each surface under the resting finger.
    Control,
    /// The same, while the person imagines the stroke.
    Imagery,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DirectionName {
    /// Along the finger, towards the body.
    #[default]
    Proximal,
    /// Along the finger, away from the body.
    Distal,
    /// Across the finger.
    Transversal,
    /// In circles.
    Circular,
}

#[derive(Debug, Args)]
pub(crate) struct Record {
    /// The bench.
    #[arg(long, value_enum)]
    pub(crate) bench: BenchName,
    /// The sample: S1–S13, NO (without texture), M1–M12, BIO, or one of --twin FILE. Not on the shaker, and not with EEG, where
    /// M8, BIO and M3 are touched.
    #[arg(long)]
    pub(crate) sample: Option<String>,
    /// EEG: what the person does.
    #[arg(long, value_enum)]
    pub(crate) task: Option<TaskName>,
    /// EEG: how often each surface is touched, 1 to 500; default 20.
    #[arg(long, value_name = "N")]
    pub(crate) trials: Option<usize>,
    #[command(flatten)]
    pub(crate) who: Who,
    /// The nominal sliding speed; default 30 mm/s.
    #[arg(long, value_name = "SPEED", value_parser = speed, allow_hyphen_values = true)]
    pub(crate) speed: Option<f64>,
    /// The number of strokes; default 15 in active and 6 in passive touch.
    #[arg(long)]
    pub(crate) strokes: Option<usize>,
    /// The nominal duration of each active stroke, such as 1s; default: as long as the plate allows.
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true)]
    pub(crate) stroke_time: Option<f64>,
    /// The direction of active strokes.
    #[arg(long, value_enum, default_value = "proximal")]
    pub(crate) direction: DirectionName,
    /// Active touch at the participant's own speed and force.
    #[arg(long, conflicts_with_all = ["speed", "stroke_time", "load"])]
    pub(crate) free: bool,
    /// The nominal normal force, in N; default 0.2.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle between finger and surface, in degrees; default 17.5 on a sample and 20 on the shaker.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// The duration of the shaker excitation, in s; default 60.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) seconds: Option<f64>,
    /// On the shaker: the control measurement, with the accelerometer on the plate and without a finger.
    #[arg(long, conflicts_with_all = ["load", "angle"])]
    pub(crate) control: bool,
    /// A label for the recording; another label gives other random movements, placements and noise.
    #[arg(long, default_value = "record")]
    pub(crate) label: String,
    /// The recording to write: Parquet with all channels, or WAV with only the acceleration of the nail; EEG: Parquet, BrainVision (.vhdr
    /// with .eeg and .vmrk beside it) or EDF+ (.edf).
    #[arg(long)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) live: Live,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Parameters {
    /// A laboratory's own parameter file: it is checked, and its changes are printed instead.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) twin: Option<PathBuf>,
}

/// A speed with its unit, in m/s.
pub(crate) fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(Measure {
            value,
            unit: Unit::MetrePerSecond,
        }) => Ok(value),
        _ => Err(format!(
            "expected a speed with its unit (mm/s, m/s), found `{text}`; write for example 30mm/s"
        )),
    }
}

/// A time with its unit, in s.
fn time(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => match text.strip_suffix("min") {
            Some(number) => (number, 60.0),
            None => (text.strip_suffix('s').unwrap_or(""), 1.0),
        },
    };
    number
        .trim()
        .parse::<f64>()
        .map(|value| value * factor)
        .map_err(|_no_number| {
            format!(
                "expected a time with its unit (s, ms, min), found `{text}`; write for example 1.2s"
            )
        })
}
