//! Writes EDF+ with annotations.

use std::io::Write;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::counted;
use piezotact::quantity::Unit;
use piezotact::recording::{
    BenchKind, Channel, Clock, Event, EventValue, Recording, RecordingWarning, StartTime,
};

use super::super::eeg_unit;
use super::tal::{DURATION, END};
use crate::atomic::write_atomically;
use crate::error::WriteError;

/// The codes of the smallest and the largest value: symmetric, so that the middle of the range is a code.
const LARGEST_CODE: f64 = 32_767.0;
/// The largest record that the format recommends, in bytes.
const LARGEST_RECORD: usize = 61_440;
/// A record is as close to this long as the samples allow, s.
const RECORD_S: f64 = 1.0;
/// No record is shorter, s, unless the recording is: most programs read many short records slowly.
const SHORTEST_RECORD_S: f64 = 0.05;
/// Lengths of records that are tried.
const MOST_CANDIDATES: usize = 1 << 16;

/// How one channel is stored.
struct Scaled<'r> {
    channel: &'r Channel,
    dimension: String,
    /// From the SI unit to the dimension.
    factor: f64,
    lowest: String,
    highest: String,
    /// The values of `lowest` and `highest`.
    range: (f64, f64),
    per_record: usize,
}

/// Writes `recording` as EDF+C: 16 bits a sample, the range of each channel around its own values, so that no sample is further than
/// half a step from its value; events as annotations. It is written whole or not at all. Returns warnings about what the file does not
/// carry; a last record that is not full is completed with the last value of each channel, and a warning says with how many samples.
///
/// # Errors
/// [`WriteError`] when it cannot be written, a sample is no number, channels begin at different times, or a name, unit, range or
/// text of an event is not one that EDF holds.
pub fn write_edf(path: &Path, recording: &Recording) -> Result<Vec<Warning>, WriteError> {
    let layout = layout(path, recording)?;
    let lists = Lists::new(path, recording, layout.records, layout.record_s)?;
    let channels = scaled(path, recording, &layout)?;
    let header = header(path, recording, &layout, &channels, &lists)?;
    write_atomically(path, |out| {
        let mut put = |bytes: &[u8]| out.write_all(bytes).map_err(WriteError::io(path));
        put(header.as_bytes())?;
        let mut record = Vec::new();
        for number in 0..layout.records {
            record.clear();
            for scaled in &channels {
                scaled.put(number, &mut record);
            }
            record.extend_from_slice(&lists.of_record(number));
            put(&record)?;
        }
        Ok(())
    })?;
    let loses = |what: String| {
        Warning::from(RecordingWarning::FormatLoses {
            format: "EDF+".into(),
            what,
        })
    };
    let mut warnings = vec![loses(
        "the condition, the labels, the provenance and the warnings of a recording, nor samples in more than 16 bits".into(),
    )];
    if layout.added > 0 {
        let added = counted(layout.added, "sample");
        warnings.push(loses(format!(
            "a last record that is not full, so that {added} with the last value of each channel were added at the end"
        )));
    }
    Ok(warnings)
}

/// How samples are divided into records.
struct Layout {
    records: usize,
    record_s: f64,
    /// The length of a record as the header states it.
    record_text: String,
    /// Samples in a record, for each clock.
    per_record: Vec<usize>,
    /// Samples added to the channels of the fastest clock.
    added: usize,
}

/// The number of samples in each clock's channels, which have to begin and end together.
fn common_lengths(path: &Path, recording: &Recording) -> Result<Vec<usize>, WriteError> {
    let refuse = |expected: &str, found: String, todo: &str| {
        Err(WriteError::content(path, expected, found, todo))
    };
    if recording.is_empty() {
        return refuse(
            "samples in every channel",
            "none".into(),
            "leave that channel out",
        );
    }
    let clocks = recording.clocks();
    if let Some(late) = clocks.iter().find(|clock| clock.start_s.0 > 0.0) {
        return refuse(
            "channels that begin together",
            format!("one that begins at {} s", late.start_s.0),
            "cut them to a common start, or write them to separate files",
        );
    }
    let length_of = |clock: usize| {
        let numbers = recording.clock_numbers().iter();
        let mut of_clock = numbers
            .zip(recording.channels())
            .filter(|(n, _)| **n == clock);
        of_clock
            .next()
            .map_or(0, |(_, channel)| channel.samples.len())
    };
    let lengths: Vec<usize> = (0..clocks.len()).map(length_of).collect();
    let fastest = fastest(clocks);
    let ends_s = |clock: usize| clocks[clock].rate_hz.duration_of(lengths[clock]).0;
    let uneven = (0..clocks.len()).any(|clock| {
        let off_s = (ends_s(clock) - ends_s(fastest)).abs();
        off_s > 1.000_001 / clocks[clock].rate_hz.hz()
    });
    if uneven {
        return refuse(
            "channels that end together",
            format!("channels of {lengths:?} samples at {} rates", clocks.len()),
            "cut them to a common length, or write them to separate files",
        );
    }
    Ok(lengths)
}

fn fastest(clocks: &[Clock]) -> usize {
    (0..clocks.len())
        .max_by(|a, b| clocks[*a].rate_hz.hz().total_cmp(&clocks[*b].rate_hz.hz()))
        .unwrap_or(0)
}

fn layout(path: &Path, recording: &Recording) -> Result<Layout, WriteError> {
    let refuse = |expected: &str, found: String, todo: &str| {
        Err(WriteError::content(path, expected, found, todo))
    };
    let lengths = common_lengths(path, recording)?;
    let clocks = recording.clocks();
    let fastest = fastest(clocks);
    let rate_hz = clocks[fastest].rate_hz.hz();
    let frame_bytes: usize = clocks
        .iter()
        .enumerate()
        .map(|(k, clock)| {
            let channels = recording
                .clock_numbers()
                .iter()
                .filter(|n| **n == k)
                .count();
            (channels as f64 * 2.0 * clock.rate_hz.hz() / rate_hz).ceil() as usize
        })
        .sum();
    // Candidates: samples of the fastest clock in a record, so that its length and the samples of all clocks in it are exact.
    let shortest = ((SHORTEST_RECORD_S * rate_hz) as usize)
        .clamp(1, lengths[fastest].clamp(1, MOST_CANDIDATES));
    let longest = (LARGEST_RECORD / frame_bytes.max(1)).max((2.0 * rate_hz) as usize);
    let longest = longest.clamp(shortest, MOST_CANDIDATES);
    let exact = |samples: usize| -> Option<(usize, String, Vec<usize>)> {
        let text = eight(samples as f64 / rate_hz)?;
        let record_s: f64 = text.parse().ok()?;
        let per_record: Option<Vec<usize>> = clocks
            .iter()
            .map(|clock| {
                let each = clock.rate_hz.hz() * record_s;
                let whole = each.round();
                // What is read back, whole ÷ length, is the rate to 9 digits.
                let fits = whole >= 1.0 && (each - whole).abs() <= 1e-9 * whole;
                fits.then_some(whole as usize)
            })
            .collect();
        Some((samples, text, per_record?))
    };
    let distance = |samples: usize| ((samples as f64 / rate_hz) / RECORD_S).ln().abs();
    let records_of = |per_record: &[usize]| {
        let records = lengths.iter().zip(per_record).map(|(n, m)| n.div_ceil(*m));
        records.max().unwrap_or(0)
    };
    // What has to be added to all clocks together, s.
    let added_s = |per_record: &[usize]| -> f64 {
        let records = records_of(per_record);
        let each = clocks.iter().zip(&lengths).zip(per_record);
        each.map(|((clock, n), m)| clock.rate_hz.duration_of(records * m - n).0)
            .sum()
    };
    let candidates = (shortest..=longest).filter_map(exact);
    let rated = candidates.map(|(samples, text, per_record)| {
        let added_s = added_s(&per_record);
        (added_s, distance(samples), text, per_record)
    });
    let best = rated.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let Some((_, _, record_text, per_record)) = best else {
        return refuse(
            "rates that give whole numbers of samples in a record of at most 8 digits",
            clocks
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(", "),
            "resample them to a rate such as 1000 Hz, or write BrainVision",
        );
    };
    let records = records_of(&per_record);
    let added = records * per_record[fastest] - lengths[fastest];
    if records > 99_999_999 {
        return refuse(
            "at most 99999999 records",
            format!("{records}"),
            "cut it into parts",
        );
    }
    Ok(Layout {
        records,
        record_s: record_text.parse().unwrap_or(RECORD_S),
        record_text,
        per_record,
        added,
    })
}

/// `value` in at most eight characters, where that is exact to 12 digits.
fn eight(value: f64) -> Option<String> {
    // Eight characters hold at most six digits behind the point.
    let millionths = value * 1e6;
    if (millionths - millionths.round()).abs() > 1e-9 * millionths.max(1.0) {
        return None;
    }
    let text = format!("{value}");
    let short = (1..=6).map(|digits| format!("{value:.digits$}"));
    let mut all = std::iter::once(text).chain(short);
    all.find(|text| {
        let back = text.parse::<f64>().unwrap_or(f64::NAN);
        text.len() <= 8 && back > 0.0 && (back - value).abs() <= 1e-12 * value
    })
}

/// Which limit of a range is meant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Limit {
    Lowest,
    Highest,
}

/// The nearest text of at most eight characters that is no larger than `value`, for a lowest limit, or no smaller, for a highest one.
fn outer(value: f64, limit: Limit) -> Option<String> {
    (0..=6).rev().find_map(|digits| {
        let step = 10_f64.powi(-digits);
        let scaled = value / step;
        let rounded = match limit {
            Limit::Lowest => scaled.floor(),
            Limit::Highest => scaled.ceil(),
        };
        let text = format!("{:.*}", digits.unsigned_abs() as usize, rounded * step);
        let text = if text.parse() == Ok(0.0) {
            "0".into()
        } else {
            text
        };
        let back: f64 = text.parse().ok()?;
        let outside = match limit {
            Limit::Lowest => back <= value,
            Limit::Highest => back >= value,
        };
        (text.len() <= 8 && outside).then_some(text)
    })
}

fn scaled<'r>(
    path: &Path,
    recording: &'r Recording,
    layout: &Layout,
) -> Result<Vec<Scaled<'r>>, WriteError> {
    let numbered = recording.channels().iter().zip(recording.clock_numbers());
    numbered
        .map(|(channel, clock)| {
            let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (at, value) in channel.samples.iter().enumerate() {
                if !value.is_finite() {
                    return Err(WriteError::content(
                        path,
                        "numbers",
                        format!("{value} at sample {at} of `{}`", channel.name),
                        "cut that part out",
                    ));
                }
                (lowest, highest) = (lowest.min(*value), highest.max(*value));
            }
            let largest = lowest.abs().max(highest.abs());
            let (dimension, factor) = dimension_of(path, &channel.unit, largest)?;
            let (low, high) = (lowest * factor, highest * factor);
            // A constant channel stands in the middle of its range.
            let half = if high > low { 0.0 } else { 1.0 };
            let range = || {
                let (lowest, highest) = (
                    outer(low - half, Limit::Lowest)?,
                    outer(high + half, Limit::Highest)?,
                );
                let range: (f64, f64) = (lowest.parse().ok()?, highest.parse().ok()?);
                (range.0 < range.1).then_some((lowest, highest, range))
            };
            let (lowest, highest, range) = range().ok_or_else(|| {
                WriteError::content(
                    path,
                    "limits of at most 8 characters",
                    format!("{low} to {high} {dimension} in `{}`", channel.name),
                    "state that channel in another unit, or write BrainVision",
                )
            })?;
            Ok(Scaled {
                channel,
                dimension,
                factor,
                lowest,
                highest,
                range,
                per_record: layout.per_record[*clock],
            })
        })
        .collect()
}

/// The dimension in which values up to `largest` have the most digits in a field of eight, and the factor to it.
fn dimension_of(path: &Path, unit: &Unit, largest: f64) -> Result<(String, f64), WriteError> {
    let symbol = match unit {
        Unit::MetrePerSecondSquared => "m/s2",
        Unit::Other(text) => text,
        known => known.symbol(),
    };
    // EEG is written in µV, as all programs expect it; several take nV for V.
    let prefixes: &[(&str, f64)] = match unit {
        Unit::Volt => &[("u", 1e6), ("m", 1e3), ("", 1.0)],
        _ => &[("", 1.0), ("m", 1e3), ("u", 1e6), ("n", 1e9), ("k", 1e-3)],
    };
    let known = prefixes.iter().filter_map(|(prefix, factor)| {
        let dimension = format!("{prefix}{symbol}");
        let (si, back) = eeg_unit(&dimension);
        let same = si == *unit && (back * factor - 1.0).abs() < 1e-12;
        same.then_some((dimension, *factor))
    });
    let known: Vec<(String, f64)> = known.collect();
    let fits = |(_, factor): &&(String, f64)| (1e-2..1e5).contains(&(largest * factor));
    let chosen = known.iter().find(fits).or_else(|| match unit {
        Unit::Volt if largest > 1.0 => known.last(),
        _ => known.first(),
    });
    let (dimension, factor) = chosen.cloned().unwrap_or_else(|| (symbol.to_owned(), 1.0));
    // The letter µ is not in the ASCII of the format; degrees have no other sign.
    let written = dimension.replace(['µ', 'μ'], "u").replace('°', "deg");
    if written.len() > 8 || !is_plain(&written) {
        return Err(WriteError::content(
            path,
            "a unit of at most 8 plain characters",
            format!("`{dimension}`"),
            "state a shorter one, or write BrainVision",
        ));
    }
    Ok((written, factor))
}

fn is_plain(text: &str) -> bool {
    text.bytes().all(|byte| (32..127).contains(&byte))
}

impl Scaled<'_> {
    /// Adds the codes of record `number`.
    fn put(&self, number: usize, record: &mut Vec<u8>) {
        let samples = &self.channel.samples;
        let (lowest, highest) = self.range;
        let step = (highest - lowest) / (2.0 * LARGEST_CODE);
        let last = samples.last().copied().unwrap_or(0.0);
        let first = number * self.per_record;
        for at in first..first + self.per_record {
            let value = samples.get(at).copied().unwrap_or(last) * self.factor;
            let code = ((value - lowest) / step - LARGEST_CODE).round();
            let code = code.clamp(-LARGEST_CODE, LARGEST_CODE) as i16;
            record.extend(code.to_le_bytes());
        }
    }
}

/// The annotation lists of all records.
struct Lists {
    /// For each record, its onset and the annotations in it.
    records: Vec<Vec<u8>>,
    /// Samples of the annotation channel in a record.
    per_record: usize,
}

impl Lists {
    fn new(
        path: &Path,
        recording: &Recording,
        records: usize,
        record_s: f64,
    ) -> Result<Self, WriteError> {
        let started = recording.annotations.started_at.as_ref();
        let zero_s = started.map_or(0.0, fraction_of);
        let mut lists = Vec::with_capacity(recording.annotations.events.len());
        for event in &recording.annotations.events {
            lists.push(list(path, event, zero_s)?);
        }
        let mut each: Vec<Vec<u8>> = (0..records)
            .map(|number| {
                let mut onset = time_of(zero_s + number as f64 * record_s).into_bytes();
                onset.extend([END, END, 0]);
                onset
            })
            .collect();
        // Annotations may stand in any record: they are spread, so that no record has to hold more than its share.
        let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
        let share = lists.iter().map(Vec::len).sum::<usize>().div_ceil(records) + longest;
        let onset = each.iter().map(Vec::len).max().unwrap_or(0);
        let capacity = (onset + share).next_multiple_of(2);
        let mut at = 0;
        for list in lists {
            while each
                .get(at)
                .is_some_and(|record| record.len() + list.len() > capacity)
            {
                at += 1;
            }
            if let Some(record) = each.get_mut(at) {
                record.extend(list);
            }
        }
        Ok(Self {
            records: each,
            per_record: capacity / 2,
        })
    }

    fn of_record(&self, number: usize) -> Vec<u8> {
        let mut bytes = self.records.get(number).cloned().unwrap_or_default();
        bytes.resize(2 * self.per_record, 0);
        bytes
    }
}

/// The part of a second after which a recording starts.
fn fraction_of(start: &StartTime) -> f64 {
    let text = start.to_string();
    let fraction = text.split_once('.').map(|(_, rest)| {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        format!("0.{}", &rest[..digits])
    });
    fraction.and_then(|text| text.parse().ok()).unwrap_or(0.0)
}

/// A time as annotations have it: with its sign, to the nanosecond at most.
fn time_of(seconds: f64) -> String {
    let text = format!("{seconds:+.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn list(path: &Path, event: &Event, zero_s: f64) -> Result<Vec<u8>, WriteError> {
    let text = match &event.value {
        None => event.kind.clone(),
        Some(EventValue::Text(text)) => format!("{}/{text}", event.kind),
        Some(EventValue::Number(number)) => format!("{}/{number}", event.kind),
    };
    let (onset_s, lasts_s) = (event.onset_s.0, event.duration_s.0);
    let holds = onset_s.abs() < 1e9 && (0.0..1e9).contains(&lasts_s);
    if text.is_empty()
        || text
            .chars()
            .any(|c| matches!(c, '\0' | '\u{14}' | '\u{15}'))
        || !holds
    {
        return Err(WriteError::content(
            path,
            "events with a name without control characters, a time and a duration from 0 s on",
            format!("`{}` at {onset_s} s for {lasts_s} s", text.escape_debug()),
            "rename or correct that event",
        ));
    }
    let mut bytes = time_of(zero_s + onset_s).into_bytes();
    if lasts_s > 0.0 {
        bytes.push(DURATION);
        let lasts = format!("{lasts_s:.9}");
        let lasts = lasts.trim_end_matches('0').trim_end_matches('.');
        bytes.extend_from_slice(lasts.as_bytes());
    }
    bytes.push(END);
    bytes.extend_from_slice(text.as_bytes());
    bytes.extend([END, 0]);
    Ok(bytes)
}

fn header(
    path: &Path,
    recording: &Recording,
    layout: &Layout,
    channels: &[Scaled<'_>],
    lists: &Lists,
) -> Result<String, WriteError> {
    for scaled in channels {
        let name = &scaled.channel.name;
        let known = matches!(name.as_str(), "EDF Annotations" | "BDF Annotations");
        if name.len() > 16 || name.is_empty() || name.trim() != name || !is_plain(name) || known {
            return Err(WriteError::content(
                path,
                "names of channels of 1 to 16 plain characters (ASCII)",
                format!("`{}`", name.escape_debug()),
                "rename that channel, or write BrainVision",
            ));
        }
    }
    let count = channels.len() + 1;
    if count > 9999 {
        return Err(WriteError::content(
            path,
            "at most 9998 channels",
            format!("{}", channels.len()),
            "write them to several files",
        ));
    }
    let start = recording
        .annotations
        .started_at
        .as_ref()
        .map(ToString::to_string);
    let (date, time, day) = dates(path, start.as_deref())?;
    let equipment = match recording.about.provenance.bench {
        Some(BenchKind::Twin) => super::TWIN,
        _ => "X",
    };
    let mut text = format!(
        "{:8}{:80}{:80}{date:8}{time:8}{:8}{:44}{:8}{:8}{count:<4}",
        "0",
        "X X X X",
        format!("Startdate {day} X X {equipment}"),
        256 * (count + 1),
        "EDF+C",
        layout.records,
        layout.record_text,
    );
    let mut column = |width: usize, of: &dyn Fn(&Scaled<'_>) -> String, last: &str| {
        for scaled in channels {
            text.push_str(&format!("{:width$}", of(scaled)));
        }
        text.push_str(&format!("{last:width$}"));
    };
    column(16, &|scaled| scaled.channel.name.clone(), "EDF Annotations");
    column(80, &|_| String::new(), "");
    column(8, &|scaled| scaled.dimension.clone(), "");
    column(8, &|scaled| scaled.lowest.clone(), "-1");
    column(8, &|scaled| scaled.highest.clone(), "1");
    column(8, &|_| format!("{}", -LARGEST_CODE), "-32768");
    column(8, &|_| format!("{LARGEST_CODE}"), "32767");
    column(80, &|_| String::new(), "");
    column(
        8,
        &|scaled| scaled.per_record.to_string(),
        &lists.per_record.to_string(),
    );
    column(32, &|_| String::new(), "");
    Ok(text)
}

/// The fields of the start: `dd.mm.yy`, `hh.mm.ss`, and the day of EDF+, `02-MAR-2002`.
fn dates(path: &Path, start: Option<&str>) -> Result<(String, String, String), WriteError> {
    const MONTHS: [&str; 12] = [
        "JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC",
    ];
    let Some(start) = start else {
        return Ok(("01.01.85".into(), "00.00.00".into(), "X".into()));
    };
    let part = |from: usize, to: usize| start.get(from..to).unwrap_or_default();
    let (year, month, day) = (part(0, 4), part(5, 7), part(8, 10));
    let within = year
        .parse()
        .is_ok_and(|year: u32| (1985..2085).contains(&year));
    let name = month
        .parse::<usize>()
        .ok()
        .and_then(|m| MONTHS.get(m.wrapping_sub(1)));
    let (Some(name), true) = (name, within) else {
        return Err(WriteError::content(
            path,
            "a start from 1985 to 2084",
            start,
            "correct the start time",
        ));
    };
    Ok((
        format!("{day}.{month}.{}", part(2, 4)),
        part(11, 19).replace(':', "."),
        format!("{day}-{name}-{year}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_outside_the_values_and_fit() {
        for value in [
            0.0,
            1.0,
            -1.0,
            123.456_789,
            -187.2,
            99_999.4,
            -3276.75,
            1e-5,
            -1e-5,
            0.1,
        ] {
            let (low, high) = (
                outer(value, Limit::Lowest).unwrap(),
                outer(value, Limit::Highest).unwrap(),
            );
            let (below, above): (f64, f64) = (low.parse().unwrap(), high.parse().unwrap());
            assert!(below <= value && value <= above, "{low} {value} {high}");
            assert!(
                low.len() <= 8 && high.len() <= 8 && above - below < 1.1,
                "{low} {high}"
            );
        }
        assert_eq!(outer(1e9, Limit::Highest), None);
        assert_eq!(eight(0.015_625).as_deref(), Some("0.015625"));
        assert_eq!(eight(1.0).as_deref(), Some("1"));
        assert_eq!(eight(1.0 / 256.0), None);
        assert_eq!(
            (time_of(0.0), time_of(1.25), time_of(-0.5)),
            ("+0".into(), "+1.25".into(), "-0.5".into())
        );
    }
}
