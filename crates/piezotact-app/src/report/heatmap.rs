//! A height map as an image between axes, with its scale of colours, as SVG text.

use super::axis::number;
use super::chart::WIDTH;
use super::image::{BAR, Image, Svg, ticks};
use crate::failure::Outcome;

/// The frame of the image: its left and top, and the largest size that it has.
const LEFT: f64 = 86.0;
const TOP: f64 = 14.0;
const WIDEST: f64 = 640.0;
const HIGHEST: f64 = 460.0;
/// The least that a side of the image has, so that a narrow map can be seen.
const LEAST: f64 = 40.0;
/// From the image to its scale of colours.
const GAP: f64 = 34.0;
const SHORTEST_BAR: f64 = 160.0;

/// Heights on a grid, row by row from the top; NaN where nothing was measured.
pub(crate) struct Heatmap<'a> {
    pub(crate) values: &'a [f64],
    pub(crate) columns: usize,
    /// How wide and how high the area is, and in which unit.
    pub(crate) size: (f64, f64),
    pub(crate) length_unit: &'static str,
    /// The values at the ends of the scale of colours, and its label.
    pub(crate) scale: (f64, f64),
    pub(crate) label: String,
}

impl Heatmap<'_> {
    pub(crate) fn svg(&self) -> Outcome<String> {
        let (width, height) = self.frame();
        let left = (f64::from(WIDTH) - LEFT - width - GAP - BAR - 90.0).max(0.0) / 2.0 + LEFT;
        let mut svg = Svg::new(TOP + (height + 54.0).max(SHORTEST_BAR + 20.0));
        let image = Image {
            values: self.values,
            columns: self.columns,
            scale: self.scale,
        };
        svg.image((left, TOP), (width, height), &image)?;
        svg.frame((left, TOP), (width, height));
        let bottom = TOP + height;
        for tick in ticks(0.0, self.size.0, width / 80.0) {
            let x = left + width * tick / self.size.0;
            svg.line((x, bottom), (x, bottom + 6.0));
            svg.text((x, bottom + 20.0), "middle", &number(tick));
        }
        svg.text(
            (left + width / 2.0, bottom + 42.0),
            "middle",
            &format!("x, {}", self.length_unit),
        );
        for tick in ticks(0.0, self.size.1, height / 50.0) {
            let y = TOP + height * tick / self.size.1;
            svg.line((left - 6.0, y), (left, y));
            svg.text((left - 10.0, y + 4.0), "end", &number(tick));
        }
        let label = format!("y, {}", self.length_unit);
        svg.upright((left - 58.0, TOP + height / 2.0), &label);
        let place = (left + width + GAP, TOP);
        svg.colour_bar(place, height.max(SHORTEST_BAR), self.scale, &self.label);
        Ok(svg.finish())
    }

    /// The size of the image: as wide to its height as the area is, unless that could not be seen.
    fn frame(&self) -> (f64, f64) {
        let (wide, high) = self.size;
        let scale = (WIDEST / wide).min(HIGHEST / high);
        ((wide * scale).max(LEAST), (high * scale).max(LEAST))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_has_its_image_and_its_scale() {
        let map = Heatmap {
            values: &[0.0, 1.0, f64::NAN, 9.0],
            columns: 2,
            size: (1.0, 1.0),
            length_unit: "mm",
            scale: (0.0, 1.0),
            label: "height, µm".into(),
        };
        let svg = map.svg().ok().unwrap();
        assert!(svg.contains("data:image/png;base64,") && svg.contains("height, µm"));
    }
}
