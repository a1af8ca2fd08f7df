//! One writer at a time.

use std::fs::{File, TryLockError};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::error::ReadError;

/// The file whose lock a writer holds; the operating system gives it back when the writer ends, however it ends.
const PANEL_LOCK: &str = "panel.lock";
/// How often and how far apart a lock is asked for: filing takes less than that, a campaign longer.
const ATTEMPTS: u32 = 100;
const PAUSE: Duration = Duration::from_millis(50);

/// The right to write to a folder, as long as one of its clones is there.
#[derive(Clone, Debug)]
pub(super) struct Lock {
    _held: Arc<File>,
}

impl PartialEq for Lock {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Lock {
    /// Waits a few seconds for the lock of `folder`.
    pub(super) fn take(folder: &Path) -> Result<Self, ReadError> {
        let path = folder.join(PANEL_LOCK);
        let io = |error: std::io::Error| ReadError::io(&path, &error);
        let mut file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(io)?;
        for attempt in 1..=ATTEMPTS {
            match file.try_lock() {
                Ok(()) => {
                    // For whoever waits: who it is.
                    file.set_len(0).map_err(io)?;
                    write!(file, "{}", std::process::id()).map_err(io)?;
                    return Ok(Self {
                        _held: Arc::new(file),
                    });
                }
                Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => std::thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => return Err(io(error)),
            }
        }
        let mut holder = String::new();
        let holder = match file.read_to_string(&mut holder) {
            Ok(_) if !holder.is_empty() => format!("process {holder}, which does"),
            _ => "another program, which does".into(),
        };
        Err(ReadError::content(
            &path,
            "nobody who is writing to this panel",
            holder,
            "wait until it has ended, and give the command again",
        ))
    }
}

/// Removes what a writer that was killed has left unfinished; nobody else writes while the lock is held.
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
