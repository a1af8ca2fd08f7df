//! Every public item is documented, but for fields, whose names say what they are.
//!
//! The check of the compiler, `missing_docs`, knows no exception for fields. As there, `#[allow(missing_docs, reason = "…")]` exempts
//! an item with all that is in it. Items that a macro makes are not seen.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use proc_macro2::Ident;
use syn::visit::Visit;
use syn::{Attribute, Visibility};

use super::Findings;
use crate::source::{Source, modules_below};

/// Every public module, type, variant, trait, function, method, constant and macro of `sources` has documentation, and every crate.
pub(super) fn check(sources: &[Source], findings: &mut Findings) -> Result<()> {
    for source in sources.iter().filter(|source| !source.is_all_test()) {
        let file: syn::File = syn::parse2(source.tokens.clone())
            .with_context(|| source.path.display().to_string())?;
        let is_root = source.path.ends_with("src/lib.rs") || source.path.ends_with("src/main.rs");
        if is_root && !documented(&file.attrs) {
            findings.add(format!(
                "{}: the crate has no documentation: say what it holds",
                source.path.display()
            ));
        }
        Undocumented {
            source,
            sources,
            findings,
        }
        .visit_file(&file);
    }
    Ok(())
}

struct Undocumented<'a> {
    source: &'a Source,
    sources: &'a [Source],
    findings: &'a mut Findings,
}

impl Undocumented<'_> {
    fn public(&mut self, visibility: &Visibility, attributes: &[Attribute], name: &Ident) {
        if matches!(visibility, Visibility::Public(_)) {
            self.item(attributes, name);
        }
    }

    fn item(&mut self, attributes: &[Attribute], name: &Ident) {
        let line = name.span().start().line;
        if !documented(attributes) && !exempt(attributes) && !self.source.is_test(line) {
            self.findings.add(format!(
                "{}:{line}: {name} is public and has no documentation: say what it is",
                self.source.path.display()
            ));
        }
    }

    /// Whether the file of the module `name` begins with documentation.
    fn documented_in_file(&self, name: &Ident) -> bool {
        let below = modules_below(&self.source.path);
        let files: [PathBuf; 2] = [
            below.join(format!("{name}.rs")),
            below.join(name.to_string()).join("mod.rs"),
        ];
        let mut found = self
            .sources
            .iter()
            .filter(|source| files.contains(&source.path));
        found.any(|source| source.text.starts_with("//!"))
    }
}

impl<'ast> Visit<'ast> for Undocumented<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if exempt(&item.attrs) {
            return;
        }
        if item.content.is_some() || !self.documented_in_file(&item.ident) {
            self.public(&item.vis, &item.attrs, &item.ident);
        }
        syn::visit::visit_item_mod(self, item);
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.public(&item.vis, &item.attrs, &item.ident);
        if !exempt(&item.attrs) {
            for variant in &item.variants {
                self.public(&item.vis, &variant.attrs, &variant.ident);
            }
        }
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.public(&item.vis, &item.attrs, &item.ident);
        if exempt(&item.attrs) {
            return;
        }
        for inner in &item.items {
            match inner {
                syn::TraitItem::Fn(inner) => self.public(&item.vis, &inner.attrs, &inner.sig.ident),
                syn::TraitItem::Const(inner) => self.public(&item.vis, &inner.attrs, &inner.ident),
                syn::TraitItem::Type(inner) => self.public(&item.vis, &inner.attrs, &inner.ident),
                _ => {}
            }
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if item.trait_.is_none() && !exempt(&item.attrs) {
            syn::visit::visit_item_impl(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.public(&item.vis, &item.attrs, &item.sig.ident);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.public(&item.vis, &item.attrs, &item.sig.ident);
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_item_union(&mut self, item: &'ast syn::ItemUnion) {
        self.public(&item.vis, &item.attrs, &item.ident);
    }

    fn visit_item_macro(&mut self, item: &'ast syn::ItemMacro) {
        let exported = item
            .attrs
            .iter()
            .any(|attribute| attribute.path().is_ident("macro_export"));
        if let Some(name) = item.ident.as_ref().filter(|_| exported) {
            self.item(&item.attrs, name);
        }
    }
}

fn documented(attributes: &[Attribute]) -> bool {
    attributes
        .iter()
        .any(|attribute| attribute.path().is_ident("doc"))
}

fn exempt(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let mut found = false;
        if attribute.path().is_ident("allow") {
            // What is no name, such as a reason, ends the search.
            let _ = attribute.parse_nested_meta(|lint| {
                found |= lint.path.is_ident("missing_docs");
                Ok(())
            });
        }
        found
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::tests::made_up;

    #[test]
    fn all_but_fields_are_documented() {
        let sources = made_up(&[
            (
                "crates/a/src/lib.rs",
                "pub mod said;\npub mod not_said;\nmod private;\npub struct S { pub x: u8 }\n/// E.\npub enum E { A { x: u8 } }\n\
                 #[allow(missing_docs, reason = \"their names\")]\n/// F.\npub enum F { X }\npub(crate) fn f() {}\n\
                 impl S { pub fn m(&self) {} fn n(&self) {} }\nimpl Clone for S { fn clone(&self) -> Self { S } }\n\
                 /// T.\npub trait T { fn t(&self); }\n#[macro_export]\nmacro_rules! exported { () => {} }\n\
                 #[cfg(test)]\npub mod tests { pub fn t() {} }\n",
            ),
            (
                "crates/a/src/said.rs",
                "//! Said.\npub const C: u8 = 1;\npub type B = u8;\n",
            ),
            ("crates/a/src/not_said/mod.rs", "fn f() { fn g() {} }\n"),
        ]);
        let mut findings = Findings::default();
        check(&sources, &mut findings).unwrap();
        let found: String = findings.0.into_iter().collect::<Vec<_>>().join("\n");
        let names = [
            "crate", "not_said", "S", "A", "m", "t", "exported", "C", "B",
        ];
        for name in names {
            assert!(found.contains(&format!(" {name} ")), "{name}: {found}");
        }
        assert_eq!(found.lines().count(), names.len(), "{found}");
    }
}
