//! Signals that hold one value: an electrode that is off, or samples that were lost.

use std::ops::Range;

use piezotact::quantity::{SampleRate, Seconds};

/// The noise of an electrode and its amplifier never holds one value for so long.
const HELD: Seconds = Seconds(0.2);

/// The parts of `samples` that hold one value for 0.2 s or more, in the order of time.
///
/// Source: house rule; as MNE-Python's `annotate_amplitude(flat=0)`.
pub(super) fn held(samples: &[f64], rate: SampleRate) -> Vec<Range<usize>> {
    let least = rate.samples_in(HELD).max(2);
    let mut found = Vec::new();
    let mut at = 0;
    for run in samples.chunk_by(|a, b| a == b) {
        if run.len() >= least {
            found.push(at..at + run.len());
        }
        at += run.len();
    }
    found
}
