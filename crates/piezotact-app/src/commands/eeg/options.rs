//! Options that epochs and ERD share, and values of options.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use piezotact::quantity::{Band, Hertz, QuantityError};
use piezotact_people::eeg::epochs::{Criterion, CutConfig};
use piezotact_people::eeg::erd::Order;
use piezotact_people::eeg::filter::Pass;
use piezotact_people::eeg::person::{NamedBand, Region};
use piezotact_people::eeg::prepare::{ChannelChoice, MarkerChoice, PrepareConfig, Reference};
use piezotact_people::eeg::source::StatedChannel;
use piezotact_people::eeg::tfr::Cycles;

#[derive(Debug, Args)]
pub(super) struct Preparing {
    /// The participant's pseudonym; default: that of a BIDS name.
    #[arg(long, value_name = "NAME")]
    pub(super) participant: Option<String>,
    /// The task; default: that of a BIDS name, or of the only marker `task`. Of a file with markers of several tasks, the one whose epochs
    /// are taken.
    #[arg(long, value_name = "TASK")]
    pub(super) task: Option<String>,
    /// A marker around which epochs are cut, by its whole name, kind or value, and the condition (surface) that it stands for; several are
    /// allowed. A kind alone (`control` for `control/BIO`) makes its values the conditions. `piezotact eeg info` lists the markers.
    #[arg(long, value_name = "MARKER[=CONDITION]")]
    event: Vec<Choice>,
    /// A table of markers that is read in the place of those of the file: columns onset (s from its first sample), duration, and `trial_type` or value
    /// (BIDS `_events.tsv`).
    #[arg(long, value_name = "EVENTS.tsv")]
    pub(super) events: Option<PathBuf>,
    /// The electrodes, separated by commas; default: all.
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        conflicts_with = "without"
    )]
    channels: Vec<String>,
    /// Channels that are left out, separated by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    without: Vec<String>,
    /// Passes frequencies above this one, Hz, without delay.
    #[arg(long, value_name = "HZ")]
    high_pass: Option<f64>,
    /// Passes frequencies below this one, Hz, without delay.
    #[arg(long, value_name = "HZ")]
    low_pass: Option<f64>,
    /// Takes away the mains and its multiples, Hz, separated by commas: 50,100.
    #[arg(long, value_name = "HZ", value_delimiter = ',')]
    notch: Vec<f64>,
    /// EOG channels, separated by commas: their part in the others is taken away by regression.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    eog: Vec<String>,
    /// Electrodes to interpolate from the others by spherical splines, separated by commas; `bad`: those that the table of channels beside
    /// the file marks as bad.
    #[arg(long, value_name = "NAMES|bad", value_delimiter = ',')]
    interpolate: Vec<String>,
    /// The reference: `as-recorded`, `average` of all electrodes, or names of channels, separated by
    /// commas.
    #[arg(long, value_name = "REFERENCE", default_value = "as-recorded")]
    reference: Referred,
    /// Rejects epochs in which a channel spans more than this, µV peak to peak.
    #[arg(long, value_name = "UV")]
    reject_above: Option<f64>,
    /// Rejects epochs in which a channel spans less than this, µV peak to peak: it is flat.
    #[arg(long, value_name = "UV")]
    reject_below: Option<f64>,
    /// Rejects epochs in which a channel drifts by more than this, µV over the epoch.
    #[arg(long, value_name = "UV")]
    reject_drift: Option<f64>,
}

impl Preparing {
    /// How epochs of `extent` are made, with the task of the file where it names one, and what stands beside it about its channels.
    pub(super) fn config(
        &self,
        extent: CutConfig,
        task: Option<String>,
        stated: &[StatedChannel],
        min_epochs: usize,
    ) -> PrepareConfig {
        let passes = [
            self.high_pass.map(Pass::Above),
            self.low_pass.map(Pass::Below),
            (!self.notch.is_empty()).then(|| Pass::AllBut(self.notch.clone())),
        ];
        // Options are in µV.
        let volts = |uv: f64| uv / 1e6;
        let criteria = [
            self.reject_above
                .map(|uv| Criterion::PeakToPeak { above_v: volts(uv) }),
            self.reject_below
                .map(|uv| Criterion::Flat { below_v: volts(uv) }),
            self.reject_drift
                .map(|uv| Criterion::Drift { above_v: volts(uv) }),
        ];
        PrepareConfig {
            markers: self.event.iter().map(|choice| choice.0.clone()).collect(),
            task,
            extent,
            channels: match self.channels.is_empty() {
                true => ChannelChoice::AllBut(self.without.clone()),
                false => ChannelChoice::Named(self.channels.clone()),
            },
            filters: passes.into_iter().flatten().collect(),
            eog: self.eog.clone(),
            interpolated: self.interpolated(stated),
            reference: self.reference.0.clone(),
            criteria: criteria.into_iter().flatten().collect(),
            min_epochs,
        }
    }
}

impl Preparing {
    /// The electrodes to interpolate: as named, and those that the table calls bad where asked for.
    fn interpolated(&self, stated: &[StatedChannel]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for name in &self.interpolate {
            let own = match name.trim() {
                "bad" => {
                    let bad = stated.iter().filter(|channel| channel.is_bad);
                    bad.map(|channel| channel.name.clone()).collect()
                }
                name => vec![name.to_owned()],
            };
            for name in own {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        names
    }
}

/// A marker and its condition.
#[derive(Clone, Debug)]
struct Choice(MarkerChoice);

impl FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (marker, condition) = text.split_once('=').unwrap_or((text, text));
        if marker.trim().is_empty() || condition.trim().is_empty() {
            return Err(format!(
                "expected MARKER or MARKER=CONDITION, found `{text}`"
            ));
        }
        Ok(Self(MarkerChoice {
            marker: marker.trim().to_owned(),
            condition: condition.trim().to_owned(),
        }))
    }
}

/// A reference.
#[derive(Clone, Debug)]
struct Referred(Reference);

impl FromStr for Referred {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(Self(match text {
            "as-recorded" => Reference::AsRecorded,
            "average" => Reference::Average,
            names => {
                let names: Vec<String> = names.split(',').map(|n| n.trim().to_owned()).collect();
                if names.iter().any(String::is_empty) {
                    return Err(format!(
                        "expected as-recorded, average or names of channels, found `{text}`"
                    ));
                }
                Reference::Channels(names)
            }
        }))
    }
}

/// Two times, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span(pub(super) [f64; 2]);

impl FromStr for Span {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!("expected two times in s, the earlier first, such as -1.5,0.8; found `{text}`")
        };
        let (from, to) = text
            .split_once("..")
            .or_else(|| text.split_once(','))
            .ok_or_else(wrong)?;
        match (from.trim().parse::<f64>(), to.trim().parse::<f64>()) {
            (Ok(from), Ok(to)) if from.is_finite() && to.is_finite() && from < to => {
                Ok(Self([from, to]))
            }
            _ => Err(wrong()),
        }
    }
}

impl From<Span> for CutConfig {
    fn from(Span([start_s, end_s]): Span) -> Self {
        Self { start_s, end_s }
    }
}

/// A band with its name: `alpha=8..12`.
#[derive(Clone, Debug)]
pub(super) struct BandOption(pub(super) NamedBand);

impl FromStr for BandOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("expected NAME=LOW..HIGH in Hz, such as alpha=8..12; found `{text}`");
        let (name, hz) = text.split_once('=').ok_or_else(wrong)?;
        let hz: Band = hz.parse().map_err(|_no_band| wrong())?;
        Ok(Self(NamedBand {
            name: name.trim().to_owned(),
            hz,
        }))
    }
}

/// A region with its electrodes: `left=C1,C3,CP3`.
#[derive(Clone, Debug)]
pub(super) struct RegionOption(pub(super) Region);

impl FromStr for RegionOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, channels) = text.split_once('=').unwrap_or((text, text));
        let channels: Vec<String> = channels.split(',').map(|n| n.trim().to_owned()).collect();
        if name.trim().is_empty() || channels.iter().any(String::is_empty) {
            return Err(format!(
                "expected NAME=ELECTRODES, such as left=C1,C3,CP3; found `{text}`"
            ));
        }
        Ok(Self(Region {
            name: name.trim().to_owned(),
            channels,
        }))
    }
}

/// Frequencies that `bands` need: from 2 Hz below the lowest one to 30 Hz, or the highest one.
pub(super) fn covering(bands: impl Iterator<Item = Band>) -> Result<Band, QuantityError> {
    let ends = bands.map(|band| [band.low().0, band.high().0]);
    let [low, high] = ends.fold([f64::INFINITY, 30.0], |[low, high], [from, to]| {
        [low.min(from), high.max(to)]
    });
    Band::new(Hertz((low - 2.0).floor().max(1.0)), Hertz(high.ceil()))
}

/// Cycles of wavelets: `7`, or `f/2`.
#[derive(Clone, Copy, Debug)]
pub(super) struct CyclesOption(pub(super) Cycles);

impl FromStr for CyclesOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, of): (&str, fn(f64) -> Cycles) = match text.split_once('/') {
            Some((f, share)) if f.trim() == "f" => (share, Cycles::FrequencyOver),
            _ => (text, Cycles::Constant),
        };
        match number.trim().parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() => Ok(Self(of(number))),
            _ => Err(format!(
                "expected a number of cycles above 0, or f/2 for half the frequency in Hz; found `{text}`"
            )),
        }
    }
}

/// What is averaged before the baseline is divided.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum OrderOption {
    /// Power over epochs.
    PowerFirst,
    /// Nothing: percentages of single epochs are averaged. Biased towards synchronisation, by a quarter and more.
    PercentOfEachEpoch,
}

impl From<OrderOption> for Order {
    fn from(order: OrderOption) -> Self {
        match order {
            OrderOption::PowerFirst => Self::PowerFirst,
            OrderOption::PercentOfEachEpoch => Self::PercentOfEachEpoch,
        }
    }
}
