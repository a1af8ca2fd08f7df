//! Advice of the science as options of the command line.

use std::error::Error;

use piezotact::Doubt;
use piezotact::document::Words;
use piezotact::doubt::{Advice, ChannelRole, Merged};
use piezotact::wording;
#[cfg(feature = "haptic")]
use piezotact_haptic::envelope::EnvelopeError;
#[cfg(feature = "study")]
use piezotact_people::association::{AssociationDoubt, FeltDoubt};
#[cfg(feature = "study")]
use piezotact_people::campaign::session::CampaignDoubt;
#[cfg(feature = "study")]
use piezotact_people::eeg::EegDoubt;
#[cfg(feature = "surface")]
use piezotact_surface::SurfaceDoubt;

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
        Advice::ShowDoubts => "piezotact info",
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

/// A doubt in words: what was found, and what to do on the command line.
pub(crate) fn text(doubt: &Doubt) -> String {
    #[cfg(feature = "study")]
    if let Some(text) = of_people(doubt) {
        return text;
    }
    #[cfg(feature = "surface")]
    if let Some(text) = wording::text_of::<SurfaceDoubt>(doubt, &words) {
        return text;
    }
    wording::text_with(doubt, &words)
}

/// A doubt of the science of people in words.
#[cfg(feature = "study")]
fn of_people(doubt: &Doubt) -> Option<String> {
    (doubt
        .kind::<AssociationDoubt>()
        .map(|said| said.to_string()))
    .or_else(|| doubt.kind::<FeltDoubt>().map(|said| said.to_string()))
    .or_else(|| doubt.kind::<CampaignDoubt>().map(|said| said.to_string()))
    .or_else(|| doubt.kind::<EegDoubt>().map(|said| said.to_string()))
}

/// Doubts of one kind in words.
pub(crate) fn merged_text(doubts: &Merged) -> String {
    doubts.text_with(&text)
}

/// Doubts in the words of the command line.
pub(crate) struct OptionWords;

impl Words for OptionWords {
    fn doubt(&self, doubt: &Doubt) -> String {
        text(doubt)
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
