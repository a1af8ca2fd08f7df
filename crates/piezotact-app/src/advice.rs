//! The options of the command line with which the advice of a warning or an error is followed.

use std::error::Error;

use piezotact::Warning;
use piezotact::document::Words;
use piezotact::feature::FeatureError;
use piezotact::recording::RecordingError;
use piezotact::score::ScoreError;
use piezotact::stroke::SegmentError;
use piezotact::transfer::TransferError;
use piezotact::warning::Merged;
use piezotact_bench::{DeviceError, ProcedureError};
#[cfg(feature = "haptic")]
use piezotact_haptic::HapticError;

/// The options that a warning's advice needs, by code and cause (the value of one of [`CAUSES`]; empty for any).
const OPTIONS: [(&str, &str, &str); 41] = [
    ("band_part_lost", "no_target", "--band"),
    ("channel_chosen", "motion", "--motion"),
    ("channel_chosen", "normal_force", "--normal-force"),
    ("channel_chosen", "vibration", "--vibration"),
    ("channel_missing", "cutting", "--cuts"),
    ("channel_missing", "force_unit", "--scale"),
    ("channels_swapped", "", "--drive and --response"),
    ("contact_map_ends", "", "--contact-map"),
    ("counts", "", "--scale"),
    ("cutoff_unsettled", "", "--cutoff"),
    (
        "device_not_described",
        "",
        "--gain and --volts-per-full-scale",
    ),
    ("faded", "", "--fade 0"),
    ("few", "averages", "--segment"),
    ("few", "sections", "--cutoff"),
    ("filter_doubtful", "looks_filtered", "--filter none"),
    ("filter_doubtful", "twice", "--filter none"),
    ("gesture_kept", "", "--high-pass"),
    ("instrument_differs", "length", "--step"),
    ("instrument_differs", "parameter", "--cutoff"),
    ("late_response", "", "--segment"),
    ("low_coherence", "", "--band"),
    ("no_contact", "", "--load"),
    ("not_excited", "", "--band"),
    ("one_segment", "", "--part N"),
    ("open_multiple", "", "--high-pass"),
    (
        "played_through_its_own",
        "",
        "panel=FOLDER after the file name of the measured bench",
    ),
    ("power_outside_band", "", "--band"),
    ("pulses_in_drive", "", "--excitation"),
    ("rejected", "", "--report and --cuts"),
    ("response_not_decayed", "end", "--exponential"),
    ("scatter", "strokes_of_texture", "--cuts"),
    ("simulated", "transfer", "piezotact info"),
    ("slew_limited", "", "--band"),
    ("stated_differs", "rate_kept", "without --rate"),
    ("taken_whole", "", "--stroke N"),
    ("thresholds_of_skin", "", "--contact-map"),
    ("uncalibrated", "", "--scale"),
    ("uneven_profile", "", "--cutoff"),
    ("unresolved_resonance", "", "--segment"),
    ("unusual_stroke", "left_out", "--segment"),
    ("unusual_stroke", "long", "--cuts"),
];

/// The fields that hold which cause or fault a warning is about.
const CAUSES: [&str; 8] = ["at", "by", "fault", "how", "of", "role", "what", "why"];

/// A warning in words: what was found, and what to do on the command line.
pub(crate) fn text(warning: &Warning) -> String {
    let is = |cause: &str| {
        let mut causes = CAUSES.iter().filter_map(|name| warning.fields.get(*name));
        cause.is_empty() || causes.any(|found| found == cause)
    };
    let option = OPTIONS
        .iter()
        .find(|(code, cause, _)| *code == warning.code && is(cause));
    match option {
        Some((_, _, option)) => format!("{warning} ({option})"),
        None => warning.to_string(),
    }
}

/// Warnings of one kind in words.
pub(crate) fn merged_text(warnings: &Merged) -> String {
    warnings.text_with(&text)
}

/// Warnings in the words of the command line.
pub(crate) struct OptionWords;

impl Words for OptionWords {
    fn warning(&self, warning: &Warning) -> String {
        text(warning)
    }
}

/// The options that help with an error of the science.
pub(crate) fn options_for(error: &(dyn Error + 'static)) -> Option<&'static str> {
    if let Some(RecordingError::Ambiguous { .. }) = error.downcast_ref() {
        return Some("--channel");
    }
    if let Some(RecordingError::Unit { .. }) = error.downcast_ref() {
        return Some("--scale");
    }
    match error.downcast_ref() {
        Some(TransferError::Transient { .. }) => return Some("--excitation impact"),
        Some(TransferError::NoHit { .. } | TransferError::NoPulses) => {
            return Some("--excitation");
        }
        _ => {}
    }
    let device = error.downcast_ref().or_else(|| match error.downcast_ref() {
        Some(ProcedureError::Device(device)) => Some(device),
        _ => None,
    });
    if let Some(DeviceError::Duration { .. }) = device {
        return Some("--seconds");
    }
    if let Some(SegmentError::NothingToCutBy) = error.downcast_ref() {
        return Some("--normal-force, --motion, --vibration");
    }
    if let Some(
        FeatureError::NoVibration { .. }
        | FeatureError::ConstantVibration { .. }
        | FeatureError::Units { .. },
    ) = error.downcast_ref()
    {
        return Some("--vibration");
    }
    if let Some(ScoreError::TooShort { .. }) = error.downcast_ref() {
        return Some("manipulate --loop");
    }
    if let Some(ScoreError::Perception(_)) = error.downcast_ref() {
        return Some("--model spectral");
    }
    #[cfg(feature = "haptic")]
    if let Some(HapticError::TooMany { .. }) = error.downcast_ref() {
        return Some("--rate");
    }
    None
}
