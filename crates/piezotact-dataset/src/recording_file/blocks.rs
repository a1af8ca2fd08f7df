//! Parquet files read in blocks: ours, and even tables of other programs.

use std::path::Path;

use piezotact::quantity::SampleRate;
use piezotact::recording::{Recording, StartTime};

use super::{Documents, Stored, column_of, later_recording, opened};
use crate::columns::{Column, Table, is_code};
use crate::error::ReadError;
use crate::journal::{Fingerprint, START_KEY, StartDocument, UNIT_KEY};
use crate::open::ReadOptions;
use crate::parquet_file::{Columns, Reader, damaged};
use crate::reads::is_there;
use crate::sidecar::sidecar_path;
use crate::time_column::{EvenTimes, is_time};

/// Codes for no data are not below this.
const LEAST_CODE: f64 = 1e6;
/// Rows that are looked at together.
const BLOCK: usize = 1 << 16;

/// What is known of a Parquet file that is read in blocks.
#[derive(Debug)]
pub(crate) struct ParquetBlocks {
    pub(crate) samples: usize,
    of: Of,
}

#[derive(Debug)]
enum Of {
    Us {
        start: Box<StartDocument>,
        fingerprint: Option<u64>,
    },
    /// A table of these columns, each with its number in the file.
    Another {
        columns: Vec<(usize, Column)>,
        options: ReadOptions,
    },
}

impl ParquetBlocks {
    /// The file at `path` where its samples take more than `beyond_bytes`, and the recording without them; `None` where it is read whole.
    pub(crate) fn of(
        path: &Path,
        options: &ReadOptions,
        beyond_bytes: u64,
    ) -> Result<Option<(Self, Stored)>, ReadError> {
        let reader = opened(path)?;
        let samples = reader.count();
        let bytes = samples as u64 * 8 * reader.columns_with(UNIT_KEY).len() as u64;
        if samples == 0 || bytes <= beyond_bytes {
            return Ok(None);
        }
        match reader.stored(START_KEY) {
            Some(_) => ours(path, &reader, options),
            None => of_another(path, &reader, options),
        }
    }

    /// Gives the samples of the `channels` to `take`, in recordings of `block` samples at most.
    pub(crate) fn each<E: From<ReadError>>(
        &self,
        path: &Path,
        channels: &[&str],
        block: usize,
        take: &mut dyn FnMut(Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let reader = opened(path)?;
        if reader.count() != self.samples {
            return Err(damaged(path, &"it changed while it was read").into());
        }
        let is_wanted = |name: &String| channels.contains(&name.as_str());
        match &self.of {
            Of::Us { start, fingerprint } => {
                let names = start.channels.iter().map(|(name, _)| name);
                let numbers: Vec<usize> = (names.enumerate())
                    .filter(|(_, name)| is_wanted(name))
                    .map(|(number, _)| number)
                    .collect();
                let wanted = StartDocument {
                    channels: (numbers.iter())
                        .map(|number| start.channels[*number].clone())
                        .collect(),
                    ..(**start).clone()
                };
                let mut found = vec![Fingerprint::new(); numbers.len()];
                reader.each_block(path, &numbers, block, &mut |samples| {
                    for (fingerprint, samples) in found.iter_mut().zip(&samples) {
                        fingerprint.add(samples);
                    }
                    take(super::assemble(path, &wanted, samples)?)
                })?;
                let is_whole = numbers.len() == start.channels.len();
                let differs = fingerprint.is_some_and(|stored| stored != Fingerprint::all(&found));
                match is_whole && differs {
                    true => Err(damaged(path, &"it does not hold what was recorded").into()),
                    false => Ok(()),
                }
            }
            Of::Another { columns, options } => {
                let wanted = columns.iter().filter(|(_, column)| is_wanted(&column.name));
                let wanted: Vec<&(usize, Column)> = wanted.collect();
                let numbers: Vec<usize> = wanted.iter().map(|(number, _)| *number).collect();
                reader.each_block(path, &numbers, block, &mut |samples| {
                    let columns = wanted.iter().map(|(_, column)| column);
                    take(table(path, columns, samples, options)?)
                })
            }
        }
    }
}

/// The recording of some rows of `columns`.
fn table<'a>(
    path: &Path,
    columns: impl Iterator<Item = &'a Column>,
    samples: Vec<Vec<f64>>,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let with = |(column, values): (&Column, Vec<f64>)| Column {
        values,
        ..column.clone()
    };
    let table = Table {
        columns: columns.zip(samples).map(with).collect(),
        ..Table::default()
    };
    table.recording(path, options)
}

fn ours(
    path: &Path,
    reader: &Reader,
    options: &ReadOptions,
) -> Result<Option<(ParquetBlocks, Stored)>, ReadError> {
    let documents = Documents::of(path, reader)?;
    let channels = reader.columns_with(UNIT_KEY).len();
    if documents.start.columns() != Columns::Whole || !reader.holds_floats() {
        return Ok(None);
    }
    documents.require_channels(path, channels)?;
    let samples = reader.count();
    documents.require_own(path, samples, None)?;
    let recording = super::assemble(path, &documents.start, vec![Vec::new(); channels])?;
    let read_s = recording.rate().duration_of(samples).0;
    let mut stored = documents.completed(recording, read_s, options.rate);
    stored
        .recording
        .about
        .warnings
        .extend(later_recording(path));
    let blocks = ParquetBlocks {
        samples,
        of: Of::Us {
            fingerprint: documents.end.as_ref().and_then(|end| end.fingerprint),
            start: Box::new(documents.start),
        },
    };
    Ok(Some((blocks, stored)))
}

fn of_another(
    path: &Path,
    reader: &Reader,
    options: &ReadOptions,
) -> Result<Option<(ParquetBlocks, Stored)>, ReadError> {
    // It completes the table, and is an input where it is missing too.
    if is_there(&sidecar_path(path)) {
        return Ok(None);
    }
    let columns = reader.columns_with(UNIT_KEY).into_iter().map(column_of);
    let mut columns: Vec<(usize, Column)> = columns.enumerate().collect();
    let moments = reader.moments(path)?;
    let Some(moments) = moments else {
        return Ok(None);
    };
    let named = columns.iter().position(|(_, column)| is_time(&column.name));
    let mut options = options.clone();
    let mut warnings = Vec::new();
    let mut started_at: Option<StartTime> = None;
    if let Some(time) = named.or(moments.first().copied()) {
        let mut column = columns[time].1.clone();
        if let Some(first) = moments.first() {
            started_at = reader.first_moment(path, *first)?;
        }
        if moments.contains(&time) {
            column.unit = Some("s".into());
        }
        match even_rate(path, reader, time, &column, &mut warnings) {
            Ok(Some(rate)) if options.rate.is_none_or(|stated| stated == rate) => {
                if options.rate.is_some() {
                    warnings.clear();
                }
                // Times that contradict it are looked at whole.
                let other = moments.first().filter(|other| **other != time);
                if let Some(other) = other {
                    let seconds = Column {
                        unit: Some("s".into()),
                        ..columns[*other].1.clone()
                    };
                    let found = even_rate(path, reader, *other, &seconds, &mut Vec::new());
                    let agrees = |found: SampleRate| (found.hz() / rate.hz() - 1.0).abs() < 0.01;
                    if !found.is_ok_and(|found| found.is_some_and(agrees)) {
                        return Ok(None);
                    }
                }
                options.rate = Some(rate);
            }
            _ => return Ok(None),
        }
        columns.retain(|(number, _)| *number != time && !moments.contains(number));
    }
    let codes = columns
        .iter()
        .map(|(number, _)| *number)
        .filter(|number| !reader.states_within(*number, LEAST_CODE))
        .collect::<Vec<_>>();
    let mut holds_codes = false;
    reader.each_block(path, &codes, BLOCK, &mut |samples| {
        holds_codes |= samples.iter().flatten().any(|value| is_code(*value));
        Ok::<(), ReadError>(())
    })?;
    if holds_codes || columns.is_empty() {
        return Ok(None);
    }
    let none = vec![Vec::new(); columns.len()];
    let each = columns.iter().map(|(_, column)| column);
    let mut recording = table(path, each, none, &options)?;
    recording.about.warnings.splice(0..0, warnings);
    recording.annotations.started_at = started_at;
    let blocks = ParquetBlocks {
        samples: reader.count(),
        of: Of::Another { columns, options },
    };
    Ok(Some((blocks, recording.into())))
}

/// The rate of a column of times, where they are even; `None` where the whole column has to be looked at.
fn even_rate(
    path: &Path,
    reader: &Reader,
    number: usize,
    column: &Column,
    warnings: &mut Vec<piezotact::Warning>,
) -> Result<Option<SampleRate>, ReadError> {
    let mut even = EvenTimes::default();
    while even.begin_pass() {
        reader.each_block(path, &[number], BLOCK, &mut |mut times| {
            even.add(&times.swap_remove(0));
            Ok::<(), ReadError>(())
        })?;
    }
    even.rate(path, column, warnings)
}
