//! What no campaign has: counts that fill the memory before anything is planned, numbers out of their range, texts that forge others.

use super::super::method::Method;
use super::super::{Adaptive, Playing, Protocol, Sequence, Task, TaskKind, TransferFunctionUse};
use super::{ProtocolError, must, positive};
use crate::campaign::adaptive::AdaptiveRule;
use crate::campaign::plan::MOST_TRIALS;
use crate::campaign::text::{TextError, check_line, check_long, check_short};

/// The most names that the plan of a session holds, each trial with all samples of its set.
const MOST_NAMES: u64 = 2_000_000;
/// The most blocks of a session, tasks of a block and comparisons.
const MOST_PARTS: usize = 100;
/// The most points that an adaptive rule computes with.
const MOST_POINTS: u64 = 2_000_000;
/// The largest level, step or threshold, with any sign, and the largest end of a scale.
const MOST_LEVEL: f64 = 1e6;
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
        must(place, found, ..=MOST_LISTED, "at most 2000")?;
    }
    for (place, found) in parts(protocol) {
        must(&place, found, ..=MOST_PARTS, "at most 100")?;
    }
    protocol.tasks.iter().try_for_each(lists)?;
    for session in &protocol.sessions {
        let blocks = session.blocks.iter();
        let each = blocks.map(|block| {
            let shares = protocol.groups(&block.over);
            let sets = shares.iter().map(Vec::len).max().unwrap_or(0);
            let largest = protocol.sets.iter().map(|set| set.samples.len()).max();
            let mut groups = shares.iter().flatten();
            let at_once = groups.find(|group| group.set.is_none());
            let samples = at_once.map_or(largest.unwrap_or(0), |group| group.samples.len());
            let tasks = block.tasks.iter().filter_map(|name| protocol.task(name));
            let of_set = tasks.fold(0_u64, |sum, task| sum.saturating_add(trials(task, samples)));
            let trials = of_set
                .saturating_mul(sets as u64)
                .saturating_mul(u64::from(block.repeats));
            (trials, trials.saturating_mul(samples as u64))
        });
        let (trials, names) = each.fold((0_u64, 0_u64), |(trials, names), (more, named)| {
            (trials.saturating_add(more), names.saturating_add(named))
        });
        let place = format!("session {}: the trials of one participant", session.name);
        must(&place, trials, ..=MOST_TRIALS as u64, "at most 86400")?;
        let place = format!("session {}: the trials times their samples", session.name);
        must(&place, names, ..=MOST_NAMES, "at most 2000000")?;
    }
    Ok(())
}

/// What is looked at in combination: blocks, the tasks of a block, and what is compared.
fn parts(protocol: &Protocol) -> Vec<(String, usize)> {
    let aims = &protocol.aims;
    let mut parts = vec![
        ("aims.comparisons".to_owned(), aims.comparisons.len()),
        ("aims.earlier_tasks".to_owned(), aims.earlier_tasks.len()),
        (
            "aims.also_counterbalanced".to_owned(),
            aims.also_counterbalanced.len(),
        ),
    ];
    parts.extend(
        aims.comparisons
            .iter()
            .map(|one| ("aims.comparisons: tasks".to_owned(), one.tasks.len())),
    );
    for session in &protocol.sessions {
        let place = format!("session {}: blocks", session.name);
        parts.push((place, session.blocks.len()));
        for block in &session.blocks {
            let place = format!("session {}, block {}: tasks", session.name, block.name);
            parts.push((place, block.tasks.len()));
        }
    }
    parts
}

/// Refuses lists of a task that are too long, and rules with too many points.
fn lists(task: &Task) -> Result<(), ProtocolError> {
    let place = |what: &str| format!("task {}: {what}", task.name);
    let short = |what: &str, found| must(&place(what), found, ..=MOST_LISTED, "at most 2000");
    short("checklist", task.checklist.len())?;
    if let Some(catch) = &task.catch {
        short("catch: known", catch.known.len())?;
    }
    match &task.kind {
        TaskKind::Categorise { descriptors, .. } => short("descriptors", descriptors.len()),
        TaskKind::Associate { sequence, .. } => match sequence {
            Sequence::Drawn { lengths } => short("lengths", lengths.len()),
            Sequence::Fixed { tests } => tests.iter().try_for_each(|test| {
                let place = format!("a test of set {}", test.set);
                short(&place, test.stimuli.len())
            }),
            Sequence::Balanced => Ok(()),
        },
        TaskKind::Compare {
            method: Method::Adaptive(adaptive),
            ..
        } => {
            short("levels", adaptive.levels.len())?;
            let (what, points) = points(adaptive);
            must(&place(what), points, ..=MOST_POINTS, "at most 2000000")
        }
        _ => Ok(()),
    }
}

/// How many points the rule of `adaptive` computes with.
fn points(adaptive: &Adaptive) -> (&'static str, u64) {
    let product = |lists: &[usize]| {
        let lists = lists.iter().map(|list| *list as u64);
        lists.fold(1, u64::saturating_mul)
    };
    let levels = adaptive.levels.len();
    match &adaptive.rule {
        AdaptiveRule::Staircase { staircase, .. } => (
            "levels times steps",
            product(&[levels, staircase.steps.len()]),
        ),
        AdaptiveRule::QuestPlus {
            thresholds_db,
            slopes,
            lapse_shares,
            ..
        } => (
            "levels times thresholds, slopes and lapses",
            product(&[
                levels,
                thresholds_db.len(),
                slopes.len(),
                lapse_shares.len(),
            ]),
        ),
    }
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
            Sequence::Balanced => samples as u64,
        },
        TaskKind::Compare { method, .. } => match method {
            Method::Constant { pairs, repeats } => {
                (pairs.len() as u64).saturating_mul(2 * u64::from(*repeats))
            }
            Method::Adaptive(adaptive) => u64::from(adaptive.rule.at_most()),
        },
    };
    let training = task.training.as_ref().map_or(0, |one| one.trials);
    let catch = task.catch.as_ref().map_or(0, |one| one.trials);
    counted.saturating_add(u64::from(training) + u64::from(catch))
}

/// Refuses times that no rendered stimulus has.
pub(super) fn rendering(protocol: &Protocol) -> Result<(), ProtocolError> {
    let Some(rendering) = &protocol.rendering else {
        return Ok(());
    };
    positive("rendering.max_age_hours", rendering.max_age_hours)?;
    match rendering.playing {
        Playing::Once => Ok(()),
        Playing::Repeated {
            pause_s,
            duration_s,
        } => {
            let place = "rendering.playing.duration_s";
            positive(place, duration_s)?;
            must(place, duration_s, ..=3600.0, "at most 3600")?;
            let place = "rendering.playing.pause_s";
            must(place, pause_s, 0.0..=3600.0, "0 to 3600")
        }
    }
}

/// Refuses numbers out of their range.
pub(super) fn numbers(protocol: &Protocol) -> Result<(), ProtocolError> {
    let aims = &protocol.aims;
    let (above_0, share) = (f64::MIN_POSITIVE, "above 0 and below 1");
    for (what, found, within, expected) in [
        ("power_share", aims.power_share, above_0..1.0, share),
        (
            "half_width_share",
            aims.half_width_share,
            above_0..0.5,
            "above 0 and below 0.5",
        ),
        ("cell_share", aims.cell_share, above_0..1.0, share),
        ("logit_sd", aims.logit_sd, 0.0..10.0, "0 to 10"),
    ] {
        must(&format!("aims.{what}"), found, within, expected)?;
    }
    for one in &aims.comparisons {
        let (found, expected) = (one.smallest_effect_ratio, "above 0 and at most 100");
        let place = "aims.comparisons: smallest_effect_ratio";
        must(place, found, above_0..=100.0, expected)?;
    }
    protocol.tasks.iter().try_for_each(levels)?;
    let resumed = Some(protocol.resuming.refused_after_hours);
    let age = protocol.rendering.as_ref().map(|one| one.max_age_hours);
    for (place, found) in [
        ("resuming.refused_after_hours", resumed),
        ("rendering.max_age_hours", age),
    ] {
        let found = found.unwrap_or_default();
        must(place, found, 0.0..=MOST_HOURS, "0 to 87600, ten years")?;
    }
    for session in &protocol.sessions {
        let min = session.source_time.as_ref().map_or(1, |of| of.min);
        let place = format!("session {}: source_time.min", session.name);
        must(&place, min, 1..=1440, "1 to 1440, a day")?;
    }
    Ok(())
}

/// Refuses levels, steps, thresholds and ends of scales that no task has.
fn levels(task: &Task) -> Result<(), ProtocolError> {
    let found: Vec<f64> = match &task.kind {
        TaskKind::Rate { from, to, .. } => vec![*from as f64, *to as f64],
        TaskKind::Compare {
            method: Method::Adaptive(adaptive),
            ..
        } => {
            let mut found = adaptive.levels();
            found.push(adaptive.largest_sd);
            match &adaptive.rule {
                AdaptiveRule::Staircase { staircase, .. } => {
                    found.extend([staircase.first, staircase.lowest, staircase.highest]);
                    found.extend(&staircase.steps);
                }
                AdaptiveRule::QuestPlus {
                    thresholds_db,
                    slopes,
                    lapse_shares,
                    ..
                } => found.extend(thresholds_db.iter().chain(slopes).chain(lapse_shares)),
            }
            found
        }
        _ => Vec::new(),
    };
    let place = format!("task {}: every level, step and end of a scale", task.name);
    let (range, expected) = (-MOST_LEVEL..=MOST_LEVEL, "-1000000 to 1000000");
    let mut all = found.into_iter();
    all.try_for_each(|one| must(&place, one, range.clone(), expected))
}

fn fits(
    place: &str,
    check: fn(&str) -> Result<(), TextError>,
    text: &str,
) -> Result<(), ProtocolError> {
    let place = place.to_owned();
    check(text).map_err(|why| ProtocolError::Text { place, why })
}

fn lines<'a>(
    place: &str,
    lines: impl IntoIterator<Item = &'a String>,
) -> Result<(), ProtocolError> {
    let mut lines = lines.into_iter();
    lines.try_for_each(|line| fits(place, check_line, line))
}

/// Refuses texts that hide something or fill a screen.
pub(super) fn texts(protocol: &Protocol) -> Result<(), ProtocolError> {
    fits("title", check_line, &protocol.title)?;
    fits("source", check_long, &protocol.source)?;
    for one in &protocol.decided_here {
        fits("decided_here", check_long, one)?;
    }
    for (sample, turned) in &protocol.orientation {
        fits(&format!("orientation.{sample}"), check_line, turned)?;
    }
    for task in &protocol.tasks {
        let place = |what: &str| format!("task {}: {what}", task.name);
        fits(&place("title"), check_line, &task.title)?;
        fits(&place("instruction"), check_long, &task.instruction)?;
        let descriptors = match &task.kind {
            TaskKind::Categorise { descriptors, .. } => &descriptors[..],
            _ => &[],
        };
        for (tag, words) in &task.in_language {
            let place = |what: &str| place(&format!("in_language.{tag}.{what}"));
            fits(&place("instruction"), check_long, &words.instruction)?;
            lines(&place("title"), &words.title)?;
            lines(&place("checklist"), &words.checklist)?;
            lines(&place("descriptors"), &words.descriptors)?;
            lines(&place("from"), &words.from)?;
            lines(&place("to"), &words.to)?;
            for (what, found, own) in [
                ("checklist", &words.checklist, &task.checklist[..]),
                ("descriptors", &words.descriptors, descriptors),
            ] {
                if !found.is_empty() {
                    let (own, expected) = (
                        own.len(),
                        "as many as in the task itself, in the same order",
                    );
                    must(&place(what), found.len(), own..=own, expected)?;
                }
            }
        }
        lines(&place("checklist"), &task.checklist)?;
        match &task.kind {
            TaskKind::Order { from, to, .. } => {
                fits(&place("from"), check_line, from)?;
                fits(&place("to"), check_line, to)?;
            }
            TaskKind::Rate {
                lowest, highest, ..
            } => {
                lines(&place("lowest"), lowest)?;
                lines(&place("highest"), highest)?;
            }
            _ => lines(&place("descriptors"), descriptors)?,
        }
    }
    for session in &protocol.sessions {
        let source_time = session.source_time.as_ref();
        if let Some(why_not) = source_time.and_then(|of| of.why_not.as_deref()) {
            let place = format!("session {}: source_time.why_not", session.name);
            fits(&place, check_long, why_not)?;
        }
    }

    lines("panel.disjoint_from", &protocol.panel.disjoint_from)?;
    // The finger stands in the table of participants where no other one is stated.
    let finger = &protocol.exploration.finger;
    fits("exploration.finger", check_short, finger)?;
    let factors = &protocol.aims.also_counterbalanced;
    let names = factors.iter().map(|factor| &factor.name);
    lines("aims.also_counterbalanced", names)?;
    match protocol.rendering.as_ref().map(|of| &of.transfer_function) {
        Some(TransferFunctionUse::Average { panel }) => {
            fits("rendering.transfer_function.panel", check_line, panel)
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{LIBRARY, Over, from_library, read};
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
            (
                r#"title = "Passages sur chaque échantillon", checklist = ["mains lavées au savon et séchées", "#,
                r#"title = "Passages sur chaque échantillon", checklist = ["#,
                "in_language.fr.checklist: expected as many",
            ),
            ("max_age_hours = 720", "max_age_hours = 1e300", "0 to 87600"),
            ("max_age_hours = 720", "max_age_hours = nan", "more than 0"),
            (
                "power_share = 0.8",
                "power_share = nan",
                "above 0 and below 1",
            ),
            (
                "power_share = 0.8",
                "power_share = inf",
                "above 0 and below 1",
            ),
            (
                "participants = 10",
                "participants = 4000000000",
                "at most 2000",
            ),
            (
                "source_time = { min = 60,",
                "source_time = { min = 0,",
                "source_time.min: expected 1 to 1440",
            ),
            ("title = \"", "title = \"a\\u001b[2K", "U+001B"),
            ("title = \"", "title = \"a\\u202e", "U+202E"),
            (
                "half_width_share = ",
                "half_width_share = 0 # ",
                "above 0 and below 0.5",
            ),
            (
                "finger = \"",
                "finger = \"=1+1 ",
                "exploration.finger: the text begins with `=`",
            ),
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
    fn levels_and_grids_that_no_rule_has_are_refused_before_they_are_made() {
        let (_, text) = LIBRARY
            .iter()
            .find(|(name, _)| *name == "roughness_jnd")
            .unwrap();
        let changed = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            read(&text.replacen(from, to, 1)).unwrap_err().to_string()
        };
        let line = text.lines().find(|line| line.starts_with("thresholds_db"));
        let many: Vec<String> = (0..1_000_000).map(|i| format!("{i}e-6")).collect();
        let many = format!("thresholds_db = [{}]", many.join(","));
        let error = changed(line.unwrap(), &many);
        let part = "levels times thresholds, slopes and lapses: expected at most 2000000, found";
        assert!(error.contains(part), "{error}");
        for (from, to) in [
            ("largest_sd = 4", "largest_sd = 1e300"),
            ("slopes = [1, 2, 3]", "slopes = [1e300]"),
        ] {
            let error = changed(from, to);
            assert!(error.contains("expected -1000000 to 1000000"), "{error}");
        }
    }

    #[test]
    fn a_session_is_counted_as_its_plan_is() {
        let mut protocol = from_library("isotropic_triplets").unwrap().unwrap();
        protocol.sessions[1].blocks[1].repeats = MOST_TRIALS as u32;
        let error = counts(&protocol).unwrap_err().to_string();
        let part = format!("at most {MOST_TRIALS}, found");
        assert!(error.contains(&part), "{error}");
        let mut blocks = from_library("isotropic_triplets").unwrap().unwrap();
        let block = blocks.sessions[1].blocks[1].clone();
        blocks.sessions[1].blocks = vec![block; MOST_PARTS + 1];
        let error = counts(&blocks).unwrap_err().to_string();
        let part = "blocks: expected at most 100, found 101";
        assert!(error.contains(part), "{error}");
        // Each of a thousand trials over a thousand samples that are named ten times names all of them.
        let mut names = from_library("periodic_pilot").unwrap().unwrap();
        names.samples = (0..2000).map(|i| format!("S{i}")).collect();
        let task = names.sessions[0].blocks[0].tasks[0].clone();
        for one in &mut names.tasks {
            if one.name == task {
                one.kind = TaskKind::Identify { presentations: 1 };
            }
        }
        names.sessions[0].blocks[0].over = Over::AllSamples;
        let error = counts(&names).unwrap_err().to_string();
        let part = "the trials times their samples: expected at most 2000000, found 4000000";
        assert!(error.contains(part), "{error}");
    }

    #[test]
    fn names_that_differ_by_case_only_are_one() {
        let error = changed("samples = [\"S1\"", "samples = [\"s2\", \"S1\"").to_string();
        assert!(error.contains("`S2` stands twice"), "{error}");
        let error = changed("samples = [\"S1\"", "samples = [\"-2\", \"S1\"").to_string();
        assert!(error.contains("`-2` is no name"), "{error}");
    }
}
