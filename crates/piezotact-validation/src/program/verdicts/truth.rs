//! The truth about a rendering: computed from the target and the delivered vibration without noise, by limits stated
//! in one table, and independent of the code of `verify`.
//!
//! Spectra come of one transform over the whole target, smoothed to lines of 5 Hz as a Hann window of 0.2 s sees them, so that
//! a limit on lines of 5 Hz means the same here and in an averaged spectrum. Levels in time are those of the band-limited
//! signals. The best constant delay is taken away where the waveform counts; in texture mode the delay that was made is known.
//! What belongs to the recording (its noise, clock, offset, lost samples) is not in the delivered signal and so not in the
//! truth, but for what makes a recording useless: a sensor that clips, holds still, or stops.
//!
//! **Where the scatter of a realisation enters.** In texture mode the phases are free. A rendering with drawn phases and the
//! target's own magnitudes has the target's spectrum exactly, whatever the phases: nothing scatters but the levels in time,
//! whose *distribution* is compared. Another draw of the same process has another spectrum than the recorded draw: with n
//! degrees of freedom a line scatters by 4.34·√(2/n) dB, about 1 dB in a line of 5 Hz and 3 s, and with twice that power between
//! two draws. For these cases lines are 20 Hz wide, and the scatter that is expected of the two is taken off the mean square
//! error, with the degrees of freedom that the spectrum within the line has. What is left scatters still; so another draw without a
//! fault of its own is right or left out, never wrong: the process is the target's. A rendering whose times are moved (played
//! faster, a delay that wanders, one half twice) lies between: it is judged as the same realisation and as another, and left out
//! where the two disagree. In texture mode every spectrum is computed with and without tapered ends, and a case is left out where
//! these disagree: drawn phases go around the ends, and a level that changes over the texture makes a step there.

use std::f64::consts::PI;
use std::fmt;

use num_complex::Complex;
use piezotact::feature::Weighting;
use piezotact::lineage::Mode;
use piezotact::quantity::{Band, Hertz};

use super::faults::{Case, Realisation, faded};
use super::kinds::Kind;
use super::scene::LEAD;
use super::signal::{
    RATE_HZ, at_times, bins_of, decibels, energy, hz_of, shaped, short_time, signal_of,
};

/// A quantity that is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Figure {
    Level,
    Spectrum,
    SpectrumByPower,
    SpectrumByFelt,
    Correlation,
    Difference,
    Clipped,
    Added,
    FeltOutside,
    LostEvent,
    AddedEvent,
    DropOut,
    LevelOverTime,
    LevelDistribution,
    GivenUp,
    Uncovered,
}

impl Figure {
    pub(super) const ALL: [Self; 16] = [
        Self::Level,
        Self::Spectrum,
        Self::SpectrumByPower,
        Self::SpectrumByFelt,
        Self::Correlation,
        Self::Difference,
        Self::Clipped,
        Self::Added,
        Self::FeltOutside,
        Self::LostEvent,
        Self::AddedEvent,
        Self::DropOut,
        Self::LevelOverTime,
        Self::LevelDistribution,
        Self::GivenUp,
        Self::Uncovered,
    ];

    /// The limit, in the unit that the name says.
    pub(super) fn limit(self) -> f64 {
        match self {
            Self::Level | Self::Spectrum | Self::SpectrumByPower | Self::SpectrumByFelt => 1.0,
            Self::Correlation => 0.05,
            Self::Difference | Self::Added | Self::FeltOutside | Self::GivenUp => 0.1,
            Self::Clipped => 0.001,
            Self::LostEvent | Self::AddedEvent => 6.0,
            Self::DropOut => 15.0,
            Self::LevelOverTime | Self::LevelDistribution => 3.0,
            Self::Uncovered => 0.05,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Level => "level, dB",
            Self::Spectrum => "spectrum, dB rms",
            Self::SpectrumByPower => "spectrum by power, dB rms",
            Self::SpectrumByFelt => "spectrum by felt power, dB rms",
            Self::Correlation => "1 − correlation",
            Self::Difference => "NMSE",
            Self::Clipped => "clipped share",
            Self::Added => "added power share",
            Self::FeltOutside => "felt outside the band, share",
            Self::LostEvent => "lost event, dB",
            Self::AddedEvent => "added event, dB",
            Self::DropOut => "drop-out, ms",
            Self::LevelOverTime => "level over time, dB",
            Self::LevelDistribution => "distribution of levels, dB",
            Self::GivenUp => "given up, power share",
            Self::Uncovered => "not recorded, share",
        }
    }

    /// Where it counts and what it is, for the table of limits.
    pub(super) fn meaning(self) -> &'static str {
        match self {
            Self::Level => "both: delivered over target in the band, either way",
            Self::Spectrum => {
                "both: lines of 5 Hz, as a Hann window sees them, within 50 dB of the strongest"
            }
            Self::SpectrumByPower => "both: the same, weighed by the target's power",
            Self::SpectrumByFelt => "both: weighed by power over the detection threshold's",
            Self::Correlation => "replicate: 0.95, at the best constant delay",
            Self::Difference => "replicate: −10 dB, at the same delay",
            Self::Clipped => "both: samples at a limit",
            Self::Added => "both: on lines without target power, over the target's power",
            Self::FeltOutside => "both: over the target's felt power, where it can be felt at all",
            Self::LostEvent => "replicate: 20 ms of the target, no more than 6 dB below its level",
            Self::AddedEvent => {
                "replicate: of a short texture, 20 ms of the delivered no more than 6 dB below the target's level"
            }
            Self::DropOut => {
                "both: silence where the target is within 6 dB of its level; of the taps in texture mode, silence longer than the target's longest"
            }
            Self::LevelOverTime => "replicate: windows of 0.5 s, of a short texture 0.1 s",
            Self::LevelDistribution => {
                "texture: between the sorted levels of windows of 0.1 s (short: 20 ms), rms"
            }
            Self::GivenUp => {
                "both: of the target, told as not achievable; to pass in part is right"
            }
            Self::Uncovered => "both: of the target; to pass in part is right",
        }
    }
}

/// Every figure up to this share of its limit: right. One from this much beyond: wrong.
pub(super) const RIGHT_TO: f64 = 0.75;
pub(super) const WRONG_FROM: f64 = 1.33;

/// What is true of one rendering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fact {
    Right,
    Wrong,
    /// Too near to a limit, or arguable.
    LeftOut,
}

/// What is true of one rendering, and the figure that says so.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    pub(super) fact: Fact,
    /// The figure that lies highest over its limit, and its value.
    pub(super) worst: Figure,
    pub(super) found: f64,
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.fact {
            Fact::Right => "right",
            Fact::Wrong => "wrong",
            Fact::LeftOut => "left out",
        };
        write!(
            f,
            "{word}: {} {:.3} (limit {})",
            self.worst.name(),
            self.found,
            self.worst.limit()
        )
    }
}

/// What is true of `case`, in which `kind` happened.
pub(super) fn truth(case: &Case, kind: Kind, mode: Mode, band: Band) -> Truth {
    let draws: &[Draw] = match (mode, case.realisation) {
        (Mode::Replicate, _) | (_, Realisation::Same) => &[Draw::Same],
        (_, Realisation::Moved) => &[Draw::Same, Draw::Another],
        (_, Realisation::Another) => &[Draw::Another],
    };
    let ends: &[Ends] = match mode {
        Mode::Replicate => &[Ends::Tapered],
        Mode::Texture => &[Ends::AsTheyAre, Ends::Tapered],
    };
    let looks = draws
        .iter()
        .flat_map(|draw| ends.iter().map(|ends| (*draw, *ends)));
    let common = Common::of(case, mode, band);
    let mut facts = looks.map(|(draw, ends)| by_limits(&common.figures(case, mode, draw, ends)));
    let Some(first) = facts.next() else {
        unreachable!("there is always a look")
    };
    let mut truth = first;
    for other in facts {
        if other.fact != truth.fact {
            truth.fact = Fact::LeftOut;
        }
    }
    truth.fact = match (kind, truth.fact) {
        // The process is the target's.
        (Kind::AnotherDraw, Fact::Wrong) if mode == Mode::Texture => Fact::LeftOut,
        // The polarity of what is nearly a tone is a delay of half a period.
        (Kind::Polarity, Fact::Right) if mode == Mode::Replicate => Fact::LeftOut,
        // The file of the target is no measurement.
        (Kind::Copy, _) => Fact::LeftOut,
        (_, fact) => fact,
    };
    truth
}

fn by_limits(figures: &[(Figure, f64)]) -> Truth {
    let over = |(figure, found): &(Figure, f64)| found / figure.limit();
    let (worst, found) = figures
        .iter()
        .copied()
        .max_by(|a, b| over(a).total_cmp(&over(b)))
        .unwrap_or((Figure::Level, 0.0));
    let fact = match over(&(worst, found)) {
        over if over <= RIGHT_TO => Fact::Right,
        over if over >= WRONG_FROM => Fact::Wrong,
        _ => Fact::LeftOut,
    };
    Truth { fact, worst, found }
}

/// The reference of a spectrum: the recorded realisation, or another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Draw {
    Same,
    Another,
}

/// What is done with both ends before a transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ends {
    AsTheyAre,
    /// Raised-cosine tapers over a twentieth of the length.
    Tapered,
}

impl Ends {
    fn of(self, x: &[f64]) -> Vec<f64> {
        match self {
            Self::AsTheyAre => x.to_vec(),
            Self::Tapered => faded(x, 0.05 * x.len() as f64 / RATE_HZ),
        }
    }
}

/// The power over the detection threshold's of what `x` holds in `band`: at 1 it is just felt.
pub(super) fn felt_power(x: &[f64], band: Band) -> f64 {
    felt(x, |hz| band.contains(hz))
}

fn felt(x: &[f64], counts: impl Fn(f64) -> bool) -> f64 {
    let n = x.len() as f64;
    bins_of(x, x.len())
        .iter()
        .enumerate()
        .map(|(k, bin)| (hz_of(k, x.len()), bin.norm_sqr() * 2.0 / (n * n)))
        .filter(|(hz, _)| *hz >= 2.0 && counts(*hz))
        .map(|(hz, power)| {
            power
                / Weighting::DetectionThreshold
                    .threshold_m_s2(Hertz(hz))
                    .powi(2)
        })
        .sum()
}

/// A line of a spectrum.
struct Line {
    hz: f64,
    target: f64,
    delivered: f64,
    /// What the squared difference in dB of two draws is on average, dB².
    scatter: f64,
}

/// A shorter target is judged with this much silence on either side, samples: 1 s, 0.2 s. What is delivered late belongs to it.
const SHORT: usize = 5_000;
const BESIDE: usize = 1_000;

/// Target and delivered signal on one time, and the figures that do not depend on how a spectrum is looked at.
struct Common {
    band: Band,
    meant: Vec<f64>,
    delivered: Vec<f64>,
    figures: Vec<(Figure, f64)>,
}

impl Common {
    fn of(case: &Case, mode: Mode, band: Band) -> Self {
        let n = case.meant.len();
        let mut meant = vec![0.0; LEAD];
        meant.extend(&case.meant);
        meant.resize(n + 2 * LEAD, 0.0);
        // With the best delay, in the band, over the target's time.
        let in_band = |x: &[f64]| {
            shaped(x, |hz| {
                f64::from(u8::from(band.contains(hz) && achieved(case, hz)))
            })
        };
        let delay = match mode {
            Mode::Replicate => best_delay(&in_band(&meant), &in_band(&case.delivered)),
            Mode::Texture => case.delay,
        };
        let framed = at_times(&case.delivered, (0..n + 2 * LEAD).map(|i| i as f64 + delay));
        let beside = if n < SHORT { BESIDE } else { 0 };
        let judged = LEAD - beside..LEAD + n + beside;
        let (t, d) = (in_band(&meant), in_band(&framed));
        let (t, d) = (&t[judged.clone()], &d[judged.clone()]);
        let (meant, delivered) = (meant[judged.clone()].to_vec(), framed[judged].to_vec());
        // The level of a short texture is that of its own time.
        let level = energy(t) / n as f64;
        let outside = felt(&delivered, |hz| !band.contains(hz));
        let share = outside / felt_power(&meant, band);
        let mut figures = vec![
            (Figure::Level, decibels(energy(d) / energy(t)).abs()),
            (Figure::Clipped, case.clipped_share),
            (Figure::Uncovered, case.uncovered_share),
            (
                Figure::FeltOutside,
                if outside >= 1.0 { share } else { 0.0 },
            ),
            (Figure::DropOut, drop_out(case, mode, t, d, level)),
        ];
        match mode {
            Mode::Replicate => {
                let product: f64 = t.iter().zip(d).map(|(t, d)| t * d).sum();
                let both = (energy(t) * energy(d)).sqrt().max(f64::MIN_POSITIVE);
                let missed: f64 = t.iter().zip(d).map(|(t, d)| (t - d).powi(2)).sum();
                figures.push((Figure::Correlation, 1.0 - product / both));
                figures.push((Figure::Difference, missed / energy(t)));
                figures.push((Figure::LostEvent, most_lost(t, d, level)));
                if beside > 0 {
                    figures.push((Figure::AddedEvent, most_lost(d, t, level)));
                }
                figures.push((Figure::LevelOverTime, most_apart(t, d, level)));
            }
            Mode::Texture => {
                figures.push((Figure::LevelDistribution, distributions_apart(t, d, level)))
            }
        }
        Self {
            band,
            meant,
            delivered,
            figures,
        }
    }

    fn figures(&self, case: &Case, mode: Mode, draw: Draw, ends: Ends) -> Vec<(Figure, f64)> {
        let lines = lines(
            &ends.of(&self.meant),
            &ends.of(&self.delivered),
            self.band,
            draw,
        );
        let mut all = self.figures.clone();
        all.extend(spectrum(case, &lines));
        debug_assert!(mode == Mode::Texture || draw == Draw::Same);
        all
    }
}

/// Whether the rendering is told to reach this frequency.
fn achieved(case: &Case, hz: f64) -> bool {
    let told = &case.config.reached;
    told.is_empty() || told.iter().any(|part| part.contains(hz))
}

fn spectrum(case: &Case, lines: &[Line]) -> Vec<(Figure, f64)> {
    let strongest = lines
        .iter()
        .fold(0.0, |most: f64, line| most.max(line.target));
    let (with, without): (Vec<&Line>, Vec<&Line>) = lines
        .iter()
        .partition(|line| line.target >= 1e-5 * strongest);
    let power: f64 = lines.iter().map(|line| line.target).sum();
    let added: f64 = without.iter().map(|line| line.delivered).sum();
    let (judged, given_up): (Vec<&Line>, Vec<&Line>) =
        with.into_iter().partition(|line| achieved(case, line.hz));
    let given_up: f64 = given_up.iter().map(|line| line.target).sum();
    let error = |weight: &dyn Fn(&Line) -> f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for line in &judged {
            let off = decibels(line.delivered / line.target).clamp(-40.0, 40.0);
            sum += weight(line) * (off * off - line.scatter);
            weights += weight(line);
        }
        (sum.max(0.0) / weights.max(f64::MIN_POSITIVE)).sqrt()
    };
    let threshold = |hz: f64| Weighting::DetectionThreshold.threshold_m_s2(Hertz(hz));
    vec![
        (Figure::Spectrum, error(&|_| 1.0)),
        (Figure::SpectrumByPower, error(&|line| line.target)),
        (
            Figure::SpectrumByFelt,
            error(&|line| line.target / threshold(line.hz).powi(2)),
        ),
        (Figure::Added, added / power),
        (Figure::GivenUp, given_up / power),
    ]
}

/// What a Hann window sees of the power `x` of its lines away: its main lobe.
fn hann(x: f64) -> f64 {
    if x.abs() >= 2.0 {
        return 0.0;
    }
    let amplitude = if x.abs() < 1e-9 {
        1.0
    } else if (x.abs() - 1.0).abs() < 1e-9 {
        0.5
    } else {
        (PI * x).sin() / (PI * x) / (1.0 - x * x)
    };
    amplitude * amplitude
}

fn lines(t: &[f64], d: &[f64], band: Band, draw: Draw) -> Vec<Line> {
    let n = t.len();
    let (t_bins, d_bins) = (bins_of(t, n), bins_of(d, n));
    let step_hz = match draw {
        Draw::Same => 5.0,
        Draw::Another => 20.0,
    };
    // What lies beside the band's ends was not to be rendered.
    let ends = [band.low().0, band.high().0].map(|hz| (hz * n as f64 / RATE_HZ).round() as usize);
    let first = (band.low().0 / step_hz).ceil() as usize;
    let last = (band.high().0 / step_hz).floor() as usize;
    (first..=last)
        .map(|line| {
            let at =
                |away: f64| ((line as f64 + away) * step_hz * n as f64 / RATE_HZ).max(0.0) as usize;
            let bins = at(-2.0).max(ends[0])..=at(2.0).min(ends[1]);
            let powers = |of: &[Complex<f64>]| -> (f64, f64) {
                bins.clone().fold((0.0, 0.0), |(sum, squares), k| {
                    let p = hann(hz_of(k, n) / step_hz - line as f64) * of[k].norm_sqr();
                    (sum + p, squares + p * p)
                })
            };
            let ((target, t_squares), (delivered, d_squares)) = (powers(&t_bins), powers(&d_bins));
            // The square of a bin's power is on average twice the square of its mean.
            let scatter = |sum: f64, squares: f64| {
                let variance = 0.5 * squares;
                let freedom = 2.0 * (sum * sum - variance) / variance.max(f64::MIN_POSITIVE);
                4.343f64.powi(2) * 2.0 / freedom.max(2.0)
            };
            Line {
                hz: line as f64 * step_hz,
                target,
                delivered,
                scatter: match draw {
                    Draw::Same => 0.0,
                    Draw::Another => scatter(target, t_squares) + scatter(delivered, d_squares),
                },
            }
        })
        .collect()
}

/// How much later `d` is than `t`, samples, to about a hundredth: where their correlation is highest, within 0.3 s.
fn best_delay(t: &[f64], d: &[f64]) -> f64 {
    const FINER: usize = 8;
    let n = 2 * t.len();
    let cross: Vec<Complex<f64>> = bins_of(t, n)
        .iter()
        .zip(bins_of(d, n))
        .map(|(t, d)| t.conj() * d)
        .collect();
    let fine = signal_of(cross, FINER * n);
    let at = |lag: i64| fine[lag.rem_euclid(fine.len() as i64) as usize];
    let most = (LEAD * FINER) as i64;
    let best = (-most..=most)
        .max_by(|a, b| at(*a).total_cmp(&at(*b)))
        .unwrap_or(0);
    let shift = piezotact::statistics::vertex([at(best - 1), at(best), at(best + 1)]);
    (best as f64 + shift) / FINER as f64
}

/// A level this far below the whole's is silence.
const SILENT: f64 = 0.01;

/// The longest stretch of silence, ms.
fn longest_silence(x: &[f64], overall: f64) -> f64 {
    let (window, hop) = (25, 5);
    let mut longest: usize = 0;
    let mut now = 0;
    for level in short_time(x, window, hop) {
        now = if level < SILENT * overall { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    match longest {
        0 => 0.0,
        count => ((count - 1) * hop + window) as f64 / RATE_HZ * 1e3,
    }
}

/// The longest drop-out, ms.
fn drop_out(case: &Case, mode: Mode, t: &[f64], d: &[f64], level: f64) -> f64 {
    let limit = Figure::DropOut.limit();
    let own = longest_silence(t, level);
    if mode == Mode::Texture && own > limit {
        // When it is silent is free; for how long is not. Half as long again is no matter of how taps happen to lie.
        let longer = longest_silence(d, energy(d) / energy(t) * level) - own;
        return match longer {
            longer if longer <= RIGHT_TO * limit => longer.max(0.0),
            longer if longer < 0.5 * own => limit,
            longer => longer,
        };
    }
    let gaps = case.gaps.iter().map(|gap| match gap.level_db {
        level if level >= -6.0 => gap.lasts_s * 1e3,
        level if level >= -20.0 => limit.min(gap.lasts_s * 1e3),
        _ => 0.0,
    });
    gaps.fold(0.0, f64::max)
}

/// By how much the delivered is below the target in the worst 20 ms that are loud in the target, dB.
fn most_lost(t: &[f64], d: &[f64], overall: f64) -> f64 {
    short_time(t, 100, 25)
        .iter()
        .zip(short_time(d, 100, 25))
        .filter(|(t, _)| **t >= 0.25 * overall)
        .map(|(t, d)| -decibels(d / t))
        .fold(0.0, f64::max)
}

/// The largest difference of levels in windows of half a second, of a short texture of 0.1 s, dB.
fn most_apart(t: &[f64], d: &[f64], overall: f64) -> f64 {
    let window = if t.len() < SHORT + 2 * BESIDE {
        500
    } else {
        2_500
    };
    short_time(t, window, window / 2)
        .iter()
        .zip(short_time(d, window, window / 2))
        .filter(|(t, _)| **t >= 0.03 * overall)
        .map(|(t, d)| decibels(d / t).abs())
        .fold(0.0, f64::max)
}

/// The rms difference of the sorted levels of windows of 0.1 s, of a short texture 20 ms, dB; what is silent counts as 20 dB below the target's level.
fn distributions_apart(t: &[f64], d: &[f64], level: f64) -> f64 {
    let floor = SILENT * level;
    let window = if t.len() < SHORT + 2 * BESIDE {
        100
    } else {
        500
    };
    let sorted = |x: &[f64]| {
        let mut levels: Vec<f64> = short_time(x, window, window / 4)
            .iter()
            .map(|level| decibels(level + floor))
            .collect();
        levels.sort_by(f64::total_cmp);
        levels
    };
    let (t, d) = (sorted(t), sorted(d));
    let squares: f64 = t.iter().zip(&d).map(|(t, d)| (t - d).powi(2)).sum();
    (squares / t.len() as f64).sqrt()
}
