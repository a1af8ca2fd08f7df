//! `BrainVision` recordings: a header (`.vhdr`), markers (`.vmrk`) and samples (`.eeg`).
//!
//! Source of the layout: Brain Products, *BrainVision Core Data Format 1.0*, and the header of version 2.0 of BrainVision Analyzer.

use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::recording::{BenchKind, Channel, EventValue, Losses, RecordingWarning, StartTime};

use super::brainvision_samples::{other_orientation, points_of, samples_of};
use super::brainvision_write::SIMULATED;
use super::content::{Content, Line, Marked, Part, Place};
use super::ini::{section, text_of, value};
use super::{EegFile, EegKind, eeg_unit, in_folder_of};
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// No recording was cut into more segments.
const MOST_SEGMENTS: usize = 20_000;
/// No recording has more channels.
const MOST_CHANNELS: usize = 100_000;

/// Whether `head` begins as a header of version 1 or 2.
pub(crate) fn looks_like_brainvision(head: &[u8]) -> bool {
    begins(head, "header file")
}

/// Whether `head` begins as a file of markers.
pub(crate) fn looks_like_markers(head: &[u8]) -> bool {
    begins(head, "marker file")
}

fn begins(head: &[u8], kind: &str) -> bool {
    let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let line = head.split(|byte| matches!(byte, b'\r' | b'\n')).next();
    let line = String::from_utf8_lossy(line.unwrap_or_default()).to_ascii_lowercase();
    ["brain vision data exchange ", "brainvision data exchange "]
        .iter()
        .any(|title| {
            line.strip_prefix(title)
                .is_some_and(|l| l.starts_with(kind))
        })
}

/// A channel as the header describes it.
pub(super) struct Described {
    name: String,
    resolution: f64,
    unit: String,
}

/// What the header says.
pub(super) struct Header {
    pub(super) data: PathBuf,
    markers: Option<PathBuf>,
    pub(super) format: Stored,
    pub(super) order: ByteOrder,
    pub(super) multiplexed: bool,
    pub(super) rate: SampleRate,
    /// The number of samples of a channel, where it is stated.
    pub(super) points: Option<usize>,
    /// The samples of a segment, where the recording was cut around markers.
    segment_points: Option<usize>,
    pub(super) channels: Vec<Described>,
}

/// The files of samples and markers that the header at `path`, with `bytes`, names.
pub(super) fn named(path: &Path, bytes: &[u8]) -> Vec<PathBuf> {
    let text = text_of(bytes);
    let common = section(&text, "Common Infos");
    let files = ["DataFile", "MarkerFile"].into_iter();
    let files = files.filter_map(|key| value(&common, key));
    let own = path.file_stem().unwrap_or_default().to_string_lossy();
    files
        .map(|name| in_folder_of(path, &name.replace("$b", &own)))
        .collect()
}

/// Reads the recording whose header is at `path`, with `bytes`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<EegFile, ReadError> {
    let text = text_of(bytes);
    let header = header_of(path, &text)?;
    let is_simulated = text
        .lines()
        .any(|line| line.strip_prefix("; ") == Some(SIMULATED));
    let stored = crate::input::read_input(&header.data)
        .map_err(|_unreadable| missing(path, "DataFile", &header.data))?;
    let (points, cut) = points_of(path, &header, stored.len())?;
    let (markers, unreadable) = match &header.markers {
        Some(file) => {
            let bytes = crate::input::read_input(file)
                .map_err(|_unreadable| missing(path, "MarkerFile", file))?;
            markers_of(file, &text_of(&bytes))
        }
        None => (Vec::new(), None),
    };
    // Where the channels of vectorized data begin depends on how many samples there are.
    if header.points.is_none()
        && !header.multiplexed
        && let Some(beyond) = markers.iter().find(|marker| marker.sample >= points)
    {
        return Err(ReadError::content(
            &header.data,
            format!(
                "samples up to the marker at data point {}",
                beyond.sample + 1
            ),
            format!("{points} samples of each channel: the file was cut short"),
            format!(
                "copy it again; if it is complete, state `DataPoints={points}` in the [Common Infos] of the header"
            ),
        ));
    }
    let (parts, started_at, mut warnings) = parts_of(&markers, header.rate, points);
    if header.points.is_none() && !header.multiplexed && header.channels.len() > 1 {
        let what = format!(
            "the header does not state DataPoints: the file is read as {points} whole samples of each channel, one channel after the other; if it was cut \
             short, all channels but the first are wrong"
        );
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    warnings.extend(unreadable);
    warnings.extend(cut.clone());
    warnings.extend(other_orientation(&header, &stored, points));
    let parts = match header.segment_points {
        Some(each) if parts.len() == 1 && points / each > MOST_SEGMENTS => {
            return Err(ReadError::content(
                path,
                format!("SegmentDataPoints that gives at most {MOST_SEGMENTS} segments"),
                format!("{each} samples in each of {} segments", points / each),
                "correct the header, or export the recording without segments",
            ));
        }
        Some(each) if parts.len() == 1 && each < points => {
            let what = format!(
                "the header says that the recording was cut into segments of {each} samples, and not when each began; their starts are counted as if nothing lay between"
            );
            warnings.push(Warning::from(RecordingWarning::Guessed { what }));
            let starts = (0..points).step_by(each);
            let part = |from: usize| Part {
                from,
                start_s: header.rate.duration_of(from).0,
            };
            starts.map(part).collect()
        }
        _ => parts,
    };
    let mut lines = Vec::with_capacity(header.channels.len());
    let all = samples_of(&header, &stored, points);
    for (described, samples) in header.channels.iter().zip(all) {
        let (unit, factor) = eeg_unit(&described.unit);
        let scale = described.resolution * factor;
        lines.push(Line {
            channel: Channel {
                name: described.name.clone(),
                unit,
                samples: samples.into_iter().map(|code| code * scale).collect(),
            },
            rate: header.rate,
            per_unit: 1,
            stated_unit: described.unit.clone(),
        });
    }
    drop(stored);
    let events = markers
        .into_iter()
        .map(|marker| Marked {
            place: Place::Sample(marker.sample as f64),
            duration_s: marker.size as f64 / header.rate.hz(),
            kind: marker.kind,
            value: Some(marker.description)
                .filter(|text| !text.is_empty())
                .map(EventValue::Text),
        })
        .collect();
    Content {
        losses: Losses {
            is_interrupted: cut.is_some(),
            ..Losses::default()
        },
        kind: EegKind::BrainVision,
        lines,
        parts,
        events,
        started_at,
        warnings,
        bench: is_simulated.then_some(BenchKind::Twin),
    }
    .into_file(path)
}

fn missing(path: &Path, key: &str, file: &Path) -> ReadError {
    ReadError::content(
        path,
        format!("the file that {key} names, {}", file.display()),
        "none there, or one that cannot be read",
        format!("put it beside the header, or correct {key}"),
    )
}

fn header_of(path: &Path, text: &str) -> Result<Header, ReadError> {
    let todo = "correct the header, or export the recording again";
    let wrong = |expected: String, found: String| ReadError::content(path, expected, found, todo);
    let infos = section(text, "Common Infos");
    let required = |key: &str| {
        value(&infos, key).ok_or_else(|| wrong(format!("`{key}` in [Common Infos]"), "none".into()))
    };
    let one_of = |key, found, all: &[&str]| {
        word_of(found, all).ok_or_else(|| {
            wrong(
                format!("{key} to be {}", all.join(" or ")),
                format!("`{}`", short(found)),
            )
        })
    };
    if let Some(format) = value(&infos, "DataFormat") {
        if format.eq_ignore_ascii_case("ASCII") {
            return Err(ReadError::content(
                path,
                "binary samples (DataFormat=BINARY)",
                "samples as text (DataFormat=ASCII), which are not read",
                "export the recording as binary (IEEE_FLOAT_32), or as EDF",
            ));
        }
        one_of("DataFormat", format, &["BINARY"])?;
    }
    if let Some(domain) = value(&infos, "DataType") {
        one_of("DataType", domain, &["TIMEDOMAIN"])?;
    }
    let multiplexed = match value(&infos, "DataOrientation") {
        Some(found) => one_of("DataOrientation", found, &["MULTIPLEXED", "VECTORIZED"])? == 0,
        None => true,
    };
    let binary = section(text, "Binary Infos");
    let format = value(&binary, "BinaryFormat")
        .ok_or_else(|| wrong("`BinaryFormat` in [Binary Infos]".into(), "none".into()))?;
    let formats = ["INT_16", "IEEE_FLOAT_32", "INT_32", "UINT_16"];
    let format = match one_of("BinaryFormat", format, &formats)? {
        0 => Stored::I16,
        1 => Stored::F32,
        2 => Stored::I32,
        _ => Stored::U16,
    };
    let order = match value(&binary, "UseBigEndianOrder") {
        Some(found) if one_of("UseBigEndianOrder", found, &["NO", "YES"])? == 1 => ByteOrder::Big,
        _ => ByteOrder::Little,
    };
    let count = whole(required("NumberOfChannels")?)
        .filter(|count| (1..=MOST_CHANNELS).contains(count))
        .ok_or_else(|| {
            wrong(
                format!("NumberOfChannels to be a number from 1 to {MOST_CHANNELS}"),
                format!(
                    "`{}`",
                    short(required("NumberOfChannels").unwrap_or_default())
                ),
            )
        })?;
    let interval = required("SamplingInterval")?;
    let interval_us = decimal(interval).filter(|us| *us > 0.0).ok_or_else(|| {
        wrong(
            "SamplingInterval to be a number of µs above zero".into(),
            format!("`{}`", short(interval)),
        )
    })?;
    let rate = SampleRate::new(1e6 / interval_us).map_err(ReadError::of(path))?;
    let points = match value(&infos, "DataPoints") {
        Some(found) => Some(whole(found).ok_or_else(|| {
            wrong(
                "DataPoints to be a whole number".into(),
                format!("`{}`", short(found)),
            )
        })?),
        None => None,
    };
    let named = |key: &str, name: &str| {
        file_beside(path, name).map_err(|name| {
            wrong(
                format!("{key} to name a file in the folder of the header"),
                format!("`{}`", short(&name)),
            )
        })
    };
    if value(&infos, "Averaged").is_some_and(|text| text.eq_ignore_ascii_case("YES")) {
        return Err(wrong(
            "a recording (Averaged=NO)".into(),
            "averages (Averaged=YES): epochs cannot be cut from them".into(),
        ));
    }
    let cut = value(&infos, "SegmentationType");
    let is_cut = cut.is_some_and(|text| !text.eq_ignore_ascii_case("NOTSEGMENTED"));
    let segment_points = value(&infos, "SegmentDataPoints").and_then(whole);
    let segment_points = segment_points.filter(|each| is_cut && *each > 0);
    Ok(Header {
        segment_points,
        data: named("DataFile", required("DataFile")?)?,
        markers: match value(&infos, "MarkerFile") {
            Some(name) => Some(named("MarkerFile", name)?),
            None => None,
        },
        format,
        order,
        multiplexed,
        rate,
        points,
        channels: channels_of(path, text, count)?,
    })
}

/// Which of `words` is `found`, in capital or small letters.
fn word_of(found: &str, words: &[&str]) -> Option<usize> {
    let mut words = words.iter();
    words.position(|word| found.eq_ignore_ascii_case(word))
}

/// The file with `name` in the folder of the header at `path`; else the name, which is not one of a file there.
fn file_beside(path: &Path, name: &str) -> Result<PathBuf, String> {
    let own = path.file_stem().unwrap_or_default().to_string_lossy();
    // The variable of BrainVision for the name of the header.
    let name = name.replace("$b", &own);
    match Path::new(&name).file_name() {
        Some(file) if file.to_str() == Some(&name) => Ok(in_folder_of(path, &name)),
        _ => Err(name),
    }
}

/// The channels of [Channel Infos], which have to be as many as are stated.
fn channels_of(path: &Path, text: &str, count: usize) -> Result<Vec<Described>, ReadError> {
    let wrong = |expected: String, found: String| {
        ReadError::content(
            path,
            expected,
            found,
            "correct the header, or export the recording again",
        )
    };
    let infos = section(text, "Channel Infos");
    if infos.len() != count {
        return Err(wrong(
            format!("{count} channels in [Channel Infos], as NumberOfChannels states"),
            format!("{}", infos.len()),
        ));
    }
    let mut channels: Vec<Option<Described>> = (0..count).map(|_| None).collect();
    for (key, entry) in infos {
        let number = key.get(..2).filter(|ch| ch.eq_ignore_ascii_case("ch"));
        let number = number.and_then(|_| whole(key.get(2..)?));
        let place = number
            .and_then(|number| channels.get_mut(number.checked_sub(1)?))
            .filter(|place| place.is_none())
            .ok_or_else(|| {
                wrong(
                    format!("channels Ch1 to Ch{count}, each once, in [Channel Infos]"),
                    format!("`{}`", short(key)),
                )
            })?;
        let mut fields = entry.split(',');
        let name = fields.next().unwrap_or_default().replace("\\1", ",");
        let (_reference, resolution, unit) = (fields.next(), fields.next(), fields.next());
        let resolution = resolution.map(str::trim).unwrap_or_default();
        let scale = match resolution {
            "" => 1.0,
            text => decimal(text).filter(|scale| *scale != 0.0).ok_or_else(|| {
                wrong(
                    format!("a resolution that is a number other than 0 for {key}"),
                    format!("`{}`", short(text)),
                )
            })?,
        };
        let unit = match unit.map(str::trim) {
            None | Some("") => "µV",
            // Latin-1 programs read the two bytes of µ in UTF-8 as two letters.
            Some(unit) => unit,
        };
        *place = Some(Described {
            name,
            resolution: scale,
            unit: unit.replace('\u{c2}', ""),
        });
    }
    Ok(channels.into_iter().flatten().collect())
}

/// A marker of the `.vmrk` file.
struct Marker {
    kind: String,
    description: String,
    /// From 0.
    sample: usize,
    size: usize,
    date: Option<StartTime>,
}

impl Marker {
    fn begins_segment(&self) -> bool {
        self.kind.eq_ignore_ascii_case("New Segment")
    }
}

/// The markers of `file` with `text`, and a warning about those that cannot be read.
fn markers_of(file: &Path, text: &str) -> (Vec<Marker>, Option<Warning>) {
    let (mut markers, mut unreadable) = (Vec::new(), Vec::new());
    let entries = section(text, "Marker Infos");
    if entries.is_empty() && !text.contains("[Marker Infos]") {
        let what = format!(
            "{} has no section [Marker Infos]: it was cut short, or is no file of markers",
            file.file_name().unwrap_or_default().to_string_lossy()
        );
        return (markers, Some(RecordingWarning::Guessed { what }.into()));
    }
    // Digits may be missing where a file ends within a position.
    let whole = match text.ends_with(['\n', '\r']) {
        true => entries.len(),
        false => entries.len().saturating_sub(1),
    };
    for (at, (key, entry)) in entries.into_iter().enumerate() {
        match marker_of(key, entry) {
            Ok(_) if at >= whole && entry.matches(',').count() < 3 => {
                unreadable.push(format!(
                    "the file ends within `{}={}`",
                    short(key),
                    short(entry)
                ));
            }
            Ok(marker) => markers.push(marker),
            Err(expected) => unreadable.push(format!(
                "`{}={}` has no {expected}",
                short(key),
                short(entry)
            )),
        }
    }
    let warning = unreadable.first().map(|first| {
        let what = format!(
            "{} marker(s) cannot be read, and are left out: {first}",
            unreadable.len()
        );
        Warning::from(RecordingWarning::Guessed { what })
    });
    (markers, warning)
}

/// A marker; else what is expected in its place.
fn marker_of(key: &str, entry: &str) -> Result<Marker, &'static str> {
    let numbered = key.get(..2).is_some_and(|mk| mk.eq_ignore_ascii_case("mk"));
    let fields: Vec<&str> = entry.split(',').collect();
    let (&[kind, description, position, ..], true) = (fields.as_slice(), numbered) else {
        return Err("fields such as those of `Mk1=Stimulus,S  1,487,1,0`");
    };
    let sample = whole(position).and_then(|at| at.checked_sub(1));
    let size = match fields.get(3).map_or("", |size| size.trim()) {
        "" => Some(0),
        size => whole(size),
    };
    Ok(Marker {
        kind: kind.replace("\\1", ","),
        description: description.replace("\\1", ","),
        sample: sample.ok_or("position in data points from 1 on")?,
        size: size.ok_or("size in data points")?,
        date: fields.get(5).and_then(|date| date_of(date)),
    })
}

/// The parts between the markers of new segments that are gaps, and the time of the first sample.
fn parts_of(
    markers: &[Marker],
    rate: SampleRate,
    points: usize,
) -> (Vec<Part>, Option<StartTime>, Vec<Warning>) {
    let first = Part {
        from: 0,
        start_s: 0.0,
    };
    let mut parts = vec![first];
    let (mut backwards, mut undated) = (Vec::new(), Vec::new());
    let mut starts: Vec<&Marker> = markers.iter().filter(|m| m.begins_segment()).collect();
    starts.sort_by_key(|marker| marker.sample);
    let started_at = starts
        .iter()
        .find(|marker| marker.sample == 0)
        .and_then(|marker| marker.date.clone());
    // The newest start with a date: where it is in the file, and when.
    let mut known = started_at.clone().map(|at| (0_usize, 0.0_f64, at));
    for marker in starts
        .into_iter()
        .filter(|m| 0 < m.sample && m.sample < points)
    {
        let last = parts.last().copied().unwrap_or(first);
        let expected_s = last.start_s + rate.duration_of(marker.sample - last.from).0;
        let (start_s, gap) = match (&known, &marker.date) {
            (Some((_, known_s, at)), Some(date)) => {
                let start_s = known_s + date.seconds_since(at).0;
                // A date that differs by less than a sample, or that lies before the end of what was recorded, is no pause.
                (start_s, (start_s - expected_s) * rate.hz() > 1.0)
            }
            _ => (expected_s, true),
        };
        if !gap {
            if (start_s - expected_s) * rate.hz() < -1.0 {
                backwards.push(marker.sample);
            }
            continue;
        }
        if known.is_none() || marker.date.is_none() {
            undated.push(marker.sample);
        }
        if let Some(date) = &marker.date {
            known = Some((marker.sample, start_s, date.clone()));
        }
        parts.push(Part {
            from: marker.sample,
            start_s,
        });
    }
    // One warning for all segments of a kind: a recording may have thousands.
    let guessed = |samples: &[usize], what: &str| {
        let first = samples.first()?;
        let of = match samples.len() {
            1 => format!("the new segment at sample {first}"),
            count => format!("{count} new segments, the first at sample {first}"),
        };
        let what = format!("{of}: {what}");
        Some(Warning::from(RecordingWarning::Guessed { what }))
    };
    let warnings = [
        guessed(
            &backwards,
            "the date lies before the end of the samples that precede it, so it is read as their continuation",
        ),
        guessed(
            &undated,
            "the file does not say how long the recording paused before it, so its start is counted as if it had not",
        ),
    ];
    (parts, started_at, warnings.into_iter().flatten().collect())
}

/// The date of a marker, `YYYYMMDDhhmmssuuuuuu`; `None` where it is none, or all zeros.
fn date_of(text: &str) -> Option<StartTime> {
    let text = text.trim();
    if text.len() != 20 || !text.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let part = |from: usize, to: usize| text.get(from..to);
    let written = format!(
        "{}-{}-{}T{}:{}:{}.{}",
        part(0, 4)?,
        part(4, 6)?,
        part(6, 8)?,
        part(8, 10)?,
        part(10, 12)?,
        part(12, 14)?,
        part(14, 20)?
    );
    StartTime::try_from(written).ok()
}

fn whole(text: &str) -> Option<usize> {
    text.trim().parse().ok()
}

/// A number, with either decimal sign.
fn decimal(text: &str) -> Option<f64> {
    let number: f64 = text.trim().replace(',', ".").parse().ok()?;
    number.is_finite().then_some(number)
}

/// At most 40 characters of what was found, without control characters.
fn short(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}
