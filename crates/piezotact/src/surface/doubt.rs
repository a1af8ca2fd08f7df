//! What roughness parameters leave open.

use std::fmt;

use crate::doubt::words::percent;
use crate::doubt::{Advice, DoubtKind, doubts};

doubts! {
    /// What a topography and its roughness parameters leave open.
    pub enum SurfaceDoubt {
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
        /// The autocorrelation of a height map does not fall to its level within the lags that the map holds.
        LongCorrelation("long_correlation") {
            /// The level, 0–1.
            level: f64,
            /// How far lags reach, m.
            reached_m: f64,
        },
    }
}

impl DoubtKind for SurfaceDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::MissingPoints { .. } => vec![Advice::FillPoints],
            Self::UnevenSteps { .. } => Vec::new(),
            Self::ShortEvaluation { .. } => {
                vec![Advice::MeasureLargerSurface, Advice::StateCutoff]
            }
            Self::UnevenProfile { .. } | Self::CutoffUnsettled { .. } => vec![Advice::StateCutoff],
            Self::LongCorrelation { .. } => {
                vec![Advice::MeasureLargerSurface, Advice::RemoveMoreForm]
            }
        }
    }
}

impl fmt::Display for SurfaceDoubt {
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
                cutoff_m * 1e3
            ),
            Self::UnevenProfile {
                evaluated_ra_m,
                whole_ra_m,
            } => write!(
                f,
                "the sections in the middle differ from the rest: their Ra is {:.4} µm, that of the whole line {:.4} µm; the \
                    line may include more than the intended surface",
                evaluated_ra_m * 1e6,
                whole_ra_m * 1e6
            ),
            Self::CutoffUnsettled { used_m, ra_m } => write!(
                f,
                "no cut-off in the table of the standard agrees with the Ra that it gives (with {} mm, Ra is {:.4} µm)",
                used_m * 1e3,
                ra_m * 1e6
            ),
            Self::LongCorrelation { level, reached_m } => write!(
                f,
                "in some direction the autocorrelation stays above {level} as far as {:.3} mm, half the map: Str is not given, \
                    nor is Sal if it does not fall in any direction",
                reached_m * 1e3
            ),
        }
    }
}
