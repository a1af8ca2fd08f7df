//! Reads the journals of runs, including incomplete and damaged ones.

use piezotact::recording::{Clock, LostBy, RecordingWarning};
use std::fs::File;
use std::io::{BufReader, Error, ErrorKind, Read as _};
use std::path::Path;

use piezotact::Warning;
use piezotact::run::RunChunk;
use piezotact::series::filled;

use super::frames::{Block, Blocks, FORMAT, Header, MAGIC, blocks_of, looks_like_journal};
use super::{EndDocument, StartDocument};
use crate::error::ReadError;
use crate::recording_file::{Stored, assemble};

/// Whether bytes begin as the journal of a run does.
pub(crate) fn is_journal(head: &[u8]) -> bool {
    looks_like_journal(head)
}

/// Reads a journal as far as possible, with warnings about an interruption and about damage. Damaged blocks are replaced by
/// straight lines, so that the following samples keep their times.
pub(crate) fn read_run_journal(path: &Path) -> Result<Stored, ReadError> {
    let bytes = crate::input::read_input(path)?;
    let Blocks {
        blocks,
        damaged: damages,
        ..
    } = blocks_of(&bytes);
    let header = Header::of(&bytes);
    let mut start = start_document(path, &blocks, header, damages)?;
    let mut samples = ClockedSamples::of(&start);
    let mut events = Vec::new();
    let mut end = None;
    for block in blocks {
        match block {
            Block::Start(_) | Block::Judged(_) => {}
            Block::Event(event) => events.push(event),
            Block::Chunk(chunk) => {
                let added = samples.add(chunk);
                added.map_err(|found| damaged(path, found))?;
            }
            // The checksum says that the block is whole: what cannot be read in it was written by another version.
            Block::End(text) => {
                let stored: Result<(StartDocument, EndDocument), _> = serde_json::from_str(&text);
                end = Some(stored.map_err(|error| of_another_version(path, &error))?);
            }
        }
    }
    let whole = end.is_some();
    let mut warnings = Vec::new();
    if let Some((at_end, end)) = end {
        start = at_end;
        (warnings, events) = (end.warnings, end.events);
    }
    // A block that is missing altogether leaves a gap and no damage.
    let damages = (damages + usize::from(header == Header::Damaged)).max(samples.lost_s.len());
    let (samples, lost) = samples.in_order();
    let mut recording = assemble(path, &start, samples)?;
    recording.annotations.events.extend(events);
    let losses = &mut recording.about.provenance.losses;
    losses.stretches_s.extend(&lost);
    losses.is_interrupted = !whole;
    recording.about.warnings = warnings;
    recording.about.warnings.extend((damages > 0).then(|| {
        Warning::from(RecordingWarning::SamplesLost {
            by: LostBy::Journal {
                places: damages,
                lost_s: lost,
            },
        })
    }));
    if let Header::Format(found) = header {
        recording
            .about
            .warnings
            .push(Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::JournalHeader {
                    found: found.into(),
                    read_as: FORMAT.into(),
                },
            }));
    }
    if !whole {
        recording
            .about
            .warnings
            .push(Warning::from(RecordingWarning::Interrupted {
                read_s: recording.duration().0,
            }));
    }
    Ok(Stored {
        recording,
        setup: start.setup,
        rendering: start.rendering,
        played: start.drive,
        samples: None,
    })
}

fn damaged(path: &Path, found: &str) -> ReadError {
    ReadError::content(
        path,
        "the journal of a recording",
        found,
        "it was interrupted before its first block, or is damaged: nothing can be read from it",
    )
}

fn newer(path: &Path, found: u32) -> ReadError {
    ReadError::content(
        path,
        format!("a journal of format {FORMAT} or before, which is what this version reads"),
        format!("format {found}"),
        "read it with a newer version of the program",
    )
}

/// The start document among `blocks`, which has to be of a format that is known.
fn start_document(
    path: &Path,
    blocks: &[Block],
    header: Header,
    damages: usize,
) -> Result<StartDocument, ReadError> {
    let unreadable = |found: &str| match header {
        Header::Format(format) if format > FORMAT => newer(path, format.into()),
        _ => damaged(path, found),
    };
    let start = blocks.iter().find_map(|block| match block {
        Block::Start(text) => Some(text),
        _ => None,
    });
    let start: StartDocument = start
        .ok_or_else(|| unreadable("one without a start document"))
        .and_then(|text| {
            serde_json::from_str(text).map_err(|error| {
                unreadable(&format!("a start document that cannot be read ({error})"))
            })
        })?;
    if start.format > StartDocument::FORMAT_WITH_CLOCKS {
        return Err(newer(path, start.format));
    }
    // A block that is unknown to this format may belong to a newer one.
    if let Header::Format(format) = header
        && format > FORMAT
        && damages > 0
    {
        return Err(newer(path, format.into()));
    }
    Ok(start)
}

/// The samples of a journal by sampling clock, with straight lines in place of lost ones.
struct ClockedSamples {
    clocks: Vec<Clock>,
    /// The clock of each channel.
    clock_of: Vec<usize>,
    /// For each clock, the samples of its channels.
    by_clock: Vec<Vec<Vec<f64>>>,
    lost_s: Vec<[f64; 2]>,
}

impl ClockedSamples {
    fn of(start: &StartDocument) -> Self {
        let (mut clocks, mut clock_of) = Clock::numbered(&start.clocks);
        if clocks.is_empty() {
            clocks.push(Clock::at(start.rate_hz));
            clock_of = vec![0; start.channels.len()];
        }
        let channels_of = |clock| clock_of.iter().filter(|of| **of == clock).count();
        let by_clock = (0..clocks.len())
            .map(|clock| vec![Vec::new(); channels_of(clock)])
            .collect();
        Self {
            clocks,
            clock_of,
            by_clock,
            lost_s: Vec::new(),
        }
    }

    /// Adds the samples of `chunk`, or says what is damaged.
    fn add(&mut self, chunk: RunChunk) -> Result<(), &'static str> {
        let number = chunk.clock as usize;
        let (Some(samples), Some(clock)) = (self.by_clock.get_mut(number), self.clocks.get(number))
        else {
            return Err("samples of a sampling clock that its start document does not define");
        };
        let have = samples.first().map_or(0, Vec::len) as u64;
        if chunk.channels.len() != samples.len() || chunk.first < have {
            return Err("blocks that are not in sequence");
        }
        if chunk.first > have {
            let mut gaps = Vec::new();
            fill(samples, &chunk, &mut gaps).ok_or("a gap longer than the recording")?;
            let at_s = |at: u64| clock.start_s.0 + at as f64 / clock.rate_hz.hz();
            self.lost_s.extend(
                gaps.iter()
                    .map(|(first, count)| [*first, first + count].map(at_s)),
            );
        }
        for (channel, new) in samples.iter_mut().zip(chunk.channels) {
            channel.extend(new);
        }
        Ok(())
    }

    /// The samples of the channels in their order, and the lost stretches.
    fn in_order(self) -> (Vec<Vec<f64>>, Vec<[f64; 2]>) {
        let mut by_clock: Vec<_> = self.by_clock.into_iter().map(Vec::into_iter).collect();
        let samples = self
            .clock_of
            .iter()
            .filter_map(|clock| by_clock[*clock].next())
            .collect();
        (samples, self.lost_s)
    }
}

/// The error about an end document that is whole and cannot be read.
fn of_another_version(path: &Path, error: &serde_json::Error) -> ReadError {
    let version = env!("CARGO_PKG_VERSION");
    ReadError::content(
        path,
        format!("the journal of a recording with an end document that version {version} reads"),
        format!("one of another version ({error})"),
        format!(
            "read it with the version that recorded it, or record again with version {version}"
        ),
    )
}

/// So many samples of each channel are filled in for damaged blocks between two whole ones at most; more is no gap: half an hour
/// at 5 kHz.
const MOST_FILLED_SAMPLES: u64 = 10_000_000;

/// Draws straight lines from the last samples to those of `next`.
fn fill(samples: &mut [Vec<f64>], next: &RunChunk, lost: &mut Vec<(u64, u64)>) -> Option<()> {
    let have = samples.first().map_or(0, Vec::len) as u64;
    let missing = next.first - have;
    if missing > MOST_FILLED_SAMPLES {
        return None;
    }
    for (channel, new) in samples.iter_mut().zip(&next.channels) {
        let to = new.first().copied().unwrap_or(0.0);
        let from = channel.last().copied().unwrap_or(to);
        channel.extend(filled([from, to], missing));
    }
    lost.push((have, missing));
    Some(())
}

/// The chunks of a journal that this program has just written, one after the other, without holding them all.
pub(super) fn chunks_of(file: File) -> impl Iterator<Item = Result<RunChunk, Error>> {
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let mut begun = false;
    std::iter::from_fn(move || {
        loop {
            let mut next = || -> Result<Option<Vec<u8>>, Error> {
                if !begun {
                    begun = true;
                    reader.read_exact(&mut [0; MAGIC.len()])?;
                }
                let mut header = [0; 13];
                if let Err(error) = reader.read_exact(&mut header) {
                    return match error.kind() {
                        ErrorKind::UnexpectedEof => Ok(None),
                        _ => Err(error),
                    };
                }
                let length = u32::from_le_bytes([header[5], header[6], header[7], header[8]]);
                let mut bytes = [&MAGIC[..], &header].concat();
                let mut content = reader.by_ref().take(length.into());
                content.read_to_end(&mut bytes)?;
                Ok(Some(bytes))
            };
            let bytes = match next() {
                Ok(Some(bytes)) => bytes,
                Ok(None) => return None,
                Err(error) => return Some(Err(error)),
            };
            match blocks_of(&bytes).blocks.pop() {
                Some(Block::Chunk(chunk)) => return Some(Ok(chunk)),
                Some(_) => {}
                None => {
                    return Some(Err(Error::new(
                        ErrorKind::InvalidData,
                        "the journal on the disk is not what was written to it",
                    )));
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use piezotact::quantity::{SampleRate, Unit};
    use piezotact::recording::{About, Annotations, BrokenPlayback, Losses};

    use super::super::frames::block_bytes;
    use super::*;

    fn start() -> StartDocument {
        StartDocument {
            format: StartDocument::FORMAT,
            rate_hz: SampleRate::new(100.0).unwrap(),
            channels: vec![("acc".into(), Unit::MetrePerSecondSquared)],
            about: About::default(),
            annotations: Annotations::default(),
            clocks: Vec::new(),
            setup: None,
            rendering: None,
            label: None,
            drive: None,
        }
    }

    fn chunk(first: u64) -> Block {
        Block::Chunk(RunChunk {
            first,
            channels: vec![(0..100).map(f64::from).collect()],
            ..RunChunk::default()
        })
    }

    /// A journal whose end document was written, but that did not become a Parquet file.
    fn ended(path: &Path, end: &str) -> Result<Stored, ReadError> {
        let begun = serde_json::to_string(&start()).unwrap();
        let blocks = [
            Block::Start(begun.clone()),
            chunk(0),
            chunk(150),
            Block::End(end.replace("START", &begun)),
        ];
        let mut bytes = MAGIC.to_vec();
        for block in &blocks {
            bytes.extend(block_bytes(block).unwrap());
        }
        std::fs::write(path, bytes).unwrap();
        read_run_journal(path)
    }

    /// Warnings without a sentence are of an earlier version. Such a recording ended, and is not read as an interrupted one.
    #[test]
    fn an_end_document_of_another_version_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet.part");
        for key in ["doubts", "warnings"] {
            let earlier = format!(r#"[START, {{"samples": 250, "{key}": [{{"code": "x"}}]}}]"#);
            let said = ended(&path, &earlier).err().unwrap().to_string();
            for part in ["r.parquet.part", env!("CARGO_PKG_VERSION"), "record again"] {
                assert!(said.contains(part), "no `{part}` in {said}");
            }
        }
    }

    #[test]
    fn what_a_damaged_journal_lost_is_stated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.parquet.part");
        let whole = ended(&path, r#"[START, {"samples": 250}]"#).ok().unwrap();
        let losses = whole.recording.about.provenance.losses;
        assert_eq!(losses.stretches_s, [[1.0, 1.5]]);
        assert!(!losses.is_interrupted && losses.samples == 0);
        let losses = Losses {
            samples: 3,
            playback: Some(BrokenPlayback {
                played: 1,
                expected: 2,
                underruns: 3,
            }),
            ..losses
        };
        let text = serde_json::to_string(&losses).unwrap();
        assert_eq!(serde_json::from_str::<Losses>(&text).unwrap(), losses);
    }
}
