//! Continuous signals: compressed tables without a heading, one column for each channel of one clock.

use std::io::{BufReader, Read, Write};
use std::ops::ControlFlow;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use flate2::write::GzEncoder;
use flate2::{Compression, GzBuilder};
use piezotact::recording::Channel;

use super::NOTHING;
use super::error::BidsError;
use super::table::Lines;
use piezotact_dataset::open_input;

/// How much text is compressed at a time, in bytes.
const BATCH: usize = 1 << 16;

/// Writes `channels`, all of one length, to `out`: numbers in the shortest form that gives the same number again, and a header
/// without time and name.
pub(super) fn write_signals(channels: &[&Channel], out: impl Write) -> std::io::Result<()> {
    let mut encoder: GzEncoder<_> = GzBuilder::new().mtime(0).write(out, Compression::new(6));
    let rows = channels.first().map_or(0, |channel| channel.samples.len());
    let mut text: Vec<u8> = Vec::with_capacity(BATCH + 64 * channels.len());
    for row in 0..rows {
        for (i, channel) in channels.iter().enumerate() {
            if i > 0 {
                text.push(b'\t');
            }
            let sample = channel.samples[row];
            if sample.is_finite() {
                serde_json::to_writer(&mut text, &sample)?;
            } else {
                text.extend_from_slice(NOTHING.as_bytes());
            }
        }
        text.push(b'\n');
        if text.len() >= BATCH {
            encoder.write_all(&text)?;
            text.clear();
        }
    }
    encoder.write_all(&text)?;
    encoder.finish()?.flush()
}

/// What is wrong with a compressed table.
pub(super) enum SignalFault {
    /// It holds no row.
    Empty,
    /// It is not compressed, or ends before it should.
    Damaged(String),
    /// A line.
    Line(u64, LineFault),
}

/// What is wrong with a line.
pub(super) enum LineFault {
    /// So many cells.
    Cells(usize),
    /// A cell that is no number, in this column (from 0).
    Text(usize, String),
    /// It is no text.
    Bytes(String),
}

/// Reads the table at `path` line by line, each with so many `columns`; gives `row` the numbers, NaN for what was not measured, until
/// it has enough.
pub(super) fn each_row(
    path: &Path,
    columns: usize,
    mut row: impl FnMut(&[f64]) -> ControlFlow<()>,
) -> Result<Result<u64, SignalFault>, BidsError> {
    let mut opened = BufReader::with_capacity(1 << 16, open_input(path)?);
    let mut magic = [0; 2];
    let is_gzip = opened.read_exact(&mut magic).is_ok() && magic == [0x1f, 0x8b];
    if !is_gzip {
        let found = match std::fs::metadata(path).is_ok_and(|found| found.len() == 0) {
            true => return Ok(Err(SignalFault::Empty)),
            false => "expected a file compressed with gzip, found another one; compress it",
        };
        return Ok(Err(SignalFault::Damaged(found.into())));
    }
    let opened = BufReader::with_capacity(1 << 16, open_input(path)?);
    let decoder = BufReader::with_capacity(1 << 16, MultiGzDecoder::new(opened));
    let mut lines = Lines::of(decoder);
    let mut numbers = Vec::new();
    let mut rows = 0;
    loop {
        let (number, line) = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) if rows == 0 => return Ok(Err(SignalFault::Empty)),
            Ok(None) => return Ok(Ok(rows)),
            Err((_, super::table::LineFault::Io(error))) => {
                return Ok(Err(SignalFault::Damaged(format!(
                    "expected a compressed file that is whole, found one that cannot be read to its end ({error}); copy it again"
                ))));
            }
            Err((number, fault)) => {
                let fault = LineFault::Bytes(fault.sentence());
                return Ok(Err(SignalFault::Line(number, fault)));
            }
        };
        numbers.clear();
        for (i, cell) in line.split('\t').enumerate() {
            let value = match cell {
                NOTHING => Some(f64::NAN),
                text => number_in(text),
            };
            match value {
                Some(value) => numbers.push(value),
                None => {
                    let fault = LineFault::Text(i, cell.chars().take(40).collect());
                    return Ok(Err(SignalFault::Line(number, fault)));
                }
            }
        }
        if numbers.len() != columns {
            let fault = LineFault::Cells(numbers.len());
            return Ok(Err(SignalFault::Line(number, fault)));
        }
        rows += 1;
        if row(&numbers).is_break() {
            return Ok(Ok(rows));
        }
    }
}

/// The finite number that `text` is; words such as `inf` are none in BIDS.
pub(super) fn number_in(text: &str) -> Option<f64> {
    let plain = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
    let text = text.trim();
    if text.is_empty() || !text.as_bytes().iter().all(plain) {
        return None;
    }
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

impl SignalFault {
    /// The line, and what was expected, what was found, and what to do; of a table of so many columns.
    pub(super) fn sentence(&self, columns: usize) -> (Option<u64>, String) {
        match self {
            Self::Empty => (None, "expected samples, found none; export it again".into()),
            Self::Damaged(why) => (None, why.clone()),
            Self::Line(line, LineFault::Cells(found)) => (
                Some(*line),
                format!(
                    "expected {columns} columns as its sidecar states, found {found}; correct `Columns` or export it again"
                ),
            ),
            Self::Line(line, LineFault::Text(column, found)) => (
                Some(*line),
                match line {
                    1 => format!(
                        "expected numbers from the first line on, found `{found}`; such tables have no heading: remove it, or correct the cell"
                    ),
                    _ => format!(
                        "expected a number or n/a in column {}, found `{found}`; correct the cell",
                        column + 1
                    ),
                },
            ),
            Self::Line(line, LineFault::Bytes(why)) => (Some(*line), why.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::Unit;

    fn channel(samples: Vec<f64>) -> Channel {
        Channel {
            name: "a".into(),
            unit: Unit::Newton,
            samples,
        }
    }

    #[test]
    fn samples_are_read_bit_by_bit_as_they_were_written() {
        let values = vec![
            0.1 + 0.2,
            -0.0,
            1e-300,
            f64::MIN_POSITIVE / 3.0,
            12_345_678.901,
            f64::NAN,
            f64::MAX,
        ];
        let (one, other) = (
            channel(values.clone()),
            channel(values.iter().map(|v| -v).collect()),
        );
        let file = tempfile::NamedTempFile::new().unwrap();
        write_signals(&[&one, &other], file.as_file()).unwrap();
        let bytes = std::fs::read(file.path()).unwrap();
        // Flags, then four bytes of time: neither a name nor a date.
        assert_eq!((bytes[3], &bytes[4..8]), (0, &[0; 4][..]));
        let mut read = Vec::new();
        let rows = each_row(file.path(), 2, |row| {
            read.push(row.to_vec());
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(rows.ok(), Some(7));
        for (row, value) in read.iter().zip(&values) {
            assert!(value.is_nan() && row[0].is_nan() || row[0].to_bits() == value.to_bits());
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let check = |bytes: &[u8], columns: usize, part: &str| {
            std::fs::write(file.path(), bytes).unwrap();
            let fault = each_row(file.path(), columns, |_| ControlFlow::Continue(()))
                .unwrap()
                .err()
                .unwrap();
            let (line, said) = fault.sentence(columns);
            let said = format!("{line:?} {said}");
            assert!(said.contains(part), "no `{part}` in {said}");
        };
        let gz = |text: &str| {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::new(6));
            encoder.write_all(text.as_bytes()).unwrap();
            encoder.finish().unwrap()
        };
        check(b"", 1, "None expected samples");
        check(&gz(""), 1, "None expected samples");
        check(b"1\t2\n", 2, "compressed with gzip");
        check(
            &gz("a\tb\n1\t2\n"),
            2,
            "Some(1) expected numbers from the first line on",
        );
        check(
            &gz("1\t2\n1\tx\n"),
            2,
            "Some(2) expected a number or n/a in column 2",
        );
        check(&gz("1\t2\n1\tinf\n"), 2, "Some(2)");
        check(&gz("1\t2\n1\n"), 2, "Some(2) expected 2 columns");
        let whole = gz(&"0.123456789\t2\n".repeat(5000));
        check(&whole[..whole.len() / 2], 2, "cannot be read to its end");
        check(&whole[..whole.len() - 4], 2, "cannot be read to its end");
    }
}
