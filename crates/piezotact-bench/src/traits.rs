//! The contract that every bench keeps: two halves, one that plays and one that acquires.
//!
//! Every bench passes the same `conformance` tests.

use piezotact::Warning;
use piezotact::checksum::Checksum;
use piezotact::device::{DriveSetup, GainName};
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{BenchKind, Condition, Event};
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::{Playback, RunPlan};
use crate::stop::StopHandle;
use crate::watch::LONGEST_PAUSE;

/// The description of the playing half of a bench.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayDescription {
    /// What it is, for people.
    pub name: String,
    /// Twin, hardware, or a measured transfer function.
    pub kind: BenchKind,
    /// The rate at which it takes the drive.
    pub rate: SampleRate,
    /// The gain set on the amplifier; absent if the device at the output is not described.
    pub gain: Option<GainName>,
}

/// The description of the acquiring half of a bench.
#[derive(Clone, Debug, PartialEq)]
pub struct AcquireDescription {
    /// What it is, for people.
    pub name: String,
    /// Twin, hardware, or a measured transfer function.
    pub kind: BenchKind,
    /// The rate of its channels.
    pub rate: SampleRate,
    /// The channels' names and SI units, in the order of [`RunChunk::channels`].
    pub channels: Vec<(String, Unit)>,
    /// Who touches what and how; load and angle are those of the run, unless the bench determines them.
    pub condition: Condition,
    /// The seed, if the bench uses random numbers.
    pub seed: Option<u64>,
    /// Its operation and settings, for the provenance of its recordings.
    pub steps: Vec<String>,
    /// The checksum of the transfer function that simulates device and finger; absent for a real device and finger.
    pub answers_with: Option<Checksum>,
}

/// The calibration of the sensors at rest, one value per channel, in their SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorCalibration {
    /// The mean at rest.
    pub offset: Vec<f64>,
    /// The noise at rest, rms about the mean.
    pub noise_rms: Vec<f64>,
}

/// The progress of a playback.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlayProgress {
    /// The number of samples played.
    pub played: u64,
    /// Times the output ran dry.
    pub underruns: usize,
    /// Whether all of the drive was played, or the playback was stopped.
    pub ended: bool,
}

/// Something that plays a drive: a sound output and an amplifier.
pub trait Play: Send {
    /// What it is.
    fn describe(&self) -> PlayDescription;
    /// Measures the path from the drive to the actuator: volts at full scale with the present gain. `None` if the device is
    /// not described, so that the digital full scale is the only known limit.
    ///
    /// # Errors
    /// [`DeviceError`] when it cannot be measured.
    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError>;
    /// Takes the drive (full scale = 1) and makes everything ready to start without delay. `stop` ends the run from outside.
    ///
    /// # Errors
    /// [`DeviceError::Rate`] when the drive has another rate than the output.
    fn ready(
        &mut self,
        playback: Playback,
        run: &RunPlan,
        stop: &StopHandle,
    ) -> Result<(), DeviceError>;
    /// Starts playing and returns at once.
    ///
    /// # Errors
    /// [`DeviceError::Order`] when it is not ready.
    fn start(&mut self) -> Result<(), DeviceError>;
    /// How far it is; returns at once.
    ///
    /// # Errors
    /// [`DeviceError::Order`] when nothing was started, [`DeviceError::Lost`] when the device is gone.
    fn progress(&mut self) -> Result<PlayProgress, DeviceError>;
    /// How far it is when `acquired` of the run has passed, where that is simulated; a device is where it is.
    ///
    /// # Errors
    /// Those of [`Self::progress`].
    fn progress_after(&mut self, _acquired: Seconds) -> Result<PlayProgress, DeviceError> {
        self.progress()
    }
    /// Stops, at any time; harmless when nothing plays.
    fn stop(&mut self);
}

/// Something that acquires channels: a data acquisition system with its sensors.
pub trait Acquire: Send {
    /// What it is.
    fn describe(&self) -> AcquireDescription;
    /// The condition of `run`: that of the bench, with the load and angle of the run unless the bench determines
    /// them.
    fn condition(&self, run: &RunPlan) -> Condition {
        Condition {
            load_n: run.load,
            angle_deg: Some(run.angle),
            ..self.describe().condition
        }
    }
    /// What a person should know of whatever is recorded in `run`, before it begins.
    fn warnings(&self, _run: &RunPlan) -> Vec<Warning> {
        Vec::new()
    }
    /// What the device noticed in the run that just ended, on the clock of its samples.
    fn events(&mut self) -> Vec<Event> {
        Vec::new()
    }
    /// Reads the sensors at rest.
    ///
    /// # Errors
    /// [`DeviceError`] when they cannot be read.
    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError>;
    /// Makes everything ready to start without delay. `stop` ends the run from outside, also while [`Self::next_chunk`] waits.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when the run asks for what the bench cannot do.
    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError>;
    /// Starts acquiring and returns at once.
    ///
    /// # Errors
    /// [`DeviceError::Order`] when it is not ready.
    fn start(&mut self) -> Result<(), DeviceError>;
    /// The longest time without samples during acquisition; a procedure ends a run after a longer pause.
    fn longest_pause(&self) -> Seconds {
        LONGEST_PAUSE
    }
    /// Waits for the next chunk, of at most a second; `None` when the run is over or was stopped. The first sample of a
    /// chunk directly follows the last one of the previous chunk, except for the lost samples that it reports.
    ///
    /// # Errors
    /// [`DeviceError::Order`] when nothing was started, [`DeviceError::Lost`] and [`DeviceError::InputFull`] when it fails; what
    /// came before is not lost.
    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError>;
    /// Reports that the whole drive was played: acquisition continues until the response has decayed, then the run is over. A
    /// bench that detects the end of its playback itself does nothing.
    fn playback_ended(&mut self) {}
    /// Stops, at any time; harmless when nothing runs.
    fn stop(&mut self);
}

/// A bench: a playing and an acquiring half at one finger.
pub struct Bench {
    pub player: Box<dyn Play>,
    pub acquirer: Box<dyn Acquire>,
    /// Stops what runs, from any thread.
    pub stop: StopHandle,
}

impl Bench {
    /// A bench of two halves.
    #[must_use]
    pub fn new(player: Box<dyn Play>, acquirer: Box<dyn Acquire>) -> Self {
        Self {
            player,
            acquirer,
            stop: StopHandle::new(),
        }
    }
}

impl Bench {
    /// The acquiring half, for a run of its own on another thread. Until it is put back, every run on this bench is refused.
    #[must_use]
    pub fn take_acquirer(&mut self) -> Box<dyn Acquire> {
        let in_use = InUse(self.acquirer.describe());
        std::mem::replace(&mut self.acquirer, Box::new(in_use))
    }
}

/// An acquiring half that runs elsewhere.
struct InUse(AcquireDescription);

impl InUse {
    fn refused(&self) -> DeviceError {
        DeviceError::Impossible {
            expected: format!("the sensors of the {} at rest", self.0.name),
            found: "a run that they still acquire".into(),
            todo: "end it first".into(),
        }
    }
}

impl Acquire for InUse {
    fn describe(&self) -> AcquireDescription {
        self.0.clone()
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        Err(self.refused())
    }

    fn ready(&mut self, _run: &RunPlan, _stop: &StopHandle) -> Result<(), DeviceError> {
        Err(self.refused())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        Err(self.refused())
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        Err(self.refused())
    }

    fn stop(&mut self) {}
}

impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench")
            .field("player", &self.player.describe())
            .field("acquirer", &self.acquirer.describe())
            .finish_non_exhaustive()
    }
}
