//! The commands on panels of transfer functions.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Subcommand};
use piezotact::quantity::Band;
use piezotact::transfer::BundleAverage;
use piezotact_bench::Excitation;

use piezotact_dataset::transfer_formats;

use crate::benches::{self, BenchSpec};
use crate::deliver::Outputs;

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
        after_help = "Measurements that the folder already contains are not repeated: give the same command again to continue\nan interrupted campaign.\n\nExample:\n  piezotact panel run --bench twin:seed=7 --participants 1..3 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 5 --out panel"
    )]
    Run(Run),
    /// Adds transfer functions that were measured elsewhere to a panel.
    #[command(
        after_help = "Options are only needed for what a file does not state; an option that contradicts the file is refused.\n\nExample:\n  piezotact panel add panel tf.json --participant P03 --load 0.2 --angle 20 --placement 2 --repeat 1"
    )]
    Add(Add),
    /// Computes how much participants differ, the effects of load and angle, and whether an average is sufficient.
    #[command(
        alias = "analyze",
        after_help = "Example:\n  piezotact panel analyse panel --report panel.html --csv panel.csv\n  piezotact panel analyse fingers --control control.json --band 20..1000 --json"
    )]
    Analyse(Analyse),
    /// Averages the participants at one load and angle, and estimates the error of the average for a new participant.
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
            format!(
                "expected at most {MOST} different numbers such as 1..5 or 1,3,7, found `{text}`"
            )
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
    /// Discards the raw recordings of this command at its end; by default they are kept in the folder `raw` of the panel.
    #[arg(long)]
    pub(crate) discard_raw: bool,
    /// The bench.
    #[arg(long, help = benches::help_with_turns("The bench", "--participants gives the participants"))]
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
    /// Number of consecutive measurements in each placement, without repositioning the finger.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) repeats: u32,
    /// Number of placements of the finger at each load and angle; the finger is repositioned for each.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) placements: u32,
    /// random, sweep or multisine.
    #[arg(long, default_value = "random")]
    pub(crate) excitation: Excitation,
    /// Maximum duration of each drive, in s.
    #[arg(long, default_value_t = 60.0)]
    pub(crate) seconds: f64,
    #[command(flatten)]
    pub(crate) gate: Gate,
    /// The band that is excited, in Hz.
    #[arg(long, default_value = "2..1200")]
    pub(crate) band: Band,
    /// The peak of the drive, as a fraction of the largest drive that the device can play.
    #[arg(long, default_value_t = 0.8)]
    pub(crate) peak: f64,
    /// Samples in a segment; default: 0.41 s, 2048 at 5 kHz.
    #[arg(long)]
    pub(crate) segment: Option<usize>,
    /// Seed of the random drives; each repeat uses another drive.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The folder of the panel; it is created if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Add {
    /// The folder of the panel; it is created if it does not exist.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    #[arg(required = true, help = format!("Transfer functions ({})", transfer_formats()))]
    pub(crate) files: Vec<PathBuf>,
    /// The participant's pseudonym, if a file does not state it.
    #[arg(long, value_name = "NAME")]
    pub(crate) participant: Option<String>,
    /// The normal force in N, if a file does not state it.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle in degrees, if a file does not state it.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// The number of the placement of the finger, from 1.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) placement: u32,
    /// The number of the repeat in this placement for the first file; default: the next free number.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) repeat: Option<u32>,
    /// Prints a summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum AverageName {
    /// The mean of the complex values: the magnitude is underestimated where the phases of the participants differ.
    Complex,
    /// The mean of the log magnitudes and of the phases: the magnitude is preserved.
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
    /// A control measurement without a finger: the narrow dip of the bench that it shows is removed from every measurement.
    #[arg(long, value_name = "CONTROL.json")]
    pub(crate) control: Option<PathBuf>,
    /// The band that is analysed, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// How the participants, and the repeats of each participant, are averaged.
    #[arg(long, value_enum, default_value = "log-magnitude")]
    pub(crate) average: AverageName,
    /// Largest error, in dB rms, at which an average is sufficient for a participant; it has to be for 90 % of people.
    #[arg(long, default_value_t = 3.0, value_name = "DB")]
    pub(crate) criterion: f64,
    /// Seed of the random halves of the participants (certainty of the largest difference) and of their random order
    /// (sufficient number of participants).
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

#[derive(Debug, Args)]
pub(crate) struct Average {
    /// The folder of the panel.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// The normal force in N; optional if the panel has only one.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) load: Option<f64>,
    /// The angle in degrees; optional if the panel has only one.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// How the participants, and the repeats of each participant, are averaged.
    #[arg(long, value_enum, default_value = "log-magnitude")]
    pub(crate) average: AverageName,
    /// The band in which the error of the average is estimated, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// The transfer function to write: JSON (.json), a universal file (.uff, .unv) or MATLAB (.mat).
    #[arg(long)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
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
