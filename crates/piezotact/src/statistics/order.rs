//! Order statistics of many values, without sorting them, and the top of a peak between samples.

/// More values than this are narrowed down before they are ordered.
const MANY: usize = 2000;
/// As many of them, evenly spread, say where the median must be.
const SAMPLE: usize = 200;
/// How far the median may be from the sample's, as a share of all values: some two standard deviations, √(¼/200).
const REACH: f64 = 0.08;

/// The median, in the unit of `values`: the mean of the middle two for an even count; `None` for none. The order of `values` changes.
///
/// Of many values only those are ordered that lie between two that a sample gives; when the middle is not among
/// them after all, all are.
///
/// Source: definition.
///
/// ```
/// assert_eq!(piezotact::statistics::median(&mut [4.0, 1.0, 3.0, 2.0]), Some(2.5));
/// ```
pub fn median(values: &mut [f64]) -> Option<f64> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    if n > MANY
        && let Some(found) = narrowed(values)
    {
        return Some(found);
    }
    Some(middle_of(values, first_middle(n)..=n / 2))
}

/// The rank of the middle value, or of the first of the middle two.
fn first_middle(n: usize) -> usize {
    (n - 1) / 2
}

/// The mean of the values of ranks `first`…`last`, which are one or two neighbours.
fn middle_of(values: &mut [f64], ranks: std::ops::RangeInclusive<usize>) -> f64 {
    let (first, last) = (*ranks.start(), *ranks.end());
    let (below, upper, _) = values.select_nth_unstable_by(last, f64::total_cmp);
    if first < last {
        0.5 * (below.iter().copied().fold(f64::MIN, f64::max) + *upper)
    } else {
        *upper
    }
}

fn narrowed(values: &[f64]) -> Option<f64> {
    let n = values.len();
    let mut sample: Vec<f64> = values.iter().step_by(n / SAMPLE).copied().collect();
    let rank = |share: f64| ((sample.len() - 1) as f64 * share).round() as usize;
    let (low_rank, high_rank) = (rank(0.5 - REACH), rank(0.5 + REACH));
    let low = *sample.select_nth_unstable_by(low_rank, f64::total_cmp).1;
    let high = *sample.select_nth_unstable_by(high_rank, f64::total_cmp).1;
    let mut below = 0;
    let mut between = vec![0.0; n];
    let mut kept = 0;
    for value in values {
        below += usize::from(*value < low);
        // Written always and kept when it counts: no branch to guess.
        between[kept] = *value;
        kept += usize::from(*value >= low && *value <= high);
    }
    between.truncate(kept);
    let (first, last) = (first_middle(n), n / 2);
    (first >= below && last < below + kept)
        .then(|| middle_of(&mut between, first - below..=last - below))
}

/// Where a parabola through three neighbours has its top, in steps from the middle one, −0.5–0.5; 0 where they have none.
///
/// Source: J. O. Smith, Spectral Audio Signal Processing, quadratic interpolation of peaks.
///
/// ```
/// assert_eq!(piezotact::statistics::vertex([0.0, 3.0, 2.0]), 0.25);
/// ```
#[must_use]
pub fn vertex([before, top, after]: [f64; 3]) -> f64 {
    match before - 2.0 * top + after {
        bend if bend < 0.0 => (0.5 * (before - after) / bend).clamp(-0.5, 0.5),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by_sorting(values: &[f64]) -> f64 {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        if n % 2 == 1 {
            sorted[n / 2]
        } else {
            0.5 * (sorted[n / 2 - 1] + sorted[n / 2])
        }
    }

    #[test]
    fn the_median_is_that_of_the_sorted_values() {
        let wave = |n: usize, turn: f64| -> Vec<f64> {
            (0..n)
                .map(|i| ((i * i) as f64 * turn).sin() + i as f64 * 1e-5)
                .collect()
        };
        let mut cases: Vec<Vec<f64>> = [1, 2, 3, 1999, 2001, 5000, 5001, 40_000]
            .into_iter()
            .map(|n| wave(n, 0.7))
            .collect();
        cases.push(vec![3.0; 6000]);
        cases.push((0..6000).map(f64::from).collect());
        // A sample that misses the middle: every place that is looked at holds a small value.
        cases.push(
            (0..8000)
                .map(|i| if i % 20 == 0 { -1.0 } else { f64::from(i) })
                .collect(),
        );
        for case in cases {
            let expected = by_sorting(&case);
            let found = median(&mut case.clone()).unwrap();
            assert!((found - expected).abs() < 1e-15, "{} values", case.len());
        }
        assert_eq!(median(&mut []), None);
    }
}
