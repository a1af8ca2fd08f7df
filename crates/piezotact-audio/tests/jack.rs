//! The sound device over a JACK server in user space, whose ports are connected so that what is played is recorded: exact to the sample. Run by
//! `./x test` as a step of its own, which starts the server; ignored elsewhere.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a test fails where it cannot go on; the log of ./x test has the figures, and what was not decided"
)]

use std::process::Command;
use std::time::Duration;

use piezotact::Series;
use piezotact::quantity::{Drive, Seconds};
use piezotact::sound::{delay, loop_residual};
use piezotact::statistics::random::Random;
use piezotact_audio::{
    AudioIo as _, Fetched, Happened, HardwareIo, Loaded, RunningStreams, SoundSetup,
};
use piezotact_bench::{Playback, StopHandle};

/// The frames of a buffer of the server that the step starts.
const BUFFER: u32 = 1024;

fn setup(rate_hz: u32, buffer_frames: u32) -> Result<SoundSetup, String> {
    let text = format!(
        r#"
        host = "jack"
        output = "output"
        input = "input"
        rate_hz = {rate_hz}
        buffer_frames = {buffer_frames}
        play = {{ drive = [1] }}
        record = [{{ channel = 1, measures = "drive" }}]
        "#
    );
    SoundSetup::from_toml(&text).map_err(|error| error.to_string())
}

/// The streams, with the port of their output connected to that of their input.
fn looped() -> RunningStreams {
    let setup = setup(48_000, BUFFER).unwrap();
    let streams = setup
        .open_streams(&mut HardwareIo::new("jack").unwrap())
        .unwrap();
    let listed = Command::new("jack_lsp")
        .output()
        .expect("jack_lsp of the package jackd2");
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let own = |end: &str| {
        let found = listed
            .lines()
            .find(|line| line.contains(&std::process::id().to_string()) && line.ends_with(end));
        found
            .unwrap_or_else(|| panic!("no port {end} of this process among\n{listed}"))
            .to_owned()
    };
    let (output, input) = (own("out_0"), own("in_0"));
    // What the server connects by itself would be heard beside it.
    let _not_connected = Command::new("jack_disconnect")
        .args(["system:capture_1", &input])
        .output();
    let connected = Command::new("jack_connect")
        .args([&output, &input])
        .status();
    assert!(
        connected
            .expect("jack_connect of the package jackd2")
            .success()
    );
    std::thread::sleep(Duration::from_millis(100));
    streams
}

fn whole(samples: Vec<f64>, streams: &RunningStreams) -> Loaded {
    let drive = Series::<Drive>::new(samples, streams.rate()).unwrap();
    Loaded::of(Playback::Whole(drive), &StopHandle::new())
}

fn fetch(streams: &mut RunningStreams, most: usize) -> Fetched {
    streams.fetch(1, most, &StopHandle::new()).unwrap().unwrap()
}

/// Three attempts met losses, so that nothing was compared: a busy machine is no fault of the program, and no proof of it either.
#[allow(
    clippy::print_stderr,
    reason = "the log of ./x test says what was not decided"
)]
fn not_decided(last: &str) {
    eprintln!(
        "NOT DECIDED: {last} in the last of three attempts; run ./x test on a machine that does nothing else"
    );
}

/// Sixty seconds, without a loss: those of a busy machine are repeated.
#[test]
#[ignore = "needs the JACK server that ./x test starts"]
fn jack_what_is_recorded_is_what_was_played() {
    let mut last = String::new();
    for attempt in 0..3 {
        let mut streams = looped();
        let mut random = Random::stream(attempt, 0, "jack");
        let draw = |_| f64::from((0.2 * random.normal()).clamp(-1.0, 1.0) as f32);
        let played: Vec<f64> = (0..60 * 48_000).map(draw).collect();
        streams.skip();
        let onset = streams.next_onset(Seconds(0.1));
        let drive = whole(played.clone(), &streams);
        streams.play_at(onset, drive).unwrap();
        let (mut samples, mut lost) = (Vec::new(), 0);
        while samples.len() < 61 * 48_000 {
            let fetched = fetch(&mut streams, 48_000);
            lost += fetched.lost;
            samples.extend(fetched.channels[0].iter().map(|v| f64::from(*v)));
        }
        let dry = streams
            .take_happened()
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
        assert!((found.gain - 1.0).abs() < 1e-9, "{found:?}");
        // Gain 1 is exact; what is left is the rounding of the gain that was found.
        assert!(
            residual.largest < 1e-9 && residual.different == 0,
            "{residual:?}"
        );
        return;
    }
    not_decided(&last);
}

#[test]
#[ignore = "needs the JACK server that ./x test starts"]
fn jack_onsets_are_where_they_were_asked_for() {
    let mut last = String::new();
    for attempt in 0..3 {
        let mut streams = looped();
        let mut random = Random::stream(attempt, 0, "jack onsets");
        let origin = streams.skip();
        let (mut wanted, mut samples, mut lost) = (Vec::new(), Vec::new(), 0);
        for _ in 0..1_000 {
            let onset = streams.next_onset(Seconds(0.03)) + (random.uniform() * 1_500.0) as u64;
            let pulse = whole(vec![0.8, -0.4], &streams);
            let piece = streams.play_at(onset, pulse).unwrap();
            wanted.push(onset);
            while !streams.progress(piece).ended {
                let fetched = fetch(&mut streams, 4_096);
                lost += fetched.lost;
                samples.extend(fetched.channels[0].clone());
            }
        }
        while samples.len() < 48_000 || samples[samples.len() - 24_000..].iter().any(|v| *v > 0.3) {
            samples.extend(fetch(&mut streams, 4_096).channels[0].clone());
        }
        let mut onsets = Vec::new();
        for happened in streams.take_happened() {
            match happened {
                Happened::Onset { frame, .. } => onsets.push(frame),
                Happened::RanDry { frames, .. } | Happened::Lost { frames, .. } => lost += frames,
            }
        }
        let heard: Vec<u64> = (0..samples.len())
            .filter(|i| samples[*i] > 0.5)
            .map(|i| i as u64 + origin)
            .collect();
        if lost > 0 || onsets != wanted || heard.len() != wanted.len() {
            last = format!(
                "{lost} frames lost, {} of {} onsets heard",
                heard.len(),
                wanted.len()
            );
            continue;
        }
        let delays: Vec<i64> = heard
            .iter()
            .zip(&wanted)
            .map(|(h, w)| *h as i64 - *w as i64)
            .collect();
        println!("1000 onsets, {} frames after the output", delays[0]);
        assert!(delays.iter().all(|delay| *delay == delays[0]), "{delays:?}");
        return;
    }
    not_decided(&last);
}

#[test]
#[ignore = "needs the JACK server that ./x test starts"]
fn jack_what_the_server_does_not_offer_is_refused() {
    let open = |rate_hz, buffer_frames| {
        let setup = setup(rate_hz, buffer_frames).unwrap();
        let opened = setup.open_streams(&mut HardwareIo::new("jack").unwrap());
        opened
            .expect_err("what the server does not offer")
            .to_string()
    };
    for (rate_hz, buffer_frames) in [(44_100, BUFFER), (48_000, 512)] {
        let said = open(rate_hz, buffer_frames);
        assert!(said.contains("48000 Hz") && said.contains("1024"), "{said}");
    }
    let listed = HardwareIo::new("jack").unwrap().devices().unwrap();
    let ids: Vec<&str> = listed.iter().map(|device| device.id.as_str()).collect();
    assert!(ids.contains(&"input") && ids.contains(&"output"), "{ids:?}");
    let mut other = setup(48_000, BUFFER).unwrap();
    other.output = "speakers".into();
    let said = other
        .open_streams(&mut HardwareIo::new("jack").unwrap())
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("`speakers`") && said.contains("output"),
        "{said}"
    );
    assert!(
        HardwareIo::new("asio")
            .unwrap_err()
            .to_string()
            .contains("alsa")
    );
}
