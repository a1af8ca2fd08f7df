//! Counterparts of the thesis' figures, in the common vocabulary of [`piezotact::figure`]: how one is laid out.

use piezotact::Series;
use piezotact::figure::{
    Axis, Chart, Drawn, Figure, Line, Mark, Scale, Spectrograms, Tone, Weight,
};
use piezotact::number::digits;
use piezotact::quantity::{Acceleration, Hertz, Quantity};
use piezotact::spectrum::{Cells, EstimateError, SpectrogramConfig, spectrogram};

/// Columns of a chart across which neighbouring points are thinned: its width in pixels.
const COLUMNS: f64 = 900.0;
/// One among many.
const SINGLE: Tone = Tone::Pale;
/// Coloured lines beyond which every second one is dashed: neighbours on a scale of colours look alike.
const DISTINCT_COLOURS: usize = 7;

/// The counterpart of a figure of the thesis.
#[derive(Clone, Debug)]
pub struct Counterpart {
    /// The number of that figure in the thesis, such as `38a`.
    pub number: &'static str,
    /// What is drawn, with its caption.
    pub figure: Figure,
}

impl Counterpart {
    /// Lines over `x` and `y`: thinned to what a page shows, those that lie behind first.
    pub(super) fn chart(
        number: &'static str,
        caption: impl Into<String>,
        (x, y): (Quantities, Quantities),
        lines: Vec<Line>,
    ) -> Self {
        let figure = chart_of(x, y, lines).captioned(caption);
        Self { number, figure }
    }

    /// Spectrograms up to `highest`, each with its title.
    ///
    /// # Errors
    /// [`EstimateError`] where a recording is too short for a spectrogram.
    pub(super) fn spectrograms(
        number: &'static str,
        caption: impl Into<String>,
        panels: &[(&str, &Series<Acceleration>)],
        highest: Hertz,
    ) -> Result<Self, EstimateError> {
        let figure = Figure {
            drawn: Drawn::Spectrograms(spectrograms(panels, highest)?),
            caption: caption.into(),
        };
        Ok(Self { number, figure })
    }
}

/// What stands along an axis whose range follows from the lines.
pub(super) struct Quantities {
    label: String,
    scale: Scale,
}

pub(super) fn linear(label: impl Into<String>) -> Quantities {
    Quantities {
        label: label.into(),
        scale: Scale::Linear,
    }
}

pub(super) fn logarithmic(label: impl Into<String>) -> Quantities {
    Quantities {
        label: label.into(),
        scale: Scale::Logarithmic,
    }
}

pub(super) fn names(label: &str, names: impl Iterator<Item = String>) -> Quantities {
    Quantities {
        label: label.into(),
        scale: Scale::Names(names.collect()),
    }
}

/// Frequency, across.
pub(super) fn frequency() -> Quantities {
    linear("frequency, Hz")
}

/// A PSD of acceleration, up.
pub(super) fn density() -> Quantities {
    linear("PSD, dB re 1 (m/s²)²/Hz")
}

/// A line; its colour follows from the others in its chart.
pub(super) fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Line {
    Line::new(label, SINGLE, points)
}

/// A point for each of `values` over whole numbers from 0, which stand for names: these have no order that a line could follow.
pub(super) fn over_names(label: &str, values: impl Iterator<Item = f64>) -> Line {
    let points = values.enumerate().map(|(i, v)| (i as f64, v)).collect();
    line(label, points).marked(Mark::Dots)
}

/// The same, joined: over steps that rise.
pub(super) fn over_steps(label: &str, values: impl Iterator<Item = f64>) -> Line {
    over_names(label, values).marked(Mark::Joined)
}

/// Points over the same names side by side instead of above each other.
pub(super) fn side_by_side(mut lines: Vec<Line>) -> Vec<Line> {
    let count = lines.len() as f64;
    for (i, line) in lines.iter_mut().enumerate() {
        let beside = 0.6 * ((i as f64 + 0.5) / count - 0.5);
        for (x, _) in &mut line.points {
            *x += beside;
        }
    }
    lines
}

/// Gives figures of one quantity over another one scale, so that they can be compared: those whose numbers differ in the letter
/// alone, such as 38a and 38b.
pub(super) fn share_scales(figures: &mut [Counterpart]) {
    let family = |number: &str| {
        let digits = number.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        digits.to_owned()
    };
    let mut scales: Vec<(String, Axis, Axis)> = Vec::new();
    let same = |a: &Axis, b: &Axis| a.label == b.label && a.scale == b.scale;
    let widen = |wide: &mut Axis, other: &Axis| {
        wide.low = wide.low.min(other.low);
        wide.high = wide.high.max(other.high);
    };
    for one in figures.iter() {
        let (Drawn::Chart(chart), family) = (&one.figure.drawn, family(one.number)) else {
            continue;
        };
        let known = scales
            .iter_mut()
            .find(|(of, x, y)| *of == family && same(x, &chart.x) && same(y, &chart.y));
        match known {
            Some((_, x, y)) => {
                widen(x, &chart.x);
                widen(y, &chart.y);
            }
            None => scales.push((family, chart.x.clone(), chart.y.clone())),
        }
    }
    for one in figures {
        let (Drawn::Chart(chart), family) = (&mut one.figure.drawn, family(one.number)) else {
            continue;
        };
        let shared = scales
            .iter()
            .find(|(of, x, y)| *of == family && same(x, &chart.x) && same(y, &chart.y));
        if let Some((_, x, y)) = shared {
            (chart.x, chart.y) = (x.clone(), y.clone());
        }
    }
}

/// A PSD in dB between two frequencies.
pub(super) fn decibels(
    psd: &[f64],
    resolution_hz: f64,
    from_hz: f64,
    to_hz: f64,
) -> Vec<(f64, f64)> {
    psd.iter()
        .enumerate()
        .map(|(k, value)| (k as f64 * resolution_hz, *value))
        .filter(|(hz, value)| (from_hz..=to_hz).contains(hz) && *value > 0.0)
        .map(|(hz, value)| (hz, 10.0 * value.log10()))
        .collect()
}

fn chart_of(x: Quantities, y: Quantities, lines: Vec<Line>) -> Chart {
    let all = || lines.iter().flat_map(|line| &line.points);
    let dotted = |line: &Line| matches!(line.mark, Mark::Dots | Mark::Joined);
    let x = match (&x.scale, lines.iter().any(dotted)) {
        (Scale::Names(_), _) | (_, true) => around(x, all().map(|p| p.0)),
        _ => from_end_to_end(x, all().map(|p| p.0)),
    };
    let y = around(y, all().map(|p| p.1));
    let behind = lines.iter().any(|line| line.weight != Weight::Thin);
    let grey = |line: &Line| behind && line.weight == Weight::Thin;
    let coloured = lines.iter().filter(|line| !grey(line)).count();
    let mut colours = Tone::several(coloured).into_iter().zip(0..);
    let mut drawn: Vec<(bool, Line)> = lines
        .into_iter()
        .map(|line| {
            let is_grey = grey(&line);
            let (tone, nth) = if is_grey {
                (SINGLE, 0)
            } else {
                colours.next().unwrap_or((SINGLE, 0))
            };
            let crowded = coloured > DISTINCT_COLOURS && nth % 2 == 1;
            let mark = match (line.mark, line.weight) {
                (Mark::Line, Weight::Usual) if crowded => Mark::Dashed,
                (mark, _) => mark,
            };
            let placed = |(px, py): &(f64, f64)| on(&x, *px) && on(&y, *py);
            let points = line.points.into_iter().filter(placed).collect();
            let points = match mark {
                Mark::Line | Mark::Dashed => thinned(points, &x),
                // Every dot is drawn.
                Mark::Joined | Mark::Dots => points,
            };
            let line = Line {
                tone,
                mark,
                points,
                ..line
            };
            (!is_grey, line)
        })
        .collect();
    // What is grey lies behind what has a colour.
    drawn.sort_by_key(|(coloured, _)| *coloured);
    Chart::new(x, y, drawn.into_iter().map(|(_, line)| line).collect()).beside()
}

/// Whether a value has a place on an axis.
fn on(axis: &Axis, value: f64) -> bool {
    axis.place(value).is_finite()
}

/// An axis with a little room around the values.
fn around(shown: Quantities, values: impl Iterator<Item = f64>) -> Axis {
    match shown.scale {
        Scale::Names(names) => Axis::names(shown.label, names),
        scale => Axis::around(shown.label, scale, values),
    }
}

/// An axis from the lowest value to the highest.
fn from_end_to_end(shown: Quantities, values: impl Iterator<Item = f64> + Clone) -> Axis {
    let roomy = around(shown, values.clone());
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
    panels: &[(&str, &Series<Acceleration>)],
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
        estimated.push((title, spectrogram(*series, &config)?));
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
            .map(|(title, spectrogram)| spectrogram.panel(**title))
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
        let usual = || line("", vec![(0.0, 1.0), (1.0, 0.0), (2.0, 10.0)]);
        let drawn = |lines| chart_of(linear(""), logarithmic(""), lines);
        let both = drawn(vec![usual(), usual().thin()]);
        assert_eq!(both.lines[0].tone, SINGLE);
        assert_eq!(both.lines[1].points, [(0.0, 1.0), (2.0, 10.0)]);
        assert_eq!((both.x.low, both.x.high), (0.0, 2.0));
        let alone = drawn(vec![usual().thin()]);
        assert_ne!(alone.lines[0].tone, SINGLE);
        // Dots above each other are all there.
        let dots = line("", vec![(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]).marked(Mark::Dots);
        assert_eq!(drawn(vec![dots]).lines[0].points.len(), 3);
    }

    /// Names have no order that a line could follow; steps have one.
    #[test]
    fn only_steps_are_joined() {
        let values = || [3.0, 1.0, 2.0].into_iter();
        assert_eq!(over_names("", values()).mark, Mark::Dots);
        assert_eq!(over_steps("", values()).mark, Mark::Joined);
        let beside = side_by_side(vec![over_names("", values()), over_names("", values())]);
        let first = beside.iter().map(|line| line.points[0].0);
        let first: Vec<f64> = first.collect();
        assert!(first[0] > -0.5 && first[0] < first[1] && first[1] < 0.5);
    }

    /// Figures of one family and one quantity are compared: 38a has the scale of 38b, and no other figure has.
    #[test]
    fn what_is_compared_has_one_scale() {
        let one = |number, label: &str, high: f64| {
            let lines = vec![line("", vec![(0.0, 1.0), (high, high)])];
            Counterpart::chart(number, "", (linear("x"), linear(label)), lines)
        };
        let mut figures = vec![
            one("38a", "y", 10.0),
            one("38b", "y", 90.0),
            one("38c", "z", 500.0),
            one("39a", "y", 20.0),
        ];
        share_scales(&mut figures);
        let highest = figures.iter().map(|one| match &one.figure.drawn {
            Drawn::Chart(chart) => (chart.x.high, chart.y.high.floor()),
            _ => panic!("no chart"),
        });
        let highest: Vec<_> = highest.collect();
        assert_eq!(
            highest,
            [(90.0, 97.0), (90.0, 97.0), (500.0, 539.0), (20.0, 21.0)]
        );
    }

    /// Beyond the colours that are easily distinguished every second line is dashed; thin ones and dots are not.
    #[test]
    fn every_second_of_many_lines_is_dashed() {
        let drawn = |count: usize, one: fn() -> Line| {
            let lines = (0..count).map(|_| one()).collect();
            let dashed = chart_of(linear(""), linear(""), lines).lines;
            dashed.iter().filter(|l| l.mark == Mark::Dashed).count()
        };
        let usual = || line("", vec![(0.0, 1.0), (1.0, 2.0)]);
        assert_eq!(drawn(DISTINCT_COLOURS, usual), 0);
        assert_eq!(drawn(DISTINCT_COLOURS + 1, usual), 4);
        assert_eq!(
            drawn(DISTINCT_COLOURS + 1, || line("", vec![(0.0, 1.0)]).thin()),
            0
        );
        assert_eq!(
            drawn(DISTINCT_COLOURS + 1, || over_names("", [1.0].into_iter())),
            0
        );
    }
}
