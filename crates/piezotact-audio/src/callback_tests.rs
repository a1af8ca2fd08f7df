//! The callbacks under a guard against allocations, with odd blocks and commands at random.

use assert_no_alloc::{AllocDisabler, assert_no_alloc, violation_count};
use piezotact::quantity::SampleRate;
use piezotact::statistics::random::Random;
use rtrb::RingBuffer;

use super::*;
use crate::streams::{Halves, StreamChannels};

#[global_allocator]
static GUARD: AllocDisabler = AllocDisabler;

fn halves() -> Halves {
    let channels = StreamChannels {
        output: 3,
        drive: vec![0, 1],
        trigger: Some(2),
        input: 2,
    };
    Halves::new(SampleRate::new(48_000.0).unwrap(), &channels)
}

#[test]
fn ten_thousand_blocks_allocate_nothing() {
    let mut halves = halves();
    let mut random = Random::stream(1, 0, "blocks");
    let mut draw = move |below: u64| (random.uniform() * below as f64) as u64;
    let (mut out, taken) = (vec![0.0; 3 * 5_000], vec![0.5; 2 * 5_000]);
    let (mut pieces, mut played, mut violations) = (0, 0, 0);
    let mut stop = StopHandle::new();
    for _ in 0..10_000 {
        match draw(8) {
            0 => {
                pieces += 1;
                let samples = match draw(2) {
                    0 => Samples::Whole((0..draw(9_000)).map(|i| (i as f32).sin() * 1.2).collect()),
                    _ => {
                        let (mut ring, samples) = RingBuffer::new(4_096);
                        for _ in 0..draw(4_096) {
                            ring.push(0.25).unwrap();
                        }
                        let complete = draw(3) > 0;
                        Samples::Made(samples, Arc::new(AtomicBool::new(complete)))
                    }
                };
                let start = draw(100_000_000);
                stop = StopHandle::new();
                let piece = Piece {
                    number: pieces,
                    start: if start < 50_000_000 { 0 } else { start },
                    samples,
                    stop: stop.child(),
                };
                let _full = halves.commands.push(Command::Play(Box::new(piece)));
            }
            1 => {
                let _full = halves.commands.push(Command::Stop);
            }
            2 => stop.stop(),
            _ => {}
        }
        halves.board.muted.store(draw(50) == 0, Ordering::Release);
        let frames = match draw(4) {
            0 => 0,
            1 => 1,
            _ => draw(2_000) as usize,
        };
        // A buffer that is no whole number of frames, now and then.
        let odd = usize::from(draw(10) == 0);
        let before = violation_count();
        assert_no_alloc(|| {
            halves.output.fill(&mut out[..3 * frames + odd]);
            halves.input.take(&taken[..2 * frames + odd]);
            if odd > 0 {
                halves.output.skipped(7);
                halves.input.lost(7);
            }
        });
        violations += violation_count() - before;
        played += halves.board.played.load(Ordering::Acquire);
        while let Ok(piece) = halves.home.pop() {
            drop(piece);
        }
        if draw(3) > 0 {
            let there = halves.samples.slots();
            halves.samples.read_chunk(there).unwrap().commit_all();
        }
        assert!(out.iter().all(|v| v.abs() <= 1.0));
    }
    assert_eq!(violations, 0);
    // The test did play, and dropped what it could not keep.
    assert!(pieces > 1_000 && played > 1_000_000, "{pieces} {played}");
    assert!(halves.board.dry.load(Ordering::Acquire) > 0);
}

#[test]
fn the_guard_finds_an_allocation() {
    let before = violation_count();
    assert_no_alloc(|| drop(std::hint::black_box(vec![1_u8; 100])));
    assert!(violation_count() > before);
}

#[test]
fn a_stop_fades_out_and_a_trigger_pulses_with_the_onset() {
    for by_handle in [false, true] {
        let mut halves = halves();
        let stop = StopHandle::new();
        let piece = Piece {
            number: 1,
            start: 100,
            samples: Samples::Whole(vec![0.5; 48_000]),
            stop: stop.child().child(),
        };
        halves
            .commands
            .push(Command::Play(Box::new(piece)))
            .unwrap();
        let mut out = vec![0.0; 3 * 480];
        halves.output.fill(&mut out);
        let frame = |out: &[f32], i: usize| [out[3 * i], out[3 * i + 1], out[3 * i + 2]];
        assert_eq!(frame(&out, 99), [0.0; 3]);
        assert_eq!(frame(&out, 100), [0.5, 0.5, TRIGGER_LEVEL]);
        // 1 ms at 48 kHz.
        assert_eq!(
            [frame(&out, 147)[2], frame(&out, 148)[2]],
            [TRIGGER_LEVEL, 0.0]
        );
        // The other half may wait for a disk: a handle needs no command of it.
        match by_handle {
            true => stop.stop(),
            false => halves.commands.push(Command::Stop).unwrap(),
        }
        halves.output.fill(&mut out);
        let falls = out.chunks(3).map(|frame| frame[0]).collect::<Vec<_>>();
        assert!(falls.windows(2).all(|pair| pair[1] <= pair[0]), "{falls:?}");
        // 5 ms at 48 kHz.
        assert!(falls[235] > 0.0 && falls[245] == 0.0, "{falls:?}");
        let silent = falls.iter().position(|v| *v == 0.0).unwrap() as u64;
        let silent_from = halves.board.silent_from.load(Ordering::Acquire);
        assert_eq!(silent_from, 480 + silent);
        assert_eq!(halves.board.ended.load(Ordering::Acquire), 1);
        assert_eq!(halves.home.slots(), 1);
    }
}

#[test]
fn what_exceeds_full_scale_or_is_no_number_is_limited_and_counted() {
    let mut halves = halves();
    let piece = Piece {
        number: 1,
        start: 0,
        samples: Samples::Whole(vec![2.0, f32::NAN, -3.0, 0.25, f32::INFINITY]),
        stop: StopHandle::new(),
    };
    halves
        .commands
        .push(Command::Play(Box::new(piece)))
        .unwrap();
    let mut out = vec![0.0; 3 * 8];
    halves.output.fill(&mut out);
    let played: Vec<f32> = out.chunks(3).map(|frame| frame[0]).collect();
    assert_eq!(played, [1.0, 0.0, -1.0, 0.25, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(halves.board.limited.load(Ordering::Acquire), 4);
}

#[test]
fn a_full_input_counts_what_it_drops() {
    let mut halves = halves();
    let second = vec![0.0; 2 * 48_000];
    for _ in 0..9 {
        halves.input.take(&second);
    }
    assert_eq!(halves.board.overflowed.load(Ordering::Acquire), 48_000);
}
