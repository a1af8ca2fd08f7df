//! The Gaussian filter of profiles and maps: the mean line and the mean surface.

use num_complex::Complex;

use super::{Extent as _, HeightMap, HeightProfile, RoughnessError};
use piezotact::fourier::{RealTransform, fast_length};

/// √(ln 2/π): with it the filter passes one half at its cut-off.
pub(super) const ALPHA: f64 = 0.469_718_639_349_825_66;

/// The mean line of `profile` at `cutoff_m`: as many heights, in m. The roughness profile is the profile
/// minus its mean line.
///
/// Formula: Σwz/Σw with w(x) = exp(−π(x/(αλc))²), α = √(ln 2/π), out to ±λc; beyond its ends the profile
/// is continued by its mirror image; a wave of length λ passes with exp(−π(αλc/λ)²).
///
/// Source: ISO 16610-21:2011, with the truncation constant Lc = 1; ISO 16610-28:2016 for the ends (symmetrical
/// reflection).
///
/// # Errors
/// [`RoughnessError::Cutoff`] when the cut-off is not above zero and finite, [`RoughnessError::Huge`] when the
/// heights are beyond any surface.
///
/// ```
/// use piezotact_surface::{HeightProfile, profile_mean_line};
/// let wave = |i: i32| (f64::from(i) * 1e-6 / 0.8e-3 * std::f64::consts::TAU).sin();
/// let profile = HeightProfile::new((0..8000).map(wave).collect(), 1e-6).unwrap();
/// let mean_line = profile_mean_line(&profile, 0.8e-3).unwrap();
/// assert!((mean_line.heights_m()[4200] - 0.5).abs() < 1e-5); // a crest, one half of it at the cut-off
/// ```
pub fn profile_mean_line(
    profile: &HeightProfile,
    cutoff_m: f64,
) -> Result<HeightProfile, RoughnessError> {
    valid_cutoff(cutoff_m, profile.step_m(), profile.length_m())?;
    super::computable(profile.heights_m(), profile.step_m())?;
    let n = profile.heights_m().len();
    let reach = reach(profile.step_m(), cutoff_m, n);
    let (centred, offset_m) = centred(profile.heights_m());
    let before = centred[..reach].iter().rev();
    let after = centred[n - reach..].iter().rev();
    let longer: Vec<f64> = before.chain(&centred).chain(after).copied().collect();
    let mut line = Smoothing::new(longer.len(), profile.step_m(), cutoff_m);
    let weights = line.smooth(&vec![1.0; longer.len()]);
    let sums = line.smooth(&longer);
    let inner = sums.iter().zip(&weights).skip(reach).take(n);
    Ok(profile.with_heights(inner.map(|(z, w)| offset_m + z / w).collect()))
}

/// The mean surface of `map` at `nesting_m`: a map on the same grid, in m, NaN where `map` is. The
/// roughness is the map minus its mean surface.
///
/// Formula: Σwz/Σw over measured points with w(x, y) = exp(−π(x² + y²)/(αλ)²), α = √(ln 2/π), out to ±λ
/// in x and in y.
///
/// Source: ISO 16610-61:2015; the kernel is separable, so rows and columns are taken in turn.
///
/// # Errors
/// [`RoughnessError::Cutoff`] when the nesting index is not above zero and finite, [`RoughnessError::Huge`] when
/// the heights are beyond any surface.
pub fn map_mean_surface(map: &HeightMap, nesting_m: f64) -> Result<HeightMap, RoughnessError> {
    valid_cutoff(nesting_m, map.shorter_step_m(), map.longer_side_m())?;
    super::computable(map.heights_m(), map.shorter_step_m())?;
    let (centred, offset_m) = centred(map.heights_m());
    let measured = map.heights_m().iter();
    let mut weights = measured
        .map(|z| if z.is_nan() { 0.0 } else { 1.0 })
        .collect::<Vec<_>>();
    let mut sums = centred;
    let mut along_x = Smoothing::new(map.columns(), map.step_x_m(), nesting_m);
    let mut along_y = Smoothing::new(map.rows(), map.step_y_m(), nesting_m);
    for values in [&mut sums, &mut weights] {
        smooth_both_ways(values, &mut along_x, &mut along_y);
    }
    let heights = map.heights_m().iter().zip(sums.iter().zip(&weights));
    let surface = heights.map(|(z, (sum, weight))| {
        if z.is_nan() {
            f64::NAN
        } else {
            offset_m + sum / weight
        }
    });
    Ok(map.with_heights(surface.collect()))
}

fn valid_cutoff(cutoff_m: f64, step_m: f64, length_m: f64) -> Result<(), RoughnessError> {
    if cutoff_m > 0.0 && cutoff_m.is_finite() {
        Ok(())
    } else {
        Err(RoughnessError::cutoff(cutoff_m, step_m, length_m))
    }
}

fn smooth_both_ways(values: &mut [f64], along_x: &mut Smoothing, along_y: &mut Smoothing) {
    let columns = along_x.points;
    for row in values.chunks_exact_mut(columns) {
        row.copy_from_slice(&along_x.smooth(row));
    }
    let mut column = vec![0.0; along_y.points];
    for c in 0..columns {
        for (to, from) in column.iter_mut().zip(values[c..].iter().step_by(columns)) {
            *to = *from;
        }
        for (to, from) in values[c..]
            .iter_mut()
            .step_by(columns)
            .zip(along_y.smooth(&column))
        {
            *to = from;
        }
    }
}

/// The heights about their mean, with 0 where nothing was measured, and that mean.
fn centred(heights_m: &[f64]) -> (Vec<f64>, f64) {
    let mean_m = super::mean(heights_m.iter().copied().filter(|z| !z.is_nan()));
    let about = |z: &f64| if z.is_nan() { 0.0 } else { z - mean_m };
    (heights_m.iter().map(about).collect(), mean_m)
}

/// The steps that a cut-off reaches, at most `most`.
fn reach(step_m: f64, cutoff_m: f64, most: usize) -> usize {
    ((cutoff_m / step_m + 1e-9) as usize).min(most)
}

/// The sum of the Gaussian's weights times the values around every point of a line, planned once.
struct Smoothing {
    points: usize,
    transform: RealTransform,
    kernel: Vec<Complex<f64>>,
}

impl Smoothing {
    fn new(points: usize, step_m: f64, cutoff_m: f64) -> Self {
        // Weights further out than the line is long meet no point.
        let reach = reach(step_m, cutoff_m, points - 1);
        let mut transform = RealTransform::new(fast_length(points + reach));
        let mut kernel = vec![0.0; transform.length()];
        kernel[0] = 1.0;
        for k in 1..=reach {
            let x = k as f64 * step_m / (ALPHA * cutoff_m);
            let weight = (-std::f64::consts::PI * x * x).exp();
            kernel[k] = weight;
            kernel[transform.length() - k] = weight;
        }
        Self {
            points,
            kernel: transform.forward(&kernel),
            transform,
        }
    }

    fn smooth(&mut self, values: &[f64]) -> Vec<f64> {
        let mut bins = self.transform.forward(values);
        for (bin, weight) in bins.iter_mut().zip(&self.kernel) {
            *bin *= weight.re;
        }
        let mut smoothed = self.transform.inverse(bins);
        smoothed.truncate(self.points);
        smoothed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filter as its definition says, point by point.
    fn direct(z: &[f64], step_m: f64, cutoff_m: f64) -> Vec<f64> {
        let weight = |d: f64| {
            if d.abs() > cutoff_m * (1.0 + 1e-9) {
                return 0.0;
            }
            (-std::f64::consts::PI * (d / (ALPHA * cutoff_m)).powi(2)).exp()
        };
        let mean = |i: usize| {
            let points = z.iter().enumerate().filter(|(_, z)| !z.is_nan());
            let (sum, weights) = points.fold((0.0, 0.0), |(s, ws), (j, z)| {
                let w = weight((j as f64 - i as f64) * step_m);
                (s + w * z, ws + w)
            });
            sum / weights
        };
        (0..z.len()).map(mean).collect()
    }

    #[test]
    fn the_quick_filter_is_the_definition() {
        for (n, cutoff_m) in [(8, 3.0), (50, 10.0), (51, 49.0), (30, 400.0), (20, 0.3)] {
            let z: Vec<f64> = (0..n)
                .map(|i| ((i * i) as f64).sin() + 40.0 + i as f64)
                .collect();
            let mirrored = (cutoff_m as usize).min(n);
            let before = z[..mirrored].iter().rev();
            let after = z[n - mirrored..].iter().rev();
            let longer: Vec<f64> = before.chain(&z).chain(after).copied().collect();
            let expected = &direct(&longer, 1.0, cutoff_m)[mirrored..mirrored + n];
            let profile = HeightProfile::new(z, 1.0).unwrap();
            let got = profile_mean_line(&profile, cutoff_m).unwrap();
            for (g, e) in got.heights_m().iter().zip(expected) {
                // the rounding of the transform
                assert!((g - e).abs() < 1e-11, "{n} {cutoff_m}: {g} {e}");
            }
        }
    }

    #[test]
    fn transmission_is_the_standards() {
        let (step_m, cutoff_m) = (2e-6, 0.8e-3);
        for wave_m in [0.2e-3, 0.4e-3, 0.8e-3, 1.6e-3, 3.2e-3] {
            let wave = |i: usize| (i as f64 * step_m / wave_m * std::f64::consts::TAU).cos();
            let profile = HeightProfile::new((0..6401).map(wave).collect(), step_m).unwrap();
            let line = profile_mean_line(&profile, cutoff_m).unwrap();
            let expected = (-std::f64::consts::PI * (ALPHA * cutoff_m / wave_m).powi(2)).exp();
            let middle = line.heights_m()[3200];
            // what the truncation at one cut-off leaves out
            assert!(
                (middle - expected).abs() < 2e-6,
                "{wave_m}: {middle} {expected}"
            );
        }
    }

    #[test]
    fn missing_points_stay_missing_and_weigh_nothing() {
        let mut z = vec![3.5e-6; 35];
        z[17] = f64::NAN;
        z[0] = f64::NAN;
        let map = HeightMap::new(z, 7, 1e-6, 2e-6).unwrap();
        let surface = map_mean_surface(&map, 5e-6).unwrap();
        for (i, z) in surface.heights_m().iter().enumerate() {
            if [0, 17].contains(&i) {
                assert!(z.is_nan());
            } else {
                assert!((z - 3.5e-6).abs() < 1e-18, "{i}: {z}");
            }
        }
    }

    #[test]
    fn a_map_of_equal_rows_is_its_profile_away_from_the_ends() {
        let z: Vec<f64> = (0..40).map(|i| ((i * i) as f64).sin()).collect();
        let profile = HeightProfile::new(z.clone(), 1.0).unwrap();
        let line = profile_mean_line(&profile, 9.0).unwrap();
        let map = HeightMap::new(z.repeat(25), 40, 1.0, 1.5).unwrap();
        let surface = map_mean_surface(&map, 9.0).unwrap();
        for row in surface.heights_m().chunks(40) {
            for (a, b) in row.iter().zip(line.heights_m()).skip(9).take(22) {
                assert!((a - b).abs() < 1e-13);
            }
        }
    }
}
