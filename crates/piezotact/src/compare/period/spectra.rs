//! The spectra of strokes at each speed, over the wavenumber f/v.

use super::{
    HIGHEST_AT_A_SPEED, HIGHEST_OF_MANY, PEAK_DB, PROMINENT_DB, SAME_SPEED, SCATTER_DB, STEP,
    Sliding, SpeedPeak, prominence_near,
};
use crate::fourier::RealTransform;
use crate::quantity::{Hertz, SampleRate};
use crate::spectrum::{Symmetry, Window};
use crate::statistics::{mean, median, vertex};

/// Zeros that a stretch is continued with, as a multiple of its length, so that lines are fine enough.
const PADDING: usize = 8;
/// The peak of one speed is looked for this far from v/λ, as a share of it.
const REACH: f64 = 0.1;
/// A line is as wide as the lobe of the window, this many times 1/T, T the length of a stroke, s …
const LOBE: f64 = 2.0;
/// … or as the speed wanders within a stroke, as a share of its frequency.
pub(super) const WANDER: f64 = 0.03;
/// The level around a line is the median from its width to this many times its width, on both sides.
pub(super) const AROUND: f64 = 4.0;
/// Fewer values than this on a side say nothing of the level around a line.
const FEWEST_AROUND: usize = 8;

/// Lines above this in a spectrum of one speed, for any length.
pub(super) struct Spectrum {
    pub(super) speed_m_s: f64,
    /// 1/m, in steps of [`STEP`].
    pub(super) wavenumbers: Vec<f64>,
    /// The mean level of all stretches, dB, and what it stands above its background by, dB.
    level_db: Vec<f64>,
    pub(super) prominence_db: Vec<f64>,
    /// Stretches that were averaged.
    pub(super) stretches: f64,
    /// The way that the longest of them is, m.
    pub(super) length_m: f64,
}

/// One spectrum for each speed.
pub(super) fn by_speed<'a, 's: 'a>(
    slidings: impl Iterator<Item = &'a Sliding<'s>>,
    lowest: Hertz,
) -> Vec<Spectrum> {
    let mut speeds: Vec<Sliding<'s>> = Vec::new();
    for sliding in slidings {
        let same = |other: &&mut Sliding<'s>| {
            (other.speed_m_s / sliding.speed_m_s - 1.0).abs() < SAME_SPEED
                && (other.rate.hz() / sliding.rate.hz() - 1.0).abs() < SAME_SPEED
        };
        match speeds.iter_mut().find(same) {
            Some(known) => known.stretches.extend(&sliding.stretches),
            None => speeds.push(sliding.clone()),
        }
    }
    speeds.iter().filter_map(|s| spectrum(s, lowest)).collect()
}

impl Spectrum {
    /// Whether it holds a wavenumber.
    pub(super) fn reaches(&self, wavenumber: f64) -> bool {
        self.wavenumbers[0] <= wavenumber * (1.0 + 1e-9)
    }

    /// How far it stands above the background close to a wavenumber, and how far noise does not, dB.
    pub(super) fn found_and_needed_db(&self, wavenumber: f64) -> (f64, f64) {
        let needed_db = PEAK_DB.max(HIGHEST_AT_A_SPEED * SCATTER_DB / self.stretches.sqrt());
        (prominence_near(&[self], wavenumber), needed_db)
    }

    /// The prominence at a wavenumber, dB.
    pub(super) fn at(&self, wavenumber: f64) -> f64 {
        let line = ((wavenumber / self.wavenumbers[0]).ln() / STEP.ln()).round();
        let line = (line.max(0.0) as usize).min(self.prominence_db.len() - 1);
        self.prominence_db[line]
    }

    /// How wide a line at a frequency is, Hz: what lies nearer is the same line.
    pub(super) fn width_hz(&self, hz: f64) -> f64 {
        (LOBE * self.speed_m_s / self.length_m).max(WANDER * hz)
    }

    /// How far the highest level within the width of a line stands above the level around it, dB; none at the ends of what is analysed.
    pub(super) fn line_db(&self, hz: f64) -> Option<f64> {
        let width_hz = self.width_hz(hz);
        let part = |low_hz: f64, high_hz: f64| {
            let place = |hz: f64| {
                let first_hz = self.wavenumbers[0] * self.speed_m_s;
                let place = (hz.max(first_hz) / first_hz).ln() / STEP.ln();
                (place.round() as usize).min(self.level_db.len())
            };
            &self.level_db[place(low_hz)..place(high_hz)]
        };
        let line = part(hz - 0.5 * width_hz, hz + 0.5 * width_hz);
        let reach_hz = AROUND * width_hz;
        let sides = [
            part(hz - reach_hz, hz - width_hz),
            part(hz + width_hz, hz + reach_hz),
        ];
        if line.is_empty() || sides.iter().any(|side| side.len() < FEWEST_AROUND) {
            return None;
        }
        let mut around = sides.concat();
        let highest_db = line.iter().copied().fold(f64::MIN, f64::max);
        Some(highest_db - median(&mut around)?)
    }

    /// The peaks around a wavenumber, the highest first, between lines by a parabola through the three highest in dB.
    pub(super) fn peaks(&self, wavenumber: f64) -> Vec<SpeedPeak> {
        let last = self.wavenumbers.len().saturating_sub(1);
        let mut tops: Vec<usize> = (1..last)
            .filter(|&i| (self.wavenumbers[i] / wavenumber - 1.0).abs() <= REACH)
            .collect();
        tops.sort_by(|a, b| self.level_db[*b].total_cmp(&self.level_db[*a]));
        let hz = |i: usize| self.wavenumbers[i] * self.speed_m_s;
        let mut peaks: Vec<usize> = Vec::new();
        for top in tops {
            let apart = |peak: &usize| (hz(*peak) - hz(top)).abs() > self.width_hz(hz(top));
            if self.prominence_db[top] >= PEAK_DB && peaks.iter().all(apart) {
                peaks.push(top);
            }
        }
        let peak = |top: usize| {
            let place = vertex([top - 1, top, top + 1].map(|i| self.level_db[i]));
            SpeedPeak {
                speed_m_s: self.speed_m_s,
                frequency_hz: hz(top) * STEP.powf(place),
                prominence_db: self.prominence_db[top],
            }
        };
        peaks.into_iter().map(peak).collect()
    }
}

pub(super) fn spectrum(sliding: &Sliding<'_>, lowest: Hertz) -> Option<Spectrum> {
    spectrum_up_to(sliding, lowest, sliding.rate.nyquist())
}

/// As [`spectrum`], of stretches that hold nothing from `highest` on.
pub(super) fn spectrum_up_to(
    sliding: &Sliding<'_>,
    lowest: Hertz,
    highest: Hertz,
) -> Option<Spectrum> {
    let Sliding {
        speed_m_s,
        rate,
        ref stretches,
        ..
    } = *sliding;
    let longest = stretches.iter().map(|s| s.len()).max().unwrap_or(0);
    if !(speed_m_s > 0.0 && speed_m_s.is_finite()) || longest < 32 {
        return None;
    }
    let n = (PADDING * longest).next_power_of_two();
    let mut transform = RealTransform::new(n);
    let bins = n / 2 + 1;
    let mut sums = vec![0.0; bins];
    let mut count = 0.0;
    let mut padded = vec![0.0; n];
    for stretch in stretches.iter().filter(|s| 2 * s.len() > longest) {
        let window = Window::Hann.coefficients(stretch.len(), Symmetry::Periodic);
        let level = mean(stretch);
        padded.fill(0.0);
        for ((out, value), weight) in padded.iter_mut().zip(*stretch).zip(&window) {
            *out = (value - level) * weight;
        }
        let power = transform.forward(&padded);
        let largest = power
            .iter()
            .map(num_complex::Complex::norm_sqr)
            .fold(0.0, f64::max);
        if largest <= 0.0 {
            continue;
        }
        count += 1.0;
        for (sum, bin) in sums.iter_mut().zip(&power) {
            *sum += 10.0 * bin.norm_sqr().max(1e-15 * largest).log10();
        }
    }
    if count < 1.0 {
        return None;
    }
    // Below one and a half periods in a stretch nothing can be told.
    let low_hz = (1.5 * rate.hz() / longest as f64).max(lowest.0);
    let high_hz = 0.95 * highest.0;
    if low_hz * STEP >= high_hz {
        return None;
    }
    let lines = ((high_hz / low_hz).ln() / STEP.ln()) as usize;
    let frequencies: Vec<f64> = (0..lines).map(|i| low_hz * STEP.powi(i as i32)).collect();
    let level_db: Vec<f64> = frequencies
        .iter()
        .map(|f| {
            let place = f / rate.hz() * n as f64;
            let k = (place as usize).min(bins - 2);
            let share = place - k as f64;
            ((1.0 - share) * sums[k] + share * sums[k + 1]) / count
        })
        .collect();
    let around = octave_median(&level_db);
    Some(Spectrum {
        speed_m_s,
        wavenumbers: frequencies.iter().map(|f| f / speed_m_s).collect(),
        prominence_db: level_db.iter().zip(&around).map(|(l, b)| l - b).collect(),
        level_db,
        stretches: count,
        length_m: speed_m_s * longest as f64 / rate.hz(),
    })
}

/// The median over an octave below and above, of every tenth line.
fn octave_median(level_db: &[f64]) -> Vec<f64> {
    let reach = (2f64.ln() / STEP.ln()) as usize;
    let mut window = Vec::new();
    let thin = 10;
    let anchors: Vec<f64> = (0..level_db.len().div_ceil(thin))
        .map(|i| {
            let centre = i * thin;
            let (from, to) = (
                centre.saturating_sub(reach),
                (centre + reach + 1).min(level_db.len()),
            );
            window.clear();
            window.extend(level_db[from..to].iter().step_by(7));
            median(&mut window).unwrap_or(f64::NAN)
        })
        .collect();
    (0..level_db.len()).map(|i| anchors[i / thin]).collect()
}

/// The lines of one recording's strokes, each with its width, Hz: peaks that stand out of the level around them by what noise does not.
pub(crate) fn lines_of_strokes(
    rate: SampleRate,
    stretches: Vec<&[f64]>,
    lowest: Hertz,
) -> Vec<[f64; 2]> {
    // At 1 m/s a wavenumber in 1/m is a frequency in Hz.
    let sliding = Sliding {
        speed_m_s: 1.0,
        rate,
        group: String::new(),
        stretches,
    };
    let Some(own) = spectrum(&sliding, lowest) else {
        return Vec::new();
    };
    let needed_db = PROMINENT_DB.max(HIGHEST_OF_MANY * SCATTER_DB / own.stretches.sqrt());
    let last = own.wavenumbers.len().saturating_sub(1);
    let tops = (1..last).filter(|&i| {
        let level = &own.level_db;
        level[i] >= level[i - 1] && level[i] > level[i + 1]
    });
    let lines = tops.filter_map(|i| {
        let hz = own.wavenumbers[i];
        let width_hz = own.width_hz(hz);
        let stands_out = own.line_db(hz).is_some_and(|db| db >= needed_db);
        let near = (hz - 0.5 * width_hz, hz + 0.5 * width_hz);
        let around = own.wavenumbers.iter().zip(&own.level_db);
        let highest = around
            .filter(|(other, _)| **other >= near.0 && **other <= near.1)
            .all(|(_, db)| *db <= own.level_db[i]);
        (stands_out && highest).then_some([hz, width_hz])
    });
    lines.collect()
}
