//! Ctrl-C, and SIGTERM: a command ends in order, and says what was done and how to go on.
//!
//! One thread looks for signals, and draws the progress meanwhile. What the first signal does depends on the command:
//!
//! - A run on a bench is stopped; the command keeps the samples and ends by itself.
//! - Work that leaves a result after each item ([`Between`]) ends by itself before the next item.
//! - A command that has already written one of its results completes: the rest follows within moments.
//! - Any other command ends here. It has written nothing, and its unfinished files are removed.
//!
//! The second signal ends every command at once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::anyhow;
use piezotact_bench::StopHandle;
use piezotact_dataset::{EndWriting, end_writing};
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::failure::Failure;
use crate::output::say;
use crate::progress;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);
/// An exit code is this much above the number of the signal: 130 for Ctrl-C, 143 for SIGTERM.
const EXIT_CODE_ABOVE: usize = 128;

/// The first signal that came; 0 before.
static FIRST: AtomicUsize = AtomicUsize::new(0);
/// The run that a signal stops.
static RUNNING: Mutex<Running> = Mutex::new(Running {
    stop: None,
    journals: Journals::None,
});
/// The work that ends by itself: where an item is completed first, its name.
static BETWEEN: Mutex<Vec<Option<&'static str>>> = Mutex::new(Vec::new());

struct Running {
    stop: Option<StopHandle>,
    journals: Journals,
}

/// Whether there may be journals of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Journals {
    None,
    Some,
}

/// Whether a signal came: nothing more is begun then.
pub(crate) fn interrupted() -> bool {
    FIRST.load(Ordering::SeqCst) != 0
}

/// The exit code of a command that a signal ended early.
pub(crate) fn exit_code() -> Option<u8> {
    match FIRST.load(Ordering::SeqCst) {
        0 => None,
        signal => u8::try_from(EXIT_CODE_ABOVE + signal).ok(),
    }
}

/// Begins to look for signals.
pub(crate) fn listen() {
    let arrived = Arc::new(AtomicUsize::new(0));
    let seen = Arc::clone(&arrived);
    let thread = std::thread::Builder::new().name("signals".into());
    let looking = thread.spawn(move || {
        loop {
            std::thread::sleep(LOOK);
            match seen.swap(0, Ordering::SeqCst) {
                0 => progress::show(),
                signal => answer(signal),
            }
        }
    });
    // Without it a signal ends the program, and journals keep what was acquired.
    let Ok(_runs_as_long_as_the_program) = looking else {
        return;
    };
    for signal in signals() {
        let registered =
            signal_hook::flag::register_usize(signal, Arc::clone(&arrived), signal as usize);
        if let Err(error) = registered {
            say(&format!("Ctrl-C cannot end a command in order: {error}"));
        }
    }
}

/// The signals that end a command.
fn signals() -> Vec<i32> {
    #[cfg(not(unix))]
    return vec![SIGINT, SIGTERM];
    #[cfg(unix)]
    {
        let mut signals = vec![SIGINT, SIGTERM];
        // `nohup` has the end of the terminal ignored.
        if !is_ignored(signal_hook::consts::SIGHUP) {
            signals.push(signal_hook::consts::SIGHUP);
        }
        signals
    }
}

/// Whether whoever started the program has it ignore `signal`, as far as the system says it.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Does what the arrival of `signal` asks for.
fn answer(signal: usize) {
    let order = Ordering::SeqCst;
    let is_first = FIRST.compare_exchange(0, signal, order, order).is_ok();
    let (running, journals) = {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        (running.stop.take(), running.journals)
    };
    if !is_first {
        let _ended = end_writing(EndWriting::Now);
        end(match journals {
            Journals::Some => {
                "stopped immediately: the acquired samples are in the journal, which `piezotact info` reads by the name of the \
                 recording; the next command of that name keeps the journal and removes incomplete files"
            }
            Journals::None => {
                "stopped immediately: what was written before is complete; give the same command again"
            }
        });
    }
    if let Some(stop) = running {
        stop.stop();
    } else if let Some(between) = between().last().copied() {
        if let Some(item) = between {
            say(&format!(
                "stops after this {item}; Ctrl-C again stops at once"
            ));
        }
    } else if end_writing(EndWriting::UnlessWritten) {
        end(&match progress::done() {
            Some(done) => {
                format!("interrupted: {done}, and nothing was written; give the same command again")
            }
            None => "interrupted: nothing was written; give the same command again".into(),
        });
    }
}

fn end(sentence: &str) -> ! {
    progress::clear();
    say(&format!("piezotact: {sentence}"));
    std::process::exit(exit_code().map_or(1, i32::from));
}

/// Lets a signal stop what runs with `handle`: the run ends in order, and what was acquired is kept.
pub(crate) fn stops(handle: &StopHandle) {
    if interrupted() {
        handle.stop();
        return;
    }
    *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Running {
        stop: Some(handle.clone()),
        journals: Journals::Some,
    };
    // A signal that came in between.
    if interrupted() {
        handle.stop();
    }
}

/// Stops the run that a signal would stop, if there is one.
pub(crate) fn stop_run() {
    let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(stop) = running.stop.take() {
        stop.stop();
    }
}

/// Work that ends by itself where a signal came, because it leaves something behind. It asks [`interrupted`].
#[derive(Debug)]
pub(crate) struct Between(());

impl Between {
    /// From now on, until this is dropped; each `item` is completed.
    pub(crate) fn items(item: &'static str) -> Self {
        between().push(Some(item));
        Self(())
    }

    /// From now on, until this is dropped; it asks all the time.
    pub(crate) fn moments() -> Self {
        between().push(None);
        Self(())
    }
}

impl Drop for Between {
    fn drop(&mut self) {
        between().pop();
    }
}

fn between() -> MutexGuard<'static, Vec<Option<&'static str>>> {
    BETWEEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How a command ends that a signal ended early: what was done, and how to go on.
pub(crate) fn failure(done: &str, go_on: &str) -> Failure {
    Failure::Data(anyhow!("interrupted: {done}; {go_on}"))
}
