//! Changes around 0 as images: on heads from above, and over two quantities; one diverging scale of colours for all.

use piezotact::figure::{Axis, MapGround, MapPanel, Maps};

use crate::DrawError;
use crate::alternative;
use crate::format::{Format, both};
use crate::image::{Colours, Image, Svg, ticks};

/// Around the panels, in heights of a text: labels and ticks on the left and below, a title above, room between.
const LEFT: f64 = 5.0;
const BELOW: f64 = 3.6;
const ABOVE: f64 = 2.2;
const BETWEEN: f64 = 1.4;
const GAP: f64 = 1.2;
/// Above heads, for the nose.
const NOSE: f64 = 0.9;
/// The largest side of a head, of the width of a figure.
const HEAD: f64 = 0.3;
/// The height of a panel with axes, in heights of a text.
const HIGH: f64 = 11.0;
const TALLEST_BAR: f64 = 300.0;

/// Maps in both formats as SVG text that takes the width there is.
///
/// # Errors
/// [`DrawError`] where an image cannot be made.
pub(crate) fn svg(maps: &Maps) -> Result<String, DrawError> {
    both(&alternative::maps(maps), |format| drawn(maps, format))
}

fn drawn(maps: &Maps, format: Format) -> Result<String, DrawError> {
    let layout = Layout::of(maps, format);
    let height = layout.height();
    let mut svg = Svg::new(format, height);
    svg.background(height);
    for (i, panel) in maps.panels.iter().enumerate() {
        layout.panel(&mut svg, maps, i, panel)?;
    }
    let tall = (layout.bottom() - format.em(ABOVE)).min(TALLEST_BAR);
    let top = 0.5 * (format.em(ABOVE) + layout.bottom() - tall);
    svg.colour_bar(
        (layout.right() + format.em(GAP), top),
        tall,
        (-maps.reach, maps.reach),
        Colours::Diverging,
        &maps.label,
    );
    Ok(svg.finish())
}

/// Where panels stand: the same size each, in rows.
struct Layout {
    format: Format,
    count: usize,
    across: usize,
    left: f64,
    size: (f64, f64),
    above: f64,
    /// Below each row, for the ticks and labels of axes.
    below: f64,
}

impl Layout {
    fn of(maps: &Maps, format: Format) -> Self {
        let count = maps.panels.len().max(1);
        let heads = matches!(
            maps.panels.first().map(|panel| &panel.ground),
            Some(MapGround::Head { .. })
        );
        let most = match (format.is_narrow(), heads) {
            (false, _) => 3,
            (true, true) => 2,
            (true, false) => 1,
        };
        let across = count.min(most);
        let left = format.em(if heads { 0.6 } else { LEFT });
        let around = left + format.em(GAP) + format.scale_width();
        let width = f64::from(format.width);
        let between = format.em(BETWEEN) * (across - 1) as f64;
        let room = (width - around - between) / across as f64;
        let size = match heads {
            true => {
                let side = room.min(HEAD * width.max(600.0));
                (side, side)
            }
            false => (room, format.em(HIGH)),
        };
        Self {
            format,
            count,
            across,
            // What is left over stands on both sides.
            left: left + 0.5 * (room - size.0) * across as f64,
            size,
            above: format.em(ABOVE + if heads { NOSE } else { 0.0 }),
            below: format.em(if heads { 0.0 } else { BELOW }),
        }
    }

    fn down(&self) -> usize {
        self.count.div_ceil(self.across)
    }

    /// The left and the top of panel `i`.
    fn place(&self, i: usize) -> (f64, f64) {
        let (column, row) = ((i % self.across) as f64, (i / self.across) as f64);
        (
            self.left + (self.size.0 + self.format.em(BETWEEN)) * column,
            self.above + (self.size.1 + self.above + self.below) * row,
        )
    }

    fn right(&self) -> f64 {
        self.place(self.across - 1).0 + self.size.0
    }

    /// Where the lowest panels end.
    fn bottom(&self) -> f64 {
        self.place((self.down() - 1) * self.across).1 + self.size.1
    }

    fn height(&self) -> f64 {
        self.bottom() + self.below + self.format.em(0.8)
    }

    fn panel(
        &self,
        svg: &mut Svg,
        maps: &Maps,
        i: usize,
        panel: &MapPanel,
    ) -> Result<(), DrawError> {
        let (left, top) = self.place(i);
        let image = Image {
            values: &panel.values,
            columns: panel.columns,
            scale: (-maps.reach, maps.reach),
            colours: Colours::Diverging,
        };
        let title = self.format.cut(&panel.title, self.size.0);
        let above = top - self.above + self.format.em(1.3);
        svg.text((left + 0.5 * self.size.0, above), "middle", &title);
        match &panel.ground {
            MapGround::Head { electrodes, radius } => {
                self.head(svg, (left, top), electrodes, *radius, &image)
            }
            MapGround::Axes {
                x,
                y,
                marked,
                outlined,
            } => {
                svg.missing((left, top), self.size);
                svg.image((left, top), self.size, &image)?;
                let frame = Frame {
                    at: (left, top),
                    size: self.size,
                    x,
                    y,
                };
                frame.marks(svg, marked, outlined);
                frame.ticks(svg, Side::of(i % self.across));
                Ok(())
            }
        }
    }

    fn head(
        &self,
        svg: &mut Svg,
        (left, top): (f64, f64),
        electrodes: &[(f64, f64, String)],
        radius: f64,
        image: &Image<'_>,
    ) -> Result<(), DrawError> {
        let half = 0.5 * self.size.0;
        let (x, y) = (left + half, top + half);
        let ring = radius * half;
        svg.disc((x, y), ring);
        svg.image((left, top), self.size, image)?;
        svg.ring((x, y), ring);
        let nose = [(-0.09, 0.99), (0.0, 1.12), (0.09, 0.99)];
        let nose = nose.map(|(dx, dy)| (x + dx * ring, y - dy * ring));
        svg.path(&nose);
        for side in [-1.0, 1.0] {
            let ear = [(0.99, 0.14), (1.05, 0.1), (1.05, -0.1), (0.99, -0.14)];
            svg.path(&ear.map(|(dx, dy)| (x + side * dx * ring, y - dy * ring)));
        }
        let dot = (0.011 * self.size.0).clamp(1.2, 2.6);
        for (right, front, name) in electrodes {
            svg.dot((x + right * half, y - front * half), dot, name);
        }
        Ok(())
    }
}

/// Where a panel stands in its row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// It is the first.
    First,
    /// It stands beside another.
    Beside,
}

impl Side {
    fn of(column: usize) -> Self {
        match column {
            0 => Self::First,
            _ => Self::Beside,
        }
    }
}

/// About `count` round numbers from `low` to `high`, and more where they would be one or two: a scale cannot be read from them.
fn at_least_three(low: f64, high: f64, count: f64) -> Vec<f64> {
    let more = (0..6).map(|further| ticks(low, high, count.max(2.0) + f64::from(further)));
    let mut more = more.into_iter();
    more.find(|ticks| ticks.len() > 2)
        .unwrap_or_else(|| ticks(low, high, count))
}

/// A panel with axes.
struct Frame<'a> {
    at: (f64, f64),
    size: (f64, f64),
    x: &'a Axis,
    y: &'a Axis,
}

impl Frame<'_> {
    fn across(&self, value: f64) -> f64 {
        let share = (value - self.x.low) / (self.x.high - self.x.low);
        self.at.0 + self.size.0 * share.clamp(0.0, 1.0)
    }

    fn up(&self, value: f64) -> f64 {
        let share = (self.y.high - value) / (self.y.high - self.y.low);
        self.at.1 + self.size.1 * share.clamp(0.0, 1.0)
    }

    fn marks(&self, svg: &mut Svg, marked: &[f64], outlined: &[[f64; 4]]) {
        let bottom = self.at.1 + self.size.1;
        svg.frame(self.at, self.size);
        for x in marked
            .iter()
            .filter(|x| **x >= self.x.low && **x <= self.x.high)
        {
            svg.path(&[(self.across(*x), self.at.1), (self.across(*x), bottom)]);
        }
        for [x1, x2, y1, y2] in outlined {
            let (left, right) = (self.across(*x1), self.across(*x2));
            let (low, high) = (self.up(*y1), self.up(*y2));
            svg.path(&[
                (left, low),
                (right, low),
                (right, high),
                (left, high),
                (left, low),
            ]);
        }
    }

    /// Ticks and labels: of y where the panel is the first of its row.
    fn ticks(&self, svg: &mut Svg, side: Side) {
        let bottom = self.at.1 + self.size.1;
        for tick in at_least_three(self.x.low, self.x.high, self.size.0 / svg.em(3.6)) {
            svg.mark_below(self.across(tick), bottom, tick);
        }
        let middle = (self.at.0 + 0.5 * self.size.0, bottom + svg.em(2.9));
        svg.text(middle, "middle", &self.x.label);
        if side == Side::First {
            for tick in ticks(self.y.low, self.y.high, self.size.1 / svg.em(2.6)) {
                svg.mark_left(self.at.0, self.up(tick), tick);
            }
            let place = (
                self.at.0 - svg.em(LEFT - 1.1),
                self.at.1 + 0.5 * self.size.1,
            );
            svg.upright(place, &self.y.label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(title: &str) -> MapPanel {
        MapPanel {
            title: title.into(),
            values: vec![-10.0, 0.0, f64::NAN, 5.0],
            columns: 2,
            ground: MapGround::Head {
                electrodes: vec![(-0.4, 0.1, "C3".into()), (0.4, 0.1, "C4".into())],
                radius: 0.8,
            },
        }
    }

    #[test]
    fn heads_share_a_scale_around_0() {
        let maps = Maps::around_zero(
            "ERD/ERS, %",
            vec![head("<a>"), head("b"), head("c"), head("d")],
        );
        assert!((maps.reach - 10.0).abs() < 1e-12);
        let drawn = drawn(&maps, Format::WIDE).unwrap();
        assert_eq!(drawn.matches("<image").count(), 4);
        assert_eq!(drawn.matches("<title>C3</title>").count(), 4);
        assert_eq!(drawn.matches(">ERD/ERS, %<").count(), 1);
        assert!(drawn.contains(">−10<") && drawn.contains(">10<") && drawn.contains("&lt;a&gt;"));
        assert!(svg(&maps).unwrap().contains("narrow-format"));
    }

    #[test]
    fn panels_with_axes_have_marks_and_outlines() {
        let panel = MapPanel {
            title: "C3".into(),
            values: vec![1.0, 2.0, -3.0, 0.5],
            columns: 2,
            ground: MapGround::Axes {
                x: Axis::new("time, s", -1.0, 1.0),
                y: Axis::new("frequency, Hz", 5.0, 15.0),
                marked: vec![0.0, 7.0],
                outlined: vec![[0.0, 0.8, 8.0, 12.0]],
            },
        };
        let maps = Maps::around_zero("dB", vec![panel.clone(), panel]);
        let drawn = drawn(&maps, Format::WIDE).unwrap();
        // One mark is beyond the axis; one outline in each panel.
        assert_eq!(drawn.matches("<polyline").count(), 4);
        assert_eq!(drawn.matches(">frequency, Hz<").count(), 1);
        assert_eq!(drawn.matches(">time, s<").count(), 2);
        assert_eq!(at_least_three(-1.2, 1.0, 2.0), [-1.0, 0.0, 1.0]);
    }
}
