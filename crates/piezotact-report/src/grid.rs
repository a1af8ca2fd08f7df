//! A matrix of percentages as squares with their numbers, as SVG text. Untested squares are hatched, so that none looks like 0 %.

use std::fmt::Write as _;

use piezotact::figure::{Matrix, Shade, Square};

use crate::alternative;
use crate::format::{Format, both};
use crate::image::escaped;

const INK: &str = "#464e56";
const LINE: &str = "#969ea6";
/// White at 0 %, this at 100 %.
const FULL: [f64; 3] = [0.0, 84.0, 104.0];
/// From this percentage on numbers are white.
const DARK: f64 = 50.0;

/// The colour of a percentage.
pub(crate) fn colour(percent: f64) -> String {
    let share = (percent / 100.0).clamp(0.0, 1.0);
    let [r, g, b] = FULL.map(|full| (255.0 + share * (full - 255.0)).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// How a matrix is drawn.
pub(crate) struct Grid<'m>(pub(crate) &'m Matrix);

impl std::ops::Deref for Grid<'_> {
    type Target = Matrix;

    fn deref(&self) -> &Matrix {
        self.0
    }
}

impl Grid<'_> {
    /// For a page: in both formats.
    pub(crate) fn svg(&self) -> String {
        let drawn: Result<String, std::convert::Infallible> =
            both(&self.alternative(), |format| Ok(self.drawn(format)));
        drawn.unwrap_or_else(|never| match never {})
    }

    fn alternative(&self) -> String {
        alternative::matrix(
            &self.scale_label,
            (&self.row_label, &self.rows),
            (&self.column_label, &self.columns),
        )
    }

    fn drawn(&self, format: Format) -> String {
        let width = f64::from(format.width);
        let longest = |names: &[String]| {
            let widths = names.iter().map(|name| format.width_of(name));
            widths.fold(0.0, f64::max)
        };
        let left = format.em(2.2) + longest(&self.rows).min(0.3 * width) + format.em(0.5);
        let right = format.em(if format.is_narrow() { 0.5 } else { 6.5 });
        let count = self.columns.len().max(1) as f64;
        let side = ((width - left - right) / count).min(format.em(4.5));
        let high = side.min(format.em(2.6));
        let turned = longest(&self.columns) > side - format.em(0.2);
        let names = if turned {
            longest(&self.columns).min(format.em(9.0))
        } else {
            format.em(1.0)
        };
        let top = format.em(2.0) + names + format.em(0.6);
        let bottom = top + high * self.rows.len() as f64;
        let below = if format.is_narrow() { 3.0 } else { 1.0 };
        let height = (bottom + format.em(below)).max(top + format.em(12.0));
        let mut svg = format!(
            "<svg role=\"img\" viewBox=\"0 0 {width} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"{}\" fill=\"{INK}\">\n<rect width=\"{width}\" height=\"{height:.0}\" fill=\"#ffffff\"/>",
            format.text
        );
        let mut text = |x: f64, y: f64, anchor: &str, turn: bool, text: &str| {
            let turn = if turn {
                format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"")
            } else {
                String::new()
            };
            let _never_fails = write!(
                svg,
                "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{turn}>{}</text>",
                escaped(text)
            );
        };
        let middle = left + side * count / 2.0;
        text(middle, format.em(1.2), "middle", false, &self.column_label);
        let upright = (top + bottom) / 2.0;
        text(format.em(1.2), upright, "middle", true, &self.row_label);
        for (i, name) in self.columns.iter().enumerate() {
            let x = left + side * (i as f64 + 0.5);
            let name = format.cut(name, format.em(9.0));
            match turned {
                true => text(
                    x + format.em(0.35),
                    top - format.em(0.4),
                    "start",
                    true,
                    &name,
                ),
                false => text(x, top - format.em(0.5), "middle", false, &name),
            }
        }
        for (i, name) in self.rows.iter().enumerate() {
            let y = top + high * (i as f64 + 0.5) + format.em(0.35);
            let name = format.cut(name, 0.3 * width);
            text(left - format.em(0.5), y, "end", false, &name);
        }
        // Outlines stand above all squares.
        let mut outlines = String::new();
        for (i, row) in self.squares.iter().enumerate() {
            for (j, square) in row.iter().enumerate() {
                let at = (left + side * j as f64, top + high * i as f64);
                svg.push_str(&drawn_square(square, at, (side, high), format));
                if square.outlined {
                    let _never_fails = write!(
                        outlines,
                        "\n<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{side:.1}\" height=\"{high:.1}\" fill=\"none\" stroke=\"#1f262d\" stroke-width=\"2\"/>",
                        at.0, at.1
                    );
                }
            }
        }
        svg.push_str(&outlines);
        if format.is_narrow() {
            let y = bottom + format.em(1.6);
            let _never_fails = write!(
                svg,
                "\n<text x=\"{middle:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}: white 0, dark {:.0}</text>",
                escaped(&self.scale_label),
                self.darkest()
            );
        } else {
            svg.push_str(&self.scale(format, left + side * count + format.em(1.5), top));
        }
        svg + "\n</svg>"
    }

    /// The number that has the darkest colour: 100 %, or the largest count.
    fn darkest(&self) -> f64 {
        let counts = self.squares.iter().flatten();
        let mut counts = counts.filter_map(|square| match square.shade {
            Shade::Count(_, most) => Some(most as f64),
            _ => None,
        });
        counts.next().unwrap_or(100.0)
    }

    /// The scale of colours, and what hatching means.
    fn scale(&self, format: Format, left: f64, top: f64) -> String {
        let (bar, steps) = (format.em(8.0), 40);
        let each = bar / f64::from(steps);
        let mut svg = String::new();
        for step in 0..steps {
            let percent = 100.0 * (1.0 - (f64::from(step) + 0.5) / f64::from(steps));
            let _never_fails = write!(
                svg,
                "\n<rect x=\"{left:.1}\" y=\"{:.2}\" width=\"{:.1}\" height=\"{:.2}\" fill=\"{}\"/>",
                top + each * f64::from(step),
                format.em(1.2),
                each + 0.5,
                colour(percent)
            );
        }
        let _never_fails = write!(
            svg,
            "\n<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{bar:.1}\" fill=\"none\" stroke=\"{LINE}\"/>",
            format.em(1.2)
        );
        let full = self.darkest();
        // Counts have no halves.
        let marks = [0.0, 0.5, 1.0].map(|share| share * full);
        for mark in marks.iter().filter(|mark| mark.fract() == 0.0) {
            let y = top + bar * (1.0 - mark / full) + format.em(0.35);
            let x = left + format.em(1.6);
            let _never_fails = write!(svg, "\n<text x=\"{x:.1}\" y=\"{y:.1}\">{mark}</text>");
        }
        let (x, y) = (left + format.em(4.4), top + bar / 2.0);
        let _never_fails = write!(
            svg,
            "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\">{}</text>",
            escaped(&self.scale_label)
        );
        let squares = || self.squares.iter().flatten();
        if squares().any(|square| square.shade == Shade::Untested) {
            let at = (left, top + bar + format.em(1.0));
            let size = (format.em(1.2), format.em(1.2));
            svg.push_str(&hatched(at, size));
            let _never_fails = write!(
                svg,
                "\n<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                left,
                at.1 + format.em(2.4),
                escaped(&self.untested_label)
            );
        }
        svg
    }
}

/// The colour of a count as a percentage of the largest.
fn count_percent(count: usize, most: usize) -> f64 {
    100.0 * count as f64 / most.max(1) as f64
}

/// A square that was not tested.
fn hatched((x, y): (f64, f64), (width, height): (f64, f64)) -> String {
    let mut lines = String::new();
    let parts = 4;
    for i in 1..=2 * parts {
        let share = f64::from(i) / f64::from(parts);
        // From the left or lower side to the upper or right one.
        let (x1, y1) = match share <= 1.0 {
            true => (x, y + share * height),
            false => (x + (share - 1.0) * width, y + height),
        };
        let (x2, y2) = match share <= 1.0 {
            true => (x + share * width, y),
            false => (x + width, y + (share - 1.0) * height),
        };
        let _never_fails = write!(lines, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
    }
    format!(
        "\n<rect class=\"untested\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"#eef0f2\" stroke=\"{LINE}\" stroke-width=\"0.5\"/>\n<path d=\"{lines}\" stroke=\"#b4bac0\" stroke-width=\"1\" fill=\"none\"/>"
    )
}

fn drawn_square(
    square: &Square,
    (x, y): (f64, f64),
    (width, height): (f64, f64),
    format: Format,
) -> String {
    let fill = match square.shade {
        Shade::Untested => return hatched((x, y), (width, height)),
        Shade::Blank => "#ffffff".to_owned(),
        Shade::Percent(percent) => colour(percent),
        Shade::Count(count, most) => colour(count_percent(count, most)),
    };
    let mut svg = format!(
        "\n<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{fill}\" stroke=\"{LINE}\" stroke-width=\"0.5\"/>"
    );
    let has_room = width >= format.width_of("100") + format.em(0.2);
    let number = match square.shade {
        Shade::Percent(percent) => Some((percent, format!("{percent:.0}"))),
        Shade::Count(count, most) => Some((count_percent(count, most), count.to_string())),
        Shade::Untested | Shade::Blank => None,
    };
    if let (Some((percent, number)), true) = (number, has_room) {
        let ink = if percent >= DARK { "#ffffff" } else { INK };
        let _never_fails = write!(
            svg,
            "\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{ink}\">{number}</text>",
            x + width / 2.0,
            y + height / 2.0 + format.em(0.35)
        );
    }
    if square.dotted {
        let _never_fails = write!(
            svg,
            "\n<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"#be1e2d\"/>",
            x + width - format.em(0.35),
            y + format.em(0.35),
            format.em(0.18)
        );
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn untested_is_drawn_apart_from_0_percent() {
        let square = |shade| Square {
            shade,
            outlined: false,
            dotted: false,
        };
        let matrix = Matrix {
            rows: vec!["<a>".into(), "b".into()],
            columns: vec!["<a>".into(), "b".into()],
            squares: vec![
                vec![square(Shade::Percent(0.0)), square(Shade::Untested)],
                vec![square(Shade::Blank), square(Shade::Percent(66.7))],
            ],
            row_label: "presented".into(),
            column_label: "declared as".into(),
            scale_label: "association, %".into(),
            untested_label: "untested".into(),
        };
        let svg = Grid(&matrix).drawn(Format::WIDE);
        assert!(svg.contains(">0</text>") && svg.contains(">67</text>"));
        // One square and one in the legend.
        assert_eq!(svg.matches("class=\"untested\"").count(), 2);
        assert!(svg.contains("&lt;a&gt;") && !svg.contains("<a>"));
    }

    #[test]
    fn counts_have_their_own_scale() {
        let square = |count| Square {
            shade: match count {
                0 => Shade::Untested,
                count => Shade::Count(count, 3),
            },
            outlined: false,
            dotted: false,
        };
        let matrix = Matrix {
            rows: vec!["a".into()],
            columns: vec!["a".into(), "b".into(), "c".into()],
            squares: vec![vec![square(0), square(1), square(3)]],
            row_label: String::new(),
            column_label: String::new(),
            scale_label: "sets".into(),
            untested_label: "never".into(),
        };
        let svg = Grid(&matrix).drawn(Format::WIDE);
        // The squares, and the ends of the scale; 1.5 sets are no mark.
        assert_eq!(svg.matches(">3</text>").count(), 2);
        assert_eq!(svg.matches(">1</text>").count(), 1);
        assert!(!svg.contains(">100<") && !svg.contains(">1.5<"));
        assert!(svg.contains(&colour(100.0)) && svg.contains(">never</text>"));
    }
}
