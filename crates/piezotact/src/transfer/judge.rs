//! What a transfer function gives away of how it was measured: channels that are swapped, late or inverted, resonances
//! that the segments do not resolve, lines that nothing drove.

use num_complex::Complex;
use rustfft::FftPlanner;

use super::TransferFunction;
use crate::doubt::Doubt;
use crate::fourier::RealTransform;
use crate::quantity::{Band, Hertz, Quantity};
use crate::series::{Series, rms};
use crate::spectrum::RECOMMENDED_SEGMENTS;

/// Fewer lines than this within the half-power bandwidth of a resonance leave a bias of more than 2 %
/// (⅓ of the squared ratio, with the resolution of a Hann window of 1.44 lines).
const LINES_OF_A_RESONANCE: f64 = 6.0;
/// A peak that stands out by less than this is none, dB.
const PROMINENT_DB: f64 = 6.0;
/// Lines below this coherence say nothing of a resonance.
const BELIEVED: f64 = 0.5;
/// A response later than this share of a segment is underestimated.
pub(super) const LATE: f64 = 0.05;
/// How far a cross-correlation stands out of its rms when two signals are one: noise reaches 5 to 6.
const RELATED: f64 = 9.0;

/// Whether a doubt says that the two signals are out of step.
fn out_of_step(doubt: &Doubt) -> bool {
    matches!(
        doubt,
        Doubt::Unrelated { .. } | Doubt::Acausal { .. } | Doubt::LateResponse { .. }
    )
}

/// From the first to the last line that is driven.
pub(super) fn driven_band(driven: &[bool], resolution_hz: f64) -> Option<Band> {
    let hz = |line: usize| Hertz(line as f64 * resolution_hz);
    let (first, last) = (
        driven.iter().position(|d| *d)?,
        driven.iter().rposition(|d| *d)?,
    );
    Band::new(hz(first), hz(last)).ok()
}

/// The runs of lines within the driven band that are not driven and answer nothing.
pub(super) fn gaps<I: Quantity, O: Quantity>(
    driven: &[bool],
    function: &TransferFunction<I, O>,
) -> Option<Doubt> {
    let inside = function.driven?;
    let (mut runs, mut missing, mut lines) = (Vec::<[usize; 2]>::new(), 0, 0);
    for (line, hz) in function.lines_in(inside) {
        lines += 1;
        // The window's leakage alone lets neighbours of 0 Hz and of single lines through.
        if hz <= 0.0 || driven[line] || function.coherence[line] > BELIEVED {
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
    (missing > 0).then(|| Doubt::NotDriven {
        bands: runs.into_iter().filter_map(band).collect(),
        share: missing as f64 / lines as f64,
    })
}

/// What of `asked` lies outside of `driven` by more than a line's width.
pub(super) fn outside(driven: Band, asked: Band, resolution_hz: f64) -> Option<Doubt> {
    let (low, high) = (asked.low().0, asked.high().0);
    let parts = [
        (low, driven.low().0.min(high)),
        (driven.high().0.max(low), high),
    ];
    let bands: Vec<Band> = parts
        .into_iter()
        .filter(|(from, to)| to - from > 2.0 * resolution_hz)
        .filter_map(|(from, to)| Band::new(Hertz(from), Hertz(to)).ok())
        .collect();
    let missing: f64 = bands.iter().map(|b| b.high().0 - b.low().0).sum();
    (!bands.is_empty()).then(|| Doubt::NotDriven {
        bands,
        share: missing / (high - low),
    })
}

/// The envelope of the impulse response and the step of its samples, s: positive frequencies only, those that are driven
/// and answer, with a Hann taper over them so that their ends do not ring.
fn envelope<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<(Vec<f64>, f64, f64)> {
    let n = 2 * (function.response.len() - 1);
    let band = function
        .driven
        .or_else(|| Band::new(Hertz(0.0), Hertz(function.highest_hz())).ok())?;
    let (low, width) = (band.low().0, band.high().0 - band.low().0);
    let mut bins = vec![Complex::default(); n];
    for (line, hz) in function.lines_in(band) {
        let place = (hz - low) / width;
        let taper = 0.5 - 0.5 * (std::f64::consts::TAU * place).cos();
        bins[line] = function.response[line] * (function.coherence[line].clamp(0.0, 1.0) * taper);
    }
    FftPlanner::new().plan_fft_inverse(n).process(&mut bins);
    let step_s = 1.0 / (n as f64 * function.resolution_hz);
    Some((bins.iter().map(|h| h.norm()).collect(), step_s, width))
}

/// The answer comes before the drive: the envelope of the impulse response is largest at a negative time, further from
/// 0 than half of what the band resolves.
pub(super) fn acausal<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Doubt> {
    let (envelope, step_s, width_hz) = envelope(function)?;
    let largest = (0..envelope.len()).max_by(|a, b| envelope[*a].total_cmp(&envelope[*b]))?;
    let lead_s = (envelope.len() - largest) as f64 * step_s;
    let early = largest > envelope.len() / 2 && lead_s > 0.5 / width_hz;
    early.then_some(Doubt::Acausal { lead_s })
}

/// The resonance with the fewest lines within its half-power bandwidth, when they are too few.
pub(super) fn unresolved<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Doubt> {
    // A peak of few averages is a matter of chance.
    if function.averages < RECOMMENDED_SEGMENTS {
        return None;
    }
    let driven = function.driven?;
    let lines: Vec<(usize, f64)> = function
        .lines_in(driven)
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
        if peak < levels[at - 1] || peak <= levels[at + 1] || function.coherence[line] < BELIEVED {
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
    narrowest.map(|(at_hz, lines)| Doubt::UnresolvedResonance {
        at_hz,
        lines,
        resolution_hz: function.resolution_hz,
    })
}

/// From a force to an acceleration, where the force takes power out of a passive finger: the sign of one is reversed.
///
/// Formula: Σ γ²·Re(H/iω)·|H/iω| < 0 over the driven lines: the power that the force puts into what moves under it.
pub(super) fn inverted<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> Option<Doubt> {
    // Late or early signals turn the phases, and nothing follows from them.
    if function.doubts.iter().any(out_of_step) {
        return None;
    }
    let (mut net, mut all) = (0.0, 0.0);
    for (line, hz) in function
        .lines_in(function.driven?)
        .filter(|(_, hz)| *hz > 0.0)
    {
        let mobility = function.response[line] / Complex::new(0.0, std::f64::consts::TAU * hz);
        let weight = function.coherence[line].clamp(0.0, 1.0) * mobility.norm();
        net += weight * mobility.re;
        all += weight * mobility.norm();
    }
    (net < -0.2 * all).then_some(Doubt::PolarityInverted)
}

/// What the whole signals say where the segments hold no common event: how late the response is in truth.
pub(super) fn timing<I: Quantity, O: Quantity>(
    function: &mut TransferFunction<I, O>,
    drive: &Series<I>,
    response: &Series<O>,
) {
    if !function.doubts.iter().any(out_of_step) {
        return;
    }
    let Some(lag) = common_lag(drive.samples(), response.samples()) else {
        return;
    };
    let (delay_s, segment_s) = (lag as f64 / drive.rate().hz(), 1.0 / function.resolution_hz);
    let late = delay_s > LATE * segment_s;
    if late || delay_s < -0.5 * segment_s {
        function.doubts.retain(|doubt| !out_of_step(doubt));
        function.doubts.push(if late {
            Doubt::LateResponse { delay_s, segment_s }
        } else {
            Doubt::Acausal { lead_s: -delay_s }
        });
    }
}

/// By how many samples `response` follows `drive`, where their correlation stands out clearly.
fn common_lag(drive: &[f64], response: &[f64]) -> Option<i64> {
    let n = (2 * drive.len()).next_power_of_two();
    let mut plan = RealTransform::new(n);
    let (x, y) = (plan.forward(drive), plan.forward(response));
    let correlation = plan.inverse(x.iter().zip(&y).map(|(x, y)| x.conj() * y).collect());
    let largest = (0..n).max_by(|a, b| correlation[*a].abs().total_cmp(&correlation[*b].abs()))?;
    let stands_out = correlation[largest].abs() > RELATED * rms(&correlation);
    let lag = if largest < n / 2 {
        largest as i64
    } else {
        largest as i64 - n as i64
    };
    stands_out.then_some(lag)
}
