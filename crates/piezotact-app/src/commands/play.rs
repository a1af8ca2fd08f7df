//! `piezotact play`: plays a drive and records what the finger does.

use std::path::Path;

use anyhow::anyhow;
use piezotact::device::DriveSetup;
use piezotact::integrity::warnings_of;
use piezotact::quantity::Drive;
use piezotact::recording::{Provenance, Recording, played_through_its_own};
use piezotact::render::{Rendering, warnings_of_played};
use piezotact::run::{Acquired, Played, RunStart};
use piezotact::series::Series;
use piezotact_bench::procedure::play_and_record;
use piezotact_bench::{Bench, RunPlan};
use piezotact_dataset::{ReadOptions, read_recording};

use crate::cli::Play;
use crate::failure::{Failure, Outcome, usage};
use crate::keeping::{Keeper, Place, Shown};
use crate::output::{print, print_kept, say_warnings};
use crate::places::{has_ending, outputs, recording_files};
use crate::reading::drive_limit;
use crate::runs::run_plan;

pub(crate) fn run(args: &Play) -> Outcome {
    args.live.begin();
    has_ending(&args.record, &["parquet"])?;
    let written = recording_files(&args.record);
    let written = written.each_ref().map(std::path::PathBuf::as_path);
    let read: Vec<&Path> = std::iter::once(args.drive.as_path())
        .chain(args.bench.file())
        .collect();
    outputs(&read, &written)?;
    let contents = read_recording(&args.drive, &ReadOptions::default())?;
    let drive = contents.recording.series::<Drive>(None);
    let drive = drive.map_err(|error| of_drive(args, error))?;
    let mut bench = args.bench.open()?;
    let setup = setup(args, contents.setup.as_ref(), &mut bench)?;
    let run = run_plan("play", &args.finger, bench.acquirer.as_ref());
    let (rendering, record) = (contents.rendering.as_ref(), args.record.as_path());
    let recording = played(
        &mut bench,
        (&drive, rendering),
        setup.as_ref(),
        &run,
        record,
    )?;
    if args.json {
        return print_kept(&args.record, &Played(Acquired::of(&recording)));
    }
    say_warnings(&recording.about.warnings);
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.record.display(),
        recording.duration(),
        recording.about.provenance.source
    ))
}

fn of_drive(args: &Play, error: impl Into<anyhow::Error>) -> Failure {
    Failure::Data(error.into().context(args.drive.display().to_string()))
}

/// The device that the drive is played with: the one that it was `made_for`, else that of the bench at the gain that the options
/// state; `None` where nothing is known of either.
fn setup(
    args: &Play,
    made_for: Option<&DriveSetup>,
    bench: &mut Bench,
) -> Outcome<Option<DriveSetup>> {
    let here = bench.player.calibrate()?;
    match (made_for, &args.gain) {
        (Some(made_for), Some(gain)) if made_for.gain.name != *gain => Err(of_drive(
            args,
            anyhow!(
                "expected the gain {} that the drive was rendered for, found --gain {gain}; leave it out, or render for {gain}",
                made_for.gain
            ),
        )),
        (Some(made_for), _) => Ok(Some(made_for.clone())),
        (None, Some(gain)) => match here {
            Some(here) => Ok(Some(here.with_gain(gain).map_err(usage)?)),
            None => Err(usage(anyhow!(
                "expected no --gain on the {}, whose device is not described, found {gain}; leave it out",
                bench.player.describe().name
            ))),
        },
        // Only the digital full scale counts.
        (None, None) if here.is_none() => Ok(None),
        (None, None) => Err(of_drive(
            args,
            anyhow!(
                "expected the gain for which the drive was made, found none; state it with --gain, or render with a transfer \
                 function that states it"
            ),
        )),
    }
}

/// Plays `drive`, made as `rendering` says, and keeps the response in the file `record`; with all with warnings of it.
pub(super) fn played(
    bench: &mut Bench,
    (drive, rendering): (&Series<Drive>, Option<&Rendering>),
    setup: Option<&DriveSetup>,
    run: &RunPlan,
    record: &Path,
) -> Outcome<Recording> {
    let what = format!("playing the drive, {:.1}", drive.duration());
    let place = Place::File(record, rendering.cloned().map(Box::new));
    let made = rendering.map(|made| &made.about.provenance);
    let mut recording = play(bench, (drive, made), setup, run, (place, &what))?;
    let broken = warnings_of(&recording, drive_limit(setup));
    recording.about.add_warnings(broken);
    let found = warnings_of_played(drive, setup, rendering, &recording.about.condition);
    recording.about.warnings.extend(found);
    Ok(recording)
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
    recording.about.warnings.extend(its_own);
    Ok(recording)
}
