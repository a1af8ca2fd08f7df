//! Binary files of HBM catman (`.bin`), with samples of 4 or 8 bytes.
//!
//! Source of the layout: HBM, *catman binary format* (file versions 5010 and later), as `APReader` reads it.

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{Recording, RecordingWarning, StartTime};

use crate::columns::{Column, WithoutUnit, recording_of_bases};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::stored::{ByteOrder, Stored};
use crate::time_column::{TimeBase, choose_base, rate_of_step};

/// What stands for a sample of an amplifier that is overloaded or has no sensor.
const OVERLOAD: f64 = -1e6;
/// Texts before the number of channels.
const RESERVED: usize = 32;
/// More channels than this are none.
const MOST_CHANNELS: usize = 4096;
/// Where the export format stands in the second header of a channel, from its end.
const FORMAT_FROM_END: usize = 8;

/// Whether a file begins as one of catman does.
pub(crate) fn looks_like_catman(head: &[u8]) -> bool {
    match head {
        [a, b, offset @ ..] if offset.len() > 6 => {
            let offset = ByteOrder::Little.unsigned(&offset[..4]);
            (5010..=5014).contains(&u16::from_le_bytes([*a, *b]))
                && (256..1 << 31).contains(&offset)
        }
        _ => false,
    }
}

/// The header of a channel.
struct Header {
    name: String,
    unit: String,
    count: usize,
    /// Days since 1899-12-30, on the clock of the computer.
    began_day: f64,
    step_ms: f64,
    format: u8,
}

struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn wrong(&self, at: usize, expected: &str, found: String) -> ReadError {
        let todo =
            "the file is damaged: copy it again, or export it from catman as MATLAB (-v7) or ASCII";
        ReadError::content(self.path, expected, format!("{found} at byte {at}"), todo)
    }

    fn take(&mut self, count: u64, what: &str) -> Result<&'a [u8], ReadError> {
        let left = self.bytes.get(self.at..).unwrap_or_default();
        let taken = usize::try_from(count)
            .ok()
            .and_then(|count| left.get(..count));
        let Some(taken) = taken else {
            let found = format!("{} bytes before the end of the file", left.len());
            return Err(self.wrong(self.at, &format!("{count} bytes of {what}"), found));
        };
        self.at += taken.len();
        Ok(taken)
    }

    fn number(&mut self, bytes: u64, what: &str) -> Result<u64, ReadError> {
        Ok(ByteOrder::Little.unsigned(self.take(bytes, what)?))
    }

    fn double(&mut self, what: &str) -> Result<f64, ReadError> {
        Ok(Stored::F64.value(self.take(8, what)?, ByteOrder::Little))
    }

    /// A text behind its length, which has so many bytes.
    fn text(&mut self, bytes: u64, what: &str) -> Result<String, ReadError> {
        let length = self.number(bytes, what)?;
        let text = self.take(length, what)?;
        let text = match std::str::from_utf8(text) {
            Ok(text) => text.to_owned(),
            Err(_) => text.iter().map(|b| char::from(*b)).collect(),
        };
        Ok(text.trim().to_owned())
    }

    fn header(&mut self) -> Result<Header, ReadError> {
        let what = "the header of a channel";
        self.number(2, what)?;
        let count = self.number(4, what)? as usize;
        let name = self.text(2, "the name of a channel")?;
        let unit = self.text(2, "the unit of a channel")?;
        self.text(2, "the comment of a channel")?;
        // Format, width of the data and a time, which the second header has too.
        self.take(2 + 2 + 8, what)?;
        let at = self.at;
        let length = self.number(4, what)?;
        let second = self.take(length, what)?;
        let (Some((first, _)), true) = (
            second.split_at_checked(16),
            second.len() > 16 + FORMAT_FROM_END,
        ) else {
            return Err(self.wrong(at, "a second header of 148 bytes", format!("{length}")));
        };
        let [began_day, step_ms] =
            [&first[..8], &first[8..]].map(|b| Stored::F64.value(b, ByteOrder::Little));
        let format = second[second.len() - FORMAT_FROM_END];
        // Linearisation, scale, and the points of it.
        self.take(2, what)?;
        let points = self.number(1, what)?;
        for _ in 0..points {
            self.double(what)?;
        }
        self.number(2, what)?;
        self.text(2, "the formula of a channel")?;
        self.text(4, "the sensor of a channel")?;
        Ok(Header {
            name,
            unit,
            count,
            began_day,
            step_ms,
            format,
        })
    }
}

/// Reads the recording in `bytes`; `path` is what a refusal names.
pub(crate) fn parse_catman(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let mut reader = Reader { path, bytes, at: 2 };
    let offset = reader.number(4, "the place of the samples")? as usize;
    reader.text(2, "the comment of the file")?;
    for _ in 0..RESERVED {
        reader.text(2, "a reserved text")?;
    }
    let at = reader.at;
    let channels = reader.number(2, "the number of channels")? as usize;
    if channels > MOST_CHANNELS {
        return Err(reader.wrong(at, "at most 4096 channels", format!("{channels}")));
    }
    // The greatest length, the places of the headers, and the factor of reduction.
    reader.take(4 + 4 * channels as u64 + 4, "the places of the channels")?;
    let mut headers = Vec::new();
    for _ in 0..channels {
        headers.push(reader.header()?);
    }
    if offset < reader.at {
        let found = format!("{offset}, within the headers, which end");
        return Err(reader.wrong(
            reader.at,
            "the place of the samples behind the headers",
            found,
        ));
    }
    reader.at = offset;
    let (mut columns, mut bases) = (Vec::new(), Vec::new());
    let (mut left_out, mut warnings) = (Vec::new(), Vec::new());
    let mut began = None;
    for header in headers {
        let stored = match header.format {
            0 => Stored::F64,
            1 => Stored::F32,
            other => {
                let what = if other == 2 {
                    "2 bytes".into()
                } else {
                    format!("format {other}")
                };
                return Err(ReadError::content(
                    path,
                    "samples of 4 or 8 bytes",
                    format!("{what} in `{}`", header.name),
                    "export the measurement from catman again with 4 or 8 bytes",
                ));
            }
        };
        let length = (header.count as u64).saturating_mul(stored.width() as u64);
        let bytes = reader.take(length, &format!("samples of `{}`", header.name))?;
        let values = stored.values(bytes, ByteOrder::Little);
        let overloads = values
            .iter()
            .filter(|value| value.total_cmp(&OVERLOAD).is_eq())
            .count();
        let is_second = Unit::parse(&header.unit).0 == Unit::Second;
        let small = header.name.to_lowercase();
        let is_time = is_second
            && ["time", "zeit", "temps"]
                .iter()
                .any(|word| small.contains(word));
        match overloads {
            _ if is_time => continue,
            _ if values.is_empty() => left_out.push(format!("`{}` (no samples)", header.name)),
            0 => {
                let found = rate_of_step(path, 1e-3 * header.step_ms).map(TimeBase::even);
                let base = choose_base(path, options, Some(found), &mut warnings)?;
                bases.push((base, Seconds(0.0)));
                began = began.or_else(|| start_time(header.began_day));
                let column = Column {
                    name: header.name,
                    unit: Some(header.unit),
                    values,
                };
                columns.push((column, bases.len() - 1));
            }
            overloads => left_out.push(format!(
                "`{}` ({overloads} of {} samples are -1000000, the code of an overload or of an open input)",
                header.name,
                values.len()
            )),
        }
    }
    if columns.is_empty() {
        let found = match left_out.as_slice() {
            [] => "none".to_owned(),
            some => some.join(", "),
        };
        let todo = "record again with the sensors connected and within their range";
        return Err(ReadError::content(
            path,
            "a channel with samples",
            found,
            todo,
        ));
    }
    if !left_out.is_empty() {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!("channels were left out: {}", left_out.join(", ")),
        }));
    }
    let unnamed = WithoutUnit::OnlyScale { counts: &[] };
    let mut recording = recording_of_bases(path, columns, &bases, warnings, options, unnamed)?;
    recording.annotations.started_at = began;
    Ok(recording)
}

/// The time of a number of days since 1899-12-30, to the millisecond, whose zone the file does not state.
fn start_time(day: f64) -> Option<StartTime> {
    let is_possible = (1.0..2e6).contains(&day);
    let epoch = StartTime::try_from("1899-12-30T00:00:00".to_owned()).ok();
    let whole = epoch
        .filter(|_| is_possible)?
        .later(Seconds(86_400.0 * day.floor()));
    Some(whole.later(Seconds((day.fract() * 86_400e3).round() * 1e-3)))
}
