//! The times of designs, what is judged, and what is said of it.

use super::super::protocol::{LIBRARY, from_library, read};
use super::*;

fn design(name: &str) -> CampaignDesign {
    campaign_design(&from_library(name).unwrap().unwrap(), 1).unwrap()
}

#[test]
fn the_time_of_every_session_is_counted() {
    let found = design("isotropic_triplets");
    let times: Vec<(&str, f64)> = (found.sessions.iter())
        .map(|session| (session.session.as_str(), session.time_s))
        .collect();
    // 14 samples of 180 s; three orders of 300 s, 12 sets of 90 s and of a sequence of 180 s beside 3.5 textures of 30 s on average:
    // 42 textures play for 21 min before anybody answers.
    let discrimination = 900.0 + 12.0 * (90.0 + 180.0) + 42.0 * 30.0;
    assert_eq!(
        times,
        [("measurement", 2520.0), ("discrimination", discrimination)]
    );
    assert!((found.report.participant_s - discrimination).abs() < 1e-9);
    assert_eq!(found.sessions[1].played_min(), 21.0);
    let imagery = design("touch_control_imagery");
    let all: f64 = imagery.sessions.iter().map(|session| session.time_s).sum();
    assert!((imagery.report.participant_s - all).abs() < 1e-9);
}

#[test]
fn a_task_in_two_blocks_takes_its_time_twice() {
    let (_, toml) = LIBRARY[1];
    let (before, block) = toml.rsplit_once("[[sessions.blocks]]").unwrap();
    let again = block.replacen("triplets", "again", 1);
    let twice = format!("{before}[[sessions.blocks]]{block}\n[[sessions.blocks]]{again}");
    let found = campaign_design(&read(&twice).unwrap(), 1).unwrap();
    assert_eq!(found.sessions[1].tasks.len(), 5);
    assert!((found.sessions[1].time_s - (900.0 + 2.0 * 4500.0)).abs() < 1e-9);
    // Not the 90 min of the source any more, and no reason is stated.
    let said = found.time_sentence();
    assert!(
        said.ends_with("for discrimination, not 165. The protocol does not say why."),
        "{said}"
    );
}

/// The thesis has 60 and 90 min (2.6.2).
#[test]
fn the_time_of_the_source_is_kept_or_it_is_said_why_not() {
    for name in ["isotropic_triplets", "averaged_transfer_function"] {
        let said = design(name).time_sentence();
        for part in [
            "discrimination 90 min (21.0 min of it textures play)",
            "The source has 60 min for measurement, not 42. ",
            "transfer function",
            "The source has 90 min for discrimination: as here.",
        ] {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
    assert!(
        !design("amplitude_inversion")
            .time_sentence()
            .contains("The source has")
    );
}

/// Whoever compares pairs whose textures are repeated hears each in full, in training and catch trials too.
#[test]
fn playing_is_counted_in_comparisons_with_training_and_catch_trials() {
    let (_, toml) = (LIBRARY.iter())
        .find(|(name, _)| *name == "roughness_jnd")
        .unwrap();
    let repeated = toml.replacen(
        "playing = { how = \"once\" }",
        "playing = { how = \"repeated\", pause_s = 0.5, duration_s = 10 }",
        1,
    );
    let of = |toml: &str| campaign_design(&read(toml).unwrap(), 1).unwrap().sessions[0].clone();
    let [once, repeated] = [of(toml), of(&repeated)];
    assert_eq!(once.played_min(), 0.0);
    // 50 and 90 trials, each with 6 of training and 5 of known answers, of 20 s more.
    assert!((repeated.time_s - once.time_s - 20.0 * f64::from(50 + 90 + 22)).abs() < 1e-6);
    assert!((repeated.played_min() * 60.0 - 20.0 * f64::from(50 + 90 + 22)).abs() < 1e-6);
}

/// The pilot of the thesis (4.3.1) is one man: nothing over people can be shown, and that is a fault.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_one_participant_shows_no_spread() {
    let found = design("periodic_pilot");
    assert_eq!(found.campaign.participants, 1);
    assert_eq!(found.outcome(), Outcome::NotMet);
    let wide = (found.report.faults.iter())
        .filter(|one| matches!(one.fault, Fault::IntervalTooWide { .. }));
    assert_eq!(wide.count(), 2);
    let sentences = found.precision_sentences().join(" ");
    assert!(
        sentences.contains("±50 percentage points with 1 participant "),
        "{sentences}"
    );
    let question = PowerQuestion {
        difference: "tasks:task1,task2".parse().unwrap(),
        task: None,
        shares: [0.9, 0.5],
        logit_sd: None,
    };
    let power = found.with_power(&question).unwrap().power.unwrap();
    assert_eq!((power.planned.power_share, power.smallest_p), (0.0, 1.0));
}

#[test]
fn comparisons_ratings_and_categories_are_judged() {
    let jnd = design("roughness_jnd");
    let decided: Vec<f64> = (jnd.report.thresholds.iter())
        .map(|of| of.decided_share)
        .collect();
    assert_eq!(decided.len(), 2);
    let judged = (jnd.report.criteria.iter())
        .filter(|one| matches!(one.what, DesignCriterion::ThresholdsDecided { .. }));
    assert_eq!(judged.count(), 2);
    // With fewer trials than a threshold takes.
    let (_, toml) = (LIBRARY.iter())
        .find(|(name, _)| *name == "roughness_jnd")
        .unwrap();
    let short = toml.replacen("trials = 50", "trials = 8", 1);
    let short = campaign_design(&read(&short).unwrap(), 1).unwrap();
    assert!(short.report.thresholds[0].decided_share < decided[0]);
    let open = (short.report.faults.iter()).any(
        |one| matches!(&one.fault, Fault::ThresholdsOpen { task, trials: 8, .. } if task == "quest"),
    );
    assert!(open, "{}", short.sentence());
    // Ratings of few people are too wide.
    let ratings = |participants| {
        let mut protocol = from_library("touch_control_imagery").unwrap().unwrap();
        protocol.panel.participants = participants;
        let found = campaign_design(&protocol, 1).unwrap();
        let wide = (found.report.faults.iter())
            .any(|one| matches!(one.fault, Fault::RatingTooWide { .. }));
        (found.report.ratings[0].half_width_share, wide)
    };
    let [(few, few_wide), (planned, planned_wide)] = [ratings(3), ratings(10)];
    assert!(
        few_wide && !planned_wide && planned < few / 2.0,
        "{few}, {planned}"
    );
}

/// 37 % where 80 % is wanted, and everything else is met.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_no_fault_is_not_said_of_a_power_below_what_is_wanted() {
    let mut protocol = from_library("periodic_pilot").unwrap().unwrap();
    protocol.panel.participants = 40;
    let question = |a, b| PowerQuestion {
        difference: "samples:M1,M8".parse().unwrap(),
        task: Some("task2".to_owned()),
        shares: [a, b],
        logit_sd: None,
    };
    let plain = campaign_design(&protocol, 1).unwrap();
    assert!(
        plain.sentence().starts_with("No fault was found"),
        "{}",
        plain.sentence()
    );
    let low = plain.clone().with_power(&question(0.5, 0.35)).unwrap();
    let power = low.power.as_ref().unwrap();
    assert!((0.2..0.6).contains(&power.planned.power_share), "{power:?}");
    assert_eq!(low.outcome(), Outcome::NotMet);
    assert!(
        low.sentence().starts_with("1 fault found"),
        "{}",
        low.sentence()
    );
    let better = low.report.faults[0].better.as_ref().unwrap();
    assert_eq!(Some(better.participants[1]), power.participants_needed);
    let high = plain.with_power(&question(0.8, 0.1)).unwrap();
    assert_eq!(high.outcome(), Outcome::Met);
    assert!(high.sentence().starts_with("No fault was found"));
}

#[test]
fn no_fault_is_said_only_where_a_rule_was_judged() {
    let mut found = design("periodic_pilot");
    assert_eq!(found.outcome(), Outcome::NotMet);
    found.report.faults.clear();
    found.report.criteria.retain(|c| c.outcome == Outcome::Met);
    assert_eq!(found.outcome(), Outcome::Met);
    assert!(found.sentence().starts_with("No fault was found: "));
    found.report.criteria[0].outcome = Outcome::NotDecided;
    assert_eq!(found.outcome(), Outcome::NotDecided);
    let said = found.sentence();
    assert!(
        said.contains("; 1 not decided: pairs together in a set ("),
        "{said}"
    );
    found.report.criteria.clear();
    assert_eq!(found.outcome(), Outcome::NotDecided);
    assert!(found.sentence().contains("nothing was judged"));
}

#[test]
fn pairs_never_together_are_listed_from_both_sides() {
    let table = design("isotropic_triplets").pairs_table().unwrap();
    let never: usize = (table.rows.iter())
        .map(|row| row[2].text().split_whitespace().count())
        .sum();
    assert_eq!((table.rows.len(), never), (13, 2 * 47));
}
