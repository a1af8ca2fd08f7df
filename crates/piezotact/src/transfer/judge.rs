//! Measurement faults detected in a transfer function: swapped, delayed or inverted channels, unresolved resonances, and
//! lines that were not excited.

use crate::transfer::TransferWarning;
use num_complex::Complex;

use super::TransferFunction;
use super::related::{Delay, delay_of_signals};
use crate::quantity::{Band, Hertz, Quantity};
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

/// Whether a warning says that the two signals are out of step.
fn out_of_step(warning: &Warning) -> bool {
    matches!(
        warning.kind(),
        Some(
            TransferWarning::Unrelated { .. }
                | TransferWarning::Acausal { .. }
                | TransferWarning::LateResponse { .. }
        )
    )
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

/// The warning about those parts of the unexcited `bands` that lie in the excited band `inside`.
pub(super) fn not_driven_within(bands: &[Band], inside: Band) -> Option<Warning> {
    let bands: Vec<Band> = bands
        .iter()
        .filter_map(|band| band.common(inside))
        .collect();
    let missing: f64 = bands.iter().map(|b| b.high().0 - b.low().0).sum();
    let share = missing / (inside.high().0 - inside.low().0);
    (!bands.is_empty()).then(|| Warning::from(TransferWarning::NotExcited { bands, share }))
}

/// The runs of lines within the excited band that are neither excited nor coherent with the drive.
pub(super) fn gaps<I: Quantity, O: Quantity>(
    excited: &[bool],
    function: &TransferFunction<I, O>,
) -> Option<Warning> {
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
    (missing > 0).then(|| {
        Warning::from(TransferWarning::NotExcited {
            bands: runs.into_iter().filter_map(band).collect(),
            share: missing as f64 / lines as f64,
        })
    })
}

/// A excited band of no more lines than these is that of a tone.
const TONE_LINES: f64 = 8.0;
/// Coherence below this on most excited lines: less than half of the response comes from the drive.
const HALF: f64 = 0.5;

/// The warning that almost all of the spectrum is not excited, for a drive that is a tone.
pub(super) fn tone<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Warning> {
    let excited = function.excited?;
    let whole = Band::new(Hertz(0.0), Hertz(function.highest_hz())).ok()?;
    let lines = (excited.high().0 - excited.low().0) / function.resolution_hz;
    (lines <= TONE_LINES)
        .then(|| outside(excited, whole, function.resolution_hz))
        .flatten()
}

/// The warning that on most excited lines less than half of the response comes from the drive: related, but only weakly.
pub(super) fn weak<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Option<Warning> {
    let warning = function.low_coherence(function.excited?, HALF);
    warning.filter(|warning| matches!(warning.kind(), Some(TransferWarning::LowCoherence { share, .. }) if share > 0.5))
}

/// The warning about the part of the band `asked` outside `excited` by more than one line spacing.
pub(super) fn outside(excited: Band, asked: Band, resolution_hz: f64) -> Option<Warning> {
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
    (!bands.is_empty()).then(|| {
        Warning::from(TransferWarning::NotExcited {
            bands,
            share: missing / (high - low),
        })
    })
}

/// The warning about channels that are out of step by `delay`: a response that is late by a share of the segment, or one that
/// comes before its drive by more than may be its uncertainty.
fn out_of_step_by(delay: Delay, segment_s: f64) -> Option<Warning> {
    let Delay { delay_s, reach_s } = delay;
    if delay_s - reach_s > LATE * segment_s {
        return Some(Warning::from(TransferWarning::LateResponse {
            delay_s,
            segment_s,
            reach_s,
        }));
    }
    (delay_s < -reach_s).then_some(Warning::from(TransferWarning::Acausal {
        lead_s: -delay_s,
        reach_s,
    }))
}

/// The warning about channels that are out of step, as far as lines show it.
pub(super) fn step_of_lines<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Warning> {
    out_of_step_by(function.delay()?, 1.0 / function.resolution_hz)
}

/// The resonance with the fewest lines within its half-power bandwidth, when they are too few.
pub(super) fn unresolved<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Warning> {
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
    narrowest.map(|(at_hz, lines)| {
        Warning::from(TransferWarning::UnresolvedResonance {
            at_hz,
            lines,
            resolution_hz: function.resolution_hz,
        })
    })
}

/// From a force to an acceleration, where the force takes power out of a passive finger: the sign of one is reversed.
///
/// Formula: Σ γ²·Re(H/iω)·|H/iω| < 0 over the excited lines: the power that the force puts into what moves under it.
pub(super) fn inverted<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Warning> {
    // Late or early signals turn the phases, and nothing follows from them.
    if function.about.warnings.iter().any(out_of_step) {
        return None;
    }
    let (mut net, mut all) = (0.0, 0.0);
    for (line, hz) in function
        .lines_in(function.excited?)
        .filter(|(_, hz)| *hz > 0.0)
    {
        let mobility = function.response[line] / Complex::new(0.0, std::f64::consts::TAU * hz);
        let weight = function.coherence[line].clamp(0.0, 1.0) * mobility.norm();
        net += weight * mobility.re;
        all += weight * mobility.norm();
    }
    (net < -0.2 * all).then_some(Warning::from(TransferWarning::PolarityInverted))
}

/// Checks a delay found from lines against that of the whole signals, which does not depend on the segment length, when
/// the lines are unrelated or out of step.
pub(super) fn timing<I: Quantity, O: Quantity>(
    function: &mut TransferFunction<I, O>,
    drive: &Series<I>,
    response: &Series<O>,
) {
    if !function.about.warnings.iter().any(out_of_step) {
        return;
    }
    let whole = function
        .excited
        .and_then(|band| delay_of_signals(drive.samples(), response.samples(), drive.rate(), band));
    let unrelated = function
        .about
        .warnings
        .iter()
        .any(|warning| matches!(warning.kind(), Some(TransferWarning::Unrelated { .. })));
    match (whole, function.delay()) {
        // No lag stands out: there is none to speak of.
        (None, _) => function.about.warnings.retain(|warning| {
            !out_of_step(warning)
                || matches!(warning.kind(), Some(TransferWarning::Unrelated { .. }))
        }),
        // Lines resolve a delay within their segment better than the signals do, which may be of few frequencies.
        (Some(whole), Some(of_lines)) if !unrelated && whole.agrees(&of_lines) => {}
        (Some(whole), _) => {
            function
                .about
                .warnings
                .retain(|warning| !out_of_step(warning));
            let segment_s = 1.0 / function.resolution_hz;
            function
                .about
                .warnings
                .extend(out_of_step_by(whole, segment_s));
        }
    }
}
