//! Effects of the load, of the direction of sliding and of any label.

use std::collections::BTreeMap;

use serde::Serialize;

use super::confounded::{self, loads_n};
use super::trends::{friction_on, level_on};
use super::{Confounder, FrictionChange, Summary};
use crate::statistics::{LogFit, PairedDifference, mean, paired_difference};
use crate::warning::Warning;

/// How vibration and friction follow the load.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoadTrend {
    /// The load of each group, N: the mean normal force where all groups measured one, or what their recordings state.
    pub load_n: Vec<Option<f64>>,
    /// The power law of rms on load; absent for fewer than two loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_on_load: Option<LogFit>,
    /// That of the friction coefficient; absent where friction was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_on_load: Option<LogFit>,
    /// By how much friction changes.
    #[serde(skip)]
    pub friction_change: Option<FrictionChange>,
    /// What it leaves open.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// How rms and friction follow the load over `groups`, one for each load, whose recordings state `stated_n`.
///
/// Formula: [`crate::statistics::log_fit`] over groups, as over speeds; loads have to span more than 20 %.
///
/// Source: house rule; L. Felicetti's thesis (2024), section 1.2.5, for what sets the level of a texture.
#[must_use]
pub fn load_trend(groups: &[&Summary], stated_n: &[Option<f64>]) -> LoadTrend {
    let load_n = loads_n(groups, stated_n);
    let with_load = groups.iter().zip(&load_n);
    let (load, with_load): (Vec<f64>, Vec<&Summary>) = with_load
        .filter_map(|(group, load)| Some(((*load)?, *group)))
        .unzip();
    let (friction_on_load, friction_change) = friction_on(&load_n, groups).unzip();
    LoadTrend {
        rms_on_load: level_on(&load, &with_load),
        friction_on_load,
        friction_change: friction_change.flatten(),
        warnings: confounded::warnings(groups, stated_n, "load"),
        load_n,
    }
}

/// Strokes that were made, and how many of them stuck and slipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Contacts {
    /// Strokes that are analysed, and those that were rejected for stick-slip.
    pub all: usize,
    /// Those that were rejected for it.
    pub stick_slip: usize,
}

/// One value of what is compared, such as a direction, beside the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ValueDifference {
    /// The value.
    pub value: String,
    /// Its level less that of the first, dB; absent for the first, and where one of them is silent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_difference_db: Option<f64>,
    /// Its strokes.
    pub contacts: Contacts,
}

/// How level and stick-slip differ between directions of sliding, or the values of a label, for one setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ContrastTrend {
    /// One for each; the first is what the others are compared with.
    pub values: Vec<ValueDifference>,
    /// What it leaves open.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// How level and stick-slip differ between `groups`, one for each value of what they are compared `by`, with their `contacts` and the loads that their
/// recordings state.
///
/// Formula: 20·log10 of the ratio of the mean rms, dB; strokes that stuck and slipped are counted and do not enter the level.
///
/// Source: L. Felicetti's thesis (2024), section 2.3.1 and figure 13.
#[must_use]
pub fn contrast_trend(
    groups: &[&Summary],
    contacts: &[Contacts],
    stated_n: &[Option<f64>],
    by: &str,
) -> ContrastTrend {
    let first = groups.first().map_or(f64::NAN, |group| group.rms.mean);
    let each = groups.iter().zip(contacts).enumerate();
    let values = each.map(|(i, (group, contacts))| {
        let level_db = 20.0 * (group.rms.mean / first).log10();
        ValueDifference {
            value: group.name.clone(),
            level_difference_db: Some(level_db).filter(|db| i > 0 && db.is_finite()),
            contacts: *contacts,
        }
    });
    ContrastTrend {
        values: values.collect(),
        warnings: confounded::warnings(groups, stated_n, by),
    }
}

/// What the interval of a difference between two values is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ContrastUnit {
    /// Settings of one participant, or of nobody known: samples, speeds or loads.
    Settings,
    /// Participants, each the mean of their settings.
    Participants,
}

/// One value, such as a direction, beside another over all settings in which both were measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Contrast {
    /// The value.
    pub value: String,
    /// What it is compared with.
    pub reference: String,
    /// In how many settings both were measured.
    pub settings: usize,
    /// What the difference is over.
    pub over: ContrastUnit,
    /// How many of them there are.
    pub units: usize,
    /// Its level less that of the other, dB: mean, interval and p over units; absent for one setting, and for two participants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<PairedDifference>,
    /// What else differs between them in some setting.
    #[serde(skip)]
    pub confounders: Vec<Confounder>,
}

/// The values of one setting, whose they are, and what else differs between them.
#[derive(Clone, Copy, Debug)]
pub struct ContrastSetting<'t> {
    /// The participant, where known.
    pub participant: Option<&'t str>,
    pub trend: &'t ContrastTrend,
    pub confounders: &'t [Confounder],
}

/// Fewer participants than this decide nothing about people.
const LEAST_PARTICIPANTS: usize = 3;

/// How levels differ between values over `settings`: samples, participants, speeds or loads. Settings of one participant are not
/// independent: where there are several participants, they are the units.
///
/// Formula: [`paired_difference`] of the levels over units; the level of a participant is the mean over their settings.
///
/// Source: as [`super::active_against_passive`]; docs/decisions/strokes.md for the units.
#[must_use]
pub fn contrasts<'t>(settings: impl Iterator<Item = ContrastSetting<'t>>) -> Vec<Contrast> {
    let mut found: Vec<Levels<'t>> = Vec::new();
    for setting in settings {
        let Some((reference, others)) = setting.trend.values.split_first() else {
            continue;
        };
        for other in others {
            let Some(db) = other.level_difference_db else {
                continue;
            };
            let between = [other.value.as_str(), reference.value.as_str()];
            let place = found.iter().position(|known| known.between == between);
            let place = place.unwrap_or_else(|| {
                found.push(Levels {
                    between,
                    levels: Vec::new(),
                    confounders: Vec::new(),
                });
                found.len() - 1
            });
            found[place].levels.push((setting.participant, db));
            found[place].confounders.extend(setting.confounders);
        }
    }
    found.into_iter().map(Levels::contrast).collect()
}

/// The levels of one value re another, by participant.
struct Levels<'t> {
    between: [&'t str; 2],
    levels: Vec<(Option<&'t str>, f64)>,
    confounders: Vec<Confounder>,
}

impl Levels<'_> {
    fn contrast(self) -> Contrast {
        let mut people: BTreeMap<Option<&str>, Vec<f64>> = BTreeMap::new();
        for (participant, db) in &self.levels {
            people.entry(*participant).or_default().push(*db);
        }
        let (over, levels): (_, Vec<f64>) = if people.len() > 1 && !people.contains_key(&None) {
            let each = people.values().map(|levels| mean(levels));
            (ContrastUnit::Participants, each.collect())
        } else {
            let each = self.levels.iter().map(|(_, db)| *db);
            (ContrastUnit::Settings, each.collect())
        };
        let enough = over == ContrastUnit::Settings || levels.len() >= LEAST_PARTICIPANTS;
        let [value, reference] = self.between.map(str::to_owned);
        Contrast {
            value,
            reference,
            settings: self.levels.len(),
            over,
            units: levels.len(),
            level: paired_difference(&vec![0.0; levels.len()], &levels).filter(|_| enough),
            confounders: super::trends::widest(self.confounders.into_iter()),
        }
    }
}
