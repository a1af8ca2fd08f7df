//! The bursts of a drive in its recording.

use super::burst::{Bursts, Span, Which};
use super::line::{Found, Line, converged};
use super::matched::{Place, Searched, peaks};
use super::place::{Between, stretched};
use super::search::{ALIKE, FAR_S, LEAST, NEAR_S};
use super::{AlignError, Prepared};
use crate::fourier::Complex;

/// What the interpolation of envelopes and of filters leaves open, s.
const FLOOR_S: f64 = 1e-6;
/// So much may the distance of the bursts differ beside the drift, s: a clock that is not corrected yet shifts each by up to a tenth of a
/// millisecond.
const APART_S: f64 = 5e-4;
/// The share of its power that the band leaves of white noise: its edges rise over a tenth of its width, 1 − 0.2 + 0.2/3.
const BAND_SHARE: f64 = 0.867;

/// A burst where it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Burst {
    pub(super) which: Which,
    pub(super) found: Found,
    /// The standard error of its time, s.
    pub(super) error_s: f64,
}

/// The bursts that a recording holds.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) bursts: Vec<Burst>,
    /// By how much the error of the drift is larger than that of the line through both.
    gain: f64,
}

impl Seen {
    /// The line through both.
    pub(super) fn line(&self) -> Option<Line> {
        let [first, last] = self.bursts.as_slice() else {
            return None;
        };
        let both = [&first.found, &last.found];
        Some(Line::between(both, [first.error_s, last.error_s]).with_gain(self.gain))
    }
}

/// The bursts in the recording, both, one or none.
pub(super) fn seen(both: &Prepared, bursts: &Bursts) -> Result<Seen, AlignError> {
    let (seen, gain) = converged(|drift_ppm, _| {
        let seen = seen_at(both, bursts, drift_ppm)?;
        let found = seen.line().map_or(0.0, |line| line.drift_ppm());
        Ok((seen, found))
    })?;
    Ok(Seen { gain, ..seen })
}

/// As [`seen`], by a clock that is corrected for `drift_ppm`.
fn seen_at(both: &Prepared, bursts: &Bursts, drift_ppm: f64) -> Result<Seen, AlignError> {
    let stretch = 1.0 + 1e-6 * drift_ppm;
    let recorded = stretched(&both.recorded, stretch);
    let templates = [bursts.first, bursts.last].map(|span| template(both, span));
    let longest = templates[0].len().max(templates[1].len());
    let usual = recorded.iter().map(|v| v * v).sum::<f64>() / recorded.len().max(1) as f64;
    let searched = Searched::of(&recorded, longest, 0, usual);
    let near = (NEAR_S * both.rate.hz()).ceil() as usize;
    let places = |own: &[f64]| {
        // Whole bursts alone: a part of one has another middle.
        let Some(lags) = recorded.len().checked_sub(own.len()) else {
            return Vec::new();
        };
        let mut found = peaks(&searched.common(own).correlations(lags + 1), near);
        found.retain(|place| place.correlation >= LEAST);
        found
    };
    let [first, last] = [places(&templates[0]), places(&templates[1])];
    let chosen = chosen(both, bursts, [&first, &last])?;
    let burst = |which: Which, span: Span, own: &[f64], place: Place| {
        let answer = Answer::of(both, &recorded, own, place, usual);
        let half_s = 0.5 * own.len() as f64 / both.rate.hz();
        let burst = Burst {
            which,
            found: Found {
                recorded_s: stretch * (answer.place.at / both.rate.hz() + half_s),
                drive_s: span.from_s.0 + half_s,
                correlation: answer.place.correlation,
            },
            error_s: answer.error_s(both, own.len()),
        };
        (burst, answer)
    };
    let first = chosen[0].map(|place| burst(Which::First, bursts.first, &templates[0], place));
    let last = chosen[1].map(|place| burst(Which::Last, bursts.last, &templates[1], place));
    let mut found: Vec<(Burst, Answer)> = first.into_iter().chain(last).collect();
    if let [(first, one), (last, other)] = found.as_mut_slice() {
        [first.error_s, last.error_s] = one.errors_beside(other, &templates[0], both);
    }
    Ok(Seen {
        bursts: found.into_iter().map(|(burst, _)| burst).collect(),
        gain: 1.0,
    })
}

/// The part of the drive that a burst is, from its exact start on.
fn template(both: &Prepared, span: Span) -> Vec<f64> {
    let rate_hz = both.rate.hz();
    let count = both.rate.samples_in(span.length_s).min(both.drive.len());
    let between = Between::new();
    (0..count)
        .map(|i| between.at(&both.drive, span.from_s.0 * rate_hz + i as f64))
        .collect()
}

/// The places of the two bursts that belong together.
fn chosen(
    both: &Prepared,
    bursts: &Bursts,
    places: [&[Place]; 2],
) -> Result<[Option<Place>; 2], AlignError> {
    let rate_hz = both.rate.hz();
    let expected_s = bursts.last.from_s.0 - bursts.first.from_s.0;
    let tolerance_s = APART_S + 1e-6 * both.config.most_drift_ppm * expected_s;
    let mut pairs: Vec<(f64, [Place; 2])> = Vec::new();
    for first in places[0] {
        for last in places[1] {
            let apart_s = (last.at - first.at) / rate_hz;
            if (apart_s - expected_s).abs() <= tolerance_s {
                pairs.push((first.correlation + last.correlation, [*first, *last]));
            }
        }
    }
    let largest = |one: &&(f64, [Place; 2])| one.0;
    let best = pairs
        .iter()
        .max_by(|a, b| largest(a).total_cmp(&largest(b)));
    let offset_s = |at: f64, span: Span| span.from_s.0 - at / rate_hz;
    if let Some((support, pair)) = best {
        let other = pairs.iter().find(|(own, other)| {
            let away = (other[0].at - pair[0].at).abs() / rate_hz;
            away > NEAR_S && *own >= ALIKE * support
        });
        if let Some((_, other)) = other {
            return Err(AlignError::SeveralPlaces {
                first_s: offset_s(pair[0].at, bursts.first),
                second_s: offset_s(other[0].at, bursts.first),
            });
        }
        return Ok(pair.map(Some));
    }
    let single = |places: &[Place], span: Span| -> Result<Option<Place>, AlignError> {
        match places {
            [best, other, ..] if other.correlation >= ALIKE * best.correlation => {
                Err(AlignError::SeveralPlaces {
                    first_s: offset_s(best.at, span),
                    second_s: offset_s(other.at, span),
                })
            }
            [best, ..] => Ok(Some(*best)),
            [] => Ok(None),
        }
    };
    let first = single(places[0], bursts.first)?;
    let last = single(places[1], bursts.last)?;
    if let (Some(first), Some(last)) = (first, last) {
        return Err(AlignError::BurstsApart {
            expected_s,
            found_s: (last.at - first.at) / rate_hz,
        });
    }
    Ok([first, last])
}

/// The answer to a burst.
struct Answer {
    place: Place,
    /// The mean square of the angular frequency about its mean, rad² per sample².
    spread: f64,
    /// The complex correlation with the burst at whole samples about its place.
    around: Vec<Complex<f64>>,
}

impl Answer {
    /// The answer near `coarse` in the recording to the burst `own`.
    fn of(both: &Prepared, recorded: &[f64], own: &[f64], coarse: Place, usual: f64) -> Self {
        let rate_hz = both.rate.hz();
        let margin = (FAR_S * rate_hz).ceil() as usize;
        let first = (coarse.at.round() as usize).saturating_sub(margin);
        let last = (first + own.len() + 2 * margin).min(recorded.len());
        // Twice the margin in front, so that no lag is before the beginning.
        let part = Searched::of(
            &recorded[first..last],
            own.len() + 2 * margin,
            2 * margin,
            usual,
        );
        let common = part.common(own);
        let lead = 2.0 * margin as f64;
        let (place, spread) = common.refined(coarse.at - first as f64 + lead);
        let lags = 0..=2 * margin;
        let around = lags.map(|lag| common.between(place.at + lag as f64 - margin as f64));
        Self {
            place: Place {
                at: place.at - lead + first as f64,
                ..place
            },
            spread,
            around: around.collect(),
        }
    }

    /// The standard error of its time where there is no other, s: all that is not the burst counts as noise, the answer of a device too.
    ///
    /// Formula: σ² = (1 − ρ²)/(2·B·T·ρ²·β²), with the correlation ρ, the bandwidth B of noise, the length T and the mean square β² of the angular
    /// frequency about its mean.
    ///
    /// Source: G. C. Carter (1987), Proc. IEEE 75(2).
    fn error_s(&self, both: &Prepared, length: usize) -> f64 {
        let rate_hz = both.rate.hz();
        let share = self.place.correlation.clamp(LEAST, 0.999_999).powi(2);
        let band = both.config.band;
        let cells = BAND_SHARE * (band.high().0 - band.low().0) * length as f64 / rate_hz;
        let spread = (self.spread * rate_hz * rate_hz).max(1.0);
        let error_s = ((1.0 - share) / (2.0 * cells * share * spread)).sqrt();
        error_s.hypot(FLOOR_S)
    }

    /// The standard errors of both times, s. A device answers to both bursts alike, as they have one spectrum: what differs is noise.
    ///
    /// Formula: σ = √(n/2)·b/(a·β²), with the power n of the noise of the correlation, half of that of the difference; the root mean square b of
    /// its angular frequency, that of the burst; the correlation a at its place and its curvature β².
    ///
    /// Source: G. C. Carter (1987), Proc. IEEE 75(2); docs/decisions/sound.md.
    fn errors_beside(&self, other: &Self, own: &[f64], both: &Prepared) -> [f64; 2] {
        // The level may change between them, and so may the phase by the error of each place.
        let cross: Complex<f64> = pairs(self, other).map(|(a, b)| a * b.conj()).sum();
        let power: f64 = other.around.iter().map(|b| b.norm_sqr()).sum();
        let gain = if power > 0.0 {
            cross / power
        } else {
            Complex::default()
        };
        let rest: f64 = pairs(self, other)
            .map(|(a, b)| (a - gain * b).norm_sqr())
            .sum();
        // Three numbers are fitted: gain, phase, and the distance of the places.
        let band = both.config.band;
        let width = BAND_SHARE * (band.high().0 - band.low().0) / both.rate.hz();
        let count = self.around.len() as f64;
        let free = (1.0 - 1.5 / (width * count)).max(0.25);
        let noise = rest / (count * free * (1.0 + gain.norm_sqr()));
        let burst = Searched::of(own, own.len(), 0, 0.0);
        let (_, of_burst) = burst.common(own).refined(0.0);
        let middle = self.around.len() / 2;
        [self, other].map(|one| {
            let slope = one.around[middle].norm() * one.spread;
            let error = (0.5 * noise * of_burst).sqrt() / slope.max(f64::MIN_POSITIVE);
            (error / both.rate.hz()).hypot(FLOOR_S)
        })
    }
}

/// The correlations of both answers at the same lags about their places.
fn pairs<'a>(
    one: &'a Answer,
    other: &'a Answer,
) -> impl Iterator<Item = (Complex<f64>, Complex<f64>)> + 'a {
    let both = one.around.iter().zip(&other.around);
    both.map(|(a, b)| (*a, *b))
}
