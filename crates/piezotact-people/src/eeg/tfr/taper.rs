//! Discrete prolate spheroidal sequences (Slepian tapers).

use std::f64::consts::PI;

/// The first `count` tapers of `samples` with a time-half-bandwidth product of `half_bandwidth`, and the share of the energy of each
/// in its band; `None` where there are no such tapers.
///
/// Those of `samples` + 1 without the last, as SciPy's periodic windows (`dpss(sym=False)`); norm 1 before that. The sum of the even ones
/// is positive, the odd ones begin positive.
///
/// Source: D. Slepian (1978), Bell Syst. Tech. J. 57; the tridiagonal form of D. B. Percival and A. T. Walden (1993), *Spectral Analysis
/// for Physical Applications*, section 8.3.
pub(super) fn tapers(
    samples: usize,
    half_bandwidth: f64,
    count: usize,
) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
    let n = samples + 1;
    if samples < 2
        || count == 0
        || count > samples
        || half_bandwidth.is_nan()
        || half_bandwidth <= 0.0
        || half_bandwidth >= n as f64 / 2.0
    {
        return None;
    }
    let width = half_bandwidth / n as f64;
    let matrix = Tridiagonal {
        diagonal: (0..n)
            .map(|i| ((n as f64 - 1.0 - 2.0 * i as f64) / 2.0).powi(2) * (2.0 * PI * width).cos())
            .collect(),
        beside: (1..n).map(|i| i as f64 * (n - i) as f64 / 2.0).collect(),
    };
    let mut windows = Vec::with_capacity(count);
    let mut concentrations = Vec::with_capacity(count);
    for k in 0..count {
        let mut window = matrix.vector(matrix.value(k));
        let turned = if k % 2 == 0 {
            window.iter().sum::<f64>() < 0.0
        } else {
            let least = (1.0 / n as f64).max(1e-7);
            window
                .iter()
                .find(|v| *v * *v > least)
                .is_some_and(|v| *v < 0.0)
        };
        if turned {
            for value in &mut window {
                *value = -*value;
            }
        }
        concentrations.push(concentration(&window, width));
        window.pop();
        windows.push(window);
    }
    Some((windows, concentrations))
}

/// The share of the energy of a window of norm 1 within ±`width` of the rate.
fn concentration(window: &[f64], width: f64) -> f64 {
    let n = window.len();
    (0..n)
        .map(|lag| {
            let product: f64 = window.iter().zip(&window[lag..]).map(|(a, b)| a * b).sum();
            let weight = match lag {
                0 => 2.0 * width,
                lag => 2.0 * (2.0 * PI * width * lag as f64).sin() / (PI * lag as f64),
            };
            product * weight
        })
        .sum()
}

/// A symmetric tridiagonal matrix.
struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// How many eigenvalues are above `value`: the positive terms of the Sturm sequence.
    fn above(&self, value: f64) -> usize {
        let mut pivot = 1.0f64;
        let mut count = 0;
        for (i, diagonal) in self.diagonal.iter().enumerate() {
            let beside = i.checked_sub(1).map_or(0.0, |i| self.beside[i]);
            pivot = diagonal - value - beside * beside / pivot;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE.sqrt();
            }
            count += usize::from(pivot > 0.0);
        }
        count
    }

    /// The eigenvalue number `k` from the largest, by bisection.
    fn value(&self, k: usize) -> f64 {
        let n = self.diagonal.len();
        let reach = |i: usize| {
            let left = i.checked_sub(1).map_or(0.0, |i| self.beside[i]);
            left + self.beside.get(i).copied().unwrap_or(0.0)
        };
        let ends = (0..n).map(|i| (self.diagonal[i] - reach(i), self.diagonal[i] + reach(i)));
        let (mut low, mut high) = ends
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| {
                (l.min(a), h.max(b))
            });
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.above(middle) > k {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The eigenvector of an eigenvalue, of norm 1, by inverse iteration.
    fn vector(&self, value: f64) -> Vec<f64> {
        let n = self.diagonal.len();
        // A start that no eigenvector is orthogonal to.
        let mut vector: Vec<f64> = (0..n)
            .map(|i| 1.0 + 0.3 * (0.7 * i as f64 + 0.1).sin() + i as f64 / n as f64)
            .collect();
        for _ in 0..4 {
            self.solve(value, &mut vector);
            let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
            for v in &mut vector {
                *v /= norm;
            }
        }
        vector
    }

    /// Solves (matrix − value)·x = `x` in place, with partial pivoting.
    fn solve(&self, value: f64, x: &mut [f64]) {
        let n = self.diagonal.len();
        let least = f64::EPSILON
            * self
                .diagonal
                .iter()
                .fold(1.0f64, |most, d| most.max(d.abs()));
        let mut main: Vec<f64> = self.diagonal.iter().map(|d| d - value).collect();
        let mut over = self.beside.clone();
        over.push(0.0);
        let mut second = vec![0.0; n];
        for i in 0..n - 1 {
            let below = self.beside[i];
            if below.abs() > main[i].abs() {
                // Rows i and i + 1 are exchanged.
                let factor = main[i] / below;
                let (next_main, next_over) = (main[i + 1], over[i + 1]);
                main[i + 1] = over[i] - factor * next_main;
                over[i + 1] = -factor * next_over;
                main[i] = below;
                over[i] = next_main;
                second[i] = next_over;
                x.swap(i, i + 1);
                x[i + 1] -= factor * x[i];
            } else {
                let pivot = if main[i].abs() < least {
                    least
                } else {
                    main[i]
                };
                let factor = below / pivot;
                main[i] = pivot;
                main[i + 1] -= factor * over[i];
                x[i + 1] -= factor * x[i];
            }
        }
        for i in (0..n).rev() {
            let pivot = if main[i].abs() < least {
                least
            } else {
                main[i]
            };
            let mut sum = x[i];
            if i + 1 < n {
                sum -= over[i] * x[i + 1];
            }
            if i + 2 < n {
                sum -= second[i] * x[i + 2];
            }
            x[i] = sum / pivot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tapers_are_orthogonal_and_concentrated() {
        let (windows, shares) = tapers(200, 2.0, 3).unwrap();
        for (i, a) in windows.iter().enumerate() {
            assert_eq!(a.len(), 200);
            for b in &windows[..i] {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                // The last sample of each is left out.
                assert!(product.abs() < 1e-2, "{product}");
            }
        }
        // Slepian (1978): 0.99994, 0.9976, 0.9594 for a product of 2.
        assert!(shares[0] > 0.9999 && shares[1] > 0.997 && shares[2] > 0.95);
        assert!(shares.windows(2).all(|pair| pair[0] > pair[1]));
        assert!(tapers(3, 2.0, 3).is_none() && tapers(1, 0.1, 1).is_none());
        assert!(tapers(100, f64::NAN, 1).is_none());
    }

    /// SciPy's by MNE-Python (`golden/eeg.py`). Both solve the same tridiagonal matrix, whose eigenvectors are well apart; the concentrations are
    /// sums of as many products as there are samples.
    #[test]
    fn tapers_are_those_of_scipy() {
        let golden: serde_json::Value =
            serde_json::from_str(include_str!("../../../tests/golden/eeg.json")).unwrap();
        let list = |value: &serde_json::Value| -> Vec<f64> {
            let values = value.as_array().unwrap().iter();
            values.map(|v| v.as_f64().unwrap()).collect()
        };
        for row in golden["dpss"].as_array().unwrap() {
            let samples = row["n"].as_u64().unwrap() as usize;
            let expected = row["windows"].as_array().unwrap();
            let (windows, shares) =
                tapers(samples, row["half"].as_f64().unwrap(), expected.len()).unwrap();
            for (a, b) in shares.iter().zip(list(&row["shares"])) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
            for (window, expected) in windows.iter().zip(expected) {
                let found = window.iter().step_by(23);
                for (a, b) in found.zip(list(expected)) {
                    assert!((a - b).abs() < 1e-11, "{samples}: {a} {b}");
                }
            }
        }
    }
}
