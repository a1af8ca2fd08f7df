//! The two halves of a bench behind which something computes the answer: what is played on one is acquired on the other.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::recording::Condition;
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::{Playback, RunPlan};
use crate::stop::StopHandle;
use crate::traits::{
    Acquire, AcquireDescription, Bench, Play, PlayDescription, PlayProgress, SensorCalibration,
};

/// What stands between the halves.
pub trait World: Send {
    /// See [`Play::describe`].
    fn output(&self) -> PlayDescription;
    /// See [`Acquire::describe`].
    fn input(&self) -> AcquireDescription;
    /// See [`Play::calibrate`].
    fn setup(&self) -> Option<DriveSetup>;
    /// See [`Acquire::calibrate`].
    fn at_rest(&self) -> SensorCalibration;
    /// Refuses a run that cannot be.
    fn possible(&self, run: &RunPlan) -> Result<(), DeviceError>;
    /// See [`Acquire::condition`].
    fn condition(&self, run: &RunPlan) -> Condition {
        Condition {
            load_n: run.load,
            angle_deg: Some(run.angle),
            ..self.input().condition
        }
    }
    /// See [`Acquire::doubts`].
    fn doubts(&self) -> Vec<Doubt> {
        Vec::new()
    }
    /// What is acquired before the playback begins, s.
    fn lead_s(&self) -> f64;
    /// What follows from `drive`, at the rate of the output, for `run`.
    fn begin(&self, drive: &[f64], run: &RunPlan) -> Result<Box<dyn Run>, DeviceError>;
}

/// A run that is under way.
pub trait Run: Send {
    /// What is acquired next, a list of samples for each channel; `None` at the end.
    fn next_channels(&mut self) -> Option<Vec<Vec<f64>>>;
}

/// The halves of a bench with `world` behind them. Time is that of the acquired samples: nothing is played that was not
/// acquired.
pub fn halves<W: World + 'static>(world: W) -> Bench {
    let shared = Arc::new(Mutex::new(Shared {
        world,
        loaded: None,
        planned: None,
        under_way: None,
    }));
    Bench::new(
        Box::new(Player(Arc::clone(&shared))),
        Box::new(Acquirer(shared)),
    )
}

/// The finger between the halves.
struct Shared<W> {
    world: W,
    loaded: Option<Vec<f64>>,
    planned: Option<(RunPlan, StopHandle)>,
    under_way: Option<UnderWay>,
}

struct UnderWay {
    run: Box<dyn Run>,
    stop: StopHandle,
    /// The samples of the drive.
    drive: u64,
    acquired: u64,
    over: bool,
}

fn locked<W>(shared: &Mutex<Shared<W>>) -> MutexGuard<'_, Shared<W>> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Player<W>(Arc<Mutex<Shared<W>>>);

impl<W: World> Play for Player<W> {
    fn describe(&self) -> PlayDescription {
        locked(&self.0).world.output()
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        Ok(locked(&self.0).world.setup())
    }

    fn ready(
        &mut self,
        playback: Playback,
        run: &RunPlan,
        _stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        let description = self.describe();
        if playback.rate() != description.rate {
            return Err(DeviceError::Rate {
                drive: playback.rate(),
                output: description.rate,
                name: description.name,
            });
        }
        locked(&self.0).loaded = Some(playback.collected(run.until));
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let shared = &mut *locked(&self.0);
        let drive = shared.loaded.take().ok_or(DeviceError::Order {
            asked: "play",
            before: "made ready",
        })?;
        let (plan, stop) = shared.planned.as_ref().ok_or(DeviceError::Order {
            asked: "start",
            before: "made ready",
        })?;
        shared.under_way = Some(UnderWay {
            run: shared.world.begin(&drive, plan)?,
            stop: stop.clone(),
            drive: drive.len() as u64,
            acquired: 0,
            over: false,
        });
        Ok(())
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        let shared = locked(&self.0);
        let run = shared.under_way.as_ref().ok_or(DeviceError::Order {
            asked: "say how far it is",
            before: "started",
        })?;
        let acquired_s = run.acquired as f64 / shared.world.input().rate.hz();
        let played_s = (acquired_s - shared.world.lead_s()).max(0.0);
        let played = (played_s * shared.world.output().rate.hz()).round() as u64;
        let played = played.min(run.drive);
        Ok(PlayProgress {
            played,
            underruns: 0,
            ended: run.over || played == run.drive,
        })
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.loaded = None;
        shared.under_way = None;
    }
}

struct Acquirer<W>(Arc<Mutex<Shared<W>>>);

impl<W: World> Acquire for Acquirer<W> {
    fn describe(&self) -> AcquireDescription {
        locked(&self.0).world.input()
    }

    fn condition(&self, run: &RunPlan) -> Condition {
        locked(&self.0).world.condition(run)
    }

    fn doubts(&self, _run: &RunPlan) -> Vec<Doubt> {
        locked(&self.0).world.doubts()
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        Ok(locked(&self.0).world.at_rest())
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        shared.world.possible(run)?;
        shared.planned = Some((run.clone(), stop.clone()));
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        // Acquisition starts first; the run begins with its lead when the player starts.
        match locked(&self.0).planned {
            Some(_) => Ok(()),
            None => Err(DeviceError::Order {
                asked: "acquire",
                before: "made ready",
            }),
        }
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        let shared = &mut *locked(&self.0);
        let rate_hz = shared.world.input().rate.hz();
        let run = shared.under_way.as_mut().ok_or(DeviceError::Order {
            asked: "wait",
            before: "started",
        })?;
        let channels = match run.stop.is_stopped() {
            true => None,
            false => run.run.next_channels(),
        };
        let Some(channels) = channels else {
            run.over = true;
            return Ok(None);
        };
        let chunk = RunChunk {
            first: run.acquired,
            device_s: Some(run.acquired as f64 / rate_hz),
            lost: 0,
            channels,
        };
        run.acquired += chunk.len() as u64;
        Ok(Some(chunk))
    }

    fn stop(&mut self) {
        locked(&self.0).planned = None;
    }
}
