//! The control half of running streams: loads drives, starts and stops them, fetches what was recorded, and watches over the device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use piezotact::quantity::{SampleRate, Seconds};
use piezotact_bench::{DeviceError, DriveSource, Playback, RunPlan, StopHandle};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::board::Board;
use crate::callback::{Command, Happened, InputCallback, OutputCallback, Piece, Routes, Samples};
use crate::error::AudioError;
use crate::io::{AudioIo, StreamPlan, Streams};

/// The commands, pieces and happenings that can be on their way.
const COMMANDS: usize = 64;
const HAPPENINGS: usize = 4_096;
/// The room for recorded samples that were not fetched, s.
const INPUT_S: f64 = 8.0;
/// The room for samples of a drive that is made while it plays, s.
const MADE_S: f64 = 2.0;
/// A pause of the callbacks after which the output is silenced, s, and after which the device is lost, s; both longer for large buffers.
const SILENCED_AFTER_S: f64 = 0.08;
const LOST_AFTER_S: f64 = 0.25;
/// The same in buffers.
const SILENCED_AFTER_BUFFERS: f64 = 3.0;
const LOST_AFTER_BUFFERS: f64 = 12.0;
/// How often the watchdog looks.
const LOOKS: Duration = Duration::from_millis(10);
/// A device that has not called back within this time of its opening is lost.
const FIRST_CALLBACK: Duration = Duration::from_secs(5);
/// A sound server that sets up its connections may pause so long in the first part of a stream.
const SETTLES: Duration = Duration::from_millis(1500);
/// How long a wait for samples lasts at most.
const WAITS: Duration = Duration::from_millis(5);
/// The rate is judged once so much was recorded, s, with this tolerance, as a share.
const RATE_AFTER_S: f64 = 4.0;
const RATE_TOLERANCE: f64 = 0.02;
/// A pause may shift the count of frames by so much, s.
const RATE_SLACK_S: f64 = 0.6;

/// Recorded frames, by channel, with what was lost before them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fetched {
    /// The number of the first frame since the streams were opened, lost ones counted.
    pub first: u64,
    /// Frames that were lost before it.
    pub lost: u64,
    /// Samples by channel, full scale = 1.
    pub channels: Vec<Vec<f32>>,
}

/// Streams that run, and the device behind them.
pub struct RunningStreams {
    name: String,
    rate: SampleRate,
    buffer_frames: u32,
    input_channels: usize,
    board: Arc<Board>,
    // Closed first: no callback runs after it.
    streams: Box<dyn Streams>,
    _watchdog: Option<Watchdog>,
    commands: Producer<Command>,
    home: Consumer<Box<Piece>>,
    output_happened: Consumer<Happened>,
    input_happened: Consumer<Happened>,
    samples: Consumer<f32>,
    /// A loss that was reported and not reached yet.
    loss: Option<(u64, u64)>,
    fetched: u64,
    maker: Option<Maker>,
    pieces: u64,
    happened: Vec<Happened>,
}

impl std::fmt::Debug for RunningStreams {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RunningStreams")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// Makes a drive while it plays.
struct Maker {
    source: Box<dyn DriveSource>,
    ring: Producer<f32>,
    complete: Arc<AtomicBool>,
}

impl Maker {
    fn top_up(&mut self) {
        let room = self.ring.slots();
        if room == 0 || self.complete.load(Ordering::Acquire) {
            return;
        }
        let made = self.source.next_samples(room);
        let ended = made.len() < room;
        for sample in made {
            let _full = self.ring.push(sample as f32);
        }
        if ended {
            self.complete.store(true, Ordering::Release);
        }
    }
}

/// A drive that is ready to start.
pub struct Loaded {
    samples: Samples,
    maker: Option<Maker>,
    stop: StopHandle,
}

impl std::fmt::Debug for Loaded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Loaded").finish_non_exhaustive()
    }
}

impl Loaded {
    /// The drive of `playback`, which `stop` fades out at any time.
    #[must_use]
    pub fn of(playback: Playback, stop: &StopHandle) -> Self {
        let stop = stop.clone();
        match playback {
            Playback::Whole(drive) => Self {
                samples: Samples::Whole(drive.samples().iter().map(|v| *v as f32).collect()),
                maker: None,
                stop,
            },
            Playback::Made(source) => {
                let room = source.rate().samples_in(Seconds(MADE_S)).max(1);
                let (ring, samples) = RingBuffer::new(room);
                let complete = Arc::new(AtomicBool::new(false));
                let mut maker = Maker {
                    source,
                    ring,
                    complete: Arc::clone(&complete),
                };
                maker.top_up();
                Self {
                    samples: Samples::Made(samples, complete),
                    maker: Some(maker),
                    stop,
                }
            }
        }
    }
}

/// How far a drive is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PieceProgress {
    /// Its samples that were given out.
    pub played: u64,
    /// Whether it has ended.
    pub ended: bool,
}

/// The channels of streams: how many leave the device, which carry the drive, which the trigger, how many come in. Channels from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamChannels {
    pub output: usize,
    /// Those of the drive.
    pub drive: Vec<usize>,
    /// That of the trigger.
    pub trigger: Option<usize>,
    pub input: usize,
}

/// The two callbacks of streams that are not opened yet, with the ends of their rings.
pub(crate) struct Halves {
    pub(crate) output: OutputCallback,
    pub(crate) input: InputCallback,
    pub(crate) board: Arc<Board>,
    pub(crate) commands: Producer<Command>,
    pub(crate) home: Consumer<Box<Piece>>,
    output_happened: Consumer<Happened>,
    input_happened: Consumer<Happened>,
    pub(crate) samples: Consumer<f32>,
}

impl Halves {
    pub(crate) fn new(rate: SampleRate, channels: &StreamChannels) -> Self {
        let board = Arc::new(Board::new());
        let (commands, obeyed) = RingBuffer::new(COMMANDS);
        let (sent_home, home) = RingBuffer::new(2 * COMMANDS);
        let (say_output, output_happened) = RingBuffer::new(HAPPENINGS);
        let (say_input, input_happened) = RingBuffer::new(HAPPENINGS);
        let room = rate.samples_in(Seconds(INPUT_S)).max(1) * channels.input.max(1);
        let (taken, samples) = RingBuffer::new(room);
        let routes = Routes {
            drive: channels.drive.clone(),
            trigger: channels.trigger,
        };
        Self {
            output: OutputCallback::new(
                (channels.output, routes),
                rate.hz(),
                obeyed,
                sent_home,
                say_output,
                Arc::clone(&board),
            ),
            input: InputCallback::new(channels.input, taken, say_input, Arc::clone(&board)),
            board,
            commands,
            home,
            output_happened,
            input_happened,
            samples,
        }
    }
}

impl RunningStreams {
    /// Opens the streams of `plan` on `io`, called `name` in messages.
    ///
    /// # Errors
    /// Those of [`AudioIo::open`].
    pub fn open(
        io: &mut dyn AudioIo,
        name: &str,
        plan: &StreamPlan,
        channels: &StreamChannels,
    ) -> Result<Self, AudioError> {
        let halves = Halves::new(plan.rate, channels);
        let streams = io.open(plan, halves.output, halves.input, &halves.board)?;
        let watchdog = streams
            .run_by_themselves()
            .then(|| Watchdog::start(&halves.board, plan.buffer_frames, plan.rate));
        Ok(Self {
            name: name.into(),
            rate: plan.rate,
            buffer_frames: plan.buffer_frames,
            input_channels: channels.input.max(1),
            board: halves.board,
            streams,
            _watchdog: watchdog,
            commands: halves.commands,
            home: halves.home,
            output_happened: halves.output_happened,
            input_happened: halves.input_happened,
            samples: halves.samples,
            loss: None,
            fetched: 0,
            maker: None,
            pieces: 0,
            happened: Vec::new(),
        })
    }

    /// The counters of the callbacks.
    #[must_use]
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// Whether they run by themselves, so that a pause means something.
    #[must_use]
    pub fn run_by_themselves(&self) -> bool {
        self.streams.run_by_themselves()
    }

    /// The rate of the streams.
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        self.rate
    }

    /// Tells a simulated finger what run comes.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] for a run that cannot be simulated.
    pub fn run_comes(&mut self, run: &RunPlan) -> Result<(), DeviceError> {
        self.streams.run_comes(run)
    }

    /// Plays `loaded` from the frame `onset` of the output on, or at once where that has passed; [`Happened::Onset`] says which frame it was.
    ///
    /// # Errors
    /// [`DeviceError::Lost`] when the device takes no more commands.
    pub fn play_at(&mut self, onset: u64, loaded: Loaded) -> Result<u64, DeviceError> {
        self.board.muted.store(false, Ordering::Release);
        self.pieces += 1;
        let piece = Piece {
            number: self.pieces,
            start: onset,
            samples: loaded.samples,
            stop: loaded.stop,
        };
        self.command(Command::Play(Box::new(piece)))?;
        self.maker = loaded.maker;
        Ok(self.pieces)
    }

    /// Fades out what plays.
    pub fn stop_playing(&mut self) {
        self.maker = None;
        // A device that takes no more commands plays nothing either.
        let _gone = self.command(Command::Stop);
    }

    fn command(&mut self, command: Command) -> Result<(), DeviceError> {
        while let Ok(done) = self.home.pop() {
            drop(done);
        }
        match self.commands.push(command) {
            Ok(()) => Ok(()),
            // A device that calls back takes its commands.
            Err(_full) => Err(self.lost_device()),
        }
    }

    /// How far the piece `number` is.
    #[must_use]
    pub fn progress(&self, number: u64) -> PieceProgress {
        // Its end is read first: what was played is complete then.
        let ended = self.board.ended.load(Ordering::Acquire) >= number;
        let current = self.board.piece.load(Ordering::Acquire) == number;
        PieceProgress {
            played: match current {
                true => self.board.played.load(Ordering::Acquire),
                false => 0,
            },
            ended,
        }
    }

    /// The frame of the output at which something that is asked for now can begin on time: a few buffers ahead.
    #[must_use]
    pub fn next_onset(&self, lead: Seconds) -> u64 {
        self.board.output.frames.load(Ordering::Acquire) + self.rate.samples_in(lead) as u64
    }

    /// What happened since this was last asked, on either side.
    pub fn take_happened(&mut self) -> Vec<Happened> {
        while let Ok(happened) = self.output_happened.pop() {
            self.happened.push(happened);
        }
        std::mem::take(&mut self.happened)
    }

    /// Leaves out what was recorded so far, and what there was no room for while nobody fetched; the next frame fetched comes after this
    /// call. Its number.
    pub fn skip(&mut self) -> u64 {
        self.drain();
        if self.board.overflowed.swap(0, Ordering::AcqRel) > 0 {
            // How many that were is known with the first frame behind them. A device that is gone says so when it is used.
            let _first = self.fetch(1, usize::MAX, &StopHandle::new());
            self.drain();
        }
        self.fetched
    }

    fn drain(&mut self) {
        while self.fetch_now(usize::MAX).is_some() {}
    }

    /// Waits for recorded frames, at most `most` and at least `enough` of them; none where `stop` came first.
    ///
    /// # Errors
    /// [`DeviceError::Lost`] when the device is gone, [`DeviceError::InputFull`] when recorded frames were not fetched in time,
    /// [`DeviceError::Unusable`] when the streams run at another rate.
    pub fn fetch(
        &mut self,
        enough: usize,
        most: usize,
        stop: &StopHandle,
    ) -> Result<Option<Fetched>, DeviceError> {
        loop {
            if stop.is_stopped() {
                return Ok(None);
            }
            if let Some(maker) = &mut self.maker {
                maker.top_up();
            }
            let there = self.samples.slots() / self.input_channels;
            if there >= enough.max(1)
                && let Some(fetched) = self.fetch_now(most)
            {
                return Ok(Some(fetched));
            }
            self.healthy()?;
            self.streams.wait(WAITS, stop);
        }
    }

    /// What is there, at most `most` frames, up to the next loss.
    fn fetch_now(&mut self, most: usize) -> Option<Fetched> {
        let there = (self.samples.slots() / self.input_channels).min(most);
        if there == 0 {
            return None;
        }
        // Losses before these frames were reported before them.
        if self.loss.is_none() {
            while let Ok(happened) = self.input_happened.pop() {
                self.happened.push(happened);
                if let Happened::Lost { frame, frames } = happened {
                    self.loss = Some((frame, frames));
                    break;
                }
            }
        }
        let mut lost = 0;
        let mut count = there;
        match self.loss {
            Some((frame, frames)) if frame <= self.fetched => {
                (lost, self.loss) = (frames, None);
                // What was lost next is looked for with the next frames.
                count = count.min(1);
            }
            Some((frame, _)) => count = count.min((frame - self.fetched) as usize),
            None => {}
        }
        let chunk = self.samples.read_chunk(count * self.input_channels).ok()?;
        let (first, second) = chunk.as_slices();
        let mut channels = vec![Vec::with_capacity(count); self.input_channels];
        for (i, sample) in first.iter().chain(second).enumerate() {
            channels[i % self.input_channels].push(*sample);
        }
        chunk.commit_all();
        self.fetched += lost;
        let fetched = Fetched {
            first: self.fetched,
            lost,
            channels,
        };
        self.fetched += count as u64;
        Some(fetched)
    }

    fn lost_device(&self) -> DeviceError {
        DeviceError::Lost {
            name: self.name.clone(),
            after_s: self.board.input.frames.load(Ordering::Acquire) as f64 / self.rate.hz(),
        }
    }

    /// Whether the device is there, in time, and at its rate.
    fn healthy(&self) -> Result<(), DeviceError> {
        let board = &self.board;
        let gone = [&board.output, &board.input]
            .iter()
            .any(|side| side.gone.load(Ordering::Acquire));
        if gone {
            return Err(self.lost_device());
        }
        if board.overflowed.load(Ordering::Acquire) > 0 {
            return Err(DeviceError::InputFull {
                name: self.name.clone(),
                after_s: board.input.frames.load(Ordering::Acquire) as f64 / self.rate.hz(),
            });
        }
        if !self.streams.run_by_themselves() {
            return Ok(());
        }
        let opened = board.age();
        let lost_after = pause_of(
            LOST_AFTER_S,
            LOST_AFTER_BUFFERS,
            self.buffer_frames,
            self.rate,
        );
        for side in [&board.output, &board.input] {
            let silent = match board.since_callback(side) {
                Some(silent) if opened < SETTLES => silent >= SETTLES,
                Some(silent) => silent >= lost_after,
                None => opened >= FIRST_CALLBACK,
            };
            if silent {
                return Err(self.lost_device());
            }
        }
        let (found_hz, ran_s) = board.input.effective_hz();
        let off = (found_hz / self.rate.hz() - 1.0).abs();
        // What a pause makes is made up for, and does not grow.
        let grows = off * ran_s > RATE_SLACK_S + RATE_TOLERANCE * ran_s;
        match ran_s >= RATE_AFTER_S && grows {
            true => Err(AudioError::EffectiveRate {
                wanted_hz: self.rate.hz(),
                found_hz,
            }
            .into()),
            false => Ok(()),
        }
    }
}

/// A pause of `s`, or of so many buffers of `frames`, whichever is longer.
fn pause_of(s: f64, buffers: f64, frames: u32, rate: SampleRate) -> Duration {
    Duration::from_secs_f64(s.max(buffers * f64::from(frames) / rate.hz()))
}

/// Silences the output when the device stops calling back: a thread of its own, so that nothing that waits can keep it from it.
struct Watchdog {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdog {
    fn start(board: &Arc<Board>, buffer_frames: u32, rate: SampleRate) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let limit = pause_of(
            SILENCED_AFTER_S,
            SILENCED_AFTER_BUFFERS,
            buffer_frames,
            rate,
        );
        let (board, stopped) = (Arc::clone(board), Arc::clone(&over));
        let watch = move || {
            while !stopped.load(Ordering::Acquire) {
                let gone = |side: &crate::board::Side| {
                    side.gone.load(Ordering::Acquire)
                        || board
                            .since_callback(side)
                            .is_some_and(|silent| silent >= limit)
                };
                if gone(&board.output) || gone(&board.input) {
                    board.muted.store(true, Ordering::Release);
                }
                std::thread::sleep(LOOKS);
            }
        };
        Self {
            // Without a thread the device is lost by its next fetch.
            thread: std::thread::Builder::new().spawn(watch).ok(),
            over,
        }
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}
