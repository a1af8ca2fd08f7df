//! The colours of lines and scales.

use piezotact::figure::Tone;
use plotters::style::RGBColor;

/// Colours that are distinguishable with any colour vision.
///
/// M. Okabe and K. Ito, *Color Universal Design* (2008), without yellow, which is too light for a line.
const OKABE_ITO: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// Viridis at ten even steps, from dark to light; its lightest end is left out.
const VIRIDIS: [RGBColor; 10] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 33, 115),
    RGBColor(65, 62, 133),
    RGBColor(53, 90, 140),
    RGBColor(43, 116, 142),
    RGBColor(33, 143, 140),
    RGBColor(33, 168, 131),
    RGBColor(82, 190, 101),
    RGBColor(144, 203, 62),
    RGBColor(186, 208, 36),
];

/// `count` colours in order: distinct ones for a few, a scale from dark to light for many.
pub(crate) fn palette(count: usize) -> Vec<RGBColor> {
    if count <= OKABE_ITO.len() {
        return OKABE_ITO[..count].to_vec();
    }
    (0..count)
        .map(|i| {
            let place = i as f64 * (VIRIDIS.len() - 1) as f64 / (count - 1) as f64;
            let k = (place as usize).min(VIRIDIS.len() - 2);
            let share = place - k as f64;
            let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as u8;
            let (a, b) = (VIRIDIS[k], VIRIDIS[k + 1]);
            RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
        })
        .collect()
}

/// The colour of a tone.
pub(crate) fn colour(tone: Tone) -> RGBColor {
    match tone {
        Tone::Reference => RGBColor(30, 30, 30),
        Tone::Pale => RGBColor(172, 180, 188),
        Tone::Main => RGBColor(0, 121, 107),
        Tone::Second => RGBColor(198, 83, 26),
        Tone::Signal => RGBColor(0, 90, 140),
        Tone::Accent => RGBColor(213, 94, 0),
        Tone::Third => RGBColor(0, 158, 115),
        Tone::Border => RGBColor(110, 118, 126),
        Tone::Of { index, count } => {
            let colours = palette(count.max(1));
            colours[index.min(colours.len() - 1)]
        }
    }
}
