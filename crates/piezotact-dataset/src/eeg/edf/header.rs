//! The header of EDF and BDF: 256 bytes, and 256 for each signal, all of it text.

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::recording::{BenchKind, RecordingWarning, StartTime};

use crate::error::ReadError;

const WHAT_TO_DO: &str = "copy the file again, or correct its header";

/// Whether a file has gaps between its records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gaps {
    /// Every record follows the one before at once.
    None,
    /// Each record has an onset of its own.
    Stated,
}

/// Which of the two standards a file follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standard {
    /// EDF of 1992, or BDF: samples alone.
    Original,
    /// EDF+ or BDF+, with annotations.
    Plus,
}

/// One signal.
#[derive(Debug)]
pub(super) struct Signal {
    pub(super) label: String,
    pub(super) dimension: String,
    physical: (f64, f64),
    digital: (f64, f64),
    pub(super) per_record: usize,
    /// Where it stands in a record, in bytes.
    pub(super) at: usize,
    /// Whether it holds annotations and no samples.
    pub(super) annotations: bool,
    /// Why its codes have no scale; `None` where they have one.
    pub(super) without_scale: Option<String>,
}

impl Signal {
    /// The factor from codes to the physical dimension, and the value of code 0.
    pub(super) fn scale(&self) -> (f64, f64) {
        let gain = (self.physical.1 - self.physical.0) / (self.digital.1 - self.digital.0);
        (gain, self.physical.0 - self.digital.0 * gain)
    }

    /// Whether a code is within the range that the header states.
    pub(super) fn holds(&self, code: i32) -> bool {
        (self.digital.0..=self.digital.1).contains(&f64::from(code))
    }
}

/// The header.
#[derive(Debug)]
pub(super) struct Header {
    /// Bytes of one sample: 2 or 3.
    pub(super) width: usize,
    pub(super) standard: Standard,
    pub(super) gaps: Gaps,
    pub(super) started_at: Option<StartTime>,
    /// The bench, where the recorder says that no person took part.
    pub(super) bench: Option<BenchKind>,
    /// Bytes of the header, and of a record.
    pub(super) bytes: usize,
    pub(super) record_bytes: usize,
    pub(super) records: usize,
    /// The length of a record, s.
    pub(super) record_s: f64,
    /// Whether the recorder did not write how many records there are: it did not end properly.
    pub(super) stopped: bool,
    /// Whether records that the header counts are missing.
    pub(super) is_cut: bool,
    pub(super) signals: Vec<Signal>,
}

impl Header {
    pub(super) fn rate_of(&self, path: &Path, signal: &Signal) -> Result<SampleRate, ReadError> {
        SampleRate::new(signal.per_record as f64 / self.record_s).map_err(ReadError::of(path))
    }
}

/// Reads fields of text one after the other.
struct Fields<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn text(&mut self, length: usize) -> Result<&'a [u8], ReadError> {
        let field = self.bytes.get(self.at..self.at + length);
        self.at += length;
        field.ok_or_else(|| {
            ReadError::content(
                self.path,
                "a complete header of EDF or BDF",
                format!("the end of the file after {} bytes", self.bytes.len()),
                WHAT_TO_DO,
            )
        })
    }

    fn number(&mut self, what: &str) -> Result<f64, ReadError> {
        let bytes = self.text(8)?;
        // Some programs write the comma of their country.
        let text = latin(bytes).trim_matches(['\0', ' ']).replace(',', ".");
        let number = text.parse::<f64>().ok();
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.wrong(format!("a number as {what}"), &text))
    }

    fn whole(&mut self, length: usize, what: &str) -> Result<i64, ReadError> {
        let bytes = self.text(length)?;
        let text = latin(bytes);
        let text = text.trim_matches(['\0', ' ']);
        text.parse()
            .map_err(|_no_number| self.wrong(format!("a whole number as {what}"), text))
    }

    fn wrong(&self, expected: String, found: &str) -> ReadError {
        ReadError::content(
            self.path,
            expected,
            format!("`{}`", found.escape_debug()),
            WHAT_TO_DO,
        )
    }
}

/// The header in `bytes`, checked against the length of the file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<(Header, Vec<Warning>), ReadError> {
    let mut fields = Fields { path, bytes, at: 0 };
    let width = if fields.text(8)?.starts_with(b"\xFF") {
        3
    } else {
        2
    };
    let _patient = fields.text(80)?;
    let recording = latin(fields.text(80)?);
    let (date, time) = (latin(fields.text(8)?), latin(fields.text(8)?));
    let header_bytes = fields.whole(8, "the length of the header")?;
    let reserved = latin(fields.text(44)?);
    let stated = fields.whole(8, "the number of records")?;
    let record_s = fields.number("the duration of a record")?;
    let count = fields.whole(4, "the number of signals")?;
    let wrong = wrong(path);
    let count = usize::try_from(count)
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| wrong("at least one signal".into(), format!("{count}")))?;
    let length = 256 * (count + 1);
    if i64::try_from(length).ok() != Some(header_bytes) {
        return Err(wrong(
            format!("a header of {length} bytes for {count} signals"),
            format!("{header_bytes} bytes stated"),
        ));
    }
    if length > bytes.len() {
        return Err(wrong(
            format!("a header of {length} bytes for {count} signals"),
            format!("a file of {} bytes", bytes.len()),
        ));
    }
    let plus = (reserved.starts_with("EDF+") && width == 2)
        || (reserved.starts_with("BDF+") && width == 3);
    let standard = match plus {
        true => Standard::Plus,
        false => Standard::Original,
    };
    let gaps = match plus && reserved[4..].starts_with('D') {
        true => Gaps::Stated,
        false => Gaps::None,
    };
    let signals = signals(path, &mut fields, count, standard, width)?;
    let mut with_samples = signals.iter().filter(|signal| !signal.annotations);
    if with_samples.clone().all(|one| one.without_scale.is_some()) {
        let why = with_samples.next().and_then(|one| {
            let why = one.without_scale.as_ref()?;
            Some(format!("`{}`: {why}", one.label))
        });
        return Err(wrong(
            "a signal with samples and a scale".into(),
            why.unwrap_or_else(|| "annotations alone".into()),
        ));
    }
    if record_s <= 0.0 {
        return Err(wrong(
            "a duration of a record above 0 s".into(),
            format!("{record_s} s"),
        ));
    }
    // Every signal is in the bytes of the header, and has at most 10⁸ samples in a record: no sum overflows.
    let record_bytes = signals.iter().map(|s| s.per_record * width).sum::<usize>();
    let stored = bytes.len() - length;
    let (records, stopped) = records_in(path, stated, stored, record_bytes)?;
    let is_cut = usize::try_from(stated).is_ok_and(|stated| stated > records);
    let started_at = start_of(&date, &time, plus.then_some(recording.as_str()));
    let mut warnings = Vec::new();
    let beside = stored - records * record_bytes;
    if !stopped && (i64::try_from(records).ok() != Some(stated) || beside > 0) {
        let mut what = format!(
            "the header states {stated} records of {record_s} s, and the file holds {records}"
        );
        if is_cut {
            let missing = stated - i64::try_from(records).unwrap_or(stated);
            what += &format!(": {missing} ({} s) are missing", missing as f64 * record_s);
        }
        if beside > 0 {
            what += &format!("; {beside} bytes of an incomplete record were left out");
        }
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    if started_at.is_none() {
        let what = format!("the start time `{date} {time}` is no date and time, and is left out");
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    let header = Header {
        width,
        standard,
        gaps,
        started_at,
        bench: recording
            .trim()
            .ends_with(super::TWIN)
            .then_some(BenchKind::Twin),
        bytes: length,
        record_bytes,
        records,
        record_s,
        stopped,
        is_cut,
        signals,
    };
    Ok((header, warnings))
}

fn wrong(path: &Path) -> impl Fn(String, String) -> ReadError {
    move |expected, found| ReadError::content(path, expected, found, WHAT_TO_DO)
}

/// The number of whole records of `record_bytes` in what is `stored` behind the header, and whether the recorder did not write how many
/// there are: the recording was not finished.
fn records_in(
    path: &Path,
    stated: i64,
    stored: usize,
    record_bytes: usize,
) -> Result<(usize, bool), ReadError> {
    let wrong = wrong(path);
    if stated < -1 {
        return Err(wrong(
            "a number of records, or -1 for an unfinished recording".into(),
            format!("{stated}"),
        ));
    }
    let records = stored / record_bytes;
    if records == 0 {
        return Err(wrong(
            format!("at least one record of {record_bytes} bytes behind the header"),
            format!("{stored} bytes"),
        ));
    }
    Ok((records, stated == -1))
}

/// The largest number of samples of a signal in one record, which its field of eight digits holds.
const MOST_PER_RECORD: i64 = 99_999_999;

fn signals(
    path: &Path,
    fields: &mut Fields<'_>,
    count: usize,
    standard: Standard,
    width: usize,
) -> Result<Vec<Signal>, ReadError> {
    let mut labels = Vec::with_capacity(count);
    for _ in 0..count {
        labels.push(latin(fields.text(16)?).trim_matches(['\0', ' ']).to_owned());
    }
    fields.text(80 * count)?;
    let mut dimensions = Vec::with_capacity(count);
    for _ in 0..count {
        let field = fields.text(8)?.trim_ascii();
        // µ in Latin-1, UTF-8 or Shift JIS.
        let text = match field.strip_prefix(b"\x83\xCA") {
            Some(rest) => format!("µ{}", latin(rest)),
            None => super::super::ini::text_of(field),
        };
        dimensions.push(text.trim_matches(['\0', ' ']).to_owned());
    }
    let mut column = |what: &str| -> Result<Vec<f64>, ReadError> {
        (0..count)
            .map(|k| fields.number(&format!("the {what} of `{}`", labels[k])))
            .collect()
    };
    let lowest = column("physical minimum")?;
    let highest = column("physical maximum")?;
    let smallest = column("digital minimum")?;
    let largest = column("digital maximum")?;
    fields.text(80 * count)?;
    let mut at = 0;
    let mut signals = Vec::with_capacity(count);
    for k in 0..count {
        let label = labels[k].clone();
        let per_record = fields.whole(8, &format!("the samples in a record of `{label}`"))?;
        let annotations = standard == Standard::Plus
            && matches!(label.as_str(), "EDF Annotations" | "BDF Annotations");
        let signal = Signal {
            annotations,
            dimension: dimensions[k].clone(),
            physical: (lowest[k], highest[k]),
            digital: (smallest[k], largest[k]),
            per_record: usize::try_from(per_record)
                .ok()
                .filter(|_| (1..=MOST_PER_RECORD).contains(&per_record))
                .ok_or_else(|| {
                    ReadError::content(
                        path,
                        format!("at least one sample of `{label}` in a record"),
                        format!("{per_record}"),
                        WHAT_TO_DO,
                    )
                })?,
            label,
            at,
            without_scale: None,
        };
        at += signal.per_record * width;
        let without_scale = without_scale(&signal);
        signals.push(Signal {
            without_scale,
            ..signal
        });
    }
    Ok(signals)
}

/// Why the codes of a signal have no scale.
fn without_scale(signal: &Signal) -> Option<String> {
    if signal.annotations {
        return None;
    }
    let (smallest, largest) = signal.digital;
    let (lowest, highest) = signal.physical;
    if smallest > largest {
        return Some(format!(
            "its digital minimum, {smallest}, is above its maximum, {largest}"
        ));
    }
    let is_one = |(from, to): (f64, f64)| from.total_cmp(&to).is_eq();
    match (
        is_one(signal.digital),
        is_one((lowest, highest)) || signal.scale().0 == 0.0,
    ) {
        (true, _) => Some(format!(
            "its digital minimum and maximum are both {smallest}"
        )),
        (_, true) => Some(format!(
            "its physical minimum, {lowest}, and maximum, {highest}, give no scale"
        )),
        _ => None,
    }
}

/// The start of a recording: the full year of EDF+ where it is stated, otherwise that of a field of two digits from 1985 on.
fn start_of(date: &str, time: &str, recording: Option<&str>) -> Option<StartTime> {
    let three = |text: &str| -> Option<[u32; 3]> {
        let parts: Vec<u32> = text
            .trim()
            .split(['.', ':', '-', '/'])
            .map(|part| part.trim().parse().ok())
            .collect::<Option<_>>()?;
        parts.try_into().ok()
    };
    let [day, month, year] = three(date)?;
    let [hour, minute, second] = three(time)?;
    let written = recording
        .and_then(|text| text.strip_prefix("Startdate "))
        .and_then(|text| {
            text.split(' ')
                .next()?
                .rsplit('-')
                .next()?
                .parse::<u32>()
                .ok()
        });
    let year = match written {
        Some(full) if full % 100 == year => full,
        _ if year >= 85 => 1900 + year,
        _ => 2000 + year,
    };
    let text = format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}");
    StartTime::try_from(text).ok()
}

fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| char::from(*byte)).collect()
}
