//! The decision: how far apart two vibrations are in each feature, and altogether.

use super::course::{SLOW, blur, size};
use super::felt::{DB_PER_NEPER, Felt};
use super::modulation::Modulation;
use super::parameters::{MODULATION_BANDS_HZ, MODULATION_DB, range_ratio, taken_off};
use super::{Contribution, D_PRIME_OF_JND, Estimate, Feature, Parameters, left};
use crate::feature::Receptor;
use crate::quantity::Hertz;

/// The channels in the order of all arrays.
const CHANNELS: [Receptor; 2] = [Receptor::Meissner, Receptor::Pacini];
/// The levels within which JND are interpolated, dB SL: of level from 20, of pitch from 10.
const HIGHEST_DB: f64 = 45.0;
/// Standard errors of the interval, one-sided 90 %.
const ERRORS: f64 = 1.28;
/// The squared weaker channel's part of felt intensity: a half.
const WEAKER: f64 = 0.5;

/// What the decision finds.
pub(super) struct Decision {
    pub(super) contributions: Vec<Contribution>,
    pub(super) jnd: Estimate,
    pub(super) pitch_jnd: f64,
    pub(super) felt_level_db: f64,
    pub(super) sensation_level_db: [f64; 2],
}

/// A JND that is `at_20` at 20 dB SL and `at_35` at 35 dB SL, at `level_db` from `low` on.
fn between(at_20: f64, at_35: f64, level_db: f64, low: f64) -> f64 {
    at_20 * (at_35 / at_20).powf((level_db.clamp(low, HIGHEST_DB) - 20.0) / 15.0)
}

/// The index of the larger.
fn larger(values: [f64; 2]) -> usize {
    usize::from(values[0] <= values[1])
}

struct Comparison<'a> {
    a: &'a Felt,
    b: &'a Felt,
    p: &'a Parameters,
    /// The level of each over its threshold, dB.
    levels_db: [f64; 2],
    level_jnd_db: f64,
    /// Felt intensity by vibration and channel.
    intensity: [[f64; 2]; 2],
    /// How much a channel counts beside the stronger one.
    share: [f64; 2],
    /// How well the weaker vibration is heard, 0–1.
    heard: f64,
    found: Vec<Contribution>,
    errors: Vec<f64>,
    /// The square of what chance may hide of level and pitch, JND².
    hidden: f64,
}

/// How far `a` and `b` are apart.
pub(super) fn decide(a: &Felt, b: &Felt, p: &Parameters) -> Decision {
    let strongest = |felt: &Felt| felt.level[0].max(felt.level[1]);
    let levels_db = [a, b].map(|felt| 10.0 * strongest(felt).max(1e-3).log10());
    let exponent = p.growth / 2.0;
    let intensity = [a, b].map(|felt| felt.level.map(|l| (1.0 + l).powf(exponent) - 1.0));
    let channel = |c: usize| intensity[0][c].max(intensity[1][c]);
    let most = channel(0).max(channel(1));
    let most = if most > 0.0 { most } else { 1e-9 };
    let heard = [a, b].map(|felt| strongest(felt) / (1.0 + strongest(felt)));
    let mut comparison = Comparison {
        a,
        b,
        p,
        levels_db,
        level_jnd_db: between(
            p.level_jnd_20_db,
            p.level_jnd_35_db,
            levels_db[0].max(levels_db[1]),
            20.0,
        ),
        intensity,
        share: [0, 1].map(|c| (channel(c) / most).powi(2)),
        heard: heard[0].min(heard[1]),
        found: Vec::new(),
        errors: Vec::new(),
        hidden: 0.0,
    };
    comparison.level();
    let pitch_jnd = comparison.pitch();
    comparison.time();
    comparison.course();
    comparison.modulation();
    comparison.brief();
    comparison.decided(pitch_jnd)
}

impl Comparison<'_> {
    fn add(&mut self, feature: Feature, channel: Option<usize>, band: Option<f64>, jnd: f64) {
        self.found.push(Contribution {
            feature,
            channel: channel.map(|c| CHANNELS[c]),
            modulation_hz: band.map(Hertz),
            jnd,
            share: 0.0,
        });
    }

    fn level(&mut self) {
        let (a, b) = (self.a, self.b);
        let mut whole = [0.0f64; 2];
        let found: [f64; 2] = std::array::from_fn(|c| {
            let apart_db = 10.0 * ((1.0 + b.level[c]) / (1.0 + a.level[c])).log10();
            let variance = a.level_error_db[c].powi(2) + b.level_error_db[c].powi(2);
            let jnd = self.share[c] / self.level_jnd_db;
            self.errors.push(jnd * variance.sqrt());
            whole[c] = jnd * apart_db.abs();
            jnd * left(apart_db, variance, taken_off::STEADY)
        });
        let c = larger(found);
        self.hidden += whole[0].max(whole[1]).powi(2) - found[c].powi(2);
        self.add(Feature::Level, Some(c), None, found[c]);
    }

    /// The distance in pitch, JND: of pulses by their rate, else of the centre of the spectrum.
    fn pitch(&mut self) -> f64 {
        let (a, b, p) = (self.a, self.b, self.p);
        let centre_hz = (0.5 * (a.log_hz + b.log_hz)).exp();
        let at_20 = p.pitch_jnd_20 * (centre_hz / 80.0).powf(p.pitch_slope);
        let weaker_db = self.levels_db[0].min(self.levels_db[1]);
        let spread = 0.5 * (a.spread.powi(2) + b.spread.powi(2)) / p.pitch_spread.powi(2);
        let jnd = between(at_20, p.pitch_jnd_35, weaker_db, 10.0) * (1.0 + spread).sqrt();
        let variance = a.log_hz_error.powi(2) + b.log_hz_error.powi(2);
        let scale = self.heard / jnd.ln_1p();
        let mut found = scale * left(b.log_hz - a.log_hz, variance, taken_off::STEADY);
        self.errors.push(scale * variance.sqrt());
        self.hidden += (scale * (b.log_hz - a.log_hz)).powi(2) - found.powi(2);
        self.add(Feature::Pitch, None, None, found);
        if let (Some(x), Some(y)) = (a.rate, b.rate) {
            let variance = x.error.powi(2) + y.error.powi(2);
            found =
                self.heard * left(x.log - y.log, variance, taken_off::STEADY) / p.rate_jnd.ln_1p();
            self.add(Feature::PulseRate, None, None, found);
        }
        found
    }

    /// Duration, onset, release and rhythm.
    fn time(&mut self) {
        let (a, b, p) = (self.a, self.b, self.p);
        if a.timed && b.timed && self.heard > 0.5 {
            let felt = |s: f64| p.duration_s + p.duration_share * s;
            let duration = (felt(a.length_s) / felt(b.length_s)).ln().abs() / p.duration_share;
            self.add(Feature::Duration, None, None, duration);
            for (end, feature) in [Feature::Rise, Feature::Fall].into_iter().enumerate() {
                let (x, y) = (a.ends_s[end], b.ends_s[end]);
                let more = left(y - x, a.wait_s2 + b.wait_s2, taken_off::ENDS);
                let least = p.rise_s + p.rise_share * x.min(y);
                let jnd = (p.rise_share * more / least).ln_1p() / p.rise_share;
                self.add(feature, None, None, jnd);
            }
        }
        if let (Some(x), Some(y)) = (&a.events, &b.events) {
            self.add(
                Feature::Accents,
                None,
                None,
                x.accents_jnd(y, self.level_jnd_db),
            );
            self.add(Feature::Rhythm, None, None, x.rhythm_jnd(y, p));
        }
    }

    /// The slow course; two excerpts have no common begin, and none, unless both are means over repetitions.
    fn course(&mut self) {
        let (a, b, p) = (self.a, self.b, self.p);
        if !(a.timed && b.timed || a.repeated && b.repeated) {
            return;
        }
        let length_s = (a.length_s * b.length_s).sqrt();
        let whole = (length_s / (length_s + p.course_whole_s)).sqrt();
        let slow = blur(length_s, p.course_blur_s);
        let found: [f64; 3] = std::array::from_fn(|c| {
            let (weight, times) = match c {
                2 => (1.0 / p.course_pitch.ln_1p(), taken_off::COURSE_OF_PITCH),
                _ => (self.share[c] / self.level_jnd_db, taken_off::COURSE),
            };
            let noise: [f64; SLOW] = std::array::from_fn(|k| {
                slow[k] * SLOW as f64 / (k + 1) as f64 * (a.chance[c] + b.chance[c])
            });
            let delta = std::array::from_fn(|k| slow[k].sqrt() * (a.course[c][k] - b.course[c][k]));
            let error = (2.0 * noise.iter().sum::<f64>() / SLOW as f64).sqrt();
            self.errors.push(whole * weight * error);
            whole * weight * size(&delta, &noise, times, p.course_power)
        });
        let c = larger([found[0], found[1]]);
        self.add(Feature::CourseOfLevel, Some(c), None, found[c]);
        self.add(Feature::CourseOfPitch, None, None, found[2]);
    }

    fn modulation(&mut self) {
        let mut found = [[0.0; MODULATION_BANDS_HZ.len()]; 2];
        for (c, of_channel) in found.iter_mut().enumerate() {
            let pairs = self.a.modulation[c].iter().zip(&self.b.modulation[c]);
            for (band, (x, y)) in pairs.enumerate() {
                if let (Some(x), Some(y)) = (x, y) {
                    let (jnd, error) = self.modulation_jnd(x, y, MODULATION_DB[band]);
                    of_channel[band] = jnd;
                    self.errors.push(error);
                }
            }
        }
        let c = larger(found.map(|of| of.iter().map(|d| d * d).sum()));
        for (band, jnd) in MODULATION_BANDS_HZ.into_iter().zip(found[c]) {
            self.add(Feature::Modulation, Some(c), Some(band), jnd);
        }
    }

    /// The distance of two modulations, and by how much one standard error changes it.
    fn modulation_jnd(&self, x: &Modulation, y: &Modulation, felt_db: f64) -> (f64, f64) {
        let high = x.power.max(y.power).max(1e-9);
        let low = x.power.min(y.power).max(1e-9);
        let variance = x.variance + y.variance;
        let ratio = left((high / low).ln(), variance, taken_off::MODULATION);
        let square = (felt_db * self.p.modulation_scale).powi(2);
        let apart = |ratio: f64| {
            let low = high * (-ratio).exp();
            let both = high + low;
            let noise = square * square + square * both + (self.p.modulation_share * both).powi(2);
            (high - low) / noise.sqrt()
        };
        let found = apart(ratio);
        (found, apart(ratio + variance.sqrt()) - found)
    }

    fn brief(&mut self) {
        if let (Some(x), Some(y)) = (self.a.brief_db, self.b.brief_db) {
            for (k, feature) in [Feature::Dip, Feature::Bump].into_iter().enumerate() {
                let jnd = (x[k] - y[k]).abs() / (self.p.dip_db + 0.5 * x[k].min(y[k]));
                self.add(feature, None, None, jnd);
            }
        }
    }

    fn decided(mut self, pitch_jnd: f64) -> Decision {
        let square: f64 = self.found.iter().map(|f| f.jnd * f.jnd).sum();
        let jnd = square.sqrt();
        let mut ranges = 0.0;
        for one in &mut self.found {
            one.share = one.jnd * one.jnd / square.max(1e-24);
            ranges += (one.share * range_ratio(one.feature).ln()).powi(2);
        }
        let ratio = ranges.sqrt().exp();
        let errors: f64 = self.errors.iter().map(|e| e * e).sum();
        let error = ERRORS * (errors / self.errors.len().max(1) as f64).sqrt();
        let total = self
            .intensity
            .map(|i| 1.0 + i[0].max(i[1]) + WEAKER * i[0].min(i[1]));
        let felt_level_db = 2.0 * DB_PER_NEPER / self.p.growth * (total[1] / total[0]).ln();
        self.found.sort_by(|x, y| y.jnd.total_cmp(&x.jnd));
        Decision {
            contributions: self.found,
            jnd: Estimate {
                value: jnd,
                low: (square - error * error).max(0.0).sqrt() / ratio,
                high: (square + self.hidden.max(0.0) + error * error).sqrt() * ratio,
            },
            pitch_jnd,
            felt_level_db,
            sensation_level_db: self.levels_db,
        }
    }
}

/// Channels this much weaker than the other one at a moment do not count there, dB.
const WEAKER_DB: f64 = 10.0;
/// So many steps are tried either way, as a person does not know when to begin: 0.25 s.
const MOST_STEPS: usize = 25;

/// The largest difference of the levels of two vibrations at one moment, dB, where they are aligned best; `None` of excerpts that are cut
/// anywhere.
///
/// Formula: min over lags of max over moments and channels of |ΔL|.
pub(super) fn moment_apart_db(a: &Felt, b: &Felt) -> Option<f64> {
    let ([a, b], shortest) = ([&a.moments_db, &b.moments_db], MOST_STEPS + 1);
    if a[0].len() < shortest || b[0].len() < shortest {
        return None;
    }
    let apart = |[from_a, from_b]: [usize; 2]| {
        let count = (a[0].len() - from_a).min(b[0].len() - from_b);
        let of = |i: usize| {
            let levels = [0, 1].map(|c| [a[c][from_a + i], b[c][from_b + i]]);
            let strongest = levels.map(|both| both[0].max(both[1]));
            let strongest_db = strongest[0].max(strongest[1]);
            let counted = [0, 1].map(|c| match strongest[c] + WEAKER_DB >= strongest_db {
                true => (levels[c][0] - levels[c][1]).abs(),
                false => 0.0,
            });
            counted[0].max(counted[1])
        };
        (0..count).map(of).fold(0.0, f64::max)
    };
    let lags = (0..=MOST_STEPS).flat_map(|lag| [[lag, 0], [0, lag]]);
    lags.map(apart).reduce(f64::min)
}

/// The share of right judgements of two intervals at `difference_jnd` just-noticeable differences, %.
///
/// Formula: 100·Φ(d′/√2), d′ = 1.16 JND.
///
/// Source: N. A. Macmillan and C. D. Creelman (2005), Detection Theory.
///
/// ```
/// assert!((piezotact::perception::percent_correct(1.0) - 79.4).abs() < 0.1);
/// ```
#[must_use]
pub fn percent_correct(difference_jnd: f64) -> f64 {
    50.0 * statrs::function::erf::erfc(-0.5 * D_PRIME_OF_JND * difference_jnd)
}
