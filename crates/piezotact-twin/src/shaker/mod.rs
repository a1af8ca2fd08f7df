//! The shaker bench of the thesis' 2.5.2: a shaker that the acquisition drives in open loop, on it a force cell with
//! a ceramic plate, the participant's finger on the plate and an accelerometer on the nail.
//!
//! The drive is random noise, and the ratio of acceleration to force is the finger's inertance. The same bench
//! with the accelerometer waxed to the plate gives the control measurement.
//!
//! Not modelled: a finger that loses contact at strong drive and light load, the nail's motion by
//! tremor of the hand, and the coil's inductance.

mod model;
#[cfg(test)]
mod tests;

use piezotact::quantity::{Band, Hertz, Seconds, Unit};
use piezotact::recording::{Condition, Touch};

use model::{Acceleration, Force, Loaded, Standing};

use super::RATE_HZ;
use super::finger::Placement;
use super::noise::BandNoise;
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::protocol::{ANGLES_DEG, load_possible, within};
use super::sensors::{Accelerometer, ChargeCell, SlowHand};
use super::session::{CALIBRATION, CHUNK, Session, Stretches, Touching};
use super::varying::VaryingResponse;
use piezotact_bench::random::Random;
use piezotact_bench::{Acquire, DeviceError, RunPlan};

/// The mounting of the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShakerMount {
    /// The nail of the participant, whose finger is on the plate.
    Finger,
    /// The plate, to which it is waxed: the control measurement, and nobody touches.
    Plate,
}

/// The random drive of the shaker.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerExcitation {
    /// How long, from 1 to 600 s.
    pub duration: Seconds,
    /// Its level, V rms.
    pub rms_v: f64,
    /// The band that is excited.
    pub band: Band,
    /// The seed. The drive depends on nothing else of the bench: every run has the same.
    pub seed: u64,
}

impl ShakerExcitation {
    /// Random noise of 0.5 V rms (*chosen*) from 2 Hz (*chosen*) to 1 kHz (*thesis* 2.5.2).
    #[must_use]
    pub fn thesis(duration: Seconds, seed: u64) -> Self {
        let band = Band::new(Hertz(2.0), Hertz(1000.0));
        Self {
            duration,
            rms_v: 0.5,
            band: band.unwrap_or_else(|_| unreachable!("a constant band that rises")),
            seed,
        }
    }

    fn samples(&self) -> usize {
        (self.duration.0 * RATE_HZ).round() as usize
    }
}

/// The twin of the shaker bench.
///
/// The placement of the finger is drawn from the label of the run for which it was placed.
#[derive(Clone, Debug)]
pub struct ShakerBench {
    twin: TwinParameters,
    participant: Participant,
    mount: ShakerMount,
    excitation: ShakerExcitation,
}

impl ShakerBench {
    /// The bench with the finger of `participant`, or for the control measurement, driven by `excitation`. What it
    /// cannot do is refused when a run is made ready.
    #[must_use]
    pub fn new(
        parameters: &TwinParameters,
        participant: Participant,
        mount: ShakerMount,
        excitation: ShakerExcitation,
    ) -> Self {
        Self {
            twin: parameters.clone(),
            participant,
            mount,
            excitation,
        }
    }

    /// The acquisition, which drives the shaker itself.
    #[must_use]
    pub fn into_acquirer(self) -> Box<dyn Acquire> {
        Session::boxed(self)
    }

    fn random(&self, name: &str) -> Random {
        self.participant.random(&format!("shaker {name}"))
    }

    fn loaded(&self, run: &RunPlan) -> Loaded {
        Loaded {
            parameters: self.twin.shaker.clone(),
            standing: match self.mount {
                ShakerMount::Finger => Standing::Finger {
                    finger: Box::new(self.participant.finger.clone()),
                    placement: Placement::of(
                        &self.twin,
                        self.participant.number,
                        self.participant.seed,
                        &format!("shaker {}", run.placed_for()),
                    ),
                    angle_deg: run.angle.0,
                },
                ShakerMount::Plate => Standing::Accelerometer,
            },
        }
    }

    /// The force cell in the run `label`. It drifts only where a finger warms it.
    fn cell(&self, label: &str) -> ChargeCell {
        let p = &self.twin.shaker;
        let mut random = self.random(&format!("force cell {label}"));
        let share = random.uniform();
        let drift_n = match self.mount {
            ShakerMount::Finger => p.least_drift_n + share * (p.most_drift_n - p.least_drift_n),
            ShakerMount::Plate => 0.0,
        };
        ChargeCell::new(p.force_noise_n, drift_n, p.drift_s, random)
    }

    fn possible(&self, run: &RunPlan) -> Result<(), DeviceError> {
        match (self.mount, run.load) {
            (ShakerMount::Finger, _) => {
                load_possible(run)?;
                within("an angle in degrees", run.angle.0, ANGLES_DEG)?;
            }
            (ShakerMount::Plate, Some(load)) => {
                return Err(DeviceError::Impossible {
                    expected: "no load, since no finger touches the plate".into(),
                    found: load.to_string(),
                    todo: "leave it out, or mount the finger".into(),
                });
            }
            (ShakerMount::Plate, None) => {}
        }
        let ShakerExcitation {
            duration,
            rms_v,
            band,
            ..
        } = &self.excitation;
        if !(1.0..=600.0).contains(&duration.0) {
            return Err(DeviceError::Duration { found: *duration });
        }
        let most_v = self.twin.shaker.most_rms_v;
        within("a drive in V rms", *rms_v, [0.001, most_v])?;
        let (width_hz, least_hz) = (band.high().0 - band.low().0, 2.0 * BandNoise::RESOLUTION_HZ);
        let nyquist_hz = RATE_HZ / 2.0;
        if band.high().0 >= nyquist_hz || width_hz < least_hz {
            return Err(DeviceError::Impossible {
                expected: format!(
                    "a band below {nyquist_hz} Hz, half the rate of the acquisition, and at least {least_hz:.1} Hz wide"
                ),
                found: band.to_string(),
                todo: "2..1000 Hz is usual".into(),
            });
        }
        Ok(())
    }
}

/// One run, from the first sample to the last. It holds what is ahead of the samples that were handed out, and
/// nothing behind them.
struct Run {
    samples: usize,
    at: usize,
    drawn: usize,
    noise: BandNoise,
    /// The hand on the plate; nobody in the control measurement.
    hand: Option<SlowHand>,
    /// Drive and true static load, from sample `at` on.
    drive_v: Vec<f64>,
    load_n: Vec<f64>,
    force: VaryingResponse<Force>,
    acceleration: VaryingResponse<Acceleration>,
    cell: ChargeCell,
    accelerometer: Accelerometer,
}

impl Run {
    fn new(bench: &ShakerBench, run: &RunPlan) -> Self {
        let loaded = bench.loaded(run);
        let ShakerExcitation {
            rms_v, band, seed, ..
        } = bench.excitation;
        let hand = || {
            SlowHand::new(
                &bench.twin.hand,
                run.load.map_or(0.0, |load| load.0),
                RATE_HZ,
                bench.random(&format!("hand {}", run.label)),
            )
        };
        Self {
            samples: bench.excitation.samples(),
            at: 0,
            drawn: 0,
            noise: BandNoise::new(band, rms_v, Random::stream(seed, 0, "shaker drive")),
            hand: (bench.mount == ShakerMount::Finger).then(hand),
            drive_v: Vec::new(),
            load_n: Vec::new(),
            force: VaryingResponse::new(Force(loaded.clone())),
            acceleration: VaryingResponse::new(Acceleration(loaded)),
            cell: bench.cell(&run.label),
            accelerometer: Accelerometer::new(
                &bench.twin.accelerometer,
                RATE_HZ,
                bench.random(&format!("accelerometer {}", run.label)),
            )
            .calibrated(bench.participant.seed),
        }
    }

    /// Draws drive and load up to, not including, sample `until` of the run.
    fn draw(&mut self, until: usize) {
        let count = until.min(self.samples).saturating_sub(self.drawn);
        let drive_v = self.noise.take(count);
        let load_n: Vec<f64> = (self.drawn..self.drawn + count)
            .map(|sample| match &mut self.hand {
                // The person watches the reading, and compensates the drift from the cell's warming.
                Some(hand) => {
                    let held_n = hand.next();
                    (held_n - self.cell.warmth_n(sample as f64 / RATE_HZ)).max(0.0)
                }
                None => 0.0,
            })
            .collect();
        self.drawn += count;
        self.force.feed(&drive_v, &load_n);
        self.acceleration.feed(&drive_v, &load_n);
        self.drive_v.extend(drive_v);
        self.load_n.extend(load_n);
    }

    /// The next `count` samples, or as many as there are; `None` at the end.
    fn take(&mut self, count: usize) -> Option<Vec<Vec<f64>>> {
        let count = count.min(self.samples - self.at);
        if count == 0 {
            return None;
        }
        self.draw(self.at + count + VaryingResponse::<Force>::LOOKAHEAD);
        let dynamic_n = self.force.take(count);
        let force = self
            .load_n
            .drain(..count)
            .zip(dynamic_n)
            .zip(self.at..)
            .map(|((load_n, dynamic_n), sample)| {
                let after_s = sample as f64 / RATE_HZ;
                self.cell.read(load_n + dynamic_n, after_s)
            })
            .collect();
        let acceleration = self.acceleration.take(count).into_iter();
        let channels = vec![
            self.drive_v.drain(..count).collect(),
            force,
            acceleration.map(|a| self.accelerometer.read(a)).collect(),
        ];
        self.at += count;
        Some(channels)
    }
}

impl Stretches for Run {
    fn next(&mut self) -> Option<Vec<Vec<f64>>> {
        self.take(CHUNK)
    }
}

impl Touching for ShakerBench {
    fn name(&self) -> String {
        let on = match self.mount {
            ShakerMount::Finger => format!("participant {}", self.participant.pseudonym()),
            ShakerMount::Plate => "accelerometer on the plate".into(),
        };
        format!("digital twin of the shaker bench, {on}")
    }

    fn channels(&self) -> Vec<(String, Unit)> {
        vec![
            ("drive".into(), Unit::Volt),
            ("force".into(), Unit::Newton),
            ("acceleration".into(), Unit::MetrePerSecondSquared),
        ]
    }

    fn condition(&self) -> Condition {
        match self.mount {
            ShakerMount::Finger => Condition {
                touch: Some(Touch::Resting),
                participant: Some(self.participant.pseudonym()),
                twin_seed: Some(self.participant.seed),
                ..Condition::default()
            },
            ShakerMount::Plate => Condition::default(),
        }
    }

    fn seed(&self) -> u64 {
        self.participant.seed
    }

    fn provenance(&self) -> Vec<String> {
        vec![self.twin.provenance()]
    }

    fn check(&self, run: &RunPlan) -> Result<(), DeviceError> {
        self.possible(run)
    }

    fn at_rest(&self) -> Vec<Vec<f64>> {
        let mut cell = self.cell("at rest");
        let mut accelerometer = Accelerometer::new(
            &self.twin.accelerometer,
            RATE_HZ,
            self.random("accelerometer at rest"),
        );
        let force = (0..CALIBRATION).map(|_| cell.read(0.0, 0.0)).collect();
        let acceleration = (0..CALIBRATION).map(|_| accelerometer.read(0.0)).collect();
        vec![vec![0.0], force, acceleration]
    }

    fn begin(&self, run: &RunPlan) -> Box<dyn Stretches> {
        Box::new(Run::new(self, run))
    }
}
