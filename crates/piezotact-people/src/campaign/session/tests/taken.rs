//! How long an answer takes, and what is taken for one.

use super::*;

/// The response time has no pauses in it.
#[test]
fn a_pause_is_not_part_of_the_time_of_an_answer() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.present();
    run.does(Command::Pause);
    run.now_ms += 600_000;
    run.does(Command::GoOn);
    let (trial, _) = run.state.current().unwrap();
    let choices: Vec<String> = run
        .state
        .choices(trial)
        .into_iter()
        .map(|(said, _)| said)
        .collect();
    run.answers(&choices.join(" ")).unwrap();
    run.does(Command::Confirm);
    let (_, of) = run.state.trials().next().unwrap();
    // Each event is a second after the one before: presented, paused, gone on, answered, confirmed.
    assert_eq!(of.seconds(), Some(3.0));
}

/// A touch trial that is confirmed after 0.49 s is refused.
#[test]
fn a_trial_of_touch_takes_as_long_as_its_strokes() {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "measurement");
    let mut run = Run::begun(&protocol, &plan);
    assert_eq!(run.state.too_soon(i64::MAX), None);
    run.present();
    let (trial, _) = run.state.current().unwrap();
    let TaskKind::Touch { strokes } = protocol.task(&trial.task).unwrap().kind else {
        panic!("{trial:?}");
    };
    let after = |ms: i64| {
        run.state
            .too_soon(run.now_ms + ms)
            .map(|why| why.to_string())
    };
    let least_ms = i64::from(strokes) * 200;
    let said = after(490).unwrap();
    assert!(said.contains(&format!("for {strokes} strokes")), "{said}");
    assert!(said.contains("found 0.5 s"), "{said}");
    assert!(after(least_ms - 1).is_some());
    for ms in [least_ms, i64::MAX - run.now_ms, -1, i64::MIN] {
        assert_eq!(after(ms), None, "{ms}");
    }
    // No answer to a trial of another kind is too soon.
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.present();
    assert_eq!(run.state.too_soon(run.now_ms), None);
}

/// It is an answer where the protocol says so, is noted as such, and names nothing.
#[test]
fn not_known_is_an_answer_where_the_protocol_allows_it() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.present();
    assert!(run.answers("?").is_err());
    let mut allowed = protocol.clone();
    allowed
        .tasks
        .iter_mut()
        .for_each(|task| task.may_not_know = true);
    let mut run = Run::begun(&allowed, &plan);
    run.present();
    run.answers("?").unwrap();
    run.does(Command::Confirm);
    let (trial, of) = run.state.trials().next().unwrap();
    assert_eq!(of.answer(), Some(&Answer::Unknown));
    assert!(run.state.names(trial, &Answer::Unknown).is_empty());
    let rows = crate::association::answers_of(&run.state, Purpose::Volunteer);
    assert!(rows.is_empty(), "{rows:?}");
    // An adaptive run needs an answer each time.
    let (_, text) = LIBRARY
        .iter()
        .find(|(name, _)| *name == "roughness_jnd")
        .unwrap();
    let refused = read(&text.replace(
        "kind = \"compare\"",
        "kind = \"compare\"\nmay_not_know = true",
    ));
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("ask the participant to guess")
    );
}

/// Which textures are to be played is said to nobody, also not by what a page refuses.
#[test]
fn a_refusal_names_no_texture() {
    let protocol = from_library("roughness_jnd").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    let mut run = Run::begun(&protocol, &plan);
    while let Step::Check { .. } = run.state.step() {
        run.does(Command::Check);
    }
    let said = run.tries(Command::GoOn).unwrap_err().to_string();
    assert!(said.contains("play the textures"), "{said}");
    assert!(!said.contains("S8"), "{said}");
}
