//! Sums over segments of |X|², and of conj(X)·Y of two signals, by the fastest transform for their length and
//! the machine.

mod butterfly;
mod eight;
mod kernel;
mod lanes;

use num_complex::Complex;

use eight::{Eight, eight};
pub use kernel::{SegmentTransform, split_power};
use lanes::{LENGTHS, LaneCross, LanePower, LaneTransform, Offset};

/// What is taken away from every segment before the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// Nothing.
    None,
    /// The mean.
    Constant,
    /// The least-squares line.
    Linear,
}

/// How many segments `hop` samples apart there are in so many samples.
pub fn segments_in(samples: usize, segment: usize, hop: usize) -> usize {
    if samples < segment {
        0
    } else {
        (samples - segment) / hop + 1
    }
}

/// A sum in independent lanes, so that it is as fast as the memory gives the numbers.
#[inline(always)]
pub fn sum(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 16];
    let (chunks, rest) = values.as_chunks::<16>();
    for chunk in chunks {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += value;
        }
    }
    lanes.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

/// The transform in lanes, where it is for segments like these and the machine has the instructions.
fn in_lanes(window: &[f64], detrend: Detrend) -> Option<(Eight, LaneTransform)> {
    Some((eight()?, lane_transform(window, detrend)?))
}

fn lane_transform(window: &[f64], detrend: Detrend) -> Option<LaneTransform> {
    let offset = match detrend {
        Detrend::None => Offset::None,
        Detrend::Constant => Offset::Mean,
        Detrend::Linear => return None,
    };
    let is_for = window.len().is_power_of_two() && LENGTHS.contains(&window.len());
    is_for.then(|| LaneTransform::new(window, offset))
}

/// A sum of |X|² over segments.
#[derive(Clone, Debug)]
pub struct PowerSum(Power);

/// How it is summed.
#[derive(Clone, Debug)]
enum Power {
    /// In lanes of eight; with the silence that is paired with a single segment.
    Lanes(Eight, LanePower, Vec<f64>),
    /// By a transform for any length, kept as the squares of real and imaginary parts.
    Planned {
        transform: SegmentTransform,
        z: Vec<Complex<f64>>,
        parts: Vec<f64>,
    },
}

impl PowerSum {
    /// Nothing yet, of segments of the length of `window`, each without its `detrend` and times the window.
    pub fn new(window: &[f64], detrend: Detrend) -> Self {
        match in_lanes(window, detrend) {
            Some((simd, transform)) => Self(Power::Lanes(
                simd,
                LanePower::new(transform),
                vec![0.0; window.len()],
            )),
            None => Self::planned(window, detrend),
        }
    }

    fn planned(window: &[f64], detrend: Detrend) -> Self {
        let n = window.len();
        Self(Power::Planned {
            transform: SegmentTransform::new(window.to_vec(), detrend),
            z: vec![Complex::default(); n],
            parts: vec![0.0; 2 * n],
        })
    }

    /// Begins again.
    pub fn clear(&mut self) {
        match &mut self.0 {
            Power::Lanes(_, sum, _) => sum.clear(),
            Power::Planned { parts, .. } => parts.fill(0.0),
        }
    }

    /// Adds two segments of the length of the window.
    pub fn add_pair(&mut self, a: &[f64], b: &[f64]) {
        match &mut self.0 {
            Power::Lanes(simd, sum, _) => sum.add(*simd, a, b),
            Power::Planned {
                transform,
                z,
                parts,
            } => {
                transform.transform_pair(a, b, z);
                transform.add_power(z, parts);
            }
        }
    }

    /// Adds one segment of the length of the window.
    pub fn add_single(&mut self, a: &[f64]) {
        match &mut self.0 {
            Power::Lanes(simd, sum, silence) => sum.add(*simd, a, silence),
            Power::Planned {
                transform,
                z,
                parts,
            } => {
                transform.transform_single(a, z);
                transform.add_power(z, parts);
            }
        }
    }

    /// The sum, n/2 + 1 bins.
    pub fn folded(&self) -> Vec<f64> {
        match &self.0 {
            Power::Lanes(_, sum, _) => fold_power(&sum.in_order()),
            Power::Planned { parts, .. } => fold_power(&both_parts(parts)),
        }
    }
}

/// The sums of |X|², |Y|² and conj(X)·Y over segments of two signals x and y, n/2 + 1 bins each.
#[derive(Clone, Debug)]
pub struct Folded {
    pub xx: Vec<f64>,
    pub yy: Vec<f64>,
    pub xy: Vec<Complex<f64>>,
}

/// Sums of |X|², |Y|² and conj(X)·Y over segments of two signals x and y.
#[derive(Clone, Debug)]
pub struct CrossSum(Cross);

/// How it is summed.
#[derive(Clone, Debug)]
enum Cross {
    /// In lanes of eight; with the silence that is paired with a single segment.
    Lanes(Eight, LaneCross, Vec<f64>),
    /// By a transform for any length.
    Planned {
        transform: SegmentTransform,
        zx: Vec<Complex<f64>>,
        zy: Vec<Complex<f64>>,
        xx: Vec<f64>,
        yy: Vec<f64>,
        xy: Vec<Complex<f64>>,
    },
}

impl CrossSum {
    /// Nothing yet, of segments of the length of `window`, each without its `detrend` and times the window.
    pub fn new(window: &[f64], detrend: Detrend) -> Self {
        match in_lanes(window, detrend) {
            Some((simd, transform)) => Self(Cross::Lanes(
                simd,
                LaneCross::new(transform),
                vec![0.0; window.len()],
            )),
            None => Self::planned(window, detrend),
        }
    }

    fn planned(window: &[f64], detrend: Detrend) -> Self {
        let n = window.len();
        Self(Cross::Planned {
            transform: SegmentTransform::new(window.to_vec(), detrend),
            zx: vec![Complex::default(); n],
            zy: vec![Complex::default(); n],
            xx: vec![0.0; 2 * n],
            yy: vec![0.0; 2 * n],
            xy: vec![Complex::default(); n],
        })
    }

    /// Begins again.
    pub fn clear(&mut self) {
        match &mut self.0 {
            Cross::Lanes(_, sums, _) => sums.clear(),
            Cross::Planned { xx, yy, xy, .. } => {
                xx.fill(0.0);
                yy.fill(0.0);
                xy.fill(Complex::default());
            }
        }
    }

    /// Adds two segments of x and the same two of y.
    pub fn add_pair(&mut self, x: [&[f64]; 2], y: [&[f64]; 2]) {
        match &mut self.0 {
            Cross::Lanes(simd, sums, _) => sums.add(*simd, x, y),
            Cross::Planned {
                transform, zx, zy, ..
            } => {
                transform.transform_pair(x[0], x[1], zx);
                transform.transform_pair(y[0], y[1], zy);
                self.add_planned();
            }
        }
    }

    /// Adds a segment of x and the same of y.
    pub fn add_single(&mut self, x: &[f64], y: &[f64]) {
        match &mut self.0 {
            Cross::Lanes(simd, sums, silence) => {
                sums.add(*simd, [x, silence], [y, silence]);
            }
            Cross::Planned {
                transform, zx, zy, ..
            } => {
                transform.transform_single(x, zx);
                transform.transform_single(y, zy);
                self.add_planned();
            }
        }
    }

    fn add_planned(&mut self) {
        if let Cross::Planned {
            transform,
            zx,
            zy,
            xx,
            yy,
            xy,
        } = &mut self.0
        {
            transform.add_power(zx, xx);
            transform.add_power(zy, yy);
            transform.add_cross(zx, zy, xy);
        }
    }

    /// The sums, n/2 + 1 bins each, not scaled.
    pub fn folded(&self) -> Folded {
        match &self.0 {
            Cross::Lanes(_, sums, _) => {
                let (xx, yy, xy) = sums.in_order();
                Folded {
                    xx: fold_power(&xx),
                    yy: fold_power(&yy),
                    xy: fold_cross(&xy),
                }
            }
            Cross::Planned { xx, yy, xy, .. } => Folded {
                xx: fold_power(&both_parts(xx)),
                yy: fold_power(&both_parts(yy)),
                xy: fold_cross(xy),
            },
        }
    }
}

/// The squares of real and imaginary part of every bin, added.
fn both_parts(parts: &[f64]) -> Vec<f64> {
    parts
        .as_chunks::<2>()
        .0
        .iter()
        .map(|[re, im]| re + im)
        .collect()
}

/// Folds a sum of |Z|² over pairs of real segments into the n/2 + 1 bins of the real signals' |X|².
fn fold_power(power: &[f64]) -> Vec<f64> {
    let n = power.len();
    (0..=n / 2)
        .map(|k| 0.5 * (power[k] + power[(n - k) % n]))
        .collect()
}

/// Folds a sum of conj(Zx)·Zy over pairs of real segments into the n/2 + 1 bins of the real signals' conj(X)·Y.
fn fold_cross(cross: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = cross.len();
    (0..=n / 2)
        .map(|k| (cross[k] + cross[(n - k) % n].conj()) * 0.5)
        .collect()
}

/// The periodic Hann window of `n` samples.
#[cfg(test)]
fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|i| crate::hann(i as f64 / n as f64)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Largest difference from `expected`.
    fn difference(expected: &[Complex<f64>], found: &[Complex<f64>]) -> f64 {
        assert_eq!(expected.len(), found.len());
        let differences = expected.iter().zip(found).map(|(a, b)| (a - b).norm());
        differences.fold(0.0, f64::max)
    }

    /// Largest difference from `expected`, relative to its largest value.
    fn apart(expected: &[Complex<f64>], found: &[Complex<f64>]) -> f64 {
        let largest = expected.iter().map(|v| v.norm()).fold(0.0, f64::max);
        difference(expected, found) / largest
    }

    fn real(values: &[f64]) -> Vec<Complex<f64>> {
        values.iter().map(|v| Complex::new(*v, 0.0)).collect()
    }

    /// How far two results are apart, relative to the largest bin of each kind.
    fn differ(expected: &Folded, found: &Folded) -> f64 {
        let powers = [(&expected.xx, &found.xx), (&expected.yy, &found.yy)];
        let powers = powers.map(|(a, b)| apart(&real(a), &real(b)));
        powers[0].max(powers[1]).max(apart(&expected.xy, &found.xy))
    }

    /// The largest power of both signals.
    fn largest_power(sums: &Folded) -> f64 {
        sums.xx.iter().chain(&sums.yy).copied().fold(0.0, f64::max)
    }

    /// How far two results are apart, relative to the rounding that they may have: a mean m is known to ε·m, which
    /// leaves ε·m·Σw in X(0), and ε·m·Σw·|X| in the sums. `with_means` are the sums of the same segments before
    /// their means were removed: |m·Σw|² is their largest power.
    fn rounding(with_means: &Folded, expected: &Folded, found: &Folded) -> f64 {
        let scale = (largest_power(with_means) * largest_power(expected)).sqrt();
        let powers = [(&expected.xx, &found.xx), (&expected.yy, &found.yy)];
        let powers = powers.map(|(a, b)| difference(&real(a), &real(b)));
        powers[0]
            .max(powers[1])
            .max(difference(&expected.xy, &found.xy))
            / scale
    }

    /// The sums by definition, without any trick: of `x` and `y`, segments of two signals.
    fn by_definition(x: &[&[f64]], y: &[&[f64]], window: &[f64]) -> Folded {
        let n = window.len();
        let turns: Vec<Complex<f64>> = (0..n)
            .map(|i| Complex::from_polar(1.0, -std::f64::consts::TAU * i as f64 / n as f64))
            .collect();
        let bins = |segment: &[f64]| -> Vec<Complex<f64>> {
            let mean = segment.iter().sum::<f64>() / n as f64;
            let windowed: Vec<f64> = segment
                .iter()
                .zip(window)
                .map(|(v, w)| (v - mean) * w)
                .collect();
            let bin = |k: usize| {
                windowed
                    .iter()
                    .enumerate()
                    .map(move |(i, v)| (k * i % n, *v))
            };
            (0..=n / 2)
                .map(|k| bin(k).map(|(at, v)| turns[at] * v).sum())
                .collect()
        };
        let mut sums = Folded {
            xx: vec![0.0; n / 2 + 1],
            yy: vec![0.0; n / 2 + 1],
            xy: vec![Complex::default(); n / 2 + 1],
        };
        for (x, y) in x.iter().zip(y) {
            for (k, (x, y)) in bins(x).into_iter().zip(bins(y)).enumerate() {
                sums.xx[k] += x.norm_sqr();
                sums.yy[k] += y.norm_sqr();
                sums.xy[k] += x.conj() * y;
            }
        }
        sums
    }

    /// The sums of a pair of segments and a single one of two signals, and that their powers are those of each
    /// signal alone.
    fn summed(mut sums: CrossSum, mut power: PowerSum, x: [&[f64]; 3], y: [&[f64]; 3]) -> Folded {
        sums.add_pair([x[1], x[2]], [y[2], y[1]]);
        sums.clear();
        sums.add_pair([x[0], x[1]], [y[0], y[1]]);
        sums.add_single(x[2], y[2]);
        let sums = sums.folded();
        for (signal, expected) in [(x, &sums.xx), (y, &sums.yy)] {
            power.clear();
            power.add_pair(signal[0], signal[1]);
            power.add_single(signal[2]);
            assert!(apart(&real(expected), &real(&power.folded())) < 1e-15);
        }
        sums
    }

    /// The transform in lanes on any machine, without the instructions for it.
    fn emulated(
        window: &[f64],
        detrend: Detrend,
        x: [&[f64]; 3],
        y: [&[f64]; 3],
    ) -> Option<Folded> {
        let silence = vec![0.0; window.len()];
        let mut sums = LaneCross::new(lane_transform(window, detrend)?);
        sums.add(pulp::Scalar512b, [x[0], x[1]], [y[0], y[1]]);
        sums.add(pulp::Scalar512b, [x[2], &silence], [y[2], &silence]);
        let (xx, yy, xy) = sums.in_order();
        let (xx, yy) = (fold_power(&xx), fold_power(&yy));
        let mut power = LanePower::new(lane_transform(window, detrend)?);
        power.add(pulp::Scalar512b, x[0], x[1]);
        power.add(pulp::Scalar512b, x[2], &silence);
        assert!(apart(&real(&xx), &real(&fold_power(&power.in_order()))) < 1e-15);
        let xy = fold_cross(&xy);
        Some(Folded { xx, yy, xy })
    }

    fn signal(n: usize, seed: usize) -> Vec<f64> {
        (0..n)
            .map(|i| ((i * i % 9973 * seed + 3 * i) as f64 * 0.7).sin() + 0.3)
            .collect()
    }

    /// For powers of two and other lengths, even and odd, at 0 Hz, at Nyquist and between.
    #[test]
    fn sums_are_the_sums_by_definition() {
        let lengths = [
            2, 3, 8, 9, 30, 31, 64, 96, 128, 256, 512, 1000, 1024, 2048, 4096,
        ];
        for n in lengths {
            let [xa, xb, xc, ya, yb, yc] = [1, 2, 3, 5, 7, 11].map(|seed| signal(n, seed));
            let (x, y) = ([&xa[..], &xb, &xc], [&ya[..], &yb, &yc]);
            let window = hann(n);
            let expected = by_definition(&x, &y, &window);
            let constant = Detrend::Constant;
            let planned = (
                CrossSum::planned(&window, constant),
                PowerSum::planned(&window, constant),
            );
            let chosen = (
                CrossSum::new(&window, constant),
                PowerSum::new(&window, constant),
            );
            for (sums, power) in [planned, chosen] {
                let found = summed(sums, power, x, y);
                assert!(differ(&expected, &found) < 1e-13, "{n}");
            }
            let emulated = emulated(&window, constant, x, y);
            assert_eq!(emulated.is_some(), n >= 256 && n.is_power_of_two());
            if let Some(found) = emulated {
                assert!(differ(&expected, &found) < 1e-13, "{n}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// In lanes, with the instructions and without, and by RustFFT the sums are the same to rounding, for
        /// every length in lanes, offset and detrend.
        #[test]
        fn in_lanes_and_planned_agree(
            exponent in 8u32..=16,
            seeds in proptest::array::uniform6(1usize..5000),
            offset in -1.0..1.0f64,
            detrend in prop_oneof![Just(Detrend::None), Just(Detrend::Constant)],
        ) {
            let n = 1 << exponent;
            let [xa, xb, xc, ya, yb, yc] = seeds.map(|seed| {
                let mut samples = signal(n, seed);
                samples.iter_mut().for_each(|v| *v += offset);
                samples
            });
            let (x, y) = ([&xa[..], &xb, &xc], [&ya[..], &yb, &yc]);
            let window = hann(n);
            let [with_means, planned] = [Detrend::None, detrend].map(|detrend| {
                summed(
                    CrossSum::planned(&window, detrend),
                    PowerSum::planned(&window, detrend),
                    x,
                    y,
                )
            });
            let chosen = summed(
                CrossSum::new(&window, detrend),
                PowerSum::new(&window, detrend),
                x,
                y,
            );
            // Largest of 3000 cases: 2.6e-15.
            let chosen = rounding(&with_means, &planned, &chosen);
            prop_assert!(chosen < 2e-14, "{chosen:e}");
            let emulated = emulated(&window, detrend, x, y).expect("a length in lanes");
            let emulated = rounding(&with_means, &planned, &emulated);
            prop_assert!(emulated < 2e-14, "{emulated:e}");
        }
    }
}
