//! Two channels of one recording: copies, and what a broken channel does to a transfer function.

use super::copied::copied;
use super::hum::hum_beside;
use super::level::{Usual, abrupt, at_the_floor};
use super::{SignalWarning, Span, inspect_samples, never_changes};
use crate::clipping::ClippingWarning;
use crate::clipping::limited;
use crate::quantity::{SampleRate, Seconds, Unit};
use crate::recording::Recording;
use crate::warning::Warning;

/// The copies among the channels of a recording. A digital drive and the voltage at the amplifier may legitimately be equal.
pub(super) fn copies_in(recording: &Recording) -> Vec<Warning> {
    let channels: Vec<_> = recording
        .channels_with_clocks()
        .filter(|(c, _)| !super::commanded(&c.unit) && !never_changes(&c.samples))
        .collect();
    let sends = |unit: &Unit| matches!(unit, Unit::FullScale | Unit::Volt);
    let mut warnings = Vec::new();
    for (i, (copy, clock)) in channels.iter().enumerate().skip(1) {
        let found = channels[..i].iter().find_map(|(of, of_clock)| {
            if clock != of_clock || sends(&copy.unit) && sends(&of.unit) {
                return None;
            }
            Some((of, copied(&of.samples, &copy.samples)?))
        });
        if let Some((of, found)) = found {
            warnings.push(Warning::from(SignalWarning::Copied {
                channel: copy.name.clone(),
                of: of.name.clone(),
                factor: found.factor,
                delay_s: found.later as f64 / clock.rate_hz.hz(),
            }));
        }
    }
    warnings
}

/// A drive and the response to it, with the names of their channels.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    pub drive: &'a [f64],
    /// The response, as many samples.
    pub response: &'a [f64],
    /// The rate of both.
    pub rate: SampleRate,
    /// What the drive's channel is called.
    pub drive_name: &'a str,
    /// What the response's channel is called.
    pub response_name: &'a str,
    /// The largest drive that can be played, in the drive's unit; absent where it is not known.
    pub drive_limit: Option<f64>,
    /// Whether the drive lasts: of hits, what is dead or limited is found hit by hit.
    pub lasts: bool,
}

/// The floor of a response while its drive goes on, re the usual level: −20 dB.
const FLOOR: f64 = 0.1;
/// A response that is dead for less is not looked at.
const SHORTEST: Seconds = Seconds(0.02);
/// The drive goes on where its level is this part of its usual one.
const EXCITED: f64 = 0.3;
/// A noise drive may have its crests clipped intentionally, up to this share.
const CRESTS: f64 = 0.005;
/// A drive within this part of its limit is not beyond it.
const TOLERANCE: f64 = 1e-6;

/// The warnings about a transfer function from a drive to a response because of what is broken in the two: each says how
/// far the function is off, where that can be computed.
///
/// Formula: a response that is dead while the share p of the drive's power is played leaves H1·(1 − p). A Gaussian
/// response of which the share s is limited leaves H1·(1 − s). A drive x of which c(x) is played leaves
/// H1·Σx·c(x)/Σx².
///
/// Source: J. J. Bussgang (1952), MIT RLE Technical Report 216, for limited Gaussian signals; the others follow from H1 = Sxy/Sxx.
#[must_use]
pub fn transfer_warnings(pair: &Pair<'_>) -> Vec<Warning> {
    let Pair {
        drive,
        response,
        rate,
        ..
    } = *pair;
    let (drive_name, response_name) = (pair.drive_name.to_owned(), pair.response_name.to_owned());
    if never_changes(drive) || never_changes(response) || drive.len() != response.len() {
        return Vec::new();
    }
    let mut warnings = Vec::new();
    if let Some(copy) = copied(drive, response) {
        warnings.push(SignalWarning::Copied {
            channel: response_name.clone(),
            of: drive_name.clone(),
            factor: copy.factor,
            delay_s: copy.later as f64 / rate.hz(),
        });
    }
    warnings.extend(pair.lasts.then(|| dead(pair)).flatten());
    if let Some(hum) = hum_beside(drive, response, rate) {
        warnings.push(hum.warning(response_name.clone()));
    }
    let fraction = limited(response).share();
    if pair.lasts && fraction > 0.0 {
        warnings.push(SignalWarning::ClippedTransfer {
            channel: response_name,
            fraction,
            off_db: Some(20.0 * (1.0 - fraction).max(1e-3).log10()),
        });
    }
    let fraction = limited(drive).share();
    if pair.lasts && fraction > CRESTS {
        warnings.push(SignalWarning::ClippedTransfer {
            channel: drive_name.clone(),
            fraction,
            off_db: None,
        });
    }
    warnings.extend(
        pair.drive_limit
            .and_then(|limit| beyond(drive, &drive_name, limit)),
    );
    warnings.into_iter().map(Warning::from).collect()
}

/// The warning about a drive beyond `limit`.
pub(super) fn beyond(drive: &[f64], channel: &str, limit: f64) -> Option<SignalWarning> {
    let most = limit * (1.0 + TOLERANCE);
    let (mut peak, mut count, mut played, mut all) = (0.0_f64, 0_usize, 0.0, 0.0);
    for v in drive {
        peak = peak.max(v.abs());
        count += usize::from(v.abs() > most);
        played += v * v.clamp(-limit, limit);
        all += v * v;
    }
    (count > 0).then(|| SignalWarning::DriveBeyondLimit {
        channel: channel.into(),
        peak,
        limit,
        share: count as f64 / drive.len() as f64,
        lost_db: 20.0 * (all / played).log10(),
    })
}

/// A dead response that lowers the transfer function by less than this, dB, is not reported: the response begins later than
/// the drive anyway.
const LEAST_LOW_DB: f64 = 0.1;

/// The warning about a response that is dead while the drive goes on.
fn dead(pair: &Pair<'_>) -> Option<SignalWarning> {
    let (drive, response, rate) = (pair.drive, pair.response, pair.rate);
    let usual = Usual::of(response, rate);
    let known = inspect_samples(response, rate, &Unit::MetrePerSecondSquared);
    let mut spans: Vec<Span> = known.frozen;
    spans.extend(known.gaps);
    for span in at_the_floor(response, rate, &usual, FLOOR, SHORTEST) {
        let within = |known: &Span| known.from < span.to && span.from < known.to;
        if abrupt(response, rate, &usual, span) && !spans.iter().any(within) {
            spans.push(span);
        }
    }
    let power = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
    let all = power(drive);
    let usual_power = all / drive.len() as f64;
    spans.retain(|span| {
        power(&drive[span.from..span.to]) >= EXCITED * EXCITED * usual_power * span.len() as f64
    });
    let share = spans
        .iter()
        .map(|span| power(&drive[span.from..span.to]))
        .sum::<f64>()
        / all;
    let longest = spans.iter().map(|span| span.len()).max()?;
    let low_db = -20.0 * (1.0 - share).max(1e-3).log10();
    (low_db >= LEAST_LOW_DB).then(|| SignalWarning::ResponseDead {
        channel: pair.response_name.into(),
        count: spans.len(),
        longest_s: rate.duration_of(longest).0,
        share,
        low_db,
    })
}

/// Whether the warnings about a pair of channels, `broken`, already cover `warning` about one of them.
///
/// Source: house rule; one finding is said once.
#[must_use]
pub fn said_of_a_pair(warning: &Warning, broken: &[Warning]) -> bool {
    use SignalWarning::{
        ClippedTransfer, Copied, DriveBeyondLimit, DropOuts, Frozen, MainsHum, ResponseDead,
    };
    let clipped = match warning.kind() {
        Some(ClippingWarning::Clipped { signal, .. }) => Some(signal),
        _ => None,
    };
    let one: Option<SignalWarning> = warning.kind();
    broken
        .iter()
        .filter_map(Warning::kind)
        .any(|other| match (&one, other) {
            (None, ClippedTransfer { channel, .. }) => clipped.as_ref() == Some(&channel),
            (
                Some(Frozen { channel, .. } | DropOuts { channel, .. }),
                ResponseDead { channel: other, .. },
            )
            | (Some(MainsHum { channel, .. }), MainsHum { channel: other, .. })
            | (Some(DriveBeyondLimit { channel, .. }), DriveBeyondLimit { channel: other, .. }) => {
                *channel == other
            }
            (
                Some(Copied { channel, of, .. }),
                Copied {
                    channel: other,
                    of: original,
                    ..
                },
            ) => (*channel == other && *of == original) || (*channel == original && *of == other),
            _ => false,
        })
}
