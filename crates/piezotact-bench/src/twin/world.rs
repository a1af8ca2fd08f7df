//! The world behind the two halves of the twin: what is played on one is felt and measured on the other.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::Arc;

use num_complex::Complex;
use piezotact::Series;
use piezotact::device::{AmplifierGain, DriveSetup};
use piezotact::quantity::{Drive, Hertz, Quantity, SampleRate, Unit};
use piezotact::recording::{BenchKind, Condition, Touch};
use piezotact::resample::Resampler;
use piezotact::spectrum::{Symmetry, Window};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::finger::{Finger, Placement};
use super::output::OutputStage;
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::protocol::{ANGLES_DEG, load_possible, within};
use super::sensors::{Accelerometer, ForceCell, HeldForce};
use crate::random::Random;
use crate::traits::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Play, PlayDescription, PlayReport,
    RunPlan, SensorCalibration,
};

/// The rate of the sound output, Hz.
const OUTPUT_RATE_HZ: f64 = 48_000.0;
/// The rate of the acquisition, Hz (*thesis* 2.5.3).
const ACQUISITION_RATE_HZ: f64 = 5_000.0;
/// The passband of the acquisition's anti-alias filter, Hz.
const PASSBAND: Hertz = Hertz(2200.0);
/// What acquisition records before the playback starts and after it ends, s.
const LEAD_S: f64 = 0.2;
const REST_S: f64 = 0.3;
/// From the digital drive to the output's converter, s (*chosen*: a small buffer).
const LATENCY_S: f64 = 1.5e-3;
/// Samples of a chunk: half a second.
const CHUNK: usize = 2_500;
/// Samples of a calibration at rest.
const CALIBRATION: usize = 5_000;

/// The twin of the PIEZOTACT bench, with one participant at it.
#[derive(Clone, Debug)]
pub struct TwinBench {
    parameters: TwinParameters,
    participant: Participant,
    output: OutputStage,
}

impl TwinBench {
    /// The bench with the finger of `participant` on the device, and the amplifier set to `gain`.
    #[must_use]
    pub fn new(parameters: &TwinParameters, participant: Participant, gain: AmplifierGain) -> Self {
        Self {
            output: OutputStage::new(&parameters.output, gain),
            parameters: parameters.clone(),
            participant,
        }
    }

    /// Its two halves.
    #[must_use]
    pub fn into_bench(self) -> Bench {
        let world = Rc::new(RefCell::new(World {
            bench: self,
            loaded: None,
            asked: None,
            run: None,
        }));
        Bench {
            player: Box::new(Player(Rc::clone(&world))),
            acquirer: Box::new(Acquirer(world)),
        }
    }

    fn random(&self, name: &str) -> Random {
        Random::stream(self.participant.seed, self.participant.number, name)
    }

    fn name(&self) -> String {
        format!(
            "digital twin of the PIEZOTACT bench, participant {}",
            self.participant.pseudonym()
        )
    }
}

fn rate(hz: f64) -> SampleRate {
    // The two rates are constants above zero.
    SampleRate::new(hz).unwrap_or_else(|_| unreachable!("a constant rate above zero"))
}

struct World {
    bench: TwinBench,
    loaded: Option<Vec<f64>>,
    asked: Option<RunPlan>,
    run: Option<Run>,
}

/// One run: everything that happens from the first acquired sample to the last.
struct Run {
    drive: Vec<f64>,
    force_n: Vec<f64>,
    response: VaryingResponse,
    accelerometer: Accelerometer,
    cell: ForceCell,
    at: usize,
    played: usize,
}

impl World {
    /// What follows from the drive that is loaded, for the run that was asked for.
    fn begin(&mut self) -> Result<(), BenchError> {
        let run = self.asked.as_ref().ok_or(BenchError::Order {
            asked: "start",
            before: "made ready",
        })?;
        let bench = &self.bench;
        let played = self.loaded.take().unwrap_or_default();
        let to_acquisition =
            Resampler::new(rate(OUTPUT_RATE_HZ), rate(ACQUISITION_RATE_HZ), PASSBAND).map_err(
                |error| BenchError::Impossible {
                    expected: "rates that go together".into(),
                    found: error.to_string(),
                    todo: "report this".into(),
                },
            )?;
        let voltage = bench.output.voltage(
            &played,
            rate(OUTPUT_RATE_HZ),
            &mut bench.random(&format!("output {}", run.label)),
        );
        let lead = (LEAD_S * ACQUISITION_RATE_HZ) as usize;
        let acquired = |samples: &[f64]| {
            let mut all = vec![0.0; lead];
            all.extend(to_acquisition.process(samples));
            all.resize(all.len() + (REST_S * ACQUISITION_RATE_HZ) as usize, 0.0);
            all
        };
        let (drive, voltage) = (acquired(&played), acquired(&voltage));
        let mut held = HeldForce::new(
            &bench.parameters.hand,
            run.load.map_or(0.0, |load| load.0),
            ACQUISITION_RATE_HZ,
            bench.random(&format!("force {}", run.label)),
        );
        let force_n: Vec<f64> = drive.iter().map(|_| held.next()).collect();
        let person = &bench.participant;
        let placement = Placement::of(person.number, person.seed, &run.label);
        self.run = Some(Run {
            response: VaryingResponse::new(voltage, person.finger.clone(), placement, run.angle.0),
            accelerometer: Accelerometer::new(
                &bench.parameters.accelerometer,
                ACQUISITION_RATE_HZ,
                bench.random(&format!("accelerometer {}", run.label)),
            ),
            cell: ForceCell::new(
                &bench.parameters.force_cell,
                bench.random(&format!("force cell {}", run.label)),
            ),
            drive,
            force_n,
            at: 0,
            played: played.len(),
        });
        Ok(())
    }
}

impl Run {
    fn next(&mut self) -> Option<Chunk> {
        let end = (self.at + CHUNK).min(self.drive.len());
        if self.at == end {
            return None;
        }
        let (cell, accelerometer) = (&mut self.cell, &mut self.accelerometer);
        let acceleration = self.response.take(end - self.at, &self.force_n);
        let channels = vec![
            self.drive[self.at..end].to_vec(),
            acceleration
                .into_iter()
                .map(|a| accelerometer.read(a))
                .collect(),
            self.force_n[self.at..end]
                .iter()
                .map(|f| cell.read(*f))
                .collect(),
        ];
        self.at = end;
        Some(Chunk { channels })
    }
}

struct Player(Rc<RefCell<World>>);

impl Play for Player {
    fn describe(&self) -> PlayDescription {
        let world = self.0.borrow();
        PlayDescription {
            name: world.bench.name(),
            kind: BenchKind::Twin,
            rate: rate(OUTPUT_RATE_HZ),
            gain: world.bench.output.setup().gain,
        }
    }

    fn calibrate(&mut self) -> Result<DriveSetup, BenchError> {
        Ok(self.0.borrow().bench.output.setup().clone())
    }

    fn ready(&mut self, drive: &Series<Drive>, _run: &RunPlan) -> Result<(), BenchError> {
        let description = self.describe();
        if drive.rate() != description.rate {
            return Err(BenchError::Rate {
                drive: drive.rate(),
                output: description.rate,
                name: description.name,
            });
        }
        self.0.borrow_mut().loaded = Some(drive.samples().to_vec());
        Ok(())
    }

    fn start(&mut self) -> Result<(), BenchError> {
        let mut world = self.0.borrow_mut();
        if world.loaded.is_none() {
            return Err(BenchError::Order {
                asked: "play",
                before: "made ready",
            });
        }
        world.begin()
    }

    fn wait(&mut self) -> Result<PlayReport, BenchError> {
        let world = self.0.borrow();
        let run = world.run.as_ref().ok_or(BenchError::Order {
            asked: "wait",
            before: "started",
        })?;
        Ok(PlayReport {
            played: run.played,
            underruns: 0,
        })
    }

    fn stop(&mut self) {
        let mut world = self.0.borrow_mut();
        world.loaded = None;
        world.run = None;
    }
}

struct Acquirer(Rc<RefCell<World>>);

impl Acquire for Acquirer {
    fn describe(&self) -> AcquireDescription {
        let world = self.0.borrow();
        AcquireDescription {
            name: world.bench.name(),
            kind: BenchKind::Twin,
            rate: rate(ACQUISITION_RATE_HZ),
            channels: vec![
                ("drive".into(), Drive::UNIT),
                ("acceleration".into(), Unit::MetrePerSecondSquared),
                ("normal_force".into(), Unit::Newton),
            ],
            condition: Condition {
                participant: Some(world.bench.participant.pseudonym()),
                touch: Some(Touch::Resting),
                ..Condition::default()
            },
            seed: Some(world.bench.participant.seed),
            steps: vec![world.bench.parameters.provenance()],
        }
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, BenchError> {
        let world = self.0.borrow();
        let bench = &world.bench;
        let mut accelerometer = Accelerometer::new(
            &bench.parameters.accelerometer,
            ACQUISITION_RATE_HZ,
            bench.random("accelerometer at rest"),
        );
        let mut cell = ForceCell::new(
            &bench.parameters.force_cell,
            bench.random("force cell at rest"),
        );
        let acceleration: Vec<f64> = (0..CALIBRATION).map(|_| accelerometer.read(0.0)).collect();
        let force: Vec<f64> = (0..CALIBRATION).map(|_| cell.read(0.0)).collect();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let about = |x: &[f64]| {
            let offset = mean(x);
            piezotact::series::rms(&x.iter().map(|v| v - offset).collect::<Vec<f64>>())
        };
        Ok(SensorCalibration {
            offset: vec![0.0, mean(&acceleration), mean(&force)],
            noise_rms: vec![0.0, about(&acceleration), about(&force)],
        })
    }

    fn ready(&mut self, run: &RunPlan) -> Result<(), BenchError> {
        load_possible(run)?;
        within("an angle in degrees", run.angle.0, ANGLES_DEG)?;
        self.0.borrow_mut().asked = Some(run.clone());
        Ok(())
    }

    fn start(&mut self) -> Result<(), BenchError> {
        // Acquisition starts first; the world begins with its lead when the player starts.
        match self.0.borrow().asked {
            Some(_) => Ok(()),
            None => Err(BenchError::Order {
                asked: "acquire",
                before: "made ready",
            }),
        }
    }

    fn wait(&mut self) -> Result<Option<Chunk>, BenchError> {
        let mut world = self.0.borrow_mut();
        let run = world.run.as_mut().ok_or(BenchError::Order {
            asked: "wait",
            before: "started",
        })?;
        Ok(run.next())
    }

    fn stop(&mut self) {
        self.0.borrow_mut().asked = None;
    }
}

/// The finger's answer to a voltage while the force drifts: frames of 0.2 s, half overlapping, each through
/// the transfer function that holds at its force. With a constant force this is the exact linear response.
struct VaryingResponse {
    voltage: Vec<f64>,
    finger: Finger,
    placement: Placement,
    angle_deg: f64,
    window: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Transfer functions by force, in steps of [`Self::FORCE_STEP_N`].
    known: BTreeMap<i64, Vec<Complex<f64>>>,
    next_frame: isize,
    /// Sums of frames, from output sample `emitted` on.
    pending: Vec<f64>,
    emitted: usize,
    buffer: Vec<f64>,
    bins: Vec<Complex<f64>>,
}

impl VaryingResponse {
    const FRAME: usize = 1024;
    const HOP: usize = Self::FRAME / 2;
    const LENGTH: usize = 4096;
    /// Room in front of a frame for what the smooth ripple answers early.
    const EARLY: usize = 1024;
    const FORCE_STEP_N: f64 = 0.002;

    fn new(voltage: Vec<f64>, finger: Finger, placement: Placement, angle_deg: f64) -> Self {
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(Self::LENGTH);
        Self {
            window: Window::Hann.coefficients(Self::FRAME, Symmetry::Periodic),
            inverse: planner.plan_fft_inverse(Self::LENGTH),
            bins: forward.make_output_vec(),
            forward,
            known: BTreeMap::new(),
            next_frame: -(Self::HOP as isize),
            pending: vec![0.0; Self::LENGTH],
            emitted: 0,
            buffer: vec![0.0; Self::LENGTH],
            voltage,
            finger,
            placement,
            angle_deg,
        }
    }

    /// The next `count` samples of acceleration, m/s²; `force_n` is the force at every sample of the run.
    fn take(&mut self, count: usize, force_n: &[f64]) -> Vec<f64> {
        let end = self.emitted + count;
        while self.next_frame < (end + Self::EARLY) as isize {
            self.add_frame(force_n);
        }
        let out = self.pending[..count].to_vec();
        self.pending.drain(..count);
        self.emitted = end;
        out
    }

    fn add_frame(&mut self, force_n: &[f64]) {
        let start = self.next_frame;
        self.next_frame += Self::HOP as isize;
        self.buffer.fill(0.0);
        for (i, w) in self.window.iter().enumerate() {
            let at = start + i as isize;
            if let Some(v) = usize::try_from(at).ok().and_then(|at| self.voltage.get(at)) {
                self.buffer[Self::EARLY + i] = v * w;
            }
        }
        let middle = usize::try_from(start + Self::HOP as isize)
            .unwrap_or(0)
            .min(force_n.len() - 1);
        let step = (force_n[middle] / Self::FORCE_STEP_N).round() as i64;
        let (finger, placement, angle_deg) = (&self.finger, &self.placement, self.angle_deg);
        let response = self.known.entry(step).or_insert_with(|| {
            let load_n = step as f64 * Self::FORCE_STEP_N;
            (0..=Self::LENGTH / 2)
                .map(|k| {
                    let frequency_hz = k as f64 * ACQUISITION_RATE_HZ / Self::LENGTH as f64;
                    finger.response(frequency_hz, load_n, angle_deg, placement)
                        * Complex::from_polar(1.0, -TAU * frequency_hz * LATENCY_S)
                })
                .collect()
        });
        let done = self.forward.process(&mut self.buffer, &mut self.bins);
        debug_assert!(done.is_ok());
        for (bin, h) in self.bins.iter_mut().zip(response.iter()) {
            *bin *= h / Self::LENGTH as f64;
        }
        self.bins[0].im = 0.0;
        self.bins[Self::LENGTH / 2].im = 0.0;
        let done = self.inverse.process(&mut self.bins, &mut self.buffer);
        debug_assert!(done.is_ok());
        let first = start - Self::EARLY as isize - self.emitted as isize;
        let needed = usize::try_from(first + Self::LENGTH as isize).unwrap_or(0);
        if self.pending.len() < needed {
            self.pending.resize(needed, 0.0);
        }
        for (i, value) in self.buffer.iter().enumerate() {
            if let Ok(at) = usize::try_from(first + i as isize) {
                self.pending[at] += value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the force held exactly, a long tone is answered with the transfer function at its frequency.
    #[test]
    fn a_constant_force_is_a_linear_system() {
        let frequency_hz = 212.0;
        let voltage: Vec<f64> = (0..20_000)
            .map(|i| (TAU * frequency_hz * f64::from(i) / ACQUISITION_RATE_HZ).sin())
            .collect();
        let finger = Finger::nominal();
        let mut response = VaryingResponse::new(voltage, finger.clone(), Placement::exact(), 20.0);
        let force_n = vec![0.2; 20_000];
        let mut y = Vec::new();
        for count in [700, 2500, 2500, 1, 9299] {
            y.extend(response.take(count, &force_n));
        }
        let h = finger.response(frequency_hz, 0.2, 20.0, &Placement::exact())
            * Complex::from_polar(1.0, -TAU * frequency_hz * LATENCY_S);
        let worst = (5_000..15_000)
            .map(|i| {
                let phase = TAU * frequency_hz * i as f64 / ACQUISITION_RATE_HZ;
                (y[i] - (h * Complex::from_polar(1.0, phase)).im).abs()
            })
            .fold(0.0, f64::max);
        // The response is sampled at 1.2 Hz steps: what rings longer than 0.6 s would wrap.
        assert!(worst < 1e-3 * h.norm(), "{:e}", worst / h.norm());
    }
}
