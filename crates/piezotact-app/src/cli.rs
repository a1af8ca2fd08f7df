//! The command line.

pub(crate) mod device;
pub(crate) mod export;
pub(crate) mod help;
pub(crate) mod manipulate;
pub(crate) mod panel;
pub(crate) mod score;
pub(crate) mod twin;

use std::path::PathBuf;

use clap::{Args, Parser};
use piezotact::filter::HighPass;
use piezotact::quantity::{Band, Hertz, Measure};
use piezotact::spectrum::Window;
use piezotact::study::Factor;
use piezotact_dataset::{NamePattern, recording_formats, transfer_formats};

pub(crate) use device::{
    Characterise, EstimatorName, ExcitationName, Finger, ForceWindowName, Gate, InverseName, Level,
    ModeName, OnOff, PhaseName, Play, Render, Transfer, Verify,
};
pub(crate) use export::Export;
pub(crate) use score::{Feeling, Score};
pub(crate) use twin::DirectionName;

use crate::deliver::Outputs;
use crate::reading::Scale;

/// The open instrument for the sense of touch: measures the vibrations of a sliding finger, renders them on a
/// vibrotactile device, and verifies how close the rendered vibrations are to the measured ones.
#[derive(Debug, Parser)]
#[command(
    name = "piezotact",
    version,
    after_help = "Start here:\n  piezotact demo\n\nExit codes: 0 done (a verification: passed); 1 error in the data or the device; 2 invalid command;\nverification: 3 not passed, 4 passed in part, 5 not decided."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: crate::commands::Command,
    /// The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    #[arg(long, global = true, display_order = 900, value_name = "DATE", value_parser = crate::invocation::date)]
    pub(crate) date: Option<String>,
    /// Replaces existing files that this command did not write before (a report or document says so itself, a table or figure
    /// cannot); recordings and transfer functions that are measured again are kept as NAME.before-N in any case.
    #[arg(long, global = true, display_order = 901)]
    pub(crate) force: bool,
}

/// The recordings, and what a person adds to what they say of themselves.
#[derive(Debug, Args)]
pub(crate) struct Takes {
    #[arg(required = true, help = format!("Recordings ({})", recording_formats()))]
    pub(crate) recordings: Vec<PathBuf>,
    /// Pattern that reads the conditions from the file names, such as '{sample}_F{load:N}_V{speed:mm/s}_{repeat}'.
    /// Fields: sample, participant, load, speed, angle, touch (active or passive), direction (proximal, distal, transversal or circular); other fields are kept as labels.
    #[arg(long, value_name = "PATTERN")]
    pub(crate) meta: Option<NamePattern>,
    /// Active or passive touch; overrides what the recordings state.
    #[arg(long, value_enum)]
    pub(crate) touch: Option<TouchName>,
    /// The direction of sliding relative to the finger; overrides what the recordings state.
    #[arg(long, value_enum)]
    pub(crate) direction: Option<DirectionName>,
    /// The nominal normal force, in N; overrides what the recordings state. If it is stated nowhere, the thresholds
    /// are those for 0.2 N.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The sliding speed, such as "30 mm/s"; overrides what the recordings state.
    #[arg(long, value_name = "VALUE UNIT", value_parser = twin::speed)]
    pub(crate) speed: Option<f64>,
    /// The vibration channels, separated by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) vibration: Vec<String>,
    /// The channel of the normal force.
    #[arg(long, value_name = "NAME")]
    pub(crate) normal_force: Option<String>,
    /// The channels of the tangential forces, separated by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) tangential_force: Vec<String>,
    /// The channel of the speed or position of the surface.
    #[arg(long, value_name = "NAME")]
    pub(crate) motion: Option<String>,
    /// Also accepts contacts without sliding, or with stick-slip, as strokes (if strokes are cut by force).
    #[arg(long)]
    pub(crate) every_contact: bool,
    /// A file of cuts for one recording; by default, RECORDING.cuts beside each recording is applied.
    #[arg(long, value_name = "FILE")]
    pub(crate) cuts: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum TouchName {
    /// The finger moves.
    Active,
    /// The surface moves.
    Passive,
}

/// What recordings are grouped by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum By {
    /// A condition.
    Condition(Factor),
    /// A label of the recordings.
    Label(String),
}

impl By {
    pub(crate) fn factor(&self) -> Factor {
        match self {
            Self::Condition(factor) => *factor,
            Self::Label(_) => Factor::Label,
        }
    }
}

/// The conditions that recordings are grouped by.
pub(crate) const CONDITIONS: [Factor; 7] = [
    Factor::Sample,
    Factor::Speed,
    Factor::Participant,
    Factor::Touch,
    Factor::Load,
    Factor::Direction,
    Factor::File,
];

fn by(text: &str) -> Result<By, String> {
    let known = CONDITIONS.into_iter().find(|factor| factor.word() == text);
    match known {
        Some(factor) => Ok(By::Condition(factor)),
        None if text.trim().is_empty() => Err("expected a condition or the name of a label".into()),
        None => Ok(By::Label(text.into())),
    }
}

/// How features are computed.
#[derive(Debug, Args)]
pub(crate) struct Computing {
    /// Cut-off, in Hz, of the high-pass filter that removes the movement of the hand (the gesture), or none. Default: 5 Hz
    /// for accelerations, none for signals of another or an unknown quantity.
    #[arg(long, value_name = "HZ|none", value_parser = gesture_filter)]
    pub(crate) high_pass: Option<GestureFilter>,
    /// Samples in a segment of the PSDs; by default, the frequency resolution is about 5 Hz.
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) segment: Option<usize>,
    /// The spatial period of the fingerprint ridges, such as 0.545mm.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) ridge: Option<Measure>,
    /// The sample set that the recordings name their samples by: `isotropic` (S1–S13), `periodic` (M1–M12), or your own (TOML). Roughness and
    /// periods are not known without it, except for recordings of the digital twin.
    #[arg(long, value_name = "NAME|SET.toml")]
    pub(crate) set: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

/// A high-pass, or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GestureFilter(pub(crate) Option<HighPass>);

fn gesture_filter(text: &str) -> Result<GestureFilter, String> {
    if text == "none" {
        return Ok(GestureFilter(None));
    }
    match text.trim_end_matches("Hz").trim().parse::<f64>() {
        Ok(hz) if hz > 0.0 && hz.is_finite() => Ok(GestureFilter(Some(HighPass {
            cutoff_hz: Hertz(hz),
            ..HighPass::gesture()
        }))),
        _ => Err("expected a frequency in Hz above zero, or none".into()),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Strokes {
    #[command(flatten)]
    pub(crate) takes: Takes,
    /// The grouping for the averages: sample, speed, participant, touch, load, direction, file, or a label of the recordings, such as a field of
    /// --meta. Default: by sample if all recordings name one, otherwise by file.
    #[arg(long, value_name = "FACTOR|LABEL", value_parser = by)]
    pub(crate) by: Option<By>,
    /// Cuts and lists the strokes and the rejected parts, with the reasons, and computes no features.
    #[arg(long, conflicts_with_all = ["by", "high_pass", "segment", "ridge", "set"])]
    pub(crate) cuts_only: bool,
    /// Writes the strokes and the rejected parts of one recording as a file of cuts that can be edited.
    #[arg(long, value_name = "FILE")]
    pub(crate) write_cuts: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) computing: Computing,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) takes: Takes,
    /// What is compared: sample, speed, participant, touch, load, direction, file, or a label of the recordings, such as a field of --meta.
    #[arg(long, value_name = "FACTOR|LABEL", value_parser = by)]
    pub(crate) by: By,
    #[command(flatten)]
    pub(crate) feeling: Feeling,
    #[command(flatten)]
    pub(crate) computing: Computing,
}

#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// The folder for everything the demo writes.
    #[arg(long, default_value = "piezotact-demo")]
    pub(crate) out: PathBuf,
    /// Seed of the random participant, finger placements and noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a person adds to what a recording says of itself.
#[derive(Debug, Args)]
pub(crate) struct Reading {
    /// What the number 1 in the file means, such as "200 m/s2": for a WAV file (1 = full scale) without a sidecar
    /// FILE.json, or for table columns without units that can be in it; "fz=N" or "fz=2 N" of one channel, as often as needed.
    #[arg(long, value_name = "[CHANNEL=]VALUE UNIT")]
    pub(crate) scale: Vec<Scale>,
    /// The sampling rate, in Hz, of a table without a time column, or the rate at which a haptic file is played (default: the
    /// rate of the HJIF curves, otherwise 8000).
    #[arg(long, value_name = "HZ")]
    pub(crate) rate: Option<f64>,
    /// The part of a recording with gaps (EEG formats, XDF) that is read, from 1 on; default: the first, with a warning.
    #[arg(long, value_name = "N")]
    pub(crate) part: Option<usize>,
}

/// A whole sidecar, and the kinds of file that `info` explains.
const SIDECAR: &str = r#"A sidecar such as NAME.wav.json, NAME.csv.json or NAME.npz.json states what the file beside it cannot.
Every entry is optional:
  {
    "full_scale": {"value": 200, "unit": "m/s2"},
    "channels": ["acc", "fz"],
    "units": {"fz": "2 N"},
    "condition": {"sample": "S4", "participant": "P01", "load_n": 0.4, "angle_deg": 20, "speed_m_s": 0.03, "touch": "active", "direction": "proximal"},
    "started_at": "2024-03-01T10:22:33+01:00",
    "labels": {"session": "2"},
    "events": [{"onset_s": 1.2, "duration_s": 0, "kind": "answer", "value": "rough"}]
  }"#;

#[derive(Debug, Args)]
#[command(after_help = SIDECAR)]
pub(crate) struct Info {
    #[arg(help = format!("A recording ({}) or a transfer function ({})", recording_formats(), transfer_formats()))]
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Spectrum {
    /// A recording.
    pub(crate) file: PathBuf,
    /// The channel; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// Measures the noise of a sensor at rest: noise floor, mains hum, drift. The recording lasts 4 s or longer; 10 s or longer
    /// for the drift.
    #[arg(
        long,
        conflicts_with_all = ["segment", "overlap", "window", "median", "over_time"]
    )]
    pub(crate) rest: bool,
    /// The band of the rms of --rest, in Hz; default: 10..1000, as far as the rate allows.
    #[arg(long, value_name = "LOW..HIGH", requires = "rest")]
    pub(crate) band: Option<Band>,
    /// Samples in a segment; default 1024, and about 0.1 s for --over-time.
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) segment: Option<usize>,
    /// Overlap of consecutive segments, as a fraction of a segment; default 0.5, and 0.875 for --over-time.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) overlap: Option<f64>,
    /// hann, hamming, blackman, blackman-harris, flat-top or rectangular.
    #[arg(long, default_value = "hann")]
    pub(crate) window: Window,
    /// Averages the segments by their median instead of their mean: robust against isolated disturbances.
    #[arg(long)]
    pub(crate) median: bool,
    /// Adds the PSD over time (spectrogram): a figure to the report, and at most 600 times × 300 frequencies to the JSON.
    #[arg(long)]
    pub(crate) over_time: bool,
    /// The highest frequency of --over-time, in Hz; default: half the sampling rate, but at most 1000.
    #[arg(
        long,
        value_name = "HZ",
        requires = "over_time",
        allow_negative_numbers = true
    )]
    pub(crate) max_frequency: Option<f64>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}
