//! Confidence intervals of shares of answers.

use piezotact::statistics::t_quantile;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

/// With fewer participants there is no interval: their differences cannot be estimated.
pub const MIN_PARTICIPANTS: usize = 3;
/// The intraclass correlation where answers do not say how participants differ: that of a standard deviation of 0.9 of the logit,
/// 0.9²/(0.9² + π²/3).
const ASSUMED_CORRELATION: f64 = 0.2;

/// The exact 95 % interval of a share of `successes` of `trials` independent trials, [low, high] from 0 to 1; the whole range
/// without a trial.
///
/// Source: C. J. Clopper and E. S. Pearson (1934), Biometrika 26; as SciPy's `binomtest(...).proportion_ci(method="exact")`.
///
/// ```
/// use piezotact_people::interval::clopper_pearson;
/// let [low, high] = clopper_pearson(7, 10);
/// assert!((low - 0.3475).abs() < 1e-4 && (high - 0.9333).abs() < 1e-4);
/// ```
#[must_use]
pub fn clopper_pearson(successes: usize, trials: usize) -> [f64; 2] {
    exact(successes as f64, trials as f64)
}

/// The same for numbers that need not be whole.
fn exact(successes: f64, trials: f64) -> [f64; 2] {
    if trials <= 0.0 {
        return [0.0, 1.0];
    }
    let quantile = |a: f64, b: f64, share: f64| Beta::new(a, b).ok().map(|d| d.inverse_cdf(share));
    let low = if successes <= 0.0 {
        Some(0.0)
    } else {
        quantile(successes, trials - successes + 1.0, 0.025)
    };
    let high = if successes >= trials {
        Some(1.0)
    } else {
        quantile(successes + 1.0, trials - successes, 0.975)
    };
    [low.unwrap_or(0.0), high.unwrap_or(1.0)]
}

/// A share over participants who answered several times, and the interval of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Clustered {
    /// The share of all answers, 0–1.
    pub share: f64,
    /// Its 95 % interval, 0–1; `None` for fewer than [`MIN_PARTICIPANTS`].
    pub interval: Option<[f64; 2]>,
    /// How many independent answers the answers are worth.
    pub effective: f64,
}

/// The share of (successes, trials) of each participant, with an interval that allows for participants who differ; `None` without
/// a trial.
///
/// Formula: the exact interval of p·n′ of n′ answers, where n′ = p(1 − p)/v · (t(N − 1)/t(k − 1))², at most N; v is the variance
/// of the ratio p of the sums over k participants, k/(k − 1)·Σ(xᵢ − p·nᵢ)²/N². Where fewer than [`MIN_PARTICIPANTS`] gave the rarer
/// answer, v says little about how people differ: n′ is at most N/(1 + (Σnᵢ²/N − 1)·0.2) then, for an intraclass correlation of
/// 0.2, as of a standard deviation of 0.9 of the logit.
///
/// Source: E. L. Korn and B. I. Graubard (1998), Survey Methodology 24, as R's `survey::svyciprop(method = "beta")`; docs/decisions/answers.md.
#[must_use]
pub fn clustered_interval(participants: &[(usize, usize)]) -> Option<Clustered> {
    let participants = participants.iter();
    clustered_of(participants.map(|(successes, trials)| (*successes as f64, *trials as f64)))
}

/// The same for numbers that need not be whole.
pub(crate) fn clustered_of(participants: impl Iterator<Item = (f64, f64)>) -> Option<Clustered> {
    let shown: Vec<(f64, f64)> = participants.filter(|(_, trials)| *trials > 0.0).collect();
    let k = shown.len();
    let trials: f64 = shown.iter().map(|(_, n)| n).sum();
    if k == 0 {
        return None;
    }
    let successes: f64 = shown.iter().map(|(x, _)| x).sum();
    let share = successes / trials;
    let squares: f64 = shown.iter().map(|(x, n)| (x - share * n).powi(2)).sum();
    let variance = k as f64 / (k as f64 - 1.0) * squares / (trials * trials);
    let ratio = match (
        t_quantile((trials.round() as usize).saturating_sub(1)),
        t_quantile(k - 1),
    ) {
        (Some(all), Some(people)) => (all / people).powi(2),
        _ => 1.0,
    };
    let worth = share * (1.0 - share) / variance * ratio;
    let rarer = |(x, n): &&(f64, f64)| if share <= 0.5 { *x > 0.0 } else { x < n };
    let most = if shown.iter().filter(rarer).count() < MIN_PARTICIPANTS {
        let mean = shown.iter().map(|(_, n)| n * n).sum::<f64>() / trials;
        trials / (1.0 + (mean - 1.0) * ASSUMED_CORRELATION)
    } else {
        trials
    };
    // Participants who all agree have no variance.
    let effective = if worth.is_nan() {
        most
    } else {
        worth.min(most)
    };
    let interval = (k >= MIN_PARTICIPANTS).then(|| exact(share * effective, effective));
    Some(Clustered {
        share,
        interval,
        effective,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    #[test]
    fn few_participants_have_no_interval() {
        assert_eq!(clustered_interval(&[]), None);
        assert_eq!(clustered_interval(&[(0, 0)]), None);
        for people in [vec![(3, 6)], vec![(12, 12), (5, 12)], vec![(0, 9), (0, 9)]] {
            let found = clustered_interval(&people).unwrap();
            assert_eq!(found.interval, None, "{people:?}");
        }
    }

    /// All answers right: a person asked more often says more, but less than another person.
    #[test]
    fn agreement_is_worth_more_than_people_and_less_than_answers() {
        let of = |repeats: usize| clustered_interval(&[(repeats, repeats); 10]).unwrap();
        assert_eq!(of(1).interval, Some(clopper_pearson(10, 10)));
        let found = of(12);
        assert!(
            (found.effective - 120.0 / 3.2).abs() < 1e-9,
            "{}",
            found.effective
        );
    }

    /// From the third person on who gave the rarer answer the differences are estimated, and the interval may be narrower.
    #[test]
    fn a_confusion_more_does_not_lower_the_upper_end_while_differences_are_assumed() {
        let high = |confused: usize| {
            let people = (0..10).map(|i| (usize::from(i < confused), 20));
            let found = clustered_interval(&people.collect::<Vec<_>>()).unwrap();
            found.interval.unwrap()[1]
        };
        assert!(high(0) < high(1) && high(1) < high(2));
    }

    /// How often the interval holds the true share, of `people` who answer `trials` times, with a standard deviation of the logit;
    /// and how often that of pooled answers does.
    fn coverage(people: usize, trials: usize, middle_logit: f64, spread_logit: f64) -> [f64; 2] {
        let right = |logit: f64| 1.0 / (1.0 + (-logit).exp());
        let mut random = Random::stream(64, people as u64, "truth");
        let truth = (0..200_000)
            .map(|_| right(middle_logit + spread_logit * random.normal()))
            .sum::<f64>()
            / 2e5;
        let mut random = Random::stream(64, people as u64, "coverage");
        let repeats = 2000;
        let (mut clustered, mut pooled) = (0, 0);
        for _ in 0..repeats {
            let answers: Vec<(usize, usize)> = (0..people)
                .map(|_| {
                    let p = right(middle_logit + spread_logit * random.normal());
                    let right = (0..trials).filter(|_| random.uniform() < p).count();
                    (right, trials)
                })
                .collect();
            let holds = |[low, high]: [f64; 2]| usize::from(low <= truth && truth <= high);
            let found = clustered_interval(&answers).unwrap();
            clustered += holds(found.interval.unwrap());
            let sum = answers.iter().map(|(right, _)| right).sum();
            pooled += holds(clopper_pearson(sum, people * trials));
        }
        [clustered, pooled].map(|count| f64::from(count as u32) / f64::from(repeats))
    }

    /// Row 3 of the statistics: 10 people × 12 trials, standard deviation 0.9 of the logit. The standard error of 2000 repeats is
    /// 0.5 % at 95 %; four of them are allowed.
    #[test]
    fn the_interval_covers_what_pooled_answers_do_not() {
        for (people, trials, middle, spread) in [
            (10, 12, 0.0, 0.9),
            (10, 12, 1.0, 0.9),
            (10, 12, 2.5, 0.9),
            (5, 8, 1.0, 0.9),
            (3, 8, 0.5, 0.9),
            (24, 6, -1.0, 0.9),
            (10, 12, 1.0, 0.0),
            (10, 12, -4.0, 0.9),
            (10, 3, -3.0, 0.9),
            (10, 3, -4.0, 2.0),
        ] {
            let [clustered, _] = coverage(people, trials, middle, spread);
            assert!(
                clustered > 0.93,
                "{people} × {trials} at {middle}: {clustered}"
            );
        }
        let [_, pooled] = coverage(10, 12, 0.0, 0.9);
        assert!(pooled < 0.83, "{pooled}");
    }
}
