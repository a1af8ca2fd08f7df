//! What freely moved strokes say along the way.

use super::{AnalysedRecording, Group, StudyError};
use crate::compare::{SpatialPeriod, Travelled, along_the_way, compare_periods};
use crate::feature::{Vibrations, vibrations};
use crate::quantity::Hertz;
use crate::recording::Touch;
use crate::stroke::{Signals, ways};

/// Adds to groups of one sample in active touch what their strokes say along the way, where the motion was measured.
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
            .filter(|take| {
                let by_hand = take.condition().touch == Some(Touch::Active);
                by_hand && take.segmentation.roles.motion.is_some()
            })
            .collect();
        let vibrations = moved.iter().map(|take| filtered(take));
        let vibrations: Vec<Vibrations> = vibrations.collect::<Result<_, _>>()?;
        let (Some(first), Some(unit)) = (moved.first(), vibrations.first()) else {
            continue;
        };
        let rate = first.recording.rate();
        let lowest = first.analysis.as_ref().map(|a| a.config.passes_from());
        let numbered = moved.iter().zip(&vibrations).enumerate();
        let parts: Vec<Travelled<'_>> = numbered
            .filter(|(_, (take, _))| take.recording.rate() == rate)
            .flat_map(|(recording, (take, vibrations))| {
                let signals = Signals::of(&take.recording, &take.segmentation.roles);
                let strokes = take.segmentation.strokes.iter();
                let ways = signals.into_iter().flat_map(move |signals| {
                    let strokes = strokes.clone();
                    let ways = strokes.flat_map(|stroke| ways(&signals, stroke.steady));
                    ways.collect::<Vec<_>>()
                });
                ways.map(move |way| Travelled {
                    recording,
                    vibration: (vibrations.channels.iter())
                        .map(|channel| way.part.of(channel.as_slice()))
                        .collect(),
                    way,
                })
            })
            .collect();
        group.way = along_the_way(&parts, rate, lowest.unwrap_or(Hertz(0.0)), &unit.unit);
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

fn filtered(take: &AnalysedRecording) -> Result<Vibrations, StudyError> {
    let high_pass = take.analysis.as_ref().and_then(|a| a.config.high_pass);
    vibrations(&take.recording, &take.segmentation, high_pass).map_err(|error| take.failed(error))
}
