//! Which blocks of rows a segment is made of.

use std::io::{Read, Seek};

use super::index::{Kind, LONGEST_ROW};
use super::layout::{Block, Column, End, Segment, Walk};
use crate::error::ReadError;

impl<R: Read + Seek> Walk<'_, R> {
    /// The blocks of which each chunk of the segment at `at` is made.
    pub(super) fn planned(&self, at: u64) -> Result<Vec<Block>, ReadError> {
        let mut blocks = Vec::<Block>::new();
        let listed = self.list.iter().filter(|(_, has_samples)| *has_samples);
        let with_index = listed.filter_map(|(number, _)| {
            let object = &self.objects[*number];
            Some((*number, object, object.index.as_ref()?))
        });
        let (mut of_daqmx, mut others) = (None::<&[u64]>, false);
        for (number, object, index) in with_index {
            if !index.widths.is_empty() {
                if of_daqmx.is_some_and(|widths| widths != index.widths) {
                    let found = format!("{:?} and {:?}", of_daqmx, index.widths);
                    let expected = "the same widths of DAQmx buffers of all channels";
                    return Err(self.source.wrong(at, expected, found));
                }
                if of_daqmx.is_none() {
                    blocks.extend(index.widths.iter().map(|width| Block {
                        rows: 0,
                        width: *width,
                        columns: Vec::new(),
                    }));
                }
                of_daqmx = Some(&index.widths);
            } else {
                others = true;
                if blocks.is_empty() || !self.is_interleaved {
                    blocks.push(Block {
                        rows: 0,
                        width: 0,
                        columns: Vec::new(),
                    });
                }
            }
            if of_daqmx.is_some() && others {
                let found = "other samples beside them";
                return Err(self.source.wrong(at, "DAQmx raw data alone", found));
            }
            for part in &index.parts {
                let slots = object.slots.iter();
                let slot = slots.take_while(|slot| slot.scaler != part.scaler).count();
                let buffer = match of_daqmx {
                    Some(_) => part.buffer,
                    None => blocks.len() - 1,
                };
                let block = &mut blocks[buffer];
                let is_first = block.columns.is_empty();
                let mut first = part.first;
                if of_daqmx.is_none() {
                    first = block.width;
                    block.width += part.kind.width() as u64;
                }
                let mut rows = index.count;
                if part.kind == Kind::Text {
                    if self.is_interleaved {
                        let found = "texts";
                        return Err(self.source.wrong(at, "interleaved numbers", found));
                    }
                    // Texts are one row, however many they are.
                    (rows, block.width) = (u64::from(index.bytes > 0), index.bytes);
                }
                if !is_first && rows != block.rows {
                    let found = format!("{} and {rows}", block.rows);
                    let expected = "interleaved channels of one length";
                    return Err(self.source.wrong(at, expected, found));
                }
                block.rows = rows;
                let is_long = block.width > LONGEST_ROW && part.kind != Kind::Text;
                // Digital lines are the narrowest samples, of a bit each.
                let are_many = block.columns.len() as u64 >= block.width.saturating_mul(8).max(1);
                if is_long || are_many {
                    let found = format!(
                        "{} bytes for {} channels",
                        block.width,
                        block.columns.len() + 1
                    );
                    let expected =
                        format!("rows of at most {LONGEST_ROW} bytes that hold their channels");
                    return Err(self.source.wrong(at, expected, found));
                }
                block.columns.push(Column {
                    object: number,
                    slot,
                    kind: part.kind,
                    first: first as usize,
                });
            }
        }
        blocks.retain(|block| block.rows > 0 && block.width > 0);
        Ok(blocks)
    }

    /// Divides the `held` bytes of a segment, of `stated` ones, into chunks; bytes behind the last whole chunk are a shorter one.
    pub(super) fn divide(
        &self,
        segment: &mut Segment,
        held: u64,
        stated: u64,
        end: End,
    ) -> Result<(), ReadError> {
        let wrong =
            |expected: &str, found: String| Err(self.source.wrong(segment.raw, expected, found));
        let sizes = self
            .blocks
            .iter()
            .map(|block| block.rows.checked_mul(block.width));
        let sizes: Option<Vec<u64>> = sizes.collect();
        let chunk = sizes.as_ref().and_then(|sizes| {
            let mut sizes = sizes.iter();
            sizes.try_fold(0_u64, |sum, size| sum.checked_add(*size))
        });
        let (Some(chunk), Some(sizes)) = (chunk, sizes) else {
            return wrong("a possible number of samples", "more than 2⁶⁴ bytes".into());
        };
        if chunk == 0 {
            return match held {
                0 => Ok(()),
                _ => wrong("no samples, as no channel has any", format!("{held} bytes")),
            };
        }
        // The rows of each block in so many bytes, as if the last chunk held less of every channel.
        let rows_in = |bytes: u64| {
            let (whole, rest) = (u128::from(bytes / chunk), u128::from(bytes % chunk));
            let rows = self.blocks.iter().map(|block| u128::from(block.rows));
            let rows = rows.map(|rows| rows * whole + rows * rest / u128::from(chunk));
            rows.map(|rows| rows as u64).collect::<Vec<u64>>()
        };
        let stated = match end {
            End::Open => held.div_ceil(chunk).saturating_mul(chunk),
            End::Stated | End::Cut => stated,
        };
        // A chunk that is not whole is one that was stopped, unless it is the only one.
        segment.stated = rows_in(if stated > 0 { stated.max(chunk) } else { 0 });
        (segment.whole, segment.last) = match self.blocks.as_slice() {
            [only] => {
                let rest = held % only.width;
                if rest > 0 && end == End::Stated {
                    let found = format!("{rest} bytes more in {held}");
                    let expected = format!("whole rows of {} bytes", only.width);
                    return wrong(&expected, found);
                }
                if stated >= chunk {
                    segment.stated = vec![stated / only.width];
                }
                (0, vec![held / only.width])
            }
            blocks => {
                let mut rest = held % chunk;
                let mut last = rows_in(rest);
                let filled = last
                    .iter()
                    .zip(blocks)
                    .map(|(rows, block)| rows * block.width);
                if end == End::Stated && filled.sum::<u64>() != rest {
                    let found = format!("{rest} bytes behind whole ones");
                    return wrong(&format!("chunks of {chunk} bytes"), found);
                }
                if end != End::Stated {
                    // What was written first is whole.
                    for ((rows, block), size) in last.iter_mut().zip(blocks).zip(sizes) {
                        *rows = rest.min(size) / block.width;
                        rest -= rest.min(size);
                    }
                }
                (held / chunk, last)
            }
        };
        Ok(())
    }

    /// Counts the samples of a segment, and those that it lacks.
    pub(super) fn count(&mut self, segment: &Segment) {
        for (number, block) in self.blocks.iter().enumerate() {
            let behind = segment.last.get(number).copied().unwrap_or(0);
            let rows = block
                .rows
                .saturating_mul(segment.whole)
                .saturating_add(behind);
            let stated = segment.stated.get(number).copied().unwrap_or(0);
            for column in &block.columns {
                let object = &mut self.objects[column.object];
                object.slots[column.slot].count += match column.kind {
                    // Texts are counted chunk by chunk.
                    Kind::Text => rows.saturating_mul(object.texts()),
                    _ => rows,
                };
                if column.slot == 0 {
                    let missing = stated.saturating_sub(rows);
                    object.missing = object.missing.saturating_add(missing);
                }
            }
        }
    }
}
