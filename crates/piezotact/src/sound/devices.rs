//! The sound systems and sound devices of a computer, as a document.

use serde::Serialize;

use crate::document::Content;

/// A device as its host lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DeviceListing {
    /// The host.
    pub host: String,
    /// The id by which it is opened.
    pub id: String,
    /// Its name, for people.
    pub name: String,
    /// What its output offers; empty where it has none.
    pub outputs: Vec<Offer>,
    /// What its input offers; empty where it has none.
    pub inputs: Vec<Offer>,
}

/// Rates, channels and buffers that go together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Offer {
    /// The channels.
    pub channels: u16,
    /// The lowest and the highest rate, Hz.
    pub rates_hz: [u32; 2],
    /// The smallest and the largest buffer, frames, where it is known.
    pub buffer_frames: Option<[u32; 2]>,
    /// The format of its samples.
    pub format: String,
}

/// Whether a sound system answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Answers {
    /// It runs and has devices.
    Yes,
    /// It does not.
    No,
}

/// A sound system.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SoundHost {
    /// Its name.
    pub name: String,
    /// Whether it answers.
    pub answers: Answers,
}

/// The sound systems and sound devices of a computer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SoundDevices {
    /// The sound systems that the program was built with.
    pub hosts: Vec<SoundHost>,
    /// The devices of those that answer.
    pub devices: Vec<DeviceListing>,
}

impl Content for SoundDevices {
    const SCHEMA: &'static str = "sound_devices";
}
