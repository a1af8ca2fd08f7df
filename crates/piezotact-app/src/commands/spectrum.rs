//! `piezotact spectrum`: the PSD of one channel, as a whole and over time, and the noise of a sensor at rest.

mod rest;

use anyhow::anyhow;
use piezotact::quantity::{Hertz, SampleRate, Uncalibrated, Unit};
use piezotact::recording::RecordingError;
use piezotact::spectrum::{
    Averaging, Cells, EstimateError, SpectrogramConfig, SpectrogramInBlocks, SpectrumDocument,
    WelchConfig, WelchInBlocks, spectrogram, welch,
};

use crate::cli::Spectrum;
use crate::deliver::deliver;
use crate::failure::{Failure, Outcome, usage};
use crate::large::{LARGE_BYTES, Large};
use crate::places::outputs;
use crate::reading::read;

pub(crate) fn run(args: &Spectrum) -> Outcome {
    if args.rest {
        return rest::run(args);
    }
    if args.over_time && args.outputs.report.is_none() && !args.outputs.json {
        return Err(usage(anyhow!(
            "--over-time needs --report or --json: give one of them, or leave --over-time out"
        )));
    }
    outputs(&[&args.file], &args.outputs.files())?;
    // The median needs all segments at once.
    if !args.median
        && let Some(large) = Large::open(&args.file, &args.reading, LARGE_BYTES)?
    {
        return of_large(args, &large);
    }
    let contents = read(&args.file, &args.reading)?;
    let recording = &contents.recording;
    let in_file = |error| in_file(args, error);
    let (channel, series) = recording.raw(args.channel.as_deref()).map_err(in_file)?;
    let psd = welch(&series, &config(args)).map_err(|error| refused(args, error))?;
    let mut document = SpectrumDocument::of(&psd, (recording, channel), &args.file);
    if args.over_time {
        let over_time = spectrogram(&series, &config_over_time(args, series.rate()));
        document.over_time = Some(over_time.map_err(|error| refused(args, error))?);
    }
    deliver(&args.outputs, &document)
}

/// As [`run`], of a recording that is read part by part.
fn of_large(args: &Spectrum, large: &Large) -> Outcome {
    let empty = &large.contents().recording;
    let channel = empty.pick(args.channel.as_deref(), &Unit::MetrePerSecondSquared);
    let channel = channel.map_err(|error| in_file(args, error))?;
    let refused = |error| refused(args, error);
    let mut sums = WelchInBlocks::new(&config(args), empty.rate()).map_err(refused)?;
    let over_time = args.over_time.then(|| {
        let config = config_over_time(args, empty.rate());
        SpectrogramInBlocks::new(&config, empty.rate(), large.samples())
    });
    let mut cells = over_time.transpose().map_err(refused)?;
    let contents = large.inspected(|part| {
        let own = part.pick(Some(&channel.name), &channel.unit);
        let samples = &own.map_err(|error| in_file(args, error))?.samples;
        sums.add(samples);
        if let Some(cells) = &mut cells {
            cells.add(samples);
        }
        Ok(())
    })?;
    let psd = sums.spectrum::<Uncalibrated>().map_err(refused)?;
    let mut document = SpectrumDocument::of(&psd, (&contents.recording, channel), &args.file);
    document.over_time = cells.map(SpectrogramInBlocks::spectrogram);
    deliver(&args.outputs, &document)
}

fn in_file(args: &Spectrum, error: RecordingError) -> Failure {
    Failure::Data(anyhow::Error::new(error).context(args.file.display().to_string()))
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

/// The highest frequency over time unless another is stated: what fingers feel.
const HIGHEST: Hertz = Hertz(1000.0);

fn config_over_time(args: &Spectrum, rate: SampleRate) -> SpectrogramConfig {
    let usual = SpectrogramConfig::usual(rate);
    let highest = Hertz(rate.nyquist().0.min(HIGHEST.0));
    SpectrogramConfig {
        window: args.window,
        segment: args.segment.unwrap_or(usual.segment),
        overlap: args.overlap.unwrap_or(usual.overlap),
        cells: Cells::of_a_figure(args.max_frequency.map_or(highest, Hertz)),
        ..usual
    }
}
