//! The journal of a run on disk: a sequence of blocks that can be read independently.
//!
//! Layout: 8 bytes `PZRUN\x01\r\n`, the sixth of which is the format, then blocks of 4 bytes `PZBK`, one byte for the kind, the length of the content (u32), the
//! CRC-32 of kind, length and content (u32), and the content; numbers are little-endian. Kinds: `S` start document (JSON;
//! it stands there twice, so that one damaged byte does not take it), `C` samples (index of the first, u64; samples lost before it, u64; device time
//! in s, f64, NaN where there is none; number of channels, u32; samples of each, u32; then f64, channel after channel), `J` what was judged
//! (JSON), `V` an event (JSON), `E` end document (JSON); `G` samples as `C`, with the number of their clock (u32) before, where it is
//! not the first.

use piezotact::recording::Event;
use piezotact::run::{Judged, RunChunk};

/// What a journal begins with.
pub(super) const MAGIC: [u8; 8] = *b"PZRUN\x01\r\n";
/// Where in it the format stands.
const FORMAT_AT: usize = 5;
/// The newest format of blocks that this program reads, and the one that it writes.
pub(super) const FORMAT: u8 = MAGIC[FORMAT_AT];
const SYNC: [u8; 4] = *b"PZBK";
const HEADER: usize = SYNC.len() + 1 + 4 + 4;

/// One block's content.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Block {
    /// The start document, as text.
    Start(String),
    /// Samples.
    Chunk(RunChunk),
    /// A judgement.
    Judged(Judged),
    /// Something that happened.
    Event(Event),
    /// The end document, as text.
    End(String),
}

/// The bytes of one block.
pub(super) fn block_bytes(block: &Block) -> Result<Vec<u8>, serde_json::Error> {
    let (kind, content) = match block {
        Block::Start(text) => (b'S', text.clone().into_bytes()),
        Block::Chunk(chunk) if chunk.clock > 0 => {
            let clock = chunk.clock.to_le_bytes();
            (b'G', [&clock[..], &chunk_bytes(chunk)].concat())
        }
        Block::Chunk(chunk) => (b'C', chunk_bytes(chunk)),
        Block::Event(event) => (b'V', serde_json::to_vec(event)?),
        Block::Judged(judged) => (b'J', serde_json::to_vec(judged)?),
        Block::End(text) => (b'E', text.clone().into_bytes()),
    };
    let length = (content.len() as u32).to_le_bytes();
    let mut bytes = Vec::with_capacity(HEADER + content.len());
    bytes.extend(SYNC);
    bytes.push(kind);
    bytes.extend(length);
    bytes.extend(checksum(kind, length, &content).to_le_bytes());
    bytes.extend(content);
    Ok(bytes)
}

fn checksum(kind: u8, length: [u8; 4], content: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&[kind]);
    hasher.update(&length);
    hasher.update(content);
    hasher.finalize()
}

fn chunk_bytes(chunk: &RunChunk) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(32 + 8 * chunk.channels.len() * chunk.len());
    bytes.extend(chunk.first.to_le_bytes());
    bytes.extend(chunk.lost.to_le_bytes());
    bytes.extend(chunk.device_s.unwrap_or(f64::NAN).to_le_bytes());
    bytes.extend((chunk.channels.len() as u32).to_le_bytes());
    bytes.extend((chunk.len() as u32).to_le_bytes());
    for sample in chunk.channels.iter().flatten() {
        bytes.extend(sample.to_le_bytes());
    }
    bytes
}

fn chunk_of(content: &[u8]) -> Option<RunChunk> {
    let (head, samples) = content.split_at_checked(32)?;
    let word = |at: usize| head.get(at..at + 8)?.try_into().ok();
    let half = |at: usize| {
        head.get(at..at + 4)?
            .try_into()
            .ok()
            .map(u32::from_le_bytes)
    };
    let device_s = f64::from_le_bytes(word(16)?);
    let (channels, count) = (half(24)? as usize, half(28)? as usize);
    if samples.len() != channels.checked_mul(count)?.checked_mul(8)? {
        return None;
    }
    let (samples, _) = samples.as_chunks::<8>();
    let of_channel = |channel: usize| {
        let its_own = samples[channel * count..][..count].iter();
        its_own.map(|bytes| f64::from_le_bytes(*bytes)).collect()
    };
    Some(RunChunk {
        first: u64::from_le_bytes(word(0)?),
        lost: u64::from_le_bytes(word(8)?),
        device_s: Some(device_s).filter(|time| !time.is_nan()),
        clock: 0,
        channels: (0..channels).map(of_channel).collect(),
    })
}

/// What is read of a journal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Blocks {
    /// The blocks that are whole, in their order.
    pub(super) blocks: Vec<Block>,
    /// How many stretches of bytes between whole blocks are no whole block.
    pub(super) damaged: usize,
    /// Whether the last block is cut short, as it is when the program was killed while writing it.
    pub(super) cut: bool,
}

/// Whether bytes begin as a journal does, of whatever format; one byte may be damaged.
pub(super) fn looks_like_journal(head: &[u8]) -> bool {
    head.len() >= MAGIC.len() && differing(head) <= 1
}

/// How many bytes differ from what a journal begins with, whatever its format.
fn differing(head: &[u8]) -> usize {
    let pairs = head.iter().zip(MAGIC).enumerate();
    pairs
        .filter(|(at, (found, expected))| *at != FORMAT_AT && *found != expected)
        .count()
}

/// What the first bytes of a journal say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Header {
    /// The format that is written.
    Ours,
    /// Another format.
    Format(u8),
    /// Something else.
    Damaged,
}

impl Header {
    /// What the first of `bytes` say.
    pub(super) fn of(bytes: &[u8]) -> Self {
        match bytes.get(FORMAT_AT) {
            _ if differing(bytes) > 0 => Self::Damaged,
            Some(format) if *format != FORMAT => Self::Format(*format),
            _ => Self::Ours,
        }
    }
}

/// All whole blocks in the bytes of a journal.
pub(super) fn blocks_of(bytes: &[u8]) -> Blocks {
    let mut found = Blocks::default();
    let mut at = MAGIC.len().min(bytes.len());
    let mut in_damage = false;
    while at < bytes.len() {
        if let Some((block, length)) = block_at(&bytes[at..]) {
            found.blocks.push(block);
            found.damaged += usize::from(in_damage);
            in_damage = false;
            at += length;
        } else {
            in_damage = true;
            // The next place where a block may begin.
            let next = bytes[at + 1..]
                .windows(SYNC.len())
                .position(|window| window == SYNC);
            at = next.map_or(bytes.len(), |next| at + 1 + next);
        }
    }
    found.cut = in_damage;
    found
}

fn block_at(bytes: &[u8]) -> Option<(Block, usize)> {
    let (header, rest) = bytes.split_at_checked(HEADER)?;
    let kind = header[4];
    let length: [u8; 4] = header[5..9].try_into().ok()?;
    let stored = u32::from_le_bytes(header[9..13].try_into().ok()?);
    let content = rest.get(..u32::from_le_bytes(length) as usize)?;
    if header[..4] != SYNC || checksum(kind, length, content) != stored {
        return None;
    }
    let text = || String::from_utf8(content.to_vec()).ok();
    let block = match kind {
        b'S' => Block::Start(text()?),
        b'C' => Block::Chunk(chunk_of(content)?),
        b'G' => {
            let (clock, content) = content.split_at_checked(4)?;
            Block::Chunk(RunChunk {
                clock: u32::from_le_bytes(clock.try_into().ok()?),
                ..chunk_of(content)?
            })
        }
        b'V' => Block::Event(serde_json::from_slice(content).ok()?),
        b'J' => Block::Judged(serde_json::from_slice(content).ok()?),
        b'E' => Block::End(text()?),
        _ => return None,
    };
    Some((block, HEADER + content.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal() -> (Vec<u8>, Vec<Block>) {
        let start = Block::Start("{\"channels\":[]}".into());
        let mut blocks = vec![start.clone(), start];
        for second in 0..4_u64 {
            blocks.push(Block::Chunk(RunChunk {
                first: 50 * second,
                device_s: (second > 0).then_some(second as f64),
                lost: 0,
                clock: u32::from(second == 2),
                channels: vec![vec![second as f64; 50], vec![-1.5; 50]],
            }));
        }
        blocks.push(Block::End("{}".into()));
        let mut bytes = MAGIC.to_vec();
        for block in &blocks {
            bytes.extend(block_bytes(block).unwrap());
        }
        (bytes, blocks)
    }

    #[test]
    fn what_is_written_is_read() {
        let (bytes, blocks) = journal();
        assert!(looks_like_journal(&bytes));
        let read = blocks_of(&bytes);
        assert_eq!(read.blocks, blocks);
        assert_eq!((read.damaged, read.cut), (0, false));
    }

    #[test]
    fn a_flipped_byte_costs_one_block() {
        let (whole, blocks) = journal();
        for at in MAGIC.len()..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x41;
            let read = blocks_of(&bytes);
            assert_eq!(read.blocks.len() + 1, blocks.len(), "byte {at}");
            assert!(read.damaged == 1 || read.cut, "byte {at}");
            let start = |b: &Block| matches!(b, Block::Start(_));
            assert!(read.blocks.iter().any(start), "byte {at}");
        }
        let mut first = whole.clone();
        first[3] = 0;
        assert!(looks_like_journal(&first) && blocks_of(&first).blocks == blocks);
    }

    #[test]
    fn a_cut_costs_the_last_block() {
        let (whole, blocks) = journal();
        for length in MAGIC.len()..whole.len() {
            let read = blocks_of(&whole[..length]);
            assert_eq!(read.blocks[..], blocks[..read.blocks.len()], "{length}");
            assert_eq!(read.damaged, 0, "{length}");
        }
    }
}
