//! One writer at a time.

use std::path::Path;

use crate::error::{ReadError, WriteError};
use crate::lock::{Lock, LockFile};

/// The file whose lock a writer holds.
const PANEL_LOCK: &str = "panel.lock";

/// Waits a few seconds for the lock of `folder`.
pub(super) fn take(folder: &Path) -> Result<Lock, ReadError> {
    let path = folder.join(PANEL_LOCK);
    Lock::take(&path, LockFile::Stays).map_err(|error| match error {
        WriteError::Held { by, .. } => ReadError::content(
            &path,
            "no other command that writes to this panel",
            format!("{by}, which is writing to it"),
            "wait until it has finished, and give the command again",
        ),
        other => ReadError::of(folder)(other),
    })
}

/// Removes unfinished files of a killed writer; no other program writes while the lock is held.
pub(super) fn remove_unfinished(folder: &Path) {
    let Ok(found) = std::fs::read_dir(folder) else {
        return;
    };
    for file in found.filter_map(Result::ok) {
        let name = file.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(".piezotact-") && name.ends_with(".tmp") {
            // What stays does no harm.
            let _best_effort = std::fs::remove_file(file.path());
        }
    }
}
