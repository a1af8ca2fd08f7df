//! Features of the strokes of a recording: level, spectrum, friction, and perceptually weighted power.

mod forces;
mod low;
mod over_strokes;
mod peaks;
mod plan;
mod rest;
mod spectra;
mod statistics;
mod warning;
mod weighting;

use crate::integrity::{ChannelFault, RestLine, SignalWarning, never_changes};
use low::{LowFrequencies, LowPowers};
use serde::{Deserialize, Serialize};
pub use warning::FeatureWarning;

pub use forces::{StrokeForces, stroke_forces};
pub(crate) use peaks::peaks_above;
pub use peaks::{Peak, peaks};
pub use plan::{FeaturePlan, band_power};
pub use spectra::StrokeSpectra;
pub use statistics::{Moments, Statistics};
pub use weighting::{Receptor, Weighting};

use crate::clipping::{ClippedAt, ClippingWarning, Rails};
use crate::filter::{HighPass, ZeroPhase};
use crate::quantity::{Band, Hertz, SampleRate, Uncalibrated, Unit};
use crate::recording::{Recording, RecordingError};
use crate::roles::Roles;
use crate::spectrum::{
    EstimateError, RECOMMENDED_SEGMENTS, WelchConfig, amplitude_spectrum, segments_in,
};
use crate::stroke::{
    Interval, SegmentError, Segmentation, Signals, Stroke, StrokeWarning, Unusual,
};
use crate::warning::words::first_of;
use crate::warning::{Few, FewWarning, Warning};

/// Fewer strokes than this in an average are a warning.
///
/// Source: the protocol of the 2024 thesis, section 3.1: averages over at least ten explorations.
pub const RECOMMENDED_STROKES: usize = 10;

/// How features are computed. It is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FeatureConfig {
    /// The high-pass filter that removes the gesture from the vibration; none keeps the gesture.
    pub high_pass: Option<HighPass>,
    /// How PSDs are estimated.
    pub welch: WelchConfig,
    /// The band for peaks, centroid, spread and weighted powers.
    pub band: Band,
}

impl FeatureConfig {
    /// Where the slope of the high-pass is over: half an octave above its cut-off; 0 Hz without one.
    #[must_use]
    pub fn passes_from(&self) -> Hertz {
        Hertz(
            self.high_pass
                .map_or(0.0, |high_pass| 1.5 * high_pass.cutoff_hz.0),
        )
    }

    /// What is usual for vibration at `rate` in recordings whose longest strokes have `longest` samples: lines about
    /// 5 Hz apart as 1024 samples at 5 kHz give (256 samples and more at low rates), or as fine as the longest stroke
    /// of every recording allows; the band from 10 Hz (a hundredth of the rate where that is less) to 1000 Hz.
    ///
    /// # Errors
    /// [`FeatureError::Estimate`] when a recording has no stroke of 8 samples.
    pub fn usual(
        rate: SampleRate,
        longest: &[usize],
        high_pass: Option<HighPass>,
    ) -> Result<Self, FeatureError> {
        let usual = ((rate.hz() / 4.882_812_5).log2().round().exp2() as usize).max(256);
        let segment = longest.iter().copied().fold(usual, usize::min);
        if segment < 8 {
            return Err(FeatureError::Estimate(EstimateError::TooShort {
                expected: 8,
                found: segment,
            }));
        }
        let low_hz = (0.01 * rate.hz()).min(10.0);
        let high_hz = (0.499 * rate.hz()).min(1000.0);
        Ok(Self {
            high_pass,
            welch: WelchConfig::hann(segment),
            band: Band::new(Hertz(low_hz), Hertz(high_hz))?,
        })
    }
}

/// The features of one stroke. What was not measured is absent. `u` is the unit of the vibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StrokeFeatures {
    /// Where it begins in the recording, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// The rms of the vibration about its mean, u; of several channels the root of the mean of their squares.
    pub rms: f64,
    /// The largest departure from the mean, u.
    pub peak: f64,
    /// Peak over rms.
    pub crest_factor: f64,
    /// The power in the bands of the four mechanoreceptors, u², in the order of [`Receptor::ALL`]; absent for a band that reaches
    /// beyond the Nyquist frequency, which the recording does not hold.
    pub receptor_power: [Option<f64>; 4],
    /// The mean frequency of the power in the band, Hz.
    pub centroid_hz: f64,
    /// The standard deviation of frequency around it, Hz.
    pub spread_hz: f64,
    /// The strongest line in the band, Hz.
    pub strongest_hz: f64,
    /// Peaks above the background, the strongest first.
    pub peaks: Vec<Peak>,
    /// The fourth power of the departure from the mean over the square of its second power, in the mean: 3 for Gaussian noise, 1.5
    /// for a tone, more for bursts; of several channels the mean.
    pub kurtosis: f64,
    /// The standard deviation of the levels of 0.1 s, dB; silence counts as 20 dB below the mean level. Absent for strokes
    /// shorter than 0.3 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_spread_db: Option<f64>,
    /// √(Fx² + Fy²)/Fz, sample by sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_coefficient: Option<Statistics>,
    /// The normal force above its zero, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_force_n: Option<Moments>,
    /// The magnitude of the speed, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<Moments>,
    /// Power weighted by the Pacinian threshold over the band of the analysis, and below it as far as the filter lets it pass; for
    /// accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pacinian_power: Option<f64>,
    /// Power weighted by the detection threshold, over the same; for accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection_power: Option<f64>,
    /// The power in the band of Meissner's corpuscles re their threshold, dB: above 0 they detect a steady vibration; for
    /// accelerations only. The gain of the filter is corrected for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meissner_level_db: Option<f64>,
    /// The part of that band that it is over begins here, Hz: below are the gesture, which is filtered out, and what a short stroke does
    /// not resolve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meissner_from_hz: Option<f64>,
    /// The same with all that the unfiltered signal holds in the rest of the band, gesture or vibration, dB: the level is no higher. Absent
    /// where all of the band is covered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meissner_level_at_most_db: Option<f64>,
    /// The same for Pacinian corpuscles, dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pacini_level_db: Option<f64>,
}

impl StrokeFeatures {
    /// With what it is at low frequencies.
    fn add(&mut self, low: LowPowers) {
        let powers = [
            (&mut self.pacinian_power, low.pacinian),
            (&mut self.detection_power, low.detection),
        ];
        for (power, more) in powers {
            *power = power.map(|power| power + more);
        }
        self.meissner_level_db = low.meissner_db;
        self.meissner_from_hz = low.meissner_db.map(|_| low.from_hz);
        self.meissner_level_at_most_db = low.meissner_at_most_db;
    }
}

/// A number of a stroke, as tables and reports have it.
#[derive(Clone, Copy, Debug)]
pub struct StrokeColumn {
    /// Its name, with its unit where that is not a power of the vibration's: `centroid_hz`.
    pub name: &'static str,
    /// Its heading in a report's table of groups, with its unit; absent where it is not shown there.
    pub heading: Option<&'static str>,
    /// The number; absent where it was not measured.
    pub value: fn(&StrokeFeatures) -> Option<f64>,
}

impl StrokeColumn {
    const fn of(name: &'static str, value: fn(&StrokeFeatures) -> Option<f64>) -> Self {
        Self {
            name,
            heading: None,
            value,
        }
    }

    const fn shown(self, heading: &'static str) -> Self {
        Self {
            heading: Some(heading),
            ..self
        }
    }
}

/// The numbers of a stroke, in the order of the columns of tables. Groups summarise those that have a heading.
pub const STROKE_COLUMNS: &[StrokeColumn] = &[
    StrokeColumn::of("rms", |s| Some(s.rms)),
    StrokeColumn::of("peak", |s| Some(s.peak)),
    StrokeColumn::of("crest_factor", |s| Some(s.crest_factor)).shown("crest factor"),
    StrokeColumn::of("merkel_power", |s| s.receptor_power[0]),
    StrokeColumn::of("meissner_power", |s| s.receptor_power[1]),
    StrokeColumn::of("pacini_power", |s| s.receptor_power[2]),
    StrokeColumn::of("ruffini_power", |s| s.receptor_power[3]),
    StrokeColumn::of("centroid_hz", |s| Some(s.centroid_hz)).shown("centroid, Hz"),
    StrokeColumn::of("spread_hz", |s| Some(s.spread_hz)),
    StrokeColumn::of("strongest_hz", |s| Some(s.strongest_hz)),
    StrokeColumn::of("friction_mean", |s| Some(s.friction_coefficient?.mean)),
    StrokeColumn::of("friction_sd", |s| Some(s.friction_coefficient?.sd)),
    StrokeColumn::of("friction_median", |s| Some(s.friction_coefficient?.median)),
    StrokeColumn::of("normal_force_mean_n", |s| Some(s.normal_force_n?.mean)),
    StrokeColumn::of("normal_force_sd_n", |s| Some(s.normal_force_n?.sd)),
    StrokeColumn::of("speed_mean_m_s", |s| Some(s.speed_m_s?.mean)),
    StrokeColumn::of("speed_sd_m_s", |s| Some(s.speed_m_s?.sd)),
    StrokeColumn::of("pacinian_power", |s| s.pacinian_power),
    StrokeColumn::of("detection_power", |s| s.detection_power),
    StrokeColumn::of("kurtosis", |s| Some(s.kurtosis)).shown("kurtosis"),
    StrokeColumn::of("level_spread_db", |s| s.level_spread_db).shown("spread of levels, dB"),
    StrokeColumn::of("meissner_level_db", |s| s.meissner_level_db),
    StrokeColumn::of("pacini_level_db", |s| s.pacini_level_db),
    StrokeColumn::of("meissner_from_hz", |s| s.meissner_from_hz),
    StrokeColumn::of("meissner_level_at_most_db", |s| s.meissner_level_at_most_db),
];

/// The features and spectra of the strokes of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// One for each stroke, in order.
    pub strokes: Vec<StrokeFeatures>,
    /// PSDs, u²/Hz.
    pub psd: StrokeSpectra,
    /// Amplitude spectra (the FFT of the thesis' figures) over as many samples as the shortest stroke has, u.
    pub fft: StrokeSpectra,
    /// The unit of the vibration.
    pub unit: Unit,
    /// How it was done.
    pub config: FeatureConfig,
    /// The lines that are there while nothing is touched, where they hold a part of the power of the strokes.
    pub rest_lines: Vec<RestLine>,
    /// The PSD while nothing is touched, with the lines of those of the strokes; absent where no rest is as long as one of their segments.
    pub rest_psd: Option<Vec<f64>>,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

impl Analysis {
    /// The mean speed of the strokes, m/s; `None` where none was measured.
    #[must_use]
    pub fn speed_m_s(&self) -> Option<f64> {
        let speeds: Vec<f64> = self
            .strokes
            .iter()
            .filter_map(|stroke| Some(stroke.speed_m_s?.mean))
            .collect();
        (!speeds.is_empty()).then(|| crate::statistics::mean(&speeds))
    }
}

/// The gesture's share of the power above which keeping it is a warning.
const GESTURE_SHARE: f64 = 0.1;

/// The features and spectra of the strokes of `recording`, as `segmentation` cut it: features for each stroke,
/// PSDs and amplitude spectra on common lines, in the unit of the vibration.
///
/// Source: L. Felicetti's thesis (2024), section 3.1: FFT, PSD, RMS and friction coefficient of every stroke, and
/// averages over strokes.
///
/// # Errors
/// [`FeatureError::NoStroke`] without strokes, [`FeatureError::NoVibration`] without a channel of vibration, and
/// those of filters and spectra.
pub fn analyse(
    recording: &Recording,
    segmentation: &Segmentation,
    config: &FeatureConfig,
) -> Result<Analysis, FeatureError> {
    let rate = Signals::of(recording, &segmentation.roles)?.rate;
    let (segmentation, left_out) = long_enough(segmentation, config, rate);
    let shortest = shortest(&segmentation);
    let mut analysis = measured(recording, &segmentation, config, shortest)?;
    analysis.conclude(&segmentation, left_out)?;
    Ok(analysis)
}

/// `segmentation` without the strokes that are shorter than a segment of the PSDs, and the warning about them; all of them where none is long
/// enough.
pub(crate) fn long_enough(
    segmentation: &Segmentation,
    config: &FeatureConfig,
    rate: SampleRate,
) -> (Segmentation, Option<Warning>) {
    let (long, short): (Vec<Stroke>, Vec<Stroke>) = segmentation
        .strokes
        .iter()
        .cloned()
        .partition(|stroke| stroke.steady.len() >= config.welch.segment);
    let is_some = !short.is_empty() && !long.is_empty();
    let left_out = is_some.then(|| {
        Warning::from(StrokeWarning::UnusualStroke {
            what: Unusual::LeftOut {
                count: short.len(),
                needed_s: config.welch.segment as f64 / rate.hz(),
            },
        })
    });
    let strokes = match long.is_empty() {
        // Then the first is refused with its length.
        true => segmentation.strokes.clone(),
        false => long,
    };
    let kept = Segmentation {
        strokes,
        ..segmentation.clone()
    };
    (kept, left_out)
}

/// The samples of the shortest stroke.
pub(crate) fn shortest(segmentation: &Segmentation) -> usize {
    let lengths = segmentation.strokes.iter().map(|s| s.steady.len());
    lengths.min().unwrap_or(0)
}

/// As [`analyse`], of strokes that are long enough, with amplitude spectra over the middle `shortest` samples of each, and without the warnings
/// that are about all strokes together.
pub(crate) fn measured(
    recording: &Recording,
    segmentation: &Segmentation,
    config: &FeatureConfig,
    shortest: usize,
) -> Result<Analysis, FeatureError> {
    let signals = Signals::of(recording, &segmentation.roles)?;
    if segmentation.strokes.is_empty() {
        return Err(FeatureError::NoStroke);
    }
    let Vibrations {
        unit,
        names,
        channels: vibrations,
        mut warnings,
    } = vibrations(recording, segmentation, config.high_pass)?;
    let vibrations: Vec<&[f64]> = vibrations.iter().map(Vec::as_slice).collect();
    warnings.extend(clipped(recording, segmentation));
    let longest = segmentation.strokes.iter().map(|s| s.steady.len()).max();
    // A segment longer than every stroke is refused before anything of its length is made.
    if let Some(found) = longest.filter(|found| *found < config.welch.segment) {
        return Err(FeatureError::Estimate(EstimateError::TooShort {
            expected: config.welch.segment,
            found,
        }));
    }
    let mut plan = FeaturePlan::new(config, signals.rate, unit.clone())?;
    let mut strokes = Vec::with_capacity(segmentation.strokes.len());
    let mut psds = Vec::with_capacity(segmentation.strokes.len());
    let mut low = LowFrequencies::new(config, signals.rate, &unit);
    let recorded: Vec<&[f64]> = recording
        .channels()
        .iter()
        .filter(|c| segmentation.roles.vibration.contains(&c.name) && !never_changes(&c.samples))
        .map(|c| c.samples.as_slice())
        .collect();
    for stroke in &segmentation.strokes {
        let (mut features, psd) = plan.of(&vibrations, &signals, segmentation, stroke)?;
        if let Some(low) = &mut low {
            features.add(low.of(&vibrations, &recorded, stroke.steady)?);
        }
        strokes.push(features);
        psds.push(psd);
    }
    let resolution_hz = signals.rate.hz() / config.welch.segment as f64;
    if config.high_pass.is_none() {
        warnings.extend(gesture_kept(&vibrations, segmentation, signals.rate));
    }
    let mut rest_lines = Vec::new();
    for (name, samples) in names.iter().zip(&vibrations) {
        if let Some((lines, warning)) =
            rest::of_channel((name, samples), segmentation, signals.rate)
        {
            rest_lines.extend(lines);
            warnings.push(warning);
        }
    }
    Ok(Analysis {
        rest_psd: rest::psd(&vibrations, segmentation, (&config.welch, signals.rate))?,
        rest_lines,
        fft: amplitudes(&vibrations, segmentation, (signals.rate, &unit, shortest))?,
        psd: StrokeSpectra::over(psds, resolution_hz, unit.of_psd()),
        strokes,
        unit,
        config: config.clone(),
        warnings,
    })
}

impl Analysis {
    /// Adds the warnings about all strokes together: those that were `left_out`, how few segments there are, what changes from stroke to stroke.
    pub(crate) fn conclude(
        &mut self,
        segmentation: &Segmentation,
        left_out: Option<Warning>,
    ) -> Result<(), FeatureError> {
        self.warnings.splice(0..0, left_out);
        self.warnings.extend(over_strokes::warnings(&self.strokes));
        let welch = &self.config.welch;
        let hop = welch.hop()?;
        let lengths = segmentation.strokes.iter().map(|s| s.steady.len());
        let segments: usize = lengths.map(|n| segments_in(n, welch.segment, hop)).sum();
        if segments < RECOMMENDED_SEGMENTS {
            self.warnings.push(Warning::from(FewWarning::Few {
                found: segments.max(1),
                recommended: RECOMMENDED_SEGMENTS,
                what: Few::Segments,
            }));
        }
        Ok(())
    }

    /// Gives up the spectra of single strokes.
    pub(crate) fn without_single_spectra(mut self) -> Self {
        self.psd.each = Vec::new();
        self.fft.each = Vec::new();
        self
    }

    /// Joins what was measured of a later section of the same recording: means and standard deviations of spectra are those over all strokes.
    ///
    /// Source: T. F. Chan, G. H. Golub and R. J. Le Veque (1983), Am. Stat. 37, for means and variances of two sets.
    pub(crate) fn join(&mut self, mut later: Self) {
        let counts = [self.strokes.len(), later.strokes.len()];
        self.psd.join(&later.psd, counts);
        self.fft.join(&later.fft, counts);
        let [own, its] = counts.map(|count| count as f64);
        self.rest_psd = match (self.rest_psd.take(), later.rest_psd.take()) {
            (Some(mut a), Some(b)) => {
                for (a, b) in a.iter_mut().zip(b) {
                    *a = (own * *a + its * b) / (own + its);
                }
                Some(a)
            }
            (a, b) => a.or(b),
        };
        for line in later.rest_lines {
            let near = |known: &&mut RestLine| {
                (known.frequency_hz - line.frequency_hz).abs() < self.psd.resolution_hz
            };
            match self.rest_lines.iter_mut().find(near) {
                Some(known) if known.mean_square < line.mean_square => *known = line,
                Some(_) => {}
                None => self.rest_lines.push(line),
            }
        }
        self.strokes.extend(later.strokes);
        self.warnings.extend(later.warnings);
    }
}

/// The warnings about channels that are clipped within a stroke.
fn clipped(recording: &Recording, segmentation: &Segmentation) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for name in &segmentation.roles.vibration {
        let Some(channel) = recording.channels().iter().find(|c| c.name == *name) else {
            continue;
        };
        let rails = Rails::of(&channel.samples);
        let clipped = segmentation
            .strokes
            .iter()
            .map(|s| rails.share(s.steady.of(&channel.samples)));
        let fraction = clipped.fold(0.0, f64::max);
        if fraction > 0.0 {
            warnings.push(Warning::from(ClippingWarning::Clipped {
                signal: format!("`{name}` in a stroke"),
                at: ClippedAt::Recorded { fraction },
            }));
        }
    }
    warnings
}

/// The channels that vibrate, freed of the gesture.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibrations {
    pub unit: Unit,
    /// Their names.
    pub names: Vec<String>,
    /// Their samples, as long as the recording.
    pub channels: Vec<Vec<f64>>,
    /// Channels that were left out.
    pub warnings: Vec<Warning>,
}

/// The channels of `recording` that vibrate, as long as the recording and in its unit, filtered by `high_pass`;
/// channels that never change are left out.
///
/// Source: [`ZeroPhase`].
///
/// # Errors
/// [`FeatureError::NoVibration`] without a channel of vibration, [`FeatureError::ConstantVibration`] when none changes, [`FeatureError::Series`] for a filter that cannot be.
pub fn vibrations(
    recording: &Recording,
    segmentation: &Segmentation,
    high_pass: Option<HighPass>,
) -> Result<Vibrations, FeatureError> {
    let roles = &segmentation.roles;
    let rate = roles.rate_in(recording)?;
    let filter = match high_pass {
        Some(high_pass) => Some(ZeroPhase::high_pass(high_pass, rate)?),
        None => None,
    };
    let (mut channels, mut names) = (Vec::new(), Vec::new());
    let (mut warnings, mut unit) = (Vec::new(), None);
    for name in &segmentation.roles.vibration {
        let channel = recording.pick(Some(name), &Unit::MetrePerSecondSquared)?;
        let first = channel.samples.first().copied().unwrap_or(0.0);
        if channel.samples.iter().all(|v| (v - first).abs() <= 0.0) {
            warnings.push(Warning::from(SignalWarning::Channel {
                channel: name.clone(),
                fault: ChannelFault::Dead,
            }));
            continue;
        }
        match &unit {
            None => unit = Some(channel.unit.clone()),
            Some(first) if *first != channel.unit => {
                return Err(FeatureError::Units {
                    first: first.clone(),
                    channel: name.clone(),
                    found: channel.unit.clone(),
                });
            }
            Some(_) => {}
        }
        names.push(name.clone());
        channels.push(match &filter {
            Some(filter) => filter.apply(&channel.samples),
            None => channel.samples.clone(),
        });
    }
    Ok(Vibrations {
        unit: unit.ok_or_else(|| no_vibration(recording, &segmentation.roles))?,
        names,
        channels,
        warnings,
    })
}

/// Why nothing vibrates: no channel is one of vibration, or all that are never change.
fn no_vibration(recording: &Recording, roles: &Roles) -> FeatureError {
    match roles.vibration.as_slice() {
        [] => FeatureError::NoVibration {
            channels: recording
                .channels()
                .iter()
                .map(|channel| format!("`{}` ({})", channel.name, channel.unit))
                .collect(),
        },
        named => FeatureError::ConstantVibration {
            channels: named.iter().map(|name| format!("`{name}`")).collect(),
        },
    }
}

/// The warning that what lies below 5 Hz was kept and is a tenth of the power or more.
fn gesture_kept(
    vibrations: &[&[f64]],
    segmentation: &Segmentation,
    rate: SampleRate,
) -> Option<Warning> {
    let high_pass = HighPass::gesture();
    // At low rates there is no vibration above the gesture to be told from it.
    if rate.hz() < 40.0 * high_pass.cutoff_hz.0 {
        return None;
    }
    let filter = ZeroPhase::high_pass(high_pass, rate).ok()?;
    let (mut all, mut fast) = (0.0, 0.0);
    for vibration in vibrations {
        let filtered = filter.apply(vibration);
        for stroke in &segmentation.strokes {
            all += variance(stroke.steady.of(vibration)) * stroke.steady.len() as f64;
            fast += variance(stroke.steady.of(&filtered)) * stroke.steady.len() as f64;
        }
    }
    let share = 1.0 - fast / all;
    (share > GESTURE_SHARE).then_some(Warning::from(FeatureWarning::GestureKept {
        share,
        below_hz: high_pass.cutoff_hz.0,
    }))
}

fn variance(samples: &[f64]) -> f64 {
    let mean = crate::statistics::mean(samples);
    samples.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / samples.len().max(1) as f64
}

/// Amplitude spectra over the middle of every stroke, `shortest` samples; of several channels the root of the mean of their squares.
fn amplitudes(
    vibrations: &[&[f64]],
    segmentation: &Segmentation,
    (rate, unit, shortest): (SampleRate, &Unit, usize),
) -> Result<StrokeSpectra, FeatureError> {
    let strokes = &segmentation.strokes;
    let mut each = Vec::with_capacity(strokes.len());
    for stroke in strokes {
        let from = stroke.steady.start + (stroke.steady.len() - shortest) / 2;
        let middle = Interval {
            start: from,
            end: from + shortest,
        };
        let mut squares: Vec<f64> = Vec::new();
        for vibration in vibrations {
            let samples = middle.of(vibration);
            let mean = crate::statistics::mean(samples);
            let series = crate::series::Series::<Uncalibrated>::new(
                samples.iter().map(|v| v - mean).collect(),
                rate,
            )?;
            let (_, amplitudes) = amplitude_spectrum(&series);
            squares.resize(amplitudes.len(), 0.0);
            for (square, amplitude) in squares.iter_mut().zip(amplitudes) {
                *square += amplitude * amplitude / vibrations.len() as f64;
            }
        }
        each.push(squares.into_iter().map(f64::sqrt).collect());
    }
    Ok(StrokeSpectra::over(
        each,
        rate.hz() / shortest.max(1) as f64,
        unit.to_string(),
    ))
}

/// Why strokes have no features.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// There is no stroke.
    #[error("there is no stroke: look at what was rejected, and why")]
    NoStroke,
    /// No channel is one of vibration.
    #[error(
        "expected a channel of vibration (in m/s² or g, or without a role), found {}; record the acceleration, state the unit of its channel, or \
            name the channel",
        first_of(channels, ", ")
    )]
    NoVibration {
        /// All channels, with their units.
        channels: Vec<String>,
    },
    /// The channels of vibration never change.
    #[error(
        "expected a channel of vibration that changes, found one value throughout in {}; check its cable, or name another channel",
        first_of(channels, ", ")
    )]
    ConstantVibration {
        /// The channels.
        channels: Vec<String>,
    },
    /// Channels of several quantities.
    #[error(
        "expected vibrations in one unit, found {first} and `{channel}` in {found}; name channels of one kind"
    )]
    Units {
        /// The unit of the first channel.
        first: Unit,
        channel: String,
        found: Unit,
    },
    /// The numbers overflow.
    #[error("expected samples whose squares can be summed, found an overflow; check the scale")]
    TooLarge,
    /// The channels are not what they should be.
    #[error(transparent)]
    Signals(#[from] SegmentError),
    /// A channel is not there.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A spectrum cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// A number that cannot be.
    #[error(transparent)]
    Quantity(#[from] crate::quantity::QuantityError),
    /// Samples that make no series, or cannot be filtered.
    #[error(transparent)]
    Series(#[from] crate::series::SeriesError),
}
