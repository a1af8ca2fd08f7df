//! What a planned number of people can show: power of a paired comparison, and the interval of a cell, by simulation.

use std::collections::BTreeMap;

use piezotact::statistics::{Z_95, mean, standard_deviation, t_quantile};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use statrs::function::gamma::ln_gamma;

use super::error::{DesignError, above_0_below, must};
use crate::campaign::random::Stream;
use crate::interval::{clopper_pearson, clustered_interval};

/// The smallest number of simulated studies.
const FEWEST_STUDIES: usize = 100;
/// Steps of the integral over the standard deviation.
const STEPS: usize = 4000;
/// The most presentations to all participants together.
pub(super) const MOST_PRESENTED: usize = 100_000;
/// The most presentations in all simulated studies together; beyond it there are fewer studies, and a wider interval says so.
const MOST_SIMULATED: usize = 20_000_000;
/// The largest number of participants that is looked for.
const MOST_PARTICIPANTS: usize = 10_000;

/// The power of a two-sided paired t-test (α = 0.05) of `participants` people for a standardised mean difference
/// d = `effect_ratio` (mean over standard deviation of the differences); `None` below two people or for an effect that is not
/// finite.
///
/// Source: noncentral t, Cohen (1988), Statistical Power Analysis, 2nd ed.; as SciPy's `nct`.
#[must_use]
pub fn paired_power(participants: usize, effect_ratio: f64) -> Option<f64> {
    if participants < 2 || !effect_ratio.is_finite() {
        return None;
    }
    let freedom = (participants - 1) as f64;
    let critical = t_quantile(participants - 1)?;
    let shift = effect_ratio.abs() * (participants as f64).sqrt();
    let normal = Normal::standard();
    // s, the ratio of estimated to true deviation, has the density 2(ν/2)^(ν/2)/Γ(ν/2)·s^(ν−1)·exp(−νs²/2).
    let constant = 2f64.ln() + freedom / 2.0 * (freedom / 2.0).ln() - ln_gamma(freedom / 2.0);
    let value = |s: f64| {
        if s == 0.0 && freedom > 1.0 {
            return 0.0;
        }
        let log = if freedom > 1.0 {
            (freedom - 1.0) * s.ln()
        } else {
            0.0
        };
        let density = (constant + log - freedom * s * s / 2.0).exp();
        density * (normal.cdf(shift - critical * s) + normal.cdf(-shift - critical * s))
    };
    // 12 standard deviations of s, and at least as far as a normal number of 9.
    let end = 1.0 + 12.0 / freedom.sqrt();
    let step = end / STEPS as f64;
    let weight = |i: usize| match i {
        0 | STEPS => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=STEPS)
        .map(|i| weight(i) * value(i as f64 * step))
        .sum();
    Some((sum * step / 3.0).clamp(0.0, 1.0))
}

/// The smallest number of people whose paired t-test has a power of `power_share` for d = `effect_ratio`; `None` above 10 000.
///
/// Source: [`paired_power`], searched.
#[must_use]
pub fn participants_for_power(effect_ratio: f64, power_share: f64) -> Option<usize> {
    let enough = |n: usize| paired_power(n, effect_ratio).is_some_and(|p| p >= power_share);
    if !enough(MOST_PARTICIPANTS) {
        return None;
    }
    let (mut too_few, mut found) = (1, MOST_PARTICIPANTS);
    while found - too_few > 1 {
        let middle = usize::midpoint(too_few, found);
        if enough(middle) {
            found = middle;
        } else {
            too_few = middle;
        }
    }
    Some(found)
}

/// What is assumed about one cell of an association matrix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CellPlan {
    /// The number of participants.
    pub participants: usize,
    /// Presentations of the sample to each participant.
    pub presentations: usize,
    /// The share of answers in the cell of the median participant, above 0 and below 1.
    pub share: f64,
    /// The standard deviation over participants, of the logit of that share.
    pub logit_sd: f64,
}

/// The interval that a cell can be expected to have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CellPrecision {
    /// What was assumed.
    pub plan: CellPlan,
    /// The number of simulated studies.
    pub studies: usize,
    /// The mean half-width of the 95 % interval over participants, as a share.
    pub half_width_share: f64,
    /// The 95 % interval of that mean over the simulated studies.
    pub interval: [f64; 2],
    /// The share of studies whose interval over participants holds the truth.
    pub coverage_share: f64,
    /// The share of studies whose interval over pooled answers (Clopper and Pearson) holds the truth.
    pub pooled_coverage_share: f64,
}

/// The expected 95 % interval of a cell, over `studies` simulated studies of participants who differ (logit-normal), fewer where
/// they would take more than 20 million presentations. The interval is that of an association matrix, [`clustered_interval`];
/// where a matrix has none, with one or two participants, it is the whole range.
///
/// # Errors
///
/// No participant, no presentation, a share not between 0 and 1, a negative or infinite spread, or fewer than
/// 100 studies.
///
/// Source: [`clustered_interval`], simulated; docs/decisions/campaigns.md.
pub fn cell_precision(
    plan: &CellPlan,
    studies: usize,
    seed: u64,
) -> Result<CellPrecision, DesignError> {
    check(plan, studies)?;
    let mut draws = Stream::of(seed, &["precision"]);
    let logit = (plan.share / (1.0 - plan.share)).ln();
    let person = |z: f64| 1.0 / (1.0 + (-logit - plan.logit_sd * z).exp());
    let truth = expectation(person);
    let trials = plan.participants * plan.presentations;
    let studies = studies.min((MOST_SIMULATED / trials).max(FEWEST_STUDIES));
    // Studies with the same counts have the same intervals.
    let mut known: BTreeMap<Vec<usize>, [[f64; 2]; 2]> = BTreeMap::new();
    let normal = Normal::standard();
    let mut widths = Vec::with_capacity(studies);
    let (mut covered, mut pooled_covered) = (0_usize, 0_usize);
    for _ in 0..studies {
        let mut counts: Vec<usize> = (0..plan.participants)
            .map(|_| {
                let share = person(normal.inverse_cdf(uniform(&mut draws)));
                (0..plan.presentations)
                    .filter(|_| uniform(&mut draws) < share)
                    .count()
            })
            .collect();
        counts.sort_unstable();
        let [[low, high], of_pool] = *known
            .entry(counts)
            .or_insert_with_key(|counts| intervals(counts, plan.presentations));
        widths.push((high - low) / 2.0);
        covered += usize::from(low <= truth && truth <= high);
        pooled_covered += usize::from(of_pool[0] <= truth && truth <= of_pool[1]);
    }
    let half_width_share = mean(&widths);
    let error = Z_95 * standard_deviation(&widths) / (studies as f64).sqrt();
    Ok(CellPrecision {
        plan: *plan,
        studies,
        half_width_share,
        interval: [half_width_share - error, half_width_share + error],
        coverage_share: covered as f64 / studies as f64,
        pooled_coverage_share: pooled_covered as f64 / studies as f64,
    })
}

/// The interval over participants and that over pooled answers, of participants with `counts` of `presentations` answers each.
fn intervals(counts: &[usize], presentations: usize) -> [[f64; 2]; 2] {
    let each: Vec<(usize, usize)> = counts.iter().map(|k| (*k, presentations)).collect();
    let clustered = clustered_interval(&each).and_then(|found| found.interval);
    let pooled = clopper_pearson(counts.iter().sum(), presentations * counts.len());
    [clustered.unwrap_or([0.0, 1.0]), pooled]
}

fn check(plan: &CellPlan, studies: usize) -> Result<(), DesignError> {
    let (what, people) = ("the number of participants", plan.participants as f64);
    must(what, people, 1.0..=MOST_PARTICIPANTS as f64, "1 to 10 000")?;
    let what = "the number of presentations to each participant";
    must(what, plan.presentations as f64, 1.0..=1000.0, "1 to 1000")?;
    let presented = plan.participants.saturating_mul(plan.presentations) as f64;
    let what = "the number of presentations to all participants together";
    must(what, presented, ..=MOST_PRESENTED as f64, "at most 100 000")?;
    let (what, range) = ("the expected share of a cell", above_0_below(1.0));
    must(what, plan.share, range, "above 0 and below 1")?;
    let what = "the spread of participants in logits";
    must(what, plan.logit_sd, 0.0..=10.0, "0 to 10")?;
    let what = "the number of simulated studies";
    must(
        what,
        studies as f64,
        FEWEST_STUDIES as f64..,
        "at least 100",
    )
}

/// The half-width of the 95 % interval of a mean rating over `participants` people, Student's t, as a share of a scale of `range`
/// steps; half of the scale where that is less, and with one participant. Each person's rating is the whole number nearest to a share
/// of the scale; the logit of that share is normal over people, with `share` as that of the median participant.
///
/// # Errors
///
/// No participant, no step, a share not between 0 and 1, a negative or infinite spread.
///
/// Source: Student (1908), Biometrika 6:1, with the standard deviation of the assumed ratings, integrated; docs/decisions/campaigns.md.
pub(super) fn rating_half_width(
    participants: usize,
    range: u64,
    share: f64,
    logit_sd: f64,
) -> Result<f64, DesignError> {
    let plan = CellPlan {
        participants,
        presentations: 1,
        share,
        logit_sd,
    };
    check(&plan, FEWEST_STUDIES)?;
    must("the steps of a scale", range as f64, 1.0.., "1 or more")?;
    let Some(quantile) = t_quantile(participants - 1) else {
        return Ok(0.5);
    };
    let logit = (share / (1.0 - share)).ln();
    let steps = range as f64;
    let rating = |z: f64| (steps / (1.0 + (-logit - logit_sd * z).exp())).round() / steps;
    let mean = expectation(rating);
    let variance = expectation(|z| (rating(z) - mean).powi(2));
    Ok((quantile * (variance / participants as f64).sqrt()).min(0.5))
}

/// A number above 0 and below 1, of 52 random bits.
pub(super) fn uniform(draws: &mut Stream) -> f64 {
    (draws.below(1 << 52) as f64 + 0.5) * 2f64.powi(-52)
}

/// The mean of `of` over a standard normal number, by the trapezoidal rule to ±8.
fn expectation(of: impl Fn(f64) -> f64) -> f64 {
    let step = 0.01;
    let at = |i: i32| f64::from(i) * step;
    let weighted = |i: i32| (-at(i).powi(2) / 2.0).exp();
    let (sum, weights) = (-800..=800).fold((0.0, 0.0), |(sum, weights), i| {
        (sum + weighted(i) * of(at(i)), weights + weighted(i))
    });
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: CellPlan = CellPlan {
        participants: 10,
        presentations: 12,
        share: 0.7,
        logit_sd: 0.9,
    };

    #[test]
    fn without_an_effect_the_power_is_the_level() {
        for n in [2, 3, 10, 200] {
            let found = paired_power(n, 0.0).unwrap();
            // The tail of Cauchy's distribution for two people is cut at 13 deviations.
            assert!(
                (found - 0.05).abs() < if n == 2 { 1e-4 } else { 1e-8 },
                "{n}: {found}"
            );
        }
        assert_eq!(paired_power(1, 0.5), None);
        assert_eq!(paired_power(10, f64::NAN), None);
        assert_eq!(participants_for_power(0.0, 0.8), None);
    }

    #[test]
    fn pooled_answers_of_people_who_differ_are_too_certain() {
        let found = cell_precision(&PLAN, 2000, 1).unwrap();
        assert!(found.pooled_coverage_share < 0.88, "{found:?}");
        assert!(found.coverage_share > 0.91, "{found:?}");
        // Who do not differ are pooled rightly.
        let alike = cell_precision(
            &CellPlan {
                logit_sd: 0.0,
                ..PLAN
            },
            2000,
            1,
        )
        .unwrap();
        assert!(alike.pooled_coverage_share > 0.94, "{alike:?}");
        assert!(alike.half_width_share < found.half_width_share);
    }

    #[test]
    fn more_people_narrow_the_interval() {
        let of = |participants| {
            cell_precision(
                &CellPlan {
                    participants,
                    ..PLAN
                },
                500,
                1,
            )
            .unwrap()
            .half_width_share
        };
        let ratio = of(10) / of(40);
        // √(40/10), and the quantile of t: 2.26/2.02.
        assert!((1.9..2.5).contains(&ratio), "{ratio}");
    }

    /// Ratings of a scale of many steps are logit-normal; of one step they are a share, with p(1 − p) as variance.
    #[test]
    fn a_mean_rating_has_the_interval_of_its_spread() {
        let of = |people, range| rating_half_width(people, range, 0.5, 0.9).unwrap();
        // By SciPy: t.ppf(0.975, 9) = 2.262157; ratings of one step are 0 or 1, of variance 0.25.
        let one_step = 2.262_157 * 0.5 / 10_f64.sqrt();
        assert!((of(10, 1) - one_step).abs() < 1e-3, "{}", of(10, 1));
        // Rounding to steps of 1/6 adds about 1/12 of its square to the variance (Sheppard).
        let [fine, coarse] =
            [of(10, 1000), of(10, 6)].map(|half| (half / 2.262_157).powi(2) * 10.0);
        assert!(
            (coarse - fine - 1.0 / (12.0 * 36.0)).abs() < 5e-4,
            "{coarse}, {fine}"
        );
        assert!(of(40, 6) < of(10, 6) / 1.9);
        assert_eq!((of(1, 6), of(2, 6)), (0.5, 0.5));
        assert!(rating_half_width(10, 0, 0.5, 0.9).is_err());
        assert!(rating_half_width(10, 6, 1.0, 0.9).is_err());
    }

    #[test]
    fn bad_plans_are_refused() {
        for bad in [
            CellPlan {
                participants: 0,
                ..PLAN
            },
            CellPlan {
                presentations: 0,
                ..PLAN
            },
            CellPlan { share: 1.0, ..PLAN },
            CellPlan {
                share: f64::NAN,
                ..PLAN
            },
            CellPlan {
                logit_sd: -1.0,
                ..PLAN
            },
        ] {
            assert!(cell_precision(&bad, 500, 1).is_err(), "{bad:?}");
        }
        assert!(cell_precision(&PLAN, 10, 1).is_err());
    }
}
