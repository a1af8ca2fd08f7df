//! `piezotact info`: what is in a file.

mod kept;

use std::fmt::Write as _;

use piezotact::doubt::merged;
use piezotact::lineage::Lineage;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Quantity};
use piezotact::recording::{Annotations, Clock, Condition, Recording};
use piezotact::statistics::{mean, peak, standard_deviation};
use piezotact_dataset::{Contents, TransferDocument, holds_transfer, read_transfer};
use serde_json::json;

use super::read;
use crate::advice::merged_text;
use crate::cli::Info;
use crate::failure::Outcome;
use crate::output::{digits, doubts_json, print, print_json};

pub(crate) fn run(args: &Info) -> Outcome {
    if let Some(kept) = kept::of(&args.file)? {
        return match args.json {
            true => print_json(&kept.json),
            false => print(&kept.text),
        };
    }
    if holds_transfer(&args.file) {
        return transfer_function(args, &read_transfer(&args.file)?);
    }
    let contents = read(&args.file, &args.reading)?;
    if args.json {
        recording_json(args, &contents)
    } else {
        recording_text(args, &contents)
    }
}

fn recording_json(args: &Info, contents: &Contents) -> Outcome {
    let recording = &contents.recording;
    let channels: Vec<_> = recording
        .channels()
        .iter()
        .map(|channel| {
            json!({
                "name": channel.name,
                "unit": channel.unit,
                "mean": mean(&channel.samples),
                "standard_deviation": standard_deviation(&channel.samples),
                "peak": peak(&channel.samples),
            })
        })
        .collect();
    let mut document = json!({
        "file": args.file,
        "kind": contents.kind.to_string(),
        "rate_hz": recording.rate(),
        "samples": recording.len(),
        "duration_s": recording.duration(),
        "channels": channels,
        "condition": recording.about.condition,
        "provenance": recording.about.provenance,
        "drive_setup": contents.setup,
        "rendering": contents.rendering,
        "doubts": doubts_json(&recording.about.doubts)?,
    });
    if recording.clocks().len() > 1 {
        let groups = groups(recording);
        let group = |(clock, samples, names): &(Clock, usize, Vec<&str>)| {
            json!({
                "rate_hz": clock.rate_hz,
                "start_s": clock.start_s,
                "samples": samples,
                "channels": names,
            })
        };
        document["clocks"] = groups.iter().map(group).collect();
    }
    if recording.annotations != Annotations::default() {
        document["annotations"] = json!(recording.annotations);
    }
    print_json(&document)
}

/// The channels of each clock, with the number of their samples.
fn groups(recording: &Recording) -> Vec<(Clock, usize, Vec<&str>)> {
    let of = |clock: &Clock| {
        let channels = recording.channels_with_clocks();
        let channels: Vec<_> = channels
            .filter_map(|(channel, own)| (own == *clock).then_some(channel))
            .collect();
        let names = channels.iter().map(|channel| channel.name.as_str());
        let samples = channels.first().map_or(0, |channel| channel.samples.len());
        (*clock, samples, names.collect())
    };
    recording.clocks().iter().map(of).collect()
}

fn recording_text(args: &Info, contents: &Contents) -> Outcome {
    let recording = &contents.recording;
    let mut text = format!("{}\n  {}, ", args.file.display(), contents.kind);
    let groups = groups(recording);
    match groups.as_slice() {
        [(clock, samples, _)] => {
            let _never_fails = write!(text, "{samples} samples at {}, ", clock.rate_hz);
        }
        several => {
            let _never_fails = write!(text, "channels of {} clocks, ", several.len());
        }
    }
    let _never_fails = write!(text, "{:.3}", recording.duration());
    for (clock, samples, names) in groups.iter().filter(|_| groups.len() > 1) {
        let _never_fails = write!(
            text,
            "\n  {samples} samples at {clock}: {}",
            names.join(", ")
        );
    }
    for channel in recording.channels() {
        let _never_fails = write!(
            text,
            "\n  {:<20} mean {}, standard deviation {}, peak {} {}",
            channel.name,
            digits(mean(&channel.samples)),
            digits(standard_deviation(&channel.samples)),
            digits(peak(&channel.samples)),
            channel.unit
        );
    }
    text.push_str(&condition_text(&recording.about.condition));
    if !recording.about.provenance.source.is_empty() {
        let _never_fails = write!(text, "\n  from: {}", recording.about.provenance.source);
    }
    for step in &recording.about.provenance.steps {
        let _never_fails = write!(text, "\n    {step}");
    }
    if let Some(time) = &recording.annotations.started_at {
        let _never_fails = write!(text, "\n  started at {time}");
    }
    for (name, label) in &recording.annotations.labels {
        let _never_fails = write!(text, "\n  label {name}: {label}");
    }
    for event in &recording.annotations.events {
        let _never_fails = write!(text, "\n  {}", event);
    }
    if let Some(lineage) = lineage_of(contents) {
        let _never_fails = write!(text, "\n  texture: {}", lineage.source);
        for step in &lineage.steps {
            let _never_fails = write!(text, "\n    {step}");
        }
    }
    if let Some(setup) = &contents.setup {
        let _never_fails = write!(
            text,
            "\n  device: gain {}, {:.3} V at full scale, {:.0} nF",
            setup.gain,
            setup.volts_per_full_scale,
            setup.load_f * 1e9
        );
    }
    let of_the_drive = contents.rendering.iter().flat_map(|r| &r.about.doubts);
    let of_the_drive = of_the_drive.filter(|doubt| !recording.about.doubts.contains(doubt));
    for doubt in merged(recording.about.doubts.iter().chain(of_the_drive)) {
        let _never_fails = write!(text, "\n  doubt: {}", merged_text(&doubt));
    }
    print(&text)
}

/// What was done to a texture on purpose: to the one in a file, or to the one that a drive was rendered from.
fn lineage_of(contents: &Contents) -> Option<&Lineage> {
    let rendering = contents.rendering.as_ref();
    let own = contents.recording.about.provenance.lineage.as_ref();
    own.or_else(|| rendering?.about.provenance.lineage.as_ref())
}

/// The band over which coherence is summed up: the one that is rendered unless stated.
fn shown_band() -> Outcome<Band> {
    Ok(Band::new(Hertz(20.0), Hertz(1000.0))?)
}

fn condition_text(condition: &Condition) -> String {
    let known = condition.to_string();
    if known.is_empty() {
        known
    } else {
        format!("\n  condition: {known}")
    }
}

fn transfer_function(args: &Info, document: &TransferDocument) -> Outcome {
    // Read as what it says it is, so that what is wrong with it is found here.
    let mut read = document.clone();
    (read.drive_unit, read.response_unit) = (Drive::UNIT, Acceleration::UNIT);
    let function = read.function::<Drive, Acceleration>(&args.file)?;
    if args.json {
        return print_json(&json!({
            "file": args.file,
            "kind": "transfer function",
            "drive_unit": document.drive_unit,
            "response_unit": document.response_unit,
            "lines": function.response().len(),
            "resolution_hz": function.resolution_hz(),
            "highest_hz": function.highest_hz(),
            "estimator": function.estimator,
            "averages": function.averages,
            "driven_hz": function.driven,
            "distortion": document.distortion,
            "coherence": function.coherence_in(shown_band()?),
            "condition": function.about.condition,
            "drive_setup": function.drive,
            "provenance": function.about.provenance,
            "doubts": doubts_json(&function.about.doubts)?,
        }));
    }
    let mut text = format!(
        "{}\n  transfer function from {} to {}, {} lines to {:.1} Hz in steps of {:.3} Hz, {:?}, {} averages",
        args.file.display(),
        document.drive_unit,
        document.response_unit,
        function.response().len(),
        function.highest_hz(),
        function.resolution_hz(),
        function.estimator,
        function.averages
    );
    if let Some(coherence) = function.coherence_in(shown_band()?) {
        let _never_fails = write!(
            text,
            "\n  coherence over {}: median {:.4}, lowest {:.4} at {:.1} Hz",
            coherence.band_hz, coherence.median, coherence.lowest, coherence.lowest_at_hz
        );
    }
    if let Some(driven) = function.driven {
        let _never_fails = write!(text, "\n  driven over {driven}");
    }
    text.push_str(&condition_text(&function.about.condition));
    if let Some(setup) = &function.drive {
        let _never_fails = write!(
            text,
            "\n  measured at gain {}, {:.3} V at full scale",
            setup.gain, setup.volts_per_full_scale
        );
    }
    for doubt in merged(&function.about.doubts) {
        let _never_fails = write!(text, "\n  doubt: {}", merged_text(&doubt));
    }
    print(&text)
}
