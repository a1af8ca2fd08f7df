//! How many people, repeats and sets find a stated difference in the campaigns of the thesis.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{Answer, AnswerTable, Declared, MatrixConfig, compared};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::design::{
    DesignError, FoundShare, PowerPlan, PowerQuestion, PowerStudy, found_share,
};
use piezotact_people::campaign::overview::campaign_design;
use piezotact_people::campaign::plan::{PlanRequest, plan};
use piezotact_people::campaign::protocol::{TaskKind, from_library};
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

/// What is said to suffice does by campaigns of other seeds, up to four standard deviations of 1000; half as many do not.
fn suffices(study: &PowerStudy, presentations: [usize; 2]) {
    let of = |participants: usize, times: usize| {
        let plan = PowerPlan {
            difference: study.question.difference.clone(),
            participants,
            presentations: vec![presentations.map(|n| n * times)],
            shares: study.question.shares,
            logit_sd: study.logit_sd,
        };
        found_share(&plan, 1000, 77).unwrap()
    };
    let near = 4.0 * (0.16_f64 / 1000.0).sqrt();
    if let Some(needed) = study.participants_needed {
        assert!(of(needed, 1) >= study.wanted_share - near);
        assert!(of((needed / 2).max(2), 1) < study.wanted_share);
    }
    if let Some(needed) = study.times_needed {
        assert!(of(study.planned.participants, needed) >= study.wanted_share - near);
    }
    assert!(study.without_difference_share < 0.07);
}

/// Campaigns of `participants` as `protocol` plans them, with people as [`PowerPlan`] describes them, read by the comparison of answers.
fn by_answers(participants: usize, campaigns: u64, shares: [f64; 2]) -> f64 {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let session = "discrimination";
    let difference = Difference::Samples(two("S2", "S3"));
    let both = ["S2", "S3"].map(str::to_owned);
    let mut found = 0;
    for campaign in 0..campaigns {
        let mut random = Random::stream(campaign, 0, "answers");
        let mut completed = Vec::new();
        let mut answers = Vec::new();
        for person in 0..participants {
            let participant = format!("P{person:03}");
            let request = PlanRequest {
                seed: campaign,
                participant: &participant,
                session,
                completed: &completed,
            };
            let planned = plan(&protocol, Sha::of(b"protocol"), request).unwrap();
            let z = 0.9 * random.normal();
            let [right, other] = shares;
            let own = 1.0 / (1.0 + (-(right / (1.0 - right)).ln() - z).exp());
            let other = (1.0 - own) * other / (1.0 - right);
            let associated = |task: &String| {
                let kind = protocol.task(task).map(|task| &task.kind);
                matches!(
                    kind,
                    Some(TaskKind::Associate { .. } | TaskKind::Identify { .. })
                )
            };
            for trial in planned.trials.iter().filter(|one| associated(&one.task)) {
                let set = protocol
                    .sets
                    .iter()
                    .find(|set| Some(&set.name) == trial.set.as_ref());
                let offered = set.unwrap().samples.clone();
                if !both.iter().all(|sample| offered.contains(sample)) {
                    continue;
                }
                for (i, presented) in trial.presented.names().iter().enumerate() {
                    if !both.contains(presented) {
                        continue;
                    }
                    let swapped = both.iter().find(|sample| *sample != presented).unwrap();
                    let third = offered
                        .iter()
                        .find(|sample| !both.contains(sample))
                        .unwrap();
                    let answered = match random.uniform() {
                        u if u < own => presented,
                        u if u < own + other => swapped,
                        _ => third,
                    };
                    answers.push(Answer {
                        participant: participant.clone(),
                        session: session.into(),
                        task: trial.task.clone(),
                        trial: trial.name.clone(),
                        presented: presented.clone(),
                        answered: answered.clone(),
                        position: Some(i + 1),
                        offered: offered.clone(),
                        ..Answer::default()
                    });
                }
            }
            completed.push(planned.as_completed());
        }
        let samples: Vec<&str> = protocol.samples.iter().map(String::as_str).collect();
        let table = AnswerTable::new(Declared::plain(&samples), answers).unwrap();
        let one = compared(&table, &MatrixConfig::default(), &difference);
        found +=
            u64::from(one.is_ok_and(|one| one.outcome() == Outcome::Met && one.less_share > 0.0));
    }
    found as f64 / campaigns as f64
}

/// Sequences are drawn: nearly half of the participants meet one of the two only, whom the comparison of answers leaves out.
#[test]
#[ignore = "many campaigns: ./x soak runs it"]
fn soak_the_power_of_drawn_sequences_is_that_of_their_answers() {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    for (participants, campaigns) in [(10, 100), (20, 100)] {
        let mut design = campaign_design(&protocol, 1).unwrap();
        design.campaign.participants = participants;
        let question = PowerQuestion {
            difference: Difference::Samples(two("S2", "S3")),
            task: None,
            shares: [0.75, 0.2],
            logit_sd: Some(0.9),
        };
        let study = design.with_power(&question).unwrap().power.unwrap();
        assert!((study.one_only_share - 0.44).abs() < 0.05);
        let answered = by_answers(participants, campaigns, [0.75, 0.2]);
        let said = study.planned.power_share;
        let sd = (answered.max(0.05) * (1.0 - answered.min(0.95)) / campaigns as f64).sqrt();
        assert!(
            (answered - said).abs() < 3.5 * sd,
            "{participants}: {answered}, {said}"
        );
    }
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
    assert!(
        never.to_string().contains("never occur in one set"),
        "{never}"
    );
    for (a, b) in [("S2", "S2"), ("S2", "S99")] {
        assert!(of(a, b, [0.5, 0.3]).is_err());
    }
    assert!(of("S2", "S3", [0.8, 0.3]).is_err());
    let same = of("S2", "S3", [0.4, 0.4]).unwrap_err();
    assert!(
        same.to_string().contains("two shares that differ"),
        "{same}"
    );
}

/// Where people do not reach 5 % however they answer, nothing is said of repeats; and nothing of people who differ, where they do not.
#[test]
#[ignore = "many campaigns: ./x soak runs it"]
fn soak_why_more_presentations_do_not_suffice_is_the_reason() {
    let protocol = from_library("averaged_transfer_function").unwrap().unwrap();
    let of = |participants, logit_sd, shares| {
        let mut design = campaign_design(&protocol, 1).unwrap();
        design.campaign.participants = participants;
        let question = PowerQuestion {
            difference: Difference::Again(two("own", "averaged")),
            task: Some("task3".into()),
            shares,
            logit_sd: Some(logit_sd),
        };
        design.with_power(&question).unwrap().power.unwrap()
    };
    let few = of(5, 0.5, [0.9, 0.3]);
    assert_eq!((few.planned.power_share, few.times_needed), (0.0, None));
    let said = few.sentences().join(" ");
    assert!(
        said.contains("with 5 participants no test of people reaches 5 %, however often each answers: the smallest p is 0.062"),
        "{said}"
    );
    let alike = of(6, 0.0, [0.505, 0.5]);
    let said = alike.sentences().join(" ");
    assert!(
        said.contains("do not suffice with 6 participants."),
        "{said}"
    );
    let enough = of(20, 0.2, [0.9, 0.5]);
    let said = enough.sentences().join(" ");
    assert!(
        said.contains("20 participants have presentations enough"),
        "{said}"
    );
    assert!(enough.planned.power_share > 0.95);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_two_tasks_of_chapter_six_and_two_groups_of_chapter_five() {
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
    suffices(&found, [3, 3]);
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
    for presentations in found.presentations {
        assert!((presentations - 42.0).abs() < 1e-9);
    }
    suffices(&found, [42, 42]);
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
