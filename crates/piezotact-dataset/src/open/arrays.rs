//! Arrays of numbers in memory, as a recording.

use std::path::Path;

use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};

use super::finite::finite;
use super::{Contents, FileKind, contents_of};
use crate::error::ReadError;
use crate::sidecar::{measure_or_unit, require_unit};

/// A channel as an array holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrayChannel {
    pub name: String,
    /// Its unit, or what 1 in it stands for: `N`, `200 m/s2`; `1` for full scale; absent where nobody states it.
    pub unit: Option<String>,
    pub samples: Vec<f64>,
}

/// The recording of `channels` sampled at `rate`, in SI; errors call it `name`.
///
/// # Errors
/// [`ReadError`] without channels, of channels that differ in length or share a name, of an amount of a unit that is no positive
/// decimal number, and of a sample that is NaN or infinite.
pub fn recording_of_arrays(
    name: &Path,
    channels: Vec<ArrayChannel>,
    rate: SampleRate,
    condition: Condition,
) -> Result<Contents, ReadError> {
    for channel in &channels {
        if let Some(unit) = &channel.unit {
            require_unit(name, &channel.name, unit)?;
        }
    }
    let channels = channels.into_iter().map(in_si).collect();
    let provenance = Provenance {
        source: name.display().to_string(),
        ..Provenance::default()
    };
    let recording = Recording::new(channels, rate, condition, provenance);
    let recording = recording.map_err(ReadError::of(name))?;
    finite(name, contents_of(recording.into(), FileKind::ARRAYS))
}

fn in_si(channel: ArrayChannel) -> Channel {
    let text = channel.unit.as_deref();
    let (unit, factor) = text.map_or((Unit::Other(String::new()), 1.0), measure_or_unit);
    let mut samples = channel.samples;
    // A factor of 1 leaves them as they are.
    if factor != 1.0 {
        samples.iter_mut().for_each(|value| *value *= factor);
    }
    Channel {
        name: channel.name,
        unit,
        samples,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(channels: &[(&str, Option<&str>, &[f64])]) -> Result<Contents, ReadError> {
        let channel = |(name, unit, samples): &(&str, Option<&str>, &[f64])| ArrayChannel {
            name: (*name).to_owned(),
            unit: unit.map(str::to_owned),
            samples: samples.to_vec(),
        };
        let rate = SampleRate::new(5000.0).unwrap();
        let channels = channels.iter().map(channel).collect();
        recording_of_arrays(Path::new("array"), channels, rate, Condition::default())
    }

    #[test]
    fn arrays_are_in_si_with_the_unit_that_is_stated() {
        let channels: [(&str, Option<&str>, &[f64]); 6] = [
            ("acc", Some("g"), &[1.0, 2.0]),
            ("fz", Some("2 mN"), &[1.0, 2.0]),
            ("drive", Some("1"), &[0.5, -0.5]),
            ("x", None, &[3.0, 4.0]),
            ("a", Some("cm/s2"), &[3.0, 5.0]),
            ("n", Some("1/s"), &[3.0, 4.0]),
        ];
        let recording = of(&channels).unwrap().recording;
        let found = recording.channels().iter();
        let found: Vec<(String, f64)> = found
            .map(|channel| (channel.unit.to_string(), channel.samples[1]))
            .collect();
        let expected = [
            ("m/s²", 19.6133),
            ("N", 0.004),
            ("FS", -0.5),
            ("no unit", 4.0),
            ("m/s²", 0.05),
            ("1/s", 4.0),
        ];
        assert_eq!(
            found,
            expected.map(|(unit, value)| (unit.to_owned(), value))
        );
        assert_eq!(recording.about.provenance.source, "array");
    }

    #[test]
    fn arrays_that_make_no_recording_are_refused_with_what_was_found() {
        for (channels, expected) in [
            (
                &[("a", None, &[1.0, f64::NAN][..])][..],
                "found NaN at sample 1",
            ),
            (&[("a", None, &[][..])], "expected samples, found none"),
            (&[], "channel"),
            (
                &[("a", Some("0,5 g"), &[1.0][..])],
                "above zero with one, such as \"0.5 N\", for `a`, found `0,5 g`",
            ),
            (&[("a", Some("-1 m/s2"), &[1.0][..])], "found `-1 m/s2`"),
            (&[("a", None, &[1.0][..]), ("b", None, &[1.0, 2.0])], "`b`"),
            (&[("a", None, &[1.0][..]), ("a", None, &[1.0])], "`a`"),
        ] {
            let error = of(channels).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
