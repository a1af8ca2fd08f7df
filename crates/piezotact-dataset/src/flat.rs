//! Tables of `FlatBuffers`, read with every offset checked: what Arrow's metadata is made of.
//!
//! Source: `FlatBuffers`, *Internals*; the tables of Apache Arrow in `Schema.fbs` and `Message.fbs`.

/// A table.
#[derive(Clone, Copy)]
pub(crate) struct Table<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Table<'a> {
    /// The table that the bytes begin with.
    pub(crate) fn root(bytes: &'a [u8]) -> Option<Self> {
        Self { bytes, at: 0 }.behind(0)
    }

    fn number<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.bytes.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    fn length(self, at: usize) -> Option<usize> {
        usize::try_from(u32::from_le_bytes(self.number(at)?)).ok()
    }

    /// The table that the offset at `at` leads to.
    fn behind(self, at: usize) -> Option<Self> {
        let at = at.checked_add(self.length(at)?)?;
        Some(Self { at, ..self })
    }

    /// Where field `id` stands; `None` where it has its default.
    fn field(self, id: usize) -> Option<usize> {
        let back = i64::from(i32::from_le_bytes(self.number(self.at)?));
        let vtable = usize::try_from(i64::try_from(self.at).ok()?.checked_sub(back)?).ok()?;
        let size = usize::from(u16::from_le_bytes(self.number(vtable)?));
        let slot = 4 + 2 * id;
        if slot + 2 > size {
            return None;
        }
        match u16::from_le_bytes(self.number(vtable.checked_add(slot)?)?) {
            0 => None,
            offset => self.at.checked_add(usize::from(offset)),
        }
    }

    /// Field `id` as a byte.
    pub(crate) fn byte(self, id: usize) -> Option<u8> {
        let [byte] = self.number(self.field(id)?)?;
        Some(byte)
    }

    /// Field `id` as a whole number of 64 bits.
    pub(crate) fn long(self, id: usize) -> Option<i64> {
        Some(i64::from_le_bytes(self.number(self.field(id)?)?))
    }

    /// Whether field `id` is there.
    pub(crate) fn has(self, id: usize) -> bool {
        self.field(id).is_some()
    }

    /// Field `id` as a table.
    pub(crate) fn table(self, id: usize) -> Option<Self> {
        self.behind(self.field(id)?)
    }

    /// Field `id` as a text.
    pub(crate) fn text(self, id: usize) -> Option<&'a str> {
        let Self { at, .. } = self.behind(self.field(id)?)?;
        let from = at.checked_add(4)?;
        let bytes = self.bytes.get(from..from.checked_add(self.length(at)?)?)?;
        std::str::from_utf8(bytes).ok()
    }

    /// Field `id` as a list: where its first element stands, and how many there are of `size` bytes each.
    fn list(self, id: usize, size: usize) -> Option<(usize, usize)> {
        let Self { at, .. } = self.behind(self.field(id)?)?;
        let (from, count) = (at.checked_add(4)?, self.length(at)?);
        let end = from.checked_add(count.checked_mul(size)?)?;
        (end <= self.bytes.len()).then_some((from, count))
    }

    /// Field `id` as a list of tables.
    pub(crate) fn tables(self, id: usize) -> Option<Vec<Self>> {
        let (from, count) = self.list(id, 4)?;
        (0..count).map(|k| self.behind(from + 4 * k)).collect()
    }

    /// Field `id` as a list of pairs of whole numbers of 64 bits.
    pub(crate) fn pairs(self, id: usize) -> Option<Vec<[i64; 2]>> {
        let (from, count) = self.list(id, 16)?;
        let long = |at| Some(i64::from_le_bytes(self.number(at)?));
        (0..count)
            .map(|k| Some([long(from + 16 * k)?, long(from + 16 * k + 8)?]))
            .collect()
    }
}

/// A message of Arrow.
pub(crate) enum Message<'a> {
    /// The schema of the columns.
    Schema(Schema<'a>),
    /// A batch of rows; `body_length` bytes follow.
    Batch {
        /// The table of the batch.
        batch: Table<'a>,
        /// The length of what follows.
        body_length: u64,
    },
}

impl<'a> Message<'a> {
    /// The message in `bytes`.
    pub(crate) fn of(bytes: &'a [u8]) -> Option<Self> {
        let message = Table::root(bytes)?;
        match message.byte(1)? {
            1 => Some(Self::Schema(Schema(message.table(2)?))),
            3 => Some(Self::Batch {
                batch: message.table(2)?,
                body_length: u64::try_from(message.long(3).unwrap_or(0)).ok()?,
            }),
            _ => None,
        }
    }
}

/// The schema of columns.
#[derive(Clone, Copy)]
pub(crate) struct Schema<'a>(Table<'a>);

impl<'a> Schema<'a> {
    /// How many columns there are.
    pub(crate) fn columns(self) -> usize {
        self.0.tables(1).map_or(0, |fields| fields.len())
    }

    /// The text that is stored under `key`.
    pub(crate) fn stored(self, key: &str) -> Option<&'a str> {
        value_of(self.0, 2, key)
    }

    /// The name of every column, with what is stored of it under `key`.
    pub(crate) fn of_columns(self, key: &str) -> Vec<(&'a str, Option<&'a str>)> {
        let fields = self.0.tables(1).unwrap_or_default();
        let named = fields.into_iter();
        named
            .filter_map(|field| Some((field.text(0)?, value_of(field, 6, key))))
            .collect()
    }
}

/// The value of `key` in the list of pairs of texts that field `id` is.
fn value_of<'a>(table: Table<'a>, id: usize, key: &str) -> Option<&'a str> {
    let pairs = table.tables(id)?;
    let pair = pairs.iter().find(|pair| pair.text(0) == Some(key))?;
    pair.text(1)
}
