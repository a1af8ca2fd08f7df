//! Figures as SVG text, one function for each.

use piezotact::quantity::{Band, Decibels, Drive, Quantity};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::failure::Outcome;
use crate::report::Straight;

const TARGET: RGBColor = RGBColor(30, 30, 30);
/// The target where the measurement lies over it.
const UNDER: RGBColor = RGBColor(172, 180, 188);
const MEASURED: RGBColor = RGBColor(0, 121, 107);
const OTHER: RGBColor = RGBColor(198, 83, 26);
const LIMIT: RGBColor = RGBColor(190, 30, 45);

/// The size of a figure in a page.
const WIDTH: u32 = 900;
const HEIGHT: u32 = 300;
/// The figure is drawn this many times larger, since points fall on whole units.
const FINE: u32 = 8;
/// Points of a line beyond which only the extremes of every stretch are drawn.
const MOST_POINTS: usize = 2400;

/// An axis: its label and its range.
struct Axis {
    label: String,
    low: f64,
    high: f64,
}

impl Axis {
    fn new(label: impl Into<String>, low: f64, high: f64) -> Self {
        Self {
            label: label.into(),
            low,
            high,
        }
    }
}

struct Line {
    label: String,
    colour: RGBColor,
    /// In half pixels.
    width: u32,
    points: Vec<(f64, f64)>,
}

impl Line {
    fn new(label: impl Into<String>, colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.into(),
            colour,
            width: 4,
            points,
        }
    }

    fn thick(mut self) -> Self {
        self.width = 10;
        self
    }

    fn thin(mut self) -> Self {
        self.width = 2;
        self
    }
}

/// What stands in a chart.
struct Chart {
    /// Above it, where it stands alone.
    title: String,
    x: Axis,
    y: Axis,
    /// Logarithmic x axis.
    scale: Scale,
    lines: Vec<Line>,
    /// Ranges of x that are shaded: what is judged.
    shaded: Vec<(f64, f64)>,
    /// Horizontal lines.
    levels: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Scale {
    Linear,
    Logarithmic,
}

impl Chart {
    fn svg(&self, height: u32) -> Outcome<String> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH * FINE, height * FINE))
                .into_drawing_area();
            area.fill(&WHITE).map_err(plot_failed)?;
            let mut builder = ChartBuilder::on(&area);
            builder
                .margin(10 * FINE)
                .margin_right(28 * FINE)
                .x_label_area_size(44 * FINE)
                .y_label_area_size(76 * FINE);
            if !self.title.is_empty() {
                builder.caption(&self.title, ("sans-serif", 15 * FINE));
            }
            let y = self.y.low..self.y.high;
            match self.scale {
                Scale::Linear => {
                    let chart = builder
                        .build_cartesian_2d(self.x.low..self.x.high, y)
                        .map_err(plot_failed)?;
                    self.draw(chart)?;
                }
                Scale::Logarithmic => {
                    // Decades alone leave a band of 30–500 Hz with one tick.
                    let ticks = [1.0, 2.0, 3.0, 5.0, 7.0]
                        .iter()
                        .flat_map(|m| (-1..6).map(move |e| m * 10f64.powi(e)));
                    let ticks = ticks
                        .filter(|t| (self.x.low..=self.x.high).contains(t))
                        .collect();
                    let x: LogCoord<f64> = (self.x.low..self.x.high).log_scale().into();
                    let x = x.with_key_points(ticks);
                    let chart = builder.build_cartesian_2d(x, y).map_err(plot_failed)?;
                    self.draw(chart)?;
                }
            }
            present(&area)?;
        }
        // In a page the figure takes the width there is.
        Ok(svg.replacen(
            &format!("width=\"{}\" height=\"{}\"", WIDTH * FINE, height * FINE),
            "role=\"img\"",
            1,
        ))
    }

    fn draw<'a, 'b: 'a, X, Y>(
        &'b self,
        mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    ) -> Outcome
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let font = ("sans-serif", 15 * FINE)
            .into_font()
            .color(&RGBColor(70, 78, 86));
        for (from, to) in &self.shaded {
            let corners = [
                (from.max(self.x.low), self.y.low),
                (to.min(self.x.high), self.y.high),
            ];
            let shade = Rectangle::new(corners, RGBColor(0, 121, 107).mix(0.07).filled());
            chart
                .draw_series(std::iter::once(shade))
                .map_err(plot_failed)?;
        }
        chart
            .configure_mesh()
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .x_labels(9)
            .y_labels(6)
            .x_label_formatter(&|v| number(*v))
            .y_label_formatter(&|v| number(*v))
            .label_style(font.clone())
            .axis_desc_style(font.clone())
            .bold_line_style(RGBColor(222, 226, 230).stroke_width(FINE))
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(150, 158, 166).stroke_width(FINE))
            .draw()
            .map_err(plot_failed)?;
        for level in &self.levels {
            let ends = [(self.x.low, *level), (self.x.high, *level)];
            chart
                .draw_series(std::iter::once(PathElement::new(
                    ends,
                    LIMIT.stroke_width(FINE),
                )))
                .map_err(plot_failed)?;
        }
        for line in &self.lines {
            let inside = line
                .points
                .iter()
                .filter(|(x, y)| *x >= self.x.low && *x <= self.x.high && y.is_finite())
                .map(|(x, y)| (*x, y.clamp(self.y.low, self.y.high)));
            let style = line.colour.stroke_width(line.width * FINE / 2);
            let drawn = chart
                .draw_series(LineSeries::new(extremes(inside.collect()), style))
                .map_err(plot_failed)?;
            if !line.label.is_empty() {
                drawn.label(&line.label).legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 20 * FINE as i32, y)], style)
                });
            }
        }
        if self.lines.iter().any(|line| !line.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .margin(10 * FINE as i32)
                .legend_area_size(30 * FINE as i32)
                .background_style(WHITE.mix(0.85))
                .label_font(font)
                .draw()
                .map_err(plot_failed)?;
        }
        Ok(())
    }
}

fn present(area: &DrawingArea<SVGBackend<'_>, Shift>) -> Outcome {
    area.present().map_err(plot_failed)?;
    Ok(())
}

fn plot_failed<E: std::error::Error + Send + Sync>(
    error: DrawingAreaErrorKind<E>,
) -> anyhow::Error {
    anyhow::anyhow!("a figure could not be drawn: {error}")
}

/// A tick's number without needless digits.
fn number(value: f64) -> String {
    // Ticks are sums of steps: what is left at 0 is rounding.
    let value = if value.abs() < 1e-9 { 0.0 } else { value };
    let text = if value.abs() >= 10.0 || value == 0.0 {
        format!("{value:.0}")
    } else {
        format!("{value:.3}")
    };
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    };
    text.replace('-', "−")
}

/// A long line as the lowest and highest point of every stretch, which looks the same.
fn extremes(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if points.len() <= MOST_POINTS {
        return points;
    }
    let stretch = points.len().div_ceil(MOST_POINTS / 2);
    points
        .chunks(stretch)
        .flat_map(|chunk| {
            let low = chunk.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
            let high = chunk.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
            let mut both: Vec<(f64, f64)> = low.into_iter().chain(high).collect();
            both.sort_by(|a, b| a.0.total_cmp(&b.0));
            both
        })
        .collect()
}

fn decibels(frequencies_hz: &[f64], powers: &[f64]) -> Vec<(f64, f64)> {
    frequencies_hz
        .iter()
        .zip(powers)
        .map(|(f, p)| (*f, Decibels::from_power(*p).0))
        .collect()
}

/// A range that holds every line's points between `low` and `high`, in steps of `step`, `depth` at most.
fn range(lines: &[&[(f64, f64)]], low: f64, high: f64, step: f64, depth: f64) -> (f64, f64) {
    let inside = || {
        lines
            .iter()
            .flat_map(|line| line.iter())
            .filter(|(x, y)| *x >= low && *x <= high && y.is_finite())
    };
    let top = inside().map(|(_, y)| *y).fold(f64::MIN, f64::max);
    let bottom = inside().map(|(_, y)| *y).fold(f64::MAX, f64::min);
    if top < bottom {
        return (0.0, step);
    }
    let top = (top / step).floor() * step + step;
    (((bottom / step).floor() * step).max(top - depth), top)
}

/// The PSD of one channel, as a file of its own: `title` says what it is and how it was estimated.
pub(crate) fn psd(
    title: &str,
    unit: &str,
    frequencies_hz: &[f64],
    values: &[f64],
) -> Outcome<String> {
    let points = decibels(&frequencies_hz[1..], &values[1..]);
    let last = frequencies_hz[frequencies_hz.len() - 1];
    let (low, high) = range(&[&points], 0.0, last, 10.0, 120.0);
    let chart = Chart {
        title: title.into(),
        x: Axis::new("frequency, Hz", frequencies_hz[1], last),
        y: Axis::new(format!("PSD, dB re 1 {unit}"), low, high),
        scale: Scale::Logarithmic,
        lines: vec![Line::new("", MEASURED, points)],
        shaded: Vec::new(),
        levels: Vec::new(),
    };
    let svg = chart.svg(HEIGHT + 120)?;
    // In a page a figure takes the width there is; a file of its own needs its size.
    let size = format!("width=\"{WIDTH}\" height=\"{}\"", HEIGHT + 120);
    Ok(svg.replacen("role=\"img\"", &size, 1))
}

/// The span of frequencies that figures of a band show: a little more on both sides.
fn span(band: Band) -> (f64, f64) {
    ((band.low().0 * 0.6).max(1.0), band.high().0 * 1.4)
}

/// What is judged: the achievable parts of the band where they are known, or all of it.
fn judged(verification: &Verification) -> Vec<(f64, f64)> {
    let bands = match verification.achievable_band_hz.as_slice() {
        [] => std::slice::from_ref(&verification.band_hz),
        achievable => achievable,
    };
    bands
        .iter()
        .map(|band| (band.low().0, band.high().0))
        .collect()
}

/// Target and measured PSD around the band that is judged.
pub(crate) fn spectra(verification: &Verification) -> Outcome<String> {
    let f = &verification.frequency_hz;
    let target = decibels(f, &verification.target_psd);
    let measured = decibels(f, &verification.measured_psd);
    let lines = vec![
        Line::new("target", UNDER, target).thick(),
        Line::new("measured on the finger", MEASURED, measured),
    ];
    spectra_chart(verification, lines)
}

/// The target's PSD, and what comes of sending the texture straight to the device: as it stands, and turned
/// down until nothing clips.
pub(crate) fn straight(straight: &Straight<Verification>) -> Outcome<String> {
    let loud = &straight.as_it_stands;
    let quiet = &straight.turned_down;
    let lines = vec![
        Line::new(
            "target",
            UNDER,
            decibels(&loud.frequency_hz, &loud.target_psd),
        )
        .thick(),
        Line::new(
            "sent straight, device's own scale",
            OTHER,
            decibels(&loud.frequency_hz, &loud.measured_psd),
        ),
        Line::new(
            "sent straight, turned down",
            TARGET,
            decibels(&quiet.frequency_hz, &quiet.measured_psd),
        )
        .thin(),
    ];
    spectra_chart(loud, lines)
}

fn spectra_chart(verification: &Verification, lines: Vec<Line>) -> Outcome<String> {
    let (from, to) = span(verification.band_hz);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 70.0);
    Chart {
        title: String::new(),
        x: Axis::new("frequency, Hz", from, to),
        // Room for the legend above the lines.
        y: Axis::new(
            format!("PSD, dB re 1 {}", verification.psd_unit),
            low,
            high + 12.0,
        ),
        scale: Scale::Logarithmic,
        shaded: judged(verification),
        levels: Vec::new(),
        lines,
    }
    .svg(HEIGHT + 40)
}

/// The error of every line that is judged.
pub(crate) fn error(verification: &Verification) -> Outcome<String> {
    let (from, to) = span(verification.band_hz);
    let points: Vec<(f64, f64)> = verification
        .error_frequency_hz
        .iter()
        .copied()
        .zip(verification.error_db.iter().copied())
        .collect();
    let (low, high) = range(&[&points], from, to, 1.0, 40.0);
    let reach = low.abs().max(high.abs()).max(2.0);
    let limit_db = verification.limits.error_db_rms;
    Chart {
        title: String::new(),
        x: Axis::new("frequency, Hz", from, to),
        y: Axis::new("measured − target, dB", -reach, reach),
        scale: Scale::Logarithmic,
        shaded: judged(verification),
        levels: vec![-limit_db, limit_db],
        lines: vec![Line::new("", MEASURED, points)],
    }
    .svg(HEIGHT - 60)
}

/// A short stretch of the target and the aligned measurement, from the middle.
pub(crate) fn waveforms(verification: &Verification) -> Outcome<String> {
    let rate_hz = verification.rate_hz;
    let shown = (0.15 * rate_hz) as usize;
    let count = verification.target.len().min(verification.aligned.len());
    let start = count.saturating_sub(shown) / 2;
    let points = |samples: &[f64]| -> Vec<(f64, f64)> {
        (start..count.min(start + shown))
            .map(|i| (i as f64 / rate_hz, samples[i]))
            .collect()
    };
    let (wanted, got) = (points(&verification.target), points(&verification.aligned));
    let reach = wanted
        .iter()
        .chain(&got)
        .map(|(_, y)| y.abs())
        .fold(f64::MIN_POSITIVE, f64::max)
        * 1.5;
    Chart {
        title: String::new(),
        x: Axis::new(
            "time, s",
            start as f64 / rate_hz,
            (start + shown) as f64 / rate_hz,
        ),
        y: Axis::new("acceleration, m/s²", -reach, reach),
        scale: Scale::Linear,
        shaded: Vec::new(),
        levels: Vec::new(),
        lines: vec![
            Line::new("target", UNDER, wanted).thick(),
            Line::new("measured, aligned", MEASURED, got).thin(),
        ],
    }
    .svg(HEIGHT - 20)
}

/// Magnitude, phase and coherence of a transfer function: three figures over one axis.
pub(crate) fn transfer<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
) -> Outcome<Vec<String>> {
    let (from, to) = span(band);
    let f = function.frequencies_hz();
    let lines = || f.iter().copied().zip(function.response()).skip(1);
    let magnitude: Vec<(f64, f64)> = lines()
        .map(|(f, h)| (f, Decibels::from_amplitude_ratio(h.norm()).0))
        .collect();
    let phase: Vec<(f64, f64)> = lines().map(|(f, h)| (f, h.arg().to_degrees())).collect();
    let coherence = f
        .iter()
        .copied()
        .zip(function.coherence().iter().copied())
        .skip(1)
        .collect();
    let (low, high) = range(&[&magnitude], from, to, 10.0, 80.0);
    // A coherence of 0.98 and one of 0.999 are worlds apart: the axis begins below the lowest in the band.
    let lowest = function
        .coherence_in(band)
        .map_or(0.0, |summary| summary.lowest.clamp(0.0, 1.0));
    let floor = ((lowest * 10.0).floor() / 10.0).min(0.9);
    let chart =
        |label: &str, low: f64, high: f64, colour: RGBColor, points: Vec<(f64, f64)>| Chart {
            title: String::new(),
            x: Axis::new("frequency, Hz", from, to),
            y: Axis::new(label, low, high),
            scale: Scale::Logarithmic,
            shaded: vec![(band.low().0, band.high().0)],
            levels: Vec::new(),
            lines: vec![Line::new("", colour, points)],
        };
    Ok(vec![
        chart("|H|, dB re 1 (m/s²)/FS", low, high, MEASURED, magnitude).svg(HEIGHT - 20)?,
        chart("phase with delay, °", -180.0, 180.0, TARGET, phase).svg(HEIGHT - 80)?,
        chart(
            "coherence",
            floor,
            1.0 + 0.05 * (1.0 - floor),
            OTHER,
            coherence,
        )
        .svg(HEIGHT - 80)?,
    ])
}

/// The drive with the level at which the device clips.
pub(crate) fn drive(drive: &Series<Drive>, limit: f64) -> Outcome<String> {
    let rate_hz = drive.rate().hz();
    let points = drive
        .samples()
        .iter()
        .enumerate()
        .map(|(i, v)| (i as f64 / rate_hz, *v))
        .collect();
    let reach = drive.peak().max(limit) * 1.15;
    Chart {
        title: String::new(),
        x: Axis::new("time, s", 0.0, drive.duration().0),
        y: Axis::new("drive, full scale = 1", -reach, reach),
        scale: Scale::Linear,
        shaded: Vec::new(),
        levels: vec![-limit, limit],
        lines: vec![Line::new("", MEASURED, points).thin()],
    }
    .svg(HEIGHT - 60)
}
