//! Files that are there whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::WriteError;

/// Writes a file beside its place, flushes it to the disk, and renames it: whoever looks sees the old file
/// or the new one, never half of it.
///
/// # Errors
/// [`WriteError::Io`] when the operating system refuses, and whatever `write` returns; the file at `path` is
/// then as it was.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut side = tempfile::Builder::new();
    side.prefix(".piezotact-").suffix(".tmp");
    // A file that others may read, as every file that a person's program writes.
    #[cfg(unix)]
    side.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let side = side.tempfile_in(folder).map_err(WriteError::io(path))?;
    {
        let mut buffer = BufWriter::with_capacity(1 << 16, side.as_file());
        write(&mut buffer)?;
        buffer.flush().map_err(WriteError::io(path))?;
    }
    side.as_file().sync_all().map_err(WriteError::io(path))?;
    side.persist(path).map_err(|failed| WriteError::Io {
        path: path.into(),
        source: failed.error,
    })?;
    // The rename itself is on the disk when the folder is. Not every file system allows that.
    if let Ok(folder) = File::open(folder) {
        let _best_effort = folder.sync_all();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept");
        std::fs::write(&path, "old").unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"half").unwrap();
            Err(WriteError::content(&path, "a", "b", "c"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
