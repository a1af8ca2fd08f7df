//! How many changes of a study were acknowledged, in a file beside the database.
//!
//! SQLite opens a write-ahead log as far as its checksums hold: a log that was cut or damaged loses its last commits without a word,
//! and what is left is a chain that verifies. The seal makes that an error. It is written after each commit and before the answer is
//! acknowledged, in two places by turns, so that a write that was cut leaves the one before.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// The name of the file.
pub(super) const SEAL: &str = "study.seal";
/// Where the two places begin, in bytes: on different pages of a disk.
const PLACES: [u64; 2] = [0, 4096];
/// Bytes of a place: identity of the study, number, checksum, each behind a space but the first, and a line end.
const LENGTH: usize = 32 + 1 + 20 + 1 + 8 + 1;

/// What a seal says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sealed {
    /// The study, 32 hexadecimal digits.
    pub(super) study: String,
    /// How many changes were acknowledged.
    pub(super) changes: u64,
}

/// What is found at the place of a seal.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    Nothing,
    Damaged,
    Whole(Sealed),
}

/// The open file.
#[derive(Debug)]
pub(super) struct Seal {
    file: File,
    study: String,
}

impl Sealed {
    fn line(&self) -> String {
        let text = format!("{} {:020}", self.study, self.changes);
        format!("{text} {:08x}\n", crc32fast::hash(text.as_bytes()))
    }

    fn of_line(line: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(line).ok()?;
        let mut words = text.split_whitespace();
        let sealed = Self {
            study: words.next()?.to_owned(),
            changes: words.next()?.parse().ok()?,
        };
        (sealed.line() == text).then_some(sealed)
    }
}

/// The seal of the study in `folder`.
pub(super) fn find(folder: &Path) -> std::io::Result<Found> {
    let mut bytes = Vec::new();
    regular(&folder.join(SEAL))?;
    match File::open(folder.join(SEAL)) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Found::Nothing),
        Err(error) => return Err(error),
        Ok(file) => file.take(PLACES[1] * 2).read_to_end(&mut bytes)?,
    };
    let place = |at: u64| {
        let begin = at as usize;
        Sealed::of_line(bytes.get(begin..begin + LENGTH)?)
    };
    let latest = PLACES
        .iter()
        .filter_map(|at| place(*at))
        .max_by_key(|sealed| sealed.changes);
    Ok(latest.map_or(Found::Damaged, Found::Whole))
}

/// Refuses what is no file: a pipe waits for ever, and a link leads out of the study.
fn regular(path: &Path) -> std::io::Result<()> {
    match std::fs::symlink_metadata(path) {
        Ok(found) if !found.is_file() => Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "expected the file study.seal, found a link, a pipe, a device or a folder; restore it from a copy of the study",
        )),
        _ => Ok(()),
    }
}

impl Seal {
    /// The file in `folder`, which is made with `sealed` where it is not there.
    pub(super) fn open(folder: &Path, sealed: &Sealed) -> std::io::Result<Self> {
        let path = folder.join(SEAL);
        if !path.exists() {
            make(&path, sealed)?;
        }
        regular(&path)?;
        let file = File::options().write(true).open(&path)?;
        Ok(Self {
            file,
            study: sealed.study.clone(),
        })
    }

    /// Notes that `changes` are acknowledged; it is on the disk when this returns.
    pub(super) fn set(&mut self, changes: u64) -> std::io::Result<()> {
        let sealed = Sealed {
            study: self.study.clone(),
            changes,
        };
        self.file
            .seek(SeekFrom::Start(PLACES[(changes % 2) as usize]))?;
        self.file.write_all(sealed.line().as_bytes())?;
        self.file.sync_data()
    }
}

/// Writes a whole file with the same in both places, and puts it at `path`.
fn make(path: &Path, sealed: &Sealed) -> std::io::Result<()> {
    let line = sealed.line();
    let mut bytes = vec![b' '; PLACES[1] as usize + LENGTH];
    for at in PLACES {
        bytes[at as usize..at as usize + LENGTH].copy_from_slice(line.as_bytes());
    }
    let mut beside = path.to_owned().into_os_string();
    beside.push(".new");
    let beside = PathBuf::from(beside);
    let mut file = File::create(&beside)?;
    file.write_all(&bytes)?;
    file.sync_all()?;
    std::fs::rename(&beside, path)?;
    piezotact_dataset::atomic::sync_folder(path);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(changes: u64) -> Sealed {
        Sealed {
            study: "0123456789abcdef0123456789ABCDEF".into(),
            changes,
        }
    }

    #[test]
    fn a_seal_reads_back_and_survives_a_cut_write_at_every_byte() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(find(folder.path()).unwrap(), Found::Nothing);
        let mut seal = Seal::open(folder.path(), &sealed(1)).unwrap();
        seal.set(2).unwrap();
        seal.set(3).unwrap();
        assert_eq!(find(folder.path()).unwrap(), Found::Whole(sealed(3)));
        let before = std::fs::read(folder.path().join(SEAL)).unwrap();
        seal.set(4).unwrap();
        let after = std::fs::read(folder.path().join(SEAL)).unwrap();
        for cut in 0..=LENGTH {
            let mut bytes = before.clone();
            bytes[..cut].copy_from_slice(&after[..cut]);
            std::fs::write(folder.path().join(SEAL), &bytes).unwrap();
            let Found::Whole(found) = find(folder.path()).unwrap() else {
                panic!("cut at {cut}");
            };
            // The last digits of both checksums may be the same.
            assert!(
                found.changes == 3 || cut > LENGTH - 8 && found.changes == 4,
                "{cut}"
            );
        }
        std::fs::write(folder.path().join(SEAL), "nothing").unwrap();
        assert_eq!(find(folder.path()).unwrap(), Found::Damaged);
    }
}
