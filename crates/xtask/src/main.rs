//! Chores of the project: `tidy` checks its invariants, `lines` counts it, `unused` lists what nobody uses, `schemas` writes the JSON
//! Schemas of documents (feature `schemas`), `bench` measures it beside its peers (feature `measure`).

#[cfg(feature = "measure")]
mod bench;
#[cfg(feature = "measure")]
mod discrimination;
mod lines;
#[cfg(feature = "measure")]
mod rendering;
#[cfg(feature = "schemas")]
mod schemas;
mod source;
#[cfg(feature = "measure")]
mod stops;
#[cfg(feature = "measure")]
#[path = "../../piezotact/tests/studies/mod.rs"]
mod studies;
mod tidy;
mod unused;
#[cfg(feature = "measure")]
mod verdicts;
#[cfg(feature = "measure")]
mod work;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["tidy"] => tidy::run(),
        ["lines"] => lines::run(None),
        ["lines", of] => lines::run(Some(of)),
        ["unused"] => unused::run(),
        #[cfg(feature = "schemas")]
        ["schemas"] => schemas::run(),
        #[cfg(not(feature = "schemas"))]
        ["schemas"] => bail!(
            "`schemas` needs the feature `schemas`: cargo run --package xtask --features schemas -- schemas"
        ),
        #[cfg(feature = "measure")]
        ["bench", python, only @ ..] => bench::run(python, only),
        #[cfg(feature = "measure")]
        ["work", name, folder, repetitions] => {
            work::run(name, folder.as_ref(), repetitions.parse()?)
        }
        #[cfg(not(feature = "measure"))]
        ["bench" | "work", ..] => {
            bail!("`bench` and `work` need the feature `measure`: ./x bench compiles it")
        }
        _ => bail!(
            "expected `tidy`, `lines [CRATE[::MODULE]]`, `unused`, `schemas`, `bench PYTHON [W1a …]` or `work NAME FOLDER REPETITIONS`"
        ),
    }
}
