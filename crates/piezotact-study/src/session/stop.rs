//! Stopping what a session plays, from any thread.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use piezotact_bench::StopHandle;

/// What is said of a trial that the end of the program cut.
const ENDED: &str = "the program was ended while it was played";

/// Stops what a session plays: from a page, from a signal, from whatever watches over it. It needs no turn of the session. All clones
/// stop the same session.
#[derive(Clone, Debug, Default)]
pub struct PlayStop {
    for_good: StopHandle,
    state: Arc<Mutex<Stops>>,
}

#[derive(Debug, Default)]
struct Stops {
    /// How often it was asked to stop, with the last reason.
    asked: u64,
    last: String,
    /// How often that was when what comes next was asked for.
    known: Option<u64>,
    now: Option<Now>,
    /// What records a touch.
    touch: Option<StopHandle>,
}

/// A trial that is being played.
#[derive(Debug)]
struct Now {
    stop: StopHandle,
    why: Option<String>,
}

impl PlayStop {
    /// Stops what is played now, because of `why`, which is journalled; the first reason counts. Gives whether anything was played.
    pub fn stop(&self, why: &str) -> bool {
        let mut state = self.state();
        state.asked += 1;
        why.clone_into(&mut state.last);
        if let Some(touch) = state.touch.take() {
            touch.stop();
        }
        let Some(now) = state.now.as_mut() else {
            return false;
        };
        now.why.get_or_insert_with(|| why.to_owned());
        now.stop.stop();
        true
    }

    /// How often it was asked to stop until now.
    #[must_use]
    pub fn asked(&self) -> u64 {
        self.state().asked
    }

    /// What is played next was asked for when there had been so many stops: one that came since ends it before its first sound.
    pub fn plays_after(&self, asked: u64) {
        self.state().known = Some(asked);
    }

    /// Whether a trial is being played.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.state().now.is_some()
    }

    /// The handle that stops what is played now, and whatever would be played after it: for the end of the program.
    #[must_use]
    pub fn for_good(&self) -> &StopHandle {
        &self.for_good
    }

    /// The handle of a touch that is recorded from now on: it ends with every stop.
    pub(crate) fn touch(&self) -> StopHandle {
        let stop = self.for_good.child();
        self.state().touch = Some(stop.clone());
        stop
    }

    /// A trial is played from now on, until what is given here is dropped.
    pub(crate) fn begin(&self) -> Playing<'_> {
        let stop = self.for_good.child();
        let mut state = self.state();
        let late = state.known.take().is_some_and(|known| known != state.asked);
        let why = late.then(|| state.last.clone());
        if late {
            stop.stop();
        }
        state.now = Some(Now {
            stop: stop.clone(),
            why,
        });
        drop(state);
        Playing { of: self, stop }
    }

    fn state(&self) -> MutexGuard<'_, Stops> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A trial that is played.
#[derive(Debug)]
pub(crate) struct Playing<'a> {
    of: &'a PlayStop,
    pub(crate) stop: StopHandle,
}

impl Playing<'_> {
    /// Why it was stopped; none where it was not.
    pub(crate) fn stopped(&self) -> Option<String> {
        if !self.stop.is_stopped() {
            return None;
        }
        let why = self.of.state().now.as_ref().and_then(|now| now.why.clone());
        Some(why.unwrap_or_else(|| ENDED.to_owned()))
    }
}

impl Drop for Playing<'_> {
    fn drop(&mut self) {
        self.of.state().now = None;
    }
}
