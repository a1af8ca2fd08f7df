//! The way in: which requests are looked at, who sends them, and how a page is let in.

use crate::WebError;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant, SystemTime};

use axum::Extension;
use axum::body::Body;
use axum::extract::{Form, Query, Request as HttpRequest, State as Shared};
use axum::http::header::{
    ACCEPT_LANGUAGE, CACHE_CONTROL, CONTENT_SECURITY_POLICY, COOKIE as COOKIES, HOST, LOCATION,
    ORIGIN, REFERRER_POLICY, RETRY_AFTER, SET_COOKIE, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::MethodRouter;
use serde::Deserialize;
use tokio::sync::watch;

use crate::access::{Access, Key, Role, is_second_mark};
use crate::console::Console;
use crate::live::Pictures;
use crate::pages::{self, Door};
use crate::server::{For, Led, Route};
use crate::serving::From;
use crate::study::StudyPages;
use crate::words::{Language, Word};

/// A request is read within this time.
const SLOW: Duration = Duration::from_secs(10);
/// The largest request, in bytes.
pub(crate) const LARGEST: usize = 64 * 1024;
/// The header with the second mark of a page.
const MARK: &str = "x-piezotact-mark";

/// What all handlers share.
pub(crate) struct Pages {
    pub(crate) access: Access,
    /// The hosts by which the pages are known, with their port.
    pub(crate) hosts: Vec<String>,
    /// `https` on a network.
    pub(crate) scheme: &'static str,
    /// True when the program ends: streams end then.
    pub(crate) ends: watch::Receiver<bool>,
    /// Changes with everything that a view does not hold: pairing, pages that come and go.
    pub(crate) around: watch::Sender<u64>,
    /// The session, where one is led.
    pub(crate) led: Option<Arc<Led>>,
    /// The study, where there is one.
    pub(crate) study: Option<Arc<dyn StudyPages>>,
    /// The console of a bench, where there is one.
    pub(crate) console: Option<Arc<Console>>,
    /// What the bench acquires, where there is one.
    pub(crate) live: Option<Pictures>,
}

impl Pages {
    /// The address of the pages, without a path.
    pub(crate) fn address(&self) -> String {
        let host = self.hosts.first().map_or("", String::as_str);
        format!("{}://{host}", self.scheme)
    }

    /// The page of whoever leads, or looks on.
    fn leading(&self) -> &'static str {
        match (&self.led, &self.console) {
            (Some(_), _) => "/experimenter",
            (None, Some(_)) => "/console",
            (None, None) => "/study",
        }
    }

    /// How one enters.
    fn door(&self) -> Door {
        match self.access.has_password() {
            true => Door::CodeOrPassword,
            false => Door::Code,
        }
    }
}

pub(crate) type Site = Arc<Pages>;

/// A page that was let in.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    pub(crate) role: Role,
    pub(crate) cookie: String,
}

/// The handler of `route` behind its check: the role, and for what changes something the second mark too.
pub(crate) fn guarded(route: &Route, handler: MethodRouter<Site>) -> MethodRouter<Site> {
    let For::Roles(roles) = route.whose else {
        return handler;
    };
    let changes = route.method == "POST";
    handler.layer(from_fn(
        move |request: HttpRequest, next: Next| async move {
            let Some(site) = request.extensions().get::<Site>().cloned() else {
                return StatusCode::INTERNAL_SERVER_ERROR.into_response();
            };
            // One browser may hold the pages of several roles, on two screens.
            let all = pages_of(&site, request.headers());
            if all.is_empty() {
                return match changes || request.uri().path().ends_with("/stream") {
                    true => (StatusCode::UNAUTHORIZED, "no page of this session").into_response(),
                    false => to("/enter"),
                };
            }
            let mark = request.headers().get(MARK);
            let mark = mark.and_then(|mark| mark.to_str().ok()).unwrap_or_default();
            let is_it = |page: &&Page| {
                roles.contains(&page.role) && (!changes || is_second_mark(mark, &page.cookie))
            };
            let Some(page) = all.iter().find(is_it).cloned() else {
                return (StatusCode::FORBIDDEN, "not for this page, or not from it")
                    .into_response();
            };
            let mut request = request;
            request.extensions_mut().insert(page);
            next.run(request).await
        },
    ))
}

/// The pages of this session whose cookies a request has, that of the experimenter first.
fn pages_of(site: &Pages, headers: &HeaderMap) -> Vec<Page> {
    let cookies = headers.get_all(COOKIES).iter();
    let cookies = cookies.filter_map(|all| all.to_str().ok());
    let known = cookies.flat_map(|all| all.split(';')).filter_map(|one| {
        let (name, cookie) = one.trim().split_once('=')?;
        let role = site.access.role(cookie, now_ms())?;
        (name == site.access.cookie(role)).then(|| Page {
            role,
            cookie: cookie.to_owned(),
        })
    });
    let mut known: Vec<Page> = known.collect();
    known.sort_by_key(|page| page.role as u8);
    known
}

/// The value of the header `name`, where it is stated once: one that is stated twice is understood in two ways.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<&HeaderValue> {
    let mut all = headers.get_all(name).iter();
    all.next().filter(|_| all.next().is_none())
}

/// Another way to the same place: what a page of another site can make a browser ask for has another host.
pub(crate) async fn known_host(
    Shared(site): Shared<Site>,
    mut request: HttpRequest,
    next: Next,
) -> Response {
    let host = only(request.headers(), HOST).and_then(|host| host.to_str().ok());
    let host = host.map(str::to_lowercase);
    if !host.is_some_and(|host| site.hosts.contains(&host)) {
        return (StatusCode::MISDIRECTED_REQUEST, "unknown host").into_response();
    }
    // What a page of another site sends is not even a wrong code.
    let origin = only(request.headers(), ORIGIN).and_then(|origin| origin.to_str().ok());
    let has_origin = request.headers().contains_key(ORIGIN);
    let is_own = |origin: &str| {
        let host = origin.strip_prefix(site.scheme);
        let host = host.and_then(|host| host.strip_prefix("://"));
        host.is_some_and(|host| site.hosts.iter().any(|known| known == host))
    };
    if has_origin && !origin.is_some_and(is_own) {
        return (StatusCode::FORBIDDEN, "from another site").into_response();
    }
    if let Some(From(_, place)) = request.extensions().get()
        && !pages_of(&site, request.headers()).is_empty()
    {
        place.let_in();
    }
    request.extensions_mut().insert(site);
    next.run(request).await
}

pub(crate) async fn in_time(request: HttpRequest, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    // The body within its time; the answer may take as long as a texture plays.
    let read = tokio::time::timeout(SLOW, axum::body::to_bytes(body, LARGEST));
    let bytes = match read.await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(_too_large)) => return StatusCode::PAYLOAD_TOO_LARGE.into_response(),
        Err(_slow) => return StatusCode::REQUEST_TIMEOUT.into_response(),
    };
    next.run(HttpRequest::from_parts(parts, Body::from(bytes)))
        .await
}

pub(crate) async fn hardened(request: HttpRequest, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    ));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("same-origin"));
    headers
        .entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-store"));
    response
}

fn to(path: &'static str) -> Response {
    (StatusCode::SEE_OTHER, [(LOCATION, path)]).into_response()
}

pub(crate) fn language(headers: &HeaderMap) -> Language {
    let tags = headers
        .get(ACCEPT_LANGUAGE)
        .and_then(|tags| tags.to_str().ok());
    tags.and_then(Language::of).unwrap_or_default()
}

pub(crate) async fn start(Shared(site): Shared<Site>, headers: HeaderMap) -> Response {
    to(
        match pages_of(&site, &headers).first().map(|page| page.role) {
            None => "/enter",
            Some(Role::Participant) => "/participant",
            Some(Role::Experimenter | Role::Viewer) => site.leading(),
        },
    )
}

#[derive(Deserialize)]
pub(crate) struct Entering {
    #[serde(default)]
    code: String,
    password: Option<String>,
}

pub(crate) async fn enter_page(
    Shared(site): Shared<Site>,
    Query(code): Query<Entering>,
    headers: HeaderMap,
) -> Html<String> {
    let door = site.door();
    Html(pages::enter(language(&headers), door, &code.code, None).into_string())
}

pub(crate) async fn enter(
    Shared(site): Shared<Site>,
    Extension(From(from, _)): Extension<From>,
    headers: HeaderMap,
    Form(entering): Form<Entering>,
) -> Response {
    let refused = |status, word| {
        let page = pages::enter(language(&headers), site.door(), "", Some(word));
        (status, Html(page.into_string())).into_response()
    };
    let wrong = match entering.password {
        None => Word::WrongCode,
        Some(_) => Word::WrongPassword,
    };
    let entered = match entering.password {
        None => site.access.enter(Key::Code(&entering.code), from, now_ms()),
        Some(password) => {
            match site.access.turn(from, now_ms()).await {
                Err(refused) => Err(refused),
                Ok(turn) => {
                    // It takes long, and nobody else waits for it.
                    let site = Arc::clone(&site);
                    let checked = tokio::task::spawn_blocking(move || {
                        site.access.enter_in_turn(&password, from, now_ms(), turn)
                    });
                    match checked.await {
                        Ok(entered) => entered,
                        Err(_panicked) => return StatusCode::INTERNAL_SERVER_ERROR.into_response(),
                    }
                }
            }
        }
    };
    match entered {
        Ok((role, mark)) => {
            site.around.send_modify(|around| *around += 1);
            let to = match role {
                Role::Participant => "/participant",
                Role::Experimenter | Role::Viewer => site.leading(),
            };
            let secure = match site.scheme {
                "https" => "; Secure",
                _ => "",
            };
            // A new mark for every page that enters: one that was there before counts for nothing.
            let cookie = format!(
                "{}={mark}; Path=/; HttpOnly; SameSite=Strict; Max-Age=86400{secure}",
                site.access.cookie(role)
            );
            (
                StatusCode::SEE_OTHER,
                [(LOCATION, to.to_owned()), (SET_COOKIE, cookie)],
            )
                .into_response()
        }
        Err(WebError::WrongCode) => refused(StatusCode::FORBIDDEN, wrong),
        Err(error @ (WebError::TooMany | WebError::Busy)) => {
            let (later, word) = match error {
                WebError::Busy => ("3", Word::Busy),
                _ => ("60", Word::TooMany),
            };
            let page = refused(StatusCode::TOO_MANY_REQUESTS, word);
            ([(RETRY_AFTER, later)], page).into_response()
        }
        Err(error) => (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response(),
    }
}

pub(crate) fn now_ms() -> i64 {
    static BEGAN: OnceLock<(SystemTime, Instant)> = OnceLock::new();
    // A clock that is set while the program runs ends no page: it could stop nothing any more.
    let (at, began) = BEGAN.get_or_init(|| (SystemTime::now(), Instant::now()));
    let since = at.duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from((since + began.elapsed()).as_millis()).unwrap_or(i64::MAX)
    })
}
