//! One chart as SVG text: lines, points with their spread, shaded ranges, over linear, logarithmic or named axes.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{BoldPoints, Ranged};
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use piezotact::figure::{Chart, Line, MOST_POINTS, Mark, Scale, Weight, extremes};

use crate::DrawError;
use crate::alternative;
use crate::axis::{Drawable, Ticked};
use crate::colour::colour;
use crate::format::{Format, both};
use crate::legend::Place;

/// The width of a figure in a page.
pub const WIDTH: u32 = Format::WIDE.width;
/// The usual height of a chart in a page.
pub const HEIGHT: u32 = 300;
/// The figure is drawn this many times larger, since points fall on whole units.
pub(crate) const FINE: u32 = 8;
/// What stays free around a chart.
pub(crate) const EDGE: u32 = 4;
/// The most numbers along the axis of y.
const Y_MARKS: usize = 6;
/// How long the mark of a tick is; its number stands as far from it.
const TICK: u32 = 4;
/// The room of a name that stands upright below a chart.
const LONGEST_NAME: f64 = 180.0;

pub(crate) const TEXT: RGBColor = RGBColor(70, 78, 86);
const LIMIT: RGBColor = RGBColor(190, 30, 45);
const SHADE: RGBColor = RGBColor(0, 121, 107);

/// A plot is at least so wide.
const LEAST_WIDTH: u32 = 40;

/// From one line of text to the next.
pub(crate) fn line_height(format: Format) -> u32 {
    format.text * 13 / 10
}

/// The width of a line in half pixels.
pub(crate) fn half_pixels(weight: Weight) -> u32 {
    match weight {
        Weight::Thin => 2,
        Weight::Usual => 4,
        Weight::Thick => 10,
    }
}

/// A chart in both formats, as SVG text that takes the width there is; `height` is that of the wide one.
///
/// # Errors
/// [`DrawError`] where the plotting library refuses it.
pub fn svg(chart: &Chart, height: u32) -> Result<String, DrawError> {
    both(&alternative::chart(chart), |format| {
        Plot::new(chart, format, height).svg()
    })
}

/// A text of `format`, with the size that the plotting library takes for it.
pub(crate) fn font<'f>(format: Format) -> TextStyle<'f> {
    // The library divides by this.
    let size = 1.24 * f64::from(format.text * FINE);
    ("sans-serif", size).into_font().color(&TEXT)
}

/// What stands below a plot.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Below {
    /// Marks with their numbers or names, and the label of x.
    Axis,
    /// Marks alone: the axis stands below another plot.
    Marks,
}

/// A chart while it is drawn.
pub(crate) struct Plot<'c> {
    chart: &'c Chart,
    format: Format,
    legend: Place<'c>,
    /// The label of y above the chart, where it is too long to stand along its axis.
    above: Vec<String>,
    /// How wide is what stands left of the plot: numbers, and the label of y along its axis.
    pub(crate) left: u32,
    /// How wide is what stands right of the chart: its legend, if it is there.
    pub(crate) beside: u32,
    below: Below,
    /// Whether the names of x stand upright.
    upright: bool,
    /// Without the legend and a label of y above the plot, and without upright names below it.
    height: u32,
}

impl std::ops::Deref for Plot<'_> {
    type Target = Chart;

    fn deref(&self) -> &Chart {
        self.chart
    }
}

impl<'c> Plot<'c> {
    pub(crate) fn new(chart: &'c Chart, format: Format, height: u32) -> Self {
        let height = if format.is_narrow() {
            (height * 3 / 5).max(190)
        } else {
            height
        };
        let labelled = chart.lines.iter().filter(|l| !l.label.is_empty()).collect();
        let legend = Place::of(labelled, format, chart.legend, height);
        let line = line_height(format);
        let along = f64::from(height.saturating_sub(5 * line));
        let is_long = format.is_narrow() || format.width_of(&chart.y.label) > along;
        let beside = legend.width();
        let plot = Self {
            chart,
            format,
            legend,
            above: Vec::new(),
            left: 0,
            beside,
            below: Below::Axis,
            upright: false,
            height,
        };
        match is_long {
            true => plot.labelled_above(),
            false => {
                let left = plot.needed_left();
                plot.framed(left, beside, Below::Axis)
            }
        }
    }

    /// The same with the label of y above the plot.
    pub(crate) fn labelled_above(mut self) -> Self {
        let room = f64::from(self.format.width - 2 * EDGE);
        self.above = self.format.lines(&self.y.label, room);
        let left = self.needed_left();
        let beside = self.beside;
        self.framed(left, beside, Below::Axis)
    }

    /// Whether the label of y stands above the plot.
    pub(crate) fn is_labelled_above(&self) -> bool {
        !self.above.is_empty()
    }

    /// The same with so much left of its plot and right of it, and this below.
    pub(crate) fn framed(mut self, left: u32, beside: u32, below: Below) -> Self {
        (self.left, self.beside, self.below) = (left, beside, below);
        self.upright = self.needs_upright_names();
        self
    }

    /// The height of the whole: what stands above and below the plot does not take from it.
    pub(crate) fn height(&self) -> u32 {
        let line = line_height(self.format);
        let usual = 2 * EDGE + self.legend.rows() * line + self.above.len() as u32 * line;
        let height = self.height + usual;
        match self.below {
            Below::Marks => height.saturating_sub(2 * line),
            Below::Axis if self.upright => height + self.below_px().saturating_sub(3 * line),
            Below::Axis => height,
        }
    }

    /// How wide the plot itself is.
    fn inner_width(&self) -> u32 {
        let around = 2 * EDGE + self.left + self.right() + self.beside;
        self.format.width.saturating_sub(around).max(LEAST_WIDTH)
    }

    /// As many numbers along the axis of y as stand clear of each other.
    fn y_marks(&self) -> usize {
        let absent = match self.below {
            Below::Axis => 0,
            Below::Marks => 2 * line_height(self.format),
        };
        let around = absent + self.below_px() + self.format.text;
        let plot = self.height.saturating_sub(around);
        (plot / (2 * self.format.text)).clamp(2, Y_MARKS as u32) as usize
    }

    /// How wide is what must stand left of the plot.
    fn needed_left(&self) -> u32 {
        let axis = self.y.ranged(14, f64::INFINITY, &|_| 0.0);
        let marks = axis.key_points(BoldPoints(Y_MARKS));
        let widths = marks
            .iter()
            .map(|mark| self.format.width_of(&self.y.text(*mark)));
        let widest = widths.fold(0.0, f64::max) as u32;
        let label = if self.above.is_empty() {
            self.format.text * 3 / 2
        } else {
            0
        };
        widest.max(2 * self.format.text) + 3 * TICK + label
    }

    fn right(&self) -> u32 {
        self.format.text * 3 / 2
    }

    /// How high is what stands below the plot.
    fn below_px(&self) -> u32 {
        let line = line_height(self.format);
        let label = if self.x.label.is_empty() { 0 } else { line };
        match &self.x.scale {
            _ if self.below == Below::Marks => 2 * TICK,
            Scale::Names(names) if self.upright => {
                let widths = names.iter().map(|name| self.format.width_of(name));
                widths.fold(0.0, f64::max).min(LONGEST_NAME) as u32 + line + label
            }
            _ => line + 2 * TICK + label,
        }
    }

    /// Whether names that are too many to stand side by side have room upright.
    fn needs_upright_names(&self) -> bool {
        let Scale::Names(names) = &self.x.scale else {
            return false;
        };
        let each = f64::from(self.inner_width()) / names.len().max(1) as f64;
        let widest = names.iter().map(|name| self.format.width_of(name));
        let letter = self.format.width_of("m");
        widest.fold(0.0, f64::max) + letter > each && 1.1 * f64::from(self.format.text) < each
    }

    pub(crate) fn svg(&self) -> Result<String, DrawError> {
        let mut svg = String::new();
        let (width, height) = (self.format.width * FINE, self.height() * FINE);
        {
            let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
            area.fill(&WHITE).map_err(plot_failed)?;
            let edge = EDGE * FINE;
            let area = area.margin(edge, edge, edge, edge);
            let line = line_height(self.format) * FINE;
            let (head, below) = area.split_vertically(self.legend.rows() * line);
            self.legend.rows_in(&head)?;
            let (head, below) = below.split_vertically(self.above.len() as u32 * line);
            for (i, text) in self.above.iter().enumerate() {
                let place = (0, (line * i as u32 + line / 2) as i32);
                let style = font(self.format).pos(Pos::new(HPos::Left, VPos::Center));
                head.draw(&Text::new(text.as_str(), place, style))
                    .map_err(plot_failed)?;
            }
            let (plot, side) =
                below.split_horizontally((self.format.width - 2 * EDGE - self.beside) * FINE);
            self.legend.column_in(&side)?;
            let mut builder = ChartBuilder::on(&plot);
            builder
                .margin_top(self.format.text * FINE * 2 / 3)
                .margin_bottom(4 * FINE)
                .margin_right(self.right() * FINE)
                .x_label_area_size(self.below_px() * FINE)
                .y_label_area_size(self.left * FINE);
            if !self.title.is_empty() {
                let size = 1.24 * f64::from(self.format.text * FINE);
                builder.caption(&self.title, ("sans-serif", size));
            }
            let marks = if self.format.is_narrow() { 7 } else { 14 };
            let room = if self.upright {
                f64::INFINITY
            } else {
                f64::from(self.inner_width())
            };
            let names = |name: &str| self.format.width_of(name);
            let chart = builder
                .build_cartesian_2d(
                    self.x.ranged(marks, room, &names),
                    self.y.ranged(2 * self.y_marks(), f64::INFINITY, &names),
                )
                .map_err(plot_failed)?;
            self.draw(chart, &plot)?;
            area.present().map_err(plot_failed)?;
        }
        // In a page the figure takes the width there is.
        Ok(svg.replacen(
            &format!("width=\"{width}\" height=\"{height}\""),
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
        area: &DrawingArea<SVGBackend<'b>, Shift>,
    ) -> Result<(), DrawError> {
        let font = font(self.format);
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
            _ if self.format.is_narrow() => 5,
            _ => 9,
        };
        let text = |place: &f64| match self.upright || self.below == Below::Marks {
            true => String::new(),
            false => self.x.text(*place),
        };
        let mut mesh = chart.configure_mesh();
        if self.above.is_empty() {
            mesh.y_desc(&self.y.label);
        }
        if self.below == Below::Axis {
            mesh.x_desc(&self.x.label);
        }
        mesh.x_labels(x_labels)
            .y_labels(self.y_marks())
            .set_all_tick_mark_size(TICK * FINE)
            .x_label_formatter(&text)
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
        if let (Scale::Names(names), true, Below::Axis) = (&self.x.scale, self.upright, self.below)
        {
            let (left, top) = area.get_base_pixel();
            let style = font
                .transform(FontTransform::Rotate270)
                .pos(Pos::new(HPos::Right, VPos::Center));
            for (i, name) in names.iter().enumerate() {
                let (x, y) = chart.backend_coord(&(i as f64, self.y.place(self.y.low)));
                let place = (x - left, y - top + 2 * (TICK * FINE) as i32);
                let name = self.format.cut(name, LONGEST_NAME);
                area.draw(&Text::new(name, place, style.clone()))
                    .map_err(plot_failed)?;
            }
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
        let size = self.format.text as i32;
        let (wide, high) = (size * 3 / 5 * fine, size * fine);
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
            let radius = match (line.weight, line.mark) {
                (Weight::Thick, _) => 7 * fine,
                (Weight::Thin, Mark::Dots) => 5 * fine / 2,
                _ => 4 * fine,
            };
            let dots = inside
                .iter()
                .map(|point| Circle::new(*point, radius, colour(line.tone).filled()));
            chart.draw_series(dots).map_err(plot_failed)?;
        }
        // A narrow figure shows no more points than a wide one.
        let most = MOST_POINTS * self.format.width as usize / WIDTH as usize;
        match line.mark {
            Mark::Dots => {}
            Mark::Dashed => {
                chart
                    .draw_series(DashedLineSeries::new(
                        extremes(inside, most),
                        9 * FINE,
                        5 * FINE,
                        style,
                    ))
                    .map_err(plot_failed)?;
            }
            Mark::Line | Mark::Joined => {
                chart
                    .draw_series(LineSeries::new(extremes(inside, most), style))
                    .map_err(plot_failed)?;
            }
        }
        Ok(())
    }
}

pub(crate) fn plot_failed<E: std::error::Error + Send + Sync>(
    error: DrawingAreaErrorKind<E>,
) -> DrawError {
    DrawError::Drawing {
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::figure::{Axis, Tone};

    /// The sizes of all texts, in units of the drawing, and how often `part` stands in it.
    fn sizes(svg: &str) -> Vec<f64> {
        let parts = svg.split("font-size=\"").skip(1);
        parts
            .map(|part| part.split('"').next().unwrap().parse::<f64>().unwrap() / f64::from(FINE))
            .collect()
    }

    fn over_names(count: usize, lines: usize) -> Chart {
        let names = (1..=count).map(|i| format!("sample {i}")).collect();
        let points: Vec<(f64, f64)> = (0..count).map(|i| (i as f64, 1.0)).collect();
        let line = |i: usize| Line::new(format!("line {i}"), Tone::Main, points.clone());
        let lines = (0..lines).map(|i| line(i).marked(Mark::Dots)).collect();
        Chart::new(
            Axis::names("sample", names),
            Axis::new("quantity, in u", 0.0, 2.0),
            lines,
        )
    }

    /// A page shows the wide format from 620 px on and the narrow one below: no text is below 11 px in either.
    #[test]
    fn texts_are_readable_wherever_a_format_is_shown() {
        let chart = over_names(14, 12);
        for (format, shown) in [(Format::WIDE, 620.0), (Format::NARROW, 300.0)] {
            let svg = Plot::new(&chart, format, HEIGHT).svg().unwrap();
            let sizes = sizes(&svg);
            assert!(sizes.len() > 20);
            for size in sizes {
                let drawn = size * shown / f64::from(format.width);
                assert!(drawn > 10.9, "{drawn} px");
            }
        }
        let both = svg(&chart, HEIGHT).unwrap();
        assert_eq!(both.matches("<svg").count(), 2);
        assert!(both.contains("class=\"wide-format\"") && both.contains("class=\"narrow-format\""));
    }

    /// All names are there, upright where they do not fit side by side; only what fits in no way is left out.
    #[test]
    fn names_stand_upright_where_they_do_not_fit() {
        let drawn = |count: usize, format: Format| {
            let chart = over_names(count, 1);
            let svg = Plot::new(&chart, format, HEIGHT).svg().unwrap();
            (
                svg.matches("\nsample ").count(),
                svg.matches("rotate(270").count(),
            )
        };
        // The label of y is upright too in the wide format; in the narrow one it stands above.
        assert_eq!(drawn(3, Format::WIDE), (3, 1));
        assert_eq!(drawn(14, Format::WIDE), (14, 15));
        assert_eq!(drawn(3, Format::NARROW), (3, 0));
        assert_eq!(drawn(14, Format::NARROW), (14, 14));
        let (shown, upright) = drawn(60, Format::NARROW);
        assert!(shown > 2 && shown < 20 && upright == 0, "{shown}");
    }

    /// Every line is named once, beside the chart or above it, however many there are.
    #[test]
    fn a_legend_names_every_line() {
        for count in [2, 8, 40] {
            for format in [Format::WIDE, Format::NARROW] {
                let chart = over_names(2, count);
                let plot = Plot::new(&chart, format, HEIGHT);
                let svg = plot.svg().unwrap();
                assert_eq!(svg.matches("\nline ").count(), count);
                let beside = plot.legend.width() > 0;
                assert_eq!(beside, !format.is_narrow() && count == 8, "{count}");
                assert_eq!(beside, plot.legend.rows() == 0);
            }
        }
    }
}
