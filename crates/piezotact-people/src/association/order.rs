//! Tasks in which samples are put in order: places, dominance and Kendall's τ.
//!
//! One sample moved from the first to the last place shifts all others: no sample keeps its place, while most pairs keep their order.
//! So the matrix of places stands beside the matrix of pairs and τ.

use crate::association::AssociationError;
use std::collections::{BTreeMap, BTreeSet};

use piezotact::statistics::mean_interval;
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};
use super::matrix::{FlaggedTrials, MatrixConfig, selected};
use crate::interval::MIN_PARTICIPANTS;

/// One order that a participant made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Repetition {
    /// The participant.
    pub participant: String,
    /// The session.
    pub session: String,
    /// The set.
    pub set: String,
    /// The samples in the order that they were put in.
    pub order: Vec<String>,
    /// Kendall's `tau_b` with the declared order, −1–1; `None` for a single sample.
    pub tau: Option<f64>,
    /// How many samples are in their declared place.
    pub in_place: usize,
}

/// How often one sample was put before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Dominance {
    /// How often it was put before the other.
    pub before: usize,
    /// How often the two were ordered together; at 0 the pair is untested.
    pub together: usize,
}

/// The orders of one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Ordering {
    /// The task.
    pub task: String,
    /// The samples in their declared order.
    pub samples: Vec<String>,
    /// Every order that was made.
    pub repetitions: Vec<Repetition>,
    /// How many orders were left out, as one of their trials is flagged.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out: usize,
    /// For each sample how often it stood in each place of its set; row by row.
    pub places: Vec<Vec<usize>>,
    /// For each pair how often the sample of the row was put before that of the column; row by row.
    pub dominance: Vec<Vec<Dominance>>,
    /// The mean of `tau_b` over participants, each the mean of its orders; `None` where no order has one.
    pub mean_tau: Option<f64>,
    /// Its 95 % interval over participants (Student's t); `None` for fewer than three, or where all agree.
    pub tau_interval: Option<[f64; 2]>,
    /// How many samples stand in their declared place.
    pub in_place: usize,
    /// How many samples were placed.
    pub placed: usize,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes the field by reference"
)]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl Ordering {
    /// What was found in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let interval = self.tau_interval.map_or_else(
            || "no interval".to_owned(),
            |[low, high]| format!("95 %: {low:.3} to {high:.3}"),
        );
        let tau = self.mean_tau.map_or_else(
            || "no τ: single samples have no order".to_owned(),
            |tau| format!("mean Kendall τ over participants {tau:.3} ({interval})"),
        );
        let count = self.repetitions.len();
        let left_out = match self.left_out {
            0 => String::new(),
            orders => format!("; {orders} with flagged trials left out"),
        };
        format!(
            "task {}: {count} order{}: {tau}; {} of {} samples in their place (guessing: {count} on average){left_out}",
            self.task,
            if count == 1 { "" } else { "s" },
            self.in_place,
            self.placed
        )
        .replace('-', "−")
    }
}

/// Kendall's `tau_b` of two lists of the same length, −1–1; `None` for fewer than two pairs of values or where one never changes.
///
/// Formula: (C − D)/√((n₀ − n₁)(n₀ − n₂)), of n₀ = n(n − 1)/2 pairs C in the same and D in the opposite order, n₁ and n₂ tied.
///
/// Source: M. G. Kendall (1945), Biometrika 33; as SciPy's `kendalltau`.
///
/// ```
/// use piezotact_people::association::kendall_tau_b;
/// // The first of 14 moved to the end: 13 of 91 pairs change their order.
/// let declared: Vec<f64> = (0..14).map(f64::from).collect();
/// let made: Vec<f64> = (0..14).map(|i| f64::from((i + 13) % 14)).collect();
/// assert!((kendall_tau_b(&declared, &made).unwrap() - 65.0 / 91.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn kendall_tau_b(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() != b.len() || a.iter().chain(b).any(|value| value.is_nan()) {
        return None;
    }
    let (mut score, mut of_a, mut of_b) = (0.0, 0.0, 0.0);
    let sign = |x: f64, y: f64| match x.total_cmp(&y) {
        std::cmp::Ordering::Less => -1.0,
        std::cmp::Ordering::Equal => 0.0,
        std::cmp::Ordering::Greater => 1.0,
    };
    for i in 0..a.len() {
        for j in 0..i {
            let (x, y): (f64, f64) = (sign(a[i], a[j]), sign(b[i], b[j]));
            score += x * y;
            of_a += x.abs();
            of_b += y.abs();
        }
    }
    let pairs: f64 = of_a * of_b;
    (pairs > 0.0).then(|| score / pairs.sqrt())
}

/// The orders of `task` among the answers that `config` selects. In one repetition (a participant, a session and a set) every sample
/// is presented once and answered once: to answer S5 for S3 puts S3 in the place of S5. Where flagged trials are left out, a
/// repetition with one of them is left out whole, as the others alone are no order.
///
/// Source: thesis 2.6.1 and 2.6.2, task 1 and 2; docs/decisions/answers.md.
///
/// # Errors
/// [`AssociationError`] where the task has no answers or is not the selected one, where all its orders are left out, and where the answers
/// of a repetition are no order of what was presented.
pub fn ordering(
    table: &AnswerTable,
    config: &MatrixConfig,
    task: &str,
) -> Result<Ordering, AssociationError> {
    if let Some(selected) = config.selection.task.as_ref().filter(|only| *only != task) {
        return Err(AssociationError::OtherTask {
            task: task.into(),
            selected: selected.clone(),
        });
    }
    let samples = &table.declared().samples;
    let mut groups: BTreeMap<[&str; 3], Vec<&Answer>> = BTreeMap::new();
    let all = MatrixConfig {
        flagged: FlaggedTrials::Kept,
        ..config.clone()
    };
    for answer in selected(table, &all).filter(|answer| answer.task == task) {
        let key = [&*answer.participant, &*answer.session, &*answer.set];
        groups.entry(key).or_default().push(answer);
    }
    let found = groups.len();
    if config.flagged == FlaggedTrials::LeftOut {
        groups.retain(|_, answers| answers.iter().all(|answer| answer.flags.is_empty()));
    }
    let left_out = found - groups.len();
    if left_out > 0 && groups.is_empty() {
        return Err(AssociationError::OrdersOnlyFlagged {
            task: task.into(),
            orders: left_out,
        });
    }
    if groups.is_empty() {
        let known: BTreeSet<&str> = selected(table, &all).map(|a| a.task.as_str()).collect();
        let known: Vec<&str> = known.into_iter().collect();
        return Err(AssociationError::NoOrders {
            task: task.into(),
            known: known.join(", "),
        });
    }
    let count = samples.len();
    let mut places = vec![vec![0; count]; count];
    let none = Dominance {
        before: 0,
        together: 0,
    };
    let mut dominance = vec![vec![none; count]; count];
    let mut repetitions = Vec::new();
    for ([participant, session, set], answers) in groups {
        let no_order = |name: &str, found| AssociationError::NoOrder {
            task: task.into(),
            participant: participant.into(),
            set: set.into(),
            name: name.into(),
            found,
        };
        let made = order_of(samples, &answers, &no_order)?;
        let mut declared = made.clone();
        declared.sort_unstable();
        let ranks: Vec<f64> = made.iter().map(|sample| *sample as f64).collect();
        let in_order: Vec<f64> = (0..made.len()).map(|place| place as f64).collect();
        for (place, sample) in made.iter().enumerate() {
            places[*sample][place] += 1;
            for other in &made[place + 1..] {
                dominance[*sample][*other].before += 1;
                dominance[*sample][*other].together += 1;
                dominance[*other][*sample].together += 1;
            }
        }
        repetitions.push(Repetition {
            participant: participant.into(),
            session: session.into(),
            set: set.into(),
            in_place: made.iter().zip(&declared).filter(|(a, b)| a == b).count(),
            tau: kendall_tau_b(&in_order, &ranks),
            order: made.iter().map(|sample| samples[*sample].clone()).collect(),
        });
    }
    let (mean_tau, tau_interval) = mean_over_people(&repetitions);
    Ok(Ordering {
        task: task.into(),
        samples: samples.clone(),
        in_place: repetitions.iter().map(|r| r.in_place).sum(),
        placed: repetitions.iter().map(|r| r.order.len()).sum(),
        repetitions,
        left_out,
        places,
        dominance,
        mean_tau,
        tau_interval,
    })
}

/// The samples of one repetition, by their place in `samples`, in the order that they were put in.
fn order_of(
    samples: &[String],
    answers: &[&Answer],
    no_order: &dyn Fn(&str, &'static str) -> AssociationError,
) -> Result<Vec<usize>, AssociationError> {
    let at = |name: &str| samples.iter().position(|sample| sample == name);
    let mut by_answer: BTreeMap<usize, usize> = BTreeMap::new();
    let mut presented = BTreeSet::new();
    for answer in answers {
        let Some(sample) = at(&answer.presented) else {
            return Err(no_order(&answer.presented, "that is no sample"));
        };
        let Some(place) = at(&answer.answered) else {
            return Err(no_order(&answer.answered, "that is no sample"));
        };
        if !presented.insert(sample) {
            return Err(no_order(&answer.presented, "presented twice"));
        }
        if by_answer.insert(place, sample).is_some() {
            return Err(no_order(&answer.answered, "answered twice"));
        }
    }
    if let Some(place) = by_answer.keys().find(|place| !presented.contains(place)) {
        return Err(no_order(&samples[*place], "answered, but not presented"));
    }
    Ok(by_answer.into_values().collect())
}

/// The mean over participants of the mean `tau_b` of each, with its interval.
fn mean_over_people(repetitions: &[Repetition]) -> (Option<f64>, Option<[f64; 2]>) {
    let mut people: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for repetition in repetitions {
        let taus = people.entry(&repetition.participant).or_default();
        taus.extend(repetition.tau);
    }
    let means = people.values().filter(|taus| !taus.is_empty());
    let means: Vec<f64> = means
        .map(|taus| taus.iter().sum::<f64>() / taus.len() as f64)
        .collect();
    if means.is_empty() {
        return (None, None);
    }
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    // People who all agree leave their differences unknown.
    let interval = mean_interval(&means)
        .filter(|[low, high]| means.len() >= MIN_PARTICIPANTS && high > low)
        .map(|ends| ends.map(|tau| tau.clamp(-1.0, 1.0)));
    (Some(mean), interval)
}
