//! `xtask unused`: public items that nobody calls, or tests alone.
//!
//! What is compared are names, in the tokens of all source: an item is listed when its name stands outside test code only where
//! it is defined and passed on (`pub use`, `impl` of the type). The check does not know which item a name means, so an unused item with a common
//! name (`new`, `write`) is missed. What only unused items use is found when these are gone.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result};
use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use syn::visit::Visit;

use crate::source::{self, Source};

/// Names of items that stay although nobody uses them, and why.
const KEPT: [(&str, &str); 3] = [
    ("of_acquirer", "the conformance of benches is for tests"),
    ("with_tone", "the conformance of benches is for tests"),
    (
        "with_work_factor",
        "tests of many passphrases would take minutes",
    ),
];

/// Lists the public items that are not used.
#[allow(clippy::print_stdout, reason = "its result is a list")]
pub(crate) fn run() -> Result<()> {
    let sources = source::read(&source::root()?)?;
    let unused = unused(&sources)?;
    for (name, why) in KEPT {
        if !unused.iter().any(|item| item.name == name) {
            println!("{name} is used or gone: take it out of KEPT ({why})");
        }
    }
    let listed: Vec<&Unused> = unused
        .iter()
        .filter(|item| KEPT.iter().all(|(name, _)| item.name != *name))
        .collect();
    for item in &listed {
        let Unused {
            at,
            kind,
            name,
            users,
        } = item;
        println!("{at}: {kind} {name}: {users}");
    }
    println!("{} public items are not used", listed.len());
    Ok(())
}

/// An item whose name stands nowhere else outside test code.
#[derive(Debug, PartialEq, Eq)]
struct Unused {
    at: String,
    kind: &'static str,
    name: String,
    users: &'static str,
}

fn unused(sources: &[Source]) -> Result<Vec<Unused>> {
    let mut items = Vec::new();
    let mut names = Names::default();
    for source in sources {
        let mut definitions = Definitions::default();
        let file = syn::parse2(source.tokens.clone());
        definitions.visit_file(&file.with_context(|| source.path.display().to_string())?);
        let public = definitions.public.into_iter();
        items.extend(public.filter_map(|(kind, name)| {
            let line = name.span().start().line;
            let at = format!("{}:{line}", source.path.display());
            (!source.is_test(line)).then(|| (at, kind, name.to_string()))
        }));
        names.take(
            source,
            source.tokens.clone(),
            &definitions.no_uses,
            Strings::Code,
        );
    }
    let found = items
        .into_iter()
        .filter(|(_, _, name)| !names.used.contains(name));
    Ok(found
        .map(|(at, kind, name)| Unused {
            users: match names.used_by_tests.contains(&name) {
                true => "only tests use it",
                false => "nobody uses it",
            },
            at,
            kind,
            name,
        })
        .collect())
}

/// The items of a file.
#[derive(Default)]
struct Definitions {
    public: Vec<(&'static str, Ident)>,
    /// Where names stand that are no uses: definitions, what is passed on, and types whose methods follow.
    no_uses: BTreeSet<Place>,
}

/// Line and column.
type Place = (usize, usize);

fn place(span: Span) -> Place {
    (span.start().line, span.start().column)
}

impl Definitions {
    fn define(&mut self, kind: &'static str, visibility: &syn::Visibility, name: &Ident) {
        self.no_uses.insert(place(name.span()));
        if matches!(visibility, syn::Visibility::Public(_)) {
            self.public.push((kind, name.clone()));
        }
    }
}

impl<'ast> Visit<'ast> for Definitions {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.define("fn", &item.vis, &item.sig.ident);
        syn::visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.define("method", &item.vis, &item.sig.ident);
        syn::visit::visit_impl_item_fn(self, item);
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.define("struct", &item.vis, &item.ident);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.define("enum", &item.vis, &item.ident);
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.define("const", &item.vis, &item.ident);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.define("const", &item.vis, &item.ident);
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.define("static", &item.vis, &item.ident);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.define("type", &item.vis, &item.ident);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.define("trait", &item.vis, &item.ident);
        for inner in &item.items {
            if let syn::TraitItem::Fn(method) = inner {
                self.define("method", &item.vis, &method.sig.ident);
            }
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if let syn::Type::Path(of) = &*item.self_ty {
            let name = of.path.segments.last();
            self.no_uses
                .extend(name.map(|segment| place(segment.ident.span())));
        }
        syn::visit::visit_item_impl(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !matches!(item.vis, syn::Visibility::Inherited) {
            self.visit_use_tree(&item.tree);
        }
    }

    fn visit_use_name(&mut self, passed_on: &'ast syn::UseName) {
        self.no_uses.insert(place(passed_on.ident.span()));
    }

    fn visit_use_rename(&mut self, passed_on: &'ast syn::UseRename) {
        self.no_uses.insert(place(passed_on.ident.span()));
    }
}

/// The names that source uses.
#[derive(Default)]
struct Names {
    used: BTreeSet<String>,
    used_by_tests: BTreeSet<String>,
}

/// What of a string is a name.
#[derive(Clone, Copy)]
enum Strings {
    /// `"{name}"`
    Code,
    /// `#[serde(default = "name")]`: every word.
    Attribute,
}

impl Names {
    fn take(
        &mut self,
        source: &Source,
        tokens: TokenStream,
        no_uses: &BTreeSet<Place>,
        strings: Strings,
    ) {
        let mut after_hash = false;
        for token in tokens {
            let line = token.span().start().line;
            let names = match source.is_test(line) {
                true => &mut self.used_by_tests,
                false => &mut self.used,
            };
            let inside = match after_hash {
                true => Strings::Attribute,
                false => strings,
            };
            after_hash = matches!(&token, TokenTree::Punct(p) if p.as_char() == '#' || after_hash && p.as_char() == '!');
            match token {
                TokenTree::Ident(name) if !no_uses.contains(&place(name.span())) => {
                    names.insert(name.to_string());
                }
                TokenTree::Literal(literal) => names.extend(words(&literal.to_string(), strings)),
                TokenTree::Group(group) if !is_doc(&group.stream()) => {
                    self.take(source, group.stream(), no_uses, inside);
                }
                _ => {}
            }
        }
    }
}

/// Whether an attribute is documentation.
fn is_doc(attribute: &TokenStream) -> bool {
    let mut tokens = attribute.clone().into_iter();
    matches!(tokens.next(), Some(TokenTree::Ident(word)) if word == "doc")
        && matches!(tokens.next(), Some(TokenTree::Punct(sign)) if sign.as_char() == '=')
}

/// The names in a string.
fn words(literal: &str, strings: Strings) -> Vec<String> {
    let word = |text: &str| {
        text.split(|c: char| !c.is_alphanumeric() && c != '_')
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    match strings {
        Strings::Code => literal.split('{').skip(1).map(word).collect(),
        Strings::Attribute => literal
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .map(str::to_owned)
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::tests::made_up;

    #[test]
    fn what_nobody_or_tests_alone_use_is_found() {
        let sources = made_up(&[
            (
                "crates/a/src/lib.rs",
                "pub mod b;\npub use b::{Passed, lonely};\n#[cfg(test)]\nmod tests { pub fn own() {} fn t() { tested(); } }\n",
            ),
            (
                "crates/a/src/b.rs",
                "/// Like lonely.\npub fn lonely() {}\npub fn tested() {}\npub struct Passed;\nimpl Passed { pub fn method(&self) {} }\n\
                 impl Show for Passed { fn show(&self) {} }\npub trait Show { fn show(&self); }\n\
                 pub fn by_string() {}\npub const LEAST: u8 = 1;\npub fn in_macro() {}\n\
                 #[serde(default = \"by_string\")]\nstruct X;\nfn f() { println!(\"{LEAST:3} Passed\"); m! { in_macro() } }\n",
            ),
            ("crates/xtask/src/main.rs", "fn main() { a.method(); }\n"),
        ]);
        let found = unused(&sources).unwrap();
        let found: Vec<(&str, &str, &str)> = found
            .iter()
            .map(|item| (item.at.as_str(), item.name.as_str(), item.users))
            .collect();
        assert_eq!(
            found,
            [
                ("crates/a/src/b.rs:2", "lonely", "nobody uses it"),
                ("crates/a/src/b.rs:3", "tested", "only tests use it"),
                ("crates/a/src/b.rs:4", "Passed", "nobody uses it"),
                ("crates/a/src/b.rs:7", "show", "nobody uses it"),
            ]
        );
    }
}
