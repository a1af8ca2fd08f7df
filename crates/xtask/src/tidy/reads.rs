//! Files are read in one place, which notes what was read: results state the files that they were made from.

use std::path::Path;

use anyhow::Result;

use super::{Findings, rust_files, shown};

/// Where files of a person are read.
const SOURCES: [&str; 5] = [
    "crates/piezotact-dataset/src",
    "crates/piezotact-study/src",
    "crates/piezotact-surface/src",
    "crates/piezotact-app/src/commands",
    "crates/piezotact-app/src/benches",
];
/// The place that notes them, and what reads only files that the program itself writes.
const ALLOWED: [&str; 6] = [
    "crates/piezotact-dataset/src/reads.rs",
    "crates/piezotact-dataset/src/atomic.rs",
    "crates/piezotact-dataset/src/lock.rs",
    "crates/piezotact-dataset/src/journal/",
    // The store: who the participants are is nothing that a result is made from.
    "crates/piezotact-study/src/store/",
    "crates/piezotact-app/src/commands/rerun/",
];
/// What reads a file.
const READING: [&str; 3] = ["fs::read(", "fs::read_to_string(", "File::open("];

/// docs/decisions/documents.md: no file is read past `piezotact_dataset::reads`.
pub(super) fn check(root: &Path, findings: &mut Findings) -> Result<()> {
    for source in SOURCES {
        for file in rust_files(&root.join(source))? {
            let place = shown(root, &file);
            if place.ends_with("tests.rs") || ALLOWED.iter().any(|own| place.starts_with(own)) {
                continue;
            }
            for (line, what) in reading(&std::fs::read_to_string(&file)?) {
                findings.add(format!(
                    "{place}:{line}: `{what}…)` reads a file that results do not state: use `piezotact_dataset::reads`"
                ));
            }
        }
    }
    Ok(())
}

/// The lines of `text` before its tests that read a file, with how.
fn reading(text: &str) -> Vec<(usize, &'static str)> {
    let code = text.lines().take_while(|line| *line != "#[cfg(test)]");
    let found = code.enumerate().filter_map(|(i, line)| {
        let what = READING.iter().find(|what| line.contains(**what))?;
        Some((i + 1, *what))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_past_the_notes_is_found_outside_of_tests() {
        let text = "let a = std::fs::read(path)?;\nlet b = reads::read(path)?;\nFile::open(x);\n#[cfg(test)]\nfs::read_to_string(x);\n";
        assert_eq!(reading(text), [(1, "fs::read("), (3, "File::open(")]);
    }
}
