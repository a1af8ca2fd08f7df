//! What the twin made, as it is handed out.

use std::path::Path;

use piezotact::document::Content;
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{Condition, Provenance, Recording};
use piezotact::run::RunStart;
use piezotact::surface::HeightMap;
use serde::Serialize;

use crate::{Sample, TwinParameters};

/// What a finger did on a bench of the twin, or the EEG of its person.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TwinRecordDocument<'a> {
    /// The file that holds the recording.
    pub record: &'a Path,
    /// Its rate, Hz.
    pub rate_hz: SampleRate,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Names and units of its channels.
    pub channels: &'a [(String, Unit)],
    /// Who touched what, and how.
    pub condition: &'a Condition,
    /// Where it comes from.
    pub provenance: &'a Provenance,
}

impl Content for TwinRecordDocument<'_> {
    const SCHEMA: &'static str = "twin_record";
}

impl<'a> TwinRecordDocument<'a> {
    /// A run of `samples` samples that began with `start`, kept in the file `record`.
    #[must_use]
    pub fn of(start: &'a RunStart, samples: usize, record: &'a Path) -> Self {
        Self {
            record,
            rate_hz: start.rate_hz,
            duration_s: start.rate_hz.duration_of(samples),
            channels: &start.channels,
            condition: &start.about.condition,
            provenance: &start.about.provenance,
        }
    }

    /// `recording` with its channels' names and units, kept in the file `record`.
    #[must_use]
    pub fn of_recording(
        recording: &'a Recording,
        channels: &'a [(String, Unit)],
        record: &'a Path,
    ) -> Self {
        Self {
            record,
            rate_hz: recording.rate(),
            duration_s: recording.duration(),
            channels,
            condition: &recording.about.condition,
            provenance: &recording.about.provenance,
        }
    }
}

/// The height map of a sample of the twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TwinSurfaceDocument<'a> {
    /// The file that holds the map.
    pub map: &'a Path,
    /// The sample.
    pub sample: &'a str,
    /// Points in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// The distance of two points, m.
    pub step_m: f64,
    /// What it was drawn with.
    pub seed: u64,
    /// The parameters of the twin that were changed.
    pub twin: String,
}

impl Content for TwinSurfaceDocument<'_> {
    const SCHEMA: &'static str = "twin_surface";
}

impl<'a> TwinSurfaceDocument<'a> {
    /// `map` of `sample`, with points `step_m` m apart, drawn with `seed` and kept in the file `out`.
    #[must_use]
    pub fn of(
        map: &HeightMap,
        (sample, parameters): (&'a Sample, &TwinParameters),
        (step_m, seed): (f64, u64),
        out: &'a Path,
    ) -> Self {
        Self {
            map: out,
            sample: &sample.name,
            columns: map.columns(),
            rows: map.rows(),
            step_m,
            seed,
            twin: parameters.provenance(),
        }
    }
}
