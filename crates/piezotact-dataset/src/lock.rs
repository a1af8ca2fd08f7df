//! File locks for exclusive writing: the operating system releases a lock when the process that holds it ends for any reason.

use crate::error::WriteError;
use std::fs::{File, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The number of attempts and the delay between them when waiting for a lock: long enough for one filing, not for a campaign.
const ATTEMPTS: u32 = 100;
const PAUSE: Duration = Duration::from_millis(50);

/// Whether the file of a lock is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockFile {
    /// The file is kept; other programs wait a few seconds for the lock.
    Stays,
    /// The file is removed at the end; other programs do not wait for the lock.
    Goes,
}

/// A held lock: the exclusive right to write, until its last clone is dropped.
#[derive(Clone, Debug)]
pub struct Lock {
    _held: Arc<Held>,
}

#[derive(Debug)]
struct Held {
    _file: File,
    goes: Option<PathBuf>,
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(path) = &self.goes {
            // While it is held; one that stays does no harm, as nobody holds it then.
            let _best_effort = std::fs::remove_file(path);
        }
    }
}

impl PartialEq for Lock {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Lock {
    /// The lock of the file at `path`, which is made where it is not there.
    ///
    /// # Errors
    /// [`WriteError::Held`] while another program has it, [`WriteError::Io`].
    pub fn take(path: &Path, kind: LockFile) -> Result<Self, WriteError> {
        Self::tried(path, kind)
            .map_err(WriteError::io(path))?
            .map_err(|by| WriteError::Held {
                path: path.into(),
                by,
            })
    }

    /// The lock, or who holds it.
    fn tried(path: &Path, kind: LockFile) -> std::io::Result<Result<Self, String>> {
        let attempts = match kind {
            LockFile::Stays => ATTEMPTS,
            LockFile::Goes => 1,
        };
        let mut attempt = 1;
        loop {
            require_no_link(path)?;
            let mut file = File::options()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(path)?;
            match file.try_lock() {
                // Its holder may have removed the file between the two: the lock of another one is none.
                Ok(()) if !is_at(&file, path) => {}
                Ok(()) => {
                    require_own(&mut file)?;
                    // For whoever waits: who it is.
                    file.set_len(0)?;
                    write!(file, "{}", std::process::id())?;
                    let goes = (kind == LockFile::Goes).then(|| path.to_owned());
                    return Ok(Ok(Self {
                        _held: Arc::new(Held { _file: file, goes }),
                    }));
                }
                Err(TryLockError::WouldBlock) if attempt < attempts => {
                    attempt += 1;
                    std::thread::sleep(PAUSE);
                }
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    return Ok(Err(match file.read_to_string(&mut holder) {
                        Ok(_) if !holder.is_empty() => format!("process {holder}"),
                        _ => "another program".into(),
                    }));
                }
                Err(TryLockError::Error(error)) => return Err(error),
            }
        }
    }
}

/// Refuses a link: what it leads to is not ours to empty.
fn require_no_link(path: &Path) -> std::io::Result<()> {
    let is_link = std::fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
    match is_link {
        true => Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "expected a lock file or none, found a link; remove it",
        )),
        false => Ok(()),
    }
}

/// Refuses a file that is none of our locks: these hold nothing, or the number of a process.
fn require_own(file: &mut File) -> std::io::Result<()> {
    let mut found = Vec::new();
    file.take(16).read_to_end(&mut found)?;
    file.rewind()?;
    match found.len() <= 10 && found.iter().all(u8::is_ascii_digit) {
        true => Ok(()),
        false => Err(std::io::Error::new(
            std::io::ErrorKind::AlreadyExists,
            "expected a lock file or none, found another file; move it, or use another name",
        )),
    }
}

/// Whether an open file is the one that stands at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let (Ok(open), Ok(there)) = (file.metadata(), std::fs::metadata(path)) else {
        return false;
    };
    (open.dev(), open.ino()) == (there.dev(), there.ino())
}

/// Elsewhere a file that is open is not removed.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_holder_at_a_time_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lock");
        // A lock file left by a killed program is not locked.
        std::fs::write(&path, "1").unwrap();
        let first = Lock::take(&path, LockFile::Goes).unwrap();
        let clone = first.clone();
        drop(first);
        let held = Lock::take(&path, LockFile::Goes).unwrap_err();
        let own = format!("process {}", std::process::id());
        assert!(matches!(held, WriteError::Held { by, .. } if by == own));
        drop(clone);
        assert!(!path.exists());
        let _again = Lock::take(&path, LockFile::Goes).unwrap();
        // Neither a file of somebody else nor what a link leads to is emptied or removed.
        let foreign = folder.path().join("thesis.lock");
        std::fs::write(&foreign, "chapter 6").unwrap();
        let refused = Lock::take(&foreign, LockFile::Goes).unwrap_err();
        assert!(matches!(refused, WriteError::Io { .. }));
        #[cfg(unix)]
        {
            let link = folder.path().join("link.lock");
            std::os::unix::fs::symlink(&foreign, &link).unwrap();
            let refused = Lock::take(&link, LockFile::Goes).unwrap_err();
            assert!(matches!(refused, WriteError::Io { .. }));
        }
        assert_eq!(std::fs::read_to_string(&foreign).unwrap(), "chapter 6");
    }
}
