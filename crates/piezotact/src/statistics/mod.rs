//! Statistics of plain numbers: mean, level and peak, medians, intervals, ranks, lines and permutation tests.

mod conclusion;
mod levels;
mod line;
mod moments;
mod order;
mod paired;
mod permutation;
pub mod random;
mod rank;
mod student;

/// Standard errors on either side of a normal estimate that hold it with 95 %, dimensionless.
pub const Z_95: f64 = 1.959_963_984_540_054;

pub use levels::LevelSpread;
pub use line::{Direction, LogFit, Trend, log_fit, trend};
pub use moments::{correlation, mean, peak, rms, standard_deviation};
pub use order::{median, vertex};
pub use paired::{PairedDifference, mean_interval, paired_difference, sign_test};
pub(crate) use permutation::{Draws, units_needed};
pub use permutation::{
    Permuted, holm, permutation_test, permutation_test_within, sign_flip_test, smallest_p,
};
pub use rank::{RankCorrelation, rank_correlation, spearman};
pub(crate) use student::deviation_interval;
pub use student::t_quantile;
