//! Arrays of samples as NumPy saves them: `.npy` holds one array, `.npz` one for each channel and its rate.
//!
//! Source of the layout: NumPy, *NEP 1: A simple file format for NumPy arrays*.

use piezotact::recording::RecordingDoubt;
use std::io::{Cursor, Read as _};
use std::path::Path;

use piezotact::Doubt;
use piezotact::quantity::SampleRate;
use zip::ZipArchive;

use super::{FileKind, Reader};
use crate::csv_table::{Column, WithoutUnit, choose_rate, rate_of, recording_of};
use crate::error::ReadError;
use crate::format::{Format, Sniff};
use crate::stored::{ByteOrder, Stored as Number};

/// What is unpacked of one array at most, in bytes.
const LARGEST: u64 = 1 << 30;
/// Names of a scalar that is the rate, in Hz, and of a vector that is the time.
const RATES: [&str; 4] = ["fs", "rate", "sample_rate", "sampling_rate"];
const TIMES: [&str; 2] = ["t", "time"];

const MAGIC: &[u8] = b"\x93NUMPY";

/// The row of the table of recordings.
pub(super) const NPY: Format<FileKind, Reader> = Format {
    kind: FileKind::named("NumPy"),
    label: "NPY, NPZ",
    endings: &["npy", "npz"],
    sniff: Sniff::Whole(|_, bytes| bytes.starts_with(MAGIC) || is_npz(bytes)),
    read: |file, options| {
        let path = file.path;
        let mut parts = Parts::default();
        let bytes = file.bytes()?;
        if bytes.starts_with(MAGIC) {
            parts.add(path, None, Array::parse(path, "the array", bytes)?)?;
        } else {
            archive(path, bytes, &mut parts)?;
        }
        let Parts {
            columns,
            time,
            rate,
            mut doubts,
        } = parts;
        if columns.is_empty() {
            return Err(ReadError::content(
                path,
                "an array of samples",
                "none",
                "save the samples of each channel as an array",
            ));
        }
        let mut of_rate = Vec::new();
        let stated = rate.map(|hz| {
            SampleRate::new(hz).map_err(|source| ReadError::Quantity {
                path: path.into(),
                source,
            })
        });
        let found = stated.or_else(|| time.map(|time| rate_of(path, &time, &mut of_rate)));
        if options.rate.is_none() && found.is_none() {
            return Err(ReadError::content(
                path,
                "a rate: a scalar `fs`, `rate` or `sample_rate` in an NPZ file, or one that is stated",
                "neither",
                "give the rate with --rate, for example --rate 5000",
            ));
        }
        let rate = choose_rate(path, options.rate, found, &mut of_rate)?;
        of_rate.append(&mut doubts);
        let unnamed = WithoutUnit::OnlyScale;
        Ok(recording_of(path, columns, rate, of_rate, options, unnamed)?.into())
    },
};

/// What a file's arrays are.
#[derive(Default)]
struct Parts {
    columns: Vec<Column>,
    time: Option<Column>,
    rate: Option<f64>,
    doubts: Vec<Doubt>,
}

impl Parts {
    /// Takes one array, of an archive with its name.
    fn add(&mut self, path: &Path, name: Option<&str>, array: Array) -> Result<(), ReadError> {
        let called = |names: &[&str]| {
            name.is_some_and(|name| names.contains(&name.to_ascii_lowercase().as_str()))
        };
        if array.left > 0 {
            self.guess(format!(
                "{} bytes after the array were left out",
                array.left
            ));
        }
        let wrong = |found: String, todo: &str| {
            let what = name.map_or("the array".to_owned(), |name| format!("`{name}`"));
            Err(ReadError::content(
                path,
                format!("{what} to hold samples in one dimension, or time × channel in two"),
                found,
                todo,
            ))
        };
        let column = |name: String, values| Column {
            name,
            unit: None,
            values,
        };
        match array.shape.as_slice() {
            [] | [1] if called(&RATES) => self.rate = array.values.first().copied(),
            [] => match name {
                Some(name) => self.guess(format!("`{name}` holds no samples and was left out")),
                None => return wrong("a single value or text".into(), "save the samples"),
            },
            [_] if called(&TIMES) => {
                self.time = Some(column(name.unwrap_or_default().into(), array.values));
            }
            [_] => {
                let name = name.unwrap_or("signal").to_owned();
                self.columns.push(column(name, array.values));
            }
            [rows, columns] if columns > rows => {
                return wrong(
                    format!("{rows} × {columns}, more channels than samples"),
                    "transpose it",
                );
            }
            [rows, columns] => {
                for k in 0..*columns {
                    let values = match array.order {
                        Order::C => array.values[k..]
                            .iter()
                            .step_by(*columns)
                            .copied()
                            .collect(),
                        Order::Fortran => array.values[k * rows..(k + 1) * rows].to_vec(),
                    };
                    let name = name.unwrap_or("channel");
                    self.columns
                        .push(column(format!("{name} {}", k + 1), values));
                }
            }
            more => {
                return wrong(
                    format!("{} dimensions", more.len()),
                    "save the dimension of time and channel alone",
                );
            }
        }
        Ok(())
    }

    fn guess(&mut self, what: String) {
        self.doubts
            .push(Doubt::from(RecordingDoubt::Guessed { what }));
    }
}

/// Whether `bytes` are a zip archive with arrays in it.
fn is_npz(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") && bytes.windows(4).any(|name| name == b".npy")
}

/// The arrays of an archive.
fn archive(path: &Path, bytes: &[u8], parts: &mut Parts) -> Result<(), ReadError> {
    let damaged = |error: String| {
        ReadError::content(
            path,
            "a whole NPZ file, a zip archive of arrays",
            error,
            "it was cut short or damaged: copy or save it again",
        )
    };
    let mut zip =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(error.to_string()))?;
    for at in 0..zip.len() {
        let entry = zip
            .by_index(at)
            .map_err(|error| damaged(error.to_string()))?;
        let file = entry.name().map_err(|error| damaged(error.to_string()))?;
        let file = file.into_owned();
        let Some(name) = file.strip_suffix(".npy") else {
            parts.guess(format!("`{file}` is no array and was left out"));
            continue;
        };
        let mut content = Vec::new();
        entry
            .take(LARGEST + 1)
            .read_to_end(&mut content)
            .map_err(|error| damaged(format!("{error} in `{file}`")))?;
        if content.len() as u64 > LARGEST {
            return Err(damaged(format!("more than 1 GiB in `{file}`")));
        }
        let array = Array::parse(path, &format!("`{name}`"), &content)?;
        parts.add(path, Some(name), array)?;
    }
    Ok(())
}

/// One array of real numbers; a text is one without dimensions and numbers.
struct Array {
    shape: Vec<usize>,
    order: Order,
    /// In the order of the file.
    values: Vec<f64>,
    /// Bytes that follow it.
    left: usize,
}

impl Array {
    fn parse(path: &Path, what: &str, bytes: &[u8]) -> Result<Self, ReadError> {
        let wrong = |expected: String, found: String, todo: &str| {
            ReadError::content(path, expected, found, todo)
        };
        let damaged = |found: String| {
            wrong(
                format!("{what} as NumPy saves it"),
                found,
                "it was cut short or damaged: copy or save it again",
            )
        };
        let (header, data) = described(bytes).map_err(|found| damaged(found.into()))?;
        let no_header = || {
            let text: String = header.0.chars().take(80).collect();
            damaged(format!("the description `{}`", text.escape_debug()))
        };
        let (stored, shape) = header.stored().zip(header.shape()).ok_or_else(no_header)?;
        let order = header.order().ok_or_else(no_header)?;
        let (byte_order, kind) = match stored.as_bytes() {
            [b'>', ..] => (ByteOrder::Big, &stored[1..]),
            [b'<' | b'=' | b'|', ..] => (ByteOrder::Little, &stored[1..]),
            _ => (ByteOrder::Little, stored),
        };
        if kind.starts_with(['U', 'S']) {
            return Ok(Self {
                shape: Vec::new(),
                order,
                values: Vec::new(),
                left: 0,
            });
        }
        let number = match kind {
            "f4" => Number::F32,
            "f8" => Number::F64,
            "i1" => Number::I8,
            "i2" => Number::I16,
            "i4" => Number::I32,
            "i8" => Number::I64,
            "u1" => Number::U8,
            "u2" => Number::U16,
            "u4" => Number::U32,
            "u8" => Number::U64,
            other => {
                let (found, todo) = match other.as_bytes() {
                    [b'O', ..] => (
                        "Python objects (a pickle), which are not read: they could run any program",
                        "save it as an array of numbers",
                    ),
                    [b'c', ..] => ("complex numbers", "save its real part"),
                    [b'[', ..] => (
                        "records",
                        "save each of their fields as an array of its own",
                    ),
                    _ => ("another type", "save it with .astype(float)"),
                };
                return Err(wrong(
                    format!("{what} to hold real numbers of 8 to 64 bits"),
                    format!("{found} (`{}`)", stored.escape_debug()),
                    todo,
                ));
            }
        };
        let length = shape
            .iter()
            .try_fold(number.width(), |product, n| product.checked_mul(*n))
            .ok_or_else(|| damaged("a shape that no file holds".into()))?;
        let Some(numbers) = data.get(..length) else {
            return Err(damaged(format!("{} of its {length} bytes", data.len())));
        };
        Ok(Self {
            shape,
            order,
            values: number.values(numbers, byte_order),
            left: data.len() - length,
        })
    }
}

/// The description of an array and the bytes behind it.
fn described(bytes: &[u8]) -> Result<(Header<'_>, &[u8]), &'static str> {
    let (size, rest) = match bytes.strip_prefix(MAGIC) {
        Some([1, _, a, b, rest @ ..]) => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        Some([2 | 3, _, a, b, c, d, rest @ ..]) => {
            (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest)
        }
        _ => return Err("something else"),
    };
    let (text, data) = rest
        .split_at_checked(size)
        .ok_or("a file that ends in its description")?;
    let text = str::from_utf8(text).map_err(|_not_text| "a description that is no text")?;
    Ok((Header(text.trim()), data))
}

/// A description such as `{'descr': '<f8', 'fortran_order': False, 'shape': (40, 3), }`.
struct Header<'a>(&'a str);

impl<'a> Header<'a> {
    /// What follows the name of an entry.
    fn entry(&self, name: &str) -> Option<&'a str> {
        let (_, rest) = self.0.split_once(name)?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start())
    }

    /// The type of the numbers; of records the start of their list.
    fn stored(&self) -> Option<&'a str> {
        let entry = self.entry("'descr'")?;
        match entry.strip_prefix('\'') {
            Some(text) => Some(text.split_once('\'')?.0),
            None => entry.starts_with('[').then_some("[…]"),
        }
    }

    fn order(&self) -> Option<Order> {
        let entry = self.entry("'fortran_order'")?;
        [("False", Order::C), ("True", Order::Fortran)]
            .into_iter()
            .find_map(|(word, order)| entry.starts_with(word).then_some(order))
    }

    fn shape(&self) -> Option<Vec<usize>> {
        let (inner, _) = self.entry("'shape'")?.strip_prefix('(')?.split_once(')')?;
        // Python 2 wrote an L behind long numbers.
        let numbers = inner.split(',').map(|n| n.trim().trim_end_matches('L'));
        let numbers = numbers.filter(|n| !n.is_empty());
        numbers.map(|n| n.parse().ok()).collect()
    }
}

/// Which index of an array runs first.
#[derive(Clone, Copy)]
enum Order {
    /// The last.
    C,
    /// The first.
    Fortran,
}
