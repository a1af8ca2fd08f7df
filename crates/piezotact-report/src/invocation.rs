//! How a report was made, as the last section of every report, for a person and for a program.

use maud::{Markup, PreEscaped, html};
use piezotact::invocation::{Found, Input, Invocation, Setting};

/// What the section stands before.
const MAIN_ENDS: &str = "</main>";
/// What the section begins with; nothing else in a report does.
const BEGIN: &str = "<section id=\"invocation\">";
/// What its part for programs begins and ends with.
const SCRIPT: [&str; 2] = [
    "<script type=\"application/json\" id=\"invocation-data\">",
    "</script>",
];

/// What gives every figure of a file a button that saves it. A page that is served has none: no script of a report runs there.
const SAVE: &str = concat!("<script>", include_str!("save.js"), "</script>");

/// The report `html` as a file: with a last section that says how it was made, and with what saves its figures; `again` says in
/// words how it is made again.
///
/// # Errors
/// Those of serialising `invocation`.
pub fn with_invocation(
    html: &str,
    invocation: &Invocation,
    again: &str,
) -> Result<String, serde_json::Error> {
    let section = section(invocation, again)?.into_string();
    let end = html.rfind(MAIN_ENDS).unwrap_or(html.len());
    let after = html[end..].strip_prefix(MAIN_ENDS).unwrap_or_default();
    Ok([&html[..end], &section, MAIN_ENDS, SAVE, after].concat())
}

/// A report in its two parts: the results alone, and how it was made; `None` for a file that does not say.
#[must_use]
pub fn split(html: &str) -> Option<(String, Invocation)> {
    let begin = html.rfind(BEGIN)?;
    let (_, rest) = html[begin..].split_once(SCRIPT[0])?;
    let (data, rest) = rest.split_once(SCRIPT[1])?;
    let (_, after) = rest.split_once("</section>")?;
    let invocation = serde_json::from_str(data).ok()?;
    let after = after.replacen(SAVE, "", 1);
    Some(([&html[..begin], &after].concat(), invocation))
}

/// Whether the section of the report `html` that says how it was made is the one that this program writes for `invocation`: a
/// person reads the section, and a program what is stored beside it.
#[must_use]
pub fn is_as_written(html: &str, invocation: &Invocation) -> bool {
    // What stands in place of the words that name the file.
    const NAMED: &str = "{file}";
    let Ok(written) = section(invocation, NAMED) else {
        return false;
    };
    let Some((begin, end)) = written.0.split_once(NAMED) else {
        return false;
    };
    let found = html.rfind(BEGIN).map(|at| &html[at..]);
    let named = found.and_then(|found| found.strip_prefix(begin));
    let rest = named.and_then(|named| named.find("</p>").map(|at| &named[at..]));
    rest.is_some_and(|rest| rest.starts_with(end))
}

fn section(invocation: &Invocation, again: &str) -> Result<Markup, serde_json::Error> {
    let (given, defaults): (Vec<&Setting>, Vec<&Setting>) = invocation
        .settings
        .iter()
        .partition(|setting| setting.given);
    let read: Vec<&Input> = (invocation.inputs.iter())
        .filter(|input| input.found != Found::Nothing)
        .collect();
    // Its name without its version.
    let program = invocation.program.split(' ').next().unwrap_or_default();
    // No text ends the script.
    let data = serde_json::to_string(invocation)?.replace('<', "\\u003c");
    let script = [SCRIPT[0], &data, SCRIPT[1]].concat();
    let section = html! {
        h2 { "How this report was made" }
        p { code.command { @for word in words(program, &invocation.command) { span { (word) } " " } } }
        p.soft { (invocation.program) ", " (invocation.date) ". " (again) }
        @if !read.is_empty() {
            div.wide { table {
                tr { th { "file that was read" } th.n { "bytes" } th { "SHA-256" } }
                @for input in read { (input_row(input)) }
            } }
        }
        details {
            summary { "All settings" }
            div.wide { table {
                tr { th { "setting" } th { "value" } th { "origin" } }
                @for setting in given { (setting_row(setting, "given")) }
                @for setting in defaults { (setting_row(setting, "default")) }
            } }
        }
        (PreEscaped(script))
    };
    Ok(html! { (PreEscaped(BEGIN)) (section) (PreEscaped("</section>")) })
}

fn input_row(input: &Input) -> Markup {
    let (bytes, sum) = match &input.found {
        Found::File { bytes, sha256 } => (bytes.to_string(), sha256.as_str()),
        Found::Changed => ("–".into(), "changed while it was read"),
        Found::Nothing => ("–".into(), "no file"),
    };
    html! { tr { td.text { (input.path) } td.n { (bytes) } td.text { code.sum { (sum) } } } }
}

fn setting_row(setting: &Setting, origin: &str) -> Markup {
    html! { tr { td { (setting.name) } td.text { (setting.values.join(", ")) } td { (origin) } } }
}

/// The command as a person types it in a shell.
#[must_use]
pub fn command_line(command: &[String]) -> String {
    line_of("piezotact", command)
}

/// A command of `program` as a person types it in a shell.
#[must_use]
pub fn line_of(program: &str, command: &[String]) -> String {
    words(program, command).join(" ")
}

/// The words of a command of `program` as a person types them, the program first.
fn words(program: &str, command: &[String]) -> Vec<String> {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,+@%".contains(c);
    let word = |word: &String| match word.chars().all(plain) && !word.is_empty() {
        true => word.clone(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    let program = std::iter::once(program.to_owned());
    program.chain(command.iter().map(word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::invocation::Output;

    fn invocation(argument: &str) -> Invocation {
        Invocation {
            command: vec!["score".into(), argument.into()],
            program: "piezotact 0.1.0".into(),
            date: "2026-11-22T18:00:00Z".into(),
            folder: "/study".into(),
            settings: vec![Setting {
                name: "band".into(),
                values: vec!["20..1000".into()],
                given: false,
            }],
            inputs: vec![Input {
                path: argument.into(),
                found: Found::Changed,
            }],
            output: Some(Output {
                setting: "report".into(),
                below: None,
            }),
            results_sha256: String::new(),
        }
    }

    /// Whatever a file is called: its name neither ends the part for programs nor becomes part of the page.
    #[test]
    fn a_report_is_split_into_what_was_put_together() {
        let results = "<html><main><section>1.5 dB</section></main></html>";
        for argument in [
            "S4.wav",
            "</script></section></main><b>.wav",
            "<section id=\"invocation\">",
            "it's \"S4\" & S8\\.wav",
        ] {
            let invocation = invocation(argument);
            let whole = with_invocation(results, &invocation, "Again.").unwrap();
            assert_eq!(whole.matches("</main>").count(), 1, "{argument}");
            assert!(!whole.contains("<b>"), "{argument}");
            let (found, again) = split(&whole).unwrap();
            assert_eq!((found.as_str(), again), (results, invocation), "{argument}");
        }
        assert_eq!(split(results), None);
    }

    #[test]
    fn a_command_is_shown_as_it_is_typed() {
        let command = ["score", "a b.wav", "it's", "--scale=2 m/s2"].map(String::from);
        assert_eq!(
            command_line(&command),
            "piezotact score 'a b.wav' 'it'\\''s' '--scale=2 m/s2'"
        );
    }
}
