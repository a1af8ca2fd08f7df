//! A force cell at a serial port.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use piezotact::Warning;
use serialport::ClearBuffer;

use super::error::ForceError;
use super::lines::{First, Line, Lines};
use super::progress::Progress;
use super::protocol::{Protocol, Said};
use super::unit::ForceUnit;
use super::{ForceDescription, ForceReading, ForceSource};

/// How long the thread waits for bytes before it looks whether it should stop.
const WAIT: Duration = Duration::from_millis(20);
/// Readings that wait to be fetched; the oldest go first. 80 a second fill it in 13 minutes.
const MOST_WAITING: usize = 65_536;

/// The settings of a serial port.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialSettings {
    /// The port, such as `/dev/ttyACM0`.
    pub port: String,
    /// Its rate, baud; 8 bits, no parity, 1 stop bit.
    pub baud: u32,
    /// The unit of the lines, where no header states it.
    pub unit: Option<ForceUnit>,
    /// How long the first reading may take: a microcontroller starts when its port is opened.
    pub first_within: Duration,
    /// How long it may be silent.
    pub longest_pause: Duration,
}

impl SerialSettings {
    /// The usual settings of `port`: 115 200 baud, a unit stated by the cell, 5 s to start, and 1 s of silence at most.
    #[must_use]
    pub fn usual(port: impl Into<String>) -> Self {
        Self {
            port: port.into(),
            baud: 115_200,
            unit: None,
            first_within: Duration::from_secs(5),
            longest_pause: Duration::from_secs(1),
        }
    }
}

/// A force cell that sends its readings as lines through a serial port (`docs/guide/force-cell.md`). A thread of its own reads them, so that
/// each has the time at which it arrived.
#[derive(Debug)]
pub struct SerialForceCell {
    settings: SerialSettings,
    running: Option<Running>,
}

#[derive(Debug)]
struct Running {
    shared: Arc<Mutex<Shared>>,
    stops: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    lines: Lines,
    protocol: Protocol,
    progress: Progress,
    waiting: VecDeque<ForceReading>,
    failure: Option<ForceError>,
}

impl SerialForceCell {
    /// The cell with these settings; nothing is opened yet.
    #[must_use]
    pub fn new(settings: SerialSettings) -> Self {
        Self {
            settings,
            running: None,
        }
    }

    fn shared(&self) -> Option<MutexGuard<'_, Shared>> {
        self.running.as_ref().map(|running| locked(&running.shared))
    }
}

fn locked(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ForceSource for SerialForceCell {
    fn describe(&self) -> ForceDescription {
        let shared = self.shared();
        let protocol = shared.as_ref().map(|shared| &shared.protocol);
        ForceDescription {
            name: self.settings.port.clone(),
            unit: protocol.map_or(self.settings.unit, Protocol::unit),
            nominal_rate_hz: protocol.and_then(|protocol| protocol.nominal_rate_hz),
        }
    }

    fn start(&mut self) -> Result<(), ForceError> {
        self.stop();
        let settings = &self.settings;
        let failed = |error: serialport::Error| ForceError::Open {
            name: settings.port.clone(),
            reason: error.to_string(),
        };
        let port = serialport::new(&settings.port, settings.baud)
            .timeout(WAIT)
            .open()
            .map_err(failed)?;
        port.clear(ClearBuffer::Input).map_err(failed)?;
        let shared = Arc::new(Mutex::new(Shared {
            lines: Lines::new(First::PerhapsHalf),
            protocol: Protocol::new(&settings.port, settings.unit),
            progress: Progress::new(
                &settings.port,
                settings.first_within,
                settings.longest_pause,
                Instant::now(),
            ),
            waiting: VecDeque::new(),
            failure: None,
        }));
        let stops = Arc::new(AtomicBool::new(false));
        let thread = {
            let (shared, stops) = (Arc::clone(&shared), Arc::clone(&stops));
            let name = settings.port.clone();
            std::thread::Builder::new()
                .name("force cell".into())
                .spawn(move || read_until_stopped(port, &name, &shared, &stops))
        };
        let thread = thread.map_err(|error| ForceError::Open {
            name: settings.port.clone(),
            reason: error.to_string(),
        })?;
        self.running = Some(Running {
            shared,
            stops,
            thread: Some(thread),
        });
        Ok(())
    }

    fn poll(&mut self) -> Result<Vec<ForceReading>, ForceError> {
        let Some(mut shared) = self.shared() else {
            return Ok(Vec::new());
        };
        if !shared.waiting.is_empty() {
            return Ok(shared.waiting.drain(..).collect());
        }
        if shared.failure.is_none() {
            shared.failure = shared.progress.check(Instant::now()).err();
        }
        match &shared.failure {
            Some(failure) => Err(failure.clone()),
            None => Ok(Vec::new()),
        }
    }

    fn stop(&mut self) {
        let Some(mut running) = self.running.take() else {
            return;
        };
        running.stops.store(true, Ordering::Relaxed);
        if let Some(thread) = running.thread.take() {
            // A thread that panicked has closed its port too.
            let _ended = thread.join();
        }
    }

    fn warnings(&self) -> Vec<Warning> {
        self.shared()
            .map_or_else(Vec::new, |shared| shared.progress.warnings())
    }
}

impl Drop for SerialForceCell {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Reads lines from `port` until it is stopped, or until the port or the device fails.
fn read_until_stopped(
    mut port: Box<dyn serialport::SerialPort>,
    name: &str,
    shared: &Mutex<Shared>,
    stops: &AtomicBool,
) {
    let mut bytes = [0; 4096];
    while !stops.load(Ordering::Relaxed) {
        let read = port.read(&mut bytes);
        let at = Instant::now();
        let mut shared = locked(shared);
        let failure = match read {
            Ok(0) => Some("the port was closed".to_owned()),
            Ok(count) => {
                if let Err(error) = shared.take(&bytes[..count], at) {
                    shared.failure = Some(error);
                    return;
                }
                None
            }
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => None,
                _ => Some(error.to_string()),
            },
        };
        if let Some(reason) = failure {
            shared.failure = Some(ForceError::Vanished {
                name: name.to_owned(),
                reason,
                readings: shared.progress.readings,
            });
            return;
        }
    }
}

impl Shared {
    /// What `bytes` say, which arrived at `at`.
    fn take(&mut self, bytes: &[u8], at: Instant) -> Result<(), ForceError> {
        let Self {
            lines,
            protocol,
            progress,
            waiting,
            ..
        } = self;
        lines.feed(bytes, |line| {
            let line = match line {
                Line::Whole(line) => line,
                Line::TooLong(line) => {
                    progress.unreadable(line);
                    return Ok(());
                }
            };
            match protocol.line(line)? {
                Said::Reading { device_s, force_n } => {
                    progress.reading(at);
                    if waiting.len() == MOST_WAITING {
                        waiting.pop_front();
                    }
                    waiting.push_back(ForceReading {
                        at,
                        device_s,
                        clock: 0,
                        force_n,
                    });
                }
                Said::Restarted { from_s, to_s, .. } => {
                    return Err(ForceError::Restarted {
                        name: progress.name.clone(),
                        from_s,
                        to_s,
                    });
                }
                Said::WithoutUnit => progress.without_unit(),
                Said::Header => {}
                Said::Unreadable => progress.unreadable(line),
            }
            Ok(())
        })
    }
}
