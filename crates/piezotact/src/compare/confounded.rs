//! Conditions that differ between groups beside the one that is compared.

use super::{CompareWarning, Mixed, Summary};
use crate::feature::Statistics;
use crate::number::digits;
use crate::warning::Warning;

/// Speeds and loads of groups that differ by no more than this share count as one.
const SAME_SHARE: f64 = 0.15;
/// Groups whose means lie more standard deviations than this from what is between them do not overlap.
const APART: f64 = 2.0;

/// A condition in which groups differ beside what is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confounder {
    /// The condition: "speed" or "load".
    pub what: &'static str,
    pub unit: &'static str,
    /// The least mean of a group …
    pub low: f64,
    pub high: f64,
    /// Whether the strokes of these two groups have no value in common: then what is compared and this cannot be told apart.
    pub complete: bool,
}

impl Confounder {
    /// The warning that a difference between groups `by` something may come from it.
    #[must_use]
    pub fn warning(&self, by: &str) -> Warning {
        Warning::from(CompareWarning::Mixed {
            how: Mixed::Confounded {
                what: self.what.into(),
                by: by.into(),
                low: self.low,
                high: self.high,
                unit: self.unit.into(),
            },
        })
    }
}

/// What differs, in words, where it differs completely; `None` where nothing does.
fn complete(confounders: &[Confounder]) -> Option<String> {
    let complete = confounders.iter().filter(|c| c.complete);
    let texts: Vec<String> = complete
        .map(|c| {
            let (low, high) = (digits(c.low), digits(c.high));
            format!("the {} differs too ({low} to {high} {})", c.what, c.unit)
        })
        .collect();
    (!texts.is_empty()).then(|| texts.join(" and "))
}

/// `conclusion` as it stands, or as not decided where a condition differs as completely as what is compared.
///
/// Source: docs/decisions/strokes.md.
#[must_use]
pub fn unless_confounded(confounders: &[Confounder], conclusion: String) -> String {
    match complete(confounders) {
        Some(what) => format!("cause not decided, since {what}: {conclusion}"),
        None => conclusion,
    }
}

/// A condition of each group, where it is known of all: its name, its unit, and mean and deviation over strokes.
type Factor = (&'static str, &'static str, Vec<Option<(f64, f64)>>);

/// The speeds and loads of `groups`, whose recordings state the loads `stated_n`, unless they are what is compared.
fn factors(groups: &[&Summary], stated_n: &[Option<f64>], by: &str) -> Vec<Factor> {
    let known = |s: Statistics, scale: f64| (s.mean * scale, s.sd * scale);
    let speeds = groups
        .iter()
        .map(|group| Some(known(group.speed_m_s?, 1e3)));
    let measured: Option<Vec<(f64, f64)>> = groups
        .iter()
        .map(|group| Some(known(group.normal_force_n?, 1.0)).filter(|(mean, _)| *mean > 0.0))
        .collect();
    let loads = match measured {
        Some(measured) => measured.into_iter().map(Some).collect(),
        None => stated_n.iter().map(|load| Some(((*load)?, 0.0))).collect(),
    };
    let mut factors = vec![("speed", "mm/s", speeds.collect()), ("load", "N", loads)];
    factors.retain(|(what, ..)| *what != by);
    factors
}

/// The load of each of `groups`, N: the mean normal force where all measured one, or what their recordings state.
pub(super) fn loads_n(groups: &[&Summary], stated_n: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut factors = factors(groups, stated_n, "speed").into_iter();
    let loads = factors.next().map_or(Vec::new(), |(_, _, loads)| loads);
    loads.into_iter().map(|load| Some(load?.0)).collect()
}

/// The conditions, speed (mm/s) and load (N), in which the means of `groups` differ by more than 15 % although they are compared `by`
/// something else; `stated_n` are the loads that their recordings state. What is not known of all groups is not compared.
///
/// Formula: complete where mean + 2 standard deviations over strokes of the least group lie below mean − 2 of the largest.
///
/// Source: docs/decisions/strokes.md.
#[must_use]
pub fn confounders(groups: &[&Summary], stated_n: &[Option<f64>], by: &str) -> Vec<Confounder> {
    let found = |(what, unit, values): Factor| {
        let known: Vec<(f64, f64)> = values.into_iter().collect::<Option<_>>()?;
        let least = known.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let largest = known.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (largest.0 > (1.0 + SAME_SHARE) * least.0).then_some(Confounder {
            what,
            unit,
            low: least.0,
            high: largest.0,
            complete: least.0 + APART * least.1 < largest.0 - APART * largest.1,
        })
    };
    let factors = factors(groups, stated_n, by).into_iter();
    factors.filter_map(found).collect()
}

/// The warnings that `groups` differ in speed or load beside what is compared, or that this is not known of some.
pub(super) fn warnings(groups: &[&Summary], stated_n: &[Option<f64>], by: &str) -> Vec<Warning> {
    let unknown = factors(groups, stated_n, by).into_iter();
    let unknown = unknown.filter(|(_, _, values)| values.iter().any(Option::is_none));
    let unknown = unknown.map(|(what, ..)| {
        Warning::from(CompareWarning::Mixed {
            how: Mixed::Unknown {
                what: what.into(),
                by: by.into(),
            },
        })
    });
    let differ = confounders(groups, stated_n, by).into_iter();
    differ.map(|c| c.warning(by)).chain(unknown).collect()
}
