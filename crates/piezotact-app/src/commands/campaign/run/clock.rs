//! The clock of the computer, before a session begins or goes on.

use piezotact_study::store::StudyStore;

use crate::commands::campaign::study::{now_ms, said};
use crate::failure::Outcome;
use crate::output::say;

/// Two clocks that are set may differ by so much, ms.
const APART_MS: i64 = 60_000;

/// Says where the clock is behind what is stored already, and gives what it said.
pub(crate) fn check(store: &StudyStore) -> Outcome<Option<String>> {
    let newest_ms = store.newest_ms()?;
    let warning = newest_ms.and_then(|newest_ms| behind(now_ms(), newest_ms));
    if let Some(warning) = &warning {
        say(&format!("warning: {warning}"));
    }
    Ok(warning)
}

/// What is to be known of a clock at `now_ms` in a study whose newest event is of `newest_ms`.
fn behind(now_ms: i64, newest_ms: i64) -> Option<String> {
    let behind_ms = newest_ms.saturating_sub(now_ms);
    let minutes = behind_ms / 60_000;
    let how_far = match minutes {
        0..120 => format!("{minutes} min"),
        120..2880 => format!("{} h", minutes / 60),
        _ => format!("{} days", minutes / 1440),
    };
    (behind_ms > APART_MS).then(|| {
        format!(
            "the clock of this computer says {} (UTC), {how_far} before the newest event of the study ({}): times and ages would be \
             wrong; leave the session, set the clock, and give the same command again",
            said(now_ms),
            said(newest_ms)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::behind;

    #[test]
    fn a_clock_that_is_behind_is_said_from_a_minute_on() {
        const NOW_MS: i64 = 1_772_360_520_000;
        for (behind_ms, said) in [
            (-1, None),
            (60_000, None),
            (61_000, Some("1 min before")),
            (3 * 3_600_000, Some("3 h before")),
            (
                6 * 86_400_000,
                Some("6 days before the newest event of the study (2026-03-07 10:22)"),
            ),
        ] {
            let found = behind(NOW_MS, NOW_MS + behind_ms);
            assert_eq!(found.is_some(), said.is_some(), "{behind_ms}");
            assert!(found.unwrap_or_default().contains(said.unwrap_or_default()));
        }
        // A number that is no time is no reason to panic.
        assert!(behind(i64::MIN, i64::MAX).is_some());
    }
}
