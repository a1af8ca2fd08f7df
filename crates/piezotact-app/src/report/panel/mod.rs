//! The report of `panel analyse`: first what a person wants to know in ten seconds, then the figures of a chapter on
//! transfer functions, tables, doubts, and how it was measured.

mod figures;
mod members;
mod tables;

use maud::{Markup, html};
use piezotact::criterion::Outcome as Judged;
use piezotact::doubt::merged;
use piezotact::panel::{
    Artefact, AverageRule, Cell, CellPenalties, Dip, FallsWithLoad, Filing, LearningCurve, Panel,
    PanelAnalysis,
};
use piezotact::quantity::{Uncalibrated, Unit};
use piezotact::recording::BenchKind;
use piezotact::statistics::Direction;
use piezotact::transfer::{BundleAverage, TransferFunction};
use piezotact_dataset::{PanelFolder, PanelKind};

use super::{broad_document, figure};
use crate::advice::merged_text;
use crate::failure::Outcome;
use piezotact::number::{p_text, signed};

type Function = TransferFunction<Uncalibrated, Uncalibrated>;

/// What a report on a panel shows.
pub(crate) struct Page<'a> {
    pub(crate) said: &'a PanelAnalysis,
    pub(crate) panel: &'a Panel<Uncalibrated, Uncalibrated>,
    pub(crate) folder: &'a PanelFolder,
    pub(crate) drive_unit: &'a Unit,
    pub(crate) response_unit: &'a Unit,
    pub(crate) cleaning: Option<&'a Cleaning>,
}

/// What a control measurement took away.
pub(crate) struct Cleaning {
    pub(crate) control: Function,
    pub(crate) artefact: Artefact,
    /// Every measurement, at the artefact, before and after.
    pub(crate) dips: Vec<(Filing, Dip, Dip)>,
    /// The first measurement of the panel as it was.
    pub(crate) before: Option<Function>,
}

/// The report as HTML text.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let title = match page.folder.index.kind {
        Some(PanelKind::Device) => "The device under many fingers",
        Some(PanelKind::Finger) => "Many fingers",
        _ => "A panel of transfer functions",
    };
    let body = html! {
        h1 { (title) }
        p.soft { (bench_line(page)) }
        (headline(page.said))
        (spread(page)?)
        (load(page)?)
        (angle(page)?)
        (repeats(page)?)
        (average(page)?)
        (artefact(page)?)
        (members::section(page))
        (doubts(page.said))
        (origin(page))
    };
    Ok(broad_document(title, &body))
}

fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn bench_line(page: &Page<'_>) -> String {
    let said = page.said;
    let kinds: Vec<Option<BenchKind>> = page
        .panel
        .entries()
        .iter()
        .map(|entry| entry.function.about.provenance.bench)
        .collect();
    let first = kinds.first().copied().flatten();
    let bench = super::bench_told(first)
        .filter(|_| kinds.iter().all(|kind| *kind == first))
        .unwrap_or("Not every measurement says whether it comes from a twin, from hardware or through a measured transfer function.");
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

/// Whether the average will do, in a word.
pub(crate) fn will_do_word(outcome: Judged) -> &'static str {
    match outcome {
        Judged::Met => "yes",
        Judged::NotMet => "no",
        Judged::NotDecided => "not decided",
    }
}

/// The share of people within the criterion, with its interval and how many would decide.
pub(crate) fn share_text(costs: &CellPenalties) -> String {
    let verdict = &costs.verdict;
    let n = costs.people.len();
    let within = (verdict.share_within * n as f64).round();
    let rule = verdict
        .criteria
        .iter()
        .find(|c| c.what == AverageRule::ShareWithin);
    let interval = match rule.and_then(|rule| rule.interval) {
        Some([low, high]) => format!(
            "95 %: {} to {} of people like them",
            percent(low),
            percent(high)
        ),
        None => "from too few people for an interval".into(),
    };
    format!("{within:.0} of {n} are ({interval})")
}

/// How many people would decide, where it is not decided.
pub(crate) fn needed_text(costs: &CellPenalties) -> Option<String> {
    let verdict = &costs.verdict;
    let driven = |c: &&piezotact::criterion::Criterion<AverageRule>| c.what == AverageRule::Driven;
    let driven = verdict.criteria.iter().find(driven).map(|c| c.outcome);
    match (verdict.outcome, verdict.people_needed) {
        (Judged::NotDecided, _) if driven != Some(Judged::Met) => {
            Some("Not everybody was driven over all of the band.".into())
        }
        (Judged::NotDecided, Some(needed)) => Some(format!(
            "If further people scatter as these {} do, {needed} would decide it.",
            costs.people.len()
        )),
        (Judged::NotDecided, None) => Some(
            "Not even 300 people who scatter as these do would decide it: they lie too close to the criterion.".into(),
        ),
        _ => None,
    }
}

/// How many people are enough, with its interval.
pub(crate) fn enough_text(curve: &LearningCurve) -> String {
    let measured = curve.points.len() + 1;
    let (Some(found), Some([low, high])) = (curve.enough.found, curve.enough.interval) else {
        return format!("how many people are enough is not decided from {measured}");
    };
    let range = format!("{found:.0} people (95 %: {low:.0} to {high:.0})");
    match curve.enough.outcome {
        Judged::Met => format!("{range} are enough, {measured} were measured"),
        Judged::NotMet => format!("{range} are needed, {measured} were measured"),
        Judged::NotDecided => {
            format!("whether {measured} people are enough is not decided: it takes {range}")
        }
    }
}

/// Whether people lie closer together under load.
pub(crate) fn falls_text(falls: &FallsWithLoad) -> String {
    let Some(p) = falls.p_value else {
        return format!(
            "whether it changes with load is not decided from {} people",
            falls.people
        );
    };
    let numbers = format!(
        "{} dB from the lightest to the heaviest load ({} over {} people)",
        signed(falls.change_db, 1),
        p_text(p),
        falls.people
    );
    match falls.direction {
        Direction::Falls => format!("it falls with load: {numbers}"),
        Direction::Rises => format!("it rises with load: {numbers}"),
        Direction::NotShown => format!("no trend with load shown: {numbers}"),
    }
}

/// Which average, in words.
fn averaging_word(averaging: BundleAverage) -> &'static str {
    match averaging {
        BundleAverage::Complex => "complex mean",
        BundleAverage::LogMagnitude => "mean of log magnitudes",
    }
}

fn interval(interval: Option<[f64; 2]>) -> String {
    interval.map_or("no interval from so few".into(), |[low, high]| {
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
                strong { "No load and angle has two people: nothing can be said of how they differ." }
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
                (number(format!("{deviation_db:.1} dB"), format!("largest deviation between people at {cell}, at {at_hz:.0} Hz")))
                @if let Some(spread) = spread {
                    (number(format!("{:.1} dB", spread.spread_rms_db), "standard deviation over people there, rms over the band".into()))
                }
                (number(format!("{:.1} dB rms", costs.mean_db_rms), format!("what the average costs a new person ({})", interval(costs.interval_db_rms))))
                (number(format!("{:.1} dB rms", costs.worst.db_rms), format!("the most, for {}", costs.worst.participant)))
                (number(percent(costs.verdict.share_within), format!("of people within {} dB rms", costs.verdict.criterion.db_rms)))
                @if let Some(curve) = curve {
                    @if let (Some(found), Some([low, high])) = (curve.enough.found, curve.enough.interval) {
                        (number(format!("{low:.0} to {high:.0}"), format!("people in the average for more to gain less than {} dB (95 %; most likely {found:.0})", curve.within_db)))
                    }
                }
            }
        }
    }
}

fn verdict_line(costs: &CellPenalties) -> &'static str {
    match costs.verdict.outcome {
        Judged::Met => "The average will do.",
        Judged::NotMet => "The average will not do.",
        Judged::NotDecided => "Whether the average will do is not decided.",
    }
}

fn worst_line(said: &PanelAnalysis, cell: Cell) -> String {
    match &said.worst {
        Some(worst) if said.cells.len() > 1 && worst.outcome() == Judged::Met => {
            format!("People differ most at {cell}.")
        }
        _ if said.cells.len() > 1 => {
            format!("Where people differ most is not decided; as measured, at {cell}.")
        }
        _ => format!("People at {cell}."),
    }
}

/// The criterion, and what is held against it.
fn verdict_reason(cell: Cell, costs: &CellPenalties) -> String {
    let criterion = costs.verdict.criterion;
    let held = match costs.interval_db_rms {
        Some([low, high]) => format!(
            "At {cell} the average of the others is {:.1} dB rms off for a new person (95 %: {low:.1} to {high:.1} dB)",
            costs.mean_db_rms
        ),
        None => format!(
            "At {cell} the average of the others is {:.1} dB rms off, from too few people for an interval",
            costs.mean_db_rms
        ),
    };
    format!(
        "{held}. Asked for: the interval within {} dB rms, and {} of people within it; {}. {}",
        criterion.db_rms,
        percent(criterion.least_share),
        share_text(costs),
        needed_text(costs).unwrap_or_default()
    )
}

fn how_sure(said: &PanelAnalysis) -> String {
    let Some(worst) = &said.worst else {
        return "No two people were measured at every load and angle, so that conditions cannot be compared: this one is the widest as measured.".into();
    };
    let Some((next, db)) = worst.ranking.get(1) else {
        return "It is the only load and angle.".into();
    };
    let sure = worst.share.map_or(
        "how sure that is stays open with so few people".into(),
        |share| {
            format!(
                "it is the widest in {} of {} draws of half of these {} people",
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
                "Largest deviation at " (falls.angle_deg.0) "°: " (falls_text(falls))
                @if let (Some(every), Some(overall)) = (falls.share, falls.share_overall) {
                    "; of draws of half of these people it falls at every step in " (percent(every))
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

fn spread(page: &Page<'_>) -> Outcome<Markup> {
    let said = page.said;
    let mut bundles = Vec::new();
    for spread in &said.spreads {
        bundles.push(titled(
            &spread.cell.to_string(),
            &figures::bundle(page, spread)?,
            &format!(
                "{} and their average; largest deviation {:.1} dB at {:.0} Hz (marked).",
                plural(spread.bundle.count, "person").replace("persons", "people"),
                spread.bundle.max_deviation_db,
                spread.bundle.max_deviation_at_hz
            ),
        ));
    }
    let all = format!(
        "Every person at every load and angle, {} curves: {:.1} dB at {:.0} Hz.",
        said.all.count, said.all.max_deviation_db, said.all.max_deviation_at_hz
    );
    Ok(html! {
        section {
            h2 { "How far people lie apart" }
            (falling(said))
            div.counterparts {
                (titled("Largest deviation by load and angle", &figures::deviations(said)?, "The largest distance between the highest and the lowest curve over the band."))
                (titled("Spread by frequency", &figures::spreads(said)?, "Standard deviation over people, line by line."))
                @for bundle in &bundles { (bundle) }
                @if said.cells.len() > 1 { (titled("All together", &figures::all(page)?, &all)) }
            }
            (tables::cells(said))
            (tables::bands(said))
        }
    })
}

fn load(page: &Page<'_>) -> Outcome<Markup> {
    let said = page.said;
    if said.load_steps.is_empty() {
        return Ok(html! {});
    }
    let mut drawn = Vec::new();
    for angle_deg in page.panel.angles_deg() {
        if let Some((who, svg)) = figures::person_by_load(page, angle_deg)? {
            drawn.push(titled(
                &format!("{who} by load, {angle_deg}°"),
                &svg,
                "One person, the first who was measured at every load.",
            ));
        }
        drawn.push(titled(
            &format!("Averages by load, {angle_deg}°"),
            &figures::averages_by_load(page, angle_deg)?,
            &format!("The {} over people.", averaging_word(said.config.averaging)),
        ));
    }
    Ok(html! {
        section {
            h2 { "What load does" }
            div.counterparts { @for figure in &drawn { (figure) } }
            (tables::loads(said))
        }
    })
}

fn angle(page: &Page<'_>) -> Outcome<Markup> {
    let said = page.said;
    if said.angle_effects.is_empty() {
        return Ok(html! {});
    }
    let mut drawn = Vec::new();
    for load_n in page.panel.loads_n() {
        if let Some((who, svg)) = figures::person_by_angle(page, load_n)? {
            drawn.push(titled(
                &format!("{who} by angle, {load_n} N"),
                &svg,
                "One person, the first who was measured at every angle.",
            ));
        }
    }
    Ok(html! {
        section {
            h2 { "What the angle does" }
            div.counterparts { @for figure in &drawn { (figure) } }
            (tables::angles(said))
        }
    })
}

fn repeats(page: &Page<'_>) -> Outcome<Markup> {
    let said = page.said;
    let found = &said.repeatability;
    let drawn = figures::repeats(page)?;
    let measured = found.lying.is_some() || found.put_back.is_some();
    Ok(html! {
        section {
            h2 { "How well measurements repeat" }
            @if !measured {
                p.soft { "Everybody was measured once at each load and angle: nothing can be said of repeats." }
            }
            @if let Some((who, functions, coherence)) = &drawn {
                div.counterparts {
                    (titled("Repeats of one finger", functions, who))
                    (titled("Their coherence", coherence, "How much of the response the drive explains."))
                }
            }
            (tables::repeats(said))
        }
    })
}

fn average(page: &Page<'_>) -> Outcome<Markup> {
    let said = page.said;
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
            h2 { "The average over people" }
            p {
                "At " (cell) " the complex mean differs from the mean of log magnitudes by "
                (format!("{:+.2} dB over the band, at the lowest by {:+.2} dB at {:.0} Hz.", difference.mean_db, difference.lowest_db, difference.lowest_at_hz))
                (format!(" Levels that differ between people raise it (by {:+.2} dB), phases that differ lower it (by {:.2} dB): they spread by {:.1}° rms over the band, and by {:.1}° where it is lowest.",
                    difference.by_levels_db, difference.by_phases_db, difference.phase_rms_deg, difference.phase_rms_there_deg))
            }
            div.counterparts {
                (titled("Both averages", &figures::averages(page, found)?, &format!("At {cell}.")))
                (titled("What it costs each person", &figures::penalties(found, said)?, "The average of all others against the person's own, rms over the band. Red: the criterion."))
                @if let Some((svg, caption)) = &learning {
                    (titled("How many people are enough", svg, caption))
                }
            }
            (tables::averages(said))
        }
    })
}

fn artefact(page: &Page<'_>) -> Outcome<Markup> {
    let Some(cleaning) = page.cleaning else {
        return Ok(html! {});
    };
    let drawn = figures::artefact(page, cleaning)?;
    let dip = |select: fn(&(Filing, Dip, Dip)) -> f64| {
        let values: Vec<f64> = cleaning.dips.iter().map(select).collect();
        let low = values.iter().copied().fold(f64::MAX, f64::min);
        let high = values.iter().copied().fold(f64::MIN, f64::max);
        format!("{low:.1} to {high:.1}")
    };
    Ok(html! {
        section {
            h2 { "The bench's own dip, taken out" }
            p {
                (format!(
                    "The control measurement has a dip of {:.1} dB at {:.1} Hz. Every measurement was divided by the control's narrow structure in {} (magnitude and phase); the control's own level and trend, a straight line in dB over the logarithm of frequency through what lies around the dip, were kept.",
                    cleaning.artefact.depth_db, cleaning.artefact.at_hz, cleaning.artefact.window_hz
                ))
            }
            div.counterparts {
                (titled("The control", &drawn.0, "The control measurement, without a finger. Shaded: where the dip is divided out."))
                @if let Some(both) = &drawn.1 {
                    (titled("A finger before and after", both, "The first measurement of the panel."))
                }
            }
            table.second {
                tr { th { "over all measurements" } th.n { "before" } th.n { "after" } }
                tr { td { "lowest line near the dip, Hz" } td.n { (dip(|d| d.1.at_hz)) } td.n { (dip(|d| d.2.at_hz)) } }
                tr { td { "depth below the line between 15–25 % below and above it, dB" } td.n { (dip(|d| d.1.depth_db)) } td.n { (dip(|d| d.2.depth_db)) } }
                tr { td { "largest departure from that line within 15 %, dB" } td.n { (dip(|d| d.1.largest_db)) } td.n { (dip(|d| d.2.largest_db)) } }
            }
        }
    })
}

fn doubts(said: &PanelAnalysis) -> Markup {
    html! {
        section {
            h2 { "Doubts" }
            @if said.doubts.is_empty() {
                p.soft { "None: nothing had to be clamped, guessed or left out." }
            } @else {
                ul.doubts { @for doubt in merged(&said.doubts) { li { (merged_text(&doubt)) } } }
            }
        }
    }
}

fn origin(page: &Page<'_>) -> Markup {
    let said = page.said;
    let config = &said.config;
    let first = page.panel.entries().first().map(|entry| &entry.function);
    html! {
        section {
            h2 { "How it was measured and analysed" }
            table {
                @if let Some(bench) = &page.folder.index.bench { tr { th { "bench" } td { (bench) } } }
                @if let Some(function) = first {
                    tr { th { "first measurement" } td { (function.about.provenance.source) ol { @for step in &function.about.provenance.steps { li { (step) } } } } }
                    tr { th { "transfer functions" } td { (format!("{:?}, {} lines every {:.2} Hz, from {} to {}", function.estimator, function.response().len(), function.resolution_hz(), page.drive_unit, page.response_unit)) } }
                    @if let Some(setup) = &function.drive {
                        tr { th { "device" } td { (format!("amplifier gain {}, {:.3} V at full scale", setup.gain, setup.volts_per_full_scale)) } }
                    }
                }
                tr { th { "averages" } td { "Repeats of a placement, then placements, then people, each counted once: " (averaging_word(config.averaging)) "." } }
                tr { th { "comparisons" } td { (format!("Between loads and between angles only people count who were measured on both sides; {} of {} were measured everywhere.", said.complete, said.participants.len())) } }
                tr { th { "how sure" } td { (format!("Half of the people are drawn {} times, seed {}: a largest distance hangs on two people, and what holds for halves may hold for another panel.", config.resamples, config.seed)) } }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
