//! The transfer function of an impact test: every hit a segment, transformed without a window but those stated.

use crate::recording::{RecordingWarning, ReversedSign};
use std::f64::consts::PI;

use num_complex::Complex;

use super::decay::Left;
use super::pulses::{Force, without_baseline};
use super::record::{Hit, ImpactTest, ImpactTraces, MOST_DAMPING};
use super::segments::{AT_REST, MOST_BEFORE, Segments, Signals, polarity};
use super::{ExponentialWindow, ForceWindow, ImpactConfig, ImpactWarning, NotDecayed};
use crate::fourier::RealTransform;
use crate::integrity::{ChannelFault, SignalWarning, copied};
use crate::quantity::{Band, Hertz, Quantity, SampleRate};
use crate::series::Series;
use crate::spectrum::EstimateError;
use crate::statistics::{mean, median};
use crate::transfer::judge::{self, Unexcited};
use crate::transfer::{CrossSpectra, Estimator, Known, TransferError, TransferFunction};
use crate::warning::{Few, FewWarning, Scatter, ScatterWarning, Warning};

/// So many hits are recommended.
const RECOMMENDED_HITS: usize = 3;
/// The pulse has ended when the force falls below this share of its peak, or below so many times its noise.
const ENDED: (f64, f64) = (0.01, 3.0);
/// The shortest taper of the force window, samples.
const SHORTEST_TAPER: usize = 8;
/// The highest level of the force is the highest median of so many lines.
const MEDIAN_LINES: usize = 3;
/// So many hits tell which of them differs: by this part of the energy of its response, and this many times that of the median hit.
const LEAST_TO_COMPARE: usize = 3;
const OTHER: f64 = 0.25;
const OTHER_RATIO: f64 = 3.0;
/// A drift of the force is stated from this share of the largest hit on.
const LEAST_DRIFT: f64 = 0.01;
/// How much of the force is drawn after the pulse, in lengths of the force window.
const DRAWN: usize = 2;

/// The transfer function of an impact test with what a report draws of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactEstimate<I: Quantity, O: Quantity> {
    /// The transfer function; its `impact` holds the hits and the windows.
    pub function: TransferFunction<I, O>,
    /// What a report draws.
    pub traces: ImpactTraces,
}

/// The windows of a segment.
struct Windows {
    /// The window of the force without the exponential, one value a sample.
    force: Vec<f64>,
    /// The length of the force window with its taper, samples; absent where there is none.
    force_length: Option<usize>,
    /// The exponential window of both, 1 at the beginning of the segment.
    exponential: Vec<f64>,
    /// Its damping, 1/s.
    damping_per_s: f64,
}

/// The transfer function from the force of a hammer to a response: one complex value a line from 0 Hz in steps of
/// 1/segment, in units of `O` per `I`, with what is `known` beside the samples; hits in segments with lost samples are not used.
///
/// Formula: X and Y are the transforms of force and response from just before a hit on, both times exp(−σt) where there is an
/// exponential window; H1 = ΣX*Y/ΣX*X over the hits, γ² = |ΣX*Y|²/(ΣX*X·ΣY*Y). As Y(jω) of y(t)·exp(−σt) is Y(jω + σ), the
/// function is H(jω + σ). It has as many independent averages as hits of one energy would scatter by, (Σe)²/Σe² with the energies e
/// of the force.
///
/// Source: D. J. Ewins, *Modal Testing*, 2nd ed., section 3.9; ISO 7626-5; W. G. Halvorsen and D. L. Brown (1977), Impulse
/// technique for structural frequency response testing, Sound and Vibration 11(11); docs/decisions/transfer-functions.md.
///
/// # Errors
/// [`TransferError::NoHit`] where the force holds no hit, or none that can be used; [`TransferError::Estimate`] when rate or
/// length differ or a signal is silent; those of [`TransferFunction::from_lines`].
pub fn estimate_impacts<I: Quantity, O: Quantity>(
    force: &Series<I>,
    response: &Series<O>,
    config: &ImpactConfig,
    estimator: Estimator,
    known: Known<'_>,
) -> Result<ImpactEstimate<I, O>, TransferError> {
    let mut found = impacts(force, response, config, estimator, known)?;
    let copied = copy_warning(force, response);
    found.function.about.warnings.extend(copied);
    Ok(found)
}

/// As [`estimate_impacts`], without the warning that both are one signal.
pub(in crate::transfer) fn impacts<I: Quantity, O: Quantity>(
    force: &Series<I>,
    response: &Series<O>,
    config: &ImpactConfig,
    estimator: Estimator,
    known: Known<'_>,
) -> Result<ImpactEstimate<I, O>, TransferError> {
    let rate = force.rate();
    let signals = same_clock(force, response, known.lost_s)?;
    if let ExponentialWindow::Damping(found) = config.exponential
        && !(found.is_finite() && found > 0.0)
    {
        return Err(TransferError::Damping { found });
    }
    let found = Force::of(signals.force, rate);
    let (level, drift) = without_baseline(signals.response, rate);
    let signals = Signals {
        force: &found.samples,
        recorded: force.samples(),
        response: if drift > 0.0 {
            &level
        } else {
            signals.response
        },
        ..signals
    };
    require_pulses(&found)?;
    let segments = Segments::of(&signals, &found, config)?;
    let seconds = |samples: usize| rate.duration_of(samples).0;
    refuse_overdamped(config, seconds(segments.length))?;
    let (hits, used) = judged_hits(&found, &segments, rate)?;
    let left = segments.left;
    let windows = Windows::of(&signals, &found, (&segments, &used), config);
    let cut = Cut::of(&signals, (&segments, &used), &windows);
    let spectra: CrossSpectra<I, O> = cut.spectra(rate)?;
    let mut function = function_of(&spectra, estimator, rate, &cut.energies)?;
    let highest = highest(&spectra);
    function.excited = excited(&spectra, highest, config.excited_within_db);
    let test = ImpactTest {
        segment_s: seconds(segments.length),
        pretrigger_s: seconds(segments.before),
        force_window_s: windows.force_length.map(seconds),
        added_damping_per_s: windows.damping_per_s,
        left: Some(left.share),
        excited_within_db: config.excited_within_db,
        hits,
    };
    function.about.provenance.steps.push(step(&test, estimator));
    function
        .about
        .warnings
        .extend(warnings(&test, left, &found));
    let drifts = response_drifts(signals.response, drift);
    let earlier = earlier_response(used.iter().map(|i| segments.hits[*i].remains));
    (function.about.warnings).extend(drifts.into_iter().chain(earlier).map(Warning::from));
    let driven = known
        .driven
        .map(|driven| judge::driven_within(function.excited, driven, function.resolution_hz()));
    let unexcited = unexcited(&function).map(|parts| match driven {
        Some(inside) => judge::within(&parts, inside),
        None => parts,
    });
    function
        .about
        .warnings
        .extend(unexcited.and_then(judge::not_excited));
    let times: Vec<f64> = used.iter().map(|i| test.hits[*i].at_s).collect();
    let band = function.excited;
    (function.about.warnings).extend(band.and_then(|band| cut.others(band, rate, &times)));
    if test.used() > 1 {
        let weak = judge::weak_warning(&function);
        let related = spectra.relation().filter(|relation| !relation.is_shown());
        let unrelated = related.map(judge::unrelated_warning);
        function
            .about
            .warnings
            .extend(weak.into_iter().chain(unrelated));
    }
    function.excited = driven.or(function.excited);
    function.impact = Some(test);
    let traces = cut.traces(&windows, (&segments, rate), (&spectra, highest.0));
    Ok(ImpactEstimate { function, traces })
}

fn require_pulses(found: &Force) -> Result<(), TransferError> {
    if found.hits.is_empty() {
        return Err(TransferError::NoHit {
            largest: found.largest,
            noise: found.noise,
        });
    }
    if !found.is_of_pulses() {
        return Err(TransferError::NoPulses);
    }
    Ok(())
}

fn refuse_overdamped(config: &ImpactConfig, segment_s: f64) -> Result<(), TransferError> {
    let most = MOST_DAMPING / segment_s;
    match config.exponential {
        ExponentialWindow::Damping(found) if found > most => Err(TransferError::Overdamped {
            found,
            most,
            segment_s,
        }),
        _ => Ok(()),
    }
}

/// The hits with their faults, and the numbers of those that are used.
fn judged_hits(
    found: &Force,
    segments: &Segments,
    rate: SampleRate,
) -> Result<(Vec<Hit>, Vec<usize>), TransferError> {
    let seconds = |samples: usize| rate.duration_of(samples).0;
    let hits: Vec<Hit> = found
        .hits
        .iter()
        .zip(&segments.hits)
        .map(|(hit, segment)| Hit {
            at_s: seconds(hit.start()),
            peak: hit.main.peak,
            duration_s: seconds(hit.main.at.len()),
            faults: segment.faults.clone(),
        })
        .collect();
    let used: Vec<usize> = (0..hits.len()).filter(|i| hits[*i].is_used()).collect();
    if used.is_empty() {
        let first = |hit: &Hit| Some((hit.at_s, *hit.faults.first()?));
        return Err(TransferError::NoneUsable {
            faults: hits.iter().filter_map(first).collect(),
        });
    }
    Ok((hits, used))
}

fn response_drifts(response: &[f64], drift: f64) -> Option<ImpactWarning> {
    let largest = response.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    (drift > LEAST_DRIFT * largest).then(|| ImpactWarning::BaselineDrifts {
        signal: "response".into(),
        share: drift / largest,
    })
}

/// The warning about hits before which the response to an earlier one `remains`.
fn earlier_response(remains: impl Iterator<Item = f64>) -> Option<ImpactWarning> {
    let remains: Vec<f64> = remains.filter(|share| *share > MOST_BEFORE).collect();
    (!remains.is_empty()).then(|| ImpactWarning::NotDecayed {
        how: NotDecayed::Before {
            hits: remains.len(),
            share: remains.iter().copied().fold(0.0, f64::max),
        },
    })
}

/// Both signals, when they can be evaluated together.
fn same_clock<'a, I: Quantity, O: Quantity>(
    force: &'a Series<I>,
    response: &'a Series<O>,
    lost_s: &'a [[f64; 2]],
) -> Result<Signals<'a>, EstimateError> {
    let (x, y) = (force.samples(), response.samples());
    if force.rate() != response.rate() || x.len() != y.len() {
        return Err(EstimateError::Mismatch {
            left: I::NAME,
            right: O::NAME,
            what: "the rate and the number of samples",
            left_value: format!("{}, {}", force.rate(), x.len()),
            right_value: format!("{}, {}", response.rate(), y.len()),
        });
    }
    for (signal, samples) in [("the drive", x), ("the response", y)] {
        if samples.iter().all(|v| *v == samples[0]) {
            return Err(EstimateError::Silent { signal });
        }
    }
    Ok(Signals {
        force: x,
        recorded: x,
        response: y,
        rate: force.rate(),
        lost_s,
    })
}

impl Windows {
    fn of(
        signals: &Signals<'_>,
        found: &Force,
        (segments, used): (&Segments, &[usize]),
        config: &ImpactConfig,
    ) -> Self {
        let left = segments.left.share;
        let length = segments.length;
        let after_s = signals.rate.duration_of(length - segments.before).0;
        let damping_per_s = match config.exponential {
            ExponentialWindow::None => 0.0,
            ExponentialWindow::Damping(damping_per_s) => damping_per_s,
            ExponentialWindow::WhereNeeded if left > AT_REST => (left / AT_REST).ln() / after_s,
            ExponentialWindow::WhereNeeded => 0.0,
        };
        let step = damping_per_s / signals.rate.hz();
        let exponential = (0..length).map(|i| (-step * i as f64).exp()).collect();
        if config.force_window == ForceWindow::None {
            return Self {
                force: vec![1.0; length],
                force_length: None,
                exponential,
                damping_per_s,
            };
        }
        // One window for all: that of the longest pulse.
        let ends = used.iter().map(|i| {
            let (from, pulse) = (segments.hits[*i].from, &found.hits[*i].main);
            let limit = (ENDED.0 * pulse.peak.abs()).max(ENDED.1 * found.noise);
            let moving = |at: usize| signals.force[at].abs() > limit;
            // At rest for as long as the taper.
            let calm = pulse.at.len().max(SHORTEST_TAPER);
            let (mut end, mut at) = (pulse.at.end, pulse.at.end);
            while at < (from + length).min(end + calm) {
                if moving(at) {
                    end = at + 1;
                }
                at += 1;
            }
            (end - from, calm)
        });
        let (end, taper) = ends.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let force = (0..length).map(|i| match i.checked_sub(end) {
            None => 1.0,
            Some(past) if past < taper => 0.5 + 0.5 * (PI * past as f64 / taper as f64).cos(),
            Some(_) => 0.0,
        });
        Self {
            force: force.collect(),
            force_length: Some((end + taper).min(length)),
            exponential,
            damping_per_s,
        }
    }
}

/// The segments that are used, windowed and transformed.
struct Cut {
    force: Vec<Vec<f64>>,
    response: Vec<Vec<f64>>,
    x: Vec<Vec<Complex<f64>>>,
    y: Vec<Vec<Complex<f64>>>,
    /// The energy of the force of each.
    energies: Vec<f64>,
    length: usize,
}

impl Cut {
    fn of(
        signals: &Signals<'_>,
        (segments, used): (&Segments, &[usize]),
        windows: &Windows,
    ) -> Self {
        let length = segments.length;
        let mut plan = RealTransform::new(length);
        let mut cut = Self {
            force: Vec::new(),
            response: Vec::new(),
            x: Vec::new(),
            y: Vec::new(),
            energies: Vec::new(),
            length,
        };
        for i in used {
            let from = segments.hits[*i].from;
            // The rise of the pulse to the level of hits is not rest.
            let rest = segments.before - segments.before / 4;
            let about = match rest {
                0..SHORTEST_TAPER => 0.0,
                _ => mean(&signals.force[from..from + rest]),
            };
            let segment = &signals.force[from..from + length];
            let force: Vec<f64> = segment.iter().map(|v| v - about).collect();
            let end = from + rest.max(1);
            let earlier = i.checked_sub(1).map_or(0, |earlier| {
                let hit = segments.hits[earlier].from + segments.before;
                hit + from.saturating_sub(hit) / 2
            });
            let begin = end.saturating_sub(segments.rest).max(earlier).min(from);
            let before = mean(&signals.response[begin..end]);
            let segment = &signals.response[from..from + length];
            let response: Vec<f64> = segment.iter().map(|v| v - before).collect();
            let windowed = |samples: &[f64], window: &dyn Fn(usize) -> f64| -> Vec<f64> {
                (samples.iter().enumerate())
                    .map(|(k, v)| v * window(k) * windows.exponential[k])
                    .collect()
            };
            let x = windowed(&force, &|k| windows.force[k]);
            cut.energies.push(x.iter().map(|v| v * v).sum());
            cut.x.push(plan.forward(&x));
            cut.y.push(plan.forward(&windowed(&response, &|_| 1.0)));
            cut.force.push(force);
            cut.response.push(response);
        }
        cut
    }

    /// The mean spectra over the hits, one-sided densities over the segment.
    fn spectra<I: Quantity, O: Quantity>(
        &self,
        rate: SampleRate,
    ) -> Result<CrossSpectra<I, O>, EstimateError> {
        let lines = self.length / 2 + 1;
        let (mut xx, mut yy) = (vec![0.0; lines], vec![0.0; lines]);
        let mut xy = vec![Complex::default(); lines];
        let scale = 2.0 / (rate.hz() * self.length as f64 * self.x.len() as f64);
        for (x, y) in self.x.iter().zip(&self.y) {
            for k in 0..lines {
                xx[k] += scale * x[k].norm_sqr();
                yy[k] += scale * y[k].norm_sqr();
                xy[k] += x[k].conj() * y[k] * scale;
            }
        }
        let step_hz = rate.hz() / self.length as f64;
        let mut spectra = CrossSpectra::from_parts(xx, yy, xy, step_hz, self.x.len())?;
        spectra.effective_averages = independent(&self.energies);
        Ok(spectra)
    }

    /// The warning about hits, whose `times` in s are those of the segments, with another response than the others have.
    ///
    /// Of each hit the part of the energy of the response in the excited band that H1 of the other hits does not predict.
    fn others(&self, band: Band, rate: SampleRate, times: &[f64]) -> Option<Warning> {
        if self.x.len() < LEAST_TO_COMPARE {
            return None;
        }
        let step_hz = rate.hz() / self.length as f64;
        let lines = (band.low().0 / step_hz).ceil() as usize
            ..=((band.high().0 / step_hz) as usize).min(self.length / 2);
        let mut unpredicted = vec![0.0; self.x.len()];
        let mut energy = vec![0.0; self.x.len()];
        for k in lines {
            let xx: f64 = self.x.iter().map(|x| x[k].norm_sqr()).sum();
            let xy: Complex<f64> = (self.x.iter().zip(&self.y))
                .map(|(x, y)| x[k].conj() * y[k])
                .sum();
            for (i, (x, y)) in self.x.iter().zip(&self.y).enumerate() {
                let rest = xx - x[k].norm_sqr();
                if rest > 0.0 {
                    let by_others = (xy - x[k].conj() * y[k]) / rest;
                    unpredicted[i] += (y[k] - by_others * x[k]).norm_sqr();
                    energy[i] += y[k].norm_sqr();
                }
            }
        }
        let shares: Vec<f64> = (unpredicted.iter().zip(&energy))
            .map(|(part, all)| part / all.max(f64::MIN_POSITIVE))
            .collect();
        let usual = median(&mut shares.clone())?;
        let limit = OTHER.max(OTHER_RATIO * usual);
        let (at_s, found): (Vec<f64>, Vec<f64>) = (times.iter().zip(&shares))
            .filter(|(_, share)| **share > limit)
            .unzip();
        (!at_s.is_empty()).then(|| {
            let share = found.iter().copied().fold(0.0, f64::max);
            ScatterWarning::Scatter {
                of: Scatter::Hits { at_s, share, usual },
            }
            .into()
        })
    }

    fn traces<I: Quantity, O: Quantity>(
        &self,
        windows: &Windows,
        (segments, rate): (&Segments, SampleRate),
        (spectra, level): (&CrossSpectra<I, O>, f64),
    ) -> ImpactTraces {
        let time = |k: usize| (k as f64 - segments.before as f64) / rate.hz();
        let drawn = windows.force_length.unwrap_or(4 * segments.before) * DRAWN;
        let upto = drawn.min(self.length);
        let points = |samples: &[f64], upto: usize| -> Vec<(f64, f64)> {
            let samples = samples.iter().enumerate().take(upto);
            samples.map(|(k, v)| (time(k), *v)).collect()
        };
        let at_hit = windows.exponential.get(segments.before).copied();
        let exponential = if windows.damping_per_s > 0.0 {
            let scale = 1.0 / at_hit.unwrap_or(1.0);
            let values: Vec<f64> = windows.exponential.iter().map(|w| w * scale).collect();
            points(&values, self.length)
        } else {
            Vec::new()
        };
        let force_window = match windows.force_length {
            Some(_) => points(&windows.force, upto),
            None => Vec::new(),
        };
        let force_db = spectra
            .drive_power
            .iter()
            .enumerate()
            .skip(1)
            .map(|(k, power)| {
                let ratio = (power / level).max(1e-12);
                (k as f64 * spectra.resolution_hz, 10.0 * ratio.log10())
            });
        ImpactTraces {
            force: self.force.iter().map(|f| points(f, upto)).collect(),
            response: self
                .response
                .iter()
                .map(|r| points(r, self.length))
                .collect(),
            force_window,
            exponential,
            force_db: force_db.collect(),
        }
    }
}

/// The number of hits of one energy that scatter as much as hits of these energies.
fn independent(energies: &[f64]) -> f64 {
    let sum: f64 = energies.iter().sum();
    let squares: f64 = energies.iter().map(|e| e * e).sum();
    if squares > 0.0 {
        sum * sum / squares
    } else {
        0.0
    }
}

/// The function of the spectra. One hit has no coherence: it is 0 at every line.
fn function_of<I: Quantity, O: Quantity>(
    spectra: &CrossSpectra<I, O>,
    estimator: Estimator,
    rate: SampleRate,
    energies: &[f64],
) -> Result<TransferFunction<I, O>, TransferError> {
    let response = spectra.ratio(estimator);
    let coherence = match energies.len() {
        1 => vec![0.0; response.len()],
        _ => spectra.coherence(),
    };
    let mut function = TransferFunction::from_lines(
        response,
        coherence,
        spectra.resolution_hz,
        rate,
        estimator,
        energies.len(),
    )?;
    function.effective_averages = spectra.effective_averages;
    Ok(function)
}

/// The highest level of the force, in its unit squared per Hz, and its line: of medians of some lines, over which one line does
/// not count.
fn highest<I: Quantity, O: Quantity>(spectra: &CrossSpectra<I, O>) -> (f64, usize) {
    let medians = spectra.drive_power[1..]
        .windows(MEDIAN_LINES)
        .filter_map(|lines| median(&mut lines.to_vec()));
    let centres = (1 + MEDIAN_LINES / 2..).zip(medians);
    centres.fold((f64::MIN_POSITIVE, 1), |(highest, at), (line, level)| {
        if level > highest {
            (level, line)
        } else {
            (highest, at)
        }
    })
}

/// The lines about the `highest` level in which the force does not fall by more than `within_db` below it.
fn excited<I: Quantity, O: Quantity>(
    spectra: &CrossSpectra<I, O>,
    (level, at): (f64, usize),
    within_db: f64,
) -> Option<Band> {
    let least = level * 10f64.powf(-0.1 * within_db);
    let (below, above) = spectra.drive_power.split_at(at);
    let above = above.iter().take_while(|power| **power >= least).count();
    let below = below[1..].iter().rev();
    let below = below.take_while(|power| **power >= least).count();
    let hz = |line: usize| Hertz(line as f64 * spectra.resolution_hz);
    Band::new(hz(at - below), hz(at + above.max(1) - 1)).ok()
}

/// The lines above those that are excited.
fn unexcited<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Unexcited> {
    let whole = Band::new(Hertz(0.0), Hertz(function.highest_hz())).ok()?;
    let excited = function.excited?;
    Some(judge::outside(excited, whole, function.resolution_hz()))
}

/// What limits the test.
fn warnings(test: &ImpactTest, left: Left, found: &Force) -> Vec<Warning> {
    let hits = test.hits.iter();
    let mut warnings: Vec<Warning> = hits
        .flat_map(|hit| {
            hit.faults.iter().map(|fault| {
                Warning::from(ImpactWarning::HitNotUsed {
                    at_s: hit.at_s,
                    fault: *fault,
                })
            })
        })
        .collect();
    if test.used() < RECOMMENDED_HITS {
        warnings.push(
            FewWarning::Few {
                found: test.used(),
                recommended: RECOMMENDED_HITS,
                what: Few::Hits,
            }
            .into(),
        );
    }
    if test.added_damping_per_s > 0.0 {
        warnings.push(
            ImpactWarning::NotDecayed {
                how: NotDecayed::Window {
                    damping_per_s: test.added_damping_per_s,
                    left: left.share,
                },
            }
            .into(),
        );
    } else if left.share > AT_REST {
        warnings.push(
            ImpactWarning::NotDecayed {
                how: NotDecayed::End {
                    left: left.share,
                    octave_hz: left.octave_hz,
                    segment_s: test.segment_s,
                },
            }
            .into(),
        );
    }
    if found.drift > LEAST_DRIFT * found.largest {
        warnings.push(
            ImpactWarning::BaselineDrifts {
                signal: "force".into(),
                share: found.drift / found.largest,
            }
            .into(),
        );
    }
    if polarity(found) < 0.0 {
        let used = test.hits.iter().filter(|hit| hit.is_used());
        let peak = used.map(|hit| hit.peak).fold(0.0, f64::min);
        warnings.push(
            RecordingWarning::Sign {
                of: ReversedSign::Hits { peak },
            }
            .into(),
        );
    }
    warnings
}

/// The warning that both are one signal. What else is said of a pair holds for drives that last.
fn copy_warning<I: Quantity, O: Quantity>(
    force: &Series<I>,
    response: &Series<O>,
) -> Option<Warning> {
    let copy = copied(force.samples(), response.samples())?;
    let copied = SignalWarning::Channel {
        channel: O::NAME.into(),
        fault: ChannelFault::Copied {
            of: I::NAME.into(),
            factor: copy.factor,
            delay_s: copy.later as f64 / force.rate().hz(),
        },
    };
    Some(copied.into())
}

/// What was done, for the provenance.
fn step(test: &ImpactTest, estimator: Estimator) -> String {
    let force = match test.force_window_s {
        Some(length_s) => format!("force window of {:.2} ms", length_s * 1e3),
        None => "no force window".into(),
    };
    let exponential = if test.added_damping_per_s > 0.0 {
        format!(
            "exponential window of force and response with an added damping of {:.4} 1/s",
            test.added_damping_per_s
        )
    } else {
        "no exponential window".into()
    };
    format!(
        "transfer function {estimator} of {} of {} hits, segments of {:.4} s from {:.2} ms before each, {force}, {exponential}, \
            excited where the force is within {} dB of its highest level",
        test.used(),
        test.hits.len(),
        test.segment_s,
        test.pretrigger_s * 1e3,
        test.excited_within_db
    )
}
