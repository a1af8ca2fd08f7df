//! Envelopes of cross-correlations: where one signal is in another.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::fourier::{Complex, ComplexPlanner, Fft, fast_length};
use crate::statistics::vertex;

/// So many places are kept.
const PLACES: usize = 6;

/// A signal in which others are looked for. Lags count from `before` samples of silence in front of it.
pub(super) struct Searched {
    bins: Vec<Complex<f64>>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Sums of squares before each sample.
    energy: Vec<f64>,
    before: usize,
    /// The least energy of a sample that counts: less is silence.
    least: f64,
}

/// A place: the lag of the start, between samples, and the correlation of envelopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) at: f64,
    pub(super) correlation: f64,
}

/// What one signal has in common with another at every lag.
pub(super) struct Common<'a> {
    within: &'a Searched,
    /// The product of their transforms at positive frequencies.
    product: Vec<Complex<f64>>,
    /// The length of the one that is looked for.
    length: usize,
    squares: f64,
}

impl Searched {
    /// `samples` for signals of up to `longest` samples, the usual energy of a sample being `usual`.
    pub(super) fn of(samples: &[f64], longest: usize, before: usize, usual: f64) -> Self {
        let n = fast_length(before + samples.len() + longest);
        let mut planner = ComplexPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        let mut bins = vec![Complex::default(); n];
        for (bin, value) in bins[before..].iter_mut().zip(samples) {
            *bin = Complex::from(*value);
        }
        forward.process(&mut bins);
        let mut energy = Vec::with_capacity(samples.len() + 1);
        let mut sum = 0.0;
        energy.push(sum);
        for value in samples {
            sum += value * value;
            energy.push(sum);
        }
        Self {
            bins,
            forward,
            inverse,
            energy,
            before,
            least: 1e-3 * usual,
        }
    }

    /// What `own` has in common with the signal.
    pub(super) fn common(&self, own: &[f64]) -> Common<'_> {
        let n = self.bins.len();
        let mut product = vec![Complex::default(); n];
        for (bin, value) in product.iter_mut().zip(own) {
            *bin = Complex::from(*value);
        }
        self.forward.process(&mut product);
        for (i, (own, within)) in product.iter_mut().zip(&self.bins).enumerate() {
            *own = match i {
                0 => Complex::default(),
                i if 2 * i < n => within * own.conj(),
                _ => Complex::default(),
            };
        }
        Common {
            within: self,
            product,
            length: own.len(),
            squares: own.iter().map(|v| v * v).sum(),
        }
    }

    /// The energy of `length` samples from a lag on.
    fn energy_at(&self, lag: usize, length: usize) -> f64 {
        let last = self.energy.len() - 1;
        let within = |at: usize| at.saturating_sub(self.before).min(last);
        let own = self.energy[within(lag + length)] - self.energy[within(lag)];
        own.max(self.least * length as f64)
    }
}

impl Common<'_> {
    /// The envelope of the correlation over the energies of both, at each of `lags` lags.
    pub(super) fn correlations(&self, lags: usize) -> Vec<f64> {
        let mut values = self.product.clone();
        self.within.inverse.process(&mut values);
        let scale = 2.0 / values.len() as f64;
        let values = values.into_iter().take(lags).enumerate();
        values
            .map(|(lag, value)| self.over_energies(lag, scale * value.norm()))
            .collect()
    }

    fn over_energies(&self, lag: usize, envelope: f64) -> f64 {
        let energies = self.within.energy_at(lag, self.length) * self.squares;
        match energies > 0.0 {
            true => envelope / energies.sqrt(),
            false => 0.0,
        }
    }

    /// The complex correlation at a lag between samples: its envelope is the magnitude.
    pub(super) fn between(&self, lag: f64) -> Complex<f64> {
        let n = self.product.len();
        let step = Complex::from_polar(1.0, TAU * lag / n as f64);
        let mut turn = Complex::from(1.0);
        let mut sum = Complex::default();
        for (i, bin) in self.product[..n.div_ceil(2)].iter().enumerate() {
            // A product of many turns loses digits.
            if i % 512 == 0 {
                turn = Complex::from_polar(1.0, TAU * (lag * i as f64 / n as f64).fract());
            }
            sum += bin * turn;
            turn *= step;
        }
        sum * (2.0 / n as f64)
    }

    /// The place near `lag` where the envelope is largest, and its curvature there: the mean square of the angular frequency about its
    /// mean, rad² per sample².
    pub(super) fn refined(&self, lag: f64) -> (Place, f64) {
        let (mut at, mut bend, mut middle) = (lag, 0.0, 0.0);
        for step in [0.3, 0.1] {
            let [before, here, behind] = [at - step, at, at + step].map(|t| self.between(t).norm());
            let curve = before - 2.0 * here + behind;
            if curve < 0.0 {
                at += (0.5 * step * (before - behind) / curve).clamp(-step, step);
            }
            (bend, middle) = (-curve / (step * step), here);
        }
        let place = Place {
            at,
            correlation: self.over_energies(at.round().max(0.0) as usize, middle),
        };
        let spread = if middle > 0.0 { bend / middle } else { 0.0 };
        (place, spread)
    }

    /// The mean frequency of what both have in common, cycles per sample.
    pub(super) fn frequency(&self) -> f64 {
        let n = self.product.len();
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, bin) in self.product.iter().enumerate().take(n.div_ceil(2)) {
            let size = bin.norm();
            sum += size * i as f64 / n as f64;
            weights += size;
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}

/// The largest maxima that are at least `near` apart, the largest first; each between samples by the parabola through three.
pub(super) fn peaks(values: &[f64], near: usize) -> Vec<Place> {
    let is_peak = |at: &usize| {
        let value = values[*at];
        (*at == 0 || values[at - 1] <= value) && values.get(at + 1).is_none_or(|next| *next < value)
    };
    let mut order: Vec<usize> = (0..values.len()).filter(is_peak).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let mut found: Vec<usize> = Vec::new();
    for at in order {
        if found.len() == PLACES {
            break;
        }
        if found.iter().all(|other| other.abs_diff(at) >= near) {
            found.push(at);
        }
    }
    let between = |at: usize| {
        let value = values[at];
        if at == 0 || at + 1 >= values.len() {
            return at as f64;
        }
        let (before, behind) = (values[at - 1], values[at + 1]);
        at as f64 + vertex([before, value, behind])
    };
    let place = |at: usize| Place {
        at: between(at),
        correlation: values[at],
    };
    found.into_iter().map(place).collect()
}
