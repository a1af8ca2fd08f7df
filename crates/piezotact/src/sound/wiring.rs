//! Which output is connected to which input: a pulse on each output, looked for on every input.

use crate::sound::SoundError;
use serde::{Deserialize, Serialize};

/// The largest value behind a pulse is at least so many times the largest one before it.
const ABOVE_REST: f64 = 8.0;
/// A second input that holds at least this share of the pulse makes the place undecided.
const ALIKE: f64 = 0.5;

/// A cable between an output and an input, channels from 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Wire {
    /// The channel of the output.
    pub output: u32,
    /// The channel of the input where the pulse arrived.
    pub input: u32,
    /// The recorded peak per played peak; negative where the polarity is inverted.
    pub gain: f64,
    /// From the start of the stretch to the peak, in samples.
    pub at_sample: usize,
}

/// Where the pulse of `output` (channel from 1; `played_share` is its peak, of full scale) arrived: `inputs` holds one recorded stretch for each input, at rest in the first
/// `rest` samples. The gain is in recorded units per played unit.
///
/// Formula: an input holds the pulse where its largest value behind the rest is at least eight times the largest value within the rest, both about the
/// mean at rest; it is the only one where no other holds half as much.
///
/// Source: docs/decisions/sound.md.
///
/// # Errors
/// [`SoundError`] where it arrived on no input or on several.
pub fn wiring(
    output: u32,
    played_share: f64,
    inputs: &[&[f64]],
    rest: usize,
) -> Result<Wire, SoundError> {
    let mut found: Vec<(u32, f64, usize)> = Vec::new();
    for (input, samples) in (1..).zip(inputs) {
        let (before, behind) = samples.split_at(rest.min(samples.len()));
        let mean = crate::statistics::mean(before);
        let noise = before
            .iter()
            .fold(0.0_f64, |most, v| most.max((v - mean).abs()));
        let peak = behind
            .iter()
            .map(|v| v - mean)
            .enumerate()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        if let Some((at, peak)) = peak
            && peak.abs() > 0.0
            && peak.abs() >= ABOVE_REST * noise
        {
            found.push((input, peak, before.len() + at));
        }
    }
    let Some(best) = found
        .iter()
        .copied()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    else {
        return Err(SoundError::Nowhere { output });
    };
    let alike = |(_, peak, _): &&(u32, f64, usize)| peak.abs() >= ALIKE * best.1.abs();
    let inputs: Vec<u32> = found
        .iter()
        .filter(alike)
        .map(|(input, ..)| *input)
        .collect();
    match inputs.len() {
        1 => Ok(Wire {
            output,
            input: best.0,
            gain: best.1 / played_share,
            at_sample: best.2,
        }),
        _ => Err(SoundError::Several { output, inputs }),
    }
}
