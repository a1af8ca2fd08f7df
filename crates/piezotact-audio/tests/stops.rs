//! A person stops what a device plays, while whatever keeps the run writes to a disk that stalls: the callback silences the output itself.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use piezotact::Series;
use piezotact::device::DeviceDescription;
use piezotact::quantity::{Degrees, Drive, Newtons};
use piezotact::recording::{BenchKind, Event};
use piezotact::run::{Discard, Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact::sound::DeviceListing;
use piezotact_audio::{
    AudioBench, AudioError, AudioIo, Board, InputCallback, OutputCallback, StreamPlan, Streams,
};
use piezotact_bench::procedure::{RunKeeper, play_and_record};
use piezotact_bench::{
    Bench, Placement, PlayProgress, Playback, ProcedureError, RunPlan, StopHandle, Until,
};

use super::loops::setup;

const RATE_HZ: f64 = 48_000.0;
const BUFFER: usize = 256;
/// The sink waits so long, and the stop comes so long after it began to.
const STALLS: Duration = Duration::from_secs(2);
const STOPS_AFTER: Duration = Duration::from_millis(300);
/// The output is silent within this time of a stop, s.
const WITHIN_S: f64 = 0.1;
const LEVEL: f64 = 0.5;

/// What the output gave out, on its first channel.
type Heard = Arc<Mutex<Vec<f32>>>;

/// A device in real time, or as fast as it can where it hurries, that shows what it was given, and records silence.
struct Heeding(Heard, Arc<AtomicBool>);

struct Running(Arc<AtomicBool>, Option<JoinHandle<()>>);

impl AudioIo for Heeding {
    fn devices(&self) -> Result<Vec<DeviceListing>, AudioError> {
        Ok(Vec::new())
    }

    fn open(
        &mut self,
        _plan: &StreamPlan,
        mut output: OutputCallback,
        mut input: InputCallback,
        _board: &Arc<Board>,
    ) -> Result<Box<dyn Streams>, AudioError> {
        let (heard, hurries) = (Arc::clone(&self.0), Arc::clone(&self.1));
        let over = Arc::new(AtomicBool::new(false));
        let closed = Arc::clone(&over);
        let channels = output.channels();
        let taken = vec![0.0; BUFFER * input.channels()];
        let serves = move || {
            let mut out = vec![0.0; BUFFER * channels];
            let mut due = Instant::now();
            while !closed.load(Ordering::Acquire) {
                output.fill(&mut out);
                let first = out.chunks(channels).map(|frame| frame[0]);
                heard.lock().unwrap().extend(first);
                input.take(&taken);
                if hurries.load(Ordering::Acquire) {
                    due = Instant::now();
                    continue;
                }
                due += Duration::from_secs_f64(BUFFER as f64 / RATE_HZ);
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
        };
        Ok(Box::new(Running(over, Some(std::thread::spawn(serves)))))
    }
}

impl Streams for Running {
    fn wait(&mut self, at_most: Duration, stop: &StopHandle) {
        let _stopped = stop.wait(at_most);
    }

    fn run_by_themselves(&self) -> bool {
        true
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
        self.1.take().unwrap().join().unwrap();
    }
}

/// Waits with samples of the drive, and has the run stopped from another thread meanwhile; the frame of the output at the stop.
struct Stalling {
    stop: StopHandle,
    heard: Heard,
    stopped_at: Arc<Mutex<Option<usize>>>,
}

struct Stalled<'a>(&'a Stalling, bool);

impl RunKeeper for Stalling {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Stalled(self, false)))
    }
}

impl Sink for Stalled<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let RunDocument::Chunk(chunk) = document else {
            return Ok(None);
        };
        if !self.1 && chunk.first as f64 > 0.5 * RATE_HZ {
            self.1 = true;
            let stop = self.0.stop.clone();
            let (heard, stopped_at) = (Arc::clone(&self.0.heard), Arc::clone(&self.0.stopped_at));
            std::thread::spawn(move || {
                std::thread::sleep(STOPS_AFTER);
                let heard = heard.lock().unwrap();
                stop.stop();
                *stopped_at.lock().unwrap() = Some(heard.len());
            });
            std::thread::sleep(STALLS);
        }
        Ok(None)
    }
}

fn bench(heard: &Heard, hurries: &Arc<AtomicBool>) -> Bench {
    let bench = AudioBench {
        setup: setup(""),
        calibration: None,
        device: DeviceDescription::drv2667().at_usual_gain(),
        participant: None,
        latency: None,
        twin_seed: None,
        kind: BenchKind::Scripted,
        today: 0,
    };
    let mut io = Heeding(Arc::clone(heard), Arc::clone(hurries));
    bench.open(&mut io).unwrap()
}

fn run() -> RunPlan {
    RunPlan {
        label: "texture".into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

/// Fades out from one sample to the next at most as 5 ms at 48 kHz do, and stays silent.
fn is_faded_out(heard: &[f32]) -> bool {
    let step = (LEVEL / (0.005 * RATE_HZ) * 1.01) as f32;
    let falls = |pair: &[f32]| (0.0..=step).contains(&(pair[0] - pair[1]));
    heard.windows(2).all(falls) && heard.last() == Some(&0.0)
}

#[test]
fn a_stop_silences_the_output_while_the_sink_waits() {
    let heard = Heard::default();
    let mut bench = bench(&heard, &Arc::default());
    let drive = Series::<Drive>::new(vec![LEVEL; 240_000], bench.player.describe().rate).unwrap();
    let stopped_at = Arc::default();
    let mut keeper = Stalling {
        stop: bench.stop.clone(),
        heard: Arc::clone(&heard),
        stopped_at: Arc::clone(&stopped_at),
    };
    let done = play_and_record(&mut bench, &drive, None, &run(), &mut keeper, None);
    assert!(
        matches!(done, Err(ProcedureError::Stopped { .. })),
        "{done:?}"
    );
    let progress = bench.player.progress().unwrap();
    drop(bench);
    let (heard, stopped_at) = (heard.lock().unwrap(), stopped_at.lock().unwrap().unwrap());
    let after = &heard[stopped_at..];
    let silent = after.iter().position(|sample| *sample == 0.0).unwrap();
    let late_s = silent as f64 / RATE_HZ;
    assert!(late_s < WITHIN_S, "silent {late_s:.3} s after the stop");
    assert!(is_faded_out(&heard[stopped_at - 1..]));
    // It says how much was given out, up to the fade's last sample.
    let given = heard.iter().filter(|sample| **sample != 0.0).count() as u64;
    assert!(
        progress.ended && progress.played - given <= 1,
        "{progress:?}, {given}"
    );
}

/// A drive that is stopped before its first sample never sounds; the next one, with a handle of its own, does.
#[test]
fn a_stop_is_of_its_own_run_alone() {
    let heard = Heard::default();
    let mut bench = bench(&heard, &Arc::default());
    let rate = bench.player.describe().rate;
    let mut play = |stop: &StopHandle, stops: bool| -> PlayProgress {
        let drive = Series::<Drive>::new(vec![LEVEL; 4_800], rate).unwrap();
        bench.acquirer.ready(&run(), stop).unwrap();
        let playback = Playback::Whole(drive);
        bench.player.ready(playback, &run(), stop).unwrap();
        bench.acquirer.start().unwrap();
        bench.player.start().unwrap();
        if stops {
            stop.stop();
        }
        // It begins 0.2 s after the start.
        std::thread::sleep(Duration::from_millis(500));
        let progress = bench.player.progress().unwrap();
        bench.player.stop();
        bench.acquirer.stop();
        progress
    };
    let parent = StopHandle::new();
    let stopped = play(&parent.child().child(), true);
    assert!(stopped.ended && stopped.played == 0, "{stopped:?}");
    assert!(heard.lock().unwrap().iter().all(|sample| *sample == 0.0));
    let whole = play(&parent.child().child(), false);
    assert!(whole.ended && whole.played == 4_800, "{whole:?}");
}

/// Between two playings a person thinks for longer than recorded frames have room.
#[test]
fn a_device_that_waited_for_an_answer_plays_again() {
    let (heard, hurries) = (Heard::default(), Arc::new(AtomicBool::new(true)));
    let mut bench = bench(&heard, &hurries);
    let drive = Series::<Drive>::new(vec![LEVEL; 9_600], bench.player.describe().rate).unwrap();
    while heard.lock().unwrap().len() < 20 * RATE_HZ as usize {
        std::thread::sleep(Duration::from_millis(5));
    }
    hurries.store(false, Ordering::Release);
    let recording = play_and_record(&mut bench, &drive, None, &run(), &mut Discard, None);
    let recording = recording.unwrap();
    let events = &recording.annotations.events;
    let lost = |event: &Event| event.kind == "samples_lost";
    assert!(!events.iter().any(lost), "{events:?}");
    let onset = events.iter().find(|event| event.kind == "playback_onset");
    // The drive begins 0.2 s after the run, up to some buffers.
    let onset_s = onset.unwrap().onset_s.0;
    assert!((0.15..0.5).contains(&onset_s), "{events:?}");
}
