//! A folder that is filled aside and renamed when it is complete.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read as _, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use super::error::BidsError;
use piezotact_dataset::WriteError;
use piezotact_dataset::atomic::{UNFINISHED, difference, sync_folder};
use piezotact_dataset::lock::{Lock, LockFile};
use piezotact_dataset::open_input;
use piezotact_dataset::reads::{hexadecimal, sha256_of_file};

/// A folder that is being filled; without [`Self::commit`] nothing is left of it. Where the same folder stands already, it stays.
#[derive(Debug)]
pub struct NewFolder {
    place: PathBuf,
    side: tempfile::TempDir,
    sums: BTreeMap<String, String>,
    _alone: Lock,
}

/// What stands at a place.
#[derive(Clone, Copy, PartialEq, Eq)]
enum There {
    /// Nothing, or an empty folder.
    Nothing,
    Folder,
    Other,
}

fn found_at(place: &Path) -> There {
    match std::fs::symlink_metadata(place) {
        Err(_none) => There::Nothing,
        Ok(found) if found.is_dir() => {
            match std::fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none()) {
                true => There::Nothing,
                false => There::Folder,
            }
        }
        Ok(_) => There::Other,
    }
}

/// The files below `folder` from there, with slashes; what is neither a file nor a folder counts as a file.
fn files_below(folder: &Path) -> std::io::Result<Vec<String>> {
    let (mut files, mut open) = (Vec::new(), vec![(folder.to_owned(), String::new())]);
    while let Some((folder, name)) = open.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            let name = format!("{name}{}", entry.file_name().to_string_lossy());
            match entry.file_type()?.is_dir() {
                true => open.push((entry.path(), format!("{name}/"))),
                false => files.push(name),
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Refuses a `place` inside `folder`, which is read.
///
/// # Errors
/// [`BidsError::Inside`].
pub fn require_outside(folder: &Path, place: &Path) -> Result<(), BidsError> {
    let root = folder.canonicalize();
    let above = place.ancestors().find_map(|above| match above.as_os_str() {
        here if here.is_empty() => Path::new(".").canonicalize().ok(),
        _ => above.canonicalize().ok(),
    });
    match (root, above) {
        (Ok(root), Some(above)) if above.starts_with(&root) => Err(BidsError::Inside {
            folder: place.to_owned(),
        }),
        _ => Ok(()),
    }
}

/// How many letters and digits a temporary folder has behind its prefix.
const RANDOM: usize = 6;

/// Whether `name` is a folder that this module began with `prefix`, and not one of a longer name.
fn is_of(prefix: &str, name: &str) -> bool {
    name.strip_prefix(prefix).is_some_and(|rest| {
        rest.len() == RANDOM && rest.bytes().all(|byte| byte.is_ascii_alphanumeric())
    })
}

impl NewFolder {
    /// Begins a folder that will stand at `place`. What a killed program left of it is removed.
    ///
    /// # Errors
    /// [`BidsError::Exists`] where something other than a folder stands there, [`BidsError::Held`] while another program writes it,
    /// [`BidsError::Write`].
    pub fn beside(place: &Path) -> Result<Self, BidsError> {
        let taken = |found: &str| BidsError::Exists {
            folder: place.to_owned(),
            found: found.to_owned(),
        };
        if found_at(place) == There::Other {
            return Err(taken("a file or a link"));
        }
        let Some(name) = place.file_name().and_then(|name| name.to_str()) else {
            return Err(taken("no name for one"));
        };
        let parent = match place.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(parent).map_err(BidsError::io(parent))?;
        let lock = parent.join(format!("{UNFINISHED}{name}.lock"));
        let alone = Lock::take(&lock, LockFile::Goes).map_err(|error| match error {
            WriteError::Held { .. } => BidsError::Held {
                folder: place.to_owned(),
            },
            other => other.into(),
        })?;
        let prefix = format!("{UNFINISHED}{name}-");
        let left = std::fs::read_dir(parent).into_iter().flatten().flatten();
        for entry in left {
            let is_ours = is_of(&prefix, &entry.file_name().to_string_lossy());
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if is_ours && is_folder {
                // Nobody else writes it: the lock is ours.
                let _stays = std::fs::remove_dir_all(entry.path());
            }
        }
        let side = tempfile::Builder::new()
            .prefix(&prefix)
            .rand_bytes(RANDOM)
            .tempdir_in(parent);
        let side = side.map_err(BidsError::io(parent))?;
        Ok(Self {
            place: place.to_owned(),
            side,
            sums: BTreeMap::new(),
            _alone: alone,
        })
    }

    /// Refuses the file `name` where another one stands in its place.
    fn require_same(&self, name: &str) -> Result<(), BidsError> {
        if found_at(&self.place) == There::Nothing {
            return Ok(());
        }
        let there = self.place.join(name);
        let found = match std::fs::symlink_metadata(&there) {
            Ok(found) if found.is_file() => {
                let at = difference(&self.side.path().join(name), &there);
                match at.map_err(BidsError::io(&there))? {
                    None => return Ok(()),
                    Some(at) => format!("another {name}, which differs {at}"),
                }
            }
            _ => format!("a folder with files and without {name}"),
        };
        Err(BidsError::Exists {
            folder: self.place.clone(),
            found,
        })
    }

    /// Refuses what stands in the place of the folder, unless it is the same.
    fn require_same_folder(&self) -> Result<(), BidsError> {
        let files = files_below(self.side.path()).map_err(BidsError::io(self.side.path()))?;
        files.iter().try_for_each(|name| self.require_same(name))?;
        let there = files_below(&self.place).map_err(BidsError::io(&self.place))?;
        match there.iter().find(|name| !files.contains(name)) {
            None => Ok(()),
            Some(other) => Err(BidsError::Exists {
                folder: self.place.clone(),
                found: format!("{other} beside them"),
            }),
        }
    }

    /// Writes the file `name` (from the root, with slashes), which must not be there yet, flushed to the disk. One that differs from
    /// what stands in its place is refused at once.
    pub(super) fn put(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), BidsError>,
    ) -> Result<(), BidsError> {
        let path = self.path(name)?;
        // A name that was there before would be a fault of labels.
        let file = File::create_new(&path).map_err(BidsError::io(Path::new(name)))?;
        let mut out = Summed {
            out: BufWriter::with_capacity(1 << 16, &file),
            sum: Sha256::new(),
        };
        fill(&mut out)?;
        let Summed { mut out, sum } = out;
        out.flush().map_err(BidsError::io(Path::new(name)))?;
        drop(out);
        file.sync_data().map_err(BidsError::io(Path::new(name)))?;
        self.sums
            .insert(name.to_owned(), hexadecimal(&sum.finalize()));
        self.require_same(name)
    }

    /// Writes the text file `name` (from the root, with slashes), flushed to the disk.
    ///
    /// # Errors
    /// [`BidsError::Write`].
    pub fn put_text(&mut self, name: &str, text: &str) -> Result<(), BidsError> {
        self.put(name, |out| {
            out.write_all(text.as_bytes())
                .map_err(BidsError::io(Path::new(name)))
        })
    }

    pub(super) fn put_json(&mut self, name: &str, value: &impl Serialize) -> Result<(), BidsError> {
        let text = serde_json::to_string_pretty(value);
        let mut text = text.map_err(|error| BidsError::file(name, None, error.to_string()))?;
        text.push('\n');
        self.put_text(name, &text)
    }

    /// Copies the file at `from`, bit by bit.
    ///
    /// # Errors
    /// [`BidsError::Read`], [`BidsError::Write`].
    pub fn copy(&mut self, name: &str, from: &Path) -> Result<(), BidsError> {
        let mut read = BufReader::with_capacity(1 << 16, open_input(from)?);
        self.put(name, |out| {
            let mut bytes = vec![0; 1 << 16];
            loop {
                let count = read.read(&mut bytes).map_err(|error| {
                    BidsError::Read(piezotact_dataset::ReadError::io(from, &error))
                })?;
                if count == 0 {
                    return Ok(());
                }
                out.write_all(&bytes[..count])
                    .map_err(BidsError::io(Path::new(name)))?;
            }
        })
    }

    /// Counts the file `name`, which somebody else wrote at [`Self::path`], among those of the folder.
    pub(super) fn adopt(&mut self, name: &str) -> Result<(), BidsError> {
        let sum = sha256_of_file(&self.side.path().join(name));
        let sum = sum.map_err(BidsError::io(Path::new(name)))?;
        self.sums.insert(name.to_owned(), sum);
        Ok(())
    }

    /// Whether the file `name` was written.
    pub(super) fn holds(&self, name: &str) -> bool {
        self.sums.contains_key(name)
    }

    /// Whether something was written in the folder `name`.
    pub(super) fn has(&self, name: &str) -> bool {
        self.sums.keys().any(|file| file.starts_with(name))
    }

    /// How many files were written.
    pub(super) fn files(&self) -> usize {
        self.sums.len()
    }

    /// Writes the checksums of the files so far but read-mes, which people complete by hand, as `sha256sum` has them, re the folder of the file `name`.
    pub(super) fn put_checksums(&mut self, name: &str) -> Result<(), BidsError> {
        let depth = name.matches('/').count();
        let is_data = |file: &str| !file.ends_with("README.md");
        let lines = (self.sums.iter())
            .filter(|(file, _)| is_data(file))
            .map(|(file, sum)| format!("{sum}  {}{file}\n", "../".repeat(depth)));
        let text: String = lines.collect();
        self.put_text(name, &text)
    }

    /// Where the file `name` (from the root, with slashes) is to be written by somebody else; its folder is made.
    ///
    /// # Errors
    /// [`BidsError::Write`].
    pub fn path(&self, name: &str) -> Result<PathBuf, BidsError> {
        // Where somebody removed what was written, nothing may be made again in its place.
        if !self.side.path().is_dir() {
            return Err(BidsError::io(&self.place)(std::io::Error::new(
                std::io::ErrorKind::NotFound,
                "expected the unfinished folder beside it, found none: another program removed it; write it again",
            )));
        }
        let path = self.side.path().join(name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(BidsError::io(folder))?;
        }
        Ok(path)
    }

    /// Puts the folder in its place. The same folder that stands there stays.
    ///
    /// # Errors
    /// [`BidsError::Exists`] where something else stands there, [`BidsError::Write`].
    pub fn commit(self) -> Result<PathBuf, BidsError> {
        if let Some(lost) = self
            .sums
            .keys()
            .find(|file| !self.side.path().join(file).is_file())
        {
            return Err(BidsError::io(&self.place.join(lost))(std::io::Error::new(
                std::io::ErrorKind::NotFound,
                "expected this file, which was written, found none: another program removed it; write it again",
            )));
        }
        if found_at(&self.place) != There::Nothing {
            self.require_same_folder()?;
            return Ok(self.place);
        }
        readable(self.side.path())?;
        std::fs::rename(self.side.path(), &self.place).map_err(BidsError::io(&self.place))?;
        // It is no longer there to be removed.
        let _moved = self.side.keep();
        sync_folder(&self.place);
        Ok(self.place)
    }
}

/// A folder that others may read, as every folder that a person's program makes.
fn readable(folder: &Path) -> Result<(), BidsError> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(folder, mode).map_err(BidsError::io(folder))?;
    }
    Ok(())
}

/// Bytes that are written, with their checksum.
struct Summed<W> {
    out: W,
    sum: Sha256,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_a_longer_name_stays_and_what_a_killed_program_left_goes() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let mut longer = NewFolder::beside(&place("bids-2")).unwrap();
        longer.put_text("a", "a").unwrap();
        let left = place(&format!("{UNFINISHED}bids-abc123"));
        std::fs::create_dir(&left).unwrap();
        let shorter = NewFolder::beside(&place("bids")).unwrap();
        assert!(!left.exists());
        assert!(matches!(
            NewFolder::beside(&place("bids")).unwrap_err(),
            BidsError::Held { .. }
        ));
        longer.commit().unwrap();
        assert!(place("bids-2/a").is_file());
        drop(shorter);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_that_somebody_removes_is_not_called_complete() {
        let folder = tempfile::tempdir().unwrap();
        let begun = || {
            let mut new = NewFolder::beside(&folder.path().join("bids")).unwrap();
            new.put_text("a", "a").unwrap();
            new
        };
        let mut removed = begun();
        std::fs::remove_dir_all(removed.side.path()).unwrap();
        assert!(removed.put_text("b", "b").is_err());
        assert!(removed.commit().is_err());
        let emptied = begun();
        std::fs::remove_file(emptied.side.path().join("a")).unwrap();
        assert!(emptied.commit().is_err());
        let mut twice = begun();
        assert!(twice.put_text("a", "b").is_err());
    }

    #[test]
    fn the_same_folder_again_is_done_and_another_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("bids");
        let written = |files: &[(&str, &str)]| {
            let mut new = NewFolder::beside(&place)?;
            for (name, text) in files {
                new.put_text(name, text)?;
            }
            // As somebody else writes it.
            let by_hand = new.path("sub/c").unwrap();
            std::fs::write(by_hand, "c").unwrap();
            new.commit()
        };
        let files = [("a", "1\n2\n"), ("sub/b", "b")];
        written(&files).unwrap();
        assert_eq!(written(&files).unwrap(), place);
        let refused = |files: &[(&str, &str)]| written(files).unwrap_err().to_string();
        let changed = refused(&[("a", "1\n3\n"), ("sub/b", "b")]);
        assert!(
            changed.contains("another a, which differs from line 2 on"),
            "{changed}"
        );
        assert!(refused(&[("a", "1\n2\n"), ("d", "")]).contains("without d"));
        assert!(refused(&[("a", "1\n2\n")]).contains("sub/b beside them"));
        std::fs::write(place.join("sub/c"), "mine").unwrap();
        assert!(refused(&files).contains("another sub/c"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
