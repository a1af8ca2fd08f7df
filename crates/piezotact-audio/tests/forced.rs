//! A run whose force comes from a file that another program appends to.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::io::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use piezotact::device::DeviceDescription;
use piezotact::quantity::{Degrees, Force, Newtons, Seconds};
use piezotact::recording::{BenchKind, Recording};
use piezotact::run::RunCollector;
use piezotact_audio::{AudioBench, LoopIo, SoundSetup};
use piezotact_bench::procedure::{acquire, record};
use piezotact_bench::{Bench, Placement, RunPlan, StopHandle, Until};

fn bench(file: &std::path::Path) -> Bench {
    let text = format!(
        r#"
        host = "loop"
        rate_hz = 48000
        buffer_frames = 256
        play = {{ drive = [1] }}
        record = [{{ channel = 1, measures = "drive" }}]
        force = {{ file = {file:?}, unit = "mN" }}
        loop = {{ pace = "real_time" }}
        "#
    );
    let setup = SoundSetup::from_toml(&text).unwrap();
    let mut io = LoopIo::new(&setup, None).unwrap();
    let bench = AudioBench {
        setup,
        calibration: None,
        latency: None,
        device: DeviceDescription::drv2667().at_usual_gain(),
        participant: None,
        twin_seed: None,
        kind: BenchKind::Scripted,
        today: 0,
    };
    bench.open(&mut io).unwrap()
}

fn plan(duration_s: f64) -> RunPlan {
    RunPlan {
        label: "held".into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::Duration(Seconds(duration_s)),
    }
}

/// Appends 80 readings per second for `for_s`, or until the flag is set.
fn cell(file: &std::path::Path, for_s: f64) -> (Arc<AtomicBool>, std::thread::JoinHandle<()>) {
    let stop = Arc::new(AtomicBool::new(false));
    let (stopped, file) = (Arc::clone(&stop), file.to_owned());
    std::fs::write(&file, "time_ms,force_mN\n").unwrap();
    let appends = move || {
        let began = Instant::now();
        let mut out = std::fs::OpenOptions::new()
            .append(true)
            .open(&file)
            .unwrap();
        while !stopped.load(Ordering::Acquire) && began.elapsed().as_secs_f64() < for_s {
            let ms = began.elapsed().as_millis();
            // A slow ramp: 200 mN and 10 mN a second.
            let mn = 200.0 + 0.01 * ms as f64;
            writeln!(out, "{ms},{mn}").unwrap();
            std::thread::sleep(Duration::from_micros(12_500));
        }
    };
    (stop, std::thread::spawn(appends))
}

#[test]
fn the_force_of_another_source_stands_beside_the_channels() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("force.csv");
    let (stop, thread) = cell(&file, 60.0);
    let mut bench = bench(&file);
    let recording: Recording = record(bench.acquirer.as_mut(), &plan(3.0)).unwrap();
    stop.store(true, Ordering::Release);
    thread.join().unwrap();
    let force = recording.series::<Force>(None).unwrap();
    let samples = force.samples();
    assert_eq!(samples.len(), 144_000);
    assert!(samples.iter().all(|n| (0.2..0.35).contains(n)));
    // 10 mN a second; times of readings are certain to 50 ms here at worst, on a busy machine.
    let rise = samples[143_000] - samples[1_000];
    let expected = 0.01 * 142_000.0 / 48_000.0;
    assert!(
        (rise - expected).abs() < 2.0 * 0.05 * 0.01,
        "{rise} {expected}"
    );
}

#[test]
fn a_source_that_stops_talking_ends_the_run_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("force.csv");
    let (_stop, thread) = cell(&file, 2.5);
    let mut bench = bench(&file);
    let mut kept = RunCollector::default();
    let error = acquire(
        bench.acquirer.as_mut(),
        &plan(30.0),
        &StopHandle::new(),
        &mut kept,
    );
    thread.join().unwrap();
    let said = error.unwrap_err().to_string();
    assert!(said.contains("force.csv"), "{said}");
    // What was recorded until then is there.
    let recording = kept.recording().unwrap();
    assert!(recording.duration().0 > 1.0, "{}", recording.duration());
}
