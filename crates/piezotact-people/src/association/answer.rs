//! Answers of participants, checked once.

use crate::association::AssociationError;
use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// Whether a trial counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// A trial of the campaign.
    #[default]
    Trial,
    /// A rehearsal: it is counted as such and excluded.
    Rehearsal,
}

/// What was wrong with a trial; it is kept and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Flag {
    /// The vibration that was played did not reach its target.
    MissedTarget,
    /// It was played by hand on another system: nothing was measured.
    NotMeasured,
    /// Another sample than the planned one was handed over; the answer says what was presented.
    WrongSample,
    /// It was played on a simulated bench: no person felt it.
    Simulated,
}

impl Flag {
    /// Every flag.
    pub const ALL: [Self; 4] = [
        Self::MissedTarget,
        Self::NotMeasured,
        Self::WrongSample,
        Self::Simulated,
    ];

    /// The flag as it stands in tables: `missed_target`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::MissedTarget => "missed_target",
            Self::NotMeasured => "not_measured",
            Self::WrongSample => "wrong_sample",
            Self::Simulated => "simulated",
        }
    }
}

/// One answer: what was presented in a trial, and what it was declared to be.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Answer {
    /// The participant, by pseudonym.
    pub participant: String,
    /// The session; empty where there is one.
    #[serde(default)]
    pub session: String,
    /// The task.
    pub task: String,
    /// The set of samples; empty where there is one.
    #[serde(default)]
    pub set: String,
    /// The trial within participant, session, task and set. With a position each of its elements has an answer of its own.
    pub trial: String,
    /// The stimulus that was presented.
    pub presented: String,
    /// The sample that it was declared to be.
    pub answered: String,
    /// Its place in the sequence that was presented, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<usize>,
    /// The samples that could be answered; empty where it is not stated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub offered: Vec<String>,
    /// What was wrong with the trial.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flags: Vec<Flag>,
    /// Whether it counts.
    #[serde(default)]
    pub purpose: Purpose,
    /// How a virtual volunteer judges who gave it; absent for a person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judge: Option<String>,
}

/// A stimulus that can be presented: a sample, or a manipulated texture made from one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Stimulus {
    /// Its name: `S2 INVERTED`.
    pub name: String,
    /// The sample that it was made from.
    pub source: String,
    /// The sample that it is expected to be declared as: `S13`.
    pub expected: String,
}

impl Stimulus {
    /// A sample itself, or its texture without manipulation.
    #[must_use]
    pub fn plain(sample: &str) -> Self {
        Self {
            name: sample.into(),
            source: sample.into(),
            expected: sample.into(),
        }
    }

    /// A texture made from `source` that is expected to be declared as `expected`.
    #[must_use]
    pub fn manipulated(name: &str, source: &str, expected: &str) -> Self {
        Self {
            name: name.into(),
            source: source.into(),
            expected: expected.into(),
        }
    }

    /// Whether it is presented under the name of its sample.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.name == self.source
    }
}

/// What a protocol declares: the samples that can be answered and the stimuli that are presented.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Declared {
    /// The samples, in their order: the columns of a matrix.
    pub samples: Vec<String>,
    /// The stimuli, in their order: the rows of a matrix.
    pub stimuli: Vec<Stimulus>,
}

impl Declared {
    /// `samples` that are presented as they are.
    #[must_use]
    pub fn plain(samples: &[&str]) -> Self {
        Self {
            samples: samples.iter().map(|&name| name.into()).collect(),
            stimuli: samples.iter().map(|name| Stimulus::plain(name)).collect(),
        }
    }
}

/// Comparisons with a reference are answered with up to so many words.
const MOST_CHOICES: usize = 3;
/// Fewer answers can name no sample that was presented by being wrong.
const LEAST_CHOICES: usize = 10;

/// Answers that were checked, with what the protocol declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerTable {
    declared: Declared,
    answers: Vec<Answer>,
    rehearsals: usize,
    inferred: usize,
}

impl AnswerTable {
    /// `answers` to what is `declared`, without rehearsals. Where an answer does not state what was offered, it is what was
    /// presented or answered in the same task and set by anybody; without sets, all samples.
    ///
    /// # Errors
    /// [`AssociationError`] for no answers, names that are not declared or declared twice, an answer that was not offered, and a
    /// trial with two answers.
    pub fn new(declared: Declared, answers: Vec<Answer>) -> Result<Self, AssociationError> {
        check_declared(&declared)?;
        let all = answers.len();
        let mut answers: Vec<Answer> = answers
            .into_iter()
            .filter(|answer| answer.purpose == Purpose::Trial)
            .collect();
        let rehearsals = all - answers.len();
        if answers.is_empty() {
            let found = if all == 0 { "none" } else { "rehearsals only" };
            return Err(AssociationError::Empty { found });
        }
        refuse_forced_choices(&declared, &answers)?;
        let mut seen: BTreeMap<([&str; 5], Option<usize>), &str> = BTreeMap::new();
        for answer in &answers {
            check_names(&declared, answer)?;
            if let Some(first) = seen.insert(answer.key(), &answer.answered) {
                return Err(AssociationError::TrialTwice {
                    place: answer.place(),
                    first: first.into(),
                    second: answer.answered.clone(),
                });
            }
        }
        for answer in &mut answers {
            let mut once = BTreeSet::new();
            answer.offered.retain(|name| once.insert(name.clone()));
        }
        let inferred = infer_offered(&declared, &mut answers);
        for answer in &answers {
            if !answer.offered.contains(&answer.answered) {
                return Err(AssociationError::OutsideSet {
                    place: answer.place(),
                    offered: answer.offered.join(", "),
                    answered: answer.answered.clone(),
                });
            }
        }
        Ok(Self {
            declared,
            answers,
            rehearsals,
            inferred,
        })
    }

    /// What the protocol declares.
    #[must_use]
    pub fn declared(&self) -> &Declared {
        &self.declared
    }

    /// The answers that count, in their order; each states what was offered.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// How many rehearsals were excluded.
    #[must_use]
    pub fn rehearsals(&self) -> usize {
        self.rehearsals
    }

    /// The same with the answers that `of` makes of its own, and without those of which it makes none.
    pub(super) fn with_answers(&self, of: impl FnMut(&Answer) -> Option<Answer>) -> Self {
        Self {
            answers: self.answers.iter().filter_map(of).collect(),
            ..self.clone()
        }
    }

    /// For how many answers what was offered was inferred.
    #[must_use]
    pub fn inferred(&self) -> usize {
        self.inferred
    }
}

impl Answer {
    /// What makes it an answer of its own.
    fn key(&self) -> ([&str; 5], Option<usize>) {
        let names = [
            &*self.participant,
            &self.session,
            &self.task,
            &self.set,
            &self.trial,
        ];
        (names, self.position)
    }

    /// The trial in words.
    fn place(&self) -> String {
        let named = [
            ("participant", &self.participant),
            ("session", &self.session),
            ("task", &self.task),
            ("set", &self.set),
            ("trial", &self.trial),
        ];
        let parts: Vec<String> = named
            .iter()
            .filter(|(_, value)| !value.is_empty())
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        parts.join(", ")
    }
}

fn check_declared(declared: &Declared) -> Result<(), AssociationError> {
    if declared.samples.len() < 2 {
        return Err(AssociationError::TooFewSamples {
            found: declared.samples.len(),
        });
    }
    let names = declared.stimuli.iter().map(|stimulus| &stimulus.name);
    once(declared.samples.iter())?;
    once(names)?;
    for stimulus in &declared.stimuli {
        for sample in [&stimulus.source, &stimulus.expected] {
            if !declared.samples.contains(sample) {
                return Err(AssociationError::Unknown {
                    place: format!("stimulus {}", stimulus.name),
                    kind: "samples",
                    known: declared.samples.join(", "),
                    name: sample.clone(),
                });
            }
        }
    }
    Ok(())
}

fn once<'a>(names: impl Iterator<Item = &'a String>) -> Result<(), AssociationError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(AssociationError::DeclaredTwice { name: name.clone() });
        }
    }
    Ok(())
}

fn check_names(declared: &Declared, answer: &Answer) -> Result<(), AssociationError> {
    let unknown = |kind, known: Vec<&str>, name: &str| AssociationError::Unknown {
        place: answer.place(),
        kind,
        known: known.join(", "),
        name: name.into(),
    };
    let samples = || declared.samples.iter().map(String::as_str);
    let stimuli = || {
        declared
            .stimuli
            .iter()
            .map(|stimulus| stimulus.name.as_str())
    };
    if !stimuli().any(|name| name == answer.presented) {
        return Err(unknown("stimuli", stimuli().collect(), &answer.presented));
    }
    for name in std::iter::once(&answer.answered).chain(&answer.offered) {
        if !samples().any(|sample| sample == name) {
            return Err(unknown("samples", samples().collect(), name));
        }
    }
    Ok(())
}

/// Refuses answers by a few words, none of which names what was presented or is expected: comparisons with a reference.
fn refuse_forced_choices(declared: &Declared, answers: &[Answer]) -> Result<(), AssociationError> {
    let said: BTreeSet<&str> = answers.iter().map(|a| a.answered.as_str()).collect();
    let presented: BTreeSet<&str> = answers.iter().map(|a| a.presented.as_str()).collect();
    let few = (2..=MOST_CHOICES).contains(&said.len());
    let stimuli = declared.stimuli.iter();
    let mut stimuli = stimuli.filter(|stimulus| presented.contains(stimulus.name.as_str()));
    let names_one = stimuli.any(|stimulus| {
        let names = [&stimulus.name, &stimulus.source, &stimulus.expected];
        names.into_iter().any(|name| said.contains(name.as_str()))
    });
    if !few || names_one || presented.len() < 2 || answers.len() < LEAST_CHOICES {
        return Ok(());
    }
    let quoted = |names: BTreeSet<&str>| -> Vec<String> {
        names.into_iter().map(|name| format!("`{name}`")).collect()
    };
    let stimuli = quoted(presented);
    Err(AssociationError::ForcedChoices {
        answers: answers.len(),
        choices: quoted(said).join(", "),
        stimuli: match stimuli.len() {
            1..=3 => stimuli.join(", "),
            of => format!("{} and {} more", stimuli[..2].join(", "), of - 2),
        },
    })
}

/// States what was offered where it is not; returns for how many answers.
fn infer_offered(declared: &Declared, answers: &mut [Answer]) -> usize {
    let mut in_set: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for answer in answers.iter().filter(|answer| !answer.set.is_empty()) {
        let key = (answer.task.clone(), answer.set.clone());
        let found = in_set.entry(key).or_default();
        found.insert(answer.answered.clone());
        found.extend(answer.offered.iter().cloned());
        let presented = declared.stimuli.iter();
        let mut presented = presented.filter(|stimulus| stimulus.name == answer.presented);
        if let Some(stimulus) = presented.next() {
            found.extend([stimulus.source.clone(), stimulus.expected.clone()]);
        }
    }
    let mut inferred = 0;
    for answer in answers.iter_mut().filter(|a| a.offered.is_empty()) {
        inferred += 1;
        let key = (answer.task.clone(), answer.set.clone());
        let known = in_set.get(&key);
        let samples = declared.samples.iter();
        answer.offered = samples
            .filter(|sample| known.is_none_or(|known| known.contains(*sample)))
            .cloned()
            .collect();
    }
    inferred
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(trial: &str, presented: &str, answered: &str) -> Answer {
        Answer {
            participant: "P1".into(),
            task: "3".into(),
            set: "A".into(),
            trial: trial.into(),
            presented: presented.into(),
            answered: answered.into(),
            ..Answer::default()
        }
    }

    fn refused(answers: Vec<Answer>) -> String {
        let declared = Declared::plain(&["S1", "S2", "S3"]);
        AnswerTable::new(declared, answers).unwrap_err().to_string()
    }

    #[test]
    fn bad_answers_are_refused_with_what_to_do() {
        let check = |answers: Vec<Answer>, parts: &[&str]| {
            let text = refused(answers);
            for part in parts {
                assert!(text.contains(part), "no `{part}` in: {text}");
            }
        };
        check(vec![], &["no answers (none)", "at least one trial"]);
        let rehearsal = Answer {
            purpose: Purpose::Rehearsal,
            ..answer("1", "S1", "S1")
        };
        check(vec![rehearsal], &["rehearsals only"]);
        check(
            vec![answer("1", "S9", "S1")],
            &["declared stimuli", "`S9`", "declare it"],
        );
        check(vec![answer("1", "S1", "S9")], &["declared samples", "`S9`"]);
        let outside = Answer {
            offered: vec!["S1".into(), "S2".into()],
            ..answer("1", "S1", "S3")
        };
        check(
            vec![outside],
            &["offered (S1, S2)", "`S3`", "correct the answer"],
        );
        check(
            vec![answer("1", "S1", "S1"), answer("1", "S2", "S3")],
            &[
                "participant P1, task 3, set A, trial 1",
                "found two (`S1` and `S3`)",
            ],
        );
    }

    #[test]
    fn declarations_are_checked() {
        let of = |declared: Declared| AnswerTable::new(declared, vec![answer("1", "S1", "S1")]);
        let twice = of(Declared::plain(&["S1", "S1"])).unwrap_err();
        assert_eq!(twice, AssociationError::DeclaredTwice { name: "S1".into() });
        let few = of(Declared::plain(&["S1"])).unwrap_err();
        assert_eq!(few, AssociationError::TooFewSamples { found: 1 });
        let mut wrong = Declared::plain(&["S1", "S2"]);
        let inverted = Stimulus::manipulated("S2 INVERTED", "S2", "S13");
        wrong.stimuli.push(inverted);
        let text = of(wrong).unwrap_err().to_string();
        assert!(
            text.contains("stimulus S2 INVERTED") && text.contains("`S13`"),
            "{text}"
        );
    }

    #[test]
    fn what_was_offered_follows_from_the_set() {
        let declared = Declared::plain(&["S1", "S2", "S3", "S4"]);
        let answers = vec![answer("1", "S1", "S2"), answer("2", "S4", "S4")];
        let table = AnswerTable::new(declared.clone(), answers).unwrap();
        assert_eq!(table.answers()[0].offered, ["S1", "S2", "S4"]);
        assert_eq!(table.inferred(), 2);
        let alone = Answer {
            set: String::new(),
            ..answer("1", "S1", "S2")
        };
        let table = AnswerTable::new(declared, vec![alone]).unwrap();
        assert_eq!(table.answers()[0].offered.len(), 4);
    }
}
