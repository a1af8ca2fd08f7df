//! The inner loops of a spectral estimate for segments of any length, on any machine: cut, detrend, window,
//! transform, and sum. Where [`lanes`](super::lanes) can do it, they are faster.
//!
//! Two real segments are transformed as the real and imaginary part of one complex segment, Z = A + iB.
//! Summed over segments nothing has to be taken apart again: |Z(k)|² + |Z(−k)|² = 2(|A|² + |B|²), and for
//! two signals conj(Zx(k))·Zy(k) + conj of the same at −k = 2(conj(Ax)·Ay + conj(Bx)·By). So the loop over
//! segments only multiplies and adds, and folding positive onto negative frequencies is done once at the end.

use std::sync::Arc;

use num_complex::Complex;
use rustfft::Fft;

use super::{Detrend, segments_in, sum};

/// A planned transform of windowed segments, with its scratch memory.
#[derive(Clone)]
pub struct SegmentTransform {
    window: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex<f64>>,
    detrend: Detrend,
    simd: pulp::Arch,
}

impl std::fmt::Debug for SegmentTransform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SegmentTransform")
            .field("segment", &self.window.len())
            .field("detrend", &self.detrend)
            .finish_non_exhaustive()
    }
}

impl SegmentTransform {
    /// Transforms segments of the length of `window`, each without its `detrend` and times the window.
    pub fn new(window: Vec<f64>, detrend: Detrend) -> Self {
        let fft = crate::complex_forward(window.len());
        let scratch = vec![Complex::default(); fft.get_inplace_scratch_len()];
        Self {
            window,
            fft,
            scratch,
            detrend,
            simd: pulp::Arch::new(),
        }
    }

    /// Detrends and windows segment `a` into the real and `b` into the imaginary parts of `z`, and
    /// transforms it. Both have the window's length.
    pub fn transform_pair(&mut self, a: &[f64], b: &[f64], z: &mut [Complex<f64>]) {
        self.simd.dispatch(FillPair {
            a,
            b,
            window: &self.window,
            detrend: self.detrend,
            z: &mut *z,
        });
        self.fft.process_with_scratch(z, &mut self.scratch);
    }

    /// As [`Self::transform_pair`] with nothing in the imaginary part.
    pub fn transform_single(&mut self, a: &[f64], z: &mut [Complex<f64>]) {
        let trend = Trend::of(a, self.detrend);
        for (i, ((z, a), w)) in z.iter_mut().zip(a).zip(&self.window).enumerate() {
            *z = Complex::new((a - trend.at(i)) * w, 0.0);
        }
        self.fft.process_with_scratch(z, &mut self.scratch);
    }

    /// Hands the transform of every two segments of `record`, `hop` samples apart, to `take`, with whether it
    /// holds two or one; `z` is the memory for it.
    pub fn each_pair(
        &mut self,
        record: &[f64],
        hop: usize,
        z: &mut [Complex<f64>],
        mut take: impl FnMut(&[Complex<f64>], bool),
    ) {
        let segment = self.window.len();
        let count = segments_in(record.len(), segment, hop);
        let cut = |i: usize| &record[i * hop..i * hop + segment];
        for i in (1..count).step_by(2) {
            self.transform_pair(cut(i - 1), cut(i), z);
            take(z, true);
        }
        if count % 2 == 1 {
            self.transform_single(cut(count - 1), z);
            take(z, false);
        }
    }

    /// Adds the squares of the real and imaginary parts of `z` to `power`, two numbers a bin.
    pub fn add_power(&self, z: &[Complex<f64>], power: &mut [f64]) {
        self.simd.dispatch(
            #[inline(always)]
            || {
                for (sum, part) in power.iter_mut().zip(bytemuck::cast_slice::<_, f64>(z)) {
                    *sum += part * part;
                }
            },
        );
    }

    /// Adds conj(zx)·zy to `cross`.
    pub fn add_cross(&self, zx: &[Complex<f64>], zy: &[Complex<f64>], cross: &mut [Complex<f64>]) {
        self.simd.dispatch(
            #[inline(always)]
            || {
                for ((sum, x), y) in cross.iter_mut().zip(zx).zip(zy) {
                    sum.re += x.re * y.re + x.im * y.im;
                    sum.im += x.re * y.im - x.im * y.re;
                }
            },
        );
    }
}

/// Detrends and windows `a` into the real and `b` into the imaginary parts of `z`, with the widest
/// instructions that the machine has.
struct FillPair<'a> {
    a: &'a [f64],
    b: &'a [f64],
    window: &'a [f64],
    detrend: Detrend,
    z: &'a mut [Complex<f64>],
}

impl pulp::WithSimd for FillPair<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self {
            a,
            b,
            window,
            detrend,
            z,
        } = self;
        let (ta, tb) = (Trend::of(a, detrend), Trend::of(b, detrend));
        if matches!(detrend, Detrend::Linear) {
            for (i, (((z, a), b), w)) in z.iter_mut().zip(a).zip(b).zip(window).enumerate() {
                *z = Complex::new((a - ta.at(i)) * w, (b - tb.at(i)) * w);
            }
        } else {
            for (((z, a), b), w) in z.iter_mut().zip(a).zip(b).zip(window) {
                *z = Complex::new((a - ta.offset) * w, (b - tb.offset) * w);
            }
        }
    }
}

/// What detrending takes away from a segment: `offset + slope · (i − middle)`.
struct Trend {
    offset: f64,
    slope: f64,
    middle: f64,
}

impl Trend {
    #[inline(always)]
    fn of(segment: &[f64], detrend: Detrend) -> Self {
        let n = segment.len() as f64;
        let middle = (n - 1.0) / 2.0;
        match detrend {
            Detrend::None => Self {
                offset: 0.0,
                slope: 0.0,
                middle,
            },
            Detrend::Constant => Self {
                offset: sum(segment) / n,
                slope: 0.0,
                middle,
            },
            Detrend::Linear => {
                let offset = sum(segment) / n;
                // Σ(i − middle)² = n(n² − 1)/12
                let spread = n * (n * n - 1.0) / 12.0;
                let tilt: f64 = segment
                    .iter()
                    .enumerate()
                    .map(|(i, v)| (i as f64 - middle) * (v - offset))
                    .sum();
                Self {
                    offset,
                    slope: if spread > 0.0 { tilt / spread } else { 0.0 },
                    middle,
                }
            }
        }
    }

    #[inline(always)]
    fn at(&self, i: usize) -> f64 {
        self.offset + self.slope * (i as f64 - self.middle)
    }
}

/// |A(k)|² and |B(k)|² of the two real segments in `z`, handed bin by bin to `take`.
pub fn split_power(z: &[Complex<f64>], mut take: impl FnMut(usize, f64, f64)) {
    let n = z.len();
    for k in 0..=n / 2 {
        let mirror = z[(n - k) % n].conj();
        take(
            k,
            ((z[k] + mirror) * 0.5).norm_sqr(),
            ((z[k] - mirror) * 0.5).norm_sqr(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::hann;
    use super::*;

    /// The squares of two packed segments, taken apart, add to those of their packed transform, and each is that
    /// of its segment transformed alone.
    #[test]
    fn packed_segments_come_apart() {
        for n in [2, 3, 8, 9, 30, 31] {
            let signal = |seed: usize| -> Vec<f64> {
                (0..n)
                    .map(|i| ((i * i * seed + 3 * i) as f64 * 0.7).sin() + 0.3)
                    .collect()
            };
            let (a, b) = (signal(1), signal(2));
            let window = hann(n);
            let mut transform = SegmentTransform::new(window, Detrend::Constant);
            let mut both = vec![Complex::default(); n];
            let (mut alone_a, mut alone_b) = (both.clone(), both.clone());
            transform.transform_pair(&a, &b, &mut both);
            transform.transform_single(&a, &mut alone_a);
            transform.transform_single(&b, &mut alone_b);
            split_power(&both, |k, a, b| {
                assert!((a - alone_a[k].norm_sqr()).abs() < 1e-12, "{n}, {k}");
                assert!((b - alone_b[k].norm_sqr()).abs() < 1e-12, "{n}, {k}");
            });
        }
    }
}
