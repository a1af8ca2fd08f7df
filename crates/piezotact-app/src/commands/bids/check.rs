//! `piezotact bids check`: what is wrong with a data set, by our own check and by the official validator where it is installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use piezotact_study::bids::{SecondOpinion, check};

use crate::deliver::{Outputs, deliver};
use crate::failure::Outcome;
use crate::places::outputs;

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
    #[command(flatten)]
    outputs: Outputs,
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
    outputs(&[], &args.outputs.files())?;
    let mut checked = check(&args.folder)?;
    checked.second_opinion = match args.second_opinion {
        Asked::IfInstalled => second_opinion(&args.folder),
        Asked::None => None,
    };
    deliver(&args.outputs, &checked)
}

/// What the official validator says; without an answer, why there is none.
fn second_opinion(folder: &Path) -> Option<SecondOpinion> {
    let failed = |why: String| {
        Some(SecondOpinion {
            program: VALIDATOR.to_owned(),
            errors: Vec::new(),
            warnings: 0,
            failed: Some(why),
        })
    };
    let spawned = Command::new(VALIDATOR)
        .args(["--format", "json", "--max-rows", "-1"])
        .arg(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut child = match spawned {
        Ok(child) => child,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return failed(format!(
                "not asked, as it is not installed; install it with pip install {VALIDATOR}"
            ));
        }
        Err(error) => return failed(format!("cannot be started: {error}")),
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
