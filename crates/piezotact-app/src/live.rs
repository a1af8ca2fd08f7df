//! Runs that are watched while they are acquired: their documents as lines of JSON, at the pace of a real bench.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use piezotact::run::{Judged, RunDocument, Sink, SinkError};
use piezotact_bench::{Acquire, Bench, Paced};

/// Whether the runs of this command are watched.
static IS_WATCHED: AtomicBool = AtomicBool::new(false);

/// The option of a command whose runs can be watched.
#[derive(Debug, clap::Args)]
pub(crate) struct Live {
    /// Prints the documents of every run (start, samples, judgements, end) as lines of JSON while it is acquired; a simulated bench then
    /// takes as long as a real one.
    #[arg(long)]
    live: bool,
}

impl Live {
    /// The runs of this command are watched, where that was asked for.
    pub(crate) fn begin(&self) {
        IS_WATCHED.store(self.live, Ordering::SeqCst);
    }
}

/// `bench` at the pace of a real one where its runs are watched.
pub(crate) fn bench(bench: Bench) -> Bench {
    match IS_WATCHED.load(Ordering::SeqCst) {
        true => bench.in_real_time(),
        false => bench,
    }
}

/// As [`bench`], of an acquiring half alone.
pub(crate) fn acquirer(acquirer: Box<dyn Acquire>) -> Box<dyn Acquire> {
    match IS_WATCHED.load(Ordering::SeqCst) {
        true => Box::new(Paced::real_time(acquirer)),
        false => acquirer,
    }
}

/// Prints `document` where runs are watched. Whoever watches may have gone: the run goes on.
pub(crate) fn show(document: &RunDocument) {
    if !IS_WATCHED.load(Ordering::SeqCst) {
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
