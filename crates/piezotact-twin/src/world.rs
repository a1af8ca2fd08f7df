//! The simulation between the two halves of the twin: device, finger and sensors.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use num_complex::Complex;
use piezotact::device::{DeviceAtGain, DriveSetup};
use piezotact::quantity::{Drive, Hertz, Quantity, SampleRate, Unit};
use piezotact::recording::{BenchKind, Condition, Touch};
use piezotact::resample::Resampler;

use super::RATE_HZ;
use super::finger::{Finger, Placement};
use super::output::OutputStage;
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::protocol::{ANGLES_DEG, load_possible, within};
use super::sensors::{Accelerometer, ForceCell, SlowHand, at_rest};
use super::session::{CALIBRATION, CHUNK, rate as acquisition_rate};
use super::varying::{LoadDependent, VaryingResponse};
use piezotact_bench::halves::{Run, SimulatedBench, halves};
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL, FORCE_CHANNEL};
use piezotact_bench::random::Random;
use piezotact_bench::{
    AcquireDescription, Bench, DeviceError, PlayDescription, RunPlan, SensorCalibration,
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
    /// The bench with the finger of `participant` on the device with the settings `set`.
    #[must_use]
    pub fn new(parameters: &TwinParameters, participant: Participant, set: &DeviceAtGain) -> Self {
        Self {
            output: OutputStage::new(&parameters.output, set),
            parameters: parameters.clone(),
            participant,
        }
    }

    /// Its two halves.
    #[must_use]
    pub fn into_bench(self) -> Bench {
        halves(self)
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

/// One run: everything that happens from the first acquired sample to the last.
struct Pressed {
    drive: Vec<f64>,
    force_n: Vec<f64>,
    response: VaryingResponse<PressedDevice>,
    accelerometer: Accelerometer,
    cell: ForceCell,
    at: usize,
}

/// The device with a finger on it, from the actuator's voltage to the nail's acceleration.
struct PressedDevice {
    finger: Finger,
    placement: Placement,
    angle_deg: f64,
    latency_s: f64,
}

impl LoadDependent for PressedDevice {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.finger
            .response(frequency_hz, load_n, self.angle_deg, &self.placement)
            * Complex::from_polar(1.0, -TAU * frequency_hz * self.latency_s)
    }
}

/// From the rate of the output to that of the acquisition, planned once: a plan takes as long as several seconds of signal.
fn to_acquisition() -> Result<&'static Resampler, DeviceError> {
    static PLAN: OnceLock<Result<Resampler, String>> = OnceLock::new();
    let plan = PLAN.get_or_init(|| {
        Resampler::new(rate(OUTPUT_RATE_HZ), rate(RATE_HZ), PASSBAND)
            .map_err(|error| error.to_string())
    });
    plan.as_ref().map_err(|found| DeviceError::Impossible {
        expected: "rates that go together".into(),
        found: found.clone(),
        todo: "report this".into(),
    })
}

impl SimulatedBench for TwinBench {
    fn output(&self) -> PlayDescription {
        PlayDescription {
            name: self.name(),
            kind: BenchKind::Twin,
            rate: rate(OUTPUT_RATE_HZ),
            gain: Some(self.output.setup().gain.name.clone()),
        }
    }

    fn input(&self) -> AcquireDescription {
        AcquireDescription {
            answers_with: None,
            name: self.name(),
            kind: BenchKind::Twin,
            rate: acquisition_rate(),
            channels: vec![
                (DRIVE_CHANNEL.into(), Drive::UNIT),
                (ACCELERATION_CHANNEL.into(), Unit::MetrePerSecondSquared),
                (FORCE_CHANNEL.into(), Unit::Newton),
            ],
            condition: Condition {
                participant: Some(self.participant.pseudonym()),
                twin_seed: Some(self.participant.seed),
                touch: Some(Touch::Resting),
                ..Condition::default()
            },
            seed: Some(self.participant.seed),
            steps: vec![self.parameters.provenance()],
        }
    }

    fn setup(&self) -> Option<DriveSetup> {
        Some(self.output.setup().clone())
    }

    fn at_rest(&self) -> SensorCalibration {
        let mut accelerometer = Accelerometer::new(
            &self.parameters.accelerometer,
            RATE_HZ,
            self.random("accelerometer at rest"),
        );
        let mut cell = ForceCell::new(
            &self.parameters.force_cell,
            RATE_HZ,
            self.random("force cell at rest"),
        );
        let acceleration: Vec<f64> = (0..CALIBRATION).map(|_| accelerometer.read(0.0)).collect();
        let force: Vec<f64> = (0..CALIBRATION).map(|_| cell.read(0.0)).collect();
        at_rest(&[vec![0.0], acceleration, force])
    }

    fn possible(&self, run: &RunPlan) -> Result<(), DeviceError> {
        load_possible(run)?;
        within("an angle in degrees", run.angle.0, ANGLES_DEG)
    }

    fn lead_s(&self) -> f64 {
        LEAD_S
    }

    fn begin(&self, played: &[f64], run: &RunPlan) -> Result<Box<dyn Run>, DeviceError> {
        let to_acquisition = to_acquisition()?;
        let voltage = self.output.voltage(
            played,
            rate(OUTPUT_RATE_HZ),
            &mut self.random(&format!("output {}", run.label)),
        );
        let lead = (LEAD_S * RATE_HZ) as usize;
        let acquired = |samples: &[f64]| {
            let mut all = vec![0.0; lead];
            all.extend(to_acquisition.process(samples));
            all.resize(all.len() + (REST_S * RATE_HZ) as usize, 0.0);
            all
        };
        let (drive, voltage) = (acquired(played), acquired(&voltage));
        let mut held = SlowHand::new(
            &self.parameters.hand,
            run.load.map_or(0.0, |load| load.0),
            RATE_HZ,
            self.random(&format!("force {}", run.label)),
        );
        let force_n: Vec<f64> = drive.iter().map(|_| held.next()).collect();
        let person = &self.participant;
        let mut response = VaryingResponse::new(PressedDevice {
            finger: person.finger.clone(),
            placement: Placement::of(
                &self.parameters,
                person.number,
                person.seed,
                run.placed_for(),
            ),
            angle_deg: run.angle.0,
            latency_s: self.parameters.actuator.latency_s,
        });
        response.feed(&voltage, &force_n);
        Ok(Box::new(Pressed {
            response,
            accelerometer: Accelerometer::new(
                &self.parameters.accelerometer,
                RATE_HZ,
                self.random(&format!("accelerometer {}", run.label)),
            )
            .calibrated(self.participant.seed),
            cell: ForceCell::new(
                &self.parameters.force_cell,
                RATE_HZ,
                self.random(&format!("force cell {}", run.label)),
            ),
            drive,
            force_n,
            at: 0,
        }))
    }
}

impl Run for Pressed {
    fn next_channels(&mut self) -> Option<Vec<Vec<f64>>> {
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
        Some(channels)
    }
}
