//! Reports on strokes: what was cut, what the strokes hold, and what changes from group to group.

mod apart;
mod figures;

use figures::Sets;
use maud::{Markup, html};
use piezotact::compare::CompareDoubt;
use piezotact::compare::{
    SpatialPeriod, Summary, across_roughness, friction_against_rms, rms_on_speed,
};
use piezotact::criterion::Outcome as Judged;
use piezotact::feature::{Receptor, Statistics, Weighting};
use piezotact::statistics::{Direction, LogFit};
use piezotact::stroke::{Judging, Rule};
use piezotact::surface::SampleSet;

use super::criteria::named_list;
use super::{document, figure};
use crate::advice::text;
use crate::cli::By;
use crate::commands::touch::compare::{
    active_passive as active_passive_lines, one_stroke_each, period, touch,
};
use crate::commands::touch::discrimination::Discrimination;
use crate::commands::touch::{
    Cell, Comparison, Take, both_ways, comparisons, doubts_once, lines_of_all,
};
use crate::failure::Outcome;
use crate::output::digits;
use crate::wording;

/// Recordings whose signals are shown; the others are in the tables.
const SHOWN: usize = 4;

/// What a report on strokes shows.
pub(crate) struct Page<'a> {
    pub(crate) title: String,
    pub(crate) takes: &'a [Take],
    pub(crate) groups: &'a [Cell<'a>],
    pub(crate) sets: &'a [SampleSet],
    pub(crate) ridge_m: Option<f64>,
    /// Which samples can be told apart; none unless they are compared.
    pub(crate) discrimination: Option<&'a Discrimination>,
}

/// The report of `segment`: the signals with their cuts.
pub(crate) fn cuts(takes: &[Take]) -> Outcome<String> {
    let title = "Strokes";
    let body = html! {
        h1 { (title) }
        p.soft { (count(takes.len(), "recording")) }
        (doubts(takes, &[], &[]))
        (signals(takes, takes.len().min(12))?)
        (rejects(takes))
        (methods(takes))
    };
    Ok(document(title, &body))
}

/// The report of `analyse` and `compare`.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let strokes: usize = page.groups.iter().map(|g| g.summary.strokes).sum();
    let (speeds, mut of_speeds) = speeds(page)?;
    let of_pairs = page
        .discrimination
        .map_or_else(Vec::new, Discrimination::doubts);
    of_speeds.extend(of_pairs.iter().map(ToString::to_string));
    let body = html! {
        h1 { (page.title) }
        p.soft {
            (count(page.takes.len(), "recording")) ", " (count(strokes, "stroke")) " in "
            (count(page.groups.len(), "group")) "."
        }
        (doubts(page.takes, page.groups, &of_speeds))
        (groups(page))
        (spectra(page)?)
        @if let Some(discrimination) = page.discrimination { (apart::section(discrimination)) }
        (samples(page)?)
        (speeds)
        (active_passive(page)?)
        (single(page)?)
        (signals(page.takes, SHOWN)?)
        (rejects(page.takes))
        (methods(page.takes))
    };
    Ok(document(&page.title, &body))
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

fn doubts(takes: &[Take], groups: &[Cell<'_>], more: &[String]) -> Markup {
    let all = doubts_once(takes, groups);
    html! {
        section {
            h2 { "Doubts" }
            @if all.is_empty() && more.is_empty() {
                p.soft { "None: nothing had to be guessed or left out." }
            } @else {
                ul.doubts {
                    @for doubt in &all { li { (doubt) } }
                    @for doubt in more { li { (doubt) } }
                }
            }
        }
    }
}

/// Mean ± standard deviation, both with the decimals that give the mean three digits.
fn spread(value: Option<Statistics>, scale: f64, strokes: usize) -> String {
    let Some(s) = value else {
        return "–".into();
    };
    let mean = digits(s.mean * scale);
    if strokes < 2 {
        return mean;
    }
    // The spread shows one digit that counts, where one more decimal is enough for it.
    let usual = mean
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len());
    let needed = (-(s.sd * scale).abs().max(1e-9).log10()).ceil().max(0.0) as usize;
    let decimals = needed.clamp(usual, usual + 1);
    if mean.contains('e') {
        format!("{mean} ± {}", digits(s.sd * scale))
    } else {
        format!(
            "{:.decimals$} ± {:.decimals$}",
            s.mean * scale,
            s.sd * scale
        )
    }
}

fn groups(page: &Page<'_>) -> Markup {
    let all = || page.groups.iter().map(|g| &g.summary);
    let touched = all().any(|s| s.friction_coefficient.is_some() || s.normal_force_n.is_some());
    let moved = all().any(|s| s.speed_m_s.is_some());
    let weighted = all().any(|s| s.pacinian_power.is_some());
    let unit = all().next().map_or(String::new(), |s| s.unit.to_string());
    html! {
        section {
            h2 { "Groups" }
            p.soft { "Mean ± standard deviation over strokes." }
            table {
                tr {
                    th { "group" } th.n { "strokes" } th.n { "rms, " (unit) } th.n { "crest factor" }
                    th.n { "centroid, Hz" } th.n { "strongest line, Hz" }
                    @if weighted { th.n { "Pacinian power" } }
                }
                @for s in all() {
                    tr {
                        td { (s.name) } td.n { (s.strokes) }
                        td.n { (spread(Some(s.rms), 1.0, s.strokes)) }
                        td.n { (spread(Some(s.crest_factor), 1.0, s.strokes)) }
                        td.n { (spread(Some(s.centroid_hz), 1.0, s.strokes)) }
                        td.n { (digits(s.strongest_hz)) }
                        @if weighted { td.n { (spread(s.pacinian_power, 1.0, s.strokes)) } }
                    }
                }
            }
            @if touched || moved {
                table.second {
                    tr {
                        th { "group" }
                        @if touched { th.n { "friction coefficient" } th.n { "normal force, N" } }
                        @if moved { th.n { "speed, mm/s" } th.n { "fingerprint peak, Hz" } th.n { "ridge wavelength, mm" } }
                    }
                    @for s in all() {
                        tr {
                            td { (s.name) }
                            @if touched {
                                td.n { (spread(s.friction_coefficient, 1.0, s.strokes)) }
                                td.n { (spread(s.normal_force_n, 1.0, s.strokes)) }
                            }
                            @if moved {
                                td.n { (spread(s.speed_m_s, 1e3, s.strokes)) }
                                td.n { (s.fingerprint.and_then(|f| f.found_hz).map_or("–".into(), digits)) }
                                td.n { (s.fingerprint.and_then(|f| f.ridge_wavelength_m).map_or("–".into(), |m| digits(m * 1e3))) }
                            }
                        }
                    }
                }
            }
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
            @let lines = lines_of_all(page.takes);
            @if !lines.is_empty() {
                p { "Lines that every sample has:" }
                ul { @for line in &lines { li { (wording::common_line(line)) } } }
            }
        }
    })
}

/// Whether a factor takes more than one value.
fn several<'a>(page: &Page<'a>, by: By) -> Option<Vec<Comparison<'a>>> {
    let all = comparisons(page.takes, by, page.sets, page.ridge_m).ok()?;
    (!all.is_empty()).then_some(all)
}

fn heading(comparison: &Comparison<'_>) -> Markup {
    html! { @if !comparison.setting.is_empty() { h3 { (comparison.setting) } } }
}

fn samples(page: &Page<'_>) -> Outcome<Markup> {
    let Some(all) = several(page, By::Sample) else {
        return Ok(html! {});
    };
    let mut names: Vec<String> = Vec::new();
    for summary in all.iter().flat_map(|c| &c.cells).map(|c| &c.summary) {
        if !names.contains(&summary.name) {
            names.push(summary.name.clone());
        }
    }
    let of = |value: &dyn Fn(&Summary) -> Option<Statistics>| -> Sets {
        let settings = all.iter().map(|comparison| {
            let named = |name: &String| {
                let cell = comparison.cells.iter().find(|c| c.summary.name == *name)?;
                value(&cell.summary).map(|s| (s.mean, s.sd))
            };
            (
                comparison.setting.clone(),
                names.iter().map(named).collect(),
            )
        });
        settings.collect()
    };
    let (rms, friction) = (of(&|s| Some(s.rms)), of(&|s| s.friction_coefficient));
    let unit = page
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let rubs = friction
        .iter()
        .any(|(_, values)| values.iter().any(Option::is_some));
    let mut parts = Vec::new();
    for comparison in &all {
        parts.push(samples_in(page, comparison)?);
    }
    Ok(html! {
        section {
            h2 { "Across samples" }
            (figure(&figures::by_name(&names, format!("rms, {unit}"), "sample", &rms)?, "Rms of the vibration of each sample: mean and standard deviation over strokes."))
            @if rubs { (figure(&figures::by_name(&names, "friction coefficient".into(), "sample", &friction)?, "Friction coefficient of each sample: mean and standard deviation over strokes.")) }
            @for part in &parts { (part) }
        }
    })
}

/// The samples of one setting: their spectra where there are several settings, and what follows their roughness.
fn samples_in(page: &Page<'_>, comparison: &Comparison<'_>) -> Outcome<Markup> {
    let summaries: Vec<&Summary> = comparison.cells.iter().map(|c| &c.summary).collect();
    let trend = across_roughness(&summaries, |name| {
        page.sets.iter().find_map(|set| set.sample(name))?.ra_m
    });
    let band = shown_band(page.takes);
    Ok(html! {
        (heading(comparison))
        @if !comparison.setting.is_empty() { (figure(&figures::psds(&summaries, band)?, "Mean power spectral density of each sample.")) }
        @if trend.samples.len() > 2 {
            (figure(&figures::roughness(&summaries, &trend)?, "Rms of the vibration against the roughness Ra of the samples, with the fitted power law."))
        }
        ul {
            @if let (Some(fit), true) = (&trend.rms_on_ra, trend.samples.len() > 2) {
                li { (wording::power_law("rms", "Ra", fit, "samples")) (format!(", R² {:.2}", fit.r_squared)) }
            }
            @if let Some(found) = &trend.rms_rank_correlation { li { (wording::ranks("rms", "Ra", found, "samples")) } }
            @if let Some(found) = &trend.friction_rank_correlation { li { (wording::ranks("friction coefficient", "Ra", found, "samples")) } }
            @if let Some(found) = &friction_against_rms(&summaries) { li { (wording::ranks("friction coefficient", "rms", found, "samples")) } }
            @if let Some(text) = one_stroke_each(&summaries) { li.doubt { (text) } }
        }
    })
}

/// Whether a period does not stand out.
fn in_doubt(period: &SpatialPeriod) -> bool {
    period.outcome() != Judged::Met
}

/// A setting's slope of rms on speed and its spatial period, each with its interval.
fn speed_row(
    comparison: &Comparison<'_>,
    fit: Option<&LogFit>,
    period: Option<&SpatialPeriod>,
) -> [String; 6] {
    let none = || "–".to_owned();
    let range = |interval: Option<[f64; 2]>, scale: f64, decimals: usize| {
        interval.map_or_else(none, |[low, high]| {
            let [low, high] = [low, high].map(|end| wording::signed(end * scale, decimals));
            format!("{low} to {high}")
        })
    };
    let period = period.filter(|p| !in_doubt(p));
    [
        comparison.setting.clone(),
        fit.map_or_else(none, |fit| wording::signed(fit.slope, 2)),
        range(fit.and_then(|fit| fit.slope_interval), 1.0, 2),
        fit.map_or_else(none, |fit| {
            let word = match fit.direction() {
                Direction::Rises => "rises",
                Direction::Falls => "falls",
                Direction::NotShown => "none shown",
            };
            match fit.p_value {
                Some(p) => format!("{word}, {}", wording::p_text(p)),
                None => "not decided".into(),
            }
        }),
        period.map_or_else(none, |p| format!("{:.3}", p.period_m * 1e3)),
        range(period.and_then(|p| p.interval_m), 1e3, 3),
    ]
}

/// What changes with the speed, and what is in doubt about it.
fn speeds(page: &Page<'_>) -> Outcome<(Markup, Vec<String>)> {
    let mut doubts = Vec::new();
    let Some(all) = several(page, By::Speed) else {
        return Ok((html! {}, doubts));
    };
    let band = shown_band(page.takes);
    let mut parts = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let mut rows: Vec<[String; 6]> = Vec::new();
    let mut aperiodic: Vec<String> = Vec::new();
    let mut sets: Sets = Vec::new();
    for comparison in &all {
        let summaries: Vec<&Summary> = comparison.cells.iter().map(|c| &c.summary).collect();
        let found = period(comparison)?;
        let setting = match comparison.setting.as_str() {
            "" => "across speeds",
            setting => setting,
        };
        for doubt in found.iter().flat_map(|period| &period.doubts) {
            match doubt.kind() {
                Some(CompareDoubt::NoCommonPeriod { .. }) if all.len() > 1 => {
                    aperiodic.push(setting.to_owned())
                }
                _ => doubts.push(format!("{setting}: {}", text(doubt))),
            }
        }
        rows.push(speed_row(
            comparison,
            rms_on_speed(&summaries).as_ref(),
            found.as_ref(),
        ));
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
                // One setting has its spectra above.
                @if !comparison.setting.is_empty() { (figure(&figures::psds(&summaries, band)?, "Mean power spectral density at each speed.")) }
                ul {
                    @if let Some(fit) = rms_on_speed(&summaries) {
                        li { (wording::power_law("rms", "speed", &fit, "speeds")) }
                    }
                    @if let Some(period) = &found {
                        @for doubt in &period.doubts { li.doubt { (text(doubt)) } }
                        li { (wording::spatial_period(period)) (format!(", {:.1} dB above the background in the mean over speeds", period.prominence_db)) }
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
    if !aperiodic.is_empty() {
        doubts.push(format!(
            "{}: no spatial period stands out at every speed: the surface may have none, or the speeds stated are not those that were reached",
            aperiodic.join(", ")
        ));
    }
    let shown = parts.len();
    let section = html! {
        section {
            h2 { "Across speeds" }
            (over_all)
            @if all.len() > 1 {
                table {
                    tr { th { "setting" } th.n { "exponent of rms on speed" } th.n { "95 %" } th { "trend" } th.n { "spatial period, mm" } th.n { "95 %" } }
                    @for row in &rows { tr { td { (row[0]) } @for cell in &row[1..] { td.n { (cell) } } } }
                }
            }
            @if all.len() > shown { p.soft { (format!("Spectra of the first {shown} of {}:", all.len())) } }
            @for part in &parts { (part) }
        }
    };
    Ok((section, doubts))
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
        Ok(figures::psds(&shared, band)?)
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
                        td.n { (pair.level_difference_db.map_or("–".into(), |db| format!("{db:+.1}"))) }
                    }
                }
            }
            p.soft {
                (format!("PSDs over {}, levels over all frequencies.", compared.band_hz))
            }
            ul { @for line in active_passive_lines(&compared) { li { (line) } } }
        }
    })
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
            (figure(&fft, "Amplitude spectrum (FFT) of every stroke (of the first 40 where there are more) over the same length, and the mean of all."))
            (figure(&psd, "Power spectral density of every stroke (of the first 40 where there are more), and the mean of all."))
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
                tr { th { "recording" } th.n { "from, s" } th.n { "to, s" } th { "reason" } th { "judged" } }
                @for take in takes {
                    @for r in &take.segmentation.rejected {
                        tr {
                            td { (take.name) }
                            td.n { (format!("{:.3}", take.recording.rate().duration_of(r.interval.start).0)) }
                            td.n { (format!("{:.3}", take.recording.rate().duration_of(r.interval.end).0)) }
                            td { (r.reason) }
                            td { (named_list(&r.criteria)) }
                        }
                    }
                }
            }
        }
    }
}

/// How it was done, so that it can be written into a paper.
fn methods(takes: &[Take]) -> Markup {
    let features = takes.iter().any(|take| take.analysis.is_some());
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
                    li { "Friction coefficient: √(Fx² + Fy²)/Fz above the forces' zeros in the lifts, sample by sample over each stroke; absent below 10 mN." }
                    li { "Mechanoreceptor bands, after the filter: "
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
            "Strokes by normal force: contact above {:.3} N until below {:.3} N over the drifting zero, smoothed over {:.0} ms; {:.0} ms of landing and {:.0} ms of take-off cut away; {}; {:.1} s and more; mean force within ±{:.0} % of {}.",
            r.on_n.0,
            r.off_n.0,
            r.smoothing_s.0 * 1e3,
            r.landing_s.0 * 1e3,
            r.take_off_s.0 * 1e3,
            match r.judging {
                Judging::Sliding => "only where the finger slides",
                Judging::ContactOnly => "whether the finger slides or not",
            },
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
