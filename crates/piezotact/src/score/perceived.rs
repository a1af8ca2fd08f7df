//! What is felt of two vibrations, over time and by channel.

use serde::Serialize;

use super::{Extent, ScoreConfig, ScoreError};
use crate::perception::{
    Parameters, PerceivedDifference, Record, Sensitivity, perceived_through, sensitivity,
};
use crate::quantity::{Acceleration, Decibels, Hertz};
use crate::series::Series;
use crate::verify::in_band;

/// How far two vibrations are apart over time and channels.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Perceived {
    /// The difference, by features.
    #[serde(flatten)]
    pub difference: PerceivedDifference,
    /// How far the halves of one recording are apart, JND: of the one whose halves differ more; absent where they are too short, or where
    /// one waveform follows the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_jnd: Option<f64>,
}

/// The level of the skin's motion over the nail's by frequency, as `config` has it.
fn skin(config: &ScoreConfig) -> impl Fn(Hertz) -> Decibels + '_ {
    |at| Decibels(config.contact.as_ref().map_or(0.0, |map| map.ratio_db(at)))
}

/// `x` within the band of `config`.
fn limited(
    x: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<Series<Acceleration>, ScoreError> {
    let samples = in_band(x.samples(), x.rate(), config.band);
    Ok(Series::new(samples, x.rate())?)
}

/// How far the halves of `x` are apart, JND; `None` where they are too short.
fn halves(x: &Series<Acceleration>, config: &ScoreConfig) -> Option<f64> {
    let (first, second) = x.samples().split_at(x.samples().len() / 2);
    let [first, second] = [first, second].map(|cut| Series::new(cut.to_vec(), x.rate()).ok());
    let apart = perceived_through(&first?, &second?, &Parameters::published(), &skin(config));
    Some(apart.ok()?.jnd.value)
}

/// How far `both` are apart within the band of `config`; of two excerpts of which one is cut out of the other, what they share.
pub(super) fn perceived(
    both: [&Series<Acceleration>; 2],
    shared: Option<&[Series<Acceleration>; 2]>,
    extent: Extent,
    config: &ScoreConfig,
) -> Result<Perceived, ScoreError> {
    let published = Parameters::published();
    let of = |a: &Series<Acceleration>, b: &Series<Acceleration>| {
        perceived_through(a, b, &published, &skin(config))
    };
    let [a, b] = both;
    let (mut a, mut b) = (limited(a, config)?, limited(b, config)?);
    let mut difference = of(&a, &b)?;
    if let Some([first, second]) = shared
        && difference.records.contains(&Record::Excerpt)
    {
        (a, b) = (limited(first, config)?, limited(second, config)?);
        difference = of(&a, &b)?;
    }
    let within_jnd = match extent {
        Extent::SharedPart => None,
        Extent::WholeOfEach => [&a, &b]
            .into_iter()
            .filter_map(|x| halves(x, config))
            .reduce(f64::max),
    };
    Ok(Perceived {
        difference,
        within_jnd,
    })
}

/// What the perceived difference of `test` from `reference` within the band of `config` becomes, JND, when each parameter in turn is at
/// the ends of its published range; as [`sensitivity`] has it, of all of each.
///
/// Source: [`sensitivity`].
///
/// # Errors
/// [`ScoreError::Perception`] as [`super::score`] has it.
pub fn score_sensitivity(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<Vec<Sensitivity>, ScoreError> {
    let (a, b) = (limited(reference, config)?, limited(test, config)?);
    Ok(sensitivity(&a, &b, &Parameters::published(), &skin(config))?)
}
