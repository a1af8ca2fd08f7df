//! The command line.

pub(crate) mod device;
pub(crate) mod export;
pub(crate) mod manipulate;
pub(crate) mod panel;
pub(crate) mod score;
pub(crate) mod twin;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use piezotact::filter::HighPass;
use piezotact::quantity::{Hertz, Measure, Unit};
use piezotact::spectrum::Window;
use piezotact::surface::{Form, ShortWaves};
use piezotact_dataset::{NamePattern, recording_formats, topography_formats, transfer_formats};

pub(crate) use device::{
    Characterise, EstimatorName, Finger, Gate, InverseName, Level, ModeName, OnOff, PhaseName,
    Play, Render, Transfer, Verify,
};
pub(crate) use export::Export;
pub(crate) use score::{Feeling, Score};
pub(crate) use twin::Replay;

/// The open instrument for the sense of touch: measures the vibrations of a sliding finger, renders them on a
/// device, and says how close it came.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Start here:\n  piezotact demo\n\nExit codes: 0 done, and a verification passed; 1 something is wrong with the data or the device; 2 the command\nis not valid; a verification was done and 3 is not passed, 4 is passed in part, 5 is not decided."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Runs the whole loop on the digital twin and writes a report.
    #[command(after_help = "Example:\n  piezotact demo --out demo --seed 7")]
    Demo(Demo),
    /// Says what is in a recording: channels, units, rate, length, doubts.
    #[command(
        after_help = "Example:\n  piezotact info measured.parquet\n  piezotact info texture.wav --scale \"200 m/s2\" --json"
    )]
    Info(Info),
    /// Estimates the power spectral density of one channel, as a whole or over time.
    #[command(
        after_help = "Example:\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --svg psd.svg\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --spectrogram time.svg --max-frequency 500\n  piezotact spectrum measured.parquet --channel acceleration --json > psd.json"
    )]
    Spectrum(Spectrum),
    /// Measures the transfer function of a device with a finger on it.
    #[command(
        after_help = "Example:\n  piezotact characterise --bench twin:participant=1,seed=7 --seconds 60 --out tf.json\n  piezotact characterise --bench twin:participant=1,seed=7 --excitation multisine --repeats 3 --out tf.json"
    )]
    Characterise(Characterise),
    /// Estimates the transfer function between two channels of a recording.
    #[command(
        after_help = "Example:\n  piezotact transfer bench.csv --drive drive --response nail --gain B3 --volts-per-full-scale 1.41 --out tf.json"
    )]
    Transfer(Transfer),
    /// Makes a texture otherwise on purpose: level, spectrum, phases, length; and keeps what was done.
    #[command(
        after_help = "Operations are done in the order in which they are given, and stand in OUT.wav.json; `piezotact info` shows them.\n\nExample:\n  piezotact manipulate S2.wav --rms-of S13.wav --out S2inv.wav --report S2inv.html\n  piezotact manipulate S8.parquet --stroke 2 --band 50..100:+6dB --tilt 3dB/oct@200Hz --loop 10s --out S8b.wav\n  piezotact manipulate S8.wav --gain -3dB --shift 20Hz --warp 1.25:keep-length --out S8c.wav\n  piezotact manipulate S8.wav --spectrum-of S1.wav --randomise-phases --seed 7 --out S8d.wav"
    )]
    Manipulate(manipulate::Manipulate),
    /// Computes the drive that makes a resting finger feel a texture.
    #[command(
        after_help = "Example:\n  piezotact render texture.wav --scale \"200 m/s2\" --transfer tf.json --out drive.wav\n  piezotact render texture.wav --scale \"200 m/s2\" --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --out drive.wav"
    )]
    Render(Render),
    /// Plays a drive on a bench and records what the finger does.
    #[command(
        after_help = "Example:\n  piezotact play drive.wav --bench twin:participant=1,seed=7 --record measured.parquet\n  piezotact play drive.wav --bench measured:hand.json,seed=7 --record rehearsed.parquet"
    )]
    Play(Play),
    /// Says how close a measurement came to its target.
    #[command(
        after_help = "Example:\n  piezotact verify --target texture.wav --scale \"200 m/s2\" --measured measured.parquet --report report.html\n  piezotact verify --target S7.wav --measured own.parquet --also averaged.parquet --transfer tf.json --report report.html\n  piezotact verify --target S2inv.wav --measured measured.parquet --before S2.wav --before S13.wav --report report.html"
    )]
    Verify(Verify),
    /// Says whether a finger could tell two vibrations apart, in just-noticeable differences.
    #[command(
        after_help = "The score does not depend on which realisation of a texture was recorded; it is the largest difference in\nspectrum, level and low-high balance, over the detection threshold, in JND. It is below the just-noticeable\ndifference (75 % of judgements correct) when all of its 95 % interval is below 1 JND, distinguishable when all of it is above\nthe published range (2.5 dB), and else not decided. The exit code is 0 whatever the verdict.\n\nExample:\n  piezotact score texture.wav measured.parquet --scale \"200 m/s2\" --report score.html\n  piezotact score S8.wav S8-synthetic.wav --scale \"200 m/s2\" --band 20..500 --json"
    )]
    Score(Score),
    /// Cuts recordings into strokes and says what was rejected, and why.
    #[command(
        after_help = "Example:\n  piezotact segment S8.parquet --report cuts.html\n  piezotact segment S8.parquet --write-cuts S8.parquet.cuts\n\nCuts in RECORDING.cuts, beside the recording, can be edited and count from then on."
    )]
    Segment(Segment),
    /// Says what the strokes of recordings hold: vibration, spectra, friction; per stroke and averaged.
    #[command(
        after_help = "Example:\n  piezotact analyse S*.parquet --by sample --report chapter3.html --csv strokes.csv\n  piezotact analyse bench/*.csv --meta '{participant}_{sample}_{speed:mm/s}mmps' --ridge 0.545mm --json"
    )]
    Analyse(Analyse),
    /// Compares samples, speeds, participants, or active with passive touch.
    #[command(
        after_help = "Two samples are told apart when a permutation test of their strokes is significant (5 % over all pairs) and the\ndistance exceeds the published range of the just-noticeable difference (JND). Distance, JND and detection\nthreshold are those of `piezotact score`; they need accelerations in m/s².\n\nExample:\n  piezotact compare Board2mm_*.csv --by speed --json\n  piezotact compare passive/S*.parquet active/S*.parquet --by touch --report comparison.html"
    )]
    Compare(Compare),
    /// Computes the roughness of a measured profile or height map.
    #[command(
        after_help = "Profiles give Ra, Rq, Rz, Rt, Rp, Rv, Rsk, Rku, RSm, Rdq; maps Sa, Sq, Sz, Sp, Sv, Ssk, Sku, Sdq, Sdr, Sal, Str.\nWith --filter none nothing but the mean height is taken away, unless --form says otherwise.\n\nExample:\n  piezotact roughness plate.x3p --report roughness.html\n  piezotact roughness line.txt --cutoff 2.5mm --x-unit mm --z-unit um --json"
    )]
    Roughness(Roughness),
    /// Measures, files, analyses and averages transfer functions of a panel of people.
    Panel(panel::Panel),
    /// Writes a texture, a drive or a transfer function as a file for other devices and programs, and says what it loses.
    #[command(
        after_help = "By the ending: .wav (32-bit float at 48 kHz, with a sidecar), .hjif (MPEG haptics), .haptic (clips for consumer\ndevices), .ahap (Apple), .uff (universal file). A .haptic clip becomes .ahap as its makers convert it.\n\nExample:\n  piezotact export texture.wav --scale \"200 m/s2\" --out texture.haptic\n  piezotact export drive.wav --transfer tf.json --out drive.hjif\n  piezotact export tf.json --out tf.uff"
    )]
    Export(Export),
    /// Records, maps and describes the digital twin: samples, people and benches without hardware.
    Twin(twin::Twin),
    /// Measures the thesis again on the digital twin, and says which of its claims hold there.
    #[command(
        after_help = "A claim that does not hold is a finding, not a failure: the exit code is 0 all the same.\n\nExample:\n  piezotact replay --chapter 3 --out replay\n  piezotact replay --twin laboratory.toml --out replay --json"
    )]
    Replay(Replay),
}

/// The recordings, and what a person adds to what they say of themselves.
#[derive(Debug, Args)]
pub(crate) struct Takes {
    #[arg(required = true, help = format!("Recordings ({})", recording_formats()))]
    pub(crate) recordings: Vec<PathBuf>,
    /// How the names of the files say conditions, such as '{sample}_F{load:N}_V{speed:mm/s}_{repeat}'. Fields:
    /// sample, participant, load, speed, angle, touch (active or passive); others are kept as labels.
    #[arg(long, value_name = "PATTERN")]
    pub(crate) meta: Option<NamePattern>,
    /// How the finger met the surface, whatever the recordings say.
    #[arg(long, value_enum)]
    pub(crate) touch: Option<TouchName>,
    /// The normal force that was asked for, in N, whatever the recordings say; where nothing says it, 0.2 N sets
    /// the thresholds.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The sliding speed, such as "30 mm/s", whatever the recordings say.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) speed: Option<Measure>,
    /// The channels that vibrate, separated by commas.
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
    /// Takes contacts as strokes also where the finger rests, or sticks and slips (when cut by force).
    #[arg(long)]
    pub(crate) every_contact: bool,
    /// A file of cuts for one recording; without it, RECORDING.cuts beside each recording counts.
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

#[derive(Debug, Args)]
pub(crate) struct Segment {
    #[command(flatten)]
    pub(crate) takes: Takes,
    /// Writes the strokes and rejects of one recording as a file of cuts to be edited.
    #[arg(long, value_name = "FILE")]
    pub(crate) write_cuts: Option<PathBuf>,
    /// Writes a table, one row for each stroke and each reject.
    #[arg(long, value_name = "TABLE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Writes a report: the signals with their cuts.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What recordings are grouped by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum By {
    /// The surface sample.
    Sample,
    /// The sliding speed.
    Speed,
    /// The participant.
    Participant,
    /// Active or passive touch.
    Touch,
    /// Each recording by itself.
    File,
}

/// How features are computed.
#[derive(Debug, Args)]
pub(crate) struct Computing {
    /// What takes the gesture away: a high-pass at this frequency in Hz, or none. Unless stated, 5 Hz for
    /// accelerations, and none for signals of another or an unknown quantity.
    #[arg(long, value_name = "HZ|none", value_parser = gesture_filter)]
    pub(crate) high_pass: Option<GestureFilter>,
    /// Samples in a segment of the PSDs; unless stated, lines are about 5 Hz apart.
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) segment: Option<usize>,
    /// The wavelength of the finger's ridges, such as 0.545mm.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) ridge: Option<Measure>,
    /// A sample set of your own (TOML) beside the two that come with the program.
    #[arg(long, value_name = "SET.toml")]
    pub(crate) set: Option<PathBuf>,
    /// Writes a tidy table, one row for each stroke.
    #[arg(long, value_name = "TABLE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
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
pub(crate) struct Analyse {
    #[command(flatten)]
    pub(crate) takes: Takes,
    /// What the averages run over; unless stated, the sample where all recordings name one, or else each file.
    #[arg(long, value_enum)]
    pub(crate) by: Option<By>,
    #[command(flatten)]
    pub(crate) computing: Computing,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) takes: Takes,
    /// What is compared.
    #[arg(long, value_enum)]
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
    /// Draws the participant, the placements of the finger, and the noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a person adds to what a recording says of itself.
#[derive(Debug, Args)]
pub(crate) struct Reading {
    /// What a sample of 1 stands for, such as "200 m/s2": full scale of a WAV file without a sidecar
    /// FILE.json, or plain numbers of a table.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) scale: Option<Measure>,
    /// The rate of a table without a time column, or at which a haptic file is played (unless stated that of HJIF curves,
    /// or 8000), in Hz.
    #[arg(long, value_name = "HZ")]
    pub(crate) rate: Option<f64>,
}

/// A whole sidecar, and the kinds of file that `info` explains.
const SIDECAR: &str = r#"A sidecar NAME.wav.json, NAME.npy.json or NAME.npz.json says what the file beside it cannot; all may be left out:
  {
    "full_scale": {"value": 200, "unit": "m/s2"},
    "channels": ["acc", "fz"],
    "units": {"fz": "2 N"},
    "condition": {"sample": "S4", "participant": "P01", "load_n": 0.4, "angle_deg": 20, "speed_m_s": 0.03, "touch": "active"},
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
    /// Where --json or --csv go instead of standard output.
    #[arg(requires = "form", conflicts_with_all = ["svg", "spectrogram"])]
    pub(crate) out: Option<PathBuf>,
    /// The channel; not needed when there is one, or one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// Samples in a segment; unless stated 1024, and about 0.1 s for --spectrogram.
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) segment: Option<usize>,
    /// The share of a segment that the next one repeats; unless stated 0.5, and 0.875 for --spectrogram.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) overlap: Option<f64>,
    /// hann, hamming, blackman, blackman-harris, flat-top or rectangular.
    #[arg(long, default_value = "hann")]
    pub(crate) window: Window,
    /// Takes the median of the segments instead of their mean: robust against single disturbances.
    #[arg(long, conflicts_with = "spectrogram")]
    pub(crate) median: bool,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Prints `frequency_hz` and `psd` as JSON.
    #[arg(long, group = "form")]
    pub(crate) json: bool,
    /// Prints frequency and PSD as CSV.
    #[arg(long, group = "form")]
    pub(crate) csv: bool,
    /// Writes a figure.
    #[arg(long, group = "form", value_name = "OUT")]
    pub(crate) svg: Option<PathBuf>,
    /// Writes a figure of the PSD over time.
    #[arg(long, group = "form", value_name = "OUT.svg")]
    pub(crate) spectrogram: Option<PathBuf>,
    /// How far up --spectrogram goes, in Hz; unless stated half the rate, or 1000 where that is less.
    #[arg(
        long,
        value_name = "HZ",
        requires = "spectrogram",
        allow_negative_numbers = true
    )]
    pub(crate) max_frequency: Option<f64>,
}

/// Which standard says what is averaged along a profile.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum StandardName {
    /// ISO 4287:1997: the mean over the sampling lengths.
    Iso4287,
    /// ISO 21920-2:2021: most parameters over the evaluation length.
    Iso21920,
}

/// What separates roughness from waviness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FilterName {
    /// The Gaussian filter of ISO 16610.
    Gauss,
    /// Nothing.
    None,
}

#[derive(Debug, Args)]
pub(crate) struct Roughness {
    #[arg(help = format!("A profile or a height map ({})", topography_formats()))]
    pub(crate) file: PathBuf,
    /// Which standard says what is averaged along a profile; iso4287 unless stated.
    #[arg(long, value_enum)]
    pub(crate) standard: Option<StandardName>,
    /// The cut-off λc of a profile, such as 2.5mm; unless stated, the rule of ISO 4288 chooses it. On a map,
    /// the nesting index of the L-filter; unless stated there is no L-filter.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    pub(crate) cutoff: Option<f64>,
    /// Chooses the cut-off by the mean width of the profile elements, as ISO 4288 asks for turned,
    /// planed and other periodic profiles.
    #[arg(long, conflicts_with = "cutoff")]
    pub(crate) periodic: bool,
    /// What separates roughness from waviness.
    #[arg(long, value_enum, default_value = "gauss")]
    pub(crate) filter: FilterName,
    /// The form that is taken away first: mean, level (least-squares line or plane) or poly2 … poly10. Level
    /// unless stated; mean with --filter none.
    #[arg(long, value_parser = form)]
    pub(crate) form: Option<Form>,
    /// What is taken away at the short end: iso (λs by ISO 3274), none, or a length such as 8um. Unless
    /// stated, iso for a profile and none for a map.
    #[arg(long, value_name = "iso|none|LENGTH", value_parser = short_waves, allow_hyphen_values = true)]
    pub(crate) s_filter: Option<ShortWaves>,
    /// The unit of the coordinates in a text that names none, such as mm.
    #[arg(long, value_name = "UNIT", value_parser = length_unit, allow_hyphen_values = true)]
    pub(crate) x_unit: Option<f64>,
    /// The unit of the heights in a text that names none, such as um.
    #[arg(long, value_name = "UNIT", value_parser = length_unit, allow_hyphen_values = true)]
    pub(crate) z_unit: Option<f64>,
    /// The step between points in a text without coordinates, such as 0.5um.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    pub(crate) step: Option<f64>,
    /// Writes a profile with its mean line and its roughness profile.
    #[arg(long, value_name = "PROFILE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A length with its unit, in m.
fn length(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(Measure {
            value,
            unit: Unit::Metre,
        }) => Ok(value),
        _ => Err(format!(
            "expected a length above zero with a unit (m, mm, um, nm), found `{text}`; write for example 2.5mm"
        )),
    }
}

/// A unit of length, in m.
fn length_unit(text: &str) -> Result<f64, String> {
    match Unit::parse(text) {
        (Unit::Metre, factor) => Ok(factor),
        _ => length(text).map_err(|_says_less| {
            format!(
                "expected a unit of length (m, mm, um, nm), found `{text}`; write for example um"
            )
        }),
    }
}

fn form(text: &str) -> Result<Form, String> {
    let degree = |text: &str| text.strip_prefix("poly")?.parse().ok();
    match (text, degree(text)) {
        ("mean", _) => Ok(Form::Mean),
        ("level", _) => Ok(Form::Level),
        (_, Some(degree @ 2..=10)) => Ok(Form::Polynomial(degree)),
        _ => Err("expected mean, level or poly2 to poly10".into()),
    }
}

fn short_waves(text: &str) -> Result<ShortWaves, String> {
    match text {
        "iso" => Ok(ShortWaves::Iso3274),
        "none" => Ok(ShortWaves::Kept),
        text => length(text).map(ShortWaves::Stated),
    }
}
