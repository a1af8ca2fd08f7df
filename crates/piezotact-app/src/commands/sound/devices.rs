//! `piezotact sound devices`: the sound devices of this computer.

use clap::Args;
use piezotact::sound::{Answers, Offer, SoundDevices, SoundHost};
use piezotact_audio::{AudioIo as _, HardwareIo, hosts};

use crate::failure::Outcome;
use crate::output::{print, print_document};

/// A larger number is no limit.
const ENDLESS: u32 = 1 << 24;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Lists the devices of this sound system alone, such as alsa, jack or pipewire.
    #[arg(long, value_name = "NAME")]
    host: Option<String>,
    /// Prints the list as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let mut found = SoundDevices::default();
    // The loop within the program has none, and is always there.
    let host = args.host.as_ref().filter(|host| *host != "loop");
    if args.host.is_some() && host.is_none() {
        found.hosts = Vec::new();
    } else if let Some(host) = host {
        // A host that is named is there, or the reason is said.
        found.devices = HardwareIo::new(host)?.devices()?;
        found.hosts.push(SoundHost {
            name: host.clone(),
            answers: match found.devices.is_empty() {
                true => Answers::No,
                false => Answers::Yes,
            },
        });
    } else {
        for host in hosts() {
            if host.answers == Answers::Yes {
                let devices = HardwareIo::new(&host.name)?.devices();
                found.devices.extend(devices.unwrap_or_default());
            }
            found.hosts.push(host);
        }
    }
    match args.json {
        true => print_document(&found),
        false => print(&text(&found)),
    }
}

fn text(found: &SoundDevices) -> String {
    let host = |host: &SoundHost| match host.answers {
        Answers::Yes => format!("{}: answers", host.name),
        Answers::No => format!("{}: does not answer", host.name),
    };
    let mut lines: Vec<String> = found.hosts.iter().map(host).collect();
    lines.push("loop: always there; a loop within the program, with no device".into());
    for device in &found.devices {
        lines.push(format!(
            "\n{} `{}`  {}",
            device.host, device.id, device.name
        ));
        for (direction, offers) in [("output", &device.outputs), ("input", &device.inputs)] {
            lines.extend(
                shown(offers)
                    .into_iter()
                    .map(|offer| format!("  {direction}: {offer}")),
            );
        }
    }
    if found.devices.is_empty() {
        lines.push("\nno sound device".into());
    }
    lines.join("\n")
}

/// Offers in words: channels, rates and buffers of all formats together, and the formats.
fn shown(offers: &[Offer]) -> Option<String> {
    let first = offers.first()?;
    let (mut channels, mut rates) = ([first.channels; 2], first.rates_hz);
    let mut buffers: Option<[u32; 2]> = None;
    let mut formats: Vec<&str> = Vec::new();
    for offer in offers {
        channels = [
            channels[0].min(offer.channels),
            channels[1].max(offer.channels),
        ];
        rates = [
            rates[0].min(offer.rates_hz[0]),
            rates[1].max(offer.rates_hz[1]),
        ];
        if let Some([least, most]) = offer.buffer_frames {
            let [low, high] = buffers.unwrap_or([least, most]);
            buffers = Some([low.min(least), high.max(most)]);
        }
        if !formats.contains(&offer.format.as_str()) {
            formats.push(&offer.format);
        }
    }
    let span = |[low, high]: [u32; 2], what: &str| match (low == high, high) {
        (true, _) => format!("{low} {what}"),
        // What a system says that has no limit.
        (false, most) if most >= ENDLESS => format!("any number of {what}"),
        (false, _) => format!("{low} to {high} {what}"),
    };
    let rates = match rates {
        [_, most] if most >= ENDLESS => "any rate".into(),
        rates => span(rates, "Hz"),
    };
    let buffers = buffers.map_or(String::new(), |buffers| {
        format!(", buffers of {}", span(buffers, "frames"))
    });
    let channels = span(channels.map(u32::from), "channels");
    Some(format!(
        "{channels}, {rates}{buffers}; {}",
        formats.join(", ")
    ))
}
