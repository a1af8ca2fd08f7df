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
mod words;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::feature::Receptor;
use crate::quantity::{Acceleration, Decibels, Hertz, Seconds};
use crate::series::Series;

pub use decision::percent_correct;
pub(crate) use excitation::Ends;
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
    /// Whether it is one of the time course: neither level nor pitch.
    #[must_use]
    pub fn is_of_time(self) -> bool {
        !matches!(self, Self::Level | Self::Pitch)
    }

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

/// What was recorded of a vibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// All of it: it begins and ends by itself.
    Whole,
    /// A part of a longer one.
    Excerpt,
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

/// "modulation around 24 Hz (Pacini)": bands are wide, and 24 Hz is the centre of one.
impl fmt::Display for Contribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.feature.name())?;
        if let Some(band) = self.modulation_hz {
            write!(f, " around {band}")?;
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
    /// Whether they are whole or cut out of longer ones.
    pub records: [Record; 2],
    /// Whether there is no chance in either: they are stimuli, and no excerpts of a texture.
    #[serde(skip)]
    pub without_chance: bool,
    /// Whether the difference is below one JND.
    pub criterion: Criterion<Judged>,
    /// Beyond which what was measured with people it lies.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub limitations: Vec<Limitation>,
}

/// The absolute value of `delta` less what `times` its `variance` explains.
fn left(delta: f64, variance: f64, times: f64) -> f64 {
    (delta * delta - times * variance).max(0.0).sqrt()
}

/// Beyond which what was measured with people the result lies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Limitation {
    /// JND were measured at lower levels over threshold.
    Level { sensation_level: Decibels },
    /// Shorter than the integration of the Pacinian channel.
    Short { felt_for: Seconds },
    /// An excerpt in which slow modulation has fewer than five periods.
    ShortExcerpt {
        felt_for: Seconds,
        /// Modulation from here on is compared.
        slowest: Hertz,
    },
    /// What is felt before or after is too weak beside the rest to be compared.
    LeftOut { felt_for: Seconds },
    /// Both are whole, and their levels differ at a moment by more than the features show: events in another order, or one more.
    Moment { difference: Decibels },
}

impl Limitation {
    /// Whether it leaves open that the two are alike.
    fn hides_a_difference(&self) -> bool {
        matches!(self, Self::LeftOut { .. } | Self::Moment { .. })
    }
}

/// What is felt for less long beside a stronger vibration is its ringing, s.
const RINGING_S: f64 = 0.2;
/// Levels that differ by less than this at a moment are alike, dB.
const MOMENT_DB: f64 = 6.0;
/// The largest of many moments of noise differs by so many standard deviations.
const MOMENT_DEVIATIONS: f64 = 8.0;
/// The highest level over threshold at which JND were measured, dB.
const HIGHEST_MEASURED_DB: f64 = 48.0;

impl fmt::Display for Limitation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level { sensation_level } => write!(
                f,
                "{:.1} dB over threshold: just-noticeable differences were measured up to {} dB",
                sensation_level.0, HIGHEST_MEASURED_DB
            ),
            Self::Short { felt_for } => write!(
                f,
                "felt for {:.3} s, shorter than the Pacinian channel integrates",
                felt_for.0
            ),
            Self::ShortExcerpt { felt_for, slowest } => write!(
                f,
                "an excerpt of {:.2} s: modulation below {:.1} Hz is not compared, and level and pitch are those of this part",
                felt_for.0, slowest.0
            ),
            Self::LeftOut { felt_for } => write!(
                f,
                "for {:.2} s more, 25 dB or more below the strongest moment, something is felt that is not compared: compare it alone",
                felt_for.0
            ),
            Self::Moment { difference } => write!(
                f,
                "at one moment the levels differ by {:.1} dB, more than the features of the model show: another order or number of events",
                difference.0
            ),
        }
    }
}

/// Excerpts as long as this, 1 s but for their ends, hold enough of what varies slowly.
const LONG_EXCERPT_S: f64 = 0.95;

/// What the difference becomes when a parameter is at the ends of its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Sensitivity {
    /// The field of [`Parameters`].
    pub parameter: &'static str,
    /// The ends of its range.
    pub range: [f64; 2],
    /// The difference there, JND.
    pub jnd: [f64; 2],
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
///
/// ```
/// use piezotact::perception::{Parameters, perceived_difference};
/// use piezotact::quantity::{Acceleration, SampleRate};
/// let rate = SampleRate::new(8000.0).unwrap();
/// let of = |depth: f64| {
///     let at = |i: usize| {
///         let turn = std::f64::consts::TAU * i as f64 / 8000.0;
///         (1.0 + depth * (30.0 * turn).sin()) * (300.0 * turn).sin()
///     };
///     let samples = (0..8000).map(|i| at(i) / (1.0 + 0.5 * depth * depth).sqrt()).collect();
///     piezotact::Series::<Acceleration>::new(samples, rate).unwrap()
/// };
/// // Of equal energy, and told apart by everybody.
/// let felt = perceived_difference(&of(0.0), &of(1.0), &Parameters::published()).unwrap();
/// assert!(felt.jnd.low > 2.0);
/// ```
pub fn perceived_difference(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    parameters: &Parameters,
) -> Result<PerceivedDifference, PerceptionError> {
    perceived_through(reference, test, parameters, &|_| Decibels(0.0))
}

/// As [`perceived_difference`], of accelerations of the nail: `skin_over_nail` is the level of the skin's motion over the nail's by
/// frequency, dB.
///
/// Source: [`perceived_difference`].
///
/// # Errors
/// Those of [`perceived_difference`].
pub fn perceived_through(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    parameters: &Parameters,
    skin_over_nail: &dyn Fn(Hertz) -> Decibels,
) -> Result<PerceivedDifference, PerceptionError> {
    let of = |what, x| PerceivedVibration::of(what, x, parameters, skin_over_nail);
    let (a, b) = (of("the reference", reference)?, of("the test", test)?);
    Ok(a.difference(&b, parameters))
}

/// What is felt of one vibration, or of the excerpts of one texture in the mean.
#[derive(Clone, Debug)]
pub struct PerceivedVibration(felt::Felt);

impl PerceivedVibration {
    /// What is felt of `x`, named `what`, an acceleration of the nail in m/s²: `skin_over_nail` is the level of the skin's motion over the
    /// nail's by frequency, dB.
    ///
    /// Source: [`perceived_difference`].
    ///
    /// # Errors
    /// Those of [`perceived_difference`].
    pub fn of(
        what: &'static str,
        x: &Series<Acceleration>,
        parameters: &Parameters,
        skin_over_nail: &dyn Fn(Hertz) -> Decibels,
    ) -> Result<Self, PerceptionError> {
        let skin = |hz: f64| skin_over_nail(Hertz(hz)).amplitude_ratio();
        felt(what, x, parameters.checked()?, &skin, None).map(Self)
    }

    /// The mean of `excerpts` of one texture, such as strokes: their ends say nothing, what they differ by is the error of the mean, and a
    /// course counts that three or more have in common; `None` of nothing.
    ///
    /// Formula: means of powers, of ln f and of dB; the squared standard error is the larger of the mean of those of the excerpts and of the
    /// variance between them, over their number.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn mean(excerpts: &[&Self]) -> Option<Self> {
        let all: Vec<&felt::Felt> = excerpts.iter().map(|one| &one.0).collect();
        felt::Felt::mean(&all).map(Self)
    }

    /// As [`Self::of`], of one of two vibrations that follow each other and are cut at the same instants: their time is common, and their
    /// chance but for the share `independent_share` of the variance, 0–1.
    ///
    /// Formula: of two that are correlated by ρ, 1 − ρ².
    ///
    /// Source: house rule.
    ///
    /// # Errors
    /// Those of [`perceived_difference`].
    pub fn of_common(
        what: &'static str,
        x: &Series<Acceleration>,
        parameters: &Parameters,
        skin_over_nail: &dyn Fn(Hertz) -> Decibels,
        independent_share: f64,
    ) -> Result<Self, PerceptionError> {
        let skin = |hz: f64| skin_over_nail(Hertz(hz)).amplitude_ratio();
        let independent = Some(independent_share.clamp(0.0, 1.0));
        felt(what, x, parameters.checked()?, &skin, independent).map(Self)
    }

    /// How different `test` feels.
    ///
    /// Source: [`perceived_difference`].
    #[must_use]
    pub fn difference(&self, test: &Self, parameters: &Parameters) -> PerceivedDifference {
        PerceivedDifference::between(&self.0, &test.0, parameters)
    }
}

impl PerceivedDifference {
    /// The difference in the features that `counts` alone, JND; its interval is as wide, as a ratio, as that of all.
    ///
    /// Formula: √(Σ dᵢ²).
    ///
    /// Source: as [`perceived_difference`].
    #[must_use]
    pub fn in_features(&self, counts: impl Fn(Feature) -> bool) -> Estimate {
        let counted = self.contributions.iter().filter(|one| counts(one.feature));
        let value = counted.map(|one| one.jnd * one.jnd).sum::<f64>().sqrt();
        let all = self.jnd;
        let left_out = (all.value * all.value - value * value).max(0.0);
        Estimate {
            value,
            low: value * all.low / all.value.max(f64::MIN_POSITIVE),
            high: (all.high * all.high - left_out).max(value * value).sqrt(),
        }
    }

    /// Whether a limitation leaves open that the two are alike.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn may_hide_more(&self) -> bool {
        self.limitations.iter().any(Limitation::hides_a_difference)
    }

    /// The criterion `what` of the difference against `limit`: never met where a limitation may hide a difference.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn judged<W>(&self, what: W, limit: Limit) -> Criterion<W> {
        let jnd = self.jnd;
        let criterion = Criterion::new(what, "JND", jnd.value, Some([jnd.low, jnd.high]), limit);
        match criterion.outcome {
            Outcome::Met if self.may_hide_more() => Criterion {
                outcome: Outcome::NotDecided,
                ..criterion
            },
            _ => criterion,
        }
    }

    fn between(a: &felt::Felt, b: &felt::Felt, parameters: &Parameters) -> Self {
        let decision = decision::decide(a, b, parameters);
        let jnd = decision.jnd;
        let sensation_level = decision.sensation_level_db.map(Decibels);
        let felt_for = [a.length_s, b.length_s].map(Seconds);
        let loud = sensation_level
            .into_iter()
            .filter(|l| l.0 > HIGHEST_MEASURED_DB);
        let short = felt_for
            .into_iter()
            .filter(|s| s.0 < parameters.integration_s);
        let records = [a, b].map(|felt| match felt.whole {
            true => Record::Whole,
            false => Record::Excerpt,
        });
        let excerpts = felt_for.into_iter().zip(records);
        let excerpts = excerpts
            .filter(|(felt_for, record)| *record == Record::Excerpt && felt_for.0 < LONG_EXCERPT_S);
        let limitations = loud
            .map(|sensation_level| Limitation::Level { sensation_level })
            .chain(short.map(|felt_for| Limitation::Short { felt_for }))
            .chain(excerpts.map(|(felt_for, _)| Limitation::ShortExcerpt {
                felt_for,
                slowest: Hertz(modulation::MIN_PERIODS / felt_for.0),
            }));
        let left_out_s = a.left_out_s.max(b.left_out_s);
        let left_out = (left_out_s >= RINGING_S).then_some(Limitation::LeftOut {
            felt_for: Seconds(left_out_s),
        });
        // What moments of noise differ by is chance.
        let scatter_db = a.scatter_of_moments_db().hypot(b.scatter_of_moments_db());
        let least_db = MOMENT_DB.max(MOMENT_DEVIATIONS * scatter_db);
        let moment = decision::moment_apart_db(a, b).filter(|db| *db > least_db && jnd.value < 1.0);
        let moment = moment.map(|db| Limitation::Moment {
            difference: Decibels(db),
        });
        let limitations: Vec<Limitation> = limitations.chain(left_out).chain(moment).collect();
        let mut found = Self {
            jnd,
            d_prime: jnd.map(|jnd| D_PRIME_OF_JND * jnd),
            percent_correct: jnd.map(percent_correct),
            contributions: decision.contributions,
            pitch_jnd: decision.pitch_jnd,
            felt_level: Decibels(decision.felt_level_db),
            sensation_level,
            felt_for,
            records,
            without_chance: a.is_without_chance() && b.is_without_chance(),
            criterion: Criterion::new(
                Judged::PerceivedDifference,
                "JND",
                jnd.value,
                Some([jnd.low, jnd.high]),
                Limit::at_most(1.0),
            ),
            limitations,
        };
        let of_one = found.judged(Judged::PerceivedDifference, Limit::at_most(1.0));
        found.criterion = of_one;
        found
    }
}

/// What the difference that `of` finds becomes, JND, when each of `parameters` in turn is at the ends of its range, the one that changes
/// it most first.
///
/// Source: [`PARAMETERS`].
///
/// # Errors
/// Those of `of`.
pub fn sensitivity<E>(
    parameters: &Parameters,
    of: impl Fn(&Parameters) -> Result<PerceivedDifference, E>,
) -> Result<Vec<Sensitivity>, E> {
    let mut found = Vec::with_capacity(PARAMETERS.len());
    for (place, one) in PARAMETERS.iter().enumerate() {
        let [low, high] = one
            .range
            .map(|value| of(&parameters.with(place, value)).map(|found| found.jnd.value));
        found.push(Sensitivity {
            parameter: one.name,
            range: one.range,
            jnd: [low?, high?],
        });
    }
    found.sort_by(|x, y| {
        let change = |one: &Sensitivity| (one.jnd[1] - one.jnd[0]).abs();
        change(y).total_cmp(&change(x))
    });
    Ok(found)
}

fn felt(
    what: &'static str,
    x: &Series<Acceleration>,
    p: &Parameters,
    skin: &dyn Fn(f64) -> f64,
    independent: Option<f64>,
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
    Ok(felt::Felt::of(x.samples(), rate_hz, p, skin, independent))
}
