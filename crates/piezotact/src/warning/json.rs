//! The JSON format of a warning: `{code, about, values, seen, advice}`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value as Json};

use super::{About, Advice, Value, Warning};

/// The written form.
#[derive(Serialize, Deserialize)]
struct Written<'a> {
    code: Cow<'a, str>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    about: Option<Cow<'a, About>>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    values: BTreeMap<Cow<'a, str>, Json>,
    #[serde(default = "once", skip_serializing_if = "is_once")]
    seen: usize,
    #[serde(default, skip_serializing_if = "no_advice")]
    advice: Cow<'a, [Advice]>,
}

fn once() -> usize {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands a reference")]
fn is_once(seen: &usize) -> bool {
    *seen == 1
}

#[expect(clippy::ptr_arg, reason = "serde hands the field")]
fn no_advice(advice: &Cow<'_, [Advice]>) -> bool {
    advice.is_empty()
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let values = self.values.iter();
        Written {
            code: Cow::Borrowed(&self.code),
            about: self.about.as_ref().map(Cow::Borrowed),
            values: values
                .map(|(name, value)| (Cow::Borrowed(name.as_str()), value.clone().into()))
                .collect(),
            seen: self.seen,
            advice: Cow::Borrowed(&self.advice),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Warning {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let fields = Map::deserialize(deserializer)?;
        if let (Some(Json::String(_)), None) = (fields.get("warning"), fields.get("code")) {
            return Err(D::Error::custom(
                "a warning in the form of an earlier version; make the file again with this version",
            ));
        }
        let written = Written::deserialize(Json::Object(fields)).map_err(D::Error::custom)?;
        let values = written.values.into_iter();
        Ok(Self {
            code: written.code.into_owned().into(),
            about: written.about.map(Cow::into_owned),
            values: values
                .map(|(name, value)| (name.into_owned(), Value::from(value)))
                .collect(),
            seen: written.seen,
            advice: written.advice.into_owned(),
        })
    }
}
