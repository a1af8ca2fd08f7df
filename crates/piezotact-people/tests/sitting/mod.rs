//! A participant at a session, whose answers the test gives.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(dead_code, reason = "each program of tests uses a part of it")]

use piezotact::criterion::Outcome;
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::{AnswerForm, Plan, PlanRequest, plan};
use piezotact_people::campaign::protocol::{Protocol, from_library};
use piezotact_people::campaign::session::{Command, Event, Evidence, Participant, State, Step};
use piezotact_people::campaign::store::Purpose;

pub(crate) fn library(name: &str) -> Protocol {
    from_library(name).unwrap().unwrap()
}

pub(crate) fn planned(protocol: &Protocol, session: &str) -> Plan {
    let request = PlanRequest {
        seed: 7,
        participant: "P01",
        session,
        completed: &[],
    };
    plan(protocol, Sha::of(b"protocol"), request).unwrap()
}

/// What was measured while `stimulus` was played.
pub(crate) fn evidence(stimulus: &str, reached: Outcome) -> Evidence {
    Evidence {
        stimulus: stimulus.to_owned(),
        drive: Sha::of(stimulus.as_bytes()),
        gain: None,
        verified: Outcome::Met,
        reached,
        criteria: [].into(),
        score_jnd: None,
        level_re_target_db: None,
        rendered_at_db: None,
        normal_force_n: None,
        onset_s: None,
        onset_uncertainty_s: None,
        strokes: 1,
        journal: None,
        bench: None,
        recorded: None,
    }
}

pub(crate) struct Sitting<'a> {
    pub(crate) state: State<'a>,
    now_ms: i64,
}

impl<'a> Sitting<'a> {
    /// With consent.
    pub(crate) fn begun(protocol: &'a Protocol, plan: &'a Plan) -> Self {
        let mut sitting = Self {
            state: State::new(protocol, plan),
            now_ms: 1_800_000_000_000,
        };
        sitting.does(Command::Begin {
            experimenter: "EX".to_owned(),
            program: "piezotact".to_owned(),
            purpose: Purpose::Volunteer,
            participant: Participant::default(),
        });
        let text = Sha::of(b"consent");
        sitting.does(Command::Consent { text });
        sitting
    }

    pub(crate) fn does(&mut self, command: Command) {
        let event: Event = self.state.decide(&command).unwrap();
        self.now_ms += 1000;
        self.state.apply(self.now_ms, &event).unwrap();
    }

    pub(crate) fn checks(&mut self) {
        while let Step::Check { .. } = self.state.step() {
            self.does(Command::Check);
        }
    }

    /// Presents the current trial as planned, each element with evidence that is `reached`; none for real samples.
    pub(crate) fn presents(&mut self, reached: &[Outcome]) {
        self.checks();
        let (trial, _) = self.state.current().unwrap();
        let names = self.state.presented(trial);
        let each = names.iter().zip(reached);
        let evidence = each
            .map(|(name, reached)| evidence(name, *reached))
            .collect();
        self.does(Command::Present { evidence });
    }

    pub(crate) fn presents_instead(&mut self, names: &[String]) {
        self.checks();
        self.does(Command::PresentInstead {
            names: names.to_vec(),
            evidence: Vec::new(),
        });
    }

    pub(crate) fn answers(&mut self, words: &[String]) {
        let words = words.to_vec();
        self.does(Command::Answer { words });
        self.does(Command::Confirm);
    }

    /// Name and task of the current trial, and what is presented in it.
    pub(crate) fn current(&self) -> (String, String, Vec<String>) {
        let (trial, _) = self.state.current().unwrap();
        let presented = self.state.presented(trial);
        (trial.name.clone(), trial.task.clone(), presented)
    }

    /// The first choices to the current trial.
    pub(crate) fn first_choices(&self) -> Vec<String> {
        let (trial, of) = self.state.current().unwrap();
        let choices = self.state.choices(trial);
        match &trial.answer {
            AnswerForm::Done => Vec::new(),
            AnswerForm::Each { .. } | AnswerForm::EachOfOrder { .. } => {
                vec![choices[0].0.clone(); of.plays.len()]
            }
            AnswerForm::OneOf { .. } | AnswerForm::Some { .. } => vec![choices[0].0.clone()],
            AnswerForm::Order { .. } => choices.into_iter().map(|(said, _)| said).collect(),
            AnswerForm::Scale { from, .. } => vec![from.to_string()],
        }
    }

    /// Presents the current trial and answers with the first choices.
    pub(crate) fn anyhow(&mut self, reached: &[Outcome]) {
        self.presents(reached);
        let words = self.first_choices();
        self.answers(&words);
    }

    /// Goes on until a trial of `task` is to be presented.
    pub(crate) fn until(&mut self, task: &str) {
        while self.current().1 != task {
            self.anyhow(&[]);
        }
    }

    pub(crate) fn finishes(&mut self) {
        while self.state.current().is_some() {
            self.anyhow(&[]);
        }
    }
}
