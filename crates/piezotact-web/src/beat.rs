//! Whether somebody who can stop a texture is there while it plays: an experimenter's page answers each beat that it is sent.
//!
//! The script answers what the server sends, and sets no timer: browsers slow the timers of hidden pages down.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::entrance::{Pages, now_ms};
use crate::server::Led;
use crate::words::{Language, Word};

/// How often a page is asked while a texture plays.
pub(crate) const EVERY: Duration = Duration::from_secs(1);
/// A texture ends when no page has answered for so long.
pub(crate) const LONGEST: Duration = Duration::from_secs(3);
/// How often it is looked.
const LOOK: Duration = Duration::from_millis(100);

/// When a page of the experimenter answered last, and whether the participant's page is away.
#[derive(Debug, Default)]
pub(crate) struct Beat {
    answered: Mutex<Option<Instant>>,
    is_away: AtomicBool,
}

impl Beat {
    /// A page answers.
    pub(crate) fn answered(&self) {
        let mut last = self.answered.lock().unwrap_or_else(PoisonError::into_inner);
        *last = Some(Instant::now());
    }

    /// When that was.
    pub(crate) fn last(&self) -> Option<Instant> {
        *self.answered.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the participant has a device and its page is not open: the participant cannot stop a texture.
    pub(crate) fn is_participant_away(&self) -> bool {
        self.is_away.load(Ordering::Relaxed)
    }
}

/// Ends textures that nobody watches, and looks for the participant's page, as long as the pages are served.
pub(crate) async fn watched(site: Arc<Pages>, led: Arc<Led>) {
    let mut began: Option<Instant> = None;
    let mut is_ended = false;
    loop {
        let is_open = led.participants.load(Ordering::Relaxed) > 0;
        let is_away = !is_open && site.access.has_participant(now_ms());
        led.beat.is_away.store(is_away, Ordering::Relaxed);
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
