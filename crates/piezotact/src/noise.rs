//! Noise of a sensor at rest: its floor, lines of the mains, drift, and whether the sensor was at rest.

mod error;
mod page;
mod warning;

use std::f64::consts::LN_2;
use std::fmt;

pub use error::NoiseError;
use serde::{Deserialize, Serialize};
pub use warning::NoiseWarning;

use crate::criterion::{Criterion, Limit, Outcome};
use crate::document::Content;
use crate::filter::{HighPass, ZeroPhase};
use crate::quantity::{Band, Hertz, QuantityError, SampleRate, Seconds, Uncalibrated, Unit};
use crate::recording::{Condition, Recording, Touch};
use crate::series::Series;
use crate::spectrum::{Averaging, WelchConfig, median_bias, welch};
use crate::statistics::{Trend, Z_95, mean, median, rms, standard_deviation, trend};
use crate::warning::Warnings;

/// How noise is analysed. There is no default: it is stated, and goes into the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct NoiseConfig {
    /// The band of the rms.
    pub band_hz: Band,
    /// The length of the segments of the spectrum, and of the parts of which drift is computed.
    pub segment_s: Seconds,
}

impl NoiseConfig {
    /// How many parts at each end the high-pass disturbs.
    fn disturbed_parts(&self) -> usize {
        let part_s = self.segment_s.0 / PARTS as f64;
        (DISTURBED / (self.band_hz.low().0 * part_s))
            .ceil()
            .clamp(1.0, PARTS as f64) as usize
    }

    /// The number of samples of a part whose level is compared.
    fn part(&self, rate: SampleRate) -> usize {
        (rate.samples_in(self.segment_s) / PARTS).max(1)
    }

    /// Segments of 1 s, and 10 to 1000 Hz as far as the rate allows.
    ///
    /// # Errors
    /// [`QuantityError::Band`] when half the rate is 10 Hz or less.
    pub fn usual(rate: SampleRate) -> Result<Self, QuantityError> {
        let high = rate.nyquist().0.min(1000.0);
        Ok(Self::over(Band::new(Hertz(10.0), Hertz(high))?))
    }

    /// Segments of 1 s, and the band `band_hz`.
    #[must_use]
    pub fn over(band_hz: Band) -> Self {
        Self {
            band_hz,
            segment_s: Seconds(1.0),
        }
    }
}

/// The noise of one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Noise {
    /// The file of the recording, for the report.
    #[serde(skip)]
    pub file: String,
    /// The channel.
    pub channel: String,
    /// Its unit.
    pub unit: Unit,
    /// Its rate.
    pub rate_hz: SampleRate,
    /// How long it was recorded.
    pub duration_s: Seconds,
    /// How it was analysed.
    pub config: NoiseConfig,
    /// The rms over the band, in the unit of the channel: of everything in the recording, from the mean PSD.
    pub rms: f64,
    /// The rms over the band of the noise floor, in the unit of the channel: from the PSD of medians, with lines replaced by the
    /// floor around them.
    pub floor_rms: f64,
    /// The amplitude density at 10, 100 and 1000 Hz, as far as the rate allows.
    pub densities: Vec<Density>,
    /// Multiples of 50 and 60 Hz.
    pub mains: Vec<MainsLine>,
    /// The slow trend of the means of segments over time, s; absent for recordings shorter than ten segments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Trend>,
    /// What was decided: about rest, lines of the mains, and drift.
    pub criteria: Vec<Criterion<NoiseCriterion>>,
    /// The number of segments of the PSD.
    pub averages: usize,
    /// The step between the lines of the PSD, Hz.
    pub resolution_hz: f64,
    /// The one-sided PSD from 0 Hz up, in the unit of the channel squared per Hz: the median of the segments, over its
    /// expectation for Gaussian noise.
    pub psd: Vec<f64>,
    /// The mean of each segment's length in turn, in the unit of the channel.
    pub means: Vec<f64>,
    /// The rms above the band's lower end over each quarter of a segment's length in turn, in the unit of the channel; without the
    /// parts at both ends that the high-pass disturbs.
    pub levels: Vec<f64>,
    /// What a person should know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Warnings,
}

/// An amplitude density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Density {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// The square root of the median of the PSD over a third octave, in the unit of the channel over √Hz.
    pub value: f64,
}

/// A multiple of the frequency of the mains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MainsLine {
    /// The frequency of the mains, Hz.
    pub mains_hz: f64,
    /// Which multiple.
    pub harmonic: usize,
    /// How far its line of the PSD stands over the floor around it, dB; absent where a line beside it hides it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above_db: Option<f64>,
    /// The rms of a steady tone there, in the unit of the channel; absent where the line does not stand out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
}

/// What is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum NoiseCriterion {
    /// The largest excursion above the band's lower end, over the usual rms: knocks.
    Crest,
    /// The loudest part over the usual one: strokes.
    LoudestPart,
    /// How levels of parts scatter beyond what noise of this spectrum does: changes of level.
    LevelSpread,
    /// The sliding speed that the recording states.
    StatedSpeed,
    /// A multiple of the frequency of the mains over the floor.
    MainsLine {
        /// Its frequency, Hz.
        at_hz: f64,
    },
    /// A line that is no multiple of the mains, over the floor: of a machine, or of a steady motion.
    OtherLine {
        /// Its frequency, Hz.
        at_hz: f64,
    },
    /// The largest change of the mean over quarters of a segment, in multiples of the rms of the floor: slow motion, or drift.
    MeanRange,
    /// The drift over the whole recording, in multiples of the rms of the floor.
    Drift,
}

impl NoiseCriterion {
    /// Whether it decides if the sensor was at rest.
    fn of_rest(self) -> bool {
        !matches!(self, Self::MainsLine { .. } | Self::Drift)
    }
}

impl fmt::Display for NoiseCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Crest => f.write_str("largest excursion, in multiples of the rms"),
            Self::LoudestPart => f.write_str("loudest part over the median part"),
            Self::LevelSpread => f.write_str("spread of the levels of parts beyond chance"),
            Self::StatedSpeed => f.write_str("sliding speed that the recording states"),
            Self::MainsLine { at_hz } => write!(f, "line at {at_hz:.0} Hz over the floor"),
            Self::OtherLine { at_hz } => {
                write!(f, "line at {at_hz:.0} Hz, not of the mains, over the floor")
            }
            Self::MeanRange => f.write_str("largest change of the mean, in multiples of the rms"),
            Self::Drift => f.write_str("drift over the recording, in multiples of the rms"),
        }
    }
}

/// The networks of the world, Hz, and how far they wander, as a share.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const WANDER: f64 = 0.004;
/// Multiples that are looked at.
const HARMONICS: usize = 10;
/// A line stands out that is so far above the floor, dB.
const STANDS_OUT_DB: f64 = 3.0;
/// A line that is not of the mains is named from so far above the floor on both sides, dB; the strongest of them.
const OTHER_LINE_DB: f64 = 10.0;
const OTHER_LINES: usize = 5;
/// The lowest line that is looked for, in lines of the PSD.
const LOWEST_LINE: usize = 3;
/// The floor around a line is taken so far to either side, and not so close, Hz.
const AROUND_HZ: f64 = 8.0;
const BESIDE_HZ: f64 = 3.0;
/// Where the amplitude density is given, Hz.
const DENSITIES_HZ: [f64; 3] = [10.0, 100.0, 1000.0];
/// A segment has so many parts whose levels are compared.
const PARTS: usize = 4;
/// The shortest recording, in segments, and the shortest of which drift is computed.
const SHORTEST: f64 = 4.0;
const SHORTEST_OF_DRIFT: usize = 10;
/// Gaussian noise reaches 6.5 times its rms once in 10^10 samples.
const CREST: Limit = Limit::AtMost {
    met: 6.5,
    not_met: 8.0,
};
/// How much louder than the usual part the loudest may be, dB, and how much the levels may spread.
const LOUDER_DB: f64 = 3.0;
const SPREAD_DB: f64 = 1.0;
/// The mean may change by so many times the noise before slow motion cannot be excluded.
const MEAN_RANGE: f64 = 10.0;
/// The ends of a recording that a high-pass disturbs, in periods of its frequency.
const DISTURBED: f64 = 1.5;
/// The drift may be as large as the noise.
const DRIFT: Limit = Limit::Within { reach: 1.0 };
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;

/// The noise of one channel of `recording`, as if the sensor was at rest; whether it was is a criterion, and a warning.
/// PSD in unit²/Hz, levels and rms in the channel's unit, differences of levels in dB.
///
/// Formula: Welch's PSD with the mean of the segments (Hann, half of each shared) for the rms, and with their median for the
/// floor, which events shorter than half of the recording do not lift; lines over the median of those within 8 Hz, with an interval of ±1.96·1.44/√n (n independent
/// segments) of the power; the slope of the means of parts by least squares, its interval from Student's t over n(1 − r)/(1 + r)
/// parts, r the correlation of a residual with the next; levels of parts against the scatter √(∫S²df/T)/∫S df of Gaussian noise.
///
/// Source: P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15(2); B. D. Santer et al. (2000), J. Geophys. Res. 105(D6),
/// 7337; J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 8.2. The limits are stated in docs/decisions/signals.md.
///
/// # Errors
/// [`NoiseError`] for a channel that cannot be picked, a band beyond the rate, fewer than four segments, and a channel that never
/// changes.
pub fn noise(
    recording: &Recording,
    channel: Option<&str>,
    config: &NoiseConfig,
) -> Result<Noise, NoiseError> {
    let (channel, series) = recording.raw(channel)?;
    let (x, rate) = (series.samples(), series.rate());
    let duration_s = rate.duration_of(x.len());
    let nyquist = rate.nyquist();
    refuse(&channel.name, &series, config)?;
    let welch_config = WelchConfig {
        averaging: Averaging::Median,
        ..WelchConfig::hann(rate.samples_in(config.segment_s))
    };
    let psd = welch(&series, &welch_config)?;
    let floor = Floor {
        psd: &psd.values,
        resolution_hz: psd.resolution_hz,
        independent: welch_config.effective_averages(psd.averages)?,
        averages: psd.averages,
    };
    let mean_psd = welch(
        &series,
        &WelchConfig::hann(rate.samples_in(config.segment_s)),
    )?;
    let rms = floor.of(&mean_psd.values).rms(config.band_hz, &[]);
    let part = config.part(rate);
    let moving = moving(x, rate, config)?;
    let levels: Vec<f64> = moving.chunks_exact(part).map(self::rms).collect();
    if floor
        .bins(config.band_hz.low().0, config.band_hz.high().0)
        .is_empty()
    {
        return Err(NoiseError::NarrowBand {
            band: config.band_hz,
            resolution: Hertz(psd.resolution_hz),
        });
    }
    // Changes of the last digit are no noise.
    let usual = median(&mut levels.clone()).unwrap_or_default();
    let highest = levels.iter().copied().fold(0.0, f64::max);
    if floor.rms(config.band_hz, &[]) <= 0.0 || usual <= 1e-12 * highest {
        return Err(NoiseError::MostlyConstant {
            channel: channel.name.clone(),
        });
    }
    let (mains, of_lines): (Vec<_>, Vec<_>) = floor.mains(nyquist).into_iter().unzip();
    let mut criteria = rest(&moving, &levels, floor.chance(config, &mains));
    let others = floor.other_lines(nyquist);
    criteria.extend(others.iter().map(|(_, criterion)| criterion.clone()));
    criteria.extend(stated(&recording.about.condition));
    let means: Vec<f64> = x
        .chunks_exact(rate.samples_in(config.segment_s))
        .map(mean)
        .collect();
    let drift = (means.len() >= SHORTEST_OF_DRIFT)
        .then(|| trend(&means, config.segment_s.0))
        .flatten();
    let steady = mains.iter().filter(|line| line.rms.is_some());
    let steady = steady.map(|line| line.mains_hz * line.harmonic as f64 / psd.resolution_hz);
    let lines: Vec<usize> = (steady.map(|k| k.round() as usize))
        .chain(others.iter().map(|(k, _)| *k))
        .collect();
    let floor_rms = floor.rms(config.band_hz, &lines);
    criteria.push(mean_range(x.chunks_exact(part).map(mean), floor_rms));
    let at_rest = Outcome::of_all(criteria.iter().map(|c| c.outcome));
    criteria.extend(of_lines);
    criteria.push(drift_criterion(drift.as_ref(), duration_s, floor_rms));
    let mut warnings = Warnings::new();
    warnings.extend(recording.about.warnings.iter().cloned().chain(psd.warnings));
    let name = || channel.name.clone();
    match at_rest {
        Outcome::Met => (),
        Outcome::NotMet => warnings.push(NoiseWarning::NotAtRest { channel: name() }),
        Outcome::NotDecided => warnings.push(NoiseWarning::PerhapsNotAtRest { channel: name() }),
    }
    Ok(Noise {
        file: String::new(),
        channel: name(),
        unit: channel.unit.clone(),
        rate_hz: rate,
        duration_s,
        config: *config,
        rms,
        floor_rms,
        densities: floor.densities(nyquist),
        mains,
        drift,
        criteria,
        averages: psd.averages,
        resolution_hz: psd.resolution_hz,
        psd: psd.values,
        means,
        levels,
        warnings,
    })
}

fn refuse(
    channel: &str,
    series: &Series<Uncalibrated>,
    config: &NoiseConfig,
) -> Result<(), NoiseError> {
    let highest = series.rate().nyquist();
    if config.band_hz.high().0 > highest.0 {
        return Err(NoiseError::Band {
            band: config.band_hz,
            highest,
        });
    }
    let (needed, found) = (Seconds(SHORTEST * config.segment_s.0), series.duration());
    if found.0 < needed.0 {
        return Err(NoiseError::TooShort { needed, found });
    }
    if crate::integrity::never_changes(series.samples()) {
        return Err(NoiseError::Dead {
            channel: channel.into(),
        });
    }
    Ok(())
}

/// What of `x` is faster than the band's lower end, in whole parts: without the ends that the high-pass disturbs.
fn moving(x: &[f64], rate: SampleRate, config: &NoiseConfig) -> Result<Vec<f64>, NoiseError> {
    let high_pass = HighPass {
        order: 4,
        cutoff_hz: config.band_hz.low(),
    };
    let mut moving = ZeroPhase::high_pass(high_pass, rate)?.apply(x);
    let skipped = config.disturbed_parts() * config.part(rate);
    moving.truncate(moving.len().saturating_sub(skipped));
    moving.drain(..skipped);
    Ok(moving)
}

/// A PSD of medians.
struct Floor<'a> {
    psd: &'a [f64],
    resolution_hz: f64,
    independent: f64,
    averages: usize,
}

impl Floor<'_> {
    fn bins(&self, low_hz: f64, high_hz: f64) -> std::ops::Range<usize> {
        let from = (low_hz / self.resolution_hz).ceil().max(0.0) as usize;
        let to = (high_hz / self.resolution_hz).max(0.0).floor() as usize;
        from.min(self.psd.len())..to.saturating_add(1).min(self.psd.len())
    }

    fn median(&self, low_hz: f64, high_hz: f64, without: std::ops::Range<usize>) -> Option<f64> {
        let bins = self.bins(low_hz, high_hz);
        let mut values: Vec<f64> = bins
            .filter(|k| !without.contains(k))
            .map(|k| self.psd[k])
            .collect();
        median(&mut values)
    }

    /// The same with another PSD of the same lines.
    fn of<'b>(&self, psd: &'b [f64]) -> Floor<'b> {
        Floor { psd, ..*self }
    }

    /// The rms over `band`; around the bins `lines` the floor beside them counts.
    fn rms(&self, band: Band, lines: &[usize]) -> f64 {
        let bins = self.bins(band.low().0, band.high().0);
        let power = bins.map(|k| match lines.iter().find(|line| line.abs_diff(k) <= 2) {
            Some(line) => self.around(*line).unwrap_or(self.psd[k]).min(self.psd[k]),
            None => self.psd[k],
        });
        (power.sum::<f64>() * self.resolution_hz).sqrt()
    }

    /// How many bins around a line are none of the floor.
    fn beside(&self) -> usize {
        (BESIDE_HZ / self.resolution_hz).ceil().max(3.0) as usize
    }

    /// The median of the PSD around the bin `at`, without the bins beside it.
    fn around(&self, at: usize) -> Option<f64> {
        let (at_hz, beside) = (at as f64 * self.resolution_hz, self.beside());
        let near = at.saturating_sub(beside)..(at + beside + 1).min(self.psd.len());
        self.median(at_hz - AROUND_HZ, at_hz + AROUND_HZ, near)
    }

    /// The strongest lines that are no multiples of the mains, by their bins. Such a line stands over the floor on both sides, and
    /// does not decide whether the sensor was at rest: a fan makes one, and so does a periodic texture under a finger.
    fn other_lines(&self, nyquist: Hertz) -> Vec<(usize, Criterion<NoiseCriterion>)> {
        let beside = self.beside();
        let of_mains = |hz: f64| {
            let off = |mains_hz: f64| (hz - mains_hz * (hz / mains_hz).round().max(1.0)).abs();
            let nearest_hz = MAINS_HZ.map(off).into_iter().fold(f64::MAX, f64::min);
            nearest_hz <= WANDER * hz + 1.5 * self.resolution_hz
        };
        let last = ((nyquist.0 - AROUND_HZ) / self.resolution_hz).max(0.0) as usize;
        let mut found: Vec<(usize, f64)> = Vec::new();
        for k in LOWEST_LINE..last.min(self.psd.len()) {
            let hz = k as f64 * self.resolution_hz;
            let near = &self.psd[k.saturating_sub(2)..(k + 3).min(self.psd.len())];
            if of_mains(hz) || near.iter().any(|value| *value > self.psd[k]) {
                continue;
            }
            let gap_hz = beside as f64 * self.resolution_hz;
            let sides = [
                self.median(
                    (hz - AROUND_HZ).max(self.resolution_hz),
                    (hz - gap_hz).max(self.resolution_hz),
                    0..0,
                ),
                self.median(hz + gap_hz, hz + AROUND_HZ, 0..0),
            ];
            let floor = sides.into_iter().flatten().fold(0.0, f64::max);
            let above_db = DB_PER_NEPER * (self.psd[k] / floor.max(f64::MIN_POSITIVE)).ln();
            if above_db > OTHER_LINE_DB {
                found.push((k, above_db));
            }
        }
        found.sort_by(|a, b| self.psd[b.0].total_cmp(&self.psd[a.0]));
        let mut lines: Vec<(usize, Criterion<NoiseCriterion>)> = Vec::new();
        for (k, above_db) in found {
            let apart = (AROUND_HZ / self.resolution_hz) as usize;
            if lines.len() == OTHER_LINES || lines.iter().any(|(line, _)| line.abs_diff(k) <= apart)
            {
                continue;
            }
            let at_hz = k as f64 * self.resolution_hz;
            let what = NoiseCriterion::OtherLine { at_hz };
            let limit = Limit::at_most(OTHER_LINE_DB);
            let criterion = Criterion {
                outcome: Outcome::NotDecided,
                ..Criterion::new(what, "dB", above_db, None, limit)
            };
            lines.push((k, criterion));
        }
        lines
    }

    fn densities(&self, nyquist: Hertz) -> Vec<Density> {
        let third = 2f64.powf(1.0 / 6.0);
        DENSITIES_HZ
            .into_iter()
            .filter(|at_hz| at_hz * third < nyquist.0)
            .filter_map(|frequency_hz| {
                let power = self.median(frequency_hz / third, frequency_hz * third, 0..0)?;
                let value = power.sqrt();
                Some(Density {
                    frequency_hz,
                    value,
                })
            })
            .collect()
    }

    /// The multiples of the mains, and whether each stands out.
    fn mains(&self, nyquist: Hertz) -> Vec<(MainsLine, Criterion<NoiseCriterion>)> {
        let multiples = |mains_hz| (1..=HARMONICS).map(move |n| (mains_hz, n));
        MAINS_HZ
            .into_iter()
            .flat_map(multiples)
            .filter(|(mains_hz, n)| mains_hz * *n as f64 + AROUND_HZ < nyquist.0)
            .map(|(mains_hz, n)| self.line(mains_hz, n))
            .collect()
    }

    fn line(&self, mains_hz: f64, harmonic: usize) -> (MainsLine, Criterion<NoiseCriterion>) {
        let at_hz = mains_hz * harmonic as f64;
        let what = NoiseCriterion::MainsLine { at_hz };
        let limit = Limit::at_most(STANDS_OUT_DB);
        let unseen = MainsLine {
            mains_hz,
            harmonic,
            above_db: None,
            rms: None,
        };
        let open = (unseen, Criterion::unmeasured(what, "dB", limit));
        let reach_hz = (WANDER * at_hz).max(0.5 * self.resolution_hz);
        let strongest = |bins: std::ops::Range<usize>| {
            bins.max_by(|a, b| self.psd[*a].total_cmp(&self.psd[*b]))
        };
        let Some(at) = strongest(self.bins(at_hz - reach_hz, at_hz + reach_hz)) else {
            return open;
        };
        let beside = self.beside();
        let near = at.saturating_sub(beside)..(at + beside + 1).min(self.psd.len());
        let Some(floor) = self.around(at).filter(|floor| *floor > 0.0) else {
            return open;
        };
        let sure = Z_95 / LN_2 / self.independent.sqrt();
        let above_db = DB_PER_NEPER * (self.psd[at] / floor).ln();
        let interval = [
            above_db - DB_PER_NEPER * sure,
            above_db + DB_PER_NEPER * sure,
        ];
        // A stronger line beside it, which is none of the mains, reaches over here.
        let hidden = strongest(near)
            .is_some_and(|other| other != at && self.psd[other] > 2.0 * self.psd[at]);
        if hidden && interval[1] > STANDS_OUT_DB {
            return open;
        }
        // A resonance is broad: what a tone leaves three lines beside it is the floor.
        let sides = [at.saturating_sub(4), at.saturating_sub(3), at + 3, at + 4];
        let sides = sides.into_iter().filter_map(|k| self.psd.get(k));
        let sides: Vec<f64> = sides.copied().collect();
        let scatter = floor / LN_2 / (self.independent * 4.0).sqrt();
        let broad = mean(&sides) - floor > 0.12 * (self.psd[at] - floor) + 2.0 * scatter;
        if broad && interval[1] > STANDS_OUT_DB {
            return open;
        }
        let criterion = Criterion::new(what, "dB", above_db, Some(interval), limit);
        let power = |k: usize| (self.psd[k] - floor).max(0.0) * self.resolution_hz;
        let tone: f64 = (at.saturating_sub(2)..=at + 2).map(power).sum();
        let rms = (tone * median_bias(self.averages)).sqrt();
        let rms = (criterion.outcome == Outcome::NotMet).then_some(rms);
        let above_db = Some(above_db);
        (
            MainsLine {
                above_db,
                rms,
                ..unseen
            },
            criterion,
        )
    }

    /// How the levels of parts scatter by chance, dB: that of Gaussian noise with the spectrum above the band's lower end, without
    /// the lines of the mains, which are steady.
    fn chance(&self, config: &NoiseConfig, mains: &[MainsLine]) -> f64 {
        let steady: Vec<f64> = mains
            .iter()
            .filter(|line| line.rms.is_some())
            .map(|line| line.mains_hz * line.harmonic as f64)
            .collect();
        let (mut all, mut squares) = (0.0, 0.0);
        for k in self.bins(config.band_hz.low().0, f64::MAX) {
            let hz = k as f64 * self.resolution_hz;
            all += self.psd[k];
            if !steady.iter().any(|line| (line - hz).abs() <= BESIDE_HZ) {
                squares += self.psd[k] * self.psd[k];
            }
        }
        let part_s = config.segment_s.0 / PARTS as f64;
        // The relative variance of a power; trigamma(1/v) is that of its logarithm.
        let v = squares / (self.resolution_hz * part_s * all * all).max(f64::MIN_POSITIVE);
        DB_PER_NEPER * (v * (1.0 + v * (0.5 + v / 6.0))).sqrt()
    }
}

/// Whether knocks, strokes or changes of level are in what moves.
fn rest(moving: &[f64], levels: &[f64], chance_db: f64) -> Vec<Criterion<NoiseCriterion>> {
    use NoiseCriterion::{Crest, LevelSpread, LoudestPart};
    let usual = median(&mut levels.to_vec())
        .map_or(f64::MIN_POSITIVE, |level| level.max(f64::MIN_POSITIVE));
    let highest = moving.iter().fold(0.0_f64, |high, v| high.max(v.abs()));
    let level_db = |level: &f64| 2.0 * DB_PER_NEPER * (level / usual).max(1e-3).ln();
    let levels_db: Vec<f64> = levels.iter().map(level_db).collect();
    let n = levels_db.len() as f64;
    let loudest_db = levels_db.iter().copied().fold(0.0, f64::max);
    // The loudest of n parts, and how surely.
    let by_chance_db = chance_db * ((2.0 * n.ln()).sqrt() + 2.0);
    let spread_db = standard_deviation(&levels_db);
    // What chance alone spreads, from its 2.5th to its 97.5th percentile, is taken away.
    let beyond = |chance_db: f64| {
        let left = spread_db * spread_db - chance_db * chance_db;
        left.max(0.0).sqrt()
    };
    let unsure = 2.0 / (2.0 * n).sqrt();
    let low_db = beyond(chance_db * (1.0 + unsure));
    let high_db = beyond(chance_db * (1.0 - unsure).max(0.0));
    let of = |what, found, low, most| {
        Criterion::new(what, "dB", found, Some([low, found]), Limit::at_most(most))
    };
    vec![
        Criterion::new(Crest, "", highest / usual, None, CREST),
        of(
            LoudestPart,
            loudest_db,
            loudest_db - by_chance_db,
            LOUDER_DB,
        ),
        Criterion::new(
            LevelSpread,
            "dB",
            beyond(chance_db),
            Some([low_db, high_db]),
            Limit::at_most(SPREAD_DB),
        ),
    ]
}

/// What the recording states about sliding, where it states something.
fn stated(condition: &Condition) -> Option<Criterion<NoiseCriterion>> {
    let (what, limit) = (NoiseCriterion::StatedSpeed, Limit::at_most(0.0));
    match (condition.speed_m_s, condition.touch) {
        (Some(speed), _) => Some(Criterion::new(what, "m/s", speed.abs(), None, limit)),
        (None, Some(Touch::Active | Touch::Passive)) => {
            Some(Criterion::unmeasured(what, "m/s", limit))
        }
        _ => None,
    }
}

/// Whether the mean stays where it is: a slow motion, warming up and drift change it, so that rest is not decided then.
fn mean_range(means: impl Iterator<Item = f64>, rms: f64) -> Criterion<NoiseCriterion> {
    let (low, high) = means.fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let found = (high - low) / rms.max(f64::MIN_POSITIVE);
    let limit = Limit::at_most(MEAN_RANGE);
    let criterion = Criterion::new(NoiseCriterion::MeanRange, "", found, None, limit);
    match criterion.outcome {
        Outcome::NotMet => Criterion {
            outcome: Outcome::NotDecided,
            ..criterion
        },
        _ => criterion,
    }
}

fn drift_criterion(
    drift: Option<&Trend>,
    duration_s: Seconds,
    rms: f64,
) -> Criterion<NoiseCriterion> {
    let what = NoiseCriterion::Drift;
    let over = duration_s.0 / rms.max(f64::MIN_POSITIVE);
    match drift.and_then(|drift| Some((drift.slope, drift.slope_interval?))) {
        Some((slope, interval)) => Criterion::new(
            what,
            "",
            slope * over,
            Some(interval.map(|s| s * over)),
            DRIFT,
        ),
        None => Criterion::unmeasured(what, "", DRIFT),
    }
}

impl Content for Noise {
    const SCHEMA: &'static str = "noise";
}
