//! Chores of the project: `tidy` checks its invariants, `lines` counts it, `unused` lists what nobody uses, `warnings` writes
//! the page of warnings, `schemas` the JSON Schemas of documents (feature `schemas`).

mod lines;
#[cfg(feature = "schemas")]
mod schemas;
mod source;
mod tidy;
mod unused;
mod warnings;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["tidy"] => tidy::run(),
        ["lines"] => lines::run(None),
        ["lines", of] => lines::run(Some(of)),
        ["unused"] => unused::run(),
        ["warnings"] => warnings::run(),
        #[cfg(feature = "schemas")]
        ["schemas"] => schemas::run(),
        #[cfg(not(feature = "schemas"))]
        ["schemas"] => bail!(
            "`schemas` needs the feature `schemas`: cargo run --package xtask --features schemas -- schemas"
        ),
        _ => bail!("expected `tidy`, `lines [CRATE[::MODULE]]`, `unused`, `warnings` or `schemas`"),
    }
}
