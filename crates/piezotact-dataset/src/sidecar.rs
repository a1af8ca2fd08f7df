//! Sidecar files such as `NAME.wav.json` and `NAME.csv.json`, with the metadata that the file beside them cannot hold: the value of full
//! scale or the units, the condition, and for a drive how it was made.
//!
//! The smallest one is `{"full_scale": {"value": 200, "unit": "m/s2"}}`.

mod written;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::quantity::{Measure, Unit};
use piezotact::recording::{About, Annotations};
pub use piezotact::render::Rendering;
use serde::{Deserialize, Serialize};

use crate::atomic::Prepared;
use crate::error::{ReadError, WriteError};
use crate::version::refuse_newer;

/// The sidecar of a WAV file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sidecar {
    /// The physical value of full scale (the number 1).
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "people_write_measures"
    )]
    pub full_scale: Option<Measure>,
    /// The names of the channels, in their order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<String>,
    /// Condition, provenance and warnings of the samples.
    #[serde(flatten, serialize_with = "About::without_empty_warnings")]
    pub about: About,
    /// When it began, its labels, and what happened while it ran.
    #[serde(flatten)]
    pub annotations: Annotations,
    /// How the drive was made, when it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rendering: Option<Rendering>,
}

/// What a sidecar says of the samples beside it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct OfSamples {
    /// The names of the channels, where it has such a list.
    pub(crate) channels: Option<Vec<String>>,
    /// What the number 1 in a channel stands for, by the name of the channel: a unit such as `N`, or a measure such as `2 N`. It counts
    /// before [`Sidecar::full_scale`], and only people write it.
    pub(crate) units: BTreeMap<String, String>,
    /// The fingerprint of the samples that it was written for.
    pub(crate) samples: Option<String>,
    /// The rate of the samples that it was written for, Hz.
    pub(crate) rate_hz: Option<f64>,
}

/// A sidecar as it is written with its samples.
#[derive(Serialize)]
pub(crate) struct Written<'a> {
    #[serde(flatten)]
    pub(crate) sidecar: &'a Sidecar,
    /// A scale beside other samples than these is not believed.
    pub(crate) samples: String,
    /// Nor is a header with another rate, Hz.
    pub(crate) rate_hz: u32,
}

/// A measure as a person writes it: `{"value": 2, "unit": "g"}` or `"2 g"`.
fn people_write_measures<'de, D: serde::Deserializer<'de>>(
    de: D,
) -> Result<Option<Measure>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        Text(String),
        Parts { value: f64, unit: String },
    }
    let text = match Option::<Written>::deserialize(de)? {
        None => return Ok(None),
        Some(Written::Text(text)) => text,
        Some(Written::Parts { value, unit }) => format!("{value} {unit}"),
    };
    text.parse().map(Some).map_err(serde::de::Error::custom)
}

/// Where the sidecar of the WAV file `path` stands: `NAME.wav.json`; so too of any other.
#[must_use]
pub fn sidecar_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// The sidecar of the WAV file `path`, if there is one.
///
/// # Errors
/// [`ReadError::Io`] when it cannot be read, [`ReadError::Content`] when it is no sidecar.
pub fn read_sidecar(path: &Path) -> Result<Option<Sidecar>, ReadError> {
    Ok(read_with_samples(path)?.map(|read| read.sidecar))
}

/// How the drive in the WAV file `path` was rendered; `None` where no sidecar says it, or one that was written for other samples.
#[must_use]
pub fn read_rendering(path: &Path) -> Option<Rendering> {
    of_these_samples(path)?.rendering
}

/// Whether the WAV file `path` has a sidecar that states the checksum of these samples.
#[must_use]
pub fn states_its_samples(path: &Path) -> bool {
    of_these_samples(path).is_some()
}

fn of_these_samples(path: &Path) -> Option<Sidecar> {
    let read = read_with_samples(path).ok().flatten()?;
    let found = crate::wav::fingerprint(path, &crate::reads::read(path).ok()?).ok()?;
    let is_of_these = read.of_samples.samples.as_ref() == Some(&found);
    is_of_these.then_some(read.sidecar)
}

/// A sidecar as it was read.
pub(crate) struct Read {
    pub(crate) sidecar: Sidecar,
    pub(crate) of_samples: OfSamples,
    /// Entries that nothing reads.
    pub(crate) warnings: Vec<Warning>,
}

/// The sidecar of the file `path` with what it says of the samples beside it.
pub(crate) fn read_with_samples(path: &Path) -> Result<Option<Read>, ReadError> {
    let path = sidecar_path(path);
    let text = match crate::reads::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(ReadError::io(&path, &error)),
    };
    refuse_newer(&path, text.as_bytes())?;
    written::check(&path, &text)?;
    let warnings = written::unknown_entries(&path, &text).into_iter().collect();
    let read = || {
        Ok(Read {
            sidecar: serde_json::from_str(&text)?,
            of_samples: serde_json::from_str(&text)?,
            warnings,
        })
    };
    read().map(Some).map_err(|error: serde_json::Error| {
        ReadError::content(&path, written::EXAMPLE, error.to_string(), written::ADVICE)
    })
}

/// Refuses as the unit of `channel` an amount that is no number above zero with a decimal point, such as `0,5 g` or `-1 m/s2`. Any other
/// text is the name of a unit: `1/s`.
pub(crate) fn require_unit(path: &Path, channel: &str, text: &str) -> Result<(), ReadError> {
    let text = text.trim();
    let first = text.split_whitespace().next();
    let number = first.and_then(|word| word.parse::<f64>().ok());
    let is_impossible = number.is_some_and(|value| !(value > 0.0 && value.is_finite()));
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || "+-−.,' ".contains(c));
    let is_amount = unit.len() < text.len() && !matches!(Unit::parse(unit).0, Unit::Other(_));
    let is_measure = text.parse::<Measure>().is_ok();
    if !(is_impossible || is_amount && !is_measure) {
        return Ok(());
    }
    Err(ReadError::content(
        path,
        format!(
            "a unit such as \"N\", or a value above zero with one, such as \"0.5 N\", for `{channel}`"
        ),
        format!("`{text}`"),
        "correct it",
    ))
}

/// The unit and factor of a text such as `N` or `2 N`.
pub(crate) fn measure_or_unit(text: &str) -> (Unit, f64) {
    match text.parse::<Measure>() {
        Ok(measure) => (measure.unit, measure.value),
        Err(_) => Unit::parse(text),
    }
}

/// Writes `value` as readable JSON, whole or not at all.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), WriteError> {
    prepare_json(path, value)?.commit()
}

pub(crate) fn prepare_json(path: &Path, value: &impl Serialize) -> Result<Prepared, WriteError> {
    Prepared::new(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value).map_err(|error| WriteError::Io {
            path: path.into(),
            source: error.into(),
        })?;
        out.write_all(b"\n").map_err(WriteError::io(path))
    })
}

/// JSON on one line, for files that hold a line for each sample otherwise.
#[cfg(feature = "haptic")]
pub(crate) fn prepare_compact_json(
    path: &Path,
    value: &impl Serialize,
) -> Result<Prepared, WriteError> {
    Prepared::new(path, |out| {
        serde_json::to_writer(&mut *out, value).map_err(|error| WriteError::Io {
            path: path.into(),
            source: error.into(),
        })?;
        out.write_all(b"\n").map_err(WriteError::io(path))
    })
}

/// The scale and unit of samples whose full scale is `scale`, or full scale itself when it is not known.
pub(crate) fn unit_and_factor(scale: Option<&Measure>) -> (Unit, f64) {
    scale.map_or((Unit::FullScale, 1.0), |scale| {
        (scale.unit.clone(), scale.value)
    })
}
