//! The trials of a task.

use super::super::protocol::{Block, FixedTest, Labels, Question, Sequence, Task, TaskKind};
use super::super::random::Stream;
use super::{AnswerForm, Group, PlanError, Planner, Presented, Trial};

impl<'a> Planner<'a> {
    pub(super) fn task(
        &mut self,
        block: &'a Block,
        task: &'a Task,
        group: Group<'a>,
        name: &str,
    ) -> Result<(), PlanError> {
        let mut stream = self.stream(&["trial", name]);
        let mut add = |name: String, presented: Presented, answer: AnswerForm| {
            self.trials.push(Trial {
                name,
                block: block.name.clone(),
                task: task.name.clone(),
                set: group.set.map(str::to_owned),
                presented,
                answer,
            });
        };
        let mut shuffled = |samples: &[String]| {
            let mut samples = samples.to_vec();
            stream.shuffle(&mut samples);
            samples
        };
        let samples = group.samples;
        match &task.kind {
            TaskKind::Touch { .. } => {
                for sample in shuffled(samples) {
                    add(
                        format!("{name}.{sample}"),
                        Presented::Sample { sample },
                        AnswerForm::Done,
                    );
                }
            }
            TaskKind::Identify { presentations } => {
                let tray = shuffled(samples);
                add(
                    format!("{name}.learn"),
                    Presented::Tray { samples: tray },
                    AnswerForm::Done,
                );
                let all: Vec<String> = (0..*presentations).flat_map(|_| samples.to_vec()).collect();
                for (i, sample) in shuffled(&all).into_iter().enumerate() {
                    let choices = samples.to_vec();
                    add(
                        format!("{name}.{}", i + 1),
                        Presented::Sample { sample },
                        AnswerForm::OneOf { choices },
                    );
                }
            }
            TaskKind::Order { from, to, .. } => {
                let tray = shuffled(samples);
                let answer = AnswerForm::Order {
                    samples: samples.to_vec(),
                    from: from.clone(),
                    to: to.clone(),
                };
                add(name.to_owned(), Presented::Tray { samples: tray }, answer);
            }
            TaskKind::Associate { sequence, labels } => {
                let answer = match labels {
                    Labels::Names => AnswerForm::Each {
                        choices: samples.to_vec(),
                    },
                    Labels::OwnOrder { task: order } => {
                        let own = format!("{}.{}", block.name, task.name);
                        let trial = name.replacen(&own, &format!("{}.{order}", block.name), 1);
                        AnswerForm::EachOfOrder { trial }
                    }
                };
                for (i, stimuli) in sequences(sequence, task, group, &mut stream)?
                    .into_iter()
                    .enumerate()
                {
                    let name = match sequence {
                        Sequence::Fixed { .. } => format!("{name}.test {}", i + 1),
                        _ => name.to_owned(),
                    };
                    add(name, Presented::Rendered { stimuli }, answer.clone());
                }
            }
            TaskKind::Compare {
                question,
                pairs,
                repeats,
            } => {
                let mut all: Vec<[String; 2]> = Vec::new();
                for _ in 0..*repeats {
                    for [first, second] in pairs {
                        all.push([first.clone(), second.clone()]);
                        all.push([second.clone(), first.clone()]);
                    }
                }
                stream.shuffle(&mut all);
                let choices = match question {
                    Question::SameDifferent => ["same", "different"],
                    Question::Rougher => ["first", "second"],
                };
                for (i, pair) in all.into_iter().enumerate() {
                    let choices = choices.map(str::to_owned).to_vec();
                    let stimuli = pair.to_vec();
                    add(
                        format!("{name}.{}", i + 1),
                        Presented::Rendered { stimuli },
                        AnswerForm::OneOf { choices },
                    );
                }
            }
            TaskKind::Categorise {
                descriptors,
                at_most,
            } => {
                for sample in shuffled(samples) {
                    let answer = AnswerForm::Some {
                        choices: descriptors.clone(),
                        at_most: *at_most as usize,
                    };
                    add(
                        format!("{name}.{sample}"),
                        Presented::Sample { sample },
                        answer,
                    );
                }
            }
            TaskKind::Rate { from, to } => {
                for sample in shuffled(samples) {
                    let answer = AnswerForm::Scale {
                        from: *from,
                        to: *to,
                    };
                    add(
                        format!("{name}.{sample}"),
                        Presented::Sample { sample },
                        answer,
                    );
                }
            }
        }
        Ok(())
    }
}

/// The sequences of an association for one set.
fn sequences(
    sequence: &Sequence,
    task: &Task,
    group: Group<'_>,
    stream: &mut Stream,
) -> Result<Vec<Vec<String>>, PlanError> {
    let samples = group.samples;
    match sequence {
        Sequence::Permutation => {
            let mut stimuli = samples.to_vec();
            stream.shuffle(&mut stimuli);
            Ok(vec![stimuli])
        }
        Sequence::Drawn { lengths } => {
            let length = lengths[stream.below(lengths.len())];
            let stimuli = (0..length).map(|_| samples[stream.below(samples.len())].clone());
            Ok(vec![stimuli.collect()])
        }
        Sequence::Fixed { tests } => {
            let of_set = |test: &&FixedTest| Some(test.set.as_str()) == group.set;
            let found: Vec<Vec<String>> = tests
                .iter()
                .filter(of_set)
                .map(|test| test.stimuli.clone())
                .collect();
            match found.is_empty() {
                false => Ok(found),
                true => Err(PlanError::NoSequence {
                    task: task.name.clone(),
                    set: group.set.unwrap_or("of all samples").to_owned(),
                }),
            }
        }
    }
}
