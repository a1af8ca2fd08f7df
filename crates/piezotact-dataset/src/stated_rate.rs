//! Single numbers in a file that state its rate, such as `fs` or `dt`, and texts beside them that state units.

use std::path::Path;

use piezotact::number::digits;
use piezotact::quantity::Unit;

use crate::error::ReadError;

/// Names of rates and of their inverse, in small letters.
const RATES: [&str; 12] = [
    "fs",
    "sr",
    "rate",
    "sampling_rate",
    "samplingrate",
    "sample_rate",
    "samplerate",
    "sampling_frequency",
    "srate",
    "samplingfrequency",
    "sfreq",
    "time_sample_rate",
];
const STEPS: [&str; 5] = ["dt", "delta_t", "time_step", "wf_increment", "increment"];
/// Units at the ends of such names.
const ENDINGS: [&str; 6] = ["hz", "khz", "s", "ms", "us", "ns"];
pub(crate) const UNIT_WORDS: [&str; 5] = ["unit", "units", "einheit", "unite", "unit_string"];
/// Words in the names of numbers that scale a channel.
const SCALES: [&str; 9] = [
    "sens", "scale", "gain", "calib", "kalib", "factor", "faktor", "mv_per", "v_per",
];
/// Rates that differ by more than this share contradict each other.
const SAME: f64 = 1e-3;

/// `name` without one of `words` among its parts; `None` where it has none or nothing else.
pub(crate) fn without_word(name: &str, words: &[&str]) -> Option<String> {
    let parts: Vec<&str> = name.split('_').collect();
    let at = parts.iter().position(|part| words.contains(part))?;
    let rest: Vec<&str> = [&parts[..at], &parts[at + 1..]].concat();
    (!rest.is_empty()).then(|| rest.join("_"))
}

/// Whether a number of this name may scale a channel.
pub(crate) fn may_be_scale(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    SCALES.iter().any(|word| name.contains(word))
}

/// The kind of a number of this name, and the unit at the end of the name.
fn parts(name: &str) -> Option<(bool, Option<&'static str>)> {
    let name = name.to_ascii_lowercase();
    let is_step = |base: &str| {
        let step = STEPS.contains(&base);
        (step || RATES.contains(&base)).then_some(step)
    };
    let ends = |unit: &'static str| {
        let step = is_step(name.strip_suffix(unit)?.strip_suffix('_')?)?;
        (step != unit.ends_with("hz")).then_some((step, Some(unit)))
    };
    let whole = is_step(&name).map(|step| (step, None));
    whole.or_else(|| ENDINGS.into_iter().find_map(ends))
}

/// Whether a number of this name states the rate.
pub(crate) fn states_rate(name: &str) -> bool {
    parts(name).is_some()
}

/// The rate, Hz, that a number of this name states in `unit`, else in the unit at the end of the name, else in Hz or s.
///
/// # Errors
/// [`ReadError::Content`] where `unit` is none of a rate or a step.
pub(crate) fn hz_of(
    path: &Path,
    name: &str,
    value: f64,
    unit: Option<&str>,
) -> Result<f64, ReadError> {
    let (is_step, own) = parts(name).unwrap_or((false, None));
    let unit = unit.map(str::trim).filter(|unit| !unit.is_empty()).or(own);
    let factor = match (unit, is_step) {
        (None, _) => Some(1.0),
        (Some(unit), true) => match Unit::parse(unit) {
            (Unit::Second, second) => Some(second),
            _ => None,
        },
        (Some(unit), false) => per_second(unit),
    };
    let Some(factor) = factor else {
        return Err(ReadError::content(
            path,
            format!(
                "`{name}` in {}",
                if is_step {
                    "s, ms, µs or ns"
                } else {
                    "Hz or kHz"
                }
            ),
            unit.unwrap_or_default(),
            "correct its unit, or give --rate",
        ));
    };
    Ok(if is_step {
        1.0 / (value * factor)
    } else {
        value * factor
    })
}

/// What 1 in a unit of a rate is in Hz.
pub(crate) fn per_second(unit: &str) -> Option<f64> {
    let plain = unit.to_lowercase().replace(' ', "");
    let samples = ["samples/", "sample/", "abtastungen/", "s/", "1/"];
    let per = samples.iter().find_map(|start| plain.strip_prefix(start));
    match (plain.as_str(), per) {
        ("hz" | "sps" | "hertz", _) | (_, Some("s" | "sec" | "second")) => Some(1.0),
        ("khz" | "ks/s" | "ksps", _) => Some(1e3),
        ("mhz", _) => Some(1e6),
        (_, Some("ms")) => Some(1e3),
        (_, Some("min" | "minute")) => Some(1.0 / 60.0),
        _ => None,
    }
}

/// Whether two rates that a file states are one.
pub(crate) fn is_same_rate(one_hz: f64, other_hz: f64) -> bool {
    (other_hz / one_hz - 1.0).abs() <= SAME
}

/// The first of the rates that a file states in one place, each with its name.
///
/// # Errors
/// [`ReadError::Content`] where another one differs.
pub(crate) fn one_of(
    path: &Path,
    rates: Vec<(String, f64)>,
) -> Result<Option<(String, f64)>, ReadError> {
    let mut rates = rates.into_iter();
    let Some((name, hz)) = rates.next() else {
        return Ok(None);
    };
    match rates.find(|(_, other)| !is_same_rate(hz, *other)) {
        None => Ok(Some((name, hz))),
        Some((other, other_hz)) => Err(ReadError::content(
            path,
            format!("one rate, as `{name}` states {} Hz", digits(hz)),
            format!("{} Hz of `{other}`", digits(other_hz)),
            "correct the one that is wrong, or give --rate",
        )),
    }
}
