//! How many people, repeats and sets find a stated difference in the campaigns of the thesis.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::design::{
    DesignError, FoundShare, PowerPlan, PowerQuestion, PowerStudy, found_share,
};
use piezotact_people::campaign::overview::campaign_design;
use piezotact_people::campaign::protocol::from_library;
use piezotact_people::difference::Difference;

fn two(a: &str, b: &str) -> [String; 2] {
    [a.into(), b.into()]
}

fn study(
    protocol: &str,
    difference: Difference,
    shares: [f64; 2],
    task: Option<&str>,
) -> Result<PowerStudy, DesignError> {
    let protocol = from_library(protocol).unwrap().unwrap();
    let design = campaign_design(&protocol, 1).unwrap();
    let question = PowerQuestion {
        difference,
        task: task.map(Into::into),
        shares,
        logit_sd: None,
    };
    Ok(design.with_power(&question)?.power.unwrap())
}

/// What is said to suffice does, and one less does not.
fn suffices(study: &PowerStudy) {
    let of = |participants: usize, times: usize| {
        let plan = PowerPlan {
            participants,
            presentations: study
                .presentations
                .map(|n| ((n * times as f64).round() as usize).max(1)),
            ..study.plan.clone()
        };
        found_share(&plan, 1000, 1).unwrap()
    };
    if let Some(needed) = study.participants_needed {
        assert!(of(needed, 1) >= study.wanted_share);
        assert!(of(needed - 1, 1) < study.wanted_share);
        // On other campaigns: within four standard deviations.
        let other = found_share(
            &PowerPlan {
                participants: needed,
                ..study.plan.clone()
            },
            1000,
            77,
        );
        assert!(other.unwrap() > study.wanted_share - 0.05);
    }
    if let Some(needed) = study.times_needed {
        assert!(of(study.plan.participants, needed) >= study.wanted_share);
    }
    assert!(study.without_difference_share < 0.07);
}

#[test]
fn two_samples_of_the_isotropic_campaign_need_more_sets() {
    let of = |a, b, shares| {
        study(
            "isotropic_triplets",
            Difference::Samples(two(a, b)),
            shares,
            None,
        )
    };
    // Both are in one of twelve sets, in which 3 to 4 stimuli of three are drawn.
    let found = of("S2", "S3", [0.75, 0.2]).unwrap();
    assert_eq!(found.sets, Some([1, 12]));
    for presentations in found.presentations {
        assert!((presentations - 3.5 / 3.0).abs() < 1e-12);
    }
    suffices(&found);
    assert!(found.planned.power_share < 0.8);
    assert!(found.times_needed.is_some_and(|times| times > 1));
    let sentences = found.sentences().join(" ");
    for words in [
        "in 1 of 12 sets",
        "by a permutation of participants at 5 %",
        "is wanted",
        "Needed:",
    ] {
        assert!(sentences.contains(words), "{words}: {sentences}");
    }
    // S2 and S4 are together twice.
    let twice = of("S2", "S4", [0.75, 0.2]).unwrap();
    assert_eq!(twice.sets, Some([2, 12]));
    assert!(twice.planned.power_share > found.planned.power_share);
    // Never together: no answer compares them.
    let never = of("S4", "S5", [0.75, 0.2]).unwrap_err();
    assert!(never.to_string().contains("which never are"), "{never}");
    for (a, b) in [("S2", "S2"), ("S2", "S99")] {
        assert!(of(a, b, [0.5, 0.3]).is_err());
    }
    assert!(of("S2", "S3", [0.8, 0.3]).is_err());
}

#[test]
fn two_tasks_of_chapter_six_and_two_groups_of_chapter_five() {
    let tasks = |a, b, shares| {
        study(
            "touch_control_imagery",
            Difference::Tasks(two(a, b)),
            shares,
            None,
        )
    };
    let found = tasks("control", "imagery", [0.5, 0.9]).unwrap();
    assert_eq!(found.presentations, [3.0, 3.0]);
    suffices(&found);
    assert!(tasks("control", "control", [0.5, 0.9]).is_err());
    let unknown = tasks("control", "nothing", [0.5, 0.9])
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("found `nothing`"), "{unknown}");
    let people = |task| {
        let own = Difference::People(two("own", "averaged"));
        study("averaged_transfer_function", own, [0.9, 0.7], task)
    };
    let found = people(Some("task3")).unwrap();
    assert_eq!(found.presentations, [42.0, 42.0]);
    suffices(&found);
    // Curves: as many rows for each number of times, rising with participants but for the noise of 400 campaigns.
    for curve in &found.curves {
        let shares: Vec<f64> = curve.iter().map(|point| point.found.power_share).collect();
        assert!(
            shares.windows(2).all(|pair| pair[1] > pair[0] - 0.08),
            "{shares:?}"
        );
        assert!(
            curve
                .windows(2)
                .all(|pair| pair[1].half_width_share < pair[0].half_width_share)
        );
    }
    let FoundShare {
        participants,
        times,
        ..
    } = found.curves[1][0].found;
    assert_eq!((participants, times), (4, 2));
    assert_eq!(found.table().rows.len(), found.curves[0].len());
}
