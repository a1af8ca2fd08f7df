//! Inputs: regular files, with the name of the file in the error.

use std::fs::File;
use std::path::Path;

use crate::error::ReadError;
use crate::reads;

/// The file at `path`, opened for reading.
///
/// # Errors
/// [`ReadError::Io`] when it is no regular file or cannot be opened.
pub fn open_input(path: &Path) -> Result<File, ReadError> {
    reads::open(path).map_err(|error| ReadError::io(path, &error))
}

/// All bytes of the file at `path`.
///
/// # Errors
/// As [`open_input`], and when it cannot be read.
pub fn read_input(path: &Path) -> Result<Vec<u8>, ReadError> {
    reads::read(path).map_err(|error| ReadError::io(path, &error))
}

/// The text in the file at `path`, in UTF-8.
///
/// # Errors
/// As [`read_input`], and when it is no text.
pub fn read_input_text(path: &Path) -> Result<String, ReadError> {
    reads::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => ReadError::content(
            path,
            "text in UTF-8",
            "other bytes",
            "save it as text; a certificate or a key as PEM",
        ),
        _ => ReadError::io(path, &error),
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_text_is_called_so() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [0x30, 0x82, 0xff, 0xfe]).unwrap();
        let error = read_input_text(file.path()).unwrap_err().to_string();
        assert!(error.contains("expected text in UTF-8"), "{error}");
    }

    #[test]
    fn devices_and_folders_are_refused_at_once() {
        for (path, part) in [
            ("/dev/zero", "found a device or a pipe"),
            ("/", "is a folder: give a file"),
            ("/nowhere/at/all", "no such file: /nowhere/at/all"),
        ] {
            let path = Path::new(path);
            for error in [
                open_input(path).map(drop).unwrap_err(),
                read_input(path).map(drop).unwrap_err(),
                read_input_text(path).map(drop).unwrap_err(),
            ] {
                assert!(error.to_string().contains(part), "{error}");
            }
        }
    }
}
