//! Clock drift and missing samples in a recording of drive and response: how the delay of the response changes over the
//! recording, and the response corrected to the clock of its drive.

use crate::recording::{Clocks, LostBy, RecordingWarning};
use std::f64::consts::TAU;

use num_complex::Complex;

use crate::fourier::{RealTransform, hann};
use crate::quantity::{Quantity, SampleRate};
use crate::resample::at_places;
use crate::series::Series;
use crate::spectrum::WelchConfig;
use crate::statistics::{mean, median, vertex};
use crate::warning::Warning;

/// A response corrected to the clock of its drive.
#[derive(Clone, Debug)]
pub struct OneClock<O: Quantity> {
    /// The response, as long as before.
    pub response: Series<O>,
    /// The stretches without valid samples of both drive and response, as `[start, end]` in s.
    pub missing_s: Vec<[f64; 2]>,
    /// The warnings about drift and missing samples for which it was corrected.
    pub warnings: Vec<Warning>,
}

/// The fewest blocks from which a change of the delay is estimated.
const FEWEST_BLOCKS: usize = 16;
/// The largest number of blocks; more would not improve the estimate.
const MOST_BLOCKS: usize = 256;
/// The shortest segment, in samples.
const SHORTEST: usize = 64;
/// The fewest excited lines from whose phases a delay is estimated.
const FEWEST_LINES: usize = 16;
/// Lines this far below the strongest are not excited: 40 dB, as elsewhere.
const EXCITED: f64 = super::cross::EXCITED;
/// From one block to the next the delay changes by no more than this, s.
const LONGEST_MISSING_S: f64 = 0.02;
/// The oversampling of the first search for a delay.
const FINE: usize = 4;
/// A block follows the others when the mean cosine of its phases reaches the first value, and the second value in standard
/// deviations of unrelated blocks.
const FOLLOWS: (f64, f64) = (0.1, 6.0);
/// The share of blocks that have to follow.
const MIN_FOLLOWING_SHARE: f64 = 0.7;
/// The largest plausible difference between two clocks, parts per million.
const MOST_PPM: f64 = 500.0;
/// The numbers of standard errors above which a drift, and a step, are significant.
const STANDS_OUT: (f64, f64) = (3.0, 8.0);
/// The largest relative difference between the delays found from lower and from upper frequencies.
const ALIKE: f64 = 0.2;
/// A smaller drift is neglected: the loss of the average at the upper end of the excited band, dB.
const LEAST_LOSS_DB: f64 = 0.1;
/// A smaller jump of the delay, in samples, is a wandering delay and not missing samples.
const FEWEST_MISSING: f64 = 0.7;
/// The largest number of places with missing samples that are looked for.
const MOST_STEPS: usize = 4;
/// The fewest blocks on either side of a step.
const BLOCKS_ASIDE: usize = 4;
/// The number of parts of the recording from which the error of the drift is estimated.
const PARTS: usize = 20;
/// The largest coherence used in the weight of a line; higher values count as this.
const BEST_COHERENCE: f64 = 0.99;

/// `response` in its own unit, corrected to the clock of `drive`, when drift or missing samples are significant and large
/// enough to matter; `None` otherwise. `config` gives the longest segment. The delay at the beginning of the recording is kept.
///
/// Formula: the delay of every block of segments from the phases of its cross-spectrum relative to the mean of all,
/// Δ = −Σ W·ω·Im Z/Σ W·ω²·Re Z with Z = Sᵢ/S̄ and W = γ²/(1 − γ²); a line with steps through the delays by weighted
/// least squares; its standard error is the larger of that of the blocks and that of a twentieth of the recording each.
/// The average loses |sin(πfD)/(πfD)| at f when the delay grows by D.
///
/// Source: G. C. Carter (1987), Coherence and time delay estimation, Proc. IEEE 75(2), for the weights.
#[must_use]
pub fn on_one_clock<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
) -> Option<OneClock<O>> {
    let rate = drive.rate();
    if rate != response.rate() || drive.samples().len() != response.samples().len() {
        return None;
    }
    let blocks = Blocks::of(drive.samples(), response.samples(), config, rate)?;
    let course = blocks.course()?;
    if course.drift_ppm.is_none() && course.steps.is_empty() {
        return None;
    }
    let mut warnings = Vec::new();
    if let Some([ppm, uncertainty]) = course.drift_ppm {
        warnings.push(Warning::from(RecordingWarning::ClocksDiffer {
            of: Clocks::Response {
                ppm,
                uncertainty_ppm: uncertainty,
            },
        }));
    }
    for [at, missing] in &course.steps {
        warnings.push(Warning::from(RecordingWarning::SamplesLost {
            by: LostBy::Unreported {
                count: *missing,
                at_s: at / rate.hz(),
            },
        }));
    }
    let reach = blocks.span as f64;
    let missing_s = course.steps.iter().map(|[at, _]| {
        [at - 0.5 * reach, at + 0.5 * reach].map(|sample| sample.max(0.0) / rate.hz())
    });
    let about = mean(response.samples());
    let centred: Vec<f64> = response.samples().iter().map(|v| v - about).collect();
    let mut samples = at_places(&centred, centred.len(), |i| {
        i as f64 + course.delay_at(i as f64)
    });
    samples.iter_mut().for_each(|v| *v += about);
    Some(OneClock {
        response: Series::new(samples, rate).ok()?,
        missing_s: missing_s.collect(),
        warnings,
    })
}

/// `response` in its own unit, prepared for an estimate with `drive`: corrected to its clock where the clocks differ, with the
/// reported lost stretches `lost_s` (`[start, end]` in s) added to those with missing samples.
///
/// Source: [`on_one_clock`].
#[must_use]
pub fn prepared<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: Series<O>,
    config: &WelchConfig,
    lost_s: Vec<[f64; 2]>,
) -> OneClock<O> {
    match on_one_clock(drive, &response, config) {
        Some(mut one) => {
            one.missing_s.extend(lost_s);
            one
        }
        None => OneClock {
            response,
            missing_s: lost_s,
            warnings: Vec::new(),
        },
    }
}

/// How the delay changes, samples.
struct Course {
    /// The drift and its standard error, parts per million, if it is significant and large enough.
    drift_ppm: Option<[f64; 2]>,
    /// Where samples are missing, and how many.
    steps: Vec<[f64; 2]>,
}

impl Course {
    /// The delay at sample `i` of the drive.
    fn delay_at(&self, i: f64) -> f64 {
        let drift = self.drift_ppm.map_or(0.0, |[ppm, _]| ppm * 1e-6 * i);
        let passed = self.steps.iter().filter(|[at, _]| *at <= i);
        drift - passed.map(|[_, missing]| missing).sum::<f64>()
    }
}

/// The cross-spectra of consecutive blocks of segments.
struct Blocks {
    /// The length of a segment, and of a block, in samples.
    segment: usize,
    span: usize,
    rate: SampleRate,
    /// The middle of each block, samples.
    at: Vec<f64>,
    cross: Vec<Vec<Complex<f64>>>,
    drive: Vec<Vec<f64>>,
    drive_power: Vec<f64>,
    response_power: Vec<f64>,
    /// The lines that are excited.
    lines: Vec<usize>,
}

impl Blocks {
    fn of(drive: &[f64], response: &[f64], config: &WelchConfig, rate: SampleRate) -> Option<Self> {
        let segment = config.segment.min(drive.len() / (FEWEST_BLOCKS / 2 + 1)) & !1;
        if segment < SHORTEST {
            return None;
        }
        let hop = segment / 2;
        let count = (drive.len() - segment) / hop + 1;
        let in_block = count.div_ceil(MOST_BLOCKS);
        let blocks = count / in_block;
        if blocks < FEWEST_BLOCKS {
            return None;
        }
        let window: Vec<f64> = (0..segment)
            .map(|i| hann(i as f64 / segment as f64))
            .collect();
        let mut transform = RealTransform::new(segment);
        let mut lines_of = |samples: &[f64]| {
            let about = mean(samples);
            let windowed: Vec<f64> = samples
                .iter()
                .zip(&window)
                .map(|(v, w)| (v - about) * w)
                .collect();
            transform.forward(&windowed)
        };
        let all = segment / 2 + 1;
        let mut found = Self {
            segment,
            span: segment + (in_block - 1) * hop,
            rate,
            at: Vec::with_capacity(blocks),
            cross: Vec::with_capacity(blocks),
            drive: Vec::with_capacity(blocks),
            drive_power: vec![0.0; all],
            response_power: vec![0.0; all],
            lines: Vec::new(),
        };
        for block in 0..blocks {
            let mut cross = vec![Complex::default(); all];
            let mut power = vec![0.0; all];
            for k in 0..in_block {
                let from = (block * in_block + k) * hop;
                let x = lines_of(&drive[from..from + segment]);
                let y = lines_of(&response[from..from + segment]);
                for line in 0..all {
                    cross[line] += x[line].conj() * y[line];
                    power[line] += x[line].norm_sqr();
                    found.response_power[line] += y[line].norm_sqr();
                }
            }
            for (sum, power) in found.drive_power.iter_mut().zip(&power) {
                *sum += power;
            }
            let from = (block * in_block * hop) as f64;
            found.at.push(from + 0.5 * found.span as f64);
            found.cross.push(cross);
            found.drive.push(power);
        }
        let strongest = found.drive_power.iter().copied().fold(0.0, f64::max);
        // The window's leakage about 0 Hz, and the real line at the end.
        found.lines = (2..all - 1)
            .filter(|line| found.drive_power[*line] > EXCITED * strongest)
            .collect();
        (found.lines.len() >= FEWEST_LINES).then_some(found)
    }

    /// The phase shift of a line by a delay of one sample, rad.
    fn radians(&self, line: usize) -> f64 {
        TAU * line as f64 / self.segment as f64
    }

    /// How the delay changes over the recording, where it can be followed.
    fn course(&self) -> Option<Course> {
        let tracked = self.tracked()?;
        let first = Model::chosen(&tracked, self)?;
        let (before, _) = self.aligned(&|_| 0.0);
        let (coherence, mean) = self.aligned(&|at| first.delay_at(at));
        let refined = self.refined(&tracked, &first, (&coherence, &mean), 0..self.lines.len());
        let model = Model::chosen(&refined, self)?;
        // Clock drift shifts all frequencies by the same delay; a change of the finger does not.
        let half = self.halved(&coherence);
        let fits = [0..half, half..self.lines.len()].map(|part| {
            let locals = self.refined(&tracked, &first, (&coherence, &mean), part);
            let fit = Fit::of(&locals, &model.steps)?;
            let error = fit.slope_error(&locals);
            Some((fit, error))
        });
        let [Some((low, low_error)), Some((high, high_error))] = fits else {
            return None;
        };
        let apart = |low: f64, high: f64, error: f64, of: f64| {
            (low - high).abs() > (STANDS_OUT.0 * error).max(ALIKE * of.abs())
        };
        let slope_error = low_error.hypot(high_error);
        let alike = !apart(low.slope, high.slope, slope_error, model.fit.slope);
        let jumped_apart = (0..model.steps.len()).any(|k| {
            let error = low.jump_errors[k].hypot(high.jump_errors[k]);
            apart(low.jumps[k], high.jumps[k], error, model.fit.jumps[k])
        });
        if jumped_apart {
            return None;
        }
        let better = |with: &[f64]| with.iter().sum::<f64>() > before.iter().sum::<f64>();
        if !better(&coherence) {
            return None;
        }
        let error = model.fit.slope_error(&refined);
        let ppm = model.fit.slope * 1e6;
        let shown = alike
            && model.fit.slope.abs() > STANDS_OUT.0 * error
            && ppm.abs() <= MOST_PPM
            && self.loss_db(model.fit.slope) > LEAST_LOSS_DB;
        let steps = model.steps.iter().zip(&model.fit.jumps);
        Some(Course {
            drift_ppm: shown.then_some([ppm, error * 1e6]),
            // After missing samples everything arrives earlier.
            steps: steps.map(|(at, jump)| [*at, -jump.round()]).collect(),
        })
    }

    /// The loss of the average at the upper end of the excited band for a delay that grows by `slope` samples per sample, dB.
    fn loss_db(&self, slope: f64) -> f64 {
        let last = self.lines.last().copied().unwrap_or(0);
        let length = self.at.last().unwrap_or(&0.0) - self.at.first().unwrap_or(&0.0);
        let half_turn = 0.5 * self.radians(last) * slope.abs() * length;
        match half_turn {
            small if small < 1e-9 => 0.0,
            large if large >= std::f64::consts::PI => f64::INFINITY,
            turn => -20.0 * (turn.sin() / turn).log10(),
        }
    }

    /// The delays of the blocks from their phases alone, each searched around that of the previous block.
    fn tracked(&self) -> Option<Vec<Local>> {
        let n = FINE * self.segment;
        let mut transform = RealTransform::new(n);
        let search = ((LONGEST_MISSING_S * self.rate.hz()) as usize).clamp(2, self.segment / 4);
        let least = FOLLOWS
            .0
            .max(FOLLOWS.1 / (2.0 * self.lines.len() as f64).sqrt());
        let mut sum = vec![Complex::<f64>::default(); self.lines.len()];
        let (mut near, mut locals) = (0.0f64, Vec::new());
        for ((at, cross), power) in self.at.iter().zip(&self.cross).zip(&self.drive) {
            // A block gives no information about lines that it does not drive.
            let phases: Vec<Complex<f64>> = self
                .lines
                .iter()
                .map(|line| {
                    let usual = self.drive_power[*line] / self.at.len() as f64;
                    let share = (power[*line] / usual.max(f64::MIN_POSITIVE)).min(1.0);
                    cross[*line] * (share / cross[*line].norm().max(f64::MIN_POSITIVE))
                })
                .collect();
            let delay = if locals.is_empty() {
                0.0
            } else {
                let size: f64 = sum
                    .iter()
                    .zip(&phases)
                    .map(|(s, p)| s.norm() * p.norm())
                    .sum();
                let mut bins = vec![Complex::default(); n / 2 + 1];
                for ((line, phase), sum) in self.lines.iter().zip(&phases).zip(&sum) {
                    // The lags lie around the delay of the block before.
                    let turned = Complex::from_polar(1.0, self.radians(*line) * near);
                    bins[*line] = phase * sum.conj() * turned;
                }
                let lags = transform.inverse(bins);
                let reach = (search * FINE) as i64;
                let at_lag = |lag: i64| lags[lag.rem_euclid(n as i64) as usize];
                let Some(best) = (-reach..=reach).max_by(|a, b| at_lag(*a).total_cmp(&at_lag(*b)))
                else {
                    continue;
                };
                let cosine = 0.5 * n as f64 * at_lag(best) / size.max(f64::MIN_POSITIVE);
                if cosine < least {
                    continue;
                }
                let part = vertex([best - 1, best, best + 1].map(at_lag));
                near + (best as f64 + part) / FINE as f64
            };
            near = delay;
            for ((line, phase), sum) in self.lines.iter().zip(&phases).zip(&mut sum) {
                *sum += phase * Complex::from_polar(1.0, self.radians(*line) * delay);
            }
            locals.push(Local { at: *at, delay });
        }
        let enough = locals.len() as f64 >= MIN_FOLLOWING_SHARE * self.at.len() as f64;
        (enough && locals.len() >= FEWEST_BLOCKS).then_some(locals)
    }

    /// The coherence of the excited lines and their mean cross-spectrum once every block is moved by its delay.
    fn aligned(&self, delay: &dyn Fn(f64) -> f64) -> (Vec<f64>, Vec<Complex<f64>>) {
        let mean: Vec<Complex<f64>> = self
            .lines
            .iter()
            .map(|line| {
                let blocks = self.at.iter().zip(&self.cross);
                let radians = self.radians(*line);
                blocks
                    .map(|(at, cross)| {
                        cross[*line] * Complex::from_polar(1.0, radians * delay(*at))
                    })
                    .sum()
            })
            .collect();
        let coherence = self.lines.iter().zip(&mean).map(|(line, mean)| {
            let powers = self.drive_power[*line] * self.response_power[*line];
            mean.norm_sqr() / powers.max(f64::MIN_POSITIVE)
        });
        (coherence.collect(), mean)
    }

    /// The excited line below which lies half of the total weight of the delay estimate.
    fn halved(&self, coherence: &[f64]) -> usize {
        let told: Vec<f64> = coherence
            .iter()
            .zip(&self.lines)
            .map(|(coherence, line)| weight(*coherence) * self.radians(*line).powi(2))
            .collect();
        let all: f64 = told.iter().sum();
        let mut sum = 0.0;
        told.iter()
            .position(|told| {
                sum += told;
                sum >= 0.5 * all
            })
            .unwrap_or(0)
    }

    /// The delays of the blocks by the phases of the excited lines `part` relative to the mean once `model` is taken away.
    fn refined(
        &self,
        tracked: &[Local],
        model: &Model,
        (coherence, mean): (&[f64], &[Complex<f64>]),
        part: std::ops::Range<usize>,
    ) -> Vec<Local> {
        let followed = |at: f64| tracked.iter().any(|local| (local.at - at).abs() < 0.5);
        let blocks = self.at.iter().zip(&self.cross).zip(&self.drive);
        blocks
            .filter(|((at, _), _)| followed(**at))
            .map(|((at, cross), _)| {
                let mut delay = model.delay_at(*at);
                for _ in 0..3 {
                    let (mut turned, mut all) = (0.0, 0.0);
                    for i in part.clone() {
                        let radians = self.radians(self.lines[i]);
                        let moved =
                            cross[self.lines[i]] * Complex::from_polar(1.0, radians * delay);
                        let power = mean[i].norm_sqr().max(f64::MIN_POSITIVE);
                        let relative = moved * mean[i].conj() / power;
                        let weight = weight(coherence[i]);
                        turned -= weight * radians * relative.im;
                        all += weight * radians * radians * relative.re;
                    }
                    if all <= 0.0 {
                        break;
                    }
                    delay += turned / all;
                }
                Local { at: *at, delay }
            })
            .collect()
    }
}

/// The weight of a line with this coherence in the delay estimate, re its power.
fn weight(coherence: f64) -> f64 {
    let held = coherence.clamp(0.0, BEST_COHERENCE);
    held / (1.0 - held)
}

/// The delay of a block, samples.
#[derive(Clone, Copy, Debug)]
struct Local {
    at: f64,
    delay: f64,
}

/// A line with all significant steps.
struct Model {
    fit: Fit,
    /// Where the delay jumps, samples of the drive.
    steps: Vec<f64>,
}

impl Model {
    /// The line through `locals` with the significant steps, the largest first.
    fn chosen(locals: &[Local], blocks: &Blocks) -> Option<Self> {
        let longest = LONGEST_MISSING_S * blocks.rate.hz();
        let mut steps: Vec<f64> = Vec::new();
        let mut fit = Fit::of(locals, &steps)?;
        while steps.len() < MOST_STEPS {
            let far = |i: usize| {
                let place = 0.5 * (locals[i].at + locals[i + 1].at);
                let near = BLOCKS_ASIDE as f64 * 0.5 * blocks.span as f64;
                steps
                    .iter()
                    .all(|step| (step - place).abs() > near)
                    .then_some(place)
            };
            let within = BLOCKS_ASIDE..locals.len().saturating_sub(BLOCKS_ASIDE);
            let next = within
                .filter_map(far)
                .filter_map(|place| {
                    let mut tried = steps.clone();
                    tried.push(place);
                    tried.sort_by(f64::total_cmp);
                    Some((Fit::of(locals, &tried)?, tried))
                })
                .min_by(|a, b| a.0.variance.total_cmp(&b.0.variance));
            let Some((better, tried)) = next else {
                break;
            };
            let stands_out = better
                .jumps
                .iter()
                .zip(&better.jump_errors)
                .all(|(jump, error)| {
                    (FEWEST_MISSING..=longest).contains(&jump.abs())
                        && jump.abs() > STANDS_OUT.1 * error
                });
            // A step explains most of what a line leaves.
            if !stands_out || better.variance > 0.5 * fit.variance {
                break;
            }
            (fit, steps) = (better, tried);
        }
        Some(Self { fit, steps })
    }

    /// The delay at sample `at`, re that of the first.
    fn delay_at(&self, at: f64) -> f64 {
        let jumps = self.steps.iter().zip(&self.fit.jumps);
        let passed = jumps.filter(|(step, _)| **step <= at);
        self.fit.slope * at + passed.map(|(_, jump)| jump).sum::<f64>()
    }
}

/// A line of one slope through delays, which jumps at given places.
#[derive(Clone, Debug)]
struct Fit {
    /// Samples of delay a sample.
    slope: f64,
    /// How far the delay jumps at each place, samples.
    jumps: Vec<f64>,
    jump_errors: Vec<f64>,
    /// The variance of what is left.
    variance: f64,
    /// The residual of each delay; none for those at a jump.
    left: Vec<Option<f64>>,
    /// The sum of the squared distances along the line.
    along: f64,
}

impl Fit {
    /// The fit through `locals` with jumps at `steps`; the blocks at a step are left out.
    fn of(locals: &[Local], steps: &[f64]) -> Option<Self> {
        let hop = locals
            .windows(2)
            .map(|pair| pair[1].at - pair[0].at)
            .fold(f64::INFINITY, f64::min);
        let clear = |at: f64| steps.iter().all(|step| (at - step).abs() > 1.1 * hop);
        let side = |at: f64| steps.iter().filter(|step| **step <= at).count();
        let mut weights: Vec<f64> = locals
            .iter()
            .map(|local| f64::from(u8::from(clear(local.at))))
            .collect();
        let used = weights.iter().sum::<f64>();
        let freedom = used - 2.0 - steps.len() as f64;
        if freedom < 4.0 {
            return None;
        }
        let sides = steps.len() + 1;
        let mut fit = None;
        // Reweighted least squares: an outlying block does not change the slope.
        for _ in 0..3 {
            let mut sums = vec![[0.0; 3]; sides];
            for (local, w) in locals.iter().zip(&weights) {
                let sum = &mut sums[side(local.at)];
                *sum = [sum[0] + w, sum[1] + w * local.at, sum[2] + w * local.delay];
            }
            if sums.iter().any(|sum| sum[0] < 2.0) {
                return None;
            }
            let middle = |s: usize| [sums[s][1] / sums[s][0], sums[s][2] / sums[s][0]];
            let (mut across, mut along) = (0.0, 0.0);
            for (local, w) in locals.iter().zip(&weights) {
                let [at, delay] = middle(side(local.at));
                across += w * (local.at - at) * (local.delay - delay);
                along += w * (local.at - at).powi(2);
            }
            let slope = across / along.max(f64::MIN_POSITIVE);
            let level = |s: usize| middle(s)[1] - slope * middle(s)[0];
            let left: Vec<f64> = locals
                .iter()
                .map(|local| local.delay - level(side(local.at)) - slope * local.at)
                .collect();
            let squares = left.iter().zip(&weights).map(|(v, w)| w * v * v);
            let variance = squares.sum::<f64>() / freedom;
            let jumps = (1..sides).map(|s| level(s) - level(s - 1)).collect();
            let jump_errors = (1..sides).map(|s| {
                let apart = middle(s)[0] - middle(s - 1)[0];
                let part = 1.0 / sums[s][0] + 1.0 / sums[s - 1][0];
                (OVERLAP * variance * (part + apart * apart / along)).sqrt()
            });
            fit = Some(Self {
                slope,
                jumps,
                jump_errors: jump_errors.collect(),
                variance,
                left: left
                    .iter()
                    .zip(locals)
                    .map(|(v, local)| clear(local.at).then_some(*v))
                    .collect(),
                along,
            });
            let mut sizes: Vec<f64> = left
                .iter()
                .zip(locals)
                .filter(|(_, local)| clear(local.at))
                .map(|(v, _)| v.abs())
                .collect();
            let usual = median(&mut sizes).unwrap_or(0.0).max(1e-9);
            for ((w, v), local) in weights.iter_mut().zip(&left).zip(locals) {
                if clear(local.at) {
                    *w = (4.0 * usual / v.abs().max(1e-12)).min(1.0);
                }
            }
        }
        fit
    }

    /// The standard error of the slope: the larger of that of single blocks and that of longer parts of the recording, in which
    /// a delay that wanders shows.
    fn slope_error(&self, locals: &[Local]) -> f64 {
        let of_blocks = (OVERLAP * self.variance / self.along).sqrt();
        let count = locals.len().div_ceil(PARTS).max(1);
        let pairs: Vec<(f64, f64)> = locals
            .iter()
            .zip(&self.left)
            .filter_map(|(local, left)| Some((local.at, (*left)?)))
            .collect();
        let parts: Vec<[f64; 2]> = pairs
            .chunks(count)
            .map(|part| {
                let of =
                    |f: fn(&(f64, f64)) -> f64| part.iter().map(f).sum::<f64>() / part.len() as f64;
                [of(|p| p.0), of(|p| p.1)]
            })
            .collect();
        let middle = mean(&parts.iter().map(|p| p[0]).collect::<Vec<f64>>());
        let along: f64 = parts.iter().map(|p| (p[0] - middle).powi(2)).sum();
        let squares: f64 = parts.iter().map(|p| p[1] * p[1]).sum();
        let freedom = (parts.len() as f64 - 2.0 - self.jumps.len() as f64).max(1.0);
        of_blocks.max((squares / freedom / along.max(f64::MIN_POSITIVE)).sqrt())
    }
}

/// Segments that overlap by half are fewer than they seem.
const OVERLAP: f64 = 1.5;
