//! `piezotact spectrum`: the PSD of one channel, as a whole or over time.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::figure::Spectrograms;
use piezotact::quantity::{Hertz, Uncalibrated};
use piezotact::recording::Channel;
use piezotact::series::Series;
use piezotact::spectrum::{
    Averaging, Cells, EstimateError, SpectrogramConfig, WelchConfig, spectrogram, welch,
};
use serde_json::json;

use super::{outputs, read};
use crate::cli::Spectrum;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, json_text, print, print_or_write, say_doubts, write_text};
use crate::report::{figures, name};

pub(crate) fn run(args: &Spectrum) -> Outcome {
    let written: Vec<&Path> = args
        .out
        .iter()
        .chain(&args.svg)
        .chain(&args.spectrogram)
        .map(PathBuf::as_path)
        .collect();
    outputs(&[&args.file], &written)?;
    let contents = read(&args.file, &args.reading)?;
    let recording = &contents.recording;
    let (channel, series) = recording.raw(args.channel.as_deref()).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(args.file.display().to_string()))
    })?;
    if let Some(path) = &args.spectrogram {
        say_doubts(&recording.about.doubts);
        return over_time(args, channel, &series, path);
    }
    let usual = WelchConfig::thesis_2024();
    let config = WelchConfig {
        window: args.window,
        segment: args.segment.unwrap_or(usual.segment),
        overlap: args.overlap.unwrap_or(usual.overlap),
        averaging: if args.median {
            Averaging::Median
        } else {
            Averaging::Mean
        },
        ..usual
    };
    let psd = welch(&series, &config).map_err(|error| refused(args, error))?;
    let unit = channel.unit.of_psd();
    let doubts: Vec<_> = recording
        .about
        .doubts
        .iter()
        .chain(&psd.doubts)
        .cloned()
        .collect();
    let frequencies_hz = psd.frequencies_hz();
    if args.json {
        let value = json!({
            "file": args.file,
            "channel": channel.name,
            "unit": unit,
            "rate_hz": series.rate(),
            "resolution_hz": psd.resolution_hz,
            "averages": psd.averages,
            "config": psd.config,
            "frequency_hz": frequencies_hz,
            "psd": psd.values,
            "doubts": doubts_json(&doubts)?,
        });
        return print_or_write(args.out.as_deref(), &json_text(&value)?);
    }
    say_doubts(&doubts);
    if args.csv {
        let mut text = format!("frequency (Hz),psd ({unit})");
        for (frequency_hz, value) in frequencies_hz.iter().zip(&psd.values) {
            let _never_fails = write!(text, "\n{frequency_hz},{value:e}");
        }
        return print_or_write(args.out.as_deref(), &text);
    }
    if let Some(svg) = &args.svg {
        let title = format!(
            "{}, {} ({} window, {} samples, {:.2} Hz, {} segments)",
            name(&args.file),
            channel.name,
            args.window.name(),
            psd.config.segment,
            psd.resolution_hz,
            psd.averages
        );
        let figure = figures::psd(&title, &unit, &frequencies_hz, &psd.values)?;
        write_text(svg, &figure)?;
        return print(&format!("wrote {}", svg.display()));
    }
    let (frequency_hz, strongest) = psd.strongest();
    print(&format!(
        "{}, channel {}: {} segments of {} samples ({:.3} Hz), strongest line {strongest:.4e} {unit} at {frequency_hz:.2} Hz\n\
         the whole spectrum: --json, --csv or --svg OUT; over time: --spectrogram OUT.svg",
        args.file.display(),
        channel.name,
        psd.averages,
        psd.config.segment,
        psd.resolution_hz,
    ))
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
