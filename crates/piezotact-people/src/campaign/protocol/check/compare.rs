//! Whether comparisons, training and catch trials can be planned.

use std::ops::Bound;

use super::super::super::adaptive::{AdaptiveRule, AdaptiveRun, StaircaseRule};
use super::super::{
    Adaptive, Block, Catch, Method, Over, Protocol, Question, Stimulus, Task, TaskKind,
};
use super::{
    ProtocolError, at_least_one, count, distinct, known_stimuli, must, positive, refused, unknown,
};

/// The largest number of trials of one task.
const MAX_TRIALS: u32 = 5000;

pub(super) fn method(
    protocol: &Protocol,
    place: &str,
    question: Question,
    method: &Method,
) -> Result<(), ProtocolError> {
    match method {
        Method::Constant { pairs, repeats } => {
            at_least_one(&format!("{place}: pairs"), pairs.len())?;
            count(&format!("{place}: repeats"), *repeats)?;
            known_stimuli(protocol, place, pairs.iter().flatten())
        }
        Method::Adaptive(_) if question == Question::SameDifferent => refused(
            place,
            "an adaptive method needs a right answer in each trial; ask `stronger` or `rougher`, or use constant stimuli",
        ),
        Method::Adaptive(adaptive) => run(protocol, place, adaptive),
    }
}

fn run(protocol: &Protocol, place: &str, adaptive: &Adaptive) -> Result<(), ProtocolError> {
    let Adaptive {
        standard,
        levels,
        rule,
        largest_sd,
    } = adaptive;
    let of = |what: &str| format!("{place}: {what}");
    let names = || std::iter::once(standard).chain(levels.iter().map(|level| &level.stimulus));
    known_stimuli(protocol, place, names())?;
    distinct(&of("standard and levels"), "stimulus", names())?;
    must(&of("levels"), levels.len(), 2.., "at least 2")?;
    for one in levels {
        let place = of(&format!("level of {}", one.stimulus));
        let (most, expected) = (Bound::Excluded(f64::INFINITY), "a finite number");
        let range = (Bound::Excluded(f64::NEG_INFINITY), most);
        must(&place, one.level, range, expected)?;
    }
    let falls = |found: f64, before: f64, what| match found > before {
        true => Ok(()),
        false => Err(ProtocolError::Levels {
            place: place.to_owned(),
            what,
            found: found.to_string(),
            before: before.to_string(),
        }),
    };
    for pair in levels.windows(2) {
        falls(pair[1].level, pair[0].level, "levels")?;
    }
    // Where all are the same texture, what is listed as more of it must be rendered so.
    let rendered = names().filter_map(|name| protocol.stimulus(name));
    let rendered: Vec<_> = rendered.collect();
    let at_no_gain = |one: &Stimulus| Stimulus {
        gain_db: None,
        rms_db: one.rms_db.map(|_| 0.0),
        ..one.clone()
    };
    let first = at_no_gain(&rendered[0]);
    if rendered
        .iter()
        .all(|one| at_no_gain(one).is_made_as(&first))
    {
        for pair in rendered.windows(2) {
            let [before, found] =
                [&pair[0], &pair[1]].map(|one| one.rms_db.unwrap_or(one.gain_db()));
            falls(found, before, "gains of standard and levels, in dB,")?;
        }
    }
    positive(&of("largest_sd"), *largest_sd)?;
    trials(&of("trials at most"), rule.at_most())?;
    AdaptiveRun::new(&adaptive.levels(), rule).map_err(|error| ProtocolError::Place {
        place: place.to_owned(),
        why: format!("{error}; correct the rule"),
    })?;
    match rule {
        AdaptiveRule::Staircase {
            staircase: rule,
            at_most,
        } => staircase(place, adaptive, rule, *at_most),
        AdaptiveRule::QuestPlus { thresholds_db, .. } => {
            let out_of_reach = |threshold: &f64| {
                !(adaptive.levels[0].level..=adaptive.levels[levels.len() - 1].level)
                    .contains(threshold)
            };
            match thresholds_db.iter().all(out_of_reach) {
                false => Ok(()),
                true => refused(
                    place,
                    "no possible threshold lies within the levels; widen the thresholds or the levels",
                ),
            }
        }
    }
}

fn staircase(
    place: &str,
    adaptive: &Adaptive,
    rule: &StaircaseRule,
    at_most: u32,
) -> Result<(), ProtocolError> {
    if rule.down <= rule.up {
        return refused(
            place,
            "a staircase with `down` not above `up` converges to what guessing reaches; raise `down`",
        );
    }
    if at_most < rule.trials.max(rule.reversals) {
        return refused(
            place,
            "`at_most` ends the staircase before it has its reversals and trials; raise it",
        );
    }
    // Every level that any of the steps can lead to.
    let levels = adaptive.levels();
    let listed = |level: f64| levels.iter().position(|one| (one - level).abs() < 1e-6);
    let mut seen = vec![false; levels.len()];
    let mut open = vec![rule.first];
    while let Some(level) = open.pop() {
        let Some(at) = listed(level) else {
            return Err(ProtocolError::NoStimulus {
                place: place.to_owned(),
                level: level.to_string(),
            });
        };
        if std::mem::replace(&mut seen[at], true) {
            continue;
        }
        for step in &rule.steps {
            for next in [level - step, level + step] {
                open.push(next.clamp(rule.lowest, rule.highest));
            }
        }
    }
    Ok(())
}

/// Whether training and catch trials of a task are possible.
pub(super) fn beside(protocol: &Protocol, place: &str, task: &Task) -> Result<(), ProtocolError> {
    let no_answer = |why: &str| refused(place, why);
    if let Some(training) = task.training {
        if matches!(
            task.kind,
            TaskKind::Touch { .. } | TaskKind::Identify { .. }
        ) {
            return no_answer(
                "training is for tasks with answers that need no learning before; leave it out",
            );
        }
        let known = match &task.kind {
            TaskKind::Associate { .. } => true,
            TaskKind::Compare {
                question, method, ..
            } => *question == Question::SameDifferent || matches!(method, Method::Adaptive(_)),
            _ => false,
        };
        if training.feedback && !known {
            return no_answer(
                "the right answers are not known, so there is no feedback; leave it out",
            );
        }
        trials(&format!("{place}: training: trials"), training.trials)?;
    }
    match &task.catch {
        None => Ok(()),
        Some(catch) => check_catch(protocol, place, task, catch),
    }
}

fn check_catch(
    protocol: &Protocol,
    place: &str,
    task: &Task,
    catch: &Catch,
) -> Result<(), ProtocolError> {
    let no_answer = |why: &str| refused(place, why);
    let of = |what: &str| format!("{place}: catch{what}");
    trials(&of(": trials"), catch.trials)?;
    let (place_of_allowed, allowed) = (of(": failures_allowed"), catch.failures_allowed);
    must(
        &place_of_allowed,
        allowed,
        ..catch.trials,
        "less than `trials`",
    )?;
    if catch.known.is_empty() {
        return no_answer("catch trials have no stimuli with a known answer; list them in `known`");
    }
    known_stimuli(protocol, &of(""), catch.known.iter().flatten())?;
    let place_of_known = of(": known");
    match &task.kind {
        TaskKind::Compare { question, .. } => {
            for one in &catch.known {
                must(&place_of_known, one.len(), 2..=2, "2 stimuli in each")?;
                if *question != Question::SameDifferent && one[0] == one[1] {
                    return no_answer(
                        "a stimulus beside itself has no right answer to `rougher` or `stronger`; name another one",
                    );
                }
            }
            Ok(())
        }
        TaskKind::Associate { .. } => {
            let (mut sizes, expected) =
                (catch.known.iter().map(Vec::len), "1 to 100 stimuli in each");
            sizes.try_for_each(|size| must(&place_of_known, size, 1..=100, expected))
        }
        _ => no_answer("catch trials are for tasks `compare` and `associate`; leave them out"),
    }
}

/// Whether each group of samples that the block goes over has a catch trial of the association `task`.
pub(super) fn catch_in_block(
    protocol: &Protocol,
    place: &str,
    block: &Block,
    task: &Task,
) -> Result<(), ProtocolError> {
    let (TaskKind::Associate { .. }, Some(catch)) = (&task.kind, &task.catch) else {
        return Ok(());
    };
    let fits = |samples: &[String]| {
        catch.known.iter().any(|known| {
            known.iter().all(|stimulus| {
                let expected = protocol.expected(stimulus);
                samples.iter().any(|sample| expected == Some(sample))
            })
        })
    };
    let mut groups = protocol.groups(&block.over).into_iter().flatten();
    let Some(missing) = groups.find(|group| !fits(group.samples)) else {
        return Ok(());
    };
    let at_once = match &block.over {
        Over::AllSamples => "of all samples",
        _ => "of the block",
    };
    let (place, set) = (
        format!("{place}, task {}", task.name),
        missing.set.unwrap_or(at_once),
    );
    Err(unknown(&place, "catch trial for the set", set))
}

fn trials(place: &str, found: u32) -> Result<(), ProtocolError> {
    must(place, found, 1..=MAX_TRIALS, "1 to 5000")
}

#[cfg(test)]
mod tests {
    use super::super::super::{LIBRARY, from_library};
    use super::super::read;

    fn says(from: &str, to: &str, part: &str) {
        let (_, toml) = LIBRARY[5];
        assert!(toml.contains(from), "{from}");
        let text = read(&toml.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
        assert!(
            !text.contains('\n') || text.contains("cannot be read"),
            "{text}"
        );
    }

    #[test]
    fn levels_that_cannot_be_compared_are_refused() {
        let standard = "standard = \"S8\"";
        says(
            standard,
            "standard = \"S9\"",
            "stimulus `S9` is not declared",
        );
        says(
            standard,
            "standard = \"S8 increment -26\"",
            "stands twice in task quest: standard and levels",
        );
        says(
            "level = -24",
            "level = -26",
            "levels must increase, and -26 follows -26; list them",
        );
        says("level = -24", "level = nan", "expected a finite number");
        says(
            "gain_db = 1.946",
            "gain_db = 9",
            "gains of standard and levels, in dB, must increase",
        );
        says("gain_db = 1.946", "gain_db = 99", "-60 to 60");
        says(
            "largest_sd = 4",
            "largest_sd = 0",
            "largest_sd: expected more than 0",
        );
        says("largest_sd = 4", "largest_sd = 4\nseed = 3", "seed");
        says("how = \"adaptive\"", "how = \"guessing\"", "guessing");
    }

    #[test]
    fn rules_that_cannot_reach_a_threshold_are_refused() {
        says(
            "down = 3",
            "down = 1",
            "converges to what guessing reaches; raise `down`",
        );
        says(
            "at_most = 90",
            "at_most = 10",
            "ends the staircase before it has its reversals",
        );
        says("at_most = 90", "at_most = 0", "expected 1 to 5000, found 0");
        says("trials = 50", "trials = 0", "expected 1 to 5000, found 0");
        says(
            "steps = [4, 4, 2]",
            "steps = [4, 3]",
            "which no stimulus has; list one, or change `first`",
        );
        says("highest = 0", "highest = 4", "can ask for level");
        says("reversals = 12", "reversals = 5", "`left_out`");
        says(
            "slopes = [1, 2, 3]",
            "slopes = [0]",
            "task quest: QUEST+: a slope must be positive",
        );
        says(
            "slopes = [1, 2, 3]",
            "slopes = [1]\nguess_share = 0.5",
            "guess_share",
        );
        let (_, toml) = LIBRARY[5];
        let line = toml.lines().find(|line| line.starts_with("thresholds_db"));
        says(
            line.unwrap(),
            "thresholds_db = [10, 20]",
            "no possible threshold lies within the levels",
        );
        says(
            "question = \"stronger\"",
            "question = \"same_different\"",
            "an adaptive method needs a right answer in each trial",
        );
    }

    #[test]
    fn training_and_catch_trials_need_known_answers() {
        let known = "known = [[\"S8 increment 0\", \"S8\"]]";
        says(known, "known = []", "no stimuli with a known answer");
        says(
            known,
            "known = [[\"S8\", \"S8\"]]",
            "a stimulus beside itself",
        );
        says(
            known,
            "known = [[\"S8\"]]",
            "expected 2 stimuli in each, found 1",
        );
        says(
            known,
            "known = [[\"S8\", \"S1\"]]",
            "stimulus `S1` is not declared",
        );
        says(known, "pairs = []", "pairs");
        says(
            "trials = 5, known",
            "trials = 0, known",
            "task quest: catch: trials: expected 1 to 5000",
        );
        says(
            "failures_allowed = 1",
            "failures_allowed = 5",
            "less than `trials`",
        );
        says(
            "training = { trials = 6",
            "training = { trials = 0",
            "task quest: training: trials",
        );
    }

    #[test]
    fn each_set_of_an_association_needs_a_catch_trial_and_an_order_has_none() {
        let (_, toml) = LIBRARY[1];
        let text = |from: &str, to: &str| {
            assert!(toml.contains(from), "{from}");
            read(&toml.replacen(from, to, 1)).unwrap_err().to_string()
        };
        let sets = from_library("isotropic_triplets").unwrap().unwrap().sets;
        let one = format!(
            "kind = \"associate\"\ncatch = {{ trials = 1, known = [[\"{}\"]], failures_allowed = 0 }}",
            sets[0].samples[0]
        );
        let found = text("kind = \"associate\"", &one);
        assert!(found.contains("catch trial for the set `"), "{found}");
        let of_order =
            "catch = { trials = 1, known = [[\"S1\"]], failures_allowed = 0 }\nkind = \"order\"";
        let found = text("kind = \"order\"", of_order);
        assert!(
            found.contains("catch trials are for tasks `compare` and `associate`"),
            "{found}"
        );
        let trained = "training = { trials = 2 }\nkind = \"touch\"";
        let found = text("kind = \"touch\"", trained);
        assert!(
            found.contains("training is for tasks with answers"),
            "{found}"
        );
        let found = text(
            "kind = \"order\"",
            "training = { trials = 2, feedback = true }\nkind = \"order\"",
        );
        assert!(found.contains("the right answers are not known"), "{found}");
    }
}
