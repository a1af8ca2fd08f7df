//! TDMS files read in blocks: where the samples of every channel lie, and any stretch of them.

use std::io::{Read, Seek};
use std::path::Path;

use piezotact::recording::{Clock, Recording};

use super::convert::{chain_of, name_of, recording_of};
use super::index::Kind;
use super::layout::{Column, Segment, Walk};
use super::samples::{File, Values};
use super::source::Source;
use crate::columns::is_code;
use crate::error::ReadError;
use crate::input::open_input;
use crate::open::ReadOptions;
use crate::recording_file::Stored;
use crate::stored::ByteOrder;

/// Samples that are looked at together.
const BLOCK: u64 = 1 << 16;

/// What is known of a TDMS file that is read in blocks.
#[derive(Debug)]
pub(crate) struct TdmsBlocks {
    pub(crate) samples: usize,
    options: ReadOptions,
    file: File,
    /// Of every object and each of its slots.
    runs: Vec<Vec<Vec<Run>>>,
}

/// Rows that follow each other in pieces of one size.
#[derive(Debug)]
struct Run {
    /// The samples before it.
    first: u64,
    /// Where its first piece begins, and how far the next is from there.
    at: u64,
    stride: u64,
    /// Pieces, and the rows of each.
    pieces: u64,
    rows: u64,
    /// Bytes of a row.
    width: u64,
    column: Column,
    order: ByteOrder,
}

impl Run {
    fn end(&self) -> u64 {
        self.first + self.pieces * self.rows
    }

    /// Whether `next` goes on as this one does, which then includes it.
    fn takes(&mut self, next: &Self) -> bool {
        let stride = match self.pieces {
            1 => next.at.wrapping_sub(self.at),
            _ => self.stride,
        };
        let fits = self.rows == next.rows
            && self.width == next.width
            && self.order == next.order
            && self.column.first == next.column.first
            && self.column.kind == next.column.kind
            && next.at > self.at
            && next.at == self.at + stride * self.pieces
            && (next.pieces == 1 || next.stride == stride);
        if fits {
            self.stride = stride;
            self.pieces += next.pieces;
        }
        fits
    }
}

/// Notes where the samples of `segment` lie.
fn note<R: Read + Seek>(walk: &Walk<'_, R>, segment: &Segment, runs: &mut Vec<Vec<Vec<Run>>>) {
    runs.resize_with(walk.objects.len(), Vec::new);
    for (object, runs) in walk.objects.iter().zip(runs.iter_mut()) {
        runs.resize_with(object.slots.len(), Vec::new);
    }
    let chunk = walk.blocks.iter().map(|block| block.rows * block.width);
    let chunk = chunk.sum::<u64>();
    let (mut whole, mut last) = (segment.raw, segment.raw + segment.whole * chunk);
    for (number, block) in walk.blocks.iter().enumerate() {
        let behind = segment.last.get(number).copied().unwrap_or(0);
        let parts = [(whole, segment.whole, block.rows), (last, 1, behind)];
        whole += block.rows * block.width;
        last += behind * block.width;
        for column in &block.columns {
            let runs = &mut runs[column.object][column.slot];
            for (at, pieces, rows) in parts {
                let next = Run {
                    first: runs.last().map_or(0, Run::end),
                    at,
                    stride: chunk,
                    pieces,
                    rows,
                    width: block.width,
                    column: column.clone(),
                    order: segment.order,
                };
                let is_empty = pieces == 0 || rows == 0;
                if !is_empty && !runs.last_mut().is_some_and(|run| run.takes(&next)) {
                    runs.push(next);
                }
            }
        }
    }
}

impl TdmsBlocks {
    /// The file at `path` where its samples take more than `beyond_bytes`, and the recording without them; `None` where it is read whole.
    pub(crate) fn of(
        path: &Path,
        options: &ReadOptions,
        beyond_bytes: u64,
    ) -> Result<Option<(Self, Stored)>, ReadError> {
        let mut walk = Walk::new(Source::new(path, open_input(path)?)?);
        let mut runs = Vec::new();
        while let Some(segment) = walk.advance()? {
            note(&walk, &segment, &mut runs);
            walk.count(&segment);
        }
        let file = File {
            objects: walk.objects,
            is_cut: walk.is_cut,
            is_interrupted: walk.is_interrupted,
        };
        let slots = file.objects.iter().flat_map(|object| &object.slots);
        let samples = slots.clone().map(|slot| slot.count).max().unwrap_or(0);
        let bytes = slots.clone().map(|slot| slot.count.saturating_mul(8));
        let bytes = bytes.fold(0, u64::saturating_add);
        let are_alike = slots.clone().all(|slot| {
            let kind = matches!(slot.kind, Kind::Number(_) | Kind::Truth | Kind::Bit(..));
            slot.count == 0 || slot.count == samples && kind
        });
        let is_whole = file.objects.iter().all(|object| object.missing == 0);
        if bytes <= beyond_bytes
            || samples == 0
            || !(are_alike && is_whole)
            || file.is_cut
            || file.is_interrupted
        {
            return Ok(None);
        }
        let blocks = Self {
            samples: samples as usize,
            options: options.clone(),
            file,
            runs,
        };
        let all: Vec<usize> = (0..blocks.file.objects.len()).collect();
        let values = blocks.values(&mut blocks.source(path)?, &all, 0..samples.min(BLOCK))?;
        let first = recording_of(path, &blocks.file, values, options)?;
        let names = (0..all.len()).filter(|number| blocks.holds(*number));
        let names: Vec<String> = names.filter_map(|number| blocks.name(number)).collect();
        let mut channels = first.channels().iter();
        // A channel that is none of the recording holds its times, which are needed as a whole, or is left out.
        let is_plain = names.len() == first.channels().len()
            && first.clocks() == [Clock::at(first.rate())]
            && first.about.provenance.losses.stretches_s.is_empty()
            && channels.all(|channel| names.contains(&channel.name));
        if !is_plain || blocks.needs_all(path)? {
            return Ok(None);
        }
        Ok(Some((blocks, without_samples(path, &first)?.into())))
    }

    fn source<'p>(&self, path: &'p Path) -> Result<Source<'p, std::fs::File>, ReadError> {
        Source::new(path, open_input(path)?)
    }

    fn name(&self, number: usize) -> Option<String> {
        let channel = self.file.objects[number].channel.as_ref()?;
        Some(name_of(&self.file.objects, number, channel))
    }

    fn holds(&self, number: usize) -> bool {
        let mut slots = self.file.objects[number].slots.iter();
        slots.any(|slot| slot.count > 0)
    }

    /// Whether a scale has ends, or a sample is a code for no data: all samples of the channel decide what they are.
    fn needs_all(&self, path: &Path) -> Result<bool, ReadError> {
        let mut source = self.source(path)?;
        for number in 0..self.file.objects.len() {
            let object = &self.file.objects[number];
            let chain = match chain_of(&self.file.objects, object) {
                Ok(chain) if self.holds(number) => chain,
                _ => continue,
            };
            if chain.as_ref().is_some_and(|chain| chain.has_a_table()) {
                return Ok(true);
            }
            // So narrow numbers are no codes.
            let is_narrow = |kind: Kind| match kind {
                Kind::Number(number) => number.width() <= 2,
                kind => matches!(kind, Kind::Truth | Kind::Bit(..)),
            };
            if chain.is_none() && object.slots.iter().all(|slot| is_narrow(slot.kind)) {
                continue;
            }
            let mut from = 0;
            while from < self.samples as u64 {
                let to = (from + BLOCK).min(self.samples as u64);
                let mut values = self.values(&mut source, &[number], from..to)?;
                let slots = values.swap_remove(number).into_iter();
                let slots: Vec<Vec<f64>> = slots.map(|values| values.numbers).collect();
                let numbers = match &chain {
                    Some(chain) => chain.apply(slots).0,
                    None => slots.into_iter().flatten().collect(),
                };
                if numbers.into_iter().any(is_code) {
                    return Ok(true);
                }
                from = to;
            }
        }
        Ok(false)
    }

    /// The stored numbers of these samples of the `objects`; of the others none.
    fn values(
        &self,
        source: &mut Source<'_, std::fs::File>,
        objects: &[usize],
        samples: std::ops::Range<u64>,
    ) -> Result<Vec<Vec<Values>>, ReadError> {
        let mut all: Vec<Vec<Values>> = Vec::with_capacity(self.runs.len());
        for (number, slots) in self.runs.iter().enumerate() {
            let mut of = Vec::with_capacity(slots.len());
            for runs in slots {
                let mut values = Values::default();
                if objects.contains(&number) {
                    let length = samples.end - samples.start;
                    values.numbers.reserve_exact(length as usize);
                    read(source, runs, &samples, &mut values)?;
                }
                of.push(values);
            }
            all.push(of);
        }
        Ok(all)
    }

    /// Gives the samples of the `channels` to `take`, in recordings of `block` samples at most.
    pub(crate) fn each<E: From<ReadError>>(
        &self,
        path: &Path,
        channels: &[&str],
        block: usize,
        take: &mut dyn FnMut(Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let is_wanted = |number: &usize| {
            let name = self.name(*number);
            name.is_some_and(|name| channels.contains(&name.as_str())) && self.holds(*number)
        };
        let wanted: Vec<usize> = (0..self.runs.len()).filter(is_wanted).collect();
        let mut objects = self.file.objects.clone();
        for (number, object) in objects.iter_mut().enumerate() {
            if !wanted.contains(&number) {
                object.slots.iter_mut().for_each(|slot| slot.count = 0);
            }
        }
        let file = File {
            objects,
            is_cut: false,
            is_interrupted: false,
        };
        let mut source = self.source(path)?;
        let (mut from, all) = (0, self.samples as u64);
        while from < all {
            let to = (from + block as u64).min(all);
            let values = self.values(&mut source, &wanted, from..to)?;
            take(recording_of(path, &file, values, &self.options)?)?;
            from = to;
        }
        Ok(())
    }
}

/// Appends the `samples` that lie in `runs`.
fn read<R: Read + Seek>(
    source: &mut Source<'_, R>,
    runs: &[Run],
    samples: &std::ops::Range<u64>,
    to: &mut Values,
) -> Result<(), ReadError> {
    let first = runs.partition_point(|run| run.end() <= samples.start);
    for run in runs[first..]
        .iter()
        .take_while(|run| run.first < samples.end)
    {
        let mut piece = samples.start.saturating_sub(run.first) / run.rows;
        while piece < run.pieces && run.first + piece * run.rows < samples.end {
            let begins = run.first + piece * run.rows;
            let from = samples.start.max(begins) - begins;
            let until = (samples.end - begins).min(run.rows);
            source.seek(run.at + piece * run.stride + from * run.width)?;
            let width = run.width as usize;
            source.rows((until - from) * run.width, width, |rows| {
                run.column.append(rows, width, run.order, to);
            })?;
            piece += 1;
        }
    }
    Ok(())
}

/// `recording` with channels of no samples.
fn without_samples(path: &Path, recording: &Recording) -> Result<Recording, ReadError> {
    let channels = recording.channels().iter();
    let channels = channels.map(|channel| piezotact::recording::Channel {
        name: channel.name.clone(),
        unit: channel.unit.clone(),
        samples: Vec::new(),
    });
    let about = recording.about.clone();
    let empty = Recording::on_clocks(channels.collect(), recording.rate(), &[], about);
    let mut empty = empty.map_err(ReadError::of(path))?;
    empty.annotations = recording.annotations.clone();
    Ok(empty)
}
