//! The report of `panel analyse`: first what a person wants to know in ten seconds, then the figures of a chapter on
//! transfer functions, tables, warnings, and how it was measured.

mod figures;
mod members;
mod tables;

use maud::{Markup, html};
use piezotact::criterion::Outcome as Judged;
use piezotact::document::Words;
use piezotact::number::{plus, signed};
use piezotact::panel::{
    AnalysedPanel, Cell, CellPenalties, CleanedDip, Panel, PanelAnalysis, PanelCurves, PanelKind,
};
use piezotact::quantity::{Uncalibrated, Unit};
use piezotact::recording::BenchKind;
use piezotact::transfer::BundleAverage;

use crate::report::warnings_section;
use crate::{DrawError, bench_text, broad_document, figure, origin};

/// What a report on a panel shows.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    pub analysed: &'a AnalysedPanel<'a>,
    pub panel: &'a Panel<Uncalibrated, Uncalibrated>,
    /// The curves of its figures.
    pub curves: &'a PanelCurves,
    /// Which bench measured it; absent where nothing says it.
    pub bench: Option<&'a str>,
    /// The unit of the drive.
    pub drive_unit: &'a Unit,
    /// The unit of the response.
    pub response_unit: &'a Unit,
}

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let title = match page.analysed.kind {
        Some(PanelKind::Device) => "Transfer functions of the device with several fingers",
        Some(PanelKind::Finger) => "Transfer functions of several fingers",
        _ => "A panel of transfer functions",
    };
    let body = html! {
        h1 { (title) }
        p.soft { (bench_line(page)) }
        (headline(page.analysed.analysis))
        (spread(page)?)
        (load(page)?)
        (angle(page)?)
        (repeats(page)?)
        (average(page)?)
        (artefact(page)?)
        (members::section(page))
        (warnings_section(&page.analysed.analysis.warnings.merged(), words))
        (methods(page))
    };
    Ok(broad_document(title, &body))
}

fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn bench_line(page: &Page<'_>) -> String {
    let said = page.analysed.analysis;
    let kinds: Vec<Option<BenchKind>> = page
        .panel
        .entries()
        .iter()
        .map(|entry| entry.function.about.provenance.bench)
        .collect();
    let first = kinds.first().copied().flatten();
    let bench = bench_text(first)
        .filter(|_| kinds.iter().all(|kind| *kind == first))
        .unwrap_or("The measurements are from different kinds of bench (digital twin, hardware, measured transfer function), or \
            some do not state theirs.");
    let loads: Vec<String> = page.panel.loads_n().iter().map(f64::to_string).collect();
    let angles: Vec<String> = page
        .panel
        .angles_deg()
        .iter()
        .map(|a| format!("{a}°"))
        .collect();
    format!(
        "{bench} {} at {} N and {}: {}, over {}.",
        plural(said.participants.len(), "participant"),
        loads.join(", "),
        angles.join(", "),
        plural(said.measurements, "measurement"),
        said.config.band
    )
}

/// Which average, in words.
fn averaging_word(averaging: BundleAverage) -> &'static str {
    match averaging {
        BundleAverage::Complex => "complex mean",
        BundleAverage::LogMagnitude => "mean of log magnitudes",
    }
}

fn interval(interval: Option<[f64; 2]>) -> String {
    interval.map_or("too few for an interval".into(), |[low, high]| {
        format!("95 %: {low:.1} to {high:.1} dB")
    })
}

fn percent(share: f64) -> String {
    format!("{:.0}\u{a0}%", share * 100.0)
}

fn headline(said: &PanelAnalysis) -> Markup {
    let Some((cell, costs)) = said
        .judged()
        .and_then(|cell| Some((cell, said.penalties_at(cell)?)))
    else {
        return html! {
            section.verdict.unsure {
                strong { "No load and angle was measured with two or more participants: differences between them cannot be \
                    estimated." }
            }
        };
    };
    let class = match costs.verdict.outcome {
        Judged::Met => "verdict",
        Judged::NotMet => "verdict failed",
        Judged::NotDecided => "verdict unsure",
    };
    let number = |value: String, what: String| html! { div { b { (value) } span { (what) } } };
    let spread = said.spreads.iter().find(|s| s.cell.is(cell));
    let (deviation_db, at_hz) = match (&said.worst, spread) {
        (Some(worst), _) => (worst.max_deviation_db, worst.at_hz),
        (None, Some(spread)) => (
            spread.bundle.max_deviation_db,
            spread.bundle.max_deviation_at_hz,
        ),
        (None, None) => (f64::NAN, f64::NAN),
    };
    let curve = said.learning.iter().find(|curve| curve.cell.is(cell));
    html! {
        section class=(class) {
            p.headline { strong { (verdict_line(costs)) } " " (verdict_reason(cell, costs)) }
            p.headline { strong { (worst_line(said, cell)) } " " (how_sure(said)) }
            div.numbers {
                (number(format!("{deviation_db:.1} dB"), format!("maximum deviation between participants at {cell}, \
                    at {at_hz:.0} Hz")))
                @if let Some(spread) = spread {
                    (number(format!("{:.1} dB", spread.spread_rms_db), "standard deviation over participants at this load and \
                        angle, rms over the band".into()))
                }
                (number(format!("{:.1} dB rms", costs.mean_db_rms), format!("error of the average for a new participant ({})", interval(costs.interval_db_rms))))
                (number(format!("{:.1} dB rms", costs.worst.db_rms), format!("largest error, for {}", costs.worst.participant)))
                (number(percent(costs.verdict.share_within), format!("of participants within {} dB rms", costs.verdict.criterion.db_rms)))
                @if let Some(curve) = curve {
                    @if let (Some(found), Some([low, high])) = (curve.enough.found, curve.enough.interval) {
                        (number(format!("{low:.0} to {high:.0}"), format!("participants in the average, beyond which more \
                            reduce the error by less than {} dB (95 %; most likely {found:.0})", curve.within_db)))
                    }
                }
            }
        }
    }
}

fn verdict_line(costs: &CellPenalties) -> &'static str {
    match costs.verdict.outcome {
        Judged::Met => "The average is sufficient.",
        Judged::NotMet => "The average is not sufficient.",
        Judged::NotDecided => "Whether the average is sufficient is not decided.",
    }
}

fn worst_line(said: &PanelAnalysis, cell: Cell) -> String {
    match &said.worst {
        Some(worst) if said.cells.len() > 1 && worst.outcome() == Judged::Met => {
            format!("Participants differ most at {cell}.")
        }
        _ if said.cells.len() > 1 => {
            format!(
                "At which load and angle participants differ most is not decided; the largest measured deviation is \
                at {cell}."
            )
        }
        _ => format!("Participants at {cell}."),
    }
}

/// The criterion, and what is held against it.
fn verdict_reason(cell: Cell, costs: &CellPenalties) -> String {
    let criterion = costs.verdict.criterion;
    let held = match costs.interval_db_rms {
        Some([low, high]) => format!(
            "At {cell} the average of the others has an error of {:.1} dB rms for a new participant (95 %: {low:.1} \
                to {high:.1} dB)",
            costs.mean_db_rms
        ),
        None => format!(
            "At {cell} the average of the others has an error of {:.1} dB rms, with too few participants for an interval",
            costs.mean_db_rms
        ),
    };
    format!(
        "{held}. Criterion: the whole interval within {} dB rms, and at least {} of participants within this limit; {}. {}",
        criterion.db_rms,
        percent(criterion.least_share),
        costs.share_text(),
        costs.needed_text().unwrap_or_default()
    )
}

fn how_sure(said: &PanelAnalysis) -> String {
    let Some(worst) = &said.worst else {
        return "No two participants were measured at every load and angle, so conditions cannot be compared: this one has the \
            largest measured deviation.".into();
    };
    let Some((next, db)) = worst.ranking.get(1) else {
        return "It is the only load and angle.".into();
    };
    let sure = worst.share.map_or(
        "the confidence in this cannot be estimated from so few participants".into(),
        |share| {
            format!(
                "it has the largest deviation in {} of {} random halves of these {} participants",
                percent(share),
                worst.resamples,
                worst.people
            )
        },
    );
    format!(
        "{:.1} dB at {:.0} Hz; next is {next} with {db:.1} dB; {sure}.",
        worst.max_deviation_db, worst.at_hz
    )
}

fn falling(said: &PanelAnalysis) -> Markup {
    html! {
        @for falls in &said.falls {
            p {
                "Maximum deviation at " (falls.angle_deg.0) "°: " (falls.text())
                @if let (Some(every), Some(overall)) = (falls.share, falls.share_overall) {
                    "; over random halves of these participants, it falls at every load step in " (percent(every))
                    ", and from the lightest to the heaviest load in " (percent(overall))
                }
                "."
            }
        }
    }
}

/// A figure with its heading in a grid of figures.
fn titled(title: &str, svg: &str, caption: &str) -> Markup {
    html! { div { h3 { (title) } (figure(svg, caption)) } }
}

fn spread(page: &Page<'_>) -> Result<Markup, DrawError> {
    let said = page.analysed.analysis;
    let mut bundles = Vec::new();
    for spread in &said.spreads {
        bundles.push(titled(
            &spread.cell.to_string(),
            &figures::bundle(page, spread)?,
            &format!(
                "{} and their average; maximum deviation {:.1} dB at {:.0} Hz (marked).",
                plural(spread.bundle.count, "participant"),
                spread.bundle.max_deviation_db,
                spread.bundle.max_deviation_at_hz
            ),
        ));
    }
    let all = format!(
        "All participants at all loads and angles, {} curves; maximum deviation {:.1} dB at {:.0} Hz.",
        said.all.count, said.all.max_deviation_db, said.all.max_deviation_at_hz
    );
    Ok(html! {
        section {
            h2 { "Differences between participants" }
            (falling(said))
            div.counterparts {
                (titled("Maximum deviation by load and angle", &figures::deviations(said)?, "The largest distance between the highest and the lowest curve over the band."))
                (titled("Spread by frequency", &figures::spreads(said)?, "Standard deviation over participants at each spectral \
                    line."))
                @for bundle in &bundles { (bundle) }
                @if said.cells.len() > 1 { (titled("All loads and angles", &figures::all(page)?, &all)) }
            }
            (tables::cells(said))
            (tables::bands(said))
        }
    })
}

fn load(page: &Page<'_>) -> Result<Markup, DrawError> {
    let said = page.analysed.analysis;
    if said.load_steps.is_empty() {
        return Ok(html! {});
    }
    let mut drawn = Vec::new();
    for angle_deg in page.panel.angles_deg() {
        if let Some((who, svg)) = figures::person_by_load(page, angle_deg)? {
            drawn.push(titled(
                &format!("{who} by load, {angle_deg}°"),
                &svg,
                "The first participant who was measured at every load.",
            ));
        }
        drawn.push(titled(
            &format!("Averages by load, {angle_deg}°"),
            &figures::averages_by_load(page, angle_deg)?,
            &format!(
                "The {} over participants.",
                averaging_word(said.config.averaging)
            ),
        ));
    }
    Ok(html! {
        section {
            h2 { "Effect of load" }
            div.counterparts { @for figure in &drawn { (figure) } }
            (tables::loads(said))
        }
    })
}

fn angle(page: &Page<'_>) -> Result<Markup, DrawError> {
    let said = page.analysed.analysis;
    if said.angle_effects.is_empty() {
        return Ok(html! {});
    }
    let mut drawn = Vec::new();
    for load_n in page.panel.loads_n() {
        if let Some((who, svg)) = figures::person_by_angle(page, load_n)? {
            drawn.push(titled(
                &format!("{who} by angle, {load_n} N"),
                &svg,
                "The first participant who was measured at every angle.",
            ));
        }
    }
    Ok(html! {
        section {
            h2 { "Effect of angle" }
            div.counterparts { @for figure in &drawn { (figure) } }
            (tables::angles(said))
        }
    })
}

fn repeats(page: &Page<'_>) -> Result<Markup, DrawError> {
    let said = page.analysed.analysis;
    let found = &said.repeatability;
    let drawn = figures::repeats(page)?;
    let measured = found.lying.is_some() || found.put_back.is_some();
    Ok(html! {
        section {
            h2 { "Repeatability" }
            @if !measured {
                p.soft { "Each participant was measured once at each load and angle: repeatability cannot be estimated." }
            }
            @if let Some((who, svg)) = &drawn {
                div.counterparts {
                    (titled("Repeats of one finger", svg, &format!("{who} Coherence: the share of the response power that the drive \
                        explains linearly.")))
                }
            }
            (tables::repeats(said))
        }
    })
}

fn average(page: &Page<'_>) -> Result<Markup, DrawError> {
    let said = page.analysed.analysis;
    let Some(cell) = said.judged() else {
        return Ok(html! {});
    };
    let Some(found) = said.averages.iter().find(|a| a.cell.is(cell)) else {
        return Ok(html! {});
    };
    let difference = &found.difference;
    let learning = figures::learning(said)?;
    Ok(html! {
        section {
            h2 { "Average over participants" }
            p {
                "At " (cell) " the complex mean differs from the mean of log magnitudes by "
                (format!("{} dB on average over the band; the lowest difference is {} dB, at {:.0} Hz.",
                    plus(difference.mean_db, 2), plus(difference.lowest_db, 2), difference.lowest_at_hz))
                (format!(" Differences of level between participants raise it (by {} dB), differences of phase lower it \
                    (by {} dB): the phases differ by {:.1}° rms over the band, and by {:.1}° where it is lowest.",
                    plus(difference.by_levels_db, 2), signed(difference.by_phases_db, 2), difference.phase_rms_deg, difference.phase_rms_there_deg))
            }
            div.counterparts {
                (titled("Both averages", &figures::averages(page, found)?, &format!("At {cell}.")))
                (titled("Error of the average for each participant", &figures::penalties(found, said)?, "The average of all others compared with the participant's own transfer function, rms over the band. Red: the criterion."))
                @if let Some((svg, caption)) = &learning {
                    (titled("Number of participants needed", svg, caption))
                }
            }
            (tables::averages(said))
        }
    })
}

fn artefact(page: &Page<'_>) -> Result<Markup, DrawError> {
    let Some((cleaning, curves)) = page.analysed.artefact.zip(page.curves.cleaning.as_ref()) else {
        return Ok(html! {});
    };
    let drawn = figures::artefact(page, (cleaning, curves))?;
    let dip = |select: fn(&CleanedDip) -> f64| {
        let values: Vec<f64> = cleaning.dips.iter().map(select).collect();
        let low = values.iter().copied().fold(f64::MAX, f64::min);
        let high = values.iter().copied().fold(f64::MIN, f64::max);
        format!("{low:.1} to {high:.1}")
    };
    Ok(html! {
        section {
            h2 { "Compensation of the dip of the bench" }
            p {
                (format!(
                    "The control measurement has a dip of {:.1} dB at {:.1} Hz. Every measurement was divided by the narrow \
                        structure of the control in {} (magnitude and phase). The level and trend of the control were kept: a \
                        straight line in dB over log frequency, fitted to the values around the dip.",
                    cleaning.artefact.depth_db, cleaning.artefact.at_hz, cleaning.artefact.window_hz
                ))
            }
            div.counterparts {
                (titled("The control", &drawn.0, "The control measurement, without a finger. Shaded: the band in which the dip \
                    is divided out."))
                @if let Some(both) = &drawn.1 {
                    (titled("A finger before and after", both, "The first measurement of the panel."))
                }
            }
            table.second {
                tr { th { "over all measurements" } th.n { "before" } th.n { "after" } }
                tr { td { "lowest line near the dip, Hz" } td.n { (dip(|d| d.before.at_hz)) } td.n { (dip(|d| d.after.at_hz)) } }
                tr { td { "depth below a straight line from 15–25 % below to 15–25 % above it, \
                    dB" } td.n { (dip(|d| d.before.depth_db)) } td.n { (dip(|d| d.after.depth_db)) } }
                tr { td { "largest deviation from this line within 15 %, dB" } td.n { (dip(|d| d.before.largest_db)) } td.n { (dip(|d| d.after.largest_db)) } }
            }
        }
    })
}

fn methods(page: &Page<'_>) -> Markup {
    let said = page.analysed.analysis;
    let config = &said.config;
    let first = page.panel.entries().first().map(|entry| &entry.function);
    let rows = html! {
        @if let Some(bench) = page.bench { (origin::row("bench", &bench)) }
        @if let Some(function) = first {
            @let provenance = &function.about.provenance;
            (origin::traced("first measurement", &provenance.source, &provenance.steps))
            (origin::row("transfer functions", &format!("{}, {} lines every {:.2} Hz, from {} to {}", function.estimator, function.response().len(), function.resolution_hz(), page.drive_unit, page.response_unit)))
            @if let Some(setup) = &function.drive {
                (origin::row("device", &format!("amplifier gain {}, {:.3} V at full scale", setup.gain, setup.volts_per_full_scale)))
            }
        }
        (origin::row("averages", &format!("First over the repeats of a placement, then over placements, then over \
            participants, each with equal weight: {}.", averaging_word(config.averaging))))
        (origin::row("comparisons", &format!("Loads and angles are compared only over the participants measured in \
            both conditions; {} of {} were measured in every condition.", said.complete, said.participants.len())))
        (origin::row("confidence", &format!("A random half of the participants is drawn {} times, seed {}: a maximum deviation depends on two participants only, and a result that holds for such halves may hold for another panel.", config.resamples, config.seed)))
    };
    origin::section("Methods", &rows)
}
