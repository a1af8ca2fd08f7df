//! The tests of a crate are one program, `tests/all.rs`, and cargo does not look for others: a file that nobody names would never run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use cargo_metadata::Metadata;

use super::{Findings, shown};

/// Every file of a crate's `tests` is a program of its own in the manifest, or a module of one.
pub(super) fn check(root: &Path, metadata: &Metadata, findings: &mut Findings) -> Result<()> {
    for package in metadata.workspace_packages() {
        let folder = package.manifest_path.as_std_path().with_file_name("tests");
        if !folder.is_dir() {
            continue;
        }
        let mut run = BTreeSet::new();
        for target in &package.targets {
            let program = target.src_path.as_std_path();
            if program.parent() == Some(&folder) {
                run.extend(modules(&std::fs::read_to_string(program)?, &folder));
                run.insert(program.to_owned());
            }
        }
        for entry in std::fs::read_dir(&folder)? {
            let file = entry?.path();
            if file.extension().is_some_and(|e| e == "rs") && !run.contains(&file) {
                findings.add(format!(
                    "{}: its tests never run: name it in tests/all.rs beside it",
                    shown(root, &file)
                ));
            }
        }
    }
    Ok(())
}

/// The files in `folder` of the modules that the text of a program there declares.
fn modules(text: &str, folder: &Path) -> Vec<PathBuf> {
    text.lines()
        .filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'))
        .map(|name| folder.join(format!("{name}.rs")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_tests_that_nobody_names_is_found() {
        let found = modules(
            "//! All.\n\nmod clocks;\n// mod out;\n#[path = \"x/mod.rs\"]\nmod x;\n",
            Path::new("tests"),
        );
        assert_eq!(
            found,
            [
                PathBuf::from("tests/clocks.rs"),
                PathBuf::from("tests/x.rs")
            ]
        );
    }
}
