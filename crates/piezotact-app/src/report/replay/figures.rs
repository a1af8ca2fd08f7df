//! The counterparts of the thesis' figures, drawn.

use piezotact::Series;
use piezotact::quantity::{Acceleration, Hertz, Quantity};
use piezotact::spectrum::{Cells, SpectrogramConfig, spectrogram};
use piezotact_bench::replay::{self, Figure, Mark, Shown};
use plotters::style::RGBColor;

use crate::failure::Outcome;
use crate::report::axis::{Axis, Scale};
use crate::report::chart::{self, Chart, Corner, Line, WIDTH, palette};
use crate::report::spectrogram::{COLUMNS, Panel, ROWS, estimate, figure};

const HEIGHT: u32 = 400;
/// One among many.
const SINGLE: RGBColor = RGBColor(172, 180, 188);
/// How far up a spectrogram goes: where textures have their power. Around a fingerprint, where its first lines are.
const HIGHEST: Hertz = Hertz(600.0);
const HIGHEST_AROUND_FINGERPRINT: Hertz = Hertz(300.0);

pub(super) fn draw(drawn: &Figure) -> Outcome<String> {
    match &drawn.shown {
        Shown::Lines { x, y, lines } => chart_of(x, y, lines)?.svg(HEIGHT),
        Shown::Spectrograms(panels) => {
            let highest = match drawn.number {
                "35" => HIGHEST_AROUND_FINGERPRINT,
                _ => HIGHEST,
            };
            spectrograms(panels, highest)
        }
    }
}

fn chart_of(x: &replay::Axis, y: &replay::Axis, lines: &[replay::Line]) -> Outcome<Chart> {
    let all = || lines.iter().flat_map(|line| &line.points);
    let dotted = |line: &replay::Line| matches!(line.mark, Mark::Dots | Mark::Joined);
    let x = match (&x.scale, lines.iter().any(dotted)) {
        (replay::Scale::Names(_), _) | (_, true) => around(x, all().map(|p| p.0)),
        _ => from_end_to_end(x, all().map(|p| p.0)),
    };
    let y = around(y, all().map(|p| p.1));
    let behind = lines.iter().any(|line| line.mark != Mark::Thin);
    let grey = |line: &replay::Line| behind && line.mark == Mark::Thin;
    let mut colours = palette(lines.iter().filter(|line| !grey(line)).count()).into_iter();
    let mut drawn: Vec<(bool, Line)> = lines
        .iter()
        .map(|line| {
            let colour = match grey(line) {
                true => SINGLE,
                false => colours.next().unwrap_or(SINGLE),
            };
            let points = line.points.iter().copied();
            let points = points
                .filter(|(px, py)| on(&x, *px) && on(&y, *py))
                .collect();
            (!grey(line), marked(line, colour, thinned(points, &x)))
        })
        .collect();
    // What is grey lies behind what has a colour.
    drawn.sort_by_key(|(coloured, _)| *coloured);
    let mut chart = Chart::new(x, y, drawn.into_iter().map(|(_, line)| line).collect());
    chart.legend = Corner::Beside;
    Ok(chart)
}

fn marked(line: &replay::Line, colour: RGBColor, points: Vec<(f64, f64)>) -> Line {
    let drawn = Line::new(line.label.as_str(), colour, points);
    match line.mark {
        Mark::Thin => drawn.thin(),
        Mark::Line => drawn,
        Mark::Dashed => drawn.marked(chart::Mark::Dashed),
        Mark::Joined => drawn.marked(chart::Mark::Joined),
        Mark::Dots => drawn.marked(chart::Mark::Dots),
    }
}

/// Whether a value has a place on an axis.
fn on(axis: &Axis, value: f64) -> bool {
    axis.place(value).is_finite()
}

/// An axis with a little room around the values.
fn around(axis: &replay::Axis, values: impl Iterator<Item = f64>) -> Axis {
    let label = axis.label.as_str();
    match &axis.scale {
        replay::Scale::Linear => Axis::around(label, Scale::Linear, values),
        replay::Scale::Logarithmic => Axis::around(label, Scale::Logarithmic, values),
        replay::Scale::Names(names) => Axis::names(label, names.clone()),
    }
}

/// An axis from the lowest value to the highest.
fn from_end_to_end(axis: &replay::Axis, values: impl Iterator<Item = f64> + Clone) -> Axis {
    let roomy = around(axis, values.clone());
    let ends = values.filter(|value| on(&roomy, *value));
    let (low, high) = ends.fold((f64::MAX, f64::MIN), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low < high {
        Axis { low, high, ..roomy }
    } else {
        roomy
    }
}

/// The lowest and the highest of neighbouring points in one column of pixels, in their order: a figure shows no
/// more.
fn thinned(points: Vec<(f64, f64)>, x: &Axis) -> Vec<(f64, f64)> {
    let (low, high) = (x.place(x.low), x.place(x.high));
    let column =
        |point: &(f64, f64)| ((x.place(point.0) - low) / (high - low) * f64::from(WIDTH)).floor();
    points
        .chunk_by(|a, b| column(a) == column(b))
        .flat_map(|together| {
            let places = 0..together.len();
            let by_value = |a: &usize, b: &usize| together[*a].1.total_cmp(&together[*b].1);
            let low = places.clone().min_by(by_value);
            let high = places.max_by(by_value).filter(|high| Some(*high) != low);
            let mut kept: Vec<usize> = low.into_iter().chain(high).collect();
            kept.sort_unstable();
            kept.into_iter().map(|place| together[place])
        })
        .collect()
}

fn spectrograms(panels: &[(String, Series<Acceleration>)], highest: Hertz) -> Outcome<String> {
    let mut estimated = Vec::new();
    for (title, series) in panels {
        let usual = SpectrogramConfig::usual(series.rate());
        let config = SpectrogramConfig {
            // Lines close enough for a comb at the slowest speed.
            segment: 4 * usual.segment,
            cells: Cells::AtMost {
                columns: COLUMNS,
                rows: ROWS,
                highest: Hertz(series.rate().nyquist().0.min(highest.0)),
            },
            ..usual
        };
        estimated.push((title, spectrogram(series, &config)?));
    }
    let note = estimated.first().map(|(_, first)| estimate(first));
    let panels: Vec<Panel<'_, Acceleration>> = estimated
        .iter()
        .map(|(title, spectrogram)| Panel {
            title: (*title).clone(),
            spectrogram,
        })
        .collect();
    figure(
        &panels,
        &Acceleration::UNIT.of_psd(),
        &note.unwrap_or_default(),
    )
}
