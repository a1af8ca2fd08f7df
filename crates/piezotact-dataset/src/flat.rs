//! Tables of `FlatBuffers`, read with every offset checked: what Arrow's metadata is made of.
//!
//! Source: `FlatBuffers`, *Internals*; the tables of Apache Arrow in `Schema.fbs` and `Message.fbs`.

/// A table.
#[derive(Clone, Copy)]
struct Table<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Table<'a> {
    /// The table that the bytes begin with.
    fn root(bytes: &'a [u8]) -> Option<Self> {
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
    fn byte(self, id: usize) -> Option<u8> {
        let [byte] = self.number(self.field(id)?)?;
        Some(byte)
    }

    /// Field `id` as a table.
    fn table(self, id: usize) -> Option<Self> {
        self.behind(self.field(id)?)
    }

    /// Field `id` as a text.
    fn text(self, id: usize) -> Option<&'a str> {
        let Self { at, .. } = self.behind(self.field(id)?)?;
        let from = at.checked_add(4)?;
        let bytes = self.bytes.get(from..from.checked_add(self.length(at)?)?)?;
        std::str::from_utf8(bytes).ok()
    }

    /// Field `id` as a list of tables.
    fn tables(self, id: usize) -> Option<Vec<Self>> {
        let Self { at, .. } = self.behind(self.field(id)?)?;
        let (from, count) = (at.checked_add(4)?, self.length(at)?);
        let end = from.checked_add(count.checked_mul(4)?)?;
        if end > self.bytes.len() {
            return None;
        }
        (0..count).map(|k| self.behind(from + 4 * k)).collect()
    }
}

/// The schema of columns.
#[derive(Clone, Copy)]
pub(crate) struct Schema<'a>(Table<'a>);

impl<'a> Schema<'a> {
    /// The schema in `bytes`, which are a message of Arrow; `None` where they are another one.
    pub(crate) fn of(bytes: &'a [u8]) -> Option<Self> {
        let message = Table::root(bytes)?;
        match message.byte(1)? {
            1 => Some(Self(message.table(2)?)),
            _ => None,
        }
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
