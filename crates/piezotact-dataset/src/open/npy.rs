//! Arrays of samples as NumPy saves them: `.npy` holds one array, `.npz` one for each channel and its rate.
//!
//! Source of the layout: NumPy, *NEP 1: A simple file format for NumPy arrays*.

use piezotact::recording::RecordingWarning;
use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use zip::ZipArchive;

use super::beside::Beside;
use super::{FileKind, ReadOptions, Reader};
use crate::columns::{Column, WithoutUnit, recording_of};
use crate::error::ReadError;
use crate::format::{Format, Recognition};
use crate::recording_file::Stored;
use crate::sidecar::sidecar_path;
use crate::stated_rate::{UNIT_WORDS, hz_of, one_of, states_rate, without_word};
use crate::stored::{ByteOrder, Stored as Number};
use crate::time_column::{TimeBase, base_beside, base_of, choose_base, is_time, state_unit};

/// What is unpacked of one array at most, in bytes.
const LARGEST: u64 = 1 << 30;
const MAGIC: &[u8] = b"\x93NUMPY";

/// The row of the table of recordings.
pub(super) const NPY: Format<FileKind, Reader> = Format {
    kind: FileKind::named("NumPy"),
    label: "NPY, NPZ",
    endings: &["npy", "npz"],
    sniff: Recognition::Whole(|_, bytes| bytes.starts_with(MAGIC) || is_npz(bytes)),
    read: |file, options| {
        let path = file.path;
        let mut parts = Parts::default();
        let bytes = file.bytes()?;
        if bytes.starts_with(MAGIC) {
            parts.add(path, None, Array::parse(path, "the array", bytes)?)?;
        } else {
            archive(path, bytes, &mut parts)?;
        }
        if parts.columns.is_empty() {
            return Err(ReadError::content(
                path,
                "an array of samples",
                "none",
                "save the samples of each channel as an array",
            ));
        }
        parts.recording(path, options)
    },
};

/// Real numbers in rows and columns, as a file holds them without a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberTable {
    /// How many numbers are in a row.
    pub columns: usize,
    /// Row after row.
    pub values: Vec<f64>,
}

impl NumberTable {
    /// The table of numbers that stand column after column.
    #[must_use]
    pub fn of_columns(rows: usize, columns: usize, numbers: &[f64]) -> Self {
        let of_row = |row: usize| numbers.iter().skip(row).step_by(rows.max(1)).copied();
        Self {
            columns,
            values: (0..rows).flat_map(of_row).collect(),
        }
    }
}

/// Whether `head` begins a `.npy` file.
#[must_use]
pub fn is_npy(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// The array of the `.npy` file in `bytes`, of one or two dimensions; one of one dimension, or of one column, is a row.
///
/// # Errors
/// [`ReadError`] for what is no whole array of real numbers, and for other dimensions.
pub fn parse_npy(path: &Path, bytes: &[u8]) -> Result<NumberTable, ReadError> {
    let array = Array::parse(path, "the array", bytes)?;
    match (array.shape.as_slice(), array.order) {
        ([columns] | [columns, 1], _) | ([_, columns], Order::C) => Ok(NumberTable {
            columns: *columns,
            values: array.values,
        }),
        ([rows, columns], Order::Fortran) => {
            Ok(NumberTable::of_columns(*rows, *columns, &array.values))
        }
        (other, _) => Err(ReadError::content(
            path,
            "an array of one or two dimensions",
            format!("{} dimensions", other.len()),
            "save one row, or rows and columns",
        )),
    }
}

/// What a file's arrays are.
#[derive(Default)]
struct Parts {
    columns: Vec<Column>,
    /// Of each column, the number of its array and whether that holds integers.
    arrays: Vec<(usize, bool)>,
    time: Option<Column>,
    /// Numbers that state the rate: name, value, and unit where the name has one.
    rates: Vec<(String, f64, Option<String>)>,
    texts: BTreeMap<String, String>,
    warnings: Vec<Warning>,
}

impl Parts {
    /// The recording of the arrays and of the sidecar beside them.
    fn recording(mut self, path: &Path, options: &ReadOptions) -> Result<Stored, ReadError> {
        let mut sidecar = Beside::read(path)?;
        if let Some(sidecar) = &mut sidecar {
            sidecar.of_part(options.part);
        }
        let mut options = options.clone();
        self.state_units();
        if let Some(time) = &mut self.time {
            state_unit(path, time, &mut options.units)?;
        }
        if let Some(sidecar) = &sidecar {
            sidecar.name_columns(&mut self.columns)?;
            sidecar.scale(&mut options, &mut self.warnings);
        }
        self.only_one_scaled(path, &options)?;
        let mut of_rate = Vec::new();
        let found = self.found_base(path, &options, &mut of_rate)?;
        let base = choose_base(path, &options, found, &mut of_rate)?;
        of_rate.append(&mut self.warnings);
        let counts: Vec<String> = self
            .arrays
            .iter()
            .zip(&self.columns)
            .filter(|((_, whole), column)| *whole && column.unit.is_none())
            .map(|(_, column)| column.name.clone())
            .collect();
        let unnamed = WithoutUnit::OnlyScale { counts: &counts };
        let recording = recording_of(path, self.columns, &base, of_rate, &options, unnamed)?;
        let mut stored = Stored::from(recording);
        if let Some(sidecar) = sidecar {
            sidecar.describe(&mut stored);
        }
        Ok(stored)
    }

    /// Gives times, rates and channels the units that texts state: `acc_unit`, `fs_unit`. Other texts are named.
    fn state_units(&mut self) {
        for (name, text) in std::mem::take(&mut self.texts) {
            let of = without_word(&name.to_ascii_lowercase(), &UNIT_WORDS);
            let is_it = |other: &str| of.as_deref() == Some(&*other.to_ascii_lowercase());
            let rates = self.rates.iter_mut().map(|(name, _, unit)| (name, unit));
            let columns = self.columns.iter_mut().chain(&mut self.time);
            let columns = columns.map(|column| (&mut column.name, &mut column.unit));
            let mut named = rates.chain(columns).filter(|(name, _)| is_it(name));
            match named.next() {
                Some((_, unit)) => *unit = unit.take().or(Some(text)),
                None => self.guess(format!("`{name}` holds no samples and was left out")),
            }
        }
    }

    /// Refuses one scale for arrays of several quantities.
    fn only_one_scaled(&self, path: &Path, options: &ReadOptions) -> Result<(), ReadError> {
        let Some(scale) = &options.scale else {
            return Ok(());
        };
        let plain: Vec<(usize, &str)> = self
            .arrays
            .iter()
            .zip(&self.columns)
            .filter(|(_, column)| {
                column.unit.is_none() && !options.units.contains_key(&column.name)
            })
            .map(|((array, _), column)| (*array, column.name.as_str()))
            .collect();
        if plain.iter().all(|(array, _)| *array == plain[0].0) {
            return Ok(());
        }
        let names: Vec<&str> = plain.iter().map(|(_, name)| *name).collect();
        let first = names.first().copied().unwrap_or_default();
        Err(ReadError::content(
            path,
            format!("one array without a unit for the scale {scale}"),
            format!("{}: {}", names.len(), names.join(", ")),
            format!(
                r#"save them under names with units, such as `{first} (m/s2)`, or write {{"units": {{"{first}": "m/s2"}}}} with each channel into {}"#,
                sidecar_path(path).display()
            ),
        ))
    }

    /// The grid of the time vector, of the rate that the file states, or of both.
    fn found_base(
        &self,
        path: &Path,
        options: &ReadOptions,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<Result<TimeBase, ReadError>>, ReadError> {
        let mut rates = Vec::new();
        for (name, value, unit) in &self.rates {
            rates.push((name.clone(), hz_of(path, name, *value, unit.as_deref())?));
        }
        if options.rate.is_some() {
            rates.truncate(1);
        }
        let stated = one_of(path, rates)?;
        let stated = stated.as_ref().map(|(name, hz)| {
            let rate = SampleRate::new(*hz).map_err(ReadError::of(path));
            rate.map(|rate| (name.as_str(), rate))
        });
        let found = match (&self.time, stated) {
            (None, Some(Ok((_, rate)))) => Some(Ok(TimeBase::even(rate))),
            (_, Some(Err(error))) => Some(Err(error)),
            (Some(time), Some(Ok(stated))) => Some(Ok(base_beside(path, time, stated, warnings))),
            (Some(time), None) => Some(base_of(path, time, warnings)),
            (None, None) => None,
        };
        if options.rate.is_none() && found.is_none() {
            return Err(ReadError::content(
                path,
                "a rate: a scalar `fs`, `rate` or `sample_rate` in an NPZ file, or the option --rate",
                "neither",
                "give the rate with --rate, for example --rate 5000",
            ));
        }
        Ok(found)
    }

    /// Takes one array, of an archive with its name.
    fn add(&mut self, path: &Path, key: Option<&str>, array: Array) -> Result<(), ReadError> {
        let header = key.map(Column::from_header);
        let name = header.as_ref().map(|header| header.name.as_str());
        let called = |is_one: &dyn Fn(&str) -> bool| [name, key].into_iter().flatten().any(is_one);
        if array.left > 0 {
            self.guess(format!(
                "{} bytes after the array were left out",
                array.left
            ));
        }
        let wrong = |found: String, todo: &str| {
            let what = key.map_or("the array".to_owned(), |key| format!("`{key}`"));
            Err(ReadError::content(
                path,
                format!("{what} to hold samples in one dimension, or time × channel in two"),
                found,
                todo,
            ))
        };
        let unit = header.as_ref().and_then(|header| header.unit.clone());
        let column = |name: String, values| Column {
            name,
            unit: unit.clone(),
            values,
        };
        let number = self.arrays.last().map_or(0, |(array, _)| array + 1);
        match array.shape.as_slice() {
            [] | [1] if called(&states_rate) && array.text.is_none() => {
                // The unit of `fs (kHz)`; of `dt_ms` it is known by the name.
                let name = if unit.is_some() { name } else { key };
                let stated = name.zip(array.values.first());
                (self.rates).extend(stated.map(|(name, value)| (name.into(), *value, unit)));
            }
            [] | [1] if array.text.is_some() && key.is_some() => {
                let text = key.map(str::to_owned).zip(array.text);
                self.texts.extend(text);
            }
            [] => match key {
                Some(key) => self.guess(format!("`{key}` holds no samples and was left out")),
                None => return wrong("a single value or text".into(), "save the samples"),
            },
            [_] if called(&is_time) => {
                self.time = Some(column(name.unwrap_or_default().into(), array.values));
            }
            [_] => {
                let name = name.unwrap_or("signal").to_owned();
                self.columns.push(column(name, array.values));
                self.arrays.push((number, array.whole));
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
                    self.arrays.push((number, array.whole));
                }
            }
            more => {
                return wrong(
                    format!("{} dimensions", more.len()),
                    "save only the dimensions of time and channel",
                );
            }
        }
        Ok(())
    }

    fn guess(&mut self, what: String) {
        self.warnings
            .push(Warning::from(RecordingWarning::Guessed { what }));
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
            "a complete NPZ file, a zip archive of arrays",
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
            parts.guess(format!("`{file}` is not an array and was left out"));
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
    /// Whether its numbers are integers.
    whole: bool,
    /// The first text, of an array of texts.
    text: Option<String>,
}

/// The first text of an array of them, of a type such as `U3` or `S3`.
fn text_in(kind: &str, data: &[u8], order: ByteOrder) -> Option<String> {
    let (kind, length) = kind.split_at_checked(1)?;
    let width = if kind == "U" { 4 } else { 1 };
    let bytes = data.get(..length.parse::<usize>().ok()?.checked_mul(width)?)?;
    let letters = bytes.chunks_exact(width);
    let text: Option<String> = letters
        .map(|letter| char::from_u32(u32::try_from(order.unsigned(letter)).ok()?))
        .collect();
    Some(text?.trim_end_matches('\0').to_owned())
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
            damaged(format!("the header `{}`", text.escape_debug()))
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
                whole: false,
                text: text_in(kind, data, byte_order),
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
            .ok_or_else(|| damaged("an impossible shape".into()))?;
        let Some(numbers) = data.get(..length) else {
            return Err(damaged(format!("{} of its {length} bytes", data.len())));
        };
        Ok(Self {
            shape,
            order,
            values: number.values(numbers, byte_order),
            left: data.len() - length,
            whole: !kind.starts_with('f'),
            text: None,
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
        .ok_or("a file that ends within its header")?;
    let text = str::from_utf8(text).map_err(|_not_text| "a header that is not text")?;
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
