//! A command joins request, value, document and rendering, and does nothing else: its `run` is short.

use std::path::Path;

use anyhow::{Context as _, Result};
use syn::spanned::Spanned as _;
use syn::visit::Visit;

use super::{Findings, rust_files, shown};

/// Where the commands stand.
const COMMANDS: &str = "crates/piezotact-app/src/commands";
/// The largest number of lines of a function `run`, from its signature to its closing brace.
const LONGEST_RUN: usize = 40;

/// Invariant 14: every `run` below the commands is short.
pub(super) fn check(root: &Path, findings: &mut Findings) -> Result<()> {
    for file in rust_files(&root.join(COMMANDS))? {
        let text = std::fs::read_to_string(&file)?;
        let place = shown(root, &file);
        for (line, lines) in runs(&text).with_context(|| place.clone())? {
            if lines > LONGEST_RUN {
                findings.add(format!(
                    "{place}:{line}: `run` has {lines} lines, more than {LONGEST_RUN}: name its parts, and move what it computes to the science"
                ));
            }
        }
    }
    Ok(())
}

/// The functions `run` of `text`: the line where each begins, and how many lines it has.
fn runs(text: &str) -> Result<Vec<(usize, usize)>> {
    let mut found = Runs(Vec::new());
    found.visit_file(&syn::parse_file(text)?);
    Ok(found.0)
}

struct Runs(Vec<(usize, usize)>);

impl<'ast> Visit<'ast> for Runs {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if item.sig.ident == "run" {
            let first = item.sig.span().start().line;
            let last = item.block.span().end().line;
            self.0.push((first, last + 1 - first));
        }
        syn::visit::visit_item_fn(self, item);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_counted_from_its_signature_to_its_end() {
        let lines = "    step();\n".repeat(LONGEST_RUN - 2);
        let text = format!(
            "//! A command.\n\n/// Runs.\npub(crate) fn run() {{\n{lines}}}\n\nfn other() {{\n\n\n}}\n"
        );
        assert_eq!(runs(&text).unwrap(), [(4, LONGEST_RUN)]);
        let longer = text.replacen("step();", "step();\n    step();", 1);
        assert_eq!(runs(&longer).unwrap(), [(4, LONGEST_RUN + 1)]);
    }

    /// The folder that is searched is the one with the commands.
    #[test]
    fn the_commands_are_found() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let demo = root.join(COMMANDS).join("demo.rs");
        let text = std::fs::read_to_string(demo).unwrap();
        assert_eq!(runs(&text).unwrap().len(), 1);
    }
}
