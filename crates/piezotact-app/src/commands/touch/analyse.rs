//! `piezotact analyse`: what the strokes of recordings hold.

use piezotact::Doubt;
use piezotact::compare::Summary;
use piezotact::feature::Statistics;
use serde_json::{Value, json};

use super::segment::check_outputs;
use super::{Cell, Take, analyse_all, cells, doubts_once, ridge_m, sample_sets, tables, take_all};
use crate::cli::{Analyse, By};
use crate::failure::Outcome;
use crate::output::{digits, doubts_json, print, print_json, say, write_text};
use crate::report;

pub(crate) fn run(args: &Analyse) -> Outcome {
    let computing = &args.computing;
    check_outputs(&args.takes, &[&computing.csv, &computing.report])?;
    let (sets, ridge_m) = (sample_sets(computing)?, ridge_m(computing)?);
    let mut takes = take_all(&args.takes)?;
    analyse_all(&mut takes, computing)?;
    let by = args.by.unwrap_or_else(|| usual(&takes));
    let groups = cells(&takes, by, &sets, ridge_m)?;
    if let Some(path) = &computing.csv {
        tables::write_strokes(path, &takes)?;
    }
    if let Some(path) = &computing.report {
        let page = report::touch::Page {
            title: format!(
                "What the strokes say, by {}",
                format!("{by:?}").to_lowercase()
            ),
            takes: &takes,
            groups: &groups,
            sets: &sets,
            ridge_m,
            discrimination: None,
        };
        write_text(path, &report::touch::render(&page)?)?;
    }
    if computing.json {
        return print_json(&json(&takes, &groups, by)?);
    }
    for doubt in doubts_once(&takes, &groups) {
        say(&format!("doubt: {doubt}"));
    }
    for group in &groups {
        print(&line(&group.summary))?;
    }
    for path in [&computing.csv, &computing.report].into_iter().flatten() {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

/// By sample where every analysed recording names one, else each file by itself.
fn usual(takes: &[Take]) -> By {
    let mut analysed = takes.iter().filter(|take| take.analysis.is_some());
    if analysed.all(|take| take.condition().sample.is_some()) {
        By::Sample
    } else {
        By::File
    }
}

/// A group in one line.
pub(crate) fn line(summary: &Summary) -> String {
    let several = summary.strokes > 1;
    let spread = |s: Statistics, decimals: fn(f64) -> String| {
        if several {
            format!("{} ± {}", decimals(s.mean), decimals(s.sd))
        } else {
            decimals(s.mean)
        }
    };
    let mut text = format!(
        "{}: {} stroke{}, rms {} {}",
        summary.name,
        summary.strokes,
        if several { "s" } else { "" },
        spread(summary.rms, digits),
        if summary.unit.symbol() == "no unit" {
            "(no unit)"
        } else {
            summary.unit.symbol()
        },
    );
    if let Some(friction) = summary.friction_coefficient {
        text += &format!(", friction {}", spread(friction, |v| format!("{v:.3}")));
    }
    if let Some(force) = summary.normal_force_n {
        text += &format!(", {:.3} N", force.mean);
    }
    if let Some(speed) = summary.speed_m_s {
        text += &format!(", {:.1} mm/s", speed.mean * 1e3);
    }
    text += &format!(
        ", centroid {} Hz, strongest {} Hz",
        digits(summary.centroid_hz.mean),
        digits(summary.strongest_hz)
    );
    if let Some(found_hz) = summary.fingerprint.and_then(|f| f.found_hz) {
        text += &format!(", fingerprint {} Hz", digits(found_hz));
    }
    if !summary.machine_lines_hz.is_empty() {
        let lines: Vec<String> = summary
            .machine_lines_hz
            .iter()
            .map(|hz| digits(*hz))
            .collect();
        text += &format!(", the machine's {} Hz", lines.join(", "));
    }
    text
}

fn json(takes: &[Take], groups: &[Cell<'_>], by: By) -> Outcome<Value> {
    let mut recordings = Vec::with_capacity(takes.len());
    for take in takes {
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
    let all: Vec<Doubt> = groups
        .iter()
        .flat_map(|g| g.summary.doubts.clone())
        .collect();
    Ok(json!({
        "by": format!("{by:?}").to_lowercase(),
        "recordings": recordings,
        "groups": groups.iter().map(group_json).collect::<Outcome<Vec<_>>>()?,
        "doubts": doubts_json(&all)?,
    }))
}

/// A group with its mean PSD.
pub(crate) fn group_json(group: &Cell<'_>) -> Outcome<Value> {
    let mut value = serde_json::to_value(&group.summary)?;
    if let Some(fields) = value.as_object_mut() {
        let files: Vec<&str> = group.takes.iter().map(|take| take.name.as_str()).collect();
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
