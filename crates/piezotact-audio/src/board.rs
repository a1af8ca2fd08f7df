//! The numbers that the real-time half leaves for the other: counters alone.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What both halves see of running streams. Written by the callbacks, read by everything else; all of it is lock-free.
#[derive(Debug)]
pub struct Board {
    epoch: Instant,
    pub output: Side,
    pub input: Side,
    /// The number of the piece that plays or played last, and of the one that has ended; 0 before the first.
    pub(crate) piece: AtomicU64,
    pub(crate) ended: AtomicU64,
    /// The frame of the output at which that one was over: silence from there on, up to the next piece.
    pub silent_from: AtomicU64,
    /// Frames of the piece that plays that were given out.
    pub(crate) played: AtomicU64,
    /// Frames of silence where the drive came too late.
    pub(crate) dry: AtomicU64,
    /// Samples of the drive beyond full scale, or no numbers.
    pub(crate) limited: AtomicU64,
    /// The output is to be silent until it is opened again.
    pub(crate) muted: AtomicBool,
    /// Frames of the input that nobody fetched in time.
    pub(crate) overflowed: AtomicU64,
}

/// One direction of running streams.
#[derive(Debug, Default)]
pub struct Side {
    /// Frames since the streams were opened, lost ones counted.
    pub frames: AtomicU64,
    /// When the first and the last callback came, ns after the streams were opened.
    first_ns: AtomicU64,
    last_ns: AtomicU64,
    /// The longest time between two callbacks, ns.
    longest_ns: AtomicU64,
    /// How often the system reported lost or late samples.
    pub losses: AtomicU64,
    /// Whether the device is gone.
    pub gone: AtomicBool,
}

impl Side {
    /// Notes that a callback came at `now_ns`.
    fn came(&self, now_ns: u64) {
        let before = self.last_ns.swap(now_ns.max(1), Ordering::AcqRel);
        if before > 0 {
            let pause = now_ns.saturating_sub(before);
            self.longest_ns.fetch_max(pause, Ordering::AcqRel);
        } else {
            self.first_ns.store(now_ns.max(1), Ordering::Release);
        }
    }

    /// Frames per second by the clock of this computer between the first callback and the last one, with the time between them, s.
    pub(crate) fn effective_hz(&self) -> (f64, f64) {
        // The frames of the last callback may be counted or not: one buffer in many.
        let frames = self.frames.load(Ordering::Acquire);
        let last_ns = self.last_ns.load(Ordering::Acquire);
        let ran_s = last_ns.saturating_sub(self.first_ns.load(Ordering::Acquire)) as f64 * 1e-9;
        (frames as f64 / ran_s.max(1e-9), ran_s)
    }

    /// The longest pause between callbacks since this was last asked.
    pub(crate) fn take_longest_pause(&self) -> Duration {
        Duration::from_nanos(self.longest_ns.swap(0, Ordering::AcqRel))
    }
}

impl Board {
    /// A board for streams that are opened now.
    #[must_use]
    pub fn new() -> Self {
        Self {
            epoch: Instant::now(),
            output: Side::default(),
            input: Side::default(),
            piece: AtomicU64::new(0),
            ended: AtomicU64::new(0),
            silent_from: AtomicU64::new(0),
            played: AtomicU64::new(0),
            dry: AtomicU64::new(0),
            limited: AtomicU64::new(0),
            muted: AtomicBool::new(false),
            overflowed: AtomicU64::new(0),
        }
    }

    fn now_ns(&self) -> u64 {
        u64::try_from(self.epoch.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    /// Notes a callback of the output.
    pub(crate) fn output_came(&self) {
        self.output.came(self.now_ns());
    }

    /// Notes a callback of the input.
    pub(crate) fn input_came(&self) {
        self.input.came(self.now_ns());
    }

    /// How long ago the last callback of `side` came; none before the first.
    pub(crate) fn since_callback(&self, side: &Side) -> Option<Duration> {
        match side.last_ns.load(Ordering::Acquire) {
            0 => None,
            last => Some(Duration::from_nanos(self.now_ns().saturating_sub(last))),
        }
    }

    /// How long the streams are open.
    pub(crate) fn age(&self) -> Duration {
        self.epoch.elapsed()
    }
}

impl Default for Board {
    fn default() -> Self {
        Self::new()
    }
}
