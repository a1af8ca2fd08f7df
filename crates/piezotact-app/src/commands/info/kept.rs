//! What `piezotact info` says of files and folders that are no recording: panels, kept runs, descriptions of devices.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::doubt::DoubtKind as _;
use piezotact::recording::RecordingDoubt;
use piezotact_dataset::{ReadOptions, read_device, read_recording};
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::output::doubts_json;

/// The index in the folder of a panel.
const PANEL_INDEX: &str = "panel.json";

/// What there is, in words and as data.
pub(super) struct Kept {
    pub(super) text: String,
    pub(super) json: Value,
}

/// What stands at `path`; `None` where it is a file of another kind.
pub(super) fn of(path: &Path) -> Outcome<Option<Kept>> {
    if path.is_dir() {
        let index = path.join(PANEL_INDEX);
        if index.is_file() {
            return panel(path, &index).map(Some);
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        return match name.contains(".runs") {
            true => runs(path).map(Some),
            false => Ok(None),
        };
    }
    if path.file_name().is_some_and(|name| name == PANEL_INDEX) && path.is_file() {
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        return panel(folder.unwrap_or(Path::new(".")), path).map(Some);
    }
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    if ending.is_some_and(|ending| ending == "toml") && path.is_file() {
        return device(path).map(Some);
    }
    Ok(None)
}

fn panel(folder: &Path, index: &Path) -> Outcome<Kept> {
    let text = std::fs::read_to_string(index)?;
    let of: Value = serde_json::from_str(&text).unwrap_or_default();
    let count = of["entries"].as_array().map_or(0, Vec::len);
    let read_with = format!("piezotact panel analyse {}", folder.display());
    Ok(Kept {
        text: format!(
            "{}\n  the index of a panel of {count} transfer function(s)\n  read it with `{read_with}`",
            index.display()
        ),
        json: json!({
            "file": index,
            "kind": "index of a panel",
            "measurements": count,
            "read_with": read_with,
        }),
    })
}

/// The runs that a command kept in a folder: what each is, and how it ended.
fn runs(folder: &Path) -> Outcome<Kept> {
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let ending = path.extension().and_then(|ending| ending.to_str());
        if matches!(ending, Some("parquet" | "part")) {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(Failure::Data(anyhow!(
            "{}: expected a folder of kept runs, found none in it; give the folder OUT.runs that a command keeps them in",
            folder.display()
        )));
    }
    let mut text = format!(
        "{}\n  a folder of {} kept run(s)",
        folder.display(),
        files.len()
    );
    let mut runs = Vec::with_capacity(files.len());
    for file in &files {
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let contents = match read_recording(file, &ReadOptions::default()) {
            Ok(contents) => contents,
            Err(error) => {
                text += &format!("\n  {name}: cannot be read ({error})");
                runs.push(json!({ "file": file, "ended": "unreadable", "why": error.to_string() }));
                continue;
            }
        };
        let about = &contents.recording.about;
        let is_cut = |doubt| {
            matches!(
                RecordingDoubt::of(doubt),
                Some(RecordingDoubt::Interrupted { .. })
            )
        };
        let ended = match about.doubts.iter().any(is_cut) {
            true => "interrupted",
            false => "ended",
        };
        let condition = about.condition.to_string();
        text += &format!("\n  {name}: {:.3}, {ended}", contents.recording.duration());
        if !condition.is_empty() {
            text += &format!(", {condition}");
        }
        runs.push(json!({
            "file": file,
            "kind": contents.kind.to_string(),
            "duration_s": contents.recording.duration(),
            "ended": ended,
            "condition": about.condition,
            "steps": about.provenance.steps,
            "doubts": doubts_json(&about.doubts)?,
        }));
    }
    Ok(Kept {
        text,
        json: json!({ "file": folder, "kind": "kept runs", "runs": runs }),
    })
}

fn device(path: &Path) -> Outcome<Kept> {
    let device = read_device(&path.to_string_lossy())?;
    let mut text = format!(
        "{}\n  the description of a device: {}, {:.0} nF",
        path.display(),
        device.name(),
        device.actuator().capacitance_f * 1e9
    );
    for gain in device.gains() {
        text += &format!(
            "\n  gain {gain}: {:.4} times, up to {} V peak, {:.0} V/s into the actuator",
            gain.voltage_ratio(),
            gain.limit_v,
            gain.slew_limit_v_per_s(device.actuator().capacitance_f)
        );
    }
    text +=
        "\n  give it to `transfer` and `render` with --device, or to the twin as twin:device=FILE";
    Ok(Kept {
        text,
        json: json!({ "file": path, "kind": "description of a device", "device": device }),
    })
}
