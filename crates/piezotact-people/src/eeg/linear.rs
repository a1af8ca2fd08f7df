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

/// The product of a matrix of `rows` × `inner` and one of `inner` × `columns`.
pub(super) fn product(a: &[f64], b: &[f64], rows: usize, inner: usize, columns: usize) -> Vec<f64> {
    let mut out = vec![0.0; rows * columns];
    for (row, out) in out.chunks_exact_mut(columns).enumerate() {
        for k in 0..inner {
            let factor = a[row * inner + k];
            for (sum, value) in out.iter_mut().zip(&b[k * columns..(k + 1) * columns]) {
                *sum += factor * value;
            }
        }
    }
    out
}

/// A matrix of `rows` × `columns` with its rows as columns.
pub(super) fn transposed(matrix: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..columns)
        .flat_map(|column| (0..rows).map(move |row| matrix[row * columns + column]))
        .collect()
}

/// Eigenvalues in descending order, and eigenvectors as rows in the same order, of a symmetric matrix of `n` rows: cyclic Jacobi
/// rotations (C. G. J. Jacobi 1846, J. reine angew. Math. 30).
pub(super) fn eigen(matrix: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut a = matrix.to_vec();
    let mut vectors = vec![0.0; n * n];
    for i in 0..n {
        vectors[i * n + i] = 1.0;
    }
    for _ in 0..60 {
        let off: f64 = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| a[i * n + j] * a[i * n + j])
            .sum();
        let diagonal: f64 = (0..n).map(|i| a[i * n + i] * a[i * n + i]).sum();
        if off <= 1e-30 * diagonal {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(&mut a, &mut vectors, n, p, q);
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|i, j| a[j * n + j].total_cmp(&a[i * n + i]));
    let values = order.iter().map(|i| a[i * n + i]).collect();
    let rows = order
        .iter()
        .flat_map(|i| vectors[i * n..(i + 1) * n].iter().copied())
        .collect();
    (values, rows)
}

/// One rotation that makes the element `p`, `q` zero; `vectors` holds eigenvectors as rows.
fn rotate(a: &mut [f64], vectors: &mut [f64], n: usize, p: usize, q: usize) {
    let apq = a[p * n + q];
    if apq == 0.0 {
        return;
    }
    let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * apq);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let t = if theta == 0.0 { 1.0 } else { t };
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for k in 0..n {
        let (akp, akq) = (a[k * n + p], a[k * n + q]);
        a[k * n + p] = c * akp - s * akq;
        a[k * n + q] = s * akp + c * akq;
    }
    for k in 0..n {
        let (apk, aqk) = (a[p * n + k], a[q * n + k]);
        a[p * n + k] = c * apk - s * aqk;
        a[q * n + k] = s * apk + c * aqk;
        let (vpk, vqk) = (vectors[p * n + k], vectors[q * n + k]);
        vectors[p * n + k] = c * vpk - s * vqk;
        vectors[q * n + k] = s * vpk + c * vqk;
    }
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
        let one = product(&a, &inverse(&a, n).unwrap(), n, n, n);
        for i in 0..n {
            for j in 0..n {
                let expected = f64::from(u8::from(i == j));
                assert!((one[i * n + j] - expected).abs() < 1e-12);
            }
        }
        assert_eq!(inverse(&[1.0, 2.0, 2.0, 4.0], 2), None);
        assert_eq!(
            transposed(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2, 3),
            [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]
        );
    }

    #[test]
    fn a_symmetric_matrix_is_its_eigenvectors() {
        let n = 9;
        let mut random = Random::stream(4, 0, "matrix");
        let root: Vec<f64> = (0..n * n).map(|_| random.normal()).collect();
        let a = product(&root, &transposed(&root, n, n), n, n, n);
        let (values, vectors) = eigen(&a, n);
        assert!(values.windows(2).all(|pair| pair[0] >= pair[1]));
        for (k, value) in values.iter().enumerate() {
            let v = &vectors[k * n..(k + 1) * n];
            let av = product(&a, v, n, n, 1);
            assert!(av.iter().zip(v).all(|(x, y)| (x - value * y).abs() < 1e-10));
        }
    }
}
