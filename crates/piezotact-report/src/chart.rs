//! One chart as SVG text: lines, points with their spread, shaded ranges, over linear, logarithmic or named axes.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use piezotact::figure::{Chart, Corner, Line, Mark, Scale, Tone, Weight};

use crate::DrawError;
use crate::axis::{Drawable, Ticked};

/// The width of a figure in a page.
pub const WIDTH: u32 = 900;
/// The usual height of a chart in a page.
pub const HEIGHT: u32 = 300;
/// The figure is drawn this many times larger, since points fall on whole units.
const FINE: u32 = 8;
/// The largest number of points of a line; of longer lines only the extremes of every stretch are drawn.
const MOST_POINTS: usize = 2400;
/// More labelled lines than this have their legend beside the chart.
const LEGEND_INSIDE: usize = 3;
/// Letters of a name in a legend beside the chart.
const LONGEST_LABEL: usize = 30;
/// The least width of a legend beside the chart, and how much of it stands before the names.
const LEGEND_WIDTH: u32 = 150;
const LEGEND_MARK: u32 = 36;
/// How wide a letter of a name is, about.
const LETTER: f64 = 7.6;

pub(crate) const TEXT: RGBColor = RGBColor(70, 78, 86);
const LIMIT: RGBColor = RGBColor(190, 30, 45);
const SHADE: RGBColor = RGBColor(0, 121, 107);

/// Colours that are distinguishable with any colour vision.
///
/// M. Okabe and K. Ito, *Color Universal Design* (2008), without yellow, which is too light for a line.
const OKABE_ITO: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// Viridis at ten even steps, from dark to light; its lightest end is left out.
const VIRIDIS: [RGBColor; 10] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 33, 115),
    RGBColor(65, 62, 133),
    RGBColor(53, 90, 140),
    RGBColor(43, 116, 142),
    RGBColor(33, 143, 140),
    RGBColor(33, 168, 131),
    RGBColor(82, 190, 101),
    RGBColor(144, 203, 62),
    RGBColor(186, 208, 36),
];

/// `count` colours in order: distinct ones for a few, a scale from dark to light for many.
pub(crate) fn palette(count: usize) -> Vec<RGBColor> {
    if count <= OKABE_ITO.len() {
        return OKABE_ITO[..count].to_vec();
    }
    (0..count)
        .map(|i| {
            let place = i as f64 * (VIRIDIS.len() - 1) as f64 / (count - 1) as f64;
            let k = (place as usize).min(VIRIDIS.len() - 2);
            let share = place - k as f64;
            let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as u8;
            let (a, b) = (VIRIDIS[k], VIRIDIS[k + 1]);
            RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
        })
        .collect()
}

/// The colour of a tone.
fn colour(tone: Tone) -> RGBColor {
    match tone {
        Tone::Reference => RGBColor(30, 30, 30),
        Tone::Pale => RGBColor(172, 180, 188),
        Tone::Main => RGBColor(0, 121, 107),
        Tone::Second => RGBColor(198, 83, 26),
        Tone::Signal => RGBColor(0, 90, 140),
        Tone::Accent => RGBColor(213, 94, 0),
        Tone::Third => RGBColor(0, 158, 115),
        Tone::Border => RGBColor(110, 118, 126),
        Tone::Of { index, count } => {
            let colours = palette(count.max(1));
            colours[index.min(colours.len() - 1)]
        }
    }
}

/// The width of a line in half pixels.
fn half_pixels(weight: Weight) -> u32 {
    match weight {
        Weight::Thin => 2,
        Weight::Usual => 4,
        Weight::Thick => 10,
    }
}

/// A chart `height` high and [`WIDTH`] wide, as SVG text that takes the width there is.
///
/// # Errors
/// [`DrawError`] where the plotting library refuses it.
pub fn svg(chart: &Chart, height: u32) -> Result<String, DrawError> {
    Plot(chart).svg(height)
}

/// The same with its size in pixels, for a file of its own.
///
/// # Errors
/// As [`svg()`].
pub fn file(chart: &Chart, height: u32) -> Result<String, DrawError> {
    Ok(sized(&svg(chart, height)?, height))
}

/// `svg` with its size, which a page leaves to the width there is.
pub(crate) fn sized(svg: &str, height: u32) -> String {
    let size = format!("width=\"{WIDTH}\" height=\"{height}\"");
    svg.replacen("role=\"img\"", &size, 1)
}

/// A chart while it is drawn.
struct Plot<'c>(&'c Chart);

impl std::ops::Deref for Plot<'_> {
    type Target = Chart;

    fn deref(&self) -> &Chart {
        self.0
    }
}

impl Plot<'_> {
    fn svg(&self, height: u32) -> Result<String, DrawError> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH * FINE, height * FINE))
                .into_drawing_area();
            area.fill(&WHITE).map_err(plot_failed)?;
            let labelled: Vec<&Line> = self.lines.iter().filter(|l| !l.label.is_empty()).collect();
            let beside = labelled.len() > LEGEND_INSIDE
                || (self.legend == Corner::Beside && !labelled.is_empty());
            let plot = if beside {
                let (plot, legend) =
                    area.split_horizontally((WIDTH - legend_width(&labelled)) * FINE);
                legend_beside(&legend, &labelled)?;
                plot
            } else {
                area.clone()
            };
            let mut builder = ChartBuilder::on(&plot);
            builder
                .margin(10 * FINE)
                .margin_right(28 * FINE)
                .x_label_area_size(44 * FINE)
                .y_label_area_size(76 * FINE);
            if !self.title.is_empty() {
                builder.caption(&self.title, ("sans-serif", 17 * FINE));
            }
            let chart = builder
                .build_cartesian_2d(self.x.ranged(), self.y.ranged())
                .map_err(plot_failed)?;
            self.draw(chart, if beside { 0 } else { labelled.len() })?;
            area.present().map_err(plot_failed)?;
        }
        // In a page the figure takes the width there is.
        Ok(svg.replacen(
            &format!("width=\"{}\" height=\"{}\"", WIDTH * FINE, height * FINE),
            "role=\"img\"",
            1,
        ))
    }

    /// A point in places, moved to the axes' ends where it lies beyond them.
    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (
            self.x.place(x.clamp(self.x.low, self.x.high)),
            self.y.place(y.clamp(self.y.low, self.y.high)),
        )
    }

    fn draw<'a, 'b: 'a>(
        &'b self,
        mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<Ticked, Ticked>>,
        legend_inside: usize,
    ) -> Result<(), DrawError> {
        let font = ("sans-serif", 17 * FINE).into_font().color(&TEXT);
        let shades = self.shaded.iter().map(|range| (range, SHADE, 0.10));
        let rejects = self.rejected.iter().map(|range| (range, LIMIT, 0.08));
        for ((from, to), colour, strength) in shades.chain(rejects) {
            let corners = [self.at((*from, self.y.low)), self.at((*to, self.y.high))];
            let shade = Rectangle::new(corners, colour.mix(strength).filled());
            chart
                .draw_series(std::iter::once(shade))
                .map_err(plot_failed)?;
        }
        let x_labels = match &self.x.scale {
            Scale::Names(names) => names.len(),
            _ => 9,
        };
        chart
            .configure_mesh()
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .x_labels(x_labels)
            .y_labels(6)
            .x_label_formatter(&|v| self.x.text(*v))
            .y_label_formatter(&|v| self.y.text(*v))
            .label_style(font.clone())
            .axis_desc_style(font.clone())
            .bold_line_style(RGBColor(222, 226, 230).stroke_width(FINE))
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(150, 158, 166).stroke_width(FINE))
            .draw()
            .map_err(plot_failed)?;
        for level in &self.levels {
            let ends = [(self.x.low, *level), (self.x.high, *level)].map(|end| self.at(end));
            chart
                .draw_series(std::iter::once(PathElement::new(
                    ends,
                    LIMIT.stroke_width(FINE),
                )))
                .map_err(plot_failed)?;
        }
        for line in &self.lines {
            self.draw_ribbon(&mut chart, line)?;
        }
        for line in &self.lines {
            self.draw_line(&mut chart, line)?;
        }
        self.draw_notes(&mut chart, &font)?;
        if legend_inside > 0 {
            chart
                .configure_series_labels()
                .position(match self.legend {
                    Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
                    Corner::UpperRight | Corner::Beside => SeriesLabelPosition::UpperRight,
                })
                .margin(10 * FINE as i32)
                .legend_area_size(30 * FINE as i32)
                .background_style(WHITE.mix(0.85))
                .label_font(font)
                .draw()
                .map_err(plot_failed)?;
        }
        Ok(())
    }

    /// The area between the limits of a line.
    fn draw_ribbon<'a, 'b: 'a>(
        &'b self,
        chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<Ticked, Ticked>>,
        line: &Line,
    ) -> Result<(), DrawError> {
        let inside = || {
            let within = |x: f64| x >= self.x.low && x <= self.x.high;
            line.ribbon.iter().filter(move |(x, ..)| within(*x))
        };
        let upper = inside().map(|(x, _, high)| self.at((*x, *high)));
        let lower = inside().rev().map(|(x, low, _)| self.at((*x, *low)));
        let outline: Vec<(f64, f64)> = upper.chain(lower).collect();
        if outline.len() > 2 {
            let area = Polygon::new(outline, colour(line.tone).mix(0.25).filled());
            chart
                .draw_series(std::iter::once(area))
                .map_err(plot_failed)?;
        }
        Ok(())
    }

    /// Places every text beside its point, if possible without covering other texts or points.
    fn draw_notes<'a, 'b: 'a>(
        &'b self,
        chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<Ticked, Ticked>>,
        font: &TextStyle<'_>,
    ) -> Result<(), DrawError> {
        let fine = FINE as i32;
        let (wide, high) = (10 * fine, 17 * fine);
        let dots: Vec<(i32, i32)> = self
            .notes
            .iter()
            .map(|(x, y, _)| chart.backend_coord(&self.at((*x, *y))))
            .collect();
        let mut taken: Vec<[i32; 4]> = dots
            .iter()
            .map(|(x, y)| [x - 4 * fine, y - 4 * fine, x + 4 * fine, y + 4 * fine])
            .collect();
        for ((x, y, text), dot) in self.notes.iter().zip(&dots) {
            let width = wide * text.chars().count() as i32;
            // Around the point, then further and further away.
            let places = (0..6).flat_map(|ring| {
                let (right, left) = (
                    8 * fine + 6 * fine * ring,
                    -8 * fine - 6 * fine * ring - width,
                );
                let rise = 11 * fine * ring;
                [
                    (right, -high - rise / 2),
                    (left, -high - rise / 2),
                    (right, rise),
                    (left, rise),
                    (right, -high / 2),
                    (left, -high / 2),
                ]
            });
            let free = |(dx, dy): &(i32, i32)| {
                let [a, b, c, d] = [
                    dot.0 + dx,
                    dot.1 + dy,
                    dot.0 + dx + width,
                    dot.1 + dy + high,
                ];
                taken
                    .iter()
                    .all(|[e, f, g, h]| c <= *e || *g <= a || d <= *f || *h <= b)
            };
            let (dx, dy) = places.clone().find(free).unwrap_or((8 * fine, -high));
            taken.push([
                dot.0 + dx,
                dot.1 + dy,
                dot.0 + dx + width,
                dot.1 + dy + high,
            ]);
            let style = font.clone().pos(Pos::new(HPos::Left, VPos::Top));
            let near =
                EmptyElement::at(self.at((*x, *y))) + Text::new(text.clone(), (dx, dy), style);
            chart
                .draw_series(std::iter::once(near))
                .map_err(plot_failed)?;
        }
        Ok(())
    }

    fn draw_line<'a, 'b: 'a>(
        &'b self,
        chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<Ticked, Ticked>>,
        line: &Line,
    ) -> Result<(), DrawError> {
        let inside: Vec<(f64, f64)> = line
            .points
            .iter()
            .filter(|(x, y)| *x >= self.x.low && *x <= self.x.high && y.is_finite())
            .map(|point| self.at(*point))
            .collect();
        let style = colour(line.tone).stroke_width(half_pixels(line.weight) * FINE / 2);
        let fine = FINE as i32;
        for (x, low, high) in &line.spread {
            let ends = [self.at((*x, *low)), self.at((*x, *high))];
            chart
                .draw_series(std::iter::once(PathElement::new(
                    ends,
                    colour(line.tone).mix(0.6).stroke_width(FINE * 3 / 2),
                )))
                .map_err(plot_failed)?;
        }
        if matches!(line.mark, Mark::Dots | Mark::Joined) {
            let dots = inside
                .iter()
                .map(|point| Circle::new(*point, 4 * fine, colour(line.tone).filled()));
            chart.draw_series(dots).map_err(plot_failed)?;
        }
        let drawn = match line.mark {
            Mark::Dots => {
                let none = LineSeries::new(std::iter::empty(), style);
                chart.draw_series(none).map_err(plot_failed)?
            }
            Mark::Dashed => chart
                .draw_series(DashedLineSeries::new(
                    extremes(inside),
                    9 * FINE,
                    5 * FINE,
                    style,
                ))
                .map_err(plot_failed)?,
            Mark::Line | Mark::Joined => chart
                .draw_series(LineSeries::new(extremes(inside), style))
                .map_err(plot_failed)?,
        };
        if !line.label.is_empty() {
            drawn
                .label(&line.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20 * fine, y)], style));
        }
        Ok(())
    }
}

/// As wide as the longest name needs.
fn legend_width(lines: &[&Line]) -> u32 {
    let longest = lines.iter().map(|line| line.label.chars().count()).max();
    let letters = longest.unwrap_or(0).min(LONGEST_LABEL);
    LEGEND_WIDTH.max(LEGEND_MARK + (LETTER * letters as f64) as u32)
}

/// The legend of many lines: one below the other, as each is drawn.
fn legend_beside(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    lines: &[&Line],
) -> Result<(), DrawError> {
    let fine = FINE as i32;
    let (_, height) = area.dim_in_pixel();
    let room = height as i32 - 30 * fine;
    let step = (22 * fine).min(room / lines.len().max(1) as i32);
    let size = (17 * FINE).min((step as u32).saturating_sub(FINE).max(6 * FINE));
    for (i, line) in lines.iter().enumerate() {
        let y = 24 * fine + step * i as i32;
        let style = colour(line.tone).stroke_width(half_pixels(line.weight) * FINE / 2);
        let dash = |from: i32, to: i32| PathElement::new([(from * fine, y), (to * fine, y)], style);
        match line.mark {
            Mark::Dashed => {
                for (from, to) in [(0, 9), (14, 23)] {
                    area.draw(&dash(from, to)).map_err(plot_failed)?;
                }
            }
            Mark::Line | Mark::Joined => area.draw(&dash(0, 23)).map_err(plot_failed)?,
            Mark::Dots => {}
        }
        if matches!(line.mark, Mark::Dots | Mark::Joined) {
            let dot = Circle::new((12 * fine, y), 4 * fine, colour(line.tone).filled());
            area.draw(&dot).map_err(plot_failed)?;
        }
        let font = ("sans-serif", size)
            .into_font()
            .color(&TEXT)
            .pos(Pos::new(HPos::Left, VPos::Center));
        // A name is cut where the room ends.
        let label: String = match line.label.chars().count() {
            long if long > LONGEST_LABEL => line
                .label
                .chars()
                .take(LONGEST_LABEL - 1)
                .chain(['…'])
                .collect(),
            _ => line.label.clone(),
        };
        area.draw(&Text::new(label, (30 * fine, y), font))
            .map_err(plot_failed)?;
    }
    Ok(())
}

fn plot_failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> DrawError {
    DrawError::Drawing {
        reason: error.to_string(),
    }
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
