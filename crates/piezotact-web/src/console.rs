//! The console of a bench: which procedures can be started, what runs, and what was made.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use axum::Extension;
use axum::extract::{Json, Path, State as Shared};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event as Sent, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use futures_util::stream::unfold;
use maud::{Markup, html};
use serde::{Deserialize, Serialize};
use tokio::sync::{oneshot, watch};

use crate::access::Role;
use crate::entrance::{Page, Site, language, now_ms};
use crate::pages::page as document;
use crate::study::REPORT_POLICY;
use crate::words::{Language, Word};

/// As many of the last lines are shown.
const LINES: usize = 60;

/// A procedure that can be started, with what it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Procedure {
    /// Its name in requests.
    pub name: &'static str,
    /// What it is called.
    pub title: Word,
    /// What it is asked for.
    pub fields: Vec<Field>,
}

/// One value that a procedure is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name in requests.
    pub name: &'static str,
    /// What it is called.
    pub label: Word,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it may be.
    pub kind: FieldKind,
}

/// What a value may be.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldKind {
    /// A number: what is usual, and from where to where.
    Number {
        usual: f64,
        /// The smallest and the largest.
        range: [f64; 2],
    },
    /// One of these, the first being usual.
    Choice(Vec<String>),
    /// A name, which may be empty.
    Name,
}

/// What a page asks of the bench.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum BenchRequest {
    /// Starts a procedure.
    Start {
        procedure: String,
        /// Its values, by the names of the fields.
        values: BTreeMap<String, String>,
    },
    /// Stops what runs.
    Stop,
}

/// What the console shows beside the live traces.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ConsoleView {
    /// What runs; absent where nothing does.
    pub running: Option<String>,
    /// The command that runs, or ran last, as it would be typed.
    pub command: Option<String>,
    /// What was said, with the time in ms since 1970-01-01 00:00 UTC, the last first.
    pub lines: VecDeque<(i64, String)>,
    /// The files that were made, the last first.
    pub files: Vec<String>,
}

impl ConsoleView {
    /// Adds a line.
    pub fn say(&mut self, line: impl Into<String>) {
        self.lines.push_front((now_ms(), line.into()));
        self.lines.truncate(LINES);
    }
}

/// The files that were made: the type and the content of one that is known.
pub type MadeFile = Box<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

type Asked = (BenchRequest, oneshot::Sender<Result<(), String>>);

/// The pages' side of a console.
pub(crate) struct Console {
    bench: String,
    procedures: Vec<Procedure>,
    requests: Sender<Asked>,
    views: watch::Receiver<ConsoleView>,
    file: MadeFile,
}

/// The side of the program that runs procedures.
#[derive(Debug)]
pub struct ConsoleDesk {
    requests: Receiver<Asked>,
    views: watch::Sender<ConsoleView>,
}

/// A request with the place for what came of it.
#[derive(Debug)]
pub struct Answerable {
    pub request: BenchRequest,
    reply: oneshot::Sender<Result<(), String>>,
}

impl Answerable {
    /// Answers: done, or why not.
    pub fn answer(self, answer: Result<(), String>) {
        // A page that has gone needs no answer.
        let _gone = self.reply.send(answer);
    }
}

impl ConsoleDesk {
    /// Both sides of the console of `bench`, on which `procedures` can be started; `file` gives files that were made.
    pub(crate) fn new(
        bench: String,
        procedures: Vec<Procedure>,
        file: MadeFile,
    ) -> (Self, Console) {
        let (requests, received) = channel();
        let (views, shown) = watch::channel(ConsoleView::default());
        let console = Console {
            bench,
            procedures,
            requests,
            views: shown,
            file,
        };
        let desk = Self {
            requests: received,
            views,
        };
        (desk, console)
    }

    /// The next request, if one comes within `patience`.
    #[must_use]
    pub fn next(&self, patience: Duration) -> Option<Answerable> {
        match self.requests.recv_timeout(patience) {
            Ok((request, reply)) => Some(Answerable { request, reply }),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => None,
        }
    }

    /// Changes what is shown.
    pub fn change(&self, change: impl FnOnce(&mut ConsoleView)) {
        self.views.send_modify(change);
    }
}

/// The console, in a handler; where there is none, there is no such page.
pub(crate) struct OfConsole(Arc<Console>);

impl axum::extract::FromRequestParts<Site> for OfConsole {
    type Rejection = StatusCode;

    async fn from_request_parts(
        _parts: &mut axum::http::request::Parts,
        site: &Site,
    ) -> Result<Self, StatusCode> {
        site.console.clone().map(Self).ok_or(StatusCode::NOT_FOUND)
    }
}

pub(crate) async fn page(
    OfConsole(console): OfConsole,
    Extension(page): Extension<Page>,
    headers: HeaderMap,
) -> Html<String> {
    Html(drawn(&console, &page, language(&headers)).into_string())
}

pub(crate) async fn stream(
    Shared(site): Shared<Site>,
    OfConsole(console): OfConsole,
    Extension(page): Extension<Page>,
) -> impl IntoResponse {
    let from = (site.ends.clone(), console.views.clone(), site, page, true);
    let views = unfold(from, async |(mut ends, mut views, site, page, is_first)| {
        if !is_first {
            tokio::select! {
                changed = views.changed() => if changed.is_err() { return None },
                changed = ends.changed() => if changed.is_err() { return None },
            }
        }
        if *ends.borrow() || site.access.role(&page.cookie, now_ms()) != Some(page.role) {
            return None;
        }
        let json = serde_json::to_string(&*views.borrow_and_update()).unwrap_or_default();
        let event = Sent::default().event("console").data(json);
        Some((Ok::<_, Infallible>(event), (ends, views, site, page, false)))
    });
    Sse::new(views).keep_alive(KeepAlive::new().interval(Duration::from_secs(5)))
}

pub(crate) async fn ask(
    OfConsole(console): OfConsole,
    Json(request): Json<BenchRequest>,
) -> Response {
    let (reply, answered) = oneshot::channel();
    let stopping = || (StatusCode::SERVICE_UNAVAILABLE, "the program ends").into_response();
    if console.requests.send((request, reply)).is_err() {
        return stopping();
    }
    match answered.await {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(why)) => (StatusCode::UNPROCESSABLE_ENTITY, why).into_response(),
        Err(_ends) => stopping(),
    }
}

pub(crate) async fn file(OfConsole(console): OfConsole, Path(name): Path<String>) -> Response {
    let is_known = console.views.borrow().files.contains(&name);
    if !is_known {
        return StatusCode::NOT_FOUND.into_response();
    }
    let wanted = name.clone();
    let read = tokio::task::spawn_blocking(move || (console.file)(&wanted)).await;
    let Ok(Some(bytes)) = read else {
        return (StatusCode::NOT_FOUND, "the file was moved or removed").into_response();
    };
    match name.ends_with(".html") {
        true => {
            let kind = (CONTENT_TYPE, "text/html; charset=utf-8");
            ([kind, (CONTENT_SECURITY_POLICY, REPORT_POLICY)], bytes).into_response()
        }
        false => {
            let kind = (CONTENT_TYPE, "application/octet-stream".to_owned());
            let saved = format!("attachment; filename=\"{}\"", name.replace('"', ""));
            ([kind, (CONTENT_DISPOSITION, saved)], bytes).into_response()
        }
    }
}

fn drawn(console: &Console, page: &Page, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let meta = html! {
        meta name="piezotact-mark" content=(crate::access::second_mark(&page.cookie));
        link rel="stylesheet" href="/assets/uplot.css";
        script src="/assets/uplot.js" defer {}
        script src="/assets/live.js" defer {}
        script src="/assets/console.js" defer {}
    };
    let body = html! {
        div #alerts role="alert" aria-live="assertive" {
            p #not-connected hidden { (w(Word::NoConnection)) }
            p #not-yours hidden { (w(Word::NotYours)) }
            p #refused hidden {}
        }
        div #page.console {
            header {
                h1 { (w(Word::Bench)) " · " (console.bench) }
                p.soft #state role="status" data-idle=(w(Word::NothingRuns)) { (w(Word::NothingRuns)) }
            }
            main {
                section.live aria-label=(w(Word::Live)) {
                    (figures(language))
                    div.charts {
                        (chart("vibration", w(Word::Vibration), "m/s²"))
                        (chart("force", w(Word::ForceWord), "N"))
                        (chart("spectrum", w(Word::SpectrumWord), "(m/s²)²/Hz"))
                        (chart("coherence", w(Word::CoherenceWord), ""))
                    }
                }
                section.aside {
                    @if page.role == Role::Experimenter {
                        button #stop.main type="button" disabled { (w(Word::StopRun)) }
                        @for (i, procedure) in console.procedures.iter().enumerate() { (form(procedure, i, language)) }
                    }
                    (metronome(language))
                    h2 { (w(Word::Files)) }
                    ul #files {}
                    h2 { (w(Word::Log)) }
                    p.soft { code #command {} }
                    ul.log #lines tabindex="0" {}
                }
            }
        }
    };
    document(language, w(Word::Bench), &meta, &body)
}

/// The numbers above the charts; the script fills them in.
fn figures(language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let figure = |id: &str, label: &str| html! { div { dt { (label) } dd id=(id) { "–" } } };
    html! {
        dl.figures {
            (figure("acquired", w(Word::Acquired)))
            (figure("left", w(Word::TimeLeft)))
            (figure("level", w(Word::LevelNow)))
            (figure("force-mean", w(Word::ForceMean)))
            (figure("force-now", w(Word::ForcePresent)))
            (figure("strokes", w(Word::Strokes)))
            (figure("coherence-now", w(Word::MedianCoherence)))
            (figure("judged", w(Word::Judged)))
        }
        p #ended hidden {}
    }
}

fn chart(id: &str, title: &str, unit: &str) -> Markup {
    let unit = match unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    html! { figure { figcaption { (title) (unit) } div.chart id=(id) role="img" aria-label=(title) {} } }
}

/// What a procedure is asked for; that at `place` 0 is open.
fn form(procedure: &Procedure, place: usize, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        details.procedure open[place == 0] {
            summary { (w(procedure.title)) }
            form data-procedure=(procedure.name) {
                @for field in &procedure.fields {
                    label { span { (w(field.label)) @if !field.unit.is_empty() { " (" (field.unit) ")" } }
                        @match &field.kind {
                            FieldKind::Number { usual, range: [low, high] } => {
                                input name=(field.name) type="number" step="any" min=(low) max=(high) value=(usual) required;
                            },
                            FieldKind::Name => { input name=(field.name) type="text" maxlength="64"; },
                            FieldKind::Choice(choices) => {
                                select name=(field.name) { @for choice in choices { option value=(choice) { (choice) } } }
                            },
                        }
                    }
                }
                button type="submit" { (w(Word::StartRun)) }
            }
        }
    }
}

fn metronome(language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        form #metronome {
            h2 { (w(Word::Metronome)) }
            label { span { (w(Word::StrokeEvery)) " (s)" } input name="period" type="number" step="any" min="0.2" max="20" value="2" required; }
            button type="submit" aria-pressed="false" data-off=(w(Word::MetronomeOn)) data-on=(w(Word::MetronomeOff)) { (w(Word::MetronomeOn)) }
            span #beat aria-hidden="true" {}
        }
    }
}
