//! The files that the bench of a panel is made of: a bench is the same where they hold the same.

use std::path::Path;

use piezotact::checksum::Checksum;
use serde::{Deserialize, Serialize};

use crate::error::ReadError;

/// A file that a bench is made of, as a device description, a script or a transfer function, by its checksum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BenchFile {
    /// The file, as it was named.
    pub file: String,
    /// The checksum of its bytes.
    pub checksum: Checksum,
}

impl BenchFile {
    /// The file at `path`, as it is now.
    ///
    /// # Errors
    /// [`ReadError::Io`] when it cannot be read.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let bytes = std::fs::read(path).map_err(|error| ReadError::io(path, &error))?;
        Ok(Self {
            file: path.display().to_string(),
            checksum: Checksum::of_bytes(&bytes),
        })
    }

    /// The first of `now` that held something else `before`.
    pub(super) fn changed<'a>(before: &[Self], now: &'a [Self]) -> Option<&'a Self> {
        let other = |now: &&Self| {
            before
                .iter()
                .any(|before| before.file == now.file && before.checksum != now.checksum)
        };
        now.iter().find(other)
    }
}
