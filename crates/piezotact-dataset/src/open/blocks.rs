//! Recordings that are larger than memory, read in blocks of samples.

use std::path::{Path, PathBuf};

use piezotact::recording::Recording;

use super::{Contents, FileKind, ReadOptions, beside, contents_of, not_a_sample};
use crate::error::ReadError;
use crate::format::Opened;
use crate::recording_file::ParquetBlocks;
use crate::tdms::{TdmsBlocks, looks_like_tdms};

/// A recording whose samples are read in blocks, as often as they are needed.
#[derive(Debug)]
pub struct RecordingInBlocks {
    path: PathBuf,
    contents: Contents,
    samples: usize,
    source: Source,
}

#[derive(Debug)]
enum Source {
    Parquet(ParquetBlocks),
    Tdms(TdmsBlocks),
}

/// The recording in `path` to be read in blocks, where its samples take more than `beyond_bytes` in memory. `None` where they take less,
/// and where it has to be read whole: other formats than Parquet and TDMS, several clocks, times that are not even, gaps and codes for no
/// data, a file that ends too early, a file beside it that completes it.
///
/// # Errors
/// As [`super::read_recording`], as far as they show without the samples.
pub fn recording_in_blocks(
    path: &Path,
    options: &ReadOptions,
    beyond_bytes: u64,
) -> Result<Option<RecordingInBlocks>, ReadError> {
    if options.part.is_some_and(|part| part != 1) || !path.is_file() {
        return Ok(None);
    }
    let file = Opened::open(path)?;
    let (source, stored, kind) = if file.head().starts_with(b"PAR1") {
        match ParquetBlocks::of(path, options, beyond_bytes)? {
            Some((source, stored)) => (Source::Parquet(source), stored, FileKind::PARQUET),
            None => return Ok(None),
        }
    } else if looks_like_tdms(file.head()) {
        match TdmsBlocks::of(path, options, beyond_bytes)? {
            Some((source, stored)) => (Source::Tdms(source), stored, FileKind::TDMS),
            None => return Ok(None),
        }
    } else {
        return Ok(None);
    };
    let mut contents = contents_of(stored, kind);
    let unread = beside::unread(path, kind);
    contents.recording.about.warnings.extend(unread);
    Ok(Some(RecordingInBlocks {
        path: path.into(),
        samples: source.samples(),
        source,
        contents,
    }))
}

impl Source {
    fn samples(&self) -> usize {
        match self {
            Self::Parquet(of) => of.samples,
            Self::Tdms(of) => of.samples,
        }
    }

    fn each<E: From<ReadError>>(
        &self,
        path: &Path,
        channels: &[&str],
        block: usize,
        take: &mut dyn FnMut(Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Self::Parquet(of) => of.each(path, channels, block, take),
            Self::Tdms(of) => of.each(path, channels, block, take),
        }
    }
}

impl RecordingInBlocks {
    /// All that is known of the recording but its samples: its channels hold none.
    #[must_use]
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// The number of samples of every channel.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Gives the samples of the `channels`, of those alone and in the order of the file, to `take`: the number of the first, and a
    /// recording of at most `block` samples, which are those that [`super::read_recording`] gives. Where all channels are read, the
    /// checksum of a file of ours is compared at the end.
    ///
    /// # Errors
    /// [`ReadError`] as of the whole file, and what `take` returns.
    pub fn each<E: From<ReadError>>(
        &self,
        channels: &[&str],
        block: usize,
        mut take: impl FnMut(usize, &Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut first = 0;
        let path = self.path.as_path();
        self.source.each(path, channels, block.max(1), &mut |of| {
            let mut channels = of.channels().iter();
            if let Some(bad) = channels.find_map(|one| not_a_sample(path, one, of.rate(), first)) {
                return Err(bad.into());
            }
            take(first, &of)?;
            first += of.len();
            Ok::<(), E>(())
        })?;
        match first == self.samples {
            true => Ok(()),
            false => Err(E::from(ReadError::content(
                path,
                format!("{} samples in every channel", self.samples),
                format!("{first}"),
                "it changed while it was read, or is damaged: copy it again",
            ))),
        }
    }
}
