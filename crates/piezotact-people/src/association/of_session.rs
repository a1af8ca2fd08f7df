//! The answers of a session as rows of the table that matrices are made from.

use std::collections::BTreeMap;

use super::answer::{Answer, Declared, Flag, Purpose, Stimulus};
use crate::campaign::plan::{AnswerForm, Presented, Trial};
use crate::campaign::protocol::{OrderKey, Protocol, TaskKind};
use crate::campaign::session::{self, Evidence, State, TrialState};
use crate::campaign::store;

/// Between the name of a session and the number of a repetition of an order in it, from the second on.
pub const REPETITION: &str = ", repetition ";

/// What `protocol` declares: its samples, and its stimuli with the answer that is expected for each.
///
/// Source: thesis 2.6 and 4.4; docs/decisions/answers.md.
#[must_use]
pub fn declared(protocol: &Protocol) -> Declared {
    let plain = protocol
        .samples
        .iter()
        .map(|sample| Stimulus::plain(sample));
    let made = protocol
        .stimuli
        .iter()
        .map(|stimulus| Stimulus::manipulated(&stimulus.name, &stimulus.of, stimulus.expected()));
    Declared {
        samples: protocol.samples.clone(),
        stimuli: plain.chain(made).collect(),
    }
}

/// The confirmed answers of `state` that say which sample was presented and which was answered: of tasks in which samples are named
/// or associated one row for each element; of tasks in which they are put in order one row for each place, in which the sample that
/// stands in the place of another is presented as the first and answered as the second. Ratings, comparisons, descriptors and orders without
/// a physical order are not among them.
///
/// Source: thesis 2.6.1 and 2.6.2; docs/decisions/answers.md.
#[must_use]
pub fn answers_of(state: &State<'_>, purpose: store::Purpose) -> Vec<Answer> {
    let mut rows = Vec::new();
    let mut repetitions: BTreeMap<[&str; 2], u32> = BTreeMap::new();
    for (trial, trial_state) in state.trials() {
        if !trial.kind.is_counted() {
            continue;
        }
        // Orders of the same samples are told apart by this number alone, also where they stand in different blocks.
        let place = [&*trial.task, trial.set.as_deref().unwrap_or("")];
        let repetition = repetitions.entry(place).or_default();
        *repetition += 1;
        if let Some(answer) = trial_state.answer() {
            let names = state.names(trial, answer);
            rows.extend(of_trial(state, (trial, trial_state), &names, *repetition));
        }
    }
    for row in &mut rows {
        row.purpose = match purpose {
            store::Purpose::Volunteer => Purpose::Trial,
            store::Purpose::Rehearsal => Purpose::Rehearsal,
        };
    }
    rows
}

/// How many counted trials of `state` whose answers would stand in a matrix were answered with "I do not know".
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn not_known(state: &State<'_>) -> usize {
    let of_names = |task: &str| {
        let kind = state.protocol().task(task).map(|task| &task.kind);
        matches!(
            kind,
            Some(TaskKind::Order { .. } | TaskKind::Identify { .. } | TaskKind::Associate { .. })
        )
    };
    let unknown = state.trials().filter(|(trial, of)| {
        trial.kind.is_counted()
            && of_names(&trial.task)
            && of.answer() == Some(&session::Answer::Unknown)
    });
    unknown.count()
}

/// The rows of one trial that is answered with `names`.
pub(super) fn of_trial(
    state: &State<'_>,
    (trial, trial_state): (&Trial, &TrialState),
    names: &[String],
    repetition: u32,
) -> Vec<Answer> {
    let protocol = state.protocol();
    let kind = protocol.task(&trial.task).map(|task| &task.kind);
    let row = |presented: &str, answered: &str, position: usize| Answer {
        participant: state.plan().participant.clone(),
        session: state.plan().session.clone(),
        task: trial.task.clone(),
        set: trial.set.clone().unwrap_or_default(),
        trial: trial.name.clone(),
        presented: presented.to_owned(),
        answered: answered.to_owned(),
        position: Some(position),
        offered: offered(state, trial),
        flags: flags((state, trial), trial_state, position - 1),
        purpose: Purpose::Trial,
        judge: state
            .participant()
            .judge
            .map(|judge| judge.name().to_owned()),
    };
    match (kind, &trial.answer) {
        (Some(TaskKind::Order { key, .. }), AnswerForm::Order { .. }) => {
            // Those that were put in order: what was on the tray.
            let Some(physical) = in_order(protocol, names, *key) else {
                return Vec::new();
            };
            let places = names.iter().zip(&physical).enumerate();
            let rows = places.map(|(i, (placed, stands))| row(placed, stands, i + 1));
            let mut rows: Vec<Answer> = rows.collect();
            if repetition > 1 {
                // Each order is a repetition of its own.
                let name = format!("{}{REPETITION}{repetition}", state.plan().session);
                rows.iter_mut()
                    .for_each(|row| row.session.clone_from(&name));
            }
            rows
        }
        (Some(TaskKind::Identify { .. } | TaskKind::Associate { .. }), form)
            if *form != AnswerForm::Done =>
        {
            let presented = state.presented(trial);
            let elements = presented.iter().zip(names).enumerate();
            elements
                .map(|(i, (presented, answered))| row(presented, answered, i + 1))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// `samples` in their physical order from the first end of the task; `None` where there is none.
fn in_order(protocol: &Protocol, samples: &[String], key: OrderKey) -> Option<Vec<String>> {
    let listed = protocol.samples.iter();
    let mut listed: Vec<String> = listed
        .filter(|one| samples.contains(one))
        .cloned()
        .collect();
    match key {
        OrderKey::AsListed => Some(listed),
        OrderKey::Reversed => {
            listed.reverse();
            Some(listed)
        }
        OrderKey::None => None,
    }
}

/// The samples that can be answered to `trial`.
pub(super) fn offered(state: &State<'_>, trial: &Trial) -> Vec<String> {
    let choices = state.choices(trial).into_iter();
    choices.map(|(_, sample)| sample).collect()
}

/// What was wrong with an element of a trial. The samples of an order are felt together: a wrong one on the tray is wrong for all.
pub(super) fn flags(
    (session, trial): (&State<'_>, &Trial),
    state: &TrialState,
    element: usize,
) -> Vec<Flag> {
    let mut flags = Vec::new();
    // Virtual volunteers have nothing else.
    if session.participant().judge.is_none()
        && state.evidence_of(element).any(Evidence::is_simulated)
    {
        flags.push(Flag::Simulated);
    }
    // Each playing of a rendered stimulus leaves its evidence; those of this element count.
    if state.evidence_of(element).any(Evidence::missed) {
        flags.push(Flag::MissedTarget);
    }
    let rendered = matches!(
        trial.presented,
        Presented::Rendered { .. } | Presented::Chosen { .. }
    );
    if rendered && state.evidence_of(element).next().is_none() {
        flags.push(Flag::NotMeasured);
    }
    let planned = state.chosen.as_deref();
    let planned = planned.unwrap_or(trial.presented.names());
    let is_wrong =
        state
            .presented_instead
            .as_deref()
            .is_some_and(|instead| match trial.presented {
                Presented::Tray { .. } => instead != planned,
                _ => instead.get(element) != planned.get(element),
            });
    if is_wrong {
        flags.push(Flag::WrongSample);
    }
    flags
}
