//! Effects of the load and of the direction of sliding.

use serde::Serialize;

use super::{CompareDoubt, Summary};
use crate::doubt::Doubt;
use crate::statistics::{LogFit, PairedDifference, log_fit, paired_difference};

/// Speeds and loads of groups that differ by no more than this share count as one.
const SAME_SHARE: f64 = 0.15;

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
    /// What it leaves open.
    #[serde(skip)]
    pub doubts: Vec<Doubt>,
}

/// How rms and friction follow the load over `groups`, one for each load, whose recordings state `stated_n`.
///
/// Formula: [`log_fit`] over groups, as over speeds.
///
/// Source: house rule; L. Felicetti's thesis (2024), section 1.2.5, for what sets the level of a texture.
#[must_use]
pub fn load_trend(groups: &[&Summary], stated_n: &[Option<f64>]) -> LoadTrend {
    let load_n = loads_n(groups, stated_n);
    let fit = |value: &dyn Fn(&Summary) -> Option<f64>| {
        let known = groups.iter().zip(&load_n);
        let known = known.filter_map(|(group, load)| Some(((*load)?, value(group)?)));
        let (load, value): (Vec<f64>, Vec<f64>) = known.unzip();
        log_fit(&load, &value)
    };
    LoadTrend {
        rms_on_load: fit(&|group| Some(group.rms.mean)),
        friction_on_load: fit(&|group| Some(group.friction_coefficient?.mean)),
        doubts: confounded(groups, None, "load"),
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

/// One direction beside the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DirectionDifference {
    /// The direction.
    pub direction: String,
    /// Its level less that of the first direction, dB; absent for the first, and where one of them is silent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_difference_db: Option<f64>,
    /// Its strokes.
    pub contacts: Contacts,
}

/// How level and stick-slip differ between directions of sliding, for one setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DirectionTrend {
    /// One for each direction; the first is what the others are compared with.
    pub directions: Vec<DirectionDifference>,
    /// What it leaves open.
    #[serde(skip)]
    pub doubts: Vec<Doubt>,
}

/// How level and stick-slip differ between `groups`, one for each direction, with their `contacts` and the loads that their
/// recordings state.
///
/// Formula: 20·log10 of the ratio of the mean rms, dB; strokes that stuck and slipped are counted and do not enter the level.
///
/// Source: L. Felicetti's thesis (2024), section 2.3.1 and figure 13.
#[must_use]
pub fn direction_trend(
    groups: &[&Summary],
    contacts: &[Contacts],
    stated_n: &[Option<f64>],
) -> DirectionTrend {
    let first = groups.first().map_or(f64::NAN, |group| group.rms.mean);
    let each = groups.iter().zip(contacts).enumerate();
    let directions = each.map(|(i, (group, contacts))| {
        let level_db = 20.0 * (group.rms.mean / first).log10();
        DirectionDifference {
            direction: group.name.clone(),
            level_difference_db: Some(level_db).filter(|db| i > 0 && db.is_finite()),
            contacts: *contacts,
        }
    });
    DirectionTrend {
        directions: directions.collect(),
        doubts: confounded(groups, Some(&loads_n(groups, stated_n)), "direction"),
    }
}

/// One direction beside another over all settings in which both were measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DirectionContrast {
    /// The direction.
    pub direction: String,
    /// What it is compared with.
    pub reference: String,
    /// In how many settings both were measured.
    pub settings: usize,
    /// Its level less that of the other, dB: mean, interval and p over settings; absent for one setting.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<PairedDifference>,
}

/// How levels differ between directions over the settings of `trends`; settings are samples, participants, speeds or loads.
///
/// Formula: [`paired_difference`] of the levels over settings.
///
/// Source: as [`super::active_against_passive`].
#[must_use]
pub fn direction_contrasts<'t>(
    trends: impl Iterator<Item = &'t DirectionTrend>,
) -> Vec<DirectionContrast> {
    let mut found: Vec<(String, String, Vec<f64>)> = Vec::new();
    for trend in trends {
        let Some((reference, others)) = trend.directions.split_first() else {
            continue;
        };
        for other in others {
            let Some(db) = other.level_difference_db else {
                continue;
            };
            let same = |(direction, of, _): &&mut (String, String, Vec<f64>)| {
                *direction == other.direction && *of == reference.direction
            };
            match found.iter_mut().find(same) {
                Some((_, _, levels)) => levels.push(db),
                None => found.push((
                    other.direction.clone(),
                    reference.direction.clone(),
                    vec![db],
                )),
            }
        }
    }
    let contrast = |(direction, reference, levels): (String, String, Vec<f64>)| DirectionContrast {
        direction,
        reference,
        settings: levels.len(),
        level: paired_difference(&vec![0.0; levels.len()], &levels),
    };
    found.into_iter().map(contrast).collect()
}

/// The load of each group, N.
fn loads_n(groups: &[&Summary], stated_n: &[Option<f64>]) -> Vec<Option<f64>> {
    let measured: Option<Vec<f64>> = groups
        .iter()
        .map(|group| Some(group.normal_force_n?.mean).filter(|force| *force > 0.0))
        .collect();
    match measured {
        Some(measured) => measured.into_iter().map(Some).collect(),
        None => stated_n.to_vec(),
    }
}

/// The doubts that groups differ in speed or load beside what is compared, or may do so.
fn confounded(groups: &[&Summary], loads_n: Option<&[Option<f64>]>, by: &str) -> Vec<Doubt> {
    let speeds: Vec<Option<f64>> = groups
        .iter()
        .map(|group| Some(group.speed_m_s?.mean * 1e3))
        .collect();
    let mut doubts = Vec::new();
    let factors = [
        Some(("speed", "mm/s", speeds.as_slice())),
        loads_n.map(|loads| ("load", "N", loads)),
    ];
    for (what, unit, values) in factors.into_iter().flatten() {
        let known: Option<Vec<f64>> = values.iter().copied().collect();
        let Some(known) = known else {
            doubts.push(Doubt::from(CompareDoubt::MayDiffer {
                what: what.into(),
                by: by.into(),
            }));
            continue;
        };
        let low = known.iter().copied().fold(f64::INFINITY, f64::min);
        let high = known.iter().copied().fold(0.0, f64::max);
        if high > (1.0 + SAME_SHARE) * low {
            doubts.push(Doubt::from(CompareDoubt::Confounded {
                what: what.into(),
                by: by.into(),
                low,
                high,
                unit: unit.into(),
            }));
        }
    }
    doubts
}
