//! XDF, the file format of the Lab Streaming Layer: streams of several devices, each with its clock.
//!
//! Source of the layout: C. Kothe et al., *XDF specification 1.0*. Time stamps are brought to the clock of the recording computer and
//! freed of jitter as pyxdf 1.17.5 does with its defaults; samples that were lost, over which it fits, stay gaps.

mod chunks;
mod clock;
mod convert;
mod losses;

use std::ops::Range;
use std::path::Path;

use piezotact::Warning;
use piezotact::recording::{Channel, RecordingWarning};

pub(crate) use convert::{recording_of_xdf, segments_of_xdf};
pub use losses::LostBefore;

use crate::error::ReadError;
use chunks::Stored;
use clock::Offsets;

/// Whether `head` begins as an XDF file does.
pub(crate) fn looks_like_xdf(head: &[u8]) -> bool {
    head.starts_with(b"XDF:")
}

/// The samples of a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum XdfValues {
    /// Channels of numbers, in SI where the stream states a unit.
    Numbers(Vec<Channel>),
    /// Texts: the channels of each sample.
    Texts(Vec<Vec<String>>),
}

/// One stream of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct XdfStream {
    /// Its number in the file.
    pub id: u32,
    pub name: String,
    /// Its content type: `EEG`, `Markers`, …
    pub kind: String,
    /// The rate that it states, Hz; 0 for samples at any time.
    pub nominal_rate_hz: f64,
    /// The rate of its time stamps, Hz; `None` for samples at any time, or less than two of them.
    pub effective_rate_hz: Option<f64>,
    /// The time of each sample on the clock of the recording computer, s, without jitter within a segment.
    pub time_s: Vec<f64>,
    /// The samples, as many as times.
    pub values: XdfValues,
    /// The parts without a gap, by the indices of their samples. A gap is longer than 1 s and than 500 samples.
    pub segments: Vec<Range<usize>>,
    /// The samples missing within its segments, in order.
    pub lost: Vec<LostBefore>,
    /// How far its time stamps, over a second, leave a constant rate, s; at most.
    pub residual_s: f64,
    /// The parts between resets of the device's clock, by the indices of their samples.
    pub clock_segments: Vec<Range<usize>>,
    /// How far its clock is from that of the recording computer: when measured, and the offset, both in s.
    pub clock_offsets: Vec<(f64, f64)>,
}

/// What an XDF file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct XdfFile {
    /// Its streams in the order of their headers.
    pub streams: Vec<XdfStream>,
    /// Whether it was cut short: a stream has no end, or the last part of the file is incomplete.
    pub is_interrupted: bool,
    /// What a person should know about the reading.
    pub warnings: Vec<Warning>,
}

/// Reads an XDF file. One that was cut short is read as far as it goes, with a warning.
///
/// # Errors
/// [`ReadError`] when it is no XDF file, has no stream, or the header of a stream cannot be understood.
pub fn read_xdf(path: &Path) -> Result<XdfFile, ReadError> {
    parse_xdf(path, &crate::input::read_input(path)?)
}

fn parse_xdf(path: &Path, bytes: &[u8]) -> Result<XdfFile, ReadError> {
    let mut stored = chunks::read(path, bytes)?;
    let mut warnings = Vec::new();
    let unknown = unknown_clocks(&stored.streams);
    let mut guessed = |what: String| {
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    };
    let mut last_s = 0.0_f64;
    let mut streams = Vec::with_capacity(stored.streams.len());
    for (mut stream, unknown) in std::mem::take(&mut stored.streams).into_iter().zip(unknown) {
        let _late = drop_late_samples(&mut stream).map(&mut guessed);
        let name = stream.header.name.clone();
        if unknown {
            let host = match stream.header.host.as_str() {
                "" => String::new(),
                host => format!(", `{host}`,"),
            };
            guessed(format!(
                "stream `{name}` has no clock offsets: how far the clock of its computer{host} is from that of the others is unknown, and its times may be \
                    off by seconds"
            ));
        }
        let mut time_s = std::mem::take(&mut stream.time_s);
        let (clock_segments, wrong) = clock::synchronise(&mut time_s, &stream.clock_offsets);
        let _wrong = wrong.map(|wrong| guessed(match wrong {
            Offsets::OfOneTime => format!(
                "the clock offsets of stream `{name}` are at one time, and cannot be used"
            ),
            Offsets::Wrong { count, of, by_s } => format!(
                "{count} of {of} clock offsets of stream `{name}` are up to {:.1} ms from the line of the others, and were left out",
                1e3 * by_s
            ),
            Offsets::Apart { by_s } => format!(
                "the clock offsets of stream `{name}` are up to {:.1} ms from their line, and its times may be off by as much",
                1e3 * by_s
            ),
        }));
        let nominal = stream.header.rate_hz;
        // Texts are events, which no rate orders.
        let regular_hz = match &stream.values {
            XdfValues::Texts(_) => 0.0,
            XdfValues::Numbers(_) => nominal,
        };
        let even = clock::without_jitter(&mut time_s, regular_hz, stream.header.spacing);
        let effective = even.rate_hz;
        if let Some(rate_hz) = effective.filter(|hz| even.residual_s * hz > 0.5) {
            guessed(format!(
                "the time stamps of stream `{name}` leave its constant rate of {rate_hz:.3} Hz by up to {:.1} ms ({:.1} samples), and are read as that rate",
                1e3 * even.residual_s,
                even.residual_s * rate_hz
            ));
        }
        if let Some(found_hz) = effective.filter(|hz| (hz - nominal).abs() > 0.1 * nominal) {
            guessed(format!(
                "stream `{name}` states {nominal} Hz, but its time stamps give {found_hz:.3} Hz"
            ));
        }
        if let (Some(first), Some(last)) = (time_s.first(), time_s.last()) {
            last_s = last_s.max(last - first);
        }
        streams.push(XdfStream {
            id: stream.id,
            name,
            kind: stream.header.kind,
            nominal_rate_hz: nominal,
            effective_rate_hz: effective,
            time_s,
            values: stream.values,
            segments: even.segments,
            lost: even.lost,
            residual_s: even.residual_s,
            clock_segments,
            clock_offsets: stream.clock_offsets,
        });
    }
    if stored.incomplete {
        warnings.push(Warning::from(RecordingWarning::Interrupted {
            read_s: last_s,
        }));
    }
    if stored.skipped > 0 {
        let what = format!(
            "{} bytes of the file are damaged or of an unknown kind, and were left out",
            stored.skipped
        );
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    Ok(XdfFile {
        streams,
        is_interrupted: stored.incomplete,
        warnings,
    })
}

/// Leaves out what an outlet that ended sent after its end: samples beyond the count of the footer, where the last clock offset is
/// an outlier too.
fn drop_late_samples(stream: &mut Stored) -> Option<String> {
    let count = stream
        .footer_count
        .filter(|count| *count < stream.time_s.len())?;
    if !clock::last_is_outlier(&stream.clock_offsets) {
        return None;
    }
    stream.clock_offsets.pop();
    let what = format!(
        "{} sample(s) of stream `{}` came after its end together with a clock offset that is an outlier, and were left out",
        stream.time_s.len() - count,
        stream.header.name
    );
    stream.time_s.truncate(count);
    match &mut stream.values {
        XdfValues::Numbers(channels) => {
            for channel in channels {
                channel.samples.truncate(count);
            }
        }
        XdfValues::Texts(texts) => texts.truncate(count),
    }
    Some(what)
}

/// Which streams are of a clock that nothing brings to that of the others: they have samples and no clock offset, and another stream is of
/// another computer, or has an offset above 1 ms.
fn unknown_clocks(streams: &[Stored]) -> Vec<bool> {
    let differs = |own: &Stored, other: &Stored| {
        let hosts = [&own.header.host, &other.header.host];
        let other_host = hosts.iter().all(|host| !host.is_empty()) && hosts[0] != hosts[1];
        other_host || other.clock_offsets.iter().any(|(_, by)| by.abs() > 1e-3)
    };
    let with_samples = |stream: &&Stored| !stream.time_s.is_empty();
    let unknown = |own: &Stored| {
        let mut others = streams.iter().filter(with_samples);
        own.clock_offsets.is_empty()
            && with_samples(&own)
            && others.any(|other| other.id != own.id && differs(own, other))
    };
    streams.iter().map(unknown).collect()
}
