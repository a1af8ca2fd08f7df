//! `piezotact characterise`: the transfer function of a device with a finger on it.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::document::Kept;
use piezotact::quantity::{Acceleration, Drive, Quantity, Seconds};
use piezotact::run::RunStart;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::Estimator;
use piezotact_bench::procedure::{
    self, Characterisation, CharacteriseConfig, GatePolicy, RepeatConfig, RepeatedCharacterisation,
    usual_segment,
};
use piezotact_bench::{Bench, ExcitationConfig, GateConfig};
use piezotact_dataset::{
    RunFolder, TransferDocument, TransferFormat, read_transfer, write_transfer,
};

use crate::cli::{Characterise, Gate as GateArgs, OnOff};
use crate::deliver::deliver_and;
use crate::failure::{Outcome, usage};
use crate::keeping::{self, Earlier, Keeper, Place, Raw, Shown, runs_of};
use crate::output::say;
use crate::places::{has_ending, outputs, recording_files};
use crate::runs::run_plan;

pub(crate) fn run(args: &Characterise) -> Outcome {
    if let Some(record) = &args.record {
        has_ending(record, &["parquet"])?;
    }
    args.live.begin();
    let mut bench = args.bench.open()?;
    let config = config(args, &bench);
    let repeats = RepeatConfig {
        repeats: usize::from(args.repeats),
        attempts: usize::from(args.gate.attempts),
        gating: gating(&args.gate)?,
    };
    check_outputs(args, repeats.repeats)?;
    let mut done = kept_while_measured(args, &mut bench, (&config, &repeats))?;
    let stored = TransferDocument {
        distortion: done.distortion.clone(),
        attempts: done.attempts.clone(),
        ..TransferDocument::of(&done.function, Drive::UNIT, Acceleration::UNIT)
    };
    let earlier = Earlier::at(&args.out, said_of_earlier(&args.out, &stored))?;
    write_transfer(&args.out, &stored)?;
    earlier.settle()?;
    let lost = TransferFormat::of_ending(&args.out).losses();
    done.function.about.warnings.extend(lost);
    let found = Kept {
        out: &args.out,
        value: &done,
    };
    deliver_and(&args.outputs, &found, &[&args.out])
}

fn config(args: &Characterise, bench: &Bench) -> CharacteriseConfig {
    CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: args.excitation,
            band: args.band,
            duration: Seconds(args.seconds),
            peak: args.peak,
            seed: args.seed,
        },
        welch: WelchConfig::hann(
            args.segment
                .unwrap_or_else(|| usual_segment(bench.acquirer.describe().rate)),
        ),
        estimator: Estimator::H1,
        run: run_plan("characterise", &args.finger, bench.acquirer.as_ref()),
    }
}

/// Refuses outputs that would replace the bench's file or each other.
fn check_outputs(args: &Characterise, repeats: usize) -> Outcome {
    let recordings = (1..=repeats).filter_map(|repeat| {
        let record = args.record.as_deref()?;
        Some(recording_files(&numbered(record, repeats, repeat, 1)))
    });
    let written: Vec<PathBuf> = std::iter::once(args.out.clone())
        .chain(args.outputs.files().into_iter().map(Path::to_owned))
        .chain(recordings.flatten())
        .collect();
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    let read: Vec<&Path> = args.bench.file().into_iter().collect();
    outputs(&read, &written)
}

/// Characterises, and keeps what is acquired: in the files that are asked for, else for the time of the measurement, so that it
/// is not lost with the program.
fn kept_while_measured(
    args: &Characterise,
    bench: &mut Bench,
    (config, repeats): (&CharacteriseConfig, &RepeatConfig),
) -> Outcome<RepeatedCharacterisation> {
    let Some(record) = args.record.as_deref() else {
        let runs = fresh(&args.out)?;
        let done = repeated(bench, config, repeats, Place::Continued(runs.clone()))?;
        keeping::done(&runs, Raw::Discarded)?;
        return Ok(done);
    };
    let path_of = |start: &RunStart| {
        let (repeat, attempt) = repeats.attempt_of(&config.run, &start.label);
        numbered(record, repeats.repeats, repeat, attempt)
    };
    repeated(bench, config, repeats, Place::Named(&path_of))
}

/// What the transfer function at `out` is to `new`, in words.
fn said_of_earlier(out: &Path, new: &TransferDocument) -> &'static str {
    match read_transfer(out) {
        Ok(old) if old.is_of_the_same(new) => "the earlier measurement",
        _ => "the earlier file is of another participant, condition or seed, and",
    }
}

/// What the options ask of every measurement.
pub(crate) fn gating(args: &GateArgs) -> Outcome<GatePolicy> {
    let within = |what: &str, value: f64| {
        if value > 0.0 && value < 1.0 {
            return Ok(value);
        }
        Err(usage(anyhow!(
            "expected {what} between 0 and 1, found {value}; leave it out for the default"
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
                        "expected --gate on with {option}, found --gate off, which checks nothing; leave one of them out"
                    )));
                }
            }
            Ok(GatePolicy::Open)
        }
        OnOff::On => {
            let usual = GateConfig::usual();
            let force_share = args.force_tolerance.unwrap_or(usual.force_share);
            let least_coherence = args.least_coherence.unwrap_or(usual.least_coherence);
            Ok(GatePolicy::Judged(GateConfig {
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
) -> Outcome<RepeatedCharacterisation> {
    let duration = config.excitation.duration;
    let what = |start: &RunStart| {
        let (repeat, _) = repeats.attempt_of(&config.run, &start.label);
        let of = match repeats.repeats {
            1 => String::new(),
            all => format!(", repeat {repeat} of {all}"),
        };
        format!(
            "characterising: {} drive, {duration:.1}{of}",
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
        gating: GatePolicy::Open,
    };
    let done = repeated(bench, config, &once, Place::Nowhere)?;
    let mut each = done.each.into_iter();
    each.next()
        .ok_or_else(|| anyhow!("the characterisation gave no measurement; report this").into())
}
