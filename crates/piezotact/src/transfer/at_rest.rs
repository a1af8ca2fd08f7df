//! Whether a sensor still reads as it did: the response of a device with nobody on it, against its stored response.

use crate::transfer::TransferError;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::TransferFunction;
use super::bundle::level_db;
use crate::criterion::{Criterion, Limit, Outcome};
use crate::device::DriveSetup;
use crate::quantity::{Band, Quantity};
use crate::statistics::median;

/// The largest change of the level, dB: half of 3 dB, the smallest usual step of a knob. What nobody has turned changes less: two
/// measurements of 5 s agree within 0.1 dB in the median, and sensitivities of accelerometers are stated within 10 % (0.8 dB).
const MOST_LEVEL_DB: f64 = 1.5;
/// The largest median distance of a line from that change, dB. A knob moves all lines alike; a finger on the device, a sensor that
/// came loose, or another actuator moves each otherwise, by some dB.
const MOST_SHAPE_DB: f64 = 1.0;
/// Lines with less coherence say little of the level.
const LEAST_COHERENCE: f64 = 0.8;
/// A median of fewer lines is not judged.
const LEAST_LINES: usize = 10;

/// What is judged of a response at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AtRestCriterion {
    /// The median change of level.
    Level,
    /// The median distance of a line from that change.
    Shape,
}

impl fmt::Display for AtRestCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Level => "level of the sensor relative to its stored response",
            Self::Shape => "distance of the lines from that change",
        })
    }
}

/// A response at rest against the stored one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AtRest {
    /// How many lines were compared.
    pub lines: usize,
    pub criteria: Vec<Criterion<AtRestCriterion>>,
}

impl AtRest {
    /// All criteria together.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|one| one.outcome))
    }
}

/// The response `now` against the `stored` one of the same device, both measured with nobody on it, over the lines in `band` that
/// both drove with a coherence of 0.8 or more: a sensor whose amplifier was turned is found, which the loopback cannot see.
///
/// Formula: the median over lines of 20·log10|now/stored|, within ±1.5 dB; and the median absolute deviation from it, at most 1 dB.
///
/// Source: docs/decisions/sound.md, which has the reasons of the limits.
///
/// # Errors
/// [`TransferError`] when they were measured through other gains or with other people.
pub fn at_rest<I: Quantity, O: Quantity>(
    now: &TransferFunction<I, O>,
    stored: &TransferFunction<I, O>,
    band: Band,
) -> Result<AtRest, TransferError> {
    if let (Some(before), Some(found)) = (&stored.drive, &now.drive)
        && !before.amplifies_like(found)
    {
        let [stored, found] = [before, found].map(DriveSetup::amplification);
        return Err(TransferError::RestDevice { stored, found });
    }
    let person = |function: &TransferFunction<I, O>| {
        let person = function.about.condition.person();
        person.unwrap_or_else(|| "nobody".to_owned())
    };
    if person(stored) != person(now) {
        return Err(TransferError::RestPerson {
            stored: person(stored),
            found: person(now),
        });
    }
    let is_excited = |function: &TransferFunction<I, O>, hz: f64| {
        function.excited.is_none_or(|excited| excited.contains(hz))
            && hz <= function.highest_hz()
            && function.coherence_at(hz) >= LEAST_COHERENCE
    };
    let mut changes: Vec<f64> = stored
        .lines_in(band)
        .filter(|(_, hz)| is_excited(stored, *hz) && is_excited(now, *hz))
        .map(|(line, hz)| level_db(now.at(hz)) - level_db(stored.response[line]))
        .filter(|change| change.is_finite())
        .collect();
    let lines = changes.len();
    let [level, shape] = [
        Limit::Within {
            reach: MOST_LEVEL_DB,
        },
        Limit::at_most(MOST_SHAPE_DB),
    ];
    let found = (lines >= LEAST_LINES)
        .then(|| median(&mut changes))
        .flatten();
    let Some(level_db) = found else {
        let open = [
            (AtRestCriterion::Level, level),
            (AtRestCriterion::Shape, shape),
        ];
        let open = open.map(|(what, limit)| Criterion::unmeasured(what, "dB", limit));
        return Ok(AtRest {
            lines,
            criteria: open.into(),
        });
    };
    let mut apart: Vec<f64> = changes.iter().map(|one| (one - level_db).abs()).collect();
    let shape_db = median(&mut apart).unwrap_or(f64::NAN);
    Ok(AtRest {
        lines,
        criteria: vec![
            Criterion::new(AtRestCriterion::Level, "dB", level_db, None, level),
            Criterion::new(AtRestCriterion::Shape, "dB", shape_db, None, shape),
        ],
    })
}
