//! Band-limited random noise of unlimited length, generated on demand.

use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex;
use piezotact::quantity::Band;
use piezotact_fourier::{ComplexToReal, RealPlanner};

use super::RATE_HZ;
use piezotact_bench::random::Random;

/// Gaussian noise of a flat spectrum within a band, at the rate of the acquisition. Independent blocks of Gaussian
/// bins overlap by half under a sine window: sin² + cos² = 1, so the power is constant, and over lags d short
/// against a block the covariance is that of the band times cos(πd/N), at every place in a block alike. The
/// window smears the edges of the band by about 1 Hz; 10 Hz outside it is 50 dB down.
pub(super) struct BandNoise {
    random: Random,
    lines: std::ops::Range<usize>,
    /// The standard deviation of a bin's real and imaginary part.
    bin: f64,
    window: Vec<f64>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    bins: Vec<Complex<f64>>,
    block: Vec<f64>,
    /// The second half of the last block, windowed.
    tail: Vec<f64>,
    ready: VecDeque<f64>,
}

impl BandNoise {
    /// A block's length: 1.6 s.
    const BLOCK: usize = 8192;
    /// The step between a block's bins, Hz.
    pub(super) const RESOLUTION_HZ: f64 = RATE_HZ / Self::BLOCK as f64;

    /// Noise of `rms` within `band`; silence when no bin lies in it.
    pub(super) fn new(band: Band, rms: f64, random: Random) -> Self {
        let inverse = RealPlanner::new().plan_fft_inverse(Self::BLOCK);
        let first = (band.low().0 / Self::RESOLUTION_HZ).ceil().max(1.0) as usize;
        let end = ((band.high().0 / Self::RESOLUTION_HZ) as usize + 1).min(Self::BLOCK / 2);
        let lines = first..end.max(first);
        let mut noise = Self {
            random,
            // K bins of two parts each add 4·bin²·K to the variance.
            bin: rms / 2.0 / (lines.len().max(1) as f64).sqrt(),
            lines,
            window: (0..Self::BLOCK)
                .map(|i| (PI * (i as f64 + 0.5) / Self::BLOCK as f64).sin())
                .collect(),
            bins: inverse.make_input_vec(),
            block: inverse.make_output_vec(),
            inverse,
            tail: Vec::new(),
            ready: VecDeque::new(),
        };
        noise.draw();
        noise.tail = noise.block[Self::BLOCK / 2..].to_vec();
        noise
    }

    /// The next `count` samples.
    pub(super) fn take(&mut self, count: usize) -> Vec<f64> {
        while self.ready.len() < count {
            self.draw();
            let (head, tail) = self.block.split_at(Self::BLOCK / 2);
            self.ready
                .extend(head.iter().zip(&self.tail).map(|(new, old)| new + old));
            self.tail = tail.to_vec();
        }
        self.ready.drain(..count).collect()
    }

    /// Another block, windowed.
    fn draw(&mut self) {
        self.bins.fill(Complex::default());
        for bin in &mut self.bins[self.lines.clone()] {
            *bin = Complex::new(self.random.normal(), self.random.normal()) * self.bin;
        }
        let done = self.inverse.process(&mut self.bins, &mut self.block);
        debug_assert!(done.is_ok());
        for (sample, w) in self.block.iter_mut().zip(&self.window) {
            *sample *= w;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Acceleration, Hertz, SampleRate};
    use piezotact::series::Series;
    use piezotact::spectrum::{WelchConfig, welch};
    use piezotact::statistics::rms;

    fn noise(seed: u64) -> BandNoise {
        let band = Band::new(Hertz(2.0), Hertz(1000.0)).unwrap();
        BandNoise::new(band, 0.5, Random::stream(seed, 0, "noise"))
    }

    #[test]
    fn the_level_is_the_rms_asked_for_and_pieces_are_the_whole() {
        let whole = noise(3).take(200_000);
        // 40 s of 998 Hz hold 80 000 independent numbers: four standard errors of their rms are 1 %.
        assert!((rms(&whole) / 0.5 - 1.0).abs() < 0.01, "{}", rms(&whole));
        let mut pieces = noise(3);
        let mut taken = Vec::new();
        for count in [1, 4095, 4097, 100_000, 0, 91_807] {
            taken.extend(pieces.take(count));
        }
        assert!(taken == whole);
    }

    /// At the joints of blocks and in their middles the power is the same, over 1 400 blocks.
    #[test]
    fn the_power_is_the_same_everywhere_in_a_block() {
        let hop = BandNoise::BLOCK / 2;
        let all = noise(5).take(1_400 * hop);
        let power = |place: usize| {
            let near = all
                .chunks(hop)
                .flat_map(|block| &block[place..place + hop / 16]);
            let squares: Vec<f64> = near.map(|v| v * v).collect();
            squares.iter().sum::<f64>() / squares.len() as f64
        };
        for place in [0, hop / 4, hop / 2, hop - hop / 16] {
            // 1 400 times 51 ms of 998 Hz: 143 000 independent numbers, four standard errors are 1.5 %.
            assert!((power(place) / 0.25 - 1.0).abs() < 0.015, "{place}");
        }
    }

    #[test]
    fn the_band_is_flat_and_empty_outside() {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let series = Series::<Acceleration>::new(noise(7).take(600_000), rate).unwrap();
        let spectrum = welch(&series, &WelchConfig::hann(2048)).unwrap();
        let expected = 0.25 / 998.0;
        for (f, value) in spectrum.frequencies_hz().iter().zip(&spectrum.values) {
            if (8.0..994.0).contains(f) {
                // 585 half-overlapping segments: a standard error of 4.3 %, and five of them.
                assert!((value / expected - 1.0).abs() < 0.22, "{f} Hz: {value:e}");
            }
            // The sine window leaves the cube of the distance: 50 dB at 10 Hz, 70 dB at 50 Hz.
            if *f > 1050.0 {
                assert!(value / expected < 1e-6, "{f} Hz: {value:e}");
            }
        }
    }
}
