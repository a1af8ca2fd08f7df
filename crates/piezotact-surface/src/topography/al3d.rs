//! AL3D of Alicona's focus-variation instruments: a list of tags, then the depth image as 32-bit floats in m.

use std::collections::HashMap;
use std::str::FromStr;

use super::source::{Number, Order, Source};
use super::{Read, TopographyKind};
use piezotact_dataset::ReadError;

pub(super) const MAGIC: &[u8] = b"AliconaImaging\0\r\n";
const TAG: usize = 52;
const KEY: usize = 20;
const VALUE: usize = 30;
/// The tags `Version` and `TagCount`, which are not counted.
const UNCOUNTED: usize = 2;
/// A point is not measured when it is this close to the marker, which the tag gives in decimals.
const SAME: f64 = 1.5e-7;

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    let first = Tags::read(source, UNCOUNTED)?;
    let count: u16 = first.get("TagCount")?;
    let tags = Tags::read(source, UNCOUNTED + usize::from(count))?;
    let columns: u32 = tags.get("Cols")?;
    let rows: u32 = tags.get("Rows")?;
    let (columns, rows) = (columns as usize, rows as usize);
    let offset: u64 = tags.get("DepthImageOffset")?;
    let offset = usize::try_from(offset).unwrap_or(usize::MAX);
    if offset < MAGIC.len() {
        return Err(source.wrong(
            "a depth image",
            format!("an offset of {offset}"),
            "export it with its heights, not only as a picture",
        ));
    }
    // Rows are padded to whole groups of eight bytes, that is of two heights.
    let padded = columns.div_ceil(2).saturating_mul(2);
    source.points(columns, rows)?;
    let stored = source.points(padded, rows)?;
    let data = source.numbers(offset, stored, Number::F32)?;
    let marker: f64 = tags.get("InvalidPixelValue").unwrap_or(f64::NAN);
    let mut heights_m = Vec::with_capacity(columns.saturating_mul(rows));
    for row in data.chunks_exact(padded.saturating_mul(Number::F32.size())) {
        heights_m.extend(
            Number::F32
                .decode(row, Order::Little)
                .into_iter()
                .take(columns)
                .map(|z| {
                    if (z - marker).abs() <= SAME * marker.abs() {
                        f64::NAN
                    } else {
                        z
                    }
                }),
        );
    }
    Ok(Read {
        kind: TopographyKind::Al3d,
        heights_m,
        columns,
        step_x_m: tags.get("PixelSizeXMeter")?,
        step_y_m: tags.get("PixelSizeYMeter")?,
        warnings: Vec::new(),
    })
}

struct Tags<'a> {
    source: Source<'a>,
    tags: HashMap<String, String>,
}

impl<'a> Tags<'a> {
    fn read(source: Source<'a>, count: usize) -> Result<Self, ReadError> {
        let mut tags = HashMap::new();
        for at in (0..count).map(|tag| MAGIC.len() + tag * TAG) {
            tags.insert(source.text(at, KEY)?, source.text(at + KEY, VALUE)?);
        }
        Ok(Self { source, tags })
    }

    fn get<T: FromStr>(&self, key: &str) -> Result<T, ReadError> {
        let value = self.tags.get(key);
        value.and_then(|value| value.parse().ok()).ok_or_else(|| {
            self.source.wrong(
                format!("a number in the tag `{key}`"),
                value.map_or("no such tag".to_owned(), |value| format!("`{value}`")),
                "export it again as AL3D or SUR",
            )
        })
    }
}
