//! `piezotact bids check`: what is wrong with a data set, by our own check and by the official validator where it is installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use piezotact::criterion::Outcome as Judged;
use piezotact::number::counted;
use piezotact_study::bids::{Checked, SecondOpinion, check};

use crate::failure::{Failure, Outcome};
use crate::output::{print, print_document, say};

/// The official validator, as its package calls it.
const VALIDATOR: &str = "bids-validator-deno";
/// How long it may take.
const PATIENCE: Duration = Duration::from_secs(600);

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of the data set.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Whether the official validator is asked too, where it is installed.
    #[arg(long, value_enum, default_value = "if-installed")]
    second_opinion: Asked,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
}

/// Whether the official validator is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Asked {
    /// Where it is installed.
    IfInstalled,
    /// Never.
    None,
}

pub(super) fn run(args: &Arguments) -> Outcome {
    let mut checked = check(&args.folder)?;
    checked.second_opinion = match args.second_opinion {
        Asked::IfInstalled => second_opinion(&args.folder),
        Asked::None => None,
    };
    match args.json {
        true => print_document(&checked)?,
        false => shown(args, &checked)?,
    }
    let other = checked.second_opinion.as_ref();
    let errors = other.is_some_and(|other| !other.errors.is_empty());
    match (checked.outcome, errors) {
        (Judged::NotMet, _) | (_, true) => Err(Failure::NotPassed),
        (Judged::NotDecided, _) => Err(Failure::NotDecided),
        (Judged::Met, false) => Ok(()),
    }
}

fn shown(args: &Arguments, checked: &Checked) -> Outcome {
    for problem in &checked.problems {
        print(&problem.to_string())?;
    }
    if checked.more > 0 {
        print(&format!("… and {} more of the same kinds", checked.more))?;
    }
    let read = format!(
        "{} and {}",
        counted(checked.tables, "table"),
        counted(checked.signals, "signal file")
    );
    let folder = args.folder.display();
    print(&match checked.outcome {
        Judged::Met => format!("{folder}: nothing wrong was found in {read}"),
        Judged::NotMet => format!(
            "{folder}: {} found in {read}",
            counted(checked.problems.len() + checked.more, "problem")
        ),
        Judged::NotDecided => {
            format!("{folder}: nothing could be checked: no table and no signal file")
        }
    })?;
    if !checked.not_read.is_empty() {
        let kinds = checked.not_read.iter();
        let kinds: Vec<String> = kinds
            .map(|(kind, count)| format!("{count} of {kind}"))
            .collect();
        print(&format!(
            "not read, as this check does not know their contents: files {}",
            kinds.join(", ")
        ))?;
    }
    match &checked.second_opinion {
        None => {}
        Some(SecondOpinion {
            failed: Some(why), ..
        }) => say(&format!("{VALIDATOR}: {why}")),
        Some(validator) => {
            for error in &validator.errors {
                print(&format!("{VALIDATOR}: {error}"))?;
            }
            print(&format!(
                "{VALIDATOR}: {} and {}",
                counted(validator.errors.len(), "error"),
                counted(validator.warnings, "warning")
            ))?;
        }
    }
    Ok(())
}

/// What the official validator says; `None` where it is not installed.
fn second_opinion(folder: &Path) -> Option<SecondOpinion> {
    let mut child = Command::new(VALIDATOR)
        .args(["--format", "json", "--max-rows", "-1"])
        .arg(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let failed = |why: String| {
        Some(SecondOpinion {
            program: VALIDATOR.to_owned(),
            errors: Vec::new(),
            warnings: 0,
            failed: Some(why),
        })
    };
    let Some(mut out) = child.stdout.take() else {
        return failed("expected its answer, found none; run it by hand".into());
    };
    let (sender, answer) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let mut text = String::new();
        let read = std::io::Read::read_to_string(&mut out, &mut text);
        // Nobody waits any more where this fails.
        let _sent = sender.send(read.map(|_| text));
    });
    let began = Instant::now();
    while child.try_wait().ok()?.is_none() {
        if began.elapsed() > PATIENCE {
            let _ended = child.kill();
            let _reaped = child.wait();
            return failed(format!(
                "expected its answer within {} s, found none; run it by hand",
                PATIENCE.as_secs()
            ));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    // What it began may go on, and holds its output.
    let text = match answer.recv_timeout(Duration::from_secs(10)) {
        Ok(Ok(text)) => text,
        _ => return failed("expected its answer when it ended, found none; run it by hand".into()),
    };
    match issues(&text) {
        Some((errors, warnings)) => Some(SecondOpinion {
            program: VALIDATOR.to_owned(),
            errors,
            warnings,
            failed: None,
        }),
        None => failed("expected its answer as JSON, found another text; run it by hand".into()),
    }
}

/// Its errors and the number of its warnings.
fn issues(text: &str) -> Option<(Vec<String>, usize)> {
    let value: serde_json::Value = serde_json::from_str(text.trim()).ok()?;
    let issues = value.get("issues")?.get("issues")?.as_array()?;
    let of = |issue: &serde_json::Value, key: &str| {
        issue
            .get(key)
            .and_then(|text| text.as_str())
            .unwrap_or_default()
            .to_owned()
    };
    let (errors, warnings): (Vec<_>, Vec<_>) = issues
        .iter()
        .partition(|issue| of(issue, "severity") == "error");
    let errors = errors.into_iter().map(|issue| {
        let parts = ["code", "subCode", "issueMessage"].map(|key| of(issue, key));
        let parts: Vec<&str> = parts
            .iter()
            .map(String::as_str)
            .filter(|part| !part.is_empty())
            .collect();
        format!("{}: {}", of(issue, "location"), parts.join(", "))
    });
    Some((errors.collect(), warnings.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_official_validator_are_told_from_warnings() {
        let text = r#"{"issues":{"issues":[
            {"code":"NOT_INCLUDED","location":"/odd.txt","severity":"error"},
            {"code":"TOO_FEW_AUTHORS","location":"/dataset_description.json","severity":"warning"}]}}"#;
        let (errors, warnings) = issues(text).unwrap();
        assert_eq!(
            (errors.as_slice(), warnings),
            (&["/odd.txt: NOT_INCLUDED".to_owned()][..], 1)
        );
        assert!(issues("not JSON").is_none() && issues("{}").is_none());
    }
}
