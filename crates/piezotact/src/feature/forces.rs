//! The forces of one stroke.

use crate::stroke::{Interval, Segmentation, Signals};

/// A stroke with less normal force than this has no friction coefficient, N.
const LEAST_NORMAL_N: f64 = 0.01;
/// The friction coefficient is the tangential force over the normal one, but at least this, N.
const LEAST_DIVISOR_N: f64 = 1e-6;

/// The forces of one stroke by sample, re their zeros while the finger is lifted.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeForces {
    pub normal_n: Vec<f64>,
    /// The magnitude of the tangential force; empty where none was measured.
    pub tangential_n: Vec<f64>,
    /// Empty where no tangential force was measured, and where the finger hardly touches.
    pub friction_coefficient: Vec<f64>,
}

/// The forces of the part `steady` of a recording; `None` without a normal force.
///
/// Formula: √(Fx² + Fy²) and √(Fx² + Fy²)/Fz, each force re its zero.
///
/// Source: L. Felicetti's thesis (2024), figure 28.
#[must_use]
pub fn stroke_forces(
    signals: &Signals<'_>,
    segmentation: &Segmentation,
    steady: Interval,
) -> Option<StrokeForces> {
    let (mut normal_n, mut ratio) = (Vec::new(), Vec::new());
    let touch = fill((signals, segmentation), steady, (&mut normal_n, &mut ratio))?;
    let both = ratio.iter().zip(&normal_n);
    Some(StrokeForces {
        tangential_n: both
            .map(|(ratio, normal)| ratio * normal.max(LEAST_DIVISOR_N))
            .collect(),
        friction_coefficient: match touch {
            Touch::Lasting => ratio,
            Touch::Broken => Vec::new(),
        },
        normal_n,
    })
}

/// Whether a finger touches during a whole stroke.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Touch {
    /// It does.
    Lasting,
    /// It hardly touches, or is off the surface now and then: there is no friction coefficient.
    Broken,
}

/// Writes the normal force and the ratio of the tangential to it by sample; the ratio is empty without a tangential force.
pub(super) fn fill(
    (signals, segmentation): (&Signals<'_>, &Segmentation),
    steady: Interval,
    (force, ratio): (&mut Vec<f64>, &mut Vec<f64>),
) -> Option<Touch> {
    let normal_n = signals.normal_force_n?;
    let zero = |axis: usize| {
        segmentation
            .force_zeros
            .as_ref()
            .map_or(0.0, |zeros| zeros.at(axis, (steady.start + steady.end) / 2))
    };
    let sign = segmentation.force_zeros.as_ref().map_or(1.0, |z| z.sign);
    let normal_zero = zero(0);
    force.clear();
    force.extend(steady.of(normal_n).iter().map(|v| v * sign - normal_zero));
    ratio.clear();
    let axes: Vec<(&[f64], f64)> = signals
        .tangential_force_n
        .iter()
        .enumerate()
        .map(|(i, axis)| (steady.of(axis), zero(i + 1)))
        .collect();
    ratio.resize(if axes.is_empty() { 0 } else { force.len() }, 0.0);
    let (squares, normals) = (&mut *ratio, &*force);
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for (axis, zero) in &axes {
                for (square, value) in squares.iter_mut().zip(*axis) {
                    *square += (value - zero) * (value - zero);
                }
            }
            for (square, normal) in squares.iter_mut().zip(normals) {
                *square = square.sqrt() / normal.max(LEAST_DIVISOR_N);
            }
        },
    );
    let off = force.iter().filter(|n| **n < LEAST_NORMAL_N).count();
    Some(match 50 * off <= force.len() {
        true => Touch::Lasting,
        false => Touch::Broken,
    })
}
