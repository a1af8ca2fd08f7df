//! A simulated bench that takes as long as a real one.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use piezotact::Doubt;
use piezotact::quantity::Seconds;
use piezotact::recording::{Condition, Event};
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::RunPlan;
use crate::stop::StopHandle;
use crate::traits::{Acquire, AcquireDescription, Bench, SensorCalibration};

/// The longest piece in which samples come, s.
const PIECE_S: f64 = 0.05;

/// An acquiring half whose samples come when their time has come: twenty pieces a second. On a bench that takes its time by itself it
/// only cuts chunks into pieces.
pub struct Paced {
    inner: Box<dyn Acquire>,
    /// How many seconds of the bench pass in a second.
    speed: f64,
    stop: StopHandle,
    began: Instant,
    pieces: VecDeque<RunChunk>,
}

impl std::fmt::Debug for Paced {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Paced")
            .field("inner", &self.inner.describe())
            .field("speed", &self.speed)
            .finish_non_exhaustive()
    }
}

impl Paced {
    /// `inner` at the pace of its own clock.
    #[must_use]
    pub fn real_time(inner: Box<dyn Acquire>) -> Self {
        Self::at(inner, 1.0)
    }

    /// `inner` at `speed` times the pace of its own clock, above 0.
    #[must_use]
    pub fn at(inner: Box<dyn Acquire>, speed: f64) -> Self {
        Self {
            inner,
            speed,
            stop: StopHandle::new(),
            began: Instant::now(),
            pieces: VecDeque::new(),
        }
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

    fn doubts(&self, run: &RunPlan) -> Vec<Doubt> {
        self.inner.doubts(run)
    }

    fn events(&mut self) -> Vec<Event> {
        self.inner.events()
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        self.inner.calibrate()
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        self.stop = stop.clone();
        self.pieces.clear();
        self.inner.ready(run, stop)
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.began = Instant::now();
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
        let end_s = (piece.first as f64 + piece.len() as f64) / rate_hz / self.speed;
        let passes = Duration::try_from_secs_f64(end_s).unwrap_or(Duration::MAX);
        match self.stop.wait(passes.saturating_sub(self.began.elapsed())) {
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

impl Bench {
    /// The same bench, which takes as long as a real one: see [`Paced`].
    #[must_use]
    pub fn in_real_time(self) -> Self {
        Self {
            acquirer: Box::new(Paced::real_time(self.acquirer)),
            ..self
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
