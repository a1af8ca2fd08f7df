//! The whole study on pages: its sessions with their reports, the matrices of all answers, and all tables to be kept.

use std::sync::Arc;

use axum::Extension;
use axum::extract::{FromRequestParts, Query, State as Shared};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{Html, IntoResponse, Response};
use maud::{Markup, html};
use serde::Deserialize;

use crate::entrance::{Site, language};
use crate::pages::page;
use crate::words::{Language, Word};

/// A report is one file with its style and its figures.
pub(crate) const REPORT_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Where a session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Planned, and nothing more.
    New,
    /// Consent is asked for.
    Consent,
    /// Trials are presented.
    Running,
    /// In a pause.
    Paused,
    /// Stopped before its end.
    Stopped,
    /// Ended without consent.
    NoConsent,
    /// Every trial is confirmed.
    Complete,
    /// Consent was withdrawn, and nothing is erased yet.
    Withdrawn,
    /// Consent was withdrawn, and everything is erased.
    Erased,
    /// Its plan cannot be read.
    Unreadable,
}

impl Standing {
    fn word(self) -> Word {
        match self {
            Self::New => Word::NotBegun,
            Self::Consent => Word::WaitsForConsent,
            Self::Running => Word::UnderWay,
            Self::Paused => Word::IsPaused,
            Self::Stopped => Word::WasStopped,
            Self::NoConsent => Word::WithoutConsent,
            Self::Complete => Word::IsComplete,
            Self::Withdrawn => Word::WithdrawnNotErased,
            Self::Erased => Word::WithdrawnErased,
            Self::Unreadable => Word::UnreadablePlan,
        }
    }

    /// Whether its report gives nothing away to somebody who still leads it.
    #[must_use]
    pub fn is_over(self) -> bool {
        matches!(self, Self::Stopped | Self::NoConsent | Self::Complete)
    }
}

/// A session of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    pub participant: String,
    /// The name of the session.
    pub session: String,
    pub standing: Standing,
    /// Whether it is a rehearsal.
    pub is_rehearsal: bool,
    /// How many trials are confirmed, and how many are needed; none of one that is erased.
    pub trials: Option<(usize, usize)>,
    /// When the last event was (UTC); empty where there is none.
    pub last: String,
}

/// A study at a glance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overview {
    pub title: String,
    /// Participants who completed the session that the campaign is judged by, and how many are planned.
    pub completed: (usize, usize),
    /// Whether virtual volunteers answer in it, and no person.
    pub is_simulated: bool,
    /// Its sessions, in the order in which they were begun.
    pub sessions: Vec<Listed>,
}

/// What pages show of the whole study.
pub trait StudyPages: Send + Sync {
    /// Its sessions.
    ///
    /// # Errors
    /// One sentence.
    fn overview(&self) -> Result<Overview, String>;

    /// The report of a session that is over, as an HTML document.
    ///
    /// # Errors
    /// One sentence.
    fn session(&self, participant: &str, session: &str) -> Result<String, String>;

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

    /// All tables, as a ZIP file.
    ///
    /// # Errors
    /// One sentence.
    fn tables(&self) -> Result<Vec<u8>, String>;
}

/// The study, in a handler, with the language of whoever asks; where there is none, there is no such page.
pub(crate) struct OfStudy(Arc<dyn StudyPages>, Language);

impl FromRequestParts<Site> for OfStudy {
    type Rejection = StatusCode;

    async fn from_request_parts(parts: &mut Parts, site: &Site) -> Result<Self, StatusCode> {
        let study = site.study.clone().ok_or(StatusCode::NOT_FOUND)?;
        Ok(Self(study, language(&parts.headers)))
    }
}

impl OfStudy {
    /// What takes longer than a page may wait for others; where there is none, a page that says why.
    async fn read<T: Send + 'static>(
        self,
        of: impl FnOnce(&dyn StudyPages) -> Result<T, String> + Send + 'static,
    ) -> Result<T, Response> {
        let Self(study, language) = self;
        let made = tokio::task::spawn_blocking(move || of(study.as_ref())).await;
        match made {
            Ok(Ok(made)) => Ok(made),
            Ok(Err(why)) => {
                let page = refused(language, &why);
                Err((StatusCode::UNPROCESSABLE_ENTITY, Html(page.into_string())).into_response())
            }
            Err(_panicked) => Err(StatusCode::INTERNAL_SERVER_ERROR.into_response()),
        }
    }
}

/// What came of a request for something of the study.
type Read = Result<Response, Response>;

fn report(html: String) -> Response {
    ([(CONTENT_SECURITY_POLICY, REPORT_POLICY)], Html(html)).into_response()
}

fn file(kind: &'static str, name: &'static str, bytes: impl IntoResponse) -> Response {
    let headers = [(CONTENT_TYPE, kind), (CONTENT_DISPOSITION, name)];
    (headers, bytes).into_response()
}

/// Which session.
#[derive(Debug, Deserialize)]
pub(crate) struct Which {
    participant: String,
    session: String,
}

pub(crate) async fn overview(
    Shared(site): Shared<Site>,
    Extension(_page): Extension<crate::entrance::Page>,
    headers: HeaderMap,
    study: OfStudy,
) -> Read {
    let overview = study.read(|study| study.overview()).await?;
    let back = site.led.is_some().then_some("/experimenter");
    let drawn = drawn(&overview, back, language(&headers));
    Ok(Html(drawn.into_string()).into_response())
}

pub(crate) async fn session(study: OfStudy, Query(which): Query<Which>) -> Read {
    let read = study.read(move |study| study.session(&which.participant, &which.session));
    Ok(report(read.await?))
}

pub(crate) async fn matrix(study: OfStudy) -> Read {
    Ok(report(study.read(|study| study.matrix()).await?))
}

pub(crate) async fn answers(study: OfStudy) -> Read {
    let table = study.read(|study| study.answers()).await?;
    let named = "attachment; filename=\"answers.csv\"";
    Ok(file("text/csv; charset=utf-8", named, table))
}

pub(crate) async fn tables(study: OfStudy) -> Read {
    let tables = study.read(|study| study.tables()).await?;
    let named = "attachment; filename=\"tables.zip\"";
    Ok(file("application/zip", named, tables))
}

/// The page of what there is not (yet).
fn refused(language: Language, why: &str) -> Markup {
    let body = html! {
        main.enter {
            h1 { "Piezotact" }
            p.alert role="alert" { (why) }
            p { a href="/" { (Word::Back.in_language(language)) } }
        }
    };
    page(language, "Piezotact", &html! {}, &body)
}

/// The links to what is made of all answers.
pub(crate) fn links(language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        a href="/matrix" target="_blank" { (w(Word::Matrix)) } " · "
        a href="/answers.csv" { (w(Word::AnswersTable)) } " · "
        a href="/tables.zip" { (w(Word::AllTables)) }
    }
}

/// The address of the report of a session.
pub(crate) fn address(participant: &str, session: &str) -> String {
    // Both are names of letters, digits, hyphens and underscores.
    format!("/session?participant={participant}&session={session}")
}

fn drawn(overview: &Overview, back: Option<&str>, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let (done, planned) = overview.completed;
    let body = html! {
        div.experimenter {
            header { h1 { (overview.title) } }
            main {
                section.step {
                    h2 { (w(Word::Sessions)) }
                    @if overview.is_simulated { p.notice { (w(Word::SimulatedStudy)) } }
                    p { (done) " " (w(Word::Of)) " " (planned) " " (w(Word::ParticipantsComplete)) }
                    @if overview.sessions.is_empty() { p { (w(Word::NoSessions)) } } @else { (listed(overview, language)) }
                    @if let Some(back) = back { p { a href=(back) { (w(Word::Back)) } } }
                }
                section.facts { p { (links(language)) } }
            }
        }
    };
    page(language, &overview.title, &html! {}, &body)
}

fn listed(overview: &Overview, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        table.sessions {
            thead { tr {
                th scope="col" { (w(Word::ParticipantWord)) }
                th scope="col" { (w(Word::SessionWord)) }
                th scope="col" { (w(Word::Trials)) }
                th scope="col" { (w(Word::LastEventUtc)) }
            } }
            tbody {
                @for one in &overview.sessions { tr {
                    th scope="row" { (one.participant) }
                    td {
                        (one.session) " · " (w(one.standing.word()))
                        @if one.is_rehearsal { " · " (w(Word::Rehearsal)) }
                        @if one.standing.is_over() {
                            br;
                            a href=(address(&one.participant, &one.session)) target="_blank" { (w(Word::SessionReport)) }
                        }
                    }
                    td.short { @if let Some((done, needed)) = one.trials { (done) " " (w(Word::Of)) " " (needed) } }
                    td.short { (one.last) }
                } }
            }
        }
    }
}
