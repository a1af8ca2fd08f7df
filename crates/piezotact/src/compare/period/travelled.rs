//! The spatial period along the way of strokes of any speed, whose motion was measured.

use std::f64::consts::TAU;

use num_complex::Complex;
use serde::Serialize;

use super::judged::Candidate;
use super::moving::{ALL_MOVE, LinesOfSpeeds, log_normal};
use super::spectra::{Spectrum, spectrum_up_to};
use super::{
    FoundIn, HIGHEST_OF_FEW, PeriodUnit, SCATTER_DB, Sliding, SpatialPeriod, agreed, noise_db,
};
use crate::feature::{Peak, peaks};
use crate::fourier::RealTransform;
use crate::quantity::{Band, Hertz, SampleRate, Uncalibrated, Unit};
use crate::spectrum::{Symmetry, WelchConfig, WelchPlan, Window, frequency_axis};
use crate::statistics::mean;
use crate::stroke::Way;

/// The part of a stroke that moves one way, with what vibrates in it.
#[derive(Clone, Debug)]
pub(crate) struct Travelled<'a> {
    /// The number of its recording.
    pub(crate) recording: usize,
    pub(crate) way: Way,
    /// Every channel, a value for each sample of the way.
    pub(crate) vibration: Vec<&'a [f64]>,
}

/// What strokes say along the way, at whatever speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AlongTheWay {
    /// The spectrum over the wavenumber.
    pub spectrum: WaySpectrum,
    /// The spatial period, or why it is not decided; absent where the strokes have no line in common.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<SpatialPeriod>,
}

/// The power spectral density of a vibration along the way, the mean over strokes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct WaySpectrum {
    /// The unit of the densities, that of the vibration squared, times m.
    pub unit: String,
    /// The lines, 1/m.
    pub wavenumber_1_m: Vec<f64>,
    /// The densities.
    pub mean: Vec<f64>,
    /// Its peaks, the strongest first.
    pub peaks: Vec<WayPeak>,
}

/// A peak of a spectrum along the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct WayPeak {
    /// Where it is, 1/m.
    pub wavenumber_1_m: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
    /// Which multiple of a lower peak it is; 1 when it is none.
    pub harmonic: usize,
}

/// Strokes slower than this share of the fastest are left out: a metre of them has many more samples.
const SLOWEST: f64 = 0.2;
/// A speed that is so many times that of its stroke is a jump of the sensor.
const JUMPS: f64 = 4.0;
/// A harmonic of a period is this near its multiple, as a share …
const TOOTH: f64 = 0.06;
/// … and no further than this share of the distance between harmonics.
const BETWEEN: f64 = 0.3;
/// Harmonics up to this one are looked for.
const HARMONICS: u32 = 12;
/// A speed that changes by no more than this share is constant.
const STEADY: f64 = 0.03;
/// How far the level of a line is from what a tone has, dB: its amplitude changes along the stroke.
const TONE_SPREAD_DB: f64 = 3.0;
/// Frequencies around the line that a tone may have, of each bin of a transform of twice the length.
const PADDING: usize = 2;

/// The spatial period along the way of `parts`, recorded at `rate`; none where they are too short or too slow, or have no line in common.
///
/// The vibration is resampled so that its samples are equal ways apart. Candidates, multiples and criteria are those of
/// [`super::spatial_period`], with the slower and the faster strokes as two speeds. Whether a line moves with the speed is decided by the strokes
/// themselves: a tone e^(2πi·x/λ) of the way x is sharp along the way and spread in time as the speeds differ; a line of a machine is sharp in time and
/// spread along the way.
///
/// Formula: D = mean level of the line along the way − the highest mean level at one frequency that the speeds pass, dB, Hann windows. A line
/// that moves has D = a, one that stays D = −b: what a tone of the way loses in time and one of the time along the way, above the noise
/// around it. Log likelihoods are those of a normal variable around them, s² = (5.57/√strokes)² + 3² dB².
///
/// The period is the geometric mean over the harmonics that stand out of n times their wavelength, the interval ± t·s/√n over recordings, or over the harmonics of the
/// only one: its strokes touch the same place, so that they are no repeats, while each harmonic has its own error where a line is broad.
///
/// Source: order tracking, K. R. Fyfe and E. D. S. Munck (1997), Mech. Syst. Signal Process. 11(2), 187–205; house rule for the likelihoods.
pub(crate) fn along_the_way(
    parts: &[Travelled<'_>],
    rate: SampleRate,
    lowest: Hertz,
    unit: &Unit,
) -> Option<AlongTheWay> {
    let speeds = parts.iter().map(|part| part.way.speed_m_s(rate));
    let usual_m_s = speeds.fold(0.0, f64::max);
    let mut parts: Vec<&Travelled<'_>> = (parts.iter())
        .filter(|part| {
            let way = &part.way;
            let jumps = way.fastest_m_s > JUMPS * way.speed_m_s(rate);
            way.slowest_m_s >= SLOWEST * usual_m_s && !jumps
        })
        .collect();
    let fastest_m_s = parts.iter().map(|p| p.way.fastest_m_s).fold(0.0, f64::max);
    parts.sort_by(|a, b| a.way.speed_m_s(rate).total_cmp(&b.way.speed_m_s(rate)));
    let slow = parts.iter().map(|p| p.way.slowest_m_s);
    let slowest_m_s = slow.fold(f64::MAX, f64::min);
    let step_m = slowest_m_s / rate.hz();
    let even = Even {
        strokes: parts.iter().map(|part| part.every(step_m)).collect(),
        slowest_m_s,
        rate,
        lowest,
        // Above, the fastest part holds nothing.
        highest: Hertz(rate.nyquist().0 * slowest_m_s / fastest_m_s),
    };
    Some(AlongTheWay {
        spectrum: even.spectrum(unit)?,
        period: period(&parts, &even),
    })
}

/// Strokes with samples equal ways apart: as those of one speed, the slowest of all.
struct Even {
    /// The channels of every stroke.
    strokes: Vec<Vec<Vec<f64>>>,
    slowest_m_s: f64,
    rate: SampleRate,
    /// What all of them hold, at the slowest speed.
    lowest: Hertz,
    highest: Hertz,
}

impl Even {
    /// The lines of some `strokes`, of which all hold what `lowest` is at the slowest speed.
    fn lines<'s>(
        &self,
        strokes: impl Iterator<Item = &'s Vec<Vec<f64>>>,
        lowest: Hertz,
    ) -> Option<Spectrum> {
        let sliding = Sliding {
            speed_m_s: self.slowest_m_s,
            rate: self.rate,
            group: String::new(),
            stretches: strokes.flatten().map(Vec::as_slice).collect(),
        };
        spectrum_up_to(&sliding, lowest, self.highest)
    }

    /// By Welch's method, segments as long as the shortest stroke or shorter.
    fn spectrum(&self, unit: &Unit) -> Option<WaySpectrum> {
        let stretches: Vec<&[f64]> = self.strokes.iter().flatten().map(Vec::as_slice).collect();
        let shortest = stretches.iter().map(|s| s.len()).min()?;
        let segment = (shortest / 2 + 1).next_power_of_two();
        let config = WelchConfig::hann(segment.min(shortest));
        let mut plan = WelchPlan::new(&config, self.rate).ok()?;
        let found = plan.estimate::<Uncalibrated>(&stretches).ok()?;
        let band = Band::new(self.lowest, self.highest).ok()?;
        let peak = |peak: Peak| WayPeak {
            wavenumber_1_m: peak.frequency_hz / self.slowest_m_s,
            prominence_db: peak.prominence_db,
            harmonic: peak.harmonic,
        };
        let peaks = peaks(&found.values, found.resolution_hz, band);
        let lines = frequency_axis(found.resolution_hz, found.values.len()).into_iter();
        let held = lines
            .zip(&found.values)
            .filter(|(hz, _)| band.contains(*hz));
        let (wavenumber_1_m, mean) = held
            .map(|(hz, value)| (hz / self.slowest_m_s, value * self.slowest_m_s))
            .unzip();
        Some(WaySpectrum {
            unit: unit.of_psd_along_a_way(),
            wavenumber_1_m,
            mean,
            peaks: peaks.into_iter().map(peak).collect(),
        })
    }
}

fn period(parts: &[&Travelled<'_>], even: &Even) -> Option<SpatialPeriod> {
    let (rate, even_strokes) = (even.rate, &even.strokes);
    // Two halves of two strokes at least.
    let middle = match even_strokes.len() {
        few @ 0..=3 => few,
        several => several / 2,
    };
    // Faster strokes hold longer periods.
    let half = |from: usize, to: usize| {
        let slow = parts[from..to].iter().map(|part| part.way.slowest_m_s);
        let slowest_m_s = slow.fold(f64::MAX, f64::min);
        let lowest = Hertz(even.lowest.0 * even.slowest_m_s / slowest_m_s);
        even.lines(even_strokes[from..to].iter(), lowest)
    };
    let halves = [half(0, middle), half(middle, even_strokes.len())];
    let all: Vec<Spectrum> = halves.into_iter().flatten().collect();
    let found = agreed(&all)?;
    let wavenumber = found.wavenumber;
    let mut recordings: Vec<usize> = parts.iter().map(|part| part.recording).collect();
    recordings.sort_unstable();
    recordings.dedup();
    let teeth = |recording: usize| -> Vec<f64> {
        let own = parts.iter().zip(even_strokes);
        let own = own.filter(|(part, _)| part.recording == recording);
        let own = even.lines(own.map(|(_, stroke)| stroke), even.lowest);
        own.map_or_else(Vec::new, |own| teeth(&own, wavenumber))
    };
    let (over, units) = match recordings.as_slice() {
        [only] => (PeriodUnit::Harmonics, teeth(*only)),
        several => {
            let each = several.iter().map(|recording| teeth(*recording));
            let each = each.filter(|teeth| !teeth.is_empty());
            (
                PeriodUnit::Recordings,
                each.map(|teeth| mean(&teeth)).collect(),
            )
        }
    };
    let units: Vec<(f64, f64)> = units.into_iter().map(|log| (log, 1.0)).collect();
    let strokes = parts.len() as f64;
    let prominence_db = found.prominence_db;
    let lines = tones(parts, rate, wavenumber, prominence_db).lines(strokes);
    Candidate {
        found_in: FoundIn::Way,
        all: &all,
        agreed: found,
        lines,
        groups: Vec::new(),
        over,
        units,
    }
    .judged()
}

impl Travelled<'_> {
    /// Every channel as at a constant speed, where that of the stroke changes; `None` where it does not.
    pub(crate) fn at_speed(&self, rate: SampleRate, speed_m_s: f64) -> Option<Vec<Vec<f64>>> {
        let changes = self.way.fastest_m_s > (1.0 + STEADY) * self.way.slowest_m_s;
        changes.then(|| self.every(speed_m_s / rate.hz()))
    }

    /// Every channel as it was recorded.
    pub(crate) fn samples(&self) -> Vec<Vec<f64>> {
        self.vibration
            .iter()
            .map(|channel| channel.to_vec())
            .collect()
    }

    /// Every channel at ways `step_m` apart, by a cubic through the four samples around.
    fn every(&self, step_m: f64) -> Vec<Vec<f64>> {
        let way_m = &self.way.way_m;
        let count = (self.way.length_m() / step_m) as usize;
        let mut places = Vec::with_capacity(count);
        let mut i = 0;
        for k in 0..count {
            let wanted_m = k as f64 * step_m;
            while i + 2 < way_m.len() && way_m[i + 1] <= wanted_m {
                i += 1;
            }
            let step = (way_m[i + 1] - way_m[i]).max(f64::MIN_POSITIVE);
            places.push((i, ((wanted_m - way_m[i]) / step).clamp(0.0, 1.0)));
        }
        let channels = self.vibration.iter();
        channels
            .map(|samples| {
                let at = |i: isize| samples[i.clamp(0, samples.len() as isize - 1) as usize];
                let places = places.iter();
                places
                    .map(|(i, t)| {
                        let i = *i as isize;
                        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
                        // Catmull and Rom (1974).
                        b + 0.5
                            * t
                            * (c - a
                                + t * (2.0 * a - 5.0 * b + 4.0 * c - d
                                    + t * (3.0 * (b - c) + d - a)))
                    })
                    .collect()
            })
            .collect()
    }
}

/// Levels of a line along the way and in time, dB.
struct Tones {
    /// Along the way, minus the highest at one frequency.
    found_db: f64,
    /// The same of a tone of the way …
    moving_db: f64,
    /// … and of a tone at that frequency.
    fixed_db: f64,
    frequency_hz: f64,
}

impl Tones {
    fn lines(&self, strokes: f64) -> LinesOfSpeeds {
        let variance = SCATTER_DB.powi(2) / strokes + TONE_SPREAD_DB.powi(2);
        let moving = log_normal(self.found_db - self.moving_db, variance);
        let fixed = log_normal(self.found_db - self.fixed_db, variance);
        LinesOfSpeeds {
            moving_log_likelihood: moving,
            fixed_log_likelihood: fixed,
            moving_speeds: usize::from(moving >= fixed + ALL_MOVE),
            telling_speeds: 1,
            fixed_hz: Vec::from_iter((fixed >= moving + ALL_MOVE).then_some(self.frequency_hz)),
            ..LinesOfSpeeds::default()
        }
    }
}

/// The logarithm of the period in m that each harmonic of `wavenumber` speaks for, of those that stand out: the first is looked for within 6 %, the
/// others around the mean of both passes.
fn teeth(own: &Spectrum, wavenumber: f64) -> Vec<f64> {
    let around = |centre: f64| -> Vec<f64> {
        let harmonics = (1..=HARMONICS).map_while(|n| {
            let order = f64::from(n);
            let expected = order * centre;
            (own.reaches(expected) && expected < own.wavenumbers.last().copied()?)
                .then_some((order, expected))
        });
        let found = harmonics.filter_map(|(order, expected)| {
            let reach = TOOTH.min(BETWEEN / order);
            let mut peaks = own.peaks(expected).into_iter();
            let peak = peaks.find(|peak| {
                let off = peak.frequency_hz / own.speed_m_s / expected - 1.0;
                off.abs() <= reach
            })?;
            (peak.prominence_db >= noise_db(HIGHEST_OF_FEW, &[own]))
                .then(|| (order * own.speed_m_s / peak.frequency_hz).ln())
        });
        found.collect()
    };
    let first = around(wavenumber);
    match first.is_empty() {
        true => first,
        false => around((-mean(&first)).exp()),
    }
}

/// The levels of the line at `wavenumber`, which stands `prominence_db` above the noise around it.
fn tones(parts: &[&Travelled<'_>], rate: SampleRate, wavenumber: f64, prominence_db: f64) -> Tones {
    let longest = parts
        .iter()
        .map(|part| part.way.way_m.len())
        .max()
        .unwrap_or(0);
    let n = (PADDING * longest).next_power_of_two();
    let mut transform = RealTransform::new(n);
    let bin_hz = rate.hz() / n as f64;
    let speeds = |of: fn(f64, f64) -> f64, from: f64| {
        let means = parts.iter().map(|part| part.way.speed_m_s(rate));
        means.fold(from, of)
    };
    let (slow, fast) = (speeds(f64::min, f64::MAX), speeds(f64::max, 0.0));
    let first = (wavenumber * slow / bin_hz) as usize;
    let last = ((wavenumber * fast / bin_hz).ceil() as usize).min(n / 2);
    let bins = first.saturating_sub(1)..=last + 1;
    let windows: Vec<Vec<f64>> = (parts.iter())
        .map(|part| Window::Hann.coefficients(part.way.way_m.len(), Symmetry::Periodic))
        .collect();
    let mut in_time = |samples: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut padded: Vec<f64> = samples.collect();
        padded.resize(n, 0.0);
        let power = transform.forward(&padded);
        let bins = bins.clone().filter_map(|bin| power.get(bin));
        bins.map(Complex::norm_sqr).collect()
    };
    let turns = |part: &Travelled<'_>| -> Vec<f64> {
        part.way
            .way_m
            .iter()
            .map(|x| TAU * wavenumber * x)
            .collect()
    };
    // Mean levels over strokes and channels, along the way and at each frequency; with a tone of the way of the amplitude 1.
    let count = parts.iter().map(|part| part.vibration.len()).sum::<usize>() as f64;
    let (mut along_db, mut time_db) = (0.0, vec![0.0; bins.clone().count()]);
    let mut of_tone: Vec<Vec<f64>> = Vec::new();
    let mut whole: Vec<f64> = Vec::new();
    let noise = 10f64.powf(-0.1 * prominence_db.max(0.0));
    for (part, window) in parts.iter().zip(&windows) {
        let turns = turns(part);
        for channel in &part.vibration {
            let level = mean(channel);
            let windowed = || channel.iter().zip(window).map(|(v, w)| (v - level) * w);
            let sum: Complex<f64> = windowed()
                .zip(&turns)
                .map(|(v, turn)| Complex::from_polar(v, -turn))
                .sum();
            along_db += level_db(sum.norm_sqr()) / count;
            for (sum, power) in time_db.iter_mut().zip(in_time(&mut windowed())) {
                *sum += level_db(power) / count;
            }
        }
        let tone = turns.iter().zip(window).map(|(turn, w)| turn.cos() * w);
        let full = (0.5 * window.iter().sum::<f64>()).powi(2);
        of_tone.push(in_time(&mut { tone }));
        whole.push(full);
    }
    let highest = |levels: &[f64]| {
        let numbered = levels.iter().copied().enumerate();
        numbered
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, 0.0))
    };
    let mean_db = |shares: &mut dyn Iterator<Item = f64>| {
        let levels: Vec<f64> = shares
            .map(|share| level_db((share + noise) / (1.0 + noise)))
            .collect();
        mean(&levels)
    };
    let losses: Vec<f64> = (0..time_db.len())
        .map(|bin| {
            mean_db(
                &mut of_tone
                    .iter()
                    .zip(&whole)
                    .map(|(tone, full)| tone.get(bin).copied().unwrap_or(0.0) / full),
            )
        })
        .collect();
    let (bin, highest_db) = highest(&time_db);
    let frequency_hz = (bins.start() + bin) as f64 * bin_hz;
    // A tone at that frequency, along the way.
    let fixed_db = mean_db(&mut parts.iter().zip(&windows).zip(&whole).map(
        |((part, window), full)| {
            let turns = turns(part);
            let sum: Complex<f64> = (turns.iter().zip(window).enumerate())
                .map(|(i, (turn, w))| {
                    let phase = TAU * frequency_hz * i as f64 / rate.hz();
                    Complex::from_polar(0.5 * w, phase - turn)
                })
                .sum();
            sum.norm_sqr() / full
        },
    ));
    Tones {
        found_db: along_db - highest_db,
        moving_db: -highest(&losses).1,
        fixed_db,
        frequency_hz,
    }
}

fn level_db(power: f64) -> f64 {
    10.0 * power.max(f64::MIN_POSITIVE).log10()
}
