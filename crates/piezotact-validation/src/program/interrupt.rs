//! Ctrl-C, and SIGTERM: panels that are counted end in order; a command that has already written one of its results completes; any other one ends
//! here, has written nothing, and its unfinished files are removed. The second signal ends every command at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use anyhow::anyhow;
use piezotact_dataset::{EndWriting, end_writing};
use signal_hook::consts::{SIGINT, SIGTERM};

use super::failure::{Failure, NAME};
use super::output::say;
use super::progress;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);
/// An exit code is this much above the number of the signal: 130 for Ctrl-C, 143 for SIGTERM.
const EXIT_CODE_ABOVE: usize = 128;

/// The first signal that came; 0 before.
static FIRST: AtomicUsize = AtomicUsize::new(0);
/// Whether work is done that ends by itself.
static BETWEEN: AtomicBool = AtomicBool::new(false);

/// Whether a signal came: nothing more is begun then.
pub(super) fn interrupted() -> bool {
    FIRST.load(Ordering::SeqCst) != 0
}

/// The exit code of a command that a signal ended early.
pub(super) fn exit_code() -> Option<u8> {
    match FIRST.load(Ordering::SeqCst) {
        0 => None,
        signal => u8::try_from(EXIT_CODE_ABOVE + signal).ok(),
    }
}

/// Begins to look for signals, and to draw the progress meanwhile.
pub(super) fn listen() {
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
    // Without it a signal ends the program.
    let Ok(_runs_as_long_as_the_program) = looking else {
        return;
    };
    for signal in [SIGINT, SIGTERM] {
        let registered =
            signal_hook::flag::register_usize(signal, Arc::clone(&arrived), signal as usize);
        if let Err(error) = registered {
            say(&format!("Ctrl-C cannot end a command in order: {error}"));
        }
    }
}

/// Does what the arrival of `signal` asks for.
fn answer(signal: usize) {
    let order = Ordering::SeqCst;
    if FIRST.compare_exchange(0, signal, order, order).is_err() {
        let _ended = end_writing(EndWriting::Now);
        end(
            "stopped immediately: what was written before is complete; give the same command again",
        );
    }
    if !BETWEEN.load(order) && end_writing(EndWriting::UnlessWritten) {
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
    say(&format!("{NAME}: {sentence}"));
    std::process::exit(exit_code().map_or(1, i32::from));
}

/// Work that ends by itself where a signal came, because it leaves something behind. It asks [`interrupted`].
#[derive(Debug)]
pub(super) struct Between(());

impl Between {
    /// From now on, until this is dropped.
    pub(super) fn moments() -> Self {
        BETWEEN.store(true, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Between {
    fn drop(&mut self) {
        BETWEEN.store(false, Ordering::SeqCst);
    }
}

/// How a command ends that a signal ended early: what was done, and how to go on.
pub(super) fn failure(done: &str, go_on: &str) -> Failure {
    Failure::Data(anyhow!("interrupted: {done}; {go_on}"))
}
