//! Merges warnings that differ only in numbers or names into one with a range: twenty recordings with the same warning give one
//! entry.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Warning;

/// The number of names that are written out.
const NAMED: usize = 3;

/// The fields that name what a warning is about: warnings that differ in one of them are merged, and their names listed.
const SUBJECTS: [&str; 9] = [
    "channel",
    "file",
    "group",
    "measurement",
    "participant",
    "result",
    "sample",
    "signal",
    "texture",
];

/// Warnings of one kind. Its written form is that of the first warning, with `about`, `subjects` and `ranges` where there are any.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Merged {
    /// The first of them, with their number in `seen`.
    #[serde(flatten)]
    pub warning: Warning,
    /// The names of the recordings, files or groups that they are about, each once; empty where none was given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub about: Vec<String>,
    /// Their own subjects (groups, channels, measurements), each once; empty for one or none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub subjects: Vec<String>,
    /// The numbers in which they differ.
    #[serde(default, with = "ranges", skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(
        feature = "schemas",
        schemars(with = "std::collections::BTreeMap<String, [f64; 2]>")
    )]
    pub ranges: Vec<Range>,
}

/// Ranges as `{field: [low, high]}`.
mod ranges {
    use std::collections::BTreeMap;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Range;

    pub(super) fn serialize<S: Serializer>(all: &[Range], to: S) -> Result<S::Ok, S::Error> {
        let by_field = all
            .iter()
            .map(|range| (&range.field, [range.low, range.high]));
        by_field.collect::<BTreeMap<_, _>>().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Range>, D::Error> {
        let by_field = BTreeMap::<String, [f64; 2]>::deserialize(from)?;
        let ranges = by_field.into_iter();
        Ok(ranges
            .map(|(field, [low, high])| Range { field, low, high })
            .collect())
    }
}

/// Writes warnings as they stand in a document, those of one kind as one; for serde's `serialize_with`.
///
/// Source: docs/decisions/house.md.
///
/// # Errors
/// Those of the serializer.
pub fn serialize_merged<S: serde::Serializer>(
    warnings: &[Warning],
    to: S,
) -> Result<S::Ok, S::Error> {
    merged(warnings).serialize(to)
}

/// A number of several warnings from its lowest to its highest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The warnings' field, with its unit.
    pub field: String,
    pub low: f64,
    pub high: f64,
}

/// Merges the warnings of one kind in `warnings`. Two warnings are of one kind when they differ only in
/// numbers, in the parts of a band that they list, or in the name of their subject.
///
/// Source: docs/decisions/house.md.
#[must_use]
pub fn merged<'a>(warnings: impl IntoIterator<Item = &'a Warning>) -> Vec<Merged> {
    merged_of(warnings.into_iter().map(|warning| (None, warning)))
}

/// As [`merged`], for warnings given with the name of what each is about (a recording, file or group), if there is one.
///
/// Source: docs/decisions/house.md.
#[must_use]
pub fn merged_of<'a>(
    warnings: impl IntoIterator<Item = (Option<&'a str>, &'a Warning)>,
) -> Vec<Merged> {
    let mut kinds: Vec<(Kind<'a>, Merged)> = Vec::new();
    for (name, warning) in warnings {
        let kind = kind_of(warning);
        let place = kinds.iter().position(|(other, _)| *other == kind);
        let place = place.unwrap_or_else(|| {
            let first = Merged {
                warning: Warning {
                    seen: 0,
                    ..warning.clone()
                },
                about: Vec::new(),
                subjects: Vec::new(),
                ranges: Vec::new(),
            };
            kinds.push((kind, first));
            kinds.len() - 1
        });
        let one = &mut kinds[place].1;
        let seen = one.warning.seen + warning.seen;
        let subject = SUBJECTS
            .iter()
            .find_map(|name| warning.fields.get(*name)?.as_str());
        let is_worse = shortfall(warning) > shortfall(&one.warning);
        if is_worse {
            one.warning = warning.clone();
        }
        one.warning.seen = seen;
        for (new, known) in [(name, &mut one.about), (subject, &mut one.subjects)] {
            let new = new.map(str::to_owned);
            known.extend(new.filter(|new| !known.contains(new)));
        }
        if let (true, Some(subject)) = (is_worse, subject) {
            // The sentence is about this one; the others are listed after it.
            one.subjects.sort_by_key(|known| known != subject);
        }
        for (field, value) in &warning.fields {
            let Some(value) = value.as_f64() else {
                continue;
            };
            match one.ranges.iter_mut().find(|range| range.field == *field) {
                Some(range) => {
                    (range.low, range.high) = (range.low.min(value), range.high.max(value));
                }
                None => one.ranges.push(Range {
                    field: field.clone(),
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

/// By how much less was found than recommended; 0 for warnings about other things.
fn shortfall(warning: &Warning) -> f64 {
    let number = |name: &str| warning.fields.get(name).and_then(Value::as_f64);
    match (number("found"), number("recommended")) {
        (Some(found), Some(recommended)) => (recommended - found).max(0.0),
        _ => 0.0,
    }
}

/// `value` with three digits of its numbers: what differs by less is the same to a person.
fn coarse(value: &Value) -> Value {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(value) => Value::String(format!("{value:.2e}")),
            None => Value::Null,
        },
        Value::Array(parts) => parts.iter().map(coarse).collect(),
        Value::Object(fields) => {
            let fields = fields.iter();
            Value::Object(
                fields
                    .map(|(name, value)| (name.clone(), coarse(value)))
                    .collect(),
            )
        }
        other => other.clone(),
    }
}

/// The properties that must be equal for two warnings to be merged: the code, and the fields, `None` for one that may differ.
type Kind<'a> = (&'a str, Vec<(&'a str, Option<Value>)>);

fn kind_of(warning: &Warning) -> Kind<'_> {
    let fields = warning.fields.iter().map(|(name, value)| {
        let differs = match value {
            Value::Number(_) => true,
            Value::String(_) => SUBJECTS.contains(&name.as_str()),
            // The parts of a band, or of a recording.
            Value::Array(parts) => parts
                .iter()
                .all(|part| matches!(part, Value::Object(_) | Value::Array(_))),
            // An example, or counts, may differ; a band or a cause may not.
            Value::Object(fields) => {
                let is_band = fields.contains_key("low_hz");
                let counts = fields.values().all(Value::is_u64);
                let is_example = fields.len() == 1 && fields.contains_key("example");
                name == "example" || is_example || (counts && !is_band)
            }
            Value::Null | Value::Bool(_) => false,
        };
        let is_guess = warning.code == "guessed" && name == "what";
        let same = match value {
            Value::String(text) if is_guess => Value::String(without_numbers(text)),
            _ => coarse(value),
        };
        (name.as_str(), (!differs).then_some(same))
    });
    (&warning.code, fields.collect())
}

/// A sentence without its numbers, but for those in names in backticks.
fn without_numbers(text: &str) -> String {
    let mut is_name = false;
    let mut left = String::with_capacity(text.len());
    for sign in text.chars() {
        is_name ^= sign == '`';
        match sign {
            '0'..='9' | '.' | '-' | '−' if !is_name => {}
            _ => left.push(sign),
        }
    }
    left
}

impl Merged {
    /// The text of the merged warning; `words` gives the sentence of the first warning.
    #[must_use]
    pub fn text_with(&self, words: &dyn Fn(&Warning) -> String) -> String {
        match self.about.as_slice() {
            [] => self.sentence(words),
            about => format!("{}: {}", listed(about), self.sentence(words)),
        }
    }

    /// The same, about all `all` of the recordings (or of `called`, in the plural) where it is about more than three and all of them.
    #[must_use]
    pub fn of_all(mut self, (all, called): (usize, &str)) -> Self {
        if all > NAMED && self.about.len() == all {
            self.about = vec![format!("all {all} {called}")];
        }
        self
    }

    fn sentence(&self, words: &dyn Fn(&Warning) -> String) -> String {
        let more = [self.likewise(), self.numbers()];
        let more: Vec<String> = more.into_iter().flatten().collect();
        let sentence = words(&self.warning);
        if more.is_empty() {
            return sentence;
        }
        format!("{sentence} ({})", more.join("; "))
    }

    fn likewise(&self) -> Option<String> {
        let others = self.subjects.get(1..)?;
        Some(format!("likewise {}", listed(others)))
    }

    fn numbers(&self) -> Option<String> {
        if self.ranges.is_empty() {
            let is_uncounted = self.about.is_empty() && self.warning.code == "guessed";
            return (is_uncounted && self.warning.seen > 1)
                .then(|| format!("{} of this kind", self.warning.seen));
        }
        let ranges: Vec<String> = self.ranges.iter().map(ToString::to_string).collect();
        Some(format!(
            "{} of this kind: {}",
            self.warning.seen,
            ranges.join(", ")
        ))
    }
}

impl fmt::Display for Merged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text_with(&Warning::to_string))
    }
}

/// The first names, and the number of the others.
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

/// The suffixes of field names, and the units they stand for.
const UNITS: [(&str, &str); 15] = [
    ("_db_rms", "dB rms"),
    ("_v_per_s", "V/s"),
    ("_per_s", "1/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_hz", "Hz"),
    ("_db", "dB"),
    ("_ppm", "ppm"),
    ("_deg", "°"),
    ("_um", "µm"),
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

/// A number with three significant digits.
fn digits(value: f64) -> String {
    let before = if value == 0.0 {
        0.0
    } else {
        value.abs().log10().floor()
    };
    if !(-4.0..6.0).contains(&before) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let text = format!("{value:.*}", (2.0 - before).max(0.0) as usize).replace('-', "−");
    match text.split_once('.') {
        Some(_) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Band, Hertz};
    use crate::recording::{MissingChannel, RecordingWarning};
    use crate::render::RenderWarning;
    use crate::stroke::{ForceFault, ForceWarning};
    use crate::warning::{Few, FewWarning};

    fn outside(share: f64) -> Warning {
        let band = Band::new(Hertz(20.0), Hertz(500.0)).unwrap();
        Warning::from(RenderWarning::PowerOutsideBand { share, band })
    }

    /// Fifty warnings that differ in a number are one with its range, about all fifty files.
    #[test]
    fn warnings_that_differ_in_a_number_are_one_with_its_range() {
        let files: Vec<String> = (0..50).map(|k| format!("text{k}.vav")).collect();
        let warnings: Vec<Warning> = (0..50)
            .map(|k| outside(0.2 + 0.01 * f64::from(k)))
            .collect();
        let told = merged_of(files.iter().map(|file| Some(file.as_str())).zip(&warnings));
        assert_eq!(
            (told.len(), told[0].warning.seen, told[0].about.len()),
            (1, 50, 50)
        );
        let text = told[0].clone().of_all((50, "recordings")).to_string();
        assert!(
            text.starts_with("all 50 recordings: 20 % of the texture's power"),
            "{text}"
        );
        assert!(
            text.ends_with("(50 of this kind: share 20 to 69 %)"),
            "{text}"
        );
        // Another band is another warning.
        let band = Band::new(Hertz(20.0), Hertz(900.0)).unwrap();
        let other = [
            outside(0.2),
            Warning::from(RenderWarning::PowerOutsideBand { share: 0.2, band }),
        ];
        assert_eq!(merged(&other).len(), 2);
        // A band that differs in its fifth digit is the same.
        let band = Band::new(Hertz(20.0), Hertz(500.04)).unwrap();
        let same = [
            outside(0.2),
            Warning::from(RenderWarning::PowerOutsideBand { share: 0.2, band }),
        ];
        assert_eq!(merged(&same).len(), 1);
    }

    /// 36 tables with repeated time stamps gave 21 sentences that differed in a number.
    #[test]
    fn guesses_that_differ_in_a_number_are_one() {
        let guess = |what: String| Warning::from(RecordingWarning::Guessed { what });
        let each: Vec<Warning> = (2..23)
            .map(|k| guess(format!("{k} rows repeat (the first at {k}.5)")))
            .collect();
        let one = merged(&each);
        assert_eq!((one.len(), one[0].warning.seen), (1, 21));
        assert!(
            one[0].to_string().ends_with("(21 of this kind)"),
            "{}",
            one[0]
        );
        let named = [
            guess("`C1` is left out".into()),
            guess("`C2` is left out".into()),
        ];
        assert_eq!(merged(&named).len(), 2);
    }

    /// Every file is counted, whatever else gives a warning of it: of 20 files with two warnings each, both are about all 20.
    #[test]
    fn every_file_is_counted_whatever_else_is_reported_of_it() {
        let names: Vec<String> = (0..20).map(|k| format!("{k}.vav")).collect();
        let both = [
            outside(0.3),
            Warning::from(ForceWarning::Doubtful {
                fault: ForceFault::ZeroUnknown,
            }),
        ];
        let all = names
            .iter()
            .flat_map(|name| both.iter().map(move |d| (Some(name.as_str()), d)));
        for one in merged_of(all) {
            assert_eq!(one.about.len(), 20);
            assert!(
                one.clone()
                    .of_all((20, "recordings"))
                    .to_string()
                    .starts_with("all 20 recordings: ")
            );
            assert!(one.to_string().starts_with("0.vav, 1.vav and 18 more: "));
        }
        let two = names[..2]
            .iter()
            .map(|name| (Some(name.as_str()), &both[1]));
        let text = merged_of(two)[0]
            .clone()
            .of_all((20, "recordings"))
            .to_string();
        assert!(
            text.starts_with("0.vav and 1.vav: the finger never leaves"),
            "{text}"
        );
    }

    #[test]
    fn what_a_warning_names_is_listed() {
        let few = |what: &str, kept| {
            Warning::from(FewWarning::Few {
                found: kept,
                recommended: 15,
                what: Few::Strokes { group: what.into() },
            })
        };
        let told = merged(&[
            few("S1", 3),
            few("S2", 3),
            Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::Cutting,
            }),
            few("S3", 5),
        ]);
        let text: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(text.len(), 2);
        assert!(
            text[0].starts_with("S1: only 3 strokes, 15 or more are recommended")
                && text[0].ends_with("(likewise S2 and S3; 3 of this kind: found 3 to 5)"),
            "{text:?}"
        );
        // The sentence is that of the worst, and what it is about stands first.
        let worst = merged(&[few("S1", 3), few("S2", 1), few("S3", 2)]);
        let text = worst[0].to_string();
        assert!(
            text.starts_with("S2: only 1 stroke, 15 or more are recommended")
                && text.ends_with("(likewise S1 and S3; 3 of this kind: found 1 to 3)"),
            "{text}"
        );
        let guessed = |what: &str| Warning::from(RecordingWarning::Guessed { what: what.into() });
        assert_eq!(merged(&[guessed("a"), guessed("b"), guessed("a")]).len(), 2);
        assert_eq!(
            merged(&[outside(0.3), outside(0.3)])[0].to_string(),
            outside(0.3).to_string()
        );
    }
}
