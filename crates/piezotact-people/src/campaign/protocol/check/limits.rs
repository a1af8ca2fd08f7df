//! What no campaign has: counts that fill the memory before anything is planned, numbers out of their range, texts that forge others.

use super::super::method::Method;
use super::super::{Over, Playing, Protocol, Sequence, Task, TaskKind};
use super::{ProtocolError, hours, number};
use crate::campaign::text::{TextError, check_line, check_long};

/// The most trials of one session: a thousand hours at half a minute each is no session.
const MOST_TRIALS: u64 = 100_000;
/// The most samples, sets, stimuli and participants.
const MOST_LISTED: usize = 2_000;
/// The largest age of a drive and the longest interruption, in hours: ten years.
const MOST_HOURS: f64 = 87_600.0;

/// Refuses counts that are too large, before anything is made of them.
pub(super) fn counts(protocol: &Protocol) -> Result<(), ProtocolError> {
    for (place, found) in [
        ("the samples", protocol.samples.len()),
        ("the sets", protocol.sets.len()),
        ("the stimuli", protocol.stimuli.len()),
        ("panel.participants", protocol.panel.participants as usize),
        ("the tasks", protocol.tasks.len()),
        ("the sessions", protocol.sessions.len()),
    ] {
        if found > MOST_LISTED {
            return Err(number(place, "at most 2000", found));
        }
    }
    for session in &protocol.sessions {
        let blocks = session.blocks.iter();
        let trials = blocks.map(|block| {
            let sets = match &block.over {
                Over::AllSamples | Over::Samples(_) => 1,
                Over::EverySet => protocol.sets.len(),
                Over::SharesOfSets(shares) => shares.iter().map(Vec::len).max().unwrap_or(0),
            };
            let largest = protocol.sets.iter().map(|set| set.samples.len()).max();
            let samples = match &block.over {
                Over::AllSamples => protocol.samples.len(),
                Over::Samples(samples) => samples.len(),
                Over::EverySet | Over::SharesOfSets(_) => largest.unwrap_or(0),
            };
            let tasks = block.tasks.iter().filter_map(|name| protocol.task(name));
            let of_set = tasks.fold(0_u64, |sum, task| sum.saturating_add(trials(task, samples)));
            of_set
                .saturating_mul(sets as u64)
                .saturating_mul(u64::from(block.repeats))
        });
        let trials = trials.fold(0_u64, u64::saturating_add);
        if trials > MOST_TRIALS {
            let place = format!("session {}: the trials of one participant", session.name);
            return Err(number(&place, "at most 100000", trials));
        }
    }
    Ok(())
}

/// The most trials of `task` over one set of `samples` samples.
fn trials(task: &Task, samples: usize) -> u64 {
    let counted = match &task.kind {
        TaskKind::Touch { .. } | TaskKind::Categorise { .. } | TaskKind::Rate { .. } => {
            samples as u64
        }
        TaskKind::Identify { presentations } => {
            u64::from(*presentations).saturating_mul(samples as u64)
        }
        TaskKind::Order { .. } => 1,
        TaskKind::Associate { sequence, .. } => match sequence {
            Sequence::Fixed { tests } => tests.len() as u64,
            Sequence::Drawn { lengths } => lengths.iter().copied().max().unwrap_or(1) as u64,
            Sequence::Permutation | Sequence::Balanced => samples as u64,
        },
        TaskKind::Compare { method, .. } => match method {
            Method::Constant { pairs, repeats } => {
                (pairs.len() as u64).saturating_mul(2 * u64::from(*repeats))
            }
            Method::Adaptive(_) => 1_000,
        },
    };
    let training = task.training.as_ref().map_or(0, |one| one.trials);
    let catch = task.catch.as_ref().map_or(0, |one| one.trials);
    counted.saturating_add(u64::from(training) + u64::from(catch))
}

/// Refuses times that no rendered stimulus has.
pub(super) fn rendering(protocol: &Protocol) -> Result<(), ProtocolError> {
    if let Some(rendering) = &protocol.rendering {
        hours("rendering.max_age_hours", rendering.max_age_hours)?;
        if let Playing::Repeated {
            pause_s,
            duration_s,
        } = rendering.playing
        {
            hours("rendering.playing.duration_s", duration_s)?;
            if duration_s > 3600.0 {
                return Err(number(
                    "rendering.playing.duration_s",
                    "at most 3600",
                    duration_s,
                ));
            }
            if !(0.0..=3600.0).contains(&pause_s) {
                return Err(number("rendering.playing.pause_s", "0 to 3600", pause_s));
            }
        }
    }
    Ok(())
}

/// Refuses numbers out of their range. A comparison with a number that is none is never true.
pub(super) fn numbers(protocol: &Protocol) -> Result<(), ProtocolError> {
    let aims = &protocol.aims;
    for (place, found, inside, expected) in [
        (
            "aims.power_share",
            aims.power_share,
            0.0..1.0,
            "0 to 1, without 1",
        ),
        (
            "aims.half_width_share",
            aims.half_width_share,
            0.0..1.0,
            "0 to 1, without 1",
        ),
        (
            "aims.cell_share",
            aims.cell_share,
            0.0..1.0,
            "0 to 1, without 1",
        ),
        ("aims.logit_sd", aims.logit_sd, 0.0..10.0, "0 to 10"),
    ] {
        if !inside.contains(&found) {
            return Err(number(place, expected, found));
        }
    }
    let mut ages = vec![(
        "resuming.refused_after_hours",
        protocol.resuming.refused_after_hours,
    )];
    if let Some(rendering) = &protocol.rendering {
        ages.push(("rendering.max_age_hours", rendering.max_age_hours));
    }
    for (place, found) in ages {
        if !(0.0..=MOST_HOURS).contains(&found) {
            return Err(number(place, "0 to 87600, ten years", found));
        }
    }
    for stimulus in &protocol.stimuli {
        let gain_db = stimulus.gain_db.unwrap_or(0.0);
        if !(-120.0..=120.0).contains(&gain_db) {
            let place = format!("stimulus {}: gain_db", stimulus.name);
            return Err(number(&place, "-120 to 120", gain_db));
        }
    }
    Ok(())
}

/// Refuses texts that hide something or fill a screen.
pub(super) fn texts(protocol: &Protocol) -> Result<(), ProtocolError> {
    let said = |place: String| move |why: TextError| ProtocolError::Text { place, why };
    check_line(&protocol.title).map_err(said("title".to_owned()))?;
    check_long(&protocol.source).map_err(said("source".to_owned()))?;
    for one in &protocol.decided_here {
        check_long(one).map_err(said("decided_here".to_owned()))?;
    }
    for task in &protocol.tasks {
        let place = |what: &str| format!("task {}: {what}", task.name);
        check_line(&task.title).map_err(said(place("title")))?;
        check_long(&task.instruction).map_err(said(place("instruction")))?;
        for item in &task.checklist {
            check_line(item).map_err(said(place("checklist")))?;
        }
        match &task.kind {
            TaskKind::Order { from, to, .. } => {
                check_line(from).map_err(said(place("from")))?;
                check_line(to).map_err(said(place("to")))?;
            }
            TaskKind::Categorise { descriptors, .. } => {
                for one in descriptors {
                    check_line(one).map_err(said(place("descriptors")))?;
                }
            }
            _ => {}
        }
    }
    for panel in &protocol.panel.disjoint_from {
        check_line(panel).map_err(said("panel.disjoint_from".to_owned()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::super::{LIBRARY, from_library, read};
    use super::*;

    fn changed(from: &str, to: &str) -> ProtocolError {
        let (_, text) = LIBRARY
            .iter()
            .find(|(name, _)| *name == "isotropic_triplets")
            .unwrap();
        assert!(text.contains(from), "{from}");
        read(&text.replacen(from, to, 1)).unwrap_err()
    }

    #[test]
    fn what_no_campaign_has_is_refused_with_the_limit() {
        for (from, to, said) in [
            ("max_age_hours = 720", "max_age_hours = 1e300", "0 to 87600"),
            ("max_age_hours = 720", "max_age_hours = nan", "more than 0"),
            (
                "power_share = 0.8",
                "power_share = nan",
                "0 to 1, without 1",
            ),
            (
                "power_share = 0.8",
                "power_share = inf",
                "0 to 1, without 1",
            ),
            (
                "participants = 10",
                "participants = 4000000000",
                "at most 2000",
            ),
            ("title = \"", "title = \"a\\u001b[2K", "U+001B"),
            ("title = \"", "title = \"a\\u202e", "U+202E"),
        ] {
            let error = changed(from, to).to_string();
            assert!(error.contains(said), "{to}: {error}");
        }
        // Counted before anything is made of them, also where the product is more than a number holds.
        let mut protocol = from_library("isotropic_triplets").unwrap().unwrap();
        assert_eq!(counts(&protocol), Ok(()));
        for repeats in [10_000, u32::MAX] {
            protocol.sessions[1].blocks[1].repeats = repeats;
            let error = counts(&protocol).unwrap_err().to_string();
            assert!(error.contains("the trials of one participant"), "{error}");
        }
    }

    #[test]
    fn names_that_differ_by_case_only_are_one() {
        let error = changed("samples = [\"S1\"", "samples = [\"s2\", \"S1\"").to_string();
        assert!(error.contains("`S2` stands twice"), "{error}");
        let error = changed("samples = [\"S1\"", "samples = [\"-2\", \"S1\"").to_string();
        assert!(error.contains("`-2` is no name"), "{error}");
    }
}
