//! Conclusions in words: a direction only where the numbers have one, and what they are over.

use super::{Direction, LogFit, PairedDifference, RankCorrelation};
use crate::number::{p_text, signed};

impl LogFit {
    /// What a power law of `y` on `x` says; its points are `units`, such as "speeds".
    #[must_use]
    pub fn conclusion(&self, y: &str, x: &str, units: &str) -> String {
        let (Some([low, high]), Some(p)) = (self.slope_interval, self.p_value) else {
            return format!(
                "{y} and {x}: not decided from {} {units} (exponent {})",
                self.points,
                signed(self.slope, 2)
            );
        };
        let numbers = format!(
            "exponent {} (95 %: {} to {} over {} {units}, {})",
            signed(self.slope, 2),
            signed(low, 2),
            signed(high, 2),
            self.points,
            p_text(p)
        );
        match self.direction() {
            Direction::Rises => format!("{y} rises with {x}: {numbers}"),
            Direction::Falls => format!("{y} falls with {x}: {numbers}"),
            Direction::NotShown => format!("{y} and {x}: no trend shown: {numbers}"),
        }
    }
}

impl RankCorrelation {
    /// What a rank correlation of `y` and `x` says; its pairs are `units`, such as "samples".
    #[must_use]
    pub fn conclusion(&self, y: &str, x: &str, units: &str) -> String {
        let rho = signed(self.rho, 2);
        let numbers = format!(
            "rank correlation {rho} ({} over {} {units})",
            p_text(self.p_value),
            self.pairs
        );
        match self.direction() {
            Direction::Rises => format!("{y} rises with {x}: {numbers}"),
            Direction::Falls => format!("{y} falls with {x}: {numbers}"),
            Direction::NotShown if self.too_few() => format!(
                "{y} and {x}: not decided: no order of {} {units} could show a trend at p < 0.05 (rank correlation {rho})",
                self.pairs
            ),
            Direction::NotShown => format!("{y} and {x}: no trend shown: {numbers}"),
        }
    }
}

impl PairedDifference {
    /// What a paired difference of levels in dB between two things says; its pairs are `units`.
    #[must_use]
    pub fn conclusion_on_levels(&self, between: [&str; 2], units: &str) -> String {
        let [low, high] = self.interval;
        let numbers = format!(
            "{} dB (95 %: {} to {} dB over {} {units}, {})",
            signed(self.mean, 1),
            signed(low, 1),
            signed(high, 1),
            self.pairs,
            p_text(self.p_value)
        );
        let [one, other] = between;
        match Direction::of(Some(self.interval)) {
            Direction::Rises => format!("{one} has a higher level than {other}: {numbers}"),
            Direction::Falls => format!("{one} has a lower level than {other}: {numbers}"),
            Direction::NotShown => {
                format!("{one} and {other}: no difference in level shown: {numbers}")
            }
        }
    }
}
