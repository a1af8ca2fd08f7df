//! `piezotact spectrum`: the PSD of one channel, as a whole or over time, and the noise of a sensor at rest.

mod rest;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::figure::Spectrograms;
use piezotact::number::rounded;
use piezotact::quantity::{Hertz, Uncalibrated};
use piezotact::recording::Channel;
use piezotact::series::Series;
use piezotact::spectrum::{
    Averaging, Cells, EstimateError, SpectrogramConfig, SpectrumDocument, WelchConfig, spectrogram,
    welch,
};
use piezotact_report::figures;

use crate::cli::Spectrum;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{document_text, print, print_or_write, say_merged, say_warnings, write_text};
use crate::places::{has_ending, outputs};
use crate::reading::read;
use crate::report::name;

pub(crate) fn run(args: &Spectrum) -> Outcome {
    if args.rest {
        return rest::run(args);
    }
    check_outputs(args)?;
    let contents = read(&args.file, &args.reading)?;
    let recording = &contents.recording;
    let (channel, series) = recording.raw(args.channel.as_deref()).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(args.file.display().to_string()))
    })?;
    if let Some(path) = &args.spectrogram {
        say_warnings(&recording.about.warnings);
        return over_time(args, channel, &series, path);
    }
    let psd = welch(&series, &config(args)).map_err(|error| refused(args, error))?;
    let document = SpectrumDocument::of(&psd, (recording, channel), &args.file);
    if args.json {
        let out = args.out.as_deref();
        return print_or_write(out, &document_text(&document, out)?);
    }
    say_merged(&document.warnings);
    if args.csv {
        return print_or_write(args.out.as_deref(), &csv(&document));
    }
    if let Some(svg) = &args.svg {
        let title = title(args, &document);
        let figure = figures::psd(&title, &document.unit, &document.frequency_hz, document.psd)?;
        write_text(svg, &figure)?;
        return print(&format!("wrote {}", svg.display()));
    }
    print(&text(&document, psd.strongest()))
}

/// Refuses outputs that would replace a file, and an ending that is not that of the format.
fn check_outputs(args: &Spectrum) -> Outcome {
    let written: Vec<&Path> = args
        .out
        .iter()
        .chain(&args.svg)
        .chain(&args.spectrogram)
        .map(PathBuf::as_path)
        .collect();
    if let Some(out) = &args.out {
        let endings: &[&str] = if args.json {
            &["json"]
        } else {
            &["csv", "txt"]
        };
        // Devices are refused as what they are.
        if !out.exists() || out.is_file() {
            has_ending(out, endings)?;
        }
    }
    outputs(&[&args.file], &written)
}

/// As the options ask, else as is usual.
fn config(args: &Spectrum) -> WelchConfig {
    let usual = WelchConfig::thesis_2024();
    WelchConfig {
        window: args.window,
        segment: args.segment.unwrap_or(usual.segment),
        overlap: args.overlap.unwrap_or(usual.overlap),
        averaging: if args.median {
            Averaging::Median
        } else {
            Averaging::Mean
        },
        ..usual
    }
}

fn csv(document: &SpectrumDocument<'_>) -> String {
    let mut text = format!("frequency (Hz),psd ({})", document.unit);
    for (frequency_hz, value) in document.frequency_hz.iter().zip(document.psd) {
        let _never_fails = write!(text, "\n{frequency_hz},{value:e}");
    }
    text
}

fn title(args: &Spectrum, document: &SpectrumDocument<'_>) -> String {
    format!(
        "{}, {} ({} window, {} samples, {:.2} Hz, {} segments)",
        name(&args.file),
        document.channel,
        args.window.name(),
        document.config.segment,
        document.resolution_hz,
        document.averages
    )
}

fn text(document: &SpectrumDocument<'_>, (frequency_hz, strongest): (f64, f64)) -> String {
    format!(
        "{}, channel {}: {} segments of {} samples ({:.3} Hz), highest value {strongest:.4e} {} at {} Hz\n\
         the whole spectrum: --json, --csv or --svg OUT; over time: --spectrogram OUT.svg",
        document.file.display(),
        document.channel,
        document.averages,
        document.config.segment,
        document.resolution_hz,
        document.unit,
        rounded(frequency_hz),
    )
}

fn refused(args: &Spectrum, error: EstimateError) -> Failure {
    match error {
        EstimateError::Config { .. } | EstimateError::Frequency { .. } => usage(error),
        _ => Failure::Data(anyhow!("{}: {error}", args.file.display())),
    }
}

/// The highest frequency of a figure over time unless another is stated: what fingers feel.
const HIGHEST: Hertz = Hertz(1000.0);

fn over_time(
    args: &Spectrum,
    channel: &Channel,
    series: &Series<Uncalibrated>,
    path: &Path,
) -> Outcome {
    let usual = SpectrogramConfig::usual(series.rate());
    let half = series.rate().nyquist();
    let config = SpectrogramConfig {
        window: args.window,
        segment: args.segment.unwrap_or(usual.segment),
        overlap: args.overlap.unwrap_or(usual.overlap),
        cells: Cells::of_a_figure(
            args.max_frequency
                .map_or(Hertz(half.0.min(HIGHEST.0)), Hertz),
        ),
        ..usual
    };
    let result = spectrogram(series, &config).map_err(|error| refused(args, error))?;
    let figure = Spectrograms {
        panels: vec![result.panel(format!("{}, {}", name(&args.file), channel.name))],
        unit: channel.unit.of_psd(),
        note: result.estimate_text(),
    };
    write_text(path, &piezotact_report::spectrogram::file(&figure)?)?;
    print(&format!("wrote {}", path.display()))
}
