//! `piezotact characterise`: the transfer function of a device with a finger on it.

use std::path::{Path, PathBuf};

use piezotact::quantity::{Acceleration, Drive, Quantity, Seconds};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::Estimator;
use piezotact_bench::procedure::{self, Characterisation, CharacteriseConfig};
use piezotact_bench::twin::TwinParameters;
use piezotact_bench::{Bench, Excitation, ExcitationConfig};
use piezotact_dataset::{TransferDocument, write_transfer};
use serde_json::json;

use super::play::{Keeping, play};
use super::{bench_failure, outputs, recording_files, run_plan};
use crate::cli::Characterise;
use crate::failure::Outcome;
use crate::output::{doubts_json, print, print_json, say_doubts};

pub(crate) fn run(args: &Characterise) -> Outcome {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: args.band,
            duration: Seconds(args.seconds),
            peak: args.peak,
            seed: args.seed,
        },
        welch: WelchConfig::hann(args.segment),
        estimator: Estimator::H1,
        run: run_plan("characterise", &args.finger),
    };
    let recording = args
        .record
        .iter()
        .flat_map(|record| recording_files(record));
    let written: Vec<PathBuf> = std::iter::once(args.out.clone()).chain(recording).collect();
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    outputs(&[], &written)?;
    let done = characterise(
        &mut args.bench.open(&TwinParameters::built_in()),
        &config,
        args.record.as_deref(),
    )?;
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
    let (drive, setup) = procedure::excite(bench, config).map_err(bench_failure)?;
    let what = format!(
        "characterising with a random drive of {}",
        config.excitation.duration
    );
    let recording = play(
        bench,
        &drive,
        Some(&setup),
        &config.run,
        Keeping {
            record,
            rendering: None,
            what: &what,
        },
    )?;
    Ok(procedure::transfer_of(recording, &setup, config)?)
}
