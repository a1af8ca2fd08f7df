//! What stores the runs of a procedure.

use piezotact::recording::{BenchKind, Recording, StartTime};
use piezotact::run::{Discard, RunStart, Sink, SinkError};

/// Stores the runs of a procedure, and finds runs stored before.
pub trait RunKeeper {
    /// The time of day at which a run on a bench of this kind begins, as its recording states it; `None` where it states none.
    fn now(&self, _kind: BenchKind) -> Option<StartTime> {
        None
    }
    /// The stored recording of a run with this start that an interrupted procedure completed: it is used instead of a new
    /// measurement.
    ///
    /// # Errors
    /// Any error of the store.
    fn completed(&mut self, _start: &RunStart) -> Result<Option<Recording>, SinkError> {
        Ok(None)
    }
    /// The sink for the documents of the run that begins with `start`.
    ///
    /// # Errors
    /// Whatever keeps it from beginning.
    fn sink(&mut self, start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError>;
}

/// Stores nothing.
impl RunKeeper for Discard {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Self))
    }
}
