//! Small dense matrices, row after row in one buffer.

/// The inverse of a square matrix of `n` rows, by Gauss–Jordan elimination with partial pivoting; `None` where it is singular.
pub(super) fn inverse(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut left = matrix.to_vec();
    let mut right = vec![0.0; n * n];
    for i in 0..n {
        right[i * n + i] = 1.0;
    }
    let scale = matrix.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    for column in 0..n {
        let pivot = (column..n).max_by(|a, b| {
            left[a * n + column]
                .abs()
                .total_cmp(&left[b * n + column].abs())
        })?;
        if left[pivot * n + column].abs() <= f64::EPSILON * scale {
            return None;
        }
        if pivot != column {
            for k in 0..n {
                left.swap(pivot * n + k, column * n + k);
                right.swap(pivot * n + k, column * n + k);
            }
        }
        let by = 1.0 / left[column * n + column];
        for k in 0..n {
            left[column * n + k] *= by;
            right[column * n + k] *= by;
        }
        for row in (0..n).filter(|row| *row != column) {
            let factor = left[row * n + column];
            if factor == 0.0 {
                continue;
            }
            for k in 0..n {
                left[row * n + k] -= factor * left[column * n + k];
                right[row * n + k] -= factor * right[column * n + k];
            }
        }
    }
    right.iter().all(|v| v.is_finite()).then_some(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let n = 7;
        let mut random = Random::stream(3, 0, "matrix");
        let a: Vec<f64> = (0..n * n).map(|_| random.normal()).collect();
        let inverted = inverse(&a, n).unwrap();
        for i in 0..n {
            for j in 0..n {
                let expected = f64::from(u8::from(i == j));
                let product: f64 = (0..n).map(|k| a[i * n + k] * inverted[k * n + j]).sum();
                assert!((product - expected).abs() < 1e-12);
            }
        }
        assert_eq!(inverse(&[1.0, 2.0, 2.0, 4.0], 2), None);
    }
}
