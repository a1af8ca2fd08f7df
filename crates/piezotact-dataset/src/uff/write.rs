//! Writes a transfer function as two functions of dataset 58: the frequency response and its coherence.

use std::io::Write;
use std::path::Path;

use piezotact::quantity::Unit;

use crate::atomic::write_atomically;
use crate::error::WriteError;
use crate::transfer_file::checked_step_hz;
use crate::transfer_json::TransferDocument;

/// The fifth id line of what is written here: the others can then be read back.
pub(super) const OWN: &str = "piezotact transfer function";

/// How numbers stand in a universal file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UffEncoding {
    /// Dataset 58: text, 13 digits.
    Text,
    /// Dataset 58b: doubles, little endian.
    Binary,
}

/// Writes a transfer function as a universal file, whole or not at all: a frequency response (function type 4,
/// complex double) and its coherence (type 6), both of node 1 over node 2 in no stated direction. The id lines hold
/// estimator, averages, rate, load, angle and participant; the device and the warnings stay behind.
///
/// # Errors
/// [`WriteError`] when it cannot be written, a column does not fit the others, or a name is longer than the format
/// holds.
pub fn write_uff(
    path: &Path,
    document: &TransferDocument,
    encoding: UffEncoding,
) -> Result<(), WriteError> {
    let step_hz = checked_step_hz(path, document)?;
    let response: Vec<f64> = document
        .real
        .iter()
        .zip(&document.imaginary)
        .flat_map(|(re, im)| [*re, *im])
        .collect();
    let id_lines = id_lines(path, document)?;
    let (over, of) = (
        axis(path, &document.drive_unit, "Drive")?,
        axis(path, &document.response_unit, "Response")?,
    );
    let none = format!("{:10}{:5}{:5}{:5} {:20} {:20}", 0, 0, 0, 0, "NONE", "NONE");
    let frequency = format!(
        "{:10}{:5}{:5}{:5} {:20} {:20}",
        18, 0, 0, 0, "Frequency", "Hz"
    );
    write_atomically(path, |out| {
        let mut put = |kind: u8, data_type: u8, axes: [&str; 2], values: &[f64]| {
            let per_point = if data_type == 6 { 2 } else { 1 };
            let points = values.len() / per_point;
            let mut text = format!("{:6}{:74}\n", -1, "");
            text.push_str(&match encoding {
                UffEncoding::Text => format!("{:6}{:74}\n", 58, ""),
                UffEncoding::Binary => format!(
                    "{:6}b{:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}\n",
                    58,
                    1,
                    2,
                    11,
                    8 * values.len(),
                    0,
                    0,
                    0,
                    0
                ),
            });
            for id in &id_lines {
                text.push_str(&format!("{id:80}\n"));
            }
            text.push_str(&format!(
                "{kind:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}\n",
                0, 0, 0, "RESPONSE", 1, 0, "DRIVE", 2, 0
            ));
            text.push_str(&format!(
                "{data_type:10}{points:10}{:10}{}{}{}\n",
                1,
                scientific(0.0, 13, 5),
                scientific(step_hz, 13, 6),
                scientific(0.0, 13, 5)
            ));
            for axis in [frequency.as_str(), axes[0], axes[1], none.as_str()] {
                text.push_str(axis);
                text.push('\n');
            }
            out.write_all(text.as_bytes())?;
            match encoding {
                UffEncoding::Text => {
                    for row in values.chunks(4) {
                        let mut text: String =
                            row.iter().map(|value| scientific(*value, 20, 12)).collect();
                        text.push('\n');
                        out.write_all(text.as_bytes())?;
                    }
                }
                UffEncoding::Binary => {
                    for value in values {
                        out.write_all(&value.to_le_bytes())?;
                    }
                }
            }
            out.write_all(format!("{:6}{:74}\n", -1, "").as_bytes())
        };
        put(4, 6, [&of, &over], &response).map_err(WriteError::io(path))?;
        if document.coherence.is_empty() {
            return Ok(());
        }
        put(6, 4, [&none, &none], &document.coherence).map_err(WriteError::io(path))
    })
}

/// The id lines: estimator, averages and rate, the condition, and that the file is of this program.
fn id_lines(path: &Path, document: &TransferDocument) -> Result<[String; 5], WriteError> {
    let mut first = format!(
        "estimator={}; averages={}",
        document.estimator, document.averages
    );
    if let Some(rate) = document.rate_hz {
        first.push_str(&format!("; rate_hz={}", rate.hz()));
    }
    let condition = &document.about.condition;
    let mut parts = Vec::new();
    parts.extend(condition.load_n.map(|load| format!("load_n={}", load.0)));
    parts.extend(
        condition
            .angle_deg
            .map(|angle| format!("angle_deg={}", angle.0)),
    );
    parts.extend(
        condition
            .participant
            .as_ref()
            .map(|name| format!("participant={name}")),
    );
    let second = if parts.is_empty() {
        "NONE".into()
    } else {
        parts.join("; ")
    };
    Ok([
        line(path, &first, PARTICIPANT)?,
        line(path, &second, PARTICIPANT)?,
        "NONE".into(),
        "NONE".into(),
        OWN.into(),
    ])
}

/// What may be too long for an id line of a transfer function.
const PARTICIPANT: &str = "a participant's name, with load and angle";

/// Text of at most 80 bytes on one line.
pub(super) fn line(path: &Path, text: &str, what: &str) -> Result<String, WriteError> {
    if text.len() <= 80 && !text.contains(char::is_control) {
        return Ok(text.to_owned());
    }
    Err(WriteError::content(
        path,
        format!("{what} that fits into a line of 80 characters"),
        format!("`{}`", text.escape_debug()),
        "shorten it, or write JSON or MAT, which hold it",
    ))
}

/// The record of an axis: quantity, label and unit.
pub(super) fn axis(path: &Path, unit: &Unit, label: &str) -> Result<String, WriteError> {
    let (quantity, symbol) = match unit {
        Unit::MetrePerSecondSquared => (12, "m/s^2"),
        Unit::Newton => (13, "N"),
        Unit::Pascal => (15, "Pa"),
        Unit::Metre => (8, "m"),
        Unit::MetrePerSecond => (11, "m/s"),
        Unit::Other(text) if text.is_empty() => (0, "NONE"),
        other => (0, other.symbol()),
    };
    if symbol.len() > 20 || symbol.contains(char::is_control) {
        return Err(WriteError::content(
            path,
            "a unit of at most 20 characters",
            format!("`{}`", symbol.escape_debug()),
            "write JSON or MAT, which hold it",
        ));
    }
    Ok(format!(
        "{quantity:10}{:5}{:5}{:5} {label:20} {symbol:20}",
        0, 0, 0
    ))
}

/// A number as Fortran's `E` writes it, right-aligned: ` 1.234560E-01`.
pub(super) fn scientific(value: f64, width: usize, digits: usize) -> String {
    let plain = format!("{value:.digits$E}");
    let written = match plain.split_once('E') {
        Some((mantissa, exponent)) => {
            let (sign, size) = match exponent.strip_prefix('-') {
                Some(size) => ('-', size),
                None => ('+', exponent),
            };
            format!("{mantissa}E{sign}{size:0>2}")
        }
        None => plain,
    };
    format!("{written:>width$}")
}
