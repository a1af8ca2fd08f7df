//! A simulated bench that takes as long as a real one.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::quantity::Seconds;
use piezotact::recording::{Condition, Event};
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::{Playback, RunPlan};
use crate::stop::StopHandle;
use crate::traits::{
    Acquire, AcquireDescription, Bench, Play, PlayDescription, PlayProgress, SensorCalibration,
};

/// The longest piece in which samples come, s.
const PIECE_S: f64 = 0.05;

/// An acquiring half whose samples come when their time has come: twenty pieces a second. On a bench that takes its time by itself it
/// only cuts chunks into pieces.
pub struct Paced {
    inner: Box<dyn Acquire>,
    clock: Arc<Mutex<Clock>>,
    pieces: VecDeque<RunChunk>,
}

/// The clock of a bench that takes its time.
struct Clock {
    /// How many seconds of the bench pass in a second.
    speed: f64,
    stop: StopHandle,
    /// When the run began; none before.
    began: Option<Instant>,
}

impl Clock {
    /// The time of the bench at `now`, s.
    fn at(&self, now: Instant) -> Seconds {
        let began = self.began.unwrap_or(now);
        Seconds(now.saturating_duration_since(began).as_secs_f64() * self.speed)
    }

    /// When it will be `time_s` by this clock.
    fn comes_in(&self, time_s: f64) -> Duration {
        let passes = Duration::try_from_secs_f64(time_s / self.speed).unwrap_or(Duration::MAX);
        let began = self.began.unwrap_or_else(Instant::now);
        passes.saturating_sub(began.elapsed())
    }
}

fn locked(clock: &Mutex<Clock>) -> MutexGuard<'_, Clock> {
    clock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl std::fmt::Debug for Paced {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Paced")
            .field("inner", &self.inner.describe())
            .finish_non_exhaustive()
    }
}

impl Paced {
    /// `inner` at the pace of its own clock.
    #[must_use]
    pub fn real_time(inner: Box<dyn Acquire>) -> Self {
        Self::at(inner, 1.0)
    }

    /// `inner` at `speed` times the pace of its own clock.
    fn at(inner: Box<dyn Acquire>, speed: f64) -> Self {
        let clock = Clock {
            speed,
            stop: StopHandle::new(),
            began: None,
        };
        Self {
            inner,
            clock: Arc::new(Mutex::new(clock)),
            pieces: VecDeque::new(),
        }
    }

    /// The half as it was.
    #[must_use]
    pub fn into_inner(self) -> Box<dyn Acquire> {
        self.inner
    }

    /// The next piece; none at the end of the run.
    fn next_piece(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        if self.pieces.is_empty()
            && let Some(chunk) = self.inner.next_chunk()?
        {
            let rate_hz = self.inner.describe().rate.hz();
            self.pieces = pieces(chunk, rate_hz);
        }
        Ok(self.pieces.pop_front())
    }
}

/// `chunk` in pieces of at most [`PIECE_S`]; a chunk without samples stays as it is.
fn pieces(chunk: RunChunk, rate_hz: f64) -> VecDeque<RunChunk> {
    let most = ((rate_hz * PIECE_S) as usize).max(1);
    if chunk.len() <= most {
        return VecDeque::from([chunk]);
    }
    let begins = (0..chunk.len()).step_by(most);
    let piece = |begin: usize| {
        let of = |samples: &Vec<f64>| {
            let end = samples.len().min(begin + most);
            samples[begin.min(end)..end].to_vec()
        };
        RunChunk {
            first: chunk.first + begin as u64,
            device_s: chunk.device_s.map(|at_s| at_s + begin as f64 / rate_hz),
            lost: if begin == 0 { chunk.lost } else { 0 },
            clock: chunk.clock,
            channels: chunk.channels.iter().map(of).collect(),
        }
    };
    begins.map(piece).collect()
}

impl Acquire for Paced {
    fn describe(&self) -> AcquireDescription {
        self.inner.describe()
    }

    fn condition(&self, run: &RunPlan) -> Condition {
        self.inner.condition(run)
    }

    fn warnings(&self, run: &RunPlan) -> Vec<Warning> {
        self.inner.warnings(run)
    }

    fn events(&mut self) -> Vec<Event> {
        self.inner.events()
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        self.inner.calibrate()
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        locked(&self.clock).stop = stop.clone();
        self.pieces.clear();
        self.inner.ready(run, stop)
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        locked(&self.clock).began = Some(Instant::now());
        self.inner.start()
    }

    fn longest_pause(&self) -> Seconds {
        self.inner.longest_pause()
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        let Some(piece) = self.next_piece()? else {
            return Ok(None);
        };
        let rate_hz = self.inner.describe().rate.hz();
        let end_s = (piece.first as f64 + piece.len() as f64) / rate_hz;
        let (comes_in, stop) = {
            let clock = locked(&self.clock);
            (clock.comes_in(end_s), clock.stop.clone())
        };
        match stop.wait(comes_in) {
            // What has not come yet does not come any more.
            true => Ok(None),
            false => Ok(Some(piece)),
        }
    }

    fn playback_ended(&mut self) {
        self.inner.playback_ended();
    }

    fn stop(&mut self) {
        self.pieces.clear();
        self.inner.stop();
    }
}

/// The playing half beside a [`Paced`] one: a stop ends its output at the time of the stop by the clock of the bench, whoever acquires then.
struct PacedPlayer {
    inner: Box<dyn Play>,
    clock: Arc<Mutex<Clock>>,
    /// How far it was when it was stopped.
    ended: Option<PlayProgress>,
}

impl PacedPlayer {
    /// How far an output is that ends at `now`.
    fn ends(&mut self, now: Instant) -> Result<PlayProgress, DeviceError> {
        let at = locked(&self.clock).at(now);
        let progress = self.inner.progress_after(at)?;
        Ok(PlayProgress {
            ended: true,
            ..progress
        })
    }
}

impl Play for PacedPlayer {
    fn describe(&self) -> PlayDescription {
        self.inner.describe()
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        self.inner.calibrate()
    }

    fn ready(
        &mut self,
        playback: Playback,
        run: &RunPlan,
        stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        self.inner.ready(playback, run, stop)
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.ended = None;
        self.inner.start()
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        if let Some(ended) = self.ended {
            return Ok(ended);
        }
        let stopped_at = locked(&self.clock).stop.stopped_at();
        match stopped_at {
            Some(at) => self.ends(at),
            None => self.inner.progress(),
        }
    }

    fn stop(&mut self) {
        if self.ended.is_none() {
            let stopped_at = locked(&self.clock).stop.stopped_at();
            self.ended = self.ends(stopped_at.unwrap_or_else(Instant::now)).ok();
        }
        self.inner.stop();
    }
}

impl Bench {
    /// The same bench, which takes as long as a real one: see [`Paced`].
    #[must_use]
    pub fn in_real_time(self) -> Self {
        self.at_speed(1.0)
    }

    /// The same bench at `speed` times the pace of its own clock, above 0.
    #[must_use]
    pub fn at_speed(self, speed: f64) -> Self {
        let acquirer = Paced::at(self.acquirer, speed);
        let player = PacedPlayer {
            inner: self.player,
            clock: Arc::clone(&acquirer.clock),
            ended: None,
        };
        Self {
            player: Box::new(player),
            acquirer: Box::new(acquirer),
            stop: self.stop,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_the_chunk_again() {
        let channels = vec![(0..1234).map(f64::from).collect::<Vec<_>>(); 2];
        let chunk = RunChunk {
            first: 500,
            device_s: Some(2.0),
            lost: 3,
            clock: 0,
            channels: channels.clone(),
        };
        let cut = pieces(chunk, 5000.0);
        assert_eq!(cut.len(), 5);
        assert_eq!((cut[0].lost, cut[1].lost), (3, 0));
        assert_eq!((cut[1].first, cut[1].device_s), (750, Some(2.05)));
        let joined: Vec<f64> = cut
            .iter()
            .flat_map(|piece| piece.channels[1].clone())
            .collect();
        assert_eq!(joined, channels[1]);
    }
}
