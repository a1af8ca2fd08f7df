//! Error messages for the text of a device description, in plain words and with an example.

/// How every entry is written.
const EXAMPLES: [(&str, &str); 14] = [
    (
        "largest_load",
        "slew = { largest_load = { peak_to_peak_v = 150, frequency_hz = 300, capacitance_f = 150e-9 } }",
    ),
    ("peak_to_peak_v", "peak_to_peak_v = 150"),
    ("frequency_hz", "frequency_hz = 300"),
    ("capacitance_f", "capacitance_f = 120e-9"),
    ("limit_v", "limit_v = 100"),
    ("slew", "slew = { current_a = 0.1 }"),
    ("coupling", "coupling = { high_pass_hz = 2 }"),
    ("divider", "divider = 0.5"),
    ("usual_gain", "usual_gain = \"x20\""),
    ("gains", "[[amplifier.gains]]"),
    ("gain", "gain = { ratio = 20 }"),
    ("amplifier", "[amplifier]"),
    ("actuator", "[actuator]"),
    ("name", "name = \"x20\""),
];

/// The sentence of the TOML reader in plain words.
pub(super) fn of(message: &str) -> String {
    let message = message.trim().replace('\n', ", ");
    if message.contains("exactly 1 element") {
        return match message.contains("more than 1") {
            true => "several entries where one belongs".into(),
            false => "no entry where one belongs".into(),
        };
    }
    if message.contains("wanted string or table") {
        return "a plain value where an entry in braces belongs".into();
    }
    if let Some((found, expected)) = message
        .strip_prefix("invalid type: ")
        .and_then(|rest| rest.split_once(", expected "))
    {
        let found = match found.split_once(' ') {
            Some(("string", text)) => format!("the text {text}"),
            Some(("integer" | "floating", _)) => found
                .replace("integer", "the number")
                .replace("floating point", "the number"),
            _ => format!("a {found}"),
        };
        let belongs = match expected {
            "f64" => "a number",
            "a string" => "a text",
            "a sequence" => "a list",
            other if other.starts_with("struct") || other.starts_with("a map") => {
                "a table of entries"
            }
            other => other,
        };
        return format!("{found} where {belongs} belongs");
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("no entry called {name}");
    }
    for (start, what) in [
        ("unknown field ", "an entry called "),
        ("unknown variant ", ""),
    ] {
        if let Some(rest) = message.strip_prefix(start) {
            return match rest.split_once(", expected ") {
                Some((name, known)) => {
                    let known = known.trim_start_matches("one of ").replace(" or ", ", ");
                    format!("{what}{name}, which is none of {known}")
                }
                None => format!("{what}{rest}"),
            };
        }
    }
    message
}

/// How the entry is written that the message names, or else the line in which it is wrong.
pub(super) fn example(message: &str, line: &str) -> Option<&'static str> {
    let of_name = |name: &str| {
        let mut examples = EXAMPLES.iter();
        examples
            .find(|(known, _)| *known == name)
            .map(|(_, example)| *example)
    };
    let missing = message.trim().strip_prefix("missing field `");
    let missing = missing.and_then(|rest| of_name(rest.trim_end_matches('`')));
    missing.or_else(|| of_name(line.split_once('=')?.0.trim()))
}
