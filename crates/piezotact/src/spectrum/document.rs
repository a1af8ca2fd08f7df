//! The PSD of a channel as it is handed out.

use std::path::Path;

use serde::Serialize;

use super::{Spectrum, WelchConfig};
use crate::document::Content;
use crate::figure::Spectrograms;
use crate::quantity::{Quantity, SampleRate};
use crate::recording::{BenchKind, Channel, Recording};
use crate::warning::{Merged, merged};

/// The PSD of one channel of a file, with its frequencies and the rate of the channel, which the spectrum alone does not hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpectrumDocument<'a> {
    /// The file.
    pub file: &'a Path,
    /// The channel.
    pub channel: &'a str,
    /// The unit of the values.
    pub unit: String,
    /// The rate of the channel, Hz.
    pub rate_hz: SampleRate,
    /// The distance of two lines, Hz.
    pub resolution_hz: f64,
    /// How many segments were averaged.
    pub averages: usize,
    /// How it was estimated.
    pub config: &'a WelchConfig,
    /// The frequencies of the lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// The PSD of each line, in `unit`.
    pub psd: &'a [f64],
    /// What limits it.
    pub warnings: Vec<Merged>,
    /// The strongest line above 0 Hz: its frequency in Hz and its PSD.
    #[serde(skip)]
    pub strongest: (f64, f64),
    /// The bench of the recording; absent where it does not state one.
    #[serde(skip)]
    pub bench: Option<BenchKind>,
    /// The PSD over time; absent where it was not asked for.
    #[serde(skip)]
    pub over_time: Option<Spectrograms>,
}

impl Content for SpectrumDocument<'_> {
    const SCHEMA: &'static str = "spectrum";
}

impl<'a> SpectrumDocument<'a> {
    /// The PSD `psd` of `channel`, a channel of the recording in `file`.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of<Q: Quantity>(
        psd: &'a Spectrum<Q>,
        (recording, channel): (&Recording, &'a Channel),
        file: &'a Path,
    ) -> Self {
        Self {
            file,
            channel: &channel.name,
            unit: channel.unit.of_psd(),
            rate_hz: recording.clock_of(&channel.name).rate_hz,
            resolution_hz: psd.resolution_hz,
            averages: psd.averages,
            config: &psd.config,
            frequency_hz: psd.frequencies_hz(),
            psd: &psd.values,
            warnings: merged(recording.about.warnings.iter().chain(&psd.warnings)),
            strongest: psd.strongest(),
            bench: recording.about.provenance.bench,
            over_time: None,
        }
    }
}
