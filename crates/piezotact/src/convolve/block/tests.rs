use super::*;
use crate::convolve::Convolver;

fn wild(count: usize, turn: f64) -> Vec<f64> {
    (1..=count).map(|i| ((i * i) as f64 * turn).sin()).collect()
}

fn naive(impulse: &[f64], input: &[f64]) -> Vec<f64> {
    (0..input.len())
        .map(|n| {
            let reach = impulse.len().min(n + 1);
            (0..reach).map(|k| impulse[k] * input[n - k]).sum()
        })
        .collect()
}

fn convolver(impulse: &[f64], block: usize) -> BlockConvolver {
    BlockConvolver::new(Partitions::new(impulse, block).unwrap())
}

fn run(convolver: &mut BlockConvolver, input: &[f64]) -> Vec<f64> {
    let block = convolver.partitions.block;
    let mut output = vec![f64::NAN; input.len()];
    for (input, output) in input.chunks(block).zip(output.chunks_mut(block)) {
        convolver.process(input, output).unwrap();
    }
    output
}

/// The largest difference, relative to the largest expected value.
fn worst(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    (found.iter().zip(expected))
        .map(|(a, b)| (a - b).abs() / largest)
        .fold(0.0, |most, error| if error <= most { most } else { error })
}

/// It is the sum by definition. Rounding: 1e-16 for each of the log2(B) steps of two transforms and for the sums over partitions,
/// which grow with their square root; 2.4e-15 is the most that was seen.
#[test]
fn blocks_and_impulse_responses_of_any_length_give_the_sum() {
    for block in [1, 2, 7, 8, 30, 61, 64, 480] {
        for taps in [1, 2, 7, 63, 64, 65, 333, 1_001] {
            let impulse = wild(taps, 0.73);
            let input = wild((2_200usize).div_ceil(block) * block, 0.37);
            let found = run(&mut convolver(&impulse, block), &input);
            let error = worst(&found, &naive(&impulse, &input));
            assert!(error < 2e-14, "{taps} taps in blocks of {block}: {error:e}");
        }
    }
}

/// 4096 taps in blocks of 64, as in the benchmark; the rounding of both.
#[test]
fn it_is_the_offline_convolution() {
    let impulse: Vec<f64> = (wild(4_096, 0.73).iter().enumerate())
        .map(|(k, v)| v * (-(k as f64) / 600.0).exp())
        .collect();
    let input = wild(48_000, 0.37);
    let found = run(&mut convolver(&impulse, 64), &input);
    let error = worst(&found, &Convolver::new(&impulse).feed(&input));
    assert!(error < 2e-14, "{error:e}");
}

#[test]
fn nothing_is_added_to_the_delay_of_a_block() {
    let mut convolver = convolver(&[0.25, 1.0, -2.0], 4);
    let mut output = [0.0; 4];
    convolver
        .process(&[0.0, 1.0, 0.0, 0.0], &mut output)
        .unwrap();
    assert!(
        worst(&output, &[0.0, 0.25, 1.0, -2.0]) < 1e-15,
        "{output:?}"
    );
}

/// The sums with registers of one and of eight lanes, on any machine; those of 61 samples are computed at once, those of 30 ahead
/// as well.
#[test]
fn registers_of_any_width_give_the_same_sums() {
    fn sums<S: pulp::Simd>(simd: S, convolver: &BlockConvolver) -> (Vec<f64>, Ahead) {
        let (mut sums, mut ahead) = (convolver.transform.bins.clone(), convolver.ahead.clone());
        ahead.turn = (ahead.turn + 1) % ahead.blocks;
        let next = Next {
            history: &convolver.history,
            partitions: &convolver.partitions,
            ahead: &mut ahead,
            sums: &mut sums,
        };
        pulp::WithSimd::with_simd(next, simd);
        (sums.concat().concat(), ahead)
    }
    for (block, blocks) in [(61, 1), (30, AHEAD)] {
        let mut convolver = convolver(&wild(700, 0.73), block);
        assert_eq!(convolver.ahead.blocks, blocks);
        run(&mut convolver, &wild(block * 37, 0.37));
        let (one, after_one) = sums(pulp::Scalar::new(), &convolver);
        let (eight, after_eight) = sums(pulp::Scalar512b, &convolver);
        // The same additions in the same order; one that is fused rounds once less, of 24 products.
        assert!(worst(&one, &eight) < 1e-14);
        let ahead = |ahead: Ahead| ahead.sums.concat().concat().concat();
        let (one, eight) = (ahead(after_one), ahead(after_eight));
        assert!(one == eight || worst(&one, &eight) < 1e-14);
    }
}

/// In the block after a change each sample lies between what both impulse responses give, all inputs remembered; whatever was
/// computed ahead.
#[test]
fn an_impulse_response_changes_without_a_step() {
    for (block, taps) in [(16, 50), (32, 700)] {
        for blocks in 40..45 {
            let at = block * blocks;
            let [first, second] = [wild(taps, 0.73), wild(taps - 1, 0.11)];
            let input = wild(2 * at, 0.37);
            let mut convolver = convolver(&first, block);
            let mut found = run(&mut convolver, &input[..at]);
            let mut next = Partitions::new(&second, block).unwrap();
            convolver.change(&mut next).unwrap();
            found.extend(run(&mut convolver, &input[at..]));
            let (old, new) = (naive(&first, &input), naive(&second, &input));
            let expected: Vec<f64> = (0..input.len())
                .map(|n| {
                    let share = ((n + 1) as f64 - at as f64) / block as f64;
                    old[n] + (new[n] - old[n]) * share.clamp(0.0, 1.0)
                })
                .collect();
            let error = worst(&found, &expected);
            assert!(
                error < 2e-14,
                "{taps} taps after {blocks} blocks: {error:e}"
            );
        }
    }
}

/// The second of two changes before a block is the one that is played, from what was played before; the third change gets back
/// what was played first.
#[test]
fn of_two_changes_before_a_block_the_last_counts() {
    let level = |level: f64| Partitions::new(&[level], 1).unwrap();
    let mut convolver = convolver(&[1.0], 1);
    let play = |convolver: &mut BlockConvolver| {
        let mut output = [0.0];
        convolver.process(&[1.0], &mut output).unwrap();
        output[0]
    };
    assert_eq!(play(&mut convolver), 1.0);
    convolver.change(&mut level(2.0)).unwrap();
    let mut third = level(3.0);
    convolver.change(&mut third).unwrap();
    assert_eq!(third.spectra, level(2.0).spectra);
    assert_eq!([play(&mut convolver), play(&mut convolver)], [3.0, 3.0]);
    let mut fourth = level(4.0);
    convolver.change(&mut fourth).unwrap();
    assert_eq!(fourth.spectra, level(1.0).spectra);
    assert_eq!(play(&mut convolver), 4.0);
}

#[test]
fn a_sample_that_is_no_number_passes() {
    let mut convolver = convolver(&wild(100, 0.73), 16);
    let mut input = wild(320, 0.37);
    let expected = run(&mut convolver.clone(), &input);
    input[40] = f64::NAN;
    let found = run(&mut convolver, &input);
    // Its block, and the 99 samples after it to the end of a block.
    assert_eq!(found[..32], expected[..32]);
    assert!(found[40].is_nan());
    input[40] = 0.0;
    let without = naive(&wild(100, 0.73), &input);
    assert!(worst(&found[160..], &without[160..]) < 1e-14);
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |impulse: &[f64], block| Partitions::new(impulse, block).unwrap_err();
    assert_eq!(refused(&[1.0], 0), SeriesError::Block { found: 0 });
    assert_eq!(
        refused(&[1.0], usize::MAX),
        SeriesError::Block { found: usize::MAX }
    );
    assert_eq!(refused(&[], 64), SeriesError::NoImpulse);
    assert!(matches!(
        refused(&[1.0, f64::NAN], 64),
        SeriesError::ImpulseNotFinite { at: 1, .. }
    ));
    let mut convolver = convolver(&wild(100, 0.73), 16);
    let before = convolver.history.newest;
    let length = |found| {
        Err(SeriesError::Lengths {
            expected: [1, 16],
            found: [1, found],
        })
    };
    assert_eq!(convolver.process(&[0.0; 15], &mut [0.0; 16]), length(15));
    assert_eq!(convolver.process(&[0.0; 16], &mut [0.0; 17]), length(17));
    assert_eq!(
        (convolver.history.newest, convolver.fade),
        (before, Fade::Done)
    );
    let mut longer = Partitions::new(&wild(113, 0.73), 16).unwrap();
    let error = convolver.change(&mut longer).unwrap_err();
    assert_eq!(
        error.to_string(),
        "expected 7 block(s) of 16 samples, found 8 of 16; cut both impulse responses for one block, and fill the shorter one with zeros"
    );
}
