//! `piezotact characterise`: the transfer function of a device with a finger on it.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::quantity::{Acceleration, Drive, Quantity, Seconds};
use piezotact::run::RunStart;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Distortion, Estimator};
use piezotact_bench::procedure::{
    self, Characterisation, CharacteriseConfig, Gating, Refused, RepeatConfig, Repeated,
};
use piezotact_bench::{Bench, ExcitationConfig, GateConfig};
use piezotact_dataset::{
    RunFolder, TransferDocument, TransferFormat, keep_before, read_transfer, write_transfer,
};
use serde_json::{Value, json};

use super::{has_ending, outputs, recording_files, run_plan};
use crate::cli::{Characterise, Gate as GateArgs, OnOff};
use crate::failure::{Outcome, usage};
use crate::keeping::{self, Keeper, Place, Raw, Shown, runs_of};
use crate::output::{doubts_json, print, print_json, say, say_doubts, write_text};
use crate::report::transfer;

pub(crate) fn run(args: &Characterise) -> Outcome {
    if let Some(record) = &args.record {
        has_ending(record, &["parquet"])?;
    }
    let mut bench = args.bench.open()?;
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: args.excitation,
            band: args.band,
            duration: Seconds(args.seconds),
            peak: args.peak,
            seed: args.seed,
        },
        welch: WelchConfig::hann(args.segment),
        estimator: Estimator::H1,
        run: run_plan("characterise", &args.finger, bench.acquirer.as_ref()),
    };
    let repeats = RepeatConfig {
        repeats: usize::from(args.repeats),
        attempts: usize::from(args.gate.attempts),
        gating: gating(&args.gate)?,
    };
    let recordings = (1..=repeats.repeats).filter_map(|repeat| {
        let record = args.record.as_deref()?;
        Some(recording_files(&numbered(
            record,
            repeats.repeats,
            repeat,
            1,
        )))
    });
    let written: Vec<PathBuf> = std::iter::once(args.out.clone())
        .chain(args.report.clone())
        .chain(recordings.flatten())
        .collect();
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    let read: Vec<&Path> = args.bench.file().into_iter().collect();
    outputs(&read, &written)?;
    let path_of = |start: &RunStart| {
        let (repeat, attempt) = repeats.attempt_of(&config.run, &start.label);
        let record = args.record.as_deref().unwrap_or(&args.out);
        numbered(record, repeats.repeats, repeat, attempt)
    };
    let place = match args.record {
        Some(_) => Place::Named(&path_of),
        // For the time of the measurement: what was acquired is not lost with the program.
        None => Place::Continued(fresh(&args.out)?),
    };
    let runs = match &place {
        Place::Continued(runs) => Some(runs.clone()),
        _ => None,
    };
    let mut done = repeated(&mut bench, &config, &repeats, place)?;
    if let Some(runs) = runs {
        keeping::done(&runs, Raw::Discarded)?;
    }
    let each: Vec<Distortion> = done
        .each
        .iter()
        .filter_map(|c| c.distortion.clone())
        .collect();
    let distortion = Distortion::together(&each);
    let document = TransferDocument {
        distortion: distortion.clone(),
        attempts: done.attempts.clone(),
        ..TransferDocument::of(&done.function, Drive::UNIT, Acceleration::UNIT)
    };
    if let Some(kept) = keep_of_another(&args.out, &document)? {
        say(&format!(
            "{}: what was there is of another person, condition or seed, and kept as {}",
            args.out.display(),
            kept.display()
        ));
    }
    write_transfer(&args.out, &document)?;
    done.function
        .about
        .doubts
        .extend(TransferFormat::of_ending(&args.out).losses());
    let function = &done.function;
    if let Some(report) = &args.report {
        let page = transfer::Page {
            title: format!("Transfer function: {}", function.about.provenance.source),
            function,
            unit: format!("({})/{}", Acceleration::UNIT, Drive::UNIT),
            response_unit: Acceleration::UNIT.to_string(),
            distortion: distortion.as_ref(),
            repeats: done.apart_db.map(|db| (done.each.len(), db)),
            refused: done.refused.iter().map(ToString::to_string).collect(),
        };
        write_text(report, &transfer::render(&page)?)?;
    }
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "averages": function.averages,
            "effective_averages": function.effective_averages,
            "resolution_hz": function.resolution_hz(),
            "band_hz": args.band,
            "driven_hz": function.driven,
            "repeats": done.each.len(),
            "repeats_apart_db_rms": done.apart_db,
            "refused": refused_json(&done.refused),
            "attempts": done.attempts,
            "distortion": distortion,
            "drive_setup": function.drive,
            "condition": function.about.condition,
            "provenance": function.about.provenance,
            "doubts": doubts_json(&function.about.doubts)?,
        }));
    }
    say_doubts(&function.about.doubts);
    print(&format!(
        "wrote {}: {} lines in steps of {:.2} Hz from {} averages, {}",
        args.out.display(),
        function.response().len(),
        function.resolution_hz(),
        function.averages,
        function.about.provenance.source
    ))?;
    if let Some(apart_db) = done.apart_db {
        print(&format!(
            "{} repeats, any two at most {apart_db:.2} dB rms apart",
            done.each.len()
        ))?;
    }
    distortion.map_or(Ok(()), |distortion| print(&told(&distortion)))
}

/// Keeps what stands at `out` under a free name, unless it is a transfer function of the same person, condition, bench and seed as
/// `new`; where it is kept.
fn keep_of_another(out: &Path, new: &TransferDocument) -> Outcome<Option<PathBuf>> {
    if !out.is_file() {
        return Ok(None);
    }
    let same = read_transfer(out).is_ok_and(|old| {
        let [old_from, new_from] = [&old, new].map(|document| &document.about.provenance);
        old.about.condition == new.about.condition
            && old_from.source == new_from.source
            && old_from.seed == new_from.seed
            && old_from.answered_with == new_from.answered_with
    });
    if same {
        return Ok(None);
    }
    Ok(keep_before(out)?)
}

/// Levels of noise and distortion re the answer, one line a band.
fn told(distortion: &Distortion) -> String {
    let mut text = format!(
        "re the answer, in dB, from {} realisations of {} periods:\n{:>14}  {:>8}  {:>8}  {:>8}",
        distortion.realisations, distortion.periods, "band", "noise", "even", "odd"
    );
    for level in &distortion.levels {
        let db = |value: Option<f64>| match value {
            Some(value) if value > 0.0 && level.linear > 0.0 => {
                format!("{:.1}", 20.0 * (value / level.linear).log10())
            }
            Some(_) => "in noise".into(),
            None => "–".into(),
        };
        text.push_str(&format!(
            "\n{:>14}  {:>8}  {:>8}  {:>8}",
            level.band_hz.to_string(),
            db(Some(level.noise)),
            db(level.even),
            db(level.odd)
        ));
    }
    text
}

fn refused_json(refused: &[Refused]) -> Vec<Value> {
    refused
        .iter()
        .map(
            |r| json!({ "repeat": r.repeat, "attempt": r.attempt, "reason": r.refusal.to_string() }),
        )
        .collect()
}

/// What the options ask of every measurement.
pub(crate) fn gating(args: &GateArgs) -> Outcome<Gating> {
    let within = |what: &str, value: f64| {
        if value > 0.0 && value < 1.0 {
            return Ok(value);
        }
        Err(usage(anyhow!(
            "expected {what} between 0 and 1, found {value}; leave it out for the usual"
        )))
    };
    match args.gating {
        OnOff::Off => {
            for (option, given) in [
                ("--force-tolerance", args.force_tolerance.is_some()),
                ("--least-coherence", args.least_coherence.is_some()),
            ] {
                if given {
                    return Err(usage(anyhow!(
                        "expected --gate on with {option}, found --gate off, which judges nothing; leave one of them out"
                    )));
                }
            }
            Ok(Gating::Open)
        }
        OnOff::On => {
            let usual = GateConfig::usual();
            let force_share = args.force_tolerance.unwrap_or(usual.force_share);
            let least_coherence = args.least_coherence.unwrap_or(usual.least_coherence);
            Ok(Gating::Judged(GateConfig {
                force_share: within("--force-tolerance", force_share)?,
                least_coherence: within("--least-coherence", least_coherence)?,
                ..usual
            }))
        }
    }
}

/// The recording of one attempt at one repeat: `raw.parquet`, `raw-2.parquet`, `raw-2-again-1.parquet`.
fn numbered(record: &Path, repeats: usize, repeat: usize, attempt: usize) -> PathBuf {
    let stem = record.file_stem().unwrap_or_default().to_string_lossy();
    let ending = record
        .extension()
        .map(|e| format!(".{}", e.to_string_lossy()))
        .unwrap_or_default();
    let number = if repeats > 1 {
        format!("-{repeat}")
    } else {
        String::new()
    };
    let again = if attempt > 1 {
        format!("-again-{}", attempt - 1)
    } else {
        String::new()
    };
    record.with_file_name(format!("{stem}{number}{again}{ending}"))
}

/// The folder for the runs behind `out`, with nothing in it that a run could be taken from.
fn fresh(out: &Path) -> Outcome<RunFolder> {
    let folder = runs_of(out)?;
    if let Some(aside) = folder.set_aside()? {
        say(&format!(
            "the runs of an interrupted characterisation are kept in {}",
            aside.display()
        ));
    }
    Ok(folder)
}

/// Characterises `repeats` times, with the progress and every refusal shown, keeping each recording at `place`.
pub(crate) fn repeated(
    bench: &mut Bench,
    config: &CharacteriseConfig,
    repeats: &RepeatConfig,
    place: Place<'_>,
) -> Outcome<Repeated> {
    let duration = config.excitation.duration;
    let what = |start: &RunStart| {
        let (repeat, _) = repeats.attempt_of(&config.run, &start.label);
        let of = match repeats.repeats {
            1 => String::new(),
            all => format!(", {repeat} of {all}"),
        };
        format!(
            "characterising with {} of {duration:.1}{of}",
            config.excitation.kind.name(),
        )
    };
    let mut keeper = Keeper::new(place, Shown::Each(&what, duration));
    let done = procedure::repeated(bench, config, repeats, &mut keeper, &mut |refused| {
        say(&refused.to_string());
    });
    done.map_err(|error| keeper.failure(error))
}

/// Runs a characterisation that takes what comes, with its progress shown.
pub(crate) fn characterise(
    bench: &mut Bench,
    config: &CharacteriseConfig,
) -> Outcome<Characterisation> {
    let once = RepeatConfig {
        repeats: 1,
        attempts: 1,
        gating: Gating::Open,
    };
    let done = repeated(bench, config, &once, Place::Nowhere)?;
    let mut each = done.each.into_iter();
    each.next()
        .ok_or_else(|| anyhow!("the characterisation gave no measurement; report this").into())
}
