//! `piezotact play`: plays a drive and records what the finger does.

use piezotact::clipping::ClippingDoubt;
use std::path::Path;

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::integrity::doubts_of;
use piezotact::quantity::Drive;
use piezotact::recording::{Provenance, Recording, played_through_its_own};
use piezotact::render::headroom;
use piezotact::run::RunStart;
use piezotact::series::Series;
use piezotact_bench::procedure::play_and_record;
use piezotact_bench::{Bench, RunPlan};
use piezotact_dataset::{ReadOptions, read_recording};
use serde_json::json;

use super::{drive_limit, has_ending, outputs, recording_files, run_plan};
use crate::cli::Play;
use crate::failure::{Failure, Outcome, usage};
use crate::keeping::{Keeper, Place, Shown};
use crate::output::{doubts_json, print, print_json, say_doubts};

pub(crate) fn run(args: &Play) -> Outcome {
    has_ending(&args.record, &["parquet"])?;
    let written = recording_files(&args.record);
    let written = written.each_ref().map(std::path::PathBuf::as_path);
    let read: Vec<&Path> = std::iter::once(args.drive.as_path())
        .chain(args.bench.file())
        .collect();
    outputs(&read, &written)?;
    let contents = read_recording(&args.drive, &ReadOptions::default())?;
    let named =
        |error: anyhow::Error| Failure::Data(error.context(args.drive.display().to_string()));
    let drive = contents
        .recording
        .series::<Drive>(None)
        .map_err(|error| named(error.into()))?;
    let mut bench = args.bench.open()?;
    let here = bench.player.calibrate()?;
    let setup = match (&contents.setup, &args.gain) {
        (Some(made_for), Some(gain)) if made_for.gain.name != *gain => {
            return Err(named(anyhow!(
                "expected the gain {} that the drive was rendered for, found --gain {gain}; leave it out, or render for {gain}",
                made_for.gain
            )));
        }
        (Some(made_for), _) => Some(made_for.clone()),
        (None, Some(gain)) => match here {
            Some(here) => Some(here.with_gain(gain).map_err(usage)?),
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
    let what = format!("playing {:.1} of drive", drive.duration());
    let place = Place::File(&args.record, contents.rendering.clone().map(Box::new));
    let made = contents
        .rendering
        .as_ref()
        .map(|made| &made.about.provenance);
    let mut recording = play(
        &mut bench,
        (&drive, made),
        setup.as_ref(),
        &run,
        (place, &what),
    )?;
    let broken = doubts_of(&recording, drive_limit(setup.as_ref()));
    recording.about.doubts.extend(broken);
    let headroom = headroom(drive.samples(), drive.rate(), setup.as_ref());
    recording
        .about
        .doubts
        .extend(headroom.slew_doubt(setup.as_ref()));
    let clipped = headroom.clipped_fraction;
    if clipped > 0.0 {
        recording
            .about
            .doubts
            .push(Doubt::from(ClippingDoubt::PlayedDriveClipped {
                fraction: clipped,
            }));
    }
    if let Some(rendering) = &contents.rendering {
        recording.about.doubts.extend(
            rendering
                .about
                .condition
                .doubts_when_measured(&recording.about.condition),
        );
    }
    if args.json {
        return print_json(&json!({
            "record": args.record,
            "rate_hz": recording.rate(),
            "duration_s": recording.duration(),
            "provenance": recording.about.provenance,
            "doubts": doubts_json(&recording.about.doubts)?,
        }));
    }
    say_doubts(&recording.about.doubts);
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.record.display(),
        recording.duration(),
        recording.about.provenance.source
    ))
}

/// Plays `drive` and records the response. `made` is the provenance of the drive, `place` where the recording is kept, `what` the
/// text beside the progress bar.
pub(crate) fn play(
    bench: &mut Bench,
    (drive, made): (&Series<Drive>, Option<&Provenance>),
    setup: Option<&DriveSetup>,
    run: &RunPlan,
    (place, what): (Place<'_>, &str),
) -> Outcome<Recording> {
    let what = |_: &RunStart| what.to_owned();
    let mut keeper = Keeper::new(place, Shown::Each(&what, drive.duration()));
    let recorded = play_and_record(bench, drive, setup, run, &mut keeper, None);
    let mut recording = recorded.map_err(|error| keeper.failure(error))?;
    let its_own = made.and_then(|drive| played_through_its_own(drive, &recording.about.provenance));
    recording.about.doubts.extend(its_own);
    Ok(recording)
}
