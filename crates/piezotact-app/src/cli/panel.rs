//! The commands on panels of transfer functions.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Subcommand};
use piezotact::quantity::Band;
use piezotact::transfer::BundleAverage;
use piezotact_bench::Excitation;

use piezotact_dataset::transfer_formats;

use crate::benches::{self, BenchSpec};

use super::Gate;

#[derive(Debug, Args)]
pub(crate) struct Panel {
    #[command(subcommand)]
    pub(crate) command: PanelCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PanelCommand {
    /// Measures a whole panel on a bench: every participant at every load and angle, several times.
    #[command(
        after_help = "What the folder already holds is not measured again: run the same command to go on with a campaign\nthat broke off.\n\nExample:\n  piezotact panel run --bench twin:seed=7 --participants 1..3 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 5 --out panel"
    )]
    Run(Run),
    /// Files transfer functions that were measured elsewhere in a panel.
    #[command(
        after_help = "What a transfer function says of itself need not be stated, and cannot be stated otherwise.\n\nExample:\n  piezotact panel add panel tf.json --participant P03 --load 0.2 --angle 20 --placement 2 --repeat 1"
    )]
    Add(Add),
    /// Says how far people lie apart and where most, what load and angle do, and whether an average will do.
    #[command(
        after_help = "Example:\n  piezotact panel analyse panel --report panel.html --csv panel.csv\n  piezotact panel analyse fingers --control control.json --band 20..1000 --json"
    )]
    Analyse(Analyse),
    /// Averages the people of one load and angle, with what that costs a new person.
    #[command(
        after_help = "Example:\n  piezotact panel average panel --load 0.2 --angle 20 --out average.json\n  piezotact render texture.wav --scale \"200 m/s2\" --transfer average.json --out drive.wav"
    )]
    Average(Average),
}

/// Participants by number: `1..5`, `1,3,7`, or both together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Participants(pub(crate) Vec<u64>);

impl FromStr for Participants {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const MOST: u64 = 1_000;
        let wrong = || {
            format!("expected up to {MOST} different numbers such as 1..5 or 1,3,7, found `{text}`")
        };
        let number = |part: &str| part.trim().parse::<u64>().map_err(|_no_number| wrong());
        let mut numbers = Vec::new();
        for part in text.split(',') {
            let (first, last) = match part.split_once("..") {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(part)?, number(part)?),
            };
            if first > last || last - first >= MOST {
                return Err(wrong());
            }
            numbers.extend(first..=last);
        }
        let mut once = numbers.clone();
        once.sort_unstable();
        once.dedup();
        if once.len() != numbers.len() || numbers.len() as u64 > MOST {
            return Err(wrong());
        }
        Ok(Self(numbers))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Throws the raw recordings of this command away at its end; else they are kept in the folder `raw` of the panel.
    #[arg(long)]
    pub(crate) discard_raw: bool,
    /// The bench.
    #[arg(long, help = benches::help_with_turns("The bench", "who sits at it says --participants"))]
    pub(crate) bench: BenchSpec,
    /// The participants, such as 1..5 or 1,3,7.
    #[arg(long)]
    pub(crate) participants: Participants,
    /// The normal forces, in N, separated by commas.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0.2,0.4,0.6",
        allow_negative_numbers = true
    )]
    pub(crate) loads: Vec<f64>,
    /// The angles between finger and surface, in degrees, separated by commas.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "20,40",
        allow_negative_numbers = true
    )]
    pub(crate) angles: Vec<f64>,
    /// Consecutive measurements of each placement, the finger left where it is.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) repeats: u32,
    /// How many times the finger is put down at each load and angle.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) placements: u32,
    /// random, sweep or multisine.
    #[arg(long, default_value = "random")]
    pub(crate) excitation: Excitation,
    /// How long each drive lasts at most, in s.
    #[arg(long, default_value_t = 30.0)]
    pub(crate) seconds: f64,
    #[command(flatten)]
    pub(crate) gate: Gate,
    /// The band that is driven, in Hz.
    #[arg(long, default_value = "2..1200")]
    pub(crate) band: Band,
    /// The peak of the drive, as a share of what the device can play.
    #[arg(long, default_value_t = 0.8)]
    pub(crate) peak: f64,
    /// Samples in a segment.
    #[arg(long, default_value_t = 2048)]
    pub(crate) segment: usize,
    /// Draws the random drives, another one for each repeat.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The folder of the panel; it is made where there is none.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Add {
    /// The folder of the panel; it is made where there is none.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    #[arg(required = true, help = format!("Transfer functions ({})", transfer_formats()))]
    pub(crate) files: Vec<PathBuf>,
    /// The participant's pseudonym, where a file does not say it.
    #[arg(long, value_name = "NAME")]
    pub(crate) participant: Option<String>,
    /// The normal force in N, where a file does not say it.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle in degrees, where a file does not say it.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// Which time the finger was put down.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) placement: u32,
    /// Which measurement of that placement the first file is; the next free one unless stated.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) repeat: Option<u32>,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum AverageName {
    /// The mean of the complex values: it loses magnitude where people's phases differ.
    Complex,
    /// The mean of log magnitudes and of phases: it does not.
    LogMagnitude,
}

impl AverageName {
    pub(crate) fn averaging(self) -> BundleAverage {
        match self {
            Self::Complex => BundleAverage::Complex,
            Self::LogMagnitude => BundleAverage::LogMagnitude,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Analyse {
    /// The folder of the panel.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// A control measurement without a finger: the bench's own narrow dip in it is taken out of every finger.
    #[arg(long, value_name = "CONTROL.json")]
    pub(crate) control: Option<PathBuf>,
    /// The band, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// How people, and the repeats of each, are averaged.
    #[arg(long, value_enum, default_value = "log-magnitude")]
    pub(crate) average: AverageName,
    /// The mean error, in dB rms, up to which an average will do for a new person.
    #[arg(long, default_value_t = 3.0, value_name = "DB")]
    pub(crate) criterion: f64,
    /// Draws halves of the people, for how sure the worst case is, and their order, for how many are enough.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Writes a tidy table, one row for each load, angle and band.
    #[arg(long, value_name = "TABLE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Average {
    /// The folder of the panel.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// The normal force in N; not needed where there is one.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle in degrees; not needed where there is one.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// How people, and the repeats of each, are averaged.
    #[arg(long, value_enum, default_value = "log-magnitude")]
    pub(crate) average: AverageName,
    /// The band over which it is said what the average costs, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// The transfer function to write.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(test)]
mod tests {
    use super::Participants;

    #[test]
    fn participants_are_ranges_and_lists() {
        let read = |text: &str| text.parse::<Participants>().map(|p| p.0);
        assert_eq!(read("1..3,7").unwrap(), [1, 2, 3, 7]);
        assert_eq!(read("4").unwrap(), [4]);
        for bad in [
            "",
            "3..1",
            "a",
            "1,1",
            "1..2,2",
            "0..5000",
            "-1",
            "1...3",
            "0..18446744073709551615",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
