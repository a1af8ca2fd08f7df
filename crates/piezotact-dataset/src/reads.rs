//! Every file that this program reads, noted, so that results can state what they were made from.
//!
//! All reading of files goes through this module (`xtask tidy` checks it), so that no format can forget to be noted.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use piezotact::invocation::{Found, Input};
use sha2::{Digest as _, Sha256};

/// What was read or looked for, in the order of the first reading.
static NOTED: Mutex<AllNoted> = Mutex::new(AllNoted {
    known: BTreeSet::new(),
    list: Vec::new(),
});

thread_local! {
    /// What was read within [`apart`].
    static APART: RefCell<Option<AllNoted>> = const { RefCell::new(None) };
}

#[derive(Default)]
struct AllNoted {
    known: BTreeSet<PathBuf>,
    list: Vec<Noted>,
}

struct Noted {
    path: PathBuf,
    /// Length and time of the last change; `None` where there was no file.
    state: Option<(u64, Option<SystemTime>)>,
}

/// Does `work`, within which [`inputs`] are what this thread read since it began, and not what the program read.
pub fn apart<T>(work: impl FnOnce() -> T) -> T {
    let outer = APART.replace(Some(AllNoted::default()));
    let done = work();
    APART.set(outer);
    done
}

/// What `then` does with what was noted until now.
fn noted<T>(then: impl FnOnce(&mut AllNoted) -> T) -> T {
    APART.with_borrow_mut(|apart| match apart {
        Some(apart) => then(apart),
        None => then(&mut NOTED.lock().unwrap_or_else(PoisonError::into_inner)),
    })
}

/// All bytes of the file at `path`, which is noted.
///
/// # Errors
/// Where it is no regular file, and those of the operating system.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of the file at `path`, which is noted.
///
/// # Errors
/// As [`read`], and a text that is not UTF-8.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Whether something stands at `path`, which is noted: a file that may be there, such as cuts beside a recording.
#[must_use]
pub fn is_there(path: &Path) -> bool {
    note(path);
    path.exists()
}

/// The file at `path`, opened for reading, which is noted. A device never ends and a pipe waits for ever: both are refused, before
/// they are opened, as opening a pipe waits for its other end.
///
/// # Errors
/// Where it is no regular file, and those of the operating system.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    note(path);
    open_regular(path)
}

fn open_regular(path: &Path) -> io::Result<File> {
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    if !found.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "expected a file, found a device or a pipe; write its data to a file first",
        ));
    }
    File::open(path)
}

/// Notes that `path` is read, or was looked for in vain. Folders, pipes and devices are not noted.
fn note(path: &Path) {
    let state = match std::fs::metadata(path) {
        Ok(found) if found.is_file() => Some(state_of(&found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        _ => return,
    };
    noted(|noted| {
        if noted.known.insert(path.to_owned()) {
            noted.list.push(Noted {
                path: path.to_owned(),
                state,
            });
        }
    });
}

/// Notes that the file at `from`, which may have been read, is now at `to`: it is an input under its new name.
pub(crate) fn moved(from: &Path, to: &Path) {
    noted(|noted| {
        for one in &mut noted.list {
            // Without a file there was nothing to move.
            if one.path == from && one.state.is_some() {
                one.path = to.to_owned();
            }
        }
        noted.known.remove(from);
    });
}

fn state_of(found: &Metadata) -> (u64, Option<SystemTime>) {
    (found.len(), found.modified().ok())
}

/// The files that this program read or looked for until now, except those that `own` accepts: its own outputs. Checksums are
/// those of the files as they are now; a file that changed since it was read has none.
#[must_use]
pub fn inputs(own: impl Fn(&Path) -> bool) -> Vec<Input> {
    let input = |noted: &Noted| Input {
        path: noted.path.display().to_string(),
        found: match noted.state {
            None => Found::Nothing,
            Some(state) => found_at(&noted.path, Some(state)),
        },
    };
    noted(|noted| {
        let foreign = noted.list.iter().filter(|noted| !own(&noted.path));
        foreign.map(input).collect()
    })
}

/// What is found at `path` now.
#[must_use]
pub fn found(path: &Path) -> Found {
    found_at(path, None)
}

fn found_at(path: &Path, before: Option<(u64, Option<SystemTime>)>) -> Found {
    let now = std::fs::metadata(path).ok().filter(Metadata::is_file);
    let Some(now) = now else {
        return match before {
            Some(_) => Found::Changed,
            None => Found::Nothing,
        };
    };
    match sha256_of_file(path) {
        Ok(sha256) if before.is_none_or(|before| before == state_of(&now)) => Found::File {
            bytes: now.len(),
            sha256,
        },
        _ => Found::Changed,
    }
}

/// The SHA-256 of what `path` holds, as 64 hexadecimal digits.
///
/// # Errors
/// What the system says where it cannot be read.
pub fn sha256_of_file(path: &Path) -> io::Result<String> {
    let mut file = open_regular(path)?;
    let mut sum = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hexadecimal(&sum.finalize())),
            count => sum.update(&buffer[..count]),
        }
    }
}

/// SHA-256 of `bytes`, 64 hexadecimal digits.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// `bytes` as hexadecimal digits, two for each.
#[must_use]
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vector of FIPS 180-4 for "abc".
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

    #[test]
    fn what_is_read_is_noted_with_its_checksum_and_what_is_missing_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("abc"), "abc").unwrap();
        std::fs::write(path("grows"), "a").unwrap();
        std::fs::write(path("own"), "a").unwrap();
        for name in ["abc", "abc", "none", "grows", "own"] {
            let _read = read(&path(name));
        }
        std::fs::write(path("grows"), "longer").unwrap();
        // What is kept under another name stays an input, and the new file of its name is none until it is read.
        std::fs::rename(path("abc"), path("abc.before-1")).unwrap();
        moved(&path("abc"), &path("abc.before-1"));
        std::fs::write(path("abc"), "new").unwrap();
        let found = inputs(|path| path.ends_with("own"));
        let here = folder.path().display().to_string();
        let found: Vec<(&str, &Found)> = found
            .iter()
            .filter_map(|input| Some((input.path.strip_prefix(&here)?, &input.found)))
            .collect();
        let abc = Found::File {
            bytes: 3,
            sha256: ABC.into(),
        };
        let expected = [
            ("/abc.before-1", &abc),
            ("/none", &Found::Nothing),
            ("/grows", &Found::Changed),
        ];
        assert_eq!(found, expected);
        // What is read apart is no input of what goes on, nor the other way round.
        let within = apart(|| {
            let _read = read(&path("own"));
            inputs(|_| false)
        });
        assert_eq!(within.len(), 1, "{within:?}");
        assert!(
            inputs(|path| !path.ends_with("own"))
                .iter()
                .any(|input| input.path.starts_with(&here))
        );
        assert_eq!(sha256(b"abc"), ABC);
        assert_eq!(super::found(&path("abc.before-1")), abc);
    }
}
