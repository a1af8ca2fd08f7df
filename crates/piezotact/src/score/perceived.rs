//! What is felt of two vibrations, over time and by channel.

use serde::Serialize;

use super::active::Compared;
use super::{Score, ScoreConfig, ScoreError, waveforms};
use crate::perception::{
    Ends, Limitation, Parameters, PerceivedDifference, PerceivedVibration, PerceptionError, Record,
    Sensitivity, sensitivity,
};
use crate::quantity::{Acceleration, Decibels, Hertz, SampleRate, Seconds};
use crate::series::Series;
use crate::statistics::mean;
use crate::verify::in_band_with_edges;
use crate::warning::Warnings;

/// The shortest excerpt of a longer vibration that is compared.
const SHORTEST_EXCERPT: Seconds = Seconds(0.3);
/// The share of a vibration that aligning costs at its ends.
const COST_OF_ALIGNING: f64 = 0.01;
/// A duration is a number of samples over a rate.
const ROUNDING_S: f64 = 1e-9;
/// The width of the edges of the band, as a share of its ends: sharper ones ring for longer than a channel follows.
const EDGE_RATIO: f64 = 0.25;
/// The silence around what begins and ends by itself: the edges ring for less long.
const SILENCE: Seconds = Seconds(0.3);
/// The part of either end from which an offset is taken.
const END: Seconds = Seconds(0.001);
/// What a vibration begins and ends with, and the share of its own level from which on it is felt.
const RAMP: Seconds = Seconds(0.02);
const FELT_SHARE: f64 = 0.3;

/// Two recordings of what drifts lie farther apart than parts of one: its halves by half its length, two recordings by all of it or more.
const PARTS: f64 = 2.0;

/// How far two vibrations are apart over time and channels.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Perceived {
    /// The difference, by features.
    #[serde(flatten)]
    pub difference: PerceivedDifference,
    /// Twice what parts of one recording are apart, JND: halves, or the two quarters that differ most, of the one in which they differ more;
    /// absent where they are too short, where one waveform
    /// follows the other, and of stimuli without chance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_jnd: Option<f64>,
}

impl Perceived {
    /// Whether one of the two is an excerpt that is too short for what varies slowly.
    pub(super) fn is_short(&self) -> bool {
        let mut all = self.difference.limitations.iter();
        all.any(|one| matches!(one, Limitation::ShortExcerpt { .. }))
    }
}

/// The level of the skin's motion over the nail's by frequency, as `config` has it.
fn skin(config: &ScoreConfig) -> impl Fn(Hertz) -> Decibels + '_ {
    |at| Decibels(config.contact.as_ref().map_or(0.0, |map| map.ratio_db(at)))
}

/// `x` within the band of `config`; what begins and ends by itself with silence around it, where the edges of the band ring.
fn limited(
    x: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<Series<Acceleration>, ScoreError> {
    let rate = x.rate();
    let within = |samples: &[f64]| in_band_with_edges(samples, rate, config.band, EDGE_RATIO);
    let alone = within(x.samples());
    // Either hides ends: an offset those of the recording, the ringing of the edges those of the band.
    let is_whole = |samples: &[f64]| Ends::of(samples, rate.hz()).whole;
    if !is_whole(&alone) && !is_whole(x.samples()) {
        return Ok(Series::new(alone, rate)?);
    }
    // An offset of the sensor, or a slow motion, makes no step where the silence begins.
    let end = rate.samples_in(END).clamp(1, x.samples().len());
    let (first, last) = (
        mean(&x.samples()[..end]),
        mean(&x.samples()[x.samples().len() - end..]),
    );
    let step = (last - first) / x.samples().len() as f64;
    let samples = x.samples().iter().enumerate();
    let samples: Vec<f64> = samples.map(|(i, v)| v - first - step * i as f64).collect();
    let silence = vec![0.0; rate.samples_in(SILENCE)];
    Ok(Series::new(
        within(&[&silence, samples.as_slice(), &silence].concat()),
        rate,
    )?)
}

/// How far `a` and `b` are apart; where they follow each other and are cut at the same instants, but for the share `independent` of their
/// variance.
fn apart(
    [a, b]: [&Series<Acceleration>; 2],
    independent: Option<f64>,
    parameters: &Parameters,
    config: &ScoreConfig,
) -> Result<PerceivedDifference, PerceptionError> {
    let skin = skin(config);
    let of = |what, x| match independent {
        Some(share) => PerceivedVibration::of_common(what, x, parameters, &skin, share),
        None => PerceivedVibration::of(what, x, parameters, &skin),
    };
    Ok(of("the reference", a)?.difference(&of("the test", b)?, parameters))
}

/// The samples of `x` between its begin and its end, without ramps and the silence around.
fn inner(x: &[f64], rate: SampleRate) -> &[f64] {
    let square: f64 = x.iter().map(|v| v * v).sum();
    let fourth: f64 = x.iter().map(|v| v.powi(4)).sum();
    let least = FELT_SHARE * (fourth / square.max(f64::MIN_POSITIVE)).sqrt();
    let first = x.iter().position(|v| v.abs() > least).unwrap_or(0);
    let last = x.iter().rposition(|v| v.abs() > least).unwrap_or(0);
    let ramp = rate.samples_in(RAMP);
    x.get(first + ramp..last.saturating_sub(ramp)).unwrap_or(x)
}

/// Twice what parts of `x` are apart, JND: its halves, or those two of its quarters that differ most; `None` where they are too short. How
/// it begins and ends is no part of them.
fn parts(x: &Series<Acceleration>, config: &ScoreConfig) -> Option<f64> {
    let samples = match Ends::of(x.samples(), x.rate().hz()).whole {
        true => inner(x.samples(), x.rate()),
        false => x.samples(),
    };
    let count = samples.len();
    let cut = |from: usize, of: usize| -> Option<Series<Acceleration>> {
        let place = |part: usize| part * count / of;
        Series::new(samples[place(from)..place(from + 1)].to_vec(), x.rate()).ok()
    };
    let parts_apart = |[first, second]: [usize; 2], of: usize| {
        let (first, second) = (cut(first, of)?, cut(second, of)?);
        let found = apart([&first, &second], None, &Parameters::published(), config);
        Some(found.ok()?.jnd.value)
    };
    let quarters = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let quarters = quarters.into_iter().filter_map(|pair| parts_apart(pair, 4));
    Some(PARTS * quarters.fold(parts_apart([0, 1], 2)?, f64::max))
}

/// Refuses excerpts that are shorter than `least`: those that are `compared` of `both`.
fn refuse(
    both: [&Series<Acceleration>; 2],
    compared: [&Series<Acceleration>; 2],
    records: [Record; 2],
    least: Seconds,
) -> Result<(), ScoreError> {
    // What both share is as long as the shorter one at the most.
    let [a, b] = both.map(|x| x.samples().len());
    let mut names = ["the reference", "the test"];
    if b < a {
        names.reverse();
    }
    let is_shared = compared[0].samples().len() == compared[1].samples().len() && a != b;
    for (i, (x, record)) in compared.into_iter().zip(records).enumerate() {
        let found = x.duration();
        if record == Record::Excerpt && found.0 < least.0 - ROUNDING_S {
            return Err(ScoreError::TooShort {
                what: match is_shared {
                    true => names[0],
                    false => ["the reference", "the test"][i],
                },
                needed: SHORTEST_EXCERPT,
                found,
            });
        }
    }
    Ok(())
}

/// What one vibration shares in time with another that it follows, and the share of the variance of both that is independent.
pub(super) type Common<'s> = Option<(&'s [Series<Acceleration>; 2], f64)>;

/// `both` within the band of `config`, or what they have in common where one of them is an excerpt; and how far they are apart.
fn compared(
    both: [&Series<Acceleration>; 2],
    common: Common<'_>,
    config: &ScoreConfig,
) -> Result<([Series<Acceleration>; 2], PerceivedDifference), ScoreError> {
    let published = Parameters::published();
    let of = |[a, b]: [&Series<Acceleration>; 2], independent| {
        let (a, b) = (limited(a, config)?, limited(b, config)?);
        let difference = apart([&a, &b], independent, &published, config)?;
        Ok::<_, ScoreError>(([a, b], difference))
    };
    let Some(([first, second], independent)) = common else {
        let (compared, difference) = of(both, None)?;
        let [a, b] = &compared;
        refuse(both, [a, b], difference.records, SHORTEST_EXCERPT)?;
        return Ok((compared, difference));
    };
    // Only how they are recorded is kept.
    let records = of(both, None)?.1.records;
    let is_shared = records.contains(&Record::Excerpt);
    let cut = if is_shared { [first, second] } else { both };
    let (compared, difference) = of(cut, Some(independent))?;
    let [a, b] = &compared;
    let least = match is_shared {
        true => Seconds(SHORTEST_EXCERPT.0 * (1.0 - COST_OF_ALIGNING)),
        false => SHORTEST_EXCERPT,
    };
    refuse(both, [a, b], difference.records, least)?;
    Ok((compared, difference))
}

/// How far `both` are apart within the band of `config`: all of each, or what they have in common where one of them is an excerpt.
pub(super) fn perceived(
    both: [&Series<Acceleration>; 2],
    common: Common<'_>,
    config: &ScoreConfig,
) -> Result<Perceived, ScoreError> {
    let ([a, b], difference) = compared(both, common, config)?;
    let within_jnd = match common {
        Some(_) => None,
        // The parts of a rhythm or a sweep differ by nature.
        None if difference.without_chance => None,
        None => [&a, &b]
            .into_iter()
            .filter_map(|x| parts(x, config))
            .reduce(f64::max),
    };
    Ok(Perceived {
        difference,
        within_jnd,
    })
}

impl Score {
    /// What the perceived difference of `test` from `reference`, of which this is the score, becomes, JND, when each parameter in turn is at
    /// the ends of its published range.
    ///
    /// Source: [`sensitivity`].
    ///
    /// # Errors
    /// Those of [`super::score`].
    pub fn sensitivity(
        &self,
        both: [&Series<Acceleration>; 2],
    ) -> Result<Vec<Sensitivity>, ScoreError> {
        let (config, mut said) = (&self.config, Warnings::new());
        let [reference, test] = both;
        let (waveform, shared) = waveforms(reference, test, config.band, &mut said);
        let found = Compared::of(both, shared, config, &mut said)?;
        let common = found.common(waveform.as_ref());
        let ([a, b], _) = compared(both, common, config)?;
        let independent = common.map(|(_, share)| share);
        Ok(sensitivity(&Parameters::published(), |parameters| {
            apart([&a, &b], independent, parameters, config)
        })?)
    }
}
