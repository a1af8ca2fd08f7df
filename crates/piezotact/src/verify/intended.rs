//! The intended target (within the band of its rendering), and the measurement aligned to its time and clock.

use std::borrow::Cow;
use std::ops::Range;

use super::align::{Aligned, align, first, in_band, in_bands};
use super::clock::{self, Clock};
use super::lines::Floor;
use super::{FOLLOWS, VerifyConfig, VerifyError, nmse_db};
use crate::fourier::{RealTransform, fast_length};
use crate::quantity::{Band, Quantity, SampleRate};
use crate::render::offset;
use crate::series::Series;
use crate::statistics::{mean, rms};

/// A target, and the silence that was put around it.
pub(super) struct Asked<Q: Quantity> {
    /// The target; a short one without its offset, with the silence around it.
    pub(super) series: Series<Q>,
    /// Samples of silence on either side.
    pub(super) silence: usize,
    /// Samples of the target itself.
    pub(super) target: usize,
}

impl<Q: Quantity> Asked<Q> {
    /// `target` with half a `segment` of silence on either side where it is shorter than two: the window of a segment would hide its
    /// ends, which are most of a short effect.
    pub(super) fn of(target: Series<Q>, config: &VerifyConfig) -> Result<Self, VerifyError> {
        let (count, segment) = (target.samples().len(), config.welch.segment);
        if count >= 2 * segment {
            return Ok(Self {
                series: target,
                silence: 0,
                target: count,
            });
        }
        let silence = segment.saturating_sub(count / 2).max(segment.div_ceil(2));
        let (rate, about) = (target.rate(), offset_of(&target, config));
        let mut samples = vec![0.0; count + 2 * silence];
        for (place, x) in samples[silence..].iter_mut().zip(target.samples()) {
            *place = x - about;
        }
        Ok(Self {
            series: Series::new(samples, rate)?,
            silence,
            target: count,
        })
    }

    /// Samples of the target itself within `compared`.
    pub(super) fn measured(&self, compared: &Range<usize>) -> usize {
        let to = compared.end.min(self.silence + self.target);
        to.saturating_sub(compared.start.max(self.silence))
    }
}

/// The offset of `target` as its rendering takes it away.
fn offset_of<Q: Quantity>(target: &Series<Q>, config: &VerifyConfig) -> f64 {
    let band = config
        .rendered
        .map_or(config.band, |rendered| rendered.band);
    offset(target.samples(), target.rate(), band)
}

/// The target as it was to be felt: without its offset, within the band of its rendering. A fade of the rendering is not part of it.
pub(super) fn intended_target<Q: Quantity>(
    asked: &Asked<Q>,
    config: &VerifyConfig,
) -> Result<Series<Q>, VerifyError> {
    let rate = asked.series.rate();
    let about = match asked.silence {
        0 => offset_of(&asked.series, config),
        _ => 0.0,
    };
    let mut samples: Vec<f64> = asked.series.samples().iter().map(|x| x - about).collect();
    if let Some(kept) = config.rendered {
        let (count, rate_hz) = (samples.len(), rate.hz());
        let n = fast_length(2 * count);
        let mut bins = RealTransform::new(n).forward(&samples);
        for (k, bin) in bins.iter_mut().enumerate() {
            let hz = k as f64 * rate_hz / n as f64;
            *bin *= kept.band.weight(hz, kept.edge_ratio);
        }
        drop(samples);
        samples = first(count, RealTransform::new(n).inverse(bins));
    }
    Ok(Series::new(samples, rate)?)
}

/// A measurement aligned to the time and the clock of its target.
pub(super) struct Synchronised {
    pub(super) aligned: Aligned,
    pub(super) clock: Clock,
}

/// The window of the short-time levels by which another realisation is located, s.
const ENVELOPE_S: f64 = 0.01;
/// Lags at which less than this share of the largest possible power falls within the target are not considered.
const MIN_POWER_WITHIN: f64 = 0.998;

/// The delay of `response` re `intended` in samples, from their levels in windows of 10 ms.
fn envelope_lag<Q: Quantity>(intended: &Series<Q>, response: &Series<Q>, band: Band) -> f64 {
    let rate = intended.rate();
    let window = ((ENVELOPE_S * rate.hz()) as usize).max(1);
    let levels = |x: &[f64]| -> Vec<f64> {
        let limited = in_band(x, rate, band);
        limited
            .chunks(window)
            .map(|cut| cut.iter().map(|v| v * v).sum())
            .collect()
    };
    let (t, m) = (levels(intended.samples()), levels(response.samples()));
    let mut transform = RealTransform::new(fast_length(t.len() + m.len()));
    let cross = transform
        .forward(&t)
        .iter()
        .zip(transform.forward(&m))
        .map(|(t, m)| t.conj() * m)
        .collect();
    let products = transform.inverse(cross);
    let n = products.len() as i64;
    // No more than a tenth of the target may lie outside what was recorded.
    let (count, all) = (t.len() as i64, m.len() as i64);
    let least = -count / 10;
    let most = (all - count * 9 / 10).max(least);
    // Silence before and after the texture does not belong to it: at the right lag all of the power lies within.
    let mut sums = vec![0.0];
    for level in &m {
        sums.push(sums.last().copied().unwrap_or(0.0) + level);
    }
    let within =
        |lag: i64| sums[(lag + count).clamp(0, all) as usize] - sums[lag.clamp(0, all) as usize];
    let largest = (least..=most).map(within).fold(0.0, f64::max);
    let best = (least..=most)
        .filter(|lag| within(*lag) >= MIN_POWER_WITHIN * largest)
        .max_by(|a, b| {
            let at = |lag: i64| products[lag.rem_euclid(n) as usize];
            at(*a).total_cmp(&at(*b))
        })
        .unwrap_or(0);
    (best * window as i64) as f64
}

/// A clock correction is kept when it reduces the difference of the waveforms by at least this, dB.
const LEAST_GAIN_DB: f64 = 0.1;

/// `response` aligned to the time of `intended`, and to its clock when the delay shows a drift or lost samples.
pub(super) fn synchronised<Q: Quantity>(
    intended: &Series<Q>,
    response: &Series<Q>,
    band: Band,
) -> Result<Synchronised, VerifyError> {
    let found = on_one_clock(intended, response, band)?;
    if found.aligned.correlation().abs() > FOLLOWS {
        return Ok(found);
    }
    // Another realisation has no correlation to align by: it is located by its level.
    let lag = envelope_lag(intended, response, band);
    Ok(Synchronised {
        aligned: found.aligned.moved_to(lag, response),
        clock: Clock::default(),
    })
}

/// The length of a part of the target in which clock drift is negligible, s.
const ANCHOR_S: f64 = 1.0;

/// `response` aligned to `intended` by the delay of the whole signal, or by that of its middle when clock drift shifts the ends.
fn anchored<Q: Quantity>(
    intended: &Series<Q>,
    response: &Series<Q>,
    band: Band,
) -> Result<Aligned, VerifyError> {
    let first = align(intended, response, band)?;
    let (count, length) = (
        intended.samples().len(),
        intended
            .rate()
            .samples_in(crate::quantity::Seconds(ANCHOR_S)),
    );
    if first.correlation().abs() > FOLLOWS || count < 4 * length {
        return Ok(first);
    }
    let from = (count - length) / 2;
    let middle = Series::<Q>::new(
        intended.samples()[from..from + length].to_vec(),
        intended.rate(),
    )?;
    let Ok(anchor) = align(&middle, response, band) else {
        return Ok(first);
    };
    if anchor.correlation().abs() < FOLLOWS {
        return Ok(first);
    }
    let lag = (anchor.delay.0 * intended.rate().hz()).round() - from as f64;
    Ok(first.moved_to(lag, response))
}

fn on_one_clock<Q: Quantity>(
    intended: &Series<Q>,
    response: &Series<Q>,
    band: Band,
) -> Result<Synchronised, VerifyError> {
    let rate = intended.rate();
    let first = anchored(intended, response, band)?;
    let difference_db = |aligned: &Aligned| {
        let (t, m) = (
            &aligned.target_in_band[aligned.from..aligned.to],
            &aligned.measured_in_band[aligned.from..aligned.to],
        );
        let missed: Vec<f64> = t.iter().zip(m).map(|(t, m)| m - t).collect();
        nmse_db(rms(&missed), rms(t))
    };
    let (target, measured) = (&first.target_in_band, &first.measured_in_band);
    let clock = clock::clock(target, measured, rate, band, first.correlation().signum());
    if !clock.differs() {
        return Ok(Synchronised {
            aligned: first,
            clock,
        });
    }
    let clock = clock.refined(target, measured, rate.hz());
    let later = first.delay.0 * rate.hz();
    let samples = clock.corrected(
        response.samples(),
        intended.samples().len(),
        later,
        rate.hz(),
    );
    let corrected = Series::<Q>::new(samples, rate)?;
    let mut second = align(intended, &corrected, band)?;
    if difference_db(&second) > difference_db(&first) - LEAST_GAIN_DB {
        return Ok(Synchronised {
            aligned: first,
            clock: clock.uncorrected(),
        });
    }
    second.delay.0 += first.delay.0 + clock.begins_s(rate.hz());
    second.from = second.from.max(first.from);
    second.to = second.to.min(first.to).max(second.from);
    Ok(Synchronised {
        aligned: second,
        clock,
    })
}

/// Guard times before the onset and after the end of the texture, outside of which only noise is expected, s.
const GUARD_S: (f64, f64) = (0.05, 0.1);
/// The signal before and after the texture is not taken as noise above this share of the texture's power.
const MOST_NOISE: f64 = 0.25;

/// The noise of the sensor in `response`, measured before and after the texture; `None` when these parts are too short, or
/// too loud to be noise.
pub(super) fn floor<Q: Quantity>(
    intended: &Series<Q>,
    response: &Series<Q>,
    aligned: &Aligned,
    band: Band,
) -> Option<Floor> {
    let (rate, samples) = (intended.rate(), response.samples());
    let begin = (aligned.delay.0 - GUARD_S.0) * rate.hz();
    let end = (aligned.delay.0 + GUARD_S.1) * rate.hz() + intended.samples().len() as f64;
    let place = |at: f64| at.clamp(0.0, samples.len() as f64) as usize;
    let about = mean(samples);
    let quiet: Vec<Vec<f64>> = [&samples[..place(begin)], &samples[place(end)..]]
        .iter()
        .map(|x| x.iter().map(|v| v - about).collect())
        .collect();
    let quiet: Vec<&[f64]> = quiet.iter().map(Vec::as_slice).collect();
    let floor = Floor::of(&quiet, rate)?;
    let played = rms(&aligned.measured_in_band[aligned.from..aligned.to]).powi(2);
    (floor.power(band) <= MOST_NOISE * played).then_some(floor)
}

/// Target and measurement, aligned in time and limited to the judged bands.
pub(super) fn judged_waveforms<'a>(
    aligned: &'a Aligned,
    judged: &[Band],
    rate: SampleRate,
    band: Band,
) -> [Cow<'a, [f64]>; 2] {
    let both = [&aligned.target_in_band, &aligned.measured_in_band];
    both.map(|samples| match judged == [band] {
        true => Cow::Borrowed(&samples[..]),
        false => Cow::Owned(in_bands(samples, rate, judged)),
    })
}
