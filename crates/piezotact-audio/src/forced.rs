//! A force from a source of its own beside the recorded channels of a sound device.

use crate::force::ForceError;
use std::collections::VecDeque;
use std::time::Instant;

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact_bench::DeviceError;

use crate::error::AudioError;
use crate::error::wrong;
use crate::force::{
    ForceJoiner, ForceSource, ForceUnit, GrowingFile, GrowingSettings, JoinerConfig,
    SerialForceCell, SerialSettings,
};
use crate::setup::ForceSettings;
use crate::streams::Fetched;

/// The longest time without readings that is interpolated, s.
const LONGEST_PAUSE_S: f64 = 1.0;

/// A source of force, with the recorded frames that wait for its readings.
pub(crate) struct JoinedForce {
    source: Box<dyn ForceSource>,
    rate: SampleRate,
    least_delay_s: f64,
    joiner: ForceJoiner,
    /// How many readings of this run have come.
    readings: u64,
    /// The number of the first frame of the run.
    origin: u64,
    waiting: VecDeque<Fetched>,
    force_n: VecDeque<f64>,
}

/// The source that `settings` name.
pub(crate) fn source(settings: &ForceSettings) -> Result<Box<dyn ForceSource>, AudioError> {
    let unit = match &settings.unit {
        Some(text) => Some(
            text.parse::<ForceUnit>()
                .map_err(|error| wrong(&error.to_string(), text))?,
        ),
        None => None,
    };
    match (&settings.serial, &settings.file) {
        (Some(port), _) => {
            let usual = SerialSettings::usual(port);
            Ok(Box::new(SerialForceCell::new(SerialSettings {
                baud: settings.baud.unwrap_or(usual.baud),
                unit,
                ..usual
            })))
        }
        (None, Some(file)) => Ok(Box::new(GrowingFile::new(GrowingSettings {
            unit,
            ..GrowingSettings::usual(file)
        }))),
        (None, None) => Err(wrong("a source of force", "none")),
    }
}

impl JoinedForce {
    /// The force of `source`, which is started and at least `least_delay_s` late, on the clock of streams at `rate`.
    pub(crate) fn start(
        mut source: Box<dyn ForceSource>,
        least_delay_s: f64,
        rate: SampleRate,
    ) -> Result<Self, AudioError> {
        source.start().map_err(failed)?;
        Ok(Self {
            source,
            rate,
            least_delay_s,
            joiner: joiner(rate, least_delay_s),
            readings: 0,
            origin: 0,
            waiting: VecDeque::new(),
            force_n: VecDeque::new(),
        })
    }

    /// A run begins with the frame `origin`.
    pub(crate) fn begin(&mut self, origin: u64) -> Result<(), DeviceError> {
        let _before = self.source.poll().map_err(failed)?;
        self.joiner = joiner(self.rate, self.least_delay_s);
        self.readings = 0;
        self.origin = origin;
        self.waiting.clear();
        self.force_n.clear();
        Ok(())
    }

    /// Frames up to `arrived` had come by now.
    pub(crate) fn arrived(&mut self, arrived: u64) -> Result<(), DeviceError> {
        let frames = arrived.saturating_sub(self.origin);
        self.joiner.frames(Instant::now(), frames);
        for reading in self.source.poll().map_err(failed)? {
            self.readings += 1;
            self.joiner.reading(&reading);
        }
        Ok(())
    }

    /// Keeps `fetched` until its force is known.
    pub(crate) fn wait_for(&mut self, fetched: Fetched) {
        self.waiting.push_back(fetched);
    }

    /// The oldest frames whose force is known, with it, N.
    ///
    /// # Errors
    /// [`DeviceError::Unusable`] when no reading came for too long.
    pub(crate) fn ready(&mut self) -> Result<Option<(Fetched, Vec<f64>)>, DeviceError> {
        let Some(first) = self.waiting.front() else {
            return Ok(None);
        };
        let frames = first.channels.first().map_or(0, Vec::len);
        let wanted = first.lost as usize + frames;
        if self.force_n.len() < wanted {
            let more = wanted - self.force_n.len();
            match self.joiner.next(more) {
                Ok(force_n) => self.force_n.extend(force_n),
                // Until its first reading the source itself says what is wrong with it.
                Err(ForceError::Stale { .. }) if self.readings == 0 => {}
                Err(error) => {
                    let name = self.source.describe().name;
                    return Err(DeviceError::Unusable(format!("{name}: {error}")));
                }
            }
        }
        if self.force_n.len() < wanted {
            return Ok(None);
        }
        let Some(fetched) = self.waiting.pop_front() else {
            return Ok(None);
        };
        self.force_n.drain(..fetched.lost as usize);
        let force_n = self.force_n.drain(..frames).collect();
        Ok(Some((fetched, force_n)))
    }

    /// The readings that have come since the last call, N.
    pub(crate) fn readings_n(&mut self) -> Result<Vec<f64>, DeviceError> {
        let readings = self.source.poll().map_err(failed)?;
        Ok(readings.iter().map(|reading| reading.force_n).collect())
    }

    /// What the force leaves open.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.source.warnings();
        warnings.extend(self.joiner.warnings());
        warnings
    }

    /// Where it comes from, in words.
    pub(crate) fn described(&self) -> String {
        format!("normal force of {}", self.source.describe().name)
    }
}

fn joiner(rate: SampleRate, least_delay_s: f64) -> ForceJoiner {
    ForceJoiner::new(JoinerConfig {
        rate,
        longest_pause_s: LONGEST_PAUSE_S,
        least_delay_s,
        least_frame_delay_s: 0.0,
    })
}

fn failed(error: ForceError) -> DeviceError {
    DeviceError::Unusable(error.to_string())
}
