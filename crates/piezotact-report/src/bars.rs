//! An association matrix as bars on a plane seen from above and the front, as SVG text (thesis figures 26 and 55).

use std::fmt::Write as _;

use piezotact::figure::{Matrix, Shade, Square};

use crate::alternative;
use crate::format::{Format, both};
use crate::image::escaped;

const INK: &str = "#464e56";
/// The three visible faces of an expected bar and of another: top, left, right.
const EXPECTED: [&str; 3] = ["#3d8fa3", "#005468", "#1b6d81"];
const OTHER: [&str; 3] = ["#e07a80", "#a01824", "#be3440"];
/// The side of a bar, of its tile.
const BAR: f64 = 0.7;

/// The bars in both formats.
pub(crate) fn svg(matrix: &Matrix) -> String {
    let drawn: Result<String, std::convert::Infallible> = both(&alternative(matrix), |format| {
        Ok(View::of(matrix, format).drawn(matrix))
    });
    drawn.unwrap_or_else(|never| match never {})
}

fn alternative(matrix: &Matrix) -> String {
    alternative::matrix(
        &format!("{}, as bars", matrix.scale_label),
        (&matrix.row_label, &matrix.rows),
        (&matrix.column_label, &matrix.columns),
    )
}

/// The percentage of a square, where it has one.
fn percent(square: &Square) -> Option<f64> {
    match square.shade {
        Shade::Percent(percent) => Some(percent),
        _ => None,
    }
}

/// How the plane is seen: columns run to the lower right, rows to the upper right, so that the diagonal lies across.
struct View {
    format: Format,
    origin: (f64, f64),
    /// Right and down from one tile to the next.
    step: (f64, f64),
    /// How high 100 % is.
    full: f64,
    rows: usize,
    height: f64,
}

impl View {
    fn of(matrix: &Matrix, format: Format) -> Self {
        let (rows, columns) = (matrix.rows.len() as f64, matrix.columns.len() as f64);
        let names = matrix.rows.iter();
        let longest = names
            .chain(&matrix.columns)
            .map(|name| format.width_of(name));
        let room = longest
            .fold(0.0, f64::max)
            .min(0.25 * f64::from(format.width))
            + format.em(1.0);
        let across = (f64::from(format.width) - 2.0 * room) / (rows + columns).max(1.0);
        let across = across.min(format.em(3.5));
        let step = (across, 0.5 * across);
        let full = format.em(6.0);
        let middle = f64::from(format.width) / 2.0 + (rows - columns) * across / 2.0;
        Self {
            format,
            origin: (middle, full + format.em(1.5)),
            step,
            full,
            rows: matrix.rows.len(),
            height: full + format.em(5.0) + (rows + columns) * step.1,
        }
    }

    /// Where a row stands, from the back.
    fn place(&self, row: usize) -> f64 {
        (self.rows - 1 - row) as f64
    }

    fn at(&self, column: f64, row: f64, percent: f64) -> (f64, f64) {
        (
            self.origin.0 + (column - row) * self.step.0,
            self.origin.1 + (column + row) * self.step.1 - percent / 100.0 * self.full,
        )
    }

    fn face(&self, corners: &[(f64, f64, f64)], fill: &str) -> String {
        let corners = corners.iter().map(|(column, row, percent)| {
            let (x, y) = self.at(*column, *row, *percent);
            format!("{x:.1},{y:.1}")
        });
        let corners: Vec<String> = corners.collect();
        format!(
            "\n<polygon points=\"{}\" fill=\"{fill}\" stroke=\"#ffffff\" stroke-width=\"0.4\"/>",
            corners.join(" ")
        )
    }

    fn drawn(&self, matrix: &Matrix) -> String {
        let (width, height) = (f64::from(self.format.width), self.height);
        let size = self.format.text;
        let mut svg = format!(
            "<svg role=\"img\" viewBox=\"0 0 {width} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"{size}\" fill=\"{INK}\">\n<rect width=\"{width}\" height=\"{height:.0}\" fill=\"#ffffff\"/>"
        );
        for (i, row) in matrix.squares.iter().enumerate() {
            for (j, square) in row.iter().enumerate() {
                let (r, c) = (self.place(i), j as f64);
                let tile = [
                    (c, r, 0.0),
                    (c + 1.0, r, 0.0),
                    (c + 1.0, r + 1.0, 0.0),
                    (c, r + 1.0, 0.0),
                ];
                let fill = if square.shade != Shade::Untested {
                    "#eff5f6"
                } else {
                    "#c4c9ce"
                };
                svg.push_str(&self.face(&tile, fill));
            }
        }
        // From the back to the front.
        for (i, row) in matrix.squares.iter().enumerate().rev() {
            for (j, square) in row.iter().enumerate() {
                let faces = match square.outlined {
                    true => EXPECTED,
                    false => OTHER,
                };
                if let Some(percent) = percent(square).filter(|percent| *percent > 0.0) {
                    svg.push_str(&self.bar((j as f64, self.place(i)), percent, faces));
                }
            }
        }
        svg.push_str(&self.names(matrix, f64::from(size)));
        svg + "\n</svg>"
    }

    fn bar(
        &self,
        (column, row): (f64, f64),
        percent: f64,
        [top, left, right]: [&str; 3],
    ) -> String {
        let edge = (1.0 - BAR) / 2.0;
        let (c, r, d, s) = (
            column + edge,
            row + edge,
            column + 1.0 - edge,
            row + 1.0 - edge,
        );
        let p = percent;
        [
            self.face(&[(c, s, 0.0), (d, s, 0.0), (d, s, p), (c, s, p)], left),
            self.face(&[(d, r, 0.0), (d, s, 0.0), (d, s, p), (d, r, p)], right),
            self.face(&[(c, r, p), (d, r, p), (d, s, p), (c, s, p)], top),
        ]
        .concat()
    }

    /// The names along the two front sides, as many as have room, and what the sides are.
    fn names(&self, matrix: &Matrix, size: f64) -> String {
        let (rows, columns) = (matrix.rows.len(), matrix.columns.len());
        let every = ((1.05 * size / self.step.1).ceil() as usize).max(1);
        let mut svg = String::new();
        let mut text = |(x, y): (f64, f64), anchor: &str, text: &str| {
            let _never_fails = write!(
                svg,
                "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
                escaped(text)
            );
        };
        let room = 0.25 * f64::from(self.format.width);
        for (j, name) in matrix.columns.iter().enumerate().step_by(every) {
            let (x, y) = self.at(j as f64 + 0.5, rows as f64, 0.0);
            text((x - 3.0, y + size), "end", &self.format.cut(name, room));
        }
        for (i, name) in matrix.rows.iter().enumerate().step_by(every) {
            let (x, y) = self.at(columns as f64, self.place(i) + 0.5, 0.0);
            text((x + 3.0, y + size), "start", &self.format.cut(name, room));
        }
        let (x, y) = self.at(0.5 * columns as f64, rows as f64, 0.0);
        let below = y + size + self.format.em(2.0);
        text(
            (x - self.format.em(3.0), below),
            "end",
            &matrix.column_label,
        );
        let (x, _) = self.at(columns as f64, 0.5 * rows as f64, 0.0);
        text((x + self.format.em(3.0), below), "start", &matrix.row_label);
        svg
    }
}
