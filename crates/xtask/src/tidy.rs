//! `xtask tidy`: the project's invariants that a program can check. Each finding says what to do.

mod commands;
mod decisions;
mod docs;
mod layers;
mod options;
mod programs;
mod reads;
mod warning_reads;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use syn::spanned::Spanned;
use syn::visit::Visit;

use crate::source::{self, rust_files};
use crate::warnings;

/// The sources of the sciences: of signals and touch, of people, and of what is optional beside them.
const SCIENCES: [&str; 4] = [
    "crates/piezotact/src",
    "crates/piezotact-people/src",
    "crates/piezotact-haptic/src/envelope",
    "crates/piezotact-surface/src/roughness",
];
/// Modules whose functions compute nothing: they hold numbers of any unit, which a label beside them names, or word them.
const SHOWN_NUMBERS: [&str; 2] = ["src/figure.rs", "src/number.rs"];

/// The arrows between crates, and no others.
const ARROWS: [(&str, &[&str]); 16] = [
    ("piezotact-fourier", &[]),
    ("piezotact", &["piezotact-fourier"]),
    ("piezotact-people", &["piezotact"]),
    ("piezotact-haptic", &["piezotact"]),
    ("piezotact-dataset", &["piezotact", "piezotact-haptic"]),
    ("piezotact-bench", &["piezotact", "piezotact-fourier"]),
    ("piezotact-audio", &["piezotact", "piezotact-bench"]),
    ("piezotact-report", &["piezotact"]),
    (
        "piezotact-surface",
        &["piezotact", "piezotact-fourier", "piezotact-dataset"],
    ),
    (
        "piezotact-study",
        &[
            "piezotact",
            "piezotact-people",
            "piezotact-dataset",
            "piezotact-bench",
        ],
    ),
    (
        "piezotact-twin",
        &["piezotact", "piezotact-fourier", "piezotact-bench"],
    ),
    (
        "piezotact-volunteers",
        &[
            "piezotact",
            "piezotact-people",
            "piezotact-bench",
            "piezotact-study",
            "piezotact-twin",
        ],
    ),
    (
        "piezotact-web",
        &["piezotact", "piezotact-people", "piezotact-study"],
    ),
    (
        "piezotact-app",
        &[
            "piezotact",
            "piezotact-people",
            "piezotact-bench",
            "piezotact-study",
            "piezotact-web",
            "piezotact-twin",
            "piezotact-volunteers",
            "piezotact-report",
            "piezotact-dataset",
            "piezotact-haptic",
            "piezotact-surface",
            "piezotact-audio",
        ],
    ),
    // Not part of the product: they measure and check it.
    (
        "piezotact-validation",
        &[
            "piezotact",
            "piezotact-fourier",
            "piezotact-dataset",
            "piezotact-people",
            "piezotact-audio",
            "piezotact-bench",
            "piezotact-twin",
            "piezotact-volunteers",
            "piezotact-report",
        ],
    ),
    // For the JSON Schemas of documents.
    (
        "xtask",
        &[
            "piezotact",
            "piezotact-dataset",
            "piezotact-people",
            "piezotact-bench",
            "piezotact-study",
            "piezotact-twin",
            "piezotact-validation",
            "piezotact-surface",
        ],
    ),
];
/// What `./x demo` compiles of them.
const CORE: [&str; 7] = [
    "piezotact",
    "piezotact-fourier",
    "piezotact-dataset",
    "piezotact-bench",
    "piezotact-twin",
    "piezotact-report",
    "piezotact-app",
];
/// Names that the science must not use: files, clocks, threads, environment, entropy.
const FORBIDDEN_IN_SCIENCE: [&str; 8] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::process",
    "std::thread",
    "std::time",
    "std::io",
    "getrandom",
];
/// The largest number of lines of a file.
const LONGEST_FILE: usize = 700;
/// Suffixes of names that state the unit of a number, or that it has none.
const UNIT_SUFFIXES: [&str; 27] = [
    "_hz",
    "_s",
    "_n",
    "_v",
    "_db",
    "_jnd",
    "_m",
    "_kg",
    "_f",
    "_a",
    "_deg",
    "_m_s",
    "_m_s2",
    "_v_per_s",
    "_ratio",
    "_fraction",
    "_share",
    "_mb",
    "ratio",
    "fraction",
    "share",
    "scale",
    "overlap",
    "coherence",
    "power",
    "value",
    "regularisation",
];

/// Checks all invariants.
#[allow(clippy::print_stdout, reason = "its result is a list of findings")]
pub(crate) fn run() -> Result<()> {
    let findings = findings()?;
    if findings.is_empty() {
        println!("tidy: all invariants hold");
        return Ok(());
    }
    for finding in &findings {
        println!("tidy: {finding}");
    }
    std::process::exit(1)
}

/// What is not as the invariants say, and what to do about each.
fn findings() -> Result<BTreeSet<String>> {
    let root = source::root()?;
    let metadata = MetadataCommand::new().current_dir(&root).exec()?;
    let mut findings = Findings::default();
    arrows(&metadata, &mut findings);
    science_is_pure(&root, &mut findings)?;
    science_is_documented(&root, &mut findings)?;
    let sources = source::read(&root)?;
    docs::check(&sources, &mut findings)?;
    warning_reads::check(&sources, &mut findings);
    layers::check(&root, &mut findings)?;
    options::check(&root, &mut findings)?;
    commands::check(&root, &mut findings)?;
    licences(&root, &metadata, "piezotact-app", &mut findings)?;
    licences(&root, &wheel(&root)?, "piezotact-python", &mut findings)?;
    files(&root, &mut findings)?;
    real_time(&root, &mut findings)?;
    reads::check(&root, &mut findings)?;
    check_warnings(&root, &mut findings)?;
    programs::check(&root, &metadata, &mut findings)?;
    decisions::check(&root, &mut findings)?;
    Ok(findings.0)
}

/// What the threads of a sound system run.
const REAL_TIME: &str = "crates/piezotact-audio/src/callback.rs";
/// What may not stand there: it allocates, locks, formats, logs or touches files.
const NOT_IN_REAL_TIME: [&str; 17] = [
    "Vec::new",
    "vec!",
    "with_capacity",
    "Box::new",
    "Arc::new",
    "String",
    "format!",
    "print",
    "to_owned",
    "to_vec",
    ".clone()",
    ".collect",
    ".resize(",
    "Mutex",
    ".lock(",
    "std::fs",
    "sleep",
];

/// The callbacks of sound devices do nothing that could make them late.
fn real_time(root: &Path, findings: &mut Findings) -> Result<()> {
    let text = std::fs::read_to_string(root.join(REAL_TIME))?;
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    for (number, line) in (1..).zip(code) {
        for word in NOT_IN_REAL_TIME {
            if line.contains(word) {
                findings.add(format!(
                    "{REAL_TIME}: `{word}` in line {number} of its code: what a callback needs is prepared by streams.rs and freed there"
                ));
            }
        }
    }
    Ok(())
}

#[derive(Default)]
struct Findings(BTreeSet<String>);

impl Findings {
    fn add(&mut self, text: String) {
        self.0.insert(text);
    }
}

/// Invariant 1: data flows one way. The twin and `piezotact-dataset` meet in the app and in what validates alone, so that no analysis reads the twin's parameters.
fn arrows(metadata: &Metadata, findings: &mut Findings) {
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.into_iter().collect();
    let ours: BTreeSet<&str> = metadata
        .workspace_packages()
        .iter()
        .map(|package| package.name.as_str())
        .collect();
    for package in metadata.workspace_packages() {
        let name = package.name.as_str();
        let Some(targets) = allowed.get(name) else {
            findings.add(format!(
                "crate {name} has no line in xtask's ARROWS: say what it may depend on"
            ));
            continue;
        };
        for dependency in &package.dependencies {
            let to = dependency.name.as_str();
            // A crate that names itself turns a feature on for its own tests.
            let outward = CORE.contains(&name) && !CORE.contains(&to);
            if ours.contains(to)
                && outward
                && !dependency.optional
                && dependency.kind == DependencyKind::Normal
            {
                findings.add(format!(
                    "{name} → {to} leaves the core: make it optional, behind a feature, so that a demo does without"
                ));
            }
            if ours.contains(to) && to != name && !targets.contains(&to) {
                findings.add(format!(
                    "{name} → {to} is no arrow of the house: hand a value over in the app instead"
                ));
            }
        }
        if package.rust_version != metadata.workspace_packages()[0].rust_version {
            findings.add(format!(
                "{name} sets a rust-version of its own: take the workspace's"
            ));
        }
    }
}

/// Invariant 2: the science touches no file, clock, thread, environment or entropy.
fn science_is_pure(root: &Path, findings: &mut Findings) -> Result<()> {
    for science in SCIENCES {
        // A crate that is nothing else has lints of its own.
        if let Some(own) = science.strip_suffix("/src") {
            let lints = format!("{own}/clippy.toml");
            let text = std::fs::read_to_string(root.join(&lints)).with_context(|| lints.clone())?;
            for wanted in [
                "std::fs",
                "std::time",
                "std::thread",
                "std::env",
                "RandomState",
            ] {
                if !text.contains(wanted) {
                    findings.add(format!("{lints} no longer forbids {wanted}"));
                }
            }
        }
        for file in rust_files(&root.join(science))? {
            let text = std::fs::read_to_string(&file)?;
            for (line, forbidden) in impure(&text) {
                findings.add(format!(
                    "{}:{line}: the science uses {forbidden}: take it as an argument",
                    shown(root, &file)
                ));
            }
        }
    }
    Ok(())
}

/// The first line of each forbidden name in `text`. Comments do not count.
fn impure(text: &str) -> Vec<(usize, &'static str)> {
    let found = FORBIDDEN_IN_SCIENCE.iter().filter_map(|forbidden| {
        let named = |line: &str| line.contains(forbidden) && !line.trim().starts_with("//");
        Some((text.lines().position(named)? + 1, *forbidden))
    });
    found.collect()
}

/// Invariant 3: no public function of the science without shape, unit, errors and source.
fn science_is_documented(root: &Path, findings: &mut Findings) -> Result<()> {
    for science in SCIENCES {
        for file in rust_files(&root.join(science))? {
            if SHOWN_NUMBERS.iter().any(|module| file.ends_with(module)) {
                continue;
            }
            let text = std::fs::read_to_string(&file)?;
            undocumented(&text, shown(root, &file), findings)
                .with_context(|| file.display().to_string())?;
        }
    }
    Ok(())
}

/// What the documentation of `text`, the source of `file`, lacks.
fn undocumented(text: &str, file: String, findings: &mut Findings) -> Result<()> {
    let syntax = syn::parse_file(text)?;
    Documentation { file, findings }.visit_file(&syntax);
    Ok(())
}

/// A function names its source; a method belongs to a type that does.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Function,
    Method,
}

struct Documentation<'a> {
    file: String,
    findings: &'a mut Findings,
}

impl Documentation<'_> {
    fn check(
        &mut self,
        visibility: Option<&syn::Visibility>,
        attributes: &[syn::Attribute],
        signature: &syn::Signature,
        kind: Kind,
    ) {
        if !matches!(visibility, Some(syn::Visibility::Public(_))) {
            return;
        }
        let place = format!(
            "{}:{}: {}",
            self.file,
            signature.span().start().line,
            signature.ident
        );
        let docs: String = attributes
            .iter()
            .filter_map(doc_text)
            .collect::<Vec<_>>()
            .join("\n");
        if docs.trim().is_empty() {
            self.findings.add(format!(
                "{place} has no documentation: say what, shape and unit"
            ));
        }
        let returns = match &signature.output {
            syn::ReturnType::Type(_, of) => quote_text(of),
            syn::ReturnType::Default => String::new(),
        };
        if returns.starts_with("Result") && !docs.contains("# Errors") {
            self.findings.add(format!(
                "{place} can fail and does not say when: add `# Errors`"
            ));
        }
        if kind == Kind::Function && !docs.contains("Source:") {
            self.findings.add(format!(
                "{place} names no source: add `Source:` with formula or reference"
            ));
        }
        for input in &signature.inputs {
            let syn::FnArg::Typed(argument) = input else {
                continue;
            };
            let name = quote_text(&argument.pat);
            if quote_text(&argument.ty) == "f64"
                && !UNIT_SUFFIXES.iter().any(|suffix| name.ends_with(suffix))
            {
                self.findings.add(format!("{place}: `{name}: f64` does not say its unit: end its name with one, or own a type"));
            }
        }
    }
}

impl<'ast> Visit<'ast> for Documentation<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.check(Some(&item.vis), &item.attrs, &item.sig, Kind::Function);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.check(Some(&item.vis), &item.attrs, &item.sig, Kind::Method);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let tests = item
            .attrs
            .iter()
            .any(|attribute| attribute.path().is_ident("cfg"));
        if !tests {
            syn::visit::visit_item_mod(self, item);
        }
    }
}

fn doc_text(attribute: &syn::Attribute) -> Option<String> {
    let syn::Meta::NameValue(pair) = &attribute.meta else {
        return None;
    };
    let syn::Expr::Lit(syn::ExprLit {
        lit: syn::Lit::Str(text),
        ..
    }) = &pair.value
    else {
        return None;
    };
    pair.path.is_ident("doc").then(|| text.value())
}

/// The source text of a piece of syntax, without spaces.
fn quote_text(tokens: &impl Spanned) -> String {
    tokens
        .span()
        .source_text()
        .unwrap_or_default()
        .replace(' ', "")
}

/// The workspace of the wheel, with the crates of its own lock file.
fn wheel(root: &Path) -> Result<Metadata> {
    let mut command = MetadataCommand::new();
    command.current_dir(root.join("py"));
    Ok(command.other_options(["--locked".to_owned()]).exec()?)
}

/// Every crate that `product` links has a licence that `deny.toml` allows.
fn licences(
    root: &Path,
    metadata: &Metadata,
    product: &str,
    findings: &mut Findings,
) -> Result<()> {
    let deny: toml::Table = std::fs::read_to_string(root.join("deny.toml"))?.parse()?;
    let allowed: Vec<spdx::Licensee> = deny
        .get("licenses")
        .and_then(|section| section.get("allow"))
        .and_then(toml::Value::as_array)
        .context("deny.toml has no licenses.allow")?
        .iter()
        .filter_map(toml::Value::as_str)
        .map(|licence| spdx::Licensee::parse(licence).with_context(|| licence.to_owned()))
        .collect::<Result<_>>()?;
    for package in linked(metadata, product)? {
        let stated = package.license.as_deref().unwrap_or("none");
        let expression = spdx::Expression::parse_mode(stated, spdx::ParseMode::LAX);
        let fits = expression.is_ok_and(|expression| {
            expression.evaluate(|wanted| allowed.iter().any(|licensee| licensee.satisfies(wanted)))
        });
        if !fits {
            findings.add(format!(
                "{} {} has the licence {stated}, which deny.toml does not allow",
                package.name, package.version
            ));
        }
    }
    Ok(())
}

/// The crates that are linked into `product`, a crate of the workspace.
fn linked<'m>(metadata: &'m Metadata, product: &str) -> Result<Vec<&'m Package>> {
    let graph = metadata
        .resolve
        .as_ref()
        .context("cargo metadata gave no graph")?;
    let nodes: BTreeMap<_, _> = graph.nodes.iter().map(|node| (&node.id, node)).collect();
    let of_product = metadata
        .workspace_packages()
        .into_iter()
        .find(|package| package.name.as_str() == product);
    let mut open = vec![
        &of_product
            .with_context(|| format!("there is no {product}"))?
            .id,
    ];
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let normal = |dependency: &&cargo_metadata::NodeDep| {
            dependency
                .dep_kinds
                .iter()
                .any(|kind| kind.kind != DependencyKind::Development)
        };
        open.extend(
            nodes[id]
                .deps
                .iter()
                .filter(normal)
                .map(|dependency| &dependency.pkg),
        );
    }
    Ok(metadata
        .packages
        .iter()
        .filter(|package| seen.contains(&package.id))
        .collect())
}

/// No file above the length limit, no leftover to-do, no path of one machine.
fn files(root: &Path, findings: &mut Findings) -> Result<()> {
    // Written in two parts, so that this file does not find itself.
    let left_undone = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("unimpl", "emented!("),
    ];
    for file in rust_files(&root.join("crates"))? {
        let text = std::fs::read_to_string(&file)?;
        let place = shown(root, &file);
        if text.lines().count() > LONGEST_FILE {
            findings.add(format!(
                "{place} has more than {LONGEST_FILE} lines: split it"
            ));
        }
        for (line, content) in text.lines().enumerate() {
            if let Some(mark) = left_undone.iter().find(|mark| content.contains(**mark)) {
                findings.add(format!(
                    "{place}:{}: {mark}: do it, or open an issue",
                    line + 1
                ));
            }
        }
    }
    Ok(())
}

fn shown(root: &Path, file: &Path) -> String {
    file.strip_prefix(root)
        .unwrap_or(file)
        .display()
        .to_string()
}

/// Every code of a warning is declared once, and the page of the guide has them all.
fn check_warnings(root: &Path, findings: &mut Findings) -> Result<()> {
    let all = warnings::declared(&source::read(root)?)?;
    let mut seen = BTreeMap::new();
    for one in &all {
        if let Some(first) = seen.insert(&one.code, &one.of) {
            findings.add(format!(
                "{} and {} have a warning with the code `{}`: rename one of them",
                first, one.of, one.code
            ));
        }
    }
    let page = std::fs::read_to_string(root.join(warnings::PAGE)).unwrap_or_default();
    if page != warnings::page(&all) {
        findings.add(format!(
            "{}: is not that of the sources: run `cargo run -p xtask -- warnings`",
            warnings::PAGE
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_impure_or_undocumented_is_found() {
        let text = "// std::fs\nuse std::time::Instant;\n/// Sum.\npub fn of(force: f64) -> Result<f64, E> { g() }\n";
        assert_eq!(super::impure(text), [(2, "std::time")]);
        let mut findings = super::Findings::default();
        super::undocumented(text, "a.rs".into(), &mut findings).unwrap();
        assert_eq!(findings.0.len(), 3, "{:?}", findings.0);
    }

    /// Each science is looked at: a module that its table lacks would be found.
    #[test]
    fn all_sciences_are_there() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for science in super::SCIENCES {
            assert!(!super::rust_files(&root.join(science)).unwrap().is_empty());
        }
    }

    /// `./x test` runs this one before the others.
    #[test]
    fn all_invariants_hold() {
        let found: Vec<String> = super::findings().unwrap().into_iter().collect();
        assert!(found.is_empty(), "{}", found.join("\n"));
    }
}
