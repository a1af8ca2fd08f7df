//! How much memory a comparison takes for each sample of the recordings. Decision 0060 says what the limits are for.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where it cannot go on, and says what it measured"
)]

use num_complex::Complex;
use peak_alloc::PeakAlloc;
use piezotact::Series;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate};
use piezotact::render::{self, RenderConfig, render};
use piezotact::score::{self, ScoreConfig, score};
use piezotact::statistics::random::Random;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{self, Measured, VerifyConfig, verify};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The largest number of bytes that `work` holds at a time beyond what there was before, for each of `samples`.
fn bytes_a_sample<T>(samples: usize, work: impl FnOnce() -> T) -> f64 {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let _result = work();
    (MEMORY.peak_usage() - before) as f64 / samples as f64
}

/// Noise of `seconds` at `rate_hz`, and the same a little louder and with a little noise of its own.
fn pair(rate_hz: f64, seconds: f64) -> [Series<Acceleration>; 2] {
    let rate = SampleRate::new(rate_hz).unwrap();
    let mut random = Random::stream(1, 1, "memory");
    let mut smooth = 0.0;
    let target: Vec<f64> = (0..(rate_hz * seconds) as usize)
        .map(|_| {
            smooth += 0.1 * (10.0 * random.normal() - smooth);
            smooth
        })
        .collect();
    let measured = target.iter().map(|v| 1.02 * v + 0.01 * random.normal());
    let measured = Series::new(measured.collect(), rate).unwrap();
    [Series::new(target, rate).unwrap(), measured]
}

/// One test, as the counts are of the whole program.
#[test]
fn a_comparison_takes_few_bytes_a_sample() {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    for (rate_hz, seconds) in [(5000.0, 100.0), (48_000.0, 12.0)] {
        let [target, measured] = pair(rate_hz, seconds);
        let samples = target.samples().len();
        let scored = bytes_a_sample(samples, || {
            score(&target, &measured, &ScoreConfig::over(band, rate_hz)).unwrap()
        });
        let verified = bytes_a_sample(samples, || {
            let measured = Measured::alone(&measured);
            verify(&target, measured, &VerifyConfig::over(band, rate_hz)).unwrap()
        });
        // A device of 20 m/s² at full scale, whatever the frequency.
        let lines = vec![Complex::from(20.0); 1025];
        let rate = SampleRate::new(rate_hz).unwrap();
        let device = TransferFunction::<Drive, Acceleration>::from_lines(
            lines,
            vec![1.0; 1025],
            rate_hz / 2048.0,
            rate,
            Estimator::H1,
            100,
        );
        let (device, soft) = (device.unwrap(), target.clone().amplified(Decibels(-20.0)));
        let config = RenderConfig::over(band, SampleRate::new(48_000.0).unwrap());
        let rendered = bytes_a_sample(samples, || render(&soft, &device, &config).unwrap());
        assert!(rendered < render::MEMORY_BYTES_A_SAMPLE as f64);
        println!(
            "{rate_hz} Hz: render {rendered:.0}, score {scored:.0}, verify {verified:.0} bytes a sample"
        );
        assert!(
            scored < score::MEMORY_BYTES_A_SAMPLE as f64
                && verified < verify::MEMORY_BYTES_A_SAMPLE as f64
        );
    }
}
