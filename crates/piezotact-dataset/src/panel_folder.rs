//! A panel on disk: a folder with `panel.json`, its index, and one transfer function (JSON) for each measurement.
//!
//! A measurement is written first and then listed, each file whole or not at all: a session that breaks off in the
//! middle leaves a panel of what was measured until then, and at most one file that the index does not list.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use piezotact::Doubt;
use piezotact::panel::{Cell, Entry, Filing, Panel};
use piezotact::quantity::{Uncalibrated, Unit};
use piezotact::transfer::TransferFunction;
use serde::{Deserialize, Serialize};

use crate::error::{ReadError, WriteError};
use crate::sidecar::write_json;
use crate::transfer_file::{read_transfer, write_transfer};
use crate::transfer_json::TransferDocument;

/// The name of the index.
pub const PANEL_INDEX: &str = "panel.json";
const FORMAT: &str = "piezotact panel 1";

/// What a panel's transfer functions are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelKind {
    /// A device with a finger on it: from the digital drive.
    Device,
    /// A finger alone: from the force on it.
    Finger,
    /// Something else.
    Other,
}

impl PanelKind {
    /// What transfer functions from `drive_unit` are of.
    #[must_use]
    pub fn of(drive_unit: &Unit) -> Self {
        match drive_unit {
            Unit::FullScale => Self::Device,
            Unit::Newton => Self::Finger,
            _ => Self::Other,
        }
    }
}

/// One measurement of a panel, as its index lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PanelEntry {
    /// The file in the folder.
    pub file: String,
    /// Who, how, which time.
    #[serde(flatten)]
    pub filing: Filing,
}

/// The index of a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PanelIndex {
    format: String,
    /// What it is of; absent while nothing is in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<PanelKind>,
    /// The unit of the drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive_unit: Option<Unit>,
    /// The unit of the response.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_unit: Option<Unit>,
    /// Which bench measures it, where one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bench: Option<String>,
    /// The participants, measured and planned.
    pub participants: Vec<String>,
    /// The loads, N.
    pub loads_n: Vec<f64>,
    /// The angles, degrees.
    pub angles_deg: Vec<f64>,
    /// What was measured.
    pub entries: Vec<PanelEntry>,
    /// What was planned and is not measured yet.
    #[serde(default)]
    pub planned: Vec<Filing>,
}

/// A panel on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelFolder {
    path: PathBuf,
    /// What it lists.
    pub index: PanelIndex,
}

/// All transfer functions of a panel, whatever they go from and to, and what there is to doubt.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelContents {
    /// The panel.
    pub panel: Vec<Entry<Uncalibrated, Uncalibrated>>,
    /// The unit of the drive.
    pub drive_unit: Unit,
    /// The unit of the response.
    pub response_unit: Unit,
    /// What the folder leaves open.
    pub doubts: Vec<Doubt>,
}

impl PanelFolder {
    /// A panel in `folder`, which is there: what its index lists, or nothing where there is no index yet.
    ///
    /// # Errors
    /// Those of [`Self::open`], but for a missing index.
    pub fn open_or_begin(folder: &Path) -> Result<Self, ReadError> {
        if folder.join(PANEL_INDEX).exists() {
            return Self::open(folder);
        }
        Ok(Self {
            path: folder.to_owned(),
            index: PanelIndex {
                format: FORMAT.into(),
                kind: None,
                drive_unit: None,
                response_unit: None,
                bench: None,
                participants: Vec::new(),
                loads_n: Vec::new(),
                angles_deg: Vec::new(),
                entries: Vec::new(),
                planned: Vec::new(),
            },
        })
    }

    /// The panel in `folder`, by its index.
    ///
    /// # Errors
    /// [`ReadError::Io`] when there is no index that can be read, [`ReadError::Content`] when it is something else or
    /// lists a file outside the folder, or the same measurement or file twice.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let path = folder.join(PANEL_INDEX);
        if !path.is_file() {
            return Err(ReadError::content(
                folder,
                format!("a folder with the index of a panel, {PANEL_INDEX}"),
                if folder.is_dir() {
                    "none in it"
                } else {
                    "no such folder"
                },
                "make one with `piezotact panel run` or `piezotact panel add`",
            ));
        }
        let todo = "put back a copy, or move it away and file the transfer functions again with `piezotact panel add`";
        let wrong =
            |expected: &str, found: String| ReadError::content(&path, expected, found, todo);
        let bytes = std::fs::read(&path).map_err(|error| ReadError::io(&path, &error))?;
        let index: PanelIndex = serde_json::from_slice(&bytes)
            .map_err(|error| wrong("the index of a panel", error.to_string()))?;
        if index.format != FORMAT {
            return Err(wrong(
                &format!("the format \"{FORMAT}\""),
                format!("\"{}\"", index.format),
            ));
        }
        for (i, entry) in index.entries.iter().enumerate() {
            if Path::new(&entry.file).file_name().and_then(|n| n.to_str()) != Some(&entry.file) {
                return Err(wrong(
                    "names of files in the folder",
                    format!("`{}`", entry.file),
                ));
            }
            let earlier = &index.entries[..i];
            if earlier
                .iter()
                .any(|e| e.filing.is(&entry.filing) || e.file == entry.file)
            {
                return Err(wrong(
                    "each measurement and file once",
                    format!("`{}` again ({})", entry.file, entry.filing),
                ));
            }
        }
        Ok(Self {
            path: folder.to_owned(),
            index,
        })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a measurement is listed.
    #[must_use]
    pub fn holds(&self, filing: &Filing) -> bool {
        self.index.entries.iter().any(|e| e.filing.is(filing))
    }

    /// Adds measurements to the plan that are neither planned nor listed.
    ///
    /// # Errors
    /// [`WriteError`] when the index cannot be written.
    pub fn plan(&mut self, filings: &[Filing]) -> Result<(), WriteError> {
        for filing in filings {
            if !self.holds(filing) && !self.index.planned.iter().any(|p| p.is(filing)) {
                self.index.planned.push(filing.clone());
            }
        }
        self.write_index()
    }

    /// Writes a transfer function and lists it: the file first, then the index.
    ///
    /// # Errors
    /// [`WriteError::Content`] when its units are not those of the panel, or it is listed already; [`WriteError::Io`]
    /// when it cannot be written. The panel is then as it was.
    pub fn file(&mut self, filing: &Filing, document: &TransferDocument) -> Result<(), WriteError> {
        let path = self.path.join(PANEL_INDEX);
        if self.holds(filing) {
            return Err(WriteError::content(
                &path,
                "each measurement once",
                filing.to_string(),
                "give it another placement or repeat number",
            ));
        }
        self.same_units(document).map_err(|(expected, found)| {
            WriteError::content(
                &path,
                expected,
                found,
                "keep transfer functions of different quantities in panels of their own",
            )
        })?;
        let file = self.free_name(filing);
        write_transfer(&self.path.join(&file), document)?;
        let mut next = self.clone();
        let entry = PanelEntry {
            file,
            filing: filing.clone(),
        };
        next.list(entry, document);
        next.write_index()?;
        *self = next;
        Ok(())
    }

    /// Lists a file that a session which broke off has left behind, when it is there, can be read, and is that
    /// measurement; says whether it was.
    ///
    /// # Errors
    /// [`WriteError`] when the index cannot be written.
    pub fn adopt(&mut self, filing: &Filing) -> Result<Adopted, WriteError> {
        let file = file_name(filing);
        let known = self.index.entries.iter().any(|e| e.file == file);
        let found = read_transfer(&self.path.join(&file))
            .ok()
            .filter(|document| {
                let at = &document.condition;
                let cell = at
                    .load_n
                    .zip(at.angle_deg)
                    .map(|(load_n, angle_deg)| Cell { load_n, angle_deg });
                !known
                    && at.participant.as_ref() == Some(&filing.participant)
                    && cell.is_some_and(|cell| cell.is(filing.cell))
                    && self.same_units(document).is_ok()
            });
        let Some(document) = found else {
            return Ok(Adopted::Nothing);
        };
        let entry = PanelEntry {
            file,
            filing: filing.clone(),
        };
        self.list(entry, &document);
        self.write_index()?;
        Ok(Adopted::Listed)
    }

    fn same_units(&self, document: &TransferDocument) -> Result<(), (String, String)> {
        let told = |drive: &Unit, response: &Unit| {
            format!("transfer functions from {drive} to {response}")
        };
        match (&self.index.drive_unit, &self.index.response_unit) {
            (Some(drive), Some(response))
                if (drive, response) != (&document.drive_unit, &document.response_unit) =>
            {
                Err((
                    told(drive, response),
                    told(&document.drive_unit, &document.response_unit),
                ))
            }
            _ => Ok(()),
        }
    }

    fn list(&mut self, entry: PanelEntry, document: &TransferDocument) {
        let index = &mut self.index;
        index
            .kind
            .get_or_insert(PanelKind::of(&document.drive_unit));
        index.drive_unit.get_or_insert(document.drive_unit.clone());
        index
            .response_unit
            .get_or_insert(document.response_unit.clone());
        index.planned.retain(|planned| !planned.is(&entry.filing));
        index.entries.push(entry);
    }

    fn write_index(&mut self) -> Result<(), WriteError> {
        let index = &mut self.index;
        let filings = || {
            index
                .entries
                .iter()
                .map(|e| &e.filing)
                .chain(&index.planned)
        };
        let people: BTreeSet<String> = filings().map(|f| f.participant.clone()).collect();
        let sorted = |value: fn(&Filing) -> f64| {
            let mut values: Vec<f64> = filings().map(value).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (loads_n, angles_deg) = (sorted(|f| f.cell.load_n.0), sorted(|f| f.cell.angle_deg.0));
        (index.loads_n, index.angles_deg) = (loads_n, angles_deg);
        index.participants = people.into_iter().collect();
        write_json(&self.path.join(PANEL_INDEX), index)
    }

    /// The name for a measurement; another one where a file of that name is there: nothing is replaced.
    fn free_name(&self, filing: &Filing) -> String {
        let plain = file_name(filing);
        let taken = |name: &str| {
            self.index.entries.iter().any(|e| e.file == name) || self.path.join(name).exists()
        };
        if !taken(&plain) {
            return plain;
        }
        let stem = plain.trim_end_matches(".json");
        (2_u32..)
            .map(|number| format!("{stem}_{number}.json"))
            .find(|name| !taken(name))
            .unwrap_or(plain)
    }

    /// Files that look like measurements and are not listed.
    #[must_use]
    pub fn not_listed(&self) -> Vec<String> {
        let Ok(folder) = std::fs::read_dir(&self.path) else {
            return Vec::new();
        };
        let mut names: Vec<String> = folder
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| {
                let looks =
                    name.ends_with(".json") && name.contains("deg_") && name.contains("N_p");
                looks && !self.index.entries.iter().any(|e| e.file == *name)
            })
            .collect();
        names.sort();
        names
    }

    /// The transfer functions of all measurements that are listed.
    ///
    /// # Errors
    /// [`ReadError::Content`] when a file is missing, naming it and the measurement, or its units are not those of the
    /// panel, or nothing is listed; [`ReadError::Transfer`] and [`ReadError::Content`] when one cannot be read.
    pub fn read(&self) -> Result<PanelContents, ReadError> {
        let index_path = self.path.join(PANEL_INDEX);
        let Some(first) = self.index.entries.first() else {
            return Err(ReadError::content(
                &index_path,
                "measurements",
                "none",
                "measure with `piezotact panel run` or file some with `piezotact panel add`",
            ));
        };
        let units = self.document(first)?;
        let (drive_unit, response_unit) = (units.drive_unit, units.response_unit);
        let mut entries = Vec::with_capacity(self.index.entries.len());
        for entry in &self.index.entries {
            let path = self.path.join(&entry.file);
            let document = self.document(entry)?;
            let told = |drive: &Unit, response: &Unit| {
                format!("a transfer function from {drive} to {response}")
            };
            if (&document.drive_unit, &document.response_unit) != (&drive_unit, &response_unit) {
                return Err(ReadError::content(
                    &path,
                    format!(
                        "{}, as in {}",
                        told(&drive_unit, &response_unit),
                        first.file
                    ),
                    told(&document.drive_unit, &document.response_unit),
                    "keep transfer functions of different quantities in panels of their own",
                ));
            }
            entries.push(Entry {
                filing: entry.filing.clone(),
                function: function_of_any_unit(document, &path)?,
            });
        }
        let mut doubts = Vec::new();
        if let Some(first) = self.index.planned.first() {
            doubts.push(Doubt::NotMeasured {
                count: self.index.planned.len(),
                first: first.to_string(),
            });
        }
        let files = self.not_listed();
        if !files.is_empty() {
            doubts.push(Doubt::NotListed { files });
        }
        Ok(PanelContents {
            panel: entries,
            drive_unit,
            response_unit,
            doubts,
        })
    }

    fn document(&self, entry: &PanelEntry) -> Result<TransferDocument, ReadError> {
        let path = self.path.join(&entry.file);
        if !path.is_file() {
            return Err(ReadError::content(
                &path,
                format!("the transfer function of {}", entry.filing),
                "no file",
                format!("put it back, or take it out of {PANEL_INDEX} and measure or add it again"),
            ));
        }
        read_transfer(&path)
    }
}

/// Whether a file that was left behind is listed now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adopted {
    /// There was none that fits.
    Nothing,
    /// It is.
    Listed,
}

/// The panel that entries make.
///
/// # Errors
/// Those of [`Panel::new`].
pub fn panel_of(
    contents: &PanelContents,
) -> Result<Panel<Uncalibrated, Uncalibrated>, piezotact::panel::PanelError> {
    let mut panel = Panel::new(contents.panel.clone())?;
    panel.doubts.extend(contents.doubts.iter().cloned());
    Ok(panel)
}

/// The transfer function in `document`, whatever it goes from and to.
///
/// # Errors
/// Those of [`TransferDocument::function`], but for units.
pub fn function_of_any_unit(
    mut document: TransferDocument,
    path: &Path,
) -> Result<TransferFunction<Uncalibrated, Uncalibrated>, ReadError> {
    document.drive_unit = Unit::Other(String::new());
    document.response_unit = Unit::Other(String::new());
    let mut function = document.function::<Uncalibrated, Uncalibrated>(path)?;
    // Its units are known to whoever asked: it is not a guess that they are left aside.
    let guess = |doubt: &Doubt| matches!(doubt, Doubt::Guessed { .. });
    function
        .doubts
        .retain(|doubt| !guess(doubt) || document.doubts.contains(doubt));
    Ok(function)
}

/// The name of the file of a measurement: readable, and without what a file system refuses.
fn file_name(filing: &Filing) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || "-_".contains(c) {
            c
        } else {
            '-'
        }
    };
    let who: String = filing.participant.chars().take(60).map(safe).collect();
    let Filing {
        cell,
        placement,
        repeat,
        ..
    } = filing;
    format!(
        "{who}_{}deg_{}N_p{placement}_r{repeat}.json",
        cell.angle_deg.0, cell.load_n.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Degrees, Newtons};

    fn filing(who: &str, repeat: u32) -> Filing {
        Filing {
            participant: who.into(),
            cell: Cell {
                load_n: Newtons(0.2),
                angle_deg: Degrees(20.0),
            },
            placement: 1,
            repeat,
        }
    }

    fn document(who: &str) -> TransferDocument {
        let mut document: TransferDocument = serde_json::from_str(
            r#"{"frequency_hz":[0,1,2],"real":[1,2,3],"imaginary":[0,0,1],"coherence":[1,1,1],"averages":20}"#,
        )
        .unwrap();
        document.condition.participant = Some(who.into());
        document.condition.load_n = Some(Newtons(0.2));
        document.condition.angle_deg = Some(Degrees(20.0));
        document
    }

    /// Every state that a crash can leave is a panel that can be read: no index, a file that is not listed, a plan.
    #[test]
    fn a_session_that_breaks_off_leaves_a_panel() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let mut panel = PanelFolder::open_or_begin(at).unwrap();
        panel
            .plan(&[filing("a", 1), filing("b", 1), filing("b", 2)])
            .unwrap();
        panel.file(&filing("a", 1), &document("a")).unwrap();
        // Between the file and the index.
        write_transfer(&at.join(file_name(&filing("b", 1))), &document("b")).unwrap();
        let mut again = PanelFolder::open(at).unwrap();
        let contents = again.read().unwrap();
        assert_eq!((contents.panel.len(), again.index.planned.len()), (1, 2));
        assert_eq!(again.index.participants, ["a", "b"]);
        let text: Vec<String> = contents.doubts.iter().map(ToString::to_string).collect();
        assert!(
            text[0].contains("2 planned") && text[1].contains("b_20deg_0.2N_p1_r1.json"),
            "{text:?}"
        );
        assert_eq!(again.adopt(&filing("b", 1)).unwrap(), Adopted::Listed);
        assert_eq!(again.adopt(&filing("b", 2)).unwrap(), Adopted::Nothing);
        let last = PanelFolder::open(at).unwrap();
        assert_eq!(
            (last.read().unwrap().panel.len(), last.index.planned.len()),
            (2, 1)
        );
        assert!(last.not_listed().is_empty());
        // A file of somebody else is not taken for it, nor replaced.
        write_transfer(&at.join(file_name(&filing("c", 1))), &document("b")).unwrap();
        assert_eq!(again.adopt(&filing("c", 1)).unwrap(), Adopted::Nothing);
        again.file(&filing("c", 1), &document("c")).unwrap();
        assert_eq!(again.index.entries[2].file, "c_20deg_0.2N_p1_r1_2.json");
    }

    #[test]
    fn units_and_doubts_survive() {
        let folder = tempfile::tempdir().unwrap();
        let mut panel = PanelFolder::open_or_begin(folder.path()).unwrap();
        let mut finger = document("a");
        finger.drive_unit = Unit::Newton;
        panel.file(&filing("a", 1), &finger).unwrap();
        assert_eq!(panel.index.kind, Some(PanelKind::Finger));
        let other = panel
            .file(&filing("b", 1), &document("b"))
            .unwrap_err()
            .to_string();
        assert!(
            other.contains("from N to") && other.contains("from FS to"),
            "{other}"
        );
        let twice = panel
            .file(&filing("a", 1), &finger)
            .unwrap_err()
            .to_string();
        assert!(twice.contains("each measurement once"), "{twice}");
        let contents = panel.read().unwrap();
        assert_eq!(contents.drive_unit, Unit::Newton);
        assert!(contents.panel[0].function.doubts.is_empty());
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let said = |at: &Path| PanelFolder::open(at).unwrap_err().to_string();
        assert!(said(at).contains("none in it"));
        assert!(said(&at.join("gone")).contains("no such folder"));
        let mut panel = PanelFolder::open_or_begin(at).unwrap();
        panel.plan(&[]).unwrap();
        assert!(
            panel
                .read()
                .unwrap_err()
                .to_string()
                .contains("expected measurements")
        );
        panel.file(&filing("a", 1), &document("a")).unwrap();
        std::fs::remove_file(at.join("a_20deg_0.2N_p1_r1.json")).unwrap();
        let missing = panel.read().unwrap_err().to_string();
        assert!(
            missing.contains("a_20deg_0.2N_p1_r1.json") && missing.contains("participant a"),
            "{missing}"
        );
        let index = std::fs::read_to_string(at.join(PANEL_INDEX)).unwrap();
        for (change, part) in [
            (index[..index.len() / 2].to_owned(), "index of a panel"),
            (index.replace("panel 1", "panel 9"), "panel 9"),
            (
                index.replace("a_20deg", "../a_20deg"),
                "files in the folder",
            ),
            ("\u{fffd}".into(), "index of a panel"),
        ] {
            std::fs::write(at.join(PANEL_INDEX), change).unwrap();
            assert!(said(at).contains(part), "{}", said(at));
        }
        assert_eq!(
            file_name(&filing("../a b", 1)),
            "---a-b_20deg_0.2N_p1_r1.json"
        );
    }
}
