//! What the cells of a column are, and the numbers that they hold.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::schema::types::ColumnDescriptor;
use piezotact::quantity::Seconds;
use piezotact::recording::StartTime;

use crate::date_time::Stamps;

/// What the cells of a column are.
pub(super) enum Cells {
    /// Numbers, in this part of 1.
    Numbers(f64),
    /// Numbers of 16 bits with a binary point.
    Halves,
    /// Whole numbers above zero.
    Unsigned,
    Moments(Moments),
    /// Text, which may be of moments.
    Text(Stamps),
}

/// Moments as whole numbers.
pub(super) struct Moments {
    per_s: i64,
    /// Whether they count from the beginning of 1970, and whether in UTC.
    since_1970: Option<bool>,
    first: Option<i64>,
}

impl Cells {
    /// `None` for what holds no numbers.
    pub(super) fn of(column: &ColumnDescriptor) -> Option<Self> {
        use Physical::{BYTE_ARRAY, DOUBLE, FIXED_LEN_BYTE_ARRAY, FLOAT, INT32, INT64};
        if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
            return None;
        }
        let physical = column.physical_type();
        let is_whole = matches!(physical, INT32 | INT64);
        let moments = |unit: &TimeUnit, since_1970| {
            let per_s = match unit {
                TimeUnit::MILLIS => 1_000,
                TimeUnit::MICROS => 1_000_000,
                TimeUnit::NANOS => 1_000_000_000,
            };
            let first = None;
            Some(Self::Moments(Moments {
                per_s,
                since_1970,
                first,
            }))
        };
        let parts = |scale: i32| Some(Self::Numbers(10_f64.powi(scale)));
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(of)), _) if physical == INT64 => {
                moments(&of.unit, Some(of.is_adjusted_to_u_t_c))
            }
            (Some(LogicalType::Time(of)), _) if is_whole => moments(&of.unit, None),
            (Some(LogicalType::Decimal(of)), _) if !matches!(physical, FLOAT | DOUBLE) => {
                parts(of.scale)
            }
            (Some(LogicalType::Float16), _) if physical == FIXED_LEN_BYTE_ARRAY => {
                Some(Self::Halves)
            }
            (Some(LogicalType::String), _) if physical == BYTE_ARRAY => {
                Some(Self::Text(Stamps::default()))
            }
            (Some(LogicalType::Integer(of)), _) if is_whole => match of.is_signed {
                true => Some(Self::Numbers(1.0)),
                false => Some(Self::Unsigned),
            },
            (Some(_), _) => None,
            (None, ConvertedType::TIMESTAMP_MILLIS) if physical == INT64 => {
                moments(&TimeUnit::MILLIS, Some(true))
            }
            (None, ConvertedType::TIMESTAMP_MICROS) if physical == INT64 => {
                moments(&TimeUnit::MICROS, Some(true))
            }
            (None, ConvertedType::DECIMAL) if is_whole || physical == FIXED_LEN_BYTE_ARRAY => {
                parts(column.type_scale())
            }
            (None, ConvertedType::UTF8) => Some(Self::Text(Stamps::default())),
            (None, ConvertedType::UINT_8 | ConvertedType::UINT_16)
            | (None, ConvertedType::UINT_32 | ConvertedType::UINT_64) => Some(Self::Unsigned),
            (None, ConvertedType::NONE) if is_whole || matches!(physical, FLOAT | DOUBLE) => {
                Some(Self::Numbers(1.0))
            }
            (None, ConvertedType::INT_8 | ConvertedType::INT_16)
            | (None, ConvertedType::INT_32 | ConvertedType::INT_64) => Some(Self::Numbers(1.0)),
            _ => None,
        }
    }

    pub(super) fn whole32(&mut self, value: i32) -> f64 {
        match self {
            Self::Unsigned => f64::from(value as u32),
            _ => self.whole(value.into()),
        }
    }

    pub(super) fn whole(&mut self, value: i64) -> f64 {
        match self {
            Self::Numbers(parts) => value as f64 / *parts,
            Self::Unsigned => value as u64 as f64,
            // The difference first: a number of ns since 1970 has more digits than a float.
            Self::Moments(moments) => {
                let first = *moments.first.get_or_insert(value);
                value.wrapping_sub(first) as f64 / moments.per_s as f64
            }
            Self::Text(_) | Self::Halves => f64::NAN,
        }
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) -> f64 {
        match self {
            Self::Halves => match bytes {
                [low, high] => half(u16::from_le_bytes([*low, *high])),
                _ => f64::NAN,
            },
            Self::Numbers(parts) if bytes.len() <= 16 => {
                let negative = bytes.first().is_some_and(|byte| *byte >= 0x80);
                let from = if negative { -1_i128 } else { 0 };
                let value = (bytes.iter()).fold(from, |sum, byte| sum << 8 | i128::from(*byte));
                value as f64 / *parts
            }
            Self::Text(stamps) => {
                let text = std::str::from_utf8(bytes).ok();
                text.and_then(|text| stamps.seconds(text))
                    .unwrap_or(f64::NAN)
            }
            _ => f64::NAN,
        }
    }

    pub(super) fn is_text(&self) -> bool {
        matches!(self, Self::Text(_))
    }

    /// Of moments the first one; `None` in it where its day is not known.
    pub(super) fn start(self) -> Option<Option<StartTime>> {
        match self {
            Self::Numbers(_) | Self::Unsigned | Self::Halves => None,
            Self::Text(stamps) => Some(stamps.start(None)),
            Self::Moments(moments) => Some(moments.start()),
        }
    }
}

/// The number in 16 bits: sign, five bits of an exponent, ten of a fraction.
///
/// Source: IEEE 754-2019, binary16.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (
        i32::from(bits >> 10 & 0x1F),
        f64::from(bits & 0x3FF) / 1024.0,
    );
    let size = match exponent {
        0 => fraction * 2_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2_f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

impl Moments {
    fn start(&self) -> Option<StartTime> {
        let (first, utc) = (self.first?, self.since_1970?);
        let epoch = format!("1970-01-01T00:00:00{}", if utc { "Z" } else { "" });
        let (whole, rest) = (first.div_euclid(self.per_s), first.rem_euclid(self.per_s));
        // Beyond some thousand years it is no date.
        let whole = Some(whole as f64).filter(|whole| (0.0..1e11).contains(whole))?;
        let at = StartTime::try_from(epoch).ok()?.later(Seconds(whole));
        Some(at.later(Seconds(rest as f64 / self.per_s as f64)))
    }
}

/// What a column without numbers holds, in a word or two.
pub(super) fn what_is_in(column: &ColumnDescriptor) -> String {
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return "lists or groups".into();
    }
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(logical), _) => {
            let word = format!("{logical:?}");
            let end = word.find('(').unwrap_or(word.len());
            word[..end].to_lowercase()
        }
        (None, ConvertedType::NONE) => column.physical_type().to_string(),
        (None, converted) => converted.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn halves_are_those_of_numpy() {
        // NumPy 2.4.6: numpy.float16(value).view("u2").
        let of = [
            (0x3555, 0.333_251_953_125),
            (0xC500, -5.0),
            (0x7BFF, 65_504.0),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x0400, 6.103_515_625e-5),
            (0x0000, 0.0),
        ];
        for (bits, value) in of {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7C00).is_infinite() && half(0x7E00).is_nan());
    }
}
