use super::super::plan::AnswerForm;
use super::super::plan::{Plan, PlanRequest, plan};
use super::super::protocol::{LIBRARY, Protocol, TaskKind, from_library, read};
use super::*;
use piezotact::Warning;
use piezotact::criterion::Outcome;
use piezotact::recording::BenchKind;

mod adaptive;
mod report;
mod taken;

const HOUR_MS: i64 = 3_600_000;

fn planned(protocol: &Protocol, session: &str) -> Plan {
    let request = PlanRequest {
        seed: 7,
        participant: "P01",
        session,
        completed: &[],
    };
    plan(protocol, Sha::of(b"protocol"), request).unwrap()
}

fn isotropic() -> (Protocol, Plan) {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    (protocol, plan)
}

/// A session that keeps its events, as a runner does.
fn present() -> Command {
    let evidence = Vec::new();
    Command::Present { evidence }
}

/// What was measured while `stimulus` was played on `bench`.
fn playing(stimulus: &str, reached: Outcome, bench: BenchKind) -> Evidence {
    Evidence {
        stimulus: stimulus.to_owned(),
        drive: Sha::of(b"drive"),
        gain: None,
        verified: Outcome::Met,
        reached,
        criteria: BTreeMap::new(),
        score_jnd: None,
        level_re_target_db: None,
        rendered_at_db: None,
        normal_force_n: None,
        onset_s: None,
        onset_uncertainty_s: None,
        strokes: 1,
        bench: Some(bench),
        recorded: None,
        journal: None,
    }
}

struct Run<'a> {
    state: State<'a>,
    events: Vec<(i64, Event)>,
    now_ms: i64,
}

impl<'a> Run<'a> {
    fn new(protocol: &'a Protocol, plan: &'a Plan) -> Self {
        Self {
            state: State::new(protocol, plan),
            events: Vec::new(),
            now_ms: 1_000_000,
        }
    }

    fn begun(protocol: &'a Protocol, plan: &'a Plan) -> Self {
        let mut run = Self::new(protocol, plan);
        run.does(Command::Begin {
            experimenter: "EX".to_owned(),
            program: "piezotact 0.1.0".to_owned(),
            purpose: Purpose::Volunteer,
            participant: Participant::default(),
        });
        run.does(Command::Consent {
            text: Sha::of(b"consent"),
        });
        run
    }

    fn tries(&mut self, command: Command) -> Result<(), Refusal> {
        let event = self.state.decide(&command)?;
        self.now_ms += 1000;
        self.state.apply(self.now_ms, &event).unwrap();
        self.events.push((self.now_ms, event));
        // The state derived from the journal alone equals the running state.
        let again =
            State::after(self.state.protocol, self.state.plan, self.events.clone()).unwrap();
        assert_eq!(again.trials, self.state.trials);
        assert_eq!(again.stage, self.state.stage);
        assert_eq!(again.step(), self.state.step());
        Ok(())
    }

    fn does(&mut self, command: Command) {
        let shown = format!("{command:?}");
        self.tries(command)
            .unwrap_or_else(|refusal| panic!("{shown}: {refusal}"));
    }

    fn answers(&mut self, words: &str) -> Result<(), Refusal> {
        let words = words.split(' ').map(str::to_owned).collect();
        self.tries(Command::Answer { words })
    }

    /// Goes on to the moment at which the current trial awaits its answer.
    fn present(&mut self) {
        while let Step::Check { .. } = self.state.step() {
            self.does(Command::Check);
        }
        self.does(present());
    }

    /// Answers and confirms the current trial with the first choices.
    fn trial(&mut self) {
        self.present();
        let (trial, state) = self.state.current().unwrap();
        let choices = self.state.choices(trial);
        let words: Vec<String> = match &trial.answer {
            AnswerForm::Done => Vec::new(),
            AnswerForm::Each { .. } | AnswerForm::EachOfOrder { .. } => {
                vec![choices[0].0.clone(); state.plays.len()]
            }
            AnswerForm::OneOf { .. } | AnswerForm::Some { .. } => vec![choices[0].0.clone()],
            AnswerForm::Order { .. } => choices.iter().map(|(said, _)| said.clone()).collect(),
            AnswerForm::Scale { from, .. } => vec![from.to_string()],
        };
        self.does(Command::Answer { words });
        self.does(Command::Confirm);
    }

    fn current(&self) -> String {
        self.state.current().unwrap().0.name.clone()
    }
}

/// Participants who read English, French or Italian read every task of the library in their language: a word that is missing in one fails.
#[test]
fn tasks_of_the_library_are_translated() {
    for (name, _) in LIBRARY {
        let protocol = from_library(name).unwrap().unwrap();
        for task in &protocol.tasks {
            for tag in ["fr", "it"] {
                let of = format!("{name}, {}, {tag}", task.name);
                let words = task.words_in(tag).unwrap_or_else(|| panic!("{of}"));
                assert_ne!(words.instruction, task.instruction, "{of}");
                assert!(words.title.is_some(), "{of}: title");
                assert_eq!(
                    words.checklist.len(),
                    task.checklist.len(),
                    "{of}: checklist"
                );
                let (descriptors, has_ends) = match &task.kind {
                    TaskKind::Order { .. } => (0, true),
                    TaskKind::Rate { lowest, .. } => (0, lowest.is_some()),
                    TaskKind::Categorise { descriptors, .. } => (descriptors.len(), false),
                    _ => (0, false),
                };
                assert_eq!(words.descriptors.len(), descriptors, "{of}: descriptors");
                let ends = [&words.from, &words.to];
                assert!(ends.iter().all(|end| end.is_some() == has_ends), "{of}");
            }
            assert_eq!(task.words_in("fr-CH"), task.words_in("FR"));
            assert_eq!(task.words_in("de"), None);
        }
    }
}

#[test]
fn every_session_of_the_library_runs_to_its_end() {
    for (name, _) in LIBRARY {
        let protocol = from_library(name).unwrap().unwrap();
        for session in &protocol.sessions {
            let plan = planned(&protocol, &session.name);
            let mut run = Run::begun(&protocol, &plan);
            while run.state.current().is_some() {
                run.trial();
            }
            assert_eq!(run.state.step(), Step::End, "{name}");
            run.does(Command::End);
            assert_eq!(run.state.stage(), Stage::Ended, "{name}");
            let left = run.state.progress();
            assert!(
                left.values()
                    .all(|(confirmed, planned)| confirmed == planned)
            );
            let chosen = |trial: &Trial| matches!(trial.presented, Presented::Chosen { .. });
            if !plan.trials.iter().any(chosen) {
                assert_eq!(run.state.confirmed(), plan.trials.len());
            }
        }
    }
}

#[test]
fn nothing_happens_before_consent_and_the_checklist() {
    let (protocol, plan) = isotropic();
    let mut run = Run::new(&protocol, &plan);
    assert!(run.tries(present()).is_err());
    run.does(Command::Begin {
        experimenter: "EX".to_owned(),
        program: "p".to_owned(),
        purpose: Purpose::Volunteer,
        participant: Participant::default(),
    });
    let refusal = run.tries(present()).unwrap_err().to_string();
    assert_eq!(refusal, "not now: ask for consent");
    run.does(Command::Consent { text: Sha::of(b"") });
    let refusal = run.tries(present()).unwrap_err().to_string();
    assert_eq!(
        refusal,
        "not now: confirm: hands washed with soap and dried"
    );
    let mut refused = Run::new(&protocol, &plan);
    refused.does(Command::Begin {
        experimenter: "EX".to_owned(),
        program: "p".to_owned(),
        purpose: Purpose::Volunteer,
        participant: Participant::default(),
    });
    refused.does(Command::RefuseConsent);
    assert_eq!(refused.state.step(), Step::Nothing);
}

#[test]
fn letters_stand_for_the_participants_own_order_of_that_set() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..3 {
        run.trial();
    }
    run.present();
    let set = run.state.current().unwrap().0.set.clone().unwrap();
    let samples = protocol.set(&set).unwrap().samples.clone();
    let own = [&samples[2], &samples[0], &samples[1]].map(String::clone);
    run.answers(&own.join(" ")).unwrap();
    run.does(Command::Confirm);
    run.present();
    let (trial, state) = run.state.current().unwrap();
    assert_eq!(trial.task, "task3");
    let said = run.state.choices(trial);
    assert_eq!(said[0], ("A".to_owned(), own[0].clone()));
    assert_eq!(said.len(), 3);
    let count = state.plays.len();
    run.answers(&vec!["b"; count].join(" ")).unwrap();
    run.does(Command::Confirm);
    let order_trial = run.state.plan().trials[3].name.clone();
    let meant = |run: &Run<'_>| {
        let (trial, state) = run.state.trials().nth(4).unwrap();
        run.state.names(trial, state.answer().unwrap())
    };
    assert_eq!(meant(&run), vec![own[1].clone(); count]);
    // The samples stood where they stood: where the order was noted wrongly, B is another sample.
    run.does(Command::Correct {
        trial: order_trial,
        words: samples.clone(),
        why: "the order was noted wrongly".to_owned(),
    });
    assert_eq!(meant(&run), vec![samples[1].clone(); count]);
}

#[test]
fn revisions_and_corrections_are_both_kept_and_differ() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.present();
    let name = run.current();
    let mut order = protocol.samples.clone();
    run.answers(&order.join(" ")).unwrap();
    order.swap(0, 1);
    run.answers(&order.join(" ")).unwrap();
    assert!(
        matches!(
            run.tries(Command::Correct {
                trial: name.clone(),
                words: order.clone(),
                why: "typed wrongly".to_owned()
            }),
            Err(Refusal::NotNow { .. })
        ),
        "before the confirmation there is nothing to correct"
    );
    run.does(Command::Confirm);
    let confirmed = Answer::Names(order.clone());
    order.swap(2, 3);
    assert!(matches!(
        run.tries(Command::Correct {
            trial: name.clone(),
            words: order.clone(),
            why: " ".to_owned()
        }),
        Err(Refusal::NoReason)
    ));
    run.does(Command::Correct {
        trial: name.clone(),
        words: order.clone(),
        why: "noted in the wrong line".to_owned(),
    });
    let (_, state) = run.state.trials().next().unwrap();
    assert_eq!(state.answers.len(), 2);
    assert_eq!(state.answers[1], confirmed);
    assert_eq!(state.answer(), Some(&Answer::Names(order)));
}

#[test]
fn a_late_answer_to_a_confirmed_trial_is_journalled_and_changes_nothing() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    let name = run.current();
    run.trial();
    let before = run.state.trials.clone();
    run.does(Command::AnswerTo {
        trial: name,
        words: protocol.samples.iter().rev().cloned().collect(),
    });
    assert_eq!(run.state.trials, before);
    assert_eq!(run.state.ignored(), 1);
    let refusal = run.tries(Command::AnswerTo {
        trial: "triplets.task3.A".to_owned(),
        words: vec!["A".to_owned()],
    });
    assert!(
        matches!(refusal, Err(Refusal::NotNow { .. })),
        "not presented yet"
    );
    let refusal = run.tries(Command::AnswerTo {
        trial: "dessert".to_owned(),
        words: Vec::new(),
    });
    assert!(matches!(refusal, Err(Refusal::Unknown { .. })));
}

#[test]
fn answers_outside_the_choices_are_refused_with_the_choices() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..3 {
        run.trial();
    }
    run.present();
    let set = run.state.current().unwrap().0.set.clone().unwrap();
    let samples = protocol.set(&set).unwrap().samples.clone();
    let says = |run: &mut Run<'_>, words: &str, part: &str| {
        let text = run.answers(words).unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    };
    says(&mut run, "NO S1 S2", "`NO` is not one of the choices");
    says(&mut run, &samples[0], "expected 3 of");
    let twice = format!("{0} {0} {1}", samples[0], samples[1]);
    says(&mut run, &twice, "stands twice");
    assert!(run.state.current().unwrap().1.answers.is_empty());
}

#[test]
fn the_wrong_sample_is_kept_as_presented() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..3 {
        run.trial();
    }
    while let Step::Check { .. } = run.state.step() {
        run.does(Command::Check);
    }
    let wrong = vec!["S1".to_owned(), "S2".to_owned(), "S3".to_owned()];
    assert!(matches!(
        run.tries(Command::PresentInstead {
            names: vec!["S99".to_owned()],
            evidence: Vec::new(),
        }),
        Err(Refusal::NotPresentable { .. })
    ));
    run.does(Command::PresentInstead {
        names: wrong.clone(),
        evidence: Vec::new(),
    });
    assert_eq!(
        run.state.current().unwrap().1.presented_instead,
        Some(wrong)
    );
}

#[test]
fn replays_are_counted_by_element() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..4 {
        run.trial();
    }
    run.present();
    for element in [1, 1, 0] {
        run.does(Command::Play {
            element,
            evidence: None,
        });
    }
    assert_eq!(run.state.current().unwrap().1.plays[..3], [2, 3, 1]);
    assert!(matches!(
        run.tries(Command::Play {
            element: 9,
            evidence: None
        }),
        Err(Refusal::Unknown { .. })
    ));
}

/// The isotropic protocol, cut off while the second answer of a set is awaited, and resumed after `hours`.
fn cut_off(hours: i64) -> (Vec<TrialState>, Stage, String) {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..4 {
        run.trial();
    }
    run.present();
    let count = run.state.current().unwrap().1.plays.len();
    run.answers(&vec!["A"; count].join(" ")).unwrap();
    let now_ms = run.now_ms + hours * HOUR_MS;
    run.does(Command::Resume {
        experimenter: "EX".to_owned(),
        now_ms,
    });
    let step = match run.state.step() {
        Step::Check { .. } => "check",
        Step::Confirm { .. } => "confirm",
        Step::Nothing => "nothing",
        _ => "other",
    };
    (
        run.state.trials[3..5].to_vec(),
        run.state.stage(),
        step.to_owned(),
    )
}

#[test]
fn an_interrupted_trial_is_repeated() {
    let (trials, _, step) = cut_off(1);
    assert!(trials[0].confirmed && trials[1].answers.is_empty() && step == "check");
    assert_eq!((trials[1].attempts, trials[1].interrupted), (1, 1));
    let (_, stage, step) = cut_off(13);
    assert_eq!((stage, step.as_str()), (Stage::Stopped, "nothing"));
}

#[test]
fn a_clock_that_jumps_back_is_said_and_stops_nothing() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.now_ms -= 500_000;
    run.trial();
    assert_eq!(run.state.jumps_back_ms(), [499_000]);
    run.does(Command::Resume {
        experimenter: "EX".to_owned(),
        now_ms: 0,
    });
    assert_eq!(run.state.stage(), Stage::Running);
}

#[test]
fn a_changed_protocol_or_plan_under_a_running_session_is_refused() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.trial();
    let mut other = plan.clone();
    other.protocol_sha = Sha::of(b"changed");
    let error = State::after(&protocol, &other, run.events.clone()).unwrap_err();
    assert!(
        matches!(
            error,
            SessionError::Changed {
                what: "protocol",
                ..
            }
        ),
        "{error}"
    );
    let mut other = plan.clone();
    other.trials.swap(0, 1);
    let error = State::after(&protocol, &other, run.events).unwrap_err();
    assert!(
        matches!(error, SessionError::Changed { what: "plan", .. }),
        "{error}"
    );
}

#[test]
fn withdrawal_pause_and_stop_end_what_can_be_answered() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    run.trial();
    run.does(Command::Pause);
    assert_eq!(run.state.step(), Step::GoOn);
    assert!(run.tries(present()).is_err());
    run.does(Command::GoOn);
    run.does(Command::Note {
        text: "a door slammed".to_owned(),
    });
    assert_eq!(
        run.tries(Command::Stop { why: String::new() }),
        Err(Refusal::NoReason)
    );
    assert!(run.tries(Command::End).is_err(), "trials are left");
    let name = plan.trials[0].name.clone();
    run.does(Command::Withdraw);
    assert_eq!(run.state.step(), Step::Nothing);
    let late = run.tries(Command::Correct {
        trial: name,
        words: protocol.samples.clone(),
        why: "late".to_owned(),
    });
    assert!(matches!(late, Err(Refusal::NotNow { .. })));
}

#[test]
fn events_are_written_and_read_as_json() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    for _ in 0..5 {
        run.trial();
    }
    for (_, event) in &run.events {
        let json = serde_json::to_string(event).unwrap();
        let again: Event = serde_json::from_str(&json).unwrap();
        assert_eq!(again, *event, "{json}");
    }
}

#[test]
fn letters_go_beyond_the_alphabet() {
    let all: Vec<String> = letters().take(28).collect();
    assert_eq!(
        (
            all[0].as_str(),
            all[25].as_str(),
            all[26].as_str(),
            all[27].as_str()
        ),
        ("A", "Z", "AA", "AB")
    );
}

#[test]
fn what_was_stopped_early_or_felt_by_nobody_is_a_warning() {
    let (protocol, plan) = isotropic();
    let mut run = Run::begun(&protocol, &plan);
    assert_eq!(run.state.warnings(), []);
    run.trial();
    let under_way = || CampaignWarning::Incomplete {
        session: "session discrimination of P01".to_owned(),
        confirmed: 1,
        planned: 27,
        stopped: false,
    };
    assert_eq!(run.state.warnings(), [Warning::from(under_way())]);
    let mut stopped = Run {
        state: run.state.clone(),
        events: run.events.clone(),
        now_ms: run.now_ms,
    };
    stopped.does(Command::Stop {
        why: "tired".to_owned(),
    });
    let warnings = stopped.state.warnings();
    let said = warnings[0].kind::<CampaignWarning>().unwrap().to_string();
    assert_eq!(warnings.len(), 1);
    assert!(said.contains("stopped after 1 of 27 trials"), "{said}");
    // A session that is under way is not stopped, and one stopped before its first answer has nothing to count.
    let mut at_once = Run::begun(&protocol, &plan);
    at_once.does(Command::Stop {
        why: "tired".to_owned(),
    });
    assert_eq!(at_once.state.warnings(), []);
    let felt = |bench| {
        let mut state = run.state.clone();
        let trial = plan.trials.iter().find(|trial| trial.task == "task3");
        let trial = trial.unwrap();
        let one = |stimulus: &String| playing(stimulus, Outcome::Met, bench);
        let event = Event::Presented {
            trial: trial.name.clone(),
            instead: None,
            evidence: trial.presented.names().iter().map(one).collect(),
            chosen: None,
        };
        state.apply(2_000_000, &event).unwrap();
        (state.warnings(), trial.presented.names().len())
    };
    assert_eq!(felt(BenchKind::Hardware).0, [Warning::from(under_way())]);
    let (warnings, playings) = felt(BenchKind::Twin);
    let said = warnings[1].to_string();
    assert!(
        said.contains(&format!("{playings} playings were on a simulated bench")),
        "{said}"
    );
}
