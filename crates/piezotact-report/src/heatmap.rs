//! A height map as an image between axes, with its scale of colours, as SVG text.

use piezotact::figure::Heatmap;

use crate::DrawError;
use crate::alternative;
use crate::format::{Format, both};
use crate::image::{Colours, Image, Svg, ticks};

/// The least that a side of the image has, so that a narrow map can be seen.
const LEAST: f64 = 40.0;
/// The largest height of the image, as a share of the width of a figure.
const HIGHEST: f64 = 0.5;
/// What stands left of the image, below it, and between it and its scale of colours, in heights of a text.
const LEFT: f64 = 5.0;
const BELOW: f64 = 3.4;
const GAP: f64 = 1.5;
const SHORTEST_BAR: f64 = 10.0;

/// A heat map in both formats as SVG text that takes the width there is.
///
/// # Errors
/// [`DrawError`] where the image cannot be made.
pub fn svg(map: &Heatmap) -> Result<String, DrawError> {
    both(&alternative::heatmap(map), |format| drawn(map, format))
}

fn drawn(map: &Heatmap, format: Format) -> Result<String, DrawError> {
    let (width, height) = frame(map, format);
    let all = format.em(LEFT + GAP) + width + format.scale_width();
    let left = (f64::from(format.width) - all).max(0.0) / 2.0 + format.em(LEFT);
    let top = format.em(1.0);
    let bar = height.max(format.em(SHORTEST_BAR));
    let whole = top + (height + format.em(BELOW)).max(bar + top);
    let mut svg = Svg::new(format, whole);
    svg.background(whole);
    let image = Image {
        values: &map.values,
        columns: map.columns,
        scale: map.scale,
        colours: Colours::Rising,
    };
    svg.image((left, top), (width, height), &image)?;
    svg.frame((left, top), (width, height));
    let bottom = top + height;
    for tick in ticks(0.0, map.size.0, width / format.em(5.0)) {
        svg.mark_below(left + width * tick / map.size.0, bottom, tick);
    }
    svg.text(
        (left + width / 2.0, bottom + format.em(2.9)),
        "middle",
        &format!("x, {}", map.length_unit),
    );
    for tick in ticks(0.0, map.size.1, height / format.em(3.0)) {
        svg.mark_left(left, top + height * tick / map.size.1, tick);
    }
    let label = format!("y, {}", map.length_unit);
    svg.upright((left - format.em(LEFT - 1.0), top + height / 2.0), &label);
    let place = (left + width + format.em(GAP), top);
    svg.colour_bar(place, bar, map.scale, Colours::Rising, &map.label);
    Ok(svg.finish())
}

/// The size of the image: as wide to its height as the area is, unless that could not be seen.
fn frame(map: &Heatmap, format: Format) -> (f64, f64) {
    let (wide, high) = map.size;
    let room = f64::from(format.width) - format.em(LEFT + GAP) - format.scale_width();
    let highest = HIGHEST * f64::from(format.width);
    let scale = (room / wide).min(highest.max(room.min(240.0)) / high);
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
