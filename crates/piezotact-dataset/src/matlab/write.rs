//! Writes a transfer function as a MATLAB file of version 5, which every MATLAB, Octave and SciPy loads.

use std::io::Write as _;
use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::WriteError;
use crate::transfer_file::checked_step_hz;
use crate::transfer_json::TransferDocument;

/// Writes a transfer function as a MATLAB file, whole or not at all: `frequency_hz`, `H` (complex) and `coherence` as
/// columns, `rate_hz`, `averages`, `estimator`, `drive_unit`, `response_unit`, and where they are known `participant`,
/// `load_n` and `angle_deg`. `description` holds the rest as JSON: device, provenance, warnings.
///
/// # Errors
/// [`WriteError`] when it cannot be written, or the columns do not fit each other or the format.
pub fn write_mat(path: &Path, document: &TransferDocument) -> Result<(), WriteError> {
    checked_step_hz(path, document)?;
    let longest = u32::MAX as usize / 32;
    if document.frequency_hz.len() > longest {
        return Err(WriteError::content(
            path,
            format!("at most {longest} lines"),
            format!("{}", document.frequency_hz.len()),
            "write JSON",
        ));
    }
    let rest = TransferDocument {
        frequency_hz: Vec::new(),
        real: Vec::new(),
        imaginary: Vec::new(),
        coherence: Vec::new(),
        confidence: None,
        ..document.clone()
    };
    let description = serde_json::to_string(&rest).map_err(|error| WriteError::Io {
        path: path.into(),
        source: error.into(),
    })?;
    let estimator = document.estimator.to_string();
    let mut bytes = header();
    numbers(&mut bytes, "frequency_hz", &document.frequency_hz, None);
    numbers(&mut bytes, "H", &document.real, Some(&document.imaginary));
    if !document.coherence.is_empty() {
        numbers(&mut bytes, "coherence", &document.coherence, None);
    }
    let condition = &document.about.condition;
    let scalars = [
        ("rate_hz", document.rate_hz.map(|rate| rate.hz())),
        ("averages", Some(document.averages as f64)),
        ("load_n", condition.load_n.map(|load| load.0)),
        ("angle_deg", condition.angle_deg.map(|angle| angle.0)),
    ];
    for (name, value) in scalars {
        if let Some(value) = value {
            numbers(&mut bytes, name, &[value], None);
        }
    }
    if let Some(confidence) = &document.confidence {
        let high: Vec<f64> = confidence
            .high
            .iter()
            .map(|h| h.unwrap_or(f64::INFINITY))
            .collect();
        numbers(&mut bytes, "magnitude_low", &confidence.low, None);
        numbers(&mut bytes, "magnitude_high", &high, None);
        numbers(
            &mut bytes,
            "phase_reach_rad",
            &confidence.phase_reach_rad,
            None,
        );
    }
    let texts = [
        ("estimator", Some(estimator.as_str())),
        ("drive_unit", Some(document.drive_unit.symbol())),
        ("response_unit", Some(document.response_unit.symbol())),
        ("participant", condition.participant.as_deref()),
        ("description", Some(&description)),
    ];
    for (name, value) in texts {
        if let Some(value) = value {
            text(&mut bytes, name, value);
        }
    }
    write_atomically(path, |out| {
        out.write_all(&bytes).map_err(WriteError::io(path))
    })
}

/// 116 bytes of text, 8 without meaning, the version, and the order of bytes.
fn header() -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, written by piezotact".to_vec();
    bytes.resize(116, b' ');
    bytes.resize(124, 0);
    bytes.extend([0x00, 0x01]);
    bytes.extend(b"IM");
    bytes
}

/// An element: its tag, its data, and zeros up to 8 bytes.
fn element(into: &mut Vec<u8>, kind: u32, data: &[u8]) {
    into.extend(kind.to_le_bytes());
    into.extend((data.len() as u32).to_le_bytes());
    into.extend(data);
    into.resize(into.len().next_multiple_of(8), 0);
}

/// Flags, dimensions and name: how every array begins.
fn array(flags: u32, rows: usize, columns: usize, name: &str) -> Vec<u8> {
    let mut array = Vec::new();
    let mut words = flags.to_le_bytes().to_vec();
    words.extend([0; 4]);
    element(&mut array, 6, &words);
    let mut dims = (rows as u32).to_le_bytes().to_vec();
    dims.extend((columns as u32).to_le_bytes());
    element(&mut array, 5, &dims);
    element(&mut array, 1, name.as_bytes());
    array
}

fn numbers(into: &mut Vec<u8>, name: &str, real: &[f64], imaginary: Option<&[f64]>) {
    let flags = 6 | if imaginary.is_some() { 0x800 } else { 0 };
    let mut whole = array(flags, real.len(), 1, name);
    for part in std::iter::once(real).chain(imaginary) {
        let bytes: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
        element(&mut whole, 9, &bytes);
    }
    element(into, 14, &whole);
}

/// A row of characters as UTF-16; marked as plain uint16, SciPy would take them for bytes of the system. Letters that
/// need two units are counted once by SciPy and twice by MATLAB: text with them goes in as UTF-8, as SciPy writes it.
fn text(into: &mut Vec<u8>, name: &str, value: &str) {
    let units: Vec<u16> = value.encode_utf16().collect();
    let letters = value.chars().count();
    let mut whole = array(4, usize::from(letters > 0), letters, name);
    if letters == units.len() {
        let bytes: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        element(&mut whole, 17, &bytes);
    } else {
        element(&mut whole, 16, value.as_bytes());
    }
    element(into, 14, &whole);
}
