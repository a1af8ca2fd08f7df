//! Samples that a stream of a constant rate lost: whole steps by which its time stamps are late from one sample on.

/// Samples missing before the one at `at`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LostBefore {
    /// The index of the sample that follows them.
    pub at: usize,
    pub samples: usize,
}

/// The level of the time stamps is compared over so long before and after a late one, s, and over so many samples.
const AROUND_S: f64 = 5.0;
const AROUND: (usize, usize) = (50, 5000);
/// At least so many samples lie between two losses.
const LEAST_BETWEEN: usize = 5;
/// So many time stamps around a loss come earlier than the one before by this share of it, and it is none.
const EARLY: f64 = 0.75;
const MOST_EARLY: usize = 3;
/// At most so many late time stamps are looked at.
const MOST: usize = 1000;

fn median(values: impl Iterator<Item = f64>) -> f64 {
    piezotact::statistics::median(&mut values.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// The samples that are missing in `time_s`, in the order of time: a step that is late by more than half a sample, by which all that follow are
/// late too. A time stamp that is late by itself, or with the rest of its packet, is jitter; so is a rate that wanders.
pub(super) fn lost(time_s: &[f64]) -> Vec<LostBefore> {
    let count = time_s.len();
    let lag = count / 8;
    if lag < LEAST_BETWEEN {
        return Vec::new();
    }
    // A loss lies within an eighth of the pairs.
    let pairs = time_s.iter().zip(&time_s[lag..]);
    let step_s = median(pairs.map(|(a, b)| b - a)) / lag as f64;
    if step_s.is_nan() || step_s <= 0.0 {
        return Vec::new();
    }
    let first_s = time_s[0];
    // How late each sample is, in samples.
    let late: Vec<f64> = time_s
        .iter()
        .enumerate()
        .map(|(k, time)| (time - first_s) / step_s - k as f64)
        .collect();
    let mut steps: Vec<(usize, f64)> = (late.iter().zip(&late[1..]).enumerate())
        .map(|(k, (a, b))| (k + 1, b - a))
        .filter(|(_, step)| *step > 0.5)
        .collect();
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let around = ((AROUND_S / step_s) as usize).clamp(AROUND.0, AROUND.1);
    let mut found: Vec<LostBefore> = Vec::new();
    for (at, step) in steps.into_iter().take(MOST) {
        let next = found.partition_point(|lost| lost.at < at);
        let from = next.checked_sub(1).map_or(0, |before| found[before].at);
        let to = found.get(next).map_or(count, |lost| lost.at);
        let before = &late[from.max(at.saturating_sub(around))..at];
        let after = &late[at..to.min(at + around)];
        if before.len().min(after.len()) < LEAST_BETWEEN {
            continue;
        }
        let level = |part: &[f64]| median(part.iter().copied());
        let spread = |part: &[f64]| {
            let middle = level(part);
            median(part.iter().map(|late| (late - middle).abs()))
        };
        let shift = level(after) - level(before);
        let noise = spread(before).max(spread(after));
        let samples = shift.round();
        // Time stamps that come early again, time after time, were late and lost nothing.
        let around = &late[at - before.len()..at + after.len()];
        let early = |pair: &&[f64]| pair[1] - pair[0] < -EARLY * shift;
        let returns = around.windows(2).filter(early).count();
        // What is late for good is late by as much as the step.
        let stays = (0.5 * step..=1.5 * step + 0.5).contains(&shift);
        if samples >= 1.0 && stays && shift > 5.0 * noise && returns < MOST_EARLY {
            let samples = samples as usize;
            found.insert(next, LostBefore { at, samples });
        }
    }
    let all = found.iter().map(|lost| lost.samples);
    // A stream that seems to lack more than it holds has no constant rate.
    match all.fold(0, usize::saturating_add) <= count {
        true => found,
        false => Vec::new(),
    }
}

/// The place of each of `count` samples on the grid of their rate.
pub(super) fn places(count: usize, lost: &[LostBefore]) -> impl Iterator<Item = usize> {
    let mut lost = lost.iter().peekable();
    let mut missing = 0;
    (0..count).map(move |k| {
        while let Some(next) = lost.next_if(|next| next.at <= k) {
            missing += next.samples;
        }
        k + missing
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times at 250 Hz in packets of `packet` samples, each as late as `late` says of its number, without the samples that `is_lost` names.
    fn times(
        packet: usize,
        late: impl Fn(usize) -> f64,
        is_lost: impl Fn(usize) -> bool,
    ) -> Vec<f64> {
        let each = (0..15_000).filter(|k| !is_lost(*k));
        each.map(|k| 1000.0 + k as f64 / 250.0 + late(k / packet))
            .collect()
    }

    fn hashed(k: usize) -> f64 {
        (k.wrapping_mul(2_654_435_761) % 1000) as f64 / 1000.0
    }

    #[test]
    fn losses_are_found_and_jitter_is_not() {
        let check = |found: Vec<LostBefore>, expected: &[(usize, usize)]| {
            let found: Vec<_> = found.iter().map(|lost| (lost.at, lost.samples)).collect();
            assert_eq!(found, expected);
        };
        let gaps = |k: usize| (1250..1260).contains(&k) || (9000..9001).contains(&k);
        check(lost(&times(1, |_| 0.0, gaps)), &[(1250, 10), (8990, 1)]);
        // Packets of 40 ms, up to 8 ms late.
        let jitter = |packet: usize| 0.008 * hashed(packet);
        let long = |k: usize| (1250..1625).contains(&k);
        check(lost(&times(10, jitter, long)), &[(1250, 375)]);
        check(lost(&times(10, jitter, |_| false)), &[]);
        // Two packets of 0.4 s come 0.8 s late, and those after them in time; a clock that drifts by 100 ppm.
        let held = |packet: usize| {
            if matches!(packet, 30 | 31) {
                0.8
            } else {
                1e-5 * packet as f64
            }
        };
        check(lost(&times(100, held, |_| false)), &[]);
        // Every second packet is late by 4 samples, or by 1; packets that are late by 10 ms on average.
        for (packet, late_s) in [(50, 0.016), (25, 0.004), (125, 0.004), (10, 0.016)] {
            let second = |packet: usize| late_s * (packet % 2) as f64;
            check(lost(&times(packet, second, |_| false)), &[]);
        }
        let exponential = |packet: usize| -0.010 * (1.0 - hashed(packet)).ln();
        check(lost(&times(50, exponential, |_| false)), &[]);
        let long = |k: usize| (7000..7050).contains(&k);
        check(lost(&times(50, exponential, long)), &[(7000, 50)]);
        // A rate that wanders.
        let slow = |k: usize| 0.3 * (k as f64 / 2000.0).sin() + 0.004 * hashed(k);
        check(lost(&times(1, slow, |_| false)), &[]);
        assert_eq!(lost(&[f64::MAX; 100]), []);
        assert_eq!(
            places(5, &[LostBefore { at: 2, samples: 3 }]).collect::<Vec<_>>(),
            [0, 1, 5, 6, 7]
        );
    }
}
