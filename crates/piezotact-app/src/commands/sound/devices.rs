//! `piezotact devices`: the sound devices of this computer.

use clap::Args;
use piezotact::document::Content;
use piezotact_audio::{Answers, AudioIo as _, DeviceListing, HardwareIo, Offer, hosts};
use serde::Serialize;

use crate::failure::Outcome;
use crate::output::{print, print_document};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Lists the devices of this sound system alone, such as alsa, jack or pipewire.
    #[arg(long, value_name = "NAME")]
    host: Option<String>,
    /// Prints the list as JSON.
    #[arg(long)]
    json: bool,
}

/// The sound systems and devices of this computer.
#[derive(Debug, Serialize)]
struct Devices {
    hosts: Vec<Host>,
    devices: Vec<DeviceListing>,
}

/// A sound system.
#[derive(Debug, Serialize)]
struct Host {
    name: String,
    answers: Answers,
}

impl Content for Devices {
    const SCHEMA: &'static str = "sound-devices";
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let mut found = Devices {
        hosts: Vec::new(),
        devices: Vec::new(),
    };
    if let Some(host) = &args.host {
        // A host that is named is there, or the reason is said.
        found.devices = HardwareIo::new(host)?.devices()?;
        found.hosts.push(Host {
            name: host.clone(),
            answers: Answers::Yes,
        });
    } else {
        for (name, answers) in hosts() {
            if answers == Answers::Yes {
                found
                    .devices
                    .extend(HardwareIo::new(&name)?.devices().unwrap_or_default());
            }
            found.hosts.push(Host { name, answers });
        }
    }
    match args.json {
        true => print_document(&found),
        false => print(&text(&found)),
    }
}

fn text(found: &Devices) -> String {
    let host = |host: &Host| match host.answers {
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

/// Offers in words, those that differ in channels alone together.
fn shown(offers: &[Offer]) -> Vec<String> {
    let mut groups: Vec<(String, Vec<u16>)> = Vec::new();
    for offer in offers {
        let [low, high] = offer.rates_hz;
        let rates = if low == high {
            format!("{low} Hz")
        } else {
            format!("{low} to {high} Hz")
        };
        let buffers = match offer.buffer_frames {
            Some([least, most]) if least == most => format!(", buffers of {least} frames"),
            Some([least, most]) => format!(", buffers of {least} to {most} frames"),
            None => String::new(),
        };
        let what = format!("{rates}{buffers}, {}", offer.format);
        match groups.iter_mut().find(|(known, _)| *known == what) {
            Some((_, channels)) => channels.push(offer.channels),
            None => groups.push((what, vec![offer.channels])),
        }
    }
    let of = |(what, channels): (String, Vec<u16>)| {
        let (least, most) = (channels.iter().min(), channels.iter().max());
        match (least, most) {
            (Some(least), Some(most)) if least != most => {
                format!("{least} to {most} channels, {what}")
            }
            (Some(count), _) => format!("{count} channels, {what}"),
            _ => what,
        }
    };
    groups.into_iter().map(of).collect()
}
