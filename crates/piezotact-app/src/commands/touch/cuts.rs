//! The file of cuts that a person can edit: written, and never replaced.

use std::path::Path;

use anyhow::anyhow;
use piezotact::study::AnalysedRecording;
use piezotact_dataset::{cuts_text, keep_as_it_is, recording_checksum};

use super::check_outputs;
use crate::cli::Strokes;
use crate::failure::{Failure, Outcome, usage};
use crate::output::write_text;

/// Writes the cuts of a recording as a file, where one is asked for.
pub(super) fn write(args: &Strokes, takes: &[AnalysedRecording]) -> Outcome {
    let (Some(path), [take]) = (&args.write_cuts, takes) else {
        return Ok(());
    };
    let recording = recording_checksum(Path::new(&take.file))?;
    let text = cuts_text(&take.segmentation, take.recording.rate(), recording);
    write_cuts(path, &text)
}

/// Refuses what would replace a person's cuts, or anything that is read.
pub(super) fn check(args: &Strokes) -> Outcome {
    if args.write_cuts.is_some() && args.takes.recordings.len() > 1 {
        return Err(usage(anyhow!(
            "expected one recording with --write-cuts, found {}; give one at a time",
            args.takes.recordings.len()
        )));
    }
    let mut written = args.computing.outputs.files();
    written.extend(args.write_cuts.as_deref());
    check_outputs(&args.takes, &written)
}

/// Writes cuts, which replace no others, asked for or not: a person may have edited them.
fn write_cuts(path: &Path, text: &str) -> Outcome {
    keep_as_it_is(path);
    write_text(path, text).map_err(|failure| match failure {
        Failure::Usage(_) => usage(anyhow!(
            "{} already exists and may contain cuts edited by hand: give another name, or move it away",
            path.display()
        )),
        other => other,
    })
}
