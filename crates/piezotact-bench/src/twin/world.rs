//! The world behind the two halves of the twin: what is played on one is felt and measured on the other.

use std::cell::RefCell;
use std::f64::consts::TAU;
use std::rc::Rc;

use num_complex::Complex;
use piezotact::Series;
use piezotact::device::{AmplifierGain, DriveSetup};
use piezotact::quantity::{Drive, Hertz, Quantity, SampleRate, Unit};
use piezotact::recording::{BenchKind, Condition, Touch};
use piezotact::resample::Resampler;

use super::RATE_HZ;
use super::finger::{Finger, Placement};
use super::output::OutputStage;
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::protocol::{ANGLES_DEG, load_possible, within};
use super::sensors::{Accelerometer, ForceCell, HeldForce, at_rest};
use super::session::{CALIBRATION, CHUNK, rate as acquisition_rate};
use super::varying::{AtLoad, VaryingResponse};
use crate::random::Random;
use crate::traits::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Play, PlayDescription, PlayReport,
    RunPlan, SensorCalibration,
};

/// The rate of the sound output, Hz.
const OUTPUT_RATE_HZ: f64 = 48_000.0;
/// The passband of the acquisition's anti-alias filter, Hz.
const PASSBAND: Hertz = Hertz(2200.0);
/// What acquisition records before the playback starts and after it ends, s.
const LEAD_S: f64 = 0.2;
const REST_S: f64 = 0.3;

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
        self.participant.random(name)
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
    response: VaryingResponse<PressedDevice>,
    accelerometer: Accelerometer,
    cell: ForceCell,
    at: usize,
    played: usize,
}

/// The device with a finger on it, from the actuator's voltage to the nail's acceleration.
struct PressedDevice {
    finger: Finger,
    placement: Placement,
    angle_deg: f64,
    latency_s: f64,
}

impl AtLoad for PressedDevice {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.finger
            .response(frequency_hz, load_n, self.angle_deg, &self.placement)
            * Complex::from_polar(1.0, -TAU * frequency_hz * self.latency_s)
    }
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
        let to_acquisition = Resampler::new(rate(OUTPUT_RATE_HZ), rate(RATE_HZ), PASSBAND)
            .map_err(|error| BenchError::Impossible {
                expected: "rates that go together".into(),
                found: error.to_string(),
                todo: "report this".into(),
            })?;
        let voltage = bench.output.voltage(
            &played,
            rate(OUTPUT_RATE_HZ),
            &mut bench.random(&format!("output {}", run.label)),
        );
        let lead = (LEAD_S * RATE_HZ) as usize;
        let acquired = |samples: &[f64]| {
            let mut all = vec![0.0; lead];
            all.extend(to_acquisition.process(samples));
            all.resize(all.len() + (REST_S * RATE_HZ) as usize, 0.0);
            all
        };
        let (drive, voltage) = (acquired(&played), acquired(&voltage));
        let mut held = HeldForce::new(
            &bench.parameters.hand,
            run.load.map_or(0.0, |load| load.0),
            RATE_HZ,
            bench.random(&format!("force {}", run.label)),
        );
        let force_n: Vec<f64> = drive.iter().map(|_| held.next()).collect();
        let person = &bench.participant;
        let mut response = VaryingResponse::new(PressedDevice {
            finger: person.finger.clone(),
            placement: Placement::of(
                &bench.parameters,
                person.number,
                person.seed,
                run.put_down_for(),
            ),
            angle_deg: run.angle.0,
            latency_s: bench.parameters.actuator.latency_s,
        });
        response.feed(&voltage, &force_n);
        self.run = Some(Run {
            response,
            accelerometer: Accelerometer::new(
                &bench.parameters.accelerometer,
                RATE_HZ,
                bench.random(&format!("accelerometer {}", run.label)),
            )
            .calibrated(bench.participant.seed),
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
        let acceleration = self.response.take(end - self.at);
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
            gain: Some(world.bench.output.setup().gain),
        }
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, BenchError> {
        Ok(Some(self.0.borrow().bench.output.setup().clone()))
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
            rate: acquisition_rate(),
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
            RATE_HZ,
            bench.random("accelerometer at rest"),
        );
        let mut cell = ForceCell::new(
            &bench.parameters.force_cell,
            bench.random("force cell at rest"),
        );
        let acceleration: Vec<f64> = (0..CALIBRATION).map(|_| accelerometer.read(0.0)).collect();
        let force: Vec<f64> = (0..CALIBRATION).map(|_| cell.read(0.0)).collect();
        Ok(at_rest(&[vec![0.0], acceleration, force]))
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
