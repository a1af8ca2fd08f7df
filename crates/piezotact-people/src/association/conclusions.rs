//! How many conclusions one report draws, beside what chance draws.

use piezotact::criterion::Outcome;

use super::confused::PairOutcome;
use super::document::Association;
use crate::difference::LEVEL_SHARE;

impl Association {
    /// How many conclusions the report draws in each of its families of tests, and how many chance draws were every truth at its limit; `None`
    /// for a single test.
    ///
    /// Formula: 5 % of the shares and pairs with an interval, and 5 % of one for all differences together, as Holm adjusts them.
    #[must_use]
    pub fn conclusions_sentence(&self) -> Option<String> {
        // One group alone is all of them.
        let groups = self.matrices.iter().filter(|_| self.matrices.len() > 2);
        let groups = groups.filter_map(|of| of.expected.as_ref());
        let shares = self.expected.iter().chain(groups).map(|of| &of.criterion);
        let shares: Vec<Outcome> = shares
            .filter(|criterion| criterion.interval.is_some())
            .map(|criterion| criterion.outcome)
            .collect();
        let pairs = self.pairs.iter();
        let pairs: Vec<PairOutcome> = pairs
            .filter(|pair| pair.criterion.interval.is_some())
            .map(|pair| pair.outcome)
            .collect();
        let decided = [
            shares
                .iter()
                .filter(|one| **one != Outcome::NotDecided)
                .count(),
            pairs
                .iter()
                .filter(|one| **one != PairOutcome::NotDecided)
                .count(),
            self.comparisons
                .iter()
                .filter(|one| one.outcome() == Outcome::Met)
                .count(),
        ];
        let tests = [shares.len(), pairs.len(), self.comparisons.len()];
        if tests.iter().sum::<usize>() < 2 {
            return None;
        }
        let names = ["shares as expected", "pairs", "differences"];
        let each = decided.iter().zip(tests).zip(names);
        let each = each.filter(|((_, tests), _)| *tests > 0);
        let each: Vec<String> = each
            .map(|((decided, tests), name)| format!("{decided} of {tests} on {name}"))
            .collect();
        let together = usize::from(!self.comparisons.is_empty());
        let holm = match together {
            0 => "",
            _ => " (differences together as one, Holm)",
        };
        Some(format!(
            "Conclusions at 5 %: {}. Expected by chance, were every truth at its limit: {:.1}{holm}.",
            each.join(", "),
            LEVEL_SHARE * (tests[0] + tests[1] + together) as f64
        ))
    }
}
