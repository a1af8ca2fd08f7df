//! `piezotact compare`: what changes from group to group.

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::compare::{
    ActivePassive, Groups, Sliding, SpatialPeriod, Summary, across_participants, across_roughness,
    active_against_passive, comparable, friction_against_rms, rms_on_speed, spatial_period,
};
use piezotact::feature::RECOMMENDED_STROKES;
use piezotact::quantity::{Band, Hertz};
use piezotact::surface::SampleSet;
use serde_json::{Map, Value, json};

use super::discrimination::{self, Discrimination};
use super::segment::check_outputs;
use super::{
    Cell, Comparison, Take, analyse_all, both_ways, cells, comparisons, differ_in, doubts_once,
    left_out, ridge_m, sample_sets, tables, take_all,
};
use crate::cli::{By, Compare};
use crate::failure::{Outcome, usage};
use crate::output::{digits, doubts_json, print, print_json, say, write_text};
use crate::report;

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
        say(&format!("doubt: {doubt}"));
    }
    for result in &results {
        print(&result.text)?;
    }
    if let Some(line) = across.as_ref().map(Discrimination::line) {
        print(&line)?;
    }
    if args.by == By::Touch {
        for pair in touch(&takes, &sets)?.pairs {
            print(&format!(
                "{}: active and passive PSDs differ by {} dB rms, level {:+.1} dB",
                pair.sample,
                pair.difference_db_rms
                    .map_or("?".into(), |db| format!("{db:.1}")),
                pair.level_difference_db
            ))?;
        }
    }
    for path in [&computing.csv, &computing.report].into_iter().flatten() {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

/// The doubts of all comparisons, each with its setting; that strokes are few is said once for all.
fn doubts_in_words(results: &[Compared]) -> Vec<String> {
    let mut few = 0;
    let mut words = Vec::new();
    for result in results {
        for doubt in &result.doubts {
            match doubt {
                Doubt::FewStrokes { .. } if results.len() > 1 => few += 1,
                doubt if result.setting.is_empty() => words.push(doubt.to_string()),
                doubt => words.push(format!("{}: {doubt}", result.setting)),
            }
        }
    }
    if few > 0 {
        words.push(format!(
            "{few} groups have fewer than {RECOMMENDED_STROKES} strokes: averages scatter"
        ));
    }
    words
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
                compared.say(&format!(
                    "levels of {} participants differ by {:.1} dB (standard deviation)",
                    spread.participants, spread.level_db.sd
                ));
                compared.put("level_spread", &spread)?;
            }
        }
        By::Touch => {}
    }
    Ok(compared)
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
        let interval = fit.slope_interval.map_or(String::new(), |[low, high]| {
            format!(" (95 %: {low:.2} to {high:.2})")
        });
        compared.say(&format!(
            "rms grows with speed to the power {:.2}{interval}",
            fit.slope
        ));
    }
    let period = period(comparison)?;
    let mm = |m: f64| m * 1e3;
    // What does not stand out is a candidate and no period.
    let stands_out = |p: &&SpatialPeriod| {
        !p.doubts
            .iter()
            .any(|d| matches!(d, Doubt::NoCommonPeriod { .. }))
    };
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
        let interval = period.interval_m.map_or(String::new(), |[low, high]| {
            format!(" (95 %: {:.3} to {:.3} mm)", mm(low), mm(high))
        });
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
        let what = match candidate {
            None => "spatial period",
            Some(_) => "no spatial period stands out at all speeds; the strongest candidate is",
        };
        compared.say(&format!(
            "{what} {:.3} mm{interval}: {}",
            mm(period.period_m),
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
                slidings.push((
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
        .map(|(speed_m_s, rate, vibrations, segmentation)| Sliding {
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
        })
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
        compared.say(&format!(
            "rms follows Ra to the power {:.2}{}",
            fit.slope,
            trend
                .rms_rank_correlation
                .map_or(String::new(), |rho| format!(", rank correlation {rho:.2}"))
        ));
    }
    if let Some(rho) = trend.friction_rank_correlation {
        compared.say(&format!("friction and Ra: rank correlation {rho:.2}"));
    }
    compared.put("roughness", &trend)?;
    let friction = friction_against_rms(summaries);
    if let Some(rho) = friction {
        compared.say(&format!("friction and rms: rank correlation {rho:.2}"));
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

fn json(
    by: By,
    takes: &[Take],
    sets: &[SampleSet],
    results: Vec<Compared>,
    (discriminated, of_pairs): (Option<Value>, &[Doubt]),
) -> Outcome<Value> {
    let mut doubts: Vec<Doubt> = takes.iter().flat_map(Take::doubts).collect();
    doubts.extend(results.iter().flat_map(|result| result.doubts.clone()));
    doubts.extend(of_pairs.iter().cloned());
    let mut seen: Vec<Doubt> = Vec::new();
    doubts.retain(|doubt| {
        let new = !seen.contains(doubt);
        seen.push(doubt.clone());
        new
    });
    let mut value = Map::new();
    value.insert("by".into(), json!(format!("{by:?}").to_lowercase()));
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
