//! `piezotact characterise`: the transfer function of a device with a finger on it.

use std::path::Path;

use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Quantity, Seconds};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::Estimator;
use piezotact_bench::procedure::{self, Characterisation, CharacteriseConfig, RunStart, announce};
use piezotact_bench::{Bench, Chunk, ExcitationConfig, RunPlan};
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{JournalWriter, StartDocument, TransferDocument, write_transfer};
use serde_json::json;

use super::{bench_failure, run_plan};
use crate::cli::Characterise;
use crate::failure::Outcome;
use crate::output::{doubts_json, print, print_json, progress, say_doubts};

pub(crate) fn run(args: &Characterise) -> Outcome {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            band: args.band,
            duration: Seconds(args.seconds),
            peak: args.peak,
            seed: args.seed,
        },
        welch: WelchConfig::hann(args.segment),
        estimator: Estimator::H1,
        run: run_plan("characterise", &args.finger),
    };
    let done = characterise(&mut args.bench.open(), &config, args.record.as_deref())?;
    let function = &done.function;
    write_transfer(
        &args.out,
        &TransferDocument::of(function, Drive::UNIT, Acceleration::UNIT),
    )?;
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "averages": function.averages,
            "resolution_hz": function.resolution_hz(),
            "band_hz": args.band,
            "drive_setup": function.drive,
            "condition": function.condition,
            "provenance": function.provenance,
            "doubts": doubts_json(&function.doubts)?,
        }));
    }
    say_doubts(&function.doubts);
    print(&format!(
        "wrote {}: {} lines in steps of {:.2} Hz from {} averages, {}",
        args.out.display(),
        function.response().len(),
        function.resolution_hz(),
        function.averages,
        function.provenance.source
    ))
}

/// Runs a characterisation, with its progress shown, keeping the recording in `record` when there is one.
pub(crate) fn characterise(
    bench: &mut Bench,
    config: &CharacteriseConfig,
    record: Option<&Path>,
) -> Outcome<Characterisation> {
    let setup = bench.player.calibrate()?;
    // Refused before a file is begun.
    bench.acquirer.ready(&config.run).map_err(bench_failure)?;
    let mut journal = record
        .map(|path| begin(path, bench, &config.run, Some(setup), None))
        .transpose()?;
    let bar = progress(
        &format!(
            "characterising with a random drive of {}",
            config.excitation.duration
        ),
        config.excitation.duration,
    );
    let rate = bench.acquirer.describe().rate;
    let done = procedure::characterise(bench, config, &mut |chunk: &Chunk| {
        bar.inc(tenths(chunk, rate.hz()));
        journal.as_mut().map_or(Ok(()), |journal| {
            journal.append(&chunk.channels).map_err(Into::into)
        })
    });
    bar.finish_and_clear();
    let done = done.map_err(bench_failure)?;
    if let Some(journal) = journal {
        journal.finish(done.recording.doubts.clone())?;
    }
    Ok(done)
}

/// Begins the recording of a run on `bench`.
pub(crate) fn begin(
    path: &Path,
    bench: &Bench,
    run: &RunPlan,
    setup: Option<DriveSetup>,
    rendering: Option<Rendering>,
) -> Outcome<JournalWriter> {
    let RunStart {
        rate,
        channels,
        condition,
        provenance,
    } = announce(bench, run);
    let start = StartDocument {
        format: StartDocument::FORMAT,
        rate_hz: rate,
        channels,
        condition,
        provenance,
        setup,
        rendering,
    };
    Ok(JournalWriter::create(path, start)?)
}

/// The length of a chunk in tenths of a second, for a progress bar.
pub(crate) fn tenths(chunk: &Chunk, rate_hz: f64) -> u64 {
    chunk.channels.first().map_or(0, |channel| {
        (channel.len() as f64 / rate_hz * 10.0).round() as u64
    })
}
