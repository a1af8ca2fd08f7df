//! Sums over segments of |X|², and of conj(X)·Y of two signals, by the fastest transform for their length and
//! the machine.

use num_complex::Complex;

use super::Detrend;
use super::eight::{Eight, eight};
use super::kernel::SegmentTransform;
use super::lanes::{LENGTHS, LaneCross, LanePower, LaneTransform, Offset};

/// The transform in lanes, where it is for segments like these and the machine has the instructions.
fn in_lanes(window: &[f64], detrend: Detrend) -> Option<(Eight, LaneTransform)> {
    let offset = match detrend {
        Detrend::None => Offset::None,
        Detrend::Constant => Offset::Mean,
        Detrend::Linear => return None,
    };
    if !window.len().is_power_of_two() || !LENGTHS.contains(&window.len()) {
        return None;
    }
    Some((eight()?, LaneTransform::new(window, offset)))
}

/// A sum of |X|² over segments.
#[derive(Clone, Debug)]
pub(super) enum PowerSum {
    /// In lanes of eight; with the silence that is paired with a single segment.
    Lanes(Eight, LanePower, Vec<f64>),
    /// By a transform for any length, kept as the squares of real and imaginary parts.
    Planned {
        transform: SegmentTransform,
        z: Vec<Complex<f64>>,
        parts: Vec<f64>,
    },
}

impl PowerSum {
    pub(crate) fn new(window: &[f64], detrend: Detrend) -> Self {
        let n = window.len();
        match in_lanes(window, detrend) {
            Some((simd, transform)) => Self::Lanes(simd, LanePower::new(transform), vec![0.0; n]),
            None => Self::Planned {
                transform: SegmentTransform::new(window.to_vec(), detrend),
                z: vec![Complex::default(); n],
                parts: vec![0.0; 2 * n],
            },
        }
    }

    pub(crate) fn clear(&mut self) {
        match self {
            Self::Lanes(_, sum, _) => sum.clear(),
            Self::Planned { parts, .. } => parts.fill(0.0),
        }
    }

    pub(crate) fn add_pair(&mut self, a: &[f64], b: &[f64]) {
        match self {
            Self::Lanes(simd, sum, _) => sum.add(*simd, a, b),
            Self::Planned {
                transform,
                z,
                parts,
            } => {
                transform.transform_pair(a, b, z);
                transform.add_power(z, parts);
            }
        }
    }

    pub(crate) fn add_single(&mut self, a: &[f64]) {
        match self {
            Self::Lanes(simd, sum, silence) => sum.add(*simd, a, silence),
            Self::Planned {
                transform,
                z,
                parts,
            } => {
                transform.transform_single(a, z);
                transform.add_power(z, parts);
            }
        }
    }

    /// The sum, n/2 + 1 bins.
    pub(crate) fn folded(&self) -> Vec<f64> {
        match self {
            Self::Lanes(_, sum, _) => fold_power(&sum.in_order()),
            Self::Planned { parts, .. } => fold_power(&both_parts(parts)),
        }
    }
}

/// The sums of |X|², |Y|² and conj(X)·Y over segments of two signals x and y, n/2 + 1 bins each.
#[derive(Clone, Debug)]
pub(crate) struct Folded {
    pub(crate) xx: Vec<f64>,
    pub(crate) yy: Vec<f64>,
    pub(crate) xy: Vec<Complex<f64>>,
}

/// Sums of |X|², |Y|² and conj(X)·Y over segments of two signals x and y.
#[derive(Clone, Debug)]
pub(crate) enum CrossSum {
    /// In lanes of eight; with the silence that is paired with a single segment.
    Lanes(Eight, LaneCross, Vec<f64>),
    /// By a transform for any length.
    Planned {
        transform: SegmentTransform,
        zx: Vec<Complex<f64>>,
        zy: Vec<Complex<f64>>,
        xx: Vec<f64>,
        yy: Vec<f64>,
        xy: Vec<Complex<f64>>,
    },
}

impl CrossSum {
    pub(crate) fn new(window: &[f64], detrend: Detrend) -> Self {
        let n = window.len();
        match in_lanes(window, detrend) {
            Some((simd, transform)) => Self::Lanes(simd, LaneCross::new(transform), vec![0.0; n]),
            None => Self::Planned {
                transform: SegmentTransform::new(window.to_vec(), detrend),
                zx: vec![Complex::default(); n],
                zy: vec![Complex::default(); n],
                xx: vec![0.0; 2 * n],
                yy: vec![0.0; 2 * n],
                xy: vec![Complex::default(); n],
            },
        }
    }

    pub(crate) fn clear(&mut self) {
        match self {
            Self::Lanes(_, sums, _) => sums.clear(),
            Self::Planned { xx, yy, xy, .. } => {
                xx.fill(0.0);
                yy.fill(0.0);
                xy.fill(Complex::default());
            }
        }
    }

    /// Adds two segments of x and the same two of y.
    pub(crate) fn add_pair(&mut self, x: [&[f64]; 2], y: [&[f64]; 2]) {
        match self {
            Self::Lanes(simd, sums, _) => sums.add(*simd, x, y),
            Self::Planned {
                transform, zx, zy, ..
            } => {
                transform.transform_pair(x[0], x[1], zx);
                transform.transform_pair(y[0], y[1], zy);
                self.add_planned();
            }
        }
    }

    /// Adds a segment of x and the same of y.
    pub(crate) fn add_single(&mut self, x: &[f64], y: &[f64]) {
        match self {
            Self::Lanes(simd, sums, silence) => {
                sums.add(*simd, [x, silence], [y, silence]);
            }
            Self::Planned {
                transform, zx, zy, ..
            } => {
                transform.transform_single(x, zx);
                transform.transform_single(y, zy);
                self.add_planned();
            }
        }
    }

    fn add_planned(&mut self) {
        if let Self::Planned {
            transform,
            zx,
            zy,
            xx,
            yy,
            xy,
        } = self
        {
            transform.add_power(zx, xx);
            transform.add_power(zy, yy);
            transform.add_cross(zx, zy, xy);
        }
    }

    pub(crate) fn folded(&self) -> Folded {
        match self {
            Self::Lanes(_, sums, _) => {
                let (xx, yy, xy) = sums.in_order();
                Folded {
                    xx: fold_power(&xx),
                    yy: fold_power(&yy),
                    xy: fold_cross(&xy),
                }
            }
            Self::Planned { xx, yy, xy, .. } => Folded {
                xx: fold_power(&both_parts(xx)),
                yy: fold_power(&both_parts(yy)),
                xy: fold_cross(xy),
            },
        }
    }
}

/// The squares of real and imaginary part of every bin, added.
fn both_parts(parts: &[f64]) -> Vec<f64> {
    parts
        .as_chunks::<2>()
        .0
        .iter()
        .map(|[re, im]| re + im)
        .collect()
}

/// Folds a sum of |Z|² over pairs of real segments into the n/2 + 1 bins of the real signals' |X|².
fn fold_power(power: &[f64]) -> Vec<f64> {
    let n = power.len();
    (0..=n / 2)
        .map(|k| 0.5 * (power[k] + power[(n - k) % n]))
        .collect()
}

/// Folds a sum of conj(Zx)·Zy over pairs of real segments into the n/2 + 1 bins of the real signals' conj(X)·Y.
fn fold_cross(cross: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = cross.len();
    (0..=n / 2)
        .map(|k| (cross[k] + cross[(n - k) % n].conj()) * 0.5)
        .collect()
}
