//! Connected nodes of one sign.

use super::flips::Sums;
use super::{Cluster, Grid, Tail, strength};

/// Finds connected nodes; memory is used again for every flip.
pub(super) struct Components<'a> {
    grid: &'a Grid,
    /// For each node one more than its place in the list of active ones; 0 where it is not.
    slots: Vec<u32>,
    parents: Vec<u32>,
    values: Vec<f64>,
    masses: Vec<f64>,
}

impl<'a> Components<'a> {
    pub(super) fn new(grid: &'a Grid) -> Self {
        Self {
            grid,
            slots: vec![0; grid.nodes()],
            parents: Vec::new(),
            values: Vec::new(),
            masses: Vec::new(),
        }
    }

    /// The clusters of the observed `t`, the largest mass first.
    pub(super) fn clusters(&mut self, t: &[f64], threshold_t: f64, tail: Tail) -> Vec<Cluster> {
        let beyond = |value: f64| match tail {
            Tail::Both => value.abs() > threshold_t,
            Tail::Positive => value > threshold_t,
            Tail::Negative => value < -threshold_t,
        };
        let active: Vec<u32> = (0..t.len())
            .filter(|i| beyond(t[*i]))
            .map(|i| i as u32)
            .collect();
        self.values.clear();
        self.values
            .extend(active.iter().map(|node| t[*node as usize]));
        self.join(&active);
        let mut of_root = std::collections::BTreeMap::<u32, Cluster>::new();
        for (i, &node) in active.iter().enumerate() {
            let root = root(&mut self.parents, i as u32);
            let cluster = of_root.entry(root).or_insert(Cluster {
                nodes: Vec::new(),
                mass: 0.0,
                p_value: 1.0,
            });
            cluster.nodes.push(node as usize);
            cluster.mass += self.values[i];
        }
        self.clear(&active);
        let mut clusters: Vec<Cluster> = of_root.into_values().collect();
        clusters.sort_by(|a, b| b.mass.abs().total_cmp(&a.mass.abs()));
        clusters
    }

    /// The largest mass in the direction of the tail among the clusters of `active` nodes; 0 without one.
    pub(super) fn largest(&mut self, active: &[u32], sums: &Sums, tail: Tail) -> f64 {
        self.values.clear();
        self.values
            .extend(active.iter().map(|node| sums.t(*node as usize)));
        self.join(active);
        self.masses.clear();
        self.masses.resize(active.len(), 0.0);
        for i in 0..active.len() {
            let root = root(&mut self.parents, i as u32);
            self.masses[root as usize] += self.values[i];
        }
        self.clear(active);
        let strengths = self.masses.iter().map(|mass| strength(tail, *mass));
        strengths.fold(0.0, f64::max)
    }

    /// Joins neighbours of one sign: the root of each is the first of its cluster.
    fn join(&mut self, active: &[u32]) {
        self.parents.clear();
        self.parents.extend(0..active.len() as u32);
        for (i, &node) in active.iter().enumerate() {
            self.slots[node as usize] = i as u32 + 1;
            let (slots, parents, values) = (&self.slots, &mut self.parents, &self.values);
            self.grid.for_each_lower(node as usize, |other| {
                let slot = slots[other];
                if slot == 0 || values[slot as usize - 1].signum() != values[i].signum() {
                    return;
                }
                let (a, b) = (root(parents, i as u32), root(parents, slot - 1));
                parents[a.max(b) as usize] = a.min(b);
            });
        }
    }

    fn clear(&mut self, active: &[u32]) {
        for node in active {
            self.slots[*node as usize] = 0;
        }
    }
}

/// The first node of the cluster, with the way to it made shorter.
#[inline]
fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}
