//! By how much the power of a band was made to change, for tests of analyses.

use piezotact::quantity::Band;

use super::brain::{background_v, plateau};
use super::head::{between, gain, place};
use super::protocol::{EegProtocol, is_channel};
use super::session::between_s;
use super::spectrum::{alpha, background, power_in};
use crate::error::{TwinError, wrong};
use crate::{Participant, TwinParameters};

/// The midpoint rule of a mean over a window, steps.
const STEPS: usize = 4_000;

/// Where the power is meant, from the onset of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthWindows {
    pub band: Band,
    pub baseline_s: [f64; 2],
    pub window_s: [f64; 2],
}

/// The change of the expected power of a channel relative to rest, as shares: −0.5 is half the power.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerChange {
    /// The name of the channel.
    pub channel: String,
    /// At the plateau, relative to rest.
    pub plateau: f64,
    /// In the window, relative to the baseline: less, because the power changes within it.
    pub window: f64,
    /// The expected power of the band at rest, V².
    pub rest_v2: f64,
}

/// What was made of one surface in one task.
#[derive(Clone, Debug, PartialEq)]
pub struct EegTruth {
    /// The change of the power of the sources themselves at the plateau, as a share.
    pub source: f64,
    /// The change that each channel of the protocol shows with its background.
    pub channels: Vec<PowerChange>,
}

/// The change of the power of a band that the EEG of `participant` was made with while `surface` is touched: of the sources, and of each channel
/// of `protocol` on the scalp with its background and the occipital alpha. Blinks, movements of the eyes and the evoked response are not in it.
///
/// Formula: Σ g²·A²·c·r/(B + Σ g²·A²) with the powers of background and rhythms in the band, and r the mean of the logistic course over the window.
///
/// Source: the same parameters as [`record`](super::record), without a random number.
///
/// # Errors
/// [`TwinError`] for a protocol that cannot be, a surface that is not in it, an EOG channel, or a window that is not ascending.
pub fn truth(
    parameters: &TwinParameters,
    participant: &Participant,
    protocol: &EegProtocol,
    (surface, windows): (&str, &TruthWindows),
) -> Result<EegTruth, TwinError> {
    protocol.check(parameters)?;
    if !protocol.surfaces.iter().any(|known| known == surface) {
        return Err(wrong(
            "surface",
            format!("one of the protocol: {}", protocol.surfaces.join(", ")),
            surface,
            "name one of these",
        ));
    }
    let model = &parameters.eeg.desynchronisation;
    let plateau_s = [model.onset_s, protocol.touch_s + model.onset_s];
    let mean = |window_s: [f64; 2]| mean_course(window_s, plateau_s, model.onset_width_s);
    let (before, during) = (mean(windows.baseline_s)?, mean(windows.window_s)?);
    let source = plateau(parameters, participant, protocol.task, surface);
    let channels = protocol.channels.iter().map(|channel| {
        let (still_v2, changing_v2) = powers(parameters, participant, channel, windows.band)?;
        let rest_v2 = still_v2 + changing_v2;
        let at = |course: f64| still_v2 + changing_v2 * (1.0 + source * course);
        Ok(PowerChange {
            channel: channel.clone(),
            plateau: at(1.0) / rest_v2 - 1.0,
            window: at(during) / at(before) - 1.0,
            rest_v2,
        })
    });
    Ok(EegTruth {
        source,
        channels: channels.collect::<Result<_, TwinError>>()?,
    })
}

fn mean_course(
    [from_s, to_s]: [f64; 2],
    plateau_s: [f64; 2],
    width_s: f64,
) -> Result<f64, TwinError> {
    if !(from_s < to_s && (to_s - from_s).is_finite()) {
        return Err(wrong(
            "window",
            "a beginning before its end",
            format!("{from_s} to {to_s} s"),
            "state such a window",
        ));
    }
    let step_s = (to_s - from_s) / STEPS as f64;
    let at = |i: usize| between_s(from_s + (i as f64 + 0.5) * step_s, plateau_s, width_s);
    Ok((0..STEPS).map(at).sum::<f64>() / STEPS as f64)
}

/// The power of what no task changes, and of mu and SMA at rest, in `band` at `channel`, V².
fn powers(
    parameters: &TwinParameters,
    participant: &Participant,
    channel: &str,
    band: Band,
) -> Result<(f64, f64), TwinError> {
    is_channel(channel)?;
    let at = place(channel)
        .ok_or_else(|| wrong("channel", "one of the scalp", channel, "leave the EOG out"))?;
    let (eeg, brain) = (&parameters.eeg, &participant.brain);
    let of =
        |source, rms_v: f64| (rms_v * gain(at, source, eeg.alpha.source_m, eeg.head_m)).powi(2);
    let rhythm = power_in(band, alpha(brain.alpha_hz, eeg.alpha.bandwidth_hz));
    let level_v = background_v(parameters, participant, channel);
    let still = level_v * level_v * power_in(band, background(&eeg.background))
        + rhythm * of(between("Oz", "Oz"), brain.occipital_v);
    let changing = of(between("C3", "CP3"), brain.mu_v)
        + of(between("FCz", "Cz"), brain.mu_v * eeg.alpha.sma_share);
    Ok((still, rhythm * changing))
}
