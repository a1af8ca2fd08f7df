//! `piezotact analyse`: what the strokes of recordings hold.

use piezotact::Doubt;
use piezotact::study::{Group, Question, StudyAnalysis};
use serde_json::{Value, json};

use super::{analysed, check_outputs, settings, tables};
use crate::advice::text;
use crate::cli::Analyse;
use crate::failure::Outcome;
use crate::output::{doubts_json, print, print_json, say, write_text};
use crate::report;

pub(crate) fn run(args: &Analyse) -> Outcome {
    let computing = &args.computing;
    check_outputs(&args.takes, &[&computing.csv, &computing.report])?;
    let settings = settings(computing, Question::Groups(args.by.map(Into::into)))?;
    let study = analysed(&args.takes, &settings)?;
    if let Some(path) = &computing.csv {
        tables::write_strokes(path, &study.takes)?;
    }
    if let Some(path) = &computing.report {
        write_text(path, &report::touch::render(&study)?)?;
    }
    if computing.json {
        return print_json(&json(&study)?);
    }
    for doubt in study.doubts_in_words(&text) {
        say(&format!("doubt: {doubt}"));
    }
    for line in study.lines() {
        print(&line)?;
    }
    for path in [&computing.csv, &computing.report].into_iter().flatten() {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

fn json(study: &StudyAnalysis) -> Outcome<Value> {
    let mut recordings = Vec::with_capacity(study.takes.len());
    for take in &study.takes {
        let mut value = super::segment::cuts_json(take)?;
        if let (Some(fields), Some(analysis)) = (value.as_object_mut(), &take.analysis) {
            let cuts = fields.remove("strokes").unwrap_or_default();
            fields.insert("cuts".into(), cuts);
            fields.insert("unit".into(), json!(analysis.unit.symbol()));
            fields.insert("strokes".into(), serde_json::to_value(&analysis.strokes)?);
            fields.insert("config".into(), serde_json::to_value(&analysis.config)?);
        }
        recordings.push(value);
    }
    let all: Vec<Doubt> = study
        .groups
        .iter()
        .flat_map(|g| g.summary.doubts.clone())
        .collect();
    let groups = study.groups.iter().map(|group| group_json(study, group));
    Ok(json!({
        "by": study.by,
        "recordings": recordings,
        "groups": groups.collect::<Outcome<Vec<_>>>()?,
        "doubts": doubts_json(&all)?,
    }))
}

/// A group with its mean PSD.
pub(crate) fn group_json(study: &StudyAnalysis, group: &Group) -> Outcome<Value> {
    let mut value = serde_json::to_value(&group.summary)?;
    if let Some(fields) = value.as_object_mut() {
        let files: Vec<&str> = study
            .takes_of(group)
            .map(|take| take.name.as_str())
            .collect();
        fields.insert("files".into(), json!(files));
        fields.insert("doubts".into(), doubts_json(&group.summary.doubts)?);
        let psd = &group.summary.psd;
        fields.insert(
            "psd".into(),
            json!({
                "unit": group.summary.unit.of_psd(),
                "resolution_hz": psd.resolution_hz,
                "frequency_hz": psd.frequencies_hz(),
                "mean": psd.mean,
                "sd": psd.sd,
            }),
        );
    }
    Ok(value)
}
