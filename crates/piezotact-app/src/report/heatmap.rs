//! A height map as an image between axes, with its scale of colours, as SVG text.

use std::fmt::Write as _;

use anyhow::anyhow;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::style::RGBColor;

use super::axis::number;
use super::chart::{TEXT, WIDTH, palette};
use crate::failure::Outcome;

/// The colours of the scale; one more stands for what was not measured.
const COLOURS: usize = 200;
const MISSING: RGBColor = RGBColor(214, 218, 222);
/// The frame of the image: its left and top, and the largest size that it has.
const LEFT: f64 = 86.0;
const TOP: f64 = 14.0;
const WIDEST: f64 = 640.0;
const HIGHEST: f64 = 460.0;
/// The least that a side of the image has, so that a narrow map can be seen.
const LEAST: f64 = 40.0;
/// From the image to its scale of colours, and how wide that is.
const GAP: f64 = 34.0;
const BAR: f64 = 22.0;
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
        let colours = palette(COLOURS);
        let image = STANDARD.encode(self.png(&colours)?);
        let left = (f64::from(WIDTH) - LEFT - width - GAP - BAR - 90.0).max(0.0) / 2.0 + LEFT;
        let mut svg = Svg::new(TOP + (height + 54.0).max(SHORTEST_BAR + 20.0));
        svg.add(&format!(
            "<image x=\"{left}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{image}\"/>"
        ));
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
        self.colour_bar(&mut svg, &colours, left + width + GAP);
        Ok(svg.finish())
    }

    fn colour_bar(&self, svg: &mut Svg, colours: &[RGBColor], left: f64) {
        let (_, height) = self.frame();
        let height = height.max(SHORTEST_BAR);
        let each = height / colours.len() as f64;
        for (i, colour) in colours.iter().rev().enumerate() {
            let y = TOP + each * i as f64;
            svg.add(&format!(
                "<rect x=\"{left}\" y=\"{y:.2}\" width=\"{BAR}\" height=\"{:.2}\" fill=\"{}\"/>",
                each + 0.6,
                hex(*colour)
            ));
        }
        svg.frame((left, TOP), (BAR, height + 0.6));
        let (low, high) = self.scale;
        for tick in ticks(low, high, height / 45.0) {
            let y = TOP + height * (high - tick) / (high - low);
            svg.line((left + BAR, y), (left + BAR + 6.0, y));
            svg.text((left + BAR + 10.0, y + 4.0), "start", &number(tick));
        }
        svg.upright((left + BAR + 66.0, TOP + height / 2.0), &self.label);
    }

    /// The size of the image: as wide to its height as the area is, unless that could not be seen.
    fn frame(&self) -> (f64, f64) {
        let (wide, high) = self.size;
        let scale = (WIDEST / wide).min(HIGHEST / high);
        ((wide * scale).max(LEAST), (high * scale).max(LEAST))
    }

    fn png(&self, colours: &[RGBColor]) -> Outcome<Vec<u8>> {
        let (low, high) = self.scale;
        let pixels: Vec<u8> = self
            .values
            .iter()
            .map(|value| {
                if value.is_nan() {
                    return COLOURS as u8;
                }
                let place = (value - low) / (high - low) * COLOURS as f64;
                place.clamp(0.0, (COLOURS - 1) as f64) as u8
            })
            .collect();
        let rows = self.values.len() / self.columns;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.columns as u32, rows as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        let rgb = |colour: &RGBColor| [colour.0, colour.1, colour.2];
        let table: Vec<u8> = colours.iter().chain([&MISSING]).flat_map(rgb).collect();
        encoder.set_palette(table);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels)?;
        writer
            .finish()
            .map_err(|error| anyhow!("an image could not be made: {error}"))?;
        Ok(bytes)
    }
}

fn hex(colour: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2)
}

/// About `count` round numbers from `low` to `high`.
fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let rough = (high - low) / count.max(2.0);
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(10.0 * decade);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let steps = (last - first).clamp(0.0, 100.0) as usize;
    (0..=steps).map(|k| (first + k as f64) * step).collect()
}

/// SVG text that grows.
struct Svg {
    text: String,
}

impl Svg {
    fn new(height: f64) -> Self {
        Self {
            text: format!(
                "<svg role=\"img\" viewBox=\"0 0 {WIDTH} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"12\" fill=\"{}\">",
                hex(TEXT)
            ),
        }
    }

    fn add(&mut self, element: &str) {
        self.text.push('\n');
        self.text.push_str(element);
    }

    fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
        let _never_fails = write!(
            self.text,
            "\n<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#969ea6\"/>"
        );
    }

    fn frame(&mut self, (x, y): (f64, f64), (width, height): (f64, f64)) {
        let _never_fails = write!(
            self.text,
            "\n<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"#969ea6\"/>"
        );
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: &str, text: &str) {
        let _never_fails = write!(
            self.text,
            "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>"
        );
    }

    /// A text that reads upwards, centred.
    fn upright(&mut self, (x, y): (f64, f64), text: &str) {
        let _never_fails = write!(
            self.text,
            "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\">{text}</text>"
        );
    }

    fn finish(self) -> String {
        self.text + "\n</svg>"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let check = |low, high, count, expected: &[f64]| {
            let found = ticks(low, high, count);
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 1e-12, "{found:?}");
            }
        };
        check(0.0, 1.27, 7.0, &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2]);
        check(-3.0, 3.0, 3.0, &[-2.0, 0.0, 2.0]);
        check(0.0, 100.0, 1.0, &[0.0, 50.0, 100.0]);
    }

    #[test]
    fn missing_points_have_their_own_colour() {
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
        let bytes = map.png(&palette(COLOURS)).ok().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = [0; 4];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, [0, 199, 200, 199]);
    }
}
