//! How independent two spectral estimates are. Another realisation of a noise may share the fine structure of its target (the
//! same lines with other phases) or its course over time (the target played late by an output underrun).

use num_complex::Complex;

use crate::fourier::RealTransform;
use crate::spectrum::{EstimateError, WelchConfig, segments_in};
use crate::statistics::Z_95;

/// The share of the scatter of two independent estimates that remains in one line.
#[derive(Clone, Copy, Debug)]
pub(super) struct IndependentShare {
    /// Its share, 0–1.
    pub(super) share: f64,
    /// The 95 % interval of the share, either side.
    pub(super) ci_half_width: f64,
}

/// Bin powers are limited to this multiple of their mean, so that a tone does not dominate the correlation.
const MOST: f64 = 4.0;
/// The number of bins over which a correlation is estimated.
const BINS: f64 = 1000.0;
/// With fewer segments than this the correlation over time is not estimated.
const FEWEST_SEGMENTS: usize = 8;
/// The smallest half-width of the interval of a share.
const LEAST: f64 = 0.02;

/// The bins of two transforms and the line that each belongs to.
pub(super) struct Bins {
    powers: Vec<[f64; 2]>,
    /// The first bin of each line, and one more.
    begins: Vec<usize>,
}

impl Bins {
    /// The bins of `a` and `b`; `line_of` rises with the bin.
    pub(super) fn of(
        a: &[Complex<f64>],
        b: &[Complex<f64>],
        line_of: impl Fn(usize) -> usize,
    ) -> Self {
        let powers: Vec<[f64; 2]> = a
            .iter()
            .zip(b)
            .map(|(a, b)| [a.norm_sqr(), b.norm_sqr()])
            .collect();
        let mut begins = Vec::new();
        for i in 0..powers.len() {
            while begins.len() <= line_of(i) {
                begins.push(i);
            }
        }
        begins.push(powers.len());
        Self { powers, begins }
    }

    fn begin(&self, line: usize) -> usize {
        let last = self.begins.len() - 1;
        self.begins[line.min(last)]
    }

    fn count(&self, line: usize) -> usize {
        self.begin(line + 1) - self.begin(line)
    }

    /// Sums over the bins of `line`, each about the mean of the bins of up to `reach` lines on either side.
    fn moments(&self, line: usize, reach: usize) -> Moments {
        let near = &self.powers
            [self.begin(line.saturating_sub(reach))..self.begin(line.saturating_add(reach + 1))];
        let n = near.len().max(1) as f64;
        let mean = |which: usize| near.iter().map(|p| p[which]).sum::<f64>() / n;
        let means = [mean(0), mean(1)];
        let limited = |p: &[f64; 2]| {
            [0, 1].map(|which| (p[which] / means[which].max(f64::MIN_POSITIVE)).min(MOST))
        };
        let centre = |which: usize| near.iter().map(|p| limited(p)[which]).sum::<f64>() / n;
        let centres = [centre(0), centre(1)];
        let mut moments = Moments::default();
        for p in &self.powers[self.begin(line)..self.begin(line + 1)] {
            let [x, y] = limited(p);
            moments.add(&Moments {
                product: (x - centres[0]) * (y - centres[1]),
                squares: [(x - centres[0]).powi(2), (y - centres[1]).powi(2)],
            });
        }
        moments
    }
}

/// Sums of products and squares of two quantities about their means.
#[derive(Clone, Copy, Default)]
struct Moments {
    product: f64,
    squares: [f64; 2],
}

impl Moments {
    fn add(&mut self, other: &Self) {
        self.product += other.product;
        self.squares[0] += other.squares[0];
        self.squares[1] += other.squares[1];
    }

    fn correlation(&self) -> f64 {
        let norm = (self.squares[0] * self.squares[1]).sqrt();
        if norm > 0.0 { self.product / norm } else { 0.0 }
    }
}

/// The share of the scatter of two independent estimates of `signals` that remains in each line. `near` holds the coherence
/// about each line and the number of lines on either side from which it was estimated, `holds` the lines with target power;
/// `independent` is the share of the bins that stay independent under the taper.
///
/// Formula: (1 − ρ)/(1 − γ²), no more than 1, with ρ the larger of two correlations and γ² the mean coherence, all over the lines near by with 1000
/// bins or all there are: that of the powers of the bins over the mean of their line, and that of the powers of the
/// segments over the mean of their line and over the level of their segment. For normal noise both are γ². The reach is that of ρ, 1.96·(1 − ρ²)/√N.
///
/// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 9.2: what is coherent scatters together; docs/decisions/verification.md.
pub(super) fn alike(
    signals: [&[f64]; 2],
    welch: &WelchConfig,
    bins: &Bins,
    near: &[(f64, usize)],
    holds: &[usize],
    independent: f64,
) -> Result<Vec<IndependentShare>, EstimateError> {
    let unrelated = IndependentShare {
        share: 1.0,
        ci_half_width: 0.0,
    };
    let mut alike = vec![unrelated; near.len()];
    let in_time = over_time(signals, welch, holds)?;
    let in_frequency: Vec<Moments> = holds
        .iter()
        .map(|line| bins.moments(*line, near[*line].1))
        .collect();
    let counts: Vec<f64> = holds.iter().map(|line| bins.count(*line) as f64).collect();
    let per_line = counts.iter().sum::<f64>() / holds.len().max(1) as f64;
    let reach = (0.5 * BINS / per_line.max(1.0)).ceil() as usize;
    let width = (2 * reach + 1).min(holds.len());
    for (place, line) in holds.iter().enumerate() {
        let from = place.saturating_sub(reach).min(holds.len() - width);
        let window = from..from + width;
        let correlation = |moments: &[Moments]| {
            let mut all = Moments::default();
            moments[window.clone()].iter().for_each(|m| all.add(m));
            all.correlation()
        };
        let both = correlation(&in_frequency).max(in_time.as_deref().map_or(0.0, correlation));
        let coherence = holds[window.clone()]
            .iter()
            .map(|line| near[*line].0)
            .sum::<f64>()
            / width as f64;
        let number = independent * counts[window.clone()].iter().sum::<f64>();
        alike[*line] = IndependentShare {
            share: ((1.0 - both + LEAST) / (1.0 - coherence + LEAST)).clamp(0.0, 1.0),
            ci_half_width: Z_95 * (1.0 - both * both) / number.max(1.0).sqrt(),
        };
    }
    Ok(alike)
}

/// Sums over the segments' powers on each line of `holds`; `None` with too few segments.
fn over_time(
    signals: [&[f64]; 2],
    welch: &WelchConfig,
    holds: &[usize],
) -> Result<Option<Vec<Moments>>, EstimateError> {
    let (segment, hop) = (welch.segment, welch.hop()?);
    let length = signals[0].len().min(signals[1].len());
    let count = segments_in(length, segment, hop);
    if count < FEWEST_SEGMENTS || holds.is_empty() {
        return Ok(None);
    }
    let window = welch.window.coefficients(segment, welch.symmetry);
    let mut transform = RealTransform::new(segment);
    let mut cut = vec![0.0; segment];
    let mut powers = |which: usize, j: usize| -> Vec<f64> {
        let samples = &signals[which][j * hop..];
        for ((place, w), v) in cut.iter_mut().zip(&window).zip(samples) {
            *place = w * v;
        }
        let bins = transform.forward(&cut);
        holds.iter().map(|line| bins[*line].norm_sqr()).collect()
    };
    let mut means = [vec![0.0; holds.len()], vec![0.0; holds.len()]];
    for (which, means) in means.iter_mut().enumerate() {
        for j in 0..count {
            for (mean, power) in means.iter_mut().zip(powers(which, j)) {
                *mean += power / count as f64;
            }
        }
    }
    // Sums of x, y, x², y² and xy.
    let mut sums = vec![[0.0; 5]; holds.len()];
    for j in 0..count {
        let mut relative = |which: usize| -> Vec<f64> {
            let over: Vec<f64> = powers(which, j)
                .iter()
                .zip(&means[which])
                .map(|(power, mean)| power / mean.max(f64::MIN_POSITIVE))
                .collect();
            // A change of level that both signals share is no evidence of the same realisation.
            let level = over.iter().sum::<f64>() / over.len() as f64;
            over.iter()
                .map(|v| (v / level.max(f64::MIN_POSITIVE)).min(MOST))
                .collect()
        };
        let (x, y) = (relative(0), relative(1));
        for ((sum, x), y) in sums.iter_mut().zip(&x).zip(&y) {
            for (place, v) in sum.iter_mut().zip([*x, *y, x * x, y * y, x * y]) {
                *place += v;
            }
        }
    }
    let n = count as f64;
    let moments = |[x, y, xx, yy, xy]: [f64; 5]| Moments {
        product: xy - x * y / n,
        squares: [xx - x * x / n, yy - y * y / n],
    };
    Ok(Some(sums.into_iter().map(moments).collect()))
}
