//! The PSD of a channel as it is handed out.

use std::path::Path;

use serde::{Serialize, Serializer};

use super::{Spectrogram, SpectrogramConfig, Spectrum, WelchConfig};
use crate::document::Content;
use crate::quantity::{Quantity, SampleRate, Uncalibrated};
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
    /// The PSD over time; absent where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "in_rows")]
    #[cfg_attr(feature = "schemas", schemars(with = "Option<OverTime<'a>>"))]
    pub over_time: Option<Spectrogram<Uncalibrated>>,
    /// What limits it.
    pub warnings: Vec<Merged>,
    /// The strongest line above 0 Hz: its frequency in Hz and its PSD.
    #[serde(skip)]
    pub strongest: (f64, f64),
    /// The bench of the recording; absent where it does not state one.
    #[serde(skip)]
    pub bench: Option<BenchKind>,
}

/// The PSD over time as documents have it: its cells in rows, as a matrix that can be drawn, which a [`Spectrogram`] has column by column.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct OverTime<'a> {
    /// How it was estimated, and which cells are kept.
    config: &'a SpectrogramConfig,
    /// How many segments the channel holds.
    segments: usize,
    /// The segments averaged in a column; the last may hold fewer.
    segments_per_column: usize,
    /// The lines averaged in a row; the last may hold fewer.
    lines_per_row: usize,
    /// The middles of the columns, s from the first sample.
    times_s: &'a [f64],
    /// From one column to the next, s.
    time_step_s: f64,
    /// The middles of the rows, Hz, rising.
    frequencies_hz: &'a [f64],
    /// From one row to the next, Hz.
    frequency_step_hz: f64,
    /// The PSD of each cell, in `unit` of the document: a row for each frequency, in it a value for each time.
    psd: Vec<Vec<f64>>,
}

impl<'a> OverTime<'a> {
    fn of<Q: Quantity>(over_time: &'a Spectrogram<Q>) -> Self {
        let row = |row: usize| over_time.columns().map(|column| column[row]).collect();
        Self {
            config: &over_time.config,
            segments: over_time.segments,
            segments_per_column: over_time.segments_per_column,
            lines_per_row: over_time.lines_per_row,
            times_s: &over_time.times_s,
            time_step_s: over_time.time_step_s,
            frequencies_hz: &over_time.frequencies_hz,
            frequency_step_hz: over_time.frequency_step_hz,
            psd: (0..over_time.frequencies_hz.len()).map(row).collect(),
        }
    }
}

fn in_rows<Q: Quantity, S: Serializer>(
    over_time: &Option<Spectrogram<Q>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let over_time = over_time.as_ref().map(OverTime::of);
    over_time.serialize(serializer)
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
