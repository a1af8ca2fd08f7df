//! A line of the mains in EEG, which filters of amplifiers leave without its multiples.

use std::f64::consts::TAU;

use piezotact::fourier::hann;
use piezotact::quantity::SampleRate;

/// The networks of the world, Hz.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
/// Where the floor around a line is taken, Hz to either side.
const BESIDE_HZ: [f64; 6] = [-5.0, -4.0, -3.0, 3.0, 4.0, 5.0];
/// The length of segments, s, and the fewest.
const SEGMENT_S: f64 = 2.0;
const SEGMENTS: usize = 4;
/// A line stands out whose power is so many times that of the floor.
const STANDS_OUT: f64 = 10.0;

/// The frequency of the strongest line of the mains, Hz, and its share of the power about the mean, 0–1; `None` where none stands 10 dB over
/// the floor within 5 Hz, or there are less than 8 s.
pub(super) fn line(samples: &[f64], rate: SampleRate) -> Option<(f64, f64)> {
    let length = rate.samples_in(piezotact::quantity::Seconds(SEGMENT_S));
    if length == 0 || samples.len() < SEGMENTS * length {
        return None;
    }
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let power = samples.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / samples.len() as f64;
    let window: Vec<f64> = (0..length)
        .map(|i| hann(i as f64 / length as f64))
        .collect();
    let at = |hz: f64| tone_power(samples, mean, &window, hz / rate.hz());
    let found = MAINS_HZ.into_iter().filter_map(|mains_hz| {
        if mains_hz + BESIDE_HZ[5] >= rate.nyquist().0 {
            return None;
        }
        let mut floor = BESIDE_HZ.map(|beside| at(mains_hz + beside));
        floor.sort_by(f64::total_cmp);
        let (line, middle) = (at(mains_hz), 0.5 * (floor[2] + floor[3]));
        (line > STANDS_OUT * middle && power > 0.0).then(|| (mains_hz, (line / power).min(1.0)))
    });
    found.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The power of a steady tone of `turns` periods a sample, averaged over segments.
fn tone_power(samples: &[f64], mean: f64, window: &[f64], turns: f64) -> f64 {
    let weight: f64 = window.iter().sum();
    let segments = samples.chunks_exact(window.len());
    let count = segments.len() as f64;
    let powers = segments.map(|segment| {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, (value, weight)) in segment.iter().zip(window).enumerate() {
            let (sine, cosine) = (TAU * (turns * i as f64).fract()).sin_cos();
            re += weight * (value - mean) * cosine;
            im += weight * (value - mean) * sine;
        }
        2.0 * (re * re + im * im) / (weight * weight)
    });
    powers.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_share() {
        let rate = SampleRate::new(250.0).unwrap();
        let of = |hz: f64, level: f64| -> Vec<f64> {
            (0..5000_usize)
                .map(|i| {
                    let noise = ((i * 7919 + i * i * 31) % 1009) as f64 / 1009.0 - 0.5;
                    level * (TAU * hz * i as f64 / 250.0).sin() + noise
                })
                .collect()
        };
        let (hz, share) = line(&of(50.03, 1.0), rate).unwrap();
        assert!(hz == 50.0 && (0.8..0.95).contains(&share), "{share}");
        assert_eq!(line(&of(60.0, 1.0), rate).unwrap().0, 60.0);
        assert!(
            line(&of(50.0, 0.0), rate).is_none() && line(&of(50.0, 1.0)[..1500], rate).is_none()
        );
    }
}
