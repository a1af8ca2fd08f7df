//! `piezotact info`: what is in a file.

mod kept;

use std::fmt::Write as _;

use piezotact::quantity::{Band, Hertz};
use piezotact::recording::{Condition, Recording};
use piezotact::roles::Roles;
use piezotact::statistics::{mean, peak, standard_deviation};
use piezotact::transfer::{Limits, StoredIdentities};
use piezotact::warning::{merged, merged_of};
use piezotact_dataset::document::{
    InfoDocument, RecordingInfo, TransferInfo, clock_summaries, event_counts,
};
use piezotact_dataset::{
    Contents, TransferDocument, holds_transfer, known_naming, read_transfer, stored_transfer,
};

use crate::advice::merged_text;
use crate::cli::Info;
use crate::failure::Outcome;
use crate::output::{digits, print, print_document};
use crate::reading::read;

pub(crate) fn run(args: &Info) -> Outcome {
    if let Some(kept) = kept::of(&args.file)? {
        return match args.json {
            true => print_document(&kept.document),
            false => print(&kept.text),
        };
    }
    if holds_transfer(&args.file) {
        return transfer_function(args, &read_transfer(&args.file)?);
    }
    // Before the recording, so that the file is never in memory beside it.
    let stored = match stored_transfer(&args.file)? {
        Some(document) => Some(TransferInfo::of(&args.file, &document, shown_band()?)?),
        None => None,
    };
    let mut contents = read(&args.file, &args.reading)?;
    known_naming(&args.file).complete(&mut contents.recording);
    if args.json {
        let recording = RecordingInfo::of(&args.file, &contents, stored);
        return print_document(&InfoDocument::Recording(Box::new(recording)));
    }
    let mut text = recording_text(args, &contents);
    if let Some(stored) = &stored {
        text += &transfer_text(stored);
    }
    print(&text)
}

fn recording_text(args: &Info, contents: &Contents) -> String {
    let recording = &contents.recording;
    let mut text = format!("{}\n  {}, ", args.file.display(), contents.kind);
    text.push_str(&channels_text(recording));
    let (roles, _) = Roles::guess(recording);
    let others = roles.without_part(recording);
    if !others.is_empty() {
        let _never_fails = write!(
            text,
            "\n  without a role: {} (roles: --vibration, --normal-force, --tangential-force, --motion of strokes)",
            others.join(", ")
        );
    }
    text.push_str(&condition_text(&recording.about.condition));
    text.push_str(&origin_text(contents));
    if let Some(setup) = &contents.setup {
        let _never_fails = write!(
            text,
            "\n  device: gain {}, {:.3} V at full scale, {}",
            setup.gain,
            setup.volts_per_full_scale,
            setup.load()
        );
    }
    // What gives a warning when the drive was made is none of the recording.
    let of_drive = || contents.rendering.iter().flat_map(|r| &r.about.warnings);
    let own = recording.about.warnings.iter();
    let own = own.filter(|warning| of_drive().all(|other| other != *warning));
    let of_drive = of_drive().map(|warning| (Some("from the drive"), warning));
    for warning in merged(own).into_iter().chain(merged_of(of_drive)) {
        let _never_fails = write!(text, "\n  warning: {}", merged_text(&warning));
    }
    text
}

/// Rates, length and channels, after the kind of file.
fn channels_text(recording: &Recording) -> String {
    let mut text = String::new();
    let groups = clock_summaries(recording);
    match groups.as_slice() {
        [one] => {
            let _never_fails = write!(text, "{} samples at {}, ", one.samples, one.rate_hz);
        }
        several => {
            let _never_fails = write!(text, "channels on {} sampling clocks, ", several.len());
        }
    }
    let _never_fails = write!(text, "{:.3}", recording.duration());
    for group in groups.iter().filter(|_| groups.len() > 1) {
        let _never_fails = write!(
            text,
            "\n  {} samples at {}: {}",
            group.samples,
            group.clock(),
            group.channels.join(", ")
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
    text
}

/// Where a recording comes from, what was done to it, and what is stated beside it.
fn origin_text(contents: &Contents) -> String {
    let recording = &contents.recording;
    let mut text = String::new();
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
    let counts = event_counts(recording);
    if counts.iter().any(|(_, count)| *count > 1) {
        let each = counts
            .iter()
            .map(|(name, count)| format!("{name} × {count}"));
        let _never_fails = write!(text, "\n  events: {}", each.collect::<Vec<_>>().join(", "));
    }
    if let Some(lineage) = contents.lineage() {
        let _never_fails = write!(text, "\n  texture: {}", lineage.source);
        for step in &lineage.steps {
            let _never_fails = write!(text, "\n    {step}");
        }
    }
    text
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
    let info = TransferInfo::of(&args.file, document, shown_band()?)?;
    if args.json {
        return print_document(&InfoDocument::Transfer(Box::new(info)));
    }
    print(&format!("{}{}", info.file.display(), transfer_text(&info)))
}

fn transfer_text(info: &TransferInfo<'_>) -> String {
    let function = &info.function;
    let averages = match function.averages {
        0 => "number of averages not stated".into(),
        averages => format!("{averages} averages"),
    };
    let mut text = format!(
        "\n  transfer function from {} to {}, {} lines to {:.1} Hz in steps of {:.3} Hz, {}, {averages}",
        info.drive_unit,
        info.response_unit,
        info.lines,
        info.highest_hz,
        function.resolution_hz(),
        function.estimator,
    );
    if let Some(identities) = &info.identities {
        text += &identities_text(identities);
    }
    if let Some(coherence) = info.coherence {
        let _never_fails = write!(
            text,
            "\n  coherence over {}: median {:.4}, lowest {:.4} at {:.1} Hz",
            coherence.band_hz, coherence.median, coherence.lowest, coherence.lowest_at_hz
        );
    }
    if let Some(excited) = function.excited {
        let _never_fails = write!(text, "\n  excited band {excited}");
    }
    if let Some(limits) = info.limits {
        text += match limits {
            Limits::BestLinear => {
                "\n  95 % limits of the best linear approximation: the drive is known without noise"
            }
            Limits::Scatter => "\n  limits of the scatter of the estimate only, without its bias",
        };
    }
    if let Some(test) = &function.impact {
        let _never_fails = write!(
            text,
            "\n  impact test, {} of {} hits used, segments of {} s, added damping of the exponential window {} 1/s",
            test.used(),
            test.hits.len(),
            digits(test.segment_s),
            digits(test.added_damping_per_s)
        );
    }
    text.push_str(&condition_text(&function.about.condition));
    if let Some(setup) = &function.drive {
        let _never_fails = write!(
            text,
            "\n  measured at gain {}, {:.3} V at full scale",
            setup.gain, setup.volts_per_full_scale
        );
    }
    for warning in &merged(&function.about.warnings) {
        let _never_fails = write!(text, "\n  warning: {}", merged_text(warning));
    }
    text
}

fn identities_text(identities: &StoredIdentities) -> String {
    let ratio = match (identities.estimator, identities.conjugate) {
        (estimator, false) => estimator.to_string(),
        (estimator, true) => format!("{estimator} with the conjugate cross-spectrum"),
    };
    let mut text = format!(
        "\n  {} {ratio} of the stored spectra {} {:.1e} (largest relative difference of {} lines, at {:.1} Hz)",
        if identities.is_equal() {
            "equals"
        } else {
            "differs from"
        },
        if identities.is_equal() {
            "within"
        } else {
            "by up to"
        },
        identities.response_difference,
        identities.lines,
        identities.response_at_hz
    );
    if let Some(difference) = identities.coherence_difference {
        let _never_fails = write!(
            text,
            "; largest difference of the coherence {difference:.1e}"
        );
    }
    text
}
