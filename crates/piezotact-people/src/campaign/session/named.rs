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

    /// The names that the answer number `index` (from 0) to `trial` stood for when it was given, the last one when it was confirmed: with
    /// the participant's own order as it was then. Empty where there is no such answer.
    #[must_use]
    pub fn names_as_given(&self, trial: &Trial, index: usize) -> Vec<String> {
        let Some(of) = self.state_of(&trial.name) else {
            return Vec::new();
        };
        let Some(answer) = of.answers.get(index) else {
            return Vec::new();
        };
        names_of(answer, || match &trial.answer {
            AnswerForm::EachOfOrder { trial } => {
                let corrected = of.order_corrections.get(index).copied().unwrap_or(0);
                self.lettered(trial, |order| order.after_corrections(corrected))
            }
            _ => self.choices(trial),
        })
    }

    /// Whether the letters that were confirmed for `trial` stand for other samples since the participant's own order was corrected.
    #[must_use]
    pub fn is_read_anew(&self, trial: &Trial) -> bool {
        let of = self.state_of(&trial.name);
        let Some((of, answer)) = of.and_then(|of| Some((of, of.as_confirmed()?))) else {
            return false;
        };
        self.names(trial, answer) != self.names_as_given(trial, of.answers.len() - 1)
    }

    /// Why the answer that counts for `trial` is not the one that was confirmed: all reasons for which it was corrected, and those for
    /// which the order that its letters stand for was since. `None` where nothing was corrected that changes it.
    #[must_use]
    pub fn corrected_because(&self, trial: &Trial) -> Option<String> {
        let reasons = self.reasons(trial);
        (!reasons.is_empty()).then(|| reasons.join("; "))
    }

    /// How often the answer to `trial` was corrected after its confirmation, or the order that its letters stand for where that
    /// changes it.
    #[must_use]
    pub fn corrections(&self, trial: &Trial) -> usize {
        self.reasons(trial).len()
    }

    fn reasons(&self, trial: &Trial) -> Vec<String> {
        let Some(of) = self.state_of(&trial.name) else {
            return Vec::new();
        };
        let mut reasons: Vec<String> = of.corrections.iter().map(|(_, why)| why.clone()).collect();
        if let AnswerForm::EachOfOrder { trial: order } = &trial.answer
            && self.is_read_anew(trial)
        {
            let known = of.order_corrections.last().copied().unwrap_or(0);
            let of_order = self.state_of(order).into_iter();
            let since = of_order.flat_map(|order| order.corrections.iter().skip(known));
            let number = self.number(order);
            reasons
                .extend(since.map(|(_, why)| format!("order of trial {number} corrected: {why}")));
        }
        reasons
    }

    /// How often the order that letters answered to the trial named `name` stand for was corrected until now; 0 where there is none.
    pub(super) fn order_corrections(&self, name: &str) -> usize {
        let trial = self.plan.trials.iter().find(|trial| trial.name == name);
        match trial.map(|trial| &trial.answer) {
            Some(AnswerForm::EachOfOrder { trial: order }) => {
                self.state_of(order).map_or(0, |of| of.corrections.len())
            }
            _ => 0,
        }
    }

    fn state_of(&self, name: &str) -> Option<&TrialState> {
        let found = self.trials().find(|(other, _)| other.name == name);
        found.map(|(_, state)| state)
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
        Answer::Done | Answer::Number(_) | Answer::Unknown => Vec::new(),
    }
}
