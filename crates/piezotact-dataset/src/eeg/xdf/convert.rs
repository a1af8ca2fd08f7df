//! An XDF file as one recording: channels of constant rates on clocks of their own, everything else as events.

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::{
    Channel, Clock, Condition, Event, EventValue, NotUsed, Provenance, Recording, RecordingWarning,
};

use super::{XdfStream, XdfValues, parse_xdf};
use crate::error::ReadError;

/// The streams in `bytes` as one recording. Of a stream with gaps the first segment is used, with a warning.
pub(crate) fn recording_of_xdf(path: &Path, bytes: &[u8]) -> Result<Recording, ReadError> {
    let file = parse_xdf(path, bytes)?;
    let mut warnings = file.warnings;
    let (mut channels, mut events) = (Vec::new(), Vec::new());
    let several = file.streams.iter().filter(|s| is_signal(s)).count() > 1;
    for stream in &file.streams {
        match &stream.values {
            _ if stream.time_s.is_empty() => {}
            XdfValues::Numbers(all) if is_signal(stream) => {
                let prefix = match several {
                    true => format!("{}: ", stream.name),
                    false => String::new(),
                };
                warnings.extend(one_segment(stream));
                channels.extend(signals(path, stream, all, &prefix)?);
            }
            XdfValues::Numbers(all) => match all.as_slice() {
                [only] => {
                    let each = stream.time_s.iter().zip(&only.samples);
                    events.extend(each.map(|(t, v)| (*t, stream, EventValue::Number(*v))));
                }
                _ => {
                    let what = format!(
                        "stream `{}` has {} channels of no constant rate, and is left out",
                        stream.name,
                        all.len()
                    );
                    warnings.push(Warning::from(RecordingWarning::Guessed { what }));
                }
            },
            XdfValues::Texts(texts) => {
                let each = stream.time_s.iter().zip(texts);
                events.extend(each.map(|(t, row)| (*t, stream, EventValue::Text(row.join(" ")))));
            }
        }
    }
    let earliest_s = channels
        .iter()
        .map(|(_, clock): &(Channel, Clock)| clock.start_s.0)
        .fold(f64::INFINITY, f64::min);
    let provenance = Provenance {
        source: path.display().to_string(),
        ..Provenance::default()
    };
    let recording = Recording::with_clocks(channels, Condition::default(), provenance);
    let mut recording = recording.map_err(ReadError::of(path))?;
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    recording.annotations.events = events
        .into_iter()
        .map(|(time_s, stream, value)| Event {
            onset_s: Seconds(time_s - earliest_s),
            duration_s: Seconds(0.0),
            kind: stream.name.clone(),
            value: Some(value),
        })
        .collect();
    let length_s = recording.duration();
    let outside = recording.annotations.outside(length_s);
    if let Some(first) = outside.first() {
        warnings.push(Warning::from(RecordingWarning::NotUsed {
            what: NotUsed::Events {
                count: outside.len(),
                onset_s: first.onset_s.0,
                lasts_s: first.duration_s.0,
                length_s: length_s.0,
            },
        }));
    }
    recording.about.warnings = warnings;
    recording.about.provenance.losses.is_interrupted = file.is_interrupted;
    Ok(recording)
}

/// Whether a stream holds samples of a constant rate.
fn is_signal(stream: &XdfStream) -> bool {
    matches!(stream.values, XdfValues::Numbers(_))
        && stream.nominal_rate_hz > 0.0
        && !stream.time_s.is_empty()
}

fn one_segment(stream: &XdfStream) -> Option<Warning> {
    let first = stream.segments.first()?.len() as f64;
    (stream.segments.len() > 1).then(|| {
        Warning::from(RecordingWarning::OneSegment {
            count: stream.segments.len(),
            lasts_s: first / stream.nominal_rate_hz,
            all_s: stream.time_s.len() as f64 / stream.nominal_rate_hz,
        })
    })
}

/// The channels of the first segment of a stream, with their clock; named with `prefix`.
fn signals(
    path: &Path,
    stream: &XdfStream,
    all: &[Channel],
    prefix: &str,
) -> Result<Vec<(Channel, Clock)>, ReadError> {
    let part = stream.segments.first().cloned().unwrap_or_default();
    let times = stream.time_s.get(part.clone()).unwrap_or_default();
    let (start_s, rate_hz) = match times {
        [first, .., last] if last > first => (*first, (times.len() - 1) as f64 / (last - first)),
        [first, ..] => (*first, stream.nominal_rate_hz),
        [] => (0.0, stream.nominal_rate_hz),
    };
    let rate_hz = SampleRate::new(rate_hz).map_err(ReadError::of(path))?;
    let clock = Clock {
        rate_hz,
        start_s: Seconds(start_s),
    };
    let named = all.iter().map(|channel| {
        let name = format!("{prefix}{}", channel.name);
        let samples = channel
            .samples
            .get(part.clone())
            .unwrap_or_default()
            .to_vec();
        let unit = channel.unit.clone();
        (
            Channel {
                name,
                unit,
                samples,
            },
            clock,
        )
    });
    Ok(named.collect())
}
