//! From the variables of a MATLAB file to recordings and transfer functions.

use piezotact::recording::RecordingWarning;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{Degrees, Newtons, SampleRate, Unit};
use piezotact::recording::Recording;
use piezotact::transfer::{Estimator, StoredIdentities};

use super::stored;
use super::{MatFile, MatNumbers, MatValue};
use crate::columns::{Column, WithoutUnit, recording_of as table_of};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::time_column::{TimeBase, base_beside, base_of, choose_base};
use crate::transfer_file::{Lines, from_lines};
use crate::transfer_json::TransferDocument;

/// Names of vectors of time, of rates, and of their inverse; of the columns of a transfer function. All in small
/// letters.
const TIMES: [&str; 7] = [
    "t",
    "time",
    "time_s",
    "timestamp",
    "zeit",
    "temps",
    "time_domain",
];
const RATES: [&str; 13] = [
    "fs",
    "sr",
    "rate",
    "rate_hz",
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
const STEPS: [&str; 3] = ["dt", "delta_t", "time_step"];
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
/// More columns than this make a matrix that is no recording.
const MOST_CHANNELS: usize = 512;

/// The variables, those of structures named `structure.field`.
fn flat(file: &MatFile) -> Vec<(String, &MatValue)> {
    let mut found = Vec::new();
    let mut open: Vec<(String, &MatValue)> = file
        .variables
        .iter()
        .rev()
        .map(|variable| (variable.name.clone(), &variable.value))
        .collect();
    while let Some((name, value)) = open.pop() {
        match value {
            MatValue::Struct {
                dims,
                class: None,
                fields,
                values,
            } if super::count(dims) == Some(1) => {
                for (field, value) in fields.iter().zip(values).rev() {
                    open.push((format!("{name}.{field}"), value));
                }
            }
            _ => found.push((name, value)),
        }
    }
    found
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

fn shape(value: &MatValue) -> String {
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
        MatValue::Unreadable(what) => what.clone(),
    }
}

fn listed(variables: &[(String, &MatValue)]) -> String {
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

/// The numbers of a file as the channels of a recording.
pub(crate) fn recording_of(
    path: &Path,
    file: &MatFile,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let variables = flat(file);
    let mut warnings = Vec::new();
    let time = variables.iter().find_map(|(name, value)| {
        let values = value.vector().filter(|values| values.len() > 1)?;
        is_called(name, &TIMES).then(|| Column {
            name: name.clone(),
            unit: None,
            values: values.to_vec(),
        })
    });
    let mut columns = Vec::new();
    let mut about = Vec::new();
    for (name, value) in &variables {
        if let MatValue::Numbers(numbers) = value
            && !is_called(name, &TIMES)
        {
            if !numbers.exact {
                about.push(Warning::from(RecordingWarning::Guessed {
                    what: format!("`{name}` holds integers beyond ±2⁵³, which were rounded"),
                }));
            }
            columns.extend(columns_of(name, numbers));
        }
    }
    let length = match &time {
        Some(time) => time.values.len(),
        None => one_length(path, &columns)?,
    };
    let before = columns.len();
    let mut left_out = Vec::new();
    columns.retain(|column| {
        let fits = column.values.len() == length;
        if !fits {
            left_out.push(column.name.clone());
        }
        fits
    });
    if columns.is_empty() {
        return Err(ReadError::content(
            path,
            "vectors of real numbers, all of one length, as channels",
            listed(&variables),
            "save the channels as vectors with a rate `fs` or a time `t`, or export them as CSV with a header",
        ));
    }
    if before > columns.len() {
        left_out.truncate(6);
        about.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "{} vectors are not as long as the time ({length}) and were left out: {}",
                before - columns.len(),
                left_out.join(", ")
            ),
        }));
    }
    let scalar = scalar_rate(path, &variables)?;
    let found = match (&time, scalar) {
        (Some(time), Some((name, rate))) => {
            let stated = (name.as_str(), rate);
            Some(Ok(base_beside(path, time, stated, &mut warnings)))
        }
        (Some(time), None) => Some(base_of(path, time, &mut warnings)),
        (None, Some((_, rate))) => Some(Ok(TimeBase::even(rate))),
        (None, None) => None,
    };
    if options.rate.is_none() && found.is_none() {
        return Err(ReadError::content(
            path,
            "a rate: a number named fs, rate or sampling_rate, or a vector named t or time",
            listed(&variables),
            "give the rate with --rate, for example --rate 5000",
        ));
    }
    let base = choose_base(path, options.rate, found, &mut warnings)?;
    warnings.append(&mut about);
    table_of(
        path,
        columns,
        &base,
        warnings,
        options,
        WithoutUnit::OnlyScale { counts: &[] },
    )
}

/// A vector as one column, a matrix as one for each of its shorter dimension.
fn columns_of(name: &str, numbers: &MatNumbers) -> Vec<Column> {
    if numbers.imaginary.is_some() || numbers.real.len() < 2 {
        return Vec::new();
    }
    let column = |name, values| Column {
        name,
        unit: None,
        values,
    };
    if numbers.is_vector() {
        return vec![column(name.to_owned(), numbers.real.clone())];
    }
    let &[rows, columns] = numbers.dims.as_slice() else {
        return Vec::new();
    };
    if rows.min(columns) > MOST_CHANNELS {
        return Vec::new();
    }
    if rows >= columns {
        let parts = numbers.real.chunks_exact(rows).enumerate();
        parts
            .map(|(k, values)| column(format!("{name} {}", k + 1), values.to_vec()))
            .collect()
    } else {
        (0..rows)
            .map(|k| {
                let values = numbers.real.iter().skip(k).step_by(rows).copied().collect();
                column(format!("{name} {}", k + 1), values)
            })
            .collect()
    }
}

/// The length that all columns share.
fn one_length(path: &Path, columns: &[Column]) -> Result<usize, ReadError> {
    let length = columns.first().map_or(0, |column| column.values.len());
    match columns.iter().find(|column| column.values.len() != length) {
        None => Ok(length),
        Some(other) => Err(ReadError::content(
            path,
            "vectors of one length as channels, or a vector `t` or `time` whose length selects the channels",
            format!(
                "`{}` with {length} and `{}` with {} numbers",
                columns.first().map_or("", |column| &column.name),
                other.name,
                other.values.len()
            ),
            "save the channels that were recorded together in a separate file",
        )),
    }
}

fn scalar_rate(
    path: &Path,
    variables: &[(String, &MatValue)],
) -> Result<Option<(String, SampleRate)>, ReadError> {
    let scalar = |names: &[&str]| {
        variables.iter().find_map(|(name, value)| {
            let value = value.scalar().filter(|_| is_called(name, names))?;
            Some((name.clone(), value))
        })
    };
    let found = scalar(&RATES).or_else(|| scalar(&STEPS).map(|(name, step)| (name, 1.0 / step)));
    found
        .map(|(name, hz)| {
            SampleRate::new(hz)
                .map(|rate| (name, rate))
                .map_err(ReadError::of(path))
        })
        .transpose()
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

fn holds_response(variables: &[(String, &MatValue)]) -> bool {
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
