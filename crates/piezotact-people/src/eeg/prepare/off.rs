//! Where an electrode records nothing of the head: its contact is lost, and what is left is far below or above the other electrodes.

use std::ops::Range;

use piezotact::quantity::{SampleRate, Seconds};
use piezotact::statistics::median;

/// Changes over this time are looked at: they hold alpha and what is faster, and neither offsets nor drifts.
const OVER: Seconds = Seconds(0.05);
/// From fewer electrodes no usual one is known: each is compared with itself alone.
const FEWEST: usize = 3;
/// Blocks of this length, s, how many of them in a row below and above what is usual for an electrode, and the factor. Blinks that follow each
/// other are above it for half a second.
const LOOKED: [(f64, [usize; 2], f64); 2] = [(0.2, [3, 5], 10.0), (4.0, [2, 2], 4.0)];
/// What stands in the place of a level of nothing, V.
const NOTHING_V: f64 = 1e-12;

/// The parts of each of `signals` at `rate`, V, in which it is a factor of 10 below its usual level for 0.6 s or above it for 1 s, or of 4 for 8 s; none
/// of signals of fewer than twice as many blocks.
///
/// Formula: the level is the RMS of x(t + 50 ms) − x(t), re the median of the levels of all electrodes in the same block where there are
/// three and more; usual is its median over blocks.
///
/// Source: house rule, as N. Bigdely-Shamlo et al. (2015), Front. Neuroinform. 9:16, find an electrode by its deviation over the whole recording.
pub(super) fn off(signals: &[&[f64]], rate: SampleRate) -> Vec<Vec<Range<usize>>> {
    let mut found = vec![Vec::new(); signals.len()];
    for (block_s, least, factor) in LOOKED {
        let block = rate.samples_in(Seconds(block_s)).max(1);
        let levels: Vec<Vec<f64>> = signals.iter().map(|own| levels(own, block, rate)).collect();
        let blocks = levels.first().map_or(0, Vec::len);
        if blocks < 2 * least[1] {
            continue;
        }
        let usual: Vec<f64> = (0..blocks)
            .map(|at| {
                let mut all: Vec<f64> = levels.iter().map(|own| own[at]).collect();
                match levels.len() < FEWEST {
                    true => 0.0,
                    false => median(&mut all).unwrap_or_default(),
                }
            })
            .collect();
        for (own, found) in levels.iter().zip(&mut found) {
            let relative: Vec<f64> = own.iter().zip(&usual).map(|(own, all)| own - all).collect();
            let middle = median(&mut relative.clone()).unwrap_or_default();
            // Below or above.
            let side = |level: &f64| {
                let off = level - middle;
                (off.abs() > f64::ln(factor)).then_some(off > 0.0)
            };
            let mut at = 0;
            for run in relative.chunk_by(|a, b| side(a) == side(b)) {
                if side(&run[0]).is_some_and(|above| run.len() >= least[usize::from(above)]) {
                    found.push(at * block..(at + run.len()) * block);
                }
                at += run.len();
            }
        }
    }
    found
}

/// The natural logarithm of the level of each block of a signal.
fn levels(signal: &[f64], block: usize, rate: SampleRate) -> Vec<f64> {
    let lag = rate.samples_in(OVER).max(1);
    let count = signal.len().saturating_sub(lag);
    let changes: Vec<f64> = (0..count).map(|i| signal[i + lag] - signal[i]).collect();
    let of = |block: &[f64]| {
        let squares: f64 = block.iter().map(|change| change * change).sum();
        (squares / block.len() as f64).sqrt().max(NOTHING_V).ln()
    };
    changes.chunks_exact(block).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    const RATE_HZ: f64 = 250.0;
    const SAMPLES: usize = 20_000;

    /// EEG of `electrodes` whose alpha falls for 0.8 s of every 4 s at the first one.
    fn cap(electrodes: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Random::stream(seed, 0, "off");
        let of = |electrode: usize| {
            let (mut re, mut im) = (0.0, 0.0);
            let values = (0..SAMPLES).map(|i| {
                re = 0.985 * re + 0.17 * random.normal();
                im = 0.985 * im + 0.17 * random.normal();
                let is_touch = i % 1000 > 700 && i % 1000 < 900;
                let gain = if electrode == 0 && is_touch { 0.4 } else { 1.0 };
                let phase = std::f64::consts::TAU * 10.0 * i as f64 / RATE_HZ;
                1e-5 * gain * (re * phase.cos() - im * phase.sin()) + 2e-6 * random.normal()
            });
            values.collect()
        };
        (0..electrodes).map(of).collect()
    }

    /// The share of the samples of each electrode that is off.
    fn shares(signals: &[Vec<f64>]) -> Vec<f64> {
        let signals: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
        let found = off(&signals, SampleRate::new(RATE_HZ).unwrap());
        let share = |parts: &Vec<Range<usize>>| {
            let is_off = |i: &usize| parts.iter().any(|part| part.contains(i));
            (0..SAMPLES).filter(is_off).count() as f64 / SAMPLES as f64
        };
        found.iter().map(share).collect()
    }

    #[test]
    fn an_electrode_that_is_off_is_found_and_a_desynchronisation_is_none() {
        for electrodes in [1, 2, 4, 12] {
            for seed in 0..5 {
                let clean = cap(electrodes, seed);
                assert_eq!(shares(&clean), vec![0.0; electrodes], "{electrodes}");
                let mut random = Random::stream(seed, 1, "off");
                // The noise of an amplifier, 0.3 µV, or mains of an electrode without contact, 400 µV.
                let mut noise = |i: usize, size: f64| match size {
                    1.0 => 3e-7 * random.normal(),
                    size => {
                        size * (0.5 + std::f64::consts::TAU * 50.0 * i as f64 / RATE_HZ).sin()
                            + 2e-5 * random.normal()
                    }
                };
                for size in [1.0, 4e-4] {
                    // In the last 40 %, for a third of the time, and at each touch.
                    let parts: [(&dyn Fn(usize) -> bool, f64); 3] = [
                        (&|i| i >= 12_000, 0.4),
                        (&|i| (4000..10_660).contains(&i), 0.333),
                        (&|i| i % 1000 >= 650 && i % 1000 < 950, 0.3),
                    ];
                    for (is_off, expected) in parts {
                        let mut broken = clean.clone();
                        for (i, value) in
                            broken[0].iter_mut().enumerate().filter(|(i, _)| is_off(*i))
                        {
                            *value = noise(i, size);
                        }
                        let found = shares(&broken);
                        assert!(
                            (found[0] - expected).abs() < 0.12,
                            "{electrodes} {size} {found:?}"
                        );
                        assert!(found[1..].iter().all(|share| *share == 0.0), "{found:?}");
                    }
                }
            }
        }
    }
}
