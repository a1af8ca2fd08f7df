//! The version of our JSON files, so that a file of a newer program is refused by name and not misread.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::ReadError;

/// The version that this program writes; a file that a person writes may leave it out.
const FORMAT: u32 = 1;

/// A document with its version in front of its fields.
#[derive(Serialize)]
pub(crate) struct Versioned<'a, T> {
    format: u32,
    #[serde(flatten)]
    document: &'a T,
}

impl<'a, T> Versioned<'a, T> {
    /// `document` as this program writes it.
    pub(crate) fn of(document: &'a T) -> Self {
        Self {
            format: FORMAT,
            document,
        }
    }
}

/// Refuses the JSON text `text` of the file at `path` when a newer program wrote it; what is no JSON is not judged here.
pub(crate) fn refuse_newer(path: &Path, text: &[u8]) -> Result<(), ReadError> {
    #[derive(Deserialize)]
    struct Version {
        format: serde_json::Value,
    }
    match serde_json::from_slice(text) {
        Ok(Version { format })
            if format
                .as_str()
                .is_some_and(|f| f.starts_with("piezotact panel ")) =>
        {
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty());
            Err(ReadError::content(
                path,
                "another file of Piezotact",
                "the index of a panel",
                format!(
                    "read it with `piezotact panel analyse {}`",
                    folder.unwrap_or(Path::new(".")).display()
                ),
            ))
        }
        Ok(Version { format }) if format.as_u64().is_none_or(|f| f > u64::from(FORMAT)) => {
            Err(ReadError::content(
                path,
                format!("a file of format {FORMAT} or before"),
                format!("format {format}"),
                "read it with a newer version of the program",
            ))
        }
        _ => Ok(()),
    }
}
