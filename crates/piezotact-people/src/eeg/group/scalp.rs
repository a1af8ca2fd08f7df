//! Means over people on the scalp.

use piezotact::statistics::mean;
use serde::{Deserialize, Serialize};

use super::people::People;
use crate::eeg::erd::Mode;
use crate::eeg::person::Change;

/// What a scalp map is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// The change in one task.
    Task(String),
    /// The change in the second task less that in the first, of people in both.
    Difference([String; 2]),
}

/// The mean over people and surfaces at the electrodes of the maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Scalp {
    /// What it is of.
    pub shown: Shown,
    /// The name of the band.
    pub band: String,
    /// How many people.
    pub people: usize,
    /// The mean at each electrode, in the unit.
    pub values: Vec<f64>,
}

/// The means of each task and of each difference of two, in each band.
pub(super) fn scalps(people: &People<'_>, unit: Mode) -> Vec<Scalp> {
    let mut all = Vec::new();
    for band in &people.first.config.bands {
        let of = |who: &String, task: &String| of_person(people, (who, task), &band.name, unit);
        for task in &people.tasks {
            let values = people.participants.iter().filter_map(|who| of(who, task));
            all.extend(averaged(
                Shown::Task(task.clone()),
                &band.name,
                &values.collect::<Vec<_>>(),
            ));
        }
        for [a, b] in people.pairs() {
            let values = people.participants.iter().filter_map(|who| {
                let (first, second) = (of(who, &a)?, of(who, &b)?);
                Some(first.iter().zip(second).map(|(a, b)| b - a).collect())
            });
            let values: Vec<Vec<f64>> = values.collect();
            all.extend(averaged(Shown::Difference([a, b]), &band.name, &values));
        }
    }
    all
}

fn averaged(shown: Shown, band: &str, values: &[Vec<f64>]) -> Option<Scalp> {
    let electrodes = values.first()?.len();
    let at = |electrode: usize| {
        let own: Vec<f64> = values.iter().map(|one| one[electrode]).collect();
        mean(&own)
    };
    Some(Scalp {
        shown,
        band: band.to_owned(),
        people: values.len(),
        values: (0..electrodes).map(at).collect(),
    })
}

/// The mean over surfaces at each electrode; nothing without electrodes, or for a person without the task or a surface.
fn of_person(
    people: &People<'_>,
    (who, task): (&str, &str),
    band: &str,
    unit: Mode,
) -> Option<Vec<f64>> {
    let document = people.get(who, task)?;
    let surface = people.surfaces_and_mean().pop()?;
    if people.electrodes.is_empty() {
        return None;
    }
    let at = |name: &String| {
        let value = |change: &Change| change.value(unit);
        let found = people.of_document(&document.electrodes, &value, |change| {
            change.band == band && change.place == *name
        });
        let own = found.into_iter().find(|(of, _)| *of == surface);
        own.map(|(_, value)| value)
    };
    people.electrodes.iter().map(|one| at(&one.name)).collect()
}
