//! Reading a protocol: its form, and whether what it names is there.

mod compare;
mod limits;

use std::collections::BTreeSet;
use std::ops::{Bound, RangeBounds};

use super::reference::misfit;
use super::{Block, FORM, Labels, Method, Over, Protocol, Sequence, Task, TaskKind};

/// Why a text is no protocol that can be run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// It is no TOML, or a field is missing, unknown or of another type.
    #[error("the protocol cannot be read: {why}; correct the file")]
    Form {
        /// What the reader says, with the line.
        why: String,
    },
    /// It was written for a later program.
    #[error(
        "expected form {FORM} of protocols, found {found}; use the version of the program that it was written for"
    )]
    Version {
        /// The form that it names.
        found: u32,
    },
    /// A name that stands nowhere.
    #[error("{place}: {what} `{name}` is not declared; declare it, or correct the name")]
    Unknown {
        place: String,
        /// What it should be: "sample".
        what: &'static str,
        name: String,
    },
    /// The same name twice.
    #[error("{what} `{name}` stands twice in {place}; give each its own name")]
    Twice {
        place: String,
        /// What it is: "sample".
        what: &'static str,
        name: String,
    },
    /// More samples than the tray holds.
    #[error(
        "set {set} has {found} samples, and the tray holds {slots}; make the set smaller, or state a larger tray"
    )]
    Tray {
        set: String,
        found: usize,
        slots: usize,
    },
    /// A number that cannot be.
    #[error("{place}: expected {expected}, found {found}")]
    Number {
        place: String,
        expected: &'static str,
        found: String,
    },
    /// A text that cannot be shown.
    #[error("{place}: {why}")]
    Text {
        place: String,
        why: crate::campaign::text::TextError,
    },
    /// A name that cannot be a name of a file or a column.
    #[error(
        "{place}: `{name}` is no name; use 1 to 40 letters, digits, spaces, `-` or `_`, a letter or digit first"
    )]
    Name { place: String, name: String },
    /// Rendered stimuli without a statement how they are rendered.
    #[error(
        "task {task} presents rendered stimuli, and the protocol has no [rendering]; state transfer function, stroke, playing and age"
    )]
    NoRendering { task: String },
    /// Levels that do not increase.
    #[error(
        "{place}: {what} must increase, and {found} follows {before}; list them in increasing order, the standard below all"
    )]
    Levels {
        place: String,
        what: &'static str,
        found: String,
        /// What is before it.
        before: String,
    },
    /// A level that a staircase can ask for, without a stimulus.
    #[error(
        "{place}: the staircase can ask for level {level}, which no stimulus has; list one, or change `first`, `steps`, `lowest` or `highest`"
    )]
    NoStimulus { place: String, level: String },
    /// A method, adaptive rule or training that cannot be followed.
    #[error("{place}: {why}")]
    Place {
        place: String,
        /// Why, and what to do.
        why: String,
    },
    /// An answer in A, B, C of an order that is not made before.
    #[error(
        "task {task} answers in the order of task {order}, which does not stand before it in its block; put it before"
    )]
    OrderAfter { task: String, order: String },
    /// The protocol has no such session.
    #[error("the protocol {protocol} has no session `{session}`; its sessions are {known}")]
    Session {
        protocol: String,
        /// The session that was asked for.
        session: String,
        /// The sessions that it has.
        known: String,
    },
    /// The participant has completed the session.
    #[error(
        "{participant} has completed the session {session} already; a participant takes part once"
    )]
    Completed {
        participant: String,
        session: String,
    },
    /// More trials than anybody can do.
    #[error(
        "session {session} has more than 86400 trials; lower the repeats and presentations of its tasks"
    )]
    TooLong { session: String },
    /// A fixed list has no test for a set.
    #[error(
        "task {task} has no fixed sequence for set {set}; add one, or leave the set out of the block"
    )]
    NoSequence { task: String, set: String },
}

/// Reads a protocol from TOML and checks that all it names is declared.
///
/// # Errors
/// [`ProtocolError`] with the first place that does not fit.
///
/// Source: docs/decisions/campaigns.md.
pub fn read(toml: &str) -> Result<Protocol, ProtocolError> {
    let protocol: Protocol = toml::from_str(toml).map_err(|error| ProtocolError::Form {
        why: in_one_sentence(toml, &error),
    })?;
    check(&protocol)?;
    Ok(protocol)
}

/// What does not fit, with the line: by the table of fields, else in the words of the reader without the picture that it draws.
fn in_one_sentence(toml: &str, error: &toml::de::Error) -> String {
    let file = toml.parse::<toml::Table>().ok().map(toml::Value::Table);
    let misfit = file.as_ref().and_then(misfit);
    let said = error.message().trim().replace('\n', ", ");
    let from = error.span().map(|span| span.start);
    let Some((before, after)) = from.and_then(|at| toml.split_at_checked(at)) else {
        return misfit.map_or(said, |one| one.why);
    };
    let names = |line: &str, field: &str| {
        let mut parts = line.split(['{', ',', '=', '[', ']', '.']);
        parts.any(|part| part.trim() == field)
    };
    let field = misfit.as_ref().map(|one| one.field.as_str());
    let further = field.and_then(|field| after.lines().position(|line| names(line, field)));
    let line = before.matches('\n').count() + 1 + further.unwrap_or(0);
    format!("line {line}: {}", misfit.map_or(said, |one| one.why))
}

fn check(protocol: &Protocol) -> Result<(), ProtocolError> {
    if protocol.form != FORM {
        return Err(ProtocolError::Version {
            found: protocol.form,
        });
    }
    let (samples, tasks) = (&protocol.samples, &protocol.tasks);
    all_named("the protocol", [protocol.name.as_str()])?;
    limits::counts(protocol)?;
    distinct("the samples", "sample", samples)?;
    at_least_one("the samples", samples.len())?;
    known_samples(protocol, "orientation", protocol.orientation.keys())?;
    at_least_one("tray_slots", protocol.tray_slots)?;
    at_least_one("panel.participants", protocol.panel.participants as usize)?;
    let hours = protocol.resuming.refused_after_hours;
    positive("resuming.refused_after_hours", hours)?;
    stimuli(protocol)?;
    sets(protocol)?;
    distinct("the tasks", "task", tasks.iter().map(|task| &task.name))?;
    at_least_one("the tasks", tasks.len())?;
    tasks.iter().try_for_each(|one| task(protocol, one))?;
    limits::rendering(protocol)?;
    sessions(protocol)?;
    limits::numbers(protocol)?;
    limits::texts(protocol)?;
    aims(protocol)
}

/// A design that is judged by a session that does not exist would have no fault.
fn aims(protocol: &Protocol) -> Result<(), ProtocolError> {
    let aims = &protocol.aims;
    let is_session = |name: &String| protocol.session(name).is_some();
    known("aims", "session", [&aims.session], is_session)?;
    let compared = aims.comparisons.iter().flat_map(|one| &one.tasks);
    let tasks = compared.chain(&aims.earlier_tasks);
    known("aims", "task", tasks, |name| protocol.task(name).is_some())
}

fn sessions(protocol: &Protocol) -> Result<(), ProtocolError> {
    let names = protocol.sessions.iter().map(|session| &session.name);
    distinct("the sessions", "session", names)?;
    at_least_one("the sessions", protocol.sessions.len())?;
    for session in &protocol.sessions {
        let (place, blocks) = (format!("session {}", session.name), &session.blocks);
        distinct(&place, "block", blocks.iter().map(|block| &block.name))?;
        at_least_one(&format!("{place}: blocks"), blocks.len())?;
        for one in blocks {
            block(protocol, &format!("{place}, block {}", one.name), one)?;
        }
    }
    Ok(())
}

fn stimuli(protocol: &Protocol) -> Result<(), ProtocolError> {
    let made = protocol.stimuli.iter().map(|stimulus| &stimulus.name);
    let names = protocol.samples.iter().chain(made);
    distinct("samples and stimuli", "stimulus", names)?;
    for stimulus in &protocol.stimuli {
        let place = format!("stimulus {}", stimulus.name);
        let samples = stimulus.samples().chain(&stimulus.expected);
        known_samples(protocol, &place, samples)?;
        if [&stimulus.spectrum_of, &stimulus.level_of].contains(&&Some(stimulus.of.clone())) {
            let why = format!(
                "`spectrum_of` and `level_of` name another sample than {}, which it is made of: leave out the one that names it",
                stimulus.of
            );
            return refused(&place, why);
        }
        if stimulus.rms_db.is_some() && (stimulus.level_of.is_some() || stimulus.gain_db.is_some())
        {
            let why =
                "`rms_db` states the level alone: leave out `level_of` and `gain_db`, or `rms_db`";
            return refused(&place, why);
        }
        let band_db = stimulus.band.and_then(|band| band.gain_db);
        for (what, found, within, expected) in [
            ("gain_db", stimulus.gain_db, -60.0..=60.0, "-60 to 60"),
            ("rms_db", stimulus.rms_db, -60.0..=40.0, "-60 to 40"),
            ("band.gain_db", band_db, -60.0..=60.0, "-60 to 60"),
            ("warp", stimulus.warp, 0.1..=10.0, "0.1 to 10"),
            ("shift_hz", stimulus.shift_hz, -1e3..=1e3, "-1000 to 1000"),
        ] {
            if let Some(found) = found {
                let place = format!("{place}: {what}");
                must(&place, found, within, expected)?;
            }
        }
    }
    Ok(())
}

fn sets(protocol: &Protocol) -> Result<(), ProtocolError> {
    distinct("the sets", "set", protocol.sets.iter().map(|set| &set.name))?;
    protocol.sets.iter().try_for_each(|set| {
        let place = format!("set {}", set.name);
        group(protocol, &place, &set.name, &set.samples)
    })
}

/// Samples that are on the tray together.
fn group(
    protocol: &Protocol,
    place: &str,
    name: &str,
    samples: &[String],
) -> Result<(), ProtocolError> {
    known_samples(protocol, place, samples)?;
    distinct(place, "sample", samples)?;
    at_least_one(place, samples.len())?;
    fits_tray(protocol, name, samples.len())
}

fn task(protocol: &Protocol, task: &Task) -> Result<(), ProtocolError> {
    let place = format!("task {}", task.name);
    let of = |what: &str| format!("{place}: {what}");
    let found = task.seconds_per_trial;
    let range = (Bound::Excluded(0.0), Bound::Included(7200.0));
    must(
        &of("seconds_per_trial"),
        found,
        range,
        "more than 0 and at most 7200",
    )?;
    let renders = matches!(
        task.kind,
        TaskKind::Associate { .. } | TaskKind::Compare { .. }
    );
    if renders && protocol.rendering.is_none() {
        return Err(ProtocolError::NoRendering {
            task: task.name.clone(),
        });
    }
    compare::beside(protocol, &place, task)?;
    let is_adaptive = matches!(
        &task.kind,
        TaskKind::Compare {
            method: Method::Adaptive(_),
            ..
        }
    );
    if task.may_not_know && is_adaptive {
        let why = "an adaptive method needs an answer in each trial: leave it out, and ask the participant to guess";
        return refused(&of("may_not_know"), why);
    }
    match &task.kind {
        TaskKind::Touch { strokes } => count(&of("strokes"), *strokes),
        TaskKind::Identify { presentations } => count(&of("presentations"), *presentations),
        TaskKind::Order { from, to, .. } => all_named(&place, [from.as_str(), to.as_str()]),
        TaskKind::Associate { sequence, labels } => {
            if let Labels::OwnOrder { task: order } = labels {
                let orders = protocol.task(order).map(|task| &task.kind);
                if !matches!(orders, Some(TaskKind::Order { .. })) {
                    return Err(unknown(&place, "ordering task", order));
                }
            }
            check_sequence(protocol, &place, sequence)
        }
        TaskKind::Compare {
            question,
            method,
            next_after_s,
        } => {
            if let Some(pause_s) = next_after_s {
                must(&of("next_after_s"), *pause_s, 0.5..=60.0, "0.5 to 60")?;
            }
            compare::method(protocol, &place, *question, method)
        }
        TaskKind::Categorise {
            descriptors,
            at_most,
        } => {
            distinct(&place, "descriptor", descriptors)?;
            let (range, expected) = (1..=descriptors.len(), "1 to the number of descriptors");
            must(&of("at_most"), *at_most as usize, range, expected)
        }
        TaskKind::Rate { from, to, .. } => {
            let above = (Bound::Excluded(*from), Bound::Unbounded);
            must(&of("to"), *to, above, "more than `from`")
        }
    }
}

fn check_sequence(
    protocol: &Protocol,
    place: &str,
    sequence: &Sequence,
) -> Result<(), ProtocolError> {
    match sequence {
        Sequence::Balanced => Ok(()),
        Sequence::Drawn { lengths } => {
            let place = format!("{place}: lengths");
            at_least_one(&place, lengths.len())?;
            let fits = |length: &usize| must(&place, *length, 1..=100, "1 to 100");
            lengths.iter().try_for_each(fits)
        }
        Sequence::Fixed { tests } => {
            at_least_one(&format!("{place}: tests"), tests.len())?;
            for test in tests {
                let Some(set) = protocol.set(&test.set) else {
                    return Err(unknown(place, "set", &test.set));
                };
                let stimuli = &test.stimuli;
                at_least_one(&format!("{place}: test of set {}", test.set), stimuli.len())?;
                known_stimuli(protocol, place, stimuli)?;
                let is_own = |stimulus: &String| {
                    let of = protocol.sample_of(stimulus).unwrap_or_default();
                    set.samples.iter().any(|sample| sample == of)
                };
                let place = format!("{place}, test of set {}", test.set);
                known(&place, "stimulus of the set", stimuli, is_own)?;
            }
            Ok(())
        }
    }
}

fn block(protocol: &Protocol, place: &str, block: &Block) -> Result<(), ProtocolError> {
    at_least_one(&format!("{place}: tasks"), block.tasks.len())?;
    count(&format!("{place}: repeats"), block.repeats)?;
    distinct(place, "task", &block.tasks)?;
    for (i, name) in block.tasks.iter().enumerate() {
        let Some(task) = protocol.task(name) else {
            return Err(unknown(place, "task", name));
        };
        compare::catch_in_block(protocol, place, block, task)?;
        if let TaskKind::Associate {
            labels: Labels::OwnOrder { task: order },
            ..
        } = &task.kind
            && (!block.tasks[..i].contains(order) || block.task_order != super::OrderRule::AsListed)
        {
            return Err(ProtocolError::OrderAfter {
                task: name.clone(),
                order: order.clone(),
            });
        }
    }
    match &block.over {
        Over::AllSamples => fits_tray(protocol, "of all samples", protocol.samples.len()),
        Over::Samples(samples) => group(protocol, place, &block.name, samples),
        Over::EverySet => at_least_one("the sets", protocol.sets.len()),
        Over::SharesOfSets(shares) => {
            at_least_one(&format!("{place}: shares"), shares.len())?;
            shares.iter().try_for_each(|share| {
                at_least_one(&format!("{place}: a share"), share.len())?;
                distinct(place, "set", share)?;
                known(place, "set", share, |set| protocol.set(set).is_some())
            })
        }
    }
}

fn fits_tray(protocol: &Protocol, set: &str, found: usize) -> Result<(), ProtocolError> {
    match found <= protocol.tray_slots {
        true => Ok(()),
        false => Err(ProtocolError::Tray {
            set: set.to_owned(),
            found,
            slots: protocol.tray_slots,
        }),
    }
}

/// All `names` are those of something declared.
fn known<'a>(
    place: &str,
    what: &'static str,
    names: impl IntoIterator<Item = &'a String>,
    is_known: impl Fn(&String) -> bool,
) -> Result<(), ProtocolError> {
    match names.into_iter().find(|name| !is_known(name)) {
        None => Ok(()),
        Some(name) => Err(unknown(place, what, name)),
    }
}

fn known_samples<'a>(
    protocol: &Protocol,
    place: &str,
    samples: impl IntoIterator<Item = &'a String>,
) -> Result<(), ProtocolError> {
    let is_known = |sample: &String| protocol.samples.contains(sample);
    known(place, "sample", samples, is_known)
}

fn known_stimuli<'a>(
    protocol: &Protocol,
    place: &str,
    stimuli: impl IntoIterator<Item = &'a String>,
) -> Result<(), ProtocolError> {
    let is_known = |stimulus: &String| protocol.sample_of(stimulus).is_some();
    known(place, "stimulus", stimuli, is_known)
}

/// All names can be names, and none stands twice.
fn distinct<'a>(
    place: &str,
    what: &'static str,
    names: impl IntoIterator<Item = &'a String>,
) -> Result<(), ProtocolError> {
    let mut seen = BTreeSet::new();
    for name in names {
        all_named(place, [name.as_str()])?;
        // Names that differ by case only are one file on some systems, and one word to those who speak.
        if !seen.insert(name.to_lowercase()) {
            return Err(ProtocolError::Twice {
                place: place.to_owned(),
                what,
                name: name.clone(),
            });
        }
    }
    Ok(())
}

fn all_named<'a>(
    place: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Result<(), ProtocolError> {
    let fits = |name: &str| {
        (1..=40).contains(&name.chars().count())
            && name.trim() == name
            && name.starts_with(char::is_alphanumeric)
            && name
                .chars()
                .all(|sign| sign.is_alphanumeric() || matches!(sign, ' ' | '-' | '_'))
    };
    match names.into_iter().find(|name| !fits(name)) {
        None => Ok(()),
        Some(name) => Err(ProtocolError::Name {
            place: place.to_owned(),
            name: name.to_owned(),
        }),
    }
}

fn at_least_one(place: &str, found: usize) -> Result<(), ProtocolError> {
    must(place, found, 1.., "at least 1")
}

/// How often something is done, which no session does more often.
fn count(place: &str, found: u32) -> Result<(), ProtocolError> {
    must(place, found, 1..=1000, "1 to 1000")
}

/// A number that has to be positive and finite.
fn positive(place: &str, found: f64) -> Result<(), ProtocolError> {
    let range = (Bound::Excluded(0.0), Bound::Excluded(f64::INFINITY));
    must(place, found, range, "more than 0")
}

/// A number that has to be in its range; one that is none is in no range.
fn must<T: PartialOrd + ToString>(
    place: &str,
    found: T,
    within: impl RangeBounds<T>,
    expected: &'static str,
) -> Result<(), ProtocolError> {
    match within.contains(&found) {
        true => Ok(()),
        false => Err(ProtocolError::Number {
            place: place.to_owned(),
            expected,
            found: found.to_string(),
        }),
    }
}

fn refused(place: &str, why: impl Into<String>) -> Result<(), ProtocolError> {
    Err(ProtocolError::Place {
        place: place.to_owned(),
        why: why.into(),
    })
}

fn unknown(place: &str, what: &'static str, name: &str) -> ProtocolError {
    ProtocolError::Unknown {
        place: place.to_owned(),
        what,
        name: name.to_owned(),
    }
}

#[cfg(test)]
mod tests;
