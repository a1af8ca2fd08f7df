//! Reads datasets 58 and 58b. Marks between datasets are whole lines, counted headers are never searched for them,
//! and nothing is reserved for values that a header merely promises.

use std::path::Path;

use num_complex::Complex;

use super::{UffAbscissa, UffAxis, UffData, UffFunction, UffKind, UffPoint};
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// The mark that opens and closes a dataset: -1 in columns 5 and 6, alone on its line.
const MARK: &[u8] = b"    -1";
const AGAIN: &str = "copy the file again as it is (not as text), or export it again";

/// Whether `bytes` begin as a universal file does: a mark, then the number of a dataset.
#[must_use]
pub fn looks_like_uff(bytes: &[u8]) -> bool {
    let mut lines = Lines { bytes, at: 0 };
    match lines.next_filled() {
        Some(line) if is_mark(line) => lines
            .next()
            .is_some_and(|line| dataset_number(line).is_some()),
        _ => false,
    }
}

/// The functions of dataset 58 in a universal file; datasets of other numbers are passed over.
///
/// # Errors
/// [`ReadError::Content`] when the file is no universal file, holds no function, or is damaged: it says where and
/// what to do.
pub fn parse_uff(path: &Path, bytes: &[u8]) -> Result<Vec<UffFunction>, ReadError> {
    let mut file = File {
        path,
        lines: Lines { bytes, at: 0 },
        dataset: 0,
    };
    let (mut functions, mut others) = (Vec::new(), Vec::new());
    while let Some(line) = file.lines.next_filled() {
        file.dataset += 1;
        if !is_mark(line) {
            return Err(file.wrong("the mark `-1` that opens a dataset", excerpt(line)));
        }
        let head = file
            .lines
            .next()
            .ok_or_else(|| file.wrong("the number of a dataset", "the end of the file"))?;
        let Some(number) = dataset_number(head) else {
            return Err(file.wrong("the number of a dataset", excerpt(head)));
        };
        if number == 58 {
            functions.push(file.function(head)?);
        } else {
            others.push(number);
            file.pass_over()?;
        }
    }
    if functions.is_empty() {
        others.sort_unstable();
        others.dedup();
        let listed: Vec<String> = others.iter().map(u32::to_string).collect();
        return Err(ReadError::content(
            path,
            "functions (dataset 58) in a universal file",
            if listed.is_empty() {
                "none".into()
            } else {
                format!("only datasets {}", listed.join(", "))
            },
            "export the time signals or the frequency responses too",
        ));
    }
    Ok(functions)
}

fn is_mark(line: &[u8]) -> bool {
    line.strip_prefix(MARK)
        .is_some_and(|rest| rest.iter().all(u8::is_ascii_whitespace))
}

/// The number at the start of a line such as `    58` or `    58b     1     2 …`.
fn dataset_number(line: &[u8]) -> Option<u32> {
    let line = line.trim_ascii_start();
    let digits = line.iter().take_while(|b| b.is_ascii_digit()).count();
    if digits == 0 || digits > 6 {
        return None;
    }
    match line.get(digits) {
        None | Some(b' ' | b'\t' | b'b' | b'B') => text(&line[..digits]).parse().ok(),
        _ => None,
    }
}

/// UTF-8 where it is, Latin-1 where it is not: analysers write both.
fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

fn excerpt(line: &[u8]) -> String {
    let line = line.trim_ascii();
    if line.is_empty() {
        return "an empty line".into();
    }
    format!("`{}`", text(&line[..line.len().min(40)]).escape_debug())
}

/// The text between two columns, without blanks around it.
fn field(line: &[u8], from: usize, to: usize) -> String {
    let to = to.min(line.len());
    text(line.get(from..to).unwrap_or_default())
        .trim()
        .to_owned()
}

/// The same, empty for `NONE`.
fn label(line: &[u8], from: usize, to: usize) -> String {
    let found = field(line, from, to);
    if found == "NONE" {
        String::new()
    } else {
        found
    }
}

/// A number as Fortran writes it: `1.5E+00`, `1.5D+00`, and `1.5-100` without a letter.
fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let text = text.replace(['D', 'd'], "E");
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let sign = text
        .char_indices()
        .skip(1)
        .find(|(_, c)| matches!(c, '+' | '-'))?
        .0;
    let (mantissa, exponent) = (text.get(..sign)?, text.get(sign..)?);
    if mantissa.contains('E') {
        return None;
    }
    format!("{mantissa}E{exponent}").parse().ok()
}

struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Lines<'a> {
    /// The next line without its end.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n');
        let (line, used) = match end {
            Some(end) => (&rest[..end], end + 1),
            None => (rest, rest.len()),
        };
        self.at += used;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn next_filled(&mut self) -> Option<&'a [u8]> {
        std::iter::from_fn(|| self.next()).find(|line| !line.trim_ascii().is_empty())
    }

    /// Whether a mark follows `skip` bytes further, with nothing but line ends between.
    fn mark_after(&self, skip: usize) -> bool {
        let Some(mut rest) = self
            .at
            .checked_add(skip)
            .and_then(|at| self.bytes.get(at..))
        else {
            return false;
        };
        while let [b'\r' | b'\n', more @ ..] = rest {
            rest = more;
        }
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        is_mark(&rest[..end])
    }
}

/// The content of the second line of a binary dataset.
struct Binary {
    order: ByteOrder,
    bytes: usize,
}

/// How values stand in a dataset.
struct Layout {
    double: bool,
    complex: bool,
    even: bool,
}

impl Layout {
    fn per_point(&self) -> usize {
        1 + usize::from(self.complex) + usize::from(!self.even)
    }

    /// The widths of the columns of text, over and over.
    fn widths(&self) -> &'static [usize] {
        match (self.double, self.even, self.complex) {
            (false, ..) => &[13],
            (true, true, _) => &[20],
            (true, false, false) => &[13, 20],
            (true, false, true) => &[13, 20, 20],
        }
    }
}

struct File<'a> {
    path: &'a Path,
    lines: Lines<'a>,
    dataset: usize,
}

impl<'a> File<'a> {
    fn wrong(&self, expected: impl Into<String>, found: impl std::fmt::Display) -> ReadError {
        ReadError::content(
            self.path,
            expected,
            format!("{found} in dataset {} of the file", self.dataset),
            AGAIN,
        )
    }

    /// A dataset of another number, to its closing mark.
    fn pass_over(&mut self) -> Result<(), ReadError> {
        loop {
            match self.lines.next() {
                Some(line) if is_mark(line) => return Ok(()),
                Some(_) => {}
                None => {
                    return Err(
                        self.wrong("the mark `-1` that closes a dataset", "the end of the file")
                    );
                }
            }
        }
    }

    fn record(&mut self) -> Result<&'a [u8], ReadError> {
        self.lines
            .next()
            .ok_or_else(|| self.wrong("11 header lines", "the end of the file"))
    }

    fn integer(&self, what: &str, line: &[u8], from: usize, to: usize) -> Result<i64, ReadError> {
        match field(line, from, to) {
            blank if blank.is_empty() => Ok(0),
            digits => digits.parse().ok().ok_or_else(|| {
                self.wrong(format!("{what}, a whole number"), format!("`{digits}`"))
            }),
        }
    }

    fn binary(&self, head: &[u8]) -> Result<Option<Binary>, ReadError> {
        let head = text(head);
        let Some((_, fields)) = head.split_once(['b', 'B']) else {
            return Ok(None);
        };
        let numbers: Vec<usize> = fields
            .split_ascii_whitespace()
            .map_while(|word| word.parse().ok())
            .collect();
        let (order, format, lines, bytes) = match numbers.as_slice() {
            [order, format, lines, bytes, ..] => (*order, *format, *lines, *bytes),
            _ => {
                return Err(self.wrong(
                    "the byte order, the number format, the number of header lines and the number of data bytes after `58b`",
                    excerpt(fields.as_bytes()),
                ));
            }
        };
        if format != 2 {
            return Err(ReadError::content(
                self.path,
                "numbers of IEEE 754 (format 2)",
                format!("format {format} in dataset {} of the file", self.dataset),
                "export as text (dataset 58)",
            ));
        }
        if !(1..=2).contains(&order) {
            return Err(self.wrong("byte order 1 (little endian) or 2 (big endian)", order));
        }
        if lines != 11 {
            return Err(self.wrong("11 header lines", lines));
        }
        Ok(Some(Binary {
            order: if order == 1 {
                ByteOrder::Little
            } else {
                ByteOrder::Big
            },
            bytes,
        }))
    }

    fn point(&self, line: &[u8], from: usize) -> Result<UffPoint, ReadError> {
        Ok(UffPoint {
            entity: label(line, from, from + 10),
            node: self.integer("a node", line, from + 10, from + 20)?,
            direction: self.integer("a direction", line, from + 20, from + 24)?,
        })
    }

    fn axis(&mut self) -> Result<UffAxis, ReadError> {
        let line = self.record()?;
        Ok(UffAxis {
            quantity: self.integer("the quantity of an axis", line, 0, 10)?,
            label: label(line, 26, 46),
            unit: label(line, 47, 67),
        })
    }

    fn function(&mut self, head: &[u8]) -> Result<UffFunction, ReadError> {
        let binary = self.binary(head)?;
        let mut id_lines: [String; 5] = Default::default();
        for line in &mut id_lines {
            let found = self.record()?;
            *line = label(found, 0, found.len());
        }
        let line = self.record()?;
        let kind = UffKind::of(self.integer("the type of a function", line, 0, 5)?);
        let (response, reference) = (self.point(line, 31)?, self.point(line, 56)?);
        let line = self.record()?;
        let [kind_of_data, promised, spacing] = self.counts(line)?;
        let (start, step) = self.start_and_step(line)?;
        let layout = match kind_of_data {
            2 | 4 | 5 | 6 => Layout {
                double: matches!(kind_of_data, 4 | 6),
                complex: matches!(kind_of_data, 5 | 6),
                even: spacing != 0,
            },
            other => {
                return Err(self.wrong("data of type 2, 4, 5 or 6", format!("type {other}")));
            }
        };
        let (abscissa_axis, ordinate_axis) = (self.axis()?, self.axis()?);
        let (denominator_axis, _z_axis) = (self.axis()?, self.axis()?);
        let promised = usize::try_from(promised)
            .ok()
            .ok_or_else(|| self.wrong("a number of values", promised))?;
        let values = match binary {
            Some(binary) => self.binary_values(&layout, &binary, promised)?,
            None => self.text_values(&layout)?,
        };
        let (abscissa, data) = self.points(&layout, values, promised, (start, step))?;
        Ok(UffFunction {
            id_lines,
            kind,
            response,
            reference,
            abscissa,
            abscissa_axis,
            ordinate_axis,
            denominator_axis,
            data,
            promised,
        })
    }

    fn counts(&self, line: &[u8]) -> Result<[i64; 3], ReadError> {
        let mut counts = [0; 3];
        for (k, count) in counts.iter_mut().enumerate() {
            *count = self.integer(
                "type, number and spacing of the data",
                line,
                10 * k,
                10 * k + 10,
            )?;
        }
        Ok(counts)
    }

    fn start_and_step(&self, line: &[u8]) -> Result<(f64, f64), ReadError> {
        let mut found = [0.0; 2];
        for (k, value) in found.iter_mut().enumerate() {
            let written = field(line, 30 + 13 * k, 43 + 13 * k);
            if !written.is_empty() {
                *value = number(&written).ok_or_else(|| {
                    self.wrong("start and step of the abscissa", format!("`{written}`"))
                })?;
            }
        }
        Ok((found[0], found[1]))
    }

    fn text_values(&mut self, layout: &Layout) -> Result<Vec<f64>, ReadError> {
        let mut values = Vec::new();
        loop {
            let Some(line) = self.lines.next() else {
                return Err(self.wrong(
                    "the mark `-1` that closes a dataset",
                    "the end of the file: it was cut short",
                ));
            };
            if is_mark(line) {
                return Ok(values);
            }
            let written = text(line);
            let before = values.len();
            // Blanks stand between nearly all numbers; where a sign fills them, columns have fixed widths.
            if !written.split_ascii_whitespace().all(|word| {
                number_of_one(word).is_some_and(|value| {
                    values.push(value);
                    true
                })
            }) {
                values.truncate(before);
                self.columns(&written, layout.widths(), &mut values)?;
            }
        }
    }

    fn columns(
        &self,
        written: &str,
        widths: &[usize],
        values: &mut Vec<f64>,
    ) -> Result<(), ReadError> {
        let (mut at, mut widths) = (0, widths.iter().cycle());
        while at < written.trim_end().len() {
            let width = widths.next().copied().unwrap_or(13);
            let end = (at + width).min(written.len());
            let value = written.get(at..end).and_then(number);
            values.push(value.ok_or_else(|| self.wrong("a number", excerpt(written.as_bytes())))?);
            at = end;
        }
        Ok(())
    }

    fn binary_values(
        &mut self,
        layout: &Layout,
        binary: &Binary,
        promised: usize,
    ) -> Result<Vec<f64>, ReadError> {
        let width = if layout.double { 8 } else { 4 };
        // Programs differ in whether an uneven abscissa beside doubles is single or double.
        let widths = if layout.double && !layout.even {
            vec![8, 4]
        } else {
            vec![width]
        };
        let others = width * (layout.per_point() - usize::from(!layout.even));
        let chosen = widths.iter().copied().find_map(|first| {
            let point = others + if layout.even { 0 } else { first };
            let length = point.checked_mul(promised)?;
            self.lines.mark_after(length).then_some((first, length))
        });
        let Some((first, length)) = chosen else {
            let bytes = binary.bytes;
            return Err(self.wrong(
                format!("{promised} values of {width} bytes, then the mark `-1`"),
                format!("no mark there ({bytes} bytes are stated)"),
            ));
        };
        let block = &self.lines.bytes[self.lines.at..self.lines.at + length];
        self.lines.at += length;
        // The mark that was seen, after the line ends before it.
        let _mark = self.lines.next_filled();
        let (mut rest, mut values, mut k) = (block, Vec::new(), 0);
        while !rest.is_empty() {
            let is_place = !layout.even && k % layout.per_point() == 0;
            let width = if is_place { first } else { width };
            let (taken, more) = rest.split_at(width.min(rest.len()));
            let stored = if width == 8 { Stored::F64 } else { Stored::F32 };
            values.push(stored.value(taken, binary.order));
            (rest, k) = (more, k + 1);
        }
        Ok(values)
    }

    fn points(
        &self,
        layout: &Layout,
        mut values: Vec<f64>,
        promised: usize,
        (start, step): (f64, f64),
    ) -> Result<(UffAbscissa, UffData), ReadError> {
        let per_point = layout.per_point();
        let wanted = promised.saturating_mul(per_point);
        if values.len() > wanted {
            // A last line filled up with zeros.
            let extra = &values[wanted..];
            if extra.len() >= 6 || extra.iter().any(|value| *value != 0.0) {
                return Err(self.wrong(
                    format!("{wanted} numbers for {promised} values"),
                    format!("{}", values.len()),
                ));
            }
            values.truncate(wanted);
        }
        if values.is_empty() || !values.len().is_multiple_of(per_point) {
            return Err(self.wrong(
                format!("{wanted} numbers, {per_point} for each value"),
                format!("{}", values.len()),
            ));
        }
        let points = values.chunks_exact(per_point);
        let skip = usize::from(!layout.even);
        let abscissa = if layout.even {
            if !(start.is_finite() && step.is_finite() && step > 0.0) {
                return Err(self.wrong(
                    "an evenly spaced abscissa that increases",
                    format!("start {start}, step {step}"),
                ));
            }
            UffAbscissa::Even { start, step }
        } else {
            UffAbscissa::List(points.clone().map(|point| point[0]).collect())
        };
        let data = if layout.complex {
            UffData::Complex(
                points
                    .map(|point| Complex::new(point[skip], point[skip + 1]))
                    .collect(),
            )
        } else {
            UffData::Real(points.map(|point| point[skip]).collect())
        };
        Ok((abscissa, data))
    }
}

/// A word that is one number; `1.0-2.0` could be two that touch.
fn number_of_one(word: &str) -> Option<f64> {
    word.parse()
        .ok()
        .or_else(|| word.replace(['D', 'd'], "E").parse().ok())
}
