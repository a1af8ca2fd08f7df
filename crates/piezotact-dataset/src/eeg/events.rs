//! Markers of EEG in a table (BIDS `_events.tsv`).

use std::path::Path;

use piezotact::Warning;
use piezotact::number::counted;
use piezotact::quantity::Seconds;
use piezotact::recording::{Event, EventValue, RecordingWarning};

use super::EegSegment;
use super::beside::table_of;
use crate::error::ReadError;

/// The events of a table with columns `onset` (s from the first sample) and `duration`, in its order. An event is called by its `trial_type`, or
/// where it has none by its `value`. Rows without an onset or a name (`n/a`) are left out, with a warning.
///
/// Source: BIDS 1.10.1, task events.
pub(super) fn read_events(path: &Path) -> Result<(Vec<Event>, Option<Warning>), ReadError> {
    let (header, rows) = table_of(path)?;
    let column = |name: &str| header.iter().position(|own| own == name);
    let needed = |name: &str| {
        column(name).ok_or_else(|| {
            ReadError::content(
                path,
                "columns onset, duration, and trial_type or value",
                header.join(", "),
                format!("add the column {name}"),
            )
        })
    };
    let (onset, duration) = (needed("onset")?, needed("duration")?);
    let (kind, value) = (column("trial_type"), column("value"));
    if kind.is_none() && value.is_none() {
        needed("trial_type")?;
    }
    let mut events = Vec::new();
    let mut left_out = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let cell = |at: usize| {
            let text = row.get(at).map_or("", String::as_str);
            (!text.is_empty() && text != "n/a").then_some(text)
        };
        let seconds = |at: usize| match cell(at) {
            None => Ok(None),
            Some(text) => match text.parse::<f64>() {
                Ok(found) if found.is_finite() => Ok(Some(found)),
                _ => Err(ReadError::content(
                    path,
                    format!("a time in s in row {}", number + 2),
                    format!("`{text}`"),
                    "correct it, or write n/a",
                )),
            },
        };
        let (Some(onset_s), lasts_s) = (seconds(onset)?, seconds(duration)?) else {
            left_out.push(number + 2);
            continue;
        };
        let (kind, value) = match (kind.and_then(cell), value.and_then(cell)) {
            (Some(kind), _) => (kind.to_owned(), None),
            (None, Some(value)) => ("value".to_owned(), Some(value)),
            (None, None) => {
                left_out.push(number + 2);
                continue;
            }
        };
        let value = value.map(|text| match text.parse::<f64>() {
            Ok(number) if number.is_finite() => EventValue::Number(number),
            _ => EventValue::Text(text.to_owned()),
        });
        events.push(Event {
            onset_s: Seconds(onset_s),
            duration_s: Seconds(lasts_s.unwrap_or(0.0).max(0.0)),
            kind,
            value,
        });
    }
    let warning = left_out.first().map(|first| {
        let what = format!(
            "{} of {} without an onset or a name ({}) {} left out",
            counted(left_out.len(), "event"),
            path.display(),
            match left_out.len() {
                1 => format!("row {first}"),
                _ => format!("the first in row {first}"),
            },
            if left_out.len() == 1 { "was" } else { "were" }
        );
        Warning::from(RecordingWarning::Guessed { what })
    });
    Ok((events, warning))
}

/// Puts `events`, with onsets from the first sample of the file, in the place of those of `segments`: each into the last part that begins before
/// it.
pub(super) fn put(events: Vec<Event>, segments: &mut [EegSegment]) {
    for segment in segments.iter_mut() {
        segment.recording.annotations.events.clear();
        segment.event_samples.clear();
    }
    for mut event in events {
        let begun = segments.partition_point(|one| one.start_s.0 <= event.onset_s.0);
        let Some(segment) = segments.get_mut(begun.saturating_sub(1)) else {
            return;
        };
        event.onset_s = Seconds(event.onset_s.0 - segment.start_s.0);
        let rates = segment.recording.clocks().iter();
        let rate_hz = rates.map(|clock| clock.rate_hz.hz()).fold(0.0, f64::max);
        let sample = (event.onset_s.0 * rate_hz).round_ties_even() as i64;
        segment.event_samples.push(sample);
        segment.recording.annotations.events.push(event);
    }
}

/// How many of `events`, with onsets from the first sample of the file, have no marker of `segments` within one sample.
pub(super) fn without_marker(events: &[Event], segments: &[EegSegment]) -> usize {
    let mut times_s: Vec<f64> = Vec::new();
    let mut step_s = 0.0_f64;
    for segment in segments {
        let rates = segment.recording.clocks().iter();
        step_s = rates
            .map(|clock| 1.0 / clock.rate_hz.hz())
            .fold(step_s, f64::max);
        let own = segment.recording.annotations.events.iter();
        times_s.extend(own.map(|event| segment.start_s.0 + event.onset_s.0));
    }
    times_s.sort_unstable_by(f64::total_cmp);
    let is_marked = |event: &&Event| {
        let reach_s = 1.001 * step_s;
        let first = times_s.partition_point(|t| *t < event.onset_s.0 - reach_s);
        times_s
            .get(first)
            .is_some_and(|t| *t <= event.onset_s.0 + reach_s)
    };
    events.len() - events.iter().filter(is_marked).count()
}

/// How many markers `segments` hold: those that say where a part begins are none.
pub(super) fn markers(segments: &[EegSegment]) -> usize {
    let all = segments
        .iter()
        .flat_map(|segment| &segment.recording.annotations.events);
    let begins = |event: &&Event| event.kind.trim().eq_ignore_ascii_case("new segment");
    all.filter(|event| !begins(event)).count()
}
