//! What epochs may hold: markers once, parts without bad samples, channels with a position.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use piezotact::Warning;
use piezotact::quantity::SampleRate;

use super::signals::Signals;
use super::{Marked, NotWhole};
use crate::eeg::epochs::{CutConfig, Epochs, NotCut};
use crate::eeg::reference::Montage;
use crate::eeg::source::{Segment, is_bad_part, marker_name};
use crate::eeg::{EegWarning, ElectrodesFault, MarkersFault};

/// The markers without those that stand a second time at one sample under one condition.
pub(super) fn once(marked: Vec<Marked>, warnings: &mut Vec<Warning>) -> Vec<Marked> {
    let all = marked.len();
    let mut seen = BTreeSet::new();
    let kept: Vec<Marked> = marked
        .into_iter()
        .filter(|one| seen.insert((one.event.sample, one.event.condition.clone())))
        .collect();
    let count = all - kept.len();
    if count > 0 {
        warnings.push(
            EegWarning::Markers {
                fault: MarkersFault::Twice { count },
            }
            .into(),
        );
    }
    kept
}

/// The parts that no epoch may hold: those in which a channel holds one value or is off, and those that an event calls bad.
pub(super) fn unusable(segments: &[Segment<'_>], signals: &Signals) -> Vec<(Range<usize>, NotCut)> {
    let held = signals.held().into_iter().map(|part| {
        let channel = part.channel;
        (part.samples, NotCut::Held { channel })
    });
    let missing = signals.missing.iter().map(|part| {
        let channel = part.channel.clone();
        (part.samples.clone(), NotCut::NoNumbers { channel })
    });
    let electrodes = signals.electrodes.iter().zip(signals.off());
    let off = electrodes.flat_map(|(channel, parts)| {
        let named = move |samples| {
            let channel = channel.clone();
            (samples, NotCut::Off { channel })
        };
        parts.into_iter().map(named)
    });
    let mut found: Vec<_> = missing.chain(held).chain(off).collect();
    let rate = signals.rate.hz();
    for (segment, start) in segments.iter().zip(&signals.starts) {
        let events = segment.recording.annotations.events.iter();
        for (event, sample) in events.zip(segment.event_samples) {
            if is_bad_part(event) {
                let from = start.saturating_add_signed(*sample as isize);
                let length = (event.duration_s.0 * rate).ceil() as usize;
                let name = marker_name(event);
                found.push((
                    from..from.saturating_add(length),
                    NotCut::CalledBad { name },
                ));
            }
        }
    }
    found
}

/// The markers whose epochs hold no part that may not be used; and the others.
pub(super) fn beside_unusable(
    marked: Vec<Marked>,
    unusable: &[(Range<usize>, NotCut)],
    rate: SampleRate,
    extent: &CutConfig,
) -> (Vec<Marked>, Vec<NotWhole>) {
    let [first, last] = [extent.start_s, extent.end_s].map(|s| (s * rate.hz()).round());
    let (mut kept, mut lost) = (Vec::new(), Vec::new());
    for one in marked {
        let [from, to] = [first, last].map(|offset| one.event.sample as f64 + offset);
        let own = unusable
            .iter()
            .find(|(part, _)| (part.start as f64) <= to && (part.end as f64 - 1.0) >= from);
        match own {
            None => kept.push(one),
            Some((_, reason)) => lost.push(NotWhole {
                condition: one.event.condition,
                onset_s: one.onset_s,
                reason: reason.clone(),
            }),
        }
    }
    (kept, lost)
}

/// A larger share of epochs that one electrode costs is a warning.
const LOST_SHARE: f64 = 0.1;

/// A warning about each electrode that is off in many of the `of` epochs: `lost` are those that are left out.
pub(super) fn lost_to_electrodes(lost: &[NotWhole], of: usize) -> Vec<Warning> {
    let mut counts = BTreeMap::<&str, usize>::new();
    for one in lost {
        if let NotCut::Held { channel } | NotCut::NoNumbers { channel } | NotCut::Off { channel } =
            &one.reason
        {
            *counts.entry(channel).or_default() += 1;
        }
    }
    let many = counts
        .into_iter()
        .filter(|(_, lost)| *lost as f64 > LOST_SHARE * of as f64);
    let warning = |(name, lost): (&str, usize)| {
        let fault = ElectrodesFault::Off { lost, of };
        let names = name.to_owned();
        EegWarning::Electrodes { names, fault }.into()
    };
    many.map(warning).collect()
}

/// A warning about channels in the mean of all electrodes that have no position, where most have one: they may be none.
pub(super) fn unknown_in_average(epochs: &Epochs) -> Option<Warning> {
    let known = Montage::known(epochs.channels());
    let all = epochs.channels().iter().zip(known);
    let unknown = all.filter(|(_, position)| position.is_none());
    let names: Vec<&str> = unknown.map(|(name, _)| name.as_str()).collect();
    let few = !names.is_empty() && 2 * names.len() < epochs.channels().len();
    let warning = EegWarning::Electrodes {
        names: names.join(", "),
        fault: ElectrodesFault::UnknownInReference,
    };
    few.then(|| warning.into())
}
