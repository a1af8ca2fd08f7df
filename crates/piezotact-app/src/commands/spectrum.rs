//! `piezotact spectrum`: the PSD of one channel.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::spectrum::{Averaging, EstimateError, WelchConfig, welch};
use serde_json::json;

use super::{outputs, read};
use crate::cli::Spectrum;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, print, print_or_write, say_doubts, write_text};
use crate::report::{figures, name};

pub(crate) fn run(args: &Spectrum) -> Outcome {
    let written: Vec<&Path> = args
        .out
        .iter()
        .chain(&args.svg)
        .map(PathBuf::as_path)
        .collect();
    outputs(&[&args.file], &written)?;
    let contents = read(&args.file, &args.reading)?;
    let recording = &contents.recording;
    let (channel, series) = recording.raw(args.channel.as_deref()).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(args.file.display().to_string()))
    })?;
    let config = WelchConfig {
        window: args.window,
        overlap: args.overlap,
        averaging: if args.median {
            Averaging::Median
        } else {
            Averaging::Mean
        },
        ..WelchConfig::hann(args.segment)
    };
    let psd = welch(&series, &config).map_err(|error| match error {
        EstimateError::Config { .. } => usage(error),
        _ => Failure::Data(anyhow!("{}: {error}", args.file.display())),
    })?;
    let unit = channel.unit.of_psd();
    let doubts: Vec<_> = recording
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
            "rate_hz": recording.rate(),
            "resolution_hz": psd.resolution_hz,
            "averages": psd.averages,
            "config": psd.config,
            "frequency_hz": frequencies_hz,
            "psd": psd.values,
            "doubts": doubts_json(&doubts)?,
        });
        return print_or_write(args.out.as_deref(), &serde_json::to_string_pretty(&value)?);
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
            args.segment,
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
         the whole spectrum: --json, --csv or --svg OUT",
        args.file.display(),
        channel.name,
        psd.averages,
        args.segment,
        psd.resolution_hz,
    ))
}
