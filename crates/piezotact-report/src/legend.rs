//! The legend of a chart: in rows above it, or in a column beside it. It never covers what is drawn.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use piezotact::figure::{Legend, Line, Mark};

use crate::DrawError;
use crate::chart::{EDGE, FINE, font, half_pixels, line_height, plot_failed};
use crate::colour::colour;
use crate::format::Format;

/// More labelled lines than this have their legend beside a wide chart.
const MOST_ABOVE: usize = 4;
/// What stands before a name, and after it.
const MARK: u32 = 32;
const AFTER: u32 = 18;
/// The least and the largest width of a column.
const NARROWEST: u32 = 110;
const WIDEST: u32 = 280;

/// A legend in its place.
pub(crate) struct Place<'l> {
    format: Format,
    /// Rows above the chart: each line with where it begins.
    rows: Vec<Vec<(u32, &'l Line)>>,
    column: Vec<&'l Line>,
}

impl<'l> Place<'l> {
    /// Beside the chart where it is `wanted` there or there are many `lines`, and the format and the `height` have room.
    pub(crate) fn of(lines: Vec<&'l Line>, format: Format, wanted: Legend, height: u32) -> Self {
        let fits = line_height(format) * lines.len() as u32 + 2 * format.text <= height;
        if !format.is_narrow()
            && fits
            && !lines.is_empty()
            && (wanted == Legend::Beside || lines.len() > MOST_ABOVE)
        {
            return Self {
                format,
                rows: Vec::new(),
                column: lines,
            };
        }
        let mut rows: Vec<Vec<(u32, &Line)>> = Vec::new();
        let room = format.width - 2 * EDGE;
        let mut next = room;
        for line in lines {
            let width = MARK + format.width_of(&line.label) as u32;
            if next + width > room {
                rows.push(Vec::new());
                next = 0;
            }
            if let Some(row) = rows.last_mut() {
                row.push((next, line));
            }
            next += width + AFTER;
        }
        Self {
            format,
            rows,
            column: Vec::new(),
        }
    }

    /// How many rows stand above the chart.
    pub(crate) fn rows(&self) -> u32 {
        self.rows.len() as u32
    }

    /// How wide the column beside the chart is: as the longest name needs.
    pub(crate) fn width(&self) -> u32 {
        let widths = self.column.iter();
        let widest = widths.map(|line| MARK + self.format.width_of(&line.label) as u32 + 8);
        widest
            .max()
            .map_or(0, |width| width.clamp(NARROWEST, WIDEST))
    }

    pub(crate) fn rows_in(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
    ) -> Result<(), DrawError> {
        let line_px = line_height(self.format);
        for (i, row) in self.rows.iter().enumerate() {
            let y = line_px * i as u32 + line_px / 2;
            for (x, line) in row {
                self.entry(area, (*x, y), self.format.width - 2 * EDGE - x, line)?;
            }
        }
        Ok(())
    }

    pub(crate) fn column_in(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
    ) -> Result<(), DrawError> {
        for (i, line) in self.column.iter().enumerate() {
            let y = self.format.text + line_height(self.format) * i as u32;
            self.entry(area, (0, y), self.width(), line)?;
        }
        Ok(())
    }

    /// A line as it is drawn, and its name, cut where its room ends.
    fn entry(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        (x, y): (u32, u32),
        room: u32,
        line: &Line,
    ) -> Result<(), DrawError> {
        let fine = FINE as i32;
        let at = |along: u32| ((x + along) as i32 * fine, y as i32 * fine);
        let style = colour(line.tone).stroke_width(half_pixels(line.weight) * FINE / 2);
        let dash = |from: u32, to: u32| PathElement::new([at(from), at(to)], style);
        let dashes: &[(u32, u32)] = match line.mark {
            Mark::Dashed => &[(0, 9), (14, 23)],
            Mark::Line | Mark::Joined => &[(0, 23)],
            Mark::Dots => &[],
        };
        for (from, to) in dashes {
            area.draw(&dash(*from, *to)).map_err(plot_failed)?;
        }
        if matches!(line.mark, Mark::Dots | Mark::Joined) {
            let dot = Circle::new(at(12), 4 * fine, colour(line.tone).filled());
            area.draw(&dot).map_err(plot_failed)?;
        }
        let style = font(self.format).pos(Pos::new(HPos::Left, VPos::Center));
        let label = self
            .format
            .cut(&line.label, f64::from(room.saturating_sub(MARK)));
        area.draw(&Text::new(label, at(MARK - 2), style))
            .map_err(plot_failed)
    }
}
