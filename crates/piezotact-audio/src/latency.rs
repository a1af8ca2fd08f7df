//! The latency of a device in one start of its streams.

use piezotact::quantity::Seconds;
use piezotact::sound::{LatencyRun, burst_delay};
use piezotact::statistics::random::Random;

use crate::calibrate::excite;
use crate::error::AudioError;
use crate::setup::SoundSetup;
use crate::streams::RunningStreams;

/// The burst of noise that is looked for in the loopback: its duration, s, and level, rms re full scale.
const BURST_S: f64 = 0.1;
const BURST_RMS: f64 = 0.03;

/// The time from handing a sample to the output to its arrival in the loopback, in the streams that were just opened. A quiet burst of noise of 0.1 s,
/// drawn from `seed`, is played.
///
/// # Errors
/// [`AudioError`] when the device fails. A loopback without the burst is a run without a latency, not an error.
pub fn latency_run(
    streams: &mut RunningStreams,
    setup: &SoundSetup,
    seed: u64,
) -> Result<LatencyRun, AudioError> {
    let Some(loopback) = setup.loopback() else {
        return Err(AudioError::Setup(
            "expected an input that records what is played, found none; add one with measures = \"drive\"".into(),
        ));
    };
    let rate = streams.rate();
    let mut random = Random::stream(seed, 0, "latency");
    let count = (BURST_S * rate.hz()) as usize;
    let white: Vec<f64> = (0..count + 2).map(|_| random.normal()).collect();
    // Without the highest frequencies, which a converter does not pass; 0.612 is the rms that is left.
    let smooth = |w: &[f64]| BURST_RMS / 0.612 * (0.25 * w[0] + 0.5 * w[1] + 0.25 * w[2]);
    let burst: Vec<f64> = white.windows(3).map(smooth).collect();
    let excited = excite(streams, &burst)?;
    let found = burst_delay(&burst, &excited.inputs[loopback.channel as usize - 1]).ok();
    let frames = found.map(|delay| delay.samples as f64 + delay.fraction - excited.onset as f64);
    Ok(LatencyRun {
        latency_s: frames.map(|frames| Seconds(frames / rate.hz())),
        gain: found.map_or(0.0, |delay| delay.gain),
        drop_outs: excited.drop_outs,
    })
}
