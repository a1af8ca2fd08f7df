//! The chunks of a journal, read from its bytes: nothing in them can be wrong without being seen.
//!
//! Arrow's own reader of streams slices a batch where its header says, and panics when a damaged header says something
//! impossible. A journal holds columns of 64-bit floats and nothing else, so that each length can be checked first.
//!
//! Source of the layout: Apache Arrow, *Encapsulated message format* and *Streaming format*.

use std::io::Read;

use arrow_ipc::{Message, root_as_message};

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
    let header = header(&mut reader).ok_or("a journal whose first message is not whole")?;
    let message = root_as_message(&header).map_err(|error| error.to_string())?;
    let schema = message
        .header_as_schema()
        .ok_or("a journal that does not begin with its schema")?;
    let stored = schema.custom_metadata().and_then(|pairs| {
        let start = pairs.iter().find(|pair| pair.key() == Some(START_KEY))?;
        Some(start.value()?.to_owned())
    });
    let start = stored.ok_or("an Arrow stream without a start document")?;
    let channels = schema.fields().map_or(0, |fields| fields.len());
    Ok((start, Batches { reader, channels }))
}

impl<R: Read> Iterator for Batches<R> {
    type Item = Vec<Vec<f64>>;

    /// The next chunk, a list of samples for each channel; `None` at the first that is not whole.
    fn next(&mut self) -> Option<Self::Item> {
        let header = header(&mut self.reader)?;
        let message = root_as_message(&header).ok()?;
        let length = u64::try_from(message.bodyLength()).ok()?;
        let body = exactly(&mut self.reader, length)?;
        columns(message, self.channels, &body)
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
fn columns(message: Message<'_>, channels: usize, body: &[u8]) -> Option<Vec<Vec<f64>>> {
    let batch = message.header_as_record_batch()?;
    let (nodes, buffers) = (batch.nodes()?, batch.buffers()?);
    if nodes.len() != channels || buffers.len() != 2 * channels || batch.compression().is_some() {
        return None;
    }
    let rows = usize::try_from(batch.length()).ok()?;
    let bytes = rows.checked_mul(size_of::<f64>())?;
    (0..channels)
        .map(|channel| {
            let (node, buffer) = (nodes.get(channel), buffers.get(2 * channel + 1));
            if node.length() != batch.length() || node.null_count() != 0 {
                return None;
            }
            let [from, length] = [buffer.offset(), buffer.length()].map(usize::try_from);
            let (from, length) = (from.ok()?, length.ok()?);
            let data = body.get(from..from.checked_add(length)?)?.get(..bytes)?;
            let (numbers, _) = data.as_chunks::<8>();
            Some(numbers.iter().map(|b| f64::from_le_bytes(*b)).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::{JournalWriter, StartDocument, journal_path};
    use piezotact::quantity::{SampleRate, Unit};
    use piezotact::recording::{Annotations, Condition, Provenance};

    /// Any byte changed to any value: chunks or nothing, never a panic; and what lies before it is read.
    #[test]
    fn damage_ends_the_journal_and_never_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet");
        let start = StartDocument {
            format: StartDocument::FORMAT,
            rate_hz: SampleRate::new(100.0).unwrap(),
            channels: vec![("a".into(), Unit::Newton), ("b".into(), Unit::Volt)],
            condition: Condition::default(),
            provenance: Provenance::default(),
            annotations: Annotations::default(),
            setup: None,
            rendering: None,
        };
        let mut writer = JournalWriter::create(&path, start).unwrap();
        let journal = journal_path(&path);
        let first = std::fs::metadata(&journal).unwrap().len() as usize;
        writer
            .append(&[vec![1.0, 2.0, 3.0], vec![-1.0, -2.0, -3.0]])
            .unwrap();
        let second = std::fs::metadata(&journal).unwrap().len() as usize;
        writer.append(&[vec![4.0], vec![-4.0]]).unwrap();
        drop(writer);
        let whole = std::fs::read(&journal).unwrap();
        let chunks = |bytes: &[u8]| -> Option<Vec<_>> { Some(open(bytes).ok()?.1.collect()) };
        let all = chunks(&whole).unwrap();
        assert_eq!(
            all,
            [
                vec![vec![1.0, 2.0, 3.0], vec![-1.0, -2.0, -3.0]],
                vec![vec![4.0], vec![-4.0]]
            ]
        );
        for at in 0..whole.len() {
            for value in [0x00, 0x01, 0x7F, 0x80, 0xFF, whole[at] ^ 0x08] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let read = chunks(&bytes);
                if at >= second {
                    assert_eq!(read.unwrap()[0], all[0], "byte {at}");
                } else if at >= first {
                    assert!(read.is_some(), "byte {at}");
                }
            }
        }
    }
}
