//! A session of one task: what is touched, how often, and how it is recorded.

use std::fmt;

use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::{Event, EventValue};
use piezotact_bench::random::Random;

use super::head::{HEOG, VEOG, all_channels, place};
use crate::TwinParameters;
use crate::error::{TwinError, wrong};

/// The kind of the events between trials: nothing is touched, and no movement is planned.
pub const REST: &str = "rest";
/// The surfaces of the study: rough, biomimetic, smooth (*thesis* 6.3).
const SURFACES: [&str; 3] = ["M8", "BIO", "M3"];
/// Channels × samples of one recording: 2 GiB.
const MOST_VALUES: f64 = 268_435_456.0;

/// What a participant does (*thesis* 6.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Strokes the surface.
    Natural,
    /// Feels the rendering of the surface on the device, with the finger at rest.
    Control,
    /// The same while imagining the movement.
    Imagery,
}

impl Task {
    /// All of them, in the order of the thesis.
    pub const ALL: [Self; 3] = [Self::Natural, Self::Control, Self::Imagery];

    /// The kind of the events of its trials: `natural`, `control` or `imagery`.
    #[must_use]
    pub fn event_kind(self) -> &'static str {
        match self {
            Self::Natural => "natural",
            Self::Control => "control",
            Self::Imagery => "imagery",
        }
    }
}

impl fmt::Display for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.event_kind())
    }
}

/// A session of one task. Surfaces follow each other in blocks of random order; before each trial the participant rests.
#[derive(Clone, Debug, PartialEq)]
pub struct EegProtocol {
    pub task: Task,
    /// The surfaces, by the names of the twin's samples.
    pub surfaces: Vec<String>,
    /// How often each is touched, 1 to 500.
    pub trials_per_surface: usize,
    /// The shortest rest before a trial, 2 to 30 s.
    pub rest_s: f64,
    /// The most that is added to a rest at random, 0 to 10 s.
    pub rest_jitter_s: f64,
    /// How long each trial lasts, 0.8 to 30 s.
    pub touch_s: f64,
    /// The rate, 256 to 8192 Hz.
    pub rate: SampleRate,
    /// The channels, of [`all_channels`].
    pub channels: Vec<String>,
}

impl EegProtocol {
    /// The session of `task` that the parameters state: three surfaces, all channels.
    ///
    /// # Errors
    /// [`TwinError::Value`] for a rate that is none; the ranges of the parameter file allow no such rate.
    pub fn usual(parameters: &TwinParameters, task: Task) -> Result<Self, TwinError> {
        let usual = &parameters.eeg.protocol;
        Ok(Self {
            task,
            surfaces: SURFACES.map(str::to_owned).to_vec(),
            trials_per_surface: usual.trials_per_surface.round() as usize,
            rest_s: usual.rest_s,
            rest_jitter_s: usual.rest_jitter_s,
            touch_s: usual.touch_s,
            rate: SampleRate::new(usual.rate_hz)
                .map_err(|error| wrong("rate", "256 to 8192 Hz", error, "state such a rate"))?,
            channels: all_channels(),
        })
    }

    /// Refuses what cannot be recorded.
    pub(super) fn check(&self, parameters: &TwinParameters) -> Result<(), TwinError> {
        let numbers = [
            ("rate", self.rate.hz(), [256.0, 8192.0], "Hz"),
            ("rest", self.rest_s, [2.0, 30.0], "s"),
            ("jitter of the rest", self.rest_jitter_s, [0.0, 10.0], "s"),
            ("trial", self.touch_s, [0.8, 30.0], "s"),
            (
                "trials of a surface",
                self.trials_per_surface as f64,
                [1.0, 500.0],
                "trials",
            ),
        ];
        for (what, found, [least, most], unit) in numbers {
            if !(least..=most).contains(&found) {
                return Err(wrong(
                    what,
                    format!("{least} to {most} {unit}"),
                    found,
                    "state such a number",
                ));
            }
        }
        once("surfaces", &self.surfaces)?;
        for surface in &self.surfaces {
            parameters.sample(surface)?;
        }
        once("channels", &self.channels)?;
        for channel in &self.channels {
            is_channel(channel)?;
        }
        self.check_size()
    }

    fn check_size(&self) -> Result<(), TwinError> {
        let trials = (self.surfaces.len() * self.trials_per_surface) as f64;
        let longest_s = trials * (self.rest_s + self.rest_jitter_s + self.touch_s) + self.rest_s;
        let values = longest_s * self.rate.hz() * self.channels.len() as f64;
        if values > MOST_VALUES {
            return Err(wrong(
                "channels times samples",
                format!("at most {MOST_VALUES}"),
                values.round(),
                "record fewer trials, fewer channels or at a lower rate",
            ));
        }
        Ok(())
    }
}

/// Refuses an electrode that the twin does not have.
pub(super) fn is_channel(name: &str) -> Result<(), TwinError> {
    if place(name).is_some() || [VEOG, HEOG].contains(&name) {
        return Ok(());
    }
    Err(wrong(
        "channel",
        format!("one of {}", all_channels().join(", ")),
        name,
        "name one of these",
    ))
}

/// Refuses a list with a name twice, or without one.
fn once(what: &'static str, names: &[String]) -> Result<(), TwinError> {
    let twice = (1..names.len()).find(|i| names[..*i].contains(&names[*i]));
    match (names, twice) {
        ([], _) => Err(wrong(what, "at least one", "none", "name one")),
        (_, Some(i)) => Err(wrong(
            what,
            "each once",
            format!("{} twice", names[i]),
            "leave one out",
        )),
        _ => Ok(()),
    }
}

/// One trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Trial {
    /// The index of its surface in the protocol.
    pub(super) surface: usize,
    /// The sample at which the touch begins.
    pub(super) onset: usize,
}

/// The trials of one recording, and how many samples it has.
pub(super) struct Schedule {
    pub(super) trials: Vec<Trial>,
    pub(super) length: usize,
}

impl Schedule {
    /// The schedule of `protocol` that `random` draws; it ends with a rest.
    pub(super) fn of(protocol: &EegProtocol, mut random: Random) -> Self {
        let mut surfaces: Vec<usize> = (0..protocol.surfaces.len()).collect();
        for i in (1..surfaces.len()).rev() {
            surfaces.swap(i, (random.uniform() * (i + 1) as f64) as usize);
        }
        let (mut trials, mut at_s) = (Vec::new(), 0.0);
        for surface in surfaces {
            for _ in 0..protocol.trials_per_surface {
                at_s += protocol.rest_s + protocol.rest_jitter_s * random.uniform();
                // Not before the rest is over.
                let onset = (at_s * protocol.rate.hz()).ceil() as usize;
                trials.push(Trial { surface, onset });
                at_s = protocol.rate.duration_of(onset).0 + protocol.touch_s;
            }
        }
        let length = protocol.rate.samples_in(Seconds(at_s + protocol.rest_s));
        Self { trials, length }
    }

    /// The rests, and the trials with their surfaces, in their order. A rest ends `planning_s` before the trial.
    pub(super) fn events(&self, protocol: &EegProtocol, planning_s: f64) -> Vec<Event> {
        let mut events = Vec::with_capacity(2 * self.trials.len());
        let mut rested_s = 0.0;
        for trial in &self.trials {
            let onset_s = protocol.rate.duration_of(trial.onset).0;
            events.push(Event {
                onset_s: Seconds(rested_s),
                duration_s: Seconds(onset_s - planning_s - rested_s),
                kind: REST.into(),
                value: None,
            });
            events.push(Event {
                onset_s: Seconds(onset_s),
                duration_s: Seconds(protocol.touch_s),
                kind: protocol.task.event_kind().into(),
                value: Some(EventValue::Text(protocol.surfaces[trial.surface].clone())),
            });
            rested_s = onset_s + protocol.touch_s;
        }
        events
    }
}
