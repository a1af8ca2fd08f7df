//! Orders of treatments that balance position and carry-over, with the counts that prove it.

use serde::{Deserialize, Serialize};

use super::error::DesignError;

/// How often each treatment stands in each position, and directly behind each other one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct OrderBalance {
    /// The number of orders with each treatment (row) in each position (column).
    pub positions: Vec<Vec<usize>>,
    /// The number of orders with each treatment (row) directly before each other one (column).
    pub carry_over: Vec<Vec<usize>>,
}

impl OrderBalance {
    /// The position that a treatment has in every order, from 0; `None` where it changes.
    #[must_use]
    pub fn only_position(&self, treatment: usize) -> Option<usize> {
        let row = self.positions.get(treatment)?;
        let mut used = row.iter().enumerate().filter(|(_, n)| **n > 0);
        match (used.next(), used.next()) {
            (Some((position, _)), None) => Some(position),
            _ => None,
        }
    }
}

/// Counts positions and first-order carry-over of `treatments` treatments in `orders`: two tables n × n, in orders.
///
/// # Errors
///
/// An order that does not hold each treatment once.
///
/// Source: Williams (1949), Aust. J. Sci. Res. A 2, 149.
pub fn order_balance(
    treatments: usize,
    orders: &[Vec<usize>],
) -> Result<OrderBalance, DesignError> {
    let mut positions = vec![vec![0; treatments]; treatments];
    let mut carry_over = vec![vec![0; treatments]; treatments];
    for (number, order) in orders.iter().enumerate() {
        let mut sorted = order.clone();
        sorted.sort_unstable();
        if sorted != (0..treatments).collect::<Vec<_>>() {
            return Err(DesignError::NotAnOrder {
                order: number + 1,
                expected: treatments,
            });
        }
        for (position, &treatment) in order.iter().enumerate() {
            positions[treatment][position] += 1;
        }
        for pair in order.windows(2) {
            carry_over[pair[0]][pair[1]] += 1;
        }
    }
    Ok(OrderBalance {
        positions,
        carry_over,
    })
}

/// The first rows of Williams: 0, 1, n − 1, 2, n − 2, …, each shifted by every number; n orders of n = `treatments`.
/// Positions are balanced. Carry-over is balanced where n is even.
///
/// # Errors
///
/// No treatment.
///
/// Source: Williams (1949), Aust. J. Sci. Res. A 2, 149.
pub fn balanced_latin_square(treatments: usize) -> Result<Vec<Vec<usize>>, DesignError> {
    if treatments == 0 {
        return Err(DesignError::TooFewSamples {
            found: 0,
            expected: 1,
        });
    }
    let first: Vec<usize> = (0..treatments)
        .map(|i| {
            if i % 2 == 1 {
                i.div_ceil(2)
            } else {
                (treatments - i / 2) % treatments
            }
        })
        .collect();
    let shifted = |by: usize| first.iter().map(|i| (i + by) % treatments).collect();
    Ok((0..treatments).map(shifted).collect())
}

/// Orders of n = `treatments` with positions and first-order carry-over balanced: n orders for an even n, 2n for an odd one.
///
/// # Errors
///
/// No treatment.
///
/// Source: Williams (1949), Aust. J. Sci. Res. A 2, 149.
pub fn williams_orders(treatments: usize) -> Result<Vec<Vec<usize>>, DesignError> {
    let mut orders = balanced_latin_square(treatments)?;
    if treatments % 2 == 1 && treatments > 1 {
        let mirrored: Vec<Vec<usize>> = orders
            .iter()
            .map(|order| order.iter().rev().copied().collect())
            .collect();
        orders.extend(mirrored);
    }
    Ok(orders)
}

/// How participants divide over the cells of crossed factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Crossing {
    /// The number of cells.
    pub cells: usize,
    /// The number of participants.
    pub participants: usize,
    /// Participants of every cell.
    pub in_every_cell: usize,
    /// Participants beyond, who make some cells larger by one.
    pub left_over: usize,
    /// The smallest number of participants, at least as many, that fills all cells equally.
    pub next_balanced: usize,
}

/// `participants` over the cells of factors with `levels` levels each; no factor is one cell.
///
/// # Errors
///
/// No participant, or a factor without levels.
///
/// Source: counted.
pub fn crossing(levels: &[usize], participants: usize) -> Result<Crossing, DesignError> {
    let cells = levels
        .iter()
        .try_fold(1_usize, |cells, n| cells.checked_mul(*n));
    let cells = cells.filter(|n| *n > 0 && *n <= 1_000_000);
    let (Some(cells), true) = (cells, participants > 0) else {
        return Err(DesignError::OutOfRange {
            what: "the number of cells or participants",
            found: 0.0,
            expected: "1 to 1 000 000 cells and at least one participant",
        });
    };
    Ok(Crossing {
        cells,
        participants,
        in_every_cell: participants / cells,
        left_over: participants % cells,
        next_balanced: participants.div_ceil(cells) * cells,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    impl OrderBalance {
        /// Whether every treatment stands in every position equally often.
        fn positions_balanced(&self) -> bool {
            let first = self.positions.first().and_then(|row| row.first());
            self.positions.iter().flatten().all(|n| Some(n) == first)
        }

        /// Whether every treatment stands directly before every other one equally often, and at least once.
        fn carry_over_balanced(&self) -> bool {
            let others = |(a, row): (usize, &Vec<usize>)| -> Vec<usize> {
                let off = row.iter().enumerate().filter(|(b, _)| *b != a);
                off.map(|(_, n)| *n).collect()
            };
            let counts: Vec<usize> = self
                .carry_over
                .iter()
                .enumerate()
                .flat_map(others)
                .collect();
            counts.iter().all(|n| *n > 0 && Some(n) == counts.first())
        }
    }

    #[test]
    fn williams_orders_balance_position_and_carry_over() {
        for n in 2..=15 {
            let orders = williams_orders(n).unwrap();
            assert_eq!(orders.len(), if n % 2 == 0 { n } else { 2 * n });
            let balance = order_balance(n, &orders).unwrap();
            assert!(
                balance.positions_balanced() && balance.carry_over_balanced(),
                "{n}"
            );
        }
        assert!(williams_orders(0).is_err());
    }

    #[test]
    fn what_is_not_balanced_is_not_said_to_be() {
        // A cyclic square balances positions, and carry-over not at all.
        let cyclic: Vec<Vec<usize>> = (0..4)
            .map(|by| (0..4).map(|i| (i + by) % 4).collect())
            .collect();
        let balance = order_balance(4, &cyclic).unwrap();
        assert!(balance.positions_balanced() && !balance.carry_over_balanced());
        // Odd squares need their mirror images.
        let odd = order_balance(3, &balanced_latin_square(3).unwrap()).unwrap();
        assert!(odd.positions_balanced() && !odd.carry_over_balanced());
        // Chapter 6: natural touch first, the two others in both orders.
        let thesis = order_balance(3, &[vec![0, 1, 2], vec![0, 2, 1]]).unwrap();
        assert!(!thesis.positions_balanced());
        assert_eq!(
            [0, 1, 2].map(|i| thesis.only_position(i)),
            [Some(0), None, None]
        );
        assert!(order_balance(3, &[vec![0, 1, 1]]).is_err());
    }

    #[test]
    fn ten_people_do_not_fill_twelve_cells() {
        let found = crossing(&[2, 6], 10).unwrap();
        assert_eq!(
            (
                found.cells,
                found.in_every_cell,
                found.left_over,
                found.next_balanced
            ),
            (12, 0, 10, 12)
        );
        let enough = crossing(&[2, 6], 24).unwrap();
        assert_eq!(
            (enough.in_every_cell, enough.left_over, enough.next_balanced),
            (2, 0, 24)
        );
        assert!(crossing(&[2, 0], 10).is_err() && crossing(&[2], 0).is_err());
    }
}
