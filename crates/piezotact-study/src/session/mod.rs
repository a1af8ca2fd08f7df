//! One runner of sessions with volunteers: state machine, store and bench joined.
//!
//! A front end shows [`Runner::state`] and gives commands; it decides nothing. Every event is stored first and then taken up, so that
//! what is shown as done can no longer be lost. Time and entropy come from outside ([`Outside`]).

mod bench;
mod runner;
mod stop;
mod touch;
mod touching;

pub use bench::{BenchStimulator, JournalOf, PreparedDrive};
pub use piezotact_bench::StopHandle;
pub use runner::{Given, Outside, RunError, Runner, Stimuli, events_of, state_of};
pub use stop::PlayStop;
pub use touch::{KeeperOf, TouchBench, TouchKeeper};

use piezotact_people::campaign::session::{Evidence, TouchRecording};

/// Which playing of a stimulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Played<'a> {
    pub trial: &'a str,
    /// Which attempt at the trial, from 1.
    pub attempt: u32,
    /// The element of the trial, from 0.
    pub element: usize,
    /// Which playing of the element in this attempt, from 1.
    pub play: u32,
    pub stimulus: &'a str,
}

/// Why the recording of a touch ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchEnd {
    /// The touch is over.
    Done,
    /// It was cut: by a pause, a stop, or the end of the program.
    Cut,
}

/// What was recorded of a touch, or of a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heard {
    /// None where not one sample was recorded.
    pub recording: Option<TouchRecording>,
    /// The strokes in it; none where neither force nor motion was recorded.
    pub strokes: Option<u32>,
    /// Why it was not recorded, or not to its end.
    pub failed: Option<String>,
}

/// Something that plays rendered stimuli on a finger and says what was measured while it did.
pub trait Stimulator {
    /// Checks that `stimulus` can be played, before the first stimulus of a trial is.
    ///
    /// # Errors
    /// [`RunError::NoDrive`], [`RunError::TooLong`].
    fn check(&self, stimulus: &str) -> Result<(), RunError>;

    /// Plays `played` as the protocol says; `stop` ends it at any time.
    ///
    /// # Errors
    /// [`RunError`].
    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError>;

    /// Begins to record how the real sample of a trial is touched, and comes back while that goes on; `touched.play` is the part of the
    /// touch, from 1. `stop` ends it at any time. Gives whether there are sensors.
    ///
    /// # Errors
    /// Why it is not recorded; the trial goes on.
    fn listen(&mut self, _touched: Played<'_>, _stop: &StopHandle) -> Result<bool, String> {
        Ok(false)
    }

    /// The strokes in what is being recorded; none where nothing is, or neither force nor motion.
    fn strokes(&self) -> Option<u32> {
        None
    }

    /// Ends what is being recorded, and gives it, where anything is.
    fn heard(&mut self, _end: TouchEnd) -> Option<Heard> {
        None
    }
}
