//! Which two are compared, and the permutations of participants that say whether they differ and by how much.

use std::fmt;
use std::str::FromStr;

use piezotact::statistics::{Permuted, mean, permutation_test, sign_flip_test, smallest_p};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The probability up to which two are said to differ.
pub const LEVEL_SHARE: f64 = 0.05;
/// Of groups one of which has fewer people nothing is decided: a difference in spread cannot be told from one of means.
///
/// Source: docs/decisions/answers.md.
pub const MIN_GROUP: usize = 5;
/// Standard errors are no smaller than this, in shares: people who are all alike have none.
const LEAST_ERROR: f64 = 1e-6;
/// Means that differ by less are the same, computed in another order.
const SAME_MEANS: f64 = 1e-12;
/// Bisections of an end of an interval: 2/2¹⁶ is far below a tenth of a point.
const BISECTIONS: usize = 16;

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

    /// The smallest probability that a permutation of `participants` (of each group) can give; 1 for groups below [`MIN_GROUP`].
    #[must_use]
    pub fn smallest_p(&self, [a, b]: [usize; 2]) -> f64 {
        match self {
            Self::People(_) if a.min(b) < MIN_GROUP => 1.0,
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

/// How two groups of people differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// Welch's t: the difference of the means over its standard error.
    pub t: f64,
    /// The degrees of freedom of Student's t.
    pub freedom: f64,
    /// The permutation of people, of the absolute value of Welch's t.
    pub permuted: Permuted,
    /// The probability that decides, two-sided: the larger of the permutation's and Student's.
    pub p_value: f64,
}

/// Whether the means of two groups of people differ: one share for each person. `None` where a group has nobody.
///
/// Formula: t = (ā − b̄)/√(s²a/n + s²b/m), which is permuted; and Student's t with the degrees of freedom of Welch and Satterthwaite, or
/// one less than the people of the smaller group where that one varies more: a permutation is too sure there.
///
/// Source: A. Janssen (1997), Stat. Probab. Lett. 36 (studentised permutations); B. L. Welch (1947), Biometrika 34;
/// [`permutation_test`]; docs/decisions/answers.md.
///
/// ```
/// use piezotact_people::difference::between_people;
/// let found = between_people(&[0.9, 0.8, 0.9, 1.0, 0.7], &[0.4, 0.6, 0.5, 0.3, 0.6], 999, 1).unwrap();
/// assert!((found.t - 4.9058).abs() < 1e-4 && (found.permuted.p_value - 2.0 / 252.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn between_people(a: &[f64], b: &[f64], draws: usize, seed: u64) -> Option<Between> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let groups = Groups::of(a, b);
    let permuted = groups.permuted(0.0, draws, seed);
    Some(Between {
        t: groups.t(0.0),
        freedom: groups.freedom,
        permuted,
        p_value: permuted.p_value.max(groups.student_p(0.0)),
    })
}

/// The 95 % interval of the difference of the means of two groups of people, from −1 to 1: the differences that [`between_people`] does not
/// reject, so that it holds 0 where that test decides nothing, and never where it decides. `None` for groups below [`MIN_GROUP`], and
/// where everybody of each group is alike.
///
/// Formula: the values θ of which p of a − θ and b is above 5 %.
///
/// Source: as [`between_people`]; P. H. Garthwaite (1996), Biometrics 52, for intervals of permutation tests.
#[must_use]
pub fn between_interval(a: &[f64], b: &[f64], draws: usize, seed: u64) -> Option<[f64; 2]> {
    if a.len().min(b.len()) < MIN_GROUP {
        return None;
    }
    let groups = Groups::of(a, b);
    if groups.error <= LEAST_ERROR {
        return None;
    }
    let holds = |by: f64| {
        groups.student_p(by) > LEVEL_SHARE || groups.permuted(by, draws, seed).p_value > LEVEL_SHARE
    };
    Some([-1.0, 1.0].map(|bound| end(groups.less, bound, &holds)))
}

/// The 95 % interval of the mean of `differences`, one of each person, from −1 to 1: the means that [`sign_flip_test`] does not reject, so
/// that the two agree. `None` where people are all alike, or so few that no signs reach 5 %.
///
/// Formula: the values θ of which p of the differences less θ is above 5 %.
///
/// Source: as [`between_interval`].
#[must_use]
pub fn paired_interval(differences: &[f64], draws: usize, seed: u64) -> Option<[f64; 2]> {
    let (first, others) = differences.split_first()?;
    // All signs, or all opposite ones.
    if 0.5_f64.powi(others.len() as i32) > LEVEL_SHARE || others.iter().all(|d| d == first) {
        return None;
    }
    let holds = |by: f64| {
        let moved: Vec<f64> = differences.iter().map(|d| d - by).collect();
        sign_flip_test(&moved, draws, seed).is_some_and(|test| test.p_value > LEVEL_SHARE)
    };
    Some([-1.0, 1.0].map(|bound| end(mean(differences), bound, &holds)))
}

/// The last value that holds from `inside`, which does, towards `bound`. Zero is tried itself, so that an interval agrees with its test.
fn end(inside: f64, bound: f64, holds: &dyn Fn(f64) -> bool) -> f64 {
    let (mut inside, mut outside) = (inside, bound);
    if -inside * bound > 0.0 {
        match holds(0.0) {
            true => inside = 0.0,
            false => outside = 0.0,
        }
    }
    if outside == bound && holds(bound) {
        return bound;
    }
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(inside, outside);
        match holds(middle) {
            true => inside = middle,
            false => outside = middle,
        }
    }
    inside
}

/// Two groups of people, around their common mean, so that rounding is that of the differences.
struct Groups {
    first: usize,
    all: Vec<f64>,
    less: f64,
    error: f64,
    freedom: f64,
}

impl Groups {
    fn of(a: &[f64], b: &[f64]) -> Self {
        let all: Vec<f64> = a.iter().chain(b).copied().collect();
        let centre = mean(&all);
        let spread = |values: &[f64]| {
            let (n, middle) = (values.len() as f64, mean(values));
            let squares: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
            (n, squares / (n - 1.0).max(1.0))
        };
        let ((n, own), (m, other)) = (spread(a), spread(b));
        let (of_a, of_b) = (own / n, other / m);
        let is_smaller_wider = (n < m && own > other) || (m < n && other > own);
        let freedom = match is_smaller_wider {
            true => n.min(m) - 1.0,
            false => (of_a + of_b).powi(2) / (of_a.powi(2) / (n - 1.0) + of_b.powi(2) / (m - 1.0)),
        };
        Self {
            first: a.len(),
            all: all.iter().map(|share| share - centre).collect(),
            less: mean(a) - mean(b),
            error: (of_a + of_b).sqrt().max(LEAST_ERROR),
            // People who are all alike have none.
            freedom: freedom.max(1.0),
        }
    }

    /// Welch's t of the first group less `by`.
    fn t(&self, by: f64) -> f64 {
        (self.less - by) / self.error
    }

    /// Student's two-sided probability.
    fn student_p(&self, by: f64) -> f64 {
        let distribution = StudentsT::new(0.0, 1.0, self.freedom);
        distribution.map_or(1.0, |of| 2.0 * of.cdf(-self.t(by).abs()))
    }

    /// The permutation of |t|, of the first group less `by`.
    fn permuted(&self, by: f64, draws: usize, seed: u64) -> Permuted {
        let all = self.all.iter().enumerate();
        let all = all.map(|(i, v)| if i < self.first { v - by } else { *v });
        let all: Vec<f64> = all.collect();
        let (n, m) = (self.first as f64, (all.len() - self.first) as f64);
        let sum: f64 = all.iter().sum();
        let squares: f64 = all.iter().map(|v| v * v).sum();
        let error_squared = |sum: f64, squares: f64, n: f64| {
            (squares - sum * sum / n).max(0.0) / (n - 1.0).max(1.0) / n
        };
        let statistic = &mut |chosen: &[usize]| {
            let (mut own, mut own_squares) = (0.0, 0.0);
            for i in chosen {
                own += all[*i];
                own_squares += all[*i] * all[*i];
            }
            let apart = (own / n - (sum - own) / m).abs();
            let error = error_squared(own, own_squares, n)
                + error_squared(sum - own, squares - own_squares, m);
            match apart < SAME_MEANS {
                true => 0.0,
                false => apart / error.sqrt().max(LEAST_ERROR),
            }
        };
        permutation_test(all.len(), self.first, draws, seed, statistic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                let found = found.permuted.p_value;
                assert!((found - smallest_p(n, m)).abs() < 1e-9, "{n} {m}: {found}");
                let least = Difference::People(two()).smallest_p([n, m]);
                let is_few = n.min(m) < MIN_GROUP;
                assert_eq!(least, if is_few { 1.0 } else { smallest_p(n, m) });
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
