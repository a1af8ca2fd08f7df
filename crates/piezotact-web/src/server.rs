//! The routes, who may use them, and their handlers.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, SystemTime};

use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Form, Json, Query, Request as HttpRequest, State as Shared};
use axum::http::header::{
    ACCEPT_LANGUAGE, CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE,
    COOKIE as COOKIES, HOST, LOCATION, ORIGIN, REFERRER_POLICY, SET_COOKIE, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::sse::{Event as Sent, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use axum::{Extension, Router};
use futures_util::stream::{Stream, unfold};
use piezotact_people::campaign::chain::Sha;
use serde::Deserialize;
use tokio::sync::{oneshot, watch};

use crate::access::{Access, AccessError, Key, Role, is_second_mark};
use crate::asked::{Asked, What};
use crate::desk::{Asking, Reply, Request};
use crate::pages::{self, Door, Pairing, Sight};
use crate::serving::From;
use crate::view::View;
use crate::words::{Language, Word};

/// A request is read within this time.
const SLOW: Duration = Duration::from_secs(10);
/// The largest request, in bytes.
const LARGEST: usize = 64 * 1024;
/// The header with the second mark of a page.
const MARK: &str = "x-piezotact-mark";

/// What pages show of the whole study.
pub trait StudyPages: Send + Sync {
    /// The matrices of all answers, as an HTML document.
    ///
    /// # Errors
    /// One sentence.
    fn matrix(&self) -> Result<String, String>;

    /// All answers, as a CSV table.
    ///
    /// # Errors
    /// One sentence.
    fn answers(&self) -> Result<String, String>;
}

/// What all handlers share.
pub(crate) struct Pages {
    pub(crate) asking: Asking,
    pub(crate) access: Access,
    pub(crate) study: Box<dyn StudyPages>,
    /// The checksum of the text that consent is given to.
    pub(crate) consent: Sha,
    /// The hosts by which the pages are known, with their port.
    pub(crate) hosts: Vec<String>,
    /// `https` on a network.
    pub(crate) scheme: &'static str,
    /// True when the program ends: streams end then.
    pub(crate) ends: watch::Receiver<bool>,
    /// Changes with everything that a view does not hold: pairing, pages that come and go.
    pub(crate) around: watch::Sender<u64>,
    pub(crate) experimenters: AtomicUsize,
}

impl Pages {
    /// The address of the pages, without a path.
    pub(crate) fn address(&self) -> String {
        let host = self.hosts.first().map_or("", String::as_str);
        format!("{}://{host}", self.scheme)
    }

    /// How one enters.
    fn door(&self) -> Door {
        match self.access.has_password() {
            true => Door::CodeOrPassword,
            false => Door::Code,
        }
    }
}

type Site = Arc<Pages>;

/// Who may use a route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum For {
    /// Everybody, with and without a code.
    Everybody,
    /// These roles.
    Roles(&'static [Role]),
}

/// A route.
#[derive(Clone, Copy, Debug)]
pub struct Route {
    /// GET or POST.
    pub method: &'static str,
    /// Its path.
    pub path: &'static str,
    /// Who may use it.
    pub whose: For,
    handler: fn(&Self) -> MethodRouter<Site>,
}

const LEADING: &[Role] = &[Role::Experimenter];
const LOOKING: &[Role] = &[Role::Experimenter, Role::Viewer];
const FEELING: &[Role] = &[Role::Participant];
const ACTING: &[Role] = &[Role::Experimenter, Role::Participant];

/// All routes there are: the router is made from them, and so are the tests of who may do what.
pub const ROUTES: &[Route] = &[
    Route {
        method: "GET",
        path: "/",
        whose: For::Everybody,
        handler: |_| get(start),
    },
    Route {
        method: "GET",
        path: "/enter",
        whose: For::Everybody,
        handler: |_| get(enter_page),
    },
    Route {
        method: "POST",
        path: "/enter",
        whose: For::Everybody,
        handler: |_| post(enter),
    },
    Route {
        method: "GET",
        path: "/assets/session.js",
        whose: For::Everybody,
        handler: |_| get(script),
    },
    Route {
        method: "GET",
        path: "/assets/session.css",
        whose: For::Everybody,
        handler: |_| get(style),
    },
    Route {
        method: "GET",
        path: "/experimenter",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(experimenter)),
    },
    Route {
        method: "GET",
        path: "/experimenter/stream",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(experimenter_stream)),
    },
    Route {
        method: "GET",
        path: "/participant",
        whose: For::Roles(FEELING),
        handler: |r| guarded(r, get(participant)),
    },
    Route {
        method: "GET",
        path: "/participant/stream",
        whose: For::Roles(FEELING),
        handler: |r| guarded(r, get(participant_stream)),
    },
    Route {
        method: "POST",
        path: "/ask",
        whose: For::Roles(ACTING),
        handler: |r| guarded(r, post(ask)),
    },
    Route {
        method: "POST",
        path: "/pairing",
        whose: For::Roles(LEADING),
        handler: |r| guarded(r, post(pairing)),
    },
    Route {
        method: "GET",
        path: "/matrix",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(matrix)),
    },
    Route {
        method: "GET",
        path: "/answers.csv",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(answers)),
    },
];

/// The router of [`ROUTES`].
pub(crate) fn router(site: Site) -> Router {
    let mut router = Router::new();
    for route in ROUTES {
        router = router.route(route.path, (route.handler)(route));
    }
    router
        .layer(DefaultBodyLimit::max(LARGEST))
        .layer(from_fn(in_time))
        .layer(from_fn_with_state(Arc::clone(&site), known_host))
        .layer(from_fn(hardened))
        .with_state(site)
}

/// A page that was let in.
#[derive(Clone, Debug)]
struct Page {
    role: Role,
    cookie: String,
}

/// The handler of `route` behind its check: the role, and for what changes something the second mark too.
fn guarded(route: &Route, handler: MethodRouter<Site>) -> MethodRouter<Site> {
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
        let role = site.access.role(cookie)?;
        (name == site.access.cookie(role)).then(|| Page {
            role,
            cookie: cookie.to_owned(),
        })
    });
    let mut known: Vec<Page> = known.collect();
    known.sort_by_key(|page| page.role as u8);
    known
}

/// Another way to the same place: what a page of another site can make a browser ask for has another host.
async fn known_host(Shared(site): Shared<Site>, mut request: HttpRequest, next: Next) -> Response {
    let host = request
        .headers()
        .get(HOST)
        .and_then(|host| host.to_str().ok());
    let host = host.map(str::to_lowercase);
    if !host.is_some_and(|host| site.hosts.contains(&host)) {
        return (StatusCode::MISDIRECTED_REQUEST, "unknown host").into_response();
    }
    // What a page of another site sends is not even a wrong code.
    let origin = request.headers().get(ORIGIN);
    let origin = origin.map(|origin| origin.to_str().unwrap_or_default());
    let is_own = |origin: &str| {
        let host = origin.strip_prefix(site.scheme);
        let host = host.and_then(|host| host.strip_prefix("://"));
        host.is_some_and(|host| site.hosts.iter().any(|known| known == host))
    };
    if !origin.is_none_or(is_own) {
        return (StatusCode::FORBIDDEN, "from another site").into_response();
    }
    request.extensions_mut().insert(site);
    next.run(request).await
}

async fn in_time(request: HttpRequest, next: Next) -> Response {
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

async fn hardened(request: HttpRequest, next: Next) -> Response {
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

fn language(headers: &HeaderMap) -> Language {
    let tags = headers
        .get(ACCEPT_LANGUAGE)
        .and_then(|tags| tags.to_str().ok());
    tags.and_then(Language::of).unwrap_or_default()
}

async fn start(Shared(site): Shared<Site>, headers: HeaderMap) -> Response {
    to(
        match pages_of(&site, &headers).first().map(|page| page.role) {
            None => "/enter",
            Some(Role::Participant) => "/participant",
            Some(Role::Experimenter | Role::Viewer) => "/experimenter",
        },
    )
}

#[derive(Deserialize)]
struct Entering {
    #[serde(default)]
    code: String,
    password: Option<String>,
}

async fn enter_page(
    Shared(site): Shared<Site>,
    Query(code): Query<Entering>,
    headers: HeaderMap,
) -> Html<String> {
    let door = site.door();
    Html(pages::enter(language(&headers), door, &code.code, None).into_string())
}

async fn enter(
    Shared(site): Shared<Site>,
    Extension(From(from)): Extension<From>,
    headers: HeaderMap,
    Form(entering): Form<Entering>,
) -> Response {
    let refused = |status, word| {
        let page = pages::enter(language(&headers), site.door(), "", Some(word));
        (status, Html(page.into_string())).into_response()
    };
    let entered = match entering.password {
        None => site.access.enter(Key::Code(&entering.code), from, now_ms()),
        Some(password) => {
            // It takes long, and nobody else waits for it.
            let site = Arc::clone(&site);
            let checked = tokio::task::spawn_blocking(move || {
                let key = Key::Password(&password);
                site.access.enter(key, from, now_ms())
            });
            match checked.await {
                Ok(entered) => entered,
                Err(_panicked) => return StatusCode::INTERNAL_SERVER_ERROR.into_response(),
            }
        }
    };
    match entered {
        Ok((role, mark)) => {
            site.around.send_modify(|around| *around += 1);
            let to = match role {
                Role::Participant => "/participant",
                Role::Experimenter | Role::Viewer => "/experimenter",
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
        Err(AccessError::WrongCode) => refused(StatusCode::FORBIDDEN, Word::WrongCode),
        Err(AccessError::TooMany) => refused(StatusCode::TOO_MANY_REQUESTS, Word::TooMany),
        Err(error @ AccessError::NotKept(_)) => {
            (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response()
        }
    }
}

fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
    })
}

async fn script() -> impl IntoResponse {
    let kind = [(CONTENT_TYPE, "text/javascript; charset=utf-8")];
    (kind, include_bytes!("assets/session.js").as_slice())
}

async fn style() -> impl IntoResponse {
    let kind = [(CONTENT_TYPE, "text/css; charset=utf-8")];
    (kind, include_bytes!("assets/session.css").as_slice())
}

#[derive(Debug, Deserialize)]
struct Seen {
    #[serde(default)]
    sight: String,
}

impl Seen {
    fn sight(&self) -> Sight {
        match self.sight.as_str() {
            "open" => Sight::Open,
            _ => Sight::Blind,
        }
    }
}

/// How a step is drawn for a page.
type Drawn = Arc<dyn Fn(&Pages, &View) -> String + Send + Sync>;

fn for_experimenter(page: &Page, sight: Sight, language: Language) -> Drawn {
    let role = page.role;
    Arc::new(move |site, view| {
        let code = site.access.code(Role::Participant);
        let pairing = Pairing {
            address: code.map(|code| format!("{}/enter?code={code}", site.address())),
            from_network: site.scheme == "https",
            is_paired: site.access.has_participant(),
        };
        let open = site.experimenters.load(Ordering::Relaxed);
        pages::experimenter(view, sight, language, role, (&pairing, open)).into_string()
    })
}

fn for_participant(language: Language) -> Drawn {
    Arc::new(move |_, view| pages::participant(&view.open, language).into_string())
}

fn framed(
    site: &Pages,
    page: &Page,
    language: Language,
    stream: &str,
    drawn: &Drawn,
) -> Html<String> {
    let step = maud::PreEscaped(drawn(site, &site.asking.views.borrow()));
    Html(pages::frame((page.role, &page.cookie), language, stream, &step).into_string())
}

async fn experimenter(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
    Query(seen): Query<Seen>,
    headers: HeaderMap,
) -> Html<String> {
    let language = language(&headers);
    let stream = match seen.sight() {
        Sight::Blind => "/experimenter/stream",
        Sight::Open => "/experimenter/stream?sight=open",
    };
    let drawn = for_experimenter(&page, seen.sight(), language);
    framed(&site, &page, language, stream, &drawn)
}

async fn participant(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
    headers: HeaderMap,
) -> Html<String> {
    let language = language(&headers);
    framed(
        &site,
        &page,
        language,
        "/participant/stream",
        &for_participant(language),
    )
}

/// Counts a page of an experimenter as long as it lives.
struct Counted(Site);

impl Counted {
    fn new(site: &Site) -> Self {
        site.experimenters.fetch_add(1, Ordering::Relaxed);
        site.around.send_modify(|around| *around += 1);
        Self(Arc::clone(site))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.experimenters.fetch_sub(1, Ordering::Relaxed);
        self.0.around.send_modify(|around| *around += 1);
    }
}

async fn experimenter_stream(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
    Query(seen): Query<Seen>,
    headers: HeaderMap,
) -> Response {
    let counted = (page.role == Role::Experimenter).then(|| Counted::new(&site));
    let drawn = for_experimenter(&page, seen.sight(), language(&headers));
    follow(site, page, drawn, counted).into_response()
}

async fn participant_stream(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
    headers: HeaderMap,
) -> Response {
    follow(site, page, for_participant(language(&headers)), None).into_response()
}

/// What a page follows the session with.
struct Follower {
    site: Site,
    page: Page,
    drawn: Drawn,
    views: watch::Receiver<View>,
    around: watch::Receiver<u64>,
    ends: watch::Receiver<bool>,
    last: String,
    _counted: Option<Counted>,
}

/// The steps of the session as they come, the present one first, each with the number of stored events as its id. It ends with the program,
/// and where the page is let in no more.
fn follow(
    site: Site,
    page: Page,
    drawn: Drawn,
    counted: Option<Counted>,
) -> Sse<impl Stream<Item = Result<Sent, Infallible>>> {
    let follower = Follower {
        views: site.asking.views.clone(),
        around: site.around.subscribe(),
        ends: site.ends.clone(),
        site,
        page,
        drawn,
        last: String::new(),
        _counted: counted,
    };
    let steps = unfold(follower, async |mut follower| {
        loop {
            if *follower.ends.borrow()
                || follower.site.access.role(&follower.page.cookie) != Some(follower.page.role)
            {
                return None;
            }
            let (step, id) = {
                let view = follower.views.borrow_and_update();
                ((follower.drawn)(&follower.site, &view), view.closed.events)
            };
            if step != follower.last {
                follower.last.clone_from(&step);
                let id = match follower.page.role {
                    // How much is stored says nothing to a participant.
                    Role::Participant => Sent::default(),
                    Role::Experimenter | Role::Viewer => Sent::default().id(id.to_string()),
                };
                return Some((Ok(id.event("step").data(step)), follower));
            }
            tokio::select! {
                changed = follower.views.changed() => if changed.is_err() { return None },
                changed = follower.around.changed() => if changed.is_err() { return None },
                changed = follower.ends.changed() => if changed.is_err() { return None },
            }
        }
    });
    Sse::new(steps).keep_alive(KeepAlive::new().interval(Duration::from_secs(5)))
}

async fn ask(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
    Json(asked): Json<Asked>,
) -> Response {
    if !asked.what.is_for(page.role) {
        return (StatusCode::FORBIDDEN, "not for this page").into_response();
    }
    if !asked.what.is_whole() {
        return (StatusCode::UNPROCESSABLE_ENTITY, "the text is empty").into_response();
    }
    let (reply, answered) = oneshot::channel();
    let mut asked = asked;
    if page.role == Role::Participant {
        let plays = matches!(asked.what, What::Play { .. });
        if plays && !site.asking.views.borrow().open.step.is_played() {
            return StatusCode::UNPROCESSABLE_ENTITY.into_response();
        }
        asked
            .what
            .name_places(&site.asking.views.borrow().closed.places);
    }
    let request = Request {
        // Pages do not know each other's ids.
        id: format!("{} {}", crate::access::second_mark(&page.cookie), asked.id),
        at: (!asked.what.fits_any_step()).then_some(asked.at),
        seen: asked.seen,
        command: asked.what.command(site.consent),
        reply,
    };
    let stopping = || (StatusCode::SERVICE_UNAVAILABLE, "the program ends").into_response();
    if site.asking.requests.send(request).is_err() {
        return stopping();
    }
    let Ok(reply) = answered.await else {
        return stopping();
    };
    let for_all = |status: StatusCode, why: String| match page.role {
        // Reasons name what is presented.
        Role::Participant => status.into_response(),
        Role::Experimenter | Role::Viewer => (status, why).into_response(),
    };
    match reply {
        Reply::Stored => StatusCode::NO_CONTENT.into_response(),
        Reply::MovedOn => StatusCode::CONFLICT.into_response(),
        Reply::Refused(why) => for_all(StatusCode::UNPROCESSABLE_ENTITY, why),
        Reply::NotStored(why) => for_all(StatusCode::INSUFFICIENT_STORAGE, why),
    }
}

async fn pairing(Shared(site): Shared<Site>) -> Response {
    match site.access.new_participant_code() {
        Ok(_) => {
            site.around.send_modify(|around| *around += 1);
            StatusCode::NO_CONTENT.into_response()
        }
        Err(error) => (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response(),
    }
}

/// What takes longer than a page may wait for others.
async fn of_study(
    site: Site,
    of: impl FnOnce(&dyn StudyPages) -> Result<String, String> + Send + 'static,
) -> Result<String, Response> {
    let made = tokio::task::spawn_blocking(move || of(site.study.as_ref())).await;
    match made {
        Ok(Ok(text)) => Ok(text),
        Ok(Err(why)) => Err((StatusCode::UNPROCESSABLE_ENTITY, why).into_response()),
        Err(_panicked) => Err(StatusCode::INTERNAL_SERVER_ERROR.into_response()),
    }
}

async fn matrix(Shared(site): Shared<Site>) -> Response {
    // A report is one file with its style and its figures.
    let policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    match of_study(site, |study| study.matrix()).await {
        Ok(page) => ([(CONTENT_SECURITY_POLICY, policy)], Html(page)).into_response(),
        Err(refused) => refused,
    }
}

async fn answers(Shared(site): Shared<Site>) -> Response {
    let named = [
        (CONTENT_TYPE, "text/csv; charset=utf-8"),
        (CONTENT_DISPOSITION, "attachment; filename=\"answers.csv\""),
    ];
    match of_study(site, |study| study.answers()).await {
        Ok(table) => (named, table).into_response(),
        Err(refused) => refused,
    }
}
