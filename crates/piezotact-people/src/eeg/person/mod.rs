//! The desynchronisation of one person in one task, as a document: by surface, band and region, on the scalp, over time and frequency.

mod error;
mod maps;
mod page;
mod trace;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::quantity::{Band, SampleRate};
use piezotact::statistics::mean;
use piezotact::warning::Warnings;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::epochs::{CutConfig, Epochs};
use super::erd::{
    BIAS_POINTS, Changes, ChannelErd, Erd, ErdConfig, Mode, Order, changes, interval_over_epochs,
    level_db,
};
use super::filter::Pass;
use super::prepare::{EpochCounts, PrepareConfig, Prepared};
use super::reference::Montage;
use super::source::Subject;
use super::tfr::{TfrConfig, TfrPlan};
use super::{Bias, EegWarning, EpochsFault, Smeared};

pub use error::PersonError;
pub(in crate::eeg) use maps::{head_map, time_frequency_panel};
pub(in crate::eeg) use page::span_text;
pub use trace::Trace;

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
    /// How power is estimated.
    pub power: TfrConfig,
    /// About from one time of the maps to the next, s; means over baseline and window are of all samples.
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
    /// The shortest epochs of which baseline and window are free of the ends: as much longer at both ends as the longest wavelet reaches, and
    /// no shorter than it is.
    #[must_use]
    pub fn extent(&self) -> CutConfig {
        let reach_s = self.power.reach_s();
        let start_s = self.baseline_s[0].min(self.window_s[0]) - reach_s;
        let end_s = self.baseline_s[1].max(self.window_s[1]) + reach_s;
        // No shorter than a wavelet.
        let missing_s = (self.power.longest_s() + 0.02 - (end_s - start_s)).max(0.0);
        let (start_s, end_s) = (start_s - 0.5 * missing_s, end_s + 0.5 * missing_s);
        // To whole hundredths of a second, outwards, and one more: samples may be so far apart.
        CutConfig {
            start_s: ((100.0 * start_s).floor() - 1.0) / 100.0,
            end_s: ((100.0 * end_s).ceil() + 1.0) / 100.0,
        }
    }
}

impl EegErd {
    /// The same with these bands and regions alone: contrasts that were planned are adjusted among themselves. All where none is named.
    ///
    /// # Errors
    /// [`PersonError::NotThere`] for a name that no band or region has.
    pub fn only(mut self, bands: &[String], regions: &[String]) -> Result<Self, PersonError> {
        let config = &self.config;
        let there = [
            config
                .bands
                .iter()
                .map(|band| band.name.clone())
                .collect::<Vec<_>>(),
            config
                .regions
                .iter()
                .map(|region| region.name.clone())
                .collect(),
        ];
        for (wanted, there) in [bands, regions].into_iter().zip(there) {
            if let Some(name) = wanted.iter().find(|name| !there.contains(name)) {
                return Err(PersonError::NotThere {
                    name: name.clone(),
                    file: self.file.clone(),
                    there: there.join(", "),
                });
            }
        }
        let is_band = |name: &String| bands.is_empty() || bands.contains(name);
        let is_region = |name: &String| regions.is_empty() || regions.contains(name);
        self.config.bands.retain(|band| is_band(&band.name));
        self.config.regions.retain(|region| is_region(&region.name));
        self.smears.retain(|smear| is_band(&smear.band));
        self.regions
            .retain(|one| is_band(&one.band) && is_region(&one.place));
        self.electrodes.retain(|one| is_band(&one.band));
        Ok(self)
    }
}

impl PersonConfig {
    /// What is asked for in one band.
    fn of(&self, band: &NamedBand) -> ErdConfig {
        ErdConfig {
            band: band.hz,
            baseline_s: self.baseline_s,
            window_s: self.window_s,
            mode: Mode::Percent,
            min_epochs: self.min_epochs,
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
    /// Its 95 % confidence interval over the epochs of this person, %; absent where percentages of single epochs are averaged, which is
    /// biased.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub percent_interval: Option<[f64; 2]>,
    /// The same of averaged power, dB.
    pub decibels: f64,
    /// The mean power in the baseline, V²; of a region the geometric mean over its electrodes.
    pub baseline_power_v2: f64,
    /// The mean power in the window, V²; of a region the geometric mean over its electrodes.
    pub window_power_v2: f64,
    /// The bias of the percentage at no change, estimated, percentage points.
    pub bias_points: f64,
    /// How many epochs it is of.
    pub epochs: usize,
}

impl Change {
    /// The change in `unit`.
    pub(in crate::eeg) fn value(&self, unit: Mode) -> f64 {
        match unit {
            Mode::Percent => self.percent,
            Mode::Decibels => self.decibels,
        }
    }

    /// The power in the baseline, dB re 1 µV².
    pub(in crate::eeg) fn baseline_db(&self) -> f64 {
        level_db(self.baseline_power_v2)
    }

    /// The power in the window, dB re 1 µV².
    pub(in crate::eeg) fn window_db(&self) -> f64 {
        level_db(self.window_power_v2)
    }
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
    /// The power in the baseline that they are relative to, channels × frequencies, dB re 1 µV².
    pub baselines_db: Vec<f64>,
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
    /// What tells this recording from others.
    pub trace: Trace,
    /// The change over time and frequency, averaged over epochs first whatever the order of the other values, and free of the bias of the
    /// logarithm.
    pub maps: Vec<ChangeMap>,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for EegErd {
    const SCHEMA: &'static str = "eeg_erd";
    const VERSION: u32 = 3;

    /// The first version also held what independent components, multitapers and current source densities gave; the second no power of
    /// baseline and window, and no trace.
    fn outdated(version: u64, fields: &Map<String, Value>) -> Option<String> {
        let again = "make it again with `piezotact eeg erd`";
        let in_mne = "clean the recording with MNE (docs/guide/mne.md), export it, and make the document again with `piezotact eeg erd`";
        (version < 3).then(|| match fields.contains_key("eye_components") {
            true => format!(
                "eye movements were taken out by independent components, which is now done in MNE; {in_mne}"
            ),
            false => again.to_owned(),
        })
    }
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
    pub(in crate::eeg) fn of(&self, channels: &[String]) -> Result<Vec<Electrode>, PersonError> {
        let known = match self {
            Self::OfNames => Montage::known(channels),
            Self::Measured(montage) => montage.of(channels),
        };
        let named = channels.iter().zip(known);
        let found: Vec<Electrode> = named
            .filter_map(|(name, position)| {
                Some(Electrode {
                    name: name.clone(),
                    position: position?,
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
/// Formula: the least-squares line through each epoch is taken away first; electrodes have offsets of millivolts, which wavelets that reach
/// beyond an epoch would see as a step.
///
/// Source: [`super::erd::desynchronisation`] and [`super::erd::map`].
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
    let filters = filtered(&config.bands, &prepared.config.filters)?;
    let positions = positions.of(epochs.channels())?;
    let every = ((config.step_s * epochs.rate().hz()).round() as usize).max(1);
    let plan = TfrPlan::plan(&config.power, epochs.rate(), epochs.samples())?;
    let surfaces: Vec<String> = prepared
        .counts
        .conditions
        .iter()
        .map(|count| count.condition.clone())
        .collect();
    let straight = epochs.without_lines();
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
        trace: Trace::of(&straight),
        maps: Vec::new(),
        warnings: [
            prepared.warnings.clone(),
            filters,
            overlap(prepared, config),
        ]
        .concat(),
    };
    for surface in &surfaces {
        let own = straight.of_condition(surface)?;
        let of_surface = |error| PersonError::Erd {
            surface: surface.to_owned(),
            error,
        };
        let asked: Vec<ErdConfig> = config.bands.iter().map(|band| config.of(band)).collect();
        let measured = changes(&plan, &own, &asked, config.order, every).map_err(of_surface)?;
        for (band, erd) in config.bands.iter().zip(&measured.bands) {
            let changes = at_electrodes(erd, surface, band);
            let regions = config.regions.iter();
            found
                .regions
                .extend(regions.map(|region| in_region(region, &changes, erd)));
            found.electrodes.extend(changes);
            found.warnings.extend(erd.warnings.iter().cloned());
        }
        found.warnings.extend(bursts(&measured, own.count()));
        found.add_map(&plan, measured, surface);
    }
    let all = std::mem::take(&mut found.warnings);
    let once: Warnings = all.into_iter().chain(found.ratio_bias()).collect();
    found.warnings = once.into();
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

/// Refuses a band that filters take away; warnings about those of which they take a part.
fn filtered(bands: &[NamedBand], filters: &[Pass]) -> Result<Vec<Warning>, PersonError> {
    let mut warnings = Vec::new();
    for band in bands {
        let [low, high] = [band.hz.low().0, band.hz.high().0];
        for filter in filters {
            let (out, touched) = match filter {
                Pass::Above(hz) => (*hz >= high, *hz > low),
                Pass::Below(hz) => (*hz <= low, *hz < high),
                Pass::Between(from, to) => (*from >= high || *to <= low, *from > low || *to < high),
                Pass::AllBut(notches) => {
                    (false, notches.iter().any(|hz| *hz >= low && *hz <= high))
                }
            };
            if out {
                return Err(PersonError::FilteredOut {
                    name: band.name.clone(),
                    band: [low, high],
                    filter: filter.to_string(),
                });
            }
            if touched {
                let (band, filter) = (band.name.clone(), filter.to_string());
                warnings.push(
                    EegWarning::Smeared {
                        by: Smeared::FilterInBand { band, filter },
                    }
                    .into(),
                );
            }
        }
    }
    Ok(warnings)
}

/// A warning where baseline and window of one epoch reach into those of the next one.
fn overlap(prepared: &Prepared, config: &PersonConfig) -> Vec<Warning> {
    let (baseline, window) = (config.baseline_s, config.window_s);
    let needed_s = baseline[1].max(window[1]) - baseline[0].min(window[0]);
    let mut onsets = prepared.onsets_s.clone();
    onsets.sort_by(f64::total_cmp);
    let near = onsets.windows(2).map(|pair| pair[1] - pair[0]);
    let near: Vec<f64> = near.filter(|between| *between < needed_s - 1e-9).collect();
    let warning = EegWarning::Epochs {
        fault: EpochsFault::Overlap {
            overlapping: near.len(),
            of: onsets.len(),
            shortest_s: near.iter().copied().fold(f64::INFINITY, f64::min),
            needed_s,
        },
    };
    (!near.is_empty())
        .then(|| warning.into())
        .into_iter()
        .collect()
}

/// Power that scatters so much from epoch to epoch that the correction of the logarithm does not reach.
const BURSTS: f64 = 8.0;

/// A warning where power scatters far more from epoch to epoch than that of noise.
fn bursts(measured: &Changes, epochs: usize) -> Option<Warning> {
    let (channel, scatter) = measured.most_scattered.clone()?;
    let warning = EegWarning::Biased {
        channel,
        epochs,
        by: Bias::Bursts { scatter },
    };
    (scatter > BURSTS).then(|| warning.into())
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
fn at_electrodes(erd: &Erd, surface: &str, band: &NamedBand) -> Vec<Change> {
    let changes = erd.channels.iter().map(|channel| Change {
        surface: surface.to_owned(),
        band: band.name.clone(),
        place: channel.channel.clone(),
        percent: channel.change,
        percent_interval: over_epochs(erd, &[channel]),
        decibels: 10.0 * (channel.window_power / channel.baseline_power).log10(),
        baseline_power_v2: channel.baseline_power,
        window_power_v2: channel.window_power,
        bias_points: channel.bias_points,
        epochs: erd.epochs,
    });
    changes.collect()
}

/// The interval of the mean change of `channels` over epochs, %; `None` where percentages of single epochs are averaged.
fn over_epochs(erd: &Erd, channels: &[&ChannelErd]) -> Option<[f64; 2]> {
    if erd.order == Order::PercentOfEachEpoch {
        return None;
    }
    let mean = |of: &dyn Fn(&ChannelErd) -> f64| {
        let values: Vec<f64> = channels.iter().map(|channel| of(channel)).collect();
        mean(&values)
    };
    let share = |of: &dyn Fn(&ChannelErd) -> f64| mean(of) / 100.0;
    let without_each = (0..erd.epochs).map(|epoch| share(&|channel| channel.without_each[epoch]));
    let without_each: Vec<f64> = without_each.collect();
    let ends = interval_over_epochs(share(&|channel| channel.change), &without_each);
    ends.map(|ends| ends.map(|end| 100.0 * end))
}

/// The mean of the changes of a region's electrodes, all of which are there.
fn in_region(region: &Region, changes: &[Change], erd: &Erd) -> Change {
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
        percent_interval: over_epochs(
            erd,
            &(erd.channels.iter())
                .filter(|channel| region.channels.contains(&channel.channel))
                .collect::<Vec<_>>(),
        ),
        decibels: mean(&|change| change.decibels),
        // So that their ratio is the change in dB.
        baseline_power_v2: mean(&|change| change.baseline_power_v2.ln()).exp(),
        window_power_v2: mean(&|change| change.window_power_v2.ln()).exp(),
        bias_points: mean(&|change| change.bias_points),
        epochs: changes.first().map_or(0, |change| change.epochs),
    }
}

impl EegErd {
    /// The electrode, surface and band whose percentage is biased most, where that is much.
    pub(super) fn most_biased(&self) -> Option<&Change> {
        let all = self.electrodes.iter();
        let most = all.max_by(|a, b| a.bias_points.total_cmp(&b.bias_points));
        most.filter(|most| self.config.order == Order::PowerFirst && most.bias_points > BIAS_POINTS)
    }

    /// The warning about it.
    pub(super) fn ratio_bias(&self) -> Option<Warning> {
        let most = self.most_biased()?;
        let bias = EegWarning::Biased {
            channel: format!("{} ({}, {})", most.place, most.surface, most.band),
            epochs: most.epochs,
            by: Bias::Ratio {
                bias_points: most.bias_points,
            },
        };
        Some(bias.into())
    }

    /// Adds the map of one surface, at the times that the ends of epochs do not touch at any frequency.
    fn add_map(&mut self, plan: &TfrPlan, measured: Changes, surface: &str) {
        let found = measured.map;
        self.warnings.extend(found.warnings);
        let reach_s = 2.0 * plan.smears_s().iter().copied().fold(0.0, f64::max);
        let [first_s, last_s] = found.power.extent_s;
        let free =
            super::tfr::times_within(&found.power.times_s, [first_s + reach_s, last_s - reach_s]);
        self.times_s = found.power.times_s[free.clone()].to_vec();
        let lines = found.power.values.chunks_exact(found.power.times_s.len());
        self.maps.push(ChangeMap {
            surface: surface.to_owned(),
            decibels: lines.flat_map(|line| line[free.clone()].to_vec()).collect(),
            baselines_db: measured.baselines_db,
        });
    }
}

#[cfg(test)]
pub(in crate::eeg) mod tests;
