//! Effects of load and angle on people's gains.

use serde::{Deserialize, Serialize};

use super::levels::{Levels, steps};
use crate::quantity::{Degrees, Newtons};
use crate::statistics::{PairedDifference, mean, paired_difference, rms, sign_test};

/// The effect of a heavier load at one angle, over people who were measured at both loads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoadStep {
    /// The angle.
    pub angle_deg: Degrees,
    /// The lighter load.
    pub from_n: Newtons,
    /// The heavier load.
    pub to_n: Newtons,
    /// Everybody.
    pub people: Vec<ParticipantStep>,
    /// How many people's mean gain rises.
    pub rising: usize,
    /// The smallest share, over people, of lines on which the gain rises, 0–1.
    pub least_rising_share: f64,
    /// The mean over people, dB.
    pub mean_db: f64,
    /// The paired test of it; absent for fewer than two people or steps that are all the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paired: Option<PairedDifference>,
    /// The probability that as many rise, or fall, by chance alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign_test_p: Option<f64>,
}

/// The effect of a heavier load for one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ParticipantStep {
    /// The pseudonym.
    pub participant: String,
    /// The mean over the lines of the band, dB.
    pub mean_db: f64,
    /// The share of the lines on which the gain rises, 0–1.
    pub rising_share: f64,
}

/// The effect of a steeper angle, over people who were measured at both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AngleEffect {
    /// The flatter angle.
    pub from_deg: Degrees,
    /// The steeper angle.
    pub to_deg: Degrees,
    /// At one load; absent over all loads together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_n: Option<Newtons>,
    /// Everybody.
    pub people: Vec<ParticipantShape>,
    /// The median over people of the rms difference, dB.
    pub median_db_rms: f64,
    /// The largest, dB.
    pub largest_db_rms: f64,
    /// Whose it is.
    pub largest_of: String,
    /// How many people are louder at the steeper angle.
    pub louder: usize,
    /// The mean over people, dB.
    pub mean_db: f64,
    /// The paired test of it; absent for fewer than two people or steps that are all the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paired: Option<PairedDifference>,
    /// The probability that as many are louder, or fainter, by chance alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign_test_p: Option<f64>,
}

/// The effect of a steeper angle for one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ParticipantShape {
    /// The pseudonym.
    pub participant: String,
    /// The mean over the lines of the band, dB.
    pub mean_db: f64,
    /// The rms over the lines of the band, dB; over loads the largest of them.
    pub db_rms: f64,
}

/// Mean, paired test and sign test of `steps_db`; identical steps have a mean but no test.
fn tested(steps_db: &[f64]) -> (f64, Option<PairedDifference>, Option<f64>) {
    let zero = vec![0.0; steps_db.len()];
    (
        mean(steps_db),
        paired_difference(&zero, steps_db),
        sign_test(steps_db),
    )
}

/// The effects of load at every angle, in dB: from the lightest to the heaviest, and between neighbouring loads, over people
/// who were measured at both.
///
/// Formula: the mean over lines of `20·log10|H(heavier)| − 20·log10|H(lighter)|`, person by person; Student's paired t
/// and the sign test over people.
///
/// Source: L. Felicetti's thesis (2024), figures 70 and 74; [`paired_difference`], [`sign_test`].
pub(super) fn by_load(levels: &Levels) -> Vec<LoadStep> {
    let mut found = Vec::new();
    for angle_deg in levels.angles_deg() {
        for (from_n, to_n) in steps(&levels.loads_n()) {
            let cells = levels
                .cell(from_n, angle_deg)
                .zip(levels.cell(to_n, angle_deg));
            let Some((light, heavy)) = cells else {
                continue;
            };
            let people: Vec<ParticipantStep> = difference(levels, light, heavy)
                .into_iter()
                .map(|(person, step)| {
                    let rising = step.iter().filter(|db| **db > 0.0).count();
                    ParticipantStep {
                        participant: levels.people[person].clone(),
                        mean_db: mean(&step),
                        rising_share: rising as f64 / step.len() as f64,
                    }
                })
                .collect();
            if people.is_empty() {
                continue;
            }
            let steps_db: Vec<f64> = people.iter().map(|p| p.mean_db).collect();
            let (mean_db, paired, sign_test_p) = tested(&steps_db);
            found.push(LoadStep {
                angle_deg: Degrees(angle_deg),
                from_n: Newtons(from_n),
                to_n: Newtons(to_n),
                rising: steps_db.iter().filter(|db| **db > 0.0).count(),
                least_rising_share: people.iter().map(|p| p.rising_share).fold(1.0, f64::min),
                people,
                mean_db,
                paired,
                sign_test_p,
            });
        }
    }
    found
}

/// Line by line, b − a of everybody who is in both cells, dB.
fn difference(levels: &Levels, a: usize, b: usize) -> Vec<(usize, Vec<f64>)> {
    levels
        .complete(&[a, b])
        .into_iter()
        .filter_map(|person| {
            let (a, b) = (levels.at(person, a)?, levels.at(person, b)?);
            let off = a.db.iter().zip(&b.db).map(|(a, b)| b - a).collect();
            Some((person, off))
        })
        .collect()
}

/// The effects of angle, in dB: between the flattest and the steepest and between neighbouring angles, at every load and over
/// all loads together, over people who were measured at both (at all loads).
///
/// Formula: over lines, the rms and the mean of `20·log10|H(steeper)| − 20·log10|H(flatter)|`, person by person, the mean
/// averaged over loads; Student's paired t and the sign test over people.
///
/// Source: L. Felicetti's thesis (2024), figure 75; [`paired_difference`], [`sign_test`].
pub(super) fn by_angle(levels: &Levels) -> Vec<AngleEffect> {
    let mut found = Vec::new();
    for (from_deg, to_deg) in steps(&levels.angles_deg()) {
        let at_loads: Vec<(f64, Vec<ParticipantShape>)> = levels
            .loads_n()
            .into_iter()
            .filter_map(|load_n| {
                let cells = (levels.cell(load_n, from_deg)?, levels.cell(load_n, to_deg)?);
                let shapes = difference(levels, cells.0, cells.1).into_iter();
                let shapes = shapes.map(|(person, off)| ParticipantShape {
                    participant: levels.people[person].clone(),
                    mean_db: mean(&off),
                    db_rms: rms(&off),
                });
                Some((load_n, shapes.collect()))
            })
            .collect();
        let effect = |load_n, people| effect_of(Degrees(from_deg), Degrees(to_deg), load_n, people);
        if at_loads.len() > 1 {
            found.extend(effect(None, over_loads(&at_loads)));
        }
        for (load_n, people) in at_loads {
            found.extend(effect(Some(Newtons(load_n)), people));
        }
    }
    found
}

/// Everybody who is there at all loads: the mean of the means, and the largest rms.
fn over_loads(at_loads: &[(f64, Vec<ParticipantShape>)]) -> Vec<ParticipantShape> {
    let Some((_, first)) = at_loads.first() else {
        return Vec::new();
    };
    first
        .iter()
        .filter_map(|person| {
            let own: Vec<&ParticipantShape> = at_loads
                .iter()
                .map(|(_, people)| people.iter().find(|p| p.participant == person.participant))
                .collect::<Option<_>>()?;
            Some(ParticipantShape {
                participant: person.participant.clone(),
                mean_db: mean(&own.iter().map(|p| p.mean_db).collect::<Vec<_>>()),
                db_rms: own.iter().map(|p| p.db_rms).fold(0.0, f64::max),
            })
        })
        .collect()
}

fn effect_of(
    from_deg: Degrees,
    to_deg: Degrees,
    load_n: Option<Newtons>,
    people: Vec<ParticipantShape>,
) -> Option<AngleEffect> {
    let largest = people.iter().max_by(|a, b| a.db_rms.total_cmp(&b.db_rms))?;
    let (largest_db_rms, largest_of) = (largest.db_rms, largest.participant.clone());
    let mut shapes: Vec<f64> = people.iter().map(|p| p.db_rms).collect();
    let steps_db: Vec<f64> = people.iter().map(|p| p.mean_db).collect();
    let (mean_db, paired, sign_test_p) = tested(&steps_db);
    Some(AngleEffect {
        from_deg,
        to_deg,
        load_n,
        median_db_rms: crate::statistics::median(&mut shapes)?,
        largest_db_rms,
        largest_of,
        louder: steps_db.iter().filter(|db| **db > 0.0).count(),
        people,
        mean_db,
        paired,
        sign_test_p,
    })
}
