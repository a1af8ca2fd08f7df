//! BCR-STM (16-bit whole numbers) and BCRF (32-bit floats): a header of `key = value` lines, padded to a
//! stated number of characters of one byte (Latin-1) or two (UTF-16), then the heights row by row.

use super::source::{Number, Order, Source, unit_m};
use super::{Read, TopographyKind};
use piezotact_dataset::ReadError;

const MAGIC: &str = "fileformat = bcr";
/// The characters of a header that does not state its size.
const HEADER: usize = 2048;
/// The characters of the longest header.
const LONGEST_HEADER: usize = 1 << 20;
/// A 16-bit point that was not measured.
const NOT_MEASURED: f64 = 32_767.0;
/// Floats above this stand for points that were not measured; the key `voidpixels` is a count in some files
/// and the marker in others.
const MEASURED_BELOW: f64 = 1.7e38;

#[derive(Clone, Copy)]
enum Characters {
    Latin1,
    Utf16(Order),
}

fn characters(bytes: &[u8]) -> Option<Characters> {
    let wide = |order: Order, bytes: &[u8]| {
        let text = decode(Characters::Utf16(order), bytes.get(..2 * MAGIC.len())?);
        (text == MAGIC).then_some(Characters::Utf16(order))
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => wide(Order::Little, rest),
        [0xFE, 0xFF, rest @ ..] => wide(Order::Big, rest),
        _ if bytes.starts_with(MAGIC.as_bytes()) => Some(Characters::Latin1),
        _ => wide(Order::Little, bytes),
    }
}

fn decode(characters: Characters, bytes: &[u8]) -> String {
    match characters {
        Characters::Latin1 => bytes.iter().map(|byte| char::from(*byte)).collect(),
        Characters::Utf16(order) => {
            let units = bytes.chunks_exact(2).map(|pair| match (order, pair) {
                (Order::Little, [a, b]) => u16::from_le_bytes([*a, *b]),
                (Order::Big, [a, b]) => u16::from_be_bytes([*a, *b]),
                _ => 0,
            });
            char::decode_utf16(units)
                .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect()
        }
    }
}

pub(super) fn is_bcr(bytes: &[u8]) -> bool {
    characters(bytes).is_some()
}

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    let characters = characters(source.bytes).unwrap_or(Characters::Latin1);
    let width = match characters {
        Characters::Latin1 => 1,
        Characters::Utf16(_) => 2,
    };
    let header = |length: usize| -> Result<Header<'_>, ReadError> {
        let text = decode(characters, source.slice("a header", 0, length * width)?);
        Ok(Header { source, text })
    };
    let length = match header(HEADER)?.value("headersize") {
        None => HEADER,
        Some(text) => text
            .parse()
            .ok()
            .filter(|length| (1..=LONGEST_HEADER).contains(length))
            .ok_or_else(|| {
                source.wrong(
                    format!("a header of at most {LONGEST_HEADER} characters"),
                    format!("`headersize = {text}`"),
                    "copy or export it again",
                )
            })?,
    };
    let header = header(length)?;
    let format = header
        .value("\u{feff}fileformat")
        .or_else(|| header.value("fileformat"))
        .unwrap_or_default();
    let (kind, number) = match format.as_str() {
        "bcrstm" | "bcrstm_unicode" => (TopographyKind::BcrStm, Number::I16),
        "bcrf" | "bcrf_unicode" => (TopographyKind::Bcrf, Number::F32),
        other => {
            return Err(source.wrong(
                "the format bcrstm or bcrf",
                format!("`{other}`"),
                "export it as one of these, or as SUR",
            ));
        }
    };
    let order = match header.value("intelmode").as_deref() {
        Some("0") => Order::Big,
        _ => Order::Little,
    };
    let columns = header.whole("xpixels")?;
    let rows = header.whole("ypixels")?;
    let points = source.points(columns, rows)?;
    let data = source.numbers(length * width, points, number)?;
    // Floats are stored in the unit itself; whole numbers are multiplied by `bit2nm` first.
    let bit = match number {
        Number::I16 if header.value("bit2nm").is_some() => header.real("bit2nm")?,
        _ => 1.0,
    };
    let scale = bit * header.unit_m("zunit")?;
    let mut heights_m = number.decode(data, order);
    for z in &mut heights_m {
        let missing = match number {
            Number::I16 => z.to_bits() == NOT_MEASURED.to_bits(),
            _ => *z > MEASURED_BELOW,
        };
        *z = if missing { f64::NAN } else { *z * scale };
    }
    Ok(Read {
        kind,
        heights_m,
        columns,
        step_x_m: header.real("xlength")? * header.unit_m("xunit")? / columns as f64,
        step_y_m: header.real("ylength")? * header.unit_m("yunit")? / rows as f64,
        warnings: Vec::new(),
    })
}

struct Header<'a> {
    source: Source<'a>,
    text: String,
}

impl Header<'_> {
    fn value(&self, key: &str) -> Option<String> {
        self.text.lines().find_map(|line| {
            let (name, value) = line.split_once('=')?;
            (name.trim() == key).then(|| value.trim().trim_end_matches('\0').to_owned())
        })
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, ReadError> {
        let value = self.value(key);
        value
            .as_deref()
            .and_then(|value| value.parse().ok())
            .ok_or_else(|| {
                self.source.wrong(
                    format!("a number for `{key}` in the header"),
                    value.map_or("nothing".to_owned(), |value| format!("`{value}`")),
                    "export it again as BCRF or SUR",
                )
            })
    }

    fn whole(&self, key: &str) -> Result<usize, ReadError> {
        self.number(key)
    }

    fn real(&self, key: &str) -> Result<f64, ReadError> {
        self.number(key)
    }

    /// What 1 stands for in m; nm where nothing is said.
    fn unit_m(&self, key: &str) -> Result<f64, ReadError> {
        let Some(name) = self.value(key) else {
            return Ok(1e-9);
        };
        unit_m(&name).ok_or_else(|| {
            self.source.wrong(
                format!("a unit of length for `{key}`"),
                format!("`{name}`"),
                "export the height channel",
            )
        })
    }
}
