//! The low end of a vibration, where lines some 5 Hz apart are too coarse for thresholds that change with every hertz.

use super::{FeatureConfig, FeatureError, Receptor, Weighting};
use crate::quantity::{Band, Decibels, Hertz, SampleRate, Seconds, Uncalibrated, Unit};
use crate::spectrum::{WelchConfig, WelchPlan};
use crate::stroke::Interval;

/// Segments of a spectrum of low frequencies; strokes that are shorter are taken whole.
const SEGMENT: Seconds = Seconds(1.0);
/// A Hann window spreads the mean over as many lines.
const LINES_OF_THE_MEAN: f64 = 2.0;
/// A level re the threshold is given where at least this share of the receptor's band is covered.
const LEAST_OF_A_BAND: f64 = 0.5;
/// The band of the analysis begins here unless stated, Hz: then what is lower counts too, as far as it is covered.
const USUAL_LOW_HZ: f64 = 10.0;

/// Powers at low frequencies over squared thresholds, of one stroke.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LowPowers {
    /// From here on the filter and the length of the stroke let the vibration pass, Hz.
    pub(super) from_hz: f64,
    /// The level in the covered part of the band of Meissner's corpuscles, dB; absent where that is less than half of it.
    pub(super) meissner_db: Option<f64>,
    /// The same with all that the unfiltered signal holds in the rest of that band, dB; absent where nothing is left.
    pub(super) meissner_at_most_db: Option<f64>,
    pub(super) pacinian: f64,
    /// … and what is detected, below the band of Pacinian corpuscles.
    pub(super) detection: f64,
}

/// A planned computation of powers below [`LowFrequencies::high_hz`].
#[derive(Clone, Debug)]
pub(super) struct LowFrequencies {
    config: FeatureConfig,
    rate: SampleRate,
    plan: Option<(usize, WelchPlan)>,
}

impl LowFrequencies {
    /// A plan for accelerations at `rate`; `None` for vibrations in another unit.
    pub(super) fn new(config: &FeatureConfig, rate: SampleRate, unit: &Unit) -> Option<Self> {
        (*unit == Unit::MetrePerSecondSquared).then(|| Self {
            config: config.clone(),
            rate,
            plan: None,
        })
    }

    /// Where low frequencies end, Hz: where the band of Pacinian corpuscles begins.
    pub(super) fn high_hz() -> f64 {
        Receptor::Pacini.band().map_or(0.0, |band| band.low().0)
    }

    /// The powers of a stroke, `steady`, from its vibrations as `filtered` and as `recorded`.
    pub(super) fn of(
        &mut self,
        filtered: &[&[f64]],
        recorded: &[&[f64]],
        steady: Interval,
    ) -> Result<LowPowers, FeatureError> {
        let own = Receptor::Meissner.band()?;
        let segment = self.rate.samples_in(SEGMENT).min(steady.len());
        let step_hz = self.rate.hz() / segment.max(1) as f64;
        let passes_hz = self.config.passes_from().0;
        let from_hz = passes_hz.max(LINES_OF_THE_MEAN * step_hz);
        let mut low = LowPowers {
            from_hz: from_hz.max(own.low().0),
            ..LowPowers::default()
        };
        let high_hz = own.high().0;
        if segment < 8 || low.from_hz >= high_hz || self.rate.nyquist().0 < high_hz {
            return Ok(low);
        }
        // The main lobe of a tone at the edge is counted whole.
        let edge_hz = (low.from_hz - step_hz).max(1.5 * step_hz);
        let corrected = self.psd(filtered, steady, segment)?.into_iter().enumerate();
        let corrected: Vec<f64> = corrected
            .map(|(k, power)| {
                let gain = self.config.high_pass.map_or(1.0, |high_pass| {
                    high_pass.gain(Hertz(k as f64 * step_hz), self.rate)
                });
                // Nothing is corrected by more than the slope's upper half.
                power / gain.powi(2).max(0.25)
            })
            .collect();
        let bins = corrected.len();
        let over = |psd: &[f64], weighting: Weighting, low_hz: f64, high_hz: f64| {
            // A line at the upper end is the next band's.
            let Ok(band) = Band::new(Hertz(low_hz), Hertz(high_hz * (1.0 - 1e-9))) else {
                return 0.0;
            };
            let weights = weighting.line_weights(bins, step_hz, band);
            psd.iter().zip(weights).map(|(p, w)| p * w).sum::<f64>()
        };
        let rapid = Weighting::RapidlyAdapting;
        let covered = over(&corrected, rapid, edge_hz, high_hz);
        let width_hz = own.high().0 - own.low().0;
        if high_hz - low.from_hz >= LEAST_OF_A_BAND * width_hz && covered > 0.0 {
            low.meissner_db = Some(Decibels::from_power(covered).0);
            if low.from_hz > own.low().0 {
                let recorded = self.psd(recorded, steady, segment)?;
                let below_hz = (own.low().0 - step_hz).max(0.5 * step_hz);
                let rest = over(&recorded, rapid, below_hz, edge_hz);
                low.meissner_at_most_db = Some(Decibels::from_power(covered + rest).0);
            }
        }
        let band = self.config.band;
        let from_hz = if band.low().0 > USUAL_LOW_HZ {
            band.low().0
        } else {
            edge_hz
        };
        let to_hz = Self::high_hz().min(band.high().0).min(high_hz);
        let [pacinian, detection] = [Weighting::Pacinian, Weighting::DetectionThreshold]
            .map(|weighting| over(&corrected, weighting, from_hz, to_hz));
        Ok(LowPowers {
            pacinian,
            detection,
            ..low
        })
    }

    /// The mean PSD of the channels, u²/Hz.
    fn psd(
        &mut self,
        channels: &[&[f64]],
        steady: Interval,
        segment: usize,
    ) -> Result<Vec<f64>, FeatureError> {
        let plan = match self.plan.take() {
            Some((planned, plan)) if planned == segment => plan,
            _ => WelchPlan::new(&WelchConfig::hann(segment), self.rate)?,
        };
        let (_, plan) = self.plan.insert((segment, plan));
        let mut mean = vec![0.0; segment / 2 + 1];
        for channel in channels {
            let one = plan.estimate::<Uncalibrated>(&[steady.of(channel)])?;
            for (sum, value) in mean.iter_mut().zip(one.values) {
                *sum += value / channels.len() as f64;
            }
        }
        Ok(mean)
    }
}
