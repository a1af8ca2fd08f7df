//! `piezotact strokes --cuts-only`: recordings cut into strokes.

use std::path::Path;

use anyhow::anyhow;
use piezotact::study::{AnalysedRecording, CutsDocument, cuts_table};
use piezotact::warning::merged;
use piezotact_dataset::{cuts_text, keep_as_it_is, recording_checksum};
use piezotact_report::touch;

use super::{check_outputs, take_all, write_table, wrote};
use crate::advice::{OptionWords, merged_text};
use crate::cli::Strokes;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say, write_text};

pub(super) fn run(args: &Strokes) -> Outcome {
    let computing = &args.computing;
    let (takes, failures) = take_all(&args.takes)?;
    write(args, &takes)?;
    write_table(computing.csv.as_deref(), &cuts_table(&takes))?;
    if let Some(path) = &computing.report {
        write_report(path, &touch::cuts(&takes, failures.files(), &OptionWords)?)?;
    }
    if computing.json {
        print_document(&CutsDocument {
            failed: failures.files(),
            ..CutsDocument::of(&takes)
        })?;
        return failures.outcome();
    }
    for take in &takes {
        for warning in merged(&take.warnings()) {
            say(&format!(
                "warning: {}: {}",
                take.name,
                merged_text(&warning)
            ));
        }
        print(&take.cuts_text())?;
    }
    wrote(&[&args.write_cuts, &computing.csv, &computing.report])?;
    failures.outcome()
}

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
    let computing = &args.computing;
    check_outputs(
        &args.takes,
        &[&args.write_cuts, &computing.csv, &computing.report],
    )
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
