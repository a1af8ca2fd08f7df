//! The counterparts of the thesis' figures, drawn.

use piezotact::Series;
use piezotact::figure::{
    Axis, Chart, Corner, Drawn, Line, Mark as PointMark, Scale, Spectrograms, Tone,
};
use piezotact::number::digits;
use piezotact::quantity::{Acceleration, Hertz, Quantity};
use piezotact::spectrum::{Cells, EstimateError, SpectrogramConfig, spectrogram};

use crate::figure::{self as replay, Figure, Mark, Shown};

/// Columns of a chart across which neighbouring points are thinned: its width in pixels.
const COLUMNS: f64 = 900.0;
/// One among many.
const SINGLE: Tone = Tone::Pale;
/// Coloured lines beyond which every second one is dashed: neighbours on a scale of colours look alike.
const TOLD_BY_COLOUR: usize = 7;
/// How far up a spectrogram goes: where textures have their power. Around a fingerprint, where its first lines are.
const HIGHEST: Hertz = Hertz(600.0);
const HIGHEST_AROUND_FINGERPRINT: Hertz = Hertz(300.0);

impl Figure {
    /// The figure as it is drawn: lines thinned to what a page shows, those that lie behind first; spectrograms over the
    /// frequencies that hold textures.
    ///
    /// # Errors
    /// [`EstimateError`] where a recording is too short for a spectrogram.
    pub fn drawn(&self) -> Result<Drawn, EstimateError> {
        match &self.shown {
            Shown::Lines { x, y, lines } => Ok(Drawn::Chart(chart_of(x, y, lines))),
            Shown::Spectrograms(panels) => {
                let highest = match self.number {
                    "35" => HIGHEST_AROUND_FINGERPRINT,
                    _ => HIGHEST,
                };
                spectrograms(panels, highest).map(Drawn::Spectrograms)
            }
        }
    }
}

fn chart_of(x: &replay::Axis, y: &replay::Axis, lines: &[replay::Line]) -> Chart {
    let all = || lines.iter().flat_map(|line| &line.points);
    let dotted = |line: &replay::Line| matches!(line.mark, Mark::Dots | Mark::Joined);
    let x = match (&x.scale, lines.iter().any(dotted)) {
        (replay::Scale::Names(_), _) | (_, true) => around(x, all().map(|p| p.0)),
        _ => from_end_to_end(x, all().map(|p| p.0)),
    };
    let y = around(y, all().map(|p| p.1));
    let behind = lines.iter().any(|line| line.mark != Mark::Thin);
    let grey = |line: &replay::Line| behind && line.mark == Mark::Thin;
    let coloured = lines.iter().filter(|line| !grey(line)).count();
    let mut colours = Tone::several(coloured).into_iter().zip(0..);
    let mut drawn: Vec<(bool, Line)> = lines
        .iter()
        .map(|line| {
            let points = line.points.iter().copied();
            let points = points
                .filter(|(px, py)| on(&x, *px) && on(&y, *py))
                .collect();
            let points = match line.mark {
                Mark::Thin | Mark::Line | Mark::Dashed => thinned(points, &x),
                // Every dot is seen.
                Mark::Joined | Mark::Dots => points,
            };
            if grey(line) {
                return (false, marked(line, line.mark, SINGLE, points));
            }
            let (colour, nth) = colours.next().unwrap_or((SINGLE, 0));
            let mark = match line.mark {
                Mark::Line if coloured > TOLD_BY_COLOUR && nth % 2 == 1 => Mark::Dashed,
                mark => mark,
            };
            (true, marked(line, mark, colour, points))
        })
        .collect();
    // What is grey lies behind what has a colour.
    drawn.sort_by_key(|(coloured, _)| *coloured);
    let mut chart = Chart::new(x, y, drawn.into_iter().map(|(_, line)| line).collect());
    chart.legend = Corner::Beside;
    chart
}

fn marked(line: &replay::Line, mark: Mark, colour: Tone, points: Vec<(f64, f64)>) -> Line {
    let drawn = Line::new(line.label.as_str(), colour, points);
    match mark {
        Mark::Thin => drawn.thin(),
        Mark::Line => drawn,
        Mark::Dashed => drawn.marked(PointMark::Dashed),
        Mark::Joined => drawn.marked(PointMark::Joined),
        Mark::Dots => drawn.marked(PointMark::Dots),
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
    let column = |point: &(f64, f64)| ((x.place(point.0) - low) / (high - low) * COLUMNS).floor();
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

fn spectrograms(
    panels: &[(String, Series<Acceleration>)],
    highest: Hertz,
) -> Result<Spectrograms, EstimateError> {
    let mut estimated = Vec::new();
    for (title, series) in panels {
        let usual = SpectrogramConfig::usual(series.rate());
        let config = SpectrogramConfig {
            // Lines close enough for a comb at the slowest speed.
            segment: 4 * usual.segment,
            cells: Cells::of_a_figure(Hertz(series.rate().nyquist().0.min(highest.0))),
            ..usual
        };
        estimated.push((title, spectrogram(series, &config)?));
    }
    let note = estimated.first().map(|(_, first)| {
        let config = &first.config;
        format!(
            "{} window, {} samples, {} % overlap; lines {:.2} Hz apart",
            config.window.name(),
            config.segment,
            digits(config.overlap * 100.0),
            first.resolution_hz()
        )
    });
    Ok(Spectrograms {
        panels: estimated
            .iter()
            .map(|(title, spectrogram)| spectrogram.panel(title.as_str()))
            .collect(),
        unit: Acceleration::UNIT.of_psd(),
        note: note.unwrap_or_default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column of pixels keeps its lowest and highest point; where there is room all points stay.
    #[test]
    fn long_lines_keep_their_extremes() {
        let axis = Axis::new("time, s", 0.0, 1.0);
        let wave: Vec<(f64, f64)> = (0..90_000)
            .map(|i| ((f64::from(i) + 0.5) / 90_000.0, f64::from(i % 100)))
            .collect();
        let kept = thinned(wave.clone(), &axis);
        assert_eq!(kept.len(), 2 * COLUMNS as usize);
        assert!(kept.iter().all(|(_, v)| *v == 0.0 || *v == 99.0));
        assert!(kept.is_sorted_by(|a, b| a.0 < b.0));
        let few: Vec<(f64, f64)> = wave.into_iter().step_by(200).collect();
        assert_eq!(thinned(few.clone(), &axis), few);
    }

    /// What has no place on a logarithmic axis is left out, and what is grey lies behind.
    #[test]
    fn thin_lines_lie_behind_the_others() {
        let axis = |scale| replay::Axis {
            label: String::new(),
            scale,
        };
        let line = |mark| replay::Line {
            label: String::new(),
            points: vec![(0.0, 1.0), (1.0, 0.0), (2.0, 10.0)],
            mark,
        };
        let (x, y) = (
            axis(replay::Scale::Linear),
            axis(replay::Scale::Logarithmic),
        );
        let both = chart_of(&x, &y, &[line(Mark::Line), line(Mark::Thin)]);
        assert_eq!(both.lines[0].tone, SINGLE);
        assert_eq!(both.lines[1].points, [(0.0, 1.0), (2.0, 10.0)]);
        assert_eq!((both.x.low, both.x.high), (0.0, 2.0));
        let alone = chart_of(&x, &y, &[line(Mark::Thin)]);
        assert_ne!(alone.lines[0].tone, SINGLE);
        // Dots above each other are all there.
        let mut dots = line(Mark::Dots);
        dots.points = vec![(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)];
        assert_eq!(chart_of(&x, &y, &[dots]).lines[0].points.len(), 3);
    }
}
