//! The numbers in messages have the digits that mean something: at most six, unless a file's own number is quoted.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(
    clippy::disallowed_methods,
    reason = "the declarations of warnings are read from the sources"
)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use piezotact::align::AlignWarning;
use piezotact::clipping::ClippingWarning;
use piezotact::compare::CompareWarning;
use piezotact::correct::{LoopWarning, MeasurementFaultWarning};
use piezotact::discrimination::DiscriminationWarning;
use piezotact::feature::FeatureWarning;
use piezotact::integrity::SignalWarning;
use piezotact::manipulate::ManipulateWarning;
use piezotact::noise::NoiseWarning;
use piezotact::panel::PanelWarning;
use piezotact::prepare::PrepareWarning;
use piezotact::recording::{RecordingWarning, RehearsalWarning};
use piezotact::render::RenderWarning;
use piezotact::resample::ResampleWarning;
use piezotact::run::RunWarning;
use piezotact::score::ScoreWarning;
use piezotact::sound::SoundWarning;
use piezotact::spectrum::SpectrumWarning;
use piezotact::stroke::{ForceWarning, StrokeWarning};
use piezotact::transfer::{ImpactWarning, TransferWarning};
use piezotact::verify::VerifyWarning;
use piezotact::warning::{FewWarning, ScatterWarning};
use serde::de::DeserializeOwned;
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

/// A variant of an enum of warnings as it is declared: its code, its fields with their types, and the tags of what is flattened.
#[derive(Clone)]
struct Declared {
    code: String,
    fields: BTreeMap<String, String>,
    tags: Vec<(String, String)>,
}

/// The end of the attribute, text or bracket that begins at `start`.
fn closing(source: &[char], start: usize) -> usize {
    let (mut depth, mut at) = (0, start);
    while at < source.len() {
        match source[at] {
            '"' => {
                at += 1;
                while source[at] != '"' {
                    at += if source[at] == '\\' { 2 } else { 1 };
                }
            }
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        at += 1;
        if depth == 0 {
            break;
        }
    }
    at
}

/// `source` cut at commas outside of brackets.
fn parts(source: &str) -> Vec<String> {
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for sign in source.chars() {
        match sign {
            '{' | '[' | '<' | '(' => depth += 1,
            '}' | ']' | '>' | ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().unwrap().push(sign);
    }
    let trimmed = parts.iter().map(|part| part.trim().to_owned());
    trimmed.filter(|part| !part.is_empty()).collect()
}

/// The name in lower case with underscores, as serde writes it.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    for sign in name.chars() {
        if sign.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(sign.to_lowercase());
    }
    snake
}

/// An enum as it is declared: the tag of its variants, its name, and its variants.
struct Tagged {
    tag: String,
    name: String,
    variants: Vec<Declared>,
}

/// The enums of `source` whose variants are written with a tag.
fn tagged(source: &str) -> Vec<Tagged> {
    let without_comments: Vec<&str> = source
        .lines()
        .filter(|line| !line.trim().starts_with("//"))
        .collect();
    let source = without_comments.join("\n");
    let mut all = Vec::new();
    for part in source.split("#[serde(tag = \"").skip(1) {
        let (tag, part) = part.split_once('"').unwrap();
        let Some((before, after)) = part.split_once("enum ") else {
            continue;
        };
        if before.contains("struct ") {
            continue;
        }
        let (name, body) = after.split_once(" {\n").unwrap();
        let signs: Vec<char> = format!("{{\n{body}").chars().collect();
        let body = &signs[1..closing(&signs, 0) - 1];
        all.push(Tagged {
            tag: tag.to_owned(),
            name: name.to_owned(),
            variants: variants(body),
        });
    }
    all
}

/// The variants of an enum with this body.
fn variants(body: &[char]) -> Vec<Declared> {
    let mut all = Vec::new();
    // Attributes go, but for the names in which a variant is written, and for what is flattened.
    let (mut plain, mut renamed, mut at) = (String::new(), Vec::new(), 0);
    while at < body.len() {
        if body[at] == '#' {
            let end = closing(body, at + 1);
            let attribute: String = body[at..end].iter().collect();
            if let Some(name) = attribute.strip_prefix("#[serde(rename = \"") {
                renamed.push((plain.len(), name.trim_end_matches("\")]").to_owned()));
            } else if attribute == "#[serde(flatten)]" {
                plain.push_str(FLATTENED);
            }
            at = end;
        } else {
            plain.push(body[at]);
            at += 1;
        }
    }
    let mut from = 0;
    for variant in parts(&plain) {
        let starts = from + plain[from..].find(&variant).unwrap();
        let (name, fields) = variant.split_once('{').unwrap_or((&variant, ""));
        let fields = parts(fields.trim().trim_end_matches('}'));
        let fields = fields.iter().filter_map(|field| {
            let (name, kind) = field.split_once(": ")?;
            Some((name.to_owned(), kind.trim().to_owned()))
        });
        let written = renamed.iter().find(|(at, _)| (from..=starts).contains(at));
        all.push(Declared {
            code: written.map_or_else(|| snake(name.trim()), |(_, name)| name.clone()),
            fields: fields.collect(),
            tags: Vec::new(),
        });
        from = starts + variant.len();
    }
    all
}

/// Stands before a field that is written flattened.
const FLATTENED: &str = "flattened ";

/// The warnings among `enums`: the variants of those that are tagged by `code`; one for each variant of an enum that is flattened into
/// one.
fn declared(enums: &[Tagged]) -> Vec<Declared> {
    let mut all = Vec::new();
    for warning in enums.iter().filter(|one| one.tag == "code") {
        for variant in &warning.variants {
            let flat = variant.fields.iter().find_map(|(name, kind)| {
                let is_flat = name.trim().starts_with(FLATTENED.trim());
                is_flat.then(|| (name.clone(), kind.clone()))
            });
            let Some((field, kind)) = flat else {
                all.push(variant.clone());
                continue;
            };
            let inner = enums.iter().find(|one| one.name == kind).unwrap();
            for cause in &inner.variants {
                let mut one = variant.clone();
                one.fields.remove(&field);
                one.fields.extend(cause.fields.clone());
                one.tags.push((inner.tag.clone(), cause.code.clone()));
                all.push(one);
            }
        }
    }
    all
}

/// The sentence of a warning of the enum `W`; `None` where `written` is none.
fn sentence<W: std::error::Error + DeserializeOwned>(written: &Value) -> Option<String> {
    let warning: W = serde_json::from_value(written.clone()).ok()?;
    Some(warning.to_string())
}

/// All enums of warnings of this crate.
const SENTENCES: [fn(&Value) -> Option<String>; 27] = [
    sentence::<AlignWarning>,
    sentence::<ClippingWarning>,
    sentence::<CompareWarning>,
    sentence::<DiscriminationWarning>,
    sentence::<FeatureWarning>,
    sentence::<FewWarning>,
    sentence::<ForceWarning>,
    sentence::<ImpactWarning>,
    sentence::<LoopWarning>,
    sentence::<ManipulateWarning>,
    sentence::<MeasurementFaultWarning>,
    sentence::<NoiseWarning>,
    sentence::<PanelWarning>,
    sentence::<PrepareWarning>,
    sentence::<RecordingWarning>,
    sentence::<RehearsalWarning>,
    sentence::<RenderWarning>,
    sentence::<ResampleWarning>,
    sentence::<RunWarning>,
    sentence::<ScatterWarning>,
    sentence::<ScoreWarning>,
    sentence::<SignalWarning>,
    sentence::<SoundWarning>,
    sentence::<SpectrumWarning>,
    sentence::<StrokeWarning>,
    sentence::<TransferWarning>,
    sentence::<VerifyWarning>,
];

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
        "Steps" => json!("time"),
        "String" => json!("name"),
        "Example" => json!({ "example": "name" }),
        "ChannelRole" => json!("motion"),
        "bool" => json!(true),
        "Counts" => json!({ "name": 2 }),
        "Band" => json!([number, 2.0 * number]),
        "Warning" => json!({ "code": "force_not_measured", "load_n": number, "text": "none" }),
        _ => return None,
    })
}

/// Times that are said in ms.
const TIMES_IN_MS: [&str; 5] = ["rms_s", "ci_half_width_s", "lead_s", "longest_s", "delay_s"];
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

/// The sentence of the warning with `number` in each of its fields; `None` where one is of a type that this test does not know.
fn said(declared: &Declared, number: f64) -> Option<String> {
    let mut written = json!({ "code": declared.code });
    for (tag, value) in &declared.tags {
        written[tag] = json!(value);
    }
    for (name, kind) in &declared.fields {
        written[name] = value(kind, number * usual(name))?;
    }
    SENTENCES.iter().find_map(|sentence| sentence(&written))
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
    let enums = files.iter();
    let enums = enums.flat_map(|file| tagged(&std::fs::read_to_string(file).unwrap()));
    for declared in declared(&enums.collect::<Vec<_>>()) {
        for number in [0.001_234_567_89, 0.123_456_789, 1.234_567_89, 123.456_789] {
            let Some(text) = self::said(&declared, number) else {
                unknown.push((declared.code.clone(), declared.tags.clone()));
                break;
            };
            said += 1;
            if !too_long(&text).is_empty() {
                long.push(text);
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
