//! The trials of a task.

use super::super::protocol::{
    Adaptive, Block, Catch, FixedTest, Labels, Method, Protocol, Question, Sequence, Task,
    TaskKind, Training,
};
use super::super::random::Stream;
use super::{
    AnswerForm, Group, Interval, Planner, Presented, Trial, TrialKind, balanced_orders, undeclared,
};
use crate::campaign::protocol::ProtocolError;

impl<'a> Planner<'a> {
    /// Adds the trials of `task` over `group`: training, then the counted ones with catch trials among them. Each has a stream of
    /// its own.
    pub(super) fn task(
        &mut self,
        block: &'a Block,
        task: &'a Task,
        group: Group<'a>,
        name: &str,
    ) -> Result<(), ProtocolError> {
        let place = Place {
            protocol: self.protocol,
            block,
            task,
            group,
            name,
        };
        if let Some(training) = &task.training
            && self.trained.insert(&task.name)
        {
            let stream = self.stream(&["training", name]);
            let trials = place.training(stream, *training)?;
            self.trials.extend(trials);
        }
        let mut trials = place.counted(&mut self.stream(&["trial", name]))?;
        if let TaskKind::Associate {
            sequence: Sequence::Balanced,
            ..
        } = &task.kind
        {
            self.balance(block, name, &mut trials);
        }
        if let Some(catch) = &task.catch {
            place.mix(catch, self.stream(&["catch", name]), &mut trials)?;
        }
        if let Some(adaptive) = place.adaptive() {
            self.runs.insert(name.to_owned(), adaptive.clone());
        }
        self.trials.extend(trials);
        match self.trials.len() <= MOST_TRIALS {
            true => Ok(()),
            false => Err(ProtocolError::TooLong {
                session: self.request.session.to_owned(),
            }),
        }
    }
}

/// No session has more trials: at one second each they take a day.
pub(in crate::campaign) const MOST_TRIALS: usize = 86_400;

impl Planner<'_> {
    /// Puts the stimuli of each of `trials` in the order that the fewest completed sessions had, of those with the same order of tasks.
    fn balance(&mut self, block: &Block, name: &str, trials: &mut [Trial]) {
        let cell = match self.cells.get(&format!("{}.tasks", block.name)) {
            Some(tasks) => format!("{name}.stimuli of tasks {tasks}"),
            None => format!("{name}.stimuli"),
        };
        for trial in trials {
            if let Presented::Rendered { stimuli } = &mut trial.presented {
                let mut orders = balanced_orders(stimuli.len());
                let order = orders.swap_remove(self.rarest(&cell, orders.len()));
                *stimuli = order.into_iter().map(|i| stimuli[i].clone()).collect();
            }
        }
    }
}

/// A task over a group, with the name that its trials begin with.
#[derive(Clone, Copy)]
struct Place<'a> {
    protocol: &'a Protocol,
    block: &'a Block,
    task: &'a Task,
    group: Group<'a>,
    name: &'a str,
}

impl Place<'_> {
    fn adaptive(&self) -> Option<&Adaptive> {
        match &self.task.kind {
            TaskKind::Compare {
                method: Method::Adaptive(adaptive),
                ..
            } => Some(adaptive),
            _ => None,
        }
    }

    fn trial(&self, name: String, presented: Presented, answer: AnswerForm) -> Trial {
        Trial {
            name,
            block: self.block.name.clone(),
            task: self.task.name.clone(),
            set: self.group.set.map(str::to_owned),
            kind: TrialKind::Counted,
            presented,
            answer,
        }
    }

    /// Trials of the same form as the counted ones, with independently drawn stimuli; in an adaptive run the levels are drawn at random.
    fn training(
        &self,
        mut stream: Stream,
        training: Training,
    ) -> Result<Vec<Trial>, ProtocolError> {
        let count = training.trials as usize;
        let mut trials: Vec<Trial> = Vec::new();
        while trials.len() < count {
            let mut more = self.counted(&mut stream)?;
            more.retain(|trial| trial.answer != AnswerForm::Done);
            if more.is_empty() {
                break;
            }
            trials.extend(more);
        }
        trials.truncate(count);
        for (i, trial) in trials.iter_mut().enumerate() {
            trial.name = format!("{}.training {}", self.name, i + 1);
            let mut right = None;
            if let (Presented::Chosen { standard, .. }, Some(adaptive)) =
                (&trial.presented, self.adaptive())
            {
                let drawn = adaptive.levels.get(stream.below(adaptive.levels.len()));
                let level = drawn.ok_or_else(|| undeclared(&self.task.name))?;
                right = Some(vec![comparison_is(*standard).to_owned()]);
                let stimuli = standard.pair(&adaptive.standard, &level.stimulus);
                trial.presented = Presented::Rendered { stimuli };
            }
            let right = right.or_else(|| self.right(trial.presented.names()));
            trial.kind = TrialKind::Training {
                feedback: right.filter(|_| training.feedback),
            };
        }
        Ok(trials)
    }

    /// Puts catch trials among `trials`, each before one of them, so that none is left over when an adaptive run ends early.
    fn mix(
        &self,
        catch: &Catch,
        mut stream: Stream,
        trials: &mut Vec<Trial>,
    ) -> Result<(), ProtocolError> {
        let fitting: Vec<&Vec<String>> = catch.known.iter().filter(|one| self.fits(one)).collect();
        let Some(answer) = trials.first().map(|trial| trial.answer.clone()) else {
            return Ok(());
        };
        if fitting.is_empty() {
            return Err(ProtocolError::NoSequence {
                task: self.task.name.clone(),
                set: self.group.set.unwrap_or("of all samples").to_owned(),
            });
        }
        let mut places: Vec<usize> = (0..catch.trials)
            .map(|_| stream.below(trials.len()))
            .collect();
        places.sort_unstable();
        let mut mixed = Vec::with_capacity(trials.len() + places.len());
        let mut caught = 0;
        for (i, trial) in trials.drain(..).enumerate() {
            while places.get(caught) == Some(&i) {
                let mut stimuli = fitting[stream.below(fitting.len())].clone();
                let right = match self.right(&stimuli) {
                    Some(right) => right,
                    // The first of the pair is the right answer, wherever it is presented.
                    None => match stream.below(2) {
                        0 => vec!["first".to_owned()],
                        _ => {
                            stimuli.reverse();
                            vec!["second".to_owned()]
                        }
                    },
                };
                caught += 1;
                mixed.push(Trial {
                    kind: TrialKind::Catch { right },
                    ..self.trial(
                        format!("{}.catch {caught}", self.name),
                        Presented::Rendered { stimuli },
                        answer.clone(),
                    )
                });
            }
            mixed.push(trial);
        }
        *trials = mixed;
        Ok(())
    }

    /// Whether all stimuli can be answered within the group.
    fn fits(&self, stimuli: &[String]) -> bool {
        let within = |stimulus: &String| {
            let expected = self.protocol.expected(stimulus);
            expected.is_some_and(|expected| self.group.samples.iter().any(|one| one == expected))
        };
        !matches!(self.task.kind, TaskKind::Associate { .. }) || stimuli.iter().all(within)
    }

    /// The right answer to stimuli, where it follows from their names.
    fn right(&self, stimuli: &[String]) -> Option<Vec<String>> {
        match &self.task.kind {
            TaskKind::Associate { .. } => {
                let expected = |stimulus| self.protocol.expected(stimulus).map(str::to_owned);
                stimuli.iter().map(|stimulus| expected(stimulus)).collect()
            }
            TaskKind::Compare {
                question: Question::SameDifferent,
                ..
            } => Some(vec![
                match stimuli.iter().all(|one| *one == stimuli[0]) {
                    true => "same",
                    false => "different",
                }
                .to_owned(),
            ]),
            _ => None,
        }
    }

    fn association_answer(&self, labels: &Labels) -> AnswerForm {
        match labels {
            Labels::Names => AnswerForm::Each {
                choices: self.group.samples.to_vec(),
            },
            Labels::OwnOrder { task: order } => {
                let own = format!("{}.{}", self.block.name, self.task.name);
                let ordered = format!("{}.{order}", self.block.name);
                AnswerForm::EachOfOrder {
                    trial: self.name.replacen(&own, &ordered, 1),
                }
            }
        }
    }

    /// The counted trials.
    fn counted(&self, stream: &mut Stream) -> Result<Vec<Trial>, ProtocolError> {
        let Self {
            task, group, name, ..
        } = *self;
        let mut trials = Vec::new();
        let mut add = |name: String, presented: Presented, answer: AnswerForm| {
            trials.push(self.trial(name, presented, answer));
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
                let answer = self.association_answer(labels);
                for (i, stimuli) in sequences(sequence, task, group, stream)?
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
                question, method, ..
            } => {
                let choices = question.choices().map(str::to_owned).to_vec();
                for (at, presented) in comparisons(method, name, stream).into_iter().enumerate() {
                    let choices = choices.clone();
                    add(
                        format!("{name}.{}", at + 1),
                        presented,
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
            TaskKind::Rate { from, to, .. } => {
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
        Ok(trials)
    }
}

/// What the trials of a comparison present, in their order.
fn comparisons(method: &Method, name: &str, stream: &mut Stream) -> Vec<Presented> {
    match method {
        Method::Constant { pairs, repeats } => {
            let mut all: Vec<[String; 2]> = Vec::new();
            for _ in 0..*repeats {
                for [first, second] in pairs {
                    all.push([first.clone(), second.clone()]);
                    all.push([second.clone(), first.clone()]);
                }
            }
            stream.shuffle(&mut all);
            let rendered = |pair: [String; 2]| Presented::Rendered {
                stimuli: pair.to_vec(),
            };
            all.into_iter().map(rendered).collect()
        }
        Method::Adaptive(adaptive) => (1..=adaptive.rule.at_most())
            .map(|_| Presented::Chosen {
                standard: match stream.below(2) {
                    0 => Interval::First,
                    _ => Interval::Second,
                },
                run: name.to_owned(),
            })
            .collect(),
    }
}

/// The answer that names the comparison, with the standard in `standard`.
fn comparison_is(standard: Interval) -> &'static str {
    match standard {
        Interval::First => "second",
        Interval::Second => "first",
    }
}

/// The sequences of an association for one set.
fn sequences(
    sequence: &Sequence,
    task: &Task,
    group: Group<'_>,
    stream: &mut Stream,
) -> Result<Vec<Vec<String>>, ProtocolError> {
    let samples = group.samples;
    match sequence {
        // Put in order by the planner.
        Sequence::Balanced => Ok(vec![samples.to_vec()]),
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
                true => Err(ProtocolError::NoSequence {
                    task: task.name.clone(),
                    set: group.set.unwrap_or("of all samples").to_owned(),
                }),
            }
        }
    }
}
