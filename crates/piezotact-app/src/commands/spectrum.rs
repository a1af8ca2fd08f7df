//! `piezotact spectrum`: the PSD of one channel, as a whole and over time, and the noise of a sensor at rest.

mod rest;

use anyhow::anyhow;
use piezotact::figure::Spectrograms;
use piezotact::quantity::{Hertz, Uncalibrated};
use piezotact::recording::Channel;
use piezotact::series::Series;
use piezotact::spectrum::{
    Averaging, Cells, EstimateError, SpectrogramConfig, SpectrumDocument, WelchConfig, spectrogram,
    welch,
};

use crate::cli::Spectrum;
use crate::deliver::deliver;
use crate::failure::{Failure, Outcome, usage};
use crate::places::outputs;
use crate::reading::read;
use crate::report::name;

pub(crate) fn run(args: &Spectrum) -> Outcome {
    if args.rest {
        return rest::run(args);
    }
    outputs(&[&args.file], &args.outputs.files())?;
    let contents = read(&args.file, &args.reading)?;
    let recording = &contents.recording;
    let (channel, series) = recording.raw(args.channel.as_deref()).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(args.file.display().to_string()))
    })?;
    let psd = welch(&series, &config(args)).map_err(|error| refused(args, error))?;
    let mut document = SpectrumDocument::of(&psd, (recording, channel), &args.file);
    if args.over_time {
        document.over_time = Some(over_time(args, channel, &series)?);
    }
    deliver(&args.outputs, &document)
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
) -> Outcome<Spectrograms> {
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
    Ok(Spectrograms {
        panels: vec![result.panel(format!("{}, {}", name(&args.file), channel.name))],
        unit: channel.unit.of_psd(),
        note: result.estimate_text(),
    })
}
