//! Passes over the samples of a signal in blocks that stay in the memory of the processor, several samples at a time.

/// Samples in a block.
const BLOCK: usize = 2048;
/// The number of minima that are kept side by side, so that a processor compares several samples at once.
const LANES: usize = 8;
/// Added to a number from −1 to 2³¹, it leaves the nearest whole number in the lowest bits of the sum: 1.5 · 2⁵².
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// Work that is compiled for the instructions of the processor at hand. A closure alone is called through a function of its own, which is not.
struct Wide<F>(F);

impl<R, F: FnMut() -> R> pulp::WithSimd for Wide<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _simd: S) -> R {
        (self.0)()
    }
}

fn wide<R>(work: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Wide(work))
}

/// What a first pass over a signal shows.
#[derive(Clone, Copy)]
pub(super) struct Ends {
    pub(super) low: f64,
    pub(super) high: f64,
    /// The smallest change from one sample to the next, without those of zero: the step of a converter.
    pub(super) step: f64,
}

/// The ends of `samples` and their step.
pub(super) fn ends(samples: &[f64]) -> Ends {
    wide(
        #[inline(always)]
        || {
            let (mut low, mut high) = ([f64::MAX; LANES], [f64::MIN; LANES]);
            let mut least = [f64::MAX; LANES];
            for from in (0..samples.len()).step_by(BLOCK) {
                let to = (from + BLOCK).min(samples.len());
                extremes(&samples[from..to], &mut low, &mut high);
                steps(&samples[from..(to + 1).min(samples.len())], &mut least);
            }
            Ends {
                low: low.into_iter().fold(f64::MAX, f64::min),
                high: high.into_iter().fold(f64::MIN, f64::max),
                step: least.into_iter().fold(f64::MAX, f64::min),
            }
        },
    )
}

/// The smallest change from one sample to the next, without those of zero: the step of a converter.
pub(crate) fn step(samples: &[f64]) -> f64 {
    ends(samples).step
}

#[inline(always)]
fn extremes(samples: &[f64], low: &mut [f64; LANES], high: &mut [f64; LANES]) {
    let (chunks, rest) = samples.as_chunks::<LANES>();
    for chunk in chunks {
        for ((v, low), high) in chunk.iter().zip(low.iter_mut()).zip(high.iter_mut()) {
            *low = if *v < *low { *v } else { *low };
            *high = if *v > *high { *v } else { *high };
        }
    }
    for ((v, low), high) in rest.iter().zip(low).zip(high) {
        *low = if *v < *low { *v } else { *low };
        *high = if *v > *high { *v } else { *high };
    }
}

#[inline(always)]
fn steps(samples: &[f64], least: &mut [f64; LANES]) {
    let next = samples.get(1..).unwrap_or_default();
    let (nexts, rest) = next.as_chunks::<LANES>();
    let smaller = |v: f64, next: f64, least: &mut f64| {
        let change = (next - v).abs();
        let smaller = change > 0.0 && change < *least;
        *least = if smaller { change } else { *least };
    };
    for (chunk, next) in samples.as_chunks::<LANES>().0.iter().zip(nexts) {
        for ((v, next), least) in chunk.iter().zip(next).zip(least.iter_mut()) {
            smaller(*v, *next, least);
        }
    }
    let from = nexts.len() * LANES;
    for ((v, next), least) in samples[from..].iter().zip(rest).zip(least) {
        smaller(*v, *next, least);
    }
}

/// How many of `samples` have each place from 0 to `last`: that of a sample is `place` of it, rounded down; what lies beyond the last counts there.
pub(super) fn tally(samples: &[f64], last: u32, place: impl Fn(f64) -> f64 + Copy) -> Vec<u32> {
    // Neighbours are often at one place: two tables spare the second addition the wait for the first.
    let mut even = vec![0_u32; last as usize + 1];
    let mut odd = even.clone();
    wide(
        #[inline(always)]
        || {
            for block in samples.chunks(BLOCK) {
                let mut places = [0_u32; BLOCK];
                rounded_down(block, &mut places, last, place);
                let (pairs, rest) = places[..block.len()].as_chunks::<2>();
                for [first, second] in pairs {
                    even[*first as usize] += 1;
                    odd[*second as usize] += 1;
                }
                for one in rest {
                    even[*one as usize] += 1;
                }
            }
        },
    );
    for (even, odd) in even.iter_mut().zip(odd) {
        *even += odd;
    }
    even
}

#[inline(always)]
fn rounded_down(
    samples: &[f64],
    places: &mut [u32; BLOCK],
    last: u32,
    place: impl Fn(f64) -> f64 + Copy,
) {
    for (at, v) in places.iter_mut().zip(samples) {
        let place = place(*v);
        let nearest = (place + WHOLE) - WHOLE;
        let above = if nearest > place { 1.0 } else { 0.0 };
        *at = (((nearest - above) + WHOLE).to_bits() as u32).min(last);
    }
}

/// The largest of `samples`, times `sign`, below `limit`.
pub(super) fn next_below(samples: &[f64], sign: f64, limit: f64) -> f64 {
    wide(
        #[inline(always)]
        || {
            let mut most = [f64::MIN; LANES];
            let larger = |v: f64, most: &mut f64| {
                let v = if sign * v < limit { sign * v } else { f64::MIN };
                *most = if v > *most { v } else { *most };
            };
            let (chunks, rest) = samples.as_chunks::<LANES>();
            for chunk in chunks {
                for (v, most) in chunk.iter().zip(&mut most) {
                    larger(*v, most);
                }
            }
            for (v, most) in rest.iter().zip(&mut most) {
                larger(*v, most);
            }
            most.into_iter().fold(f64::MIN, f64::max)
        },
    )
}

/// How many of `samples` are within `rounding` of each of `values`.
pub(super) fn near<const N: usize>(samples: &[f64], values: [f64; N], rounding: f64) -> [usize; N] {
    wide(
        #[inline(always)]
        || {
            let mut all = [0; N];
            for block in samples.chunks(BLOCK) {
                for (all, value) in all.iter_mut().zip(values) {
                    let near = block.iter().map(|v| (v - value).abs() <= rounding);
                    *all += near.map(u64::from).sum::<u64>() as usize;
                }
            }
            all
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn passes_in_blocks_are_those_sample_by_sample() {
        let mut random = Random::stream(4, 0, "passes");
        for length in [0, 1, 2, 9, 2047, 2048, 2049, 9001] {
            let samples: Vec<f64> = (0..length)
                .map(|_| (random.normal() * 100.0).round() / 8.0)
                .collect();
            let found = ends(&samples);
            let low = samples.iter().copied().fold(f64::MAX, f64::min);
            let high = samples.iter().copied().fold(f64::MIN, f64::max);
            let changes = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            let step = changes.filter(|c| *c > 0.0).fold(f64::MAX, f64::min);
            assert_eq!([found.low, found.high, found.step], [low, high, step]);
            // Places on the edge of two, and beyond the last.
            let place = |v: f64| 4.0 * (v - low);
            let mut expected = vec![0_u32; 41];
            for v in &samples {
                expected[(place(*v) as usize).min(40)] += 1;
            }
            assert_eq!(tally(&samples, 40, place), expected, "{length}");
            let equal = |value: f64| {
                samples
                    .iter()
                    .filter(|v| (*v - value).abs() <= 0.01)
                    .count()
            };
            assert_eq!(
                near(&samples, [low, 0.125], 0.01),
                [equal(low), equal(0.125)]
            );
        }
    }
}
