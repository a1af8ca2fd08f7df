//! Lines typed by the experimenter, or by a script.

use std::io::{self, BufRead, IsTerminal as _, Read as _, Write as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use crate::failure::Outcome;
use crate::interrupt::interrupted;
use crate::output::print;

/// How often a signal is looked for while a line is awaited.
const LOOK: Duration = Duration::from_millis(50);

/// The longest line that is taken, in bytes; a note is the longest that a person types.
const LONGEST: u64 = 16_384;
/// Lines after the end of a session that are counted: a pipe may have no end.
pub(super) const MOST_COUNTED: usize = 1000;

/// What came from the keyboard.
pub(super) enum Typed {
    /// A line.
    Line(String),
    /// A line that is not taken, with the reason.
    NotTaken(&'static str),
    /// Nothing more comes: the input ended, or Ctrl-C was typed.
    End,
}

/// The keyboard and the screen.
pub(super) struct Terminal {
    lines: Receiver<io::Result<Typed>>,
    is_keyboard: bool,
}

impl Terminal {
    /// Begins to read lines.
    pub(super) fn new() -> Self {
        let (sender, lines) = channel();
        // It waits in a read that nothing ends, until the program ends.
        let _reads_as_long_as_the_program = std::thread::spawn(move || {
            let mut keyboard = io::stdin().lock();
            while let Some(line) = line(&mut keyboard).transpose() {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self {
            lines,
            is_keyboard: io::stdin().is_terminal(),
        }
    }

    /// Prints `text`.
    pub(super) fn say(&self, text: &str) -> Outcome {
        print(text)
    }

    /// Asks with `prompt`, and waits for a line.
    pub(super) fn ask(&self, prompt: &str) -> Outcome<Typed> {
        let mut screen = io::stdout().lock();
        let written = write!(screen, "{prompt} ").and_then(|()| screen.flush());
        drop(screen);
        if written.is_err() {
            return Ok(Typed::End);
        }
        loop {
            if interrupted() {
                return Ok(Typed::End);
            }
            match self.lines.recv_timeout(LOOK) {
                Ok(Ok(typed)) => {
                    // What a script types is not on the screen.
                    if let (Typed::Line(line), false) = (&typed, self.is_keyboard) {
                        print(line)?;
                    }
                    return Ok(typed);
                }
                Ok(Err(error)) => return Err(error.into()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(Typed::End),
            }
        }
    }

    /// Whether a person types.
    pub(super) fn is_keyboard(&self) -> bool {
        self.is_keyboard
    }

    /// How many lines of a script nobody asked for; none of a person, who sees that nothing is asked.
    pub(super) fn not_asked_for(&self) -> usize {
        if self.is_keyboard {
            return 0;
        }
        let typed = std::iter::from_fn(|| self.lines.recv_timeout(LOOK).ok());
        typed
            .filter(|typed| !matches!(typed, Ok(Typed::Line(line)) if line.is_empty()))
            .take(MOST_COUNTED)
            .count()
    }
}

/// The next line of `keyboard`; `None` at its end. What is not taken is read to its end and dropped.
fn line(keyboard: &mut impl BufRead) -> io::Result<Option<Typed>> {
    let mut bytes = Vec::new();
    let read = keyboard
        .by_ref()
        .take(LONGEST)
        .read_until(b'\n', &mut bytes)?;
    if read == 0 {
        return Ok(None);
    }
    if read as u64 == LONGEST && bytes.last() != Some(&b'\n') {
        skip_line(keyboard)?;
        return Ok(Some(Typed::NotTaken(
            "the line is longer than 16 kB and was not taken; type a shorter one",
        )));
    }
    Ok(Some(match String::from_utf8(bytes) {
        Ok(line) => Typed::Line(line.trim().to_owned()),
        Err(_other_encoding) => Typed::NotTaken(
            "the line is not in UTF-8 and was not taken; set the terminal to UTF-8, or type it without accents",
        ),
    }))
}

fn skip_line(keyboard: &mut impl BufRead) -> io::Result<()> {
    loop {
        let part = keyboard.fill_buf()?;
        let (end, length) = match part.iter().position(|byte| *byte == b'\n') {
            Some(at) => (true, at + 1),
            None => (part.is_empty(), part.len()),
        };
        keyboard.consume(length);
        if end {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_cannot_be_taken_do_not_end_the_terminal() {
        let mut typed = b"yes\n\xe9t\xe9\n".to_vec();
        typed.extend(vec![b'x'; 50_000]);
        typed.extend(b"\n");
        // As long as is taken, with its end.
        typed.extend(vec![b'y'; LONGEST as usize - 1]);
        typed.extend(b"\nlast");
        let mut keyboard = io::Cursor::new(typed);
        let mut next = || line(&mut keyboard).unwrap();
        assert!(matches!(next(), Some(Typed::Line(line)) if line == "yes"));
        assert!(matches!(next(), Some(Typed::NotTaken(why)) if why.contains("UTF-8")));
        assert!(matches!(next(), Some(Typed::NotTaken(why)) if why.contains("16 kB")));
        assert!(matches!(next(), Some(Typed::Line(line)) if line.len() + 1 == LONGEST as usize));
        assert!(matches!(next(), Some(Typed::Line(line)) if line == "last"));
        assert!(next().is_none());
    }
}
