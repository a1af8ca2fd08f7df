//! A loop within the program: what the output plays comes back on the inputs, directly and through a simulated finger, with the faults of real
//! devices on request. For tests and rehearsals, with no device.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use piezotact::quantity::SampleRate;
use piezotact::sound::DeviceListing;
use piezotact::statistics::random::Random;
use piezotact_bench::{DeviceError, Plant, RunPlan, StopHandle};

use crate::board::Board;
use crate::callback::{InputCallback, OutputCallback};
use crate::error::{AudioError, wrong};
use crate::io::{AudioIo, StreamPlan, Streams};
use crate::loop_settings::{LoopFailure, LoopFault, LoopPace, LoopSettings};
use crate::setup::{Measures, SoundSetup};

/// The level of the calibrator on which a sensor of the loop may be mounted: rms in the sensor's unit, and Hz.
const CALIBRATOR: (f64, f64) = (10.0, 159.2);

/// Makes the simulated finger for a run at a rate.
pub type PlantMaker =
    Box<dyn Fn(Option<&RunPlan>, SampleRate) -> Result<Box<dyn Plant>, DeviceError> + Send>;

/// A loop that can be opened.
pub struct LoopIo {
    settings: LoopSettings,
    wires: Vec<LoopWire>,
    drive: usize,
    plant: Option<PlantMaker>,
}

impl std::fmt::Debug for LoopIo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LoopIo")
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

/// What arrives at one input, channel from 0.
#[derive(Clone, Debug)]
struct LoopWire {
    channel: usize,
    measures: Measures,
    /// Full scale of the input per unit.
    per_unit: f64,
    calibrated: bool,
}

impl LoopIo {
    /// The loop of `setup`, with the simulated finger that `plant` makes.
    ///
    /// # Errors
    /// [`AudioError::Setup`] for a set-up without a loop.
    pub fn new(setup: &SoundSetup, plant: Option<PlantMaker>) -> Result<Self, AudioError> {
        let settings = setup
            .looped
            .clone()
            .ok_or_else(|| wrong("a part [loop]", "none"))?;
        let wires = setup.record.iter().map(|recorded| LoopWire {
            channel: recorded.channel as usize - 1,
            measures: recorded.measures,
            per_unit: recorded.v_per_unit().unwrap_or(1.0) / settings.input_v_per_full_scale,
            calibrated: settings.on_calibrator == Some(recorded.channel),
        });
        Ok(Self {
            wires: wires.collect(),
            drive: setup
                .play
                .drive
                .first()
                .map_or(0, |channel| *channel as usize - 1),
            plant,
            settings,
        })
    }
}

impl AudioIo for LoopIo {
    fn devices(&self) -> Result<Vec<DeviceListing>, AudioError> {
        Ok(Vec::new())
    }

    fn open(
        &mut self,
        plan: &StreamPlan,
        output: OutputCallback,
        input: InputCallback,
        board: &Arc<Board>,
    ) -> Result<Box<dyn Streams>, AudioError> {
        let plant = match &self.plant {
            Some(make) => Some(make(None, plan.rate)?),
            None => None,
        };
        let rate_hz = plan.rate.hz();
        let engine = Engine {
            rate_hz,
            wires: self.wires.clone(),
            drive: self.drive,
            out: vec![0.0; plan.buffer_frames as usize * output.channels().max(1)],
            taken: Vec::new(),
            frames: plan.buffer_frames as usize,
            line: VecDeque::from(vec![0.0; self.settings.delay_frames as usize + LINE]),
            place: 0.0,
            given: 0,
            recorded: 0,
            to_lose: 0,
            losing: 0,
            plant_channels: plant
                .as_ref()
                .map_or(Vec::new(), |plant| names(plant.as_ref())),
            behind: plant
                .as_ref()
                .map_or(VecDeque::new(), |plant| silence(plant.as_ref())),
            plant,
            through: Vec::new(),
            passes: self
                .wires
                .iter()
                .map(|_| HighPass::at(self.settings.corner_hz, rate_hz))
                .collect(),
            noise: Random::stream(self.settings.seed, 0, "sound loop"),
            faults: self.settings.faults.clone(),
            over: false,
            settings: self.settings.clone(),
            output,
            input,
            board: Arc::clone(board),
        };
        let engine = Arc::new(Mutex::new(engine));
        let streams = LoopStreams {
            maker: self.plant.take(),
            rate: plan.rate,
            thread: (self.settings.pace == LoopPace::RealTime).then(|| Clockwork::start(&engine)),
            engine,
        };
        Ok(Box::new(streams))
    }
}

/// As much silence as the answer of `plant` comes later than that of a device.
fn silence(plant: &dyn Plant) -> VecDeque<f64> {
    VecDeque::from(vec![0.0; plant.rate().samples_in(plant.delay())])
}

fn names(plant: &dyn Plant) -> Vec<String> {
    plant.channels().into_iter().map(|(name, _)| name).collect()
}

/// Frames about a place that are interpolated between.
const LINE: usize = 4;

struct Engine {
    settings: LoopSettings,
    rate_hz: f64,
    wires: Vec<LoopWire>,
    drive: usize,
    out: Vec<f32>,
    taken: Vec<f32>,
    frames: usize,
    /// What the output gave and the input has not passed yet.
    line: VecDeque<f64>,
    /// The place of the next input frame in the line, behind its first sample.
    place: f64,
    /// Frames that the output gave by its clock, silence counted, and that the input recorded, lost ones counted.
    given: u64,
    recorded: u64,
    /// Frames that the input is to lose, and those of them that have passed.
    to_lose: u64,
    losing: u64,
    plant: Option<Box<dyn Plant>>,
    plant_channels: Vec<String>,
    /// The loopback on its way, as late as the answer of the finger.
    behind: VecDeque<f64>,
    through: Vec<Vec<f64>>,
    passes: Vec<HighPass>,
    noise: Random,
    faults: Vec<LoopFault>,
    over: bool,
    output: OutputCallback,
    input: InputCallback,
    board: Arc<Board>,
}

impl Engine {
    /// The next fault that is due.
    fn due(&mut self) -> Option<LoopFault> {
        let now_s = self.given as f64 / self.rate_hz;
        let at = self.faults.iter().position(|fault| fault.at_s <= now_s)?;
        Some(self.faults.swap_remove(at))
    }

    /// A buffer passes.
    fn step(&mut self) -> Duration {
        let mut pause = Duration::ZERO;
        while let Some(fault) = self.due() {
            let frames = (fault.for_s * self.rate_hz).round() as u64;
            match fault.what {
                LoopFailure::Underrun => {
                    pause += Duration::from_secs_f64(fault.for_s);
                    self.starve(frames);
                }
                LoopFailure::Overrun => self.to_lose += frames,
                LoopFailure::Stall => {
                    pause += Duration::from_secs_f64(fault.for_s);
                    self.starve(frames);
                    self.to_lose += frames;
                }
                LoopFailure::Removed => {
                    self.over = true;
                    self.board.output.gone.store(true, Ordering::Release);
                    self.board.input.gone.store(true, Ordering::Release);
                }
                LoopFailure::Silenced => self.over = true,
            }
        }
        if self.over {
            return pause;
        }
        let channels = self.output.channels().max(1);
        let mut out = std::mem::take(&mut self.out);
        self.output.fill(&mut out);
        let drive: Vec<f64> = out
            .chunks_exact(channels)
            .map(|frame| self.engine_gives(f64::from(frame[self.drive])))
            .collect();
        self.out = out;
        self.line.extend(&drive);
        self.pass();
        pause
    }

    /// A sample of the drive as the engine hands it on.
    fn engine_gives(&mut self, sample: f64) -> f64 {
        let at = self.given;
        self.given += 1;
        match self.settings.silent {
            Some(silent) if at % silent.every.max(1) < silent.of => 0.0,
            _ => sample,
        }
    }

    /// The output is not served for `frames`: silence is played.
    fn starve(&mut self, frames: u64) {
        self.output.skipped(frames);
        self.given += frames;
        self.line.extend((0..frames).map(|_| 0.0));
    }

    /// The frames of the loopback that are due by the clock of the input.
    fn heard(&mut self) -> Vec<f64> {
        let step = 1.0 / (1.0 + 1e-6 * self.settings.clock_ppm);
        let keep = self.settings.delay_frames as usize;
        let mut heard = Vec::new();
        while self.place as usize + LINE + keep <= self.line.len() {
            let at = self.place as usize;
            heard.push(between(&self.line, at, self.place - at as f64));
            self.place += step;
        }
        let behind = (self.place as usize).min(self.line.len());
        self.line.drain(..behind);
        self.place -= behind as f64;
        heard
    }

    /// What the finger does while `drive` passes.
    fn finger(&mut self, drive: &[f64]) {
        self.through.resize(self.plant_channels.len(), Vec::new());
        self.through.iter_mut().for_each(Vec::clear);
        if let Some(plant) = &mut self.plant {
            plant.process(drive, &mut self.through);
        }
    }

    /// All frames that are due by the clock of the input reach it.
    fn pass(&mut self) {
        let drive = self.heard();
        self.finger(&drive);
        self.behind.extend(&drive);
        let drive: Vec<f64> = self.behind.drain(..drive.len()).collect();
        let channels = self.input.channels().max(1);
        self.taken.clear();
        self.taken.resize(drive.len() * channels, 0.0);
        let (calibrator, hz) = CALIBRATOR;
        for (wire, pass) in self.wires.iter().zip(&mut self.passes) {
            let from = self
                .plant_channels
                .iter()
                .position(|name| name == wire.measures.name());
            for (i, played) in drive.iter().enumerate() {
                let t = (self.recorded + i as u64) as f64 / self.rate_hz;
                let value = match (wire.measures, from) {
                    _ if wire.calibrated => {
                        wire.per_unit * calibrator * 2f64.sqrt() * (TAU * hz * t).sin()
                    }
                    (Measures::Drive, _) => self.settings.gain * played,
                    (_, Some(from)) => wire.per_unit * self.through[from][i],
                    (_, None) => 0.0,
                };
                let noisy = pass.next(value) + self.settings.noise * self.noise.normal();
                self.taken[i * channels + wire.channel] = noisy.clamp(-1.0, 1.0) as f32;
            }
        }
        self.recorded += drive.len() as u64;
        let taken = std::mem::take(&mut self.taken);
        let lost = (self.to_lose - self.losing).min(drive.len() as u64);
        self.losing += lost;
        let kept = &taken[lost as usize * channels..];
        if self.losing > 0 && self.losing == self.to_lose {
            self.input.lost(self.losing);
            (self.to_lose, self.losing) = (0, 0);
        }
        // The buffers of an input are no longer than those of the output, as at a real device.
        for buffer in kept.chunks(self.frames * channels) {
            self.input.take(buffer);
        }
        self.taken = taken;
    }
}

/// The value at `share` between samples `at + 1` and `at + 2` of `line`, by the cubic through four samples.
fn between(line: &VecDeque<f64>, at: usize, share: f64) -> f64 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| line[at + i]);
    if share == 0.0 {
        return b;
    }
    let t = share;
    a * -t * (t - 1.0) * (t - 2.0) / 6.0 + b * (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
        - c * (t + 1.0) * t * (t - 2.0) / 2.0
        + d * (t + 1.0) * t * (t - 1.0) / 6.0
}

/// A high-pass of first order; none where its corner is 0.
struct HighPass {
    a: f64,
    b: f64,
    before: f64,
    out: f64,
}

impl HighPass {
    fn at(corner_hz: f64, rate_hz: f64) -> Self {
        let k = (TAU * corner_hz / rate_hz / 2.0).tan();
        Self {
            a: (1.0 - k) / (1.0 + k),
            b: 1.0 / (1.0 + k),
            before: 0.0,
            out: 0.0,
        }
    }

    fn next(&mut self, sample: f64) -> f64 {
        if self.b >= 1.0 {
            return sample;
        }
        self.out = self.b * (sample - self.before) + self.a * self.out;
        self.before = sample;
        self.out
    }
}

fn locked(engine: &Mutex<Engine>) -> MutexGuard<'_, Engine> {
    engine.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The thread of a loop in real time.
struct Clockwork {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Clockwork {
    fn start(engine: &Arc<Mutex<Engine>>) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (engine, stopped) = (Arc::clone(engine), Arc::clone(&over));
        let thread = std::thread::spawn(move || {
            let mut due = Instant::now();
            while !stopped.load(Ordering::Acquire) {
                let (pause, buffer) = {
                    let mut engine = locked(&engine);
                    let pause = engine.step();
                    (
                        pause,
                        Duration::from_secs_f64(engine.frames as f64 / engine.rate_hz),
                    )
                };
                due += buffer + pause;
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
        });
        Self {
            over,
            thread: Some(thread),
        }
    }
}

impl Drop for Clockwork {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

struct LoopStreams {
    engine: Arc<Mutex<Engine>>,
    thread: Option<Clockwork>,
    maker: Option<PlantMaker>,
    rate: SampleRate,
}

impl Streams for LoopStreams {
    fn wait(&mut self, at_most: Duration, stop: &StopHandle) {
        if self.thread.is_some() || locked(&self.engine).over {
            let _stopped = stop.wait(at_most);
            return;
        }
        let _pause = locked(&self.engine).step();
    }

    fn run_by_themselves(&self) -> bool {
        self.thread.is_some()
    }

    fn run_comes(&mut self, run: &RunPlan) -> Result<(), DeviceError> {
        if let Some(make) = &self.maker {
            let plant = make(Some(run), self.rate)?;
            let mut engine = locked(&self.engine);
            engine.plant_channels = names(plant.as_ref());
            // A finger has the same delay in every run.
            engine.behind.resize(silence(plant.as_ref()).len(), 0.0);
            engine.plant = Some(plant);
        }
        Ok(())
    }
}
