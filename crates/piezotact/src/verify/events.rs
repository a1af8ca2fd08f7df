//! Events in time: drop-outs, added events and changes of the short-time level.

use crate::statistics::median;

/// The window in which a drop-out is looked for, s.
const SHORT_S: f64 = 0.01;
/// The hop of this window, s.
const SHORT_HOP_S: f64 = 0.0025;
/// A window is a drop-out when it holds less than this share of the expected power.
const DROP_OUT_POWER_SHARE: f64 = 0.1;
/// The window in which a departure from the target is looked for, s, and how far it moves.
const FINE_S: f64 = 0.003;
const FINE_HOP_S: f64 = 0.0005;
/// Two departures separated by no more than this count as one, s.
const BREAK_S: f64 = 0.004;
/// How long onsets and offsets of content outside the band ring inside it, s.
const ENDS_S: f64 = 0.05;
/// A difference of this share of the mean power is a departure.
const LEAST_DEPARTURE: f64 = 0.01;
/// When the usual difference exceeds this share of the mean power, departures cannot be detected.
const MAX_USUAL_DIFFERENCE: f64 = 0.5;
/// A stretch is lost when it holds no more than the first share of the target (by least squares), and possibly lost up to the
/// second.
const LOST: f64 = 0.3;
const MAY_BE_LOST: f64 = 0.7;
/// A shorter drop-out cannot be detected with windows of 10 ms, s: none of them is without power.
pub(super) const UNSEEN_S: f64 = 0.0125;
/// Windows of the target with less than this share of its mean power are not checked for drop-outs.
const QUIET: f64 = 0.1;
/// A window that is quieter than this share of the median is a lull.
const LULL: f64 = 0.01;
/// A window quieter than this share of the median is possibly a lull.
const SHALLOW_LULL: f64 = 0.05;
/// What is quieter than this share of the mean power counts as silent where levels are compared.
const SILENT: f64 = 0.01;
/// Between two realisations, a shorter difference of lulls cannot be distinguished from chance, s.
const CHANCE_S: f64 = 0.01;
/// A waveform saturates when a model with a limit leaves less than this share of the squared residual that a pure gain leaves.
const SATURATION_RESIDUAL_RATIO: f64 = 0.5;
/// Peaks whose quantile ratio is below this share of that of the target may have been limited.
const CLIPPED_CREST_RATIO: f64 = 0.8;
/// Clipping is ruled out unless the target exceeds the measurement by this factor.
const MIN_PEAK_EXCESS: f64 = 1.05;
/// A window holds an added event above the first multiple of the expected power; in another realisation possibly above the
/// second.
const ADDED_POWER_RATIO: f64 = 4.0;
const POSSIBLY_ADDED_POWER_RATIO: f64 = 2.5;
/// An added event holds at least the first share of the mean power; a possible one at least the second.
const ADDED: f64 = 0.1;
const MAY_BE_ADDED: f64 = 0.03;
/// An added event exceeds the usual difference by this factor.
const USUAL_DIFFERENCES: f64 = 8.0;
/// The longest window of short-time levels, s, and the shortest.
const LEVEL_S: (f64, f64) = (0.5, 0.1);
/// A window of the target quieter than this share of its mean power has no level of its own.
const LEVEL_QUIET: f64 = 0.05;
/// dB of a power whose natural logarithm changes by 1.
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;

/// A value with the interval in which it lies with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) value: f64,
    pub(super) interval: [f64; 2],
}

impl Found {
    /// The same finding when durations shorter than `unseen` cannot be detected: the upper limit is at least that.
    pub(super) fn no_shorter_than(self, unseen: f64) -> Self {
        let [low, high] = self.interval;
        Self {
            interval: [low, high.max(unseen)],
            ..self
        }
    }

    /// The larger of two findings of one thing.
    pub(super) fn larger(self, other: Self) -> Self {
        let [a, b] = [self.interval, other.interval];
        Self {
            value: self.value.max(other.value),
            interval: [a[0].max(b[0]), a[1].max(b[1])],
        }
    }
}

/// The mean power of windows of `length` samples, `hop` apart.
fn powers(x: &[f64], length: usize, hop: usize) -> Vec<f64> {
    if x.len() < length || length == 0 {
        return Vec::new();
    }
    let mut sums = Vec::with_capacity(x.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for v in x {
        sum += v * v;
        sums.push(sum);
    }
    (0..=(x.len() - length) / hop.max(1))
        .map(|i| (sums[i * hop + length] - sums[i * hop]).max(0.0) / length as f64)
        .collect()
}

/// The number of windows in the longest run in which `is` holds.
fn runs_of(count: usize, is: impl Fn(usize) -> bool) -> usize {
    let (mut longest, mut run) = (0, 0);
    for i in 0..count {
        run = if is(i) { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    longest
}

/// As [`runs_of`], without runs at the ends: start and end of a realisation are known only from its level, so runs
/// there are not counted.
fn longest_run(count: usize, is: impl Fn(usize) -> bool) -> usize {
    let begin = (0..count).find(|i| !is(*i)).unwrap_or(count);
    let (mut longest, mut run) = (0, 0);
    for i in begin..count {
        if is(i) {
            run += 1;
        } else {
            longest = longest.max(run);
            run = 0;
        }
    }
    longest
}

/// The two compared signals, aligned in time and limited to one band, with the power of the sensor's noise in the second.
#[derive(Clone, Copy)]
pub(super) struct Compared<'a> {
    pub(super) target: &'a [f64],
    pub(super) measured: &'a [f64],
    pub(super) rate_hz: f64,
    /// The mean square of the sensor's noise.
    pub(super) noise_power: f64,
    /// The share that is not the silence around a short target, 0–1.
    pub(super) effect_share: f64,
}

impl Compared<'_> {
    fn samples(&self, duration_s: f64) -> usize {
        ((duration_s * self.rate_hz).round() as usize).max(1)
    }

    fn short(&self) -> ([Vec<f64>; 2], f64) {
        let (length, hop) = (self.samples(SHORT_S), self.samples(SHORT_HOP_S));
        let both = [self.target, self.measured].map(|x| powers(x, length, hop));
        (both, hop as f64 / self.rate_hz)
    }

    /// The longest stretch in which a measurement that follows its target (up to a gain) holds less than a tenth of the
    /// expected power, s.
    ///
    /// Formula: windows of 10 ms every 2.5 ms in which the target holds a tenth of its mean power or more; a run of n
    /// windows is a drop-out of (n − 1)·2.5 ms + 9 ms, as a window counts once nine tenths of it are gone.
    pub(super) fn dropped_while_following(&self) -> Found {
        let ([wanted, got], hop_s) = self.short();
        let mean = wanted.iter().sum::<f64>() / wanted.len().max(1) as f64;
        let gain = self.gain();
        let least = (QUIET * mean)
            .max(self.noise_power / (DROP_OUT_POWER_SHARE * gain).max(f64::MIN_POSITIVE));
        let gone = |i: usize| {
            wanted[i] >= least
                && (got[i] - self.noise_power).max(0.0) < DROP_OUT_POWER_SHARE * gain * wanted[i]
        };
        // A lull of the target does not end a drop-out.
        let silent = |i: usize| {
            gone(i) || (wanted[i] < least && got[i] < DROP_OUT_POWER_SHARE * gain * least)
        };
        let count = wanted.len().min(got.len());
        let mut longest = 0.0f64;
        let mut i = 0;
        while i < count {
            if !silent(i) {
                i += 1;
                continue;
            }
            let from = i;
            while i < count && silent(i) {
                i += 1;
            }
            // From the first window in which something is missing to the last.
            let missing: Vec<usize> = (from..i).filter(|i| gone(*i)).collect();
            if let (Some(first), Some(last)) = (missing.first(), missing.last()) {
                let windows = (last - first) as f64;
                longest = longest.max(windows * hop_s + 0.9 * SHORT_S);
            }
        }
        // Depending on where its power lies, a window is counted when between half and all of it is missing.
        let interval = if longest > 0.0 {
            [longest - 0.5 * SHORT_S, longest + hop_s]
        } else {
            [0.0, 0.0]
        };
        let found = Found {
            value: longest,
            interval,
        };
        found.larger(self.longest_departure())
    }

    /// The longest stretch in which a measurement that otherwise follows its target departs from it, s: a loss that
    /// was filled by a straight line, or that is too short for windows of 10 ms.
    ///
    /// Formula: windows of 3 ms every 0.5 ms in which the difference holds eight times the usual difference, a hundredth of the
    /// target's mean power and a quarter of what they should hold; n windows in a row, breaks of 4 ms aside, are
    /// (n − 1)·0.5 ms, with an interval of −4.5 ms to +3 ms; the first and last 50 ms are left out, where content outside the
    /// band rings. A stretch is lost when the least-squares share of the target in it is at most 0.3, possibly lost up to 0.7.
    fn longest_departure(&self) -> Found {
        let (length, hop) = (self.samples(FINE_S), self.samples(FINE_HOP_S));
        let hop_s = hop as f64 / self.rate_hz;
        let wanted = powers(self.target, length, hop);
        let gain = self.gain();
        let scale = gain.max(0.0).sqrt() * self.sign();
        let pairs = self.target.iter().zip(self.measured);
        let difference: Vec<f64> = pairs.map(|(t, m)| m - scale * t).collect();
        let mut differs = powers(&difference, length, hop);
        let mean = gain * wanted.iter().sum::<f64>() / wanted.len().max(1) as f64;
        let usual = USUAL_DIFFERENCES * (median(&mut differs).unwrap_or(0.0) + self.noise_power);
        if usual > MAX_USUAL_DIFFERENCE * mean || wanted.is_empty() {
            // A loss would not stand out of the usual difference: only windows of 10 ms can show it.
            return Found {
                value: 0.0,
                interval: [0.0, UNSEEN_S],
            };
        }
        let least = usual.max(LEAST_DEPARTURE * mean);
        let departs = |i: usize| differs[i] > least && differs[i] > 0.25 * gain * wanted[i];
        let ends = self.samples(ENDS_S);
        let most_break = (BREAK_S / hop_s) as usize;
        let mut found = Found {
            value: 0.0,
            interval: [0.0, FINE_S],
        };
        let mut run: Option<(usize, usize)> = None;
        let mut end = |run: Option<(usize, usize)>| {
            let Some((first, last)) = run else { return };
            let (from, to) = (first * hop, last * hop + length);
            if from < ends || to + ends > self.target.len() {
                return;
            }
            let (t, m) = (&self.target[from..to], &self.measured[from..to]);
            let product: f64 = t.iter().zip(m).map(|(t, m)| t * m).sum();
            let squares: f64 = t.iter().map(|t| t * t).sum();
            let kept = product / (scale * squares.max(f64::MIN_POSITIVE));
            if kept > MAY_BE_LOST {
                return;
            }
            let duration_s = (last - first) as f64 * hop_s;
            // A stretch with far more power than expected is an added event, not a loss.
            let held: f64 = m.iter().map(|m| m * m).sum();
            let lost = kept.abs() <= LOST && held <= 2.0 * gain * squares;
            found = found.larger(Found {
                value: if lost { duration_s } else { 0.0 },
                interval: [
                    if lost {
                        (duration_s - 1.5 * FINE_S).max(0.0)
                    } else {
                        0.0
                    },
                    duration_s + FINE_S,
                ],
            });
        };
        for i in (0..differs.len().min(wanted.len())).filter(|i| departs(*i)) {
            run = match run {
                Some((first, last)) if i - last <= most_break + 1 => Some((first, i)),
                before => {
                    end(before);
                    Some((i, i))
                }
            };
        }
        end(run);
        found
    }

    /// −1 where the measurement follows with the sign reversed.
    fn sign(&self) -> f64 {
        let pairs = self.target.iter().zip(self.measured);
        pairs.map(|(t, m)| t * m).sum::<f64>().signum()
    }

    /// The longest lull of the target, s.
    pub(super) fn own_lull_s(&self) -> f64 {
        let ([wanted, _], hop_s) = self.short();
        lull(&wanted, LULL, 0.0, hop_s)
    }

    /// How much longer the longest lull of the measurement is than that of its target, s, for two realisations of one texture.
    ///
    /// Formula: runs of windows of 10 ms with less than a hundredth of the median power of those that are not silent; of two
    /// realisations of one texture the longest lulls differ by chance, by about half of their own length. Slow components
    /// of a texture fill a short drop-out: the upper limit is therefore the excess of the runs below a twentieth.
    pub(super) fn longer_lulls(&self) -> Found {
        let ([wanted, got], hop_s) = self.short();
        let excess = |share: f64| {
            let own = lull(&wanted, share, 0.0, hop_s);
            (
                (lull(&got, share, self.noise_power, hop_s) - own).max(0.0),
                own,
            )
        };
        let (value, own) = excess(LULL);
        let (open, _) = excess(SHALLOW_LULL);
        let unsure = (0.5 * own).max(CHANCE_S) + hop_s;
        // A stretch without power is at most one window longer on either side.
        let highest = if value > 0.0 {
            value + 2.0 * hop_s
        } else {
            0.0
        };
        Found {
            value,
            interval: [(value - unsure).max(0.0), highest.max(open)],
        }
    }

    /// The power of the measurement, less the noise, over that of the target.
    fn gain(&self) -> f64 {
        let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>() / x.len().max(1) as f64;
        let wanted = power(self.target);
        if wanted > 0.0 {
            (power(self.measured) - self.noise_power).max(0.0) / wanted
        } else {
            0.0
        }
    }

    /// The share of samples at a limit that the target would exceed, 0–1, when a limit explains the measurement better than a
    /// pure gain; otherwise 0.
    ///
    /// Formula: m = clip(g·t, ±c) with g from the samples below the median of |t| and c the level with the smallest squared
    /// residual,
    /// against m = g·t; the sensor's noise is taken from both.
    pub(super) fn saturated_share(&self) -> f64 {
        let mut sizes: Vec<f64> = self.target.iter().map(|t| t.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let at = (share * sizes.len() as f64) as usize;
            sizes
                .get(at.min(sizes.len().saturating_sub(1)))
                .copied()
                .unwrap_or(0.0)
        };
        let pairs = || self.target.iter().zip(self.measured);
        let gain_of = |below: f64| {
            let (tm, tt) = pairs()
                .filter(|(t, _)| t.abs() <= below)
                .fold((0.0, 0.0), |(tm, tt), (t, m)| (tm + t * m, tt + t * t));
            if tt > 0.0 { tm / tt } else { 0.0 }
        };
        let (all, weak) = (gain_of(f64::INFINITY), gain_of(quantile(0.5)));
        let noise = self.noise_power * self.target.len() as f64;
        let left = |of: &dyn Fn(f64) -> f64| {
            let squares: f64 = pairs().map(|(t, m)| (m - of(*t)).powi(2)).sum();
            (squares - noise).max(0.0)
        };
        let linear = left(&|t| all * t);
        let best = (1..=40)
            .map(|i| 1.0 - 0.6f64.powi(i).clamp(5e-4, 0.6))
            .map(|share| {
                let limit = (weak * quantile(share)).abs();
                (left(&|t| (weak * t).clamp(-limit, limit)), 1.0 - share)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((squares, share))
                if linear > 0.0 && squares < SATURATION_RESIDUAL_RATIO * linear =>
            {
                share
            }
            _ => 0.0,
        }
    }

    /// Whether the peaks of the measurement lie at one level while those of its target do not, as after clipping of another
    /// realisation.
    ///
    /// Formula: the ratio of the quantiles 0.999 and 0.97 of |x|, below four fifths of the target's; 1.5 for noise, 1 for a tone.
    pub(super) fn pressed(&self) -> bool {
        let crest = |x: &[f64]| {
            let mut sizes: Vec<f64> = x.iter().map(|v| v.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let at = |share: f64| sizes.get((share * sizes.len() as f64) as usize).copied();
            match (at(0.999), at(0.97)) {
                (Some(high), Some(low)) if low > 0.0 => high / low,
                _ => 1.0,
            }
        };
        crest(self.measured) < CLIPPED_CREST_RATIO * crest(self.target)
    }

    /// Whether the target, scaled by the gain, exceeds the peak of the measurement by 5 %: otherwise nothing was clipped.
    pub(super) fn exceeded(&self) -> bool {
        let gain = self.gain().max(0.0).sqrt();
        crate::statistics::peak(self.target) * gain
            > MIN_PEAK_EXCESS * crate::statistics::peak(self.measured)
    }

    /// The longest event that a measurement which follows its target has and the target does not, s; the interval extends from
    /// certain to possible events.
    ///
    /// Formula: windows of 10 ms that hold four times the power that they should, and more than a tenth of the target's mean
    /// power (may be: 0.03), over its own time where it is short, and eight times the usual difference above it; n windows in a row are (n − 1)·2.5 ms + 10 ms.
    pub(super) fn added_while_following(&self) -> Found {
        let ([wanted, got], hop_s) = self.short();
        let gain = self.gain();
        let windows = wanted.len().max(1) as f64 * self.effect_share;
        let mean = gain * wanted.iter().sum::<f64>() / windows;
        let scale = gain.max(0.0).sqrt();
        let pairs = self.target.iter().zip(self.measured);
        let difference: Vec<f64> = pairs.map(|(t, m)| m - scale * t).collect();
        let (length, hop) = (self.samples(SHORT_S), self.samples(SHORT_HOP_S));
        let usual = median(&mut powers(&difference, length, hop)).unwrap_or(0.0);
        let longest = |share: f64| {
            let least = (share * mean).max(USUAL_DIFFERENCES * usual) + self.noise_power;
            let added = |i: usize| {
                let should = gain * wanted[i];
                got[i] > ADDED_POWER_RATIO * should + self.noise_power && got[i] - should > least
            };
            match runs_of(wanted.len().min(got.len()), added) {
                0 => 0.0,
                n => (n - 1) as f64 * hop_s + SHORT_S,
            }
        };
        let (sure, open) = (longest(ADDED), longest(MAY_BE_ADDED));
        Found {
            value: sure,
            interval: [sure, open.max(sure)],
        }
    }

    /// The same for another realisation: windows that exceed the median window by 6 dB more than any of the target does
    /// (possible events: 4 dB). A short effect has too few windows for a median: its power is the reference.
    pub(super) fn added_crests(&self) -> Found {
        let ([wanted, got], hop_s) = self.short();
        let (usual_wanted, usual_got) = match self.effect_share < 1.0 {
            true => (1.0, self.gain()),
            false => (typical(&wanted), typical(&got)),
        };
        let highest =
            wanted.iter().copied().fold(0.0, f64::max) / usual_wanted.max(f64::MIN_POSITIVE);
        let longest =
            |factor: f64| match runs_of(got.len(), |i| got[i] > factor * highest * usual_got) {
                0 => 0.0,
                n => (n - 1) as f64 * hop_s + SHORT_S,
            };
        let (sure, open) = (
            longest(ADDED_POWER_RATIO),
            longest(POSSIBLY_ADDED_POWER_RATIO),
        );
        Found {
            value: sure,
            interval: [sure, open.max(sure)],
        }
    }

    fn levels(&self) -> [Vec<f64>; 2] {
        let duration_s = self.target.len() as f64 / self.rate_hz;
        let window_s = (duration_s / 8.0).clamp(LEVEL_S.1, LEVEL_S.0);
        let length = self.samples(window_s);
        [self.target, self.measured].map(|x| powers(x, length, (length / 2).max(1)))
    }

    /// The largest difference of a short-time level from that of the target after removing the mean gain, dB.
    ///
    /// Formula: windows of an eighth of the length, 0.1 to 0.5 s; those in which the target holds a twentieth of its mean
    /// power or more.
    pub(super) fn level_departure(&self) -> Option<f64> {
        let [wanted, got] = self.levels();
        let mean = wanted.iter().sum::<f64>() / wanted.len().max(1) as f64;
        let gain = self.gain();
        let departures = wanted
            .iter()
            .zip(&got)
            .filter(|(w, _)| **w >= LEVEL_QUIET * mean);
        let departures = departures.map(|(w, g)| {
            let left = (g - self.noise_power).max(1e-3 * g).max(f64::MIN_POSITIVE);
            (DB_PER_NEPER * (left / (gain * w).max(f64::MIN_POSITIVE)).ln()).abs()
        });
        departures.reduce(f64::max)
    }

    /// The rms difference between the distributions of short-time levels of measurement and target after removing the mean
    /// gain, dB.
    ///
    /// Formula: the rms difference of the sorted levels of windows of 0.1 s; silent windows count as 20 dB below the mean
    /// level. Windows of another realisation differ by chance: the interval is a third of the value and 0.3 dB.
    pub(super) fn level_distribution(&self) -> Option<Found> {
        let length = self.samples(LEVEL_S.1);
        let hop = (length / 4).max(1);
        let gain = self.gain().max(f64::MIN_POSITIVE);
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
        let wanted = powers(self.target, length, hop);
        let silent = SILENT * mean(&wanted);
        let sorted = |powers: &mut dyn Iterator<Item = f64>| {
            let mut levels: Vec<f64> = powers
                .map(|power| DB_PER_NEPER * (power.max(0.0) + silent).ln())
                .collect();
            levels.sort_by(f64::total_cmp);
            levels
        };
        let got = powers(self.measured, length, hop);
        let got = sorted(&mut got.iter().map(|power| (power - self.noise_power) / gain));
        let wanted = sorted(&mut wanted.iter().copied());
        if wanted.len() < 8 || silent <= 0.0 {
            return None;
        }
        let squares: f64 = wanted.iter().zip(&got).map(|(a, b)| (a - b).powi(2)).sum();
        let value = (squares / wanted.len() as f64).sqrt();
        Some(Found {
            value,
            interval: [(0.67 * value - 0.3).max(0.0), 1.33 * value + 0.3],
        })
    }
}

/// The longest run of windows in `powers` below `share` of the median window, s.
fn lull(powers: &[f64], share: f64, noise: f64, hop_s: f64) -> f64 {
    let below = (share * (typical(powers) - noise)).max(noise);
    match longest_run(powers.len(), |i| powers[i] - noise < below) {
        0 => 0.0,
        run => (run - 1) as f64 * hop_s + 0.9 * SHORT_S,
    }
}

/// The median power of the windows that are not silent.
fn typical(powers: &[f64]) -> f64 {
    let mean = powers.iter().sum::<f64>() / powers.len().max(1) as f64;
    let mut loud: Vec<f64> = powers.iter().copied().filter(|p| *p > 0.1 * mean).collect();
    median(&mut loud).unwrap_or(0.0)
}
