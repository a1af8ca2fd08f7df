//! Progress of long work on standard error: what is done, of how many, and about how long is left.
//!
//! A run on a bench has a bar from its start, as its length is known. Other work is shown once it has taken longer than
//! [`LONG`]: on a terminal a line that changes, elsewhere a plain line every [`PLAIN`], and only of work with several items.

use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle, WeakProgressBar};
use piezotact::quantity::Seconds;

use crate::output::{counted, message, say};

/// Work that takes longer is shown.
const LONG: Duration = Duration::from_secs(5);
/// How often a plain line is said where nobody looks at a terminal.
const PLAIN: Duration = Duration::from_secs(60);

/// Nothing is estimated from less, s.
const LEAST_S: f64 = 2.0;

/// How work of many items is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words {
    /// "reading"
    pub(crate) doing: &'static str,
    /// "read"
    pub(crate) done: &'static str,
    /// "recording"
    pub(crate) item: &'static str,
    /// What follows when all items are done, before the work ends: "comparing".
    pub(crate) then: &'static str,
}

/// Work as it is shown.
struct State {
    what: What,
    began: Instant,
    /// When a plain line is due.
    plain: Duration,
}

enum What {
    /// One thing, of which only the time is known that it took so far.
    One(String),
    Items(Items),
}

struct Items {
    words: Words,
    sizes: Sizes,
    done: usize,
    /// When the last was done, after the beginning.
    last: Duration,
}

/// What the items take compared with each other.
enum Sizes {
    Known(Vec<f64>),
    /// So many items, of which nothing is known: no time is estimated.
    Unknown(usize),
}

impl Sizes {
    fn len(&self) -> usize {
        match self {
            Self::Known(sizes) => sizes.len(),
            Self::Unknown(count) => *count,
        }
    }
}

/// The work that is being done, the part that contains others first.
static WORK: Mutex<Vec<State>> = Mutex::new(Vec::new());
/// The line on the terminal, and the bar of a run.
static LINES: Mutex<Lines> = Mutex::new(Lines {
    work: None,
    run: None,
});

struct Lines {
    work: Option<ProgressBar>,
    run: Option<WeakProgressBar>,
}

fn work() -> MutexGuard<'static, Vec<State>> {
    WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

fn lines() -> MutexGuard<'static, Lines> {
    LINES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether somebody is asked for lines on the terminal.
static PROMPTED: AtomicBool = AtomicBool::new(false);

/// From now on lines are asked for on the terminal: no work is shown any more, which would stand in what is typed.
#[cfg(feature = "study")]
pub(crate) fn keep_off() {
    PROMPTED.store(true, Ordering::SeqCst);
    clear();
}

/// Work that is shown until this is dropped.
#[derive(Debug)]
pub(crate) struct Work(());

impl Work {
    fn of(what: What) -> Self {
        work().push(State {
            what,
            began: Instant::now(),
            plain: PLAIN,
        });
        Self(())
    }

    /// One thing: `what` is done, such as "comparing".
    pub(crate) fn one(what: impl Into<String>) -> Self {
        Self::of(What::One(what.into()))
    }

    /// Items of the `sizes`: an item of twice the size is expected to take twice as long.
    pub(crate) fn of_sizes(words: Words, sizes: Vec<f64>) -> Self {
        Self::of_items(words, Sizes::Known(sizes))
    }

    /// `count` items that take different times, none of which is known.
    pub(crate) fn of_steps(words: Words, count: usize) -> Self {
        Self::of_items(words, Sizes::Unknown(count))
    }

    fn of_items(words: Words, sizes: Sizes) -> Self {
        Self::of(What::Items(Items {
            words,
            sizes,
            done: 0,
            last: Duration::ZERO,
        }))
    }

    /// One item for each file, of the size of the file.
    pub(crate) fn of_files<P: AsRef<Path>>(words: Words, files: &[P]) -> Self {
        let size = |file: &P| std::fs::metadata(file).map_or(1.0, |found| found.len() as f64);
        Self::of_sizes(words, files.iter().map(size).collect())
    }

    /// One more item is done.
    pub(crate) fn one_more(&self) {
        if let Some(state) = work().last_mut()
            && let What::Items(items) = &mut state.what
        {
            items.done += 1;
            items.last = state.began.elapsed();
        }
    }

    /// So many items are done.
    #[cfg(feature = "study")]
    pub(crate) fn up_to(&self, count: usize) {
        if let Some(state) = work().last_mut()
            && let What::Items(items) = &mut state.what
        {
            items.up_to(count, state.began.elapsed());
        }
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        work().pop();
        clear();
    }
}

/// What is done of the items, such as "3 of 12 recordings were read"; `None` of work that has no items.
pub(crate) fn done() -> Option<String> {
    work().iter().rev().find_map(|state| match &state.what {
        What::Items(items) if items.sizes.len() > 1 => Some(items.done_text()),
        _ => None,
    })
}

/// Shows the work that takes long.
pub(crate) fn show() {
    if PROMPTED.load(Ordering::SeqCst) {
        return;
    }
    let terminal = std::io::stderr().is_terminal();
    let text = {
        let mut work = work();
        let is_long = work.first().is_some_and(|all| all.began.elapsed() >= LONG);
        let Some(state) = work.last_mut() else { return };
        let elapsed = state.began.elapsed();
        let is_due = match (&state.what, terminal) {
            (_, true) => is_long,
            (What::Items(items), false) => items.sizes.len() > 1 && elapsed >= state.plain,
            (What::One(_), false) => false,
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
    let mut lines = lines();
    let run = lines.run.as_ref().and_then(WeakProgressBar::upgrade);
    if run.is_some_and(|run| !run.is_finished()) {
        return;
    }
    let line = lines.work.get_or_insert_with(|| {
        let bar = ProgressBar::new(0);
        // The template is a constant; were it wrong, the plain bar serves.
        if let Ok(style) = ProgressStyle::with_template("{msg}") {
            bar.set_style(style);
        }
        bar
    });
    line.set_message(message(&text));
    line.tick();
}

/// Takes the line off the terminal.
pub(crate) fn clear() {
    if let Some(line) = lines().work.take() {
        line.finish_and_clear();
    }
}

/// Does `write`, which writes to the terminal, with what stands there taken off meanwhile.
pub(crate) fn aside<T>(write: impl FnOnce() -> T) -> T {
    let bar = {
        let lines = lines();
        let run = lines.run.as_ref().and_then(WeakProgressBar::upgrade);
        lines.work.clone().or(run)
    };
    match bar {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// A bar that grows with the time that a run has acquired, with its figures as the message below it; on anything but a terminal, a line at
/// its start. Of a run that ends when it is stopped there is no bar, only the figures.
pub(crate) fn of_run(what: &str, length: Option<Seconds>) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        say(&format!("{what} …"));
        return ProgressBar::hidden();
    }
    clear();
    let (bar, template) = match length {
        Some(length) => (
            ProgressBar::new((length.0 * 10.0) as u64),
            "{prefix} [{bar:30}] {percent:>3} % {eta}{msg}",
        ),
        None => (ProgressBar::new_spinner(), "{prefix} {elapsed}{msg}"),
    };
    // The template is a constant; were it wrong, the plain bar serves.
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_prefix(message(what));
    bar.enable_steady_tick(Duration::from_millis(200));
    lines().run = Some(bar.downgrade());
    bar
}

impl State {
    /// What is shown after `elapsed`.
    fn text(&self, elapsed: Duration) -> String {
        let so_far = |what: &str| format!("{what}: {} so far", passed(elapsed));
        match &self.what {
            What::One(what) => so_far(what),
            What::Items(items) if items.sizes.len() < 2 => so_far(items.words.doing),
            What::Items(items) => items.text(elapsed),
        }
    }
}

impl Items {
    /// So many are done after `elapsed`, if they were not before.
    #[cfg(feature = "study")]
    fn up_to(&mut self, count: usize, elapsed: Duration) {
        if count > self.done {
            self.done = count;
            self.last = elapsed;
        }
    }

    fn done_text(&self) -> String {
        format!(
            "{} of {} {} {}",
            self.done,
            counted(self.sizes.len(), self.words.item),
            if self.done == 1 { "was" } else { "were" },
            self.words.done
        )
    }

    fn text(&self, elapsed: Duration) -> String {
        let (words, all) = (&self.words, self.sizes.len());
        if self.done >= all {
            let since = elapsed.saturating_sub(self.last);
            return format!("{}: {} so far", words.then, passed(since));
        }
        let mut text = format!(
            "{}: {} of {}",
            words.doing,
            self.done,
            counted(all, words.item)
        );
        match (&self.sizes, self.left(elapsed)) {
            (Sizes::Unknown(_), _) => text += &format!(", {} so far", passed(elapsed)),
            (Sizes::Known(_), Some(left)) => text += &format!(", {left}"),
            (Sizes::Known(_), None) => {}
        }
        text
    }

    /// How long it takes until all items are done, in words; `None` while there is nothing to estimate it from: before the first
    /// is done, and where the last takes longer than expected.
    fn left(&self, elapsed: Duration) -> Option<String> {
        let size = |sizes: &[f64]| sizes.iter().sum::<f64>();
        let Sizes::Known(sizes) = &self.sizes else {
            return None;
        };
        let (done, open) = sizes.split_at(self.done.min(sizes.len()));
        let (current, after) = open.split_first()?;
        let [elapsed, last] = [elapsed, self.last].map(|time| time.as_secs_f64());
        let each = last / size(done);
        if self.done == 0 || !each.is_finite() || last < LEAST_S {
            return None;
        }
        let of_current = each * current - (elapsed - last);
        let left_s = if of_current > 0.0 {
            of_current + each * size(after)
        } else {
            // The current item takes longer than the others did, so that these may have been easy ones.
            elapsed / (size(done) + current) * size(after)
        };
        (left_s > 0.0).then(|| match left_s {
            ..5.0 => "less than 5 s left".into(),
            _ => format!("about {} left", time(Duration::from_secs_f64(left_s))),
        })
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
pub(crate) fn time(time: Duration) -> String {
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

    const READING: Words = Words {
        doing: "reading",
        done: "read",
        item: "recording",
        then: "comparing",
    };

    fn items(sizes: &[f64], done: usize, last_s: u64) -> Items {
        Items {
            words: READING,
            sizes: Sizes::Known(sizes.to_vec()),
            done,
            last: Duration::from_secs(last_s),
        }
    }

    fn text(items: &Items, elapsed_s: u64) -> String {
        items.text(Duration::from_secs(elapsed_s))
    }

    /// Nothing is estimated before an item is done, nor of a last one that takes longer than it should.
    #[test]
    fn the_time_left_is_estimated_from_what_is_done() {
        let equal = [1.0; 4];
        for (done, last_s, elapsed_s, expected) in [
            (0, 0, 30, "reading: 0 of 4 recordings"),
            (1, 1, 1, "reading: 1 of 4 recordings"),
            (1, 20, 20, "reading: 1 of 4 recordings, about 1 min left"),
            (2, 40, 52, "reading: 2 of 4 recordings, about 30 s left"),
            // The third takes 60 s where the others took 20 s each: all take 100/3 s as far as is known.
            (2, 40, 100, "reading: 2 of 4 recordings, about 35 s left"),
            (3, 60, 78, "reading: 3 of 4 recordings, less than 5 s left"),
            (3, 60, 90, "reading: 3 of 4 recordings"),
            (4, 80, 92, "comparing: 12 s so far"),
        ] {
            assert_eq!(text(&items(&equal, done, last_s), elapsed_s), expected);
        }
    }

    /// A volunteer is measured as long as 12 strokes play, and has two trials of 42 strokes: while the first volunteer is here, the time
    /// of all is known.
    #[cfg(feature = "study")]
    #[test]
    fn the_time_left_is_known_within_the_first_of_several_volunteers() {
        let mut steps = items(&[12.0, 42.0, 42.0].repeat(6), 0, 0);
        steps.up_to(1, Duration::from_secs(4));
        steps.up_to(2, Duration::from_secs(18));
        // 54 of 576 strokes took 18 s.
        assert_eq!(
            text(&steps, 18),
            "reading: 2 of 18 recordings, about 3 min left"
        );
        // Of trials that were not needed, none is left.
        steps.up_to(15, Duration::from_secs(160));
        steps.up_to(15, Duration::from_secs(170));
        assert_eq!(
            text(&steps, 160),
            "reading: 15 of 18 recordings, about 35 s left"
        );
    }

    /// A file of ten times the size is expected to take ten times as long.
    #[test]
    fn the_time_left_counts_the_sizes() {
        let first_is_small = items(&[1.0, 10.0, 10.0], 1, 6);
        assert_eq!(
            text(&first_is_small, 6),
            "reading: 1 of 3 recordings, about 2 min left"
        );
        let of_nothing = items(&[0.0, 10.0], 1, 6);
        assert_eq!(text(&of_nothing, 6), "reading: 1 of 2 recordings");
        let unknown = Items {
            sizes: Sizes::Unknown(3),
            ..items(&[], 1, 6)
        };
        assert_eq!(
            text(&unknown, 70),
            "reading: 1 of 3 recordings, 1 min 10 s so far"
        );
    }

    #[test]
    fn what_is_done_is_counted() {
        let of = |sizes: &[f64], done| items(sizes, done, 1).done_text();
        assert_eq!(
            [of(&[1.0; 12], 3), of(&[1.0; 12], 1), of(&[1.0; 12], 0)],
            [
                "3 of 12 recordings were read",
                "1 of 12 recordings was read",
                "0 of 12 recordings were read"
            ]
        );
    }

    #[test]
    fn a_time_is_said_in_seconds_minutes_and_hours() {
        let of = |seconds| time(Duration::from_secs(seconds));
        assert_eq!(
            [of(12), of(55), of(56), of(61), of(3_600), of(7_500)],
            ["15 s", "55 s", "1 min", "2 min", "1 h 00 min", "2 h 05 min"]
        );
        let so_far = |seconds| passed(Duration::from_secs(seconds));
        assert_eq!([so_far(12), so_far(125)], ["12 s", "2 min 05 s"]);
    }
}
