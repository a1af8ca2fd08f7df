//! One clock for two devices: drift and jitter from pulses that both recorded.

use crate::eeg::epochs::EpochsError;
use piezotact::Warning;
use piezotact::statistics::{median, t_quantile};
use serde::{Deserialize, Serialize};

use super::{EegWarning, MarkersFault};

/// So many pulses of a list are tried as the first that both have.
const STARTS: usize = 12;
/// Fewer shared pulses give no line.
const FEWEST: usize = 3;
/// A pulse further from the line than this many robust standard deviations is left out of it.
const OUTLIER: f64 = 5.0;
/// A robust standard deviation is this times the median deviation (Gaussian).
const OF_MEDIAN: f64 = 1.4826;
/// The most fits of a line, each without the outliers of the one before.
const FITS: usize = 10;
/// A step of time below this is one, s.
const SAME_S: f64 = 1e-9;

/// How pulses of two devices are matched. There is no default: it is stated, and goes into the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PulseConfig {
    /// Two intervals that differ by no more than this are the same, s.
    pub tolerance_s: f64,
    /// The largest drift that is looked for, parts per million.
    pub largest_drift_ppm: f64,
}

impl PulseConfig {
    /// 20 ms and 500 ppm: what sound cards, amplifiers and acquisition cards stay below.
    #[must_use]
    pub fn of_devices() -> Self {
        Self {
            tolerance_s: 0.02,
            largest_drift_ppm: 500.0,
        }
    }
}

/// How the clock of a second device runs against that of a first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SharedClock {
    /// How pulses were matched.
    pub config: PulseConfig,
    /// The time on the second clock at 0 s of the first, s.
    pub offset_s: f64,
    /// How much faster the second clock runs, parts per million: above 0 it counts more seconds.
    pub drift_ppm: f64,
    /// The 95 % interval of the drift, parts per million.
    pub drift_interval_ppm: [f64; 2],
    /// The standard deviation of pulses about the line, of both devices together, ms.
    pub jitter_ms: f64,
    /// The pulse furthest from the line among those that it was fitted to, ms.
    pub largest_ms: f64,
    /// How many pulses the line was fitted to.
    pub matched: usize,
    /// Shared pulses that are too far from the line, and left out of it.
    pub outliers: usize,
    /// Pulses of the first device that the second does not have.
    pub only_first: usize,
    /// Pulses of the second device that the first does not have.
    pub only_second: usize,
    /// The first and the last shared pulse on the first clock, s.
    pub extent_s: [f64; 2],
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl SharedClock {
    /// The result in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let [low, high] = self.drift_interval_ppm;
        format!(
            "The second clock runs {:+.2} ppm against the first (95 %: {low:+.2} to {high:+.2}), offset {:.4} s, jitter {:.3} ms SD of \
             {} shared pulses over {:.1} s",
            self.drift_ppm,
            self.offset_s,
            self.jitter_ms,
            self.matched,
            self.extent_s[1] - self.extent_s[0]
        )
        .replace('-', "−")
    }
}

/// How the clock of a second device runs against that of a first, from the times of pulses that both recorded, s, each on its own
/// clock. Either may have pulses that the other lacks.
///
/// Formula: pulses are matched by the intervals between them, from the start that matches most; least squares give
/// second = offset + (1 + drift)·first, without pulses further from the line than five robust standard deviations. The interval is
/// Student's t with the scatter about the line; jitter is that scatter.
///
/// Source: least squares; the need for one clock: C. Kothe et al. (2025), *The Lab Streaming Layer*, Imaging Neurosci. 3.
///
/// # Errors
/// [`EpochsError`] for times that are not finite and ascending, a tolerance or drift that is not above 0, or fewer than three shared
/// pulses.
///
/// ```
/// use piezotact_people::eeg::pulses::{PulseConfig, shared_clock};
/// let first: Vec<f64> = (0..60).map(f64::from).collect();
/// let second: Vec<f64> = first.iter().map(|t| 3.0 + t * 1.000_05).collect();
/// let found = shared_clock(&first, &second, &PulseConfig::of_devices()).unwrap();
/// assert!((found.drift_ppm - 50.0).abs() < 1e-3 && (found.offset_s - 3.0).abs() < 1e-6);
/// ```
pub fn shared_clock(
    first_s: &[f64],
    second_s: &[f64],
    config: &PulseConfig,
) -> Result<SharedClock, EpochsError> {
    check(first_s, Device::First)?;
    check(second_s, Device::Second)?;
    if !(config.tolerance_s > 0.0 && config.largest_drift_ppm > 0.0) {
        return Err(EpochsError::Shape {
            expected: "a tolerance and a largest drift above 0".to_owned(),
            found: format!(
                "{} s and {} ppm",
                config.tolerance_s, config.largest_drift_ppm
            ),
        });
    }
    let (pairs, others) = matched(first_s, second_s, config);
    if pairs.len() < FEWEST {
        return Err(EpochsError::FewShared {
            found: pairs.len(),
            first: first_s.len(),
            second: second_s.len(),
        });
    }
    let points: Vec<(f64, f64)> = pairs
        .iter()
        .map(|(i, j)| (first_s[*i], second_s[*j]))
        .collect();
    let (line, kept) = robust_line(&points);
    let within: Vec<f64> = points
        .iter()
        .map(|point| line.residual(*point).abs())
        .filter(|residual| *residual <= kept)
        .collect();
    let reach = t_quantile(within.len() - 2).unwrap_or(f64::INFINITY) * line.slope_error;
    let drift = line.slope - 1.0;
    let warning = EegWarning::Markers {
        fault: MarkersFault::Periodic {
            matched: pairs.len(),
            shift_s: others.unwrap_or_default(),
        },
    };
    Ok(SharedClock {
        config: *config,
        offset_s: line.offset,
        drift_ppm: 1e6 * drift,
        drift_interval_ppm: [1e6 * (drift - reach), 1e6 * (drift + reach)],
        jitter_ms: 1e3 * line.scatter,
        largest_ms: 1e3 * within.iter().copied().fold(0.0, f64::max),
        matched: within.len(),
        outliers: points.len() - within.len(),
        only_first: first_s.len() - points.len(),
        only_second: second_s.len() - points.len(),
        extent_s: [points[0].0, points[points.len() - 1].0],
        warnings: others.map(|_| warning.into()).into_iter().collect(),
    })
}

/// The pairs of pulses that most starts agree on, and by how much another start with as many pairs is shifted, s.
fn matched(
    first_s: &[f64],
    second_s: &[f64],
    config: &PulseConfig,
) -> (Vec<(usize, usize)>, Option<f64>) {
    let spread = |count: usize| -> Vec<usize> {
        let starts = count.min(STARTS);
        (0..starts).map(|k| k * count / starts.max(1)).collect()
    };
    let from_first = spread(first_s.len())
        .into_iter()
        .flat_map(|i| (0..second_s.len()).map(move |j| (i, j)));
    let mut best = Vec::new();
    let mut shifts: Vec<(usize, f64)> = Vec::new();
    for start in from_first {
        let pairs = walk(first_s, second_s, start, config);
        shifts.push((pairs.len(), second_s[start.1] - first_s[start.0]));
        if pairs.len() > best.len() {
            best = pairs;
        }
    }
    let Some((i, j)) = best.first().copied() else {
        return (best, None);
    };
    // A start later in the same match has an offset that drift moved.
    let own = second_s[j] - first_s[i];
    let allowed = |shift: f64| {
        let span = first_s[first_s.len() - 1] - first_s[0];
        (shift - own).abs() <= config.tolerance_s + 1e-6 * config.largest_drift_ppm * span
    };
    let other = shifts
        .iter()
        .filter(|(count, shift)| *count == best.len() && !allowed(*shift))
        .map(|(_, shift)| shift - own)
        .min_by(|a, b| a.abs().total_cmp(&b.abs()));
    (best, other)
}

/// The pairs that follow from `start`, forwards and backwards: each pulse is matched by its interval to the last one matched.
fn walk(
    first_s: &[f64],
    second_s: &[f64],
    start: (usize, usize),
    config: &PulseConfig,
) -> Vec<(usize, usize)> {
    let allowed = |interval: f64| config.tolerance_s + 1e-6 * config.largest_drift_ppm * interval;
    let mut pairs = Vec::new();
    // Backwards, times are counted from the start with the other sign.
    let mut last = start;
    let (mut i, mut j) = (start.0, start.1);
    while i > 0 && j > 0 {
        let (a, b) = (
            first_s[last.0] - first_s[i - 1],
            second_s[last.1] - second_s[j - 1],
        );
        if (a - b).abs() <= allowed(a) {
            (i, j) = (i - 1, j - 1);
            last = (i, j);
            pairs.push(last);
        } else if a < b {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    pairs.reverse();
    pairs.push(start);
    last = start;
    (i, j) = (start.0 + 1, start.1 + 1);
    while i < first_s.len() && j < second_s.len() {
        let (a, b) = (first_s[i] - first_s[last.0], second_s[j] - second_s[last.1]);
        if (a - b).abs() <= allowed(a) {
            last = (i, j);
            pairs.push(last);
            (i, j) = (i + 1, j + 1);
        } else if a < b {
            i += 1;
        } else {
            j += 1;
        }
    }
    pairs
}

/// A line through pairs of times.
struct Line {
    offset: f64,
    slope: f64,
    /// The standard error of the slope.
    slope_error: f64,
    /// The standard deviation about the line, s.
    scatter: f64,
}

impl Line {
    /// The line of least squares through at least three points.
    fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let x_mean = points.iter().map(|(x, _)| x).sum::<f64>() / n;
        let y_mean = points.iter().map(|(_, y)| y).sum::<f64>() / n;
        let squares: f64 = points.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
        // About the means and of the difference of the clocks: no digit of a small drift is lost.
        let products: f64 = points
            .iter()
            .map(|(x, y)| (x - x_mean) * ((y - y_mean) - (x - x_mean)))
            .sum();
        let drift = products / squares;
        let slope = 1.0 + drift;
        let offset = y_mean - slope * x_mean;
        let rest: f64 = points
            .iter()
            .map(|(x, y)| (y - offset - slope * x).powi(2))
            .sum();
        let scatter = (rest / (n - 2.0)).sqrt();
        Self {
            offset,
            slope,
            slope_error: scatter / squares.sqrt(),
            scatter,
        }
    }

    fn residual(&self, (x, y): (f64, f64)) -> f64 {
        y - self.offset - self.slope * x
    }
}

/// The line through the points that are not outliers of it, and how far from it these are at most.
fn robust_line(points: &[(f64, f64)]) -> (Line, f64) {
    let mut line = Line::through(points);
    let mut limit = f64::INFINITY;
    for _ in 0..FITS {
        let mut sizes: Vec<f64> = points.iter().map(|p| line.residual(*p).abs()).collect();
        let spread = OF_MEDIAN * median(&mut sizes).unwrap_or(0.0);
        let next = (OUTLIER * spread).max(SAME_S);
        let kept: Vec<(f64, f64)> = points
            .iter()
            .filter(|p| line.residual(**p).abs() <= next)
            .copied()
            .collect();
        if kept.len() < FEWEST {
            break;
        }
        let refitted = Line::through(&kept);
        let same = (refitted.slope - line.slope).abs() < 1e-15 && limit.is_finite();
        line = refitted;
        // What the last line was fitted to.
        limit = kept
            .iter()
            .map(|p| line.residual(*p).abs())
            .fold(0.0, f64::max);
        if same {
            break;
        }
    }
    (line, limit)
}

fn check(times_s: &[f64], device: Device) -> Result<(), EpochsError> {
    let ascending = times_s.windows(2).all(|pair| pair[1] - pair[0] > SAME_S);
    if times_s.iter().all(|t| t.is_finite()) && ascending {
        return Ok(());
    }
    Err(EpochsError::PulseOrder { device })
}

/// Whose pulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// The one whose clock is the reference.
    First,
    /// The other.
    Second,
}

impl std::fmt::Display for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::First => "first",
            Self::Second => "second",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

    /// Pulses about 1 s apart over ten minutes on two clocks, 50 ppm apart, each with a jitter up to 0.5 ms; of each some are missing
    /// and some are of its own.
    fn recorded(seed: u64, drift_ppm: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = move || rng.next_u64() as f64 / u64::MAX as f64 - 0.5;
        let (mut a, mut b) = (Vec::new(), Vec::new());
        let mut t = 2.0;
        while t < 602.0 {
            if draw() > -0.45 {
                a.push(t + 1e-3 * draw());
            }
            if draw() > -0.45 {
                b.push(17.3 + t * (1.0 + 1e-6 * drift_ppm) + 1e-3 * draw());
            }
            if draw() > 0.47 {
                b.push(17.3 + t + 0.4);
            }
            t += 1.0 + 0.3 * draw();
        }
        (a, b)
    }

    #[test]
    fn a_drift_of_50_ppm_is_found_within_1_ppm_over_ten_minutes() {
        let mut covered = 0;
        for seed in 0..100 {
            let (a, b) = recorded(seed, 50.0);
            let found = shared_clock(&a, &b, &PulseConfig::of_devices()).unwrap();
            assert!(
                (found.drift_ppm - 50.0).abs() < 1.0,
                "seed {seed}: {found:?}"
            );
            // Two uniform jitters of 1 ms: √2·1/√12 ms.
            assert!((found.jitter_ms - 0.408).abs() < 0.06, "seed {seed}");
            assert!(found.warnings.is_empty() && found.only_second > 0 && found.only_first > 0);
            let [low, high] = found.drift_interval_ppm;
            covered += usize::from(low <= 50.0 && 50.0 <= high);
        }
        assert!((88..=100).contains(&covered), "{covered} of 100 intervals");
    }

    #[test]
    fn regular_pulses_that_fit_twice_are_reported() {
        let a: Vec<f64> = (0..60).map(f64::from).collect();
        let whole = shared_clock(&a, &a, &PulseConfig::of_devices()).unwrap();
        assert!(whole.warnings.is_empty() && whole.matched == 60);
        // The first is missing in one list and the last in the other: nothing says by how much they are shifted.
        let found = shared_clock(&a[5..], &a[..50], &PulseConfig::of_devices()).unwrap();
        assert_eq!(found.warnings.len(), 1);
        assert!(found.drift_ppm.abs() < 1e-6);
    }

    #[test]
    fn what_is_no_clock_is_refused() {
        let config = PulseConfig::of_devices();
        let few = shared_clock(&[0.0, 1.0], &[0.0, 1.0, 5.0], &config);
        assert!(matches!(few, Err(EpochsError::FewShared { found: 2, .. })));
        assert!(matches!(
            shared_clock(&[1.0, 0.0], &[0.0], &config),
            Err(EpochsError::PulseOrder {
                device: Device::First
            })
        ));
        assert!(
            shared_clock(&[], &[], &config)
                .unwrap_err()
                .to_string()
                .contains("only 0 pulses")
        );
    }

    /// A pulse that one device saw 15 ms late is left out.
    #[test]
    fn a_late_pulse_is_an_outlier() {
        let (a, _) = recorded(1, 0.0);
        let mut b: Vec<f64> = a
            .iter()
            .enumerate()
            .map(|(i, t)| t + 1e-4 * (i as f64 * 0.7).sin())
            .collect();
        b[100] += 0.015;
        let found = shared_clock(&a, &b, &PulseConfig::of_devices()).unwrap();
        assert_eq!((found.outliers, found.only_first), (1, 0));
        assert!(found.drift_ppm.abs() < 0.2 && found.largest_ms < 0.2);
    }
}
