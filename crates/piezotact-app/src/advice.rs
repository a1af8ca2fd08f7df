//! Advice of the science as options of the command line.

use std::error::Error;

use piezotact::Warning;
use piezotact::document::Words;
use piezotact::warning::{Advice, ChannelRole, Merged};
use piezotact::wording;
#[cfg(feature = "haptic")]
use piezotact_haptic::envelope::EnvelopeError;
#[cfg(feature = "study")]
use piezotact_people::association::{AssociationWarning, FeltWarning};
#[cfg(feature = "study")]
use piezotact_people::campaign::session::CampaignWarning;
#[cfg(feature = "study")]
use piezotact_people::eeg::EegWarning;
#[cfg(feature = "surface")]
use piezotact_surface::SurfaceWarning;

/// The option with which advice is followed on the command line; `None` where there is none.
fn option(advice: &Advice) -> Option<String> {
    let option = match advice {
        Advice::NameChannel { role } => match role {
            ChannelRole::NormalForce => "--normal-force",
            ChannelRole::Motion => "--motion",
            ChannelRole::Vibration => "--vibration",
            ChannelRole::Signal => "--channel",
        },
        Advice::StateScale => "--scale",
        Advice::OmitRate => "without --rate",
        Advice::LowerRate => "--rate",
        Advice::StateLoad => "--load",
        Advice::CutByHand => "--cuts",
        Advice::TakeStroke => "--stroke N",
        Advice::StateHighPass { at_hz } => return Some(format!("--high-pass {at_hz}")),
        Advice::StateCutoff => "--cutoff",
        Advice::LeaveUnfiltered => "--filter none",
        Advice::StateStep => "--step",
        Advice::ShorterSegments { .. } | Advice::LongerSegments => "--segment",
        Advice::ExchangeDriveAndResponse => "--drive and --response",
        Advice::NarrowBand | Advice::WidenBand => "--band",
        Advice::GiveContactMap => "--contact-map",
        Advice::DescribeDevice => "--gain and --volts-per-full-scale",
        Advice::JoinWithItself => "manipulate --loop",
        Advice::EvaluateAsImpacts => "--excitation impact",
        Advice::StateExcitation => "--excitation",
        Advice::ExponentialWindow => "--exponential",
        Advice::ShowWarnings => "piezotact info",
        Advice::PlayThroughOtherPlacement => {
            "panel=FOLDER after the file name of the measured bench"
        }
        _ => return None,
    };
    Some(option.to_owned())
}

/// Advice in words, with its option.
pub(crate) fn words(advice: &Advice) -> String {
    match option(advice) {
        Some(option) => format!("{advice} ({option})"),
        None => advice.to_string(),
    }
}

/// A warning in words: what was found, and what to do on the command line.
pub(crate) fn text(warning: &Warning) -> String {
    #[cfg(feature = "study")]
    if let Some(text) = of_people(warning) {
        return text;
    }
    #[cfg(feature = "surface")]
    if let Some(text) = wording::text_of::<SurfaceWarning>(warning, &words) {
        return text;
    }
    wording::text_with(warning, &words)
}

/// A warning of the science of people in words.
#[cfg(feature = "study")]
fn of_people(warning: &Warning) -> Option<String> {
    (warning
        .kind::<AssociationWarning>()
        .map(|said| said.to_string()))
    .or_else(|| warning.kind::<FeltWarning>().map(|said| said.to_string()))
    .or_else(|| {
        warning
            .kind::<CampaignWarning>()
            .map(|said| said.to_string())
    })
    .or_else(|| warning.kind::<EegWarning>().map(|said| said.to_string()))
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

    fn advice(&self, advice: &Advice) -> String {
        words(advice)
    }
}

/// The options that help with an error of the science.
pub(crate) fn options_for(error: &(dyn Error + 'static)) -> Option<String> {
    let advice = wording::advice_of_error(error);
    #[cfg(feature = "haptic")]
    let advice = match error.downcast_ref() {
        Some(EnvelopeError::TooMany { .. }) => vec![Advice::LowerRate],
        _ => advice,
    };
    let options: Vec<String> = advice.iter().filter_map(option).collect();
    (!options.is_empty()).then(|| options.join(", "))
}
