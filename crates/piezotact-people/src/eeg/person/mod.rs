//! The desynchronisation of one person in one task, as a document: by surface, band and region, on the scalp, over time and frequency.

mod error;
mod maps;
mod page;

use piezotact::Doubt;
use piezotact::document::Content;
use piezotact::quantity::{Band, SampleRate};
use serde::{Deserialize, Serialize};

use super::epochs::{CutConfig, Epochs};
use super::erd::{
    ErdConfig, Mode, Order, biased_percent_of_each_epoch, desynchronisation, map as change_map,
};
use super::prepare::{EpochCounts, PrepareConfig, Prepared};
use super::reference::Montage;
use super::source::Subject;
use super::tfr::{TfrConfig, TfrPlan};

pub use error::PersonError;
pub(in crate::eeg) use maps::{head_map, time_frequency_panel};
pub(in crate::eeg) use page::span_text;

/// A scalp map needs so many electrodes with a known position.
pub(in crate::eeg) const FEWEST_OF_A_MAP: usize = 8;

/// A band with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct NamedBand {
    /// Its name: "alpha".
    pub name: String,
    /// The band.
    pub hz: Band,
}

/// A region: electrodes whose changes are averaged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Its electrodes.
    pub channels: Vec<String>,
}

/// What is compared with what. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PersonConfig {
    /// How power is estimated; which times are given out follows from `step_s`.
    pub power: TfrConfig,
    /// About from one time of the maps to the next, s.
    pub step_s: f64,
    /// The bands.
    pub bands: Vec<NamedBand>,
    /// The regions.
    pub regions: Vec<Region>,
    /// The baseline from the marker, s.
    pub baseline_s: [f64; 2],
    /// The window from the marker, s.
    pub window_s: [f64; 2],
    /// What is averaged before the baseline is divided.
    pub order: Order,
    /// With fewer epochs of a surface there is no result.
    pub min_epochs: usize,
}

impl PersonConfig {
    /// The shortest epochs of which baseline and window are free of the ends: as much longer at both ends as the longest wavelet reaches.
    #[must_use]
    pub fn extent(&self) -> CutConfig {
        let reach_s = self.power.reach_s();
        // To whole hundredths of a second, outwards.
        let start_s = self.baseline_s[0].min(self.window_s[0]) - reach_s;
        let end_s = self.baseline_s[1].max(self.window_s[1]) + reach_s;
        CutConfig {
            start_s: (100.0 * start_s).floor() / 100.0,
            end_s: (100.0 * end_s).ceil() / 100.0,
        }
    }
}

impl Region {
    /// A region of each of these electrodes.
    #[must_use]
    pub fn single(names: &[&str]) -> Vec<Self> {
        let one = |name: &&str| Self {
            name: (*name).to_owned(),
            channels: vec![(*name).to_owned()],
        };
        names.iter().map(one).collect()
    }
}

/// The change of power at one electrode or region, in one band, on one surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Change {
    /// The surface.
    pub surface: String,
    /// The name of the band.
    pub band: String,
    /// The region or electrode.
    pub place: String,
    /// The change, %; negative is a desynchronisation.
    pub percent: f64,
    /// The same of averaged power, dB.
    pub decibels: f64,
    /// The bias of the percentage at no change, estimated, percentage points.
    pub bias_points: f64,
    /// How many epochs it is of.
    pub epochs: usize,
}

/// How far the wavelets of a band smear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Smear {
    /// The name of the band.
    pub band: String,
    /// The standard deviation of the longest wavelet, s.
    pub smear_s: f64,
}

/// The change of averaged power over electrodes, frequencies and times on one surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ChangeMap {
    /// The surface.
    pub surface: String,
    /// Channels × frequencies × times, dB.
    pub decibels: Vec<f64>,
}

/// An electrode with its position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Electrode {
    /// Its name.
    pub name: String,
    /// Its position on a sphere of radius 1: to the right, to the front, up.
    pub position: [f64; 3],
}

/// The desynchronisation of one person in one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EegErd {
    /// The file.
    pub file: String,
    /// Who and what it is of.
    pub subject: Subject,
    /// How epochs were made.
    pub preparation: PrepareConfig,
    /// What was compared.
    pub config: PersonConfig,
    /// The rate of the signals.
    pub rate_hz: SampleRate,
    /// Which markers have an epoch.
    pub counts: EpochCounts,
    /// The surfaces, in the order in which they were asked for.
    pub surfaces: Vec<String>,
    /// How far wavelets smear.
    pub smears: Vec<Smear>,
    /// The change in each region.
    pub regions: Vec<Change>,
    /// The change at each electrode.
    pub electrodes: Vec<Change>,
    /// The electrodes of the maps.
    pub channels: Vec<String>,
    /// Those of them whose position is known.
    pub positions: Vec<Electrode>,
    /// The times of the maps from the marker, s: those that the ends of epochs do not touch.
    pub times_s: Vec<f64>,
    /// The change over time and frequency, averaged over epochs first whatever the order of the other values.
    pub maps: Vec<ChangeMap>,
    /// What to know before relying on it.
    pub doubts: Vec<Doubt>,
}

impl Content for EegErd {
    const SCHEMA: &'static str = "eeg_erd";
}

/// Where electrodes are.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// Where the 10-10 system has their names.
    OfNames,
    /// As measured.
    Measured(Montage),
}

impl Positions {
    /// The positions of those of `channels` that have one.
    ///
    /// # Errors
    /// [`PersonError::NoPosition`] for measured positions of which none is that of a channel.
    fn of(&self, channels: &[String]) -> Result<Vec<Electrode>, PersonError> {
        let position = |name: &String| match self {
            Self::OfNames => {
                let one = Montage::ten_ten(std::slice::from_ref(name)).ok()?;
                one.positions.first().copied()
            }
            Self::Measured(montage) => {
                let own = montage.channels.iter().position(|own| own == name)?;
                Some(montage.positions[own])
            }
        };
        let found: Vec<Electrode> = channels
            .iter()
            .filter_map(|name| {
                Some(Electrode {
                    name: name.clone(),
                    position: position(name)?,
                })
            })
            .collect();
        match self {
            Self::Measured(montage) if found.is_empty() => Err(PersonError::NoPosition {
                channels: channels.join(", "),
                found: montage.channels.join(", "),
            }),
            _ => Ok(found),
        }
    }
}

/// The desynchronisation of one person in one task, from prepared epochs whose conditions are surfaces: % and dB of power relative to the
/// baseline, by band in regions (the mean of the changes of their electrodes) and at electrodes, and dB over time and frequency.
///
/// Source: [`desynchronisation`] and [`super::erd::map`].
///
/// # Errors
/// [`PersonError`] for a region with an electrode that is not there, measured positions of other electrodes, wavelets longer than the
/// epochs, and what these functions refuse.
pub fn person(
    file: &str,
    subject: &Subject,
    prepared: &Prepared,
    positions: &Positions,
    config: &PersonConfig,
) -> Result<EegErd, PersonError> {
    let epochs = &prepared.epochs;
    check(config, epochs)?;
    let positions = positions.of(epochs.channels())?;
    let config = &PersonConfig {
        power: config.power.clone().every(config.step_s, epochs.rate()),
        ..config.clone()
    };
    let plan = TfrPlan::plan(&config.power, epochs.rate(), epochs.samples())?;
    let surfaces: Vec<String> = prepared
        .counts
        .conditions
        .iter()
        .map(|count| count.condition.clone())
        .collect();
    let mut found = EegErd {
        file: file.to_owned(),
        subject: subject.clone(),
        preparation: prepared.config.clone(),
        config: config.clone(),
        rate_hz: epochs.rate(),
        counts: prepared.counts.clone(),
        surfaces: surfaces.clone(),
        smears: smears(config, &plan),
        regions: Vec::new(),
        electrodes: Vec::new(),
        channels: epochs.channels().to_vec(),
        positions,
        times_s: Vec::new(),
        maps: Vec::new(),
        doubts: prepared.doubts.clone(),
    };
    for surface in &surfaces {
        let own = epochs.of_condition(surface)?;
        for band in &config.bands {
            let (changes, doubts) = at_electrodes(&plan, &own, surface, band, config)?;
            let regions = config.regions.iter();
            found
                .regions
                .extend(regions.map(|region| in_region(region, &changes)));
            found.electrodes.extend(changes);
            found.doubts.extend(doubts);
        }
        found.add_map(&plan, &own, surface)?;
    }
    // The same of every surface and band is said once.
    let mut once: Vec<Doubt> = Vec::new();
    for doubt in found.doubts.drain(..) {
        if !once.contains(&doubt) {
            once.push(doubt);
        }
    }
    found.doubts = once;
    Ok(found)
}

fn check(config: &PersonConfig, epochs: &Epochs) -> Result<(), PersonError> {
    if config.bands.is_empty() || config.regions.is_empty() {
        return Err(PersonError::Nothing);
    }
    let names = [
        config.bands.iter().map(|one| &one.name).collect::<Vec<_>>(),
        config.regions.iter().map(|one| &one.name).collect(),
    ];
    for names in names {
        let twice = names
            .iter()
            .enumerate()
            .find(|(at, name)| names[..*at].contains(name));
        if let Some((_, name)) = twice {
            return Err(PersonError::Twice {
                name: (*name).clone(),
            });
        }
    }
    // A band between the first and the last frequency is covered as densely as they are stated.
    let hz = &config.power.frequencies_hz;
    let [least, most] = [hz.first(), hz.last()].map(|end| end.copied().unwrap_or_default());
    for band in &config.bands {
        if band.hz.low().0 < least || band.hz.high().0 > most {
            return Err(PersonError::Band {
                name: band.name.clone(),
                band: [band.hz.low().0, band.hz.high().0],
                covered: [least, most],
            });
        }
    }
    for region in &config.regions {
        let missing = region
            .channels
            .iter()
            .find(|name| !epochs.channels().contains(name));
        if missing.is_some() || region.channels.is_empty() {
            return Err(PersonError::Region {
                region: region.name.clone(),
                channel: missing.cloned().unwrap_or_else(|| "no electrode".into()),
                channels: epochs.channels().join(", "),
            });
        }
    }
    Ok(())
}

fn smears(config: &PersonConfig, plan: &TfrPlan) -> Vec<Smear> {
    let lines = || config.power.frequencies_hz.iter().zip(plan.smears_s());
    let of = |band: &NamedBand| Smear {
        band: band.name.clone(),
        smear_s: lines()
            .filter(|(hz, _)| band.hz.contains(**hz))
            .map(|(_, smear)| *smear)
            .fold(0.0, f64::max),
    };
    config.bands.iter().map(of).collect()
}

/// The changes at all electrodes in one band on one surface.
fn at_electrodes(
    plan: &TfrPlan,
    epochs: &Epochs,
    surface: &str,
    band: &NamedBand,
    config: &PersonConfig,
) -> Result<(Vec<Change>, Vec<Doubt>), PersonError> {
    let asked = ErdConfig {
        band: band.hz,
        baseline_s: config.baseline_s,
        window_s: config.window_s,
        mode: Mode::Percent,
        min_epochs: config.min_epochs,
    };
    let found = match config.order {
        Order::PowerFirst => desynchronisation(plan, epochs, &asked),
        Order::PercentOfEachEpoch => biased_percent_of_each_epoch(plan, epochs, &asked),
    };
    let found = found.map_err(|error| PersonError::Erd {
        surface: surface.to_owned(),
        error,
    })?;
    let changes = found.channels.iter().map(|channel| Change {
        surface: surface.to_owned(),
        band: band.name.clone(),
        place: channel.channel.clone(),
        percent: channel.change,
        decibels: 10.0 * (channel.window_power / channel.baseline_power).log10(),
        bias_points: channel.bias_points,
        epochs: found.epochs,
    });
    Ok((changes.collect(), found.doubts))
}

/// The mean of the changes of a region's electrodes, all of which are there.
fn in_region(region: &Region, changes: &[Change]) -> Change {
    let own: Vec<&Change> = changes
        .iter()
        .filter(|change| region.channels.contains(&change.place))
        .collect();
    let mean = |of: &dyn Fn(&Change) -> f64| {
        own.iter().map(|change| of(change)).sum::<f64>() / own.len().max(1) as f64
    };
    Change {
        surface: changes
            .first()
            .map_or_else(String::new, |c| c.surface.clone()),
        band: changes.first().map_or_else(String::new, |c| c.band.clone()),
        place: region.name.clone(),
        percent: mean(&|change| change.percent),
        decibels: mean(&|change| change.decibels),
        bias_points: mean(&|change| change.bias_points),
        epochs: changes.first().map_or(0, |change| change.epochs),
    }
}

impl EegErd {
    /// Adds the map of one surface, at the times that the ends of epochs do not touch at any frequency.
    fn add_map(
        &mut self,
        plan: &TfrPlan,
        epochs: &Epochs,
        surface: &str,
    ) -> Result<(), PersonError> {
        let power = plan.average(epochs)?;
        let erd = |error| PersonError::Erd {
            surface: surface.to_owned(),
            error,
        };
        let found = change_map(
            &power,
            self.config.baseline_s,
            Mode::Decibels,
            self.config.min_epochs,
        )
        .map_err(erd)?;
        self.doubts.extend(found.doubts);
        let reach_s = 2.0 * plan.smears_s().iter().copied().fold(0.0, f64::max);
        let [first_s, last_s] = found.power.extent_s;
        let free =
            super::tfr::times_within(&found.power.times_s, [first_s + reach_s, last_s - reach_s]);
        self.times_s = found.power.times_s[free.clone()].to_vec();
        let lines = found.power.values.chunks_exact(found.power.times_s.len());
        self.maps.push(ChangeMap {
            surface: surface.to_owned(),
            decibels: lines.flat_map(|line| line[free.clone()].to_vec()).collect(),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests;
