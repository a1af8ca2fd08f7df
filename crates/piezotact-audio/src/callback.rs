//! The real-time half: what the sound system's own threads run. No allocation, lock, log, formatting or file access; a test runs it under a guard
//! against allocations, and `xtask tidy` reads this file.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use piezotact_bench::StopHandle;
use rtrb::{Consumer, Producer};

use crate::board::Board;

/// The length of a pulse on the trigger channel, s.
const TRIGGER_S: f64 = 0.001;
/// Its level, full scale = 1.
const TRIGGER_LEVEL: f32 = 0.9;
/// A playback that is stopped fades out in this time, s.
const FADE_S: f64 = 0.005;

/// What the output is asked to do.
#[derive(Debug)]
pub(crate) enum Command {
    /// Plays a piece instead of what plays.
    Play(Box<Piece>),
    /// Fades out.
    Stop,
}

/// A drive on its way to the output.
#[derive(Debug)]
pub(crate) struct Piece {
    /// Its number: above that of any piece before it.
    pub(crate) number: u64,
    /// The frame of the output at which its first sample is given out.
    pub(crate) start: u64,
    /// Its samples, full scale = 1.
    pub(crate) samples: Samples,
    /// Fades it out from any thread, whatever the other half waits for.
    pub(crate) stop: StopHandle,
}

/// Where the samples of a drive come from.
#[derive(Debug)]
pub(crate) enum Samples {
    /// All of them are there.
    Whole(Vec<f32>),
    /// They are made while it plays; the flag is set when no more come.
    Made(Consumer<f32>, Arc<AtomicBool>),
}

/// The next sample of a piece.
enum Next {
    Sample(f32),
    Dry,
    End,
}

impl Piece {
    fn next(&mut self, position: usize) -> Next {
        match &mut self.samples {
            Samples::Whole(samples) => samples
                .get(position)
                .map_or(Next::End, |v| Next::Sample(*v)),
            Samples::Made(ring, complete) => {
                // Read before the ring: what was put there before the flag is found.
                let complete = complete.load(Ordering::Acquire);
                match ring.pop() {
                    Ok(sample) => Next::Sample(sample),
                    Err(_empty) if complete => Next::End,
                    Err(_empty) => Next::Dry,
                }
            }
        }
    }
}

/// Something that happened at a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happened {
    /// The first sample of a drive was given out at this frame of the output.
    Onset {
        frame: u64,
        /// The frames that the input had counted then.
        input: u64,
    },
    /// No sample of the drive was there in time, for so many frames.
    RanDry {
        /// The first frame of silence.
        frame: u64,
        frames: u64,
        /// The frames that the input had counted when it ended.
        input: u64,
    },
    /// The input lost frames before this one.
    Lost {
        /// The frame, lost ones counted.
        frame: u64,
        frames: u64,
    },
}

/// Where the drive leaves the device: channels from 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Routes {
    /// The channels of the drive.
    pub(crate) drive: Vec<usize>,
    /// The channel that pulses when a drive begins.
    pub(crate) trigger: Option<usize>,
}

/// Fills buffers of the output.
#[derive(Debug)]
pub struct OutputCallback {
    pub(crate) channels: usize,
    pub(crate) routes: Routes,
    pub(crate) commands: Consumer<Command>,
    pub(crate) home: Producer<Box<Piece>>,
    pub(crate) happened: Producer<Happened>,
    pub(crate) board: Arc<Board>,
    frame: u64,
    /// Frames of this buffer that were filled.
    within: u64,
    piece: Option<Box<Piece>>,
    position: usize,
    dry: u64,
    trigger_left: u32,
    trigger_frames: u32,
    gain: f32,
    fade: f32,
    fading: bool,
}

impl OutputCallback {
    pub(crate) fn new(
        (channels, routes): (usize, Routes),
        rate_hz: f64,
        commands: Consumer<Command>,
        home: Producer<Box<Piece>>,
        happened: Producer<Happened>,
        board: Arc<Board>,
    ) -> Self {
        Self {
            channels,
            routes,
            commands,
            home,
            happened,
            board,
            frame: 0,
            within: 0,
            piece: None,
            position: 0,
            dry: 0,
            trigger_left: 0,
            trigger_frames: (TRIGGER_S * rate_hz).ceil() as u32,
            gain: 1.0,
            fade: (1.0 / (FADE_S * rate_hz)) as f32,
            fading: false,
        }
    }

    /// The channels of a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Fills `out`, interleaved; what is no whole frame at its end is silent.
    pub fn fill(&mut self, out: &mut [f32]) {
        self.board.output_came();
        self.obey();
        out.fill(0.0);
        self.within = 0;
        for frame in out.chunks_exact_mut(self.channels.max(1)) {
            let sample = self.sample();
            for channel in &self.routes.drive {
                if let Some(out) = frame.get_mut(*channel) {
                    *out = sample;
                }
            }
            if self.trigger_left > 0 {
                self.trigger_left -= 1;
                let trigger = self
                    .routes
                    .trigger
                    .and_then(|channel| frame.get_mut(channel));
                if let Some(out) = trigger {
                    *out = TRIGGER_LEVEL;
                }
            }
            self.frame += 1;
            self.within += 1;
        }
        self.board
            .output
            .frames
            .store(self.frame, Ordering::Release);
    }

    /// Frames that the device played as silence, as it was not served in time.
    pub fn skipped(&mut self, frames: u64) {
        // Of a drive that did not begin nothing is missing.
        if self
            .piece
            .as_ref()
            .is_some_and(|piece| piece.start <= self.frame)
        {
            let _full = self.happened.push(Happened::RanDry {
                frame: self.frame,
                frames,
                input: self.board.input.frames.load(Ordering::Acquire) + frames,
            });
        }
        self.board.output.losses.fetch_add(1, Ordering::AcqRel);
    }

    fn obey(&mut self) {
        while let Ok(command) = self.commands.pop() {
            match command {
                Command::Play(mut piece) => {
                    self.send_home();
                    piece.start = piece.start.max(self.frame);
                    (self.position, self.gain, self.fading) = (0, 1.0, false);
                    self.board.played.store(0, Ordering::Release);
                    self.board.piece.store(piece.number, Ordering::Release);
                    self.piece = Some(piece);
                }
                Command::Stop => self.fading = true,
            }
        }
        let stopped = |piece: &Piece| piece.stop.is_stopped();
        self.fading |=
            self.piece.as_deref().is_some_and(stopped) || self.board.muted.load(Ordering::Acquire);
    }

    /// The next sample of what plays; 0 where nothing does.
    fn sample(&mut self) -> f32 {
        let Some(piece) = &mut self.piece else {
            return 0.0;
        };
        if self.frame < piece.start {
            if self.fading {
                self.end();
            }
            return 0.0;
        }
        let sample = match piece.next(self.position) {
            Next::Sample(sample) => sample,
            Next::Dry => {
                self.dry += 1;
                self.board.dry.fetch_add(1, Ordering::AcqRel);
                if self.fading {
                    self.end();
                }
                return 0.0;
            }
            Next::End => {
                self.end();
                return 0.0;
            }
        };
        self.say_dry();
        if self.position == 0 {
            let _full = self.happened.push(Happened::Onset {
                frame: self.frame,
                input: self.board.input.frames.load(Ordering::Acquire) + self.within,
            });
            self.trigger_left = self.trigger_frames;
        }
        self.position += 1;
        self.board
            .played
            .store(self.position as u64, Ordering::Release);
        let whole = if sample.is_finite() { sample } else { 0.0 };
        let within = whole.clamp(-1.0, 1.0);
        if within != sample {
            self.board.limited.fetch_add(1, Ordering::AcqRel);
        }
        if self.fading {
            self.gain = (self.gain - self.fade).max(0.0);
            if self.gain <= 0.0 {
                self.end();
                return 0.0;
            }
        }
        within * self.gain
    }

    /// Reports the silence that just ended.
    fn say_dry(&mut self) {
        if self.dry > 0 {
            let _full = self.happened.push(Happened::RanDry {
                frame: self.frame - self.dry,
                frames: self.dry,
                input: self.board.input.frames.load(Ordering::Acquire) + self.within,
            });
            self.dry = 0;
        }
    }

    fn end(&mut self) {
        self.say_dry();
        self.send_home();
        self.fading = false;
    }

    /// Hands a piece back, so that it is freed elsewhere.
    fn send_home(&mut self) {
        let Some(piece) = self.piece.take() else {
            return;
        };
        self.board.silent_from.store(self.frame, Ordering::Release);
        self.board.ended.store(piece.number, Ordering::Release);
        if let Err(rtrb::PushError::Full(piece)) = self.home.push(piece) {
            // The ring home holds as many as can be on their way; leaked rather than freed here.
            std::mem::forget(piece);
        }
    }
}

/// Takes buffers of the input.
#[derive(Debug)]
pub struct InputCallback {
    pub(crate) channels: usize,
    pub(crate) samples: Producer<f32>,
    pub(crate) happened: Producer<Happened>,
    pub(crate) board: Arc<Board>,
    frame: u64,
    /// Frames before this one for which there was no room.
    dropped: u64,
}

impl InputCallback {
    pub(crate) fn new(
        channels: usize,
        samples: Producer<f32>,
        happened: Producer<Happened>,
        board: Arc<Board>,
    ) -> Self {
        Self {
            channels,
            samples,
            happened,
            board,
            frame: 0,
            dropped: 0,
        }
    }

    /// The channels of a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Takes `taken`, interleaved; what is no whole frame at its end is left out. Frames for which there is no room are counted and dropped.
    pub fn take(&mut self, taken: &[f32]) {
        self.board.input_came();
        let channels = self.channels.max(1);
        let frames = taken.len() / channels;
        let whole = &taken[..frames * channels];
        match self.samples.write_chunk(whole.len()) {
            Ok(mut room) => {
                // What comes after dropped frames keeps its number.
                if self.dropped > 0 {
                    let _full = self.happened.push(Happened::Lost {
                        frame: self.frame - self.dropped,
                        frames: self.dropped,
                    });
                    self.dropped = 0;
                }
                let (first, second) = room.as_mut_slices();
                let (begin, rest) = whole.split_at(first.len());
                first.copy_from_slice(begin);
                second.copy_from_slice(rest);
                room.commit_all();
            }
            Err(_no_room) => {
                self.dropped += frames as u64;
                self.board
                    .overflowed
                    .fetch_add(frames as u64, Ordering::AcqRel);
            }
        }
        self.frame += frames as u64;
        self.board.input.frames.store(self.frame, Ordering::Release);
    }

    /// Frames that the device lost before what comes next.
    pub fn lost(&mut self, frames: u64) {
        let _full = self.happened.push(Happened::Lost {
            frame: self.frame,
            frames,
        });
        self.frame += frames;
        self.board.input.losses.fetch_add(1, Ordering::AcqRel);
        self.board.input.frames.store(self.frame, Ordering::Release);
    }
}

#[cfg(test)]
#[path = "callback_tests.rs"]
mod tests;
