//! Lines that are there while nothing is touched: of the mains, or of a machine.

use super::FeatureError;
use crate::integrity::{ChannelFault, RestLine, SignalWarning, lines_at_rest};
use crate::quantity::{SampleRate, Seconds, Uncalibrated};
use crate::spectrum::{Averaging, WelchConfig, WelchPlan};
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

/// The PSD of `channels` in the rests that are as long as a segment, over segments and channels; `None` without such a rest.
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
    of_parts(&parts, config, rate).map(Some)
}

/// The PSD of rests, as the median of their segments: a finger that begins and ends to press vibrates in a few of them, louder on a rougher
/// surface, which is no property of the sensor.
fn of_parts(
    parts: &[&[f64]],
    config: &WelchConfig,
    rate: SampleRate,
) -> Result<Vec<f64>, FeatureError> {
    let config = WelchConfig {
        averaging: Averaging::Median,
        ..config.clone()
    };
    let spectrum = WelchPlan::new(&config, rate)?.estimate::<Uncalibrated>(parts)?;
    Ok(spectrum.values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn vibrations_beside_contacts_do_not_change_the_noise_of_a_sensor_and_its_gain_does() {
        let rate = SampleRate::new(5000.0).unwrap();
        let config = WelchConfig::hann(1000);
        let mut random = Random::stream(1, 0, "rest");
        let quiet: Vec<f64> = (0..20_000).map(|_| 0.01 * random.normal()).collect();
        // 0.1 s of a vibration 20 dB above the noise as the finger lifts and as it lands.
        let mut beside = quiet.clone();
        for (i, value) in beside.iter_mut().enumerate() {
            if !(500..19_500).contains(&i) {
                *value += 0.1 * random.normal();
            }
        }
        let loud: Vec<f64> = quiet.iter().map(|v| 3.0 * v).collect();
        let level = |samples: &[f64]| {
            let psd = of_parts(&[samples], &config, rate).unwrap();
            10.0 * mean(&psd[4..200]).log10()
        };
        assert!((level(&beside) - level(&quiet)).abs() < 1.0);
        assert!((level(&loud) - level(&quiet) - 9.54).abs() < 0.01);
    }
}
