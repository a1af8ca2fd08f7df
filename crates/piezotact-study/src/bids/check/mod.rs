//! Checks what a data set says, beyond what the official validators look at: every cell of every table, sidecars against samples,
//! people, and answers against what could be answered.
//!
//! The limits are those of BIDS 1.11 and of docs/decisions/store.md. What is not looked at is said.

mod answers;
mod both;
mod eeg;
mod people;
mod signals;
mod tables;

use std::collections::{BTreeMap, BTreeSet};
use std::io::BufReader;
use std::path::Path;

use piezotact::criterion::Outcome;
use piezotact::document::Content;
use serde::{Deserialize, Serialize};

use super::error::BidsError;
use super::name::DATATYPES;
use super::read::{BidsFolder, require_one, two_studies};
use super::table::Lines;
use super::tree::{Entry, Tree};
use super::{CHECKSUMS, DESCRIPTION};
use piezotact_dataset::open_input;
use piezotact_dataset::reads::sha256_of_file;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ProblemKind {
    /// No data set, a half-written one, or several.
    Dataset,
    /// A name that is none of BIDS.
    Name,
    /// A file that the list of checksums names is missing.
    Missing,
    /// A file as it was recorded was changed.
    Changed,
    /// A sidecar is missing.
    Sidecar,
    /// A sidecar lacks something, or says something that cannot be.
    Metadata,
    /// Another number of columns than stated.
    Columns,
    /// Compressed data that cannot be read to its end.
    Compression,
    /// No samples, or no rows.
    Empty,
    /// A line with too few or too many cells.
    Ragged,
    /// No number where one is expected.
    Number,
    /// A value that is none of the listed ones.
    Level,
    /// A negative duration.
    Duration,
    /// An event after the end of what was recorded.
    Onset,
    /// A participant without a row, or a row without a participant.
    Participant,
    /// Something stands twice that may stand once.
    Twice,
    /// Something that tells who somebody is.
    Privacy,
    /// A file that is named and not there.
    File,
    /// An answer that was not offered.
    Response,
    /// Right and wrong exchanged.
    Correct,
    /// An order that is none.
    Ranking,
    /// Files of two studies.
    Study,
    /// Samples of EEG that cannot be read, or fewer or more than stated.
    Samples,
}

/// Something that is wrong with a data set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Problem {
    /// What kind of thing.
    pub kind: ProblemKind,
    /// The file, from the root.
    pub file: String,
    /// The line, from 1; absent where it is about the whole file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// What was expected, what was found, and what to do.
    pub text: String,
}

impl Problem {
    /// The file, with the line where it is about one.
    pub(super) fn place(&self) -> String {
        let file = plain(&self.file);
        match self.line {
            Some(line) => format!("{file}:{line}"),
            None => file,
        }
    }

    /// What was expected, what was found, and what to do, without control characters.
    pub(super) fn text(&self) -> String {
        plain(&self.text)
    }
}

/// A text of a foreign file, whose control characters do nothing to a terminal.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign.is_control() {
            true => plain.extend(sign.escape_default()),
            false => plain.push(sign),
        }
    }
    plain
}

/// What was found in a data set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Checked {
    /// Met where nothing is wrong in what was looked at; not decided where nothing was looked at.
    pub outcome: Outcome,
    /// What is wrong, file by file.
    pub problems: Vec<Problem>,
    /// How many more were found of a kind in a file than are listed.
    pub more: usize,
    /// How many tables were read.
    pub tables: usize,
    /// How many files of signals were read.
    pub signals: usize,
    /// How many files hold data that this check does not read, by kind of data.
    pub not_read: BTreeMap<String, usize>,
    /// What the official validator found; absent where it was not to be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_opinion: Option<SecondOpinion>,
}

/// What another validator found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SecondOpinion {
    /// Its name.
    pub program: String,
    /// Errors, each with its file.
    pub errors: Vec<String>,
    /// How many warnings.
    pub warnings: usize,
    /// Why nothing is known of it; absent where it gave an answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
}

impl Content for Checked {
    const SCHEMA: &'static str = "bids_check";
}

/// Who wrote a data set: this program's hold to more than BIDS asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    Ours,
    Foreign,
}

/// No session lasts as long, in s: a week.
pub(super) const LONGEST_SESSION_S: f64 = 604_800.0;

/// What is said of a link to a file elsewhere.
pub(super) const LEADS_OUT: &str = "expected a file of the data set, found a link that leads out of it; copy the file into its place";

/// So many problems of one kind are listed of a file.
const MOST_OF_A_KIND: usize = 10;

/// Collects problems.
#[derive(Debug, Default)]
struct Found {
    problems: Vec<Problem>,
    counts: BTreeMap<(String, ProblemKind), usize>,
    more: usize,
}

impl Found {
    fn add(
        &mut self,
        kind: ProblemKind,
        file: &str,
        line: impl Into<Option<u64>>,
        text: impl Into<String>,
    ) {
        let count = self.counts.entry((file.to_owned(), kind)).or_default();
        *count += 1;
        if *count > MOST_OF_A_KIND {
            self.more += 1;
            return;
        }
        self.problems.push(Problem {
            kind,
            file: file.to_owned(),
            line: line.into(),
            text: text.into(),
        });
    }

    /// An error of reading as a problem.
    fn error(&mut self, kind: ProblemKind, file: &str, error: BidsError) {
        match error {
            BidsError::File { file, line, why } => self.add(kind, &file, line, why),
            other => self.add(kind, file, None, other.to_string()),
        }
    }
}

/// Checks the data set in `root`.
///
/// # Errors
/// [`BidsError::NoDataset`] where the folder cannot be read as one at all.
pub fn check(root: &Path) -> Result<Checked, BidsError> {
    let tree = Tree::of(root)?;
    let mut found = Found::default();
    match require_one(&tree) {
        Ok(()) => {}
        // A folder without anything of BIDS is another folder, not a faulty data set.
        Err(error) if !(tree.has(DESCRIPTION) || tree.entries.iter().any(is_of_participant)) => {
            return Err(error);
        }
        // The folder of one participant of a data set.
        Err(error) if tree.is_part() => return Err(error),
        Err(BidsError::NoDataset {
            found: what, todo, ..
        }) => {
            found.add(
                ProblemKind::Dataset,
                DESCRIPTION,
                None,
                format!("expected one data set, found {what}; {todo}"),
            );
        }
        Err(other) => return Err(other),
    }
    if tree.has(DESCRIPTION) {
        match tree.json(DESCRIPTION) {
            Err(error) => found.error(ProblemKind::Metadata, DESCRIPTION, error),
            Ok(stated) => {
                for key in ["Name", "BIDSVersion"] {
                    if super::tree::text(&stated, key).is_none() {
                        let why = format!("expected {key}, a text, found none; add it");
                        found.add(ProblemKind::Metadata, DESCRIPTION, None, why);
                    }
                }
            }
        }
    }
    if let Some((file, why)) = two_studies(&tree) {
        found.add(ProblemKind::Study, &file, None, why);
    }
    for file in &tree.outside {
        found.add(ProblemKind::File, file, None, LEADS_OUT);
    }
    let origin = match tree.is_ours() {
        true => Origin::Ours,
        false => Origin::Foreign,
    };
    names(&tree, &mut found);
    sidecars(&tree, &mut found);
    checksums(&tree, &mut found);
    people::check(&tree, origin, &mut found);
    let mut spans = signals::check(&tree, origin, &mut found);
    let brains = eeg::check(&tree, origin, &mut spans, &mut found);
    if origin == Origin::Ours {
        for (file, error) in BidsFolder::recordings_unlike(&tree) {
            // What cannot be read was named.
            if !found.problems.iter().any(|problem| problem.file == file) {
                found.error(ProblemKind::Changed, &file, error);
            }
        }
    }
    let tables = tables::check(&tree, origin, &spans, &mut found);
    let signals = tree
        .entries
        .iter()
        .filter(|entry| entry.is_signal())
        .count()
        + brains;
    found
        .problems
        .sort_by(|one, other| (&one.file, one.line).cmp(&(&other.file, other.line)));
    Ok(Checked {
        outcome: match (found.problems.is_empty(), tables + signals) {
            (false, _) => Outcome::NotMet,
            (true, 0) => Outcome::NotDecided,
            (true, _) => Outcome::Met,
        },
        problems: found.problems,
        more: found.more,
        tables,
        signals,
        not_read: not_read(&tree),
        second_opinion: None,
    })
}

fn is_of_participant(entry: &Entry) -> bool {
    entry.file.starts_with("sub-")
}

fn names(tree: &Tree, found: &mut Found) {
    for entry in &tree.entries {
        let rename = |why: &str| format!("{why}; rename the file");
        if let Some(folder) = odd_folder(entry) {
            let why = format!(
                "expected a folder of data such as beh or eeg, found {folder}; move the file, or list it in .bidsignore"
            );
            found.add(ProblemKind::Name, &entry.file, None, why);
        }
        match &entry.name {
            None => {}
            Some(Err(why)) => found.add(ProblemKind::Name, &entry.file, None, rename(why)),
            Some(Ok(name)) => {
                for (key, place) in [("sub", 0), ("ses", 1)] {
                    let folder = entry.file.split('/').nth(place).unwrap_or_default();
                    let in_folder = folder.strip_prefix(&format!("{key}-"));
                    let stated = name.label(key);
                    if is_of_participant(entry)
                        && in_folder != stated
                        && (in_folder.is_some() || stated.is_some())
                    {
                        let text = |label: Option<&str>| {
                            label.map_or("none".to_owned(), |label| format!("{key}-{label}"))
                        };
                        let why = format!(
                            "expected {} as its folder, found {}",
                            text(in_folder),
                            text(stated)
                        );
                        found.add(ProblemKind::Name, &entry.file, None, rename(&why));
                    }
                }
                if let Some(why) = entry
                    .datatype()
                    .and_then(|datatype| name.fault_in(datatype))
                {
                    found.add(ProblemKind::Name, &entry.file, None, rename(&why));
                }
            }
        }
    }
    // Some file systems take two names that differ in case alone for one.
    let mut known: BTreeMap<String, &str> = BTreeMap::new();
    let drives = tree
        .others
        .iter()
        .filter(|file| file.starts_with("stimuli/"));
    for file in tree.entries.iter().map(|entry| &entry.file).chain(drives) {
        if let Some(other) = known.insert(file.to_lowercase(), file) {
            let why = format!(
                "expected names that differ in more than small and capital letters, found {other}; rename one of them"
            );
            found.add(ProblemKind::Twice, file, None, why);
        }
    }
    // Folders that differ in case alone.
    let mut folders: BTreeMap<String, &str> = BTreeMap::new();
    let of_drives = tree
        .others
        .iter()
        .filter(|file| file.starts_with("stimuli/"));
    for folder in of_drives.filter_map(|file| Some(file.rsplit_once('/')?.0)) {
        let other = folders.entry(folder.to_lowercase()).or_insert(folder);
        if *other != folder {
            let why = format!(
                "expected folders that differ in more than small and capital letters, found {other}; rename one of them"
            );
            found.add(ProblemKind::Twice, folder, None, why);
        }
    }
    for file in tree
        .others
        .iter()
        .filter(|file| file.starts_with("stimuli/"))
    {
        if !tree.path(file).is_file() {
            let why =
                "expected a file, found a link that leads to none, or a device; restore the file";
            found.add(ProblemKind::File, file, None, why);
        }
    }
}

/// The folder of a file of a participant, where it is none of BIDS.
fn odd_folder(entry: &Entry) -> Option<&str> {
    let mut folders = entry.folder().split('/');
    let participant = folders.next()?;
    let mut folder = folders.next()?;
    if folder.starts_with("ses-") {
        folder = folders.next()?;
    }
    // Formats that are folders have an ending.
    let is_known = DATATYPES.contains(&folder) || folder.contains('.');
    (participant.starts_with("sub-") && !is_known).then_some(folder)
}

/// Sidecars that cannot be read, or that are beside no data.
fn sidecars(tree: &Tree, found: &mut Found) {
    let mut used: BTreeSet<&str> = BTreeSet::new();
    for entry in tree
        .entries
        .iter()
        .filter(|entry| !entry.file.ends_with(".json"))
    {
        used.extend(
            tree.sidecars(entry)
                .into_iter()
                .map(|sidecar| sidecar.file.as_str()),
        );
    }
    for entry in tree
        .entries
        .iter()
        .filter(|entry| entry.file.ends_with(".json"))
    {
        if let Err(error) = tree.json(&entry.file) {
            found.error(ProblemKind::Metadata, &entry.file, error);
        }
        let of_data = ["beh", "physio", "stim", "events"];
        let is_of_data = entry
            .parsed()
            .is_some_and(|name| of_data.contains(&name.suffix.as_str()));
        if is_of_data && !used.contains(entry.file.as_str()) {
            let why = "expected a data file that it describes, found none; restore the data file, or remove this one";
            found.add(ProblemKind::File, &entry.file, None, why);
        }
    }
}

/// The data of a data set that are missing or changed since they were exported.
pub(super) fn changes(tree: &Tree) -> Vec<Problem> {
    let mut found = Found::default();
    checksums(tree, &mut found);
    found.problems
}

/// Files that the list of checksums names and that are missing, and recordings that were changed.
fn checksums(tree: &Tree, found: &mut Found) {
    let lost =
        "expected the checksums of what was exported, found none; restore the file from a copy";
    if !tree.has(CHECKSUMS) {
        if tree.is_ours() {
            found.add(ProblemKind::Missing, CHECKSUMS, None, lost);
        }
        return;
    }
    let opened = match open_input(&tree.path(CHECKSUMS)) {
        Ok(opened) => opened,
        Err(error) => {
            found.add(ProblemKind::Metadata, CHECKSUMS, None, error.to_string());
            return;
        }
    };
    let mut lines = Lines::of(BufReader::new(opened));
    let mut listed: BTreeSet<String> = BTreeSet::new();
    loop {
        let (number, line) = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err((number, fault)) => {
                found.add(ProblemKind::Metadata, CHECKSUMS, number, fault.sentence());
                return;
            }
        };
        // Sums of binary files have an asterisk in the place of the second space.
        let parts = line.split_once("  ").or_else(|| line.split_once(" *"));
        match parts {
            Some((sum, file)) if sum.len() == 64 => {
                let file = file.trim_start_matches("../");
                listed.insert(file.to_owned());
                checksum(tree, sum, file, found);
            }
            _ => {
                let why = "expected a checksum, two spaces and a file, found another line; restore the file from a copy";
                found.add(ProblemKind::Metadata, CHECKSUMS, number, why);
            }
        }
    }
    if listed.is_empty() {
        found.add(ProblemKind::Empty, CHECKSUMS, None, lost);
    } else if tree.is_ours() {
        unlisted(tree, &listed, found);
    }
}

/// Data that were not exported.
fn unlisted(tree: &Tree, listed: &BTreeSet<String>, found: &mut Found) {
    let own = tree.entries.iter().filter(|entry| {
        entry.is_signal() || entry.parsed().is_some() || entry.file == "participants.tsv"
    });
    let others = tree.others.iter().filter(|file| {
        let is_data = file.starts_with("stimuli/") || file.starts_with("sourcedata/");
        is_data && file.as_str() != CHECKSUMS
    });
    for file in own.map(|entry| &entry.file).chain(others) {
        if !listed.contains(file) {
            let why = "expected files that were exported, found another one, which sourcedata/SHA256SUMS does not list; remove it, or add its checksum there";
            found.add(ProblemKind::Changed, file, None, why);
        }
    }
}

fn checksum(tree: &Tree, sum: &str, file: &str, found: &mut Found) {
    if !tree.has(file) {
        let why = "expected this file, which was exported, found none: the data set is half copied, or the file was removed; copy it again";
        found.add(ProblemKind::Missing, file, None, why);
        return;
    }
    // People complete the read-me by hand.
    if file.ends_with("README.md") || file == CHECKSUMS {
        return;
    }
    let is = sha256_of_file(&tree.path(file));
    if is.is_ok_and(|is| is.eq_ignore_ascii_case(sum)) {
        return;
    }
    let why = "expected the file as it was exported, found another content; copy the file again, or, where the change is wanted, put its new checksum into sourcedata/SHA256SUMS";
    found.add(ProblemKind::Changed, file, None, why);
}

/// How many files hold data of other kinds.
fn not_read(tree: &Tree) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for entry in &tree.entries {
        let of_brain = [".eeg", ".vmrk", ".fdt"];
        let is_read = entry.is_signal()
            || entry.is_table()
            || entry.file.ends_with(".json")
            || eeg::is_eeg(entry)
            || of_brain.iter().any(|ending| entry.file.ends_with(ending));
        if let (false, Some(datatype)) = (is_read, entry.datatype()) {
            *counts.entry(datatype.to_owned()).or_default() += 1;
        }
    }
    let derived = tree.others.iter().filter(|file| {
        let is_value = file.ends_with(".tsv") || file.ends_with(".json");
        file.starts_with("derivatives/") && is_value
    });
    match derived.count() {
        0 => {}
        count => {
            counts.insert("derivatives".to_owned(), count);
        }
    }
    counts
}
