//! Chores of the project: `tidy` checks its invariants, `schemas` writes the JSON Schemas of documents, `bench` measures it beside its peers.

mod bench;
mod discrimination;
mod rendering;
mod schemas;
#[path = "../../piezotact/tests/studies/mod.rs"]
mod studies;
mod tidy;
mod verdicts;
mod work;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["tidy"] => tidy::run(),
        ["schemas"] => schemas::run(),
        ["bench", python, only @ ..] => bench::run(python, only),
        ["work", name, folder, repetitions] => {
            work::run(name, folder.as_ref(), repetitions.parse()?)
        }
        _ => bail!(
            "expected `tidy`, `schemas`, `bench PYTHON [W1a …]` or `work NAME FOLDER REPETITIONS`"
        ),
    }
}
