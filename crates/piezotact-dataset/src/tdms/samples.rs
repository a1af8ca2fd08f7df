//! The samples of the channels, read in blocks.

use std::io::{Read, Seek};

use super::index::Kind;
use super::layout::{Column, Object, Walk};
use super::property::Stamp;
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// What a file is, beside its samples.
#[derive(Debug)]
pub(super) struct File {
    pub(super) objects: Vec<Object>,
    /// Whether it ends before its last segment does.
    pub(super) is_cut: bool,
    pub(super) is_interrupted: bool,
}

/// The samples of one scaler of a channel.
#[derive(Debug, Default)]
pub(super) struct Values {
    /// Of times: s from the first one.
    pub(super) numbers: Vec<f64>,
    /// The first one, of times.
    pub(super) first: Option<Stamp>,
    /// The first one, of texts.
    pub(super) text: Option<String>,
}

/// Reads the samples of a file whose segments were counted: for each object, those of its scalers.
pub(super) fn read<R: Read + Seek>(
    walk: Walk<'_, R>,
) -> Result<(File, Vec<Vec<Values>>), ReadError> {
    let reserved = |object: &Object| {
        let slots = object.slots.iter().map(|slot| {
            let count = match slot.kind {
                Kind::Complex(_) | Kind::Text => 0,
                _ => slot.count as usize,
            };
            Values {
                numbers: Vec::with_capacity(count),
                ..Values::default()
            }
        });
        slots.collect()
    };
    let mut values: Vec<Vec<Values>> = walk.objects.iter().map(reserved).collect();
    let mut walk = walk.again();
    while let Some(segment) = walk.advance()? {
        let Walk {
            source,
            blocks,
            objects,
            ..
        } = &mut walk;
        source.seek(segment.raw)?;
        let whole = (0..segment.whole).flat_map(|_| blocks.iter().map(|block| (block, block.rows)));
        let last = blocks.iter().zip(segment.last.iter().copied());
        for (block, rows) in whole.chain(last) {
            let bytes = rows * block.width;
            let is_wanted = |column: &Column| !matches!(column.kind, Kind::Complex(_) | Kind::Text);
            if block.columns.iter().any(is_wanted) {
                let width = block.width as usize;
                source.rows(bytes, width, |rows| {
                    for column in &block.columns {
                        let values = &mut values[column.object][column.slot];
                        column.append(rows, width, segment.order, values);
                    }
                })?;
                continue;
            }
            let end = source.at() + bytes;
            if let [
                Column {
                    object,
                    slot,
                    kind: Kind::Text,
                    ..
                },
            ] = block.columns.as_slice()
                && rows > 0
                && values[*object][*slot].text.is_none()
            {
                // The ends of all texts stand before the first.
                let count = objects[*object].texts();
                let length = source.number::<4>(segment.order, "the length of a text")?;
                let start = source
                    .at()
                    .saturating_add(count.saturating_sub(1).saturating_mul(4));
                let length = length.min(80).min(end.saturating_sub(start));
                if start < end {
                    source.seek(start)?;
                    let mut text = vec![0; length as usize];
                    source.fill(&mut text, "a text")?;
                    values[*object][*slot].text = Some(String::from_utf8_lossy(&text).into_owned());
                }
            }
            source.seek(end)?;
        }
    }
    let file = File {
        objects: walk.objects,
        is_cut: walk.is_cut,
        is_interrupted: walk.is_interrupted,
    };
    Ok((file, values))
}

impl Column {
    /// Appends the samples of the column in `rows` of `width` bytes.
    pub(super) fn append(&self, rows: &[u8], width: usize, order: ByteOrder, to: &mut Values) {
        let numbers = &mut to.numbers;
        let from = numbers.len();
        match self.kind {
            Kind::Number(number) => number.append(rows, width, self.first, order, numbers),
            Kind::Truth => {
                Stored::U8.append(rows, width, self.first, order, numbers);
                for truth in &mut numbers[from..] {
                    *truth = f64::from(u8::from(*truth != 0.0));
                }
            }
            Kind::Bit(number, bit) => numbers.extend(rows.chunks_exact(width).map(|row| {
                let bytes = row.get(self.first..self.first + number.width());
                let value = order.unsigned(bytes.unwrap_or_default());
                ((value >> bit) & 1) as f64
            })),
            Kind::Time => {
                for row in rows.chunks_exact(width) {
                    let bytes = row.get(self.first..self.first + 16);
                    let stamp = Stamp::of(bytes.unwrap_or_default(), order);
                    let first = *to.first.get_or_insert(stamp);
                    to.numbers.push(stamp.since(first));
                }
            }
            Kind::Complex(_) | Kind::Text => {}
        }
    }
}
