//! `piezotact noise`: the noise of a sensor at rest.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use piezotact::criterion::Outcome as Judged;
use piezotact::noise::{Noise, NoiseConfig, NoiseCriterion, NoiseError, noise};
use piezotact::number::digits;
use piezotact::page::Shown as _;
use piezotact::quantity::Band;
use piezotact_report::report::{csv, html};

use crate::advice::OptionWords;
use crate::cli::Reading;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say_warnings};
use crate::places::outputs;
use crate::reading::read;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A recording of the sensor at rest, 4 s or longer; 10 s or longer for the drift.
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
    let config = match args.band {
        Some(band_hz) => NoiseConfig::over(band_hz),
        None => match NoiseConfig::usual(recording.rate()) {
            Ok(config) => config,
            Err(_) => {
                return Err(usage(anyhow!(
                    "{file}: expected a rate above 20 Hz for the usual band from 10 Hz, found {}; state a band with --band",
                    recording.rate()
                )));
            }
        },
    };
    let mut found = noise(&recording, args.channel.as_deref(), &config).map_err(|e| match e {
        NoiseError::Band { .. } | NoiseError::NarrowBand { .. } => usage(e),
        e => Failure::Data(anyhow::Error::new(e).context(file.clone())),
    })?;
    found.file = file;
    if let Some(path) = &args.report {
        write_report(path, &html(&found.page(), &OptionWords)?)?;
    }
    match (args.json, args.csv) {
        (true, _) => print_document(&found),
        (_, true) => {
            say_warnings(&found.warnings);
            print(csv(&found.spectrum_table())?.trim_end())
        }
        _ => {
            print(&text(&found))?;
            say_warnings(&found.warnings);
            args.report
                .iter()
                .try_for_each(|path| print(&format!("report: {}", path.display())))
        }
    }
}

/// The conclusion first, then the numbers and the criteria that are not met.
fn text(found: &Noise) -> String {
    let unit = match found.unit.symbol() {
        "no unit" => "(no unit)",
        symbol => symbol,
    };
    let density = |d: &piezotact::noise::Density| {
        format!(
            "amplitude density at {} Hz: {} {unit}/√Hz",
            d.frequency_hz,
            digits(d.value)
        )
    };
    let mut lines = vec![found.sentence()];
    lines.extend(found.densities.iter().map(density));
    lines.extend([found.mains_sentence(), found.drift_sentence()]);
    // Lines of the mains have a sentence of their own.
    let of_mains = |what| matches!(what, NoiseCriterion::MainsLine { .. });
    let open = found.criteria.iter();
    let open = open.filter(|c| c.outcome != Judged::Met && !of_mains(c.what));
    lines.extend(open.map(|criterion| format!("criterion: {criterion}")));
    lines.join("\n")
}
