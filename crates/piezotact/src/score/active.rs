//! The part of a recording that holds a vibration, without the silence before and after it.

use std::ops::Range;

use super::perceived::Common;
use super::waveform::NEARLY_ALL;
use super::{Extent, ScoreConfig, ScoreError, ScoreModel, ScoreWarning, Waveform};
use crate::quantity::{Acceleration, SampleRate, Seconds};
use crate::render::offset;
use crate::series::{Series, SeriesError};
use crate::statistics::mean;
use crate::warning::{Warning, Warnings};

/// The windows in which levels are looked at.
const WINDOW: Seconds = Seconds(0.005);
/// A window counts as silence when its power is below this share of the loudest one (−30 dB).
const SILENCE_POWER_SHARE: f64 = 1e-3;
/// Less silence before or after a vibration is left in.
const LEAST_SILENCE: Seconds = Seconds(0.05);
/// The shortest vibration that is scored.
pub(super) const SHORTEST: Seconds = Seconds(0.005);

/// What of two vibrations is compared.
pub(super) struct Compared {
    pub(super) extent: Extent,
    /// The vibrations without the silence around them; of a short one, in a segment.
    pub(super) series: [Series<Acceleration>; 2],
    /// What both share in time, where one follows the other.
    pub(super) shared: Option<[Series<Acceleration>; 2]>,
    /// Whether one of them is shorter than a segment.
    pub(super) is_short: bool,
    /// How long the shorter one is, s.
    pub(super) shorter_s: f64,
}

impl Compared {
    /// Those parts of `whole`, or of what they share in time, that hold a vibration; the silence that is left out is a warning.
    pub(super) fn of(
        whole: [&Series<Acceleration>; 2],
        shared: Option<[Series<Acceleration>; 2]>,
        config: &ScoreConfig,
        warnings: &mut Warnings,
    ) -> Result<Self, ScoreError> {
        let [a, b] = whole.map(|x| x.samples().len());
        let (shorter, a_is_shorter) = (a.min(b), a < b);
        let enough = (NEARLY_ALL * shorter as f64).min(config.welch.segment as f64);
        let shared = shared.filter(|[a, _]| a.samples().len() as f64 >= enough);
        let extent = match shared {
            Some(_) => Extent::SharedPart,
            None => Extent::WholeOfEach,
        };
        let [a, b] = shared.unwrap_or_else(|| whole.map(Clone::clone));
        let mut kept = [active(&a), active(&b)];
        if extent == Extent::SharedPart {
            let both = kept[0].start.min(kept[1].start)..kept[0].end.max(kept[1].end);
            kept = [both.clone(), both];
        }
        let rate = a.rate();
        let is_cut = extent == Extent::SharedPart
            && !whole.iter().all(|of| hardly_longer(of, kept[0].len()));
        let shared = (extent == Extent::SharedPart).then(|| [a.clone(), b.clone()]);
        // The perceived difference has a limit of its own.
        let least = match config.judged_by {
            ScoreModel::Spectral => config.welch.segment,
            ScoreModel::PerceivedDifference => 0,
        };
        let mut series = Vec::with_capacity(2);
        for ((what, x), kept) in [("the reference", a), ("the test", b)]
            .into_iter()
            .zip(kept)
        {
            // A cut of a texture says little of it, whereas an effect with silence around it is all there is.
            let is_whole = match extent {
                Extent::SharedPart => !is_cut,
                Extent::WholeOfEach => kept.start > 0 && kept.end < x.samples().len(),
            };
            if !is_whole && kept.len() < least {
                let what = match (extent, a_is_shorter) {
                    (Extent::WholeOfEach, _) => what,
                    (Extent::SharedPart, true) => "the reference",
                    (Extent::SharedPart, false) => "the test",
                };
                return Err(ScoreError::TooShort {
                    what,
                    needed: rate.duration_of(least),
                    found: rate.duration_of(kept.len()),
                });
            }
            let silence = x.samples().len() - kept.len();
            if silence == 0 {
                series.push(x);
                continue;
            }
            warnings.push(Warning::from(ScoreWarning::SilenceExcluded {
                signal: what.into(),
                silence_s: seconds(rate, silence),
                kept_s: seconds(rate, kept.len()),
            }));
            series.push(part(&x, kept)?);
        }
        let shortest = series.iter().map(|x| x.samples().len()).min().unwrap_or(0);
        let is_short = shortest < config.welch.segment;
        if is_short {
            for x in &mut series {
                *x = in_a_segment(x, config)?;
            }
        }
        let [Some(a), Some(b)] = [series.pop(), series.pop()] else {
            unreachable!("two vibrations were compared");
        };
        Ok(Self {
            extent,
            series: [b, a],
            shared,
            is_short,
            shorter_s: seconds(rate, shortest),
        })
    }
}

impl Compared {
    /// What both share in time, and the share of their variance that is independent, where one waveform follows the other.
    pub(super) fn common(&self, waveform: Option<&Waveform>) -> Common<'_> {
        let shared = self.shared.as_ref()?;
        Some((shared, self.independent(waveform)))
    }

    /// The share of the variance of both that is independent, 0–1: all of it but where one waveform follows the other.
    pub(super) fn independent(&self, waveform: Option<&Waveform>) -> f64 {
        match (self.extent, waveform) {
            (Extent::SharedPart, Some(found)) => 1.0 - found.correlation.powi(2),
            _ => 1.0,
        }
    }
}

/// The samples of `x` without the silence before and after its vibration; all of them where that is shorter than 50 ms on its side.
fn active(x: &Series<Acceleration>) -> Range<usize> {
    let (samples, rate) = (x.samples(), x.rate());
    let about = mean(samples);
    let window = rate.samples_in(WINDOW).max(1);
    let powers: Vec<f64> = samples
        .chunks(window)
        .map(|cut| cut.iter().map(|v| (v - about).powi(2)).sum())
        .collect();
    let least = SILENCE_POWER_SHARE * powers.iter().copied().fold(0.0, f64::max);
    let holds = |power: &f64| *power > least;
    let all = 0..samples.len();
    let (Some(first), Some(last)) = (
        powers.iter().position(holds),
        powers.iter().rposition(holds),
    ) else {
        return all;
    };
    let silence = rate.samples_in(LEAST_SILENCE);
    // A window more on either side: the vibration begins and ends within one.
    let begins = first.saturating_sub(1) * window;
    let ends = ((last + 2) * window).min(all.end);
    let from = if begins >= silence { begins } else { 0 };
    let to = if all.end - ends >= silence {
        ends
    } else {
        all.end
    };
    from..to
}

/// Whether the vibration of `whole` is about as long as a part of `count` samples of it, but for the silence that may be left in.
fn hardly_longer(whole: &Series<Acceleration>, count: usize) -> bool {
    let left_in = 2 * whole.rate().samples_in(LEAST_SILENCE);
    NEARLY_ALL * active(whole).len() as f64 <= (count + left_in) as f64
}

/// `x` in the middle of a segment of `config`, where it is shorter than one: amplified by as much as the window of a segment then takes
/// of a vibration that fills it, so that its level is that of its own duration.
fn in_a_segment(
    x: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<Series<Acceleration>, SeriesError> {
    let (count, segment) = (x.samples().len(), config.welch.segment);
    let begins = segment.saturating_sub(count) / 2;
    let window = config
        .welch
        .window
        .coefficients(segment, config.welch.symmetry);
    let power = |cut: &[f64]| cut.iter().map(|w| w * w).sum::<f64>();
    let within = power(&window[begins..(begins + count).min(segment)]);
    let gain = (power(&window) / within.max(f64::MIN_POSITIVE)).sqrt();
    let about = offset(x.samples(), x.rate(), config.band);
    let mut samples = vec![0.0; segment.max(count)];
    for (place, v) in samples[begins..].iter_mut().zip(x.samples()) {
        *place = gain * (v - about);
    }
    Series::new(samples, x.rate())
}

/// The samples `part` of `x`.
fn part(x: &Series<Acceleration>, part: Range<usize>) -> Result<Series<Acceleration>, SeriesError> {
    Series::new(x.samples()[part].to_vec(), x.rate())
}

/// How long `count` samples last, s.
fn seconds(rate: SampleRate, count: usize) -> f64 {
    rate.duration_of(count).0
}
