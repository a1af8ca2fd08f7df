//! The playing and acquiring halves of the scripted fake.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Force, Quantity, SampleRate, Seconds};
use piezotact::recording::{BenchKind, Condition, Touch};
use piezotact::run::RunChunk;

use super::script::{Breach, FakeScript, Half, Pace, TimeOrigin};
use super::world::{Device, Output};
use crate::error::DeviceError;
use crate::plan::{Playback, RunPlan, Until};
use crate::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL, FORCE_CHANNEL};
use crate::random::Random;
use crate::stop::StopHandle;
use crate::traits::{
    Acquire, AcquireDescription, Bench, Play, PlayDescription, PlayProgress, SensorCalibration,
};

/// From the start of the playback to its first sample, s.
const LATENCY_S: f64 = 0.05;
/// The time acquired after the playback, s.
const REST_S: f64 = 0.3;
/// A chunk with too many samples, s.
const TOO_LONG_S: f64 = 2.5;
/// How much is lost without a report, s.
const UNREPORTED_S: f64 = 0.05;
/// The interval at which a waiting half checks whether it was stopped, s.
const LOOKS_EVERY_S: f64 = 3600.0;
/// The name of the fake.
const NAME: &str = "scripted fake of a bench (no device and no finger)";

/// The halves of the bench that `script` describes.
pub(super) fn halves(script: FakeScript, rates: [SampleRate; 2], participant: &str) -> Bench {
    let shared = Arc::new(Mutex::new(Shared {
        script,
        rates,
        participant: participant.into(),
        planned: None,
        loaded: None,
        running: None,
        playing: None,
        before: 0,
    }));
    Bench::new(
        Box::new(Player(Arc::clone(&shared))),
        Box::new(Acquirer(shared)),
    )
}

struct Shared {
    script: FakeScript,
    /// Of output and input.
    rates: [SampleRate; 2],
    participant: String,
    planned: Option<(RunPlan, StopHandle)>,
    loaded: Option<Playback>,
    running: Option<Running>,
    playing: Option<Playing>,
    /// Samples that were acquired in runs before.
    before: u64,
}

/// An input that acquires.
struct Running {
    plan: RunPlan,
    stop: StopHandle,
    device: Device,
    began: Instant,
    /// Samples of the run, lost ones counted.
    at: u64,
    /// Samples that were lost without a report.
    hidden: u64,
    chunks: usize,
    /// When the rest behind the playback is over.
    ends_at: Option<u64>,
    late: Vec<usize>,
    lost: Vec<usize>,
    faulty: bool,
    last: RunChunk,
}

/// An output that plays.
struct Playing {
    output: Output,
    /// The sample of the run at which it was started.
    since: u64,
    /// The progress at its end.
    ended: Option<PlayProgress>,
}

/// What has to happen before the next chunk is delivered.
enum Next {
    /// Nothing: the chunk is delivered at once.
    Chunk(Option<RunChunk>),
    /// Time, then the chunk.
    After(Duration, StopHandle, RunChunk),
    /// Samples that never arrive.
    Never(StopHandle),
}

impl Shared {
    fn input_hz(&self) -> f64 {
        self.rates[1].hz()
    }

    /// What was acquired since the bench was opened, s.
    fn now_s(&self) -> f64 {
        let run = self.running.as_ref().map_or(0, |run| run.at);
        (self.before + run) as f64 / self.input_hz()
    }

    /// Whether `half` is there.
    fn there(&self, half: Half) -> Result<(), DeviceError> {
        let after_s = self.now_s();
        match self.script.lost {
            Some(lost) if lost.half == half && after_s >= lost.after_s => Err(DeviceError::Lost {
                name: match half {
                    Half::Output => "output of the scripted fake",
                    Half::Input => "input of the scripted fake",
                }
                .into(),
                after_s,
            }),
            _ => Ok(()),
        }
    }

    /// The position in the output signal of the sample `at` of the run.
    fn position(&self, playing: &Playing, at: u64) -> f64 {
        let by_input_s = (at as f64 - playing.since as f64) / self.input_hz();
        let by_output_s = by_input_s / (1.0 + self.script.clock_ppm * 1e-6);
        (by_output_s - LATENCY_S) * self.rates[0].hz()
    }

    fn progress(&self) -> Option<PlayProgress> {
        let playing = self.playing.as_ref()?;
        self.progress_at(self.running.as_ref().map_or(playing.since, |run| run.at))
    }

    /// The progress when the run is at the sample `at`.
    fn progress_at(&self, at: u64) -> Option<PlayProgress> {
        let playing = self.playing.as_ref()?;
        if playing.ended.is_some() {
            return playing.ended;
        }
        let position = self.position(playing, at);
        let (played, underruns, ended) =
            playing
                .output
                .played(position, &self.script.underruns, self.rates[0].hz());
        Some(PlayProgress {
            played,
            underruns,
            ended,
        })
    }

    /// `progress`, where something was started and the output is there.
    fn said(&self, progress: Option<PlayProgress>) -> Result<PlayProgress, DeviceError> {
        let progress = progress.ok_or(DeviceError::Order {
            asked: "say how far it is",
            before: "started",
        })?;
        if !progress.ended {
            self.there(Half::Output)?;
        }
        Ok(progress)
    }

    /// What happens in the next `count` samples: drive, acceleration and force.
    fn advance(&mut self, count: u64) -> Vec<Vec<f64>> {
        let Some(mut run) = self.running.take() else {
            return Vec::new();
        };
        let mut playing = self.playing.take();
        let lost = self.script.lost.filter(|lost| lost.half == Half::Output);
        let mut channels = vec![Vec::new(); 3];
        for at in run.at..run.at + count {
            let now_s = (self.before + at) as f64 / self.input_hz();
            let silent = lost.is_some_and(|lost| now_s >= lost.after_s);
            let drive = match &mut playing {
                Some(playing) if playing.ended.is_none() && !silent => {
                    let position = self.position(playing, at);
                    playing.output.at(position)
                }
                _ => 0.0,
            };
            let [acceleration, force] = run.device.next(drive);
            for (channel, value) in channels.iter_mut().zip([drive, acceleration, force]) {
                channel.push(value);
            }
        }
        run.at += count;
        self.running = Some(run);
        self.playing = playing;
        channels
    }

    /// The sample of the run at which something that is scripted for `at_s` happens; none when it was before the run.
    fn place(&self, at_s: f64, since: TimeOrigin) -> Option<u64> {
        let at = (at_s * self.input_hz()).round() as u64;
        match since {
            TimeOrigin::Run => Some(at),
            TimeOrigin::Opened => at.checked_sub(self.before),
        }
    }

    /// Refuses to record where the script's input is full.
    fn has_room(&self) -> Result<(), DeviceError> {
        let after_s = self.now_s();
        match self.script.input_full_after_s {
            Some(full_s) if after_s >= full_s => Err(DeviceError::InputFull {
                name: "scripted fake".into(),
                after_s,
            }),
            _ => Ok(()),
        }
    }

    /// Loses samples without reporting them.
    fn hide(&mut self) {
        let hidden = (UNREPORTED_S * self.input_hz()).ceil() as u64;
        let _nobody_heard = self.advance(hidden);
        if let Some(run) = &mut self.running {
            run.hidden += hidden;
        }
    }

    /// The scripted breach of the contract, from the sample at which it happens on.
    fn breach_at(&self, at: u64) -> Option<Breach> {
        let fault = self.script.fault?;
        let from = self.place(fault.at_s, TimeOrigin::Run)?;
        (at >= from).then_some(fault.what)
    }

    /// How many samples `run` still has to deliver.
    fn left_at(&self, run: &Running, breach: Option<Breach>) -> u64 {
        let wanted = match run.plan.until {
            Until::Duration(duration) => Some(self.rates[1].samples_in(duration) as u64),
            Until::PlaybackEnded => run.ends_at,
            Until::Stopped => None,
        };
        let wanted = wanted.filter(|_| breach != Some(Breach::NeverEnds));
        wanted.map_or(u64::MAX, |wanted| wanted.saturating_sub(run.at))
    }

    /// The scripted delay that the next chunk of `run` has: its number, and s.
    fn late_at(&self, run: &Running) -> Option<(usize, f64)> {
        let late = self.script.late.iter().enumerate();
        let mut late = late.filter(|(i, late)| {
            !run.late.contains(i)
                && self
                    .place(late.at_s, TimeOrigin::Run)
                    .is_some_and(|l| run.at >= l)
        });
        late.next().map(|(i, late)| (i, late.by_s))
    }

    /// The sample after `at` at which the next thing happens: there a chunk ends.
    fn next_event(&self, gaps: &[(usize, u64, u64)], at: u64) -> Option<u64> {
        let gaps = gaps.iter().map(|(_, place, _)| *place);
        let ends = [
            self.script
                .lost
                .filter(|lost| lost.half == Half::Input)
                .map(|lost| lost.after_s),
            self.script.input_full_after_s,
        ];
        let ends = ends.into_iter().flatten();
        let ends = ends.filter_map(|at_s| self.place(at_s, TimeOrigin::Opened));
        let fault = self.script.fault;
        let fault = fault.and_then(|fault| self.place(fault.at_s, TimeOrigin::Run));
        gaps.chain(ends)
            .chain(fault)
            .filter(|place| *place > at)
            .min()
    }

    fn next(&mut self) -> Result<Next, DeviceError> {
        let rate_hz = self.input_hz();
        let run = self.running.as_ref().ok_or(DeviceError::Order {
            asked: "wait",
            before: "started",
        })?;
        if run.stop.is_stopped() {
            return Ok(Next::Chunk(None));
        }
        self.there(Half::Input)?;
        self.has_room()?;
        let (at, stop) = (run.at, run.stop.clone());
        let breach = self.breach_at(at);
        match breach {
            Some(Breach::EndsEarly) => return Ok(Next::Chunk(None)),
            Some(Breach::DeliversNothing) => return Ok(Next::Never(stop)),
            Some(Breach::DeliversEmpty) => {
                return Ok(Next::Chunk(Some(RunChunk {
                    first: at,
                    ..RunChunk::default()
                })));
            }
            _ => {}
        }
        let left = self.left_at(run, breach);
        if left == 0 {
            return Ok(Next::Chunk(None));
        }
        let late = self.late_at(run);
        let mut count = self.script.chunks_s[run.chunks % self.script.chunks_s.len()] * rate_hz;
        let mut faulty = None;
        if !run.faulty
            && let Some(breach) = breach
        {
            faulty = Some(breach);
            if breach == Breach::TooManySamples {
                count = TOO_LONG_S * rate_hz;
            }
        }
        let gap = self.script.drop_outs.iter().enumerate();
        let gaps: Vec<(usize, u64, u64)> = gap
            .filter(|(i, _)| !run.lost.contains(i))
            .filter_map(|(i, gap)| Some((i, self.place(gap.at_s, gap.since)?, gap.samples)))
            .collect();
        let due = gaps.iter().find(|(_, place, _)| at >= *place).copied();

        // Unless the fake runs in real time, a late chunk is preceded by an empty one.
        if let (Some((i, _)), Pace::Asked) = (late, self.script.pace) {
            if let Some(run) = &mut self.running {
                run.late.push(i);
            }
            let first = at - self.running.as_ref().map_or(0, |run| run.hidden);
            return Ok(Next::Chunk(Some(RunChunk {
                first,
                ..RunChunk::default()
            })));
        }
        let lost = due.map_or(0, |(_, _, samples)| samples.min(left));
        if lost > 0 {
            let _nobody_heard = self.advance(lost);
        }
        if faulty == Some(Breach::UnreportedGap) {
            self.hide();
        }
        let at = at + lost;
        let next = self.next_event(&gaps, at);
        let count = (count.round() as u64).max(1).min(left - lost);
        let count = match faulty {
            Some(_) => count,
            None => next.map_or(count, |next| count.min(next - at)),
        };
        let channels = self.advance(count);
        let Some(run) = &mut self.running else {
            return Ok(Next::Chunk(None));
        };
        run.chunks += 1;
        run.lost.extend(due.map(|(i, _, _)| i));
        run.late.extend(late.map(|(i, _)| i));
        let began = run.at - count;
        let mut chunk = RunChunk {
            first: began - run.hidden,
            device_s: Some(began as f64 / rate_hz),
            lost,
            channels,
            ..RunChunk::default()
        };
        if let Some(breach) = faulty {
            run.faulty = true;
            chunk = broken(chunk, &run.last, breach);
        }
        run.last = chunk.clone();
        if self.script.pace == Pace::Asked {
            return Ok(Next::Chunk(Some(chunk)));
        }
        let by_s = late.map_or(0.0, |(_, by_s)| by_s);
        let comes = Duration::from_secs_f64(run.at as f64 / rate_hz + by_s);
        let wait = comes.saturating_sub(run.began.elapsed());
        Ok(Next::After(wait, stop, chunk))
    }
}

/// A chunk with which a fake breaks the contract.
fn broken(mut chunk: RunChunk, last: &RunChunk, breach: Breach) -> RunChunk {
    match breach {
        Breach::ChannelMissing => {
            chunk.channels.pop();
        }
        Breach::UnequalChannels => {
            chunk.channels.last_mut().map(Vec::pop);
        }
        Breach::TimeBackwards => {
            chunk.device_s = chunk.device_s.map(|device_s| device_s - 1.0);
        }
        Breach::RepeatedChunk => return last.clone(),
        Breach::NotANumber => {
            if let Some(sample) = chunk.channels.iter_mut().flatten().next() {
                *sample = f64::NAN;
            }
        }
        Breach::TooManySamples
        | Breach::UnreportedGap
        | Breach::EndsEarly
        | Breach::NeverEnds
        | Breach::DeliversNothing
        | Breach::DeliversEmpty => {}
    }
    chunk
}

fn locked(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Player(Arc<Mutex<Shared>>);

impl Play for Player {
    fn describe(&self) -> PlayDescription {
        PlayDescription {
            name: NAME.into(),
            kind: BenchKind::Scripted,
            rate: locked(&self.0).rates[0],
            gain: None,
        }
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        locked(&self.0).there(Half::Output)?;
        Ok(None)
    }

    fn ready(
        &mut self,
        playback: Playback,
        _run: &RunPlan,
        _stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        shared.there(Half::Output)?;
        if playback.rate() != shared.rates[0] {
            return Err(DeviceError::Rate {
                drive: playback.rate(),
                output: shared.rates[0],
                name: NAME.into(),
            });
        }
        shared.loaded = Some(playback);
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        let playback = shared.loaded.take().ok_or(DeviceError::Order {
            asked: "play",
            before: "made ready",
        })?;
        shared.there(Half::Output)?;
        let rates = shared.rates.map(SampleRate::hz);
        shared.playing = Some(Playing {
            output: Output::new(playback, &shared.script.underruns, rates),
            since: shared.running.as_ref().map_or(0, |run| run.at),
            ended: None,
        });
        Ok(())
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        let shared = locked(&self.0);
        shared.said(shared.progress())
    }

    fn progress_after(&mut self, acquired: Seconds) -> Result<PlayProgress, DeviceError> {
        let shared = &mut *locked(&self.0);
        let at = (acquired.0 * shared.input_hz()) as u64;
        if let Some(mut playing) = shared.playing.take() {
            // How much drive there is up to then.
            let _unheard = playing.output.at(shared.position(&playing, at));
            shared.playing = Some(playing);
        }
        shared.said(shared.progress_at(at))
    }

    fn stop(&mut self) {
        let mut shared = locked(&self.0);
        shared.loaded = None;
        let progress = shared.progress();
        if let Some(playing) = &mut shared.playing {
            playing.ended = progress.map(|progress| PlayProgress {
                ended: true,
                ..progress
            });
        }
    }
}

struct Acquirer(Arc<Mutex<Shared>>);

impl Acquire for Acquirer {
    fn describe(&self) -> AcquireDescription {
        let shared = locked(&self.0);
        AcquireDescription {
            name: NAME.into(),
            kind: BenchKind::Scripted,
            rate: shared.rates[1],
            channels: vec![
                (DRIVE_CHANNEL.into(), Drive::UNIT),
                (ACCELERATION_CHANNEL.into(), Acceleration::UNIT),
                (FORCE_CHANNEL.into(), Force::UNIT),
            ],
            condition: Condition {
                participant: Some(shared.participant.clone()),
                touch: Some(Touch::Resting),
                ..Condition::default()
            },
            seed: Some(shared.script.seed),
            steps: vec![format!(
                "a resonance at {} Hz, {} ms late, noise of {} m/s² rms, clocks {:+} ppm apart",
                shared.script.device.resonance_hz,
                1e3 * shared.script.device.delay_s,
                shared.script.device.noise_m_s2,
                shared.script.clock_ppm
            )],
            answers_with: None,
        }
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        let shared = locked(&self.0);
        shared.there(Half::Input)?;
        Ok(SensorCalibration {
            offset: vec![0.0; 3],
            noise_rms: vec![0.0, shared.script.device.noise_m_s2, 0.0],
        })
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        shared.there(Half::Input)?;
        shared.planned = Some((run.clone(), stop.clone()));
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let mut shared = locked(&self.0);
        let planned = shared.planned.take();
        let (plan, stop) = planned.ok_or(DeviceError::Order {
            asked: "acquire",
            before: "made ready",
        })?;
        shared.there(Half::Input)?;
        shared.end();
        shared.playing = None;
        let what = format!("fake {} {}", shared.participant, plan.label);
        let device = Device::new(
            &shared.script.device,
            shared.input_hz(),
            plan.load.map_or(0.0, |load| load.0),
            Random::stream(shared.script.seed, 0, &what),
        );
        shared.running = Some(Running {
            plan,
            stop,
            device,
            began: Instant::now(),
            at: 0,
            hidden: 0,
            chunks: 0,
            ends_at: None,
            late: Vec::new(),
            lost: Vec::new(),
            faulty: false,
            last: RunChunk::default(),
        });
        Ok(())
    }

    fn longest_pause(&self) -> Seconds {
        Seconds(locked(&self.0).script.longest_pause_s)
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        // The lock is released while waiting, as the player needs it.
        let next = locked(&self.0).next()?;
        Ok(match next {
            Next::Chunk(chunk) => chunk,
            Next::After(wait, stop, chunk) => (!stop.wait(wait)).then_some(chunk),
            Next::Never(stop) => {
                while !stop.wait(Duration::from_secs_f64(LOOKS_EVERY_S)) {}
                None
            }
        })
    }

    fn playback_ended(&mut self) {
        let shared = &mut *locked(&self.0);
        let rest = (REST_S * shared.input_hz()).round() as u64;
        if let Some(run) = &mut shared.running {
            run.ends_at.get_or_insert(run.at + rest);
        }
    }

    fn stop(&mut self) {
        locked(&self.0).end();
    }
}

impl Shared {
    /// Ends what runs; what was acquired counts for the time since the bench was opened.
    fn end(&mut self) {
        self.planned = None;
        let progress = self.progress();
        if let Some(run) = self.running.take() {
            self.before += run.at;
            if let Some(playing) = &mut self.playing {
                playing.ended = progress.map(|progress| PlayProgress {
                    ended: true,
                    ..progress
                });
            }
        }
    }
}
