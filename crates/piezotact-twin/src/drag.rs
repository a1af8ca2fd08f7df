//! A fingertip dragged over a surface: steady sliding or stick-slip, depending on friction and damping.
//!
//! m·ẇ = k·u + c·(V − w) − F(w), u̇ = V − w, with the speed V of what drags (a hand, or the platform under a held
//! finger), the slip speed w, the lag u, and F = N·μ(w), μ(w) = μ + (μs − μ)·e^(−w/v0). It sticks (w = 0) while the
//! pull is below N·μs. Sliding is stable while c exceeds −N·dμ/dw (J. H. Dieterich, A. Ruina and others; for
//! fingers M. J. Adams et al. 2013).

use super::parameters::{Drag, Sample, TwinParameters};
use super::participant::Participant;
use super::protocol::SlidingDirection;
use super::wander::SmoothWander;
use piezotact_bench::random::Random;

/// The friction of one finger on one sample, and the stiffness and damping that hold the fingertip.
#[derive(Clone, Debug)]
pub(crate) struct FingertipFriction {
    stiffness_n_m: f64,
    damping_n_s_m: f64,
    mass_kg: f64,
    friction: f64,
    static_ratio: f64,
    load_exponent: f64,
    per_reference_load: f64,
    per_falls_over: f64,
    step_s: f64,
    fluctuation: SmoothWander,
    lag_m: f64,
    slip_m_s: f64,
}

/// The state of the fingertip at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// The speed of the skin over the surface, m/s.
    pub(crate) slip_m_s: f64,
    /// The friction force, N.
    pub(crate) friction_n: f64,
    /// The tangential acceleration of the fingertip, m/s².
    pub(crate) acceleration_m_s2: f64,
}

/// Which side moves: the hand or the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MovingSide {
    /// A free hand draws the finger.
    Hand,
    /// The surface moves under a finger that is held.
    Surface,
}

impl FingertipFriction {
    pub(crate) fn of(
        parameters: &TwinParameters,
        participant: &Participant,
        sample: &Sample,
        movement: SlidingDirection,
        dragging: MovingSide,
        rate_hz: f64,
        random: Random,
    ) -> Self {
        let drag: &Drag = match (dragging, movement) {
            (MovingSide::Surface, _) => &parameters.drag.held,
            (MovingSide::Hand, SlidingDirection::Proximal) => &parameters.drag.active,
            (MovingSide::Hand, SlidingDirection::Distal) => &parameters.drag.distal,
            (MovingSide::Hand, SlidingDirection::Transversal | SlidingDirection::Circular) => {
                &parameters.drag.across
            }
        };
        let model = &parameters.friction;
        // A length of the path, converted to time at the reference speed, as the control points of a hand are in seconds.
        let memory_s = model.fluctuation_m / parameters.texture.reference_speed_m_s;
        // What a sample states holds at the reference speed.
        let at_reference = (-parameters.texture.reference_speed_m_s / model.falls_over_m_s).exp();
        let surplus = 1.0 + (sample.static_ratio - 1.0) * at_reference;
        Self {
            stiffness_n_m: drag.stiffness_n_m,
            damping_n_s_m: drag.damping_n_s_m,
            mass_kg: model.mass_kg,
            friction: sample.friction * participant.skin.friction / surplus,
            static_ratio: sample.static_ratio,
            load_exponent: model.load_exponent,
            per_reference_load: 1.0 / parameters.texture.reference_load_n,
            per_falls_over: 1.0 / model.falls_over_m_s,
            step_s: 1.0 / rate_hz,
            fluctuation: SmoothWander::new(model.fluctuation, memory_s, rate_hz, random),
            lag_m: 0.0,
            slip_m_s: 0.0,
        }
    }

    /// The finger lands while it moves at `speed_m_s`.
    pub(crate) fn land(&mut self, speed_m_s: f64) {
        self.lag_m = 0.0;
        self.slip_m_s = speed_m_s;
    }

    /// The next moment, while the finger is dragged at `speed_m_s` under `force_n`.
    pub(crate) fn next(&mut self, speed_m_s: f64, force_n: f64) -> Moment {
        let here = (1.0 + self.fluctuation.next()).max(0.0);
        if force_n <= 0.0 {
            self.land(speed_m_s);
            return Moment {
                slip_m_s: 0.0,
                friction_n: 0.0,
                acceleration_m_s2: 0.0,
            };
        }
        let kinetic = self.friction
            * here
            * (force_n * self.per_reference_load).powf(self.load_exponent)
            * force_n;
        let (k, c, m, h) = (
            self.stiffness_n_m,
            self.damping_n_s_m,
            self.mass_kg,
            self.step_s,
        );
        let before = self.slip_m_s;
        let pull = k * self.lag_m + c * speed_m_s;
        let friction_n;
        if before <= 0.0 && pull <= self.static_ratio * kinetic {
            // It sticks: the friction equals the pull.
            friction_n = pull.max(0.0);
            self.slip_m_s = 0.0;
        } else {
            let weakening =
                (self.static_ratio - 1.0) * (-before.max(0.0) * self.per_falls_over).exp();
            let resisting = kinetic * (1.0 + weakening);
            let slip = (before + h / m * (pull - resisting)) / (1.0 + h * c / m);
            self.slip_m_s = slip.max(0.0);
            friction_n = if slip > 0.0 {
                resisting
            } else {
                pull.clamp(0.0, resisting)
            };
        }
        self.lag_m += h * (speed_m_s - self.slip_m_s);
        Moment {
            slip_m_s: self.slip_m_s,
            friction_n,
            acceleration_m_s2: (self.slip_m_s - before) / h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dragged(
        sample: &str,
        movement: SlidingDirection,
        dragging: MovingSide,
    ) -> FingertipFriction {
        let parameters = TwinParameters::built_in();
        let participant = Participant::of(0, 1, &parameters);
        let mut dragged = FingertipFriction::of(
            &parameters,
            &participant,
            parameters.sample(sample).unwrap(),
            movement,
            dragging,
            5_000.0,
            Random::stream(1, 1, "drag"),
        );
        dragged.land(0.03);
        dragged
    }

    /// The share of time that the finger sticks, and how often it starts again, a second.
    fn sticking(dragged: &mut FingertipFriction, speed_m_s: f64) -> (f64, f64) {
        let force_n = 0.2;
        let mut stuck = 0;
        let mut starts = 0;
        let mut before = 1.0;
        // It takes up the friction first.
        for _ in 0..1_000 {
            dragged.next(speed_m_s, force_n);
        }
        for _ in 0..20_000 {
            let Moment { slip_m_s, .. } = dragged.next(speed_m_s, force_n);
            stuck += usize::from(slip_m_s <= 0.0);
            starts += usize::from(before <= 0.0 && slip_m_s > 0.0);
            before = slip_m_s;
        }
        (stuck as f64 / 20_000.0, starts as f64 / 4.0)
    }

    #[test]
    fn rough_samples_slide_and_the_plate_without_texture_sticks_and_slips_in_a_free_hand() {
        for sample in ["S1", "S8", "S13", "M8"] {
            let mut dragged = dragged(sample, SlidingDirection::Proximal, MovingSide::Hand);
            assert_eq!(sticking(&mut dragged, 0.03), (0.0, 0.0), "{sample}");
        }
        // When the hand slows down.
        let (stuck, bursts_hz) = sticking(
            &mut dragged("NO", SlidingDirection::Proximal, MovingSide::Hand),
            0.015,
        );
        // Bursts at 2–15 Hz.
        assert!(
            stuck > 0.3 && (2.0..=15.0).contains(&bursts_hz),
            "{stuck} {bursts_hz}"
        );
        let held = sticking(
            &mut dragged("NO", SlidingDirection::Proximal, MovingSide::Surface),
            0.01,
        );
        assert_eq!(held, (0.0, 0.0));
        let (stuck, bursts_hz) = sticking(
            &mut dragged("S1", SlidingDirection::Transversal, MovingSide::Hand),
            0.03,
        );
        assert!(stuck > 0.1 && bursts_hz > 2.0, "{stuck} {bursts_hz}");
    }

    /// While it slides steadily the friction is the sample's own, with the load law.
    #[test]
    fn steady_sliding_has_the_sample_s_friction() {
        for (force_n, expected) in [(0.2, 0.85), (0.4, 0.85 * 2f64.powf(-0.1))] {
            let mut dragged = dragged("S1", SlidingDirection::Proximal, MovingSide::Surface);
            let ratios: Vec<f64> = (0..50_000)
                .map(|_| dragged.next(0.03, force_n).friction_n / force_n)
                .collect();
            let mean = piezotact::statistics::mean(&ratios);
            // 4 % of fluctuation over 75 independent lengths.
            assert!((mean / expected - 1.0).abs() < 0.02, "{mean}");
        }
    }

    #[test]
    fn a_finger_in_the_air_feels_nothing() {
        let mut dragged = dragged("S1", SlidingDirection::Proximal, MovingSide::Hand);
        let Moment {
            slip_m_s,
            friction_n,
            ..
        } = dragged.next(0.03, 0.0);
        assert_eq!((slip_m_s, friction_n), (0.0, 0.0));
    }
}
