//! `xtask warnings`: the page of the guide with all warnings, made of the enums that declare them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use syn::visit::Visit;

use crate::source::{self, Source};

/// The page, from the root of the project.
pub(crate) const PAGE: &str = "docs/guide/warnings.md";

/// A warning as its enum declares it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Declared {
    /// Its crate and its enum: `piezotact::RenderWarning`.
    pub(crate) of: String,
    pub(crate) code: String,
    /// When it is raised: the comment of the variant.
    when: String,
    /// Its sentence, with the names of what stands in it in italics.
    sentence: String,
}

/// Writes the page.
pub(crate) fn run() -> Result<()> {
    let root = source::root()?;
    let path = root.join(PAGE);
    std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
    let text = page(&declared(&source::read(&root)?)?);
    std::fs::write(&path, text).with_context(|| path.display().to_string())
}

/// All warnings: the variants of enums called `…Warning` that are written with their variant as `code`. A variant that holds an enum with
/// another tag, flattened, is one warning, whose sentence is followed by those of the values of the tag.
pub(crate) fn declared(sources: &[Source]) -> Result<Vec<Declared>> {
    let mut enums: Vec<(&str, syn::ItemEnum)> = Vec::new();
    for source in sources.iter().filter(|source| !source.is_all_test()) {
        if source.text.contains("#[serde(tag = \"") {
            let mut own = Enums(Vec::new());
            own.visit_file(&syn::parse2(source.tokens.clone())?);
            enums.extend(
                own.0
                    .into_iter()
                    .map(|item| (source.package.as_str(), item)),
            );
        }
    }
    let mut found = Vec::new();
    for (package, item) in &enums {
        if !item.ident.to_string().ends_with("Warning")
            || tag(&item.attrs)?.as_deref() != Some("code")
        {
            continue;
        }
        for variant in &item.variants {
            let mut sentence = sentence(variant)?;
            for field in &variant.fields {
                let Some(kind) = flattened(field)? else {
                    continue;
                };
                let inner = enums
                    .iter()
                    .filter(|(of, inner)| of == package && inner.ident == *kind);
                match inner.collect::<Vec<_>>().as_slice() {
                    [(_, inner)] => sentence += &causes(inner)?,
                    [] => {}
                    _ => bail!("{package} has two enums called {kind}"),
                }
            }
            found.push(Declared {
                of: format!("{package}::{}", item.ident),
                code: code(variant)?,
                when: comment(&variant.attrs),
                sentence,
            });
        }
    }
    Ok(found)
}

/// The values of the tag of `inner`, each with what it says, or with the first line of its comment.
fn causes(inner: &syn::ItemEnum) -> Result<String> {
    let Some(tag) = tag(&inner.attrs)? else {
        return Ok(String::new());
    };
    let mut causes = String::new();
    for variant in &inner.variants {
        let said = match sentence(variant)? {
            none if none.is_empty() => lines_of_comment(&variant.attrs).into_iter().next(),
            said => Some(said),
        };
        let _never_fails = write!(
            causes,
            "<br>`{tag}` = `{}`: {}",
            code(variant)?,
            said.unwrap_or_default()
        );
    }
    Ok(causes)
}

/// The tag with which serde writes the variants of an enum.
fn tag(attributes: &[syn::Attribute]) -> Result<Option<String>> {
    Ok(in_serde(attributes, "tag")?.flatten())
}

/// The type of a field that is written flattened.
fn flattened(field: &syn::Field) -> Result<Option<&syn::Ident>> {
    let syn::Type::Path(path) = &field.ty else {
        return Ok(None);
    };
    let is_flat = in_serde(&field.attrs, "flatten")?.is_some();
    let kind = path.path.segments.last().filter(|_| is_flat);
    Ok(kind.map(|segment| &segment.ident))
}

/// The entry `name` of the attribute `serde`, with its text where it is `name = "…"`.
fn in_serde(attributes: &[syn::Attribute], name: &str) -> Result<Option<Option<String>>> {
    let mut found = None;
    for attribute in attributes.iter().filter(|one| one.path().is_ident("serde")) {
        attribute.parse_nested_meta(|meta| {
            let text = match meta.input.peek(syn::Token![=]) {
                true => Some(meta.value()?.parse::<syn::LitStr>()?.value()),
                false => None,
            };
            if meta.path.is_ident(name) {
                found = Some(text);
            }
            Ok(())
        })?;
    }
    Ok(found)
}

/// The page with `all`: a table for each enum.
pub(crate) fn page(all: &[Declared]) -> String {
    let mut by_enum: BTreeMap<&str, Vec<&Declared>> = BTreeMap::new();
    for one in all {
        by_enum.entry(&one.of).or_default().push(one);
    }
    let mut page = format!(
        "# Warnings\n\nA warning says what a person should know before relying on a result, and what to do. It never changes an exit code. In documents \
         (`--json`) it has its `code`, its values and its sentence, `text`. There are {} codes. `cargo run -p xtask -- warnings` makes this page of the \
         sources.\n",
        all.len()
    );
    for (of, warnings) in by_enum {
        let _never_fails = write!(
            page,
            "\n## {of}\n\n| code | when | what it says, and what to do |\n|---|---|---|\n"
        );
        for one in warnings {
            let cell = |text: &str| {
                text.replace('|', "\\|")
                    .replace("[`", "`")
                    .replace("`]", "`")
            };
            let _never_fails = writeln!(
                page,
                "| `{}` | {} | {} |",
                one.code,
                cell(&one.when),
                cell(&one.sentence)
            );
        }
    }
    page
}

struct Enums(Vec<syn::ItemEnum>);

impl<'ast> Visit<'ast> for Enums {
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.0.push(item.clone());
    }
}

/// The name in which serde writes a variant.
fn code(variant: &syn::Variant) -> Result<String> {
    if let Some(Some(renamed)) = in_serde(&variant.attrs, "rename")? {
        return Ok(renamed);
    }
    let mut snake = String::new();
    for sign in variant.ident.to_string().chars() {
        if sign.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(sign.to_lowercase());
    }
    Ok(snake)
}

/// A comment as one line.
fn comment(attributes: &[syn::Attribute]) -> String {
    lines_of_comment(attributes).join(" ")
}

fn lines_of_comment(attributes: &[syn::Attribute]) -> Vec<String> {
    let lines = attributes.iter().filter_map(|attribute| {
        let syn::Meta::NameValue(pair) = &attribute.meta else {
            return None;
        };
        match &pair.value {
            syn::Expr::Lit(syn::ExprLit {
                lit: syn::Lit::Str(text),
                ..
            }) if pair.path.is_ident("doc") => Some(text.value().trim().to_owned()),
            _ => None,
        }
    });
    lines.collect()
}

/// The sentence of a variant: the text of its `#[error(…)]`, with names in the place of values.
fn sentence(variant: &syn::Variant) -> Result<String> {
    let Some(attribute) = (variant.attrs.iter()).find(|one| one.path().is_ident("error")) else {
        return Ok(String::new());
    };
    let Format { text, values } = attribute.parse_args()?;
    let mut values = values.iter();
    let mut sentence = String::new();
    let mut rest = text.value();
    while let Some(open) = rest.find('{') {
        let close = rest[open..].find('}').map_or(rest.len(), |at| open + at);
        let name = rest[open + 1..close].split(':').next().unwrap_or_default();
        let name = match name {
            "" => values.next().and_then(first_name).unwrap_or_default(),
            name => name.to_owned(),
        };
        sentence.push_str(&rest[..open]);
        if sentence.ends_with(|sign: char| sign == '*' || sign.is_alphanumeric()) {
            sentence.push(' ');
        }
        let _never_fails = write!(sentence, "*{}*", name.replace('_', " "));
        rest = rest[(close + 1).min(rest.len())..].to_owned();
        if rest.starts_with(char::is_alphanumeric) {
            sentence.push(' ');
        }
    }
    Ok(sentence + &rest)
}

/// What stands in `#[error(…)]`: a text, and values for it.
struct Format {
    text: syn::LitStr,
    values: Vec<syn::Expr>,
}

impl syn::parse::Parse for Format {
    fn parse(input: syn::parse::ParseStream<'_>) -> syn::Result<Self> {
        let text = input.parse()?;
        let mut values = Vec::new();
        while input.parse::<Option<syn::Token![,]>>()?.is_some() && !input.is_empty() {
            let name = input.peek(syn::Ident)
                && input.peek2(syn::Token![=])
                && !input.peek2(syn::Token![==]);
            if name {
                input.parse::<syn::Ident>()?;
                input.parse::<syn::Token![=]>()?;
                input.parse::<syn::Expr>()?;
                continue;
            }
            values.push(input.parse()?);
        }
        Ok(Self { text, values })
    }
}

/// The first field that an expression names: not a function, and not a part of a path.
fn first_name(expression: &syn::Expr) -> Option<String> {
    let mut first = First(None);
    first.visit_expr(expression);
    first.0
}

struct First(Option<String>);

impl<'ast> Visit<'ast> for First {
    fn visit_expr_call(&mut self, call: &'ast syn::ExprCall) {
        call.args
            .iter()
            .for_each(|argument| self.visit_expr(argument));
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if call.method == "advice" {
            self.0.get_or_insert_with(|| "what to do".to_owned());
        }
        self.visit_expr(&call.receiver);
    }

    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        if let Some(name) = path.path.get_ident() {
            self.0.get_or_insert_with(|| name.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::tests::made_up;

    #[test]
    fn a_warning_is_read_from_its_enum() {
        let sources = made_up(&[(
            "crates/piezotact/src/render.rs",
            "/// W.\n#[derive(Serialize, thiserror::Error)]\n#[serde(tag = \"code\", rename_all = \"snake_case\")]\npub enum RenderWarning {\n\
             /// Much is\n/// left out.\n#[error(\"in {} of {band_hz:.1}: {x}\", percent(*share), x = rounded(*x))]\nLeftOut { share: f64, band_hz: f64, x: f64 },\n\
             /// Other.\n#[error(\"none\")]\n#[serde(rename = \"other_code\")]\nOther,\n\
             /// Two.\n#[error(\"{fault}; {}\", fault.advice())]\nFailed { load_n: f64, #[serde(flatten)] fault: Fault },\n}\n\
             #[serde(tag = \"code\")]\npub enum Cause { A }\n\
             #[serde(tag = \"fault\", rename_all = \"snake_case\")]\npub enum Fault {\n/// The sensor\n/// clips.\nAtLimit,\n\
             /// Noise.\n#[serde(rename = \"noise_only\")]\nNoise { share: f64 },\n}\n",
        )]);
        let all = declared(&sources).unwrap();
        let expected = |code: &str, when: &str, sentence: &str| Declared {
            of: "piezotact::RenderWarning".into(),
            code: code.into(),
            when: when.into(),
            sentence: sentence.into(),
        };
        assert_eq!(
            all,
            [
                expected(
                    "left_out",
                    "Much is left out.",
                    "in *share* of *band hz*: *x*"
                ),
                expected("other_code", "Other.", "none"),
                expected(
                    "failed",
                    "Two.",
                    "*fault*; *what to do*<br>`fault` = `at_limit`: The sensor<br>`fault` = `noise_only`: Noise."
                ),
            ]
        );
        let page = page(&all);
        assert!(
            page.contains("There are 3 codes.")
                && page.contains("| `other_code` | Other. | none |"),
            "{page}"
        );
    }
}
