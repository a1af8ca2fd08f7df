//! Progress of long work on standard error: what is done, of how many, and about how long is left: on a terminal a line that changes, elsewhere
//! a plain line every minute.

use std::io::{IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use piezotact::number::counted;

use super::output::say;

/// Work that takes longer is shown on a terminal.
const LONG: Duration = Duration::from_secs(5);
/// How often a plain line is said where nobody looks at a terminal.
const PLAIN: Duration = Duration::from_secs(60);

/// How work of many items is said.
#[derive(Clone, Copy, Debug)]
pub(super) struct Words {
    /// "measuring"
    pub(super) doing: &'static str,
    /// "measured"
    pub(super) done: &'static str,
    /// "panel"
    pub(super) item: &'static str,
    /// What follows when all items are done, before the work ends: "counting".
    pub(super) then: &'static str,
}

/// Whether the items take the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Items {
    Alike,
    /// No time is estimated.
    Unlike,
}

struct State {
    words: Words,
    items: Items,
    all: usize,
    done: usize,
    began: Instant,
    /// When the last was done, after the beginning.
    last: Duration,
    /// When a plain line is due.
    plain: Duration,
}

/// The work that is being done.
static WORK: Mutex<Option<State>> = Mutex::new(None);
/// Whether a line stands on the terminal.
static LINE: Mutex<bool> = Mutex::new(false);

fn work() -> MutexGuard<'static, Option<State>> {
    WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Work that is shown until this is dropped.
#[derive(Debug)]
pub(super) struct Work(());

impl Work {
    /// `all` items.
    pub(super) fn of(words: Words, items: Items, all: usize) -> Self {
        *work() = Some(State {
            words,
            items,
            all,
            done: 0,
            began: Instant::now(),
            last: Duration::ZERO,
            plain: PLAIN,
        });
        Self(())
    }

    /// One more item is done.
    pub(super) fn one_more(&self) {
        if let Some(state) = work().as_mut() {
            state.done += 1;
            state.last = state.began.elapsed();
        }
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        *work() = None;
        clear();
    }
}

/// What is done of the items, such as "3 of 12 panels were measured"; `None` where there are not several.
pub(super) fn done() -> Option<String> {
    let work = work();
    let state = work.as_ref().filter(|state| state.all > 1)?;
    Some(format!(
        "{} of {} {} {}",
        state.done,
        counted(state.all, state.words.item),
        if state.done == 1 { "was" } else { "were" },
        state.words.done
    ))
}

/// Shows the work that takes long.
pub(super) fn show() {
    let terminal = std::io::stderr().is_terminal();
    let text = {
        let mut work = work();
        let Some(state) = work.as_mut() else { return };
        let elapsed = state.began.elapsed();
        let is_due = match terminal {
            true => elapsed >= LONG,
            false => state.all > 1 && elapsed >= state.plain,
        };
        if !is_due {
            return;
        }
        state.plain = elapsed + PLAIN;
        state.text(elapsed)
    };
    if !terminal {
        return say(&text);
    }
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    let _nobody_sees = write!(std::io::stderr().lock(), "\r\u{1b}[K{text}");
    *line = true;
}

/// Takes the line off the terminal.
pub(super) fn clear() {
    aside(|| ());
}

/// Does `write`, which writes to the terminal, with what stands there taken off.
pub(super) fn aside<T>(write: impl FnOnce() -> T) -> T {
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    if std::mem::take(&mut *line) {
        let _nobody_sees = write!(std::io::stderr().lock(), "\r\u{1b}[K");
    }
    write()
}

impl State {
    /// What is shown after `elapsed`.
    fn text(&self, elapsed: Duration) -> String {
        let words = self.words;
        if self.all < 2 {
            return format!("{}: {} so far", words.doing, passed(elapsed));
        }
        if self.done >= self.all {
            let since = elapsed.saturating_sub(self.last);
            return format!("{}: {} so far", words.then, passed(since));
        }
        let counted = counted(self.all, words.item);
        let text = format!("{}: {} of {counted}", words.doing, self.done);
        match self.left(elapsed) {
            _ if self.items == Items::Unlike => format!("{text}, {} so far", passed(elapsed)),
            Some(left) => format!("{text}, about {} left", time(left)),
            None => text,
        }
    }

    /// How long it takes until all items are done; `None` before the first is, and where the last takes longer than it should.
    fn left(&self, elapsed: Duration) -> Option<Duration> {
        let each = self.last.checked_div(u32::try_from(self.done).ok()?)?;
        let left = each * u32::try_from(self.all - self.done).ok()?;
        left.checked_sub(elapsed - self.last)
    }
}

/// A time that has passed, in words.
fn passed(time: Duration) -> String {
    match (time.as_secs() / 60, time.as_secs() % 60) {
        (0, seconds) => format!("{seconds} s"),
        (minutes, seconds) => format!("{minutes} min {seconds:02} s"),
    }
}

/// A time that is left, in words: in steps of 5 s below a minute, else in minutes.
pub(super) fn time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds <= 55.0 {
        return format!("{:.0} s", (seconds / 5.0).ceil() * 5.0);
    }
    let minutes = (seconds / 60.0).ceil() as u64;
    match (minutes / 60, minutes % 60) {
        (0, minutes) => format!("{minutes} min"),
        (hours, minutes) => format!("{hours} h {minutes:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is estimated before an item is done, nor of one that takes longer than it should.
    #[test]
    fn the_time_left_is_estimated_from_what_is_done() {
        let text = |items, done, last_s, elapsed_s| {
            let words = Words {
                doing: "measuring",
                done: "measured",
                item: "panel",
                then: "counting",
            };
            let state = State {
                words,
                items,
                all: 4,
                done,
                began: Instant::now(),
                last: Duration::from_secs(last_s),
                plain: PLAIN,
            };
            state.text(Duration::from_secs(elapsed_s))
        };
        for (items, done, last_s, elapsed_s, expected) in [
            (Items::Alike, 0, 0, 30, "measuring: 0 of 4 panels"),
            (
                Items::Alike,
                1,
                20,
                20,
                "measuring: 1 of 4 panels, about 1 min left",
            ),
            (
                Items::Alike,
                2,
                40,
                52,
                "measuring: 2 of 4 panels, about 30 s left",
            ),
            (Items::Alike, 3, 60, 90, "measuring: 3 of 4 panels"),
            (
                Items::Unlike,
                1,
                6,
                70,
                "measuring: 1 of 4 panels, 1 min 10 s so far",
            ),
            (Items::Alike, 4, 80, 92, "counting: 12 s so far"),
        ] {
            assert_eq!(text(items, done, last_s, elapsed_s), expected);
        }
        assert_eq!(time(Duration::from_secs(7_500)), "2 h 05 min");
    }
}
