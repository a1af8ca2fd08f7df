//! Clock drift and missing samples in a recording of drive and response: how the delay of the response changes over the
//! recording, and the response corrected to the clock of its drive.

use crate::recording::{Clocks, LostBy, RecordingWarning};
use std::f64::consts::TAU;

use num_complex::Complex;

use super::change::Change;
use crate::delay::{Course, Fit, Local, Outliers, Rules, Slope};
use crate::fourier::{RealTransform, hann};
use crate::quantity::{Quantity, SampleRate};
use crate::resample::at_places;
use crate::series::Series;
use crate::spectrum::WelchConfig;
use crate::statistics::{mean, vertex};
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
    /// How it changes over the recording beside that; absent where no change is shown.
    pub change: Option<Change>,
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
const LONGEST_MISSING_S: f64 = 0.05;
/// The oversampling of the first search for a delay.
const FINE: usize = 4;
/// A block follows the others when the mean cosine of its phases reaches the first value, and the second value in standard
/// deviations of unrelated blocks.
const FOLLOWS: (f64, f64) = (0.1, 6.0);
/// The share of blocks that have to follow.
const MIN_FOLLOWING_SHARE: f64 = 0.7;
/// The largest plausible difference between two clocks, parts per million.
const MOST_PPM: f64 = 500.0;
/// The numbers of standard errors above which the delays of two parts of the band differ.
const APART: f64 = 3.0;
/// The largest relative difference between the delays found from lower and from upper frequencies.
const ALIKE: f64 = 0.2;
/// A smaller drift is neglected: the loss of the average at the upper end of the excited band, dB.
const LEAST_LOSS_DB: f64 = 0.1;
/// A smaller jump of the delay, in samples, is a wandering delay and not missing samples.
const FEWEST_MISSING: f64 = 0.7;
/// The largest number of places with missing samples that are looked for.
const MOST_STEPS: usize = 12;
/// What is left of the delay is steady below this, samples.
const STEADY: f64 = 0.15;
/// The largest coherence used in the weight of a line; higher values count as this.
const BEST_COHERENCE: f64 = 0.99;
/// Segments that overlap by half are fewer than they seem.
pub(super) const OVERLAP: f64 = 1.5;

/// `response` in its own unit, corrected to the clock of `drive`, when drift or missing samples are significant and large
/// enough to matter; `None` otherwise. `config` gives the longest segment. The delay at the beginning of the recording is kept.
///
/// Formula: the delay of every block of segments from the phases of its cross-spectrum relative to the mean of all,
/// Δ = −Σ W·ω·Im Z/Σ W·ω²·Re Z with Z = Sᵢ/S̄ and W = γ²/(1 − γ²); of a constant, a line, steps and a line with steps through the
/// delays the one of the lowest Bayesian information criterion, where lower and upper frequencies agree on it.
/// The average loses |sin(πfD)/(πfD)| at f when the delay grows by D. Where the gain of the response changes over the recording
/// too, only what turns a phase by more than π counts: a resonance that changes turns it by less.
///
/// Source: G. C. Carter (1987), Coherence and time delay estimation, Proc. IEEE 75(2), for the weights;
/// docs/decisions/transfer-functions.md.
#[must_use]
pub fn on_one_clock<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
) -> Option<OneClock<O>> {
    let blocks = Blocks::of_signals(drive, response, config)?;
    followed(drive, response, config, &blocks, &[])
}

/// `response` in its own unit, prepared for an estimate with `drive`: corrected to its clock where the clocks differ, with the
/// reported lost stretches `lost_s` (`[start, end]` in s) added to those with missing samples, and whether it changes over the recording.
///
/// Source: [`on_one_clock`].
#[must_use]
pub fn prepared<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: Series<O>,
    config: &WelchConfig,
    lost_s: Vec<[f64; 2]>,
) -> OneClock<O> {
    let blocks = Blocks::of_signals(drive, &response, config);
    let one = blocks
        .as_ref()
        .and_then(|blocks| followed(drive, &response, config, blocks, &lost_s));
    match one {
        Some(mut one) => {
            one.missing_s.extend(lost_s);
            one
        }
        None => OneClock {
            response,
            change: blocks.and_then(|blocks| Change::of(&blocks, &lost_s)),
            missing_s: lost_s,
            warnings: Vec::new(),
        },
    }
}

/// `response` corrected by the course of its delay; `None` where that is constant.
fn followed<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
    blocks: &Blocks,
    lost_s: &[[f64; 2]],
) -> Option<OneClock<O>> {
    let mut course = blocks.course()?;
    let mut one = course.corrected(response, blocks)?;
    let change = |one: &OneClock<O>| {
        let left_out: Vec<[f64; 2]> = one.missing_s.iter().chain(lost_s).copied().collect();
        Change::of(
            &Blocks::of_signals(drive, &one.response, config)?,
            &left_out,
        )
    };
    one.change = change(&one);
    if one.change.is_some() && course.keep_above_half_a_turn(blocks) {
        one = course.corrected(response, blocks)?;
        one.change = change(&one);
    }
    Some(one)
}

/// How the delays of blocks of a recording may change, samples.
fn rules(rate: SampleRate) -> Rules {
    Rules {
        overlap: OVERLAP,
        clear: 1.1,
        aside: 3,
        steps: MOST_STEPS,
        sizes: FEWEST_MISSING..LONGEST_MISSING_S * rate.hz(),
        steady: STEADY,
        least: 1e-4,
        outliers: Outliers::Held,
    }
}

/// How the delay changes, samples.
pub(super) struct Drifting {
    /// The drift and its standard error, parts per million, if it is significant and large enough.
    drift_ppm: Option<[f64; 2]>,
    /// Where samples are missing, and how many.
    steps: Vec<[f64; 2]>,
}

impl Drifting {
    /// Leaves out what turns no phase by more than π: the change of a system does as much. Says whether there was any.
    pub(super) fn keep_above_half_a_turn(&mut self, blocks: &Blocks) -> bool {
        let last = blocks.lines.last().copied().unwrap_or(0);
        let least = std::f64::consts::PI / blocks.radians(last).max(f64::MIN_POSITIVE);
        let before = (self.drift_ppm, self.steps.len());
        self.drift_ppm =
            (self.drift_ppm).filter(|[ppm, _]| ppm.abs() * 1e-6 * blocks.length() > least);
        self.steps.retain(|[_, missing]| missing.abs() > least);
        before != (self.drift_ppm, self.steps.len())
    }

    /// Whether there is nothing to correct.
    pub(super) fn is_none(&self) -> bool {
        self.drift_ppm.is_none() && self.steps.is_empty()
    }

    /// The stretches where samples are missing, `[start, end]` in s, and the warnings about it.
    pub(super) fn said(&self, blocks: &Blocks) -> (Vec<[f64; 2]>, Vec<Warning>) {
        let rate = blocks.rate;
        let drift = self.drift_ppm.map(|[ppm, uncertainty_ppm]| {
            let of = Clocks::Response {
                ppm,
                uncertainty_ppm,
            };
            Warning::from(RecordingWarning::ClocksDiffer { of })
        });
        let steps = self.steps.iter().map(|[at, count]| {
            let by = LostBy::Unreported {
                count: *count,
                at_s: at / rate.hz(),
            };
            Warning::from(RecordingWarning::SamplesLost { by })
        });
        let reach = blocks.span as f64;
        let missing_s = self.steps.iter().map(|[at, _]| {
            [at - 0.5 * reach, at + 0.5 * reach].map(|sample| sample.max(0.0) / rate.hz())
        });
        (
            missing_s.collect(),
            drift.into_iter().chain(steps).collect(),
        )
    }

    /// `response` corrected by it; `None` where there is nothing to correct.
    fn corrected<O: Quantity>(&self, response: &Series<O>, blocks: &Blocks) -> Option<OneClock<O>> {
        if self.is_none() {
            return None;
        }
        let (missing_s, warnings) = self.said(blocks);
        let about = mean(response.samples());
        let centred: Vec<f64> = response.samples().iter().map(|v| v - about).collect();
        let mut samples = at_places(&centred, centred.len(), |i| {
            i as f64 + self.delay_at(i as f64)
        });
        samples.iter_mut().for_each(|v| *v += about);
        Some(OneClock {
            response: Series::new(samples, response.rate()).ok()?,
            missing_s,
            warnings,
            change: None,
        })
    }

    /// The delay at sample `i` of the drive.
    pub(super) fn delay_at(&self, i: f64) -> f64 {
        let drift = self.drift_ppm.map_or(0.0, |[ppm, _]| ppm * 1e-6 * i);
        let passed = self.steps.iter().filter(|[at, _]| *at <= i);
        drift - passed.map(|[_, missing]| missing).sum::<f64>()
    }
}

/// Samples that are taken at a time.
const PART: usize = 1 << 16;

/// The cross-spectra of the blocks of two signals that come part by part.
pub(super) struct BlockSums {
    found: Blocks,
    hop: usize,
    in_block: usize,
    blocks: usize,
    /// The segments that were added, and those of the current block.
    done: usize,
    cross: Vec<Complex<f64>>,
    power: Vec<f64>,
    window: Vec<f64>,
    transform: RealTransform,
    held: [Vec<f64>; 2],
}

impl BlockSums {
    /// Nothing yet, of signals of so many `samples`; `None` where they give too few blocks.
    pub(super) fn new(samples: usize, config: &WelchConfig, rate: SampleRate) -> Option<Self> {
        let segment = config.segment.min(samples / (FEWEST_BLOCKS / 2 + 1)) & !1;
        if segment < SHORTEST {
            return None;
        }
        let hop = segment / 2;
        let count = (samples - segment) / hop + 1;
        let in_block = count.div_ceil(MOST_BLOCKS);
        let blocks = count / in_block;
        if blocks < FEWEST_BLOCKS {
            return None;
        }
        let all = segment / 2 + 1;
        Some(Self {
            found: Blocks {
                segment,
                span: segment + (in_block - 1) * hop,
                rate,
                at: Vec::with_capacity(blocks),
                cross: Vec::with_capacity(blocks),
                drive: Vec::with_capacity(blocks),
                drive_power: vec![0.0; all],
                response_power: vec![0.0; all],
                lines: Vec::new(),
            },
            hop,
            in_block,
            blocks,
            done: 0,
            cross: vec![Complex::default(); all],
            power: vec![0.0; all],
            window: (0..segment)
                .map(|i| hann(i as f64 / segment as f64))
                .collect(),
            transform: RealTransform::new(segment),
            held: [Vec::new(), Vec::new()],
        })
    }

    /// Takes the next samples of both, as many of each.
    pub(super) fn add(&mut self, drive: &[f64], response: &[f64]) {
        let mut held = std::mem::take(&mut self.held);
        held[0].extend_from_slice(drive);
        held[1].extend_from_slice(response);
        let mut from = 0;
        while let (Some(drive), Some(response)) = (
            held[0].get(from..from + self.found.segment),
            held[1].get(from..from + self.found.segment),
        ) {
            self.add_segment(drive, response);
            from += self.hop;
        }
        for held in &mut held {
            held.drain(..from);
        }
        self.held = held;
    }

    fn add_segment(&mut self, drive: &[f64], response: &[f64]) {
        if self.done >= self.blocks * self.in_block {
            return;
        }
        let (window, transform) = (&self.window, &mut self.transform);
        let mut lines_of = |samples: &[f64]| {
            let about = mean(samples);
            let windowed: Vec<f64> = samples
                .iter()
                .zip(window)
                .map(|(v, w)| (v - about) * w)
                .collect();
            transform.forward(&windowed)
        };
        let (x, y) = (lines_of(drive), lines_of(response));
        for (line, (x, y)) in x.iter().zip(&y).enumerate() {
            self.cross[line] += x.conj() * y;
            self.power[line] += x.norm_sqr();
            self.found.response_power[line] += y.norm_sqr();
        }
        self.done += 1;
        if !self.done.is_multiple_of(self.in_block) {
            return;
        }
        for (sum, power) in self.found.drive_power.iter_mut().zip(&self.power) {
            *sum += power;
        }
        let from = ((self.done - self.in_block) * self.hop) as f64;
        let all = self.power.len();
        self.found.at.push(from + 0.5 * self.found.span as f64);
        let cross = std::mem::replace(&mut self.cross, vec![Complex::default(); all]);
        let power = std::mem::replace(&mut self.power, vec![0.0; all]);
        self.found.cross.push(cross);
        self.found.drive.push(power);
    }

    /// The blocks of all samples; `None` where they were fewer than stated, or too few lines are excited.
    pub(super) fn blocks(self) -> Option<Blocks> {
        let mut found = self.found;
        if found.at.len() < self.blocks {
            return None;
        }
        let strongest = found.drive_power.iter().copied().fold(0.0, f64::max);
        // The window's leakage about 0 Hz, and the real line at the end.
        found.lines = (2..found.drive_power.len() - 1)
            .filter(|line| found.drive_power[*line] > EXCITED * strongest)
            .collect();
        (found.lines.len() >= FEWEST_LINES).then_some(found)
    }
}

/// The cross-spectra of consecutive blocks of segments.
pub(super) struct Blocks {
    /// The length of a segment, and of a block, in samples.
    pub(super) segment: usize,
    pub(super) span: usize,
    pub(super) rate: SampleRate,
    /// The middle of each block, samples.
    pub(super) at: Vec<f64>,
    pub(super) cross: Vec<Vec<Complex<f64>>>,
    pub(super) drive: Vec<Vec<f64>>,
    pub(super) drive_power: Vec<f64>,
    response_power: Vec<f64>,
    /// The lines that are excited.
    pub(super) lines: Vec<usize>,
}

impl Blocks {
    /// The blocks of two signals that were sampled together; `None` where there are too few.
    fn of_signals<I: Quantity, O: Quantity>(
        drive: &Series<I>,
        response: &Series<O>,
        config: &WelchConfig,
    ) -> Option<Self> {
        let rate = drive.rate();
        let (drive, samples) = (drive.samples(), response.samples());
        let together = rate == response.rate() && drive.len() == samples.len();
        together.then(|| Self::of(drive, samples, config, rate))?
    }

    fn of(drive: &[f64], response: &[f64], config: &WelchConfig, rate: SampleRate) -> Option<Self> {
        let mut sums = BlockSums::new(drive.len(), config, rate)?;
        for (drive, response) in drive.chunks(PART).zip(response.chunks(PART)) {
            sums.add(drive, response);
        }
        sums.blocks()
    }

    /// The phase shift of a line by a delay of one sample, rad.
    fn radians(&self, line: usize) -> f64 {
        TAU * line as f64 / self.segment as f64
    }

    /// How the delay changes over the recording, where it can be followed.
    pub(super) fn course(&self) -> Option<Drifting> {
        let rules = rules(self.rate);
        let tracked = self.tracked()?;
        let first = Course::of(&tracked, &rules)?;
        let (before, _) = self.aligned(&|_| 0.0);
        let (coherence, mean) = self.aligned(&|at| first.change_at(at));
        let refined = self.refined(&tracked, &first, (&coherence, &mean), 0..self.lines.len());
        let course = Course::of(&refined, &rules)?;
        // Clock drift shifts all frequencies by the same delay; a change of the finger does not.
        let half = self.halved(&coherence);
        let slope = match course.slope {
            Some(_) => Slope::Free,
            None => Slope::None,
        };
        let fits = [0..half, half..self.lines.len()].map(|part| {
            let locals = self.refined(&tracked, &first, (&coherence, &mean), part);
            let fit = Fit::of(&locals, &course.steps, slope, &rules)?;
            let error = fit.slope_error(&locals, &rules);
            Some((fit, error))
        });
        let [Some((low, low_error)), Some((high, high_error))] = fits else {
            return None;
        };
        let apart = |low: f64, high: f64, error: f64, of: f64| {
            (low - high).abs() > (APART * error).max(ALIKE * of.abs())
        };
        let alike = !apart(
            low.slope,
            high.slope,
            low_error.hypot(high_error),
            course.fit.slope,
        );
        let jumped_apart = (0..course.steps.len()).any(|k| {
            let error = low.jump_errors[k].hypot(high.jump_errors[k]);
            apart(low.jumps[k], high.jumps[k], error, course.fit.jumps[k])
        });
        let better = |with: &[f64]| with.iter().sum::<f64>() > before.iter().sum::<f64>();
        if jumped_apart || !better(&coherence) {
            return None;
        }
        let shown = course.slope.filter(|[slope, _]| {
            alike && slope.abs() * 1e6 <= MOST_PPM && self.loss_db(*slope) > LEAST_LOSS_DB
        });
        let steps = course.steps.iter().zip(&course.fit.jumps);
        Some(Drifting {
            drift_ppm: shown.map(|shown| shown.map(|of| of * 1e6)),
            // After missing samples everything arrives earlier.
            steps: steps.map(|(at, jump)| [*at, -jump.round()]).collect(),
        })
    }

    /// From the first to the last block, samples.
    fn length(&self) -> f64 {
        self.at.last().unwrap_or(&0.0) - self.at.first().unwrap_or(&0.0)
    }

    /// The loss of the average at the upper end of the excited band for a delay that grows by `slope` samples per sample, dB.
    fn loss_db(&self, slope: f64) -> f64 {
        let last = self.lines.last().copied().unwrap_or(0);
        let half_turn = 0.5 * self.radians(last) * slope.abs() * self.length();
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
            locals.push(Local {
                at: *at,
                delay,
                weight: 1.0,
            });
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

    /// The delays of the blocks by the phases of the excited lines `part` relative to the mean once `course` is taken away.
    fn refined(
        &self,
        tracked: &[Local],
        course: &Course,
        (coherence, mean): (&[f64], &[Complex<f64>]),
        part: std::ops::Range<usize>,
    ) -> Vec<Local> {
        let followed = |at: f64| tracked.iter().any(|local| (local.at - at).abs() < 0.5);
        let blocks = self.at.iter().zip(&self.cross).zip(&self.drive);
        blocks
            .filter(|((at, _), _)| followed(**at))
            .map(|((at, cross), _)| {
                let mut delay = course.change_at(*at);
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
                Local {
                    at: *at,
                    delay,
                    weight: 1.0,
                }
            })
            .collect()
    }
}

/// The weight of a line with this coherence in the delay estimate, re its power.
fn weight(coherence: f64) -> f64 {
    let held = coherence.clamp(0.0, BEST_COHERENCE);
    held / (1.0 - held)
}
