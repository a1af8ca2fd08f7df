//! The Rust source of the project: its files by crate and module, and which of their lines are test code.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// Where crates stand.
const FOLDERS: [&str; 2] = ["crates", "py"];

/// A source file.
#[derive(Debug)]
pub(crate) struct Source {
    /// The folder of its crate: `piezotact-app`.
    pub(crate) package: String,
    /// The modules that lead to it: `commands`, `demo`; none for the root of a crate.
    pub(crate) module: Vec<String>,
    /// From the root of the project: `crates/piezotact-app/src/commands/demo.rs`.
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    pub(crate) tokens: TokenStream,
    /// The lines of its test code.
    tests: Vec<RangeInclusive<usize>>,
    /// Whether it is compiled with a feature of its crate alone.
    pub(crate) is_optional: bool,
}

impl Source {
    /// Whether a line of it, counted from 1, is test code: below `tests/`, or in an item under `#[cfg(test)]`.
    pub(crate) fn is_test(&self, line: usize) -> bool {
        self.tests.iter().any(|lines| lines.contains(&line))
    }

    /// Whether all of it is test code.
    pub(crate) fn is_all_test(&self) -> bool {
        self.is_test(0)
    }
}

/// The folder of the project.
pub(crate) fn root() -> Result<PathBuf> {
    Ok(Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()?)
}

/// All sources of the project in `root`.
pub(crate) fn read(root: &Path) -> Result<Vec<Source>> {
    let mut texts = BTreeMap::new();
    for folder in FOLDERS.map(|folder| root.join(folder)) {
        if !folder.is_dir() {
            continue;
        }
        for file in rust_files(&folder)? {
            let text = std::fs::read_to_string(&file)?;
            texts.insert(file.strip_prefix(root)?.to_path_buf(), text);
        }
    }
    sources(texts)
}

/// The Rust files below `folder`, but for what was compiled.
pub(crate) fn rust_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() && !path.ends_with("target") {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(files)
}

/// The sources of the files `texts`, by their path from the root of the project.
pub(crate) fn sources(texts: BTreeMap<PathBuf, String>) -> Result<Vec<Source>> {
    let mut sources = Vec::new();
    let mut test_modules = Vec::new();
    let mut optional = Vec::new();
    for (path, text) in texts {
        let tokens: TokenStream = text
            .parse()
            .map_err(|error| anyhow!("{}: {error}", path.display()))?;
        let mut tests = Tests::default();
        tests.walk(tokens.clone());
        let below = modules_below(&path);
        let file_of = |(name, file): (String, Option<String>)| match file {
            Some(file) => path.with_file_name(file).with_extension(""),
            None => below.join(name),
        };
        test_modules.extend(tests.modules.into_iter().map(file_of));
        optional.extend(tests.optional.into_iter().map(file_of));
        let (package, module) = place(&path);
        sources.push(Source {
            package,
            module,
            path,
            text,
            tokens,
            tests: tests.lines,
            is_optional: false,
        });
    }
    for source in &mut sources {
        let in_tests = source.path.components().any(|c| c.as_os_str() == "tests");
        let bare = source.path.with_extension("");
        source.is_optional = optional.iter().any(|module| bare.starts_with(module));
        if in_tests || test_modules.iter().any(|module| bare.starts_with(module)) {
            source.tests = vec![0..=usize::MAX];
        }
    }
    Ok(sources)
}

/// The folder of the modules that the file `path` declares.
pub(crate) fn modules_below(path: &Path) -> PathBuf {
    let is_folder = ["lib.rs", "main.rs", "mod.rs"]
        .iter()
        .any(|name| path.ends_with(name));
    match is_folder {
        true => path.with_file_name(""),
        false => path.with_extension(""),
    }
}

/// The crate and the modules of the file `path`; the tests beside `src` are in a module `tests`.
fn place(path: &Path) -> (String, Vec<String>) {
    let names: Vec<String> = path
        .with_extension("")
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    let at = names
        .iter()
        .position(|name| name == "src" || name == "tests");
    let at = at.unwrap_or(2).max(1);
    let mut module = names[at..].to_vec();
    module.retain(|name| !["src", "lib", "main", "mod"].contains(&name.as_str()));
    (names[at - 1].clone(), module)
}

/// The test code of a file.
#[derive(Default)]
struct Tests {
    lines: Vec<RangeInclusive<usize>>,
    /// Test modules in files of their own: name, and `#[path]`.
    modules: Vec<(String, Option<String>)>,
    /// Modules in files of their own that a feature of the crate turns on.
    optional: Vec<(String, Option<String>)>,
}

impl Tests {
    fn walk(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut i = 0;
        while i < tokens.len() {
            let attributes = attributes(&tokens[i..]);
            let start = i;
            i += 2 * attributes.len();
            if attributes.iter().any(|attribute| is_test(attribute)) {
                let end = item_end(&tokens, i);
                let first = tokens[start].span().start().line;
                let last = tokens[end - 1].span().end().line;
                self.lines.push(first..=last);
                self.modules.extend(module(&tokens[i..end], &attributes));
                i = end;
                continue;
            }
            if attributes
                .iter()
                .any(|attribute| is_of_a_feature(attribute))
            {
                let end = item_end(&tokens, i);
                self.optional.extend(module(&tokens[i..end], &attributes));
            }
            if let Some(TokenTree::Group(group)) = tokens.get(i) {
                self.walk(group.stream());
            }
            i += 1;
        }
    }
}

/// The name of `mod name;`, with the file that an attribute states.
fn module(item: &[TokenTree], attributes: &[&Group]) -> Option<(String, Option<String>)> {
    let [
        ..,
        TokenTree::Ident(word),
        TokenTree::Ident(name),
        TokenTree::Punct(_),
    ] = item
    else {
        return None;
    };
    let path = attributes.iter().find_map(|attribute| path_of(attribute));
    (word == "mod").then(|| (name.to_string(), path))
}

/// The attributes at the beginning of `tokens`, documentation too; each takes two tokens.
fn attributes(tokens: &[TokenTree]) -> Vec<&Group> {
    let pairs = tokens.chunks_exact(2).map_while(|pair| match pair {
        [TokenTree::Punct(hash), TokenTree::Group(group)] if hash.as_char() == '#' => Some(group),
        _ => None,
    });
    pairs.collect()
}

/// The file of an attribute `[path = "file"]`.
fn path_of(attribute: &Group) -> Option<String> {
    let text = attribute.stream().to_string();
    let file = text.strip_prefix("path")?.trim_start().strip_prefix('=')?;
    Some(file.trim().trim_matches('"').to_owned())
}

/// Whether an attribute is `[cfg(test)]`, or `[cfg(all(test, …))]`.
pub(crate) fn is_test(attribute: &Group) -> bool {
    let text: String = attribute.stream().to_string().split_whitespace().collect();
    text == "cfg(test)" || text.starts_with("cfg(all(test,")
}

/// Whether an attribute is `[cfg(feature = "…")]`.
fn is_of_a_feature(attribute: &Group) -> bool {
    let text: String = attribute.stream().to_string().split_whitespace().collect();
    text.starts_with("cfg(feature=")
}

/// Behind the item that begins at `i`: its body, or its semicolon; of a field, its comma.
pub(crate) fn item_end(tokens: &[TokenTree], i: usize) -> usize {
    let sign = |at: usize, sign: char| matches!(tokens.get(at), Some(TokenTree::Punct(p)) if p.as_char() == sign);
    let name = (i..tokens.len()).find(|at| match &tokens[*at] {
        TokenTree::Ident(word) => word != "pub",
        TokenTree::Group(group) => group.delimiter() != Delimiter::Parenthesis,
        _ => true,
    });
    let name = name.unwrap_or(i);
    let is_field = sign(name + 1, ':') && !sign(name + 2, ':');
    let mut angles = 0_i32;
    let ends = |at: &usize| match &tokens[*at] {
        TokenTree::Punct(p) => {
            // The head of an arrow closes nothing.
            let is_arrow = sign(at.wrapping_sub(1), '-') || sign(at.wrapping_sub(1), '=');
            match p.as_char() {
                '<' => angles += 1,
                '>' if !is_arrow => angles -= 1,
                _ => {}
            }
            p.as_char() == ';' || is_field && angles == 0 && p.as_char() == ','
        }
        TokenTree::Group(group) => !is_field && group.delimiter() == Delimiter::Brace,
        TokenTree::Ident(_) | TokenTree::Literal(_) => false,
    };
    let end = (i..tokens.len()).find(ends);
    end.map_or(tokens.len(), |at| at + 1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The sources of files that a test makes up.
    pub(crate) fn made_up(files: &[(&str, &str)]) -> Vec<Source> {
        let texts = files
            .iter()
            .map(|(path, text)| (PathBuf::from(path), (*text).to_owned()));
        sources(texts.collect()).unwrap()
    }

    #[test]
    fn test_code_is_found_in_items_fields_and_files() {
        let found = made_up(&[
            (
                "crates/a/src/lib.rs",
                "//! A.\nstruct S {\n    #[cfg(test)]\n    seen: Map<A, B>,\n    x: u8,\n}\n\
                 /// Tests.\n#[cfg(test)]\n#[path = \"own.rs\"]\nmod other;\n#[cfg(test)]\nmod more;\nmod less;\n\
                 fn f() {\n    #[cfg(test)]\n    if a { b() }\n    c()\n}",
            ),
            ("crates/a/src/own.rs", ""),
            ("crates/a/src/more/mod.rs", ""),
            ("crates/a/src/more/part.rs", ""),
            (
                "crates/a/src/less.rs",
                "#[cfg(all(test, unix))]\nmod below;\n",
            ),
            ("crates/a/src/less/below.rs", ""),
            ("crates/a/src/less/belows.rs", ""),
            ("crates/a/tests/all.rs", ""),
        ]);
        let root = found.iter().find(|source| source.module.is_empty());
        let root = root.unwrap();
        let lines: Vec<usize> = (1..19).filter(|line| root.is_test(*line)).collect();
        assert_eq!(lines, [3, 4, 7, 8, 9, 10, 11, 12, 15, 16]);
        let in_files: Vec<(bool, String)> = found
            .iter()
            .map(|source| (source.is_all_test(), source.module.join("::")))
            .collect();
        let expected = [
            (false, "less"),
            (false, ""),
            (true, "less::below"),
            (false, "less::belows"),
            (true, "more"),
            (true, "more::part"),
            (true, "own"),
            (true, "tests::all"),
        ];
        for (test, module) in expected {
            assert!(
                in_files.contains(&(test, module.to_owned())),
                "{module}: {in_files:?}"
            );
        }
    }
}
