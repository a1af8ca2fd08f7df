//! Noise of a sensor at rest: its floor, lines of the mains, drift, and whether the sensor was at rest.

mod doubt;

use std::f64::consts::LN_2;
use std::fmt;

pub use doubt::NoiseDoubt;
use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::document::Content;
use crate::doubt::Doubts;
use crate::figure::{Axis, Chart, Line, Mark, Scale, Tone};
use crate::filter::{FilterError, HighPass, ZeroPhase};
use crate::number::{counted, digits};
use crate::page::{Block, Cell, Column, Number, Page, Table};
use crate::quantity::{Band, Hertz, QuantityError, SampleRate, Seconds, Unit};
use crate::recording::{Condition, Recording, RecordingError, Touch};
use crate::spectrum::{Averaging, EstimateError, WelchConfig, median_bias, welch};
use crate::statistics::{Trend, mean, median, rms, standard_deviation, trend};

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
    /// Segments of 1 s, and 10 to 1000 Hz as far as the rate allows.
    ///
    /// # Errors
    /// [`QuantityError::Band`] when half the rate is 10 Hz or less.
    pub fn usual(rate: SampleRate) -> Result<Self, QuantityError> {
        let high = rate.nyquist().0.min(1000.0);
        Ok(Self {
            band_hz: Band::new(Hertz(10.0), Hertz(high))?,
            segment_s: Seconds(1.0),
        })
    }
}

/// The noise of one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Noise {
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
    /// The rms over the band, in the unit of the channel: from the PSD, lines of the mains included.
    pub rms: f64,
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
    /// The rms above the band's lower end over each quarter of a segment's length in turn, in the unit of the channel.
    pub levels: Vec<f64>,
    /// What a person should know before relying on it.
    pub doubts: Doubts,
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
    /// The drift over the whole recording, of the rms over the band.
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
            Self::LoudestPart => f.write_str("loudest part over the usual one"),
            Self::LevelSpread => f.write_str("spread of the levels of parts beyond chance"),
            Self::StatedSpeed => f.write_str("sliding speed that the recording states"),
            Self::MainsLine { at_hz } => write!(f, "line at {at_hz:.0} Hz over the floor"),
            Self::Drift => f.write_str("drift over the recording, of the rms"),
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
/// The drift may be as large as the noise.
const DRIFT: Limit = Limit::Within { reach: 1.0 };
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;

/// The noise of one channel of `recording`, as if the sensor was at rest; whether it was is a criterion, and a doubt.
/// PSD in unit²/Hz, levels and rms in the channel's unit, differences of levels in dB.
///
/// Formula: Welch's PSD with the median of the segments (Hann, half of each shared), which events shorter than half of the
/// recording do not lift; lines over the median of those within 8 Hz, with an interval of ±1.96·1.44/√n (n independent
/// segments) of the power; the slope of the means of parts by least squares, its interval from Student's t over n(1 − r)/(1 + r)
/// parts, r the correlation of a residual with the next; levels of parts against the scatter √(∫S²df/T)/∫S df of Gaussian noise.
///
/// Source: P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15(2); B. D. Santer et al. (2000), J. Geophys. Res. 105(D6),
/// 7337; J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 8.2. The limits are stated in decision 0048.
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
    if config.band_hz.high().0 > nyquist.0 {
        return Err(NoiseError::Band {
            band: config.band_hz,
            highest: nyquist,
        });
    }
    let needed = Seconds(SHORTEST * config.segment_s.0);
    if duration_s.0 < needed.0 {
        return Err(NoiseError::TooShort {
            needed,
            found: duration_s,
        });
    }
    if crate::integrity::never_changes(x) {
        return Err(NoiseError::Dead {
            channel: channel.name.clone(),
        });
    }
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
    let rms = floor.rms(config.band_hz);
    let high_pass = HighPass {
        order: 4,
        cutoff_hz: config.band_hz.low(),
    };
    let moving = ZeroPhase::high_pass(high_pass, rate)?.apply(x);
    let part = (rate.samples_in(config.segment_s) / PARTS).max(1);
    let levels: Vec<f64> = moving.chunks_exact(part).map(self::rms).collect();
    let (mains, of_lines): (Vec<_>, Vec<_>) = floor.mains(nyquist).into_iter().unzip();
    let mut criteria = rest(&moving, &levels, floor.chance(config, &mains));
    criteria.extend(stated(&recording.about.condition));
    let at_rest = Outcome::of_all(criteria.iter().map(|c| c.outcome));
    criteria.extend(of_lines);
    let means: Vec<f64> = x
        .chunks_exact(rate.samples_in(config.segment_s))
        .map(mean)
        .collect();
    let drift = (means.len() >= SHORTEST_OF_DRIFT)
        .then(|| trend(&means, config.segment_s.0))
        .flatten();
    criteria.push(drift_criterion(drift.as_ref(), duration_s, rms));
    let mut doubts = Doubts::new();
    doubts.extend(recording.about.doubts.iter().cloned().chain(psd.doubts));
    let name = || channel.name.clone();
    match at_rest {
        Outcome::Met => (),
        Outcome::NotMet => doubts.push(NoiseDoubt::NotAtRest { channel: name() }),
        Outcome::NotDecided => doubts.push(NoiseDoubt::PerhapsNotAtRest { channel: name() }),
    }
    Ok(Noise {
        channel: name(),
        unit: channel.unit.clone(),
        rate_hz: rate,
        duration_s,
        config: *config,
        rms,
        densities: floor.densities(nyquist),
        mains,
        drift,
        criteria,
        averages: psd.averages,
        resolution_hz: psd.resolution_hz,
        psd: psd.values,
        means,
        levels,
        doubts,
    })
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

    fn rms(&self, band: Band) -> f64 {
        let power: f64 = self.psd[self.bins(band.low().0, band.high().0)]
            .iter()
            .sum();
        (power * self.resolution_hz).sqrt()
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
        let beside = (BESIDE_HZ / self.resolution_hz).ceil().max(3.0) as usize;
        let near = at.saturating_sub(beside)..(at + beside + 1).min(self.psd.len());
        let around = self.median(at_hz - AROUND_HZ, at_hz + AROUND_HZ, near.clone());
        let Some(floor) = around.filter(|floor| *floor > 0.0) else {
            return open;
        };
        let sure = 1.96 / LN_2 / self.independent.sqrt();
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
    let of_chance_db = chance_db * (1.0 + 2.0 / (2.0 * n).sqrt());
    let beyond_db = (spread_db * spread_db - of_chance_db * of_chance_db)
        .max(0.0)
        .sqrt();
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
        of(LevelSpread, spread_db, beyond_db, SPREAD_DB),
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

/// Why noise cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum NoiseError {
    /// The channel cannot be picked.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording is too short.
    #[error("cannot analyse noise: expected {needed} or longer, found {found:.3}; record longer")]
    TooShort {
        /// What is needed.
        needed: Seconds,
        /// What was found.
        found: Seconds,
    },
    /// The band reaches beyond the signal.
    #[error(
        "cannot analyse noise over {band}: the signal ends at {highest}; lower the end of the band"
    )]
    Band {
        /// The band asked for.
        band: Band,
        /// Where the signal ends.
        highest: Hertz,
    },
    /// The channel never changes.
    #[error("cannot analyse noise: `{channel}` never changes; check the sensor's cable and range")]
    Dead {
        /// The channel.
        channel: String,
    },
    /// The spectrum cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The band's lower end cannot be filtered at.
    #[error(transparent)]
    Filter(#[from] FilterError),
}

impl Content for Noise {
    const SCHEMA: &'static str = "noise";
}

impl Noise {
    /// Whether the sensor was at rest.
    #[must_use]
    pub fn at_rest(&self) -> Outcome {
        let of_rest = self.criteria.iter().filter(|c| c.what.of_rest());
        Outcome::of_all(of_rest.map(|c| c.outcome))
    }

    /// The conclusion in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let (rms, unit) = (digits(self.rms), self.unit.symbol());
        let level = format!("{rms} {unit} rms over {}", self.config.band_hz);
        match self.at_rest() {
            Outcome::Met => format!("Noise of the sensor at rest: {level}"),
            Outcome::NotMet => format!("The sensor was not at rest: {level}"),
            Outcome::NotDecided => format!("Noise, perhaps not at rest: {level}"),
        }
    }

    /// The drift in one sentence.
    #[must_use]
    pub fn drift_sentence(&self) -> String {
        let (unit, least) = (self.unit.symbol(), SHORTEST_OF_DRIFT as f64);
        let Some(drift) = &self.drift else {
            let least_s = digits(least * self.config.segment_s.0);
            return format!("Drift is not decided: it needs {least_s} s or longer");
        };
        let interval = drift
            .slope_interval
            .map_or("not decided".into(), |[low, high]| {
                format!("{} to {}", digits(low), digits(high))
            });
        let (slope, range) = (digits(drift.slope), digits(drift.range));
        let text = format!(
            "The mean changes by {slope} {unit}/s (95 %: {interval}), range {range} {unit}"
        );
        text.replace('-', "−")
    }

    /// The PSD and the amplitude density by frequency: one row a line.
    #[must_use]
    pub fn spectrum_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("frequency, Hz", "frequency_hz"),
            Column::new(&format!("PSD, {}", self.unit.of_psd()), "psd"),
            Column::new(&self.density_label(), "amplitude_density"),
        ]);
        table.rows = (self.psd.iter().enumerate())
            .map(|(k, psd)| vec![k as f64 * self.resolution_hz, *psd, psd.sqrt()])
            .map(|row| row.into_iter().map(Cell::from).collect())
            .collect();
        table
    }

    fn density_label(&self) -> String {
        format!("amplitude density, {}/√Hz", self.unit.symbol())
    }

    /// The report.
    #[must_use]
    pub fn page(&self, origin: &str) -> Page {
        let (unit, part_s) = (self.unit.symbol(), self.config.segment_s.0 / PARTS as f64);
        let mut numbers = vec![Number::new(
            format!("{} {unit}", digits(self.rms)),
            format!("rms over {}", self.config.band_hz),
        )];
        numbers.extend(self.densities.iter().map(|density| {
            Number::new(
                format!("{} {unit}/√Hz", digits(density.value)),
                format!("at {} Hz", density.frequency_hz),
            )
        }));
        let conclusion = Block::Conclusion {
            text: format!("{}.", self.sentence()),
            outcome: Some(self.at_rest()),
        };
        let of_rest = self.criteria.iter().filter(|c| c.what.of_rest());
        let others = self.criteria.iter().filter(|c| !c.what.of_rest());
        let note = format!(
            "PSD by Welch's method: Hann window, segments of {}, half of each shared, median of {}. Levels: rms above {} over quarters of a segment. Drift: least squares over the means of segments; its interval counts as many parts as are independent. A line stands out when it is more than {STANDS_OUT_DB} dB above the floor around it with 95 % confidence.",
            self.config.segment_s,
            counted(self.averages, "segment"),
            self.config.band_hz.low(),
        );
        Page::new(format!("Noise of {}", self.channel), origin)
            .section("", [conclusion, Block::Numbers { numbers }])
            .section(
                "Was the sensor at rest?",
                [
                    Block::Table(Table::of_criteria(of_rest)),
                    Block::Figure(
                        self.over_time("rms of parts", &self.levels, part_s)
                            .captioned("Level of each part. At rest it is the same throughout."),
                    ),
                ],
            )
            .section("Spectrum", [Block::Figure(self.spectrum_figure())])
            .section(
                "Lines of the mains and drift",
                [
                    Block::Text {
                        text: format!("{}.", self.drift_sentence()),
                    },
                    Block::Figure(
                        self.over_time("mean of parts", &self.means, self.config.segment_s.0)
                            .captioned("Mean of each part, which drift shows in."),
                    ),
                    Block::Table(Table::of_criteria(others)),
                ],
            )
            .doubts(&self.doubts)
            .section("Method", [Block::Note { text: note }])
    }

    fn spectrum_figure(&self) -> crate::figure::Figure {
        let (step_hz, last) = (self.resolution_hz, self.psd.len() - 1);
        let point = |k: usize| (k as f64 * step_hz, self.psd[k].sqrt());
        let above = |points: &(f64, f64)| points.1 > 0.0;
        let points: Vec<_> = (1..=last).map(point).filter(above).collect();
        let lines = self.mains.iter().filter(|line| line.rms.is_some());
        let lines = lines.map(|line| line.mains_hz * line.harmonic as f64 / step_hz);
        let lines = lines.map(|k| point(k.round() as usize)).filter(above);
        let y = points.iter().map(|point| point.1);
        let y = Axis::around(self.density_label(), Scale::Logarithmic, y);
        let x = Axis::log("frequency, Hz", step_hz, last as f64 * step_hz);
        let mut chart = Chart::new(x, y, vec![Line::new("noise", Tone::Main, points).thin()]);
        let lines = Line::new("lines of the mains", Tone::Second, lines.collect());
        if !lines.points.is_empty() {
            chart.lines.push(lines.marked(Mark::Dots));
        }
        chart.captioned("Amplitude density: the square root of the PSD.")
    }

    fn over_time(&self, what: &str, values: &[f64], part_s: f64) -> Chart {
        let time = |i: usize| (i as f64 + 0.5) * part_s;
        let points: Vec<(f64, f64)> = (values.iter().enumerate())
            .map(|(i, value)| (time(i), *value))
            .collect();
        let label = format!("{what}, {}", self.unit.symbol());
        let y = Axis::around(label, Scale::Linear, values.iter().copied());
        let x = Axis::new("time, s", 0.0, self.duration_s.0);
        Chart::new(x, y, vec![Line::new("", Tone::Main, points)])
    }
}
