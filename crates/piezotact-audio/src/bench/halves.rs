//! The playing and the acquiring half of a sound device.

use piezotact::clipping::{ClippedAt, ClippingWarning};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use piezotact::Warning;
use piezotact::align::ClockTracker;
use piezotact::device::DriveSetup;
use piezotact::number::{counted, digits};
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{
    BenchKind, Condition, Event, EventValue, LostBy, RecordingWarning, Touch,
};
use piezotact::run::RunChunk;
use piezotact::sound::silent_runs;
use piezotact::statistics::{mean, rms};
use piezotact_bench::{
    Acquire, AcquireDescription, Bench, DeviceError, DriveSource, MOST_LOST, Play, PlayDescription,
    PlayProgress, Playback, RunPlan, SensorCalibration, StopHandle, Until,
};

use super::silent::{SILENT_SAMPLES, SilentParts};
use super::{AudioBench, Input};
use crate::callback::Happened;
use crate::forced::JoinedForce;
use crate::setup::Measures;
use crate::streams::{Fetched, Loaded, RunningStreams};

/// What is recorded before a drive begins, and after its end beside the latency, s: as on the twin.
const LEAD: Seconds = Seconds(0.2);
const REST_S: f64 = 0.3;
/// A latency that was not measured is at most this, s.
const LATENCY_S: f64 = 0.5;
/// The loopback has the drive at the latest so long after the run began, s.
const LATEST: Seconds = Seconds(LEAD.0 + 0.8);
/// The length of a calibration at rest, s.
const AT_REST: Seconds = Seconds(0.5);
/// The length of a chunk, s, and the longest one.
const CHUNK_S: f64 = 0.05;
const LONGEST_CHUNK_S: f64 = 0.5;
/// A recorded value of this share of full scale or more is clipped.
const FULL_SCALE: f32 = 0.999_9;
/// A pause between callbacks of so many buffers, or this, is a stall.
const STALL_BUFFERS: f64 = 4.0;
const STALL_S: f64 = 0.08;

/// Frames of output and input differ by so many buffers at most, and by this share of them.
const BUFFERS_APART: f64 = 8.0;
const CLOCKS_APART: f64 = 0.001;

/// The kinds of events of a run on a sound device.
const ONSET: &str = "playback_onset";
const RAN_DRY: &str = "playback_ran_dry";

/// Recorded frames, with the force at each, N, where it has a source of its own.
type WithForce = (Fetched, Option<Vec<f64>>);

/// What an open device is made of.
pub(super) struct Parts {
    pub(super) bench: AudioBench,
    pub(super) drive_setup: Option<DriveSetup>,
    pub(super) streams: RunningStreams,
    pub(super) inputs: Vec<Input>,
    pub(super) warnings: Vec<Warning>,
    pub(super) force: Option<JoinedForce>,
}

/// The halves of an open device.
pub(super) fn halves(parts: Parts) -> Bench {
    let shared = Arc::new(Mutex::new(Shared {
        bench: parts.bench,
        drive_setup: parts.drive_setup,
        streams: parts.streams,
        inputs: parts.inputs,
        warnings: parts.warnings,
        force: parts.force,
        loaded: None,
        planned: None,
        run: None,
        last: LastRun::default(),
    }));
    Bench::new(
        Box::new(Player(Arc::clone(&shared))),
        Box::new(Acquirer(shared)),
    )
}

struct Shared {
    bench: AudioBench,
    drive_setup: Option<DriveSetup>,
    streams: RunningStreams,
    inputs: Vec<Input>,
    warnings: Vec<Warning>,
    /// The normal force, when it is no input of the device; its channel is the last.
    force: Option<JoinedForce>,
    loaded: Option<Played>,
    planned: Option<(RunPlan, StopHandle)>,
    run: Option<UnderWay>,
    last: LastRun,
}

/// A drive that is ready, how many silent parts it has of its own, and what compares the clocks of output and input while it plays.
struct Played {
    loaded: Loaded,
    silent_parts: Option<usize>,
    clocks: Option<Clocks>,
}

/// What compares clocks; a drive that is made while it plays is noted where it is made.
type Clocks = Arc<Mutex<ClockTracker>>;

/// A drive that is made while it plays, and noted.
struct Noted {
    source: Box<dyn DriveSource>,
    clocks: Clocks,
}

impl DriveSource for Noted {
    fn rate(&self) -> SampleRate {
        self.source.rate()
    }

    fn next_samples(&mut self, count: usize) -> Vec<f64> {
        let samples = self.source.next_samples(count);
        tracked(&self.clocks).played(samples.iter().copied());
        samples
    }
}

fn tracked(clocks: &Clocks) -> MutexGuard<'_, ClockTracker> {
    clocks.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is known of a run beside its samples.
#[derive(Clone, Debug, Default)]
struct LastRun {
    events: Vec<Event>,
    clipped: Vec<u64>,
    limited: u64,
    /// The loopback as it was recorded, to look for silent parts.
    loopback: SilentParts,
    own_silent_parts: Option<usize>,
    clocks: Option<Clocks>,
    dry: usize,
    stalls: (usize, f64),
}

struct UnderWay {
    plan: RunPlan,
    stop: StopHandle,
    /// The frame of the input that is its first sample.
    origin: u64,
    /// The frames of output and input when it began.
    began: [u64; 2],
    acquired: u64,
    piece: Option<u64>,
    /// The frame of the run at which the drive began, and the frames of silence where it came too late.
    onset: Option<u64>,
    dry: u64,
    /// The playback was stopped before its end.
    cut: bool,
    ends_at: Option<u64>,
    acquiring: bool,
}

fn locked(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn before(asked: &'static str, before: &'static str) -> DeviceError {
    DeviceError::Order { asked, before }
}

impl Shared {
    fn rate(&self) -> SampleRate {
        self.streams.rate()
    }

    fn name(&self) -> String {
        let behind = match self.bench.kind {
            BenchKind::Twin => ", behind it the digital twin",
            BenchKind::Scripted | BenchKind::Measured => ", behind it no device and no finger",
            BenchKind::Hardware => "",
        };
        format!("sound device `{}`{behind}", self.bench.setup.called())
    }

    /// The latency of the device, in words.
    fn latency(&self) -> String {
        let latency = self.bench.latency.as_ref();
        let spread = latency.and_then(|latency| Some((latency, latency.latency?)));
        match spread {
            Some((latency, spread)) => format!(
                "output to input in {} ms (median of {}, {} within {} ms, measured on {})",
                digits(1e3 * spread.median_s.0),
                counted(latency.found(), "restart"),
                match latency.has_percentiles() {
                    true => "99 %",
                    false => "all",
                },
                digits(
                    1e3 * match latency.has_percentiles() {
                        true => spread.p99_s.0,
                        false => spread.range_s[1].0,
                    }
                ),
                latency.measured_on
            ),
            None => "latency not measured".into(),
        }
    }

    /// The samples of `fetched` in SI units, in the order of the channels.
    fn in_units(&mut self, fetched: &Fetched) -> Vec<Vec<f64>> {
        let last = &mut self.last;
        last.clipped.resize(self.inputs.len(), 0);
        let inputs = self.inputs.iter().zip(&mut last.clipped);
        inputs
            .map(|(input, clipped)| {
                let samples = &fetched.channels[input.channel];
                *clipped += samples.iter().filter(|v| v.abs() >= FULL_SCALE).count() as u64;
                samples
                    .iter()
                    .map(|v| f64::from(*v) * input.scale)
                    .collect()
            })
            .collect()
    }

    /// The next frames, with their force where it has a source of its own; none where `stop` came first.
    fn fetch(
        &mut self,
        enough: usize,
        most: usize,
        stop: &StopHandle,
    ) -> Result<Option<WithForce>, DeviceError> {
        let Some(force) = &mut self.force else {
            let fetched = self.streams.fetch(enough, most, stop)?;
            return Ok(fetched.map(|fetched| (fetched, None)));
        };
        loop {
            let arrived = self.streams.board().input.frames.load(Ordering::Acquire);
            force.arrived(arrived)?;
            if let Some((fetched, force_n)) = force.ready()? {
                return Ok(Some((fetched, Some(force_n))));
            }
            // Fewer at a time, so that readings are fetched soon after they arrive.
            match self.streams.fetch(1, enough, stop)? {
                Some(fetched) => force.wait_for(fetched),
                None => return Ok(None),
            }
        }
    }

    /// The frames that output and input have passed, lost ones counted.
    fn passed(&self) -> [u64; 2] {
        let board = self.streams.board();
        [&board.output, &board.input].map(|side| side.frames.load(Ordering::Acquire))
    }

    /// Refuses a run in which the input passed fewer frames than the output since both stood at `began`, beyond what clocks and buffers make: they were
    /// lost, and it is not known where.
    fn as_many_on_both_sides(&self, began: [u64; 2]) -> Result<(), DeviceError> {
        let [played, recorded] = self.passed();
        let [played, recorded] = [played - began[0], recorded - began[1]];
        let buffers = BUFFERS_APART * f64::from(self.bench.setup.buffer_frames);
        let missing = played as f64 - recorded as f64;
        match missing > buffers + CLOCKS_APART * played as f64 {
            true => Err(DeviceError::Unusable(format!(
                "the input delivered {missing:.0} frames fewer than the output played, and the sound system reported no loss: the computer is too busy, the \
                 buffers are too short, or the sound system has no real-time priority; close other programs, use larger buffers, allow real-time \
                 priority, then measure again"
            ))),
            false => Ok(()),
        }
    }

    /// Notes what happened since the last call.
    fn note_happened(&mut self) {
        let rate_hz = self.rate().hz();
        let Some(run) = &mut self.run else {
            return;
        };
        let origin = run.origin;
        let event = |frame: u64, frames: u64, kind: &str, value: u64| Event {
            onset_s: Seconds(frame.saturating_sub(origin) as f64 / rate_hz),
            duration_s: Seconds(frames as f64 / rate_hz),
            kind: kind.into(),
            value: Some(EventValue::Number(value as f64)),
        };
        for happened in self.streams.take_happened() {
            match happened {
                // The moment at which it was handed over; it is recorded a latency later.
                Happened::Onset { frame, input } => {
                    run.onset = Some(input.saturating_sub(origin));
                    self.last.events.push(event(input, 0, ONSET, frame));
                }
                Happened::RanDry { frames, input, .. } => {
                    self.last.dry += 1;
                    run.dry += frames;
                    let began = input.saturating_sub(frames);
                    self.last.events.push(event(began, frames, RAN_DRY, frames));
                }
                Happened::Lost { .. } => {}
            }
        }
        if !self.streams.run_by_themselves() {
            return;
        }
        let board = self.streams.board();
        let limit_s =
            STALL_S.max(STALL_BUFFERS * f64::from(self.bench.setup.buffer_frames) / rate_hz);
        let pause = board
            .output
            .take_longest_pause()
            .max(board.input.take_longest_pause());
        if pause >= Duration::from_secs_f64(limit_s) {
            let (times, longest_s) = self.last.stalls;
            self.last.stalls = (times + 1, longest_s.max(pause.as_secs_f64()));
        }
    }

    /// How many samples the loopback left silent that the drive did not.
    fn silent_parts(&self) -> usize {
        let own = self.last.own_silent_parts;
        own.map_or(0, |own| self.last.loopback.parts.saturating_sub(own))
    }

    fn run_warnings(&self) -> Vec<Warning> {
        let mut warnings = self.warnings.clone();
        for (input, clipped) in self.inputs.iter().zip(&self.last.clipped) {
            if *clipped > 0 {
                warnings.push(Warning::from(ClippingWarning::Clipped {
                    signal: format!("the input of `{}`", input.measures.name()),
                    at: ClippedAt::Input { samples: *clipped },
                }));
            }
        }
        if self.last.limited > 0 {
            warnings.push(Warning::from(ClippingWarning::Clipped {
                signal: "the drive".into(),
                at: ClippedAt::Output {
                    samples: self.last.limited,
                },
            }));
        }
        let (parts, samples) = (self.silent_parts(), self.last.loopback.samples);
        let silence = (parts > 0).then_some(LostBy::Silence { parts, samples });
        let (times, longest_s) = self.last.stalls;
        let pause = (times > 0).then_some(LostBy::Pause { times, longest_s });
        let lost = [silence, pause].into_iter().flatten();
        warnings.extend(lost.map(|by| Warning::from(RecordingWarning::SamplesLost { by })));
        warnings.extend(self.clock_warnings());
        warnings.extend(self.force.iter().flat_map(JoinedForce::warnings));
        warnings
    }

    /// What the loopback says of the clocks. A playback that ran dry is late from there on, which is said already.
    fn clock_warnings(&self) -> Vec<Warning> {
        let clocks = self.last.clocks.as_ref().filter(|_| self.last.dry == 0);
        let compared = clocks.and_then(|clocks| tracked(clocks).result());
        compared.map_or(Vec::new(), |compared| compared.warnings(self.rate()))
    }
}

struct Player(Arc<Mutex<Shared>>);

impl Play for Player {
    fn describe(&self) -> PlayDescription {
        let shared = locked(&self.0);
        PlayDescription {
            name: shared.name(),
            kind: shared.bench.kind,
            rate: shared.rate(),
            gain: Some(shared.bench.device.gain().name.clone()),
        }
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        Ok(locked(&self.0).drive_setup.clone())
    }

    fn ready(
        &mut self,
        playback: Playback,
        _run: &RunPlan,
        stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        let output = shared.rate();
        if playback.rate() != output {
            return Err(DeviceError::Rate {
                drive: playback.rate(),
                output,
                name: shared.name(),
            });
        }
        let clocks = shared.bench.setup.loopback().map(|_| {
            let latest = output.samples_in(LATEST);
            Clocks::new(Mutex::new(ClockTracker::new(output, 0, latest)))
        });
        let silent_parts = match &playback {
            Playback::Whole(drive) => Some(silent_runs(drive.samples(), SILENT_SAMPLES).len()),
            Playback::Made(_) => None,
        };
        let playback = match (playback, &clocks) {
            (Playback::Made(source), Some(clocks)) => {
                let clocks = Arc::clone(clocks);
                Playback::Made(Box::new(Noted { source, clocks }))
            }
            (playback, _) => playback,
        };
        if let (Playback::Whole(drive), Some(clocks)) = (&playback, &clocks) {
            tracked(clocks).played(drive.samples().iter().copied());
        }
        shared.loaded = Some(Played {
            loaded: Loaded::of(playback, stop),
            silent_parts,
            clocks,
        });
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let shared = &mut *locked(&self.0);
        let played = shared.loaded.take().ok_or(before("play", "made ready"))?;
        if !shared.run.as_ref().is_some_and(|run| run.acquiring) {
            return Err(before("play", "acquiring"));
        }
        let onset = shared.streams.next_onset(LEAD);
        let piece = shared.streams.play_at(onset, played.loaded)?;
        shared.last.own_silent_parts = played.silent_parts;
        shared.last.clocks = played.clocks;
        if let Some(run) = &mut shared.run {
            run.piece = Some(piece);
        }
        Ok(())
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        let mut shared = locked(&self.0);
        shared.note_happened();
        let run = shared
            .run
            .as_ref()
            .ok_or(before("say how far it is", "started"))?;
        let piece = run.piece.ok_or(before("say how far it is", "started"))?;
        let cut = run.cut;
        let progress = shared.streams.progress(piece);
        Ok(PlayProgress {
            played: progress.played,
            underruns: shared.last.dry + shared.silent_parts() + shared.last.stalls.0,
            ended: progress.ended || cut,
        })
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.loaded = None;
        let playing = shared.run.as_ref().and_then(|run| run.piece);
        if playing.is_some_and(|piece| !shared.streams.progress(piece).ended) {
            shared.streams.stop_playing();
        }
        if let Some(run) = &mut shared.run {
            run.cut |= run.piece.is_some();
        }
    }
}

struct Acquirer(Arc<Mutex<Shared>>);

impl Acquirer {
    /// The next frames of the run in progress; none when it is over. The lock is given back between waits.
    fn next(&self) -> Result<Option<RunChunk>, DeviceError> {
        let shared = &mut *locked(&self.0);
        let rate = shared.rate();
        let run = shared.run.as_ref().filter(|run| run.acquiring);
        let run = run.ok_or(before("wait", "started"))?;
        if run.piece.is_none() && shared.loaded.is_some() && !run.stop.is_stopped() {
            return Err(before("wait", "told to play what is ready"));
        }
        let wanted = match run.plan.until {
            Until::Duration(duration) => Some(rate.samples_in(duration) as u64),
            Until::PlaybackEnded => run.ends_at,
            Until::Stopped => None,
        };
        let left = wanted.map_or(u64::MAX, |wanted| wanted.saturating_sub(run.acquired));
        let unheard = run.cut && run.plan.until == Until::PlaybackEnded && run.ends_at.is_none();
        if left == 0 || unheard {
            shared.as_many_on_both_sides(run.began)?;
            return Ok(None);
        }
        let frames = |s: f64| (s * rate.hz()).ceil() as u64;
        let most = frames(LONGEST_CHUNK_S).min(left) as usize;
        let enough = frames(CHUNK_S).min(left) as usize;
        let stop = run.stop.clone();
        let fetched = shared.fetch(enough, most, &stop)?;
        shared.note_happened();
        let Some((fetched, force_n)) = fetched else {
            return Ok(None);
        };
        if fetched.lost as f64 > MOST_LOST.0 * rate.hz() {
            let acquired = shared.run.as_ref().map_or(0, |run| run.acquired);
            return Err(DeviceError::lost_samples(
                &shared.name(),
                fetched.lost,
                rate,
                Seconds(acquired as f64 / rate.hz()),
            ));
        }
        let mut channels = shared.in_units(&fetched);
        channels.extend(force_n);
        let drive = shared
            .inputs
            .iter()
            .position(|input| input.measures == Measures::Drive);
        let Some(run) = &mut shared.run else {
            return Ok(None);
        };
        if let Some(drive) = drive {
            shared.last.loopback.take(&channels[drive]);
            if let Some(clocks) = &shared.last.clocks {
                tracked(clocks).recorded(fetched.first - run.origin, &channels[drive]);
            }
        }
        // Of a loss beyond the end of the run only what lies within it counts, and the time of the device is beyond it.
        let lost = fetched.lost.min(left);
        let device_s = (fetched.first - run.origin) as f64 / rate.hz();
        let mut chunk = RunChunk {
            first: run.acquired + lost,
            device_s: (lost < left).then_some(device_s),
            lost,
            channels,
            ..RunChunk::default()
        };
        let keep = (left - lost) as usize;
        chunk
            .channels
            .iter_mut()
            .for_each(|channel| channel.truncate(keep));
        run.acquired += lost + chunk.len() as u64;
        Ok(Some(chunk))
    }
}

impl Acquire for Acquirer {
    fn describe(&self) -> AcquireDescription {
        let shared = locked(&self.0);
        let measures = shared.inputs.iter().map(|input| input.measures);
        let channels: Vec<(String, Unit)> = measures
            .chain(shared.force.iter().map(|_| Measures::Force))
            .map(|measures| (measures.name().into(), measures.unit()))
            .collect();
        let force = shared.force.as_ref().map(JoinedForce::described);
        let setup = &shared.bench.setup;
        let made_on = shared
            .bench
            .calibration
            .as_ref()
            .map(|calibration| calibration.made_on.as_str());
        AcquireDescription {
            name: shared.name(),
            kind: shared.bench.kind,
            rate: shared.rate(),
            channels,
            condition: Condition {
                participant: shared.bench.participant.clone(),
                twin_seed: shared.bench.twin_seed,
                touch: Some(Touch::Resting),
                ..Condition::default()
            },
            seed: None,
            steps: vec![format!(
                "played and recorded by {} in buffers of {} frames, {}, {}",
                shared.name(),
                setup.buffer_frames,
                match made_on {
                    Some(made_on) => format!("calibrated on {made_on}"),
                    None => "not calibrated".into(),
                },
                shared.latency()
            )]
            .into_iter()
            .chain(force)
            .collect(),
            answers_with: None,
        }
    }

    fn warnings(&self, _run: &RunPlan) -> Vec<Warning> {
        locked(&self.0).run_warnings()
    }

    fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut locked(&self.0).last.events)
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        let shared = &mut *locked(&self.0);
        let frames = shared.rate().samples_in(AT_REST);
        shared.streams.skip();
        let (mut channels, mut there) = (vec![Vec::new(); shared.inputs.len()], 0);
        let stop = StopHandle::new();
        while there < frames {
            let Some(fetched) = shared.streams.fetch(1, frames - there, &stop)? else {
                break;
            };
            for (all, input) in channels.iter_mut().zip(&shared.inputs) {
                let samples = fetched.channels[input.channel].iter();
                all.extend(samples.map(|v| f64::from(*v) * input.scale));
            }
            there += fetched.channels.first().map_or(0, Vec::len);
        }
        if let Some(force) = &mut shared.force {
            channels.push(force.readings_n()?);
        }
        let offset: Vec<f64> = channels.iter().map(|channel| mean(channel)).collect();
        let noise_rms = channels.iter().zip(&offset).map(|(channel, offset)| {
            let about: Vec<f64> = channel.iter().map(|v| v - offset).collect();
            rms(&about)
        });
        Ok(SensorCalibration {
            noise_rms: noise_rms.collect(),
            offset,
        })
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        shared.streams.run_comes(run)?;
        shared.planned = Some((run.clone(), stop.clone()));
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let shared = &mut *locked(&self.0);
        let planned = shared.planned.take();
        let (plan, stop) = planned.ok_or(before("acquire", "made ready"))?;
        let origin = shared.streams.skip();
        if let Some(force) = &mut shared.force {
            force.begin(origin)?;
        }
        let _before = shared.streams.take_happened();
        let board = shared.streams.board();
        let _pauses = (
            board.output.take_longest_pause(),
            board.input.take_longest_pause(),
        );
        board.limited.store(0, Ordering::Release);
        shared.last = LastRun::default();
        shared.run = Some(UnderWay {
            plan,
            stop,
            origin,
            began: shared.passed(),
            acquired: 0,
            piece: None,
            onset: None,
            dry: 0,
            cut: false,
            ends_at: None,
            acquiring: true,
        });
        Ok(())
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        self.next()
    }

    fn playback_ended(&mut self) {
        let shared = &mut *locked(&self.0);
        let rate = shared.rate();
        shared.last.limited = shared.streams.board().limited.load(Ordering::Acquire);
        let buffers = 4.0 * f64::from(shared.bench.setup.buffer_frames) / rate.hz();
        let rest = rate.samples_in(Seconds(REST_S + LATENCY_S.max(buffers))) as u64;
        let piece = shared.run.as_ref().and_then(|run| run.piece);
        let played = piece.map_or(0, |piece| shared.streams.progress(piece).played);
        if let Some(run) = &mut shared.run {
            // What was acquired is behind what was played where frames wait, or were lost and are not reported yet.
            let played = run.onset.map_or(0, |onset| onset + played + run.dry);
            run.ends_at.get_or_insert(run.acquired.max(played) + rest);
        }
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.planned = None;
        if let Some(run) = &mut shared.run {
            run.acquiring = false;
        }
    }
}
