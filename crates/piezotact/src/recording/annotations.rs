//! When a recording began, how people label it, and what happened while it ran.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::quantity::Seconds;

/// What a recording carries beside its condition; nothing where nothing is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Annotations {
    /// The time of the first sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_at: Option<StartTime>,
    /// Labels of a laboratory's own, by their names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// What happened, in any order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
}

/// Something that happened while a recording ran: a stimulus, an answer, a mark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// When it began, from the first sample.
    pub onset_s: Seconds,
    /// How long it lasted; 0 for a moment.
    pub duration_s: Seconds,
    /// What kind of event it is.
    pub kind: String,
    /// What was seen, where there is more to say than the kind.
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

/// What an event says beside its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum EventValue {
    /// A number, in the unit that the kind has.
    Number(f64),
    /// A text.
    Text(String),
}

/// A date and a time of day in the form of RFC 3339, such as `2024-03-01T10:22:33.5+01:00`. Where nothing says which zone
/// the clock stood in, the offset is absent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct StartTime(String);

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

/// A text that is no date and time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a date and time such as 2024-03-01T10:22:33+01:00, found `{found}`")]
pub struct NoStartTime {
    /// The text.
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
