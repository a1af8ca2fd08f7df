//! MATLAB files of version 4, of version 5 (which MATLAB calls 5, 6 and 7), and with the feature `hdf5` of version 7.3.
//!
//! Source of the layout: The MathWorks, *MAT-File Format*. Without the feature, version 7.3 is refused by name. What a file
//! claims is checked against the bytes it has before anything is reserved: a damaged file is an error, never a panic.

mod convert;
mod recording;
mod signals;
mod stored;
mod units;
mod v4;
mod v5;
#[cfg(feature = "hdf5")]
mod v73;
mod write;

use std::path::Path;

pub use write::write_mat;

pub(crate) use convert::{holds_both, holds_transfer, transfer_of};
pub(crate) use recording::recording_of;

use crate::error::ReadError;

/// What is unpacked or spread out of one file at most, in bytes and in numbers.
const LARGEST: usize = 1 << 30;
const MOST_NUMBERS: usize = 1 << 27;

/// The class of an array of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberClass {
    /// `double`.
    Double,
    /// `single`.
    Single,
    /// `int8` to `int64`, with its bits.
    Int(u8),
    /// `uint8` to `uint64`, with its bits.
    Uint(u8),
    /// `logical`.
    Logical,
}

/// Numbers in the order of the file: down the first dimension first.
#[derive(Clone, Debug, PartialEq)]
pub struct MatNumbers {
    /// The length in every dimension.
    pub dims: Vec<usize>,
    /// What they were in MATLAB.
    pub class: NumberClass,
    /// Their values, or real parts.
    pub real: Vec<f64>,
    /// Their imaginary parts, of complex ones.
    pub imaginary: Option<Vec<f64>>,
    /// Whether every value is the one in the file; not so for integers of 64 bits beyond ±2⁵³.
    pub exact: bool,
}

/// One entry of a sparse matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatEntry {
    /// The row, from 0.
    pub row: usize,
    /// The column, from 0.
    pub column: usize,
    /// The value, or its real part.
    pub real: f64,
    pub imaginary: f64,
}

/// A value in a MATLAB file.
#[derive(Clone, Debug, PartialEq)]
pub enum MatValue {
    /// Numbers, logical ones too.
    Numbers(MatNumbers),
    /// Text, one string for each row.
    Text(Vec<String>),
    /// Cells, down the first dimension first.
    Cell {
        /// The length in every dimension.
        dims: Vec<usize>,
        values: Vec<Self>,
    },
    /// A structure or an array of them; an object of the old kind too.
    Struct {
        /// The length in every dimension.
        dims: Vec<usize>,
        /// The class, of an object.
        class: Option<String>,
        /// The names of the fields.
        fields: Vec<String>,
        /// The fields of the first element, then those of the next.
        values: Vec<Self>,
    },
    /// A sparse matrix: what is not listed is 0.
    Sparse {
        rows: usize,
        columns: usize,
        /// What is not 0.
        entries: Vec<MatEntry>,
    },
    /// An object of a class, such as a table, which only MATLAB understands; its class, where the file names it.
    Object(Option<String>),
    /// Something else that only MATLAB understands; its kind is named.
    Unreadable(String),
}

impl MatValue {
    /// The numbers of a vector or scalar, when it holds real ones.
    #[must_use]
    pub fn vector(&self) -> Option<&[f64]> {
        match self {
            Self::Numbers(numbers) if numbers.is_vector() && numbers.imaginary.is_none() => {
                Some(&numbers.real)
            }
            _ => None,
        }
    }

    /// The number of a real scalar.
    #[must_use]
    pub fn scalar(&self) -> Option<f64> {
        match self.vector()? {
            [only] => Some(*only),
            _ => None,
        }
    }

    /// The text of a single row.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(rows) => match rows.as_slice() {
                [] => Some(""),
                [only] => Some(only),
                _ => None,
            },
            _ => None,
        }
    }
}

impl MatNumbers {
    /// Whether at most one dimension is longer than 1.
    #[must_use]
    pub fn is_vector(&self) -> bool {
        self.dims.iter().filter(|length| **length > 1).count() <= 1
    }
}

/// A variable with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MatVariable {
    /// The name; empty for what MATLAB keeps for itself.
    pub name: String,
    pub value: MatValue,
}

/// The variables of a file, in its order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MatFile {
    pub variables: Vec<MatVariable>,
}

impl MatFile {
    /// The variable of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&MatValue> {
        self.variables
            .iter()
            .find(|variable| variable.name == name)
            .map(|variable| &variable.value)
    }
}

/// Whether `bytes` begin as a MATLAB file does, of any version.
#[must_use]
pub fn looks_like_mat(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB")
        || is_hdf5(bytes)
        || v5::order(bytes).is_some()
        || v4::looks_like(bytes)
}

fn is_hdf5(bytes: &[u8]) -> bool {
    const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
    bytes.starts_with(SIGNATURE)
        || bytes
            .get(512..)
            .is_some_and(|rest| rest.starts_with(SIGNATURE))
}

/// Reads every variable of a MATLAB file.
///
/// # Errors
/// [`ReadError::Content`] when it is no MATLAB file, one of version 7.3 without the feature `hdf5`, or damaged: it says where and what to do.
pub fn parse_mat(path: &Path, bytes: &[u8]) -> Result<MatFile, ReadError> {
    let source = Source { path };
    let newer = v5::version(bytes) == Some(2);
    if is_hdf5(bytes) || newer || bytes.starts_with(b"MATLAB 7.3 MAT-file") {
        #[cfg(feature = "hdf5")]
        return v73::read(&source, bytes);
        #[cfg(not(feature = "hdf5"))]
        return Err(ReadError::content(
            path,
            "a MATLAB file of version 7 or older",
            "one of version 7.3 (HDF5), which this build does not read",
            "build piezotact with ./x build, or save it in MATLAB with the option -v7: save('file.mat', '-v7')",
        ));
    }
    if let Some(order) = v5::order(bytes) {
        v5::read(&source, bytes, order)
    } else if v4::looks_like(bytes) {
        v4::read(&source, bytes)
    } else {
        Err(source.wrong(
            "a MATLAB file with its header of 128 bytes",
            "a MATLAB file that is cut short or damaged in its header",
        ))
    }
}

/// The file that a refusal names.
struct Source<'a> {
    path: &'a Path,
}

impl Source<'_> {
    fn wrong(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        ReadError::content(
            self.path,
            expected,
            found,
            "copy the file again, save it again with -v7, or export the channels as CSV with a header",
        )
    }
}

/// How many elements `dims` claim; `None` when no memory holds them.
fn count(dims: &[usize]) -> Option<usize> {
    if dims.contains(&0) {
        return Some(0);
    }
    dims.iter()
        .try_fold(1_usize, |product, length| product.checked_mul(*length))
}

/// Text of `dims` from the code units of UTF-16, which stand down the columns.
fn rows_of_text(dims: &[usize], units: &[u16]) -> Vec<String> {
    let rows = dims.first().copied().unwrap_or(0);
    if rows == 0 || units.is_empty() {
        return Vec::new();
    }
    let columns = units.len() / rows;
    (0..rows.min(units.len()))
        .map(|row| {
            let units: Vec<u16> = (0..columns)
                .map(|column| units[row + column * rows])
                .collect();
            String::from_utf16_lossy(&units)
        })
        .collect()
}

/// Whether doubles hold these integers of 64 bits: 2⁵³ itself may already be another number rounded.
fn is_exact(values: &[f64]) -> bool {
    values
        .iter()
        .all(|value| value.abs() < 9_007_199_254_740_992.0)
}

/// The entries of a sparse matrix from where its columns start, their rows, and their numbers; `None` where these do not fit.
fn sparse_entries(
    rows: usize,
    starts: &[f64],
    row_of: &[f64],
    real: &[f64],
    imaginary: Option<&[f64]>,
) -> Option<Vec<MatEntry>> {
    let mut entries = Vec::new();
    for (column, range) in starts.windows(2).enumerate() {
        if !(0.0 <= range[0] && range[0] <= range[1] && range[1] <= row_of.len() as f64) {
            return None;
        }
        let from = range[0] as usize;
        let rows_here = row_of.iter().enumerate().take(range[1] as usize).skip(from);
        for (k, &row) in rows_here {
            if !(row >= 0.0 && row < rows as f64) {
                return None;
            }
            entries.push(MatEntry {
                row: row as usize,
                column,
                real: *real.get(k)?,
                imaginary: match imaginary {
                    Some(imaginary) => *imaginary.get(k)?,
                    None => 0.0,
                },
            });
        }
    }
    // Ranges rise, so no entry is counted twice: there are no more than the file has.
    Some(entries)
}
