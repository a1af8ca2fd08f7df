//! Units of separate channels that stand beside them: in a structure `units` whose fields are called as the channels are, or in a list.

use std::collections::HashMap;

use super::MatValue;
use super::signals::{Found, NAMES, Variables, outwards};
use crate::stated_rate::UNIT_WORDS;

/// What is stated of the units of channels, by their number; and what was taken from it or was not.
#[derive(Default)]
pub(super) struct Stated {
    pub(super) units: HashMap<usize, String>,
    pub(super) said: Vec<String>,
}

impl Stated {
    /// By the names of the channels in a structure of units, else in a list beside them, else by the order of fields, which MATLAB
    /// keeps in structures alone.
    pub(super) fn of(found: &mut Found, variables: &Variables<'_>) -> Self {
        let mut stated = Self::default();
        for (number, signal) in found.signals.iter().enumerate() {
            let variable = &variables.all[signal.at];
            let column = signal.column.name.to_ascii_lowercase();
            let unit = variables
                .unit_in_structure(&variable.scope, &variable.last)
                .or_else(|| variables.unit_in_structure(&variable.scope, &column));
            stated.units.extend(unit.map(|unit| (number, unit)));
        }
        for (at, list) in variables.all.iter().enumerate() {
            if let (true, Some(units)) = (list.is(&UNIT_WORDS), texts_of(list.value)) {
                stated.add_list(found, variables, at, &units);
            }
        }
        stated
    }

    /// The channels whose nearest list of units is that of number `list`, in groups that stand in one place.
    fn places_of(
        &self,
        found: &Found,
        variables: &Variables<'_>,
        list: usize,
    ) -> Vec<(String, Vec<usize>)> {
        let is_list = |at: &usize| {
            let other = &variables.all[*at];
            other.is(&UNIT_WORDS) && texts_of(other.value).is_some()
        };
        let mut places = Vec::<(String, Vec<usize>)>::new();
        for (number, signal) in found.signals.iter().enumerate() {
            let scope = &variables.all[signal.at].scope;
            let nearest = outwards(scope).find_map(|place| variables.at(place).find(is_list));
            if nearest != Some(list) {
                continue;
            }
            match places.iter_mut().find(|(place, _)| place == scope) {
                Some((_, numbers)) => numbers.push(number),
                None => places.push((scope.clone(), vec![number])),
            }
        }
        // A list among channels is that of these, not of channels further in.
        let own = &variables.all[list].scope;
        if places.iter().any(|(place, _)| place == own) {
            places.retain(|(place, _)| place == own);
        }
        places
    }

    fn add_list(
        &mut self,
        found: &mut Found,
        variables: &Variables<'_>,
        list: usize,
        units: &[String],
    ) {
        let name = &variables.all[list].name;
        let names = (variables.here(&variables.all[list].scope))
            .filter(|variable| variable.is(&NAMES))
            .find_map(|names| texts_of(names.value).filter(|names| names.len() == units.len()))
            .unwrap_or_default();
        for (place, mut bare) in self.places_of(found, variables, list) {
            // Columns of one matrix have theirs already.
            bare.retain(|number| found.signals[*number].column.unit.is_none());
            if bare.iter().all(|number| self.units.contains_key(number)) {
                continue;
            }
            let named = |number: &usize| format!("`{}`", found.signals[*number].column.name);
            let by_name: Vec<(usize, usize)> = (bare.iter())
                .filter_map(|number| {
                    let own = &variables.all[found.signals[*number].at].last;
                    let is_own = |name: &String| name.trim().eq_ignore_ascii_case(own);
                    Some((*number, names.iter().position(is_own)?))
                })
                .collect();
            let times: Vec<(usize, usize)> = found.times.here(&place).collect();
            // In the order of the file, each with the number of its channel or of its time.
            let mut fields: Vec<(usize, Result<usize, usize>)> = (bare.iter())
                .map(|number| (found.signals[*number].at, Ok(*number)))
                .collect();
            if fields.len() != units.len() {
                fields.extend(times.iter().map(|(at, time)| (*at, Err(*time))));
                fields.sort_unstable();
            }
            let fits = fields.len() == units.len();
            let is_one = units.iter().all(|unit| unit == &units[0]);
            if !by_name.is_empty() {
                for (number, at) in by_name {
                    let unit = || units[at].trim().to_owned();
                    self.units.entry(number).or_insert_with(unit);
                }
            } else if fits && (is_one || !place.is_empty()) {
                if !is_one {
                    let pairs = (fields.iter().zip(units))
                        .filter_map(|((_, of), unit)| Some((of.as_ref().ok()?, unit)))
                        .map(|(number, unit)| format!("{} in {}", named(number), unit.trim()));
                    self.said.push(format!(
                        "the units of `{name}` are taken in the order of the fields: {}",
                        pairs.collect::<Vec<_>>().join(", ")
                    ));
                }
                for ((_, of), unit) in fields.into_iter().zip(units) {
                    let unit = unit.trim().to_owned();
                    match of {
                        Ok(number) => {
                            self.units.entry(number).or_insert(unit);
                        }
                        Err(time) => {
                            let time = &mut found.times.columns[time].unit;
                            *time = time.take().or(Some(unit));
                        }
                    }
                }
            } else {
                let names: Vec<String> = bare.iter().take(6).map(named).collect();
                let why = match fits {
                    true => "only the fields of a structure have an order",
                    false => "the list is not as long",
                };
                self.said.push(format!(
                    "the units of `{name}` ({}) were not applied to {}: {why} (`units.NAME = 'mN'` states them by name)",
                    units.join(", "),
                    names.join(", ")
                ));
            }
        }
    }
}

/// The texts of a list: cells, or the rows of a text. Cells without anything in them are empty.
pub(super) fn texts_of(value: &MatValue) -> Option<Vec<String>> {
    match value {
        MatValue::Text(rows) if rows.len() > 1 => {
            Some(rows.iter().map(|row| row.trim().to_owned()).collect())
        }
        MatValue::Cell { values, .. } if !values.is_empty() => {
            let texts = values.iter().map(|value| match value {
                MatValue::Numbers(numbers) if numbers.real.is_empty() => Some(String::new()),
                value => value.text().map(str::to_owned),
            });
            texts.collect()
        }
        _ => None,
    }
}
