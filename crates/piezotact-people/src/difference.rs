//! Which two are compared, and the permutation of participants that says whether they differ.

use std::fmt;
use std::str::FromStr;

use piezotact::statistics::{Permuted, mean, permutation_test, smallest_p};
use serde::{Deserialize, Serialize};

/// The probability up to which two are said to differ.
pub const LEVEL_SHARE: f64 = 0.05;

/// What is compared, by two names each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", content = "names", rename_all = "snake_case")]
pub enum Difference {
    /// Two samples that are offered together: right answers against those that name the other.
    Samples([String; 2]),
    /// Two tasks of the same people: shares of answers as expected.
    Tasks([String; 2]),
    /// The same people in two studies, or with two ways of rendering: shares of answers as expected.
    Again([String; 2]),
    /// Two groups of different people, such as own and averaged transfer functions: shares of answers as expected.
    People([String; 2]),
}

impl Difference {
    /// The two names.
    #[must_use]
    pub fn names(&self) -> &[String; 2] {
        match self {
            Self::Samples(names)
            | Self::Tasks(names)
            | Self::Again(names)
            | Self::People(names) => names,
        }
    }

    /// The smallest probability that a permutation of `participants` (of each group) can give.
    #[must_use]
    pub fn smallest_p(&self, [a, b]: [usize; 2]) -> f64 {
        match self {
            // All signs, or all opposite ones.
            Self::Samples(_) | Self::Tasks(_) | Self::Again(_) => 0.5_f64.powi(a as i32 - 1),
            Self::People(_) => smallest_p(a, b),
        }
        .min(1.0)
    }
}

impl FromStr for Difference {
    type Err = String;

    /// `samples:A,B`, `tasks:A,B`, `again:A,B` or `people:A,B`.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("expected samples:A,B, tasks:A,B, again:A,B or people:A,B, found `{text}`");
        let (what, of) = text.split_once(':').ok_or_else(expected)?;
        let names: Vec<&str> = of.split(',').map(str::trim).collect();
        let names = match names[..] {
            [a, b] if !a.is_empty() && !b.is_empty() => [a.to_owned(), b.to_owned()],
            _ => return Err(expected()),
        };
        match what {
            "samples" => Ok(Self::Samples(names)),
            "tasks" => Ok(Self::Tasks(names)),
            "again" => Ok(Self::Again(names)),
            "people" => Ok(Self::People(names)),
            _ => Err(expected()),
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.names();
        match self {
            Self::Samples(_) => write!(f, "samples {a} and {b}"),
            Self::Tasks(_) => write!(f, "tasks {a} and {b}"),
            Self::Again(_) => write!(f, "{a} and {b} (the same people)"),
            Self::People(_) => write!(f, "{a} and {b} (groups of people)"),
        }
    }
}

/// The probability, two-sided, of means of two groups at least as far apart, were it chance which person is in which: one share for
/// each person. `None` where a group has nobody.
///
/// Source: [`permutation_test`] with the absolute difference of means.
#[must_use]
pub fn between_people(a: &[f64], b: &[f64], draws: usize, seed: u64) -> Option<Permuted> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let all: Vec<f64> = a.iter().chain(b).copied().collect();
    // Around their mean, so that rounding is that of the differences.
    let centre = mean(&all);
    let all: Vec<f64> = all.iter().map(|share| share - centre).collect();
    let (n, m, sum) = (a.len() as f64, b.len() as f64, all.iter().sum::<f64>());
    let apart = &mut |chosen: &[usize]| {
        let part: f64 = chosen.iter().map(|i| all[*i]).sum();
        (part / n - (sum - part) / m).abs()
    };
    Some(permutation_test(all.len(), a.len(), draws, seed, apart))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::sign_flip_test;

    #[test]
    fn the_smallest_probability_is_that_of_people_who_all_differ_alike() {
        let two = || ["a".to_owned(), "b".to_owned()];
        for n in 1..9 {
            let differences = vec![0.25; n];
            let found = sign_flip_test(&differences, 999, 1).unwrap();
            let least = Difference::Tasks(two()).smallest_p([n; 2]);
            assert!((found.p_value - least).abs() < 1e-12, "{n}: {least}");
            for m in 1..9 {
                let found = between_people(&vec![0.25; n], &vec![0.75; m], 999, 1).unwrap();
                let least = Difference::People(two()).smallest_p([n, m]);
                assert!((found.p_value - least).abs() < 1e-9, "{n} {m}: {least}");
            }
        }
        assert_eq!(between_people(&[], &[1.0], 9, 1), None);
    }

    #[test]
    fn what_is_compared_is_read_as_it_is_written() {
        for (text, names) in [
            ("samples:S2,S3", ["S2", "S3"]),
            ("again: a , b", ["a", "b"]),
        ] {
            let read: Difference = text.parse().unwrap();
            assert_eq!(read.names(), &names.map(str::to_owned));
        }
        for bad in [
            "",
            "samples",
            "samples:",
            "samples:a",
            "samples:a,",
            "samples:a,b,c",
            "other:a,b",
        ] {
            assert!(bad.parse::<Difference>().is_err(), "{bad}");
        }
    }

    /// Shares that are all the same: every division is as extreme.
    #[test]
    fn no_difference_at_all_has_a_probability_of_one() {
        let same = [0.1 + 0.2, 0.3, 0.3];
        assert_eq!(between_people(&same, &same, 999, 1).unwrap().p_value, 1.0);
        assert_eq!(sign_flip_test(&[0.0; 4], 999, 1).unwrap().p_value, 1.0);
    }
}
