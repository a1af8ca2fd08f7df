//! Hum of the mains: lines at multiples of 50 or 60 Hz that hold their phase and stand alone.

use serde::{Deserialize, Serialize};

use super::{ChannelFault, SignalWarning};
use crate::fourier::RealTransform;
use crate::fourier::hann;
use crate::quantity::{SampleRate, Seconds};
use crate::statistics::{mean, median};

/// Lines of the mains in a signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Hum {
    /// The frequency of the mains as found, Hz.
    pub mains_hz: f64,
    /// The lines, as multiples of it, lowest first.
    pub harmonics: Vec<usize>,
    /// Their share of the power about the mean, 0–1.
    pub share: f64,
    /// How far the strongest stands above the median of the lines around it, dB.
    pub above_db: f64,
}

impl Hum {
    pub(super) fn warning(&self, channel: String) -> SignalWarning {
        SignalWarning::Channel {
            channel,
            fault: ChannelFault::MainsHum {
                mains_hz: self.mains_hz,
                harmonics: self.harmonics.clone(),
                share: self.share,
                above_db: self.above_db,
            },
        }
    }
}

/// The networks of the world, Hz, and how far they wander.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const WANDER_HZ: f64 = 0.2;
/// Multiples that are looked at.
const HARMONICS: usize = 10;
/// The shortest signal that is looked at, and how much of a longer one.
const SHORTEST: Seconds = Seconds(2.0);
const LONGEST: Seconds = Seconds(10.0);
/// A line stands so far above the median of the lines around it, dB. Noise does so in one of e^22 lines.
const ABOVE_DB: f64 = 15.0;
/// A line of a comb between the multiples stands so far above, dB.
const COMB_DB: f64 = 12.0;
/// A line stands so many times above the mean of the six bins on either side of it: a texture's lines are as wide as its
/// speed varies.
const NARROW: f64 = 25.0;
const BESIDE: usize = 6;
/// The least number of lines of hum, including the first: a tone of a texture may coincide with one or two.
const FEWEST: usize = 3;
/// Hum below this share of the power is not reported.
const LEAST_SHARE: f64 = 1e-3;

/// The power of a signal by frequency, through a Hann window.
struct Lines {
    power: Vec<f64>,
    resolution_hz: f64,
    all: f64,
}

/// One line.
#[derive(Clone, Copy)]
struct Line {
    hertz: f64,
    above_db: f64,
    power: f64,
}

impl Lines {
    fn of(samples: &[f64], rate: SampleRate) -> Option<Self> {
        if rate.duration_of(samples.len()).0 < SHORTEST.0 {
            return None;
        }
        // From the middle of a long signal; the length with small factors is quick to transform.
        let most = samples.len().min(rate.samples_in(LONGEST));
        let length = quick(most);
        let from = (samples.len() - length) / 2;
        let part = &samples[from..from + length];
        let middle = mean(part);
        let windowed: Vec<f64> = part
            .iter()
            .enumerate()
            .map(|(i, v)| (v - middle) * hann(i as f64 / length as f64))
            .collect();
        let bins = RealTransform::new(length).forward(&windowed);
        let power: Vec<f64> = bins.iter().map(|bin| bin.norm_sqr()).collect();
        Some(Self {
            all: power.iter().sum(),
            power,
            resolution_hz: rate.hz() / length as f64,
        })
    }

    fn bin(&self, hertz: f64) -> usize {
        (hertz / self.resolution_hz).round().max(0.0) as usize
    }

    /// How far the strongest bin between two frequencies stands above those around it, whatever its width.
    fn above_db(&self, low_hz: f64, high_hz: f64) -> Option<(usize, f64)> {
        let (low, high) = (self.bin(low_hz), self.bin(high_hz));
        let reach = self.bin(8.0).max(12);
        if low < 4 || high + reach >= self.power.len() {
            return None;
        }
        let at = (low..=high).max_by(|a, b| self.power[*a].total_cmp(&self.power[*b]))?;
        let mut around: Vec<f64> = (at.saturating_sub(reach).max(1)..at.saturating_sub(3))
            .chain(at + 4..=at + reach)
            .map(|bin| self.power[bin])
            .collect();
        let usual = median(&mut around)?.max(f64::MIN_POSITIVE);
        Some((at, 10.0 * (self.power[at] / usual).max(1e-30).log10()))
    }

    /// The line of one phase near `hertz`.
    fn line(&self, hertz: f64, wander_hz: f64, least_db: f64) -> Option<Line> {
        let reach = wander_hz.max(self.resolution_hz);
        let (at, above_db) = self.above_db(hertz - reach, hertz + reach)?;
        let sum = |from: usize, to: usize| self.power[from..=to].iter().sum::<f64>();
        let power = sum(at - 2, at + 2);
        let near = at.saturating_sub(2 + BESIDE);
        let beside = sum(near, at - 3) + sum(at + 3, at + 2 + BESIDE);
        let mean_beside = beside / (2 * BESIDE) as f64;
        if above_db < least_db || self.power[at] < NARROW * mean_beside {
            return None;
        }
        // Between two bins of a Hann window.
        let (left, right) = (self.power[at - 1].sqrt(), self.power[at + 1].sqrt());
        let here = self.power[at].sqrt();
        let (sign, next) = if right > left {
            (1.0, right)
        } else {
            (-1.0, left)
        };
        let ratio = next / here;
        let offset = sign * ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(-0.5, 1.0);
        Some(Line {
            hertz: (at as f64 + offset) * self.resolution_hz,
            above_db,
            power,
        })
    }

    /// The lines at multiples of `mains_hz` that are multiples of one frequency.
    fn harmonics(&self, mains_hz: f64, least_db: f64) -> (f64, Vec<(usize, Line)>) {
        let found: Vec<(usize, Line)> = (1..=HARMONICS)
            .filter_map(|n| {
                let times = n as f64;
                let line = self.line(times * mains_hz, times * WANDER_HZ, least_db)?;
                Some((n, line))
            })
            .collect();
        let strongest = found.iter().max_by(|a, b| a.1.power.total_cmp(&b.1.power));
        let Some((n, line)) = strongest else {
            return (mains_hz, Vec::new());
        };
        let exact_hz = line.hertz / *n as f64;
        let fits = |n: usize, line: &Line| {
            let reach = 0.5 * self.resolution_hz * (1.0 + n as f64 / 2.0).min(2.0);
            (line.hertz - n as f64 * exact_hz).abs() <= reach
        };
        let kept = found.iter().filter(|(n, line)| fits(*n, line)).copied();
        (exact_hz, kept.collect())
    }

    /// Whether lines between the multiples of `mains_hz` say that a comb of a part of it is there.
    fn comb(&self, mains_hz: f64) -> bool {
        [2_usize, 3, 4, 5].into_iter().any(|parts| {
            let spacing = mains_hz / parts as f64;
            let places = (1..=2 * parts).filter(|n| n % parts != 0);
            let (mut lines, mut all) = (0, 0);
            for n in places {
                let hertz = n as f64 * spacing;
                let half = 0.4_f64.max(self.resolution_hz);
                if let Some((_, above_db)) = self.above_db(hertz - half, hertz + half) {
                    all += 1;
                    lines += usize::from(above_db >= COMB_DB);
                }
            }
            all > 0 && 2 * lines >= all
        })
    }
}

/// A line that is there while nothing is touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RestLine {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its mean square, in the square of the unit of the signal.
    pub mean_square: f64,
}

/// A part at rest that is looked at, and the shortest that is.
const REST: Seconds = Seconds(1.0);
const SHORTEST_REST: Seconds = Seconds(0.2);

/// The narrow lines of `rests`, parts of one signal at `rate` in which nothing is touched, lowest first: they come from the mains or from a
/// machine, whatever is touched at other times. Lines below four steps between bins, and of rests shorter than 0.2 s, are not looked for.
///
/// Formula: powers of parts of 1 s, or as long as the longest rest, through a Hann window, averaged; a line stands 15 dB above the median of
/// the bins around it and is as narrow as the window makes it. Mean square 16·Σ|X|²/(3·N²) over its five bins.
///
/// Source: house rule, as for [`mains_hum`]; F. J. Harris (1978), Proc. IEEE 66(1), for the window.
#[must_use]
pub fn lines_at_rest(rests: &[&[f64]], rate: SampleRate) -> Vec<RestLine> {
    let longest = rests.iter().map(|rest| rest.len()).max().unwrap_or(0);
    let length = quick(longest.min(rate.samples_in(REST)));
    if longest < rate.samples_in(SHORTEST_REST) {
        return Vec::new();
    }
    let mut transform = RealTransform::new(length);
    let mut lines = Lines {
        power: vec![0.0; length / 2 + 1],
        resolution_hz: rate.hz() / length as f64,
        all: 0.0,
    };
    let mut parts = 0.0;
    for part in rests.iter().flat_map(|rest| rest.chunks_exact(length)) {
        let middle = mean(part);
        let windowed: Vec<f64> = (part.iter().enumerate())
            .map(|(i, v)| (v - middle) * hann(i as f64 / length as f64))
            .collect();
        for (sum, bin) in lines.power.iter_mut().zip(transform.forward(&windowed)) {
            *sum += bin.norm_sqr();
        }
        parts += 1.0;
    }
    let mut found: Vec<RestLine> = Vec::new();
    for at in 4..lines.power.len().saturating_sub(4) {
        let highest = (at - 2..=at + 2).all(|near| lines.power[near] <= lines.power[at]);
        let line = highest.then(|| lines.line(at as f64 * lines.resolution_hz, 0.0, ABOVE_DB));
        found.extend(line.flatten().map(|line| RestLine {
            frequency_hz: line.hertz,
            mean_square: 16.0 * line.power / (3.0 * parts * (length as f64).powi(2)),
        }));
    }
    found
}

/// The largest length up to `most` without prime factors above 5.
fn quick(most: usize) -> usize {
    let smooth = |mut n: usize| {
        for factor in [2, 3, 5] {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
        }
        n == 1
    };
    (1..=most).rev().find(|n| smooth(*n)).unwrap_or(most)
}

/// The hum of the mains in `samples` at `rate`, with its share of the power, 0–1; `None` where there is none, or less than 2 s.
/// Lines count that hold their phase over the whole, stand 15 dB above their surroundings and are multiples of
/// one frequency within 0.2 Hz of 50 or 60 Hz; three of them with the first are hum, unless a comb with lines between
/// them explains them.
///
/// Source: IEC 61000-4-30 for the frequencies; a machine that slides a periodic texture at exactly this rate makes the
/// same lines.
#[must_use]
pub fn mains_hum(samples: &[f64], rate: SampleRate) -> Option<Hum> {
    let lines = Lines::of(samples, rate)?;
    let mut found: Vec<Hum> = MAINS_HZ
        .into_iter()
        .filter_map(|mains_hz| {
            let (mains_hz, harmonics) = lines.harmonics(mains_hz, ABOVE_DB);
            let first = harmonics.first().is_some_and(|(n, _)| *n == 1);
            if !first || harmonics.len() < FEWEST || lines.comb(mains_hz) {
                return None;
            }
            hum_of(mains_hz, &harmonics, lines.all)
        })
        .collect();
    // Both at once are a comb of 10 Hz.
    if found.len() == 1 { found.pop() } else { None }
}

fn hum_of(mains_hz: f64, harmonics: &[(usize, Line)], all: f64) -> Option<Hum> {
    let share = harmonics.iter().map(|(_, line)| line.power).sum::<f64>() / all;
    let strongest = harmonics.iter().map(|(_, line)| line.above_db);
    (share >= LEAST_SHARE).then(|| Hum {
        mains_hz,
        harmonics: harmonics.iter().map(|(n, _)| *n).collect(),
        share: share.min(1.0),
        above_db: strongest.fold(0.0, f64::max),
    })
}

/// A line of the response that is hum stands so much less above its surroundings in the drive, dB.
const BELOW_DB: f64 = 10.0;

/// The hum in a response that its drive does not hold: one line at the mains' own frequency, or two multiples.
pub(super) fn hum_beside(drive: &[f64], response: &[f64], rate: SampleRate) -> Option<Hum> {
    let (drive, response) = (Lines::of(drive, rate)?, Lines::of(response, rate)?);
    let mut found: Vec<Hum> = MAINS_HZ
        .into_iter()
        .filter_map(|mains_hz| {
            let (mains_hz, mut harmonics) = response.harmonics(mains_hz, ABOVE_DB);
            harmonics.retain(|(_, line)| {
                let near = drive.resolution_hz;
                let excited = drive.above_db(line.hertz - near, line.hertz + near);
                excited.is_none_or(|(_, above_db)| above_db < line.above_db - BELOW_DB)
            });
            let first = harmonics.first().is_some_and(|(n, _)| *n == 1);
            if !first && harmonics.len() < 2 {
                return None;
            }
            hum_of(mains_hz, &harmonics, response.all)
        })
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.into_iter().next()
}
