//! Decisions stand in chapters, and every citation of one leads to a chapter.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::{Findings, shown};

const FOLDER: &str = "docs/decisions/";
/// The list of the chapters.
const INDEX: &str = "README.md";
const LONGEST_CHAPTER: usize = 130;
/// What cites: sources, documents, scripts and settings.
const CITING: [&str; 6] = ["rs", "md", "toml", "py", "mjs", "R"];
/// Folders that are not of the project.
const FOREIGN: [&str; 3] = [".git", "target", "node_modules"];

/// Each chapter has a title, is short and is listed; each citation names a chapter that exists.
pub(super) fn check(root: &Path, findings: &mut Findings) -> Result<()> {
    let folder = root.join(FOLDER);
    let index =
        std::fs::read_to_string(folder.join(INDEX)).with_context(|| format!("{FOLDER}{INDEX}"))?;
    let mut chapters = BTreeSet::new();
    for entry in std::fs::read_dir(&folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(&path)?;
        for fault in faults(&name, &text, &index) {
            findings.add(format!("{FOLDER}{name} {fault}"));
        }
        chapters.insert(name.into_owned());
    }
    for file in citing(root)? {
        // What is no text cites nothing.
        let Ok(text) = std::fs::read_to_string(&file) else {
            continue;
        };
        for (line, fault) in wrong_citations(&text, &chapters) {
            findings.add(format!("{}:{line}: {fault}", shown(root, &file)));
        }
    }
    Ok(())
}

/// What is wrong with the form of a chapter.
fn faults(name: &str, text: &str, index: &str) -> Vec<String> {
    let mut faults = Vec::new();
    if !text.starts_with("# ") {
        faults.push("has no title: begin with `# `".to_owned());
    }
    if text.lines().count() > LONGEST_CHAPTER {
        faults.push(format!(
            "has more than {LONGEST_CHAPTER} lines: shorten or split it"
        ));
    }
    if name != INDEX && !index.contains(&format!("({name})")) {
        faults.push(format!("is not listed in {FOLDER}{INDEX}"));
    }
    faults
}

/// The lines of `text` that cite a decision by its number, or a chapter that does not exist.
fn wrong_citations(text: &str, chapters: &BTreeSet<String>) -> Vec<(usize, String)> {
    let mut wrong = Vec::new();
    for (i, line) in text.lines().enumerate() {
        for rest in line.split(FOLDER).skip(1) {
            let end = rest
                .find(|c: char| !(c.is_ascii_alphanumeric() || "-_.".contains(c)))
                .unwrap_or(rest.len());
            let name = rest[..end].trim_end_matches('.');
            if !name.is_empty() && !chapters.contains(name) {
                wrong.push((i + 1, format!("{FOLDER}{name} does not exist")));
            }
        }
        let lower = line.to_lowercase();
        let is_numbered = lower.split("decision").skip(1).any(|rest| {
            let number = rest.strip_prefix('s').unwrap_or(rest).strip_prefix(' ');
            number.is_some_and(|number| number.starts_with(|c: char| c.is_ascii_digit()))
        });
        if is_numbered {
            wrong.push((
                i + 1,
                format!("decisions have no numbers: cite a chapter of {FOLDER}"),
            ));
        }
    }
    wrong
}

/// The files below `folder` that may cite.
fn citing(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_symlink() || FOREIGN.iter().any(|foreign| path.ends_with(foreign)) {
            continue;
        }
        if path.is_dir() {
            files.extend(citing(&path)?);
        } else if path
            .extension()
            .is_none_or(|extension| CITING.iter().any(|of| extension.eq_ignore_ascii_case(of)))
        {
            files.push(path);
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chapters_without_form_and_citations_without_chapter_are_found() {
        let index = "# Decisions\n- [Rendering](rendering.md)\n";
        assert!(faults("rendering.md", "# Rendering\n", index).is_empty());
        assert_eq!(faults("eeg.md", &"line\n".repeat(131), index).len(), 3);

        let chapters = BTreeSet::from(["rendering.md".to_owned()]);
        // Written in parts, so that this file does not find itself.
        let text = [
            concat!("/// Source: docs/deci", "sions/rendering.md."),
            concat!("docs/deci", "sions/ has chapters; a decision of 2 people"),
            concat!("(docs/deci", "sions/eeg.md)"),
            concat!("docs/deci", "sions/0012"),
            concat!("Deci", "sion 0012 of this project"),
            concat!("deci", "sions 12 and 13"),
        ];
        let lines: Vec<usize> = wrong_citations(&text.join("\n"), &chapters)
            .into_iter()
            .map(|(line, _)| line)
            .collect();
        assert_eq!(lines, [3, 4, 5, 6]);
    }
}
