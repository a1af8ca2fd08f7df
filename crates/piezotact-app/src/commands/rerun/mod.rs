//! `piezotact rerun`: a report or a document made again, and compared value by value.

mod compare;
mod repeat;

use std::path::PathBuf;

use clap::Args;
use piezotact::document::INVOCATION;
use piezotact::invocation::Rerun;
use piezotact_report::invocation::command_line;

use crate::failure::{Failure, Outcome};
use crate::made::Made;
use crate::output::{counted, print, print_document, say};
use compare::{Compared, compared};
use repeat::Repeated;

/// How many differences are named.
const MOST_NAMED: usize = 10;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A report (HTML) or a document (JSON) that this program wrote.
    file: PathBuf,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let made = Made::read(&args.file)?;
    let folder = made.folder(&args.file)?;
    let changed = made.changed(&folder);
    let repeated = Repeated::of(&made, &folder)?;
    for what in &changed {
        say(what);
    }
    say(&format!(
        "runs again: {}",
        command_line(&made.invocation.command)
    ));
    let (now, invocation) = repeated.run(&made)?;
    let mut found = compared(&made.results, &now);
    found.invocations(&made.invocation, &invocation);
    if !made.shows_its_invocation {
        let [before, now] = ["changed by hand", "what is stored in the report"];
        found.one(INVOCATION, Some(before.into()), Some(now.into()));
    }
    let rerun = document(args, &made, found, changed);
    if args.json {
        print_document(&rerun)?;
    } else {
        print(&text(&rerun))?;
    }
    if rerun.same {
        Ok(())
    } else {
        Err(Failure::NotPassed)
    }
}

fn document(args: &Arguments, made: &Made, found: Compared, changed: Vec<String>) -> Rerun {
    Rerun {
        file: args.file.display().to_string(),
        command: made.invocation.command.clone(),
        same: found.differences.is_empty() && made.untouched,
        compared: found.compared,
        different: found.differences.len(),
        first_differences: found.differences.into_iter().take(MOST_NAMED).collect(),
        changed,
    }
}

fn text(rerun: &Rerun) -> String {
    if rerun.same {
        return format!("the same: {}", counted(rerun.compared, "value"));
    }
    if rerun.different == 0 {
        return format!(
            "not the same: {} are, but the file itself was changed",
            counted(rerun.compared, "value")
        );
    }
    let mut text = format!(
        "different: {} of {}",
        rerun.different,
        counted(rerun.compared, "value")
    );
    for one in &rerun.first_differences {
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".into());
        text += &format!(
            "\n  {}: {}, now {}",
            one.place,
            shown(&one.before),
            shown(&one.now)
        );
    }
    match rerun.different - rerun.first_differences.len() {
        0 => text,
        more => format!("{text}\n  and {}", counted(more, "more value")),
    }
}
