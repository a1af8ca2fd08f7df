//! The excitation of a waveform, and its uncertainty from the variation between its parts.

use std::cell::RefCell;
use std::sync::Arc;

use crate::discrimination::{Evidence, Excitation, ExcitationPlan, Model, Units};
use crate::quantity::{Acceleration, SampleRate, Seconds};
use crate::series::Series;
use crate::spectrum::{EstimateError, RECOMMENDED_SEGMENTS, WelchConfig, WelchPlan, segments_in};
use crate::statistics::LevelSpread;

use super::Extent;

/// The numbers of parts, from fine to coarse, into which a recording is divided to test whether it is stationary.
const PARTS: [usize; 2] = [4, 2];
/// Into how many where no scatter of segments is known.
const FINE_PARTS: usize = 8;
/// The fewest samples of a spectrum from which bands are computed.
const SHORTEST: usize = 16;

/// The plans of one comparison, one for each length of segments: both waveforms have the same ones.
pub(super) struct Plans<'a> {
    pub(super) model: &'a Model,
    made: RefCell<Vec<(usize, f64, Arc<ExcitationPlan>)>>,
}

impl<'a> Plans<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        let made = RefCell::default();
        Self { model, made }
    }

    /// For PSDs of segments of `segment` samples.
    fn of(&self, segment: usize, rate: SampleRate) -> Arc<ExcitationPlan> {
        let rate_hz = rate.hz();
        let mut made = self.made.borrow_mut();
        let known = made
            .iter()
            .find(|(n, hz, _)| (*n, *hz) == (segment, rate_hz));
        if let Some((.., plan)) = known {
            return Arc::clone(plan);
        }
        let plan = ExcitationPlan::new(self.model, segment / 2 + 1, rate_hz / segment as f64);
        let plan = Arc::new(plan);
        made.push((segment, rate_hz, Arc::clone(&plan)));
        plan
    }
}

/// The spectra of a waveform's segments, and what they excite.
pub(super) struct Waveform {
    plan: Arc<ExcitationPlan>,
    psd: Vec<f64>,
    pub(super) mean: Excitation,
    each: Vec<Excitation>,
    averages: f64,
}

impl Waveform {
    /// The segments averaged.
    pub(super) fn segments(&self) -> usize {
        self.each.len()
    }

    /// `x` cut into the segments of `welch`.
    pub(super) fn of(
        x: &Series<Acceleration>,
        plans: &Plans<'_>,
        welch: &WelchConfig,
    ) -> Result<Self, EstimateError> {
        welch.fits(x.samples().len())?;
        let mut of_segment = WelchPlan::new(welch, x.rate())?;
        let hop = welch.hop()?;
        let segments = segments_in(x.samples().len(), welch.segment, hop);
        let bins = welch.segment / 2 + 1;
        let plan = plans.of(welch.segment, x.rate());
        let mut psd = vec![0.0; bins];
        let mut each = Vec::with_capacity(segments);
        for i in 0..segments {
            let cut = &x.samples()[i * hop..i * hop + welch.segment];
            let one = of_segment.estimate::<Acceleration>(&[cut])?.values;
            for (sum, value) in psd.iter_mut().zip(&one) {
                *sum += value / segments as f64;
            }
            each.push(plan.of(&one));
        }
        Ok(Self {
            mean: plan.of(&psd),
            averages: welch.effective_averages(segments)?,
            plan,
            psd,
            each,
        })
    }

    /// What Gaussian noise of the spectra of `self` and `other` would scatter by, of which the share `independent`, 0–1, is not common to
    /// both.
    pub(super) fn scatter_of_noise<'a>(
        &'a self,
        other: &'a Self,
        welch: &WelchConfig,
        independent: f64,
    ) -> Evidence<'a> {
        let times = 1.0 / independent.max(1e-6);
        Evidence::Noise {
            plan: &self.plan,
            psd: [&self.psd, &other.psd],
            kinship: line_kinship(welch),
            averages: [self.averages * times, other.averages * times],
        }
    }

    fn units(&self) -> Units {
        Units {
            each: self.each.clone(),
            effective: self.averages,
        }
    }
}

/// What each of `count` parts of `x`, one after the other, excites; `None` when they are too short.
pub(super) fn parts(
    x: &Series<Acceleration>,
    count: usize,
    plans: &Plans<'_>,
    welch: &WelchConfig,
) -> Result<Option<Vec<Excitation>>, EstimateError> {
    let length = x.samples().len() / count;
    let segment = (length / 2).min(welch.segment) & !1;
    if segment < SHORTEST {
        return Ok(None);
    }
    let welch = WelchConfig {
        segment,
        ..welch.clone()
    };
    let plan = plans.of(segment, x.rate());
    let mut of_part = WelchPlan::new(&welch, x.rate())?;
    x.samples()
        .chunks_exact(length)
        .take(count)
        .map(|part| Ok(plan.of(&of_part.estimate::<Acceleration>(&[part])?.values)))
        .collect::<Result<Vec<_>, _>>()
        .map(Some)
}

/// What says how sure the difference of `a` and `b` is: the scatter of segments where there are [`RECOMMENDED_SEGMENTS`] of
/// them, and else what Gaussian noise of these spectra would do or, where one follows the other, the scatter of short parts; and
/// the scatter of longer parts, which shows what wanders.
pub(super) fn evidence<'a>(
    [a, b]: [(&Series<Acceleration>, &'a Waveform); 2],
    extent: Extent,
    plans: &Plans<'_>,
    welch: &'a WelchConfig,
) -> Result<Vec<Evidence<'a>>, EstimateError> {
    let together = extent == Extent::SharedPart;
    let of = |units: [Units; 2]| {
        if together {
            Evidence::Together(units)
        } else {
            Evidence::Apart(units)
        }
    };
    let of_parts = |count: usize| -> Result<Option<Evidence<'a>>, EstimateError> {
        let [a, b] = [a.0, b.0].map(|x| parts(x, count, plans, welch));
        Ok(match (a?, b?) {
            (Some(a), Some(b)) => Some(of([Units::independent(a), Units::independent(b)])),
            _ => None,
        })
    };
    let mut scales = Vec::new();
    if a.1.segments().min(b.1.segments()) >= RECOMMENDED_SEGMENTS {
        scales.push(of([a.1.units(), b.1.units()]));
    } else {
        let fine = if together {
            of_parts(FINE_PARTS)?
        } else {
            None
        };
        scales.push(fine.unwrap_or_else(|| a.1.scatter_of_noise(b.1, welch, 1.0)));
    }
    for count in PARTS {
        scales.extend(of_parts(count)?);
    }
    Ok(scales)
}

/// How far the powers of lines 0, 1 and 2 apart go together in one segment of noise, 0–1.
///
/// Formula: |Σ w²·e^(−2πijt/n)|²/(Σ w²)²; 1, 4/9 and 1/36 for Hann.
fn line_kinship(welch: &WelchConfig) -> [f64; 3] {
    let window = welch.window.coefficients(welch.segment, welch.symmetry);
    let power: f64 = window.iter().map(|w| w * w).sum();
    [0usize, 1, 2].map(|apart| {
        let turn = std::f64::consts::TAU * apart as f64 / welch.segment as f64;
        let (re, im) = window
            .iter()
            .enumerate()
            .fold((0.0, 0.0), |(re, im), (t, w)| {
                let (sin, cos) = (turn * t as f64).sin_cos();
                (re + w * w * cos, im + w * w * sin)
            });
        (re * re + im * im) / (power * power)
    })
}

/// The spread and the maximum of the excitation's level over windows of `window`; `None` with fewer than three of them.
pub(super) fn spread(
    x: &Series<Acceleration>,
    plans: &Plans<'_>,
    window: Seconds,
) -> Result<Option<LevelSpread>, EstimateError> {
    let segment = x.rate().samples_in(window).max(16);
    let welch = WelchConfig {
        overlap: 0.0,
        ..WelchConfig::hann(segment)
    };
    let count = segments_in(x.samples().len(), segment, welch.hop()?);
    if count < 3 {
        return Ok(None);
    }
    let mut plan = WelchPlan::new(&welch, x.rate())?;
    let excited = plans.of(segment, x.rate());
    let mut levels_db = Vec::with_capacity(count);
    for cut in x.samples().chunks_exact(segment) {
        let psd = plan.estimate::<Acceleration>(&[cut])?.values;
        let total = excited.of(&psd).total();
        // A pause is as quiet as a tenth of the threshold's power, not infinitely quiet.
        levels_db.push(10.0 * total.max(0.1).log10());
    }
    Ok(LevelSpread::of(&levels_db))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_a_hann_window_go_together_as_they_should() {
        let [own, next, second] = line_kinship(&WelchConfig::hann(1024));
        assert!((own - 1.0).abs() < 1e-12);
        assert!((next - 4.0 / 9.0).abs() < 1e-12 && (second - 1.0 / 36.0).abs() < 1e-12);
    }
}
