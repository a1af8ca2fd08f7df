//! What a typed line means at a step of a session.

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::AnswerForm;
use piezotact_people::campaign::session::{Command, State, Step};

/// What a line asks for.
#[derive(Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one for each line that a person types"
)]
pub(super) enum Asked {
    /// A command for the session.
    Command(Command),
    /// The keys are explained.
    Help,
    /// How far the session is.
    Status,
    /// The terminal is left; the session can be resumed.
    Leave,
    /// Withdrawal is asked for; it needs a second word.
    Withdraw,
}

/// All keys, as `/help` shows them.
pub(super) const HELP: &str = "\
Enter            does what the line above asks for: an item is confirmed, a trial was presented, an answer is final
an answer        in words as listed, in capital or small letters; letters can stand together: cab
/play N          plays or hands over element N once more; /play alone: all of them
/wrong NAMES     other samples than planned were handed over, in their order
/fix N ANSWER because WHY   corrects what was noted for trial N, which is confirmed
/note TEXT       keeps a note
/pause, /go      begins and ends a pause
/stop WHY        stops the session before its end
/withdraw        the participant withdraws consent
/status          how far the session is
/leave           leaves the terminal; the same command resumes later";

/// What `line` asks for at the step where `state` stands.
///
/// # Errors
/// One sentence that says what was expected.
pub(super) fn understood(
    state: &State<'_>,
    line: &str,
    consent: Sha,
) -> Result<Vec<Asked>, String> {
    if let Some(rest) = line.strip_prefix('/') {
        return slash(state, rest);
    }
    let one = |command| Ok(vec![Asked::Command(command)]);
    match state.step() {
        Step::AskConsent => match line.to_lowercase().as_str() {
            "yes" | "y" => one(Command::Consent { text: consent }),
            "no" | "n" => one(Command::RefuseConsent),
            _ => Err("expected yes or no: does the participant consent?".to_owned()),
        },
        Step::Check { .. } if line.is_empty() => one(Command::Check),
        Step::Present { .. } if line.is_empty() => one(Command::Present {
            evidence: Vec::new(),
        }),
        Step::Answer { trial, .. } if line.is_empty() => match trial.answer {
            AnswerForm::Done => one(Command::Confirm),
            _ => Err("expected an answer; /help explains the keys".to_owned()),
        },
        Step::Answer { trial, .. } if trial.answer == AnswerForm::Done => {
            Err("expected Enter when it is done; /note keeps a note".to_owned())
        }
        Step::Confirm { .. } if line.is_empty() => one(Command::Confirm),
        Step::Answer { trial, .. } | Step::Confirm { trial, .. } => one(Command::Answer {
            words: words(line, &state.choices(trial)),
        }),
        Step::GoOn if line.is_empty() => one(Command::GoOn),
        Step::End if line.is_empty() => one(Command::End),
        _ => Err("expected Enter or a key such as /note; /help explains the keys".to_owned()),
    }
}

/// The words of an answer: names that are in `choices`, which may hold spaces; letters may stand together.
fn words(line: &str, choices: &[(String, String)]) -> Vec<String> {
    let said = |word: &str| {
        choices
            .iter()
            .any(|(said, _)| said.to_lowercase() == word.to_lowercase())
    };
    if line.contains(',') {
        let parts = line.split(',').map(str::trim);
        return parts
            .filter(|part| !part.is_empty())
            .map(str::to_owned)
            .collect();
    }
    if said(line) {
        return vec![line.to_owned()];
    }
    let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
    let letters = line.chars().filter(|c| !c.is_whitespace());
    let letters: Vec<String> = letters.map(String::from).collect();
    // A number has no choices, and its digits are not letters.
    let is_lettered =
        !choices.is_empty() && choices.iter().all(|(said, _)| said.chars().count() == 1);
    let stand_together = is_lettered || letters.iter().all(|letter| said(letter));
    match words.iter().all(|word| said(word)) || !stand_together {
        true => words,
        false => letters,
    }
}

fn slash(state: &State<'_>, text: &str) -> Result<Vec<Asked>, String> {
    let (key, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    let one = |asked| Ok(vec![asked]);
    let given = |what: &str| match rest.is_empty() {
        true => Err(format!("expected {what} behind /{key}")),
        false => Ok(rest.to_owned()),
    };
    match key {
        "help" | "?" => one(Asked::Help),
        "status" => one(Asked::Status),
        "leave" | "quit" => one(Asked::Leave),
        "withdraw" => one(Asked::Withdraw),
        "pause" => one(Asked::Command(Command::Pause)),
        "go" => one(Asked::Command(Command::GoOn)),
        "note" => one(Asked::Command(Command::Note {
            text: given("the text of the note")?,
        })),
        "stop" => one(Asked::Command(Command::Stop {
            why: given("why the session is stopped")?,
        })),
        "play" => played(state, rest),
        "wrong" => {
            let names = given("the samples that were handed over, in their order")?;
            let names = match names.contains(',') {
                true => names
                    .split(',')
                    .map(|name| name.trim().to_owned())
                    .collect(),
                false => names.split_whitespace().map(str::to_owned).collect(),
            };
            let evidence = Vec::new();
            one(Asked::Command(Command::PresentInstead { names, evidence }))
        }
        "fix" => fixed(
            state,
            &given("the number of a trial, the answer, `because` and the reason")?,
        ),
        _ => Err(format!("there is no key /{key}; /help lists the keys")),
    }
}

/// One element once more, or all.
fn played(state: &State<'_>, rest: &str) -> Result<Vec<Asked>, String> {
    let elements = state.current().map_or(0, |(_, trial)| trial.plays.len());
    let play = |element| {
        Asked::Command(Command::Play {
            element,
            evidence: None,
        })
    };
    if rest.is_empty() && elements > 0 {
        return Ok((0..elements).map(play).collect());
    }
    match rest.parse::<usize>() {
        Ok(number) if (1..=elements).contains(&number) => Ok(vec![play(number - 1)]),
        _ if elements == 0 => Err("nothing was presented yet; Enter presents the trial".to_owned()),
        _ => Err(format!(
            "expected an element from 1 to {elements}, found `{rest}`"
        )),
    }
}

/// `N ANSWER because WHY`: the number of a trial as in its heading, or its name as in an exported table.
fn fixed(state: &State<'_>, rest: &str) -> Result<Vec<Asked>, String> {
    let Some((what, why)) = rest.split_once(" because ") else {
        return Err(
            "expected /fix N ANSWER because WHY, such as /fix 3 S4 because misheard".to_owned(),
        );
    };
    let (first, after) = what.split_once(char::is_whitespace).unwrap_or((what, ""));
    let numbered = first.parse::<usize>().ok();
    let numbered = numbered.and_then(|number| state.trials().nth(number.checked_sub(1)?));
    // Names of trials can hold spaces: the longest that fits is the one.
    let named = || {
        let fits = state.trials().filter_map(|(trial, _)| {
            let rest = what.strip_prefix(trial.name.as_str())?;
            rest.starts_with(char::is_whitespace)
                .then_some((trial, rest))
        });
        fits.max_by_key(|(trial, _)| trial.name.len())
    };
    let found = numbered.map(|(trial, _)| (trial, after)).or_else(named);
    let Some((trial, line)) = found else {
        return Err(format!(
            "expected the number of a trial from 1 to {}, found `{first}`; it stands in the heading of the trial",
            state.plan().trials.len()
        ));
    };
    Ok(vec![Asked::Command(Command::Correct {
        trial: trial.name.clone(),
        words: words(line.trim(), &state.choices(trial)),
        why: why.trim().to_owned(),
    })])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_names_or_letters_that_stand_together() {
        let letters: Vec<(String, String)> = ["A", "B", "C"]
            .map(|c| (c.to_owned(), format!("of {c}")))
            .to_vec();
        assert_eq!(words("cab", &letters), ["c", "a", "b"]);
        assert_eq!(words("c a b", &letters), ["c", "a", "b"]);
        // Told by the letter that is none.
        assert_eq!(words("cad", &letters), ["c", "a", "d"]);
        for number in ["10", "-5", "750"] {
            assert_eq!(words(number, &[]), [number]);
        }
        let names: Vec<(String, String)> = ["S1", "S2 INVERTED"]
            .map(|c| (c.to_owned(), c.to_owned()))
            .to_vec();
        assert_eq!(words("s1 S1", &names), ["s1", "S1"]);
        assert_eq!(words("s2 inverted", &names), ["s2 inverted"]);
        assert_eq!(words("S1, S2 INVERTED", &names), ["S1", "S2 INVERTED"]);
    }
}
