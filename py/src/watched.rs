//! Work that leaves Python to its other threads, and that Ctrl-C ends for whoever waits for it.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

use piezotact_app::library;
use pyo3::prelude::*;

use crate::errors;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);
/// The stack of the thread that works: that of a program's first thread on Linux, bytes.
const STACK: usize = 8 << 20;

/// What `work` gives, done without the interpreter's lock. On Ctrl-C a run on a bench is stopped, and the exception is raised at once;
/// what is computed then ends by itself, and nobody gets it.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (done, mut waiting) = channel();
    let thread = Builder::new().name("piezotact".into()).stack_size(STACK);
    thread.spawn(move || {
        let _nobody_waits = done.send(work());
    })?;
    loop {
        let found;
        (waiting, found) = py.detach(move || {
            let found = waiting.recv_timeout(LOOK);
            (waiting, found)
        });
        match found {
            Ok(value) => return Ok(value),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| library::stop())?
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(errors::internal("it ended without a result"));
            }
        }
    }
}
