//! What a bench can do, whoever built it.

use piezotact::checksum::Checksum;
use piezotact::device::{AmplifierGain, DriveSetup};
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate, Unit};
use piezotact::recording::{BenchKind, Condition};
use piezotact::{Doubt, Series};

/// What is asked of one run: who touches how, and what the run is for.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// What the run is for; it stands in the recording's provenance.
    pub label: String,
    /// The normal force that the participant is asked to hold; none where the person is free to choose.
    pub load: Option<Newtons>,
    /// The angle between finger and surface.
    pub angle: Degrees,
    /// Whether the finger is put down for this run.
    pub lying: Lying,
}

/// Where a resting finger lies in a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Lying {
    /// It was taken off and put down for this run.
    #[default]
    Anew,
    /// It lies as in the run of this label, and was not taken off since.
    AsIn(String),
}

impl RunPlan {
    /// The label of the run for which the finger was put down.
    #[must_use]
    pub fn put_down_for(&self) -> &str {
        match &self.lying {
            Lying::Anew => &self.label,
            Lying::AsIn(label) => label,
        }
    }
}

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
    pub gain: Option<AmplifierGain>,
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
    /// The channels' names and SI units, in the order of [`Chunk::channels`].
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

/// Samples as they come from a bench: a list for each channel, all of one length, at most a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// One list of samples a channel, in its SI unit.
    pub channels: Vec<Vec<f64>>,
}

/// What the player saw while it played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlayReport {
    /// Samples that came out, of those that went in.
    pub played: usize,
    /// Times the output ran dry.
    pub underruns: usize,
}

/// Something that plays a drive: a sound output and an amplifier.
pub trait Play {
    /// What it is.
    fn describe(&self) -> PlayDescription;
    /// Measures the way from the drive to the actuator: volts at full scale, with the gain that is set. `None` where
    /// nothing describes it, and the digital full scale is the only limit that is known.
    ///
    /// # Errors
    /// [`BenchError`] when it cannot be measured.
    fn calibrate(&mut self) -> Result<Option<DriveSetup>, BenchError>;
    /// Takes the drive (full scale = 1) and makes everything ready to start without delay.
    ///
    /// # Errors
    /// [`BenchError::Rate`] when the drive has another rate than the output.
    fn ready(&mut self, drive: &Series<Drive>, run: &RunPlan) -> Result<(), BenchError>;
    /// Starts playing and returns at once.
    ///
    /// # Errors
    /// [`BenchError::Order`] when it is not ready.
    fn start(&mut self) -> Result<(), BenchError>;
    /// Waits until the drive has been played.
    ///
    /// # Errors
    /// [`BenchError::Order`] when nothing was started.
    fn wait(&mut self) -> Result<PlayReport, BenchError>;
    /// Stops, at any time; harmless when nothing plays.
    fn stop(&mut self);
}

/// Something that acquires channels: a data acquisition system with its sensors.
pub trait Acquire {
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
    /// [`BenchError`] when they cannot be read.
    fn calibrate(&mut self) -> Result<SensorCalibration, BenchError>;
    /// Makes everything ready to start without delay.
    ///
    /// # Errors
    /// [`BenchError::Impossible`] when the run asks for what the bench cannot do.
    fn ready(&mut self, run: &RunPlan) -> Result<(), BenchError>;
    /// Starts acquiring and returns at once.
    ///
    /// # Errors
    /// [`BenchError::Order`] when it is not ready.
    fn start(&mut self) -> Result<(), BenchError>;
    /// Waits for the next chunk; `None` when the run is over.
    ///
    /// # Errors
    /// [`BenchError::Order`] when nothing was started.
    fn wait(&mut self) -> Result<Option<Chunk>, BenchError>;
    /// Stops, at any time; harmless when nothing runs.
    fn stop(&mut self);
}

/// The two halves that stand at one finger.
pub struct Bench {
    /// What plays.
    pub player: Box<dyn Play>,
    /// What acquires.
    pub acquirer: Box<dyn Acquire>,
}

impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench")
            .field("player", &self.player.describe())
            .field("acquirer", &self.acquirer.describe())
            .finish()
    }
}

/// Why a bench does not do what it is asked.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The drive has another rate than the output.
    #[error("cannot play: the drive is sampled at {drive}, the output of {name} runs at {output}; render with --rate {}", output.hz())]
    Rate {
        /// The drive's rate.
        drive: SampleRate,
        /// The output's rate.
        output: SampleRate,
        /// The bench.
        name: String,
    },
    /// The drive was made for another gain.
    #[error(
        "cannot play: the drive was rendered for gain {drive}, {name} is set to {bench}; set the amplifier to {drive}, or characterise and render at {bench}"
    )]
    Gain {
        /// The gain the drive is for.
        drive: AmplifierGain,
        /// The gain that is set.
        bench: AmplifierGain,
        /// The bench.
        name: String,
    },
    /// The output gives another potential than the drive was made for.
    #[error(
        "cannot play: the drive was rendered for {drive:.3} V at full scale, {name} now gives {bench:.3} V; set the volume back, or characterise and render again"
    )]
    OutputLevel {
        /// The potential the drive is for, V.
        drive: f64,
        /// The potential that is found, V.
        bench: f64,
        /// The bench.
        name: String,
    },
    /// What is asked for cannot be.
    #[error("expected {expected}, found {found}; {todo}")]
    Impossible {
        /// What is possible.
        expected: String,
        /// What was asked for.
        found: String,
        /// What to do.
        todo: String,
    },
    /// A step out of order.
    #[error(
        "the bench was asked to {asked} before it was {before}; this is a fault of the procedure: report it"
    )]
    Order {
        /// The step asked for.
        asked: &'static str,
        /// What should have come before.
        before: &'static str,
    },
    /// A target cannot be rendered.
    #[error(transparent)]
    Render(#[from] piezotact::render::RenderError),
    /// The first measurement of a closed loop cannot be believed.
    #[error("nothing was corrected: {0}")]
    Broken(String),
    /// A repeat did not pass the gate.
    #[error(
        "repeat {repeat} was refused in {attempts} of {attempts} attempts; the last time {breach}"
    )]
    Refused {
        /// Which repeat.
        repeat: usize,
        /// How often it was tried.
        attempts: usize,
        /// Why it was refused the last time.
        breach: crate::gate::Breach,
    },
    /// What was acquired could not be kept.
    #[error("the recording could not be kept: {0}")]
    Keep(Box<dyn std::error::Error + Send + Sync>),
    /// What was acquired makes no transfer function.
    #[error("the characterisation gave no transfer function: {0}")]
    Transfer(#[from] piezotact::transfer::TransferError),
    /// What was acquired makes no recording.
    #[error("the bench delivered no recording: {0}")]
    Recording(#[from] piezotact::recording::RecordingError),
    /// What was to be played is no signal.
    #[error("there is nothing to play: {0}")]
    Drive(#[from] piezotact::series::SeriesError),
}
