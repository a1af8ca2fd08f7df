//! What is played on one half of the bench is answered on the other.

use std::cell::RefCell;
use std::rc::Rc;

use piezotact::convolve::Convolver;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Quantity};
use piezotact::recording::{BenchKind, Condition};
use piezotact::series::rms;
use piezotact::{Doubt, Series};

use super::{MeasuredBench, output_rate};
use crate::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL};
use crate::traits::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Play, PlayDescription, PlayReport,
    RunPlan, SensorCalibration,
};

/// What acquisition records before the playback starts and after it ends, s, as the twin's.
const LEAD_S: f64 = 0.2;
const REST_S: f64 = 0.3;
/// The length of a chunk, s.
const CHUNK_S: f64 = 0.5;
/// The length of a calibration at rest, s.
const CALIBRATION_S: f64 = 1.0;

/// The two halves of `bench`.
pub(super) fn halves(bench: MeasuredBench) -> Bench {
    let world = Rc::new(RefCell::new(World {
        bench,
        loaded: None,
        asked: None,
        run: None,
    }));
    Bench {
        player: Box::new(Player(Rc::clone(&world))),
        acquirer: Box::new(Acquirer(world)),
    }
}

struct World {
    bench: MeasuredBench,
    loaded: Option<Vec<f64>>,
    asked: Option<RunPlan>,
    run: Option<Run>,
}

/// One run, from the first acquired sample to the last.
struct Run {
    /// What is looped back, as it was sent.
    drive: Vec<f64>,
    /// What is left of it behind the limit, from the first sample that was not fed.
    played_through: Vec<f64>,
    fed: usize,
    device: Convolver,
    noise: Box<dyn FnMut() -> f64>,
    chunk: usize,
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
        let sent = self.loaded.take().unwrap_or_default();
        let (lead, rest) = (
            (LEAD_S * bench.rate.hz()) as usize,
            (REST_S * bench.rate.hz()) as usize,
        );
        let acquired = |samples: &[f64]| {
            let mut all = vec![0.0; lead];
            all.extend(bench.to_acquisition.process(samples));
            all.resize(all.len() + rest, 0.0);
            all
        };
        let limit = bench.limit();
        let clipped: Vec<f64> = sent.iter().map(|v| v.clamp(-limit, limit)).collect();
        let mut started = Run {
            drive: acquired(&sent),
            played_through: acquired(&clipped),
            fed: 0,
            device: Convolver::new(&bench.impulse),
            noise: Box::new(bench.noise(&format!("run {}", run.label))),
            chunk: ((CHUNK_S * bench.rate.hz()) as usize).max(1),
            at: 0,
            played: sent.len(),
        };
        // What the impulse response holds at negative times is answered early: that much is fed ahead.
        let ahead = bench.impulse.len() / 2;
        let _before_the_first_sample = started.answer(ahead);
        self.run = Some(started);
        Ok(())
    }
}

impl Run {
    /// The next `count` samples of the answer; behind its end the drive is silent.
    fn answer(&mut self, count: usize) -> Vec<f64> {
        let from = self.fed.min(self.played_through.len());
        let to = (self.fed + count).min(self.played_through.len());
        self.fed += count;
        let mut input = self.played_through[from..to].to_vec();
        input.resize(count, 0.0);
        self.device.feed(&input)
    }

    fn next(&mut self) -> Option<Chunk> {
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
        Some(Chunk {
            channels: vec![drive, acceleration],
        })
    }
}

struct Player(Rc<RefCell<World>>);

impl Play for Player {
    fn describe(&self) -> PlayDescription {
        let world = self.0.borrow();
        let setup = world.bench.function.drive.as_ref();
        PlayDescription {
            name: world.bench.name(),
            kind: BenchKind::Measured,
            rate: output_rate().unwrap_or(world.bench.rate),
            gain: setup.map(|setup| setup.gain),
        }
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, BenchError> {
        Ok(self.0.borrow().bench.function.drive.clone())
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
        let bench = &world.bench;
        AcquireDescription {
            name: bench.name(),
            kind: BenchKind::Measured,
            rate: bench.rate,
            channels: vec![
                (DRIVE_CHANNEL.into(), Drive::UNIT),
                (ACCELERATION_CHANNEL.into(), Acceleration::UNIT),
            ],
            condition: bench.function.condition.clone(),
            seed: Some(bench.noise.seed),
            steps: vec![
                format!(
                    "played through {}: {} lines, an impulse response of {} samples at {}, nothing outside {}, clipped at a drive of {:.3}",
                    bench.through(),
                    bench.function.response().len(),
                    bench.impulse.len(),
                    bench.rate,
                    bench.answers,
                    bench.limit()
                ),
                format!(
                    "white noise of {} m/s² rms added, ChaCha8",
                    bench.noise.rms_m_s2
                ),
            ],
        }
    }

    fn condition(&self, _run: &RunPlan) -> Condition {
        self.0.borrow().bench.function.condition.clone()
    }

    fn doubts(&self, _run: &RunPlan) -> Vec<Doubt> {
        let world = self.0.borrow();
        let bench = &world.bench;
        let mut doubts = vec![Doubt::Rehearsed {
            through: bench.through(),
            answers_hz: bench.answers,
            own_doubts: bench.function.doubts.len(),
        }];
        let Condition {
            load_n, angle_deg, ..
        } = bench.function.condition;
        let unknown = match (load_n, angle_deg) {
            (None, None) => Some("load and angle"),
            (None, Some(_)) => Some("load"),
            (Some(_), None) => Some("angle"),
            (Some(_), Some(_)) => None,
        };
        doubts.extend(unknown.map(|what| Doubt::Guessed {
            what: format!(
                "{} does not say the {what} at which it was measured: whatever was asked for, none is recorded",
                bench.called
            ),
        }));
        if bench.function.drive.is_none() {
            doubts.push(Doubt::DeviceNotDescribed);
        }
        doubts
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, BenchError> {
        let world = self.0.borrow();
        let mut noise = world.bench.noise("at rest");
        let samples = (CALIBRATION_S * world.bench.rate.hz()) as usize;
        let at_rest: Vec<f64> = (0..samples).map(|_| noise()).collect();
        let offset = piezotact::series::mean(&at_rest);
        let about: Vec<f64> = at_rest.iter().map(|v| v - offset).collect();
        Ok(SensorCalibration {
            offset: vec![0.0, offset],
            noise_rms: vec![0.0, rms(&about)],
        })
    }

    fn ready(&mut self, run: &RunPlan) -> Result<(), BenchError> {
        let mut world = self.0.borrow_mut();
        world.bench.possible(run)?;
        world.asked = Some(run.clone());
        Ok(())
    }

    fn start(&mut self) -> Result<(), BenchError> {
        // Acquisition starts first; the run begins with its lead when the player starts.
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
