//! Whether somebody who can stop a texture is there while it plays: an experimenter's page answers each beat that it is sent.
//!
//! The script answers what the server sends, and sets no timer: browsers slow the timers of hidden pages down.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::server::Led;
use crate::words::{Language, Word};

/// How often a page is asked while a texture plays.
pub(crate) const EVERY: Duration = Duration::from_secs(1);
/// A texture ends when no page has answered for so long.
pub(crate) const LONGEST: Duration = Duration::from_secs(3);
/// How often it is looked.
const LOOK: Duration = Duration::from_millis(100);
/// When a page of the experimenter answered last.
#[derive(Debug, Default)]
pub(crate) struct Beat(Mutex<Option<Instant>>);

impl Beat {
    /// A page answers.
    pub(crate) fn answered(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// When that was.
    pub(crate) fn last(&self) -> Option<Instant> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends textures that nobody watches, as long as the pages are served.
pub(crate) async fn watched(led: Arc<Led>) {
    let mut began: Option<Instant> = None;
    let mut is_ended = false;
    loop {
        tokio::time::sleep(LOOK).await;
        if !led.stop.is_playing() {
            (began, is_ended) = (None, false);
            continue;
        }
        let began = *began.get_or_insert_with(Instant::now);
        let last = led.beat.last().map_or(began, |beat| beat.max(began));
        // One stop: each further one would count as a stop of what is asked for next.
        if !is_ended && last.elapsed() > LONGEST {
            is_ended = true;
            led.stop
                .stop(Word::NobodyWatched.in_language(Language::English));
        }
    }
}
