//! Contrasts of tasks, and their order.

use piezotact::Warning;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::statistics::holm;

use super::people::{People, unequal};
use super::power::power_of;
use super::{
    ALL_SURFACES, Gradient, GroupConfig, GroupCriterion, LEVEL, PersonChange, TaskChanges,
    TaskContrast,
};
use crate::eeg::EegWarning;
use crate::eeg::contrast::{Contrast, paired};
use crate::eeg::erd::Mode;

/// Differences of people scatter by a good part of their mean: beyond this they are hardly of different people.
const TOO_ALIKE: f64 = 20.0;

/// The unit of a difference, as criteria state it.
pub(super) fn unit_of(mode: Mode) -> &'static str {
    match mode {
        Mode::Percent => "points",
        Mode::Decibels => "dB",
    }
}

/// All contrasts of two tasks, with probabilities adjusted by Holm among those of single surfaces, and among those of their means.
pub(super) fn contrasts(
    people: &People<'_>,
    changes: &[TaskChanges],
    config: &GroupConfig,
) -> Vec<TaskContrast> {
    let mut found = Vec::new();
    for first in changes {
        for pair in people.pairs() {
            let second = changes
                .iter()
                .find(|other| other.task == pair[1] && is_beside(first, other));
            if let (true, Some(second)) = (first.task == pair[0], second) {
                found.push(contrast(first, second));
            }
        }
    }
    for of_mean in [false, true] {
        let own: Vec<usize> = (0..found.len())
            .filter(|i| (found[*i].surface == ALL_SURFACES) == of_mean)
            .filter(|i| found[*i].contrast.is_some())
            .collect();
        let over = own.len();
        let p = |of: fn(&TaskContrast) -> Option<f64>| {
            // Without a number nothing is shown: 1.
            let all = own.iter().map(|i| of(&found[*i]).unwrap_or(1.0));
            holm(&all.collect::<Vec<_>>())
        };
        let (of_changes, of_powers) = (p(of_change), p(of_power));
        for ((i, p), of_power) in own.into_iter().zip(of_changes).zip(of_powers) {
            found[i].p_holm = Some(p);
            found[i].power_p_holm = found[i].window.map(|_| of_power);
            found[i].holm_over = over;
        }
    }
    let withheld = config.unit == Mode::Percent && unequal(&people.epochs()).is_some();
    for one in &mut found {
        one.criteria = criteria(one, config);
        if withheld {
            // The bias of a percentage follows the number of epochs: a difference may be of that alone.
            for criterion in &mut one.criteria {
                criterion.outcome = Outcome::NotDecided;
            }
        }
    }
    found
}

/// The probability of a difference of changes.
fn of_change(one: &TaskContrast) -> Option<f64> {
    Some(one.contrast?.difference.p_value)
}

/// The probability of differences of power as far in the direction of that of the changes: of one side, as the direction is given, and the
/// larger of that in the window and that from baseline to window.
fn of_power(one: &TaskContrast) -> Option<f64> {
    let change = one.contrast?.difference;
    let [window, step] = [one.window?, one.step?].map(|found| {
        let difference = found.difference;
        match change.mean * difference.mean > 0.0 {
            true => 0.5 * difference.p_value,
            false => 1.0 - 0.5 * difference.p_value,
        }
    });
    Some(window.max(step))
}

/// Whether two are of the same surface, region and band.
fn is_beside(a: &TaskChanges, b: &TaskChanges) -> bool {
    (&a.surface, &a.region, &a.band) == (&b.surface, &b.region, &b.band)
}

/// People who have both.
fn both<'c>(first: &'c TaskChanges, second: &'c TaskChanges) -> Vec<[&'c PersonChange; 2]> {
    let of = |one: &'c PersonChange| {
        let mut others = second.people.iter();
        let other = others.find(|other| other.participant == one.participant)?;
        Some([one, other])
    };
    first.people.iter().filter_map(of).collect()
}

/// The power in the window less that in the baseline of one task, % of the baseline of both (the mean of their dB).
fn step_percent(pair: [&PersonChange; 2], at: usize) -> f64 {
    let both_db = 0.5 * (pair[0].baseline_db + pair[1].baseline_db);
    let [window, baseline] =
        [pair[at].window_db, pair[at].baseline_db].map(|db| power_of(db - both_db));
    100.0 * (window - baseline)
}

fn contrast(first: &TaskChanges, second: &TaskChanges) -> TaskContrast {
    let pairs = both(first, second);
    let of_pairs = |value: &dyn Fn([&PersonChange; 2], usize) -> f64| {
        let [a, b] = [0, 1].map(|at| {
            pairs
                .iter()
                .map(|pair| value(*pair, at))
                .collect::<Vec<_>>()
        });
        paired(&a, &b).ok()
    };
    let of = |value: fn(&PersonChange) -> f64| of_pairs(&|pair, at| value(pair[at]));
    TaskContrast {
        tasks: [first.task.clone(), second.task.clone()],
        surface: first.surface.clone(),
        region: first.region.clone(),
        band: first.band.clone(),
        people: pairs
            .iter()
            .map(|pair| pair[0].participant.clone())
            .collect(),
        contrast: of(|one| one.change),
        p_holm: None,
        holm_over: 0,
        baseline: of(|one| one.baseline_db),
        window: of(|one| one.window_db),
        step: of_pairs(&step_percent),
        power_p_holm: None,
        criteria: Vec::new(),
    }
}

fn criteria(one: &TaskContrast, config: &GroupConfig) -> Vec<Criterion<GroupCriterion>> {
    let place = format!("{}, {}, {}", one.surface, one.region, one.band);
    let (tasks, limit) = (one.tasks.clone(), Limit::at_most(LEVEL));
    let what = GroupCriterion::Differ {
        tasks: tasks.clone(),
        place: place.clone(),
    };
    let mut differ = match one.p_holm {
        Some(p) => Criterion::new(what, "", p, None, limit),
        None => Criterion::unmeasured(what, "", limit),
    };
    let what = GroupCriterion::PowerDiffers {
        tasks: tasks.clone(),
        place: place.clone(),
    };
    let mut of_power = match one.power_p_holm {
        Some(p) => Criterion::new(what, "", p, None, limit),
        None => Criterion::unmeasured(what, "", limit),
    };
    // A large p does not show that tasks are alike.
    if of_power.outcome == Outcome::NotMet {
        of_power.outcome = Outcome::NotDecided;
    }
    // Nor does a small one show that they differ where their baselines, or added noise, may be all that does.
    if differ.outcome == Outcome::NotMet || of_power.outcome != Outcome::Met {
        differ.outcome = Outcome::NotDecided;
    }
    let mut all = vec![differ, of_power];
    if let Some(reach) = config.margin {
        let (limit, unit) = (Limit::Within { reach }, unit_of(config.unit));
        let what = GroupCriterion::Alike { tasks, place };
        let mut alike = match &one.contrast {
            Some(found) => {
                let difference = found.difference;
                Criterion::new(
                    what,
                    unit,
                    difference.mean,
                    Some(difference.interval),
                    limit,
                )
            }
            None => Criterion::unmeasured(what, unit, limit),
        };
        // Other baselines, or noise in one task, can hide a difference as they can make one.
        let differs = |found: Contrast| found.difference.p_value <= LEVEL;
        if alike.outcome == Outcome::Met && one.baseline.is_some_and(differs) {
            alike.outcome = Outcome::NotDecided;
        }
        all.push(alike);
    }
    all
}

/// The claimed order of tasks in each region and band: of the mean of surfaces, or of the only one.
pub(super) fn gradients(
    people: &People<'_>,
    contrasts: &[TaskContrast],
    config: &GroupConfig,
) -> Vec<Gradient> {
    if config.gradient.is_empty() {
        return Vec::new();
    }
    let surface = people.surfaces_and_mean().pop().unwrap_or_default();
    let mut found = Vec::new();
    for band in &people.first.config.bands {
        for region in &people.first.config.regions {
            let of = |pair: &[String]| {
                let mut own = contrasts.iter();
                // Tasks stand in the claimed order, so that a contrast is the later one less the earlier one.
                own.find(|one| {
                    one.tasks == pair
                        && (&one.surface, &one.region, &one.band)
                            == (&surface, &region.name, &band.name)
                })
            };
            let step = |pair: &[String]| {
                let what = GroupCriterion::Below {
                    tasks: [pair[0].clone(), pair[1].clone()],
                    place: format!("{surface}, {}, {}", region.name, band.name),
                };
                below(what, of(pair), config.unit)
            };
            found.push(Gradient {
                tasks: config.gradient.clone(),
                region: region.name.clone(),
                band: band.name.clone(),
                criteria: config.gradient.windows(2).map(step).collect(),
            });
        }
    }
    found
}

/// Whether the first task of a contrast is more desynchronised: decided where its p after Holm decides.
fn below(
    what: GroupCriterion,
    contrast: Option<&TaskContrast>,
    unit: Mode,
) -> Criterion<GroupCriterion> {
    let (unit, limit) = (unit_of(unit), Limit::at_least(0.0));
    let measured = contrast.and_then(|one| Some((one.contrast?.difference, one.p_holm?)));
    let Some((difference, p)) = measured else {
        return Criterion::unmeasured(what, unit, limit);
    };
    let mut step = Criterion::new(
        what,
        unit,
        difference.mean,
        Some(difference.interval),
        limit,
    );
    let decided = contrast.is_some_and(|one| one.outcome() == Outcome::Met);
    if p > LEVEL || !decided {
        step.outcome = Outcome::NotDecided;
    }
    step
}

/// A warning where a difference scatters hardly at all over people.
pub(super) fn too_alike(contrasts: &[TaskContrast]) -> Option<Warning> {
    let sizes = contrasts
        .iter()
        .filter_map(|one| Some((&one.tasks, one.contrast?.d_z)));
    let most = sizes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let ([a, b], d_z) = most.filter(|(_, d_z)| d_z.abs() > TOO_ALIKE)?;
    let tasks = format!("{b} − {a}");
    Some(EegWarning::TooAlike { tasks, d_z }.into())
}
