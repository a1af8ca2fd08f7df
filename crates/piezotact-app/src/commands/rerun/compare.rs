//! Results of two runs of one command, compared value by value.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::document::INVOCATION;
use piezotact::invocation::{Difference, Invocation};
use serde_json::Value;

use crate::arguments::OUTPUTS;
use crate::made::Results;

/// What a comparison found.
#[derive(Debug, Default)]
pub(super) struct Compared {
    /// How many values there are.
    pub(super) compared: usize,
    pub(super) differences: Vec<Difference>,
}

impl Compared {
    pub(super) fn one(&mut self, place: &str, before: Option<String>, now: Option<String>) {
        self.compared += 1;
        if before != now {
            self.differences.push(Difference {
                place: place.to_owned(),
                before,
                now,
            });
        }
    }
}

impl Compared {
    /// What `stated` says of the settings and of the files that were read, against what the command `did`. Outputs are elsewhere,
    /// and what a file holds is said of the inputs.
    pub(super) fn invocations(&mut self, stated: &Invocation, did: &Invocation) {
        let settings = |of: &Invocation| -> BTreeMap<String, String> {
            let own = of.settings.iter();
            let own = own.filter(|setting| !OUTPUTS.contains(&setting.name.as_str()));
            own.map(|setting| (setting.name.clone(), setting.values.join(" ")))
                .collect()
        };
        let (before, now) = (settings(stated), settings(did));
        let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
        for name in names {
            let [before, now] = [&before, &now].map(|all| all.get(name).cloned());
            self.unless_equal(&format!("{INVOCATION}: setting {name}"), before, now);
        }
        let paths = |of: &Invocation| -> BTreeSet<String> {
            of.inputs.iter().map(|input| input.path.clone()).collect()
        };
        let (before, now) = (paths(stated), paths(did));
        for path in before.symmetric_difference(&now) {
            let word = |all: &BTreeSet<String>| all.contains(path).then(|| "read".to_owned());
            self.unless_equal(&format!("{INVOCATION}: {path}"), word(&before), word(&now));
        }
    }

    /// Counts a value only where it differs: what is not a result.
    fn unless_equal(&mut self, place: &str, before: Option<String>, now: Option<String>) {
        if before != now {
            self.one(place, before, now);
        }
    }
}

/// Every value of `before` against that of `now`.
pub(super) fn compared(before: &Results, now: &Results) -> Compared {
    let mut found = Compared::default();
    match (before, now) {
        (Results::Document(before), Results::Document(now)) => {
            fields("", Some(before), Some(now), &mut found);
        }
        (Results::Report(before), Results::Report(now)) => reports(before, now, &mut found),
        _ => found.one("kind", Some("report".into()), Some("document".into())),
    }
    found
}

/// The values of documents by their path.
fn fields(path: &str, before: Option<&Value>, now: Option<&Value>, found: &mut Compared) {
    let below = |key: &str| match path {
        "" => key.to_owned(),
        path => format!("{path}.{key}"),
    };
    let objects = [before, now].map(|value| value.and_then(Value::as_object));
    let arrays = [before, now].map(|value| value.and_then(Value::as_array));
    let keys: BTreeSet<&String> = (objects.iter().flatten())
        .flat_map(|object| object.keys())
        .collect();
    let length = arrays.iter().flatten().map(|array| array.len()).max();
    for key in &keys {
        let [before, now] = objects.map(|object| object.and_then(|object| object.get(*key)));
        fields(&below(key), before, now, found);
    }
    for i in 0..length.unwrap_or(0) {
        let [before, now] = arrays.map(|array| array.and_then(|array| array.get(i)));
        fields(&below(&i.to_string()), before, now, found);
    }
    // What is neither, what is empty, and what was one and is the other.
    let kinds = [before, now].map(|value| value.map(std::mem::discriminant));
    if kinds[0] != kinds[1] || (keys.is_empty() && length.unwrap_or(0) == 0) {
        let [before, now] = [before, now].map(|value| value.map(short));
        found.one(path, before, now);
    }
}

/// A value as text; of one that holds others, what it is.
fn short(value: &Value) -> String {
    match value {
        Value::Object(fields) if !fields.is_empty() => format!("{} fields", fields.len()),
        Value::Array(several) if !several.is_empty() => format!("{} elements", several.len()),
        value => value.to_string(),
    }
}

/// A piece of a report: where it stands, and what it shows.
type Piece = (String, String);

/// The texts and figures of reports, in order.
fn reports(before: &str, now: &str, found: &mut Compared) {
    let (before, now) = (pieces(before), pieces(now));
    for i in 0..before.len().max(now.len()) {
        let (old, new) = (before.get(i), now.get(i));
        let place = old
            .or(new)
            .map(|(place, _)| place.clone())
            .unwrap_or_default();
        let shown = |piece: Option<&Piece>| piece.map(|(_, text)| text.clone());
        let (old, new) = (shown(old), shown(new));
        if old != new
            && [&old, &new]
                .into_iter()
                .flatten()
                .any(|text| text.starts_with("<svg"))
        {
            // A drawing is too long to be shown.
            let word = |text: Option<String>| text.map(|_drawing| "a drawing".to_owned());
            let now = word(new).map(|word| format!("another {}", &word[2..]));
            found.one(&place, word(old), now);
        } else {
            found.one(&place, old, new);
        }
    }
}

/// The pieces of a report: its texts between tags, with the heading above them, and its drawings whole.
fn pieces(html: &str) -> Vec<Piece> {
    let (mut pieces, mut heading, mut figures) = (Vec::new(), String::from("title"), 0);
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        let text = rest[..at].trim();
        rest = &rest[at..];
        if !text.is_empty() {
            pieces.push((heading.clone(), text.to_owned()));
        }
        // The end is looked for behind a beginning alone: each search goes through all that follows.
        if rest.starts_with("<svg")
            && let Some(end) = rest.find("</svg>")
        {
            figures += 1;
            let (svg, after) = rest.split_at(end + "</svg>".len());
            pieces.push((format!("{heading}, figure {figures}"), svg.to_owned()));
            rest = after;
            continue;
        }
        let Some(end) = rest.find('>') else { break };
        let (tag, after) = rest.split_at(end + 1);
        if ["<h1", "<h2", "<h3"]
            .iter()
            .any(|begin| tag.starts_with(begin))
        {
            let until = after.find('<').unwrap_or(after.len());
            heading = after[..until].trim().to_owned();
        }
        // What a tag says itself: the width of a bar, a link.
        if tag.contains('=') {
            pieces.push((heading.clone(), tag.to_owned()));
        }
        rest = after;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn differences(before: Results, now: Results) -> Vec<[String; 3]> {
        let found = compared(&before, &now);
        let differences = found.differences.into_iter().map(|one| {
            let shown = |value: Option<String>| value.unwrap_or_else(|| "–".into());
            [one.place, shown(one.before), shown(one.now)]
        });
        differences.collect()
    }

    #[test]
    fn fields_that_differ_are_named_by_their_path() {
        let before =
            json!({ "level_db": 1.5, "strokes": [{ "rms": 1.0 }, { "rms": 2.0 }], "gone": null });
        let now =
            json!({ "level_db": 1.5, "strokes": [{ "rms": 1.0 }, { "rms": 2.5 }, { "rms": 3.0 }] });
        let found = differences(Results::Document(before.clone()), Results::Document(now));
        let expected = [
            ["gone", "null", "–"],
            ["strokes.1.rms", "2.0", "2.5"],
            ["strokes.2.rms", "–", "3.0"],
            ["strokes.2", "–", "1 fields"],
        ];
        assert_eq!(found, expected.map(|row| row.map(String::from)));
        let same = compared(
            &Results::Document(before.clone()),
            &Results::Document(before),
        );
        assert_eq!((same.compared, same.differences.len()), (4, 0));
    }

    #[test]
    fn texts_and_drawings_that_differ_are_named_by_their_heading() {
        let report = |level: &str, point: &str| {
            Results::Report(format!(
                "<h1>Score</h1><section><h2>Level</h2><p>{level}</p><svg><path d=\"{point}\"/></svg></section>"
            ))
        };
        let found = differences(report("1.5 dB", "M1"), report("1.6 dB", "M2"));
        let expected = [
            ["Level", "1.5 dB", "1.6 dB"],
            ["Level, figure 1", "a drawing", "another drawing"],
        ];
        assert_eq!(found, expected.map(|row| row.map(String::from)));
        assert!(differences(report("1", "M1"), report("1", "M1")).is_empty());
    }
}
