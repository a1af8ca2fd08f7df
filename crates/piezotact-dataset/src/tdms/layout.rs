//! The segments of a TDMS file: which channels a segment holds, and how their samples lie in it.

use std::collections::HashMap;
use std::io::{Read, Seek};

use super::index::{Index, Kind, Scalers};
use super::property::{Properties, Start, read as read_properties};
use super::source::Source;
use crate::error::ReadError;
use crate::stored::ByteOrder;

/// The bytes of a lead-in.
const LEAD_IN: u64 = 28;
/// More objects than this are no channels.
const MOST_OBJECTS: usize = 8192;
/// The type of a channel that holds no samples yet.
const NO_TYPE: u64 = 0;
/// The bits of the table of contents of a segment.
const META: u64 = 1 << 1;
const NEW_LIST: u64 = 1 << 2;
const RAW: u64 = 1 << 3;
const INTERLEAVED: u64 = 1 << 5;
const BIG_ENDIAN: u64 = 1 << 6;
const KNOWN_BITS: u64 = 0xEE;

/// A file, a group or a channel.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) group: String,
    /// Absent of a group and of the file.
    pub(super) channel: Option<String>,
    pub(super) properties: Properties,
    pub(super) index: Option<Index>,
    /// Its samples, by scaler.
    pub(super) slots: Vec<Slot>,
    /// Samples that the file states and does not hold.
    pub(super) missing: u64,
    /// The starts that its properties stated one after another, and how many samples stood before; none where there was one.
    pub(super) starts: Vec<(u64, Start)>,
    /// A property that holds for all samples and was changed between them.
    pub(super) changed: Option<String>,
}

impl Object {
    /// How many texts a chunk of it holds.
    pub(super) fn texts(&self) -> u64 {
        self.index.as_ref().map_or(0, |index| index.count)
    }
}

/// The samples of one scaler of a channel.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub(super) scaler: u64,
    pub(super) kind: Kind,
    pub(super) count: u64,
}

/// Rows of interleaved samples in a chunk.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) rows: u64,
    /// Bytes of a row.
    pub(super) width: u64,
    pub(super) columns: Vec<Column>,
}

/// Samples within rows.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) object: usize,
    pub(super) slot: usize,
    pub(super) kind: Kind,
    pub(super) first: usize,
}

/// How a segment ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Stated,
    /// The file ends before it.
    Cut,
    /// The program that wrote it did not end it.
    Open,
}

/// Where a segment has its samples.
#[derive(Debug)]
pub(super) struct Segment {
    pub(super) raw: u64,
    pub(super) order: ByteOrder,
    /// How many times all blocks follow each other whole.
    pub(super) whole: u64,
    /// Rows of each block behind them.
    pub(super) last: Vec<u64>,
    /// Rows of each block that the segment states.
    pub(super) stated: Vec<u64>,
}

/// A walk through the segments of a file.
#[derive(Debug)]
pub(super) struct Walk<'p, R> {
    pub(super) source: Source<'p, R>,
    pub(super) objects: Vec<Object>,
    known: HashMap<String, usize>,
    /// The objects of the current segment, and whether they have samples in it.
    pub(super) list: Vec<(usize, bool)>,
    pub(super) blocks: Vec<Block>,
    pub(super) is_interleaved: bool,
    next: u64,
    /// Whether its samples were counted.
    is_counted: bool,
    /// Whether the file ends before its last segment does.
    pub(super) is_cut: bool,
    /// Whether the program that wrote it did not end its last segment.
    pub(super) is_interrupted: bool,
}

impl<'p, R: Read + Seek> Walk<'p, R> {
    pub(super) fn new(source: Source<'p, R>) -> Self {
        Self {
            source,
            objects: Vec::new(),
            known: HashMap::new(),
            list: Vec::new(),
            blocks: Vec::new(),
            is_interleaved: false,
            next: 0,
            is_counted: false,
            is_cut: false,
            is_interrupted: false,
        }
    }

    /// The same walk from the beginning, with the same objects.
    pub(super) fn again(mut self) -> Self {
        self.list.clear();
        self.next = 0;
        self.is_counted = true;
        self
    }

    /// The next segment; `None` behind the last whole one.
    pub(super) fn advance(&mut self) -> Result<Option<Segment>, ReadError> {
        let (at, length) = (self.next, self.source.length);
        let left = length.saturating_sub(at);
        if left == 0 {
            return Ok(None);
        }
        self.source.end = length;
        self.source.seek(at)?;
        let mut tag = [0; 4];
        let tag_bytes = left.min(4) as usize;
        self.source
            .fill(&mut tag[..tag_bytes], "the tag of a segment")?;
        if tag[..tag_bytes] == b"TDSh"[..tag_bytes] && tag_bytes == 4 {
            return Err(self.is_an_index());
        }
        if tag[..tag_bytes] != b"TDSm"[..tag_bytes] {
            let found = format!("`{}`", tag.escape_ascii());
            return Err(self.source.wrong(at, "the tag `TDSm` of a segment", found));
        }
        if left < LEAD_IN {
            return self.ends_within(at, "its lead-in");
        }
        let toc = self.source.number::<4>(ByteOrder::Little, "a lead-in")?;
        let order = match toc & BIG_ENDIAN {
            0 => ByteOrder::Little,
            _ => ByteOrder::Big,
        };
        let version = self.source.number::<4>(order, "a lead-in")?;
        if toc & !KNOWN_BITS != 0 || ![4712, 4713].contains(&version) {
            let found = format!("contents {toc:#x} and version {version}");
            let expected = "a segment of version 4712 or 4713";
            return Err(self.source.wrong(at + 4, expected, found));
        }
        let next = self.source.number::<8>(order, "a lead-in")?;
        let raw = self.source.number::<8>(order, "a lead-in")?;
        let body = at + LEAD_IN;
        let stated_end = match next {
            u64::MAX => Some(length.max(body.saturating_add(raw))),
            next => body.checked_add(next),
        };
        let (Some(stated_end), Some(raw)) = (stated_end, body.checked_add(raw)) else {
            let found = format!("offsets {next} and {raw}");
            return Err(self.source.wrong(at + 12, "offsets within the file", found));
        };
        if raw > stated_end {
            let found = format!("samples from byte {raw} on");
            let expected = format!("a segment that ends at byte {stated_end}");
            return Err(self.source.wrong(at + 20, expected, found));
        }
        if raw > length {
            return self.ends_within(at, "its metadata");
        }
        let end = match next {
            u64::MAX => End::Open,
            _ if stated_end > length => End::Cut,
            _ => End::Stated,
        };
        self.is_interrupted |= end == End::Open;
        let is_interleaved = toc & INTERLEAVED != 0;
        if toc & META != 0 {
            self.source.end = raw;
            self.metadata(order, toc)?;
        } else if at == 0 {
            let found = "none in the first segment";
            return Err(self.source.wrong(at, "metadata", found));
        }
        if toc & META != 0 || is_interleaved != self.is_interleaved {
            self.is_interleaved = is_interleaved;
            self.blocks = self.planned(at)?;
        }
        self.source.end = length;
        let has_raw = toc & RAW != 0;
        let held = if has_raw {
            length.min(stated_end) - raw
        } else {
            0
        };
        let stated = if has_raw { stated_end - raw } else { 0 };
        let mut segment = Segment {
            raw,
            order,
            whole: 0,
            last: vec![0; self.blocks.len()],
            stated: Vec::new(),
        };
        self.divide(&mut segment, held, stated, end)?;
        if end != End::Stated && !self.is_cut {
            self.no_segment_within(raw, at)?;
            self.is_cut = true;
        }
        self.next = stated_end.min(length);
        Ok(Some(segment))
    }

    fn is_an_index(&self) -> ReadError {
        let beside = self.source.path.with_extension("tdms");
        ReadError::content(
            self.source.path,
            "a TDMS file with samples",
            "the index of one (`TDSh`), which holds none",
            format!("give {}, the file that it belongs to", beside.display()),
        )
    }

    /// The file ends within a segment before its samples.
    fn ends_within(&mut self, at: u64, what: &str) -> Result<Option<Segment>, ReadError> {
        if at == 0 {
            return Err(ReadError::content(
                self.source.path,
                "a segment with samples",
                format!(
                    "a file that ends at byte {} within {what}",
                    self.source.length
                ),
                "it was cut short: copy it again",
            ));
        }
        self.is_cut = true;
        Ok(None)
    }

    /// That no segment begins within the samples of the segment at `at`, which go to the end of the file: its offset would be wrong.
    fn no_segment_within(&mut self, raw: u64, at: u64) -> Result<(), ReadError> {
        self.source.seek(raw)?;
        let (mut kept, mut place, mut found) = (Vec::new(), raw, None);
        let left = self.source.length - raw;
        self.source.rows(left, 1, |bytes| {
            kept.extend_from_slice(bytes);
            let is_lead_in = |window: &[u8]| {
                let number = |from: usize| {
                    let part = &window[from..from + 4];
                    (
                        ByteOrder::Little.unsigned(part),
                        ByteOrder::Big.unsigned(part),
                    )
                };
                let (toc, versions) = (number(4).0, number(8));
                toc & !KNOWN_BITS == 0
                    && [versions.0, versions.1]
                        .iter()
                        .any(|version| [4712, 4713].contains(version))
            };
            let begins = kept.windows(12).position(|window| {
                window[0] == b'T' && window.starts_with(b"TDSm") && is_lead_in(window)
            });
            found = found.or(begins.map(|begins| place + begins as u64));
            let used = kept.len().saturating_sub(11);
            kept.drain(..used);
            place += used as u64;
        })?;
        match found {
            None => Ok(()),
            Some(place) => {
                let found = format!("another segment at byte {place}, and a wrong offset");
                let expected = "the last segment, as its samples go to the end of the file";
                Err(self.source.wrong(at + 12, expected, found))
            }
        }
    }

    /// Reads the objects of a segment.
    fn metadata(&mut self, order: ByteOrder, toc: u64) -> Result<(), ReadError> {
        if toc & NEW_LIST != 0 {
            self.list.clear();
        }
        let count = self.source.number::<4>(order, "the number of objects")?;
        for _ in 0..count {
            let at = self.source.at();
            let path = self.source.name(order, "the path of an object")?;
            let number = self.object(at, path)?;
            let has_samples = self.index(number, order)?;
            match self.list.iter_mut().find(|(known, _)| *known == number) {
                Some((_, known)) => *known = has_samples,
                None => self.list.push((number, has_samples)),
            }
            let object = &mut self.objects[number];
            let before = Start::of(&object.properties);
            let changed = read_properties(&mut self.source, order, &mut object.properties)?;
            let count = object.slots.first().map_or(0, |slot| slot.count);
            if count == 0 || self.is_counted {
                continue;
            }
            object.changed = object.changed.take().or(changed);
            let after = Start::of(&object.properties);
            if before.stamp.is_some() && after != before {
                if object.starts.is_empty() {
                    object.starts.push((0, before));
                }
                object.starts.push((count, after));
            }
        }
        Ok(())
    }

    /// The number of the object at a path, which is added where it is new.
    fn object(&mut self, at: u64, path: String) -> Result<usize, ReadError> {
        if let Some(number) = self.known.get(&path) {
            return Ok(*number);
        }
        let Some(names) = names_of(&path).filter(|names| names.len() <= 2) else {
            let found = format!("`{}`", path.escape_debug());
            let expected = "the path of an object such as /'group'/'channel'";
            return Err(self.source.wrong(at, expected, found));
        };
        if self.objects.len() == MOST_OBJECTS {
            let expected = format!("at most {MOST_OBJECTS} groups and channels");
            return Err(self.source.wrong(at, expected, "one more"));
        }
        let mut names = names.into_iter();
        self.objects.push(Object {
            group: names.next().unwrap_or_default(),
            channel: names.next(),
            properties: Properties::new(),
            index: None,
            slots: Vec::new(),
            missing: 0,
            starts: Vec::new(),
            changed: None,
        });
        self.known.insert(path, self.objects.len() - 1);
        Ok(self.objects.len() - 1)
    }

    /// Reads how the samples of an object lie in the segment; whether it has any in it.
    fn index(&mut self, number: usize, order: ByteOrder) -> Result<bool, ReadError> {
        let at = self.source.at();
        let header = self.source.number::<4>(order, "an index of samples")?;
        let index = match header {
            0xFFFF_FFFF => return Ok(false),
            0 if self.objects[number].index.is_some() => return Ok(true),
            0x14 | 0x1C => Index::plain(&mut self.source, order)?,
            0x1269 => Index::daqmx(&mut self.source, order, Scalers::Numbers)?,
            0x126A | 0x1369 => Index::daqmx(&mut self.source, order, Scalers::DigitalLines)?,
            other => {
                let found = match other {
                    0 => "that of an earlier segment, which has none".to_owned(),
                    other => format!("one of type or length {other:#x}"),
                };
                return Err(self.source.wrong(at, "an index of samples", found));
            }
        };
        let object = &mut self.objects[number];
        let before = object.index.as_ref().map(|index| index.type_code);
        let before = before.filter(|code| *code != NO_TYPE);
        if index.type_code == NO_TYPE && before.is_some() {
            return Ok(false);
        }
        if before.is_some_and(|before| before != index.type_code) {
            let expected = format!(
                "samples of one type in all segments of `{}`",
                object.channel.as_deref().unwrap_or_default()
            );
            let found = format!(
                "type {:#x} after {:#x}",
                index.type_code,
                before.unwrap_or(0)
            );
            return Err(self.source.wrong(at, expected, found));
        }
        for part in &index.parts {
            let slots = &mut object.slots;
            if !slots.iter().any(|slot| slot.scaler == part.scaler) {
                slots.push(Slot {
                    scaler: part.scaler,
                    kind: part.kind,
                    count: 0,
                });
            }
        }
        object.index = Some(index);
        Ok(true)
    }
}

/// The names in a path such as `/'group'/'it''s a channel'`; none for `/`.
fn names_of(path: &str) -> Option<Vec<String>> {
    let mut rest = path.strip_prefix('/')?;
    let mut names = Vec::new();
    while !rest.is_empty() {
        let mut name = String::new();
        let mut inner = rest.strip_prefix('\'')?;
        loop {
            let (part, behind) = inner.split_once('\'')?;
            name.push_str(part);
            match behind.strip_prefix('\'') {
                Some(more) => {
                    name.push('\'');
                    inner = more;
                }
                None => {
                    rest = behind;
                    break;
                }
            }
        }
        names.push(name);
        rest = match rest.strip_prefix('/') {
            Some("") => return None,
            Some(more) => more,
            None if rest.is_empty() => rest,
            None => return None,
        };
    }
    Some(names)
}
