//! Which parts of a target's spectrum are strong and which are weak, and gains that touch one part alone.

use piezotact::quantity::Band;

use super::scene::Scene;
use super::signal::{Draws, bins_of, hz_of};

/// A gain that is `inside` within `band` and 1 outside, over edges of a hertz.
pub(super) fn within(band: [f64; 2], inside: f64) -> impl Fn(f64) -> f64 {
    move |hz| {
        let depth = (hz - band[0]).min(band[1] - hz);
        let share = (depth + 0.5).clamp(0.0, 1.0);
        1.0 + (inside - 1.0) * share
    }
}

/// Powers of `x` in these bands.
fn powers(x: &[f64], bands: &[[f64; 2]]) -> Vec<f64> {
    // The bins of a short texture lie further apart than a third octave reaches.
    let length = x.len().max(5_000);
    let bins = bins_of(x, length);
    let of = |band: &[f64; 2]| {
        let inside = |k: &usize| (band[0]..band[1]).contains(&hz_of(*k, length));
        (1..bins.len())
            .filter(inside)
            .map(|k| bins[k].norm_sqr())
            .sum()
    };
    bands.iter().map(of).collect()
}

fn strongest(powers: &[f64]) -> usize {
    (0..powers.len())
        .max_by(|a, b| powers[*a].total_cmp(&powers[*b]))
        .unwrap_or(0)
}

/// The third octaves of the band, the strongest of the target among them, and another one no more than 20 dB below it where
/// there is one.
pub(super) struct ThirdOctaves {
    pub(super) strongest: [f64; 2],
    pub(super) another: [f64; 2],
    pub(super) weakest: [f64; 2],
}

impl ThirdOctaves {
    pub(super) fn of(scene: &Scene, draws: &mut Draws) -> Self {
        let octaves: Vec<[f64; 2]> = scene
            .band
            .third_octaves()
            .iter()
            .map(|band| [band.low().0, band.high().0])
            .filter(|[low, high]| high / low > 1.2)
            .collect();
        let powers = powers(&scene.target, &octaves);
        let first = strongest(&powers);
        let others: Vec<usize> = (0..octaves.len()).filter(|i| *i != first).collect();
        let loud: Vec<usize> = others
            .iter()
            .copied()
            .filter(|i| powers[*i] > 0.01 * powers[first])
            .collect();
        let second = others
            .iter()
            .copied()
            .max_by(|a, b| powers[*a].total_cmp(&powers[*b]));
        let another = match loud.len() {
            0 => second.unwrap_or(first),
            n => loud[(draws.uniform() * n as f64) as usize],
        };
        // An octave or more away.
        let weakest = others
            .into_iter()
            .filter(|i| i.abs_diff(first) >= 3)
            .min_by(|a, b| powers[*a].total_cmp(&powers[*b]))
            .unwrap_or(first);
        Self {
            strongest: octaves[first],
            another: octaves[another],
            weakest: octaves[weakest],
        }
    }
}

/// Which line of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    Strongest,
    Weak,
}

/// The strongest 5 Hz of the target, or 5 Hz that lie 10–35 dB below.
pub(super) fn line(scene: &Scene, which: Which, draws: &mut Draws) -> [f64; 2] {
    let lines: Vec<[f64; 2]> = (4..199)
        .map(|k| [5.0 * f64::from(k), 5.0 * f64::from(k + 1)])
        .collect();
    let powers = powers(&scene.target, &lines);
    let first = strongest(&powers);
    let range = 10f64.powf(-3.5) * powers[first]..0.1 * powers[first];
    let some: Vec<usize> = (0..lines.len())
        .filter(|i| range.contains(&powers[*i]))
        .collect();
    let chosen = match some.len() {
        n if which == Which::Weak && n > 0 => some[(draws.uniform() * n as f64) as usize],
        _ => first,
    };
    [lines[chosen][0] - 2.5, lines[chosen][1] + 2.5]
}

/// 1 in `band` and 0 outside.
pub(super) fn within_band(band: Band) -> impl Fn(f64) -> f64 {
    move |hz| f64::from(u8::from(band.contains(hz)))
}
