//! The features of one stroke after the other, planned once.

use super::forces::{self, Touch};
use super::low::LowFrequencies;
use super::statistics::{Moments, Statistics, squares_and_peak};
use super::{FeatureConfig, FeatureError, Receptor, StrokeFeatures, Weighting, peaks};
use crate::quantity::{Band, Decibels, Hertz, SampleRate, Seconds, Uncalibrated, Unit};
use crate::series::is_sample;
use crate::spectrum::WelchPlan;
use crate::statistics::LevelSpread;
use crate::stroke::{Interval, Segmentation, Signals, Stroke, stroke_speed_m_s};

/// Levels are compared over windows of this length, as scores and verifications do.
const SHORT_TIME: Seconds = Seconds(0.1);
/// A level re the threshold of a receptor is given where the analysis holds at least this share of the receptor's band.
const LEAST_OF_A_BAND: f64 = 0.5;
/// What is silent counts as so much less than the mean power.
const SILENT: f64 = 0.01;

/// The sum of the fourth powers of departures from `mean`; the sum of squares of each window of `window` samples is added to
/// `short`.
fn fourth_powers(samples: &[f64], mean: f64, window: usize, short: &mut [f64]) -> f64 {
    let mut fourth = 0.0;
    let mut windows = short.iter_mut();
    for part in samples.chunks(window) {
        let (mut squares, mut fourths) = ([0.0; 8], [0.0; 8]);
        for (i, value) in part.iter().enumerate() {
            let square = (value - mean) * (value - mean);
            squares[i % 8] += square;
            fourths[i % 8] += square * square;
        }
        fourth += fourths.iter().sum::<f64>();
        if let (true, Some(sum)) = (part.len() == window, windows.next()) {
            *sum += squares.iter().sum::<f64>();
        }
    }
    fourth
}

/// The standard deviation of the levels of windows with these sums of squares, dB.
fn level_spread_db(short: &[f64]) -> Option<f64> {
    let silent = (SILENT * crate::statistics::mean(short)).max(f64::MIN_POSITIVE);
    let level_db = |power: &f64| Decibels::from_power(power.max(silent)).0;
    let levels_db: Vec<f64> = short.iter().map(level_db).collect();
    LevelSpread::of(&levels_db).map(|spread| spread.db)
}

/// A planned computation of features: window, transform and memory, made once for all strokes.
#[derive(Clone, Debug)]
pub struct FeaturePlan {
    welch: WelchPlan,
    config: FeatureConfig,
    rate: SampleRate,
    /// What every line's density is multiplied by for the Pacinian and the detection-threshold power; absent for a
    /// vibration that is no acceleration. Lower frequencies need finer lines.
    weights: Option<[Vec<f64>; 2]>,
    /// The same for the level re the threshold of Pacinian corpuscles, over their own band; absent where the band of the analysis
    /// holds less than half of it.
    pacini: Option<Vec<f64>>,
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
        let high = Band::new(Hertz(LowFrequencies::high_hz()), config.band.high());
        let high = high.ok().and_then(|high| high.common(config.band));
        let weights = felt.then(|| {
            [Weighting::Pacinian, Weighting::DetectionThreshold].map(|weighting| {
                high.map_or(Vec::new(), |high| {
                    weighting.line_weights(bins, resolution_hz, high)
                })
            })
        });
        let pacini = || {
            let own = Receptor::Pacini.band().ok()?;
            let common = own.common(config.band)?;
            let width_hz = |band: Band| band.high().0 - band.low().0;
            let enough = width_hz(common) >= LEAST_OF_A_BAND * width_hz(own);
            (felt && enough).then(|| Weighting::Pacinian.line_weights(bins, resolution_hz, common))
        };
        Ok(Self {
            pacini: pacini(),
            welch: WelchPlan::new(&config.welch, rate)?,
            config: config.clone(),
            rate,
            weights,
            ratio: Vec::new(),
            force: Vec::new(),
        })
    }

    /// The features of `stroke`, without what it is below the band of Pacinian corpuscles, and its PSD in u²/Hz, from the (filtered) `vibrations` and the forces and motion
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
        let (mut square, mut peak, mut kurtosis) = (0.0, 0.0f64, 0.0);
        let window = self.rate.samples_in(SHORT_TIME).max(1);
        let mut short = vec![0.0; steady.len() / window];
        let mut psd: Vec<f64> = Vec::new();
        for vibration in vibrations {
            let samples = steady.of(vibration);
            let mean = crate::statistics::mean(samples);
            let (sum, largest) = squares_and_peak(samples, mean);
            square += sum / samples.len().max(1) as f64;
            peak = peak.max(largest);
            let fourth = fourth_powers(samples, mean, window, &mut short);
            kurtosis += fourth * samples.len() as f64 / (sum * sum).max(f64::MIN_POSITIVE);
            let spectrum = self.welch.estimate::<Uncalibrated>(&[samples])?;
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
        let pacini = self.pacini.as_ref().map(|weights| -> f64 {
            let lines = psd.iter().zip(weights);
            lines.map(|(p, w)| p * w).sum()
        });
        let pacini = pacini.filter(|power| *power > 0.0);
        let nyquist = self.rate.nyquist();
        let mut receptor_power = [None; 4];
        for (power, receptor) in receptor_power.iter_mut().zip(Receptor::ALL) {
            let band = receptor.band()?;
            *power = (band.high() <= nyquist).then(|| band_power(&psd, resolution_hz, band));
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
            kurtosis: kurtosis / channels,
            level_spread_db: level_spread_db(&short),
            peaks: peaks(&psd, resolution_hz, self.config.band),
            friction_coefficient,
            normal_force_n,
            speed_m_s: signals.motion.and_then(|(motion, kind)| {
                Moments::of(&stroke_speed_m_s(signals.rate, motion, kind, steady))
            }),
            pacinian_power,
            detection_power,
            meissner_level_db: None,
            meissner_from_hz: None,
            meissner_level_at_most_db: None,
            pacini_level_db: pacini.map(|power| Decibels::from_power(power).0),
        };
        Ok((features, psd))
    }

    fn forces(
        &mut self,
        signals: &Signals<'_>,
        segmentation: &Segmentation,
        steady: Interval,
    ) -> (Option<Statistics>, Option<Moments>) {
        let known = forces::fill(
            (signals, segmentation),
            steady,
            (&mut self.force, &mut self.ratio),
        );
        match known {
            Some(touch) => {
                let ratio = Statistics::of(&mut self.ratio).filter(|_| touch == Touch::Lasting);
                (ratio, Moments::of(&self.force))
            }
            None => (None, None),
        }
    }
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
