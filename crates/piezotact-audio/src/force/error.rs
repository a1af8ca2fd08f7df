//! Why a force cannot be read or placed in time.

use std::time::Duration;

use piezotact::number::rounded;

use super::unit::ForceUnit;

/// Why a source of force cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ForceError {
    /// It cannot be opened.
    #[error(
        "cannot open {name} as a source of force: {reason}; check its name, its cable and who may read it"
    )]
    Open {
        /// The port or the file.
        name: String,
        /// What the system says.
        reason: String,
    },
    /// It sends nothing.
    #[error(
        "{name} stops talking: no reading of the force for {} s, after {readings} in all; check its cable and its power, or \
            the program that writes it",
        rounded(pause.as_secs_f64())
    )]
    Silent {
        /// The port or the file.
        name: String,
        /// For how long nothing came.
        pause: Duration,
        readings: u64,
    },
    /// It sends lines, and none is a force.
    #[error(
        "{name} sends lines, but none could be read as a force for {} s, such as `{example}`; expected `F <time in ms> <force>` or a \
            number alone: check the baud rate, and the format in docs/guide/force-cell.md",
        rounded(pause.as_secs_f64())
    )]
    Unreadable {
        /// The port or the file.
        name: String,
        /// For how long there was no reading.
        pause: Duration,
        /// One of its lines.
        example: String,
    },
    /// It does not say in which unit the force is.
    #[error(
        "{name} sends forces without a unit; send a header line such as `# unit=mN rate=80`, or state the unit in the settings (N, \
            mN, cN, g or kg)"
    )]
    NoUnit {
        /// The port or the file.
        name: String,
    },
    /// It states another unit than before, or than the settings.
    #[error(
        "{name} states the unit {found}, where {expected} was {}; readings of two units are not joined: correct the program of the \
            force cell or the settings, and start again",
        if *from_settings { "stated in the settings" } else { "stated before" }
    )]
    Unit {
        /// The port or the file.
        name: String,
        expected: ForceUnit,
        found: ForceUnit,
        /// Whether the first was that of the settings.
        from_settings: bool,
    },
    /// It states a unit that is not known.
    #[error("{name} states the unit `{found}`; expected N, mN, cN, g or kg")]
    UnknownUnit {
        /// The port or the file.
        name: String,
        found: String,
    },
    /// The device began again.
    #[error("{name} restarted (its time went from {} s back to {} s): tare it and measure again",
        rounded(*from_s),
        rounded(*to_s)
    )]
    Restarted {
        /// The port or the file.
        name: String,
        /// The last time before, s.
        from_s: f64,
        /// The first time after, s.
        to_s: f64,
    },
    /// It is no longer there.
    #[error(
        "{name} is no longer there after {readings} readings ({reason}); check its cable, then measure again"
    )]
    Vanished {
        /// The port or the file.
        name: String,
        /// What the system says.
        reason: String,
        readings: u64,
    },
    /// The columns of a file do not say which one is the force.
    #[error("{name}: expected {expected}, found {found}; {todo}")]
    Columns {
        name: String,
        expected: String,
        /// What the file has.
        found: String,
        todo: String,
    },
    /// There is no force for frames that were recorded.
    #[error("no reading of the force for {} s (at most {} s are interpolated): check the force cell and its unit, then measure again",
        rounded(*pause_s),
        rounded(*longest_s)
    )]
    Stale {
        /// How long none came, s.
        pause_s: f64,
        /// The longest pause, s.
        longest_s: f64,
    },
    /// Readings come, and their time does not go on.
    #[error("the times of the force readings stand still for {} s: correct the clock of the force cell, then measure again",
        rounded(*pause_s)
    )]
    ClockStands {
        /// For how long, s.
        pause_s: f64,
    },
    /// Nothing to join.
    #[error("the recording ended without {expected}: start the force cell before the recording")]
    Nothing { expected: &'static str },
}
