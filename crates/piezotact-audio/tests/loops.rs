//! Streams over the loop: what is recorded is what was played, and what fails is counted.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::time::{Duration, Instant};

use piezotact::Series;
use piezotact::quantity::{Hertz, Seconds};
use piezotact::sound::{Exciter, InputCalibration, delay, loop_residual};
use piezotact::statistics::random::Random;
use piezotact_audio::{
    AudioError, Happened, Loaded, LoopIo, RunningStreams, SoundSetup, latency_run,
    measured_loopback, record_tone, wires,
};
use piezotact_bench::{DeviceError, Playback, StopHandle};

pub(super) fn setup(looped: &str) -> SoundSetup {
    setup_at(48_000.0, looped)
}

pub(super) fn setup_at(rate_hz: f64, looped: &str) -> SoundSetup {
    let text = format!(
        r#"
        host = "loop"
        rate_hz = {rate_hz}
        buffer_frames = 256
        play = {{ drive = [1, 2], trigger = 3 }}
        record = [
            {{ channel = 1, measures = "drive" }},
            {{ channel = 2, measures = "acceleration", mv_per_m_s2 = 10.2 }},
        ]
        [loop]
        {looped}
        "#
    );
    SoundSetup::from_toml(&text).unwrap()
}

fn opened(setup: &SoundSetup) -> RunningStreams {
    setup
        .open_streams(&mut LoopIo::new(setup, None).unwrap())
        .unwrap()
}

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::stream(seed, 0, "loop");
    // As it is played: rounded to 32 bits, within full scale.
    (0..count)
        .map(|_| f64::from((0.2 * random.normal()).clamp(-1.0, 1.0) as f32))
        .collect()
}

fn whole(samples: Vec<f64>, streams: &RunningStreams) -> Loaded {
    let drive = Series::new(samples, streams.rate()).unwrap();
    Loaded::of(Playback::Whole(drive), &StopHandle::new())
}

/// Records `frames` of the first input.
fn recorded(streams: &mut RunningStreams, frames: usize) -> (Vec<f64>, u64) {
    let (mut samples, mut lost) = (Vec::new(), 0);
    let stop = StopHandle::new();
    while samples.len() < frames {
        let fetched = streams
            .fetch(1, frames - samples.len(), &stop)
            .unwrap()
            .unwrap();
        lost += fetched.lost;
        samples.extend(fetched.channels[0].iter().map(|v| f64::from(*v)));
    }
    (samples, lost)
}

#[test]
fn what_is_recorded_is_what_was_played() {
    let mut streams = opened(&setup("noise = 0\ndelay_frames = 700"));
    let played = noise(200_000, 1);
    streams.skip();
    let onset = streams.next_onset(Seconds(0.01));
    let drive = whole(played.clone(), &streams);
    streams.play_at(onset, drive).unwrap();
    let (samples, lost) = recorded(&mut streams, 220_000);
    let found = delay(&played, &samples).unwrap();
    assert_eq!(lost, 0);
    // The gain of a half is exact in binary.
    assert!((found.gain - 0.5).abs() < 1e-12, "{found:?}");
    let residual = loop_residual(&played, &samples, &found, 1e-7);
    assert!(
        residual.largest == 0.0 && residual.different == 0,
        "{residual:?}"
    );
}

#[test]
fn onsets_are_where_they_were_asked_for() {
    let mut streams = opened(&setup("noise = 0\ndelay_frames = 300"));
    let mut random = Random::stream(5, 0, "onsets");
    streams.skip();
    let origin = streams.skip();
    let (mut wanted, mut samples) = (Vec::new(), Vec::new());
    let stop = StopHandle::new();
    for _ in 0..1_000 {
        // Anywhere within a buffer or behind it.
        let onset = streams.next_onset(Seconds(0.0)) + (random.uniform() * 700.0) as u64;
        let pulse = whole(vec![0.8, -0.4], &streams);
        let piece = streams.play_at(onset, pulse).unwrap();
        wanted.push(onset);
        while !streams.progress(piece).ended {
            let fetched = streams.fetch(1, 4_096, &stop).unwrap().unwrap();
            samples.extend(fetched.channels[0].clone());
        }
    }
    for _ in 0..20 {
        samples.extend(streams.fetch(1, 4_096, &stop).unwrap().unwrap().channels[0].clone());
    }
    let happened = streams.take_happened();
    let onsets: Vec<u64> = happened
        .iter()
        .filter_map(|h| match h {
            Happened::Onset { frame, .. } => Some(*frame),
            _ => None,
        })
        .collect();
    assert_eq!(onsets, wanted);
    let heard: Vec<u64> = (0..samples.len())
        .filter(|i| samples[*i] > 0.3)
        .map(|i| i as u64 + origin)
        .collect();
    assert_eq!(heard.len(), wanted.len());
    let delays: Vec<u64> = heard.iter().zip(&wanted).map(|(h, w)| h - w).collect();
    assert!(delays.iter().all(|delay| *delay == delays[0]), "{delays:?}");
}

#[test]
fn a_drive_that_is_made_while_it_plays_comes_whole() {
    struct Made(Vec<f64>, usize, piezotact::quantity::SampleRate);
    impl piezotact_bench::DriveSource for Made {
        fn rate(&self) -> piezotact::quantity::SampleRate {
            self.2
        }
        fn next_samples(&mut self, count: usize) -> Vec<f64> {
            let to = (self.1 + count).min(self.0.len());
            let next = self.0[self.1..to].to_vec();
            self.1 = to;
            next
        }
    }
    let mut streams = opened(&setup("noise = 0"));
    let played = noise(480_000, 3);
    let source = Made(played.clone(), 0, streams.rate());
    let made = Loaded::of(Playback::Made(Box::new(source)), &StopHandle::new());
    let piece = streams.play_at(0, made).unwrap();
    let (samples, _) = recorded(&mut streams, 500_000);
    let found = delay(&played, &samples).unwrap();
    let residual = loop_residual(&played, &samples, &found, 1e-7);
    assert_eq!(residual.different, 0, "{residual:?}");
    let progress = streams.progress(piece);
    assert!(progress.ended && progress.played == 480_000, "{progress:?}");
}

#[test]
fn losses_of_the_input_keep_its_clock() {
    let faults = "noise = 0\nfaults = [{ what = \"overrun\", at_s = 0.5, for_s = 0.02 }]";
    let mut streams = opened(&setup(faults));
    let played = noise(96_000, 4);
    let drive = whole(played.clone(), &streams);
    streams.play_at(4_800, drive).unwrap();
    let stop = StopHandle::new();
    let (mut samples, mut losses) = (Vec::new(), Vec::new());
    while samples.len() < 120_000 {
        let fetched = streams.fetch(1, 4_096, &stop).unwrap().unwrap();
        assert_eq!(fetched.first, samples.len() as u64 + fetched.lost);
        if fetched.lost > 0 {
            losses.push((fetched.first, fetched.lost));
        }
        samples.resize(samples.len() + fetched.lost as usize, 0.0);
        samples.extend(fetched.channels[0].iter().map(|v| f64::from(*v)));
    }
    assert_eq!(losses.len(), 1, "{losses:?}");
    assert_eq!(losses[0].1, 960);
    let found = delay(&played, &samples).unwrap();
    let residual = loop_residual(&played, &samples, &found, 0.05);
    // Nothing but the lost stretch differs.
    assert!(
        residual.different > 500 && residual.different <= 960,
        "{residual:?}"
    );
}

#[test]
fn a_device_that_is_gone_is_named_and_its_output_silent_within_a_tenth_of_a_second() {
    for what in ["removed", "silenced"] {
        let faults = format!("pace = \"real_time\"\nfaults = [{{ what = \"{what}\", at_s = 2 }}]");
        let mut streams = opened(&setup(&faults));
        let drive = whole(noise(480_000, 6), &streams);
        streams.play_at(0, drive).unwrap();
        let stop = StopHandle::new();
        let mut last = Instant::now();
        let error = loop {
            match streams.fetch(1, 4_096, &stop) {
                Ok(_) => last = Instant::now(),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, DeviceError::Lost { .. }), "{what}: {error}");
        // A quarter of a second without a word, then half as much for a busy machine.
        assert!(
            last.elapsed() < Duration::from_millis(500),
            "{what}: {:?}",
            last.elapsed()
        );
    }
}

#[test]
fn a_loopback_has_its_gain_and_a_latency() {
    let setup = setup("gain = -0.25\ndelay_frames = 1200\nnoise = 1e-5");
    let mut streams = opened(&setup);
    let gain = measured_loopback(&mut streams, &setup).unwrap().gain;
    // 1e-5 rms of noise on a tone of 0.0088 rms over 0.24 s: 1e-5 of it.
    assert!((gain + 0.25).abs() < 1e-4, "{gain}");
    let run = latency_run(&mut streams, &setup, 1).unwrap();
    let frames = run.latency_s.unwrap().0 * 48_000.0;
    // The line of the loop is three samples longer; the input of this buffer is counted behind it.
    assert!((frames - 1_203.0).abs() <= 256.0, "{frames}");
    assert_eq!(run.drop_outs, 0);
}

/// Half a period of the tone is a whole number of samples at 8 kHz, and nearly one at 44.1 kHz; with clocks apart, noise, and losses.
#[test]
fn the_polarity_of_a_loopback_is_never_that_of_half_a_period() {
    for rate_hz in [8_000.0, 44_100.0, 48_000.0] {
        for looped in [
            "noise = 0.003",
            "noise = 0.005\nclock_ppm = 20",
            "clock_ppm = -300",
            "gain = -0.4\nclock_ppm = 100",
            "faults = [{ what = \"stall\", at_s = 0.2, for_s = 0.04 }]",
            "faults = [{ what = \"underrun\", at_s = 0.4, for_s = 0.0005 }]",
            "faults = [{ what = \"overrun\", at_s = 0.4, for_s = 0.04 }]",
        ] {
            let setup = setup_at(rate_hz, looped);
            let found = measured_loopback(&mut opened(&setup), &setup).unwrap();
            let truth = if looped.contains("gain") { -0.4 } else { 0.5 };
            let off_db = 20.0 * (found.gain / truth).abs().log10();
            // 0.005 of noise beside a tone of 0.025 over 1920 samples: 0.65 % (0.06 dB), four times that.
            // The loop interpolates between samples by a cubic, which loses up to 0.15 dB at an eighth of the rate.
            let most_db = match looped {
                looped if looped.contains("noise") => 0.24,
                looped if looped.contains("ppm") && rate_hz < 10_000.0 => 0.15,
                _ => 0.02,
            };
            assert!(
                found.gain * truth > 0.0 && off_db.abs() < most_db,
                "{rate_hz} {looped}: {found:?}"
            );
        }
    }
}

#[test]
fn a_wrong_cable_is_found() {
    let found = wires::<AudioError>(&setup(""), &mut |alone| {
        alone.open_streams(&mut LoopIo::new(alone, None)?)
    })
    .unwrap();
    // The loop takes what leaves the first channel of the drive.
    let first = found[0].as_ref().unwrap();
    assert_eq!((first.output, first.input), (1, 1));
    // A loopback that is not there.
    let silent = setup("gain = 0");
    let error = measured_loopback(&mut opened(&silent), &silent).unwrap_err();
    assert!(matches!(error, AudioError::Sound(_)), "{error}");
}

#[test]
fn a_sensor_on_a_calibrator_gets_its_sensitivity() {
    let setup = setup("on_calibrator = 2\nnoise = 1e-4");
    let exciter = Exciter::handheld();
    let mut streams = opened(&setup);
    let (tone, peak) = record_tone(&mut streams, 2, Seconds(2.0), exciter.frequency_hz).unwrap();
    let unit = || piezotact::quantity::Unit::MetrePerSecondSquared;
    let found =
        InputCalibration::by_exciter((2, "acceleration", unit()), exciter, &tone, peak).unwrap();
    // 10.2 mV per m/s² into 2 V at full scale.
    let expected = 2.0 / 0.0102;
    assert!(
        (found.per_full_scale / expected - 1.0).abs() < 1e-3,
        "{found:?}"
    );
    let silent = record_tone(&mut streams, 1, Seconds(2.0), Hertz(159.2)).unwrap();
    assert!(
        InputCalibration::by_exciter((1, "drive", unit()), exciter, &silent.0, silent.1).is_err()
    );
}

#[test]
fn set_ups_that_cannot_be_are_refused() {
    let text = toml_of("rate_hz = 48000", "[loop]");
    assert!(
        SoundSetup::from_toml(&text).is_ok(),
        "{:?}",
        SoundSetup::from_toml(&text)
    );
    for (rate, looped, part) in [
        ("rate_hz = 1", "[loop]", "rate_hz from 8000"),
        ("rate_hz = 44100.5", "[loop]", "whole number"),
        ("rate_hz = nan", "[loop]", "rate_hz"),
        (
            "rate_hz = 48000\nbuffer_frames = 1",
            "[loop]",
            "buffer_frames",
        ),
        ("rate_hz = 48000", "", "[loop]"),
        ("rate_hz = 48000\ncolour = 1", "[loop]", "colour"),
        ("rate_hz = 48000", "[loop]\ngain = 1e9", "gain"),
        (
            "rate_hz = 48000",
            "[loop]\nsilent = { of = 2, every = 1 }",
            "silent",
        ),
        ("rate_hz = 48000\nforce = {}", "[loop]", "one source"),
    ] {
        let said = SoundSetup::from_toml(&toml_of(rate, looped))
            .unwrap_err()
            .to_string();
        assert!(said.contains(part), "{rate} {looped}: {said}");
    }
}

fn toml_of(rate: &str, looped: &str) -> String {
    format!(
        "host = \"loop\"\n{rate}\nplay = {{ drive = [1] }}\nrecord = [{{ channel = 1, measures = \"drive\" }}]\n{looped}"
    )
}
