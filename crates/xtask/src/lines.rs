//! `xtask lines`: how much there is to read, to compile and to learn.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{AddAssign, RangeInclusive};
use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};
use proc_macro2::{Group, Span, TokenStream, TokenTree};
use syn::spanned::Spanned as _;
use syn::visit::Visit;

use crate::source::{self, Source};
use crate::warnings;

/// The crate of the program.
const APP: &str = "piezotact-app";
/// The macro of the program that lists its commands, one `=>` each.
const COMMANDS: &str = "commands";

/// Prints the lines of every crate and the size of the program; with `of`, a crate or `CRATE::MODULE`, those of its modules.
#[allow(clippy::print_stdout, reason = "its result is a table")]
pub(crate) fn run(of: Option<&str>) -> Result<()> {
    let root = source::root()?;
    let sources = source::read(&root)?;
    let mut rows: BTreeMap<String, Lines> = BTreeMap::new();
    for source in &sources {
        if let Some(row) = row_of(source, of) {
            *rows.entry(row).or_default() += count(source);
        }
    }
    ensure!(
        !rows.is_empty(),
        "expected a crate or CRATE::MODULE, found {}",
        of.unwrap_or("no source")
    );
    println!("{}", table(&rows));
    if of.is_some() {
        return Ok(());
    }
    let program = Program::of(&sources)?;
    let (demo, full) = (
        packages(&root, &["--no-default-features"])?,
        packages(&root, &["--features", "full"])?,
    );
    let mut rings: BTreeMap<String, Lines> = BTreeMap::new();
    for source in &sources {
        let ring = match source.package.as_str() {
            package if !source.is_optional && demo.contains(package) => "core: ./x demo",
            package if full.contains(package) => "study: ./x build",
            _ => "validation and tools",
        };
        *rings.entry(ring.to_owned()).or_default() += count(source);
    }
    println!("\n{}\n", table(&rings));
    println!(
        "crates of the demo build: {}, of the full build: {} (`cargo tree`, with build scripts and macros)",
        demo.len(),
        full.len(),
    );
    println!(
        "commands and subcommands: {}, options: {} (counted in the source: clap's `Subcommand` variants, rows of `commands!` and fields with \
         `#[arg(long)]`; an option that several commands share counts once)",
        program.commands, program.options,
    );
    let learned = Learned::of(&sources)?;
    println!(
        "codes of warnings: {}, error enums: {} with {} texts, documents: {}, functions over {LONG_FUNCTION} lines: {}",
        warnings::declared(&sources)?.len(),
        learned.error_enums,
        learned.error_texts,
        learned.documents,
        learned.long_functions,
    );
    Ok(())
}

/// Lines that are not blank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lines {
    code: usize,
    docs: usize,
    comments: usize,
    /// All lines of test code, its comments too.
    tests: usize,
}

impl AddAssign for Lines {
    fn add_assign(&mut self, other: Self) {
        self.code += other.code;
        self.docs += other.docs;
        self.comments += other.comments;
        self.tests += other.tests;
    }
}

/// The row of a source: its crate, or its module in the crate or module `of`; none if it is not in there.
fn row_of(source: &Source, of: Option<&str>) -> Option<String> {
    let Some(of) = of else {
        return Some(source.package.clone());
    };
    let mut above = of.split("::");
    if above.next()? != source.package {
        return None;
    }
    let mut module = source.module.iter();
    for name in above {
        if module.next()? != name {
            return None;
        }
    }
    Some(
        module
            .next()
            .cloned()
            .unwrap_or_else(|| "(itself)".to_owned()),
    )
}

/// The lines of a file. A line with code and a comment is code.
fn count(source: &Source) -> Lines {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut kinds = Kinds {
        code: vec![false; lines.len() + 1],
        docs: vec![false; lines.len() + 1],
        lines: &lines,
    };
    kinds.walk(source.tokens.clone());
    let mut counted = Lines::default();
    for (line, text) in (1..).zip(&lines) {
        let of = if text.trim().is_empty() {
            continue;
        } else if source.is_test(line) {
            &mut counted.tests
        } else if kinds.code[line] {
            &mut counted.code
        } else if kinds.docs[line] {
            &mut counted.docs
        } else {
            &mut counted.comments
        };
        *of += 1;
    }
    counted
}

/// The lines of a file, counted from 1, that hold code and documentation.
struct Kinds<'a> {
    code: Vec<bool>,
    docs: Vec<bool>,
    lines: &'a [&'a str],
}

impl Kinds<'_> {
    fn walk(&mut self, tokens: TokenStream) {
        for token in tokens {
            if self.is_doc_comment(&token) {
                self.docs[rows(token.span())].fill(true);
            } else if let TokenTree::Group(group) = token {
                self.group(&group);
            } else {
                self.code[rows(token.span())].fill(true);
            }
        }
    }

    fn group(&mut self, group: &Group) {
        for bracket in [group.span_open(), group.span_close()] {
            self.code[rows(bracket)].fill(true);
        }
        self.walk(group.stream());
    }

    /// Whether a token stands for a part of a doc comment: `#`, `!` or brackets where the source has a slash.
    fn is_doc_comment(&self, token: &TokenTree) -> bool {
        let stands_for_itself = match token {
            TokenTree::Punct(sign) => sign.as_char() == '/',
            TokenTree::Group(_) => false,
            TokenTree::Ident(_) | TokenTree::Literal(_) => true,
        };
        let start = token.span().start();
        !stands_for_itself && self.lines[start.line - 1].chars().nth(start.column) == Some('/')
    }
}

fn rows(span: Span) -> RangeInclusive<usize> {
    span.start().line..=span.end().line
}

/// The rows as text, the largest first, and their sum.
fn table(rows: &BTreeMap<String, Lines>) -> String {
    let total = |lines: &Lines| lines.code + lines.docs + lines.comments + lines.tests;
    let mut sorted: Vec<(&str, Lines)> = rows
        .iter()
        .map(|(name, lines)| (name.as_str(), *lines))
        .collect();
    sorted.sort_by_key(|(_, lines)| std::cmp::Reverse(total(lines)));
    let mut all = Lines::default();
    for (_, lines) in &sorted {
        all += *lines;
    }
    sorted.push(("total", all));
    let mut text = format!(
        "{:24}{:>9}{:>9}{:>10}{:>9}{:>9}",
        "lines, not blank", "code", "docs", "comments", "tests", "total"
    );
    for (name, lines) in sorted {
        let Lines {
            code,
            docs,
            comments,
            tests,
        } = lines;
        text += &format!(
            "\n{name:24}{code:>9}{docs:>9}{comments:>10}{tests:>9}{:>9}",
            total(&lines)
        );
    }
    text
}

/// The packages that a build of the program with `options` compiles.
fn packages(root: &Path, options: &[&str]) -> Result<BTreeSet<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(root)
        .args([
            "tree",
            "--locked",
            "--package",
            APP,
            "--edges",
            "normal,build",
            "--prefix",
            "none",
        ])
        .args(options)
        .output()?;
    ensure!(
        output.status.success(),
        "cargo tree: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8(output.stdout)?;
    // Two versions of one package are two.
    let names = text.lines().map(|line| {
        let mut words = line.split(' ');
        let (name, version) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        match line.contains("(/") {
            true => name.to_owned(),
            false => format!("{name} {version}"),
        }
    });
    Ok(names.collect())
}

/// What a user of the program meets.
#[derive(Default)]
struct Program {
    commands: usize,
    options: usize,
}

impl Program {
    fn of(sources: &[Source]) -> Result<Self> {
        let mut program = Self::default();
        for source in sources
            .iter()
            .filter(|source| source.package == APP && !source.is_all_test())
        {
            program.visit_file(&syn::parse2(source.tokens.clone())?);
        }
        Ok(program)
    }
}

impl<'ast> Visit<'ast> for Program {
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        if item
            .attrs
            .iter()
            .any(|attribute| names(attribute, "derive", "Subcommand"))
        {
            self.commands += item.variants.len();
        }
        syn::visit::visit_item_enum(self, item);
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        self.options += usize::from(
            field
                .attrs
                .iter()
                .any(|attribute| names(attribute, "arg", "long")),
        );
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        if item.path.is_ident(COMMANDS) {
            let tokens: Vec<TokenTree> = item.tokens.clone().into_iter().collect();
            let is = |token: &TokenTree, sign: char| matches!(token, TokenTree::Punct(p) if p.as_char() == sign);
            let arrows = tokens
                .windows(2)
                .filter(|pair| is(&pair[0], '=') && is(&pair[1], '>'));
            self.commands += arrows.count();
        }
    }
}

/// What a reader of the source has to learn, test code left out.
#[derive(Default)]
struct Learned {
    error_enums: usize,
    error_texts: usize,
    documents: usize,
    long_functions: usize,
}

/// From this number of lines on a function is long.
const LONG_FUNCTION: usize = 100;

impl Learned {
    fn of(sources: &[Source]) -> Result<Self> {
        let mut learned = Self::default();
        for source in sources.iter().filter(|source| !source.is_all_test()) {
            learned.visit_file(&syn::parse2(source.tokens.clone())?);
        }
        Ok(learned)
    }

    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let lines = block.span().end().line + 1 - signature.span().start().line;
        self.long_functions += usize::from(lines > LONG_FUNCTION);
    }
}

impl<'ast> Visit<'ast> for Learned {
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        if item.ident.to_string().ends_with("Error") {
            self.error_enums += 1;
            let texts = item.variants.iter();
            self.error_texts += texts
                .filter(|variant| variant.attrs.iter().any(|one| one.path().is_ident("error")))
                .count();
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let of = item
            .trait_
            .as_ref()
            .and_then(|(_, path, _)| path.segments.last());
        self.documents += usize::from(of.is_some_and(|of| of.ident == "Content"));
        syn::visit::visit_item_impl(self, item);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if item.ident != "tests" {
            syn::visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.function(&item.sig, &item.block);
        syn::visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
        syn::visit::visit_impl_item_fn(self, item);
    }
}

/// Whether an attribute is `#[outer(… word …)]`.
fn names(attribute: &syn::Attribute, outer: &str, word: &str) -> bool {
    attribute.path().is_ident(outer)
        && attribute.meta.require_list().is_ok_and(|list| {
            let mut tokens = list.tokens.clone().into_iter();
            tokens.any(|token| matches!(token, TokenTree::Ident(ident) if ident == word))
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::tests::made_up;

    const LIB: &str = "//! A crate.\n//!\n\n// Why.\nfn f() -> u8 { // One.\n    4 / 2\n}\n\n/** Two\nlines. */\n#[doc = \"x\"]\n\
        const S: &str = \"a\n\n// in a string\";\n\n/// Tests.\n#[cfg(test)]\nmod tests {\n    // Here.\n\n    fn g() {}\n}\n";

    #[test]
    fn each_line_is_of_one_kind() {
        let sources = made_up(&[
            ("crates/a/src/lib.rs", LIB),
            ("crates/a/src/b/c.rs", "/// D.\nfn d() {}\n"),
            ("crates/a/tests/all.rs", "//! All.\nfn d() {}\n"),
        ]);
        let lines = |code, docs, comments, tests| Lines {
            code,
            docs,
            comments,
            tests,
        };
        let row = |of: Option<&str>, name: &str| {
            let mut sum = Lines::default();
            let of = sources
                .iter()
                .filter(|source| row_of(source, of).as_deref() == Some(name));
            of.for_each(|source| sum += count(source));
            sum
        };
        assert_eq!(row(Some("a"), "(itself)"), lines(6, 4, 1, 6));
        assert_eq!(row(Some("a"), "b"), lines(1, 1, 0, 0));
        assert_eq!(row(Some("a::b"), "c"), lines(1, 1, 0, 0));
        assert_eq!(row(None, "a"), lines(7, 5, 1, 8));
    }

    #[test]
    fn commands_and_options_are_counted() {
        let sources = made_up(&[(
            "crates/piezotact-app/src/main.rs",
            "commands! { #[command(x = \"=>\")] A(a::A) => a::run, B(B) => b::run, }\n\
             #[derive(Debug, Subcommand)]\nenum Panel { Run { #[arg(long)] x: u8 }, Add }\nenum Other { X }\n\
             #[derive(Args)]\nstruct A { #[arg(value_name = \"X\")] x: u8, #[arg(value_name = \"Y\", long)] y: u8 }",
        )]);
        let program = Program::of(&sources).unwrap();
        assert_eq!((program.commands, program.options), (4, 2));
    }

    #[test]
    fn errors_documents_and_long_functions_are_counted() {
        let long = format!("fn long() {{\n{}}}\n", "step();\n".repeat(LONG_FUNCTION));
        let text = format!(
            "enum AError {{ #[error(\"a\")] A, #[error(transparent)] B(B), C }}\nimpl a::Content for B {{ fn f() {{}} }}\n{long}\
             mod tests {{ enum BError {{ X }}\n{long} }}\nstruct S;\nimpl S {{ {long} }}"
        );
        let sources = made_up(&[("crates/a/src/lib.rs", &text)]);
        let learned = Learned::of(&sources).unwrap();
        assert_eq!((learned.error_enums, learned.error_texts), (1, 2));
        assert_eq!((learned.documents, learned.long_functions), (1, 2));
    }
}
