//! What a bench acquires, for pages: drawn by a thread of its own, so that an acquisition never waits for a page.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use axum::Extension;
use axum::extract::State as Shared;
use axum::http::StatusCode;
use axum::response::sse::{Event as Sent, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{Stream, unfold};
use piezotact::monitor::{ForceNow, Monitor, MonitorConfig, MonitorView};
use piezotact::run::{Judged, RunDocument, Sink, SinkError};
use serde::Serialize;
use serde_json::Value;
use tokio::sync::watch;

use crate::access::Role;
use crate::entrance::{Page, Site, now_ms};

/// How often traces are drawn.
const OFTEN: Duration = Duration::from_millis(150);
/// How often coherence and strokes are, at most; never more than a fifth of the time.
const RARELY: Duration = Duration::from_secs(1);

/// Takes the documents of runs, and shows them on the pages of a site. Clones show the same.
#[derive(Clone, Debug)]
pub struct Live(Sender<RunDocument>);

/// What pages show of it.
#[derive(Clone, Debug)]
pub struct Pictures(watch::Receiver<Arc<Picture>>);

/// What is sent, as JSON.
#[derive(Clone, Debug, Default)]
struct Picture {
    number: u64,
    fast: String,
    /// Coherence and strokes, and how often they were computed.
    slow: (u64, String),
    force: String,
}

impl Live {
    /// A place to show runs, and what pages show of it.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new() -> std::io::Result<(Self, Pictures)> {
        let (documents, taken) = channel();
        let (pictures, shown) = watch::channel(Arc::default());
        let thread = std::thread::Builder::new().name("live".into());
        // It ends when nobody shows runs any more.
        let _ends_by_itself = thread.spawn(move || draw(&taken, &pictures))?;
        Ok((Self(documents), Pictures(shown)))
    }

    /// Shows `document`.
    pub fn show(&self, document: RunDocument) {
        // Where nobody draws it any more, the run goes on.
        let _gone = self.0.send(document);
    }
}

impl Sink for Live {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        self.show(document.clone());
        Ok(None)
    }
}

#[derive(Serialize)]
struct Slow {
    coherence: Option<piezotact::monitor::CoherenceNow>,
    strokes: Option<piezotact::monitor::StrokesNow>,
}

#[derive(Serialize)]
struct ForceOnly {
    now: Option<ForceNow>,
    runs: bool,
}

fn draw(documents: &Receiver<RunDocument>, pictures: &watch::Sender<Arc<Picture>>) {
    let mut monitor = Monitor::new(MonitorConfig::console());
    let mut picture = Picture::default();
    let (mut drawn, mut summed, mut took) = (Instant::now(), Instant::now(), Duration::ZERO);
    let mut is_new = false;
    loop {
        match documents.recv_timeout(OFTEN) {
            Ok(document) => {
                is_new = true;
                let at_once = !matches!(document, RunDocument::Chunk(_));
                monitor.take(&document);
                if !at_once && drawn.elapsed() < OFTEN {
                    continue;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        if !is_new {
            continue;
        }
        let view = monitor.view();
        let is_over = view.ended.is_some();
        if is_over || summed.elapsed() >= RARELY.max(took * 4) {
            let began = Instant::now();
            let slow = Slow {
                coherence: monitor.coherence(),
                strokes: monitor.strokes(),
            };
            picture.slow = (picture.slow.0 + 1, json(&slow));
            (took, summed) = (began.elapsed(), Instant::now());
        }
        picture.number += 1;
        picture.fast = json(&view);
        picture.force = json(&force_of(&view));
        pictures.send_replace(Arc::new(picture.clone()));
        (drawn, is_new) = (Instant::now(), false);
    }
}

fn force_of(view: &MonitorView) -> ForceOnly {
    ForceOnly {
        now: view.force_now.clone(),
        runs: view.label.is_some() && view.ended.is_none(),
    }
}

/// `value` as JSON with four digits of each number: what a screen shows.
fn json(value: &impl Serialize) -> String {
    fn short(value: &mut Value) {
        match value {
            Value::Array(all) => all.iter_mut().for_each(short),
            Value::Object(all) => all.values_mut().for_each(short),
            Value::Number(number) if number.is_f64() => {
                let digits = number.as_f64().map(|number| format!("{number:.3e}"));
                let rounded = digits.and_then(|digits| digits.parse::<f64>().ok());
                *value = rounded.map_or(Value::Null, Value::from);
            }
            _ => {}
        }
    }
    let mut value = serde_json::to_value(value).unwrap_or(Value::Null);
    // Times need more digits than four: they are counted from the last one.
    since_last(&mut value);
    short(&mut value);
    value.to_string()
}

/// Turns the times of traces into times before the last sample, which is stated.
fn since_last(value: &mut Value) {
    for name in ["vibration", "force"] {
        let Some(Value::Array(times)) = value.pointer_mut(&format!("/{name}/at_s")) else {
            continue;
        };
        let last = times.last().and_then(Value::as_f64).unwrap_or_default();
        for time in times {
            *time = time
                .as_f64()
                .map_or(Value::Null, |at| Value::from(at - last));
        }
    }
}

/// Which of the pictures a page is sent.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Whole,
    Force,
}

/// Everything that is acquired, for whoever leads or looks on.
pub(crate) async fn whole(
    Shared(site): Shared<Site>,
    Extension(page): Extension<Page>,
) -> Response {
    sent(site, page, Part::Whole)
}

fn sent(site: Site, page: Page, part: Part) -> Response {
    match site.live.clone() {
        Some(pictures) => Sse::new(stream(site, page, pictures.0, part))
            .keep_alive(KeepAlive::new().interval(Duration::from_secs(5)))
            .into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

/// The last picture, whenever there is a new one and the page has taken the one before.
fn stream(
    site: Site,
    page: Page,
    pictures: watch::Receiver<Arc<Picture>>,
    part: Part,
) -> impl Stream<Item = Result<Sent, Infallible>> {
    let following = Following::new(site, page, pictures, part);
    unfold(following, async |mut following| {
        let event = following.next().await?;
        Some((Ok(event), following))
    })
}

/// The next event of what a page of a session follows; never where it follows nothing.
pub(crate) async fn next(following: &mut Option<Following>) -> Option<Sent> {
    match following {
        Some(following) => following.next().await,
        None => std::future::pending().await,
    }
}

/// A page that follows.
pub(crate) struct Following {
    site: Site,
    page: Page,
    pictures: watch::Receiver<Arc<Picture>>,
    ends: watch::Receiver<bool>,
    part: Part,
    /// The numbers of the traces and of the sums that were sent last.
    sent: (u64, u64),
    /// The force that was sent last.
    last: String,
}

impl Following {
    /// What a page of a session follows, where a bench shows what it acquires: the participant the force alone, as nothing else follows
    /// from what is played.
    pub(crate) fn of_session(site: &Site, page: &Page) -> Option<Self> {
        let part = match page.role {
            Role::Participant => Part::Force,
            Role::Experimenter | Role::Viewer => Part::Whole,
        };
        let pictures = site.live.clone()?;
        Some(Self::new(Arc::clone(site), page.clone(), pictures.0, part))
    }

    fn new(site: Site, page: Page, pictures: watch::Receiver<Arc<Picture>>, part: Part) -> Self {
        Self {
            ends: site.ends.clone(),
            site,
            page,
            pictures,
            part,
            sent: (0, 0),
            last: String::new(),
        }
    }

    /// The next event; `None` at the end of the program, and where the page is let in no more.
    async fn next(&mut self) -> Option<Sent> {
        loop {
            if *self.ends.borrow()
                || self.site.access.role(&self.page.cookie, now_ms()) != Some(self.page.role)
            {
                return None;
            }
            let picture = Arc::clone(&self.pictures.borrow_and_update());
            if let Some(event) = self.event(&picture) {
                // There may be a second event of the same picture.
                self.pictures.mark_changed();
                return Some(event);
            }
            tokio::select! {
                changed = self.pictures.changed() => changed.ok()?,
                changed = self.ends.changed() => changed.ok()?,
            }
        }
    }

    fn event(&mut self, picture: &Picture) -> Option<Sent> {
        let (fast, slow) = self.sent;
        match self.part {
            Part::Whole if picture.slow.0 != slow => {
                self.sent.1 = picture.slow.0;
                Some(Sent::default().event("slow").data(&picture.slow.1))
            }
            Part::Whole if picture.number != fast => {
                self.sent.0 = picture.number;
                Some(Sent::default().event("fast").data(&picture.fast))
            }
            Part::Force if picture.number != fast && picture.force != self.last => {
                self.sent.0 = picture.number;
                self.last.clone_from(&picture.force);
                Some(Sent::default().event("force").data(&picture.force))
            }
            Part::Whole | Part::Force => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_has_four_digits_and_times_before_now() {
        let view = serde_json::json!({
            "acquired_s": 1234.5678,
            "vibration": {"at_s": [1224.025, 1234.5678], "low": [-0.000_123_456, 1.0]},
            "averages": 12345,
        });
        let sent: Value = serde_json::from_str(&json(&view)).unwrap();
        assert_eq!(sent["vibration"]["at_s"], serde_json::json!([-10.54, 0.0]));
        assert_eq!(sent["vibration"]["low"][0], serde_json::json!(-0.000_123_5));
        assert_eq!(sent["averages"], serde_json::json!(12345));
    }
}
