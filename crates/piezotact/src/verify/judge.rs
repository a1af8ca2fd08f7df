//! The criteria of a verification, judged from the spectra and waveforms of target and measurement.

use crate::recording::{Clocks, LostBy, RecordingWarning};
use crate::render::{PartLost, RenderWarning};
use crate::statistics::Z_95;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::clock::Clock;
use super::events::{Compared, Found, UNSEEN_S};
use super::lines::{Floor, Line, Lines, Pair, rms_error};
use super::{FOLLOWS, VerifyConfig, VerifyCriterion, VerifyWarning};
use crate::criterion::{Criterion, Limit};
use crate::lineage::Mode;
use crate::quantity::{Band, Hertz, SampleRate};
use crate::warning::Warning;

/// Everything that the criteria are judged from: spectra, waveforms, noise floor, clipping and clock.
#[derive(Clone, Copy)]
pub(super) struct Evidence<'a> {
    /// The spectra of what is compared.
    pub(super) pair: &'a Pair,
    /// The PSD of the requested target, before the band limit of its rendering.
    pub(super) asked_psd: &'a [f64],
    /// The spectra of both at all frequencies.
    pub(super) outside: &'a Pair,
    /// Target and measurement, aligned in time and limited to the judged bands.
    pub(super) waveforms: [&'a [f64]; 2],
    pub(super) floor: Option<&'a Floor>,
    /// The parts of the band that are judged.
    pub(super) judged: &'a [Band],
    /// The share of the target that was measured.
    pub(super) covered: f64,
    pub(super) clipped: f64,
    /// The clipped share of the drive alone.
    pub(super) clipped_drive: f64,
    /// The longest part of what is compared in which the sensor froze.
    pub(super) frozen_s: Option<f64>,
    /// The longest straight line that replaces lost samples within the compared part, s.
    pub(super) bridged_s: f64,
    /// The silence that was put around a short target, s.
    pub(super) silence_s: f64,
    pub(super) clock: &'a Clock,
    /// Whether the quantity is an acceleration, for which detection thresholds are known.
    pub(super) felt: bool,
    pub(super) rate: SampleRate,
    pub(super) config: &'a VerifyConfig,
}

/// The criteria, and what gives a warning.
pub(super) struct Judgement {
    pub(super) criteria: Vec<Criterion<VerifyCriterion>>,
    pub(super) more: Vec<Warning>,
    /// The share of the lines of the band that could not be evaluated: without target, or hidden by the sensor's noise, 0–1.
    pub(super) left_out: f64,
    /// The share of the power of the whole texture on the lines that are judged, 0–1.
    pub(super) texture_share: f64,
}

/// From this correlation on a measurement is taken for a copy of its target: no device and no sensor reaches it.
const COPY: f64 = 1.0 - 1e-7;
/// A delay that wanders by more is a warning, s.
const WANDERS_S: f64 = 5e-5;
/// The frequency range in which power outside the band is judged by perceptibility, Hz.
const FELT_HZ: (f64, f64) = (10.0, 1000.0);
/// A line outside the band is counted when it exceeds the noise by this factor.
const STANDS_OUT: f64 = 4.0;

/// A line below this share of the noise shows that the noise was not present while the texture played.
const ABSENT_NOISE_SHARE: f64 = 0.3;
/// The largest share of such lines for which the noise is still taken as present.
const MAX_QUIETER_LINES: f64 = 0.1;

/// Whether the noise `floor` can have been present while the texture played: the measurement is no quieter than it.
fn noise_is_plausible(floor: &Floor, pair: &Pair, band: Band) -> bool {
    let lines = pair.measured.iter().enumerate();
    let (mut quieter, mut all) = (0usize, 0usize);
    for (k, measured) in lines {
        let hz = k as f64 * pair.resolution_hz;
        if band.contains(hz) {
            all += 1;
            quieter += usize::from(*measured < ABSENT_NOISE_SHARE * floor.at(hz));
        }
    }
    quieter as f64 <= MAX_QUIETER_LINES * all as f64
}

/// The level of the noise `floor` over the detection threshold if a finger felt it, dB.
fn noise_sensation_db(floor: &Floor, pair: &Pair, config: &VerifyConfig) -> f64 {
    let lines = (0..pair.measured.len()).map(|k| k as f64 * pair.resolution_hz);
    let felt = lines.filter(|hz| (FELT_HZ.0..FELT_HZ.1).contains(hz));
    let excited = felt.map(|hz| floor.at(hz) / config.weighting.threshold_m_s2(Hertz(hz)).powi(2));
    10.0 * (pair.resolution_hz * excited.sum::<f64>())
        .max(f64::MIN_POSITIVE)
        .log10()
}

/// The criteria on `evidence`. Noise before and after the texture is subtracted as the sensor's where nobody could feel it. Where it
/// could be felt it may as well be a vibration, as of an amplifier: what is found is as measured, and intervals reach from there to what is
/// found without the noise.
pub(super) fn judge(evidence: &Evidence<'_>) -> Judgement {
    let believed = evidence
        .floor
        .filter(|floor| noise_is_plausible(floor, evidence.pair, evidence.config.band));
    let without_noise = judged(&Evidence {
        floor: believed,
        ..*evidence
    });
    let level_db = believed
        .filter(|_| evidence.felt)
        .map(|floor| noise_sensation_db(floor, evidence.pair, evidence.config));
    let Some(level_db) = level_db.filter(|level_db| *level_db > 0.0) else {
        return without_noise;
    };
    let mut as_measured = judged(&Evidence {
        floor: None,
        ..*evidence
    });
    for criterion in &mut as_measured.criteria {
        let mut others = without_noise.criteria.iter();
        if let Some(other) = others.find(|other| other.what == criterion.what) {
            *criterion = between(criterion, other);
        }
    }
    as_measured.left_out = as_measured.left_out.max(without_noise.left_out);
    as_measured.more.extend(without_noise.more);
    let noise = VerifyWarning::NoiseCouldBeFelt { level_db };
    as_measured.more.push(noise.into());
    as_measured
}

/// What was found for `one`, with an interval that reaches to what was found for `other`.
fn between(
    one: &Criterion<VerifyCriterion>,
    other: &Criterion<VerifyCriterion>,
) -> Criterion<VerifyCriterion> {
    let (Some(found), Some(at_other)) = (one.found, other.found) else {
        return one.clone();
    };
    let ends = [one.interval, other.interval].into_iter().flatten();
    let ends = ends.flatten().chain([found, at_other]);
    let [low, high] = ends.fold([found, found], |[low, high], end| {
        [end.min(low), end.max(high)]
    });
    if low == high {
        return one.clone();
    }
    Criterion::new(one.what, &one.unit, found, Some([low, high]), one.limit)
}

fn judged(evidence: &Evidence<'_>) -> Judgement {
    let (config, limits) = (evidence.config, &evidence.config.limits);
    let mut criteria = Vec::new();
    let mut more: Vec<Warning> = Vec::new();
    let noise_power: f64 = evidence.floor.map_or(0.0, |floor| {
        evidence.judged.iter().map(|band| floor.power(*band)).sum()
    });
    let [target, measured] = evidence.waveforms;
    let blocks = Blocks::of(target, measured, noise_power, evidence.rate.hz());
    let all = blocks.all();

    let bandwidth_s = effective_bandwidth_hz(evidence.pair, evidence.judged) * target.len() as f64
        / evidence.rate.hz();
    let level = blocks.level_db(bandwidth_s);
    criteria.push(of(
        VerifyCriterion::Level,
        "dB",
        level,
        Limit::Within {
            reach: limits.level_db,
        },
    ));
    let lines = Lines::of(evidence.pair, evidence.floor, config.band);
    criteria.extend(spectrum(evidence, &lines, &mut more));
    if config.mode == Mode::Replicate {
        criteria.push(of(
            VerifyCriterion::WaveformCorrelation,
            "",
            blocks.correlation(bandwidth_s),
            Limit::at_least(limits.waveform_correlation),
        ));
        criteria.push(of(
            VerifyCriterion::WaveformError,
            "dB",
            blocks.nmse_db(bandwidth_s),
            Limit::at_most(limits.waveform_nmse_db),
        ));
    }
    criteria.extend(in_time(evidence, &all, noise_power));
    criteria.push(limited(evidence, &all, noise_power));
    criteria.extend(extent(evidence, &lines));
    let correlation = all.correlation();
    if all.plain_correlation() >= COPY {
        criteria.push(Criterion {
            found: Some(correlation),
            ..Criterion::unmeasured(VerifyCriterion::Independent, "", Limit::at_most(COPY))
        });
    }
    if let Some(frozen_s) = evidence
        .frozen_s
        .filter(|frozen_s| *frozen_s > limits.drop_out_s)
    {
        criteria.push(Criterion {
            found: Some(frozen_s),
            ..Criterion::unmeasured(
                VerifyCriterion::Frozen,
                "s",
                Limit::at_most(limits.drop_out_s),
            )
        });
    }
    more.extend(of_clock(evidence.clock));
    let left_out = lines.without_target + lines.hidden;
    Judgement {
        criteria,
        more,
        texture_share: texture_share(evidence),
        left_out: left_out as f64 / (left_out + lines.compared.len()).max(1) as f64,
    }
}

fn of(what: VerifyCriterion, unit: &str, found: Found, limit: Limit) -> Criterion<VerifyCriterion> {
    Criterion::new(what, unit, found.value, Some(found.interval), limit)
}

/// The warnings about the clocks.
fn of_clock(clock: &Clock) -> Vec<Warning> {
    let drift = clock.drift_ppm.map(|ppm| RecordingWarning::ClocksDiffer {
        of: Clocks::Playback { ppm },
    });
    let lost = (!clock.lost.is_empty()).then(|| RecordingWarning::SamplesLost {
        by: LostBy::Recording {
            samples: clock.lost.iter().map(|lost| lost.samples).sum(),
            places: clock.lost.len(),
        },
    });
    let wanders = clock
        .wander_s
        .filter(|wander_s| *wander_s > WANDERS_S)
        .map(|rms_s| RecordingWarning::ClocksDiffer {
            of: Clocks::Wanders { rms_s },
        });
    [drift, lost, wanders]
        .into_iter()
        .flatten()
        .map(Warning::from)
        .collect()
}

/// The errors of the spectrum: unweighted, by power and by felt power, and the power that was added.
fn spectrum(
    evidence: &Evidence<'_>,
    lines: &Lines,
    more: &mut Vec<Warning>,
) -> Vec<Criterion<VerifyCriterion>> {
    let (config, limits) = (evidence.config, &evidence.config.limits);
    let judged = |line: &&Line| {
        evidence
            .judged
            .iter()
            .any(|band| band.contains(line.frequency_hz))
    };
    let compared: Vec<Line> = lines.compared.iter().filter(judged).copied().collect();
    let sensitivity = |hz: f64| config.weighting.threshold_m_s2(Hertz(hz)).powi(-2);
    let mut criteria = Vec::new();
    let mut push = |what: VerifyCriterion, weight: &dyn Fn(&Line) -> f64| {
        let limit = Limit::at_most(limits.error_db_rms);
        criteria.push(match rms_error(&compared, weight) {
            Some((value, interval)) => of(what, "dB", Found { value, interval }, limit),
            None => Criterion::unmeasured(what, "dB", limit),
        });
    };
    push(VerifyCriterion::SpectrumError, &|_| 1.0);
    push(VerifyCriterion::PowerWeightedError, &|line| {
        line.pooled_power()
    });
    if evidence.felt {
        push(VerifyCriterion::FeltWeightedError, &|line| {
            line.pooled_power() * sensitivity(line.frequency_hz)
        });
    }
    let in_band: f64 = lines
        .compared
        .iter()
        .map(|line| line.target_power)
        .sum::<f64>()
        + lines.hidden_power;
    let added = lines.added / in_band.max(f64::MIN_POSITIVE);
    criteria.push(Criterion::new(
        VerifyCriterion::AddedPower,
        "",
        added,
        None,
        Limit::at_most(limits.added_power),
    ));
    if evidence.felt {
        let Pair {
            target,
            measured,
            variance_db2,
            resolution_hz,
            ..
        } = evidence.outside;
        let noise = |hz: f64| evidence.floor.map_or(0.0, |floor| floor.at(hz));
        let edge = config.rendered.map_or(0.0, |rendered| rendered.edge_ratio);
        let (mut beyond, mut scatter) = (0.0, 0.0);
        for k in 0..target.len().min(measured.len()) {
            let (hz, half_hz) = (k as f64 * resolution_hz, 0.5 * resolution_hz);
            let (t, m) = (target[k], measured[k]);
            // Power in the edges of the rendered band is not added power.
            let outside = hz + half_hz > FELT_HZ.0
                && hz - half_hz < FELT_HZ.1
                && (hz + half_hz < config.band.low().0 * (1.0 - edge)
                    || hz - half_hz > config.band.high().0 * (1.0 + edge));
            if outside && (m > STANDS_OUT * noise(hz) || t > noise(hz)) {
                let felt = resolution_hz * sensitivity(hz);
                beyond += (m - noise(hz) - t) * felt;
                // The difference of two realisations in a line.
                scatter += (m.max(t) * felt).powi(2) * variance_db2[k] / DB_PER_NEPER.powi(2);
            }
        }
        let reach = Z_95 * scatter.sqrt();
        let felt: f64 = lines
            .compared
            .iter()
            .map(|line| line.target_power * sensitivity(line.frequency_hz))
            .sum();
        // Power below the detection threshold is imperceptible, however weak the texture is.
        let share = |beyond: f64| beyond.max(0.0) / felt.max(1.0);
        criteria.push(Criterion::new(
            VerifyCriterion::FeltOutside,
            "",
            share(beyond),
            Some([share(beyond - reach), share(beyond + reach)]),
            Limit::at_most(limits.added_power),
        ));
    }
    let all = lines.compared.len() + lines.hidden;
    if lines.hidden > 0 {
        more.push(Warning::from(RenderWarning::BandPartLost {
            share: lines.hidden as f64 / all.max(1) as f64,
            bands: Vec::new(),
            why: PartLost::HiddenByNoise {
                power_share: lines.hidden_power / in_band.max(f64::MIN_POSITIVE),
            },
        }));
    }
    criteria
}

/// The share of samples at a limit: found as flat tops, or because a limit explains the waveform better than a pure gain.
fn limited(evidence: &Evidence<'_>, all: &Sums, noise_power: f64) -> Criterion<VerifyCriterion> {
    let compared = compared(evidence, noise_power);
    let limit = Limit::at_most(evidence.config.limits.clipped_fraction);
    let saturated = if all.follows() {
        compared.saturated_share()
    } else {
        0.0
    };
    // A peak that the target has at the same height was not clipped.
    let sensor = if all.follows() && !compared.exceeded() {
        0.0
    } else {
        evidence.clipped
    };
    let found = sensor.max(evidence.clipped_drive).max(saturated);
    let open = !all.follows() && compared.pressed();
    let interval = open.then_some([found, 1.0]);
    Criterion::new(VerifyCriterion::Clipped, "", found, interval, limit)
}

fn compared<'a>(evidence: &Evidence<'a>, noise_power: f64) -> Compared<'a> {
    let [target, measured] = evidence.waveforms;
    let effect = target.len() as f64 - 2.0 * evidence.silence_s * evidence.rate.hz();
    Compared {
        target,
        measured,
        rate_hz: evidence.rate.hz(),
        noise_power,
        effect_share: effect.max(1.0) / (target.len() as f64).max(1.0),
    }
}

/// The criteria on events in time: drop-outs, added events, short-time levels.
fn in_time(
    evidence: &Evidence<'_>,
    all: &Sums,
    noise_power: f64,
) -> Vec<Criterion<VerifyCriterion>> {
    let limits = &evidence.config.limits;
    let compared = compared(evidence, noise_power);
    let drop_out = Limit::at_most(limits.drop_out_s);
    let level = Limit::at_most(limits.short_time_level_db);
    // Another realisation of a texture may have its lulls at other times, but not longer ones. A target with silence of
    // its own may have it at other times.
    let free = evidence.config.mode == Mode::Texture && compared.own_lull_s() > limits.drop_out_s;
    let dropped = if all.follows() && !free {
        compared
            .dropped_while_following()
            .larger(compared.longer_lulls())
    } else {
        compared.longer_lulls().no_shorter_than(UNSEEN_S)
    };
    let dropped = dropped.larger(Found {
        value: evidence.bridged_s,
        interval: [evidence.bridged_s; 2],
    });
    let over_time = match evidence.config.mode {
        Mode::Replicate => compared
            .level_departure()
            .map(|value| Criterion::new(VerifyCriterion::ShortTimeLevel, "dB", value, None, level)),
        Mode::Texture => compared
            .level_distribution()
            .map(|found| of(VerifyCriterion::ShortTimeDistribution, "dB", found, level)),
    };
    let dropped = of(VerifyCriterion::DropOut, "s", dropped, drop_out);
    // So does a short effect of another phase: it begins and ends elsewhere.
    let short = evidence.config.mode == Mode::Texture && evidence.silence_s > 0.0;
    let added = if all.follows() && !free && !short {
        compared.added_while_following()
    } else {
        compared.added_crests()
    };
    let added = of(VerifyCriterion::AddedEvent, "s", added, Limit::at_most(0.0));
    [dropped, added].into_iter().chain(over_time).collect()
}

/// How much of the target was judged.
fn extent(evidence: &Evidence<'_>, lines: &Lines) -> Vec<Criterion<VerifyCriterion>> {
    let limits = &evidence.config.limits;
    let band = evidence.config.band;
    let step_hz = evidence.pair.resolution_hz;
    let judged = |hz: f64| evidence.judged.iter().any(|band| band.contains(hz));
    let (mut power, mut kept) = (0.0, 0.0);
    for (k, p) in evidence.asked_psd.iter().enumerate() {
        let hz = k as f64 * step_hz;
        if band.contains(hz) {
            power += p;
            kept += if judged(hz) { *p } else { 0.0 };
        }
    }
    let hidden = lines.hidden_power / (step_hz * power).max(f64::MIN_POSITIVE);
    let counted = lines
        .compared
        .iter()
        .filter(|line| judged(line.frequency_hz));
    let line_share = counted.count() as f64 / lines.compared.len().max(1) as f64;
    let least = limits.least_judged;
    vec![
        Criterion::new(
            VerifyCriterion::JudgedPower,
            "",
            (kept / power.max(f64::MIN_POSITIVE) - hidden).clamp(0.0, 1.0),
            None,
            Limit::AtLeast {
                met: limits.judged_power,
                not_met: least,
            },
        ),
        Criterion::new(
            VerifyCriterion::JudgedLines,
            "",
            line_share,
            None,
            Limit::at_least(least),
        ),
        Criterion::new(
            VerifyCriterion::Covered,
            "",
            evidence.covered,
            None,
            Limit::AtLeast {
                met: limits.covered,
                not_met: 0.0,
            },
        ),
    ]
}

/// The share of the power of the requested target, about its mean and in the band or not, that lies where it is judged, 0–1.
fn texture_share(evidence: &Evidence<'_>) -> f64 {
    let step_hz = evidence.pair.resolution_hz;
    let (mut power, mut kept) = (0.0, 0.0);
    // The window of a segment spreads a mean over two lines.
    for (k, p) in evidence.asked_psd.iter().enumerate().skip(2) {
        let hz = k as f64 * step_hz;
        power += p;
        if evidence.judged.iter().any(|band| band.contains(hz)) {
            kept += p;
        }
    }
    if power > 0.0 { kept / power } else { 1.0 }
}

/// Sums over target and measurement.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    target: f64,
    measured: f64,
    product: f64,
    /// The mean square of the sensor's noise.
    noise_power: f64,
}

impl Sums {
    fn without(self, other: Self) -> Self {
        Self {
            count: self.count - other.count,
            target: self.target - other.target,
            measured: self.measured - other.measured,
            product: self.product - other.product,
            noise_power: self.noise_power,
        }
    }

    /// The power of the measurement minus the noise, at least a hundredth of the measured power.
    fn left(&self) -> f64 {
        let left = self.measured - self.count * self.noise_power;
        left.max(0.01 * self.measured).max(f64::MIN_POSITIVE)
    }

    fn level_db(&self) -> f64 {
        10.0 * (self.left() / self.target.max(f64::MIN_POSITIVE)).log10()
    }

    fn plain_correlation(&self) -> f64 {
        let norm = (self.target * self.measured).sqrt();
        if norm > 0.0 { self.product / norm } else { 0.0 }
    }

    /// Whether the measurement follows its target in time.
    fn follows(&self) -> bool {
        self.plain_correlation().abs() > FOLLOWS
    }

    /// The correlation, corrected for the sensor's noise.
    fn correlation(&self) -> f64 {
        let norm = (self.target * self.left()).sqrt().max(f64::MIN_POSITIVE);
        (self.product / norm).clamp(-1.0, 1.0)
    }

    /// The power of the difference minus the noise, re that of the target.
    fn nmse(&self) -> f64 {
        let difference = self.measured - 2.0 * self.product + self.target;
        let left = (difference - self.count * self.noise_power).max(0.01 * difference);
        left.max(0.0) / self.target.max(f64::MIN_POSITIVE)
    }
}

/// Sums over blocks of time, for the jackknife.
struct Blocks(Vec<Sums>);

/// dB of a power whose natural logarithm changes by 1.
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;
/// The length of a block, s, and the fewest.
const BLOCK_S: f64 = 0.25;
const FEWEST_BLOCKS: usize = 8;

impl Blocks {
    fn of(target: &[f64], measured: &[f64], noise_power: f64, rate_hz: f64) -> Self {
        let count = target.len().min(measured.len());
        let blocks = ((count as f64 / rate_hz / BLOCK_S) as usize).max(FEWEST_BLOCKS);
        let length = count.div_ceil(blocks).max(1);
        let pairs = target.chunks(length).zip(measured.chunks(length));
        Self(
            pairs
                .map(|(t, m)| Sums {
                    count: t.len() as f64,
                    target: t.iter().map(|v| v * v).sum(),
                    measured: m.iter().map(|v| v * v).sum(),
                    product: t.iter().zip(m).map(|(t, m)| t * m).sum(),
                    noise_power,
                })
                .collect(),
        )
    }

    fn all(&self) -> Sums {
        let mut all = Sums::default();
        for block in &self.0 {
            all.count += block.count;
            all.target += block.target;
            all.measured += block.measured;
            all.product += block.product;
            all.noise_power = block.noise_power;
        }
        all
    }

    /// The level of the measurement re that of the target, dB. When the measurement follows its target, the two scatter
    /// together; otherwise the interval is that of the jackknife over blocks.
    ///
    /// Formula: the variance of 10·log10 of the ratio of two powers is (10/ln 10)²·2·(1 − r²)/(B·T).
    fn level_db(&self, bandwidth_s: f64) -> Found {
        let all = self.all();
        let value = all.level_db();
        if !all.follows() {
            return self.jackknife(&Sums::level_db);
        }
        let apart = 1.0 - all.correlation().powi(2);
        // The noise correlates with the texture by chance, and its power is itself an estimate.
        let noise = all.noise_power * all.count / all.left();
        let of_noise = 4.0 * noise + 4.0 * noise * noise;
        let squares = (2.0 * apart + of_noise) / bandwidth_s.max(1.0);
        let reach = Z_95 * DB_PER_NEPER * squares.sqrt();
        Found {
            value,
            interval: [value - reach, value + reach],
        }
    }

    /// The correlation of these waveforms; as it describes these samples, its interval comes from the sensor's noise alone.
    fn correlation(&self, bandwidth_s: f64) -> Found {
        let value = self.all().correlation();
        let reach = Z_95 * (1.0 - value) / bandwidth_s.max(1.0).sqrt();
        Found {
            value,
            interval: [value - reach, (value + reach).min(1.0)],
        }
    }

    /// The power of the waveforms' difference over that of the target, dB, likewise.
    fn nmse_db(&self, bandwidth_s: f64) -> Found {
        let value = 10.0 * self.all().nmse().max(1e-32).log10();
        let reach = Z_95 * DB_PER_NEPER / bandwidth_s.max(1.0).sqrt();
        Found {
            value,
            interval: [value - reach, value + reach],
        }
    }

    /// `statistic` of all, with its 95 % interval by the jackknife over blocks.
    fn jackknife(&self, statistic: &dyn Fn(&Sums) -> f64) -> Found {
        let all = self.all();
        let value = statistic(&all);
        let n = self.0.len() as f64;
        let left_out: Vec<f64> = self
            .0
            .iter()
            .map(|block| statistic(&all.without(*block)))
            .collect();
        let middle = left_out.iter().sum::<f64>() / n.max(1.0);
        let squares: f64 = left_out.iter().map(|v| (v - middle).powi(2)).sum();
        let error = ((n - 1.0) / n.max(1.0) * squares).sqrt();
        let quantile = StudentsT::new(0.0, 1.0, (n - 1.0).max(1.0))
            .map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
        let reach = if error > 0.0 { quantile * error } else { 0.0 };
        Found {
            value,
            interval: [value - reach, value + reach],
        }
    }
}

/// The bandwidth of white noise with the same scatter as the target's lines within `judged`, Hz.
///
/// Formula: (ΣS)²/ΣS²·Δf.
fn effective_bandwidth_hz(pair: &Pair, judged: &[Band]) -> f64 {
    let lines = pair.target.iter().enumerate();
    let (sum, squares) = lines
        .filter(|(k, _)| {
            let hz = *k as f64 * pair.resolution_hz;
            judged.iter().any(|band| band.contains(hz))
        })
        .fold((0.0, 0.0), |(sum, squares), (_, p)| {
            (sum + p, squares + p * p)
        });
    if squares > 0.0 {
        sum * sum / squares * pair.resolution_hz
    } else {
        pair.resolution_hz
    }
}
