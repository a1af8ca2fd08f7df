//! JSON, recordings and tables as rows of field path and value, and how rows are compared.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;

use flate2::read::GzDecoder;
use piezotact_dataset::{ReadOptions, read_recording};
use serde_json::{Value, json};

/// Field path and value: a number, a text, true, false, null, or what a long list is summed up as.
pub(crate) type Rows = BTreeMap<String, Value>;

/// Lists longer than this are summed up, with as many of their values at equal steps.
const KEPT: usize = 16;
/// Two values are the same up to here: sums in another order differ by about 1e-16 a step, in some 1e5 steps.
const RELATIVE: f64 = 1e-9;
/// Below this, a number is what rounding left of a difference.
const ROUNDING: f64 = 1e-16;
/// In a long list, also a value far below the others is what rounding left: as a share of their rms.
const ROUNDING_IN_LIST: f64 = 1e-12;
/// What stands for a sentence: only that there is one counts.
const SENTENCE: &str = "<sentence>";
/// Fields that tell the program's version or the day, not a result.
const LEFT_OUT: [&str; 7] = [
    "editor",
    "version",
    "created",
    "date",
    "made_on",
    "made_on_day",
    "measured_on",
];

/// The rows of a JSON value under `path`.
pub(crate) fn json_rows(rows: &mut Rows, path: &str, value: &Value) {
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                if name == "warnings" {
                    // How a warning is put may change; how many there are may not.
                    let count = field.as_array().map_or(1, Vec::len);
                    rows.insert(format!("{path}.warnings.length"), count.into());
                } else if !LEFT_OUT.contains(&name.as_str()) {
                    json_rows(rows, &format!("{path}.{name}"), field);
                }
            }
        }
        Value::Array(items) if items.len() > KEPT => long_rows(rows, path, items),
        Value::Array(items) => {
            rows.insert(format!("{path}.length"), items.len().into());
            for (index, item) in items.iter().enumerate() {
                json_rows(rows, &format!("{path}[{index}]"), item);
            }
        }
        Value::String(text) => {
            let kept = if text.matches(' ').count() >= 3 {
                SENTENCE
            } else {
                text.as_str()
            };
            rows.insert(path.into(), kept.into());
        }
        _ => {
            rows.insert(path.into(), value.clone());
        }
    }
}

/// A long list: of numbers as their sums, of anything else as one such list for each field of its items.
fn long_rows(rows: &mut Rows, path: &str, items: &[Value]) {
    rows.insert(format!("{path}.length"), items.len().into());
    let mut columns: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for item in items {
        let mut cells = Rows::new();
        json_rows(&mut cells, "", item);
        for (field, cell) in cells {
            columns.entry(field).or_default().push(cell);
        }
    }
    for (field, cells) in columns {
        let path = format!("{path}[*]{field}");
        // A line without a value is null: how many are not is the count.
        let known = cells.iter().filter(|cell| !cell.is_null());
        let numbers: Option<Vec<f64>> = known.map(Value::as_f64).collect();
        match numbers {
            Some(numbers) => _ = rows.insert(path, summed_up(&numbers)),
            None => {
                let step = cells.len().div_ceil(KEPT);
                let some: Vec<&Value> = cells.iter().step_by(step).collect();
                rows.insert(path, json!({ "count": cells.len(), "some": some }));
            }
        }
    }
}

fn summed_up(numbers: &[f64]) -> Value {
    let step = numbers.len().div_ceil(KEPT).max(1);
    let some: Vec<f64> = numbers.iter().copied().step_by(step).collect();
    let squares: f64 = numbers.iter().map(|v| v * v).sum();
    json!({
        "count": numbers.len(),
        "sum": numbers.iter().sum::<f64>(),
        "rms": (squares / numbers.len().max(1) as f64).sqrt(),
        "min": numbers.iter().copied().reduce(f64::min),
        "max": numbers.iter().copied().reduce(f64::max),
        "some": some,
    })
}

/// The rows of a file that a command wrote.
pub(crate) fn file_rows(rows: &mut Rows, file: &Path, name: &str, bytes: &[u8]) {
    let path = format!("file {name}");
    rows.insert(path.clone(), "written".into());
    match name.rsplit('.').next() {
        Some("json" | "hjif" | "haptic" | "ahap") => {
            json_rows(rows, &path, &serde_json::from_slice(bytes).unwrap());
        }
        Some("parquet" | "wav") => recording_rows(rows, &path, file),
        Some("csv") => table_rows(rows, &path, bytes, b',', Names::InFirstRow),
        Some("tsv") => table_rows(rows, &path, bytes, b'\t', Names::InFirstRow),
        // Signals of BIDS, whose columns are named elsewhere.
        Some("gz") => {
            let mut text = Vec::new();
            GzDecoder::new(bytes).read_to_end(&mut text).unwrap();
            table_rows(rows, &path, &text, b'\t', Names::Elsewhere);
        }
        Some("eeg" | "edf") => {
            rows.insert(format!("{path} bits"), fnv1a(bytes.iter().copied()).into());
        }
        // Pages, pictures and what the next command of the chain reads.
        _ => {}
    }
}

/// A recording: rate, and for each channel unit, sums, and a checksum of the bits of its samples.
fn recording_rows(rows: &mut Rows, path: &str, file: &Path) {
    let recording = read_recording(file, &ReadOptions::default())
        .unwrap()
        .recording;
    rows.insert(format!("{path} rate_hz"), recording.rate().hz().into());
    for channel in recording.channels() {
        let path = format!("{path} {}", channel.name);
        rows.insert(format!("{path} unit"), channel.unit.to_string().into());
        rows.insert(format!("{path} samples"), summed_up(&channel.samples));
        let bytes = channel
            .samples
            .iter()
            .flat_map(|v| v.to_bits().to_le_bytes());
        rows.insert(format!("{path} bits"), fnv1a(bytes).into());
    }
}

/// FNV-1a, 64 bits.
fn fnv1a(bytes: impl Iterator<Item = u8>) -> String {
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// Where the names of columns are.
#[derive(Clone, Copy, PartialEq)]
enum Names {
    InFirstRow,
    Elsewhere,
}

/// A table: each column as a list.
fn table_rows(rows: &mut Rows, path: &str, bytes: &[u8], separator: u8, names: Names) {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(names == Names::InFirstRow)
        .from_reader(bytes);
    let names: Vec<String> = match names {
        Names::InFirstRow => reader.headers().unwrap().iter().map(Into::into).collect(),
        Names::Elsewhere => Vec::new(),
    };
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let cell = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => number.into(),
        _ => Value::from(text),
    };
    for index in 0..records.first().map_or(names.len(), csv::StringRecord::len) {
        let name = names
            .get(index)
            .map_or_else(|| (index + 1).to_string(), Clone::clone);
        let cells: Vec<Value> = records.iter().map(|record| cell(&record[index])).collect();
        json_rows(rows, &format!("{path} {name}"), &cells.into());
    }
}

/// What samples may depend on in their last bit: the processor's instructions that the program chooses between.
pub(crate) fn machine() -> String {
    let mut name = String::from(std::env::consts::ARCH);
    #[cfg(target_arch = "x86_64")]
    for (known, there) in [
        (" avx2", std::arch::is_x86_feature_detected!("avx2")),
        (" fma", std::arch::is_x86_feature_detected!("fma")),
        (" avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ] {
        name.push_str(if there { known } else { "" });
    }
    name
}

/// A table as it is stored: one row a line, so that a change of a value is a change of a line.
pub(crate) fn table(machine: &str, commands: &BTreeMap<String, Rows>) -> String {
    let mut text = format!("{{\n\"machine\": {},\n\"commands\": {{", json!(machine));
    for (number, (command, rows)) in commands.iter().enumerate() {
        let comma = if number == 0 { "" } else { "," };
        write!(text, "{comma}\n{}: {{", json!(command)).unwrap();
        for (number, (path, value)) in rows.iter().enumerate() {
            let comma = if number == 0 { "" } else { "," };
            write!(text, "{comma}\n {}: {value}", json!(path)).unwrap();
        }
        text.push_str("\n}");
    }
    text.push_str("\n}\n}\n");
    text
}

/// The rows of one command of a stored table.
pub(crate) fn of_table(stored: &Value) -> Rows {
    let fields = stored.as_object().cloned().unwrap_or_default();
    fields.into_iter().collect()
}

/// Whether checksums of samples count.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Checksums {
    Compared,
    LeftOut,
}

/// One sentence for every stored row that is missing or has another value.
pub(crate) fn differences(
    stored: &Rows,
    found: &Rows,
    renamed: &[(&str, &str)],
    checksums: Checksums,
) -> Vec<String> {
    let mut wrong = Vec::new();
    for (path, expected) in stored {
        let now = now_called(path, renamed);
        let Some(value) = found.get(path).or_else(|| found.get(&now)) else {
            wrong.push(format!("{path} is missing, was {expected}"));
            continue;
        };
        if checksums == Checksums::LeftOut && is_checksum(expected) && is_checksum(value) {
            continue;
        }
        compare(&mut wrong, path, expected, value);
    }
    wrong
}

/// The sum of samples or of the values of a transfer function, of a drive as its sidecar states it, or of a file (SHA-256).
fn is_checksum(value: &Value) -> bool {
    let digits = |text: &str| {
        let sum = text.strip_prefix("fold64:").unwrap_or(text);
        matches!(sum.len(), 16 | 64) && sum.bytes().all(|b| b.is_ascii_hexdigit())
    };
    value.as_str().is_some_and(digits)
}

/// The path with every renamed run of its segments as it is called now.
fn now_called(path: &str, renamed: &[(&str, &str)]) -> String {
    let ends = |next: Option<char>| next.is_none_or(|c| matches!(c, '.' | '[' | ' '));
    let mut now = path.to_owned();
    for (old, new) in renamed {
        let place = now.match_indices(old).map(|(at, _)| at).find(|at| {
            ends(now[..*at].chars().next_back()) && ends(now[at + old.len()..].chars().next())
        });
        if let Some(at) = place {
            now.replace_range(at..at + old.len(), new);
        }
    }
    now
}

fn compare(wrong: &mut Vec<String>, path: &str, expected: &Value, found: &Value) {
    let number = |value: &Value, field: &str| value[field].as_f64().unwrap_or(0.0);
    match (expected, found) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            if !near(a, b, ROUNDING) {
                wrong.push(format!("{path}: was {a:?}, is {b:?}"));
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            let rms = number(expected, "rms");
            for (field, a) in a {
                let b = b.get(field).unwrap_or(&Value::Null);
                // What rounding may leave of a sum grows with the number of its terms.
                let terms = match field.as_str() {
                    "sum" => number(expected, "count"),
                    _ => 1.0,
                };
                let floor = ROUNDING.max(ROUNDING_IN_LIST * rms) * terms.max(1.0);
                let same = match (a, b) {
                    (Value::Array(a), Value::Array(b)) => {
                        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b, floor))
                    }
                    _ => alike(a, b, floor),
                };
                if !same {
                    wrong.push(format!("{path}, {field}: was {a}, is {b}"));
                }
            }
        }
        _ if expected == found => {}
        _ => wrong.push(format!("{path}: was {expected}, is {found}")),
    }
}

fn alike(a: &Value, b: &Value, floor: f64) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => near(a, b, floor),
        _ => a == b,
    }
}

fn near(a: f64, b: f64, floor: f64) -> bool {
    (a - b).abs() <= RELATIVE * a.abs().max(b.abs()) + floor
}
