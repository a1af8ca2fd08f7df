//! The chunks of an XDF file: headers, samples, clock offsets and footers.

use std::path::Path;

use piezotact::recording::Channel;
use roxmltree::{Document, Node};

use super::super::{eeg_unit, unique_names};
use super::XdfValues;
use super::clock::Spacing;
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored as Number};

const FILE_HEADER: u16 = 1;
const STREAM_HEADER: u16 = 2;
const SAMPLES: u16 = 3;
const CLOCK_OFFSET: u16 = 4;
const BOUNDARY: u16 = 5;
const STREAM_FOOTER: u16 = 6;

/// What stands in every boundary chunk, to go on from behind a damaged part.
const BOUNDARY_MARK: [u8; 16] = [
    0x43, 0xA5, 0x46, 0xDC, 0xCB, 0xF5, 0x41, 0x0F, 0xB3, 0x0E, 0xD5, 0x46, 0x73, 0x83, 0xCB, 0xE4,
];

/// All streams together have no more channels.
const MOST_CHANNELS: usize = 1 << 17;

/// What the header of a stream says.
pub(super) struct Header {
    pub(super) name: String,
    pub(super) kind: String,
    /// The computer whose clock its time stamps are of; empty where it is not stated.
    pub(super) host: String,
    pub(super) rate_hz: f64,
    pub(super) spacing: Spacing,
    /// The type of its numbers; `None` for texts.
    number: Option<Number>,
    channels: usize,
}

/// A stream as it is stored.
pub(super) struct Stored {
    pub(super) id: u32,
    pub(super) header: Header,
    pub(super) time_s: Vec<f64>,
    pub(super) values: XdfValues,
    /// Factors to SI, for each channel.
    factors: Vec<f64>,
    pub(super) clock_offsets: Vec<(f64, f64)>,
    /// The number of samples that the footer states.
    pub(super) footer_count: Option<usize>,
    has_footer: bool,
    /// The last time, from which one that is left out follows.
    last_s: f64,
}

/// All streams of a file.
pub(super) struct Content {
    pub(super) streams: Vec<Stored>,
    /// Whether a stream has no footer, or the last chunk is cut.
    pub(super) incomplete: bool,
    /// Bytes in damaged parts.
    pub(super) skipped: usize,
}

/// A place in the bytes.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1)?.first().copied()
    }

    fn unsigned(&mut self, count: usize) -> Option<u64> {
        self.take(count)
            .map(|bytes| ByteOrder::Little.unsigned(bytes))
    }

    fn double(&mut self) -> Option<f64> {
        self.unsigned(8).map(f64::from_bits)
    }

    /// A length of 1, 4 or 8 bytes, with their number before it.
    fn length(&mut self) -> Option<usize> {
        let count = self.byte().filter(|count| matches!(count, 1 | 4 | 8))?;
        usize::try_from(self.unsigned(count.into())?).ok()
    }
}

/// Reads the chunks in `bytes`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Content, ReadError> {
    let todo = "copy the file again, or record it again with LabRecorder";
    if !super::looks_like_xdf(bytes) {
        return Err(ReadError::content(
            path,
            "an XDF file, which begins with `XDF:`",
            "another file",
            todo,
        ));
    }
    let mut cursor = Cursor { bytes, at: 4 };
    let mut content = Content {
        streams: Vec::new(),
        incomplete: false,
        skipped: 0,
    };
    while cursor.at < bytes.len() {
        let from = cursor.at;
        let Some((tag, body, cut)) = chunk(&mut cursor) else {
            cursor.at = from;
            match behind_unknown(bytes, from) {
                Some(next) => cursor.at = next,
                None => _ = skip(&mut cursor),
            }
            content.skipped += cursor.at - from;
            continue;
        };
        content.incomplete |= cut;
        let used = match tag {
            STREAM_HEADER if cut => true,
            STREAM_HEADER => {
                let known = content.streams.iter().map(|stream| stream.header.channels);
                let left = MOST_CHANNELS.saturating_sub(known.sum());
                let stream = header(path, body, bytes.len().min(left))?;
                if content.streams.iter().any(|known| known.id == stream.id) {
                    return Err(ReadError::content(
                        path,
                        "one header for each stream",
                        format!("two of stream {}", stream.id),
                        todo,
                    ));
                }
                content.streams.push(stream);
                true
            }
            SAMPLES | CLOCK_OFFSET | STREAM_FOOTER => {
                let mut body = Cursor { bytes: body, at: 0 };
                let id = body.unsigned(4);
                let known = content
                    .streams
                    .iter_mut()
                    .find(|s| Some(u64::from(s.id)) == id);
                known.is_some_and(|stream| match tag {
                    SAMPLES => samples(stream, &mut body) || cut,
                    CLOCK_OFFSET => offset(stream, &mut body) || cut,
                    _ => {
                        footer(stream, &body);
                        stream.has_footer = !cut;
                        true
                    }
                })
            }
            _ => true,
        };
        if !used {
            // Its length holds where another chunk follows; otherwise the next one is behind the next boundary.
            let mut after = Cursor {
                bytes,
                at: cursor.at,
            };
            if cursor.at < bytes.len() && chunk(&mut after).is_none() {
                cursor.at = from + 1;
                skip(&mut cursor);
            }
            content.skipped += cursor.at - from;
        }
    }
    if content.streams.is_empty() {
        return Err(ReadError::content(path, "a stream", "none", todo));
    }
    content.incomplete |= content.streams.iter().any(|stream| !stream.has_footer);
    Ok(content)
}

/// The next chunk: its tag, its content, and whether the file ends within it. `None` where there is no chunk.
fn chunk<'a>(cursor: &mut Cursor<'a>) -> Option<(u16, &'a [u8], bool)> {
    let length = cursor.length()?.checked_sub(2)?;
    let tag = u16::try_from(cursor.unsigned(2)?).ok()?;
    if !(FILE_HEADER..=STREAM_FOOTER).contains(&tag) {
        return None;
    }
    if tag == BOUNDARY && length != BOUNDARY_MARK.len() {
        return None;
    }
    match cursor.take(length) {
        Some(body) => Some((tag, body, false)),
        None => {
            let rest = cursor.bytes.get(cursor.at..).unwrap_or_default();
            cursor.at = cursor.bytes.len();
            Some((tag, rest, true))
        }
    }
}

/// Where the chunk at `from` ends, which has an unknown tag: its length holds where another chunk or the end of the file follows.
fn behind_unknown(bytes: &[u8], from: usize) -> Option<usize> {
    let mut cursor = Cursor { bytes, at: from };
    let length = cursor.length()?.checked_sub(2)?;
    cursor.unsigned(2)?;
    cursor.take(length)?;
    let end = cursor.at;
    (end == bytes.len() || chunk(&mut cursor).is_some()).then_some(end)
}

/// Goes on behind the next boundary; the number of bytes up to there.
fn skip(cursor: &mut Cursor<'_>) -> usize {
    let from = cursor.at;
    let rest = cursor.bytes.get(from..).unwrap_or_default();
    let mark = BOUNDARY_MARK.len();
    let found = rest
        .windows(mark)
        .position(|window| window == BOUNDARY_MARK);
    cursor.at = found.map_or(cursor.bytes.len(), |at| from + at + mark);
    cursor.at - from
}

/// The text of the element at `names`, one within the other.
fn text_at<'d>(node: Node<'d, 'd>, names: &[&str]) -> Option<&'d str> {
    let mut node = node;
    for name in names {
        node = node.children().find(|child| child.has_tag_name(*name))?;
    }
    node.text().map(str::trim).filter(|text| !text.is_empty())
}

fn header(path: &Path, body: &[u8], most_channels: usize) -> Result<Stored, ReadError> {
    let wrong = |expected: &str, found: String| {
        ReadError::content(
            path,
            expected,
            found,
            "copy the file again, or record it again with LabRecorder",
        )
    };
    let mut cursor = Cursor { bytes: body, at: 0 };
    let id = cursor.unsigned(4).and_then(|id| u32::try_from(id).ok());
    let id = id.ok_or_else(|| wrong("the number of a stream", "the end of its header".into()))?;
    let text = String::from_utf8_lossy(body.get(4..).unwrap_or_default());
    let parsed = Document::parse(text.trim_end_matches('\0'));
    let document =
        parsed.map_err(|error| wrong("the header of a stream in XML", format!("{error}")))?;
    let info = document.root_element();
    let required = |name: &str| {
        text_at(info, &[name]).ok_or_else(|| {
            wrong(
                "name, channel_count, nominal_srate and channel_format in the header of a stream",
                format!("no {name}"),
            )
        })
    };
    let count = required("channel_count")?;
    // A sample has a byte of each channel at least.
    let channels: usize = count
        .parse()
        .ok()
        .filter(|n| *n <= most_channels)
        .ok_or_else(|| {
            wrong(
                "a number of channels that the file can hold",
                format!("`{count}`"),
            )
        })?;
    let rate = required("nominal_srate")?;
    let rate_hz = rate.parse().ok().filter(|hz| (0.0..=1e7).contains(hz));
    let rate_hz = rate_hz.ok_or_else(|| wrong("a rate from 0 to 1e7 Hz", format!("`{rate}`")))?;
    let number = match required("channel_format")? {
        "float32" => Some(Number::F32),
        "double64" => Some(Number::F64),
        "int8" => Some(Number::I8),
        "int16" => Some(Number::I16),
        "int32" => Some(Number::I32),
        "int64" => Some(Number::I64),
        "string" => None,
        other => {
            return Err(wrong(
                "a channel format of XDF 1.0",
                format!("`{}`", other.escape_debug()),
            ));
        }
    };
    let drops = text_at(info, &["desc", "synchronization", "can_drop_samples"]);
    let header = Header {
        name: text_at(info, &["name"]).unwrap_or_default().to_owned(),
        kind: text_at(info, &["type"]).unwrap_or_default().to_owned(),
        host: text_at(info, &["hostname"]).unwrap_or_default().to_owned(),
        rate_hz,
        spacing: match drops.is_some_and(|text| text.eq_ignore_ascii_case("true")) {
            true => Spacing::WithLosses,
            false => Spacing::Even,
        },
        number,
        channels,
    };
    let (values, factors) = match number {
        None => (XdfValues::Texts(Vec::new()), Vec::new()),
        Some(_) => {
            let (channels, factors) = described(info, channels);
            (XdfValues::Numbers(channels), factors)
        }
    };
    Ok(Stored {
        id,
        header,
        time_s: Vec::new(),
        values,
        factors,
        clock_offsets: Vec::new(),
        footer_count: None,
        has_footer: false,
        last_s: 0.0,
    })
}

/// The channels that a header describes, and their factors to SI.
fn described(info: Node<'_, '_>, count: usize) -> (Vec<Channel>, Vec<f64>) {
    let child = |node: Node<'_, '_>, name: &str| {
        let found = node.children().find(|child| child.has_tag_name(name));
        found
            .and_then(|child| child.text())
            .unwrap_or_default()
            .trim()
            .to_owned()
    };
    let list = info.children().find(|node| node.has_tag_name("desc"));
    let list = list.and_then(|desc| desc.children().find(|node| node.has_tag_name("channels")));
    let known: Vec<(String, String)> = list.map_or_else(Vec::new, |list| {
        let each = list.children().filter(|node| node.has_tag_name("channel"));
        each.map(|node| (child(node, "label"), child(node, "unit")))
            .collect()
    });
    let mut names: Vec<String> = (0..count)
        .map(|k| match known.get(k) {
            Some((label, _)) if !label.is_empty() => label.clone(),
            _ => format!("channel {}", k + 1),
        })
        .collect();
    let _renamed = unique_names(&mut names);
    names
        .into_iter()
        .enumerate()
        .map(|(k, name)| {
            let unit = known
                .get(k)
                .map(|(_, unit)| unit.as_str())
                .unwrap_or_default();
            // The names of units that the specification of LSL uses.
            let (unit, factor) = eeg_unit(match unit {
                "microvolts" | "microvolt" => "uV",
                "millivolts" | "millivolt" => "mV",
                "volts" | "volt" => "V",
                other => other,
            });
            let samples = Vec::new();
            (
                Channel {
                    name,
                    unit,
                    samples,
                },
                factor,
            )
        })
        .unzip()
}

/// Adds the samples of a chunk; whether it held as many as it states. Those before a damaged one are kept.
fn samples(stream: &mut Stored, body: &mut Cursor<'_>) -> bool {
    let Some(count) = body.length() else {
        return false;
    };
    let step_s = match stream.header.rate_hz {
        hz if hz > 0.0 => 1.0 / hz,
        _ => 0.0,
    };
    for _ in 0..count {
        if sample(stream, body, step_s).is_none() {
            return false;
        }
    }
    true
}

fn sample(stream: &mut Stored, body: &mut Cursor<'_>, step_s: f64) -> Option<()> {
    let time_s = match body.byte()? {
        0 => stream.last_s + step_s,
        _ => body.double().filter(|time| time.is_finite())?,
    };
    match (&mut stream.values, stream.header.number) {
        (XdfValues::Numbers(channels), Some(number)) => {
            let width = number.width();
            let row = body.take(width.checked_mul(channels.len())?)?;
            let each = row.chunks_exact(width).zip(&stream.factors);
            for (channel, (bytes, factor)) in channels.iter_mut().zip(each) {
                channel
                    .samples
                    .push(number.value(bytes, ByteOrder::Little) * factor);
            }
        }
        (XdfValues::Texts(texts), _) => {
            let row = (0..stream.header.channels).map(|_| {
                let length = body.length()?;
                Some(String::from_utf8_lossy(body.take(length)?).into_owned())
            });
            texts.push(row.collect::<Option<_>>()?);
        }
        (XdfValues::Numbers(_), None) => return None,
    }
    stream.last_s = time_s;
    stream.time_s.push(time_s);
    Some(())
}

fn offset(stream: &mut Stored, body: &mut Cursor<'_>) -> bool {
    match (body.double(), body.double()) {
        (Some(time), Some(value)) if time.is_finite() && value.is_finite() => {
            stream.clock_offsets.push((time, value));
            true
        }
        _ => false,
    }
}

/// Reads a footer; what cannot be understood in it changes nothing that was read.
fn footer(stream: &mut Stored, body: &Cursor<'_>) {
    let text = String::from_utf8_lossy(body.bytes.get(4..).unwrap_or_default());
    if let Ok(document) = Document::parse(text.trim_end_matches('\0')) {
        let count = text_at(document.root_element(), &["sample_count"]);
        stream.footer_count = count.and_then(|count| count.parse().ok());
    }
}
