//! A protocol as its design sees it.

use super::design::{
    Aims, CampaignDescription, CompareAim, Factor, SequenceRule, TaskDescription,
    TaskKind as Designed,
};
use super::plan::balanced_orders;
use super::protocol::{
    Block, Method, OrderRule, Over, Playing, Protocol, Sequence, Task, TaskKind,
};

/// The design of the session that the protocol's aims name: what [`super::design::design_findings`] judges.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn describe(protocol: &Protocol) -> CampaignDescription {
    let aims = &protocol.aims;
    let blocks: &[Block] = protocol
        .session(&aims.session)
        .map_or(&[], |session| &session.blocks);
    let (sets, shared_over) = sets(protocol, blocks);
    let samples = match sets.is_empty() {
        true => protocol.samples.clone(),
        // In the order of the protocol, without those that stand in no set.
        false => {
            let in_a_set = |sample: &&String| sets.iter().any(|set| set.contains(sample));
            protocol.samples.iter().filter(in_a_set).cloned().collect()
        }
    };
    let in_blocks = |task: &&Task| blocks.iter().any(|block| block.tasks.contains(&task.name));
    let earlier = |task: &&Task| aims.earlier_tasks.contains(&task.name);
    let tasks = protocol
        .tasks
        .iter()
        .filter(|task| in_blocks(task) || earlier(task))
        .map(|task| described(protocol, task, blocks, &sets))
        .collect();
    CampaignDescription {
        name: protocol.name.clone(),
        samples,
        sets,
        tray: protocol.tray_slots,
        sets_shared_over: shared_over,
        pairs_wanted: aims.pairs,
        tasks,
        task_orders: task_orders(protocol, blocks),
        comparisons: aims.comparisons.clone(),
        counterbalanced: counterbalanced(protocol, blocks),
        participants: protocol.panel.participants as usize,
        aims: Aims {
            power_share: aims.power_share,
            half_width_share: aims.half_width_share,
            cell_share: aims.cell_share,
            logit_sd: aims.logit_sd,
        },
    }
}

/// The sets of the blocks, and over how many participants they are shared.
fn sets(protocol: &Protocol, blocks: &[Block]) -> (Vec<Vec<String>>, usize) {
    // Who names or associates has all samples of the block before them: one set.
    let from_a_set = |block: &&Block| {
        let tasks = block.tasks.iter().filter_map(|name| protocol.task(name));
        tasks
            .map(|task| &task.kind)
            .any(|kind| matches!(kind, TaskKind::Identify { .. } | TaskKind::Associate { .. }))
    };
    let mut of_sets = blocks.iter().filter(|block| block.over.is_of_sets());
    let block = of_sets.next().or_else(|| blocks.iter().find(from_a_set));
    let shares = block.map_or(Vec::new(), |block| protocol.groups(&block.over));
    let groups = shares.iter().flatten();
    let sets = groups.map(|group| group.samples.to_vec()).collect();
    (sets, shares.len().max(1))
}

fn described(
    protocol: &Protocol,
    task: &Task,
    blocks: &[Block],
    sets: &[Vec<String>],
) -> TaskDescription {
    let block = blocks.iter().find(|block| block.tasks.contains(&task.name));
    let over_sets = block.is_some_and(|block| block.over.is_of_sets());
    let group = match block.map(|block| &block.over) {
        Some(Over::Samples(samples)) => samples.len(),
        _ => protocol.samples.len(),
    };
    // Presentations of single samples, of one participant; and how often the task is done: for each set, or each set of a share.
    let shares = block.map_or(1, |block| protocol.groups(&block.over).len());
    let (singles, times) = match over_sets {
        true => (
            sets.iter().map(Vec::len).sum(),
            (sets.len() as f64 / shares as f64).max(1.0),
        ),
        false => (group, 1.0),
    };
    let mut elements = 1.0;
    let each_s = match protocol.rendering.as_ref().map(|one| one.playing) {
        Some(Playing::Repeated { duration_s, .. }) => duration_s,
        Some(Playing::Once) | None => 0.0,
    };
    let mut played_s = 0.0;
    let mut seconds_beside = task.seconds_per_trial;
    let kind = match &task.kind {
        TaskKind::Touch { .. } => Designed::Touch { trials: singles },
        TaskKind::Identify { .. } => Designed::IdentifyFromMemory,
        TaskKind::Order { .. } => match over_sets {
            true => Designed::OrderSet {
                scoring: protocol.aims.scoring,
            },
            false => Designed::OrderAll {
                samples: group,
                scoring: protocol.aims.scoring,
            },
        },
        TaskKind::Associate { sequence, .. } => {
            let (sequence, mean_length) = sequence_rule(protocol, sequence, sets);
            seconds_beside /= mean_length;
            played_s = each_s;
            elements = mean_length;
            Designed::Associate { sequence }
        }
        TaskKind::Compare { method, .. } => {
            played_s = 2.0 * each_s;
            let (once, aim) = compared(method);
            Designed::Compare {
                alternatives: 2,
                trials: (times * once as f64).round() as usize,
                aim,
            }
        }
        TaskKind::Categorise { descriptors, .. } => Designed::Categorise {
            categories: descriptors.len(),
            trials: singles,
        },
        TaskKind::Rate { from, to, .. } => Designed::Rate {
            trials: singles,
            range: to.abs_diff(*from),
        },
    };
    let repeats = match &task.kind {
        TaskKind::Identify { presentations } => *presentations as usize,
        _ => 1,
    };
    let block_repeats = block.map_or(1, |block| block.repeats as usize);
    let training = task
        .training
        .map_or(0.0, |training| f64::from(training.trials));
    let catch = task
        .catch
        .as_ref()
        .map_or(0.0, |catch| f64::from(catch.trials));
    TaskDescription {
        name: task.name.clone(),
        task: kind,
        repeats: repeats * block_repeats,
        seconds_per_trial: seconds_beside + played_s,
        played_s,
        uncounted_trials: elements * (training + catch * times * block_repeats as f64),
    }
}

/// The trials of a comparison that is done once, and its aim.
fn compared(method: &Method) -> (usize, CompareAim) {
    match method {
        Method::Constant { pairs, repeats } => (
            2 * pairs.len() * *repeats as usize,
            CompareAim::Shares { pairs: pairs.len() },
        ),
        // All that it can have: a staircase may end before.
        Method::Adaptive(adaptive) => (
            adaptive.rule.at_most() as usize,
            CompareAim::Threshold {
                levels: adaptive.levels(),
                rule: adaptive.rule.clone(),
                largest_sd: adaptive.largest_sd,
            },
        ),
    }
}

/// The rule of a sequence, and the mean number of its stimuli.
fn sequence_rule(
    protocol: &Protocol,
    sequence: &Sequence,
    sets: &[Vec<String>],
) -> (SequenceRule, f64) {
    let mean = |lengths: &mut dyn Iterator<Item = usize>| {
        let (sum, count) = lengths.fold((0, 0), |(sum, count), n| (sum + n, count + 1));
        (sum as f64 / f64::from(count.max(1))).max(1.0)
    };
    match sequence {
        Sequence::Balanced => (
            SequenceRule::Permutation,
            mean(&mut sets.iter().map(Vec::len)),
        ),
        Sequence::Drawn { lengths } => {
            let shortest = lengths.iter().min().copied().unwrap_or(1);
            let longest = lengths.iter().max().copied().unwrap_or(1);
            (
                SequenceRule::Independent { shortest, longest },
                mean(&mut lengths.iter().copied()),
            )
        }
        Sequence::Fixed { tests } => {
            // By the physical sample: that is what answers exclude each other by.
            let physical = |stimuli: &Vec<String>| -> Vec<String> {
                let of = |stimulus: &String| protocol.sample_of(stimulus).map(str::to_owned);
                stimuli.iter().filter_map(of).collect()
            };
            let own = |set: &Vec<String>| {
                let same = |name: &str| protocol.set(name).is_some_and(|one| one.samples == *set);
                let own = tests.iter().filter(|test| same(&test.set));
                own.map(|test| &test.stimuli).collect::<Vec<_>>()
            };
            let of_set = |set| own(set).into_iter().map(physical).collect();
            let of_set_by_name = |set| own(set).into_iter().cloned().collect();
            let by_set: Vec<Vec<Vec<String>>> = sets.iter().map(of_set).collect();
            let length = mean(&mut by_set.iter().flatten().map(Vec::len));
            let by_name: Vec<Vec<Vec<String>>> = sets.iter().map(of_set_by_name).collect();
            let stimuli = if by_name == by_set {
                Vec::new()
            } else {
                by_name
            };
            let tests = by_set;
            (SequenceRule::Fixed { tests, stimuli }, length)
        }
    }
}

/// The orders of tasks over participants.
fn task_orders(protocol: &Protocol, blocks: &[Block]) -> Vec<Vec<String>> {
    let mut orders = vec![protocol.aims.earlier_tasks.clone()];
    for block in blocks {
        let rows: Vec<Vec<String>> = match block.task_order {
            OrderRule::AsListed => vec![block.tasks.clone()],
            OrderRule::Balanced | OrderRule::Shuffled => balanced_orders(block.tasks.len())
                .into_iter()
                .map(|order| order.into_iter().map(|i| block.tasks[i].clone()).collect())
                .collect(),
        };
        let longer = orders.iter().flat_map(|before| {
            rows.iter()
                .map(|row| before.iter().chain(row).cloned().collect())
        });
        orders = longer.collect();
    }
    orders
}

/// The factors whose orders are balanced over participants.
fn counterbalanced(protocol: &Protocol, blocks: &[Block]) -> Vec<Factor> {
    let mut factors = protocol.aims.also_counterbalanced.clone();
    for block in blocks {
        if block.task_order == OrderRule::Balanced {
            factors.push(Factor {
                name: format!("order of tasks of {}", block.name),
                orders: balanced_orders(block.tasks.len()).len(),
            });
        }
        if block.set_order == OrderRule::Balanced {
            let shares = protocol.groups(&block.over);
            let sets = shares.iter().map(Vec::len).max().unwrap_or(1);
            factors.push(Factor {
                name: format!("order of sets of {}", block.name),
                orders: balanced_orders(sets).len(),
            });
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::super::design::{Fault, Scoring, design_findings};
    use super::super::protocol::{LIBRARY, from_library, read};
    use super::*;

    fn faults(protocol: &Protocol) -> Vec<Fault> {
        let report = design_findings(&describe(protocol), 1).unwrap();
        report.faults.into_iter().map(|found| found.fault).collect()
    }

    #[test]
    fn the_faults_of_the_thesis_are_found_from_its_protocols_alone() {
        let protocol = |name: &str| from_library(name).unwrap().unwrap();
        let isotropic = faults(&protocol("isotropic_triplets"));
        assert!(
            isotropic.iter().any(|fault| matches!(
                fault,
                Fault::PairsNeverTogether {
                    together: 31,
                    pairs: 78,
                    ..
                }
            )),
            "{isotropic:?}"
        );
        let periodic = faults(&protocol("periodic_pilot"));
        assert!(
            !periodic
                .iter()
                .any(|fault| matches!(fault, Fault::PairsNeverTogether { .. })),
            "{periodic:?}"
        );
        let inversion = faults(&protocol("amplitude_inversion"));
        assert!(
            inversion.iter().any(|fault| matches!(
                fault,
                Fault::AnswersByExclusion {
                    permutations: Some(8),
                    ..
                }
            )),
            "{inversion:?}"
        );
        let imagery = faults(&protocol("touch_control_imagery"));
        let has = |what: fn(&Fault) -> bool| assert!(imagery.iter().any(what), "{imagery:?}");
        has(
            |fault| matches!(fault, Fault::ConfoundedWithOrder { task, position: 1, .. } if task == "natural"),
        );
        has(|fault| {
            matches!(
                fault,
                Fault::CannotBeBalanced {
                    cells: 12,
                    participants: 10
                }
            )
        });
        has(|fault| {
            matches!(
                fault,
                Fault::PowerTooLow {
                    participants: 10,
                    ..
                }
            )
        });
    }

    /// Two of eight sequences repeat a sample; who answers each sample once in the other six has a wider distribution than who repeats
    /// answers. By enumeration, 13 right of 24 have a probability of 7 % then.
    #[test]
    fn some_sequences_with_repeats_do_not_lower_what_is_above_chance() {
        let (_, toml) = LIBRARY
            .iter()
            .find(|(name, _)| *name == "amplitude_inversion")
            .unwrap();
        let repeated = toml
            .replacen("[\"S6\", \"S13\", \"S2\"]", "[\"S6\", \"S6\", \"S2\"]", 1)
            .replacen("[\"S8\", \"S5\", \"S11\"]", "[\"S8\", \"S8\", \"S11\"]", 1);
        assert_ne!(*toml, repeated);
        let of = |toml: &str| {
            let report = design_findings(&describe(&read(toml).unwrap()), 1).unwrap();
            let chance = report
                .chance
                .into_iter()
                .find(|of| of.task == "task3")
                .unwrap();
            (
                chance.beyond_chance_from,
                chance.beyond_chance_together_from,
            )
        };
        assert_eq!(of(toml), (Some(14), Some(52)));
        assert_eq!(of(&repeated).0, Some(14));
        assert!(of(&repeated).1 < Some(52));
    }

    /// The matrix has a row for S2 and one for S2 INVERTED, each presented twice, not one that is presented four times.
    #[test]
    fn inverted_textures_have_cells_of_their_own() {
        let protocol = from_library("amplitude_inversion").unwrap().unwrap();
        let described = describe(&protocol);
        let report = design_findings(&described, 1).unwrap();
        let of = &report.precision[0];
        assert_eq!(
            (of.presentations, of.precision.plan.presentations),
            (2.0, 2)
        );
        let mut without = described.clone();
        for task in &mut without.tasks {
            if let Designed::Associate {
                sequence: SequenceRule::Fixed { stimuli, .. },
            } = &mut task.task
            {
                assert_eq!(stimuli.len(), 2);
                stimuli.clear();
            }
        }
        let pooled = design_findings(&without, 1).unwrap();
        assert_eq!(pooled.precision[0].presentations, 4.0);
        assert!(pooled.precision[0].precision.half_width_share < of.precision.half_width_share);
    }

    /// Four samples on the tray at once are one set, in which every pair is together and the chance level is 1 of 4.
    #[test]
    fn all_samples_at_once_are_one_set() {
        let (_, toml) = LIBRARY[1];
        let some = "over = { samples = [\"S1\", \"S2\", \"S3\", \"S4\"] }";
        let at_once = toml.replacen("over = \"every_set\"", some, 1);
        let described = describe(&read(&at_once).unwrap());
        assert_eq!(described.sets, [["S1", "S2", "S3", "S4"]]);
        let report = design_findings(&described, 1).unwrap();
        assert!(report.never.is_empty());
        let chance = report.chance.iter().find(|of| of.task == "task3").unwrap();
        assert!((chance.mean / chance.answers - 0.25).abs() < 1e-12);
        // An order alone needs no set.
        let orders = at_once.replacen("tasks = [\"task2\", \"task3\"]", "tasks = [\"task2\"]", 1);
        assert!(describe(&read(&orders).unwrap()).sets.is_empty());
    }

    #[test]
    fn dominance_beside_positions_is_no_fault() {
        let (_, toml) = LIBRARY[1];
        let positions = |fault: &Fault| format!("{fault:?}").contains("Position");
        let before = faults(&read(toml).unwrap());
        let better = toml.replacen(
            "scoring = \"by_position\"",
            "scoring = \"by_position_and_dominance\"",
            1,
        );
        let after = faults(&read(&better).unwrap());
        assert!(
            before.iter().any(positions) && !after.iter().any(positions),
            "{before:?} {after:?}"
        );
        assert_eq!(describe(&read(&better).unwrap()).aims.logit_sd, 0.9);
        assert_eq!(
            read(&better).unwrap().aims.scoring,
            Scoring::ByPositionAndDominance
        );
    }

    #[test]
    fn trials_of_adaptive_runs_training_and_catch_trials_take_their_time() {
        let jnd = describe(&from_library("roughness_jnd").unwrap().unwrap());
        let report = design_findings(&jnd, 1).unwrap();
        let times: Vec<_> = report.time.iter().collect();
        assert_eq!((times[0].trials, times[0].uncounted), (50.0, 11.0));
        assert_eq!((times[1].trials, times[1].uncounted), (90.0, 11.0));
        assert_eq!(report.participant_s, 12.0 * (50.0 + 90.0 + 22.0));
        // Two alternatives: half of the answers are right by chance.
        let by_chance: Vec<f64> = report.chance.iter().map(|task| task.mean).collect();
        let near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-9;
        assert!(
            near(by_chance[0], 25.0) && near(by_chance[1], 45.0),
            "{by_chance:?}"
        );
        let (_, toml) = LIBRARY[1];
        let plain = describe(&read(toml).unwrap());
        let known: Vec<String> = plain
            .sets
            .iter()
            .map(|set| format!("[\"{0}\", \"{0}\"]", set[0]))
            .collect();
        let with = format!(
            "kind = \"associate\"\ntraining = {{ trials = 2 }}\ncatch = {{ trials = 1, known = [{}], failures_allowed = 0 }}",
            known.join(", ")
        );
        let with = describe(&read(&toml.replace("kind = \"associate\"", &with)).unwrap());
        let uncounted = |campaign: &CampaignDescription| {
            let task = campaign.tasks.iter().find(|task| task.name == "task3");
            task.unwrap().uncounted_trials
        };
        // Two sequences of training and one of each of twelve sets, 3.5 stimuli long as the others.
        assert_eq!((uncounted(&plain), uncounted(&with)), (0.0, 14.0 * 3.5));
    }
}
