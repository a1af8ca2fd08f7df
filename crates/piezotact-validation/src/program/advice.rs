//! Advice of the science as options of the `piezotact` command, with which a laboratory follows it.

use std::error::Error;

use piezotact::Warning;
use piezotact::document::Words;
use piezotact::warning::{Advice, ChannelRole};
use piezotact::wording;
use piezotact_people::eeg::EegWarning;

/// The option with which advice is followed; `None` where there is none, and for advice that measurements on the twin never give.
fn option(advice: &Advice) -> Option<String> {
    let option = match advice {
        Advice::NameChannel { role } => match role {
            ChannelRole::NormalForce => "--normal-force",
            ChannelRole::Motion => "--motion",
            ChannelRole::Vibration => "--vibration",
            ChannelRole::Signal => "--channel",
        },
        Advice::StateScale => "--scale",
        Advice::StateLoad => "--load",
        Advice::CutByHand => "--cuts",
        Advice::StateHighPass { at_hz } => return Some(format!("--high-pass {at_hz}")),
        Advice::ShorterSegments { .. } | Advice::LongerSegments => "--segment",
        Advice::ExchangeDriveAndResponse => "--drive and --response",
        Advice::NarrowBand | Advice::WidenBand => "--band",
        Advice::DescribeDevice => "--gain and --volts-per-full-scale",
        Advice::StateExcitation => "--excitation",
        _ => return None,
    };
    Some(option.to_owned())
}

/// Warnings in the words of the `piezotact` command.
pub(super) struct OptionWords;

impl Words for OptionWords {
    fn warning(&self, warning: &Warning) -> String {
        match warning.kind::<EegWarning>() {
            Some(of_eeg) => of_eeg.to_string(),
            None => wording::text_with(warning, &|advice| self.advice(advice)),
        }
    }

    fn advice(&self, advice: &Advice) -> String {
        match option(advice) {
            Some(option) => format!("{advice} ({option})"),
            None => advice.to_string(),
        }
    }
}

/// The options that help with an error of the science.
pub(super) fn options_for(error: &(dyn Error + 'static)) -> Option<String> {
    let advice = wording::advice_of_error(error);
    let options: Vec<String> = advice.iter().filter_map(option).collect();
    (!options.is_empty()).then(|| options.join(", "))
}
