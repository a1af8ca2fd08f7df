//! What is felt of two vibrations, over time and by channel.

use serde::Serialize;

use super::active::Compared;
use super::{Extent, Score, ScoreConfig, ScoreError, waveforms};
use crate::perception::{
    Ends, LEAD_S, Limitation, Parameters, PerceivedDifference, PerceivedVibration, PerceptionError,
    Record, Sensitivity, sensitivity,
};
use crate::quantity::{Acceleration, Decibels, Hertz, Seconds};
use crate::series::Series;
use crate::verify::in_band_with_edges;
use crate::warning::Warnings;

/// The shortest excerpt of a longer vibration that is compared.
const SHORTEST_EXCERPT: Seconds = Seconds(0.3);
/// The width of the edges of the band, as a share of its ends: sharper ones ring for longer than a channel follows.
const EDGE_RATIO: f64 = 0.5;

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
    let samples = match Ends::of(x.samples(), rate.hz()).whole {
        true => {
            let silence = vec![0.0; rate.samples_in(Seconds(LEAD_S))];
            within(&[&silence, x.samples(), &silence].concat())
        }
        false => within(x.samples()),
    };
    Ok(Series::new(samples, rate)?)
}

/// How far `a` and `b` are apart, whose variance by chance is their own by the share `independent`.
fn apart(
    [a, b]: [&Series<Acceleration>; 2],
    independent: f64,
    parameters: &Parameters,
    config: &ScoreConfig,
) -> Result<PerceivedDifference, PerceptionError> {
    let of = |what, x| {
        let felt = PerceivedVibration::of(what, x, parameters, &skin(config))?;
        Ok(felt.with_independent(independent))
    };
    Ok(of("the reference", a)?.difference(&of("the test", b)?, parameters))
}

/// Twice what parts of `x` are apart, JND: its halves, or those two of its quarters that differ most; `None` where they are too short.
fn parts(x: &Series<Acceleration>, config: &ScoreConfig) -> Option<f64> {
    let (samples, count) = (x.samples(), x.samples().len());
    let cut = |from: usize, of: usize| -> Option<Series<Acceleration>> {
        let place = |part: usize| part * count / of;
        Series::new(samples[place(from)..place(from + 1)].to_vec(), x.rate()).ok()
    };
    let parts_apart = |[first, second]: [usize; 2], of: usize| {
        let (first, second) = (cut(first, of)?, cut(second, of)?);
        let found = apart([&first, &second], 1.0, &Parameters::published(), config);
        Some(found.ok()?.jnd.value)
    };
    let quarters = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let quarters = quarters.into_iter().filter_map(|pair| parts_apart(pair, 4));
    Some(PARTS * quarters.fold(parts_apart([0, 1], 2)?, f64::max))
}

/// Refuses excerpts that are too short: those that are `compared` of `both`.
fn refuse(
    both: [&Series<Acceleration>; 2],
    compared: [&Series<Acceleration>; 2],
    records: [Record; 2],
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
        if record == Record::Excerpt && found.0 < SHORTEST_EXCERPT.0 {
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

/// `both` within the band of `config`, or, of an excerpt that is cut out of the other or that the other follows, what they share; and how
/// far they are apart.
fn compared(
    both: [&Series<Acceleration>; 2],
    shared: Option<&[Series<Acceleration>; 2]>,
    independent: f64,
    config: &ScoreConfig,
) -> Result<([Series<Acceleration>; 2], PerceivedDifference), ScoreError> {
    let published = Parameters::published();
    let of = |[a, b]: [&Series<Acceleration>; 2]| {
        let (a, b) = (limited(a, config)?, limited(b, config)?);
        let difference = apart([&a, &b], independent, &published, config)?;
        Ok::<_, ScoreError>(([a, b], difference))
    };
    let (mut compared, mut difference) = of(both)?;
    if let Some([first, second]) = shared
        && difference.records.contains(&Record::Excerpt)
    {
        (compared, difference) = of([first, second])?;
    }
    let [a, b] = &compared;
    refuse(both, [a, b], difference.records)?;
    Ok((compared, difference))
}

/// How far `both` are apart within the band of `config`; of an excerpt that is cut out of the other, or that the other follows, what they
/// share. Their variance by chance is their own by the share `independent`, less than 1 where one waveform follows the other.
pub(super) fn perceived(
    both: [&Series<Acceleration>; 2],
    shared: Option<&[Series<Acceleration>; 2]>,
    (extent, independent): (Extent, f64),
    config: &ScoreConfig,
) -> Result<Perceived, ScoreError> {
    let ([a, b], difference) = compared(both, shared, independent, config)?;
    let within_jnd = match extent {
        Extent::SharedPart => None,
        // The parts of a rhythm or a sweep differ by nature.
        Extent::WholeOfEach if difference.without_chance => None,
        Extent::WholeOfEach => [&a, &b]
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
        let independent = found.extent.independent(waveform.as_ref());
        let ([a, b], _) = compared(both, found.shared.as_ref(), independent, config)?;
        Ok(sensitivity(&Parameters::published(), |parameters| {
            apart([&a, &b], independent, parameters, config)
        })?)
    }
}
