//! The pages of a session with a volunteer: one for the experimenter, one for the participant, one to look on.
//!
//! Pages show the state of a runner and send commands; they decide nothing. [`Site::new`] makes the pages and the [`Desk`], at which the
//! thread that owns store and bench answers; [`Site::serve`] serves the pages on a thread of its own.

mod access;
mod asked;
mod assets;
mod beat;
mod certificate;
mod console;
mod desk;
mod entrance;
mod live;
mod pages;
mod password;
mod qr;
mod server;
mod serving;
mod study;
mod tries;
mod view;
mod words;

use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::Event;
use piezotact_people::campaign::text::TextError;
use piezotact_study::session::PlayStop;
use tokio::sync::watch;

use beat::Beat;

pub use access::{Access, KeepPages, Key, Role};
pub use certificate::{Certificate, CertificateError, VALIDITY};
pub use console::{
    Answerable, BenchRequest, ConsoleDesk, ConsoleView, Field, FieldKind, MadeFile, Procedure,
};
pub use desk::{Desk, Screen, Shown};
pub use live::{Live, Pictures};
pub use password::Password;
pub use server::{For, ROUTES, Route};
pub use study::{Listed, Overview, Standing, StudyPages};
pub use view::{
    Answered, Closed, ClosedStep, Form, Heading, Measured, Open, OpenStep, PlayedBy, Repeats, Text,
    View,
};
pub use words::{Language, Word};

/// Threads for what takes long: passwords, reports, files.
const BLOCKING: usize = 4;

/// The pages of a session.
pub struct Site {
    pages: entrance::Pages,
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

/// From where pages can be opened.
#[derive(Clone, Debug)]
pub enum Reach {
    /// From this machine alone, without encryption.
    Machine,
    /// From the network, encrypted.
    Network {
        /// The name or address by which other machines reach this one.
        name: String,
        /// The certificate of this name.
        certificate: Certificate,
    },
}

/// Pages that cannot be served, a page that is not let in, or a password that is not accepted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WebError {
    /// The system gives no thread, or refuses the socket.
    #[error("the pages could not be served: {0}")]
    System(String),
    /// The certificate cannot be used.
    #[error("the certificate of the pages: {0}; give another one, or none for a self-signed one")]
    Certificate(#[from] CertificateError),
    /// Not a code that is valid now.
    #[error("the code is not valid (any more)")]
    WrongCode,
    /// Too many wrong codes.
    #[error("too many wrong codes: wait a minute")]
    TooMany,
    /// Too many passwords wait for their check.
    #[error("many passwords are tried at this moment: try again in a few seconds")]
    Busy,
    /// No random numbers, or the file of pages could not be written.
    #[error("the page could not be let in: {0}; try again")]
    NotKept(String),
    /// Too easy to guess.
    #[error("the password: {0}")]
    Weak(#[from] TextError),
    /// Too long to be typed.
    #[error("a password has at most 1024 bytes: take a shorter one")]
    Long,
    /// The text is no hash of a password.
    #[error("the text is no hash of a password (Argon2): delete it, and set a password again")]
    NoHash,
    /// No random numbers, or no memory.
    #[error("the password could not be hashed: {0}; try again")]
    NotHashed(String),
}

impl From<std::io::Error> for WebError {
    fn from(error: std::io::Error) -> Self {
        Self::System(error.to_string())
    }
}

impl Site {
    /// The pages of the session that shows `view` first, and the desk at which they are answered; `earlier` is what was stored of it until
    /// now, with the time of each event in ms since 1970-01-01 00:00 UTC. `stop` is that of the runner.
    #[must_use]
    pub fn new(
        (view, earlier): (View, Vec<(i64, Event)>),
        (consent, played_by): (Option<String>, PlayedBy),
        stop: PlayStop,
        access: Access,
        study: Arc<dyn StudyPages>,
    ) -> (Self, Desk) {
        let sha = Sha::of(consent.as_deref().unwrap_or_default().as_bytes());
        let beat = Arc::new(Beat::default());
        let (desk, asking) = Desk::new(
            view,
            consent,
            (played_by, stop.clone()),
            earlier,
            Arc::clone(&beat),
        );
        let led = server::Led {
            asking,
            consent: sha,
            stop,
            experimenters: AtomicUsize::new(0),
            participants: AtomicUsize::new(0),
            draft: Mutex::default(),
            beat,
        };
        let mut site = Self::empty(access);
        site.pages.led = Some(Arc::new(led));
        site.pages.study = Some(study);
        (site, desk)
    }

    /// The sessions of `study` with their reports, and its tables; nothing is led.
    #[must_use]
    pub fn study(access: Access, study: Arc<dyn StudyPages>) -> Self {
        let mut site = Self::empty(access);
        site.pages.study = Some(study);
        site
    }

    /// The console of `bench`, on which `procedures` can be started, and the desk at which that is asked for; `file` gives what was made.
    #[must_use]
    pub fn console(
        bench: String,
        procedures: Vec<Procedure>,
        file: MadeFile,
        access: Access,
    ) -> (Self, ConsoleDesk) {
        let (desk, console) = ConsoleDesk::new(bench, procedures, file);
        let mut site = Self::empty(access);
        site.pages.console = Some(Arc::new(console));
        (site, desk)
    }

    /// The same, which shows what a bench acquires.
    #[must_use]
    pub fn showing(mut self, live: Pictures) -> Self {
        self.pages.live = Some(live);
        self
    }

    fn empty(access: Access) -> Self {
        let (ends, end) = watch::channel(false);
        let pages = entrance::Pages {
            access,
            hosts: Vec::new(),
            scheme: "http",
            ends: end,
            around: watch::channel(0).0,
            led: None,
            study: None,
            console: None,
            live: None,
        };
        Self { pages, ends }
    }

    /// Serves the pages at `listener` until the value is dropped.
    ///
    /// # Errors
    /// [`WebError`] where the system gives no thread or refuses the socket, and for a certificate that cannot be used.
    pub fn serve(self, listener: TcpListener, reach: &Reach) -> Result<Served, WebError> {
        let Self { mut pages, ends } = self;
        let at = listener.local_addr()?;
        let tls = match reach {
            Reach::Machine => None,
            Reach::Network { certificate, .. } => Some(certificate.acceptor()?),
        };
        pages.hosts = hosts(at, reach);
        pages.scheme = match tls {
            Some(_) => "https",
            None => "http",
        };
        listener.set_nonblocking(true)?;
        let led = pages.led.clone();
        let pages = Arc::new(pages);
        let answering = serving::Answering {
            tls,
            address: pages.address(),
            ends: ends.subscribe(),
            router: server::router(Arc::clone(&pages)),
        };
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            // Reports, tables and one password at a time.
            .max_blocking_threads(BLOCKING)
            .build()?;
        let thread = std::thread::Builder::new()
            .name("pages".into())
            .spawn(move || {
                runtime.block_on(async move {
                    let _watches = led.map(|led| tokio::spawn(beat::watched(pages, led)));
                    if let Ok(listener) = tokio::net::TcpListener::from_std(listener) {
                        serving::serve(listener, answering).await;
                    }
                });
                // A password that is still checked is waited for by nobody.
                runtime.shutdown_background();
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

/// The names by which a browser asks for the pages at `address`, the one that is shown first.
fn hosts(address: SocketAddr, reach: &Reach) -> Vec<String> {
    let port = address.port();
    let mut hosts = vec![address.to_string()];
    match reach {
        Reach::Machine => {
            hosts.extend(["localhost", "127.0.0.1", "[::1]"].map(|host| format!("{host}:{port}")));
        }
        Reach::Network { name, .. } => {
            let name = name.to_lowercase();
            let name = match name.parse() {
                Ok(std::net::IpAddr::V6(six)) => format!("[{six}]"),
                _ => name,
            };
            hosts.insert(0, format!("{name}:{port}"));
            if port == 443 {
                // The port that browsers leave out.
                hosts.extend([name, address.ip().to_string()]);
            }
        }
    }
    hosts
}
