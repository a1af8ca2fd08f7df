//! Event-related desynchronisation (ERD, negative) and synchronisation (ERS, positive): power in a window relative to a baseline.
//!
//! Power is averaged over epochs first, and the averages are divided: a ratio of each epoch, averaged, is biased upwards by a quarter and
//! more (0 % shows as +28 % in MNE-Python's own example), because an epoch whose baseline is low by chance counts most.

use piezotact::Warning;
use piezotact::quantity::{Band, Hertz};
use piezotact::statistics::{mean, median, t_quantile};
use serde::{Deserialize, Serialize};
use statrs::function::gamma::digamma;

use super::epochs::Epochs;
use super::tfr::{Power, SpreadSink, TfrError, TfrPlan, TrialPowers, Window, WindowSink};
use super::{Bias, EegWarning, Smeared};

/// A bias of so many percentage points is a warning.
pub(super) const BIAS_POINTS: f64 = 1.0;
/// So many standard deviations of the wavelet are what it reaches: 0.2 % of its energy lies beyond them.
const REACH: f64 = 2.0;

/// The unit of a change of power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// 100·(A − R)/R, %: −100 where nothing is left.
    Percent,
    /// 10·log₁₀(A/R), dB.
    Decibels,
}

impl Mode {
    fn change(self, window: f64, baseline: f64) -> f64 {
        match self {
            Self::Percent => 100.0 * (window - baseline) / baseline,
            Self::Decibels => 10.0 * (window / baseline).log10(),
        }
    }
}

/// What is averaged before the baseline is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Power over epochs: the default.
    PowerFirst,
    /// Nothing: the percentages of single epochs are averaged, which is biased.
    PercentOfEachEpoch,
}

/// What is compared with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErdConfig {
    /// The band; power is the mean over the planned frequencies in it.
    pub band: Band,
    /// The baseline from the event, s.
    pub baseline_s: [f64; 2],
    /// The window from the event, s.
    pub window_s: [f64; 2],
    /// The unit of the change.
    pub mode: Mode,
    /// With fewer epochs there is no result.
    pub min_epochs: usize,
}

/// The change of power of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelErd {
    /// The name of the channel.
    pub channel: String,
    /// The change in the unit of the mode; negative is a desynchronisation.
    pub change: f64,
    /// The mean power in the baseline, V².
    pub baseline_power: f64,
    /// The mean power in the window, V².
    pub window_power: f64,
    /// The bias that a true change of 0 would have, estimated, percentage points.
    pub bias_points: f64,
    /// The change of all epochs but one, of every epoch in order.
    pub without_each: Vec<f64>,
}

/// The change of power of all channels, with all that it depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Erd {
    pub config: ErdConfig,
    /// What was averaged first.
    pub order: Order,
    /// The largest temporal smear in the band, s.
    pub smear_s: f64,
    /// How many epochs it is of.
    pub epochs: usize,
    pub channels: Vec<ChannelErd>,
    /// What to know before relying on it.
    pub warnings: Vec<Warning>,
}

/// The change of power over time and frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct ErdMap {
    /// The power that it was computed from; its values are replaced by the change in the unit of the mode.
    pub power: Power,
    /// The baseline from the event, s.
    pub baseline_s: [f64; 2],
    pub mode: Mode,
    /// What to know before relying on it.
    pub warnings: Vec<Warning>,
}

/// ERD/ERS of each channel: the mean power over epochs, band and window relative to that over epochs, band and baseline, in the unit of
/// the mode.
///
/// Formula: A and R are means over epochs, times and frequencies; 100·(A − R)/R or 10·log₁₀(A/R). The bias of the ratio is var(R)/R².
///
/// Source: G. Pfurtscheller and F. H. Lopes da Silva (1999), Clin. Neurophysiol. 110; order of averages: R. Grandchamp and A. Delorme (2011),
/// Front. Psychol. 2.
///
/// # Errors
/// [`TfrError`] for fewer epochs than asked for or 2, a baseline or window that is not within the epoch or only where the wavelet reaches
/// beyond its ends, a baseline that overlaps the window, and a baseline without power.
pub fn desynchronisation(
    plan: &TfrPlan,
    epochs: &Epochs,
    config: &ErdConfig,
) -> Result<Erd, TfrError> {
    let checked = checked(plan, epochs, config)?;
    let trials = plan.trials(epochs, &config.windows())?;
    let mut found = power_first(epochs, config, (&trials, 0), checked)?;
    let bias = found.ratio_bias();
    found.warnings.extend(bias);
    Ok(found)
}

impl Erd {
    /// The warning about the channel whose percentage is biased most, where that is much.
    fn ratio_bias(&self) -> Option<Warning> {
        let (channel, bias_points) = most_biased(&self.channels)?;
        let is_biased = self.config.mode == Mode::Percent && bias_points > BIAS_POINTS;
        let bias = EegWarning::Biased {
            channel,
            epochs: self.epochs,
            by: Bias::Ratio { bias_points },
        };
        is_biased.then(|| bias.into())
    }
}

/// The change of mean power from the windows of baseline and window, which stand at `first` and behind it.
fn power_first(
    epochs: &Epochs,
    config: &ErdConfig,
    (trials, first): (&TrialPowers, usize),
    (smear_s, warnings): (f64, Vec<Warning>),
) -> Result<Erd, TfrError> {
    let mut channels = Vec::with_capacity(epochs.channels().len());
    for (i, channel) in epochs.channels().iter().enumerate() {
        let baselines = trials.of(i, first);
        let (baseline_power, window_power) = (mean(baselines), mean(trials.of(i, first + 1)));
        has_power(channel, baseline_power)?;
        let n = baselines.len() as f64;
        let squares: f64 = baselines.iter().map(|r| (r - baseline_power).powi(2)).sum();
        let variance = squares / (n - 1.0) / n;
        let without = |mean: f64, one: f64| (n * mean - one) / (n - 1.0);
        let pairs = baselines.iter().zip(trials.of(i, first + 1));
        let without_each = pairs.map(|(r, a)| {
            (config.mode).change(without(window_power, *a), without(baseline_power, *r))
        });
        channels.push(ChannelErd {
            channel: channel.clone(),
            change: config.mode.change(window_power, baseline_power),
            baseline_power,
            window_power,
            bias_points: 100.0 * variance / (baseline_power * baseline_power),
            without_each: without_each.collect(),
        });
    }
    Ok(Erd {
        config: *config,
        order: Order::PowerFirst,
        smear_s,
        epochs: epochs.count(),
        channels,
        warnings,
    })
}

/// The mean of the changes of single epochs, as [`power_first`]: **biased** upwards, so that a desynchronisation looks too small, or like a
/// synchronisation. It is here to repeat what others computed.
///
/// Formula: the mean of 100·(Aₑ − Rₑ)/Rₑ. Its bias at no change is 100·(mean(R)·mean(1/R) − 1), which the result and its warning state.
///
/// Source: as MNE-Python's `apply_baseline(mode="percent")` on single epochs; R. Grandchamp and A. Delorme (2011), Front. Psychol. 2 for the bias.
fn percent_of_each_epoch(
    epochs: &Epochs,
    config: &ErdConfig,
    (trials, first): (&TrialPowers, usize),
    (smear_s, mut warnings): (f64, Vec<Warning>),
) -> Result<Erd, TfrError> {
    let mut channels = Vec::with_capacity(epochs.channels().len());
    for (i, channel) in epochs.channels().iter().enumerate() {
        let (baselines, windows) = (trials.of(i, first), trials.of(i, first + 1));
        for baseline in baselines {
            has_power(channel, *baseline)?;
        }
        let changes: Vec<f64> = baselines
            .iter()
            .zip(windows)
            .map(|(r, a)| config.mode.change(*a, *r))
            .collect();
        let inverse: Vec<f64> = baselines.iter().map(|r| 1.0 / r).collect();
        let (n, change) = (changes.len() as f64, mean(&changes));
        let without_each = changes.iter().map(|one| (n * change - one) / (n - 1.0));
        channels.push(ChannelErd {
            channel: channel.clone(),
            change,
            baseline_power: mean(baselines),
            window_power: mean(windows),
            bias_points: 100.0 * (mean(baselines) * mean(&inverse) - 1.0),
            without_each: without_each.collect(),
        });
    }
    if let Some((channel, bias_points)) = most_biased(&channels) {
        warnings.push(
            EegWarning::Biased {
                channel,
                epochs: epochs.count(),
                by: Bias::EachEpoch { bias_points },
            }
            .into(),
        );
    }
    Ok(Erd {
        config: *config,
        order: Order::PercentOfEachEpoch,
        smear_s,
        epochs: epochs.count(),
        channels,
        warnings,
    })
}

/// The change of mean power at each channel, frequency and time relative to the mean of the baseline at this channel and frequency, in the
/// unit of the mode.
///
/// Source: as MNE-Python's `apply_baseline` (`percent` × 100, `logratio` × 10) on averaged power.
///
/// # Errors
/// [`TfrError`] for fewer epochs than asked for or 2, a baseline outside the epochs or only where the wavelet reaches beyond their ends, and
/// a baseline without power.
pub fn map(
    power: &Power,
    baseline_s: [f64; 2],
    mode: Mode,
    min_epochs: usize,
) -> Result<ErdMap, TfrError> {
    let range = super::tfr::times_within(&power.times_s, baseline_s);
    if range.is_empty() {
        return Err(TfrError::Outside {
            part: Part::Baseline,
            from_s: baseline_s[0],
            to_s: baseline_s[1],
            first_s: power.extent_s[0],
            last_s: power.extent_s[1],
        });
    }
    let lines = power.values.chunks_exact(power.times_s.len());
    let baselines: Vec<f64> = lines.map(|line| mean(&line[range.clone()])).collect();
    map_of(power.clone(), (baseline_s, &baselines), mode, min_epochs)
}

/// The same with the mean power in the baseline of each channel and frequency.
fn map_of(
    mut power: Power,
    (baseline_s, baselines): ([f64; 2], &[f64]),
    mode: Mode,
    min_epochs: usize,
) -> Result<ErdMap, TfrError> {
    enough(power.epochs, min_epochs)?;
    let smear_s = power.smears_s.iter().copied().fold(0.0, f64::max);
    let mut warnings = Vec::new();
    within(
        Part::Baseline,
        baseline_s,
        power.extent_s,
        smear_s,
        &mut warnings,
    )?;
    let (times, lines) = (power.times_s.len(), power.frequencies_hz.len());
    let changed = power.values.chunks_exact_mut(times).zip(baselines);
    for (i, (line, baseline)) in changed.enumerate() {
        has_power(&power.channels[i / lines], *baseline)?;
        for value in line {
            *value = mode.change(*value, *baseline);
        }
    }
    Ok(ErdMap {
        power,
        baseline_s,
        mode,
        warnings,
    })
}

/// The changes in several bands and over time and frequency, of one pass over the epochs.
pub(super) struct Changes {
    /// One for each band.
    pub(super) bands: Vec<Erd>,
    /// In dB, at every so many-th sample; relative to the baseline at the full rate.
    pub(super) map: ErdMap,
    /// The level of the power in the baseline of the map, channels × frequencies, dB re 1 µV²; free of the bias of the logarithm.
    pub(super) baselines_db: Vec<f64>,
    /// The channel whose power scatters most from epoch to epoch, and its median variance over its squared mean: 1 for noise.
    pub(super) most_scattered: Option<(String, f64)>,
}

/// The changes in the bands of `configs`, which share baseline, window and number of epochs, and the map at every so many-th sample. All means
/// over baseline and window are those of all samples: `every` changes none of them. The map is free of the bias of the logarithm.
///
/// Formula: a mean of n epochs whose squared standard error is v of its square is taken for a Gamma variable of shape α = n/((n + 1)·v),
/// whose logarithm is ψ(α) − ln α too low; this is taken away from the power at each time and from that of the baseline.
///
/// Source: [`desynchronisation`] and [`map`]; M. Abramowitz and I. A. Stegun (1964), *Handbook of Mathematical Functions*, 6.3, for ψ; the correction is this project's (docs/decisions/eeg.md).
pub(super) fn changes(
    plan: &TfrPlan,
    epochs: &Epochs,
    configs: &[ErdConfig],
    order: Order,
    every: usize,
) -> Result<Changes, TfrError> {
    let checked = configs.iter().map(|config| checked(plan, epochs, config));
    let checked = checked.collect::<Result<Vec<_>, _>>()?;
    let first = configs.first().ok_or(TfrError::NoBand)?;
    let mut windows: Vec<Window> = configs.iter().flat_map(ErdConfig::windows).collect();
    let of_map = windows.len();
    for hz in &plan.config().frequencies_hz {
        // A band of this frequency alone.
        let band = Band::new(Hertz(hz * (1.0 - 1e-9)), Hertz(hz * (1.0 + 1e-9)));
        windows.push(Window {
            band: band.map_err(|_no_band| TfrError::NoBand)?,
            extent_s: first.baseline_s,
        });
    }
    let mut spread = SpreadSink::new(plan, epochs, every);
    let mut trials = WindowSink::new(plan, epochs, &windows)?;
    plan.run(epochs, &mut (&mut spread, &mut trials))?;
    let ((power, errors), trials) = (spread.finish(plan, epochs), trials.finish());
    let bands = configs.iter().zip(checked).enumerate();
    let bands = bands.map(|(i, (config, checked))| match order {
        Order::PowerFirst => power_first(epochs, config, (&trials, 2 * i), checked),
        Order::PercentOfEachEpoch => {
            percent_of_each_epoch(epochs, config, (&trials, 2 * i), checked)
        }
    });
    let bands = bands.collect::<Result<Vec<_>, _>>()?;
    let channels = 0..epochs.channels().len();
    let baselines: Vec<&[f64]> = channels
        .flat_map(|channel| (of_map..windows.len()).map(move |window| (channel, window)))
        .map(|(channel, window)| trials.of(channel, window))
        .collect();
    let means: Vec<f64> = baselines.iter().map(|of| mean(of)).collect();
    let baseline = (first.baseline_s, means.as_slice());
    let mut map = map_of(power, baseline, Mode::Decibels, first.min_epochs)?;
    let n = epochs.count();
    let times = map.power.times_s.len();
    let each = times * map.power.frequencies_hz.len();
    let scattered = epochs.channels().iter().zip(errors.chunks_exact(each));
    let scattered = scattered.map(|(name, errors)| {
        let usual = median(&mut errors.to_vec()).unwrap_or(0.0);
        (name.clone(), usual * n as f64)
    });
    let most_scattered = scattered.max_by(|a, b| a.1.total_cmp(&b.1));
    let biases = baselines.iter();
    let biases_db: Vec<f64> = biases
        .map(|of| log_bias_db(relative_error(of), n))
        .collect();
    for (i, value) in map.power.values.iter_mut().enumerate() {
        *value -= log_bias_db(errors[i], n) - biases_db[i / times];
    }
    let levels = means.iter().zip(biases_db);
    Ok(Changes {
        bands,
        map,
        baselines_db: levels
            .map(|(power, bias)| level_db(*power) - bias)
            .collect(),
        most_scattered,
    })
}

/// The 95 % confidence interval of a change over the epochs of one person, from the changes `without_each` of them, all as shares (−1 where no power is left); `None`
/// for fewer than two epochs, and where no power is left.
///
/// Formula: y = ln(1 + c) of all epochs and y₋ₑ without epoch e; s² = (n − 1)/n·Σ(y₋ₑ − ȳ)²; y ± t₀.₉₇₅(n − 1)·s.
///
/// Source: the jackknife of J. W. Tukey (1958), Ann. Math. Stat. 29, as in B. Efron and R. J. Tibshirani (1993), *An Introduction to the
/// Bootstrap*, chapter 11; of the logarithm, so that no end is below −1.
#[must_use]
pub fn interval_over_epochs(change_share: f64, without_each: &[f64]) -> Option<[f64; 2]> {
    let n = without_each.len();
    let t = t_quantile(n.checked_sub(1)?)?;
    let logs: Vec<f64> = without_each.iter().map(|change| change.ln_1p()).collect();
    let middle = mean(&logs);
    let squares: f64 = logs.iter().map(|y| (y - middle).powi(2)).sum();
    let reach = t * (squares * (n as f64 - 1.0) / n as f64).sqrt();
    let y = change_share.ln_1p();
    let ends = [y - reach, y + reach].map(f64::exp_m1);
    ends.iter().all(|end| end.is_finite()).then_some(ends)
}

/// The level of a power, V², in dB re 1 µV².
pub(super) fn level_db(power_v2: f64) -> f64 {
    10.0 * (power_v2 * 1e12).log10()
}

/// The squared standard error of the mean of `values` re its square.
fn relative_error(values: &[f64]) -> f64 {
    let (n, mean) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    squares / (n - 1.0) / n / (mean * mean)
}

/// The bias of the level of a mean of `n` powers whose squared standard error is `error` of its square, dB; not above 0.
fn log_bias_db(error: f64, n: usize) -> f64 {
    let n = n as f64;
    // Of exponential powers the estimate is n/(n + 1) of what it estimates.
    let shape = n / ((n + 1.0) * error);
    if !(shape.is_finite() && shape > 0.0) {
        return 0.0;
    }
    10.0 / std::f64::consts::LN_10 * (digamma(shape) - shape.ln())
}

impl ErdConfig {
    /// Baseline and window.
    fn windows(&self) -> [Window; 2] {
        [self.baseline_s, self.window_s].map(|extent_s| Window {
            band: self.band,
            extent_s,
        })
    }
}

/// Checks that baseline and window can be measured; the smear in the band, and warnings.
fn checked(
    plan: &TfrPlan,
    epochs: &Epochs,
    config: &ErdConfig,
) -> Result<(f64, Vec<Warning>), TfrError> {
    enough(epochs.count(), config.min_epochs)?;
    let hz = &plan.config().frequencies_hz;
    let smear_s = hz
        .iter()
        .zip(plan.smears_s())
        .filter(|(hz, _)| config.band.contains(**hz))
        .map(|(_, smear)| *smear)
        .fold(0.0, f64::max);
    let extent_s = [epochs.first_s(), epochs.last_s()];
    let mut warnings = Vec::new();
    within(
        Part::Baseline,
        config.baseline_s,
        extent_s,
        smear_s,
        &mut warnings,
    )?;
    within(
        Part::Window,
        config.window_s,
        extent_s,
        smear_s,
        &mut warnings,
    )?;
    let gap_s =
        (config.window_s[0] - config.baseline_s[1]).max(config.baseline_s[0] - config.window_s[1]);
    if gap_s < 0.0 {
        return Err(TfrError::Overlap { by_s: -gap_s });
    }
    let reach_s = REACH * smear_s;
    if gap_s < reach_s {
        warnings.push(
            EegWarning::Smeared {
                by: Smeared::Baseline { gap_s, reach_s },
            }
            .into(),
        );
    }
    Ok((smear_s, warnings))
}

fn enough(found: usize, min_epochs: usize) -> Result<(), TfrError> {
    let needed = min_epochs.max(2);
    if found < needed {
        return Err(TfrError::FewEpochs { found, needed });
    }
    Ok(())
}

fn has_power(channel: &str, power: f64) -> Result<(), TfrError> {
    if power > 0.0 && power.is_finite() {
        return Ok(());
    }
    Err(TfrError::NoPower {
        channel: channel.to_owned(),
    })
}

fn most_biased(channels: &[ChannelErd]) -> Option<(String, f64)> {
    let most = channels
        .iter()
        .max_by(|a, b| a.bias_points.total_cmp(&b.bias_points));
    most.map(|one| (one.channel.clone(), one.bias_points))
}

/// Checks that a part lies within the epoch, and how much of it the ends of the epoch touch.
fn within(
    part: Part,
    [from_s, to_s]: [f64; 2],
    [first_s, last_s]: [f64; 2],
    smear_s: f64,
    warnings: &mut Vec<Warning>,
) -> Result<(), TfrError> {
    let slack = 1e-9;
    if !(from_s < to_s && from_s >= first_s - slack && to_s <= last_s + slack) {
        return Err(TfrError::Outside {
            part,
            from_s,
            to_s,
            first_s,
            last_s,
        });
    }
    let reach_s = REACH * smear_s;
    let free = (to_s.min(last_s - reach_s) - from_s.max(first_s + reach_s)).max(0.0);
    let touched_share = 1.0 - free / (to_s - from_s);
    if free == 0.0 {
        return Err(TfrError::AtEdge {
            part,
            from_s,
            to_s,
            reach_s,
        });
    }
    if touched_share > slack {
        warnings.push(
            EegWarning::Smeared {
                by: Smeared::Edge {
                    window: part.to_string(),
                    touched_share,
                    reach_s,
                },
            }
            .into(),
        );
    }
    Ok(())
}

/// Which part of an epoch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The baseline.
    Baseline,
    /// The window.
    Window,
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Baseline => "baseline",
            Self::Window => "window",
        })
    }
}
