//! A client that speaks HTTP without a library: what is tested is what comes over the wire.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(dead_code, reason = "each program of tests uses a part of it")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// An answer of the server.
#[derive(Clone, Debug)]
pub(crate) struct Reply {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: String,
}

/// A connection, encrypted or not.
pub(crate) trait Channel: Read + Write + Send {}

impl<T: Read + Write + Send> Channel for T {}

/// What encrypts a connection.
pub(crate) type Encrypt = Arc<dyn Fn(TcpStream) -> Box<dyn Channel> + Send + Sync>;

/// Where the pages are, and the codes that let in.
pub(crate) struct Pages {
    pub(crate) at: SocketAddr,
    /// On a network, where connections are encrypted.
    pub(crate) encrypt: Option<Encrypt>,
    /// The experimenter's code, or on a network the password.
    pub(crate) experimenter: String,
    pub(crate) viewer: String,
}

/// A page that was let in: its cookie, and its second mark.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    pub(crate) cookie: String,
    pub(crate) mark: String,
    pub(crate) role: &'static str,
}

impl Pages {
    /// A new connection; `None` where there is no server.
    pub(crate) fn connect(&self, patience: Duration) -> Option<Box<dyn Channel>> {
        let stream = TcpStream::connect(self.at).ok()?;
        stream.set_read_timeout(Some(patience)).unwrap();
        Some(match &self.encrypt {
            None => Box::new(stream),
            Some(encrypt) => encrypt(stream),
        })
    }

    /// Sends `method` `path` with `headers` and `body`, and reads the whole answer.
    pub(crate) fn send(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> Reply {
        self.try_send(method, path, headers, body).unwrap()
    }

    /// As [`Self::send`]; `None` where there is no server, or it ends before it has answered.
    pub(crate) fn try_send(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> Option<Reply> {
        let mut stream = self.connect(Duration::from_secs(30))?;
        let host = match headers.iter().any(|(name, _)| *name == "host") {
            true => String::new(),
            false => format!("host: {}\r\n", self.at),
        };
        let headers: String = headers
            .iter()
            .map(|(name, value)| format!("{name}: {value}\r\n"))
            .collect();
        let length = body.len();
        // An early refusal closes the connection while the rest is sent.
        let _cut = write!(
            stream,
            "{method} {path} HTTP/1.1\r\n{host}{headers}connection: close\r\ncontent-length: {length}\r\n\r\n{body}"
        );
        let mut all = Vec::new();
        let _cut = stream.read_to_end(&mut all);
        let all = String::from_utf8(all).unwrap();
        let (head, body) = all.split_once("\r\n\r\n").unwrap_or((&all, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        Some(Reply {
            status: status.unwrap_or(0),
            head: head.to_lowercase(),
            body: body.to_owned(),
        })
    }

    /// Lets a page in with `code`.
    pub(crate) fn enter(&self, code: &str) -> Page {
        self.enter_by(&format!("code={code}"))
    }

    /// Lets a page in with a filled form.
    pub(crate) fn enter_by(&self, filled: &str) -> Page {
        let form = [("content-type", "application/x-www-form-urlencoded")];
        let entered = self.send("POST", "/enter", &form, filled);
        assert_eq!(entered.status, 303, "{entered:?}");
        let (_, cookie) = entered.head.split_once("set-cookie: ").unwrap();
        let cookie = cookie.split(';').next().unwrap().to_owned();
        let leads = |to: &&str| entered.head.contains(&format!("location: {to}\r\n"));
        let pages = ["/participant", "/console", "/experimenter", "/study"];
        let role = pages.into_iter().find(leads).unwrap_or("/experimenter");
        let page = self.send("GET", role, &[("cookie", &cookie)], "");
        let mark = page.body.split_once("piezotact-mark\" content=\"");
        // A page that changes nothing has none.
        assert_eq!(mark.is_none(), role == "/study", "{role}");
        Page {
            mark: mark.map_or(String::new(), |(_, mark)| mark[..64].to_owned()),
            cookie,
            role,
        }
    }

    pub(crate) fn experimenter(&self) -> Page {
        self.enter_by(&self.experimenter_form())
    }

    /// What the experimenter enters with.
    pub(crate) fn experimenter_form(&self) -> String {
        match self.encrypt {
            None => format!("code={}", self.experimenter),
            Some(_) => format!("password={}", self.experimenter),
        }
    }

    /// The participant's device, let in by the code on the page of `experimenter`.
    pub(crate) fn participant(&self, experimenter: &Page) -> Page {
        let headers = [
            ("cookie", experimenter.cookie.as_str()),
            ("x-piezotact-mark", &experimenter.mark),
        ];
        assert_eq!(self.send("POST", "/pairing", &headers, "").status, 204);
        self.enter(&self.pairing_code(experimenter))
    }

    pub(crate) fn pairing_code(&self, experimenter: &Page) -> String {
        let shown = self.shown(experimenter);
        let (_, code) = shown.split_once("code=").unwrap();
        code[..10].to_owned()
    }

    /// What a page shows.
    pub(crate) fn shown(&self, page: &Page) -> String {
        self.send("GET", page.role, &[("cookie", &page.cookie)], "")
            .body
    }

    /// The mark of the step that a page shows.
    pub(crate) fn mark(&self, page: &Page) -> String {
        let shown = self.shown(page);
        let (_, mark) = shown.split_once("data-mark=\"").unwrap();
        mark.split('"').next().unwrap().to_owned()
    }

    /// Asks for `what` (JSON without braces) as `page`, at the step `at`, with an id.
    pub(crate) fn ask_as(&self, page: &Page, (id, at): (&str, &str), what: &str) -> Reply {
        let headers = [
            ("cookie", page.cookie.as_str()),
            ("x-piezotact-mark", &page.mark),
            ("content-type", "application/json"),
        ];
        let body = format!(r#"{{"id":"{id}","at":"{at}",{what}}}"#);
        self.send("POST", "/ask", &headers, &body)
    }

    /// Asks for `what` at the present step, under a new id.
    pub(crate) fn ask(&self, page: &Page, what: &str) -> Reply {
        static IDS: AtomicU32 = AtomicU32::new(0);
        let id = IDS.fetch_add(1, Ordering::SeqCst).to_string();
        let at = self.mark(page);
        self.ask_as(page, (&id, &at), what)
    }

    /// Posts nothing to `path`.
    pub(crate) fn post(&self, page: &Page, path: &str) -> Reply {
        let headers = [
            ("cookie", page.cookie.as_str()),
            ("x-piezotact-mark", &page.mark),
        ];
        self.send("POST", path, &headers, "")
    }

    /// The stream of a page, whose steps are read one after the other.
    pub(crate) fn follow(&self, page: &Page) -> Stream {
        let mut stream = self.connect(Duration::from_secs(20)).unwrap();
        write!(
            stream,
            "GET {}/stream HTTP/1.1\r\nhost: {}\r\ncookie: {}\r\n\r\n",
            page.role, self.at, page.cookie
        )
        .unwrap();
        Stream(BufReader::new(stream))
    }
}

/// A stream of steps.
pub(crate) struct Stream(BufReader<Box<dyn Channel>>);

impl Stream {
    /// The next line of data; `None` where the stream has ended.
    pub(crate) fn step(&mut self) -> Option<String> {
        loop {
            let mut line = String::new();
            match self.0.read_line(&mut line) {
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
            // The last chunk.
            if line == "0\r\n" {
                return None;
            }
            if let Some(data) = line.strip_prefix("data: ") {
                return Some(data.to_owned());
            }
        }
    }

    /// All that comes until the stream shows `words`.
    pub(crate) fn until(&mut self, words: &str) -> Vec<String> {
        let mut all = Vec::new();
        while let Some(step) = self.step() {
            let is_it = step.contains(words);
            all.push(step);
            if is_it {
                return all;
            }
        }
        panic!("the stream ended without `{words}`");
    }
}
