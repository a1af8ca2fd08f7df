//! Shared parts of image figures: SVG text, values as an embedded PNG, colour scale, ticks.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::style::{RGBColor, WHITE};

use crate::DrawError;
use crate::axis::number;
use crate::chart::TEXT;
use crate::colour::palette;
use crate::format::Format;

/// The colours of the scale; one more stands for what was not measured.
const COLOURS: usize = 200;
const MISSING: RGBColor = RGBColor(214, 218, 222);

/// From blue over white to red, which people with any colour vision tell apart (the scheme `RdBu` of `ColorBrewer`).
///
/// Source: C. A. Brewer, G. W. Hatchard and M. A. Harrower (2003), Cartogr. Geogr. Inf. Sci. 30(1).
const DIVERGING: [RGBColor; 9] = [
    RGBColor(5, 48, 97),
    RGBColor(33, 102, 172),
    RGBColor(103, 169, 207),
    RGBColor(209, 229, 240),
    RGBColor(247, 247, 247),
    RGBColor(253, 219, 199),
    RGBColor(239, 138, 98),
    RGBColor(178, 24, 43),
    RGBColor(103, 0, 31),
];

/// The colours of a scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colours {
    /// From dark to light.
    Rising,
    /// From blue over white to red; what has no value is transparent.
    Diverging,
}

impl Colours {
    fn all(self) -> Vec<RGBColor> {
        match self {
            Self::Rising => palette(COLOURS),
            Self::Diverging => (0..COLOURS).map(diverging).collect(),
        }
    }
}

/// One of the diverging colours.
fn diverging(index: usize) -> RGBColor {
    let place = index as f64 * (DIVERGING.len() - 1) as f64 / (COLOURS - 1) as f64;
    let k = (place as usize).min(DIVERGING.len() - 2);
    let share = place - k as f64;
    let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - share) + f64::from(b) * share).round() as u8;
    let (a, b) = (DIVERGING[k], DIVERGING[k + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Values as colours, row by row from the top; NaN where nothing was measured.
pub(crate) struct Image<'a> {
    pub(crate) values: &'a [f64],
    pub(crate) columns: usize,
    /// The values at the ends of the scale of colours.
    pub(crate) scale: (f64, f64),
    pub(crate) colours: Colours,
}

impl Image<'_> {
    fn png(&self) -> Result<Vec<u8>, DrawError> {
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
        let colours = self.colours.all();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.columns as u32, rows as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        let rgb = |colour: &RGBColor| [colour.0, colour.1, colour.2];
        let table: Vec<u8> = colours.iter().chain([&MISSING]).flat_map(rgb).collect();
        encoder.set_palette(table);
        if self.colours == Colours::Diverging {
            let opaque = std::iter::repeat_n(255, COLOURS);
            encoder.set_trns(opaque.chain([0]).collect::<Vec<u8>>());
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&pixels).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

fn failed(error: png::EncodingError) -> DrawError {
    DrawError::Drawing {
        reason: error.to_string(),
    }
}

fn hex(colour: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2)
}

/// About `count` round numbers from `low` to `high`.
pub(crate) fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
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

/// A text as SVG holds it.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// SVG text that grows, as wide as a figure.
pub(crate) struct Svg {
    format: Format,
    text: String,
}

impl Svg {
    pub(crate) fn new(format: Format, height: f64) -> Self {
        let Format { width, text, .. } = format;
        Self {
            format,
            text: format!(
                "<svg role=\"img\" viewBox=\"0 0 {width} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"{text}\" fill=\"{}\">",
                hex(TEXT)
            ),
        }
    }

    /// `share` of the height of a text.
    pub(crate) fn em(&self, share: f64) -> f64 {
        self.format.em(share)
    }

    /// White behind everything, where the page may not be.
    pub(crate) fn background(&mut self, height: f64) {
        self.area((0.0, 0.0), (f64::from(self.format.width), height), WHITE);
    }

    /// The colour of what was not measured, where no image may cover it.
    pub(crate) fn missing(&mut self, at: (f64, f64), size: (f64, f64)) {
        self.area(at, size, MISSING);
    }

    fn area(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), colour: RGBColor) {
        self.add(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{}\"/>",
            hex(colour)
        ));
    }

    fn add(&mut self, element: &str) {
        self.text.push('\n');
        self.text.push_str(element);
    }

    pub(crate) fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
        let _never_fails = write!(
            self.text,
            "\n<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#969ea6\"/>"
        );
    }

    pub(crate) fn frame(&mut self, (x, y): (f64, f64), (width, height): (f64, f64)) {
        let _never_fails = write!(
            self.text,
            "\n<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"#969ea6\"/>"
        );
    }

    /// A mark and its number below a frame that ends at `bottom`.
    pub(crate) fn mark_below(&mut self, x: f64, bottom: f64, value: f64) {
        self.line((x, bottom), (x, bottom + self.em(0.4)));
        self.text((x, bottom + self.em(1.5)), "middle", &number(value));
    }

    /// A mark and its number left of a frame that begins at `left`.
    pub(crate) fn mark_left(&mut self, left: f64, y: f64, value: f64) {
        self.line((left - self.em(0.4), y), (left, y));
        let at = (left - self.em(0.7), y + self.em(0.35));
        self.text(at, "end", &number(value));
    }

    /// A text that starts, ends or has its middle there, as `anchor` says.
    pub(crate) fn text(&mut self, (x, y): (f64, f64), anchor: &str, text: &str) {
        let _never_fails = write!(
            self.text,
            "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        );
    }

    /// A text that reads upwards, centred.
    pub(crate) fn upright(&mut self, (x, y): (f64, f64), text: &str) {
        let _never_fails = write!(
            self.text,
            "\n<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\">{}</text>",
            escaped(text)
        );
    }

    /// A filled circle, in the colour of what was not measured.
    pub(crate) fn disc(&mut self, (x, y): (f64, f64), radius: f64) {
        let fill = hex(MISSING);
        self.add(&format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\"/>"
        ));
    }

    /// The line of a circle.
    pub(crate) fn ring(&mut self, (x, y): (f64, f64), radius: f64) {
        self.add(&format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"none\" stroke=\"#464e56\" stroke-width=\"1.5\"/>"
        ));
    }

    /// A dot that says what it is when it is pointed at.
    pub(crate) fn dot(&mut self, (x, y): (f64, f64), radius: f64, name: &str) {
        self.add(&format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"#1f262d\"><title>{}</title></circle>",
            escaped(name)
        ));
    }

    /// A thick line through points; closed where the last is the first.
    pub(crate) fn path(&mut self, points: &[(f64, f64)]) {
        let points: Vec<String> = points
            .iter()
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        self.add(&format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#1f262d\" stroke-width=\"1.5\"/>",
            points.join(" ")
        ));
    }

    /// An image that fills the frame from `at`, `size` large.
    pub(crate) fn image(
        &mut self,
        (x, y): (f64, f64),
        size: (f64, f64),
        image: &Image<'_>,
    ) -> Result<(), DrawError> {
        let (width, height) = size;
        let png = STANDARD.encode(image.png()?);
        self.add(&format!(
            "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{png}\"/>"
        ));
        Ok(())
    }

    /// The scale of colours from `low` to `high`, with its ticks and its label to the right: [`Format::scale_width`] wide.
    pub(crate) fn colour_bar(
        &mut self,
        (left, top): (f64, f64),
        height: f64,
        (low, high): (f64, f64),
        colours: Colours,
        label: &str,
    ) {
        let bar = self.em(1.2);
        let colours = colours.all();
        let each = height / colours.len() as f64;
        for (i, colour) in colours.iter().rev().enumerate() {
            let y = top + each * i as f64;
            self.add(&format!(
                "<rect x=\"{left}\" y=\"{y:.2}\" width=\"{bar:.1}\" height=\"{:.2}\" fill=\"{}\"/>",
                each + 0.6,
                hex(*colour)
            ));
        }
        self.frame((left, top), (bar, height + 0.6));
        let right = left + bar;
        for tick in ticks(low, high, height / self.em(2.2)) {
            let y = top + height * (high - tick) / (high - low);
            self.line((right, y), (right + self.em(0.4), y));
            let at = (right + self.em(0.6), y + self.em(0.35));
            self.text(at, "start", &number(tick));
        }
        let at = left + self.format.scale_width() - self.em(0.5);
        self.upright((at, top + height / 2.0), label);
    }

    pub(crate) fn finish(self) -> String {
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
        let image = Image {
            values: &[0.0, 1.0, f64::NAN, 9.0],
            columns: 2,
            scale: (0.0, 1.0),
            colours: Colours::Rising,
        };
        let bytes = image.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = [0; 4];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, [0, 199, 200, 199]);
    }

    #[test]
    fn a_text_stays_a_text() {
        let mut svg = Svg::new(Format::WIDE, 10.0);
        svg.text((0.0, 0.0), "start", "<a> & b");
        assert!(svg.finish().contains(">&lt;a&gt; &amp; b</text>"));
    }
}
