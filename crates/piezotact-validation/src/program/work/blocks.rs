//! The time of every block of a convolution in real time.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, ensure};
use piezotact::convolve::{BlockConvolver, Partitions};
use serde_json::json;

use super::{keep, load};

const BLOCK: usize = 64;
const TAPS: usize = 4096;

/// W4: blocks of 64 samples through 4096 taps, `passes` times after one pass that is not counted. A block goes in and comes out
/// in single precision in the same two buffers, as with a sound device; changing to double precision and back is timed too. The
/// time is that of the monotonic clock on the wall, as clocks of CPU time are too coarse for a microsecond; reading it is part of the time of every
/// block, as it is for peers.
#[allow(clippy::print_stdout, reason = "its result is one line of JSON")]
pub(super) fn w4(folder: &Path, passes: usize) -> Result<()> {
    let data = load(folder, "W4")?;
    ensure!(
        data.len() > TAPS && (data.len() - TAPS).is_multiple_of(BLOCK),
        "W4.f64: expected whole blocks of {BLOCK} samples and {TAPS} taps, found {} numbers",
        data.len()
    );
    let (signal, taps) = data.split_at(data.len() - TAPS);
    let input: Vec<f32> = signal.iter().map(|v| *v as f32).collect();
    let mut output = vec![0.0f32; input.len()];
    let fresh = BlockConvolver::new(Partitions::new(taps, BLOCK)?);
    let (mut device_in, mut device_out) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
    let (mut wide, mut answer) = ([0.0; BLOCK], [0.0; BLOCK]);
    let mut passes_s = Vec::with_capacity(passes);
    for pass in 0..=passes {
        let mut convolver = fresh.clone();
        let mut times = Vec::with_capacity(input.len() / BLOCK);
        for (input, output) in input.chunks(BLOCK).zip(output.chunks_mut(BLOCK)) {
            device_in.copy_from_slice(input);
            let start = Instant::now();
            for (wide, sample) in wide.iter_mut().zip(&device_in) {
                *wide = f64::from(*sample);
            }
            convolver.process(&wide, &mut answer)?;
            for (sample, answer) in device_out.iter_mut().zip(&answer) {
                *sample = *answer as f32;
            }
            times.push(start.elapsed().as_secs_f64());
            output.copy_from_slice(&device_out);
        }
        if pass > 0 {
            passes_s.push(times);
        }
    }
    let result: Vec<f64> = output.iter().map(|v| f64::from(*v)).collect();
    keep(folder, "W4", &result)?;
    println!("{}", json!({ "passes_s": passes_s }));
    Ok(())
}
