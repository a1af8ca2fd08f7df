//! Columns of numbers in Parquet files: written as 64-bit floats, read whatever their width.

use crate::ReadError;
use std::fs::File;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use parquet::basic::{Compression, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType, DoubleType, FixedLenByteArray};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, KeyValue, RowGroupMetaData};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescriptor, Type};
use piezotact::recording::StartTime;

use crate::flat::Schema;
use cells::{Cells, what_is_in};

mod blocks;
mod cells;
mod packed;

/// The rows of a group: what is held in memory while a file is written.
const ROWS_OF_A_GROUP: usize = 1 << 20;
/// The rows that are read at a time.
const ROWS_AT_A_TIME: usize = 1 << 16;
/// Where pyarrow and others keep Arrow's schema.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// How the columns of a file are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Columns {
    /// A number in every row.
    Whole,
    /// Channels have clocks of their own: shorter ones are filled up with nulls at their end.
    FilledUp,
}

/// A file that is being written.
pub(crate) struct Writer<W: Write + Send> {
    inner: SerializedFileWriter<W>,
    columns: Columns,
    rows: Vec<Vec<f64>>,
}

impl<W: Write + Send> Writer<W> {
    /// Begins a file of columns called `names` with `texts` in its metadata.
    pub(crate) fn new<'n>(
        out: W,
        names: impl Iterator<Item = &'n str>,
        columns: Columns,
        texts: impl IntoIterator<Item = (&'static str, String)>,
    ) -> Result<Self, ParquetError> {
        let repetition = match columns {
            Columns::Whole => Repetition::REQUIRED,
            Columns::FilledUp => Repetition::OPTIONAL,
        };
        let field = |name| {
            Type::primitive_type_builder(name, Physical::DOUBLE)
                .with_repetition(repetition)
                .build()
                .map(Arc::new)
        };
        let fields: Vec<_> = names.map(field).collect::<Result<_, _>>()?;
        let rows = vec![Vec::new(); fields.len()];
        let schema = Type::group_type_builder("schema").with_fields(fields);
        let texts = texts.into_iter();
        let pairs = texts.map(|(key, text)| KeyValue::new(key.to_owned(), text));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_key_value_metadata(Some(pairs.collect()))
            .build();
        let inner =
            SerializedFileWriter::new(out, Arc::new(schema.build()?), Arc::new(properties))?;
        Ok(Self {
            inner,
            columns,
            rows,
        })
    }

    /// Appends to every column; whole columns grow alike.
    pub(crate) fn append(&mut self, chunk: Vec<Vec<f64>>) -> Result<(), ParquetError> {
        for (column, new) in self.rows.iter_mut().zip(chunk) {
            column.extend(new);
        }
        let full = self.columns == Columns::Whole
            && self
                .rows
                .first()
                .is_some_and(|rows| rows.len() >= ROWS_OF_A_GROUP);
        if full { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let longest = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let mut group = self.inner.next_row_group()?;
        for rows in &mut self.rows {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            let levels: Option<Vec<i16>> = (self.columns == Columns::FilledUp).then(|| {
                let filled = std::iter::repeat_n(1, rows.len());
                filled
                    .chain(std::iter::repeat_n(0, longest - rows.len()))
                    .collect()
            });
            column
                .typed::<DoubleType>()
                .write_batch(rows, levels.as_deref(), None)?;
            column.close()?;
            rows.clear();
        }
        group.close().map(|_metadata| ())
    }

    /// Ends the file.
    pub(crate) fn finish(mut self) -> Result<(), ParquetError> {
        if self.rows.iter().any(|rows| !rows.is_empty()) {
            self.write_group()?;
        }
        self.inner.close().map(|_metadata| ())
    }
}

/// A file that is read.
pub(crate) struct Reader {
    inner: SerializedFileReader<File>,
    file: Arc<File>,
}

impl Reader {
    pub(crate) fn new(file: File) -> Result<Self, ParquetError> {
        Ok(Self {
            file: Arc::new(file.try_clone()?),
            inner: SerializedFileReader::new(file)?,
        })
    }

    /// The text that is stored under `key`.
    pub(crate) fn stored(&self, key: &str) -> Option<String> {
        let pairs = self.inner.metadata().file_metadata().key_value_metadata()?;
        let pair = pairs.iter().find(|pair| pair.key == key)?;
        pair.value.clone()
    }

    /// The names of the columns, each with what Arrow's metadata store of it under `key`.
    pub(crate) fn columns_with(&self, key: &str) -> Vec<(String, Option<String>)> {
        let message = self.stored(ARROW_SCHEMA);
        let message = message.and_then(|text| STANDARD.decode(text).ok());
        // The mark of a message and its length stand before it.
        let schema = message.as_deref().and_then(|bytes| bytes.get(8..));
        let stored = schema.and_then(Schema::of);
        let stored = stored.map_or(Vec::new(), |schema| schema.of_columns(key));
        let value = |name: &str| {
            let (_, value) = stored.iter().find(|(column, _)| *column == name)?;
            value.map(str::to_owned)
        };
        let columns = self.descriptors().iter();
        columns
            .map(|column| (name_of(column), value(&name_of(column))))
            .collect()
    }

    fn descriptors(&self) -> &[Arc<ColumnDescriptor>] {
        self.inner
            .metadata()
            .file_metadata()
            .schema_descr()
            .columns()
    }

    /// Every column as 64-bit floats; `path` is only named in errors.
    pub(crate) fn numbers(
        &self,
        path: &Path,
        columns: Columns,
    ) -> Result<Vec<Vec<f64>>, ReadError> {
        let held = self.held(path, columns)?;
        Ok(held.into_iter().map(|held| held.values).collect())
    }

    /// As [`Self::numbers`], with what they are.
    pub(crate) fn held(&self, path: &Path, columns: Columns) -> Result<Vec<Held>, ReadError> {
        let mut cells = self.cells(path)?;
        let (all, gaps) = (self.columns(&mut cells)).map_err(|error| damaged(path, &error))?;
        match gaps {
            Some(name) if columns == Columns::Whole => return Err(gaps_in(path, &name)),
            _ => {}
        }
        let held = all.into_iter().zip(cells).zip(self.descriptors());
        held.map(
            |((values, cells), column)| match values.iter().any(|one| one.is_nan()) {
                true if cells.is_text() => Err(no_numbers(path, column, "text".into())),
                _ => Ok(Held {
                    values,
                    moments: cells.start(),
                }),
            },
        )
        .collect()
    }

    /// What the cells of every column are, of which nothing is read yet.
    fn cells(&self, path: &Path) -> Result<Vec<Cells>, ReadError> {
        let cells = self.descriptors().iter().map(|column| {
            Cells::of(column).ok_or_else(|| no_numbers(path, column, what_is_in(column)))
        });
        let cells = cells.collect::<Result<_, _>>()?;
        let mut chunks = self.groups().iter().flat_map(RowGroupMetaData::columns);
        match chunks.find_map(packed::unknown_codec) {
            None => Ok(cells),
            Some(codec) => Err(ReadError::content(
                path,
                format!("columns compressed as one of {}", packed::KNOWN),
                codec,
                "write it again with another compression, such as snappy",
            )),
        }
    }

    /// Every column, and the first that has rows without a number.
    fn columns(
        &self,
        cells: &mut [Cells],
    ) -> Result<(Vec<Vec<f64>>, Option<String>), ParquetError> {
        let mut first_gaps = None;
        let mut all = vec![Vec::new(); self.descriptors().len()];
        for group in self.groups() {
            require_places(group)?;
            for (k, (numbers, cells)) in all.iter_mut().zip(cells.iter_mut()).enumerate() {
                let mut rows = self.rows_of(group, k)?;
                let mut gaps = 0;
                loop {
                    let (rows, without) = rows(ROWS_AT_A_TIME, cells, numbers)?;
                    gaps += without;
                    if rows == 0 {
                        break;
                    }
                }
                if gaps > 0 {
                    first_gaps.get_or_insert_with(|| name_of(&self.descriptors()[k]));
                }
            }
        }
        Ok((all, first_gaps))
    }

    fn groups(&self) -> &[RowGroupMetaData] {
        self.inner.metadata().row_groups()
    }

    /// What reads the rows of a column in `group`, from the first on.
    fn rows_of(&self, group: &RowGroupMetaData, column: usize) -> Result<Rows, ParquetError> {
        let chunk = group.columns().get(column);
        let chunk =
            chunk.ok_or_else(|| ParquetError::General("a column that is missing".into()))?;
        let descriptor = Arc::clone(&self.descriptors()[column]);
        let pages = packed::pages(&self.file, chunk, group.num_rows())?;
        Ok(match get_column_reader(descriptor, pages) {
            ColumnReader::DoubleColumnReader(reader) => rows(reader, |_, v| v),
            ColumnReader::FloatColumnReader(reader) => rows(reader, |_, v| f64::from(v)),
            ColumnReader::Int32ColumnReader(reader) => rows(reader, Cells::whole32),
            ColumnReader::Int64ColumnReader(reader) => rows(reader, Cells::whole),
            ColumnReader::ByteArrayColumnReader(reader) => {
                rows(reader, |cells, v: ByteArray| cells.bytes(v.data()))
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                rows(reader, |cells, v: FixedLenByteArray| cells.bytes(v.data()))
            }
            _ => Box::new(|_, _, _| Ok((0, 0))),
        })
    }
}

/// What reads so many rows of a column at most, and appends their numbers: how many rows it read, and how many of them have no number.
type Rows =
    Box<dyn FnMut(usize, &mut Cells, &mut Vec<f64>) -> Result<(usize, usize), ParquetError>>;

fn rows<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    number: impl Fn(&mut Cells, T::T) -> f64 + 'static,
) -> Rows {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    Box::new(move |most, cells, numbers| {
        values.clear();
        levels.clear();
        let read = || reader.read_records(most, Some(&mut levels), None, &mut values);
        // The crate asserts that a damaged run has a length: here it is an error, as all other damage.
        let read = catch_unwind(AssertUnwindSafe(read));
        let no_run = |_| ParquetError::General("a run of values without a length".into());
        let (rows, read, _) = read.map_err(no_run)??;
        numbers.extend(values.drain(..).map(|value| number(cells, value)));
        Ok((rows, rows.saturating_sub(read)))
    })
}

/// A column as it was read.
pub(crate) struct Held {
    pub(crate) values: Vec<f64>,
    /// Of a column of moments, in s since the first one, that one; `None` where its day is not known.
    pub(crate) moments: Option<Option<StartTime>>,
}

fn gaps_in(path: &Path, column: &str) -> ReadError {
    ReadError::content(
        path,
        "a number in every row",
        format!("gaps in `{column}`"),
        "fill or cut them",
    )
}

fn no_numbers(path: &Path, column: &ColumnDescriptor, found: String) -> ReadError {
    ReadError::content(
        path,
        "numbers",
        format!("{found} in `{}`", name_of(column)),
        "export that column as numbers, or leave it out",
    )
}

/// That the file at `path` cannot be read.
pub(crate) fn damaged(path: &Path, error: &dyn std::fmt::Display) -> ReadError {
    ReadError::content(
        path,
        "a complete Parquet file",
        format!("one that cannot be read ({error})"),
        "it was cut short or damaged: copy it again",
    )
}

/// Refuses columns whose place in their file is none: the library panics on negative ones.
fn require_places(group: &RowGroupMetaData) -> Result<(), ParquetError> {
    let has_a_place = |column: &ColumnChunkMetaData| {
        let first = column
            .dictionary_page_offset()
            .unwrap_or(column.data_page_offset());
        first >= 0 && column.data_page_offset() >= 0 && column.compressed_size() >= 0
    };
    match group.columns().iter().all(has_a_place) {
        true => Ok(()),
        false => Err(ParquetError::General(
            "a column with an offset outside the file".into(),
        )),
    }
}

fn name_of(column: &ColumnDescriptor) -> String {
    column.path().string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

    fn file_of(columns: Columns, chunks: &[Vec<Vec<f64>>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let texts = [("key", "text".to_owned())];
        let mut writer = Writer::new(&mut bytes, ["a", "b"].into_iter(), columns, texts).unwrap();
        for chunk in chunks {
            writer.append(chunk.clone()).unwrap();
        }
        writer.finish().unwrap();
        bytes
    }

    fn read(bytes: &[u8], columns: Columns) -> Result<Vec<Vec<f64>>, ReadError> {
        let path = Path::new("a.parquet");
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        Reader::new(file)
            .map_err(|error| damaged(path, &error))?
            .numbers(path, columns)
    }

    #[test]
    fn columns_come_back_also_where_they_differ_in_length() {
        let wave: Vec<f64> = (0..3000).map(|i| (f64::from(i) * 0.1).sin()).collect();
        let whole = file_of(
            Columns::Whole,
            &[
                vec![wave.clone(), wave.clone()],
                vec![vec![1.0], vec![-0.0]],
            ],
        );
        let back = read(&whole, Columns::Whole).ok().unwrap();
        assert_eq!(back[0][..3000], wave);
        assert_eq!(
            (back[0][3000], back[1][3000].to_bits()),
            (1.0, (-0.0_f64).to_bits())
        );
        let filled = file_of(Columns::FilledUp, &[vec![wave.clone(), vec![2.0; 7]]]);
        let back = read(&filled, Columns::FilledUp).ok().unwrap();
        assert_eq!((back[0].len(), back[1].as_slice()), (3000, &[2.0; 7][..]));
        let gaps = read(&filled, Columns::Whole);
        assert!(matches!(gaps, Err(ReadError::Content { found, .. }) if found == "gaps in `b`"));
    }

    /// The library panics on some damaged metadata: each such place is looked at first.
    #[test]
    fn damage_never_panics() {
        let wave: Vec<f64> = (0..500).map(|i| (f64::from(i) * 0.1).sin()).collect();
        let whole = file_of(Columns::Whole, &[vec![wave.clone(), wave]]);
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random.next_u32() % 4 {
                let at = random.next_u32() as usize % bytes.len();
                let values = [0x00, 0x7F, 0xFF, bytes[at] ^ (1 << (random.next_u32() % 8))];
                bytes[at] = values[random.next_u32() as usize % 4];
            }
            let _either = read(&bytes, Columns::Whole);
        }
    }
}
