//! One person's sense of touch, as numbers.

use crate::judge::JudgeError;
use serde::{Deserialize, Serialize};

use super::answer::Moment;

/// A person's sense of touch. Noises are standard deviations of one look; a look is one stroke or one playback of the texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// The noise of the level of a real surface in one look, in the natural logarithm of rms.
    pub level_noise_real: f64,
    /// The same of a rendered texture.
    pub level_noise_rendered: f64,
    /// The noise of the level of one band in one look, dB.
    pub band_noise_db: f64,
    /// The noise of the centroid in one look, in the natural logarithm of Hz.
    pub centroid_noise: f64,
    /// The standard deviation of the person's lasting bias of each texture's level, in the natural logarithm of rms.
    pub texture_bias: f64,
    /// Two levels that are this far apart count as one step apart, in the natural logarithm of rms.
    pub level_step: f64,
    /// Two spectra whose bands are this far apart count as one step apart, dB.
    pub band_step_db: f64,
    /// The weight of a squared step in spectrum, where a squared step in level has 1, among random surfaces.
    pub spectrum_weight: f64,
    /// How much larger that weight is among regular patterns.
    pub regular_weight_ratio: f64,
    /// What a period of e times 100 µm adds to the roughness of a real surface, in the natural logarithm of rms.
    pub spatial_weight: f64,
    /// Real surfaces with a friction coefficient above this are placed last: smooth and sticky.
    pub smooth_friction: f64,
    /// From how many steps on two textures are called different.
    pub different_steps: f64,
    /// The share of judgements without attention: a choice is then a guess, an order has two neighbours exchanged.
    pub lapse_share: f64,
    /// How much the noise is larger for a texture that is remembered and not touched.
    pub memory_noise_ratio: f64,
    /// How much larger the noise of the first judgement of a session is, as a share.
    pub learning_share: f64,
    /// After how many judgements that has fallen to 1/e.
    pub learning_trials: f64,
    /// How much the noise grows with every hundred judgements of a session, as a share.
    pub fatigue_share: f64,
    /// The natural logarithms of the rms in m/s² that have the lowest and the highest value of a scale.
    pub scale_ends: [f64; 2],
}

impl Touch {
    /// The mean person of the twin, whose texture biases have a standard deviation of 0.04.
    ///
    /// A look has a noise of 0.18 in ln rms (19 %, Israr, Tan and Reed 2006: 1.5 dB), which nine looks reduce to 0.06; a rendered
    /// texture has 0.07 after nine looks. The noise of a band is that of a JND of 2.5 dB between two looks. The centroid has the
    /// Weber fraction of frequency, 0.2. Weights: spectrum 1, among regular patterns 4; spatial 0.15. Learning, fatigue, memory and
    /// the criterion of *different* are assumptions. Source: docs/decisions/twin.md.
    #[must_use]
    pub fn mean_person() -> Self {
        Self {
            level_noise_real: 0.18,
            level_noise_rendered: 0.21,
            band_noise_db: 2.5 / std::f64::consts::SQRT_2,
            centroid_noise: 0.18,
            texture_bias: 0.04,
            level_step: 0.06 * std::f64::consts::SQRT_2,
            band_step_db: 2.5,
            spectrum_weight: 1.0,
            regular_weight_ratio: 4.0,
            spatial_weight: 0.15,
            smooth_friction: 1.2,
            different_steps: 2.0,
            lapse_share: 0.015,
            memory_noise_ratio: 1.5,
            learning_share: 0.2,
            learning_trials: 10.0,
            fatigue_share: 0.1,
            scale_ends: [-2.0, 1.0],
        }
    }

    /// Itself, where every parameter is within its range.
    ///
    /// # Errors
    /// [`JudgeError::Touch`] with the first that is not.
    pub fn checked(self) -> Result<Self, JudgeError> {
        for (what, found, low, high) in [
            ("level_noise_real", self.level_noise_real, 1e-4, 10.0),
            (
                "level_noise_rendered",
                self.level_noise_rendered,
                1e-4,
                10.0,
            ),
            ("band_noise_db", self.band_noise_db, 1e-3, 100.0),
            ("centroid_noise", self.centroid_noise, 1e-4, 10.0),
            ("texture_bias", self.texture_bias, 0.0, 2.0),
            ("level_step", self.level_step, 1e-4, 10.0),
            ("band_step_db", self.band_step_db, 1e-3, 100.0),
            ("spectrum_weight", self.spectrum_weight, 0.0, 1e3),
            ("regular_weight_ratio", self.regular_weight_ratio, 0.0, 1e3),
            ("spatial_weight", self.spatial_weight, -2.0, 2.0),
            ("smooth_friction", self.smooth_friction, 0.0, 1e3),
            ("different_steps", self.different_steps, 0.0, 1e3),
            ("lapse_share", self.lapse_share, 0.0, 1.0),
            ("memory_noise_ratio", self.memory_noise_ratio, 1e-2, 100.0),
            ("learning_share", self.learning_share, 0.0, 10.0),
            ("learning_trials", self.learning_trials, 0.1, 1e4),
            ("fatigue_share", self.fatigue_share, 0.0, 10.0),
            ("scale_ends[0]", self.scale_ends[0], -20.0, 20.0),
            ("scale_ends[1]", self.scale_ends[1], -20.0, 20.0),
        ] {
            if !(low..=high).contains(&found) {
                return Err(JudgeError::Touch {
                    what,
                    expected: format!("{low} to {high}"),
                    found: found.to_string(),
                });
            }
        }
        let [low, high] = self.scale_ends;
        if low >= high {
            return Err(JudgeError::Touch {
                what: "scale_ends",
                expected: "the lower end first".to_owned(),
                found: format!("{low} and {high}"),
            });
        }
        Ok(self)
    }

    /// The same with every noise of a look times `ratio`.
    #[must_use]
    pub fn with_noise(self, ratio: f64) -> Self {
        Self {
            level_noise_real: self.level_noise_real * ratio,
            level_noise_rendered: self.level_noise_rendered * ratio,
            band_noise_db: self.band_noise_db * ratio,
            centroid_noise: self.centroid_noise * ratio,
            ..self
        }
    }

    /// The noise at `moment` over that of a rested person who knows the task: 1 + learning·e^(−n/trials) + fatigue·n/100 for the
    /// judgement n from 0.
    #[must_use]
    pub fn noise_at(&self, moment: Moment) -> f64 {
        let n = f64::from(moment.judgement);
        let learning = self.learning_share * (-n / self.learning_trials).exp();
        1.0 + learning + self.fatigue_share * n / 100.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_out_of_range_is_refused() {
        let says = |touch: Touch| touch.checked().unwrap_err().to_string();
        let wrong = Touch {
            lapse_share: 1.5,
            ..Touch::mean_person()
        };
        assert_eq!(
            says(wrong),
            "lapse_share of a sense of touch: expected 0 to 1, found 1.5; correct it"
        );
        let nan = Touch {
            level_step: f64::NAN,
            ..Touch::mean_person()
        };
        assert!(says(nan).contains("level_step"), "{}", says(nan));
    }

    #[test]
    fn noise_falls_by_learning_and_grows_by_fatigue() {
        let touch = Touch::mean_person();
        let at = |judgement| touch.noise_at(Moment { judgement });
        assert!((at(0) - 1.2).abs() < 1e-12);
        assert!(at(30) < at(0) && at(30) < at(400));
        // 1 + 0.2/e + 0.1·10/100
        assert!((at(10) - 1.083_575_888).abs() < 1e-6);
    }
}
