//! The plan of one run: who touches how, until when, and what is played.

use piezotact::Series;
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate, Seconds};

use crate::error::DeviceError;

/// The plan of one run: load, angle and placement of the finger, when it ends, and its purpose.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// The purpose of the run; it is stored in the recording's provenance.
    pub label: String,
    /// The target normal force; none if the participant chooses the force freely.
    pub load: Option<Newtons>,
    /// The angle between finger and surface.
    pub angle: Degrees,
    /// Whether the finger was lifted and placed again before this run.
    pub placement: Placement,
    /// When it is over.
    pub until: Until,
}

/// The placement of a resting finger in a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Placement {
    /// The finger was lifted and placed again for this run.
    #[default]
    New,
    /// The finger has not been lifted since the run of this label.
    SameAs(String),
}

/// The end condition of a run; a stop handle ends it at any time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// When all of the drive was played, and the response has died away.
    PlaybackEnded,
    /// After this much was acquired.
    Duration(Seconds),
    /// When it is stopped, or when the participant has finished.
    Stopped,
}

impl RunPlan {
    /// The label of the run for which the finger was placed.
    #[must_use]
    pub fn placed_for(&self) -> &str {
        match &self.placement {
            Placement::New => &self.label,
            Placement::SameAs(label) => label,
        }
    }
}

/// A drive that is generated during playback.
pub trait DriveSource: Send {
    /// The rate of its samples.
    fn rate(&self) -> SampleRate;
    /// The next `count` samples (full scale = 1), or fewer where it ends.
    fn next_samples(&mut self, count: usize) -> Vec<f64>;
}

/// The signal to be played.
pub enum Playback {
    /// A complete signal.
    Whole(Series<Drive>),
    /// A signal that is generated during playback.
    Made(Box<dyn DriveSource>),
}

impl std::fmt::Debug for Playback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Whole(drive) => write!(f, "Whole({} samples)", drive.samples().len()),
            Self::Made(source) => write!(f, "Made({})", source.rate()),
        }
    }
}

/// The longest drive that is collected from a [`DriveSource`] by a bench that needs it as a whole, s.
const LONGEST_COLLECTED_S: f64 = 600.0;

impl Playback {
    /// The rate of its samples.
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        match self {
            Self::Whole(drive) => drive.rate(),
            Self::Made(source) => source.rate(),
        }
    }

    /// All samples (full scale = 1); for a generated signal as many as `until` needs. For benches that compute their response
    /// before a run begins.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when a generated signal has not ended after ten minutes.
    pub fn collected(self, until: Until) -> Result<Vec<f64>, DeviceError> {
        let mut source = match self {
            Self::Whole(drive) => return Ok(drive.samples().to_vec()),
            Self::Made(source) => source,
        };
        let rate = source.rate();
        let enough = match until {
            Until::Duration(duration) => Some(rate.samples_in(duration)),
            Until::PlaybackEnded | Until::Stopped => None,
        };
        let longest = rate.samples_in(Seconds(LONGEST_COLLECTED_S));
        let mut samples = Vec::new();
        while enough.is_none_or(|enough| samples.len() < enough) {
            if samples.len() > longest {
                return Err(DeviceError::Impossible {
                    expected: format!(
                        "a drive that ends within {LONGEST_COLLECTED_S} s, as this bench computes the response before it begins"
                    ),
                    found: "one that goes on".into(),
                    todo: "state a shorter duration".into(),
                });
            }
            let left = enough.map_or(1 << 16, |enough| enough - samples.len());
            let wanted = left.min(1 << 16);
            let new = source.next_samples(wanted);
            let ended = new.len() < wanted;
            samples.extend(new);
            if ended {
                break;
            }
        }
        Ok(samples)
    }
}
