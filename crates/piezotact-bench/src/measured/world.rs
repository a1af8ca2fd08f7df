//! The simulation of a measured bench: the response to the played drive, run by run.

use piezotact::Warning;
use piezotact::convolve::Convolver;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Quantity};
use piezotact::recording::{BenchKind, Condition, RecordingWarning, Simulated};
use piezotact::render::RenderWarning;
use piezotact::statistics::rms;

use super::{MeasuredBench, output_rate};
use crate::error::DeviceError;
use crate::halves::{Run, SimulatedBench};
use crate::plan::RunPlan;
use crate::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL};
use crate::traits::{AcquireDescription, PlayDescription, SensorCalibration};

/// What acquisition records before the playback starts and after it ends, s, as the twin's.
const LEAD_S: f64 = 0.2;
const REST_S: f64 = 0.3;
/// The length of a chunk, s.
const CHUNK_S: f64 = 0.5;
/// The length of a calibration at rest, s.
const CALIBRATION_S: f64 = 1.0;

/// One run, from the first acquired sample to the last.
struct Rehearsal {
    /// What is looped back, as it was sent.
    drive: Vec<f64>,
    /// The drive after the output limit, from the first sample that has not been filtered yet.
    played_through: Vec<f64>,
    fed: usize,
    device: Convolver,
    noise: Box<dyn FnMut() -> f64 + Send>,
    chunk: usize,
    at: usize,
}

impl SimulatedBench for MeasuredBench {
    fn output(&self) -> PlayDescription {
        PlayDescription {
            name: self.name(),
            kind: BenchKind::Measured,
            rate: output_rate().unwrap_or(self.rate),
            gain: self.setup().map(|setup| setup.gain.name.clone()),
        }
    }

    fn input(&self) -> AcquireDescription {
        AcquireDescription {
            name: self.name(),
            kind: BenchKind::Measured,
            rate: self.rate,
            channels: vec![
                (DRIVE_CHANNEL.into(), Drive::UNIT),
                (ACCELERATION_CHANNEL.into(), Acceleration::UNIT),
            ],
            condition: self.function.about.condition.clone(),
            seed: Some(self.noise.seed),
            answers_with: Some(self.function.checksum()),
            steps: vec![
                format!(
                    "played through {}: {} lines, an impulse response of {} samples at {}, nothing outside {}, clipped at a drive of {:.3}",
                    self.through(),
                    self.function.response().len(),
                    self.impulse.len(),
                    self.rate,
                    self.answers,
                    self.limit()
                ),
                format!(
                    "white noise of {} m/s² rms added, ChaCha8",
                    self.noise.rms_m_s2
                ),
            ],
        }
    }

    fn setup(&self) -> Option<DriveSetup> {
        self.function.drive.clone()
    }

    fn at_rest(&self) -> SensorCalibration {
        let mut noise = self.noise("at rest");
        let samples = (CALIBRATION_S * self.rate.hz()) as usize;
        let at_rest: Vec<f64> = (0..samples).map(|_| noise()).collect();
        let offset = piezotact::statistics::mean(&at_rest);
        let about: Vec<f64> = at_rest.iter().map(|v| v - offset).collect();
        SensorCalibration {
            offset: vec![0.0, offset],
            noise_rms: vec![0.0, rms(&about)],
        }
    }

    fn possible(&self, run: &RunPlan) -> Result<(), DeviceError> {
        self.answers_as(run)
    }

    fn condition(&self, _run: &RunPlan) -> Condition {
        self.function.about.condition.clone()
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = vec![Warning::from(RecordingWarning::Simulated {
            by: Simulated::Transfer {
                through: self.through(),
                answers_hz: self.answers,
                own_warnings: self.function.about.warnings.len(),
            },
        })];
        let Condition {
            load_n, angle_deg, ..
        } = self.function.about.condition;
        let unknown = match (load_n, angle_deg) {
            (None, None) => Some("load and angle"),
            (None, Some(_)) => Some("load"),
            (Some(_), None) => Some("angle"),
            (Some(_), Some(_)) => None,
        };
        warnings.extend(unknown.map(|what| Warning::from(RecordingWarning::Guessed {
            what: format!(
                "{} does not state the {what} at which it was measured: no value is recorded, even if one was requested",
                self.called
            ),
        })));
        if self.function.drive.is_none() {
            warnings.push(Warning::from(RenderWarning::DeviceNotDescribed));
        }
        warnings
    }

    fn lead_s(&self) -> f64 {
        LEAD_S
    }

    fn begin(&self, sent: &[f64], run: &RunPlan) -> Result<Box<dyn Run>, DeviceError> {
        let (lead, rest) = (
            (LEAD_S * self.rate.hz()) as usize,
            (REST_S * self.rate.hz()) as usize,
        );
        let acquired = |samples: &[f64]| {
            let mut all = vec![0.0; lead];
            all.extend(self.to_acquisition.process(samples));
            all.resize(all.len() + rest, 0.0);
            all
        };
        let limit = self.limit();
        let clipped: Vec<f64> = sent.iter().map(|v| v.clamp(-limit, limit)).collect();
        let mut started = Rehearsal {
            drive: acquired(sent),
            played_through: acquired(&clipped),
            fed: 0,
            device: Convolver::new(&self.impulse),
            noise: Box::new(self.noise(&format!("run {}", run.label))),
            chunk: ((CHUNK_S * self.rate.hz()) as usize).max(1),
            at: 0,
        };
        // The impulse response has a part at negative times: that many samples are fed ahead.
        let ahead = self.impulse.len() / 2;
        let _before_the_first_sample = started.answer(ahead);
        Ok(Box::new(started))
    }
}

impl Rehearsal {
    /// The next `count` samples of the response; after its end the drive is silent.
    fn answer(&mut self, count: usize) -> Vec<f64> {
        let from = self.fed.min(self.played_through.len());
        let to = (self.fed + count).min(self.played_through.len());
        self.fed += count;
        let mut input = self.played_through[from..to].to_vec();
        input.resize(count, 0.0);
        self.device.feed(&input)
    }
}

impl Run for Rehearsal {
    fn next_channels(&mut self) -> Option<Vec<Vec<f64>>> {
        let end = (self.at + self.chunk).min(self.drive.len());
        if self.at == end {
            return None;
        }
        let mut acceleration = self.answer(end - self.at);
        for sample in &mut acceleration {
            *sample += (self.noise)();
        }
        let drive = self.drive[self.at..end].to_vec();
        self.at = end;
        Some(vec![drive, acceleration])
    }
}
