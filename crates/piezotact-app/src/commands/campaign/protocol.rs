//! `piezotact campaign protocol`: the protocols of the library, as files to start from, and data dictionaries.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::page::{Cell, Column, Table};
use piezotact_people::campaign::protocol::{LIBRARY, read, reference};
use piezotact_report::report;

use super::{dictionary, no_protocol};
use crate::failure::{Outcome, usage};
use crate::output::{print, print_document, write_text};
use crate::places::outputs;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The name of a protocol of the library; with --dictionary also a protocol (TOML). Without it, the library is listed.
    protocol: Option<PathBuf>,
    /// Prints what each column of the table of answers means, task by task.
    #[arg(long, requires = "protocol", conflicts_with = "out")]
    dictionary: bool,
    /// Prints all fields that a protocol can state: type, allowed values, default and meaning.
    #[arg(long, conflicts_with_all = ["protocol", "dictionary", "out", "json"])]
    explain: bool,
    /// Writes the protocol to a file (TOML) instead of standard output.
    #[arg(long, value_name = "FILE.toml", requires = "protocol")]
    out: Option<PathBuf>,
    /// Prints the protocol, or its dictionary with the fields that BIDS has for a column, as JSON.
    #[arg(long, requires = "protocol", conflicts_with = "out")]
    json: bool,
}

pub(super) fn run(args: &Arguments) -> Outcome {
    let written: Vec<&Path> = args.out.iter().map(PathBuf::as_path).collect();
    outputs(&[], &written)?;
    if args.explain {
        return print(reference().trim_end());
    }
    let Some(named) = &args.protocol else {
        return print(&report::text(&library()?)?);
    };
    if args.dictionary {
        let found = dictionary::of(named)?;
        return match args.json {
            true => print_document(&found),
            false => print(&dictionary::in_words(&found)),
        };
    }
    let found = LIBRARY.iter().find(|(known, _)| Path::new(known) == named);
    let Some((_, toml)) = found else {
        return Err(usage(no_protocol(&named.display().to_string())));
    };
    if args.json {
        return print_document(&read(toml)?);
    }
    match &args.out {
        None => print(toml.trim_end()),
        Some(path) => {
            write_text(path, toml)?;
            print(&format!("wrote {}", path.display()))
        }
    }
}

/// The protocols of the library: name, title, participants, source.
fn library() -> Outcome<Table> {
    let names = ["name", "title", "participants", "source"];
    let mut table = Table::new(names.map(|name| Column::new(name, name)));
    for (name, toml) in LIBRARY {
        let protocol = read(toml)?;
        table.rows.push(vec![
            Cell::from(name),
            Cell::from(protocol.title),
            Cell::from(protocol.panel.participants.to_string()),
            Cell::from(protocol.source),
        ]);
    }
    Ok(table)
}
