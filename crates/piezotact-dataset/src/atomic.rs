//! Atomic file writes: a file is either completely written or not present.

use std::fs::File;
use std::io::{BufRead as _, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::error::WriteError;

/// Writes a temporary file, flushes it to the disk, and renames it to `path`: other programs see the old file
/// or the new one, never a partial one. A link is followed; anything but a regular file (a pipe, a device) is written
/// to directly.
///
/// # Errors
/// [`WriteError::Io`] when the operating system refuses, [`WriteError::Content`] when a folder stands there,
/// [`WriteError::Differs`] after [`keep_as_it_is`], and whatever `write` returns; the file at `path` is then as it was.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    Prepared::new(path, write)?.commit()
}

/// A complete file on the disk, not yet renamed to its final name.
#[derive(Debug)]
pub struct Prepared {
    /// The temporary file; `None` when it was written directly to a pipe or device.
    side: Option<Side>,
    place: PathBuf,
}

/// The temporary file, which is listed while it is there.
#[derive(Debug)]
struct Side {
    file: tempfile::NamedTempFile,
    _listed: Listed,
}

impl Prepared {
    /// What `write` makes, beside `path`: nothing stands there before it is committed.
    ///
    /// # Errors
    /// [`WriteError`] of `write`, and where nothing can be written beside `path`.
    pub fn new(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
    ) -> Result<Self, WriteError> {
        // Where a link leads to, so that it stays a link.
        let place = led_to(path);
        if place.is_dir() {
            return Err(WriteError::content(
                path,
                "the name of a file",
                "a folder",
                "give a file's name in it",
            ));
        }
        if place.exists() && !place.is_file() {
            let file = File::options()
                .write(true)
                .open(&place)
                .map_err(WriteError::io(path))?;
            fill(&file, path, write)?;
            return Ok(Self { side: None, place });
        }
        let folder = folder_of(&place);
        let mut side = tempfile::Builder::new();
        // If the program is killed, the leftover file is recognised by its name and removed by the next write.
        let prefix = unfinished(&place);
        remove_left_behind(folder, &prefix);
        remove_abandoned(folder);
        side.prefix(&prefix).suffix(".tmp");
        // A file that others may read, as every file that a person's program writes.
        #[cfg(unix)]
        side.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
        let mut written = written();
        let file = side.tempfile_in(folder).map_err(|error| WriteError::Io {
            path: path.into(),
            // The name of the file beside it is nobody's business.
            source: std::io::Error::from(error.kind()),
        })?;
        let _listed = Listed::in_list(&mut written, file.path());
        drop(written);
        let side = Side { file, _listed };
        // Locked until the file is closed, so that no other program removes it. Without file locks nothing is removed.
        let _held = side.file.as_file().try_lock();
        fill(side.file.as_file(), path, write)?;
        let flushed = side.file.as_file().sync_all();
        flushed.map_err(WriteError::io(path))?;
        if stays_as_it_is(path)
            && let Some(at) = difference(side.file.path(), &place).map_err(WriteError::io(path))?
        {
            let path = path.to_owned();
            return Err(WriteError::Differs { path, at });
        }
        Ok(Self {
            side: Some(side),
            place,
        })
    }

    /// Puts the file in its place.
    pub fn commit(self) -> Result<(), WriteError> {
        let Some(side) = self.side else { return Ok(()) };
        let mut written = written();
        side.file
            .persist(&self.place)
            .map_err(|failed| WriteError::Io {
                path: self.place.clone(),
                source: failed.error,
            })?;
        written.any = true;
        // The rename reaches the disk with the folder's next flush: until then the complete old file is there.
        Ok(())
    }
}

impl Prepared {
    /// Puts the file in its place where nothing stands yet.
    pub fn commit_new(self) -> Result<(), WriteError> {
        let Some(side) = self.side else { return Ok(()) };
        let mut written = written();
        side.file
            .persist_noclobber(&self.place)
            .map_err(|failed| WriteError::Io {
                path: self.place.clone(),
                source: failed.error,
            })?;
        written.any = true;
        Ok(())
    }
}

/// Where a file at `path` stands: where a link leads to, even to nothing.
pub(crate) fn led_to(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| match std::fs::read_link(path) {
        Ok(target) => folder_of(path).join(target),
        Err(_no_link) => path.to_owned(),
    })
}

/// Where this program writes only what stands there already.
static AS_IT_IS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Lets this program write at `path` only what stands there already: anything else is refused by [`WriteError::Differs`].
pub fn keep_as_it_is(path: &Path) {
    let mut kept = AS_IT_IS.lock().unwrap_or_else(PoisonError::into_inner);
    kept.push(led_to(path));
}

/// Whether [`keep_as_it_is`] was asked for `path`.
#[must_use]
pub fn stays_as_it_is(path: &Path) -> bool {
    let kept = AS_IT_IS.lock().unwrap_or_else(PoisonError::into_inner);
    kept.contains(&led_to(path))
}

/// Where the files `new` and `old` differ, in words; `None` where they have the same bytes. Nothing at `old` differs in nothing.
pub fn difference(new: &Path, old: &Path) -> std::io::Result<Option<String>> {
    let lengths = match std::fs::metadata(old) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        found => [std::fs::metadata(new)?.len(), found?.len()],
    };
    let mut files = [
        BufReader::new(File::open(new)?),
        BufReader::new(File::open(old)?),
    ];
    let (mut byte, mut line, mut is_text) = (1_u64, 1_u64, true);
    loop {
        let [new, old] = files.each_mut().map(BufReader::fill_buf);
        let (new, old) = (new?, old?);
        let common = new.len().min(old.len());
        let same = new
            .iter()
            .zip(old)
            .take_while(|(new, old)| new == old)
            .count();
        is_text &= !new[..same].contains(&0);
        byte += same as u64;
        line += new[..same].iter().filter(|byte| **byte == b'\n').count() as u64;
        if same < common || common == 0 {
            if common == 0 && new.len() == old.len() {
                return Ok(None);
            }
            let of = format!("({} bytes now, {} there)", lengths[0], lengths[1]);
            return Ok(Some(match is_text && !new[same..].contains(&0) {
                true => format!("from line {line} on {of}"),
                false => format!("from byte {byte} on {of}"),
            }));
        }
        files.iter_mut().for_each(|file| file.consume(common));
    }
}

/// What this program has written so far.
static WRITTEN: Mutex<Written> = Mutex::new(Written {
    unfinished: Vec::new(),
    any: false,
});

struct Written {
    /// Temporary files that are not in their place yet.
    unfinished: Vec<PathBuf>,
    /// Whether any file was put in its place.
    any: bool,
}

impl Written {
    /// Removes the unfinished files, unless files that are in their place keep the program from ending; whether it did.
    fn end(&mut self, when: EndWriting) -> bool {
        if self.any && when == EndWriting::UnlessWritten {
            return false;
        }
        for path in self.unfinished.drain(..) {
            // What stays is removed by the next command that writes there.
            let _removed = std::fs::remove_file(path);
        }
        true
    }
}

fn written() -> MutexGuard<'static, Written> {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file in the list of those that are unfinished.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn in_list(written: &mut Written, path: &Path) -> Self {
        written.unfinished.push(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        written().unfinished.retain(|path| *path != self.0);
    }
}

/// Whether files that are already in their place keep a program from ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndWriting {
    /// Not once a file of this program is in its place: what belongs to it may still be missing.
    UnlessWritten,
    /// In any case.
    Now,
}

/// Ends all writing before the program ends: its unfinished temporary files are removed, and a thread that writes waits for
/// ever. Returns whether writing was ended; if not, nothing has changed.
#[must_use]
pub fn end_writing(when: EndWriting) -> bool {
    let mut written = written();
    if !written.end(when) {
        return false;
    }
    // Never released: nothing is begun or put in its place any more.
    std::mem::forget(written);
    true
}

/// Checks that a file can be written at `path`, before there is anything to write: its name is none that the file system refuses, and
/// its folder takes files. Nothing is left behind.
///
/// # Errors
/// [`WriteError::Content`] when the name is too long, [`WriteError::Io`] when the folder takes no files.
pub fn check_place(path: &Path) -> Result<(), WriteError> {
    match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::InvalidFilename => {
            let name = path.file_name().unwrap_or_default();
            return Err(WriteError::content(
                path,
                "a name that the file system accepts",
                format!("one of {} bytes", name.len()),
                "give a shorter one",
            ));
        }
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            return Err(WriteError::io(path)(error));
        }
        _ => {}
    }
    let _removed = tempfile::tempfile_in(folder_of(path)).map_err(|error| WriteError::Io {
        path: path.into(),
        // The name of the file that was tried is nobody's business.
        source: std::io::Error::from(error.kind()),
    })?;
    Ok(())
}

/// The folder in which `path` stands.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// What the name of an unfinished file for `place` begins with: `.piezotact-unfinished-NAME-`.
fn unfinished(place: &Path) -> String {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    // File systems allow 255 bytes, and a character has up to four.
    let name: String = name.chars().take(50).collect();
    format!("{UNFINISHED}{name}-")
}

/// What the name of every unfinished file begins with.
pub const UNFINISHED: &str = ".piezotact-unfinished-";

/// Removes unfinished files for `place` left by killed programs; returns their number.
pub(crate) fn remove_unfinished_of(place: &Path) -> usize {
    remove_left_behind(folder_of(place), &unfinished(place))
}

/// Removes unfinished files left by killed programs whose names begin with `prefix` and which no program has locked; returns
/// their number.
pub fn remove_left_behind(folder: &Path, prefix: &str) -> usize {
    remove_where(folder, prefix, |_| true)
}

/// As [`remove_left_behind`], of the files that `meant` accepts.
fn remove_where(folder: &Path, prefix: &str, meant: impl Fn(&Path) -> bool) -> usize {
    let Ok(found) = std::fs::read_dir(folder) else {
        return 0;
    };
    let mut removed = 0;
    for entry in found.filter_map(Result::ok) {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(prefix)
            && name.ends_with(".tmp")
            && meant(&entry.path())
            && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
        {
            // What stays does no harm.
            removed += usize::from(std::fs::remove_file(entry.path()).is_ok());
        }
    }
    removed
}

/// A file of another name that no program has locked for this long was left by one that was killed.
const ABANDONED: Duration = Duration::from_secs(60);

/// Removes unfinished files for any name left by killed programs, once they are old: a younger one may be about to be locked.
fn remove_abandoned(folder: &Path) {
    let is_old = |path: &Path| {
        let changed = std::fs::metadata(path).and_then(|found| found.modified());
        changed.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > ABANDONED))
    };
    remove_where(folder, UNFINISHED, is_old);
}

fn fill(
    file: &File,
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let mut buffer = BufWriter::with_capacity(1 << 16, file);
    write(&mut buffer)?;
    buffer.flush().map_err(WriteError::io(path))
}

/// Brings what was created or renamed in the folder of `path` to the disk. Not every file system allows that.
pub fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(folder_of(path)) {
        let _best_effort = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_folder_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let write = |path: &Path| {
            write_atomically(path, |out| {
                out.write_all(b"new").map_err(WriteError::io(path))
            })
        };
        write(&link).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert!(link.is_symlink());
        assert!(
            write(folder.path())
                .unwrap_err()
                .to_string()
                .contains("a folder")
        );
    }

    #[test]
    fn an_unfinished_file_says_what_it_was_to_be() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("texture.wav");
        let mut beside = Vec::new();
        write_atomically(&path, |_| {
            let names = std::fs::read_dir(folder.path()).unwrap();
            beside.extend(names.map(|n| n.unwrap().file_name().to_string_lossy().into_owned()));
            Ok(())
        })
        .unwrap();
        assert!(
            beside[0].starts_with(".piezotact-unfinished-texture.wav-"),
            "{beside:?}"
        );
        let long = "ü".repeat(120);
        write_atomically(&folder.path().join(long), |_| Ok(())).unwrap();
    }

    /// What a killed program left is removed by the next write of that file; what another program is writing stays.
    #[test]
    fn what_was_left_behind_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let left = folder.path().join(".piezotact-unfinished-a.json-0.tmp");
        let held = folder.path().join(".piezotact-unfinished-a.json-1.tmp");
        let other = folder.path().join(".piezotact-unfinished-b.json-0.tmp");
        let old = folder.path().join(".piezotact-unfinished-c.json-0.tmp");
        let mine = folder.path().join(".piezotact-notes.tmp");
        for file in [&left, &held, &other, &old, &mine] {
            std::fs::write(file, "half").unwrap();
        }
        for file in [&old, &mine, &held] {
            let file = File::options().write(true).open(file).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
        }
        let running = File::open(&held).unwrap();
        running.try_lock().unwrap();
        write_atomically(&path, |_| Ok(())).unwrap();
        assert!(!left.exists() && held.exists() && other.exists() && mine.exists());
        // One of another name goes too, once it is old.
        assert!(!old.exists());
    }

    /// A program that ends removes its unfinished files; not once a file is in its place, unless it has to.
    #[test]
    fn writing_ends_without_unfinished_files() {
        let folder = tempfile::tempdir().unwrap();
        let side = folder.path().join(".piezotact-unfinished-a.json-0.tmp");
        let of = |any| {
            std::fs::write(&side, "half").unwrap();
            Written {
                unfinished: vec![side.clone()],
                any,
            }
        };
        for (any, when, ended) in [
            (false, EndWriting::UnlessWritten, true),
            (true, EndWriting::UnlessWritten, false),
            (true, EndWriting::Now, true),
        ] {
            assert_eq!(of(any).end(when), ended);
            assert_eq!(side.exists(), !ended, "{any} {when:?}");
        }
        // What is being written is in the list, and no longer once it is written.
        let path = folder.path().join("b.json");
        let listed = || {
            let ours = |side: &PathBuf| side.to_string_lossy().contains("b.json-");
            written()
                .unfinished
                .iter()
                .filter(|side| ours(side))
                .count()
        };
        write_atomically(&path, |_| {
            assert_eq!(listed(), 1);
            Ok(())
        })
        .unwrap();
        assert!(listed() == 0 && written().any);
    }

    #[test]
    fn what_stays_as_it_is_takes_the_same_again_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let old = "a,b\n1,2\n".repeat(5000);
        let write = |text: &str| {
            write_atomically(&path, |out| {
                out.write_all(text.as_bytes())
                    .map_err(WriteError::io(&path))
            })
        };
        write(&old).unwrap();
        keep_as_it_is(&path);
        write(&old).unwrap();
        let changed = format!("{}x", &old[..old.len() - 1]);
        for (new, at) in [
            (
                changed.as_str(),
                "from line 10000 on (40000 bytes now, 40000 there)",
            ),
            ("a,b\n", "from line 2 on (4 bytes now, 40000 there)"),
            (
                &format!("{old}1,2\n"),
                "from line 10001 on (40004 bytes now, 40000 there)",
            ),
            ("a\0b", "from byte 2 on (3 bytes now, 40000 there)"),
        ] {
            let refused = write(new).unwrap_err().to_string();
            assert!(refused.contains(at), "{refused}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), old);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        // What is moved away is not in the way.
        std::fs::remove_file(&path).unwrap();
        write("other").unwrap();
    }

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
