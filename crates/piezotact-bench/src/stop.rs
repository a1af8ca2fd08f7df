//! Stopping a run from outside.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

/// Stops a run on a bench from another thread or from an interrupt (Ctrl-C), even while the bench waits.
///
/// All clones stop the same runs. A stop is final: a bench that is to run again gets a new handle.
#[derive(Clone, Debug, Default)]
pub struct StopHandle(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    stopped: Mutex<bool>,
    changed: Condvar,
    children: Mutex<Vec<Weak<Self>>>,
}

impl StopHandle {
    /// A handle that has not stopped anything.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops the run, and wakes all threads that wait with this handle.
    pub fn stop(&self) {
        *self
            .0
            .stopped
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
        for child in self.children().iter().filter_map(Weak::upgrade) {
            Self(child).stop();
        }
    }

    /// A handle for one run of several: stopped by this handle too, but stopping nothing else.
    #[must_use]
    pub fn child(&self) -> Self {
        let child = Self::new();
        let mut children = self.children();
        children.retain(|child| child.strong_count() > 0);
        children.push(Arc::downgrade(&child.0));
        drop(children);
        if self.is_stopped() {
            child.stop();
        }
        child
    }

    fn children(&self) -> MutexGuard<'_, Vec<Weak<Inner>>> {
        self.0
            .children
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether it was stopped.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        *self
            .0
            .stopped
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for `duration` or until it is stopped; returns whether it was stopped.
    #[must_use]
    pub fn wait(&self, duration: Duration) -> bool {
        let stopped = self
            .0
            .stopped
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let waited = self
            .0
            .changed
            .wait_timeout_while(stopped, duration, |stopped| !*stopped);
        *waited.unwrap_or_else(PoisonError::into_inner).0
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
        let [first, second] = [handle.child(), handle.child()];
        first.stop();
        assert!(!handle.is_stopped() && !second.is_stopped());
        handle.stop();
        assert!(second.is_stopped() && handle.child().is_stopped());
    }
}
