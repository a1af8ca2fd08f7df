//! No decision looks into a warning: what it needs is a field of the result, and the warning is made from the field.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

use super::Findings;
use crate::source::Source;

/// The front end adds names of options by code (docs/decisions/house.md); conclusions are held against the truth with what was warned of.
const ALLOWED: [&str; 2] = [
    "crates/piezotact-app/src/advice.rs",
    "crates/piezotact-validation/src/program/conclusions/truth.rs",
];

/// Invariant 12: outside of the modules that define warnings, and of tests, none is compared or matched.
pub(super) fn check(sources: &[Source], findings: &mut Findings) {
    for source in sources {
        let place = source.path.display().to_string();
        let is_own = place.ends_with("warning.rs") || place.contains("/warning/");
        if is_own || ALLOWED.contains(&place.as_str()) {
            continue;
        }
        let mut found = Vec::new();
        walk(source.tokens.clone(), &mut found);
        found.retain(|(line, _)| !source.is_test(*line));
        for (line, what) in found {
            findings.add(format!(
                "{place}:{line}: `{what}` looks into a warning: keep what is found in a field, decide by it, and make the warning from it"
            ));
        }
    }
}

/// The places of `tokens` that look into a warning, with how.
fn walk(tokens: TokenStream, found: &mut Vec<(usize, String)>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (i, token) in tokens.iter().enumerate() {
        if let TokenTree::Group(group) = token {
            walk(group.stream(), found);
        }
        if let Some(what) = look(&tokens, i) {
            found.push((token.span().start().line, what));
        }
    }
}

/// What looks into a warning at the token `i`: a pattern with a variant of a `…Warning`, `kind` of one, or a comparison of its code.
fn look(tokens: &[TokenTree], i: usize) -> Option<String> {
    let name = ident(tokens, i)?;
    let is_field = i > 0 && is_punct(tokens, i - 1, '.');
    if name == "code" && is_field && is_punct(tokens, i + 1, '=') && is_punct(tokens, i + 2, '=') {
        return Some(".code ==".into());
    }
    let is_path = is_punct(tokens, i + 1, ':') && is_punct(tokens, i + 2, ':');
    if name == "kind" && is_field && is_path {
        let of = ident(tokens, i + 4).filter(|of| of.ends_with("Warning"))?;
        return Some(format!(".kind::<{of}>"));
    }
    if !name.ends_with("Warning") || !is_path {
        return None;
    }
    let variant = ident(tokens, i + 3)?;
    let what = format!("{name}::{variant}");
    if name == "Warning" {
        return (variant == "kind").then_some(what);
    }
    let (mut next, mut is_pattern) = (i + 4, false);
    if let Some(TokenTree::Group(group)) = tokens.get(next)
        && group.delimiter() != Delimiter::Bracket
    {
        let inside: Vec<TokenTree> = group.stream().into_iter().collect();
        let last = inside.len();
        is_pattern =
            last >= 2 && is_punct(&inside, last - 1, '.') && is_punct(&inside, last - 2, '.');
        next += 1;
    }
    if let Some(TokenTree::Punct(punct)) = tokens.get(next) {
        let is_pair = punct.spacing() == Spacing::Joint;
        is_pattern |= match punct.as_char() {
            '=' => !(is_pair && is_punct(tokens, next + 1, '=')),
            '|' => !is_pair,
            _ => false,
        };
    }
    is_pattern.then_some(what)
}

fn ident(tokens: &[TokenTree], i: usize) -> Option<String> {
    match tokens.get(i)? {
        TokenTree::Ident(ident) => Some(ident.to_string()),
        _ => None,
    }
}

fn is_punct(tokens: &[TokenTree], i: usize, sign: char) -> bool {
    matches!(tokens.get(i), Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let mut found = Vec::new();
        walk(text.parse().unwrap(), &mut found);
        found.into_iter().map(|(_, what)| what).collect()
    }

    #[test]
    fn patterns_on_warnings_are_found_and_warnings_that_are_made_are_not() {
        for (text, what) in [
            (
                "matches!(w.kind(), Some(RunWarning::Lost { .. }))",
                "RunWarning::Lost",
            ),
            ("if let RunWarning::Lost { n } = w {}", "RunWarning::Lost"),
            (
                "match w { RunWarning::Early => 1, _ => 2 }",
                "RunWarning::Early",
            ),
            (
                "match w { AWarning::A | AWarning::B(_) => 1 }",
                "AWarning::A",
            ),
            ("all.filter_map(Warning::kind)", "Warning::kind"),
            ("w.kind::<RunWarning>().is_some()", ".kind::<RunWarning>"),
            ("known.code == warning.code", ".code =="),
        ] {
            assert_eq!(
                found(text).first().map(String::as_str),
                Some(what),
                "{text}"
            );
        }
        for text in [
            "warnings.push(Warning::from(RunWarning::Lost { n, places: a.clone() }))",
            "match why { Why::Early => RunWarning::Early, Why::Lost(n) => RunWarning::Lost { n } }",
            "(n > 0).then_some(RunWarning::Early)",
            "let w = RunWarning::Lost { n: 3 }; w == RunWarning::Early || b",
            "error.kind() == ErrorKind::NotFound",
        ] {
            assert_eq!(found(text), Vec::<String>::new(), "{text}");
        }
    }
}
