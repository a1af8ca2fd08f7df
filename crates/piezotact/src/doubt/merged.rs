//! Doubts that differ in numbers, or in what they name, as one with its range: twenty recordings that are each doubted for
//! the same reason are one thing to know.

use std::fmt;

use serde::Serialize;
use serde_json::Value;

use super::Doubt;

/// As many names are written out.
const NAMED: usize = 3;

/// Doubts of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// The first of them.
    pub doubt: Doubt,
    /// How many there are.
    pub count: usize,
    /// The names of the recordings, files or groups that they are about, each once; empty where none was given.
    pub about: Vec<String>,
    /// What they name themselves (groups, channels, measurements), each once; empty where that is one or none.
    pub subjects: Vec<String>,
    /// The numbers in which they differ.
    pub ranges: Vec<Range>,
}

/// A number of several doubts from its lowest to its highest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The doubts' field, with its unit.
    pub field: String,
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
}

/// `doubts`, those of one kind as one. Two are of one kind when they are the same doubt about the same things and differ in
/// numbers, in the parts of a band that they list, or in what they name as their subject.
///
/// Source: decision 0030 of this project.
#[must_use]
pub fn merged<'a>(doubts: impl IntoIterator<Item = &'a Doubt>) -> Vec<Merged> {
    merged_of(doubts.into_iter().map(|doubt| (None, doubt)))
}

/// As [`merged`], of doubts with the name of what each is about, where it has one.
///
/// Source: decision 0030 of this project.
#[must_use]
pub fn merged_of<'a>(
    doubts: impl IntoIterator<Item = (Option<&'a str>, &'a Doubt)>,
) -> Vec<Merged> {
    let mut kinds: Vec<(Option<Value>, Merged)> = Vec::new();
    for (name, doubt) in doubts {
        let Kind {
            kind,
            subject,
            numbers,
        } = Kind::of(doubt);
        let place = kinds.iter().position(|(other, merged)| match &kind {
            Some(_) => *other == kind,
            None => merged.doubt == *doubt,
        });
        let place = place.unwrap_or_else(|| {
            let first = Merged {
                doubt: doubt.clone(),
                count: 0,
                about: Vec::new(),
                subjects: Vec::new(),
                ranges: Vec::new(),
            };
            kinds.push((kind, first));
            kinds.len() - 1
        });
        let one = &mut kinds[place].1;
        one.count += 1;
        for (new, known) in [
            (name.map(str::to_owned), &mut one.about),
            (subject, &mut one.subjects),
        ] {
            known.extend(new.filter(|new| !known.contains(new)));
        }
        for (field, value) in numbers {
            match one.ranges.iter_mut().find(|range| range.field == field) {
                Some(range) => {
                    (range.low, range.high) = (range.low.min(value), range.high.max(value));
                }
                None => one.ranges.push(Range {
                    field,
                    low: value,
                    high: value,
                }),
            }
        }
    }
    let mut merged: Vec<Merged> = kinds.into_iter().map(|(_, one)| one).collect();
    for one in &mut merged {
        one.ranges.retain(|range| range.low < range.high);
        if one.subjects.len() < 2 {
            one.subjects.clear();
        }
    }
    merged
}

/// What makes a doubt the same as another, and what may differ.
struct Kind {
    /// The doubt without its numbers and its subject; `None` for one that cannot be written as fields.
    kind: Option<Value>,
    subject: Option<String>,
    numbers: Vec<(String, f64)>,
}

impl Kind {
    fn of(doubt: &Doubt) -> Self {
        let mut bare = doubt.clone();
        let subject = bare.take_subject();
        let mut kind = serde_json::to_value(&bare).ok();
        let mut numbers = Vec::new();
        if let Some(fields) = kind.as_mut().and_then(Value::as_object_mut) {
            for (field, value) in fields {
                match value {
                    Value::Number(number) => {
                        numbers.extend(number.as_f64().map(|number| (field.clone(), number)));
                        *value = Value::Null;
                    }
                    // The parts of a band.
                    Value::Array(parts) if parts.iter().all(Value::is_array) => {
                        *value = Value::Null;
                    }
                    _ => {}
                }
            }
        }
        Self {
            kind,
            subject,
            numbers,
        }
    }
}

impl Doubt {
    /// Takes away what the doubt names as its subject, and returns it; what it names as an example goes with it.
    fn take_subject(&mut self) -> Option<String> {
        match self {
            Self::OddOneOut { at: example, .. }
            | Self::OppositeSign {
                such_as: example, ..
            }
            | Self::OtherParticipant { found: example, .. }
            | Self::OfMembers { example, .. }
            | Self::Rejected {
                reasons: example, ..
            } => example.clear(),
            _ => {}
        }
        match self {
            Self::Uncalibrated { channel: subject }
            | Self::CoarseQuantisation {
                channel: subject, ..
            }
            | Self::DeadChannel { channel: subject }
            | Self::SignReversed { channel: subject }
            | Self::InterruptedLater { journal: subject }
            | Self::CutsNotApplied { file: subject, .. }
            | Self::FewStrokes { what: subject, .. }
            | Self::Scattered { group: subject, .. }
            | Self::Pooled { group: subject, .. }
            | Self::NoInterval { what: subject, .. }
            | Self::NotFelt { what: subject, .. }
            | Self::OddOneOut {
                participant: subject,
                ..
            }
            | Self::MixedRepeats { of: subject, .. }
            | Self::OppositeSign {
                measurement: subject,
                ..
            }
            | Self::OtherParticipant {
                measurement: subject,
                ..
            } => Some(std::mem::take(subject)),
            _ => None,
        }
    }
}

impl Merged {
    /// What it tells a person where `all` recordings (or whatever `called` says, in the plural) could be doubted: that it is
    /// all of them, or which.
    #[must_use]
    pub fn text_of(&self, all: usize, called: &str) -> String {
        if all > NAMED && self.about.len() == all {
            return format!("all {all} {called}: {}", self.sentence());
        }
        self.to_string()
    }

    fn sentence(&self) -> String {
        let more = [self.likewise(), self.numbers()];
        let more: Vec<String> = more.into_iter().flatten().collect();
        if more.is_empty() {
            return self.doubt.to_string();
        }
        format!("{} ({})", self.doubt, more.join("; "))
    }

    fn likewise(&self) -> Option<String> {
        let others = self.subjects.get(1..)?;
        Some(format!("likewise {}", listed(others)))
    }

    fn numbers(&self) -> Option<String> {
        if self.ranges.is_empty() {
            return None;
        }
        let ranges: Vec<String> = self.ranges.iter().map(ToString::to_string).collect();
        Some(format!(
            "{} of this kind: {}",
            self.count,
            ranges.join(", ")
        ))
    }
}

impl fmt::Display for Merged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.about.is_empty() {
            write!(f, "{}: ", listed(&self.about))?;
        }
        f.write_str(&self.sentence())
    }
}

/// The first names, and how many there are beside them.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] if names.len() <= NAMED => format!("{} and {last}", first.join(", ")),
        _ => {
            let named = NAMED - 1;
            format!(
                "{} and {} more",
                names[..named].join(", "),
                names.len() - named
            )
        }
    }
}

/// How the names of fields end, and the units that this stands for.
const UNITS: [(&str, &str); 10] = [
    ("_db_rms", "dB rms"),
    ("_v_per_s", "V/s"),
    ("_m_s", "m/s"),
    ("_hz", "Hz"),
    ("_db", "dB"),
    ("_pa", "Pa"),
    ("_s", "s"),
    ("_n", "N"),
    ("_m", "m"),
    ("_v", "V"),
];

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = ["share", "fraction"]
            .iter()
            .any(|of| self.field.contains(of));
        let unit = UNITS
            .iter()
            .find_map(|(end, unit)| Some((self.field.strip_suffix(end)?, *unit)));
        let (name, unit, scale) = match unit {
            _ if share => (self.field.as_str(), "%", 100.0),
            Some((name, unit)) => (name, unit, 1.0),
            None => (self.field.as_str(), "", 1.0),
        };
        let (low, high) = (digits(scale * self.low), digits(scale * self.high));
        write!(f, "{} {low} to {high}", name.replace('_', " "))?;
        if unit.is_empty() {
            return Ok(());
        }
        write!(f, " {unit}")
    }
}

/// Three digits that count, and none beyond.
fn digits(value: f64) -> String {
    let before = if value == 0.0 {
        0.0
    } else {
        value.abs().log10().floor()
    };
    if !(-4.0..6.0).contains(&before) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", (2.0 - before).max(0.0) as usize);
    match text.split_once('.') {
        Some(_) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Band, Hertz};

    fn outside(share: f64) -> Doubt {
        let band = Band::new(Hertz(20.0), Hertz(500.0)).unwrap();
        Doubt::PowerOutsideBand { share, band }
    }

    /// Fifty doubts that differ in a number are one with its range, about all fifty files.
    #[test]
    fn doubts_that_differ_in_a_number_are_one_with_its_range() {
        let files: Vec<String> = (0..50).map(|k| format!("text{k}.vav")).collect();
        let doubts: Vec<Doubt> = (0..50)
            .map(|k| outside(0.2 + 0.01 * f64::from(k)))
            .collect();
        let told = merged_of(files.iter().map(|file| Some(file.as_str())).zip(&doubts));
        assert_eq!(
            (told.len(), told[0].count, told[0].about.len()),
            (1, 50, 50)
        );
        let text = told[0].text_of(50, "recordings");
        assert!(
            text.starts_with("all 50 recordings: 20 % of the texture's power"),
            "{text}"
        );
        assert!(
            text.ends_with("(50 of this kind: share 20 to 69 %)"),
            "{text}"
        );
        // Another band is another doubt.
        let band = Band::new(Hertz(20.0), Hertz(900.0)).unwrap();
        let other = [outside(0.2), Doubt::PowerOutsideBand { share: 0.2, band }];
        assert_eq!(merged(&other).len(), 2);
    }

    /// Every file is counted, whatever else is doubted of it: of 20 files with two doubts each, both are about all 20.
    #[test]
    fn every_file_is_counted_whatever_else_is_doubted_of_it() {
        let names: Vec<String> = (0..20).map(|k| format!("{k}.vav")).collect();
        let both = [outside(0.3), Doubt::ZeroUnknown];
        let all = names
            .iter()
            .flat_map(|name| both.iter().map(move |d| (Some(name.as_str()), d)));
        for one in merged_of(all) {
            assert_eq!(one.about.len(), 20);
            assert!(
                one.text_of(20, "recordings")
                    .starts_with("all 20 recordings: ")
            );
            assert!(one.to_string().starts_with("0.vav, 1.vav and 18 more: "));
        }
        let two = names[..2]
            .iter()
            .map(|name| (Some(name.as_str()), &both[1]));
        let text = merged_of(two)[0].text_of(20, "recordings");
        assert!(
            text.starts_with("0.vav and 1.vav: the finger never leaves"),
            "{text}"
        );
    }

    #[test]
    fn what_a_doubt_names_is_listed() {
        let few = |what: &str, kept| Doubt::FewStrokes {
            what: what.into(),
            kept,
            recommended: 15,
        };
        let told = merged(&[few("S1", 3), few("S2", 3), Doubt::NothingCut, few("S3", 5)]);
        let text: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(text.len(), 2);
        assert!(
            text[0].starts_with("S1: strokes kept: 3")
                && text[0].ends_with("(likewise S2 and S3; 3 of this kind: kept 3 to 5)"),
            "{text:?}"
        );
        let guessed = |what: &str| Doubt::Guessed { what: what.into() };
        assert_eq!(merged(&[guessed("a"), guessed("b"), guessed("a")]).len(), 2);
        assert_eq!(
            merged(&[outside(0.3), outside(0.3)])[0].sentence(),
            outside(0.3).to_string()
        );
    }
}
