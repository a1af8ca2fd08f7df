//! `piezotact play`: plays a drive and records what the finger does.

use std::path::Path;

use anyhow::anyhow;
use piezotact::device::DriveSetup;
use piezotact::quantity::Drive;
use piezotact::recording::Recording;
use piezotact::series::Series;
use piezotact_bench::procedure::play_and_record;
use piezotact_bench::{Bench, BenchError, Chunk, RunPlan};
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{ReadOptions, read_recording};
use serde_json::json;

use super::characterise::{begin, tenths};
use super::{bench_failure, run_plan};
use crate::cli::Play;
use crate::failure::{Failure, Outcome};
use crate::output::{doubts_json, print, print_json, progress, say_doubts};

pub(crate) fn run(args: &Play) -> Outcome {
    let contents = read_recording(&args.drive, &ReadOptions::default())?;
    let named =
        |error: anyhow::Error| Failure::Data(error.context(args.drive.display().to_string()));
    let drive = contents
        .recording
        .series::<Drive>(None)
        .map_err(|error| named(error.into()))?;
    let mut bench = args.bench.open();
    let mut setup = bench.player.calibrate()?;
    match (&contents.setup, args.gain) {
        (Some(made_for), _) => setup.gain = made_for.gain,
        (None, Some(gain)) => setup.gain = gain,
        (None, None) => {
            return Err(named(anyhow!(
                "expected a sidecar that says which gain the drive is for, found none; render it again, or state it with --gain"
            )));
        }
    }
    let run = run_plan("play", &args.finger);
    let recording = play(
        &mut bench,
        &drive,
        &setup,
        &run,
        &args.record,
        contents.rendering,
    )?;
    if args.json {
        return print_json(&json!({
            "record": args.record,
            "rate_hz": recording.rate(),
            "duration_s": recording.duration(),
            "provenance": recording.provenance,
            "doubts": doubts_json(&recording.doubts)?,
        }));
    }
    say_doubts(&recording.doubts);
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.record.display(),
        recording.duration(),
        recording.provenance.source
    ))
}

/// Plays `drive` and records it in `record`, with its progress shown.
pub(crate) fn play(
    bench: &mut Bench,
    drive: &Series<Drive>,
    setup: &DriveSetup,
    run: &RunPlan,
    record: &Path,
    rendering: Option<Rendering>,
) -> Outcome<Recording> {
    let description = bench.player.describe();
    // Refused before a file is begun.
    if drive.rate() != description.rate {
        let (drive, output) = (drive.rate(), description.rate);
        return Err(BenchError::Rate {
            drive,
            output,
            name: description.name,
        }
        .into());
    }
    if setup.gain != description.gain {
        let (drive, bench) = (setup.gain, description.gain);
        return Err(BenchError::Gain {
            drive,
            bench,
            name: description.name,
        }
        .into());
    }
    bench.acquirer.ready(run).map_err(bench_failure)?;
    let mut journal = begin(record, bench, run, Some(setup.clone()), rendering)?;
    let bar = progress(
        &format!("playing {:.1} of drive", drive.duration()),
        drive.duration(),
    );
    let rate = bench.acquirer.describe().rate;
    let done = play_and_record(bench, drive, Some(setup), run, &mut |chunk: &Chunk| {
        bar.inc(tenths(chunk, rate.hz()));
        journal.append(&chunk.channels).map_err(Into::into)
    });
    bar.finish_and_clear();
    let recording = done.map_err(bench_failure)?;
    journal.finish(recording.doubts.clone())?;
    Ok(recording)
}
