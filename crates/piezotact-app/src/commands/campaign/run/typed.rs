//! A session that is typed on the terminal.

use anyhow::anyhow;
use piezotact::number::counted;
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::{Command, Event, Evidence, Participant, Stage, State};
use piezotact_people::campaign::store::StoreError;
use piezotact_study::session::{
    Given, Heard, Played, RunError, Runner, Stimulator, StopHandle, TouchBench, TouchEnd,
};

use super::shown::{self, PlayedBy, said, shown};
use super::terminal::{MOST_COUNTED, Terminal, Typed};
use super::words::{Asked, HELP, understood};
use super::{About, Arguments, Front, first_command, left, require_in_time, status, withdrawn};
use crate::failure::{Failure, Outcome};
use crate::interrupt::{Between, interrupted};
use crate::output::{print, say};
use crate::progress;

/// A script of which so many lines in a row are refused has no end that helps.
const MOST_REFUSED: usize = 100;

/// The terminal.
pub(super) struct Typing;

impl Front for Typing {
    fn shown(&self, bench: TouchBench<'static>) -> Box<dyn Stimulator> {
        Box::new(Announced(bench))
    }

    fn lead(&mut self, runner: Runner<'_>, args: &Arguments, about: About<'_>) -> Outcome {
        session(runner, args, about.consent)
    }
}

/// A bench that says on the screen which element of a trial it plays, and never which stimulus that is.
struct Announced<'a>(TouchBench<'a>);

impl Stimulator for Announced<'_> {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        self.0.check(stimulus)
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        // Whoever reads has gone: the next prompt finds it out.
        let _said = print(&format!("  texture {} is played …", played.element + 1));
        self.0.play(played, stop)
    }

    fn listen(&mut self, touched: Played<'_>, stop: &StopHandle) -> Result<bool, String> {
        self.0.listen(touched, stop)
    }

    fn strokes(&self) -> Option<u32> {
        self.0.strokes()
    }

    fn heard(&mut self, end: TouchEnd) -> Option<Heard> {
        self.0.heard(end)
    }
}

/// The session from where it stands to its end, or until the terminal is left.
fn session(mut runner: Runner<'_>, args: &Arguments, consent: Option<&str>) -> Outcome {
    let _ends_between = Between::items("step");
    let terminal = Terminal::new();
    progress::keep_off();
    begin(&mut runner, args, &terminal)?;
    let consent_sha = Sha::of(consent.unwrap_or_default().as_bytes());
    let played_by = match args.leading.by_hand {
        true => PlayedBy::Hand,
        false => PlayedBy::Bench,
    };
    let mut last = String::new();
    let mut refused = 0;
    loop {
        if matches!(
            runner.state().stage(),
            Stage::Ended | Stage::Stopped | Stage::Withdrawn
        ) {
            return ended_with(&runner, args, &terminal);
        }
        let now = shown(runner.state(), consent, played_by);
        let lines = now.lines.join("\n");
        if lines != last {
            terminal.say(&lines)?;
            last = lines;
        }
        let line = match terminal.ask(now.prompt)? {
            Typed::Line(line) => line,
            Typed::NotTaken(why) => {
                terminal.say(&format!("  {why}"))?;
                continue;
            }
            Typed::End => return Err(Failure::Data(anyhow!(left(&runner)))),
        };
        let asked = match understood(runner.state(), &line, consent_sha) {
            Ok(asked) => asked,
            Err(why) => {
                terminal.say(&format!("  {why}"))?;
                refused += 1;
                if refused > MOST_REFUSED && !terminal.is_keyboard() {
                    return Err(Failure::Data(anyhow!(
                        "{MOST_REFUSED} lines in a row were refused, the last with: {why}; {}",
                        left(&runner)
                    )));
                }
                continue;
            }
        };
        refused = 0;
        for asked in asked {
            match asked {
                Asked::Help => terminal.say(HELP)?,
                Asked::Status => terminal.say(&status(&runner))?,
                Asked::Leave => {
                    say(&left(&runner));
                    return Ok(());
                }
                Asked::Withdraw => withdraw(&mut runner, &terminal)?,
                Asked::Command(command) => {
                    last.clear();
                    give(&mut runner, command, &terminal)?;
                }
            }
            if interrupted() {
                return Err(Failure::Data(anyhow!(left(&runner))));
            }
        }
    }
}

/// Begins the session, or goes on with one that was cut off.
fn begin(runner: &mut Runner<'_>, args: &Arguments, terminal: &Terminal) -> Outcome {
    let Some(command) = first_command(runner, args) else {
        return Ok(());
    };
    if matches!(command, Command::Resume { .. }) {
        terminal.say(&format!(
            "The session goes on where it was left: {}.",
            status(runner)
        ))?;
        if args.leading.by_hand && was_measured(runner.state()) {
            terminal.say(
                "Until now textures were played on a bench. From here on they are played by hand: nothing is measured, and each such answer is flagged `not_measured`.",
            )?;
        }
    }
    if let Command::Begin { participant, .. } = &command {
        let missing = not_stated(participant);
        if !missing.is_empty() {
            terminal.say(&format!(
                "Not stated of the participant: {}.",
                missing.join(", ")
            ))?;
        }
    }
    require_in_time(runner, &command)?;
    let _begun = runner.give(command)?;
    Ok(())
}

/// Whether a texture was played on a bench in this session.
fn was_measured(state: &State<'_>) -> bool {
    state.trials().any(|(_, of)| !of.evidence.is_empty())
}

/// What a description of the panel needs and nobody stated.
fn not_stated(participant: &Participant) -> Vec<&'static str> {
    let stated = [
        ("sex", participant.sex.is_some()),
        ("age", participant.age_years.is_some()),
        ("handedness", participant.handedness.is_some()),
    ];
    let missing = stated.into_iter().filter(|(_, is_stated)| !is_stated);
    missing.map(|(what, _)| what).collect()
}

/// Gives `command`; what is refused, cannot be played or cannot be stored is said, and the session waits at the same step.
fn give(runner: &mut Runner<'_>, command: Command, terminal: &Terminal) -> Outcome {
    let now_ms = runner.now_ms();
    let too_soon = runner.state().too_soon(now_ms);
    // The time is checked at a keyboard only; a script has no strokes.
    let too_soon = too_soon.filter(|_| command == Command::Confirm && terminal.is_keyboard());
    if let Some(refusal) = too_soon {
        return terminal.say(&format!("  {refusal}"));
    }
    let before = noted(runner.state());
    match runner.give(command) {
        Ok(Given::Done(Event::Corrected { trial, .. })) => {
            terminal.say(&corrected(runner.state(), &trial, &before))
        }
        Ok(Given::Done(Event::Ignored { why, .. })) => {
            terminal.say(&format!("  without effect: {why}"))
        }
        Ok(Given::Done(Event::Confirmed { trial, touched })) => {
            if let Some(touched) = touched {
                terminal.say(&shown::touched(runner.state(), &trial, &touched))?;
            }
            feedback(runner, &trial, terminal)
        }
        Ok(Given::Done(_)) => Ok(()),
        Ok(Given::Void { why }) => terminal.say(&format!(
            "  THE TRIAL IS VOID and will be presented again: {why}"
        )),
        Err(RunError::Store(error @ StoreError::Place { .. })) => {
            terminal.say(&format!("  NOT STORED: {error}. Then give it again."))
        }
        Err(RunError::Refused(refusal)) => terminal.say(&format!("  {refusal}")),
        Err(
            error @ (RunError::NoDrive { .. }
            | RunError::TooLong { .. }
            | RunError::Device(_)
            | RunError::NoBench { .. }),
        ) => terminal.say(&format!(
            "  NOT PRESENTED: {error}. /leave, and give the same command with what is missing."
        )),
        Err(error) => Err(error.into()),
    }
}

/// The answer that counts for each trial, as it is said; none where there is none.
fn noted(state: &State<'_>) -> Vec<Option<String>> {
    let trials = state.trials();
    let noted = trials.map(|(trial, of)| Some(said(state, trial, of.answer()?)));
    noted.collect()
}

/// What the correction of the trial named `name` did to the answers that were noted `before`.
fn corrected(state: &State<'_>, name: &str, before: &[Option<String>]) -> String {
    let mut lines = Vec::new();
    let now = noted(state);
    let each = before.iter().zip(&now).enumerate();
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for (i, (before, now)) in each {
        let (Some(before), Some(now)) = (before, now) else {
            continue;
        };
        let line = format!("  trial {}: {before} → {now}", i + 1);
        match i + 1 == state.number(name) {
            true => own.push(line),
            false if before != now => others.push(line),
            false => {}
        }
    }
    lines.extend(own);
    if !others.is_empty() {
        lines.push("  the letters of this order stand for other samples now, also in:".to_owned());
        lines.append(&mut others);
        lines.push("  the tables keep both, with the reason".to_owned());
    }
    lines.join("\n")
}

/// The right answer of a training trial, where the protocol has it said.
fn feedback(runner: &Runner<'_>, name: &str, terminal: &Terminal) -> Outcome {
    let mut trials = runner.state().plan().trials.iter();
    let right = trials
        .find(|trial| trial.name == name)
        .and_then(|trial| runner.state().feedback(trial));
    right.map_or(Ok(()), |right| {
        terminal.say(&format!("  the right answer was: {}", right.join(" ")))
    })
}

/// Withdrawal asks twice.
fn withdraw(runner: &mut Runner<'_>, terminal: &Terminal) -> Outcome {
    terminal.say("  The participant withdraws: everything of this participant is to be erased.")?;
    match terminal.ask("type WITHDRAW to confirm>")? {
        Typed::Line(line) if line == "WITHDRAW" => give(runner, Command::Withdraw, terminal),
        _ => terminal.say("  nothing was withdrawn"),
    }
}

fn ended_with(runner: &Runner<'_>, args: &Arguments, terminal: &Terminal) -> Outcome {
    let what = match runner.state().stage() {
        Stage::Withdrawn => return terminal.say(&withdrawn(args)),
        Stage::Stopped => "was stopped before its end",
        _ if !runner.state().is_complete() => "was ended without consent",
        _ => "is complete",
    };
    let purpose = match args.leading.rehearsal {
        true => "rehearsal",
        false => "session",
    };
    terminal.say(&format!(
        "The {purpose} {} of {} {what}: {}.",
        args.session,
        args.participant,
        status(runner)
    ))?;
    match terminal.not_asked_for() {
        0 => Ok(()),
        lines => terminal.say(&format!(
            "  {}{} after the end: not taken. A session that is over takes no corrections; mend a copy of its exported tables, and say so beside them.",
            if lines < MOST_COUNTED { "" } else { "at least " },
            counted(lines, "line")
        )),
    }
}
