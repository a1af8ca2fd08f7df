//! What may stand where a command writes: nothing, what the command wrote before, the same bytes, or what `--force` gives up.
//!
//! Recordings and transfer functions that were measured are never replaced: what stood there is kept as `NAME.before-N`. So the same
//! command goes on after a kill, whatever it had written.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::invocation::{Invocation, Setting};
use piezotact_dataset::sidecar::{read_rendering, sidecar_path};
use piezotact_dataset::{check_place, keep_as_it_is};

use crate::arguments::{Arguments, OUTPUTS, OutputPath, output_of};
use crate::failure::{Outcome, usage};
use crate::made::Made;

/// Outputs that are measured: whoever writes them keeps what stood there.
const MEASURED: [[&str; 2]; 8] = [
    ["twin record", "out"],
    ["characterise", "out"],
    ["characterise", "record"],
    ["play", "record"],
    ["record", "out"],
    ["sound calibrate", "out"],
    ["sound latency", "out"],
    ["render", "record"],
];
/// What is measured of a sound device stands beside its set-up, where no option names it.
const BESIDE_SETUP: [[&str; 2]; 2] = [
    ["sound calibrate", ".calibration.json"],
    ["sound latency", ".latency.json"],
];
/// Folders whose commands go on with what is in them, and check it themselves.
const CONTINUED: [[&str; 2]; 1] = [["panel run", "out"]];
/// The endings of outputs that have only some, by the end of the command's name; one that is not theirs would name a file that is
/// something else.
const ENDINGS: [(&str, &str, &[&str]); 6] = [
    ("", "report", &["html", "htm"]),
    ("", "csv", &["csv"]),
    ("", "write_cuts", &["cuts", "txt"]),
    ("characterise", "out", TRANSFERS),
    ("transfer", "out", TRANSFERS),
    ("panel average", "out", TRANSFERS),
];
const TRANSFERS: &[&str] = &["json", "uff", "unv", "mat"];

/// A command with its outputs.
pub(crate) struct Writing {
    /// Its name: `panel run`.
    pub(crate) command: String,
    /// The folder in which it runs.
    pub(crate) folder: PathBuf,
    pub(crate) outputs: Vec<OutputPath>,
    pub(crate) existing: Existing,
}

/// What becomes of files that a command did not write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    /// They are refused before anything is measured.
    Refused,
    /// They stay where the same is written again; anything else is refused when it is known.
    Compared,
    /// They are replaced.
    Replaced,
}

impl Writing {
    /// Refuses folders for figures and tables that cannot be made or written, and those that hold anything that cannot be one of them.
    pub(crate) fn check(&self) -> Outcome {
        self.folders_of_parts().try_for_each(require_folder)?;
        let endings: &[&str] = match self.existing {
            Existing::Compared => &["svg", "png", "pdf", "csv"],
            _ => &[],
        };
        let is_own = |path: &Path| {
            let ending = path.extension().and_then(OsStr::to_str);
            path.is_file() && ending.is_some_and(|ending| endings.contains(&ending))
        };
        self.refuse_others(&is_own)
    }

    /// Refuses folders for figures and tables that hold anything but what `is_own` accepts and hidden files, as a killed command leaves
    /// them.
    pub(crate) fn refuse_others(&self, is_own: &dyn Fn(&Path) -> bool) -> Outcome {
        let is_hidden = |path: &Path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with('.')
        };
        for folder in self.folders_of_parts() {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let mut entries = entries.map(|entry| entry.path());
            if entries.any(|path| !is_own(&path) && !is_hidden(&path)) && !self.may_replace(folder)
            {
                return Err(usage(anyhow!(
                    "{}: expected a new or empty folder, found one that holds other files; give another one, or add to it with \
                     --force",
                    folder.display()
                )));
            }
        }
        Ok(())
    }

    /// The folders for the figures and tables of a report.
    fn folders_of_parts(&self) -> impl Iterator<Item = &Path> {
        let outputs = self.outputs.iter();
        let of_parts = outputs.filter(|one| matches!(one.setting.as_str(), "figures" | "tables"));
        of_parts.map(|output| output.path.as_path())
    }

    /// Whether this command wrote the report at `report` before, with `part` beside it.
    pub(crate) fn wrote_part(&self, report: &Path, part: &Path) -> bool {
        made_at(report).is_some_and(|made| self.is_of_the_same(&made) && self.wrote(&made, part))
    }

    /// Whether a person asked for everything to be replaced.
    pub(crate) fn replaces_everything(&self) -> bool {
        self.existing == Existing::Replaced
    }

    /// Refuses an ending that is not that of the format.
    fn require_its_ending(&self, path: &Path) -> Outcome {
        let output = self.outputs.iter().find(|output| output.path == path);
        let setting = output.map(|output| output.setting.as_str());
        let own = ENDINGS
            .iter()
            .find(|(command, of, _)| self.command.ends_with(command) && setting == Some(*of));
        own.map_or(Ok(()), |(_, _, endings)| require_ending(path, endings))
    }

    /// Refuses a file at `path` that this command did not write and does not keep, and a name with an ending that is not its own. One
    /// that could be what is written now is compared when it is.
    pub(crate) fn refuse_existing(&self, path: &Path) -> Outcome {
        self.require_its_ending(path)?;
        if path.is_file() && self.is_brainvision(path) {
            keep_as_it_is(path);
            return Ok(());
        }
        if !path.is_file() || self.may_replace(path) || self.is_kept(path) {
            return Ok(());
        }
        if self.existing == Existing::Compared && !is_of_another(path) {
            keep_as_it_is(path);
            return Ok(());
        }
        Err(usage(anyhow!(
            "{} already exists: give another name, move it away, or replace it with --force",
            path.display()
        )))
    }

    /// Whether what stands at `path` is kept, or gone on with, by whoever writes there.
    fn is_kept(&self, path: &Path) -> bool {
        let name = path.to_string_lossy();
        if BESIDE_SETUP
            .iter()
            .any(|[command, ending]| self.command == *command && name.ends_with(ending))
        {
            return true;
        }
        let Some((output, beside)) = self.output_beside(path) else {
            return false;
        };
        let known = [self.command.as_str(), output.setting.as_str()];
        // The journal of an interrupted recording is kept by the next one.
        let is_journal = beside.ends_with(".part");
        let runs = |file: &Path| with(file, ".runs").is_dir();
        // A drive that was corrected on a bench is none that is rendered without one.
        let is_of_loop = self.command != "render"
            && (runs(path) || beside_sidecar(path).is_some_and(|file| runs(&file)));
        // What an earlier command prepared, or wrote beside it.
        let is_prepared = self.command == "prepare"
            && (path.extension() == Some(OsStr::new("parquet"))
                || sidecar_path(path).is_file()
                || beside_sidecar(path).is_some_and(|file| file.is_file()));
        // A drive that is corrected on a bench.
        let is_corrected = known == ["render", "out"] && self.existing == Existing::Refused;
        MEASURED.contains(&known)
            || is_prepared
            || is_corrected
            || CONTINUED.contains(&known)
            || is_journal
            || is_of_loop
    }

    /// Whether `path` is one of the three files of a simulated `BrainVision` recording. They name each other, so that none is set
    /// aside; the same simulation gives the same bytes.
    fn is_brainvision(&self, path: &Path) -> bool {
        let mut outputs = self.outputs.iter();
        self.command == "twin record"
            && outputs.any(|output| {
                output.path.extension() == Some(OsStr::new("vhdr"))
                    && ["vhdr", "eeg", "vmrk"]
                        .iter()
                        .any(|ending| output.path.with_extension(ending) == path)
            })
    }

    /// The output that `path` is, stands in, or stands beside with a longer name: `drive.wav.json` beside `drive.wav`; and what
    /// its name has more.
    fn output_beside(&self, path: &Path) -> Option<(&OutputPath, String)> {
        if let Some((output, _)) = output_of(&self.outputs, path) {
            let name = path.to_string_lossy().into_owned();
            return Some((output, name));
        }
        let name = path.to_string_lossy();
        self.outputs.iter().find_map(|output| {
            if let Some(more) = name.strip_prefix(&*output.path.to_string_lossy()) {
                return more.starts_with('.').then(|| (output, more.to_owned()));
            }
            // Each of several recordings has its number in its name.
            let stem = output.path.with_extension("");
            let more = name.strip_prefix(&*stem.to_string_lossy())?;
            let is_numbered = output.setting == "record" && more.starts_with('-');
            is_numbered.then(|| (output, more.to_owned()))
        })
    }

    /// Whether what stands at `path` may be replaced: everything on request, and what this command wrote before.
    fn may_replace(&self, path: &Path) -> bool {
        if self.existing == Existing::Replaced {
            return true;
        }
        let Some((output, _)) = self.output_beside(path) else {
            return false;
        };
        if self.command == "render" && output.setting == "out" && is_open_rendering(path) {
            return true;
        }
        // Reports and documents say themselves which command wrote them, and where else it wrote.
        let mut places: Vec<PathBuf> = vec![path.to_owned()];
        places.extend(self.outputs.iter().map(|output| output.path.clone()));
        places.extend(["report.html", "verification.json"].map(|name| output.path.join(name)));
        places.iter().any(|place| {
            made_at(place).is_some_and(|made| self.is_of_the_same(&made) && self.wrote(&made, path))
        })
    }

    /// Whether `made` is of a command of this name.
    fn is_of_the_same(&self, made: &Invocation) -> bool {
        let mut root = crate::commands::command();
        let words = std::iter::once("piezotact").chain(made.command.iter().map(String::as_str));
        let matches = root.try_get_matches_from_mut(words);
        matches.is_ok_and(|matches| Arguments::of(&root, &matches).names.join(" ") == self.command)
    }

    /// Whether the command that `made` states wrote `path`, or a file beside one that it wrote.
    fn wrote(&self, made: &Invocation, path: &Path) -> bool {
        let here = self.folder.join(path);
        let is_output = |setting: &&Setting| OUTPUTS.contains(&setting.name.as_str());
        let written = made.settings.iter().filter(is_output);
        let mut written = written.flat_map(|setting| &setting.values);
        written.any(|value| {
            let there = Path::new(&made.folder).join(value);
            here.starts_with(&there) || here == with(&there, ".json")
        })
    }
}

/// Refuses a folder that cannot be made, or takes no files.
fn require_folder(folder: &Path) -> Outcome {
    let above = folder.ancestors().map(|above| match above.as_os_str() {
        name if name.is_empty() => Path::new("."),
        _ => above,
    });
    let there = above.into_iter().find(|above| above.exists());
    let there = there.unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(usage(anyhow!(
            "cannot create the folder {}: {} is a file; give another name",
            folder.display(),
            there.display()
        )));
    }
    check_place(&there.join("figure.svg")).map_err(|error| {
        let here = folder.display();
        anyhow!("cannot write to the folder {here}: {error}; give another one").into()
    })
}

/// Whether what stands at `path` says that another command made it, so that it cannot be what is written now. A report always says it.
fn is_of_another(path: &Path) -> bool {
    let ending = path.extension().and_then(OsStr::to_str);
    matches!(ending, Some("html" | "htm")) || made_at(path).is_some()
}

/// How the report or document at `path` was made; `None` for what does not say.
fn made_at(path: &Path) -> Option<Invocation> {
    const LARGEST: u64 = 1 << 28;
    let ending = path.extension()?.to_str()?;
    let length = std::fs::metadata(path)
        .ok()
        .filter(|found| found.is_file())?
        .len();
    if !matches!(ending, "html" | "htm" | "json") || length > LARGEST {
        return None;
    }
    let text = std::fs::read_to_string(path).ok()?;
    Made::of(&text).map(|made| made.invocation)
}

/// Whether `path` is a drive that was rendered, or its sidecar, as that says. A drive that was corrected on a bench is a measurement.
fn is_open_rendering(path: &Path) -> bool {
    let drive = beside_sidecar(path).unwrap_or_else(|| path.to_owned());
    read_rendering(&drive).is_some_and(|made| made.aim.is_none())
}

/// The file whose sidecar `path` is.
fn beside_sidecar(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?.strip_suffix(".json")?;
    Some(path.with_file_name(name))
}

/// `path` with a longer name.
fn with(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

/// Refuses a name with another ending than `endings`.
fn require_ending(path: &Path, endings: &[&str]) -> Outcome {
    let found = path.extension().map(OsStr::to_ascii_lowercase);
    if endings
        .iter()
        .any(|ending| found.as_deref() == Some(OsStr::new(ending)))
    {
        return Ok(());
    }
    Err(usage(anyhow!(
        "{}: expected a name that ends in .{}, found another ending; the file would not be what its name says",
        path.display(),
        endings.join(", .")
    )))
}
