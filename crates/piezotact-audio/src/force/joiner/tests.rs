use piezotact::recording::{Clocks, LostBy, RecordingWarning};
use std::time::Duration;

use piezotact::statistics::random::Random;

use super::*;

const RATE_HZ: f64 = 48_000.0;
const BLOCK: u64 = 512;
/// What readings and frames are late at the least, s.
const LEAST_S: f64 = 0.002;
const LEAST_FRAME_S: f64 = 0.004;

fn config() -> JoinerConfig {
    JoinerConfig {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        longest_pause_s: 1.0,
        least_delay_s: LEAST_S,
        least_frame_delay_s: LEAST_FRAME_S,
    }
}

/// A simulated source: its rate, how fast its clock is, and whether it states times.
struct Source {
    per_s: f64,
    fast: f64,
    times: Times,
    /// Readings in this time are not sent, s.
    silent_s: [f64; 2],
    /// Readings arrive at these intervals only, s; 0 for at once.
    fetched_every_s: f64,
    /// Readings from the first of these times to the second arrive later by the third, s.
    late_s: [f64; 3],
}

#[derive(Clone, Copy, PartialEq)]
enum Times {
    Stated,
    None,
}

impl Source {
    fn cell() -> Self {
        Self {
            per_s: 80.0,
            fast: 200e-6,
            times: Times::Stated,
            silent_s: [0.0; 2],
            fetched_every_s: 0.0,
            late_s: [0.0; 3],
        }
    }
}

/// What arrives: so many frames, or a reading with its device time.
enum Event {
    Frames(u64),
    Reading(Option<f64>, f64),
}

/// The force at the time `t_s`: a ramp of 0.5 N/s up and down, so that an error of 1 ms is one of 0.5 mN.
fn ramp(t_s: f64) -> f64 {
    0.5 * (t_s % 4.0 - 2.0).abs()
}

/// Frames for `seconds`, in blocks with up to 10 ms of jitter, joined to `source`, which begins a second earlier with up to 15 ms of
/// jitter; the force at every frame and the joiner.
fn joined(source: &Source, seconds: f64) -> Result<(Vec<f64>, ForceJoiner), ForceError> {
    let origin = Instant::now();
    let mut random = Random::stream(8, 0, "jitter");
    let mut events: Vec<(f64, Event)> = Vec::new();
    let mut seen_s: f64 = 0.0;
    for block in 1..=(seconds * RATE_HZ) as u64 / BLOCK {
        let at_s = 1.0 + (block * BLOCK) as f64 / RATE_HZ + LEAST_FRAME_S;
        seen_s = seen_s.max(at_s + 0.01 * random.uniform());
        events.push((seen_s, Event::Frames(block * BLOCK)));
    }
    let mut seen_s: f64 = 0.0;
    for i in 0..((seconds + 1.2) * source.per_s) as usize {
        let t_s = i as f64 / source.per_s;
        if (source.silent_s[0]..source.silent_s[1]).contains(&t_s) {
            continue;
        }
        let jitter_s = match source.times {
            Times::Stated => 0.015 * random.uniform(),
            Times::None => 0.0,
        };
        let [from_s, to_s, by_s] = source.late_s;
        let late_s = match (from_s..to_s).contains(&t_s) {
            true => by_s,
            false => 0.0,
        };
        seen_s = seen_s.max(t_s + LEAST_S + jitter_s + late_s);
        let arrives_s = match source.fetched_every_s {
            0.0 => seen_s,
            every_s => (seen_s / every_s).ceil() * every_s,
        };
        let stated = (source.times == Times::Stated).then_some(t_s * (1.0 + source.fast));
        events.push((arrives_s, Event::Reading(stated, ramp(t_s))));
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut joiner = ForceJoiner::new(config());
    let (mut force_n, mut last) = (Vec::new(), 0);
    for (at_s, event) in events {
        let at = origin + Duration::from_secs_f64(at_s);
        match event {
            Event::Frames(frames) => {
                joiner.frames(at, frames);
                last = frames;
            }
            Event::Reading(device_s, force_n) => joiner.reading(&ForceReading {
                at,
                device_s,
                clock: 0,
                force_n,
            }),
        }
        force_n.extend(joiner.next(4_096)?);
    }
    force_n.extend(joiner.finish(last)?);
    assert_eq!(force_n.len() as u64, last);
    Ok((force_n, joiner))
}

/// The largest error, N, of frames from `from_s` on, away from the corners of the ramp, which interpolation cuts.
fn worst_n(force_n: &[f64], from_s: f64) -> f64 {
    let error = |(n, force_n): (usize, &f64)| {
        let t_s = 1.0 + n as f64 / RATE_HZ;
        let corner_s = (t_s % 2.0).min(2.0 - t_s % 2.0);
        (t_s > from_s && corner_s > 0.15).then_some((force_n - ramp(t_s)).abs())
    };
    force_n
        .iter()
        .enumerate()
        .filter_map(error)
        .fold(0.0, f64::max)
}

/// 200 ppm over a minute are 12 ms, and jitters are 10 and 15 ms: the force of every frame is within 1 ms of its time, 0.5 mN, once
/// there were a few seconds, and at the beginning within the uncertainty that is stated.
#[test]
fn a_drifting_clock_with_jitter_is_joined() {
    let (force_n, joiner) = joined(&Source::cell(), 60.0).unwrap();
    let late_n = worst_n(&force_n, 10.0);
    assert!(late_n < 0.5e-3, "{late_n:e} N");
    let uncertainty_s = joiner.uncertainty_s().unwrap();
    let all_n = worst_n(&force_n, 0.0);
    assert!(
        all_n < 0.5 * uncertainty_s,
        "{all_n:e} N, {uncertainty_s:e} s"
    );
    assert!(uncertainty_s < 0.02, "{uncertainty_s}");
    assert!(joiner.warnings().is_empty(), "{:?}", joiner.warnings());
}

/// Some readings of the beginning are late: the others place them, and nothing gives a warning. All of them are late: frames of the beginning were
/// placed wrongly, as is seen later, and the uncertainty says by how much.
#[test]
fn what_is_known_later_says_how_certain_the_beginning_was() {
    let late = |late_s| Source {
        late_s,
        ..Source::cell()
    };
    for (source, reported) in [
        (late([1.3, 1.6, 0.08]), false),
        (late([0.0, 2.5, 0.08]), true),
    ] {
        let (force_n, joiner) = joined(&source, 20.0).unwrap();
        let uncertainty_s = joiner.uncertainty_s().unwrap();
        let all_n = worst_n(&force_n, 0.0);
        assert!(
            all_n < 0.5 * uncertainty_s,
            "{all_n:e} N, {uncertainty_s:e} s"
        );
        assert_eq!(
            uncertainty_s > MOST_UNCERTAIN_S,
            reported,
            "{uncertainty_s}"
        );
    }
}

/// Readings whose time stands still are no silence of the sound device.
#[test]
fn a_clock_that_stands_is_named() {
    let origin = Instant::now();
    let mut joiner = ForceJoiner::new(config());
    let mut result = Ok(Vec::new());
    for ms in 1..6_000_u32 {
        let at = origin + Duration::from_millis(ms.into());
        joiner.frames(at, 48 * u64::from(ms));
        if ms.is_multiple_of(12) {
            joiner.reading(&ForceReading {
                at,
                device_s: Some(1e-3 * f64::from(ms.min(2_400))),
                clock: 0,
                force_n: 0.2,
            });
        }
        result = joiner.next(100_000);
        if result.is_err() {
            break;
        }
    }
    assert!(
        matches!(result, Err(ForceError::ClockStands { pause_s }) if pause_s < 1.1),
        "{result:?}"
    );
}

/// Half a second for the clocks, then the last reading is at most 12.5 ms and its delay behind.
#[test]
fn the_force_follows_soon() {
    let origin = Instant::now();
    let mut joiner = ForceJoiner::new(config());
    let mut most_s: f64 = 0.0;
    for ms in 1..3_000_u32 {
        let at = origin + Duration::from_millis(ms.into());
        joiner.frames(at, 48 * u64::from(ms));
        if ms.is_multiple_of(12) {
            joiner.reading(&ForceReading {
                at,
                device_s: Some(1e-3 * f64::from(ms)),
                clock: 0,
                force_n: 0.2,
            });
        }
        let given = joiner.next(100_000).unwrap();
        assert!(given.iter().all(|force_n| (force_n - 0.2).abs() < 1e-12));
        if ms > 1_100 {
            most_s = most_s.max(joiner.held_back_s());
        }
    }
    assert!(most_s < 0.016, "{most_s}");
}

/// Without device times a reading counts as measured when it arrived; fetched every 20 ms from a file, several at once are spread over
/// that time, which is the uncertainty that is stated.
#[test]
fn readings_without_times_are_joined_by_their_arrival() {
    let scale = Source {
        per_s: 10.0,
        times: Times::None,
        ..Source::cell()
    };
    let (force_n, joiner) = joined(&scale, 20.0).unwrap();
    // Jitter of the frames alone, of which the first seconds hold little.
    let worst = worst_n(&force_n, 5.0);
    assert!(worst < 0.5e-3, "{worst:e}");
    assert!(joiner.uncertainty_s().unwrap() < 0.02);
    let fetched = Source {
        per_s: 400.0,
        times: Times::None,
        fetched_every_s: 0.025,
        ..Source::cell()
    };
    let (force_n, joiner) = joined(&fetched, 20.0).unwrap();
    let worst = worst_n(&force_n, 5.0);
    assert!(worst < 0.5 * 0.026, "{worst:e}");
    let warnings = joiner.warnings();
    assert!(matches!(
        warnings[0].kind(),
        Some(RecordingWarning::ClocksDiffer { of: Clocks::Force { uncertainty_s, .. } }) if (uncertainty_s - 0.025).abs() < 0.012
    ));
}

/// A gap of 0.5 s is interpolated with a warning, one of 1.5 s is an error.
#[test]
fn gaps_are_told_and_long_ones_refused() {
    let gap = |silent_s| Source {
        silent_s,
        ..Source::cell()
    };
    let (_, joiner) = joined(&gap([6.0, 6.5]), 10.0).unwrap();
    let warnings = joiner.warnings();
    let [warning] = &warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!(matches!(
        warning.kind(),
        // From the last reading before 6 s to the one at 6.5 s.
        Some(RecordingWarning::SamplesLost { by: LostBy::Force { gaps: 1, longest_s, .. } }) if (longest_s - 0.5125).abs() < 1e-3
    ));
    let error = joined(&gap([6.0, 7.5]), 10.0).unwrap_err();
    assert!(matches!(error, ForceError::Stale { .. }), "{error}");
    let error = joined(&gap([0.0, 20.0]), 10.0).unwrap_err();
    assert!(matches!(error, ForceError::Stale { .. }), "{error}");
}

#[test]
fn nothing_to_join_is_an_error() {
    let mut joiner = ForceJoiner::new(config());
    assert_eq!(joiner.next(10), Ok(Vec::new()));
    assert!(matches!(
        joiner.finish(100),
        Err(ForceError::Nothing { .. })
    ));
    let mut joiner = ForceJoiner::new(config());
    joiner.frames(Instant::now(), 480);
    assert!(matches!(
        joiner.finish(480),
        Err(ForceError::Nothing { .. })
    ));
}

/// A clock that begins again keeps the readings before it where they were.
#[test]
fn a_clock_that_begins_again() {
    let origin = Instant::now();
    let mut joiner = ForceJoiner::new(JoinerConfig {
        least_delay_s: 0.0,
        least_frame_delay_s: 0.0,
        ..config()
    });
    let mut force_n = Vec::new();
    for ms in 1..4_000_u32 {
        let at = origin + Duration::from_millis(ms.into());
        joiner.frames(at, 48 * u64::from(ms));
        if ms.is_multiple_of(10) {
            let clock = u32::from(ms > 2_000);
            joiner.reading(&ForceReading {
                at,
                device_s: Some(1e-3 * f64::from(ms - 2_000 * clock)),
                clock,
                force_n: 1e-3 * f64::from(ms),
            });
        }
        force_n.extend(joiner.next(100_000).unwrap());
    }
    force_n.extend(joiner.finish(48 * 3_999).unwrap());
    for (n, force_n) in force_n
        .iter()
        .enumerate()
        .skip(4_800)
        .take(48 * 3_900 - 4_800)
    {
        let t_s = n as f64 / RATE_HZ;
        // A reading before the first is held for 10 ms; the rest is exact.
        assert!((force_n - t_s).abs() < 1e-6, "{t_s}: {force_n}");
    }
}

/// A consumer that never asks, and a source without frames: what waits is bounded.
#[test]
fn memory_is_bounded() {
    let mut joiner = ForceJoiner::new(config());
    let at = Instant::now();
    for i in 0..200_000_u32 {
        joiner.reading(&ForceReading {
            at: at + Duration::from_millis(i.into()),
            device_s: Some(1e-3 * f64::from(i)),
            clock: 0,
            force_n: 0.2,
        });
    }
    assert_eq!(joiner.waiting.len(), MOST_WAITING);
}
