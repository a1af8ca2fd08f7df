//! The cut-off of a profile: stated, or chosen by the rules and tables of ISO 4288.

use serde::{Deserialize, Serialize};

/// Which cut-off separates roughness from waviness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Cutoff {
    /// This one, in m.
    Stated(f64),
    /// The one whose range of Ra holds the Ra measured with it: for profiles without a period.
    Iso4288,
    /// The one whose range of `RSm` holds the `RSm` measured with it: for turned, planed and other periodic
    /// profiles.
    Iso4288Periodic,
}

/// What is taken away at the short end, before the roughness is separated from the waviness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ShortWaves {
    /// Nothing.
    Kept,
    /// The λs that goes with the cut-off, where it is five steps and more; else nothing.
    Iso3274,
    /// A Gaussian filter of this cut-off, in m.
    Stated(f64),
}

/// One line of the tables.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) cutoff_m: f64,
    pub(super) lambda_s_m: f64,
    /// The largest Ra, and the largest `RSm`, in m.
    ra_to_m: f64,
    rsm_to_m: f64,
}

/// ISO 4288:1996, tables 1 and 3; λs after ISO 3274:1996, table 1.
pub(super) const TABLE: [Row; 5] = [
    row(0.08e-3, 2.5e-6, 0.02e-6, 0.04e-3),
    row(0.25e-3, 2.5e-6, 0.1e-6, 0.13e-3),
    row(0.8e-3, 2.5e-6, 2e-6, 0.4e-3),
    row(2.5e-3, 8e-6, 10e-6, 1.3e-3),
    row(8e-3, 25e-6, 80e-6, 4e-3),
];

const fn row(cutoff_m: f64, lambda_s_m: f64, ra_to_m: f64, rsm_to_m: f64) -> Row {
    Row {
        cutoff_m,
        lambda_s_m,
        ra_to_m,
        rsm_to_m,
    }
}

/// What the table is entered with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Entry {
    Ra(f64),
    Rsm(f64),
}

/// The row for `entry`; none above the table. Below the table it is the first.
fn row_for(entry: Entry) -> Option<usize> {
    TABLE.iter().position(|row| match entry {
        Entry::Ra(ra_m) => ra_m <= row.ra_to_m,
        Entry::Rsm(rsm_m) => rsm_m <= row.rsm_to_m,
    })
}

/// The λs that goes with `cutoff_m`: that of the longest cut-off of the table that is not above it.
pub(super) fn lambda_s_m(cutoff_m: f64) -> f64 {
    let below = TABLE.iter().rev().find(|row| row.cutoff_m <= cutoff_m);
    below.unwrap_or(&TABLE[0]).lambda_s_m
}

/// How a search for the cut-off ended: on a row that fits what was measured with it, or on the row that
/// comes closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Search {
    Settled(usize),
    Unsettled(usize),
}

/// Searches the rows from `first` to `last` of the table: enters with a guess, measures with the row found
/// and enters again, until measured value and row agree; then takes the next shorter row if that agrees too.
///
/// Formula: ISO 4288:1996, 7.2.
pub(super) fn search<E>(
    guess: Entry,
    (first, last): (usize, usize),
    mut measure: impl FnMut(usize) -> Result<Entry, E>,
) -> Result<Search, E> {
    let within = |row: Option<usize>| row.unwrap_or(TABLE.len()).clamp(first, last);
    let mut tried = [false; TABLE.len()];
    let mut at = within(row_for(guess));
    loop {
        tried[at] = true;
        let wanted = row_for(measure(at)?);
        if wanted == Some(at) {
            break;
        }
        let next = within(wanted);
        if tried[next] {
            return Ok(Search::Unsettled(at));
        }
        at = next;
    }
    let shorter = at
        .checked_sub(1)
        .filter(|row| *row >= first && !tried[*row]);
    Ok(Search::Settled(match shorter {
        Some(row) if row_for(measure(row)?) == Some(row) => row,
        _ => at,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(guess_m: f64, rows: (usize, usize), ra_m: [f64; 5]) -> Search {
        let measure = |row: usize| Ok::<_, ()>(Entry::Ra(ra_m[row]));
        search(Entry::Ra(guess_m), rows, measure).unwrap()
    }

    #[test]
    fn the_search_ends_on_a_row_that_fits_its_own_ra() {
        let check = |guess_m, rows, ra_m, expected| {
            assert_eq!(settle(guess_m, rows, ra_m), expected, "{guess_m}");
        };
        let five_um = [0.5e-6, 1e-6, 3e-6, 5e-6, 6e-6];
        check(5e-6, (0, 4), five_um, Search::Settled(3));
        check(60e-6, (0, 4), five_um, Search::Settled(3));
        check(1e-9, (0, 4), five_um, Search::Settled(3));
        // the next shorter fits as well and is taken
        check(
            2.5e-6,
            (0, 4),
            [0.5e-6, 1e-6, 1.9e-6, 2.2e-6, 3e-6],
            Search::Settled(2),
        );
        // what would fit is longer than the profile, or beyond the table
        check(5e-6, (0, 2), five_um, Search::Unsettled(2));
        check(1e-3, (0, 4), [90e-6; 5], Search::Unsettled(4));
        // two rows that send the search to each other
        check(
            1e-6,
            (0, 4),
            [0.5e-6, 1e-6, 3e-6, 1e-6, 1e-6],
            Search::Unsettled(3),
        );
    }

    #[test]
    fn lambda_s_goes_with_the_cut_off() {
        assert_eq!(
            [0.01e-3, 0.8e-3, 2.5e-3, 5e-3, 8e-3].map(lambda_s_m),
            [2.5e-6, 2.5e-6, 8e-6, 8e-6, 25e-6]
        );
    }
}
