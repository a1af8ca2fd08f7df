//! What the EEG of one person is made of.

use piezotact_bench::random::Random;

use super::protocol::Task;
use crate::{Participant, TwinParameters};

/// The power of a source falls and rises within these shares.
const DESYNCHRONISATION: [f64; 2] = [-0.95, 0.5];

/// The sources of one person's EEG. All are properties of the person, not of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brain {
    /// The frequency of alpha, Hz.
    pub alpha_hz: f64,
    /// The rms of mu at its centre, at rest, V.
    pub mu_v: f64,
    /// The rms of the occipital alpha at Oz, V.
    pub occipital_v: f64,
    /// The rms of the background from 0.5 to 100 Hz, the median of channels, V.
    pub background_v: f64,
    /// The amplitude of N80 at CP3 in the control task, V.
    pub evoked_v: f64,
    /// What is added to the desynchronisation of every task, as a share of power.
    pub desynchronisation: f64,
}

impl Brain {
    /// The brain of participant `number` under `seed`; number 0 has every mean.
    pub(crate) fn of(parameters: &TwinParameters, number: u64, seed: u64) -> Self {
        let eeg = &parameters.eeg;
        let mut random = Random::stream(seed, number, "brain");
        let mut person = || match number {
            0 => 0.0,
            _ => random.person(),
        };
        Self {
            alpha_hz: eeg.alpha.frequency_hz + eeg.alpha.frequency_spread_hz * person(),
            mu_v: eeg.alpha.mu_v * (eeg.alpha.mu_spread * person()).exp(),
            occipital_v: eeg.alpha.occipital_v * (eeg.alpha.occipital_spread * person()).exp(),
            background_v: eeg.background.rms_v * (eeg.background.rms_spread * person()).exp(),
            evoked_v: eeg.evoked.amplitude_v * (eeg.evoked.amplitude_spread * person()).exp(),
            desynchronisation: eeg.desynchronisation.person_spread * person(),
        }
    }
}

/// The change of the power of mu and SMA of `participant` at the plateau, as a share: −0.5 is half the power.
pub(super) fn plateau(
    parameters: &TwinParameters,
    participant: &Participant,
    task: Task,
    surface: &str,
) -> f64 {
    let erd = &parameters.eeg.desynchronisation;
    let of_task = match task {
        Task::Natural => erd.natural,
        Task::Control => erd.control,
        Task::Imagery => erd.imagery,
    };
    let own = |spread: f64, stream: String| match participant.number {
        0 => 0.0,
        _ => spread * participant.random(&stream).person(),
    };
    let word = task.event_kind();
    let change = of_task
        + participant.brain.desynchronisation
        + own(erd.task_spread, format!("desynchronisation {word}"))
        + own(
            erd.surface_spread,
            format!("desynchronisation {word} {surface}"),
        );
    change.clamp(DESYNCHRONISATION[0], DESYNCHRONISATION[1])
}

/// The rms of the background of `channel`, 0.5 to 100 Hz, V.
pub(super) fn background_v(
    parameters: &TwinParameters,
    participant: &Participant,
    channel: &str,
) -> f64 {
    let spread = parameters.eeg.background.channel_spread;
    let own = match participant.number {
        0 => 0.0,
        _ => {
            spread
                * participant
                    .random(&format!("eeg level of {channel}"))
                    .person()
        }
    };
    participant.brain.background_v * own.exp()
}
