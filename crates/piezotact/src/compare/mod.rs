//! Comparisons: across samples, speeds, loads, directions, participants, and between active and passive touch.

mod chance;
mod conclusion;
mod confounded;
mod distinguishability;
mod groups;
mod left_out;
mod lines;
mod over_time;
mod period;
mod receptors;
mod summary;
mod touching;
mod trends;
mod warning;

pub use conclusion::friction_conclusion;
pub use confounded::{Confounder, confounders, unless_confounded};
pub use distinguishability::{Distinguishability, Groups, Pair, PairCriterion, SampleUnit};
pub use groups::{AcrossSamples, DiscriminationConfig, Texture, WithheldCause, discriminate};
pub use left_out::{TextureWithLines, discriminate_without};
pub use lines::{CommonLine, LineOrigin, LinesOf, common_lines, lines_in_doubt, set_apart};
pub use over_time::{PerceivedStrokes, add_over_time};
pub use period::{
    AlongTheWay, FoundIn, GroupPeriod, LinesOfSpeeds, PeriodCriterion, PeriodUnit, Sliding,
    SpatialPeriod, SpeedPeak, WayPeak, WaySpectrum, compare_periods, spatial_period,
};
pub(crate) use period::{Travelled, along_the_way, lines_of_strokes};
pub use receptors::{LevelUnit, ReceptorLevel, receptor_levels};
pub use summary::{Fingerprint, Periods, Summary, Tooth, summarise};
pub use touching::{
    Contacts, Contrast, ContrastSetting, ContrastTrend, ContrastUnit, LoadTrend, ValueDifference,
    contrast_trend, contrasts, load_trend,
};
pub use trends::{
    ActivePassive, ActivePassivePair, FrictionChange, LevelSpread, RoughnessTrend,
    across_participants, across_roughness, active_against_passive, friction_against_rms,
    friction_change, friction_on_speed, rms_on_speed,
};
pub use warning::{CompareWarning, Mixed, Named, plain_name};

use crate::quantity::Band;

/// The rms over the lines of `band` of the difference of two PSDs with the same lines, `resolution_hz` apart from
/// 0 Hz, in dB; `None` when they share no line above zero there.
///
/// Formula: √(mean (10·log10(a/b))²), unweighted.
///
/// Source: the spectrum error of [`crate::verify`], between two measurements.
#[must_use]
pub fn difference_db_rms(a: &[f64], b: &[f64], resolution_hz: f64, band: Band) -> Option<f64> {
    let squares: Vec<f64> = a
        .iter()
        .zip(b)
        .enumerate()
        .filter(|(k, (a, b))| band.contains(*k as f64 * resolution_hz) && **a > 0.0 && **b > 0.0)
        .map(|(_, (a, b))| (10.0 * (a / b).log10()).powi(2))
        .collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Whether groups can be compared: all in one unit.
///
/// Source: values combine only where their units match.
///
/// # Errors
/// [`CompareError::NotTogether`] naming two units.
pub fn comparable(groups: &[&Summary]) -> Result<(), CompareError> {
    let mut units = groups.iter().map(|group| &group.unit);
    let first = units.next();
    match units.find(|unit| Some(*unit) != first) {
        Some(other) => Err(CompareError::NotTogether {
            what: "the unit of the vibration",
            one: first.map_or(String::new(), ToString::to_string),
            other: other.to_string(),
        }),
        None => Ok(()),
    }
}

/// Why groups cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// There is nothing.
    #[error("there are no strokes to compare: look at what was rejected, and why")]
    Nothing,
    /// Recordings that cannot be averaged.
    #[error(
        "cannot average recordings: {what} is {one} in one and {other} in another; compare them separately"
    )]
    NotTogether {
        what: &'static str,
        one: String,
        other: String,
    },
}
