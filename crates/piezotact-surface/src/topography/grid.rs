//! Coordinates that fill a grid, or a line, in even steps.

/// Points that lie closer to their place than this share of a step are even.
pub(super) const EVEN: f64 = 0.01;
/// A point that is further from its place than this share of a step belongs to no grid.
pub(super) const GAP: f64 = 0.25;
/// Coordinates that differ by less than this share of the widest gap are one: no gap is wider than three steps.
const ONE: f64 = 0.3;

/// Evenly spaced places along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    first: f64,
    pub(super) step: f64,
    pub(super) count: usize,
    /// The largest distance of a point from its place, as a share of the step.
    pub(super) worst: f64,
}

impl Axis {
    /// The axis on which `values` lie, in any order and any number of times; what is wrong with them otherwise.
    pub(super) fn of(values: &[f64]) -> Result<Self, String> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let widest = sorted
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(0.0, f64::max);
        let centres: Vec<f64> = sorted
            .chunk_by(|a, b| b - a <= ONE * widest)
            .map(|one| one.iter().sum::<f64>() / one.len() as f64)
            .collect();
        let (Some(first), Some(last)) = (centres.first(), centres.last()) else {
            return Err("no coordinates".into());
        };
        let gaps: Vec<f64> = centres.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut ordered = gaps.clone();
        ordered.sort_by(f64::total_cmp);
        let Some(usual) = ordered.get(ordered.len() / 2) else {
            return Err(format!("all at {first}"));
        };
        let mut steps = 0;
        for gap in &gaps {
            let count = (gap / usual).round();
            if (gap / usual - count).abs() > GAP {
                return Err(format!("steps of {usual} and of {gap}"));
            }
            steps += count as usize;
        }
        let mut axis = Self {
            first: *first,
            step: (last - first) / steps as f64,
            count: steps + 1,
            worst: 0.0,
        };
        for value in values {
            let place = (value - axis.first) / axis.step;
            let off = (place - place.round()).abs();
            if off > GAP || off.is_nan() {
                return Err(format!("{value} between its places {} apart", axis.step));
            }
            axis.worst = axis.worst.max(off);
        }
        Ok(axis)
    }

    /// The place of a coordinate, from 0.
    pub(super) fn place(&self, value: f64) -> usize {
        let place = ((value - self.first) / self.step).round();
        (place.max(0.0) as usize).min(self.count.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_through_jitter_and_gaps() {
        let axis = Axis::of(&[0.3, 0.1, 0.2, 0.1, 0.6, 0.5]).unwrap();
        assert_eq!((axis.count, axis.place(0.6)), (6, 5));
        assert!((axis.step - 0.1).abs() < 1e-12 && axis.worst < 1e-9);
        let axis = Axis::of(&[0.0, 1.05, 2.0, 3.0, 0.02]).unwrap();
        assert!(axis.count == 4 && axis.worst > EVEN, "{axis:?}");
        for wrong in [
            &[][..],
            &[1.0, 1.0],
            &[0.0, 1.0, 2.0, 3.5],
            &[0.0, 1.0, 2.0, 3.0, 7.0],
            &[-f64::MAX, 0.0, f64::MAX],
            &[0.0, 0.27, 0.55, 0.8, 1.9],
        ] {
            assert!(Axis::of(wrong).is_err(), "{wrong:?}");
        }
    }
}
