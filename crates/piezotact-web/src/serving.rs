//! Connections: how many, how long, and encrypted on a network.

mod places;

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout, timeout_at};
use tokio_rustls::TlsAcceptor;

use places::{Place, Places};

/// A connection is encrypted within this time, and then says within the same time what it asks for, also after an earlier answer.
const SLOW: Duration = Duration::from_secs(10);
/// Connections that still work have this long to end.
const GRACE: Duration = Duration::from_millis(500);
/// Where the system has no more connections, the next try.
const LATER: Duration = Duration::from_millis(100);
/// The longest head of a request, and what is kept of an answer until it is sent, in bytes.
const BUFFER: usize = 32 * 1024;
/// The first byte of an encrypted connection.
const HANDSHAKE: u8 = 22;

/// The address that a request comes from, and its connection.
#[derive(Clone, Debug)]
pub(crate) struct From(pub(crate) IpAddr, pub(crate) Arc<Place>);

/// How connections are answered.
#[derive(Clone)]
pub(crate) struct Answering {
    pub(crate) router: Router,
    /// What encrypts them; none on this machine.
    pub(crate) tls: Option<TlsAcceptor>,
    /// The address of the pages, for whoever asks without encryption.
    pub(crate) address: String,
    pub(crate) ends: watch::Receiver<bool>,
}

/// Answers connections until the program ends. An error of a connection ends that connection only.
pub(crate) async fn serve(listener: TcpListener, answering: Answering) {
    let places = Places::default();
    let mut connections = JoinSet::new();
    let mut ends = answering.ends.clone();
    loop {
        while connections.try_join_next().is_some() {}
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = ends.wait_for(|ends| *ends) => break,
        };
        let Ok((stream, from)) = accepted else {
            tokio::time::sleep(LATER).await;
            continue;
        };
        let Some(place) = places.take(from.ip()) else {
            continue;
        };
        let place = Arc::new(place);
        let from = From(from.ip(), Arc::clone(&place));
        let task = connections.spawn(connection(stream, from, answering.clone()));
        place.held_by(task);
    }
    drop(listener);
    let all = async { while connections.join_next().await.is_some() {} };
    let _late_ones_are_cut = timeout(GRACE, all).await;
}

async fn connection(stream: TcpStream, from: From, answering: Answering) {
    let _slower = stream.set_nodelay(true);
    let Some(tls) = &answering.tls else {
        return requests(stream, from, answering).await;
    };
    let until = Instant::now() + SLOW;
    let mut first = [0];
    let Ok(Ok(1)) = timeout_at(until, stream.peek(&mut first)).await else {
        return;
    };
    if first[0] != HANDSHAKE {
        return lead_to(stream, &answering.address).await;
    }
    if let Ok(Ok(encrypted)) = timeout_at(until, tls.accept(stream)).await {
        requests(encrypted, from, answering).await;
    }
}

/// The path and query that a request without encryption asks for, as far as it was read; the start where it does not say.
fn path_of(request: &[u8]) -> &str {
    let line = request.split(|byte| *byte == b'\r').next();
    let line = std::str::from_utf8(line.unwrap_or_default()).unwrap_or_default();
    let path = line.split(' ').nth(1).unwrap_or_default();
    let is_path = path.starts_with('/') && path.bytes().all(|byte| byte.is_ascii_graphic());
    match is_path && line.ends_with("HTTP/1.1") {
        true => path,
        false => "/",
    }
}

/// Tells a browser that asked without encryption where the pages are.
async fn lead_to(mut stream: TcpStream, address: &str) {
    let mut asked = [0; 1024];
    let Ok(Ok(read)) = timeout(SLOW, stream.peek(&mut asked)).await else {
        return;
    };
    let path = path_of(asked.get(..read).unwrap_or_default());
    let answer = format!(
        "HTTP/1.1 307 Temporary Redirect\r\nlocation: {address}{path}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
    );
    let written = async {
        stream.write_all(answer.as_bytes()).await?;
        // What was asked is read away: a connection that is closed before is an error to a browser.
        let mut rest = [0; 1024];
        while let Ok(Ok(1..)) = timeout(LATER, async {
            stream.readable().await?;
            stream.try_read(&mut rest)
        })
        .await
        {}
        stream.shutdown().await
    };
    let _gone = timeout(SLOW, written).await;
}

async fn requests<S>(stream: S, from: From, answering: Answering)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let place = Arc::clone(&from.1);
    let router = TowerToHyperService::new(answering.router.layer(Extension(from)));
    let service = service_fn(move |request| {
        let (place, answer) = (Arc::clone(&place), router.call(request));
        async move {
            place.asks();
            let answer = answer.await;
            place.answered();
            answer
        }
    });
    let mut ends = answering.ends;
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(SLOW)
        .max_buf_size(BUFFER)
        .serve_connection(TokioIo::new(stream), service);
    tokio::pin!(connection);
    tokio::select! {
        _done = connection.as_mut() => return,
        _ = ends.wait_for(|ends| *ends) => connection.as_mut().graceful_shutdown(),
    }
    let _done = connection.await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_that_was_asked_for_is_kept() {
        for (request, path) in [
            (
                "GET /enter?code=abc HTTP/1.1\r\nhost: x\r\n",
                "/enter?code=abc",
            ),
            ("GET http://elsewhere/ HTTP/1.1\r\n", "/"),
            ("GET /a\nb HTTP/1.1\r\n", "/"),
            ("GET /cut", "/"),
            ("", "/"),
        ] {
            assert_eq!(path_of(request.as_bytes()), path, "{request}");
        }
        assert_eq!(path_of(&[0xff, b' ', b'/', b'\r']), "/");
    }
}
