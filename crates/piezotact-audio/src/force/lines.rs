//! Bytes as lines: half lines at the start, lines without end, and any end of line.

/// A line is no longer than this, bytes.
const LONGEST: usize = 256;

/// Joins bytes to lines.
#[derive(Debug)]
pub(super) struct Lines {
    line: Vec<u8>,
    first: First,
    /// The rest of a line that was too long is skipped.
    skips: bool,
}

/// Whether the first bytes may be the rest of a line that began before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    /// They begin a line.
    Whole,
    /// They may be a rest: such a line counts only if it says itself that it is one, by its first character.
    PerhapsHalf,
    /// They are a rest.
    Half,
}

/// A line, or what stood in place of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line<'a> {
    /// A line without its end.
    Whole(&'a [u8]),
    /// The beginning of a line that is too long.
    TooLong(&'a [u8]),
}

impl Lines {
    pub(super) fn new(first: First) -> Self {
        Self {
            line: Vec::with_capacity(LONGEST),
            first,
            skips: false,
        }
    }

    /// Gives every line that ends within `bytes` to `take`, until it fails. Empty lines are left out. A line ends at a line feed or a
    /// carriage return.
    pub(super) fn feed<E>(
        &mut self,
        bytes: &[u8],
        mut take: impl FnMut(Line<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        for byte in bytes {
            if matches!(byte, b'\n' | b'\r') {
                let counts = match self.first {
                    First::Whole => true,
                    First::PerhapsHalf => matches!(self.line.first(), Some(b'#' | b'F')),
                    First::Half => false,
                };
                // An end of line that comes first ends the line before.
                self.first = First::Whole;
                let skipped = std::mem::take(&mut self.skips);
                let taken = match counts && !skipped && !self.line.trim_ascii().is_empty() {
                    true => take(Line::Whole(self.line.trim_ascii())),
                    false => Ok(()),
                };
                self.line.clear();
                taken?;
            } else if self.skips {
            } else if self.line.len() == LONGEST {
                self.skips = true;
                self.first = First::Whole;
                let taken = take(Line::TooLong(&self.line));
                self.line.clear();
                taken?;
            } else {
                self.line.push(*byte);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(first: First, parts: &[&[u8]]) -> Vec<String> {
        let (mut lines, mut all) = (Lines::new(first), Vec::new());
        for part in parts {
            let done: Result<(), ()> = lines.feed(part, |line| {
                all.push(match line {
                    Line::Whole(line) => String::from_utf8_lossy(line).into_owned(),
                    Line::TooLong(line) => format!("too long: {}", line.len()),
                });
                Ok(())
            });
            done.unwrap();
        }
        all
    }

    #[test]
    fn parts_ends_and_halves() {
        let parts: [&[u8]; 4] = [b"2.5\r\n1", b".25\n\n F 1 2", b".5 \r", b"half"];
        assert_eq!(lines(First::Whole, &parts), ["2.5", "1.25", "F 1 2.5"]);
        assert_eq!(lines(First::PerhapsHalf, &parts), ["1.25", "F 1 2.5"]);
        assert_eq!(lines(First::PerhapsHalf, &[b"# unit=N\n"]), ["# unit=N"]);
        assert_eq!(lines(First::Half, &[b"# unit=N\n1\n"]), ["1"]);
    }

    /// A line without end takes 256 bytes, counts once, and the next line is read.
    #[test]
    fn long_lines_are_skipped() {
        let long = vec![b'7'; 100_000];
        let parts: [&[u8]; 3] = [&long, &long, b"\n3.5\n"];
        assert_eq!(lines(First::Whole, &parts), ["too long: 256", "3.5"]);
    }
}
