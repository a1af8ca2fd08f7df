//! Inputs: regular files. A device never ends and a pipe waits for ever: both are refused before anything is read.

use std::fs::File;
use std::io::{Error, ErrorKind, Read as _};
use std::path::Path;

use crate::error::ReadError;

/// The file at `path`, opened for reading.
///
/// # Errors
/// [`ReadError::Io`] when it is no regular file or cannot be opened.
pub fn open_input(path: &Path) -> Result<File, ReadError> {
    opened(path).map_err(|error| ReadError::io(path, &error))
}

/// All bytes of the file at `path`.
///
/// # Errors
/// As [`open_input`], and when it cannot be read.
pub fn read_input(path: &Path) -> Result<Vec<u8>, ReadError> {
    bytes(path).map_err(|error| ReadError::io(path, &error))
}

/// The text in the file at `path`, in UTF-8.
///
/// # Errors
/// As [`read_input`], and when it is no text.
pub fn read_input_text(path: &Path) -> Result<String, ReadError> {
    text(path).map_err(|error| ReadError::io(path, &error))
}

/// As [`read_input_text`], for callers that say themselves what a missing file means.
pub(crate) fn text(path: &Path) -> Result<String, Error> {
    let mut text = String::new();
    opened(path)?.read_to_string(&mut text)?;
    Ok(text)
}

fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    opened(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Looks at the kind of the file before it is opened, since opening a pipe waits for its other end.
fn opened(path: &Path) -> Result<File, Error> {
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(Error::from(ErrorKind::IsADirectory));
    }
    if !found.is_file() {
        return Err(Error::new(
            ErrorKind::InvalidInput,
            "expected a file, found a device or a pipe; write its data to a file first",
        ));
    }
    File::open(path)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn devices_and_folders_are_refused_at_once() {
        for (path, part) in [
            ("/dev/zero", "found a device or a pipe"),
            ("/", "found a folder"),
            ("/nowhere/at/all", "found none there"),
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
