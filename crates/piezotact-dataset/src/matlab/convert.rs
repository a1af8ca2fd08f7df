//! The variables of a MATLAB file by their names, and from them to transfer functions.

use piezotact::recording::RecordingWarning;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{Degrees, Newtons, SampleRate, Unit};
use piezotact::transfer::{Estimator, StoredIdentities};

use super::signals::TIMES;
use super::{MatFile, MatNumbers, MatValue};
use super::{stored, units};
use crate::error::ReadError;
use crate::transfer_file::{Lines, from_lines};
use crate::transfer_json::TransferDocument;

/// Names of the columns of a transfer function, in small letters.
const FREQUENCIES: [&str; 7] = [
    "frequency_hz",
    "f",
    "freq",
    "frequency",
    "frequencies",
    "f_hz",
    "freq_domain",
];
const COHERENCES: [&str; 5] = ["coherence", "coh", "gamma2", "cxy", "c"];
/// Arrays of more elements or cells are not taken apart.
const MOST_ELEMENTS: usize = 4096;

/// The variables; those of structures are named `structure.field`, of arrays `structures(2).field` and `cells{2}`. A structure with
/// `Name` and `Value` (a property, as converters of TDMS write them) is a variable of that name.
pub(super) fn flat(file: &MatFile) -> Vec<(String, &MatValue)> {
    let mut found = Vec::new();
    let mut open: Vec<(String, &MatValue)> = file
        .variables
        .iter()
        .rev()
        // What has no name is MATLAB's own.
        .filter(|variable| !variable.name.is_empty())
        .map(|variable| (variable.name.clone(), &variable.value))
        .collect();
    while let Some((name, value)) = open.pop() {
        match value {
            MatValue::Struct {
                class: None,
                fields,
                values,
                ..
            } if !fields.is_empty() && values.len() / fields.len() <= MOST_ELEMENTS => {
                let elements = values.chunks_exact(fields.len());
                let one = elements.len() == 1;
                for (k, element) in elements.enumerate().rev() {
                    let place = match one {
                        true => name.clone(),
                        false => format!("{name}({})", k + 1),
                    };
                    if let Some((property, value)) = property_of(fields, element) {
                        let around = name.rsplit_once('.').map_or("", |(around, _)| around);
                        let dot = if around.is_empty() { "" } else { "." };
                        open.push((format!("{around}{dot}{property}"), value));
                    } else {
                        for (field, value) in fields.iter().zip(element).rev() {
                            open.push((format!("{place}.{field}"), value));
                        }
                    }
                }
            }
            MatValue::Cell { values, .. }
                if (1..=MOST_ELEMENTS).contains(&values.len())
                    && !values
                        .iter()
                        .all(|value| matches!(value, MatValue::Text(_)))
                    // A list of texts may have places without one.
                    && units::texts_of(value).is_none() =>
            {
                for (k, value) in values.iter().enumerate().rev() {
                    open.push((format!("{name}{{{}}}", k + 1), value));
                }
            }
            _ => found.push((name, value)),
        }
    }
    found
}

/// The name and the value of a structure that holds nothing else.
fn property_of<'m>(fields: &[String], element: &'m [MatValue]) -> Option<(&'m str, &'m MatValue)> {
    let [name, value] = element else { return None };
    let named = |at: usize, called: &str| {
        fields
            .get(at)
            .is_some_and(|f| f.eq_ignore_ascii_case(called))
    };
    let is_property = named(0, "name") && named(1, "value") && value.scalar().is_some();
    name.text()
        .filter(|_| is_property)
        .map(|name| (name, value))
}

fn is_called(name: &str, names: &[&str]) -> bool {
    let last = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    names.contains(&last.as_str())
}

fn by_name<'a>(
    variables: &[(String, &'a MatValue)],
    names: &[&str],
) -> Option<(String, &'a MatValue)> {
    // The order of `names` decides, then that of the file.
    names.iter().find_map(|wanted| {
        variables
            .iter()
            .find(|(name, _)| is_called(name, &[wanted]))
            .map(|(name, value)| (name.clone(), *value))
    })
}

pub(super) fn shape(value: &MatValue) -> String {
    let by = |dims: &[usize]| {
        let dims: Vec<String> = dims.iter().take(4).map(usize::to_string).collect();
        dims.join("×")
    };
    match value {
        MatValue::Numbers(MatNumbers {
            dims, imaginary, ..
        }) => {
            let complex = if imaginary.is_some() { " complex" } else { "" };
            format!("{}{complex}", by(dims))
        }
        MatValue::Text(_) => "text".into(),
        MatValue::Cell { dims, .. } => format!("{} cells", by(dims)),
        MatValue::Struct { dims, .. } => format!("{} structures", by(dims)),
        MatValue::Sparse { rows, columns, .. } => format!("{rows}×{columns} sparse"),
        MatValue::Object(Some(class)) => format!("an object of the class {class}"),
        MatValue::Object(None) => "an object of a class".into(),
        MatValue::Unreadable(what) => what.clone(),
    }
}

pub(super) fn listed(variables: &[(String, &MatValue)]) -> String {
    if variables.is_empty() {
        return "no variables".into();
    }
    let mut named: Vec<String> = variables
        .iter()
        .take(12)
        .map(|(name, value)| format!("{name} ({})", shape(value)))
        .collect();
    if variables.len() > named.len() {
        named.push(format!("{} more", variables.len() - named.len()));
    }
    named.join(", ")
}

/// Whether a file holds a frequency response with its frequencies, and no time signals.
pub(crate) fn holds_transfer(file: &MatFile) -> bool {
    let variables = flat(file);
    holds_response(&variables) && !holds_time_signals(&variables)
}

/// Whether a file holds a frequency response with its frequencies, and time signals.
pub(crate) fn holds_both(file: &MatFile) -> bool {
    let variables = flat(file);
    holds_response(&variables) && holds_time_signals(&variables)
}

pub(super) fn holds_response(variables: &[(String, &MatValue)]) -> bool {
    !stored::responses(variables).is_empty() && by_name(variables, &FREQUENCIES).is_some()
}

/// A vector of times, and another of that length.
fn holds_time_signals(variables: &[(String, &MatValue)]) -> bool {
    let length = |value: &MatValue| value.vector().map(<[f64]>::len).filter(|len| *len > 1);
    let time = variables.iter().find_map(|(name, value)| {
        let length = length(value)?;
        is_called(name, &TIMES).then_some(length)
    });
    time.is_some_and(|time| {
        (variables.iter())
            .any(|(name, value)| length(value) == Some(time) && !is_called(name, &TIMES))
    })
}

/// The unit that `text` names, and what 1 of it is in SI units.
fn unit_of(text: Option<&str>) -> (Unit, f64) {
    let (unit, si) = Unit::parse(text.unwrap_or("").trim_end());
    match unit.symbol() {
        "no unit" => (Unit::Other(String::new()), si),
        _ => (unit, si),
    }
}

/// The frequency response of a file, with its coherence.
pub(crate) fn transfer_of(path: &Path, file: MatFile) -> Result<TransferDocument, ReadError> {
    let variables = flat(&file);
    let real = |names: &[&str]| {
        by_name(&variables, names).and_then(|(_, value)| value.vector().map(<[f64]>::to_vec))
    };
    let responses = stored::responses(&variables);
    let (Some(found), Some(frequency_hz)) = (responses.first(), real(&FREQUENCIES)) else {
        return Err(ReadError::content(
            path,
            "a complex vector `H` (or FRF, H1, Hf, TF, Hf_chan_2) and its frequencies `f` (or freq, frequency_hz)",
            listed(&variables),
            "use these variable names and save with -v7, or write the transfer function as a universal file",
        ));
    };
    let (mut response, stored_coherence) = (found.values.clone(), found.coherence(&variables));
    let coherence = stored_coherence.or_else(|| real(&COHERENCES));
    let text = |name: &str| by_name(&variables, &[name]).and_then(|(_, value)| value.text());
    let number = |name: &str| by_name(&variables, &[name]).and_then(|(_, value)| value.scalar());
    let [(drive_unit, drive_si), (response_unit, response_si)] =
        ["drive_unit", "response_unit"].map(|name| unit_of(text(name)));
    let factor = f64::powi(drive_si, -1) * response_si;
    for line in &mut response {
        *line *= factor;
    }
    let mut warnings = Vec::new();
    if let [first, _, ..] = responses.as_slice() {
        let names: Vec<&str> = responses.iter().map(|r| r.name.as_str()).collect();
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the file holds {} transfer functions ({}): `{}` is read",
                names.len(),
                names.join(", "),
                first.name
            ),
        }));
    }
    // What only our own files hold: everything but the columns, as JSON.
    let own = text("description").filter(|text| text.starts_with("{\"drive_unit\":"));
    let described: Option<TransferDocument> =
        own.map(serde_json::from_str).transpose().map_err(|error| {
            ReadError::content(
                path,
                "the description that this program writes with a transfer function",
                error.to_string(),
                "estimate the transfer function again",
            )
        })?;
    if let Some(described) = &described {
        warnings.clone_from(&described.about.warnings);
    }
    let identities = found.identities(&variables, &frequency_hz);
    warnings.extend(identities.as_ref().and_then(StoredIdentities::warning));
    let impact = described.as_ref().and_then(|own| own.impact.clone());
    let one_hit = impact.as_ref().is_some_and(|test| test.used() == 1);
    let lines = Lines {
        frequency_hz,
        response,
        // One hit has no coherence, which nobody forgot.
        coherence: coherence.or_else(|| one_hit.then(|| vec![0.0; found.values.len()])),
    };
    let mut document = from_lines(path, lines, warnings)?;
    if one_hit {
        document.coherence.clear();
    }
    if let Some(identities) = &identities {
        document.estimator = identities.estimator;
    }
    document.identities = identities;
    document.impact = impact;
    if let Some(described) = described {
        document.about.condition = described.about.condition;
        document.drive = described.drive;
        document.about.provenance = described.about.provenance;
        document.effective_averages = described.effective_averages;
        document.excited_hz = described.excited_hz;
        document.known_input = described.known_input;
        document.distortion = described.distortion;
        document.attempts = described.attempts;
    }
    document.response_unit = response_unit;
    document.drive_unit = drive_unit;
    if let Some(estimator) = text("estimator").and_then(Estimator::named) {
        document.estimator = estimator;
    }
    document.averages = number("averages")
        .filter(|count| (0.0..1e12).contains(count))
        .map_or(0, |count| count as usize);
    document.rate_hz = number("rate_hz").and_then(|hz| SampleRate::new(hz).ok());
    if let Some(name) = text("participant").filter(|name| !name.is_empty()) {
        document.about.condition.participant = Some(name.to_owned());
    }
    if let Some(load) = number("load_n") {
        document.about.condition.load_n = Some(Newtons(load));
    }
    if let Some(angle) = number("angle_deg") {
        document.about.condition.angle_deg = Some(Degrees(angle));
    }
    Ok(document)
}
