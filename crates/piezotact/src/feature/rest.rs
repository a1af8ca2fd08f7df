//! Lines that are there while nothing is touched: of the mains, or of a machine.

use super::FeatureError;
use crate::integrity::{ChannelFault, RestLine, SignalWarning, lines_at_rest};
use crate::quantity::{SampleRate, Seconds, Uncalibrated};
use crate::spectrum::{WelchConfig, WelchPlan};
use crate::statistics::mean;
use crate::stroke::{Interval, Segmentation};
use crate::warning::Warning;

/// What is next to a contact is no rest: the force is smoothed, and a filter of the gesture rings.
const BESIDE: Seconds = Seconds(0.05);
/// Lines that hold less than this share of the power of the strokes change nothing.
const LEAST_SHARE: f64 = 1e-3;

/// The parts of a recording of `length` samples beyond all contacts, strokes and rejected ones.
fn rests(segmentation: &Segmentation, length: usize, rate: SampleRate) -> Vec<Interval> {
    let strokes = segmentation.strokes.iter().map(|stroke| stroke.contact);
    let rejected = segmentation
        .rejected
        .iter()
        .map(|rejected| rejected.interval);
    let mut contacts: Vec<Interval> = strokes.chain(rejected).collect();
    contacts.sort_by_key(|contact| contact.start);
    let beside = rate.samples_in(BESIDE);
    let mut rests = Vec::new();
    let mut start = 0;
    for contact in contacts {
        let end = contact.start.saturating_sub(beside);
        if end > start {
            rests.push(Interval { start, end });
        }
        start = start.max(contact.end + beside);
    }
    if start < length {
        rests.push(Interval { start, end: length });
    }
    rests
}

/// The lines of the channel `name` that stand at rest and hold 0.1 % or more of the power of the strokes together, with the warning.
pub(super) fn of_channel(
    (name, samples): (&str, &[f64]),
    segmentation: &Segmentation,
    rate: SampleRate,
) -> Option<(Vec<RestLine>, Warning)> {
    let rests = rests(segmentation, samples.len(), rate);
    let rests: Vec<&[f64]> = rests.iter().map(|rest| rest.of(samples)).collect();
    let lines = lines_at_rest(&rests, rate);
    let strokes = segmentation.strokes.iter();
    let squares: Vec<f64> = strokes
        .map(|stroke| {
            let part = stroke.steady.of(samples);
            part.iter().map(|v| v * v).sum::<f64>() / part.len().max(1) as f64
        })
        .collect();
    let share = lines.iter().map(|line| line.mean_square).sum::<f64>() / mean(&squares);
    (share >= LEAST_SHARE).then(|| {
        let warning = Warning::from(SignalWarning::Channel {
            channel: name.to_owned(),
            fault: ChannelFault::LinesAtRest {
                lines_hz: lines.iter().map(|line| line.frequency_hz).collect(),
                share: share.min(1.0),
            },
        });
        (lines, warning)
    })
}

/// The PSD of `channels` in the rests that are as long as a segment, averaged over channels; `None` without such a rest.
pub(super) fn psd(
    channels: &[&[f64]],
    segmentation: &Segmentation,
    (config, rate): (&WelchConfig, SampleRate),
) -> Result<Option<Vec<f64>>, FeatureError> {
    let Some(first) = channels.first() else {
        return Ok(None);
    };
    let mut rests = rests(segmentation, first.len(), rate);
    rests.retain(|rest| rest.len() >= config.segment);
    if rests.is_empty() {
        return Ok(None);
    }
    let parts = channels
        .iter()
        .flat_map(|channel| rests.iter().map(|rest| rest.of(channel)));
    let parts: Vec<&[f64]> = parts.collect();
    let spectrum = WelchPlan::new(config, rate)?.estimate::<Uncalibrated>(&parts)?;
    Ok(Some(spectrum.values))
}
