//! The ranges of a campaign's numbers.

use super::super::description::CampaignDescription;
use super::super::error::DesignError;

pub(super) fn check_numbers(campaign: &CampaignDescription) -> Result<(), DesignError> {
    let ranges = [
        ("the wanted power", campaign.aims.power_share, 0.0, 1.0),
        (
            "the wanted half-width",
            campaign.aims.half_width_share,
            0.0,
            0.5,
        ),
    ];
    for (what, found, low, high) in ranges {
        if !(found > low && found < high) {
            let expected = if high < 1.0 {
                "above 0 and below 0.5"
            } else {
                "above 0 and below 1"
            };
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected,
            });
        }
    }
    for task in &campaign.tasks {
        let found = task.seconds_per_trial;
        if !(found >= 0.0 && found.is_finite()) {
            let what = "the time of a trial in seconds";
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected: "0 or more",
            });
        }
        if (1..=1000).contains(&task.repeats) {
            continue;
        }
        let what = "the number of repeats of a task";
        let found = task.repeats as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "1 to 1000",
        });
    }
    let shared = campaign.sets_shared_over;
    if shared == 0 || (shared > campaign.sets.len() && shared > 1) {
        let what = "the number of participants who share the sets";
        let found = shared as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "1 up to the number of sets",
        });
    }
    for comparison in &campaign.comparisons {
        let found = comparison.smallest_effect_ratio;
        if !(found > 0.0 && found.is_finite()) {
            let what = "the smallest effect";
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected: "above 0",
            });
        }
    }
    if campaign.participants < 2 {
        let what = "the number of participants";
        let found = campaign.participants as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "2 or more",
        });
    }
    Ok(())
}

pub(super) fn check_order(samples: usize) -> Result<(), DesignError> {
    if (2..=100).contains(&samples) {
        return Ok(());
    }
    let found = samples as f64;
    Err(DesignError::OutOfRange {
        what: "the number of samples to order",
        found,
        expected: "2 to 100",
    })
}

pub(super) fn check_trials(alternatives: usize, trials: usize) -> Result<(), DesignError> {
    if alternatives >= 2 && (1..=5000).contains(&trials) {
        return Ok(());
    }
    let (what, found, expected) = if alternatives < 2 {
        (
            "the number of possible answers",
            alternatives as f64,
            "2 or more",
        )
    } else {
        ("the number of trials", trials as f64, "1 to 5000")
    };
    Err(DesignError::OutOfRange {
        what,
        found,
        expected,
    })
}
