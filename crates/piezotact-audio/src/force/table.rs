//! The columns of a text file with a header.

use super::error::ForceError;
use super::protocol::number;
use super::unit::ForceUnit;

/// What the names of a force and of a time begin with, in small letters.
const FORCES: [&str; 5] = ["force", "fz", "fn", "load", "normal"];
const TIMES: [&str; 2] = ["time", "t"];

/// Which columns of a file hold the force and its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Columns {
    /// The only column whose name begins with `force`, `Fz`, `Fn`, `load` or `normal`, and the first whose name is `time` or `t`, with
    /// the units that their names state, as in `force_mN`, `Fz [N]`, `time (ms)`.
    ByHeader,
    /// These.
    Named {
        /// The name of the force.
        force: String,
        unit: ForceUnit,
        /// The name and the unit of the time; none where the file states none.
        time: Option<(String, TimeUnit)>,
    },
}

/// The unit in which a file states times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// s.
    Second,
    /// ms.
    Millisecond,
    /// µs.
    Microsecond,
}

impl TimeUnit {
    fn seconds(self) -> f64 {
        match self {
            Self::Second => 1.0,
            Self::Millisecond => 1e-3,
            Self::Microsecond => 1e-6,
        }
    }

    fn of(text: &str) -> Option<Self> {
        match text {
            "s" | "sec" | "seconds" => Some(Self::Second),
            "ms" => Some(Self::Millisecond),
            "us" | "µs" | "μs" => Some(Self::Microsecond),
            _ => None,
        }
    }
}

/// How the lines of a file are read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    delimiter: char,
    force: usize,
    pub(super) unit: ForceUnit,
    time: Option<(usize, TimeUnit)>,
}

impl Table {
    /// The columns that the header `line` of the file `name` names.
    pub(super) fn of(name: &str, line: &str, columns: &Columns) -> Result<Self, ForceError> {
        let delimiter = ['\t', ';', ','].into_iter().find(|d| line.contains(*d));
        let delimiter = delimiter.unwrap_or(',');
        let names: Vec<String> = cells(line, delimiter).map(str::to_owned).collect();
        let wrong = |expected: String, todo: &str| ForceError::Columns {
            name: name.to_owned(),
            expected,
            found: format!("the columns {}", shown(&names)),
            todo: todo.to_owned(),
        };
        let (force, unit, time) = match columns {
            Columns::Named { force, unit, time } => {
                let place = |column: &str| {
                    let found = names.iter().position(|name| name == column);
                    let expected = || format!("a column `{column}`");
                    found.ok_or_else(|| wrong(expected(), "correct its name in the settings"))
                };
                let time = time.as_ref().map(|(time, unit)| Ok((place(time)?, *unit)));
                (place(force)?, *unit, time.transpose()?)
            }
            Columns::ByHeader => {
                let mut forces = names.iter().enumerate().filter(|(_, name)| {
                    let name = name.to_lowercase();
                    FORCES.iter().any(|force| name.starts_with(force))
                });
                let (Some((force, stated)), None) = (forces.next(), forces.next()) else {
                    return Err(wrong(
                        "a header with one column of the force, such as `force_N`".into(),
                        "name the column of the force in the settings",
                    ));
                };
                let unit = unit_of(stated).and_then(|unit| unit.parse().ok());
                let unit = unit.ok_or_else(|| {
                    wrong(
                        format!("a unit in the name `{stated}`, such as `force_N`"),
                        "rename the column, or name it and its unit in the settings",
                    )
                })?;
                (force, unit, time_of(&names, &wrong)?)
            }
        };
        Ok(Self {
            delimiter,
            force,
            unit,
            time,
        })
    }

    /// The time, s, and the force in the unit of the column; none where they are no numbers.
    pub(super) fn read(&self, line: &str) -> Option<(Option<f64>, f64)> {
        let decimal_comma = self.delimiter != ',';
        let cell = |place: usize| {
            let text = cells(line, self.delimiter).nth(place)?;
            match decimal_comma && !text.contains('.') {
                true => number(&text.replacen(',', ".", 1)),
                false => number(text),
            }
        };
        let time = match self.time {
            Some((place, unit)) => Some(unit.seconds() * cell(place)?),
            None => None,
        };
        Some((time, cell(self.force)?))
    }
}

/// The column of the time and its unit, where there is one.
fn time_of(
    names: &[String],
    wrong: &dyn Fn(String, &str) -> ForceError,
) -> Result<Option<(usize, TimeUnit)>, ForceError> {
    let found = names.iter().enumerate().find(|(_, name)| {
        let word = name.to_lowercase();
        let word = word.split(|sign: char| !sign.is_alphabetic()).next();
        word.is_some_and(|word| TIMES.contains(&word))
    });
    let Some((place, stated)) = found else {
        return Ok(None);
    };
    let unit = unit_of(stated).and_then(TimeUnit::of).ok_or_else(|| {
        wrong(
            format!("a unit in the name `{stated}`, such as `time_s`"),
            "rename the column, or name it and its unit in the settings",
        )
    })?;
    Ok(Some((place, unit)))
}

/// The unit at the end of a column's name: `force_N`, `force [N]`, `force (N)`, `force/N`, `force N`.
fn unit_of(name: &str) -> Option<&str> {
    let name = name.trim_end_matches([']', ')']);
    let (_, unit) = name.rsplit_once(['_', '[', '(', '/', ' '])?;
    Some(unit.trim())
}

/// The cells of a line, without quotes and space around them.
fn cells(line: &str, delimiter: char) -> impl Iterator<Item = &str> {
    line.trim_start_matches('\u{feff}')
        .split(delimiter)
        .map(|cell| cell.trim().trim_matches('"').trim())
}

fn shown(names: &[String]) -> String {
    let names: Vec<String> = names
        .iter()
        .take(12)
        .map(|name| format!("`{}`", name.chars().take(40).collect::<String>()))
        .collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(header: &str) -> Result<Table, ForceError> {
        Table::of("file", header, &Columns::ByHeader)
    }

    #[test]
    fn names_state_column_and_unit() {
        for (header, line, expected) in [
            ("time_s,force_N", "1.5,0.2", (Some(1.5), 0.2)),
            (
                "\u{feff}\"time (ms)\";\"Fz [mN]\"",
                "1500;200,5",
                (Some(1.5), 200.5),
            ),
            ("load/g\tt_us\tother", "20\t1500000\tx", (Some(1.5), 20.0)),
            ("temperature,Force (N)", "20,0.25", (None, 0.25)),
            ("force N", " 0.25 ", (None, 0.25)),
        ] {
            let found = table(header).unwrap().read(line).unwrap();
            assert_eq!(found, expected, "{header}");
        }
        assert_eq!(table("Fz [mN]").unwrap().unit, ForceUnit::Millinewton);
    }

    #[test]
    fn what_is_not_clear_is_refused() {
        for header in [
            "time_s,pressure",
            "time_s,force_N,load_N",
            "time_s,force",
            "time,force_N",
            "",
        ] {
            let error = table(header).unwrap_err();
            assert!(matches!(error, ForceError::Columns { .. }), "{header}");
        }
        let named = Columns::Named {
            force: "a".into(),
            unit: ForceUnit::Newton,
            time: Some(("b".into(), TimeUnit::Second)),
        };
        assert!(Table::of("file", "a,b", &named).is_ok());
        assert!(Table::of("file", "a,c", &named).is_err());
    }

    #[test]
    fn cells_that_are_no_numbers_are_none() {
        let table = table("time_s,force_N").unwrap();
        for line in ["1", "1,", "1,nan", "x,1", "", "1;2", "inf,1"] {
            assert_eq!(table.read(line), None, "{line}");
        }
    }
}
