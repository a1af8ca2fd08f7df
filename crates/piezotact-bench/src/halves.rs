//! The two halves of a bench behind which something computes the answer: what is played on one is acquired on the other.

use std::cell::RefCell;
use std::rc::Rc;

use piezotact::device::DriveSetup;
use piezotact::quantity::Drive;
use piezotact::recording::Condition;
use piezotact::{Doubt, Series};

use crate::traits::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Play, PlayDescription, PlayReport,
    RunPlan, SensorCalibration,
};

/// What stands between the halves.
pub trait World {
    /// See [`Play::describe`].
    fn output(&self) -> PlayDescription;
    /// See [`Acquire::describe`].
    fn input(&self) -> AcquireDescription;
    /// See [`Play::calibrate`].
    fn setup(&self) -> Option<DriveSetup>;
    /// See [`Acquire::calibrate`].
    fn at_rest(&self) -> SensorCalibration;
    /// Refuses a run that cannot be.
    fn possible(&self, run: &RunPlan) -> Result<(), BenchError>;
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
    /// What follows from `drive`, at the rate of the output, for `run`.
    fn begin(&self, drive: &[f64], run: &RunPlan) -> Result<Box<dyn Run>, BenchError>;
}

/// A run that is under way.
pub trait Run: Send {
    /// What is acquired next; `None` at the end.
    fn next(&mut self) -> Option<Chunk>;
}

/// The halves of a bench with `world` behind them.
pub fn halves<W: World + 'static>(world: W) -> Bench {
    let shared = Rc::new(RefCell::new(Shared {
        world,
        loaded: None,
        asked: None,
        run: None,
        played: 0,
    }));
    Bench {
        player: Box::new(Player(Rc::clone(&shared))),
        acquirer: Box::new(Acquirer(shared)),
    }
}

struct Shared<W: World> {
    world: W,
    loaded: Option<Vec<f64>>,
    asked: Option<RunPlan>,
    run: Option<Box<dyn Run>>,
    played: usize,
}

struct Player<W: World>(Rc<RefCell<Shared<W>>>);

impl<W: World> Play for Player<W> {
    fn describe(&self) -> PlayDescription {
        self.0.borrow().world.output()
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, BenchError> {
        Ok(self.0.borrow().world.setup())
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
        let mut shared = self.0.borrow_mut();
        let drive = shared.loaded.take().ok_or(BenchError::Order {
            asked: "play",
            before: "made ready",
        })?;
        let run = shared.asked.as_ref().ok_or(BenchError::Order {
            asked: "start",
            before: "made ready",
        })?;
        let run = shared.world.begin(&drive, run)?;
        shared.run = Some(run);
        shared.played = drive.len();
        Ok(())
    }

    fn wait(&mut self) -> Result<PlayReport, BenchError> {
        let shared = self.0.borrow();
        match shared.run {
            Some(_) => Ok(PlayReport {
                played: shared.played,
                underruns: 0,
            }),
            None => Err(BenchError::Order {
                asked: "wait",
                before: "started",
            }),
        }
    }

    fn stop(&mut self) {
        let mut shared = self.0.borrow_mut();
        shared.loaded = None;
        shared.run = None;
    }
}

struct Acquirer<W: World>(Rc<RefCell<Shared<W>>>);

impl<W: World> Acquire for Acquirer<W> {
    fn describe(&self) -> AcquireDescription {
        self.0.borrow().world.input()
    }

    fn condition(&self, run: &RunPlan) -> Condition {
        self.0.borrow().world.condition(run)
    }

    fn doubts(&self, _run: &RunPlan) -> Vec<Doubt> {
        self.0.borrow().world.doubts()
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, BenchError> {
        Ok(self.0.borrow().world.at_rest())
    }

    fn ready(&mut self, run: &RunPlan) -> Result<(), BenchError> {
        let mut shared = self.0.borrow_mut();
        shared.world.possible(run)?;
        shared.asked = Some(run.clone());
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
        let mut shared = self.0.borrow_mut();
        let run = shared.run.as_mut().ok_or(BenchError::Order {
            asked: "wait",
            before: "started",
        })?;
        Ok(run.next())
    }

    fn stop(&mut self) {
        self.0.borrow_mut().asked = None;
    }
}
