//! `piezotact noise`: the noise of a sensor at rest.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use piezotact::criterion::Outcome as Judged;
use piezotact::noise::{Noise, NoiseConfig, NoiseError, noise};
use piezotact::number::digits;
use piezotact::quantity::Band;
use piezotact_report::report::{csv, html};

use super::{outputs, read};
use crate::advice::OptionWords;
use crate::cli::Reading;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{print, print_document, say_doubts, write_text};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A recording of the sensor at rest, 10 s or longer.
    recording: PathBuf,
    /// The channel; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    channel: Option<String>,
    /// The band of the rms, in Hz; default: 10..1000, as far as the rate allows.
    #[arg(long, value_name = "LOW..HIGH")]
    band: Option<Band>,
    #[command(flatten)]
    reading: Reading,
    /// Writes a report.
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long, group = "form")]
    json: bool,
    /// Prints frequency, PSD and amplitude density as CSV.
    #[arg(long, group = "form")]
    csv: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let report: Vec<_> = args.report.iter().map(PathBuf::as_path).collect();
    outputs(&[&args.recording], &report)?;
    let recording = read(&args.recording, &args.reading)?.recording;
    let file = args.recording.display().to_string();
    let usual = NoiseConfig::usual(recording.rate()).map_err(|e| anyhow!("{file}: {e}"))?;
    let config = NoiseConfig {
        band_hz: args.band.unwrap_or(usual.band_hz),
        ..usual
    };
    let found = noise(&recording, args.channel.as_deref(), &config).map_err(|e| match e {
        NoiseError::Band { .. } => usage(e),
        e => Failure::Data(anyhow::Error::new(e).context(file.clone())),
    })?;
    if let Some(path) = &args.report {
        write_text(path, &html(&found.page(&file), &OptionWords)?)?;
    }
    match (args.json, args.csv) {
        (true, _) => print_document(&found),
        (_, true) => {
            say_doubts(&found.doubts);
            print(csv(&found.spectrum_table())?.trim_end())
        }
        _ => {
            print(&text(&found))?;
            say_doubts(&found.doubts);
            args.report
                .iter()
                .try_for_each(|path| print(&format!("report: {}", path.display())))
        }
    }
}

/// The conclusion first, then the numbers and the criteria that are not met.
fn text(found: &Noise) -> String {
    let unit = found.unit.symbol();
    let density = |d: &piezotact::noise::Density| {
        format!(
            "amplitude density at {} Hz: {} {unit}/√Hz",
            d.frequency_hz,
            digits(d.value)
        )
    };
    let mut lines = vec![found.sentence()];
    lines.extend(found.densities.iter().map(density));
    lines.push(found.drift_sentence());
    let open = found.criteria.iter().filter(|c| c.outcome != Judged::Met);
    lines.extend(open.map(|criterion| format!("criterion: {criterion}")));
    lines.join("\n")
}
