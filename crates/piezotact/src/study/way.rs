//! What freely moved strokes say along the way.

use super::take::FASTEST_M_S;
use super::{AnalysedRecording, Group, StudyError};
use crate::compare::{SpatialPeriod, Travelled, along_the_way, compare_periods};
use crate::criterion::Outcome;
use crate::feature::{Vibrations, vibrations};
use crate::quantity::{Hertz, Seconds};
use crate::recording::Touch;
use crate::stroke::{Signals, Way, ways};

/// Strokes whose speeds differ by more than this share say more along the way than in time.
const UNEVEN: f64 = 0.1;

/// The motion may have been recorded so much later than the vibration, or earlier, s: a camera has such delays.
const LATE_S: [f64; 6] = [-0.1, -0.05, -0.02, 0.02, 0.05, 0.1];

/// Adds to groups of one sample what their strokes say along the way, where the motion was measured and no machine held it at one speed.
pub(super) fn add(takes: &[AnalysedRecording], groups: &mut [Group]) -> Result<(), StudyError> {
    for group in &mut *groups {
        let sample = |place: &usize| &takes[*place].condition().sample;
        let mut others = group.takes.iter().map(sample);
        let first = others.next();
        if others.any(|other| Some(other) != first) {
            continue;
        }
        let moved: Vec<&AnalysedRecording> = (group.takes.iter())
            .map(|place| &takes[*place])
            .filter(|take| take.segmentation.roles.motion.is_some() && take.sections == 1)
            .collect();
        if !are_uneven(&moved) {
            continue;
        }
        let vibrations = moved.iter().map(|take| filtered(take));
        let vibrations: Vec<Vibrations> = vibrations.collect::<Result<_, _>>()?;
        let (Some(first), Some(unit)) = (moved.first(), vibrations.first()) else {
            continue;
        };
        let rate = first.recording.rate();
        let lowest = first.analysis.as_ref().map(|a| a.config.passes_from());
        let lowest = lowest.unwrap_or(Hertz(0.0));
        let found = |late: Seconds| {
            let numbered = moved.iter().zip(&vibrations).enumerate();
            let parts: Vec<Travelled<'_>> = numbered
                .filter(|(_, (take, _))| take.recording.rate() == rate)
                .flat_map(|(recording, (take, vibrations))| {
                    travelled_of((recording, late), take, vibrations)
                })
                .collect();
            along_the_way(&parts, rate, lowest, &unit.unit)
        };
        group.way = found(Seconds(0.0));
        let period = group.way.as_mut().and_then(|way| way.period.as_mut());
        if let Some(period) = period.filter(|period| period.outcome == Outcome::Met) {
            let others = LATE_S.iter().filter_map(|late_s| {
                let way = found(Seconds(*late_s))?;
                Some((*late_s, way.period?.prominence_db))
            });
            period.require_one_time(others);
        }
    }
    let mut periods: Vec<(&str, &mut SpatialPeriod)> = Vec::new();
    for group in groups {
        let first = group.takes.first();
        let sample = first.and_then(|place| takes[*place].condition().sample.as_deref());
        let period = group.way.as_mut().and_then(|way| way.period.as_mut());
        periods.extend(sample.zip(period));
    }
    let mut samples = periods.iter().map(|(sample, _)| *sample);
    let first = samples.next();
    if samples.any(|sample| Some(sample) != first) {
        compare_periods(&mut periods);
    }
    Ok(())
}

/// The parts of the strokes of a recording that move one way; none where the motion was not measured.
pub(super) fn travelled_of<'v>(
    (recording, late): (usize, Seconds),
    take: &AnalysedRecording,
    vibrations: &'v Vibrations,
) -> Vec<Travelled<'v>> {
    let Ok(signals) = Signals::of(&take.recording, &take.segmentation.roles) else {
        return Vec::new();
    };
    let strokes = take.segmentation.strokes.iter();
    let ways = strokes.flat_map(|stroke| ways(&signals, stroke.steady, late));
    let ways = ways.filter(|way| way.speed_m_s(signals.rate) <= FASTEST_M_S);
    let part = |way: Way| Travelled {
        recording,
        vibration: (vibrations.channels.iter())
            .map(|channel| way.part.of(channel.as_slice()))
            .collect(),
        way,
    };
    ways.map(part).collect()
}

/// Whether a hand moved, or strokes differ in speed.
fn are_uneven(takes: &[&AnalysedRecording]) -> bool {
    let mut by_hand = takes.iter();
    if by_hand.any(|take| take.condition().touch == Some(Touch::Active)) {
        return true;
    }
    let analyses = takes.iter().filter_map(|take| take.analysis.as_ref());
    let strokes = analyses.flat_map(|analysis| &analysis.strokes);
    let speeds = strokes.filter_map(|stroke| Some(stroke.speed_m_s?.mean));
    let (low, high) = speeds.fold((f64::MAX, 0.0f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    high > (1.0 + UNEVEN) * low
}

fn filtered(take: &AnalysedRecording) -> Result<Vibrations, StudyError> {
    let high_pass = take.analysis.as_ref().and_then(|a| a.config.high_pass);
    vibrations(&take.recording, &take.segmentation, high_pass).map_err(|error| take.failed(error))
}
