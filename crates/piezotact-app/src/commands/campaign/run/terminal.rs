//! Lines typed by the experimenter, or by a script.

use std::io::{self, BufRead as _, IsTerminal as _, Write as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use crate::failure::Outcome;
use crate::interrupt::interrupted;
use crate::output::print;

/// How often a signal is looked for while a line is awaited.
const LOOK: Duration = Duration::from_millis(50);

/// What came from the keyboard.
pub(super) enum Typed {
    /// A line.
    Line(String),
    /// Nothing more comes: the input ended, or Ctrl-C was typed.
    End,
}

/// The keyboard and the screen.
pub(super) struct Terminal {
    lines: Receiver<io::Result<String>>,
    is_keyboard: bool,
}

impl Terminal {
    /// Begins to read lines.
    pub(super) fn new() -> Self {
        let (sender, lines) = channel();
        // It waits in a read that nothing ends, until the program ends.
        let _reads_as_long_as_the_program = std::thread::spawn(move || {
            for line in io::stdin().lock().lines() {
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
                Ok(Ok(line)) => {
                    // What a script types is not on the screen.
                    if !self.is_keyboard {
                        print(&line)?;
                    }
                    return Ok(Typed::Line(line.trim().to_owned()));
                }
                Ok(Err(error)) => return Err(error.into()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(Typed::End),
            }
        }
    }
}
