//! Reports on strokes: what was cut, what the strokes hold, and what changes from group to group.

mod apart;
mod figures;
mod touching;

use figures::{Courses, Sets, SpectralAxes, Spread};
use maud::{Markup, html};
use piezotact::compare::{SpatialPeriod, Summary};
use piezotact::document::{FailedFile, Words};
use piezotact::feature::{Receptor, STROKE_COLUMNS, Statistics, Weighting};
use piezotact::number::{counted, digits, p_text, plus, signed};
use piezotact::statistics::{Direction, LogFit};
use piezotact::study::{
    self, AnalysedRecording, Comparison, Factor, Group, SampleTrend, SpeedTrend, StudyAnalysis,
    Trend,
};

use crate::criteria::named_list;
use crate::{DrawError, document, figure};

/// Recordings whose signals are shown; the others are in the tables.
const SHOWN: usize = 4;
/// Settings whose spectra are shown; the figure over all of them holds the rest.
const SETTINGS_SHOWN: usize = 3;

/// A report of cuts: the signals with their strokes and rejects.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn cuts(
    takes: &[AnalysedRecording],
    failed: &[FailedFile],
    words: &dyn Words,
) -> Result<String, DrawError> {
    let title = "Strokes";
    let body = html! {
        h1 { (title) }
        p.soft { (counted(takes.len(), "recording")) }
        (warnings(&study::warnings_in_words(takes, &|warning| words.warning(warning))))
        (without_result(failed))
        (signals(takes, takes.len().min(12))?)
        (rejects(takes))
        (methods(takes))
    };
    Ok(document(title, &body))
}

/// A report of a study: its groups, what changes from one to the next, and how it was done. It shows what was computed with
/// [`piezotact::study::Breadth::Report`].
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(study: &StudyAnalysis, words: &dyn Words) -> Result<String, DrawError> {
    let title = match &study.asked {
        Some(asked) => format!("Comparison by {}", asked.by),
        None => format!("Features of the strokes, by {}", study.by),
    };
    let body = html! {
        h1 { (title) }
        p.soft {
            (counted(study.takes.len(), "recording")) ", " (counted(study.strokes(), "stroke")) " in "
            (counted(study.groups.len(), "group")) "."
        }
        (warnings(&study.warnings_of_report(&|warning| words.warning(warning))))
        (without_result(&study.failed))
        (groups(study))
        (spectra(study)?)
        @if let Some(discrimination) = &study.discrimination { (apart::section(discrimination)) }
        (samples(study)?)
        (speeds(study, words)?)
        (touching::section(study, Factor::Load, words)?)
        (touching::section(study, Factor::Direction, words)?)
        (active_passive(study)?)
        (single(study)?)
        (signals(&study.takes, SHOWN)?)
        (rejects(&study.takes))
        (methods(&study.takes))
    };
    Ok(document(&title, &body))
}

fn without_result(failed: &[FailedFile]) -> Markup {
    html! {
        @if !failed.is_empty() {
            section {
                h2 { "Files without a result" }
                ul.warnings { @for file in failed { li { (file.why) } } }
            }
        }
    }
}

fn warnings(sentences: &[String]) -> Markup {
    html! {
        section {
            h2 { "Warnings" }
            @if sentences.is_empty() {
                p.soft { "None: no value was guessed or left out." }
            } @else {
                ul.warnings { @for warning in sentences { li { (warning) } } }
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
    // What was stated for all strokes has no spread.
    if strokes < 2 || s.sd <= 0.0 {
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

fn groups(study: &StudyAnalysis) -> Markup {
    let shown = || {
        STROKE_COLUMNS
            .iter()
            .filter_map(|column| Some((column.name, column.heading?)))
    };
    let all = || study.groups.iter().map(|g| &g.summary);
    let touched = all().any(|s| s.friction_coefficient.is_some() || s.normal_force_n.is_some());
    let moved = all().any(|s| s.speed_m_s.is_some());
    let weighted = all().any(|s| s.pacinian_power.is_some());
    let unit = all().next().map_or(String::new(), |s| s.unit.to_string());
    html! {
        section {
            h2 { "Groups" }
            p.soft { "Mean ± standard deviation over strokes." }
            div.wide tabindex="0" role="region" aria-label="Table" { table.tight {
                tr {
                    th scope="col" { "group" } th.n scope="col" { "strokes" } th.n scope="col" { "rms, " (unit) }
                    @for (_, heading) in shown() { th.n scope="col" { (heading) } }
                    th.n scope="col" { "highest peak, Hz" }
                    @if weighted { th.n scope="col" { "Pacinian power, × threshold power" } }
                }
                @for s in all() {
                    tr {
                        td { (s.name) } td.n { (s.strokes) }
                        td.n { (spread(Some(s.rms), 1.0, s.strokes)) }
                        @for (name, _) in shown() { td.n { (spread(s.features.get(name).copied(), 1.0, s.strokes)) } }
                        td.n { (s.peaks.first().map_or("–".into(), |peak| digits(peak.frequency_hz))) }
                        @if weighted { td.n { (spread(s.pacinian_power, 1.0, s.strokes)) } }
                    }
                }
            } }
            (felt(study))
            @if touched || moved {
                div.wide tabindex="0" role="region" aria-label="Table" { table.second.tight {
                    tr {
                        th scope="col" { "group" }
                        @if touched { th.n scope="col" { "friction coefficient" } th.n scope="col" { "normal force, N" } }
                        @if moved { th.n scope="col" { "speed, mm/s" } th.n scope="col" { "fingerprint peak, Hz" } th.n scope="col" { "ridge wavelength, mm" } }
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
                } }
            }
        }
    }
}

/// By which sense each texture is perceived, and which receptors its vibration excites.
fn felt(study: &StudyAnalysis) -> Markup {
    let known = |group: &Group| group.duplex.is_some() || !group.summary.receptors.is_empty();
    html! {
        @if study.groups.iter().any(known) {
            div.wide tabindex="0" role="region" aria-label="Table" { table.second {
                tr { th scope="col" { "group" } th scope="col" { "texture by the duplex theory" } th scope="col" { "receptors" } }
                @for group in &study.groups {
                    tr {
                        td { (group.summary.name) }
                        td.text { (group.duplex.map_or("–".into(), |duplex| duplex.to_string())) }
                        td.text { @for level in &group.summary.receptors { div { (level.to_string()) } } }
                    }
                }
            } }
            p.soft {
                "Coarse textures (spatial period above 200 µm) are perceived by a spatial sense, fine ones (below 100 µm) by vibration \
                 (Hollins and Risner 2000). Thresholds after Bolanowski et al. (1988) for a large contact; published thresholds differ by \
                 15 to 35 dB. Merkel and Ruffini are not judged."
            }
        }
    }
}

/// The names of the groups of all comparisons, in their order: first those of the one with most.
fn names_of(comparisons: &[Comparison]) -> Vec<String> {
    let mut longest: Vec<&Comparison> = comparisons.iter().collect();
    longest.sort_by_key(|comparison| std::cmp::Reverse(comparison.groups.len()));
    let mut names: Vec<String> = Vec::new();
    for group in longest
        .into_iter()
        .flat_map(|comparison| &comparison.groups)
    {
        if !names.contains(&group.summary.name) {
            names.push(group.summary.name.clone());
        }
    }
    names
}

/// The axes of all figures of spectra: what is compared has one scale.
fn spectral_axes(study: &StudyAnalysis) -> SpectralAxes {
    let band = study
        .band_hz
        .map_or((1.0, 1000.0), |[low, high]| (low, high));
    let all = study.asked.iter().chain(&study.beside);
    let compared = all.flat_map(|across| &across.comparisons);
    let compared = compared.flat_map(|comparison| &comparison.groups);
    let both = study.both_ways.iter();
    let both = both.flat_map(|both| both.active.iter().chain(&both.passive));
    let groups = study.groups.iter().chain(compared).chain(both);
    SpectralAxes::around(
        band,
        &groups.map(|group| &group.summary).collect::<Vec<_>>(),
    )
}

fn spectra(study: &StudyAnalysis) -> Result<Markup, DrawError> {
    let summaries: Vec<&Summary> = study.groups.iter().map(|g| &g.summary).collect();
    if summaries.len() < 2 {
        return Ok(html! {});
    }
    Ok(html! {
        section {
            h2 { "Spectra of the groups" }
            (figure(&figures::psds(&summaries, &spectral_axes(study))?, "Mean power spectral density of each group, over all its strokes."))
            @let lines = &study.common_lines;
            @if !lines.is_empty() {
                p { "Spectral lines found in every sample:" }
                ul { @for line in lines { li { (line.conclusion()) } } }
            }
        }
    })
}

fn heading(comparison: &Comparison) -> Markup {
    html! { @if !comparison.setting.is_empty() { h3 { (comparison.setting) } } }
}

fn samples(study: &StudyAnalysis) -> Result<Markup, DrawError> {
    let all = study.across(Factor::Sample);
    if all.is_empty() {
        return Ok(html! {});
    }
    let names = names_of(all);
    let of = |value: fn(&Summary) -> Option<Spread>| -> Sets {
        let settings = all.iter().map(|comparison| {
            let named = |name: &String| {
                let mut groups = comparison.groups.iter();
                let group = groups.find(|g| g.summary.name == *name)?;
                value(&group.summary)
            };
            (
                comparison.setting.clone(),
                names.iter().map(named).collect(),
            )
        });
        settings.collect()
    };
    let (rms, friction) = (of(Spread::of_rms), of(Spread::of_friction));
    let unit = study
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let rubs = friction
        .iter()
        .any(|(_, values)| values.iter().any(Option::is_some));
    let mut parts = Vec::new();
    for comparison in all {
        if let Trend::Samples(trend) = &comparison.trend {
            parts.push(samples_in(study, comparison, trend)?);
        }
    }
    Ok(html! {
        section {
            h2 { "Across samples" }
            (figure(&figures::by_name(&names, format!("rms, {unit}"), "sample", &rms)?, "Rms of the vibration of each sample: mean and standard deviation over strokes; small dots: the single strokes, where they are five or fewer."))
            @if rubs { (figure(&figures::by_name(&names, "friction coefficient".into(), "sample", &friction)?, "Friction coefficient of each sample: mean and standard deviation over strokes; small dots: the single strokes, where they are five or fewer.")) }
            @for part in &parts { (part) }
        }
    })
}

/// The samples of one setting: their spectra where there are several settings, and what follows their roughness.
fn samples_in(
    study: &StudyAnalysis,
    comparison: &Comparison,
    changes: &SampleTrend,
) -> Result<Markup, DrawError> {
    let summaries = comparison.summaries();
    let trend = &changes.roughness;
    let axes = spectral_axes(study);
    Ok(html! {
        (heading(comparison))
        @if !comparison.setting.is_empty() { (figure(&figures::psds(&summaries, &axes)?, "Mean power spectral density of each sample.")) }
        @if trend.samples.len() > 2 {
            (figure(&figures::in_order(&summaries, trend)?, "Roughness Ra and rms of the vibration of the samples, the roughest first; bars: standard deviation over strokes."))
            (figure(&figures::roughness(&summaries, trend)?, "Rms of the vibration against the roughness Ra of the samples, with the fitted power law where a trend is shown."))
        }
        ul {
            @if let (Some(fit), true) = (&trend.rms_on_ra, trend.samples.len() > 2) {
                li { (fit.conclusion("rms", "Ra", "samples")) (format!(", R² {:.2}", fit.r_squared)) }
            }
            @if let Some(found) = &trend.rms_rank_correlation { li { (found.conclusion("rms", "Ra", "samples")) } }
            @if let Some(found) = &trend.friction_rank_correlation { li { (trend.friction_change.map_or_else(|| found.conclusion("friction", "Ra", "samples"), |change| change.conclusion(found, "Ra"))) } }
            @if let Some(found) = &changes.friction_on_rms { li { (changes.friction_change_on_rms.map_or_else(|| found.conclusion("friction", "rms", "samples"), |change| change.conclusion(found, "rms"))) } }
            @if let Some(text) = changes.one_stroke_each() { li.warning { (text) } }
        }
    })
}

/// A setting's slope of rms on speed and its spatial period, each with its interval.
fn speed_row(comparison: &Comparison, trend: &SpeedTrend) -> [String; 6] {
    let fit: Option<&LogFit> = trend.rms_on_speed.as_ref();
    let period: Option<&SpatialPeriod> = trend.standing_out();
    let none = || "–".to_owned();
    let range = |interval: Option<[f64; 2]>, scale: f64, decimals: usize| {
        interval.map_or_else(none, |[low, high]| {
            let [low, high] = [low, high].map(|end| signed(end * scale, decimals));
            format!("{low} to {high}")
        })
    };
    [
        comparison.setting.clone(),
        fit.map_or_else(none, |fit| signed(fit.slope, 2)),
        range(fit.and_then(|fit| fit.slope_interval), 1.0, 2),
        fit.map_or_else(none, |fit| {
            let word = match fit.direction() {
                Direction::Rises => "rises",
                Direction::Falls => "falls",
                Direction::NotShown => "no trend shown",
            };
            match fit.p_value {
                Some(p) => format!("{word}, {}", p_text(p)),
                None => "not decided".into(),
            }
        }),
        period.map_or_else(none, |p| format!("{:.3}", p.period_m * 1e3)),
        range(period.and_then(|p| p.interval_m), 1e3, 3),
    ]
}

/// What changes with the speed.
fn speeds(study: &StudyAnalysis, words: &dyn Words) -> Result<Markup, DrawError> {
    let all = study.across(Factor::Speed);
    if all.is_empty() {
        return Ok(html! {});
    }
    let axes = spectral_axes(study);
    let peaks_shown = all
        .iter()
        .take(SETTINGS_SHOWN)
        .filter_map(|c| match &c.trend {
            Trend::Speeds(trend) => trend.period.as_ref(),
            _ => None,
        });
    let peak_axes = figures::period_axes(peaks_shown);
    let mut parts = Vec::new();
    let mut rows: Vec<[String; 6]> = Vec::new();
    let mut courses: Courses = Vec::new();
    for comparison in all {
        let Trend::Speeds(trend) = &comparison.trend else {
            continue;
        };
        let summaries = comparison.summaries();
        rows.push(speed_row(comparison, trend));
        let course = summaries.iter().filter_map(|s| {
            let speed = s.speed_m_s?;
            Some((speed.mean * 1e3, Spread::of_rms(s)?))
        });
        courses.push((comparison.setting.clone(), course.collect()));
        if parts.len() < SETTINGS_SHOWN {
            parts.push(html! {
                (heading(comparison))
                // One setting has its spectra above.
                @if !comparison.setting.is_empty() { (figure(&figures::psds(&summaries, &axes)?, "Mean power spectral density at each speed.")) }
                ul {
                    @if let Some(fit) = &trend.rms_on_speed {
                        li { (fit.conclusion("rms", "speed", "speeds")) }
                    }
                    @if let Some(period) = &trend.period {
                        @for warning in &period.warnings { li.warning { (words.warning(warning)) } }
                        li { (period.conclusion()) (format!(", on average over speeds {:.1} dB above the background", period.prominence_db)) }
                    }
                }
                @if let Some(period) = &trend.period {
                    (figure(&figures::period(period, &peak_axes)?, "The peak of each speed, and the line f = v/λ where the period stands out."))
                }
            });
        }
    }
    let unit = study
        .groups
        .first()
        .map_or(String::new(), |g| g.summary.unit.to_string());
    let over_all = figures::over_quantity("speed, mm/s", format!("rms, {unit}"), &courses)?;
    let shown = parts.len();
    Ok(html! {
        section {
            h2 { "Across speeds" }
            (figure(&over_all, "Rms of the vibration at each speed: mean and standard deviation over strokes; small dots: the single strokes, where they are five or fewer."))
            @if all.len() > 1 {
                div.wide tabindex="0" role="region" aria-label="Table" { table.tight {
                    tr { th scope="col" { "setting" } th.n scope="col" { "exponent of rms versus speed" } th.n scope="col" { "95 % interval" } th scope="col" { "trend" } th.n scope="col" { "spatial period, mm" } th.n scope="col" { "95 % interval, mm" } }
                    @for row in &rows { tr { td { (row[0]) } @for cell in &row[1..] { td.n { (cell) } } } }
                } }
            }
            @if all.len() > shown { p.soft { (format!("Spectra of the first {shown} of {}:", all.len())) } }
            @for part in &parts { (part) }
        }
    })
}

fn active_passive(study: &StudyAnalysis) -> Result<Markup, DrawError> {
    let Some(both) = &study.both_ways else {
        return Ok(html! {});
    };
    let compared = &both.found;
    if compared.pairs.is_empty() {
        return Ok(html! {});
    }
    let axes = spectral_axes(study);
    // Where the same samples are compared in one way of touching, their figure stands there.
    let is_shown = |shared: &[&Summary]| {
        let settings = study.across(Factor::Sample).iter();
        let mut settings = settings.filter(|comparison| !comparison.setting.is_empty());
        settings.any(|comparison| {
            let there = comparison.summaries();
            let same = |(a, b): (&&Summary, &&Summary)| a.name == b.name && a.psd == b.psd;
            there.len() == shared.len() && there.iter().zip(shared).all(same)
        })
    };
    let of = |groups: &[Group]| -> Result<Option<String>, DrawError> {
        let shared: Vec<&Summary> = groups
            .iter()
            .map(|group| &group.summary)
            .filter(|s| compared.pairs.iter().any(|pair| pair.sample == s.name))
            .collect();
        let new = !is_shown(&shared);
        new.then(|| figures::psds(&shared, &axes)).transpose()
    };
    let (passive, active) = (of(&both.passive)?, of(&both.active)?);
    Ok(html! {
        section {
            h2 { "Active and passive touch" }
            @if passive.is_none() || active.is_none() { p.soft { "Mean power spectral densities: see “Across samples”." } }
            @if let Some(svg) = &passive { (figure(svg, "Passive touch: mean power spectral density of each sample.")) }
            @if let Some(svg) = &active { (figure(svg, "Active touch: mean power spectral density of each sample.")) }
            div.wide tabindex="0" role="region" aria-label="Table" { table.tight {
                tr { th scope="col" { "sample" } th.n scope="col" { "difference of the PSDs, dB rms" } th.n scope="col" { "active − passive level, dB" } }
                @for pair in &compared.pairs {
                    tr {
                        td { (pair.sample) }
                        td.n { (pair.difference_db_rms.map_or("–".into(), |db| format!("{db:.1}"))) }
                        td.n { (pair.level_difference_db.map_or("–".into(), |db| plus(db, 1))) }
                    }
                }
            } }
            p.soft {
                (format!("PSDs over {}, levels over all frequencies.", compared.band_hz))
            }
            ul { @for line in compared.conclusions() { li { (line) } } }
        }
    })
}

fn single(study: &StudyAnalysis) -> Result<Markup, DrawError> {
    let Some(example) = &study.example else {
        return Ok(html! {});
    };
    let take = &study.takes[example.take];
    let Some(analysis) = &take.analysis else {
        return Ok(html! {});
    };
    let [fft, psd] = figures::strokes_with_mean(analysis)?;
    let unit = analysis.unit.to_string();
    Ok(html! {
        section {
            h2 { "Single strokes and their mean: " (take.name) }
            @if let Some(svg) = &figures::stroke(take, example, &unit)? {
                (figure(svg, "The first stroke, its vibration with the gesture filtered out as described below. Forces are relative \
                    to their zero while the finger is lifted."))
            }
            (figure(&fft, "Amplitude spectrum (FFT) of every stroke (of the first 40 where there are more) over the same length, and the mean of all."))
            (figure(&psd, "Power spectral density of every stroke (of the first 40 where there are more), and the mean of all."))
        }
    })
}

fn signals(takes: &[AnalysedRecording], most: usize) -> Result<Markup, DrawError> {
    let mut parts = Vec::new();
    let shown = &takes[..takes.len().min(most)];
    for (take, svg) in shown.iter().zip(figures::signals(shown)?) {
        parts.push(html! {
            h3 { (take.name) }
            (figure(&svg, "Shaded green: strokes as they are analysed. Shaded red: rejected."))
        });
    }
    Ok(html! {
        section {
            h2 { "Signals and cuts" }
            @if takes.len() > most { p.soft { (format!("The first {most} of {} recordings; piezotact strokes --cuts-only --csv lists the cuts of all.", takes.len())) } }
            @for part in &parts { (part) }
        }
    })
}

fn rejects(takes: &[AnalysedRecording]) -> Markup {
    let rejected: usize = takes.iter().map(|t| t.segmentation.rejected.len()).sum();
    if rejected == 0 {
        return html! {};
    }
    html! {
        section {
            h2 { "Rejected parts" }
            div.wide tabindex="0" role="region" aria-label="Table" { table {
                tr { th scope="col" { "recording" } th.n scope="col" { "from, s" } th.n scope="col" { "to, s" } th scope="col" { "reason" } th scope="col" { "criteria" } }
                @for take in takes {
                    @for r in &take.segmentation.rejected {
                        tr {
                            td { (take.name) }
                            td.n { (format!("{:.3}", take.seconds(r.interval.start))) }
                            td.n { (format!("{:.3}", take.seconds(r.interval.end))) }
                            td { (r.reason) }
                            td { (named_list(&r.criteria)) }
                        }
                    }
                }
            } }
        }
    }
}

/// How it was done, so that it can be written into a paper.
fn methods(takes: &[AnalysedRecording]) -> Markup {
    let features = takes.iter().any(|take| take.analysis.is_some());
    let mut cuts: Vec<String> = Vec::new();
    let mut computed: Vec<String> = Vec::new();
    for take in takes {
        let text = take.segmentation.rule.sentence();
        if !cuts.contains(&text) {
            cuts.push(text);
        }
        if let Some(text) = take.features_text().filter(|text| !computed.contains(text)) {
            computed.push(text);
        }
    }
    let files: Vec<&String> = takes
        .iter()
        .filter_map(|t| t.segmentation.cuts.as_ref())
        .collect();
    html! {
        section {
            h2 { "Methods" }
            ul {
                @for text in cuts.iter().chain(&computed) { li { (text) } }
                @for file in &files { li { "Strokes cut by hand: " (file) } }
                @if features {
                    li { "Friction coefficient: √(Fx² + Fy²)/Fz for every sample of a stroke, with each force relative to its \
                        zero while the finger is lifted; not given below 10 mN." }
                    li { "Mechanoreceptor bands, after the filter: "
                        @for (i, receptor) in Receptor::ALL.iter().enumerate() {
                            @if i > 0 { ", " } (receptor.name())
                            @if let Ok(band) = receptor.band() { " " (band) }
                        } "." }
                    li { "Kurtosis of the filtered vibration: mean of the fourth power over the square of the mean square, 3 for \
                        Gaussian noise. Spread of levels: standard deviation of the levels of parts of 0.1 s, dB." }
                    li { "Pacinian power: " (Weighting::Pacinian.source()) "." }
                }
                li { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
            }
        }
    }
}
