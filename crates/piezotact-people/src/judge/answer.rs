//! What a person answers, given the noise.

use piezotact::quantity::Band;
use piezotact::spectrum::EstimateError;
use serde::{Deserialize, Serialize};

use super::Judge;
use super::cues::{CUE_BANDS, Cues, Pattern};
use super::normal::cdf;
use super::touch::Touch;

/// The coordinates in which textures are compared: the level and the bands, in steps times the root of their weight.
pub(super) const AXES: usize = 1 + CUE_BANDS;
/// The negative logarithms of the centroids, Hz, at the ends of a scale, for who goes by the spectrum alone.
const SPECTRUM_ENDS: [f64; 2] = [-6.214_608_098_422_191, -3.912_023_005_428_146];

/// A rendered vibration of this rms is as strong as what is felt of none, m/s²: thresholds of 0.021 to 0.15 m/s² between 20 and 315 Hz (Morioka
/// and Griffin 2006, J. Sound Vib. 295:633).
const DETECTED_M_S2: f64 = 0.03;

/// A person who judges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// Which cues count.
    pub judge: Judge,
    /// How well they are sensed.
    pub touch: Touch,
}

/// When something is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Moment {
    /// How many judgements of the session came before.
    pub judgement: u32,
}

/// A texture as it is touched in one judgement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look<'a> {
    pub cues: &'a Cues,
    /// How many looks: strokes or playbacks, replays included; the noise falls with their root. At least 1 counts.
    pub looks: f64,
    /// The person's lasting bias of this texture's level, in the natural logarithm of rms; 0 where it is not known.
    pub bias: f64,
}

impl<'a> Look<'a> {
    /// The looks of a judgement at leisure.
    pub const AT_LEISURE: f64 = 9.0;

    /// `cues` at leisure, nine looks, without a bias.
    #[must_use]
    pub fn of(cues: &'a Cues) -> Self {
        Self {
            cues,
            looks: Self::AT_LEISURE,
            bias: 0.0,
        }
    }
}

/// Whether the alternatives can be touched while the answer is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Recall {
    /// They are touched.
    Touched,
    /// They are remembered.
    Remembered,
}

/// Whether two textures are called the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Sameness {
    /// The same.
    Same,
    /// Different.
    Different,
}

/// Why there is no answer, or no judge that answers show.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JudgeError {
    /// Nothing to choose from.
    #[error("expected at least {expected} textures to judge, found {found}; look at the trial")]
    TooFew {
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Cues over different bands.
    #[error(
        "expected cues over one band, found {one_hz:?} Hz and {other_hz:?} Hz; compute all cues over the same band"
    )]
    Bands {
        /// Of one texture, Hz.
        one_hz: [f64; 2],
        other_hz: [f64; 2],
    },
    /// A cue that is no number.
    #[error(
        "expected finite cues and biases and positive looks of texture {place}, found {found}; compute them again from what was delivered"
    )]
    NotFinite {
        /// Its place in the trial, from 0.
        place: usize,
        found: String,
    },
    /// An order that does not name each texture once.
    #[error(
        "the order {found:?} does not name each of {textures} textures once: correct the answer"
    )]
    Order {
        /// How many there are.
        textures: usize,
        found: Vec<usize>,
    },
    /// Nothing was delivered in the band.
    #[error("nothing was delivered within {low:.0}–{high:.0} Hz: look at this trial",
        low = band.low().0, high = band.high().0
    )]
    Silent { band: Band },
    /// The acceleration has no estimate of its spectrum.
    #[error("the spectrum of what was delivered cannot be estimated: {0}")]
    Spectrum(#[from] EstimateError),
    /// The rate is too low for the band.
    #[error(
        "a rate of {found_hz:.0} Hz is too low for five bands from {low_hz:.0} Hz on: record with more than {expected_hz:.0} Hz"
    )]
    Rate {
        /// The lower end of the band, Hz.
        low_hz: f64,
        /// The least rate, Hz.
        expected_hz: f64,
        /// That of the recording, Hz.
        found_hz: f64,
    },
    /// A value outside its range.
    #[error("{what} of a sense of touch: expected {expected}, found {found}; correct it")]
    Touch {
        what: &'static str,
        expected: String,
        found: String,
    },
    /// No answers.
    #[error("there are no answers with what was delivered: give those of a campaign")]
    NoAnswers,
    /// An answer that is none of the alternatives, or bounds of parameters that do not ascend.
    #[error("internal error: {why}; please report it")]
    Answers { why: String },
}

/// Refuses textures that cannot be judged together.
pub(super) fn together(textures: &[Look<'_>], fewest: usize) -> Result<(), JudgeError> {
    if textures.len() < fewest {
        return Err(JudgeError::TooFew {
            expected: fewest,
            found: textures.len(),
        });
    }
    for (place, look) in textures.iter().enumerate() {
        let numbers = look.looks.is_finite() && look.looks > 0.0 && look.bias.is_finite();
        if !(numbers && look.cues.is_finite()) {
            return Err(JudgeError::NotFinite {
                place,
                found: format!("{look:?}"),
            });
        }
        let of = |look: &Look<'_>| [look.cues.band.low().0, look.cues.band.high().0];
        let (one_hz, other_hz) = (of(&textures[0]), of(look));
        if (0..2).any(|i| (one_hz[i] - other_hz[i]).abs() > 1e-6 * one_hz[i]) {
            return Err(JudgeError::Bands { one_hz, other_hz });
        }
    }
    Ok(())
}

/// Draws that decide whether the person attends, and what is guessed.
struct Attention {
    lapse: f64,
    guess: f64,
}

impl Attention {
    fn drawn(draw: &mut dyn FnMut() -> f64) -> Self {
        Self {
            lapse: cdf(draw()),
            guess: cdf(draw()),
        }
    }

    /// One of `count` with the same probability.
    fn guessed(&self, count: usize) -> usize {
        ((self.guess * count as f64) as usize).min(count.saturating_sub(1))
    }
}

impl Person {
    /// The association of `presented` with one of `alternatives`: its place. It is the alternative with the smallest squared distance
    /// (Δ ln rms/step)² + w·mean over bands of (ΔL/step)², where the noise of a comparison, of both its looks, is on the presented
    /// texture.
    ///
    /// `draw` gives standard normal numbers; eight are drawn. Source: physics of the twin, docs/decisions/twin.md.
    ///
    /// # Errors
    /// [`JudgeError`] where there are no alternatives, or cues cannot be compared.
    pub fn associate(
        &self,
        presented: Look<'_>,
        alternatives: &[Look<'_>],
        (recall, moment): (Recall, Moment),
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<usize, JudgeError> {
        let scene = Scene::of(self, presented, alternatives, (recall, moment))?;
        let attention = Attention::drawn(draw);
        let noise: [f64; AXES] = std::array::from_fn(|_| draw());
        if self.judge == Judge::Guesser || attention.lapse < self.touch.lapse_share {
            return Ok(attention.guessed(alternatives.len()));
        }
        let at: [f64; AXES] =
            std::array::from_fn(|i| scene.presented[i] + scene.noise[i] * noise[i]);
        let distances: Vec<f64> = scene.alternatives.iter().map(|a| squared(&at, a)).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let nearest: Vec<usize> = (0..distances.len())
            .filter(|j| distances[*j] <= least)
            .collect();
        let place = attention.guessed(nearest.len());
        Ok(nearest.get(place).copied().unwrap_or(0))
    }

    /// The order of `textures` by falling roughness: their places, the roughest first. Each is as rough as its level with noise, plus
    /// what its period adds; textures with a friction coefficient above the criterion come last.
    ///
    /// `draw` gives standard normal numbers; two and one for each texture are drawn. Source: Thurstone 1927, case V;
    /// docs/decisions/twin.md.
    ///
    /// # Errors
    /// [`JudgeError`] where there are no textures, or their cues cannot be compared.
    pub fn order(
        &self,
        textures: &[Look<'_>],
        moment: Moment,
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<Vec<usize>, JudgeError> {
        together(textures, 1)?;
        let attention = Attention::drawn(draw);
        let rough: Vec<f64> = textures
            .iter()
            .map(|look| {
                let (mean, sd) = self.roughness(*look, moment);
                mean + sd * draw()
            })
            .collect();
        let mut order: Vec<usize> = (0..textures.len()).collect();
        order.sort_by(|a, b| {
            let last = |i: usize| self.is_placed_last(textures[i]);
            last(*a)
                .cmp(&last(*b))
                .then(rough[*b].total_cmp(&rough[*a]))
        });
        if order.len() > 1 && attention.lapse < self.touch.lapse_share {
            let place = attention.guessed(order.len() - 1);
            order.swap(place, place + 1);
        }
        Ok(order)
    }

    /// Which of two textures is rougher or stronger: 0 or 1.
    ///
    /// `draw` gives standard normal numbers; four are drawn.
    ///
    /// # Errors
    /// [`JudgeError`] where their cues cannot be compared.
    pub fn rougher(
        &self,
        pair: [Look<'_>; 2],
        moment: Moment,
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<usize, JudgeError> {
        together(&pair, 2)?;
        let attention = Attention::drawn(draw);
        let felt = pair.map(|look| {
            let (mean, sd) = self.roughness(look, moment);
            mean + sd * draw()
        });
        if attention.lapse < self.touch.lapse_share {
            return Ok(attention.guessed(2));
        }
        Ok(usize::from(felt[1] > felt[0]))
    }

    /// Whether two textures are called the same: they are less than the criterion of steps apart.
    ///
    /// `draw` gives standard normal numbers; eight are drawn.
    ///
    /// # Errors
    /// [`JudgeError`] where their cues cannot be compared.
    pub fn same(
        &self,
        pair: [Look<'_>; 2],
        moment: Moment,
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<Sameness, JudgeError> {
        let [one, other] = pair;
        let scene = Scene::of(self, one, &[other], (Recall::Touched, moment))?;
        let attention = Attention::drawn(draw);
        let noise: [f64; AXES] = std::array::from_fn(|_| draw());
        let different = if self.judge == Judge::Guesser || attention.lapse < self.touch.lapse_share
        {
            attention.guess >= 0.5
        } else {
            let at: [f64; AXES] =
                std::array::from_fn(|i| scene.presented[i] + scene.noise[i] * noise[i]);
            squared(&at, &scene.alternatives[0]) > self.touch.different_steps.powi(2)
        };
        Ok(match different {
            true => Sameness::Different,
            false => Sameness::Same,
        })
    }

    /// The rating of a texture on a scale of whole numbers from `from`, the smoothest, to `to`, the roughest: linear in its roughness
    /// between the ends of the person's scale.
    ///
    /// `draw` gives standard normal numbers; three are drawn.
    ///
    /// # Errors
    /// [`JudgeError`] where its cues are no numbers.
    pub fn rate(
        &self,
        look: Look<'_>,
        [from, to]: [i64; 2],
        moment: Moment,
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<i64, JudgeError> {
        together(&[look], 1)?;
        let attention = Attention::drawn(draw);
        let (mean, sd) = self.roughness(look, moment);
        let felt = mean + sd * draw();
        let guesses = self.judge == Judge::Guesser || attention.lapse < self.touch.lapse_share;
        let [low, high] = match self.judge {
            Judge::SpectrumOnly => SPECTRUM_ENDS,
            _ => self.touch.scale_ends,
        };
        let share = match guesses {
            true => attention.guess,
            false => ((felt - low) / (high - low)).clamp(0.0, 1.0),
        };
        Ok(from + (share * (to - from) as f64).round() as i64)
    }

    /// Which of `count` categories, listed from the roughest to the smoothest, a texture has: its place. The scale of ratings is
    /// divided into equal parts.
    ///
    /// `draw` gives standard normal numbers; three are drawn.
    ///
    /// # Errors
    /// [`JudgeError`] where there is no category, or its cues are no numbers.
    pub fn categorise(
        &self,
        look: Look<'_>,
        count: usize,
        moment: Moment,
        draw: &mut dyn FnMut() -> f64,
    ) -> Result<usize, JudgeError> {
        if count == 0 {
            return Err(JudgeError::TooFew {
                expected: 1,
                found: 0,
            });
        }
        let fine = self.rate(look, [0, 1_000_000], moment, draw)?;
        let share = 1.0 - fine as f64 / 1e6;
        Ok(((share * count as f64) as usize).min(count - 1))
    }

    /// The mean and the standard deviation of a texture's roughness as it is sensed.
    pub(super) fn roughness(&self, look: Look<'_>, moment: Moment) -> (f64, f64) {
        let noise = self.touch.noise_at(moment) / look.looks.sqrt();
        let level = self.felt_level(look.cues) + look.bias;
        let level_noise = noise * self.level_noise(look.cues);
        match self.judge {
            Judge::Guesser => (0.0, 1.0),
            Judge::LevelOnly => (level, level_noise),
            Judge::SpectrumOnly => (-look.cues.ln_centroid, noise * self.touch.centroid_noise),
            Judge::Thurstone => {
                let period = look.cues.surface.map_or(0.0, |on| on.period_m);
                let spatial = (period.max(1e-4) / 1e-4).ln();
                (level + self.touch.spatial_weight * spatial, level_noise)
            }
        }
    }

    /// The level of a texture, in the natural logarithm of rms: a rendered one far below what is detected is felt as nothing.
    fn felt_level(&self, cues: &Cues) -> f64 {
        match cues.surface {
            Some(_) => cues.ln_rms,
            None => 0.5 * ((2.0 * cues.ln_rms).exp() + DETECTED_M_S2.powi(2)).ln(),
        }
    }

    /// Whether the texture sticks so that it is placed last.
    pub(super) fn is_placed_last(&self, look: Look<'_>) -> bool {
        let friction = look.cues.surface.and_then(|on| on.friction);
        self.judge == Judge::Thurstone
            && friction.is_some_and(|friction| friction > self.touch.smooth_friction)
    }

    fn level_noise(&self, cues: &Cues) -> f64 {
        match cues.surface {
            Some(_) => self.touch.level_noise_real,
            None => self.touch.level_noise_rendered,
        }
    }
}

/// The squared distance.
pub(super) fn squared(a: &[f64; AXES], b: &[f64; AXES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// A comparison in coordinates whose squared distance is the one that decides.
pub(super) struct Scene {
    pub(super) presented: [f64; AXES],
    pub(super) alternatives: Vec<[f64; AXES]>,
    /// The standard deviation of the noise on the presented texture.
    pub(super) noise: [f64; AXES],
}

impl Scene {
    pub(super) fn of(
        person: &Person,
        presented: Look<'_>,
        alternatives: &[Look<'_>],
        (recall, moment): (Recall, Moment),
    ) -> Result<Self, JudgeError> {
        let all: Vec<Look<'_>> = std::iter::once(presented)
            .chain(alternatives.iter().copied())
            .collect();
        together(&all, 2)?;
        let touch = &person.touch;
        let is_regular =
            |look: &Look<'_>| (look.cues.surface).is_some_and(|on| on.pattern == Pattern::Regular);
        let weight = match alternatives.iter().all(is_regular) {
            true => touch.spectrum_weight * touch.regular_weight_ratio,
            false => touch.spectrum_weight,
        };
        let [of_level, of_band] = match person.judge {
            Judge::Thurstone => [1.0, weight],
            Judge::LevelOnly => [1.0, 0.0],
            Judge::SpectrumOnly => [0.0, 1.0],
            Judge::Guesser => [0.0, 0.0],
        };
        let level = of_level / touch.level_step;
        let band = (of_band / CUE_BANDS as f64).sqrt() / touch.band_step_db;
        let at = |look: &Look<'_>| {
            let mut at = [0.0; AXES];
            at[0] = level * (look.cues.ln_rms + look.bias);
            for (at, db) in at[1..].iter_mut().zip(look.cues.bands_db) {
                *at = band * db;
            }
            at
        };
        // The alternatives together are one reference: the mean of their squared noises.
        let count = alternatives.len() as f64;
        let of_references = |squared: &dyn Fn(&Look<'_>) -> f64| {
            alternatives.iter().map(squared).sum::<f64>() / count
        };
        let memory = match recall {
            Recall::Touched => 1.0,
            Recall::Remembered => touch.memory_noise_ratio.powi(2),
        };
        let level_of = |look: &Look<'_>| person.level_noise(look.cues).powi(2) / look.looks;
        let level_noise = (level_of(&presented) + memory * of_references(&level_of)).sqrt();
        let looks = presented.looks.recip() + memory * of_references(&|look| look.looks.recip());
        let band_noise = touch.band_noise_db * looks.sqrt();
        let now = touch.noise_at(moment);
        let mut noise = [now * band * band_noise; AXES];
        noise[0] = now * level * level_noise;
        Ok(Self {
            presented: at(&presented),
            alternatives: alternatives.iter().map(at).collect(),
            noise,
        })
    }
}
