//! Numbers as the bytes of a file: their type and the order of their bytes.

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    /// Up to eight bytes, the least first, filled up with zeros.
    pub(crate) fn little(self, bytes: &[u8]) -> [u8; 8] {
        let mut little = [0; 8];
        let places = little.iter_mut();
        match self {
            Self::Little => places.zip(bytes).for_each(|(to, from)| *to = *from),
            Self::Big => places
                .zip(bytes.iter().rev())
                .for_each(|(to, from)| *to = *from),
        }
        little
    }

    /// A whole number of up to eight bytes.
    pub(crate) fn unsigned(self, bytes: &[u8]) -> u64 {
        u64::from_le_bytes(self.little(bytes))
    }
}

/// The type of stored numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Stored {
    /// Bytes of one number.
    pub(crate) fn width(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number in `bytes`; whole ones beyond ±2⁵³ are rounded.
    pub(crate) fn value(self, bytes: &[u8], order: ByteOrder) -> f64 {
        let all = order.little(bytes);
        let [a, b, c, d, ..] = all;
        match self {
            Self::I8 => i8::from_le_bytes([a]).into(),
            Self::U8 => a.into(),
            Self::I16 => i16::from_le_bytes([a, b]).into(),
            Self::U16 => u16::from_le_bytes([a, b]).into(),
            Self::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Self::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Self::I64 => i64::from_le_bytes(all) as f64,
            Self::U64 => u64::from_le_bytes(all) as f64,
            Self::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Self::F64 => f64::from_le_bytes(all),
        }
    }

    /// Every number in `bytes`; what is left over at the end is no number.
    pub(crate) fn values(self, bytes: &[u8], order: ByteOrder) -> Vec<f64> {
        bytes
            .chunks_exact(self.width())
            .map(|chunk| self.value(chunk, order))
            .collect()
    }
}
