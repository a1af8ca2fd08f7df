//! Whether two vibrations are distinguishable by touch, from what they excite: one distance, one just-noticeable difference (JND) and
//! one threshold for every command that asks.
//!
//! The distance is computed from sums that are linear in power ([`Excitation`]), so that a waveform's segments and a sample's
//! strokes are treated alike; what differs is only what the limits rest on.

mod contact;
mod evidence;
mod excitation;
mod warning;

use crate::warning::Warning;
use serde::{Deserialize, Serialize};

pub use contact::{ContactMap, ContactMapError};
pub(crate) use evidence::{Evidence, Uncertainty, Units, uncertainty};
pub use excitation::{Excitation, ExcitationPlan};
pub use warning::DiscriminationWarning;

use crate::criterion::Limit;
use crate::feature::Weighting;
use crate::quantity::{Band, Decibels, Hertz};

/// The mean of the absolute value of a normal deviate, √(2/π).
pub(crate) const MEAN_ABSOLUTE: f64 = 0.797_884_560_802_865_4;
/// dB of a power whose natural logarithm changes by 1.
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;

/// The perceptual model: detection threshold, just-noticeable differences and spread of excitation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Model {
    /// The band over which vibrations are compared.
    pub band: Band,
    /// One just-noticeable difference in level, dB: below it nothing is noticed.
    pub level_jnd: Decibels,
    /// The largest JND in level that was found, dB: above it a difference is noticed, between the two nothing is decided.
    pub level_jnd_high: Decibels,
    /// One just-noticeable difference in frequency, as a share of it (Weber fraction).
    pub frequency_jnd_share: f64,
    /// Whose detection threshold counts.
    pub weighting: Weighting,
    /// The ratio of skin to nail motion; if absent, they are assumed to be equal.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub contact: Option<ContactMap>,
}

impl Model {
    /// Over `band`: a JND of 1.58 dB (a fifth in amplitude) that reaches up to 2.5 dB, a fifth in frequency that reaches
    /// up as much, and the threshold of the most sensitive channel.
    ///
    /// Source: docs/decisions/verification.md.
    #[must_use]
    pub fn over(band: Band) -> Self {
        Self {
            band,
            level_jnd: Decibels(1.58),
            level_jnd_high: Decibels(2.5),
            frequency_jnd_share: 0.2,
            weighting: Weighting::DetectionThreshold,
            contact: None,
        }
    }

    /// The level of the skin's motion over the nail's at `frequency`, dB: 0 without a contact map.
    ///
    /// Source: [`ContactMap::ratio_db`].
    #[must_use]
    pub fn skin_over_nail(&self, frequency: Hertz) -> Decibels {
        let contact = self.contact.as_ref();
        Decibels(contact.map_or(0.0, |map| map.ratio_db(frequency)))
    }

    /// Where the JND come from.
    #[must_use]
    pub fn jnd_source(&self) -> &'static str {
        "JND in level 1.58 dB (a fifth in amplitude) to 2.5 dB and in frequency a fifth to a third: A. Israr, H. Z. Tan and C. M. Reed (2006), J. Acoust. Soc. Am. 120, found 1.65–3 dB and 0.13–0.38 at the index pad, 3.6 dB and 0.46–0.60 under a masker; 75 % of two-interval judgements are right at one JND"
    }

    /// How far what one frequency excites spreads, as a standard deviation of ln f: so far that a tone moved by one JND of
    /// frequency changes levels by one JND on average, 0.40 for 1.58 dB and a fifth.
    ///
    /// Formula: √(2/π)·(10/ln 10)·ln(1 + Weber fraction)/JND in dB.
    #[must_use]
    pub fn spreading(&self) -> f64 {
        MEAN_ABSOLUTE * DB_PER_NEPER * self.frequency_jnd_share.ln_1p() / self.level_jnd.0
    }

    /// The limit of a difference in JND: up to 1 it is below the just-noticeable difference, above the upper end of the
    /// published range it is noticed, and between them nothing is decided.
    #[must_use]
    pub fn limit(&self) -> Limit {
        Limit::AtMost {
            met: 1.0,
            not_met: (self.level_jnd_high.0 / self.level_jnd.0).max(1.0),
        }
    }

    /// From which difference on, JND, it is noticed.
    #[must_use]
    pub fn noticed_jnd(&self) -> f64 {
        self.limit().not_met_from()
    }

    /// The acceleration of the nail that is just detected at `frequency`, rms, m/s².
    ///
    /// Source: [`Weighting::threshold_m_s2`], over the ratio of the nail-to-skin map where there is one.
    #[must_use]
    pub fn threshold_m_s2(&self, frequency: Hertz) -> f64 {
        let skin_over_nail_db = self
            .contact
            .as_ref()
            .map_or(0.0, |map| map.ratio_db(frequency));
        self.weighting.threshold_m_s2(frequency) / 10f64.powf(skin_over_nail_db / 20.0)
    }

    /// One over the squared threshold, (m/s²)⁻².
    fn sensitivity(&self, frequency: Hertz) -> f64 {
        self.threshold_m_s2(frequency).powi(-2)
    }

    /// The warnings about the model itself.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        match &self.contact {
            None => vec![DiscriminationWarning::ThresholdsOfSkin.into()],
            Some(map) if !map.covers(self.band) => vec![
                DiscriminationWarning::ContactMapEnds {
                    measured_hz: map.measured_hz(),
                }
                .into(),
            ],
            Some(_) => Vec::new(),
        }
    }

    /// How far the vibrations with the sums `a` and `b` of [`Excitation::sums`] are apart, JND: the largest of the three parts.
    ///
    /// Source: [`crate::score::score`].
    #[must_use]
    pub fn distance_jnd(&self, a: &[f64], b: &[f64]) -> f64 {
        let (all_a, all_b) = (excitation::total(a), excitation::total(b));
        let bands = a.len().saturating_sub(2);
        let floor = Floor::of(a, b);
        let spectrum: f64 = (0..bands)
            .map(|i| {
                floor.share(a[i].max(b[i]))
                    * (b[i].max(floor.level) / a[i].max(floor.level)).ln().abs()
            })
            .sum();
        let level = (all_b.max(1.0) / all_a.max(1.0)).ln().abs();
        let of_level = DB_PER_NEPER * spectrum.max(level) / self.level_jnd.0;
        if all_a <= 1.0 || all_b <= 1.0 {
            return of_level;
        }
        let balance = excitation::log_centroid(b) - excitation::log_centroid(a);
        of_level.max(balance.abs() / self.frequency_jnd_share.ln_1p())
    }
}

/// The thresholds of excitation above which a band is perceptible.
struct Floor {
    /// Where the strongest band stands when the louder of the two is just at threshold: 1 or more where neither is felt.
    level: f64,
    /// Of the bands above it, the sum of the louder's.
    felt: f64,
}

impl Floor {
    fn of(a: &[f64], b: &[f64]) -> Self {
        let bands = a.len().saturating_sub(2);
        let louder = || (0..bands).map(|i| a[i].max(b[i]));
        let all = excitation::total(a).max(excitation::total(b));
        let level = louder().fold(0.0, f64::max) / all.max(f64::MIN_POSITIVE);
        Self {
            level,
            felt: louder().filter(|e| *e > level).sum(),
        }
    }

    /// The weight of a band, 0–1, in which the larger excitation of the two is `louder`.
    fn share(&self, louder: f64) -> f64 {
        if louder > self.level {
            louder / self.felt
        } else {
            0.0
        }
    }
}

/// A difference in JND and the limits within which it lies with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Difference {
    /// As measured.
    pub jnd: f64,
    /// At least; what estimates from this length scatter by is taken away.
    pub low_jnd: f64,
    /// At most.
    pub high_jnd: f64,
    /// The expected value due to scatter alone, without any difference.
    pub scatter_jnd: f64,
}

impl Difference {
    fn within(jnd: f64, ci_half_width_jnd: f64, error_jnd: f64) -> Self {
        Self {
            jnd,
            low_jnd: (jnd - ci_half_width_jnd).max(0.0),
            high_jnd: jnd + ci_half_width_jnd,
            scatter_jnd: MEAN_ABSOLUTE * error_jnd,
        }
    }

    fn larger(self, other: Self) -> Self {
        Self {
            jnd: self.jnd.max(other.jnd),
            low_jnd: self.low_jnd.max(other.low_jnd),
            high_jnd: self.high_jnd.max(other.high_jnd),
            scatter_jnd: self.scatter_jnd.max(other.scatter_jnd),
        }
    }
}

/// The perceptible difference in one band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BandDifference {
    /// B over A with what lies below the floor lifted to it, dB.
    pub(crate) felt_db: f64,
    /// How far that may be off, dB, 95 %.
    pub(crate) ci_half_width_db: f64,
    /// How much the band counts, 0–1.
    pub(crate) share: f64,
}

/// The three parts of a distance, and the bands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Differences {
    pub(crate) bands: Vec<BandDifference>,
    pub(crate) spectrum: Difference,
    pub(crate) level: Difference,
    pub(crate) balance: Difference,
    /// Whether the parts of the recordings differ by much more than their segments make likely.
    pub(crate) wanders: bool,
}

impl Differences {
    /// The distance: the largest of the three.
    pub(crate) fn largest(&self) -> Difference {
        self.spectrum.larger(self.level).larger(self.balance)
    }
}

/// How much larger than |x| the absolute value of a normal deviate around x with standard deviation 1 is on average.
fn folding(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    2.0 * density - x * statrs::function::erf::erfc(x / std::f64::consts::SQRT_2)
}

/// The differences of `a` and `b`, with limits from `scales`.
pub(crate) fn differences(
    a: &Excitation,
    b: &Excitation,
    model: &Model,
    scales: &[Evidence<'_>],
) -> Differences {
    let (a, b) = (a.sums.as_slice(), b.sums.as_slice());
    let (bands, sums) = (a.len().saturating_sub(2), a.len());
    let floor = Floor::of(a, b);
    let jnd_db = model.level_jnd.0;
    // dB of a band for each unit of what it excites; nothing of what is lifted to the floor.
    let slope = |x: &[f64], i: usize| {
        if x[i] > floor.level {
            DB_PER_NEPER / x[i]
        } else {
            0.0
        }
    };
    let sure = |at: &dyn Fn(&[f64], f64) -> Vec<f64>| -> Uncertainty {
        uncertainty(scales, [&at(a, -1.0), &at(b, 1.0)])
    };
    let mut spectrum_jnd = 0.0;
    let (mut scatter_jnd, mut folded_jnd) = (0.0, 0.0);
    let mut signs = vec![0.0; bands];
    let found: Vec<BandDifference> = (0..bands)
        .map(|i| {
            let felt_db = DB_PER_NEPER * (b[i].max(floor.level) / a[i].max(floor.level)).ln();
            let share = floor.share(a[i].max(b[i]));
            let sure = sure(&|x, sign| {
                let mut gradient = vec![0.0; sums];
                gradient[i] = sign * slope(x, i);
                gradient
            });
            spectrum_jnd += share * felt_db.abs() / jnd_db;
            signs[i] = share * felt_db.signum();
            if sure.error > 0.0 && sure.error.is_finite() {
                scatter_jnd += share * MEAN_ABSOLUTE * sure.error / jnd_db;
                let certain = (felt_db.abs() / sure.error - 1.0).max(0.0);
                folded_jnd += share * sure.error * folding(certain) / jnd_db;
            }
            BandDifference {
                felt_db,
                ci_half_width_db: sure.ci_half_width,
                share,
            }
        })
        .collect();
    // The sum of absolute values is a sum with these signs, and larger by what folding adds.
    let of_spectrum = sure(&|x, sign| {
        let mut gradient: Vec<f64> = (0..bands)
            .map(|i| sign * signs[i] * slope(x, i) / jnd_db)
            .collect();
        gradient.resize(sums, 0.0);
        gradient
    });
    let spectrum = Difference {
        jnd: spectrum_jnd,
        low_jnd: (spectrum_jnd - folded_jnd - of_spectrum.ci_half_width).max(0.0),
        high_jnd: spectrum_jnd + of_spectrum.ci_half_width,
        scatter_jnd,
    };

    let (all_a, all_b) = (excitation::total(a), excitation::total(b));
    let of_level = sure(&|x, sign| {
        let mut gradient = vec![0.0; sums];
        let all = excitation::total(x);
        gradient[bands] = if all > 1.0 {
            sign * DB_PER_NEPER / all / jnd_db
        } else {
            0.0
        };
        gradient
    });
    let level_jnd = DB_PER_NEPER * (all_b.max(1.0) / all_a.max(1.0)).ln().abs() / jnd_db;
    let level = Difference::within(level_jnd, of_level.ci_half_width, of_level.error);

    // An imperceptible vibration has no defined frequency.
    let balance = if all_a <= 1.0 || all_b <= 1.0 {
        Difference::within(0.0, 0.0, 0.0)
    } else {
        let jnd = model.frequency_jnd_share.ln_1p();
        let of_balance = sure(&|x, sign| {
            let (all, centroid) = (excitation::total(x), excitation::log_centroid(x));
            let mut gradient = vec![0.0; sums];
            gradient[bands] = -sign * centroid / all / jnd;
            gradient[bands + 1] = sign / all / jnd;
            gradient
        });
        let moved = (excitation::log_centroid(b) - excitation::log_centroid(a)).abs();
        Difference::within(moved / jnd, of_balance.ci_half_width, of_balance.error)
    };
    Differences {
        bands: found,
        spectrum,
        level,
        balance,
        wanders: of_spectrum.wanders || of_level.wanders,
    }
}
