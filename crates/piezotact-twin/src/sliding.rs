//! A finger that slides over a sample, computed sample by sample: friction, vibration, and the resulting nail acceleration.

use std::sync::Arc;

use num_complex::Complex;
use piezotact_fourier::{ComplexToReal, RealPlanner, RealToComplex};

use super::RATE_HZ;
use super::drag::{FingertipFriction, MovingSide};
use super::finger::{Finger, Placement};
use super::parameters::{Sample, TwinParameters};
use super::participant::Participant;
use super::protocol::SlidingDirection;
use super::texture::Texture;
use piezotact_bench::random::Random;

/// The simulation of one finger on one sample.
pub(crate) struct Sliding {
    texture: Texture,
    dragged: FingertipFriction,
    tangential_to_nail: f64,
    own_answer: RelativeResponse,
}

/// One stretch of contact: its nail and its friction.
pub(crate) struct SlideResult {
    /// The acceleration of the nail, m/s².
    pub(crate) acceleration_m_s2: Vec<f64>,
    /// The friction force along the way, N.
    pub(crate) friction_n: Vec<f64>,
}

/// The setting of a slide: participant, sample, movement, load and angle.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    /// The name of the run, from which the placement of the finger is drawn.
    pub(crate) name: &'a str,
    pub(crate) parameters: &'a TwinParameters,
    pub(crate) participant: &'a Participant,
    pub(crate) sample: &'a Sample,
    pub(crate) movement: SlidingDirection,
    pub(crate) dragging: MovingSide,
    /// The load and the angle of the run.
    pub(crate) load_n: f64,
    pub(crate) angle_deg: f64,
}

impl Sliding {
    pub(crate) fn new(scene: Scene<'_>, random: Random) -> Self {
        let Scene {
            name,
            parameters,
            participant,
            sample,
            movement,
            dragging,
            load_n,
            angle_deg,
        } = scene;
        let placement = Placement::of(parameters, participant.number, participant.seed, name);
        Self {
            texture: Texture::of(parameters, participant, sample, movement, RATE_HZ),
            dragged: FingertipFriction::of(
                parameters,
                participant,
                sample,
                movement,
                dragging,
                RATE_HZ,
                random,
            ),
            tangential_to_nail: parameters.texture.tangential_to_nail,
            own_answer: RelativeResponse::new(
                parameters,
                &participant.finger,
                &placement,
                load_n,
                angle_deg,
            ),
        }
    }

    /// Nail acceleration and friction of a finger dragged at `speed_m_s` (0 and more) under `force_n`, both given for each
    /// sample; at a force of 0 the finger is in the air.
    pub(crate) fn slide(
        &mut self,
        speed_m_s: &[f64],
        force_n: &[f64],
        random: Random,
    ) -> SlideResult {
        let moved = |v: &[f64]| v.iter().sum::<f64>() / RATE_HZ;
        // The mean speed along the way: what rests does not count.
        let (sum, square) = speed_m_s
            .iter()
            .zip(force_n)
            .filter(|(_, n)| **n > 0.0)
            .fold((0.0, 0.0), |(sum, square), (v, _)| {
                (sum + v, square + v * v)
            });
        let usual = square / f64::max(sum, f64::MIN_POSITIVE);
        // Slips are faster than the hand, but cover no longer path.
        let mut passage =
            self.texture
                .passage(1.1 * moved(speed_m_s) + 1e-3, usual.max(1e-4), random);
        let mut way_m = 0.0;
        let mut vibration = Vec::with_capacity(force_n.len());
        let mut pulled = Vec::with_capacity(force_n.len());
        let mut friction_n = Vec::with_capacity(force_n.len());
        let mut touching = false;
        for (v, n) in speed_m_s.iter().zip(force_n) {
            if *n > 0.0 && !touching {
                self.dragged.land(*v);
            }
            touching = *n > 0.0;
            let moment = self.dragged.next(*v, *n);
            way_m += moment.slip_m_s / RATE_HZ;
            let felt = if touching {
                passage.next(moment.slip_m_s, *n, way_m)
            } else {
                0.0
            };
            vibration.push(felt);
            pulled.push(self.tangential_to_nail * moment.acceleration_m_s2);
            friction_n.push(moment.friction_n);
        }
        let mut acceleration_m_s2 = self.own_answer.apply(&vibration);
        for (a, pull) in acceleration_m_s2.iter_mut().zip(pulled) {
            *a += pull;
        }
        SlideResult {
            acceleration_m_s2,
            friction_n,
        }
    }
}

/// Transforms of one length, forwards and backwards.
type Plans = (
    usize,
    Arc<dyn RealToComplex<f64>>,
    Arc<dyn ComplexToReal<f64>>,
);

/// The response of this finger re the reference finger: |H/Href|, without delay.
struct RelativeResponse {
    /// At steps of half the rate over [`Self::STEPS`].
    ratio: Vec<f64>,
    planner: RealPlanner,
    plans: Option<Plans>,
}

impl RelativeResponse {
    const STEPS: usize = 256;

    fn new(
        parameters: &TwinParameters,
        finger: &Finger,
        placement: &Placement,
        load_n: f64,
        angle_deg: f64,
    ) -> Self {
        let reference = Finger::nominal(parameters);
        let ratio = (0..=Self::STEPS)
            .map(|i| {
                let hz = (i as f64).max(0.5) * 0.5 * RATE_HZ / Self::STEPS as f64;
                let own = finger.response(hz, load_n, angle_deg, placement);
                let usual = reference.response(hz, load_n, angle_deg, &Placement::exact());
                own.norm() / usual.norm()
            })
            .collect();
        Self {
            ratio,
            planner: RealPlanner::new(),
            plans: None,
        }
    }

    fn apply(&mut self, x: &[f64]) -> Vec<f64> {
        let n = x.len().next_power_of_two().max(1_024);
        let (forward, inverse) = match &self.plans {
            Some((size, forward, inverse)) if *size == n => {
                (Arc::clone(forward), Arc::clone(inverse))
            }
            _ => {
                let forward = self.planner.plan_fft_forward(n);
                let inverse = self.planner.plan_fft_inverse(n);
                self.plans = Some((n, Arc::clone(&forward), Arc::clone(&inverse)));
                (forward, inverse)
            }
        };
        let mut samples = forward.make_input_vec();
        samples[..x.len()].copy_from_slice(x);
        let mut bins: Vec<Complex<f64>> = forward.make_output_vec();
        let done = forward.process(&mut samples, &mut bins);
        debug_assert!(done.is_ok());
        let per_bin = 2.0 * Self::STEPS as f64 / n as f64;
        for (k, bin) in bins.iter_mut().enumerate() {
            let place = k as f64 * per_bin;
            let i = (place as usize).min(Self::STEPS - 1);
            let share = place - i as f64;
            let ratio = self.ratio[i] * (1.0 - share) + self.ratio[i + 1] * share;
            *bin *= ratio / n as f64;
        }
        let done = inverse.process(&mut bins, &mut samples);
        debug_assert!(done.is_ok());
        samples.truncate(x.len());
        samples
    }
}
