//! The pages of a column, unpacked: the library leaves all codecs but Snappy to code in C or to crates that nothing else needs.

use std::fs::File;
use std::io::Read;
use std::sync::Arc;

use flate2::read::MultiGzDecoder;
use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use ruzstd::decoding::StreamingDecoder;

/// The codecs that are read.
pub(super) const KNOWN: &str = "Snappy, zstd, gzip";
/// What a page unpacks to at most, in bytes; writers aim at 1 MiB.
const LARGEST: u64 = 1 << 30;

/// The name of the codec of a column that cannot be unpacked.
pub(super) fn unknown_codec(chunk: &ColumnChunkMetaData) -> Option<String> {
    match chunk.compression() {
        Compression::UNCOMPRESSED
        | Compression::SNAPPY
        | Compression::GZIP(_)
        | Compression::ZSTD(_) => None,
        other => Some(other.to_string()),
    }
}

/// The pages of a column.
pub(super) fn pages(
    file: &Arc<File>,
    chunk: &ColumnChunkMetaData,
    rows: i64,
) -> Result<Box<dyn PageReader>, ParquetError> {
    let codec = chunk.compression();
    let open = |chunk: &ColumnChunkMetaData| {
        let rows = usize::try_from(rows)?;
        SerializedPageReader::new(Arc::clone(file), chunk, rows, None)
    };
    if !matches!(codec, Compression::GZIP(_) | Compression::ZSTD(_)) {
        return Ok(Box::new(open(chunk)?));
    }
    let bare = chunk
        .clone()
        .into_builder()
        .set_compression(Compression::UNCOMPRESSED);
    let inner = open(&bare.build()?)?;
    Ok(Box::new(Unpacked { inner, codec }))
}

/// Pages that are read as they are stored, and unpacked.
struct Unpacked {
    inner: SerializedPageReader<File>,
    codec: Compression,
}

impl Unpacked {
    fn unpack(&self, packed: &[u8]) -> Result<Vec<u8>, ParquetError> {
        let mut plain = Vec::new();
        if packed.is_empty() {
            return Ok(plain);
        }
        let broken = |error: String| {
            ParquetError::General(format!("a page that cannot be unpacked: {error}"))
        };
        match self.codec {
            Compression::ZSTD(_) => {
                let stream =
                    StreamingDecoder::new(packed).map_err(|error| broken(error.to_string()))?;
                stream.take(LARGEST + 1).read_to_end(&mut plain)
            }
            _ => MultiGzDecoder::new(packed)
                .take(LARGEST + 1)
                .read_to_end(&mut plain),
        }
        .map_err(|error| broken(error.to_string()))?;
        match plain.len() as u64 > LARGEST {
            true => Err(broken("it holds more than 1 GiB".into())),
            false => Ok(plain),
        }
    }

    fn page(&self, mut page: Page) -> Result<Page, ParquetError> {
        match &mut page {
            Page::DataPage { buf, .. } | Page::DictionaryPage { buf, .. } => {
                *buf = self.unpack(buf)?.into();
            }
            Page::DataPageV2 {
                buf,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed: true,
                ..
            } => {
                // The levels stand before the values, as they are.
                let levels =
                    (*def_levels_byte_len as usize).saturating_add(*rep_levels_byte_len as usize);
                let (levels, packed) = buf.split_at_checked(levels).ok_or_else(|| {
                    ParquetError::General("a page that ends within its levels".into())
                })?;
                let mut plain = levels.to_vec();
                plain.extend(self.unpack(packed)?);
                *buf = plain.into();
            }
            Page::DataPageV2 { .. } => {}
        }
        Ok(page)
    }
}

impl Iterator for Unpacked {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Unpacked {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        let page = self.inner.get_next_page()?;
        page.map(|page| self.page(page)).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        self.inner.skip_next_page()
    }
}
