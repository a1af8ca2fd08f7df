//! How the heights of a surface are distributed.

/// The distribution of heights in classes of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightDistribution {
    /// The borders of the classes, one more than classes, rising, in m.
    pub borders_m: Vec<f64>,
    /// The share of all measured points in each class; together 1 where none lies beyond the classes.
    pub shares: Vec<f64>,
    /// The material ratio at each border, the share of all measured points above it, falling.
    pub material_ratio: Vec<f64>,
}

/// The distribution of `heights_m`, in m, over `classes` classes of equal width from `low_m` to `high_m`; NaN,
/// where nothing was measured, does not count. `None` without classes, width or measured points.
///
/// Formula: share of class k = points in it / all measured points; material ratio at a border = points above
/// it / all measured points. A height on a border belongs to the class above it, `high_m` to the last class.
///
/// Source: ISO 4287:1997, 4.5 (amplitude density and material ratio curve).
///
/// ```
/// use piezotact_surface::height_distribution;
/// let d = height_distribution(&[0.0, 1.0, 1.5, f64::NAN, 2.0], (0.0, 2.0), 2).unwrap();
/// assert_eq!(d.borders_m, [0.0, 1.0, 2.0]);
/// assert_eq!(d.shares, [0.25, 0.75]);
/// assert_eq!(d.material_ratio, [1.0, 0.75, 0.0]);
/// ```
#[must_use]
pub fn height_distribution(
    heights_m: &[f64],
    (low_m, high_m): (f64, f64),
    classes: usize,
) -> Option<HeightDistribution> {
    let width = (high_m - low_m) / classes as f64;
    let measured = || heights_m.iter().copied().filter(|z| z.is_finite());
    let all = measured().count() as f64;
    if classes == 0 || !(width > 0.0 && width.is_finite()) || all < 1.0 {
        return None;
    }
    let mut counts = vec![0usize; classes];
    let mut above = 0usize;
    for z in measured() {
        if z > high_m {
            above += 1;
        } else if z >= low_m {
            counts[(((z - low_m) / width) as usize).min(classes - 1)] += 1;
        }
    }
    let mut material_ratio: Vec<f64> = counts
        .iter()
        .rev()
        .scan(above, |above, count| {
            *above += count;
            Some(*above as f64 / all)
        })
        .collect();
    material_ratio.reverse();
    material_ratio.push(above as f64 / all);
    Some(HeightDistribution {
        borders_m: (0..=classes).map(|k| low_m + k as f64 * width).collect(),
        shares: counts.iter().map(|count| *count as f64 / all).collect(),
        material_ratio,
    })
}

/// The heights, in m, between which all but a share of `beyond_share` of `heights_m` lie, half of that share on
/// each side: what a scale of colours should span. `None` when nothing was measured.
///
/// Formula: the order statistics at the ranks ⌊b/2·(n − 1)⌋ from below and from above, b being that share.
///
/// Source: R. J. Hyndman and Y. Fan, Sample Quantiles in Statistical Packages, The American Statistician 50,
/// 1996: a quantile that is one of the values.
///
/// ```
/// let heights: Vec<f64> = (0..=100).map(f64::from).collect();
/// assert_eq!(piezotact_surface::height_limits_m(&heights, 0.04), Some((2.0, 98.0)));
/// ```
#[must_use]
pub fn height_limits_m(heights_m: &[f64], beyond_share: f64) -> Option<(f64, f64)> {
    let mut measured: Vec<f64> = heights_m
        .iter()
        .copied()
        .filter(|z| z.is_finite())
        .collect();
    let last = measured.len().checked_sub(1)?;
    let rank = ((beyond_share.clamp(0.0, 1.0) / 2.0 * last as f64) as usize).min(last / 2);
    let low = *measured.select_nth_unstable_by(rank, f64::total_cmp).1;
    let high = *measured
        .select_nth_unstable_by(last - rank, f64::total_cmp)
        .1;
    Some((low, high))
}

/// Classes of [`distribution_of`], at most, and points to each of them, at least on average.
const CLASSES: usize = 80;
const POINTS_PER_CLASS: usize = 10;
/// The share of the points whose height may lie beyond what is shown.
const BEYOND: f64 = 0.01;
/// A flat map still has a scale, m on both sides.
const FLAT_M: f64 = 1e-9;

/// The distribution of 99 % of `heights_m`, in m, in at most 80 classes of at least ten points on average. `None` when nothing was
/// measured, or all heights are the same.
///
/// Formula: [`height_distribution`] between the limits of [`height_limits_m`].
///
/// Source: as [`height_distribution`].
#[must_use]
pub fn distribution_of(heights_m: &[f64]) -> Option<HeightDistribution> {
    let range_m = height_limits_m(heights_m, BEYOND).unwrap_or_default();
    let classes = (heights_m.len() / POINTS_PER_CLASS).clamp(4, CLASSES);
    height_distribution(heights_m, range_m, classes)
}

/// From which to which height, m, 99 % of `heights_m` lie; a nanometre on both sides of a flat map.
///
/// Formula: [`height_limits_m`].
///
/// Source: as [`height_limits_m`].
///
/// ```
/// assert_eq!(piezotact_surface::height_span_m(&[0.0, 0.0]), (-1e-9, 1e-9));
/// ```
#[must_use]
pub fn height_span_m(heights_m: &[f64]) -> (f64, f64) {
    match height_limits_m(heights_m, BEYOND).unwrap_or_default() {
        (low, high) if low < high => (low, high),
        (low, high) => (low - FLAT_M, high + FLAT_M),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_measured_points_and_sum_to_one() {
        let heights: Vec<f64> = (0..1000)
            .map(|i| (f64::from(i) * 0.37).sin() * 1e-6)
            .chain([f64::NAN; 50])
            .collect();
        let d = height_distribution(&heights, (-1e-6, 1e-6), 40).unwrap();
        assert_eq!((d.borders_m.len(), d.material_ratio.len()), (41, 41));
        assert!((d.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(d.material_ratio.windows(2).all(|pair| pair[0] >= pair[1]));
        // half of a sine lies above its middle
        assert!((d.material_ratio[20] - 0.5).abs() < 0.01);
        let half = height_distribution(&heights, (-1e-6, 0.0), 20).unwrap();
        // one of the thousand is 0, the border, which is not above itself
        assert!((half.material_ratio[20] - d.material_ratio[20]).abs() < 0.0011);
        assert!((half.shares.iter().sum::<f64>() - 0.5).abs() < 0.01);
    }

    #[test]
    fn what_has_no_spread_has_no_distribution() {
        assert!(height_distribution(&[1.0; 9], (1.0, 1.0), 10).is_none());
        assert!(height_distribution(&[1.0, 2.0], (1.0, 2.0), 0).is_none());
        assert!(height_distribution(&[f64::NAN; 9], (0.0, 1.0), 10).is_none());
        assert!(height_limits_m(&[f64::NAN; 9], 0.01).is_none());
        assert_eq!(height_limits_m(&[3.0, 1.0], 0.01), Some((1.0, 3.0)));
        assert_eq!(height_limits_m(&[3.0, 1.0, 2.0], 7.0), Some((2.0, 2.0)));
    }
}
