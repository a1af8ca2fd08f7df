//! The pages of a session with a volunteer: one for the experimenter, one for the participant, one to look on.
//!
//! Pages show the state of a runner and send commands; they decide nothing. [`Site::new`] makes the pages and the [`Desk`], at which the
//! thread that owns store and bench answers; [`Site::serve`] serves the pages on a thread of its own.

mod access;
mod asked;
mod desk;
mod pages;
mod server;
mod view;
mod words;

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::Event;
use tokio::sync::watch;

pub use access::{Access, AccessError, KeepPages, Role};
pub use desk::{Desk, Screen, Shown};
pub use server::{For, ROUTES, Route, StudyPages};
pub use view::{
    Answered, Closed, ClosedStep, Form, Heading, Measured, Open, OpenStep, PlayedBy, Repeats, View,
};
pub use words::{Language, Word};

/// Pages that still load have this long to end.
const GRACE: Duration = Duration::from_millis(500);

/// The pages of a session.
pub struct Site {
    pages: server::Pages,
    ends: watch::Sender<bool>,
}

impl std::fmt::Debug for Site {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Site").finish_non_exhaustive()
    }
}

/// Pages that are served; they end when it is dropped.
#[derive(Debug)]
pub struct Served {
    ends: watch::Sender<bool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// A server that could not begin.
#[derive(Debug, thiserror::Error)]
#[error("the pages could not be served: {0}")]
pub struct ServeError(#[from] std::io::Error);

impl Site {
    /// The pages of the session that shows `view` first, and the desk at which they are answered; `earlier` is what was stored of it until
    /// now, with the time of each event in ms since 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn new(
        (view, earlier): (View, Vec<(i64, Event)>),
        consent: Option<String>,
        played_by: PlayedBy,
        access: Access,
        study: Box<dyn StudyPages>,
    ) -> (Self, Desk) {
        let sha = Sha::of(consent.as_deref().unwrap_or_default().as_bytes());
        let (desk, asking) = Desk::new(view, consent, played_by, earlier);
        let (ends, end) = watch::channel(false);
        let pages = server::Pages {
            asking,
            access,
            study,
            consent: sha,
            hosts: Vec::new(),
            ends: end,
            around: watch::channel(0).0,
            experimenters: AtomicUsize::new(0),
        };
        (Self { pages, ends }, desk)
    }

    /// Serves the pages at `listener` until the value is dropped.
    ///
    /// # Errors
    /// [`ServeError`] where the system gives no thread or refuses the socket.
    pub fn serve(self, listener: TcpListener) -> Result<Served, ServeError> {
        let Self { mut pages, ends } = self;
        pages.hosts = hosts(listener.local_addr()?);
        listener.set_nonblocking(true)?;
        let router = server::router(Arc::new(pages));
        let mut end = ends.subscribe();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        let serving = async move {
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
                return;
            };
            let over = async move {
                let _program_ends = end.wait_for(|ends| *ends).await;
            };
            let server = axum::serve(listener, router).with_graceful_shutdown(over);
            // An error of a connection ends that connection only.
            let _served = server.await;
        };
        let mut late = ends.subscribe();
        let thread = std::thread::Builder::new()
            .name("pages".into())
            .spawn(move || {
                runtime.block_on(async move {
                    let late = async move {
                        let _program_ends = late.wait_for(|ends| *ends).await;
                        tokio::time::sleep(GRACE).await;
                    };
                    tokio::select! {
                        () = serving => {}
                        () = late => {}
                    }
                });
            })?;
        Ok(Served {
            ends,
            thread: Some(thread),
        })
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ends.send_replace(true);
        if let Some(thread) = self.thread.take() {
            let _a_panic_was_said = thread.join();
        }
    }
}

/// The names by which a browser on this machine asks for `address`.
fn hosts(address: SocketAddr) -> Vec<String> {
    let port = address.port();
    let mut hosts = vec![address.to_string()];
    if address.ip().is_loopback() {
        hosts.extend(["localhost", "127.0.0.1", "[::1]"].map(|host| format!("{host}:{port}")));
    }
    hosts
}
