//! The autocorrelation of a height map, and the contour round its centre.

use num_complex::Complex;
use piezotact_fourier::ComplexPlanner;

use super::HeightMap;
use piezotact::fourier::{RealTransform, fast_length};

/// The autocorrelation at which Sal and Str look: ISO 25178-3's default.
pub(super) const LEVEL: f64 = 0.2;

/// The part of the autocorrelation round zero lag that stays above the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CentralLobe {
    /// It ends within half the map in every direction.
    Closed {
        /// The nearest point of its contour, m.
        nearest_m: f64,
        farthest_m: f64,
    },
    /// It reaches as far as lags do.
    Open {
        /// The nearest point of its contour, m, where it falls nearer than lags reach.
        nearest_m: Option<f64>,
        /// How far lags reach where it does not end, m.
        reached_m: f64,
    },
}

impl CentralLobe {
    pub(super) fn nearest_m(self) -> Option<f64> {
        match self {
            Self::Closed { nearest_m, .. } => Some(nearest_m),
            Self::Open { nearest_m, .. } => nearest_m,
        }
    }

    pub(super) fn aspect_ratio(self) -> Option<f64> {
        match self {
            Self::Closed {
                nearest_m,
                farthest_m,
            } => Some(nearest_m / farthest_m),
            Self::Open { .. } => None,
        }
    }
}

/// The autocorrelation at lags of up to half the map each way, zero lag in the middle.
///
/// Formula: mean of z(r)·z(r + τ) over the pairs of measured points at lag τ, over the mean of z².
pub(super) struct Correlogram {
    pub(super) values: Vec<f64>,
    /// The largest lag in rows and in columns.
    pub(super) most: (usize, usize),
    pub(super) step_x_m: f64,
    pub(super) step_y_m: f64,
}

impl Correlogram {
    /// That of `map`, whose heights are about zero and not all zero.
    pub(super) fn of(map: &HeightMap) -> Self {
        let most = (map.rows() / 2, map.columns() / 2);
        let largest = map.heights_m().iter().fold(0.0f64, |m, z| m.max(z.abs()));
        let heights = map.heights_m().iter();
        let heights: Vec<f64> = heights
            .map(|z| if z.is_nan() { 0.0 } else { z / largest })
            .collect();
        let measured = map
            .heights_m()
            .iter()
            .map(|z| f64::from(u8::from(!z.is_nan())));
        let products = lagged_products(&heights, map.columns(), most);
        let pairs = lagged_products(&measured.collect::<Vec<_>>(), map.columns(), most);
        let width = 2 * most.1 + 1;
        let centre = most.0 * width + most.1;
        let variance = products[centre] / pairs[centre];
        let values = products.iter().zip(&pairs).map(|(product, pairs)| {
            // counts are whole, up to the rounding of the transform
            let mean = if *pairs < 0.5 { 0.0 } else { product / pairs };
            mean / variance
        });
        Self {
            values: values.collect(),
            most,
            step_x_m: map.step_x_m(),
            step_y_m: map.step_y_m(),
        }
    }

    fn width(&self) -> usize {
        2 * self.most.1 + 1
    }

    fn centre(&self) -> usize {
        self.most.0 * self.width() + self.most.1
    }

    fn lag_m(&self, at: usize) -> (f64, f64) {
        let (row, column) = (at / self.width(), at % self.width());
        (
            (column as f64 - self.most.1 as f64) * self.step_x_m,
            (row as f64 - self.most.0 as f64) * self.step_y_m,
        )
    }

    /// The four points beside `at`, fewer at an edge.
    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> {
        let (width, height) = (self.width(), self.values.len() / self.width());
        let (row, column) = (at / width, at % width);
        let sides = [
            (column > 0).then(|| at - 1),
            (column + 1 < width).then_some(at + 1),
            (row > 0).then(|| at - width),
            (row + 1 < height).then_some(at + width),
        ];
        sides.into_iter().flatten()
    }

    /// The points that connect to zero lag, side by side, without falling to the level in between.
    fn connected(&self) -> Vec<usize> {
        let mut seen = vec![false; self.values.len()];
        let mut points = vec![self.centre()];
        seen[self.centre()] = true;
        let mut next = 0;
        while let Some(&at) = points.get(next) {
            next += 1;
            for beside in self.neighbours(at) {
                if !seen[beside] && self.values[beside] > LEVEL {
                    seen[beside] = true;
                    points.push(beside);
                }
            }
        }
        points
    }

    /// The part round zero lag that stays above the level.
    pub(super) fn lobe(&self) -> CentralLobe {
        let (mut nearest_m, mut farthest_m) = (f64::INFINITY, 0.0f64);
        let mut reached_m = f64::INFINITY;
        for at in self.connected() {
            let mut sides = 0;
            for beside in self.neighbours(at) {
                sides += 1;
                if self.values[beside] <= LEVEL {
                    let crossing_m = self.crossing_m(at, beside);
                    nearest_m = nearest_m.min(crossing_m);
                    farthest_m = farthest_m.max(crossing_m);
                }
            }
            if sides < 4 {
                let (x_m, y_m) = self.lag_m(at);
                reached_m = reached_m.min(x_m.hypot(y_m));
            }
        }
        if reached_m.is_finite() {
            CentralLobe::Open {
                nearest_m: (nearest_m < reached_m).then_some(nearest_m),
                reached_m,
            }
        } else {
            CentralLobe::Closed {
                nearest_m,
                farthest_m,
            }
        }
    }

    /// How far from zero lag the line from `inside` to `outside` falls to the level.
    fn crossing_m(&self, inside: usize, outside: usize) -> f64 {
        let (from, to) = (self.values[inside], self.values[outside]);
        let share = (from - LEVEL) / (from - to);
        let ((x0, y0), (x1, y1)) = (self.lag_m(inside), self.lag_m(outside));
        (x0 + share * (x1 - x0)).hypot(y0 + share * (y1 - y0))
    }
}

/// Σ v(r)·v(r + τ) over the pairs of points of a map at every lag τ of up to `most` rows and columns each way.
fn lagged_products(values: &[f64], columns: usize, most: (usize, usize)) -> Vec<f64> {
    let rows = values.len() / columns;
    let mut along_x = RealTransform::new(fast_length(columns + most.1));
    let length_y = fast_length(rows + most.0);
    let bins = along_x.length() / 2 + 1;
    let mut spectrum = vec![Complex::default(); length_y * bins];
    for (row, to) in values
        .chunks_exact(columns)
        .zip(spectrum.chunks_exact_mut(bins))
    {
        to.copy_from_slice(&along_x.forward(row));
    }
    square_along_y(&mut spectrum, bins);
    let width = 2 * most.1 + 1;
    let mut products = Vec::with_capacity((2 * most.0 + 1) * width);
    for row in (length_y - most.0..length_y).chain(0..=most.0) {
        let lags = along_x.inverse(spectrum[row * bins..(row + 1) * bins].to_vec());
        products.extend_from_slice(&lags[lags.len() - most.1..]);
        products.extend_from_slice(&lags[..=most.1]);
    }
    products
}

/// Turns transforms of rows into transforms, of rows only, of the autocorrelation.
fn square_along_y(spectrum: &mut [Complex<f64>], bins: usize) {
    let length = spectrum.len() / bins;
    let mut planner = ComplexPlanner::new();
    let forward = planner.plan_fft_forward(length);
    let inverse = planner.plan_fft_inverse(length);
    let scratch = forward
        .get_inplace_scratch_len()
        .max(inverse.get_inplace_scratch_len());
    let mut scratch = vec![Complex::default(); scratch];
    let mut column = vec![Complex::default(); length];
    for bin in 0..bins {
        for (to, from) in column.iter_mut().zip(spectrum[bin..].iter().step_by(bins)) {
            *to = *from;
        }
        forward.process_with_scratch(&mut column, &mut scratch);
        for value in &mut column {
            *value = Complex::from(value.norm_sqr() / length as f64);
        }
        inverse.process_with_scratch(&mut column, &mut scratch);
        for (to, from) in spectrum[bin..].iter_mut().step_by(bins).zip(&column) {
            *to = *from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_correlation_is_the_definition() {
        let (rows, columns) = (9, 14);
        let z = |i: usize| ((i * i) as f64).sin();
        let values: Vec<f64> = (0..rows * columns).map(z).collect();
        let most = (rows / 2, columns / 2);
        let got = lagged_products(&values, columns, most);
        let mut at = 0;
        for down in -(most.0 as isize)..=most.0 as isize {
            for right in -(most.1 as isize)..=most.1 as isize {
                let mut sum = 0.0;
                for i in 0..values.len() {
                    let row = (i / columns).checked_add_signed(down);
                    let column = (i % columns).checked_add_signed(right);
                    if let (Some(r), Some(c)) = (row, column)
                        && r < rows
                        && c < columns
                    {
                        sum += values[i] * values[r * columns + c];
                    }
                }
                assert!((got[at] - sum).abs() < 1e-12, "{down} {right}");
                at += 1;
            }
        }
    }

    #[test]
    fn the_contour_of_a_cosine_is_where_it_should_be() {
        let wave = |points: f64, i: usize| (i as f64 / points * std::f64::consts::TAU).cos();
        let z = |i: usize| wave(25.0, i % 200) * wave(50.0, i / 200);
        let map = HeightMap::new((0..40_000).map(z).collect(), 200, 1e-6, 1e-6).unwrap();
        let lobe = Correlogram::of(&map).lobe();
        let at_level = (0.2f64).acos() / std::f64::consts::TAU;
        // overlaps hold no whole number of waves
        let nearest_m = lobe.nearest_m().unwrap();
        assert!(
            (nearest_m - 25e-6 * at_level).abs() < 0.15e-6,
            "{nearest_m}"
        );
        let ratio = lobe.aspect_ratio().unwrap();
        assert!((ratio - 0.5).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn ridges_leave_the_aspect_open() {
        let z = |i: usize| ((i % 60) as f64 / 20.0 * std::f64::consts::TAU).cos();
        let map = HeightMap::new((0..3600).map(z).collect(), 60, 1e-6, 1e-6).unwrap();
        let lobe = Correlogram::of(&map).lobe();
        assert_eq!(lobe.aspect_ratio(), None);
        assert!((lobe.nearest_m().unwrap() - 4.36e-6).abs() < 0.2e-6);
    }
}
