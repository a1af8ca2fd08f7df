//! Band-limited interpolation at times that are no whole samples.

use std::f64::consts::PI;

use super::Alignment;
use crate::quantity::{SampleRate, Seconds};
use crate::resample::bessel_i0;

/// Samples on each side of a time.
const HALF: usize = 32;
/// The shape of the window: the stop band is below −100 dB.
const BETA: f64 = 10.0;
/// Steps of the table of the window; between them it is a line, to 1e-6.
const STEPS: usize = 4096;

/// The signal on the clock of the drive, whose first sample was taken at `start_s` by the clock of the recording, and the time of its
/// first sample on that of the drive.
pub(super) fn placed(
    alignment: &Alignment,
    samples: &[f64],
    rate: SampleRate,
    start_s: Seconds,
) -> (Vec<f64>, Seconds) {
    let rate_hz = rate.hz();
    let end_s = Seconds(start_s.0 + rate.duration_of(samples.len().saturating_sub(1)).0);
    let slack = 1e-6;
    let first = (alignment.on_drive(start_s).0 * rate_hz - slack).ceil();
    let last = (alignment.on_drive(end_s).0 * rate_hz + slack).floor();
    // A clock that is twice as fast is none: a document that says so makes no endless signal.
    let most = 2.0 * samples.len() as f64;
    let count = (last - first + 1.0).clamp(0.0, most) as usize;
    let between = Between::new();
    let at = |i: usize| {
        let drive_s = (first + i as f64) / rate_hz;
        let recorded_s = alignment.on_recording(Seconds(drive_s)).0 - start_s.0;
        between.at(samples, recorded_s * rate_hz)
    };
    let found = match samples.is_empty() {
        true => Vec::new(),
        false => (0..count).map(at).collect(),
    };
    (found, Seconds(first / rate_hz))
}

/// The signal by a clock that is slower by the factor `stretch`, above 0.
pub(super) fn stretched(samples: &[f64], stretch: f64) -> Vec<f64> {
    if stretch == 1.0 || samples.is_empty() {
        return samples.to_vec();
    }
    let count = ((samples.len() - 1) as f64 / stretch).floor() as usize + 1;
    let between = Between::new();
    (0..count.min(2 * samples.len()))
        .map(|i| between.at(samples, i as f64 * stretch))
        .collect()
}

/// A sinc in a Kaiser window.
pub(super) struct Between {
    window: Vec<f64>,
}

impl Between {
    pub(super) fn new() -> Self {
        let of = |i: usize| {
            let share = i as f64 / STEPS as f64;
            bessel_i0(BETA * (1.0 - share * share).sqrt()) / bessel_i0(BETA)
        };
        Self {
            window: (0..=STEPS).map(of).collect(),
        }
    }

    /// The value at `place`, counted in samples; outside, the signal continues with its first and last value.
    pub(super) fn at(&self, samples: &[f64], place: f64) -> f64 {
        let base = place.floor();
        let late = place - base;
        let last = samples.len() as i64 - 1;
        let (mut sum, mut weights) = (0.0, 0.0);
        // sin(π(step − late)) is the same for every step but for its sign.
        let sine = (PI * late).sin();
        for step in 1 - HALF as i64..=HALF as i64 {
            let away = step as f64 - late;
            let step_of = away.abs() / HALF as f64 * STEPS as f64;
            let window = self.window.get(step_of as usize..);
            let Some([low, high]) = window.and_then(<[f64]>::first_chunk) else {
                continue;
            };
            let window = low + (high - low) * step_of.fract();
            let sinc = match away.abs() < 1e-12 {
                true => 1.0,
                false if step % 2 == 0 => -sine / (PI * away),
                false => sine / (PI * away),
            };
            let at = (base as i64 + step).clamp(0, last.max(0)) as usize;
            sum += samples[at] * sinc * window;
            weights += sinc * window;
        }
        sum / weights
    }
}
