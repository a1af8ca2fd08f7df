//! Documents held against their JSON Schemas in `docs/schemas/`: required fields, types, and constants.

use std::path::Path;

use serde_json::Value;

/// What in `document` differs from the schema that it names; empty where nothing does.
pub(crate) fn differences(document: &Value) -> Vec<String> {
    let Some(name) = document["schema"].as_str() else {
        return vec!["it names no schema".into()];
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
    let text = std::fs::read(folder.join(format!("{name}.json")));
    let root: Value = match text {
        Ok(text) => serde_json::from_slice(&text).unwrap(),
        Err(error) => return vec![format!("docs/schemas/{name}.json: {error}")],
    };
    against(&root, &root, document, name)
}

fn against(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let mut found = Vec::new();
    // What stands beside a reference holds too.
    if let Some(name) = schema["$ref"].as_str() {
        let target = name.trim_start_matches('#');
        let target = root.pointer(target).unwrap_or(&Value::Null);
        assert!(target.is_object() || target.is_boolean(), "no {name}");
        found.extend(against(root, target, value, at));
    }
    if let Some(expected) = schema.get("const").filter(|expected| *expected != value) {
        found.push(format!("{at}: expected {expected}, found {value}"));
    }
    if let Some(all) = schema["enum"].as_array().filter(|all| !all.contains(value)) {
        found.push(format!("{at}: expected one of {all:?}, found {value}"));
    }
    if !has_type(&schema["type"], value) {
        found.push(format!("{at}: expected {}, found {value}", schema["type"]));
    }
    for field in schema["required"].as_array().into_iter().flatten() {
        let field = field.as_str().unwrap();
        if value
            .as_object()
            .is_some_and(|fields| !fields.contains_key(field))
        {
            found.push(format!("{at}: lacks {field}"));
        }
    }
    for (field, inner) in schema["properties"].as_object().into_iter().flatten() {
        if let Some(own) = value.get(field) {
            found.extend(against(root, inner, own, &format!("{at}.{field}")));
        }
    }
    for one in value.as_array().into_iter().flatten() {
        if schema["items"].is_object() {
            found.extend(against(root, &schema["items"], one, &format!("{at}[]")));
        }
    }
    for part in schema["allOf"].as_array().into_iter().flatten() {
        found.extend(against(root, part, value, at));
    }
    for choices in ["anyOf", "oneOf"] {
        let Some(choices) = schema[choices].as_array() else {
            continue;
        };
        let tried = choices.iter().map(|one| against(root, one, value, at));
        let tried: Vec<Vec<String>> = tried.collect();
        if let (false, Some(closest)) = (
            tried.iter().any(Vec::is_empty),
            tried.iter().min_by_key(|all| all.len()),
        ) {
            found.extend(closest.iter().cloned());
        }
    }
    found
}

fn has_type(expected: &Value, value: &Value) -> bool {
    let is = |name: &Value| match name.as_str().unwrap_or_default() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "integer" => value.is_u64() || value.is_i64(),
        // JSON has no number that is infinite or none.
        "number" => value.is_number() || value.is_null(),
        other => panic!("a type called {other}"),
    };
    match expected {
        Value::Null => true,
        Value::Array(several) => several.iter().any(is),
        one => is(one),
    }
}
