//! The figures of a report on a panel, one function for each.

use piezotact::panel::{
    Cell, CellAverage, CellSpread, Cleaning, CleaningCurves, Curve, Filing, PanelAnalysis,
    RepeatCurve,
};
use piezotact::quantity::{Band, Degrees, Newtons, Unit};
use piezotact::transfer::BundleAverage;

use super::Page;
use crate::{Draw, DrawError};
use piezotact::figure::{Axis, Chart, Legend, Line, Mark, Panels, Scale, Tone};

const HEIGHT: u32 = 400;
/// One among many.
const SINGLE: Tone = Tone::Pale;
const MEAN: Tone = Tone::Reference;
const MEASURED: Tone = Tone::Main;
/// The odd one.
const OUTSIDE: Tone = Tone::Accent;
/// Where people lie furthest apart.
const WIDEST: Tone = Tone::Signal;

/// The level of a participant in one cell.
fn person(page: &Page<'_>, who: &str, cell: Cell) -> Option<Vec<(f64, f64)>> {
    page.curves.own_db(who, cell).cloned()
}

fn frequency(band: Band) -> Axis {
    Axis::log("frequency, Hz", band.low().0.max(1.0), band.high().0)
}

fn unit(page: &Page<'_>) -> String {
    let said = |unit: &Unit| match unit {
        Unit::FullScale => "full scale".into(),
        Unit::MetrePerSecondSquared => "(m/s²)".into(),
        other => other.to_string(),
    };
    format!(
        "magnitude, dB re 1 {}/{}",
        said(page.response_unit),
        said(page.drive_unit)
    )
}

fn around(label: impl Into<String>, lines: &[Line]) -> Axis {
    let values = lines
        .iter()
        .flat_map(|line| line.points.iter().map(|p| p.1));
    Axis::around(label, Scale::Linear, values)
}

/// The scale of all magnitudes, as they are compared: around all participants in all conditions, and `lines`.
fn magnitude(page: &Page<'_>, lines: &[Line]) -> Axis {
    let spreads = page.analysed.analysis.spreads.iter();
    let ends = spreads.flat_map(|one| one.bundle.lowest_db.iter().chain(&one.bundle.highest_db));
    let points = lines
        .iter()
        .flat_map(|line| line.points.iter().map(|p| p.1));
    Axis::around(unit(page), Scale::Linear, ends.copied().chain(points))
}

/// Magnitudes over the band that is analysed.
fn magnitudes(page: &Page<'_>, lines: Vec<Line>) -> Result<String, DrawError> {
    let y = magnitude(page, &lines);
    let mut chart = Chart::new(frequency(page.analysed.analysis.config.band), y, lines);
    chart.legend = Legend::Beside;
    chart.svg(HEIGHT)
}

fn over_frequency(
    band: Band,
    label: impl Into<String>,
    lines: Vec<Line>,
) -> Result<String, DrawError> {
    let y = around(label, &lines);
    let mut chart = Chart::new(frequency(band), y, lines);
    chart.legend = Legend::Beside;
    chart.svg(HEIGHT)
}

fn coloured(lines: Vec<(String, Vec<(f64, f64)>)>) -> Vec<Line> {
    let colours = Tone::several(lines.len());
    lines
        .into_iter()
        .zip(colours)
        .enumerate()
        .map(|(i, ((label, points), colour))| {
            let line = Line::new(label, colour, points);
            // Neighbours among many colours look alike: dashes distinguish them.
            if i % 2 == 1 {
                line.marked(Mark::Dashed)
            } else {
                line
            }
        })
        .collect()
}

fn zipped(frequencies_hz: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    frequencies_hz
        .iter()
        .copied()
        .zip(values.iter().copied())
        .collect()
}

/// The counterpart of figures 67 and 76: everybody, and the average.
pub(super) fn bundle(page: &Page<'_>, spread: &CellSpread) -> Result<String, DrawError> {
    let mut lines = Vec::new();
    let mut outside = Vec::new();
    for person_there in &spread.people {
        let who = &person_there.participant;
        let points = person(page, who, spread.cell).unwrap_or_default();
        if person_there.is_odd {
            outside.push(Line::new(who.as_str(), OUTSIDE, points));
        } else {
            lines.push(Line::new("", SINGLE, points).thin());
        }
    }
    if let Some(first) = lines.first_mut() {
        first.label = "each participant".into();
    }
    lines.extend(outside);
    let average = page
        .analysed
        .analysis
        .averages
        .iter()
        .find(|a| a.cell.is(spread.cell));
    if let Some(average) = average {
        let db = average_db(average, page.analysed.analysis.config.averaging);
        lines.push(Line::new(
            "average",
            MEAN,
            zipped(&average.frequencies_hz, db),
        ));
    }
    let at_hz = spread.bundle.max_deviation_at_hz;
    let y = magnitude(page, &lines);
    let mut chart = Chart::new(frequency(page.analysed.analysis.config.band), y, lines);
    let bundle = &spread.bundle;
    let widest = bundle
        .frequencies_hz
        .iter()
        .position(|hz| (hz - at_hz).abs() < 1e-9);
    if let Some(line) = widest {
        let ends = (at_hz, bundle.lowest_db[line], bundle.highest_db[line]);
        chart
            .lines
            .push(Line::new("maximum deviation", WIDEST, Vec::new()).spread(vec![ends]));
    }
    chart.legend = Legend::Beside;
    chart.svg(HEIGHT)
}

fn average_db(average: &CellAverage, averaging: BundleAverage) -> &[f64] {
    match averaging {
        BundleAverage::LogMagnitude => &average.log_magnitude_db,
        BundleAverage::Complex => &average.complex_db,
    }
}

/// The counterpart of figures 68 and 77.
pub(super) fn deviations(said: &PanelAnalysis) -> Result<String, DrawError> {
    let distinct = |values: Vec<f64>| -> Vec<f64> {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        values
    };
    let loads = distinct(said.spreads.iter().map(|s| s.cell.load_n.0).collect());
    let angles = distinct(said.spreads.iter().map(|s| s.cell.angle_deg.0).collect());
    let colours = Tone::several(angles.len());
    let lines: Vec<Line> = angles
        .iter()
        .zip(colours)
        .map(|(angle_deg, colour)| {
            let points = loads
                .iter()
                .enumerate()
                .filter_map(|(i, load_n)| {
                    let cell = Cell {
                        load_n: Newtons(*load_n),
                        angle_deg: Degrees(*angle_deg),
                    };
                    let spread = said.spreads.iter().find(|s| s.cell.is(cell))?;
                    Some((i as f64, spread.bundle.max_deviation_db))
                })
                .collect();
            Line::new(format!("{angle_deg}°"), colour, points).marked(Mark::Joined)
        })
        .collect();
    let highest = lines
        .iter()
        .flat_map(|l| &l.points)
        .map(|p| p.1)
        .fold(0.0, f64::max);
    let names = loads.iter().map(|load| format!("{load} N")).collect();
    // From zero: a step is seen as large as it is.
    let y = Axis::new("maximum deviation, dB", 0.0, (highest * 1.15).max(0.1));
    let mut chart = Chart::new(Axis::names("load", names), y, lines);
    chart.legend = Legend::Beside;
    chart.svg(HEIGHT)
}

pub(super) fn spreads(said: &PanelAnalysis) -> Result<String, DrawError> {
    let lines = said.spreads.iter().map(|spread| {
        let points = zipped(&spread.bundle.frequencies_hz, &spread.bundle.spread_db);
        (spread.cell.to_string(), points)
    });
    over_frequency(
        said.config.band,
        "standard deviation over participants, dB",
        coloured(lines.collect()),
    )
}

pub(super) fn all(page: &Page<'_>) -> Result<String, DrawError> {
    let cells = &page.analysed.analysis.cells;
    let colours = Tone::several(cells.len());
    let mut lines = Vec::new();
    for (cell, colour) in cells.iter().zip(colours) {
        let mut first = true;
        for who in &page.analysed.analysis.participants {
            if let Some(points) = person(page, who, *cell) {
                let label = if first {
                    cell.to_string()
                } else {
                    String::new()
                };
                lines.push(Line::new(label, colour, points).thin());
                first = false;
            }
        }
    }
    magnitudes(page, lines)
}

/// The first person who was measured in all of `cells`, with the curves.
fn example(page: &Page<'_>, cells: &[(String, Cell)]) -> Option<(String, Vec<Line>)> {
    let complete = |who: &&String| {
        let there = |(_, cell): &(String, Cell)| page.curves.own_db(who, *cell).is_some();
        cells.iter().all(there)
    };
    let who = page.analysed.analysis.participants.iter().find(complete)?;
    let lines = cells
        .iter()
        .filter_map(|(name, cell)| Some((name.clone(), person(page, who, *cell)?)));
    Some((who.clone(), coloured(lines.collect())))
}

fn drawn_example(
    page: &Page<'_>,
    cells: &[(String, Cell)],
) -> Result<Option<(String, String)>, DrawError> {
    if cells.len() < 2 {
        return Ok(None);
    }
    let Some((who, lines)) = example(page, cells) else {
        return Ok(None);
    };
    let svg = magnitudes(page, lines)?;
    Ok(Some((who, svg)))
}

/// The counterpart of figures 22, 70a and 74.
pub(super) fn person_by_load(
    page: &Page<'_>,
    angle_deg: f64,
) -> Result<Option<(String, String)>, DrawError> {
    let there = |cell: &&Cell| (cell.angle_deg.0 - angle_deg).abs() < 1e-9;
    let cells = page.analysed.analysis.cells.iter().filter(there);
    let cells: Vec<(String, Cell)> = cells.map(|cell| (cell.load_n.to_string(), *cell)).collect();
    drawn_example(page, &cells)
}

/// The counterpart of figure 75.
pub(super) fn person_by_angle(
    page: &Page<'_>,
    load_n: f64,
) -> Result<Option<(String, String)>, DrawError> {
    let there = |cell: &&Cell| (cell.load_n.0 - load_n).abs() < 1e-9;
    let cells = page.analysed.analysis.cells.iter().filter(there);
    let cells: Vec<(String, Cell)> = cells
        .map(|cell| (format!("{}°", cell.angle_deg.0), *cell))
        .collect();
    drawn_example(page, &cells)
}

/// The counterpart of figure 70b.
pub(super) fn averages_by_load(page: &Page<'_>, angle_deg: f64) -> Result<String, DrawError> {
    let said = page.analysed.analysis;
    let there = |a: &&CellAverage| (a.cell.angle_deg.0 - angle_deg).abs() < 1e-9;
    let lines = said.averages.iter().filter(there).map(|average| {
        let db = average_db(average, said.config.averaging);
        (
            average.cell.load_n.to_string(),
            zipped(&average.frequencies_hz, db),
        )
    });
    magnitudes(page, coloured(lines.collect()))
}

/// The counterpart of figure 78: the participant and cell with most measurements.
pub(super) fn repeats(page: &Page<'_>) -> Result<Option<(String, String)>, DrawError> {
    let Some(repeats) = &page.curves.repeats else {
        return Ok(None);
    };
    let band = page.analysed.analysis.config.band;
    let of = |curve: fn(&RepeatCurve) -> &Curve| {
        let named = repeats.each.iter().map(|one| {
            let Filing {
                placement, repeat, ..
            } = one.filing;
            let name = format!("placement {placement}, repeat {repeat}");
            (name, curve(one).clone())
        });
        coloured(named.collect())
    };
    let functions = of(|one| &one.level_db);
    let level = magnitude(page, &functions);
    let mut lines = of(|one| &one.coherence);
    for line in &mut lines {
        line.label.clear();
    }
    let lowest = lines
        .iter()
        .flat_map(|l| &l.points)
        .map(|p| p.1)
        .fold(1.0, f64::min);
    let low = if lowest > 0.9 { 0.9 } else { 0.0 };
    let panels = Panels::new(vec![
        Chart::new(frequency(band), level, functions).beside(),
        Chart::new(frequency(band), Axis::new("coherence", low, 1.005), lines),
    ]);
    let caption = format!(
        "{} measurements of {} at {}.",
        repeats.each.len(),
        repeats.participant,
        repeats.cell
    );
    Ok(Some((caption, panels.svg(HEIGHT)?)))
}

pub(super) fn averages(page: &Page<'_>, average: &CellAverage) -> Result<String, DrawError> {
    let log = zipped(&average.frequencies_hz, &average.log_magnitude_db);
    let complex = zipped(&average.frequencies_hz, &average.complex_db);
    let lines = vec![
        ("log magnitudes".to_owned(), log),
        ("complex".to_owned(), complex),
    ];
    magnitudes(page, coloured(lines))
}

pub(super) fn penalties(average: &CellAverage, said: &PanelAnalysis) -> Result<String, DrawError> {
    let costs = average.penalties_of(said.config.averaging);
    let points: Vec<(f64, f64)> = costs
        .people
        .iter()
        .enumerate()
        .map(|(i, person)| (i as f64, person.db_rms))
        .collect();
    let criterion_db = said.config.criterion.db_rms;
    let highest = points.iter().map(|p| p.1).fold(criterion_db, f64::max);
    let names = costs.people.iter().map(|p| p.participant.clone()).collect();
    let line = Line::new("", MEASURED, points).marked(Mark::Dots);
    let y = Axis::new("error of the average, dB rms", 0.0, highest * 1.15);
    let mut chart = Chart::new(
        Axis::names("participant left out of the average", names),
        y,
        vec![line],
    );
    chart.levels.push(criterion_db);
    chart.svg(HEIGHT)
}

/// The learning curve of the cell that is judged, and its caption.
pub(super) fn learning(said: &PanelAnalysis) -> Result<Option<(String, String)>, DrawError> {
    let judged = said.judged();
    let found = said
        .learning
        .iter()
        .find(|curve| judged.is_some_and(|cell| cell.is(curve.cell)));
    let Some(curve) = found else {
        return Ok(None);
    };
    let names = curve.points.iter().map(|p| p.people.to_string()).collect();
    let at = |i: usize| i as f64;
    let points = curve
        .points
        .iter()
        .enumerate()
        .map(|(i, p)| (at(i), p.mean_db_rms));
    let spread: Vec<(f64, f64, f64)> = curve
        .points
        .iter()
        .enumerate()
        .filter_map(|(i, p)| p.interval_db_rms.map(|[low, high]| (at(i), low, high)))
        .collect();
    let highest = spread.iter().map(|s| s.2).fold(0.0, f64::max);
    let line = Line::new("", MEASURED, points.collect())
        .marked(Mark::Joined)
        .spread(spread);
    let y = Axis::new(
        "error for a new participant, dB rms",
        0.0,
        (highest * 1.1).max(0.1),
    );
    let chart = Chart::new(
        Axis::names("participants in the average", names),
        y,
        vec![line],
    );
    let how = match curve.orders {
        0 => "over all subsets of the others".to_owned(),
        orders => format!("over {orders} random orders of the others for each participant"),
    };
    let caption = format!(
        "At {}, {how}; bars: 95 % over the participants left out. Number beyond which more participants reduce the error by \
            less than {} dB: {}.",
        curve.cell,
        curve.within_db,
        curve.enough_text()
    );
    Ok(Some((chart.svg(HEIGHT)?, caption)))
}

/// The counterpart of figure 71: the control, and a finger before and after.
pub(super) fn artefact(
    page: &Page<'_>,
    (cleaning, curves): (&Cleaning, &CleaningCurves),
) -> Result<(String, Option<String>), DrawError> {
    let band = page.analysed.analysis.config.band;
    let control = Line::new("", MEASURED, curves.control_db.clone());
    let y = around(
        "magnitude of the control, dB",
        std::slice::from_ref(&control),
    );
    let mut chart = Chart::new(frequency(band), y, vec![control]);
    let window = cleaning.artefact.window_hz;
    chart.shaded.push((window.low().0, window.high().0));
    let both = match &curves.example_db {
        Some([before, after]) => Some(magnitudes(
            page,
            vec![
                Line::new("before", SINGLE, before.clone()).thick(),
                Line::new("after", MEASURED, after.clone()),
            ],
        )?),
        None => None,
    };
    Ok((chart.svg(HEIGHT)?, both))
}
