//! Warnings about a verification.

use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use serde::{Deserialize, Serialize};

/// Warnings about a verification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum VerifyWarning {
    /// The clocks of playback and recording differ, and the measurement was compared after correcting for it.
    #[error(
        "the clocks of playback and recording differ by {ppm:+.1} ppm: compared after correcting for it; drive playback and recording from one \
            clock, or use short textures"
    )]
    ClockDrift { ppm: f64 },
    /// The recording lost samples, and was compared after correcting for it.
    #[error(
        "the recording lost {samples:.0} samples at {places} place(s): compared after correcting for it; check whether the recorder is overloaded; \
            record again"
    )]
    LostSamples { samples: f64, places: usize },
    /// The delay changes over time in a way that neither clock drift nor lost samples explain.
    #[error(
        "the delay of the measurement varies by {:.2} ms rms, which neither two clocks nor lost samples explain: check whether the rate of the \
            sound output changes, or the sensor moves",
        rms_s * 1e3
    )]
    DelayWanders { rms_s: f64 },
    /// Part of the target's lines is hidden by the sensor's noise and was not compared.
    #[error(
        "the sensor noise hides {:.0} % of the spectral lines of the target, with {:.2} % of its power: they are not compared; use a sensor with \
            less noise",
        line_share * 100.0,
        power_share * 100.0
    )]
    HiddenByNoise { line_share: f64, power_share: f64 },
    /// The measurement equals the target.
    #[error(
        "the measurement is proportional to the target: it is a copy and says nothing about a device; give the recording made while the drive was \
            played"
    )]
    CopyOfTarget,
    /// A measurement is compared with another texture than the one its drive was rendered from.
    #[error(
        "the drive was rendered from {rendered} and is compared with {compared}: check that they belong together"
    )]
    OtherTarget { rendered: String, compared: String },
    /// The measurement follows its target with the sign reversed.
    #[error(
        "the measurement follows its target with the sign reversed (correlation {correlation:.3}): check the polarity of the sensors and the \
            actuator"
    )]
    Inverted { correlation: f64 },
    /// Part of the band holds almost no target power: errors in dB are meaningless there and are left out.
    #[error("in {} of the band, the target has almost no power; this part was left out of the error: narrow the band", percent(*share))]
    NoTargetPower { share: f64 },
    /// Only part of the band is judged.
    #[error(
        "{} of {band} is evaluated: the drive was computed to reach only {}, and the vibration elsewhere is missing or wrong",
        percent(*share),
        list(judged)
    )]
    PartJudged {
        share: f64,
        judged: Vec<Band>,
        band: Band,
    },
    /// The measurement holds power on lines where the target has none.
    #[error(
        "where the target has no power, the measurement has {} of the power of the target: there is vibration that was not intended; check \
            distortion, mains and other sources of vibration",
        percent(*ratio)
    )]
    PowerAdded { ratio: f64 },
    /// The measurement ends before the target does.
    #[error(
        "target and measurement overlap for {compared_s:.2} s of the {target_s:.2} s of the target: start recording before the playback and stop \
            after its end; check that they belong together"
    )]
    Cut { compared_s: f64, target_s: f64 },
    /// The texture was intentionally rendered at another level, and is compared at that level.
    #[error(
        "the texture was intentionally rendered at {level_db:+.1} dB and is compared at this level: the presented level is not the recorded one"
    )]
    LevelChanged { level_db: f64 },
}
