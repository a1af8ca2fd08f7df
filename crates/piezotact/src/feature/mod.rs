//! What the strokes of a recording say: level, spectrum, friction, and what a person can feel of them.

mod peaks;
mod weighting;

use serde::{Deserialize, Serialize};

pub(crate) use peaks::vertex;
pub use peaks::{Peak, peaks};
pub use weighting::{Receptor, Weighting};

use crate::doubt::Doubt;
use crate::filter::{FilterError, HighPass, ZeroPhase};
use crate::quantity::{Band, Hertz, SampleRate, Uncalibrated, Unit};
use crate::recording::{Recording, RecordingError};
use crate::series::is_sample;
use crate::spectrum::{
    EstimateError, RECOMMENDED_SEGMENTS, WelchConfig, WelchPlan, amplitude_spectrum, segments_in,
};
use crate::stroke::{Interval, SegmentError, Segmentation, Signals, Stroke, stroke_speed_m_s};
use crate::verify::flat_top_fraction;

/// Fewer strokes than this in an average are a doubt.
///
/// Source: the protocol of the 2024 thesis, section 3.1: averages over at least ten explorations.
pub const RECOMMENDED_STROKES: usize = 10;

/// How features are computed. It is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeatureConfig {
    /// What takes the gesture away from the vibration; none leaves it.
    pub high_pass: Option<HighPass>,
    /// How PSDs are estimated.
    pub welch: WelchConfig,
    /// The band for peaks, centroid, spread and weighted powers.
    pub band: Band,
}

impl FeatureConfig {
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
            band: Band::new(Hertz(low_hz), Hertz(high_hz)).map_err(FeatureError::Quantity)?,
        })
    }
}

/// Mean, standard deviation and median of something over a stroke, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, n − 1 in the denominator.
    pub sd: f64,
    /// The median.
    pub median: f64,
}

impl Statistics {
    /// The statistics of `values`; `None` for none. The order of `values` changes.
    ///
    /// Source: sample mean, √(Σ(x − x̄)²/(n − 1)), middle value (the mean of the middle two for an even count).
    #[must_use]
    pub fn of(values: &mut [f64]) -> Option<Self> {
        let median = crate::order::median(values)?;
        let Moments { mean, sd } = Moments::of(values)?;
        Some(Self { mean, sd, median })
    }
}

/// Mean and standard deviation of something over a stroke, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, n − 1 in the denominator.
    pub sd: f64,
}

impl Moments {
    /// The moments of `values`; `None` for none.
    ///
    /// Source: sample mean, √(Σ(x − x̄)²/(n − 1)).
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        if n == 0 {
            return None;
        }
        let mean = sum(values) / n as f64;
        let (squares, _) = squares_and_peak(values, mean);
        Some(Self {
            mean,
            sd: (squares / (n.max(2) - 1) as f64).sqrt(),
        })
    }
}

/// The features of one stroke. What was not measured is absent. `u` is the unit of the vibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// The power in the bands of the four mechanoreceptors, u², in the order of [`Receptor::ALL`].
    pub receptor_power: [f64; 4],
    /// The mean frequency of the power in the band, Hz.
    pub centroid_hz: f64,
    /// The standard deviation of frequency around it, Hz.
    pub spread_hz: f64,
    /// The strongest line in the band, Hz.
    pub strongest_hz: f64,
    /// Peaks above the background, the strongest first.
    pub peaks: Vec<Peak>,
    /// √(Fx² + Fy²)/Fz, sample by sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_coefficient: Option<Statistics>,
    /// The normal force above its zero, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_force_n: Option<Moments>,
    /// The magnitude of the speed, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<Moments>,
    /// Power weighted by the Pacinian threshold; for accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pacinian_power: Option<f64>,
    /// Power weighted by the detection threshold; for accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection_power: Option<f64>,
}

/// A spectrum of every stroke, with mean and standard deviation over strokes line by line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrokeSpectra {
    /// The step between lines, Hz; the first lies at 0 Hz.
    pub resolution_hz: f64,
    /// One spectrum for each stroke.
    pub each: Vec<Vec<f64>>,
    /// Their mean.
    pub mean: Vec<f64>,
    /// Their standard deviation, n − 1 in the denominator; 0 for one stroke.
    pub sd: Vec<f64>,
}

impl StrokeSpectra {
    /// The spectra `each`, all of one length, with their mean and standard deviation.
    ///
    /// Source: sample mean and standard deviation over strokes, of powers or amplitudes, not of decibels.
    #[must_use]
    pub fn over(each: Vec<Vec<f64>>, resolution_hz: f64) -> Self {
        let count = each.len();
        let lines = each.first().map_or(0, Vec::len);
        let mut mean = vec![0.0; lines];
        for spectrum in &each {
            for (sum, value) in mean.iter_mut().zip(spectrum) {
                *sum += value / count as f64;
            }
        }
        let mut sd = vec![0.0; lines];
        for spectrum in &each {
            for ((sum, value), mean) in sd.iter_mut().zip(spectrum).zip(&mean) {
                *sum += (value - mean) * (value - mean);
            }
        }
        for sum in &mut sd {
            *sum = (*sum / (count.max(2) - 1) as f64).sqrt();
        }
        Self {
            resolution_hz,
            each,
            mean,
            sd,
        }
    }

    /// The frequency of every line, Hz.
    #[must_use]
    pub fn frequencies_hz(&self) -> Vec<f64> {
        crate::spectrum::frequency_axis(self.resolution_hz, self.mean.len())
    }
}

/// What the strokes of one recording say.
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
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

/// The gesture's share of the power above which keeping it is a doubt.
const GESTURE_SHARE: f64 = 0.1;

/// The features and spectra of the strokes of `recording`, as `segmentation` cut it: features for each stroke,
/// PSDs and amplitude spectra on common lines, in the unit of the vibration.
///
/// Source: L. Felicetti's thesis (2024), section 3.1: FFT, PSD, RMS and friction coefficient of every stroke, and
/// averages over strokes.
///
/// # Errors
/// [`FeatureError::NoStroke`] without strokes, [`FeatureError::NoVibration`] without a channel that vibrates, and
/// those of filters and spectra.
pub fn analyse(
    recording: &Recording,
    segmentation: &Segmentation,
    config: &FeatureConfig,
) -> Result<Analysis, FeatureError> {
    let signals = Signals::of(recording, &segmentation.roles).map_err(FeatureError::Signals)?;
    if segmentation.strokes.is_empty() {
        return Err(FeatureError::NoStroke);
    }
    let Vibrations {
        unit,
        channels: vibrations,
        mut doubts,
    } = vibrations(recording, segmentation, config.high_pass)?;
    let vibrations: Vec<&[f64]> = vibrations.iter().map(Vec::as_slice).collect();
    let (long, short): (Vec<Stroke>, Vec<Stroke>) = segmentation
        .strokes
        .iter()
        .cloned()
        .partition(|stroke| stroke.steady.len() >= config.welch.segment);
    if !short.is_empty() && !long.is_empty() {
        doubts.push(Doubt::ShortStrokes {
            count: short.len(),
            needed_s: config.welch.segment as f64 / recording.rate().hz(),
        });
    }
    let segmentation = &match long.as_slice() {
        // Then the first is refused with its length.
        [] => segmentation.clone(),
        _ => Segmentation {
            strokes: long,
            ..segmentation.clone()
        },
    };
    for name in &segmentation.roles.vibration {
        let Some(channel) = recording.channels().iter().find(|c| c.name == *name) else {
            continue;
        };
        let clipped = segmentation
            .strokes
            .iter()
            .map(|s| flat_top_fraction(s.steady.of(&channel.samples)));
        let fraction = clipped.fold(0.0, f64::max);
        let known = recording
            .doubts
            .iter()
            .any(|doubt| matches!(doubt, Doubt::Clipped { .. }));
        if fraction > 0.0 && !known {
            doubts.push(Doubt::Clipped {
                what: format!("`{name}` in a stroke"),
                fraction,
            });
        }
    }
    let mut plan = FeaturePlan::new(config, recording.rate(), unit.clone())?;
    let mut strokes = Vec::with_capacity(segmentation.strokes.len());
    let mut psds = Vec::with_capacity(segmentation.strokes.len());
    for stroke in &segmentation.strokes {
        let (features, psd) = plan.of(&vibrations, &signals, segmentation, stroke)?;
        strokes.push(features);
        psds.push(psd);
    }
    let resolution_hz = recording.rate().hz() / config.welch.segment as f64;
    let hop = config.welch.hop().map_err(FeatureError::Estimate)?;
    let segments: usize = segmentation
        .strokes
        .iter()
        .map(|s| segments_in(s.steady.len(), config.welch.segment, hop))
        .sum();
    if segments < RECOMMENDED_SEGMENTS {
        doubts.push(Doubt::ShortSignal {
            segments: segments.max(1),
        });
    }
    if config.high_pass.is_none() {
        doubts.extend(gesture_kept(&vibrations, segmentation, recording.rate()));
    }
    Ok(Analysis {
        fft: amplitudes(&vibrations, segmentation, recording.rate())?,
        psd: StrokeSpectra::over(psds, resolution_hz),
        strokes,
        unit,
        config: config.clone(),
        doubts,
    })
}

/// The channels that vibrate, freed of the gesture.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibrations {
    /// Their unit.
    pub unit: Unit,
    /// Their samples, as long as the recording.
    pub channels: Vec<Vec<f64>>,
    /// Channels that were left out.
    pub doubts: Vec<Doubt>,
}

/// The channels of `recording` that vibrate, as long as the recording and in its unit, filtered by `high_pass`;
/// channels that never change are left out.
///
/// Source: [`ZeroPhase`].
///
/// # Errors
/// [`FeatureError::NoVibration`] when none is left, [`FeatureError::Filter`] for a filter that cannot be.
pub fn vibrations(
    recording: &Recording,
    segmentation: &Segmentation,
    high_pass: Option<HighPass>,
) -> Result<Vibrations, FeatureError> {
    let filter = match high_pass {
        Some(high_pass) => {
            Some(ZeroPhase::high_pass(high_pass, recording.rate()).map_err(FeatureError::Filter)?)
        }
        None => None,
    };
    let (mut channels, mut doubts, mut unit) = (Vec::new(), Vec::new(), None);
    for name in &segmentation.roles.vibration {
        let channel = recording
            .pick(Some(name), &Unit::MetrePerSecondSquared)
            .map_err(FeatureError::Recording)?;
        let first = channel.samples.first().copied().unwrap_or(0.0);
        if channel.samples.iter().all(|v| (v - first).abs() <= 0.0) {
            doubts.push(Doubt::DeadChannel {
                channel: name.clone(),
            });
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
        channels.push(match &filter {
            Some(filter) => filter.apply(&channel.samples),
            None => channel.samples.clone(),
        });
    }
    Ok(Vibrations {
        unit: unit.ok_or(FeatureError::NoVibration)?,
        channels,
        doubts,
    })
}

/// The doubt that what lies below 5 Hz was kept and is a tenth of the power or more.
fn gesture_kept(
    vibrations: &[&[f64]],
    segmentation: &Segmentation,
    rate: SampleRate,
) -> Option<Doubt> {
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
    (share > GESTURE_SHARE).then_some(Doubt::GestureKept {
        share,
        below_hz: high_pass.cutoff_hz.0,
    })
}

fn variance(samples: &[f64]) -> f64 {
    let mean = crate::series::mean(samples);
    samples.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / samples.len().max(1) as f64
}

/// Amplitude spectra over the middle of every stroke, as many samples as the shortest one has; of several channels
/// the root of the mean of their squares.
fn amplitudes(
    vibrations: &[&[f64]],
    segmentation: &Segmentation,
    rate: SampleRate,
) -> Result<StrokeSpectra, FeatureError> {
    let strokes = &segmentation.strokes;
    let shortest = strokes.iter().map(|s| s.steady.len()).min().unwrap_or(0);
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
            let mean = crate::series::mean(samples);
            let series = crate::series::Series::<Uncalibrated>::new(
                samples.iter().map(|v| v - mean).collect(),
                rate,
            )
            .map_err(FeatureError::Series)?;
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
    ))
}

/// A planned computation of features: window, transform and memory, made once for all strokes.
#[derive(Clone, Debug)]
pub struct FeaturePlan {
    welch: WelchPlan,
    config: FeatureConfig,
    rate: SampleRate,
    /// What every line's density is multiplied by for the Pacinian and the detection-threshold power; absent for a
    /// vibration that is no acceleration.
    weights: Option<[Vec<f64>; 2]>,
    ratio: Vec<f64>,
    force: Vec<f64>,
}

impl FeaturePlan {
    /// A plan for vibrations in `unit` at `rate`.
    ///
    /// # Errors
    /// [`FeatureError::Estimate`] when the PSD's configuration cannot be.
    pub fn new(config: &FeatureConfig, rate: SampleRate, unit: Unit) -> Result<Self, FeatureError> {
        let resolution_hz = rate.hz() / config.welch.segment as f64;
        let bins = config.welch.segment / 2 + 1;
        // A band that ends below 500 Hz holds only part of what the Pacinian channel feels.
        let felt = unit == Unit::MetrePerSecondSquared && rate.nyquist().0 > 500.0;
        let weights = felt.then(|| {
            [Weighting::Pacinian, Weighting::DetectionThreshold]
                .map(|weighting| weighting.line_weights(bins, resolution_hz, config.band))
        });
        Ok(Self {
            welch: WelchPlan::new(&config.welch, rate).map_err(FeatureError::Estimate)?,
            config: config.clone(),
            rate,
            weights,
            ratio: Vec::new(),
            force: Vec::new(),
        })
    }

    /// The features of `stroke` and its PSD in u²/Hz, from the (filtered) `vibrations` and the forces and motion
    /// in `signals`.
    ///
    /// # Errors
    /// [`FeatureError::Estimate`] when the stroke is shorter than a segment, [`FeatureError::TooLarge`] when the
    /// numbers overflow.
    pub fn of(
        &mut self,
        vibrations: &[&[f64]],
        signals: &Signals<'_>,
        segmentation: &Segmentation,
        stroke: &Stroke,
    ) -> Result<(StrokeFeatures, Vec<f64>), FeatureError> {
        let steady = stroke.steady;
        let (mut square, mut peak) = (0.0, 0.0f64);
        let mut psd: Vec<f64> = Vec::new();
        for vibration in vibrations {
            let samples = steady.of(vibration);
            let mean = crate::series::mean(samples);
            let (sum, largest) = squares_and_peak(samples, mean);
            square += sum / samples.len().max(1) as f64;
            peak = peak.max(largest);
            let spectrum = self
                .welch
                .estimate::<Uncalibrated>(&[samples])
                .map_err(FeatureError::Estimate)?;
            if psd.is_empty() {
                psd = spectrum.values;
            } else {
                for (sum, value) in psd.iter_mut().zip(spectrum.values) {
                    *sum += value;
                }
            }
        }
        let channels = vibrations.len().max(1) as f64;
        if vibrations.len() > 1 {
            for value in &mut psd {
                *value /= channels;
            }
        }
        let rms = (square / channels).sqrt();
        if !is_sample(rms) {
            return Err(FeatureError::TooLarge);
        }
        let resolution_hz = self.rate.hz() / self.config.welch.segment as f64;
        let shape = Shape::of(&psd, resolution_hz, self.config.band);
        let weighted = |which: usize| {
            let weights = &self.weights.as_ref()?[which];
            Some(psd.iter().zip(weights).map(|(p, w)| p * w).sum())
        };
        let (pacinian_power, detection_power) = (weighted(0), weighted(1));
        let mut receptor_power = [0.0; 4];
        for (power, receptor) in receptor_power.iter_mut().zip(Receptor::ALL) {
            let band = receptor.band().map_err(FeatureError::Quantity)?;
            *power = band_power(&psd, resolution_hz, band);
        }
        let (friction_coefficient, normal_force_n) = self.forces(signals, segmentation, steady);
        let features = StrokeFeatures {
            start_s: steady.start as f64 / self.rate.hz(),
            duration_s: steady.len() as f64 / self.rate.hz(),
            rms,
            peak,
            crest_factor: if rms > 0.0 { peak / rms } else { 0.0 },
            receptor_power,
            centroid_hz: shape.centroid_hz,
            spread_hz: shape.spread_hz,
            strongest_hz: shape.strongest_hz,
            peaks: peaks(&psd, resolution_hz, self.config.band),
            friction_coefficient,
            normal_force_n,
            speed_m_s: signals.motion.and_then(|(motion, kind)| {
                Moments::of(&stroke_speed_m_s(signals.rate, motion, kind, steady))
            }),
            pacinian_power,
            detection_power,
        };
        Ok((features, psd))
    }

    fn forces(
        &mut self,
        signals: &Signals<'_>,
        segmentation: &Segmentation,
        steady: Interval,
    ) -> (Option<Statistics>, Option<Moments>) {
        let Some(normal_n) = signals.normal_force_n else {
            return (None, None);
        };
        let zero = |axis: usize| {
            segmentation
                .force_zeros
                .as_ref()
                .map_or(0.0, |zeros| zeros.at(axis, (steady.start + steady.end) / 2))
        };
        let sign = segmentation.force_zeros.as_ref().map_or(1.0, |z| z.sign);
        let normal_zero = zero(0);
        self.force.clear();
        self.force
            .extend(steady.of(normal_n).iter().map(|v| v * sign - normal_zero));
        self.ratio.clear();
        let axes: Vec<(&[f64], f64)> = signals
            .tangential_force_n
            .iter()
            .enumerate()
            .map(|(i, axis)| (steady.of(axis), zero(i + 1)))
            .collect();
        self.ratio
            .resize(if axes.is_empty() { 0 } else { self.force.len() }, 0.0);
        let (ratio, force) = (&mut self.ratio, &self.force);
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for (axis, zero) in &axes {
                    for (square, value) in ratio.iter_mut().zip(*axis) {
                        *square += (value - zero) * (value - zero);
                    }
                }
                for (square, normal) in ratio.iter_mut().zip(force) {
                    *square = square.sqrt() / normal.max(1e-6);
                }
            },
        );
        {
            let force = Moments::of(&self.force);
            // What hardly touches has no friction coefficient, nor what is off the surface now and then.
            let off = self.force.iter().filter(|n| **n < LEAST_NORMAL_N).count();
            let touches = 50 * off <= self.force.len();
            (Statistics::of(&mut self.ratio).filter(|_| touches), force)
        }
    }
}

/// A stroke with less normal force than this has no friction coefficient, N.
const LEAST_NORMAL_N: f64 = 0.01;

/// A sum in independent lanes.
fn sum(values: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        for (sum, value) in sums.iter_mut().zip(chunk) {
            *sum += value;
        }
    }
    sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

/// The sum of squared departures from `mean`, and the largest of them, in independent lanes.
fn squares_and_peak(samples: &[f64], mean: f64) -> (f64, f64) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || squares_and_peak_in_lanes(samples, mean),
    )
}

#[inline(always)]
fn squares_and_peak_in_lanes(samples: &[f64], mean: f64) -> (f64, f64) {
    const LANES: usize = 8;
    let (mut sums, mut tops) = ([0.0; LANES], [0.0f64; LANES]);
    let (chunks, rest) = samples.as_chunks::<LANES>();
    for chunk in chunks {
        for ((sum, top), value) in sums.iter_mut().zip(&mut tops).zip(chunk) {
            let off = value - mean;
            *sum += off * off;
            *top = top.max(off.abs());
        }
    }
    let rest = rest.iter().map(|v| v - mean);
    (
        sums.iter().sum::<f64>() + rest.clone().map(|v| v * v).sum::<f64>(),
        tops.into_iter()
            .chain(rest.map(f64::abs))
            .fold(0.0, f64::max),
    )
}

/// The power of a one-sided PSD with lines `resolution_hz` apart from 0 Hz within `band`, unit².
///
/// Formula: Σ S(f)·Δf over low ≤ f < high.
///
/// Source: Parseval's theorem for a density.
#[must_use]
pub fn band_power(psd: &[f64], resolution_hz: f64, band: Band) -> f64 {
    let lines = lines_in(psd, resolution_hz, band);
    psd[lines].iter().sum::<f64>() * resolution_hz
}

/// The lines of a spectrum with low ≤ f < high.
fn lines_in(psd: &[f64], resolution_hz: f64, band: Band) -> std::ops::Range<usize> {
    let line = |hz: f64| ((hz / resolution_hz - 1e-9).ceil().max(0.0) as usize).min(psd.len());
    let (from, to) = (line(band.low().0), line(band.high().0));
    from.min(to)..to
}

/// Where the power of a spectrum lies.
struct Shape {
    centroid_hz: f64,
    spread_hz: f64,
    strongest_hz: f64,
}

impl Shape {
    fn of(psd: &[f64], resolution_hz: f64, band: Band) -> Self {
        let lines = lines_in(psd, resolution_hz, band);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        let mut strongest = (0, f64::MIN);
        for k in lines {
            let f = k as f64 * resolution_hz;
            sum += psd[k];
            first += psd[k] * f;
            second += psd[k] * f * f;
            if psd[k] > strongest.1 {
                strongest = (k, psd[k]);
            }
        }
        let sum = if sum > 0.0 { sum } else { 1.0 };
        let centroid_hz = first / sum;
        Self {
            centroid_hz,
            spread_hz: (second / sum - centroid_hz * centroid_hz).max(0.0).sqrt(),
            strongest_hz: strongest.0 as f64 * resolution_hz,
        }
    }
}

/// Why strokes have no features.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// There is no stroke.
    #[error(
        "expected at least one stroke, found none; look at what was rejected with `piezotact segment`"
    )]
    NoStroke,
    /// There is no vibration.
    #[error(
        "expected a channel that vibrates, found none that changes; name one with --vibration or check its cable"
    )]
    NoVibration,
    /// Channels of several quantities.
    #[error(
        "expected vibrations in one unit, found {first} and `{channel}` in {found}; name channels of one kind with --vibration"
    )]
    Units {
        /// The unit of the first channel.
        first: Unit,
        /// Another channel.
        channel: String,
        /// Its unit.
        found: Unit,
    },
    /// The numbers overflow.
    #[error("expected samples whose squares can be summed, found an overflow; check the scale")]
    TooLarge,
    /// The channels are not what they should be.
    #[error("{0}")]
    Signals(SegmentError),
    /// A channel is not there.
    #[error("{0}")]
    Recording(RecordingError),
    /// The filter cannot be.
    #[error("{0}")]
    Filter(FilterError),
    /// A spectrum cannot be estimated.
    #[error("{0}")]
    Estimate(EstimateError),
    /// A number that cannot be.
    #[error("{0}")]
    Quantity(crate::quantity::QuantityError),
    /// Samples that make no series.
    #[error("{0}")]
    Series(crate::series::SeriesError),
}
