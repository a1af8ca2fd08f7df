//! Tidy tables: one row for each stroke, one column for each variable, units in the names.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::anyhow;
use piezotact::criterion::Criterion;
use piezotact::feature::{Moments, Receptor, Statistics};
use piezotact::stroke::StrokeCriterion;
use piezotact::study::Take;
use serde::Serialize;

use crate::failure::{Failure, Outcome};
use crate::output::write_text;

fn text_of(rows: &[Vec<String>]) -> Outcome<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| anyhow!("a table could not be written: {error}"))?;
    String::from_utf8(bytes).map_err(Failure::from)
}

/// The labels that recordings have beside what the columns of a condition say, in the order of their names.
fn labels(takes: &[Take]) -> BTreeSet<&str> {
    let names = takes.iter().flat_map(|take| take.labels.keys());
    let own = |name: &&str| !IN_CONDITION.contains(name);
    names.map(String::as_str).filter(own).collect()
}

/// The labels that a condition takes from a name.
const IN_CONDITION: [&str; 6] = ["sample", "participant", "load", "speed", "angle", "touch"];

/// The cells of a recording's labels, empty where it has none of that name.
fn label_cells<'a>(
    take: &'a Take,
    labels: &'a BTreeSet<&str>,
) -> impl Iterator<Item = String> + 'a {
    let cell = |name: &&str| take.labels.get(*name).cloned().unwrap_or_default();
    labels.iter().map(cell)
}

fn label_names(labels: &BTreeSet<&str>) -> impl Iterator<Item = String> {
    labels.iter().map(|name| format!("label_{name}"))
}

/// A name as documents have it: `steady_part`.
fn code(what: &impl Serialize) -> Outcome<String> {
    let text = serde_json::to_value(what)?;
    Ok(text.as_str().unwrap_or_default().to_owned())
}

/// One row for each stroke and each reject. Every criterion that was judged has the columns `WHAT_found`, `WHAT_limit` (of
/// the size, where it is a limit to both sides) and `WHAT_outcome`, empty where it was not judged.
pub(crate) fn write_cuts(path: &Path, takes: &[Take]) -> Outcome {
    let header = [
        "file",
        "kind",
        "start_s",
        "end_s",
        "contact_start_s",
        "contact_end_s",
        "cut_by",
        "reason",
    ];
    let labels = labels(takes);
    let mut judged: Vec<StrokeCriterion> = Vec::new();
    for take in takes {
        let of_strokes = take.segmentation.strokes.iter().flat_map(|s| &s.criteria);
        let of_rejects = take.segmentation.rejected.iter().flat_map(|r| &r.criteria);
        for criterion in of_strokes.chain(of_rejects) {
            if !judged.contains(&criterion.what) {
                judged.push(criterion.what);
            }
        }
    }
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    rows[0].extend(label_names(&labels));
    for what in &judged {
        let what = code(what)?;
        rows[0].extend(["found", "limit", "outcome"].map(|of| format!("{what}_{of}")));
    }
    let criteria = |row: &mut Vec<String>, of: &[Criterion<StrokeCriterion>]| -> Outcome {
        for what in &judged {
            let criterion = of.iter().find(|criterion| criterion.what == *what);
            row.push(optional(criterion.and_then(|c| c.found)));
            row.push(optional(criterion.map(|c| c.limit.value())));
            row.push(criterion.map_or(Ok(String::new()), |c| code(&c.outcome))?);
        }
        Ok(())
    };
    for take in takes {
        let s = |sample: usize| take.seconds(sample).to_string();
        for stroke in &take.segmentation.strokes {
            let mut row = vec![
                take.name.clone(),
                "stroke".into(),
                s(stroke.steady.start),
                s(stroke.steady.end),
                s(stroke.contact.start),
                s(stroke.contact.end),
                format!("{:?}", stroke.cut_by).to_lowercase(),
                String::new(),
            ];
            row.extend(label_cells(take, &labels));
            criteria(&mut row, &stroke.criteria)?;
            rows.push(row);
        }
        for rejected in &take.segmentation.rejected {
            let (start, end) = (s(rejected.interval.start), s(rejected.interval.end));
            let mut row = vec![
                take.name.clone(),
                "rejected".into(),
                start.clone(),
                end.clone(),
                start,
                end,
                String::new(),
                rejected.reason.to_string(),
            ];
            row.extend(label_cells(take, &labels));
            criteria(&mut row, &rejected.criteria)?;
            rows.push(row);
        }
    }
    write_text(path, &text_of(&rows)?)
}

/// One row for each stroke with all its features; an empty cell for what was not measured.
pub(crate) fn write_strokes(path: &Path, takes: &[Take]) -> Outcome {
    let labels = labels(takes);
    let mut rows = vec![header()];
    rows[0].extend(label_names(&labels));
    for take in takes {
        let Some(analysis) = &take.analysis else {
            continue;
        };
        let condition = take.condition();
        for (i, stroke) in analysis.strokes.iter().enumerate() {
            let mut row = vec![
                take.name.clone(),
                condition.sample.clone().unwrap_or_default(),
                condition.participant.clone().unwrap_or_default(),
                condition
                    .touch
                    .map_or(String::new(), |touch| format!("{touch:?}").to_lowercase()),
                optional(condition.load_n.map(|load| load.0)),
                optional(condition.speed_m_s),
                (i + 1).to_string(),
                stroke.start_s.to_string(),
                stroke.duration_s.to_string(),
                analysis.unit.symbol().to_owned(),
                stroke.rms.to_string(),
                stroke.peak.to_string(),
                stroke.crest_factor.to_string(),
            ];
            row.extend(stroke.receptor_power.iter().map(f64::to_string));
            row.extend(
                [stroke.centroid_hz, stroke.spread_hz, stroke.strongest_hz]
                    .iter()
                    .map(f64::to_string),
            );
            row.extend(statistics(stroke.friction_coefficient));
            row.extend(moments(stroke.normal_force_n));
            row.extend(moments(stroke.speed_m_s));
            row.push(optional(stroke.pacinian_power));
            row.push(optional(stroke.detection_power));
            row.extend(label_cells(take, &labels));
            rows.push(row);
        }
    }
    write_text(path, &text_of(&rows)?)
}

fn header() -> Vec<String> {
    let mut names: Vec<String> = [
        "file",
        "sample",
        "participant",
        "touch",
        "load_n",
        "stated_speed_m_s",
        "stroke",
        "start_s",
        "duration_s",
        "unit",
        "rms",
        "peak",
        "crest_factor",
    ]
    .map(str::to_owned)
    .to_vec();
    names.extend(Receptor::ALL.map(|receptor| format!("{}_power", receptor.name().to_lowercase())));
    names.extend(["centroid_hz", "spread_hz", "strongest_hz"].map(str::to_owned));
    names.extend(["mean", "sd", "median"].map(|kind| format!("friction_{kind}")));
    for (what, unit) in [("normal_force", "n"), ("speed", "m_s")] {
        names.extend(["mean", "sd"].map(|kind| format!("{what}_{kind}_{unit}")));
    }
    names.extend(["pacinian_power", "detection_power"].map(str::to_owned));
    names
}

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

fn statistics(value: Option<Statistics>) -> [String; 3] {
    match value {
        Some(s) => [s.mean, s.sd, s.median].map(|v| v.to_string()),
        None => [String::new(), String::new(), String::new()],
    }
}

fn moments(value: Option<Moments>) -> [String; 2] {
    match value {
        Some(m) => [m.mean.to_string(), m.sd.to_string()],
        None => [String::new(), String::new()],
    }
}
