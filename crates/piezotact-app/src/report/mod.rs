//! Reports: one HTML file that holds everything it shows.

pub(crate) mod replay;

use std::path::Path;

pub(crate) use piezotact_report::broad_document;
use piezotact_report::criteria;

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
