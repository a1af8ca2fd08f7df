//! The science names no command-line option: the app adds its options to the advice of warnings and errors.

use std::path::{Path, PathBuf};

use anyhow::Result;
use proc_macro2::{TokenStream, TokenTree};

use super::layers::is_test;
use super::{Findings, SCIENCES, rust_files};
use crate::source::item_end;

/// Invariant 12: no string of the science names an option.
pub(super) fn check(root: &Path, findings: &mut Findings) -> Result<()> {
    for science in SCIENCES {
        for file in rust_files(&root.join(science))? {
            let text = std::fs::read_to_string(&file)?;
            let place = file.strip_prefix(root).map(PathBuf::from)?;
            for (line, option) in options(&text)? {
                findings.add(format!(
                    "{}:{line}: a string names the option {option}: say what to do in words, and name the option in the table of the app",
                    place.display()
                ));
            }
        }
    }
    Ok(())
}

/// The options that strings of `text` name, with their lines. Comments and tests do not count.
fn options(text: &str) -> Result<Vec<(usize, String)>> {
    let tokens: TokenStream = text
        .parse()
        .map_err(|error| anyhow::anyhow!("not Rust: {error}"))?;
    let mut found = Vec::new();
    walk(tokens, &mut found);
    Ok(found)
}

fn walk(tokens: TokenStream, found: &mut Vec<(usize, String)>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut i = 0;
    while let Some(token) = tokens.get(i) {
        if is_test(&tokens[i..]) {
            i = item_end(&tokens, i + 2);
            continue;
        }
        // What documentation says is an attribute: `#[doc = "…"]`, or `#![doc = "…"]` of what it stands in.
        let is = |at: usize, sign: char| matches!(tokens.get(at), Some(TokenTree::Punct(p)) if p.as_char() == sign);
        if is(i, '#') {
            let at = i + 1 + usize::from(is(i + 1, '!'));
            if matches!(tokens.get(at), Some(TokenTree::Group(group)) if is_doc(group)) {
                i = at + 1;
                continue;
            }
        }
        match token {
            TokenTree::Group(group) => walk(group.stream(), found),
            TokenTree::Literal(literal) => {
                let text = literal.to_string();
                let option = option_in(&text);
                found.extend(option.map(|option| (literal.span().start().line, option)));
            }
            _ => {}
        }
        i += 1;
    }
}

fn is_doc(group: &proc_macro2::Group) -> bool {
    let first = group.stream().into_iter().next();
    matches!(first, Some(TokenTree::Ident(word)) if word == "doc")
}

/// The first option that a string literal names: two dashes behind no word, and a letter.
fn option_in(literal: &str) -> Option<String> {
    if !literal.contains('"') {
        return None;
    }
    literal.match_indices("--").find_map(|(at, _)| {
        let before = literal[..at].chars().next_back();
        let starts = before.is_none_or(|c| !c.is_alphanumeric() && c != '-');
        let name: String = literal[at + 2..]
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '-')
            .collect();
        let named = name.starts_with(|c: char| c.is_ascii_lowercase());
        (starts && named).then(|| format!("--{name}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_in_a_string_is_found_and_nowhere_else() {
        let text = "//! Try `--scale`.\n/// Or --rate.\n#[error(\"give --rate\")]\nfn f() { g(\"(--cuts)\"); h(\"a -- b, x--y\"); }\n\
            macro_rules! m { () => { \"--by-hand\" } }\n#[cfg(test)]\nmod tests { const X: &str = \"--load\"; }";
        let found = options(text).unwrap();
        assert_eq!(
            found,
            [
                (3, "--rate".to_owned()),
                (4, "--cuts".to_owned()),
                (5, "--by-hand".to_owned())
            ]
        );
    }
}
