//! What roughness parameters leave open.

use std::fmt;

use super::length_text;
use piezotact::number::{digits_that_count, rounded};
use piezotact::warning::words::percent;
use piezotact::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// What a topography and its roughness parameters leave open.
    pub enum SurfaceWarning {
        /// Part of a height map was not measured.
        MissingPoints("missing_points") {
            /// The share of its points, 0–1.
            share: f64,
        },
        /// Points of a topography that are not evenly spaced were read as if they were.
        UnevenSteps("uneven_steps") {
            /// The largest departure from the mean step, as a share of it.
            worst: f64,
        },
        /// A roughness parameter from less than the standard's evaluation length.
        ShortEvaluation("short_evaluation") {
            /// Sections of one cut-off that fit.
            sections: usize,
            /// The number the standard asks for.
            asked: usize,
            /// The cut-off in m.
            cutoff_m: f64,
        },
        /// The stretch of a profile that was evaluated is not like the whole.
        UnevenProfile("uneven_profile") {
            /// Ra of what was evaluated, m.
            evaluated_ra_m: f64,
            /// Ra of the whole roughness profile, m.
            whole_ra_m: f64,
        },
        /// The cut-off rule did not settle on one cut-off.
        CutoffUnsettled("cutoff_unsettled") {
            /// The cut-off used, m.
            used_m: f64,
            /// Ra with it, m.
            ra_m: f64,
        },
        /// A profile that the instrument had filtered was filtered again.
        FilteredTwice("filtered_twice") {
            /// The cut-off of the second filter, m.
            cutoff_m: f64,
            /// Ra with it, m.
            ra_m: f64,
            /// Ra of the profile as it is, m.
            unfiltered_ra_m: f64,
        },
        /// A profile that was filtered here lacks long waves, as if it had been filtered before.
        LooksFiltered("looks_filtered") {
            /// The cut-off, m.
            cutoff_m: f64,
            /// Ra with the filter, m.
            ra_m: f64,
            /// Ra of the profile as it is, m.
            unfiltered_ra_m: f64,
        },
        /// A profile that counts as filtered by the instrument has the long waves that a filter removes.
        NotFiltered("not_filtered") {
            /// The instrument's cut-off, m.
            cutoff_m: f64,
            /// The share of its power in waves from twice the cut-off on, 0–1.
            share: f64,
        },
        /// A parameter is not the one that the instrument states.
        InstrumentDiffers("instrument_differs") {
            /// Its symbol.
            parameter: String,
            /// Ours, µm.
            ours_um: f64,
            /// The instrument's, µm.
            instrument_um: f64,
            /// Our cut-off, m.
            cutoff_m: Option<f64>,
            /// The instrument's cut-off, m.
            instrument_cutoff_m: Option<f64>,
        },
        /// The length in the header of a profile is that which was set, and another one was evaluated.
        LengthSet("length_set") {
            /// The length in the header, m.
            set_m: f64,
            /// The length evaluated, which was used, m.
            evaluated_m: f64,
            /// The step that follows from it, m.
            step_m: f64,
            /// The file that states the length evaluated.
            file: String,
        },
        /// The length in the header of a profile does not go with the number of its points.
        LengthUnconfirmed("length_unconfirmed") {
            /// The length in the header, m.
            length_m: f64,
            /// The number of points.
            points: usize,
            /// The step that follows from both, which was used, m.
            step_m: f64,
            /// The step that such instruments usually write, m.
            usual_step_m: f64,
        },
        /// The slope is that of no surface: the units of heights or steps are wrong.
        ImplausibleSlope("implausible_slope") {
            /// The root-mean-square slope.
            slope: f64,
        },
        /// Single points stand far out of a profile.
        Spikes("spikes") {
            /// How many.
            count: usize,
            /// Where the highest is, m.
            at_m: f64,
            /// How far it stands out, m.
            height_m: f64,
        },
        /// Single points stand far out of a height map.
        MapSpikes("map_spikes") {
            /// How many.
            count: usize,
            /// Where the highest is along a row, m.
            at_x_m: f64,
            /// Where it is across the rows, m.
            at_y_m: f64,
            /// How far it stands out, m.
            height_m: f64,
        },
        /// Every height is the same.
        FlatHeights("flat_heights"),
        /// Heights end at one value: the range of the instrument was too small.
        SaturatedHeights("saturated_heights") {
            /// Which end: "highest" or "lowest".
            limit: String,
            /// The value, m.
            height_m: f64,
            /// The share of the points there, 0–1.
            share: f64,
        },
        /// One value stands for a stretch in which nothing was measured.
        HeldHeights("held_heights") {
            /// How many stretches.
            count: usize,
            /// Where the longest begins, m.
            at_m: f64,
            /// How long it is, m.
            longest_m: f64,
        },
        /// The autocorrelation of a height map does not fall to its level within the lags that the map holds.
        LongCorrelation("long_correlation") {
            /// The level, 0–1.
            level: f64,
            /// How far lags reach, m.
            reached_m: f64,
        },
    }
}

impl WarningKind for SurfaceWarning {
    fn of(warning: &piezotact::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::MissingPoints { .. } => vec![Advice::FillPoints],
            Self::UnevenSteps { .. } => Vec::new(),
            Self::ShortEvaluation { .. } => {
                vec![Advice::MeasureLargerSurface, Advice::StateCutoff]
            }
            Self::FilteredTwice { .. } => vec![Advice::KeepSettingsFile, Advice::LeaveUnfiltered],
            Self::LooksFiltered { .. } => vec![Advice::LeaveUnfiltered],
            Self::InstrumentDiffers { .. } => vec![Advice::StateCutoff],
            Self::NotFiltered { .. } => vec![Advice::Check(Subject::Belonging)],
            Self::LengthSet { .. } => Vec::new(),
            Self::ImplausibleSlope { .. } => vec![Advice::Check(Subject::UnitAndScale)],
            Self::Spikes { .. }
            | Self::MapSpikes { .. }
            | Self::FlatHeights
            | Self::SaturatedHeights { .. }
            | Self::HeldHeights { .. } => {
                vec![Advice::Check(Subject::Measurement)]
            }
            Self::LengthUnconfirmed { .. } => vec![Advice::KeepSettingsFile, Advice::StateStep],
            Self::UnevenProfile { .. } | Self::CutoffUnsettled { .. } => vec![Advice::StateCutoff],
            Self::LongCorrelation { .. } => {
                vec![Advice::MeasureLargerSurface, Advice::RemoveMoreForm]
            }
        }
    }
}

impl fmt::Display for SurfaceWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MissingPoints { share } => write!(
                f,
                "{} of the points were not measured and are left out: parameters are those of the remaining points",
                percent(*share)
            ),
            Self::UnevenSteps { worst } => write!(
                f,
                "the points are not evenly spaced (steps differ by up to {}): slopes and spacings have the same uncertainty",
                percent(*worst)
            ),
            Self::ShortEvaluation {
                sections,
                asked,
                cutoff_m,
            } => write!(
                f,
                "only {sections} section{} of the cut-off {} mm, the standard requires {asked}",
                if *sections == 1 { "" } else { "s" },
                rounded(cutoff_m * 1e3)
            ),
            Self::UnevenProfile {
                evaluated_ra_m,
                whole_ra_m,
            } => write!(
                f,
                "the sections in the middle differ from the rest: their Ra is {} µm, that of the whole line {} µm; the \
                    line may include more than the intended surface",
                digits_that_count(evaluated_ra_m * 1e6, 4),
                digits_that_count(whole_ra_m * 1e6, 4)
            ),
            Self::CutoffUnsettled { used_m, ra_m } => write!(
                f,
                "no cut-off in the table of the standard agrees with the Ra that it gives (with {} mm, Ra is {} µm)",
                rounded(used_m * 1e3),
                digits_that_count(ra_m * 1e6, 4)
            ),
            Self::FilteredTwice {
                cutoff_m,
                ra_m,
                unfiltered_ra_m,
            } => write!(
                f,
                "the instrument had filtered this roughness profile, and it was filtered again with a cut-off of {}: Ra is {} µm, \
                    that of the profile as it is {} µm",
                length_text(*cutoff_m),
                digits_that_count(ra_m * 1e6, 4),
                digits_that_count(unfiltered_ra_m * 1e6, 4)
            ),
            Self::LooksFiltered {
                cutoff_m,
                ra_m,
                unfiltered_ra_m,
            } => write!(
                f,
                "waves longer than the cut-off of {} are as weak as a filter leaves them: the profile may have been filtered \
                    already (Ra is {} µm, that of the profile as it is {} µm)",
                length_text(*cutoff_m),
                digits_that_count(ra_m * 1e6, 4),
                digits_that_count(unfiltered_ra_m * 1e6, 4)
            ),
            Self::NotFiltered { cutoff_m, share } => write!(
                f,
                "{} of the power lies in waves longer than twice the instrument's cut-off of {}, which its filter removes: the \
                 profile does not look like a roughness profile, and it was not filtered here",
                percent(*share),
                length_text(*cutoff_m)
            ),
            Self::InstrumentDiffers {
                parameter,
                ours_um,
                instrument_um,
                cutoff_m,
                instrument_cutoff_m,
            } => {
                let with = |cutoff_m: &Option<f64>| match cutoff_m {
                    Some(cutoff_m) => format!(" (cut-off {})", length_text(*cutoff_m)),
                    None => String::new(),
                };
                write!(
                    f,
                    "{parameter} is {} µm{}, the instrument states {} µm{}",
                    digits_that_count(*ours_um, 4),
                    with(cutoff_m),
                    digits_that_count(*instrument_um, 4),
                    with(instrument_cutoff_m)
                )
            }
            Self::LengthSet {
                set_m,
                evaluated_m,
                step_m,
                file,
            } => write!(
                f,
                "the length of {} in the header is the length that was set; {} were evaluated ({file}), and the step of {} follows \
                    from that",
                length_text(*set_m),
                length_text(*evaluated_m),
                length_text(*step_m)
            ),
            Self::LengthUnconfirmed {
                length_m,
                points,
                step_m,
                usual_step_m,
            } => write!(
                f,
                "the header states {} for {points} points, a step of {}, where such instruments usually write {}: the length may \
                    be the one that was set, not the one that was evaluated; heights and Ra depend on it through the filter, \
                    widths and slopes directly",
                length_text(*length_m),
                length_text(*step_m),
                length_text(*usual_step_m)
            ),
            Self::ImplausibleSlope { slope } => write!(
                f,
                "the root-mean-square slope is {}, which is that of no surface: the unit of the heights or of the steps is wrong",
                digits_that_count(*slope, 3)
            ),
            Self::Spikes {
                count,
                at_m,
                height_m,
            } => write!(
                f,
                "{} far out of the profile, the highest by {} at {}: their remainder after filtering affects every parameter",
                match count {
                    1 => "1 spike stands".to_owned(),
                    count => format!("{count} spikes stand"),
                },
                length_text(*height_m),
                length_text(*at_m)
            ),
            Self::MapSpikes {
                count,
                at_x_m,
                at_y_m,
                height_m,
            } => write!(
                f,
                "{} far out of the map, the highest by {} at x {}, y {}: Sz, Sp, Sv and Sku are theirs, and Sq is larger",
                match count {
                    1 => "1 point stands".to_owned(),
                    count => format!("{count} points stand"),
                },
                length_text(*height_m),
                length_text(*at_x_m),
                length_text(*at_y_m)
            ),
            Self::FlatHeights => write!(f, "every height is the same: nothing was measured"),
            Self::SaturatedHeights {
                limit,
                height_m,
                share,
            } => write!(
                f,
                "{} of the points have exactly the {limit} value, {}: the range of the instrument was too small, and heights are \
                    underestimated",
                percent(*share),
                length_text(*height_m)
            ),
            Self::HeldHeights {
                count,
                at_m,
                longest_m,
            } => write!(
                f,
                "{} where one value is held, the longest of {} from {} on: nothing was measured there",
                match count {
                    1 => "there is 1 stretch".to_owned(),
                    count => format!("there are {count} stretches"),
                },
                length_text(*longest_m),
                length_text(*at_m)
            ),
            Self::LongCorrelation { level, reached_m } => write!(
                f,
                "in some direction the autocorrelation stays above {level} as far as {:.3} mm, half the map: Str is not given, \
                    nor is Sal if it does not fall in any direction",
                reached_m * 1e3,
                level = rounded(*level)
            ),
        }
    }
}
