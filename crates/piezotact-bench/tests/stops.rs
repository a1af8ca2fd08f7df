//! A person stops what a simulated bench plays in real time, while whatever keeps the run writes to a disk that stalls: the output ends at
//! the time of the stop by the clock of the bench.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use num_complex::Complex;
use piezotact::Series;
use piezotact::quantity::{Acceleration, Degrees, Drive, Newtons, SampleRate};
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::fake::{FakeScript, fake};
use piezotact_bench::measured::{MeasuredBench, SensorNoise};
use piezotact_bench::procedure::{RunKeeper, play_and_record};
use piezotact_bench::{Bench, Placement, ProcedureError, RunPlan, StopHandle, Until};

const OUTPUT_HZ: f64 = 48_000.0;
/// The stop comes so long after the sink began to wait.
const STOPS_AFTER: Duration = Duration::from_millis(400);
/// The output ends within this time of a stop, s.
const WITHIN_S: f64 = 0.1;

/// When the run began, and when it was stopped.
type Times = Arc<Mutex<[Option<Instant>; 2]>>;

/// Waits for `stalls` with the first samples it gets, and has the run stopped from another thread meanwhile.
struct Stalling {
    stop: StopHandle,
    stalls: Duration,
    times: Times,
}

struct Stalled<'a>(&'a mut Stalling, bool);

impl RunKeeper for Stalling {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Stalled(self, false)))
    }
}

impl Sink for Stalled<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        match document {
            RunDocument::Start(_) => self.0.times.lock().unwrap()[0] = Some(Instant::now()),
            RunDocument::Chunk(chunk) if !self.1 && chunk.first > 0 => {
                self.1 = true;
                let (stop, times) = (self.0.stop.clone(), Arc::clone(&self.0.times));
                std::thread::spawn(move || {
                    std::thread::sleep(STOPS_AFTER);
                    times.lock().unwrap()[1] = Some(Instant::now());
                    stop.stop();
                });
                std::thread::sleep(self.0.stalls);
            }
            _ => {}
        }
        Ok(None)
    }
}

fn measured() -> Bench {
    let hand = TransferFunction::<Drive, Acceleration>::from_lines(
        vec![Complex::from(8.0); 513],
        vec![1.0; 513],
        2_500.0 / 512.0,
        SampleRate::new(5_000.0).unwrap(),
        Estimator::H1,
        100,
    );
    let noise = SensorNoise {
        rms_m_s2: 0.002,
        seed: 7,
    };
    let bench = MeasuredBench::new(hand.unwrap(), "hand.json", noise);
    bench.unwrap().into_bench()
}

fn scripted() -> Bench {
    fake(FakeScript::from_toml("chunks_s = [0.9]").unwrap(), "F01").unwrap()
}

/// How long after a stop the output of `bench` ended by its clock, s; `latency_s` is from the start of a run to its first sample.
fn ended_after_s(bench: Bench, latency_s: f64, stalls: Duration) -> f64 {
    let mut bench = bench.in_real_time();
    let rate = SampleRate::new(OUTPUT_HZ).unwrap();
    let drive = Series::<Drive>::new(vec![0.3; 5 * 48_000], rate).unwrap();
    let run = RunPlan {
        label: "texture".into(),
        load: Some(Newtons(0.4)),
        angle: Degrees(30.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    };
    let times = Times::default();
    let mut keeper = Stalling {
        stop: bench.stop.clone(),
        stalls,
        times: Arc::clone(&times),
    };
    let done = play_and_record(&mut bench, &drive, None, &run, &mut keeper, None);
    assert!(
        matches!(done, Err(ProcedureError::Stopped { .. })),
        "{done:?}"
    );
    let progress = bench.player.progress().unwrap();
    assert!(progress.ended, "{progress:?}");
    let [began, stopped] = times.lock().unwrap().map(Option::unwrap);
    let ended_s = latency_s + progress.played as f64 / OUTPUT_HZ;
    ended_s - (stopped - began).as_secs_f64()
}

#[test]
fn a_simulated_output_ends_at_the_stop_whatever_the_sink_does() {
    for stalls_s in [0, 2] {
        for (what, bench, latency_s) in [("measured", measured(), 0.2), ("fake", scripted(), 0.05)]
        {
            let late_s = ended_after_s(bench, latency_s, Duration::from_secs(stalls_s));
            assert!(
                late_s.abs() < WITHIN_S,
                "{what}, a sink that waits {stalls_s} s: the output ended {late_s:.3} s after the stop"
            );
        }
    }
}
