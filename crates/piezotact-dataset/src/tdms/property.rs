//! Properties of files, groups and channels.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use piezotact::quantity::Seconds;
use piezotact::recording::StartTime;

use super::source::Source;
use crate::error::ReadError;
use crate::stored::{ByteOrder, Stored};

/// Properties by their names.
pub(super) type Properties = BTreeMap<String, Property>;

/// What a property holds, as far as it is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Property {
    Text(String),
    Number(f64),
    Time(Stamp),
}

impl Property {
    /// Whether `other` says the same, numbers to the rounding of a program.
    fn is_like(&self, other: Option<&Self>) -> bool {
        match (self, other) {
            (Self::Number(a), Some(Self::Number(b))) => (a - b).abs() <= 1e-9 * a.abs(),
            (own, other) => Some(own) == other,
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The text, where it holds one that is not empty.
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }
}

/// A time: whole seconds since 1904-01-01 00:00 UTC, and 2⁻⁶⁴ s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    seconds: i64,
    fraction: u64,
}

impl Stamp {
    pub(super) fn of(bytes: &[u8], order: ByteOrder) -> Self {
        let (first, second) = bytes.split_at(bytes.len().min(8));
        let (fraction, seconds) = match order {
            ByteOrder::Little => (first, second),
            ByteOrder::Big => (second, first),
        };
        Self {
            seconds: order.unsigned(seconds) as i64,
            fraction: order.unsigned(fraction),
        }
    }

    /// How much later it is than `earlier`, s.
    pub(super) fn since(self, earlier: Self) -> f64 {
        let whole = i128::from(self.seconds) - i128::from(earlier.seconds);
        let part = i128::from(self.fraction) - i128::from(earlier.fraction);
        whole as f64 + part as f64 / 2_f64.powi(64)
    }

    /// The time in UTC; `None` where it was not set, or in no year of four digits.
    pub(super) fn start_time(self) -> Option<StartTime> {
        const DAY: i64 = 86_400;
        const YEAR_9999: i64 = 8095 * 365 * DAY;
        let is_set = (1..YEAR_9999).contains(&self.seconds);
        let epoch = StartTime::try_from("1904-01-01T00:00:00Z".to_owned()).ok();
        let day = epoch.filter(|_| is_set)?;
        // In two steps, as one number would be exact to half a microsecond alone.
        let day = day.later(Seconds((self.seconds / DAY * DAY) as f64));
        let of_day = (self.seconds % DAY) as f64 + self.fraction as f64 / 2_f64.powi(64);
        Some(day.later(Seconds(of_day)))
    }
}

/// When the first sample of a channel was taken, as its properties say it: a time, and s from there on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Start {
    pub(super) stamp: Option<Stamp>,
    /// In the unit of the step between samples.
    pub(super) offset_s: f64,
}

impl Start {
    pub(super) fn of(properties: &Properties) -> Self {
        let offset_s = properties.get("wf_start_offset").and_then(Property::number);
        Self {
            stamp: match properties.get("wf_start_time") {
                Some(Property::Time(stamp)) => Some(*stamp),
                _ => None,
            },
            offset_s: offset_s.filter(|s| s.is_finite()).unwrap_or(0.0),
        }
    }

    /// How much later it is than `earlier`, s, where offsets count in units of `second`; `None` where one of them has no time.
    pub(super) fn since(self, earlier: Self, second: f64) -> Option<f64> {
        let later_s = self.stamp?.since(earlier.stamp?);
        Some(later_s + (self.offset_s - earlier.offset_s) * second)
    }
}

/// The number type with a code of a TDMS file.
pub(super) fn stored(code: u64) -> Option<Stored> {
    Some(match code {
        1 => Stored::I8,
        2 => Stored::I16,
        3 => Stored::I32,
        4 => Stored::I64,
        5 => Stored::U8,
        6 => Stored::U16,
        7 => Stored::U32,
        8 => Stored::U64,
        9 | 0x19 => Stored::F32,
        10 | 0x1A => Stored::F64,
        _ => return None,
    })
}

/// Properties that say what the samples are: they hold for all samples of a channel.
fn is_of_samples(name: &str) -> bool {
    name.starts_with("NI_Scal")
        || ["unit_string", "NI_UnitDescription", "wf_increment"].contains(&name)
}

/// Reads the properties of an object and adds them to `known`; the first that says what samples are and was another before.
pub(super) fn read<R: Read + Seek>(
    source: &mut Source<'_, R>,
    order: ByteOrder,
    known: &mut Properties,
) -> Result<Option<String>, ReadError> {
    let mut changed = None;
    let count = source.number::<4>(order, "the number of properties")?;
    for _ in 0..count {
        let name = source.name(order, "the name of a property")?;
        let at = source.at();
        let code = source.number::<4>(order, "the type of a property")?;
        let property = match code {
            0x20 => source.text(order, "a property")?.map(Property::Text),
            0x44 => {
                let mut bytes = [0; 16];
                source.fill(&mut bytes, "a property")?;
                Some(Property::Time(Stamp::of(&bytes, order)))
            }
            // Nothing, truth, complex numbers.
            0 | 0x21 | 0x0008_000C | 0x0010_000D => {
                let mut bytes = [0; 16];
                let width = match code {
                    0 => 0,
                    0x21 => 1,
                    0x0008_000C => 8,
                    _ => 16,
                };
                source.fill(&mut bytes[..width], "a property")?;
                None
            }
            code => match stored(code) {
                Some(number) => {
                    let mut bytes = [0; 8];
                    let bytes = &mut bytes[..number.width()];
                    source.fill(bytes, "a property")?;
                    Some(Property::Number(number.value(bytes, order)))
                }
                None => {
                    let expected = format!("a known type of the property `{name}`");
                    return Err(source.wrong(at, expected, format!("type {code:#x}")));
                }
            },
        };
        let before = known.get(&name).filter(|_| is_of_samples(&name));
        if before.is_some_and(|before| !before.is_like(property.as_ref())) {
            changed = changed.or_else(|| Some(name.clone()));
        }
        match property {
            Some(property) => known.insert(name, property),
            None => known.remove(&name),
        };
    }
    Ok(changed)
}
