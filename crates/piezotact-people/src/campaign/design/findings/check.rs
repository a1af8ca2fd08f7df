//! The ranges of a campaign's numbers.

use super::super::description::CampaignDescription;
use super::super::error::{DesignError, must};

pub(super) fn check_numbers(campaign: &CampaignDescription) -> Result<(), DesignError> {
    let aims = &campaign.aims;
    let share = |what, found: f64, below: f64, expected| {
        must(found > 0.0 && found < below, what, found, expected)
    };
    share(
        "the wanted power",
        aims.power_share,
        1.0,
        "above 0 and below 1",
    )?;
    let half_width = aims.half_width_share;
    share(
        "the wanted half-width",
        half_width,
        0.5,
        "above 0 and below 0.5",
    )?;
    for task in &campaign.tasks {
        let found = task.seconds_per_trial;
        let fits = found >= 0.0 && found.is_finite();
        must(fits, "the time of a trial in seconds", found, "0 or more")?;
        let fits = (1..=1000).contains(&task.repeats);
        let what = "the number of repeats of a task";
        must(fits, what, task.repeats as f64, "1 to 1000")?;
    }
    let shared = campaign.sets_shared_over;
    let fits = (1..=campaign.sets.len().max(1)).contains(&shared);
    let what = "the number of participants who share the sets";
    must(fits, what, shared as f64, "1 up to the number of sets")?;
    for comparison in &campaign.comparisons {
        let found = comparison.smallest_effect_ratio;
        let fits = found > 0.0 && found.is_finite();
        must(fits, "the smallest effect", found, "above 0")?;
    }
    let is_one = campaign.participants > 0;
    must(is_one, "the number of participants", 0.0, "1 or more")
}

/// The most answers of one participant to one task: the distribution of those that are right by chance takes the square of it.
const MOST_ANSWERS: usize = 20_000;
/// The most samples of which every pair is looked at.
const MOST_IN_PAIRS: usize = 500;
/// The most pairs that stand in the sets, each counted as often as it does.
const MOST_PAIRS: usize = 20_000_000;

/// Refuses sets that have too many pairs, before any is counted.
pub(super) fn check_pairs(campaign: &CampaignDescription) -> Result<(), DesignError> {
    if campaign.sets.is_empty() {
        return Ok(());
    }
    let pairs = campaign.sets.iter().map(|set| {
        let others = set.len().saturating_sub(1);
        set.len().saturating_mul(others) / 2
    });
    let found = pairs.fold(0, usize::saturating_add);
    let samples = campaign.samples.len();
    at_most("samples in sets", samples, MOST_IN_PAIRS)?;
    at_most("pairs of samples in all sets", found, MOST_PAIRS)
}

/// Refuses more answers than chance is enumerated for.
pub(super) fn check_answers(once: usize, repeats: usize) -> Result<(), DesignError> {
    let what = "answers of one participant to one task";
    at_most(what, once.saturating_mul(repeats), MOST_ANSWERS)
}

fn at_most(what: &'static str, found: usize, most: usize) -> Result<(), DesignError> {
    match found <= most {
        true => Ok(()),
        false => Err(DesignError::TooLarge { what, found, most }),
    }
}

pub(super) fn check_order(samples: usize) -> Result<(), DesignError> {
    let (fits, what) = (
        (2..=100).contains(&samples),
        "the number of samples to order",
    );
    must(fits, what, samples as f64, "2 to 100")
}

pub(super) fn check_trials(alternatives: usize, trials: usize) -> Result<(), DesignError> {
    let (what, found) = ("the number of possible answers", alternatives as f64);
    must(alternatives >= 2, what, found, "2 or more")?;
    let (fits, what) = ((1..=5000).contains(&trials), "the number of trials");
    must(fits, what, trials as f64, "1 to 5000")
}

#[cfg(test)]
mod tests {
    use super::super::super::super::describe::describe;
    use super::super::super::super::protocol::from_library;
    use super::*;

    #[test]
    fn a_design_is_counted_before_anything_is_enumerated() {
        let protocol = from_library("isotropic_triplets").unwrap().unwrap();
        let mut campaign = describe(&protocol);
        assert_eq!(check_pairs(&campaign), Ok(()));
        campaign.samples = (0..501).map(|i| format!("S{i}")).collect();
        let (found, most) = (501, MOST_IN_PAIRS);
        let what = "samples in sets";
        assert_eq!(
            check_pairs(&campaign),
            Err(DesignError::TooLarge { what, found, most })
        );
        assert_eq!(check_answers(20, 1000), Ok(()));
        let refused = check_answers(usize::MAX, 2).unwrap_err().to_string();
        assert!(
            refused.contains("to one task: expected at most 20000, found"),
            "{refused}"
        );
    }
}
