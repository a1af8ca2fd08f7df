//! Pages that are served for a test.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::cell::Cell;
use std::net::TcpListener;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::store::Purpose;
use piezotact_web::{
    Access, BenchRequest, Certificate, Listed, Live, Overview, Password, PlayedBy, Procedure,
    Reach, Role, Screen, Site, Standing, StudyPages, View, Word,
};
use tokio_rustls::rustls;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};

use crate::support::{Bed, Place, next};

mod http;

pub(crate) use http::{Encrypt, Page, Pages};

/// The experimenter's password on a network.
pub(crate) const PASSWORD: &str = "four-words-of-wood";

/// Encrypts connections to whoever has `certificate`, and to nobody else.
pub(crate) fn encrypt(certificate: &Certificate) -> Encrypt {
    let mut roots = rustls::RootCertStore::empty();
    let own = CertificateDer::from_pem_slice(certificate.chain_pem.as_bytes()).unwrap();
    roots.add(own).unwrap();
    let ring = Arc::new(rustls::crypto::ring::default_provider());
    let config = rustls::ClientConfig::builder_with_provider(ring)
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    let config = Arc::new(config);
    Arc::new(move |stream| {
        let name = ServerName::try_from("127.0.0.1").unwrap();
        let client = rustls::ClientConnection::new(Arc::clone(&config), name).unwrap();
        Box::new(rustls::StreamOwned::new(client, stream))
    })
}

/// A study without answers.
struct Nothing;

impl StudyPages for Nothing {
    fn overview(&self) -> Result<Overview, String> {
        let listed = |participant: &str, standing| Listed {
            participant: participant.to_owned(),
            session: "discrimination".to_owned(),
            standing,
            is_rehearsal: false,
            trials: Some((3, 45)),
            last: "2026-01-01 00:00:00".to_owned(),
        };
        Ok(Overview {
            title: "Textures".to_owned(),
            completed: (1, 10),
            is_simulated: false,
            sessions: vec![
                listed("P01", Standing::Complete),
                listed("P02", Standing::Running),
            ],
        })
    }

    fn session(&self, participant: &str, session: &str) -> Result<String, String> {
        match (participant, session) {
            ("P01", "discrimination") => Ok("<!DOCTYPE html><title>session</title>".to_owned()),
            _ => Err(format!("<{participant}> has no such session")),
        }
    }

    fn tables(&self) -> Result<Vec<u8>, String> {
        Ok(b"PK".to_vec())
    }

    fn matrix(&self) -> Result<String, String> {
        Ok("<!DOCTYPE html><title>matrix</title>".to_owned())
    }

    fn answers(&self) -> Result<String, String> {
        Err("there are no answers yet".to_owned())
    }
}

/// Serves the session of `plan` in `bed` while `act` uses its pages.
pub(crate) fn with_pages<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    act: impl FnOnce(&Pages) -> T + Send,
) -> T {
    served(bed, of, |_| {}, act, &Reach::Machine)
}

/// As [`with_pages`], on a network.
pub(crate) fn with_pages_on_network<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    act: impl FnOnce(&Pages) -> T + Send,
) -> T {
    let names = ["127.0.0.1".to_owned()];
    let reach = Reach::Network {
        name: names[0].clone(),
        certificate: Certificate::own(&names, SystemTime::now()).unwrap(),
    };
    served(bed, of, |_| {}, act, &reach)
}

/// As [`with_pages`]; `before` has the number of events that the store refuses next, once the session is taken up.
pub(crate) fn with_pages_after<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    before: impl FnOnce(&Cell<usize>),
    act: impl FnOnce(&Pages) -> T + Send,
) -> T {
    served(bed, of, before, act, &Reach::Machine)
}

fn served<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    before: impl FnOnce(&Cell<usize>),
    act: impl FnOnce(&Pages) -> T + Send,
    reach: &Reach,
) -> T {
    let refusals = Rc::clone(&bed.store.refusals);
    let stop = bed.stop.clone();
    let served = |runner: &mut piezotact_study::session::Runner<'_>| {
        let first = match runner.state().events() {
            0 => next(runner.state()),
            _ => Some(piezotact_people::campaign::session::Command::Resume {
                experimenter: "EX".into(),
                now_ms: runner.now_ms(),
            }),
        };
        runner.give(first.unwrap()).unwrap();
        before(&refusals);
        let access = Access::new("P01", None, Box::new(|_| Ok(()))).unwrap();
        let (access, encrypt) = match reach {
            Reach::Machine => (access, None),
            Reach::Network { certificate, .. } => {
                let password = Password::new(PASSWORD).unwrap();
                (access.with_password(password), Some(encrypt(certificate)))
            }
        };
        let experimenter = access.code(Role::Experimenter, 0);
        let viewer = access.code(Role::Viewer, 0).unwrap();
        let view = View::of(runner.state(), None, PlayedBy::Bench);
        let (site, mut desk) = Site::new(
            (view, runner.events().unwrap()),
            (None, PlayedBy::Bench),
            stop,
            access,
            Arc::new(Nothing),
        );
        Screen::default().shows(&desk);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let pages = Pages {
            at: listener.local_addr().unwrap(),
            encrypt,
            experimenter: experimenter.unwrap_or_else(|| PASSWORD.to_owned()),
            viewer,
        };
        let served = site.serve(listener, reach).unwrap();
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let acting = scope.spawn(|| {
                let _ends = Ends(&is_over);
                act(&pages)
            });
            desk.run(runner, &|| is_over.load(Ordering::SeqCst))
                .unwrap();
            let began = std::time::Instant::now();
            drop(served);
            assert!(
                began.elapsed() < Duration::from_secs(2),
                "the pages do not end"
            );
            acting.join().unwrap()
        })
    };
    bed.open(of, Purpose::Volunteer, Place::Tape, served)
        .unwrap()
}

/// Ends the desk also where a test fails.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

/// Serves the console of a bench, on which one procedure can be started that is done at once, while `act` uses its pages.
pub(crate) fn with_console(act: impl FnOnce(&Pages) + Send) {
    let access = Access::new("console", None, Box::new(|_| Ok(()))).unwrap();
    let code = |role| access.code(role, 0).unwrap();
    let (experimenter, viewer) = (code(Role::Experimenter), code(Role::Viewer));
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let pages = Pages {
        at: listener.local_addr().unwrap(),
        encrypt: None,
        experimenter,
        viewer,
    };
    let procedure = Procedure {
        name: "play",
        title: Word::PlayDrive,
        fields: Vec::new(),
    };
    let file = Box::new(|name: &str| Some(format!("<title>{name}</title>").into_bytes()));
    let (site, desk) = Site::console("fake".into(), vec![procedure], file, access);
    let (_live, pictures) = Live::new().unwrap();
    let served = site
        .showing(pictures)
        .serve(listener, &Reach::Machine)
        .unwrap();
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let acting = scope.spawn(|| {
            let _ends = Ends(&is_over);
            act(&pages);
        });
        while !is_over.load(Ordering::SeqCst) {
            let Some(asked) = desk.next(Duration::from_millis(20)) else {
                continue;
            };
            let answer = match &asked.request {
                BenchRequest::Stop => Err("nothing runs".to_owned()),
                BenchRequest::Start { procedure, .. } => {
                    desk.change(|view| {
                        view.say(format!("{procedure} is done"));
                        view.files = vec!["play-1.html".into(), "play-1.parquet".into()];
                    });
                    Ok(())
                }
            };
            asked.answer(answer);
        }
        drop(served);
        acting.join().unwrap();
    });
}
