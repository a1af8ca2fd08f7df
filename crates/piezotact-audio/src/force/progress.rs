//! What came from a source so far, and whether it still talks.

use piezotact::recording::{LostBy, RecordingWarning};
use std::time::{Duration, Instant};

use piezotact::Warning;

use super::error::ForceError;

/// From this share of unreadable lines on there is a warning.
const MOST_UNREADABLE: f64 = 0.01;
/// An example of a line is no longer than this, characters.
const LONGEST_EXAMPLE: usize = 60;

/// What came so far.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    pub(super) name: String,
    /// How long a source may take until its first reading, and between two.
    first_within: Duration,
    longest_pause: Duration,
    /// When it was started, or sent its last reading.
    since: Instant,
    pub(super) readings: u64,
    /// Lines that hold or should hold a reading.
    lines: usize,
    unreadable: usize,
    unreadable_since: usize,
    without_unit_since: usize,
    example: String,
}

impl Progress {
    pub(super) fn new(
        name: &str,
        first_within: Duration,
        longest_pause: Duration,
        now: Instant,
    ) -> Self {
        Self {
            name: name.to_owned(),
            first_within,
            longest_pause,
            since: now,
            readings: 0,
            lines: 0,
            unreadable: 0,
            unreadable_since: 0,
            without_unit_since: 0,
            example: String::new(),
        }
    }

    pub(super) fn reading(&mut self, at: Instant) {
        self.lines += 1;
        self.readings += 1;
        self.since = at;
        self.unreadable_since = 0;
        self.without_unit_since = 0;
    }

    pub(super) fn without_unit(&mut self) {
        self.without_unit_since += 1;
    }

    pub(super) fn unreadable(&mut self, line: &[u8]) {
        self.lines += 1;
        self.unreadable += 1;
        self.unreadable_since += 1;
        let text = String::from_utf8_lossy(line);
        let shown = |sign: char| if sign.is_control() { '·' } else { sign };
        self.example = text.chars().take(LONGEST_EXAMPLE).map(shown).collect();
    }

    /// Whether the source still talks at `now`.
    pub(super) fn check(&self, now: Instant) -> Result<(), ForceError> {
        let pause = now.saturating_duration_since(self.since);
        let most = match self.readings {
            0 => self.first_within,
            _ => self.longest_pause,
        };
        if pause <= most {
            return Ok(());
        }
        let name = self.name.clone();
        Err(match (self.without_unit_since, self.unreadable_since) {
            (1.., _) => ForceError::NoUnit { name },
            (0, 1..) => ForceError::Unreadable {
                name,
                pause: most,
                example: self.example.clone(),
            },
            (0, 0) => ForceError::Silent {
                name,
                pause: most,
                readings: self.readings,
            },
        })
    }

    pub(super) fn warnings(&self) -> Vec<Warning> {
        let many = self.unreadable as f64 > MOST_UNREADABLE * self.lines as f64;
        let warning = many.then(|| {
            Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::ForceLines {
                    signal: self.name.clone(),
                    unreadable: self.unreadable,
                    lines: self.lines,
                    example: self.example.clone(),
                },
            })
        });
        warning.into_iter().collect()
    }
}
