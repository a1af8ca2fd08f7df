//! What is asked of one run.

use piezotact::Series;
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate, Seconds};

use crate::error::DeviceError;

/// What is asked of one run: who touches how, until when, and what the run is for.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// What the run is for; it stands in the recording's provenance.
    pub label: String,
    /// The normal force that the participant is asked to hold; none where the person is free to choose.
    pub load: Option<Newtons>,
    /// The angle between finger and surface.
    pub angle: Degrees,
    /// Whether the finger was lifted and placed again before this run.
    pub placement: Placement,
    /// When it is over.
    pub until: Until,
}

/// Where a resting finger lies in a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Placement {
    /// It was taken off and placed again for this run.
    #[default]
    New,
    /// It lies as in the run of this label, and was not taken off since.
    SameAs(String),
}

/// When a run is over; a stop handle ends it at any time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// When all of the drive was played, and the response has died away.
    PlaybackEnded,
    /// After this much was acquired.
    Duration(Seconds),
    /// When it is stopped, or when whoever touches something is done.
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

/// A drive that is made while it is played.
pub trait DriveSource: Send {
    /// The rate of its samples.
    fn rate(&self) -> SampleRate;
    /// The next `count` samples (full scale = 1), or fewer where it ends.
    fn next_samples(&mut self, count: usize) -> Vec<f64>;
}

/// What is played.
pub enum Playback {
    /// A signal that is there as a whole.
    Whole(Series<Drive>),
    /// A signal that is made as it goes.
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

    /// All of its samples, of one that is made as it goes as many as `until` needs: for benches that compute their answer before a
    /// run begins.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when one that is made as it goes has not ended after ten minutes.
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
                        "a drive that ends within {LONGEST_COLLECTED_S} s, as this bench computes its answer before it begins"
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
