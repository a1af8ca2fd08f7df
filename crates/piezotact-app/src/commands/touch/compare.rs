//! `piezotact compare`: what changes from group to group.

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::compare::{
    ActivePassive, Groups, LevelSpread, Sliding, SpatialPeriod, Summary, across_participants,
    across_roughness, active_against_passive, comparable, friction_against_rms, rms_on_speed,
    spatial_period,
};
use piezotact::criterion::Outcome as Judged;
use piezotact::doubt::Doubts;
use piezotact::doubt::merged_of;
use piezotact::quantity::{Band, Hertz};
use piezotact::surface::SampleSet;
use serde_json::{Map, Value, json};

use super::discrimination::{self, Discrimination};
use super::segment::check_outputs;
use super::{
    Cell, Comparison, Take, analyse_all, both_ways, cells, comparisons, differ_in, doubts_once,
    left_out, lines_of_all, ridge_m, sample_sets, tables, take_all,
};
use crate::advice::text;
use crate::cli::{By, Compare};
use crate::failure::{Outcome, usage};
use crate::output::{digits, doubts_json, print, print_json, say, write_text};
use crate::report;
use crate::wording;

pub(crate) fn run(args: &Compare) -> Outcome {
    let computing = &args.computing;
    let model = discrimination::model(&args.feeling)?;
    check_outputs(&args.takes, &[&computing.csv, &computing.report])?;
    let (sets, ridge_m) = (sample_sets(computing)?, ridge_m(computing)?);
    let mut takes = take_all(&args.takes)?;
    analyse_all(&mut takes, computing)?;
    let compared = comparisons(&takes, args.by, &sets, ridge_m)?;
    if compared.is_empty() {
        return Err(usage(anyhow!(
            "expected recordings that differ in {} and share all else, found none{}; give more recordings, or say more of them with --meta",
            format!("{:?}", args.by).to_lowercase(),
            match differ_in(&takes, args.by) {
                nothing if nothing.is_empty() => String::new(),
                what => format!(" (they differ in {what})"),
            }
        )));
    }
    let across = match args.by {
        By::Sample | By::File => Some(Discrimination::of(&compared, model)),
        By::Speed | By::Participant | By::Touch => None,
    };
    if let Some(path) = &computing.csv {
        tables::write_strokes(path, &takes)?;
    }
    if let Some(path) = &computing.report {
        let groups = cells(&takes, args.by, &sets, ridge_m)?;
        let page = report::touch::Page {
            title: format!(
                "What changes with the {}",
                format!("{:?}", args.by).to_lowercase()
            ),
            takes: &takes,
            groups: &groups,
            sets: &sets,
            ridge_m,
            discrimination: across.as_ref(),
        };
        write_text(path, &report::touch::render(&page)?)?;
    }
    let apart = left_out(&takes, &compared);
    let mut results = compared
        .iter()
        .enumerate()
        .map(|(i, comparison)| {
            let groups = across.as_ref().and_then(|across| across.groups(i));
            result(comparison, args.by, &sets, groups)
        })
        .collect::<Outcome<Vec<_>>>()?;
    if let Some(first) = results.first_mut() {
        first.doubts.extend(apart);
    }
    let of_pairs = across
        .as_ref()
        .map_or_else(Vec::new, Discrimination::doubts);
    if computing.json {
        let discriminated = across.as_ref().map(Discrimination::json).transpose()?;
        return print_json(&json(
            args.by,
            &takes,
            &sets,
            results,
            (discriminated, &of_pairs),
        )?);
    }
    for doubt in doubts_once(&takes, &[]) {
        say(&format!("doubt: {doubt}"));
    }
    for doubt in doubts_in_words(&results) {
        say(&format!("doubt: {doubt}"));
    }
    for doubt in &of_pairs {
        say(&format!("doubt: {}", text(doubt)));
    }
    for result in &results {
        print(&result.text)?;
    }
    if let Some(line) = across.as_ref().map(Discrimination::line) {
        print(&line)?;
    }
    if args.by == By::Touch {
        let found = touch(&takes, &sets)?;
        for pair in &found.pairs {
            print(&format!(
                "{}: active and passive PSDs differ by {} dB rms, level by {}",
                pair.sample,
                pair.difference_db_rms
                    .map_or("?".into(), |db| format!("{db:.1}")),
                pair.level_difference_db
                    .map_or("more than can be measured".into(), |db| format!(
                        "{db:+.1} dB"
                    ))
            ))?;
        }
        for line in active_passive(&found) {
            print(&line)?;
        }
    }
    for line in lines_of_all(&takes) {
        print(&wording::common_line(&line))?;
    }
    for path in [&computing.csv, &computing.report].into_iter().flatten() {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

/// What active and passive touch say over all samples.
pub(crate) fn active_passive(found: &ActivePassive) -> Vec<String> {
    let level = found.level.as_ref();
    let level = level.map(|l| wording::level_difference(["active", "passive touch"], l, "samples"));
    let ranks = found.rms_rank_correlation.as_ref();
    let ranks = ranks.map(|r| wording::ranks("active rms", "passive rms", r, "samples"));
    let few = (found.pairs.len() == 1)
        .then(|| "active and passive touch: not decided from 1 sample".to_owned());
    level.into_iter().chain(ranks).chain(few).collect()
}

/// The doubts of all comparisons, those of one kind once and with the settings that they are about.
fn doubts_in_words(results: &[Compared]) -> Vec<String> {
    let all = results.iter().flat_map(|result| {
        let setting = Some(result.setting.as_str()).filter(|setting| !setting.is_empty());
        result.doubts.iter().map(move |doubt| (setting, doubt))
    });
    merged_of(all)
        .iter()
        .map(|doubt| doubt.text_of((results.len(), "settings"), &text))
        .collect()
}

struct Compared {
    setting: String,
    fields: Map<String, Value>,
    text: String,
    doubts: Vec<Doubt>,
}

fn result(
    comparison: &Comparison<'_>,
    by: By,
    sets: &[SampleSet],
    groups_told: Option<&Groups>,
) -> Outcome<Compared> {
    let summaries: Vec<&Summary> = comparison.cells.iter().map(|cell| &cell.summary).collect();
    comparable(&summaries)?;
    let mut compared = Compared {
        setting: comparison.setting.clone(),
        fields: Map::new(),
        text: String::new(),
        doubts: summaries.iter().flat_map(|s| s.doubts.clone()).collect(),
    };
    if !comparison.setting.is_empty() {
        compared.text = format!("{}:", comparison.setting);
        compared.put("setting", &comparison.setting)?;
    }
    for summary in &summaries {
        compared.say(&super::analyse::line(summary));
    }
    let groups: Vec<Value> = comparison
        .cells
        .iter()
        .map(super::analyse::group_json)
        .collect::<Outcome<_>>()?;
    compared.put("groups", &groups)?;
    match by {
        By::Speed => speeds(&mut compared, comparison, &summaries)?,
        By::Sample | By::File => samples(&mut compared, &summaries, sets, groups_told)?,
        By::Participant => {
            if let Some(spread) = across_participants(&summaries) {
                compared.say(&participants(&spread));
                compared.put("level_spread", &spread)?;
            }
        }
        By::Touch => {}
    }
    Ok(compared)
}

/// How far participants differ, with what their number leaves open.
fn participants(spread: &LevelSpread) -> String {
    match spread.sd_interval_db {
        Some([low, high]) => format!(
            "levels of {} participants differ by {:.1} dB (standard deviation; 95 %: {low:.1} to {high:.1} dB for people like them)",
            spread.participants, spread.level_db.sd
        ),
        None => "one participant: how far people differ is not decided".into(),
    }
}

impl Compared {
    fn put(&mut self, name: &str, value: &impl serde::Serialize) -> Outcome {
        self.fields
            .insert(name.into(), serde_json::to_value(value)?);
        Ok(())
    }

    fn say(&mut self, line: &str) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text.push_str(line);
    }
}

fn speeds(compared: &mut Compared, comparison: &Comparison<'_>, summaries: &[&Summary]) -> Outcome {
    let fit = rms_on_speed(summaries);
    compared.put("rms_log_slope", &fit.map(|fit| fit.slope))?;
    compared.put(
        "rms_log_slope_interval",
        &fit.and_then(|fit| fit.slope_interval),
    )?;
    compared.put("rms_on_speed", &fit)?;
    if let Some(fit) = fit {
        compared.put("rms_trend", &fit.direction())?;
        compared.say(&wording::power_law("rms", "speed", &fit, "speeds"));
    }
    let period = period(comparison)?;
    let mm = |m: f64| m * 1e3;
    // What does not stand out is a candidate and no period.
    let stands_out = |p: &&SpatialPeriod| p.outcome() == Judged::Met;
    let candidate = period
        .as_ref()
        .filter(|p| !stands_out(p))
        .map(|p| mm(p.period_m));
    compared.put("spatial_period_candidate_mm", &candidate)?;
    compared.put(
        "spatial_period_mm",
        &period.as_ref().filter(stands_out).map(|p| mm(p.period_m)),
    )?;
    compared.put(
        "spatial_period_interval_mm",
        &period
            .as_ref()
            .filter(stands_out)
            .and_then(|p| p.interval_m.map(|i| i.map(mm))),
    )?;
    if let Some(period) = &period {
        compared.put("spatial_period_outcome", &period.outcome())?;
        compared.put("spatial_period_criteria", &period.criteria)?;
        compared.put(
            "spatial_period_over",
            &json!({"what": period.over, "count": period.units}),
        )?;
        compared.put("spatial_period_groups", &period.groups)?;
    }
    let peaks: Vec<Value> = match &period {
        Some(period) => period
            .peaks
            .iter()
            .map(|peak| {
                json!({
                    "speed_mm_s": mm(peak.speed_m_s),
                    "frequency_hz": peak.frequency_hz,
                    "prominence_db": peak.prominence_db,
                })
            })
            .collect(),
        None => Vec::new(),
    };
    compared.put("peaks", &peaks)?;
    if let Some(period) = period {
        let peaks: Vec<String> = period
            .peaks
            .iter()
            .map(|p| {
                format!(
                    "{} Hz at {} mm/s",
                    digits(p.frequency_hz),
                    digits(mm(p.speed_m_s))
                )
            })
            .collect();
        compared.say(&format!(
            "{}: {}",
            wording::spatial_period(&period),
            peaks.join(", ")
        ));
        compared.doubts.extend(period.doubts);
    }
    Ok(())
}

/// The spatial period on which all speeds agree.
pub(crate) fn period(comparison: &Comparison<'_>) -> Outcome<Option<SpatialPeriod>> {
    let mut slidings = Vec::new();
    for cell in &comparison.cells {
        let Some(speed) = cell.summary.speed_m_s else {
            continue;
        };
        for take in &cell.takes {
            if let Some(analysis) = &take.analysis {
                let vibrations = piezotact::feature::vibrations(
                    &take.recording,
                    &take.segmentation,
                    analysis.config.high_pass,
                )?;
                let load = take.condition().load_n;
                slidings.push((
                    load.map_or("load not stated".to_owned(), |load| load.to_string()),
                    speed.mean,
                    take.recording.rate(),
                    vibrations,
                    &take.segmentation,
                ));
            }
        }
    }
    let parts: Vec<_> = slidings
        .iter()
        .map(
            |(group, speed_m_s, rate, vibrations, segmentation)| Sliding {
                group: group.clone(),
                speed_m_s: *speed_m_s,
                rate: *rate,
                stretches: vibrations
                    .channels
                    .iter()
                    .flat_map(|channel| {
                        segmentation
                            .strokes
                            .iter()
                            .map(|s| s.steady.of(channel.as_slice()))
                    })
                    .collect(),
            },
        )
        .collect();
    let filtered = comparison.cells.iter().flat_map(|cell| &cell.takes);
    let lowest_hz = filtered
        .filter_map(|take| Some(take.analysis.as_ref()?.config.passes_from().0))
        .fold(0.0, f64::max);
    Ok(spatial_period(&parts, Hertz(lowest_hz)))
}

fn samples(
    compared: &mut Compared,
    summaries: &[&Summary],
    sets: &[SampleSet],
    groups_told: Option<&Groups>,
) -> Outcome {
    let trend = across_roughness(summaries, |sample| {
        sets.iter().find_map(|set| set.sample(sample))?.ra_m
    });
    if let Some(fit) = trend.rms_on_ra {
        compared.say(&wording::power_law("rms", "Ra", &fit, "samples"));
    }
    if let Some(found) = &trend.rms_rank_correlation {
        compared.say(&wording::ranks("rms", "Ra", found, "samples"));
    }
    if let Some(found) = &trend.friction_rank_correlation {
        compared.say(&wording::ranks("friction", "Ra", found, "samples"));
    }
    compared.put("roughness", &trend)?;
    let friction = friction_against_rms(summaries);
    if let Some(found) = &friction {
        compared.say(&wording::ranks("friction", "rms", found, "samples"));
    }
    if let Some(text) = one_stroke_each(summaries) {
        compared.say(&text);
    }
    compared.put("friction_rms_rank_correlation", &friction)?;
    if let Some(groups) = groups_told {
        for sentence in groups.sentences() {
            compared.say(&sentence);
        }
        compared.put("below_jnd", &groups.below_by_name())?;
    }
    Ok(())
}

/// What strokes that were not repeated leave open.
pub(crate) fn one_stroke_each(summaries: &[&Summary]) -> Option<String> {
    let single = summaries.iter().filter(|s| s.strokes < 2).count();
    (single > 0).then(|| {
        format!(
            "{single} of {} samples rest on one stroke: how far strokes of one sample differ is not known, so that differences between samples are not decided; record 10 or more",
            summaries.len()
        )
    })
}

fn json(
    by: By,
    takes: &[Take],
    sets: &[SampleSet],
    results: Vec<Compared>,
    (discriminated, of_pairs): (Option<Value>, &[Doubt]),
) -> Outcome<Value> {
    let mut doubts: Doubts = takes.iter().flat_map(Take::doubts).collect();
    doubts.extend(results.iter().flat_map(|result| result.doubts.clone()));
    doubts.extend(of_pairs.iter().cloned());
    let mut value = Map::new();
    value.insert("by".into(), json!(format!("{by:?}").to_lowercase()));
    value.insert("common_lines".into(), json!(lines_of_all(takes)));
    if by == By::Touch {
        let touch = serde_json::to_value(touch(takes, sets)?)?;
        value.insert("active_against_passive".into(), touch);
    }
    if let Some(discriminated) = discriminated {
        value.insert("discrimination".into(), discriminated);
    }
    // One comparison stands at the top; several stand in a list.
    let mut results: Vec<Map<String, Value>> = results.into_iter().map(|r| r.fields).collect();
    if let [_] = results.as_slice() {
        value.extend(results.remove(0));
    } else {
        value.insert("comparisons".into(), json!(results));
    }
    value.insert("doubts".into(), doubts_json(&doubts)?);
    Ok(Value::Object(value))
}

/// Active against passive touch, sample by sample.
pub(crate) fn touch(takes: &[Take], sets: &[SampleSet]) -> Outcome<ActivePassive> {
    let both = both_ways(takes, sets)?;
    let summaries = |cells: &'_ [Cell<'_>]| -> Vec<Summary> {
        cells.iter().map(|cell| cell.summary.clone()).collect()
    };
    let (active, passive) = (summaries(&both.active), summaries(&both.passive));
    let band = Band::new(Hertz(20.0), Hertz(500.0))?;
    Ok(active_against_passive(
        &active.iter().collect::<Vec<_>>(),
        &passive.iter().collect::<Vec<_>>(),
        band,
    ))
}
