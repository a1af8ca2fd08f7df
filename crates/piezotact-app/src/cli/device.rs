//! The options of what characterises a device and renders on it.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use piezotact::device::GainName;
use piezotact::quantity::{Band, Measure};
use piezotact::transfer::ExponentialWindow;
use piezotact_bench::Excitation;

use crate::benches::{self, BenchSpec};
use crate::deliver::Outputs;
use crate::live::Live;

use super::Reading;

/// The name of a gain; whether a device has it is asked of its description.
fn gain_name(text: &str) -> Result<GainName, String> {
    match text.trim() {
        "" => {
            Err("expected the name of a gain, found none; give the one set on the amplifier".into())
        }
        name => Ok(GainName::new(name)),
    }
}

/// How long a fade lasts, s.
fn fade(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok();
    let possible = seconds.filter(|seconds| (0.0..=10.0).contains(seconds));
    possible.ok_or_else(|| "expected a fade of 0 to 10 s; write for example 0.02".into())
}

/// How the finger is asked to lie.
#[derive(Debug, Args)]
pub(crate) struct Finger {
    /// The normal force that the participant holds, in N; default: that of the measured bench, otherwise 0.2.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle between finger and surface, in degrees; default: that of the measured bench, otherwise 20.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
}

#[derive(Debug, Args)]
pub(crate) struct Characterise {
    /// The bench.
    #[arg(long, help = benches::help("The bench"))]
    pub(crate) bench: BenchSpec,
    /// random (band-limited noise, as in the thesis), sweep (three exponential sine sweeps) or multisine, which
    /// separates noise from distortion.
    #[arg(long, default_value = "random")]
    pub(crate) excitation: Excitation,
    /// Maximum duration of the drive, in s.
    #[arg(long, default_value_t = 60.0)]
    pub(crate) seconds: f64,
    /// Number of measurements without repositioning the finger; the estimate uses all of them.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub(crate) repeats: u16,
    #[command(flatten)]
    pub(crate) gate: Gate,
    #[command(flatten)]
    pub(crate) finger: Finger,
    /// The band that is excited, in Hz.
    #[arg(long, default_value = "2..1200")]
    pub(crate) band: Band,
    /// The peak of the drive, as a fraction of the largest drive that the device can play.
    #[arg(long, default_value_t = 0.8)]
    pub(crate) peak: f64,
    /// Samples in a segment; default: 0.41 s, 2048 at 5 kHz.
    #[arg(long)]
    pub(crate) segment: Option<usize>,
    /// Seed of the random drive.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Also stores the recording; several recordings are numbered.
    #[arg(long, value_name = "RAW.parquet")]
    pub(crate) record: Option<PathBuf>,
    /// The transfer function to write: JSON (.json), a universal file (.uff, .unv) or MATLAB (.mat).
    #[arg(long)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) live: Live,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

/// What every measurement must keep to while it runs.
#[derive(Debug, Args)]
pub(crate) struct Gate {
    /// Whether a measurement is stopped and repeated when the force or the coherence is outside its limits.
    #[arg(long = "gate", value_enum, default_value = "on")]
    pub(crate) gating: OnOff,
    /// Largest relative deviation from the load of the mean force in every ten seconds; default 0.1.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) force_tolerance: Option<f64>,
    /// Smallest median coherence over the excited frequency lines in every ten seconds; default 0.9.
    #[arg(long, value_name = "COHERENCE", allow_negative_numbers = true)]
    pub(crate) least_coherence: Option<f64>,
    /// Largest number of attempts at one measurement.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub(crate) attempts: u16,
}

/// Whether measurements are checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum OnOff {
    /// Every measurement is checked.
    On,
    /// No measurement is checked.
    Off,
}

/// Whether the force of a hit is windowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ForceWindowName {
    /// The force after the pulse is set to zero.
    On,
    /// The force of the whole segment is used.
    Off,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum EstimatorName {
    /// Sxy/Sxx, unbiased by noise on the response.
    H1,
    /// Syy/Syx, unbiased by noise on the drive.
    H2,
    /// For noise on both: their geometric mean, or the total least squares for --noise-ratio.
    Hv,
}

/// What the drive of a recording is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ExcitationName {
    /// An impact test if the drive consists of short pulses, otherwise a random drive.
    Auto,
    /// A drive that lasts over the whole recording (noise, sweep, multisine): averages over segments.
    Random,
    /// Hits of a hammer: one segment for each hit, without overlap.
    Impact,
}

/// The exponential window of an impact test, as it is written on the command line.
fn exponential(text: &str) -> Result<ExponentialWindow, String> {
    match text.trim() {
        "auto" => Ok(ExponentialWindow::WhereNeeded),
        "off" => Ok(ExponentialWindow::None),
        stated => match stated.parse::<f64>() {
            Ok(damping_per_s) if damping_per_s.is_finite() && damping_per_s > 0.0 => {
                Ok(ExponentialWindow::Damping(damping_per_s))
            }
            _ => Err(
                "expected auto, off, or the added damping in 1/s, such as 20; 20 leaves 2 % after 0.2 s".into(),
            ),
        },
    }
}

#[derive(Debug, Args)]
pub(crate) struct Transfer {
    /// A recording that holds both channels.
    pub(crate) recording: PathBuf,
    /// The channel of the drive.
    #[arg(long)]
    pub(crate) drive: String,
    /// The channel of the response.
    #[arg(long)]
    pub(crate) response: String,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// What the drive is taken for; a random estimate refuses a drive of short pulses.
    #[arg(long, value_enum, default_value = "auto")]
    #[cfg_attr(
        not(feature = "modal"),
        arg(
            help = "What the drive is taken for. Impact tests are not in this build: ./x build has them"
        )
    )]
    pub(crate) excitation: ExcitationName,
    /// Samples in a segment. Default: 0.41 s, 2048 at 5 kHz; for impacts, twice as long as the response takes to decay.
    #[arg(long)]
    pub(crate) segment: Option<usize>,
    /// Impacts: whether the force is set to zero after its pulse, which leaves out its noise. Default: on.
    #[arg(long, value_enum)]
    pub(crate) force_window: Option<ForceWindowName>,
    /// Impacts: an exponential window for force and response, with its added damping in 1/s; auto takes as much as
    /// leaves 1 % of the response at the end of the segment, if more is left there. Default: off.
    #[arg(long, value_name = "auto|off|1/s", value_parser = exponential)]
    pub(crate) exponential: Option<ExponentialWindow>,
    /// The estimator of the transfer function.
    #[arg(long, value_enum, default_value = "h1")]
    pub(crate) estimator: EstimatorName,
    /// For --estimator hv: the power of the noise on the response over that on the drive, in (units of the response per
    /// unit of the drive)². Without it Hv is the geometric mean of H1 and H2.
    #[arg(long, value_name = "RATIO")]
    pub(crate) noise_ratio: Option<f64>,
    /// The drive is random and its channel holds the signal that was sent, not a measurement of it. Only then are the limits
    /// of H1 95 % confidence limits of the best linear approximation. A drive that repeats itself has none.
    #[arg(long)]
    pub(crate) known_input: bool,
    /// The amplifier and the actuator: drv2667 (that of the thesis, the default), fixed, or a TOML file that
    /// describes them.
    #[arg(long, value_name = "NAME|FILE.toml", requires = "volts_per_full_scale")]
    pub(crate) device: Option<String>,
    /// The gain set on the amplifier, by its name on the device, such as B3; together with --volts-per-full-scale it
    /// describes the device. Optional if the device has only one gain.
    #[arg(long, value_parser = gain_name, requires = "volts_per_full_scale")]
    pub(crate) gain: Option<GainName>,
    /// The peak voltage at the PC's output for a drive at full scale, in V. A drive channel in V is then
    /// converted to full scale = 1.
    #[arg(long, value_name = "V")]
    pub(crate) volts_per_full_scale: Option<f64>,
    /// The capacitance of the actuator, in nF, if it differs from the description of the device.
    #[arg(long, value_name = "NF", requires = "volts_per_full_scale")]
    pub(crate) load_nf: Option<f64>,
    /// The transfer function to write: JSON (.json), a universal file (.uff, .unv) or MATLAB (.mat).
    #[arg(long)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

/// How a transfer function is inverted.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum InverseName {
    /// Division by the transfer function.
    Plain,
    /// Division with a constant regularisation.
    Constant,
    /// The regularised inverse, multiplied by the coherence.
    Coherence,
    /// The regularised inverse, reduced where the target needs the largest drive, until the drive fits the device.
    DriveLimited,
}

/// Which phase an inverse has.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum PhaseName {
    /// The phase of the device is compensated; waveforms are reproduced, with a delay.
    Linear,
    /// Minimum phase: only spectra are reproduced; the edges of the band ring before the beginning as with linear phase.
    Minimum,
}

/// What a closed loop is to meet.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum ModeName {
    /// The waveform.
    Replicate,
    /// The power spectrum.
    Texture,
}

/// How loud a texture is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// Re the texture, dB.
    Stated(f64),
    /// At its own, or as much softer as it takes to fit, in level and in slope.
    Fit,
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "fit" {
            return Ok(Self::Fit);
        }
        let level = text.parse().ok().filter(|db| (-120.0..=120.0).contains(db));
        level.map(Self::Stated).ok_or_else(|| {
            format!(
                "expected a level from -120 to 120 dB, or fit, found `{text}`; 0 is the level of the texture"
            )
        })
    }
}

#[derive(Debug, Args)]
pub(crate) struct Render {
    /// The textures: recordings in m/s².
    #[arg(required = true)]
    pub(crate) targets: Vec<PathBuf>,
    /// The transfer function of the device with the finger on it; may be repeated, for several participants.
    #[arg(long, required = true)]
    pub(crate) transfer: Vec<PathBuf>,
    /// The drive to write (WAV, 32-bit float), with its sidecar beside it; a folder for several textures or participants.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// The band that is rendered, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// The channel of the texture; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// The gain set on the amplifier; must be the one the transfer function was measured with.
    #[arg(long, value_parser = gain_name)]
    pub(crate) gain: Option<GainName>,
    /// The amplifier and the actuator, drv2667, fixed or a TOML file that describes them; must be those the transfer
    /// function was measured with.
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) device: Option<String>,
    /// Raises or lowers the level of the texture by this many dB; `fit`: its own level, lowered only as much as the device
    /// requires, with --mode texture after its peaks were limited.
    #[arg(
        long,
        default_value = "0",
        value_name = "DB|fit",
        allow_negative_numbers = true
    )]
    pub(crate) level: Level,
    /// The rate of the drive, in Hz.
    #[arg(long, default_value_t = 48_000, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1_000..=768_000))]
    pub(crate) drive_rate: u32,
    /// How the transfer function is inverted: plain (division, as in the thesis), constant (regularised), coherence
    /// (regularised and reduced where the coherence is low), or drive-limited (reduced where the target needs the largest
    /// drive, until the drive fits the device).
    #[arg(long, value_enum, default_value = "constant")]
    pub(crate) inverse: InverseName,
    /// Fades the texture in and out over this time, in s. What a fade takes is missing when the rendering is verified.
    #[arg(long, default_value_t = 0.0, value_name = "S", value_parser = fade, hide_short_help = true)]
    pub(crate) fade: f64,
    /// The phase of the inverse: linear (reproduces waveforms, with a delay) or minimum (spectra only; it rings before the
    /// beginning about as linear phase does, as the edges of the band do).
    #[arg(long, value_enum, default_value = "linear")]
    pub(crate) phase: PhaseName,
    /// Corrects the drive in a closed loop on --bench: `replicate` corrects the waveform, `texture` the spectrum.
    #[arg(long, value_enum, requires = "bench")]
    pub(crate) mode: Option<ModeName>,
    /// The bench of the closed loop.
    /// May be repeated: one for each --transfer; a single bench is used for all of them.
    #[arg(long, requires = "mode", help = format!("{}. May be repeated: one for each --transfer; a single bench is used for all of them", benches::help("The bench of the closed loop")))]
    pub(crate) bench: Vec<BenchSpec>,
    /// Largest number of corrections, default 6; every drive is played twice, and the best drive once more.
    #[arg(long, requires = "mode", value_parser = clap::value_parser!(u16).range(1..=50))]
    pub(crate) iterations: Option<u16>,
    #[command(flatten)]
    pub(crate) finger: Finger,
    /// Stores the recording of the best drive (Parquet); a folder for several textures or participants.
    #[arg(long, requires = "mode", value_name = "MEASURED.parquet")]
    pub(crate) record: Option<PathBuf>,
    /// Discards the measurements of the closed loop at the end; by default they are kept in the folder OUT.runs.
    #[arg(long, requires = "mode")]
    pub(crate) discard_raw: bool,
    /// Accepts a drive beyond the limits of the device, instead of refusing it: it is clipped, and its slope stays as it is. Not
    /// available in a closed loop, which never plays such a drive.
    #[arg(long, conflicts_with = "mode")]
    pub(crate) allow_clipping: bool,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

#[derive(Debug, Args)]
pub(crate) struct Play {
    /// The drive (WAV) that `render` wrote.
    pub(crate) drive: PathBuf,
    /// The bench.
    #[arg(long, help = benches::help("The bench"))]
    pub(crate) bench: BenchSpec,
    /// The recording to write (Parquet).
    #[arg(long)]
    pub(crate) record: PathBuf,
    #[command(flatten)]
    pub(crate) live: Live,
    /// The gain for which a drive without a sidecar was made.
    #[arg(long, value_parser = gain_name)]
    pub(crate) gain: Option<GainName>,
    #[command(flatten)]
    pub(crate) finger: Finger,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Verify {
    /// The texture that was rendered.
    #[arg(long)]
    pub(crate) target: PathBuf,
    /// The recording made while it was played.
    #[arg(long)]
    pub(crate) measured: PathBuf,
    /// The channel of the target; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// The channel of the measurement; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) measured_channel: Option<String>,
    /// What the number 1 in the measurement means, if it differs from --scale.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) measured_scale: Option<Measure>,
    /// The drive (WAV) that was played, if the measurement does not contain it: its level and its achievable band
    /// are used.
    #[arg(long)]
    pub(crate) drive: Option<PathBuf>,
    /// The band in which target and measurement are compared, in Hz; default: 20..1000, wider where the drive
    /// was rendered in a wider one.
    #[arg(long)]
    pub(crate) band: Option<Band>,
    /// The transfer function: its figures are shown in the report, and the result of playing the texture directly on the
    /// device, without rendering, is predicted with it.
    #[arg(long)]
    pub(crate) transfer: Option<PathBuf>,
    /// A further measurement of the same target, such as one rendered with an averaged transfer function; may be
    /// repeated. Each is verified in the same way, at the level stored with its rendering (--drive applies to
    /// --measured only); the verdict and the exit code are those of --measured.
    #[arg(long, value_name = "MEASURED")]
    pub(crate) also: Vec<PathBuf>,
    /// A source of a manipulated target (`manipulate`): the original texture, or a texture whose level or spectrum was used;
    /// may be repeated. Levels, waveforms and spectra before and after the manipulation are compared.
    #[arg(long, value_name = "SOURCE")]
    pub(crate) before: Vec<PathBuf>,
    /// The channel of the source textures; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) before_channel: Option<String>,
    /// Uses one stroke of the source textures, numbered from 1, as `manipulate --stroke` does.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) before_stroke: Option<u32>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}
