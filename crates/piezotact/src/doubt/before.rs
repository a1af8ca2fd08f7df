//! Reads doubts in the format of version 0.1.0: `{"doubt": "force_not_measured", "load_n": 0.3}`.

use serde_json::{Map, Value as Json};

use super::{About, Doubt, Example, FieldValue, SubjectField, Value};
use crate::quantity::{Band, Hertz};

/// The field that names what a doubt is about, by the doubt's name.
fn subject(code: &str) -> Option<SubjectField> {
    Some(match code {
        "uncalibrated"
        | "coarse_quantisation"
        | "dead_channel"
        | "sign_reversed"
        | "frozen"
        | "drop_outs"
        | "mains_hum"
        | "copied"
        | "drive_beyond_limit"
        | "response_dead"
        | "clipped_transfer" => ("channel", About::Channel),
        "clipped" | "not_felt" | "rate_converted" => ("what", About::Signal),
        "interrupted_later" => ("journal", About::File),
        "cuts_not_applied" => ("file", About::File),
        "few_strokes" => ("what", About::Group),
        "scattered" | "pooled" => ("group", About::Group),
        "no_interval" => ("what", About::Result),
        "odd_one_out" => ("participant", About::Participant),
        "mixed_repeats" => ("of", About::Participant),
        "opposite_sign" | "other_participant" => ("measurement", About::Measurement),
        _ => return None,
    })
}

/// Fields that were an example, by the doubt's name.
const EXAMPLES: [(&str, &str); 4] = [
    ("odd_one_out", "at"),
    ("opposite_sign", "such_as"),
    ("other_participant", "found"),
    ("rejected", "reasons"),
];
/// Fields added during the development of version 0.1.0, with the value used when they are absent.
const ADDED: [(&str, &str); 5] = [
    ("impossible_coherence", "lines"),
    ("late_response", "reach_s"),
    ("acausal", "reach_s"),
    ("unrelated", "limit"),
    ("unrelated", "averages"),
];
/// Fields that hold a band or a list of bands.
const BANDS: [&str; 5] = ["bands", "judged", "band", "band_hz", "answers_hz"];

/// The doubt that `fields` hold; `None` without a name.
pub(super) fn doubt(mut fields: Map<String, Json>) -> Option<Doubt> {
    let Some(Json::String(mut code)) = fields.remove("doubt") else {
        return None;
    };
    if let Some(coherence) = fields.remove("median_coherence") {
        fields.insert("coherence".into(), coherence);
    }
    for (_, field) in ADDED.iter().filter(|(of, _)| *of == code) {
        fields.entry(*field).or_insert(0.into());
    }
    // Only the wording distinguished where clipping happened.
    if let ("clipped", Some(what)) = (code.as_str(), fields.get("what").and_then(Json::as_str)) {
        if what == "the drive that was played" {
            code = "played_drive_clipped".into();
            fields.remove("what");
        } else if let Some(limit) = what
            .strip_prefix("the drive (")
            .and_then(|rest| rest.strip_suffix(')'))
        {
            let limit = limit.to_owned();
            code = "drive_clipped".into();
            fields.remove("what");
            fields.insert("limited_by".into(), limit.into());
        }
    }
    let about = subject(&code).and_then(|(field, about)| match fields.remove(field)? {
        Json::String(name) => Some(about(name)),
        _ => None,
    });
    let values = fields
        .into_iter()
        .map(|(name, value)| {
            let value = Value::from(value);
            let value = match value {
                list @ Value::List(_) if BANDS.contains(&name.as_str()) => bands(list),
                Value::Text(text) if EXAMPLES.contains(&(code.as_str(), name.as_str())) => {
                    Value::Example(text)
                }
                // A sentence that was generated when the file was written.
                Value::Text(text) if code == "of_members" => noted(text),
                other => other,
            };
            (name, value)
        })
        .collect();
    Some(Doubt {
        code: code.into(),
        about,
        values,
        seen: 1,
        advice: Vec::new(),
    })
}

/// Two numbers as a band, and lists of two numbers as bands.
fn bands(value: Value) -> Value {
    let pair: Option<[f64; 2]> = FieldValue::from_value(Some(&value));
    if let Some([low, high]) = pair
        && let Ok(band) = Band::new(Hertz(low), Hertz(high))
    {
        return Value::Band(band);
    }
    match value {
        Value::List(values) => Value::List(values.into_iter().map(bands).collect()),
        other => other,
    }
}

/// A doubt known only as a sentence.
fn noted(text: String) -> Value {
    let fields = [("text", Example(text).into_value())];
    Value::Doubt(Box::new(Doubt::of_fields(
        "noted",
        fields,
        None,
        Vec::new(),
    )))
}
