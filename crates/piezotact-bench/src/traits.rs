//! The contract of a bench, whoever built it: two halves, one that plays and one that acquires.
//!
//! Every bench passes the same [`conformance`](crate::conformance) tests.

use piezotact::Doubt;
use piezotact::checksum::Checksum;
use piezotact::device::{DriveSetup, GainName};
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{BenchKind, Condition};
use piezotact::run::RunChunk;

use crate::error::DeviceError;
use crate::plan::{Playback, RunPlan};
use crate::stop::StopHandle;
use crate::watch::LONGEST_PAUSE;

/// The playing half of a bench, as it describes itself.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayDescription {
    /// What it is, for people.
    pub name: String,
    /// Twin, hardware, or a measured transfer function.
    pub kind: BenchKind,
    /// The rate at which it takes the drive.
    pub rate: SampleRate,
    /// The gain that is set on the amplifier; absent where nothing describes what stands behind the output.
    pub gain: Option<GainName>,
}

/// The acquiring half of a bench, as it describes itself.
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
    /// Who touches what and how; load and angle come with the run, except where the bench has them already.
    pub condition: Condition,
    /// The seed, where something is drawn.
    pub seed: Option<u64>,
    /// What it will do and how it is set, for the provenance of what it records.
    pub steps: Vec<String>,
    /// The transfer function that answers in place of a device and a finger; absent where they answer themselves.
    pub answers_with: Option<Checksum>,
}

/// What the sensors read at rest, one value a channel, in their SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorCalibration {
    /// The mean at rest.
    pub offset: Vec<f64>,
    /// The noise at rest, rms about the mean.
    pub noise_rms: Vec<f64>,
}

/// How far a playback is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlayProgress {
    /// Samples that came out.
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
    /// Measures the way from the drive to the actuator: volts at full scale, with the gain that is set. `None` where
    /// nothing describes it, and the digital full scale is the only limit that is known.
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
    /// Stops, at any time; harmless when nothing plays.
    fn stop(&mut self);
}

/// Something that acquires channels: a data acquisition system with its sensors.
pub trait Acquire: Send {
    /// What it is.
    fn describe(&self) -> AcquireDescription;
    /// What goes on while `run` is recorded: what the bench says, at the load and angle of the run, unless they are not
    /// the run's to choose.
    fn condition(&self, run: &RunPlan) -> Condition {
        Condition {
            load_n: run.load,
            angle_deg: Some(run.angle),
            ..self.describe().condition
        }
    }
    /// What a person should know of whatever is recorded in `run`, before it begins.
    fn doubts(&self, _run: &RunPlan) -> Vec<Doubt> {
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
    /// How long it may deliver no samples while it acquires; a procedure ends a run in which nothing comes for longer.
    fn longest_pause(&self) -> Seconds {
        LONGEST_PAUSE
    }
    /// Waits for the next chunk, of at most a second; `None` when the run is over or was stopped. The first sample of a
    /// chunk follows the last one of the chunk before, but for the samples that it says were lost.
    ///
    /// # Errors
    /// [`DeviceError::Order`] when nothing was started, [`DeviceError::Lost`] and [`DeviceError::InputFull`] when it fails; what
    /// came before is not lost.
    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError>;
    /// Says that all of the drive was played: acquisition goes on until the response has died away, then the run is over. One
    /// that sees by itself when its playback ends does nothing.
    fn playback_ended(&mut self) {}
    /// Stops, at any time; harmless when nothing runs.
    fn stop(&mut self);
}

/// The two halves that stand at one finger.
pub struct Bench {
    /// What plays.
    pub player: Box<dyn Play>,
    /// What acquires.
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

impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench")
            .field("player", &self.player.describe())
            .field("acquirer", &self.acquirer.describe())
            .finish_non_exhaustive()
    }
}
