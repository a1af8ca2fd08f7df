//! Stopping a run from outside.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Stops a run on a bench from another thread or from an interrupt (Ctrl-C), even while the bench waits.
///
/// All clones stop the same runs. A stop is final: a bench that is to run again gets a new handle.
#[derive(Clone, Debug, Default)]
pub struct StopHandle(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    /// When it was stopped. It is read without waiting.
    stopped: OnceLock<Instant>,
    /// Held while that changes, and by whoever waits for it.
    changes: Mutex<()>,
    changed: Condvar,
    children: Mutex<Vec<Weak<Self>>>,
    /// Kept, so that a stop goes through it also where nobody else has it.
    _parent: Option<StopHandle>,
}

impl StopHandle {
    /// A handle that has not stopped anything.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops the run, and wakes all threads that wait with this handle.
    pub fn stop(&self) {
        self.stop_at(Instant::now());
    }

    fn stop_at(&self, now: Instant) {
        let changes = self.changes();
        // The first stop counts.
        let _stopped_before = self.0.stopped.set(now);
        drop(changes);
        self.0.changed.notify_all();
        for child in self.children().iter().filter_map(Weak::upgrade) {
            Self(child).stop_at(now);
        }
    }

    /// A handle for one run of several: stopped by this handle too, but stopping nothing else.
    #[must_use]
    pub fn child(&self) -> Self {
        let child = Self(Arc::new(Inner {
            _parent: Some(self.clone()),
            ..Inner::default()
        }));
        let mut children = self.children();
        children.retain(|child| child.strong_count() > 0);
        children.push(Arc::downgrade(&child.0));
        drop(children);
        if let Some(at) = self.stopped_at() {
            child.stop_at(at);
        }
        child
    }

    fn changes(&self) -> MutexGuard<'_, ()> {
        let changes = self.0.changes.lock();
        changes.unwrap_or_else(PoisonError::into_inner)
    }

    fn children(&self) -> MutexGuard<'_, Vec<Weak<Inner>>> {
        self.0
            .children
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether it was stopped. It never waits for another thread, so that the callback of a sound device may ask.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stopped_at().is_some()
    }

    /// When it was stopped, or the handle that it is a child of; none before. It does not wait either.
    pub(crate) fn stopped_at(&self) -> Option<Instant> {
        self.0.stopped.get().copied()
    }

    /// Waits for `duration` or until it is stopped; returns whether it was stopped.
    #[must_use]
    pub fn wait(&self, duration: Duration) -> bool {
        let waited = self
            .0
            .changed
            .wait_timeout_while(self.changes(), duration, |()| !self.is_stopped());
        drop(waited);
        self.is_stopped()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_from_another_thread_wakes_whoever_waits() {
        let handle = StopHandle::new();
        assert!(!handle.wait(Duration::from_millis(1)));
        let other = handle.clone();
        let thread = std::thread::spawn(move || other.stop());
        assert!(handle.wait(Duration::from_secs(60)));
        thread.join().unwrap();
        assert!(handle.is_stopped());
    }

    #[test]
    fn a_child_is_stopped_with_its_parent_and_not_the_other_way_round() {
        let handle = StopHandle::new();
        let [first, second] = [handle.child(), handle.child().child()];
        first.stop();
        assert!(!handle.is_stopped() && !second.is_stopped());
        handle.stop();
        assert!(second.is_stopped() && handle.child().is_stopped());
        // All at one time, which a second stop does not change.
        handle.stop();
        assert_eq!(second.stopped_at(), handle.child().child().stopped_at());
        assert!(first.stopped_at() < second.stopped_at());
    }
}
