//! Cluster tests of two tasks over electrodes, frequencies and times.

use piezotact::Warning;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::statistics::holm;
use piezotact::warning::{Few, FewWarning};
use serde::{Deserialize, Serialize};

use super::people::People;
use super::power::power_of;
use super::{GroupConfig, GroupCriterion, GroupError, LEVEL};
use crate::eeg::cluster::{
    Cluster, ClusterConfig, ClusterTest, Grid, Tried, differences, people_for, test,
};
use crate::eeg::person::{ChangeMap, EegErd};
use crate::eeg::reference::Montage;
use crate::eeg::{EegWarning, PositionsFault};

/// So many clusters are listed, the largest first.
const LISTED: usize = 10;

/// Where a cluster lies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ClusterPlace {
    /// The probability of a cluster as large by chance.
    pub p_value: f64,
    /// The sum of its t; negative where the second task is more desynchronised.
    pub mass: f64,
    /// How many nodes it has.
    pub nodes: usize,
    /// Its electrodes.
    pub electrodes: Vec<String>,
    /// Its lowest and its highest frequency, Hz.
    pub hz: [f64; 2],
    /// Its first and its last time, s.
    pub time_s: [f64; 2],
    /// Where t is furthest from 0: electrode.
    pub peak_electrode: String,
    /// Where t is furthest from 0: frequency, Hz.
    pub peak_hz: f64,
    /// Where t is furthest from 0: time, s.
    pub peak_s: f64,
    /// That t.
    pub peak_t: f64,
}

/// The cluster test of two tasks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskClusters {
    /// The tasks: the second less the first, dB, mean of surfaces.
    pub tasks: [String; 2],
    /// Who took part in both.
    pub people: Vec<String>,
    /// How many pairs of electrodes are neighbours; 0 where positions are not known, so that each electrode is by itself.
    pub neighbours: usize,
    /// Electrodes × frequencies × times.
    pub nodes: usize,
    /// The first and the last time that is tested, s.
    pub time_s: [f64; 2],
    /// The t beyond which nodes form clusters.
    pub threshold_t: f64,
    /// How many sign flips were made.
    pub flips: usize,
    /// Which: all, or drawn ones.
    pub tried: Tried,
    /// The smallest probability that these can give.
    pub smallest_p: f64,
    /// How many clusters there are.
    pub found: usize,
    /// The largest of them.
    pub clusters: Vec<ClusterPlace>,
    /// The probability of the one that is least probable, after Holm over the pairs of tasks; 1 without a cluster.
    pub p_holm: f64,
    /// The largest of the probabilities of a cluster, of one of power itself, whatever the baselines, and of one of power less that in the
    /// baseline (re the baseline of both tasks), which have half of its nodes in common with it, in the same direction: of the least probable such clusters, after Holm over
    /// the pairs of tasks; 1 without them.
    pub power_p_holm: f64,
    /// What was decided.
    pub criteria: Vec<Criterion<GroupCriterion>>,
}

/// The cluster test of each pair of tasks with at least two people in both.
pub(super) fn clusters(
    people: &People<'_>,
    config: &GroupConfig,
) -> Result<(Vec<TaskClusters>, Vec<Warning>), GroupError> {
    let (mut found, mut warnings) = (Vec::new(), Vec::new());
    let pairs = neighbours(people, config.neighbours_deg);
    if pairs.is_empty() && people.channels.len() > 1 {
        warnings.push(
            EegWarning::Positions {
                fault: PositionsFault::NoNeighbours {
                    electrodes: people.channels.len(),
                },
            }
            .into(),
        );
    }
    for tasks in people.pairs() {
        let tested = tested(people, &tasks);
        if tested.names.len() < 2 || tested.times.is_empty() {
            continue;
        }
        let hz = people.first.config.power.frequencies_hz.len();
        let grid = Grid::new(people.channels.len(), hz, tested.times.len(), &pairs)?;
        let values = differences(&tested.first, &tested.second)?;
        let Some(settings) = ClusterConfig::two_sided(values.len(), config.flips, config.seed)
        else {
            continue;
        };
        let result = test(&values, &grid, &settings)?;
        let described = described(people, &tasks, &tested, &grid, &result, pairs.len());
        let power_p_holm = match result.clusters.iter().any(|one| one.p_value <= LEVEL) {
            true => {
                let of = |[first, second]: &[Vec<Vec<f64>>; 2]| {
                    let tested = test(&differences(first, second)?, &grid, &settings)?;
                    Ok::<_, GroupError>(tested.clusters)
                };
                let of_power = [of(&tested.levels)?, of(&tested.steps())?];
                with_power(&result.clusters, &of_power)
            }
            false => 1.0,
        };
        found.push(TaskClusters {
            power_p_holm,
            ..described
        });
    }
    warnings.extend(few_people(&found));
    let of = |p: fn(&TaskClusters) -> f64| holm(&found.iter().map(p).collect::<Vec<_>>());
    let (of_changes, of_power) = (of(|one| one.p_holm), of(|one| one.power_p_holm));
    for ((one, p), with_power) in found.iter_mut().zip(of_changes).zip(of_power) {
        one.decide(p, with_power);
    }
    Ok((found, warnings))
}

/// The largest probability of a cluster of changes and of one of each kind of power that have a sign and nodes in common: of the least
/// probable such three; 1 without them. In common are half of the nodes of the cluster of changes or more: a cluster of power elsewhere says
/// nothing of it.
fn with_power(changes: &[Cluster], [levels, steps]: &[Vec<Cluster>; 2]) -> f64 {
    let mut least = 1.0_f64;
    for one in changes {
        let signed = |other: &&Cluster| one.mass * other.mass > 0.0;
        for level in levels.iter().filter(signed) {
            for step in steps.iter().filter(signed) {
                let is_in = |of: &Cluster, node: &usize| of.nodes.binary_search(node).is_ok();
                let common = one.nodes.iter();
                let common = common.filter(|node| is_in(level, node) && is_in(step, node));
                if 2 * common.count() >= one.nodes.len() {
                    least = least.min(one.p_value.max(level.p_value).max(step.p_value));
                }
            }
        }
    }
    least
}

/// A warning where the smallest possible p is above the level once it is adjusted over the pairs of tasks.
fn few_people(found: &[TaskClusters]) -> Option<Warning> {
    let tests = found.len();
    let worst = found
        .iter()
        .max_by(|a, b| a.smallest_p.total_cmp(&b.smallest_p))?;
    let warning = FewWarning::Few {
        found: worst.people.len(),
        recommended: people_for(tests),
        what: Few::ParticipantsOfClusters {
            flips: worst.flips,
            smallest_p: worst.smallest_p,
            tests,
        },
    };
    (worst.smallest_p * tests as f64 > LEVEL).then(|| warning.into())
}

/// The pairs of neighbours among the electrodes, by their indices.
fn neighbours(people: &People<'_>, angle_deg: f64) -> Vec<[usize; 2]> {
    let names = people
        .electrodes
        .iter()
        .map(|one| one.name.clone())
        .collect();
    let positions = people.electrodes.iter().map(|one| one.position).collect();
    let Ok(montage) = Montage::new(names, positions) else {
        return Vec::new();
    };
    let index = |i: usize| {
        let name = &people.electrodes[i].name;
        people.channels.iter().position(|own| own == name)
    };
    let pairs = montage.neighbours(angle_deg).into_iter();
    pairs
        .filter_map(|[i, j]| Some([index(i)?, index(j)?]))
        .collect()
}

/// The values of people in both tasks, people × (electrodes × frequencies × times).
struct Tested {
    names: Vec<String>,
    times: std::ops::Range<usize>,
    first: Vec<Vec<f64>>,
    second: Vec<Vec<f64>>,
    /// The power itself in both tasks, dB re 1 µV².
    levels: [Vec<Vec<f64>>; 2],
}

impl Tested {
    /// The power less that in the baseline, re the baseline of both tasks (the mean of their dB).
    fn steps(&self) -> [Vec<Vec<f64>>; 2] {
        let changes = [&self.first, &self.second];
        [0, 1].map(|task| {
            let of_person = |person: usize| {
                let at = |node: usize| {
                    let [own, other] = [task, 1 - task].map(|task| {
                        let level = self.levels[task][person][node];
                        [level, level - changes[task][person][node]]
                    });
                    let both_db = 0.5 * (own[1] + other[1]);
                    let [level, baseline] = own.map(|db| power_of(db - both_db));
                    level - baseline
                };
                (0..self.first[person].len()).map(at).collect()
            };
            (0..self.names.len()).map(of_person).collect()
        })
    }
}

fn tested(people: &People<'_>, [a, b]: &[String; 2]) -> Tested {
    let times_s = &people.first.times_s;
    // In the baseline both are 0 by definition.
    let [from_s, to_s] = people.first.config.baseline_s;
    let after = times_s.partition_point(|t| *t <= to_s);
    let before = times_s.partition_point(|t| *t < from_s);
    let times = match people.first.config.window_s[0] >= to_s {
        true => after..times_s.len(),
        false => 0..before,
    };
    let mut found = Tested {
        names: Vec::new(),
        times: times.clone(),
        first: Vec::new(),
        second: Vec::new(),
        levels: Default::default(),
    };
    for participant in &people.participants {
        let (Some(first), Some(second)) = (people.get(participant, a), people.get(participant, b))
        else {
            continue;
        };
        let common: Vec<&String> = first
            .surfaces
            .iter()
            .filter(|surface| second.surfaces.contains(surface))
            .collect();
        // As the contrasts of means: of people who have all surfaces in both.
        if common.len() < people.surfaces.len() {
            continue;
        }
        found.names.push(participant.clone());
        let change = |_: &ChangeMap, _: usize| 0.0;
        let level = |map: &ChangeMap, line: usize| map.baselines_db[line];
        let mean = |document, of: &dyn Fn(&ChangeMap, usize) -> f64| {
            mean_map(people, document, &common, &times, of)
        };
        found.first.push(mean(first, &change));
        found.second.push(mean(second, &change));
        found.levels[0].push(mean(first, &level));
        found.levels[1].push(mean(second, &level));
    }
    found
}

/// The mean of the maps of `surfaces` at the common electrodes and at `times`, dB above what `of` gives of a map at an electrode and frequency.
fn mean_map(
    people: &People<'_>,
    document: &EegErd,
    surfaces: &[&String],
    times: &std::ops::Range<usize>,
    of: &dyn Fn(&ChangeMap, usize) -> f64,
) -> Vec<f64> {
    let (hz, all) = (
        document.config.power.frequencies_hz.len(),
        document.times_s.len(),
    );
    let maps: Vec<&ChangeMap> = document
        .maps
        .iter()
        .filter(|map| surfaces.contains(&&map.surface))
        .collect();
    let mut values = Vec::with_capacity(people.channels.len() * hz * times.len());
    for name in &people.channels {
        let channel = document.channels.iter().position(|own| own == name);
        let start = channel.unwrap_or_default() * hz;
        for line in start..start + hz {
            let above: f64 = maps.iter().map(|map| of(map, line)).sum();
            for time in times.clone() {
                let at = line * all + time;
                let sum: f64 = maps.iter().map(|map| map.decibels[at]).sum();
                values.push((sum + above) / maps.len() as f64);
            }
        }
    }
    values
}

fn described(
    people: &People<'_>,
    tasks: &[String; 2],
    tested: &Tested,
    grid: &Grid,
    result: &ClusterTest,
    neighbours: usize,
) -> TaskClusters {
    let times_s = &people.first.times_s[tested.times.clone()];
    let place = |cluster: &Cluster| placed(people, times_s, grid, &result.t, cluster);
    let least = result.clusters.iter().map(|one| one.p_value);
    TaskClusters {
        tasks: tasks.clone(),
        people: tested.names.clone(),
        neighbours,
        nodes: grid.nodes(),
        time_s: [times_s[0], times_s[times_s.len() - 1]],
        threshold_t: result.config.threshold_t,
        flips: result.flips,
        tried: result.tried,
        smallest_p: result.smallest_p,
        found: result.clusters.len(),
        clusters: result.clusters.iter().take(LISTED).map(place).collect(),
        // Without a cluster every flip has one as large. Adjusted when all pairs are there.
        p_holm: least.fold(1.0, f64::min),
        power_p_holm: 1.0,
        criteria: Vec::new(),
    }
}

impl TaskClusters {
    /// Decides by the adjusted probability `p` of a cluster, and that with one of power.
    fn decide(&mut self, p: f64, with_power: f64) {
        let tasks = self.tasks.clone();
        let of_changes = GroupCriterion::Cluster {
            tasks: tasks.clone(),
        };
        let all = [
            (of_changes, p),
            (GroupCriterion::ClusterOfPower { tasks }, with_power),
        ];
        let all = all.map(|(what, p)| Criterion::new(what, "", p, None, Limit::at_most(LEVEL)));
        // A large p does not show that tasks are alike, nor a small one that they differ where their baselines, or added noise, may be
        // all that does.
        let met = all.iter().all(|one| one.outcome == Outcome::Met);
        let decided = |mut one: Criterion<GroupCriterion>| {
            let is_of_changes = matches!(one.what, GroupCriterion::Cluster { .. });
            if one.outcome == Outcome::NotMet || is_of_changes && !met {
                one.outcome = Outcome::NotDecided;
            }
            one
        };
        self.criteria = all.map(decided).to_vec();
        self.p_holm = p;
        self.power_p_holm = with_power;
    }

    /// Whether changes have a cluster in which power itself does not differ: the baselines, or added noise, may carry it.
    #[must_use]
    pub fn may_be_of_baselines(&self) -> bool {
        self.p_holm <= LEVEL && self.power_p_holm > LEVEL
    }
}

fn placed(
    people: &People<'_>,
    times_s: &[f64],
    grid: &Grid,
    t: &[f64],
    cluster: &Cluster,
) -> ClusterPlace {
    let hz = &people.first.config.power.frequencies_hz;
    let places: Vec<[usize; 3]> = cluster.nodes.iter().map(|node| grid.place(*node)).collect();
    let range = |of: &dyn Fn(&[usize; 3]) -> f64| {
        let values = places.iter().map(of);
        values.fold([f64::MAX, f64::MIN], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let mut channels: Vec<usize> = places.iter().map(|place| place[0]).collect();
    channels.sort_unstable();
    channels.dedup();
    let peak = cluster
        .nodes
        .iter()
        .copied()
        .max_by(|a, b| t[*a].abs().total_cmp(&t[*b].abs()))
        .unwrap_or_default();
    let [channel, frequency, time] = grid.place(peak);
    ClusterPlace {
        p_value: cluster.p_value,
        mass: cluster.mass,
        nodes: cluster.nodes.len(),
        electrodes: channels
            .iter()
            .map(|i| people.channels[*i].clone())
            .collect(),
        hz: range(&|place| hz[place[1]]),
        time_s: range(&|place| times_s[place[2]]),
        peak_electrode: people.channels[channel].clone(),
        peak_hz: hz[frequency],
        peak_s: times_s[time],
        peak_t: t[peak],
    }
}
