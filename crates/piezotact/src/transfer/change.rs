//! Whether the response to a drive stays the same while it is measured: a finger that lifts and a sensor that comes loose change it.

use num_complex::Complex;
use serde::Serialize;

use super::clock::Blocks;
use crate::quantity::{Band, Hertz, SampleRate};
use crate::statistics::{mean, median};
use crate::warning::{Scatter, ScatterWarning, Warning};

/// The parts of a recording that are compared.
const PARTS: usize = 20;
/// The fewest parts in which the response is another: one more than a moment's disturbance reaches.
const FEWEST_PARTS: usize = 2;
/// A response is another where its complex gain differs from that of the median part by this share, −3.1 or +2.3 dB or 17°, and by
/// so many standard errors.
const DIFFERS: (f64, f64) = (0.3, 6.0);
/// The ratio of the ends of a band, and the fewest lines within one.
const HALF_OCTAVE: f64 = std::f64::consts::SQRT_2;
const FEWEST_LINES: usize = 12;
/// A block with less than this share of the mean power of the drive in a band tells nothing about it.
const LEAST_POWER: f64 = 0.1;
/// A lower gain counts as this, dB.
const NOTHING_DB: f64 = -60.0;

/// How the response to a drive changed while it was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Change {
    /// From when to when, first to last, s.
    pub from_s: f64,
    pub to_s: f64,
    /// The share of the recording in which the response is another, 0–1.
    pub share: f64,
    /// The band in which its level differs most.
    pub band_hz: Band,
    /// The largest difference from the median part there: of the level, dB, and of the phase at the same time, °.
    pub by_db: f64,
    pub by_deg: f64,
    /// The mean normal force then and in the rest, N; absent where none was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_n: Option<[f64; 2]>,
    /// The parts in which it is another, s.
    #[serde(skip)]
    parts_s: Vec<[f64; 2]>,
}

/// The gain of a part of the recording in a band, re the mean of all, and its variance.
struct Gain {
    value: Complex<f64>,
    variance: f64,
}

impl Change {
    /// How the response changed over `blocks`, without those that touch the stretches `lost_s`; `None` where no change is shown.
    ///
    /// Formula: the gain of a part is Σ H̄*·Sxy/Σ |H̄|²·Sxx over its blocks and the lines of half an octave, with H̄ of the whole recording; its
    /// standard error by the differences of neighbouring blocks.
    ///
    /// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 4.6, for the comparison of parts;
    /// docs/decisions/transfer-functions.md.
    pub(super) fn of(blocks: &Blocks, lost_s: &[[f64; 2]]) -> Option<Self> {
        let rate_hz = blocks.rate.hz();
        let half = 0.5 * blocks.span as f64;
        let whole = |at: f64| {
            let [from, to] = [at - half, at + half].map(|sample| sample / rate_hz);
            lost_s.iter().all(|[a, b]| *b <= from || *a >= to)
        };
        let usable: Vec<usize> = (0..blocks.at.len())
            .filter(|i| whole(blocks.at[*i]))
            .collect();
        let of_part = usable.len().div_ceil(PARTS).max(1);
        let parts: Vec<&[usize]> = usable.chunks(of_part).collect();
        let mut changed = vec![false; parts.len()];
        let mut most: Option<([f64; 2], Band)> = None;
        for lines in bands(blocks) {
            let gains = gains(blocks, &lines, &parts);
            let middle = |of: fn(&Gain) -> f64| {
                median(&mut gains.iter().flatten().map(of).collect::<Vec<_>>())
            };
            let (Some(re), Some(im)) = (middle(|g| g.value.re), middle(|g| g.value.im)) else {
                continue;
            };
            let usual = Complex::new(re, im);
            let size = usual.norm().max(f64::MIN_POSITIVE);
            for (gain, changed) in gains.iter().zip(&mut changed) {
                let Some(gain) = gain else { continue };
                let ratio = gain.value / usual;
                let by = (ratio - 1.0).norm();
                if by <= DIFFERS.0.max(DIFFERS.1 * gain.variance.sqrt() / size) {
                    continue;
                }
                *changed = true;
                let db = (20.0 * ratio.norm().log10()).max(NOTHING_DB);
                if most.is_none_or(|([largest, _], _)| db.abs() > largest.abs())
                    && let Ok(band) = blocks.band(&lines)
                {
                    most = Some(([db, ratio.arg().to_degrees()], band));
                }
            }
        }
        let others = parts.iter().zip(&changed).filter(|(_, changed)| **changed);
        let parts_s: Vec<[f64; 2]> = others
            .filter_map(|(part, _)| Some([*part.first()?, *part.last()?]))
            .map(|[first, last]| {
                // Blocks overlap by half.
                [blocks.at[first] - 0.5 * half, blocks.at[last] + 0.5 * half].map(|s| s / rate_hz)
            })
            .collect();
        let ([by_db, by_deg], band_hz) = most?;
        (parts_s.len() >= FEWEST_PARTS).then_some(Self {
            from_s: parts_s.first()?[0],
            to_s: parts_s.last()?[1],
            share: parts_s.len() as f64 / parts.len() as f64,
            band_hz,
            by_db,
            by_deg,
            force_n: None,
            parts_s,
        })
    }

    /// The same with the normal force `force_n` at `rate` in those parts and in the rest, N.
    pub(super) fn with_force(self, force_n: &[f64], rate: SampleRate) -> Self {
        let (mut then, mut rest) = (Vec::new(), Vec::new());
        for (i, force_n) in force_n.iter().enumerate() {
            match self.holds(i, rate) {
                true => then.push(*force_n),
                false => rest.push(*force_n),
            }
        }
        self.with_mean_forces([mean(&then), mean(&rest)])
    }

    /// The same with the mean normal forces in those parts and in the rest, N.
    pub(super) fn with_mean_forces(self, force_n: [f64; 2]) -> Self {
        Self {
            force_n: Some(force_n),
            ..self
        }
    }

    /// Whether the sample `i` at `rate` lies in those parts.
    pub(super) fn holds(&self, i: usize, rate: SampleRate) -> bool {
        let at_s = i as f64 / rate.hz();
        self.parts_s.iter().any(|[a, b]| (*a..*b).contains(&at_s))
    }

    /// The warning about it.
    pub(super) fn warning(&self) -> Warning {
        ScatterWarning::Scatter {
            of: Scatter::Response {
                from_s: self.from_s,
                to_s: self.to_s,
                share: self.share,
                band_hz: self.band_hz,
                by_db: self.by_db,
                by_deg: self.by_deg,
                force_n: self.force_n,
            },
        }
        .into()
    }
}

/// The excited lines in bands of half an octave, wider where these hold few lines.
fn bands(blocks: &Blocks) -> Vec<Vec<usize>> {
    let mut bands: Vec<Vec<usize>> = Vec::new();
    for line in &blocks.lines {
        match bands.last_mut() {
            Some(band)
                if band.len() < FEWEST_LINES || (*line as f64) < HALF_OCTAVE * band[0] as f64 =>
            {
                band.push(*line);
            }
            _ => bands.push(vec![*line]),
        }
    }
    bands.retain(|band| band.len() >= FEWEST_LINES);
    bands
}

/// The gain of each part over `lines`, where the drive has power there.
fn gains(blocks: &Blocks, lines: &[usize], parts: &[&[usize]]) -> Vec<Option<Gain>> {
    let count = blocks.at.len() as f64;
    let mean_of = |line: usize| -> Complex<f64> {
        let all: Complex<f64> = blocks.cross.iter().map(|cross| cross[line]).sum();
        all / blocks.drive_power[line].max(f64::MIN_POSITIVE)
    };
    let whole: Vec<Complex<f64>> = lines.iter().map(|line| mean_of(*line)).collect();
    let sums = |block: usize| -> (Complex<f64>, f64, f64) {
        let (mut over, mut under, mut power) = (Complex::default(), 0.0, 0.0);
        for (line, h) in lines.iter().zip(&whole) {
            let driven = blocks.drive[block][*line];
            over += h.conj() * blocks.cross[block][*line];
            under += h.norm_sqr() * driven;
            power += driven;
        }
        (over, under, power)
    };
    let usual = lines
        .iter()
        .map(|line| blocks.drive_power[*line])
        .sum::<f64>()
        / count;
    let of_parts: Vec<Vec<(Complex<f64>, f64)>> = parts
        .iter()
        .map(|part| {
            let of_blocks = part.iter().map(|block| sums(*block));
            let driven =
                of_blocks.filter(|(_, under, power)| *power >= LEAST_POWER * usual && *under > 0.0);
            driven.map(|(over, under, _)| (over, under)).collect()
        })
        .collect();
    let single: Vec<Complex<f64>> = of_parts.iter().flatten().map(|(o, u)| o / u).collect();
    let pairs = single.windows(2).map(|pair| (pair[1] - pair[0]).norm_sqr());
    // The squared difference of two is exponentially distributed.
    let variance = median(&mut pairs.collect::<Vec<f64>>()).unwrap_or(0.0);
    let variance = variance / (2.0 * std::f64::consts::LN_2);
    let gain = |part: Vec<(Complex<f64>, f64)>| {
        let over: Complex<f64> = part.iter().map(|(over, _)| over).sum();
        let under: f64 = part.iter().map(|(_, under)| under).sum();
        (!part.is_empty()).then(|| Gain {
            value: over / under,
            variance: variance * super::clock::OVERLAP / part.len() as f64,
        })
    };
    of_parts.into_iter().map(gain).collect()
}

impl Blocks {
    /// From the first to the last of `lines`.
    fn band(&self, lines: &[usize]) -> Result<Band, crate::quantity::QuantityError> {
        let hz = |line: usize| Hertz(line as f64 * self.rate.hz() / self.segment as f64);
        Band::new(hz(lines[0]), hz(lines[lines.len() - 1]))
    }
}
