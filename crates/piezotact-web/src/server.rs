//! The routes, who may use them, and their handlers.

use std::convert::Infallible;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::extract::{DefaultBodyLimit, FromRequestParts, Json, Query, State as Shared};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::sse::{Event as Sent, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use axum::{Extension, Router};
use futures_util::stream::{Stream, unfold};
use piezotact_people::campaign::chain::Sha;
use piezotact_study::session::PlayStop;
use serde::Deserialize;
use tokio::sync::{oneshot, watch};

use crate::access::Role;
use crate::asked::{Asked, What};
use crate::beat::{Beat, EVERY};
use crate::desk::{Asking, Reply, Request};
use crate::entrance::{
    LARGEST, Page, Pages, Site, enter, enter_page, guarded, hardened, in_time, known_host,
    language, now_ms, start,
};
use crate::pages::{self, Pairing, Sight};
use crate::view::{OpenStep, View};
use crate::words::Language;
use crate::{assets, console, live, study};

/// The session that pages lead.
pub(crate) struct Led {
    pub(crate) asking: Asking,
    /// The checksum of the text that consent is given to.
    pub(crate) consent: Sha,
    /// Stops what is played.
    pub(crate) stop: PlayStop,
    /// How many pages of each are open.
    pub(crate) experimenters: AtomicUsize,
    pub(crate) participants: AtomicUsize,
    /// What is chosen on the participant's page and not sent yet, with the mark of its step.
    pub(crate) draft: Mutex<(String, Vec<String>)>,
    pub(crate) beat: Arc<Beat>,
}

impl Led {
    /// The participant's draft at the step with this mark.
    fn draft(&self, mark: &str) -> Vec<String> {
        let draft = self.draft.lock().unwrap_or_else(PoisonError::into_inner);
        match draft.0 == mark {
            true => draft.1.clone(),
            false => Vec::new(),
        }
    }

    /// How many pages of `role` are open, where they are counted.
    fn open(&self, role: Role) -> Option<&AtomicUsize> {
        match role {
            Role::Experimenter => Some(&self.experimenters),
            Role::Participant => Some(&self.participants),
            Role::Viewer => None,
        }
    }
}

/// The session, in a handler; where there is none, there is no such page.
pub(crate) struct OfSession(Arc<Led>);

impl FromRequestParts<Site> for OfSession {
    type Rejection = StatusCode;

    async fn from_request_parts(_parts: &mut Parts, site: &Site) -> Result<Self, StatusCode> {
        site.led.clone().map(Self).ok_or(StatusCode::NOT_FOUND)
    }
}

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
    pub method: &'static str,
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
        path: "/favicon.ico",
        whose: For::Everybody,
        handler: |_| get(StatusCode::NO_CONTENT),
    },
    Route {
        method: "GET",
        path: "/assets/session.js",
        whose: For::Everybody,
        handler: |_| get(assets::script),
    },
    Route {
        method: "GET",
        path: "/assets/session.css",
        whose: For::Everybody,
        handler: |_| get(assets::style),
    },
    Route {
        method: "GET",
        path: "/assets/console.js",
        whose: For::Everybody,
        handler: |_| get(assets::console_script),
    },
    Route {
        method: "GET",
        path: "/assets/live.js",
        whose: For::Everybody,
        handler: |_| get(assets::live_script),
    },
    Route {
        method: "GET",
        path: "/assets/uplot.js",
        whose: For::Everybody,
        handler: |_| get(assets::plot_script),
    },
    Route {
        method: "GET",
        path: "/assets/uplot.css",
        whose: For::Everybody,
        handler: |_| get(assets::plot_style),
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
        path: "/draft",
        whose: For::Roles(FEELING),
        handler: |r| guarded(r, post(draft)),
    },
    Route {
        method: "POST",
        path: "/beat",
        whose: For::Roles(LEADING),
        handler: |r| guarded(r, post(beat)),
    },
    Route {
        method: "POST",
        path: "/pairing",
        whose: For::Roles(LEADING),
        handler: |r| guarded(r, post(pairing)),
    },
    Route {
        method: "GET",
        path: "/study",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(study::overview)),
    },
    Route {
        method: "GET",
        path: "/session",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(study::session)),
    },
    Route {
        method: "GET",
        path: "/tables.zip",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(study::tables)),
    },
    Route {
        method: "GET",
        path: "/matrix",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(study::matrix)),
    },
    Route {
        method: "GET",
        path: "/answers.csv",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(study::answers)),
    },
    Route {
        method: "GET",
        path: "/console",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(console::page)),
    },
    Route {
        method: "GET",
        path: "/console/stream",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(console::stream)),
    },
    Route {
        method: "POST",
        path: "/console/ask",
        whose: For::Roles(LEADING),
        handler: |r| guarded(r, post(console::ask)),
    },
    Route {
        method: "GET",
        path: "/console/files/{name}",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(console::file)),
    },
    Route {
        method: "GET",
        path: "/live",
        whose: For::Roles(LOOKING),
        handler: |r| guarded(r, get(live::whole)),
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
type Drawn = Arc<dyn Fn(&Pages, &Led, &View) -> String + Send + Sync>;

fn for_experimenter(page: &Page, sight: Sight, language: Language) -> Drawn {
    let role = page.role;
    Arc::new(move |site, led, view| {
        let code = site.access.code(Role::Participant, now_ms());
        let pairing = Pairing {
            address: code.map(|code| format!("{}/enter?code={code}", site.address())),
            from_network: site.scheme == "https",
            is_paired: site.access.has_participant(now_ms()),
        };
        let open = [&led.experimenters, &led.participants].map(|of| of.load(Ordering::Relaxed));
        let draft = led.draft(&view.open.draft);
        pages::experimenter(view, sight, language, role, (&pairing, open, &draft)).into_string()
    })
}

fn for_participant(language: Language) -> Drawn {
    Arc::new(move |_, led, view| {
        let open = led.participants.load(Ordering::Relaxed);
        pages::participant(&view.open, language, open).into_string()
    })
}

fn framed(
    (site, led): (&Pages, &Led),
    page: &Page,
    language: Language,
    stream: &str,
    drawn: &Drawn,
) -> Html<String> {
    let step = maud::PreEscaped(drawn(site, led, &led.asking.views.borrow()));
    let is_live = site.live.is_some();
    let language = match page.role {
        Role::Participant => pages::of_participant(&led.asking.views.borrow().open, language),
        Role::Experimenter | Role::Viewer => language,
    };
    let framed = pages::frame(
        (page.role, &page.cookie),
        language,
        (stream, is_live),
        &step,
    );
    Html(framed.into_string())
}

async fn experimenter(
    Shared(site): Shared<Site>,
    OfSession(led): OfSession,
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
    framed((&site, &led), &page, language, stream, &drawn)
}

async fn participant(
    Shared(site): Shared<Site>,
    OfSession(led): OfSession,
    Extension(page): Extension<Page>,
    headers: HeaderMap,
) -> Html<String> {
    let language = language(&headers);
    framed(
        (&site, &led),
        &page,
        language,
        "/participant/stream",
        &for_participant(language),
    )
}

/// Counts a page as long as it lives.
struct Counted(Site, Arc<Led>, Role);

impl Counted {
    fn new(site: &Site, led: &Arc<Led>, role: Role) -> Option<Self> {
        led.open(role)?.fetch_add(1, Ordering::Relaxed);
        site.around.send_modify(|around| *around += 1);
        Some(Self(Arc::clone(site), Arc::clone(led), role))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        if let Some(open) = self.1.open(self.2) {
            open.fetch_sub(1, Ordering::Relaxed);
        }
        self.0.around.send_modify(|around| *around += 1);
    }
}

async fn experimenter_stream(
    Shared(site): Shared<Site>,
    OfSession(led): OfSession,
    Extension(page): Extension<Page>,
    Query(seen): Query<Seen>,
    headers: HeaderMap,
) -> Response {
    let drawn = for_experimenter(&page, seen.sight(), language(&headers));
    follow((site, led), page, drawn).into_response()
}

async fn participant_stream(
    Shared(site): Shared<Site>,
    OfSession(led): OfSession,
    Extension(page): Extension<Page>,
    headers: HeaderMap,
) -> Response {
    follow((site, led), page, for_participant(language(&headers))).into_response()
}

/// What a page follows the session with.
struct Follower {
    site: Site,
    led: Arc<Led>,
    page: Page,
    drawn: Drawn,
    views: watch::Receiver<View>,
    around: watch::Receiver<u64>,
    ends: watch::Receiver<bool>,
    last: String,
    next_beat: tokio::time::Instant,
    /// What is acquired, on the same connection: a browser opens six to one address.
    live: Option<live::Following>,
    _counted: Option<Counted>,
}

/// The steps of the session as they come, the present one first, each with the number of stored events as its id. It ends with the program,
/// and where the page is let in no more.
fn follow(
    (site, led): (Site, Arc<Led>),
    page: Page,
    drawn: Drawn,
) -> Sse<impl Stream<Item = Result<Sent, Infallible>>> {
    let counted = Counted::new(&site, &led, page.role);
    let follower = Follower {
        views: led.asking.views.clone(),
        around: site.around.subscribe(),
        ends: site.ends.clone(),
        live: live::Following::of_session(&site, &page),
        site,
        led,
        page,
        drawn,
        last: String::new(),
        next_beat: tokio::time::Instant::now(),
        _counted: counted,
    };
    let steps = unfold(follower, async |mut follower| {
        loop {
            if *follower.ends.borrow()
                || follower.site.access.role(&follower.page.cookie, now_ms())
                    != Some(follower.page.role)
            {
                return None;
            }
            let (step, id) = {
                let view = follower.views.borrow_and_update();
                (
                    (follower.drawn)(&follower.site, &follower.led, &view),
                    view.closed.events,
                )
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
            let beats = follower.page.role == Role::Experimenter && {
                let view = follower.views.borrow();
                view.open.begins || matches!(view.open.step, OpenStep::Playing(_))
            };
            tokio::select! {
                () = tokio::time::sleep_until(follower.next_beat), if beats => {
                    follower.next_beat = tokio::time::Instant::now() + EVERY;
                    // Browsers drop an event without data.
                    return Some((Ok(Sent::default().event("beat").data("beat")), follower));
                },
                event = live::next(&mut follower.live) => return Some((Ok(event?), follower)),
                changed = follower.views.changed() => if changed.is_err() { return None },
                changed = follower.around.changed() => if changed.is_err() { return None },
                changed = follower.ends.changed() => if changed.is_err() { return None },
            }
        }
    });
    Sse::new(steps).keep_alive(KeepAlive::new().interval(Duration::from_secs(5)))
}

async fn ask(
    OfSession(led): OfSession,
    Extension(page): Extension<Page>,
    Json(asked): Json<Asked>,
) -> Response {
    if !asked.what.is_for(page.role) {
        return (StatusCode::FORBIDDEN, "not for this page").into_response();
    }
    if !asked.what.is_whole() {
        return (StatusCode::UNPROCESSABLE_ENTITY, "the text is empty").into_response();
    }
    // Before its turn: what plays is silent when it comes.
    let silences = asked.what.silences(page.role);
    let was_playing = silences.is_some_and(|why| led.stop.stop(why));
    if asked.what == What::Silence {
        return match was_playing {
            true => StatusCode::NO_CONTENT.into_response(),
            // It was over, and counts; or it had not begun, and does not begin.
            false => StatusCode::CONFLICT.into_response(),
        };
    }
    let (reply, answered) = oneshot::channel();
    let mut asked = asked;
    let sent = asked.what.clone();
    if page.role == Role::Participant {
        let plays = matches!(asked.what, What::Play { .. });
        if plays && !led.asking.views.borrow().open.step.is_played() {
            return StatusCode::UNPROCESSABLE_ENTITY.into_response();
        }
        asked
            .what
            .name_places(&led.asking.views.borrow().closed.places);
    }
    let request = Request {
        // Pages do not know each other's ids.
        id: format!("{} {}", crate::access::second_mark(&page.cookie), asked.id),
        at: (!asked.what.fits_any_step()).then_some(asked.at),
        seen: asked.seen,
        stops: led.stop.asked(),
        command: asked.what.command(led.consent),
        sent,
        reply,
    };
    let stopping = || (StatusCode::SERVICE_UNAVAILABLE, "the program ends").into_response();
    if led.asking.requests.send(request).is_err() {
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

/// What is chosen on the participant's page and not sent yet, for the experimenter to see.
#[derive(Debug, Deserialize)]
struct Draft {
    at: String,
    words: Vec<String>,
}

async fn draft(
    Shared(site): Shared<Site>,
    OfSession(led): OfSession,
    Json(draft): Json<Draft>,
) -> StatusCode {
    let is_one = {
        let view = led.asking.views.borrow();
        view.open.draft == draft.at && view.open.step.can_say(&draft.words)
    };
    if !is_one {
        return StatusCode::CONFLICT;
    }
    *led.draft.lock().unwrap_or_else(PoisonError::into_inner) = (draft.at, draft.words);
    site.around.send_modify(|around| *around += 1);
    StatusCode::NO_CONTENT
}

/// An experimenter's page says that it is there while a texture plays.
async fn beat(OfSession(led): OfSession) -> StatusCode {
    led.beat.answered();
    StatusCode::NO_CONTENT
}

async fn pairing(Shared(site): Shared<Site>, _session: OfSession) -> Response {
    match site.access.new_participant_code(now_ms()) {
        Ok(_) => {
            site.around.send_modify(|around| *around += 1);
            StatusCode::NO_CONTENT.into_response()
        }
        Err(error) => (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response(),
    }
}
