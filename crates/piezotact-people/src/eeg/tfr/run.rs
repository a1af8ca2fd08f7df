//! The convolution of epochs with wavelets, by transforms that are planned once.

use piezotact::fourier::{Complex, Fft};

use super::{TfrError, TfrPlan};
use crate::eeg::epochs::Epochs;

/// So many epochs are transformed before the wavelets are gone through, so that a wavelet is read once for all of them.
const BLOCK: usize = 8;

/// What takes the coefficients of one channel, epoch and frequency; the power is |z|² for each time.
pub(in crate::eeg) trait Sink {
    fn take(&mut self, channel: usize, epoch: usize, frequency: usize, z: &[Complex<f64>]);
}

impl<A: Sink, B: Sink> Sink for (&mut A, &mut B) {
    fn take(&mut self, channel: usize, epoch: usize, frequency: usize, z: &[Complex<f64>]) {
        self.0.take(channel, epoch, frequency, z);
        self.1.take(channel, epoch, frequency, z);
    }
}

/// The transform of `wave` about its middle, for transforms of `length`, whose scale it holds: real, as a wavelet is symmetric about its
/// middle.
pub(super) fn response(
    wave: &[Complex<f64>],
    length: usize,
    forward: &dyn Fft<f64>,
    scratch: &mut [Complex<f64>],
) -> Vec<f64> {
    let middle = (wave.len() - 1) / 2;
    let mut bins = vec![Complex::default(); length];
    for (i, value) in wave.iter().enumerate() {
        // A wavelet is shorter than the transform, and so is its half.
        bins[(i + length - middle) % length] += value / length as f64;
    }
    forward.process_with_scratch(&mut bins, scratch);
    bins.iter().map(|bin| bin.re).collect()
}

/// The smallest length from `n` up whose prime factors are 2, 3 and 5 with at least a factor of 8: quick to transform.
pub(super) fn good_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    let from = n.max(8).next_multiple_of(8);
    (from..).step_by(8).find(|m| smooth(*m)).unwrap_or(from)
}

impl TfrPlan {
    /// Gives `sink` the coefficients of all epochs: for each channel and block of epochs, for each frequency and epoch.
    pub(in crate::eeg) fn run(
        &self,
        epochs: &Epochs,
        sink: &mut impl Sink,
    ) -> Result<(), TfrError> {
        if epochs.samples() != self.samples || epochs.rate() != self.rate {
            return Err(TfrError::Epochs {
                samples: self.samples,
                rate_hz: self.rate.hz(),
                found: epochs.samples(),
                found_hz: epochs.rate().hz(),
            });
        }
        let arch = pulp::Arch::new();
        let folded = self.length / self.config.decimation;
        let times = self.times();
        let mut spectra = vec![Complex::default(); BLOCK * self.length];
        let mut work = vec![Complex::default(); folded];
        let needed = self
            .forward
            .get_inplace_scratch_len()
            .max(self.inverse.get_inplace_scratch_len());
        let mut scratch = vec![Complex::default(); needed];
        let all: Vec<usize> = (0..epochs.count()).collect();
        for channel in 0..epochs.channels().len() {
            for block in all.chunks(BLOCK) {
                for (spectrum, &epoch) in spectra.chunks_exact_mut(self.length).zip(block) {
                    let signal = epochs.signal(channel, epoch);
                    for (bin, value) in spectrum.iter_mut().zip(signal) {
                        *bin = Complex::from(*value);
                    }
                    spectrum[self.samples..].fill(Complex::default());
                    self.forward.process_with_scratch(spectrum, &mut scratch);
                }
                for (frequency, response) in self.responses.iter().enumerate() {
                    for (spectrum, &epoch) in spectra.chunks_exact(self.length).zip(block) {
                        arch.dispatch(|| multiply(spectrum, response, &mut work));
                        self.inverse.process_with_scratch(&mut work, &mut scratch);
                        sink.take(channel, epoch, frequency, &work[..times]);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The product of a spectrum and a response, folded to the length of `out`: the transform of every so many-th sample.
#[inline(always)]
fn multiply(spectrum: &[Complex<f64>], response: &[f64], out: &mut [Complex<f64>]) {
    let folded = out.len();
    for (fold, (bins, gains)) in spectrum
        .chunks_exact(folded)
        .zip(response.chunks_exact(folded))
        .enumerate()
    {
        let products = bins.iter().zip(gains);
        if fold == 0 {
            for (out, (bin, gain)) in out.iter_mut().zip(products) {
                *out = Complex::new(bin.re * gain, bin.im * gain);
            }
        } else {
            for (out, (bin, gain)) in out.iter_mut().zip(products) {
                out.re += bin.re * gain;
                out.im += bin.im * gain;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TfrConfig, TfrPlan};
    use super::*;
    use crate::eeg::tfr::wavelet::morlet;
    use piezotact::quantity::SampleRate;

    /// Power is that of the plain sum over the wavelet, for every decimation.
    #[test]
    fn power_is_that_of_the_convolution() {
        let rate = SampleRate::new(200.0).unwrap();
        let n = 301;
        let signal: Vec<f64> = (0..n)
            .map(|i| (0.3 * f64::from(i)).sin() + (0.01 * f64::from(i * i)).cos())
            .collect();
        let epochs = Epochs::new(
            vec!["C3".into()],
            vec!["a".into()],
            rate,
            0.0,
            signal.clone(),
        )
        .unwrap();
        let wavelet = morlet(10.0, 3.0 / (std::f64::consts::TAU * 10.0), 200.0);
        let half = (wavelet.len() / 2) as i64;
        for decimation in [1, 2, 5, 7] {
            let config = TfrConfig {
                frequencies_hz: vec![10.0],
                cycles: vec![3.0],
                decimation,
            };
            let plan = TfrPlan::plan(&config, rate, n as usize).unwrap();
            let power = plan.average(&epochs).unwrap();
            assert_eq!(power.values.len(), (n as usize).div_ceil(decimation));
            for (i, got) in power.values.iter().enumerate() {
                let t = (i * decimation) as i64;
                let z: Complex<f64> = (-half..=half)
                    .filter(|k| (0..i64::from(n)).contains(&(t - k)))
                    .map(|k| wavelet[(k + half) as usize] * signal[(t - k) as usize])
                    .sum();
                assert!((got - z.norm_sqr()).abs() < 1e-9 * (1.0 + z.norm_sqr()));
            }
        }
    }

    #[test]
    fn lengths_are_quick() {
        assert_eq!(
            [1, 9, 2397, 2401, 480].map(good_length),
            [8, 16, 2400, 2560, 480]
        );
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let rate = SampleRate::new(200.0).unwrap();
        let plan = |frequencies_hz: Vec<f64>, cycles: Vec<f64>, decimation| {
            let config = TfrConfig {
                frequencies_hz,
                cycles,
                decimation,
            };
            TfrPlan::plan(&config, rate, 400)
        };
        assert!(plan(vec![10.0], vec![4.0], 1).is_ok());
        assert!(plan(vec![], vec![], 1).is_err());
        assert!(plan(vec![10.0], vec![4.0, 5.0], 1).is_err());
        assert!(plan(vec![10.0], vec![0.0], 1).is_err());
        assert!(plan(vec![101.0], vec![4.0], 1).is_err());
        assert!(plan(vec![10.0], vec![4.0], 0).is_err());
        assert!(plan(vec![10.0], vec![4.0], usize::MAX).is_err());
        assert!(plan(vec![1e-300], vec![4.0], 1).is_err());
        assert!(matches!(
            plan(vec![4.0], vec![7.0], 1),
            Err(TfrError::LongerThanEpoch { .. })
        ));
    }
}
