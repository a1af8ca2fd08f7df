//! Pairs that are never together, and sets that hold all of them.

use piezotact::criterion::{Criterion, Limit};

use super::super::construct::{balanced_blocks, covering, shares};
use super::super::description::PairsWanted;
use super::super::error::DesignError;
use super::super::fault::{BetterPlan, Change, DesignCriterion, Fault, SampleSetCount};
use super::Work;

impl Work<'_> {
    /// Fault 2: pairs that are never together.
    pub(super) fn pairs(&mut self) -> Result<(), DesignError> {
        let Some(coverage) = self.report.coverage.clone() else {
            return Ok(());
        };
        let name = |i: &usize| self.campaign.samples[*i].clone();
        let never: Vec<[String; 2]> = coverage
            .never
            .iter()
            .map(|[a, b]| [name(a), name(b)])
            .collect();
        self.report.never.clone_from(&never);
        if self.campaign.pairs_wanted == PairsWanted::WithinSets {
            return Ok(());
        }
        let criterion = Criterion::new(
            DesignCriterion::PairsTogether,
            "pairs",
            coverage.together as f64,
            None,
            Limit::at_least(coverage.pairs as f64),
        );
        self.judge(criterion, |work| {
            let fewest = coverage.presentations.iter().min().copied().unwrap_or(0);
            let rare = coverage
                .presentations
                .iter()
                .enumerate()
                .filter(|(_, sets)| **sets == fewest);
            let rarest = rare
                .map(|(i, sets)| SampleSetCount {
                    sample: name(&i),
                    sets: *sets,
                })
                .collect();
            let fault = Fault::PairsNeverTogether {
                together: coverage.together,
                pairs: coverage.pairs,
                never,
                rarest,
            };
            // More samples than sets are built of leave the fault without a better plan.
            Ok((fault, work.better_sets().ok()))
        })
    }

    /// Sets of the largest size used that hold every pair.
    fn better_sets(&self) -> Result<BetterPlan, DesignError> {
        let points = self.campaign.samples.len();
        let size = self.blocks.iter().map(Vec::len).max().unwrap_or(2);
        let built = match balanced_blocks(points, size) {
            Ok(built) => built,
            Err(_) => covering(points, size, self.seed)?,
        };
        let halves = shares(points, &built.blocks, 2.min(built.blocks.len()))?;
        let (per_set_s, others_s) = self.time_of_sets_s();
        let then = built.blocks.len();
        let half = halves.iter().map(Vec::len).max();
        let change = Change::Sets {
            method: built.method,
            sets: built.named(&self.campaign.samples),
            together: built.coverage.together,
            pairs: built.coverage.pairs,
            bound: built.bound,
            halves,
        };
        Ok(BetterPlan {
            sets: [self.sets_each(), then],
            participant_s: [
                self.report.participant_s,
                others_s + per_set_s * then as f64,
            ],
            sets_shared_by_two: half,
            participant_shared_by_two_s: half.map(|sets| others_s + per_set_s * sets as f64),
            ..self.plan(change)
        })
    }
}
