//! What was computed of a study, as values that a data set holds beside the measured ones.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::anyhow;
use piezotact::device::DeviceDescription;
use piezotact::page::{Cell, Column, Table};
use piezotact::quantity::{Acceleration, Drive};
use piezotact::study::{AnalysedRecording, strokes_table};
use piezotact::transfer::TransferFunction;
use piezotact_dataset::{
    ConfidenceColumns, ReadOptions, TransferDocument, read_recording, read_transfer,
    texture_file_name,
};
use piezotact_people::association::{
    AnswerTable, AssociationConfig, Grouping, MatrixConfig, associate,
};
use piezotact_people::campaign::dictionary::{ColumnMeaning, columns_of};
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::readiness::stimuli_of;
use piezotact_study::bids::{Derived, Sources, Touched, unit_text, warnings_carried};
use serde_json::json;

use crate::commands::campaign::study::Study;
use crate::commands::verify::verified;
use crate::failure::{Failure, Outcome, usage};

/// A derived value with everything that it is written with.
pub(super) struct Owned {
    of: Option<(String, Option<String>)>,
    task: Option<String>,
    sample: Option<String>,
    desc: &'static str,
    suffix: &'static str,
    table: Table,
    columns: BTreeMap<String, ColumnMeaning>,
    description: &'static str,
    provenance: serde_json::Value,
    sources: MadeOf,
}

/// What a value was made from.
enum MadeOf {
    /// A recording, re the folder of the session.
    Recording(Vec<String>),
    /// The drive of its stimulus.
    Drive,
    /// All answers.
    Answers,
}

impl Owned {
    pub(super) fn borrowed(&self) -> Derived<'_> {
        Derived {
            of: (self.of.as_ref())
                .map(|(participant, session)| (participant.as_str(), session.as_deref())),
            task: self.task.as_deref(),
            sample: self.sample.as_deref(),
            desc: self.desc,
            suffix: self.suffix,
            table: &self.table,
            columns: self.columns.clone(),
            description: self.description,
            provenance: self.provenance.clone(),
            sources: match &self.sources {
                MadeOf::Recording(files) => Sources::Session(files),
                MadeOf::Drive => Sources::Drive,
                MadeOf::Answers => Sources::Answers,
            },
        }
    }
}

fn columns(names: &[&str]) -> Table {
    Table::new(names.iter().map(|name| Column::new(name, name)))
}

/// The mean power spectral density of the strokes of `take`, and the features of each.
pub(super) fn of_strokes(take: &AnalysedRecording, of: &Touched<'_>, written: &str) -> Vec<Owned> {
    let Some(analysis) = &take.analysis else {
        return Vec::new();
    };
    let unit = unit_text(&analysis.unit);
    let mut of_psd = columns_of("psd");
    for name in ["mean", "sd"] {
        if let Some(column) = of_psd.get_mut(name) {
            column.units = Some(format!("({unit})^2/Hz"));
        }
    }
    let features = columns_of("features");
    let mut psd = columns(&["frequency", "mean", "sd"]);
    let spectra = &analysis.psd;
    let strokes = spectra.each.len();
    let lines = spectra.frequency_hz.iter().copied();
    let lines = lines.zip(spectra.mean.iter().zip(&spectra.sd));
    psd.rows = lines
        .map(|(hz, (mean, sd))| {
            vec![
                Cell::from(hz),
                Cell::from(*mean),
                Cell::from((strokes > 1).then_some(*sd)),
            ]
        })
        .collect();
    // What was done before is said where it was done.
    let [of_psds, of_features] = match analysis.config.high_pass {
        Some(_) => [
            "Power spectral density of the friction-induced vibration, by Welch's method over each stroke, after a high-pass forward and back (zero phase) of the recording; the settings state its order and frequency.",
            "Features of each stroke, in SI units, after a high-pass forward and back (zero phase) of the recording; the settings state its order and frequency. Rms and peak are about the mean of the stroke, the normal force is above its zero.",
        ],
        None => [
            "Power spectral density of the friction-induced vibration, by Welch's method over each stroke, without a high-pass.",
            "Features of each stroke, in SI units, without a high-pass. Rms and peak are about the mean of the stroke, the normal force is above its zero.",
        ],
    };
    let warnings = warnings_carried(of.recording.about.provenance.bench, take.warnings());
    let settings = json!({ "settings": analysis.config, "warnings": warnings });
    let owned = |desc, suffix, table, columns, description| Owned {
        of: Some((of.participant.to_owned(), of.session.map(str::to_owned))),
        task: Some(of.task.to_owned()),
        sample: of.sample.map(str::to_owned),
        desc,
        suffix,
        table,
        columns,
        description,
        provenance: settings.clone(),
        sources: MadeOf::Recording(vec![written.to_owned()]),
    };
    vec![
        owned("strokes", "psd", psd, of_psd, of_psds),
        owned(
            "strokes",
            "features",
            of_columns(strokes_table(std::slice::from_ref(take)), &features),
            features,
            of_features,
        ),
    ]
}

/// How close each drive came to its target when it was prepared.
pub(super) fn of_drives(
    (participant, session): (&str, &str),
    folder: &Path,
    plan: &Plan,
) -> Outcome<Vec<Owned>> {
    let mut all = Vec::new();
    for stimulus in stimuli_of(plan) {
        let file = |part: &str, ending: &str| {
            folder
                .join(part)
                .join(format!("{}.{ending}", texture_file_name(stimulus)))
        };
        let (target, drive, measured) = (
            file("targets", "wav"),
            file("drives", "wav"),
            file("measured", "parquet"),
        );
        if ![&target, &drive, &measured]
            .iter()
            .all(|file| file.is_file())
        {
            continue;
        }
        let rendering = read_recording(&drive, &ReadOptions::default())?.rendering;
        let Some(rendering) = rendering else { continue };
        let verification = verified(&target, &measured, rendering.config.inverse.band)?;
        let mut table = columns(&[
            "criterion",
            "found",
            "low",
            "high",
            "limit",
            "unit",
            "outcome",
        ]);
        table.rows = verification
            .criteria
            .iter()
            .map(|one| {
                let [low, high] = one.interval.map_or([None; 2], |ends| ends.map(Some));
                vec![
                    Cell::from(one.what.to_string()),
                    Cell::from(one.found),
                    Cell::from(low),
                    Cell::from(high),
                    Cell::from(one.limit.value()),
                    Cell::from(one.unit.as_ref()),
                    Cell::from(one.outcome.word()),
                ]
            })
            .collect();
        let provenance = json!({
            "verdict": verification.sentence(),
            "band_hz": rendering.config.inverse.band,
            "warnings": verification.warnings,
        });
        all.push(Owned {
            of: Some((participant.to_owned(), Some(session.to_owned()))),
            task: None,
            sample: Some(stimulus.to_owned()),
            desc: "prepared",
            suffix: "verification",
            table,
            columns: columns_of("verification"),
            description: "How close the drive came to the recorded stroke when it was prepared: the criteria that decide.",
            provenance,
            sources: MadeOf::Drive,
        });
    }
    Ok(all)
}

/// Removes the names that somebody gave a device and its gains.
fn without_names(value: &mut serde_json::Value) {
    if let Some(fields) = value.as_object_mut() {
        let is_name = |key: &str| ["name", "gain", "usual_gain"].contains(&key);
        fields.retain(|key, value| !(is_name(key) && value.is_string()));
        fields.values_mut().for_each(without_names);
    }
    if let Some(each) = value.as_array_mut() {
        each.iter_mut().for_each(without_names);
    }
}

/// The transfer function in `path`, of `otherwise` where it names nobody; `people` are those of the data set, each with the session
/// where there are sessions.
pub(super) fn of_transfer(
    path: &Path,
    otherwise: Option<&str>,
    people: &BTreeMap<String, Option<String>>,
) -> Outcome<Owned> {
    let mut function = read_transfer(path)?.function::<Drive, Acceleration>(path)?;
    let named = function.about.condition.participant.as_deref();
    let participant = named.or(otherwise).unwrap_or_default().to_owned();
    let Some(session) = people.get(&participant).cloned() else {
        return Err(usage(anyhow!(
            "{}: expected the transfer function of a participant of the data set ({}), found {}; leave it out",
            path.display(),
            people.keys().cloned().collect::<Vec<_>>().join(", "),
            if participant.is_empty() {
                "one that names nobody".to_owned()
            } else {
                format!("one of {participant}")
            }
        )));
    };
    let about = &mut function.about;
    let bench = about.provenance.bench;
    about.warnings = warnings_carried(bench, std::mem::take(&mut about.warnings));
    if bench.is_none() {
        // Files and channels of another program.
        about.provenance.source.clear();
        about.provenance.steps.clear();
    }
    let document = TransferDocument::of(
        &function,
        piezotact::quantity::Unit::FullScale,
        piezotact::quantity::Unit::MetrePerSecondSquared,
    );
    let table = transfer_table(&function, document.confidence.as_ref());
    let mut provenance = serde_json::to_value(&document)?;
    if let Some(provenance) = provenance.as_object_mut() {
        // They stand in the table.
        for column in [
            "frequency_hz",
            "real",
            "imaginary",
            "coherence",
            "confidence",
        ] {
            provenance.remove(column);
        }
        let device = function.drive.as_ref().map(|drive| drive.device().name());
        let is_own =
            device.is_some_and(|name| DeviceDescription::built_in(&name.to_lowercase()).is_none());
        if let (true, Some(drive)) = (is_own, provenance.get_mut("drive")) {
            without_names(drive);
        }
    }
    Ok(Owned {
        of: Some((participant, session)),
        task: None,
        sample: None,
        desc: "device",
        suffix: "transfer",
        table,
        columns: columns_of("transfer"),
        description: "Transfer function from the digital drive (full scale = 1) to the acceleration of the fingernail, with the finger on the device.",
        provenance,
        // The measurement that it was estimated from is not part of the study.
        sources: MadeOf::Recording(Vec::new()),
    })
}

fn transfer_table(
    function: &TransferFunction<Drive, Acceleration>,
    limits: Option<&ConfidenceColumns>,
) -> Table {
    let mut table = columns(&[
        "frequency",
        "real",
        "imaginary",
        "coherence",
        "magnitude_low",
        "magnitude_high",
        "phase_reach",
    ]);
    let coherence = function.has_coherence().then(|| function.coherence());
    table.rows = function
        .frequencies_hz()
        .into_iter()
        .zip(function.response())
        .enumerate()
        .map(|(line, (hz, h))| {
            let coherence = coherence.and_then(|all| all.get(line).copied());
            vec![
                Cell::from(hz),
                Cell::from(h.re),
                Cell::from(h.im),
                Cell::from(coherence),
                Cell::from(limits.and_then(|all| all.low.get(line).copied())),
                Cell::from(limits.and_then(|all| all.high.get(line).copied().flatten())),
                Cell::from(limits.and_then(|all| all.phase_reach_rad.get(line).copied())),
            ]
        })
        .collect();
    table
}

/// `table` with the columns that are `known` alone: names of files and labels that somebody typed may tell who somebody is.
fn of_columns(mut table: Table, known: &BTreeMap<String, ColumnMeaning>) -> Table {
    let names = table.columns.iter().map(|column| column.name.as_str());
    let kept: Vec<bool> = names.map(|name| known.contains_key(name)).collect();
    let mut keeps = kept.iter();
    table.columns.retain(|_| keeps.next() == Some(&true));
    for row in &mut table.rows {
        let mut keeps = kept.iter();
        row.retain(|_| keeps.next() == Some(&true));
    }
    table
}

/// `table` with nothing in the cells that say so in words.
fn without_words(mut table: Table) -> Table {
    for cell in table.rows.iter_mut().flatten() {
        if *cell == Cell::from("n/a") {
            *cell = Cell::Missing(());
        }
    }
    table
}

/// The association matrices of the study, by task, and its thresholds; none where nothing was answered.
pub(super) fn of_answers(study: &Study) -> Outcome<Vec<Owned>> {
    let mut all = Vec::new();
    let (declared, mut answers) = study.answers()?;
    answers.retain(|answer| answer.purpose == piezotact_people::association::Purpose::Trial);
    if !answers.is_empty() {
        let mut ordering_tasks = study.orders();
        ordering_tasks.retain(|task| answers.iter().any(|answer| answer.task == *task));
        let table =
            AnswerTable::new(declared, answers).map_err(|error| Failure::Data(error.into()))?;
        let asked = AssociationConfig {
            matrix: MatrixConfig::default(),
            by: Some(Grouping::Task),
            ordering_tasks,
        };
        // Orders that cannot be scored are no reason to leave the matrices out.
        let found = associate(&table, &asked).or_else(|_| {
            let without = AssociationConfig {
                ordering_tasks: Vec::new(),
                ..asked.clone()
            };
            associate(&table, &without)
        });
        let found = found.map_err(|error| Failure::Data(error.into()))?;
        all.push(Owned {
            of: None,
            task: None,
            sample: None,
            desc: "association",
            suffix: "matrix",
            table: without_words(found.cells_table()),
            columns: columns_of("matrix"),
            description: "Association matrices: what was presented, and what it was declared to be; one row for each cell, with a 95 % interval over participants.",
            provenance: json!({ "settings": found.config, "sentence": found.sentence(), "warnings": found.warnings }),
            sources: MadeOf::Answers,
        });
    }
    let thresholds = study.thresholds()?;
    if !thresholds.rows.is_empty() {
        all.push(Owned {
            of: None,
            task: None,
            sample: None,
            desc: "adaptive",
            suffix: "thresholds",
            table: thresholds,
            columns: columns_of("thresholds"),
            description: "Thresholds of adaptive comparisons, in the unit of their levels.",
            provenance: json!({}),
            sources: MadeOf::Answers,
        });
    }
    Ok(all)
}
