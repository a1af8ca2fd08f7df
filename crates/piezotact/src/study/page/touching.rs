//! What changes with the load and with the direction of sliding.

use super::figures::{self, Courses, Sets, Spread};
use super::{DOTS, SETTINGS_SHOWN, names_of};
use crate::compare::Summary;
use crate::figure::Chart;
use crate::page::Block;
use crate::study::{Comparison, Factor, StudyAnalysis, Trend};

/// A number of a group; absent where it was not measured.
type Value = fn(&Summary) -> Option<Spread>;

/// What changes with the load or the direction: level and friction, and what follows.
pub(super) fn blocks(study: &StudyAnalysis, by: Factor) -> Vec<Block> {
    let all = study.across(by);
    if all.is_empty() {
        return Vec::new();
    }
    let values: [(&str, String, Value); 2] = [
        (
            "Rms of the vibration",
            format!("rms, {}", study.unit()),
            Spread::of_rms,
        ),
        (
            "Friction coefficient",
            "friction coefficient".into(),
            Spread::of_friction,
        ),
    ];
    let named = match by {
        Factor::Label => study.by_name(),
        other => other.to_string(),
    };
    let mut blocks = Vec::new();
    for (what, label, value) in values {
        let chart = match by {
            Factor::Load => over_loads(all, label, value),
            _ => over_names(all, &named, label, value),
        };
        let caption = format!("{what} at each {named}: {DOTS}");
        blocks.extend(chart.map(|chart| Block::from(chart.captioned(caption))));
    }
    if study.asked.as_ref().is_none_or(|asked| asked.by != by) {
        let contrasts = study.contrasts(by).iter();
        blocks.extend(contrasts.map(|contrast| Block::text(contrast.conclusion())));
    }
    for comparison in all {
        let trend = study.trend(comparison);
        if !comparison.setting.is_empty() && !trend.is_empty() {
            blocks.push(Block::heading(comparison.setting.as_str()));
        }
        blocks.extend(trend);
    }
    let axes = study.spectral_axes();
    let several = all.iter().filter(|c| !c.setting.is_empty());
    for comparison in several.take(SETTINGS_SHOWN) {
        let chart = figures::psds(&comparison.summaries(), &axes);
        let setting = &comparison.setting;
        let caption = format!("Mean power spectral density at each {named}: {setting}.");
        blocks.push(chart.captioned(caption).into());
    }
    blocks
}

/// A number over the loads; `None` where no group has it.
fn over_loads(all: &[Comparison], label: String, value: Value) -> Option<Chart> {
    let course = |comparison: &Comparison| {
        let Trend::Loads(trend) = &comparison.trend else {
            return (String::new(), Vec::new());
        };
        let points = trend.load_n.iter().zip(comparison.summaries());
        let points = points.filter_map(|(load_n, summary)| Some(((*load_n)?, value(summary)?)));
        (comparison.setting.clone(), points.collect())
    };
    let courses: Courses = all.iter().map(course).collect();
    let known = courses.iter().any(|(_, points)| !points.is_empty());
    known.then(|| figures::over_quantity("normal force, N", label, &courses))
}

/// The same over names.
fn over_names(all: &[Comparison], named: &str, label: String, value: Value) -> Option<Chart> {
    let names = names_of(all);
    let set = |comparison: &Comparison| {
        let summaries = comparison.summaries();
        let named = |name: &String| {
            let group = summaries.iter().find(|s| s.name == *name)?;
            value(group)
        };
        let values = names.iter().map(named).collect();
        (comparison.setting.clone(), values)
    };
    let sets: Sets = all.iter().map(set).collect();
    let mut values = sets.iter().flat_map(|(_, values)| values);
    let known = values.any(Option::is_some);
    known.then(|| figures::by_name(&names, label, named, &sets))
}
