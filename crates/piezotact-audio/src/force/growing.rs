//! A text file to which another program appends forces.

use piezotact::stroke::{ForceFault, ForceWarning};
use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use piezotact::Warning;

use super::error::ForceError;
use super::lines::{First, Line, Lines};
use super::progress::Progress;
use super::protocol::{Protocol, Said, number};
use super::table::Table;
use super::unit::ForceUnit;
use super::{ForceDescription, ForceReading, ForceSource};

pub use super::table::{Columns, TimeUnit};

/// What is read of the beginning of a file to learn its columns, bytes.
const HEADER: usize = 65_536;
/// What is read in one call, bytes: more comes in the next one.
const AT_ONCE: usize = 1 << 20;
/// The beginning of a file by which it is known again, bytes.
const HEAD: usize = 64;

/// The settings of a file that grows.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowingSettings {
    pub path: PathBuf,
    /// The columns of a file with columns.
    pub columns: Columns,
    /// The unit of the lines of a file in the protocol of force cells, where no header states it.
    pub unit: Option<ForceUnit>,
    /// How long the first reading may take, and the file to exist.
    pub first_within: Duration,
    /// How long nothing may be appended.
    pub longest_pause: Duration,
}

impl GrowingSettings {
    /// The usual settings of `path`: columns and units stated by the file, 5 s to the first reading, and 1 s of silence at most.
    #[must_use]
    pub fn usual(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            columns: Columns::ByHeader,
            unit: None,
            first_within: Duration::from_secs(5),
            longest_pause: Duration::from_secs(1),
        }
    }
}

/// The readings that another program appends to a text file: columns with a header, or the lines of a force cell
/// (`docs/guide/force-cell.md`). It is followed from its end at the start; a line counts when its end is written. Readings arrive when they
/// are fetched: fetch them every 20 ms or so.
#[derive(Debug)]
pub struct GrowingFile {
    settings: GrowingSettings,
    following: Option<Following>,
}

/// How the lines of a file are read.
#[derive(Clone, Debug, PartialEq)]
enum Format {
    /// As those of a force cell.
    Protocol,
    Columns(Table),
}

#[derive(Debug)]
struct Following {
    name: String,
    columns: Columns,
    /// None before it exists.
    opened: Option<Opened>,
    lines: Lines,
    /// None before its header was read.
    format: Option<Format>,
    protocol: Protocol,
    progress: Progress,
    clock: u32,
    began_again: usize,
    failure: Option<ForceError>,
}

#[derive(Debug)]
struct Opened {
    file: File,
    device: u64,
    inode: u64,
    offset: u64,
    head: Vec<u8>,
}

impl GrowingFile {
    /// The file with these settings; nothing is opened yet.
    #[must_use]
    pub fn new(settings: GrowingSettings) -> Self {
        Self {
            settings,
            following: None,
        }
    }

    fn name(&self) -> String {
        self.settings.path.display().to_string()
    }
}

impl ForceSource for GrowingFile {
    fn describe(&self) -> ForceDescription {
        let protocol = self.following.as_ref().map(|following| &following.protocol);
        ForceDescription {
            name: self.name(),
            unit: protocol.map_or(self.settings.unit, Protocol::unit),
            nominal_rate_hz: protocol.and_then(|protocol| protocol.nominal_rate_hz),
        }
    }

    fn start(&mut self) -> Result<(), ForceError> {
        self.stop();
        let (settings, name) = (&self.settings, self.name());
        let mut following = Following {
            columns: settings.columns.clone(),
            opened: None,
            lines: Lines::new(First::Whole),
            format: None,
            protocol: Protocol::new(&name, settings.unit),
            progress: Progress::new(
                &name,
                settings.first_within,
                settings.longest_pause,
                Instant::now(),
            ),
            clock: 0,
            began_again: 0,
            failure: None,
            name,
        };
        if let Some(opened) = following.open(&settings.path)? {
            following.opened = Some(opened);
            following.go_to_end()?;
        }
        self.following = Some(following);
        Ok(())
    }

    fn poll(&mut self) -> Result<Vec<ForceReading>, ForceError> {
        let Some(following) = &mut self.following else {
            return Ok(Vec::new());
        };
        if let Some(failure) = &following.failure {
            return Err(failure.clone());
        }
        let mut readings = Vec::new();
        let fetched = following
            .fetch(&self.settings.path, &mut readings)
            .and_then(|()| following.progress.check(Instant::now()));
        following.failure = fetched.err();
        match &following.failure {
            Some(failure) if readings.is_empty() => Err(failure.clone()),
            _ => Ok(readings),
        }
    }

    fn stop(&mut self) {
        self.following = None;
    }

    fn warnings(&self) -> Vec<Warning> {
        let Some(following) = &self.following else {
            return Vec::new();
        };
        let mut warnings = following.progress.warnings();
        if following.began_again > 0 {
            warnings.push(Warning::from(ForceWarning::Doubtful {
                fault: ForceFault::BeganAgain {
                    file: following.name.clone(),
                    times: following.began_again,
                },
            }));
        }
        warnings
    }
}

impl Following {
    fn failed(&self, error: &std::io::Error) -> ForceError {
        ForceError::Open {
            name: self.name.clone(),
            reason: error.to_string(),
        }
    }

    /// The file at its beginning; none if it does not exist.
    fn open(&self, path: &Path) -> Result<Option<Opened>, ForceError> {
        // A pipe would wait for whoever writes into it.
        if std::fs::metadata(path).is_ok_and(|about| !about.is_file()) {
            return Err(ForceError::Open {
                name: self.name.clone(),
                reason: "it is not a file".into(),
            });
        }
        let file = match File::open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(|error| self.failed(&error))?,
        };
        let about = file.metadata().map_err(|error| self.failed(&error))?;
        if !about.is_file() {
            return Err(ForceError::Open {
                name: self.name.clone(),
                reason: "it is not a file".into(),
            });
        }
        Ok(Some(Opened {
            file,
            device: about.dev(),
            inode: about.ino(),
            offset: 0,
            head: Vec::new(),
        }))
    }

    /// Reads the header of a file that was there before, and goes to its end.
    fn go_to_end(&mut self) -> Result<(), ForceError> {
        let Some(mut opened) = self.opened.take() else {
            return Ok(());
        };
        let mut header = Vec::new();
        let read = (&opened.file).take(HEADER as u64).read_to_end(&mut header);
        read.map_err(|error| self.failed(&error))?;
        let mut lines = Lines::new(First::Whole);
        lines.feed(&header, |line| match (line, &self.format) {
            (Line::Whole(line), None) => self.learn(line).map(|_header| ()),
            _ => Ok(()),
        })?;
        if self.format.is_none() && header.len() < HEADER {
            // Its header is not complete: it holds no readings yet.
            self.opened = Some(opened);
            return Ok(());
        }
        let end = opened.file.seek(SeekFrom::End(0));
        opened.offset = end.map_err(|error| self.failed(&error))?;
        let mut last = [b'\n'];
        if let Some(before) = opened.offset.checked_sub(1) {
            let read = opened.file.read_at(&mut last, before);
            read.map_err(|error| self.failed(&error))?;
        }
        self.lines = Lines::new(match last {
            [b'\n' | b'\r'] => First::Whole,
            _ => First::Half,
        });
        header.truncate(HEAD);
        opened.head = header;
        self.opened = Some(opened);
        Ok(())
    }

    /// Reads what was appended.
    fn fetch(&mut self, path: &Path, readings: &mut Vec<ForceReading>) -> Result<(), ForceError> {
        let now = std::fs::metadata(path).ok();
        let Some(opened) = &self.opened else {
            self.opened = self.open(path)?;
            return match self.opened {
                Some(_) => self.read(readings),
                None => Ok(()),
            };
        };
        let replaced =
            |about: &Metadata| (about.dev(), about.ino()) != (opened.device, opened.inode);
        let replaced = now.is_some_and(|about| replaced(&about));
        if opened.began_again() {
            self.begin_again();
        }
        self.read(readings)?;
        if replaced && let Some(new) = self.open(path)? {
            self.begin_again();
            self.opened = Some(new);
            return self.read(readings);
        }
        Ok(())
    }

    /// The file begins again: its header, its lines, its clock.
    fn begin_again(&mut self) {
        self.began_again += 1;
        self.clock += 1;
        self.lines = Lines::new(First::Whole);
        self.format = None;
        self.protocol.new_clock();
        if let Some(opened) = &mut self.opened {
            opened.offset = 0;
            opened.head.clear();
        }
    }

    fn read(&mut self, readings: &mut Vec<ForceReading>) -> Result<(), ForceError> {
        let Some(opened) = &mut self.opened else {
            return Ok(());
        };
        let mut bytes = vec![0; AT_ONCE];
        let read = opened.file.read_at(&mut bytes, opened.offset);
        let at = Instant::now();
        let count = match read {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::Interrupted => 0,
            Err(error) => {
                return Err(ForceError::Vanished {
                    name: self.name.clone(),
                    reason: error.to_string(),
                    readings: self.progress.readings,
                });
            }
        };
        let bytes = &bytes[..count];
        let known = opened.head.len();
        if opened.offset == known as u64 && known < HEAD {
            let more = bytes.iter().take(HEAD - known);
            opened.head.extend(more);
        }
        opened.offset += count as u64;
        let mut lines = std::mem::replace(&mut self.lines, Lines::new(First::Whole));
        let fed = lines.feed(bytes, |line| self.line(line, at, readings));
        self.lines = lines;
        fed
    }

    fn line(
        &mut self,
        line: Line<'_>,
        at: Instant,
        readings: &mut Vec<ForceReading>,
    ) -> Result<(), ForceError> {
        let line = match line {
            Line::Whole(line) => line,
            Line::TooLong(line) => {
                self.progress.unreadable(line);
                return Ok(());
            }
        };
        if self.format.is_none() && self.learn(line)? == Learnt::Header {
            return Ok(());
        }
        let said = match &self.format {
            Some(Format::Columns(table)) => {
                let read = std::str::from_utf8(line).ok();
                let read = read.and_then(|line| table.read(line));
                read.map_or(Said::Unreadable, |(time_s, force)| {
                    self.protocol.reading(time_s, force)
                })
            }
            _ => self.protocol.line(line)?,
        };
        let (device_s, force_n) = match said {
            Said::Reading { device_s, force_n } => (device_s, force_n),
            Said::Restarted { force_n, .. } => {
                self.began_again += 1;
                self.clock += 1;
                (Some(0.0), force_n)
            }
            Said::WithoutUnit => {
                self.progress.without_unit();
                return Ok(());
            }
            Said::Header => return Ok(()),
            Said::Unreadable => {
                self.progress.unreadable(line);
                return Ok(());
            }
        };
        self.progress.reading(at);
        readings.push(ForceReading {
            at,
            device_s,
            clock: self.clock,
            force_n,
        });
        Ok(())
    }

    /// Learns from `line` how the lines of the file are read.
    fn learn(&mut self, line: &[u8]) -> Result<Learnt, ForceError> {
        let text = String::from_utf8_lossy(line);
        if text.starts_with('#') {
            self.protocol.line(line)?;
            return Ok(Learnt::Header);
        }
        let first = text.split_ascii_whitespace().next();
        if first.is_some_and(|word| word == "F" || number(word).is_some()) {
            self.format = Some(Format::Protocol);
            return Ok(Learnt::Reading);
        }
        let table = Table::of(&self.name, &text, &self.columns)?;
        self.protocol.state(table.unit)?;
        self.protocol = self.protocol.clone().endless();
        self.format = Some(Format::Columns(table));
        Ok(Learnt::Header)
    }
}

/// Whether a line from which the format was learnt is a reading too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Learnt {
    Header,
    Reading,
}

impl Opened {
    /// Whether the file became shorter, or another text stands at its beginning.
    fn began_again(&self) -> bool {
        if self
            .file
            .metadata()
            .is_ok_and(|about| about.len() < self.offset)
        {
            return true;
        }
        let mut head = vec![0; self.head.len()];
        let read = self.file.read_exact_at(&mut head, 0);
        read.is_ok() && head != self.head
    }
}
