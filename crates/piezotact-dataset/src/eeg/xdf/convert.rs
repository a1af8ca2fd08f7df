//! An XDF file as one recording: channels of constant rates on clocks of their own, everything else as events.

use std::ops::Range;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::Seconds;
use piezotact::recording::{
    Channel, Clock, Condition, Event, EventValue, LostBy, NotUsed, Provenance, Recording,
    RecordingWarning,
};

use super::super::{EegSegment, one_of};
use super::{LostBefore, XdfStream, XdfValues, parse_xdf};
use crate::error::ReadError;
use crate::time_column::rate_of_step;

/// What stands between two parts of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Between {
    /// Long gaps; straight lines stand in the place of samples that were lost within a part.
    Gaps,
    /// Gaps of every length.
    Losses,
}

/// The streams in `bytes` as one recording: of one with gaps the first part, with a warning, or the one that `part` names, from 1 on.
pub(crate) fn recording_of_xdf(
    path: &Path,
    bytes: &[u8],
    part: Option<usize>,
) -> Result<Recording, ReadError> {
    let segments = parts_of(path, bytes, Between::Gaps)?;
    one_of(path, segments, part)
}

/// The streams in `bytes` as parts without a gap of the stream of EEG (without one, of the first of a constant rate).
pub(crate) fn segments_of_xdf(path: &Path, bytes: &[u8]) -> Result<Vec<EegSegment>, ReadError> {
    parts_of(path, bytes, Between::Losses)
}

fn parts_of(path: &Path, bytes: &[u8], between: Between) -> Result<Vec<EegSegment>, ReadError> {
    let file = parse_xdf(path, bytes)?;
    let mut warnings = file.warnings;
    let mut guessed = |what: String| {
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    };
    let mut events = Vec::new();
    let mut left_out = Vec::new();
    for stream in file.streams.iter().filter(|stream| !is_signal(stream)) {
        match &stream.values {
            _ if stream.time_s.is_empty() => {}
            XdfValues::Numbers(all) => match all.as_slice() {
                [only] => {
                    let each = stream.time_s.iter().zip(&only.samples);
                    events.extend(each.map(|(t, v)| (*t, stream, EventValue::Number(*v))));
                }
                _ => left_out.push(format!(
                    "stream `{}` has {} channels of no constant rate",
                    stream.name,
                    all.len()
                )),
            },
            XdfValues::Texts(texts) => {
                let each = stream.time_s.iter().zip(texts);
                events.extend(each.map(|(t, row)| (*t, stream, EventValue::Text(row.join(" ")))));
            }
        }
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut signals: Vec<&XdfStream> = file.streams.iter().filter(|s| is_signal(s)).collect();
    let is_eeg = |stream: &&&XdfStream| stream.kind.eq_ignore_ascii_case("EEG");
    let Some(leading) = signals.iter().find(is_eeg).or(signals.first()).copied() else {
        let names = file
            .streams
            .iter()
            .map(|stream| match stream.nominal_rate_hz {
                _ if stream.time_s.is_empty() => format!("`{}` without samples", stream.name),
                hz if hz > 0.0 => format!("`{}` of texts", stream.name),
                _ => format!("`{}` of no constant rate (nominal_srate 0)", stream.name),
            });
        return Err(ReadError::content(
            path,
            "a stream of numbers at a constant rate",
            names.collect::<Vec<_>>().join(", "),
            "record the signal with its rate in nominal_srate, or resample it to a constant rate",
        ));
    };
    for what in left_out {
        guessed(format!("{what}, and is left out"));
    }
    let parts = parts_between(leading, between);
    let without = |stream: &&XdfStream| parts.iter().any(|part| pieces(stream, part).is_empty());
    for stream in signals.iter().filter(|stream| without(stream)) {
        guessed(format!(
            "stream `{}` has no samples in one of {} parts of the recording, and is left out",
            stream.name,
            parts.len()
        ));
    }
    signals.retain(|stream| !without(stream));
    let mut segments = Vec::with_capacity(parts.len());
    for part in &parts {
        segments.push(segment(path, &signals, part)?);
    }
    let starts_s: Vec<f64> = segments.iter().map(|(_, start_s)| *start_s).collect();
    // Half a sample, so that a marker on the first sample of a part stays in it.
    let slack_s = 0.5 / leading.effective_rate_hz.unwrap_or(leading.nominal_rate_hz);
    let mut ends_s = f64::NEG_INFINITY;
    for (number, part) in parts.iter().enumerate() {
        let (stream, own) = &part.leading;
        let time_s = |at: usize| stream.time_s.get(at).copied().unwrap_or_default();
        let overlap_s = ends_s - time_s(own.start);
        if overlap_s > slack_s {
            guessed(format!(
                "the clock of stream `{}` went back: part {} begins {} s before the one before it ends, and markers of that time may stand in the \
                 wrong part",
                stream.name,
                number + 1,
                digits(overlap_s)
            ));
        }
        ends_s = ends_s.max(time_s(own.end.saturating_sub(1)));
    }
    let mut segments: Vec<EegSegment> = segments
        .into_iter()
        .map(|(recording, start_s)| EegSegment {
            recording,
            start_s: Seconds(start_s - starts_s[0]),
            event_samples: Vec::new(),
        })
        .collect();
    for (time_s, stream, value) in events {
        let begun = starts_s.partition_point(|start_s| *start_s <= time_s + slack_s);
        let number = begun.saturating_sub(1);
        let segment = &mut segments[number];
        let onset_s = time_s - starts_s[number];
        let rates = segment.recording.clocks().iter();
        let rate_hz = rates.map(|clock| clock.rate_hz.hz()).fold(0.0, f64::max);
        segment
            .event_samples
            .push((onset_s * rate_hz).round_ties_even() as i64);
        segment.recording.annotations.events.push(Event {
            onset_s: Seconds(onset_s),
            duration_s: Seconds(0.0),
            kind: stream.name.clone(),
            value: Some(value),
        });
    }
    for segment in &mut segments {
        let recording = &mut segment.recording;
        recording.about.warnings.extend(outside(recording));
    }
    let first = &mut segments[0].recording;
    warnings.append(&mut first.about.warnings);
    first.about.warnings = warnings;
    first.about.provenance.losses.is_interrupted = file.is_interrupted;
    Ok(segments)
}

/// The warning about events beyond the end of a recording.
fn outside(recording: &Recording) -> Option<Warning> {
    let length_s = recording.duration();
    let outside = recording.annotations.outside(length_s);
    let first = outside.first()?;
    Some(Warning::from(RecordingWarning::NotUsed {
        what: NotUsed::Events {
            count: outside.len(),
            onset_s: first.onset_s.0,
            lasts_s: first.duration_s.0,
            length_s: length_s.0,
        },
    }))
}

/// A part of the recording.
struct Part<'s> {
    /// The stream whose gaps make the parts, and its samples in this one.
    leading: (&'s XdfStream, Range<usize>),
    /// From when to when the samples of other streams belong to it, s: in the first and the last without a limit.
    time_s: Range<f64>,
}

/// The parts that the gaps of `leading` make, in the order of time.
fn parts_between(leading: &XdfStream, between: Between) -> Vec<Part<'_>> {
    let mut starts: Vec<usize> = leading.segments.iter().map(|part| part.start).collect();
    if between == Between::Losses {
        starts.extend(leading.lost.iter().map(|lost| lost.at));
        starts.sort_unstable();
    }
    let ends = starts.iter().skip(1).copied();
    let ends = ends.chain([leading.time_s.len()]);
    let at = |k: usize| leading.time_s.get(k).copied().unwrap_or_default();
    let mut pieces: Vec<Range<usize>> = starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(a, b)| a..b)
        .collect();
    pieces.sort_by(|a, b| at(a.start).total_cmp(&at(b.start)));
    let limits: Vec<f64> = [f64::NEG_INFINITY]
        .into_iter()
        .chain(pieces.iter().skip(1).map(|piece| at(piece.start)))
        .chain([f64::INFINITY])
        .collect();
    let limits = limits.iter().zip(limits.iter().skip(1));
    let part = |(piece, (from, to)): (Range<usize>, (&f64, &f64))| Part {
        leading: (leading, piece),
        time_s: *from..*to,
    };
    pieces.into_iter().zip(limits).map(part).collect()
}

/// The samples of a stream in a part of the recording: those of its own segments, each if it has any.
fn pieces(stream: &XdfStream, part: &Part<'_>) -> Vec<Range<usize>> {
    let (leading, own) = &part.leading;
    if leading.id == stream.id {
        return vec![own.clone()];
    }
    let each = stream.segments.iter().map(|own| {
        let times = stream.time_s.get(own.clone()).unwrap_or_default();
        let before = |limit_s: f64| own.start + times.partition_point(|time| *time < limit_s);
        before(part.time_s.start)..before(part.time_s.end)
    });
    each.filter(|piece| !piece.is_empty()).collect()
}

/// The channels of `streams` in a part of the recording, and the time of its first sample.
fn segment(
    path: &Path,
    streams: &[&XdfStream],
    part: &Part<'_>,
) -> Result<(Recording, f64), ReadError> {
    let (mut channels, mut warnings) = (Vec::new(), Vec::new());
    let mut lost = Vec::new();
    for stream in streams {
        let pieces = pieces(stream, part);
        let (Some(piece), XdfValues::Numbers(all)) = (pieces.first(), &stream.values) else {
            continue;
        };
        if pieces.len() > 1 {
            let all: usize = pieces.iter().map(Range::len).sum();
            warnings.push(Warning::from(RecordingWarning::OneSegment {
                count: pieces.len(),
                lasts_s: piece.len() as f64 / stream.nominal_rate_hz,
                all_s: all as f64 / stream.nominal_rate_hz,
            }));
        }
        let prefix = match streams.len() > 1 {
            true => format!("{}: ", stream.name),
            false => String::new(),
        };
        let (own, own_lost) = signals(path, stream, all, piece, &prefix)?;
        channels.extend(own);
        lost.extend(own_lost);
    }
    let starts = channels
        .iter()
        .map(|(_, clock): &(Channel, Clock)| clock.start_s.0);
    let start_s = starts.fold(f64::INFINITY, f64::min);
    let provenance = Provenance {
        source: path.display().to_string(),
        ..Provenance::default()
    };
    let recording = Recording::with_clocks(channels, Condition::default(), provenance);
    let mut recording = recording.map_err(ReadError::of(path))?;
    lost.sort_by(|a, b| a.0.total_cmp(&b.0));
    let places_s: Vec<[f64; 2]> = (lost.iter())
        .map(|(from, to, _)| [from - start_s, to - start_s])
        .collect();
    let losses = &mut recording.about.provenance.losses;
    losses.samples = lost.iter().map(|(_, _, samples)| *samples as u64).sum();
    losses.stretches_s.clone_from(&places_s);
    if !places_s.is_empty() {
        warnings.push(Warning::from(RecordingWarning::SamplesLost {
            by: LostBy::Stamps {
                gaps: places_s.len(),
                samples: losses.samples,
                longest_s: losses.longest().0,
                places_s,
            },
        }));
    }
    recording.about.warnings = warnings;
    Ok((recording, start_s))
}

/// Whether a stream holds samples of a constant rate: markers may state one, which so few of them do not have.
fn is_signal(stream: &XdfStream) -> bool {
    let is_called_marker = ["Markers", "Marker", "Events"]
        .iter()
        .any(|kind| stream.kind.eq_ignore_ascii_case(kind));
    let lasts_s = match stream.time_s.as_slice() {
        [first, .., last] => last - first,
        _ => f64::INFINITY,
    };
    let has_rate = 2.0 * stream.time_s.len() as f64 > stream.nominal_rate_hz * lasts_s;
    matches!(stream.values, XdfValues::Numbers(_))
        && stream.nominal_rate_hz > 0.0
        && !stream.time_s.is_empty()
        && (has_rate || !is_called_marker)
}

/// From when to when straight lines stand in the place of samples, s, and of how many.
type Filled = (f64, f64, usize);

/// Channels with their clock, and what was filled in them.
type Signals = (Vec<(Channel, Clock)>, Vec<Filled>);

/// The channels of a piece of a stream, with their clock; named with `prefix`. Straight lines stand in the place of samples that were lost.
fn signals(
    path: &Path,
    stream: &XdfStream,
    all: &[Channel],
    piece: &Range<usize>,
    prefix: &str,
) -> Result<Signals, ReadError> {
    let times = stream.time_s.get(piece.clone()).unwrap_or_default();
    let within = |lost: &&LostBefore| piece.start < lost.at && lost.at < piece.end;
    let lost: Vec<LostBefore> = (stream.lost.iter().filter(within))
        .map(|lost| LostBefore {
            at: lost.at - piece.start,
            ..*lost
        })
        .collect();
    let missing: usize = lost.iter().map(|lost| lost.samples).sum();
    let steps = (times.len() + missing).saturating_sub(1);
    let (start_s, rate_hz) = match times {
        [first, .., last] if last > first => (*first, steps as f64 / (last - first)),
        [first, ..] => (*first, stream.nominal_rate_hz),
        [] => (0.0, stream.nominal_rate_hz),
    };
    let rate_hz = rate_of_step(path, 1.0 / rate_hz)?;
    let clock = Clock {
        rate_hz,
        start_s: Seconds(start_s),
    };
    let named = all.iter().map(|channel| {
        let own = channel.samples.get(piece.clone()).unwrap_or_default();
        let mut samples = Vec::with_capacity(own.len() + missing);
        let mut from = 0;
        for lost in &lost {
            samples.extend_from_slice(&own[from..lost.at]);
            let (before, after) = (own[lost.at - 1], own[lost.at]);
            let share = |k: usize| k as f64 / (lost.samples + 1) as f64;
            let line = (1..=lost.samples).map(share);
            samples.extend(line.map(|share| before + (after - before) * share));
            from = lost.at;
        }
        samples.extend_from_slice(&own[from..]);
        let channel = Channel {
            name: format!("{prefix}{}", channel.name),
            unit: channel.unit.clone(),
            samples,
        };
        (channel, clock)
    });
    let step_s = 1.0 / rate_hz.hz();
    let filled = lost.iter().map(|lost| {
        let (before_s, after_s) = (times[lost.at - 1], times[lost.at]);
        (before_s + step_s, after_s, lost.samples)
    });
    Ok((named.collect(), filled.collect()))
}
