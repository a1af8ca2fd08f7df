//! What a vibration excites in both channels over time.

use std::f64::consts::{PI, TAU};

use num_complex::Complex;

use super::Parameters;
use crate::feature::Weighting;
use crate::fourier::{RealTransform, fast_length};
use crate::quantity::Hertz;

/// How often envelopes are sampled, Hz, about: bins of that band alone are transformed back.
const ENVELOPE_RATE_HZ: f64 = 1000.0;
/// The fade of a record that begins or ends abruptly, s.
const FADE_S: f64 = 0.020;
/// Abrupt is what begins with more than these shares of its own level over so many seconds: a zero of a slow vibration is no soft begin.
const ABRUPT: [(f64, f64); 2] = [(0.001, 0.2), (0.004, 0.4)];
/// Silence is what has less than this share over so many seconds.
const SILENT: (f64, f64) = (0.010, 0.02);
/// The silence that is added behind a record, s.
const PAD_S: f64 = 0.25;

/// The silence that is added to both ends of a whole record, s.
const LEAD_S: f64 = 0.1;

/// What a vibration excites over time.
pub(super) struct Excitation {
    /// Power over threshold: rapidly adapting, Pacinian.
    pub(super) power: [Vec<f64>; 2],
    /// The sum of both, weighted by ln(f/Hz).
    pub(super) log_power: Vec<f64>,
    /// The time between two values, s.
    pub(super) step_s: f64,
    /// The spectrum: frequency, Hz, and share of the power over both thresholds.
    pub(super) spectrum: Vec<(f64, f64)>,
    /// Whether it begins and ends by itself, and is not cut out.
    pub(super) whole: bool,
}

/// The gain of a fade of `n` samples at sample `i`.
fn fade(i: usize, n: usize) -> f64 {
    (0.5 * PI * (i as f64 + 0.5) / n as f64).sin().powi(2)
}

/// How a record begins and ends.
pub(crate) struct Ends {
    /// Whether it begins abruptly, and whether it ends so.
    abrupt: [bool; 2],
    /// Whether it begins and ends by itself: it does neither, or silence stands at one of its ends.
    pub(crate) whole: bool,
}

impl Ends {
    /// Of `x`, sampled at `rate_hz`.
    pub(crate) fn of(x: &[f64], rate_hz: f64) -> Self {
        let square: f64 = x.iter().map(|v| v * v).sum();
        let fourth: f64 = x.iter().map(|v| v.powi(4)).sum();
        let own = (fourth / square.max(1e-300)).sqrt().max(1e-300);
        let shares = |seconds: f64| {
            let edge = ((seconds * rate_hz).round() as usize).clamp(1, x.len());
            [&x[..edge], &x[x.len() - edge..]].map(|end| crate::statistics::rms(end) / own)
        };
        let [first, last] = shares(SILENT.0);
        let silent = first.min(last) <= SILENT.1;
        let abrupt = [0, 1].map(|end| {
            let mut levels = ABRUPT.into_iter();
            levels.any(|(seconds, most)| shares(seconds)[end] > most)
        });
        Self {
            abrupt: abrupt.map(|abrupt| abrupt && !silent),
            whole: silent || abrupt == [false, false],
        }
    }
}

/// `x` faded where it begins or ends abruptly, so that a cut makes no click, and whether it is whole.
fn faded(x: &[f64], rate_hz: f64) -> (Vec<f64>, bool) {
    let ends = Ends::of(x, rate_hz);
    let n = ((FADE_S * rate_hz).round() as usize).min(x.len() / 4);
    let mut y = x.to_vec();
    let end = y.len() - 1;
    for i in 0..n {
        if ends.abrupt[0] {
            y[i] *= fade(i, n);
        }
        if ends.abrupt[1] {
            y[end - i] *= fade(i, n);
        }
    }
    (y, ends.whole)
}

/// Adds to `bins` what the receptors feel of the envelope of the part above `demodulation_hz`: displacement, rectified on one side.
fn demodulate(bins: &mut [Complex<f64>], transform: &mut RealTransform, df: f64, from_hz: f64) {
    let length = transform.length();
    let first = (0..bins.len()).find(|k| *k as f64 * df >= from_hz);
    let Some(first) = first else { return };
    let mut values = vec![Complex::default(); length];
    for k in first..bins.len() {
        // Conjugated, as the transform is that to bins.
        values[k] = (2.0 * bins[k] / (TAU * k as f64 * df).powi(2)).conj();
    }
    piezotact_fourier::complex_forward(length).process(&mut values);
    let rectified: Vec<f64> = values
        .iter()
        .map(|v| v.norm() / length as f64 / PI)
        .collect();
    let low = transform.forward(&rectified);
    for k in 0..first {
        let f = k as f64 * df;
        if f >= 20.0 {
            bins[k] += low[k] * (TAU * f).powi(2);
        }
    }
}

impl Excitation {
    /// Of acceleration `x`, m/s², of which the skin has the share `skin`, an amplitude ratio by frequency in Hz.
    pub(super) fn of(x: &[f64], rate_hz: f64, p: &Parameters, skin: &dyn Fn(f64) -> f64) -> Self {
        let (mut x, whole) = faded(x, rate_hz);
        if whole {
            // What begins and ends by itself is felt alike with silence around it and without.
            let silence = vec![0.0; (LEAD_S * rate_hz).round() as usize];
            x = [silence.as_slice(), &x, &silence].concat();
        }
        let n = x.len();
        let pad = fast_length(n + (PAD_S * rate_hz) as usize);
        let df = rate_hz / pad as f64;
        let mut transform = RealTransform::new(pad);
        let mut bins = transform.forward(&x);
        for (k, bin) in bins.iter_mut().enumerate().skip(1) {
            *bin *= skin(k as f64 * df);
        }
        demodulate(&mut bins, &mut transform, df, p.demodulation_hz);

        let m = (ENVELOPE_RATE_HZ * pad as f64 / rate_hz) as usize;
        let step_s = pad as f64 / rate_hz / m as f64;
        bins.truncate(m);
        let offset = 10f64.powf(p.threshold_offset_db / 20.0);
        let (mut weights, mut logs) = ([Vec::new(), Vec::new()], Vec::new());
        let mut spectrum = Vec::with_capacity(bins.len());
        let mut all = 0.0;
        for (k, bin) in bins.iter_mut().enumerate() {
            let f = (k as f64 * df).max(0.5);
            let audible = if k as f64 * df < 1.0 { 0.0 } else { 1.0 };
            *bin *= audible / (1.0 + (p.low_hz / f).powi(4)).sqrt();
            let knee = 10f64.powf(12.0 * (f / p.rapid_knee_hz).log2().max(0.0) / 20.0);
            let rapid = Weighting::RapidlyAdapting.threshold_m_s2(Hertz(f)) * knee * offset;
            let pacinian = Weighting::Pacinian.threshold_m_s2(Hertz(f)) * offset;
            let power = bin.norm_sqr() * (rapid.powi(-2) + pacinian.powi(-2));
            all += power;
            spectrum.push((f, power));
            weights[0].push(1.0 / rapid);
            weights[1].push(1.0 / pacinian);
            logs.push(f.ln().max(0.0).sqrt());
        }
        for (_, power) in &mut spectrum {
            *power /= all.max(1e-300);
        }

        let keep = m.min((n as f64 / rate_hz / step_s).ceil() as usize);
        let plan = piezotact_fourier::complex_forward(m);
        let scale = 0.5 / (pad as f64).powi(2);
        let power = |weight: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut values = vec![Complex::default(); m];
            for (k, bin) in bins.iter().enumerate() {
                values[k] = (2.0 * bin * weight(k)).conj();
            }
            plan.process(&mut values);
            values[..keep]
                .iter()
                .map(|v| scale * v.norm_sqr())
                .collect()
        };
        let mut log_power = power(&|k| weights[0][k] * logs[k]);
        for (sum, value) in log_power
            .iter_mut()
            .zip(power(&|k| weights[1][k] * logs[k]))
        {
            *sum += value;
        }
        Self {
            power: [power(&|k| weights[0][k]), power(&|k| weights[1][k])],
            log_power,
            step_s,
            spectrum,
            whole,
        }
    }
}

/// The mean of ln f of `spectrum` and its standard deviation, weighted by felt intensity: what lies within a third of an octave is felt
/// together, of a power of `total` over threshold.
///
/// Formula: weights P/E·((1 + E)^(g/2) − 1), E the power within a sixth of an octave on either side, g the exponent of intensity.
pub(super) fn centre(spectrum: &[(f64, f64)], total: f64, p: &Parameters) -> (f64, f64) {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for (_, power) in spectrum {
        sum += power;
        sums.push(sum);
    }
    let sixth = 2f64.powf(1.0 / 6.0);
    let mut moments = [0.0; 3];
    for (f, power) in spectrum {
        let low = spectrum.partition_point(|(g, _)| *g < f / sixth);
        let high = spectrum.partition_point(|(g, _)| *g <= f * sixth);
        let near = (total * (sums[high] - sums[low])).max(1e-12);
        let weight = power / near * ((1.0 + near).powf(p.growth / 2.0) - 1.0);
        let log = f.ln();
        for (moment, factor) in moments.iter_mut().zip([1.0, log, log * log]) {
            *moment += weight * factor;
        }
    }
    let mean = moments[1] / moments[0].max(1e-300);
    let square = moments[2] / moments[0].max(1e-300);
    (mean, (square - mean * mean).max(0.0).sqrt())
}

/// `x` after a pole of time constant `tau_s`.
pub(super) fn one_pole(x: &[f64], tau_s: f64, step_s: f64) -> Vec<f64> {
    let a = (-step_s / tau_s).exp();
    let mut y = 0.0;
    x.iter()
        .map(|v| {
            y = (1.0 - a) * v + a * y;
            y
        })
        .collect()
}

/// `x` after two of them.
pub(super) fn two_poles(x: &[f64], tau_s: f64, step_s: f64) -> Vec<f64> {
    one_pole(&one_pole(x, tau_s, step_s), tau_s, step_s)
}

/// The level of the after-effect of what came before, dB: forward masking that decays with `tau_s` to a residue.
pub(super) fn after_effect(level_db: &[f64], tau_s: f64, step_s: f64, p: &Parameters) -> Vec<f64> {
    let (a, b) = ((-step_s / tau_s).exp(), (-step_s / p.residue_s).exp());
    let (mut fast, mut slow) = (0.0f64, 0.0f64);
    level_db
        .iter()
        .map(|level| {
            let now = fast + slow;
            slow = (p.tail_residue * level).max(slow * b);
            fast = (p.tail_jump * level - slow).max(fast * a).max(0.0);
            now
        })
        .collect()
}

/// `x` smoothed by a bell of 2·`reach` + 1 values.
pub(super) fn smoothed(x: &[f64], reach: usize) -> Vec<f64> {
    let width = 2 * reach + 1;
    if x.len() < width {
        return x.to_vec();
    }
    let bell: Vec<f64> = (0..width)
        .map(|k| 0.5 - 0.5 * (TAU * (k + 1) as f64 / (width + 1) as f64).cos())
        .collect();
    let sum: f64 = bell.iter().sum();
    (0..x.len())
        .map(|i| {
            let first = reach.saturating_sub(i);
            let last = width.min(x.len() + reach - i);
            (first..last)
                .map(|k| bell[k] / sum * x[i + k - reach])
                .sum()
        })
        .collect()
}
