//! The part of a recording in which a drive plays.

use super::Interval;
use crate::quantity::{Acceleration, Drive};
use crate::recording::Recording;
use crate::series::Series;

/// The share of its energy that a texture played may have on either side of the part in which it is felt.
const TAIL_SHARE: f64 = 5e-4;

/// The part of a recording in which its drive plays and what it plays is felt; none without a drive, or where it is silent.
///
/// It is what lies between the first and the last 0.05 % of the energy of the drive and, within it, of the acceleration: the tails
/// of an inverse filter are not quiet in the drive, but nothing is felt of them.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn played_part(recording: &Recording) -> Option<Interval> {
    let drive = recording.series::<Drive>(None).ok()?;
    let played = energetic_part(drive.samples())?;
    let felt = recording.series::<Acceleration>(None).ok();
    let felt = felt
        .as_ref()
        .map(Series::samples)
        .filter(|felt| felt.len() == drive.samples().len());
    Some(
        match felt.and_then(|felt| energetic_part(&felt[played.start..played.end])) {
            Some(felt) => Interval {
                start: played.start + felt.start,
                end: played.start + felt.end,
            },
            None => played,
        },
    )
}

/// What lies between the first and the last [`TAIL_SHARE`] of the energy of `x`.
fn energetic_part(x: &[f64]) -> Option<Interval> {
    let tail = TAIL_SHARE * x.iter().map(|v| v * v).sum::<f64>();
    let beyond = |left: &mut f64, v: &f64| {
        *left -= v * v;
        *left < 0.0
    };
    let (mut before, mut after) = (tail, tail);
    let start = x.iter().position(|v| beyond(&mut before, v))?;
    let end = x.iter().rposition(|v| beyond(&mut after, v))? + 1;
    (start < end).then_some(Interval { start, end })
}
