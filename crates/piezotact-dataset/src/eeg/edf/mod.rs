//! EDF, EDF+, BDF and BDF+.
//!
//! Sources of the layout: Kemp et al. 1992, *A simple format for exchange of digitized polygraphic recordings*; Kemp & Olivan 2003,
//! *European data format 'plus' (EDF+)*; BioSemi, *BDF*.

mod header;
mod tal;
mod write;

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::Seconds;
use piezotact::recording::{Channel, Losses, RecordingWarning};

pub use write::write_edf;

use super::content::{Content, Line, Marked, Part, Place};
use super::{EegFile, EegKind, eeg_unit, trigger};
use crate::error::ReadError;
use header::{Gaps, Header, Signal, Standard};
use tal::{Annotation, Onset};

/// Whether `head` begins as an EDF file does.
pub(crate) fn looks_like_edf(head: &[u8]) -> bool {
    head.starts_with(b"0       ") && has_counts(head)
}

/// Whether `head` begins as a BDF file does.
pub(crate) fn looks_like_bdf(head: &[u8]) -> bool {
    head.starts_with(b"\xFFBIOSEMI")
}

/// Whether a size of the header stands where EDF has it: no other text does.
fn has_counts(head: &[u8]) -> bool {
    let number = |from: usize, to: usize| {
        let text = head.get(from..to).map(<[u8]>::trim_ascii);
        text.is_some_and(|text| !text.is_empty() && text.iter().all(u8::is_ascii_digit))
    };
    number(184, 192)
}

/// Reads the file at `path`, with `bytes`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<EegFile, ReadError> {
    let (header, mut warnings) = header::parse(path, bytes)?;
    let records: Vec<&[u8]> = bytes
        .get(header.bytes..)
        .unwrap_or_default()
        .chunks_exact(header.record_bytes)
        .take(header.records)
        .collect();
    let (onsets, annotations, unreadable) = annotations_of(&header, &records);
    warnings.extend(unreadable);
    let zero_s = onsets.first().map_or(0.0, |onset| onset.onset_s);
    let (parts, jump) = parts_in(path, &header, &onsets)?;
    warnings.extend(jump);
    let mut events: Vec<Marked> = annotations
        .into_iter()
        .map(|annotation| Marked {
            place: Place::Time(annotation.onset_s - zero_s),
            duration_s: annotation.duration_s,
            kind: annotation.text,
            value: None,
        })
        .collect();
    let mut lines = Vec::new();
    let mut fastest = 0;
    for signal in header.signals.iter().filter(|signal| !signal.annotations) {
        if signal.without_scale.is_none() {
            fastest = fastest.max(signal.per_record);
        }
    }
    for signal in header.signals.iter().filter(|signal| !signal.annotations) {
        let codes = || {
            records
                .iter()
                .flat_map(|record| codes_of(signal, header.width, record))
        };
        if trigger::is_trigger(&signal.label) {
            let found = trigger::events(&signal.label, codes());
            // Places are counted on the fastest channel.
            let ratio = fastest as f64 / signal.per_record as f64;
            events.extend(found.into_iter().map(|event| Marked {
                place: match event.place {
                    Place::Sample(at) => Place::Sample(at * ratio),
                    time @ Place::Time(_) => time,
                },
                ..event
            }));
        }
        if let Some(why) = &signal.without_scale {
            let what = format!("`{}` is left out: {why}", signal.label);
            warnings.push(Warning::from(RecordingWarning::Guessed { what }));
            continue;
        }
        let (unit, factor) = eeg_unit(&signal.dimension);
        let (gain, offset) = signal.scale();
        let outside = codes().filter(|code| !signal.holds(*code)).count();
        // Codes of triggers are no amplitudes.
        if outside > 0 && !trigger::is_trigger(&signal.label) {
            warnings.push(Warning::from(RecordingWarning::OutsideRange {
                channel: signal.label.clone(),
                samples: outside,
                of: codes().count(),
            }));
        }
        let samples = codes()
            .map(|code| (f64::from(code) * gain + offset) * factor)
            .collect();
        lines.push(Line {
            channel: Channel {
                name: signal.label.clone(),
                unit,
                samples,
            },
            rate: header.rate_of(path, signal)?,
            per_unit: signal.per_record,
            stated_unit: signal.dimension.clone(),
        });
    }
    // In the order of time, as MNE has annotations.
    let time_of = |event: &Marked| match event.place {
        Place::Time(time_s) => time_s,
        Place::Sample(sample) => sample * header.record_s / fastest.max(1) as f64,
    };
    events.sort_by(|a, b| time_of(a).total_cmp(&time_of(b)));
    if header.stopped {
        let read_s = header.record_s * header.records as f64;
        warnings.push(Warning::from(RecordingWarning::Interrupted { read_s }));
    }
    let losses = Losses {
        is_interrupted: header.stopped || header.is_cut,
        ..Losses::default()
    };
    Content {
        losses,
        kind: kind_of(&header),
        lines,
        parts,
        events,
        started_at: header.started_at.map(|at| at.later(Seconds(zero_s))),
        warnings,
        bench: header.bench,
    }
    .into_file(path)
}

/// The parts without gaps, and a warning where the file states that there is one part and there are more.
fn parts_in(
    path: &Path,
    header: &Header,
    onsets: &[Onset],
) -> Result<(Vec<Part>, Option<Warning>), ReadError> {
    if header.gaps == Gaps::Stated {
        return Ok((parts_of(path, header, onsets)?, None));
    }
    if jumps(header, onsets) {
        let what = "the file says that it is continuous (EDF+C), but the onsets of its records jump; it is read as one with gaps (EDF+D)";
        let warning = Warning::from(RecordingWarning::Guessed { what: what.into() });
        return Ok((parts_of(path, header, onsets)?, Some(warning)));
    }
    let whole = Part {
        from: 0,
        start_s: 0.0,
    };
    Ok((vec![whole], None))
}

/// Onsets of records may be rounded by so much, s.
const ROUNDED_S: f64 = 0.02;

/// The equipment of a recording that no person took part in.
const TWIN: &str = "piezotact_digital_twin";

fn kind_of(header: &Header) -> EegKind {
    match (header.width, header.standard, header.gaps) {
        (2, Standard::Original, _) => EegKind::Edf,
        (2, Standard::Plus, Gaps::None) => EegKind::EdfPlus,
        (2, Standard::Plus, Gaps::Stated) => EegKind::EdfPlusGaps,
        (_, Standard::Original, _) => EegKind::Bdf,
        (_, Standard::Plus, Gaps::None) => EegKind::BdfPlus,
        (_, Standard::Plus, Gaps::Stated) => EegKind::BdfPlusGaps,
    }
}

/// The codes of a signal in one record.
fn codes_of<'r>(signal: &Signal, width: usize, record: &'r [u8]) -> impl Iterator<Item = i32> + 'r {
    let own = record.get(signal.at..signal.at + signal.per_record * width);
    own.unwrap_or_default()
        .chunks_exact(width)
        .map(|bytes| match *bytes {
            [a, b] => i16::from_le_bytes([a, b]).into(),
            // The sign of the third byte is that of the whole.
            [a, b, c] => i32::from_le_bytes([0, a, b, c]) >> 8,
            _ => 0,
        })
}

/// The onset of each record, and all annotations, in the order of the file; a warning about those that cannot be read.
fn annotations_of(
    header: &Header,
    records: &[&[u8]],
) -> (Vec<Onset>, Vec<Annotation>, Option<Warning>) {
    let channels: Vec<&Signal> = header.signals.iter().filter(|s| s.annotations).collect();
    let (mut onsets, mut annotations) = (Vec::new(), Vec::new());
    let mut unreadable = 0;
    let mut first = None;
    if header.standard == Standard::Original {
        return (onsets, annotations, None);
    }
    for (number, record) in records.iter().enumerate() {
        for (k, channel) in channels.iter().enumerate() {
            let own = record.get(channel.at..channel.at + channel.per_record * header.width);
            let found = tal::parse(own.unwrap_or_default());
            unreadable += found.unreadable.len();
            let why = found.unreadable.into_iter().next();
            first = first.or(why.map(|why| format!("{why} in record {}", number + 1)));
            // The first annotation of the first annotation channel is the onset of the record.
            if k == 0
                && let Some(onset) = found.first_onset
            {
                onsets.push(Onset {
                    record: number,
                    onset_s: onset,
                });
            }
            annotations.extend(found.annotations);
        }
    }
    let warning = first.map(|first| {
        let what = format!(
            "{unreadable} annotation(s) cannot be read, and are left out: the first has {first} where a number such as `+1.5` is expected"
        );
        Warning::from(RecordingWarning::Guessed { what })
    });
    (onsets, annotations, warning)
}

/// Whether the onsets of records of a continuous file are off by more than they are rounded.
fn jumps(header: &Header, onsets: &[Onset]) -> bool {
    let zero_s = onsets.first().map_or(0.0, |onset| onset.onset_s);
    let complete = onsets.len() == header.records;
    complete
        && onsets.iter().any(|onset| {
            let expected_s = zero_s + onset.record as f64 * header.record_s;
            (onset.onset_s - expected_s).abs() > ROUNDED_S
        })
}

/// The parts of a file whose records have onsets of their own.
fn parts_of(path: &Path, header: &Header, onsets: &[Onset]) -> Result<Vec<Part>, ReadError> {
    let fastest = header.signals.iter().filter(|s| !s.annotations);
    let per_record = fastest.map(|s| s.per_record).max().unwrap_or(1).max(1);
    let half_sample_s = 0.5 * header.record_s / per_record as f64;
    let complete = onsets.len() == header.records
        && onsets
            .iter()
            .enumerate()
            .all(|(k, onset)| onset.record == k);
    if !complete {
        return Err(ReadError::content(
            path,
            "the onset of each record of a discontinuous file (EDF+D)",
            format!("{} onsets for {} records", onsets.len(), header.records),
            "copy the file again, or export it as EDF+C",
        ));
    }
    let zero_s = onsets.first().map_or(0.0, |onset| onset.onset_s);
    let mut parts: Vec<Part> = Vec::new();
    let mut ends_s = f64::NEG_INFINITY;
    for (number, onset) in onsets.iter().enumerate() {
        let start_s = onset.onset_s - zero_s;
        if start_s < ends_s - half_sample_s {
            return Err(ReadError::content(
                path,
                format!(
                    "records in the order of time: record {} from {ends_s} s on",
                    number + 1
                ),
                format!("an onset of {start_s} s"),
                "copy the file again, or export it as EDF+C",
            ));
        }
        // Onsets are rounded when they are written: less than half a sample is no gap.
        if start_s > ends_s + half_sample_s {
            parts.push(Part {
                from: number,
                start_s,
            });
        }
        let from = parts
            .last()
            .map_or((0, 0.0), |part| (part.from, part.start_s));
        ends_s = from.1 + (number + 1 - from.0) as f64 * header.record_s;
    }
    Ok(parts)
}
