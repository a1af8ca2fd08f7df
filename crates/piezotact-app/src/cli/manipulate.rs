//! The command line of `piezotact manipulate`: operations in the order in which they are given.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use piezotact::lineage::{BandChange, WarpedLength};
use piezotact::quantity::{Band, Decibels, Hertz, Measure, Seconds};
use piezotact_dataset::recording_formats;

use super::Reading;

#[derive(Debug, Args)]
pub(crate) struct Manipulate {
    #[arg(help = format!("The texture: a recording in m/s² ({})", recording_formats()))]
    pub(crate) input: PathBuf,
    /// The texture to write (WAV, 32-bit float); its sidecar goes beside it.
    #[arg(long, value_name = "OUT.wav")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) operations: Operations,
    /// Takes one stroke of INPUT, from 1, freed of the gesture, instead of all of it; RECORDING.cuts counts.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) stroke: Option<u32>,
    /// The stroke of the other recordings; unless stated that of --stroke.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) of_stroke: Option<u32>,
    /// Where --rms-of measures both levels; unless stated over all frequencies.
    #[arg(long, value_name = "LOW..HIGH", requires = "rms-of")]
    pub(crate) rms_band: Option<Band>,
    /// Draws the phases of --randomise-phases.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The channel; not needed when there is one, or one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// The channel of the other recordings.
    #[arg(long)]
    pub(crate) of_channel: Option<String>,
    /// What a sample of 1 stands for in the other recordings; unless stated what they say, or --scale.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) of_scale: Option<Measure>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Writes a report: waveforms, spectra and levels, before and after.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// One operation that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Asked {
    RmsOf(PathBuf),
    Gain(Decibels),
    Band(Band, BandChange),
    /// The slope in dB an octave, and the pivot.
    Tilt(f64, Hertz),
    Shift(Hertz),
    Warp(f64, WarpedLength),
    SpectrumOf(PathBuf),
    RandomisePhases,
    Loop(Seconds),
}

/// The operations, in the order of the command line. Each is an option of its own, as options are everywhere here;
/// what a derived parser would lose is their order, so it is put together from where they stood.
#[derive(Clone, Debug)]
pub(crate) struct Operations(pub(crate) Vec<Asked>);

/// An option that takes a value: its name, what its value looks like, its help, and how it is read.
type Valued = (
    &'static str,
    &'static str,
    &'static str,
    fn(&str) -> Result<Asked, String>,
);

const HEADING: &str = "Operations, done in the order in which they are given";
const RANDOMISE: &str = "randomise-phases";
const VALUED: [Valued; 8] = [
    (
        "rms-of",
        "FILE",
        "Takes the rms of another texture: a pure gain",
        rms_of,
    ),
    ("gain", "DB", "Louder or softer, such as -3dB", gain),
    (
        "band",
        "LOW..HIGH:DB",
        "Raises or lowers a band in Hz, such as 50..100:+6dB, or removes it: 50..100:remove",
        band,
    ),
    (
        "tilt",
        "SLOPE@PIVOT",
        "Tilts the spectrum about a frequency, such as 3dB/oct@200Hz; held below 10 Hz",
        tilt,
    ),
    (
        "shift",
        "HZ",
        "Moves every frequency by as many Hz, such as 20Hz",
        shift,
    ),
    (
        "warp",
        "RATIO",
        "Multiplies every frequency, as by another speed, such as 1.25; 1.25:keep-length keeps the length",
        warp,
    ),
    (
        "spectrum-of",
        "FILE",
        "Takes the spectrum of another texture, with its own phases and rms",
        spectrum_of,
    ),
    (
        "loop",
        "SECONDS",
        "Makes it as long as that, such as 10s: joined with itself without a click, or cut",
        length,
    ),
];

impl Args for Operations {
    fn augment_args(command: Command) -> Command {
        let command = command.arg(
            Arg::new(RANDOMISE)
                .long(RANDOMISE)
                .help(
                    "Draws other phases by --seed: the same power on every line, another waveform",
                )
                .help_heading(HEADING)
                .action(ArgAction::SetTrue),
        );
        VALUED.into_iter().fold(command, |command, valued| {
            let (name, value, help, read) = valued;
            command.arg(
                Arg::new(name)
                    .long(name)
                    .value_name(value)
                    .help(help)
                    .help_heading(HEADING)
                    .action(ArgAction::Append)
                    .allow_hyphen_values(true)
                    .value_parser(read),
            )
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Operations {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut placed: Vec<(usize, Asked)> = Vec::new();
        if matches.get_flag(RANDOMISE) {
            placed.extend(
                matches
                    .index_of(RANDOMISE)
                    .map(|at| (at, Asked::RandomisePhases)),
            );
        }
        for (name, ..) in VALUED {
            let places = matches.indices_of(name).into_iter().flatten();
            let asked = matches.get_many::<Asked>(name).into_iter().flatten();
            placed.extend(places.zip(asked.cloned()));
        }
        placed.sort_by_key(|(at, _)| *at);
        Ok(Self(placed.into_iter().map(|(_, asked)| asked).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// A number, with or without `unit` after it.
fn number(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let value: f64 = text
        .strip_suffix(unit)
        .unwrap_or(text)
        .trim()
        .parse()
        .ok()?;
    value.is_finite().then_some(value)
}

#[allow(clippy::unnecessary_wraps, reason = "one type for all readers")]
fn rms_of(text: &str) -> Result<Asked, String> {
    Ok(Asked::RmsOf(text.into()))
}

#[allow(clippy::unnecessary_wraps, reason = "one type for all readers")]
fn spectrum_of(text: &str) -> Result<Asked, String> {
    Ok(Asked::SpectrumOf(text.into()))
}

fn gain(text: &str) -> Result<Asked, String> {
    number(text, "dB")
        .map(|db| Asked::Gain(Decibels(db)))
        .ok_or_else(|| "expected a gain in dB; write for example -3dB".into())
}

fn band(text: &str) -> Result<Asked, String> {
    let wrong = || {
        String::from(
            "expected a band and what to do with it; write for example 50..100:+6dB or 50..100:remove",
        )
    };
    let (band, change) = text.split_once(':').ok_or_else(wrong)?;
    let band: Band = band
        .trim()
        .trim_end_matches("Hz")
        .parse()
        .map_err(|error: piezotact::quantity::QuantityError| error.to_string())?;
    let change = match change.trim() {
        "remove" => BandChange::Removed,
        db => BandChange::Gain {
            gain_db: number(db, "dB").ok_or_else(wrong)?,
        },
    };
    Ok(Asked::Band(band, change))
}

fn tilt(text: &str) -> Result<Asked, String> {
    let parts = || {
        let (slope, pivot) = text.split_once('@')?;
        let slope = slope.trim().trim_end_matches("ave");
        Some((number(slope, "dB/oct")?, number(pivot, "Hz")?))
    };
    parts()
        .map(|(slope, pivot)| Asked::Tilt(slope, Hertz(pivot)))
        .ok_or_else(|| "expected a slope about a frequency; write for example 3dB/oct@200Hz".into())
}

fn shift(text: &str) -> Result<Asked, String> {
    number(text, "Hz")
        .map(|hz| Asked::Shift(Hertz(hz)))
        .ok_or_else(|| "expected a shift in Hz; write for example 20Hz or -20Hz".into())
}

fn warp(text: &str) -> Result<Asked, String> {
    let (ratio, length) = match text.split_once(':') {
        None => (text, WarpedLength::Follows),
        Some((ratio, "keep-length")) => (ratio, WarpedLength::Kept),
        Some((_, other)) => {
            return Err(format!(
                "expected keep-length after the ratio, found `{other}`; write for example 1.25:keep-length"
            ));
        }
    };
    number(ratio, "x")
        .map(|ratio| Asked::Warp(ratio, length))
        .ok_or_else(|| "expected a ratio of frequencies; write for example 1.25".into())
}

fn length(text: &str) -> Result<Asked, String> {
    number(text, "s")
        .map(|s| Asked::Loop(Seconds(s)))
        .ok_or_else(|| "expected a length in s; write for example 10s".into())
}
