//! Whether two vibrations can be distinguished by touch: one number in just-noticeable differences (JND) that does not
//! depend on which realisation of a texture was recorded.
//!
//! The score is the perceived difference of [`crate::perception`], over time and by channel of receptors. Beside it stand the difference
//! of the spectra (what both excite, band by band, in m/s² over the detection threshold, in JND of level and of frequency), waveform
//! similarity and the indices of the literature. The difference of the spectra alone decides where [`ScoreModel::Spectral`] is asked for.

mod active;
mod error;
mod excitation;
pub mod literature;
mod measurement;
mod page;
mod perceived;
mod perceptible;
mod sliding;
mod verdict;
mod warning;
mod waveform;

use active::Compared;
pub use error::ScoreError;
use excitation::{Plans, Waveform as Segments, evidence, parts, spread};
use serde::{Deserialize, Serialize};
pub use warning::{NoIndicesCause, NotComparedCause, NotComputed, ScoreWarning};

pub use literature::{Literature, LiteratureConfig};
pub use measurement::{JudgedMeasurement, Measurement, Target, judged_measurement};
pub use page::ScoredRecordings;
pub use perceived::Perceived;
pub use perceptible::with_perceptible_difference;
pub use sliding::sliding_part;
pub use verdict::{How, ScoreCriterion, Verdict};
pub use waveform::{Extent, Waveform};

use crate::checksum::Checksum;
use crate::clipping::{ClippedAt, ClippingWarning, flat_top_fraction};
use crate::criterion::Criterion;
pub use crate::discrimination::Difference;
use crate::discrimination::{ContactMap, Differences, Excitation, Model, differences};
use crate::feature::Weighting;
use crate::number::rounded;
use crate::quantity::{Acceleration, Band, Decibels, Hertz, Seconds};
use crate::series::{Series, SeriesError};
use crate::spectrum::{EstimateError, RECOMMENDED_SEGMENTS, WelchConfig, welch};
use crate::statistics::LevelSpread;
use crate::verify::{VerifyConfig, VerifyError, errors_in_band, rms_of};
use crate::warning::{Few, FewWarning, Scatter, ScatterWarning, Warning, Warnings};

/// The window of short-time levels.
const SHORT_TIME: Seconds = Seconds(0.1);
/// Less excitation than this, −120 dB re threshold, is what rounding leaves of silence.
const SILENT: f64 = 1e-12;
/// Levels of nothing are this, dB.
const NOTHING_DB: f64 = -300.0;

/// Which difference decides whether two vibrations are distinguishable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ScoreModel {
    /// What is felt over time and by channel of receptors.
    #[default]
    PerceivedDifference,
    /// What both excite in third octaves over their whole length; it knows nothing of time.
    Spectral,
}

/// How two vibrations are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ScoreConfig {
    /// Which difference decides.
    pub judged_by: ScoreModel,
    /// The band over which they are compared.
    pub band: Band,
    /// One just-noticeable difference in level, dB: below it nothing is noticed.
    pub level_jnd: Decibels,
    /// The largest JND in level that was found, dB: above it a difference is noticed, between the two nothing is decided.
    pub level_jnd_high: Decibels,
    /// One just-noticeable difference in frequency, as a share of it (Weber fraction).
    pub frequency_jnd_share: f64,
    /// Whose detection threshold counts.
    pub weighting: Weighting,
    /// How skin moves when the nail does; absent, they are taken to move alike.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub contact: Option<ContactMap>,
    /// How the spectra behind the bands are estimated.
    pub welch: WelchConfig,
    /// How the indices of the literature are computed.
    pub literature: LiteratureConfig,
}

impl ScoreConfig {
    /// Over `band`, judged by the perceived difference: JND of spectra, their range and thresholds of [`Model::over`], Hann segments of about 1.2 Hz at `rate_hz`.
    #[must_use]
    pub fn over(band: Band, rate_hz: f64) -> Self {
        let segment = 2f64.powf((rate_hz / 1.2).log2().round()).max(16.0) as usize;
        let model = Model::over(band);
        Self {
            judged_by: ScoreModel::PerceivedDifference,
            band,
            level_jnd: model.level_jnd,
            level_jnd_high: model.level_jnd_high,
            frequency_jnd_share: model.frequency_jnd_share,
            weighting: model.weighting,
            contact: None,
            welch: WelchConfig::hann(segment),
            literature: LiteratureConfig::vibromaf(),
        }
    }

    /// What a finger feels, and what of a difference.
    #[must_use]
    pub fn model(&self) -> Model {
        Model {
            band: self.band,
            level_jnd: self.level_jnd,
            level_jnd_high: self.level_jnd_high,
            frequency_jnd_share: self.frequency_jnd_share,
            weighting: self.weighting,
            contact: self.contact.clone(),
        }
    }

    /// [`Model::spreading`].
    #[must_use]
    pub fn spreading(&self) -> f64 {
        self.model().spreading()
    }
}

/// What two vibrations hold in one third octave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BandScore {
    /// The band.
    pub band_hz: Band,
    /// Its centre, Hz.
    pub centre_hz: f64,
    /// Level of the reference, dB re 1 m/s² rms.
    pub reference_db: f64,
    /// Level of the test, dB re 1 m/s² rms.
    pub test_db: f64,
    /// The detection threshold at the centre, dB re 1 m/s² rms.
    pub threshold_db: f64,
    /// Test over reference, dB.
    pub difference_db: f64,
    /// What is felt of the difference, dB: of levels over threshold that spread over neighbouring bands, with what lies
    /// below the floor lifted to it.
    pub felt_db: f64,
    /// The same in JND, with its sign.
    pub felt_jnd: f64,
    /// How far it may be off, JND, 95 %.
    pub ci_half_width_jnd: f64,
    /// How much the band counts, 0–1: its share of what is excited.
    pub share: f64,
}

/// The spectra's difference line by line, in dB.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpectrumError {
    /// Root mean square over the lines of the band, dB.
    pub rms_db: f64,
    /// The largest, dB.
    pub max_db: f64,
    /// Where it is, Hz.
    pub max_at_hz: f64,
    /// The step between the lines, Hz.
    pub resolution_hz: f64,
}

/// The perceptual distance of two vibrations with its verdict, and further measures of their difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Score {
    /// The score: the perceived difference, over time and by channel; absent where the spectra decide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perceived: Option<Perceived>,
    /// The criteria: the difference that decides re the just-noticeable difference and, for two realisations, re the distance between the
    /// halves of one recording.
    pub criteria: Vec<Criterion<ScoreCriterion>>,
    /// The verdict that follows from the criteria.
    pub verdict: Verdict,
    /// One sentence that says whether a finger could tell A, the reference, from B, the test, by how much, and how.
    pub sentence: String,
    /// The difference of the spectra, JND: the largest of the three below.
    pub spectral: Difference,
    /// How far the spectra of the halves of the reference lie apart, and those of the test, JND; absent where they are too short.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_jnd: Option<[f64; 2]>,
    /// The mean difference of the bands' levels, weighed by what they excite.
    pub spectrum: Difference,
    /// The difference of the overall level over threshold.
    pub level: Difference,
    /// The difference of the mean frequency of what is excited.
    pub balance: Difference,
    /// The mean frequency of what the reference excites, Hz.
    pub reference_centroid_hz: f64,
    /// The mean frequency of what the test excites, Hz.
    pub test_centroid_hz: f64,
    /// The level of what the reference excites, dB re the detection threshold.
    pub reference_sensation_db: f64,
    /// The level of what the test excites, dB re the detection threshold.
    pub test_sensation_db: f64,
    /// 20·log10 of the rms of the test over that of the reference in the band, dB.
    pub level_error_db: f64,
    /// Third octaves.
    pub bands: Vec<BandScore>,
    /// The spectra line by line.
    pub spectrum_error: SpectrumError,
    /// The spread of short-time levels of the reference and the test, dB; it is not part of the score.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulation_db: Option<[f64; 2]>,
    /// What of the two is compared.
    pub extent: Extent,
    /// How alike the waveforms are; it is not part of the score.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waveform: Option<Waveform>,
    /// ST-SIM and SPQI, for comparison with the literature; not part of the score.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub literature: Option<Literature>,
    /// The rate at which they were compared, Hz.
    pub rate_hz: f64,
    /// The segments averaged, of the one that has fewer.
    pub segments: usize,
    /// Whether level or spectrum of one of the two change over time by more than chance explains.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_nonstationary: bool,
    /// How it was computed.
    pub config: ScoreConfig,
    /// Where the just noticeable differences of level and spectrum come from; those of the perceived difference have their sources in `perception`.
    pub jnd_source: &'static str,
    /// What a person should know before relying on it.
    pub warnings: Warnings,
}

/// What [`score`] takes in memory at most beside its two recordings, in bytes for each sample of the longer one.
///
/// Source: measured by `tests/memory.rs`; docs/decisions/verification.md.
pub const MEMORY_BYTES_A_SAMPLE: usize = 160;

/// The perceptual distance of `test` from `reference` in JND, and whether they can be distinguished: by the perceived difference
/// ([`crate::perception`]) within the band, or by the difference of the spectra, as `config` says.
///
/// Perceived: all of each is compared, and of an excerpt that is cut out of the other what both share. *Below the JND* needs the whole
/// interval below 1 JND; *distinguishable* needs it above 1 JND and, for two realisations, above twice what parts of one recording differ by.
///
/// Spectra: where one waveform follows the other (correlation above 0.5 either way over four fifths of the shorter, above 0.8 over less)
/// they are aligned, and the time that they share is compared; or else all of each. Silence of 50 ms or more before and after a
/// vibration (30 dB below its loudest 5 ms) is left out, with a warning; a vibration shorter than a segment is compared by one
/// segment around it, at the level of its own duration.
///
/// Formulas: excitation e = Σ S(f)/a(f)²·Δf, a the detection threshold, spread over third octaves as
/// [`ScoreConfig::spreading`] says. What lies below a floor is lifted to it: 1 (the threshold) for the sum over all bands, and
/// for each band the largest of either over the larger of the two sums, so that two spectra of which neither is above
/// threshold reach it nowhere. With d the difference in dB of a
/// band and w its share of the louder's excitation: spectrum = Σ w|d|/JND; level = |difference of the sums|/JND;
/// balance = |Δ mean of ln f, weighed by excitation|/ln(1 + Weber fraction). The score is the largest of the three, 0 when
/// neither is felt. Limits: 95 % (Student), from how the segments
/// differ, or its quarters or halves where those differ by more than segments make likely; with fewer than ten segments from what
/// Gaussian noise of these spectra would do; where one follows the other, from how both differ segment by segment. Below, what
/// absolute values of mere scatter add up to is taken away as well.
///
/// Source: docs/decisions/perception.md and verification.md; thresholds after Bolanowski et al. (1988), summed power after Bensmaïa and
/// Hollins (2003), JND after Israr and Tan (2006).
///
/// # Errors
/// [`ScoreError::Rate`] when the rates differ, [`ScoreError::BandAboveNyquist`], [`ScoreError::Jnd`] when a JND is not
/// above zero, [`ScoreError::Silent`] when either holds nothing in the band, [`ScoreError::NoBand`] when the band
/// lies below 1 Hz, [`ScoreError::TooShort`] when either is shorter than 5 ms, or less than 0.3 s of a longer vibration (by spectra: less
/// than a segment) is left to compare, [`ScoreError::Perception`] when the perceived difference cannot be computed: below 1000 Hz or 50 ms.
///
/// ```
/// use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, SampleRate};
/// use piezotact::score::{ScoreConfig, score};
/// let rate = SampleRate::new(5000.0).unwrap();
/// let tone = (0..50_000).map(|i| 5.0 * (std::f64::consts::TAU * 250.0 * i as f64 / 5000.0).sin());
/// let tone = piezotact::Series::<Acceleration>::new(tone.collect(), rate).unwrap();
/// let louder = tone.clone().amplified(Decibels(1.58));
/// let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
/// let score = score(&tone, &louder, &ScoreConfig::over(band, 5000.0)).unwrap();
/// assert!((score.spectral.jnd - 1.0).abs() < 1e-6);
/// let perceived = score.perceived.unwrap().difference;
/// assert!(perceived.jnd.low < 1.0 && 1.0 > perceived.jnd.value);
/// ```
pub fn score(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<Score, ScoreError> {
    refuse(reference, test, config)?;
    let mut warnings = Warnings::new();
    let [of_reference, of_test] =
        [reference, test].map(|one| Checksum::of(one.samples().iter().copied()));
    if of_reference == of_test {
        warnings.push(ScoreWarning::NotComputed {
            what: NotComputed::TwoRecordings,
        });
    }
    let (waveform, shared) = waveforms(reference, test, config.band, &mut warnings);
    let found = Compared::of([reference, test], shared, config, &mut warnings)?;
    let perceived = match config.judged_by {
        ScoreModel::PerceivedDifference => {
            let common = found.common(waveform.as_ref());
            Some(perceived::perceived([reference, test], common, config)?)
        }
        ScoreModel::Spectral => None,
    };
    let (extent, [reference, test]) = (found.extent, &found.series);
    let rate_hz = reference.rate().hz();
    let bands = config.band.third_octaves();
    if bands.is_empty() {
        return Err(ScoreError::NoBand { band: config.band });
    }
    let model = config.model();
    let plans = Plans::new(&model);
    let a = excited("the reference", reference, &plans, config)?;
    let b = excited("the test", test, &plans, config)?;
    let segments = a.segments().min(b.segments());
    let scales = match found.is_short {
        true => vec![a.scatter_of_noise(&b, &config.welch, found.independent(waveform.as_ref()))],
        false => evidence([(reference, &a), (test, &b)], extent, &plans, &config.welch)?,
    };
    let (a, b) = (&a.mean, &b.mean);
    let apart = differences(a, b, &model, &scales);
    let spectral = apart.largest();
    let bands = band_scores(&bands, a, b, &apart, &model);
    // A short effect has no halves that are alike, and no level that changes.
    let (within_jnd, levels) = match found.is_short {
        true => (None, None),
        false => (
            within(reference, test, &plans, &config.welch)?,
            levels_over_time(reference, test, &plans)?,
        ),
    };
    let sensation_db = [a, b].map(|x| level_db(x.total()));
    let criteria = match &perceived {
        Some(found) => verdict::perceived_criteria(found),
        None => verdict::spectral_criteria(
            spectral,
            (extent, within_jnd),
            (levels, sensation_db),
            &model,
        ),
    };
    let Differences {
        spectrum,
        level,
        balance,
        wanders,
        ..
    } = apart;

    let felt_db = perceived.as_ref().map_or(sensation_db, |found| {
        found.difference.sensation_level.map(|level| level.0)
    });
    warnings.extend(warnings_about([reference, test], felt_db, segments));
    warnings.extend(model.warnings());
    if wanders {
        warnings.push(Warning::from(ScatterWarning::Scatter {
            of: Scatter::Parts,
        }));
    }
    let modulation = levels.map(|[a, b]| [a.db, b.db]);
    let indices = literature::literature(reference, test, config.literature);
    let literature = computed(indices, &mut warnings);
    let power = |x: &Excitation| x.power.iter().sum::<f64>();
    let verdict = match &perceived {
        Some(found) => Verdict::perceived(&criteria, &found.difference),
        None => Verdict::spectral(
            spectral,
            &criteria,
            [
                (level, b.total() > a.total()),
                (balance, b.log_centroid() > a.log_centroid()),
            ],
            &bands,
            Seconds(found.shorter_s),
        ),
    };
    let mut found = Score {
        perceived,
        sentence: String::new(),
        verdict,
        criteria,
        spectral,
        within_jnd,
        spectrum,
        level,
        balance,
        reference_centroid_hz: a.log_centroid().exp(),
        test_centroid_hz: b.log_centroid().exp(),
        reference_sensation_db: sensation_db[0],
        test_sensation_db: sensation_db[1],
        level_error_db: level_db(power(b)) - level_db(power(a)),
        bands,
        spectrum_error: spectrum_error(reference, test, config.band)?,
        modulation_db: modulation,
        extent,
        waveform,
        literature,
        rate_hz,
        segments,
        is_nonstationary: wanders,
        config: config.clone(),
        jnd_source: config.model().jnd_source(),
        warnings,
    };
    found.sentence = found.in_words();
    Ok(found)
}

/// The comparison of the waveforms, and the part that both share.
fn waveforms(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    band: Band,
    warnings: &mut Warnings,
) -> (Option<Waveform>, Option<[Series<Acceleration>; 2]>) {
    match waveform::waveform(reference, test, band) {
        Ok(compared) => {
            warnings.extend(compared.warnings);
            (Some(compared.waveform), compared.shared)
        }
        // It is said with the name that the signal has here.
        Err(VerifyError::Silent { .. }) => (None, None),
        Err(error) => {
            warnings.push(Warning::from(ScoreWarning::NotComputed {
                what: NotComputed::Waveform { why: error.into() },
            }));
            (None, None)
        }
    }
}

/// What `x`, named `what`, excites in its segments.
fn excited(
    what: &'static str,
    x: &Series<Acceleration>,
    plans: &Plans<'_>,
    config: &ScoreConfig,
) -> Result<Segments, ScoreError> {
    let found = Segments::of(x, plans, &config.welch)?;
    if found.mean.total() > SILENT {
        Ok(found)
    } else {
        Err(ScoreError::Silent {
            what,
            band: config.band,
        })
    }
}

/// The indices of the literature; a warning where they could not be computed.
fn computed(
    indices: Result<Literature, ScoreError>,
    warnings: &mut Warnings,
) -> Option<Literature> {
    match indices {
        Ok(literature) => {
            warnings.extend(literature.warnings.clone());
            Some(literature)
        }
        Err(error) => {
            warnings.push(Warning::from(ScoreWarning::NotComputed {
                what: NotComputed::Indices { why: error.into() },
            }));
            None
        }
    }
}

fn refuse(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    config: &ScoreConfig,
) -> Result<(), ScoreError> {
    let rate = reference.rate();
    if (test.rate().hz() - rate.hz()).abs() > 1e-9 * rate.hz() {
        return Err(ScoreError::Rate {
            reference_hz: rate.hz(),
            test_hz: test.rate().hz(),
        });
    }
    if config.band.high().0 > rate.nyquist().0 {
        return Err(ScoreError::BandAboveNyquist {
            band: config.band,
            highest: rate.nyquist(),
        });
    }
    let needed = active::SHORTEST;
    for (what, x) in [("the reference", reference), ("the test", test)] {
        if x.duration().0 < needed.0 {
            return Err(ScoreError::TooShort {
                what,
                needed,
                found: x.duration(),
            });
        }
    }
    require_jnd(config.level_jnd, config.frequency_jnd_share)
}

/// The largest just-noticeable difference in level that is accepted, dB: a thousand times in amplitude.
const LARGEST_JND_DB: f64 = 60.0;
/// The largest just-noticeable difference in frequency that is accepted, as a share.
const LARGEST_JND_SHARE: f64 = 10.0;

/// Requires just-noticeable differences that can be: in level above 0 and up to 60 dB, in frequency a share above 0 and up to 10.
///
/// # Errors
/// [`ScoreError::Jnd`] for one that is not.
///
/// Source: house rule.
pub fn require_jnd(level: Decibels, frequency_share: f64) -> Result<(), ScoreError> {
    for (what, found, most) in [
        ("in level, in dB", level.0, LARGEST_JND_DB),
        (
            "in frequency, as a share",
            frequency_share,
            LARGEST_JND_SHARE,
        ),
    ] {
        if !(found > 0.0 && found <= most) {
            return Err(ScoreError::Jnd { what, found, most });
        }
    }
    Ok(())
}

fn level_db(power: f64) -> f64 {
    (10.0 * power.log10()).max(NOTHING_DB)
}

/// How far the halves of either lie apart, JND; `None` where they are too short for a spectrum.
fn within(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    plans: &Plans<'_>,
    welch: &WelchConfig,
) -> Result<Option<[f64; 2]>, ScoreError> {
    let of = |x| -> Result<Option<f64>, ScoreError> {
        Ok(match parts(x, 2, plans, welch)?.as_deref() {
            Some([first, second]) => Some(plans.model.distance_jnd(&first.sums, &second.sums)),
            _ => None,
        })
    };
    Ok(match (of(reference)?, of(test)?) {
        (Some(a), Some(b)) => Some([a, b]),
        _ => None,
    })
}

/// Each third octave.
fn band_scores(
    bands: &[Band],
    a: &Excitation,
    b: &Excitation,
    found: &Differences,
    model: &Model,
) -> Vec<BandScore> {
    bands
        .iter()
        .zip(&found.bands)
        .enumerate()
        .map(|(i, (band, difference))| {
            let centre_hz = (band.low().0 * band.high().0).sqrt();
            let (reference_db, test_db) = (level_db(a.power[i]), level_db(b.power[i]));
            BandScore {
                band_hz: *band,
                centre_hz,
                reference_db,
                test_db,
                threshold_db: 20.0 * model.threshold_m_s2(Hertz(centre_hz)).log10(),
                difference_db: test_db - reference_db,
                felt_db: difference.felt_db,
                felt_jnd: difference.felt_db / model.level_jnd.0,
                ci_half_width_jnd: difference.ci_half_width_db / model.level_jnd.0,
                share: difference.share,
            }
        })
        .collect()
}

/// The spectra line by line, with lines about 5 Hz apart, as a verification has them.
fn spectrum_error(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    band: Band,
) -> Result<SpectrumError, ScoreError> {
    let config = VerifyConfig::over(band, reference.rate().hz()).welch;
    let (a, b) = (welch(reference, &config)?, welch(test, &config)?);
    let lines = errors_in_band(&a.values, &b.values, a.resolution_hz, band)?.compared;
    let (max_at_hz, max_db) = lines
        .iter()
        .copied()
        .max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()))
        .unwrap_or((band.low().0, 0.0));
    Ok(SpectrumError {
        rms_db: rms_of(lines.iter().map(|(_, error_db)| *error_db)),
        max_db: max_db.abs(),
        max_at_hz,
        resolution_hz: a.resolution_hz,
    })
}

fn warnings_about(
    [reference, test]: [&Series<Acceleration>; 2],
    felt_db: [f64; 2],
    segments: usize,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if segments < RECOMMENDED_SEGMENTS {
        warnings.push(Warning::from(FewWarning::Few {
            found: segments,
            recommended: RECOMMENDED_SEGMENTS,
            what: Few::Segments,
        }));
    }
    let names = ["the reference", "the test"];
    for ((what, x), felt_db) in names.into_iter().zip([reference, test]).zip(felt_db) {
        let fraction = flat_top_fraction(x.samples());
        if fraction > 0.0 {
            warnings.push(Warning::from(ClippingWarning::Clipped {
                signal: what.into(),
                at: ClippedAt::Recorded { fraction },
            }));
        }
        warnings.extend(not_felt([what], [felt_db]));
    }
    warnings
}

/// The warnings about those vibrations of `names` that are not felt: their levels `sensation_db`, dB re the detection threshold, are
/// not above 0 dB.
///
/// Source: as [`score`].
#[must_use]
pub fn not_felt<const N: usize>(names: [&str; N], sensation_db: [f64; N]) -> Vec<Warning> {
    let levels = names.into_iter().zip(sensation_db);
    let below = levels.filter(|(_, level_db)| *level_db <= 0.0);
    let warning = |(signal, level_db): (&str, f64)| {
        let signal = signal.to_owned();
        ScoreWarning::NotFelt { signal, level_db }.into()
    };
    below.map(warning).collect()
}

/// The short-time levels of both; `None` where either is too short.
fn levels_over_time(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
    plans: &Plans<'_>,
) -> Result<Option<[LevelSpread; 2]>, ScoreError> {
    let of = |x| spread(x, plans, SHORT_TIME);
    Ok(of(reference)?.zip(of(test)?).map(|(a, b)| [a, b]))
}

#[cfg(test)]
mod short_tests;
