//! Recordings, drives and textures as the commands read them.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::integrity::warnings_of;
use piezotact::quantity::{Acceleration, Measure, Quantity, QuantityError, SampleRate, Unit};
use piezotact::recording::{Recording, RecordingError};
use piezotact::score::sliding_part;
use piezotact::series::Series;
use piezotact_dataset::{Contents, ReadOptions, is_time_unit, read_recording};

use crate::calls;
use crate::cli::Reading;
use crate::failure::{Failure, Outcome, usage};
use crate::memory::reading_fits;

/// A rate given in Hz on the command line.
pub(crate) fn rate_option(rate_hz: Option<f64>) -> Result<Option<SampleRate>, Failure> {
    rate_hz
        .map(SampleRate::new)
        .transpose()
        .map_err(usage::<QuantityError>)
}

pub(crate) fn read(path: &Path, reading: &Reading) -> Outcome<Contents> {
    inspected(path, &options_of(reading)?)
}

/// The recording in `path` beside the one that `reading` is for: its `own` scale counts, or else that of `reading` where it holds no
/// acceleration without it.
pub(crate) fn read_beside(
    path: &Path,
    own: Option<&Measure>,
    reading: &Reading,
) -> Outcome<Contents> {
    let of_both = options_of(reading)?;
    let with = |scale: Option<Measure>| {
        let options = ReadOptions {
            scale,
            ..of_both.clone()
        };
        inspected(path, &options)
    };
    if own.is_some() {
        return with(own.cloned());
    }
    let as_it_is = with(None)?;
    let mut channels = as_it_is.recording.channels().iter();
    let is_scaled = channels.any(|channel| channel.unit == Acceleration::UNIT);
    match &of_both.scale {
        Some(scale) if !is_scaled => with(Some(scale.clone())),
        _ => Ok(as_it_is),
    }
}

/// As [`read`], for what inspects the channels itself.
pub(crate) fn read_uninspected(path: &Path, reading: &Reading) -> Outcome<Contents> {
    opened(path, &options_of(reading)?)
}

/// The recording that is given by the name `path`, else the one in that file.
fn opened(path: &Path, options: &ReadOptions) -> Outcome<Contents> {
    if let Some(given) = calls::given(path) {
        return as_given(path, given, options);
    }
    reading_fits(path)?;
    Ok(read_recording(path, options)?)
}

/// A recording that is given has its units: a scale or a part that is stated of files would be left out silently.
fn as_given(path: &Path, given: Contents, options: &ReadOptions) -> Outcome<Contents> {
    let is_stated = options.scale.is_some() || !options.units.is_empty();
    let mut channels = given.recording.channels().iter();
    let plain = channels.find(|channel| match &channel.unit {
        Unit::FullScale => !options.is_drive,
        Unit::Other(text) => text.is_empty(),
        _ => false,
    });
    match plain {
        Some(channel) if is_stated => Err(usage(anyhow!(
            "{}: expected the unit of `{}` with its samples, found --scale, which is of files; state the unit where the recording is made",
            path.display(),
            channel.name
        ))),
        _ if options.part.is_some() => Err(usage(anyhow!(
            "{}: expected a file for --part, found a recording in memory; state the part where it is read",
            path.display()
        ))),
        _ => Ok(given),
    }
}

/// What a person states of the scale of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Scale {
    /// What 1 stands for in all channels without a unit.
    All(Measure),
    /// The unit of a channel, or what 1 in it stands for.
    Of { channel: String, unit: String },
}

impl FromStr for Scale {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let Some((channel, unit)) = text.rsplit_once('=') else {
            return text.parse().map(Self::All);
        };
        let (channel, unit) = (channel.trim(), unit.trim());
        let is_known = !matches!(Unit::parse(unit).0, Unit::Other(_)) || is_time_unit(unit);
        if channel.is_empty() || !(is_known || unit.parse::<Measure>().is_ok()) {
            return Err(QuantityError::Measure { found: text.into() });
        }
        Ok(Self::Of {
            channel: channel.into(),
            unit: unit.into(),
        })
    }
}

impl Reading {
    /// What 1 stands for in all channels without a unit.
    pub(crate) fn scale(&self) -> Option<&Measure> {
        let mut all = self.scale.iter().rev();
        all.find_map(|scale| match scale {
            Scale::All(measure) => Some(measure),
            Scale::Of { .. } => None,
        })
    }

    /// The same with another scale of all channels.
    pub(crate) fn with_scale(&self, scale: Option<Measure>) -> Self {
        let each = self
            .scale
            .iter()
            .filter(|scale| !matches!(scale, Scale::All(_)));
        Self {
            scale: each.cloned().chain(scale.map(Scale::All)).collect(),
            rate: self.rate,
            part: self.part,
        }
    }

    /// The units of single channels.
    fn units(&self) -> BTreeMap<String, String> {
        let each = self.scale.iter().filter_map(|scale| match scale {
            Scale::All(_) => None,
            Scale::Of { channel, unit } => Some((channel.clone(), unit.clone())),
        });
        each.collect()
    }
}

pub(crate) fn options_of(reading: &Reading) -> Outcome<ReadOptions> {
    Ok(ReadOptions {
        scale: reading.scale().cloned(),
        units: reading.units(),
        rate: rate_option(reading.rate)?,
        part: reading.part,
        ..ReadOptions::default()
    })
}

/// The recording in a file, with the warnings about what broke on its way to the file.
pub(crate) fn inspected(path: &Path, options: &ReadOptions) -> Outcome<Contents> {
    let mut contents = opened(path, options)?;
    let found = warnings_of(&contents.recording, drive_limit(contents.setup.as_ref()));
    contents.recording.about.add_warnings(found);
    Ok(contents)
}

/// A drive: its file was written by a program, so that nothing broke on the way to it, and full scale is its unit.
pub(crate) fn read_drive(path: &Path) -> Outcome<Contents> {
    let options = ReadOptions {
        is_drive: true,
        ..ReadOptions::default()
    };
    opened(path, &options)
}

/// The largest drive that the device plays, of full scale: full scale where it is not known.
pub(crate) fn drive_limit(setup: Option<&DriveSetup>) -> f64 {
    setup.map_or(1.0, DriveSetup::drive_limit)
}

/// The texture in a recording, in m/s²; when its scale is not known, what to do about it.
pub(crate) fn texture(
    path: &Path,
    recording: &Recording,
    channel: Option<&str>,
) -> Outcome<Series<Acceleration>> {
    let found = recording.series::<Acceleration>(channel);
    found.map_err(|error| no_texture(path, error))
}

/// As [`texture`], of a recording of touch its strokes alone; `signal` is what it is called in the warning that says so.
pub(crate) fn sliding(
    path: &Path,
    signal: &str,
    recording: &Recording,
    channel: Option<&str>,
) -> Outcome<(Series<Acceleration>, Option<Warning>)> {
    let found = sliding_part(signal, recording, channel);
    found.map_err(|error| no_texture(path, error))
}

fn no_texture(path: &Path, error: RecordingError) -> Failure {
    let text = path.display();
    match &error {
        RecordingError::Unit {
            found: Unit::FullScale,
            ..
        } => Failure::Data(anyhow!(
            "{text}: expected a physical scale, found none (full scale = 1); give it with --scale \"200 m/s2\" or in {text}.json"
        )),
        _ => Failure::Data(anyhow::Error::new(error).context(text.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_that_of_all_channels_or_of_one() {
        let reading = Reading {
            scale: ["2 g", "fz=N", "a=b=2 mN", "200 m/s2", "Time=d"]
                .map(|text| text.parse::<Scale>().unwrap())
                .into(),
            rate: None,
            part: None,
        };
        assert_eq!(
            reading.scale().map(ToString::to_string).as_deref(),
            Some("200 m/s²")
        );
        let units: Vec<(String, String)> = reading.units().into_iter().collect();
        let units: Vec<String> = units
            .iter()
            .map(|(of, unit)| format!("{of}: {unit}"))
            .collect();
        assert_eq!(units, ["Time: d", "a=b: 2 mN", "fz: N"]);
        assert_eq!(reading.with_scale(None).scale(), None);
        for wrong in ["fz=", "=N", "fz=banana", "fz=-1 N", "N"] {
            assert!(wrong.parse::<Scale>().is_err(), "{wrong}");
        }
    }
}
