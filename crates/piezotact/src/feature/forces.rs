//! The forces of one stroke.

use std::borrow::Cow;

use crate::quantity::Seconds;
use crate::statistics::mean;
use crate::stroke::frames::smoothed;
use crate::stroke::{Interval, Segmentation, Signals};

/// A stroke with less normal force than this has no friction coefficient, N.
const LEAST_NORMAL_N: f64 = 0.01;
/// The friction coefficient is the tangential force over the normal one, but at least this, N.
const LEAST_DIVISOR_N: f64 = 1e-6;
/// A normal force that fluctuates by this share of its mean within this time is noisy.
const NOISY: f64 = 0.1;
const HUM_SMOOTHING: Seconds = Seconds(0.04);

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

/// Writes the normal force and the ratio of the tangential to it by sample; the ratio is empty without a tangential force. Where the normal force
/// fluctuates within 40 ms, two periods of the mains, by more than a tenth of its mean, as noise or hum of its cell does, all forces are
/// smoothed over that time: the mean of a ratio to noise is too high without limit.
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
    let width = signals.rate.samples_in(HUM_SMOOTHING);
    let smooth_n = smoothed(force, width);
    let fast = force.iter().zip(&smooth_n).map(|(n, mean)| n - mean);
    let noise_n = (fast.map(|n| n * n).sum::<f64>() / force.len().max(1) as f64).sqrt();
    let is_noisy = noise_n > NOISY * mean(&smooth_n).abs();
    if is_noisy {
        force.copy_from_slice(&smooth_n);
    }
    let axes: Vec<(Cow<'_, [f64]>, f64)> = signals
        .tangential_force_n
        .iter()
        .enumerate()
        .map(|(i, axis)| {
            let axis = steady.of(axis);
            let axis = match is_noisy {
                true => Cow::Owned(smoothed(axis, width)),
                false => Cow::Borrowed(axis),
            };
            (axis, zero(i + 1))
        })
        .collect();
    ratio.resize(if axes.is_empty() { 0 } else { force.len() }, 0.0);
    let (squares, normals) = (&mut *ratio, &*force);
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for (axis, zero) in &axes {
                for (square, value) in squares.iter_mut().zip(axis.iter()) {
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
