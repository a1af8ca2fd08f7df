//! The commands that run on the digital twin alone.

use std::path::PathBuf;

use clap::Args;
use piezotact_bench::replay;

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// One chapter of the thesis; unless stated, all of them.
    #[arg(long, value_name = "3|4|5|6", value_parser = chapter)]
    pub(crate) chapter: Option<u8>,
    /// The folder for report.html and findings.json.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Draws people, surfaces, movements and noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// A parameter file of your own (TOML): what it states replaces the twin's built-in numbers.
    #[arg(long, value_name = "FILE")]
    pub(crate) twin: Option<PathBuf>,
    /// Prints the findings as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

fn chapter(text: &str) -> Result<u8, String> {
    let known = replay::Replay::CHAPTERS;
    let number = text.parse().ok().filter(|number| known.contains(number));
    number.ok_or_else(|| {
        let numbers = known.map(|number| number.to_string());
        format!(
            "expected one of the chapters {}, found `{text}`",
            numbers.join(", ")
        )
    })
}
