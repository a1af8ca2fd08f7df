//! Whether a session may begin: who takes part, what was done before, and what will be played.
//!
//! Everything that is missing is said at once, so that a volunteer is not called in vain.

mod error;
mod made;
mod prepared;

use std::collections::{BTreeMap, BTreeSet};

pub use error::NotReady;
pub use made::before_rendering;
pub use prepared::{PreparedStimuli, PreparedStimulus, prepared_stimuli};

use piezotact::checksum::Checksum;
use piezotact::compare::plain_name;
use piezotact::criterion::Outcome;
use piezotact::lineage::Lineage;
use piezotact::quantity::Acceleration;
use piezotact::recording::{BenchKind, Condition};
use piezotact::render::Rendering as Rendered;
use piezotact::series::Series;
use piezotact::transfer::AtRest;

use super::chain::Sha;
use super::plan::{Plan, Presented};
use super::protocol::{AROUND_S, Protocol, Rendering, TransferFunctionUse, When};

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
    /// The checksum of that file.
    pub sha: Sha,
    /// The checksum of the samples of the drive.
    pub samples: Checksum,
    /// What the drive was made from, and how; `None` where nothing says it.
    pub lineage: Option<Lineage>,
    /// The sample that was touched, by what its target states.
    pub sample: Option<String>,
    /// The file of its target.
    pub target_file: String,
    /// Its target, m/s².
    pub texture: Series<Acceleration>,
    /// What the target was made from, and how, by its own file.
    pub target_lineage: Option<Lineage>,
    /// What the drive states otherwise than when it was measured: `another level`.
    pub changed_since_measured: Option<String>,
    /// The checksums of the transfer functions that it was made with, first the one that it was rendered with.
    pub made_with: Vec<Checksum>,
    /// How much higher the measured level is than that of the target as it was rendered, dB; `None` where nothing was measured.
    pub level_error_db: Option<f64>,
    /// The level that it was rendered at, relative to its texture, in dB.
    pub level_db: f64,
    /// How long the drive lasts, s.
    pub drive_s: f64,
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
    /// The drives that this session played already: the checksums of their files, by stimulus.
    pub played: &'a BTreeMap<String, Sha>,
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
    found.extend(stimuli_not_ready(
        protocol,
        &plan.participant,
        stimuli_of(plan),
        known,
    ));
    found
}

/// What is wrong with the drives of `stimuli` for `participant`: each as the protocol states it.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn stimuli_not_ready<'a>(
    protocol: &Protocol,
    participant: &str,
    stimuli: impl IntoIterator<Item = &'a str>,
    known: Known<'_>,
) -> Vec<NotReady> {
    let (mut found, mut drives) = (Vec::new(), Vec::new());
    for stimulus in stimuli {
        let facts = known.renderings.iter().find(|one| one.stimulus == stimulus);
        drives.extend(facts);
        match facts {
            None => found.push(missing(stimulus, known.incomplete)),
            Some(facts) => {
                found.extend(of_drive(protocol, participant, facts, known.now_ms));
                found.extend(known.bench.iter().flat_map(|bench| on_bench(facts, bench)));
            }
        }
    }
    found.extend(made::faults(protocol, &drives, known.played));
    found
}

/// What `drive` states otherwise than `played`, the same samples when they were measured; `None` where they state the same.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn changed_since(played: &Rendered, drive: &Rendered) -> Option<String> {
    let lineage = |one: &Rendered| {
        let lineage = one.about.provenance.lineage.as_ref();
        lineage.map(before_rendering)
    };
    let sample = |one: &Rendered| {
        let lineage = one.about.provenance.lineage.as_ref();
        lineage.and_then(|lineage| lineage.sample.clone())
    };
    let person = |one: &Rendered| one.about.condition.participant.clone();
    let device = |one: &Rendered| one.setup.clone();
    let made_with = |one: &Rendered| one.about.provenance.made_with.clone();
    let changed = [
        ("level", (played.level_db - drive.level_db).abs() > 0.005),
        ("sample", sample(played) != sample(drive)),
        ("lineage", lineage(played) != lineage(drive)),
        ("participant", person(played) != person(drive)),
        ("device or gain", device(played) != device(drive)),
        ("transfer function", made_with(played) != made_with(drive)),
    ];
    let changed = changed.into_iter().filter(|(_, differs)| *differs);
    let changed: Vec<String> = changed.map(|(what, _)| format!("another {what}")).collect();
    (!changed.is_empty()).then(|| changed.join(", "))
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
    participant: &str,
    facts: &RenderingFacts,
    now_ms: i64,
) -> Vec<NotReady> {
    let stimulus = || facts.stimulus.clone();
    let mut found = Vec::new();
    let Some(rendering) = &protocol.rendering else {
        return found;
    };
    let somebody = facts.strokes.condition.participant.as_ref();
    if somebody.is_none_or(|somebody| somebody != participant) {
        found.push(NotReady::Strokes {
            stimulus: stimulus(),
            participant: participant.to_owned(),
            found: somebody.map_or_else(|| "somebody who is not stated".to_owned(), Clone::clone),
        });
    }
    let made = protocol.stimulus(&facts.stimulus);
    let made = made.as_deref();
    let whose = made.and_then(|made| protocol.transfer_function_of(made));
    let is_average = matches!(whose, Some(TransferFunctionUse::Average { .. }));
    let expected = match is_average {
        true => Whose::Average,
        false => Whose::Of(participant.to_owned()),
    };
    if facts.rendered_with != expected {
        found.push(NotReady::TransferFunction {
            stimulus: stimulus(),
            expected: expected.words(),
            found: facts.rendered_with.words(),
        });
    }
    // What another finger felt is said already.
    let is_own = somebody.is_some_and(|somebody| somebody == participant);
    if facts.verified != Outcome::Met && is_own {
        found.push(NotReady::NotPassed {
            stimulus: stimulus(),
            outcome: facts.verified,
        });
    }
    if let Some(longest_s) = rendering
        .playing
        .longest_s()
        .filter(|longest_s| facts.drive_s > *longest_s)
    {
        found.push(NotReady::Refused {
            stimulus: stimulus(),
            why: format!(
                "expected a drive of at most {longest_s:.1} s for a texture that is played for {:.1} s, found {:.1} s; prepare it from a shorter stroke, or state a longer time in the protocol",
                longest_s - AROUND_S,
                facts.drive_s
            ),
        });
    }
    if facts.measured == MeasuredDrive::Another {
        found.push(NotReady::Measured {
            stimulus: stimulus(),
        });
    }
    // An averaged transfer function has no age: it is not measured for each session.
    let ages = |part: &Part| *part != Part::TransferFunction || !is_average;
    for part in Part::ALL.into_iter().filter(ages) {
        found.extend(age(rendering, facts, part, now_ms));
    }
    found
}

fn is_simulated(bench: Option<BenchKind>) -> bool {
    bench.is_some_and(|bench| bench != BenchKind::Hardware)
}

/// What is wrong with the age of a part. The recording that a drive was verified with must be dated, unless it was simulated; the others
/// may come from systems that state no date.
fn age(rendering: &Rendering, facts: &RenderingFacts, part: Part, now_ms: i64) -> Option<NotReady> {
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
