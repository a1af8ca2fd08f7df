//! The sound device over a `PipeWire` server whose null sink is its own source, through ALSA, in real time. Run by `./x test` as a step of its own,
//! which starts the server; ignored elsewhere.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a test fails where it cannot go on; the log of ./x test has the figures, and what was not decided"
)]

use piezotact::Series;
use piezotact::quantity::{Drive, Seconds};
use piezotact::sound::{delay, loop_residual};
use piezotact::statistics::random::Random;
use piezotact_audio::{Happened, HardwareIo, Loaded, SoundSetup, latency_run};
use piezotact_bench::{Playback, StopHandle};

fn setup() -> SoundSetup {
    let text = r#"
        host = "alsa"
        output = "pipewire"
        input = "pipewire"
        rate_hz = 48000
        buffer_frames = 1024
        play = { drive = [1], channels = 2 }
        record = [
            { channel = 1, measures = "drive" },
            { channel = 2, measures = "acceleration" },
        ]
    "#;
    SoundSetup::from_toml(text).unwrap()
}

#[test]
#[ignore = "needs the PipeWire server that ./x test starts"]
fn pipewire_what_is_recorded_is_what_was_played() {
    let mut last = String::new();
    for attempt in 0..3 {
        let mut io = HardwareIo::new("alsa").unwrap();
        let mut streams = setup().open_streams(&mut io).unwrap();
        let stop = StopHandle::new();
        // The server sets up its connections first.
        for _ in 0..20 {
            streams.fetch(2_400, 48_000, &stop).unwrap();
        }
        let mut random = Random::stream(attempt, 0, "pipewire");
        let draw = |_| f64::from((0.2 * random.normal()).clamp(-1.0, 1.0) as f32);
        let played: Vec<f64> = (0..20 * 48_000).map(draw).collect();
        streams.skip();
        let onset = streams.next_onset(Seconds(0.1));
        let drive = Series::<Drive>::new(played.clone(), streams.rate()).unwrap();
        streams
            .play_at(onset, Loaded::of(Playback::Whole(drive), &stop))
            .unwrap();
        let (mut samples, mut lost) = (Vec::new(), 0);
        while samples.len() < 21 * 48_000 {
            let fetched = streams.fetch(1, 48_000, &stop).unwrap().unwrap();
            lost += fetched.lost;
            samples.extend(fetched.channels[0].iter().map(|v| f64::from(*v)));
        }
        let happened = streams.take_happened();
        let dry = happened
            .iter()
            .filter(|h| matches!(h, Happened::RanDry { .. }))
            .count();
        if lost > 0 || dry > 0 {
            last = format!("{lost} frames lost, {dry} times dry");
            continue;
        }
        let found = delay(&played, &samples).unwrap();
        let residual = loop_residual(&played, &samples, &found, 1e-7);
        println!(
            "delay {} samples, gain {}, residual {}",
            found.samples, found.gain, residual.largest
        );
        assert!((found.gain - 1.0).abs() < 1e-6, "{found:?}");
        assert!(
            residual.largest < 1e-6 && residual.different == 0,
            "{residual:?}"
        );
        return;
    }
    // A busy machine is no fault of the program, and no proof of it either.
    eprintln!(
        "NOT DECIDED: {last} in the last of three attempts; run ./x test on a machine that does nothing else"
    );
}

/// Streams that start again have another latency: buffers of the server lie between them.
#[test]
#[ignore = "needs the PipeWire server that ./x test starts"]
fn pipewire_restarts_have_a_latency() {
    let setup = setup();
    let mut found = Vec::new();
    for number in 0..5 {
        let mut streams = setup
            .open_streams(&mut HardwareIo::new("alsa").unwrap())
            .unwrap();
        let run = latency_run(&mut streams, &setup, number).unwrap();
        found.extend(run.latency_s.map(|latency| latency.0));
    }
    println!("latencies {found:?} s");
    assert!(found.len() >= 3, "{found:?}");
    assert!(found.iter().all(|s| (0.005..1.0).contains(s)), "{found:?}");
}
