//! Runs that are watched while they are acquired: their documents as lines of JSON, at the pace of a real bench.

use std::io::Write as _;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use piezotact::run::{Judged, RunDocument, Sink, SinkError};
use piezotact_bench::{Acquire, Bench, Paced};

/// Whether the documents of runs are printed.
static IS_PRINTED: AtomicBool = AtomicBool::new(false);
/// Whether simulated benches take as long as real ones.
static IS_PACED: AtomicBool = AtomicBool::new(false);
/// Who else watches.
static WATCHER: OnceLock<Watcher> = OnceLock::new();

type Watcher = Box<dyn Fn(&RunDocument) + Send + Sync>;

/// The option of a command whose runs can be watched.
#[derive(Debug, clap::Args)]
pub(crate) struct Live {
    /// Prints the documents of every run (start, samples, judgements, end) as lines of JSON while it is acquired; a simulated bench then
    /// takes as long as a real one.
    #[arg(long)]
    live: bool,
}

impl Live {
    /// Whether runs are to be watched.
    pub(crate) fn is_asked_for(&self) -> bool {
        self.live
    }

    /// The runs of this command are watched, where that was asked for.
    pub(crate) fn begin(&self) {
        IS_PRINTED.store(self.live, Ordering::SeqCst);
        IS_PACED.store(self.live, Ordering::SeqCst);
    }
}

/// From now on simulated benches take as long as real ones.
#[cfg(feature = "web")]
pub(crate) fn in_real_time() {
    IS_PACED.store(true, Ordering::SeqCst);
}

/// From now on the documents of runs go to `watcher` too. One watches.
#[cfg(feature = "web")]
pub(crate) fn watched_by(watcher: Watcher) {
    let _first_stays = WATCHER.set(watcher);
}

/// `bench` at the pace of a real one where that was asked for.
pub(crate) fn bench(bench: Bench) -> Bench {
    match IS_PACED.load(Ordering::SeqCst) {
        true => bench.in_real_time(),
        false => bench,
    }
}

/// As [`bench()`], of an acquiring half alone.
pub(crate) fn acquirer(acquirer: Box<dyn Acquire>) -> Box<dyn Acquire> {
    match IS_PACED.load(Ordering::SeqCst) {
        true => Box::new(Paced::real_time(acquirer)),
        false => acquirer,
    }
}

/// Shows `document` to whoever watches. They may have gone: the run goes on.
pub(crate) fn show(document: &RunDocument) {
    if let Some(watcher) = WATCHER.get() {
        watcher(document);
    }
    if !IS_PRINTED.load(Ordering::SeqCst) {
        return;
    }
    let Ok(mut line) = serde_json::to_vec(document) else {
        return;
    };
    line.push(b'\n');
    let mut out = std::io::stdout().lock();
    let _gone = out.write_all(&line).and_then(|()| out.flush());
}

/// A sink whose documents are shown.
pub(crate) struct Showing<S>(pub(crate) S);

impl<S: Sink> Sink for Showing<S> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let judged = self.0.take(document);
        show(document);
        judged
    }
}
