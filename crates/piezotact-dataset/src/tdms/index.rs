//! How the samples of a channel lie in a segment.

use std::io::{Read, Seek};

use super::property::stored;
use super::source::Source;
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// A longer row of interleaved samples is no row.
pub(super) const LONGEST_ROW: u64 = 1 << 20;
/// The type of `DAQmx` raw data, and the scaler of samples that are no `DAQmx` raw data.
const DAQMX: u64 = 0xFFFF_FFFF;
pub(super) const NO_SCALER: u64 = DAQMX;

/// What the samples of a channel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Stored),
    Truth,
    /// One bit of a number: a digital line.
    Bit(Stored, u32),
    Time,
    Complex(usize),
    Text,
}

impl Kind {
    fn of(code: u64) -> Option<Self> {
        match code {
            0x20 => Some(Self::Text),
            0x21 => Some(Self::Truth),
            0x44 => Some(Self::Time),
            0x0008_000C => Some(Self::Complex(8)),
            0x0010_000D => Some(Self::Complex(16)),
            code => stored(code).map(Self::Number),
        }
    }

    /// The bytes of one; 0 for texts, which differ in length.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Number(number) | Self::Bit(number, _) => number.width(),
            Self::Truth => 1,
            Self::Time => 16,
            Self::Complex(width) => width,
            Self::Text => 0,
        }
    }
}

/// How the samples of an object lie in a chunk.
#[derive(Clone, Debug)]
pub(super) struct Index {
    pub(super) type_code: u64,
    /// Samples in a chunk.
    pub(super) count: u64,
    /// Bytes in a chunk; 0 for `DAQmx`.
    pub(super) bytes: u64,
    /// One, with the scaler [`NO_SCALER`], but for `DAQmx` raw data.
    pub(super) parts: Vec<Part>,
    /// Bytes of a row of each `DAQmx` buffer; none where it is no `DAQmx` raw data.
    pub(super) widths: Vec<u64>,
}

/// Samples of one scaler.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) scaler: u64,
    pub(super) kind: Kind,
    pub(super) buffer: usize,
    pub(super) first: u64,
}

/// What the scalers of `DAQmx` raw data take out of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalers {
    Numbers,
    DigitalLines,
}

impl Index {
    /// The dimension of samples, which is 1, and their number.
    fn count_in_chunk<R: Read + Seek>(
        source: &mut Source<'_, R>,
        order: ByteOrder,
    ) -> Result<u64, ReadError> {
        let at = source.at();
        match source.number::<4>(order, "a dimension")? {
            1 => source.number::<8>(order, "a number of samples"),
            other => {
                let found = format!("{other} dimensions");
                Err(source.wrong(at, "samples of one dimension", found))
            }
        }
    }

    /// Reads that of a channel of one type of samples.
    pub(super) fn plain<R: Read + Seek>(
        source: &mut Source<'_, R>,
        order: ByteOrder,
    ) -> Result<Self, ReadError> {
        let at = source.at();
        let code = source.number::<4>(order, "the type of samples")?;
        let count = Self::count_in_chunk(source, order)?;
        // A channel that never held a sample may have no type.
        let kind = match Kind::of(code) {
            Some(kind) => kind,
            None if code == 0 && count == 0 => {
                return Ok(Self {
                    type_code: code,
                    count,
                    bytes: 0,
                    parts: Vec::new(),
                    widths: Vec::new(),
                });
            }
            None => {
                let name = match code {
                    0xB | 0x1B => "extended floats (80 bits)".to_owned(),
                    0x4F => "fixed-point numbers".to_owned(),
                    code => format!("type {code:#x}"),
                };
                let expected =
                    "numbers of 8 to 64 bits, truth values, times, complex numbers or texts";
                return Err(source.wrong(at, expected, name));
            }
        };
        let bytes = match kind {
            Kind::Text => Some(source.number::<8>(order, "the length of texts")?),
            kind => count.checked_mul(kind.width() as u64),
        };
        let Some(bytes) = bytes else {
            let found = format!("{count}");
            return Err(source.wrong(at + 8, "a possible number of samples", found));
        };
        let parts = vec![Part {
            scaler: NO_SCALER,
            kind,
            buffer: 0,
            first: 0,
        }];
        Ok(Self {
            type_code: code,
            count,
            bytes,
            parts,
            widths: Vec::new(),
        })
    }

    /// Reads that of a channel of `DAQmx` raw data.
    pub(super) fn daqmx<R: Read + Seek>(
        source: &mut Source<'_, R>,
        order: ByteOrder,
        scalers: Scalers,
    ) -> Result<Self, ReadError> {
        let code = source.number::<4>(order, "the type of samples")?;
        let count = Self::count_in_chunk(source, order)?;
        let at = source.at();
        let count_of_scalers = source.number::<4>(order, "the number of scalers")?;
        let mut parts = Vec::new();
        for _ in 0..count_of_scalers {
            parts.push(Self::part(source, order, scalers)?);
        }
        let buffers = source.number::<4>(order, "the number of buffers")?;
        let mut widths = Vec::new();
        for _ in 0..buffers {
            widths.push(source.number::<4>(order, "the width of a buffer")?);
        }
        let fits = |part: &Part| {
            let end = part.first + part.kind.width() as u64;
            widths
                .get(part.buffer)
                .is_some_and(|width| end <= *width && *width <= LONGEST_ROW)
        };
        let twice = |(at, part): (usize, &Part)| {
            parts[..at].iter().any(|other| other.scaler == part.scaler)
        };
        let is_one = code == DAQMX || parts.len() == 1;
        if parts.is_empty() || parts.len() > 64 || !is_one || !parts.iter().all(fits) {
            let found = format!("{count_of_scalers} in buffers of {widths:?} bytes");
            let expected = "scalers whose samples lie within the rows of their buffers";
            return Err(source.wrong(at, expected, found));
        }
        if parts.iter().enumerate().any(twice) {
            let found = "two of one number";
            return Err(source.wrong(at, "scalers of different numbers", found));
        }
        if code != DAQMX {
            parts[0].scaler = NO_SCALER;
        }
        Ok(Self {
            type_code: code,
            count,
            bytes: 0,
            parts,
            widths,
        })
    }

    /// A scaler of `DAQmx` raw data.
    fn part<R: Read + Seek>(
        source: &mut Source<'_, R>,
        order: ByteOrder,
        scalers: Scalers,
    ) -> Result<Part, ReadError> {
        let at = source.at();
        let what = "a scaler";
        let code = source.number::<4>(order, what)?;
        let kind = match code {
            0 => Kind::Number(Stored::U8),
            1 => Kind::Number(Stored::I8),
            2 => Kind::Number(Stored::U16),
            3 => Kind::Number(Stored::I16),
            4 => Kind::Number(Stored::U32),
            5 => Kind::Number(Stored::I32),
            6 => Kind::Number(Stored::U64),
            7 => Kind::Number(Stored::I64),
            8 => Kind::Number(Stored::F32),
            9 => Kind::Number(Stored::F64),
            0xFFFF_FFFF => Kind::Time,
            other => {
                let found = format!("type {other:#x}");
                return Err(source.wrong(at, "a scaler of a known type", found));
            }
        };
        let buffer = source.number::<4>(order, what)? as usize;
        let offset = source.number::<4>(order, what)?;
        match scalers {
            Scalers::DigitalLines => source.number::<1>(order, what)?,
            Scalers::Numbers => source.number::<4>(order, what)?,
        };
        let scaler = source.number::<4>(order, what)?;
        let (kind, first) = match (scalers, kind) {
            (Scalers::DigitalLines, Kind::Number(number)) => {
                (Kind::Bit(number, (offset % 8) as u32), offset / 8)
            }
            _ => (kind, offset),
        };
        Ok(Part {
            scaler,
            kind,
            buffer,
            first,
        })
    }
}
