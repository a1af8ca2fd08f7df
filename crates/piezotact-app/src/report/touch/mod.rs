//! Reports on strokes: what was cut, what the strokes hold, and what changes from group to group.

mod figures;

use maud::{Markup, html};
use piezotact::Doubt;
use piezotact::compare::{
    Discrimination, Summary, across_roughness, friction_against_rms, indistinguishable,
    rms_on_speed,
};
use piezotact::feature::{Receptor, Weighting};
use piezotact::stroke::Rule;
use piezotact::surface::SampleSet;

use super::{document, figure};
use crate::cli::By;
use crate::commands::touch::compare::{period, textures, touch};
use crate::commands::touch::{Cell, Comparison, Take, both_ways, comparisons};
use crate::failure::Outcome;
use crate::output::digits;

/// Recordings whose signals are shown; the others are in the tables.
const SHOWN: usize = 4;

/// What a report on strokes shows.
pub(crate) struct Page<'a> {
    pub(crate) title: &'a str,
    pub(crate) takes: &'a [Take],
    pub(crate) groups: &'a [Cell<'a>],
    pub(crate) sets: &'a [SampleSet],
    pub(crate) ridge_m: Option<f64>,
    /// How far apart samples must be; none unless they are compared.
    pub(crate) discrimination: Option<Discrimination>,
}

/// The report of `segment`: the signals with their cuts.
pub(crate) fn cuts(takes: &[Take]) -> Outcome<String> {
    let title = "Strokes";
    let body = html! {
        h1 { (title) }
        p.soft { (count(takes.len(), "recording")) }
        (doubts(takes, &[]))
        (signals(takes, takes.len().min(12))?)
        (rejects(takes))
        (methods(takes, false))
    };
    Ok(document(title, &body))
}

/// The report of `analyse` and `compare`.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let strokes: usize = page.groups.iter().map(|g| g.summary.strokes).sum();
    let body = html! {
        h1 { (page.title) }
        p.soft {
            (count(page.takes.len(), "recording")) ", " (count(strokes, "stroke")) " in "
            (count(page.groups.len(), "group")) "."
        }
        (doubts(page.takes, page.groups))
        (groups(page))
        (spectra(page)?)
        (samples(page)?)
        (speeds(page)?)
        (active_passive(page)?)
        (told_apart(page))
        (single(page)?)
        (signals(page.takes, SHOWN)?)
        (rejects(page.takes))
        (methods(page.takes, true))
    };
    Ok(document(page.title, &body))
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// Every doubt once, with the recordings and groups that it is about.
fn doubts(takes: &[Take], groups: &[Cell<'_>]) -> Markup {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    let mut add = |doubt: &Doubt, whose: Option<&'_ str>| {
        let text = doubt.to_string();
        match all.iter_mut().find(|(other, _)| *other == text) {
            Some((_, names)) => names.extend(whose.map(|_| "")),
            None => all.push((text, vec![""; usize::from(whose.is_some())])),
        }
    };
    for take in takes {
        for doubt in take.doubts() {
            add(&doubt, Some(&take.name));
        }
    }
    for group in groups {
        for doubt in &group.summary.doubts {
            add(doubt, None);
        }
    }
    let first = |text: &str| {
        takes
            .iter()
            .find(|take| take.doubts().iter().any(|doubt| doubt.to_string() == text))
            .map(|take| take.name.clone())
    };
    html! {
        section {
            h2 { "Doubts" }
            @if all.is_empty() {
                p.soft { "None: nothing had to be guessed or left out." }
            } @else {
                ul.doubts {
                    @for (text, names) in &all {
                        li {
                            @match (first(text), names.len()) {
                                (Some(name), 1) => { b { (name) ": " } }
                                (Some(name), more) => { b { (name) " and " (count(more - 1, "other")) ": " } }
                                (None, _) => {}
                            }
                            (text)
                        }
                    }
                }
            }
        }
    }
}

fn groups(page: &Page<'_>) -> Markup {
    let has_friction = page
        .groups
        .iter()
        .any(|g| g.summary.friction_coefficient.is_some());
    let has_speed = page.groups.iter().any(|g| g.summary.speed_m_s.is_some());
    let weighted = page
        .groups
        .iter()
        .any(|g| g.summary.pacinian_power.is_some());
    let unit = page
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let some = |value: Option<piezotact::feature::Statistics>, scale: f64| {
        value.map_or("–".into(), |s| {
            format!("{} ± {}", digits(s.mean * scale), digits(s.sd * scale))
        })
    };
    html! {
        section {
            h2 { "Groups" }
            p.soft { "Mean ± standard deviation over strokes." }
            div.wide { table {
                tr {
                    th { "group" } th.n { "strokes" } th.n { "rms, " (unit) } th.n { "crest factor" }
                    @if has_friction { th.n { "friction coefficient" } th.n { "normal force, N" } }
                    @if has_speed { th.n { "speed, mm/s" } th.n { "fingerprint, Hz" } }
                    th.n { "centroid, Hz" } th.n { "strongest line, Hz" }
                    @if weighted { th.n { "Pacinian power" } }
                }
                @for Cell { summary: s, .. } in page.groups {
                    tr {
                        td { (s.name) } td.n { (s.strokes) }
                        td.n { (some(Some(s.rms), 1.0)) } td.n { (digits(s.crest_factor.mean)) }
                        @if has_friction { td.n { (some(s.friction_coefficient, 1.0)) } td.n { (some(s.normal_force_n, 1.0)) } }
                        @if has_speed {
                            td.n { (some(s.speed_m_s, 1e3)) }
                            td.n { (s.fingerprint.and_then(|f| f.found_hz).map_or("–".into(), digits)) }
                        }
                        td.n { (digits(s.centroid_hz.mean)) } td.n { (digits(s.strongest_hz)) }
                        @if weighted { td.n { (some(s.pacinian_power, 1.0)) } }
                    }
                }
            } }
        }
    }
}

/// The band that figures of spectra show, Hz.
fn shown_band(takes: &[Take]) -> (f64, f64) {
    takes
        .iter()
        .filter_map(|take| take.analysis.as_ref())
        .map(|a| {
            let lowest = a.config.band.low().0.max(a.psd.resolution_hz);
            (lowest, a.config.band.high().0)
        })
        .fold((f64::MAX, f64::MIN), |(low, high), (a, b)| {
            (low.min(a), high.max(b))
        })
}

fn spectra(page: &Page<'_>) -> Outcome<Markup> {
    let summaries: Vec<&Summary> = page.groups.iter().map(|g| &g.summary).collect();
    if summaries.len() < 2 {
        return Ok(html! {});
    }
    let band = shown_band(page.takes);
    Ok(html! {
        section {
            h2 { "Spectra of the groups" }
            (figure(&figures::psds(&summaries, band)?, "Mean power spectral density of each group, over all its strokes."))
        }
    })
}

/// Whether a factor takes more than one value.
fn several<'a>(page: &Page<'a>, by: By) -> Option<Vec<Comparison<'a>>> {
    let all = comparisons(page.takes, by, page.sets, page.ridge_m).ok()?;
    let many = all.iter().any(|comparison| comparison.cells.len() > 1);
    many.then_some(all)
}

fn heading(comparison: &Comparison<'_>) -> Markup {
    html! { @if !comparison.setting.is_empty() { h3 { (comparison.setting) } } }
}

fn samples(page: &Page<'_>) -> Outcome<Markup> {
    let Some(all) = several(page, By::Sample) else {
        return Ok(html! {});
    };
    let band = shown_band(page.takes);
    let mut parts = Vec::new();
    for comparison in all.iter().filter(|c| c.cells.len() > 1) {
        let summaries: Vec<&Summary> = comparison.cells.iter().map(|c| &c.summary).collect();
        let trend = across_roughness(&summaries, |name| {
            page.sets.iter().find_map(|set| set.sample(name))?.ra_m
        });
        let names: Vec<String> = summaries.iter().map(|s| s.name.clone()).collect();
        let rms = summaries
            .iter()
            .map(|s| Some((s.rms.mean, s.rms.sd)))
            .collect();
        let friction: Vec<_> = summaries
            .iter()
            .map(|s| s.friction_coefficient.map(|f| (f.mean, f.sd)))
            .collect();
        let unit = summaries
            .first()
            .map_or(String::new(), |s| s.unit.to_string());
        parts.push(html! {
            (heading(comparison))
            @if all.len() > 1 { (figure(&figures::psds(&summaries, band)?, "Mean power spectral density of each sample.")) }
            (figure(&figures::by_name(&names, format!("rms, {unit}"), "sample", &[(String::new(), rms)])?, "Rms of the vibration of each sample: mean and standard deviation over strokes."))
            @if friction.iter().any(Option::is_some) {
                (figure(&figures::by_name(&names, "friction coefficient".into(), "sample", &[(String::new(), friction)])?, "Friction coefficient of each sample: mean and standard deviation over strokes."))
            }
            @if trend.samples.len() > 1 {
                (figure(&figures::roughness(&summaries, &trend)?, "Rms of the vibration against the roughness Ra of the samples, with the fitted power law."))
            }
            ul {
                @if let Some(fit) = &trend.rms_on_ra {
                    li { (format!("log rms on log Ra: slope {:.2}", fit.slope))
                        @if let Some([low, high]) = fit.slope_interval { (format!(" (95 %: {low:.2} to {high:.2})")) }
                        (format!(", R² {:.2}", fit.r_squared)) }
                }
                @if let Some(rho) = trend.rms_rank_correlation { li { (format!("Spearman's rank correlation of Ra and rms: {rho:.2}")) } }
                @if let Some(rho) = trend.friction_rank_correlation { li { (format!("Spearman's rank correlation of Ra and friction coefficient: {rho:.2}")) } }
                @if let Some(rho) = friction_against_rms(&summaries) { li { (format!("Spearman's rank correlation of friction coefficient and rms: {rho:.2}")) } }
            }
        });
    }
    Ok(html! { section { h2 { "Across samples" } @for part in &parts { (part) } } })
}

fn speeds(page: &Page<'_>) -> Outcome<Markup> {
    let Some(all) = several(page, By::Speed) else {
        return Ok(html! {});
    };
    let band = shown_band(page.takes);
    let mut parts = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let mut sets: Vec<(String, Vec<Option<(f64, f64)>>)> = Vec::new();
    for comparison in all.iter().filter(|c| c.cells.len() > 1) {
        let summaries: Vec<&Summary> = comparison.cells.iter().map(|c| &c.summary).collect();
        let found = period(comparison)?;
        names.push(comparison.setting.clone());
        for summary in &summaries {
            let value = Some((summary.rms.mean, summary.rms.sd));
            let at = names.len() - 1;
            let place = sets.iter().position(|(name, _)| *name == summary.name);
            let values = match place {
                Some(place) => &mut sets[place].1,
                None => {
                    sets.push((summary.name.clone(), Vec::new()));
                    let last = sets.len() - 1;
                    &mut sets[last].1
                }
            };
            values.resize(at, None);
            values.push(value);
        }
        // Three settings show what there is to see; the figure over all of them holds the rest.
        if parts.len() < 3 {
            parts.push(html! {
                (heading(comparison))
                (figure(&figures::psds(&summaries, band)?, "Mean power spectral density at each speed."))
                ul {
                    @if let Some(fit) = rms_on_speed(&summaries) {
                        li { (format!("log rms on log speed: slope {:.2}", fit.slope))
                            @if let Some([low, high]) = fit.slope_interval { (format!(" (95 %: {low:.2} to {high:.2})")) } }
                    }
                    @if let Some(period) = &found {
                        li { (format!("spatial period on which the speeds agree: {:.3} mm", period.period_m * 1e3))
                            @if let Some([low, high]) = period.interval_m { (format!(" (95 %: {:.3} to {:.3} mm)", low * 1e3, high * 1e3)) }
                            (format!(", {:.1} dB above the background", period.prominence_db)) }
                    }
                }
                @if let Some(period) = &found {
                    (figure(&figures::period(period)?, "The peak of each speed, and the line f = v/λ."))
                }
            });
        }
    }
    let unit = page
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let over_all = if names.len() > 1 {
        let svg = figures::by_name(&names, format!("rms, {unit}"), "", &sets)?;
        figure(
            &svg,
            "Rms of the vibration at each speed: mean and standard deviation over strokes.",
        )
    } else {
        html! {}
    };
    Ok(html! { section { h2 { "Across speeds" } (over_all) @for part in &parts { (part) } } })
}

fn active_passive(page: &Page<'_>) -> Outcome<Markup> {
    let both = both_ways(page.takes, page.sets)?;
    let compared = touch(page.takes, page.sets)?;
    if compared.pairs.is_empty() {
        return Ok(html! {});
    }
    let band = shown_band(page.takes);
    let of = |cells: &[Cell<'_>]| -> Outcome<String> {
        let shared: Vec<&Summary> = cells
            .iter()
            .map(|cell| &cell.summary)
            .filter(|s| compared.pairs.iter().any(|pair| pair.sample == s.name))
            .collect();
        figures::psds(&shared, band)
    };
    Ok(html! {
        section {
            h2 { "Active and passive touch" }
            (figure(&of(&both.passive)?, "Passive touch: mean power spectral density of each sample."))
            (figure(&of(&both.active)?, "Active touch: mean power spectral density of each sample."))
            table {
                tr { th { "sample" } th.n { "difference of the PSDs, dB rms" } th.n { "active − passive level, dB" } }
                @for pair in &compared.pairs {
                    tr {
                        td { (pair.sample) }
                        td.n { (pair.difference_db_rms.map_or("–".into(), |db| format!("{db:.1}"))) }
                        td.n { (format!("{:+.1}", pair.level_difference_db)) }
                    }
                }
            }
            p.soft {
                (format!("Over {}.", compared.band_hz))
                @if let Some(rho) = compared.rms_rank_correlation { (format!(" Spearman's rank correlation of the two rms: {rho:.2}.")) }
            }
        }
    })
}

fn told_apart(page: &Page<'_>) -> Markup {
    let Some(discrimination) = page.discrimination else {
        return html! {};
    };
    let summaries: Vec<&Summary> = page.groups.iter().map(|g| &g.summary).collect();
    if summaries.len() < 2 {
        return html! {};
    }
    let found = indistinguishable(&textures(&summaries), discrimination);
    html! {
        section {
            h2 { "What can be told apart by vibration" }
            p { (format!(
                "Distances in just-noticeable differences: level ({} dB each) and shape (octave bands, {} dB each) together; groups within {} JND cannot be told apart.",
                discrimination.level_jnd_db, discrimination.band_jnd_db, discrimination.threshold_jnd
            )) }
            @if found.confusable().is_empty() {
                p { "All can be told apart." }
            } @else {
                ul { @for group in found.confusable() { li { (group.join(", ")) } } }
            }
            div.wide { table.matrix {
                tr { th { "JND" } @for name in &found.names { th.n { (name) } } }
                @for (name, row) in found.names.iter().zip(&found.distance_jnd) {
                    tr {
                        th { (name) }
                        @for distance in row {
                            td.n.near[*distance <= discrimination.threshold_jnd] { (format!("{distance:.1}")) }
                        }
                    }
                }
            } }
        }
    }
}

fn single(page: &Page<'_>) -> Outcome<Markup> {
    let Some(take) = page.takes.iter().find(|take| take.analysis.is_some()) else {
        return Ok(html! {});
    };
    let Some(analysis) = &take.analysis else {
        return Ok(html! {});
    };
    let vibrations = piezotact::feature::vibrations(
        &take.recording,
        &take.segmentation,
        analysis.config.high_pass,
    )?;
    let [fft, psd] = figures::strokes_with_mean(analysis)?;
    let unit = analysis.unit.to_string();
    Ok(html! {
        section {
            h2 { "Single strokes and their mean: " (take.name) }
            @if let [only] = vibrations.channels.as_slice() {
                (figure(&figures::stroke(take, only, &unit)?, "The first stroke, freed of the gesture as stated below."))
            }
            (figure(&fft, "Amplitude spectrum (FFT) of every stroke over the same length, and their mean."))
            (figure(&psd, "Power spectral density of every stroke, and their mean."))
        }
    })
}

fn signals(takes: &[Take], most: usize) -> Outcome<Markup> {
    let mut parts = Vec::new();
    for take in takes.iter().take(most) {
        let charts = figures::signals(take)?;
        let last = charts.len().saturating_sub(1);
        parts.push(html! {
            h3 { (take.name) }
            @for (i, svg) in charts.iter().enumerate() {
                @if i == last {
                    (figure(svg, "Shaded green: strokes as they are analysed. Shaded red: rejected."))
                } @else { (figure(svg, "")) }
            }
        });
    }
    Ok(html! {
        section {
            h2 { "Signals and cuts" }
            @if takes.len() > most { p.soft { (format!("The first {most} of {} recordings; all cuts are in the table of `piezotact segment --csv`.", takes.len())) } }
            @for part in &parts { (part) }
        }
    })
}

fn rejects(takes: &[Take]) -> Markup {
    let rejected: usize = takes.iter().map(|t| t.segmentation.rejected.len()).sum();
    if rejected == 0 {
        return html! {};
    }
    html! {
        section {
            h2 { "What was rejected" }
            table {
                tr { th { "recording" } th.n { "from, s" } th.n { "to, s" } th { "reason" } }
                @for take in takes {
                    @for r in &take.segmentation.rejected {
                        tr {
                            td { (take.name) }
                            td.n { (format!("{:.3}", take.recording.rate().duration_of(r.interval.start).0)) }
                            td.n { (format!("{:.3}", take.recording.rate().duration_of(r.interval.end).0)) }
                            td { (r.reason) }
                        }
                    }
                }
            }
        }
    }
}

/// How it was done, so that it can be written into a paper.
fn methods(takes: &[Take], features: bool) -> Markup {
    let mut cuts: Vec<String> = Vec::new();
    let mut computed: Vec<String> = Vec::new();
    for take in takes {
        let text = rule_text(&take.segmentation.rule);
        if !cuts.contains(&text) {
            cuts.push(text);
        }
        if let Some(a) = &take.analysis {
            let gesture = a
                .config
                .high_pass
                .map_or("no filter".into(), |h| h.to_string());
            let text = format!(
                "{gesture}; PSDs by Welch's method: {} window, {} samples ({:.2} Hz) with {:.0} % overlap, one-sided; band for peaks and centroid {}.",
                a.config.welch.window.name(),
                a.config.welch.segment,
                a.psd.resolution_hz,
                a.config.welch.overlap * 100.0,
                a.config.band
            );
            if !computed.contains(&text) {
                computed.push(text);
            }
        }
    }
    let files: Vec<&String> = takes
        .iter()
        .filter_map(|t| t.segmentation.cuts.as_ref())
        .collect();
    html! {
        section {
            h2 { "How it was done" }
            ul {
                @for text in cuts.iter().chain(&computed) { li { (text) } }
                @for file in &files { li { "Cuts by a person: " (file) } }
                @if features {
                    li { "Friction coefficient: √(Fx² + Fy²)/Fz above the forces' zeros in the lifts, sample by sample over each stroke." }
                    li { "Mechanoreceptor bands: "
                        @for (i, receptor) in Receptor::ALL.iter().enumerate() {
                            @if i > 0 { ", " } (receptor.name())
                            @if let Ok(band) = receptor.band() { " " (band) }
                        } "." }
                    li { "Pacinian power: " (Weighting::Pacinian.source()) "." }
                }
                li { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
            }
        }
    }
}

fn rule_text(rule: &Rule) -> String {
    match rule {
        Rule::Force(r) => format!(
            "Strokes by normal force: contact above {:.3} N until below {:.3} N over the drifting zero, smoothed over {:.0} ms; {:.0} ms of landing and {:.0} ms of take-off cut away; only where the finger slides; {:.1} s and more; mean force within ±{:.0} % of {}.",
            r.on_n.0,
            r.off_n.0,
            r.smoothing_s.0 * 1e3,
            r.landing_s.0 * 1e3,
            r.take_off_s.0 * 1e3,
            r.shortest_s.0,
            r.tolerance_share * 100.0,
            r.load_n
                .map_or("the strokes' median".into(), |load| load.to_string())
        ),
        Rule::Speed(r) => format!(
            "Strokes by the plateau of the speed: within ±{:.0} %, {:.1} s and more, while the normal force is above {:.3} N.",
            r.tolerance_share * 100.0,
            r.shortest_s.0,
            r.touch_n.0
        ),
        Rule::Whole => "The whole recording is one stroke.".into(),
    }
}
