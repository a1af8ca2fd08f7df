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
        let mut values = Vec::with_capacity(bytes.len() / self.width());
        self.append(bytes, self.width(), 0, order, &mut values);
        values
    }

    /// Appends the number `first` bytes behind the start of each row of `bytes`, which are `row` bytes long each; where a row is too short
    /// for it, 0.
    pub(crate) fn append(
        self,
        bytes: &[u8],
        row: usize,
        first: usize,
        order: ByteOrder,
        to: &mut Vec<f64>,
    ) {
        // One loop for each type and order, so that none of them is decided for each number.
        macro_rules! each {
            ($number:ty, $read:ident) => {{
                const WIDTH: usize = size_of::<$number>();
                if row == WIDTH && first == 0 {
                    let (numbers, _) = bytes.as_chunks::<WIDTH>();
                    to.extend(numbers.iter().map(|n| <$number>::$read(*n) as f64));
                } else {
                    to.extend(bytes.chunks_exact(row).map(|row| {
                        let number = row.get(first..).and_then(<[u8]>::first_chunk::<WIDTH>);
                        <$number>::$read(number.copied().unwrap_or_default()) as f64
                    }));
                }
            }};
        }
        macro_rules! of {
            ($number:ty) => {
                match order {
                    ByteOrder::Little => each!($number, from_le_bytes),
                    ByteOrder::Big => each!($number, from_be_bytes),
                }
            };
        }
        match self {
            Self::I8 => of!(i8),
            Self::U8 => of!(u8),
            Self::I16 => of!(i16),
            Self::U16 => of!(u16),
            Self::I32 => of!(i32),
            Self::U32 => of!(u32),
            Self::I64 => of!(i64),
            Self::U64 => of!(u64),
            Self::F32 => of!(f32),
            Self::F64 => of!(f64),
        }
    }
}
