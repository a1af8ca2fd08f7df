//! Spherical splines.

use crate::eeg::epochs::EpochsError;
use std::f64::consts::PI;

use piezotact::Warning;

use super::{Montage, dot, far};
use crate::eeg::linear::inverse;

/// The regularisation and stiffness of interpolated potentials, as MNE-Python sets them.
const INTERPOLATION: (f64, u32, usize) = (1e-5, 4, 50);

/// Values at any position of the head from those at channels: a planned sum over channels for each position.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    channels: usize,
    weights: Vec<f64>,
    /// What to know before relying on the values.
    pub warnings: Vec<Warning>,
}

impl Interpolation {
    /// The plan from the channels of `montage` to `positions`, which are set to length 1.
    ///
    /// Source: F. Perrin et al. (1989); as MNE-Python's `interpolate_bads` (λ = 1e-5, m = 4, 50 terms).
    ///
    /// # Errors
    /// [`EpochsError::Singular`] for electrodes that do not determine a spline.
    pub fn plan(montage: &Montage, positions: &[[f64; 3]]) -> Result<Self, EpochsError> {
        let (regularisation, stiffness, terms) = INTERPOLATION;
        let n = montage.positions.len();
        let positions: Vec<[f64; 3]> = positions.iter().map(|p| super::on_sphere(*p)).collect();
        let factors = factors(stiffness, terms);
        let own = matrix(
            &montage.positions,
            &montage.positions,
            &factors,
            regularisation,
        );
        let mut bordered = vec![1.0; (n + 1) * (n + 1)];
        for i in 0..n {
            bordered[i * (n + 1)..i * (n + 1) + n].copy_from_slice(&own[i * n..(i + 1) * n]);
        }
        bordered[n * (n + 1) + n] = 0.0;
        let inverted = inverse(&bordered, n + 1).ok_or(EpochsError::Singular { channels: n })?;
        let across = matrix(&positions, &montage.positions, &factors, 0.0);
        let mut weights = Vec::with_capacity(positions.len() * n);
        for row in across.chunks_exact(n) {
            for channel in 0..n {
                let sum: f64 = (0..n)
                    .map(|k| row[k] * inverted[k * (n + 1) + channel])
                    .sum();
                weights.push(sum + inverted[n * (n + 1) + channel]);
            }
        }
        Ok(Self {
            channels: n,
            weights,
            warnings: far(montage, &positions),
        })
    }

    /// The weights, positions × channels.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The value at each position from one value at each channel, in their unit.
    ///
    /// # Errors
    /// [`EpochsError::Shape`] unless there is one value for each channel.
    pub fn apply(&self, values: &[f64]) -> Result<Vec<f64>, EpochsError> {
        if values.len() != self.channels {
            return Err(EpochsError::Shape {
                expected: format!("one value for each of {} channels", self.channels),
                found: values.len().to_string(),
            });
        }
        let rows = self.weights.chunks_exact(self.channels);
        Ok(rows
            .map(|row| row.iter().zip(values).map(|(w, v)| w * v).sum())
            .collect())
    }
}

/// (2n + 1)/(4π·(n(n + 1))^`power`) for n from 1.
fn factors(power: u32, terms: usize) -> Vec<f64> {
    (1..=terms)
        .map(|n| {
            let n = n as f64;
            (2.0 * n + 1.0) / ((n * (n + 1.0)).powi(power as i32) * 4.0 * PI)
        })
        .collect()
}

/// Σ factorₙ·Pₙ(cos) of all pairs of positions, rows × columns, with `added` on the diagonal.
fn matrix(rows: &[[f64; 3]], columns: &[[f64; 3]], factors: &[f64], added: f64) -> Vec<f64> {
    let mut values = Vec::with_capacity(rows.len() * columns.len());
    for (i, row) in rows.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            let own = if i == j { added } else { 0.0 };
            values.push(legendre(dot(row, column), factors) + own);
        }
    }
    values
}

/// Σ factorₙ·Pₙ(x), n from 1.
fn legendre(x: f64, factors: &[f64]) -> f64 {
    let (mut before, mut now) = (1.0, x);
    let mut sum = 0.0;
    for (i, factor) in factors.iter().enumerate() {
        sum += factor * now;
        let n = (i + 1) as f64;
        let next = ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0);
        before = now;
        now = next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_at_electrodes_come_back() {
        let names = ["Fz", "Cz", "Pz", "C3", "C4", "O1", "O2", "F7", "F8"];
        let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
        let montage = Montage::ten_ten(&names).unwrap();
        let plan = Interpolation::plan(&montage, &montage.positions).unwrap();
        let values = [1.0, 2.0, -1.0, 0.5, 0.0, 3.0, 1.0, 1.0, 4.0];
        let found = plan.apply(&values).unwrap();
        // Smoothed by the regularisation: by less than a tenth of their range of 5.
        assert!(found.iter().zip(values).all(|(a, b)| (a - b).abs() < 0.5));
        assert!(plan.warnings.is_empty());
        // A constant stays one everywhere, and below the head nothing was measured.
        let below = Interpolation::plan(&montage, &[[0.0, 0.0, -1.0]]).unwrap();
        assert!((below.apply(&[7.0; 9]).unwrap()[0] - 7.0).abs() < 1e-9);
        assert_eq!(below.warnings.len(), 1);
        assert!(plan.apply(&values[1..]).is_err());
    }
}
