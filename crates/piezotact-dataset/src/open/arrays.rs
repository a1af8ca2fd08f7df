//! Arrays of numbers in memory, as a recording.

use std::path::Path;

use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::roles::is_torque_unit;

use super::finite::finite;
use super::{Contents, FileKind, contents_of};
use crate::error::ReadError;
use crate::sidecar::{measure_or_unit, require_unit};

/// Units that messages name.
const KNOWN_UNITS: &str = "m/s2, mm/s2, g, mg, N, mN, V, mV, uV, Pa, m, mm, um, m/s, mm/s, rad/s, s, Nm, counts, or 1 for full scale";
/// The unit of samples as a converter gives them.
const COUNTS: &str = "counts";
/// How a recording calls the unit of a channel without one.
const NO_UNIT: &str = "no unit";

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
/// [`ReadError`] without channels, of channels that differ in length or share a name, of a unit that is not known, of an amount of
/// a unit that is no positive decimal number, and of a sample that is NaN or infinite.
pub fn recording_of_arrays(
    name: &Path,
    channels: Vec<ArrayChannel>,
    rate: SampleRate,
    condition: Condition,
) -> Result<Contents, ReadError> {
    let channels = channels.into_iter().map(|channel| in_si(name, channel));
    let channels = channels.collect::<Result<_, _>>()?;
    let provenance = Provenance {
        source: name.display().to_string(),
        ..Provenance::default()
    };
    let recording = Recording::new(channels, rate, condition, provenance);
    let recording = recording.map_err(ReadError::of(name))?;
    finite(name, contents_of(recording.into(), FileKind::ARRAYS))
}

fn in_si(name: &Path, channel: ArrayChannel) -> Result<Channel, ReadError> {
    let text = channel.unit.as_deref().map_or("", str::trim);
    let (unit, factor) = match text {
        "" | NO_UNIT => (Unit::Other(String::new()), 1.0),
        text => known_unit(name, &channel.name, text)?,
    };
    let mut samples = channel.samples;
    // A factor of 1 leaves them as they are.
    if factor != 1.0 {
        samples.iter_mut().for_each(|value| *value *= factor);
    }
    Ok(Channel {
        name: channel.name,
        unit,
        samples,
    })
}

/// The unit and factor of a text such as `N` or `2 N`. A file states the units of all that a sensor gives, and an unknown one is kept; the
/// unit of an array is stated for what is computed, and an unknown one is a mistake.
fn known_unit(name: &Path, channel: &str, text: &str) -> Result<(Unit, f64), ReadError> {
    require_unit(name, channel, text)?;
    let (unit, factor) = measure_or_unit(text);
    let is_kept = is_torque_unit(&unit) || text == COUNTS;
    if matches!(unit, Unit::Other(_)) && !is_kept {
        return Err(ReadError::content(
            name,
            format!("for `{channel}` one of the units {KNOWN_UNITS}"),
            format!("`{text}`"),
            "state `no unit` where it is another",
        ));
    }
    Ok((unit, factor))
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
            ("tz", Some("Nm"), &[3.0, 4.0]),
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
            ("Nm", 4.0),
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
            (
                &[("a", Some("bananas"), &[1.0][..])],
                "for `a` one of the units m/s2, mm/s2, g,",
            ),
            (
                &[("a", Some("2 bananas"), &[1.0][..])],
                "found `2 bananas`; state `no unit` where it is another",
            ),
            (&[("a", None, &[1.0][..]), ("b", None, &[1.0, 2.0])], "`b`"),
            (&[("a", None, &[1.0][..]), ("a", None, &[1.0])], "`a`"),
        ] {
            let error = of(channels).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn units_that_messages_name_are_known() {
        for text in KNOWN_UNITS
            .split([',', ' '])
            .filter(|word| !["", "or", "for", "full", "scale"].contains(word))
        {
            let recording = of(&[("a", Some(text), &[1.0])]).unwrap().recording;
            let unit = &recording.channels()[0].unit;
            assert!(
                !matches!(unit, Unit::Other(_)) || ["Nm", COUNTS].contains(&text),
                "{text}"
            );
        }
    }

    #[test]
    fn units_of_a_recording_can_be_stated_again() {
        let recording = of(&[("a", Some("no unit"), &[1.0])]).unwrap().recording;
        assert_eq!(recording.channels()[0].unit, Unit::Other(String::new()));
    }
}
