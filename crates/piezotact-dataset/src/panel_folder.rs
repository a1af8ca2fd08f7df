//! A panel on disk: a folder with `panel.json`, its index, and one transfer function (JSON) for each measurement.
//!
//! A measurement is written first and then listed, each file whole or not at all: a session that breaks off in the
//! middle leaves a panel of what was measured until then, and at most one file that the index does not list. Whoever
//! writes holds the folder's lock from before the index is read until the end.

mod bench;
mod lock;

use piezotact::recording::{NotUsed, RecordingWarning};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::panel::{
    Cell, Entry, FiledMeasurement, Filing, MissingMeasurements, Panel, PanelKind, PanelWarning,
};
use piezotact::quantity::{Uncalibrated, Unit};
use piezotact::transfer::TransferFunction;
use serde::{Deserialize, Serialize};

use crate::error::{ReadError, WriteError};
use crate::lock::Lock;
use crate::sidecar::{prepare_json, write_json};
use crate::transfer_file::read_transfer;
use crate::transfer_json::{MeasuredFor, TransferDocument};
use crate::version::Versioned;

pub use bench::BenchFile;
use bench::differing;

/// The name of the index.
pub const PANEL_INDEX: &str = "panel.json";
const FORMAT: &str = "piezotact panel 1";

/// The index of a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelIndex {
    /// The name and the version of its form.
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
    /// The files that this bench is made of; empty where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bench_files: Vec<BenchFile>,
    /// The participants, measured and planned.
    pub participants: Vec<String>,
    /// The loads, N.
    pub loads_n: Vec<f64>,
    /// The angles, degrees.
    pub angles_deg: Vec<f64>,
    /// The measurements.
    pub entries: Vec<FiledMeasurement>,
    /// What was planned and is not measured yet.
    #[serde(default)]
    pub planned: Vec<Filing>,
}

/// A panel on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelFolder {
    path: PathBuf,
    /// Absent where it is only read.
    lock: Option<Lock>,
    pub index: PanelIndex,
}

/// All transfer functions of a panel, whatever they go from and to, and what there is to warning.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelContents {
    pub panel: Vec<Entry<Uncalibrated, Uncalibrated>>,
    /// The unit of the drive.
    pub drive_unit: Unit,
    /// The unit of the response.
    pub response_unit: Unit,
    /// What the folder leaves open.
    pub warnings: Vec<Warning>,
}

impl PanelFolder {
    /// A panel in `folder`, which is there, to write to: what its index lists, or nothing where there is no index yet.
    /// No other program can write to it as long as this value or a clone of it exists. Unfinished files of a killed
    /// program are removed.
    ///
    /// # Errors
    /// Those of [`Self::open`], but for a missing index; [`ReadError::Content`] when another program goes on writing to
    /// the folder.
    pub fn open_or_begin(folder: &Path) -> Result<Self, ReadError> {
        let lock = Some(lock::take(folder)?);
        lock::remove_unfinished(folder);
        if folder.join(PANEL_INDEX).exists() {
            return Ok(Self {
                lock,
                ..Self::open(folder)?
            });
        }
        Ok(Self {
            path: folder.to_owned(),
            lock,
            index: PanelIndex {
                format: FORMAT.into(),
                kind: None,
                drive_unit: None,
                response_unit: None,
                bench: None,
                bench_files: Vec::new(),
                participants: Vec::new(),
                loads_n: Vec::new(),
                angles_deg: Vec::new(),
                entries: Vec::new(),
                planned: Vec::new(),
            },
        })
    }

    /// The panel in `folder`, by its index, to read.
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
        let todo = "restore a copy, or move it away and add the transfer functions again with `piezotact panel add`";
        let wrong =
            |expected: &str, found: String| ReadError::content(&path, expected, found, todo);
        let bytes = crate::input::read_input(&path)?;
        let index: PanelIndex = serde_json::from_slice(&bytes)
            .map_err(|error| wrong("the index of a panel", error.to_string()))?;
        let version = |format: &str| format.rsplit(' ').next()?.parse::<u32>().ok();
        if index.format.starts_with("piezotact panel ") && version(&index.format) > version(FORMAT)
        {
            return Err(ReadError::content(
                &path,
                format!("the format \"{FORMAT}\""),
                format!("\"{}\"", index.format),
                "read it with a newer version of the program",
            ));
        }
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
            lock: None,
            index,
        })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the index lists a measurement.
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

    /// The measurements with stored judgements.
    #[must_use]
    pub fn accepted(&self) -> Vec<&FiledMeasurement> {
        let entries = self.index.entries.iter();
        entries.filter(|entry| !entry.attempts.is_empty()).collect()
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
                "keep transfer functions of different quantities in separate panels",
            )
        })?;
        let file = self.free_name(filing);
        self.writable()?;
        prepare_json(&self.path.join(&file), &Versioned::of(document))?.commit_new()?;
        let mut next = self.clone();
        let entry = FiledMeasurement {
            file,
            filing: filing.clone(),
            attempts: document.attempts.clone(),
        };
        next.list(entry, document);
        next.write_index()?;
        *self = next;
        Ok(())
    }

    /// What the file of a measurement states of a panel that was begun with `bench`.
    #[must_use]
    pub fn measured_for(bench: &str, filing: &Filing) -> MeasuredFor {
        MeasuredFor {
            bench: bench.into(),
            filing: filing.clone(),
        }
    }

    /// Lists a file that a session which broke off has left behind, when it is there, can be read, and says in its
    /// provenance that it is that measurement of the campaign this index was begun for; says whether it was.
    ///
    /// # Errors
    /// [`WriteError`] when the index cannot be written.
    pub fn adopt(&mut self, filing: &Filing) -> Result<Adopted, WriteError> {
        let file = file_name(filing);
        let known = self.index.entries.iter().any(|e| e.file == file);
        let Some(bench) = self.index.bench.as_ref().filter(|_| !known) else {
            return Ok(Adopted::Nothing);
        };
        let asked = Self::measured_for(bench, filing);
        let found = read_transfer(&self.path.join(&file))
            .ok()
            .filter(|document| {
                let at = &document.about.condition;
                let cell = at
                    .load_n
                    .zip(at.angle_deg)
                    .map(|(load_n, angle_deg)| Cell { load_n, angle_deg });
                document.measured_for.as_ref() == Some(&asked)
                    && at.participant.as_ref() == Some(&filing.participant)
                    && cell.is_some_and(|cell| cell.is(filing.cell))
                    && self.same_units(document).is_ok()
            });
        let Some(document) = found else {
            return Ok(Adopted::Nothing);
        };
        let entry = FiledMeasurement {
            file,
            filing: filing.clone(),
            attempts: document.attempts.clone(),
        };
        self.list(entry, &document);
        self.write_index()?;
        Ok(Adopted::Listed)
    }

    /// Begins or resumes a campaign: `bench` describes everything that its measurements have in common, and `files` are the files
    /// from which that bench is built. A panel without measurements may be begun again with another campaign; the earlier plan is
    /// then discarded.
    ///
    /// # Errors
    /// [`WriteError::Content`] when the panel was begun with another or one of its files held something else, or holds files of
    /// measurements but no index that says of which campaign.
    pub fn begin(&mut self, bench: &str, files: Vec<BenchFile>) -> Result<(), WriteError> {
        let path = self.path.join(PANEL_INDEX);
        if !path.exists()
            && let Some(first) = self.not_listed().first()
        {
            return Err(WriteError::content(
                &path,
                "an empty folder, or a folder with the index of its measurements",
                format!("no index, but {first}"),
                "add these measurements to a separate panel with `piezotact panel add`, or give another folder",
            ));
        }
        match &self.index.bench {
            Some(other) if other != bench && !self.index.entries.is_empty() => {
                let [begun, now] = differing(other, bench);
                return Err(WriteError::content(
                    &path,
                    format!("to continue the campaign with {begun}, as it was started"),
                    now,
                    "use the same settings as before, or give another folder",
                ));
            }
            Some(other) if other != bench => self.index.planned.clear(),
            _ => {}
        }
        let measured = !self.index.entries.is_empty() || !self.not_listed().is_empty();
        if let Some(changed) = BenchFile::changed(&self.index.bench_files, &files)
            && measured
        {
            return Err(WriteError::content(
                &path,
                format!(
                    "to continue with {} as it was when the panel was started",
                    changed.file
                ),
                "changed contents of that file",
                "restore the earlier file, or give another folder",
            ));
        }
        self.index.bench = Some(bench.to_owned());
        self.index.bench_files = files;
        Ok(())
    }

    /// Takes those of `filings` off the list whose files are missing or damaged, so that they can be measured again; a
    /// damaged file stays beside under another name. What was found, for people.
    ///
    /// # Errors
    /// [`WriteError`] when a file cannot be renamed, or the index not written.
    pub fn set_aside_unreadable(&mut self, filings: &[Filing]) -> Result<Vec<String>, WriteError> {
        let mut told = Vec::new();
        let listed: Vec<FiledMeasurement> = self.index.entries.clone();
        for entry in listed {
            if !filings.iter().any(|filing| filing.is(&entry.filing)) {
                continue;
            }
            let path = self.path.join(&entry.file);
            let read = self.document(&entry);
            let Err(error) = read.and_then(|d| function_of_any_unit(&d, &path)) else {
                continue;
            };
            if path.exists() {
                let aside = (1_u32..)
                    .map(|number| self.path.join(format!("{}.damaged{number}", entry.file)))
                    .find(|aside| !aside.exists())
                    .unwrap_or_else(|| path.with_extension("damaged"));
                std::fs::rename(&path, &aside).map_err(WriteError::io(&aside))?;
                told.push(format!(
                    "{error}; it is kept as {} and measured again",
                    aside.display()
                ));
            } else {
                told.push(format!("{error}; it is measured again"));
            }
            self.index.entries.retain(|e| e.file != entry.file);
            self.index.planned.push(entry.filing);
        }
        if !told.is_empty() {
            self.write_index()?;
        }
        Ok(told)
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

    fn list(&mut self, entry: FiledMeasurement, document: &TransferDocument) {
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

    fn writable(&self) -> Result<(), WriteError> {
        if self.lock.is_some() {
            return Ok(());
        }
        Err(WriteError::content(
            &self.path.join(PANEL_INDEX),
            "a panel that was opened for writing",
            "one that was opened for reading",
            "report this",
        ))
    }

    fn write_index(&mut self) -> Result<(), WriteError> {
        self.writable()?;
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
            values.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
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
    /// panel, or nothing is listed; [`ReadError::Invalid`] and [`ReadError::Content`] when one cannot be read.
    pub fn read(&self) -> Result<PanelContents, ReadError> {
        let index_path = self.path.join(PANEL_INDEX);
        let Some(first) = self.index.entries.first() else {
            return Err(ReadError::content(
                &index_path,
                "measurements",
                "none",
                "measure with `piezotact panel run` or add transfer functions with `piezotact panel add`",
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
                    "keep transfer functions of different quantities in separate panels",
                ));
            }
            entries.push(Entry {
                filing: entry.filing.clone(),
                function: function_of_any_unit(&document, &path)?,
            });
        }
        let mut warnings = Vec::new();
        if let Some(first) = self.index.planned.first() {
            warnings.push(Warning::from(PanelWarning::IncompletePanel {
                what: MissingMeasurements::Planned {
                    count: self.index.planned.len(),
                    first: first.to_string(),
                },
            }));
        }
        let files = self.not_listed();
        if !files.is_empty() {
            warnings.push(Warning::from(RecordingWarning::NotUsed {
                what: NotUsed::TransferFunctions { files },
            }));
        }
        Ok(PanelContents {
            panel: entries,
            drive_unit,
            response_unit,
            warnings,
        })
    }

    fn document(&self, entry: &FiledMeasurement) -> Result<TransferDocument, ReadError> {
        let path = self.path.join(&entry.file);
        if !path.is_file() {
            return Err(ReadError::content(
                &path,
                format!("the transfer function of {}", entry.filing),
                "no file",
                format!("restore it, or remove it from {PANEL_INDEX} and measure or add it again"),
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
    panel.warnings.extend(contents.warnings.iter().cloned());
    Ok(panel)
}

/// The transfer function in `document`, whatever it goes from and to.
///
/// # Errors
/// Those of [`TransferDocument::function`], but for units.
pub fn function_of_any_unit(
    document: &TransferDocument,
    path: &Path,
) -> Result<TransferFunction<Uncalibrated, Uncalibrated>, ReadError> {
    document.lines(path)
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
mod tests;
