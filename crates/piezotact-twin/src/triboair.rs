//! `TriboAir`, the bench of passive touch (*thesis* 2.3.2): a platform on air bearings carries the sample with a
//! trapezoidal speed under a finger at rest; forces under the platform, its position, an accelerometer on the nail.

use std::f64::consts::TAU;

use piezotact::quantity::Unit;
use piezotact::recording::{Condition, Touch};

use super::RATE_HZ;
use super::acttouch::smooth;
use super::drag::MovingSide;
use super::parameters::{Sample, TriboAirParameters, TwinParameters};
use super::participant::Participant;
use super::protocol::{ANGLES_DEG, SlidingDirection, load_possible, strokes_possible, within};
use super::sensors::{Accelerometer, SlowHand, TriaxialCell};
use super::session::{
    CALIBRATION, Session, Stretches, Touched, Touching, empty, nail_and_forces, on_nail, quiet,
};
use super::sliding::{Scene, SlideResult, Sliding};
use super::wander::Wander;
use piezotact_bench::random::Random;
use piezotact_bench::{Acquire, DeviceError, RunPlan};

/// Slower than this the platform is not excited, m/s (*chosen*).
const SLOWEST_M_S: f64 = 0.001;
/// How fast the controller's ripple of speed changes, s (*chosen*).
const RIPPLE_MEMORY_S: f64 = 0.02;

/// The twin of `TriboAir`, with one person and one sample on it.
#[derive(Clone, Debug)]
pub struct TriboAir {
    parameters: TwinParameters,
    participant: Participant,
    sample: Sample,
    strokes: usize,
    speed_m_s: f64,
}

impl TriboAir {
    /// The bench with the finger of `participant` at rest, and `sample` under it, moved `strokes` times at
    /// `speed_m_s`.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] with what is possible, for a speed that leaves no plateau on the track.
    pub fn new(
        parameters: &TwinParameters,
        participant: Participant,
        sample: &Sample,
        strokes: usize,
        speed_m_s: f64,
    ) -> Result<Self, DeviceError> {
        strokes_possible(strokes)?;
        let fastest = fastest_m_s(&parameters.triboair);
        if !(SLOWEST_M_S..=fastest).contains(&speed_m_s) {
            let mm = |m: f64| (m * 1e4).floor() / 10.0;
            return Err(DeviceError::Impossible {
                expected: format!(
                    "a speed from {} to {} mm/s, so that {} s of plateau are left on the track of {} mm",
                    mm(SLOWEST_M_S),
                    mm(fastest),
                    parameters.triboair.shortest_plateau_s,
                    mm(parameters.triboair.track_m)
                ),
                found: format!("{} mm/s", speed_m_s * 1e3),
                todo: "10, 20 and 30 mm/s are usual".into(),
            });
        }
        Ok(Self {
            parameters: parameters.clone(),
            participant,
            sample: sample.clone(),
            strokes,
            speed_m_s,
        })
    }

    /// Its acquiring half; the bench moves the platform itself.
    #[must_use]
    pub fn into_acquirer(self) -> Box<dyn Acquire> {
        Session::boxed(self)
    }

    fn random(&self, run: &RunPlan, what: &str) -> Random {
        self.participant
            .random(&format!("{} {what}", self.scene_name(run)))
    }

    /// What tells a run from others: the sample, the speed, the load, and the label.
    fn scene_name(&self, run: &RunPlan) -> String {
        let load_mn = run.load.map_or(0.0, |load| load.0 * 1e3);
        let (sample, um_s) = (&self.sample.name, self.speed_m_s * 1e6);
        format!(
            "triboair {sample} {um_s:.0} um/s {load_mn:.0} mN {}",
            run.label
        )
    }

    /// What the force cell of the bench is, whoever touches.
    fn cell_body(&self) -> Random {
        Random::stream(self.participant.seed, 0, "force cell of triboair")
    }
}

/// The speed at which the shortest plateau is left: v·t + v²/a = track.
fn fastest_m_s(parameters: &TriboAirParameters) -> f64 {
    let (a, t) = (parameters.acceleration_m_s2, parameters.shortest_plateau_s);
    0.5 * a * ((t * t + 4.0 * parameters.track_m / a).sqrt() - t)
}

impl Touching for TriboAir {
    fn name(&self) -> String {
        format!(
            "digital twin of the TriboAir bench, participant {}",
            self.participant.pseudonym()
        )
    }

    fn channels(&self) -> Vec<(String, Unit)> {
        let mut channels = nail_and_forces();
        channels.push(("platform_position".into(), Unit::Metre));
        channels
    }

    fn condition(&self) -> Condition {
        Condition {
            sample: Some(self.sample.name.clone()),
            participant: Some(self.participant.pseudonym()),
            twin_seed: Some(self.participant.seed),
            speed_m_s: Some(self.speed_m_s),
            touch: Some(Touch::Passive),
            // The sample moves away from the body.
            direction: Some(SlidingDirection::Proximal),
            ..Condition::default()
        }
    }

    fn seed(&self) -> u64 {
        self.participant.seed
    }

    fn provenance(&self) -> Vec<String> {
        vec![
            format!(
                "passive touch: {} strokes of {} mm, the sample moves distally",
                self.strokes,
                self.parameters.triboair.track_m * 1e3
            ),
            self.parameters.provenance(),
        ]
    }

    fn check(&self, run: &RunPlan) -> Result<(), DeviceError> {
        load_possible(run)?;
        within("an angle in degrees", run.angle.0, ANGLES_DEG)
    }

    fn at_rest(&self) -> Vec<Vec<f64>> {
        let random = |name: &str| self.participant.random(name);
        let nail = on_nail(
            &self.parameters,
            &self.participant,
            random("triboair accelerometer at rest"),
        );
        let cells = TriaxialCell::piezoelectric(
            &self.parameters.piezo_cells,
            RATE_HZ,
            self.cell_body(),
            random("triboair cells at rest"),
        );
        let mut channels = quiet(nail, cells);
        channels.push(vec![0.0; CALIBRATION]);
        channels
    }

    fn begin(&self, run: &RunPlan) -> Box<dyn Stretches> {
        let name = self.scene_name(run);
        let asked_n = run.load.map_or(0.0, |load| load.0);
        let scene = Scene {
            name: &name,
            parameters: &self.parameters,
            participant: &self.participant,
            sample: &self.sample,
            movement: SlidingDirection::Proximal,
            dragging: MovingSide::Surface,
            load_n: asked_n * self.participant.hand.force,
            angle_deg: run.angle.0,
        };
        let Touched {
            sliding,
            held,
            nail,
        } = Touched::of(scene, |what| self.random(run, what));
        let hand = &self.parameters.hand;
        Box::new(PassiveRun {
            sliding,
            held,
            ripple: Wander::new(
                self.parameters.triboair.speed_ripple,
                RIPPLE_MEMORY_S,
                RATE_HZ,
                self.random(run, "platform"),
            ),
            tremor: Wander::new(hand.tremor_m_s2, 0.5, RATE_HZ, self.random(run, "tremor")),
            nail,
            cells: TriaxialCell::piezoelectric(
                &self.parameters.piezo_cells,
                RATE_HZ,
                self.cell_body(),
                self.random(run, "cells"),
            ),
            position_m: 0.0,
            at: 0,
            stroke: 0,
            run: run.clone(),
            bench: self.clone(),
        })
    }
}

struct PassiveRun {
    bench: TriboAir,
    run: RunPlan,
    sliding: Sliding,
    held: SlowHand,
    ripple: Wander,
    tremor: Wander,
    nail: Accelerometer,
    cells: TriaxialCell,
    position_m: f64,
    at: usize,
    stroke: usize,
}

/// The times of one stroke, s, from its beginning.
struct Timetable {
    touch: f64,
    start: f64,
    ramp: f64,
    stop: f64,
    leave: f64,
    back: f64,
    end: f64,
}

impl Timetable {
    fn of(parameters: &TriboAirParameters, speed_m_s: f64) -> Self {
        let ramp = speed_m_s / parameters.acceleration_m_s2;
        // The area of the trapezoid is the track.
        let moving = parameters.track_m / speed_m_s + ramp;
        let touch = parameters.waiting_s;
        let start = touch + parameters.placing_s + parameters.waiting_s;
        let stop = start + moving;
        let leave = stop + parameters.waiting_s;
        let back = leave + parameters.placing_s;
        Self {
            touch,
            start,
            ramp,
            stop,
            leave,
            back,
            end: back + 1.5 * parameters.track_m / parameters.return_m_s,
        }
    }

    /// The platform's speed as a share of the one asked for, at `t` within the motion.
    fn trapezoid(&self, t: f64) -> f64 {
        let up = (t - self.start) / self.ramp;
        let down = (self.stop - t) / self.ramp;
        up.min(down).clamp(0.0, 1.0)
    }
}

impl Stretches for PassiveRun {
    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        if self.stroke == self.bench.strokes {
            return None;
        }
        let triboair = &self.bench.parameters.triboair;
        let times = Timetable::of(triboair, self.bench.speed_m_s);
        let count = (times.end * RATE_HZ) as usize;
        let (mut speed, mut force) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            let t = i as f64 / RATE_HZ;
            let share = times.trapezoid(t);
            speed.push((self.bench.speed_m_s * share * (1.0 + self.ripple.next())).max(0.0));
            let held = self.held.next();
            let placed = smooth((t - times.touch) / triboair.placing_s);
            let lifted = smooth((times.back - t) / triboair.placing_s);
            force.push(held * placed * lifted);
        }
        let label = format!("passage {}", self.stroke);
        self.stroke += 1;
        let passage = self.bench.random(&self.run, &label);
        let SlideResult {
            acceleration_m_s2,
            friction_n,
        } = self.sliding.slide(&speed, &force, passage);
        // The way back is a smooth one, under a lifted finger.
        let (from_m, back_s) = (self.position_m, times.end - times.back);
        let moved_m: f64 = speed.iter().sum::<f64>() / RATE_HZ;
        let hz = self.bench.parameters.hand.tremor_hz;
        let mut channels = empty(5, count);
        for i in 0..count {
            let t = i as f64 / RATE_HZ;
            self.at += 1;
            let shake = TAU * hz * self.at as f64 / RATE_HZ;
            let tremor = std::f64::consts::SQRT_2 * self.tremor.next() * shake.sin();
            channels[0].push(self.nail.read(acceleration_m_s2[i] + tremor));
            let reading = self.cells.read([0.0, friction_n[i], force[i]]);
            for (channel, axis) in channels[1..4].iter_mut().zip(reading) {
                channel.push(axis);
            }
            self.position_m += speed[i] / RATE_HZ;
            if t > times.back {
                let left = 1.0 - smooth((t - times.back) / back_s);
                self.position_m = from_m + moved_m * left;
            }
            let step = triboair.encoder_step_m;
            channels[4].push((self.position_m / step).round() * step);
        }
        self.position_m = from_m;
        debug_assert!(times.leave < times.back);
        Some(channels)
    }
}
