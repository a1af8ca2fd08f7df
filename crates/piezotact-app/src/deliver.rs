//! The one way out of a command: its report, its table, its JSON, what it prints, its warnings, its exit code.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::document::Content;
use piezotact::page::{Ending, Page, Shown};
use piezotact_report::report::{csv, html, terminal};

use crate::advice::{OptionWords, merged_text};
use crate::calls::keep_page;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say, write_text};

/// Where a result goes. The options of a report's figures and tables are added to every command with `--report`
/// ([`crate::parts`]).
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Outputs {
    /// Writes a report: the conclusion, the numbers, tables, figures, and how it was made.
    #[arg(long, value_name = "REPORT.html")]
    pub(crate) report: Option<PathBuf>,
    /// Writes the results as a table, with a row for each item.
    #[arg(long, value_name = "TABLE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

impl Outputs {
    /// The files that are written.
    pub(crate) fn files(&self) -> Vec<&Path> {
        let files = self.report.iter().chain(&self.csv);
        files.map(PathBuf::as_path).collect()
    }
}

/// Hands out `value`: writes what `outputs` ask for, prints it, says its warnings, and ends as it ended.
pub(crate) fn deliver<T: Shown + Content>(outputs: &Outputs, value: &T) -> Outcome {
    deliver_and(outputs, value, &[])
}

/// As [`deliver`], of a command that wrote `others`, which it names.
pub(crate) fn deliver_and<T: Shown + Content>(
    outputs: &Outputs,
    value: &T,
    others: &[&Path],
) -> Outcome {
    let page = value.page();
    write(outputs, &page)?;
    let Some(page) = keep_page(page) else {
        print_document(value)?;
        return ended(value.ending());
    };
    if outputs.json {
        print_document(value)?;
    } else {
        print(&terminal(&page)?)?;
        for (about, warning) in page.merged_warnings() {
            let about = if about.is_empty() {
                String::new()
            } else {
                format!("{about}: ")
            };
            say(&format!("warning: {about}{}", merged_text(warning)));
        }
        let reports = outputs
            .report
            .iter()
            .map(|path| ("report:", path.as_path()));
        let tables = outputs.csv.iter().map(|path| ("wrote", path.as_path()));
        let others = others.iter().map(|path| ("wrote", *path));
        for (what, path) in others.chain(tables).chain(reports) {
            print(&format!("{what} {}", path.display()))?;
        }
    }
    ended(value.ending())
}

/// Writes the report and the table that `outputs` ask for.
pub(crate) fn write(outputs: &Outputs, page: &Page) -> Outcome {
    if let Some(path) = &outputs.csv {
        let Some(table) = page.csv_table() else {
            return Err(usage(anyhow!(
                "this result has no table for --csv; --json prints all of it"
            )));
        };
        write_text(path, &csv(table)?)?;
    }
    match &outputs.report {
        Some(path) => write_report(path, &html(page, &OptionWords)?),
        None => Ok(()),
    }
}

/// The exit code of a result.
pub(crate) fn ended(ending: Ending) -> Outcome {
    match ending {
        Ending::Done => Ok(()),
        Ending::NotPassed => Err(Failure::NotPassed),
        Ending::PassedInPart => Err(Failure::PassedInPart),
        Ending::NotDecided => Err(Failure::NotDecided),
    }
}
