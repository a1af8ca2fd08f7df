//! Comparisons of tasks: their order, their power, and the cells of crossed factors.

use piezotact::criterion::{Criterion, Limit, Outcome};

use super::super::description::Comparison;
use super::super::error::DesignError;
use super::super::fault::{BetterPlan, Change, DesignCriterion, Fault, FoundFault};
use super::super::orders::{Crossing, crossing, order_balance, williams_orders};
use super::super::precision::{paired_power, participants_for_power};
use super::Work;
use super::report::ComparisonPower;

impl Work<'_> {
    /// Fault 6: a task that always has the same position among those it is compared with.
    pub(super) fn order(&mut self, comparison: &Comparison) -> Result<(), DesignError> {
        let names = &comparison.tasks;
        for name in names
            .iter()
            .chain(self.campaign.task_orders.iter().flatten())
        {
            if self
                .campaign
                .tasks
                .iter()
                .filter(|task| task.name == *name)
                .count()
                != 1
            {
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
        let balance = order_balance(names.len(), &orders)?;
        let fixed: Vec<(usize, usize)> = (0..names.len())
            .filter_map(|i| balance.only_position(i).map(|at| (i, at)))
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
    pub(super) fn power(&mut self, comparison: &Comparison) {
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
        self.report.criteria.push(criterion.clone());
        if criterion.outcome != Outcome::NotMet {
            return;
        }
        let better = participants_for_power(effect_ratio, wanted_share).map(|n| BetterPlan {
            participants: [participants, n],
            ..self.plan(Change::Participants { participants: n })
        });
        let fault = Fault::PowerTooLow {
            tasks,
            participants,
            effect_ratio,
            power_share,
            wanted_share,
        };
        self.report.faults.push(FoundFault {
            fault,
            criterion,
            better,
        });
    }

    /// Fault 6: cells that the participants do not fill equally.
    pub(super) fn crossing(&mut self) -> Result<(), DesignError> {
        if self.campaign.counterbalanced.is_empty() {
            return Ok(());
        }
        let orders: Vec<usize> = self
            .campaign
            .counterbalanced
            .iter()
            .map(|f| f.orders)
            .collect();
        let found = crossing(&orders, self.campaign.participants)?;
        self.report.crossing = Some(found);
        let left = found.left_over as f64;
        let criterion = Criterion::new(
            DesignCriterion::CellsFilled,
            "participants",
            left,
            None,
            Limit::at_most(0.0),
        );
        self.judge(criterion, |work| {
            let Crossing {
                cells,
                participants,
                next_balanced,
                ..
            } = found;
            let mut better = work.plan(Change::Participants {
                participants: next_balanced,
            });
            better.participants[1] = next_balanced;
            Ok((
                Fault::CannotBeBalanced {
                    cells,
                    participants,
                },
                Some(better),
            ))
        })
    }
}
