//! Whether a session may begin: who takes part, what was done before, and what will be played.
//!
//! Everything that is missing is said at once, so that a volunteer is not called in vain.

mod error;
mod made;

use std::collections::BTreeSet;

pub use error::NotReady;

use piezotact::checksum::Checksum;
use piezotact::compare::plain_name;
use piezotact::criterion::Outcome;
use piezotact::lineage::Lineage;
use piezotact::recording::{BenchKind, Condition};
use piezotact::transfer::AtRest;

use super::plan::{Plan, Presented};
use super::protocol::{Protocol, Rendering, TransferFunctionUse, When};

/// Sessions on different days have at least this time between them, in hours: an evening and the next morning have it, the morning
/// and the evening of one day do not, whatever the time zone.
const ANOTHER_DAY_HOURS: f64 = 12.0;
/// A sensor was checked at most this long before its session, in hours: on the day of the session.
const SENSOR_HOURS: f64 = 12.0;
const MS_PER_HOUR: f64 = 3.6e6;

/// Whose transfer function a drive was rendered with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Whose {
    /// That of this participant.
    Of(String),
    /// The average of a panel.
    Average,
    /// Nothing says it.
    Unknown,
}

impl Whose {
    fn words(&self) -> String {
        match self {
            Self::Of(person) => format!("the transfer function of {person}"),
            Self::Average => "an averaged transfer function".to_owned(),
            Self::Unknown => "a transfer function that does not say whose it is".to_owned(),
        }
    }
}

/// Of which drive a measurement is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredDrive {
    /// Of this one, by its checksum.
    This,
    /// Of another one.
    Another,
    /// The recording does not say it: another system made it.
    Unstated,
}

/// A measurement that a drive rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The strokes that it was made from.
    Strokes,
    /// The transfer function that it was rendered with.
    TransferFunction,
    /// The recording that it was verified with.
    Measurement,
}

impl Part {
    const ALL: [Self; 3] = [Self::Strokes, Self::TransferFunction, Self::Measurement];

    fn words(self) -> &'static str {
        match self {
            Self::Strokes => "strokes",
            Self::TransferFunction => "a transfer function",
            Self::Measurement => "a measurement of the drive",
        }
    }
}

/// On what, on whom and when something was measured. What nothing says is absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    pub bench: Option<BenchKind>,
    pub condition: Condition,
    /// In ms since 1970-01-01 00:00 UTC.
    pub at_ms: Option<i64>,
}

/// What is known of the drive of one stimulus.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderingFacts {
    pub stimulus: String,
    /// The file of the drive.
    pub file: String,
    /// The checksum of the samples of the drive.
    pub samples: Checksum,
    /// What the drive was made from, and how; `None` where nothing says it.
    pub lineage: Option<Lineage>,
    /// The level that it was rendered at, relative to its texture, in dB.
    pub level_db: f64,
    /// The strokes that it was made from.
    pub strokes: Origin,
    /// The transfer function that it was rendered with.
    pub transfer_function: Origin,
    /// The recording that it was verified with.
    pub measurement: Origin,
    /// With whose transfer function it was rendered.
    pub rendered_with: Whose,
    /// Whether it passed its verification.
    pub verified: Outcome,
    /// Of which drive the measurement is that it was verified with.
    pub measured: MeasuredDrive,
    /// Why the bench, as it is now, does not play it: a sentence for each reason, of gain, device, output level and rate.
    pub refused: Vec<String>,
}

impl RenderingFacts {
    fn origin(&self, part: Part) -> &Origin {
        match part {
            Part::Strokes => &self.strokes,
            Part::TransferFunction => &self.transfer_function,
            Part::Measurement => &self.measurement,
        }
    }
}

/// The bench on which the session plays, as it is now.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchNow {
    pub kind: BenchKind,
    /// Whose finger is on it, where it says so, and how the finger lies in the session.
    pub condition: Condition,
}

/// What the response of the device with nobody on it says of its sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorNow {
    /// The response against its stored one.
    pub against_stored: AtRest,
    /// When it was measured, in ms since 1970-01-01 00:00 UTC; `None` where nothing says it.
    pub at_ms: Option<i64>,
}

/// A session that stands before another in the protocol.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarlierSession<'a> {
    pub session: &'a str,
    /// When it ended, in ms since 1970-01-01 00:00 UTC; `None` where it did not.
    pub ended_ms: Option<i64>,
}

/// What is known before a session begins.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The drives that are there.
    pub renderings: &'a [RenderingFacts],
    /// The stimuli of which some files are there, with those that are not.
    pub incomplete: &'a [(String, String)],
    /// The earlier sessions of this participant.
    pub earlier: &'a [EarlierSession<'a>],
    /// Panels by name with their members.
    pub panels: &'a [(String, BTreeSet<String>)],
    /// The bench that plays; `None` where nothing is played here: by hand on another system, or not at all.
    pub bench: Option<&'a BenchNow>,
    /// The check of its sensor; `None` where none was made.
    pub sensor: Option<&'a SensorNow>,
    /// The time now, in ms since 1970-01-01 00:00 UTC.
    pub now_ms: i64,
}

/// The stimuli that `plan` plays or may choose, each once.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn stimuli_of(plan: &Plan) -> BTreeSet<&str> {
    let planned = plan
        .trials
        .iter()
        .filter_map(|trial| match &trial.presented {
            Presented::Rendered { stimuli } => Some(stimuli),
            _ => None,
        });
    let chosen = plan.runs.values().flat_map(|run| {
        let levels = run.levels.iter().map(|level| &level.stimulus);
        levels.chain([&run.standard])
    });
    planned
        .flatten()
        .chain(chosen)
        .map(String::as_str)
        .collect()
}

/// Everything for which the session of `plan` may not begin; nothing, when it may.
///
/// Source: thesis 2.6.2 and 5.3, measurement and discrimination on two days, individual transfer functions, disjoint panels;
/// docs/decisions/campaigns.md.
#[must_use]
pub fn not_ready(protocol: &Protocol, plan: &Plan, known: Known<'_>) -> Vec<NotReady> {
    let mut found = panels(protocol, plan, known);
    found.extend(earlier(protocol, plan, known));
    found.extend(
        known
            .bench
            .and_then(|bench| finger(&plan.participant, bench)),
    );
    found.extend(known.sensor.iter().flat_map(|now| sensor(now, known)));
    let mut drives = Vec::new();
    for stimulus in stimuli_of(plan) {
        let facts = known.renderings.iter().find(|one| one.stimulus == stimulus);
        drives.extend(facts);
        match facts {
            None => found.push(missing(stimulus, known.incomplete)),
            Some(facts) => {
                found.extend(of_drive(protocol, plan, facts, known.now_ms));
                found.extend(known.bench.iter().flat_map(|bench| on_bench(facts, bench)));
            }
        }
    }
    found.extend(made::faults(protocol, &drives));
    found
}

/// What of a stimulus without a drive is not there.
fn missing(stimulus: &str, incomplete: &[(String, String)]) -> NotReady {
    let mut incomplete = incomplete.iter();
    let stimulus = stimulus.to_owned();
    match incomplete.find(|(of, _)| *of == stimulus) {
        Some((_, files)) => NotReady::Incomplete {
            stimulus,
            files: files.clone(),
        },
        None => NotReady::Missing { stimulus },
    }
}

/// Who would feel what is played, where it is not the participant. Real devices need not say whose finger is on them.
fn finger(participant: &str, bench: &BenchNow) -> Option<NotReady> {
    let participant = participant.to_owned();
    let kind = bench.kind;
    match (kind, &bench.condition.participant) {
        (BenchKind::Hardware, None) => None,
        (BenchKind::Hardware | BenchKind::Twin, Some(found)) => {
            (!found.eq_ignore_ascii_case(&participant)).then(|| NotReady::OtherFinger {
                participant,
                found: found.clone(),
            })
        }
        (BenchKind::Twin | BenchKind::Measured | BenchKind::Scripted, _) => {
            Some(NotReady::NoFinger {
                participant,
                bench: kind,
            })
        }
    }
}

/// What is wrong with the sensor, and with the time of its check. What is simulated states no time.
fn sensor(sensor: &SensorNow, known: Known<'_>) -> Vec<NotReady> {
    let criteria = sensor.against_stored.criteria.iter();
    let faults = criteria.filter(|one| one.outcome != Outcome::Met);
    let mut found: Vec<NotReady> = faults.cloned().map(NotReady::Sensor).collect();
    let hours = sensor.at_ms.map(|at_ms| hours_between(at_ms, known.now_ms));
    let is_real = known
        .bench
        .is_some_and(|bench| bench.kind == BenchKind::Hardware);
    if hours.map_or(is_real, |hours| hours.abs() > SENSOR_HOURS) {
        found.push(NotReady::SensorOld { hours });
    }
    found
}

/// What of a drive does not fit the bench that is to play it.
fn on_bench(facts: &RenderingFacts, bench: &BenchNow) -> Vec<NotReady> {
    let stimulus = || facts.stimulus.clone();
    let refused = facts.refused.iter().map(|why| NotReady::Refused {
        stimulus: stimulus(),
        why: why.clone(),
    });
    let mut found: Vec<NotReady> = refused.collect();
    let here = &bench.condition;
    for part in Part::ALL {
        let origin = facts.origin(part);
        let there = &origin.condition;
        if let Some(kind) = origin.bench.filter(|kind| *kind != bench.kind) {
            found.push(NotReady::OtherBench {
                stimulus: stimulus(),
                part,
                expected: bench.kind,
                found: kind,
            });
            continue;
        }
        if let (Some(expected), Some(seed)) = (here.twin_seed, there.twin_seed)
            && expected != seed
        {
            found.push(NotReady::TwinSeed {
                stimulus: stimulus(),
                part,
                expected,
                found: seed,
            });
        }
        // A finger that strokes lies as it likes.
        if part != Part::Strokes {
            let placements = placements(here, there).map(|(expected, lay)| NotReady::Placement {
                stimulus: stimulus(),
                part,
                expected,
                found: lay,
            });
            found.extend(placements);
        }
    }
    found
}

/// Load and angle that both state and that differ, as they are `here` and were `there`.
fn placements(here: &Condition, there: &Condition) -> impl Iterator<Item = (String, String)> {
    let load = here.load_n.zip(there.load_n).filter(|(a, b)| a != b);
    let load = load.map(|(a, b)| (a.to_string(), b.to_string()));
    let angle = here.angle_deg.zip(there.angle_deg);
    let angle = angle.filter(|(a, b)| a != b);
    let angle = angle.map(|(a, b)| (format!("{}°", a.0), format!("{}°", b.0)));
    load.into_iter().chain(angle)
}

fn panels(protocol: &Protocol, plan: &Plan, known: Known<'_>) -> Vec<NotReady> {
    let mut found = Vec::new();
    for panel in &protocol.panel.disjoint_from {
        let members = known.panels.iter().find(|(name, _)| name == panel);
        match members {
            None => found.push(NotReady::UnknownPanel {
                panel: panel.clone(),
            }),
            // Names that differ in capital letters or zeros only are one person everywhere in a study.
            Some((_, members))
                if members
                    .iter()
                    .any(|member| plain_name(member) == plain_name(&plan.participant)) =>
            {
                found.push(NotReady::Panel {
                    participant: plan.participant.clone(),
                    panel: panel.clone(),
                });
            }
            Some(_) => {}
        }
    }
    found
}

/// The sessions before this one: each ended, and the last one on another day where the protocol says so.
fn earlier(protocol: &Protocol, plan: &Plan, known: Known<'_>) -> Vec<NotReady> {
    let place = protocol.sessions.iter();
    let place = place.clone().position(|one| one.name == plan.session);
    let Some(place) = place else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (i, before) in protocol.sessions[..place].iter().enumerate() {
        let done = known.earlier.iter().find(|one| one.session == before.name);
        let Some(ended_ms) = done.and_then(|one| one.ended_ms) else {
            found.push(NotReady::Earlier {
                session: before.name.clone(),
            });
            continue;
        };
        let hours = hours_between(ended_ms, known.now_ms);
        let last = i + 1 == place;
        if last && protocol.sessions[place].when == When::AnotherDay && hours < ANOTHER_DAY_HOURS {
            found.push(NotReady::SameDay {
                session: before.name.clone(),
                hours,
            });
        }
    }
    found
}

/// Times that were read from files can be any numbers.
fn hours_between(earlier_ms: i64, later_ms: i64) -> f64 {
    later_ms.saturating_sub(earlier_ms) as f64 / MS_PER_HOUR
}

fn of_drive(
    protocol: &Protocol,
    plan: &Plan,
    facts: &RenderingFacts,
    now_ms: i64,
) -> Vec<NotReady> {
    let stimulus = || facts.stimulus.clone();
    let mut found = Vec::new();
    let Some(rendering) = &protocol.rendering else {
        return found;
    };
    let participant = &plan.participant;
    let somebody = facts.strokes.condition.participant.as_ref();
    if somebody != Some(participant) {
        found.push(NotReady::Strokes {
            stimulus: stimulus(),
            participant: participant.clone(),
            found: somebody.map_or_else(|| "somebody who is not stated".to_owned(), Clone::clone),
        });
    }
    let expected = match &rendering.transfer_function {
        TransferFunctionUse::Own => Whose::Of(participant.clone()),
        TransferFunctionUse::Average { .. } => Whose::Average,
    };
    if facts.rendered_with != expected {
        found.push(NotReady::TransferFunction {
            stimulus: stimulus(),
            expected: expected.words(),
            found: facts.rendered_with.words(),
        });
    }
    if facts.verified != Outcome::Met {
        found.push(NotReady::NotPassed {
            stimulus: stimulus(),
            outcome: facts.verified,
        });
    }
    if facts.measured == MeasuredDrive::Another {
        found.push(NotReady::Measured {
            stimulus: stimulus(),
        });
    }
    for part in Part::ALL {
        found.extend(age(rendering, facts, part, now_ms));
    }
    found
}

fn is_simulated(bench: Option<BenchKind>) -> bool {
    bench.is_some_and(|bench| bench != BenchKind::Hardware)
}

/// What is wrong with the age of a part. The recording that a drive was verified with must be dated, unless it was simulated; the others
/// may come from systems that state no date. An averaged transfer function has no age: it is not measured for each session.
fn age(rendering: &Rendering, facts: &RenderingFacts, part: Part, now_ms: i64) -> Option<NotReady> {
    let is_average = matches!(
        rendering.transfer_function,
        TransferFunctionUse::Average { .. }
    );
    if part == Part::TransferFunction && is_average {
        return None;
    }
    let stimulus = facts.stimulus.clone();
    let at_ms = facts.origin(part).at_ms;
    match at_ms.map(|at_ms| hours_between(at_ms, now_ms)) {
        Some(hours) if hours > rendering.max_age_hours => Some(NotReady::TooOld {
            stimulus,
            part,
            hours,
            most_hours: rendering.max_age_hours,
        }),
        // A minute, for two clocks that differ.
        Some(hours) if hours >= -1.0 / 60.0 => None,
        None if part != Part::Measurement || is_simulated(facts.measurement.bench) => None,
        ahead => Some(NotReady::Undated {
            stimulus,
            part,
            ahead_hours: ahead.map(|hours| -hours),
        }),
    }
}

#[cfg(test)]
mod tests;
