//! How the heights of a surface are distributed.

/// The distribution of heights in classes of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightDistribution {
    /// The borders of the classes, one more than classes, rising, in m.
    pub borders_m: Vec<f64>,
    /// The share of the measured points in each class; together 1.
    pub shares: Vec<f64>,
    /// The material ratio at each border, the share of the measured points above it: from 1 down to 0.
    pub material_ratio: Vec<f64>,
}

/// The distribution of `heights_m`, in m, over `classes` classes from the lowest height to the highest; NaN,
/// where nothing was measured, does not count. `None` without classes, and where all heights are one.
///
/// Formula: share of class k = points in it / all measured points; material ratio at a border = sum of the
/// shares above it. A height on a border belongs to the class above it, the highest to the last class.
///
/// Source: ISO 4287:1997, 4.5 (amplitude density and material ratio curve).
///
/// ```
/// use piezotact::surface::height_distribution;
/// let d = height_distribution(&[0.0, 1.0, 1.5, f64::NAN, 2.0], 2).unwrap();
/// assert_eq!(d.borders_m, [0.0, 1.0, 2.0]);
/// assert_eq!(d.shares, [0.25, 0.75]);
/// assert_eq!(d.material_ratio, [1.0, 0.75, 0.0]);
/// ```
#[must_use]
pub fn height_distribution(heights_m: &[f64], classes: usize) -> Option<HeightDistribution> {
    let measured = || heights_m.iter().copied().filter(|z| z.is_finite());
    let low = measured().reduce(f64::min)?;
    let high = measured().reduce(f64::max)?;
    let width = (high - low) / classes as f64;
    if classes == 0 || !(width > 0.0 && width.is_finite()) {
        return None;
    }
    let mut counts = vec![0usize; classes];
    for z in measured() {
        counts[(((z - low) / width) as usize).min(classes - 1)] += 1;
    }
    let all = counts.iter().sum::<usize>() as f64;
    let mut above = counts.iter().sum::<usize>();
    let mut material_ratio = vec![1.0];
    for count in &counts {
        above -= count;
        material_ratio.push(above as f64 / all);
    }
    Some(HeightDistribution {
        borders_m: (0..=classes).map(|k| low + k as f64 * width).collect(),
        shares: counts.iter().map(|count| *count as f64 / all).collect(),
        material_ratio,
    })
}

/// The heights, in m, between which all but a share of `beyond` of `heights_m` lie, half of that share on
/// each side: what a scale of colours should span. `None` when nothing was measured.
///
/// Formula: the order statistics at the ranks ⌊beyond/2·(n − 1)⌋ from below and from above.
///
/// Source: R. J. Hyndman and Y. Fan, Sample Quantiles in Statistical Packages, The American Statistician 50,
/// 1996: a quantile that is one of the values.
///
/// ```
/// let heights: Vec<f64> = (0..=100).map(f64::from).collect();
/// assert_eq!(piezotact::surface::height_limits_m(&heights, 0.04), Some((2.0, 98.0)));
/// ```
#[must_use]
pub fn height_limits_m(heights_m: &[f64], beyond: f64) -> Option<(f64, f64)> {
    let mut measured: Vec<f64> = heights_m
        .iter()
        .copied()
        .filter(|z| z.is_finite())
        .collect();
    let last = measured.len().checked_sub(1)?;
    let rank = ((beyond.clamp(0.0, 1.0) / 2.0 * last as f64) as usize).min(last / 2);
    let low = *measured.select_nth_unstable_by(rank, f64::total_cmp).1;
    let high = *measured
        .select_nth_unstable_by(last - rank, f64::total_cmp)
        .1;
    Some((low, high))
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
        let d = height_distribution(&heights, 40).unwrap();
        assert_eq!((d.borders_m.len(), d.material_ratio.len()), (41, 41));
        assert!((d.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(d.material_ratio.windows(2).all(|pair| pair[0] >= pair[1]));
        // half of a sine lies above its middle
        assert!((d.material_ratio[20] - 0.5).abs() < 0.01);
    }

    #[test]
    fn what_has_no_spread_has_no_distribution() {
        assert!(height_distribution(&[1.0; 9], 10).is_none());
        assert!(height_distribution(&[1.0, 2.0], 0).is_none());
        assert!(height_distribution(&[f64::NAN; 9], 10).is_none());
        assert!(height_limits_m(&[f64::NAN; 9], 0.01).is_none());
        assert_eq!(height_limits_m(&[3.0, 1.0], 0.01), Some((1.0, 3.0)));
        assert_eq!(height_limits_m(&[3.0, 1.0, 2.0], 7.0), Some((2.0, 2.0)));
    }
}
