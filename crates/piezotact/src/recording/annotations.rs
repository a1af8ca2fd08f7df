//! When a recording began, how people label it, and what happened while it ran.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::lineage::Operation;
use crate::quantity::Seconds;

/// Annotations of a recording: start time, labels and events; empty if unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Annotations {
    /// The time of the first sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_at: Option<StartTime>,
    /// Labels defined by the laboratory, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// What happened, in any order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
}

impl Annotations {
    /// The events that do not lie in a recording of `length_s`: before its first sample, after its end, or of a negative
    /// duration.
    #[must_use]
    pub fn outside(&self, length_s: Seconds) -> Vec<&Event> {
        let inside = |event: &&Event| {
            let (onset_s, lasts_s) = (event.onset_s.0, event.duration_s.0);
            // An event at the end counts as inside, with a tolerance of a microsecond.
            onset_s >= 0.0 && lasts_s >= 0.0 && onset_s + lasts_s <= length_s.0 + 1e-6
        };
        self.events.iter().filter(|event| !inside(event)).collect()
    }

    /// The annotations of the part of a recording that begins at `from_s` and lasts `length_s`: labels unchanged, event onsets re
    /// the first sample of the part, events cropped to the part or left out, the start time shifted.
    #[must_use]
    pub fn cut(&self, from_s: Seconds, length_s: Seconds) -> Self {
        let cropped = |event: &Event| {
            let begins_s = event.onset_s.0 - from_s.0;
            let ends_s = begins_s + event.duration_s.0.max(0.0);
            let inside = if event.duration_s.0 > 0.0 {
                begins_s < length_s.0 && ends_s > 0.0
            } else {
                (0.0..length_s.0).contains(&begins_s)
            };
            let (onset_s, end_s) = (begins_s.max(0.0), ends_s.min(length_s.0));
            let whole = begins_s >= 0.0 && ends_s <= length_s.0;
            inside.then(|| Event {
                onset_s: Seconds(onset_s),
                duration_s: match whole {
                    true => event.duration_s,
                    false => Seconds(end_s - onset_s),
                },
                ..event.clone()
            })
        };
        Self {
            started_at: self.started_at.as_ref().map(|start| start.later(from_s)),
            labels: self.labels.clone(),
            events: self.events.iter().filter_map(cropped).collect(),
        }
    }

    /// The annotations of a signal after `operation`. If events have no defined time in the result, they are left out and a
    /// sentence that gives the reason is returned. Labels and the start time are kept.
    #[must_use]
    pub fn after(&self, operation: &Operation) -> (Self, Option<String>) {
        let why = match operation {
            Operation::Stroke { from_s, to_s, .. } => {
                return (self.cut(Seconds(*from_s), Seconds(to_s - from_s)), None);
            }
            Operation::Looped {
                duration_s,
                join: None,
            } => return (self.cut(Seconds(0.0), Seconds(*duration_s)), None),
            Operation::MeanTakenAway { .. }
            | Operation::Gain { .. }
            | Operation::RmsOf { .. }
            | Operation::BandChanged { .. }
            | Operation::Tilted { .. }
            | Operation::Shifted { .. }
            | Operation::SpectrumOf { .. }
            | Operation::Rendered { .. } => return (self.clone(), None),
            Operation::Warped { .. } => "its time axis was warped",
            Operation::PhasesRandomised { .. } => "its phases were randomised",
            Operation::Looped { join: Some(_), .. } => "it was looped",
            Operation::Named { operation, .. } => operation,
        };
        let sentence = (!self.events.is_empty()).then(|| {
            let count = self.events.len();
            format!("{count} event(s) of the recording were left out, since their times are not valid in this signal: {why}")
        });
        let kept = Self {
            events: Vec::new(),
            ..self.clone()
        };
        (kept, sentence)
    }
}

/// Something that happened while a recording ran: a stimulus, an answer, a mark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Event {
    /// When it began, from the first sample.
    pub onset_s: Seconds,
    /// How long it lasted; 0 for a moment.
    pub duration_s: Seconds,
    /// What kind of event it is.
    pub kind: String,
    /// A value of the event beside its kind, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<EventValue>,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3}: {}", self.onset_s, self.kind)?;
        match &self.value {
            Some(EventValue::Number(number)) => write!(f, " {number}")?,
            Some(EventValue::Text(text)) => write!(f, " {text}")?,
            None => {}
        }
        if self.duration_s.0 > 0.0 {
            write!(f, " ({:.3})", self.duration_s)?;
        }
        Ok(())
    }
}

/// The value of an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum EventValue {
    /// A number, in the unit that the kind has.
    Number(f64),
    /// A text.
    Text(String),
}

impl fmt::Display for EventValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => f.write_str(text),
        }
    }
}

/// A date and a time of day in the form of RFC 3339, such as `2024-03-01T10:22:33.5+01:00`. The offset is absent if the time zone
/// of the clock is unknown.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "String", into = "String")]
pub struct StartTime(String);

impl StartTime {
    /// Nanoseconds since 1 March of year 0 on the clock that it was read from, and the offset of that clock.
    fn nanoseconds(&self) -> Option<(i128, &str)> {
        let zone = self.0.rfind(['Z', '+', '-']).filter(|at| *at > 10);
        let (clock, offset) = self.0.split_at(zone.unwrap_or(self.0.len()));
        let (whole, fraction) = clock.split_once('.').unwrap_or((clock, ""));
        let parts: Vec<i128> = whole
            .split(['-', 'T', ':'])
            .filter_map(|part| part.parse().ok())
            .collect();
        let &[year, month, day, hour, minute, second] = parts.as_slice() else {
            return None;
        };
        let digits = fraction.chars().chain("000000000".chars());
        let fraction: String = digits.take(9).collect();
        let of_day = ((hour * 60 + minute) * 60 + second) * SECOND;
        let at = days_of(year, month, day) * DAY + of_day;
        Some((at + fraction.parse::<i128>().unwrap_or(0), offset))
    }

    /// How much later it is than `earlier`, a time of the same clock.
    #[must_use]
    pub fn seconds_since(&self, earlier: &Self) -> Seconds {
        match (self.nanoseconds(), earlier.nanoseconds()) {
            (Some((at, _)), Some((from, _))) => Seconds((at - from) as f64 * 1e-9),
            _ => Seconds(0.0),
        }
    }

    /// The time in ms since 1970-01-01 00:00 UTC; of a clock in an unknown time zone the earliest that it can be. `None` before 1970.
    #[must_use]
    pub fn unix_ms(&self) -> Option<i64> {
        let (at, offset) = self.nanoseconds()?;
        let minutes = match offset {
            "Z" => 0,
            // The clocks that are furthest ahead are 14 h before UTC.
            "" => 14 * 60,
            _ => {
                let (hours, minutes) = offset.get(1..)?.split_once(':')?;
                let ahead = hours.parse::<i128>().ok()? * 60 + minutes.parse::<i128>().ok()?;
                if offset.starts_with('-') {
                    -ahead
                } else {
                    ahead
                }
            }
        };
        let since = at - days_of(1970, 1, 1) * DAY - minutes * 60 * SECOND;
        let ms = i64::try_from(since.div_euclid(1_000_000)).ok()?;
        (ms >= 0).then_some(ms)
    }

    /// The time `by` later, to the nanosecond, in the same zone.
    #[must_use]
    pub fn later(&self, by: Seconds) -> Self {
        let added = (by.0 * 1e9).round();
        let Some((from, offset)) = self.nanoseconds().filter(|_| added != 0.0) else {
            return self.clone();
        };
        let at = from + added as i128;
        let (year, month, day) = date_of(at.div_euclid(DAY));
        let of_day = at.rem_euclid(DAY);
        let second = of_day / SECOND;
        let fraction = format!(".{:09}", of_day % SECOND);
        Self(format!(
            "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}{}{offset}",
            second / 3600,
            second / 60 % 60,
            second % 60,
            fraction.trim_end_matches('0').trim_end_matches('.')
        ))
    }
}

/// Nanoseconds of a second, and of a day.
const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;

/// The days from 1 March of year 0 to a date of the Gregorian calendar.
fn days_of(year: i128, month: i128, day: i128) -> i128 {
    let (year, month) = match month {
        1 | 2 => (year - 1, month + 9),
        _ => (year, month - 3),
    };
    365 * year + year.div_euclid(4) - year.div_euclid(100)
        + year.div_euclid(400)
        + (153 * month + 2) / 5
        + day
        - 1
}

/// The date so many days after 1 March of year 0.
fn date_of(days: i128) -> (i128, i128, i128) {
    let of_era = days.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let year = year_of_era + 400 * days.div_euclid(146_097);
    match month {
        0..=9 => (year, month + 3, day),
        _ => (year + 1, month - 9, day),
    }
}

impl TryFrom<String> for StartTime {
    type Error = NoStartTime;

    fn try_from(text: String) -> Result<Self, NoStartTime> {
        if is_time(&text) {
            Ok(Self(text))
        } else {
            Err(NoStartTime { found: text })
        }
    }
}

impl From<StartTime> for String {
    fn from(time: StartTime) -> Self {
        time.0
    }
}

impl fmt::Display for StartTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A text that is not a valid date and time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a date and time such as 2024-03-01T10:22:33+01:00, found `{found}`")]
pub struct NoStartTime {
    pub found: String,
}

/// Whether `text` is a date and time of RFC 3339, section 5.6, with or without its offset.
fn is_time(text: &str) -> bool {
    let Some((date, time)) = text.split_once('T') else {
        return false;
    };
    let zone = time.find(['Z', '+', '-']).unwrap_or(time.len());
    let (clock, offset) = time.split_at(zone);
    let (seconds, fraction) = clock.split_once('.').unwrap_or((clock, "0"));
    let offset_fits = match offset {
        "" | "Z" => true,
        signed => fits(&signed[1..], ':', &[(2, 0..=23), (2, 0..=59)]),
    };
    fits(date, '-', &[(4, 0..=9999), (2, 1..=12), (2, 1..=31)])
        && fits(seconds, ':', &[(2, 0..=23), (2, 0..=59), (2, 0..=60)])
        && !fraction.is_empty()
        && fraction.bytes().all(|byte| byte.is_ascii_digit())
        && offset_fits
}

/// Whether the parts of `text` between `sign` are numbers of so many digits within the ranges.
fn fits(text: &str, sign: char, parts: &[(usize, std::ops::RangeInclusive<u32>)]) -> bool {
    let found: Vec<&str> = text.split(sign).collect();
    found.len() == parts.len()
        && found.iter().zip(parts).all(|(part, (digits, range))| {
            part.len() == *digits
                && part.bytes().all(|byte| byte.is_ascii_digit())
                && part.parse().is_ok_and(|number| range.contains(&number))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_a_date_and_a_time() {
        for text in [
            "2024-03-01T10:22:33Z",
            "2024-03-01T10:22:33.125+01:00",
            "2024-12-31T23:59:60",
        ] {
            let time = StartTime::try_from(text.to_owned()).unwrap();
            assert_eq!(time.to_string(), text);
        }
        for text in [
            "",
            "2024-03-01",
            "2024-03-01 10:22:33",
            "2024-13-01T10:22:33Z",
            "2024-03-01T24:22:33Z",
            "2024-03-01T10:22:33.Z",
            "2024-03-01T10:22:33+1:00",
            "24-03-01T10:22:33Z",
        ] {
            assert!(StartTime::try_from(text.to_owned()).is_err(), "{text}");
        }
    }

    /// Against the calendar of Python's `datetime`.
    #[test]
    fn a_later_time_follows_the_calendar() {
        for (from, by_s, to) in [
            (
                "2024-02-28T23:59:59.5+01:00",
                0.75,
                "2024-02-29T00:00:00.25+01:00",
            ),
            ("2023-12-31T23:00:00Z", 3600.0, "2024-01-01T00:00:00Z"),
            ("1900-02-28T12:00:00", 86_400.0, "1900-03-01T12:00:00"),
            (
                "2000-02-28T12:00:00-05:00",
                86_400.0,
                "2000-02-29T12:00:00-05:00",
            ),
            ("2024-03-01T00:00:00Z", -1.0, "2024-02-29T23:59:59Z"),
            ("2024-03-01T10:22:33.500Z", 0.0, "2024-03-01T10:22:33.500Z"),
        ] {
            let start = StartTime::try_from(from.to_owned()).unwrap();
            assert_eq!(start.later(Seconds(by_s)).to_string(), to, "{from}");
        }
    }

    #[test]
    fn a_part_keeps_the_events_within_it() {
        let event = |onset_s: f64, duration_s: f64| Event {
            onset_s: Seconds(onset_s),
            duration_s: Seconds(duration_s),
            kind: "stimulus".into(),
            value: None,
        };
        let whole = Annotations {
            started_at: StartTime::try_from("2024-03-01T10:22:33Z".to_owned()).ok(),
            labels: [("session".to_owned(), "2".to_owned())].into(),
            events: vec![
                event(0.5, 0.0),
                event(0.5, 1.0),
                event(1.5, 0.25),
                event(2.75, 1.0),
                event(3.0, 0.0),
            ],
        };
        let part = whole.cut(Seconds(1.0), Seconds(2.0));
        assert_eq!(part.labels, whole.labels);
        let at = part.started_at.map(|start| start.to_string());
        assert_eq!(at.as_deref(), Some("2024-03-01T10:22:34Z"));
        let expected = [event(0.0, 0.5), event(0.5, 0.25), event(1.75, 0.25)];
        assert_eq!(part.events, expected);
        let warp = Operation::Warped {
            ratio: 2.0,
            length: crate::lineage::WarpedLength::Follows,
        };
        let (warped, said) = whole.after(&warp);
        assert_eq!(warped.events, []);
        assert_eq!(
            (&warped.labels, &warped.started_at),
            (&whole.labels, &whole.started_at)
        );
        let said = said.unwrap();
        assert!(
            said.contains("5 event(s)") && said.contains("warped"),
            "{said}"
        );
        let gain = Operation::Gain { gain_db: 3.0 };
        assert_eq!(whole.after(&gain), (whole.clone(), None));
        let stroke = Operation::Stroke {
            number: 1,
            from_s: 1.0,
            to_s: 3.0,
            high_pass_hz: 10.0,
        };
        assert_eq!(whole.after(&stroke).0.events, expected);
    }

    #[test]
    fn what_is_empty_is_absent_and_what_is_not_comes_back() {
        assert_eq!(
            serde_json::to_string(&Annotations::default()).unwrap(),
            "{}"
        );
        let all = r#"{"started_at":"2024-03-01T10:22:33Z","labels":{"session":"2"},"events":[{"onset_s":0.5,"duration_s":0.0,"kind":"answer","value":"rough"},{"onset_s":1.0,"duration_s":0.25,"kind":"level","value":3.0}]}"#;
        let read: Annotations = serde_json::from_str(all).unwrap();
        assert_eq!(read.events[1].value, Some(EventValue::Number(3.0)));
        assert_eq!(serde_json::to_string(&read).unwrap(), all);
        assert!(serde_json::from_str::<Annotations>(r#"{"started_at":"noon"}"#).is_err());
    }
}
