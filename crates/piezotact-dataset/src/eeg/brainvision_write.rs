//! Writes `BrainVision` recordings: 32-bit floating point, multiplexed, UTF-8.

use std::io::Write;
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::Unit;
use piezotact::recording::{BenchKind, EventValue, Recording, RecordingWarning, StartTime};

use crate::atomic::{Prepared, led_to};
use crate::error::WriteError;

/// A marker of a `BrainVision` recording. Markers stand on samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EegMarker {
    /// The type: `Stimulus`, `Response`, `Comment`, …
    pub kind: String,
    /// The description: `S  1`; may be empty.
    pub description: String,
    /// The sample, from 0.
    pub sample: usize,
    /// How many samples it lasts; 0 or 1 for a moment.
    pub samples: usize,
}

/// The events of `recording` as markers on the nearest sample of its first channel. Events before its first or after its last sample
/// are left out. An event with a text or a number is a marker of its kind that describes it; another one is a `Comment`.
#[must_use]
pub fn markers_of(recording: &Recording) -> Vec<EegMarker> {
    let rate_hz = recording.rate().hz();
    let events = recording.annotations.events.iter();
    let markers = events.filter_map(|event| {
        let sample = (event.onset_s.0 * rate_hz).round_ties_even();
        if !(0.0..recording.len() as f64).contains(&sample) {
            return None;
        }
        let (kind, description) = match &event.value {
            Some(EventValue::Text(text)) => (event.kind.clone(), text.clone()),
            Some(EventValue::Number(number)) => (event.kind.clone(), number.to_string()),
            // A start in the file is written from the recording itself.
            None if event.kind == NEW_SEGMENT && sample > 0.0 => {
                (event.kind.clone(), String::new())
            }
            None if event.kind == NEW_SEGMENT => return None,
            None => ("Comment".to_owned(), event.kind.clone()),
        };
        Some(EegMarker {
            kind,
            description,
            sample: sample as usize,
            samples: (event.duration_s.0 * rate_hz).round_ties_even() as usize,
        })
    });
    markers.collect()
}

/// The comment in the header of a recording that no person took part in.
pub(super) const SIMULATED: &str = "Simulated by the digital twin of piezotact";

/// The type of the markers at which a segment begins.
const NEW_SEGMENT: &str = "New Segment";

/// Writes `recording` as `path` (`.vhdr`) with its samples (`.eeg`) and `markers` (`.vmrk`) beside it: 32-bit floating point,
/// multiplexed, volts in µV. All three files are complete on the disk before one of them gets its name, and the header, without which
/// nothing can be read, gets it last. Returns warnings about what the files do not carry.
///
/// # Errors
/// [`WriteError`] when a file cannot be written, the channels have more than one clock, a sample does not fit into 32 bits, a marker
/// is outside the recording, or a name holds a line break.
pub fn write_brainvision(
    path: &Path,
    recording: &Recording,
    markers: &[EegMarker],
) -> Result<Vec<Warning>, WriteError> {
    let refuse = |expected: &str, found: String, todo: &str| {
        Err(WriteError::content(path, expected, found, todo))
    };
    if path
        .extension()
        .is_none_or(|ending| !ending.eq_ignore_ascii_case("vhdr"))
    {
        return refuse(
            "a name that ends with .vhdr",
            format!("`{}`", path.display()),
            "give the name of the header",
        );
    }
    if recording.clocks().len() > 1 {
        return refuse(
            "channels of one clock",
            format!("{} clocks", recording.clocks().len()),
            "write each group to a file of its own, or all of them as EDF",
        );
    }
    if recording.is_empty() {
        return refuse(
            "samples in every channel",
            "none".into(),
            "leave that channel out",
        );
    }
    let (data, marks) = (path.with_extension("eeg"), path.with_extension("vmrk"));
    let scaled = scales(path, recording)?;
    let header_text = header(path, recording, &scaled, &data, &marks)?;
    let marker_text = marker_file(path, recording, markers, &data)?;
    let samples = Prepared::new(&data, |out| {
        let mut frame = Vec::with_capacity(4 * scaled.len());
        for at in 0..recording.len() {
            frame.clear();
            for (channel, (_, factor)) in recording.channels().iter().zip(&scaled) {
                let value = (channel.samples[at] * factor) as f32;
                frame.extend(value.to_le_bytes());
            }
            out.write_all(&frame).map_err(WriteError::io(&data))?;
        }
        Ok(())
    })?;
    let text = |place: &Path, text: String| {
        Prepared::new(place, move |out| {
            out.write_all(text.as_bytes())
                .map_err(WriteError::io(place))
        })
    };
    let marked = text(&marks, marker_text)?;
    let headed = text(path, header_text)?;
    // An older header does not describe the new samples: it goes before they come.
    let older = led_to(path);
    if older.is_file() {
        std::fs::remove_file(&older).map_err(WriteError::io(path))?;
    }
    samples.commit()?;
    marked.commit()?;
    headed.commit()?;
    Ok(vec![Warning::from(RecordingWarning::FormatLoses {
        format: "BrainVision".into(),
        what: "the condition, the labels, the provenance and the warnings of a recording, times of events between two samples, the time zone, nor samples in more than 32 bits".into(),
    })])
}

/// The unit of each channel in the file, and the factor to it.
fn scales(path: &Path, recording: &Recording) -> Result<Vec<(String, f64)>, WriteError> {
    let each = recording.channels().iter().map(|channel| {
        let (unit, factor) = match &channel.unit {
            Unit::Volt => ("µV".to_owned(), 1e6),
            Unit::Other(text) if text.is_empty() => ("n/a".to_owned(), 1.0),
            other => (other.symbol().to_owned(), 1.0),
        };
        let fits = |value: &f64| value.is_finite() && ((value * factor) as f32).is_finite();
        match channel.samples.iter().position(|value| !fits(value)) {
            None => Ok((unit, factor)),
            Some(at) => Err(WriteError::content(
                path,
                "samples within ±3.4e38",
                format!(
                    "{} at sample {at} of `{}`",
                    channel.samples[at], channel.name
                ),
                "cut that part out",
            )),
        }
    });
    each.collect()
}

/// A text of a field: no line break, and commas as the format writes them.
fn field(path: &Path, text: &str, what: &str) -> Result<String, WriteError> {
    if text.chars().any(char::is_control) || text.contains("\\1") || text.trim() != text {
        return Err(WriteError::content(
            path,
            format!("{what} without line breaks, outer spaces or `\\1`"),
            format!("`{}`", text.escape_debug()),
            "rename it",
        ));
    }
    Ok(text.replace(',', "\\1"))
}

/// The name of a file beside the header.
fn name_of(path: &Path, file: &Path) -> Result<String, WriteError> {
    let name = file.file_name().and_then(|name| name.to_str());
    let fits = name.filter(|name| {
        !name.chars().any(char::is_control) && !name.contains("$b") && name.trim() == *name
    });
    fits.map(str::to_owned).ok_or_else(|| {
        WriteError::content(
            path,
            "a name of a file in Unicode, without line breaks or `$b`",
            format!("`{}`", file.display()),
            "give another name",
        )
    })
}

fn header(
    path: &Path,
    recording: &Recording,
    scaled: &[(String, f64)],
    data: &Path,
    marks: &Path,
) -> Result<String, WriteError> {
    let simulated = match recording.about.provenance.bench {
        Some(BenchKind::Twin) => format!("; {SIMULATED}\r\n"),
        _ => String::new(),
    };
    let mut text = format!(
        "Brain Vision Data Exchange Header File Version 1.0\r\n\
         ; Written by piezotact\r\n{simulated}\r\n\
         [Common Infos]\r\n\
         Codepage=UTF-8\r\n\
         DataFile={}\r\n\
         MarkerFile={}\r\n\
         DataFormat=BINARY\r\n\
         ; Data orientation: MULTIPLEXED=ch1,pt1, ch2,pt1 ...\r\n\
         DataOrientation=MULTIPLEXED\r\n\
         DataType=TIMEDOMAIN\r\n\
         NumberOfChannels={}\r\n\
         DataPoints={}\r\n\
         ; Sampling interval in microseconds\r\n\
         SamplingInterval={}\r\n\r\n\
         [Binary Infos]\r\n\
         BinaryFormat=IEEE_FLOAT_32\r\n\r\n\
         [Channel Infos]\r\n\
         ; Each entry: Ch<Channel number>=<Name>,<Reference channel name>,<Resolution in \"Unit\">,<Unit>\r\n",
        name_of(path, data)?,
        name_of(path, marks)?,
        recording.channels().len(),
        recording.len(),
        1e6 / recording.rate().hz(),
    );
    for (k, (channel, (unit, _))) in recording.channels().iter().zip(scaled).enumerate() {
        let name = field(path, &channel.name, "names of channels")?;
        let unit = field(path, unit, "units")?;
        text.push_str(&format!("Ch{}={name},,1,{unit}\r\n", k + 1));
    }
    Ok(text)
}

fn marker_file(
    path: &Path,
    recording: &Recording,
    markers: &[EegMarker],
    data: &Path,
) -> Result<String, WriteError> {
    let mut text = format!(
        "Brain Vision Data Exchange Marker File, Version 1.0\r\n\r\n\
         [Common Infos]\r\n\
         Codepage=UTF-8\r\n\
         DataFile={}\r\n\r\n\
         [Marker Infos]\r\n\
         ; Each entry: Mk<Marker number>=<Type>,<Description>,<Position in data points>,<Size in data points>,<Channel number (0 = all channels)>,<Date (YYYYMMDDhhmmssuuuuuu)>\r\n",
        name_of(path, data)?,
    );
    let start = recording.annotations.started_at.as_ref();
    let date = start.map_or_else(|| "0".repeat(20), date_of);
    text.push_str(&format!("Mk1=New Segment,,1,1,0,{date}\r\n"));
    let mut sorted: Vec<&EegMarker> = markers.iter().collect();
    sorted.sort_by_key(|marker| marker.sample);
    for (k, marker) in sorted.into_iter().enumerate() {
        if marker.sample >= recording.len() || marker.kind.is_empty() {
            return Err(WriteError::content(
                path,
                format!(
                    "markers with a type, on samples 0 to {}",
                    recording.len() - 1
                ),
                format!(
                    "`{}` on sample {}",
                    marker.kind.escape_debug(),
                    marker.sample
                ),
                "correct that marker, or leave it out",
            ));
        }
        text.push_str(&format!(
            "Mk{}={},{},{},{},0\r\n",
            k + 2,
            field(path, &marker.kind, "types of markers")?,
            field(path, &marker.description, "descriptions of markers")?,
            marker.sample + 1,
            marker.samples,
        ));
    }
    Ok(text)
}

/// A start as markers have it, `YYYYMMDDhhmmssuuuuuu`.
fn date_of(start: &StartTime) -> String {
    let text = start.to_string();
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let whole = whole.get(..19).unwrap_or_default();
    let digits = whole.chars().filter(char::is_ascii_digit);
    let fraction = fraction.chars().take_while(char::is_ascii_digit);
    digits
        .chain(fraction.chain("000000".chars()).take(6))
        .collect()
}
