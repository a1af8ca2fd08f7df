//! What is felt of one vibration.

use super::Parameters;
use super::course::{ALL, SLOW, about_mean, chance, coefficients, wandering};
use super::events::{Rate, Sequence, rate, sequence};
use super::excitation::{Excitation, after_effect, centre, one_pole, smoothed, two_poles};
use super::modulation::{Modulation, modulation};
use super::parameters::{MODULATION_BANDS_HZ, MODULATION_DB};
use crate::statistics::median;

/// dB of a power whose natural logarithm changes by 1.
pub(super) const DB_PER_NEPER: f64 = 4.342_944_819_032_518;
/// What lies this far below the top is not part of a vibration, as a ratio of powers: 25 dB.
const EXTENT: f64 = 316.227_766_016_837_94;
/// The reach of the bell that smooths the louder channel, s.
const BELL_S: f64 = 0.003;
/// The time constant of both poles that smooth the pitch, s.
const PITCH_S: f64 = 0.015;
/// What is left out at both ends where chance is estimated, s, and of dips and bumps.
const CHANCE_MARGIN_S: f64 = 0.030;
const BRIEF_MARGIN_S: f64 = 0.040;
/// The fewest values in which a dip or a bump stands out.
const BRIEF_SHORTEST: usize = 60;
/// Deviations from the median, in standard deviations, that are ordinary: down, up.
const ORDINARY: [f64; 2] = [5.0, 4.0];
/// A standard deviation over the median of the absolute deviation, of normal deviates.
const DEVIATION_OVER_MEDIAN: f64 = 1.4826;
/// Where an onset ends and a release begins, as a share of the own power: −6 dB.
const REACHED: f64 = 0.25;
/// What a scattering level adds to the wait, s per dB·√s.
const WAIT_OF_SCATTER: f64 = 0.020;

/// What has a smaller error of level, dB·√s, has no chance in it: it is a stimulus and no excerpt, and its length is its own.
const WITHOUT_CHANCE: f64 = 0.15;

/// A modulation of less than this share of the one that is felt has no logarithm.
const LEAST_MODULATION: f64 = 0.01;

/// The length of a moment and the time between two, s.
const MOMENT_S: f64 = 0.050;
pub(super) const MOMENT_STEP_S: f64 = 0.010;
/// What is left out is felt from this power over threshold on: 6 dB.
const LEFT_OUT: f64 = 4.0;

/// The variance of a mean from the coefficients of what it is the mean of.
type Variance = fn(&[f64; ALL]) -> f64;

/// What is felt of one vibration.
#[derive(Clone, Debug)]
pub(super) struct Felt {
    pub(super) length_s: f64,
    pub(super) whole: bool,
    /// Whether its begin and its end say something: it is whole, or cut where the other is.
    pub(super) timed: bool,
    /// Power over threshold of each channel, and its standard error in dB.
    pub(super) level: [f64; 2],
    pub(super) level_error_db: [f64; 2],
    pub(super) log_hz: f64,
    pub(super) log_hz_error: f64,
    pub(super) spread: f64,
    /// From the begin to −6 dB and from there to the end, s.
    pub(super) ends_s: [f64; 2],
    /// The mean square of the time that chance adds to an end, s².
    pub(super) wait_s2: f64,
    /// The courses of both levels, dB, and of ln f, and the variance of their coefficients by chance.
    pub(super) course: [[f64; SLOW]; 3],
    pub(super) chance: [f64; 3],
    pub(super) modulation: [[Option<Modulation>; MODULATION_BANDS_HZ.len()]; 2],
    /// The deepest dip and the highest bump, dB.
    pub(super) brief_db: Option<[f64; 2]>,
    pub(super) events: Option<Sequence>,
    pub(super) rate: Option<Rate>,
    /// The levels of both channels over time, dB, in means over 50 ms, 10 ms apart; empty but of what is timed.
    pub(super) moments_db: [Vec<f64>; 2],
    /// Whether it is the mean of excerpts at the same place of a movement, whose course is repeated.
    pub(super) repeated: bool,
    /// How long something is felt before and after what is compared, s.
    pub(super) left_out_s: f64,
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn level_db(power: &[f64]) -> Vec<f64> {
    power.iter().map(|e| 10.0 * (1.0 + e).log10()).collect()
}

impl Felt {
    /// Of acceleration `x`, m/s², of which the skin has the share `skin`. What it is compared with has its time and its chance, but for the
    /// share `independent` of the variance, where that is stated.
    pub(super) fn of(
        x: &[f64],
        rate_hz: f64,
        p: &Parameters,
        skin: &dyn Fn(f64) -> f64,
        independent: Option<f64>,
    ) -> Self {
        let excitation = Excitation::of(x, rate_hz, p, skin);
        let step_s = excitation.step_s;
        let [rapid, pacinian] = &excitation.power;
        let envelopes = [
            two_poles(rapid, p.rapid_envelope_s, step_s),
            two_poles(pacinian, p.pacinian_envelope_s, step_s),
        ];
        let levels = [level_db(&envelopes[0]), level_db(&envelopes[1])];
        let tails_s = [p.rapid_tail_s, p.pacinian_tail_s];
        let tailed: [Vec<f64>; 2] = std::array::from_fn(|c| {
            let after = after_effect(&levels[c], tails_s[c], step_s, p);
            let pairs = envelopes[c].iter().zip(after);
            pairs
                .map(|(e, db)| 10.0 * (e + 10f64.powf(db / 10.0)).log10())
                .collect()
        });
        let louder: Vec<f64> = rapid.iter().zip(pacinian).map(|(a, b)| a.max(*b)).collect();
        let louder = smoothed(&louder, ((BELL_S / step_s).round() as usize).max(1));
        let (on, off) = extent(&louder);
        let n = off - on;
        let integrated = one_pole(&envelopes[1], p.integration_s, step_s);
        let own = [&envelopes[0][on..off], &integrated[on..off]];

        let level = own.map(own_level);
        let (log_hz, spread) = centre(&excitation.spectrum, level[0] + level[1], p);
        let variance = if excitation.whole { chance } else { wandering };
        let total: Vec<f64> = rapid.iter().zip(pacinian).map(|(a, b)| a + b).collect();
        let pitch = Pitch::of(&total, &excitation, on..off, variance);
        let margin = ((CHANCE_MARGIN_S / step_s) as usize).min(n / 8);
        let courses = [&levels[0], &levels[1], &pitch.moved];
        let length_s = n as f64 * step_s;
        let level_error_db = [0, 1].map(|c| level_error_db(&envelopes[c][on..off], variance));
        let mut felt = Self {
            length_s,
            whole: excitation.whole,
            timed: independent.is_some(),
            level,
            level_error_db,
            log_hz,
            log_hz_error: pitch.error,
            spread,
            ends_s: [0.0; 2],
            wait_s2: 0.0,
            course: courses.map(|v| {
                let all = coefficients(&about_mean(&v[on..off]));
                std::array::from_fn(|k| all[k])
            }),
            chance: courses
                .map(|v| chance(&coefficients(&about_mean(&v[on + margin..off - margin])))),
            modulation: [0, 1].map(|c| modulation(&tailed[c][on..off], step_s)),
            brief_db: brief_db([0, 1].map(|c| &tailed[c][on..off]), step_s, p),
            events: None,
            rate: None,
            moments_db: Default::default(),
            repeated: false,
            left_out_s: step_s
                * (louder[..on].iter().chain(&louder[off..]))
                    .filter(|power| **power >= LEFT_OUT)
                    .count() as f64,
        };
        felt.whole |= felt.is_without_chance();
        felt.timed |= felt.whole;
        if felt.timed {
            felt.moments_db = [0, 1].map(|c| moments(&levels[c][on..off], step_s));
        }
        felt.judge_time(&louder[on..off], step_s);
        match independent {
            Some(share) => felt.with_independent(share),
            None => felt,
        }
    }

    /// The mean of excerpts of one texture; `None` of nothing.
    pub(super) fn mean(all: &[&Self]) -> Option<Self> {
        all.first()?;
        let of = |value: &dyn Fn(&Self) -> f64| {
            mean(&all.iter().map(|one| value(one)).collect::<Vec<_>>())
        };
        // The value and the squared standard error of its mean.
        let error = |values: Vec<[f64; 2]>| {
            let n = values.len() as f64;
            let middle = values.iter().map(|v| v[0]).sum::<f64>() / n;
            let squares: f64 = values.iter().map(|v| (v[0] - middle).powi(2)).sum();
            let within = values.iter().map(|v| v[1]).sum::<f64>() / n;
            within.max(squares / (n - 1.0).max(1.0)) / n
        };
        let rates: Option<Vec<&Rate>> = all.iter().map(|one| one.rate.as_ref()).collect();
        let rate = rates.map(|rates| Rate {
            log: mean(&rates.iter().map(|rate| rate.log).collect::<Vec<_>>()),
            error: error(
                rates
                    .iter()
                    .map(|rate| [rate.log, rate.error.powi(2)])
                    .collect(),
            )
            .sqrt(),
        });
        let brief: Vec<[f64; 2]> = all.iter().filter_map(|one| one.brief_db).collect();
        let brief_db = (!brief.is_empty())
            .then(|| [0, 1].map(|k| mean(&brief.iter().map(|db| db[k]).collect::<Vec<_>>())));
        Some(Self {
            length_s: of(&|one| one.length_s),
            whole: false,
            timed: false,
            level: [0, 1].map(|c| of(&|one| one.level[c])),
            level_error_db: [0, 1].map(|c| {
                let db = |one: &&Self| {
                    let level = 10.0 * (1.0 + one.level[c]).log10();
                    [level, one.level_error_db[c].powi(2)]
                };
                error(all.iter().map(db).collect()).sqrt()
            }),
            log_hz: of(&|one| one.log_hz),
            log_hz_error: error(
                all.iter()
                    .map(|one| [one.log_hz, one.log_hz_error.powi(2)])
                    .collect(),
            )
            .sqrt(),
            spread: of(&|one| one.spread),
            modulation: [0, 1].map(|c| {
                std::array::from_fn(|band| {
                    let each: Vec<Modulation> = all
                        .iter()
                        .filter_map(|one| one.modulation[c][band])
                        .collect();
                    let least = LEAST_MODULATION * MODULATION_DB[band].powi(2);
                    (!each.is_empty()).then(|| Modulation {
                        power: mean(&each.iter().map(|one| one.power).collect::<Vec<_>>()),
                        variance: error(
                            each.iter()
                                .map(|one| [one.power.max(least).ln(), one.variance])
                                .collect(),
                        ),
                    })
                })
            }),
            brief_db,
            rate,
            ends_s: [0.0; 2],
            wait_s2: 0.0,
            events: None,
            course: std::array::from_fn(|c| std::array::from_fn(|k| of(&|one| one.course[c][k]))),
            chance: std::array::from_fn(|c| {
                // As one coefficient of noise scatters: those of its course fall with their number.
                let coefficient = |k: usize| {
                    let falls = (k + 1) as f64 / SLOW as f64;
                    error(
                        all.iter()
                            .map(|one| [one.course[c][k], one.chance[c] / falls])
                            .collect(),
                    ) * falls
                };
                mean(&(0..SLOW).map(coefficient).collect::<Vec<_>>())
            }),
            repeated: all.len() > 2,
            moments_db: Default::default(),
            left_out_s: of(&|one| one.left_out_s),
        })
    }

    /// The same, of whose variance by chance the share `independent` alone is its own; when it ends depends on where it is cut.
    fn with_independent(mut self, independent: f64) -> Self {
        let ratio = independent.sqrt();
        self.level_error_db = self.level_error_db.map(|error| ratio * error);
        self.log_hz_error *= ratio;
        self.chance = self.chance.map(|variance| independent * variance);
        for found in self.modulation.iter_mut().flatten().flatten() {
            found.variance *= independent;
        }
        if let Some(rate) = &mut self.rate {
            rate.error *= ratio;
        }
        self
    }

    /// The standard deviation by chance of the level at a moment, dB: the smaller of what the error of the mean level makes likely, and of
    /// what one moment differs by from the mean of those beside it.
    ///
    /// Formula: min(ε·√(T/50 ms), 1.48·median|L₋ − 2L + L₊|/√6), ε the standard error of the level over the length T.
    pub(super) fn scatter_of_moments_db(&self) -> f64 {
        let stronger = usize::from(self.level[0] <= self.level[1]);
        let of_mean_db = self.level_error_db[stronger] * (self.length_s / MOMENT_S).sqrt();
        let apart = (MOMENT_S / MOMENT_STEP_S).round() as usize;
        let levels = &self.moments_db[stronger];
        let (near, far) = (levels.iter().skip(apart), levels.iter().skip(2 * apart));
        let three = levels.iter().zip(near).zip(far);
        let mut bends: Vec<f64> = three.map(|((a, b), c)| (a - 2.0 * b + c).abs()).collect();
        // What grows evenly does not bend.
        let of_bends_db = median(&mut bends).map_or(f64::INFINITY, |middle| {
            DEVIATION_OVER_MEDIAN * middle / 6f64.sqrt()
        });
        of_mean_db.min(of_bends_db)
    }

    /// Whether it is a stimulus and no excerpt: there is no chance in its level.
    pub(super) fn is_without_chance(&self) -> bool {
        let stronger = usize::from(self.level[0] <= self.level[1]);
        self.level_error_db[stronger] * self.length_s.sqrt() < WITHOUT_CHANCE
    }

    fn judge_time(&mut self, louder: &[f64], step_s: f64) {
        let own = own_level(louder) * REACHED;
        let first = louder.iter().position(|v| *v >= own);
        let last = louder.iter().rposition(|v| *v >= own);
        if let (Some(first), Some(last)) = (first, last) {
            self.ends_s = [first, louder.len() - 1 - last].map(|n| n as f64 * step_s);
            let stronger = usize::from(self.level[0] <= self.level[1]);
            let scatter = WAIT_OF_SCATTER * self.level_error_db[stronger];
            self.wait_s2 = wait(&louder[first..=last], own, step_s) / self.length_s
                + scatter * scatter * self.length_s;
        }
        let level = level_db(louder);
        self.rate = rate(&level, step_s);
        self.events = if self.timed {
            sequence(&level, step_s)
        } else {
            None
        };
    }
}

/// Where `louder` is felt: from the first to behind the last value that is above threshold and within 25 dB of the top.
fn extent(louder: &[f64]) -> (usize, usize) {
    let top = louder.iter().copied().fold(0.0, f64::max);
    let least = (top / EXTENT).max(1.0);
    let first = louder.iter().position(|v| *v >= least);
    let last = louder.iter().rposition(|v| *v >= least);
    match (first, last) {
        (Some(first), Some(last)) => (first, last + 1),
        _ => (0, louder.len()),
    }
}

/// The means of `level_db` over 50 ms, 10 ms apart.
fn moments(level_db: &[f64], step_s: f64) -> Vec<f64> {
    let count = |s: f64| ((s / step_s).round() as usize).max(1);
    let windows = level_db.windows(count(MOMENT_S));
    windows.step_by(count(MOMENT_STEP_S)).map(mean).collect()
}

/// The mean of `power`, weighted by itself: pauses do not count.
fn own_level(power: &[f64]) -> f64 {
    let squares: f64 = power.iter().map(|v| v * v).sum();
    squares / power.iter().sum::<f64>().max(1e-30)
}

/// The standard error of the own level, dB.
fn level_error_db(power: &[f64], variance: Variance) -> f64 {
    let first = mean(power).max(1e-30);
    let second = (power.iter().map(|v| v * v).sum::<f64>() / power.len().max(1) as f64).max(1e-30);
    let influence: Vec<f64> = power.iter().map(|v| v * v / second - v / first).collect();
    DB_PER_NEPER * (2.0 * variance(&coefficients(&influence))).sqrt()
}

struct Pitch {
    /// The standard error of the mean ln f.
    error: f64,
    /// ln f over time about its mean, as far as it is felt.
    moved: Vec<f64>,
}

impl Pitch {
    fn of(
        total: &[f64],
        excitation: &Excitation,
        felt: std::ops::Range<usize>,
        variance: Variance,
    ) -> Self {
        let log_power = &excitation.log_power;
        let step_s = excitation.step_s;
        let sum: f64 = total[felt.clone()].iter().sum();
        let log_hz = if sum > 0.0 {
            log_power[felt.clone()].iter().sum::<f64>() / sum
        } else {
            0.0
        };
        let level = mean(&total[felt.clone()]).max(1e-12);
        let influence: Vec<f64> = felt
            .map(|i| (log_power[i] - log_hz * total[i]) / level)
            .collect();
        let smooth = two_poles(total, PITCH_S, step_s);
        let smooth_log = two_poles(log_power, PITCH_S, step_s);
        let moved = smooth.iter().zip(smooth_log).map(|(power, log)| {
            if *power > 1e-9 {
                power / (1.0 + power) * (log / power - log_hz)
            } else {
                0.0
            }
        });
        Self {
            error: (2.0 * variance(&coefficients(&influence))).sqrt(),
            moved: moved.collect(),
        }
    }
}

/// The deepest dip and the highest bump of both channels beyond what is ordinary, dB, less near the onset.
fn brief_db(tailed: [&[f64]; 2], step_s: f64, p: &Parameters) -> Option<[f64; 2]> {
    let margin = (BRIEF_MARGIN_S / step_s).round() as usize;
    let n = tailed[0].len().saturating_sub(2 * margin);
    if n < BRIEF_SHORTEST {
        return None;
    }
    let mut found = [0.0f64; 2];
    for level in tailed {
        let v = &level[margin..margin + n];
        let middle = median(&mut v.to_vec())?;
        let mut away: Vec<f64> = v.iter().map(|l| (l - middle).abs()).collect();
        let deviation = DEVIATION_OVER_MEDIAN * median(&mut away)?;
        for (i, level) in v.iter().enumerate() {
            let since_s = (i + margin) as f64 * step_s;
            let gain = 1.0 / (1.0 + p.onset_masking * (-since_s / p.onset_s).exp());
            let beyond = [middle - level, level - middle];
            for k in 0..2 {
                found[k] = found[k].max(gain * (beyond[k] - ORDINARY[k] * deviation));
            }
        }
    }
    Some(found)
}

/// The sum of the cubed durations of the runs below `least`, over 3, s³: over the length, the mean square of a wait from any moment.
fn wait(power: &[f64], least: f64, step_s: f64) -> f64 {
    let runs = power.chunk_by(|a, b| (*a < least) == (*b < least));
    runs.filter(|run| run[0] < least)
        .map(|run| (run.len() as f64 * step_s).powi(3) / 3.0)
        .sum()
}
