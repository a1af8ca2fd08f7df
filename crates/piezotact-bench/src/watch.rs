//! Ends a run whose device delivers no more samples.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use piezotact::quantity::Seconds;

use crate::error::DeviceError;
use crate::stop::StopHandle;

/// A device that delivers no samples for longer than this is lost: 5 s plus twice the longest chunk.
pub const LONGEST_PAUSE: Seconds = Seconds(7.0);
/// What loses more than this at once, or in a run that plays in all, is no measurement: what is lost is filled in on straight lines.
/// A system that recovers loses some buffers, 0.1 s each at most; a computer that does not keep up loses seconds.
pub const MOST_LOST: Seconds = Seconds(2.0);
/// The number of parts in which the pause is waited for, so that a computer that is suspended for a while costs only one of them.
const PARTS: u32 = 10;

/// Watches one run: it stops it where no samples come for too long.
#[derive(Debug)]
pub(crate) struct Watch {
    /// Ends the run: with the handle it was made from, or where nothing comes.
    pub(crate) stop: StopHandle,
    longest: Seconds,
    came: AtomicBool,
    busy: AtomicBool,
    silent: AtomicBool,
}

impl Watch {
    /// A watch over a run that `stop` ends, and a pause of more than `longest`.
    pub(crate) fn new(stop: &StopHandle, longest: Seconds) -> Self {
        Self {
            stop: stop.child(),
            longest,
            came: AtomicBool::new(false),
            busy: AtomicBool::new(false),
            silent: AtomicBool::new(false),
        }
    }

    /// Does what acquires, under watch; the run is over then.
    pub(crate) fn during<T>(&self, acquires: impl FnOnce() -> T) -> T {
        std::thread::scope(|scope| {
            // If no thread can be started, the run is not watched.
            let _unwatched = std::thread::Builder::new().spawn_scoped(scope, || self.watch());
            let _over = Over(&self.stop);
            acquires()
        })
    }

    /// Handles received samples: the time this takes does not count as a pause of the device.
    pub(crate) fn handle<T>(&self, handles: impl FnOnce() -> T) -> T {
        self.busy.store(true, Ordering::SeqCst);
        let handled = handles();
        self.came.store(true, Ordering::SeqCst);
        self.busy.store(false, Ordering::SeqCst);
        handled
    }

    /// Returns an error after too long a pause of the device `name`, which had delivered samples for `after_s`.
    pub(crate) fn answers(&self, name: &str, after_s: f64) -> Result<(), DeviceError> {
        if !self.silent.load(Ordering::SeqCst) {
            return Ok(());
        }
        Err(DeviceError::Silent {
            name: name.into(),
            pause_s: self.longest.0,
            after_s,
        })
    }

    fn watch(&self) {
        let part = Duration::from_secs_f64(self.longest.0).div_f64(f64::from(PARTS));
        let mut empty = 0;
        while !self.stop.wait(part) {
            let came = self.came.swap(false, Ordering::SeqCst);
            empty = match came || self.busy.load(Ordering::SeqCst) {
                true => 0,
                false => empty + 1,
            };
            if empty >= PARTS {
                self.silent.store(true, Ordering::SeqCst);
                self.stop.stop();
            }
        }
    }
}

/// Ends the watch, also where what acquires panics.
struct Over<'a>(&'a StopHandle);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}
