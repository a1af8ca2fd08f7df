//! The files of a data set, with what their names say.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ignore::gitignore::{Gitignore, GitignoreBuilder};
use serde_json::{Map, Value};

use super::error::BidsError;
use super::name::{DATATYPES, Parsed};
use super::{DESCRIPTION, NOTHING, PROGRAM};
use piezotact_dataset::read_input_text;

/// How deep folders are followed.
const DEEPEST: usize = 64;
/// The longest text with fields that is read, in bytes: sidecars hold kilobytes.
const LONGEST_JSON: u64 = 1 << 26;
/// The file that lists what is not of BIDS, from the root.
const IGNORED: &str = ".bidsignore";
/// The suffixes of sidecars that stand at the root without an entity.
const SIDECARS_OF_ALL: [&str; 9] = [
    "beh",
    "channels",
    "coordsystem",
    "eeg",
    "electrodes",
    "events",
    "physio",
    "scans",
    "stim",
];
/// Data sets have no more files.
const MOST_FILES: usize = 2_000_000;
/// Folders at the root that hold no data of this data set in its raw form.
const OTHERS: [&str; 5] = ["sourcedata", "derivatives", "code", "stimuli", "phenotype"];

/// A file of a data set.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// From the root, with slashes.
    pub(super) file: String,
    /// What its name says; a sentence for a name that is none of BIDS; absent for a file that has no such name.
    pub(super) name: Option<Result<Parsed, String>>,
}

impl Entry {
    /// The parts of its name, where it has one of BIDS.
    pub(super) fn parsed(&self) -> Option<&Parsed> {
        self.name.as_ref()?.as_ref().ok()
    }

    pub(super) fn folder(&self) -> &str {
        self.file.rsplit_once('/').map_or("", |(folder, _)| folder)
    }

    /// The kind of data whose folder it stands in.
    pub(super) fn datatype(&self) -> Option<&'static str> {
        let last = self.folder().rsplit('/').next()?;
        DATATYPES.iter().copied().find(|known| *known == last)
    }

    fn is(&self, suffix: &str, ending: &str) -> bool {
        self.parsed()
            .is_some_and(|name| name.suffix == suffix && name.ending == ending)
    }

    pub(super) fn is_signal(&self) -> bool {
        self.is("physio", "tsv.gz") || self.is("stim", "tsv.gz")
    }

    pub(super) fn is_table(&self) -> bool {
        self.file.ends_with(".tsv")
    }
}

/// The files of a data set.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub(super) root: PathBuf,
    /// In the order of their names; without those of [`OTHERS`].
    pub(super) entries: Vec<Entry>,
    /// Those of `sourcedata`, `derivatives`, `code`, `stimuli` and `phenotype`, by their names.
    pub(super) others: Vec<String>,
    /// Folders at the root that hold a data set of their own.
    pub(super) within: Vec<String>,
    /// Links that lead out of the data set, which are not followed.
    pub(super) outside: Vec<String>,
    /// The folders of participants at the root.
    pub(super) participants: BTreeSet<String>,
    /// The places of JSON files among the entries, by their folders.
    json: BTreeMap<String, Vec<usize>>,
}

impl Tree {
    /// The files below `root`. Links to folders are not followed.
    pub(super) fn of(root: &Path) -> Result<Self, BidsError> {
        let none = |found: &str, todo| BidsError::NoDataset {
            folder: root.to_owned(),
            found: found.to_owned(),
            todo,
        };
        if !root.is_dir() {
            let found = if root.exists() { "a file" } else { "nothing" };
            return Err(none(
                found,
                "give the folder that holds dataset_description.json",
            ));
        }
        let mut listed = Listed::of(root);
        listed
            .list("", 0)
            .map_err(|error| none(&error, "give one data set"))?;
        let Listed {
            mut files,
            outside,
            participants,
            ..
        } = listed;
        files.sort();
        let within: Vec<String> = files
            .iter()
            .filter_map(|file| Some(file.strip_suffix(DESCRIPTION)?.trim_end_matches('/')))
            .filter(|folder| {
                !folder.is_empty()
                    && !(folder.split('/'))
                        .any(|part| ["derivatives", "sourcedata", "code"].contains(&part))
            })
            .map(str::to_owned)
            .collect();
        let (others, own): (Vec<String>, Vec<String>) = files.into_iter().partition(|file| {
            let first = file.split('/').next().unwrap_or_default();
            file.contains('/') && OTHERS.contains(&first)
        });
        let entries = own.into_iter().map(|file| Entry {
            name: named(&file),
            file,
        });
        let entries: Vec<Entry> = entries.collect();
        let mut json: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (at, entry) in entries.iter().enumerate() {
            if entry.file.ends_with(".json") {
                json.entry(entry.folder().to_owned()).or_default().push(at);
            }
        }
        Ok(Self {
            root: root.to_owned(),
            entries,
            others,
            within,
            outside,
            participants,
            json,
        })
    }

    /// Whether this program wrote the data set: it then holds to more than BIDS asks for.
    pub(super) fn is_ours(&self) -> bool {
        let stated = self.json(DESCRIPTION).unwrap_or_default();
        if text(&stated, "DatasetType").is_some_and(|kind| kind != "raw") {
            return false;
        }
        let by = stated.get("GeneratedBy").and_then(Value::as_array);
        let mut names = by.into_iter().flatten().filter_map(|one| one.get("Name"));
        names.any(|name| name.as_str() == Some(PROGRAM))
    }

    /// Whether it is a folder of a data set rather than one.
    pub(super) fn is_part(&self) -> bool {
        let above = self.root.canonicalize().ok();
        let above = above.as_deref().and_then(Path::parent);
        !self.has(DESCRIPTION) && above.is_some_and(|above| above.join(DESCRIPTION).is_file())
    }

    /// Whether a file stands at `file`, also where a link to a folder leads to it.
    pub(super) fn is_there(&self, file: &str) -> bool {
        self.has(file) || self.path(file).is_file()
    }

    pub(super) fn path(&self, file: &str) -> PathBuf {
        self.root.join(file)
    }

    pub(super) fn has(&self, file: &str) -> bool {
        self.entries
            .binary_search_by(|entry| entry.file.as_str().cmp(file))
            .is_ok()
            || self
                .others
                .binary_search_by(|other| other.as_str().cmp(file))
                .is_ok()
    }

    /// The sidecars that apply to `entry`, the one that is furthest from it first.
    ///
    /// Source: BIDS 1.11, inheritance principle.
    pub(super) fn sidecars(&self, entry: &Entry) -> Vec<&Entry> {
        let Some(name) = entry.parsed() else {
            return Vec::new();
        };
        let folder = entry.folder();
        let ends = folder.match_indices('/').map(|(end, _)| end);
        let above = [0].into_iter().chain(ends).chain([folder.len()]);
        let mut above: Vec<&str> = above.map(|end| &folder[..end]).collect();
        above.dedup();
        let mut found: Vec<&Entry> = above
            .into_iter()
            .filter_map(|folder| self.json.get(folder))
            .flatten()
            .map(|at| &self.entries[*at])
            .filter(|other| {
                let Some(of) = other.parsed() else {
                    return false;
                };
                of.suffix == name.suffix
                    && of
                        .entities
                        .iter()
                        .all(|(key, label)| name.label(key) == Some(label))
            })
            .collect();
        found.sort_by_key(|other| {
            (
                other.file.matches('/').count(),
                other.parsed().map_or(0, |name| name.entities.len()),
            )
        });
        found
    }

    /// What the sidecars of `entry` say together; one that is nearer counts before one that is further.
    pub(super) fn sidecar(&self, entry: &Entry) -> Result<Map<String, Value>, BidsError> {
        let mut merged = Map::new();
        for sidecar in self.sidecars(entry) {
            merged.extend(self.json(&sidecar.file)?);
        }
        Ok(merged)
    }

    /// The object in the JSON file `file`.
    pub(super) fn json(&self, file: &str) -> Result<Map<String, Value>, BidsError> {
        let path = self.path(file);
        let long = std::fs::metadata(&path).is_ok_and(|found| found.len() > LONGEST_JSON);
        if long {
            let why = format!(
                "expected a text of at most {LONGEST_JSON} bytes, found a longer one; it is no sidecar"
            );
            return Err(BidsError::file(file, None, why));
        }
        let text = read_input_text(&path)?;
        let text = text.trim_start_matches('\u{feff}');
        let value: Value = serde_json::from_str(text).map_err(|error| {
            BidsError::file(
                file,
                error.line() as u64,
                format!("expected JSON, found other text ({error}); correct it"),
            )
        })?;
        match value {
            Value::Object(object) => Ok(object),
            _ => Err(BidsError::file(
                file,
                None,
                "expected an object in JSON, found another value; put braces around its fields",
            )),
        }
    }
}

/// What the name of `file` says; `None` for files that have other names.
fn named(file: &str) -> Option<Result<Parsed, String>> {
    let name = file.rsplit('/').next().unwrap_or_default();
    let at_root = !file.contains('/');
    // Formats that are folders have files with names of their own.
    let in_format = file.rsplit('/').skip(1).any(|folder| folder.contains('.'));
    if name.starts_with('.') || in_format {
        return None;
    }
    let of_all = |suffix: &str| SIDECARS_OF_ALL.contains(&suffix);
    if at_root && !name.contains('-') && !name.strip_suffix(".json").is_some_and(of_all) {
        return None;
    }
    Some(Parsed::of(name))
}

/// The files below a root, while they are listed.
struct Listed<'a> {
    root: &'a Path,
    /// Where the root is, without links.
    place: Option<PathBuf>,
    ignored: Gitignore,
    files: Vec<String>,
    outside: Vec<String>,
    participants: BTreeSet<String>,
}

impl<'a> Listed<'a> {
    fn of(root: &'a Path) -> Self {
        let mut ignored = GitignoreBuilder::new("");
        let patterns = read_input_text(&root.join(IGNORED)).unwrap_or_default();
        for line in patterns.lines() {
            // A pattern that is none hides nothing.
            let _kept = ignored.add_line(None, line);
        }
        Self {
            root,
            place: root.canonicalize().ok(),
            ignored: ignored.build().unwrap_or_else(|_| Gitignore::empty()),
            files: Vec::new(),
            outside: Vec::new(),
            participants: BTreeSet::new(),
        }
    }

    /// Adds the files below `folder`; a sentence for what is no data set.
    fn list(&mut self, folder: &str, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("folders that are more than {DEEPEST} deep"));
        }
        let entries = std::fs::read_dir(self.root.join(folder));
        let entries =
            entries.map_err(|error| format!("a folder that cannot be read ({folder}: {error})"))?;
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if folder.is_empty() && name.starts_with('.') {
                continue;
            }
            let file = match folder {
                "" => name,
                folder => format!("{folder}/{name}"),
            };
            // Nobody is there any more where this fails.
            let Ok(kind) = entry.file_type() else {
                continue;
            };
            if self.ignored.matched(&file, kind.is_dir()).is_ignore() {
                continue;
            }
            if kind.is_dir() {
                if folder.is_empty() && file.starts_with("sub-") {
                    self.participants.insert(file.clone());
                }
                self.list(&file, depth + 1)?;
            } else if kind.is_symlink() && self.leads_out(&file) {
                self.outside.push(file);
            } else {
                self.files.push(file);
            }
            if self.files.len() > MOST_FILES {
                return Err(format!("more than {MOST_FILES} files"));
            }
        }
        Ok(())
    }

    /// Whether the link `file` leads to a file outside the data set. One to nothing is found when it is read.
    fn leads_out(&self, file: &str) -> bool {
        let led = self.root.join(file).canonicalize();
        match (led, &self.place) {
            (Ok(led), Some(place)) => !led.starts_with(place),
            _ => false,
        }
    }
}

/// A text of a sidecar that is not `n/a`.
pub(super) fn text<'a>(of: &'a Map<String, Value>, key: &str) -> Option<&'a str> {
    of.get(key)?.as_str().filter(|text| *text != NOTHING)
}
