//! The parameters of the model, each with its published range and its source.

use super::{Feature, PerceptionError};
use serde::{Deserialize, Serialize};

/// The centres of the modulation bands, Hz.
pub const MODULATION_BANDS_HZ: [f64; 7] = [1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 90.0];
/// The modulation of a level that is just felt in each band, dB rms: low-pass in noise and best at 20–40 Hz on tones (J. M. Weisenberger
/// 1986; the values are chosen so that a depth of 0.09–0.14 is felt).
pub(super) const MODULATION_DB: [f64; 7] = [0.60, 0.60, 0.45, 0.35, 0.28, 0.35, 0.60];

/// Where a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterSource {
    /// The field of [`Parameters`].
    pub name: &'static str,
    /// The value that is used.
    pub value: f64,
    /// The published range, or that within which the model was tried.
    pub range: [f64; 2],
    /// Empty for a pure number.
    pub unit: &'static str,
    /// The publication; "chosen" where there is none.
    pub source: &'static str,
}

macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident = $value:literal, $low:literal ..= $high:literal, $unit:literal, $source:literal;)*) => {
        /// The parameters of the model; [`Self::published`] has the values of [`PARAMETERS`].
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
        pub struct Parameters {
            $($(#[$doc])* pub $name: f64,)*
        }

        /// All parameters with range and source.
        pub const PARAMETERS: &[ParameterSource] = &[$(ParameterSource {
            name: stringify!($name), value: $value, range: [$low, $high], unit: $unit, source: $source,
        },)*];

        impl Parameters {
            /// The values of [`PARAMETERS`].
            #[must_use]
            pub fn published() -> Self {
                Self { $($name: $value,)* }
            }

            fn values(&self) -> Vec<f64> {
                vec![$(self.$name,)*]
            }

            fn values_mut(&mut self) -> Vec<&mut f64> {
                vec![$(&mut self.$name,)*]
            }
        }
    };
}

parameters! {
    /// How much higher all thresholds are than those of `Weighting`, dB: contacts, sites and forces differ by that much.
    threshold_offset_db = 0.0, -35.0..=35.0, "dB", "Bolanowski 1988; Morioka & Griffin 2006; Papetti 2017: 15-35 dB apart at 250 Hz";
    /// Below this frequency acceleration is felt as motion of the hand, Hz.
    low_hz = 10.0, 5.0..=20.0, "Hz", "chosen: below the tables of the model";
    /// Where the threshold of the rapidly adapting channel rises by another 12 dB per octave, Hz.
    rapid_knee_hz = 100.0, 60.0..=150.0, "Hz", "Bolanowski 1988 to 100 Hz; above it chosen";
    /// Above this frequency receptors follow the rectified motion, not the motion, Hz.
    demodulation_hz = 500.0, 400.0..=1000.0, "Hz", "Lamoré 1986: carriers of 1-2 kHz";
    /// The time constant of both poles of the rapidly adapting channel's envelope, s.
    rapid_envelope_s = 0.008, 0.005..=0.010, "s", "Saal 2017 (TouchSim): 3.4-9 ms";
    /// The same of the Pacinian channel, s.
    pacinian_envelope_s = 0.004, 0.001..=0.005, "s", "Saal 2017 (TouchSim): 0.9-1.8 ms; chosen so that 125 Hz is hardly followed";
    /// The decay of forward masking in the rapidly adapting channel, s.
    rapid_tail_s = 0.100, 0.050..=0.120, "s", "Makous 1996";
    /// The same in the Pacinian channel, s.
    pacinian_tail_s = 0.040, 0.020..=0.040, "s", "Makous 1996";
    /// Forward masking at the end of the masker, as a share of its level in dB.
    tail_jump = 0.6, 0.4..=0.8, "", "chosen";
    /// What is left of it after the decay, as a share of the level in dB.
    tail_residue = 0.2, 0.1..=0.3, "", "Makous 1996: 1 dB for 5 dB";
    /// The decay of that, s.
    residue_s = 1.0, 0.5..=3.0, "s", "chosen";
    /// The time constant of the integration of power in the Pacinian channel, s.
    integration_s = 0.200, 0.1..=0.4, "s", "Zwislocki; Gescheider 1994";
    /// The exponent of felt intensity over amplitude.
    growth = 0.89, 0.7..=1.0, "", "Verrillo 1970";
    /// The JND of level at 20 dB SL, dB.
    level_jnd_20_db = 2.3, 1.8..=3.0, "dB", "Israr 2006";
    /// The JND of level at 35 dB SL, dB.
    level_jnd_35_db = 2.15, 1.65..=2.7, "dB", "Israr 2006";
    /// The JND of frequency at 80 Hz and 20 dB SL, as a share of it.
    pitch_jnd_20 = 0.25, 0.13..=0.38, "", "Israr 2006";
    /// Its exponent over frequency at 20 dB SL.
    pitch_slope = -0.30, -0.5..=0.0, "", "Israr 2006: falls from 0.38 to 0.13";
    /// The JND of frequency at 35 dB SL, as a share of it.
    pitch_jnd_35 = 0.20, 0.14..=0.28, "", "Israr 2006";
    /// The standard deviation of ln f at which the JND of frequency is √2 times as large.
    pitch_spread = 1.0, 0.7..=1.5, "", "Israr 2006: 0.46-0.60 with two maskers";
    /// The JND of the rate of pulses, as a share of it.
    rate_jnd = 0.20, 0.03..=0.50, "", "Franzén & Nordmark 1975 and literature";
    /// The JND of a duration is this, s,
    duration_s = 0.011, 0.006..=0.015, "s", "Cao: decays of 10.8 and 50 ms";
    /// and this share of it.
    duration_share = 0.125, 0.10..=0.16, "", "Francisco 2015; Jones 2009";
    /// The JND of the time to −6 dB of an onset or a release, s.
    rise_s = 0.017, 0.010..=0.030, "s", "Balandra 2019: ramps of 54 and 57 ms";
    /// and its share that is added for long ones.
    rise_share = 0.5, 0.2..=1.0, "", "chosen";
    /// The factor on the modulation that is just felt.
    modulation_scale = 1.0, 0.7..=1.4, "", "Weisenberger 1986";
    /// The JND of the mean square of a modulation, as a share of the sum of both.
    modulation_share = 0.20, 0.1..=0.3, "", "chosen";
    /// The JND of frequency within a vibration, as a share of it.
    course_pitch = 0.30, 0.2..=0.5, "", "Summers 1994, 1997: octaves in 80-320 ms";
    /// The length at which a course is compared with 1/√2 of the precision of a long one, s.
    course_whole_s = 0.30, 0.1..=0.5, "s", "chosen";
    /// The time constant of the two poles that blur a course, s.
    course_blur_s = 0.040, 0.020..=0.060, "s", "order: 34 ms (literature)";
    /// The exponent of the mean over a course: how much its strongest difference counts.
    course_power = 8.0, 4.0..=16.0, "", "chosen";
    /// The depth of a single dip or bump that is just felt, dB.
    dip_db = 6.5, 4.0..=10.0, "dB", "Van Doren 1990: gap of 10 ms";
    /// How much harder a brief event is at the onset of a vibration.
    onset_masking = 0.9, 0.5..=1.5, "", "Gescheider 1989: 4 dB from 100 to 650 ms";
    /// The decay of that, s.
    onset_s = 0.25, 0.1..=0.5, "s", "Gescheider 1989";
}

impl Parameters {
    /// The same with the parameter of that place in [`PARAMETERS`] at `value`.
    pub(super) fn with(mut self, place: usize, value: f64) -> Self {
        if let Some(one) = self.values_mut().into_iter().nth(place) {
            *one = value;
        }
        self
    }

    /// Itself, where every value lies within its range.
    ///
    /// # Errors
    /// [`PerceptionError::Parameter`] with the first that does not.
    pub fn checked(&self) -> Result<&Self, PerceptionError> {
        let outside = |(value, source): &(f64, &ParameterSource)| {
            !(source.range[0]..=source.range[1]).contains(value)
        };
        match self.values().into_iter().zip(PARAMETERS).find(outside) {
            Some((found, source)) => Err(PerceptionError::Parameter {
                name: source.name,
                found,
                range: source.range,
            }),
            None => Ok(self),
        }
    }
}

/// By how much, as a ratio, the JND of a feature may be smaller or larger: the root of the highest over the lowest that was published.
/// Levels: 1.65–3.0 dB; durations: 10–16 %, and what clicks add; pitch: 0.13–0.38; modulation and what is in order: 0.7–1.4 and more.
pub(super) fn range_ratio(feature: Feature) -> f64 {
    match feature {
        Feature::Duration => 1.3,
        Feature::Level => 1.35,
        Feature::Accents | Feature::Rhythm | Feature::CourseOfLevel => 1.4,
        Feature::Modulation => 1.5,
        Feature::Pitch | Feature::CourseOfPitch | Feature::Dip | Feature::Bump => 1.6,
        Feature::PulseRate | Feature::Rise | Feature::Fall => 1.8,
    }
}

/// How many squared standard errors are taken off a squared difference, so that two realisations of one noise are equal; found by
/// simulation (half a JND in 99 % of pairs).
pub(super) mod taken_off {
    /// Level and pitch.
    pub(crate) const STEADY: f64 = 5.0;
    pub(crate) const MODULATION: f64 = 9.0;
    pub(crate) const COURSE: f64 = 4.0;
    pub(crate) const COURSE_OF_PITCH: f64 = 10.0;
    pub(crate) const ENDS: f64 = 25.0;
    pub(crate) const ACCENTS: f64 = 5.0;
    pub(crate) const INTERVALS: f64 = 2.0;
}
