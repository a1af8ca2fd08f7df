//! `piezotact spectrum --rest`: the noise of a sensor at rest.

use std::path::PathBuf;

use anyhow::anyhow;
use piezotact::criterion::Outcome as Judged;
use piezotact::noise::{Noise, NoiseConfig, NoiseCriterion, NoiseError, noise};
use piezotact::number::digits;
use piezotact::page::Shown as _;
use piezotact_report::report::{csv, html};

use crate::advice::OptionWords;
use crate::cli::Spectrum;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say_warnings};
use crate::places::outputs;
use crate::reading::read;

pub(super) fn run(args: &Spectrum) -> Outcome {
    let report: Vec<_> = args.report.iter().map(PathBuf::as_path).collect();
    outputs(&[&args.file], &report)?;
    let recording = read(&args.file, &args.reading)?.recording;
    let file = args.file.display().to_string();
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
