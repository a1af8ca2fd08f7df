//! `piezotact compare`: what changes from group to group.

use piezotact::doubt::Doubts;
use piezotact::quantity::{Band, Hertz};
use piezotact::study::{
    By, Comparison, Discrimination, Question, SpeedTrend, StudyAnalysis, Take, Trend,
};
use serde_json::{Map, Value, json};

use super::analyse::group_json;
use super::{analysed, check_outputs, settings, tables};
use crate::advice::text;
use crate::cli::Compare;
use crate::commands::score;
use crate::failure::Outcome;
use crate::output::{doubts_json, print, print_json, say, write_text};
use crate::report;

/// The band over which a finger feels: the one that `score` compares unless told otherwise.
const FELT_HZ: [f64; 2] = [20.0, 1000.0];

pub(crate) fn run(args: &Compare) -> Outcome {
    let computing = &args.computing;
    let [low, high] = FELT_HZ.map(Hertz);
    let question = Question::Changes {
        by: args.by.into(),
        model: score::model(&args.feeling, Band::new(low, high)?)?,
    };
    check_outputs(&args.takes, &[&computing.csv, &computing.report])?;
    let settings = settings(computing, question)?;
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

/// The fields of one comparison.
struct Fields(Map<String, Value>);

impl Fields {
    fn put(&mut self, name: &str, value: &impl serde::Serialize) -> Outcome {
        self.0.insert(name.into(), serde_json::to_value(value)?);
        Ok(())
    }
}

fn comparison_json(
    study: &StudyAnalysis,
    number: usize,
    comparison: &Comparison,
) -> Outcome<Map<String, Value>> {
    let mut fields = Fields(Map::new());
    if !comparison.setting.is_empty() {
        fields.put("setting", &comparison.setting)?;
    }
    let groups = comparison.groups.iter();
    let groups: Vec<Value> = groups
        .map(|group| group_json(study, group))
        .collect::<Outcome<_>>()?;
    fields.put("groups", &groups)?;
    match &comparison.trend {
        Trend::Speeds(trend) => speeds(&mut fields, trend)?,
        Trend::Samples(trend) => {
            fields.put("roughness", &trend.roughness)?;
            fields.put("friction_rms_rank_correlation", &trend.friction_on_rms)?;
            let discrimination = study.discrimination.as_ref();
            if let Some(groups) = discrimination.and_then(|found| found.groups(number)) {
                fields.put("below_jnd", &groups.below_by_name())?;
            }
        }
        Trend::Participants(Some(spread)) => fields.put("level_spread", spread)?,
        Trend::Participants(None) | Trend::Touch => {}
    }
    Ok(fields.0)
}

fn speeds(fields: &mut Fields, trend: &SpeedTrend) -> Outcome {
    let fit = trend.rms_on_speed;
    fields.put("rms_log_slope", &fit.map(|fit| fit.slope))?;
    fields.put(
        "rms_log_slope_interval",
        &fit.and_then(|fit| fit.slope_interval),
    )?;
    fields.put("rms_on_speed", &fit)?;
    if let Some(fit) = fit {
        fields.put("rms_trend", &fit.direction())?;
    }
    let mm = |m: f64| m * 1e3;
    let (candidate, period) = (trend.candidate(), trend.standing_out());
    fields.put(
        "spatial_period_candidate_mm",
        &candidate.map(|p| mm(p.period_m)),
    )?;
    fields.put("spatial_period_mm", &period.map(|p| mm(p.period_m)))?;
    fields.put(
        "spatial_period_interval_mm",
        &period.and_then(|p| p.interval_m.map(|i| i.map(mm))),
    )?;
    if let Some(period) = &trend.period {
        fields.put("spatial_period_outcome", &period.outcome())?;
        fields.put("spatial_period_criteria", &period.criteria)?;
        fields.put(
            "spatial_period_over",
            &json!({"what": period.over, "count": period.units}),
        )?;
        fields.put("spatial_period_groups", &period.groups)?;
    }
    let peaks = trend.period.iter().flat_map(|period| &period.peaks);
    let peaks: Vec<Value> = peaks
        .map(|peak| {
            json!({
                "speed_mm_s": mm(peak.speed_m_s),
                "frequency_hz": peak.frequency_hz,
                "prominence_db": peak.prominence_db,
            })
        })
        .collect();
    fields.put("peaks", &peaks)
}

fn discrimination_json(discrimination: &Discrimination) -> Outcome<Value> {
    let found = match &discrimination.found {
        Err(withheld) => {
            let mut value = serde_json::to_value(withheld)?;
            if let Some(fields) = value.as_object_mut() {
                fields.insert("sentence".into(), json!(withheld.to_string()));
            }
            return Ok(value);
        }
        Ok(found) => found,
    };
    let mut value = serde_json::to_value(found)?;
    if let Some(fields) = value.as_object_mut() {
        // They stand among all doubts, with their sentences.
        fields.remove("doubts");
        fields.insert("sentence".into(), json!(discrimination.line()));
        fields.insert("jnd_source".into(), json!(found.config.model.jnd_source()));
        if let Some(Value::Array(settings)) = fields.get_mut("settings") {
            for (setting, name) in settings.iter_mut().zip(&discrimination.settings) {
                if let Some(fields) = setting.as_object_mut() {
                    fields.insert("setting".into(), json!(name));
                }
            }
        }
    }
    Ok(value)
}

fn json(study: &StudyAnalysis) -> Outcome<Value> {
    let comparisons = study.comparisons();
    let mut doubts: Doubts = study.takes.iter().flat_map(Take::doubts).collect();
    for number in 0..comparisons.len() {
        doubts.extend(study.doubts_of_comparison(number));
    }
    let discrimination = study.discrimination.as_ref();
    doubts.extend(
        discrimination
            .into_iter()
            .flat_map(|found| found.doubts().cloned()),
    );
    let mut value = Map::new();
    value.insert("by".into(), json!(study.by));
    value.insert("common_lines".into(), json!(study.common_lines));
    if let (By::Touch, Some(both)) = (study.by, &study.both_ways) {
        let touch = serde_json::to_value(&both.found)?;
        value.insert("active_against_passive".into(), touch);
    }
    if let Some(discrimination) = discrimination {
        value.insert(
            "discrimination".into(),
            discrimination_json(discrimination)?,
        );
    }
    // One comparison stands at the top; several stand in a list.
    let numbered = comparisons.iter().enumerate();
    let mut results = numbered
        .map(|(number, comparison)| comparison_json(study, number, comparison))
        .collect::<Outcome<Vec<_>>>()?;
    if let [_] = results.as_slice() {
        value.extend(results.remove(0));
    } else {
        value.insert("comparisons".into(), json!(results));
    }
    value.insert("doubts".into(), doubts_json(&doubts)?);
    Ok(Value::Object(value))
}
