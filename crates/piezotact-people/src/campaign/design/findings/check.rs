//! The ranges of a campaign's numbers.

use super::super::description::CampaignDescription;
use super::super::error::{DesignError, above_0_below, must};

pub(super) fn check_numbers(campaign: &CampaignDescription) -> Result<(), DesignError> {
    let aims = &campaign.aims;
    let (power, half_width) = (aims.power_share, aims.half_width_share);
    must(
        "the wanted power",
        power,
        above_0_below(1.0),
        "above 0 and below 1",
    )?;
    let (what, range) = ("the wanted half-width", above_0_below(0.5));
    must(what, half_width, range, "above 0 and below 0.5")?;
    for task in &campaign.tasks {
        let (what, range) = ("the time of a trial in seconds", 0.0..f64::INFINITY);
        must(what, task.seconds_per_trial, range, "0 or more")?;
        let what = "the number of repeats of a task";
        must(what, task.repeats as f64, 1.0..=1000.0, "1 to 1000")?;
    }
    let what = "the number of participants who share the sets";
    let (shared, most) = (
        campaign.sets_shared_over as f64,
        campaign.sets.len().max(1) as f64,
    );
    must(what, shared, 1.0..=most, "1 up to the number of sets")?;
    for comparison in &campaign.comparisons {
        let (found, range) = (
            comparison.smallest_effect_ratio,
            above_0_below(f64::INFINITY),
        );
        must("the smallest effect", found, range, "above 0")?;
    }
    let (what, people) = ("the number of participants", campaign.participants as f64);
    must(what, people, 1.0.., "1 or more")
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
    let what = "the number of samples to order";
    must(what, samples as f64, 2.0..=100.0, "2 to 100")
}

pub(super) fn check_trials(alternatives: usize, trials: usize) -> Result<(), DesignError> {
    let what = "the number of possible answers";
    must(what, alternatives as f64, 2.0.., "2 or more")?;
    must(
        "the number of trials",
        trials as f64,
        1.0..=5000.0,
        "1 to 5000",
    )
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
