//! The data file of a `BrainVision` recording.

use std::path::Path;

use piezotact::Warning;
use piezotact::recording::RecordingWarning;

use super::brainvision::Header;
use crate::error::ReadError;

/// The samples of each channel, as stored.
pub(super) fn samples_of(header: &Header, stored: &[u8], points: usize) -> Vec<Vec<f64>> {
    let width = header.format.width();
    let channels = header.channels.len();
    if header.multiplexed {
        let mut all = vec![Vec::with_capacity(points); channels];
        for frame in stored.chunks_exact(width * channels) {
            for (own, bytes) in all.iter_mut().zip(frame.chunks_exact(width)) {
                own.push(header.format.value(bytes, header.order));
            }
        }
        all
    } else {
        let each = stored.chunks_exact(width * points);
        each.map(|bytes| header.format.values(bytes, header.order))
            .collect()
    }
}

/// How much less its samples change from one to the next in the other orientation, where a header states the wrong one: the squared changes
/// re the variance, of which noise has 2.
const SMOOTHER: (f64, f64) = (1.0, 0.25);
/// So many channels and samples of each are looked at.
const LOOKED_AT: (usize, usize) = (32, 4000);

/// Changes from the last channel of a sample to the first of the next that are so many times as large as those between channels: channels of
/// one time stand side by side.
const APART: f64 = 2.0;
/// The networks of the world, Hz.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];

/// `values` without their lines of the mains, second by second.
fn without_mains(values: &mut [f64], rate_hz: f64) {
    let second = rate_hz.round().max(1.0) as usize;
    for part in values.chunks_mut(second) {
        for hz in MAINS_HZ.into_iter().filter(|hz| 2.0 * hz < rate_hz) {
            let turn = |k: usize| (std::f64::consts::TAU * hz * k as f64 / rate_hz).sin_cos();
            let (mut sine, mut cosine) = (0.0, 0.0);
            for (k, value) in part.iter().enumerate() {
                let (s, c) = turn(k);
                sine += value * s;
                cosine += value * c;
            }
            let scale = 2.0 / part.len() as f64;
            for (k, value) in part.iter_mut().enumerate() {
                let (s, c) = turn(k);
                *value -= scale * (sine * s + cosine * c);
            }
        }
    }
}

/// A warning where samples are clearly smoother in the other orientation than in the one that the header states. The mains in all channels
/// are smooth across them and rough in time: they count for no orientation.
pub(super) fn other_orientation(header: &Header, stored: &[u8], points: usize) -> Option<Warning> {
    let channels = header.channels.len();
    let width = header.format.width();
    let looked = points.min(LOOKED_AT.1);
    if channels < 2 || looked < 20 {
        return None;
    }
    let roughness = |multiplexed: bool| {
        let of_channel = |channel: usize| {
            let at = |k: usize| match multiplexed {
                true => k * channels + channel,
                false => channel * points + k,
            };
            let mut values: Vec<f64> = (0..looked)
                .filter_map(|k| stored.get(at(k) * width..(at(k) + 1) * width))
                .map(|bytes| header.format.value(bytes, header.order))
                .collect();
            let mean = values.iter().sum::<f64>() / looked as f64;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            if multiplexed == header.multiplexed {
                without_mains(&mut values, header.rate.hz());
            }
            let changes = values.iter().zip(values.iter().skip(1));
            let changes: f64 = changes.map(|(a, b)| (b - a).powi(2)).sum();
            changes / squares
        };
        let each = (0..channels.min(LOOKED_AT.0)).map(of_channel);
        // Flat channels have none.
        let mut each: Vec<f64> = each.filter(|rough| rough.is_finite()).collect();
        piezotact::statistics::median(&mut each)
    };
    let (own, other) = (
        roughness(header.multiplexed)?,
        roughness(!header.multiplexed)?,
    );
    // What all channels have in common is smooth across them, up to the next sample.
    let at = |k: usize| {
        let bytes = stored.get(k * width..(k + 1) * width);
        bytes.map_or(0.0, |bytes| header.format.value(bytes, header.order))
    };
    let (mut within, mut to_next) = (0.0, 0.0);
    for frame in 0..points.saturating_sub(1).min(LOOKED_AT.1) {
        let first = frame * channels;
        let change = |k: usize| (at(first + k + 1) - at(first + k)).powi(2);
        within += (0..channels - 1).map(change).sum::<f64>();
        to_next += change(channels - 1);
    }
    let are_frames = to_next > APART * within / (channels - 1) as f64;
    if header.multiplexed && are_frames {
        return None;
    }
    let (stated, likely) = match header.multiplexed {
        true => ("MULTIPLEXED", "VECTORIZED"),
        false => ("VECTORIZED", "MULTIPLEXED"),
    };
    (own > SMOOTHER.0 && other < SMOOTHER.1 * own).then(|| {
        let what = format!(
            "the header states DataOrientation={stated}, but the samples are {:.0} times smoother as {likely}: the channels may be mixed up",
            (own / other).sqrt()
        );
        Warning::from(RecordingWarning::Guessed { what })
    })
}

/// The number of samples of each channel in a data file of so many bytes, and a warning where it is not the one that is stated, or the last
/// sample is incomplete.
pub(super) fn points_of(
    path: &Path,
    header: &Header,
    bytes: usize,
) -> Result<(usize, Option<Warning>), ReadError> {
    let frame = header.format.width() * header.channels.len();
    let points = bytes / frame;
    let stated = header.points.unwrap_or(points);
    let beside = bytes % frame;
    if stated == points && beside == 0 && points > 0 {
        return Ok((points, None));
    }
    // Of vectorized data the last channels lack what is missing.
    if points == 0 || !header.multiplexed {
        return Err(ReadError::content(
            &header.data,
            match header.points {
                Some(stated) => format!(
                    "{stated} samples of each channel, as DataPoints of {} states",
                    path.display()
                ),
                None => format!(
                    "whole samples of {} channels, {frame} bytes each",
                    header.channels.len()
                ),
            },
            format!(
                "{points} in {bytes} bytes: the file was cut short, or the header has the wrong number of channels"
            ),
            "copy the data file again, or correct the header",
        ));
    }
    let mut what = format!("the data file holds {points} whole samples of each channel");
    if stated != points {
        what += &format!(", and DataPoints of the header states {stated}");
    }
    if stated > points {
        what += &format!(
            ": {} ({:.3} s) are missing",
            stated - points,
            header.rate.duration_of(stated - points).0
        );
    }
    if beside > 0 {
        what += &format!("; {beside} bytes of an incomplete sample were left out");
    }
    let warning = Warning::from(RecordingWarning::Guessed { what });
    Ok((points, Some(warning)))
}
