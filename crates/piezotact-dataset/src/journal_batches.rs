//! The chunks of a journal, read from its bytes: nothing in them can be wrong without being seen.
//!
//! Arrow's own reader of streams slices a batch where its header says, and panics when a damaged header says something
//! impossible. A journal holds columns of 64-bit floats and nothing else, so that each length can be checked first.
//!
//! Source of the layout: Apache Arrow, *Encapsulated message format* and *Streaming format*.

use std::io::Read;

use crate::flat::{Message, Table};
use crate::journal::START_KEY;

/// The mark before every message.
const CONTINUATION: [u8; 4] = [0xFF; 4];
/// A header longer than this is damaged.
const LONGEST_HEADER: u64 = 64 << 20;

/// The messages of a journal.
pub(crate) struct Batches<R> {
    reader: R,
    channels: usize,
}

/// The start document of a journal as it is stored, and what follows it; the reason where there is none.
pub(crate) fn open<R: Read>(mut reader: R) -> Result<(String, Batches<R>), String> {
    let header = header(&mut reader).ok_or("a journal whose first message is incomplete")?;
    let Some(Message::Schema(schema)) = Message::of(&header) else {
        return Err("a journal that does not begin with its schema".into());
    };
    let start = schema.stored(START_KEY).map(str::to_owned);
    let start = start.ok_or("an Arrow stream without a start document")?;
    let channels = schema.columns();
    Ok((start, Batches { reader, channels }))
}

impl<R: Read> Iterator for Batches<R> {
    type Item = Vec<Vec<f64>>;

    /// The next chunk, a list of samples for each channel; `None` at the first that is not whole.
    fn next(&mut self) -> Option<Self::Item> {
        let header = header(&mut self.reader)?;
        let Some(Message::Batch { batch, body_length }) = Message::of(&header) else {
            return None;
        };
        let body = exactly(&mut self.reader, body_length)?;
        columns(batch, self.channels, &body)
    }
}

/// The header of the next message.
fn header(reader: &mut impl Read) -> Option<Vec<u8>> {
    let [mark, length] = [word(reader)?, word(reader)?];
    let length = u64::from(u32::from_le_bytes(length));
    (mark == CONTINUATION && (1..=LONGEST_HEADER).contains(&length))
        .then(|| exactly(reader, length))?
}

fn word(reader: &mut impl Read) -> Option<[u8; 4]> {
    let mut word = [0; 4];
    reader.read_exact(&mut word).ok()?;
    Some(word)
}

/// As many bytes as that, where there are as many.
fn exactly(reader: &mut impl Read, length: u64) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = reader.take(length).read_to_end(&mut bytes).ok()?;
    (read as u64 == length).then_some(bytes)
}

/// The columns of a batch of `channels` columns of 64-bit floats.
fn columns(batch: Table<'_>, channels: usize, body: &[u8]) -> Option<Vec<Vec<f64>>> {
    let (nodes, buffers) = (batch.pairs(1)?, batch.pairs(2)?);
    let compressed = batch.has(3);
    if nodes.len() != channels || buffers.len() != 2 * channels || compressed {
        return None;
    }
    let length = batch.long(0).unwrap_or(0);
    let bytes = usize::try_from(length)
        .ok()?
        .checked_mul(size_of::<f64>())?;
    (0..channels)
        .map(|channel| {
            let ([rows, nulls], [from, long]) = (nodes[channel], buffers[2 * channel + 1]);
            if rows != length || nulls != 0 {
                return None;
            }
            let (from, long) = (usize::try_from(from).ok()?, usize::try_from(long).ok()?);
            let data = body.get(from..from.checked_add(long)?)?.get(..bytes)?;
            let (numbers, _) = data.as_chunks::<8>();
            Some(numbers.iter().map(|b| f64::from_le_bytes(*b)).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A journal of the first version: any byte changed: chunks or nothing, never a panic; and what lies before it is read.
    #[test]
    fn damage_ends_the_journal_and_never_panics() {
        let whole = include_bytes!("../tests/data/v0.1.0/interrupted.parquet.part").to_vec();
        let chunks = |bytes: &[u8]| -> Option<Vec<_>> { Some(open(bytes).ok()?.1.collect()) };
        let all = chunks(&whole).unwrap();
        assert!(all.len() > 1);
        for at in (0..whole.len()).step_by(61) {
            for value in [0x00, 0x7F, 0xFF, whole[at] ^ 0x08] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let read = chunks(&bytes).unwrap_or_default();
                assert!(read.len() <= all.len(), "byte {at}");
                if at > 2 * whole.len() / 3 {
                    assert_eq!(read[0], all[0], "byte {at}");
                }
            }
        }
    }
}
