//! What `piezotact info` says of files and folders that are no recording: panels, kept runs, descriptions of devices.

use std::path::Path;

use anyhow::anyhow;
use piezotact_dataset::document::{DeviceInfo, InfoDocument, PanelIndexInfo, RunInfo, RunsInfo};
use piezotact_dataset::{PANEL_INDEX, read_device};

use crate::failure::{Failure, Outcome};
use crate::report::name;

/// What there is, in words and as data.
pub(super) struct Kept<'a> {
    pub(super) text: String,
    pub(super) document: InfoDocument<'a>,
}

/// What stands at `path`; `None` where it is a file of another kind.
pub(super) fn of(path: &Path) -> Outcome<Option<Kept<'_>>> {
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

fn panel(folder: &Path, index: &Path) -> Outcome<Kept<'static>> {
    let info = PanelIndexInfo::of(
        index,
        format!("piezotact panel analyse {}", folder.display()),
    )?;
    Ok(Kept {
        text: format!(
            "{}\n  the index of a panel of {} transfer function(s)\n  read it with `{}`",
            index.display(),
            info.measurements,
            info.read_with
        ),
        document: InfoDocument::Panel(info),
    })
}

/// The runs that a command kept in a folder: what each is, and how it ended.
fn runs(folder: &Path) -> Outcome<Kept<'static>> {
    let info = RunsInfo::of(folder)?;
    if info.runs.is_empty() {
        return Err(Failure::Data(anyhow!(
            "{}: expected a folder of kept runs, found no run in it; give the folder OUT.runs in which a command keeps its runs",
            folder.display()
        )));
    }
    let mut text = format!(
        "{}\n  a folder of {} kept run(s)",
        folder.display(),
        info.runs.len()
    );
    for run in &info.runs {
        text += "\n  ";
        text += &run_text(run);
    }
    Ok(Kept {
        text,
        document: InfoDocument::Runs(info),
    })
}

fn run_text(run: &RunInfo) -> String {
    match run {
        RunInfo::Unreadable { file, why, .. } => format!("{}: cannot be read ({why})", name(file)),
        RunInfo::Read {
            file,
            duration_s,
            ended,
            condition,
            ..
        } => {
            let text = format!("{}: {duration_s:.3}, {ended}", name(file));
            match condition.to_string() {
                nothing if nothing.is_empty() => text,
                condition => format!("{text}, {condition}"),
            }
        }
    }
}

fn device(path: &Path) -> Outcome<Kept<'_>> {
    let device = read_device(&path.to_string_lossy())?;
    let mut text = format!(
        "{}\n  the description of a device: {}, {}",
        path.display(),
        device.name(),
        device.actuator().load()
    );
    for gain in device.gains() {
        text += &format!(
            "\n  gain {gain}: ratio {:.4}, limit {} V peak, {}",
            gain.voltage_ratio(),
            gain.limit_v,
            match gain.slew_limit_v_per_s(device.actuator().capacitance_f) {
                Some(slope) => format!("slew limit {slope:.0} V/s with the actuator"),
                None => "no slew limit".into(),
            }
        );
    }
    text +=
        "\n  use it in `transfer` and `render` with --device, or in the twin as twin:device=FILE";
    Ok(Kept {
        text,
        document: InfoDocument::Device(DeviceInfo {
            file: path,
            kind: "description of a device",
            device,
        }),
    })
}
