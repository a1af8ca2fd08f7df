//! The two halves of a simulated bench: a world computes the response to the signal played on one half, and the other acquires
//! it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::quantity::Seconds;
use piezotact::recording::Condition;
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::{Placement, Playback, RunPlan, Until};
use crate::stop::StopHandle;
use crate::traits::{
    Acquire, AcquireDescription, Bench, Play, PlayDescription, PlayProgress, SensorCalibration,
};

/// The simulated system between the two halves: drive in, acquired channels out.
pub trait SimulatedBench: Send {
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
    /// See [`Acquire::warnings`].
    fn warnings(&self) -> Vec<Warning> {
        Vec::new()
    }
    /// The time acquired before the playback begins, s.
    fn lead_s(&self) -> f64;
    /// The simulation of `run` with `drive`, which is at the rate of the output.
    fn begin(&self, drive: &[f64], run: &RunPlan) -> Result<Box<dyn Run>, DeviceError>;
}

/// A simulated run in progress.
pub trait Run: Send {
    /// The next acquired samples, one list per channel; `None` at the end.
    fn next_channels(&mut self) -> Option<Vec<Vec<f64>>>;
}

/// The length of a block of rest after the drive, in a run until it is stopped, s.
const REST_AT_A_TIME_S: f64 = 5.0;

/// The halves of a bench simulated by `world`. Time is counted in acquired samples: playback advances only as samples are
/// acquired. A run of a stated duration, or until it is stopped, continues in silence after the drive.
pub fn halves<W: SimulatedBench + 'static>(world: W) -> Bench {
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

/// The state shared by the two halves.
struct Shared<W> {
    world: W,
    loaded: Option<Vec<f64>>,
    planned: Option<(RunPlan, StopHandle)>,
    under_way: Option<UnderWay>,
}

impl<W: SimulatedBench> Shared<W> {
    /// How far the player is when `acquired_s` of the run has passed.
    fn progress_after(&self, acquired_s: f64) -> Result<PlayProgress, DeviceError> {
        let run = self.under_way.as_ref().filter(|run| run.run.is_some());
        let run = run.ok_or(before("say how far it is", "started"))?;
        let played_s = (acquired_s - self.world.lead_s()).max(0.0);
        let played = (played_s * self.world.output().rate.hz()).round() as u64;
        let played = played.min(run.drive);
        Ok(PlayProgress {
            played,
            underruns: 0,
            ended: run.over || played == run.drive,
        })
    }
}

struct UnderWay {
    plan: RunPlan,
    stop: StopHandle,
    /// What is acquired next; none before the player starts.
    run: Option<Box<dyn Run>>,
    /// The samples of the drive.
    drive: u64,
    acquired: u64,
    /// The number of blocks of rest after the drive.
    rests: usize,
    over: bool,
    acquiring: bool,
}

impl UnderWay {
    /// The next chunk's channels; `None` when the run is over.
    fn next_channels(
        &mut self,
        world: &dyn SimulatedBench,
    ) -> Result<Option<Vec<Vec<f64>>>, DeviceError> {
        let wanted = match self.plan.until {
            Until::Duration(duration) => Some(world.input().rate.samples_in(duration) as u64),
            Until::PlaybackEnded | Until::Stopped => None,
        };
        let left = wanted.map(|wanted| wanted.saturating_sub(self.acquired) as usize);
        if self.stop.is_stopped() || self.over || left == Some(0) {
            return Ok(None);
        }
        let run = match &mut self.run {
            Some(run) => run,
            // Nothing plays in this run.
            None => self.run.insert(begun(world, Vec::new(), &self.plan)?),
        };
        let mut next = run.next_channels();
        if next.is_none() && self.plan.until != Until::PlaybackEnded {
            self.rests += 1;
            let rest = RunPlan {
                label: format!("{}, rest {}", self.plan.label, self.rests),
                placement: Placement::SameAs(self.plan.placed_for().into()),
                ..self.plan.clone()
            };
            let silence = world.output().rate.samples_in(Seconds(REST_AT_A_TIME_S));
            let run = self.run.insert(world.begin(&vec![0.0; silence], &rest)?);
            next = run.next_channels();
        }
        if let (Some(channels), Some(left)) = (&mut next, left) {
            for channel in channels {
                channel.truncate(left);
            }
        }
        Ok(next)
    }
}

/// The run of `drive`, in silence up to the duration of `plan`.
fn begun(
    world: &dyn SimulatedBench,
    mut drive: Vec<f64>,
    plan: &RunPlan,
) -> Result<Box<dyn Run>, DeviceError> {
    if let Until::Duration(duration) = plan.until {
        let lasts = world.output().rate.samples_in(duration);
        drive.resize(drive.len().max(lasts), 0.0);
    }
    world.begin(&drive, plan)
}

fn locked<W>(shared: &Mutex<Shared<W>>) -> MutexGuard<'_, Shared<W>> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn before(asked: &'static str, before: &'static str) -> DeviceError {
    DeviceError::Order { asked, before }
}

struct Player<W>(Arc<Mutex<Shared<W>>>);

impl<W: SimulatedBench> Play for Player<W> {
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
        locked(&self.0).loaded = Some(playback.collected(run.until)?);
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let shared = &mut *locked(&self.0);
        let drive = shared.loaded.take().ok_or(before("play", "made ready"))?;
        let run = shared.under_way.as_mut().filter(|run| run.acquiring);
        let run = run.ok_or(before("play", "acquiring"))?;
        run.drive = drive.len() as u64;
        run.run = Some(begun(&shared.world, drive, &run.plan)?);
        Ok(())
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        let shared = locked(&self.0);
        let acquired = shared.under_way.as_ref().map_or(0, |run| run.acquired);
        shared.progress_after(acquired as f64 / shared.world.input().rate.hz())
    }

    fn progress_after(&mut self, acquired: Seconds) -> Result<PlayProgress, DeviceError> {
        locked(&self.0).progress_after(acquired.0)
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.loaded = None;
        // The response to the whole drive was already computed: if the playback ends early, the run must end too.
        if let Some(run) = &mut shared.under_way {
            run.over |= run.run.is_some();
        }
    }
}

struct Acquirer<W>(Arc<Mutex<Shared<W>>>);

impl<W: SimulatedBench> Acquire for Acquirer<W> {
    fn describe(&self) -> AcquireDescription {
        locked(&self.0).world.input()
    }

    fn condition(&self, run: &RunPlan) -> Condition {
        locked(&self.0).world.condition(run)
    }

    fn warnings(&self, _run: &RunPlan) -> Vec<Warning> {
        locked(&self.0).world.warnings()
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
        let shared = &mut *locked(&self.0);
        let planned = shared.planned.take();
        let (plan, stop) = planned.ok_or(before("acquire", "made ready"))?;
        // The run begins with its lead when the player starts.
        shared.under_way = Some(UnderWay {
            plan,
            stop,
            run: None,
            drive: 0,
            acquired: 0,
            rests: 0,
            over: false,
            acquiring: true,
        });
        Ok(())
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        let shared = &mut *locked(&self.0);
        let rate_hz = shared.world.input().rate.hz();
        let run = shared.under_way.as_mut().filter(|run| run.acquiring);
        let run = run.ok_or(before("wait", "started"))?;
        if run.run.is_none() && shared.loaded.is_some() && !run.stop.is_stopped() {
            return Err(before("wait", "told to play what is ready"));
        }
        let Some(channels) = run.next_channels(&shared.world)? else {
            run.over = true;
            return Ok(None);
        };
        let chunk = RunChunk {
            first: run.acquired,
            device_s: Some(run.acquired as f64 / rate_hz),
            channels,
            ..RunChunk::default()
        };
        run.acquired += chunk.len() as u64;
        Ok(Some(chunk))
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.planned = None;
        if let Some(run) = &mut shared.under_way {
            (run.over, run.acquiring) = (true, false);
        }
    }
}
