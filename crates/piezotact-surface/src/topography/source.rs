//! What the readers of binary files share: fields and points that are looked up, never assumed to be there.

use std::path::Path;

use piezotact_dataset::ReadError;

/// More points than this are no measurement of a texture but a damaged header.
const MOST_POINTS: usize = 1 << 27;

/// The bytes of a file, and its name for what goes wrong.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
}

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

impl<'a> Source<'a> {
    pub(super) fn wrong(
        &self,
        expected: impl Into<String>,
        found: impl Into<String>,
        todo: impl Into<String>,
    ) -> ReadError {
        ReadError::content(self.path, expected, found, todo)
    }

    /// `length` bytes at `offset`.
    pub(super) fn slice(
        &self,
        what: &str,
        offset: usize,
        length: usize,
    ) -> Result<&'a [u8], ReadError> {
        offset
            .checked_add(length)
            .and_then(|end| self.bytes.get(offset..end))
            .ok_or_else(|| {
                self.wrong(
                    format!("{what}: {length} bytes from byte {offset}"),
                    format!("a file of {} bytes", self.bytes.len()),
                    "it was cut short or its header is damaged: copy or export it again",
                )
            })
    }

    fn field<const N: usize>(&self, offset: usize, order: Order) -> Result<[u8; N], ReadError> {
        let mut field = [0; N];
        field.copy_from_slice(self.slice("a header", offset, N)?);
        if order == Order::Big {
            field.reverse();
        }
        Ok(field)
    }

    pub(super) fn u8(&self, offset: usize) -> Result<u8, ReadError> {
        Ok(u8::from_le_bytes(self.field(offset, Order::Little)?))
    }

    pub(super) fn u16(&self, offset: usize, order: Order) -> Result<u16, ReadError> {
        Ok(u16::from_le_bytes(self.field(offset, order)?))
    }

    pub(super) fn u32(&self, offset: usize, order: Order) -> Result<u32, ReadError> {
        Ok(u32::from_le_bytes(self.field(offset, order)?))
    }

    pub(super) fn i32(&self, offset: usize, order: Order) -> Result<i32, ReadError> {
        Ok(i32::from_le_bytes(self.field(offset, order)?))
    }

    pub(super) fn f32(&self, offset: usize, order: Order) -> Result<f64, ReadError> {
        Ok(f64::from(f32::from_le_bytes(self.field(offset, order)?)))
    }

    pub(super) fn f64(&self, offset: usize, order: Order) -> Result<f64, ReadError> {
        Ok(f64::from_le_bytes(self.field(offset, order)?))
    }

    /// Latin-1 text of a fixed length, up to its first NUL, trimmed.
    pub(super) fn text(&self, offset: usize, length: usize) -> Result<String, ReadError> {
        let field = self.slice("a header", offset, length)?;
        let text: String = field
            .iter()
            .take_while(|byte| **byte != 0)
            .map(|byte| char::from(*byte))
            .collect();
        Ok(text.trim().to_owned())
    }

    /// The number of points of a grid; what no file can hold is refused before anything is set aside for it.
    pub(super) fn points(&self, columns: usize, rows: usize) -> Result<usize, ReadError> {
        columns
            .checked_mul(rows)
            .filter(|points| (1..=MOST_POINTS).contains(points))
            .ok_or_else(|| {
                self.wrong(
                    format!("1 to {MOST_POINTS} points"),
                    format!("a header that states {columns} × {rows}"),
                    "copy or export it again, or cut the map into parts",
                )
            })
    }

    /// The bytes of `points` numbers at `offset`.
    pub(super) fn numbers(
        &self,
        offset: usize,
        points: usize,
        number: Number,
    ) -> Result<&'a [u8], ReadError> {
        self.slice(
            &format!("{points} heights"),
            offset,
            points.saturating_mul(number.size()),
        )
    }
}

/// How a height is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    U8,
    U16,
    U32,
    I8,
    I16,
    I32,
    F32,
    F64,
}

impl Number {
    pub(super) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The numbers in `data`; what is left over of the last one is dropped.
    pub(super) fn decode(self, data: &[u8], order: Order) -> Vec<f64> {
        data.chunks_exact(self.size())
            .map(|chunk| {
                let mut eight = [0; 8];
                match order {
                    Order::Little => {
                        for (to, from) in eight.iter_mut().zip(chunk) {
                            *to = *from;
                        }
                    }
                    Order::Big => {
                        for (to, from) in eight.iter_mut().zip(chunk.iter().rev()) {
                            *to = *from;
                        }
                    }
                }
                let [a, b, c, d, ..] = eight;
                match self {
                    Self::U8 => f64::from(a),
                    Self::I8 => f64::from(i8::from_le_bytes([a])),
                    Self::U16 => f64::from(u16::from_le_bytes([a, b])),
                    Self::I16 => f64::from(i16::from_le_bytes([a, b])),
                    Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
                    Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
                    Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
                    Self::F64 => f64::from_le_bytes(eight),
                }
            })
            .collect()
    }
}

/// How many m a unit of length is, under the names that instruments write.
pub(super) fn unit_m(name: &str) -> Option<f64> {
    let name = name.trim().trim_matches(['(', ')', '[', ']']).trim();
    Some(match name {
        "m" | "metre" | "meter" => 1.0,
        "cm" => 1e-2,
        "mm" | "MM" | "millimetre" | "millimeter" => 1e-3,
        // The micro sign of Unicode, the Greek letter, and the MS-DOS code page's read as Latin-1.
        "µm" | "\u{3bc}m" | "\u{e6}m" | "um" | "UM" | "µ" | "micron" | "microns" | "micrometre"
        | "micrometer" => 1e-6,
        "nm" | "nanometre" | "nanometer" => 1e-9,
        "Å" | "\u{212b}" | "A" | "Angstrom" | "angstrom" => 1e-10,
        "pm" => 1e-12,
        "in" | "inch" | "\"" => 0.0254,
        "mil" | "mils" => 25.4e-6,
        _ => return None,
    })
}
