//! Whether a session may begin: who takes part, what was done before, and what will be played.
//!
//! Everything that is missing is said at once, so that a volunteer is not called in vain.

use std::collections::BTreeSet;

use piezotact::criterion::Outcome;
use piezotact::recording::BenchKind;

use super::plan::{Plan, Presented};
use super::protocol::{Protocol, TransferFunctionUse, When};

/// Sessions on different days have at least this time between them, in hours: an evening and the next morning have it, the morning
/// and the evening of one day do not, whatever the time zone.
const ANOTHER_DAY_HOURS: f64 = 12.0;
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
            Self::Unknown => "a transfer function of nobody knows whom".to_owned(),
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

/// What is known of the drive of one stimulus.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderingFacts {
    pub stimulus: String,
    /// Whose strokes it was made from; `None` where nothing says it.
    pub strokes_of: Option<String>,
    /// With whose transfer function it was rendered.
    pub rendered_with: Whose,
    /// Whether it passed its verification.
    pub verified: Outcome,
    /// Of which drive the measurement is that it was verified with.
    pub measured: MeasuredDrive,
    /// When it was prepared, in ms since 1970-01-01 00:00 UTC; `None` where nothing says it.
    pub prepared_ms: Option<i64>,
}

/// The finger that feels what is played.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FingerOnBench {
    /// Nothing is played here: by hand on another system, or not at all.
    NotHere,
    /// A person's, on real devices.
    Real,
    /// One that a bench simulates.
    Simulated {
        bench: BenchKind,
        /// Whose finger it is; `None` for nobody's.
        of: Option<String>,
    },
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
    /// The earlier sessions of this participant.
    pub earlier: &'a [EarlierSession<'a>],
    /// Panels by name with their members.
    pub panels: &'a [(String, BTreeSet<String>)],
    /// The finger that feels what is played.
    pub finger: &'a FingerOnBench,
    /// The time now, in ms since 1970-01-01 00:00 UTC.
    pub now_ms: i64,
}

/// Why a session may not begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotReady {
    /// There is no drive for a stimulus.
    #[error("{stimulus}: there is no drive; prepare it from the strokes of this participant")]
    Missing { stimulus: String },
    /// A drive made from somebody else's strokes.
    #[error(
        "{stimulus}: expected strokes of {participant}, found those of {found}; prepare the drives of {participant}"
    )]
    Strokes {
        stimulus: String,
        participant: String,
        /// Whose strokes they are.
        found: String,
    },
    /// A drive rendered with another transfer function than the protocol asks for.
    #[error("{stimulus}: expected {expected}, found {found}; render it again")]
    TransferFunction {
        stimulus: String,
        /// What the protocol asks for.
        expected: String,
        found: String,
    },
    /// A drive that did not pass.
    #[error(
        "{stimulus}: its verification is {}; prepare it again, in a closed loop where the open one does not pass", .outcome.word()
    )]
    NotPassed { stimulus: String, outcome: Outcome },
    /// A measurement of another drive.
    #[error(
        "{stimulus}: the measurement beside it was made with another drive; play this drive, record it, and compare it with its target"
    )]
    Measured { stimulus: String },
    /// A drive that is too old.
    #[error(
        "{stimulus}: expected a drive of the last {most_hours} h, found one of {hours:.1} h ago; measure the participant again"
    )]
    TooOld {
        stimulus: String,
        /// Its age, in hours.
        hours: f64,
        /// The largest age, in hours.
        most_hours: f64,
    },
    /// A drive that is not dated, or from the future.
    #[error("{stimulus}: when it was prepared is not known; prepare it again")]
    Undated { stimulus: String },
    /// A bench with nobody's finger on it.
    #[error(
        "expected a bench with a finger on it, found {}: nobody feels what it plays; name the bench of {participant}", bench_words(*.bench)
    )]
    NoFinger {
        participant: String,
        bench: BenchKind,
    },
    /// A bench with somebody else's finger on it.
    #[error(
        "expected the finger of {participant} on the bench, found that of {found}; name the bench of {participant}"
    )]
    OtherFinger {
        participant: String,
        /// Whose finger it is.
        found: String,
    },
    /// An earlier session was not ended.
    #[error("session {session} comes before this one and was not ended; end it first")]
    Earlier { session: String },
    /// The sessions are on one day.
    #[error(
        "expected another day than that of session {session}, found {hours:.1} h between them; come back after {ANOTHER_DAY_HOURS} h"
    )]
    SameDay {
        session: String,
        /// The time between them, in hours.
        hours: f64,
    },
    /// The participant belongs to a panel that must not overlap.
    #[error(
        "{participant} belongs to the panel `{panel}`, from which this campaign is disjoint; choose another participant"
    )]
    Panel { participant: String, panel: String },
    /// Nobody said who belongs to a panel that must not overlap.
    #[error(
        "the campaign is disjoint from the panel `{panel}`, and who belongs to it is not stated; state it when the study is made"
    )]
    UnknownPanel { panel: String },
}

impl NotReady {
    /// The stimulus that it is about; `None` where it is about the participant.
    #[must_use]
    pub fn stimulus(&self) -> Option<&str> {
        match self {
            Self::Missing { stimulus }
            | Self::Strokes { stimulus, .. }
            | Self::TransferFunction { stimulus, .. }
            | Self::NotPassed { stimulus, .. }
            | Self::Measured { stimulus }
            | Self::TooOld { stimulus, .. }
            | Self::Undated { stimulus } => Some(stimulus),
            Self::NoFinger { .. }
            | Self::OtherFinger { .. }
            | Self::Earlier { .. }
            | Self::SameDay { .. }
            | Self::Panel { .. }
            | Self::UnknownPanel { .. } => None,
        }
    }
}

/// The stimuli that `plan` plays or may choose, each once.
///
/// Source: decision 0069 of this project.
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
/// decision 0069 of this project.
#[must_use]
pub fn not_ready(protocol: &Protocol, plan: &Plan, known: Known<'_>) -> Vec<NotReady> {
    let mut found = panels(protocol, plan, known);
    found.extend(earlier(protocol, plan, known));
    found.extend(finger(&plan.participant, known.finger));
    for stimulus in stimuli_of(plan) {
        let facts = known.renderings.iter().find(|one| one.stimulus == stimulus);
        match facts {
            None => found.push(NotReady::Missing {
                stimulus: stimulus.to_owned(),
            }),
            Some(facts) => found.extend(of_drive(protocol, plan, facts, known.now_ms)),
        }
    }
    found
}

/// Who would feel what is played, where it is not the participant.
fn finger(participant: &str, finger: &FingerOnBench) -> Option<NotReady> {
    let participant = participant.to_owned();
    match finger {
        FingerOnBench::NotHere | FingerOnBench::Real => None,
        FingerOnBench::Simulated {
            bench: BenchKind::Twin,
            of: Some(found),
        } => (!found.eq_ignore_ascii_case(&participant)).then(|| NotReady::OtherFinger {
            participant,
            found: found.clone(),
        }),
        FingerOnBench::Simulated { bench, .. } => Some(NotReady::NoFinger {
            participant,
            bench: *bench,
        }),
    }
}

fn bench_words(bench: BenchKind) -> &'static str {
    match bench {
        BenchKind::Twin => "the digital twin of nobody",
        BenchKind::Hardware => "real devices",
        BenchKind::Measured => "a measured transfer function",
        BenchKind::Scripted => "a scripted fake",
    }
}

fn panels(protocol: &Protocol, plan: &Plan, known: Known<'_>) -> Vec<NotReady> {
    let mut found = Vec::new();
    for panel in &protocol.panel.disjoint_from {
        let members = known.panels.iter().find(|(name, _)| name == panel);
        match members {
            None => found.push(NotReady::UnknownPanel {
                panel: panel.clone(),
            }),
            // Names that differ by case only are one person everywhere in a study.
            Some((_, members))
                if members
                    .iter()
                    .any(|member| member.eq_ignore_ascii_case(&plan.participant)) =>
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
    let somebody = facts.strokes_of.as_ref();
    if somebody != Some(participant) {
        found.push(NotReady::Strokes {
            stimulus: stimulus(),
            participant: participant.clone(),
            found: somebody.map_or_else(|| "nobody knows whom".to_owned(), Clone::clone),
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
    let hours = facts
        .prepared_ms
        .map(|prepared_ms| hours_between(prepared_ms, now_ms));
    match hours {
        Some(hours) if hours > rendering.max_age_hours => found.push(NotReady::TooOld {
            stimulus: stimulus(),
            hours,
            most_hours: rendering.max_age_hours,
        }),
        // A minute, for two clocks that differ.
        Some(hours) if hours >= -1.0 / 60.0 => {}
        _ => found.push(NotReady::Undated {
            stimulus: stimulus(),
        }),
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::chain::Sha;
    use crate::campaign::plan::{PlanRequest, plan};
    use crate::campaign::protocol::from_library;

    const NOW: i64 = 1_800_000_000_000;
    const HOUR: i64 = 3_600_000;

    fn planned(protocol: &Protocol, session: &str) -> Plan {
        let request = PlanRequest {
            seed: 1,
            participant: "P01",
            session,
            completed: &[],
        };
        plan(protocol, Sha::of(b"protocol"), request).unwrap()
    }

    fn fits(plan: &Plan) -> Vec<RenderingFacts> {
        let facts = |stimulus: &str| RenderingFacts {
            stimulus: stimulus.to_owned(),
            strokes_of: Some("P01".to_owned()),
            rendered_with: Whose::Of("P01".to_owned()),
            verified: Outcome::Met,
            measured: MeasuredDrive::This,
            prepared_ms: Some(NOW - 20 * HOUR),
        };
        stimuli_of(plan).into_iter().map(facts).collect()
    }

    fn found(
        protocol: &Protocol,
        plan: &Plan,
        drives: &[RenderingFacts],
        hours: i64,
    ) -> Vec<NotReady> {
        let earlier = [EarlierSession {
            session: "measurement",
            ended_ms: Some(NOW - hours * HOUR),
        }];
        let known = Known {
            renderings: drives,
            earlier: &earlier,
            panels: &[],
            finger: &FingerOnBench::NotHere,
            now_ms: NOW,
        };
        not_ready(protocol, plan, known)
    }

    #[test]
    fn a_session_with_everything_begins_and_each_thing_that_is_wrong_is_said() {
        let protocol = from_library("isotropic_triplets").unwrap().unwrap();
        let plan = planned(&protocol, "discrimination");
        let drives = fits(&plan);
        assert!(!drives.is_empty());
        assert_eq!(found(&protocol, &plan, &drives, 20), []);
        let first = drives[0].stimulus.clone();
        let with = |change: &dyn Fn(&mut RenderingFacts)| {
            let mut drives = drives.clone();
            change(&mut drives[0]);
            found(&protocol, &plan, &drives, 20)
        };
        assert_eq!(
            found(&protocol, &plan, &drives[1..], 20),
            [NotReady::Missing { stimulus: first }]
        );
        let somebody = |one: &mut RenderingFacts| one.strokes_of = Some("P02".to_owned());
        assert!(matches!(with(&somebody)[..], [NotReady::Strokes { .. }]));
        let nobody = |one: &mut RenderingFacts| one.strokes_of = None;
        assert!(matches!(with(&nobody)[..], [NotReady::Strokes { .. }]));
        let average = |one: &mut RenderingFacts| one.rendered_with = Whose::Average;
        assert!(matches!(
            with(&average)[..],
            [NotReady::TransferFunction { .. }]
        ));
        let open = |one: &mut RenderingFacts| one.verified = Outcome::NotDecided;
        assert!(matches!(with(&open)[..], [NotReady::NotPassed { .. }]));
        let swapped = |one: &mut RenderingFacts| one.measured = MeasuredDrive::Another;
        assert!(matches!(with(&swapped)[..], [NotReady::Measured { .. }]));
        let elsewhere = |one: &mut RenderingFacts| one.measured = MeasuredDrive::Unstated;
        assert_eq!(with(&elsewhere), []);
        let old = |one: &mut RenderingFacts| one.prepared_ms = Some(NOW - 800 * HOUR);
        assert!(matches!(with(&old)[..], [NotReady::TooOld { .. }]));
        let future = |one: &mut RenderingFacts| one.prepared_ms = Some(NOW + HOUR);
        assert!(matches!(with(&future)[..], [NotReady::Undated { .. }]));
        let no_time = |one: &mut RenderingFacts| one.prepared_ms = Some(i64::MIN);
        assert!(matches!(with(&no_time)[..], [NotReady::TooOld { .. }]));
        let undated = |one: &mut RenderingFacts| one.prepared_ms = None;
        assert!(matches!(with(&undated)[..], [NotReady::Undated { .. }]));
    }

    #[test]
    fn the_second_session_waits_for_the_first_and_for_another_day() {
        let protocol = from_library("isotropic_triplets").unwrap().unwrap();
        let plan = planned(&protocol, "discrimination");
        let drives = fits(&plan);
        assert!(matches!(
            found(&protocol, &plan, &drives, 3)[..],
            [NotReady::SameDay { .. }]
        ));
        let known = Known {
            renderings: &drives,
            earlier: &[],
            panels: &[],
            finger: &FingerOnBench::NotHere,
            now_ms: NOW,
        };
        assert!(matches!(
            not_ready(&protocol, &plan, known)[..],
            [NotReady::Earlier { .. }]
        ));
        let first = planned(&protocol, "measurement");
        assert_eq!(not_ready(&protocol, &first, known), []);
        // Chapter 6 allows both in one session.
        let chapter6 = from_library("touch_control_imagery").unwrap().unwrap();
        let same_day = chapter6
            .sessions
            .iter()
            .all(|one| one.when == When::AnyTime);
        assert!(same_day);
    }

    #[test]
    fn panels_that_must_not_overlap_are_stated_and_looked_up() {
        let protocol = from_library("averaged_transfer_function").unwrap().unwrap();
        let session = &protocol.sessions[0].name;
        let plan = planned(&protocol, session);
        let with = |panels: &[(String, BTreeSet<String>)]| {
            let known = Known {
                renderings: &[],
                earlier: &[],
                panels,
                finger: &FingerOnBench::NotHere,
                now_ms: NOW,
            };
            let found = not_ready(&protocol, &plan, known);
            let of_panels = |one: &NotReady| {
                matches!(one, NotReady::Panel { .. } | NotReady::UnknownPanel { .. })
            };
            found.into_iter().filter(of_panels).collect::<Vec<_>>()
        };
        let names = &protocol.panel.disjoint_from;
        assert_eq!(names.len(), 3);
        assert_eq!(with(&[]).len(), 3);
        let stated = |member: &str| {
            let members = BTreeSet::from([member.to_owned()]);
            let each = names.iter().map(|name| (name.clone(), members.clone()));
            each.collect::<Vec<_>>()
        };
        assert_eq!(with(&stated("P07")), []);
        assert_eq!(with(&stated("P01")).len(), 3);
        assert_eq!(with(&stated("p01")).len(), 3);
    }

    #[test]
    fn who_feels_what_is_played_is_the_participant() {
        let protocol = from_library("isotropic_triplets").unwrap().unwrap();
        let plan = planned(&protocol, "discrimination");
        let drives = fits(&plan);
        let with = |finger: &FingerOnBench| {
            let earlier = [EarlierSession {
                session: "measurement",
                ended_ms: Some(NOW - 20 * HOUR),
            }];
            let known = Known {
                renderings: &drives,
                earlier: &earlier,
                panels: &[],
                finger,
                now_ms: NOW,
            };
            not_ready(&protocol, &plan, known)
        };
        let of = |bench, person: Option<&str>| FingerOnBench::Simulated {
            bench,
            of: person.map(str::to_owned),
        };
        assert_eq!(with(&FingerOnBench::Real), []);
        assert_eq!(with(&of(BenchKind::Twin, Some("P01"))), []);
        assert_eq!(
            with(&of(BenchKind::Twin, Some("P02"))),
            [NotReady::OtherFinger {
                participant: "P01".to_owned(),
                found: "P02".to_owned()
            }]
        );
        for bench in [BenchKind::Measured, BenchKind::Scripted, BenchKind::Twin] {
            assert_eq!(
                with(&of(bench, None)),
                [NotReady::NoFinger {
                    participant: "P01".to_owned(),
                    bench
                }]
            );
        }
        // A scripted fake names whom it likes.
        assert_eq!(with(&of(BenchKind::Scripted, Some("P01"))).len(), 1);
    }
}
