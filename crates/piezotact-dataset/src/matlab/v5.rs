//! MATLAB 5, 6 and 7: elements of a tag and its bytes, in either order of bytes, some of them compressed.

use std::io::Read as _;

use flate2::read::ZlibDecoder;

use super::{
    LARGEST, MOST_NUMBERS, MatFile, MatNumbers, MatValue, MatVariable, NumberClass, Source, count,
    is_exact, rows_of_text, sparse_entries,
};
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// Arrays within arrays go no deeper than this.
pub(super) const DEEPEST: usize = 64;
/// What deflate makes of one byte at most, and a little more.
pub(super) const MOST_OF_ONE_BYTE: usize = 1040;

/// Flags of an array.
const COMPLEX: u32 = 0x800;
const LOGICAL: u32 = 0x200;

const INT8: u32 = 1;
const UINT8: u32 = 2;
const INT16: u32 = 3;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const SINGLE: u32 = 7;
const DOUBLE: u32 = 9;
const INT64: u32 = 12;
const UINT64: u32 = 13;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const UTF8: u32 = 16;
const UTF16: u32 = 17;
const UTF32: u32 = 18;

/// The version in the header, 1 or (for HDF5) 2.
pub(super) fn version(bytes: &[u8]) -> Option<u64> {
    let order = order(bytes)?;
    Some(order.unsigned(bytes.get(124..126)?) >> 8)
}

/// The order of bytes that the header says; `None` when it is no header.
pub(super) fn order(bytes: &[u8]) -> Option<ByteOrder> {
    let (version, order) = (bytes.get(124..126)?, bytes.get(126..128)?);
    match (order, version) {
        (b"IM", [_, 1 | 2]) => Some(ByteOrder::Little),
        (b"MI", [1 | 2, _]) => Some(ByteOrder::Big),
        _ => None,
    }
}

pub(super) fn read(
    source: &Source<'_>,
    bytes: &[u8],
    order: ByteOrder,
) -> Result<MatFile, ReadError> {
    let mut reader = Reader {
        source,
        order,
        unpacked: 0,
        numbers: 0,
    };
    let mut rest = bytes.get(128..).unwrap_or_default();
    let mut file = MatFile::default();
    while !rest.is_empty() {
        let (element, more) = reader.element(rest)?;
        rest = more;
        let variable = match element.kind {
            COMPRESSED => {
                let unpacked = reader.unpack(element.data)?;
                let (inner, _) = reader.element(&unpacked)?;
                if inner.kind != MATRIX {
                    return Err(reader.wrong("a matrix", format!("data of type {}", inner.kind)));
                }
                reader.matrix(inner.data, 0)?
            }
            MATRIX => reader.matrix(element.data, 0)?,
            other => return Err(reader.wrong("a variable", format!("data of type {other}"))),
        };
        file.variables.push(variable);
    }
    Ok(file)
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

struct Reader<'s> {
    source: &'s Source<'s>,
    order: ByteOrder,
    /// Bytes unpacked so far.
    unpacked: usize,
    /// Numbers decoded so far.
    numbers: usize,
}

impl Reader<'_> {
    fn wrong(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        self.source.wrong(expected, found)
    }

    fn word(&self, bytes: &[u8], at: usize) -> Option<u32> {
        let four = bytes.get(at..at.checked_add(4)?)?;
        u32::try_from(self.order.unsigned(four)).ok()
    }

    /// The element at the start of `bytes`, and what follows it.
    fn element<'a>(&self, bytes: &'a [u8]) -> Result<(Element<'a>, &'a [u8]), ReadError> {
        let cut = || self.wrong("a complete element", "the end of the data");
        let first = self.word(bytes, 0).ok_or_else(cut)?;
        if first >> 16 != 0 {
            // A small one: its data stand in the second half of the tag.
            let (kind, length) = (first & 0xFFFF, (first >> 16) as usize);
            let data = bytes.get(4..8).ok_or_else(cut)?;
            let data = data.get(..length).ok_or_else(|| {
                self.wrong("a small element of at most 4 bytes", format!("{length}"))
            })?;
            return Ok((Element { kind, data }, &bytes[8..]));
        }
        let length = self.word(bytes, 4).ok_or_else(cut)? as usize;
        let data = bytes
            .get(8..)
            .and_then(|rest| rest.get(..length))
            .ok_or_else(|| {
                self.wrong(
                    format!("an element of {length} bytes"),
                    format!("{} bytes left", bytes.len().saturating_sub(8)),
                )
            })?;
        // All but compressed ones are filled up to 8 bytes; the last one may lack the filling.
        let end = if first == COMPRESSED {
            8 + length
        } else {
            8 + length.next_multiple_of(8)
        };
        let rest = bytes.get(end..).unwrap_or_default();
        Ok((Element { kind: first, data }, rest))
    }

    fn unpack(&mut self, data: &[u8]) -> Result<Vec<u8>, ReadError> {
        let most = data
            .len()
            .saturating_mul(MOST_OF_ONE_BYTE)
            .saturating_add(1 << 16)
            .min(LARGEST - self.unpacked.min(LARGEST));
        let mut unpacked = Vec::new();
        ZlibDecoder::new(data)
            .take(most as u64 + 1)
            .read_to_end(&mut unpacked)
            .map_err(|error| {
                self.wrong("a compressed variable", format!("damaged bytes ({error})"))
            })?;
        if unpacked.len() > most {
            return Err(self.wrong(
                format!("at most {LARGEST} bytes unpacked"),
                "more: cut the recording into parts",
            ));
        }
        self.unpacked += unpacked.len();
        Ok(unpacked)
    }

    fn matrix(&mut self, bytes: &[u8], depth: usize) -> Result<MatVariable, ReadError> {
        let unnamed = |value| MatVariable {
            name: String::new(),
            value,
        };
        if bytes.is_empty() {
            return Ok(unnamed(empty()));
        }
        if depth > DEEPEST {
            return Err(self.wrong(format!("at most {DEEPEST} arrays within another"), "more"));
        }
        let (flags, rest) = self.element(bytes)?;
        let flags = match (flags.kind, self.word(flags.data, 0)) {
            (UINT32, Some(flags)) => flags,
            _ => return Err(self.wrong("the flags of an array", "other data")),
        };
        let class = flags & 0xFF;
        if class == 17 {
            // An object of the new kind has no shape: a name, its system, its class, and what only MATLAB understands.
            let mut rest = rest;
            let texts = std::array::from_fn(|_| {
                let (element, more) = self.element(rest).ok()?;
                rest = more;
                Some(latin(element.data))
            });
            let [name, _, class]: [Option<String>; 3] = texts;
            return Ok(MatVariable {
                name: name.unwrap_or_default(),
                value: MatValue::Object(class),
            });
        }
        let (dims, rest) = self.element(rest)?;
        let dims = self.dims(&dims)?;
        let (name, rest) = self.element(rest)?;
        if !matches!(name.kind, INT8 | UINT8 | UTF8) {
            return Err(self.wrong(
                "the name of an array",
                format!("data of type {}", name.kind),
            ));
        }
        let name = match name.kind {
            UTF8 => String::from_utf8_lossy(name.data).into_owned(),
            _ if name.data.is_ascii() => latin(name.data),
            _ => return Err(self.wrong("a name of plain letters", "other bytes")),
        };
        let value = match class {
            1 => self.cells(dims, rest, depth)?,
            2 => self.structure(dims, None, rest, depth)?,
            3 => {
                let (class, rest) = self.element(rest)?;
                self.structure(dims, Some(latin(class.data)), rest, depth)?
            }
            4 => self.characters(&dims, rest)?,
            5 => self.sparse(&dims, flags, rest)?,
            6..=15 => self.numbers(dims, flags, rest)?,
            16 => MatValue::Unreadable("a function".into()),
            other => MatValue::Unreadable(format!("an array of class {other}")),
        };
        Ok(MatVariable { name, value })
    }

    fn dims(&self, element: &Element<'_>) -> Result<Vec<usize>, ReadError> {
        let dims: Option<Vec<usize>> = match element.kind {
            // Some programs write them as unsigned.
            INT32 | UINT32 if element.data.len() <= 4 * 32 => element
                .data
                .chunks_exact(4)
                .map(|four| {
                    let length = self.word(four, 0)?;
                    i32::try_from(length).ok()?.try_into().ok()
                })
                .collect(),
            _ => None,
        };
        dims.filter(|dims| dims.len() >= 2)
            .ok_or_else(|| self.wrong("the dimensions of an array", "other data"))
    }

    fn elements(&self, dims: &[usize]) -> Result<usize, ReadError> {
        count(dims).ok_or_else(|| self.wrong("an array that fits into memory", format!("{dims:?}")))
    }

    /// Arrays one after the other, as many as are claimed; each takes 8 bytes at least.
    fn several(
        &mut self,
        wanted: usize,
        mut rest: &[u8],
        depth: usize,
    ) -> Result<Vec<MatValue>, ReadError> {
        if wanted > rest.len() / 8 {
            return Err(self.wrong(
                format!("{wanted} arrays within another"),
                format!("{} bytes for them", rest.len()),
            ));
        }
        // A value takes more room in memory than its 8 bytes in the file.
        self.claim(wanted.saturating_mul(16))?;
        let mut values = Vec::new();
        for _ in 0..wanted {
            let (element, more) = self.element(rest)?;
            rest = more;
            if element.kind != MATRIX {
                return Err(self.wrong("an array", format!("data of type {}", element.kind)));
            }
            values.push(self.matrix(element.data, depth + 1)?.value);
        }
        Ok(values)
    }

    fn cells(
        &mut self,
        dims: Vec<usize>,
        rest: &[u8],
        depth: usize,
    ) -> Result<MatValue, ReadError> {
        let wanted = self.elements(&dims)?;
        let values = self.several(wanted, rest, depth)?;
        Ok(MatValue::Cell { dims, values })
    }

    fn structure(
        &mut self,
        dims: Vec<usize>,
        class: Option<String>,
        rest: &[u8],
        depth: usize,
    ) -> Result<MatValue, ReadError> {
        let (length, rest) = self.element(rest)?;
        let length = self.word(length.data, 0).unwrap_or(0) as usize;
        let (names, rest) = self.element(rest)?;
        if length == 0 && !names.data.is_empty() {
            return Err(self.wrong("the length of the names of fields", "0"));
        }
        let fields: Vec<String> = names
            .data
            .chunks_exact(length.max(1))
            .map(|name| latin(name.split(|b| *b == 0).next().unwrap_or_default()))
            .collect();
        let wanted = self
            .elements(&dims)?
            .checked_mul(fields.len())
            .ok_or_else(|| self.wrong("a structure that fits into memory", format!("{dims:?}")))?;
        let values = self.several(wanted, rest, depth)?;
        Ok(MatValue::Struct {
            dims,
            class,
            fields,
            values,
        })
    }

    fn characters(&mut self, dims: &[usize], rest: &[u8]) -> Result<MatValue, ReadError> {
        let wanted = self.elements(dims)?;
        if wanted == 0 {
            return Ok(MatValue::Text(Vec::new()));
        }
        let (element, _) = self.element(rest)?;
        self.claim(element.data.len())?;
        let units: Vec<u16> = match element.kind {
            UTF8 => String::from_utf8_lossy(element.data)
                .encode_utf16()
                .collect(),
            INT8 | UINT8 => element.data.iter().map(|b| u16::from(*b)).collect(),
            UINT16 | INT16 | UTF16 => element
                .data
                .chunks_exact(2)
                .map(|two| self.order.unsigned(two) as u16)
                .collect(),
            UTF32 | UINT32 | INT32 => {
                let text: String = element
                    .data
                    .chunks_exact(4)
                    .map(|four| {
                        self.word(four, 0)
                            .and_then(char::from_u32)
                            .unwrap_or(char::REPLACEMENT_CHARACTER)
                    })
                    .collect();
                text.encode_utf16().collect()
            }
            other => return Err(self.wrong("characters", format!("data of type {other}"))),
        };
        // One row may hold letters that take two units, or bytes that were no text: all of it is that row.
        let one_row = dims.first() == Some(&1) && dims.len() == 2;
        if units.len() != wanted && !one_row {
            return Err(self.wrong(format!("{wanted} characters"), format!("{}", units.len())));
        }
        Ok(MatValue::Text(rows_of_text(dims, &units)))
    }

    /// Counts what is about to be decoded.
    fn claim(&mut self, numbers: usize) -> Result<(), ReadError> {
        self.numbers = self.numbers.saturating_add(numbers);
        if self.numbers > MOST_NUMBERS {
            return Err(self.wrong(format!("at most {MOST_NUMBERS} numbers in a file"), "more"));
        }
        Ok(())
    }

    fn numbers(
        &mut self,
        dims: Vec<usize>,
        flags: u32,
        rest: &[u8],
    ) -> Result<MatValue, ReadError> {
        let wanted = self.elements(&dims)?;
        let mut exact = true;
        let (real, rest) = self.part(wanted, rest, &mut exact)?;
        let imaginary = if flags & COMPLEX != 0 {
            Some(self.part(wanted, rest, &mut exact)?.0)
        } else {
            None
        };
        let class = match flags & 0xFF {
            _ if flags & LOGICAL != 0 => NumberClass::Logical,
            6 => NumberClass::Double,
            7 => NumberClass::Single,
            other => {
                let bits = 8_u8 << ((other - 8) / 2);
                if other % 2 == 0 {
                    NumberClass::Int(bits)
                } else {
                    NumberClass::Uint(bits)
                }
            }
        };
        Ok(MatValue::Numbers(MatNumbers {
            dims,
            class,
            real,
            imaginary,
            exact,
        }))
    }

    /// One list of numbers: MATLAB stores them in the smallest type that holds them.
    fn part<'a>(
        &mut self,
        wanted: usize,
        rest: &'a [u8],
        exact: &mut bool,
    ) -> Result<(Vec<f64>, &'a [u8]), ReadError> {
        if wanted == 0 && rest.is_empty() {
            return Ok((Vec::new(), rest));
        }
        let (element, rest) = self.element(rest)?;
        let values = self.decode(&element, exact)?;
        if values.len() != wanted {
            return Err(self.wrong(
                format!("{wanted} numbers"),
                format!("{} in their place", values.len()),
            ));
        }
        Ok((values, rest))
    }

    fn decode(&mut self, element: &Element<'_>, exact: &mut bool) -> Result<Vec<f64>, ReadError> {
        let stored = match element.kind {
            INT8 => Stored::I8,
            UINT8 => Stored::U8,
            INT16 => Stored::I16,
            UINT16 => Stored::U16,
            INT32 => Stored::I32,
            UINT32 => Stored::U32,
            SINGLE => Stored::F32,
            DOUBLE => Stored::F64,
            INT64 => Stored::I64,
            UINT64 => Stored::U64,
            other => return Err(self.wrong("numbers", format!("data of type {other}"))),
        };
        let width = stored.width();
        if !element.data.len().is_multiple_of(width) {
            return Err(self.wrong(
                format!("numbers of {width} bytes"),
                format!("{} bytes", element.data.len()),
            ));
        }
        self.claim(element.data.len() / width)?;
        let values = stored.values(element.data, self.order);
        if matches!(stored, Stored::I64 | Stored::U64) {
            *exact &= is_exact(&values);
        }
        Ok(values)
    }

    fn sparse(&mut self, dims: &[usize], flags: u32, rest: &[u8]) -> Result<MatValue, ReadError> {
        let &[rows, columns] = dims else {
            return Err(self.wrong("a sparse matrix of two dimensions", format!("{dims:?}")));
        };
        let mut exact = true;
        let (row_of, rest) = self.element(rest)?;
        let row_of = self.decode(&row_of, &mut exact)?;
        let (starts, rest) = self.element(rest)?;
        let starts = self.decode(&starts, &mut exact)?;
        let (mut real, rest) = self.element(rest)?;
        if flags & LOGICAL != 0 && real.data.len() == row_of.len() {
            // MATLAB calls the bytes of a logical matrix doubles.
            real.kind = UINT8;
        }
        let real = self.decode(&real, &mut exact)?;
        let complex = flags & COMPLEX != 0;
        let imaginary = if complex {
            let (imaginary, _) = self.element(rest)?;
            self.decode(&imaginary, &mut exact)?
        } else {
            Vec::new()
        };
        let imaginary = complex.then_some(imaginary.as_slice());
        let entries = sparse_entries(rows, &starts, &row_of, &real, imaginary)
            .filter(|_| columns.checked_add(1) == Some(starts.len()))
            .ok_or_else(|| self.wrong("the rows and columns of a sparse matrix", "others"))?;
        Ok(MatValue::Sparse {
            rows,
            columns,
            entries,
        })
    }
}

fn empty() -> MatValue {
    MatValue::Numbers(MatNumbers {
        dims: vec![0, 0],
        class: NumberClass::Double,
        real: Vec::new(),
        imaginary: None,
        exact: true,
    })
}

fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|b| char::from(*b)).collect()
}
