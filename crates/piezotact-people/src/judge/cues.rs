//! The cues of a vibration, computed from the acceleration that was delivered.

use crate::judge::JudgeError;
use piezotact::quantity::{Acceleration, Band, Hertz};
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, welch};
use serde::{Deserialize, Serialize};

/// How many bands of equal width in octaves the spectrum has.
pub const CUE_BANDS: usize = 5;
/// A band with less of the power than this counts as having it.
const FLOOR_SHARE: f64 = 1e-3;
/// The bins of the spectrum are at most this share of the lower end of the band apart.
const RESOLUTION_SHARE: f64 = 0.25;

/// What a finger can tell of a vibration, and of a real surface that it touches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Cues {
    /// The band over which they hold.
    pub band: Band,
    /// The natural logarithm of the rms acceleration over the band in m/s².
    pub ln_rms: f64,
    /// The levels of the five bands, dB re the power of all: of the five octaves below 1 kHz where the band ends there.
    pub bands_db: [f64; CUE_BANDS],
    /// The natural logarithm of the power-weighted geometric mean frequency in Hz.
    pub ln_centroid: f64,
    /// What only a real surface tells; absent for a rendered vibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<OnSurface>,
}

/// What a real surface tells beside its vibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OnSurface {
    /// The distance of its elements, m: the period of a pattern, the mean grain of a random surface.
    pub period_m: f64,
    /// Whether they stand in a pattern.
    pub pattern: Pattern,
    /// The friction coefficient while sliding; absent where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// How the elements of a surface stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// At random: the isotropic samples.
    Random,
    /// In a regular pattern: the periodic samples.
    Regular,
}

impl Cues {
    /// The cues of `vibration` over `band`, or up to half the rate where that is lower.
    ///
    /// Welch's PSD (Hann, half overlap, bins at most a quarter of the band's lower end apart) gives the rms, the power in five
    /// bands of equal width in octaves below the upper end (one octave each, or less where the band has fewer than five), each
    /// over the whole power in dB and at least −30 dB, and the centroid. Source: docs/decisions/twin.md.
    ///
    /// # Errors
    /// [`JudgeError`] where nothing was delivered, the recording is too short, or its rate too low.
    pub fn of(vibration: &Series<Acceleration>, band: Band) -> Result<Self, JudgeError> {
        let rate = vibration.rate();
        let (low, high) = (band.low().0, band.high().0.min(rate.nyquist().0));
        let too_low = JudgeError::Rate {
            low_hz: low,
            expected_hz: 4.0 * low,
            found_hz: rate.hz(),
        };
        if high < 2.0 * low {
            return Err(too_low);
        }
        let band = Band::new(Hertz(low), Hertz(high)).map_err(|_too_low| too_low)?;
        let fewest = rate.hz() / (RESOLUTION_SHARE * low).max(f64::MIN_POSITIVE);
        let segment = (fewest.min(1e9) as usize).next_power_of_two().max(16);
        let psd = welch(vibration, &WelchConfig::hann(segment))?;
        let octaves = ((high / low).log2() / CUE_BANDS as f64).min(1.0);
        let (mut all, mut moment, mut bands) = (0.0, 0.0, [0.0; CUE_BANDS]);
        for (i, value) in psd.values.iter().enumerate() {
            let frequency_hz = i as f64 * psd.resolution_hz;
            if !band.contains(frequency_hz) || frequency_hz <= 0.0 {
                continue;
            }
            let power = value * psd.resolution_hz;
            all += power;
            moment += power * frequency_hz.ln();
            let below = ((high / frequency_hz).log2() / octaves) as usize;
            if let Some(place) = (CUE_BANDS - 1).checked_sub(below) {
                bands[place] += power;
            }
        }
        if !(all > 0.0 && all.is_finite()) {
            return Err(JudgeError::Silent { band });
        }
        Ok(Self {
            band,
            ln_rms: 0.5 * all.ln(),
            bands_db: bands.map(|power| 10.0 * (power / all).max(FLOOR_SHARE).log10()),
            ln_centroid: moment / all,
            surface: None,
        })
    }

    /// The same cues of a real surface.
    #[must_use]
    pub fn on(self, surface: OnSurface) -> Self {
        Self {
            surface: Some(surface),
            ..self
        }
    }

    /// Whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let of_surface = self.surface.is_none_or(|surface| {
            surface.period_m.is_finite() && surface.friction.is_none_or(f64::is_finite)
        });
        self.ln_rms.is_finite()
            && self.ln_centroid.is_finite()
            && self.bands_db.iter().all(|db| db.is_finite())
            && of_surface
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use piezotact::quantity::SampleRate;

    use super::*;

    fn band() -> Band {
        Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
    }

    fn of(rate_hz: f64, wave: impl Fn(f64) -> f64) -> Result<Cues, JudgeError> {
        let samples = (0..(2.0 * rate_hz) as usize).map(|i| wave(i as f64 / rate_hz));
        let rate = SampleRate::new(rate_hz).unwrap();
        Cues::of(&Series::new(samples.collect(), rate).unwrap(), band())
    }

    /// Two tones of 1 m/s² and 0.5 m/s² amplitude: power 0.5 and 0.125, in the second and fourth octave below 1 kHz.
    #[test]
    fn two_tones_have_the_cues_of_their_powers() {
        let cues = of(5000.0, |t| {
            (TAU * 90.0 * t).sin() + 0.5 * (TAU * 350.0 * t).sin()
        })
        .unwrap();
        assert!((cues.ln_rms - 0.5 * 0.625f64.ln()).abs() < 2e-3, "{cues:?}");
        let expected = [
            -30.0,
            10.0 * 0.8f64.log10(),
            -30.0,
            10.0 * 0.2f64.log10(),
            -30.0,
        ];
        for (found, expected) in cues.bands_db.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02, "{:?}", cues.bands_db);
        }
        let centroid = 0.8 * 90f64.ln() + 0.2 * 350f64.ln();
        // Leakage of the Hann window weighs a little to either side.
        assert!((cues.ln_centroid - centroid).abs() < 2e-3, "{cues:?}");
    }

    #[test]
    fn the_level_moves_the_level_alone() {
        let wave = |t: f64| (TAU * 60.0 * t).sin() + 0.7 * (TAU * 233.0 * t).sin();
        let (one, twice) = (
            of(5000.0, wave).unwrap(),
            of(5000.0, |t| 2.0 * wave(t)).unwrap(),
        );
        assert!((twice.ln_rms - one.ln_rms - 2f64.ln()).abs() < 1e-12);
        assert!((twice.ln_centroid - one.ln_centroid).abs() < 1e-12);
        assert_eq!(one.surface, None);
    }

    #[test]
    fn what_has_no_cues_is_refused() {
        assert!(matches!(
            of(5000.0, |_| 0.0),
            Err(JudgeError::Silent { .. })
        ));
        let refused = of(60.0, |t| t.sin()).unwrap_err().to_string();
        assert!(refused.contains("more than 80 Hz"), "{refused}");
        let short = Series::new(vec![0.0, 1.0, 0.0], SampleRate::new(5000.0).unwrap()).unwrap();
        assert!(matches!(
            Cues::of(&short, band()),
            Err(JudgeError::Spectrum(_))
        ));
    }

    /// At 800 Hz the band ends at 400 Hz, which is 4.3 octaves above 20 Hz: five bands of 0.86 octaves.
    #[test]
    fn a_low_rate_ends_the_band() {
        let cues = of(800.0, |t| (TAU * 30.0 * t).sin()).unwrap();
        assert!((cues.band.high().0 - 400.0).abs() < 1e-9);
        assert!(cues.bands_db[0] > -0.1, "{:?}", cues.bands_db);
    }
}
