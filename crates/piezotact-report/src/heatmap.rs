//! A height map as an image between axes, with its scale of colours, as SVG text.

use piezotact::figure::Heatmap;

use crate::DrawError;
use crate::axis::number;
use crate::chart::WIDTH;
use crate::image::{BAR, Image, Svg, ticks};

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

/// A heat map as SVG text that takes the width there is.
///
/// # Errors
/// [`DrawError`] where the image cannot be made.
pub fn svg(map: &Heatmap) -> Result<String, DrawError> {
    let (width, height) = frame(map);
    let left = (f64::from(WIDTH) - LEFT - width - GAP - BAR - 90.0).max(0.0) / 2.0 + LEFT;
    let mut svg = Svg::new(TOP + (height + 54.0).max(SHORTEST_BAR + 20.0));
    let image = Image {
        values: &map.values,
        columns: map.columns,
        scale: map.scale,
    };
    svg.image((left, TOP), (width, height), &image)?;
    svg.frame((left, TOP), (width, height));
    let bottom = TOP + height;
    for tick in ticks(0.0, map.size.0, width / 80.0) {
        let x = left + width * tick / map.size.0;
        svg.line((x, bottom), (x, bottom + 6.0));
        svg.text((x, bottom + 20.0), "middle", &number(tick));
    }
    svg.text(
        (left + width / 2.0, bottom + 42.0),
        "middle",
        &format!("x, {}", map.length_unit),
    );
    for tick in ticks(0.0, map.size.1, height / 50.0) {
        let y = TOP + height * tick / map.size.1;
        svg.line((left - 6.0, y), (left, y));
        svg.text((left - 10.0, y + 4.0), "end", &number(tick));
    }
    let label = format!("y, {}", map.length_unit);
    svg.upright((left - 58.0, TOP + height / 2.0), &label);
    let place = (left + width + GAP, TOP);
    svg.colour_bar(place, height.max(SHORTEST_BAR), map.scale, &map.label);
    Ok(svg.finish())
}

/// The size of the image: as wide to its height as the area is, unless that could not be seen.
fn frame(map: &Heatmap) -> (f64, f64) {
    let (wide, high) = map.size;
    let scale = (WIDEST / wide).min(HIGHEST / high);
    ((wide * scale).max(LEAST), (high * scale).max(LEAST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_has_its_image_and_its_scale() {
        let map = Heatmap {
            values: vec![0.0, 1.0, f64::NAN, 9.0],
            columns: 2,
            size: (1.0, 1.0),
            length_unit: "mm".into(),
            scale: (0.0, 1.0),
            label: "height, µm".into(),
        };
        let svg = svg(&map).unwrap();
        assert!(svg.contains("data:image/png;base64,") && svg.contains("height, µm"));
    }
}
