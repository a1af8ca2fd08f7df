//! Measurement faults detected in a transfer function: swapped, delayed or inverted channels, unresolved resonances, and
//! lines that were not excited.

use crate::recording::{RecordingWarning, ReversedSign};
use crate::transfer::TransferWarning;
use num_complex::Complex;

use super::related::{Delay, Relation, delay_of_signals};
use super::{CrossSpectra, TransferFunction};
use crate::quantity::{Band, Hertz, Quantity, Unit};
use crate::series::Series;
use crate::spectrum::RECOMMENDED_SEGMENTS;
use crate::warning::Warning;

/// Fewer lines than this within the half-power bandwidth of a resonance leave a bias of more than 2 %
/// (⅓ of the squared ratio, with the resolution of a Hann window of 1.44 lines).
const LINES_OF_A_RESONANCE: f64 = 6.0;
/// The least prominence of a peak, dB.
const PROMINENT_DB: f64 = 6.0;
/// The least coherence of lines in which a resonance is looked for.
const MIN_RESONANCE_COHERENCE: f64 = 0.5;
/// A response delayed by more than this share of a segment is underestimated.
const LATE: f64 = 0.05;

/// Parts of a band that were not excited, and their share of it, 0–1.
pub(super) type Unexcited = (Vec<Band>, f64);

/// What an estimate shows of its lines; its warnings follow from it.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Gaps in the drive, and what lies beside a tone.
    gaps: Vec<Unexcited>,
    /// Drive and response are not shown to be related.
    unrelated: Option<Relation>,
    /// The band on most of whose lines less than half of the response comes from the drive.
    weak: Option<Band>,
    /// The delay by which the channels are out of step.
    step: Option<Delay>,
    /// The resonance with the fewest lines, Hz, and their number.
    unresolved: Option<(f64, f64)>,
    /// The sign of one channel is reversed.
    inverted: bool,
}

impl Found {
    /// What the lines of `function`, estimated from `spectra`, show.
    pub(super) fn of<I: Quantity, O: Quantity>(
        spectra: &CrossSpectra<I, O>,
        function: &TransferFunction<I, O>,
    ) -> Self {
        let gaps = gaps(&spectra.excited(), function);
        let mut found = Self {
            gaps: gaps.into_iter().chain(tone(function)).collect(),
            unrelated: spectra.relation().filter(|found| !found.is_shown()),
            ..Self::default()
        };
        // The delay between two unrelated signals is the position of a random peak: it is not looked for.
        if found.unrelated.is_none() {
            let from_force = I::UNIT == Unit::Newton && O::UNIT == Unit::MetrePerSecondSquared;
            found.weak = weak(function);
            found.step = step_of_lines(function);
            found.unresolved = unresolved(function);
            found.inverted = from_force && found.is_inverted(function);
        }
        found
    }

    /// Whether the two channels are unrelated, or out of step.
    fn is_out_of_step(&self) -> bool {
        self.unrelated.is_some() || self.step.is_some()
    }

    /// Whether the sign of one channel of `function`, from a force to the acceleration of a passive finger, is reversed. Late or
    /// early signals turn the phases, and nothing follows from them.
    pub(super) fn is_inverted<I: Quantity, O: Quantity>(
        &self,
        function: &TransferFunction<I, O>,
    ) -> bool {
        !self.is_out_of_step() && takes_power_out(function)
    }

    /// Leaves out gaps beyond the excited band `inside`.
    pub(super) fn narrow(&mut self, inside: Band) {
        for gap in &mut self.gaps {
            *gap = within(gap, inside);
        }
    }

    /// The warnings about `function`.
    pub(super) fn warnings<I: Quantity, O: Quantity>(
        &self,
        function: &TransferFunction<I, O>,
    ) -> Vec<Warning> {
        let gaps = self.gaps.iter().cloned().filter_map(not_excited);
        let resolution_hz = function.resolution_hz;
        let unresolved = self.unresolved.map(|(at_hz, lines)| {
            TransferWarning::UnresolvedResonance {
                at_hz,
                lines,
                resolution_hz,
            }
            .into()
        });
        let of_lines = [
            self.unrelated.map(unrelated_warning),
            self.weak
                .and_then(|band| function.low_coherence(band, HALF)),
            self.step
                .map(|delay| step_warning(delay, 1.0 / resolution_hz)),
            unresolved,
            self.inverted.then(|| {
                RecordingWarning::Sign {
                    of: ReversedSign::Power,
                }
                .into()
            }),
        ];
        gaps.chain(of_lines.into_iter().flatten()).collect()
    }
}

/// The warning that a drive and its response are not shown to be related.
pub(super) fn unrelated_warning(relation: Relation) -> Warning {
    TransferWarning::Unrelated {
        coherence: relation.coherence,
        limit: relation.limit,
        averages: relation.averages,
    }
    .into()
}

/// A line this far below the strongest of its neighbours is leakage from them: 20 dB, and the number of neighbours.
const LEAKS: (f64, usize) = (1e-2, 4);

/// The band from the first to the last excited line of a drive with the spectrum `power`. The line at 0 Hz (the mean was
/// removed) and leakage below the first prominent line do not count as excited.
pub(super) fn excited_band(excited: &[bool], power: &[f64], resolution_hz: f64) -> Option<Band> {
    let hz = |line: usize| Hertz(line as f64 * resolution_hz);
    let stands_out = |line: &usize| {
        let above = power.iter().skip(line + 1).take(LEAKS.1);
        excited[*line] && power[*line] >= LEAKS.0 * above.copied().fold(0.0, f64::max)
    };
    let first = (1..excited.len()).find(stands_out);
    let first = first.or_else(|| excited.iter().position(|d| *d))?;
    let last = excited.iter().rposition(|d| *d)?;
    Band::new(hz(first), hz(last)).ok()
}

/// The excited band of a drive whose band `driven` is known, where `found` was found: lines outside count as not excited, even if the
/// ends of a drive have power there.
pub(super) fn driven_within(found: Option<Band>, driven: Band, resolution_hz: f64) -> Band {
    // The lowest line of a band lies up to one line spacing above its lower end.
    let low = |found: Band| match found.low().0 - driven.low().0 <= resolution_hz {
        true => Band::new(driven.low(), found.high()).unwrap_or(found),
        false => found,
    };
    let inside = found.and_then(|found| low(found).common(driven));
    inside.unwrap_or(driven)
}

/// Those unexcited parts that lie in the excited band `inside`.
pub(super) fn within((bands, _): &Unexcited, inside: Band) -> Unexcited {
    let bands: Vec<Band> = bands
        .iter()
        .filter_map(|band| band.common(inside))
        .collect();
    let missing: f64 = bands.iter().map(|b| b.high().0 - b.low().0).sum();
    let share = missing / (inside.high().0 - inside.low().0);
    (bands, share)
}

/// The runs of lines within the excited band that are neither excited nor coherent with the drive.
fn gaps<I: Quantity, O: Quantity>(
    excited: &[bool],
    function: &TransferFunction<I, O>,
) -> Option<Unexcited> {
    let inside = function.excited?;
    let (mut runs, mut missing, mut lines) = (Vec::<[usize; 2]>::new(), 0, 0);
    for (line, hz) in function.lines_in(inside) {
        lines += 1;
        // The window's leakage alone lets neighbours of 0 Hz and of single lines through.
        if hz <= 0.0 || excited[line] || function.coherence[line] > MIN_RESONANCE_COHERENCE {
            continue;
        }
        missing += 1;
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == line => *last = line,
            _ => runs.push([line, line]),
        }
    }
    let band = |[first, last]: [usize; 2]| {
        let step = function.resolution_hz;
        Band::new(
            Hertz((first as f64 - 0.5) * step),
            Hertz((last as f64 + 0.5) * step),
        )
        .ok()
    };
    let bands = runs.into_iter().filter_map(band).collect();
    (missing > 0).then_some((bands, missing as f64 / lines as f64))
}

/// A excited band of no more lines than these is that of a tone.
const TONE_LINES: f64 = 8.0;
/// Coherence below this on most excited lines: less than half of the response comes from the drive.
const HALF: f64 = 0.5;

/// What is not excited of the spectrum, for a drive that is a tone: almost all of it.
fn tone<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Unexcited> {
    let excited = function.excited?;
    let whole = Band::new(Hertz(0.0), Hertz(function.highest_hz())).ok()?;
    let lines = (excited.high().0 - excited.low().0) / function.resolution_hz;
    (lines <= TONE_LINES).then(|| outside(excited, whole, function.resolution_hz))
}

/// The excited band, where on most of its lines less than half of the response comes from the drive: related, but only weakly.
fn weak<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Band> {
    let excited = function.excited.filter(|_| function.has_coherence())?;
    (function.low_coherence_share(excited, HALF) > 0.5).then_some(excited)
}

/// The warning that a response comes only weakly from its drive.
pub(super) fn weak_warning<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Warning> {
    function.low_coherence(weak(function)?, HALF)
}

/// The parts of the band `asked` outside `excited` by more than one line spacing, and their share of it.
pub(super) fn outside(excited: Band, asked: Band, resolution_hz: f64) -> Unexcited {
    let (low, high) = (asked.low().0, asked.high().0);
    let parts = [
        (low, excited.low().0.min(high)),
        (excited.high().0.max(low), high),
    ];
    let bands: Vec<Band> = parts
        .into_iter()
        .filter(|(from, to)| to - from > 2.0 * resolution_hz)
        .filter_map(|(from, to)| Band::new(Hertz(from), Hertz(to)).ok())
        .collect();
    let missing: f64 = bands.iter().map(|b| b.high().0 - b.low().0).sum();
    let share = match bands.is_empty() {
        true => 0.0,
        false => missing / (high - low),
    };
    (bands, share)
}

/// The warning that `bands`, a `share` of what was asked for, were not excited; `None` without bands.
pub(super) fn not_excited((bands, share): Unexcited) -> Option<Warning> {
    (!bands.is_empty()).then(|| TransferWarning::NotExcited { bands, share }.into())
}

/// Whether a response is late by a share of the segment.
fn is_late(delay: Delay, segment_s: f64) -> bool {
    delay.delay_s - delay.ci_half_width_s > LATE * segment_s
}

/// `delay` where channels are out of step by it: a response is late, or comes before its drive by more than may be its
/// uncertainty.
fn out_of_step(delay: Delay, segment_s: f64) -> Option<Delay> {
    (is_late(delay, segment_s) || delay.is_early()).then_some(delay)
}

/// The warning about channels that are out of step by `delay`.
fn step_warning(delay: Delay, segment_s: f64) -> Warning {
    let Delay {
        delay_s,
        ci_half_width_s,
    } = delay;
    match is_late(delay, segment_s) {
        true => TransferWarning::LateResponse {
            delay_s,
            segment_s,
            ci_half_width_s,
        }
        .into(),
        false => delay.acausal(),
    }
}

/// By how much channels are out of step, as far as lines show it.
fn step_of_lines<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Delay> {
    out_of_step(function.delay()?, 1.0 / function.resolution_hz)
}

/// The resonance with the fewest lines within its half-power bandwidth, Hz, and how many these are, when they are too few.
fn unresolved<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<(f64, f64)> {
    // A peak of few averages is a matter of chance.
    if function.averages < RECOMMENDED_SEGMENTS {
        return None;
    }
    let excited = function.excited?;
    let lines: Vec<(usize, f64)> = function
        .lines_in(excited)
        .filter(|(_, hz)| *hz > 0.0)
        .collect();
    let level = |line: usize| {
        20.0 * function.response[line]
            .norm()
            .max(f64::MIN_POSITIVE)
            .log10()
    };
    let levels: Vec<f64> = lines.iter().map(|(line, _)| level(*line)).collect();
    let mut narrowest: Option<(f64, f64)> = None;
    for at in 1..levels.len().saturating_sub(1) {
        let peak = levels[at];
        let line = lines[at].0;
        if peak < levels[at - 1]
            || peak <= levels[at + 1]
            || function.coherence[line] < MIN_RESONANCE_COHERENCE
        {
            continue;
        }
        let below = |depth_db: f64, side: &mut dyn Iterator<Item = usize>| {
            let mut previous = peak;
            for (steps, k) in side.enumerate() {
                if levels[k] > peak {
                    return None;
                }
                if levels[k] <= peak - depth_db {
                    // Between two lines, linearly in dB.
                    let part = (previous - (peak - depth_db)) / (previous - levels[k]);
                    return Some(steps as f64 + part);
                }
                previous = levels[k];
            }
            None
        };
        let prominent = below(PROMINENT_DB, &mut (0..at).rev()).is_some()
            && below(PROMINENT_DB, &mut (at + 1..levels.len())).is_some();
        let width = below(3.0103, &mut (0..at).rev())
            .zip(below(3.0103, &mut (at + 1..levels.len())))
            .map(|(left, right)| left + right);
        if let Some(width) = width.filter(|width| prominent && *width < LINES_OF_A_RESONANCE)
            && narrowest.is_none_or(|(_, least)| width < least)
        {
            narrowest = Some((lines[at].1, width));
        }
    }
    narrowest
}

/// Whether, from a force to an acceleration, the force takes power out of a passive finger: the sign of one is reversed.
///
/// Formula: Σ γ²·Re(H/iω)·|H/iω| < 0 over the excited lines: the power that the force puts into what moves under it.
fn takes_power_out<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> bool {
    let Some(excited) = function.excited else {
        return false;
    };
    let (mut net, mut all) = (0.0, 0.0);
    for (line, hz) in function.lines_in(excited).filter(|(_, hz)| *hz > 0.0) {
        let mobility = function.response[line] / Complex::new(0.0, std::f64::consts::TAU * hz);
        let weight = function.coherence[line].clamp(0.0, 1.0) * mobility.norm();
        net += weight * mobility.re;
        all += weight * mobility.norm();
    }
    net < -0.2 * all
}

/// Checks a delay found from lines against that of the whole signals, which does not depend on the segment length, when
/// the lines are unrelated or out of step.
pub(super) fn timing<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    found: &mut Found,
    drive: &Series<I>,
    response: &Series<O>,
) {
    if !found.is_out_of_step() {
        return;
    }
    let whole = function
        .excited
        .and_then(|band| delay_of_signals(drive.samples(), response.samples(), drive.rate(), band));
    let is_related = found.unrelated.is_none();
    match (whole, function.delay()) {
        // No lag stands out: there is none to speak of.
        (None, _) => found.step = None,
        // Lines resolve a delay within their segment better than the signals do, which may be of few frequencies.
        (Some(whole), Some(of_lines)) if is_related && whole.agrees(&of_lines) => {}
        (Some(whole), _) => {
            found.unrelated = None;
            found.step = out_of_step(whole, 1.0 / function.resolution_hz);
        }
    }
}
