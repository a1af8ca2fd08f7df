//! MATLAB 4: a header of five integers before every matrix.

use super::{
    MOST_NUMBERS, MatEntry, MatFile, MatNumbers, MatValue, MatVariable, NumberClass, Source, count,
    rows_of_text,
};
use crate::error::ReadError;

/// The header of one matrix.
struct Header {
    little: bool,
    /// 0 double, 1 single, 2 int32, 3 int16, 4 uint16, 5 uint8.
    precision: usize,
    /// 0 full, 1 text, 2 sparse.
    kind: usize,
    rows: usize,
    columns: usize,
    complex: bool,
    name_length: usize,
}

const WIDTHS: [usize; 6] = [8, 4, 4, 2, 2, 1];

impl Header {
    fn of(bytes: &[u8]) -> Option<Self> {
        let fields: [u8; 20] = bytes.get(..20)?.try_into().ok()?;
        let field = |k: usize, little: bool| {
            let four = [
                fields[4 * k],
                fields[4 * k + 1],
                fields[4 * k + 2],
                fields[4 * k + 3],
            ];
            if little {
                i32::from_le_bytes(four)
            } else {
                i32::from_be_bytes(four)
            }
        };
        let little = (0..=4052).contains(&field(0, true)) && field(0, true) / 1000 == 0;
        let kind = usize::try_from(field(0, little)).ok()?;
        let (machine, zero, precision, kind) =
            (kind / 1000, kind / 100 % 10, kind / 10 % 10, kind % 10);
        let stands = machine == usize::from(!little) && zero == 0 && precision < 6 && kind < 3;
        let complex = field(3, little);
        let name_length = usize::try_from(field(4, little)).ok()?;
        (stands && (0..=1).contains(&complex) && (1..=256).contains(&name_length)).then_some(())?;
        Some(Self {
            little,
            precision,
            kind,
            rows: usize::try_from(field(1, little)).ok()?,
            columns: usize::try_from(field(2, little)).ok()?,
            complex: complex == 1,
            name_length,
        })
    }
}

/// Whether a header of version 4 and a name follow each other at the start.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    Header::of(bytes).is_some_and(|header| {
        let name = bytes.get(20..20 + header.name_length).unwrap_or_default();
        matches!(name, [first, .., 0] if first.is_ascii_alphabetic())
    })
}

pub(super) fn read(source: &Source<'_>, bytes: &[u8]) -> Result<MatFile, ReadError> {
    let (mut file, mut rest, mut numbers) = (MatFile::default(), bytes, 0_usize);
    while !rest.is_empty() {
        let header = Header::of(rest)
            .ok_or_else(|| source.wrong("the header of a matrix (version 4)", "other bytes"))?;
        let name = rest.get(20..20 + header.name_length).unwrap_or_default();
        let name = name.split(|b| *b == 0).next().unwrap_or_default();
        let name: String = name.iter().map(|b| char::from(*b)).collect();
        let cut = || {
            source.wrong(
                format!(
                    "{} × {} numbers of `{}`",
                    header.rows,
                    header.columns,
                    name.escape_debug()
                ),
                "the end of the file",
            )
        };
        let elements = count(&[header.rows, header.columns]).ok_or_else(cut)?;
        let width = WIDTHS[header.precision];
        let parts = 1 + usize::from(header.complex);
        let start = 20 + header.name_length;
        let end = elements
            .checked_mul(width * parts)
            .and_then(|length| length.checked_add(start))
            .filter(|end| *end <= rest.len())
            .ok_or_else(cut)?;
        numbers = numbers.saturating_add(elements * parts);
        if numbers > MOST_NUMBERS {
            return Err(source.wrong(format!("at most {MOST_NUMBERS} numbers"), "more"));
        }
        let (real, imaginary) = rest[start..end].split_at(elements * width);
        let real = decode(real, header.precision, header.little);
        let imaginary = header
            .complex
            .then(|| decode(imaginary, header.precision, header.little));
        rest = &rest[end..];
        let value = match header.kind {
            1 => {
                let units: Vec<u16> = real.iter().map(|unit| *unit as u16).collect();
                MatValue::Text(rows_of_text(&[header.rows, header.columns], &units))
            }
            2 => sparse(source, &header, &real)?,
            _ => MatValue::Numbers(MatNumbers {
                dims: vec![header.rows, header.columns],
                class: match header.precision {
                    0 => NumberClass::Double,
                    1 => NumberClass::Single,
                    2 => NumberClass::Int(32),
                    3 => NumberClass::Int(16),
                    4 => NumberClass::Uint(16),
                    _ => NumberClass::Uint(8),
                },
                real,
                imaginary,
                exact: true,
            }),
        };
        file.variables.push(MatVariable { name, value });
    }
    Ok(file)
}

fn decode(bytes: &[u8], precision: usize, little: bool) -> Vec<f64> {
    bytes
        .chunks_exact(WIDTHS[precision])
        .map(|chunk| {
            let mut le = [0; 8];
            for (k, byte) in chunk.iter().enumerate() {
                le[if little { k } else { chunk.len() - 1 - k }] = *byte;
            }
            let four = [le[0], le[1], le[2], le[3]];
            match precision {
                0 => f64::from_le_bytes(le),
                1 => f32::from_le_bytes(four).into(),
                2 => i32::from_le_bytes(four).into(),
                3 => i16::from_le_bytes([le[0], le[1]]).into(),
                4 => u16::from_le_bytes([le[0], le[1]]).into(),
                _ => le[0].into(),
            }
        })
        .collect()
}

/// Rows of row, column, value (and imaginary part), from 1; the last row is the shape.
fn sparse(source: &Source<'_>, header: &Header, table: &[f64]) -> Result<MatValue, ReadError> {
    let wrong = || {
        source.wrong(
            "a sparse matrix as rows of row, column and value",
            format!("{} × {} numbers", header.rows, header.columns),
        )
    };
    let (count, width) = (header.rows, header.columns);
    if count == 0 || !(3..=4).contains(&width) || table.len() != count * width {
        return Err(wrong());
    }
    let at = |row: usize, column: usize| table[row + column * count];
    let index = |value: f64| {
        ((0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0)
            .then_some(value as usize)
    };
    let (Some(rows), Some(columns)) = (index(at(count - 1, 0)), index(at(count - 1, 1))) else {
        return Err(wrong());
    };
    let mut entries = Vec::new();
    for k in 0..count - 1 {
        match (index(at(k, 0)), index(at(k, 1))) {
            (Some(row), Some(column))
                if (1..=rows).contains(&row) && (1..=columns).contains(&column) =>
            {
                entries.push(MatEntry {
                    row: row - 1,
                    column: column - 1,
                    real: at(k, 2),
                    imaginary: if width == 4 { at(k, 3) } else { 0.0 },
                });
            }
            _ => return Err(wrong()),
        }
    }
    Ok(MatValue::Sparse {
        rows,
        columns,
        entries,
    })
}
