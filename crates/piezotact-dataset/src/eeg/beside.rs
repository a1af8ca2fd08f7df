//! EEG with what stands beside it: names by BIDS, its JSON file, its table of channels, a table of positions.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use piezotact::quantity::Seconds;
use serde::Deserialize;

use super::{EegSegment, events, read_eeg};
use crate::error::ReadError;
use crate::input::{open_input, read_input_text};
use crate::matlab::looks_like_mat;
use crate::open::{ReadOptions, read_recording};

/// A file of EEG, with the person and task that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct EegSource {
    /// The kind of file, in words.
    pub kind: String,
    /// Its parts without a gap, at least one.
    pub segments: Vec<EegSegment>,
    /// The participant, if the name of the file or its content says so.
    pub participant: Option<String>,
    /// The task, if the name of the file or the JSON file beside it says so.
    pub task: Option<String>,
    /// The positions of electrodes that the file itself states: x to the right, y to the front, z up; empty where it states none.
    pub positions: Vec<StatedPosition>,
    /// The rows of the table of channels beside the file; empty where there is none.
    pub channels: Vec<ChannelRow>,
    /// The table of events beside a file with markers of its own, which are used; absent where there is none.
    pub events: Option<EventTable>,
}

/// A table of events beside a file with markers of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventTable {
    pub name: String,
    /// How many events it has.
    pub events: usize,
    /// How many of them have no marker of the file within one sample.
    pub without_marker: usize,
    /// How many markers the file has.
    pub markers: usize,
}

/// What a table of channels states of one (BIDS `_channels.tsv`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelRow {
    /// The name, as channels of the source are called.
    pub name: String,
    /// The column `type`.
    pub kind: Option<String>,
    /// The column `status`.
    pub status: Option<String>,
}

impl ChannelRow {
    /// Whether its status is bad.
    #[must_use]
    pub fn is_bad(&self) -> bool {
        let status = self.status.as_deref();
        status.is_some_and(|status| status.eq_ignore_ascii_case("bad"))
    }
}

/// What the JSON file of an EEG recording states (BIDS).
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "PascalCase", default)]
struct Stated {
    sampling_frequency: Option<f64>,
    task_name: Option<String>,
}

/// The position of an electrode.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedPosition {
    pub name: String,
    /// x, y and z in the unit and directions of the table.
    pub position: [f64; 3],
}

/// Reads EEG with what stands beside it: any EEG file as [`read_eeg`], XDF in parts between the gaps of its stream of EEG, other recordings as one part. The name of a BIDS file
/// (`sub-01_task-control_eeg.vhdr`) gives participant and task; `_eeg.json` and `_channels.tsv` beside it are held against it, and `_events.tsv`
/// gives the markers of a file that has none. Channels of EDF
/// and BDF are called by their electrodes: `EEG C3-Ref` is `C3` where all electrodes have the same reference.
///
/// # Errors
/// [`ReadError`] when the file cannot be read, or what stands beside it states another rate, other channels or another task.
pub fn read_eeg_source(path: &Path) -> Result<EegSource, ReadError> {
    let (mut kind, mut segments, positions) = read_segments(path)?;
    let named = |entity: &str| entity_of(path, entity);
    let stated = stated_beside(path)?;
    let task = named("task");
    if let Some((json, stated)) = &stated {
        check_rate(path, json, stated, &segments)?;
        if let (Some(task), Some(other)) = (&task, &stated.task_name)
            && compact(task) != compact(other)
        {
            return Err(ReadError::content(
                json,
                format!("TaskName `{task}`, as the name of {} states", shown(path)),
                format!("`{other}`"),
                "correct the one that is wrong",
            ));
        }
    }
    let mut channels = check_channels(path, &segments)?;
    if kind.starts_with("EDF") || kind.starts_with("BDF") {
        by_electrodes(&mut segments, &mut channels);
    }
    let mut beside = None;
    if let Some(table) = sibling(path, "events.tsv") {
        let (found, left_out) = events::read_events(&table)?;
        let markers = events::markers(&segments);
        if markers > 0 {
            beside = Some(EventTable {
                name: shown(&table),
                events: found.len(),
                without_marker: events::without_marker(&found, &segments),
                markers,
            });
        } else {
            segments[0].recording.about.warnings.extend(left_out);
        }
        if markers == 0 && !found.is_empty() {
            kind = format!("{kind}, markers of {}", shown(&table));
            events::put(found, &mut segments);
        }
    }
    let condition = &segments[0].recording.about.condition;
    Ok(EegSource {
        participant: named("sub").or_else(|| condition.participant.clone()),
        task: task.or_else(|| stated.and_then(|(_, stated)| stated.task_name)),
        kind,
        segments,
        positions,
        channels,
        events: beside,
    })
}

impl EegSource {
    /// Takes the markers of the table at `path` in the place of those of the file: columns `onset` (s from the first sample of the file), `duration`,
    /// and `trial_type` or `value` (BIDS `_events.tsv`).
    ///
    /// # Errors
    /// [`ReadError`] for another table, or one without an event.
    pub fn take_events(&mut self, path: &Path) -> Result<(), ReadError> {
        let (found, left_out) = events::read_events(path)?;
        self.segments[0].recording.about.warnings.extend(left_out);
        if found.is_empty() {
            return Err(ReadError::content(
                path,
                "events with an onset and a trial_type or value",
                "no such row",
                "give another table, or leave it out",
            ));
        }
        self.kind = format!("{}, markers of {}", self.kind, shown(path));
        events::put(found, &mut self.segments);
        self.events = None;
        Ok(())
    }
}

/// The files that are read with the one at `path`, itself among them: samples, markers, and what stands beside it by BIDS.
#[must_use]
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let mut found = vec![path.to_owned()];
    let ending = path.extension().and_then(|ending| ending.to_str());
    let ending = ending.unwrap_or_default().to_ascii_lowercase();
    if ending == "vhdr" {
        let named =
            crate::input::read_input(path).map(|bytes| super::brainvision::named(path, &bytes));
        found.extend(named.unwrap_or_default());
        found.extend(["eeg", "vmrk", "dat"].map(|own| path.with_extension(own)));
    }
    if ending == "set" {
        found.push(path.with_extension("fdt"));
    }
    found.extend(
        ["eeg.json", "channels.tsv", "events.tsv"]
            .into_iter()
            .filter_map(|own| sibling(path, own)),
    );
    let mut there: Vec<PathBuf> = Vec::new();
    for file in found {
        if file.is_file() && !there.contains(&file) {
            there.push(file);
        }
    }
    there
}

/// Calls channels by their electrodes, and the rows of the table too.
///
/// Source: EDF+ (B. Kemp and J. Olivan 2003, Clin. Neurophysiol. 114), 2.1.3: the label is the type of signal, a space, and the sensor.
fn by_electrodes(segments: &mut [EegSegment], rows: &mut [ChannelRow]) {
    const TYPE: &str = "EEG ";
    let first = segments[0].recording.channels().iter();
    let labels = first.filter_map(|channel| channel.name.strip_prefix(TYPE));
    let labels: Vec<String> = labels.map(|label| label.trim().to_owned()).collect();
    let behind = |label: &str| label.rsplit_once('-').map(|(_, behind)| behind.to_owned());
    let reference = labels.first().and_then(|label| behind(label));
    let reference = reference.filter(|own| {
        // Of two electrodes each the pairs are kept: C3-A2 and C4-A1.
        labels.len() > 1
            && labels
                .iter()
                .all(|label| behind(label).as_ref() == Some(own))
    });
    let name = |name: &str| match name.strip_prefix(TYPE).map(str::trim) {
        // `EOG VEOG` says its type twice.
        None if name
            .strip_prefix("EOG ")
            .is_some_and(|own| own.to_uppercase().contains("EOG")) =>
        {
            name["EOG ".len()..].trim().to_owned()
        }
        Some(label) if !label.is_empty() => match label.rsplit_once('-') {
            Some((electrode, _)) if reference.is_some() && !electrode.is_empty() => {
                electrode.trim().to_owned()
            }
            _ => label.to_owned(),
        },
        _ => name.to_owned(),
    };
    for segment in segments.iter_mut() {
        // All segments have the channels of the first: where two of it would share a name, nothing was changed yet.
        if segment.recording.rename(name).is_err() {
            return;
        }
    }
    for row in rows {
        row.name = name(&row.name);
    }
}

/// The kind of a file in words, its parts, and the positions that it states.
type Parts = (String, Vec<EegSegment>, Vec<StatedPosition>);

fn read_segments(path: &Path) -> Result<Parts, ReadError> {
    use std::io::Read as _;
    let mut head = Vec::new();
    open_input(path)?
        .take(1024)
        .read_to_end(&mut head)
        .map_err(|error| ReadError::io(path, &error))?;
    let is_eeg = super::looks_like_brainvision(&head)
        || super::looks_like_edf(&head)
        || super::looks_like_bdf(&head)
        || super::looks_like_markers(&head)
        || super::has_header_beside(path)
        || (looks_like_mat(&head)
            && path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("set")));
    if is_eeg {
        let file = read_eeg(path)?;
        return Ok((file.kind.to_string(), file.segments, file.positions));
    }
    if super::looks_like_xdf(&head) {
        let segments = super::xdf::segments_of_xdf(path, &crate::input::read_input(path)?)?;
        return Ok(("XDF".into(), segments, Vec::new()));
    }
    let contents = read_recording(path, &ReadOptions::default())?;
    let recording = contents.recording;
    let rates = recording.clocks().iter().map(|clock| clock.rate_hz.hz());
    let rate_hz = rates.fold(0.0, f64::max);
    let events = recording.annotations.events.iter();
    let samples = events.map(|event| (event.onset_s.0 * rate_hz).round_ties_even() as i64);
    let segment = EegSegment {
        event_samples: samples.collect(),
        recording,
        start_s: Seconds(0.0),
    };
    Ok((contents.kind.to_string(), vec![segment], Vec::new()))
}

/// The label of an entity in a name by BIDS: `control` of `task` in `sub-01_task-control_eeg.vhdr`.
fn entity_of(path: &Path, entity: &str) -> Option<String> {
    let stem = path.file_name()?.to_str()?;
    let stem = stem.split('.').next()?;
    let mut parts = stem.split('_');
    let found = parts.find_map(|part| part.strip_prefix(entity)?.strip_prefix('-'));
    found.filter(|label| !label.is_empty()).map(str::to_owned)
}

/// The file beside `path` that a BIDS recording has, `sub-01_task-control_eeg.vhdr` → `sub-01_task-control_SUFFIX`.
fn sibling(path: &Path, suffix: &str) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_str()?;
    let stem = stem.strip_suffix("_eeg")?;
    let beside = path.with_file_name(format!("{stem}_{suffix}"));
    beside.is_file().then_some(beside)
}

/// What stands in the place of such a file and is none: a link that leads nowhere, a folder.
fn unreadable(path: &Path, suffix: &str) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_str()?.strip_suffix("_eeg")?.to_owned();
    let beside = path.with_file_name(format!("{stem}_{suffix}"));
    (std::fs::symlink_metadata(&beside).is_ok() && !beside.is_file()).then_some(beside)
}

fn stated_beside(path: &Path) -> Result<Option<(PathBuf, Stated)>, ReadError> {
    let Some(json) = sibling(path, "eeg.json") else {
        return Ok(None);
    };
    let text = read_input_text(&json)?;
    match serde_json::from_str(&text) {
        Ok(stated) => Ok(Some((json, stated))),
        Err(error) => Err(ReadError::content(
            &json,
            "the JSON file of an EEG recording (SamplingFrequency, TaskName)",
            format!("another content ({error})"),
            "correct it, or move it away",
        )),
    }
}

fn check_rate(
    path: &Path,
    json: &Path,
    stated: &Stated,
    segments: &[EegSegment],
) -> Result<(), ReadError> {
    let Some(stated_hz) = stated.sampling_frequency else {
        return Ok(());
    };
    let clocks = segments[0].recording.clocks();
    // A channel of another rate, such as a trigger, is no contradiction.
    let same = |hz: f64| (hz - stated_hz).abs() <= 1e-4 * hz;
    if clocks.iter().any(|clock| same(clock.rate_hz.hz())) {
        return Ok(());
    }
    let found: Vec<String> = clocks
        .iter()
        .map(|clock| clock.rate_hz.to_string())
        .collect();
    Err(ReadError::content(
        json,
        format!(
            "SamplingFrequency {}, the rate of {}",
            found.join(" or "),
            shown(path)
        ),
        format!("{stated_hz} Hz"),
        "correct the one that is wrong: all times depend on it",
    ))
}

/// Holds the channels of the file against the table beside it; its rows.
fn check_channels(path: &Path, segments: &[EegSegment]) -> Result<Vec<ChannelRow>, ReadError> {
    let Some(table) = sibling(path, "channels.tsv") else {
        if let Some(broken) = unreadable(path, "channels.tsv") {
            return Err(ReadError::content(
                &broken,
                "a table of channels",
                "something that is no file, or a link that leads nowhere",
                "fetch the file (git annex get), or move it away",
            ));
        }
        return Ok(Vec::new());
    };
    let (header, rows) = table_of(&table)?;
    let Some(name) = header.iter().position(|column| column == "name") else {
        return Err(ReadError::content(
            &table,
            "a column `name`",
            header.join(", "),
            "add it",
        ));
    };
    let stated: Vec<&String> = rows.iter().filter_map(|row| row.get(name)).collect();
    let channels = segments[0].recording.channels();
    let there: Vec<&String> = channels.iter().map(|channel| &channel.name).collect();
    let [set_of_stated, set_of_there] =
        [&stated, &there].map(|names| names.iter().copied().collect::<BTreeSet<_>>());
    let missing = stated.iter().find(|name| !set_of_there.contains(*name));
    let further = there.iter().find(|name| !set_of_stated.contains(*name));
    let (found, todo) = match (missing, further) {
        (Some(missing), Some(further)) => (
            format!("`{missing}` in the table and `{further}` in the recording"),
            "give the channel one name in both",
        ),
        (Some(missing), None) => (
            format!("`{missing}` in the table alone"),
            "take its row out, or export all channels",
        ),
        (None, Some(further)) => (format!("`{further}` in the recording alone"), "add its row"),
        (None, None) => {
            let column = |name: &str| header.iter().position(|column| column == name);
            let (kind, status) = (column("type"), column("status"));
            let cell = |row: &Vec<String>, at: Option<usize>| {
                let text = row.get(at?)?;
                Some(text.clone()).filter(|text| !text.is_empty() && text != "n/a")
            };
            let odd = rows.iter().filter_map(|row| cell(row, status));
            let odd = odd.into_iter().find(|status| {
                !["good", "bad"]
                    .iter()
                    .any(|known| status.eq_ignore_ascii_case(known))
            });
            if let Some(odd) = odd {
                return Err(ReadError::content(
                    &table,
                    "the status good, bad or n/a",
                    format!("`{odd}`"),
                    "correct it",
                ));
            }
            let row = |row: &Vec<String>| {
                Some(ChannelRow {
                    name: row.get(name)?.clone(),
                    kind: cell(row, kind),
                    status: cell(row, status),
                })
            };
            return Ok(rows.iter().filter_map(row).collect());
        }
    };
    Err(ReadError::content(
        &table,
        format!("the channels of {}", shown(path)),
        found,
        todo,
    ))
}

/// Reads positions of electrodes: a table with columns `name`, `x`, `y` and `z` between tabs or commas (BIDS `_electrodes.tsv`). Rows
/// without a position (`n/a`) are left out.
///
/// # Errors
/// [`ReadError`] when a column is missing, a cell is no number, or no row has a position.
pub fn read_electrodes(path: &Path) -> Result<Vec<StatedPosition>, ReadError> {
    let (header, rows) = table_of(path)?;
    let column = |name: &str| {
        let found = header.iter().position(|own| own.eq_ignore_ascii_case(name));
        found.ok_or_else(|| {
            ReadError::content(
                path,
                "columns name, x, y and z",
                header.join(", "),
                format!("add the column {name}"),
            )
        })
    };
    let (name, axes) = (column("name")?, [column("x")?, column("y")?, column("z")?]);
    let mut found = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let cell = |at: usize| row.get(at).map_or("", String::as_str);
        if axes.iter().any(|at| matches!(cell(*at), "n/a" | "")) {
            continue;
        }
        let mut position = [0.0; 3];
        for (value, at) in position.iter_mut().zip(axes) {
            *value = cell(at).parse().map_err(|_no_number| {
                ReadError::content(
                    path,
                    format!("a number in row {}", number + 2),
                    format!("`{}`", cell(at)),
                    "correct it, or write n/a",
                )
            })?;
        }
        found.push(StatedPosition {
            name: cell(name).to_owned(),
            position,
        });
    }
    let mut names = BTreeSet::new();
    if let Some(twice) = found.iter().find(|one| !names.insert(one.name.as_str())) {
        return Err(ReadError::content(
            path,
            "each electrode once",
            format!("`{}` twice", twice.name),
            "remove one of the rows",
        ));
    }
    if found.is_empty() {
        return Err(ReadError::content(
            path,
            "positions of electrodes",
            "no row with x, y and z",
            "give another table, or leave it out",
        ));
    }
    Ok(found)
}

/// The header and the rows of a table between tabs or commas.
pub(super) fn table_of(path: &Path) -> Result<(Vec<String>, Vec<Vec<String>>), ReadError> {
    let text = read_input_text(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let first = text.lines().next().unwrap_or_default();
    let between = if first.contains('\t') { '\t' } else { ',' };
    let cells = |line: &str| -> Vec<String> {
        line.split(between)
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let header = cells(lines.next().unwrap_or_default());
    Ok((header, lines.map(cells).collect()))
}

/// A name without what programs write differently: `natural touch` and `naturaltouch`.
fn compact(text: &str) -> String {
    let letters = text.chars().filter(|sign| sign.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

fn shown(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
