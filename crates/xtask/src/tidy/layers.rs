//! The modules of the science stand in layers, and a module uses only what stands before it.
//!
//! The table is the one in `docs/layers.md`. Uses are read from the tokens of the source, macros included: paths that begin
//! with `crate`, and those of so many `super` that they lead to the root. Comments and `#[cfg(test)]` do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};

use super::{Findings, rust_files};
use crate::source::{self, item_end};

/// The sciences: the heading over the table of each, and its source folder.
const TABLES: [(&str, &str); 2] = [
    ("## Layers of the science", "crates/piezotact/src"),
    (
        "## Layers of the science of people",
        "crates/piezotact-people/src",
    ),
];

/// Invariant 11: the science has no circle.
pub(super) fn check(root: &Path, findings: &mut Findings) -> Result<()> {
    let page = std::fs::read_to_string(root.join("docs/layers.md")).context("docs/layers.md")?;
    for (heading, source) in TABLES {
        let folder = root.join(source);
        let mut sources = Sources::new();
        for file in rust_files(&folder)? {
            let text = std::fs::read_to_string(&file)?;
            sources.insert(file.strip_prefix(&folder)?.to_path_buf(), text);
        }
        for found in against(&table(&page, heading)?, source, &sources)? {
            findings.add(found);
        }
    }
    Ok(())
}

/// The modules of the table under `heading` in `page`, in its order.
fn table(page: &str, heading: &str) -> Result<Vec<String>> {
    let (_, after) = page
        .split_once(&format!("\n{heading}\n"))
        .with_context(|| format!("docs/layers.md has no heading `{heading}`"))?;
    let section = after.split("\n## ").next().unwrap_or_default();
    let mut modules = Vec::new();
    for row in section.lines().filter(|line| line.starts_with('|')) {
        let cell = row.split('|').nth(2).unwrap_or_default();
        modules.extend(cell.split('`').skip(1).step_by(2).map(str::to_owned));
    }
    if modules.is_empty() {
        bail!("docs/layers.md: `{heading}` has no table with modules in its second column");
    }
    Ok(modules)
}

/// The source files of a crate by their path in its `src`.
type Sources = BTreeMap<PathBuf, String>;

/// The violations of the order `modules` in `sources` of the folder `source`; each finding says what to do.
fn against(modules: &[String], source: &str, sources: &Sources) -> Result<Vec<String>> {
    let mut found = Vec::new();
    let mut place = BTreeMap::new();
    for (i, module) in modules.iter().enumerate() {
        if place.insert(module.as_str(), i).is_some() {
            found.push(format!(
                "docs/layers.md: module {module} stands twice in the table of layers: keep one"
            ));
        }
    }
    let mut tree = Tree::new(source, sources);
    tree.file(Path::new("lib.rs"), &[])?;
    found.append(&mut tree.findings);
    for module in modules.iter().filter(|m| !tree.modules.contains(*m)) {
        found.push(format!(
            "docs/layers.md: the table of layers has a module {module}, which {source}/lib.rs does not: take it out"
        ));
    }
    for module in &tree.modules {
        if !place.contains_key(module.as_str()) {
            found.push(format!(
                "{source}/lib.rs: module {module} is not in the table of layers of docs/layers.md: add it behind what it uses"
            ));
        }
    }
    for Use { from, to, at } in &tree.uses {
        // An item that the root passes on stands in its module.
        let to = tree.passed_on.get(to).unwrap_or(to);
        let (Some(own), Some(other)) = (place.get(from.as_str()), place.get(to.as_str())) else {
            if !tree.modules.contains(to) {
                found.push(format!(
                    "{at}: `crate::{to}` is no module of the table of layers: name the module that holds it"
                ));
            }
            continue;
        };
        if other <= own {
            continue;
        }
        found.push(format!(
            "{at}: {from} uses {to}, which stands below it in the table of layers of docs/layers.md: move what both need up"
        ));
    }
    Ok(found)
}

/// One use of a module by another.
struct Use {
    from: String,
    to: String,
    /// The file and its line.
    at: String,
}

/// The modules of a crate, followed from its root, and what they use.
struct Tree<'a> {
    source: &'a str,
    sources: &'a Sources,
    /// The modules at the root.
    modules: BTreeSet<String>,
    /// The items that the root passes on, with their modules.
    passed_on: BTreeMap<String, String>,
    uses: Vec<Use>,
    findings: Vec<String>,
}

/// Where tokens stand.
#[derive(Clone, Copy)]
struct Place<'a> {
    source: &'a str,
    file: &'a Path,
    /// The module from the root on; empty in the root.
    module: &'a [String],
}

impl Place<'_> {
    fn at(&self, span: Span) -> String {
        format!(
            "{}/{}:{}",
            self.source,
            self.file.display(),
            span.start().line
        )
    }
}

impl<'a> Tree<'a> {
    fn new(source: &'a str, sources: &'a Sources) -> Self {
        Self {
            source,
            sources,
            modules: BTreeSet::new(),
            passed_on: BTreeMap::new(),
            uses: Vec::new(),
            findings: Vec::new(),
        }
    }

    fn file(&mut self, file: &Path, module: &[String]) -> Result<()> {
        let text = self
            .sources
            .get(file)
            .with_context(|| format!("{}/{} is missing", self.source, file.display()))?;
        let tokens: TokenStream = text
            .parse()
            .map_err(|error| anyhow::anyhow!("{}/{}: {error}", self.source, file.display()))?;
        let source = self.source;
        self.walk(
            tokens,
            Place {
                source,
                file,
                module,
            },
        )
    }

    /// Takes up what `tokens` declare and use.
    fn walk(&mut self, tokens: TokenStream, place: Place<'_>) -> Result<()> {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut i = 0;
        while i < tokens.len() {
            if is_test(&tokens[i..]) {
                i = item_end(&tokens, i + 2);
                continue;
            }
            match &tokens[i] {
                TokenTree::Ident(word) if word == "mod" => i = self.module(&tokens, i, place)?,
                TokenTree::Ident(word) if word == "use" && place.module.is_empty() => {
                    self.pass_on(&tokens[i + 1..]);
                    i = statement_end(&tokens, i);
                }
                TokenTree::Ident(word) if is_root(word) => i = self.path(&tokens, i, place),
                TokenTree::Group(group) => {
                    self.walk(group.stream(), place)?;
                    i += 1;
                }
                _ => i += 1,
            }
        }
        Ok(())
    }

    /// The module that `mod` at `i` declares; gives where to go on.
    fn module(&mut self, tokens: &[TokenTree], i: usize, place: Place<'_>) -> Result<usize> {
        let (Some(TokenTree::Ident(name)), Some(next)) = (tokens.get(i + 1), tokens.get(i + 2))
        else {
            return Ok(i + 1);
        };
        let mut module = place.module.to_vec();
        module.push(name.to_string());
        if place.module.is_empty() {
            self.modules.insert(name.to_string());
        }
        match next {
            TokenTree::Group(body) if body.delimiter() == Delimiter::Brace => {
                let inside = Place {
                    module: &module,
                    ..place
                };
                self.walk(body.stream(), inside)?;
            }
            _ => {
                let folder: PathBuf = module.iter().collect();
                let beside = folder.with_extension("rs");
                let file = match self.sources.contains_key(&beside) {
                    true => beside,
                    false => folder.join("mod.rs"),
                };
                self.file(&file, &module)?;
            }
        }
        Ok(i + 3)
    }

    /// What a `use` in the root passes on: `warning::Warning`, and no more than that.
    fn pass_on(&mut self, tokens: &[TokenTree]) {
        if let [
            TokenTree::Ident(module),
            TokenTree::Punct(_),
            TokenTree::Punct(_),
            TokenTree::Ident(item),
            TokenTree::Punct(end),
            ..,
        ] = tokens
            && end.as_char() == ';'
        {
            self.passed_on.insert(item.to_string(), module.to_string());
        }
    }

    /// The path that begins at `i` with `crate`, `self` or `super`; gives where to go on.
    fn path(&mut self, tokens: &[TokenTree], i: usize, place: Place<'_>) -> usize {
        let mut depth = place.module.len();
        let mut at = i;
        while let Some(TokenTree::Ident(word)) = tokens.get(at) {
            match word.to_string().as_str() {
                "crate" => depth = 0,
                "super" => depth = depth.saturating_sub(1),
                "self" => {}
                _ => break,
            }
            if !joined(tokens, at + 1) {
                // Nothing is taken out of it here: `pub(crate)`, `self`, or another name for it.
                if depth == 0 && is_word(tokens.get(at + 1), "as") {
                    self.hidden(word, place);
                }
                return at + 1;
            }
            at += 3;
        }
        match tokens.get(at) {
            Some(TokenTree::Group(group)) => self.group(group, depth, place),
            Some(TokenTree::Ident(name)) if depth == 0 => self.uses(name, place),
            Some(TokenTree::Punct(star)) if depth == 0 && star.as_char() == '*' => {
                self.findings.push(format!(
                    "{}: takes everything of the crate: name the modules",
                    place.at(star.span())
                ));
            }
            _ => {}
        }
        at + 1
    }

    /// The paths in the braces of a `use`, behind a path that leads `depth` modules deep.
    fn group(&mut self, group: &Group, depth: usize, place: Place<'_>) {
        let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
        let module = &place.module[..depth.min(place.module.len())];
        for path in tokens.split(|token| matches!(token, TokenTree::Punct(p) if p.as_char() == ','))
        {
            match path.first() {
                Some(TokenTree::Ident(word)) if word == "super" => {
                    self.path(path, 0, Place { module, ..place });
                }
                Some(TokenTree::Ident(word)) if depth == 0 && word == "self" => {
                    self.hidden(word, place);
                }
                Some(TokenTree::Ident(name)) if depth == 0 => self.uses(name, place),
                Some(TokenTree::Punct(star)) if depth == 0 => self.findings.push(format!(
                    "{}: takes everything of the crate: name the modules",
                    place.at(star.span())
                )),
                _ => {}
            }
        }
    }

    fn uses(&mut self, name: &Ident, place: Place<'_>) {
        let Some(from) = place.module.first() else {
            return;
        };
        let to = name.to_string();
        if *from != to {
            self.uses.push(Use {
                from: from.clone(),
                to,
                at: place.at(name.span()),
            });
        }
    }

    fn hidden(&mut self, word: &Ident, place: Place<'_>) {
        self.findings.push(format!(
            "{}: another name for the crate hides what is used: write `crate`",
            place.at(word.span())
        ));
    }
}

fn is_root(word: &Ident) -> bool {
    ["crate", "super", "self"].iter().any(|root| word == root)
}

fn is_word(token: Option<&TokenTree>, word: &str) -> bool {
    matches!(token, Some(TokenTree::Ident(found)) if found == word)
}

/// Whether `::` stands at `i`.
fn joined(tokens: &[TokenTree], i: usize) -> bool {
    let colon = |token: Option<&TokenTree>| matches!(token, Some(TokenTree::Punct(p)) if p.as_char() == ':');
    colon(tokens.get(i)) && colon(tokens.get(i + 1))
}

/// Whether `tokens` begin with `#[cfg(test)]`.
pub(super) fn is_test(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(hash), TokenTree::Group(group), ..] = tokens else {
        return false;
    };
    hash.as_char() == '#' && source::is_test(group)
}

/// Behind the semicolon that follows `i`.
fn statement_end(tokens: &[TokenTree], i: usize) -> usize {
    let ends = |token: &TokenTree| matches!(token, TokenTree::Punct(p) if p.as_char() == ';');
    (i..tokens.len())
        .find(|at| ends(&tokens[*at]))
        .map_or(tokens.len(), |at| at + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# A page\n\n## Layers of the science\n\n| layer | modules | holds |\n|---|---|---|\n\
        | ground | `quantity`, `statistics` | units |\n| signals | `series` | `no` module |\n\n## Next\n| x | `other` |";

    const CLEAN: [(&str, &str); 5] = [
        (
            "lib.rs",
            "//! A crate.\npub mod quantity;\npub mod series;\nmod statistics;\npub use series::Series;",
        ),
        (
            "quantity.rs",
            "/// See [`crate::series`].\npub struct Hertz;\n// crate::series is no use.\n\
             #[cfg(test)]\nmod tests { use crate::series::Series; }\n#[cfg(test)]\nmod more;",
        ),
        ("statistics.rs", "pub(crate) fn mean() {}"),
        (
            "series/mod.rs",
            "mod part;\nuse crate::{quantity::Hertz, statistics};\nuse self::part::X;\n\
             pub struct Series;\nmacro_rules! m { () => { $crate::statistics::mean() } }",
        ),
        (
            "series/part.rs",
            "use super::super::quantity;\nuse super::Series;\npub struct X;\nfn f() { super::f() }",
        ),
    ];

    /// What is found in a clean tree with `changed` files instead of its own, or beside them.
    fn found(page: &str, changed: &[(&str, &str)]) -> Vec<String> {
        let sources = CLEAN
            .iter()
            .chain(changed)
            .map(|(path, text)| (PathBuf::from(path), (*text).to_owned()))
            .collect();
        against(&table(page, TABLES[0].0).unwrap(), TABLES[0].1, &sources).unwrap()
    }

    /// That one finding, which names `words`, comes of one changed file.
    fn refused(file: &str, text: &str, words: &[&str]) {
        let found = found(PAGE, &[(file, text)]);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        for word in words {
            assert!(found[0].contains(word), "{text}: {found:?}");
        }
    }

    #[test]
    fn a_clean_tree_passes() {
        assert_eq!(
            table(PAGE, TABLES[0].0).unwrap(),
            ["quantity", "statistics", "series"]
        );
        assert_eq!(found(PAGE, &[]), Vec::<String>::new());
    }

    /// The heading of one science begins like that of the other.
    #[test]
    fn each_science_has_its_table() {
        let people = format!("\n{}\n\n| | `campaign` |\n\n## Next\n{PAGE}", TABLES[1].0);
        assert_eq!(table(&people, TABLES[1].0).unwrap(), ["campaign"]);
        assert_eq!(
            table(&people, TABLES[0].0).unwrap(),
            ["quantity", "statistics", "series"]
        );
        assert!(table(PAGE, TABLES[1].0).is_err());
    }

    #[test]
    fn a_circle_is_refused() {
        // `series` uses `statistics`, and this closes the circle.
        let circle = "use crate::series::Series;\npub(crate) fn mean(_: &Series) {}";
        refused(
            "statistics.rs",
            circle,
            &["src/statistics.rs:1:", "statistics uses series"],
        );
    }

    #[test]
    fn a_use_is_seen_however_it_is_written() {
        for text in [
            "fn f() { crate::series::f() }",
            "use super::series::Series;",
            "use crate::{quantity, series::{self, Series}};",
            "use super::{series};",
            "fn f() { let _ = vec![crate::series::f()]; }",
            "mod inner { use super::super::series::Series; }",
            "mod inner { use super::{super::series}; }",
            "pub use crate::Series;",
            "impl From<crate::series::Series> for X {}",
            "pub fn f() -> crate::Series { todo() }",
        ] {
            refused("statistics.rs", text, &["statistics uses series"]);
        }
        refused("statistics.rs", "use crate::*;", &["takes everything"]);
        refused("statistics.rs", "use super::*;", &["takes everything"]);
        refused("statistics.rs", "use crate as all;", &["another name"]);
        refused(
            "statistics.rs",
            "use crate::{self as all};",
            &["another name"],
        );
    }

    #[test]
    fn what_stands_before_it_in_its_layer_may_be_used() {
        let before = "use crate::quantity::Hertz;";
        assert_eq!(
            found(PAGE, &[("statistics.rs", before)]),
            Vec::<String>::new()
        );
        refused(
            "quantity.rs",
            "use crate::statistics::mean;",
            &["quantity uses statistics"],
        );
    }

    #[test]
    fn table_and_crate_have_the_same_modules() {
        let more = PAGE.replace("`series`", "`series`, `spectrum`");
        let found_more = found(&more, &[]);
        assert!(found_more.len() == 1 && found_more[0].contains("module spectrum"));
        let fewer = PAGE.replace("`statistics`", "");
        let found_fewer = found(&fewer, &[]);
        assert!(
            found_fewer.len() == 1 && found_fewer[0].contains("statistics is not in the table")
        );
        let twice = PAGE.replace("`series`", "`series`, `quantity`");
        assert!(found(&twice, &[]).iter().any(|f| f.contains("twice")));
        assert!(table("# A page", TABLES[0].0).is_err());
    }
}
