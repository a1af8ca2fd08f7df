use piezotact::criterion::Outcome;
use piezotact::figure::{Drawn, Figure};
use piezotact::page::Block;

use super::super::super::adaptive::{GUESS_SHARE, ThresholdEstimate, weibull};
use super::super::super::plan::TrialKind;
use super::super::super::protocol::{Adaptive, Method, TaskKind};
use super::*;
use crate::association::session_page;

/// An observer: its threshold, in dB of the increment, and the numbers that decide its answers (`SplitMix64`).
struct Observer {
    threshold_db: f64,
    state: u64,
}

impl Observer {
    /// Thresholds from -16 to -6 dB: amplitudes 1.16 to 1.5 times as high, 1.3 to 3.5 dB.
    fn new(index: u64) -> Self {
        let mut observer = Self {
            threshold_db: 0.0,
            state: index + 1,
        };
        observer.threshold_db = -16.0 + 10.0 * observer.uniform();
        observer
    }

    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Which of the two stimuli is said to be stronger.
    fn says(&mut self, adaptive: &Adaptive, presented: &[String]) -> &'static str {
        let level_db = |stimulus: &String| {
            let mut levels = adaptive.levels.iter();
            levels.find(|level| level.stimulus == *stimulus)
        };
        let (right, wrong, level) = match (level_db(&presented[0]), level_db(&presented[1])) {
            (Some(level), None) => ("first", "second", level.level),
            (None, Some(level)) => ("second", "first", level.level),
            other => panic!("{presented:?} {other:?}"),
        };
        match self.uniform() < weibull(level, self.threshold_db, SLOPE, GUESS_SHARE, 0.02) {
            true => right,
            false => wrong,
        }
    }
}

const SLOPE: f64 = 2.0;

fn jnd() -> (Protocol, Plan) {
    let protocol = from_library("roughness_jnd").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    (protocol, plan)
}

fn adaptive<'a>(protocol: &'a Protocol, task: &str) -> &'a Adaptive {
    match &protocol.task(task).unwrap().kind {
        TaskKind::Compare {
            method: Method::Adaptive(adaptive),
            ..
        } => adaptive,
        other => panic!("{other:?}"),
    }
}

/// A session to its end, in which `says` answers; replayed from its journal after each event where `run` does that.
fn whole(run: &mut Run<'_>, mut says: impl FnMut(&Adaptive, &[String]) -> &'static str) {
    while let Some((trial, _)) = run.state.current() {
        let rule = adaptive(run.state.protocol, &trial.task);
        let word = says(rule, &run.state.presented(trial));
        run.present();
        run.answers(word).unwrap();
        run.does(Command::Confirm);
    }
}

/// The same without replays, for many observers.
fn fast<'a>(
    protocol: &'a Protocol,
    plan: &'a Plan,
    mut says: impl FnMut(&Adaptive, &[String]) -> &'static str,
) -> State<'a> {
    let mut state = State::new(protocol, plan);
    let does = |state: &mut State<'a>, command: Command| {
        let event = state.decide(&command).unwrap();
        state.apply(0, &event).unwrap();
    };
    let (experimenter, program) = ("EX".to_owned(), "p".to_owned());
    does(
        &mut state,
        Command::Begin {
            experimenter,
            program,
            purpose: Purpose::Volunteer,
            participant: Participant::default(),
        },
    );
    does(&mut state, Command::Consent { text: Sha::of(b"") });
    while let Some((trial, _)) = state.current() {
        let word = says(adaptive(protocol, &trial.task), &state.presented(trial));
        while let Step::Check { .. } = state.step() {
            does(&mut state, Command::Check);
        }
        does(&mut state, present());
        let words = vec![word.to_owned()];
        does(&mut state, Command::Answer { words });
        does(&mut state, Command::Confirm);
    }
    state
}

fn threshold(state: &State<'_>, task: &str) -> ThresholdEstimate {
    let mut all = state.thresholds(task);
    assert_eq!(all.len(), 1);
    all.remove(0).estimate
}

#[test]
fn an_adaptive_session_is_the_same_from_its_journal_at_every_step() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    let mut observer = Observer::new(3);
    whole(&mut run, |rule, presented| observer.says(rule, presented));
    assert_eq!(run.state.step(), Step::End);
    for task in ["quest", "staircase"] {
        let found = threshold(&run.state, task);
        assert_eq!(found.decided(), Outcome::Met, "{found:?}");
        let error = found.level.unwrap() - observer.threshold_db;
        assert!(error.abs() < 6.0, "{task}: {error}");
        // What was presented stands in the events, also where the plan left it open.
        let of_task = run.state.trials().filter(|(trial, _)| trial.task == task);
        let chosen = of_task.filter(|(trial, state)| {
            state.confirmed && matches!(trial.presented, Presented::Chosen { .. })
        });
        for (trial, state) in chosen {
            assert_eq!(state.chosen.as_deref(), state.presented());
            assert_eq!(run.state.presented(trial).len(), 2);
        }
    }
    // The staircase ended before its last trial; no catch trial is left behind it.
    let left: Vec<_> = run
        .state
        .trials()
        .filter(|(_, state)| !state.confirmed)
        .collect();
    assert!(!left.is_empty());
    for (trial, state) in left {
        assert_eq!((trial.task.as_str(), state.attempts), ("staircase", 0));
        assert_eq!(state.answer(), None);
    }
    let (confirmed, planned) = run.state.progress()["staircase"];
    assert_eq!(confirmed, planned);
    assert!(run.state.warnings().iter().all(is_under_way));
    for (_, event) in &run.events {
        let json = serde_json::to_string(event).unwrap();
        assert_eq!(serde_json::from_str::<Event>(&json).unwrap(), *event);
    }
    let read: Plan = serde_json::from_slice(&plan.bytes()).unwrap();
    assert_eq!((read.sha(), &read), (plan.sha(), &plan));
}

#[test]
fn thresholds_of_simulated_observers_are_recovered() {
    let (protocol, plan) = jnd();
    let mut errors: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut decided: BTreeMap<&str, u32> = BTreeMap::new();
    let mut within = 0;
    for index in 0..200 {
        let mut observer = Observer::new(index);
        let state = fast(&protocol, &plan, |rule, presented| {
            observer.says(rule, presented)
        });
        let mut shown = figures_with_a_threshold(&state);
        for task in ["quest", "staircase"] {
            let found = threshold(&state, task);
            shown -= i32::from(found.decided() == Outcome::Met);
            // The level of 79.4 % right answers lies below the Weibull threshold of 80.3 %.
            let error = found.level.unwrap() - observer.threshold_db;
            if task == "quest" {
                within += u32::from(error.abs() <= 1.96 * found.posterior_sd.unwrap());
            }
            errors.entry(task).or_default().push(error);
            *decided.entry(task).or_default() += u32::from(found.decided() == Outcome::Met);
        }
        assert_eq!(shown, 0);
    }
    for (task, errors) in &errors {
        let count = errors.len() as f64;
        let bias = errors.iter().sum::<f64>() / count;
        let squares: f64 = errors.iter().map(|error| (error - bias).powi(2)).sum();
        let sd = (squares / (count - 1.0)).sqrt();
        assert!(bias.abs() < 0.5 * sd, "{task}: bias {bias} spread {sd}");
        assert!(sd < 3.5, "{task}: spread {sd}");
        assert!(decided[task] >= 160, "{task}: {} decided", decided[task]);
    }
    assert!(within >= 180, "{within}");
}

/// How many figures of the report of the session draw a threshold, of two that have right and wrong answers.
fn figures_with_a_threshold(state: &State<'_>) -> i32 {
    let page = session_page(state, &[]);
    let blocks = page.sections.iter().flat_map(|section| &section.blocks);
    let labels = blocks.filter_map(|block| match block {
        Block::Figure(Figure {
            drawn: Drawn::Chart(chart),
            ..
        }) => {
            let labels = chart.lines.iter().map(|line| line.label.as_str());
            Some(labels.collect::<Vec<_>>())
        }
        _ => None,
    });
    let labels: Vec<Vec<&str>> = labels.collect();
    assert_eq!(labels.len(), 2);
    assert!(labels.iter().all(|of| of[1..3] == ["right", "wrong"]));
    labels.iter().filter(|of| of.contains(&"threshold")).count() as i32
}

#[test]
fn an_observer_who_answers_at_random_is_not_decided() {
    let (protocol, plan) = jnd();
    let mut decided: BTreeMap<&str, u32> = BTreeMap::new();
    let mut warnings = 0;
    for index in 0..200 {
        let mut observer = Observer::new(index + 1000);
        let state = fast(&protocol, &plan, |_, _| match observer.uniform() < 0.5 {
            true => "first",
            false => "second",
        });
        let mut shown = figures_with_a_threshold(&state);
        for task in ["quest", "staircase"] {
            let found = threshold(&state, task).decided();
            *decided.entry(task).or_default() += u32::from(found == Outcome::Met);
            shown -= i32::from(found == Outcome::Met);
        }
        assert_eq!(shown, 0, "a report shows a threshold that is not decided");
        warnings += u32::from(!state.warnings().is_empty());
    }
    assert!(decided.values().all(|count| *count <= 4), "{decided:?}");
    // Five trials with one wrong answer allowed are passed by 6/32 of those who guess, two tasks by 3.5 %.
    assert!(warnings >= 180, "{warnings}");
}

#[test]
fn too_few_reversals_or_an_outer_threshold_decide_nothing() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    for task in ["quest", "staircase"] {
        let none = threshold(&run.state, task);
        assert_eq!((none.decided(), none.answers), (Outcome::NotDecided, 0));
    }
    let mut observer = Observer::new(1);
    for _ in 0..25 {
        let (trial, _) = run.state.current().unwrap();
        let rule = adaptive(&protocol, &trial.task);
        let word = observer.says(rule, &run.state.presented(trial));
        run.present();
        run.answers(word).unwrap();
        run.does(Command::Confirm);
    }
    let task = run.state.current().unwrap().0.task.clone();
    assert_eq!(
        threshold(&run.state, &task).decided(),
        Outcome::NotDecided,
        "half of a run"
    );
    // Someone who always feels the difference: the threshold is below all levels.
    let mut keen = Observer::new(2);
    keen.threshold_db = -60.0;
    let state = fast(&protocol, &plan, |rule, presented| {
        keen.says(rule, presented)
    });
    for task in ["quest", "staircase"] {
        assert_eq!(
            threshold(&state, task).decided(),
            Outcome::NotDecided,
            "{task}"
        );
    }
}

#[test]
fn a_correction_changes_the_estimate_and_nothing_that_was_presented() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    let mut observer = Observer::new(5);
    let mut corrected = None;
    let mut count = 0;
    while let Some((trial, _)) = run.state.current() {
        let rule = adaptive(&protocol, &trial.task);
        let word = observer.says(rule, &run.state.presented(trial));
        run.present();
        run.answers(word).unwrap();
        run.does(Command::Confirm);
        count += 1;
        if count == 30 && corrected.is_none() {
            let shown = |run: &Run<'_>| -> Vec<Option<Vec<String>>> {
                run.state
                    .trials
                    .iter()
                    .map(|state| state.chosen.clone())
                    .collect()
            };
            let before = (shown(&run), run.state.thresholds(&trial.task));
            let (first, state) = run
                .state
                .trials()
                .find(|(trial, state)| {
                    matches!(trial.presented, Presented::Chosen { .. }) && state.confirmed
                })
                .unwrap();
            let other = match state.answer().unwrap() {
                Answer::Names(said) if said[0] == "first" => "second",
                _ => "first",
            };
            corrected = Some(first.name.clone());
            run.does(Command::Correct {
                trial: first.name.clone(),
                words: vec![other.to_owned()],
                why: "typed wrongly".to_owned(),
            });
            assert_eq!(shown(&run), before.0);
            assert_ne!(run.state.thresholds(&trial.task), before.1);
        }
    }
    assert!(corrected.is_some());
    run.does(Command::End);
}

#[test]
fn a_correction_does_not_open_a_run_again_behind_a_later_task() {
    // Of a staircase, as QUEST+ always has all its trials, and in a session where it comes first.
    let (_, toml) = LIBRARY[5];
    let listed = toml.replace("task_order = \"balanced\"", "task_order = \"as_listed\"");
    let staircase_first =
        listed.replace("[\"quest\", \"staircase\"]", "[\"staircase\", \"quest\"]");
    let protocol = read(&staircase_first).unwrap();
    let plan = planned(&protocol, "discrimination");
    let mut run = Run::begun(&protocol, &plan);
    let mut observer = Observer::new(8);
    whole(&mut run, |rule, presented| observer.says(rule, presented));
    assert_eq!(run.state.step(), Step::End);
    let counted: Vec<String> = run
        .state
        .trials()
        .filter(|(trial, state)| {
            trial.task == "staircase" && trial.kind.is_counted() && state.confirmed
        })
        .map(|(trial, _)| trial.name.clone())
        .collect();
    let mut opened = false;
    for name in counted.iter().rev().take(12) {
        run.does(Command::Correct {
            trial: name.clone(),
            words: vec!["first".to_owned()],
            why: "typed wrongly".to_owned(),
        });
        opened |= run.state.runs["thresholds.staircase"].next.is_some();
        assert_eq!(run.state.step(), Step::End);
    }
    assert!(
        opened,
        "no correction left the staircase without its reversals"
    );
    assert_eq!(
        threshold(&run.state, "staircase").decided(),
        Outcome::NotDecided
    );
}

#[test]
fn other_stimuli_than_chosen_count_as_what_they_were() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    while !run.state.current().unwrap().0.kind.is_counted() {
        run.trial();
    }
    while let Step::Check { .. } = run.state.step() {
        run.does(Command::Check);
    }
    assert!(
        run.tries(Command::PresentInstead {
            names: vec!["S8".to_owned()],
            evidence: Vec::new(),
        })
        .is_err()
    );
    // Twice the standard: there is no right answer, and the run takes nothing up.
    let twice = vec!["S8".to_owned(), "S8".to_owned()];
    run.does(Command::PresentInstead {
        names: twice,
        evidence: Vec::new(),
    });
    run.answers("first").unwrap();
    run.does(Command::Confirm);
    let task = run.state.current().unwrap().0.task.clone();
    assert_eq!(threshold(&run.state, &task).answers, 0);
    while !run.state.current().unwrap().0.kind.is_counted() {
        run.trial();
    }
    let other = vec!["S8 increment -6".to_owned(), "S8".to_owned()];
    while let Step::Check { .. } = run.state.step() {
        run.does(Command::Check);
    }
    run.does(Command::PresentInstead {
        names: other,
        evidence: Vec::new(),
    });
    run.answers("first").unwrap();
    run.does(Command::Confirm);
    assert_eq!(threshold(&run.state, &task).answers, 1);
}

#[test]
fn feedback_follows_training_alone_and_catch_failures_raise_a_warning() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    let trial = &plan.trials[0];
    assert!(matches!(trial.kind, TrialKind::Training { .. }));
    assert_eq!(run.state.feedback(trial), None);
    run.trial();
    let shown = run.state.feedback(trial).unwrap().to_vec();
    let names = trial.presented.names();
    let stronger = names.iter().position(|name| name != "S8").unwrap();
    assert_eq!(shown, [["first", "second"][stronger]]);
    for wrong in 0..=2_usize {
        let mut observer = Observer::new(9);
        let mut failed: BTreeMap<&str, usize> = BTreeMap::new();
        let mut run = Run::begun(&protocol, &plan);
        while let Some((trial, _)) = run.state.current() {
            let presented = run.state.presented(trial);
            let mut word = observer.says(adaptive(&protocol, &trial.task), &presented);
            if let TrialKind::Catch { right } = &trial.kind {
                let failures = failed.entry(trial.task.as_str()).or_default();
                let fails = trial.task == "quest" && *failures < wrong;
                *failures += usize::from(fails);
                word = match (right[0] == "first", fails) {
                    (true, false) | (false, true) => "first",
                    _ => "second",
                };
            }
            let name = trial.name.clone();
            run.present();
            run.answers(word).unwrap();
            run.does(Command::Confirm);
            let planned = plan.trials.iter().find(|trial| trial.name == name).unwrap();
            let trained = matches!(planned.kind, TrialKind::Training { .. });
            assert_eq!(run.state.feedback(planned).is_some(), trained);
            if run.state.progress()["quest"].0 == run.state.progress()["quest"].1
                && run.state.progress()["staircase"].0 == 0
            {
                break;
            }
        }
        let of_quest = run
            .state
            .catches()
            .into_iter()
            .find(|one| one.task == "quest");
        let Some(of_quest) = of_quest.filter(|one| one.answered == 5) else {
            panic!("catch trials are missing");
        };
        assert_eq!((of_quest.failed, of_quest.allowed), (wrong, 1));
        let mut warnings = run.state.warnings();
        warnings.retain(|warning| !is_under_way(warning));
        assert_eq!(warnings.len(), usize::from(wrong > 1));
        if let Some(warning) = warnings.first() {
            let kind: CampaignWarning = warning.kind().unwrap();
            assert_eq!(
                kind,
                CampaignWarning::CatchTrialsFailed {
                    task: "quest".to_owned(),
                    failed: 2,
                    answered: 5,
                    allowed: 1
                }
            );
            assert!(kind.to_string().contains("2 of 5"), "{kind}");
        }
    }
}

#[test]
fn a_catch_trial_of_an_association_is_judged_in_the_participants_own_letters() {
    let (_, toml) = LIBRARY[1];
    let known: Vec<String> = from_library("isotropic_triplets")
        .unwrap()
        .unwrap()
        .sets
        .iter()
        .map(|set| format!("[\"{0}\", \"{0}\"]", set.samples[0]))
        .collect();
    let catch = format!(
        "kind = \"associate\"\ntraining = {{ trials = 2 }}\ncatch = {{ trials = 1, known = [{}], failures_allowed = 0 }}",
        known.join(", ")
    );
    let protocol = read(&toml.replace("kind = \"associate\"", &catch)).unwrap();
    let plan = planned(&protocol, "discrimination");
    let caught = |trial: &&Trial| matches!(trial.kind, TrialKind::Catch { .. });
    assert_eq!(plan.trials.iter().filter(caught).count(), 12);
    let mut run = Run::begun(&protocol, &plan);
    while let Some((trial, _)) = run.state.current() {
        let TrialKind::Catch { right } = &trial.kind else {
            run.trial();
            continue;
        };
        run.present();
        let choices = run.state.choices(trial);
        let said = |name: &String| {
            choices
                .iter()
                .find(|(_, meant)| meant == name)
                .unwrap()
                .0
                .clone()
        };
        let words: Vec<String> = right.iter().map(said).collect();
        run.does(Command::Answer { words });
        run.does(Command::Confirm);
    }
    let counts = run.state.catches();
    assert_eq!((counts[0].answered, counts[0].failed), (12, 0));
    let trained = plan
        .trials
        .iter()
        .filter(|trial| trial.name.contains("training"));
    assert_eq!(trained.clone().count(), 2);
    assert!(
        trained
            .into_iter()
            .all(|trial| run.state.feedback(trial).is_none())
    );
}

#[test]
fn an_event_that_does_not_say_what_was_chosen_is_refused() {
    let (protocol, plan) = jnd();
    let mut run = Run::begun(&protocol, &plan);
    while !run.state.current().unwrap().0.kind.is_counted() {
        run.trial();
    }
    let event = |chosen| Event::Presented {
        trial: run.current(),
        instead: None,
        evidence: Vec::new(),
        chosen,
    };
    let mut state = run.state.clone();
    let error = state.apply(0, &event(None)).unwrap_err().to_string();
    assert!(error.contains("what was chosen"), "{error}");
    // Another program may have chosen another level: what was presented stands.
    let other = vec!["S8".to_owned(), "S8 increment -26".to_owned()];
    state.apply(0, &event(Some(other.clone()))).unwrap();
    let (trial, _) = state.current().unwrap();
    assert_eq!(state.presented(trial), other);
}

#[test]
fn an_interrupted_run_goes_on_from_its_answers() {
    let (_, toml) = LIBRARY[5];
    let listed = toml
        .replace("task_order = \"balanced\"", "task_order = \"as_listed\"")
        .replace("[\"quest\", \"staircase\"]", "[\"staircase\", \"quest\"]");
    let protocol = read(&listed).unwrap();
    let plan = planned(&protocol, "discrimination");
    let mut run = Run::begun(&protocol, &plan);
    let mut observer = Observer::new(11);
    let second = |run: &Run<'_>| {
        let (trial, _) = run.state.current().unwrap();
        trial.task == "quest" && trial.kind.is_counted()
    };
    while !second(&run) {
        let (trial, _) = run.state.current().unwrap();
        let word = observer.says(
            adaptive(&protocol, &trial.task),
            &run.state.presented(trial),
        );
        run.present();
        run.answers(word).unwrap();
        run.does(Command::Confirm);
    }
    run.present();
    let (trial, state) = run.state.current().unwrap();
    let (name, chosen) = (trial.name.clone(), state.chosen.clone().unwrap());
    let answers = threshold(&run.state, "staircase").answers;
    run.does(Command::Resume {
        experimenter: "EX".to_owned(),
        now_ms: run.now_ms,
    });
    let (trial, _) = run.state.current().unwrap();
    assert_eq!((&trial.name, run.state.presented(trial)), (&name, chosen));
    assert_eq!(threshold(&run.state, "staircase").answers, answers);
    whole(&mut run, |rule, presented| observer.says(rule, presented));
    assert_eq!(run.state.step(), Step::End);
    for task in ["quest", "staircase"] {
        let found = threshold(&run.state, task);
        assert!(found.level.is_some() && found.answers >= 30, "{found:?}");
        let (confirmed, planned) = run.state.progress()[task];
        assert_eq!(confirmed, planned);
    }
}

fn is_under_way(warning: &Warning) -> bool {
    matches!(
        warning.kind(),
        Some(CampaignWarning::Incomplete { stopped: false, .. })
    )
}
