//! Drives that characterise a device.

use num_complex::Complex;
use piezotact::Series;
use piezotact::quantity::{Band, Drive, SampleRate, Seconds};
use realfft::RealFftPlanner;

use crate::random::Random;
use crate::traits::BenchError;

/// A band-limited random drive.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationConfig {
    /// The band that is driven.
    pub band: Band,
    /// How long.
    pub duration: Seconds,
    /// The largest sample, full scale = 1.
    pub peak: f64,
    /// The seed.
    pub seed: u64,
}

/// A random drive whose spectrum is flat in the band and zero outside, with the stated peak.
///
/// Source: thesis 2.5.3, "a random signal up to 1 kHz"; made as Gaussian bins of one long transform, so that
/// there is nothing outside the band and no filter's ripple inside.
///
/// # Errors
/// [`BenchError::Impossible`] when the duration is shorter than a second or longer than 10 minutes, the peak is
/// not from 0.001 to 1, or the band does not fit the rate.
pub fn random_excitation(
    config: &ExcitationConfig,
    rate: SampleRate,
) -> Result<Series<Drive>, BenchError> {
    let impossible = |expected: &str, found: String, todo: &str| BenchError::Impossible {
        expected: expected.into(),
        found,
        todo: todo.into(),
    };
    if !(1.0..=600.0).contains(&config.duration.0) {
        return Err(impossible(
            "a duration from 1 to 600 s",
            config.duration.to_string(),
            "60 s is usual",
        ));
    }
    if !(1e-3..=1.0).contains(&config.peak) {
        return Err(impossible(
            "a peak from 0.001 to 1",
            config.peak.to_string(),
            "0.8 is usual",
        ));
    }
    if config.band.high().0 >= rate.nyquist().0 {
        return Err(impossible(
            &format!("a band below half of {rate}"),
            config.band.to_string(),
            "lower its end",
        ));
    }
    let n = rate.samples_in(config.duration);
    let mut random = Random::stream(config.seed, 0, "excitation");
    let mut bins: Vec<Complex<f64>> = (0..=n / 2)
        .map(|k| {
            if config.band.contains(k as f64 * rate.hz() / n as f64) && k > 0 {
                Complex::new(random.normal(), random.normal())
            } else {
                Complex::default()
            }
        })
        .collect();
    if n.is_multiple_of(2) {
        bins[n / 2].im = 0.0;
    }
    let plan = RealFftPlanner::new().plan_fft_inverse(n);
    let mut samples = plan.make_output_vec();
    let done = plan.process(&mut bins, &mut samples);
    debug_assert!(done.is_ok());
    let largest = piezotact::series::peak(&samples);
    if largest <= 0.0 {
        return Err(impossible(
            &format!(
                "a band wider than the {} Hz that {} resolve",
                1.0 / config.duration.0,
                config.duration
            ),
            config.band.to_string(),
            "widen it, 2..1200 is usual",
        ));
    }
    for sample in &mut samples {
        *sample *= config.peak / largest;
    }
    Ok(Series::new(samples, rate)?)
}
