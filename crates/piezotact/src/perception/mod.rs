//! How different two vibrations feel: two channels of receptors, resolved in time, and a decision.
//!
//! The rapidly adapting channel (Meissner's corpuscles) and the Pacinian one are excited by the displacement of the skin over their
//! thresholds and do not mask each other. Of the envelopes of both, and of the pitch over time, features are compared: level, pitch, rate
//! of pulses, duration, onset and release, accents and rhythm, slow course, modulation in bands, single dips and bumps. What the estimate
//! of a feature scatters by in a vibration of this length is taken off, so that two realisations of one texture are equal. The features' d′
//! are added in quadrature: 1 JND is 79 % of right judgements of two intervals, d′ = 1.16.
//!
//! Not in the model: adaptation to long stimuli, and forward masking across channels (no evidence for it).

mod course;
mod decision;
mod events;
mod excitation;
mod felt;
mod modulation;
mod parameters;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit};
use crate::feature::Receptor;
use crate::quantity::{Acceleration, Decibels, Hertz, Seconds};
use crate::series::Series;

pub use parameters::{MODULATION_BANDS_HZ, PARAMETERS, ParameterSource, Parameters};

/// The d′ of one JND: 79 % right of two intervals.
pub const D_PRIME_OF_JND: f64 = 1.16;
/// The lowest rate, Hz: the Pacinian channel feels up to half of it.
const LOWEST_RATE_HZ: f64 = 1000.0;
/// The shortest record, s.
const SHORTEST_S: f64 = 0.05;

/// Why two vibrations cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PerceptionError {
    /// Sampled too slowly.
    #[error(
        "cannot compare what is felt: expected {what} sampled at {} Hz or more, found {found_hz} Hz; record faster",
        LOWEST_RATE_HZ
    )]
    Rate {
        /// Which of the two.
        what: &'static str,
        found_hz: f64,
    },
    /// Too short.
    #[error(
        "cannot compare what is felt: expected {what} to last {} s or longer, found {:.4} s; add the silence around it", SHORTEST_S, .found.0
    )]
    TooShort {
        /// Which of the two.
        what: &'static str,
        found: Seconds,
    },
    /// A parameter without a source.
    #[error(
        "expected the parameter {name} of perception from {} to {}, found {found}: no source has another value",
        .range[0], .range[1]
    )]
    Parameter {
        /// Its name.
        name: &'static str,
        found: f64,
        range: [f64; 2],
    },
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Feature {
    /// The level of each channel, pauses left out.
    Level,
    /// The centre of the spectrum over both thresholds.
    Pitch,
    /// The inverse gap of pulses.
    PulseRate,
    /// The duration, of vibrations that begin and end by themselves.
    Duration,
    /// The time of the onset.
    Rise,
    /// The time of the release.
    Fall,
    /// Which events are stronger.
    Accents,
    /// The intervals of events.
    Rhythm,
    /// The slow course of the level.
    CourseOfLevel,
    /// The slow course of the pitch: sweeps, order.
    CourseOfPitch,
    /// The modulation of the level in a band.
    Modulation,
    /// A single dip or gap.
    Dip,
    /// A single strong event.
    Bump,
}

impl Feature {
    /// The name in plain words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Pitch => "pitch",
            Self::PulseRate => "pulse rate",
            Self::Duration => "duration",
            Self::Rise => "onset",
            Self::Fall => "release",
            Self::Accents => "accents",
            Self::Rhythm => "rhythm",
            Self::CourseOfLevel => "course of level",
            Self::CourseOfPitch => "course of pitch",
            Self::Modulation => "modulation",
            Self::Dip => "dip",
            Self::Bump => "single event",
        }
    }
}

/// A value and the interval in which it lies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Estimate {
    pub value: f64,
    /// At least, given the published ranges of the parameters and what estimates from this length scatter by.
    pub low: f64,
    /// At most.
    pub high: f64,
}

impl Estimate {
    fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self {
            value: of(self.value),
            low: of(self.low),
            high: of(self.high),
        }
    }
}

/// The part of one feature in a difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Contribution {
    pub feature: Feature,
    /// In which channel it is felt; absent where in both together.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub channel: Option<Receptor>,
    /// The centre of its band, of a modulation.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub modulation_hz: Option<Hertz>,
    /// How far the vibrations are apart in it alone.
    pub jnd: f64,
    /// Its part of the squared difference, 0–1.
    pub share: f64,
}

/// "modulation at 24 Hz (Pacini)".
impl fmt::Display for Contribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.feature.name())?;
        if let Some(band) = self.modulation_hz {
            write!(f, " at {band}")?;
        }
        match self.channel {
            Some(channel) => write!(f, " ({})", channel.name()),
            None => Ok(()),
        }
    }
}

/// The quantity that is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Judged {
    /// The difference of two vibrations.
    PerceivedDifference,
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("perceived difference")
    }
}

/// How different two vibrations feel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PerceivedDifference {
    /// In just-noticeable differences.
    pub jnd: Estimate,
    /// As d′.
    pub d_prime: Estimate,
    /// Right judgements of two intervals, %.
    pub percent_correct: Estimate,
    /// By feature, the largest first.
    pub contributions: Vec<Contribution>,
    /// The distance in pitch alone, JND: of pulses that of their rate.
    pub pitch_jnd: f64,
    /// How much stronger the test feels, as a change of level of a single tone: stronger channel and half the weaker.
    pub felt_level: Decibels,
    /// The level of reference and test over threshold, in the stronger channel, pauses left out.
    pub sensation_level: [Decibels; 2],
    /// How long they are felt.
    pub felt_for: [Seconds; 2],
    /// Whether the difference is below one JND.
    pub criterion: Criterion<Judged>,
}

/// The absolute value of `delta` less what `times` its `variance` explains.
fn left(delta: f64, variance: f64, times: f64) -> f64 {
    (delta * delta - times * variance).max(0.0).sqrt()
}

/// How different `test` feels from `reference`, accelerations of the skin in m/s²: in JND, d′ and % of right judgements, and by feature
/// and channel. The order of the two does not matter; they may differ in rate and length.
///
/// Formula: √(Σ dᵢ²) over the features; docs/decisions/perception.md has them.
///
/// Source: thresholds and two channels: S. J. Bolanowski et al. (1988), J. Acoust. Soc. Am. 84(5); JND: A. Israr, H. Z. Tan and
/// C. M. Reed (2006), J. Acoust. Soc. Am. 120; all others in [`PARAMETERS`].
///
/// # Errors
/// [`PerceptionError::Rate`] below 1000 Hz; [`PerceptionError::TooShort`] below 50 ms; [`PerceptionError::Parameter`] with a parameter
/// outside its published range.
pub fn perceived_difference(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    parameters: &Parameters,
) -> Result<PerceivedDifference, PerceptionError> {
    let parameters = parameters.checked()?;
    let a = felt("the reference", reference, parameters)?;
    let b = felt("the test", test, parameters)?;
    let decision = decision::decide(&a, &b, parameters);
    let jnd = decision.jnd;
    Ok(PerceivedDifference {
        jnd,
        d_prime: jnd.map(|jnd| D_PRIME_OF_JND * jnd),
        percent_correct: jnd.map(decision::percent_correct),
        contributions: decision.contributions,
        pitch_jnd: decision.pitch_jnd,
        felt_level: Decibels(decision.felt_level_db),
        sensation_level: decision.sensation_level_db.map(Decibels),
        felt_for: [a.length_s, b.length_s].map(Seconds),
        criterion: Criterion::new(
            Judged::PerceivedDifference,
            "JND",
            jnd.value,
            Some([jnd.low, jnd.high]),
            Limit::at_most(1.0),
        ),
    })
}

fn felt(
    what: &'static str,
    x: &Series<Acceleration>,
    p: &Parameters,
) -> Result<felt::Felt, PerceptionError> {
    let rate_hz = x.rate().hz();
    if rate_hz < LOWEST_RATE_HZ {
        return Err(PerceptionError::Rate {
            what,
            found_hz: rate_hz,
        });
    }
    if x.duration().0 < SHORTEST_S {
        return Err(PerceptionError::TooShort {
            what,
            found: x.duration(),
        });
    }
    Ok(felt::Felt::of(x.samples(), rate_hz, p))
}
