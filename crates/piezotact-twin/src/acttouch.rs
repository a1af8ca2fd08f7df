//! `ActTouch`, the bench of active touch (*thesis* 2.3.1): a sample on a triaxial force cell, a person who strokes it
//! and lifts the finger after every stroke, an accelerometer on the nail.

use std::f64::consts::TAU;

use piezotact::quantity::Unit;
use piezotact::recording::{Condition, Touch};

use super::RATE_HZ;
use super::camera::Camera;
use super::drag::MovingSide;
use super::parameters::{HandParameters, Sample, TwinParameters};
use super::participant::Participant;
use super::protocol::{
    ANGLES_DEG, Pace, SlidingDirection, load_possible, strokes_possible, within,
};
use super::sensors::{Accelerometer, SlowHand, TriaxialCell};
use super::session::{
    CALIBRATION, Session, Stretches, Touched, Touching, empty, nail_and_forces, on_nail, quiet,
};
use super::sliding::{Scene, SlideResult, Sliding};
use super::wander::SmoothWander;
use piezotact_bench::random::Random;
use piezotact_bench::{Acquire, DeviceError, RunPlan};

/// A stroke shorter than this has no steady part left once landing and take-off are cut, s.
const SHORTEST_STROKE_S: f64 = 0.6;
/// A longer stroke would be mistaken for two strokes or for a drift of the force cell, s.
const LONGEST_STROKE_S: f64 = 6.0;
/// Free touch presses no harder than this, N (*chosen*).
const MOST_FREE_FORCE_N: f64 = 2.0;

/// The protocol of active touch: number, direction and pace of the strokes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveProtocol {
    pub strokes: usize,
    /// The direction of the strokes.
    pub movement: SlidingDirection,
    /// Who sets speed and force.
    pub pace: Pace,
}

/// The twin of `ActTouch`, with one person and one sample on it.
#[derive(Clone, Debug)]
pub struct ActTouch {
    parameters: TwinParameters,
    participant: Participant,
    sample: Sample,
    protocol: ActiveProtocol,
}

impl ActTouch {
    /// The bench with `participant` at it and `sample` on it.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] with what is possible, for strokes that the plate cannot hold.
    pub fn new(
        parameters: &TwinParameters,
        participant: Participant,
        sample: &Sample,
        protocol: ActiveProtocol,
    ) -> Result<Self, DeviceError> {
        strokes_possible(protocol.strokes)?;
        if let Pace::Metronome {
            speed_m_s,
            stroke_s,
        } = protocol.pace
        {
            let way_m = stroke_m(parameters, sample);
            let fits = [way_m / LONGEST_STROKE_S, way_m / SHORTEST_STROKE_S];
            let mm = |m: f64| (m * 1e5).round() / 100.0;
            let impossible = |expected: String, found: String, todo: &str| {
                Err(DeviceError::Impossible {
                    expected,
                    found,
                    todo: todo.into(),
                })
            };
            if !(fits[0]..=fits[1]).contains(&speed_m_s) {
                return impossible(
                    format!(
                        "a speed from {} to {} mm/s, so that a stroke over the {} mm of {} lasts {SHORTEST_STROKE_S} to {LONGEST_STROKE_S} s",
                        mm(fits[0]),
                        mm(fits[1]),
                        mm(way_m),
                        sample.name
                    ),
                    format!("{} mm/s", mm(speed_m_s)),
                    "ask for one of those; 30 mm/s is usual",
                );
            }
            if let Some(stroke_s) = stroke_s {
                if !(SHORTEST_STROKE_S..=LONGEST_STROKE_S).contains(&stroke_s) {
                    return impossible(
                        format!("a stroke of {SHORTEST_STROKE_S} to {LONGEST_STROKE_S} s"),
                        format!("{stroke_s} s"),
                        "ask for one of those",
                    );
                }
                if speed_m_s * stroke_s > way_m * (1.0 + 1e-9) {
                    return impossible(
                        format!(
                            "strokes that fit the {} mm of {}: at most {} mm/s for {stroke_s} s, or at most {:.3} s at {} mm/s",
                            mm(way_m),
                            sample.name,
                            mm(way_m / stroke_s),
                            way_m / speed_m_s,
                            mm(speed_m_s)
                        ),
                        format!(
                            "{} mm/s for {stroke_s} s, which are {} mm",
                            mm(speed_m_s),
                            mm(speed_m_s * stroke_s)
                        ),
                        "stroke more slowly or for a shorter time",
                    );
                }
            }
        }
        Ok(Self {
            parameters: parameters.clone(),
            participant,
            sample: sample.clone(),
            protocol,
        })
    }

    /// Its acquiring half; a person moves.
    #[must_use]
    pub fn into_acquirer(self) -> Box<dyn Acquire> {
        Session::boxed(self)
    }

    fn random(&self, run: &RunPlan, what: &str) -> Random {
        self.participant
            .random(&format!("{} {what}", self.scene_name(run)))
    }

    /// The name of a run for its random stream: the sample, how it is touched, and the label.
    fn scene_name(&self, run: &RunPlan) -> String {
        let movement = self.protocol.movement.word();
        let pace = match self.protocol.pace {
            Pace::Metronome { speed_m_s, .. } => format!("{:.0} um/s", speed_m_s * 1e6),
            Pace::Free => "free".into(),
        };
        let load_mn = run.load.map_or(0.0, |load| load.0 * 1e3);
        let sample = &self.sample.name;
        format!(
            "acttouch {sample} {movement} {pace} {load_mn:.0} mN {}",
            run.label
        )
    }

    /// The random stream of the force cell, the same for every participant.
    fn cell_body(&self) -> Random {
        Random::stream(self.participant.seed, 0, "force cell of acttouch")
    }

    /// Whether a camera follows the fingertip; circles have no way along one axis.
    fn is_followed(&self) -> bool {
        self.parameters.hand.track_hz > 0.0 && self.protocol.movement != SlidingDirection::Circular
    }

    /// The force that this person intends to apply, N.
    fn load_n(&self, run: &RunPlan) -> f64 {
        let hand = &self.participant.hand;
        match (self.protocol.pace, run.load) {
            (Pace::Metronome { .. }, Some(load)) => load.0 * hand.force,
            (Pace::Metronome { .. }, None) | (Pace::Free, _) => {
                let friction = self.sample.friction * self.participant.skin.friction;
                let exponent = self.parameters.hand.free_force_exponent;
                (hand.free_force_n * (friction / 0.6).powf(exponent)).min(MOST_FREE_FORCE_N)
            }
        }
    }
}

/// How long a stroke over a sample can be, m.
fn stroke_m(parameters: &TwinParameters, sample: &Sample) -> f64 {
    (sample.plate_m - parameters.hand.stroke_margin_m).max(0.2 * sample.plate_m)
}

impl Touching for ActTouch {
    fn name(&self) -> String {
        format!(
            "digital twin of the ActTouch bench, participant {}",
            self.participant.pseudonym()
        )
    }

    fn channels(&self) -> Vec<(String, Unit)> {
        let mut channels = nail_and_forces();
        if self.is_followed() {
            channels.push(("position".into(), Unit::Metre));
        }
        channels
    }

    fn condition(&self) -> Condition {
        Condition {
            sample: Some(self.sample.name.clone()),
            participant: Some(self.participant.pseudonym()),
            twin_seed: Some(self.participant.seed),
            speed_m_s: match self.protocol.pace {
                Pace::Metronome { speed_m_s, .. } => Some(speed_m_s),
                Pace::Free => None,
            },
            touch: Some(Touch::Active),
            direction: Some(self.protocol.movement),
            ..Condition::default()
        }
    }

    fn seed(&self) -> u64 {
        self.participant.seed
    }

    fn provenance(&self) -> Vec<String> {
        let movement = self.protocol.movement.word();
        let pace = match self.protocol.pace {
            Pace::Metronome { .. } => "with a metronome",
            Pace::Free => "at free speed and force",
        };
        vec![
            format!(
                "active touch: {} {movement} strokes {pace}",
                self.protocol.strokes
            ),
            self.parameters.provenance(),
        ]
    }

    fn check(&self, run: &RunPlan) -> Result<(), DeviceError> {
        if matches!(self.protocol.pace, Pace::Metronome { .. }) {
            load_possible(run)?;
        }
        within("an angle in degrees", run.angle.0, ANGLES_DEG)
    }

    fn at_rest(&self) -> Vec<Vec<f64>> {
        let random = |name: &str| self.participant.random(name);
        let nail = on_nail(
            &self.parameters,
            &self.participant,
            random("acttouch accelerometer at rest"),
        );
        let cells = TriaxialCell::strain_gauge(
            &self.parameters.force_cell,
            RATE_HZ,
            self.cell_body(),
            random("acttouch cells at rest"),
        );
        let mut channels = quiet(nail, cells);
        if self.is_followed() {
            channels.push(vec![0.0; CALIBRATION]);
        }
        channels
    }

    fn begin(&self, run: &RunPlan) -> Box<dyn Stretches> {
        Box::new(self.active_run(run))
    }
}

impl ActTouch {
    fn active_run(&self, run: &RunPlan) -> ActiveRun {
        let name = self.scene_name(run);
        let scene = Scene {
            name: &name,
            parameters: &self.parameters,
            participant: &self.participant,
            sample: &self.sample,
            movement: self.protocol.movement,
            dragging: MovingSide::Hand,
            load_n: self.load_n(run),
            angle_deg: run.angle.0,
        };
        let Touched {
            sliding,
            held,
            nail,
        } = Touched::of(scene, |what| self.random(run, what));
        let hand = &self.parameters.hand;
        let mut random = self.random(run, "hand");
        let gesture_m_s2 = hand.gesture_least_m_s2
            + (hand.gesture_most_m_s2 - hand.gesture_least_m_s2) * random.uniform();
        ActiveRun {
            sliding,
            held,
            // The speed of a hand is as smooth as its force: it has a mass.
            haste: SmoothWander::new(
                hand.speed_spread_within,
                hand.speed_memory_s,
                RATE_HZ,
                self.random(run, "speed"),
            ),
            gesture: SmoothWander::new(
                gesture_m_s2,
                1.0 / (TAU * hand.gesture_hz),
                RATE_HZ,
                self.random(run, "gesture"),
            ),
            nail,
            cell: TriaxialCell::strain_gauge(
                &self.parameters.force_cell,
                RATE_HZ,
                self.cell_body(),
                self.random(run, "cell"),
            ),
            random,
            camera: Camera::of(hand, self.random(run, "camera")).filter(|_| self.is_followed()),
            place_m: 0.0,
            run: run.clone(),
            stroke: 0,
            bench: self.clone(),
            #[cfg(test)]
            truth: std::sync::Arc::default(),
        }
    }
}

struct ActiveRun {
    bench: ActTouch,
    run: RunPlan,
    sliding: Sliding,
    held: SlowHand,
    haste: SmoothWander,
    gesture: SmoothWander,
    nail: Accelerometer,
    cell: TriaxialCell,
    random: Random,
    camera: Option<Camera>,
    /// Where the fingertip is along the sample, m.
    place_m: f64,
    stroke: usize,
    #[cfg(test)]
    truth: std::sync::Arc<std::sync::Mutex<Vec<(usize, usize)>>>,
}

/// From 0 to 1 between 0 and 1, with a horizontal tangent at both ends.
pub(crate) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// One intended stroke.
struct Stroke {
    lift: usize,
    contact: usize,
    speed_m_s: f64,
}

impl ActiveRun {
    /// The next stroke as executed by this hand.
    fn stroke(&mut self) -> Stroke {
        let hand: &HandParameters = &self.bench.parameters.hand;
        let person = &self.bench.participant.hand;
        let way_m = stroke_m(&self.bench.parameters, &self.bench.sample);
        let (meant_m_s, spread) = match self.bench.protocol.pace {
            Pace::Metronome { speed_m_s, .. } => {
                (speed_m_s * person.speed, hand.speed_spread_metronome)
            }
            Pace::Free => (person.free_speed_m_s, hand.speed_spread_free),
        };
        let mut speed_m_s = meant_m_s * (spread * self.random.person()).exp();
        let stroke_s = match self.bench.protocol.pace {
            Pace::Metronome {
                stroke_s: Some(stroke_s),
                ..
            } => {
                speed_m_s = speed_m_s.min(way_m / stroke_s);
                stroke_s
            }
            _ => {
                speed_m_s = speed_m_s.min(way_m / SHORTEST_STROKE_S);
                (way_m / speed_m_s).min(LONGEST_STROKE_S)
            }
        };
        let lift_s = hand.lift_s * (hand.lift_spread * self.random.person()).exp();
        Stroke {
            lift: (lift_s * RATE_HZ) as usize,
            contact: (stroke_s * RATE_HZ) as usize,
            speed_m_s,
        }
    }

    /// The speed of the hand and the force of the finger, a sample each; in the air the force is 0.
    fn meant(&mut self, stroke: &Stroke) -> (Vec<f64>, Vec<f64>) {
        let hand = &self.bench.parameters.hand;
        let seconds = stroke.contact as f64 / RATE_HZ;
        let count = stroke.lift + stroke.contact;
        let (mut speed, mut force) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            let t = (i as f64 - stroke.lift as f64) / RATE_HZ;
            let up = smooth(t / hand.ramp_s + 0.5);
            let down = smooth((seconds - t) / hand.ramp_s + 0.5);
            let pace = 1.0 + self.haste.next();
            speed.push((stroke.speed_m_s * up * down * pace).max(0.0));
            let held = self.held.next();
            force.push(if t < 0.0 {
                0.0
            } else {
                held * smooth(t / hand.landing_s) * smooth((seconds - t) / hand.take_off_s)
            });
        }
        (speed, force)
    }

    /// Where the fingertip is along the sample, a sample each, m: back at the beginning before the hand gets up to speed.
    fn places_m(&mut self, stroke: &Stroke, speed: &[f64]) -> Vec<f64> {
        let ramp = (0.5 * self.bench.parameters.hand.ramp_s * RATE_HZ) as usize;
        let back = stroke.lift.saturating_sub(ramp).max(1);
        let from_m = self.place_m;
        let mut place_m = 0.0;
        let places = speed.iter().enumerate().map(|(i, speed)| {
            place_m += speed / RATE_HZ;
            place_m + from_m * (1.0 - smooth(i as f64 / back as f64))
        });
        let places = places.collect();
        self.place_m = place_m;
        places
    }

    /// Adds the knock of a finger that lands, or leaves, at `at`.
    fn knock(&mut self, acceleration: &mut [f64], at: usize, share: f64) {
        let hand = &self.bench.parameters.hand;
        let most = hand.transient_most_m_s2.max(hand.transient_least_m_s2);
        let peak = share
            * (hand.transient_least_m_s2
                + (most - hand.transient_least_m_s2) * self.random.uniform());
        let hz = hand.transient_hz * (0.2 * self.random.person()).exp();
        let length = (8.0 * hand.transient_s * RATE_HZ) as usize;
        for (i, a) in acceleration.iter_mut().skip(at).take(length).enumerate() {
            let t = i as f64 / RATE_HZ;
            *a += peak * (-t / hand.transient_s).exp() * (TAU * hz * t).sin();
        }
    }

    /// The unit vector of the friction on the sample, along x and y, for every moment.
    fn directions(&mut self, speed: &[f64]) -> Vec<[f64; 2]> {
        let hand = &self.bench.parameters.hand;
        let yaw = hand.yaw_deg.to_radians() * self.random.person();
        let straight = |angle: f64| [angle.cos(), angle.sin()];
        match self.bench.protocol.movement {
            SlidingDirection::Proximal => vec![straight(TAU / 4.0 + yaw); speed.len()],
            SlidingDirection::Distal => vec![straight(yaw - TAU / 4.0); speed.len()],
            SlidingDirection::Transversal => vec![straight(yaw); speed.len()],
            SlidingDirection::Circular => {
                let mut angle = TAU * self.random.uniform();
                speed
                    .iter()
                    .map(|v| {
                        angle += v / RATE_HZ / hand.circle_m;
                        straight(angle)
                    })
                    .collect()
            }
        }
    }
}

impl Stretches for ActiveRun {
    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        let last = self.bench.protocol.strokes;
        if self.stroke > last {
            return None;
        }
        let mut stroke = self.stroke();
        if self.stroke == last {
            // The hand moves away.
            stroke.contact = 0;
        }
        #[cfg(test)]
        if let Ok(mut truth) = self.truth.lock() {
            truth.push((stroke.lift, stroke.contact));
        }
        let label = format!("passage {}", self.stroke);
        self.stroke += 1;
        let (speed, force) = self.meant(&stroke);
        let directions = self.directions(&speed);
        let passage = self.bench.random(&self.run, &label);
        let SlideResult {
            mut acceleration_m_s2,
            friction_n,
        } = self.sliding.slide(&speed, &force, passage);
        if stroke.contact > 0 {
            self.knock(&mut acceleration_m_s2, stroke.lift, 1.0);
            let leaves = (self.bench.parameters.hand.take_off_s * RATE_HZ) as usize;
            self.knock(
                &mut acceleration_m_s2,
                (stroke.lift + stroke.contact).saturating_sub(leaves / 3),
                0.3,
            );
        }
        let mut channels = empty(4, force.len());
        let places_m = self.places_m(&stroke, &speed);
        if let Some(camera) = &mut self.camera {
            channels.push(places_m.iter().map(|place| camera.read(*place)).collect());
        }
        for i in 0..force.len() {
            channels[0].push(self.nail.read(acceleration_m_s2[i] + self.gesture.next()));
            let [x, y] = directions[i];
            let reading = self
                .cell
                .read([x * friction_n[i], y * friction_n[i], force[i]]);
            for (channel, axis) in channels[1..4].iter_mut().zip(reading) {
                channel.push(axis);
            }
        }
        Some(channels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Degrees, Newtons};
    use piezotact::recording::{Channel, Provenance, Recording};
    use piezotact::roles::Roles;
    use piezotact::stroke::{Expected, Judging, segment};

    fn protocol() -> ActiveProtocol {
        ActiveProtocol {
            strokes: 15,
            movement: SlidingDirection::Proximal,
            pace: Pace::Metronome {
                speed_m_s: 0.03,
                stroke_s: None,
            },
        }
    }

    fn run() -> RunPlan {
        RunPlan {
            label: "cuts".into(),
            load: Some(Newtons(0.2)),
            angle: Degrees(20.0),
            placement: piezotact_bench::Placement::New,
            until: piezotact_bench::Until::Stopped,
        }
    }

    /// The analysis, which does not see what the hand meant to do, finds every stroke of forty people: it begins when
    /// the landing is over and ends before the take-off, within 60 ms of 100 ms after and 80 ms before them.
    #[test]
    fn the_cuts_of_the_analysis_are_those_of_the_hand() {
        let parameters = TwinParameters::built_in();
        let (mut found, mut worst_s) = (0, 0.0f64);
        for number in 1..=40 {
            let sample = format!("S{}", 1 + number % 13);
            let sample = parameters.sample(&sample).unwrap();
            let person = Participant::of(number, 3, &parameters);
            let bench = ActTouch::new(&parameters, person, sample, protocol()).unwrap();
            let mut active = bench.active_run(&run());
            let truth = std::sync::Arc::clone(&active.truth);
            let mut channels = vec![Vec::new(); 4];
            while let Some(stretch) = active.next() {
                for (channel, samples) in channels.iter_mut().zip(stretch) {
                    channel.extend(samples);
                }
            }
            let channels = bench.channels().into_iter().zip(channels);
            let channels = channels.map(|((name, unit), samples)| Channel {
                name,
                unit,
                samples,
            });
            let rate = crate::session::rate();
            let recording = Recording::new(
                channels.collect(),
                rate,
                bench.condition(),
                Provenance::default(),
            )
            .unwrap();
            let (roles, _) = Roles::guess(&recording);
            let expected = Expected {
                load_n: Some(Newtons(0.2)),
                speed_m_s: Some(0.03),
                judging: Judging::Sliding,
            };
            let cut = segment(&recording, &roles, expected).unwrap();
            assert_eq!(
                cut.strokes.len(),
                15,
                "participant {number}: {:?}",
                cut.rejected
            );
            let mut at = 0;
            for ((lift, contact), stroke) in truth.lock().unwrap().iter().zip(&cut.strokes) {
                let (from, to) = (at + lift, at + lift + contact);
                let seconds = |samples: usize| samples as f64 / RATE_HZ;
                let (start_s, end_s) = (seconds(stroke.steady.start), seconds(stroke.steady.end));
                worst_s = worst_s
                    .max((start_s - seconds(from) - 0.1).abs())
                    .max((seconds(to) - end_s - 0.08).abs());
                at = to;
                found += 1;
            }
        }
        assert_eq!(found, 600);
        // The force takes 80 ms to rise and 60 ms to fall, and is noticed somewhere on the way.
        assert!(worst_s < 0.06, "{worst_s}");
    }

    #[test]
    fn strokes_that_the_plate_cannot_hold_are_refused() {
        let parameters = TwinParameters::built_in();
        let sample = parameters.sample("M8").unwrap();
        let asked = |speed_m_s: f64, stroke_s: Option<f64>| {
            let protocol = ActiveProtocol {
                pace: Pace::Metronome {
                    speed_m_s,
                    stroke_s,
                },
                ..protocol()
            };
            let person = Participant::of(1, 1, &parameters);
            ActTouch::new(&parameters, person, sample, protocol).map(|_| ())
        };
        // 60 mm of plate leave 50 mm.
        assert!(asked(0.05, Some(1.0)).is_ok());
        for (speed_m_s, stroke_s, says) in [
            (0.06, Some(1.0), "at most 50 mm/s for 1 s"),
            (0.2, None, "from 8.33 to 83.33 mm/s"),
            (-0.03, None, "from 8.33 to 83.33 mm/s"),
            (f64::NAN, None, "from 8.33 to 83.33 mm/s"),
            (0.03, Some(0.1), "a stroke of 0.6 to 6 s"),
            (0.03, Some(f64::NAN), "a stroke of 0.6 to 6 s"),
        ] {
            let text = asked(speed_m_s, stroke_s).unwrap_err().to_string();
            assert!(text.contains(says), "{text}");
        }
    }
}
