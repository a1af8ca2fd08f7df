//! What changes with the load and with the direction of sliding.

use maud::{Markup, html};
use piezotact::compare::Summary;
use piezotact::document::Words;
use piezotact::study::{Comparison, Factor, StudyAnalysis, Trend};

use super::figures::{self, Courses, Sets, Spread};
use super::{SETTINGS_SHOWN, heading, names_of, spectral_axes};
use crate::{DrawError, figure};

/// A number of a group; absent where it was not measured.
type Value = fn(&Summary) -> Option<Spread>;

/// What changes with the load or the direction: level and friction, and what follows.
pub(super) fn section(
    study: &StudyAnalysis,
    by: Factor,
    words: &dyn Words,
) -> Result<Markup, DrawError> {
    let all = study.across(by);
    if all.is_empty() {
        return Ok(html! {});
    }
    let drawn = |label: String, value: Value| match by {
        Factor::Load => over_loads(all, label, value),
        _ => over_names(all, by, label, value),
    };
    let unit = study
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let level = drawn(format!("rms, {unit}"), Spread::of_rms)?;
    let friction = drawn("friction coefficient".into(), Spread::of_friction)?;
    let axes = spectral_axes(study);
    let mut spectra = Vec::new();
    let several = all.iter().filter(|c| !c.setting.is_empty());
    for comparison in several.take(SETTINGS_SHOWN) {
        let svg = figures::psds(&comparison.summaries(), &axes)?;
        spectra.push((&comparison.setting, svg));
    }
    let caption = |what: &str| {
        format!(
            "{what} at each {by}: mean and standard deviation over strokes; small dots: the single strokes, where they are five or fewer."
        )
    };
    Ok(html! {
        section {
            h2 { "Across " (by) "s" }
            @if let Some(svg) = &level { (figure(svg, &caption("Rms of the vibration"))) }
            @if let Some(svg) = &friction { (figure(svg, &caption("Friction coefficient"))) }
            @for contrast in study.contrasts(by) { p { (contrast.conclusion()) "." } }
            @for comparison in all {
                (heading(comparison))
                ul {
                    @for line in comparison.trend_lines() { li { (line) } }
                    @for warning in comparison.own_warnings() { li.warning { (words.warning(warning)) } }
                }
            }
            @for (setting, svg) in &spectra {
                (figure(svg, &format!("Mean power spectral density at each {by}: {setting}.")))
            }
        }
    })
}

/// A number over the loads; `None` where no group has it.
fn over_loads(
    all: &[Comparison],
    label: String,
    value: Value,
) -> Result<Option<String>, DrawError> {
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
    let drawn = || figures::over_quantity("normal force, N", label, &courses);
    known.then(drawn).transpose()
}

/// The same over names.
fn over_names(
    all: &[Comparison],
    by: Factor,
    label: String,
    value: Value,
) -> Result<Option<String>, DrawError> {
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
    let drawn = || figures::by_name(&names, label, by.word(), &sets);
    known.then(drawn).transpose()
}
