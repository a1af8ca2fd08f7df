//! What roughness parameters leave open.

use super::length_text;
use piezotact::number::{digits_that_count, rounded};
use piezotact::warning::words::percent;
use serde::{Deserialize, Serialize};

/// What a topography and its roughness parameters leave open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SurfaceWarning {
    /// The stretch of a profile that was evaluated is not like the whole.
    #[error(
        "the sections in the middle differ from the rest: their Ra is {} µm, that of the whole line {} µm; the line may include more than the \
            intended surface; state the cut-off",
        digits_that_count(evaluated_ra_m * 1e6, 4),
        digits_that_count(whole_ra_m * 1e6, 4)
    )]
    UnevenProfile {
        evaluated_ra_m: f64,
        whole_ra_m: f64,
    },
    /// The sections of a profile are not those of one surface.
    #[error(
        "Ra is {} µm in one section and {} µm in another: the line holds more than one surface, such as a groove beside a plane, so that its \
            parameters describe neither; evaluate each part by itself",
        digits_that_count(lowest_ra_m * 1e6, 3),
        digits_that_count(highest_ra_m * 1e6, 3)
    )]
    UnevenSections { lowest_ra_m: f64, highest_ra_m: f64 },
    /// The cut-off rule did not settle on one cut-off.
    #[error(
        "no cut-off in the table of the standard agrees with the Ra that it gives (with {} mm, Ra is {} µm): state the cut-off",
        rounded(used_m * 1e3),
        digits_that_count(ra_m * 1e6, 4)
    )]
    CutoffUnsettled { used_m: f64, ra_m: f64 },
    /// The autocorrelation of a height map does not fall to its level within the lags that the map holds.
    #[error(
        "in some direction the autocorrelation stays above {level} as far as {:.3} mm, half the map: Str is not given, nor is Sal if it does not \
            fall in any direction; measure a longer line or a larger area; remove more form or waviness",
        reached_m * 1e3,
        level = rounded(*level)
    )]
    LongCorrelation { level: f64, reached_m: f64 },
    /// Heights that cannot be trusted.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "heights_doubtful")]
    Heights {
        #[serde(flatten)]
        fault: HeightsFault,
    },
    /// A profile that is filtered twice, or not at all.
    #[error("{}; {}", fault.sentence(*cutoff_m), fault.advice())]
    #[serde(rename = "filter_doubtful")]
    Filter {
        cutoff_m: f64,
        #[serde(flatten)]
        fault: FilterFault,
    },
    /// What an instrument states is not what is found.
    #[error("{what}; {}", what.advice())]
    #[serde(rename = "instrument_differs")]
    Instrument {
        #[serde(flatten)]
        what: InstrumentStates,
    },
}

/// What an instrument states and is not found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum InstrumentStates {
    /// A parameter is not the one that the instrument states.
    #[error(
        "{parameter} is {} µm{}, the instrument states {} µm{}",
        digits_that_count(*ours_um, 4),
        with_cutoff(*cutoff_m),
        digits_that_count(*instrument_um, 4),
        with_cutoff(*instrument_cutoff_m)
    )]
    Parameter {
        parameter: String,
        ours_um: f64,
        instrument_um: f64,
        cutoff_m: Option<f64>,
        instrument_cutoff_m: Option<f64>,
    },
    /// The length in the header of a profile is that which was set, and another one was evaluated.
    #[error(
        "the length of {} in the header is the length that was set; {} were evaluated ({file}), and the step of {} follows from that",
        length_text(*set_m),
        length_text(*evaluated_m),
        length_text(*step_m)
    )]
    LengthSet {
        set_m: f64,
        evaluated_m: f64,
        step_m: f64,
        file: String,
    },
    /// The length in the header of a profile does not go with the number of its points.
    #[error(
        "the header states {} for {points} points, a step of {}, where such instruments usually write {}: the length may be the one that was set, \
            not the one that was evaluated; heights and Ra depend on it through the filter, widths and slopes directly",
        length_text(*length_m),
        length_text(*step_m),
        length_text(*usual_step_m)
    )]
    Length {
        length_m: f64,
        points: usize,
        step_m: f64,
        usual_step_m: f64,
    },
}

impl InstrumentStates {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Parameter { .. } => "state the cut-off",
            Self::LengthSet { .. } => "state the step between points if it is another",
            Self::Length { .. } => {
                "keep the instrument's file with settings (.tx3) beside the profile, or state the step between points"
            }
        }
    }
}

/// What is doubtful about the filter of a profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum FilterFault {
    /// A profile that the instrument had filtered was filtered again.
    Twice { ra_m: f64, unfiltered_ra_m: f64 },
    /// A profile that was filtered here lacks long waves, as if it had been filtered before.
    LooksFiltered { ra_m: f64, unfiltered_ra_m: f64 },
    /// A profile that counts as filtered by the instrument has the long waves that a filter removes.
    NotFiltered { share: f64 },
}

impl FilterFault {
    /// What is doubtful, with this cut-off.
    fn sentence(&self, cutoff_m: f64) -> String {
        let cutoff = length_text(cutoff_m);
        let ra_um = |ra_m: f64| digits_that_count(ra_m * 1e6, 4);
        match self {
            Self::Twice {
                ra_m,
                unfiltered_ra_m,
            } => format!(
                "the instrument had filtered this roughness profile, and it was filtered again with a cut-off of {cutoff}: Ra is {} µm, that of the \
                 profile as it is {} µm",
                ra_um(*ra_m),
                ra_um(*unfiltered_ra_m)
            ),
            Self::LooksFiltered {
                ra_m,
                unfiltered_ra_m,
            } => format!(
                "waves longer than the cut-off of {cutoff} are as weak as a filter leaves them: the profile may have been filtered already (Ra is {} \
                 µm, that of the profile as it is {} µm)",
                ra_um(*ra_m),
                ra_um(*unfiltered_ra_m)
            ),
            Self::NotFiltered { share } => format!(
                "{} of the power lies in waves longer than twice the instrument's cut-off of {cutoff}, which its filter removes: the profile does not \
                 look like a roughness profile, and it was not filtered here",
                percent(*share)
            ),
        }
    }

    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Twice { .. } => {
                "keep the instrument's file with settings (.tx3) beside the profile, or evaluate it without a filter"
            }
            Self::LooksFiltered { .. } => "evaluate it without a filter",
            Self::NotFiltered { .. } => "check that they belong together",
        }
    }
}

/// What is wrong with heights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum HeightsFault {
    /// Part of a height map was not measured.
    #[error(
        "{} of the points were not measured and are left out: parameters are those of the remaining points",
        percent(*share)
    )]
    Missing { share: f64 },
    /// The slope is that of no surface: the units of heights or steps are wrong.
    #[error(
        "the root-mean-square slope is {}, which is that of no surface: the unit of the heights or of the steps is wrong",
        digits_that_count(*slope, 3)
    )]
    Slope { slope: f64 },
    /// Single points stand far out of a profile.
    #[error(
        "{} far out of the profile, the highest by {} at {}: their remainder after filtering affects every parameter",
        match count {
        1 => "1 spike stands".to_owned(),
        count => format!("{count} spikes stand"),
        },
        length_text(*height_m),
        length_text(*at_m)
    )]
    Spikes {
        count: usize,
        at_m: f64,
        height_m: f64,
    },
    /// Single points stand far out of a height map.
    #[error(
        "{} far out of the map, the highest by {} at x {}, y {}: Sz, Sp, Sv and Sku are theirs, and Sq is larger",
        match count {
        1 => "1 point stands".to_owned(),
        count => format!("{count} points stand"),
        },
        length_text(*height_m),
        length_text(*at_x_m),
        length_text(*at_y_m)
    )]
    MapSpikes {
        count: usize,
        at_x_m: f64,
        at_y_m: f64,
        height_m: f64,
    },
    /// Every height is the same.
    #[error("every height is the same: nothing was measured")]
    Flat,
    /// Heights end at one value: the range of the instrument was too small.
    #[error(
        "{} of the points have exactly the {limit} value, {}: the range of the instrument was too small, and heights are underestimated",
        percent(*share),
        length_text(*height_m)
    )]
    Saturated {
        limit: String,
        height_m: f64,
        share: f64,
    },
    /// One value stands for a stretch in which nothing was measured.
    #[error(
        "the profile is constant over {}, the longest of {} from {} on: the instrument measured nothing there and repeated its last value",
        match count {
            1 => "1 stretch".to_owned(),
            count => format!("{count} stretches"),
        },
        length_text(*longest_m),
        length_text(*at_m)
    )]
    Held {
        count: usize,
        at_m: f64,
        longest_m: f64,
    },
}

impl HeightsFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Missing { .. } => "measure again the areas where many are missing",
            Self::Slope { .. } => "check the unit and scale of heights and steps",
            Self::Spikes { .. }
            | Self::MapSpikes { .. }
            | Self::Flat
            | Self::Saturated { .. }
            | Self::Held { .. } => "look at the heights, and measure them again",
        }
    }
}

/// A cut-off, where there is one.
fn with_cutoff(cutoff_m: Option<f64>) -> String {
    cutoff_m.map_or_else(String::new, |cutoff_m| {
        format!(" (cut-off {})", length_text(cutoff_m))
    })
}
