//! Doubts in the JSON that commands print: each with all its keys, whatever they hold. Stored files leave out what is empty.

use piezotact::Doubt;
use piezotact::doubt::Advice;
use serde_json::{Map, Value, json};

use crate::advice;

/// The keys of a doubt, and those that several doubts as one have besides.
const KEYS: [&str; 9] = [
    "code", "about", "values", "seen", "advice", "text", "ranges", "of", "subjects",
];

/// Gives every doubt in `value` the keys `about` (or null), `values`, `seen`, `advice` and `text`, and every advice its
/// `code`, `values` and `text`. A doubt stands in a list called `doubts`, or in the values of a doubt.
pub(crate) fn complete(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            for (name, inner) in fields.iter_mut() {
                match inner {
                    Value::Array(doubts) if name.contains("doubt") => {
                        for doubt in doubts {
                            whole(doubt);
                        }
                    }
                    other => complete(other),
                }
            }
        }
        Value::Array(values) => values.iter_mut().for_each(complete),
        _ => {}
    }
}

/// Completes `value`, where it is a doubt; else what is in it.
fn whole(value: &mut Value) {
    let is_doubt = value.as_object().is_some_and(|fields| {
        fields.get("code").is_some_and(Value::is_string)
            && fields.keys().all(|key| KEYS.contains(&key.as_str()))
    });
    let stored = is_doubt.then(|| serde_json::from_value::<Doubt>(value.clone()));
    let (Some(Ok(doubt)), Value::Object(fields)) = (stored, &mut *value) else {
        return complete(value);
    };
    fields.entry("about").or_insert(Value::Null);
    fields.insert("seen".into(), json!(doubt.seen));
    let text = || json!(advice::text(&doubt));
    fields.entry("text").or_insert_with(text);
    let advice = doubt.advice.iter().map(advice_json).collect();
    fields.insert("advice".into(), Value::Array(advice));
    let values = fields.entry("values").or_insert_with(|| json!({}));
    for inner in values.as_object_mut().into_iter().flat_map(Map::values_mut) {
        match inner {
            Value::Array(several) => several.iter_mut().for_each(whole),
            one => whole(one),
        }
    }
}

/// `{code, values, text}`.
fn advice_json(advice: &Advice) -> Value {
    let (code, values) = match serde_json::to_value(advice) {
        Ok(Value::String(code)) => (code, Map::new()),
        Ok(Value::Object(fields)) => match fields.into_iter().next() {
            Some((code, Value::Object(values))) => (code, values),
            Some((code, what)) => (code, Map::from_iter([("what".to_owned(), what)])),
            None => (String::new(), Map::new()),
        },
        _ => (String::new(), Map::new()),
    };
    json!({ "code": code, "values": values, "text": advice::words(advice) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::recording::RecordingDoubt;
    use piezotact::stroke::StrokeDoubt;

    /// Python reads every doubt by the same keys, those within doubts and those without advice too.
    #[test]
    fn every_printed_doubt_has_all_its_keys() {
        let plain = Doubt::from(StrokeDoubt::SlidingAssumed);
        let scaled = Doubt::from(RecordingDoubt::Uncalibrated {
            channel: "acc".into(),
        });
        let rate = Doubt::from(RecordingDoubt::RateStated {
            stated_hz: 1.0,
            found_hz: 2.0,
        });
        let mut outer = json!(plain);
        outer["values"] = json!({ "example": scaled, "several": [rate] });
        let mut document = json!({ "part": { "doubts": [outer] }, "code": "no doubt" });
        complete(&mut document);
        assert_eq!(document["code"], "no doubt");
        let outer = &document["part"]["doubts"][0];
        let inner = [&outer["values"]["example"], &outer["values"]["several"][0]];
        for doubt in inner.into_iter().chain([outer]) {
            for key in ["code", "about", "values", "seen", "advice", "text"] {
                assert!(doubt.get(key).is_some(), "no {key} in {doubt}");
            }
            assert!(doubt["text"].as_str().is_some_and(|text| text.len() > 10));
        }
        assert_eq!(
            (&outer["about"], &outer["advice"]),
            (&Value::Null, &json!([]))
        );
        let advice = &inner[0]["advice"][0];
        assert_eq!(
            (&advice["code"], &advice["values"]),
            (&json!("state_scale"), &json!({}))
        );
        assert!(
            advice["text"]
                .as_str()
                .is_some_and(|text| text.contains("--scale"))
        );
        let advice = &inner[1]["advice"][0];
        assert_eq!(advice["values"], json!({ "what": "which_is_right" }));
        // What is whole stays as it is.
        let once = document.clone();
        complete(&mut document);
        assert_eq!(
            document["part"]["doubts"][0]["text"],
            once["part"]["doubts"][0]["text"]
        );
    }
}
