//! What answers stand for: samples by their names, or letters in the participant's own order.

use super::super::plan::{AnswerForm, Trial};
use super::answer::letters;
use super::{Answer, State, TrialState};

impl State<'_> {
    /// The choices of the answer to `trial`, and the sample that each stands for: A, B, C … in the participant's own order
    /// where the trial asks for them; empty where there are none.
    #[must_use]
    pub fn choices(&self, trial: &Trial) -> Vec<(String, String)> {
        let as_named = |choices: &[String]| {
            choices
                .iter()
                .map(|one| (one.clone(), one.clone()))
                .collect()
        };
        match &trial.answer {
            AnswerForm::OneOf { choices }
            | AnswerForm::Each { choices }
            | AnswerForm::Some { choices, .. } => as_named(choices),
            // Where another sample was on the tray, it is put in order.
            AnswerForm::Order { samples, .. } => {
                let own = self.trials().find(|(other, _)| other.name == trial.name);
                let instead = own.and_then(|(_, state)| state.presented_instead.as_deref());
                as_named(instead.unwrap_or(samples))
            }
            AnswerForm::EachOfOrder { trial } => self.lettered(trial, TrialState::answer),
            AnswerForm::Done | AnswerForm::Scale { .. } => Vec::new(),
        }
    }

    /// A, B, C … with the samples of the order that `of` takes from the trial named `order`.
    fn lettered(
        &self,
        order: &str,
        of: impl Fn(&TrialState) -> Option<&Answer>,
    ) -> Vec<(String, String)> {
        let own = self.trials().find(|(other, _)| other.name == order);
        match own.and_then(|(_, state)| of(state)) {
            Some(Answer::Names(order)) => letters().zip(order.iter().cloned()).collect(),
            _ => Vec::new(),
        }
    }

    /// The names that `answer` to `trial` stands for; places in the participant's own order as the samples that stand there
    /// now. Empty for numbers and for what is only done.
    #[must_use]
    pub fn names(&self, trial: &Trial, answer: &Answer) -> Vec<String> {
        names_of(answer, || self.choices(trial))
    }

    /// The names that `answer` to `trial` stood for before the participant's own order was corrected.
    #[must_use]
    pub fn names_as_confirmed(&self, trial: &Trial, answer: &Answer) -> Vec<String> {
        names_of(answer, || match &trial.answer {
            AnswerForm::EachOfOrder { trial } => self.lettered(trial, TrialState::as_confirmed),
            _ => self.choices(trial),
        })
    }

    /// Whether the letters that were confirmed for `trial` stand for other samples since the participant's own order was corrected.
    #[must_use]
    pub fn is_read_anew(&self, trial: &Trial) -> bool {
        let state = self.trials().find(|(other, _)| other.name == trial.name);
        let confirmed = state.and_then(|(_, state)| state.as_confirmed());
        confirmed.is_some_and(|answer| {
            self.names(trial, answer) != self.names_as_confirmed(trial, answer)
        })
    }

    /// Why the answer that counts for `trial` is not the one that was confirmed: the last reason for which it was corrected, or for
    /// which the order that its letters stand for was. `None` where it is the confirmed one.
    #[must_use]
    pub fn corrected_because(&self, trial: &Trial) -> Option<String> {
        let state_of = |name: &str| self.trials().find(|(other, _)| other.name == name);
        let own = state_of(&trial.name).and_then(|(_, state)| state.corrections.last());
        if let Some((_, why)) = own {
            return Some(why.clone());
        }
        let AnswerForm::EachOfOrder { trial: order } = &trial.answer else {
            return None;
        };
        let (_, why) = state_of(order)?.1.corrections.last()?;
        self.is_read_anew(trial)
            .then(|| format!("order of trial {} corrected: {why}", self.number(order)))
    }

    /// The number of the trial named `name` in the plan, from 1, as experimenters see it; 0 for a name that is not there.
    #[must_use]
    pub fn number(&self, name: &str) -> usize {
        let at = self.plan.trials.iter().position(|trial| trial.name == name);
        at.map_or(0, |at| at + 1)
    }
}

/// The names that `answer` stands for among `choices`.
fn names_of(answer: &Answer, choices: impl FnOnce() -> Vec<(String, String)>) -> Vec<String> {
    match answer {
        Answer::Names(names) => names.clone(),
        Answer::Places(places) => {
            let choices = choices();
            let named = places.iter().filter_map(|place| choices.get(*place));
            named.map(|(_, named)| named.clone()).collect()
        }
        Answer::Done | Answer::Number(_) => Vec::new(),
    }
}
