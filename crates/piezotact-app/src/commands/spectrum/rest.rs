//! `piezotact spectrum --rest`: the noise of a sensor at rest.

use anyhow::anyhow;
use piezotact::noise::{NoiseConfig, NoiseError, noise};

use crate::cli::Spectrum;
use crate::deliver::deliver;
use crate::failure::{Failure, Outcome, usage};
use crate::places::outputs;
use crate::reading::read;

pub(super) fn run(args: &Spectrum) -> Outcome {
    outputs(&[&args.file], &args.outputs.files())?;
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
    deliver(&args.outputs, &found)
}
