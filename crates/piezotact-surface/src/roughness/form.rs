//! The F-operator: takes the form of the part away from what was measured.

use serde::{Deserialize, Serialize};

use super::{Extent as _, HeightMap, HeightProfile, RoughnessError};

/// The highest degree of a polynomial form along a profile.
const PROFILE_DEGREE: usize = 10;
/// The highest total degree of a polynomial form of a map.
const MAP_DEGREE: usize = 4;
/// A term that is the earlier ones but for this share of it says nothing new about the points.
const NEW_SHARE: f64 = 1e-9;

/// The form that is taken away, fitted by least squares to the measured points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The mean height.
    Mean,
    /// The least-squares line of a profile, the least-squares plane of a map.
    Level,
    /// A polynomial of this degree: 1 to 10 along a profile, total degree 1 to 4 on a map.
    Polynomial(usize),
}

impl Form {
    fn degree(self, most: usize, points: usize) -> Result<usize, RoughnessError> {
        match self {
            Self::Mean => Ok(0),
            Self::Level => Ok(1),
            Self::Polynomial(degree) if (1..=most).contains(&degree) => Ok(degree),
            Self::Polynomial(degree) => Err(RoughnessError::Degree {
                degree,
                most,
                points,
            }),
        }
    }
}

/// `profile` without its form: as many heights about zero, in m.
///
/// Formula: z − Σ⟨z, qₖ⟩qₖ with qₖ the Chebyshev polynomials made orthonormal over the points.
///
/// Source: ISO 21920-2:2021, F-operation; Å. Björck, Numerical Methods
/// for Least Squares Problems, 2.4 (Gram–Schmidt, each term orthogonalised twice).
///
/// # Errors
/// [`RoughnessError::Degree`] when the degree is not 1–10 or has as many terms as there are points,
/// [`RoughnessError::Huge`] when the heights are beyond any surface.
pub fn remove_profile_form(
    profile: &HeightProfile,
    form: Form,
) -> Result<HeightProfile, RoughnessError> {
    super::computable(profile.heights_m(), profile.step_m())?;
    let n = profile.heights_m().len();
    let degree = form.degree(PROFILE_DEGREE, n)?;
    let mut residual = profile.heights_m().to_vec();
    fewer_terms(degree + 1, degree, PROFILE_DEGREE, n)?;
    let x: Vec<f64> = (0..n).map(|i| centred_index(i, n)).collect();
    let terms = (0..=degree).map(|k| x.iter().map(|x| chebyshev(k, *x)).collect());
    remove_terms(&mut residual, terms);
    Ok(profile.with_heights(residual))
}

/// `map` without its form: a map on the same grid, about zero, in m, NaN where `map` is.
///
/// Formula: as for a profile, with the products Tᵢ(x)Tⱼ(y), i + j up to the degree, over the measured points.
///
/// Source: ISO 25178-2:2021, F-operation; Å. Björck, Numerical Methods for Least Squares Problems, 2.4.
///
/// # Errors
/// [`RoughnessError::Degree`] when the degree is not 1–4 or has as many terms as there are measured points,
/// [`RoughnessError::Huge`] when the heights are beyond any surface.
pub fn remove_map_form(map: &HeightMap, form: Form) -> Result<HeightMap, RoughnessError> {
    super::computable(map.heights_m(), map.shorter_step_m())?;
    let measured: Vec<usize> = (0..map.heights_m().len())
        .filter(|i| !map.heights_m()[*i].is_nan())
        .collect();
    let degree = form.degree(MAP_DEGREE, measured.len())?;
    let powers = (0..=degree).flat_map(|total| (0..=total).map(move |j| (total - j, j)));
    fewer_terms(powers.clone().count(), degree, MAP_DEGREE, measured.len())?;
    let terms = powers.map(|(i, j)| {
        let x: Vec<f64> = chebyshev_along(i, map.columns());
        let y: Vec<f64> = chebyshev_along(j, map.rows());
        let at = |point: &usize| x[point % map.columns()] * y[point / map.columns()];
        measured.iter().map(at).collect()
    });
    let mut residual: Vec<f64> = measured.iter().map(|i| map.heights_m()[*i]).collect();
    remove_terms(&mut residual, terms);
    let mut heights_m = vec![f64::NAN; map.heights_m().len()];
    for (i, z) in measured.iter().zip(residual) {
        heights_m[*i] = z;
    }
    Ok(map.with_heights(heights_m))
}

fn fewer_terms(
    terms: usize,
    degree: usize,
    most: usize,
    points: usize,
) -> Result<(), RoughnessError> {
    // A mean and a level can always be taken: terms that the points cannot separate are left out.
    if degree <= 1 || terms < points {
        Ok(())
    } else {
        Err(RoughnessError::Degree {
            degree,
            most,
            points,
        })
    }
}

/// The place of point `i` of `n` on −1 … 1.
fn centred_index(i: usize, n: usize) -> f64 {
    2.0 * i as f64 / (n - 1) as f64 - 1.0
}

fn chebyshev_along(degree: usize, points: usize) -> Vec<f64> {
    (0..points)
        .map(|i| chebyshev(degree, centred_index(i, points)))
        .collect()
}

fn chebyshev(degree: usize, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    for _ in 0..degree {
        (before, now) = (now, 2.0 * x * now - before);
    }
    before
}

/// Takes from `values` their projection on the span of `terms`.
fn remove_terms(values: &mut [f64], terms: impl Iterator<Item = Vec<f64>>) {
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for mut term in terms {
        let before = norm(&term);
        for _ in 0..2 {
            for direction in &directions {
                remove_direction(&mut term, direction);
            }
        }
        let left = norm(&term);
        if left > NEW_SHARE * before {
            term.iter_mut().for_each(|v| *v /= left);
            directions.push(term);
        }
    }
    for _ in 0..2 {
        for direction in &directions {
            remove_direction(values, direction);
        }
    }
}

fn remove_direction(values: &mut [f64], direction: &[f64]) {
    let along: f64 = values.iter().zip(direction).map(|(v, d)| v * d).sum();
    for (value, d) in values.iter_mut().zip(direction) {
        *value -= along * d;
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_its_own_form() {
        for degree in 1..=PROFILE_DEGREE {
            let z = |i: usize| (0..=degree).map(|k| (i as f64 / 50.0).powi(k as i32)).sum();
            let profile = HeightProfile::new((0..200).map(z).collect(), 1e-6).unwrap();
            let largest = profile.heights_m()[199];
            let left = remove_profile_form(&profile, Form::Polynomial(degree)).unwrap();
            // rounding of heights up to `largest`
            assert!(norm(left.heights_m()) < 1e-13 * largest, "{degree}");
        }
    }

    #[test]
    fn a_tilted_bowl_with_holes_is_its_own_form() {
        let z = |i: usize| {
            let (x, y) = ((i % 30) as f64, (i / 30) as f64);
            if i % 7 == 3 || i < 40 {
                f64::NAN
            } else {
                5.0 + x - 2.0 * y + 0.01 * x * x + 0.02 * x * y - 0.03 * y * y
            }
        };
        let map = HeightMap::new((0..600).map(z).collect(), 30, 1e-6, 1e-6).unwrap();
        let left = remove_map_form(&map, Form::Polynomial(2)).unwrap();
        for (before, after) in map.heights_m().iter().zip(left.heights_m()) {
            assert_eq!(before.is_nan(), after.is_nan());
            assert!(after.is_nan() || after.abs() < 1e-11);
        }
        let level = remove_map_form(&map, Form::Level).unwrap();
        assert!(level.heights_m().iter().any(|z| z.abs() > 0.1));
    }

    #[test]
    fn what_is_no_form_is_refused() {
        let profile = HeightProfile::new(vec![1.0; 8], 1e-6).unwrap();
        for degree in [0, 7, 11, usize::MAX] {
            assert!(remove_profile_form(&profile, Form::Polynomial(degree)).is_err());
        }
        let line = [vec![1.0; 5], vec![f64::NAN; 20]].concat();
        let map = HeightMap::new(line, 5, 1.0, 1.0).unwrap();
        let left = remove_map_form(&map, Form::Level).unwrap();
        assert!(left.heights_m()[..5].iter().all(|z| z.abs() < 1e-14));
        assert!(remove_map_form(&map, Form::Polynomial(2)).is_err());
    }
}
