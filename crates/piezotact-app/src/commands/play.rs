//! `piezotact play`: plays a drive and records what the finger does.

use std::path::Path;

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::integrity::doubts_of;
use piezotact::quantity::Drive;
use piezotact::recording::{Annotations, Recording, played_through_its_own};
use piezotact::render::headroom;
use piezotact::series::Series;
use piezotact_bench::procedure::{RunStart, announce, play_and_record, require_device};
use piezotact_bench::{Bench, Chunk, Gate, RunPlan};
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{JournalWriter, ReadOptions, StartDocument, WriteError, read_recording};
use serde_json::json;

use super::{bench_failure, drive_limit, open_bench, outputs, recording_files, run_plan};
use crate::cli::Play;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, print, print_json, progress, say, say_doubts};

pub(crate) fn run(args: &Play) -> Outcome {
    let [record, journal] = recording_files(&args.record);
    let read: Vec<&Path> = std::iter::once(args.drive.as_path())
        .chain(args.bench.file())
        .collect();
    outputs(&read, &[&record, &journal])?;
    let contents = read_recording(&args.drive, &ReadOptions::default())?;
    let named =
        |error: anyhow::Error| Failure::Data(error.context(args.drive.display().to_string()));
    let drive = contents
        .recording
        .series::<Drive>(None)
        .map_err(|error| named(error.into()))?;
    let mut bench = open_bench(&args.bench)?;
    let here = bench.player.calibrate()?;
    let setup = match (&contents.setup, args.gain) {
        (Some(made_for), Some(gain)) if made_for.gain != gain => {
            return Err(named(anyhow!(
                "expected the gain {} that the drive was rendered for, found --gain {gain}; leave it out, or render for {gain}",
                made_for.gain
            )));
        }
        (Some(made_for), _) => Some(made_for.clone()),
        (None, Some(gain)) => match here {
            Some(here) => Some(DriveSetup { gain, ..here }),
            None => {
                return Err(usage(anyhow!(
                    "expected no --gain on the {}, of whose device nothing is known, found {gain}; leave it out",
                    bench.player.describe().name
                )));
            }
        },
        // Nothing is known of either: only the digital full scale counts.
        (None, None) if here.is_none() => None,
        (None, None) => {
            return Err(named(anyhow!(
                "expected to know which gain the drive is for, found nothing that says it; state it with --gain, or render with a transfer function that says it"
            )));
        }
    };
    let run = run_plan("play", &args.finger, bench.acquirer.as_ref());
    let keeping = Keeping {
        record: Some(&args.record),
        rendering: contents.rendering.clone(),
        what: &format!("playing {:.1} of drive", drive.duration()),
        gate: None,
    };
    let mut recording = play(&mut bench, &drive, setup.as_ref(), &run, keeping)?;
    let broken = doubts_of(&recording, drive_limit(setup.as_ref()));
    recording.doubts.extend(broken);
    let clipped = headroom(drive.samples(), drive.rate(), setup.as_ref()).clipped_fraction;
    if clipped > 0.0 {
        recording.doubts.push(Doubt::Clipped {
            what: "the drive that was played".into(),
            fraction: clipped,
        });
    }
    if let Some(rendering) = &contents.rendering {
        recording.doubts.extend(
            rendering
                .condition
                .doubts_when_measured(&recording.condition),
        );
    }
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

/// How a run is kept.
pub(crate) struct Keeping<'a> {
    /// The recording to write, if it is to be kept.
    pub(crate) record: Option<&'a Path>,
    /// How the drive was made.
    pub(crate) rendering: Option<Rendering>,
    /// What the progress bar says.
    pub(crate) what: &'a str,
    /// What judges the run while it runs.
    pub(crate) gate: Option<&'a mut Gate>,
}

/// Plays `drive` and records what comes of it, with its progress shown.
pub(crate) fn play(
    bench: &mut Bench,
    drive: &Series<Drive>,
    setup: Option<&DriveSetup>,
    run: &RunPlan,
    mut keeping: Keeping<'_>,
) -> Outcome<Recording> {
    // Refused before a file is begun.
    require_device(bench, drive, setup).map_err(bench_failure)?;
    bench.acquirer.ready(run).map_err(bench_failure)?;
    let rendering = keeping.rendering;
    let made_with = rendering.as_ref().map(|made| made.provenance.clone());
    let start = StartDocument {
        setup: setup.cloned(),
        rendering,
        ..start_document(announce(bench.acquirer.as_ref(), run))
    };
    let rate = start.rate_hz;
    let mut journal = keeping
        .record
        .map(|path| JournalWriter::create(path, start))
        .transpose()?;
    let bar = progress(keeping.what, drive.duration());
    let done = play_and_record(bench, drive, setup, run, &mut |chunk: &Chunk| {
        let frames = chunk.channels.first().map_or(0, Vec::len);
        bar.inc((frames as f64 / rate.hz() * 10.0).round() as u64);
        if let Some(journal) = journal.as_mut() {
            journal.append(&chunk.channels)?;
        }
        match keeping.gate.as_deref_mut() {
            Some(gate) => gate.admit(chunk).map_err(Into::into),
            None => Ok(()),
        }
    });
    bar.finish_and_clear();
    let mut recording = done.map_err(bench_failure)?;
    let its_own = made_with
        .as_ref()
        .and_then(|drive| played_through_its_own(drive, &recording.provenance));
    recording.doubts.extend(its_own);
    if let Some(kept) = finish(journal, &recording)? {
        say(&kept);
    }
    Ok(recording)
}

/// What a journal begins with.
pub(crate) fn start_document(start: RunStart) -> StartDocument {
    StartDocument {
        format: StartDocument::FORMAT,
        rate_hz: start.rate,
        channels: start.channels,
        condition: start.condition,
        provenance: start.provenance,
        annotations: Annotations::default(),
        setup: None,
        rendering: None,
    }
}

/// Ends a journal, and says where a recording of the same name was put.
fn finish(
    journal: Option<JournalWriter>,
    recording: &Recording,
) -> Result<Option<String>, WriteError> {
    let Some(journal) = journal else {
        return Ok(None);
    };
    let kept = journal.finish(recording.provenance.clone(), recording.doubts.clone())?;
    Ok(kept.map(|kept| {
        format!(
            "the recording of that name that was there is kept as {}",
            kept.display()
        )
    }))
}
