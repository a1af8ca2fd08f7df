//! ST-SIM and SPQI, for comparison with the literature: locked to the waveform, and without a unit.

use crate::score::{NotComputed, ScoreError, ScoreWarning};
use serde::{Deserialize, Serialize};
use statrs::function::erf::erfc;

use crate::fourier::RealTransform;
use crate::quantity::{Acceleration, SampleRate};
use crate::resample::resample;
use crate::series::Series;
use crate::warning::Warning;

/// The rate that both indices are made for, Hz.
pub const LITERATURE_RATE_HZ: f64 = 8000.0;
/// The samples of one block.
const BLOCK: usize = 512;
/// The scale of the normal distribution that turns a level above threshold into spectral support, dB.
const SUPPORT_DB: f64 = 12.0;
/// The share of temporal similarity in ST-SIM.
const TEMPORAL_SHARE: f64 = 2.0 / 3.0;

/// Which published threshold curve, dB re full scale, not re a physical unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LevelCurve {
    /// a = 62, e = 77: the curve of the Python package vibromaf, for both indices.
    #[default]
    Vibromaf,
    /// a = 50, e = 45: the masking curve of MPEG haptic coding, as it is written.
    Mpeg,
}

impl LevelCurve {
    /// The threshold of each of the 512 lines of a block, dB re full scale.
    ///
    /// Formula: |a/log10(b)²·log10(f/550 + b)²| − e, b = 1 − 250/550; vibromaf holds it where it first exceeds 0 dB,
    /// and has its lines at 8000·k/1023 Hz.
    ///
    /// Source: vibromaf 0.0.8, `signal/perception.py`, after R. Hassen and E. Steinbach (2020), IEEE Trans. Haptics 13(1).
    #[must_use]
    pub fn thresholds_db(self) -> Vec<f64> {
        let (a, e) = match self {
            Self::Vibromaf => (62.0, 77.0),
            Self::Mpeg => (50.0, 45.0),
        };
        let c = 1.0 / 550.0;
        let b: f64 = 1.0 - 250.0 * c;
        let factor = a / b.log10().powi(2);
        let mut thresholds: Vec<f64> = (0..BLOCK)
            .map(|k| {
                let frequency_hz = LITERATURE_RATE_HZ * k as f64 / (2 * BLOCK - 1) as f64;
                (factor * (c * frequency_hz + b).log10().powi(2)).abs() - e
            })
            .collect();
        if self == Self::Vibromaf {
            let limit = thresholds.iter().position(|t| *t > 0.0).unwrap_or(0);
            let held = thresholds[limit];
            thresholds[limit..].fill(held);
        }
        thresholds
    }
}

/// How the indices of the literature are computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LiteratureConfig {
    /// The threshold curve.
    pub curve: LevelCurve,
    /// The acceleration that is taken for full scale, m/s²: both curves need one, and neither paper gives it.
    pub full_scale_m_s2: f64,
}

impl LiteratureConfig {
    /// vibromaf's curve, 1 m/s² as full scale.
    #[must_use]
    pub fn vibromaf() -> Self {
        Self {
            curve: LevelCurve::Vibromaf,
            full_scale_m_s2: 1.0,
        }
    }
}

/// ST-SIM and its two parts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StSim {
    /// The index, 1 for equal signals, above it where the test excites more; `None` where the temporal similarity is negative and has no real power 2/3.
    pub value: Option<f64>,
    /// Similarity of the normalised blocks, −1–1.
    pub temporal: f64,
    /// Similarity of the spectral support, 0 and up.
    pub spectral: f64,
}

/// What the literature's indices say of two signals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Literature {
    /// The spectral temporal similarity.
    pub st_sim: StSim,
    /// The spectral perceptual quality index, 0–1.
    pub spqi: f64,
    /// How they were computed.
    pub config: LiteratureConfig,
    /// What a person should know before relying on them.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

/// Blocks of [`BLOCK`] samples; a rest is left out.
fn blocks(samples: &[f64]) -> impl Iterator<Item = &[f64]> {
    samples.chunks_exact(BLOCK)
}

/// The levels of the orthonormal cosine transform of every block, over the threshold, dB.
fn perceptual_spectra(samples: &[f64], thresholds_db: &[f64]) -> Vec<Vec<f64>> {
    let mut transform = RealTransform::new(2 * BLOCK);
    let turns: Vec<num_complex::Complex<f64>> = (0..BLOCK)
        .map(|k| {
            let angle = -std::f64::consts::PI * k as f64 / (2 * BLOCK) as f64;
            num_complex::Complex::from_polar((2.0 / BLOCK as f64).sqrt(), angle)
        })
        .collect();
    blocks(samples)
        .map(|block| {
            let bins = transform.forward(block);
            let lines = bins.iter().zip(&turns).zip(thresholds_db).enumerate();
            lines
                .map(|(k, ((bin, turn), threshold_db))| {
                    let scale = if k == 0 { 0.5f64.sqrt() } else { 1.0 };
                    20.0 * ((bin * turn).re * scale).abs().log10() - threshold_db
                })
                .collect()
        })
        .collect()
}

/// The mean over blocks of Σ r·d/(Σ r² + ε).
fn similarity(pairs: impl Iterator<Item = (Vec<f64>, Vec<f64>)>) -> f64 {
    let (sum, count) = pairs.fold((0.0, 0usize), |(sum, count), (r, d)| {
        let shared: f64 = r.iter().zip(&d).map(|(r, d)| r * d).sum();
        let own: f64 = r.iter().map(|r| r * r).sum();
        (sum + shared / (own + f64::EPSILON), count + 1)
    });
    sum / count.max(1) as f64
}

fn support(spectrum: &[f64]) -> Vec<f64> {
    let scale = -1.0 / (SUPPORT_DB * 2f64.sqrt());
    spectrum.iter().map(|db| 0.5 * erfc(db * scale)).collect()
}

fn normalised(block: &[f64]) -> Vec<f64> {
    let mean = crate::statistics::mean(block);
    let sd = crate::statistics::standard_deviation(block) + f64::EPSILON;
    block.iter().map(|v| (v - mean) / sd).collect()
}

/// The two signals as far as both reach.
fn shared<'a>(reference: &'a [f64], test: &'a [f64]) -> Result<(&'a [f64], &'a [f64]), ScoreError> {
    let found = reference.len().min(test.len());
    if found < BLOCK {
        return Err(ScoreError::FewSamples {
            expected: BLOCK,
            found,
        });
    }
    Ok((&reference[..found], &test[..found]))
}

/// ST-SIM of `test` to `reference`, both sampled at 8 kHz as shares of full scale, dimensionless: 1 for equal
/// signals. They are neither aligned nor scaled; the longer one is cut, and so is what fills no block of 512.
///
/// Formula: T^(2/3)·S^(1/3), with T = mean Σrd/(Σr² + ε) over blocks of mean 0 and deviation 1, S the same of
/// Φ((level − threshold)/12 dB) of the blocks' cosine transforms. Where T is negative there is no such power: vibromaf
/// 0.0.8 gives a complex number there, this a `None`.
///
/// Source: R. Hassen and E. Steinbach (2020), IEEE Trans. Haptics 13(1), as vibromaf 0.0.8 computes it.
///
/// # Errors
/// [`ScoreError::FewSamples`] without a block.
pub fn st_sim(reference: &[f64], test: &[f64], curve: LevelCurve) -> Result<StSim, ScoreError> {
    let (reference, test) = shared(reference, test)?;
    if reference == test {
        return Ok(StSim {
            value: Some(1.0),
            temporal: 1.0,
            spectral: 1.0,
        });
    }
    let thresholds_db = curve.thresholds_db();
    let of = |samples| perceptual_spectra(samples, &thresholds_db).into_iter();
    let spectral = similarity(
        of(reference)
            .zip(of(test))
            .map(|(r, d)| (support(&r), support(&d))),
    );
    let temporal = similarity(
        blocks(reference)
            .zip(blocks(test))
            .map(|(r, d)| (normalised(r), normalised(d))),
    );
    let value = temporal.powf(TEMPORAL_SHARE) * spectral.powf(1.0 - TEMPORAL_SHARE);
    Ok(StSim {
        value: (temporal >= 0.0).then_some(value),
        temporal,
        spectral,
    })
}

/// SPQI of `test` to `reference`, both sampled at 8 kHz as shares of full scale, 0–1: 1 for equal signals. They are
/// neither aligned nor scaled; the longer one is cut, and so is what fills no block of 512.
///
/// Formula: mean over blocks of (1 − tanh(0.3·D + 2))/2 with D = 10·log10(Σ|Pr − Pd|/(ΣPr + ε)), P the powers of the
/// cosine transform over the threshold.
///
/// Source: A. Noll et al. (2022), as vibromaf 0.0.8 computes it.
///
/// # Errors
/// [`ScoreError::FewSamples`] without a block.
pub fn spqi(reference: &[f64], test: &[f64], curve: LevelCurve) -> Result<f64, ScoreError> {
    let (reference, test) = shared(reference, test)?;
    if reference == test {
        return Ok(1.0);
    }
    let thresholds_db = curve.thresholds_db();
    let powers = |samples| {
        let spectra = perceptual_spectra(samples, &thresholds_db).into_iter();
        spectra.map(|s| s.iter().map(|db| 10f64.powf(db / 10.0)).collect::<Vec<_>>())
    };
    let scores: Vec<f64> = powers(reference)
        .zip(powers(test))
        .map(|(r, d)| {
            let difference: f64 = r.iter().zip(&d).map(|(r, d)| (r - d).abs()).sum();
            let own: f64 = r.iter().sum();
            let ratio_db = 10.0 * (difference / (own + f64::EPSILON)).log10();
            (1.0 - (0.3 * ratio_db + 2.0).tanh()) / 2.0
        })
        .collect();
    Ok(crate::statistics::mean(&scores))
}

/// Both indices of two accelerations, brought to 8 kHz and to shares of `config.full_scale_m_s2`.
///
/// Source: [`st_sim`], [`spqi`]; vibromaf takes its input for 8 kHz and converts nothing, here [`resample`] does.
///
/// # Errors
/// [`ScoreError::FewSamples`] without a block; [`ScoreError::NoFullScale`] when full scale is not above zero;
/// [`ScoreError::Series`] when a rate cannot become 8 kHz.
pub fn literature(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    config: LiteratureConfig,
) -> Result<Literature, ScoreError> {
    let full_scale_m_s2 = config.full_scale_m_s2;
    if !(full_scale_m_s2 > 0.0 && full_scale_m_s2.is_finite()) {
        return Err(ScoreError::NoFullScale {
            found: full_scale_m_s2,
        });
    }
    let rate = SampleRate::new(LITERATURE_RATE_HZ).map_err(|_constant| ScoreError::FewSamples {
        expected: BLOCK,
        found: 0,
    })?;
    let scaled = |x: &Series<Acceleration>| -> Result<Vec<f64>, ScoreError> {
        let samples = resample(x, rate)?.into_samples();
        Ok(samples.iter().map(|v| v / full_scale_m_s2).collect())
    };
    let (r, d) = (scaled(reference)?, scaled(test)?);
    let st_sim = st_sim(&r, &d, config.curve)?;
    let warnings = match st_sim.value {
        Some(value) if value > 1.0 => vec![Warning::from(ScoreWarning::NotComputed {
            what: NotComputed::StSimBeyondRange { value },
        })],
        Some(_) => Vec::new(),
        None => vec![Warning::from(ScoreWarning::NotComputed {
            what: NotComputed::StSim {
                temporal: st_sim.temporal,
            },
        })],
    };
    Ok(Literature {
        spqi: spqi(&r, &d, config.curve)?,
        st_sim,
        config,
        warnings,
    })
}
