//! Comparisons of tasks: their order, their power, and the cells of crossed factors.

use piezotact::criterion::{Criterion, Limit};

use super::super::description::Comparison;
use super::super::error::DesignError;
use super::super::fault::{Change, DesignCriterion, Fault};
use super::super::orders::{crossing, only_positions, williams_orders};
use super::super::precision::{paired_power, participants_for_power};
use super::Work;
use super::report::ComparisonPower;

impl Work<'_> {
    /// Fault 6: a task that always has the same position among those it is compared with.
    pub(super) fn order(&mut self, comparison: &Comparison) -> Result<(), DesignError> {
        let names = &comparison.tasks;
        let described = self.campaign.tasks.iter().map(|task| &task.name);
        for name in names
            .iter()
            .chain(self.campaign.task_orders.iter().flatten())
        {
            if described.clone().filter(|known| *known == name).count() != 1 {
                return Err(DesignError::UnknownTask { task: name.clone() });
            }
        }
        if names.len() < 2 {
            return Ok(());
        }
        let what = DesignCriterion::FixedPositions {
            tasks: names.clone(),
        };
        if self.campaign.task_orders.is_empty() {
            let unknown = Criterion::unmeasured(what, "tasks", Limit::at_most(0.0));
            self.report.criteria.push(unknown);
            return Ok(());
        }
        let among = |order: &Vec<String>| -> Vec<usize> {
            order
                .iter()
                .filter_map(|name| names.iter().position(|n| n == name))
                .collect()
        };
        let orders: Vec<Vec<usize>> = self.campaign.task_orders.iter().map(among).collect();
        let positions = only_positions(names.len(), &orders)?.into_iter();
        let fixed: Vec<(usize, usize)> = positions
            .enumerate()
            .filter_map(|(i, at)| Some((i, at?)))
            .collect();
        let criterion =
            Criterion::new(what, "tasks", fixed.len() as f64, None, Limit::at_most(0.0));
        self.judge(criterion, |work| {
            let (task, position) = fixed.first().copied().unwrap_or_default();
            let fault = Fault::ConfoundedWithOrder {
                task: names[task].clone(),
                position: position + 1,
                tasks: names.clone(),
            };
            let named = |order: &Vec<usize>| order.iter().map(|i| names[*i].clone()).collect();
            let orders = williams_orders(names.len())?.iter().map(named).collect();
            Ok((
                fault,
                Some(work.plan(Change::EarlierMeasurement { orders })),
            ))
        })
    }

    /// Fault 7: the power of a comparison.
    pub(super) fn power(&mut self, comparison: &Comparison) -> Result<(), DesignError> {
        let participants = self.campaign.participants;
        let effect_ratio = comparison.smallest_effect_ratio;
        // One participant shows no spread: nothing is found.
        let power_share = paired_power(participants, effect_ratio).unwrap_or(0.0);
        let tasks = comparison.tasks.clone();
        self.report.power.push(ComparisonPower {
            tasks: tasks.clone(),
            effect_ratio,
            power_share,
        });
        let wanted_share = self.campaign.aims.power_share;
        let what = DesignCriterion::Power {
            tasks: tasks.clone(),
        };
        let criterion = Criterion::new(what, "", power_share, None, Limit::at_least(wanted_share));
        self.judge(criterion, |work| {
            let better = participants_for_power(effect_ratio, wanted_share)
                .map(|participants| work.with_participants(participants));
            let fault = Fault::PowerTooLow {
                tasks,
                participants,
                effect_ratio,
                power_share,
                wanted_share,
            };
            Ok((fault, better))
        })
    }

    /// Fault 6: cells that the participants do not fill equally.
    pub(super) fn crossing(&mut self) -> Result<(), DesignError> {
        let factors = &self.campaign.counterbalanced;
        if factors.is_empty() {
            return Ok(());
        }
        let orders: Vec<usize> = factors.iter().map(|factor| factor.orders).collect();
        let found = crossing(&orders, self.campaign.participants)?;
        self.report.crossing = Some(found);
        let left = found.left_over as f64;
        let (what, none) = (DesignCriterion::CellsFilled, Limit::at_most(0.0));
        let criterion = Criterion::new(what, "participants", left, None, none);
        self.judge(criterion, |work| {
            let fault = Fault::CannotBeBalanced {
                cells: found.cells,
                participants: found.participants,
            };
            Ok((fault, Some(work.with_participants(found.next_balanced))))
        })
    }
}
