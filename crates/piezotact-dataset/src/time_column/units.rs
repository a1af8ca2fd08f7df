//! How time columns are called, and the unit that their names or numbers state.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::Unit;
use piezotact::recording::RecordingWarning;

use crate::columns::Column;
use crate::date_time::DAY_S;
use crate::error::ReadError;

/// Names under which a column holds the time, with spaces between their words.
const NAMES: [&str; 19] = [
    "time",
    "times",
    "t",
    "timestamp",
    "timestamps",
    "time stamp",
    "datetime",
    "zeit",
    "temps",
    "tempo",
    "tiempo",
    "elapsed",
    "elapsed time",
    "time elapsed",
    "relative time",
    "unix time",
    "unixtime",
    "epoch time",
    "posix time",
];
/// Names that are a unit, in small letters: `micros` of an Arduino.
const UNIT_NAMES: [(&str, &str); 9] = [
    ("micros", "us"),
    ("microseconds", "us"),
    ("millis", "ms"),
    ("milliseconds", "ms"),
    ("msec", "ms"),
    ("nanos", "ns"),
    ("nanoseconds", "ns"),
    ("seconds", "s"),
    ("sec", "s"),
];
/// The times of the years 2001 to 2100, s since 1970.
const UNIX_S: RangeInclusive<f64> = 1e9..=4.1e9;
/// Whole numbers without a unit that step by more than 1 and at most this are milliseconds.
const MOST_MS: f64 = 100.0;
/// Numbers that step by less than this, in s, may be days, s.
const SHORT_S: f64 = 2e-5;
/// The shortest step of any recording, s.
const LEAST_STEP_S: f64 = 1e-7;
/// How near a rate per day of a step in days is to a whole number of Hz.
const WHOLE: f64 = 1e-4;

/// Whether `name` is that of a time column.
pub(crate) fn is_time(name: &str) -> bool {
    let plain = name.to_lowercase().replace('_', " ");
    NAMES.contains(&plain.as_str()) || UNIT_NAMES.iter().any(|(other, _)| *other == plain)
}

/// The name of a time and its unit, where the unit is the end of the name or all of it: `time_us`, `unix time ms`, `micros`.
pub(crate) fn named_unit(name: &str) -> Option<(&str, &'static str)> {
    const ENDS: [(&str, &str); 6] = [
        ("s", "s"),
        ("ms", "ms"),
        ("us", "us"),
        ("µs", "us"),
        ("μs", "us"),
        ("ns", "ns"),
    ];
    let plain = name.to_lowercase();
    if let Some((_, unit)) = UNIT_NAMES.iter().find(|(own, _)| *own == plain) {
        return Some((name, unit));
    }
    let (rest, last) = name.rsplit_once(['_', ' '])?;
    let last = last.to_lowercase();
    let mut units = ENDS.iter().chain(&UNIT_NAMES);
    let (_, unit) = units.find(|(end, _)| *end == last)?;
    is_time(rest).then_some((rest, *unit))
}

/// Whether a text is a unit in which a time column can be: `ms`, `min`, `d`.
#[must_use]
pub fn is_time_unit(text: &str) -> bool {
    seconds_of(text).is_some()
}

/// What 1 in a unit of time is in s. `hh:mm:ss` is how a spreadsheet shows days.
pub(crate) fn seconds_of(unit: &str) -> Option<f64> {
    if let (Unit::Second, factor) = Unit::parse(unit) {
        return Some(factor);
    }
    let plain = unit.trim().to_lowercase();
    if let Some((_, unit)) = UNIT_NAMES.iter().find(|(own, _)| *own == plain) {
        return Some(Unit::parse(unit).1);
    }
    match plain.as_str() {
        "secs" | "second" => Some(1.0),
        "min" | "minute" | "minutes" => Some(60.0),
        "h" | "hour" | "hours" => Some(3600.0),
        "d" | "day" | "days" => Some(DAY_S),
        _ if plain.starts_with("hh:mm") || plain.starts_with("h:mm") => Some(DAY_S),
        _ => None,
    }
}

/// Gives a time column the unit that is stated of it in `units`, and takes it out there.
pub(crate) fn state_unit(
    path: &Path,
    time: &mut Column,
    units: &mut BTreeMap<String, String>,
) -> Result<(), ReadError> {
    let Some(stated) = units.remove(&time.name) else {
        return Ok(());
    };
    match &time.unit {
        Some(own) if own.trim() != stated.trim() && seconds_of(own) != seconds_of(&stated) => {
            Err(ReadError::content(
                path,
                format!("the unit of `{}` as the file states it, {own}", time.name),
                stated,
                "correct the one that is wrong",
            ))
        }
        _ => {
            time.unit = Some(stated);
            Ok(())
        }
    }
}

/// Whether a time may be shares of a day, as Excel counts them: its steps are those of a whole rate, and very short ones in s.
fn is_in_days(time: &Column, mean: f64) -> bool {
    let rate_hz = 1.0 / (mean * DAY_S);
    let is_whole = (rate_hz.round() / rate_hz - 1.0).abs() < WHOLE;
    let starts_in_a_day = time
        .values
        .first()
        .is_some_and(|first| (0.0..1.0).contains(first));
    mean < SHORT_S && is_whole && starts_in_a_day
}

/// What 1 in a time column is in s: by its unit, or else guessed from its `mean` step, and from its first and last number where they
/// are a time since 1970.
pub(super) fn seconds_per_unit(
    path: &Path,
    time: &Column,
    mean: f64,
    warnings: &mut Vec<Warning>,
) -> Result<f64, ReadError> {
    let name = &time.name;
    if let Some(unit) = time.unit.as_deref().map(str::trim)
        && !unit.is_empty()
    {
        return seconds_of(unit).ok_or_else(|| {
            ReadError::content(
                path,
                format!("`{name}` in s, ms, µs, ns, min, h or d"),
                unit,
                "correct its unit, or give --rate",
            )
        });
    }
    let (first, last) = (time.values.first(), time.values.last());
    let since_1970 = |factor: f64| {
        let mut ends = first.into_iter().chain(last);
        ends.all(|time| UNIX_S.contains(&(time * factor)))
    };
    let unix = [
        ("milliseconds since 1970", 1e-3),
        ("microseconds since 1970", 1e-6),
        ("nanoseconds since 1970", 1e-9),
    ];
    // Other whole numbers that step by more than one are milliseconds, where that makes a rate that is usual; anything else is seconds.
    let whole = time.values.iter().all(|t| t.fract() == 0.0) && mean > 1.0;
    let (unit, factor) = match unix.into_iter().find(|(_, factor)| since_1970(*factor)) {
        Some(unix) => unix,
        None if whole && mean > MOST_MS => {
            return Err(ReadError::content(
                path,
                format!(
                    "the unit of `{name}`, whose whole numbers step by {}",
                    digits(mean)
                ),
                "none: they may be milliseconds, microseconds or nanoseconds",
                format!(
                    "write it into its name, as in `{name} (us)`, or state it with --scale \"{name}=us\""
                ),
            ));
        }
        None if whole => ("milliseconds", 1e-3),
        None if is_in_days(time, mean) => ("days", DAY_S),
        None if mean < LEAST_STEP_S => {
            return Err(ReadError::content(
                path,
                format!(
                    "the unit of `{name}`, whose numbers step by {}",
                    digits(mean)
                ),
                "none: no recording has so short steps in s",
                format!(
                    "write it into its name, as in `{name} (ms)`; of days, as Excel counts them, `{name} (d)` or --scale \"{name}=d\""
                ),
            ));
        }
        None => ("seconds", 1.0),
    };
    warnings.push(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "`{name}` has no unit and is read as {unit} (mean step {}; another unit: --scale \"{name}=ms\")",
            digits(mean)
        ),
    }));
    Ok(factor)
}
