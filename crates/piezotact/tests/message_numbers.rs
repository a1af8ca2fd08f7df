//! The numbers in messages have the digits that mean something: at most six, unless a file's own number is quoted.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(
    clippy::disallowed_methods,
    reason = "the declarations of warnings are read from the sources"
)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::wording::finding;
use serde_json::{Value, json};

const MOST_DIGITS: usize = 6;

/// The numbers of `text` with more digits that count than [`MOST_DIGITS`].
fn too_long(text: &str) -> Vec<String> {
    let is_part = |sign: char| sign.is_ascii_alphanumeric() || sign == '.';
    let text = text.replace("e-", "e");
    let words = text.split(|sign: char| !is_part(sign));
    let words = words.map(|word| word.trim_matches('.'));
    let numbers = words.filter(|word| word.parse::<f64>().is_ok());
    let numbers = numbers.filter(|number| {
        let mantissa = number.split('e').next().unwrap_or_default();
        let digits = mantissa.replace('.', "");
        let digits = digits.trim_start_matches('0');
        let digits = match mantissa.contains('.') {
            true => digits,
            false => digits.trim_end_matches('0'),
        };
        digits.len() > MOST_DIGITS
    });
    numbers.map(str::to_owned).collect()
}

/// All files of warnings below `folder`.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// A kind of warning as it is declared: its code, what it is about, and its fields with their types.
struct Declared {
    code: String,
    about: Option<(String, String)>,
    fields: BTreeMap<String, String>,
}

/// The warnings that are declared in `source`.
fn declared(source: &str) -> Vec<Declared> {
    let mut all: Vec<Declared> = Vec::new();
    let mut inside = false;
    for line in source.lines() {
        let text = line.trim();
        match text {
            "warnings! {" => inside = true,
            _ if line == "}" => inside = false,
            _ => {}
        }
        if !inside || text.starts_with("//") {
            continue;
        }
        if let Some((_, rest)) = text.split_once("(\"")
            && let Some((code, rest)) = rest.split_once("\")")
        {
            let about = rest.trim().strip_prefix("of ").and_then(|of| {
                let (kind, field) = of.split_once('(')?;
                let (field, _) = field.split_once(')')?;
                Some((kind.to_lowercase(), field.to_owned()))
            });
            all.push(Declared {
                code: code.to_owned(),
                about,
                fields: BTreeMap::new(),
            });
        } else if let (Some((name, kind)), Some(last)) = (text.split_once(": "), all.last_mut()) {
            let kind = kind.trim_end_matches(',').to_owned();
            last.fields.insert(name.to_owned(), kind);
        }
    }
    all
}

/// A value of a field of the type `kind`, with `number` where there is one.
fn value(kind: &str, number: f64) -> Option<Value> {
    let inner = |outer: &str| kind.strip_prefix(outer)?.strip_suffix('>');
    if let Some(inner) = inner("Option<") {
        return value(inner, number);
    }
    if let Some(inner) = inner("Vec<") {
        return Some(json!([value(inner, number)?]));
    }
    Some(match kind {
        "f64" => json!(number),
        "[f64; 2]" => json!([number, number]),
        "usize" | "u64" | "u32" => json!(3),
        "String" => json!("name"),
        "Example" => json!({ "example": "name" }),
        "Counts" => json!({ "counts": { "name": 2 } }),
        "Band" => json!({ "low_hz": number, "high_hz": 2.0 * number }),
        "Warning" => json!({ "code": "force_not_measured", "values": { "load_n": number } }),
        _ => return None,
    })
}

/// Times that are said in ms.
const TIMES_IN_MS: [&str; 5] = ["rms_s", "reach_s", "lead_s", "longest_s", "delay_s"];
/// Rates of files, which are quoted.
const OWN_RATES: [&str; 6] = [
    "stated_hz",
    "found_hz",
    "target_hz",
    "transfer_hz",
    "from_hz",
    "to_hz",
];

/// How large a value of this name usually is.
fn usual(name: &str) -> f64 {
    match name {
        _ if name.ends_with("_m") => 1e-6,
        _ if name.contains("share") || name.contains("fraction") => 1e-2,
        _ if name.ends_with("_m_s") || TIMES_IN_MS.contains(&name) => 1e-3,
        // A file's own number is quoted as it is.
        _ if OWN_RATES.contains(&name) => 0.0,
        _ => 1.0,
    }
}

/// The warning with `number` in each of its fields; `None` where one is of a type that this test does not know.
fn warning(declared: &Declared, number: f64) -> Option<Warning> {
    let mut written = json!({ "code": declared.code, "values": {} });
    for (name, kind) in &declared.fields {
        match &declared.about {
            Some((about, field)) if field == name => {
                written["about"] = json!({ about.as_str(): "name" });
            }
            _ => written["values"][name] = value(kind, number * usual(name))?,
        }
    }
    serde_json::from_value(written).ok()
}

/// Every kind of warning, with numbers that have many digits.
#[test]
fn warnings_have_the_digits_that_mean_something() {
    let mut files = Vec::new();
    sources(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
        &mut files,
    );
    let (mut said, mut unknown, mut long) = (0, Vec::new(), Vec::new());
    for file in files {
        for declared in declared(&std::fs::read_to_string(file).unwrap()) {
            for number in [0.001_234_567_89, 0.123_456_789, 1.234_567_89, 123.456_789] {
                let text = warning(&declared, number).map(|warning| finding(&warning));
                let of_a_kind = text.filter(|text| !text.contains("of another version"));
                let Some(text) = of_a_kind else {
                    unknown.push(declared.code.clone());
                    break;
                };
                said += 1;
                if !too_long(&text).is_empty() {
                    long.push(text);
                }
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
    assert!(said > 600 && unknown.len() < 20, "{said} {unknown:?}");
}

#[test]
fn long_numbers_are_found() {
    let text =
        "12.345678 % of 1200000 samples at 0.00123456 s, 1.2345678e-9, S8.wav, 4800000 and 4800001";
    assert_eq!(too_long(text), ["12.345678", "1.2345678e9", "4800001"]);
}
