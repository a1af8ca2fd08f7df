//! One door for transfer functions in files: JSON, universal files, and MATLAB's.

use piezotact::recording::RecordingWarning;
use std::path::Path;

use num_complex::Complex;
use piezotact::Warning;
use piezotact::quantity::Unit;
use piezotact::recording::{About, Provenance};
use piezotact::transfer::Estimator;

use crate::error::{ReadError, WriteError};
use crate::format::{self, Format, Opened, Recognition};
use crate::haptic::{haptic_kind_of_file, is_called_haptic};
use crate::matlab;
use crate::transfer_json::{TransferDocument, parse_json};
use crate::uff::{self, UffEncoding};
use crate::version::Versioned;

/// The files that a transfer function can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferFormat {
    /// Readable JSON, which holds everything.
    Json,
    /// A universal file of text.
    UffText,
    /// A universal file of binary numbers.
    UffBinary,
    /// A MATLAB file (version 5).
    Matlab,
}

impl TransferFormat {
    /// What a file of this format cannot hold of a transfer function, for whoever writes one.
    #[must_use]
    pub fn losses(self) -> Option<Warning> {
        match self {
            Self::UffText | Self::UffBinary => Some(Warning::from(RecordingWarning::FormatLoses {
                format: "a universal file".into(),
                what: "the device, the provenance, the excited band, whether the drive was exact, the hits and the added damping of an impact test, and the warnings of a transfer function".into(),
            })),
            Self::Json | Self::Matlab => None,
        }
    }

    /// What the ending of `path` asks for: `.uff` and `.unv` universal text, `.mat` MATLAB, and everything else JSON.
    #[must_use]
    pub fn of_ending(path: &Path) -> Self {
        format::of_ending(&TRANSFERS, path).map_or(Self::Json, |format| format.kind)
    }
}

/// What reads transfer functions of one format.
struct Reader {
    /// The transfer function in a file.
    read: fn(&Path, &[u8]) -> Result<TransferDocument, ReadError>,
    /// Whether a file holds one rather than a recording.
    holds: fn(&mut Opened<'_>) -> Result<bool, ReadError>,
}

/// The formats of transfer functions, in the order in which they are looked for.
static TRANSFERS: [Format<TransferFormat, Reader>; 3] = [
    Format {
        kind: TransferFormat::UffText,
        label: "UFF",
        endings: &["uff", "unv"],
        sniff: Recognition::Head(uff::looks_like_uff),
        read: Reader {
            read: |path, bytes| uff::transfer_of(path, &uff::parse_uff(path, bytes)?),
            holds: |file| {
                let path = file.path;
                Ok(uff::holds_transfer(&uff::parse_uff(path, file.bytes()?)?))
            },
        },
    },
    Format {
        kind: TransferFormat::Matlab,
        label: "MAT",
        endings: &["mat"],
        sniff: Recognition::Head(matlab::looks_like_mat),
        read: Reader {
            read: |path, bytes| matlab::transfer_of(path, matlab::parse_mat(path, bytes)?),
            holds: |file| {
                let path = file.path;
                Ok(matlab::holds_transfer(&matlab::parse_mat(
                    path,
                    &file.take_bytes()?,
                )?))
            },
        },
    },
    // What is nothing else is read as JSON, which says what is wrong with it: this row stays the last one.
    Format {
        kind: TransferFormat::Json,
        label: "JSON",
        endings: &["json"],
        sniff: Recognition::Head(|_| true),
        read: Reader {
            read: parse_json,
            holds: |file| {
                Ok(file.head().first() == Some(&b'{')
                    && haptic_kind_of_file(file.path).is_none()
                    && !is_called_haptic(file.path, file.head()))
            },
        },
    },
];

/// The formats of transfer functions that can be read, for people: `UFF, MAT, JSON`.
#[must_use]
pub fn transfer_formats() -> String {
    format::list(&TRANSFERS, ", ")
}

/// Reads a transfer function from JSON, from a universal file (function type 4, with the coherence of type 6 between
/// the same points), or from a MATLAB file (our variables, or `H` or `FRF` with `f` or `freq`). Its content says which
/// it is. A coherence that is missing is taken as 1, with a warning.
///
/// # Errors
/// [`ReadError::Io`] when it cannot be read, [`ReadError::Content`] when it is something else, holds several, or its
/// lines are uneven or begin far above 0 Hz.
pub fn read_transfer(path: &Path) -> Result<TransferDocument, ReadError> {
    let bytes = crate::input::read_input(path)?;
    let document = match format::recognise_bytes(&TRANSFERS, path, &bytes) {
        Some(format) => (format.read.read)(path, &bytes)?,
        None => parse_json(path, &bytes)?,
    };
    if document.about.lacks_twin_seed() {
        return Err(ReadError::content(
            path,
            "the seed of the digital twin beside its participant (condition.twin_seed)",
            "none there",
            "make it again with this version: participants of one number and two seeds are two people",
        ));
    }
    Ok(document)
}

/// The transfer function that an analyser stored beside the time signals in the file at `path`; `None` where there is none,
/// nothing else ([`holds_transfer`]), or no file of this name, as of a recording that was ended before it was complete.
///
/// # Errors
/// As [`read_transfer`].
pub fn stored_transfer(path: &Path) -> Result<Option<TransferDocument>, ReadError> {
    if !path.is_file() {
        return Ok(None);
    }
    let mut file = Opened::open(path)?;
    match format::recognise(&TRANSFERS, &mut file)? {
        Some(format) if matches!(format.kind, TransferFormat::Matlab) => {
            let file = matlab::parse_mat(path, &file.take_bytes()?)?;
            if matlab::holds_both(&file) {
                matlab::transfer_of(path, file).map(Some)
            } else {
                Ok(None)
            }
        }
        _ => Ok(None),
    }
}

/// Whether the file at `path` holds a transfer function and no recording, by its content; `false` for what cannot be read.
#[must_use]
pub fn holds_transfer(path: &Path) -> bool {
    // A long recording is not read for this: its first bytes say that it is none.
    let holds = || -> Result<bool, ReadError> {
        let mut file = Opened::open(path)?;
        match format::recognise(&TRANSFERS, &mut file)? {
            Some(format) => (format.read.holds)(&mut file),
            None => Ok(false),
        }
    };
    holds().unwrap_or(false)
}

/// Writes a transfer function, whole or not at all, as what the ending of `path` says: `.uff` or `.unv` a universal
/// file of text, `.mat` a MATLAB file, anything else JSON.
///
/// # Errors
/// [`WriteError`] when it cannot be written.
pub fn write_transfer(path: &Path, document: &TransferDocument) -> Result<(), WriteError> {
    write_transfer_as(path, document, TransferFormat::of_ending(path))
}

/// Writes a transfer function, whole or not at all, as `format`.
///
/// # Errors
/// [`WriteError`] when it cannot be written, or the format cannot hold it.
pub fn write_transfer_as(
    path: &Path,
    document: &TransferDocument,
    format: TransferFormat,
) -> Result<(), WriteError> {
    match format {
        TransferFormat::Json => crate::sidecar::write_json(path, &Versioned::of(document)),
        TransferFormat::UffText => uff::write_uff(path, document, UffEncoding::Text),
        TransferFormat::UffBinary => uff::write_uff(path, document, UffEncoding::Binary),
        TransferFormat::Matlab => matlab::write_mat(path, document),
    }
}

/// The step of a document whose columns fit each other, Hz.
pub(crate) fn checked_step_hz(path: &Path, document: &TransferDocument) -> Result<f64, WriteError> {
    let wrong = |expected: String, found: String| {
        WriteError::content(
            path,
            expected,
            found,
            "estimate the transfer function again",
        )
    };
    let lines = document.frequency_hz.len();
    let lengths = [
        document.real.len(),
        document.imaginary.len(),
        // One hit, or one segment, has no coherence.
        match document.coherence.len() {
            0 if document.impact.is_some() || document.averages == 1 => lines,
            found => found,
        },
    ];
    if lines < 2 || lengths.iter().any(|length| *length != lines) {
        return Err(wrong(
            "two lines or more, and as many values in every column".into(),
            format!("{lines} frequencies, {lengths:?} values"),
        ));
    }
    let last = document.frequency_hz[lines - 1];
    let step_hz = last / (lines - 1) as f64;
    let even = |(k, f): (usize, &f64)| (f - k as f64 * step_hz).abs() <= 1e-3 * step_hz;
    if !(step_hz > 0.0 && last.is_finite() && document.frequency_hz.iter().enumerate().all(even)) {
        return Err(wrong(
            "equally spaced frequencies from 0 Hz".into(),
            format!("{} to {last} Hz", document.frequency_hz[0]),
        ));
    }
    let columns = [&document.real, &document.imaginary, &document.coherence];
    if let Some(value) = columns
        .into_iter()
        .flatten()
        .find(|value| !value.is_finite())
    {
        return Err(wrong("numbers".into(), value.to_string()));
    }
    Ok(step_hz)
}

/// The lines of a transfer function that another program wrote.
pub(crate) struct Lines {
    pub(crate) frequency_hz: Vec<f64>,
    pub(crate) response: Vec<Complex<f64>>,
    pub(crate) coherence: Option<Vec<f64>>,
}

/// A document of `lines`, from 0 Hz on: what is missing below the first line is filled with zeros that nothing vouches
/// for, a missing coherence with ones, and both are said.
pub(crate) fn from_lines(
    path: &Path,
    lines: Lines,
    mut warnings: Vec<Warning>,
) -> Result<TransferDocument, ReadError> {
    let Lines {
        mut frequency_hz,
        mut response,
        coherence,
    } = lines;
    let count = frequency_hz.len();
    if count < 2 || response.len() != count {
        return Err(ReadError::content(
            path,
            "two lines or more, with a frequency for each",
            format!("{count} frequencies, {} lines", response.len()),
            "export the complete transfer function",
        ));
    }
    let step = even_step_hz(path, &frequency_hz)?;
    let (first, last) = (frequency_hz[0], frequency_hz[count - 1]);
    let mut coherence = coherence_or_one(coherence, count, &mut warnings);
    let below = (first / step).round();
    if (first - below * step).abs() > 1e-2 * step || below < 0.0 || below > count as f64 {
        return Err(ReadError::content(
            path,
            "frequency lines from 0 Hz, or from a low multiple of their spacing",
            format!("from {first} Hz in steps of {step} Hz"),
            "export it from 0 Hz",
        ));
    }
    // At most `count`: the check above says so.
    let below = below as usize;
    if below > 0 {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the frequency lines below {first} Hz are not in the file: they are set to 0, with coherence 0"
            ),
        }));
        let step = last / (below + count - 1) as f64;
        frequency_hz = (0..below + count).map(|k| k as f64 * step).collect();
        response.splice(..0, std::iter::repeat_n(Complex::default(), below));
        coherence.splice(..0, std::iter::repeat_n(0.0, below));
    }
    Ok(TransferDocument {
        drive_unit: Unit::Other(String::new()),
        response_unit: Unit::Other(String::new()),
        estimator: Estimator::H1,
        known_input: false,
        averages: 0,
        effective_averages: None,
        excited_hz: None,
        rate_hz: None,
        about: About {
            provenance: Provenance {
                source: path.display().to_string(),
                ..Provenance::default()
            },
            warnings,
            ..About::default()
        },
        drive: None,
        frequency_hz,
        real: response.iter().map(|h| h.re).collect(),
        imaginary: response.iter().map(|h| h.im).collect(),
        coherence,
        impact: None,
        confidence: None,
        identities: None,
        attempts: Vec::new(),
        distortion: None,
        measured_for: None,
    })
}

/// The step of at least two `frequency_hz`, which has to be the same everywhere.
fn even_step_hz(path: &Path, frequency_hz: &[f64]) -> Result<f64, ReadError> {
    if let Some(bad) = frequency_hz.iter().find(|f| !f.is_finite()) {
        return Err(ReadError::content(
            path,
            "frequencies",
            format!("{bad}"),
            "export the transfer function again",
        ));
    }
    let (first, last) = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let step = (last - first) / (frequency_hz.len() - 1) as f64;
    let mut axis = frequency_hz.iter().enumerate();
    let uneven = if step > 0.0 {
        axis.find(|(k, f)| (**f - first - *k as f64 * step).abs() > 1e-3 * step)
    } else {
        axis.next_back()
    };
    if let Some((k, found)) = uneven {
        return Err(ReadError::content(
            path,
            format!("frequencies equally spaced by {step} Hz"),
            format!("{found} Hz in line {k}"),
            "export the transfer function on a uniform axis",
        ));
    }
    Ok(step)
}

/// `coherence` where it has `count` lines; a warning and 1 everywhere where it has not.
fn coherence_or_one(
    coherence: Option<Vec<f64>>,
    count: usize,
    warnings: &mut Vec<Warning>,
) -> Vec<f64> {
    match coherence {
        Some(coherence) if coherence.len() == count => coherence,
        other => {
            let why = other.map_or_else(
                || "the file holds no coherence".into(),
                |found| {
                    format!(
                        "the coherence has {} frequency lines instead of {count} and is not used",
                        found.len()
                    )
                },
            );
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "{why}: it is assumed to be 1 everywhere, and the reliability of the transfer function is unknown"
                ),
            }));
            vec![1.0; count]
        }
    }
}
