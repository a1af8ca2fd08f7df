//! MATLAB 4: a header of five integers before every matrix.

use super::{
    MOST_NUMBERS, MatEntry, MatFile, MatNumbers, MatValue, MatVariable, NumberClass, Source, count,
    rows_of_text,
};
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// The header of one matrix.
struct Header {
    order: ByteOrder,
    stored: Stored,
    class: NumberClass,
    /// 0 full, 1 text, 2 sparse.
    kind: u64,
    rows: usize,
    columns: usize,
    complex: bool,
    name_length: usize,
}

const TYPES: [(Stored, NumberClass); 6] = [
    (Stored::F64, NumberClass::Double),
    (Stored::F32, NumberClass::Single),
    (Stored::I32, NumberClass::Int(32)),
    (Stored::I16, NumberClass::Int(16)),
    (Stored::U16, NumberClass::Uint(16)),
    (Stored::U8, NumberClass::Uint(8)),
];

impl Header {
    fn of(bytes: &[u8]) -> Option<Self> {
        let header = bytes.get(..20)?;
        // Thousands of the first number say the machine: 0 little endian, 1 big endian.
        [(ByteOrder::Little, 0), (ByteOrder::Big, 1)]
            .into_iter()
            .find_map(|(order, machine)| {
                let mut fields = header.chunks_exact(4).map(|four| order.unsigned(four));
                let kind = fields.next()?;
                let (rows, columns) = (fields.next()?, fields.next()?);
                let (complex, name_length) = (fields.next()?, fields.next()?);
                let (stored, class) = *TYPES.get(usize::try_from(kind / 10 % 10).ok()?)?;
                let stands = kind / 1000 == machine && kind / 100 % 10 == 0 && kind % 10 < 3;
                (stands && complex <= 1 && (1..=256).contains(&name_length)).then_some(())?;
                Some(Self {
                    order,
                    stored,
                    class,
                    kind: kind % 10,
                    rows: usize::try_from(rows).ok()?,
                    columns: usize::try_from(columns).ok()?,
                    complex: complex == 1,
                    name_length: usize::try_from(name_length).ok()?,
                })
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
        let width = header.stored.width();
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
        let real = header.stored.values(real, header.order);
        let imaginary = header
            .complex
            .then(|| header.stored.values(imaginary, header.order));
        rest = &rest[end..];
        let value = match header.kind {
            1 => {
                let units: Vec<u16> = real.iter().map(|unit| *unit as u16).collect();
                MatValue::Text(rows_of_text(&[header.rows, header.columns], &units))
            }
            2 => sparse(source, &header, &real)?,
            _ => MatValue::Numbers(MatNumbers {
                dims: vec![header.rows, header.columns],
                class: header.class,
                real,
                imaginary,
                exact: true,
            }),
        };
        file.variables.push(MatVariable { name, value });
    }
    Ok(file)
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
