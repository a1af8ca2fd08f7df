//! The acceleration of a vibration that was measured as a velocity, as by a laser vibrometer.

use super::{Recording, RecordingWarning};
use crate::number::rounded;
use crate::quantity::Unit;
use crate::warning::Warning;

/// The share of the rate up to which the derivative is right within 1 %.
const BAND: f64 = 1.0 / 6.0;

impl Recording {
    /// The channels `names` that are in m/s become their derivative, in m/s²; a warning for each states that and the band in which
    /// the derivative is right within 1 %, up to a sixth of the rate. Above it is too small.
    ///
    /// Formula: (v₊₃ − 9v₊₂ + 45v₊₁ − 45v₋₁ + 9v₋₂ − v₋₃)/60 times the rate, with fewer neighbours at the ends.
    ///
    /// Source: the central difference of sixth order, as in ISO 4287 for slopes.
    pub(crate) fn differentiate_velocities(&mut self, names: &[String]) {
        for at in 0..self.channels.len() {
            let rate_hz = self.clocks[self.clock_of[at]].rate_hz.hz();
            let channel = &mut self.channels[at];
            if channel.unit != Unit::MetrePerSecond || !names.contains(&channel.name) {
                continue;
            }
            channel.samples = derivative(&channel.samples, rate_hz);
            channel.unit = Unit::MetrePerSecondSquared;
            let what = format!(
                "`{}` is taken as the velocity of the vibration (m/s): its acceleration is the derivative, right within 1 % up to {} Hz and too \
                 small above",
                channel.name,
                rounded(BAND * rate_hz)
            );
            let warning = Warning::from(RecordingWarning::Guessed { what });
            self.about.warnings.push(warning);
        }
    }
}

/// The derivative of `values` by their time in s.
fn derivative(values: &[f64], rate_hz: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |i: usize| {
        let pair = |k: usize| values[i + k] - values[i - k];
        let change = match i.min(last - i) {
            0 if last == 0 => 0.0,
            0 => values[(i + 1).min(last)] - values[i.min(last - 1)],
            1 => pair(1) / 2.0,
            2 => (8.0 * pair(1) - pair(2)) / 12.0,
            _ => (45.0 * pair(1) - 9.0 * pair(2) + pair(3)) / 60.0,
        };
        rate_hz * change
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::derivative;

    #[test]
    fn a_sine_has_its_derivative_within_the_band() {
        let rate_hz = 6000.0;
        for (tone_hz, share) in [(50.0, 1e-6), (400.0, 2e-4), (999.0, 0.01)] {
            let turn = std::f64::consts::TAU * tone_hz / rate_hz;
            let wave = |i: usize| (turn * i as f64).sin();
            let values: Vec<f64> = (0..600).map(wave).collect();
            let found = derivative(&values, rate_hz);
            for (i, found) in found.iter().enumerate().skip(3).take(594) {
                let expected = turn * rate_hz * (turn * i as f64).cos();
                assert!(
                    (found - expected).abs() <= share * turn * rate_hz,
                    "{tone_hz}: {found} {expected}"
                );
            }
        }
        assert_eq!(derivative(&[1.0, 3.0], 10.0), [20.0, 20.0]);
        assert_eq!(derivative(&[1.0], 10.0), [0.0]);
        assert!(derivative(&[], 10.0).is_empty());
    }
}
