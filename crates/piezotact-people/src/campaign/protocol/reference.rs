//! What a protocol can state, from the JSON Schema of its types (`docs/schemas/protocol.json`): one table for people and for the errors of the reader.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde_json::Value;
use toml::Value as Toml;

/// The schema of the types of this module; the reader of TOML decides, this says what it takes.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../../../../docs/schemas/protocol.json"))
        .unwrap_or_default()
});
/// What the file of a protocol has as JSON beside what is stated in TOML.
const OF_JSON: [&str; 3] = ["schema", "version", "invocation"];

/// A value with its fields, and those of the variant that its tag chooses.
type Fields = BTreeMap<&'static str, &'static Value>;

/// The schema behind references, and beside "or nothing".
fn resolved(schema: &'static Value) -> &'static Value {
    let to = schema["$ref"].as_str().and_then(|to| to.strip_prefix('#'));
    match (to.and_then(|to| SCHEMA.pointer(to)), &schema["anyOf"][0]) {
        (Some(found), _) => resolved(found),
        (None, Value::Null) => schema,
        (None, first) => resolved(first),
    }
}

fn list(of: &'static Value) -> &'static [Value] {
    of.as_array().map_or(&[], Vec::as_slice)
}

fn fields(schema: &'static Value) -> Fields {
    let all = schema["properties"].as_object().into_iter().flatten();
    all.filter(|(name, _)| !OF_JSON.contains(&name.as_str()))
        .map(|(name, field)| (name.as_str(), field))
        .collect()
}

/// The field whose value chooses a variant, with that value: `kind`, `touch`.
fn tag(variant: &'static Value) -> Option<(&'static str, &'static str)> {
    let mut all = fields(variant).into_iter();
    all.find_map(|(name, field)| Some((name, field["const"].as_str()?)))
}

/// Whether a value must have the field; what is false, empty or absent by default need not stand.
fn is_required(schema: &'static Value, name: &str) -> bool {
    let listed = list(&schema["required"]).iter().any(|one| one == name);
    listed && schema["properties"][name]["type"] != "boolean"
}

/// The type in words, with its values where they are listed.
fn type_of(schema: &'static Value) -> String {
    let schema = resolved(schema);
    let of_type = match &schema["type"] {
        Value::Array(types) => types.first().and_then(Value::as_str),
        one => one.as_str(),
    };
    let variants = list(&schema["oneOf"]);
    match of_type {
        _ if !variants.is_empty() && schema["properties"].is_null() => {
            let each = variants.iter().map(|one| match one["const"].as_str() {
                Some(value) => format!("\"{value}\""),
                None => match tag(one) {
                    Some((name, value)) => format!("{{ {name} = \"{value}\", … }}"),
                    None => {
                        let inner = fields(one).into_iter();
                        let inner = inner.map(|(name, of)| format!("{name} = {}", type_of(of)));
                        format!("{{ {} }}", inner.collect::<Vec<_>>().join(", "))
                    }
                },
            });
            format!("one of {}", each.collect::<Vec<_>>().join(", "))
        }
        Some("string") => "text".to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("number") => "number".to_owned(),
        Some("integer") if schema["minimum"] == 0 => "whole number from 0".to_owned(),
        Some("integer") => "whole number".to_owned(),
        Some("array") => match schema["maxItems"].as_u64() {
            Some(count) => format!("list of {count}: {}", type_of(&schema["items"])),
            None => format!("list: {}", type_of(&schema["items"])),
        },
        _ => "table".to_owned(),
    }
}

/// The first sentences of a description, in one line.
fn meaning(schema: &'static Value) -> String {
    let own = schema["description"].as_str();
    let own = own.or_else(|| resolved(schema)["description"].as_str());
    own.unwrap_or_default().replace('\n', " ")
}

/// All tables of a protocol with their fields: type, allowed values, default, meaning with the unit. A field without a default must be stated.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn reference() -> String {
    let mut text = String::from(
        "A protocol is a file of TOML. Each field stands with its type; `required` where it must be stated, else with its default.\n",
    );
    explain(&SCHEMA, "the beginning of the file", "", &mut text);
    text
}

/// The table `schema` at `path`, under `heading`, then those in it.
fn explain(schema: &'static Value, heading: &str, path: &str, text: &mut String) {
    if !fields(schema).is_empty() {
        *text += &format!("\n{heading}: {}\n", meaning(schema));
        own_fields(schema, None, text);
    }
    inner(schema, path, text);
    for variant in list(&schema["oneOf"]) {
        let Some((name, value)) = tag(variant) else {
            continue;
        };
        *text += &format!(
            "\n{heading} with {name} = \"{value}\": {}\n",
            meaning(variant)
        );
        own_fields(variant, Some(name), text);
        inner(variant, path, text);
    }
}

fn own_fields(schema: &'static Value, but: Option<&str>, text: &mut String) {
    for (name, field) in fields(schema) {
        if Some(name) == but {
            continue;
        }
        let of = resolved(field);
        let default = match of["type"].as_str() {
            _ if is_required(schema, name) => "required",
            Some("boolean") => "default false",
            Some("array") => "default []",
            _ => "default: absent",
        };
        *text += &format!(
            "  {name} ({}; {default}): {}\n",
            type_of(field),
            meaning(field)
        );
        let variants = list(&of["oneOf"]).iter().chain(list(&of["items"]["oneOf"]));
        for value in variants.filter(|value| value["const"].is_string()) {
            *text += &format!("    {}: {}\n", value["const"], meaning(value));
        }
    }
}

/// The tables in `schema`, each once with its place.
fn inner(schema: &'static Value, path: &str, text: &mut String) {
    for (name, field) in fields(schema) {
        let (of, place) = (resolved(field), format!("{path}{name}"));
        let (of, heading, place) = match (of["type"].as_str(), &of["additionalProperties"]) {
            (Some("array"), _) => {
                let items = resolved(&of["items"]);
                (items, format!("[[{place}]]"), place)
            }
            (_, Value::Object(_)) => {
                let each = resolved(&of["additionalProperties"]);
                (each, format!("[{place}.NAME]"), format!("{place}.NAME"))
            }
            _ => (of, format!("[{place}]"), place),
        };
        let has_variants = list(&of["oneOf"]).iter().any(|one| tag(one).is_some());
        if has_variants || !fields(of).is_empty() {
            explain(of, &heading, &format!("{place}."), text);
        }
    }
}

/// Where a file that was refused does not have the fields and types of a protocol.
pub(super) struct Misfit {
    /// The name of the field, to be searched in the file, and what is wrong.
    pub(super) field: String,
    pub(super) why: String,
}

/// The first place in `file` that no protocol has.
pub(super) fn misfit(file: &Toml) -> Option<Misfit> {
    differs(&SCHEMA, file, "the protocol", "")
}

/// A value in one line.
fn shown(value: &Toml) -> String {
    match value {
        Toml::Table(_) => "a table".to_owned(),
        Toml::Array(_) => "a list".to_owned(),
        Toml::String(text) => format!("{text:?}"),
        other => other.to_string(),
    }
}

fn differs(schema: &'static Value, found: &Toml, place: &str, field: &str) -> Option<Misfit> {
    let schema = resolved(schema);
    let wrong = || {
        let why = format!(
            "{place}: expected {}, found {}",
            type_of(schema),
            shown(found)
        );
        Some(Misfit {
            field: field.to_owned(),
            why,
        })
    };
    let variants = list(&schema["oneOf"]);
    match found {
        Toml::Table(table) => {
            if let each @ Value::Object(_) = &schema["additionalProperties"] {
                let mut all = table.iter();
                let of = |name: &str| format!("{place}.{name}");
                return all.find_map(|(name, value)| differs(each, value, &of(name), name));
            }
            let chosen = |variant: &&'static Value| match tag(variant) {
                Some((name, value)) => table.get(name).and_then(Toml::as_str) == Some(value),
                None => fields(variant).keys().any(|name| table.contains_key(*name)),
            };
            let variant = variants.iter().find(chosen);
            let tagged = variants.iter().find_map(tag).map(|(name, _)| name);
            let mut known = fields(schema);
            match (variant, tagged) {
                (Some(variant), _) => known.extend(fields(variant)),
                (None, Some(tag)) => {
                    let values = variants.iter().filter_map(|one| Some(self::tag(one)?.1));
                    let values: Vec<&str> = values.collect();
                    let values = values.join("`, `");
                    return Some(match table.get(tag) {
                        None => Misfit {
                            field: field.to_owned(),
                            why: format!(
                                "missing field `{tag}` of {place}; it is one of `{values}`"
                            ),
                        },
                        Some(other) => Misfit {
                            field: tag.to_owned(),
                            why: format!(
                                "{place}: expected `{tag}` to be one of `{values}`, found {}",
                                shown(other)
                            ),
                        },
                    });
                }
                (None, None) if !variants.is_empty() || known.is_empty() => return wrong(),
                (None, None) => {}
            }
            let names: Vec<&str> = known.keys().copied().collect();
            if let Some(stray) = table.keys().find(|name| !known.contains_key(name.as_str())) {
                let names = names.join("`, `");
                return Some(Misfit {
                    field: stray.clone(),
                    why: format!("unknown field `{stray}` of {place}, expected one of `{names}`"),
                });
            }
            let of = |name: &str| {
                is_required(schema, name) || variant.is_some_and(|of| is_required(of, name))
            };
            if let Some(missing) = names
                .iter()
                .find(|name| of(name) && !table.contains_key(**name))
            {
                let why = format!(
                    "missing field `{missing}` of {place}: {}",
                    meaning(known[missing]).trim_end_matches('.')
                );
                return Some(Misfit {
                    field: field.to_owned(),
                    why,
                });
            }
            let called = |name: &str| match place {
                "the protocol" => name.to_owned(),
                _ => format!("{place}.{name}"),
            };
            let mut all = table.iter();
            all.find_map(|(name, value)| differs(known[name.as_str()], value, &called(name), name))
        }
        Toml::Array(all) if schema["type"] == "array" => {
            let each = |(i, one): (usize, &Toml)| {
                let name = one.get("name").and_then(Toml::as_str);
                let name = name.map_or_else(|| (i + 1).to_string(), str::to_owned);
                differs(&schema["items"], one, &format!("{place} {name}"), field)
            };
            all.iter().enumerate().find_map(each)
        }
        found => {
            let is = match found {
                _ if !variants.is_empty() => variants
                    .iter()
                    .any(|one| one["const"].as_str() == found.as_str() && one["const"].is_string()),
                _ => type_of(schema)
                    .split(' ')
                    .next()
                    .is_some_and(|of| match found {
                        Toml::String(_) => of == "text",
                        Toml::Boolean(_) => of == "true",
                        Toml::Float(_) => of == "number",
                        Toml::Integer(found) => {
                            of == "number"
                                || of == "whole" && (*found >= 0 || schema["minimum"] != 0)
                        }
                        _ => false,
                    }),
            };
            if is { None } else { wrong() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LIBRARY, Protocol};
    use super::*;

    /// Every table of `file` by itself: what `change` makes of it, in the whole file.
    fn each_table(file: &Toml, change: &dyn Fn(&mut toml::Table) -> Vec<toml::Table>) -> Vec<Toml> {
        let mut made = Vec::new();
        match file {
            Toml::Table(table) => {
                made.extend(change(&mut table.clone()).into_iter().map(Toml::Table));
                for (name, value) in table {
                    for inner in each_table(value, change) {
                        let mut whole = table.clone();
                        whole.insert(name.clone(), inner);
                        made.push(Toml::Table(whole));
                    }
                }
            }
            Toml::Array(all) => {
                for (i, one) in all.iter().enumerate().take(2) {
                    for inner in each_table(one, change) {
                        let mut whole = all.clone();
                        whole[i] = inner;
                        made.push(Toml::Array(whole));
                    }
                }
            }
            _ => {}
        }
        made
    }

    fn reads(file: &Toml) -> Result<(), String> {
        let read: Result<Protocol, _> = file.clone().try_into();
        read.map(|_| ()).map_err(|error| error.to_string())
    }

    /// Where the reader of TOML and the table disagree, one of them lists a field that the other does not have.
    #[test]
    fn the_table_has_the_fields_that_the_reader_takes() {
        for (name, toml) in LIBRARY {
            let file: Toml = toml.parse::<toml::Table>().map(Toml::Table).unwrap();
            assert!(misfit(&file).is_none(), "{name}");
            // A field that nobody has is refused by both, and the reader lists no field that the table does not list.
            let strays = each_table(&file, &|table| {
                table.insert("zzz".into(), Toml::Integer(1));
                vec![table.clone()]
            });
            assert!(strays.len() > 20);
            for stray in strays {
                let Err(said) = reads(&stray) else { continue };
                let why = misfit(&stray)
                    .unwrap_or_else(|| panic!("{name}: {said}"))
                    .why;
                let said = said.lines().next().unwrap_or_default();
                let listed = said.split_once("expected").map_or("", |(_, after)| after);
                for field in listed.split('`').skip(1).step_by(2) {
                    assert!(why.contains(&format!("`{field}`")), "{field}: {why}");
                }
            }
            // Fields without a default are those without which the reader refuses.
            let without = each_table(&file, &|table| {
                let less = |name: &String| {
                    let mut less = table.clone();
                    less.remove(name);
                    less
                };
                table.keys().map(less).collect()
            });
            for less in without {
                let found = misfit(&less).map(|one| one.why);
                assert_eq!(
                    reads(&less).is_err(),
                    found.is_some(),
                    "{name}: {:?} {found:?}",
                    reads(&less)
                );
            }
        }
    }

    #[test]
    fn every_table_stands_in_the_reference() {
        let text = reference();
        for part in [
            "  form (whole number from 0; required): The version of the form: 1.",
            "  stimuli (list: table; default []): Rendered stimuli",
            "[[tasks]] with kind = \"touch\"",
            "[tasks.method.rule.staircase]",
            "[[sessions.blocks]]",
            "[tasks.in_language.NAME]",
            "    \"proximal\": Towards the body",
            "  feedback (true or false; default false)",
            "{ shares_of_sets = list: list: text }",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(!text.contains("invocation"));
    }
}
